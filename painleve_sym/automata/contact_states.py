"""The states of a mechanism with its contacts, shared by all its automata."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import sympy as sp
from sympy.logic.boolalg import Boolean

from painleve_sym.automata.automaton import (
    Choice,
    Definition,
    HybridAutomaton,
    Mode,
    Reset,
    Transition,
    all_positive,
)
from painleve_sym.automata.contact_forces import ContactRow
from painleve_sym.automata.interfaces import Interface, cone_margins
from painleve_sym.automata.model import (
    CONTACT_LOSS,
    CONTACTS,
    FORCE_LOSS,
    FRICTION_LOSS,
    SLIPS,
    ContactModel,
)
from painleve_sym.automata.preparation import motion_steps, preparation
from painleve_sym.automata.variants import Term
from painleve_sym.contact_rows import ContactRows
from painleve_sym.errors import EventKind, StopReason
from painleve_sym.mechanics.coefficients import F_N, F_T, ContactCoefficients
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.solved import solved_motion
from painleve_sym.mechanics.system import TIME

FRICTION_WORK = sp.Symbol(FRICTION_LOSS, real=True)
CONTACT_WORK = sp.Symbol(CONTACT_LOSS, real=True)
FORCE_WORK = sp.Symbol(FORCE_LOSS, real=True)

_ZERO = sp.Integer(0)

SINGULAR_MARGIN = sp.Rational(1, 10**8)
"""|A_s|/W_nn at which a slip counts as having met A = 0: the limit is then linear in time."""


@dataclass(frozen=True)
class ContactStates(ABC):
    """States, energies and outputs of a mechanism with any number of contacts.

    The gap, its rate and the slip velocity are states of their own where they are not
    coordinates already: computed from q they cancel and lose precision.
    """

    model: ContactModel

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self.model.mechanism

    @cached_property
    def rows(self) -> tuple[ContactRow, ...]:
        """States of each contact."""
        given = zip(self.mechanism.contacts, self.model.rows, self.model.ends, strict=True)
        return tuple(ContactRow.of(*row) for row in given)

    @cached_property
    def states(self) -> tuple[sp.Symbol, ...]:
        """States of `Mechanism.motion`, of contacts where needed, then dissipated energies."""
        own = self.mechanism.motion
        extra = [s for row in self.rows for s in row.symbols if s not in own]
        springs = (s for contact in self.interfaces for s in contact.start.states)
        return (*own, *extra, *springs, *self.dissipations)

    @property
    @abstractmethod
    def interfaces(self) -> tuple[Interface, ...]:
        """The interface of each contact: its memory, local modes and transitions."""

    @cached_property
    def dissipations(self) -> tuple[sp.Symbol, ...]:
        """States that only account for energy; a moving surface does work like a drive."""
        moving = any(speed != 0 for speed in self.mechanism.drive_speeds)
        driven = self.mechanism.system.dissipated_power != 0 or moving
        return (FRICTION_WORK, CONTACT_WORK, *((FORCE_WORK,) if driven else ()))

    def drive_work(self, pushes: Iterable[sp.Expr]) -> sp.Expr:
        """Return the power (or work) taken from the drives by forces (or impulses) n1, t1, …."""
        speeds = self.mechanism.drive_speeds
        return sp.Add(*[p * v for p, v in zip(pushes, speeds, strict=True)])

    def motion_rates(
        self, accelerations: Iterable[sp.Expr], forces: Sequence[sp.Expr]
    ) -> dict[sp.Symbol, sp.Expr]:
        """Return the rates of coordinates, velocities, time, and the work of forces and drives.

        The accelerations are q̈, the forces those of the contacts, n1, t1, n2, t2, …; N.
        """
        system = self.mechanism.system
        rates = dict(zip(system.q, system.q_dot, strict=True))
        rates |= dict(zip(system.q_dot, accelerations, strict=True))
        if FORCE_WORK in self.dissipations:
            rates[FORCE_WORK] = system.dissipated_power - self.drive_work(forces)
        if self.mechanism.depends_on_time:
            rates[TIME] = sp.Integer(1)
        return rates

    def outputs_of(self, forces: Sequence[sp.Expr], stored: sp.Expr) -> dict[str, sp.Expr]:
        """Return forces, gaps and velocities of each contact, and energies.

        Of several contacts each name has that of its contact behind it.
        """
        values: dict[str, sp.Expr] = {}
        at = ContactRows(len(self.rows))
        for i, row in enumerate(self.rows):
            compression = {} if self.model.several else {"compression": -row.gap}
            own = {
                "normal_force": forces[at.normal(i)],
                "tangential_force": forces[at.tangent(i)],
                **compression,
                "gap": row.gap,
                "gap_rate": row.gap_rate,
                "slip_velocity": row.slip,
            }
            values |= {f"{name}{row.end}": value for name, value in own.items()}
        return values | {
            "kinetic_energy": self.mechanism.system.kinetic_energy,
            "potential_energy": self.mechanism.system.potential_energy,
            "stored_energy": stored,
        }

    def domain_ends(self, *slips: sp.Expr | int) -> tuple[Transition, ...]:
        """Return the transitions that end a run outside the mechanism's domain.

        `slips` are the signs of slip of all contacts, 0 for those that do not slide: with them
        |v_t| in conditions on friction is smooth.
        """
        kind, stop = EventKind.LEFT_DOMAIN, StopReason.LEFT_DOMAIN
        speeds = {
            row.contact.slip_speed: sign * row.slip
            for row, sign in zip(self.rows, slips, strict=True)
            if row.contact.friction_bounds
        }
        return tuple(
            Transition(f"domain_{i}", kind, bound.margin.xreplace(speeds), stop=stop, bound=i)
            for i, bound in enumerate(self.mechanism.domain)
        )

    @property
    @abstractmethod
    def terms(self) -> tuple[Term, ...]:
        """Abbreviations of the automaton."""

    @property
    @abstractmethod
    def automaton(self) -> HybridAutomaton:
        """The automaton, validated."""

    def automaton_of(
        self, title: str, modes: Iterable[Mode], starts: tuple[Choice, ...], **more: Any
    ) -> HybridAutomaton:
        """Return the automaton of these modes; `more` are further attributes of it.

        The title comes behind the mechanism's name in that of the automaton.
        """
        parameters = (*self.mechanism.system.parameters, *self.model.parameters)
        definitions = {s: v for law in self.model.own_laws for s, v in law.definitions.items()}
        return HybridAutomaton(
            name=f"{self.mechanism.name}{title}",
            states=self.states,
            parameters=tuple(p.symbol for p in parameters),
            definitions=definitions,
            modes=tuple(modes),
            starts=starts,
            preparation=preparation(
                self.mechanism, self.interfaces, self.dissipations, definitions
            ),
            terms=self.terms,
            **more,
        )


@dataclass(frozen=True)
class OneContact(ContactStates):
    """The only contact of a mechanism: its fields in local modes that are modes of the automaton.

    None of them depends on how the normal force arises.
    """

    stick_yields: ClassVar[bool] = False
    """Whether its stick has a force of its own, which does not keep v̇_t = 0."""

    @property
    @abstractmethod
    def interface(self) -> Interface:
        """The contact with its law."""

    @property
    def coefficients(self) -> ContactCoefficients:
        """W and b of the contact, in closed form or as symbols of terms of the automaton."""
        solved = solved_motion(self.mechanism)
        return solved.coefficients[0] if solved else self.mechanism.coefficients

    @property
    def terms(self) -> tuple[Definition, ...]:
        """Steps that lead to the coefficients, where they have no closed form."""
        return motion_steps(self.mechanism)

    @property
    def interfaces(self) -> tuple[Interface, ...]:
        """The contact with its law."""
        return (self.interface,)

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

    @property
    def _slip_is_extra(self) -> bool:
        """Whether the slip velocity is a state beside the velocities."""
        return self.slip not in self.mechanism.motion

    # ---- coefficients of slip, with the friction at its velocity ----

    def A(self, slip: int, side: int = 1) -> sp.Expr:
        """Return A_{sσ} of slip along s with a normal force of the sign σ; 1/kg."""
        friction = self.interface.kinetic_along(slip)
        return self.coefficients.A(slip * side, friction)

    def slip_rate_coefficient(self, slip: int, side: int = 1) -> sp.Expr:
        """Return C_{sσ}, so that v̇_t = C_{sσ} F_n + b_t in slip; 1/kg."""
        friction = self.interface.kinetic_along(slip)
        return self.coefficients.slip_rate_coefficient(slip * side, friction)

    def slip_force(self, slip: int, side: int = 1) -> sp.Expr:
        """Return F_n* = −B/A_{sσ}, with which the contact slides at constant gap; N."""
        return -self.coefficients.B / self.A(slip, side)

    # ---- events of friction ----

    def slip_starts(
        self,
        margins: Mapping[int, sp.Expr],
        choices: Callable[[int], tuple[Choice, ...]],
        reset: Reset | None = None,
    ) -> list[Transition]:
        """Return the ends of stick by their margins; each leads to choices of its slip.

        Where both are equal, stick needs no friction: it ends with the contact alone.
        """
        if margins[-1] == margins[1]:
            return []
        kind = EventKind.SLIP_START
        return [
            self.transition(SLIPS[s], kind, margin, choices(s), reset)
            for s, margin in margins.items()
        ]

    def stick_margins(self, force: sp.Expr, side: int = 1) -> dict[int, sp.Expr]:
        """Return `cone_margins` in stick, for a normal force of this sign."""
        limit = self.interface.static_coefficient * side * force
        return cone_margins(limit, self.tangential_force("stick", force))

    def slip_begins(self, slip: int, sign: int, side: int = 1) -> Boolean:
        """Return where slip can begin at v_t = 0, with A of this sign and F_n of this side."""
        c, force = self.coefficients, self.slip_force(slip, side)
        rate = slip * (self.slip_rate_coefficient(slip, side) * force + c.b_t)
        return all_positive(sign * self.A(slip, side), -sign * side * c.B, rate)

    def slip_stop(self, slip: int, choices: tuple[Choice, ...]) -> Transition:
        """Return the end of slip: v_t = 0."""
        still, kind = {self.slip: _ZERO}, EventKind.SLIP_STOP
        return self.transition("slip_stop", kind, slip * self.slip, choices, still)

    def singular(self, A: sp.Expr) -> Transition:
        """Return the end of a slip that meets A = 0, where its A is positive before."""
        margin = A / self.coefficients.W_nn - SINGULAR_MARGIN
        return self.transition("singular", EventKind.SINGULAR, margin, stop=StopReason.SINGULAR)

    def jam(self, guard: sp.Expr | None = None) -> Transition:
        """Return the end of an impact whose impulse has none."""
        return self.transition("jam", EventKind.JAM, guard, stop=StopReason.JAM)

    def curved_path(self) -> Transition:
        """Return the end of an impact whose slip has friction that varies with its velocity."""
        kind, stop = EventKind.IMPACT, StopReason.VARYING_FRICTION
        return self.transition("friction", kind, None, stop=stop)

    # ---- forces and rates ----

    def tangential_force(self, contact: str, force: sp.Expr, side: int = 1) -> sp.Expr:
        """Return F_t of a contact mode for the normal force `force` of the sign `side`."""
        c = self.coefficients
        if contact == "stick":
            if not (c.slides and self._slip_is_extra):
                return c.sticking_force.xreplace({F_N: force})
            smooth = c.accelerations.xreplace({F_N: force, F_T: _ZERO})
            return -row_acceleration(c.contact.J_T, smooth, c.contact.tangential_bias) / c.W_tt
        slip = CONTACTS[contact]
        return -slip * side * self.interface.kinetic_along(slip) * force

    def field(
        self,
        contact: str | None,
        force: sp.Expr,
        normal: sp.Expr | None = None,
        side: int = 1,
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
        side : int
            Sign of F_n.
        """
        c = self.coefficients
        friction = self.tangential_force(contact, force, side) if contact else _ZERO
        pushes = {F_N: force, F_T: friction}
        if contact == "stick" and not self.stick_yields and c.rank_one:
            # Any forces that hold the slip accelerate alike: those of F_n = 0, so that none cancel.
            pushes = {F_N: _ZERO, F_T: self.tangential_force(contact, _ZERO)}
        accelerations = c.accelerations.xreplace(pushes)
        rates = self.motion_rates(accelerations, (force, friction))
        rates[self.gap] = self.gap_rate
        # Both rows along q̈ share what it is made of; one alone is shorter as C F_n + b_t.
        along = accelerations if normal is None else None
        rates[self.slip] = self._slip_rate(contact, force, along, side)
        rates[self.gap_rate] = (
            self._normal(contact, force, accelerations) if normal is None else normal
        )
        rates[FRICTION_WORK] = -friction * self.slip if contact != "stick" else _ZERO
        rates[CONTACT_WORK] = _ZERO
        return rates

    def _normal(self, contact: str | None, force: sp.Expr, accelerations: sp.Matrix) -> sp.Expr:
        """Return g̈_N: exactly the same for any force where A′ = 0."""
        c, holds = self.coefficients, contact == "stick" and not self.stick_yields
        if self.gap not in self.mechanism.motion and not (holds and c.rank_one):
            return row_acceleration(c.contact.J_N, accelerations, c.contact.normal_bias)
        if holds:
            return c.A_stick * force + c.B_stick
        if contact == "stick":
            return c.W_nn * force + c.W_nt * self.tangential_force("stick", force) + c.b_n
        return self.A(CONTACTS[contact]) * force + c.B if contact else c.B

    def _slip_rate(
        self, contact: str | None, force: sp.Expr, accelerations: sp.Matrix | None, side: int
    ) -> sp.Expr:
        """Return v̇_t: exactly 0 where sticking holds it."""
        c = self.coefficients
        if contact == "stick" and not self.stick_yields:
            return _ZERO
        if self._slip_is_extra and accelerations is not None:
            return row_acceleration(c.contact.J_T, accelerations, c.contact.tangential_bias)
        if contact == "stick":
            return c.W_nt * force + c.W_tt * self.tangential_force("stick", force) + c.b_t
        if contact:
            return self.slip_rate_coefficient(CONTACTS[contact], side) * force + c.b_t
        return c.b_t

    def outputs(
        self, contact: str | None, force: sp.Expr, stored: sp.Expr, side: int = 1
    ) -> dict[str, sp.Expr]:
        """Return forces, gap and energies of a mode; `side` is the sign of the normal force."""
        friction = self.tangential_force(contact, force, side) if contact else _ZERO
        return self.outputs_of((force, friction), stored)

    def held_mode(
        self,
        name: str,
        contact: str,
        force: sp.Expr,
        transitions: tuple[Transition, ...],
        side: int = 1,
    ) -> Mode:
        """Return a mode in which F_n = `force`, of the sign `side`, keeps the gap at 0.

        The domain ends it, too.
        """
        rates = self.field(contact, force, normal=_ZERO, side=side) | {self.gap: _ZERO}
        outputs = self.outputs(contact, force, _ZERO, side)
        ends = self.domain_ends(CONTACTS[contact])
        return Mode(name, rates, (*transitions, *ends), outputs)

    def instant_mode(self, name: str, *transitions: Transition) -> Mode:
        """Return a mode in which no time passes, without forces."""
        return Mode(name, {}, transitions, self.outputs(None, _ZERO, _ZERO))


def row_acceleration(jacobian: sp.Matrix, accelerations: sp.Matrix, bias: sp.Expr) -> sp.Expr:
    """Return J q̈ + J̇ q̇ with the accelerations as they stand: they are computed once."""
    parts = [
        a if j == 1 else sp.Mul(j, a, evaluate=False)
        for j, a in zip(jacobian, accelerations, strict=True)
        if j != 0 and a != 0
    ]
    return sp.Add(*parts, bias, evaluate=False) if parts else bias
