"""The package's engines as contestants of the benchmarks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.engines.records import EventRecords
from painleve_sym.laws.catalogue import Law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.toml.mechanism_file import load_mechanism
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.simulator import Simulator
from tests.benchmarks.cases import ARM, BELT, ROD, Case
from tests.support.paper_law import paper_law

STIFF = {"E": 20.9e14}


@dataclass(frozen=True)
class Setup:
    """Mechanism, law and end of a case in the package.

    Attributes
    ----------
    mechanism : str
        Name of a mechanism, or of a file in this folder.
    law : Law
    parameters : dict of str to float
    until : tuple of str
    t_end : float
        Later than the event of `until`, or the end of the motion; s.
    """

    mechanism: str
    law: Law
    parameters: dict[str, float]
    until: tuple[str, ...]
    t_end: float

    def simulator(self, engine: str) -> Simulator:
        """Return the simulator with an engine."""
        return Simulator(self._mechanism(), self.law, engine)

    def _mechanism(self) -> Mechanism:
        if self.mechanism.endswith(".toml"):
            return load_mechanism(Path(__file__).with_name(self.mechanism))
        return model(self.mechanism)


def _impact(mechanism: str, parameters: dict[str, float]) -> Setup:
    """Return the setup of an impact up to separation."""
    return Setup(mechanism, paper_law(reload="virgin"), parameters, ("separation",), 0.01)


SETUPS = {
    ROD.name: _impact("rod", STIFF),
    ARM.name: _impact(
        "two-link-arm",
        STIFF | {"mu": ARM.mu, "h": -0.5 * sum(math.sin(a) for a in ARM.start[:2])},
    ),
    BELT.name: Setup("shaken_belt.toml", RigidLaw(), {}, (), BELT.duration),
}

NAMES = {
    "taylor": "painleve-sym, Taylor",
    "compiled": "painleve-sym, Runge-Kutta",
    "erk": "painleve-sym, erk without compiler",
}


@dataclass
class PackagePeer:
    """The event loop over generated modes, called once per motion from Python."""

    case: Case = ROD
    engine: str = "taylor"
    loosest: float = 1e-4
    tightest: float = 1e-14
    reverse_slip: bool = True

    @property
    def name(self) -> str:
        """Return the line of the table."""
        return NAMES[self.engine]

    def prepare(self) -> None:
        """Derive, generate, compile or take from the cache."""
        self._setup = SETUPS[self.case.name]
        self.simulator = self._setup.simulator(self.engine)
        mechanism = self.simulator.mechanism
        given = dict(zip(self.case.states, self.case.start, strict=True))
        given |= {"x_dot": given.get("slip_velocity", 0.0)}
        self.start = {n: given.get(n, 0.0) for n in mechanism.state_names}
        self._engine = self.simulator.integrator
        place = self.simulator.at(self.start, self._setup.parameters)
        begin = self.simulator.start(place)
        self._state, self._scale, self._parameters = begin.state, begin.scale, begin.parameters
        self._options: RunOptions | None = None
        automaton = self.simulator.contact.automaton
        index = {s.name: i for i, s in enumerate(automaton.states)}
        self._index = {n: index[n] for n in self.case.states if n in index}

    def options(self, tol: float, record: str = "end") -> RunOptions:
        """Return the options of a run; every state's tolerance is in parts of its own scale."""
        atol, setup, simulator = tol * self._scale, self._setup, self.simulator
        begins = simulator.start_events
        return RunOptions(setup.t_end, tol, atol, setup.until, record, start_events=begins)

    def run(self, tol: float) -> dict[str, float]:
        """Integrate one motion to its end."""
        if self._options is None or self._options.rtol != tol:
            self._options = self.options(tol)
        raw = self._engine.run(self._state, self._parameters, self._options)
        end = raw.state.tolist()
        return {n: end[i] for n, i in self._index.items()} | {"t": raw.time}

    def event_times(self, tol: float) -> list[float]:
        """Return the times of the events, s; those at one instant count once."""
        raw = self._engine.run(self._state, self._parameters, self.options(tol, "events"))
        nx, nz = len(raw.state), len(raw.memory)
        times = EventRecords.of(raw.events, nx, nz).time.tolist()
        return list(dict.fromkeys(t for t in times if t > 0.0))


@dataclass
class BatchPeer:
    """A row of a batch with lanes on one thread; the first row is the case, others lie around it.

    Attributes
    ----------
    rows : int
        Rows of the batch; its time is divided by them.
    spread : float
        Standard deviation by which the coordinates that are not zero differ from row to row.
    """

    case: Case = ROD
    rows: int = 256
    spread: float = 1e-3
    loosest: float = 1e-4
    tightest: float = 1e-14
    reverse_slip: bool = True
    name: str = "painleve-sym, Taylor, row of a batch"

    def prepare(self) -> None:
        """Make the rows."""
        single = PackagePeer(self.case)
        single.prepare()
        self._simulator, self._setup = single.simulator, SETUPS[self.case.name]
        draw = np.random.default_rng(0)
        self._states: dict[str, Any] = {}
        self._parameters: dict[str, Any] = dict(self._setup.parameters)
        for name, value in single.start.items():
            change = self.spread * draw.standard_normal(self.rows)
            change[0] = 0.0
            self._states[name] = value + change if value else np.full(self.rows, value)
        if self.case is ARM:
            heights = [0.5 * np.sin(self._states[n]) for n in ARM.states[:2]]
            self._parameters["h"] = -heights[0] - heights[1]
        self.outline = single.simulator.outline.state_names

    def run(self, tol: float) -> dict[str, float]:
        """Run the whole batch; return the end of its first row."""
        setup = self._setup
        batch = run_batch(
            self._simulator,
            self._states,
            self._parameters,
            t_end=setup.t_end,
            until=setup.until,
            rtol=tol,
            threads=1,
        )
        kept = {n: float(batch[n][0]) for n in self.case.states if n in self.outline}
        return kept | {"t": float(batch["time"][0])}
