"""Closed forms of a mechanism in space: motion, mobility, slip in any direction, critical friction.

Each contact stands as if the others were open.
"""

from __future__ import annotations

from collections.abc import Iterator

import sympy as sp

from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.formulas.formula import Formula, Section, alone
from painleve_sym.mechanics.formulas.one_contact import energies
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.simplify import readable, reduced

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


def spatial_sections(mechanism: Mechanism) -> tuple[Section, ...]:
    """Return the closed forms of a mechanism in space, in reading order."""
    system = mechanism.system
    names = ", ".join(v.row for v in system.velocities)
    note = f"M q_ddot = h + J^T F with q = ({names}), F = (F_n, F_t1, F_t2)"
    turning: tuple[Formula, ...] = ()
    if system.quaternions:
        names, velocities = (
            ", ".join(str(s) for s in symbols) for symbols in (system.q, system.q_dot)
        )
        note = (
            f"M u_dot = h + J^T F with u = ({velocities}), F = (F_n, F_t1, F_t2); q_dot = N u with "
            f"q = ({names})"
        )
        turning = (Formula("N", system.N, "SI", "rates of q by the velocities u", "N"),)
    h = system.bias_force.applyfunc(lambda entry: readable(reduced(entry)))
    motion = Section(
        "equations of motion",
        (
            Formula("M", system.mass_matrix, "SI", "mass matrix", "M"),
            Formula("h", h, "SI", "forces without those of the contacts", "h"),
            *turning,
        ),
        note=note,
    )
    several = len(mechanism.contacts) > 1
    own = [
        alone(section, contact.name) if several else section
        for contact in mechanism.contacts
        for section in _contact(mechanism, contact)
    ]
    return (energies(mechanism), motion, *own)


def _contact(mechanism: Mechanism, contact: Contact) -> Iterator[Section]:
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
    W, b = mobility(mechanism, contact)
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
    mu, w, T = contact.friction, W[1:, 0], W[1:, 1:]
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


def mobility(mechanism: Mechanism, contact: Contact) -> tuple[sp.Matrix, sp.Matrix]:
    """Return W and b of a contact in space with the others open, rows n, t1, t2."""
    system, J = mechanism.system, contact.J
    W = (J * system.inverse_mass_matrix * J.T).applyfunc(readable)
    b = (J * system.free_acceleration + contact.biases).applyfunc(readable)
    return W, b
