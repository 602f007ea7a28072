"""Closed forms of one contact in space: mobility, slip in any direction, critical friction."""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.formulas.formula import Formula, Section
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.simplify import readable

SLIP_ANGLE = sp.Symbol("phi_slip", real=True)
"""Angle of the slip from t1 towards t2; rad."""
LONGEST = 300
"""Operations of a mass matrix whose inverse is still worth its length."""
LONGEST_JACOBIAN = 2000
"""Operations of the Jacobian of a contact that is still worth its length."""
_TOO_LONG_JACOBIAN = (
    "The Jacobian of this contact has {count} operations, and its closed forms are too long to be "
    "of use: `classify`, `jump` and `map` compute its numbers."
)
_TOO_LONG = (
    "The inverse of M is too long to be of use in closed form: W = J M^-1 J^T, and `classify` and "
    "`map` compute its numbers from M and J."
)


def spatial_sections(mechanism: Mechanism) -> Iterator[Section]:
    """Yield the sections of the only contact of a mechanism in space, in reading order."""
    contact = mechanism.contact
    if (count := sp.count_ops(contact.J)) > LONGEST_JACOBIAN:
        gap = Formula("gap", contact.gap, "m", "gap g_N", "g_N")
        yield Section("contact", (gap,), note=_TOO_LONG_JACOBIAN.format(count=count))
        return
    slips = sp.Matrix(contact.slip_velocities)
    place = (
        Formula("gap", contact.gap, "m", "gap g_N", "g_N"),
        Formula("slip_velocity", slips, "m/s", "slip velocities along t1 and t2", "v_t"),
        Formula("J", contact.J, "SI", "Jacobian, rows n, t1, t2", "J"),
    )
    if sp.count_ops(mechanism.system.mass_matrix) > LONGEST:
        yield Section("contact", place, note=_TOO_LONG)
        return
    coefficients = ContactCoefficients(contact)
    W, b = coefficients.W, coefficients.b
    yield Section(
        "contact",
        (
            *place,
            Formula("W", W, "1/kg", "mobility J M^-1 J^T, rows n, t1, t2", "W"),
            Formula("b", b, "m/s^2", "accelerations without contact forces", "b"),
        ),
        note="a = W F + b",
    )
    e = sp.Matrix([sp.cos(SLIP_ANGLE), sp.sin(SLIP_ANGLE)])
    mu, w, T = contact.mu, W[1:, 0], W[1:, 1:]
    across = sp.Matrix([-e[1], e[0]])
    A = readable(W[0, 0] - mu * (w.T * e)[0])
    along = w - mu * T * e
    meaning = "with F_n the slip v gains k F_n + b_t.e, and its angle turns by (h F_n + b_t.e')/v"
    yield Section(
        "slip along phi_slip",
        (
            Formula("A", A, "1/kg", "of the normal acceleration A F_n + B", "A"),
            Formula("B", b[0], "m/s^2", "normal acceleration without contact force", "B"),
            Formula("k", readable((e.T * along)[0]), "1/kg", meaning, "k"),
            Formula("h_t", readable((across.T * along)[0]), "1/kg", "h above", "h_t"),
        ),
        note="F_t = -mu F_n e, e = (cos(phi_slip), sin(phi_slip)), e' a right angle ahead of e",
    )
    if w.is_zero_matrix:
        yield Section("friction", note="w = 0: A > 0 for every friction and slip.")
        return
    critical = readable(W[0, 0] / sp.sqrt(readable(w[0] ** 2 + w[1] ** 2)))
    yield Section(
        "friction and the paradox",
        (
            Formula("mu_P", critical, "1", "critical friction: W_nn/|w|", r"\mu_P"),
            Formula("w", w, "1/kg", "direction of slip with the least A", "w"),
        ),
        note="A < 0 for slip within acos(mu_P/mu) of the direction of w",
    )
