"""Forces of one contact among several: a table of its local modes, summed once."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import sympy as sp
from sympy.logic.boolalg import Boolean

from painleve_sym.automata.automaton import positive
from painleve_sym.automata.model import StateRow
from painleve_sym.laws.catalogue import OwnLaw
from painleve_sym.mechanics.contact import Contact

RESOLVED = sp.Integer(10)
"""Of the unresolved force: what is above rounding."""

_ZERO, _ONE = sp.Integer(0), sp.Integer(1)

Memory = dict[sp.Symbol, sp.Expr]


@dataclass(frozen=True)
class ContactRow:
    """The states of one contact: gap, its rate, and slip velocity.

    `end` stands behind the names of its states and outputs where there are several contacts.
    """

    contact: Contact
    gap: sp.Symbol
    gap_rate: sp.Symbol
    slip: sp.Symbol
    end: str = ""

    @classmethod
    def of(cls, contact: Contact, names: StateRow, end: str) -> ContactRow:
        """Return the row, with coordinates and velocities in place of symbols of its own."""
        system = contact.system
        known = {s.name: s for s in (*system.q, *system.q_dot)}
        gap, rate, slip = (known.get(name) or sp.Symbol(name, real=True) for name in names)
        return cls(contact, gap, rate, slip, end)

    @property
    def name(self) -> str:
        """Name of the contact."""
        return self.contact.name

    @property
    def deflection(self) -> sp.Symbol:
        """State ζ of its tangential spring: deflection less the deflection in slip; m."""
        return sp.Symbol(f"deflection_from_slip{self.end}", real=True)

    @property
    def symbols(self) -> tuple[sp.Symbol, sp.Symbol, sp.Symbol]:
        """Gap, its rate, slip velocity."""
        return self.gap, self.gap_rate, self.slip

    @property
    def expressions(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """The states as functions of coordinates and velocities."""
        return self.contact.gap, self.contact.gap_rate, self.contact.slip_velocity


@dataclass(frozen=True)
class ContactMotion:
    """Forces (N) and accelerations (m/s²) of a contact, as expressions of the automaton.

    `force_scale` is the size of the forces, for what counts as rounding; the scales of the
    accelerations are the sums of the sizes of their terms. `normal_mobility` is W_nn, 1/kg;
    `force_square` is the sum of the squares of the forces of all contacts, N².
    """

    normal_force: sp.Expr
    tangential_force: sp.Expr
    normal_acceleration: sp.Expr
    tangential_acceleration: sp.Expr
    force_scale: sp.Expr
    normal_scale: sp.Expr
    tangential_scale: sp.Expr
    normal_mobility: sp.Expr
    force_square: sp.Expr


@dataclass(frozen=True)
class LocalContact:
    """One contact among several: its states, its law, and the memory of its friction.

    `target` is the mode that follows an event which its contact problem must answer.
    """

    row: ContactRow
    target: str
    law: OwnLaw

    def _symbol(self, prefix: str) -> sp.Symbol:
        return sp.Symbol(f"{prefix}{self.row.end}", real=True)

    @cached_property
    def local(self) -> sp.Symbol:
        """Index of the local mode."""
        return self._symbol("local_mode")

    @cached_property
    def sign(self) -> sp.Symbol:
        """Sign of slip where it slips, else 0."""
        return self._symbol("slip_sign")

    @cached_property
    def sticks(self) -> sp.Symbol:
        """1 where it sticks, else 0."""
        return self._symbol("sticks")

    @property
    def alone(self) -> sp.Expr:
        """1 where it sticks within its cone, else 0."""
        return self.sticks * (1 - self.sign**2)

    @property
    def at_bound(self) -> sp.Expr:
        """1 where it sticks with its friction at a bound, as others hold it, else 0."""
        return self.sticks * self.sign**2

    @property
    def static_coefficient(self) -> sp.Expr:
        """Coefficient up to which it sticks: μ_s of the contact times r_s of the law."""
        return self.row.contact.friction_curve.at_rest * self.law.friction.static_ratio

    def kinetic_along(self, sign: sp.Expr | int) -> sp.Expr:
        """Return the coefficient in slip of this sign: μ(s v_t) of the contact times r(v_t)."""
        slip = self.row.slip
        own = self.row.contact.friction_curve.in_slip(sign * slip)
        return own * self.law.friction.kinetic_ratio(slip)

    @property
    def kinetic_coefficient(self) -> sp.Expr:
        """Coefficient of friction in slip, a function of its slip velocity."""
        return self.kinetic_along(self.sign)

    @property
    def is_coulomb(self) -> bool:
        """Whether one coefficient is that of rest and of all slips."""
        return self.row.contact.friction_curve.is_coulomb and self.law.friction.is_coulomb

    @property
    def released(self) -> Memory:
        """Neither stick nor slip: a contact whose sticking has just ended does not stick again.

        With a static friction above the kinetic one both may be possible.
        """
        return {} if self.is_coulomb else {self.sign: _ZERO, self.sticks: _ZERO}

    def may_stick(self, rest: Boolean, closes: sp.Expr = _ZERO) -> Boolean:
        """Return where it may stick: at rest, but where its sticking has just ended.

        `closes` is 1 where it was open before.
        """
        if self.is_coulomb:
            return rest
        return sp.And(rest, positive(self.sticks + self.sign**2 + closes))


class Known(enum.StrEnum):
    """Source of a force in a local mode."""

    ZERO = enum.auto()
    GIVEN = enum.auto()
    """A law gives it: from the compression, or friction from the normal force."""
    UNKNOWN = enum.auto()
    """It keeps an acceleration at 0; friction that this leaves open is shared."""


class LocalMode(NamedTuple):
    """A row of the table of a contact: sources of its forces, and free motions, in one local mode.

    The `flag` is made of memory: 1 in this local mode, 0 in the others.
    """

    flag: sp.Expr
    normal: Known
    friction: Known
    gap_moves: bool
    slip_moves: bool


@dataclass(frozen=True)
class Forces:
    """The forces of one contact in all its local modes, which are the rows of its table.

    `side` is the sign of the normal force that it may carry. `given` is F_n where a law gives it,
    N, `unresolved` the rounding of it, N, and `spring_force` the part of F_t that no normal force
    determines, N. The `stored_energy` can be returned, J; the `dissipated_power` is that of the
    normal motion, W.
    """

    contact: LocalContact
    table: tuple[LocalMode, ...]
    side: sp.Expr = _ONE
    given: sp.Expr | None = None
    unresolved: sp.Expr = _ZERO
    spring_force: sp.Expr = _ZERO
    stored_energy: sp.Expr = _ZERO
    dissipated_power: sp.Expr = _ZERO
    outputs: Mapping[str, sp.Expr] = field(default_factory=dict)

    def _total(self, holds: Callable[[LocalMode], bool]) -> sp.Expr:
        return sp.Add(*[mode.flag for mode in self.table if holds(mode)])

    @cached_property
    def closed(self) -> sp.Expr:
        """1 where it may carry force, else 0."""
        return self._total(lambda mode: mode.normal is not Known.ZERO)

    @cached_property
    def holds(self) -> sp.Expr:
        """1 where its friction keeps v̇_t = 0, else 0."""
        return self._total(lambda mode: mode.friction is Known.UNKNOWN)

    @cached_property
    def still(self) -> sp.Expr:
        """1 where v̇_t = 0, else 0."""
        return self._total(lambda mode: not mode.slip_moves)

    @cached_property
    def apart(self) -> sp.Expr:
        """1 where its gap may change, else 0."""
        return self._total(lambda mode: mode.gap_moves)

    @property
    def unresolved_friction(self) -> sp.Expr:
        """Friction that is rounding beside the forces of the contact, which stick bears; N."""
        return self.contact.static_coefficient * self.unresolved

    def capacity(self, normal_force: sp.Expr) -> sp.Expr:
        """Return the friction that stick bears under a normal force; N."""
        return self.contact.static_coefficient * self.side * normal_force + self.unresolved_friction

    def known_friction(self, normal_force: sp.Expr) -> sp.Expr:
        """Return F_t per normal force where its friction does not keep v̇_t = 0; N."""
        return -self.contact.kinetic_coefficient * self.side * self.contact.sign * normal_force

    def resolved(self, normal_force: sp.Expr, total: sp.Expr) -> sp.Expr:
        """Return F_n, floored at its rounding where that of all contacts is below it; N.

        A contact that closes has F_n = 0 and bears no friction. Where no other contact bears
        force, it is F_n a moment later, as its friction grows together with its normal force.

        Parameters
        ----------
        normal_force : sympy.Expr
            F_n; N.
        total : sympy.Expr
            Sum of the sizes of all normal forces; N.
        """
        if self.unresolved == 0:
            return normal_force
        missing = sp.Max(RESOLVED * self.unresolved - total, 0)
        return normal_force + self.closed * sp.Heaviside(-self.contact.row.gap_rate, 0) * missing

    def rates(self, motion: ContactMotion) -> dict[sp.Symbol, sp.Expr]:
        """Return the rates of states of its own beside its row."""
        return {}

    def rubbing_velocity(self, motion: ContactMotion) -> sp.Expr:
        """Return the velocity at which friction slips; m/s."""
        return self.contact.row.slip
