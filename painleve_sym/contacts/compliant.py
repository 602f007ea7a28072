"""The automaton of a mechanism with one compliant frictional contact."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.contacts.contact_states import CONTACT_WORK, ContactStates, domain_transitions
from painleve_sym.contacts.model import CONTACTS, FLIGHT, check_compliant
from painleve_sym.contacts.preparation import preparation
from painleve_sym.errors import EventKind
from painleve_sym.hybrid.automaton import Choice, HybridAutomaton, Mode, Transition, positive
from painleve_sym.laws.compliance import DELTA, DELTA_DOT, SEPARATED, Branch, Exit
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.mechanics.declarations import Parameter

INDENTED = "flight_indented"


@dataclass(frozen=True)
class CompliantContact(ContactStates):
    """Builds the automaton: flight, slip ±, stick, each with the branches of the law.

    Parameters
    ----------
    mechanism : Mechanism
        With exactly one contact.
    law : ContactLaw
    """

    law: ContactLaw

    def __post_init__(self) -> None:
        check_compliant(self.mechanism, self.law)
        taken = [p.name for p in self.mechanism.outline.parameters]
        self.__dict__["law"] = self.law.apart_from(taken)

    @property
    def own_laws(self) -> tuple[ContactLaw]:
        """The law of the contact."""
        return (self.law,)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the law."""
        return self.law.parameters

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """Memory of the law."""
        return self.law.memory

    @cached_property
    def friction_coefficient(self) -> sp.Expr:
        """Coefficient of friction in slip: μ r(v_t)."""
        return self.mechanism.coefficients.mu * self.law.friction.kinetic_ratio(self.slip)

    @cached_property
    def static_coefficient(self) -> sp.Expr:
        """Coefficient of friction that stick must exceed before slip starts: μ r_s."""
        return self.mechanism.coefficients.mu * self.law.friction.static_ratio

    def _of_state(self, expr: sp.Expr) -> sp.Expr:
        """Write a law's expression in the states of the automaton."""
        return sp.sympify(expr).xreplace({DELTA: -self.gap, DELTA_DOT: -self.gap_rate})

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

    def _landing(
        self, branch: Branch, touchdown: bool
    ) -> tuple[tuple[Choice, ...], dict[sp.Symbol, sp.Expr]]:
        """Return choices and reset of a contact whose force sets in; δ = 0 at a touchdown."""
        return self._contact_choices(branch.name), {}

    def _exit(self, number: int, contact: str, branch: Branch, e: Exit) -> Transition:
        if e.target == SEPARATED:
            target = INDENTED if self.law.recontacts else FLIGHT
            reset: dict[sp.Symbol, sp.Expr] = {}
            after = sp.Integer(0)
        else:
            target = f"{contact}/{e.target}"
            reset = {s: self._of_state(v) for s, v in e.memory.items()}
            after = self.law.branch(e.target).stored_energy.xreplace(dict(e.memory))
        # What the stored energy jumps by goes to the law: nothing where the force is continuous,
        # a loss where a stretched dashpot lets go, a gain under the virgin reload rule.
        released = self._of_state(branch.stored_energy - after)
        if released != 0:
            reset[CONTACT_WORK] = CONTACT_WORK + released
        label = f"{e.kind}_{number}"
        return self.transition(label, e.kind, self._of_state(e.guard), (Choice(target),), reset)

    def _contact_mode(self, contact: str, branch: Branch) -> Mode:
        force = self._of_state(branch.force)
        if contact == "stick":
            changes = self._slip_starts(branch, force)
        else:
            changes = [self._slip_stop(CONTACTS[contact], branch, force)]
        exits = [self._exit(i, contact, branch, e) for i, e in enumerate(branch.exits)]
        return Mode(
            f"{contact}/{branch.name}",
            self._law_field(contact, branch),
            # Friction first: at a start at rest it decides which normal motion follows.
            (*changes, *exits, *domain_transitions(self.mechanism)),
            self.outputs(contact, force, self._of_state(branch.stored_energy)),
        )

    def _slip_starts(self, branch: Branch, force: sp.Expr) -> list[Transition]:
        """Return the ends of stick: |F_t| has reached what friction can bear."""
        limit, needed = self.static_coefficient * force, self.tangential_force("stick", force)
        changes = []
        for direction, margin in (("neg", limit - needed), ("pos", limit + needed)):
            enter = Choice(f"slip_{direction}/{branch.name}", departs=("slip_stop",))
            changes.append(
                self.transition(f"slip_{direction}", EventKind.SLIP_START, margin, (enter,))
            )
        return changes

    def _slip_stop(self, s: int, branch: Branch, force: sp.Expr) -> Transition:
        """Return the end of slip along s: v_t = 0."""
        needed = self.tangential_force("stick", force)
        other = "slip_pos" if s < 0 else "slip_neg"
        turns = positive(s * needed - self.static_coefficient * force)
        reverse = Choice(f"{other}/{branch.name}", turns, ("slip_stop",))
        stop = (reverse, Choice(f"stick/{branch.name}"))
        reset = {self.slip: sp.Integer(0)}
        return self.transition("slip_stop", EventKind.SLIP_STOP, s * self.slip, stop, reset)

    def _flight_modes(self) -> list[Mode]:
        lands = self._landing(self.law.loading, touchdown=True)
        land = self.transition("touchdown", EventKind.TOUCHDOWN, self.gap, *lands)
        zero = sp.Integer(0)
        free, outputs = self.field(None, zero), self.outputs(None, zero, zero)
        modes = [Mode(FLIGHT, free, (land, *domain_transitions(self.mechanism)), outputs)]
        if self.law.recontacts:
            clean = {s: sp.Integer(0) for s in self.law.memory}
            leave = self.transition(
                "liftoff", EventKind.LIFTOFF, -self.gap, (Choice(FLIGHT),), clean
            )
            back = [self._recontact(i, e) for i, e in enumerate(self.law.recontacts)]
            modes.append(
                Mode(INDENTED, free, (leave, *back, *domain_transitions(self.mechanism)), outputs)
            )
        return modes

    def _recontact(self, number: int, e: Exit) -> Transition:
        choices, landed = self._landing(self.law.branch(e.target), touchdown=False)
        reset = self._recontact_reset(e) | landed
        label = f"recontact_{number}"
        return self.transition(label, e.kind, self._of_state(e.guard), choices, reset)

    def _recontact_reset(self, e: Exit) -> dict[sp.Symbol, sp.Expr]:
        reset = {s: self._of_state(v) for s, v in e.memory.items()}
        gained = self._of_state(self.law.branch(e.target).stored_energy.xreplace(dict(e.memory)))
        reset[CONTACT_WORK] = CONTACT_WORK - gained
        return reset

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton, validated."""
        mechanism, law = self.mechanism, self.law
        contact_modes = [self._contact_mode(c, b) for c in CONTACTS for b in law.branches]
        return HybridAutomaton(
            name=f"{mechanism.name} with {law.name}",
            states=self.states,
            memory=self.memory,
            parameters=tuple(p.symbol for p in (*mechanism.system.parameters, *law.parameters)),
            definitions=dict(law.definitions),
            modes=(*self._flight_modes(), *contact_modes),
            starts=self._start_choices(),
            uncontrolled=self.dissipations,
            preparation=preparation(self),
        )

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
