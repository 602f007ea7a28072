"""Closed forms of the jump at finite stiffness: A and B frozen at the start but not dropped.

An impact without collision of a mechanism with one planar contact, a force F = K δⁿ: slip from rest
at δ = 0 with A < 0 and B < 0, sticking compression, sticking restitution along
F = K ((δ − δ_p)/e²)ⁿ with δ_p = (1 − e²) δ_max. In slip v̇_n = A F + B and v̇_t = C F + b_t, in
sticking v̇_n = A′ F + B′.
"""

from __future__ import annotations

import sympy as sp

A = sp.Symbol("A", negative=True)
"""Normal acceleration per normal force in slip; 1/kg."""
B = sp.Symbol("B", negative=True)
"""Free normal acceleration; m/s²."""
A_STICK = sp.Symbol("A_stick", positive=True)
"""A′, the same as A in sticking; 1/kg."""
B_STICK = sp.Symbol("B_stick", real=True)
"""B′, the same as B in sticking; m/s²."""
C = sp.Symbol("C", real=True)
"""Tangential acceleration per normal force in slip; 1/kg."""
B_T = sp.Symbol("b_t", real=True)
"""Free tangential acceleration; m/s²."""
V_T = sp.Symbol("v_t", real=True)
"""Slip velocity before the impact; m/s."""
K, N = sp.symbols("K n", positive=True)
"""Stiffness (N/mⁿ) and exponent of the force."""
E_S = sp.Symbol("e_energetic", nonnegative=True)
"""Energetic coefficient of restitution."""
DELTA = sp.Symbol("delta", positive=True)
"""Compression; m."""
B_FREE = sp.Symbol("b_n", positive=True)
"""The free normal acceleration where it opens the contact, as in the indeterminate state; m/s²."""
DAMPING = sp.Symbol("c", nonnegative=True)
"""Of a linear contact, F = K δ + c δ̇; N s/m."""
TIME = sp.Symbol("t_1", positive=True)
"""Time at which the slip stops; s."""
V_1 = sp.Symbol("v_n_1", negative=True)
"""Normal velocity when the slip stops; m/s."""
DELTA_1 = sp.Symbol("delta_1", positive=True)
"""Compression when the slip stops; m."""


def energy_integral(delta: sp.Expr = DELTA) -> sp.Expr:
    """Return δ̇²/2 = |A| K δ^(n+1)/(n+1) + |B| δ in slip; m²/s²."""
    return -A * K * delta ** (N + 1) / (N + 1) - B * delta


def ratio_of_terms(delta: sp.Expr = DELTA) -> sp.Expr:
    """Return z = A K δⁿ/((n + 1) B), the first term of the energy integral over the second; 1."""
    return A * K * delta**N / ((N + 1) * B)


def slip_time(delta: sp.Expr = DELTA) -> sp.Expr:
    """Return the time to reach δ in slip, √(2δ/|B|) ₂F₁(1/2, 1/(2n); 1 + 1/(2n); −z); s."""
    b = 1 / (2 * N)
    function = sp.hyper((sp.Rational(1, 2), b), (1 + b,), -ratio_of_terms(delta))
    return sp.sqrt(2 * delta / -B) * function


def slip_impulse(delta: sp.Expr = DELTA) -> sp.Expr:
    """Return ∫F dt up to δ in slip, also a ₂F₁; N s.

    The momentum balance δ̇ = |A| P + |B| t gives the same, but cancels while z is small.
    """
    b = 1 / (2 * N)
    function = sp.hyper((sp.Rational(1, 2), 1 + b), (2 + b,), -ratio_of_terms(delta))
    return K * delta**N * sp.sqrt(2 * delta / -B) / (2 * N + 1) * function


def slip_stop_velocity(time: sp.Expr = TIME) -> sp.Expr:
    """Return v_n(t1) = −(A/C) v_t + (B − A b_t/C) t1, exact for frozen coefficients; m/s."""
    return -A / C * V_T + (B - A * B_T / C) * time


def separation_velocity(v_1: sp.Expr = V_1, delta_1: sp.Expr = DELTA_1) -> sp.Expr:
    """Return v_n(t3) from v_n and δ at the stop of the slip; m/s.

    e √((1 − A′/A) v_n(t1)² + 2 (B′ − A′ B/A) δ1), if the contact sticks until it separates.
    """
    kinetic = (1 - A_STICK / A) * v_1**2
    return E_S * sp.sqrt(kinetic + 2 * (B_STICK - A_STICK * B / A) * delta_1)


def blow_up_time() -> sp.Expr:
    """Return the limit t_∞ of `slip_time` for δ → ∞, n > 1: a number times K^(−1/(2n)); s.

    Also the leading term of t1 for K → ∞, with relative error K^(−(n−1)/(2n(n+1))).
    """
    b = 1 / (2 * N)
    factor = sp.gamma(1 + b) * sp.gamma(sp.Rational(1, 2) - b) / sp.sqrt(sp.pi)
    return sp.sqrt(2 / -B) * (A * K / ((N + 1) * B)) ** (-b) * factor


def leading_correction() -> sp.Expr:
    """Return the first term that K → ∞ adds to the classical v_n(t3), of order K^(−1/(2n)); m/s.

    For frozen coefficients and n > 1; the next term is of order K^(−1/(n+1)).
    """
    change = (B - A * B_T / C) * blow_up_time()
    return -E_S * sp.sqrt(1 - A_STICK / A) * change


def separating_rate() -> sp.Expr:
    """Return δ̇₀ on the separating surface of the indeterminate state, F = K δ + c δ̇; m/s.

    The stable direction of the equilibrium F = −b_n/A: faster approaches end in an impact without
    collision, slower ones lift off. With c = 0 and a force K δⁿ the energy integral says the same.

    References
    ----------
    Hogan & Kristiansen (2017).
    """
    root = sp.sqrt((A * DAMPING) ** 2 - 4 * A * K)
    return (-A * DAMPING - root) / 2 * (DELTA + B_FREE / (A * K))
