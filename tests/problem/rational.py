"""Planar contact problems over the rationals: every motion, and how open its forces are.

Each choice of pieces is a polyhedron; equations are eliminated, inequalities by Fourier and
Motzkin. Nothing is rounded.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

Row = tuple[Fraction, ...]
"""Coefficients of an inequality, with its constant last: the sum is not negative."""

_ZERO, _ONE = Fraction(0), Fraction(1)


class Exact(NamedTuple):
    """The case of a problem, whether a continuum of motions exists, and the motions otherwise.

    Each motion has whether its forces are open.
    """

    case: str
    moves: bool
    motions: dict[Row, bool]


class _Piece(NamedTuple):
    directions: list[list[Fraction]]
    vanishing: list[int]
    cone: list[list[Fraction]]
    signs: list[tuple[int, int]]


def solutions_of(
    W: Sequence[Sequence[int]],
    b: Sequence[int],
    mu: Sequence[Fraction],
    slip: Sequence[int],
    closed: Sequence[bool],
) -> Exact:
    """Solve a problem of contacts with rows n, t each."""
    size = len(b)
    offered = [
        _pieces(size, 2 * i, Fraction(m), s, c)
        for i, (m, s, c) in enumerate(zip(mu, slip, closed, strict=True))
    ]
    motions: dict[Row, list[_Range]] = {}
    for chosen in itertools.product(*offered):
        ranges = _ranges(W, b, chosen)
        if ranges is None:
            continue
        accelerations, forces = ranges
        if any(r.open for r in accelerations):
            return Exact("indeterminate", True, {})
        motion = tuple(r.low for r in accelerations)
        known = motions.get(motion)
        motions[motion] = forces if known is None else list(map(_joined, known, forces))
    is_open = {motion: any(r.open for r in forces) for motion, forces in motions.items()}
    if not motions:
        return Exact("inconsistent", False, {})
    if len(motions) > 1:
        return Exact("indeterminate", False, is_open)
    return Exact("hyperstatic" if any(is_open.values()) else "unique", False, is_open)


def _pieces(size: int, n: int, mu: Fraction, s: int, closed: bool) -> list[_Piece]:
    def vector(normal: Fraction, tangential: Fraction) -> list[Fraction]:
        row = [_ZERO] * size
        row[n], row[n + 1] = normal, tangential
        return row

    pieces = [] if closed else [_Piece([], [], [], [(n, 1)])]
    for side in (1, -1) if closed else (1,):
        ways = [s] if s else [1, -1] if mu else [0]
        for way in ways:
            signs = [(n + 1, way)] if not s and mu else []
            force, cone = vector(_ONE, -mu * way * side), [vector(Fraction(side), _ZERO)]
            pieces.append(_Piece([force], [n], cone, signs))
        if not s and mu:
            cone = [vector(mu * side, _ONE), vector(mu * side, -_ONE)]
            free = [vector(_ONE, _ZERO), vector(_ZERO, _ONE)]
            pieces.append(_Piece(free, [n, n + 1], cone, []))
    return pieces


class _Range(NamedTuple):
    """Least and largest value; None where there is none."""

    low: Fraction | None
    high: Fraction | None

    @property
    def open(self) -> bool:
        return self.low is None or self.low != self.high


def _joined(one: _Range, other: _Range) -> _Range:
    lows, highs = (one.low, other.low), (one.high, other.high)
    return _Range(
        None if None in lows else min(lows),  # type: ignore[type-var]
        None if None in highs else max(highs),  # type: ignore[type-var]
    )


def _ranges(W, b, chosen: Sequence[_Piece]) -> tuple[list[_Range], list[_Range]] | None:
    """Return the ranges of all accelerations and forces of a choice; None where it is empty."""
    size = len(b)
    G = [g for piece in chosen for g in piece.directions]
    vanishing = [row for piece in chosen for row in piece.vanishing]
    rates = [[_dot(W[i], g) for g in G] for i in range(size)]
    solved = _eliminated([rates[v] for v in vanishing], [-Fraction(b[v]) for v in vanishing])
    if solved is None:
        return None
    x, null = solved

    def over(row: Sequence[Fraction], constant: Fraction) -> Row:
        return (*(_dot(row, v) for v in null), _dot(row, x) + constant)

    rows = []
    for piece in chosen:
        for form in piece.cone:
            rows.append(over([_dot(form, g) for g in G], _ZERO))
        for i, s in piece.signs:
            rows.append(over([s * rate for rate in rates[i]], Fraction(s * b[i])))
    polyhedron = _without(rows, 0)
    if polyhedron is None:
        return None
    accelerations = [_range(over(rates[i], Fraction(b[i])), rows) for i in range(size)]
    forces = [_range(over([g[i] for g in G], _ZERO), rows) for i in range(size)]
    return accelerations, forces


def _dot(p: Sequence[Fraction], q: Sequence[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(p, q, strict=True)), _ZERO)


def _eliminated(
    A: Sequence[Sequence[Fraction]], c: Sequence[Fraction]
) -> tuple[list[Fraction], list[list[Fraction]]] | None:
    """Return a solution of ``A x = c`` and a basis of the null space; None without solution."""
    count = len(A[0]) if A else 0
    M = [[*row, value] for row, value in zip(A, c, strict=True)]
    pivots: list[int] = []
    for column in range(count):
        row = next((i for i in range(len(pivots), len(M)) if M[i][column]), None)
        if row is None:
            continue
        at = len(pivots)
        M[at], M[row] = M[row], M[at]
        M[at] = [v / M[at][column] for v in M[at]]
        for i, other in enumerate(M):
            if i != at and other[column]:
                M[i] = [v - other[column] * w for v, w in zip(other, M[at], strict=True)]
        pivots.append(column)
    if any(row[-1] and not any(row[:-1]) for row in M):
        return None
    x = [_ZERO] * count
    for i, column in enumerate(pivots):
        x[column] = M[i][-1]
    null = []
    for free in sorted(set(range(count)) - set(pivots)):
        v = [_ZERO] * count
        v[free] = _ONE
        for i, column in enumerate(pivots):
            v[column] = -M[i][free]
        null.append(v)
    return x, null


def _without(rows: Sequence[Row], kept: int) -> list[Row] | None:
    """Return the inequalities of the first variables alone; None where they contradict."""
    known = _reduced(rows)
    count = len(rows[0]) - 1 if rows else kept
    for column in range(count - 1, kept - 1, -1):
        if known is None:
            return None
        up = [r for r in known if r[column] > 0]
        down = [r for r in known if r[column] < 0]
        lower = [r[:column] + r[column + 1 :] for r in known if not r[column]]
        for p, q in itertools.product(up, down):
            sums = tuple(x * -q[column] + y * p[column] for x, y in zip(p, q, strict=True))
            lower.append(sums[:column] + sums[column + 1 :])
        known = _reduced(lower)
    return known


def _reduced(rows: Sequence[Row]) -> list[Row] | None:
    """Return the sharpest inequality of each direction; None for a false one."""
    sharpest: dict[Row, Fraction] = {}
    for *coefficients, constant in rows:
        largest = max(map(abs, coefficients), default=_ZERO)
        if not largest:
            if constant < 0:
                return None
            continue
        way = tuple(v / largest for v in coefficients)
        sharpest[way] = min(sharpest.get(way, constant / largest), constant / largest)
    return [(*way, constant) for way, constant in sharpest.items()]


def _range(form: Row, rows: Sequence[Row]) -> _Range:
    """Return the range of a form over the inequalities, which do not contradict."""
    *slope, level = form
    if not any(slope):
        return _Range(level, level)
    equal = [(_ONE, *(-v for v in slope), -level), (-_ONE, *slope, level)]
    ends = _without([*((_ZERO, *row) for row in rows), *equal], 1) or []
    lows = [-r[1] / r[0] for r in ends if r[0] > 0]
    highs = [-r[1] / r[0] for r in ends if r[0] < 0]
    return _Range(max(lows, default=None), min(highs, default=None))
