"""The states of a mechanism with one contact, shared by its compliant and its rigid automaton."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from painleve_sym.contacts.model import CONTACT_LOSS, CONTACTS, FORCE_LOSS, FRICTION_LOSS
from painleve_sym.errors import EventKind, StopReason
from painleve_sym.hybrid.automaton import Choice, Mode, Reset, Transition
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import TIME

GAP, GAP_RATE = sp.Symbol("gap", real=True), sp.Symbol("gap_dot", real=True)
SLIP = sp.Symbol("slip_velocity", real=True)
DEFLECTION = sp.Symbol("deflection_from_slip", real=True)
"""ζ of the tangential spring of a contact, its deflection from that of slip; m."""
FRICTION_WORK = sp.Symbol(FRICTION_LOSS, real=True)
CONTACT_WORK = sp.Symbol(CONTACT_LOSS, real=True)
FORCE_WORK = sp.Symbol(FORCE_LOSS, real=True)


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
        """The states as functions of coordinates and velocities."""
        return self.contact.gap, self.contact.gap_rate, self.contact.slip_velocity


def domain_transitions(mechanism: Mechanism) -> list[Transition]:
    """Return the transitions that end a run outside the mechanism's domain."""
    return [
        Transition(
            f"domain_{i}",
            EventKind.LEFT_DOMAIN,
            bound.margin,
            stop=StopReason.LEFT_DOMAIN,
            bound=i,
        )
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

    def transition(
        self,
        label: str,
        kind: EventKind,
        guard: sp.Expr | None,
        choices: tuple[Choice, ...] = (),
        reset: Reset | None = None,
        **more: Any,
    ) -> Transition:
        """Return a transition of the contact; see `Transition`."""
        name = self.mechanism.contact.name
        return Transition(label, kind, guard, choices, reset or {}, contact=name, **more)

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
        """States of `Mechanism.motion`, contact states where needed, then dissipated energies."""
        extra = [s for s in self.rows[0].symbols if s in (GAP, GAP_RATE, SLIP)]
        return (*self.mechanism.motion, *extra, *self.dissipations)

    @cached_property
    def dissipations(self) -> tuple[sp.Symbol, ...]:
        """States that only account for energy; a moving surface does work like a drive."""
        driven = self.mechanism.system.dissipated_power != 0 or any(self.drive_speeds)
        return (FRICTION_WORK, CONTACT_WORK, *((FORCE_WORK,) if driven else ()))

    @property
    def drive_speeds(self) -> tuple[sp.Expr, sp.Expr]:
        """`ContactCoefficients.drive_speeds` of the contact."""
        return self.mechanism.coefficients.drive_speeds

    @property
    def friction_coefficient(self) -> sp.Expr:
        """Coefficient of friction in slip, which may depend on the slip velocity."""
        return self.mechanism.coefficients.mu

    def tangential_force(self, contact: str, force: sp.Expr) -> sp.Expr:
        """Return F_t of a contact mode for the normal force `force`."""
        c = self.mechanism.coefficients
        if contact == "stick":
            if self.slip != SLIP:
                return c.sticking_force.xreplace({F_N: force})
            if c.W_tt == 0:  # no motion slides the contact: nothing is to be held
                return sp.Integer(0)
            smooth = c.accelerations.xreplace({F_N: force, F_T: sp.Integer(0)})
            return -row_acceleration(c.contact.J_T, smooth, c.contact.tangential_bias) / c.W_tt
        return -CONTACTS[contact] * self.friction_coefficient * force

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
        rates[self.gap] = self.gap_rate
        # Both rows along q̈ share what it is made of; one alone is shorter as C F_n + b_t.
        along = accelerations if normal is None else None
        rates[self.slip] = self._slip_rate(contact, force, along)
        rates[self.gap_rate] = (
            self._normal(contact, force, accelerations) if normal is None else normal
        )
        rates[FRICTION_WORK] = -friction * self.slip if contact != "stick" else sp.Integer(0)
        rates[CONTACT_WORK] = sp.Integer(0)
        if FORCE_WORK in self.dissipations:
            normal_drive, drive = self.drive_speeds
            rates[FORCE_WORK] = system.dissipated_power - friction * drive - force * normal_drive
        if self.mechanism.depends_on_time:
            rates[TIME] = sp.Integer(1)
        return rates

    def _normal(self, contact: str | None, force: sp.Expr, accelerations: sp.Matrix) -> sp.Expr:
        """Return g̈_N: exactly the same for any force where A′ = 0."""
        c = self.mechanism.coefficients
        if self.gap_rate == GAP_RATE and not (contact == "stick" and c.rank_one):
            return row_acceleration(c.contact.J_N, accelerations, c.contact.normal_bias)
        if contact == "stick":
            return c.A_stick * force + c.B_stick
        return c.A(CONTACTS[contact], self.friction_coefficient) * force + c.B if contact else c.B

    def _slip_rate(
        self, contact: str | None, force: sp.Expr, accelerations: sp.Matrix | None
    ) -> sp.Expr:
        """Return v̇_t: exactly 0 in sticking."""
        c = self.mechanism.coefficients
        if contact == "stick":
            return sp.Integer(0)
        if self.slip == SLIP and accelerations is not None:
            return row_acceleration(c.contact.J_T, accelerations, c.contact.tangential_bias)
        if contact:
            along = c.slip_rate_coefficient(CONTACTS[contact], self.friction_coefficient)
            return along * force + c.b_t
        return c.b_t

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

    def held_mode(
        self, name: str, contact: str, force: sp.Expr, transitions: tuple[Transition, ...]
    ) -> Mode:
        """Return a mode in which F_n = `force` keeps the gap at 0; the domain ends it, too."""
        zero = sp.Integer(0)
        rates = self.field(contact, force, normal=zero) | {self.gap: zero}
        outputs = self.outputs(contact, force, zero)
        return Mode(name, rates, (*transitions, *domain_transitions(self.mechanism)), outputs)


def row_acceleration(jacobian: sp.Matrix, accelerations: sp.Matrix, bias: sp.Expr) -> sp.Expr:
    """Return J q̈ + J̇ q̇ with the accelerations as they stand: they are computed once."""
    parts = [
        a if j == 1 else sp.Mul(j, a, evaluate=False)
        for j, a in zip(jacobian, accelerations, strict=True)
        if j != 0 and a != 0
    ]
    return sp.Add(*parts, bias, evaluate=False) if parts else bias
