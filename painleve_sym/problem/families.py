"""Choices of pieces whose system is singular: no forces, one motion, or a continuum of motions.

A choice asks for ``x`` with ``V (W G x + b) = 0`` and inequalities, where the columns of G are the
directions of its forces and V takes the rows that vanish. Where V W G is singular, x is open along
its null space; whether the motion is open with it is a question of W G alone.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from painleve_sym.problem.complementarity.solution_sets import RANK, FloatArray
from painleve_sym.problem.constraints import STICK, Piece, Vector, pressed
from painleve_sym.problem.faces import Cone, Face, ForceSet
from painleve_sym.problem.law import ZERO, Motion, ScaledLaw

RANGE = 1e-12  # of b: what may be missing to the range of a singular matrix
_MOVES = 1e-10  # of an acceleration by a force of order one; zeros are below 1e-14
_ONE = 1e-9  # of a line of motions: signs leave a point of it
_HOLDS = 1e-9  # of the forces: they are those of a choice


def forces_by(chosen: Sequence[Piece], size: int) -> FloatArray:
    """Return the directions of the forces of pieces, as columns."""
    directions = [way for piece in chosen for way in piece.directions]
    G = np.zeros((size, len(directions)))
    for k, (rows, values) in enumerate(directions):
        for row, value in zip(rows, values, strict=True):
            G[row, k] = value
    return G


def _forms(
    chosen: Sequence[Piece], G: FloatArray, rates: FloatArray, b: FloatArray
) -> tuple[FloatArray, FloatArray, tuple[Cone, ...]]:
    """Return the inequalities of pieces by x: rows, start, and the discs that stick.

    Forces are ``G x`` and accelerations ``rates x + b``.
    """
    rows, start, cones = list[FloatArray](), list[float](), list[Cone]()
    for piece in chosen:
        for at, values in piece.cone:
            rows.append(np.array(values) @ G[list(at)])
            start.append(0.0)
        for at, values in piece.signs:
            rows.append(np.array(values) @ rates[list(at)])
            start.append(float(np.array(values) @ b[list(at)]))
        for n, ball in piece.discs:
            cones.append(Cone(piece.side * G[n], G[list(ball.rows)], ball.mu))
    return np.array(rows).reshape(len(rows), G.shape[1]), np.array(start), tuple(cones)


class Family:
    """The forces of one choice of pieces whose system is singular.

    Parameters
    ----------
    law : ScaledLaw
        Of the problem, with one row for each that may vanish.
    chosen : sequence of Piece
        One for each constraint.
    across : sequence of int
        Rows that vanish as well: those across a slip that begins.
    """

    def __init__(self, law: ScaledLaw, chosen: Sequence[Piece], across: Sequence[int] = ()) -> None:
        self.law, self.chosen = law, chosen
        self.W, self.b = law.arrays
        self.G = forces_by(chosen, len(self.b))
        self.rows = [row for piece in chosen for row in piece.vanishing] + list(across)
        # What rounding leaves of a coupling would decide the rank.
        self.rates = self.W @ self.G
        terms = law.terms_of(self.G)
        self.rates[np.abs(self.rates) <= 8 * np.finfo(float).eps * terms] = 0.0
        self.block = self.rates[self.rows]

    @cached_property
    def _parts(self) -> tuple[FloatArray | None, FloatArray]:
        """A solution x of the equations, None where there is none, and their null space."""
        size = self.block.shape[1]
        if not size:  # nothing presses, and nothing vanishes
            return np.zeros(0), np.zeros((0, 0))
        left, stretch, right = np.linalg.svd(self.block, full_matrices=True)
        rank = int((stretch > RANK * len(self.b)).sum())
        goal = -self.b[self.rows]
        null: FloatArray = right[rank:].T
        missed = np.abs(left[:, rank:].T @ goal)
        if (missed > RANGE * np.abs(goal).max(initial=0.0)).any():
            return None, null
        left, stretch, right = left[:, :rank], stretch[:rank], right[:rank]
        x = right.T @ (left.T @ goal / stretch)
        x += right.T @ (left.T @ (goal - self.block @ x) / stretch)
        return x, null

    @property
    def reached(self) -> bool:
        """Whether b lies in the range of the singular matrix."""
        return self._parts[0] is not None

    @property
    def moves(self) -> bool:
        """Whether forces that the equations leave open change an acceleration."""
        null = self._parts[1]
        return bool(null.shape[1]) and bool(np.abs(self.rates @ null).max() > _MOVES)

    def only_motion(self) -> Motion | None:
        """Return the only motion that the equations and the signs of accelerations admit.

        None where there may be others: signs that leave one motion of a line of them, but for
        rounding, are those of slips that exclude each other.
        """
        x, null = self._parts
        assert x is not None
        if not self.moves:
            return self.law.motion(self.forces)
        moved = self.rates @ null
        _, stretch, right = np.linalg.svd(moved, full_matrices=False)
        if len(stretch) > 1 and stretch[1] > _MOVES:
            return None
        along = moved @ right[0]
        low, high, start = -math.inf, math.inf, self.rates @ x + self.b
        for piece in self.chosen:
            for rows, values in piece.signs:
                at = list(rows)
                slope, level = float(np.dot(values, along[at])), float(np.dot(values, start[at]))
                if slope > _MOVES:
                    low = max(low, -level / slope)
                elif slope < -_MOVES:
                    high = min(high, -level / slope)
        middle = (low + high) / 2
        if not math.isfinite(middle) or abs(high - low) > _ONE * max(1.0, abs(middle)):
            return None
        forces: Vector = (self.G @ (x + middle * (null @ right[0]))).tolist()
        return self.law.motion(forces)

    @property
    def forces(self) -> Vector:
        """Forces that solve the equations, without the inequalities."""
        x, _ = self._parts
        assert x is not None
        forces: Vector = (self.G @ x).tolist()
        return forces

    def inside(self) -> tuple[Vector, bool] | None:
        """Return forces well inside the inequalities, and whether the motion is open around them.

        None where no forces fulfil them.
        """
        x, null = self._parts
        if x is None:
            return None
        rows, start, cones = _forms(self.chosen, self.G, self.rates, self.b)
        face = ForceSet(x, null, rows, start, cones).inside()
        if face is None:
            return None
        span = face.span
        moves = bool(span.shape[1]) and bool(np.max(np.abs(self.rates @ span)) > _MOVES)
        forces: Vector = (self.G @ face.point).tolist()
        return forces, moves

    def at_infinity(self) -> bool:
        """Whether a neighbouring problem has forces of any size along the null space.

        Only a slip makes this a border: a stress that contacts hold among each other is not.
        """
        null = self._parts[1]
        if self.reached or not any(piece.has_slip for piece in self.chosen) or not null.shape[1]:
            return False
        rows, _, cones = _forms(self.chosen, self.G, self.rates, self.b)
        for side in (1.0, -1.0) if null.shape[1] == 1 else (1.0,):
            slope = rows @ null
            moving = np.max(np.abs(slope), axis=1, initial=0.0) > _MOVES
            if null.shape[1] == 1:
                x = side * null[:, 0]
                levels = [*(rows @ x), *(-cone.excess(x) for cone in cones)]
                if min(levels, default=0.0) >= -_MOVES:
                    return True
            elif ForceSet(
                np.zeros(len(null)), null, rows[moving], -np.ones(int(moving.sum())), cones
            ).inside():
                return True
        return False

    def contains(self, forces: Vector, motion: Motion) -> bool:
        """Return whether forces with this motion are one of the family, its borders included."""
        law, point = self.law, np.array(forces)
        x = np.linalg.lstsq(self.G, point, rcond=None)[0] if self.G.shape[1] else np.zeros(0)
        size = float(np.max(np.abs(point), initial=0.0))
        if np.max(np.abs(self.G @ x - point), initial=0.0) > _HOLDS * size:
            return False
        scales = [law.scale(k, motion.terms) for k in law.row_part]
        if any(abs(motion.a[row]) > ZERO * scales[row] for row in self.rows):
            return False
        for piece in self.chosen:
            for form in piece.cone:
                if (
                    sum(v * forces[r] for r, v in zip(form.rows, form.values, strict=True))
                    < -_HOLDS * size
                ):
                    return False
            for form in piece.signs:
                rate = sum(v * motion.a[r] for r, v in zip(form.rows, form.values, strict=True))
                if rate < -_HOLDS * scales[form.rows[0]]:
                    return False
            for n, ball in piece.discs:
                friction = math.hypot(*(forces[t] for t in ball.rows))
                if friction > ball.mu * abs(forces[n]) + _HOLDS * size:
                    return False
        return True


def forces_of_motion(law: ScaledLaw, motion: Motion) -> tuple[Vector, int] | None:
    """Return the shortest forces with a motion, and in how many directions they are open.

    The set is convex: the accelerations alone say what each constraint may do. A part that leaves
    has no force, one that slips has friction at its limit, and one at rest has any within its ball.
    Lengths count in units of the mobilities, so that neither units nor axes choose. A closed
    constraint with friction has one set for each sign of F_n. None where there are none.
    """
    zero = [law.is_zero(k, length, motion.terms) for k, length in enumerate(motion.lengths)]
    sides = list[tuple[int, ...]]()
    for constraint, n, _ in law.each:
        if not zero[n]:
            sides.append((0,))
        elif len(constraint.sides) > 1 and not any(ball.mu for ball in constraint.balls):
            sides.append((2,))  # either sign, which no friction tells apart
        else:
            sides.append(constraint.sides)
    points, dimension = list[FloatArray](), 0
    for chosen in itertools.product(*sides):
        face, G = _of_sides(law, motion, zero, chosen)
        if face is not None:
            points.append(G @ face.point)
            dimension = max(dimension, face.span.shape[1])
    if not points:
        return None
    weights = np.array([law.weights[part] or 1.0 for part in law.row_part])
    sizes = [float(np.linalg.norm(weights * point)) for point in points]
    shortest: Vector = points[int(np.argmin(np.round(sizes, 12)))].tolist()
    apart = max(float(np.max(np.abs(weights * (p - points[0])))) for p in points)
    largest = max(max(sizes), max(law.offsets, default=0.0))
    return shortest, max(dimension, int(apart > _MOVES * largest))


def _of_sides(
    law: ScaledLaw, motion: Motion, zero: Sequence[bool], sides: Sequence[int]
) -> tuple[Face | None, FloatArray]:
    """Return the forces of a motion for given signs of F_n, and the map to forces by rows."""
    chosen = []
    for (constraint, _, balls), side in zip(law.each, sides, strict=True):
        if not side:
            if not constraint.opens:
                return None, np.zeros((0, 0))
            continue
        ways = []
        for ball, k in balls:
            if ball.slip or not ball.mu:
                ways.append(ball.slip)
            elif zero[k]:
                ways.append(STICK)
            else:
                a = [motion.a[t] for t in ball.rows]
                length = math.hypot(*a)
                ways.append(tuple(v / length for v in a))
        piece = pressed(constraint, 1 if side == 2 else side, tuple(ways))
        chosen.append(piece._replace(cone=() if side == 2 else piece.cone, signs=()))
    weights = np.array([law.weights[part] or 1.0 for part in law.row_part])
    G = forces_by(chosen, len(law.b))
    lengths = np.linalg.norm(weights[:, None] * G, axis=0)
    G = G / np.where(lengths > 0, lengths, 1.0)
    block, goal = law.arrays[0] @ G, np.array(motion.a) - law.arrays[1]
    scales = np.array([law.scale(k, motion.terms) for k in law.row_part])
    base, null = _least_squares(block, goal, ZERO * scales)
    if base is None:
        return None, G
    return ForceSet(base, null, *_forms(chosen, G, block, goal)).shortest(), G


def _least_squares(
    block: FloatArray, goal: FloatArray, least: FloatArray
) -> tuple[FloatArray | None, FloatArray]:
    """Return the shortest x with ``block x = goal``, and the null space.

    None for x where more than `least` is missing.
    """
    size = block.shape[1]
    if not size:
        return (np.zeros(0) if np.all(np.abs(goal) <= least) else None), np.zeros((0, 0))
    left, stretch, right = np.linalg.svd(block, full_matrices=True)
    rank = int(np.sum(stretch > _MOVES))
    null: FloatArray = right[rank:].T
    x = right[:rank].T @ (left[:, :rank].T @ goal / stretch[:rank])
    x += right[:rank].T @ (left[:, :rank].T @ (goal - block @ x) / stretch[:rank])
    return (x if np.all(np.abs(block @ x - goal) <= least) else None), null
