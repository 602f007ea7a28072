"""Lemke's complementary pivots: one solution of a linear complementarity problem of any size.

References
----------
Lemke (1965); Cottle, Pang & Stone (1992), "CPS" below.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
import numpy.typing as npt

from painleve_sym.blas_threads import one_blas_thread
from painleve_sym.equality import Compared
from painleve_sym.errors import Explained
from painleve_sym.problem.complementarity.lcp import (
    LCP,
    RESIDUAL_TOLERANCE,
    LCPSolution,
    cleaned,
    equilibrate,
    principal_block,
    solution_at,
)
from painleve_sym.problem.complementarity.solution_sets import FloatArray

_PIVOT = 1e-11  # smaller entries of a scaled tableau are what elimination left of a zero
_TIE = 1e-12  # ratios closer than this are equal; the lexicographic rule then decides


class LemkeStatus(Explained):
    """End of Lemke's method; `sentence` explains it and names a remedy."""

    SOLVED = ("solved", "the solution has been checked; solve_all tells whether there are others")
    RAY = (
        "ray",
        "the pivots ended on an unbounded ray. For a copositive-plus matrix the problem has no "
        "feasible point, for a P-matrix this cannot happen; for any other matrix a solution may "
        "still exist: ask solve_all",
    )
    STEP_LIMIT = ("step_limit", "max_pivots was used up; raise max_pivots or ask solve_all")
    NOT_VERIFIED = (
        "not_verified",
        "the last basis is too ill-conditioned: its solution fails the residual check; rescale "
        "the data or ask solve_all",
    )


Solution = TypeVar("Solution")


@dataclass(frozen=True, eq=False)
class LemkeResult(Compared, Generic[Solution]):
    """Report one run of Lemke's method: its end, the solution if there is one, the pivots used."""

    status: LemkeStatus
    solution: Solution | None
    pivots: int


@one_blas_thread()
def solve_lemke(
    lcp: LCP, max_pivots: int | None = None, tol: float = RESIDUAL_TOLERANCE
) -> LemkeResult[LCPSolution]:
    """Find one solution by complementary pivots (Lemke 1965; CPS section 4.4).

    ``w = M z + d z_0 + q`` with d of ones starts from a z_0 that makes all w >= 0 and pivots until
    z_0 leaves. Ties are broken lexicographically, so that no basis returns (CPS section 4.9). The
    solution is computed again from the last basis and checked against `tol`, never read off the
    tableau. Without `max_pivots` the most pivots are 50 per pair, far above the few per pair that
    are usual.
    """
    scaled, unit = equilibrate(lcp)
    status, point, pivots = pivot(scaled, 50 * lcp.size if max_pivots is None else max_pivots, tol)
    solution = None if point is None else solution_at(lcp, scaled, unit, point)
    return LemkeResult(status, solution, pivots)


def pivot(scaled: LCP, limit: int, tol: float) -> tuple[LemkeStatus, FloatArray | None, int]:
    """Run the pivots on an equilibrated problem; return the end, the checked z and the count."""
    n = scaled.size
    if np.all(scaled.offset >= 0):
        return LemkeStatus.SOLVED, np.zeros(n), 0
    # Columns 0..n-1 belong to w, n..2n-1 to z, 2n to z_0; the last holds the values.
    table = np.column_stack([np.eye(n), -scaled.matrix, -np.ones(n), scaled.offset])
    basis = np.arange(n)
    row = _lexicographic_row(table, np.ones(n), np.arange(n), basis)
    entering = 2 * n
    for pivots in range(1, limit + 1):
        leaving, basis[row] = int(basis[row]), entering
        _eliminate(table, row, entering)
        if leaving == 2 * n:
            point = cleaned(scaled, _basis_point(scaled, basis[basis >= n] - n), tol)
            status = LemkeStatus.NOT_VERIFIED if point is None else LemkeStatus.SOLVED
            return status, point, pivots
        entering = leaving + n if leaving < n else leaving - n
        rows = np.flatnonzero(table[:, entering] > _PIVOT)
        if rows.size == 0:
            return LemkeStatus.RAY, None, pivots
        row = _lexicographic_row(table, table[:, entering], rows, basis)
    return LemkeStatus.STEP_LIMIT, None, limit


def _eliminate(table: FloatArray, row: int, column: int) -> None:
    """Make the column zero in all rows but one, where it becomes one; in place.

    Columns in which that row is zero stay as they are, as most do at first.
    """
    table[row] /= table[row, column]
    factor = table[:, column].copy()
    factor[row] = 0.0
    changed = np.flatnonzero(table[row])
    table[:, changed] -= factor[:, None] * table[row, changed]


def _basis_point(lcp: LCP, index: npt.NDArray[np.intp]) -> FloatArray:
    """Return z with ``w = 0`` in the rows of `index` (least squares where these are singular)."""
    z = np.zeros(lcp.size)
    if index.size:
        block, goal = principal_block(lcp.matrix, index), -lcp.offset[index]
        x = np.linalg.lstsq(block, goal, rcond=None)[0]
        # One refinement: each equation to the rounding of its own terms, see solve_refined.
        z[index] = x + np.linalg.lstsq(block, goal - block @ x, rcond=None)[0]
    return z


def _lexicographic_row(
    table: FloatArray, column: FloatArray, rows: npt.NDArray[np.intp], basis: npt.NDArray[np.intp]
) -> int:
    """Return the row whose values, then inverse-basis entries, by the pivot come first in order."""
    n = table.shape[0]
    for key in (-1, *range(n)):
        ratio = table[rows, key] / column[rows]
        rows = rows[ratio <= ratio.min() + _TIE * max(1.0, abs(ratio.min()))]
        if key == -1 and np.any(basis[rows] == 2 * n):
            return int(rows[basis[rows] == 2 * n][0])  # z_0 may leave: that is a solution
        if rows.size == 1:
            break
    return int(rows[0])
