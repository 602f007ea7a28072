"""Complementarity problems over the rationals, and strategies that draw small ones."""

import itertools
from fractions import Fraction

import numpy as np
from hypothesis import strategies as st

from tests.support.drawn import integers


def unique_solution(rows, values):
    """Solve rows x = values over the rationals; None unless there is exactly one solution."""
    table = [
        [*map(Fraction, row), Fraction(value)] for row, value in zip(rows, values, strict=True)
    ]
    unknowns = len(table[0]) - 1
    for k in range(unknowns):
        pivot = next((i for i in range(k, len(table)) if table[i][k] != 0), None)
        if pivot is None:
            return None
        table[k], table[pivot] = table[pivot], table[k]
        table[k] = [entry / table[k][k] for entry in table[k]]
        for i in range(len(table)):
            if i != k:
                table[i] = [a - table[i][k] * b for a, b in zip(table[i], table[k], strict=True)]
    return (
        None if any(row[-1] != 0 for row in table[unknowns:]) else [r[-1] for r in table[:unknowns]]
    )


def exact_vertices(matrix, offset):
    """Return the basic complementary solutions z, and which of them have a full basis.

    The problem is solvable if and only if it has one of these (no line fits into z, w >= 0).
    """
    n = len(offset)
    vertices = {}
    for kinds in itertools.product("wz-", repeat=n):
        basis = [(kind, j) for j, kind in enumerate(kinds) if kind != "-"]
        if basis:
            rows = [
                [int(i == j) if kind == "w" else -matrix[i][j] for kind, j in basis]
                for i in range(n)
            ]
            values = unique_solution(rows, offset)
        else:
            values = [] if not any(offset) else None
        if values is None or any(value < 0 for value in values):
            continue
        z = [Fraction(0)] * n
        for (kind, j), value in zip(basis, values, strict=True):
            z[j] = value if kind == "z" else z[j]
        vertices[tuple(z)] = vertices.get(tuple(z), False) or "-" not in kinds
    return vertices


def among(z, candidates):
    # Not every NumPy compares fractions.
    z, *others = (np.array(c, dtype=float) for c in (z, *candidates))
    return any(np.allclose(z, other, rtol=1e-9, atol=1e-12) for other in others)


orders = st.integers(1, 3)


def entries(count):
    """Return the strategy of lists of a number of integers, from -3 to 3."""
    return integers([range(-3, 4)] * count)


def magnitudes(count):
    """Return the strategy of such lists of many magnitudes, none of which overflow in products."""
    parts = st.tuples(entries(count), integers([range(-9, 10)] * count))
    return parts.map(lambda drawn: [a * 10.0**k for a, k in zip(*drawn, strict=True)])


@st.composite
def problems(draw, sizes=orders, numbers=entries):
    n = draw(sizes)
    drawn = draw(numbers(n * n + n))
    return [drawn[i : i + n] for i in range(0, n * n, n)], drawn[n * n :]


@st.composite
def dominant_problems(draw):
    """Strictly row-dominant matrices with a positive diagonal: P-matrices, rarely symmetric."""
    matrix, offset = draw(problems(st.integers(1, 4)))
    for i, row in enumerate(matrix):
        row[i] = 1 + sum(abs(entry) for j, entry in enumerate(row) if j != i)
    return matrix, offset
