"""Sliding with a constant gap: the rate at which the force F_n* = −B/A drifts."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.bodies import rate
from painleve_sym.mechanics.coefficients import F_N, F_T, ContactCoefficients


def coefficient_rates(coefficients: ContactCoefficients, slip: int = -1) -> tuple[sp.Expr, sp.Expr]:
    """Return dA_s/dt and dB/dt in slip, of the state and of `F_N`; 1/(kg s), m/s³."""
    system = coefficients.contact.system
    friction = -slip * coefficients.mu * F_N
    accelerations = coefficients.accelerations.xreplace({F_T: friction})
    rates = system.rates | dict(zip(system.q_dot, accelerations, strict=True))
    return rate(coefficients.A(slip), rates), rate(coefficients.B, rates)


def sliding_field(coefficients: ContactCoefficients, slip: int = -1) -> dict[sp.Symbol, sp.Expr]:
    """Return the rates of coordinates and velocities while the contact slides with F_n*."""
    system = coefficients.contact.system
    normal, tangential = coefficients.force_directions
    force = coefficients.slip_force(slip)
    along = (normal - slip * coefficients.mu * tangential) * force
    rates = dict(zip(system.q, system.q_dot, strict=True))
    return rates | dict(zip(system.q_dot, system.free_acceleration + along, strict=True))


def sliding_force_rate(coefficients: ContactCoefficients, slip: int = -1) -> sp.Expr:
    """Return dF_n*/dt along the sliding solution, −(Ḃ + F_n* Ȧ)/A; N/s.

    It is what a contact of finite stiffness has to follow: −B/A moves while the contact slides.
    """
    force = coefficients.slip_force(slip)
    A_dot, B_dot = coefficient_rates(coefficients, slip)
    drift = (B_dot + F_N * A_dot).xreplace({F_N: force})
    return -drift / coefficients.A(slip)
