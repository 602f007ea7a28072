"""The rigid contact problem of a mechanism at a state: coefficients, case, every solution."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence

import numpy as np

from painleve_sym.at.classification import Classification, classification
from painleve_sym.at.closing import closing_hint
from painleve_sym.at.delassus import ContactNumbers, Delassus
from painleve_sym.at.inputs import border_notices, place_of, refuse_infinite, refuse_place
from painleve_sym.checks import LARGEST, StateLike
from painleve_sym.codegen.named_mechanisms import MechanismLike
from painleve_sym.errors import InputError, PainleveWarning
from painleve_sym.laws.friction import friction_notice
from painleve_sym.mechanics.mechanism import Mechanism, Place
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.units import Value


def contact_problem(
    mechanism: Mechanism, state: Mapping[str, float], parameters: Mapping[str, float]
) -> ContactProblem:
    """Return the problem of all contacts at a complete state as if closed; no check of the gaps.

    The slip velocity of an only contact that is held as a state of its own (``slip_velocity`` of an
    event) is taken from there.
    """
    values = {**state, **parameters}
    numbers = Delassus.of(mechanism).at(values)
    refuse_infinite(mechanism, values, numbers)
    slip = numbers.slip_velocity
    if len(slip) == 1:
        slip = np.array([state.get("slip_velocity", slip[0])])
    bilateral = np.array(mechanism.outline.bilateral)
    return ContactProblem(numbers.W, numbers.b, numbers.mu, slip, bilateral)


def classify(
    mechanism: MechanismLike,
    state: StateLike | None = None,
    *,
    parameters: Mapping[str, Value] | None = None,
    close: str | None = None,
    contact_velocity: Sequence[float] | None = None,
) -> Classification:
    """Return the rigid contact problem of the closed contacts at a state, with every solution.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
        With any number of contacts, unilateral or bilateral; in the plane or in space.
    state : mapping of str to (float or str), optional
        Coordinates and velocities; absent ones are 0. The mechanism's `start` where no state is
        given. Where there is one contact, its gap and
        normal velocity must be 0. Of several, one must be closed and none may approach; bilateral
        ones must be held.
    parameters : mapping of str to float
        Absent ones have their defaults.
    close : str, optional
        A coordinate for which gap = 0 is solved from the given state, ``CONTACT:COORDINATE`` with
        several contacts; see `at.closing.closed_state`.
    contact_velocity : sequence of float, optional
        Of the only contact, along n and t, in space n, t1, t2, m/s: the velocities of the state are
        changed for it, with the least kinetic energy of the change; see
        `at.inputs.moving_place`.

    Raises
    ------
    InputError
        Unknown names, numbers out of range, a state that is not in contact; all faults of the
        contacts at once.

    References
    ----------
    Impact model resolution on Painlevé's paradox, (1)–(3) and Fig. 2.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> ps.classify("rod", {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}).case
    <ContactCase.INCONSISTENT: 'inconsistent'>
    """
    place = place_of(mechanism, state, parameters, close, contact_velocity)
    answer = classify_at(place)
    outline = place.mechanism.outline
    static = (c for c in outline.contacts if c.name in answer.contacts and c.static_friction)
    for notice in (*map(friction_notice, static), *border_notices(place)):
        warnings.warn(notice, PainleveWarning, stacklevel=2)
    return answer


def classify_at(place: Place) -> Classification:
    """Return the contact problem of the closed contacts at a place; see `classify`."""
    numbers, closed = _closed_at(place)
    return classified(place, numbers, closed)


def _closed_at(place: Place) -> tuple[ContactNumbers, list[int]]:
    """Return the numbers of all contacts at a place, and the closed ones by index."""
    mechanism = place.mechanism
    numbers = Delassus.of(mechanism).at(place.values)
    refuse_place(place, numbers)
    tolerances = numbers.gap_tolerance.tolist(), numbers.rate_tolerance.tolist()
    if not math.isfinite(sum(map(sum, tolerances))):
        within = list(map(sum, zip(*tolerances, strict=True)))
        unknown = [i for i, size in enumerate(within) if not math.isfinite(size)]
        refuse_infinite(mechanism, place.values, numbers.of_contacts(unknown))
    closed = closed_contacts(f"classify {mechanism.name!r}", mechanism, numbers)
    refuse_infinite(mechanism, place.values, numbers.of_contacts(closed))
    return numbers, closed


def classified(place: Place, numbers: ContactNumbers, closed: Sequence[int]) -> Classification:
    """Return the contact problem of contacts that are closed at a place, by index."""
    mechanism = place.mechanism
    at = numbers.of_contacts(closed)
    A, B = at.A_stick, at.B_stick
    if not math.isfinite(sum((*A.tolist(), *B.tolist()))):
        raise InputError(
            f"classify {mechanism.name!r}: got A' = {A}, B' = {B} in sticking, need finite "
            "numbers. Fix: check the state and the parameters."
        )
    largest = max(map(abs, at.W.ravel().tolist()))
    if largest > LARGEST:  # bounces of the contact have no numbers then
        raise InputError(
            f"classify {mechanism.name!r}: got a mobility of {largest:g} 1/kg, need at most "
            f"{LARGEST:g}. Fix: check the state and the parameters."
        )
    bilateral = mechanism.outline.bilateral
    sides = np.array([bilateral[i] for i in closed])
    problem = ContactProblem(at.W, at.b, at.mu, at.slip_velocity, sides)
    return classification(place, closed, problem, (A, B))


def closed_contacts(where: str, mechanism: Mechanism, numbers: ContactNumbers) -> list[int]:
    """Return the indices of the closed contacts.

    Raises
    ------
    InputError
        For a contact inside its surface, approaching it or off its guide, and where none is closed;
        all faults at once. `where` begins the message.
    """
    faults: list[str] = []
    closed: list[int] = []
    single = len(mechanism.outline.contacts) == 1
    for i, contact in enumerate(mechanism.outline.contacts):
        gap, rate = float(numbers.gap[i]), float(numbers.gap_rate[i])
        near, slow = float(numbers.gap_tolerance[i]), float(numbers.rate_tolerance[i])
        name = "the contact" if single else f"contact {contact.name!r}"
        if contact.bilateral:
            subject = "a bilateral contact" if single else f"bilateral {name}"
            faults += guide_faults(subject, (gap, near), (rate, slow))
            closed.append(i)
        elif gap < -near:
            faults.append(
                f"{name} starts inside the ground, gap = {gap:g} m, and no contact law is given. "
                f"{closing_hint(mechanism, i)}; or use simulate with a law."
            )
        elif gap <= near and rate < -slow:
            faults.append(
                f"normal velocity {rate:g} m/s, need 0. Fix: use jump or simulate."
                if single
                else f"{name} approaches with {-rate:g} m/s: an impact. "
                "Fix: use simulate with --law rigid."
            )
        elif gap <= near and rate <= slow:
            closed.append(i)
        elif single and gap > near:
            faults.append(f"{name} is open, gap = {gap:g} m, need 0. {closing_hint(mechanism, i)}.")
        elif single:
            faults.append(
                f"normal velocity {rate:g} m/s, need 0. "
                "Fix: the contact is leaving: nothing to solve."
            )
    if not closed and not faults:
        hint = closing_hint(mechanism, 0).replace("close it", "close one")
        faults.append(f"no contact is closed. {hint}.")
    if faults:
        raise InputError(f"{where}: " + " ".join(faults))
    return closed


def guide_faults(subject: str, gap: tuple[float, float], rate: tuple[float, float]) -> list[str]:
    """Return a sentence where a bilateral contact is off its guide; none where it is on it.

    Parameters
    ----------
    subject : str
    gap, rate : tuple of two float
        Gap and normal velocity, each with its tolerance; m, m/s.
    """
    if abs(gap[0]) <= gap[1] and abs(rate[0]) <= rate[1]:
        return []
    return [
        f"{subject} holds its point: got gap = {gap[0]:g} m and normal velocity {rate[0]:g} m/s, "
        f"need both 0 within {gap[1]:.1g} m and {rate[1]:.1g} m/s. "
        "Fix: start on the guide and along it."
    ]
