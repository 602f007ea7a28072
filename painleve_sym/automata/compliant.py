"""A contact with a force–compression law: one of several, and the automaton of an only one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import sympy as sp

from painleve_sym.automata.automaton import (
    Alternative,
    Choice,
    HybridAutomaton,
    Mode,
    Part,
    Test,
    Transition,
    is_zero,
    positive,
)
from painleve_sym.automata.contact_forces import ContactMotion, Forces, Known, LocalMode, Memory
from painleve_sym.automata.contact_states import CONTACT_WORK, OneContact
from painleve_sym.automata.interfaces import (
    FLIGHTS,
    RUBBING,
    ContactStart,
    Interface,
    switched,
    zero_factor,
)
from painleve_sym.automata.model import CONTACT, CONTACTS, FLIGHT, INDENTED, MOTION, SLIPS
from painleve_sym.errors import EventKind
from painleve_sym.laws.compliance import DELTA, DELTA_DOT, SEPARATED, Branch, Exit, ramp
from painleve_sym.laws.contact_law import ContactLaw

UNRESOLVED = sp.Rational(1, 10**12)
"""Of the forces of a contact: what they are known to."""

_ZERO, _ONE = sp.Integer(0), sp.Integer(1)


@dataclass(frozen=True)
class BranchChange:
    """Passage of a contact from one branch of its law, or a flight, to another.

    The label is unique among those with the same source, and the guard crosses from + to −. The
    reset is that of the law's memory, and of the energy that it takes: what the stored energy jumps
    by is nothing where the force is continuous, a loss where a stretched dashpot lets go, a gain
    under the virgin reload rule. `back` has the labels of changes back to the source, where both
    have the same force and one guard has the other sign of the other: it is zero on entry, and
    smooth motion takes it up.
    """

    label: str
    kind: EventKind
    source: str
    target: str
    guard: sp.Expr
    reset: Memory
    back: tuple[str, ...] = ()

    @property
    def closes(self) -> bool:
        """Whether the force sets in."""
        return self.source in FLIGHTS and self.target not in FLIGHTS


def _turns_back(second: BranchChange, first: BranchChange) -> bool:
    """Return whether a change leads back from another, at the zero of the same guard."""
    here = (second.source, second.target) == (first.target, first.source)
    return here and second.guard == -first.guard


@dataclass(frozen=True)
class CompliantInterface(Interface):
    """A contact with a force–compression law.

    The law is in symbols of its own where that of another contact has the same names.
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
    def unresolved_force(self) -> sp.Symbol:
        """Memory: rounding level of the normal force since the contact closed; N."""
        return self._symbol("unresolved_force")

    @cached_property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """All memory of the contact."""
        own = (self.local, self.sign, self.sticks, *self._friction_memory)
        return (*own, *self.flags.values(), *self.law_memory.values())

    @property
    def _friction_memory(self) -> tuple[sp.Symbol, ...]:
        """Memory of friction, 0 in flight."""
        return (self.unresolved_force,)

    @cached_property
    def local_modes(self) -> tuple[str, ...]:
        """Flights, then slips and stick in each branch."""
        return (*FLIGHTS, *(f"{s}/{b.name}" for b in self.law.branches for s in RUBBING))

    def of_state(self, expr: sp.Expr) -> sp.Expr:
        """Write an expression of the law in states and memory of the automaton."""
        states = {DELTA: -self.row.gap, DELTA_DOT: -self.row.gap_rate}
        return sp.sympify(expr).xreplace(states | self.law_memory)

    def in_branches(self, quantity: Callable[[Branch], sp.Expr]) -> sp.Expr:
        """Return a quantity in its branch, 0 in flight; branches that agree share it."""
        flags: dict[sp.Expr, sp.Expr] = {}
        for branch in self.law.branches:
            value = self.of_state(quantity(branch))
            flags[value] = flags.get(value, _ZERO) + self.flags[branch.name]
        return sp.Add(*[switched(flag, value) for value, flag in flags.items()])

    @property
    def start(self) -> ContactStart:
        """It may start inside the surface, pressed."""
        return ContactStart(self.row, loading_curve=(self.law.stiffness, self.law.exponent))

    @property
    def closed(self) -> sp.Expr:
        """1 where it carries force, else 0."""
        return sp.Add(*(self.flags[name] for name in self.branches))

    @property
    def _flies(self) -> LocalMode:
        zero = Known.ZERO
        return LocalMode(1 - self.closed, zero, zero, gap_moves=True, slip_moves=True)

    @property
    def _of_law(self) -> dict[str, Any]:
        """Normal force and energies of the law in its branches, 0 in flight; see `Forces`."""
        return {
            "given": self.in_branches(lambda b: b.force),
            "unresolved": self.unresolved_force,
            "stored_energy": self.in_branches(lambda b: b.stored_energy),
            "dissipated_power": self.in_branches(lambda b: b.dissipated_power),
        }

    @cached_property
    def forces(self) -> Forces:
        """The law gives F_n where it is closed."""
        table = self._table((self._flies,), self.closed, Known.GIVEN)
        return Forces(self, table, **self._of_law)

    # ---- entering a local mode ----

    def _in(self, place: str) -> Memory:
        return {s: _ONE if name == place else _ZERO for name, s in self.flags.items()}

    def _enter_flight(self, name: str) -> Memory:
        none = dict.fromkeys((self.sign, self.sticks, *self._friction_memory), _ZERO)
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
        sticks = _ZERO if self.is_coulomb else zero_factor(self.row.slip)
        return {
            self.local: self._index(branch) + sign,
            self.sign: sign,
            self.sticks: sticks,
            **self._in(branch),
        }

    def _land(self, change: BranchChange, motion: ContactMotion) -> Memory:
        """Return the memory, and changed states, of a contact whose force sets in."""
        return self._enter_branch(change.target) | self._resolution(motion)

    def _resolution(self, motion: ContactMotion) -> Memory:
        """Return the force that counts as rounding, of a contact whose force sets in.

        Its normal force vanishes where it closes and where it opens, and so does what friction can
        bear. A tangential load that is nothing but rounding would make it slip there.
        """
        K, n = self.law.stiffness, self.law.exponent
        row = self.row
        # Force at the compression that takes up the energy of the approach.
        approach = ramp((n + 1) * row.gap_rate**2 / (2 * motion.normal_mobility * K))
        forces = motion.force_scale + K * (approach ** (n / (n + 1)) + ramp(-row.gap) ** n)
        return {self.unresolved_force: UNRESOLVED * forces}

    def _rub(self, sign: sp.Expr, sticks: sp.Expr) -> Memory:
        """Return the memory in the same branch with another slip."""
        here = sp.Add(*[self.flags[name] * self._index(name) for name in self.branches])
        return {self.local: here + sign, self.sign: sign, self.sticks: sticks}

    @cached_property
    def part(self) -> Part:
        """Alternatives where contacts at rest choose: keep on, stick, or slip either way."""
        closed, slip = self.closed, self.row.slip
        at_rest = sp.And(positive(closed), is_zero(slip))
        sliding = sp.And(positive(closed), positive(sp.Abs(slip)))
        choices = [
            Alternative(sp.Le(closed, 0, evaluate=False)),
            Alternative(sliding, self._rub(sp.sign(slip), _ZERO)),
        ]
        may_stick, prefers = self.may_stick(at_rest), not self.is_coulomb
        choices.append(Alternative(may_stick, self._rub(_ZERO, _ONE), preferred=prefers))
        choices += [Alternative(at_rest, self._rub(sp.Integer(sign), _ZERO)) for sign in (-1, 1)]
        if self.target == CONTACT:  # beside rigid contacts, which may hold it
            choices += self._rests(at_rest, self._rub(_ZERO, _ONE), {-1: 3, 1: 4})
        return self._part(
            alternatives=tuple(choices),
            rest=(slip,),
            # Of a slip that begins only: compliant contacts open and close by their law.
            leaving=self.watch.leaving[:1],
            variants=self._variants,
        )

    @property
    def _variants(self) -> tuple[Memory, ...]:
        """Flight, then slip and stick in branches of the same force."""
        flight = {self.sign: _ZERO, self.sticks: _ZERO, **self._in(FLIGHT)}
        groups: dict[sp.Expr, list[sp.Symbol]] = {}
        for branch in self.law.branches:
            groups.setdefault(branch.force, []).append(self.flags[branch.name])
        none = dict.fromkeys(self.flags.values(), _ZERO)
        rows = [flight]
        for *others, last in groups.values():
            # It is in one of them; in which stays open.
            inside = {flag: value for flag, value in none.items() if flag not in others}
            inside[last] = 1 - sp.Add(*others)
            rows += [rubs | inside for rubs in self._rubbing_variants]
        return tuple(rows)

    def begin(self, motion: ContactMotion) -> Memory:
        """Return the memory at the start: loading where the gap is negative, else open."""
        inside = self._enter_branch(self.law.loading.name) | self._resolution(motion)
        outside = self._enter_flight(FLIGHT)
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
        back = (
            tuple(o.label for o in changes if self._smooth(c) and _turns_back(o, c))
            for c in changes
        )
        return tuple(replace(c, back=labels) for c, labels in zip(changes, back, strict=True))

    def _smooth(self, change: BranchChange) -> bool:
        """Return whether the force of two branches is the same function."""
        if change.source in FLIGHTS or change.target in FLIGHTS:
            return False
        source, target = self.law.branch(change.source), self.law.branch(change.target)
        return bool(source.force == target.force)

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
        ends = [self.watch.end_of_rest(motion)] if self.target == CONTACT else []
        switches = (self._switch(c, motion) for c in self.changes)
        return [*self._friction_changes(motion), *switches, *ends]

    def tests(self, motion: ContactMotion) -> list[Test]:
        """Return the friction cone, and the onset of slip."""
        return self.watch.tests(motion)

    def _friction_changes(self, motion: ContactMotion) -> list[Transition]:
        return self.watch.friction_changes(motion)

    def _switch(self, change: BranchChange, motion: ContactMotion) -> Transition:
        """Return a change as one of the memory of this contact."""
        if change.target in FLIGHTS:
            enter = self._enter_flight(change.target)
        elif change.closes:
            enter = self._land(change, motion)
        else:
            shift = self._index(change.target) - self._index(change.source)
            enter = {self.local: self.local + shift, **self._in(change.target)}
        guard, reset = switched(self.flags[change.source], change.guard), change.reset | enter
        label = self._label(change.label, change.source)
        back = tuple(f"{self._label(one, change.target)}:{self.row.name}" for one in change.back)
        asks = change.closes
        return self.watch.transition(label, change.kind, guard, reset, asks=asks, departs=back)

    def _label(self, label: str, source: str) -> str:
        """Return the label of a change, unique among all sources."""
        return label if source in FLIGHTS else f"{label}_{source}"


@dataclass(frozen=True)
class CompliantContact(OneContact):
    """Builds the automaton: flight, slip ±, stick, each with the branches of the law."""

    @property
    def law(self) -> ContactLaw:
        """The law of the contact."""
        return self.model.compliant[0]

    @cached_property
    def interface(self) -> CompliantInterface:
        """The contact with its law: coefficients of friction, changes of branch and flight."""
        return CompliantInterface(self.rows[0], MOTION, self.law)

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """Memory of the law."""
        return self.law.memory

    def _law_field(self, contact: str, branch: Branch) -> dict[sp.Symbol, sp.Expr]:
        rates = self.field(contact, self.interface.of_state(branch.force))
        return rates | {CONTACT_WORK: self.interface.of_state(branch.dissipated_power)}

    def _contact_choices(self, branch: str) -> tuple[Choice, ...]:
        slips = (Choice(f"{name}/{branch}", positive(s * self.slip)) for s, name in SLIPS.items())
        return (*slips, Choice(f"stick/{branch}"))

    def _landing(self, change: BranchChange) -> tuple[tuple[Choice, ...], dict[sp.Symbol, sp.Expr]]:
        """Return choices and reset of a contact whose force sets in."""
        return self._contact_choices(change.target), {}

    def _change(self, contact: str, change: BranchChange) -> Transition:
        reset = change.reset
        if change.closes:
            choices, landed = self._landing(change)
            reset = reset | landed
        else:
            flies = change.target in FLIGHTS
            target = change.target if flies else f"{contact}/{change.target}"
            choices = (Choice(target, departs=change.back),)
        return self.transition(change.label, change.kind, change.guard, choices, reset)

    def _changes(self, source: str, contact: str = "") -> list[Transition]:
        return [self._change(contact, c) for c in self.interface.changes if c.source == source]

    def _contact_mode(self, contact: str, branch: Branch) -> Mode:
        force = self.interface.of_state(branch.force)
        if contact == "stick":
            changes = self._slip_starts(branch, force)
        else:
            changes = [self._slip_stop(CONTACTS[contact], branch, force)]
        return Mode(
            f"{contact}/{branch.name}",
            self._law_field(contact, branch),
            # Friction first: at a start at rest it decides which normal motion follows.
            (*changes, *self._changes(branch.name, contact), *self.domain_ends(CONTACTS[contact])),
            self.outputs(contact, force, self.interface.of_state(branch.stored_energy)),
        )

    def _slip_starts(self, branch: Branch, force: sp.Expr) -> list[Transition]:
        """Return the ends of stick: |F_t| has reached the limit of friction."""
        return self.slip_starts(self.stick_margins(force), partial(self._begun, branch))

    def _begun(self, branch: Branch, slip: int) -> tuple[Choice, ...]:
        return (Choice(f"{SLIPS[slip]}/{branch.name}", departs=("slip_stop",)),)

    def _slip_stop(self, s: int, branch: Branch, force: sp.Expr) -> Transition:
        """Return the end of slip along s: v_t = 0."""
        needed = self.tangential_force("stick", force)
        turns = positive(s * needed - self.interface.static_coefficient * force)
        reverse = Choice(f"{SLIPS[-s]}/{branch.name}", turns, ("slip_stop",))
        return self.slip_stop(s, (reverse, Choice(f"stick/{branch.name}")))

    def _flight_modes(self) -> list[Mode]:
        free, outputs = self.field(None, _ZERO), self.outputs(None, _ZERO, _ZERO)
        return [
            Mode(name, free, (*self._changes(name), *self.domain_ends(0)), outputs)
            for name in self.interface.flights
        ]

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton, validated."""
        contact_modes = [self._contact_mode(c, b) for c in CONTACTS for b in self.law.branches]
        modes, starts = (*self._flight_modes(), *contact_modes), self._start_choices()
        return self.automaton_of(f" with {self.law.name}", modes, starts, memory=self.memory)

    def _start_choices(self) -> tuple[Choice, ...]:
        # Inside the surface: loading, whose guards then sort out unloading. On it: flight, whose
        # touchdown guard (gap, its rate, its acceleration) decides between flight and contact.
        below = positive(-self.gap)
        choices = self._contact_choices(self.law.loading.name)
        inside = [
            Choice(c.target, below if c.condition is None else sp.And(below, c.condition))
            for c in choices
        ]
        return (*inside, Choice(FLIGHT))
