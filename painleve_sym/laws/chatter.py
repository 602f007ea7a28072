"""Bounces of frozen coefficients: the ratio of successive ones in closed form, its thresholds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.laws.impact_cases import ImpactCase
from painleve_sym.laws.restitution import Measure, RestitutionLaw, energetic
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.general_contact import A_STICK, KAPPA, MU, W_TT, general_contact
from painleve_sym.mechanics.impact.classes import impact_course
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_T, Condition
from painleve_sym.mechanics.simplify import readable

CYCLES = (ImpactClass.SLIDING, ImpactClass.C_STICKING, ImpactClass.R_STICKING)
"""Classes whose bounces repeat themselves up to their size, in closed form."""

TAU = sp.Symbol("tau", real=True)
"""τ = 2 b_t/|b_n|; 1."""


@dataclass(frozen=True)
class ChatterRatio:
    """The ratio of successive bounces of one impact class, W, b_t and b_n frozen.

    Small bounces near a state of contact take so little time that W, b_t and b_n < 0 do not change.
    A flight that starts with v_n > 0 lasts T = 2 v_n/|b_n|, returns with −v_n and adds b_t T to
    v_t. Impacts are homogeneous of degree one in (v_t, v_n), so that a sequence of bounces that all
    have one ratio v_t/v_n at the impacts grows or dies out by one ratio ρ. After a sticking impact
    v_t = 0: the next one has v_t/|v_n| = τ = 2 b_t/|b_n| whatever happened before. Slip that
    outlasts its impact has ρ = e.

    ρ < 1 is chatter, which ends in contact; ρ > 1 is reverse chatter, which leaves contact by
    infinitely many bounces after t = 0.

    Every expression is in the symbols of `general_contact`, τ and the law's coefficient;
    `symbols_of` gives those of a mechanism. `slip` is s = sign(v_t) at the impacts; sign(b_t) in
    sticking classes.

    References
    ----------
    Nordmark, Dankowicz & Champneys (2011); Champneys & Várkonyi (2016).
    """

    law: RestitutionLaw
    case: ImpactClass
    slip: int

    @cached_property
    def _impact(self) -> ImpactCase:
        return ImpactCase(
            self.law, impact_course(general_contact().coefficients, self.case, self.slip)
        )

    def _in_cycle(self, expr: sp.Expr) -> sp.Expr:
        arriving = {V_T: TAU, V_N: sp.Integer(-1)}
        return sp.sympify(expr).xreplace(arriving)

    @cached_property
    def ratio(self) -> sp.Expr:
        """ρ; 1."""
        rho = self._in_cycle(self._impact.separation_velocity)
        if not rho.is_rational_function():
            return sp.sqrt(readable(sp.cancel(sp.together(sp.expand(rho**2)))))
        return readable(rho)

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """Conditions for the bounces to have this class.

        Of a slip that outlasts the impact they determine the class, not its slip velocity, which
        grows from bounce to bounce.
        """
        return tuple(
            Condition(c.name, readable(self._in_cycle(c.margin)), c.meaning, c.strict)
            for c in self._impact.conditions
        )

    @cached_property
    def restitution_threshold(self) -> sp.Expr:
        """The coefficient of restitution with ρ = 1, above which chatter is reverse; 1.

        Reverse chatter needs a value below 1; slip throughout has ρ = e and the threshold 1.
        """
        e, power = self.law.parameter.symbol, self.law.power
        if self.ratio.is_polynomial(e) and sp.degree(self.ratio, e) == 1:
            return readable((1 - self.ratio.subs(e, 0)) / sp.diff(self.ratio, e))
        # Of a law that measures work ρ² is affine in the share eᵖ, else ρ is.
        works, share = self.law.measure is Measure.WORK, sp.Dummy("share", positive=True)
        affine = sp.expand(self.ratio**2) if works else self.ratio
        affine = affine.subs(e, sp.root(share, power))
        rest, slope = affine.subs(share, 0), sp.diff(affine, share)
        return sp.root(readable(sp.cancel(sp.together((1 - rest) / slope))), power)

    @cached_property
    def friction_threshold(self) -> sp.Expr | None:
        """μ with ρ = 1; None where ρ does not depend on μ, or not as a quotient of linear terms."""
        mu = MU
        top = sp.numer(sp.cancel(sp.together(sp.expand(self.ratio**2 - 1))))
        if self.law.measure is Measure.IMPULSE:
            top = sp.numer(sp.cancel(sp.together(self.ratio - 1)))
        if sp.degree(top, mu) != 1:
            return None
        return readable(-top.subs(mu, 0) / sp.diff(top, mu))


def chatter_ratio(
    case: ImpactClass = ImpactClass.C_STICKING,
    restitution: RestitutionLaw | None = None,
    slip: int = -1,
) -> ChatterRatio:
    """Return the ratio of successive bounces of any contact in closed form.

    The case is ``SLIDING``, ``C_STICKING`` or ``R_STICKING``: bounces whose slip reverses never
    grow, ρ ≤ e, since then s W_nt < 0. The restitution is the energetic one when left out; Newton's
    has ρ = e in every class. `slip` is s = sign(v_t) at the impacts.
    """
    if case not in CYCLES:
        raise InputError(
            f"ratio of bounces: got class {case.value}, need one of "
            f"{', '.join(c.value for c in CYCLES)}; bounces of other classes die out."
        )
    return ChatterRatio(restitution or energetic(), case, slip)


def symbols_of(coefficients: ContactCoefficients) -> dict[sp.Symbol, sp.Expr]:
    """Return what the symbols of `general_contact`, and τ, stand for in a mechanism."""
    c = coefficients
    return {
        W_TT: c.W_tt,
        A_STICK: c.A_stick,
        KAPPA: readable(c.W_nt / c.W_tt),
        TAU: readable(-2 * c.b_t / c.b_n),
        MU: c.mu,
    }
