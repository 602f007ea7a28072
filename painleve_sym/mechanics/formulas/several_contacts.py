"""Closed forms of a mechanism with several contacts: each alone, and all together."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import sympy as sp

from painleve_sym.contact_rows import ContactRows
from painleve_sym.mechanics.contact_set import ContactSet
from painleve_sym.mechanics.formulas.formula import Formula, Section, alone
from painleve_sym.mechanics.formulas.one_contact import contact_sections, energies
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.simplify import readable, reduced
from painleve_sym.mechanics.system import determinant

_SLIPS = {-1: ("neg", "left", "-"), 1: ("pos", "right", "+")}


def joint_sections(mechanism: Mechanism) -> tuple[Section, ...]:
    """Return the closed forms of a mechanism with several contacts, in reading order.

    Those of one contact carry its name, as if the others were open.
    """
    system, contacts = mechanism.system, mechanism.contacts
    together = ContactSet(mechanism)
    W = together.W.applyfunc(reduced)
    free = sp.Matrix([b for c in mechanism.all_coefficients for b in (c.b_n, c.b_t)])
    b = free.applyfunc(reduced)
    names = ", ".join(c.name for c in system.coordinates)
    forces = ", ".join(f"F_n_{c.name}, F_t_{c.name}" for c in contacts)
    motion = Section(
        "equations of motion",
        (
            Formula("M", system.mass_matrix, "SI", "mass matrix", "M"),
            Formula("h", system.bias_force, "SI", "forces without those of the contacts", "h"),
            Formula("J", together.J, "SI", "rows of gap and slip of each contact", "J"),
        ),
        note=f"M q_ddot = h + J^T F with q = ({names}), F = ({forces})",
    )
    own = [
        alone(section, contact.name)
        for contact in contacts
        for section in contact_sections(mechanism.only(contact.name))
    ]
    count = "both" if len(contacts) == 2 else "all"
    coupled = Section(
        f"{count} contacts",
        (
            Formula("W", W.applyfunc(readable), "1/kg", "mobility J M^-1 J^T", "W"),
            Formula(
                "b", b.applyfunc(readable), "m/s^2", "accelerations without contact forces", "b"
            ),
        ),
        note="a = W F + b",
    )
    sections = (energies(mechanism), motion, *own, coupled)
    if any(mechanism.outline.held):
        return sections
    note = (
        "A of each contact alone and the determinant > 0: one solution for all loads; both slide "
        "on where their normal forces are positive"
        if len(contacts) == 2
        else "all slide on where their normal forces are positive"
    )
    formulas = tuple(_sliding_formulas(mechanism, W, b))
    return (*sections, Section(f"{count} contacts slide", formulas, note=note))


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
                - s[k] * contacts[k].friction * W[at.normal(i), at.tangent(k)]
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
