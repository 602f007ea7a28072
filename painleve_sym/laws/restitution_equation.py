"""Equations that end restitution, by law, and the velocity of separation that solves them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import sympy as sp

from painleve_sym.mechanics.impact.impulse_rays import V_N_PLUS

V_N_MINUS = sp.Symbol("v_n_minus", nonpositive=True)
"""Normal velocity before the impact; m/s."""
P_C = sp.Symbol("P_c", nonnegative=True)
"""Normal impulse of compression; N s."""
P_R = sp.Symbol("P_r", nonnegative=True)
"""Normal impulse of restitution; N s."""
E_C = sp.Symbol("E_c", nonnegative=True)
"""Energy stored by compression; J."""
E_R = sp.Symbol("E_r", nonpositive=True)
"""Energy stored by restitution, negative: it is released; J."""
A_R = sp.Symbol("A_r", positive=True)
"""dv_n/dP_n during restitution (A′ in sticking), or on its last ray; 1/kg."""
V_N_1 = sp.Symbol("v_n_1", nonnegative=True)
"""Normal velocity at the start of the last ray of restitution; m/s."""
P_R1 = sp.Symbol("P_r1", nonnegative=True)
"""Normal impulse of restitution before its last ray; N s."""
E_R1 = sp.Symbol("E_r1", nonpositive=True)
"""Energy stored by restitution before its last ray, negative; J."""


def equation_of(measure: str, share: sp.Expr) -> sp.Eq:
    """Return the equation that ends restitution when a share of the `Measure` has come back."""
    sides = {
        "velocity": (V_N_PLUS, -share * V_N_MINUS),
        "impulse": (P_R, share * P_C),
        "work": (E_R, -share * E_C),
    }
    return sp.Eq(*sides[measure], evaluate=False)


@cache
def separation_velocity(equation: sp.Eq) -> sp.Expr:
    """Return v_n⁺ that solves the equation of a law; see `RestitutionLaw.separation_velocity`."""
    return _solved(equation, {P_R: V_N_PLUS / A_R, E_R: -(V_N_PLUS**2) / (2 * A_R)})


@cache
def final_velocity(equation: sp.Eq) -> sp.Expr:
    """Return v_n⁺ that solves the equation of a law; see `RestitutionLaw.final_velocity`."""
    impulse = P_R1 + (V_N_PLUS - V_N_1) / A_R
    stored = E_R1 - (V_N_PLUS**2 - V_N_1**2) / (2 * A_R)
    return _solved(equation, {P_R: impulse, E_R: stored})


def _solved(equation: sp.Eq, ray: Mapping[sp.Symbol, sp.Expr]) -> sp.Expr:
    difference = equation.lhs - equation.rhs
    # Solved for a symbol of no sign, since SymPy drops roots whose sign it cannot decide.
    unknown = sp.Symbol("v", real=True)
    roots = sp.solve(difference.subs(dict(ray)).subs(V_N_PLUS, unknown), unknown)
    return max(roots, key=lambda root: not root.could_extract_minus_sign())
