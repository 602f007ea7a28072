"""The law of constraints with friction in units of order one, by which every answer is checked.

Whichever solver gave the forces, the check is the same: the forces without what a solve may have
left of zeros, their accelerations, and the size of both against the scales below.

*Parts.* A part is a normal row, or the rows of one ball, which count by their length: nothing
depends on the choice of the tangents. The part i has the acceleration a_i, the terms
``T_i = sum |W_ij| |F_j| + |b_i|``, and ``beta_i``, the largest |b| among the parts that W couples
with it, directly or by others.

*Zero.* An acceleration is zero where it is below 1e-10 of ``min(T, beta) + 1e-4 max(T, beta)``.
Terms alone would hide an acceleration behind forces that cancel; b alone would ask of large forces
more than their rounding allows. A force is zero where all accelerations that it causes are.

*Infinity.* Forces are rejected whose rounding alone could move an equation that must vanish by more
than b there: they come from a system that is singular but for rounding.

*Equal motions* are compared by the accelerations themselves, never by their terms.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from painleve_sym.problem.complementarity.lcp import RESIDUAL_TOLERANCE
from painleve_sym.problem.complementarity.solution_sets import FloatArray
from painleve_sym.problem.constraints import Ball, Constraint, Vector
from painleve_sym.problem.friction_set import unit_vector
from painleve_sym.problem.rounding import SOLVED
from painleve_sym.problem.scaling import layout_of, scaled

ROUNDING = 1e-14  # of the terms of an acceleration: what a solve may leave of a zero
ZERO = 1e-10  # of the scale of an acceleration
SIGN = 1e-12  # of the scale of an acceleration: what may be missing to its right sign
EQUAL = 1e-8  # of two accelerations; nearer ones are one motion
EDGE = 1e-8  # of the largest friction force, and of an acceleration: nearer is on a border
LEAST_OF_LARGER = 1e-4  # of the larger of T and beta, in the scale
EPSILON = 2.0**-52
INFINITE = 64 * EPSILON  # rounding of the terms of one equation
_TURN_ROUNDING = 4 * EPSILON  # of the length of a ball


class Motion(NamedTuple):
    """Accelerations of some forces.

    Attributes
    ----------
    a : list of float
        By rows.
    lengths, terms : list of float
        |a| and T by parts.
    """

    a: Vector
    lengths: Vector
    terms: Vector


Slips = tuple[tuple[tuple[float, ...], ...], ...]
"""For each constraint, and each of its balls, the unit vector along which it slips; empty where it
sticks or is lifted off."""


class Checked(NamedTuple):
    """Forces that obey the law.

    Attributes
    ----------
    forces : list of float
        By rows.
    slips : Slips
    motion : Motion
    residual : float
    """

    forces: Vector
    slips: Slips
    motion: Motion
    residual: float


class ScaledLaw:
    """W and b scaled to order one by powers of two, and the check of forces by the law.

    Parameters
    ----------
    W : list of r lists of r float
    b : list of r float
    constraints : sequence of Constraint
        With the friction of the problem that is given.

    Attributes
    ----------
    W, b, constraints
        Those of the scaled problem; the rows of one ball share their scale, so that it stays one.
    unit, rate_unit : list of float
        Forces and accelerations of the given problem are those of the scaled one times these, which
        rounds nothing.
    """

    def __init__(self, W: list[Vector], b: Vector, constraints: Sequence[Constraint]) -> None:
        self.W, self.b, self.constraints, self.unit, self.rate_unit = scaled(
            W, b, tuple(constraints)
        )
        self.layout = layout = layout_of(self.constraints)
        self.parts, self.row_part = layout.parts, layout.row_part
        self.plain, self.each = layout.plain, layout.each
        self.part_sizes = self._part_sizes()
        self.offsets = self.lengths(self.b)
        if not self.plain:
            self._tidy()
        # Square roots of mobilities: they make the forces of different parts comparable.
        self.weights = [math.sqrt(row[k]) for k, row in enumerate(self.part_sizes)]

    # ---- sizes ----

    def _part_sizes(self) -> list[Vector]:
        if self.plain:
            return [list(map(abs, row)) for row in self.W]
        return [
            [math.hypot(*[self.W[i][j] for i in p for j in q]) for q in self.parts]
            for p in self.parts
        ]

    def _tidy(self) -> None:
        """Set components to 0 that are rounding where the axes of a disc are turned."""
        at = self.row_part
        for i, row in enumerate(self.W):
            sizes = self.part_sizes[at[i]]
            for j, w in enumerate(row):
                if w and abs(w) <= _TURN_ROUNDING * sizes[at[j]]:
                    row[j] = 0.0
            if abs(self.b[i]) <= _TURN_ROUNDING * self.offsets[at[i]]:
                self.b[i] = 0.0

    @cached_property
    def groups(self) -> list[int]:
        """The number of the group of parts that W couples, of each part."""
        sizes, count = self.part_sizes, len(self.parts)
        group = list(range(count))
        for i in range(count):
            for j in range(i):
                if sizes[i][j] and group[i] != group[j]:
                    old, new = group[i], group[j]
                    group = [new if g == old else g for g in group]
        return group

    @cached_property
    def beta(self) -> Vector:
        """The largest |b| among the parts that W couples with each part."""
        largest = dict.fromkeys(self.groups, 0.0)
        for g, offset in zip(self.groups, self.offsets, strict=True):
            largest[g] = max(largest[g], offset)
        return [largest[g] for g in self.groups]

    @cached_property
    def arrays(self) -> tuple[FloatArray, FloatArray]:
        """W and b as arrays, which nothing changes."""
        return np.array(self.W), np.array(self.b)

    def lengths(self, vector: Sequence[float]) -> Vector:
        """Return the lengths of the parts of a vector by rows."""
        if self.plain:
            return list(map(abs, vector))
        return [math.hypot(*[vector[r] for r in part]) for part in self.parts]

    def terms_of(self, directions: FloatArray) -> FloatArray:
        """Return by rows the sizes of the terms of ``W directions``, shape (r, k)."""
        if self.plain:
            sizes: FloatArray = np.abs(self.arrays[0]) @ np.abs(directions)
            return sizes
        lengths = np.array([np.linalg.norm(directions[list(part)], axis=0) for part in self.parts])
        terms: FloatArray = (np.array(self.part_sizes) @ lengths)[self.row_part]
        return terms

    def motion(self, forces: Vector) -> Motion:
        """Return ``W F + b`` with the size of its terms."""
        rows = [acceleration(row, self.b[k], forces) for k, row in enumerate(self.W)]
        a, terms = [rate for rate, _ in rows], [size for _, size in rows]
        if self.plain:
            return Motion(a, list(map(abs, a)), terms)
        lengths = self.lengths(forces)
        terms = [
            sum(map(operator.mul, row, lengths)) + offset
            for row, offset in zip(self.part_sizes, self.offsets, strict=True)
        ]
        return Motion(a, self.lengths(a), terms)

    def scale(self, k: int, terms: Vector) -> float:
        """Return the size with which the acceleration of a part is compared."""
        T, beta = terms[k], self.beta[k]
        if not beta:  # where no b acts, forces count against forces
            return T
        low, high = (T, beta) if beta > T else (beta, T)
        return low + LEAST_OF_LARGER * high

    def is_zero(self, k: int, length: float, terms: Vector) -> bool:
        """Return whether a length of the acceleration of a part is zero."""
        # No scale is below 1e-4 of the terms, which are quicker to compare with.
        least = ZERO * LEAST_OF_LARGER * terms[k]
        return length <= least or length <= ZERO * self.scale(k, terms)

    def _is_negative(self, k: int, rate: float, terms: Vector) -> bool:
        """Return whether an acceleration has the wrong sign."""
        return rate < 0 and -rate > SIGN * self.scale(k, terms) + 4 * EPSILON * terms[k]

    # ---- residual ----

    def residual(self, forces: Vector, motion: Motion | None = None) -> float:
        """Measure how far forces are from the law, by their terms; free of units and axes."""
        a, _, terms = motion or self.motion(forces)
        if not math.isfinite(sum(terms)):
            return math.inf
        sizes = self.lengths(forces)
        worst = 0.0
        for constraint, n, balls in self.each:
            row = constraint.normal
            normal, leaving = forces[row], ratio(a[row], terms[n])
            held = abs(leaving)
            if constraint.opens:
                if held or normal < 0:
                    weight = self._share(n, sizes[n], terms)
                    held = max(weight if normal < 0 else min(weight, held), -leaving)
            elif len(constraint.sides) == 1 and normal * constraint.sides[0] < 0:
                held = max(held, self._share(n, sizes[n], terms))
            worst = max(worst, held)
            for ball, k in balls:
                limit = ball.mu * abs(normal)
                span = sizes[k] + limit
                opposing = self._opposing(ball, forces, a, limit, span, terms[k])
                worst = max(worst, ratio(sizes[k] - limit, span), opposing)
        return worst

    @staticmethod
    def _opposing(
        ball: Ball, forces: Vector, a: Vector, limit: float, span: float, terms: float
    ) -> float:
        """Return the residual of friction at its limit against the slip, or against a_t at rest."""
        if len(ball.rows) == 1:
            (t,) = ball.rows
            rate = a[t]
            way = ball.slip[0] if ball.slip else (rate > 0) - (rate < 0)
            missed = ratio(abs(forces[t] + way * limit), span)
            return missed if ball.slip else min(missed, ratio(abs(rate), terms))
        (s, t) = ball.rows
        p, q = forces[s], forces[t]
        if ball.slip:
            x, y = ball.slip
            return ratio(math.hypot(p + limit * x, q + limit * y), span)
        size = math.hypot(p, q)
        inside = min(max(ratio(limit - size, span), 0.0), ratio(math.hypot(a[s], a[t]), terms))
        along, across = p * a[s] + q * a[t], abs(p * a[t] - q * a[s])
        return max(inside, ratio(max(along, across), size * terms))

    def _share(self, k: int, size: float, terms: Vector) -> float:
        """Return how much a part of the forces matters to any acceleration, by its terms.

        A force that moves nothing counts as 1.
        """
        if not size:
            return 0.0
        share, moves = 0.0, False
        for row, term in zip(self.part_sizes, terms, strict=True):
            if row[k]:
                moves = True
                if term > 0:
                    share = max(share, row[k] * size / term)
        return share if moves else 1.0

    # ---- check ----

    def check(self, forces: Vector, given: Slips | None = None) -> Checked | None:
        """Return the forces with negligible parts removed, or None if they do not obey the law.

        `given` are the directions of slip for which they were computed, if any.
        """
        best: Checked | None = None
        for candidate in self._candidates(forces):
            slips = given or self._slips(candidate)
            settled = self._settled(candidate, slips)
            motion = self.motion(settled)
            measured = self.residual(settled, motion)
            if best is None or measured < best.residual:
                best = Checked(settled, slips, motion, measured)
            if measured <= ROUNDING:
                break
        if best is None or best.residual > RESIDUAL_TOLERANCE or self._violates(best):
            return None
        return Checked(best.forces, self._named(best), best.motion, best.residual)

    def _violates(self, point: Checked) -> bool:
        """Return whether a row that must vanish does not, or one has the wrong sign."""
        forces, (a, lengths, terms) = point.forces, point.motion
        vanishing: list[tuple[int, float]] = []  # part, and |b| of an equation
        for (constraint, n, balls), slips in zip(self.each, point.slips, strict=True):
            if constraint.opens and forces[constraint.normal] == 0:
                if self._is_negative(n, a[constraint.normal], terms):
                    return True
                continue
            if not self.is_zero(n, lengths[n], terms):
                return True
            vanishing.append((n, self.offsets[n]))
            for (ball, k), e in zip(balls, slips, strict=True):
                if ball.slip or not ball.mu:
                    continue
                if not e:
                    if not self.is_zero(k, lengths[k], terms):
                        return True
                    vanishing.append((k, self.offsets[k]))
                    continue
                if len(ball.rows) == 1:
                    along = a[ball.rows[0]] * e[0]
                else:
                    (s, t), (x, y) = ball.rows, e
                    along = a[s] * x + a[t] * y
                    if not self.is_zero(k, abs(x * a[t] - y * a[s]), terms):
                        return True
                    across = abs(x * self.b[t] - y * self.b[s])
                    across = across if across > ROUNDING * self.offsets[k] else 0.0
                    vanishing.append((k, across))
                if self._is_negative(k, along, terms):
                    return True
        return self._infinite(vanishing, terms)

    def _infinite(self, vanishing: Sequence[tuple[int, float]], terms: Vector) -> bool:
        """Return whether rounding of the forces alone could be all of b in some equations."""
        least = min([offset for _, offset in vanishing if offset], default=math.inf)
        if all([INFINITE * (terms[k] - self.offsets[k]) <= least for k, _ in vanishing]):
            return False
        worst: dict[int, tuple[float, float]] = {}
        for k, offset in vanishing:
            largest, most = worst.get(self.groups[k], (0.0, 0.0))
            moved = INFINITE * (terms[k] - self.offsets[k])
            worst[self.groups[k]] = max(largest, offset), max(most, moved)
        return any(most > largest > 0 for largest, most in worst.values())

    def _candidates(self, forces: Vector) -> Iterator[Vector]:
        """Yield the forces with rounding of zeros removed, and as they are.

        Noise is what is small beside the largest force in comparable units, or whole constraints
        that matter to no acceleration.
        """
        lengths = self.lengths(forces)
        weighted = list(map(operator.mul, self.weights, lengths))
        noise = SOLVED * max(weighted)
        if 0 < min(filter(None, weighted), default=0.0) <= noise:
            yield [
                0.0 if 0 < weighted[self.row_part[row]] <= noise else force
                for row, force in enumerate(forces)
            ]
        yield forces
        terms = self.motion(forces).terms
        kept = list(forces)
        for constraint, n, balls in self.each:
            own = (n, *[k for _, k in balls])
            if all([self._share(k, lengths[k], terms) <= RESIDUAL_TOLERANCE for k in own]):
                self._lift(constraint, kept)
        if kept != forces:
            yield kept

    @staticmethod
    def _lift(constraint: Constraint, forces: Vector) -> None:
        """Remove the forces of a constraint."""
        forces[constraint.normal] = 0.0
        for ball in constraint.balls:
            for t in ball.rows:
                forces[t] = 0.0

    def _slips(self, forces: Vector) -> Slips:
        """Return the directions of slip that the forces show."""
        a = self.motion(forces).a
        slips = []
        for constraint in self.constraints:
            normal, own = forces[constraint.normal], []
            for ball in constraint.balls:
                friction = [forces[t] for t in ball.rows]
                size = math.hypot(*friction)
                inside = size < ball.mu * abs(normal) * (1 - 1e-9)
                e: tuple[float, ...] = ball.slip
                if constraint.opens and normal == 0:
                    e = ()
                elif not e and not inside:
                    opposite = [-f for f in friction] if size else [a[t] for t in ball.rows]
                    e = unit_vector(opposite)
                own.append(e)
            slips.append(tuple(own))
        return tuple(slips)

    def _settled(self, forces: Vector, slips: Slips) -> Vector:
        """Return the forces with F_n >= 0 where a constraint opens, and friction within its ball.

        Friction is on the edge of the ball exactly where it slips.
        """
        settled = list(forces)
        for constraint, own in zip(self.constraints, slips, strict=True):
            normal = forces[constraint.normal]
            if constraint.opens and normal <= 0:
                self._lift(constraint, settled)
                continue
            for ball, e in zip(constraint.balls, own, strict=True):
                limit = ball.mu * abs(normal)
                if len(ball.rows) == 1:
                    (t,) = ball.rows
                    tangential = -limit * e[0] if e else forces[t]
                    settled[t] = min(max(tangential, -limit), limit)
                    continue
                friction = [forces[t] for t in ball.rows]
                if e:
                    friction = [-limit * v for v in e]
                elif (size := math.hypot(*friction)) > limit:
                    friction = [f * (limit / size) for f in friction]
                for t, f in zip(ball.rows, friction, strict=True):
                    settled[t] = f
        return [force + 0.0 for force in settled]  # no -0.0

    def _named(self, point: Checked) -> Slips:
        """Return the directions of slip, borders by convention: without acceleration it sticks.

        Without friction, or where F_n = 0, the acceleration alone shows the direction.
        """
        forces, (a, lengths, terms) = point.forces, point.motion
        named = []
        for (constraint, _, balls), own in zip(self.each, point.slips, strict=True):
            lifted = constraint.opens and forces[constraint.normal] == 0
            slips = []
            for (ball, k), e in zip(balls, own, strict=True):
                way = () if lifted else ball.slip or e
                if not (lifted or ball.slip):
                    if lengths[k] <= (ROUNDING if e else RESIDUAL_TOLERANCE) * terms[k]:
                        way = ()
                    elif not e or len(ball.rows) == 1:
                        way = unit_vector([a[t] for t in ball.rows])
                slips.append(way)
            named.append(tuple(slips))
        return tuple(named)

    # ---- comparison ----

    def same_motion(self, first: Motion, second: Motion) -> bool:
        """Return whether two motions are one; never by their terms, which large forces have."""
        for k, part in enumerate(self.parts):
            p, q = first.a, second.a
            step = max(abs(p[r] - q[r]) for r in part)
            size = max(first.lengths[k], second.lengths[k], self.offsets[k])
            # What elimination leaves of zeros; forces that cancel must not hide an acceleration.
            terms = max(first.terms[k], second.terms[k])
            rounding = 10 * ROUNDING * terms
            if self.beta[k]:
                rounding = min(rounding, ZERO * self.beta[k] + ROUNDING * terms)
            # Where nothing but noise stands, it is that of the rows beside it.
            if step > EQUAL * size + rounding + 2 * EPSILON * self.beta[k]:
                return False
        return True

    def borders(self, point: Checked) -> set[str]:
        """Return the borders on which an answer lies.

        'grazing': a constraint neither presses nor leaves. 'edge': friction at its limit without
        slip, within 1e-8.
        """
        forces, (_, lengths, terms) = point.forces, point.motion
        met = set()
        sizes = self.lengths(forces)
        largest = list(map(max, terms, self.beta))
        for constraint, n, balls in self.each:
            pressing = self._share(n, sizes[n], largest) > EDGE
            if constraint.opens and not pressing and lengths[n] <= EDGE * self.beta[n]:
                met.add("grazing")
            if not pressing:
                continue
            for ball, k in balls:
                if ball.slip or not ball.mu:
                    continue
                near = sizes[k] >= ball.mu * sizes[n] * (1 - EDGE)
                if near and lengths[k] <= EDGE * self.beta[k]:
                    met.add("edge")
        return met


def ratio(part: float, whole: float) -> float:
    """Return part / whole, 0 where there is nothing."""
    return part / whole if whole > 0 else 0.0


def acceleration(row: Vector, free: float, forces: Vector) -> tuple[float, float]:
    """Return a row of ``W F + b``, and the sum of the sizes of its terms."""
    # Term by term, so that one contact has W_nn F_n + W_nt F_t + b_n literally.
    rate = size = 0.0
    for term in map(operator.mul, row, forces):
        rate += term
        size += abs(term)
    return rate + free, size + abs(free)
