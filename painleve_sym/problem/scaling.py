"""Rows of a problem grouped in parts, and its numbers scaled to order one."""

from __future__ import annotations

import functools
import math
import operator
from typing import NamedTuple

from painleve_sym.problem.constraints import Ball, Constraint, Vector, power_of_two

Placed = tuple[tuple[Ball, int], ...]
"""The balls of a constraint, and the part of each."""


class Layout(NamedTuple):
    """Places of the parts of a problem.

    Attributes
    ----------
    parts : tuple of tuples of int
        The rows of each part.
    row_part : list of int
        The part of each row.
    plain : bool
        Whether each row is the part of its number, as in the plane.
    each : tuple of (Constraint, int, Placed)
        Each constraint with its normal part, and its balls with theirs.
    tangents : tuple of int
        The number of tangential rows of each constraint.
    brakes : tuple of int
        Constraints whose normal row is not one of the problem.
    turning : int
        The number of discs at rest with friction, whose slip begins in any direction.
    """

    parts: tuple[tuple[int, ...], ...]
    row_part: list[int]
    plain: bool
    each: tuple[tuple[Constraint, int, Placed], ...]
    tangents: tuple[int, ...]
    brakes: tuple[int, ...]
    turning: int


# The same few for all states of a mechanism.
@functools.lru_cache(maxsize=256)
def layout_of(constraints: tuple[Constraint, ...]) -> Layout:
    """Return the layout of constraints."""
    parts = list[tuple[int, ...]]()
    each = []
    for constraint in constraints:
        n, balls = len(parts), constraint.balls
        parts += [(constraint.normal,), *(ball.rows for ball in balls)]
        each.append((constraint, n, tuple((ball, n + 1 + k) for k, ball in enumerate(balls))))
    places = {row: k for k, part in enumerate(parts) for row in part}
    row_part = [places[row] for row in range(len(places))]
    plain = parts == [(row,) for row in range(len(places))]
    tangents = tuple(sum(len(ball.rows) for ball in c.balls) for c in constraints)
    firsts = [(c.normal, *(t for ball in c.balls for t in ball.rows)) for c in constraints]
    brakes = tuple(i for i, (normal, *own) in enumerate(firsts) if own and normal > own[0])
    turning = sum(ball.turns for c in constraints for ball in c.balls)
    return Layout(tuple(parts), row_part, plain, tuple(each), tangents, brakes, turning)


def _with_friction(constraint: Constraint, d: Vector) -> Constraint:
    """Return a constraint with the friction coefficients of the scaled rows."""
    unit = d[constraint.normal]
    balls = (ball._replace(mu=ball.mu * d[ball.rows[0]] / unit) for ball in constraint.balls)
    return constraint._replace(balls=tuple(balls))


def scaled(
    W: list[Vector], b: Vector, constraints: tuple[Constraint, ...]
) -> tuple[list[Vector], Vector, tuple[Constraint, ...], Vector, Vector]:
    """Return W, b and the constraints scaled to order one by powers of two, and the units.

    Signs and pieces stay the same. The units are those of forces and of accelerations: by them the
    scaled ones are to be multiplied.
    """
    # ldexp(1, k // 2) is within a factor two of the root of a number near 2**k.
    d = [
        math.ldexp(1.0, math.frexp(row[k])[1] // 2) if row[k] > 0 else 1.0
        for k, row in enumerate(W)
    ]
    layout = layout_of(constraints)
    if not layout.plain:
        for part in layout.parts:
            largest = max(part, key=lambda t: W[t][t])
            for t in part:
                d[t] = d[largest]
    offset = list(map(operator.truediv, b, d))
    largest = max(map(abs, offset))
    size = 2 * power_of_two(largest) if 0 < largest < math.inf else 1.0
    if d.count(d[0]) < len(d):
        constraints = tuple([_with_friction(c, d) for c in constraints])
    return (
        [[w / (e * f) for w, f in zip(row, d, strict=True)] for row, e in zip(W, d, strict=True)],
        [v / size for v in offset],
        constraints,
        [size / e for e in d],
        [size * e for e in d],
    )
