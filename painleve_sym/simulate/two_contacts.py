"""Rigid motion with two contacts: compiled modes, and a contact problem at every event."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.contacts.decision import Decider, Decision
from painleve_sym.contacts.rigid import DECISION
from painleve_sym.contacts.two_contacts import TwoContacts
from painleve_sym.engines.protocol import Answer, IntervalHistory, Question
from painleve_sym.errors import EventKind, InputError, StopReason
from painleve_sym.hybrid.automaton import HybridAutomaton
from painleve_sym.laws.rigid import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import Parameter
from painleve_sym.simulate.scales import rigid_scales
from painleve_sym.simulate.simulator import ContactSimulator
from painleve_sym.simulate.trajectory import Trajectory

_CHAIN = 64
"""Impacts at one instant before it is called an accumulation."""
_SETTLED = 1e-9
"""Gap and normal speed, in parts of the state's scale, at which bounces have died out."""
_LOOK_AHEAD = (1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Parts of the time in a mode by which a decision looks ahead where two solutions meet."""
_MEETING = (EventKind.LIFTOFF, EventKind.SLIP_START)
"""Events at which the mode left is still a solution."""


@dataclass(frozen=True)
class TwoContactSimulator(ContactSimulator):
    """A mechanism with two rigid contacts, ready to run.

    Between events both contacts keep their mode, in compiled code. At an event the contact problem
    of the closed contacts is solved with every solution (`ContactProblem`); where there are
    several the policy chooses, and the event ``contact`` lists all. Impacts follow the path of the
    impulse (`solve_simultaneous_impact`); the event ``impact`` has the impulses, and one without an
    end stops the run with ``jam``. Where no forces are possible the impact without collision
    happens.

    Parameters
    ----------
    mechanism : Mechanism
        With two contacts that can open.
    restitution : {"energetic", "poisson", "newton"}
    policy : {"liftoff", "slip", "impact"}
        Where several solutions exist: most contacts open, most stay closed, or the impact.
    engine : {"auto", "compiled", "erk"}
        Its modes have no Taylor series: ``auto`` is ``compiled``.
    """

    mechanism: Mechanism
    restitution: str = "energetic"
    policy: str = "liftoff"
    engine: str = "auto"
    start_events: ClassVar[bool] = True

    def __post_init__(self) -> None:
        RigidLaw(self.restitution, self.policy)

    @cached_property
    def contact(self) -> TwoContacts:
        """The two contacts."""
        return TwoContacts(self.mechanism, self.restitution)

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
        return RigidLaw.name

    @property
    def choices(self) -> dict[str, str]:
        """Restitution law and policy."""
        return {"restitution": self.restitution, "policy": self.policy}

    def contact_scales(
        self, i: int, values: Mapping[Any, Array], numbers: Mapping[str, Array]
    ) -> tuple[Array, ...]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a contact."""
        return rigid_scales(numbers)

    # ---- the run ----

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
            As for `SoftenedSimulator.run`; no gap may be negative.

        Returns
        -------
        Trajectory
            Also when it stopped early: `stop_reason` says why. Forces and gaps of each contact are
            the outputs ``normal_force_<contact>``, ...; where both contacts stick and the body has
            no more freedom, the forces are not determined: those of least norm are given.

        Raises
        ------
        InputError
            Unknown names, numbers out of range, a start outside the domain or inside the ground.
        """
        vector, values = self.start(state, parameters)
        self._check_gaps(vector)
        checked = self.options(vector, values, **options)
        resolver = _Resolver(self, values, checked.atol / checked.rtol)
        raw = self.integrator.run(vector, self._vector_of(values), checked, resolve=resolver)
        trajectory = self.trajectory(raw, values, checked.rtol)
        details = iter(resolver.details)
        decided = raw.event_records.transition < 0
        events = (
            replace(e, **next(details)) if mark else e
            for e, mark in zip(trajectory.events, decided, strict=True)
        )
        detail = resolver.stop_detail or trajectory.stop_detail
        return replace(trajectory, events=tuple(events), stop_detail=detail)

    def _check_gaps(self, vector: Array) -> None:
        gaps, _, _ = self.decider.contact_values(vector)
        for contact, gap in zip(self.mechanism.contacts, gaps, strict=True):
            if gap < 0:
                raise InputError(
                    f"{self.where}: contact {contact.name!r} starts inside the ground, gap = "
                    f"{gap:g} m, and a rigid contact has no compression. Fix: start with gap >= 0."
                )

    @cached_property
    def decider(self) -> Decider:
        """What the contact problem of both contacts decides."""
        return Decider(self.contact, self.policy)


@dataclass
class _Resolver:
    """Answers the questions of one run: impacts at that instant included.

    Attributes
    ----------
    simulator : TwoContactSimulator
    values : dict of str to float
        Parameters.
    scale : ndarray, shape (nx,)
        Of each state.
    touchdowns : dict of str to IntervalHistory
        Of each contact.
    details : list of dict
        Per event of the answers: what its `EventRecord` says besides.
    stop_detail : str
    jams : bool
        Whether an impact had no end.
    """

    simulator: TwoContactSimulator
    values: dict[str, float]
    scale: Array
    touchdowns: dict[str, IntervalHistory] = field(default_factory=dict)
    details: list[dict[str, Any]] = field(default_factory=list)
    stop_detail: str = ""
    jams: bool = False

    def __call__(self, question: Question) -> Answer:
        """Return what follows."""
        events: list[tuple[EventKind, Array, int]] = []
        state, stop = question.state, None
        if self._accumulates(question):
            closed = self._settled(state)
            if closed is None:
                stop = StopReason.ACCUMULATION
            else:
                state = closed
                self._note(events, EventKind.SETTLE, state)
        decision = self._decide(events, state, question)
        if decision is None:
            return Answer(
                self._index(DECISION), events[-1][1], (), tuple(events), StopReason.ACCUMULATION
            )
        if decision.mode is None:
            stop = stop or (StopReason.JAM if self.jams else StopReason.NO_MODE)
        mode = self._index(decision.mode or DECISION)
        labels = [t.label for t in self.simulator.outline.modes[mode].transitions]
        departs = tuple(labels.index(name) for name in decision.departs)
        return Answer(mode, decision.state, departs, tuple(events), stop)

    def _index(self, mode: str) -> int:
        return [m.name for m in self.simulator.outline.modes].index(mode)

    def _note(
        self,
        events: list[tuple[EventKind, Array, int]],
        kind: EventKind,
        state: Array,
        mode: str = DECISION,
        **detail: Any,
    ) -> None:
        events.append((kind, state, self._index(mode)))
        self.details.append(detail)

    def _accumulates(self, question: Question) -> bool:
        if question.kind is not EventKind.TOUCHDOWN:
            return False
        history = self.touchdowns.setdefault(question.contact, IntervalHistory())
        return history.accumulates(question.time)

    def _settled(self, state: Array) -> Array | None:
        """Return the state with the contacts closed whose bounces have died out; None for none."""
        after, closed = state.copy(), False
        states = list(self.simulator.outline.states)
        for row in self.simulator.contact.rows:
            gap, rate = states.index(row.gap), states.index(row.gap_rate)
            near = abs(after[gap]) < _SETTLED * self.scale[gap]
            if near and abs(after[rate]) < 1e3 * _SETTLED * self.scale[rate]:
                after[gap] = after[rate] = 0.0
                closed = True
        return after if closed else None

    def _decide(
        self, events: list[tuple[EventKind, Array, int]], state: Array, question: Question
    ) -> Decision | None:
        """Return the decision; None where impacts follow each other without end."""
        sim, values = self.simulator, self.values
        decider, meets = sim.decider, question.kind in _MEETING
        e = values[sim.own_parameters[0].name]
        state = decider.rested(state, values, self.scale)
        for _ in range(_CHAIN):
            gaps, rates, _ = decider.contact_values(state)
            approach = bool(np.any((gaps <= 0) & (rates < 0)))
            if not approach:
                decision = decider.decide(state, values)
                if meets:
                    decision = self._beyond(decision, state, question)
                if decision.mode != "impact":
                    self._note_contact(events, decision, gaps)
                    return decision
                if decision.alternatives:
                    self._note_contact(events, replace(decision, mode=DECISION), gaps)
            found = decider.impact(state, values, sim.restitution, e)
            if found is None:
                self.jams = True
                self.stop_detail = (
                    "the impact of the rigid contacts has no end: their friction carries any "
                    "impulse; use one contact at a time, or a softened law"
                )
                return Decision(None, state)
            impulses, state = found
            state = decider.rested(state, values, self.scale)
            meets = False
            self._note(events, EventKind.IMPACT, state, impulses=tuple(map(float, impulses)))
        return None

    def _beyond(self, first: Decision, state: Array, question: Question) -> Decision:
        """Return the decision a moment later, when the mode left is no solution any more."""
        sim, values = self.simulator, self.values
        left = sim.outline.modes[question.mode].name
        constants = sim.integrator.constants(sim._vector_of(values))
        rates = sim.integrator.field(question.mode, state, np.zeros(0), constants)
        for part in _LOOK_AHEAD:
            later = sim.decider.decide(state, values, part * question.spent * rates)
            if later.mode != left:
                return later
        return first

    def _note_contact(
        self, events: list[tuple[EventKind, Array, int]], decision: Decision, gaps: Array
    ) -> None:
        if np.any(gaps <= 0):
            mode = decision.mode or ""
            more = {"alternatives": decision.alternatives}
            self._note(events, EventKind.CONTACT, decision.state, mode, **more)
