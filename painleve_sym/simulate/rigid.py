"""Rigid motion: the contact problem between impacts, Routh's construction at them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.run import Array, RawRun, RunOptions
from painleve_sym.errors import InputError, StopReason
from painleve_sym.hybrid.automaton import HybridAutomaton
from painleve_sym.hybrid.rigid import DECISION, RigidContact
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import Parameter
from painleve_sym.simulate.classify import contact_problem
from painleve_sym.simulate.simulator import ContactSimulator
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
    engine : {"auto", "compiled", "taylor", "erk"}
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
        self._check_gap(vector)
        checked = self.options(vector, values, **options)
        raw, limits = self._run_through_bounces(vector, values, checked)
        trajectory = self.trajectory(raw, values, checked.rtol)
        events = sorted((*trajectory.events, *limits), key=lambda e: e.time)
        events = [self._with_alternatives(e, values) for e in events]
        return replace(trajectory, events=tuple(events))

    def _check_gap(self, vector: Array) -> None:
        gap = float(vector[self._index(self.contact.gap)])
        if gap < 0:
            raise InputError(
                f"{self.where}: the start is inside the ground, gap = {gap:g} m, and a rigid "
                "contact has no compression. Fix: start with gap >= 0, or give a contact law."
            )

    def _index(self, symbol: Any) -> int:
        return self.automaton.states.index(symbol)

    # ---- bounces that accumulate ----

    def _run_through_bounces(
        self, vector: Array, values: dict[str, float], o: RunOptions
    ) -> tuple[RawRun, list[EventRecord]]:
        """Run; where bounces die out, close the contact and go on. Returns the joined run."""
        parameters = self._vector_of(values)
        runs: list[RawRun] = []
        limits: list[EventRecord] = []
        options, start = replace(o, start_events=True), 0.0
        while True:
            raw = _shifted(self.integrator.run(vector, parameters, options), start)
            runs.append(raw)
            stuck = raw.time == start and len(runs) > 1
            if raw.stop_reason is not StopReason.ACCUMULATION or stuck or not self._closed(raw, o):
                return _joined(runs), limits
            vector = raw.state.copy()
            vector[self._index(self.contact.gap)] = 0.0
            vector[self._index(self.contact.gap_rate)] = 0.0
            limits.append(self._settle_event(raw, vector))
            start = raw.time
            options = replace(options, t_end=o.t_end - start)
            if not options.t_end > 0:
                return _joined(runs), limits

    def _closed(self, raw: RawRun, o: RunOptions) -> bool:
        gap, rate = (self._index(s) for s in (self.contact.gap, self.contact.gap_rate))
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
            state={n: float(v) for n, v in zip(names, vector, strict=True)},
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
    return raw._replace(time=raw.time + start)


def _joined(runs: list[RawRun]) -> RawRun:
    counters = {k: sum(r.counters[k] for r in runs) for k in runs[-1].counters}
    return runs[-1]._replace(
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
