"""The rigid contact problem of a mechanism at a state: coefficients, case, every solution."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple, overload

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.checks import LARGEST
from painleve_sym.codegen.named_mechanisms import MechanismLike
from painleve_sym.complementarity.uniqueness import Uniqueness
from painleve_sym.contacts.chatter import Chatter, chatter
from painleve_sym.contacts.classified import ClassifiedState, named_at
from painleve_sym.contacts.classify_in_space import SpatialClassification, classified_in_space
from painleve_sym.contacts.closing import closing_hint
from painleve_sym.contacts.delassus import ContactNumbers, Delassus
from painleve_sym.contacts.inputs import border_notices, place_of, refuse_infinite, refuse_place
from painleve_sym.contacts.model import guide_slip_mode, guide_stick_mode
from painleve_sym.errors import InputError, PainleveWarning
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.mechanism import Mechanism, Place
from painleve_sym.mechanics.outline import KINDS
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.solution import ContactSolution
from painleve_sym.units import Value


@dataclass(frozen=True, eq=False, repr=False)
class Classification(ClassifiedState):
    """The rigid contact problem of the closed contacts at one state, with every solution.

    None and several solutions are results. It has the attributes of `ClassifiedState`, and:

    Attributes
    ----------
    A_sticks, B_sticks : ndarray, shape (n,)
        A′ and B′ of each closed contact; see `NormalCoefficients`.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> answer = ps.classify("rod", {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0})
    >>> answer.case
    <ContactCase.INDETERMINATE: 'indeterminate'>
    >>> len(answer.solutions), answer.contacts
    (2, ('A',))
    """

    A_sticks: Array
    B_sticks: Array

    @cached_property
    def promise(self) -> Uniqueness:
        """Existence and uniqueness for all loads, from W, μ and the slip directions."""
        return self.problem.uniqueness()

    @cached_property
    def coefficients(self) -> tuple[NormalCoefficients, ...]:
        """A and B of each closed contact, the others open."""
        sticking = zip(self.A_sticks.tolist(), self.B_sticks.tolist(), strict=True)
        return tuple(
            NormalCoefficients.of(self.problem.alone(i), *stick) for i, stick in enumerate(sticking)
        )

    # ---- one contact: where it is `single` ----

    @cached_property
    def chatter(self) -> tuple[Chatter, ...]:
        """Course of small bounces near a contact at v_t = 0 that can open.

        For every restitution law, with the default of its coefficient. Empty in slip, where they
        die out, where B ≥ 0, where impacts jam, for a contact that cannot open, and for a mechanism
        with several contacts.
        """
        if not self.single or self.problem.slip_direction:
            return ()
        laws = [make() for make in RESTITUTIONS.values()]
        chatters = [chatter(self.problem, law.name, law.parameter.default) for law in laws]
        return tuple(c for c in chatters if c is not None)

    @property
    def A(self) -> float:
        """A of g̈_N = A F_n + B in slip with F_n > 0; 1/kg."""
        return self._only.A

    @property
    def B(self) -> float:
        """B of the same; m/s²."""
        return self._only.B

    @property
    def A_stick(self) -> float:
        """A′ of g̈_N = A′ F_n + B′ in sticking; 1/kg."""
        return self._only.A_stick

    @property
    def B_stick(self) -> float:
        """B′; m/s²."""
        return self._only.B_stick

    @property
    def _only(self) -> NormalCoefficients:
        (own,) = self.coefficients
        return own

    # ---- plain data ----

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys, the same for any contacts."""
        return {**super().to_dict(), "chatter": [c.to_dict() for c in self.chatter]}

    def _contact_data(self, i: int) -> dict[str, Any]:
        return {
            "kind": KINDS[bool(self.problem.bilateral[i])],
            "slip_velocity": float(self.problem.slip_velocity[i]),
            **self.coefficients[i]._asdict(),
        }

    def _solution_data(self, solution: ContactSolution, i: int) -> dict[str, Any]:
        return {
            "mode": solution.modes[i].value,
            "name": solution_name(solution, self.problem, i),
            "normal_force": float(solution.normal_forces[i]),
            "tangential_force": float(solution.tangential_forces[i]),
            "normal_acceleration": float(solution.normal_accelerations[i]),
            "tangential_acceleration": float(solution.tangential_accelerations[i]),
        }

    @property
    def _assurance(self) -> dict[str, Any]:
        return {"promise": self.promise.label}


class NormalCoefficients(NamedTuple):
    """The line g̈_N = A F_n + B of one contact in slip and in sticking, the others open.

    Attributes
    ----------
    slip : int
        s = sign(v_t); at v_t = 0 the sign of the free acceleration b_t (−1 where b_t = 0).
    A, A_pull : float
        A in slip along s for F_n > 0, and for F_n < 0, which a bilateral contact has; 1/kg.
    B : float
        m/s².
    A_stick, B_stick : float
        A′ and B′ of g̈_N = A′ F_n + B′ in sticking; 1/kg and m/s².
    excess : float
        μ |W_nt| − W_nn: where positive A < 0 for one direction of slip, and a bilateral slip has no
        solution or two; 1/kg.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> [own] = ps.classify("rod", {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}).coefficients
    >>> own.slip, round(own.A, 6), round(own.B, 6), own.excess > 0
    (-1, -0.033745, -8.958529, True)
    """

    slip: int
    A: float
    A_pull: float
    B: float
    A_stick: float
    B_stick: float
    excess: float

    @classmethod
    def of(cls, problem: ContactProblem, A_stick: float, B_stick: float) -> NormalCoefficients:
        """Return the numbers of a problem of one contact, with those in sticking."""
        s = problem.slip_direction or (1 if problem.b_t > 0 else -1)
        A, A_pull = problem.A_slip(s), problem.A_slip(s, -1)
        return cls(s, A, A_pull, problem.B, A_stick, B_stick, -min(A, A_pull))


def solution_name(solution: ContactSolution, problem: ContactProblem, i: int = 0) -> str:
    """Return the mode of rigid motion that a solution is for one contact, the others open.

    Such as ``slip_neg``, and ``slip_neg/pull_unstable`` of a bilateral contact.
    """
    mode = solution.modes[i]
    if not problem.bilateral[i]:
        return mode.value
    side = 1 if solution.normal_forces[i] >= 0 else -1
    if mode is ContactMode.STICK:
        return guide_stick_mode(side)
    slip = 1 if mode is ContactMode.SLIP_POS else -1
    return guide_slip_mode(slip, side, problem.alone(i).A_slip(slip, side) < 0)


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
    return ContactProblem(numbers.W, numbers.b, numbers.mu, slip, np.array(mechanism.outline.held))


Spatial = Literal["rod-3d", "top", "brick", "slider-3d", "two-link-arm-3d"]
"""Named mechanisms whose classification a type checker knows to be one in space."""


@overload
def classify(  # type: ignore[overload-overlap]
    mechanism: Spatial,
    state: Mapping[str, Value] | None = None,
    *,
    parameters: Mapping[str, Value] | None = None,
    close: str | None = None,
    contact_velocity: Sequence[float] | None = None,
) -> SpatialClassification: ...
@overload
def classify(
    mechanism: MechanismLike,
    state: Mapping[str, Value] | None = None,
    *,
    parameters: Mapping[str, Value] | None = None,
    close: str | None = None,
    contact_velocity: Sequence[float] | None = None,
) -> Classification: ...
def classify(
    mechanism: MechanismLike,
    state: Mapping[str, Value] | None = None,
    *,
    parameters: Mapping[str, Value] | None = None,
    close: str | None = None,
    contact_velocity: Sequence[float] | None = None,
) -> Any:
    """Return the rigid contact problem of the closed contacts at a state, with every solution.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
        With any number of contacts, unilateral or bilateral; in space, see `SpatialClassification`.
    state : mapping of str to (float or str), optional
        Coordinates and velocities; absent ones are 0. The mechanism's `start` where no state is
        given. Where there is one contact, its gap and
        normal velocity must be 0. Of several, one must be closed and none may approach; bilateral
        ones must be held.
    parameters : mapping of str to float
        Absent ones have their defaults.
    close : str, optional
        A coordinate for which gap = 0 is solved from the given state, ``CONTACT:COORDINATE`` with
        several contacts; see `contacts.closing.closed_state`.
    contact_velocity : sequence of float, optional
        Of the only contact, along n and t, in space n, t1, t2, m/s: the velocities of the state are
        changed for it, with the least kinetic energy of the change; see
        `contacts.inputs.moving_place`.

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
    for notice in border_notices(place):
        warnings.warn(notice, PainleveWarning, stacklevel=2)
    return answer


def classify_at(place: Place) -> Classification | SpatialClassification:
    """Return the contact problem of the closed contacts at a place; see `classify`."""
    if place.mechanism.outline.in_space:
        return classified_in_space(place, *_closed_at(place))
    return planar_classification(place)


def _closed_at(place: Place) -> tuple[ContactNumbers, list[int]]:
    """Return the numbers of all contacts at a place, and the closed ones by index."""
    mechanism = place.mechanism
    numbers = Delassus.of(mechanism).at(place.values)
    refuse_place(place, numbers)
    tolerances = (numbers.gap_tolerance + numbers.rate_tolerance).tolist()
    unknown = [i for i, within in enumerate(tolerances) if not math.isfinite(within)]
    refuse_infinite(mechanism, place.values, numbers.of_contacts(unknown))
    closed = closed_contacts(f"classify {mechanism.name!r}", mechanism, numbers)
    refuse_infinite(mechanism, place.values, numbers.of_contacts(closed))
    return numbers, closed


def planar_classification(place: Place) -> Classification:
    """Return the contact problem of a planar mechanism; InputError for one in space."""
    mechanism = place.mechanism
    mechanism.require_planar()
    numbers, closed = _closed_at(place)
    at = numbers.of_contacts(closed)
    A, B = at.A_stick, at.B_stick
    if not math.isfinite(sum((*A.tolist(), *B.tolist()))):
        raise InputError(
            f"classify {mechanism.name!r}: got A' = {A}, B' = {B} in sticking, need finite "
            "numbers. Fix: check the state and the parameters."
        )
    largest = max(abs(w) for w in at.W.ravel().tolist())
    if largest > LARGEST:  # bounces of the contact have no numbers then
        raise InputError(
            f"classify {mechanism.name!r}: got a mobility of {largest:g} 1/kg, need at most "
            f"{LARGEST:g}. Fix: check the state and the parameters."
        )
    held = np.array(mechanism.outline.held)[closed]
    problem = ContactProblem(at.W, at.b, at.mu, at.slip_velocity, held)
    return Classification(
        **named_at(place, closed),
        problem=problem,
        solutions=problem.solutions(),
        A_sticks=A,
        B_sticks=B,
    )


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
            faults += held_faults(subject, (gap, near), (rate, slow))
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


def held_faults(subject: str, gap: tuple[float, float], rate: tuple[float, float]) -> list[str]:
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
