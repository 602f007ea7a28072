"""Figs. 2, 3, 5, 7 and 11: the rigid contact problem, solved by every method side by side."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from painleve_sym.complementarity import (
    LCPSolution,
    LemkeResult,
    MPCCOptions,
    MPCCSurvey,
    solve_lemke,
    solve_mpcc_all,
)
from painleve_sym.contacts.classify import Classification, classify
from painleve_sym.contacts.local_mode import ContactMode
from painleve_sym.contacts.problem import ContactCase, ContactProblem, ContactSolution
from painleve_sym.papers.claim import Entry, Outcome, features, table
from painleve_sym.papers.impact_resolution.claims import SLIDING_FORCE
from painleve_sym.papers.panels import FORCE, NORMAL_ACCELERATION, Mark, Panel, line
from painleve_sym.papers.run_cache import Workbench

GROUP = "figure"
STEP = 1e-6
"""Time step of the contact problem in velocities; s. So short that gravity moves nothing."""
_CORNERS = MPCCOptions(random_starts=0)
REST = 1e-9
"""Velocity, relative to the slip before, that round-off leaves of zero."""


@dataclass(frozen=True)
class Diagram:
    """One of the paper's diagrams of ÿ_A over F_n.

    Attributes
    ----------
    table : int
        State it is drawn for.
    case : ContactCase
        What the paper finds.
    claim : str
    title : str
        For Fig. 2.
    top : float
        Largest force drawn; N.
    """

    table: int
    case: ContactCase
    claim: str
    title: str
    top: float


DIAGRAMS: dict[str, Diagram] = {
    "fig-3": Diagram(
        1, ContactCase.SLIP, "one solution: sliding, F_n = 6.039 N", "$A>0$, $B<0$", 12.0
    ),
    "fig-5": Diagram(2, ContactCase.LIFTOFF, "one solution: the rod jumps up", "$A>0$, $B>0$", 4.0),
    "fig-7": Diagram(3, ContactCase.INCONSISTENT, "no solution", "$A<0$, $B<0$", 400.0),
    "fig-11": Diagram(
        4,
        ContactCase.INDETERMINATE,
        "two solutions: jump up, or slide with F_n = −B/A",
        "$A<0$, $B>0$",
        450.0,
    ),
}


def rigid(bench: Workbench, number: int) -> Classification:
    """Return the rigid contact problem at the state of a table."""
    return bench.shared(f"rigid {number}", lambda: classify(bench.rod, bench.state(number)))


def panel(diagram: Diagram, found: Classification, title: str = "") -> Panel:
    """Return the line ÿ_A = A F_n + B, the set complementarity admits, and where they meet."""
    forces = [0.0, diagram.top]
    values = [found.A * f + found.B for f in forces]
    top = max(*values, 0.35 * max(abs(v) for v in values))
    bottom = min(*values, -0.25 * top)
    admitted = line(
        r"$F_n\geq0$, $\ddot{y}_A\geq0$, $F_n\,\ddot{y}_A=0$",
        [0.0, 0.0, diagram.top],
        [1.15 * top, 0.0, 0.0],
        "admissible",
    )
    equation = line(r"$\ddot{y}_A=A\,F_n+B$", forces, values)
    marks = tuple(Mark("solution", s.normal_force, s.normal_acceleration) for s in found.solutions)
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

    The slip direction is not given but found: W P + v + h b = v⁺ has the form of the contact
    problem at rest, with the velocities before the step as free accelerations.
    """
    velocity = np.array([0.0, problem.slip_velocity.item()])
    return replace(problem, b=velocity + STEP * problem.b, slip_velocity=np.zeros(1))


@dataclass(frozen=True)
class Answers:
    """What enumeration, Lemke and the relaxation say about one contact problem.

    Attributes
    ----------
    name, unit : str
        Of the problem, and of its normal unknown.
    exact : tuple of ContactSolution
    lemke : LemkeResult
    survey : MPCCSurvey
    """

    name: str
    unit: str
    exact: tuple[ContactSolution, ...]
    lemke: LemkeResult[LCPSolution]
    survey: MPCCSurvey

    @classmethod
    def of(cls, problem: ContactProblem, name: str, unit: str) -> Answers:
        """Ask all three."""
        lcp = problem.lcp()
        lemke, survey = solve_lemke(lcp), solve_mpcc_all(lcp, options=_CORNERS, compared=2)
        return cls(name, unit, problem.solutions(), lemke, survey)

    @property
    def pivots(self) -> list[float]:
        """Lemke's normal unknown, where it has an answer."""
        return [] if self.lemke.solution is None else [float(self.lemke.solution.z[0])]

    @property
    def relaxed(self) -> list[float]:
        """The relaxation's normal unknowns."""
        return sorted(float(s.z[0]) for s in self.survey.solutions)

    def rows(self) -> list[list[Any]]:
        """Return a row of the table for each method."""
        failed = self.survey.failed
        ended = f"{self.survey.starts - failed} of {self.survey.starts} starts end in a solution"
        exact = [s.normal_force for s in self.exact]
        lemke = f"{self.lemke.status.label}, {self.lemke.pivots} pivots"
        return [
            [self.name, "enumeration", self._text(exact), "every cone tried"],
            [self.name, "Lemke", self._text(self.pivots), lemke],
            [self.name, "relaxed MPCC", self._text(self.relaxed), ended],
        ]

    def _text(self, values: list[float]) -> str:
        return ", ".join(f"{v:.6g} {self.unit}" for v in values) if values else "none"

    def checks(self) -> dict[str, bool]:
        """Check that no method claims a solution that is none; missing some is allowed."""
        exact = [s.normal_force for s in self.exact]

        def known(value: float) -> bool:
            return any(math.isclose(value, e, rel_tol=1e-6, abs_tol=1e-12) for e in exact)

        return {
            f"{self.name}: Lemke's answer is a solution": all(map(known, self.pivots)),
            f"{self.name}: relaxed answers are solutions": all(map(known, self.relaxed)),
        }


def _impulse(solution: ContactSolution, slip: float) -> dict[str, Any]:
    """Return one solution over a step in words and numbers."""
    slipping = abs(solution.tangential_acceleration) > REST * abs(slip)
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


def compute_diagram(name: str, bench: Workbench) -> Outcome:
    """Solve the contact problem of one diagram by every method."""
    diagram = DIAGRAMS[name]
    found = rigid(bench, diagram.table)
    free = in_velocities(found.problem)
    given = Answers.of(found.problem, "accelerations, sliding given", "N")
    stepped = Answers.of(free, "impulses over a step, slip free", "N s")
    over_step = [_impulse(s, found.problem.slip_velocity.item()) for s in stepped.exact]
    data = {
        "A": found.A,
        "B": found.B,
        "case": found.case.value,
        "solutions": [s.normal_force for s in found.solutions],
        "step": STEP,
        "over_a_step": over_step,
        "table": table(
            ["problem", "method", "normal unknown", "how it ended"],
            [*given.rows(), *stepped.rows()],
        ),
    }
    checks = {"same number and kind of solutions": found.case is diagram.case}
    checks |= given.checks() | stepped.checks()
    if name == "fig-3":
        checks["−B/A as printed"] = SLIDING_FORCE.matches(-found.B / found.A)
    forces = [
        "lifts off" if s.mode is ContactMode.LIFTOFF else f"slides, F_n = {s.normal_force:.6g} N"
        for s in found.solutions
    ]
    steps = [f"{s['kind']} ({s['normal_impulse']:.4g} N s)" for s in over_step]
    computed = "; ".join(forces) if forces else "no solution"
    reason = (
        f"With velocities over a step of {STEP:g} s as unknowns, and the slip free to change: "
        + "; ".join(steps)
        + "."
    )
    return features(diagram.claim, computed, checks, reason, data, (panel(diagram, found),))


def compute_cases(bench: Workbench) -> Outcome:
    """Show the four sign patterns of A and B with the states of Tables 1–4."""
    panels, checks, rows = [], {}, []
    signs = {1: (1, -1), 2: (1, 1), 3: (-1, -1), 4: (-1, 1)}
    for number, diagram in enumerate(DIAGRAMS.values(), 1):
        found = rigid(bench, diagram.table)
        panels.append(panel(diagram, found, f"case {number}: {diagram.title}"))
        same = (found.A > 0) == (signs[number][0] > 0) and (found.B > 0) == (signs[number][1] > 0)
        checks[f"case {number}"] = same and found.case is diagram.case
        rows.append([number, found.A, found.B, found.case.value, len(found.solutions)])
    counts = ", ".join(str(row[-1]) for row in rows)
    return features(
        "four cases with 1, 1, 0 and 2 solutions",
        f"{counts} solutions (states of Tables 1–4)",
        checks,
        data={"table": table(["case", "A", "B", "kind", "solutions"], rows)},
        panels=tuple(panels),
    )


ENTRIES = (
    Entry("fig-2", GROUP, "Fig. 2: the four cases", compute_cases),
    Entry("fig-3", GROUP, "Fig. 3: one solution, sliding", partial(compute_diagram, "fig-3")),
    Entry("fig-5", GROUP, "Fig. 5: one solution, lift-off", partial(compute_diagram, "fig-5")),
    Entry("fig-7", GROUP, "Fig. 7: no solution", partial(compute_diagram, "fig-7")),
    Entry("fig-11", GROUP, "Fig. 11: two solutions", partial(compute_diagram, "fig-11")),
)
