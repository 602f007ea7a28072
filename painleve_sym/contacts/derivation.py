"""The contacts of a mechanism with their laws, and the automaton that is derived from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from painleve_sym.contacts.model import ContactModel

if TYPE_CHECKING:
    from painleve_sym.contacts.contact_states import ContactStates
    from painleve_sym.contacts.interfaces import Interface
    from painleve_sym.hybrid.automaton import HybridAutomaton


@dataclass(frozen=True)
class ContactDerivation(ContactModel):
    """Contacts with their laws, from which an automaton is derived when it is first asked for."""

    @cached_property
    def builder(self) -> ContactStates:
        """Object that derives the automaton."""
        # SymPy is imported by the builders alone.
        from painleve_sym.contacts import automaton, compliant, guide, rigid, tangential_spring

        kind, *others = automaton.interface_kinds(self)
        builders: dict[type[Interface], type[ContactStates]] = {
            guide.GuideInterface: guide.BilateralContact,
            rigid.RigidInterface: rigid.RigidContact,
            compliant.CompliantInterface: compliant.CompliantContact,
            tangential_spring.SpringInterface: tangential_spring.TangentialSpringContact,
        }
        return automaton.PluralContacts(self) if others else builders[kind](self)

    @property
    def automaton(self) -> HybridAutomaton:
        """The automaton, derived when first asked for."""
        return self.builder.automaton
