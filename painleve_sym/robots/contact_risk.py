"""The risk of a contact of a robot: at a pose, and the least over poses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from painleve_sym.arrays import Array
from painleve_sym.equality import Compared
from painleve_sym.plain_data import finite, plain_fields
from painleve_sym.problem.coefficients import Sector
from painleve_sym.problem.impact.one_contact import Impact
from painleve_sym.problem.risk import slip_angle

_IMPACT = ("restitution", "velocity", "normal_impulse", "tangential_impulse", "energy_change")


@dataclass(frozen=True, eq=False, repr=False)
class ContactRisk(Compared):
    """The contact of a robot at a pose.

    Attributes
    ----------
    W : ndarray, shape (3, 3)
        Mobility with the rows n, t1, t2 of the contact; 1/kg.
    mu : float or None
        Friction coefficient.
    mu_P : float
        A < 0 for some direction of slip exactly where the friction coefficient exceeds this.
        Infinite beyond 1e9, where |w| is the rounding of 0.
    direction : tuple of float
        Unit vector of the worst slip along t1 and t2; nan where `mu_P` is infinite.
    worst_direction : ndarray, shape (3,)
        The same in the axes of the world.
    sector : Sector or None
        The directions of slip with A < 0 for `mu`; None up to `mu_P`, and without `mu`.
    least_over_normals : float
        The least `mu_P` of all surface normals.
    gradient : dict of str to float
        Derivatives of `mu_P` by joint values, 1/rad or 1/m; nan where `mu_P` is infinite.
    impact : Impact or None
        The impact without collision of slip at 1 m/s along the worst direction, by the energetic
        law with e = 0.75; its impulses grow with the velocity. None up to `mu_P`, without `mu`,
        and where W is singular.
    """

    W: Array
    mu: float | None
    mu_P: float
    direction: tuple[float, ...]
    worst_direction: Array
    sector: Sector | None
    least_over_normals: float
    gradient: dict[str, float]
    impact: Impact | None

    def __repr__(self) -> str:
        """Return the critical friction and the worst direction in one line."""
        if math.isinf(self.mu_P):
            return f"ContactRisk mu_P = inf, least over normals {self.least_over_normals:.6g}"
        worst = f"worst slip at {math.degrees(slip_angle(self.direction)):.4g} deg from t1"
        if self.sector is not None:
            worst += f", A < 0 within {math.degrees(self.sector.half_angle):.4g} deg of it"
        least = f"least over normals {self.least_over_normals:.6g}"
        return f"ContactRisk mu_P = {self.mu_P:.6g}, {least}, {worst}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data; infinite numbers are None."""
        return {
            "W": (self.W + 0.0).tolist(),
            "mu_P": finite(self.mu_P),
            "direction": [finite(v + 0.0) for v in self.direction],
            "sector": None if self.sector is None else self.sector.to_dict(),
            "worst_direction": [finite(v + 0.0) for v in self.worst_direction.tolist()],
            "least_over_normals": finite(self.least_over_normals),
            "gradient": {n: finite(g + 0.0) for n, g in self.gradient.items()},
            "impact": None if self.impact is None else plain_fields(self.impact, *_IMPACT),
        }


@dataclass(frozen=True, eq=False)
class LeastRisk(Compared):
    """The pose with the least `mu_P` that a search over joint values within limits reached.

    Attributes
    ----------
    mu_P : float
        Infinite where no friction is enough in any pose that was looked at; 0 where the search ends
        beside a pose in which the contact cannot move along its normal.
    joints : dict of str to float
        rad or m.
    """

    mu_P: float
    joints: dict[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        return {"mu_P": finite(self.mu_P), "joints": self.joints}
