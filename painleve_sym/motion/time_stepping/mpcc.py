"""Complementarity through CasADi and IPOPT: Scholtes' relaxation, with every answer checked.

An independent road to the solutions that `lcp` enumerates, and one that stays open where a
complementarity condition sits inside a larger nonlinear program. An interior-point method finds
one solution near its start or none; it proves nothing about others, and it can end without an
answer. Both are said in the result.

References
----------
Scholtes (2001); Wächter & Biegler (2006).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from painleve_sym.equality import Compared
from painleve_sym.errors import Explained, InputError
from painleve_sym.problem.complementarity.lcp import LCP, RESIDUAL_TOLERANCE, equilibrate, residual
from painleve_sym.problem.complementarity.solution_sets import FloatArray

# Bounds on z_i w_i of the scaled problem. Each step's product is within reach of the last point;
# 1e-9 is IPOPT's own accuracy.
RELAXATIONS = (1.0, 1e-1, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9)
MAX_ITERATIONS = 200  # of IPOPT, for each relaxation
RANDOM_STARTS = 4  # added to the corners z_i in {0, large}, always the same ones
_CORNER_LIMIT = 4  # 2**4 corner starts; for more pairs random corners take their place
_NEAR = 1e-6  # solutions with a smaller relative distance are one; IPOPT leaves some 1e-8


class MPCCStatus(Explained):
    """End of one relaxation run; `sentence` explains it and names a remedy."""

    SOLVED = ("solved", "the point has been checked; there may be others, see solve_mpcc_all")
    INFEASIBLE = (
        "infeasible",
        "IPOPT stopped at a point where the violation has no descent. Without proof: the problem "
        "may be inconsistent, or the start was poor; try more starts, or solve_all decides",
    )
    NOT_CONVERGED = ("not_converged", "IPOPT gave up; start elsewhere, or ask solve_all")
    NOT_VERIFIED = (
        "not_verified",
        "IPOPT reports success, but the point fails the residual check; ask solve_all",
    )


@dataclass(frozen=True, eq=False)
class MPCCResult(Compared):
    """Report the run from one start: SOLVED only where the residual passes the check.

    `z` is the last point, a solution only then, and ``w = M z + q``. Iterations are IPOPT's over
    all relaxations of this start. `polished` says whether z was recomputed from IPOPT's active
    pairs (a linear solve) to pass the check.
    """

    status: MPCCStatus
    z: FloatArray
    w: FloatArray
    residual: float
    iterations: int
    polished: bool


@dataclass(frozen=True, eq=False)
class MPCCSurvey(Compared):
    """Report many starts: the distinct solutions in order of their starts, and the failed runs."""

    solutions: tuple[MPCCResult, ...]
    failures: tuple[MPCCResult, ...]
    starts: int

    @property
    def failed(self) -> int:
        """Return the number of starts without a solution."""
        return len(self.failures)


def solve_mpcc(problem: LCP, start: npt.ArrayLike | None = None) -> MPCCResult:
    """Find one solution by relaxing ``z_i w_i = 0`` to ``z_i w_i <= tau`` with tau -> 0.

    Each relaxed program (Scholtes 2001) asks for the feasible point nearest to the last one::

        min |z - z_last|^2 / 2   s.t.   z >= 0,  w = M z + q >= 0,  z_i w_i <= tau

    The limit is then recomputed from its active pairs, since an interior point stops some 1e-9
    short of the bounds, and the better of the two points is checked against the problem itself.

    Without a start several are tried until one succeeds; where none does, the failure with the
    smallest residual is returned.

    Raises
    ------
    InputError
        For a start of another length or with infinite entries. Fix: give n finite numbers.
    """
    program = _RelaxedProgram(problem)
    starts = program.starts(RANDOM_STARTS) if start is None else [program.checked_start(start)]
    best: MPCCResult | None = None
    for point in starts:
        result = program.run(point)
        if result.status is MPCCStatus.SOLVED:
            return result
        if best is None or result.residual < best.residual:
            best = result
    assert best is not None  # there is always one start
    return best


def solve_mpcc_all(
    problem: LCP,
    starts: Iterable[npt.ArrayLike] | None = None,
    compared: int | None = None,
    random_starts: int = RANDOM_STARTS,
) -> MPCCSurvey:
    """Run `solve_mpcc` from many starts and keep the distinct solutions.

    A survey without solutions does not prove that there is none, and solutions may be missing:
    `painleve_sym.problem.complementarity.lcp.solve_all` decides both. The starts are by default
    corners and as many random starts.

    Solutions are distinct if their first `compared` entries are, or all. The forces of one contact
    at rest are the first two: how a_t divides into two parts does not count.

    Raises
    ------
    InputError
        As `solve_mpcc`.
    """
    program = _RelaxedProgram(problem)
    points = list(
        program.starts(random_starts) if starts is None else map(program.checked_start, starts)
    )
    if not points:
        raise InputError(
            "solve_mpcc_all has nowhere to begin, starts: got none, need at least one. "
            "Fix: give a start or leave starts out."
        )
    solutions: list[MPCCResult] = []
    failures: list[MPCCResult] = []
    for result in map(program.run, points):
        if result.status is not MPCCStatus.SOLVED:
            failures.append(result)
        elif not any(_near(result.z[:compared], known.z[:compared]) for known in solutions):
            solutions.append(result)
    return MPCCSurvey(tuple(solutions), tuple(failures), len(points))


def _near(a: FloatArray, b: FloatArray) -> bool:
    return bool(np.max(np.abs(a - b)) <= _NEAR * max(np.max(np.abs(a)), np.max(np.abs(b))))


class _RelaxedProgram:
    """The relaxed program of one problem, built once and run from many starts."""

    def __init__(self, lcp: LCP) -> None:
        self.lcp = lcp
        self.scaled, self.unit = equilibrate(lcp)
        import casadi as ca

        z = ca.SX.sym("z", lcp.size)
        last = ca.SX.sym("last", lcp.size)
        w = ca.DM(self.scaled.matrix) @ z + ca.DM(self.scaled.offset)
        self.solver: Any = ca.nlpsol(
            "relaxed",
            "ipopt",
            {"x": z, "p": last, "f": ca.sumsqr(z - last) / 2, "g": ca.vertcat(w, z * w)},
            {
                "print_time": False,
                "error_on_fail": False,
                "ipopt.print_level": 0,
                "ipopt.sb": "yes",
                "ipopt.max_iter": MAX_ITERATIONS,
                # Below the smallest tau, or the product bound would not be felt.
                "ipopt.tol": min(1e-10, RELAXATIONS[-1] / 10),
            },
        )

    def checked_start(self, start: npt.ArrayLike) -> FloatArray:
        """Return the start in scaled units."""
        point = np.asarray(start, dtype=float)
        if point.shape != (self.lcp.size,) or not np.all(np.isfinite(point)):
            raise InputError(
                f"relaxation cannot begin, start: got {start!r}, need {self.lcp.size} finite "
                "numbers. Fix: give one number for each complementary pair."
            )
        return point / self.unit

    def starts(self, random_starts: int) -> Iterator[FloatArray]:
        """Yield the starts: corners near and far, then random ones over several magnitudes."""
        n, random = self.lcp.size, np.random.default_rng(0)
        far = 2.0  # past the solutions of well-scaled problems, which lie near 1
        if n <= _CORNER_LIMIT:
            for corner in np.ndindex((2,) * n):
                yield far * np.array(corner, dtype=np.float64)
        else:
            yield np.zeros(n)
            yield np.full(n, far)
            for _ in range(2**_CORNER_LIMIT - 2):
                yield far * random.integers(0, 2, n).astype(np.float64)
        for _ in range(random_starts):
            yield np.exp(random.uniform(-2.0, 4.0, n))

    def run(self, start: FloatArray) -> MPCCResult:
        """Relax from one start and check the result."""
        z, word, iterations = start, "", 0
        n = self.lcp.size
        upper = np.full(2 * n, np.inf)
        for tau in RELAXATIONS:
            upper[n:] = tau
            lower = np.append(np.zeros(n), np.full(n, -np.inf))
            answer = self.solver(x0=z, p=z, lbx=0.0, lbg=lower, ubg=upper)
            stats = self.solver.stats()
            z = np.asarray(answer["x"], dtype=float).ravel()
            word = str(stats["return_status"])
            iterations += int(stats["iter_count"])
            if not stats["success"]:
                break
        return self._checked(z, word, iterations)

    def _checked(self, z: FloatArray, word: str, iterations: int) -> MPCCResult:
        """Return the better of the last point and its polished form, with an honest status.

        The word is that with which IPOPT ended.
        """
        polished = self._polished(z)
        points = [self.unit * np.maximum(z, 0.0)]
        if polished is not None:
            points.append(self.unit * polished)
        errors = [residual(self.lcp, point) for point in points]
        best = int(np.argmin(errors))
        if errors[best] <= RESIDUAL_TOLERANCE:
            status = MPCCStatus.SOLVED
        elif word == "Infeasible_Problem_Detected":
            status = MPCCStatus.INFEASIBLE
        elif word in ("Solve_Succeeded", "Solved_To_Acceptable_Level"):
            status = MPCCStatus.NOT_VERIFIED
        else:
            status = MPCCStatus.NOT_CONVERGED
        return MPCCResult(
            status=status,
            z=points[best],
            w=self.lcp.matrix @ points[best] + self.lcp.offset,
            residual=errors[best],
            iterations=iterations,
            polished=best == 1,
        )

    def _polished(self, z: FloatArray) -> FloatArray | None:
        """Return the point near z where the smaller entry of each pair is exactly zero."""
        if not np.all(np.isfinite(z)):
            return None
        active = z > self.scaled.matrix @ z + self.scaled.offset
        point = np.where(active, z, 0.0)
        if np.any(active):
            # The shortest step keeps to the nearest of many solutions where the block is singular.
            rows = self.scaled.matrix[active]
            defect = rows @ point + self.scaled.offset[active]
            point[active] -= np.linalg.lstsq(rows[:, active], defect, rcond=None)[0]
        return np.maximum(point, 0.0)
