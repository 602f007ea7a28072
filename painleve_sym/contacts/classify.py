"""The rigid contact problem of a mechanism at a state: coefficients, case, every solution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from painleve_sym.complementarity.contact import ContactCase, ContactProblem, ContactSolution
from painleve_sym.contacts.chatter import Chatter, chatter
from painleve_sym.contacts.classify_bilateral import BilateralClassification, classify_bilateral
from painleve_sym.contacts.contact_numbers import contact_numbers
from painleve_sym.contacts.inputs import (
    CONTACT_TOLERANCE,
    resolve_parameters,
    resolve_state,
    symbol_values,
)
from painleve_sym.errors import InputError
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.models import Mechanism


@dataclass(frozen=True)
class Classification:
    """Coefficients and rigid solutions of one contact at one state.

    Attributes
    ----------
    mechanism : str
    state, parameters : dict of str to float
        Complete, with defaults filled in.
    A, B : float
        g̈_N = A F_n + B in slip, 1/kg and m/s². At v_t = 0, A is that of the slip direction that
        would begin: the sign of b_t, or negative slip where b_t = 0.
    A_stick, B_stick : float
        The same in sticking.
    case : ContactCase
    solutions : tuple of ContactSolution
        Every solution, each with its verified residual; none and several are results.
    problem : ContactProblem
    chatter : tuple of Chatter
        At v_t = 0: how small bounces follow each other, for every restitution law with the default
        of its coefficient. Empty in slip, where they die out, where B ≥ 0, and where impacts jam.
    """

    mechanism: str
    state: dict[str, float]
    parameters: dict[str, float]
    A: float
    B: float
    A_stick: float
    B_stick: float
    case: ContactCase
    solutions: tuple[ContactSolution, ...]
    problem: ContactProblem
    chatter: tuple[Chatter, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        return {
            "mechanism": self.mechanism,
            "state": self.state,
            "parameters": self.parameters,
            "A": self.A,
            "B": self.B,
            "A_stick": self.A_stick,
            "B_stick": self.B_stick,
            "case": self.case.value,
            "solutions": [
                {
                    "mode": s.mode.value,
                    "normal_force": s.normal_force,
                    "tangential_force": s.tangential_force,
                    "normal_acceleration": s.normal_acceleration,
                    "tangential_acceleration": s.tangential_acceleration,
                    "residual": s.residual,
                }
                for s in self.solutions
            ],
            "chatter": [c.to_dict() for c in self.chatter],
        }


def contact_problem(
    mechanism: Mechanism, state: Mapping[str, float], parameters: Mapping[str, float]
) -> ContactProblem:
    """Return the numbers of the contact at a complete state; no check of the gap."""
    found = contact_numbers(mechanism)(symbol_values(mechanism, state, parameters))
    return ContactProblem(
        **{name: found[name] for name in ("W_nn", "W_nt", "W_tt", "b_n", "b_t")},
        mu=float(parameters[mechanism.contact.friction.name]),
        slip_velocity=found["slip_velocity"],
    )


def classify(
    mechanism: Mechanism,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
) -> Classification | BilateralClassification:
    """Return the rigid contact problem at a state in contact, with every solution.

    As the contact is, by `classify_opening` or `classify_bilateral`.
    """
    if mechanism.contact.bilateral:
        return classify_bilateral(mechanism, state, parameters)
    return classify_opening(mechanism, state, parameters)


def classify_opening(
    mechanism: Mechanism,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
) -> Classification:
    """Return the rigid contact problem of a contact that can open, with every solution.

    Parameters
    ----------
    mechanism : Mechanism
        With one contact.
    state : mapping of str to float
        Coordinates and velocities; absent ones are 0. Gap and normal velocity must be 0.
    parameters : mapping of str to float
        Absent ones have their defaults.

    Raises
    ------
    InputError
        Unknown names, numbers out of range, a state that is not in contact.

    References
    ----------
    Zhao, Liu & Chen, (1)–(3) and Fig. 2.
    """
    values = resolve_parameters(
        f"{mechanism.name!r}", mechanism.system.parameters, parameters or {}
    )
    start = resolve_state(mechanism, state, values)
    contact = mechanism.contact
    if contact.bilateral:
        raise InputError(
            f"classify {mechanism.name!r}: contact {contact.name!r} is bilateral, need one that "
            "can open. Fix: use classify_bilateral."
        )
    _check_contact(mechanism, start, values)
    problem = contact_problem(mechanism, start, values)
    found = contact_numbers(mechanism)(symbol_values(mechanism, start, values))
    A = problem.A
    if A is None:
        A = problem.A_slip(1 if problem.b_t > 0 else -1)
    return Classification(
        mechanism=mechanism.name,
        state=start,
        parameters=values,
        A=A,
        B=problem.B,
        A_stick=found["A_stick"],
        B_stick=found["B_stick"],
        case=problem.case,
        solutions=problem.solutions(),
        problem=problem,
        chatter=_bounces(problem),
    )


def _bounces(problem: ContactProblem) -> tuple[Chatter, ...]:
    if problem.slip_direction:
        return ()
    laws = [make() for make in RESTITUTIONS.values()]
    found = [chatter(problem, law.name, law.parameter.default) for law in laws]
    return tuple(c for c in found if c is not None)


def _check_contact(
    mechanism: Mechanism, state: Mapping[str, float], parameters: Mapping[str, float]
) -> None:
    found = contact_numbers(mechanism)(symbol_values(mechanism, state, parameters))
    gap, rate = found["gap"], found["gap_rate"]
    where = f"classify {mechanism.name!r}"
    if gap < -CONTACT_TOLERANCE:
        raise InputError(
            f"{where}: the contact starts inside the ground, gap = {gap:g} m, and no contact law "
            "is given. Fix: start with gap 0, or use simulate with a law."
        )
    if gap > CONTACT_TOLERANCE:
        raise InputError(
            f"{where}: the contact is open, gap = {gap:g} m, need 0. Fix: start on the surface."
        )
    if abs(rate) > CONTACT_TOLERANCE:
        fix = "use jump or simulate" if rate < 0 else "the contact is leaving: nothing to solve"
        raise InputError(f"{where}: normal velocity {rate:g} m/s, need 0. Fix: {fix}.")
