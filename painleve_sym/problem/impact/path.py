"""Phases of an impact, and Routh's path in the plane: straight pieces, one ray after the other."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from painleve_sym.equality import Compared
from painleve_sym.laws.restitution import Measure
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.rounding import rounded_sum

# det W over W_nn W_tt, and the distance of two break points, after the roundings of an inverse
# mass matrix: below it W counts as rank one, and both events happen at once.
COINCIDENT = 1e-12
# Members of an enumeration take longer to look up.
_VELOCITY, _IMPULSE = Measure.VELOCITY, Measure.IMPULSE


class PathRay(NamedTuple):
    """A direction of the impulse: r = dP_t/dP_n, dv_n/dP_n and dv_t/dP_n, and the sign of slip."""

    name: str
    mode: ContactMode
    side: float
    ratio: float
    normal_rate: float
    slip_rate: float


@dataclass(frozen=True, eq=False)
class ImpactPhase(Compared):
    """A part of an impact: of compression or restitution, in slip or sticking.

    Attributes
    ----------
    name : str
        ``tangential`` (slip that stops in compression), or slip, sticking or reverse slip
        with compression or restitution, such as ``sticking compression``; by the final slip
        ``slip``, ``sticking`` or ``reverse slip`` of the whole impact. Reverse slip begins
        after a stop: backwards in the plane, in space at some angle to the slip before.
    mode : ContactMode
        ``SLIP_POS``, ``SLIP_NEG``, in space ``SLIP``, or ``STICK``.
    normal_impulse : float
        P_n ≥ 0 of this phase; N s.
    tangential_impulse : tuple of float
        (P_t,) of this phase, in space (P_1, P_2); N s.
    velocity : tuple of float
        (v_n, v_t) at its end, in space (v_n, v_1, v_2); m/s.
    normal_work, tangential_work : float
        ∫v_n dP_n (negative: stored in compression) and ∫v_t·dP_t ≤ 0 (friction); J.
    direction : tuple of float
        Unit vector of the slip at its end, or that along which slip stops there; 0 in sticking.
        One number in the plane, two in space. In the plane it is that of the whole phase.
    """

    name: str
    mode: ContactMode
    normal_impulse: float
    tangential_impulse: tuple[float, ...]
    velocity: tuple[float, ...]
    normal_work: float
    tangential_work: float
    direction: tuple[float, ...]

    @property
    def impulse(self) -> tuple[float, ...]:
        """P_n and P_t of this phase, rows in the order of W; N s."""
        return (self.normal_impulse, *self.tangential_impulse)


class ImpactPath:
    """The path of an impact as it is followed; its numbers are of order 1, those of phases are not.

    d(v_t, v_n)/dP_n is constant along a ray. The slip stops at most once: in sticking v_t stays 0,
    and where |W_nt| > μ W_tt the slip that begins at v_t = 0 grows. `v_n` and `v_t` are what is
    reached, `ray` is the present one, `case` the class of the path so far, and `spent` what of the
    law's measure, P_n or ∫v_n dP_n, compression or restitution has taken.
    """

    def __init__(
        self, W: tuple[float, float, float], mu: float, v_n: float, v_t: float, measure: Measure
    ) -> None:
        # Powers of two leave every digit, and keep squares of the velocities in range.
        W_nn, W_nt, W_tt = W
        self.mass = down = binary_exponent(W_nn, W_tt)
        self.speed = binary_exponent(v_n, v_t)
        self.W = math.ldexp(W_nn, -down), math.ldexp(W_nt, -down), math.ldexp(W_tt, -down)
        self.v_n, self.v_t = math.ldexp(v_n, -self.speed), math.ldexp(v_t, -self.speed)
        self.mu, self.measure, self.spent = mu, measure, 0.0
        self.phases: list[ImpactPhase] = []
        self.case = ImpactClass.SLIDING
        if self.v_t != 0.0:
            self.ray = self._slip_ray("slip", 1 if self.v_t > 0.0 else -1)
            return
        self.ray = self._ray_at_rest("slip")
        if self.ray.mode is ContactMode.STICK:
            self.case = ImpactClass.C_STICKING

    def _slip_ray(self, name: str, s: int) -> PathRay:
        W_nn, W_nt, W_tt = self.W
        r = -s * self.mu
        mode = ContactMode.SLIP_POS if s > 0 else ContactMode.SLIP_NEG
        rates = rounded_sum(W_nn, r * W_nt), rounded_sum(W_nt, r * W_tt)
        return PathRay(name, mode, float(s), r, *rates)

    def _ray_at_rest(self, name: str) -> PathRay:
        W_nn, W_nt, W_tt = self.W
        if rounded_sum(abs(W_nt), -self.mu * W_tt) > 0.0:
            return self._slip_ray(name, 1 if W_nt > 0.0 else -1)
        if W_tt == 0.0:  # no tangential force moves anything
            return PathRay("sticking", ContactMode.STICK, 0.0, 0.0, W_nn, 0.0)
        det = W_nn * W_tt - W_nt * W_nt
        rate = det / W_tt if det > COINCIDENT * W_nn * W_tt else 0.0
        return PathRay("sticking", ContactMode.STICK, 0.0, -W_nt / W_tt, rate, 0.0)

    @property
    def begins(self) -> bool:
        """Whether there is an impact: an approach, or at v_n = 0 A < 0, or A = 0 stops the slip."""
        rate = self.ray.normal_rate
        if self.v_n != 0.0 or rate < 0.0:
            return True
        return rate == 0.0 and self.W[0] > 0.0 and self._impulse_to_stop < math.inf

    @property
    def _impulse_to_stop(self) -> float:
        """P_n until v_t = 0 on the present ray; inf where it never is."""
        slowing = self.v_t * self.ray.slip_rate < 0.0
        return -self.v_t / self.ray.slip_rate if slowing else math.inf

    def follow(self, share: float) -> bool:
        """Follow the path to where a share of the measure of compression has come back.

        False where it never gets there.
        """
        due = -share * self.v_n + 0.0
        if not self._follow_part("compression", _VELOCITY, 0.0):
            return False
        if self.measure is not _VELOCITY:
            due = share * self.spent if self.measure is _IMPULSE else -share * self.spent
        self.spent = 0.0
        return self._follow_part("restitution", self.measure, due)

    def _end(self, measure: Measure, due: float) -> tuple[float, float]:
        """Return what `impulse_to_end` does for the present ray; `due` is of the whole part."""
        v_n, rate = self.v_n, self.ray.normal_rate
        if measure is _VELOCITY and rate <= 0.0 and self.phases and due <= v_n:
            return 0.0, v_n
        return impulse_to_end(measure, v_n, rate, due, max(0.0, due - self.spent))

    def _follow_part(self, part: str, measure: Measure, due: float) -> bool:
        """Follow compression or restitution to its end; False where it never gets there."""
        compresses = part == "compression"
        P_end, v_n = self._end(measure, due)
        P_stop, sooner = self._impulse_to_stop, P_end * (1 - COINCIDENT)
        # A slip that stops with the compression leaves it a phase of no length.
        if P_stop < math.inf and P_stop <= (P_end * (1 + COINCIDENT) if compresses else sooner):
            reached = self.v_n + self.ray.normal_rate * P_stop
            name = "tangential" if compresses else "slip restitution"
            self._advance(name, P_stop, v_n if P_stop >= sooner else reached, 0.0)
            self.ray = self._ray_at_rest("reverse slip")
            self.case = AFTER_STOP[part, self.ray.mode is ContactMode.STICK]
            (P_end, v_n), P_stop = self._end(measure, due), math.inf
        if P_end == math.inf:
            return False
        together = P_stop <= P_end * (1 + COINCIDENT)
        v_t = 0.0 if together else self.v_t + self.ray.slip_rate * P_end
        self._advance(f"{self.ray.name} {part}", P_end, v_n, v_t)
        return True

    def _advance(self, name: str, P: float, v_n: float, v_t: float) -> None:
        # Velocities are linear in the impulse: the works take their means.
        P_t = self.ray.ratio * P
        work_n, work_t = P * (self.v_n + v_n) / 2, P_t * (self.v_t + v_t) / 2
        self.spent += P if self.measure is _IMPULSE else work_n
        self.v_n, self.v_t = v_n, v_t
        speed, impulse, energy = self.speed, self.speed - self.mass, 2 * self.speed - self.mass
        self.phases.append(
            ImpactPhase(
                name,
                self.ray.mode,
                math.ldexp(P, impulse) + 0.0,
                (math.ldexp(P_t, impulse) + 0.0,),
                (math.ldexp(v_n, speed) + 0.0, math.ldexp(v_t, speed) + 0.0),
                math.ldexp(work_n, energy) + 0.0,
                math.ldexp(work_t, energy) + 0.0,
                (self.ray.side,),
            )
        )


AFTER_STOP = {
    ("compression", True): ImpactClass.C_STICKING,
    ("compression", False): ImpactClass.C_REVERSED,
    ("restitution", True): ImpactClass.R_STICKING,
    ("restitution", False): ImpactClass.R_REVERSED,
}


def binary_exponent(*numbers: float) -> int:
    """Return k for which 2**k is just above the largest of the numbers in size."""
    return math.frexp(max(map(abs, numbers)))[1]


def impulse_to_end(
    measure: Measure, v_n: float, rate: float, due: float, left: float
) -> tuple[float, float]:
    """Return P_n along a ray to where a measure ends it, inf for never, and v_n there.

    The rate is dv_n/dP_n. `due` is the final velocity, `left` the impulse P_n or the work
    ∫v_n dP_n that is still to come.
    """
    if measure is _VELOCITY:
        return ((due - v_n) / rate, due) if rate > 0.0 else (math.inf, v_n)
    if measure is _IMPULSE:
        return left, v_n + rate * left
    if left == 0.0:
        return 0.0, v_n
    # v_n P + rate P²/2 = left, without the cancellation of the usual root.
    final = math.sqrt(max(0.0, v_n * v_n + 2 * rate * left))
    return (2 * left / (v_n + final), final) if final > 0.0 else (math.inf, v_n)
