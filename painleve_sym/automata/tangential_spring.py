"""A compliant contact that yields along its tangent, too: one of several, and an only one.

A spring of stiffness k_t is in series with Coulomb friction; its deflection is ξ, and F_t = −k_t ξ.
In stick ξ̇ = v_t. In slip along s the force is −s μ F_n, hence ξ = s μ F_n/k_t: friction slips at
v_t − ξ̇ = v_t − s μ Ḟ_n/k_t, and stops where that vanishes.

The state of the contact is ζ = ξ − s μ F_n/k_t, the deflection from that of slip along s, where s
is the last direction of slip, 0 before the first slip of a contact. Slip ends with ζ = ζ̇ = 0, and
with ζ itself as a state round-off does not start it again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import ClassVar

import sympy as sp
from sympy.logic.boolalg import Boolean

from painleve_sym.automata.automaton import Alternative, Choice, Part, Test, Transition, positive
from painleve_sym.automata.compliant import BranchChange, CompliantContact, CompliantInterface
from painleve_sym.automata.contact_forces import ContactMotion, Forces, Known, LocalMode, Memory
from painleve_sym.automata.contact_states import FRICTION_WORK
from painleve_sym.automata.interfaces import (
    FLIGHTS,
    SLIP_STARTS,
    ContactStart,
    not_negative,
)
from painleve_sym.automata.model import CONTACTS, FLIGHT, MOTION, SLIPS
from painleve_sym.errors import EventKind
from painleve_sym.laws.compliance import DELTA, DELTA_DOT, Branch

_ZERO, _ONE = sp.Integer(0), sp.Integer(1)


@dataclass(frozen=True)
class SpringInterface(CompliantInterface):
    """A compliant contact that yields along its tangent, too: its law has `Friction.SPRING`.

    F_t follows from its states, so that nothing is to be chosen where it stops, slips or lands.

    References
    ----------
    Mindlin (1949); Iwan (1966); Dupont & Yamajako (1997).
    """

    @property
    def stiffness(self) -> sp.Expr:
        """k_t; N/m."""
        stiffness = self.law.friction.tangential_stiffness
        assert stiffness is not None
        return stiffness

    @property
    def start(self) -> ContactStart:
        """Start of its law, with the deflection as a state."""
        return replace(super().start, tangential_stiffness=self.stiffness)

    @cached_property
    def last_slip(self) -> sp.Symbol:
        """Memory: s, the last direction of slip; 0 before the first slip since it closed."""
        return self._symbol("slip_side")

    @property
    def relaxed(self) -> Memory:
        """Reset where the contact closes: ξ = 0."""
        return {self.last_slip: _ZERO, self.row.deflection: _ZERO}

    def limit_rate(self, branch: Branch, acceleration: sp.Expr) -> sp.Expr:
        """Return μ Ḟ_n/k_t of a branch at a g̈_N, inside the contact or where it begins; m/s."""
        by_depth, by_rate = (
            # A ramp rises from its kink on, and xⁿ/x is xⁿ⁻¹ also at x = 0.
            sp.powsimp(sp.diff(branch.force, s).replace(sp.Heaviside, lambda *_: _ONE))
            for s in (DELTA, DELTA_DOT)
        )
        rate = self.of_state(by_depth * DELTA_DOT) - self.of_state(by_rate) * acceleration
        return self.kinetic_coefficient * rate / self.stiffness

    def slip_margins(self, normal_force: sp.Expr) -> dict[int, sp.Expr]:
        """Return μ F_n + s F_t by s; nothing cancels on the side of the last slip."""
        return {
            s: (1 - s * self.last_slip) * self.kinetic_coefficient * normal_force
            - s * self.stiffness * self.row.deflection
            for s in SLIPS
        }

    def slides(self, change: BranchChange, acceleration: sp.Expr) -> dict[int, Boolean]:
        """Return the conditions under which a closing contact slides, by the direction of the slip.

        There the force of the spring, relaxed, would outgrow friction. Where the normal force sets
        in with a jump, by a dashpot, friction bears any deflection at first.
        """
        branch, at = self.law.branch(change.target), self.landing_states(change)
        limit = self.limit_rate(branch, acceleration).xreplace(at)
        slides = {s: positive(s * self.row.slip - limit) for s in SLIPS}
        if at and branch.force.has(DELTA_DOT):
            borne = self.kinetic_coefficient * self.of_state(branch.force).xreplace(at)
            none = sp.Le(borne, 0, evaluate=False)
            slides = {s: sp.And(none, slide) for s, slide in slides.items()}
        return slides

    def landing_states(self, change: BranchChange) -> Memory:
        """Return the gap of a touchdown, exactly 0."""
        return {self.row.gap: _ZERO} if change.source == FLIGHT else {}

    # ---- one of several contacts ----

    @property
    def _friction_memory(self) -> tuple[sp.Symbol, ...]:
        return (*super()._friction_memory, self.last_slip)

    @cached_property
    def forces(self) -> SpringForces:
        """The law gives F_n, and the spring F_t = −s μ F_n − k_t ζ, of stick and of slip."""
        k, zeta, of_law = self.stiffness, self.row.deflection, self._of_law
        xi = zeta + self.kinetic_coefficient * self.last_slip * of_law["given"] / k
        of_law["stored_energy"] += k * xi**2 / 2
        closed = LocalMode(self.closed, Known.GIVEN, Known.GIVEN, gap_moves=True, slip_moves=True)
        outputs = {f"tangential_deflection{self.row.end}": xi}
        return SpringForces(
            self, (self._flies, closed), **of_law, spring_force=-k * zeta, outputs=outputs
        )

    def yields(self, motion: ContactMotion) -> sp.Expr:
        """Return μ Ḟ_n/k_t; m/s."""
        return self.in_branches(lambda b: self.limit_rate(b, motion.normal_acceleration))

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return none: its forces follow from its state."""
        return []

    @property
    def part(self) -> Part:
        """It keeps on, whatever the others choose."""
        keeps = (Alternative(not_negative(self.closed)),)
        return self._part(alternatives=keeps, leaving=self._starts, variants=self._variants)

    @property
    def _starts(self) -> tuple[str, ...]:
        return tuple(f"{label}:{self.row.name}" for label in SLIP_STARTS.values())

    def _friction_changes(self, motion: ContactMotion) -> list[Transition]:
        still = {self.row.deflection: _ZERO}
        changes = [
            self.watch.transition(
                SLIP_STARTS[s],
                EventKind.SLIP_START,
                self.sticks * (margin + self.forces.unresolved_friction),
                self._rub(sp.Integer(s), _ZERO) | {self.last_slip: sp.Integer(s)} | still,
                asks=False,
                departs=self.watch.leaving[:1],
            )
            for s, margin in self.slip_margins(motion.normal_force).items()
        ]
        guard, sticks = (
            self.sign * self.forces.rubbing_velocity(motion),
            self._rub(_ZERO, _ONE) | still,
        )
        stop = self.watch.transition(
            "slip_stop", EventKind.SLIP_STOP, guard, sticks, asks=False, departs=self._starts
        )
        return [*changes, stop]

    def _enter_flight(self, name: str) -> Memory:
        return super()._enter_flight(name) | self.relaxed

    def _enter_branch(self, branch: str) -> Memory:
        """Return the memory of a loaded start; a contact with slip has been sliding before."""
        return super()._enter_branch(branch) | {self.last_slip: sp.sign(self.row.slip)}

    def _land(self, change: BranchChange, motion: ContactMotion) -> Memory:
        slides = self.slides(change, motion.normal_acceleration)

        def where(values: Mapping[int, int]) -> sp.Piecewise:
            """Return the value of the slip that begins, or that of stick, 0."""
            cases = [(values[s], condition) for s, condition in slides.items()]
            return sp.Piecewise(*cases, (values[0], True), evaluate=False)

        sign = where({-1: -1, 0: 0, 1: 1})
        return {
            self.local: self._index(change.target) + sign,
            self.sign: sign,
            self.sticks: where({-1: 0, 0: 1, 1: 0}),
            **self._in(change.target),
            **self._resolution(motion),
            **self.relaxed,
            **self.landing_states(change),
            self.last_slip: sign,
        }


@dataclass(frozen=True)
class SpringForces(Forces):
    """Forces of a contact with a tangential spring."""

    contact: SpringInterface

    def known_friction(self, normal_force: sp.Expr) -> sp.Expr:
        """Return −s μ F_n, of stick and of slip; N."""
        return -self.contact.kinetic_coefficient * self.contact.last_slip * normal_force

    def rates(self, motion: ContactMotion) -> dict[sp.Symbol, sp.Expr]:
        """Return ζ̇."""
        own, row = self.contact, self.contact.row
        return {row.deflection: own.sticks * (row.slip - own.last_slip * own.yields(motion))}

    def rubbing_velocity(self, motion: ContactMotion) -> sp.Expr:
        """Return v_t − ξ̇ of slip; m/s."""
        return self.contact.row.slip - self.contact.sign * self.contact.yields(motion)


@dataclass(frozen=True)
class TangentialSpringContact(CompliantContact):
    """Builds the automaton of a contact whose law has `Friction.SPRING`; see `SpringInterface`.

    A contact that is loaded at the start and slides has been sliding: its spring is deflected by
    s μ F_n/k_t. At rest, and where it touches down, the spring is relaxed: s = ζ = 0. The force of
    the law does not jump while the contact is loaded.
    """

    stick_yields: ClassVar[bool] = True

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

    def tangential_force(self, contact: str, force: sp.Expr, side: int = 1) -> sp.Expr:
        """Return F_t of a contact mode for the normal force `force`."""
        if contact == "stick":
            limit = self.interface.kinetic_along(0) * force
            return -self.interface.last_slip * limit - self.interface.stiffness * self.deflection
        return super().tangential_force(contact, force, side)

    def _law_field(self, contact: str, branch: Branch) -> dict[sp.Symbol, sp.Expr]:
        rates = super()._law_field(contact, branch)
        yields = self.interface.limit_rate(branch, rates[self.gap_rate])
        if contact == "stick":
            velocity = self.slip - self.interface.last_slip * yields
            return rates | {self.deflection: velocity, FRICTION_WORK: _ZERO}
        friction = self.tangential_force(contact, self.interface.of_state(branch.force))
        velocity = self.slip - CONTACTS[contact] * yields
        return rates | {FRICTION_WORK: -friction * velocity}

    def outputs(
        self, contact: str | None, force: sp.Expr, stored: sp.Expr, side: int = 1
    ) -> dict[str, sp.Expr]:
        """Return forces, gap and energies of a mode, with ξ and the energy k_t ξ²/2."""
        friction = self.tangential_force(contact, force) if contact else _ZERO
        deflection = -friction / self.interface.stiffness
        energy = stored + self.interface.stiffness * deflection**2 / 2
        own = super().outputs(contact, force, energy, side)
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
        slides = self.interface.slides(change, self.coefficients.b_n)
        choices = (
            *(Choice(f"{SLIPS[s]}/{change.target}", slide) for s, slide in slides.items()),
            Choice(f"stick/{change.target}", departs=tuple(SLIPS.values())),
        )
        return choices, {**self.interface.relaxed, **self.interface.landing_states(change)}
