"""Coefficients of the normal acceleration of one contact, and how near its paradox is.

While a contact slides along the unit vector e of its tangents, its normal acceleration is
A F_n + B with

    A = W_nn - μ w·e,    B = b_n,

where w couples the normal to the tangents. A is negative for some direction of slip where μ exceeds
``μ_P = W_nn/|w|``: in the plane for one of two directions, in space in a sector around that of w.
Over all normals that a surface might have at this point, μ_P is least at
``2 √(λ₁ λ₃)/(λ₃ - λ₁)``, with the extreme eigenvalues of W: one number for a foot, whatever it
stands on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from painleve_sym.plain_data import finite
from painleve_sym.problem.friction_set import unit_vector
from painleve_sym.problem.risk import (
    friction_threshold,
    least_over_normals,
    schur_complement,
    sector_half_angle,
    slip_slope,
)
from painleve_sym.problem.rounding import FloatArray as Array
from painleve_sym.problem.rounding import rounded_difference


class Sector(NamedTuple):
    """The directions of slip for which A < 0.

    Attributes
    ----------
    direction : tuple of float
        Unit vector of its middle along the tangents.
    half_angle : float
        Slip within this angle of it has A < 0; rad. 0 in the plane, which has this direction alone.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> W = [[2.0, 0.0, 1.5], [0.0, 2.0, 0.0], [1.5, 0.0, 2.0]]
    >>> [own] = ps.contact(W, [-1.0, 0.0, 0.0], 1.5).coefficients
    >>> own.sector.direction, round(own.sector.half_angle, 4)
    ((0.0, 1.0), 0.4759)
    """

    direction: tuple[float, ...]
    half_angle: float

    @classmethod
    def of(cls, W: Array, mu: float, critical: float) -> Sector | None:
        """Return the sector of a mobility W and a friction μ; None where A >= 0 for all slip.

        `critical` is μ_P of W.
        """
        if not mu > critical:
            return None
        half = sector_half_angle(critical, mu) if len(W) == 3 else 0.0
        return cls(unit_vector((W[1:, 0] + 0.0).tolist()), half)  # no -0.0

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        return {"direction": list(self.direction), "half_angle": self.half_angle}


class NormalCoefficients(NamedTuple):
    """The lines a_n = A F_n + B of one contact in slip and in sticking, the others open.

    Attributes
    ----------
    direction : tuple of float
        Unit vector e of the slip along the tangents. At rest that of the free acceleration b_t;
        where this is 0, that of w, along which a normal force pushes; zeros where both are 0.
    A, A_pull : float
        A in slip along `direction` for F_n > 0, and for F_n < 0, which a bilateral contact has;
        1/kg. A value within rounding of its terms is exactly 0.
    B : float
        b_n; m/s².
    A_stick, B_stick : float
        A′ and B′ of a_n = A′ F_n + B′ in sticking; 1/kg and m/s².
    excess : float
        μ |w| − W_nn: positive where A < 0 for some direction of slip, and a bilateral slip along w
        has no solution or two; 1/kg.
    mu_P : float
        Least friction with A < 0 for some direction of slip; infinite where no friction has it.
    sector : Sector or None
        The directions of slip with A < 0; None where A >= 0 for all of them.
    least_over_normals : float
        Least μ_P over all directions of the surface's normal; infinite where none has a paradox.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> [own] = ps.classify("rod", {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}).coefficients
    >>> own.direction, round(own.A, 6), round(own.B, 6), round(own.mu_P, 6)
    ((-1.0,), -0.033745, -8.958529, 1.375259)
    """

    direction: tuple[float, ...]
    A: float
    A_pull: float
    B: float
    A_stick: float
    B_stick: float
    excess: float
    mu_P: float
    sector: Sector | None
    least_over_normals: float

    @classmethod
    def of(
        cls,
        W: Array,
        b: Array,
        mu: float,
        slip: Sequence[float],
        sticking: tuple[float, float] | None = None,
    ) -> NormalCoefficients:
        """Return the coefficients of a contact with a normal row and those of one ball.

        `sticking` are A′ and B′, where they are known more exactly than from W and b.
        """
        W_nn, w = W[0, 0], W[0, 1:]
        ways = map(unit_vector, (slip, b[1:].tolist(), w.tolist()))
        e = next(filter(None, ways), (0.0,) * len(w))
        if sticking is None:
            A_stick, B_stick = schur_complement(W, b, 1)
            sticking = float(A_stick.item()), float(B_stick.item())
        critical = float(friction_threshold(W))
        return cls(
            tuple(v + 0.0 for v in e),  # no -0.0
            A=float(slip_slope(W, mu, e)),
            A_pull=float(slip_slope(W, mu, e, -1)),
            B=float(b[0]),
            A_stick=sticking[0],
            B_stick=sticking[1],
            excess=0.0 - float(rounded_difference(W_nn, mu * math.hypot(*w.tolist()))),
            mu_P=critical,
            sector=Sector.of(W, mu, critical),
            least_over_normals=float(least_over_normals(W)),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys; infinite numbers are None."""
        data = {name: getattr(self, name) for name in self._fields}
        data |= {name: finite(data[name]) for name in ("mu_P", "least_over_normals")}
        sector = None if self.sector is None else self.sector.to_dict()
        return data | {"direction": list(self.direction), "sector": sector}
