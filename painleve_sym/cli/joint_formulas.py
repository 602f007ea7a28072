"""The closed forms of a mechanism with several contacts: each alone, and all together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import sympy as sp

from painleve_sym.cli.formulas import Formula, Section, contact_sections, energies
from painleve_sym.contacts.contact_states import CONTACTS
from painleve_sym.contacts.two_contacts import TwoContacts
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.simplify import readable, reduced
from painleve_sym.mechanics.system import determinant

_SLIPS = {"slip_neg": "left", "slip_pos": "right"}


def joint_sections(mechanism: Mechanism) -> tuple[Section, ...]:
    """Return the closed forms of a mechanism with two contacts, in reading order.

    Those of one contact carry its name, as if the other were open.
    """
    joint = TwoContacts(mechanism)
    system = mechanism.system
    W, b = joint.mobility.applyfunc(reduced), joint.free.applyfunc(reduced)
    names = ", ".join(c.name for c in system.coordinates)
    forces = ", ".join(f"F_n_{c.name}, F_t_{c.name}" for c in mechanism.contacts)
    motion = Section(
        "equations of motion",
        (
            Formula("M", system.mass_matrix, "SI", "mass matrix", "M"),
            Formula("h", system.bias_force, "SI", "forces without those of the contacts", "h"),
            Formula("J", joint.jacobian, "SI", "rows of gap and slip of each contact", "J"),
        ),
        note=f"M q_ddot = h + J^T F with q = ({names}), F = ({forces})",
    )
    alone = [
        _named(section, contact.name)
        for contact in mechanism.contacts
        for section in contact_sections(mechanism.only(contact.name))
    ]
    together = Section(
        "both contacts",
        (
            Formula("W", W.applyfunc(readable), "1/kg", "mobility J M^-1 J^T", "W"),
            Formula(
                "b", b.applyfunc(readable), "m/s^2", "accelerations without contact forces", "b"
            ),
        ),
        note="a = W F + b",
    )
    sliding = Section(
        "both contacts slide",
        tuple(_sliding_formulas(joint, W, b)),
        note=(
            "A of each contact alone and the determinant > 0: one solution for all loads; both "
            "slide on where their normal forces are positive"
        ),
    )
    return (energies(mechanism), motion, *alone, together, sliding)


def _named(section: Section, contact: str) -> Section:
    formulas = tuple(
        replace(f, name=f"{f.name}_{contact}", latex=rf"\left({f.latex}\right)_{{{contact}}}")
        for f in section.formulas
    )
    return replace(section, title=f"{section.title}, {contact} alone", formulas=formulas)


def _sliding_formulas(joint: TwoContacts, W: sp.Matrix, b: sp.Matrix) -> Iterator[Formula]:
    contacts = joint.mechanism.contacts
    for modes in product(_SLIPS, repeat=2):
        end = "_".join(mode.removeprefix("slip_") for mode in modes)
        words = ", ".join(
            f"{c.name} to the {_SLIPS[mode]}" for c, mode in zip(contacts, modes, strict=True)
        )
        signs = ",".join("+" if CONTACTS[mode] > 0 else "-" for mode in modes)
        A = sp.Matrix(2, 2, lambda i, k, slips=modes: _per_force(joint, W, i, k, slips[k]))
        whole = reduced(determinant(A))
        yield Formula(
            f"det_{end}",
            readable(whole),
            "1/kg^2",
            f"determinant of A, {words}",
            rf"\det A_{{{signs}}}",
        )
        for i, contact in enumerate(contacts):
            replaced = A.copy()
            replaced[:, i] = -sp.Matrix([b[0], b[2]])
            yield Formula(
                f"F_n_{contact.name}_{end}",
                readable(reduced(determinant(replaced)) / whole),
                "N",
                f"normal force of {contact.name}, {words}",
                rf"F_{{n,{contact.name}}}^{{{signs}}}",
            )


def _per_force(joint: TwoContacts, W: sp.Matrix, i: int, k: int, mode: str) -> sp.Expr:
    """Return the normal acceleration of contact i per normal force of the sliding contact k."""
    friction = joint.mechanism.contacts[k].friction
    return W[2 * i, 2 * k] - CONTACTS[mode] * friction * W[2 * i, 2 * k + 1]
