"""Constraints with friction: the rows of a contact problem, grouped, and the pieces of each law.

A constraint has one normal row and any number of balls of friction. A ball is one tangential row
(an interval) or two (a disc); its force has at most the size μ |F_n| and opposes slip. The normal
row opens (F_n >= 0, a_n >= 0, F_n a_n = 0) or is closed (a_n = 0) with the signs of F_n allowed.

The law of one constraint is piecewise linear but for the slip of a disc that begins at rest, whose
direction is free. A `Piece` is one of its linear parts: the directions that the force may have, the
rows of the acceleration that vanish, and the inequalities in which both may still move.
"""

from __future__ import annotations

import functools
import itertools
import math
from typing import NamedTuple

Vector = list[float]
"""Numbers of a few contacts: Python computes with these faster than NumPy with its arrays."""

_SMALLEST = 2.0**-1000  # of a friction coefficient in a quotient: its inverse is finite


class Ball(NamedTuple):
    """Friction of one constraint along one or two tangential rows.

    Attributes
    ----------
    rows : tuple of int
        Rows of W.
    mu : float
        Radius of the ball for F_n = 1.
    slip : tuple of float
        Unit vector of the slip velocity along the rows; empty at rest.
    """

    rows: tuple[int, ...]
    mu: float
    slip: tuple[float, ...]

    @property
    def turns(self) -> bool:
        """Whether slip begins in a direction that is not given: a disc at rest."""
        return len(self.rows) > 1 and self.mu > 0 and not self.slip


class Constraint(NamedTuple):
    """One normal row with the balls of friction that its force presses.

    Attributes
    ----------
    normal : int
        Row of W.
    balls : tuple of Ball
    opens : bool
        Whether the constraint may lift off: F_n >= 0, a_n >= 0.
    sides : tuple of int
        Signs of F_n while a_n = 0.
    """

    normal: int
    balls: tuple[Ball, ...]
    opens: bool = True
    sides: tuple[int, ...] = (1,)

    @property
    def is_free(self) -> bool:
        """Whether it holds from both sides without friction: an equation with any force."""
        return len(self.sides) > 1 and not any(ball.mu for ball in self.balls)


class Linear(NamedTuple):
    """Coefficients of a linear form by the rows on which it depends."""

    rows: tuple[int, ...]
    values: tuple[float, ...]


class Piece(NamedTuple):
    """One linear part of the law of a constraint.

    Attributes
    ----------
    side : int
        Sign of F_n; 0 where it is 0.
    slips : tuple of (tuple of float or None), one for each ball
        Direction of slip; empty where the ball sticks or has no friction, None where slip begins
        in a direction that is not known: then the piece is not complete.
    directions : tuple of Linear
        The force is a sum of multiples x of these.
    vanishing : tuple of int
        As many rows of a that are 0.
    cone, signs : tuple of Linear
        Forms of the force, and of the acceleration, that are not negative.
    discs : tuple of (int, Ball)
        Sticking balls of two rows, whose force is at most μ |F_n|; the normal row of each.
    """

    side: int
    slips: tuple[tuple[float, ...] | None, ...]
    directions: tuple[Linear, ...] = ()
    vanishing: tuple[int, ...] = ()
    cone: tuple[Linear, ...] = ()
    signs: tuple[Linear, ...] = ()
    discs: tuple[tuple[int, Ball], ...] = ()

    @property
    def turning(self) -> tuple[int, ...]:
        """The balls whose slip begins in a direction that is not known."""
        return tuple(k for k, way in enumerate(self.slips) if way is None)

    @property
    def has_slip(self) -> bool:
        """Whether a ball with friction slips."""
        return any(way is None or way for way in self.slips)


def power_of_two(size: float) -> float:
    """Return the largest power of two that is no larger than a positive number."""
    return math.ldexp(1.0, math.frexp(size)[1] - 1)


# The same few for all states of a mechanism.
@functools.lru_cache(maxsize=512)
def pieces(constraint: Constraint) -> tuple[Piece, ...]:
    """Return the pieces of a constraint's law at zero normal velocity: lift-off, slips, stick."""
    none: tuple[tuple[float, ...] | None, ...] = ((),) * len(constraint.balls)
    n = constraint.normal
    offered = []
    if constraint.opens:
        offered.append(Piece(0, none, signs=(Linear((n,), (1.0,)),)))
    if constraint.is_free:
        # Without friction both signs of F_n obey one law.
        still = tuple(ball.slip for ball in constraint.balls)
        return (pressed(constraint, 1, still)._replace(cone=()),)
    for side in constraint.sides:
        ways = [_ways(ball) for ball in constraint.balls]
        offered += [pressed(constraint, side, chosen) for chosen in itertools.product(*ways)]
    return tuple(offered)


@functools.lru_cache(maxsize=512)
def linear_pieces(constraint: Constraint) -> tuple[Piece, ...]:
    """Return the pieces in which the direction of every slip is known."""
    return tuple(piece for piece in pieces(constraint) if not piece.turning)


STICK: tuple[float, ...] = ()


def _ways(ball: Ball) -> list[tuple[float, ...] | None]:
    """Return the directions in which a pressed ball may slip; the last one is to stick."""
    if ball.slip or not ball.mu:
        return [ball.slip]
    if len(ball.rows) > 1:
        return [None, STICK]
    return [(1.0,), (-1.0,), STICK]


def pressed(
    constraint: Constraint, side: int, chosen: tuple[tuple[float, ...] | None, ...]
) -> Piece:
    """Return the piece with a_n = 0 and the slip `chosen` for each ball.

    The force of a sliding ball follows F_n in one direction; that of a sticking one is free.
    """
    n, balls = constraint.normal, constraint.balls
    sliding = [(b, e) for b, e in zip(balls, chosen, strict=True) if e and b.mu]
    sticking = [
        b
        for b, e in zip(balls, chosen, strict=True)
        if not e and e is not None and b.mu and not b.slip
    ]
    # Along F_n on both sides, so that the determinants of both orient alike.
    size = power_of_two(max(1.0, *(b.mu for b, _ in sliding))) if sliding else 1.0
    rows, values = [n], [1.0 / size]
    signs = []
    for ball, e in sliding:
        rows += ball.rows
        values += [-ball.mu * v * side / size for v in e]
        if not ball.slip:
            signs.append(Linear(ball.rows, e))
    directions = [Linear(tuple(rows), tuple(values))]
    vanishing, cone, discs = [n], [Linear((n,), (float(side),))], []
    for ball in sticking:
        step = max(power_of_two(ball.mu), _SMALLEST)
        edge = side * ball.mu / step
        for t in ball.rows:
            directions.append(Linear((t,), (1.0,)))
        vanishing += ball.rows
        if len(ball.rows) > 1:
            discs.append((n, ball))
            continue
        (t,) = ball.rows
        cone += [Linear((n, t), (edge, 1.0 / step)), Linear((n, t), (edge, -1.0 / step))]
    if len(cone) == 3 and not discs:
        cone = cone[1:]  # the two edges of one interval include F_n >= 0
    return Piece(
        side,
        chosen,
        tuple(directions),
        tuple(vanishing),
        tuple(cone),
        tuple(signs),
        tuple(discs),
    )
