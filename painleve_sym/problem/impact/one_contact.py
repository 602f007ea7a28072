"""The complete impact of one contact in numbers, in the plane and in space."""

from __future__ import annotations

import enum
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from painleve_sym.choices import ImpactFriction, ImpactFrictionLike, chosen
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.laws.restitution import Measure, RestitutionLaw, check_final_slip
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.plain_data import plain_fields
from painleve_sym.problem.impact.energy_gain import least_energy_notice
from painleve_sym.problem.impact.final_slip import final_slip_course
from painleve_sym.problem.impact.inputs import impact_inputs
from painleve_sym.problem.impact.path import ImpactPath, ImpactPhase
from painleve_sym.problem.impact.spatial import InvariantDirection, course_in_space, invariant_ones
from painleve_sym.problem.impact.within_plane import axes_of_motion, in_plane, phase_along

_PATH = ImpactFriction.PATH


class ImpactEnd(enum.StrEnum):
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


@dataclass(frozen=True, eq=False)
class Impact(Compared):
    """The complete solution of an impact of one contact.

    Attributes
    ----------
    case : ImpactClass
        Wang and Mason's class; ``NO_IMPACT`` where there is none.
    end : ImpactEnd
    restitution : str
        Name of the law.
    velocity_before, velocity : tuple of float
        (v_n, v_t), in space (v_n, v_1, v_2), before and after; after what the impulse does up to
        the jam where it jams; m/s.
    phases : tuple of ImpactPhase
        In order, of no length where two events coincide or with restitution 0. Empty without
        impact; where it jams, those before the jam.
    W : tuple of tuple of float
        Mobility, rows and columns (n, t), in space (n, t1, t2); 1/kg.
    impact_friction : ImpactFriction
        Whether friction opposed the slip of each moment along the path, or the final slip.
    is_unique : bool
        Whether no other impulse obeys the law. In the plane it always is; in space several final
        slips may be possible, and that of the least normal impulse is taken.

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
    velocity_before: tuple[float, ...]
    velocity: tuple[float, ...]
    phases: tuple[ImpactPhase, ...]

    def __repr__(self) -> str:
        """Return law, class, end and velocities in one line."""
        names = "v_n, v_t" if len(self.W) == 2 else "v_n, v_1, v_2"
        before, after = (
            ", ".join(f"{v:.6g}" for v in values)
            for values in (self.velocity_before, self.velocity)
        )
        return (
            f"Impact by {self.restitution!r}: {self.case.value}, ends in {self.end.value}, "
            f"({names}) = ({before}) to ({after}) m/s"
        )

    W: tuple[tuple[float, ...], ...]
    impact_friction: ImpactFriction = ImpactFriction.PATH
    is_unique: bool = True

    @property
    def without_collision(self) -> bool:
        """Whether it is an impact though v_n⁻ = 0: a tangential impact."""
        return self.velocity_before[0] == 0.0 and self.case is not ImpactClass.NO_IMPACT

    @property
    def normal_impulse(self) -> float:
        """P_n of the impact, up to the jam where it jams; N s."""
        return math.fsum(phase.normal_impulse for phase in self.phases)

    @property
    def tangential_impulse(self) -> tuple[float, ...]:
        """(P_t,) of the impact, in space (P_1, P_2); N s. |P_t| ≤ μ P_n."""
        return self.impulse[1:]

    @property
    def impulse(self) -> tuple[float, ...]:
        """P_n and P_t of the impact, rows in the order of W; N s."""
        every = [phase.impulse for phase in self.phases] or [(0.0,) * len(self.W)]
        return tuple(math.fsum(own) for own in zip(*every, strict=True))

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
        before = self.velocity_before
        return least_energy_notice(self.energy_change, self.W, before, self.restitution)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        start = ("case", "end", "restitution", "impact_friction", "is_unique")
        velocities = "velocity_before", "velocity"
        sums = ("normal_impulse", "tangential_impulse", "energy_change")
        return plain_fields(self, *start, *velocities, *sums, "phases")


def solve_impact(
    W: Sequence[Sequence[float]],
    mu: float,
    velocity: Sequence[float],
    restitution: RestitutionLaw | str = "energetic",
    e: float = 0.75,
    *,
    impact_friction: ImpactFrictionLike = ImpactFriction.PATH,
) -> Impact:
    """Return the complete solution of an impact of one contact with Coulomb friction.

    In the plane d(v_n, v_t)/dP_n = W (1, r), with r = P_t′/P_n′ = −μ sign(v_t) in slip and
    r = −W_nt/W_tt in sticking: a path of straight pieces with exact break points where v_t = 0 (the
    contact then sticks iff |W_nt| ≤ μ W_tt, else slips in direction sign(W_nt)), where v_n = 0
    (compression ends), and where the law ends restitution. At most three pieces; nothing is
    iterated. In space r is a vector of two numbers, −μ v_t/|v_t| in slip: the slip turns, and the
    path is followed by power series to rounding, through the stop of the slip. It then sticks iff
    |W_tt⁻¹ w| ≤ μ, with w = (W_n1, W_n2), else slips in the one direction in which slip can grow.
    Signs: v_n < 0 on approach, P_n ≥ 0 pushes the bodies apart, P_t counts along v_t.

    Parameters
    ----------
    W : array_like, shape (2, 2) or (3, 3)
        Rows and columns in the order (n, t), like the velocity: [[W_nn, W_nt], [W_nt, W_tt]];
        symmetric, positive definite or of rank one; 1/kg. In space in the order (n, t1, t2), with
        t1 and t2 of unit length and at right angles; symmetric and positive definite, of rank two
        where v_n and v_t are tied, or of rank two or one where it moves nothing along one tangent:
        an impact in the plane of the others, unless a driven surface slips across it.
    mu : float
        Friction coefficient, ≥ 0.
    velocity : sequence of 2 or 3 float
        (v_n, v_t) or (v_n, v_1, v_2) before the impact, v_n ≤ 0; exactly 0 means at rest; m/s. Slip
        along a tangent in which W moves nothing is that of a driven surface, and stays.
    restitution : RestitutionLaw, or its name, one of {"energetic", "poisson", "newton"}
        These agree where the impact follows one ray, where W_nt = 0, and for e = 0. Newton's gives
        nothing back without collision, and can add energy (see `Impact.notice`); the others never
        do in the impact of this single contact.
    e : float
        Coefficient of restitution of that law, in [0, 1].
    impact_friction : ImpactFriction or its text
        Which slip friction opposes: that of each moment, along the ``path`` above (Routh), or the
        ``final_slip`` (Moreau), v_n⁺ = −e v_n⁻ with friction against v_t⁺, which takes Newton's
        law. They agree where the path has one ray. An impact by the final slip has one phase.

    Returns
    -------
    Impact
        ``NO_IMPACT`` where v_n = 0 and A > 0, or nothing slips; end ``JAM`` where the impulse would
        never end. A within rounding of 0 counts as 0, where the slip stops at v_n = 0, or in space
        turns to A < 0.

    Raises
    ------
    InputError
        All faults at once: entries that are not finite, v_n > 0, mu < 0, e outside [0, 1], W not
        symmetric positive semidefinite, an unknown law; or results beyond the floating range.
    CompilerMissing
        In space where there is no C compiler, unless the contact moves in one plane.

    References
    ----------
    Routh (1905); Keller (1986); Stronge (1990); Wang & Mason (1992); Nordmark, Dankowicz &
    Champneys (2009). In space Bhatt & Koechling (1995); Batlle (1996); Jia & Wang (2017). By the
    final slip Moreau (1988).

    Examples
    --------
    >>> from painleve_sym import solve_impact
    >>> impact = solve_impact([[2.0, 0.0], [0.0, 1.0]], 0.3, (-1.0, 0.5), "newton", 0.5)
    >>> impact.case
    <ImpactClass.SLIDING: 'sliding'>

    In space:

    >>> W = [[2.0, 0.3, 0.4], [0.3, 1.0, 0.2], [0.4, 0.2, 3.0]]
    >>> impact = solve_impact(W, 0.5, (-1.0, 0.1, -0.2), "energetic", 0.5)
    >>> [phase.name for phase in impact.phases]
    ['slip compression', 'slip restitution', 'sticking restitution']
    """
    friction = _PATH
    if impact_friction is not _PATH:  # members of an enumeration take longer to look up
        friction = chosen(ImpactFriction, impact_friction, "impact friction", "solve impact")
    given, (mu,), before, law, (e,) = impact_inputs(W, mu, velocity, restitution, e)
    is_unique = True
    try:
        if friction is not _PATH:
            check_final_slip(friction, law, "solve impact")
            case, ended, phases, is_unique = final_slip_course(given, mu, before, e)
        else:
            case, ended, phases = _course(given, mu, before, law.measure, law.share(e))
    except OverflowError as error:
        raise InputError(
            "solve impact: impulses or energies leave the range of floating point. "
            "Fix: give smaller velocities, or W in other units."
        ) from error
    after = phases[-1].velocity if phases else before
    end = ImpactEnd.PERSISTENT
    if case is not ImpactClass.NO_IMPACT:
        end = ImpactEnd.SEPARATION if after[0] > 0.0 else ImpactEnd.PERSISTENT
        end = end if ended else ImpactEnd.JAM
    return Impact(case, end, law.name, before, after, phases, given, friction, is_unique)


def _course(
    W: tuple[tuple[float, ...], ...],
    mu: float,
    velocity: tuple[float, ...],
    measure: Measure,
    share: float,
) -> tuple[ImpactClass, bool, tuple[ImpactPhase, ...]]:
    """Return the class of an impact, whether it has an end, and its phases."""
    if len(W) == 3:
        axes = axes_of_motion(W, velocity)
        if axes is None:
            return course_in_space(W, mu, velocity, measure, share)
        tangent, across = axes
        plane, v_t = in_plane(W, tangent), tangent[0] * velocity[1] + tangent[1] * velocity[2]
        if across:
            (nn, nt), (_, tt) = plane
            rows = (nn, nt, 0.0), (nt, tt, 0.0), (0.0, 0.0, 0.0)
            course = course_in_space(rows, mu, (velocity[0], v_t, across), measure, share)
        else:
            course = _course(plane, mu, (velocity[0], v_t), measure, share)
        case, ended, phases = course
        return case, ended, tuple(phase_along(phase, tangent) for phase in phases)
    (W_nn, W_nt), (_, W_tt) = W
    path = ImpactPath((W_nn, W_nt, W_tt), mu, velocity[0], velocity[1], measure)
    begins = path.begins
    ended = begins and path.follow(share)
    return path.case if begins else ImpactClass.NO_IMPACT, ended, tuple(path.phases)


def invariant_directions(W: Sequence[Sequence[float]], mu: float) -> tuple[InvariantDirection, ...]:
    """Return all directions in which slip does not turn in an impact of one contact in space.

    Parameters
    ----------
    W : array_like, shape (3, 3)
        Mobility as for `solve_impact`; 1/kg.
    mu : float
        Friction coefficient, ≥ 0.

    Returns
    -------
    tuple of InvariantDirection
        Two, or four where w = (W_n1, W_n2) lies within an astroid about 0, that of the largest
        growth first; it attracts. Empty where slip turns in no direction, for w = 0 and equal
        mobilities in all of them.

    Raises
    ------
    InputError
        As by `solve_impact`.

    References
    ----------
    Bhatt & Koechling (1995); Batlle (1996).

    Examples
    --------
    >>> from painleve_sym.problem import invariant_directions
    >>> W = [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 3.0]]
    >>> [round(d.growth, 6) for d in invariant_directions(W, 0.5)]
    [-0.5, -1.5, -1.5, -0.5]
    """
    where = "invariant directions"
    if np.shape(W) != (3, 3):
        raise InputError(
            f"{where}: got W of shape {np.shape(W)}, need a matrix of 3 rows and columns: in the "
            "plane slip does not turn. Fix: give the mobility of a contact in space."
        )
    still = (0.0,) * 3
    given = impact_inputs(W, mu, still, "newton", 0.0, where=where, in_one_plane=False)
    (_, n1, n2), (_, W11, W12), (_, _, W22) = given.W
    return invariant_ones((n1, n2), (W11, W12, W22), *given.mu)
