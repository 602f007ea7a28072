"""Closed forms of a mechanism: energies, motion, each contact alone, and all together."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import sympy as sp

from painleve_sym.contact_rows import ContactRows
from painleve_sym.mechanics.contact_set import ContactSet
from painleve_sym.mechanics.formulas.formula import Formula, Section, alone
from painleve_sym.mechanics.formulas.in_space import spatial_sections
from painleve_sym.mechanics.formulas.one_contact import contact_sections
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.simplify import readable, reduced
from painleve_sym.mechanics.system import determinant

_SLIPS = {-1: ("neg", "left", "-"), 1: ("pos", "right", "+")}


def motion_sections(mechanism: Mechanism) -> tuple[Section, ...]:
    """Return the closed forms of a mechanism without impacts, in reading order.

    Those of one contact of several carry its name, as if the others were open.
    """
    contacts, outline = mechanism.contacts, mechanism.outline
    sections = spatial_sections if outline.rows.n_tangents > 1 else contact_sections
    own = [
        alone(section, contact.name) if len(contacts) > 1 else section
        for contact in contacts
        for section in sections(mechanism.only(contact.name))
    ]
    coupled = len(contacts) > 1 and outline.rows.n_tangents == 1
    together = _together(mechanism) if coupled else ()
    return (energies(mechanism), _motion(mechanism), *own, *together)


def energies(mechanism: Mechanism) -> Section:
    """Return T and V."""
    system = mechanism.system
    return Section(
        "energies",
        (
            Formula("T", system.kinetic_energy, "J", "kinetic energy", "T"),
            Formula("V", system.potential_energy, "J", "potential energy", "V"),
        ),
    )


def _motion(mechanism: Mechanism) -> Section:
    """Return M, h and, in the plane, the Jacobian; in space that stands with its contact."""
    system, contacts, outline = mechanism.system, mechanism.contacts, mechanism.outline
    contact, several = contacts[0], len(contacts) > 1
    applied, forces, rows = "J^T F", ", F = (F_n, F_t1, F_t2)", list[Formula]()
    if outline.rows.n_tangents == 1 and several:
        named = ", ".join(f"F_n_{c.name}, F_t_{c.name}" for c in contacts)
        J, forces = ContactSet(mechanism).J, f", F = ({named})"
        rows.append(Formula("J", J, "SI", "rows of gap and slip of each contact", "J"))
    elif outline.rows.n_tangents == 1:
        applied, forces = "J_N^T F_n + J_T^T F_t", ""
        rows.append(Formula("J_N", contact.J_N, "SI", "Jacobian of the gap", "J_N"))
        rows.append(Formula("J_T", contact.J_T, "SI", "Jacobian of the slip velocity", "J_T"))
    variable, names, turning = "q", [v.row for v in system.velocities], ""
    if system.quaternions:
        variable, names = "u", [str(v) for v in system.q_dot]
        turning = f"; q_dot = N u with q = ({', '.join(map(str, system.q))})"
        rows.append(Formula("N", system.N, "SI", "rates of q by the velocities u", "N"))
    rate = "q_ddot" if variable == "q" else "u_dot"
    meaning = f"forces without those of the contact{'s' * several}"
    return Section(
        "equations of motion",
        (
            Formula("M", system.mass_matrix, "SI", "mass matrix", "M"),
            Formula("h", system.bias_force, "SI", meaning, "h"),
            *rows,
        ),
        note=f"M {rate} = h + {applied} with {variable} = ({', '.join(names)}){forces}{turning}",
    )


def _together(mechanism: Mechanism) -> Iterator[Section]:
    """Yield the sections of several contacts: mobility, and normal forces while all slide."""
    contacts = mechanism.contacts
    W = ContactSet(mechanism).W.applyfunc(reduced)
    free = sp.Matrix([b for c in mechanism.all_coefficients for b in (c.b_n, c.b_t)])
    b = free.applyfunc(reduced)
    count = "both" if len(contacts) == 2 else "all"
    yield Section(
        f"{count} contacts",
        (
            Formula("W", W.applyfunc(readable), "1/kg", "mobility J M^-1 J^T", "W"),
            Formula(
                "b", b.applyfunc(readable), "m/s^2", "accelerations without contact forces", "b"
            ),
        ),
        note="a = W F + b",
    )
    if any(mechanism.outline.bilateral):
        return
    note = (
        "A of each contact alone and the determinant > 0: one solution for all loads; both slide "
        "on where their normal forces are positive"
        if len(contacts) == 2
        else "all slide on where their normal forces are positive"
    )
    yield Section(f"{count} contacts slide", tuple(_sliding_formulas(mechanism, W, b)), note=note)


def _sliding_formulas(mechanism: Mechanism, W: sp.Matrix, b: sp.Matrix) -> Iterator[Formula]:
    """Yield, per choice of slip directions, det A and the normal forces by Cramer's rule.

    A_ik = W_n(i)n(k) − s_k μ_k W_n(i)t(k): normal acceleration of contact i per normal force of k.
    """
    contacts = mechanism.contacts
    n, at = len(contacts), ContactRows(len(contacts))
    for slips in product(_SLIPS, repeat=n):
        words = [_SLIPS[s] for s in slips]
        end, signs = "_".join(w[0] for w in words), ",".join(w[2] for w in words)
        meaning = ", ".join(f"{c.name} to the {w[1]}" for c, w in zip(contacts, words, strict=True))
        A = sp.Matrix(
            n,
            n,
            lambda i, k, s=slips: (
                W[at.normal(i), at.normal(k)]
                - s[k] * contacts[k].mu * W[at.normal(i), at.tangent(k)]
            ),
        )
        whole = reduced(determinant(A))
        yield Formula(
            f"det_{end}",
            readable(whole),
            f"1/kg^{n}",
            f"determinant of A, {meaning}",
            rf"\det A_{{{signs}}}",
        )
        if whole == 0:
            continue  # Such as three feet of one body on one line: the forces are not unique.
        for i, contact in enumerate(contacts):
            replaced = A.copy()
            replaced[:, i] = -sp.Matrix(list(b)[at.normals])
            yield Formula(
                f"F_n_{contact.name}_{end}",
                readable(reduced(determinant(replaced)) / whole),
                "N",
                f"normal force of {contact.name}, {meaning}",
                rf"F_{{n,{contact.name}}}^{{{signs}}}",
            )
