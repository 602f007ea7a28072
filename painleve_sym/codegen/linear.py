"""Solutions of small linear systems as expressions: no pivoting, since no value is known."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import add

import casadi as ca

RIDGE = 1e-9
"""Added to a unit diagonal of a matrix that may be singular. Refined twice, it changes a solution
by its cube over that of the eigenvalue; rounding in a singular direction grows by its inverse."""
LARGEST_RATIO = 1e3
"""By which the ridge of one unknown may be larger than RIDGE."""
_REFINEMENTS = 2
_NOTHING = 1e-90

Matrix = Sequence[Sequence[ca.SX]]


def least_solution(matrix: Matrix, right: Matrix, ease: Sequence[ca.SX]) -> list[list[ca.SX]]:
    """Return the solution of least norm of a symmetric positive semidefinite system.

    The unknowns are scaled to a unit diagonal; then a ridge is added as in Tikhonov's
    regularisation, and its effect is taken back by iterated refinement. Where the system does not
    determine the unknowns, they are shared in proportion to `ease`.

    Parameters
    ----------
    matrix : k rows of k casadi.SX
        Symmetric; its diagonal is positive.
    right : k rows of m casadi.SX
    ease : sequence of k casadi.SX
        Not negative; empty for equal shares.

    Returns
    -------
    list of k rows of m casadi.SX

    References
    ----------
    Riley, Solving systems of linear equations with a positive definite, symmetric, but possibly
    ill-conditioned matrix, Math. Tables Aids Comput. 9 (1955) 96-101.
    """
    size = len(right)
    if size == 1:
        return [[r / matrix[0][0] for r in right[0]]]
    scale = [1 / ca.sqrt(matrix[i][i]) for i in range(size)]
    unit = [
        [matrix[i][j] * scale[i] * scale[j] if i != j else ca.SX(1) for j in range(size)]
        for i in range(size)
    ]
    ridge = [ca.SX(RIDGE)] * size
    if ease:
        total = reduce(add, ease) + _NOTHING
        ridge = [RIDGE * total / (e + total / LARGEST_RATIO + _NOTHING) for e in ease]
    factor = _factor(
        [[a + (ridge[i] if i == j else 0) for j, a in enumerate(r)] for i, r in enumerate(unit)]
    )
    columns = []
    for k in range(len(right[0])):
        target = [right[i][k] * scale[i] for i in range(size)]
        x = _substitute(factor, target)
        for _ in range(_REFINEMENTS):
            rest = [t - _dot(row, x) for t, row in zip(target, unit, strict=True)]
            x = [a + d for a, d in zip(x, _substitute(factor, rest), strict=True)]
        columns.append([a * s for a, s in zip(x, scale, strict=True)])
    return [list(row) for row in zip(*columns, strict=True)]


def solution(
    matrix: Matrix, right: Sequence[ca.SX], scales: Sequence[ca.SX]
) -> tuple[list[ca.SX], ca.SX]:
    """Return the solution of a general system, and its determinant with rows of unit scale.

    Up to two unknowns by Cramer's rule. Of more, whose system may be singular (three feet of one
    body carry forces that are not determined), the solution of least norm.

    Parameters
    ----------
    matrix : k rows of k casadi.SX
    right : sequence of k casadi.SX
    scales : sequence of k casadi.SX
        Size of each row and column, positive.
    """
    size = len(right)
    root = [ca.sqrt(s) for s in scales]
    unit = [[matrix[i][j] / (root[i] * root[j]) for j in range(size)] for i in range(size)]
    target = [r / s for r, s in zip(right, root, strict=True)]
    if size <= 2:
        whole = determinant(unit)
        replaced = (
            [[target[i] if j == k else unit[i][j] for j in range(size)] for i in range(size)]
            for k in range(size)
        )
        x = [determinant(m) / whole for m in replaced]
    else:
        whole = ca.SX(1)
        normal = [[_dot(a, b) for b in unit] for a in unit]
        factor = _factor(
            [[a + (RIDGE if i == j else 0) for j, a in enumerate(r)] for i, r in enumerate(normal)]
        )
        x = [ca.SX(0)] * size
        for _ in range(_REFINEMENTS + 1):
            rest = [t - _dot(row, x) for t, row in zip(target, unit, strict=True)]
            y = _substitute(factor, rest)
            x = [x[j] + _dot([unit[i][j] for i in range(size)], y) for j in range(size)]
    return [a / r for a, r in zip(x, root, strict=True)], whole


def determinant(matrix: Sequence[Sequence[ca.SX]]) -> ca.SX:
    """Return the determinant by minors of the last rows, each computed once."""
    size = len(matrix)
    minors: dict[tuple[int, ...], ca.SX] = {(): ca.SX(1)}
    for row in reversed(range(size)):
        larger: dict[tuple[int, ...], ca.SX] = {}
        for columns, minor in minors.items():
            for j in range(size):
                if j in columns:
                    continue
                chosen = tuple(sorted((*columns, j)))
                sign = -1 if chosen.index(j) % 2 else 1
                term = sign * matrix[row][j] * minor
                larger[chosen] = larger[chosen] + term if chosen in larger else term
        minors = larger
    return minors[tuple(range(size))]


def _factor(matrix: list[list[ca.SX]]) -> tuple[list[list[ca.SX]], list[ca.SX]]:
    """Return L (unit lower triangle) and D of L D L' = matrix."""
    size = len(matrix)
    lower = [[ca.SX(0)] * size for _ in range(size)]
    diagonal: list[ca.SX] = []
    for j in range(size):
        d = matrix[j][j]
        for k in range(j):
            d = d - lower[j][k] ** 2 * diagonal[k]
        diagonal.append(d)
        for i in range(j + 1, size):
            entry = matrix[i][j]
            for k in range(j):
                entry = entry - lower[i][k] * lower[j][k] * diagonal[k]
            lower[i][j] = entry / d
    return lower, diagonal


def _substitute(
    factor: tuple[list[list[ca.SX]], list[ca.SX]], right: Sequence[ca.SX]
) -> list[ca.SX]:
    lower, diagonal = factor
    x = list(right)
    for i in range(len(x)):
        for k in range(i):
            x[i] = x[i] - lower[i][k] * x[k]
    x = [a / d for a, d in zip(x, diagonal, strict=True)]
    for i in reversed(range(len(x))):
        for k in range(i + 1, len(x)):
            x[i] = x[i] - lower[k][i] * x[k]
    return x


def _dot(row: Sequence[ca.SX], x: Sequence[ca.SX]) -> ca.SX:
    return reduce(add, (a * b for a, b in zip(row, x, strict=True)))
