"""The runs behind the figures and statements; the balance of energy is taken over all.

Where the paper does not print an input (the moduli of Figs. 9 and 14, the speeds of Fig. 10), the
values here are chosen to show its statements.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import sympy as sp

from painleve_sym.arrays import Array
from painleve_sym.at.cases import classify_at
from painleve_sym.at.classification import Classification
from painleve_sym.engines.protocol import DEFAULT_RTOL
from painleve_sym.laws.catalogue import compliant_law
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.motion.records import EventRecord
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.papers.impact_resolution.claims import (
    EXPONENT,
    INITIAL_FORCES,
    SOFT,
    STIFF,
    STIFFER,
    TABLES,
)
from painleve_sym.papers.panels import (
    ANGULAR_VELOCITY,
    FORCE_KN,
    HEIGHT,
    NORMAL_VELOCITY,
    SLIP_VELOCITY,
    TIME_MS,
    Axis,
    Mark,
    Panel,
    events_as_marks,
    line,
    window,
)

T = TypeVar("T")


@dataclass(frozen=True)
class RunCase:
    """A compliant run of the rod from the state of a table, with entries that replace those of it.

    `modulus` is E, Pa; `initial_force` the surface energy as the force of the initial compression,
    N; `until` the kind of event that ends it, or empty.
    """

    table: int
    modulus: float
    t_end: float
    initial_force: float = 0.0
    until: str = ""
    reload: str = "virgin"
    state: tuple[tuple[str, float], ...] = ()
    rtol: float = DEFAULT_RTOL


@dataclass(frozen=True)
class Workbench:
    """The rod with its simulators; runs are kept, so that items share them."""

    _shared: dict[Hashable, Any] = field(default_factory=dict, repr=False)

    @cached_property
    def rod(self) -> Mechanism:
        """The paper's rod."""
        return rod()

    def simulator(self, reload: str = "virgin", exponent: float = EXPONENT) -> Simulator:
        """Return the rod with the paper's law under a reload rule, built on first use.

        The `exponent` of real materials is Hertz's.
        """
        return self.shared(
            ("simulator", reload, exponent),
            lambda: Simulator(
                self.rod, compliant_law("bilinear-hertz", reload=reload).with_parameters(n=exponent)
            ),
        )

    def state(self, table: int) -> dict[str, float]:
        """Return the complete start state of a table."""
        return dict.fromkeys(self.rod.state_names, 0.0) | dict(TABLES[table].state)

    def rigid(self, table: int) -> Classification:
        """Return the rigid contact problem at the state of a table."""
        return self.shared(f"rigid {table}", lambda: classify_at(self.rod.at(self.state(table))))

    def run(self, case: RunCase) -> Trajectory:
        """Return the run of a case, made on first use."""
        return self.shared(
            case,
            lambda: self.simulator(case.reload).run(
                self.state(case.table) | dict(case.state),
                t_end=case.t_end,
                parameters={"E": case.modulus},
                until=case.until or (),
                initial_force=case.initial_force or None,
                rtol=case.rtol,
            ),
        )

    def shared(self, name: Hashable, make: Callable[[], T]) -> T:
        """Return the value that `make` returns, computed only once under this name."""
        if name not in self._shared:
            self._shared[name] = make()
        value: T = self._shared[name]
        return value

    def evaluated(self, expr: sp.Expr, run: Trajectory, state: Mapping[str, float]) -> float:
        """Return the number of an expression in the rod's symbols, with the run's parameters."""
        system = self.rod.system
        values = {p.symbol: run.parameters[p.name] for p in system.parameters}
        values |= {s: state[s.name] for s in (*system.q, *system.q_dot)}
        return float(expr.subs(values))

    @cached_property
    def sliding_force(self) -> Callable[[Array, Array], Array]:
        """−B/A of leftward sliding as a function of θ and θ̇, with the default parameters; N."""
        system, c = self.rod.system, self.rod.coefficients
        names = {s.name: s for s in (*system.q, *system.q_dot)}
        arguments = [names["theta"], names["theta_dot"]]
        function: Callable[[Array, Array], Array] = sp.lambdify(
            arguments, (-c.B / c.A(-1)).subs(system.defaults), modules="numpy"
        )
        return function

    def sliding_force_along(self, trajectory: Trajectory, times: Array) -> Array:
        """Return −B/A at the states of a run, shape (len(times),); N."""
        states = trajectory(times)
        theta, omega = (trajectory.state_names.index(n) for n in ("theta", "theta_dot"))
        return self.sliding_force(states[:, theta], states[:, omega])


MODULI = tuple(float(f"20.9e{p}") for p in range(10, 19))
"""Moduli of the convergence study, 20.9e10 … 20.9e18; Pa."""

LONG = 1.0
"""End time of runs that an event ends; s. No impact here lasts a twentieth of it."""

SLIDING = {SOFT: RunCase(1, SOFT, 0.018), STIFF: RunCase(1, STIFF, 1.6e-3)}
"""Fig. 4; long enough for the forces that the paper reads off."""
SLIDING_ELASTIC = {E: replace(case, reload="elastic") for E, case in SLIDING.items()}
SLIDING_LOADED = RunCase(1, SOFT, 0.018, initial_force=3.0)
"""§3.1: a small initial surface energy."""
JUMP_UP = RunCase(2, SOFT, 0.1)
"""Fig. 6."""
IMPACT = RunCase(3, STIFF, 5e-4)
"""Fig. 8."""

STIFFNESSES = tuple(float(f"20.9e{p}") for p in (13, 14, 15, 16))
HARDER_IMPACTS = {E: RunCase(3, E, LONG, until="separation") for E in STIFFNESSES}
"""Fig. 9."""
SPEEDS = (-0.5, -1.0, -1.5, -2.0)
SPEED_FORCE = 100.0
OTHER_SPEEDS = {
    v: RunCase(3, STIFF, LONG, until="separation", state=(("x_A_dot", v),)) for v in SPEEDS
}
"""Fig. 10."""
LOADED_SPEED = RunCase(3, STIFF, LONG, until="separation", initial_force=SPEED_FORCE)

NEAR_BORDER = 3.40
"""θ̇ just below the border of the inconsistent field at θ = 1, 3.4127 rad/s."""
BORDER = {
    E: RunCase(3, E, LONG, until="separation", state=(("theta_dot", NEAR_BORDER),))
    for E in (SOFT, STIFF)
}

JUMP_UPS = {
    F: RunCase(4, STIFF, 1e-3, initial_force=F)
    for F in (0.0, *(f.force.value for f in INITIAL_FORCES if f.table == 5))
}
"""Fig. 12."""
LOADED_IMPACTS = {
    f.force.value: RunCase(4, STIFFER, 3e-4, initial_force=f.force.value)
    for f in INITIAL_FORCES
    if f.table == 6
}
"""Fig. 13."""
FIXED_FORCE = 500.0
LOADED_STIFFNESSES = tuple(float(f"20.9e{p}") for p in (14, 15, 16))
LOADED_HARDER = {
    E: RunCase(4, E, LONG, until="separation", initial_force=FIXED_FORCE)
    for E in LOADED_STIFFNESSES
}
"""Fig. 14."""


def modulus_label(modulus: float) -> str:
    """Return E = 20.9 × 10ᵖ Pa as mathtext."""
    power = round(math.log10(modulus / 20.9))
    return rf"$E=20.9\times10^{{{power}}}$ Pa"


def modulus_text(modulus: float) -> str:
    """Return the text of a modulus, such as 20.9e14."""
    return f"20.9e{round(math.log10(modulus / 20.9))}"


def first(run: Trajectory, kind: str) -> EventRecord | None:
    """Return the first event of a kind, or None."""
    return next(iter(run.events_of(kind)), None)


def needed(run: Trajectory, kind: str) -> EventRecord:
    """Return the first event of a kind; LookupError where the run has none."""
    event = first(run, kind)
    if event is None:
        kinds = [e.kind for e in run.events]
        raise LookupError(f"run of {run.mechanism!r}: no event {kind!r} among {kinds}")
    return event


AXES = {
    "x_A_dot": SLIP_VELOCITY,
    "y_A": HEIGHT,
    "y_A_dot": NORMAL_VELOCITY,
    "theta_dot": ANGULAR_VELOCITY,
    "normal_force": FORCE_KN,
}
"""What is drawn over time, with the axis of each."""


def history(
    bench: Workbench,
    cases: Iterable[tuple[str, RunCase]],
    name: str,
    end: float,
    kinds: tuple[str, ...] = (),
    title: str = "",
    axes: Mapping[str, Axis] = AXES,
) -> Panel:
    """Return one state or output over time, up to `end` in s, for several runs with their labels.

    Events of the given kinds are marked.
    """
    curves, marks = [], list[Mark]()
    for label, case in cases:
        run = bench.run(case)
        times = window(run, 0.0, end)
        curves.append(line(label, times, run.values(name, times)))
        marks += events_as_marks(run, name, end, kinds)
    x = TIME_MS.within(0.0, TIME_MS.factor * end)
    return Panel(x, axes[name], tuple(curves), tuple(marks), title)
