"""A rigid contact that can open: one of several, and the automaton of an only one.

Between impacts the contact problem of the accelerations holds. An impact of the only contact is a
chain of instantaneous modes, one per straight ray in the space of impulses (Routh's construction),
or one mode by the final slip (Moreau).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.automata.automaton import (
    Accumulation,
    Alternative,
    Choice,
    HybridAutomaton,
    Mode,
    Part,
    Test,
    TestRole,
    Transition,
    all_positive,
    is_zero,
    positive,
)
from painleve_sym.automata.contact_forces import ContactMotion, Forces, Known, LocalMode, Memory
from painleve_sym.automata.contact_states import OneContact
from painleve_sym.automata.final_slip import FinalSlip
from painleve_sym.automata.impact_rays import APPROACH, MEMORY, RATE_ROUNDING, ImpactRays
from painleve_sym.automata.interfaces import (
    RUBBING,
    ContactStart,
    Interface,
    not_negative,
    switched_test,
    zero_factor,
)
from painleve_sym.automata.model import CONTACT, CONTACTS, FLIGHT, SLIPS
from painleve_sym.choices import ImpactFriction
from painleve_sym.errors import EventKind
from painleve_sym.laws.restitution import restitution_law
from painleve_sym.mechanics.impact.impulse_rays import raw
from painleve_sym.mechanics.paradox.singular_point import SingularPoint

DECISION = "contact"
"""The instantaneous mode in which a closed contact finds its solution."""

JAMMED = "jammed"
"""The instantaneous mode of a wedged contact, whose force grows without end."""

_ZERO, _ONE = sp.Integer(0), sp.Integer(1)


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

    @property
    def start(self) -> ContactStart:
        """It does not start inside the surface."""
        return ContactStart(self.row)

    @property
    def alone(self) -> sp.Expr:
        """1 where it sticks within its cone, else 0, as where it touches without force."""
        return self.closed * super().alone

    @property
    def _touches(self) -> sp.Expr:
        """1 where it touches without force, as others hold it, else 0."""
        return (1 - self.closed) * self.sticks

    @cached_property
    def forces(self) -> Forces:
        """Zero in flight and at a touch without force, else the reaction that keeps g̈_N = 0."""
        zero, flies = Known.ZERO, (1 - self.closed) * (1 - self.sticks)
        open_modes = (
            LocalMode(flies, zero, zero, gap_moves=True, slip_moves=True),
            LocalMode(self._touches, zero, zero, gap_moves=False, slip_moves=True),
        )
        return Forces(self, self._table(open_modes, self.closed, Known.UNKNOWN))

    def _closed(self, sign: int) -> Memory:
        return self._rubbing(2 + sign, sign) | {self.closed: _ONE}

    @property
    def _flight(self) -> Memory:
        return dict.fromkeys(self.memory, _ZERO)

    def begin(self, motion: ContactMotion) -> Memory:
        """Return the memory of flight: the decision at the start finds what is closed."""
        return self._flight

    @cached_property
    def part(self) -> Part:
        """Open where it has left or may leave; closed where gap and gap rate are 0."""
        row = self.row
        apart = sp.Or(positive(row.gap), sp.And(is_zero(row.gap), not_negative(row.gap_rate)))
        together = sp.And(is_zero(row.gap), is_zero(row.gap_rate))
        open_ = Alternative(apart, self._flight, open=True)
        still = sp.And(together, is_zero(row.slip))
        may_stick, prefers = self.may_stick(still, 1 - self.closed), not self.is_coulomb
        closed = [Alternative(may_stick, self._closed(0), preferred=prefers)]
        closed += [
            Alternative(sp.And(together, not_negative(s * row.slip)), self._closed(s))
            for s in (-1, 1)
        ]
        touches = self._flight | {self.sticks: _ONE}
        rests = Alternative(together, touches, open=True, rest_of=0)
        alternatives = (open_, *closed, rests, *self._rests(still, self._closed(0), {-1: 2, 1: 3}))
        variants = self._flight, *(rubs | {self.closed: _ONE} for rubs in self._rubbing_variants)
        rest, leaving = (row.slip,), self.watch.leaving
        return self._part(alternatives=alternatives, rest=rest, leaving=leaving, variants=variants)

    def transitions(self, motion: ContactMotion) -> list[Transition]:
        """Return slip start and stop, touchdown and lift-off."""
        gap, force, enter = self.row.gap, motion.normal_force, self.watch.transition
        land = enter("touchdown", EventKind.TOUCHDOWN, self.forces.apart * gap, {gap: _ZERO})
        leave = enter("liftoff", EventKind.LIFTOFF, self.closed * force)
        end = self.watch.end_of_rest(motion, self._touches)
        return [*self.watch.friction_changes(motion), land, leave, end]

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return F_n, the friction cone, and the onsets of slip and of lift-off."""
        leaving = self.forces.apart * zero_factor(self.row.gap) * zero_factor(self.row.gap_rate)
        a_n, scale = motion.normal_acceleration, motion.normal_scale
        return [
            Test(self.closed * motion.normal_force, motion.force_scale),
            switched_test(leaving, a_n, scale, TestRole.BEGINS),
            switched_test(self._touches, a_n, scale, TestRole.VANISHES),
            *self.watch.tests(motion),
        ]


@dataclass(frozen=True)
class RigidContact(OneContact):
    """Builds the automaton: flight, slip ±, stick, a decision, and the rays of an impact.

    References
    ----------
    Génot & Brogliato (1999); Champneys & Várkonyi (2016).
    """

    @cached_property
    def interface(self) -> RigidInterface:
        """The contact: where a run may start, and its scales."""
        return RigidInterface(self.rows[0], CONTACT, self.model.rigid_law)

    @cached_property
    def rays(self) -> ImpactRays | FinalSlip:
        """Modes of an impact."""
        given = self.model.rigid_law
        by_final_slip = given.impact_friction is ImpactFriction.FINAL_SLIP
        modes = FinalSlip if by_final_slip else ImpactRays
        return modes(self, restitution_law(given.restitution))

    @cached_property
    def singular_points(self) -> dict[int, SingularPoint]:
        """The singular point A = B = 0 of slip in each direction."""
        return {s: SingularPoint(self.mechanism.coefficients, s, raw) for s in (-1, 1)}

    # ---- the contact problem of the accelerations ----

    def _sliding_choices(self, slip: int) -> tuple[Choice, ...]:
        c, name = self.coefficients, SLIPS[slip]
        moving, A, B = slip * self.slip, self.A(slip), c.B
        several = {"liftoff": FLIGHT, "slip": f"{name}_unstable", "impact": self.rays.first(name)}
        return (
            Choice(name, all_positive(moving, A - RATE_ROUNDING * c.W_nn, -B)),
            Choice(self.rays.first(name), all_positive(moving, -B)),  # A <= 0 is left: A = 0 too
            Choice(several[self.model.rigid_law.policy], all_positive(moving, -A, B)),
        )

    def _resting_choices(self) -> tuple[Choice, ...]:
        """At v_t = 0 (to be tried after both slips): lift-off, stick, or the onset of a slip."""
        c, rest = self.coefficients, is_zero(self.slip)
        onsets = []
        for slip, name in SLIPS.items():
            for sign, target in ((1, name), (-1, f"{name}_unstable")):
                onsets.append(Choice(target, self.slip_begins(slip, sign), ("slip_stop",)))
        lift = Choice(FLIGHT, positive(c.B))
        lifts = self.model.rigid_law.policy == "liftoff"
        order = (lift, *self._sticks, *onsets) if lifts else (*self._sticks, *onsets, lift)
        if c.rank_one:
            # A wedged contact that cannot stick has no solution, and no impulse that moves it.
            order += (Choice(JAMMED, positive(-c.B)),)
        return tuple(Choice(x.target, sp.And(rest, x.condition), x.departs) for x in order)

    @cached_property
    def _sticks(self) -> tuple[Choice, ...]:
        """Sticking, where it is a solution: of a rank-one W all forces of a line are one.

        At the edge of the cone it sticks.
        """
        c, W_tt = self.coefficients, self.coefficients.W_tt
        static = self.interface.static_coefficient
        if not c.rank_one:
            friction, terms = self.tangential_force("stick", c.stick_force), sp.Abs(c.b_t)
            terms += sp.Abs(c.W_nt * c.stick_force)
            limit = static * c.stick_force + (RATE_ROUNDING * terms / W_tt if c.slides else _ZERO)
            borne = not_negative(limit - sp.Abs(friction))
            return (Choice("stick", sp.And(positive(c.stick_force), borne)),)
        # Every F_n with F_t = −(W_nt F_n + b_t)/W_tt holds v̇_t = 0; g̈_N = B′ must be 0 too. Any of
        # them is borne where the contact is wedged, else those near F_t = 0.
        still = positive(self._closed_margin)
        wedged = positive(static * W_tt - sp.Abs(c.W_nt))
        return Choice(JAMMED, sp.And(wedged, still)), Choice("stick", sp.And(positive(-c.B), still))

    @property
    def _closed_margin(self) -> sp.Expr:
        """By how much B′ of a rank-one W is less than rounding."""
        c = self.coefficients
        terms = sp.Abs(c.W_tt * c.b_n) + sp.Abs(c.W_nt * c.b_t)
        return RATE_ROUNDING * terms - sp.Abs(c.W_tt * c.B_stick)

    def _decision(self) -> Mode:
        clean = dict.fromkeys(MEMORY, _ZERO)
        start = clean | {APPROACH: self.gap_rate}
        arriving = self.transition(
            "impact", EventKind.IMPACT, self.gap_rate, self.rays.starts(), start
        )
        leaving = self.transition(
            "leave", EventKind.LIFTOFF, -self.gap_rate, (Choice(FLIGHT),), clean
        )
        solutions = (
            *self._sliding_choices(-1),
            *self._sliding_choices(1),
            *self._resting_choices(),
            Choice(FLIGHT),
        )
        reset = clean | {self.gap_rate: _ZERO}
        decide = self.transition("decide", EventKind.CONTACT, None, solutions, reset)
        return self.instant_mode(DECISION, arriving, leaving, decide)

    # ---- modes ----

    def _flight(self) -> Mode:
        closed = dict.fromkeys((self.gap, self.gap_rate, *MEMORY), _ZERO)
        land = self.transition(
            "touchdown",
            EventKind.TOUCHDOWN,
            self.gap,
            (Choice(DECISION),),
            {self.gap: _ZERO},
            on_accumulation=Accumulation(EventKind.SETTLE, DECISION, closed),
        )
        outputs = self.outputs(None, _ZERO, _ZERO)
        return Mode(FLIGHT, self.field(None, _ZERO), (land, *self.domain_ends(0)), outputs)

    def _slip(self, contact: str, unstable: bool) -> Mode:
        c, s = self.coefficients, CONTACTS[contact]
        sign = -1 if unstable else 1
        stop = self.slip_stop(s, (Choice(DECISION),))
        # Where F_n crosses zero from above: A > 0, B reaches 0 from below; A < 0, B from above.
        # Ḃ > 0 there: the gap opens, though rounding may leave B below 0 at first.
        open_ = Choice(DECISION) if unstable else Choice(FLIGHT, None, ("touchdown",))
        lift = self.transition("liftoff", EventKind.LIFTOFF, -sign * c.B, (open_,))
        meet = self.singular(sign * self.A(s))
        name = f"{contact}_unstable" if unstable else contact
        return self.held_mode(name, contact, self.slip_force(s), (stop, lift, meet))

    def _stick(self) -> Mode:
        c = self.coefficients
        if c.rank_one:
            # Of the forces that are open it has those without friction.
            lift = self.transition("liftoff", EventKind.LIFTOFF, -c.B, (Choice(DECISION),))
            return self.held_mode("stick", "stick", -c.B / c.W_nn, (lift,))

        def enter(slip: int) -> tuple[Choice, ...]:
            # Where the force of such a slip would turn it back, only lift-off is left. Friction
            # that falls as the slip begins may leave no force, though A > 0.
            falls = () if self.interface.is_coulomb else (-c.B,)
            possible = all_positive(self.A(slip), *falls)
            return Choice(SLIPS[slip], possible, ("slip_stop",)), Choice(FLIGHT)

        changes = self.slip_starts(self.stick_margins(c.stick_force), enter)
        lift = self.transition("liftoff", EventKind.LIFTOFF, c.stick_force, (Choice(DECISION),))
        return self.held_mode("stick", "stick", c.stick_force, (*changes, lift))

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton, validated; modes that cannot be reached under the policy are left out."""
        modes = [self._flight(), self._decision(), self._stick()]
        if self.coefficients.rank_one:
            modes.append(self.instant_mode(JAMMED, self.jam()))
        modes += [self._slip(n, u) for n in SLIPS.values() for u in (False, True)]
        modes += self.rays.modes(DECISION)
        starts = (Choice(FLIGHT, positive(self.gap)), Choice(DECISION))
        title = f", rigid, {self.model.rigid_law.restitution} restitution"
        return self.automaton_of(title, modes, starts, memory=MEMORY)
