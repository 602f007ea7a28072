"""The classes of an impact with friction of one contact, by the rays of their impulse."""

from __future__ import annotations

import enum
from collections.abc import Sequence

from painleve_sym.errors import InputError


class ImpactClass(enum.StrEnum):
    """Name the course of an impact by when the slip stops (P_t) and what comes then.

    With s = sign(v_t), the slip stops at P_t = −v_t/C_s if s C_s < 0, and compression along the
    slip ends at P_c = −v_n/A_s if A_s > 0. At v_t = 0 the contact sticks iff |W_nt| ≤ μ W_tt;
    otherwise it slips in direction sign(W_nt), where A > 0 and the slip grows.

    In space the first ray is a curve on which slip turns, the condition of sticking is
    |W_tt⁻¹ w| ≤ μ with w = (W_n1, W_n2), and the slip that begins where it fails is called reverse
    whatever its angle to the one before.

    NO_IMPACT
        v_n = 0 and A_s > 0, or no slip: finite forces decide, there is no impulse. Also v_n = 0 and
        W_nn = 0, where none moves the contact along its normal.
    SLIDING
        s C_s ≥ 0, or P_t is not reached before restitution ends. Also the start from v_t = 0
        with |W_nt| > μ W_tt.
    C_STICKING
        P_t ≤ P_c or A_s ≤ 0, and |W_nt| ≤ μ W_tt: sticks in compression, to the end. With A_s ≤ 0
        and v_n = 0 it is the impact without collision. Also the start from v_t = 0.
    C_REVERSED
        P_t ≤ P_c and |W_nt| > μ W_tt: slips back from compression on.
    R_STICKING
        P_t > P_c within restitution, and |W_nt| ≤ μ W_tt.
    R_REVERSED
        P_t > P_c within restitution, and |W_nt| > μ W_tt.
    STICKING, REVERSED
        Of an impact by the final slip (`ImpactFriction`), which has no course: v_t⁺ = 0, or slip
        against the one before; its other class is ``SLIDING``.

    References
    ----------
    Wang & Mason (1992) for all but ``NO_IMPACT``; Routh (1905).
    """

    NO_IMPACT = "no_impact"
    SLIDING = "sliding"
    C_STICKING = "c_sticking"
    C_REVERSED = "c_reversed"
    R_STICKING = "r_sticking"
    R_REVERSED = "r_reversed"
    STICKING = "sticking"
    REVERSED = "reversed"

    @property
    def rays(self) -> tuple[str, ...]:
        """The rays in order: of ``slip``, ``stick`` and ``reverse``; none without a course."""
        return _RAYS.get(self, ())

    @classmethod
    def of_rays(cls, rays: Sequence[str], *, in_compression: bool = True) -> ImpactClass:
        """Return the class with these rays, the first one left during compression or restitution.

        Raises
        ------
        InputError
            No impact of one contact has these rays.
        """
        candidates = [c for c in CLASSES if c.rays == tuple(rays)]
        if not candidates:
            raise InputError(
                f"course of an impact: got rays {tuple(rays)!r}, need one of "
                f"{sorted(set(_RAYS.values()) - {()})}. Fix: name slip first; at most one follows."
            )
        return candidates[0] if in_compression else candidates[-1]


_RAYS: dict[ImpactClass, tuple[str, ...]] = {
    ImpactClass.NO_IMPACT: (),
    ImpactClass.SLIDING: ("slip",),
    ImpactClass.C_STICKING: ("slip", "stick"),
    ImpactClass.C_REVERSED: ("slip", "reverse"),
    ImpactClass.R_STICKING: ("slip", "stick"),
    ImpactClass.R_REVERSED: ("slip", "reverse"),
}
CLASSES = tuple(_RAYS)[1:]
"""The classes of an impact along its path."""
