"""The complete planar impact of one contact in numbers: Routh's path, ray by ray."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from painleve_sym.checks import checked_number, mobility_faults
from painleve_sym.contacts.impact.energy_gain import contact_energy, gain_notice
from painleve_sym.contacts.impact.path import ImpactPath, ImpactPhase
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.files import plain_fields
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.impact.impact_class import ImpactClass


class ImpactEnd(enum.Enum):
    """Name how an impact ends.

    SEPARATION
        v_n⁺ > 0: the bodies leave each other.
    PERSISTENT
        v_n⁺ = 0: the contact stays closed, finite forces decide what it does next. So it is with
        restitution 0, with Newton's law without collision, and where there is no impact at all.
    JAM
        The impulse has no end: on the last ray dv_n/dP_n = 0, and the velocity or energy that
        ends the impact is never reached. It needs a W of rank one (a pivoted strut) or W_nn = 0;
        friction then carries any force. There is no rigid impact, but a compliant one.
    """

    SEPARATION = "separation"
    PERSISTENT = "persistent"
    JAM = "jam"


@dataclass(frozen=True)
class Impact:
    """The complete solution of a planar impact.

    Attributes
    ----------
    case : ImpactClass
        Wang and Mason's class; ``NO_IMPACT`` where there is none.
    end : ImpactEnd
    restitution : str
        Name of the law.
    velocity_before, velocity : tuple of float
        (v_n, v_t) before and after; after what the impulse does up to the jam where it jams; m/s.
    phases : tuple of ImpactPhase
        In order, of no length where two events coincide or with restitution 0. Empty without
        impact; where it jams, those before the jam.
    W : tuple of tuple of float
        Mobility, rows and columns (n, t); 1/kg.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> W = [[2.0, 0.5], [0.5, 1.0]]
    >>> impact = ps.solve_impact(W, 0.5, [-1.0, 0.2], "energetic", 0.5)
    >>> impact.case, impact.velocity
    (<ImpactClass.SLIDING: 'sliding'>, (0.5, 0.2))
    >>> [phase.name for phase in impact.phases]
    ['slip compression', 'slip restitution']
    """

    case: ImpactClass
    end: ImpactEnd
    restitution: str
    velocity_before: tuple[float, float]
    velocity: tuple[float, float]
    phases: tuple[ImpactPhase, ...]

    def __repr__(self) -> str:
        """Return law, class, end and velocities in one line."""
        (n, t), (n_after, t_after) = self.velocity_before, self.velocity
        return (
            f"Impact by {self.restitution!r}: {self.case.value}, ends in {self.end.value}, "
            f"(v_n, v_t) = ({n:.6g}, {t:.6g}) to ({n_after:.6g}, {t_after:.6g}) m/s"
        )

    W: tuple[tuple[float, float], tuple[float, float]]

    @property
    def without_collision(self) -> bool:
        """Whether it is an impact though v_n⁻ = 0: a tangential impact."""
        return self.velocity_before[0] == 0.0 and self.case is not ImpactClass.NO_IMPACT

    @property
    def normal_impulse(self) -> float:
        """P_n of the impact, up to the jam where it jams; N s."""
        return math.fsum(phase.normal_impulse for phase in self.phases)

    @property
    def tangential_impulse(self) -> float:
        """P_t of the impact; N s. |P_t| ≤ μ P_n."""
        return math.fsum(phase.tangential_impulse for phase in self.phases)

    @property
    def energy_change(self) -> float:
        """Work of the contact; J. The change of kinetic energy over a surface at rest."""
        works = [w for p in self.phases for w in (p.normal_work, p.tangential_work)]
        return math.fsum(works)

    @property
    def notice(self) -> str:
        """One sentence where the impact adds energy, which Newton's law can do; else empty.

        Its percentage is that of the least kinetic energy with these contact velocities.
        """
        gain = self.energy_change
        if gain <= 0:
            return ""
        return gain_notice(gain, contact_energy(self.W, self.velocity_before), self.restitution)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        start = ("case", "end", "restitution", "velocity_before", "velocity")
        sums = ("normal_impulse", "tangential_impulse", "energy_change")
        return plain_fields(self, *start, *sums, "phases")


def solve_impact(
    W: Sequence[Sequence[float]],
    mu: float,
    velocity: tuple[float, float],
    restitution: str = "energetic",
    e: float = 0.75,
) -> Impact:
    """Return the complete solution of a planar impact of one contact with Coulomb friction.

    d(v_n, v_t)/dP_n = W (1, r), with r = P_t′/P_n′ = −μ sign(v_t) in slip and r = −W_nt/W_tt in
    sticking: a path of straight pieces with exact break points where v_t = 0 (the contact then
    sticks iff |W_nt| ≤ μ W_tt, else slips in direction sign(W_nt)), where v_n = 0 (compression
    ends), and where the law ends restitution. At most three pieces; nothing is iterated.
    Signs: v_n < 0 on approach, P_n ≥ 0 pushes the bodies apart, P_t counts along v_t.

    Parameters
    ----------
    W : array_like, shape (2, 2)
        Rows and columns in the order (n, t), like the velocity: [[W_nn, W_nt], [W_nt, W_tt]];
        symmetric, positive definite or of rank one; 1/kg.
    mu : float
        Friction coefficient, ≥ 0.
    velocity : tuple of float
        (v_n, v_t) before the impact, v_n ≤ 0; exactly 0 means at rest; m/s.
    restitution : {"energetic", "poisson", "newton"}
        Agree where the impact follows one ray, where W_nt = 0, and for e = 0. Newton's gives
        nothing back without collision, and can add energy (see `Impact.notice`); the others never
        do in the impact of this single contact.
    e : float
        Coefficient of restitution of that law, in [0, 1].

    Returns
    -------
    Impact
        ``NO_IMPACT`` where v_n = 0 and A > 0, or nothing slips; end ``JAM`` where the impulse would
        never end. A within rounding of 0 counts as 0, where the slip stops at v_n = 0.

    Raises
    ------
    InputError
        All faults at once: entries that are not finite, v_n > 0, mu < 0, e outside [0, 1], W not
        symmetric positive semidefinite, an unknown law; or results beyond the floating range.

    References
    ----------
    Routh (1905); Keller (1986); Stronge (1990); Wang & Mason (1992); Nordmark, Dankowicz &
    Champneys (2009).

    Examples
    --------
    >>> from painleve_sym import solve_impact
    >>> impact = solve_impact([[2.0, 0.0], [0.0, 1.0]], 0.3, (-1.0, 0.5), "newton", 0.5)
    >>> impact.case
    <ImpactClass.SLIDING: 'sliding'>
    """
    W_nn, W_nt, W_tt, mu, v_n, v_t, e = _checked(W, mu, velocity, restitution, e)
    given, before = ((W_nn, W_nt), (W_nt, W_tt)), (v_n, v_t)
    path = ImpactPath((W_nn, W_nt, W_tt), mu, v_n, v_t, restitution)
    if not path.begins:
        none, end = ImpactClass.NO_IMPACT, ImpactEnd.PERSISTENT
        return Impact(none, end, restitution, before, before, (), given)
    try:
        ended = path.follow(e)
    except OverflowError as error:
        raise InputError(
            "solve impact: impulses or energies leave the range of floating point. "
            "Fix: give smaller velocities, or W in other units."
        ) from error
    end = ImpactEnd.SEPARATION if path.v_n > 0.0 else ImpactEnd.PERSISTENT
    after = path.phases[-1].velocity if path.phases else before
    end = end if ended else ImpactEnd.JAM
    return Impact(path.case, end, restitution, before, after, tuple(path.phases), given)


def _checked(
    W: Sequence[Sequence[float]],
    mu: float,
    velocity: tuple[float, float],
    restitution: str,
    e: float,
) -> tuple[float, ...]:
    """Return W_nn, W_nt, W_tt, mu, v_n, v_t, e as floats; raise with every fault."""
    try:
        (W_nn, W_nt), (W_tn, W_tt) = ((float(w) for w in row) for row in W)
        v_n, v_t = (float(v) for v in velocity)
        mu, e = float(mu), float(e)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"solve impact: got W = {W!r}, mu = {mu!r}, velocity = {velocity!r}, e = {e!r}, need "
            f"numbers, W of shape (2, 2) and velocity (v_n, v_t). Fix: check the shapes."
        ) from error
    entries = {"W_nn": W_nn, "W_nt": W_nt, "W_tn": W_tn, "W_tt": W_tt, "mu": mu, "e": e}
    entries |= {"v_n": v_n, "v_t": v_t}
    faults = [fault for n, v in entries.items() if (fault := checked_number(v, n)[1])]
    faults = faults or mobility_faults(W_nn, W_nt, W_tn, W_tt)
    if mu < 0:
        faults.append(f"mu: got {mu!r}, need mu >= 0.")
    if v_n > 0:
        faults.append(f"v_n: got {v_n!r} m/s, need v_n <= 0: the contact is opening.")
    if e < 0 or e > 1:
        faults.append(f"e: got {e!r}, need 0 <= e <= 1.")
    if str(restitution) not in RESTITUTIONS:
        faults.append(unknown_name("restitution law", restitution, RESTITUTIONS))
    if faults:
        raise InputError("solve impact: " + " ".join(faults))
    return W_nn, (W_nt + W_tn) / 2, W_tt, mu, v_n, v_t, e
