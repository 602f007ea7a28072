"""What the items share: the rod, its softened simulators, and every run made only once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar

import sympy as sp

from painleve_sym.arrays import Array
from painleve_sym.laws.catalogue import compliant_law
from painleve_sym.mechanics.models import Mechanism, rod
from painleve_sym.simulate.compliant import DEFAULT_RTOL, SoftenedSimulator
from painleve_sym.simulate.trajectory import Trajectory

T = TypeVar("T")


@dataclass(frozen=True)
class Case:
    """A softened run of the rod.

    Attributes
    ----------
    table : int
        Table of the paper whose state it starts from; 0 for `state` alone.
    modulus : float
        E; Pa.
    t_end : float
        s.
    initial_force : float
        Surface energy as the force of the initial compression; N.
    until : str
        Kind of event that ends it; empty for none.
    reload : {"virgin", "elastic"}
    state : tuple of (str, float)
        Entries that replace those of the table.
    rtol : float
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
    """The rod with its simulators; runs are kept, so that items share them.

    Attributes
    ----------
    tables : mapping of int to mapping of str to float
        Start states by table number.
    """

    tables: Mapping[int, Mapping[str, float]]
    _simulators: dict[str, SoftenedSimulator] = field(default_factory=dict, repr=False)
    _runs: dict[Case, Trajectory] = field(default_factory=dict, repr=False)
    _shared: dict[str, Any] = field(default_factory=dict, repr=False)

    @cached_property
    def rod(self) -> Mechanism:
        """The paper's rod."""
        return rod()

    def simulator(self, reload: str = "virgin") -> SoftenedSimulator:
        """Return the rod with the paper's law under a reload rule, built on first use."""
        if reload not in self._simulators:
            contact_law = compliant_law("bilinear-hertz", reload=reload)
            self._simulators[reload] = SoftenedSimulator(self.rod, contact_law)
        return self._simulators[reload]

    def state(self, table: int) -> dict[str, float]:
        """Return the complete start state of a table."""
        return dict.fromkeys(self.rod.state_names, 0.0) | dict(self.tables.get(table, {}))

    def run(self, case: Case) -> Trajectory:
        """Return the run of a case, made on first use."""
        if case not in self._runs:
            self._runs[case] = self.simulator(case.reload).run(
                self.state(case.table) | dict(case.state),
                t_end=case.t_end,
                parameters={"E": case.modulus},
                until=case.until or (),
                initial_force=case.initial_force or None,
                rtol=case.rtol,
            )
        return self._runs[case]

    def shared(self, name: str, make: Callable[[], T]) -> T:
        """Return what `make` gave the first time it was asked for under this name."""
        if name not in self._shared:
            self._shared[name] = make()
        value: T = self._shared[name]
        return value

    @cached_property
    def sliding_force(self) -> Callable[[Array, Array], Array]:
        """−B/A of leftward sliding as a function of θ and θ̇, with the default parameters; N."""
        system, c = self.rod.system, self.rod.coefficients
        values = {p.symbol: p.default for p in system.parameters}
        names = {s.name: s for s in (*system.q, *system.q_dot)}
        arguments = [names["theta"], names["theta_dot"]]
        function: Callable[[Array, Array], Array] = sp.lambdify(
            arguments, (-c.B / c.A(-1)).subs(values), modules="numpy"
        )
        return function

    def sliding_force_along(self, trajectory: Trajectory, times: Array) -> Array:
        """Return −B/A at the states of a run, shape (len(times),); N."""
        states = trajectory(times)
        theta, omega = (trajectory.state_names.index(n) for n in ("theta", "theta_dot"))
        return self.sliding_force(states[:, theta], states[:, omega])
