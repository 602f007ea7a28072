"""A compliant contact in space with constant W, b and μ: the automaton of its motion.

The slip v_t = v (cos φ, sin φ) is followed by its speed and angle,

    v' = e·a,    φ' = e⊥·a/v,    a = F_n w + b_t − μ F_n W_tt e,    e = (cos φ, sin φ),

so that slip that stops does so where v crosses 0, as in the plane. There φ' has no limit of its
own: while v falls to 0 the slip turns to a direction with e⊥·a = 0, ever faster, and steps shrink
with v. The turning is therefore divided by √(v² + v₀²) with a `turning_speed` v₀ far below every
speed of the motion: a slip slower than v₀ turns to that direction at a finite rate. Slip that
begins out of stick grows from 0 with the square of time, and a v₀ a hundred times as large costs
no digit there.

A contact without slip needs the friction −g, g = F_n W_tt⁺ w + W_tt⁺ b_t, to stick, and does where
|g| ≤ μ F_n. Else slip begins, along g at first, from where it turns within v₀ to the one direction
in which it can grow.

References
----------
Keller (1986); Batlle (1996); Jia & Wang (2017).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.automata.automaton import (
    Choice,
    HybridAutomaton,
    Mode,
    Reset,
    Transition,
    positive,
)
from painleve_sym.automata.compliant import BranchChange, CompliantInterface
from painleve_sym.automata.contact_forces import ContactRow
from painleve_sym.automata.contact_states import CONTACT_WORK, FRICTION_WORK
from painleve_sym.automata.interfaces import FLIGHTS
from painleve_sym.automata.model import FLIGHT, MOTION
from painleve_sym.errors import EventKind
from painleve_sym.laws.compliance import Branch
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.mechanics.general_contact import general_contact

SLIP, STICK = "slip", "stick"
IMPULSES = ("normal_impulse", "tangential_impulse_1", "tangential_impulse_2")
COEFFICIENTS = (
    *("W_nn", "W_n1", "W_n2", "W_11", "W_12", "W_22"),
    *("gain_1", "gain_2", "free_1", "free_2"),
    *("b_n", "b_1", "b_2", "mu", "turning_speed", "unresolved_force"),
)
"""Parameters besides those of the law: W, W_tt⁺ w and W_tt⁺ b_t (`holding_forces`), b, μ, v₀, and
the force that is rounding beside those of the motion, by which friction may be missed before slip
begins."""

_GAP, _RATE, _V1, _V2, _SPEED, _ANGLE = sp.symbols(
    "gap gap_rate slip_velocity_1 slip_velocity_2 slip_speed slip_angle", real=True
)
_IMPULSES = sp.symbols(IMPULSES, real=True)
_COEFFICIENTS = sp.symbols(COEFFICIENTS, real=True)
_NN, _N1, _N2, _11, _12, _22, *_HOLDING, _BN, _B1, _B2, _MU, _TURNING, _UNRESOLVED = _COEFFICIENTS
_W = sp.Matrix([[_NN, _N1, _N2], [_N1, _11, _12], [_N2, _12, _22]])
_B = sp.Matrix([_BN, _B1, _B2])
_GAIN, _FREE = sp.Matrix(_HOLDING[:2]), sp.Matrix(_HOLDING[2:])
_TURNS_BELOW = sp.Symbol("turns_below", real=True)
"""Memory: the turning speed v₀ of this slip; m/s."""
_BEGINS_BELOW = 100
"""v₀ of a slip that begins out of stick, by that of others."""
_SET_IN = sp.Float("1e-100")
"""Force by which a contact without force is decided, as just after it sets in; N."""


@dataclass(frozen=True)
class FrozenSpatialContact:
    """The automaton of a compliant contact in space with constant coefficients.

    Parameters
    ----------
    law : ContactLaw
        With Coulomb's friction.
    """

    law: ContactLaw

    @property
    def title(self) -> str:
        """The contact and its law in a few words."""
        return f"contact in space, frozen, with {self.law.name}"

    @cached_property
    def _interface(self) -> CompliantInterface:
        row = ContactRow(general_contact().contact, _GAP, _RATE, _SPEED)
        return CompliantInterface(row, MOTION, self.law)

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton: flights, and slip and stick in each branch of the law."""
        zero = sp.Integer(0)
        of_law = (p.symbol for p in self.law.parameters)
        flights = [
            self._mode(name, None, sp.zeros(3, 1), zero, zero, ())
            for name in self._interface.flights
        ]
        rubs = [self._contact(rub, b) for rub in (SLIP, STICK) for b in self.law.branches]
        return HybridAutomaton(
            name=self.title,
            states=(
                *(_GAP, _RATE, _V1, _V2, _SPEED, _ANGLE),
                *(*_IMPULSES, FRICTION_WORK, CONTACT_WORK),
            ),
            memory=(*self.law.memory, _TURNS_BELOW),
            parameters=(*_COEFFICIENTS, *of_law),
            definitions=dict(self.law.definitions),
            modes=(*flights, *rubs),
            starts=(Choice(FLIGHT),),
        )

    # ---- modes ----

    def _contact(self, rub: str, branch: Branch) -> Mode:
        of_state = self._interface.of_state
        force = of_state(branch.force)
        needed = _needed(force)
        if rub == STICK:
            friction = -needed
            changes = [self._slip_start(branch, force)]
        else:
            friction = -_MU * force * _direction()
            changes = [self._slip_stop(branch, force)]
        forces = sp.Matrix([force, *friction])
        stored, power = of_state(branch.stored_energy), of_state(branch.dissipated_power)
        return self._mode(f"{rub}/{branch.name}", rub, forces, stored, power, tuple(changes))

    def _mode(
        self,
        name: str,
        rub: str | None,
        forces: sp.Matrix,
        stored: sp.Expr,
        power: sp.Expr,
        friction_changes: tuple[Transition, ...],
    ) -> Mode:
        """Return a mode with these forces n, t1, t2; friction first, as it decides what follows."""
        normal, *along = _W * forces + _B
        field = {_GAP: _RATE, _RATE: normal, CONTACT_WORK: power}
        if rub is not None:
            field |= dict(zip(_IMPULSES, forces, strict=True))
        if rub != STICK:
            field |= {_V1: along[0], _V2: along[1]}
        if rub == SLIP:
            c, s = _direction()
            field[_SPEED] = c * along[0] + s * along[1]
            field[_ANGLE] = (c * along[1] - s * along[0]) / sp.sqrt(_SPEED**2 + _TURNS_BELOW**2)
            field[FRICTION_WORK] = _MU * forces[0] * _SPEED
        source = name.partition("/")[2] or name
        changes = [self._change(rub, c) for c in self._interface.changes if c.source == source]
        outputs = {
            **dict(zip(("normal_force", "force_1", "force_2"), forces, strict=True)),
            "stored_energy": stored,
        }
        return Mode(name, field, (*friction_changes, *changes), outputs)

    # ---- transitions ----

    def _change(self, rub: str | None, change: BranchChange) -> Transition:
        if not change.closes:
            flies = change.target in FLIGHTS
            target = change.target if flies else f"{rub}/{change.target}"
            kept = (Choice(target, departs=change.back),)
            return Transition(change.label, change.kind, change.guard, kept, change.reset)
        branch = self.law.branch(change.target)
        force, square = self._interface.of_state(branch.force), _V1**2 + _V2**2
        moves, needed = sp.Heaviside(square, 0), _needed(force + _SET_IN)
        one, two = (moves * v + (1 - moves) * g for v, g in zip((_V1, _V2), needed, strict=True))
        lands = {_SPEED: sp.sqrt(square), _ANGLE: sp.atan2(two, one), _TURNS_BELOW: _TURNING}
        slips = Choice(f"{SLIP}/{branch.name}", positive(square))
        choices, reset = (slips, *_at_rest(branch, force)), {**change.reset, **lands}
        return Transition(change.label, change.kind, change.guard, choices, reset)

    def _slip_stop(self, branch: Branch, force: sp.Expr) -> Transition:
        still: Reset = dict.fromkeys((_SPEED, _V1, _V2), sp.Integer(0))
        choices, kind = _at_rest(branch, force), EventKind.SLIP_STOP
        reset = {**still, **_begins(force + _SET_IN), _TURNS_BELOW: _TURNING}
        return Transition("slip_stop", kind, _SPEED, choices, reset)

    def _slip_start(self, branch: Branch, force: sp.Expr) -> Transition:
        choices = (Choice(f"{SLIP}/{branch.name}", departs=("slip_stop",)),)
        # At the end of a contact F_n and what friction can bear vanish together.
        margin = _UNRESOLVED**2 - _beyond(force)
        reset = {**_begins(force), _TURNS_BELOW: _BEGINS_BELOW * _TURNING}
        return Transition("slip_start", EventKind.SLIP_START, margin, choices, reset)


def _direction() -> sp.Matrix:
    return sp.Matrix([sp.cos(_ANGLE), sp.sin(_ANGLE)])


def _needed(force: sp.Expr) -> sp.Matrix:
    """Return g, against which friction holds a contact without slip; N."""
    return force * _GAIN + _FREE


def _beyond(force: sp.Expr) -> sp.Expr:
    """Return |g|² − (μ F_n)², positive where friction cannot hold the contact; N²."""
    one, two = _needed(force)
    return one**2 + two**2 - (_MU * force) ** 2


def _begins(force: sp.Expr) -> Reset:
    """Return the direction in which slip of a contact at rest begins."""
    one, two = _needed(force)
    return {_ANGLE: sp.atan2(two, one)}


def _at_rest(branch: Branch, force: sp.Expr) -> tuple[Choice, ...]:
    """Return the choices of a contact without slip: slip begins, or it sticks."""
    slips = Choice(f"{SLIP}/{branch.name}", positive(_beyond(force + _SET_IN)), ("slip_stop",))
    return slips, Choice(f"{STICK}/{branch.name}")
