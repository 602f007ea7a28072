"""The sliding solution on a contact law with A < 0 < B: a saddle, its rates and its separatrix."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from painleve_sym.laws.compliance import DELTA, DELTA_DOT, Branch, without_ramps
from painleve_sym.laws.contact_law import ContactLaw

A, B = sp.Symbol("A", negative=True), sp.Symbol("B", positive=True)
"""Coefficients of g̈_N = A F_n + B, held constant; 1/kg and m/s²."""
DEPTH = sp.Symbol("delta_sliding", positive=True)
"""Compression δ* of the sliding solution; m."""


@dataclass(frozen=True)
class LawSaddle:
    """The equilibrium F_n(δ*) = −B/A of δ̈ = −(A F_n(δ, δ̇) + B) for constant A < 0 < B.

    The branch is the curve the motion is on: loading, or unloading from δ_max = δ*.

    References
    ----------
    Impact model resolution on Painlevé's paradox, §3.4: the sliding solution is not stable.
    Hogan & Kristiansen (2017) and Kristiansen & Hogan (2018) for linear contacts.
    """

    law: ContactLaw
    branch: Branch

    @property
    def compression(self) -> sp.Expr:
        """δ* = (F_n*/K)^(1/n) with F_n* = −B/A, on the loading curve at rest; m."""
        return (-B / (A * self.law.stiffness)) ** (1 / self.law.exponent)

    def _at_equilibrium(self, expr: sp.Expr) -> sp.Expr:
        start = {DELTA: DEPTH, DELTA_DOT: sp.Integer(0), **dict.fromkeys(self.law.memory, DEPTH)}
        return without_ramps(expr).xreplace(start)

    @property
    def slope(self) -> sp.Expr:
        """∂F_n/∂δ at δ* as a function of `DEPTH`; N/m."""
        return self._at_equilibrium(without_ramps(self.branch.force).diff(DELTA))

    @property
    def damping(self) -> sp.Expr:
        """∂F_n/∂δ̇ at δ* as a function of `DEPTH`; N s/m."""
        return self._at_equilibrium(without_ramps(self.branch.force).diff(DELTA_DOT))

    @property
    def rates(self) -> tuple[sp.Expr, sp.Expr]:
        """Growth rate λ₊ > 0 and decay rate λ₋ < 0 of a small deviation; 1/s.

        λ² + A F_δ̇ λ + A F_δ = 0. Both are real for A < 0, F_δ > 0 and finite F_δ̇: the equilibrium
        is a saddle for every such law, and a dashpot (F_δ̇ > 0) makes it leave faster. A and B
        are held constant.
        """
        half, product = -A * self.damping / 2, -A * self.slope
        root = sp.sqrt(half**2 + product)
        # The product of both is A F_δ: this form does not cancel.
        return half + root, -product / (half + root)

    @property
    def growth_rate(self) -> sp.Expr:
        """λ₊ at δ*, a closed form in A, B and the parameters of the law; 1/s."""
        return self.rates[0].xreplace({DEPTH: self.compression})

    @property
    def conservative(self) -> bool:
        """Whether the force depends on δ alone, so that an energy is conserved."""
        return not sp.sympify(self.branch.force).has(DELTA_DOT)


def loading_saddle(law: ContactLaw) -> LawSaddle:
    """Return the saddle on the loading curve."""
    return LawSaddle(law, law.loading)


def unloading_saddle(law: ContactLaw) -> LawSaddle:
    """Return the saddle on the curve that is followed when the contact opens from δ*."""
    return LawSaddle(law, law.branch(law.unloading))


def barrier(law: ContactLaw) -> sp.Expr:
    """Return ∫(B + A F_n) dδ from 0 to δ*, B δ* n/(n + 1): the work the approach must do; m²/s².

    For constant A and B a contact that touches with −ẏ_A = √(2 barrier) just reaches the sliding
    solution: slower ones lift off, faster ones impact.
    """
    depth = sp.Symbol("delta", positive=True)
    force = without_ramps(law.loading.force).xreplace({DELTA_DOT: sp.Integer(0)})
    work = sp.integrate(force.xreplace({DELTA: depth}), (depth, 0, DEPTH))
    return B * DEPTH + A * sp.simplify(work)
