"""Rigid motion with two contacts: compiled modes, and a contact problem at every event."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.contacts.decision import Decider, Decision
from painleve_sym.contacts.rigid import DECISION
from painleve_sym.contacts.two_contacts import TwoContacts
from painleve_sym.engines.protocol import (
    DENSE_ROWS,
    IntervalHistory,
    RawRun,
    RunOptions,
    joined_steps,
)
from painleve_sym.errors import InputError, StopReason
from painleve_sym.hybrid.automaton import HybridAutomaton
from painleve_sym.laws.rigid import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import Parameter
from painleve_sym.simulate.simulator import ContactSimulator, rigid_scales
from painleve_sym.simulate.trajectory import EventRecord, Trajectory

_CHAIN = 64
"""Impacts at one instant before it is called an accumulation."""
_SETTLED = 1e-9
"""Gap and normal speed, in parts of the state's scale, at which bounces have died out."""
_LOOK_AHEAD = (1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Parts of the time in a mode by which a decision looks ahead where two solutions meet."""
_MEETING = ("liftoff", "slip_start")
"""Events at which the mode left is still a solution."""


@dataclass
class _Run:
    """A run as it is made: pieces, events, and what they count."""

    options: RunOptions
    time: float = 0.0
    pieces: list[RawRun] = field(default_factory=list)
    events: list[EventRecord] = field(default_factory=list)
    touchdowns: dict[str, IntervalHistory] = field(default_factory=dict)
    reason: StopReason | None = None
    detail: str = ""
    hit: bool = False

    def note(self, event: EventRecord) -> None:
        """Record an event that no piece holds."""
        self.events.append(event)
        self.hit |= event.kind in self.options.until


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

    def __post_init__(self) -> None:
        RigidLaw(self.restitution, self.policy)

    @cached_property
    def contact(self) -> TwoContacts:
        """The two contacts."""
        return TwoContacts(self.mechanism, self.restitution)

    @cached_property
    def _decider(self) -> Decider:
        return Decider(self.contact, self.policy)

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

    @property
    def event_kinds(self) -> tuple[str, ...]:
        """Kinds of events that a run may be asked to end at."""
        return (*self.outline.kinds, "impact", "settle")

    def contact_scales(
        self, values: Mapping[Any, Array], found: Mapping[str, Array]
    ) -> tuple[Array, ...]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a contact."""
        return rigid_scales(found)

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
        run = _Run(self.options(vector, values, **options))
        self._follow(run, vector, values)
        trajectory = self.trajectory(_joined(run), values, run.options.rtol)
        detail = run.detail or trajectory.stop_detail
        return replace(trajectory, events=tuple(run.events), stop_detail=detail)

    def _check_gaps(self, vector: Array) -> None:
        gaps, _, _ = self._decider.contact_values(vector)
        for contact, gap in zip(self.mechanism.contacts, gaps, strict=True):
            if gap < 0:
                raise InputError(
                    f"{self.where}: contact {contact.name!r} starts inside the ground, gap = "
                    f"{gap:g} m, and a rigid contact has no compression. Fix: start with gap >= 0."
                )

    def _follow(self, run: _Run, vector: Array, values: dict[str, float]) -> None:
        parameters, o = self._vector_of(values), run.options
        scale = o.atol / o.rtol
        before, label, spent = DECISION, "", 0.0
        while True:
            decision = self._decide(run, vector, values, scale, (before, label, spent))
            mode = decision.mode or DECISION
            at = self._mode_index(mode)
            if decision.mode is None or run.reason is not None or run.hit:
                reason = run.reason or (StopReason.UNTIL if run.hit else StopReason.NO_MODE)
                run.pieces.append(_standing(run, decision.state, at, reason))
                return
            labels = [t.label for t in self.outline.modes[at].transitions]
            departs = tuple(labels.index(name) for name in decision.departs)
            options = replace(
                o,
                t_end=o.t_end - run.time,
                start_mode=at,
                start_departs=departs,
                start_events=True,
            )
            raw = self.integrator.run(decision.state, parameters, options).shifted(run.time)
            spent, run.time = raw.time - run.time, raw.time
            self._take_events(run, raw, values)
            run.pieces.append(raw)
            if raw.stop_reason is not StopReason.DECISION:
                return
            # The last row decides; the one before it says what happened.
            last = raw.events[-2]
            left = self.outline.modes[int(last[1])]
            before, label = left.name, left.transitions[int(last[2])].label
            vector = raw.state
            if run.time >= o.t_end:
                raw = raw._replace(stop_reason=StopReason.T_END)
                run.pieces[-1] = raw
                return
            if self._accumulates(run, label):
                vector = self._settled(run, vector, scale)
            if len(run.events) >= o.max_events and run.reason is None:
                run.reason = StopReason.EVENT_LIMIT

    def _mode_index(self, name: str) -> int:
        return [m.name for m in self.outline.modes].index(name)

    def _take_events(self, run: _Run, raw: RawRun, values: dict[str, float]) -> None:
        decide = self._mode_index(DECISION)
        rows = raw.events[raw.events[:, 1] != decide]
        constants = self.integrator.constants(self._vector_of(values))
        for event in self._events(rows, constants):
            run.note(event)

    def event_outputs(self, label: str) -> tuple[str, str]:
        """Return the name of the contact of an event and what its outputs' names end in."""
        name = label.partition(":")[2]
        return name, f"_{name}" if name else f"_{self.mechanism.contacts[0].name}"

    def _accumulates(self, run: _Run, label: str) -> bool:
        if not label.startswith("touchdown"):
            return False
        return run.touchdowns.setdefault(label, IntervalHistory()).accumulates(run.time)

    def _settled(self, run: _Run, vector: Array, scale: Array) -> Array:
        """Return the state with the contacts closed whose bounces have died out."""
        after = vector.copy()
        states = list(self.outline.states)
        closed = False
        for row in self.contact.rows:
            gap, rate = states.index(row.gap), states.index(row.gap_rate)
            near = abs(after[gap]) < _SETTLED * scale[gap]
            if near and abs(after[rate]) < 1e3 * _SETTLED * scale[rate]:
                after[gap] = after[rate] = 0.0
                closed = True
        if not closed:
            run.reason = StopReason.ACCUMULATION
            return vector
        run.note(self._record(run, "settle", DECISION, DECISION, after))
        return after

    def _decide(
        self,
        run: _Run,
        vector: Array,
        values: dict[str, float],
        scale: Array,
        left: tuple[str, str, float],
    ) -> Decision:
        """Return what follows, impacts at this instant included."""
        mode, label, spent = left
        decider, kind = self._decider, label.partition(":")[0]
        e = values[self.own_parameters[0].name]
        state = decider.rested(vector, values, scale)
        for _ in range(_CHAIN):
            gaps, rates, _ = decider.contact_values(state)
            approach = bool(np.any((gaps <= 0) & (rates < 0)))
            if not approach:
                decision = decider.decide(state, values)
                meets = kind.removesuffix("_neg").removesuffix("_pos") in _MEETING
                if meets and mode != DECISION:
                    decision = self._beyond(decision, state, values, mode, spent)
                if decision.mode != "impact":
                    self._note_contact(run, decision, gaps)
                    return decision
                if decision.alternatives:
                    self._note_contact(run, replace(decision, mode=DECISION), gaps)
            found = decider.impact(state, values, self.restitution, e)
            if found is None:
                run.reason = StopReason.JAM
                run.detail = (
                    "the impact of the rigid contacts has no end: their friction carries any "
                    "impulse; use one contact at a time, or a softened law"
                )
                return Decision(None, state)
            impulses, state = found
            state = decider.rested(state, values, scale)
            mode = DECISION
            event = self._record(run, "impact", DECISION, DECISION, state)
            run.note(replace(event, impulses=tuple(map(float, impulses))))
        run.reason = StopReason.ACCUMULATION
        return Decision(None, state)

    def _beyond(
        self, first: Decision, state: Array, values: dict[str, float], mode: str, spent: float
    ) -> Decision:
        """Return the decision a moment later, when the mode left is no solution any more."""
        constants = self.integrator.constants(self._vector_of(values))
        rates = self.integrator.field(self._mode_index(mode), state, np.zeros(0), constants)
        for part in _LOOK_AHEAD:
            found = self._decider.decide(state, values, part * spent * rates)
            if found.mode != mode:
                return found
        return first

    def _note_contact(self, run: _Run, decision: Decision, gaps: Array) -> None:
        if np.any(gaps <= 0):
            event = self._record(run, "contact", DECISION, decision.mode or "", decision.state)
            run.note(replace(event, alternatives=decision.alternatives))

    def _record(self, run: _Run, kind: str, before: str, after: str, state: Array) -> EventRecord:
        names = [s.name for s in self.outline.states]
        return EventRecord(
            time=run.time,
            kind=kind,
            mode_before=before,
            mode_after=after,
            state={n: float(v) for n, v in zip(names, state, strict=True)},
            normal_force=0.0,
            tangential_force=0.0,
            compression=0.0,
        )


def _standing(run: _Run, state: Array, mode: int, reason: StopReason) -> RawRun:
    """Return a piece of no length: the end of a run at an event."""
    nx = len(state)
    empty = np.empty((0, 4 + 2 * nx))
    steps = np.empty((0, 4 + DENSE_ROWS * nx))
    return RawRun(run.time, state, np.zeros(0), mode, reason, -1, steps, empty, {})


def _joined(run: _Run) -> RawRun:
    counters = Counter(dict.fromkeys(("accepted_steps", "rejected_steps"), 0))
    for piece in run.pieces:
        counters.update(piece.counters)
    counters["events"] = len(run.events)
    last = run.pieces[-1]
    return last._replace(
        steps=joined_steps(run.pieces),
        events=last.events[:0],
        counters=dict(counters),
    )
