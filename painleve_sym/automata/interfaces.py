"""Contacts as parts of a motion with several contacts: their local modes as data.

An `Interface` has the memory of one contact: its branch, the sign of its slip, whether it sticks.
By it are switched its `Forces`, and the transitions and tests of its `Watch`; `ContactStart` says
what holds at the start of a run.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp
from sympy.logic.boolalg import Boolean

from painleve_sym.automata.automaton import Alternative, Choice, Part, Test, TestRole, Transition
from painleve_sym.automata.contact_forces import (
    ContactMotion,
    ContactRow,
    Forces,
    Known,
    LocalContact,
    LocalMode,
    Memory,
)
from painleve_sym.automata.model import FLIGHT, INDENTED, MOTION
from painleve_sym.automata.scales import Numbers, Terms, compliant_scales, rigid_scales
from painleve_sym.errors import EventKind
from painleve_sym.laws.compliance import ramp

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


@dataclass(frozen=True)
class ContactStart:
    """The start of a run: the states that a contact does not admit, and the scales of all.

    `guide` where it must be closed; `loading_curve` has K and n of the force K δⁿ of a contact
    that yields, `tangential_stiffness` k_t of its spring, N/m.
    """

    row: ContactRow
    guide: bool = False
    loading_curve: tuple[sp.Expr, sp.Expr] | None = None
    tangential_stiffness: sp.Expr | None = None

    @property
    def states(self) -> tuple[sp.Symbol, ...]:
        """States of its own beside its row."""
        return () if self.tangential_stiffness is None else (self.row.deflection,)

    def faults(self, gap: sp.Expr, rate: sp.Expr, near: sp.Expr, slow: sp.Expr) -> list[Boolean]:
        """Return conditions that reject a start; up to `near` and `slow` it counts as closed."""
        if self.guide:
            return [sp.Gt(sp.Abs(gap), near), sp.Gt(sp.Abs(rate), slow)]
        return [] if self.loading_curve else [sp.Lt(gap, 0)]

    def scales(self, numbers: Numbers, terms: Terms) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J)."""
        if self.loading_curve is None:
            return rigid_scales(numbers, terms)
        return compliant_scales(numbers, self.row.gap, *self.loading_curve, terms)

    def scales_of_states(self, gap: sp.Expr, terms: Terms) -> Memory:
        """Return the scales of `states`: deflections under the force at the scale of the gap; m."""
        if self.tangential_stiffness is None or self.loading_curve is None:
            return {}
        stiffness, exponent = self.loading_curve
        load = terms("load", stiffness * gap**exponent)
        return {self.row.deflection: load / self.tangential_stiffness}


@dataclass(frozen=True)
class Watch:
    """Transitions of one contact, and the tests of its friction."""

    contact: LocalContact
    forces: Forces

    @property
    def leaving(self) -> tuple[str, ...]:
        """Guards that leave 0 after a choice: of a slip that begins, of a gap that opens."""
        return tuple(f"{label}:{self.contact.row.name}" for label in ("slip_stop", "touchdown"))

    @property
    def _slides(self) -> sp.Expr:
        """The sign of slip where it slips, else 0."""
        return self.contact.sign * (1 - self.contact.sticks)

    def transition(
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
        name, target = self.contact.row.name, self.contact.target
        follows, label = (Choice(target if asks else MOTION, departs=departs),), f"{label}:{name}"
        chooses = asks and target == MOTION
        return Transition(label, kind, guard, follows, reset or {}, contact=name, chooses=chooses)

    def friction_changes(self, motion: ContactMotion) -> list[Transition]:
        """Return the starts of slip, where sticking reaches its cone, and its stop."""
        kind, row = EventKind.SLIP_START, self.contact.row
        released = self.contact.released
        changes = [
            self.transition(SLIP_STARTS[s], kind, self.contact.alone * margin, released)
            for s, margin in self._margins(motion).items()
        ]
        still, guard = {row.slip: _ZERO}, self._slides * row.slip
        return [*changes, self.transition("slip_stop", EventKind.SLIP_STOP, guard, still)]

    def end_of_rest(self, motion: ContactMotion, touches: sp.Expr = _ZERO) -> Transition:
        """Return the end of rest at a bound: the others no longer hold the contact.

        `touches` is 1 where it rests without force.
        """
        least = (RELEASED * motion.normal_mobility) ** 2 * motion.force_square
        guard = self.contact.at_bound * (least - motion.tangential_acceleration**2)
        guard += touches * (least - motion.normal_acceleration**2)
        return self.transition("released", EventKind.SLIP_START, guard)

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return the inequalities of stick and of a beginning slip after a decision."""
        v_dot, scale = motion.tangential_acceleration, motion.tangential_scale
        at_rest = self._slides * zero_factor(self.contact.row.slip)
        # A contact that can bear nothing does not stick. Nothing but 0 is known of one that does,
        # so that no change of a vanishing scale decides.
        beyond = sp.Min(AT_REST * scale + _DENORMAL - sp.Abs(v_dot), 0)
        return [
            *(
                Test(self.contact.alone * m, motion.force_scale)
                for m in self._margins(motion).values()
            ),
            switched_test(at_rest, v_dot, scale, TestRole.BEGINS),
            switched_test(self.contact.at_bound, v_dot, scale, TestRole.VANISHES),
            Test(self.contact.alone * beyond, scale),
        ]

    def _margins(self, motion: ContactMotion) -> dict[int, sp.Expr]:
        return cone_margins(self.forces.capacity(motion.normal_force), motion.tangential_force)


@dataclass(frozen=True)
class Interface(LocalContact, ABC):
    """One contact among several: its memory, its local modes and its alternatives."""

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
    def start(self) -> ContactStart:
        """Admitted states at the start of a run, and their scales."""

    @property
    @abstractmethod
    def forces(self) -> Forces:
        """Its forces in all local modes."""

    @cached_property
    def watch(self) -> Watch:
        """Its transitions, and the tests of its friction."""
        return Watch(self, self.forces)

    @property
    @abstractmethod
    def part(self) -> Part:
        """Its alternatives where a transition chooses."""

    @abstractmethod
    def begin(self, motion: ContactMotion) -> Memory:
        """Return its memory at the start of a motion."""

    @abstractmethod
    def transitions(self, motion: ContactMotion) -> list[Transition]:
        """Return the transitions of the contact."""

    @abstractmethod
    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return the inequalities of its local mode after a decision."""

    # ---- shared by kinds ----

    def _table(
        self, open_modes: Sequence[LocalMode], closed: sp.Expr, normal: Known
    ) -> tuple[LocalMode, ...]:
        """Return the table of a contact with Coulomb friction; `closed` is 1 where it has any.

        The gap moves where a law gives F_n. Without friction it slips where it would stick.
        """
        stick = self.alone * sp.sign(self.static_coefficient)
        slip, moves = closed - stick - self.at_bound, normal is Known.GIVEN
        return (
            *open_modes,
            LocalMode(slip, normal, Known.GIVEN, gap_moves=moves, slip_moves=True),
            LocalMode(stick, normal, Known.UNKNOWN, gap_moves=moves, slip_moves=False),
            LocalMode(self.at_bound, normal, Known.GIVEN, gap_moves=moves, slip_moves=False),
        )

    @property
    def _rubbing_variants(self) -> tuple[Memory, Memory]:
        """Memory of slip, whose sign is open, and of stick; see `Part.variants`."""
        return {self.sticks: _ZERO}, {self.sticks: _ONE, self.sign: _ZERO}

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

    def _part(self, **choices: Any) -> Part:
        """Return the part with these alternatives, variants and labels; see `Part`."""
        name, modes = self.row.name, self.local_modes
        return Part(name=name, memory=self.memory, local_modes=modes, **choices)


def cone_margins(limit: sp.Expr, friction: sp.Expr) -> dict[int, sp.Expr]:
    """Return the margins of friction F_t to the edges of the cone, the limit μ |F_n|; N.

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
