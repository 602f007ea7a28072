"""Rows of a problem grouped in parts, and its numbers scaled to order one."""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Sequence
from typing import NamedTuple

from painleve_sym.problem.constraints import Constraint, Vector, power_of_two


class Layout(NamedTuple):
    """Places of the parts of a problem.

    Attributes
    ----------
    parts : tuple of tuples of int
        The rows of each part.
    normals : tuple of int, one for each constraint
    balls : tuple of tuples of int, one for each constraint
        Its normal part, and the parts of its balls.
    row_part : list of int
        The part of each row.
    plain : bool
        Whether each row is the part of its number, as in the plane.
    """

    parts: tuple[tuple[int, ...], ...]
    normals: tuple[int, ...]
    balls: tuple[tuple[int, ...], ...]
    row_part: list[int]
    plain: bool


# The same few for all states of a mechanism.
@functools.lru_cache(maxsize=256)
def layout_of(rows: tuple[tuple[int, tuple[tuple[int, ...], ...]], ...]) -> Layout:
    """Return the layout of constraints by their normal rows and the rows of their balls."""
    parts, normals, balls = list[tuple[int, ...]](), list[int](), list[tuple[int, ...]]()
    for normal, own in rows:
        normals.append(len(parts))
        balls.append(tuple(range(len(parts) + 1, len(parts) + 1 + len(own))))
        parts += [(normal,), *own]
    places = {row: k for k, part in enumerate(parts) for row in part}
    row_part = [places[row] for row in range(len(places))]
    plain = parts == [(row,) for row in range(len(places))]
    return Layout(tuple(parts), tuple(normals), tuple(balls), row_part, plain)


def _with_friction(constraint: Constraint, d: Vector) -> Constraint:
    """Return a constraint with the friction coefficients of the scaled rows."""
    unit = d[constraint.normal]
    if all(d[ball.rows[0]] == unit for ball in constraint.balls):
        return constraint
    balls = (ball._replace(mu=ball.mu * d[ball.rows[0]] / unit) for ball in constraint.balls)
    return constraint._replace(balls=tuple(balls))


def scaled(
    W: list[Vector], b: Vector, constraints: Sequence[Constraint]
) -> tuple[list[Vector], Vector, tuple[Constraint, ...], Vector]:
    """Return W, b and the constraints scaled to order one by powers of two, and the unit.

    Signs and pieces stay the same. Forces F' of the scaled problem are ``unit * F'`` of the
    given one.
    """
    # ldexp(1, k // 2) is within a factor two of the root of a number near 2**k.
    d = [
        math.ldexp(1.0, math.frexp(row[k])[1] // 2) if row[k] > 0 else 1.0
        for k, row in enumerate(W)
    ]
    for constraint in constraints:
        for ball in constraint.balls:
            if len(ball.rows) > 1:
                largest = max(W[t][t] for t in ball.rows)
                own = math.ldexp(1.0, math.frexp(largest)[1] // 2) if largest > 0 else 1.0
                for t in ball.rows:
                    d[t] = own
    offset = list(map(operator.truediv, b, d))
    largest = max(map(abs, offset))
    size = 2 * power_of_two(largest) if 0 < largest < math.inf else 1.0
    with_friction = tuple(_with_friction(c, d) for c in constraints)
    return (
        [[w / (e * f) for w, f in zip(row, d, strict=True)] for row, e in zip(W, d, strict=True)],
        [v / size for v in offset],
        with_friction,
        [size / e for e in d],
    )
