"""A rigid contact that holds from both sides: one of several, and the automaton of an only one.

The contact never opens. What can happen is slip either way and sticking, each with a normal force
of either sign, and the tangential impact that stops a slip where no finite force can be.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import sympy as sp

from painleve_sym.automata.automaton import (
    Alternative,
    Choice,
    HybridAutomaton,
    Mode,
    Part,
    Test,
    Transition,
    all_positive,
    is_zero,
    positive,
)
from painleve_sym.automata.contact_forces import ContactMotion, Forces, Known, Memory
from painleve_sym.automata.contact_states import FORCE_WORK, FRICTION_WORK, OneContact
from painleve_sym.automata.interfaces import RUBBING, ContactStart, Interface, not_negative
from painleve_sym.automata.model import CONTACT, SLIPS, guide_slip_mode, guide_stick_mode
from painleve_sym.automata.rigid import DECISION
from painleve_sym.errors import EventKind
from painleve_sym.mechanics.impact.impulse_rays import V_T
from painleve_sym.mechanics.outline import SIDES
from painleve_sym.mechanics.paradox.bilateral import BilateralForms

TANGENTIAL_IMPACT = "tangential_impact"
"""The instantaneous mode in which a slip without a solution stops."""

_ZERO, _ONE = sp.Integer(0), sp.Integer(1)
_SIDES = tuple(SIDES.values())


@dataclass(frozen=True)
class GuideInterface(Interface):
    """A rigid contact that holds from both sides: g_N = 0, F_n of either sign."""

    @cached_property
    def side(self) -> sp.Symbol:
        """Sign of F_n."""
        return self._symbol("side")

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """Local mode, sign of slip, sticking, side."""
        return self.local, self.sign, self.sticks, self.side

    @property
    def local_modes(self) -> tuple[str, ...]:
        """Slip to either side and stick, each with either sign of F_n."""
        return tuple(f"{slip}/{side}" for side in ("pull", "push") for slip in RUBBING)

    @property
    def start(self) -> ContactStart:
        """It starts closed."""
        return ContactStart(self.row, guide=True)

    @cached_property
    def forces(self) -> Forces:
        """Forces that keep g̈_N = 0, and friction; it never opens."""
        return Forces(self, self._table((), _ONE, Known.UNKNOWN), side=self.side)

    def _held(self, sign: int, side: int) -> Memory:
        local = len(RUBBING) * (side > 0) + 1 + sign
        return self._rubbing(local, sign) | {self.side: sp.Integer(side)}

    def begin(self, motion: ContactMotion) -> Memory:
        """Return some memory: the decision at the start finds the right one."""
        return self._held(0, 1)

    @cached_property
    def part(self) -> Part:
        """Stick, or slip along v_t, with either sign of F_n."""
        slip = self.row.slip
        rest, prefers = self.may_stick(is_zero(slip)), not self.is_coulomb
        alternatives = [
            Alternative(rest, self._held(0, side), preferred=prefers) for side in (1, -1)
        ]
        alternatives += [
            Alternative(not_negative(s * slip), self._held(s, side))
            for s in (-1, 1)
            for side in (1, -1)
        ]
        for i, side in enumerate((1, -1)):
            slips = {-1: 2 + i, 1: 4 + i}
            alternatives += self._rests(is_zero(slip), self._held(0, side), slips)
        return self._part(
            alternatives=tuple(alternatives),
            rest=(slip,),
            leaving=self.watch.leaving,
            variants=self._rubbing_variants,
        )

    def transitions(self, motion: ContactMotion) -> list[Transition]:
        """Return slip start and stop, and the reversal of the normal force."""
        guard = self.side * motion.normal_force
        turn = self.watch.transition("force_reversal", EventKind.FORCE_REVERSAL, guard)
        # First: where F_n turns, what friction can bear vanishes, too.
        return [turn, *self.watch.friction_changes(motion), self.watch.end_of_rest(motion)]

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return the sign of F_n, the friction cone, and the onset of slip."""
        own = Test(self.side * motion.normal_force, motion.force_scale)
        return [own, *self.watch.tests(motion)]


@dataclass(frozen=True)
class BilateralContact(OneContact):
    """Builds the automaton: slip ± and stick, each with either sign of F_n, and a decision.

    Where a slip has two solutions the policy decides: the one with A > 0 (there is no lift-off
    here), the one with A < 0, or the tangential impact. At v_t = 0 it sticks where that is
    possible. W has not rank one: the contact could not slip.

    References
    ----------
    Klein (1909); Génot & Brogliato (1999) and Le Xuan Anh (2003) on tangential impacts.
    """

    @cached_property
    def interface(self) -> GuideInterface:
        """The contact: where a run may start, and its scales."""
        return GuideInterface(self.rows[0], CONTACT, self.model.rigid_law)

    @cached_property
    def forms(self) -> BilateralForms:
        """Closed forms of the tangential impact."""
        return BilateralForms(self.coefficients)

    # ---- the decision ----

    def _sliding_choices(self, slip: int) -> Iterator[Choice]:
        c = self.coefficients
        moving, B = slip * self.slip, c.B
        for side in _SIDES:
            A, other = self.A(slip, side), self.A(slip, -side)
            taken = {
                "liftoff": guide_slip_mode(slip, side),
                "slip": guide_slip_mode(slip, -side, unstable=True),
                "impact": TANGENTIAL_IMPACT,
            }[self.model.rigid_law.policy]
            yield Choice(taken, all_positive(moving, A, -other, -side * B))
            yield Choice(guide_slip_mode(slip, side), all_positive(moving, A, -side * B))
        for side in _SIDES:
            # B = 0: the guard of the force decides how the motion continues.
            possible = sp.And(all_positive(moving, self.A(slip, side)), is_zero(B))
            yield Choice(guide_slip_mode(slip, side), possible)
        yield Choice(TANGENTIAL_IMPACT, positive(moving))

    def _resting_choices(self) -> Iterator[Choice]:
        """At v_t = 0 (to be tried after both slips): stick, then the onset of a slip."""
        c, stop = self.coefficients, ("slip_stop",)
        for side in _SIDES:
            margins = self.stick_margins(c.stick_force, side)
            yield Choice(guide_stick_mode(side), all_positive(*margins.values()))
        for sign, slip, side in product((1, -1), SLIPS, _SIDES):
            name = guide_slip_mode(slip, side, sign < 0)
            yield Choice(name, self.slip_begins(slip, sign, side), stop)
        for slip, side in product(SLIPS, _SIDES):
            possible = sp.And(is_zero(c.B), all_positive(slip * c.b_t, self.A(slip, side)))
            yield Choice(guide_slip_mode(slip, side), possible, stop)
        yield Choice(guide_stick_mode(1))

    def _decision(self) -> Mode:
        choices = (*self._sliding_choices(-1), *self._sliding_choices(1), *self._resting_choices())
        decide = self.transition("decide", EventKind.CONTACT, None, choices)
        return self.instant_mode(DECISION, decide)

    def _impact(self) -> Mode:
        """Stop the slip by the only impulse that keeps v_n = 0 within the friction cone."""
        forms, system = self.forms, self.mechanism.system
        now = {V_T: self.slip}
        reset = dict(zip(system.q_dot, forms.velocity_after.xreplace(now), strict=True))
        reset |= {self.slip: _ZERO, self.gap_rate: _ZERO}
        reset[FRICTION_WORK] = FRICTION_WORK + forms.friction_loss.xreplace(now)
        if FORCE_WORK in self.dissipations:
            impulses = (forms.normal_impulse, forms.tangential_impulse)
            reset[FORCE_WORK] = FORCE_WORK - self.drive_work(p.xreplace(now) for p in impulses)
        stop = self.transition(
            "stop", EventKind.TANGENTIAL_IMPACT, None, (Choice(DECISION),), reset
        )
        return self.instant_mode(TANGENTIAL_IMPACT, stop)

    # ---- modes ----

    def _slip(self, slip: int, side: int, unstable: bool) -> Mode:
        c, sign = self.coefficients, -1 if unstable else 1
        stop = self.slip_stop(slip, (Choice(DECISION),))
        # Beyond F_n = 0 the other side answers where its A is positive; else nothing does.
        over: tuple[Choice, ...] = (Choice(TANGENTIAL_IMPACT),)
        if not unstable:
            other = guide_slip_mode(slip, -side)
            over = (Choice(other, positive(self.A(slip, -side)), ("force_reversal",)), *over)
        loss = -sign * side * c.B
        turn = self.transition("force_reversal", EventKind.FORCE_REVERSAL, loss, over)
        meet, name = self.singular(sign * self.A(slip, side)), guide_slip_mode(slip, side, unstable)
        force, ends = self.slip_force(slip, side), (stop, turn, meet)
        return self.held_mode(name, SLIPS[slip], force, ends, side)

    def _stick(self, side: int) -> Mode:
        c = self.coefficients

        def enter(slip: int) -> tuple[Choice, ...]:
            # With A < 0 the slip on this side would run backwards: only the other side slips on.
            # Where friction falls as the slip begins, the force may change its side, too.
            falls = () if self.interface.is_coulomb else (-side * c.B,)
            possible, stop = all_positive(self.A(slip, side), *falls), ("slip_stop",)
            this, other = guide_slip_mode(slip, side), guide_slip_mode(slip, -side)
            return Choice(this, possible, stop), Choice(other, None, stop)

        force = c.stick_force
        changes = self.slip_starts(self.stick_margins(force, side), enter)
        every = ("force_reversal", *(change.label for change in changes))
        other = (Choice(guide_stick_mode(-side), None, every),)
        # Reached only where F_t vanishes with F_n; any other F_t begins a slip before.
        turn = self.transition("force_reversal", EventKind.FORCE_REVERSAL, side * force, other)
        return self.held_mode(guide_stick_mode(side), "stick", force, (turn, *changes))

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton, validated."""
        slips = [self._slip(*slip) for slip in product(SLIPS, _SIDES, (False, True))]
        sticks = [self._stick(side) for side in _SIDES]
        modes = (self._decision(), self._impact(), *sticks, *slips)
        return self.automaton_of(", rigid, bilateral", modes, (Choice(DECISION),), memory=())
