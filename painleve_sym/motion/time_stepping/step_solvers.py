"""Solvers for the contact problem of a time step: which of its solutions a step takes.

Where the problem has several solutions the step is not determined by mechanics, and each solver
here answers in its own way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from painleve_sym.motion.time_stepping.mpcc import MPCCStatus, solve_mpcc
from painleve_sym.problem.complementarity.lcp import LCPSolution, solve_all
from painleve_sym.problem.complementarity.lemke import solve_lemke
from painleve_sym.problem.contact_problem import ContactProblem

Impulse = tuple[float, float]
"""Normal and tangential impulse of one step; N s."""
Answer = tuple[int, Impulse | None]
"""Number of solutions of one step, and the impulses of the chosen one."""


def _read(problem: ContactProblem, solution: LCPSolution) -> Impulse:
    normal, tangential = problem.forces_from(solution).tolist()
    return normal, tangential


def first_solution(problem: ContactProblem) -> Answer:
    """Enumerate and take the solution whose complementary cone is tried first."""
    impulses = [_read(problem, solution) for solution in solve_all(problem.lcp())]
    # One set of forces may be found in several cones, which differ in how v_t is divided.
    return len(dict.fromkeys(impulses)), impulses[0] if impulses else None


def enumerated(place: int, problem: ContactProblem) -> Answer:
    """Enumerate and take one of the solutions, which are in the order of their normal impulse."""
    solutions = problem.solutions()
    if not solutions:
        return 0, None
    return len(solutions), (solutions[place].normal_force, solutions[place].tangential_force)


def lemke(problem: ContactProblem) -> Answer:
    """Return the solution of Lemke's pivoting."""
    solution = solve_lemke(problem.lcp()).solution
    return (0, None) if solution is None else (1, _read(problem, solution))


def mpcc(problem: ContactProblem) -> Answer:
    """Return the solution of the relaxation by IPOPT, from the first start that succeeds."""
    relaxed = solve_mpcc(problem.lcp())
    if relaxed.status is not MPCCStatus.SOLVED:
        return 0, None
    normal = float(relaxed.z[0])
    return 1, (normal, float(relaxed.z[1]) - problem.mu.item() * normal)


SOLVERS: Mapping[str, Callable[[ContactProblem], Answer]] = {
    "first": first_solution,
    "least-impulse": partial(enumerated, 0),
    "largest-impulse": partial(enumerated, -1),
    "lemke": lemke,
    "mpcc": mpcc,
}
"""By name. The first three enumerate every solution and differ in the one they take."""
