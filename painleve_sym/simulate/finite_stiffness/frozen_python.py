"""Impacts with frozen coefficients by SciPy alone: slower than the compiled code.

The same phases as engine/frozen_impact.c, with SciPy's hypergeometric function, adaptive quadrature
and bracketed roots.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import hyp2f1

NUMBERS = 9
PHASES = 8
SEPARATION, STAYS, NO_IMPACT, NO_END, FAILED = range(5)
HYPERGEOMETRIC, ELEMENTARY, QUADRATURE = 1, 2, 4
_RTOL = 4 * 2.3e-16
"""Roots: the least relative tolerance that brentq takes."""
_TINY = 1e-300
_ROUNDING = 1e-12
"""Less than this part of the energy at the largest compression counts as none."""


@dataclass
class Ray:
    """x'' = −(a F + b) with F = κ xⁿ, from x = x0 with speed |u0|: x'²/2 = G(x)."""

    a: float
    b: float
    kappa: float
    n: float
    x0: float
    u0: float

    def __post_init__(self) -> None:
        self.anchor, self.at_anchor = self.x0, 0.5 * self.u0**2
        self.turning, self.turn_ahead = self.u0 == 0 and self.x0 > 0, 0.0
        self.methods = 0

    def force(self, x: float) -> float:
        """Return κ xⁿ; N."""
        return float(self.kappa * max(x, 0.0) ** self.n)

    def energy(self, x: float) -> float:
        """Return G at x ≥ 0; m²/s²."""
        if self.anchor > 0:
            return self.energy_near((x - self.anchor) / self.anchor)
        p = self.n + 1
        return float(self.at_anchor - self.a * self.kappa / p * x**p - self.b * x)

    def energy_near(self, near: float) -> float:
        """Return G at x = (1 + near) · anchor, which keeps its digits next to the anchor."""
        p, x0 = self.n + 1, self.anchor
        power = x0**p * (math.expm1(p * math.log1p(near)) if near > -1 else -1.0)
        return float(self.at_anchor - self.a * self.kappa / p * power - self.b * x0 * near)

    def still(self) -> float:
        """Return the compression at which a F + b = 0 (0 if none)."""
        ratio = -self.b / (self.a * self.kappa) if self.a else 0.0
        return float(ratio ** (1 / self.n)) if ratio > 0 else 0.0

    def turn(self) -> float:
        """Return where a loading motion turns, inf if nowhere."""
        if self.a > 0:
            low, high = max(self.x0, self.still()), max(2 * self.x0, 2 * self.still(), 1e-30)
            while self.energy(high) > 0:
                high *= 2
            return _root(self.energy, low, high)
        if self.b <= 0:
            return math.inf
        if self.a == 0:
            return self.x0 + self.at_anchor / self.b
        still = self.still()
        if self.x0 >= still or self.energy(still) >= 0:
            return math.inf
        return _root(self.energy, self.x0, still)

    def turn_back(self, x_max: float) -> float:
        """Return where an unloading motion turns before x = 0, or −1."""
        p = self.n + 1
        rounding = _ROUNDING * abs(self.a) * self.kappa / p * x_max**p
        low = 0.0
        high = self.x0
        if self.a < 0:
            low = self.still()
            if self.x0 <= low:
                return -1.0
        elif self.a > 0:
            high = min(self.still(), self.x0)
        if self.energy(low) >= rounding:
            return -1.0
        return _root(self.energy, low, high) if self.energy(low) < 0 else 0.0

    def advance(self, start: float, end: float) -> tuple[float, float]:
        """Return time and impulse from x = start to x = end, both ≥ 0."""
        if start == end:
            return 0.0, 0.0
        if self.x0 == 0 and self.u0 == 0 and self.a <= 0 and start == 0:
            return self._from_rest(end)
        self.methods |= QUADRATURE
        if not self.turn_ahead:
            return self._quad(start, end, False), self._quad(start, end, True)
        # Each half from its own end: there the energy keeps its digits.
        kept, middle = (self.anchor, self.at_anchor, self.turning), (self.x0 + self.turn_ahead) / 2
        total = [0.0, 0.0]
        for own, far in ((kept, self.x0), ((self.turn_ahead, 0.0, True), self.turn_ahead)):
            low, high = sorted((middle, far))
            x1, x2 = max(min(start, end), low), min(max(start, end), high)
            self.anchor, self.at_anchor, self.turning = own
            if x1 < x2:
                total = [v + self._quad(x1, x2, k == 1) for k, v in enumerate(total)]
        self.anchor, self.at_anchor, self.turning = kept
        return total[0], total[1]

    def _from_rest(self, x: float) -> tuple[float, float]:
        n, beta, f = self.n, -self.b, self.force(x)
        z, root, b0 = -self.a * f / ((n + 1) * beta), math.sqrt(2 * x / beta), 0.5 / n
        self.methods |= ELEMENTARY if n == 1 else HYPERGEOMETRIC
        if n == 1 and z > 0:
            t = root * math.asinh(math.sqrt(z)) / math.sqrt(z)
        else:
            t = root * float(hyp2f1(0.5, b0, 1 + b0, -z))
        if z > 1:
            return t, (math.sqrt(2 * beta * x * (1 + z)) - beta * t) / -self.a
        return t, f * root * float(hyp2f1(0.5, 1 + b0, 2 + b0, -z)) / (2 * n + 1)

    def _quad(self, start: float, end: float, impulse: bool) -> float:
        # x = anchor (1 ± q²)⁴ at a turning point, else x = q⁴: what is singular there goes.
        sign = 1.0 if max(start, end) > self.anchor else -1.0

        def variable(x: float) -> float:
            if not self.turning:
                return math.sqrt(math.sqrt(x))
            near = (x - self.anchor) / self.anchor
            return math.sqrt(sign * (math.expm1(math.log1p(near) / 4) if near > -1 else -1.0))

        def integrand(q: float) -> float:
            if self.turning:
                e = sign * q * q
                x, dx = self.anchor * (1 + e) ** 4, 8 * self.anchor * q * (1 + e) ** 3
                g = self.energy_near(e * (4 + e * (6 + e * (4 + e))))
            else:
                x, dx = q**4, 4 * q**3
                g = self.energy(x)
            part = dx / math.sqrt(2 * g) if g > 0 else 0.0
            return part * self.force(x) if impulse else part

        ends = variable(start), variable(end)
        # Asked for all digits: full_output keeps what it gets when round-off comes first.
        value = quad(
            integrand, min(ends), max(ends), epsabs=0, epsrel=1e-13, limit=100, full_output=1
        )[0]
        return float(value)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    return float(brentq(function, low, high, xtol=_TINY, rtol=_RTOL, maxiter=500))


@dataclass
class Impact:
    """The state of one impact between its phases."""

    sets: tuple[Sequence[float], Sequence[float]]
    mu: float
    stiffness: float
    n: float
    e: float
    slip_velocity: float
    x: float
    u: float

    def __post_init__(self) -> None:
        self.stopped, self.mode, self.loading = 0, 0, True
        self.speed = abs(self.slip_velocity)
        self.kappa, self.permanent, self.largest = self.stiffness, 0.0, self.x
        self.methods, self.rows = 0, list[list[float]]()
        self.sums = [0.0, 0.0, 0.0]

    def departure(self, force: float) -> int:
        """Return the direction in which a point at rest slips under this force, 0 if it sticks."""
        _, W_nt, W_tt, _, b_t = self.sets[self.stopped]
        if force == 0 and b_t == 0:
            force = 1.0  # all scales with the force then, also when it is still zero
        pull = W_nt * force + b_t
        if abs(pull) <= self.mu * W_tt * force:
            return 0
        return (pull > 0) - (pull < 0)

    def path(self) -> tuple[Ray, float, float, float, float]:
        """Return the ray, F_t = ratio F + offset and v̇_t = c F + d."""
        W_nn, W_nt, W_tt, b_n, b_t = self.sets[self.stopped]
        if self.mode:
            ratio, offset = -self.mu * self.mode, 0.0
            c, d = W_nt + ratio * W_tt, b_t
        else:
            ratio, offset, c, d = -W_nt / W_tt, -b_t / W_tt, 0.0, 0.0
        a, b = W_nn + ratio * W_nt, b_n + offset * W_nt
        return Ray(a, b, self.kappa, self.n, self.x, self.u), ratio, offset, c, d

    def unload(self) -> None:
        """Pass to the unloading curve at the largest compression."""
        self.largest = self.x + self.permanent
        self.loading, self.x = False, self.e**2 * self.largest
        self.permanent = self.largest - self.x
        self.kappa = self.stiffness * self.e ** (-2 * self.n)

    def begin(self) -> int | None:
        """Choose the first mode and branch; return an end where there is no impact."""
        force = self.stiffness * self.x**self.n if self.x > 0 else 0.0
        v = self.slip_velocity
        self.mode = (v > 0) - (v < 0) if v else self.departure(force)
        self.stopped = int(v == 0)
        ray = self.path()[0]
        rate = -(ray.a * force + ray.b)
        if self.x == 0 and (self.u < 0 or (self.u == 0 and rate <= 0)):
            return NO_IMPACT
        if self.u == 0 and rate == 0:
            return STAYS
        if self.u < 0 or (self.u == 0 and rate < 0):
            if self.e == 0:
                return SEPARATION
            self.unload()
        return None

    def stick_end(self, end: float) -> float | None:
        """Return the compression at which sticking fails first."""
        _, W_nt, W_tt, _, b_t = self.sets[self.stopped]
        ahead = []
        for side in (-1, 1):
            rate = side * self.mu * W_tt - W_nt
            force = b_t / rate if rate else 0.0
            x = (force / self.kappa) ** (1 / self.n) if force > 0 else -1.0
            between = (
                self.x * (1 + 1e-13) < x < end
                if self.loading
                else (max(end, 0) < x < self.x * (1 - 1e-13))
            )
            if x > 0 and between:
                ahead.append(x)
        if not ahead:
            return None
        return min(ahead) if self.loading else max(ahead)

    def slip_stop(self, ray: Ray, c: float, d: float, end: float) -> float | None:
        """Return the compression at which the slip stops; raise LookupError if it never does."""
        s, start, going = self.mode, self.x, 1 if self.loading else -1
        c, d = s * c, s * d
        still = (-d / c / self.kappa) ** (1 / self.n) if c * d < 0 else -1.0
        turns = still > 0 and going * (still - start) > 0 and going * (end - still) > 0
        falls = c * ray.force(start) + d < 0
        concave = c * going < 0
        far = end
        if not concave:
            if self.slip_velocity == 0 or not falls:
                return None
            far = still if turns else end

        def left(x: float) -> float:
            t, P = ray.advance(start, x)
            return s * self.slip_velocity + c * P + d * t

        low = still if concave and turns else start
        if math.isinf(far):
            if c >= 0:
                raise LookupError
            guess = (max(abs(self.slip_velocity), 1e-12) / -c / self.kappa) ** (1 / self.n)
            far = max(2 * low, guess)
            while left(far) > 0:
                far *= 4
        if left(far) >= 0:
            return None
        if low == start and self.slip_velocity == 0:
            low = start + 1e-9 * (far - start)
        return _root(left, low, far) if left(low) > 0 else low

    def phase(self) -> int | None:
        """Follow one phase; return how the impact ends, or None."""
        ray, ratio, offset, c, d = self.path()
        turn = ray.turn() if self.loading else ray.turn_back(self.e**2 * self.largest)
        end, back = max(turn, 0.0), not self.loading and turn >= 0
        if turn > 0 and math.isfinite(turn):
            ray.turn_ahead = turn
        start, mode, speed = self.x, self.mode, self.u
        try:
            x = self.slip_stop(ray, c, d, end) if mode else self.stick_end(end)
        except LookupError:
            return NO_END
        to = end if x is None else x
        if math.isinf(to):
            return NO_END
        t, P = ray.advance(start, to)
        push = abs(ray.a * ray.force(to) + ray.b)
        if abs(to - start) <= 1e-15 * start and self.u and push:
            # So close to the turning point that compressions do not tell: uniform deceleration.
            t = abs(self.u) / push
            P = ray.force(to) * t
        stands = x is None and (self.loading or back)
        going = 1 if self.loading else -1
        self.u = 0.0 if stands else going * math.sqrt(2 * max(0.0, ray.energy(to)))
        self.slip_velocity += c * P + d * t
        if mode == 0 or x is not None:
            self.slip_velocity = 0.0
        P_t = ratio * P + offset * t
        moment = (speed * t - 0.5 * ray.b * t * t - (to - start)) / ray.a if ray.a else math.nan
        numbers = (mode, self.loading, t, P, P_t, to + self.permanent, self.u, self.slip_velocity)
        self.rows.append([float(value) for value in (*numbers, moment)])
        self.sums = [total + part for total, part in zip(self.sums, (t, P, P_t), strict=True)]
        self.methods |= ray.methods
        self.x = to
        return self._switch(ray, x is not None, back)

    def _switch(self, ray: Ray, event: bool, back: bool) -> int | None:
        force = ray.force(self.x)
        if event and self.mode:
            self.stopped = 1
            self.mode = self.departure(force)
        elif event:
            _, W_nt, _, _, b_t = self.sets[self.stopped]
            pull = W_nt * force + b_t
            self.mode = (pull > 0) - (pull < 0)
        elif self.loading and self.mode and self.mode * self.slip_velocity <= 1e-15 * self.speed:
            # The slip stops at the largest compression, to round-off.
            self.stopped, self.slip_velocity = 1, 0.0
            if self.e == 0:
                return SEPARATION
            self.unload()
            self.mode = self.departure(self.kappa * self.x**self.n)
        elif back:
            if self.e < 1 or ray.a > 0:
                return STAYS
            self.loading = True
        elif not self.loading or self.e == 0:
            self.largest = max(self.largest, self.x + self.permanent)
            return SEPARATION
        else:
            self.unload()
            if self.mode == 0:
                self.mode = self.departure(self.kappa * self.x**self.n)
        return None


def solve(case: Sequence[float]) -> tuple[list[float], list[list[float]]]:
    """Return head and phases of one impact, as the compiled code orders them."""
    s = Impact((case[:5], case[5:10]), *case[10:])
    end = s.begin()
    while end is None and len(s.rows) < PHASES:
        try:
            end = s.phase()
        except (ValueError, ArithmeticError, RuntimeError):
            end = FAILED
    end = STAYS if end is None else end
    head = [float(end), float(s.methods), float(len(s.rows)), s.slip_velocity, 0.0 - s.u]
    head += [s.sums[1], s.sums[2], s.sums[0], s.largest]
    rows = s.rows + [[math.nan] * NUMBERS] * (PHASES - len(s.rows))
    return head, rows
