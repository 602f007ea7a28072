"""The package's compiled engine as a contestant of the Table 3 benchmark."""

from __future__ import annotations

import numpy as np

from painleve_sym.codegen.run import RunOptions
from painleve_sym.laws.compliance import law
from painleve_sym.mechanics.models import rod
from painleve_sym.simulate.compliant import SoftenedSimulator

START = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
PARAMETERS = {"E": 20.9e14}


class PackagePeer:
    """The event loop in C over generated modes, called once per impact from Python."""

    name = "painleve-sym"
    loosest = 1e-4
    tightest = 1e-14
    reverse_slip = True

    def prepare(self) -> None:
        """Derive, generate, compile or take from the cache."""
        simulator = SoftenedSimulator(rod(), law("bilinear-hertz", reload="virgin"), "compiled")
        values = simulator.parameters(PARAMETERS)
        start = dict.fromkeys(simulator.mechanism.state_names, 0.0) | START
        self._engine = simulator.integrator
        self._state = simulator.initial_state(start, values)
        self._scale = simulator.tolerances(self._state, values)
        self._options: RunOptions | None = None
        automaton = simulator.contact.automaton
        self._index = {s.name: i for i, s in enumerate(automaton.states)}
        self._parameters = np.array([values[s.name] for s in automaton.parameters])

    def run(self, tol: float) -> dict[str, float]:
        """Integrate one impact until separation."""
        if self._options is None or self._options.rtol != tol:
            self._options = RunOptions(
                0.01, tol, tol * self._scale, ("separation",), record="end"
            )
        raw = self._engine.run(self._state, self._parameters, self._options)
        names = ("x_A_dot", "y_A_dot", "theta", "theta_dot", "y_A")
        return {n: float(raw.state[self._index[n]]) for n in names} | {"t": raw.time}
