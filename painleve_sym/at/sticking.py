"""A′ and B′ of a sticking contact, g̈_N = A′ F_n + B′, as formulas of SymPy and of CasADi.

With the tangential accelerations held at 0 they are the Schur complements A′ = W_nn − wᵀ W_tt⁺ w
and B′ = b_n − wᵀ W_tt⁺ b_t, w = (W_nt1, …). The pseudoinverse holds nothing in a direction in which
no motion slides the contact: W_nn and b_n remain where W_tt = 0. For numbers, see
`problem.risk.schur_complement`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import casadi as ca
    from sympy import Expr

    from painleve_sym.mechanics.coefficients import ContactCoefficients


def sticking_expressions(c: ContactCoefficients) -> tuple[Expr, Expr]:
    """Return A′ and B′ of a planar contact, with a case for states with W_tt = 0.

    There W_nt = 0, and sticking holds nothing.
    """
    import sympy as sp

    if c.W_tt.is_number:
        return c.A_stick, c.B_stick
    slides = sp.Gt(c.W_tt, 0, evaluate=False)
    pairs = (c.A_stick, c.W_nn), (c.B_stick, c.b_n)
    A, B = (sp.Piecewise((held, slides), (free, True)) for held, free in pairs)
    return A, B


def sticking_formulas(W: ca.SX, b: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return A′ and B′ of a contact in space; W and b have the rows n, t1, t2."""
    import casadi as ca

    from painleve_sym.problem.risk import RANK_ONE

    trace = W[1, 1] + W[2, 2]
    size = ca.if_else(trace > 0, trace, 1)
    # Of order one, so that no product of two of them leaves the range of numbers.
    unit = W[1:, 1:] / size
    t11, t12, t22 = unit[0, 0], unit[0, 1], unit[1, 1]
    determinant = t11 * t22 - t12 * t12
    regular = determinant > RANK_ONE
    adjugate = ca.vertcat(ca.horzcat(t22, -t12), ca.horzcat(-t12, t11))
    # The pseudoinverse of a matrix of rank one and trace one is the matrix.
    inverse = ca.if_else(regular, adjugate / ca.if_else(regular, determinant, 1), unit)
    held = W[0, 1:] @ inverse / size
    return W[0, 0] - held @ W[1:, 0], b[0] - held @ b[1:]
