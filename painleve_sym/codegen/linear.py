"""Solutions of small linear systems as expressions: no pivoting, since no value is known."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import add

import casadi as ca

RIDGE = 1e-9
"""Of the sum of the diagonal, added to it where a matrix may be singular. Refined twice it
changes a solution by the cube of its part of an eigenvalue; rounding in a singular
direction grows by its inverse."""
_ROUNDING = 1e-5
"""Part of what the unknowns may be, far above their rounding in a singular direction."""
_REFINEMENTS = 2
_NOTHING = 1e-90

Matrix = Sequence[Sequence[ca.SX]]


def least_solution(matrix: Matrix, right: Matrix, weights: Sequence[ca.SX]) -> list[list[ca.SX]]:
    """Return a solution of a symmetric positive semidefinite system that may be singular.

    With x = D z, D the diagonal of `weights`, it solves (A D + ρ) z = r: Tikhonov's regularisation,
    whose effect is taken back by iterated refinement. Where the system does not determine the
    unknowns, they are shared in proportion to `weights`; an unknown of no weight is 0. In such a
    direction z has rounding, amplified by 1/ρ. Its part there, v = ρ² (A D + ρ)⁻² z, is taken off
    of a single right side where it is small beside 1: what the system demands there is not.

    The diagonal of A is positive. `weights` has the sizes that the unknowns may have, not negative;
    where it is empty, the inverse of the diagonal: equal shares, in its units, with their rounding.

    References
    ----------
    Riley (1955).
    """
    size = len(right)
    if size == 1:
        return [[r / matrix[0][0] for r in right[0]]]
    d = list(weights) or [1 / matrix[i][i] for i in range(size)]
    ridge = RIDGE * reduce(add, (matrix[i][i] * d[i] for i in range(size))) + _NOTHING
    scaled = [[matrix[i][j] * d[j] for j in range(size)] for i in range(size)]
    factor = _factor(scaled, ridge)
    columns = []
    for k in range(len(right[0])):
        target = [right[i][k] for i in range(size)]
        z = _substitute(factor, target)
        for _ in range(_REFINEMENTS):
            rest = [t - _dot(row, z) for t, row in zip(target, scaled, strict=True)]
            z = [a + b for a, b in zip(z, _substitute(factor, rest), strict=True)]
        if weights and len(right[0]) == 1:
            v = z
            for _ in range(_REFINEMENTS):
                v = _substitute(factor, [ridge * a for a in v])
            z = _without_rounding(z, d, v)
        columns.append([a * b for a, b in zip(d, z, strict=True)])
    return [list(row) for row in zip(*columns, strict=True)]


def _without_rounding(z: list[ca.SX], d: list[ca.SX], v: list[ca.SX]) -> list[ca.SX]:
    """Return z less its part v that is not determined, where that is below `_ROUNDING`."""
    small = _ROUNDING**2 * reduce(add, d)
    size = _dot(d, [a * a for a in v])
    part = small**2 / (small**2 + size**2 + _NOTHING)
    return [a - part * b for a, b in zip(z, v, strict=True)]


def solution(
    matrix: Matrix, right: Sequence[ca.SX], scales: Sequence[ca.SX]
) -> tuple[list[ca.SX], ca.SX]:
    """Return the solution of a general system, and its determinant with rows of unit scale.

    Up to two unknowns by Cramer's rule. Of more, whose system may be singular (three feet of one
    body carry forces that are not determined), the solution of least norm. `scales` are the sizes
    of each row and column, positive.
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
        factor = _factor(normal, ca.SX(RIDGE))
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


def _factor(matrix: list[list[ca.SX]], ridge: ca.SX) -> list[list[ca.SX]]:
    """Return L (unit lower triangle) and U of L U = matrix + ridge · identity, in one matrix."""
    size, lu = len(matrix), [list(row) for row in matrix]
    for i in range(size):
        lu[i][i] = lu[i][i] + ridge
    for j in range(size):
        for i in range(j + 1, size):
            lu[i][j] = lu[i][j] / lu[j][j]
            for k in range(j + 1, size):
                lu[i][k] = lu[i][k] - lu[i][j] * lu[j][k]
    return lu


def _substitute(lu: list[list[ca.SX]], right: Sequence[ca.SX]) -> list[ca.SX]:
    x = list(right)
    for i in range(len(x)):
        for k in range(i):
            x[i] = x[i] - lu[i][k] * x[k]
    for i in reversed(range(len(x))):
        for k in range(i + 1, len(x)):
            x[i] = x[i] - lu[i][k] * x[k]
        x[i] = x[i] / lu[i][i]
    return x


def _dot(row: Sequence[ca.SX], x: Sequence[ca.SX]) -> ca.SX:
    return reduce(add, (a * b for a, b in zip(row, x, strict=True)))
