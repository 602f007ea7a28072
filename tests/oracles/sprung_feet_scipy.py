"""A block on two compliant feet with tangential springs, written by hand and integrated with SciPy.

The state has the deflections xi themselves: F_t = -k_t xi of a foot that sticks, and in slip along
s xi = s mu F_n/k_t, so that friction slips at v_t - s mu F_n'/k_t.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.oracles.feet_scipy import (
    CONTACT,
    FRICTION,
    GAP,
    OMEGA,
    RATE,
    SLIP,
    THETA,
    VX,
    VY,
    Block,
    X,
    Y,
)

Array = NDArray[np.float64]

XI = (14, 15)
_AT_ONCE = 1e-11
"""Of a guard, in N or m/s: what a real event passes within `_AFTER`, and rounding does not."""


@dataclass
class SprungBlock(Block):
    """A block whose feet have tangential springs; None for a foot with Coulomb friction."""

    springs: tuple[float | None, float | None] = (None, None)

    def friction(self, y: Array, N: Array) -> Array:
        """Return the tangential forces: of springs first, then of what holds a velocity."""
        T, held = np.zeros(2), list[int]()
        for i, (f, k_t) in enumerate(zip(self.feet, self.springs, strict=True)):
            if f.closed and f.sign:
                T[i] = -f.sign * self.mu[i] * N[i]
            elif f.closed and k_t is not None:
                T[i] = -k_t * y[XI[i]]
            elif f.closed:
                held.append(i)
        return self.holding(y, N, T, held)

    def yields(self, y: Array, moves: Array) -> Array:
        """Return mu F_n'/k_t of each foot, 0 without a spring."""
        yields = np.zeros(2)
        for i, (law, k_t) in enumerate(zip(self.laws, self.springs, strict=True)):
            if k_t is not None:
                depth = max(-y[GAP[i]], 0.0)
                stiffness = law.n * law.k * depth ** (law.n - 1) if law.n != 1 else law.k
                change = -stiffness * y[RATE[i]] - law.c * moves[i, 1]
                yields[i] = self.mu[i] * change / k_t
        return yields

    def rates(self, _: float, y: Array) -> Array:
        """Return the derivative of the state."""
        _, T, whole, moves = self.forced(y)
        yields = self.yields(y, moves)
        out = np.zeros(16)
        out[[X, Y, THETA]], out[[VX, VY, OMEGA]] = y[[VX, VY, OMEGA]], whole
        for i, (f, law, k_t) in enumerate(zip(self.feet, self.laws, self.springs, strict=True)):
            held = f.closed and f.sign == 0 and k_t is None
            out[GAP[i]], out[RATE[i]] = y[RATE[i]], moves[i, 1]
            out[SLIP[i]] = 0.0 if held else moves[i, 0]
            if f.closed and f.sign:
                out[XI[i]] = f.sign * yields[i]
                out[FRICTION] -= T[i] * (y[SLIP[i]] - f.sign * yields[i])
            elif f.closed and k_t is not None:
                out[XI[i]] = y[SLIP[i]]
            if f.closed:
                out[CONTACT] += law.dissipated(f.branch, -y[GAP[i]], -y[RATE[i]])
        return out

    def guards(self) -> list[tuple[int, str, str, Callable[[Array], float]]]:
        """Return the guards, of sprung feet with the ends of their own stick and slip."""
        own = []
        for i, kind, target, guard in super().guards():
            k_t = self.springs[i]
            if k_t is None or kind not in ("slip_start", "slip_stop"):
                own.append((i, kind, target, guard))
        for i, (f, k_t) in enumerate(zip(self.feet, self.springs, strict=True)):
            if k_t is None or not f.closed:
                continue
            if f.sign:

                def stops(y: Array, i: int = i, s: int = f.sign) -> float:
                    return float(s * y[SLIP[i]] - self.yields(y, self.forced(y)[3])[i])

                own.append((i, "slip_stop", "", stops))
                continue
            for s in (1, -1):

                def bears(y: Array, i: int = i, s: int = s, k_t: float = k_t) -> float:
                    return float(self.mu[i] * self.normal(y)[i] - s * k_t * y[XI[i]])

                own.append((i, "slip_start", str(s), bears))
        return own

    def happen(self, y: Array, i: int, kind: str, target: str) -> None:
        """Apply an event to the foot and the state."""
        f, k_t = self.feet[i], self.springs[i]
        if k_t is None:
            super().happen(y, i, kind, target)
        elif kind == "slip_start":
            f.sign = int(target)
        elif kind == "slip_stop":
            y[XI[i]], f.sign = f.sign * self.mu[i] * self.normal(y)[i] / k_t, 0
        else:
            was, jumps = f.closed, f.branch == "flight" and self.laws[i].c > 0
            yields = self.yields(y, self.forced(y)[3])[i]
            super().happen(y, i, kind, target)
            if f.closed != was:
                y[XI[i]] = 0.0
            if f.closed and not was and (jumps or abs(y[SLIP[i]]) < yields):
                f.sign = 0

    def start(self, **place: float) -> Array:
        """Return the state for the place and velocity of the foot A."""
        y = np.append(super().start(**place), [0.0, 0.0])
        for i, (f, k_t) in enumerate(zip(self.feet, self.springs, strict=True)):
            if k_t is not None:
                y[XI[i]] = f.sign * self.mu[i] * self.normal(y)[i] / k_t
        return y

    def decide(self, y: Array, released: int | None = None) -> None:
        """Set the slip signs of Coulomb feet at rest; a sprung foot has no choice."""
        if None in self.springs and len(y) == 16:
            super().decide(y, released)

    def _due(self, y: Array, guards: list) -> int | None:
        ahead = self._ahead(y)
        real = [g if g[3](ahead) < -_AT_ONCE else (*g[:3], lambda _: 1.0) for g in guards]
        return super()._due(y, real)
