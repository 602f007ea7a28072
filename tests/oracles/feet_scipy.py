"""A block on two compliant feet, written by hand and integrated with SciPy.

Independent of the package: Newton's and Euler's equations of one body, the three force-compression
laws, dry friction by enumeration with a small dense solve, and the logic of events are all written
here. The gaps, their rates and the slip velocities are states of their own, as a point of a rigid
body accelerates by a_C + alpha x r - omega^2 r.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853
from scipy.optimize import brentq

Array = NDArray[np.float64]

FEET = ("A", "B")
X, Y, THETA, VX, VY, OMEGA = range(6)
GAP, RATE, SLIP = (6, 7), (8, 9), (10, 11)
FRICTION, CONTACT = 12, 13
_INSTANT = 1e-13
"""Guards that vanish within this time are simultaneous; s."""

_AFTER = 1e-9
"""How long after an event contacts at rest are looked at; s."""


@dataclass(frozen=True)
class Law:
    """F = k d^n + c d' while loading; with `e` < 1 the plastic unloading of the paper, (5)."""

    k: float
    n: float = 1.0
    c: float = 0.0
    e: float | None = None

    def force(self, branch: str, d: float, rate: float, deepest: float) -> float:
        """Return the normal force; N."""
        if self.e is not None and branch in ("restitution", "reload"):
            left = deepest * (1 - self.e**2)
            return self.k * max((d - left) / self.e**2, 0.0) ** self.n
        return self.k * max(d, 0.0) ** self.n + self.c * rate

    def dissipated(self, branch: str, d: float, rate: float) -> float:
        """Return the power lost in the normal motion; W."""
        if self.e is not None:
            lost = (1 - self.e**2) * self.k * max(d, 0.0) ** self.n * rate
            return lost if branch == "compression" else 0.0
        return self.c * rate**2

    def exits(self, branch: str, d: float, rate: float, deepest: float) -> Iterator[tuple]:
        """Yield kind, guard and next branch of every way out of a branch."""
        left = deepest * (1 - self.e**2) if self.e is not None else 0.0
        indented = self.e is not None or self.c > 0
        if branch == "flight":
            yield "touchdown", -d, "compression"
        elif branch == "indented":
            yield "liftoff", d, "flight"
            if self.e is not None:
                yield "touchdown", left - d, "reload"
            else:
                yield "touchdown", -(self.k * d + self.c * rate), "restitution"
        elif branch == "compression":
            yield "max_compression", rate, "restitution"
            if self.c > 0:
                yield "separation", self.k * d + self.c * rate, "indented"
        elif branch == "restitution":
            pull = d - left if self.e is not None else self.k * d + self.c * rate
            yield "separation", pull, "indented" if indented else "flight"
            if self.c > 0:
                yield "separation", d, "indented"
            yield "reload", -rate, "reload" if self.e is not None else "compression"
        elif branch == "reload":
            yield "max_compression", rate, "restitution"
            yield "yield", deepest - d, "compression"


@dataclass
class Foot:
    """Mode of one foot: branch of its law, deepest compression, sign of slip (0: sticks)."""

    branch: str = "flight"
    deepest: float = 0.0
    sign: int = 0

    @property
    def closed(self) -> bool:
        """Whether it may carry force."""
        return self.branch not in ("flight", "indented")


@dataclass
class Event:
    """Time (s), kind, foot."""

    time: float
    kind: str
    foot: str


@dataclass
class Block:
    """Mass m, inertia J, half distance a, height h, slope beta, gravity g, friction, laws.

    Friction is mu in slip and static mu in stick; with a Stribeck velocity (m/s) it falls from one
    to the other.
    """

    laws: tuple[Law, Law]
    m: float = 1.0
    J: float = 0.02
    a: float = 0.1
    h: float = 0.2
    beta: float = 0.2
    g: float = 9.8
    mu: tuple[float, float] = (0.4, 0.6)
    static: tuple[float, float] = (1.0, 1.0)
    stribeck: tuple[float, float] = (0.0, 0.0)
    feet: tuple[Foot, Foot] = field(default_factory=lambda: (Foot(), Foot()))

    # ---- mechanics ----

    def arms(self, theta: float) -> Array:
        """Return the vectors from the mass centre to the feet, shape (2, 2)."""
        c, s = np.cos(theta), np.sin(theta)
        body = np.array([[-self.a, -self.h], [self.a, -self.h]])
        return np.array([[c * x - s * y, s * x + c * y] for x, y in body])

    def normal(self, y: Array) -> Array:
        """Return the normal forces."""
        return np.array(
            [
                law.force(f.branch, -y[GAP[i]], -y[RATE[i]], f.deepest) if f.closed else 0.0
                for i, (f, law) in enumerate(zip(self.feet, self.laws, strict=True))
            ]
        )

    def free(self, y: Array, N: Array) -> tuple[Array, float]:
        """Return acceleration of the centre and of the angle under weight and normal forces."""
        r = self.arms(y[THETA])
        weight = self.g * np.array([-np.sin(self.beta), -np.cos(self.beta)])
        return weight + np.array([0.0, N.sum() / self.m]), float(r[:, 0] @ N) / self.J

    def point(self, r: Array, y: Array, centre: Array, alpha: float) -> Array:
        """Return the acceleration of a point of the body."""
        return centre + alpha * np.array([-r[1], r[0]]) - y[OMEGA] ** 2 * r

    def kinetic(self, i: int, v: float) -> float:
        """Return the friction coefficient of a foot that slips."""
        width = self.stribeck[i]
        rise = (self.static[i] - 1) / (1 + (v / width) ** 2) if width > 0 else 0.0
        return self.mu[i] * (1 + rise)

    def friction(self, y: Array, N: Array) -> Array:
        """Return the tangential forces of the present slip signs."""
        mu = [self.kinetic(i, y[SLIP[i]]) for i in (0, 1)]
        T = np.array([-f.sign * m * n for f, m, n in zip(self.feet, mu, N, strict=True)])
        held = [i for i, f in enumerate(self.feet) if f.closed and f.sign == 0]
        return self.holding(y, N, T, held)

    def holding(self, y: Array, N: Array, T: Array, held: list[int]) -> Array:
        """Return the tangential forces with those that hold the velocities of some feet."""
        if not held:
            return T
        r = self.arms(y[THETA])
        W = 1 / self.m + np.outer(r[:, 1], r[:, 1]) / self.J
        centre, alpha = self.free(y, N)
        b = np.array([self.point(r[i], y, centre, alpha)[0] for i in (0, 1)]) + W @ T
        # Their mobility has the square of this difference: it is singular to rounding there.
        if len(held) == 2 and abs(r[0, 1] - r[1, 1]) <= 1e-12 * self.a:
            whole = -b[0] / W[0, 0]  # both feet share one force: by what each can carry
            room = np.array(self.mu) * np.array(self.static) * N
            return whole * (room / room.sum() if room.sum() > 0 else np.array([0.5, 0.5]))
        T[held] = np.linalg.solve(W[np.ix_(held, held)], -b[held])
        return T

    def forced(self, y: Array) -> tuple[Array, Array, Array, Array]:
        """Return F_n, F_t, and the accelerations: of centre and angle, and of each foot."""
        N = self.normal(y)
        T = self.friction(y, N)
        centre, alpha = self.free(y, N)
        centre = centre + np.array([T.sum() / self.m, 0.0])
        arms = self.arms(y[THETA])
        alpha -= float(arms[:, 1] @ T) / self.J
        moves = np.array([self.point(r, y, centre, alpha) for r in arms])
        return N, T, np.array([*centre, alpha]), moves

    def rates(self, _: float, y: Array) -> Array:
        """Return the derivative of the state."""
        _, T, whole, moves = self.forced(y)
        out = np.zeros(14)
        out[[X, Y, THETA]], out[[VX, VY, OMEGA]] = y[[VX, VY, OMEGA]], whole
        for i, (f, law) in enumerate(zip(self.feet, self.laws, strict=True)):
            held = f.closed and f.sign == 0
            out[GAP[i]], out[RATE[i]] = y[RATE[i]], moves[i, 1]
            out[SLIP[i]] = 0.0 if held else moves[i, 0]
            out[FRICTION] -= 0.0 if held else T[i] * y[SLIP[i]]
            if f.closed:
                out[CONTACT] += law.dissipated(f.branch, -y[GAP[i]], -y[RATE[i]])
        return out

    # ---- events ----

    def guards(self) -> list[tuple[int, str, str, Callable[[Array], float]]]:
        """Return foot, kind, next branch or slip, and guard of whatever can happen now."""
        margins: list[tuple[int, str, str, Callable[[Array], float]]] = []
        for i, (f, law) in enumerate(zip(self.feet, self.laws, strict=True)):

            def at(y: Array, i: int = i) -> tuple[float, float, float]:
                return -y[GAP[i]], -y[RATE[i]], self.feet[i].deepest

            if f.closed and f.sign == 0:
                for s in (1, -1):

                    def cone(y: Array, i: int = i, s: int = s) -> float:
                        N = self.normal(y)
                        limit = self.mu[i] * self.static[i] * N[i]
                        return float(limit - s * self.friction(y, N)[i])

                    margins.append((i, "slip_start", "", cone))
            elif f.closed:
                margins.append((i, "slip_stop", "", lambda y, i=i, s=f.sign: s * y[SLIP[i]]))
            for k, (kind, _, target) in enumerate(law.exits(f.branch, 1.0, 1.0, 1.0)):

                def leave(y: Array, i: int = i, k: int = k, at: Callable = at) -> float:
                    law, branch = self.laws[i], self.feet[i].branch
                    return float(list(law.exits(branch, *at(y)))[k][1])

                margins.append((i, kind, target, leave))
        return margins

    def happen(self, y: Array, i: int, kind: str, target: str) -> None:
        """Apply an event to the foot and the state."""
        f = self.feet[i]
        if kind == "slip_stop":
            y[SLIP[i]], f.sign = 0.0, 0
        elif kind != "slip_start":
            was, spring = f.closed, 0.5 * self.laws[i].k * y[GAP[i]] ** 2
            if kind == "max_compression" and f.branch == "compression":
                f.deepest = -y[GAP[i]]
            if f.branch == "flight" or target == "flight":
                y[GAP[i]] = 0.0
            f.branch = target
            # What a dashpot leaves in the spring is lost when the foot leaves, until it comes back.
            if self.laws[i].c > 0 and kind in ("separation", "touchdown"):
                y[CONTACT] += spring if kind == "separation" else -spring
            if not f.closed:
                f.sign = 0
            elif not was:
                f.sign = int(np.sign(y[SLIP[i]]))
        if kind in ("slip_stop", "slip_start", "touchdown"):
            self.decide(y, i if kind == "slip_start" and self.static[i] > 1 else None)

    def decide(self, y: Array, released: int | None = None) -> None:
        """Set the slip signs of closed feet at rest to what satisfies the law of friction.

        Where that leaves a choice most feet stick, but not the one whose sticking just ended.
        """
        rest = [i for i, f in enumerate(self.feet) if f.closed and y[SLIP[i]] == 0.0]
        # Forces just after: at a landing both sides of the cone are zero.
        ahead = self._ahead(y)
        ahead[[SLIP[i] for i in rest]] = 0.0
        y = ahead
        N = self.normal(y)
        fits = []
        for signs in itertools.product((0, 1, -1), repeat=len(rest)):
            if any(i == released and s == 0 for i, s in zip(rest, signs, strict=True)):
                continue
            for i, s in zip(rest, signs, strict=True):
                self.feet[i].sign = s
            try:
                T, rate = self.friction(y, N), self.rates(0.0, y)
            except np.linalg.LinAlgError:
                continue
            size = 1e-12 * (np.abs(T).sum() + N.sum() + self.m * self.g)
            worst = 0.0
            for i, s in zip(rest, signs, strict=True):
                limit = self.mu[i] * self.static[i] * N[i]
                over = abs(T[i]) - limit if s == 0 else -s * rate[SLIP[i]] * self.m
                worst = max(worst, over)
            fits.append((max(worst - size, 0.0), -signs.count(0), signs))
        best = min(fits, key=lambda e: e[:2] if max(self.static) > 1 else e[0])[2]
        for i, s in zip(rest, best, strict=True):
            self.feet[i].sign = s

    # ---- the run ----

    def start(
        self,
        x_A: float = 0,
        y_A: float = 0,
        theta: float = 0,
        x_A_dot: float = 0,
        y_A_dot: float = 0,
        theta_dot: float = 0,
    ) -> Array:
        """Return the state for the place and velocity of the foot A."""
        r = self.arms(theta)
        y = np.zeros(14)
        y[[X, Y]] = np.array([x_A, y_A]) - r[0]
        y[[THETA, OMEGA]] = theta, theta_dot
        y[[VX, VY]] = np.array([x_A_dot, y_A_dot]) - theta_dot * np.array([-r[0, 1], r[0, 0]])
        y[GAP[0]], y[GAP[1]] = y_A, y_A + 2 * self.a * np.sin(theta)
        y[RATE[0]] = y_A_dot
        y[RATE[1]] = y_A_dot + 2 * self.a * np.cos(theta) * theta_dot
        y[SLIP[0]] = x_A_dot
        y[SLIP[1]] = x_A_dot - 2 * self.a * np.sin(theta) * theta_dot
        for i, f in enumerate(self.feet):
            if y[GAP[i]] < 0:
                f.branch, f.sign = "compression", int(np.sign(y[SLIP[i]]))
        self.decide(y)
        return y

    def run(self, y: Array, t_end: float, scale: float = 1e-6) -> tuple[list[Event], Array]:
        """Integrate; return all events and the end state.

        Parameters
        ----------
        y : ndarray, shape (14,)
        t_end : float
            s.
        scale : float
            Compression below which only absolute errors count; m.
        """
        t, events = 0.0, []
        atol = np.full(y.size, 1e-13)
        atol[list(GAP)], atol[list(RATE)], atol[14:] = 1e-12 * scale, 1e-10 * scale, 1e-12 * scale
        while t < t_end and len(events) < 2000:
            guards = self.guards()
            now = self._due(y, guards)
            if now is None:
                solver = DOP853(self.rates, t, y, t_end, rtol=1e-12, atol=atol)
                crossed = None
                while crossed is None and solver.status == "running":
                    failure = solver.step()
                    if solver.status == "failed":
                        raise RuntimeError(f"DOP853 at t = {solver.t}: {failure}")
                    crossed = self._crossing(solver, guards)
                t, y = (solver.t, solver.y.copy()) if crossed is None else crossed[1:]
                if crossed is None:
                    break
                now = crossed[0]
            i, kind, target, _ = guards[now]
            if t > 0:  # what happens at once is the choice of the start
                events.append(Event(t, kind, FEET[i]))
            self.happen(y, i, kind, target)
        return events, y

    @staticmethod
    def _crossing(solver: DOP853, guards: list) -> tuple[int, float, Array] | None:
        """Return the first guard that comes down through zero within the last step, and where."""
        path, best = solver.dense_output(), None
        times = np.linspace(solver.t_old, solver.t, 9)
        states = path(times).T
        for k, (*_, g) in enumerate(guards):
            values = [g(y) for y in states]
            for j in range(8):
                if values[j] > 0 >= values[j + 1]:
                    t = brentq(lambda t, g=g: g(path(t)), times[j], times[j + 1], xtol=1e-300)
                    if best is None or t < best[1]:
                        best = k, t, path(t)
                    break
        return best

    def _due(self, y: Array, guards: list) -> int | None:
        """Return the guard that passes zero at once, if any."""
        ahead = self._ahead(y)
        for k, (*_, g) in enumerate(guards):
            fall = (g(y) - g(ahead)) / _AFTER
            if g(ahead) < 0 and g(y) <= _INSTANT * fall:
                return k
        return None

    def _ahead(self, y: Array) -> Array:
        """Return the state a moment later."""
        half = y + _AFTER / 2 * self.rates(0.0, y)
        ahead: Array = y + _AFTER * self.rates(0.0, half)
        return ahead

    def foot_A(self, y: Array) -> dict[str, float]:
        """Return the state by the names of the mechanism's coordinates."""
        r = self.arms(y[THETA])[0]
        v = y[[VX, VY]] + y[OMEGA] * np.array([-r[1], r[0]])
        return {
            "x_A": y[X] + r[0],
            "y_A": y[GAP[0]],
            "theta": y[THETA],
            "x_A_dot": v[0],
            "y_A_dot": y[RATE[0]],
            "theta_dot": y[OMEGA],
            "friction_dissipation": y[FRICTION],
            "contact_dissipation": y[CONTACT],
        }
