"""The singular point A = B = 0 of slip: eigenvalues, force exponent, the one bounded force."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.mechanics.bodies import rate
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.impact.impulse_rays import Writer
from painleve_sym.mechanics.paradox.critical_friction import in_one_variable
from painleve_sym.mechanics.simplify import readable


@dataclass(frozen=True)
class JamThreshold:
    """State in which the eigenvalues of the singular point are equal, with its friction μ_C.

    `at` is the value of `variable` (tan q, tan(q/2) or the coordinate q itself) there.
    """

    friction: sp.Expr
    variable: sp.Expr
    at: sp.Expr


@dataclass(frozen=True)
class SingularPoint:
    """Slip near A_s = B = 0, for any mechanism with one contact.

    In slip q̈ = f + w_s F with F = −B/A_s and w_s = M⁻¹(J_N − μ s J_T)ᵀ. A_s depends on q alone
    where μ is constant and nothing depends on the time, so along the motion

        Ȧ = α,  Ḃ = β₀ + β₁ F,

    with α = (∂A/∂q) q̇, β₀ = (∂B/∂q) q̇ + (∂B/∂q̇) f and β₁ = (∂B/∂q̇) w_s. With dτ = dt/A this is
    A′ = α A, B′ = β₀ A − β₁ B: linear where α, β₀, β₁ keep their values at the point. Hence

        F = F* + C (t* − t)^(−γ),  γ = 1 − r,  r = −β₁/α,  F* = −β₀/(α + β₁),

    as a slip with α A < 0 reaches A = 0 at t*. For 0 < r < 1 the force diverges and its impulse
    does not, so that B reaches 0 together with A: dynamic jam. For r > 1 every force tends to F*.
    For r = 1 the power is a logarithm; for r ≤ 0 a force above F* has an unbounded impulse, so that
    the slip stops before.
    Every expression is in the state and the parameters; A = B = 0 is not substituted. `slip` is
    s = sign(v_t); expressions are `readable` (simplified) or `raw` (unsimplified, faster).

    References
    ----------
    Génot & Brogliato (1999), whose critical friction μ_C is; Champneys & Várkonyi (2016); Nordmark,
    Várkonyi & Champneys (2018).
    """

    coefficients: ContactCoefficients
    slip: int = -1
    write: Writer = field(default=readable, compare=False)

    def __post_init__(self) -> None:
        if self.slip not in (-1, 1):
            raise InputError(
                f"singular point: slip direction: got {self.slip!r}, need -1 or +1. "
                "Fix: give sign(v_t)."
            )

    @cached_property
    def A_rate(self) -> sp.Expr:
        """α = Ȧ_s; 1/(kg s)."""
        system = self.coefficients.contact.system
        return self.write(rate(self.coefficients.A(self.slip), system.rates))

    @cached_property
    def B_rate(self) -> sp.Expr:
        """β₀: Ḃ without contact force; m/s³."""
        system = self.coefficients.contact.system
        free = (self._velocity_gradient * system.free_acceleration)[0]
        return self.write(rate(self.coefficients.B, system.rates) + free)

    @cached_property
    def B_rate_per_force(self) -> sp.Expr:
        """β₁ = ∂Ḃ/∂F_n; 1/(kg s)."""
        normal, tangential = self.coefficients.force_directions
        direction = normal - self.slip * self.coefficients.mu * tangential
        return self.write((self._velocity_gradient * direction)[0])

    @property
    def _velocity_gradient(self) -> sp.Matrix:
        B = self.coefficients.B
        return sp.Matrix([[sp.diff(B, v) for v in self.coefficients.contact.system.q_dot]])

    @property
    def eigenvalues(self) -> tuple[sp.Expr, sp.Expr]:
        """α and −β₁: those of the flow in τ with dτ = dt/A; 1/(kg s).

        Their directions (A, B) are (1, −F*) and (0, 1). A slip from A > 0 reaches the point where
        both are negative; the third eigenvalue, along the set of singular points, is 0.
        """
        return self.A_rate, -self.B_rate_per_force

    @cached_property
    def eigenvalue_ratio(self) -> sp.Expr:
        """r = −β₁/α; 1."""
        return self.write(-self.B_rate_per_force / self.A_rate)

    @property
    def force_exponent(self) -> sp.Expr:
        """γ = 1 − r of the force, F − F* ~ (t* − t)^(−γ); 1. Not positive where it stays finite."""
        return 1 - self.eigenvalue_ratio

    @cached_property
    def bounded_force(self) -> sp.Expr:
        """F* = −β₀/(α + β₁), the force of the exceptional slip along (1, −F*); N.

        A slip exists there only where it is positive. For r < 1 it is the border between slips
        that lift off (F < F* near the point) and those that jam (F > F*).
        """
        return self.write(-self.B_rate / (self.A_rate + self.B_rate_per_force))

    @cached_property
    def critical_friction(self) -> sp.Expr:
        """μ_P(q) = W_nn/(s W_nt), with which A_s = 0 at q; 1."""
        c = self.coefficients
        if c.W_nt == 0:
            raise InputError(
                f"singular point of mechanism {c.contact.system.name!r}: got W_nt = 0, need a "
                "contact whose friction moves it in the normal direction: here A > 0 always."
            )
        return self.write(c.W_nn / (self.slip * c.W_nt))

    def on_A_zero(self, expr: sp.Expr) -> sp.Expr:
        """Return an expression with μ replaced by μ_P(q): its value at points with A_s = 0."""
        mu = self.coefficients.mu
        return self.write(sp.sympify(expr).subs(mu, self.critical_friction))

    def thresholds(self, coordinate: str) -> tuple[JamThreshold, ...]:
        """Return where r = 1, as the singular point moves along one coordinate with μ.

        On one side of it the force stays bounded as A → 0, on the other an open set of slips jams.
        Thresholds have positive friction, or one whose sign depends on parameters.

        Raises
        ------
        InputError
            Unknown name, or no closed form: r at A = 0 is not rational in the coordinate's
            tangent, or the roots of r = 1 are not radicals.
        """
        system = self.coefficients.contact.system
        where = f"singular point of mechanism {system.name!r}"
        t, q = sp.Dummy("t", real=True), system.coordinate(coordinate, where)
        ratio, variable = in_one_variable(self.on_A_zero(self.eigenvalue_ratio), q, t)
        friction, same = in_one_variable(self.critical_friction, q, t)
        if ratio is None or friction is None or variable != same:
            raise InputError(
                f"{where}: the eigenvalue ratio at A = 0 is not rational in the tangent of "
                f"{coordinate!r}, need that for a closed form. Fix: solve eigenvalue_ratio = 1 "
                "with numbers."
            )
        top = sp.Poly(sp.fraction(sp.together(ratio - 1))[0], t)
        places = sp.roots(top)
        if sum(places.values()) < top.degree():
            raise InputError(
                f"{where}: the eigenvalue ratio is 1 at the roots of a polynomial of degree "
                f"{top.degree()} in {variable}, which have no closed form. Fix: solve "
                "eigenvalue_ratio = 1 with numbers."
            )
        pairs = [
            (p, sp.simplify(sp.radsimp(friction.subs(t, p))))
            for p in places
            if p.is_real is not False
        ]
        thresholds = [JamThreshold(mu, variable, p) for p, mu in pairs if not mu.is_nonpositive]
        return tuple(sorted(thresholds, key=lambda x: sp.default_sort_key(x.friction)))
