"""Solution sets of linear equations with inequalities: a point, a segment, a ray, a wider face.

One branch of a piecewise linear problem asks for ``block x = goal`` with ``rows x + start >= 0``.
A regular block leaves one point; a singular one leaves a point, a segment, a ray, a wider face or
nothing at all. All quantities are meant to be scaled to order one.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

RANK = 1e-14  # per row, on entries scaled to order one: some 50 roundings
_FACE = 1e-10  # widths and defects of a face, on quantities scaled to order one; HiGHS' best
_EXTENT = 1e-8  # least extent of a face, above the tolerance of the LP solver


def solve_refined(block: FloatArray, goal: FloatArray) -> FloatArray:
    """Solve regular systems ``block x = goal``, each equation to the rounding of its own terms.

    Elimination leaves errors in proportion to the largest terms of the whole system. One step of
    refinement makes the error of every equation that of its own terms (Skeel 1980), which the check
    of an answer by shares needs where unknowns differ by orders of magnitude. Shapes (..., k, k)
    and (..., k).
    """
    if goal.shape[-1] == 1:
        return goal / block[..., 0]
    x = np.linalg.solve(block, goal[..., None])
    defect = goal[..., None] - block @ x
    return (x + np.linalg.solve(block, defect))[..., 0]


def solve_two(
    block: Sequence[Sequence[float]], goal: Sequence[float], least: float
) -> list[float] | None:
    """Solve one system of two equations as `solve_refined` does, number by number.

    None for a block whose smallest singular value is not above `least`.
    """
    (a, b), (c, d) = block
    determinant, square = a * d - b * c, a * a + b * b + c * c + d * d
    # The singular values have this product, and this sum of squares.
    rest = math.sqrt(max(square * square - 4 * determinant * determinant, 0.0))
    largest = math.sqrt((square + rest) / 2)
    if not abs(determinant) > least * largest:
        return None
    first, second = (0, 1) if abs(a) >= abs(c) else (1, 0)
    (p, q), (r, s) = block[first], block[second]
    factor = r / p
    pivot = s - factor * q

    def eliminated(g: float, h: float) -> tuple[float, float]:
        y = (h - factor * g) / pivot
        return (g - q * y) / p, y

    x, y = eliminated(goal[first], goal[second])
    defects = [goal[k] - (block[k][0] * x + block[k][1] * y) for k in (first, second)]
    dx, dy = eliminated(*defects)
    return [x + dx, y + dy]


def affine_face(
    block: FloatArray,
    goal: FloatArray,
    rows: FloatArray,
    start: FloatArray,
    size: int,
) -> tuple[FloatArray, BoolArray] | None:
    """Return one x with ``block x = goal`` and ``rows x + start >= 0``, and what varies around it.

    The inequalities are used only where the block, with entries of order one, is singular: they
    bound the face. The point of a regular block is returned unchecked, since its check is that of
    the whole problem, whose number of rows is `size`: roundings are in proportion to it.

    The first result is a point inside the face where it has an inside, the second tells which
    entries differ somewhere on the face. None is returned for a face that is empty.
    """
    fixed: BoolArray = np.zeros(goal.size, np.bool_)
    if goal.size == 0:
        return np.zeros(0), fixed
    left, stretch, right = np.linalg.svd(block)
    rank = int(np.sum(stretch > RANK * size))
    if rank == goal.size:
        return solve_refined(block, goal), fixed
    if np.any(np.abs(left[:, rank:].T @ goal) > _FACE * np.max(np.abs(goal))):
        return None
    x = right[:rank].T @ (left[:, :rank].T @ goal / stretch[:rank])
    x += right[:rank].T @ (left[:, :rank].T @ (goal - block @ x) / stretch[:rank])
    null = right[rank:].T
    # On this face x = (the point so far) + null t, and each inequality bounds t.
    slope, level = rows @ null, rows @ x + start
    inside = _interval(slope[:, 0], level) if null.shape[1] == 1 else _wide(slope, level)
    if inside is None:
        return None
    t, ways = inside
    point: FloatArray = x + null @ t
    moving: BoolArray = np.any(np.abs(null @ ways) > _EXTENT, axis=1)
    return point, moving


def _interval(slope: FloatArray, start: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Return a middle point of ``{t : start + slope t >= 0}`` and, as columns, its extent."""
    up, down = slope > _FACE, slope < -_FACE
    level = ~up & ~down
    low = float(np.max(-start[up] / slope[up], initial=-np.inf))
    high = float(np.min(-start[down] / slope[down], initial=np.inf))
    slack = _FACE * (1.0 + float(np.max(np.abs(start))))
    if np.any(start[level] < -slack) or low > high + slack:
        return None
    if np.isinf(low) or np.isinf(high):
        # A half line (z >= 0 forbids a whole one): one scaled unit away from its end.
        return np.array([low + 1.0 if np.isinf(high) else high - 1.0]), np.ones((1, 1))
    return np.array([(low + high) / 2]), np.array([[max(high - low, 0.0)]])


def _wide(slope: FloatArray, start: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Do the same for several unknowns t."""
    slack = _FACE * (1.0 + float(np.max(np.abs(start))))
    # Rows without slope restrict no t; kept, they would only hide the inside of the face.
    level = np.all(np.abs(slope) <= _FACE, axis=1)
    if np.any(start[level] < -slack):
        return None
    return _polytope(slope[~level], start[~level], slack)


def _polytope(
    slope: FloatArray, start: FloatArray, slack: float
) -> tuple[FloatArray, FloatArray] | None:
    """Do it by linear programs, for rows that all have a slope."""
    from scipy.optimize import linprog  # needed for doubly singular blocks only

    count = slope.shape[1]
    tight = {"primal_feasibility_tolerance": _FACE, "dual_feasibility_tolerance": _FACE}
    # Deepest point: the largest common margin, at most one scaled unit.
    deepest = linprog(
        np.append(np.zeros(count), -1.0),
        A_ub=np.column_stack([-slope, np.ones(start.size)]),
        b_ub=start,
        bounds=[(None, None)] * count + [(None, 1.0)],
        options=tight,
    )
    if deepest.x is None or deepest.x[-1] < -slack:
        return None
    t = np.asarray(deepest.x[:-1], dtype=float)
    if deepest.x[-1] > slack:
        return t, np.eye(count)
    # A face without inside may still be a segment or ray: go one unit along each t both ways.
    ends = np.tile(t, (2 * count, 1))
    box = [(value - 1.0, value + 1.0) for value in t]
    for k, (axis, sign) in enumerate(itertools.product(range(count), (1.0, -1.0))):
        goal = np.where(np.arange(count) == axis, sign, 0.0)
        end = linprog(goal, A_ub=-slope, b_ub=start + slack, bounds=box, options=tight)
        ends[k] = t if end.x is None else end.x
    middle = ends.mean(axis=0)
    return middle, (ends - middle).T
