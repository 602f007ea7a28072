"""Routh's path of a planar impact: straight pieces in impulse space, one ray after the other."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

from painleve_sym.contacts.local_mode import ContactMode
from painleve_sym.mechanics.impact.impact_class import ImpactClass

# Two rounded products and their difference: the sign of a smaller rate would be an accident.
ROUND_OFF = 4 * 2.0**-52
# det W over W_nn W_tt, and the distance of two break points, after the roundings of an inverse
# mass matrix: below it W counts as rank one, and both events happen at once.
COINCIDENT = 1e-12


class PathRay(NamedTuple):
    """A direction of the impulse: r = dP_t/dP_n, dv_n/dP_n and dv_t/dP_n."""

    name: str
    mode: ContactMode
    ratio: float
    normal_rate: float
    slip_rate: float


class PathPiece(NamedTuple):
    """A phase: impulses, velocity at its end, ∫v_n dP_n and ∫v_t dP_t."""

    name: str
    mode: ContactMode
    P_n: float
    P_t: float
    v_t: float
    v_n: float
    work_n: float
    work_t: float


class RestitutionEnd(Protocol):
    """Rule for the end of restitution, informed of the pieces before the last ray."""

    def end(self, v_n: float, rate: float) -> tuple[float, float]:
        """Return the impulse still to come along a ray, inf for never, and the final v_n."""
        ...

    def spend(self, piece: PathPiece) -> None:
        """Subtract a finished piece of restitution from the remaining budget."""
        ...


class ImpactPath:
    """The path of an impact as it is followed; its numbers are of order 1.

    d(v_t, v_n)/dP_n is constant along a ray. The slip stops at most once: in sticking v_t stays 0,
    and where |W_nt| > μ W_tt the slip that begins at v_t = 0 grows. `v_n` and `v_t` are what is
    reached, `ray` is the present one, and `case` the class of the path so far.
    """

    def __init__(
        self, W_nn: float, W_nt: float, W_tt: float, mu: float, v_n: float, v_t: float
    ) -> None:
        self.W = W_nn, W_nt, W_tt
        self.mu = mu
        self.v_n, self.v_t, self.v_n_start = v_n, v_t, v_n
        self.pieces: list[PathPiece] = []
        if v_t == 0.0:
            self.ray = self._ray_at_rest("slip")
            sticks = self.ray.mode is ContactMode.STICK
            self.case = ImpactClass.C_STICKING if sticks else ImpactClass.SLIDING
        else:
            self.ray = self._slip_ray("slip", 1 if v_t > 0.0 else -1)
            self.case = ImpactClass.SLIDING

    def _slip_ray(self, name: str, s: int) -> PathRay:
        W_nn, W_nt, W_tt = self.W
        r = -s * self.mu
        mode = ContactMode.SLIP_POS if s > 0 else ContactMode.SLIP_NEG
        return PathRay(name, mode, r, _sum(W_nn, r * W_nt), _sum(W_nt, r * W_tt))

    def _ray_at_rest(self, name: str) -> PathRay:
        W_nn, W_nt, W_tt = self.W
        if abs(W_nt) > self.mu * W_tt:
            return self._slip_ray(name, 1 if W_nt > 0.0 else -1)
        if W_tt == 0.0:  # no tangential force moves anything
            return PathRay("sticking", ContactMode.STICK, 0.0, W_nn, 0.0)
        det = W_nn * W_tt - W_nt * W_nt
        rate = det / W_tt if det > COINCIDENT * W_nn * W_tt else 0.0
        return PathRay("sticking", ContactMode.STICK, -W_nt / W_tt, rate, 0.0)

    @property
    def starts_without_collision(self) -> bool:
        """Whether an impulse along the ray can begin at v_n = 0: A < 0, or A = 0 stops the slip."""
        stops = self.W[0] > 0.0 and self.impulse_to_stop < math.inf
        return self.ray.normal_rate < 0.0 or (self.ray.normal_rate == 0.0 and stops)

    @property
    def impulse_to_stop(self) -> float:
        """P_n until v_t = 0 on the present ray; inf where it never is."""
        slowing = self.v_t * self.ray.slip_rate < 0.0
        return -self.v_t / self.ray.slip_rate if slowing else math.inf

    def _follow(self, name: str, P: float, v_t: float, v_n: float) -> None:
        # Velocities are linear in the impulse: the works take their means.
        ray, P_t = self.ray, self.ray.ratio * P
        works = P * (self.v_n + v_n) / 2, P_t * (self.v_t + v_t) / 2
        self.pieces.append(PathPiece(name, ray.mode, P, P_t, v_t, v_n, *works))
        self.v_t, self.v_n = v_t, v_n

    def _turn(self, sticking: ImpactClass, reversed_: ImpactClass) -> None:
        """Continue from v_t = 0."""
        self.ray = self._ray_at_rest("reverse slip")
        self.case = sticking if self.ray.mode is ContactMode.STICK else reversed_

    def compress(self) -> bool:
        """Follow the path to v_n = 0; False where it never gets there."""
        P_stop = self.impulse_to_stop
        P_end = -self.v_n / self.ray.normal_rate if self.ray.normal_rate > 0.0 else math.inf
        if P_stop < math.inf and P_stop <= P_end * (1 + COINCIDENT):
            v_n = self.v_n + self.ray.normal_rate * P_stop
            together = P_stop >= P_end * (1 - COINCIDENT)
            self._follow("tangential", P_stop, 0.0, 0.0 if together else v_n)
            self._turn(ImpactClass.C_STICKING, ImpactClass.C_REVERSED)
            if self.v_n == 0.0:
                P_end = 0.0
            else:
                rises = self.ray.normal_rate > 0.0
                P_end = -self.v_n / self.ray.normal_rate if rises else math.inf
        if P_end == math.inf:
            return False
        v_t = self.v_t + self.ray.slip_rate * P_end
        self._follow(f"{self.ray.name} compression", P_end, v_t, 0.0)
        return True

    def restitute(self, law: RestitutionEnd) -> bool:
        """Follow the path from v_n = 0 to where the law ends it; False where that is never."""
        P_end, v_n = law.end(self.v_n, self.ray.normal_rate)
        P_stop = self.impulse_to_stop
        if P_stop < P_end * (1 - COINCIDENT):
            reached = self.v_n + self.ray.normal_rate * P_stop
            self._follow("slip restitution", P_stop, 0.0, reached)
            law.spend(self.pieces[-1])
            self._turn(ImpactClass.R_STICKING, ImpactClass.R_REVERSED)
            P_stop = math.inf
            P_end, v_n = law.end(self.v_n, self.ray.normal_rate)
        if P_end == math.inf:
            return False
        together = P_stop <= P_end * (1 + COINCIDENT)
        v_t = 0.0 if together else self.v_t + self.ray.slip_rate * P_end
        self._follow(f"{self.ray.name} restitution", P_end, v_t, v_n)
        return True


class NewtonEnd:
    """Newton: restitution ends at v_n⁺ = −e v_n⁻."""

    def __init__(self, e: float, path: ImpactPath) -> None:
        self.target = -e * path.v_n_start + 0.0

    def end(self, v_n: float, rate: float) -> tuple[float, float]:
        """See `RestitutionEnd.end`."""
        if rate > 0.0:
            return (self.target - v_n) / rate, self.target
        return (0.0, v_n) if self.target <= v_n else (math.inf, v_n)

    def spend(self, piece: PathPiece) -> None:
        """See `RestitutionEnd.spend`."""


class PoissonEnd:
    """Poisson: restitution ends at P_r = e P_c."""

    def __init__(self, e: float, path: ImpactPath) -> None:
        self.left = e * math.fsum(piece.P_n for piece in path.pieces)

    def end(self, v_n: float, rate: float) -> tuple[float, float]:
        """See `RestitutionEnd.end`."""
        return self.left, v_n + rate * self.left

    def spend(self, piece: PathPiece) -> None:
        """See `RestitutionEnd.spend`."""
        self.left = max(0.0, self.left - piece.P_n)


class EnergeticEnd:
    """Stronge: restitution ends at E_r = −e² E_c."""

    def __init__(self, e: float, path: ImpactPath) -> None:
        self.left = -e * e * math.fsum(piece.work_n for piece in path.pieces)

    def end(self, v_n: float, rate: float) -> tuple[float, float]:
        """See `RestitutionEnd.end`."""
        if self.left == 0.0:
            return 0.0, v_n
        # v_n P + rate P²/2 = left, without the cancellation of the usual root.
        final = math.sqrt(v_n * v_n + 2 * rate * self.left)
        return (2 * self.left / (v_n + final), final) if final > 0.0 else (math.inf, v_n)

    def spend(self, piece: PathPiece) -> None:
        """See `RestitutionEnd.spend`."""
        self.left = max(0.0, self.left - piece.work_n)


def _sum(a: float, b: float) -> float:
    """Return a + b, exactly 0 where it is within the rounding of its terms."""
    value = a + b
    return value if abs(value) > ROUND_OFF * (abs(a) + abs(b)) else 0.0
