"""Rigid motion: the contact problem between impacts, Routh's construction at them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.run import Array, Engine, RawRun, RunOptions
from painleve_sym.errors import InputError, StopReason
from painleve_sym.hybrid.automaton import HybridAutomaton
from painleve_sym.hybrid.rigid import DECISION, RigidContact
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import Parameter
from painleve_sym.simulate.classify import contact_problem
from painleve_sym.simulate.simulator import ContactSimulator, Limit, Restart
from painleve_sym.simulate.trajectory import EventRecord, Trajectory

CLOSED = 1e-9
"""Gap and normal speed, in parts of the state's scale, at which bounces have died out."""


@dataclass(frozen=True)
class RigidSimulator(ContactSimulator):
    """A mechanism with one rigid contact, ready to run.

    In the inconsistent state the impact without collision happens. In the indeterminate state the
    policy chooses, and the event of that choice lists all solutions as `alternatives`. Bounces
    that accumulate end in contact at their limit time (event ``settle``). A slip that meets A = 0,
    where the contact force grows without bound, ends the run with StopReason.SINGULAR.

    Parameters
    ----------
    mechanism : Mechanism
        With exactly one contact.
    restitution : {"energetic", "poisson", "newton"}
    policy : {"liftoff", "slip", "impact"}
    engine : {"auto", "compiled", "erk"}
    """

    mechanism: Mechanism
    restitution: str = "energetic"
    policy: str = "liftoff"
    engine: str = "auto"

    @cached_property
    def contact(self) -> RigidContact:
        """The rigid contact."""
        return RigidContact(self.mechanism, self.restitution, self.policy)

    @property
    def automaton(self) -> HybridAutomaton:
        """The automaton that is run."""
        return self.contact.automaton

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """The coefficient of restitution."""
        return self.contact.parameters

    @property
    def label(self) -> str:
        """Name of the contact law."""
        return "rigid"

    @property
    def choices(self) -> dict[str, str]:
        """Restitution law and policy."""
        return {"restitution": self.restitution, "policy": self.policy}

    def contact_scale(self, values: Mapping[Any, float], kinetic: float) -> tuple[float, ...]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J) of the contact."""
        W_nn = float(numbers([self.mechanism.coefficients.W_nn], values)[0])
        energy = kinetic or 1.0
        return 1.0, float(np.sqrt(2 * energy * W_nn)), energy

    def run(
        self,
        state: Mapping[str, float],
        *,
        parameters: Mapping[str, float] | None = None,
        **options: Any,
    ) -> Trajectory:
        """Integrate the rigid motion from t = 0.

        Parameters
        ----------
        state, parameters, **options
            As for `SoftenedSimulator.run`; the gap must not be negative.

        Returns
        -------
        Trajectory
            Also when it stopped early: `stop_reason` says why.

        Raises
        ------
        InputError
            Unknown names, numbers out of range, a start outside the domain or inside the ground.
        """
        vector, values = self.start(state, parameters)
        vector = self.checked_start(vector, values, None)
        checked = self.options(vector, values, **options)
        raw, limits = self.execute(self.integrator, vector, self._vector_of(values), checked)
        trajectory = self.trajectory(raw, values, checked.rtol)
        return self.with_limits(trajectory, limits, values)

    def with_limits(
        self, trajectory: Trajectory, limits: Sequence[Limit], values: dict[str, float]
    ) -> Trajectory:
        """Return the trajectory with the limits of its bounces among its events."""
        events = sorted((*trajectory.events, *(x.event for x in limits)), key=lambda e: e.time)
        completed = [self._with_alternatives(e, values) for e in events]
        return replace(trajectory, events=tuple(completed))

    def checked_start(self, vector: Array, values: Mapping[str, float], force: Any) -> Array:
        """Return the start vector; InputError where it is inside the ground."""
        vector = super().checked_start(vector, values, force)
        gap = float(vector[self._index(self.contact.gap)])
        if gap < 0:
            raise InputError(
                f"{self.where}: the start is inside the ground, gap = {gap:g} m, and a rigid "
                "contact has no compression. Fix: start with gap >= 0, or give a contact law."
            )
        return vector

    def _index(self, symbol: Any) -> int:
        return self.automaton.states.index(symbol)

    # ---- bounces that accumulate ----

    def execute(
        self,
        engine: Engine,
        vector: Array,
        parameters: Array,
        options: RunOptions,
        restart: Restart | None = None,
    ) -> tuple[RawRun, list[Limit]]:
        """Run; where bounces die out, close the contact and go on. Returns the joined run."""
        runs: list[RawRun] = []
        limits: list[Limit] = []
        current, start = replace(options, start_events=True), 0.0
        memory: Array | None = None
        while True:
            raw = _shifted(engine.run(vector, parameters, current, memory), start)
            runs.append(raw)
            stuck = raw.time == start and len(runs) > 1
            over = raw.stop_reason is not StopReason.ACCUMULATION or stuck
            if over or not self._closed(raw, options):
                return _joined(runs), limits
            vector, memory = (restart or self._restart)(raw)
            limits.append(Limit(self._settle_event(raw, vector), vector, memory))
            start = raw.time
            current = replace(current, t_end=options.t_end - start)
            if not current.t_end > 0:
                return _joined(runs), limits

    @property
    def closing(self) -> tuple[int, ...]:
        """Indices of the states that a limit of bounces sets to zero: gap and its rate."""
        return self._index(self.contact.gap), self._index(self.contact.gap_rate)

    def _restart(self, raw: RawRun) -> tuple[Array, Array]:
        vector = raw.state.copy()
        vector[list(self.closing)] = 0.0
        return vector, np.zeros_like(raw.memory)

    def _closed(self, raw: RawRun, o: RunOptions) -> bool:
        gap, rate = self.closing
        scale = o.atol / o.rtol
        near = abs(raw.state[gap]) < CLOSED * scale[gap]
        return bool(near and abs(raw.state[rate]) < 1e3 * CLOSED * scale[rate])

    def _settle_event(self, raw: RawRun, vector: Array) -> EventRecord:
        names = [s.name for s in self.automaton.states]
        return EventRecord(
            time=raw.time,
            kind="settle",
            mode_before=self.automaton.modes[raw.mode].name,
            mode_after=DECISION,
            state={n: float(v) for n, v in zip(names, vector[: len(names)], strict=True)},
            normal_force=0.0,
            tangential_force=0.0,
            compression=0.0,
        )

    # ---- several solutions ----

    def _with_alternatives(self, event: EventRecord, values: dict[str, float]) -> EventRecord:
        if event.kind != "contact":
            return event
        solutions = contact_problem(self.mechanism, event.state, values).solutions()
        modes = tuple(dict.fromkeys(s.mode.value for s in solutions))
        return replace(event, alternatives=modes) if len(modes) > 1 else event


def _shifted(raw: RawRun, start: float) -> RawRun:
    if start == 0:
        return raw
    for rows in (raw.steps, raw.events):
        rows[:, 0] += start
    return replace(raw, time=raw.time + start)


def _joined(runs: list[RawRun]) -> RawRun:
    counters = {k: sum(r.counters[k] for r in runs) for k in runs[-1].counters}
    return replace(
        runs[-1],
        steps=np.vstack([r.steps for r in runs]),
        events=np.vstack([r.events for r in runs]),
        counters=counters,
    )


def simulate_rigid(
    mechanism: Mechanism,
    state: Mapping[str, float],
    *,
    restitution: str = "energetic",
    policy: str = "liftoff",
    engine: str = "auto",
    **options: Any,
) -> Trajectory:
    """Integrate a rigid motion; see `RigidSimulator.run` for the options."""
    return RigidSimulator(mechanism, restitution, policy, engine).run(state, **options)
