"""The automaton of a mechanism with one compliant contact that yields along its tangent, too."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial

import sympy as sp

from painleve_sym.contacts.compliant import CompliantContact
from painleve_sym.contacts.contact_states import FRICTION_WORK, row_acceleration
from painleve_sym.contacts.interfaces import FLIGHTS, BranchChange, SpringInterface
from painleve_sym.contacts.model import CONTACTS, MOTION, SLIPS
from painleve_sym.errors import EventKind
from painleve_sym.hybrid.automaton import Choice, Transition
from painleve_sym.laws.compliance import Branch

_ZERO = sp.Integer(0)


@dataclass(frozen=True)
class TangentialSpringContact(CompliantContact):
    """Builds the automaton of a contact whose law has `Friction.SPRING`; see `SpringInterface`.

    A contact that is loaded at the start and slides has been sliding: its spring is deflected by
    s μ F_n/k_t. At rest, and where it touches down, the spring is relaxed: s = ζ = 0.

    Parameters
    ----------
    model : ContactModel
        With exactly one contact, and a law whose force does not jump while the contact is loaded.
    """

    @cached_property
    def interface(self) -> SpringInterface:
        """The contact with its law and its spring."""
        return SpringInterface(self.rows[0], MOTION, self.law)

    @property
    def deflection(self) -> sp.Symbol:
        """State ζ."""
        return self.rows[0].deflection

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """Memory of the law, and s."""
        return (*self.law.memory, self.interface.last_slip)

    # ---- forces and rates ----

    def tangential_force(self, contact: str, force: sp.Expr) -> sp.Expr:
        """Return F_t of a contact mode for the normal force `force`."""
        if contact == "stick":
            limit = self.friction_coefficient * force
            return -self.interface.last_slip * limit - self.interface.stiffness * self.deflection
        return super().tangential_force(contact, force)

    def _normal(self, contact: str | None, force: sp.Expr, accelerations: sp.Matrix) -> sp.Expr:
        if contact != "stick":
            return super()._normal(contact, force, accelerations)
        c = self.mechanism.coefficients
        if self._gap_is_extra:
            return row_acceleration(c.contact.J_N, accelerations, c.contact.normal_bias)
        return c.W_nn * force + c.W_nt * self.tangential_force("stick", force) + c.b_n

    def _slip_rate(
        self, contact: str | None, force: sp.Expr, accelerations: sp.Matrix | None
    ) -> sp.Expr:
        if contact != "stick":
            return super()._slip_rate(contact, force, accelerations)
        c = self.mechanism.coefficients
        if self._slip_is_extra and accelerations is not None:
            return row_acceleration(c.contact.J_T, accelerations, c.contact.tangential_bias)
        return c.W_nt * force + c.W_tt * self.tangential_force("stick", force) + c.b_t

    def _law_field(self, contact: str, branch: Branch) -> dict[sp.Symbol, sp.Expr]:
        rates = super()._law_field(contact, branch)
        yields = self.interface.limit_rate(branch, rates[self.gap_rate])
        if contact == "stick":
            velocity = self.slip - self.interface.last_slip * yields
            return rates | {self.deflection: velocity, FRICTION_WORK: _ZERO}
        friction = self.tangential_force(contact, self._of_state(branch.force))
        velocity = self.slip - CONTACTS[contact] * yields
        return rates | {FRICTION_WORK: -friction * velocity}

    def outputs(self, contact: str | None, force: sp.Expr, stored: sp.Expr) -> dict[str, sp.Expr]:
        """Return forces, gap and energies of a mode, with ξ and the energy k_t ξ²/2."""
        friction = self.tangential_force(contact, force) if contact else _ZERO
        deflection = -friction / self.interface.stiffness
        energy = stored + self.interface.stiffness * deflection**2 / 2
        own = super().outputs(contact, force, energy)
        return own | {"tangential_deflection": deflection}

    # ---- transitions ----

    def _slip_starts(self, branch: Branch, force: sp.Expr) -> list[Transition]:
        """Return the ends of stick: the spring is deflected as far as friction can bear."""
        margins = self.interface.slip_margins(force)
        return self.slip_starts(margins, partial(self._begun, branch), {self.deflection: _ZERO})

    def _slip_stop(self, s: int, branch: Branch, force: sp.Expr) -> Transition:
        """Return the end of slip along s: the spring yields as fast as the contact moves."""
        name = SLIPS[s]
        acceleration = self._law_field(name, branch)[self.gap_rate]
        yields = s * self.interface.limit_rate(branch, acceleration)
        # |F_t| = μ F_n there, and both sides grow alike.
        stick = Choice(f"stick/{branch.name}", departs=(name,))
        reset = {self.deflection: _ZERO, self.interface.last_slip: sp.Integer(s)}
        guard = s * (self.slip - yields)
        return self.transition("slip_stop", EventKind.SLIP_STOP, guard, (stick,), reset)

    def _change(self, contact: str, change: BranchChange) -> Transition:
        transition = super()._change(contact, change)
        if change.source in FLIGHTS or change.target not in FLIGHTS:
            return transition
        return replace(transition, reset={**transition.reset, **self.interface.relaxed})

    def _landing(self, change: BranchChange) -> tuple[tuple[Choice, ...], dict[sp.Symbol, sp.Expr]]:
        """Return slip where the force of the spring would outgrow friction, else stick."""
        slides = self.interface.slides(change, self.mechanism.coefficients.b_n)
        choices = (
            *(Choice(f"{SLIPS[s]}/{change.target}", slide) for s, slide in slides.items()),
            Choice(f"stick/{change.target}", departs=tuple(SLIPS.values())),
        )
        return choices, {**self.interface.relaxed, **self.interface.landing_states(change)}
