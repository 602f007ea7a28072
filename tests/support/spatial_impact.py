"""The path of an impact in space in Python: the oracle of ``problem/impact/spatial.c``.

It is derived in ``painleve_sym/problem/impact/spatial.py``; the steps are those of the C, by NumPy
and with the directions in which slip does not turn from the package.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyval

from painleve_sym.arrays import Array
from painleve_sym.laws.restitution import Measure
from painleve_sym.problem.impact.path import COINCIDENT, impulse_to_end
from painleve_sym.problem.impact.spatial import (
    ENDED,
    JAM,
    MEASURES,
    NO_IMPACT,
    ORDER,
    PHASES,
    PIECES,
    RESUMED,
    ROW,
    SLIP,
    STICK,
    STOPS,
    UNFINISHED,
    invariant_angles,
    zero_between,
)
from painleve_sym.problem.modes import sign_of
from painleve_sym.problem.rounding import SUM, rounded_sum

_GOES_ON = -1
_TIED, _LEAST_CHANGE = 1e-9, 0.05
_LAST_TERM, _STOPPED, _LEAST_RATE, _GROWTH = 1e-17, 1e-30, 1e-3, 16.0
_C, _S, _V, _N, _P, _P1, _P2, _E, _T = range(9)
"""Places in a state: direction, slip, v_n; impulses and works since the phase began."""
_BORDER, _LAW, _RATE, _TURN = range(4)


class _Limit(NamedTuple):
    """An invariant direction with the series in y of slip that tends to it."""

    direction: tuple[float, float]
    k: float
    rate: float
    radius: float
    C: Array
    S: Array
    D: Array
    V: Array


class _Piece(NamedTuple):
    """A piece of the path, from x = `begin` to x = `end`; `series` has a row for each number.

    By time x = τ, and the numbers are the sums of the series; else x = exp(k τ), from 1 to 0 for
    k < 0, and y = x**power.
    """

    series: Array
    begin: float
    end: float
    origin: Array
    k: float = 0.0
    power: float = 0.0
    limit: Array | None = None

    def at(self, x: float) -> Array:
        """Return the state at a place."""
        if x == self.begin:
            return self.origin.copy()
        y: float = x if self.limit is None else x**self.power
        state: Array = np.asarray(polyval(y, self.series.T))
        if self.limit is not None:
            state[_V:_E] *= x
            state[_E:] *= x * x
            state[_E] += self.limit[_N] * state[_P]
            state[_N:] += self.limit[_N:]
        state[:_V] /= math.hypot(*state[:_V])
        return state


class SpatialPath:
    """The path of an impact in space as it is followed; given is a row of `impacts_in_space`."""

    def __init__(self, given: Sequence[float]) -> None:
        Wnn, w1, w2, W11, W12, W22, mu, v_n, v_1, v_2, measure, share = map(float, given)
        self.Wnn, self.w, self.Wtt, self.mu = Wnn, (w1, w2), (W11, W12, W22), mu
        self.size = math.hypot(w1, w2) + mu * (W11 + W22)
        self.measure, self.share, self.target = MEASURES[int(measure)], share, -share * v_n
        v = math.hypot(v_1, v_2)
        self.state = np.zeros(9)
        self.state[:4] = (v_1 / v if v else 0.0, v_2 / v if v else 0.0, v, v_n)
        self.restitution, self.left, self.phases = 0, 0.0, list[list[float]]()
        det, size = W11 * W22 - W12 * W12, W11 * W22
        if W22 == 0.0:  # nothing moves along t2
            a1, a2, det, size = w1 / W11, 0.0, W11, W11
        else:
            a1, a2 = (W22 * w1 - W12 * w2) / det, (W11 * w2 - W12 * w1) / det
        self.tie, least = (a1, a2), Wnn - w1 * a1 - w2 * a2
        # Then v_n = offset + a·v_t all along.
        self.singular = least * det <= COINCIDENT * Wnn * size
        self.offset = v_n - a1 * v_1 - a2 * v_2
        if abs(self.offset) <= _TIED * (abs(v_n) + abs(a1 * v_1) + abs(a2 * v_2)):
            self.offset = 0.0

    def follow(self) -> tuple[int, Array]:
        """Return the end, and the phases in rows of 11 numbers."""
        end = NO_IMPACT
        if self._begins():
            end = self._curve() if self.state[_V] > 0.0 else self._at_rest(SLIP)
            end = self._at_rest(RESUMED) if end == _GOES_ON else end
        end = UNFINISHED if len(self.phases) > PHASES else end
        return end, np.array(self.phases).reshape(len(self.phases), ROW)

    def _rates(self, c: float, s: float) -> tuple[float, float, float]:
        """Return A, k, h along a direction; they are exactly 0 within their rounding."""
        (w1, w2), (W11, W12, W22), mu = self.w, self.Wtt, self.mu
        f1, f2 = w1 - mu * (W11 * c + W12 * s), w2 - mu * (W12 * c + W22 * s)
        h = c * f2 - s * f1
        A, k = rounded_sum(self.Wnn, -mu * w1 * c, -mu * w2 * s), c * f1 + s * f2
        k, h = (rate if abs(rate) > SUM * self.size else 0.0 for rate in (k, h))
        return A, k, h

    def _along_across(self, c: float, s: float) -> tuple[float, float]:
        w1, w2 = self.w
        return w1 * c + w2 * s, rounded_sum(w2 * c, -w1 * s)

    def _tied_along(self, c: float, s: float) -> float:
        """Return dv_n/dv along a direction of slip, where W is of rank two."""
        return rounded_sum(self.tie[0] * c, self.tie[1] * s)

    def _sense(self, state: Array) -> float:
        """Return a number with the sign of v_n, also where v_n vanishes with the slip."""
        if not self._tied:
            return float(state[_N])
        along = self._tied_along(*state[:2])
        return along if abs(along) > COINCIDENT * math.hypot(*self.tie) else 0.0

    @property
    def _tied(self) -> bool:
        """Whether v_n and the slip vanish together."""
        return self.singular and self.offset == 0.0

    def _at(self, piece: _Piece, x: float) -> Array:
        """Return the state at a place of a piece."""
        state = piece.at(x)
        if self.singular and x != piece.begin:
            state[_N] = self.offset + state[_V] * self._tied_along(*state[:2])
        return state

    def _begins(self) -> bool:
        c, s, v, n = self.state[:4]
        if n < 0.0 or v == 0.0 or self.Wnn == 0.0:
            return bool(n < 0.0)
        (A, k, h), (_, across) = self._rates(c, s), self._along_across(c, s)
        return A < 0.0 or (A == 0.0 and (-across * h < 0.0 or (h == 0.0 and k < 0.0)))

    # ---- series ----

    def _by_time(self) -> _Piece:
        (w1, w2), (W11, W12, W22), mu = self.w, self.Wtt, self.mu
        q = np.zeros((9, ORDER + 1))
        q[:, 0] = self.state
        c, s, v, n = q[:4]
        f1, f2, h, k = np.zeros((4, ORDER))
        for j in range(ORDER):
            f1[j] = (w1 if j == 0 else 0.0) - mu * (W11 * c[j] + W12 * s[j])
            f2[j] = (w2 if j == 0 else 0.0) - mu * (W12 * c[j] + W22 * s[j])
            h[j] = _term(c, f2, j) - _term(s, f1, j)
            k[j] = _term(c, f1, j) + _term(s, f2, j)
            u1, u2 = _term(v, c, j), _term(v, s, j)
            rates = (
                *(-_term(s, h, j), _term(c, h, j), _term(v, k, j)),
                self.Wnn * v[j] - mu * (w1 * u1 + w2 * u2),
                *(v[j], -mu * u1, -mu * u2),
                *(_term(v, n, j), -mu * _term(v, v, j)),
            )
            q[:, j + 1] = np.array(rates) / (j + 1)
        reach = min(_reach(c, 1.0), _reach(s, 1.0), _reach(v, v[0]))
        return _Piece(q, 0.0, reach, self.state.copy())

    def _limit_ahead(self, h: float) -> _Limit | None:
        (w1, w2), (W11, W12, W22), mu = self.w, self.Wtt, self.mu
        here, best = math.atan2(self.state[_S], self.state[_C]), (math.inf, 0.0, 0.0, 0.0)
        for angle in invariant_angles(self.w, self.Wtt, mu):
            ahead = math.fmod((angle - here) * math.copysign(1.0, h), math.tau)
            k = self.growth(angle)
            rate = self.turning(angle, k)
            if rate < 0.0:
                best = min(best, (ahead + math.tau if ahead < 0.0 else ahead, angle, k, rate))
        ahead, angle, k, rate = best
        least = min(abs(k), abs(k + rate), abs(2 * k + rate))
        # Quotients by smaller rates lose digits.
        if ahead == math.inf or least < _LEAST_RATE * self.size:
            return None
        C, S, D, V, f1, f2, K, turned = np.zeros((8, ORDER + 1))
        C[0], S[0], V[0] = math.cos(angle), math.sin(angle), 1.0
        f1[0], f2[0] = (
            w1 - mu * (W11 * C[0] + W12 * S[0]),
            w2 - mu * (W12 * C[0] + W22 * S[0]),
        )
        for j in range(1, ORDER + 1):
            # First without D_j, whose part in term j of h is rate D_j.
            C[j], S[j] = -_term(S, turned, j) / j, _term(C, turned, j) / j
            f1[j], f2[j] = -mu * (W11 * C[j] + W12 * S[j]), -mu * (W12 * C[j] + W22 * S[j])
            of_h = _term(C, f2, j) - _term(S, f1, j)
            D[j] = 1.0 if j == 1 else of_h / ((j - 1) * rate)
            turned[j] = j * D[j]
            C[j], S[j] = C[j] - S[0] * D[j], S[j] + C[0] * D[j]
            f1[j], f2[j] = -mu * (W11 * C[j] + W12 * S[j]), -mu * (W12 * C[j] + W22 * S[j])
            K[j] = (_term(C, f1, j) + _term(S, f2, j)) / rate
            V[j] = _term(K, V, j) / j
        radius = min(_reach(a, 1.0) for a in (C, S, D, V))
        return _Limit((C[0], S[0]), k, rate, radius, C, S, D, V)

    def growth(self, angle: float) -> float:
        """Return k of a direction."""
        return self._rates(math.cos(angle), math.sin(angle))[1]

    def turning(self, angle: float, k: float) -> float:
        """Return dh/dφ at an invariant direction with this k."""
        c, s, (W11, W12, W22) = math.cos(angle), math.sin(angle), self.Wtt
        return -k - self.mu * (W11 * s * s - 2 * W12 * s * c + W22 * c * c)

    def _along_limit(self, limit: _Limit) -> _Piece | None:
        """Return the piece along an invariant direction; None where that is not near enough."""
        (w1, w2), mu, state, (c, s) = self.w, self.mu, self.state, limit.direction
        off = math.atan2(c * state[_S] - s * state[_C], c * state[_C] + s * state[_S])
        y = off
        if abs(off) > limit.radius:
            return None
        powers = np.arange(ORDER + 1)
        for _ in range(50):
            step = float((polyval(y, limit.D) - off) / polyval(y, (powers * limit.D)[1:]))
            y -= step
            if abs(step) <= 1e-17 + 1e-16 * abs(y):
                break
        if not abs(y) <= limit.radius:
            return None
        scale = y**powers
        one, two = limit.k + powers * limit.rate, 2 * limit.k + powers * limit.rate
        v = limit.V * scale * (state[_V] / polyval(y, limit.V))
        c_, s_ = limit.C * scale, limit.S * scale
        u1, u2, vv = (np.convolve(v, of)[: ORDER + 1] for of in (c_, s_, v))
        n = (self.Wnn * v - mu * (w1 * u1 + w2 * u2)) / one
        work = np.convolve(v, n)[: ORDER + 1] / two
        parts = (c_, s_, v, n, v / one, -mu * u1 / one, -mu * u2 / one, work, -mu * vv / two)
        series = np.array(parts)
        end = state - polyval(1.0, series.T)
        end[_E] -= end[_N] * polyval(1.0, series[_P])
        x, k = (0.0 if limit.k < 0.0 else _GROWTH), limit.k
        return _Piece(series, 1.0, x, state.copy(), k, limit.rate / k, end)

    # ---- events ----

    def _event(self, event: int, state: Array) -> tuple[float, float]:
        """Return the function that vanishes at an event, and its derivative by τ."""
        c, s, v, n = state[:4]
        (A, _, h), (along, across) = self._rates(c, s), self._along_across(c, s)
        if event == _RATE:
            return A, -self.mu * across * h
        if event == _TURN:
            return (across if abs(across) > 1e-14 * math.hypot(*self.w) else 0.0), -along * h
        if event == _LAW and self.measure is Measure.IMPULSE:
            return state[_P] - self.left, v
        if event == _LAW and self.measure is Measure.WORK:
            return state[_E] - self.left, v * n
        return (n - self.target if event == _LAW else n), v * A

    def _event_between(
        self, piece: _Piece, event: int, start: float, to: float, sign: int
    ) -> float:
        """Return the event between two places, of which the function has this sign at the first."""

        def newton(x: float) -> tuple[float, float]:
            value, slope = self._event(event, self._at(piece, x))
            return value * sign, slope * sign / (1.0 if piece.limit is None else piece.k * x)

        return zero_between(newton, start, to, 4e-16)

    # ---- the path ----

    def _tell(self, ray: int, c: float, s: float) -> None:
        at = self.state
        kinetic = self.measure is Measure.IMPULSE
        spent = at[_P] if kinetic else at[_E]
        if self.restitution:
            self.left -= spent
        elif self.measure is not Measure.VELOCITY:
            self.left += self.share * (spent if kinetic else -spent)
        velocity = (at[_N], at[_V] * at[_C], at[_V] * at[_S])
        self.phases.append(
            [2 * ray + self.restitution, *at[_P:_E], *velocity, at[_E], at[_T], c, s]
        )
        self.state[_P:] = 0.0

    def _impulse_to_end(self, A: float) -> tuple[float, float]:
        """Return the impulse along a ray to the end of the part, inf for never, and v_n there."""
        part = (self.measure, self.target) if self.restitution else (Measure.VELOCITY, 0.0)
        measure, due = part
        n, spent = self.state[_N], self.state[_P if measure is Measure.IMPULSE else _E]
        rests = A == 0.0 or (A < 0.0 and self.restitution)
        if measure is Measure.VELOCITY and rests and self.phases and due <= n:
            return 0.0, n
        return impulse_to_end(measure, n, A, due, max(0.0, self.left - spent))

    def _ray(self, kind: int, ratio: tuple[float, float], A: float, k: float) -> int:
        """Follow a straight ray to the end of the impact, or to where its slip stops."""
        at = self.state
        if self.singular and at[_V] > 0.0:
            A = k * (at[_N] - self.offset) / at[_V]
        while True:
            (end, n), stop = self._impulse_to_end(A), math.inf
            # In restitution v_n may fall to 0 before: the contact is compressed again.
            border = -at[_N] / A if self.restitution and A < 0.0 else math.inf
            falls = border < end
            if falls:
                end, n = border, 0.0
            if k < 0.0 and at[_V] > 0.0:
                stop = -at[_V] / k
            sooner, direction = end * (1 - COINCIDENT), (0.0, 0.0)
            if kind != STICK:
                direction = at[_C], at[_S]
            latest = sooner if self.restitution else end * (1 + COINCIDENT)
            stops = stop < math.inf and stop <= latest
            if not stops and end == math.inf:
                return JAM
            P = stop if stops else end
            reached = at[_N] + A * stop if stops and stop < sooner else n
            v = 0.0 if stops or stop <= end * (1 + COINCIDENT) else at[_V] + k * P
            at[_P : _P2 + 1] += (P, ratio[0] * P, ratio[1] * P)
            at[_E] += P * (at[_N] + reached) / 2
            at[_T] += P * (ratio[0] * at[_C] + ratio[1] * at[_S]) * (at[_V] + v) / 2
            at[_N], at[_V] = (self.offset if stops and self.singular else reached), v
            self._tell(STOPS if stops else kind, *direction)
            if stops:
                return _GOES_ON
            if self.restitution and not falls:
                return ENDED
            self.restitution = int(not falls)

    def _never_ends(self) -> bool:
        """Whether v_n, tied to the slip of a driven surface, never gets beyond its end."""
        (w1, _), (W11, _, W22) = self.w, self.Wtt
        kinematic = self.measure is Measure.VELOCITY
        if (
            not self.singular
            or W22
            or abs(w1) >= self.mu * W11
            or (self.restitution and not kinematic)
        ):
            return False
        cosine, across = w1 / (self.mu * W11), abs(self.state[_V] * self.state[_S])
        turned = self.tie[0] * across * cosine / math.sqrt(1 - cosine * cosine)
        above = self.offset + turned - (self.target if self.restitution else 0.0)
        return bool(above <= _TIED * (abs(self.offset) + abs(turned)))

    def _curve(self) -> int:
        """Follow slip that turns, to the end of the impact or to where it stops."""
        both = self.mu * math.hypot(*self.w) > self.Wnn * (1 - COINCIDENT)
        limit, rate, turn, first, direct = None, 1, 0, self.state[_V], False
        for i in range(PIECES):
            c, s = self.state[:2]
            A, k, h = self._rates(c, s)
            if self._never_ends():
                return JAM
            if h == 0.0:
                stays = self.singular and abs(k) <= COINCIDENT * self.size
                k = 0.0 if stays else k
                return self._ray(SLIP, (-self.mu * c, -self.mu * s), A, k)
            if i == 0:
                limit, (along, across) = self._limit_ahead(h), self._along_across(c, s)
                turn = sign_of(across) or sign_of(-along * h)
                rate = sign_of(A) or sign_of(-across * h) or 1
            piece = None if direct or limit is None else self._along_limit(limit)
            piece, direct = piece or self._by_time(), False
            to, passes, changes = piece.end, False, False
            end = self._at(piece, to)
            if both:
                # v_n is monotonic between the zeros of A, of which one is on each side of w.
                passes = turn * self._event(_TURN, end)[0] < 0.0
                if passes:
                    to = self._event_between(piece, _TURN, piece.begin, to, turn)
                    end = self._at(piece, to)
                changes = rate * self._event(_RATE, end)[0] < 0.0
                if changes:
                    passes, to = False, self._event_between(piece, _RATE, piece.begin, to, rate)
                    end = self._at(piece, to)
            event = self._part_ends(piece, to, end, rate)
            if event is not None:
                # Along an invariant direction, events within a small change of v lose digits.
                direct = piece.limit is not None and abs(event[1] - 1) < _LEAST_CHANGE
                reached = self._at(piece, event[1])
                if event[0] == _LAW and reached[_V] <= COINCIDENT * first:
                    reached[_V] = 0.0  # it stops at the end
                if not direct and self._end_part(event[0], reached):
                    return ENDED
                continue
            self.state = end
            rate, turn = (-rate if changes else rate), (-turn if passes else turn)
            if (piece.limit is not None and to == 0.0) or end[_V] < _STOPPED * first:
                self.state[_V] = 0.0
                self.state[_N] = self.offset if self.singular else self.state[_N]
                if self.restitution and self._nearly_done():
                    self._tell(SLIP, *self.state[:2])
                    return ENDED
                self._tell(STOPS, *self.state[:2])
                return _GOES_ON
        return UNFINISHED

    def _nearly_done(self) -> bool:
        """Whether restitution ends here but for rounding."""
        at, measure = self.state, self.measure
        if measure is Measure.VELOCITY:
            return bool(self.target - at[_N] <= COINCIDENT * self.target)
        spent = at[_P if measure is Measure.IMPULSE else _E]
        return bool(self.left - spent <= COINCIDENT * self.left)

    def _part_ends(
        self, piece: _Piece, to: float, end: Array, rate: int
    ) -> tuple[int, float] | None:
        """Return the event that ends compression or restitution in a piece, and its place.

        In the piece v_n is monotonic, with the sign of `rate`.
        """
        if not self.restitution:
            opens = self._sense(end) > 0.0 if self._tied else end[_N] >= 0.0
            if rate > 0 and opens and self.state[_N] < 0.0:
                return _BORDER, self._event_between(piece, _BORDER, piece.begin, to, -1)
            return None
        falls = rate < 0 and self._sense(end) < 0.0
        if falls:
            to = self._event_between(piece, _BORDER, piece.begin, to, 1)
            end = self._at(piece, to)
            end[_N] = 0.0
        if self._event(_LAW, end)[0] >= 0.0:
            return _LAW, self._event_between(piece, _LAW, piece.begin, to, -1)
        return (_BORDER, to) if falls else None

    def _end_part(self, event: int, state: Array) -> bool:
        """End compression or restitution at an event of slip; return whether the impact ends."""
        self.state = state
        if event == _LAW:
            if self.measure is Measure.VELOCITY:
                state[_N] = self.target
            self._tell(SLIP, *state[:2])
            return True
        state[_N] = 0.0
        self._tell(SLIP, *state[:2])
        # Restitution begins, or the contact is compressed again.
        self.restitution = 1 - self.restitution
        due = self.target if self.measure is Measure.VELOCITY else self.left
        done = bool(due <= 0.0)
        if self.restitution and done:
            self._tell(SLIP, *state[:2])
        return done and self.restitution == 1

    def _at_rest(self, kind: int) -> int:
        """Follow a contact without slip: it sticks, or slips as slip can grow."""
        (w1, w2), ratio = self.w, (-self.tie[0], -self.tie[1])
        A, k, c, s = 0.0, 0.0, 0.0, 0.0
        if math.hypot(*ratio) > self.mu:
            angle = invariant_angles(self.w, self.Wtt, self.mu)[0]
            c, s = math.cos(angle), math.sin(angle)
            A, k, _ = self._rates(c, s)
        if k <= 0.0:
            A = self.Wnn + w1 * ratio[0] + w2 * ratio[1]
            regular = not self.singular and COINCIDENT * self.Wnn < A
            return self._ray(STICK, ratio, A if regular else 0.0, 0.0)
        self.state[:2] = c, s
        return self._ray(kind, (-self.mu * c, -self.mu * s), A, k)


def _term(a: Array, b: Array, j: int) -> float:
    """Return term j of the product of two series."""
    return float(a[: j + 1] @ b[j::-1])


def _reach(series: Array, first: float) -> float:
    """Return the size of x for which the last terms are small parts of `first`."""
    terms = ((j, abs(series[j])) for j in (ORDER - 1, ORDER))
    return min(((_LAST_TERM * first / a) ** (1 / j) for j, a in terms if a > 0), default=math.inf)
