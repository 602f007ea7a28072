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
    unit : list of float
        Forces of the given problem are those of the scaled one times this, which rounds nothing.
    """

    def __init__(self, W: list[Vector], b: Vector, constraints: Sequence[Constraint]) -> None:
        self.given = W, b
        self.W, self.b, self.constraints, self.unit = scaled(W, b, constraints)
        rows = tuple((c.normal, tuple(ball.rows for ball in c.balls)) for c in constraints)
        self.parts, self.normals, self.balls, self.row_part, self.plain = layout_of(rows)
        self.part_sizes = self._part_sizes()
        self.offsets = self.lengths(self.b)
        if not self.plain:
            self._tidy()
        # Square roots of mobilities: they make the forces of different parts comparable.
        self.weights = [math.sqrt(row[k]) for k, row in enumerate(self.part_sizes)]

    # ---- sizes ----

    def _part_sizes(self) -> list[Vector]:
        if self.plain:
            return [[abs(w) for w in row] for row in self.W]
        return [
            [math.hypot(*(self.W[i][j] for i in p for j in q)) for q in self.parts]
            for p in self.parts
        ]

    def _tidy(self) -> None:
        """Remove what rounding leaves of zeros where the axes of a disc are turned."""
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

    def lengths(self, vector: Sequence[float]) -> Vector:
        """Return the lengths of the parts of a vector by rows."""
        if self.plain:
            return [abs(v) for v in vector]
        return [
            abs(vector[p[0]]) if len(p) == 1 else math.hypot(*(vector[r] for r in p))
            for p in self.parts
        ]

    def terms_of(self, directions: FloatArray) -> FloatArray:
        """Return by rows the sizes of the terms of ``W directions``, shape (r, k)."""
        if self.plain:
            sizes: FloatArray = np.abs(np.array(self.W)) @ np.abs(directions)
            return sizes
        lengths = np.array([np.linalg.norm(directions[list(part)], axis=0) for part in self.parts])
        terms: FloatArray = (np.array(self.part_sizes) @ lengths)[self.row_part]
        return terms

    def motion(self, forces: Vector) -> Motion:
        """Return ``W F + b`` with the size of its terms."""
        a, terms = accelerations(self.W, self.b, forces)
        if self.plain:
            return Motion(a, [abs(v) for v in a], terms)
        lengths = self.lengths(forces)
        terms = [
            sum(map(operator.mul, row, lengths)) + offset
            for row, offset in zip(self.part_sizes, self.offsets, strict=True)
        ]
        return Motion(a, self.lengths(a), terms)

    def scale(self, terms: Sequence[float]) -> Vector:
        """Return by part what an acceleration is compared with."""
        scales = []
        for T, beta in zip(terms, self.beta, strict=True):
            if not beta:  # where no b acts, forces count against forces
                scales.append(T)
                continue
            low, high = (T, beta) if beta > T else (beta, T)
            scales.append(low + LEAST_OF_LARGER * high)
        return scales

    def is_zero(self, motion: Motion) -> list[bool]:
        """Return which parts of a motion are zero."""
        return [
            length <= ZERO * size
            for length, size in zip(motion.lengths, self.scale(motion.terms), strict=True)
        ]

    # ---- residual ----

    def residual(self, forces: Vector, motion: Motion | None = None) -> float:
        """Measure how far forces are from the law, by their terms; free of units and axes."""
        a, _, terms = motion or self.motion(forces)
        if not math.isfinite(sum(terms)):
            return math.inf
        sizes = self.lengths(forces)
        weights = self._share([abs(v) for v in sizes], terms, rows=self.normals)
        worst = 0.0
        for i, constraint in enumerate(self.constraints):
            n = self.normals[i]
            row = constraint.normal
            normal, leaving = forces[row], ratio(a[row], terms[n])
            held = abs(leaving)
            if constraint.opens:
                held = max(weights[i] if normal < 0 else min(weights[i], held), -leaving, 0.0)
            elif len(constraint.sides) == 1 and normal * constraint.sides[0] < 0:
                held = max(held, weights[i])
            worst = max(worst, held)
            for ball, k in zip(constraint.balls, self.balls[i], strict=True):
                limit = ball.mu * abs(normal)
                span = sizes[k] + limit
                cone = ratio(sizes[k] - limit, span)
                opposing = self._opposing(ball, forces, a, limit, span, terms[k])
                worst = max(worst, cone, opposing)
        return worst

    @staticmethod
    def _opposing(
        ball: Ball, forces: Vector, a: Vector, limit: float, span: float, terms: float
    ) -> float:
        """Return what friction misses of its limit against the slip, or against a_t at rest."""
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

    def _share(self, part: Vector, terms: Vector, rows: Sequence[int] | None = None) -> Vector:
        """Return how much each part of the forces matters to any acceleration, by its terms.

        With `rows` only of the parts there. A force that moves nothing counts as 1.
        """
        shares = []
        pairs = list(zip(self.part_sizes, terms, strict=True))
        for k in range(len(part)) if rows is None else rows:
            value, share, moves = part[k], 0.0, False
            for row, size in pairs:
                w = row[k]
                if w:
                    moves = True
                    if size > 0:
                        own = w * value / size
                        if own > share:
                            share = own
            if not moves and value > 0:
                share = 1.0
            shares.append(share)
        return shares

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
                tidy = [force + 0.0 for force in settled]  # no -0.0
                best = Checked(tidy, slips, motion, measured)
            if measured <= ROUNDING:
                break
        if best is None or best.residual > RESIDUAL_TOLERANCE or self._violates(best):
            return None
        return Checked(best.forces, self._named(best), best.motion, best.residual)

    def _violates(self, point: Checked) -> bool:
        """Return whether a row that must vanish does not, or one has the wrong sign."""
        forces, (a, lengths, terms) = point.forces, point.motion
        scales = _Scales(self, terms)
        vanishing: list[tuple[int, float, float]] = []  # part, |b| and terms but b of an equation
        for i, constraint in enumerate(self.constraints):
            n = self.normals[i]
            if constraint.opens and forces[constraint.normal] == 0:
                if scales.is_negative(a[constraint.normal], n):
                    return True
                continue
            if scales.is_not_zero(lengths[n], n):
                return True
            vanishing.append((n, self.offsets[n], terms[n] - self.offsets[n]))
            for ball, k, e in zip(constraint.balls, self.balls[i], point.slips[i], strict=True):
                if ball.slip or not ball.mu:
                    continue
                if not e:
                    if scales.is_not_zero(lengths[k], k):
                        return True
                    vanishing.append((k, self.offsets[k], terms[k] - self.offsets[k]))
                    continue
                along = sum(a[t] * v for t, v in zip(ball.rows, e, strict=True))
                if scales.is_negative(along, k):
                    return True
                if len(ball.rows) > 1:
                    (s, t), (x, y) = ball.rows, e
                    if scales.is_not_zero(abs(x * a[t] - y * a[s]), k):
                        return True
                    across = abs(x * self.b[t] - y * self.b[s])
                    across = across if across > ROUNDING * self.offsets[k] else 0.0
                    vanishing.append((k, across, terms[k] - self.offsets[k]))
        return self._infinite(vanishing)

    def _infinite(self, vanishing: Sequence[tuple[int, float, float]]) -> bool:
        """Return whether rounding of the forces alone could be all of b in some equations."""
        worst: dict[int, tuple[float, float]] = {}
        if all(size * INFINITE <= offset for _, offset, size in vanishing):
            return False
        for k, offset, size in vanishing:
            largest, moved = worst.get(self.groups[k], (0.0, 0.0))
            worst[self.groups[k]] = max(largest, offset), max(moved, size)
        return any(INFINITE * moved > largest > 0 for largest, moved in worst.values())

    def _candidates(self, forces: Vector) -> Iterator[Vector]:
        """Yield the forces without what a solve may have left of zeros, and as they are.

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
        share = self._share(lengths, self.motion(forces).terms)
        kept = list(forces)
        for i, constraint in enumerate(self.constraints):
            n = self.normals[i]
            if all(share[k] <= RESIDUAL_TOLERANCE for k in (n, *self.balls[i])):
                kept[constraint.normal] = 0.0
                for ball in constraint.balls:
                    for t in ball.rows:
                        kept[t] = 0.0
        if kept != forces:
            yield kept

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
                    e = direction(opposite)
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
                settled[constraint.normal] = 0.0
                for ball in constraint.balls:
                    for t in ball.rows:
                        settled[t] = 0.0
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
        return settled

    def _named(self, point: Checked) -> Slips:
        """Return the directions of slip, borders by convention: without acceleration it sticks.

        Without friction, or where F_n = 0, the acceleration alone shows the direction.
        """
        forces, (a, lengths, terms) = point.forces, point.motion
        named = []
        for i, (constraint, own) in enumerate(zip(self.constraints, point.slips, strict=True)):
            lifted = constraint.opens and forces[constraint.normal] == 0
            slips = []
            for ball, k, e in zip(constraint.balls, self.balls[i], own, strict=True):
                way = e
                if lifted:
                    way = ()
                elif ball.slip:
                    way = ball.slip
                elif e or lengths[k] > RESIDUAL_TOLERANCE * terms[k]:
                    still = lengths[k] <= ROUNDING * terms[k]
                    if still:
                        way = ()
                    elif not e or len(ball.rows) == 1:
                        way = direction([a[t] for t in ball.rows])
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
        share = self._share(
            self.lengths(forces), [max(t, b) for t, b in zip(terms, self.beta, strict=True)]
        )
        for i, constraint in enumerate(self.constraints):
            n, normal = self.normals[i], forces[constraint.normal]
            pressing = share[n] > EDGE
            if constraint.opens and not pressing and lengths[n] <= EDGE * self.beta[n]:
                met.add("grazing")
            if not pressing:
                continue
            for ball, k in zip(constraint.balls, self.balls[i], strict=True):
                if ball.slip or not ball.mu:
                    continue
                size = math.hypot(*(forces[t] for t in ball.rows))
                near = size >= ball.mu * abs(normal) * (1 - EDGE)
                if near and lengths[k] <= EDGE * self.beta[k]:
                    met.add("edge")
        return met


class _Scales:
    """The scales of some accelerations, computed where their terms alone do not decide."""

    def __init__(self, law: ScaledLaw, terms: Vector) -> None:
        self.law, self.terms = law, terms
        self.scales: Vector = []

    def _of(self, k: int) -> float:
        self.scales = self.scales or self.law.scale(self.terms)
        return self.scales[k]

    def is_not_zero(self, length: float, k: int) -> bool:
        """Return whether an acceleration is more than zero; no scale is below 1e-4 of its terms."""
        least = ZERO * LEAST_OF_LARGER * self.terms[k]
        return length > least and length > ZERO * self._of(k)

    def is_negative(self, rate: float, k: int) -> bool:
        """Return whether an acceleration has the wrong sign."""
        return rate < 0 and -rate > SIGN * self._of(k) + 4 * EPSILON * self.terms[k]


def direction(vector: Sequence[float]) -> tuple[float, ...]:
    """Return the unit vector along a vector; empty for 0."""
    largest = max(map(abs, vector))
    if largest == 0:
        return ()
    parts = [v / largest for v in vector]  # neither overflow nor underflow in their squares
    length = math.hypot(*parts)
    return tuple(v / length for v in parts)


def ratio(part: float, whole: float) -> float:
    """Return part / whole, 0 where there is nothing."""
    return part / whole if whole > 0 else 0.0


def accelerations(W: list[Vector], b: Vector, forces: Vector) -> tuple[Vector, Vector]:
    """Return ``W F + b``, and the sum of the sizes of the terms of each entry."""
    # Term by term, so that one contact has W_nn F_n + W_nt F_t + b_n literally.
    rates, sizes = [], []
    for row, free in zip(W, b, strict=True):
        rate = size = 0.0
        for term in map(operator.mul, row, forces):
            rate += term
            size += abs(term)
        rates.append(rate + free)
        sizes.append(size + abs(free))
    return rates, sizes
