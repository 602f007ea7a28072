"""Inputs of a contact problem: friction, slip velocities, and the constraints that they state."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from painleve_sym.errors import InputError, received
from painleve_sym.problem.array_checks import finite_array
from painleve_sym.problem.complementarity.solution_sets import FloatArray
from painleve_sym.problem.constraints import Ball, Constraint
from painleve_sym.problem.friction_set import Brake, Disc, FrictionSet, Interval

STATED = "ContactProblem cannot be stated, "


# The same few for all states of a mechanism.
@functools.lru_cache(maxsize=512)
def planar(i: int, mu: float, slip: int, bilateral: bool) -> Constraint:
    """Return the constraint of the i-th contact in the plane, with rows n, t."""
    ball = Ball((2 * i + 1,), mu, (float(slip),) if slip else ())
    return Constraint(2 * i, (ball,), not bilateral, (1, -1) if bilateral else (1,))


def pressed(
    W: list[list[float]], b: list[float], brake: FrictionSet, row: int, slip: Sequence[float]
) -> Constraint:
    """Append the row that presses a brake by a known force, and return its constraint.

    Uncoupled, with W_vv F_v + b_v = 0: then no law but that of a contact is needed.
    """
    mobility = W[row][row] or 1.0
    for line in W:
        line.append(0.0)
    W.append([0.0] * len(b) + [mobility])
    b.append(-mobility * brake.mu)
    friction = 1.0 if brake.mu else 0.0
    ball = Ball((row,), friction, brake.direction(slip))
    return Constraint(len(b) - 1, (ball,), False, (1,))


@functools.lru_cache(maxsize=256)
def interval(mu: float) -> tuple[FrictionSet, ...]:
    """Return the friction of a planar contact."""
    return (Interval(mu),)


@functools.lru_cache(maxsize=256)
def disc(mu: float) -> tuple[FrictionSet, ...]:
    """Return the friction of a contact in space."""
    return (Disc(mu),)


def is_brake(own: tuple[FrictionSet, ...]) -> bool:
    """Return whether a contact is a brake alone, without a normal row."""
    return len(own) == 1 and isinstance(own[0], Brake)


def shape_fault(name: str, given: tuple[int, ...], needed: tuple[int, ...], n: int) -> str:
    """Return a sentence for an array that does not fit the contacts."""
    return (
        f"{name}: got shape {given}, need {needed} for {n} contacts. Fix: give rows n, t of W and "
        "b for each contact in the plane, n, t1, t2 in space, and its velocity along the tangents."
    )


def joined(slips: Any) -> tuple[FloatArray, str]:
    """Return slip velocities, which may be sequences of different lengths, as one array."""
    parts = list(slips) if isinstance(slips, list | tuple) else [slips]
    values: list[Any] = []
    for part in parts:
        values += (
            list(part) if isinstance(part, list | tuple | np.ndarray) and np.ndim(part) else [part]
        )
    if any(np.ndim(v) for v in values):
        values = list(np.concatenate([np.ravel(v) for v in values]))
    array, fault = finite_array(values, "slip_velocity")
    return array, fault


def friction_sets(given: Any) -> tuple[tuple[FrictionSet, ...], ...] | None:
    """Return the balls of each contact; None where numbers are given.

    Raises
    ------
    InputError
        For entries that are not sets, and a `Brake` beside another ball.
    """
    if isinstance(given, FrictionSet):
        return ((given,),)
    if not isinstance(given, list | tuple):
        return None
    if not any(isinstance(own, FrictionSet | tuple | list) for own in given):
        return None
    sets = tuple(tuple(own) if isinstance(own, list | tuple) else (own,) for own in given)
    flat = [ball for own in sets for ball in own]
    if not all(isinstance(ball, FrictionSet) for ball in flat):
        raise InputError(
            f"{STATED}friction: got {received(given)}, need an Interval, a Disc, a Brake or a "
            "tuple of balls for each contact. Fix: friction=[Disc(0.5)]."
        )
    if any(len(own) > 1 and any(isinstance(ball, Brake) for ball in own) for own in sets):
        raise InputError(
            f"{STATED}friction: got a Brake beside another ball of one contact. Fix: give it as a "
            "contact of its own, with one row of W."
        )
    return sets
