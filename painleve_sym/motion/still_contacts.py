"""Contacts that no motion slides at the given parameters, such as a slip c q̇ with c = 0."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from painleve_sym.at.delassus import Delassus

if TYPE_CHECKING:
    from painleve_sym.mechanics.contact import Contact
    from painleve_sym.mechanics.mechanism import Mechanism


def with_still_contacts(
    mechanism: Mechanism, numbers: Delassus, values: Mapping[str, float], zeros: Iterable[str]
) -> Mechanism | None:
    """Return the mechanism in which slip velocities that zeros of parameters make 0 are 0.

    Its formulas have no quotient by W_tt then. None where no contact is of this kind.

    Parameters
    ----------
    mechanism : Mechanism
    numbers : Delassus
        Of the mechanism.
    values : mapping of str to float
        A start with its parameters.
    zeros : iterable of str
        Names that are 0 in every motion.
    """
    frictions = {c.friction for c in mechanism.outline.contacts}
    own = {p.name for p in mechanism.outline.parameters} - frictions
    if not (names := own.intersection(zeros)):
        return None
    W = numbers.at(values).W
    if all(W[i, i] != 0 for i in range(1, len(W), 2)):
        return None
    contacts = tuple(_still(contact, names) for contact in mechanism.contacts)
    return None if contacts == mechanism.contacts else replace(mechanism, contacts=contacts)


def _still(contact: Contact, zeros: set[str]) -> Contact:
    """Return a contact with its slip at zeros of parameters, where no motion slides it there."""
    import sympy as sp

    symbols = [p.symbol for p in contact.system.parameters if p.name in zeros]
    slip = sp.sympify(contact.slip_velocity).subs(dict.fromkeys(symbols, 0))
    moves = slip.free_symbols & set(contact.system.q_dot)
    return contact if moves else replace(contact, slip_velocity=slip)
