"""Figs. 2, 3, 5, 7 and 11: the rigid contact problem, solved by every method side by side."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from painleve_sym.at.classification import Classification
from painleve_sym.motion.time_stepping.mpcc import solve_mpcc_all
from painleve_sym.papers.impact_resolution.claims import NUMBERS
from painleve_sym.papers.impact_resolution.runs import Workbench
from painleve_sym.papers.item import ItemOutcome, checked, table
from painleve_sym.papers.panels import FORCE, NORMAL_ACCELERATION, Mark, Panel, line
from painleve_sym.problem.complementarity import solve_lemke
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.solution import ContactCase, ContactSolution

STEP = 1e-6
"""Time step of the contact problem in velocities; s. So short that gravity moves nothing."""
STICKING = 1e-9
"""Velocity, relative to the slip before, that round-off leaves of zero."""


@dataclass(frozen=True)
class Diagram:
    """One of the paper's diagrams of ÿ_A over F_n: its state, its answer, the largest force; N."""

    table: int
    case: ContactCase
    title: str
    top: float


DIAGRAMS: dict[str, Diagram] = {
    "fig-3": Diagram(1, ContactCase.SLIP, "$A>0$, $B<0$", 12.0),
    "fig-5": Diagram(2, ContactCase.LIFTOFF, "$A>0$, $B>0$", 4.0),
    "fig-7": Diagram(3, ContactCase.INCONSISTENT, "$A<0$, $B<0$", 400.0),
    "fig-11": Diagram(4, ContactCase.INDETERMINATE, "$A<0$, $B>0$", 450.0),
}


def panel(diagram: Diagram, rigid: Classification, title: str = "") -> Panel:
    """Return the line ÿ_A = A F_n + B, the set complementarity admits, and where they meet."""
    forces = [0.0, diagram.top]
    values = [rigid.A * f + rigid.B for f in forces]
    top = max(*values, 0.35 * max(abs(v) for v in values))
    bottom = min(*values, -0.25 * top)
    admitted = line(
        r"$F_n\geq0$, $\ddot{y}_A\geq0$, $F_n\,\ddot{y}_A=0$",
        [0.0, 0.0, diagram.top],
        [1.15 * top, 0.0, 0.0],
        "admissible",
    )
    equation = line(r"$\ddot{y}_A=A\,F_n+B$", forces, values)
    marks = tuple(Mark("solution", s.normal_force, s.normal_acceleration) for s in rigid.solutions)
    return Panel(
        FORCE.within(-0.06 * diagram.top, diagram.top),
        NORMAL_ACCELERATION.within(1.15 * bottom, 1.15 * top),
        (admitted, equation),
        marks,
        title,
        "" if marks else "no solution",
    )


def in_velocities(problem: ContactProblem) -> ContactProblem:
    """Return the frictional contact problem over a short step, in impulses and end velocities.

    The slip direction is an unknown: W P + v + h b = v⁺ has the form of the contact
    problem at rest, with the velocities before the step as free accelerations.
    """
    velocity = np.array([0.0, problem.slip_velocity.item()])
    return replace(problem, b=velocity + STEP * problem.b, slip_velocity=np.zeros(1))


def solved_by_every_method(
    problem: ContactProblem, name: str, unit: str
) -> tuple[tuple[ContactSolution, ...], list[list[Any]], dict[str, bool]]:
    """Solve one contact problem by enumeration, Lemke's method and the relaxation.

    Return all solutions, a row of the table for each method, and whether every claimed solution is
    one; a method may miss some. The unit is that of the normal unknown.
    """
    solutions = problem.solutions()
    exact = [s.normal_force for s in solutions]
    lcp = problem.lcp()
    lemke, survey = solve_lemke(lcp), solve_mpcc_all(lcp, compared=2, random_starts=0)
    pivoted = [] if lemke.solution is None else [float(lemke.solution.z[0])]
    relaxed = sorted(float(s.z[0]) for s in survey.solutions)

    def text(values: list[float]) -> str:
        return ", ".join(f"{v:.6g} {unit}" for v in values) if values else "none"

    def known(value: float) -> bool:
        return any(math.isclose(value, e, rel_tol=1e-6, abs_tol=1e-12) for e in exact)

    ended = f"{survey.starts - survey.failed} of {survey.starts} starts end in a solution"
    rows: list[list[Any]] = [
        [name, "enumeration", text(exact), "every cone tried"],
        [name, "Lemke", text(pivoted), f"{lemke.status.label}, {lemke.pivots} pivots"],
        [name, "relaxed MPCC", text(relaxed), ended],
    ]
    checks = {
        f"{name}: Lemke's answer is a solution": all(map(known, pivoted)),
        f"{name}: relaxed answers are solutions": all(map(known, relaxed)),
    }
    return solutions, rows, checks


def _impulse(solution: ContactSolution, slip: float) -> dict[str, Any]:
    """Return one solution over a step in words and numbers."""
    slipping = abs(solution.tangential_acceleration) > STICKING * abs(slip)
    jumps = not slipping and solution.normal_force > 0
    kind = "jump to rest" if jumps else "slides on"
    if solution.mode is ContactMode.LIFTOFF:
        kind = "lifts off"
    return {
        "kind": kind,
        "normal_impulse": solution.normal_force,
        "tangential_impulse": solution.tangential_force,
        "slip_velocity_after": solution.tangential_acceleration,
        "normal_velocity_after": solution.normal_acceleration,
    }


def compute_diagram(name: str, bench: Workbench) -> ItemOutcome:
    """Solve the contact problem of one diagram by every method."""
    diagram = DIAGRAMS[name]
    rigid = bench.rigid(diagram.table)
    _, given, given_checks = solved_by_every_method(
        rigid.problem, "accelerations, sliding given", "N"
    )
    impulses, stepped, stepped_checks = solved_by_every_method(
        in_velocities(rigid.problem), "impulses over a step, slip free", "N s"
    )
    over_step = [_impulse(s, rigid.problem.slip_velocity.item()) for s in impulses]
    data = {
        "A": rigid.A,
        "B": rigid.B,
        "case": rigid.case.value,
        "solutions": [s.normal_force for s in rigid.solutions],
        "step": STEP,
        "over_a_step": over_step,
        "table": table(["problem", "method", "normal unknown", "how it ended"], [*given, *stepped]),
    }
    checks = {"same number and kind of solutions": rigid.case is diagram.case}
    checks |= given_checks | stepped_checks
    if name == "fig-3":
        checks["−B/A as printed"] = NUMBERS["sliding-force"].matches(-rigid.B / rigid.A)
    forces = [
        "lifts off" if s.mode is ContactMode.LIFTOFF else f"slides, F_n = {s.normal_force:.6g} N"
        for s in rigid.solutions
    ]
    steps = [f"{s['kind']} ({s['normal_impulse']:.4g} N s)" for s in over_step]
    computed = "; ".join(forces) if forces else "no solution"
    return checked(
        computed, checks, data, (panel(diagram, rigid),), step=STEP, steps="; ".join(steps)
    )


def compute_cases(bench: Workbench) -> ItemOutcome:
    """Show the four sign patterns of A and B with the states of Tables 1–4."""
    panels, checks, rows = [], {}, []
    signs = {1: (1, -1), 2: (1, 1), 3: (-1, -1), 4: (-1, 1)}
    for number, diagram in enumerate(DIAGRAMS.values(), 1):
        rigid = bench.rigid(diagram.table)
        panels.append(panel(diagram, rigid, f"case {number}: {diagram.title}"))
        same = (rigid.A > 0) == (signs[number][0] > 0) and (rigid.B > 0) == (signs[number][1] > 0)
        checks[f"case {number}"] = same and rigid.case is diagram.case
        rows.append([number, rigid.A, rigid.B, rigid.case.value, len(rigid.solutions)])
    counts = ", ".join(str(row[-1]) for row in rows)
    return checked(
        f"{counts} solutions (states of Tables 1–4)",
        checks,
        {"table": table(["case", "A", "B", "kind", "solutions"], rows)},
        tuple(panels),
    )


COMPUTE = {"fig-2": compute_cases, **{name: partial(compute_diagram, name) for name in DIAGRAMS}}
