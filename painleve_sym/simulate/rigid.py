"""Rigid motion: the contact problem between impacts, Routh's construction at them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from painleve_sym.arrays import Array
from painleve_sym.contacts.chatter import REVERSE_CHATTER, Chatter, chatter
from painleve_sym.contacts.classify import contact_problem, held_faults, solution_name
from painleve_sym.contacts.guide import BilateralContact
from painleve_sym.contacts.rigid import RigidContact
from painleve_sym.engines.protocol import RawRun
from painleve_sym.errors import EventKind, InputError, StopReason
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.simulate.locate_limit import locate_limit
from painleve_sym.simulate.scales import rigid_scales
from painleve_sym.simulate.simulator import ContactSimulator
from painleve_sym.simulate.singular_limit import LimitKind, ReverseChatter
from painleve_sym.simulate.trajectory import EventRecord, Trajectory

GROWING_BOUNCES = 4
"""Touchdowns in a row, each faster than the one before, that count as growth."""

_MEETINGS = {
    LimitKind.BOUNDED: "the slip runs into A = B = 0 with a bounded force (see limit); beyond it "
    "the contact can slip on, open or have an impact",
    LimitKind.LIFTOFF: "the slip meets A = B = 0 to within rounding, but its force falls to 0 "
    "before; the contact opens there",
    LimitKind.STOP: "the slip comes to A = 0 with B < 0, where the contact force presses it to a "
    "stop; start again with slip velocity 0",
}
"""What a slip that meets A = 0 without dynamic jam does there."""


@dataclass(frozen=True)
class RigidSimulator(ContactSimulator):
    """A mechanism with one rigid contact, ready to run.

    In the inconsistent state the impact without collision happens. In the indeterminate state the
    policy chooses, and the event of that choice lists all solutions as `alternatives`. Bounces
    that accumulate end in contact at their limit time (event ``settle``). A slip that runs into
    A = B = 0, where the contact force grows without bound, ends the run with
    StopReason.DYNAMIC_JAM, any other that meets A = 0 with SINGULAR; `Trajectory.limit` holds time
    and state it would arrive at. A contact at rest that can also leave in growing bounces lists
    ``reverse_chatter`` among its `alternatives`, and `Trajectory.reverse_chatter` tells of bounces
    that do grow.

    A bilateral contact keeps its gap 0: see `BilateralContact` for its modes, its tangential
    impacts and what the policies mean there. Restitution plays no part.

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

    @property
    def start_events(self) -> bool:
        """Whether what a start makes happen at once are events: an impact without collision."""
        return True

    @cached_property
    def contact(self) -> RigidContact | BilateralContact:
        """The rigid contact, or the guide that holds it from both sides."""
        if self.mechanism.contact.bilateral:
            return BilateralContact(self.mechanism, self.policy)
        return RigidContact(self.mechanism, self.restitution, self.policy)

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
        self, i: int, values: Mapping[Any, Array], numbers: Mapping[str, Array]
    ) -> tuple[Array, ...]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a contact."""
        return rigid_scales(numbers)

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
        raw = self.integrator.run(vector, self._vector_of(values), checked)
        trajectory = self.trajectory(raw, values, checked.rtol)
        if isinstance(self.contact, BilateralContact):
            return trajectory
        growth = growing_bounces(
            trajectory.events,
            self.contact.gap_rate.name,
            lambda state: self.chatter(state, values),
        )
        return _with_limit(self.contact, replace(trajectory, reverse_chatter=growth), values)

    def trajectory(self, raw: RawRun, values: dict[str, float], rtol: float) -> Trajectory:
        """Return the raw run as a trajectory; events with several solutions list them."""
        found = super().trajectory(raw, values, rtol)
        return replace(
            found, events=tuple(self._with_alternatives(e, values) for e in found.events)
        )

    def checked_start(self, vector: Array, values: Mapping[str, float], force: Any) -> Array:
        """Return the start vector; InputError where it is inside the ground."""
        vector = super().checked_start(vector, values, force)
        gap = float(vector[self._index(self.contact.gap)])
        if self.mechanism.contact.bilateral:
            rate = float(vector[self._index(self.contact.gap_rate)])
            near, slow = self.closed_within(vector, values)[0]
            for fault in held_faults("a bilateral contact", (gap, near), (rate, slow)):
                raise InputError(f"{self.where}: {fault}")
        elif gap < 0:
            raise InputError(
                f"{self.where}: the start is inside the ground, gap = {gap:g} m, and a rigid "
                "contact has no compression. Fix: start with gap >= 0, or give a contact law."
            )
        return vector

    def _index(self, symbol: Any) -> int:
        return self.outline.states.index(symbol)

    def _detail(self, raw: RawRun) -> str:
        if self.mechanism.contact.bilateral and raw.stop_reason is StopReason.SINGULAR:
            return (
                "the slip meets A = 0, where the force of the guide grows without bound and rigid "
                "theory ends; end earlier, or start elsewhere"
            )
        return super()._detail(raw)

    # ---- several solutions ----

    def chatter(self, state: Mapping[str, float], values: Mapping[str, float]) -> Chatter | None:
        """Return how small bounces near a contact at rest follow each other (see `chatter`).

        Parameters
        ----------
        state, values : mapping of str to float
            Coordinates and velocities, and all parameters.
        """
        problem = contact_problem(self.mechanism, state, values)
        return chatter(problem, self.restitution, values[self.own_parameters[0].name])

    def _with_alternatives(self, event: EventRecord, values: dict[str, float]) -> EventRecord:
        if event.kind is not EventKind.CONTACT:
            return event
        problem = contact_problem(self.mechanism, event.state, values)
        modes = tuple(dict.fromkeys(solution_name(s, problem) for s in problem.solutions()))
        opens = not problem.bilateral[0]
        if opens and modes and event.state[self.contact.slip.name] == 0:
            bounces = self.chatter(event.state, values)
            modes += (REVERSE_CHATTER,) if bounces is not None and bounces.reverse else ()
        return replace(event, alternatives=modes) if len(modes) > 1 else event


def _with_limit(contact: RigidContact, run: Trajectory, values: Mapping[str, float]) -> Trajectory:
    limit = locate_limit(contact, run, values)
    if limit is None:
        return run
    jam = limit.kind is LimitKind.DYNAMIC_JAM
    reason = StopReason.DYNAMIC_JAM if jam else run.stop_reason
    detail = reason.advice if jam else _MEETINGS[limit.kind]
    return replace(run, limit=limit, stop_reason=reason, stop_detail=detail)


def growing_bounces(
    events: Sequence[EventRecord],
    gap_rate: str,
    at_contact: Callable[[Mapping[str, float]], Chatter | None],
) -> tuple[ReverseChatter, ...]:
    """Return the stretches of bounces that grow out of contact.

    Parameters
    ----------
    events : sequence of EventRecord
    gap_rate : str
        Name of the state that holds ġ_N.
    at_contact : callable
        Tells of a state how small bounces near it follow each other. Growth where it expects none
        is not reverse chatter but a motion that falls harder (a rod that tumbles).
    """
    touchdowns = [e for e in events if e.kind is EventKind.TOUCHDOWN]
    speeds = [-e.state[gap_rate] for e in touchdowns]
    found, first = [], 0
    for i in range(1, len(touchdowns) + 1):
        if i < len(touchdowns) and speeds[i] > speeds[i - 1] > 0:
            continue
        if i - first >= GROWING_BOUNCES:
            expected = at_contact(touchdowns[first].state)
            if expected is not None and expected.reverse:
                ratio = (speeds[i - 1] / speeds[first]) ** (1 / (i - 1 - first))
                times = touchdowns[first].time, touchdowns[i - 1].time
                found.append(ReverseChatter(*times, i - first, ratio, expected.ratio))
        first = i
    return tuple(found)
