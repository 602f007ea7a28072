"""The impact of one contact by the slip after it: a contact problem of velocities, impulses."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.impact.path import ImpactPhase
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.solution import ContactSolution

FinalSlipCourse = tuple[ImpactClass, bool, tuple[ImpactPhase, ...], bool]
"""The class of an impact, whether it ends, its only phase, and whether it is the only impulse."""

_NAMES = {
    ImpactClass.SLIDING: "slip",
    ImpactClass.STICKING: "sticking",
    ImpactClass.REVERSED: "reverse slip",
}


def final_slip_course(
    W: Sequence[Sequence[float]], mu: float, velocity: Sequence[float], e: float
) -> FinalSlipCourse:
    """Return the impact with v_n⁺ = −e v_n⁻ and friction against the slip after it.

    W P = v⁺ − v⁻ is the contact problem of a contact at rest with b = (1 + e) v_n⁻, v_t⁻. Of
    several impulses the least normal one is taken. Without collision an impulse has to change the
    velocity. The arguments are those of `solve_impact`.
    """
    v_n, *v_t = velocity
    b = np.array([(1.0 + e) * v_n, *v_t])
    problem = ContactProblem(np.array(W), b, mu, np.zeros(len(v_t)))
    solutions = problem.solutions()
    if v_n == 0.0:
        solutions = tuple(s for s in solutions if s.normal_force > 0.0 and _changes(s, v_t))
        if not solutions:
            return ImpactClass.NO_IMPACT, False, (), True
    if not solutions:
        return ImpactClass.STICKING, False, (), True
    chosen = min(solutions, key=lambda s: s.normal_force)
    is_unique = len(solutions) == 1 and not chosen.moves
    case = _class_of(chosen, v_t)
    return case, True, (_phase(_NAMES[case], chosen, velocity, e),), is_unique


def _changes(solution: ContactSolution, v_t: Sequence[float]) -> bool:
    return bool(np.any(solution.acceleration[1:] != v_t))


def _class_of(solution: ContactSolution, v_t: Sequence[float]) -> ImpactClass:
    if solution.mode is ContactMode.STICK:
        return ImpactClass.STICKING
    back = math.fsum(a * b for a, b in zip(solution.direction, v_t, strict=True)) < 0.0
    return ImpactClass.REVERSED if back else ImpactClass.SLIDING


def _phase(name: str, solution: ContactSolution, before: Sequence[float], e: float) -> ImpactPhase:
    P_n, *P_t = (solution.force + 0.0).tolist()
    after = solution.acceleration.tolist()
    after[0] = after[0] - e * before[0] + 0.0
    works = [P * (v + w) / 2 + 0.0 for P, v, w in zip((P_n, *P_t), before, after, strict=True)]
    return ImpactPhase(
        name,
        solution.mode,
        P_n,
        tuple(P_t),
        tuple(v + 0.0 for v in after),
        works[0],
        math.fsum(works[1:]) + 0.0,
        solution.direction,
    )
