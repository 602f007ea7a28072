"""The contacts of a mechanism with their laws, and the automaton that is derived from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from painleve_sym.automata.model import ContactModel

if TYPE_CHECKING:
    from painleve_sym.automata.automaton import HybridAutomaton
    from painleve_sym.automata.contact_states import ContactStates


@dataclass(frozen=True)
class ContactDerivation(ContactModel):
    """Contacts with their laws, from which an automaton is derived when it is first asked for."""

    @cached_property
    def builder(self) -> ContactStates:
        """Object that derives the automaton."""
        # SymPy is imported by the builders alone.
        from painleve_sym.automata.plural_contacts import ALONE, PluralContacts

        alone = None if self.several else ALONE.get(self.kinds[0])
        return (alone or PluralContacts)(self)

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton, derived when first asked for."""
        automaton = self.builder.automaton
        if not self.watch:
            return automaton
        from painleve_sym.automata.watched import watched

        gaps = {
            c.name: row.gap
            for c, row in zip(self.mechanism.contacts, self.builder.rows, strict=True)
        }
        return watched(automaton, self.watch, gaps)
