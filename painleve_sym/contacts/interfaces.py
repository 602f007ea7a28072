"""Contacts as parts of a motion with several contacts: their local modes as data.

Each interface holds the memory of one contact (which branch it is in, the sign of its slip, whether
it sticks), by which forces are put together, the transitions that change it, and the inequalities
that its local modes must satisfy.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import sympy as sp
from sympy.logic.boolalg import Boolean

from painleve_sym.contacts.contact_states import CONTACT_WORK, ContactRow, cone_margins
from painleve_sym.contacts.model import FLIGHT, INDENTED, MOTION, SLIPS
from painleve_sym.errors import EventKind
from painleve_sym.hybrid.automaton import (
    Alternative,
    Choice,
    Part,
    Test,
    Transition,
    is_zero,
    positive,
)
from painleve_sym.laws.compliance import DELTA, DELTA_DOT, SEPARATED, Branch, Exit, ramp
from painleve_sym.laws.contact_law import ContactLaw

AT_REST = sp.Rational(1, 10**6)
"""Of the terms of v̇_t: what a contact that sticks may keep of it."""

_DENORMAL = sp.Float("1e-300")
"""Accelerations below it have no digits; m/s²."""

FLIGHTS = (FLIGHT, INDENTED)
"""Local modes without force."""
RUBBING = ("slip_neg", "stick", "slip_pos")
"""Closed local modes, in the order of the sign of slip."""

_ZERO, _ONE = sp.Integer(0), sp.Integer(1)

Memory = dict[sp.Symbol, sp.Expr]


@dataclass(frozen=True)
class ContactMotion:
    """Forces and accelerations of a contact, as symbols or expressions of the automaton.

    Attributes
    ----------
    normal_force, tangential_force : sympy.Expr
        N.
    normal_acceleration, tangential_acceleration : sympy.Expr
        m/s².
    force_scale : sympy.Expr
        Size of the forces, for what counts as rounding; N.
    normal_scale, tangential_scale : sympy.Expr
        Sum of the sizes of the terms of each acceleration; m/s².
    """

    normal_force: sp.Expr
    tangential_force: sp.Expr
    normal_acceleration: sp.Expr
    tangential_acceleration: sp.Expr
    force_scale: sp.Expr
    normal_scale: sp.Expr
    tangential_scale: sp.Expr


@dataclass(frozen=True)
class Interface(ABC):
    """One contact among several.

    Parameters
    ----------
    row : ContactRow
        Its states.
    target : str
        Mode that follows an event which its contact problem must answer.
    """

    row: ContactRow
    target: str

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

    @property
    def side(self) -> sp.Expr:
        """Sign of the normal force that it may carry."""
        return _ONE

    @property
    def static_coefficient(self) -> sp.Expr:
        """Coefficient of friction up to which it sticks."""
        return self.row.contact.friction

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
        """1 where its friction keeps v̇_t = 0, else 0."""
        return self.sticks

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

    @abstractmethod
    def start(self) -> Memory:
        """Return its memory at the start of a motion."""

    @abstractmethod
    def transitions(self, motion: ContactMotion) -> list[Transition]:
        """Return the transitions of the contact, friction first."""

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return what must not be negative for its local mode to follow a decision."""
        at_rest = self.sign * zero_factor(self.row.slip)
        # A contact that can bear nothing does not stick.
        moving = sp.Abs(motion.tangential_acceleration)
        slack = AT_REST * motion.tangential_scale + _DENORMAL
        return [
            *(Test(self.sticks * m, motion.force_scale) for m in self._margins(motion).values()),
            Test(at_rest * motion.tangential_acceleration, motion.tangential_scale),
            Test(self.sticks * (slack - moving), motion.tangential_scale),
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

    @property
    def _released(self) -> Memory:
        """Change of memory where sticking reaches its cone."""
        return {}

    def _margins(self, motion: ContactMotion) -> dict[int, sp.Expr]:
        limit = self.static_coefficient * self.side * motion.normal_force
        return cone_margins(limit, motion.tangential_force)

    def _friction_changes(self, motion: ContactMotion) -> list[Transition]:
        changes = [
            self._transition(label, EventKind.SLIP_START, self.sticks * margin, self._released)
            for label, margin in zip(
                ("slip_start_neg", "slip_start_pos"), self._margins(motion).values(), strict=True
            )
        ]
        still, guard = {self.row.slip: _ZERO}, self.sign * self.row.slip
        return [*changes, self._transition("slip_stop", EventKind.SLIP_STOP, guard, still)]


@dataclass(frozen=True)
class RigidInterface(Interface):
    """A rigid contact that can open: F_n ≥ 0, g_N ≥ 0."""

    @cached_property
    def closed(self) -> sp.Symbol:
        """1 where g̈_N = 0 is kept, else 0."""
        return self._symbol("closed")

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """Local mode, sign of slip, sticking, closed."""
        return self.local, self.sign, self.sticks, self.closed

    @property
    def local_modes(self) -> tuple[str, ...]:
        """Flight, slip to either side, stick."""
        return FLIGHT, *RUBBING

    def _closed(self, sign: int) -> Memory:
        return {
            self.local: sp.Integer(2 + sign),
            self.sign: sp.Integer(sign),
            self.sticks: sp.Integer(0 if sign else 1),
            self.closed: _ONE,
        }

    def start(self) -> Memory:
        """Return the memory of flight: the decision at the start finds what is closed."""
        return dict.fromkeys(self.memory, _ZERO)

    @cached_property
    def part(self) -> Part:
        """Open where it has left or may leave; closed where gap and gap rate are 0."""
        row = self.row
        apart = sp.Or(positive(row.gap), sp.And(is_zero(row.gap), _not_negative(row.gap_rate)))
        together = sp.And(is_zero(row.gap), is_zero(row.gap_rate))
        open_ = Alternative(apart, self.start(), open=True)
        closed = [
            Alternative(
                sp.And(together, is_zero(row.slip) if s == 0 else _not_negative(s * row.slip)),
                self._closed(s),
            )
            for s in (0, -1, 1)
        ]
        return Part(
            self.name, self.memory, self.local_modes, (open_, *closed), (row.slip,), self._leaving
        )

    def transitions(self, motion: ContactMotion) -> list[Transition]:
        """Return slip start and stop, touchdown and lift-off."""
        gap, kind = self.row.gap, EventKind.TOUCHDOWN
        land = self._transition("touchdown", kind, (1 - self.closed) * gap, {gap: _ZERO})
        leave = self._transition("liftoff", EventKind.LIFTOFF, self.closed * motion.normal_force)
        return [*self._friction_changes(motion), land, leave]

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return F_n, the friction cone, and the onsets of slip and of lift-off."""
        leaving = (1 - self.closed) * zero_factor(self.row.gap) * zero_factor(self.row.gap_rate)
        return [
            Test(self.closed * motion.normal_force, motion.force_scale),
            Test(leaving * motion.normal_acceleration, motion.normal_scale),
            *super().tests(motion),
        ]


@dataclass(frozen=True)
class GuideInterface(Interface):
    """A rigid contact that holds from both sides: g_N = 0, F_n of either sign."""

    @cached_property
    def side(self) -> sp.Symbol:
        """Sign of F_n."""
        return self._symbol("side")

    @property
    def closed(self) -> sp.Expr:
        """It never opens."""
        return _ONE

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """Local mode, sign of slip, sticking, side."""
        return self.local, self.sign, self.sticks, self.side

    @property
    def local_modes(self) -> tuple[str, ...]:
        """Slip to either side and stick, each with either sign of F_n."""
        return tuple(f"{slip}/{side}" for side in ("pull", "push") for slip in RUBBING)

    def _held(self, sign: int, side: int) -> Memory:
        return {
            self.local: sp.Integer(len(RUBBING) * (side > 0) + 1 + sign),
            self.sign: sp.Integer(sign),
            self.sticks: sp.Integer(0 if sign else 1),
            self.side: sp.Integer(side),
        }

    def start(self) -> Memory:
        """Return some memory: the decision at the start finds the right one."""
        return self._held(0, 1)

    @cached_property
    def part(self) -> Part:
        """Stick, or slip along v_t, with either sign of F_n."""
        slip = self.row.slip
        offered = [
            Alternative(is_zero(slip) if s == 0 else _not_negative(s * slip), self._held(s, side))
            for s in (0, -1, 1)
            for side in (1, -1)
        ]
        return Part(
            self.name, self.memory, self.local_modes, tuple(offered), (slip,), self._leaving
        )

    def transitions(self, motion: ContactMotion) -> list[Transition]:
        """Return slip start and stop, and the reversal of the normal force."""
        guard = self.side * motion.normal_force
        turn = self._transition("force_reversal", EventKind.FORCE_REVERSAL, guard)
        return [*self._friction_changes(motion), turn]

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return the sign of F_n, the friction cone, and the onset of slip."""
        own = Test(self.side * motion.normal_force, motion.force_scale)
        return [own, *super().tests(motion)]


@dataclass(frozen=True)
class BranchChange:
    """Passage of a contact from one branch of its law, or a flight, to another.

    Attributes
    ----------
    label : str
        Unique among those with the same source.
    kind : EventKind
    source, target : str
        Name of a branch, or one of `FLIGHTS`.
    guard : sympy.Expr
        Crosses from + to −.
    reset : mapping of symbol to sympy.Expr
        Of the law's memory, and of the energy that it takes: what the stored energy jumps by is
        nothing where the force is continuous, a loss where a stretched dashpot lets go, a gain
        under the virgin reload rule.
    """

    label: str
    kind: EventKind
    source: str
    target: str
    guard: sp.Expr
    reset: Memory

    @property
    def closes(self) -> bool:
        """Whether the force sets in."""
        return self.source in FLIGHTS and self.target not in FLIGHTS


@dataclass(frozen=True)
class CompliantInterface(Interface):
    """A contact with a force–compression law.

    Parameters
    ----------
    row, target
        As for `Interface`.
    law : ContactLaw
        In symbols of its own where the law of another contact has the same names.
    """

    law: ContactLaw

    @property
    def flights(self) -> tuple[str, ...]:
        """Its local modes without force."""
        return FLIGHTS if self.law.recontacts else FLIGHTS[:1]

    @cached_property
    def branches(self) -> tuple[str, ...]:
        """Names of the branches of the law."""
        return tuple(b.name for b in self.law.branches)

    @cached_property
    def flags(self) -> dict[str, sp.Symbol]:
        """By flight and branch: 1 in it, else 0."""
        return {name: self._symbol(f"in_{name}") for name in (*self.flights, *self.branches)}

    @cached_property
    def law_memory(self) -> dict[sp.Symbol, sp.Symbol]:
        """Memory of the law, by the law's own symbols; the same for an only contact."""
        return {s: self._symbol(s.name) if self.row.end else s for s in self.law.memory}

    @cached_property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """All memory of the contact."""
        own = (self.local, self.sign, self.sticks)
        return (*own, *self.flags.values(), *self.law_memory.values())

    @cached_property
    def local_modes(self) -> tuple[str, ...]:
        """Flights, then slips and stick in each branch."""
        return (*FLIGHTS, *(f"{s}/{b.name}" for b in self.law.branches for s in RUBBING))

    @property
    def closed(self) -> sp.Expr:
        """1 where it carries force, else 0."""
        return sp.Add(*(self.flags[name] for name in self.branches))

    def of_state(self, expr: sp.Expr) -> sp.Expr:
        """Write an expression of the law in states and memory of the automaton."""
        states = {DELTA: -self.row.gap, DELTA_DOT: -self.row.gap_rate}
        return sp.sympify(expr).xreplace(states | self.law_memory)

    def _in_branches(self, quantity: str) -> sp.Expr:
        values = [
            _where(self.flags[b.name], self.of_state(getattr(b, quantity)))
            for b in self.law.branches
        ]
        return sp.Add(*values)

    @property
    def static_coefficient(self) -> sp.Expr:
        """Coefficient of friction up to which it sticks: μ r_s."""
        return self.row.contact.friction * self.law.friction.static_ratio

    @property
    def kinetic_coefficient(self) -> sp.Expr:
        """Coefficient of friction in slip: μ r(v_t)."""
        return self.row.contact.friction * self.law.friction.kinetic_ratio(self.row.slip)

    @property
    def _released(self) -> Memory:
        """Neither stick nor slip: a contact whose sticking has just ended does not stick again.

        With a static friction above the kinetic one both may be possible.
        """
        ends = not self.law.friction.is_coulomb
        return {self.sign: _ZERO, self.sticks: _ZERO} if ends else {}

    @cached_property
    def given_force(self) -> sp.Expr:
        """F_n of the branch it is in; 0 in flight; N."""
        return self._in_branches("force")

    @cached_property
    def stored_energy(self) -> sp.Expr:
        """Energy that the contact can still return; J."""
        return self._in_branches("stored_energy")

    @cached_property
    def dissipated_power(self) -> sp.Expr:
        """Power lost in the law for good; W."""
        return self._in_branches("dissipated_power")

    # ---- entering a local mode ----

    def _in(self, place: str) -> Memory:
        return {s: _ONE if name == place else _ZERO for name, s in self.flags.items()}

    def _enter_flight(self, name: str) -> Memory:
        none = {self.sign: _ZERO, self.sticks: _ZERO}
        clean = dict.fromkeys(self.law_memory.values(), _ZERO) if name == FLIGHT else {}
        index = sp.Integer(FLIGHTS.index(name))
        return {self.local: index, **none, **self._in(name), **clean}

    def _index(self, branch: str) -> int:
        """Return the index of sticking in a branch; slip is one beside it."""
        return len(FLIGHTS) + len(RUBBING) * self.branches.index(branch) + 1

    def _enter_branch(self, branch: str) -> Memory:
        """Return the memory in a branch after a flight, slipping by the sign of v_t."""
        sign = sp.sign(self.row.slip)
        # What lands without slip may stick.
        sticks = _ZERO if self.law.friction.is_coulomb else zero_factor(self.row.slip)
        return {
            self.local: self._index(branch) + sign,
            self.sign: sign,
            self.sticks: sticks,
            **self._in(branch),
        }

    def _land(self, change: BranchChange, motion: ContactMotion) -> Memory:
        """Return the memory, and changed states, of a contact whose force sets in."""
        return self._enter_branch(change.target)

    def _rub(self, sign: sp.Expr, sticks: sp.Expr) -> Memory:
        """Return the memory in the same branch with another slip."""
        here = sp.Add(*[self.flags[name] * self._index(name) for name in self.branches])
        return {self.local: here + sign, self.sign: sign, self.sticks: sticks}

    @cached_property
    def part(self) -> Part:
        """Alternatives where contacts at rest choose: keep on, stick, or slip either way."""
        at_rest = sp.And(positive(self.closed), is_zero(self.row.slip))
        sliding = sp.And(positive(self.closed), positive(sp.Abs(self.row.slip)))
        choices = [
            Alternative(sp.Le(self.closed, 0, evaluate=False)),
            Alternative(sliding, self._rub(sp.sign(self.row.slip), _ZERO)),
        ]
        has_static = not self.law.friction.is_coulomb
        may_stick = sp.And(at_rest, positive(self.sticks + self.sign**2)) if has_static else at_rest
        choices.append(Alternative(may_stick, self._rub(_ZERO, _ONE), preferred=has_static))
        choices += [Alternative(at_rest, self._rub(sp.Integer(sign), _ZERO)) for sign in (-1, 1)]
        # Of a slip that begins only: compliant contacts open and close by their law.
        leaving = self._leaving[:1]
        return Part(
            self.name, self.memory, self.local_modes, tuple(choices), (self.row.slip,), leaving
        )

    def start(self) -> Memory:
        """Return the memory at the start: loading where the gap is negative, else open."""
        inside, outside = self._enter_branch(self.law.loading.name), self._enter_flight(FLIGHT)
        pressed = sp.Heaviside(-self.row.gap, 0)
        return {s: pressed * inside.get(s, _ZERO) + (1 - pressed) * outside[s] for s in outside}

    # ---- transitions ----

    @cached_property
    def changes(self) -> tuple[BranchChange, ...]:
        """Touchdown, exits of every branch, lift-off from an indented surface, and recontact."""
        law, row = self.law, self.row
        separated = INDENTED if law.recontacts else FLIGHT
        land = BranchChange("touchdown", EventKind.TOUCHDOWN, FLIGHT, law.loading.name, row.gap, {})
        changes = [land]
        for branch in law.branches:
            for i, e in enumerate(branch.exits):
                target = separated if e.target == SEPARATED else e.target
                changes.append(self._change(f"{e.kind}_{i}", branch.name, target, e))
        if law.recontacts:
            clean = dict.fromkeys(self.law_memory.values(), _ZERO)
            leave = BranchChange("liftoff", EventKind.LIFTOFF, INDENTED, FLIGHT, -row.gap, clean)
            changes.append(leave)
        for i, e in enumerate(law.recontacts):
            changes.append(self._change(f"recontact_{i}", INDENTED, e.target, e))
        return tuple(changes)

    def _change(self, label: str, source: str, target: str, e: Exit) -> BranchChange:
        before, after = (
            _ZERO if name in FLIGHTS else self.law.branch(name).stored_energy
            for name in (source, target)
        )
        reset = {self.law_memory[s]: self.of_state(v) for s, v in e.memory.items()}
        released = self.of_state(before - after.xreplace(dict(e.memory)))
        if released != 0:
            reset[CONTACT_WORK] = CONTACT_WORK + released
        return BranchChange(label, e.kind, source, target, self.of_state(e.guard), reset)

    def transitions(self, motion: ContactMotion) -> list[Transition]:
        """Return slip start and stop, and the changes of branch and flight."""
        return [*self._friction_changes(motion), *(self._switch(c, motion) for c in self.changes)]

    def _switch(self, change: BranchChange, motion: ContactMotion) -> Transition:
        """Return a change as one of the memory of this contact."""
        label = change.label
        if change.target in FLIGHTS:
            enter = self._enter_flight(change.target)
        elif change.closes:
            enter = self._land(change, motion)
        else:
            shift = self._index(change.target) - self._index(change.source)
            enter = {self.local: self.local + shift, **self._in(change.target)}
        if change.source not in FLIGHTS:
            label = f"{label}_{change.source}"
        guard, reset = _where(self.flags[change.source], change.guard), change.reset | enter
        return self._transition(label, change.kind, guard, reset, asks=change.closes)


@dataclass(frozen=True)
class SpringInterface(CompliantInterface):
    """A compliant contact that yields along its tangent, too: its law has `Friction.SPRING`.

    A spring of stiffness k_t is in series with Coulomb friction; its deflection is ξ, and
    F_t = −k_t ξ. In stick ξ̇ = v_t. In slip along s the force is −s μ F_n, hence ξ = s μ F_n/k_t:
    friction slips at v_t − ξ̇ = v_t − s μ Ḟ_n/k_t, and stops where that vanishes.

    The state of the contact is ζ = ξ − s μ F_n/k_t, the deflection from that of slip along s, where
    s is the last direction of slip, 0 before the first slip of a contact. Slip ends with
    ζ = ζ̇ = 0, and with ζ itself as a state round-off does not start it again. As F_t follows from
    the states, nothing is to be chosen where such a contact stops, slips or lands.

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

    @cached_property
    def last_slip(self) -> sp.Symbol:
        """Memory: s, the last direction of slip, or 0 where there was none since it closed."""
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
        """Return where a closing contact slides, by the direction of the slip.

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
    def holds(self) -> sp.Expr:
        """It holds by its deflection, not by its velocity."""
        return _ZERO

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """All memory of the contact."""
        return (*super().memory, self.last_slip)

    def known_friction(self, normal_force: sp.Expr) -> sp.Expr:
        """Return −s μ F_n, of stick and of slip; N."""
        return -self.kinetic_coefficient * self.last_slip * normal_force

    @property
    def spring_force(self) -> sp.Expr:
        """−k_t ζ; N."""
        return -self.stiffness * self.row.deflection

    @property
    def tangential_deflection(self) -> sp.Expr:
        """ξ; m."""
        return -self.known_friction(self.given_force) / self.stiffness + self.row.deflection

    @property
    def stored_energy(self) -> sp.Expr:
        """Energy that the contact can still return, with that of the spring; J."""
        return super().stored_energy + self.stiffness * self.tangential_deflection**2 / 2

    @property
    def outputs(self) -> dict[str, sp.Expr]:
        """ξ."""
        return {f"tangential_deflection{self.row.end}": self.tangential_deflection}

    def _yields(self, motion: ContactMotion) -> sp.Expr:
        """Return μ Ḟ_n/k_t; m/s."""
        rates = [
            _where(self.flags[b.name], self.limit_rate(b, motion.normal_acceleration))
            for b in self.law.branches
        ]
        return sp.Add(*rates)

    def rates(self, motion: ContactMotion) -> dict[sp.Symbol, sp.Expr]:
        """Return ζ̇."""
        velocity = self.row.slip - self.last_slip * self._yields(motion)
        return {self.row.deflection: self.sticks * velocity}

    def rubbing_velocity(self, motion: ContactMotion) -> sp.Expr:
        """Return v_t − ξ̇ of slip; m/s."""
        return self.row.slip - self.sign * self._yields(motion)

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return none: its forces follow from its state."""
        return []

    @property
    def part(self) -> Part:
        """It keeps on, whatever the others choose."""
        keeps = (Alternative(_not_negative(self.closed)),)
        return Part(self.name, self.memory, self.local_modes, keeps, leaving=self._starts)

    @property
    def _starts(self) -> tuple[str, ...]:
        return f"slip_start_neg:{self.name}", f"slip_start_pos:{self.name}"

    def _friction_changes(self, motion: ContactMotion) -> list[Transition]:
        still = {self.row.deflection: _ZERO}
        changes = [
            self._transition(
                label.partition(":")[0],
                EventKind.SLIP_START,
                self.sticks * margin,
                self._rub(sp.Integer(s), _ZERO) | {self.last_slip: sp.Integer(s)} | still,
                asks=False,
                departs=(f"slip_stop:{self.name}",),
            )
            for label, (s, margin) in zip(
                self._starts, self.slip_margins(motion.normal_force).items(), strict=True
            )
        ]
        guard, sticks = self.sign * self.rubbing_velocity(motion), self._rub(_ZERO, _ONE) | still
        stop = self._transition(
            "slip_stop", EventKind.SLIP_STOP, guard, sticks, asks=False, departs=self._starts
        )
        return [*changes, stop]

    def _enter_flight(self, name: str) -> Memory:
        return super()._enter_flight(name) | self.relaxed

    def _enter_branch(self, branch: str) -> Memory:
        """Return the memory of a loaded start: what slides has been sliding."""
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
            **self.relaxed,
            **self.landing_states(change),
            self.last_slip: sign,
        }


def zero_factor(expr: sp.Expr) -> sp.Expr:
    """Return 1 where the expression is exactly 0, else 0."""
    return 1 - sp.sign(sp.Abs(expr))


def _not_negative(expr: sp.Expr) -> Boolean:
    return sp.Ge(expr, 0, evaluate=False)


def _where(flag: sp.Expr, expr: sp.Expr) -> sp.Expr:
    """Return the expression where the flag is 1, and 0, with all its derivatives, where it is 0.

    A guard that stays 0 never fires. Ramps inside keep their base at 0.
    """
    return flag * sp.sympify(expr).replace(
        lambda e: isinstance(e, ramp), lambda e: ramp(flag * e.args[0], evaluate=False)
    )
