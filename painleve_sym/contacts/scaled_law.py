"""The law of planar contacts in units of order one, by which forces are checked.

Every answer passes the same check, whichever solver gave it: its forces without what a solve may
have left of zeros, their accelerations, and the residual of both. Signs are those of
`ContactProblem`.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from painleve_sym.complementarity.lcp import RESIDUAL_TOLERANCE
from painleve_sym.complementarity.solution_sets import BoolArray, FloatArray
from painleve_sym.contact_rows import ContactRows
from painleve_sym.contacts.local_mode import (
    CONTACT_LIMIT,
    ContactMode,
    ModeProduct,
    Vector,
    local_modes,
    power_of_two,
    sign_of,
    slip_mode,
)
from painleve_sym.contacts.solution import ContactSolution

ROUNDING = 1e-14  # of the terms of an acceleration: what a solve may leave of a zero
SIGN = 1e-12  # of the terms of an acceleration: what may be missing to its right sign
_ROUND_OFF = 1e-13  # of the largest force: what a solve may leave of a zero, if the residual agrees
_NEAR = 1e-6  # part of the largest force; forces farther apart are not compared by row
DISTINCT = 1e-8  # of the terms of every acceleration; nearer solutions are one, met in two modes
_MANY_MODES = 4**CONTACT_LIMIT


class _Checked(NamedTuple):
    """2 n scaled forces that passed the check, with their modes and residual."""

    forces: Vector
    modes: tuple[ContactMode, ...]
    residual: float

    @property
    def largest(self) -> float:
        """Return the size of the largest force."""
        return max(map(abs, self.forces))


class ScaledLaw:
    """The problem scaled to order one by powers of two, and the check of its answers.

    Forces here are those of the problem over `unit`, which rounds nothing. All is computed number
    by number: for the few contacts that a problem has, calls of NumPy take ten times as long.

    `given` are W and b of the problem, `directions` the signs of its slip velocities, `modes` the
    local modes of its contacts and `product` all choices of them. `weights` make forces comparable:
    the root of each mobility. `least` is the least normal force of each contact, at which it opens:
    0, or -inf where it holds from both sides.
    """

    def __init__(
        self,
        W: FloatArray,
        b: FloatArray,
        mu: FloatArray,
        directions: Sequence[int],
        bilateral: BoolArray,
    ) -> None:
        self.given: tuple[list[Vector], Vector] = W.tolist(), b.tolist()
        self.directions = directions
        self.W, self.b, self.mu, self.unit = _scale_contacts(*self.given, mu.tolist())
        held = bilateral.tolist()
        self.least = [-math.inf if both else 0.0 for both in held]
        self.modes = list(map(local_modes, self.mu, self.directions, held))
        self.product = ModeProduct(self.W, self.b, self.modes)
        self._pairs = self.product.pairs
        self._normals = [n for n, _ in self._pairs]
        self.weights = [math.sqrt(row[k]) for k, row in enumerate(self.W)]

    def solutions(self) -> tuple[ContactSolution, ...]:
        """Return every solution of the problem; see `ContactProblem.solutions`."""
        checked, wide = list[_Checked](), list[tuple[int, ...]]()
        for point in self.product.points():
            answer = self._check(point.forces, point.choice)
            if answer is None:
                continue
            if point.wide:
                wide.append(point.choice)
            twin = self._twin(answer, checked)
            if twin is None:
                checked.append(answer)
            elif answer.residual < checked[twin].residual:
                checked[twin] = answer
        return tuple(
            self._solution(answer, not (wide and _any_holds(wide, self._possible(answer.forces))))
            for answer in _ordered(checked)
        )

    def solution_of(self, forces: FloatArray) -> ContactSolution | None:
        """Return forces of the problem as a solution, or None where they fail the check."""
        answer = self._check((forces / self.unit).tolist())
        return None if answer is None else self._solution(answer, self._isolated(answer))

    def residual(self, forces: FloatArray) -> float:
        """Measure forces of the problem; see `ContactProblem.residual`."""
        scaled = (forces / self.unit).tolist()
        return self._residual(scaled, _accelerations(self.W, self.b, scaled))

    def _residual(self, forces: Vector, motion: tuple[Vector, Vector]) -> float:
        """Measure forces whose accelerations are known, with the sizes of their terms."""
        a, terms = motion
        if not math.isfinite(sum(terms)):
            return math.inf
        share = list(map(ratio, a, terms))
        weights = self._share(list(map(abs, forces)), terms, rows=self._normals)
        residual = 0.0
        for i, (weight, s) in enumerate(zip(weights, self.directions, strict=True)):
            n, t = self._pairs[i]
            normal, tangential, leaving, speeding = forces[n], forces[t], share[n], share[t]
            held = abs(leaving)
            if self.least[i] == 0:
                held = max(weight if normal < 0 else min(weight, held), -leaving, 0.0)
            limit = self.mu[i] * abs(normal)
            span = abs(tangential) + limit
            cone = ratio(abs(tangential) - limit, span)
            way = s or sign_of(speeding)
            opposing = ratio(abs(tangential + way * limit), span)
            if not s:
                opposing = min(opposing, abs(speeding))
            residual = max(residual, held, cone, opposing)
        return residual

    def _check(self, forces: Vector, choice: tuple[int, ...] | None = None) -> _Checked | None:
        """Return the forces with negligible parts removed, or None if they are not a solution.

        The choice is that of local modes for which they were computed, if any.
        """
        best: _Checked | None = None
        moved: tuple[Vector, Vector] = [], []
        for candidate in self._candidates(forces):
            modes = self._modes(candidate, choice)
            settled = self._settled(candidate, modes)
            motion = _accelerations(self.W, self.b, settled)
            measured = self._residual(settled, motion)
            if best is None or measured < best.residual:
                named = self._named(settled, modes, motion)
                best = _Checked([force + 0.0 for force in settled], named, measured)  # no -0.0
                moved = motion
            if measured <= ROUNDING:
                break
        if best is None or best.residual > RESIDUAL_TOLERANCE or self._opposes(best, *moved):
            return None
        return best

    def _opposes(self, point: _Checked, a: Vector, terms: Vector) -> bool:
        """Return whether an open contact approaches, or friction drives a slip, beyond rounding.

        Where large forces cancel, what is small beside its terms is not yet rounding.
        """
        for (n, t), mode, s, least in zip(
            self._pairs, point.modes, self.directions, self.least, strict=True
        ):
            if point.forces[n] == least:
                wrong, size = -a[n], terms[n]
            elif s or mode is ContactMode.STICK:
                continue
            else:
                wrong, size = a[t] * sign_of(point.forces[t]), terms[t]
            if wrong > SIGN * size:
                return True
        return False

    def _candidates(self, forces: Vector) -> Iterator[Vector]:
        """Yield the forces without what a solve may have left of zeros, and as they are.

        Noise is what is small beside the largest force in comparable units, or whole contacts that
        matter to no acceleration.
        """
        weighted = list(map(operator.mul, self.weights, map(abs, forces)))
        noise = _ROUND_OFF * max(weighted)
        if 0 < min(filter(None, weighted), default=0.0) <= noise:
            pairs = zip(forces, weighted, strict=True)
            yield [0.0 if 0 < value <= noise else force for force, value in pairs]
        yield forces
        terms = _accelerations(self.W, self.b, forces)[1]
        share = self._share(list(map(abs, forces)), terms)
        kept = list(forces)
        for n, t in self._pairs:
            if share[n] <= RESIDUAL_TOLERANCE and share[t] <= RESIDUAL_TOLERANCE:
                kept[n] = kept[t] = 0.0
        if kept != forces:
            yield kept

    def _modes(self, forces: Vector, choice: tuple[int, ...] | None) -> list[ContactMode]:
        """Return the modes of a choice, or those that the forces show."""
        if choice is not None:
            return [given[j].mode for given, j in zip(self.modes, choice, strict=True)]
        modes, a = [], _accelerations(self.W, self.b, forces)[0]
        for i, s in enumerate(self.directions):
            n, t = self._pairs[i]
            normal, tangential = forces[n], forces[t]
            inside = abs(tangential) < self.mu[i] * abs(normal) * (1 - 1e-9)
            if normal == self.least[i]:
                modes.append(ContactMode.LIFTOFF)
            elif s or not inside:
                modes.append(slip_mode(s or (-tangential if tangential else a[t])))
            else:
                modes.append(ContactMode.STICK)
        return modes

    def _settled(self, forces: Vector, modes: Sequence[ContactMode]) -> Vector:
        """Return the forces with F_n >= 0 where a contact can open, and F_t within its cone.

        Friction is on the edge of the cone exactly where the contact slips.
        """
        settled = list(forces)
        for i, mode in enumerate(modes):
            n, t = self._pairs[i]
            normal, tangential = forces[n], forces[t]
            if normal <= self.least[i]:
                settled[n] = settled[t] = 0.0
                continue
            limit = self.mu[i] * abs(normal)
            if mode is ContactMode.SLIP_POS:
                tangential = -limit
            elif mode is ContactMode.SLIP_NEG:
                tangential = limit
            settled[t] = min(max(tangential, -limit), limit)
        return settled

    def _named(
        self, forces: Vector, modes: Sequence[ContactMode], motion: tuple[Vector, Vector]
    ) -> tuple[ContactMode, ...]:
        """Return the modes, borders by the convention of `ContactMode`."""
        a, terms = motion
        named = []
        for i, (mode, s) in enumerate(zip(modes, self.directions, strict=True)):
            n, t = self._pairs[i]
            rate, size = a[t], terms[t]
            word = mode
            if forces[n] == self.least[i]:
                word = ContactMode.LIFTOFF
            elif not s and (mode is not ContactMode.STICK or abs(rate) > RESIDUAL_TOLERANCE * size):
                # Without friction, or where F_n = 0, the acceleration alone tells the direction.
                word = ContactMode.STICK if abs(rate) <= ROUNDING * size else slip_mode(rate)
            named.append(word)
        return tuple(named)

    def _twin(self, point: _Checked, known: Sequence[_Checked]) -> int | None:
        """Return the position of the same forces among those known, or None."""
        for k, other in enumerate(known):
            near = _NEAR * max(point.largest, other.largest)
            if all(
                abs(p - q) <= near for p, q in zip(point.forces, other.forces, strict=True)
            ) and self._same(point.forces, other.forces):
                return k
        return None

    def _same(self, first: Vector, second: Vector) -> bool:
        """Return whether the step between two forces is negligible for every acceleration."""
        pairs = list(zip(first, second, strict=True))
        size = [max(abs(p), abs(q)) for p, q in pairs]
        # Where forces balance, every term of an acceleration may be rounding: noise is none.
        noise = _ROUND_OFF * max(w * s for w, s in zip(self.weights, size, strict=True))
        step = [
            0.0 if w > 0 and w * abs(p - q) <= noise else abs(p - q)
            for w, (p, q) in zip(self.weights, pairs, strict=True)
        ]
        terms = _accelerations(self.W, self.b, size)[1]
        return all(share <= DISTINCT for share in self._share(step, terms, size))

    def _share(
        self,
        part: Vector,
        terms: Vector,
        whole: Vector | None = None,
        rows: Sequence[int] | None = None,
    ) -> Vector:
        """Return how much each part of the forces matters to any acceleration, by its terms.

        With `rows` only of the forces there.
        """
        shares = []
        pairs = list(zip(self.W, terms, strict=True))
        for k in rows or range(len(part)):
            value, share, moves = part[k], 0.0, False
            for row, size in pairs:
                w = row[k]
                if w:
                    moves = True
                    if size > 0:
                        own = abs(w) * value / size
                        if own > share:
                            share = own
            if not moves and value > 0:  # where nothing moves, forces count by themselves
                share = 1.0 if whole is None else value / whole[k]
            shares.append(share)
        return shares

    def _possible(self, forces: Vector) -> list[list[bool]]:
        """Return for each contact which of its local modes hold these forces, borders included."""
        a, terms = _accelerations(self.W, self.b, forces)
        share = list(map(ratio, a, terms))
        rows = map(self.product.rows.of, range(len(self.mu)))
        return [
            [mode.holds(forces[pair], share[pair]) for mode in given]
            for given, pair in zip(self.modes, rows, strict=True)
        ]

    def _isolated(self, point: _Checked) -> bool | None:
        """Return whether no choice of local modes through these forces is wide.

        None where too many choices meet.
        """
        possible = self._possible(point.forces)
        if math.prod(map(sum, possible)) > _MANY_MODES:
            return None
        meeting = [
            [mode for mode, flag in zip(given, flags, strict=True) if flag]
            for given, flags in zip(self.modes, possible, strict=True)
        ]
        return not any(near.wide for near in ModeProduct(self.W, self.b, meeting).points())

    def _solution(self, point: _Checked, isolated: bool | None) -> ContactSolution:
        """Return checked forces with their accelerations, in the units of the problem."""
        forces = list(map(operator.mul, self.unit, point.forces))
        a, terms = _accelerations(*self.given, forces)
        a = [0.0 if abs(v) <= ROUNDING * t else v for v, t in zip(a, terms, strict=True)]
        lift, stick, pairs = ContactMode.LIFTOFF, ContactMode.STICK, self._pairs
        # What the mode fixes at 0 is exactly 0.
        parted = [a[n] if m is lift else 0.0 for (n, _), m in zip(pairs, point.modes, strict=True)]
        sliding = [
            0.0 if m is stick else a[t] for (_, t), m in zip(pairs, point.modes, strict=True)
        ]
        given = [forces[n] for n, _ in pairs], [forces[t] for _, t in pairs]
        numbers = np.array((*given, parted, sliding))
        numbers.setflags(write=False)
        normal, tangential, a_n, a_t = numbers
        return ContactSolution(point.modes, normal, tangential, a_n, a_t, point.residual, isolated)


def _scale_contacts(
    W: list[Vector], b: Vector, mu: Vector
) -> tuple[list[Vector], Vector, Vector, Vector]:
    """Return W, b and mu scaled to order one by powers of two, which rounds nothing, and the unit.

    Signs and local modes stay the same. Forces F' of the scaled problem are ``unit * F'`` of the
    given one.
    """
    pairs = ContactRows(len(mu)).each()
    diagonal = [row[k] for k, row in enumerate(W)]
    # ldexp(1, k // 2) is within a factor two of the root of a number near 2**k.
    d = [math.ldexp(1.0, math.frexp(w)[1] // 2) if w > 0 else 1.0 for w in diagonal]
    offset = list(map(operator.truediv, b, d))
    largest = max(map(abs, offset))
    size = 2 * power_of_two(largest) if 0 < largest < math.inf else 1.0
    return (
        [[w / (e * f) for w, f in zip(row, d, strict=True)] for row, e in zip(W, d, strict=True)],
        [v / size for v in offset],
        [m * d[t] / d[n] for m, (n, t) in zip(mu, pairs, strict=True)],
        [size / e for e in d],
    )


def _ordered(points: list[_Checked]) -> list[_Checked]:
    """Return the points by their normal forces, then by the tangential ones.

    Forces that differ by rounding alone are equal here: it must not decide the order.
    """
    if len(points) < 2:
        return points
    at = ContactRows(len(points[0].modes))
    forces = [(*p.forces[at.normals], *p.forces[at.tangentials]) for p in points]
    ranks = [_levels(column) for column in zip(*forces, strict=True)]
    return [points[k] for k in sorted(range(len(points)), key=lambda k: [r[k] for r in ranks])]


def _levels(values: Sequence[float]) -> list[int]:
    """Return the rank of each value, the same for values that differ by rounding alone."""
    near = DISTINCT * max(map(abs, values))
    ranks, level, last = [0] * len(values), 0, -math.inf
    for k in sorted(range(len(values)), key=values.__getitem__):
        level += values[k] - last > near
        ranks[k], last = level, values[k]
    return ranks


def _accelerations(W: list[Vector], b: Vector, forces: Vector) -> tuple[Vector, Vector]:
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


def ratio(part: float, whole: float) -> float:
    """Return part / whole, 0 where there is nothing."""
    return part / whole if whole > 0 else 0.0


def _any_holds(choices: list[tuple[int, ...]], possible: Sequence[Sequence[bool]]) -> bool:
    """Return whether one of the choices holds the forces that are possible in each contact."""
    return any(all(held[j] for held, j in zip(possible, choice, strict=True)) for choice in choices)
