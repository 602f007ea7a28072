"""The automaton of a mechanism with one compliant contact that yields along its tangent, too.

A spring of stiffness k_t is in series with Coulomb friction; its deflection is ξ, and F_t = −k_t ξ.
In stick ξ̇ = v_t. In slip along s the force is −s μ F_n, hence ξ = s μ F_n/k_t: friction slips at
v_t − ξ̇ = v_t − s μ Ḟ_n/k_t, and stops where that vanishes.

The state of the contact is ζ = ξ − s μ F_n/k_t, the deflection from that of slip along s, where s
is the last direction of slip, 0 before the first slip of a contact. Slip ends with ζ = ζ̇ = 0, and
with ζ itself as a state round-off does not start it again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial

import sympy as sp

from painleve_sym.contacts.compliant import CompliantContact
from painleve_sym.contacts.contact_states import (
    FRICTION_WORK,
    row_acceleration,
)
from painleve_sym.contacts.interfaces import FLIGHTS, BranchChange
from painleve_sym.contacts.model import CONTACTS, SLIPS
from painleve_sym.errors import EventKind
from painleve_sym.hybrid.automaton import Choice, Transition, positive
from painleve_sym.laws.compliance import DELTA, DELTA_DOT, Branch

SIDE = sp.Symbol("slip_side", real=True)
"""Memory: s, the last direction of slip, or 0 where there was none since the contact closed."""

_ZERO = sp.Integer(0)


@dataclass(frozen=True)
class TangentialSpringContact(CompliantContact):
    """Builds the automaton of a contact whose law has `Friction.SPRING`.

    A contact that is loaded at the start and slides has been sliding: its spring is deflected by
    s μ F_n/k_t. At rest, and where it touches down, the spring is relaxed: s = ζ = 0.

    Parameters
    ----------
    model : ContactModel
        With exactly one contact, and a law whose force does not jump while the contact is loaded.

    References
    ----------
    Mindlin (1949); Iwan (1966); Dupont & Yamajako (1997).
    """

    @cached_property
    def tangential_stiffness(self) -> sp.Expr:
        """k_t; N/m."""
        stiffness = self.law.friction.tangential_stiffness
        assert stiffness is not None
        return stiffness

    @property
    def _relaxed(self) -> dict[sp.Symbol, sp.Expr]:
        """Reset where the contact closes: ξ = 0."""
        return {SIDE: _ZERO, self.deflection: _ZERO}

    @property
    def deflection(self) -> sp.Symbol:
        """State ζ."""
        return self.rows[0].deflection

    @cached_property
    def states(self) -> tuple[sp.Symbol, ...]:
        """Those of every contact, with ζ before the dissipated energies."""
        own, count = super().states, len(self.dissipations)
        return (*own[:-count], self.deflection, *own[-count:])

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """Memory of the law, and s."""
        return (*self.law.memory, SIDE)

    # ---- forces and rates ----

    def tangential_force(self, contact: str, force: sp.Expr) -> sp.Expr:
        """Return F_t of a contact mode for the normal force `force`."""
        if contact == "stick":
            limit = self.friction_coefficient * force
            return -SIDE * limit - self.tangential_stiffness * self.deflection
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

    def _limit_rate(self, branch: Branch, acceleration: sp.Expr) -> sp.Expr:
        """Return μ Ḟ_n/k_t of a branch at a g̈_N, inside the contact or where it begins; m/s."""
        by_depth, by_rate = (
            # A ramp rises from its kink on, and xⁿ/x is xⁿ⁻¹ also at x = 0.
            sp.powsimp(sp.diff(branch.force, s).replace(sp.Heaviside, lambda *_: sp.Integer(1)))
            for s in (DELTA, DELTA_DOT)
        )
        rate = self._of_state(by_depth * DELTA_DOT) - self._of_state(by_rate) * acceleration
        return self.friction_coefficient * rate / self.tangential_stiffness

    def _law_field(self, contact: str, branch: Branch) -> dict[sp.Symbol, sp.Expr]:
        rates = super()._law_field(contact, branch)
        yields = self._limit_rate(branch, rates[self.gap_rate])
        if contact == "stick":
            return rates | {self.deflection: self.slip - SIDE * yields, FRICTION_WORK: _ZERO}
        friction = self.tangential_force(contact, self._of_state(branch.force))
        velocity = self.slip - CONTACTS[contact] * yields
        return rates | {FRICTION_WORK: -friction * velocity}

    def outputs(self, contact: str | None, force: sp.Expr, stored: sp.Expr) -> dict[str, sp.Expr]:
        """Return forces, gap and energies of a mode, with ξ and the energy k_t ξ²/2."""
        friction = self.tangential_force(contact, force) if contact else _ZERO
        deflection = -friction / self.tangential_stiffness
        energy = stored + self.tangential_stiffness * deflection**2 / 2
        own = super().outputs(contact, force, energy)
        return own | {"tangential_deflection": deflection}

    # ---- transitions ----

    def _slip_starts(self, branch: Branch, force: sp.Expr) -> list[Transition]:
        """Return the ends of stick: the spring is deflected as far as friction can bear."""
        # μ F_n + s F_t, where nothing cancels on the side of the last slip.
        margins = {
            s: (1 - s * SIDE) * self.friction_coefficient * force
            - s * self.tangential_stiffness * self.deflection
            for s in SLIPS
        }
        return self.slip_starts(margins, partial(self._begun, branch), {self.deflection: _ZERO})

    def _slip_stop(self, s: int, branch: Branch, force: sp.Expr) -> Transition:
        """Return the end of slip along s: the spring yields as fast as the contact moves."""
        name = SLIPS[s]
        acceleration = self._law_field(name, branch)[self.gap_rate]
        yields = s * self._limit_rate(branch, acceleration)
        # |F_t| = μ F_n there, and both sides grow alike.
        stick = Choice(f"stick/{branch.name}", departs=(name,))
        reset = {self.deflection: _ZERO, SIDE: sp.Integer(s)}
        guard = s * (self.slip - yields)
        return self.transition("slip_stop", EventKind.SLIP_STOP, guard, (stick,), reset)

    def _change(self, contact: str, change: BranchChange) -> Transition:
        transition = super()._change(contact, change)
        if change.source in FLIGHTS or change.target not in FLIGHTS:
            return transition
        return replace(transition, reset={**transition.reset, **self._relaxed})

    def _landing(
        self, branch: Branch, touchdown: bool
    ) -> tuple[tuple[Choice, ...], dict[sp.Symbol, sp.Expr]]:
        """Return slip where the force of the spring, relaxed, would outgrow friction, else stick.

        Where the force sets in with a jump, by a dashpot, friction bears any deflection at first.
        """
        at = {self.gap: _ZERO} if touchdown else {}
        limit = self._limit_rate(branch, self.mechanism.coefficients.b_n).xreplace(at)
        slides = [positive(s * self.slip - limit) for s in SLIPS]
        if touchdown and branch.force.has(DELTA_DOT):
            borne = self.friction_coefficient * self._of_state(branch.force).xreplace(at)
            slides = [sp.And(sp.Le(borne, 0, evaluate=False), slide) for slide in slides]
        choices = (
            *(Choice(f"{n}/{branch.name}", c) for n, c in zip(SLIPS.values(), slides, strict=True)),
            Choice(f"stick/{branch.name}", departs=tuple(SLIPS.values())),
        )
        return choices, {**self._relaxed, **at}
