"""The automaton of a mechanism with one compliant frictional contact."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import sympy as sp

from painleve_sym.contacts.contact_states import CONTACT_WORK, OneContact, cone_margins
from painleve_sym.contacts.interfaces import FLIGHTS, BranchChange, CompliantInterface
from painleve_sym.contacts.model import CONTACTS, FLIGHT, MOTION, SLIPS
from painleve_sym.hybrid.automaton import Choice, HybridAutomaton, Mode, Transition, positive
from painleve_sym.laws.compliance import Branch
from painleve_sym.laws.contact_law import ContactLaw


@dataclass(frozen=True)
class CompliantContact(OneContact):
    """Builds the automaton: flight, slip ±, stick, each with the branches of the law.

    Parameters
    ----------
    model : ContactModel
        With exactly one contact, and a compliant law.
    """

    @property
    def law(self) -> ContactLaw:
        """The law of the contact."""
        (law,) = self.model.own_laws
        assert law.is_compliant
        return law

    @cached_property
    def interface(self) -> CompliantInterface:
        """The contact with its law: coefficients of friction, changes of branch and flight."""
        return CompliantInterface(self.rows[0], MOTION, self.law)

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """Memory of the law."""
        return self.law.memory

    @property
    def friction_coefficient(self) -> sp.Expr:
        """Coefficient of friction in slip: μ r(v_t)."""
        return self.interface.kinetic_coefficient

    def _of_state(self, expr: sp.Expr) -> sp.Expr:
        return self.interface.of_state(expr)

    def _law_field(self, contact: str, branch: Branch) -> dict[sp.Symbol, sp.Expr]:
        rates = self.field(contact, self._of_state(branch.force))
        return rates | {CONTACT_WORK: self._of_state(branch.dissipated_power)}

    def _contact_choices(self, branch: str) -> tuple[Choice, ...]:
        """Return the choices of a loaded contact in a branch."""
        return (
            Choice(f"slip_neg/{branch}", positive(-self.slip)),
            Choice(f"slip_pos/{branch}", positive(self.slip)),
            Choice(f"stick/{branch}"),
        )

    def _landing(self, change: BranchChange) -> tuple[tuple[Choice, ...], dict[sp.Symbol, sp.Expr]]:
        """Return choices and reset of a contact whose force sets in."""
        return self._contact_choices(change.target), {}

    def _change(self, contact: str, change: BranchChange) -> Transition:
        """Return a change of branch or flight as one of the mode."""
        reset = change.reset
        if change.closes:
            choices, landed = self._landing(change)
            reset = reset | landed
        else:
            flies = change.target in FLIGHTS
            choices = (Choice(change.target if flies else f"{contact}/{change.target}"),)
        return self.transition(change.label, change.kind, change.guard, choices, reset)

    def _changes(self, source: str, contact: str = "") -> list[Transition]:
        return [self._change(contact, c) for c in self.interface.changes if c.source == source]

    def _contact_mode(self, contact: str, branch: Branch) -> Mode:
        force = self._of_state(branch.force)
        if contact == "stick":
            changes = self._slip_starts(branch, force)
        else:
            changes = [self._slip_stop(CONTACTS[contact], branch, force)]
        return Mode(
            f"{contact}/{branch.name}",
            self._law_field(contact, branch),
            # Friction first: at a start at rest it decides which normal motion follows.
            (*changes, *self._changes(branch.name, contact), *self.domain_ends),
            self.outputs(contact, force, self._of_state(branch.stored_energy)),
        )

    def _slip_starts(self, branch: Branch, force: sp.Expr) -> list[Transition]:
        """Return the ends of stick: |F_t| has reached what friction can bear."""
        limit = self.interface.static_coefficient * force
        margins = cone_margins(limit, self.tangential_force("stick", force))
        return self.slip_starts(margins, partial(self._begun, branch))

    def _begun(self, branch: Branch, slip: int) -> tuple[Choice, ...]:
        """Return the slip that follows a stick."""
        return (Choice(f"{SLIPS[slip]}/{branch.name}", departs=("slip_stop",)),)

    def _slip_stop(self, s: int, branch: Branch, force: sp.Expr) -> Transition:
        """Return the end of slip along s: v_t = 0."""
        needed = self.tangential_force("stick", force)
        turns = positive(s * needed - self.interface.static_coefficient * force)
        reverse = Choice(f"{SLIPS[-s]}/{branch.name}", turns, ("slip_stop",))
        return self.slip_stop(s, (reverse, Choice(f"stick/{branch.name}")))

    def _flight_modes(self) -> list[Mode]:
        zero = sp.Integer(0)
        free, outputs = self.field(None, zero), self.outputs(None, zero, zero)
        return [
            Mode(name, free, (*self._changes(name), *self.domain_ends), outputs)
            for name in self.interface.flights
        ]

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton, validated."""
        contact_modes = [self._contact_mode(c, b) for c in CONTACTS for b in self.law.branches]
        modes, starts = (*self._flight_modes(), *contact_modes), self._start_choices()
        return self.automaton_of(f" with {self.law.name}", modes, starts, memory=self.memory)

    def _start_choices(self) -> tuple[Choice, ...]:
        # Inside the surface: loading, whose guards then sort out unloading. On it: flight, whose
        # touchdown guard (gap, its rate, its acceleration) decides between flight and contact.
        below = positive(-self.gap)
        choices = self._contact_choices(self.law.loading.name)
        inside = [
            Choice(c.target, below if c.condition is None else sp.And(below, c.condition))
            for c in choices
        ]
        return (*inside, Choice(FLIGHT))
