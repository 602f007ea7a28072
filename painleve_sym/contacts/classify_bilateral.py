"""A bilateral contact at a state: every solution of its contact problem, its tangential impact."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.complementarity.bilateral import BilateralProblem, BilateralSolution
from painleve_sym.contacts.guide import slip_mode, stick_mode
from painleve_sym.contacts.inputs import (
    CONTACT_TOLERANCE,
    resolve_parameters,
    resolve_state,
    symbol_values,
)
from painleve_sym.errors import InputError
from painleve_sym.mechanics.impact.impulse_rays import V_T
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.paradox.bilateral import BilateralForms


class BilateralCase(enum.Enum):
    """Name a state of a bilateral contact by the number of its solutions.

    INCONSISTENT
        None: slip with μ |W_nt| > W_nn and s W_nt B < 0. Only the tangential impact answers.
    UNIQUE
        One.
    TWO_SOLUTIONS
        Slip with μ |W_nt| > W_nn and s W_nt B > 0: one of each sign of F_n.
    SEVERAL
        Two or three at v_t = 0, or a ray of them.
    """

    INCONSISTENT = "inconsistent"
    UNIQUE = "unique"
    TWO_SOLUTIONS = "two solutions"
    SEVERAL = "several"


@dataclass(frozen=True)
class BilateralClassification:
    """Coefficients and rigid solutions of one bilateral contact at one state.

    Attributes
    ----------
    mechanism : str
    state, parameters : dict of str to float
        Complete, with defaults filled in.
    slip : int
        s = sign(v_t); at v_t = 0 the sign of the free acceleration b_t (−1 where b_t = 0).
    A_push, A_pull : float
        A of A F_n + B = 0 in slip along `slip` for F_n > 0 and for F_n < 0; 1/kg.
    B : float
        m/s².
    A_stick, B_stick : float
        The same in sticking.
    excess : float
        μ |W_nt| − W_nn, positive where a slip has no solution or two; 1/kg.
    case : BilateralCase
    solutions : tuple of BilateralSolution
        Every solution by increasing F_n, each with its verified residual.
    problem : BilateralProblem
    """

    mechanism: str
    state: dict[str, float]
    parameters: dict[str, float]
    slip: int
    A_push: float
    A_pull: float
    B: float
    A_stick: float
    B_stick: float
    excess: float
    case: BilateralCase
    solutions: tuple[BilateralSolution, ...]
    problem: BilateralProblem

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        single = ("slip", "A_push", "A_pull", "B", "A_stick", "B_stick", "excess")
        return {
            "mechanism": self.mechanism,
            "bilateral": True,
            "state": self.state,
            "parameters": self.parameters,
            **{name: getattr(self, name) for name in single},
            "case": self.case.value,
            "solutions": [
                {
                    "mode": s.mode.value,
                    "name": solution_name(s, self.problem),
                    "normal_force": s.normal_force,
                    "tangential_force": s.tangential_force,
                    "normal_acceleration": 0.0,
                    "tangential_acceleration": s.tangential_acceleration,
                    "residual": s.residual,
                    "isolated": s.isolated,
                }
                for s in self.solutions
            ],
        }


def bilateral_problem(
    mechanism: Mechanism, state: Mapping[str, float], parameters: Mapping[str, float]
) -> BilateralProblem:
    """Return the numbers of the contact at a complete state; no check of the gap.

    A slip velocity held as a state of its own (an event's ``slip_velocity``) is taken from there.
    """
    c, contact = mechanism.coefficients, mechanism.contact
    symbols = symbol_values(mechanism, state, parameters)
    expressions = [c.W_nn, c.W_nt, c.W_tt, c.b_n, c.b_t, c.mu, contact.slip_velocity]
    W_nn, W_nt, W_tt, b_n, b_t, mu, v_t = map(float, numbers(expressions, symbols))
    return BilateralProblem(W_nn, W_nt, W_tt, b_n, b_t, mu, state.get("slip_velocity", v_t))


def solution_name(solution: BilateralSolution, problem: BilateralProblem) -> str:
    """Return the mode of rigid motion that a solution is, such as ``slip_neg/pull_unstable``."""
    side = 1 if solution.normal_force >= 0 else -1
    if solution.mode.value == "stick":
        return stick_mode(side)
    slip = 1 if solution.mode.value == "slip_pos" else -1
    return slip_mode(slip, side, problem.A_slip(slip, side) < 0)


def check_held(where: str, gap: float, rate: float) -> None:
    """Raise InputError unless gap and normal velocity of a bilateral contact are 0."""
    if not (abs(gap) <= CONTACT_TOLERANCE and abs(rate) <= CONTACT_TOLERANCE):
        raise InputError(
            f"{where}: a bilateral contact holds its point: got gap = {gap:g} m and normal "
            f"velocity {rate:g} m/s, need both 0 within {CONTACT_TOLERANCE:g}. "
            "Fix: start on the guide and along it."
        )


def _resolved(
    mechanism: Mechanism,
    where: str,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None,
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the complete state and parameters; InputError where the contact is not held."""
    contact = mechanism.contact
    declared = mechanism.system.parameters
    values = resolve_parameters(f"{mechanism.name!r}", declared, parameters or {})
    start = resolve_state(mechanism, state, values)
    symbols = symbol_values(mechanism, start, values)
    gap, rate = numbers([contact.gap, contact.gap_rate], symbols)
    check_held(where, float(gap), float(rate))
    return start, values


def classify_bilateral(
    mechanism: Mechanism,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
) -> BilateralClassification:
    """Return the rigid contact problem of a bilateral contact at a state, with every solution.

    Parameters
    ----------
    mechanism : Mechanism
        With one bilateral contact.
    state : mapping of str to float
        Coordinates and velocities; absent ones are 0. Gap and normal velocity must be 0.
    parameters : mapping of str to float
        Absent ones have their defaults.

    Raises
    ------
    InputError
        Unknown names, numbers out of range, a state off the guide, a contact that can open.
    """
    if not mechanism.contact.bilateral:
        raise InputError(f"classify {mechanism.name!r}: its contact can open. Fix: use classify.")
    start, values = _resolved(mechanism, f"classify {mechanism.name!r}", state, parameters)
    problem = bilateral_problem(mechanism, start, values)
    c, symbols = mechanism.coefficients, symbol_values(mechanism, start, values)
    A_stick, B_stick = numbers([c.A_stick, c.B_stick], symbols)
    slip = problem.slip_direction or (1 if problem.b_t > 0 else -1)
    A = {side: problem.A_slip(slip, side) for side in (1, -1)}
    solutions = problem.solutions()
    return BilateralClassification(
        mechanism=mechanism.name,
        state=start,
        parameters=values,
        slip=slip,
        A_push=A[1],
        A_pull=A[-1],
        B=problem.b_n,
        A_stick=float(A_stick),
        B_stick=float(B_stick),
        excess=-min(A.values()),
        case=_case(problem, solutions),
        solutions=solutions,
        problem=problem,
    )


def _case(problem: BilateralProblem, solutions: tuple[BilateralSolution, ...]) -> BilateralCase:
    if not solutions:
        return BilateralCase.INCONSISTENT
    if len(solutions) == 1 and solutions[0].isolated:
        return BilateralCase.UNIQUE
    two = len(solutions) == 2 and all(s.isolated for s in solutions)
    return BilateralCase.TWO_SOLUTIONS if two and problem.slip_direction else BilateralCase.SEVERAL


# ---- the tangential impact ----


@dataclass(frozen=True)
class TangentialImpact:
    """The impulse that stops the slip of a bilateral contact at once.

    Attributes
    ----------
    mechanism : str
    slip : int
        s before.
    normal_impulse, tangential_impulse : float
        N s; |P_t| ≤ μ |P_n|.
    velocity_before, velocity : dict of str to float
        Velocities of the mechanism, by state name.
    energy_change : float
        Work of P_t as seen from the guide; J.
    case : BilateralCase
        Of the state before: INCONSISTENT leaves nothing else, TWO_SOLUTIONS offers slips as well.
    """

    mechanism: str
    slip: int
    normal_impulse: float
    tangential_impulse: float
    velocity_before: dict[str, float]
    velocity: dict[str, float]
    energy_change: float
    case: BilateralCase

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        names = ("mechanism", "slip", "normal_impulse", "tangential_impulse", "energy_change")
        return {
            "bilateral": True,
            **{name: getattr(self, name) for name in names},
            "case": self.case.value,
            "before": {"velocity": self.velocity_before},
            "final": {"velocity": self.velocity},
        }


def tangential_impact(
    mechanism: Mechanism,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
) -> TangentialImpact:
    """Return the tangential impact of a bilateral contact at a state of slip.

    W P = (0, −v_t): the only impulse other than 0 that keeps v_n = 0 and obeys Coulomb's law for
    impulses. It lies in the friction cone exactly where μ |W_nt| ≥ W_nn.

    Parameters
    ----------
    mechanism, state, parameters
        As for `classify_bilateral`.

    Raises
    ------
    InputError
        Also for v_t = 0 and for μ |W_nt| < W_nn, where finite forces answer.
    """
    where = f"jump of mechanism {mechanism.name!r}"
    start, values = _resolved(mechanism, where, state, parameters)
    problem = bilateral_problem(mechanism, start, values)
    slip = problem.slip_direction
    if not slip:
        raise InputError(f"{where}: got v_t = 0, need a slip for an impact to stop.")
    worst = min(problem.A_slip(1, 1), problem.A_slip(1, -1))
    if worst > 0:
        raise InputError(
            f"{where}: got mu |W_nt| - W_nn = {-worst:g} 1/kg, need >= 0 for a tangential impact: "
            "the slip has one solution with finite forces. Fix: integrate on, or raise mu."
        )
    forms = BilateralForms(mechanism.coefficients)
    symbols = symbol_values(mechanism, start, values)
    parts = [forms.normal_impulse, forms.tangential_impulse, forms.friction_loss]
    found = numbers([*parts, *forms.velocity_after], symbols | {V_T: problem.slip_velocity})
    P_n, P_t, loss, *velocity = (float(v) + 0.0 for v in found)
    names = [s.name for s in mechanism.system.q_dot]
    return TangentialImpact(
        mechanism=mechanism.name,
        slip=slip,
        normal_impulse=P_n,
        tangential_impulse=P_t,
        velocity_before={n: start[n] for n in names},
        velocity=dict(zip(names, velocity, strict=True)),
        energy_change=-loss,
        case=_case(problem, problem.solutions()),
    )
