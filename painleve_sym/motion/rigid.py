"""Details of the motion of rigid contacts besides its events.

All solutions of a contact problem or an impact that has several, and growing bounces.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from painleve_sym.at.cases import contact_problem
from painleve_sym.at.classification import solution_name
from painleve_sym.at.delassus import Delassus
from painleve_sym.automata.model import ContactModel
from painleve_sym.choices import ImpactFriction
from painleve_sym.errors import EventKind, InputError
from painleve_sym.motion.records import EventRecord
from painleve_sym.motion.singular_limit import ReverseChatter
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.impact.chatter import REVERSE_CHATTER, Chatter, chatter
from painleve_sym.problem.law import EQUAL
from painleve_sym.problem.solution import ContactSolution

if TYPE_CHECKING:
    from painleve_sym.motion.mechanism_with_laws import MechanismWithLaws

GROWING_BOUNCES = 4
"""Touchdowns in a row, each faster than the one before, that count as growth."""


def chatter_at(
    contact: ContactModel, state: Mapping[str, float], values: Mapping[str, float]
) -> Chatter | None:
    """Return how small bounces near a contact at rest follow each other (see `chatter`)."""
    problem = contact_problem(contact.mechanism, state, values)
    return chatter(problem, contact.rigid_law.restitution, values[contact.parameters[0].name])


def alternatives(
    simulator: MechanismWithLaws, state: Mapping[str, float], values: Mapping[str, float]
) -> tuple[str, ...]:
    """Return the names of all solutions of the contact problem after an event; none for one."""
    several = simulator.contact.several
    return (_of_several if several else _of_one)(simulator, state, values)


def _of_one(
    simulator: MechanismWithLaws, state: Mapping[str, float], values: Mapping[str, float]
) -> tuple[str, ...]:
    contact = simulator.contact
    try:
        problem = contact_problem(simulator.mechanism, state, values)
    except InputError:  # a mobility that overflows has none; the run ends there (`non_finite`)
        return ()
    modes = tuple(dict.fromkeys(solution_name(s, problem) for s in problem.solutions()))
    if contact.parameters and modes and state[contact.rows[0].slip] == 0:
        bounces = chatter_at(contact, state, values)
        modes += (REVERSE_CHATTER,) if bounces is not None and bounces.reverse else ()
    return modes if len(modes) > 1 else ()


def _of_several(
    simulator: MechanismWithLaws, state: Mapping[str, float], values: Mapping[str, float]
) -> tuple[str, ...]:
    gaps, rates, slips = np.array([[state[n] for n in r] for r in simulator.contact.rows]).T
    closed = [i for i in simulator.rigid if gaps[i] <= 0 and rates[i] == 0]
    if len(simulator.rigid) < len(gaps) or not closed:
        return ()
    mechanism = simulator.mechanism
    at = Delassus.of(mechanism).at({**state, **values}).of_contacts(closed)
    bilateral = np.array(mechanism.outline.bilateral)[closed]
    problem = ContactProblem(at.W, at.b, at.mu, slips[closed], bilateral)
    solutions = problem.solutions()
    if len(solutions) < 2:
        return ()
    several = (*_names(solutions, closed, len(gaps)), "impact")
    return several if len(several) > 2 else ()


def _names(
    solutions: Sequence[ContactSolution], closed: Sequence[int], contacts: int
) -> tuple[str, ...]:
    """Return the names of the motions of all contacts, each once."""
    names = []
    for solution in solutions:
        modes = ["flight"] * contacts
        for i, mode in zip(closed, solution.modes, strict=True):
            modes[i] = "flight" if mode.value == "liftoff" else mode.value
        names.append(" + ".join(modes))
    return tuple(dict.fromkeys(names))


def final_slips(
    simulator: MechanismWithLaws, before: Mapping[str, float], values: Mapping[str, float]
) -> tuple[str, ...]:
    """Return what several contacts may do after an impact by the final slip; none for one answer.

    One contact has one answer (`FinalSlip`).
    """
    contact = simulator.contact
    if contact.rigid_law.impact_friction is not ImpactFriction.FINAL_SLIP:
        return ()
    gaps, rates, slips = np.array([[before[n] for n in r] for r in contact.rows]).T
    closed = [i for i in simulator.rigid if gaps[i] <= 0 and rates[i] <= 0]
    of = [contact.own_laws[i].parameters for i in closed]
    e = np.array([values[own[0].name] if own else 0.0 for own in of])
    mechanism = simulator.mechanism
    at = Delassus.of(mechanism).at({**before, **values}).of_contacts(closed)
    b = np.ravel([(1 + e) * rates[closed], slips[closed]], order="F")
    bilateral = np.array(mechanism.outline.bilateral)[closed]
    solutions = ContactProblem(at.W, b, at.mu, np.zeros(len(closed)), bilateral).solutions()
    if not np.any(rates[closed] < 0):
        least = EQUAL * np.max(np.abs(b), initial=0.0)
        solutions = tuple(s for s in solutions if np.any(np.abs(s.accelerations - b) > least))
    open_ = len(solutions) > 1 or any(s.moves for s in solutions)
    return _names(solutions, closed, len(gaps)) if open_ else ()


def final_slip_notices(events: Sequence[EventRecord]) -> tuple[str, ...]:
    """Return a sentence where impacts have several answers by the final slip."""
    open_ = [e for e in events if e.kind is EventKind.IMPACT and e.alternatives]
    if not open_:
        return ()
    first, more = open_[0], f" So it is in {len(open_)} impacts." * (len(open_) > 1)
    return (
        f"At t = {first.time:.9g} s the impact has several final slips "
        f"({', '.join(first.alternatives)}), of which that of the least normal impulse is "
        f"taken.{more}",
    )


def growing_bounces(
    events: Sequence[EventRecord],
    gap_rate: str,
    at_contact: Callable[[Mapping[str, float]], Chatter | None],
) -> tuple[ReverseChatter, ...]:
    """Return the stretches of bounces that grow out of contact.

    `gap_rate` is the name of the state that holds ġ_N. `at_contact` tells of a state how small
    bounces near it follow each other: growth where it expects none is not reverse chatter but a
    motion that falls harder (a rod that tumbles).
    """
    touchdowns = [e for e in events if e.kind is EventKind.TOUCHDOWN]
    speeds = [-e.state[gap_rate] for e in touchdowns]
    chatters, first = [], 0
    for i in range(1, len(touchdowns) + 1):
        if i < len(touchdowns) and speeds[i] > speeds[i - 1] > 0:
            continue
        if i - first >= GROWING_BOUNCES:
            expected = at_contact(touchdowns[first].state)
            if expected is not None and expected.reverse:
                ratio = (speeds[i - 1] / speeds[first]) ** (1 / (i - 1 - first))
                times = touchdowns[first].time, touchdowns[i - 1].time
                chatters.append(ReverseChatter(*times, i - first, ratio, expected.ratio))
        first = i
    return tuple(chatters)
