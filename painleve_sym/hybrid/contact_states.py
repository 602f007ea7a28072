"""The states of a mechanism with one contact, shared by its softened and its rigid automaton."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.errors import StopReason
from painleve_sym.hybrid.automaton import Transition
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.models import Mechanism

GAP, GAP_RATE = sp.Symbol("gap", real=True), sp.Symbol("gap_dot", real=True)
SLIP = sp.Symbol("slip_velocity", real=True)
FRICTION_WORK = sp.Symbol("friction_dissipation", real=True)
CONTACT_WORK = sp.Symbol("contact_dissipation", real=True)
FORCE_WORK = sp.Symbol("force_dissipation", real=True)

FLIGHT = "flight"
CONTACTS = {"slip_neg": -1, "slip_pos": 1, "stick": 0}
"""Contact modes and their slip direction."""


@dataclass(frozen=True)
class ContactRow:
    """The states of one contact: gap, its rate, and slip velocity."""

    contact: Contact
    gap: sp.Symbol
    gap_rate: sp.Symbol
    slip: sp.Symbol

    @classmethod
    def of(
        cls, contact: Contact, gap: sp.Symbol, gap_rate: sp.Symbol, slip: sp.Symbol
    ) -> ContactRow:
        """Return the row, with coordinates and velocities in place of symbols of its own."""
        system = contact.system
        if contact.gap in system.q:
            gap = contact.gap
            gap_rate = system.q_dot[system.q.index(gap)]
        if contact.slip_velocity in system.q_dot:
            slip = contact.slip_velocity
        return cls(contact, gap, gap_rate, slip)

    @property
    def symbols(self) -> tuple[sp.Symbol, sp.Symbol, sp.Symbol]:
        """Gap, its rate, slip velocity."""
        return self.gap, self.gap_rate, self.slip

    @property
    def expressions(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """What the states are in coordinates and velocities."""
        return self.contact.gap, self.contact.gap_rate, self.contact.slip_velocity


def domain_transitions(mechanism: Mechanism) -> list[Transition]:
    """Return the transitions that end a run outside the mechanism's domain."""
    return [
        Transition(f"domain_{i}", "left_domain", bound.margin, stop=StopReason.LEFT_DOMAIN)
        for i, bound in enumerate(mechanism.domain)
    ]


@dataclass(frozen=True)
class ContactStates:
    """States and fields that do not depend on how the normal force arises.

    The gap, its rate and the slip velocity are states of their own where they are not
    coordinates already: computed from q they cancel and lose precision.

    Parameters
    ----------
    mechanism : Mechanism
        With exactly one contact.
    """

    mechanism: Mechanism

    @cached_property
    def rows(self) -> tuple[ContactRow, ...]:
        """States of the contact, as the only row."""
        return (ContactRow.of(self.mechanism.contact, GAP, GAP_RATE, SLIP),)

    @property
    def gap(self) -> sp.Symbol:
        """State that holds g_N."""
        return self.rows[0].gap

    @property
    def gap_rate(self) -> sp.Symbol:
        """State that holds ġ_N."""
        return self.rows[0].gap_rate

    @property
    def slip(self) -> sp.Symbol:
        """State that holds v_t."""
        return self.rows[0].slip

    @cached_property
    def states(self) -> tuple[sp.Symbol, ...]:
        """Coordinates, velocities, contact states where needed, then dissipated energies."""
        system = self.mechanism.system
        extra = [s for s in self.rows[0].symbols if s in (GAP, GAP_RATE, SLIP)]
        return (*system.q, *system.q_dot, *extra, *self.dissipations)

    @cached_property
    def dissipations(self) -> tuple[sp.Symbol, ...]:
        """States that only account for energy; a moving surface does work like a drive."""
        driven = self.mechanism.system.dissipated_power != 0 or self._surface_speed != 0
        return (FRICTION_WORK, CONTACT_WORK, *((FORCE_WORK,) if driven else ()))

    @property
    def _surface_speed(self) -> sp.Expr:
        return sp.sympify(self.mechanism.contact.surface_speed)

    def tangential_force(self, contact: str, force: sp.Expr) -> sp.Expr:
        """Return F_t of a contact mode for the normal force `force`."""
        c = self.mechanism.coefficients
        if contact == "stick":
            return c.sticking_force.xreplace({F_N: force})
        return -CONTACTS[contact] * c.mu * force

    def field(
        self, contact: str | None, force: sp.Expr, normal: sp.Expr | None = None
    ) -> dict[sp.Symbol, sp.Expr]:
        """Return the rates of all states but the law's own dissipation.

        Parameters
        ----------
        contact : str or None
            Contact mode; None in flight.
        force : sympy.Expr
            F_n.
        normal : sympy.Expr, optional
            g̈_N where it is known better than A F_n + B (0 on a rigid surface).
        """
        system, c = self.mechanism.system, self.mechanism.coefficients
        friction = self.tangential_force(contact, force) if contact else sp.Integer(0)
        rates = dict(zip(system.q, system.q_dot, strict=True))
        accelerations = c.accelerations.xreplace({F_N: force, F_T: friction})
        rates |= dict(zip(system.q_dot, accelerations, strict=True))
        # The contact rows in the form A F_n + B: no cancellation, and exactly 0 in sticking.
        slip = CONTACTS[contact] if contact else 0
        if contact == "stick":
            rows = (c.A_stick * force + c.B_stick, sp.Integer(0))
        elif contact:
            rows = (c.A(slip) * force + c.B, c.slip_rate_coefficient(slip) * force + c.b_t)
        else:
            rows = (c.B, c.b_t)
        rates |= {self.gap: self.gap_rate, self.slip: rows[1]}
        rates[self.gap_rate] = rows[0] if normal is None else normal
        rates[FRICTION_WORK] = -friction * self.slip if contact != "stick" else sp.Integer(0)
        rates[CONTACT_WORK] = sp.Integer(0)
        if FORCE_WORK in self.dissipations:
            rates[FORCE_WORK] = system.dissipated_power - friction * self._surface_speed
        return rates

    def outputs(self, contact: str | None, force: sp.Expr, stored: sp.Expr) -> dict[str, sp.Expr]:
        """Return forces, gap and energies of a mode."""
        system = self.mechanism.system
        friction = self.tangential_force(contact, force) if contact else sp.Integer(0)
        return {
            "normal_force": force,
            "tangential_force": friction,
            "compression": -self.gap,
            "gap": self.gap,
            "gap_rate": self.gap_rate,
            "slip_velocity": self.slip,
            "kinetic_energy": system.kinetic_energy,
            "potential_energy": system.potential_energy,
            "stored_energy": stored,
        }
