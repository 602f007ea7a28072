"""The contacts of a mechanism with their laws, and the automaton that is derived from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from painleve_sym.contacts.model import ContactModel

if TYPE_CHECKING:
    from painleve_sym.contacts.contact_states import ContactStates
    from painleve_sym.hybrid.automaton import HybridAutomaton


@dataclass(frozen=True)
class ContactDerivation(ContactModel):
    """Contacts with their laws, from which an automaton is derived when it is first asked for."""

    @cached_property
    def builder(self) -> ContactStates:
        """Object that derives the automaton."""
        # SymPy is imported by the builders alone.
        if self.several:
            from painleve_sym.contacts.automaton import PluralContacts

            return PluralContacts(self)
        if self.own_laws[0].is_compliant:
            from painleve_sym.contacts.compliant import CompliantContact
            from painleve_sym.contacts.tangential_spring import TangentialSpringContact

            yields = self.own_laws[0].friction.tangential_stiffness is not None
            return TangentialSpringContact(self) if yields else CompliantContact(self)
        if self.is_guide:
            from painleve_sym.contacts.guide import BilateralContact

            return BilateralContact(self)
        from painleve_sym.contacts.rigid import RigidContact

        return RigidContact(self)

    @property
    def automaton(self) -> HybridAutomaton:
        """The automaton, derived when first asked for."""
        return self.builder.automaton
