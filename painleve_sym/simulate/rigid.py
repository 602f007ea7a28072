"""Rigid motion: the contact problem between impacts, Routh's construction at them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.codegen.run import Array, RawRun, RunOptions
from painleve_sym.errors import InputError, StopReason
from painleve_sym.hybrid.automaton import HybridAutomaton
from painleve_sym.hybrid.bilateral import BilateralContact
from painleve_sym.hybrid.rigid import DECISION, RigidContact
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import Parameter
from painleve_sym.simulate.bilateral import bilateral_problem, check_held, solution_name
from painleve_sym.simulate.classify import contact_problem
from painleve_sym.simulate.simulator import ContactSimulator
from painleve_sym.simulate.trajectory import EventRecord, Trajectory
from painleve_sym.simulate.two_contacts import TwoContactSimulator

CLOSED = 1e-9
"""Gap and normal speed, in parts of the state's scale, at which bounces have died out."""


@dataclass(frozen=True)
class RigidSimulator(ContactSimulator):
    """A mechanism with one rigid contact, ready to run.

    In the inconsistent state the impact without collision happens. In the indeterminate state the
    policy chooses, and the event of that choice lists all solutions as `alternatives`. Bounces
    that accumulate end in contact at their limit time (event ``settle``). A slip that meets A = 0,
    where the contact force grows without bound, ends the run with StopReason.SINGULAR.

    A bilateral contact keeps its gap 0: see `BilateralContact` for its modes, its tangential
    impacts and what the policies mean there. Restitution plays no part.

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
    def contact(self) -> RigidContact | BilateralContact:
        """The rigid contact, or the guide that holds it from both sides."""
        if self.mechanism.contact.bilateral:
            return BilateralContact(self.mechanism, self.policy)
        return RigidContact(self.mechanism, self.restitution, self.policy)

    @property
    def automaton(self) -> HybridAutomaton:
        """The automaton that is run."""
        return self.contact.automaton

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """The coefficient of restitution; none where the contact is bilateral."""
        return self.contact.parameters

    @property
    def label(self) -> str:
        """Name of the contact law."""
        return "rigid"

    @property
    def choices(self) -> dict[str, str]:
        """Restitution law (of a contact that can open) and policy."""
        if self.mechanism.contact.bilateral:
            return {"policy": self.policy}
        return {"restitution": self.restitution, "policy": self.policy}

    def contact_scales(
        self, values: Mapping[Any, Array], found: Mapping[str, Array]
    ) -> tuple[Array, ...]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a contact."""
        kinetic = found["kinetic_energy"]
        energy = np.where(kinetic == 0, 1.0, kinetic)
        return np.ones(len(energy)), np.sqrt(2 * energy * found["W_nn"]), energy

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
        if self.mechanism.contact.bilateral:
            check_held(self.where, gap, float(vector[self._index(self.contact.gap_rate)]))
        elif gap < 0:
            raise InputError(
                f"{self.where}: the start is inside the ground, gap = {gap:g} m, and a rigid "
                "contact has no compression. Fix: start with gap >= 0, or give a contact law."
            )

    def _index(self, symbol: Any) -> int:
        return self.outline.states.index(symbol)

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
            raw = self.integrator.run(vector, parameters, options).shifted(start)
            runs.append(raw)
            # A bilateral contact has no bounces.
            stuck = self.mechanism.contact.bilateral or (raw.time == start and len(runs) > 1)
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
        names = [s.name for s in self.outline.states]
        return EventRecord(
            time=raw.time,
            kind="settle",
            mode_before=self.outline.modes[raw.mode].name,
            mode_after=DECISION,
            state={n: float(v) for n, v in zip(names, vector, strict=True)},
            normal_force=0.0,
            tangential_force=0.0,
            compression=0.0,
        )

    def _detail(self, raw: RawRun) -> str:
        if self.mechanism.contact.bilateral and raw.stop_reason is StopReason.SINGULAR:
            return (
                "the slip meets A = 0, where the force of the guide grows without bound and rigid "
                "theory ends; end earlier, or start elsewhere"
            )
        return super()._detail(raw)

    # ---- several solutions ----

    def _with_alternatives(self, event: EventRecord, values: dict[str, float]) -> EventRecord:
        if event.kind != "contact":
            return event
        if self.mechanism.contact.bilateral:
            held = bilateral_problem(self.mechanism, event.state, values)
            modes = tuple(dict.fromkeys(solution_name(s, held) for s in held.solutions()))
        else:
            solutions = contact_problem(self.mechanism, event.state, values).solutions()
            modes = tuple(dict.fromkeys(s.mode.value for s in solutions))
        return replace(event, alternatives=modes) if len(modes) > 1 else event


def _joined(runs: list[RawRun]) -> RawRun:
    counters = {k: sum(r.counters[k] for r in runs) for k in runs[-1].counters}
    return replace(
        runs[-1],
        steps=np.vstack([r.steps for r in runs]),
        events=np.vstack([r.events for r in runs]),
        counters=counters,
    )


def rigid_simulator(
    mechanism: Mechanism,
    restitution: str = "energetic",
    policy: str = "liftoff",
    engine: str = "auto",
) -> RigidSimulator | TwoContactSimulator:
    """Return the simulator for the number of contacts: one, or two at a time."""
    kind = RigidSimulator if len(mechanism.contacts) == 1 else TwoContactSimulator
    return kind(mechanism, restitution, policy, engine)


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
    return rigid_simulator(mechanism, restitution, policy, engine).run(state, **options)
