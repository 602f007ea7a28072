"""Closed forms of a bilateral contact: both signs of F_n, the paradox, the tangential impact."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.impact.impulse_rays import V_T
from painleve_sym.mechanics.simplify import readable


@dataclass(frozen=True)
class BilateralForms:
    """The number of solutions of a bilateral contact in slip, and its tangential impact.

    The gap stays 0, F_n has either sign and friction is F_t = −μ s |F_n|. So in slip along s

        W_nn F_n − μ s W_nt |F_n| + B = 0,

    which is A_{sσ} F_n + B = 0 for F_n of the sign σ, with A_s = W_nn − μ s W_nt: a contact that
    can open has the same F_n in slip along sσ.

    References
    ----------
    Painlevé (1895); Klein (1909).
    """

    coefficients: ContactCoefficients

    @cached_property
    def excess(self) -> sp.Expr:
        """μ |W_nt| − W_nn; 1/kg. Negative: one solution in slip. Positive: none, or two."""
        c = self.coefficients
        return c.mu * sp.Abs(c.W_nt) - c.W_nn

    @cached_property
    def selector(self) -> sp.Expr:
        """W_nt B; m/s²/kg. With `excess` > 0: two solutions along its sign, none against it."""
        return readable(self.coefficients.W_nt * self.coefficients.B)

    # ---- the tangential impact ----

    @cached_property
    def determinant(self) -> sp.Expr:
        """W_nn W_tt − W_nt²; 1/kg²."""
        c = self.coefficients
        return readable(c.W_nn * c.W_tt - c.W_nt**2)

    @cached_property
    def normal_impulse(self) -> sp.Expr:
        """P_n = W_nt v_t/det W of the impulse that stops the slip with v_n = 0 kept; N s."""
        return readable(self.coefficients.W_nt * V_T / self.determinant)

    @cached_property
    def tangential_impulse(self) -> sp.Expr:
        """P_t = −W_nn v_t/det W of the same; N s. |P_t| ≤ μ |P_n| is `excess` ≥ 0."""
        return readable(-self.coefficients.W_nn * V_T / self.determinant)

    @cached_property
    def friction_loss(self) -> sp.Expr:
        """W_nn v_t²/(2 det W): kinetic energy that this impulse takes from a fixed guide; J."""
        return readable(self.coefficients.W_nn * V_T**2 / (2 * self.determinant))

    @cached_property
    def velocity_after(self) -> sp.Matrix:
        """q̇ after the tangential impact as a function of q̇ before and v_t, shape (n, 1)."""
        normal, tangential = self.coefficients.force_directions
        change = normal * self.normal_impulse + tangential * self.tangential_impulse
        before = sp.Matrix(self.coefficients.contact.system.q_dot)
        return before + change.applyfunc(readable)
