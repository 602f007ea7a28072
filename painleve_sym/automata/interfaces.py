"""Contacts as parts of a motion with several contacts: their local modes as data.

Each interface holds the memory of one contact (which branch it is in, the sign of its slip, whether
it sticks), by which forces are put together, the transitions that change it, and the inequalities
that its local modes must satisfy.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import sympy as sp
from sympy.logic.boolalg import Boolean

from painleve_sym.automata.automaton import Alternative, Choice, Part, Test, TestRole, Transition
from painleve_sym.automata.model import FLIGHT, INDENTED, MOTION, StateRow
from painleve_sym.automata.scales import Numbers, Terms, compliant_scales, rigid_scales
from painleve_sym.errors import EventKind
from painleve_sym.laws.catalogue import OwnLaw
from painleve_sym.laws.compliance import ramp
from painleve_sym.mechanics.contact import Contact

AT_REST = sp.Rational(1, 10**6)
"""Of the terms of v̇_t: what a contact that sticks may keep of it."""

RELEASED = sp.Rational(1, 10**10)
"""Of W_nn and the forces: acceleration of a contact that others no longer hold."""

_DENORMAL = sp.Float("1e-300")
"""Accelerations below it have no digits; m/s²."""

FLIGHTS = (FLIGHT, INDENTED)
"""Local modes without force."""
RUBBING = ("slip_neg", "stick", "slip_pos")
"""Closed local modes, in the order of the sign of slip."""

SLIP_STARTS = {-1: "slip_start_neg", 1: "slip_start_pos"}
"""Labels of the ends of stick, by the slip that begins."""

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
    def deflection(self) -> sp.Symbol:
        """State ζ of its tangential spring, the deflection from that of slip; m."""
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
class Interface(ABC):
    """One contact among several, with its states.

    `target` is the mode that follows an event which its contact problem must answer.
    """

    row: ContactRow
    target: str
    law: OwnLaw

    @property
    def name(self) -> str:
        """Name of the contact."""
        return self.row.contact.name

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

    # ---- the start of a run ----

    @property
    def states(self) -> tuple[sp.Symbol, ...]:
        """States of its own beside its row."""
        return ()

    def start_faults(
        self, gap: sp.Expr, rate: sp.Expr, near: sp.Expr, slow: sp.Expr
    ) -> list[Boolean]:
        """Return where a start is not admitted; up to `near` and `slow` it counts as closed."""
        return []

    @property
    def loading_curve(self) -> tuple[sp.Expr, sp.Expr] | None:
        """K and n of K δⁿ where its law is one that yields."""
        return (self.law.stiffness, self.law.exponent) if self.law.is_compliant else None

    def scales(self, numbers: Numbers, terms: Terms) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J)."""
        curve = self.loading_curve
        if curve is None:
            return rigid_scales(numbers, terms)
        return compliant_scales(numbers, self.row.gap, *curve, terms)

    def scales_of_states(self, gap: sp.Expr, terms: Terms) -> Memory:
        """Return the scales of `states`, by that of the gap."""
        return {}

    # ---- friction and normal force ----

    @property
    def side(self) -> sp.Expr:
        """Sign of the normal force that it may carry."""
        return _ONE

    @property
    def static_coefficient(self) -> sp.Expr:
        """Coefficient of friction up to which it sticks."""
        return self.row.contact.friction

    @property
    def unresolved_friction(self) -> sp.Expr:
        """Friction that is rounding beside the forces of the contact, which stick bears; N."""
        return _ZERO

    def capacity(self, normal_force: sp.Expr) -> sp.Expr:
        """Return the friction that stick bears under a normal force; N."""
        return self.static_coefficient * self.side * normal_force + self.unresolved_friction

    @property
    def kinetic_coefficient(self) -> sp.Expr:
        """Coefficient of friction in slip, a function of its slip velocity."""
        return self.row.contact.friction

    @property
    @abstractmethod
    def closed(self) -> sp.Expr:
        """1 where it may carry force, else 0."""

    @property
    def holds(self) -> sp.Expr:
        """1 where its friction keeps v̇_t = 0, else 0, as always without friction."""
        return self._sticks_alone * sp.sign(self.static_coefficient)

    @property
    def still(self) -> sp.Expr:
        """1 where v̇_t = 0: where it holds, or others hold it with its friction at its bound."""
        return self.holds + self.sticks * self.sign**2

    @property
    def _sticks_alone(self) -> sp.Expr:
        """1 where it sticks within its cone, else 0."""
        return self.sticks * (1 - self.sign**2)

    @property
    def apart(self) -> sp.Expr:
        """1 where its gap may change, else 0."""
        return _ONE

    def known_friction(self, normal_force: sp.Expr) -> sp.Expr:
        """Return F_t per normal force where its friction does not keep v̇_t = 0; N."""
        return -self.kinetic_coefficient * self.side * self.sign * normal_force

    @property
    def spring_force(self) -> sp.Expr:
        """Part of F_t that no normal force determines; N."""
        return _ZERO

    def rates(self, motion: ContactMotion) -> dict[sp.Symbol, sp.Expr]:
        """Return the rates of states of its own beside its row."""
        return {}

    def rubbing_velocity(self, motion: ContactMotion) -> sp.Expr:
        """Return the velocity at which friction slips; m/s."""
        return self.row.slip

    @property
    def outputs(self) -> dict[str, sp.Expr]:
        """Outputs of its own."""
        return {}

    def resolved(self, normal_force: sp.Expr, total: sp.Expr) -> sp.Expr:
        """Return the normal force by which is decided what follows; N.

        A contact that closes has F_n = 0 and bears no friction. Where no other contact bears
        force, it is F_n a moment later, as its friction grows together with its normal force.

        Parameters
        ----------
        normal_force : sympy.Expr
            F_n; N.
        total : sympy.Expr
            Sum of the sizes of all normal forces; N.
        """
        return normal_force

    @property
    def given_force(self) -> sp.Expr | None:
        """F_n where a law gives it; None where it keeps g̈_N = 0."""
        return None

    @property
    def stored_energy(self) -> sp.Expr:
        """Energy that the contact can still return; J."""
        return _ZERO

    @property
    def dissipated_power(self) -> sp.Expr:
        """Power lost in its normal motion; W."""
        return _ZERO

    @property
    @abstractmethod
    def memory(self) -> tuple[sp.Symbol, ...]:
        """All memory of the contact; the first entry is `local`."""

    @property
    @abstractmethod
    def local_modes(self) -> tuple[str, ...]:
        """Names of the local modes."""

    @property
    @abstractmethod
    def part(self) -> Part:
        """Its alternatives where a transition chooses."""

    @property
    def variants(self) -> tuple[Memory, ...]:
        """Memory for which functions of their own are generated: slip, whose sign is open, stick.

        See `Part`.
        """
        return {self.sticks: _ZERO}, {self.sticks: _ONE, self.sign: _ZERO}

    @abstractmethod
    def start(self, motion: ContactMotion) -> Memory:
        """Return its memory at the start of a motion."""

    @abstractmethod
    def transitions(self, motion: ContactMotion) -> list[Transition]:
        """Return the transitions of the contact, friction first."""

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return what must not be negative for its local mode to follow a decision."""
        at_rest = self.sign * (1 - self.sticks) * zero_factor(self.row.slip)
        at_bound = self.sticks * self.sign**2
        # A contact that can bear nothing does not stick. Nothing but 0 is known of one that does,
        # so that no change of a vanishing scale decides.
        moving = sp.Abs(motion.tangential_acceleration)
        beyond = sp.Min(AT_REST * motion.tangential_scale + _DENORMAL - moving, 0)
        return [
            *(
                Test(self._sticks_alone * m, motion.force_scale)
                for m in self._margins(motion).values()
            ),
            switched_test(
                at_rest, motion.tangential_acceleration, motion.tangential_scale, TestRole.BEGINS
            ),
            switched_test(
                at_bound, motion.tangential_acceleration, motion.tangential_scale, TestRole.VANISHES
            ),
            Test(self._sticks_alone * beyond, motion.tangential_scale),
        ]

    # ---- shared pieces ----

    @property
    def _leaving(self) -> tuple[str, ...]:
        """Guards that leave 0 after a choice: of a slip that begins, of a gap that opens."""
        return f"slip_stop:{self.name}", f"touchdown:{self.name}"

    def _transition(
        self,
        label: str,
        kind: EventKind,
        guard: sp.Expr,
        reset: Memory | None = None,
        *,
        asks: bool = True,
        departs: tuple[str, ...] = (),
    ) -> Transition:
        """Return a transition of this contact; `asks` where its contact problem must answer."""
        follows = (Choice(self.target if asks else MOTION, departs=departs),)
        chooses = asks and self.target == MOTION
        name, label = self.name, f"{label}:{self.name}"
        return Transition(label, kind, guard, follows, reset or {}, contact=name, chooses=chooses)

    def _rubbing(self, local: int, sign: int) -> Memory:
        """Return the memory of slip along a sign, or of stick for 0, under an index."""
        stick = _ZERO if sign else _ONE
        return {self.local: sp.Integer(local), self.sign: sp.Integer(sign), self.sticks: stick}

    def _rests(self, condition: Boolean, stick: Memory, slips: dict[int, int]) -> list[Alternative]:
        """Return stick with its friction at a bound for slips, given by sign and index."""
        return [
            Alternative(condition, stick | {self.sign: sp.Integer(sign)}, rest_of=i)
            for sign, i in slips.items()
        ]

    def _ends_of_rest(self, motion: ContactMotion, touches: sp.Expr = _ZERO) -> Transition:
        """Return what ends rest at a bound: the others no longer hold the contact."""
        rubs = self.sticks * self.sign**2
        least = (RELEASED * motion.normal_mobility) ** 2 * motion.force_square
        guard = rubs * (least - motion.tangential_acceleration**2)
        guard += touches * (least - motion.normal_acceleration**2)
        return self._transition("released", EventKind.SLIP_START, guard)

    @property
    def _released(self) -> Memory:
        """Change of memory where sticking reaches its cone."""
        return {}

    def _margins(self, motion: ContactMotion) -> dict[int, sp.Expr]:
        return cone_margins(self.capacity(motion.normal_force), motion.tangential_force)

    def _friction_changes(self, motion: ContactMotion) -> list[Transition]:
        kind, margins = EventKind.SLIP_START, self._margins(motion)
        changes = [
            self._transition(SLIP_STARTS[s], kind, self._sticks_alone * margin, self._released)
            for s, margin in margins.items()
        ]
        still, guard = {self.row.slip: _ZERO}, self.sign * (1 - self.sticks) * self.row.slip
        return [*changes, self._transition("slip_stop", EventKind.SLIP_STOP, guard, still)]


def cone_margins(limit: sp.Expr, friction: sp.Expr) -> dict[int, sp.Expr]:
    """Return the distances of friction F_t from what the contact can bear, the limit μ |F_n|; N.

    Keys are the directions of the slip that begins where the distance falls to 0.
    """
    return {-1: limit - friction, 1: limit + friction}


def switched_test(factor: sp.Expr, value: sp.Expr, scale: sp.Expr, role: TestRole) -> Test:
    """Return the test of factor · value, which says nothing where the factor is 0."""
    return Test(factor * value, factor**2 * scale, role)


def zero_factor(expr: sp.Expr) -> sp.Expr:
    """Return 1 where the expression is exactly 0, else 0."""
    return 1 - sp.sign(sp.Abs(expr))


def not_negative(expr: sp.Expr) -> Boolean:
    """Return expr >= 0, unevaluated."""
    return sp.Ge(expr, 0, evaluate=False)


def switched(flag: sp.Expr, expr: sp.Expr) -> sp.Expr:
    """Return the expression where the flag is 1, and 0, with all its derivatives, where it is 0.

    A guard that stays 0 never fires. Ramps inside keep their base at 0.
    """
    return flag * sp.sympify(expr).replace(
        lambda e: isinstance(e, ramp), lambda e: ramp(flag * e.args[0], evaluate=False)
    )
