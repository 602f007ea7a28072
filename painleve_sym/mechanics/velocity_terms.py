"""A formula at one point as a polynomial in the velocities: checks without differentiating it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import sympy as sp

Terms = dict[tuple[int, ...], float]
"""Coefficients by the indices of their velocities, in order: () for what has none."""

_DEGREE = 2
_QUICK: dict[type[sp.Basic], Callable[..., float]] = {sp.sin: math.sin, sp.cos: math.cos}
"""What SymPy would take long for."""
_CLEARLY = 1e-6
"""A pivot above this part of the diagonal is not a sum of rounding errors."""


class _NotSeen(Exception):
    """The formula is not such a polynomial as it is written."""


def velocity_terms(
    expr: sp.Expr, velocities: Sequence[sp.Symbol], point: Mapping[sp.Symbol, sp.Expr]
) -> Terms | None:
    """Return the terms of degree 0, 1 and 2 in the velocities at a point.

    The point has numbers for all other symbols. None where the formula, as it is written, does not
    show that it is such a polynomial: it may be one all the same.
    """
    known: dict[sp.Basic, Terms] = {v: {(i,): 1.0} for i, v in enumerate(velocities)}
    known |= {s: {(): float(value)} for s, value in point.items()}
    try:
        return _terms(sp.sympify(expr), known)
    except _NotSeen:
        return None


def _terms(expr: sp.Expr, known: dict[sp.Basic, Terms]) -> Terms:
    terms = known.get(expr)
    if terms is None:
        terms = known[expr] = _combined(expr, [_terms(a, known) for a in expr.args])
    return terms


def _combined(expr: sp.Expr, parts: list[Terms]) -> Terms:
    if expr.is_Add:
        total: Terms = {}
        for part in parts:
            for key, value in part.items():
                total[key] = total.get(key, 0.0) + value
        return total
    if expr.is_Mul:
        return _product(parts)
    if expr.is_Pow and expr.exp in (1, 2):
        return _product([parts[0]] * int(expr.exp))
    if any(key for part in parts for key in part):
        raise _NotSeen
    number = _value(expr, [part.get((), 0.0) for part in parts])
    if not math.isfinite(number):
        raise _NotSeen
    return {(): number}


def _value(expr: sp.Expr, arguments: list[float]) -> float:
    quick = _QUICK.get(expr.func)
    if quick and all(map(math.isfinite, arguments)):
        return quick(*arguments)
    value = expr.func(*map(sp.Float, arguments)) if arguments else expr
    if not value.is_number:
        raise _NotSeen
    try:
        return float(value)
    except TypeError as error:  # a number that is not real
        raise _NotSeen from error


def _product(parts: list[Terms]) -> Terms:
    total: Terms = {(): 1.0}
    for part in parts:
        longer: Terms = {}
        for left, a in total.items():
            for right, b in part.items():
                key = tuple(sorted(left + right))
                if len(key) > _DEGREE:
                    raise _NotSeen
                longer[key] = longer.get(key, 0.0) + a * b
        total = longer
    return total


def clearly_positive(terms: Terms, n: int) -> bool:
    """Return whether the terms of degree 2 in n velocities are positive, far beyond rounding."""
    matrix = [[0.0] * n for _ in range(n)]
    for (i, j), value in ((k, v) for k, v in terms.items() if len(k) == 2):
        matrix[i][j] += value
        matrix[j][i] += value
    diagonal = [matrix[k][k] for k in range(n)]
    for k in range(n):
        pivot = matrix[k][k]
        if not pivot > _CLEARLY * diagonal[k] > 0:
            return False
        for i in range(k + 1, n):
            factor = matrix[i][k] / pivot
            matrix[i] = [a - factor * b for a, b in zip(matrix[i], matrix[k], strict=True)]
    return True
