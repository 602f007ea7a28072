"""The package's engines in C as contestants of the benchmark."""

from __future__ import annotations

import math
from dataclasses import dataclass

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator
from tests.benchmarks.cases import ARM, ROD, Case

STIFF = {"E": 20.9e14}
SETUPS = {
    ROD.name: ("rod", STIFF),
    ARM.name: (
        "two-link-arm",
        STIFF | {"mu": ARM.mu, "h": -0.5 * sum(math.sin(a) for a in ARM.start[:2])},
    ),
}


@dataclass
class PackagePeer:
    """The event loop in C over generated modes, called once per impact from Python."""

    case: Case = ROD
    engine: str = "taylor"
    loosest: float = 1e-4
    tightest: float = 1e-14
    reverse_slip: bool = True

    @property
    def name(self) -> str:
        """Return the line of the table."""
        return f"painleve-sym, {'Taylor' if self.engine == 'taylor' else 'Runge-Kutta'}"

    def prepare(self) -> None:
        """Derive, generate, compile or take from the cache."""
        name, parameters = SETUPS[self.case.name]
        law_ = law("bilinear-hertz", reload="virgin")
        simulator = Simulator(model(name), law_, self.engine)
        mechanism = simulator.mechanism
        given = dict(zip(self.case.states, self.case.start, strict=True))
        start = {n: given.get(n, 0.0) for n in mechanism.state_names}
        self._engine = simulator.integrator
        begin = simulator.start(start, parameters)
        self._state, self._scale, self._parameters = begin.state, begin.scale, begin.parameters
        self._options: RunOptions | None = None
        automaton = simulator.contact.automaton
        index = {s.name: i for i, s in enumerate(automaton.states)}
        self._index = {n: index[n] for n in self.case.states if n in index}

    def run(self, tol: float) -> dict[str, float]:
        """Integrate one impact until separation."""
        if self._options is None or self._options.rtol != tol:
            atol = tol * self._scale
            self._options = RunOptions(0.01, tol, atol, ("separation",), record="end")
        raw = self._engine.run(self._state, self._parameters, self._options)
        end = raw.state.tolist()
        return {n: end[i] for n, i in self._index.items()} | {"t": raw.time}
