"""Bounces of frozen coefficients: the ratio of successive ones in closed form, its thresholds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.laws.impact import ImpactCase, RestitutionLaw, energetic
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.impulses import V_N, V_T, Condition, Writer
from painleve_sym.mechanics.readable import readable
from painleve_sym.mechanics.routh import ImpactClass, impact_course
from painleve_sym.mechanics.system import Coordinate, LagrangianSystem, Parameter

CYCLES = (ImpactClass.SLIDING, ImpactClass.C_STICKING, ImpactClass.R_STICKING)
"""Classes whose bounces repeat themselves up to their size, in closed form."""


@dataclass(frozen=True)
class ChatterRatio:
    """The ratio of successive bounces of one impact class, W, b_t and b_n frozen.

    Small bounces near a state of contact take so little time that W, b_t and b_n < 0 do not
    change. A flight that starts with v_n > 0 lasts T = 2 v_n/|b_n|, returns with −v_n and adds
    b_t T to v_t. Impacts are homogeneous of degree one in (v_t, v_n), so that a sequence of
    bounces that all have one ratio v_t/v_n at the impacts grows or dies out by one ratio ρ.
    After a sticking impact v_t = 0: the next one has v_t/|v_n| = τ = 2 b_t/|b_n| whatever happened
    before. Slip that outlasts its impact has ρ = e.

    ρ < 1 is chatter, which ends in contact; ρ > 1 is reverse chatter, which leaves contact by
    infinitely many bounces after t = 0.

    Attributes
    ----------
    coefficients : ContactCoefficients
    law : RestitutionLaw
    case : ImpactClass
    slip : {-1, +1}
        s = sign(v_t) at the impacts; sign(b_t) in sticking classes.
    write : callable

    References
    ----------
    Nordmark, Dankowicz & Champneys, Friction-induced reverse chatter in rigid-body mechanisms with
    impacts, IMA J. Appl. Math. 76 (2011) 85–119; Champneys & Várkonyi (2016).
    """

    coefficients: ContactCoefficients
    law: RestitutionLaw
    case: ImpactClass
    slip: int
    write: Writer

    @cached_property
    def slip_per_fall(self) -> sp.Expr:
        """τ = 2 b_t/|b_n|: v_t/|v_n| at the impact after a flight that starts with v_t = 0; 1."""
        return self.write(-2 * self.coefficients.b_t / self.coefficients.b_n)

    @cached_property
    def _impact(self) -> ImpactCase:
        return ImpactCase(
            self.law, impact_course(self.coefficients, self.case, self.slip, self.write)
        )

    def _in_cycle(self, expr: sp.Expr) -> sp.Expr:
        arriving = {V_T: self.slip_per_fall, V_N: sp.Integer(-1)}
        return sp.sympify(expr).subs(arriving, simultaneous=True)

    @cached_property
    def ratio(self) -> sp.Expr:
        """ρ; 1."""
        rho = self._in_cycle(self._impact.separation_velocity)
        if not rho.is_rational_function():
            return sp.sqrt(self.write(sp.cancel(sp.together(sp.expand(rho**2)))))
        return self.write(rho)

    @cached_property
    def conditions(self) -> tuple[Condition, ...]:
        """What must hold for the bounces to have this class.

        Of a slip that outlasts the impact only the class is told, not its slip velocity: that grows
        from bounce to bounce.
        """
        return tuple(
            Condition(c.name, self.write(self._in_cycle(c.margin)), c.meaning, c.strict)
            for c in self._impact.conditions
        )

    @cached_property
    def restitution_threshold(self) -> sp.Expr:
        """The coefficient of restitution with ρ = 1, above which chatter is reverse; 1.

        Reverse chatter needs a value below 1; slip throughout has ρ = e and the threshold 1.
        """
        e = self.law.parameter.symbol
        if self.ratio.is_polynomial(e):
            return self.write((1 - self.ratio.subs(e, 0)) / sp.diff(self.ratio, e))
        # With the energetic law ρ² is affine in e².
        square, x = sp.expand(self.ratio**2), sp.Dummy("x", positive=True)
        square = square.subs(e, sp.sqrt(x))
        rest, slope = square.subs(x, 0), sp.diff(square, x)
        return sp.sqrt(self.write(sp.cancel(sp.together((1 - rest) / slope))))

    @cached_property
    def friction_threshold(self) -> sp.Expr | None:
        """μ with ρ = 1; None where ρ does not depend on μ, or not as a quotient of linear terms."""
        mu = self.coefficients.mu
        top = sp.numer(sp.cancel(sp.together(sp.expand(self.ratio**2 - 1))))
        if self.law.name == "poisson":
            top = sp.numer(sp.cancel(sp.together(self.ratio - 1)))
        if sp.degree(top, mu) != 1:
            return None
        return self.write(-top.subs(mu, 0) / sp.diff(top, mu))


def chatter_ratio(
    coefficients: ContactCoefficients,
    case: ImpactClass = ImpactClass.C_STICKING,
    restitution: RestitutionLaw | None = None,
    slip: int = -1,
    write: Writer = readable,
) -> ChatterRatio:
    """Return the ratio of successive bounces of a contact in closed form.

    Parameters
    ----------
    coefficients : ContactCoefficients
        Of a mechanism, or of `general_contact`.
    case : ImpactClass
        ``SLIDING``, ``C_STICKING`` or ``R_STICKING``. Bounces whose slip reverses never grow:
        ρ ≤ e, since then s W_nt < 0.
    restitution : RestitutionLaw, optional
        The energetic one when left out. Newton's has ρ = e in every class.
    slip : {-1, +1}
        s = sign(v_t) at the impacts.
    write : callable
        See `Writer`.

    Raises
    ------
    InputError
        Another class.
    """
    if case not in CYCLES:
        raise InputError(
            f"ratio of bounces: got class {case.value}, need one of "
            f"{', '.join(c.value for c in CYCLES)}. Fix: none; bounces of other classes die out."
        )
    return ChatterRatio(coefficients, restitution or energetic(), case, slip, write)


def general_contact() -> ContactCoefficients:
    """Return one contact in its own coordinates, for closed forms that hold for every mechanism.

    Its parameters are W_tt > 0, κ = W_nt/W_tt and A′ = W_nn − W_nt²/W_tt > 0, by which any positive
    definite W can be written, the fall a = −b_n > 0, τ = 2 b_t/a, and μ.
    """
    t = Coordinate("t", "tangential displacement of the contact point", "m")
    n = Coordinate("n", "gap", "m")
    W_tt = Parameter("W_tt", 1.0, "1/kg", "tangential mobility", 0.0, lower_closed=False)
    A_stick = Parameter("A_stick", 1.0, "1/kg", "mobility A' in sticking", 0.0, lower_closed=False)
    kappa = Parameter("kappa", 0.0, "1", "W_nt/W_tt")
    tau = Parameter("tau", 0.0, "1", "2 b_t/|b_n|")
    fall = Parameter("a", 1.0, "m/s^2", "fall -b_n", 0.0, lower_closed=False)
    mu = Parameter("mu", 1.0, "1", "friction coefficient", 0.0)
    kinetic = t.rate**2 / (2 * W_tt.symbol)
    kinetic += (n.rate - kappa.symbol * t.rate) ** 2 / (2 * A_stick.symbol)
    mass = sp.hessian(kinetic, (t.rate, n.rate))
    forces = mass * sp.Matrix([tau.symbol * fall.symbol / 2, -fall.symbol])
    system = LagrangianSystem(
        name="general contact",
        coordinates=(t, n),
        parameters=(W_tt, A_stick, kappa, tau, fall, mu),
        kinetic_energy=kinetic,
        potential_energy=sp.Integer(0),
        generalized_forces={"t": forces[0], "n": forces[1]},
    )
    return ContactCoefficients(Contact("contact", system, n.symbol, t.rate, mu.symbol))
