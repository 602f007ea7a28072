"""Solutions of small linear systems as expressions: no pivoting, since no value is known."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import add

import casadi as ca

RIDGE = 1e-8
"""Added to a unit diagonal. Refined twice, it changes a solution by its cube over the eigenvalue's,
and rounding in a singular direction grows by no more than its inverse."""
_REFINEMENTS = 2


def least_solution(matrix: Sequence[Sequence[ca.SX]], right: Sequence[ca.SX]) -> list[ca.SX]:
    """Return the solution of least norm of a symmetric positive semidefinite system.

    The unknowns are scaled to a unit diagonal; then the ridge of Tikhonov's regularisation is
    added, and its effect is taken back by iterated refinement.

    Parameters
    ----------
    matrix : sequence of k sequences of k casadi.SX
        Symmetric; its diagonal is positive.
    right : sequence of k casadi.SX

    References
    ----------
    Riley, Solving systems of linear equations with a positive definite, symmetric, but possibly
    ill-conditioned matrix, Math. Tables Aids Comput. 9 (1955) 96-101.
    """
    size = len(right)
    if size == 1:
        return [right[0] / matrix[0][0]]
    scale = [1 / ca.sqrt(matrix[i][i]) for i in range(size)]
    unit = [
        [matrix[i][j] * scale[i] * scale[j] if i != j else ca.SX(1) for j in range(size)]
        for i in range(size)
    ]
    target = [r * s for r, s in zip(right, scale, strict=True)]
    factor = _factor([[a + (RIDGE if i == j else 0) for j, a in enumerate(r)] for i, r in
                      enumerate(unit)])
    x = _substitute(factor, target)
    for _ in range(_REFINEMENTS):
        rest = [t - _dot(row, x) for t, row in zip(target, unit, strict=True)]
        x = [a + d for a, d in zip(x, _substitute(factor, rest), strict=True)]
    return [a * s for a, s in zip(x, scale, strict=True)]


def solution(matrix: Sequence[Sequence[ca.SX]], right: Sequence[ca.SX]) -> list[ca.SX]:
    """Return the solution of a regular system by Cramer's rule: it needs no pivot."""
    size = len(right)
    whole = determinant(matrix)
    replaced = (
        [[right[i] if j == k else matrix[i][j] for j in range(size)] for i in range(size)]
        for k in range(size)
    )
    return [determinant(m) / whole for m in replaced]


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
