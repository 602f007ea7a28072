"""The automaton of a mechanism with several contacts, whose local modes are data.

A literal product of the local modes of n contacts has as many modes as their numbers multiplied
(121 for two contacts under the bilinear law). Here the motion is one mode: what each contact does
(its branch of the law, the sign of its slip, whether it sticks) is memory, 0 or 1 or a sign, by
which the forces are put together. Each contact has its own guards, switched on by its memory. An
event changes the memory of its contact; where contacts at rest must choose between sticking and
slipping again, the transition decides (`Part`): the combination is taken of which no guard fires.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.contacts.contact_states import (
    CONTACT_WORK,
    FORCE_WORK,
    FRICTION_WORK,
    ContactRow,
    domain_transitions,
)
from painleve_sym.errors import InputError
from painleve_sym.hybrid.automaton import (
    Alternative,
    Choice,
    Definition,
    HybridAutomaton,
    LinearSystem,
    Mode,
    Part,
    Transition,
)
from painleve_sym.hybrid.conditions import least
from painleve_sym.laws.compliance import (
    DELTA,
    DELTA_DOT,
    SEPARATED,
    Branch,
    ContactLaw,
    Exit,
    ramp,
)
from painleve_sym.mechanics.contact_set import ContactSet
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.simplify import readable
from painleve_sym.mechanics.system import Parameter

MOTION = "motion"
"""The one mode in which time passes."""
START = "start"
"""The instantaneous mode in which the contacts take up their local modes."""

OPEN, INDENTED = 0, 1
"""Indices of the local modes without force: the gap is open, or the surface is still indented."""
FLIGHT_NAMES = ("flight", "flight_indented")
SLIPS = ("slip_neg", "stick", "slip_pos")
"""Local modes of a branch, in the order of the sign of slip."""


@dataclass(frozen=True)
class CompliantContact:
    """One contact with a force–compression law: its memory, local modes and transitions.

    Parameters
    ----------
    row : ContactRow
        Its states.
    law : ContactLaw
        In symbols of its own where the law of another contact has the same names.
    """

    row: ContactRow
    law: ContactLaw

    @property
    def name(self) -> str:
        """Name of the contact."""
        return self.row.contact.name

    def _memory(self, what: str) -> sp.Symbol:
        return sp.Symbol(f"{what}_{self.name}", real=True)

    @cached_property
    def local(self) -> sp.Symbol:
        """Index of the local mode."""
        return self._memory("local_mode")

    @cached_property
    def sign(self) -> sp.Symbol:
        """Sign of slip where it slips, else 0."""
        return self._memory("slip_sign")

    @cached_property
    def sticks(self) -> sp.Symbol:
        """1 where it sticks, else 0."""
        return self._memory("sticks")

    @cached_property
    def branches(self) -> dict[str, sp.Symbol]:
        """By branch of the law: 1 in it, else 0."""
        return {b.name: self._memory(f"in_{b.name}") for b in self.law.branches}

    @cached_property
    def flights(self) -> tuple[sp.Symbol, ...]:
        """1 where the gap is open, and 1 where only the indented surface is left; else 0."""
        names = FLIGHT_NAMES if self.law.recontacts else FLIGHT_NAMES[:1]
        return tuple(self._memory(name) for name in names)

    @cached_property
    def own_memory(self) -> dict[sp.Symbol, sp.Symbol]:
        """Memory of the law, by the law's own symbols."""
        return {s: self._memory(s.name) for s in self.law.memory}

    @cached_property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """All memory of the contact."""
        flags = (self.local, self.sign, self.sticks, *self.flights, *self.branches.values())
        return (*flags, *self.own_memory.values())

    @cached_property
    def local_modes(self) -> tuple[str, ...]:
        """Names of the local modes."""
        return (*FLIGHT_NAMES, *(f"{s}/{b.name}" for b in self.law.branches for s in SLIPS))

    @property
    def closed(self) -> sp.Expr:
        """1 where it carries force, else 0."""
        return sp.Add(*self.branches.values())

    def of_state(self, expr: sp.Expr) -> sp.Expr:
        """Write an expression of the law in states and memory of the automaton."""
        states = {DELTA: -self.row.gap, DELTA_DOT: -self.row.gap_rate}
        return sp.sympify(expr).xreplace(states | self.own_memory)

    def _in_branches(self, part: str) -> sp.Expr:
        values = [
            _where(flag, self.of_state(getattr(self.law.branch(name), part)))
            for name, flag in self.branches.items()
        ]
        return sp.Add(*values)

    @cached_property
    def force(self) -> sp.Expr:
        """F_n of the branch it is in; 0 in flight; N."""
        return self._in_branches("force")

    @cached_property
    def stored_energy(self) -> sp.Expr:
        """What the contact can still give back; J."""
        return self._in_branches("stored_energy")

    @cached_property
    def dissipated_power(self) -> sp.Expr:
        """Power lost for good; W."""
        return self._in_branches("dissipated_power")

    # ---- entering a local mode ----

    def _flags(self, on: sp.Symbol) -> dict[sp.Symbol, sp.Expr]:
        every = (*self.flights, *self.branches.values())
        return {s: sp.Integer(1 if s == on else 0) for s in every}

    def enter_flight(self, index: int) -> dict[sp.Symbol, sp.Expr]:
        """Return the memory in flight."""
        none = {self.sign: sp.Integer(0), self.sticks: sp.Integer(0)}
        clean = dict.fromkeys(self.own_memory.values(), sp.Integer(0)) if index == OPEN else {}
        return {self.local: sp.Integer(index), **none, **self._flags(self.flights[index]), **clean}

    def _index(self, branch: str) -> int:
        """Return the index of sticking in a branch; slip is one beside it."""
        return len(FLIGHT_NAMES) + len(SLIPS) * list(self.branches).index(branch) + 1

    def enter_branch(self, branch: str) -> dict[sp.Symbol, sp.Expr]:
        """Return the memory in a branch after a flight, slipping by the sign of v_t."""
        sign = sp.sign(self.row.slip)
        return {
            self.local: self._index(branch) + sign,
            self.sign: sign,
            self.sticks: sp.Integer(0),
            **self._flags(self.branches[branch]),
        }

    def _to_friction(self, sign: int) -> dict[sp.Symbol, sp.Expr]:
        """Return the memory in the same branch with a slip, or in sticking where `sign` is 0."""
        here = sp.Add(*[flag * self._index(name) for name, flag in self.branches.items()])
        return {
            self.local: here + sign,
            self.sign: sp.Integer(sign),
            self.sticks: sp.Integer(0 if sign else 1),
        }

    @cached_property
    def part(self) -> Part:
        """What it may do where contacts at rest choose: keep on, stick, or slip either way."""
        at_rest = least(self.closed, sp.Float("1e-300") - sp.Abs(self.row.slip))
        moving = sp.Max(1 - self.closed, sp.Abs(self.row.slip), evaluate=False)
        choices = [Alternative(moving)]
        choices += [Alternative(at_rest, self._to_friction(sign)) for sign in (0, -1, 1)]
        return Part(self.name, self.memory, self.local_modes, tuple(choices))

    # ---- transitions ----

    def _label(self, kind: str) -> str:
        return f"{kind}:{self.name}"

    def start(self) -> dict[sp.Symbol, sp.Expr]:
        """Return the memory at the start: loading where the gap is negative, else open."""
        inside, outside = self.enter_branch(self.law.loading.name), self.enter_flight(OPEN)
        pressed = sp.Heaviside(-self.row.gap, 0)
        return {
            s: pressed * inside.get(s, sp.Integer(0)) + (1 - pressed) * outside[s] for s in outside
        }

    def transitions(self, needed: sp.Expr) -> tuple[Transition, ...]:
        """Return the transitions of the contact: friction first, as for a single contact.

        Parameters
        ----------
        needed : sympy.Expr
            F_t that the contact carries.
        """
        mu, row, motion = self.row.contact.friction, self.row, (Choice(MOTION),)
        changes = []
        for sign, margin in ((-1, mu * self.force - needed), (1, mu * self.force + needed)):
            enter = (Choice(MOTION, departs=(self._label("slip_stop"),)),)
            side = "neg" if sign < 0 else "pos"
            changes.append(
                Transition(
                    self._label(f"slip_start_{side}"),
                    "slip_start",
                    _where(self.sticks, margin),
                    enter,
                    self._to_friction(sign),
                )
            )
        changes.append(
            Transition(
                self._label("slip_stop"),
                "slip_stop",
                self.sign * row.slip,
                motion,
                {row.slip: sp.Integer(0)},
                decides=True,
            )
        )
        changes.append(
            Transition(
                self._label("touchdown"),
                "touchdown",
                _where(self.flights[OPEN], row.gap),
                motion,
                self.enter_branch(self.law.loading.name),
                decides=True,
            )
        )
        for branch in self.law.branches:
            for number, e in enumerate(branch.exits):
                changes.append(self._exit(branch, number, e))
        if self.law.recontacts:
            changes += self._recontacts()
        return tuple(changes)

    def _exit(self, branch: Branch, number: int, e: Exit) -> Transition:
        flag = self.branches[branch.name]
        reset: dict[sp.Symbol, sp.Expr]
        if e.target == SEPARATED:
            reset = self.enter_flight(INDENTED if self.law.recontacts else OPEN)
            after = sp.Integer(0)
        else:
            shift = self._index(e.target) - self._index(branch.name)
            reset = {self.own_memory[s]: self.of_state(v) for s, v in e.memory.items()}
            reset |= {self.local: self.local + shift, **self._flags(self.branches[e.target])}
            after = self.law.branch(e.target).stored_energy.xreplace(dict(e.memory))
        released = self.of_state(branch.stored_energy - after)
        if released != 0:
            reset[CONTACT_WORK] = CONTACT_WORK + released
        label = self._label(f"{e.kind}_{branch.name}_{number}")
        guard = _where(flag, self.of_state(e.guard))
        return Transition(label, e.kind, guard, (Choice(MOTION),), reset)

    def _recontacts(self) -> list[Transition]:
        flag = self.flights[INDENTED]
        leave = Transition(
            self._label("liftoff"),
            "liftoff",
            _where(flag, -self.row.gap),
            (Choice(MOTION),),
            self.enter_flight(OPEN),
        )
        changes = [leave]
        for number, e in enumerate(self.law.recontacts):
            reset = {self.own_memory[s]: self.of_state(v) for s, v in e.memory.items()}
            stored = self.law.branch(e.target).stored_energy.xreplace(dict(e.memory))
            reset[CONTACT_WORK] = CONTACT_WORK - self.of_state(stored)
            changes.append(
                Transition(
                    self._label(f"recontact_{number}"),
                    e.kind,
                    _where(flag, self.of_state(e.guard)),
                    (Choice(MOTION),),
                    reset | self.enter_branch(e.target),
                    decides=True,
                )
            )
        return changes


@dataclass(frozen=True)
class CompliantContacts:
    """Builds the automaton of a mechanism with any number of compliant contacts.

    Parameters
    ----------
    mechanism : Mechanism
    laws : mapping of str to ContactLaw
        The law of each contact by its name. One law object for all contacts keeps the names of its
        parameters; laws of their own have the contact's name behind each of theirs.
    """

    mechanism: Mechanism
    laws: Mapping[str, ContactLaw]

    def __post_init__(self) -> None:
        held = [c.name for c in self.mechanism.contacts if c.bilateral]
        if held:
            raise InputError(
                f"mechanism {self.mechanism.name!r}: contact {held[0]!r} holds from both sides, "
                "and a law only pushes."
            )

    @cached_property
    def contact_set(self) -> ContactSet:
        """The contacts together."""
        return ContactSet(self.mechanism)

    @cached_property
    def rows(self) -> tuple[ContactRow, ...]:
        """States of each contact."""
        return tuple(
            ContactRow.of(
                c,
                sp.Symbol(f"gap_{c.name}", real=True),
                sp.Symbol(f"gap_{c.name}_dot", real=True),
                sp.Symbol(f"slip_velocity_{c.name}", real=True),
            )
            for c in self.mechanism.contacts
        )

    @cached_property
    def contacts(self) -> tuple[CompliantContact, ...]:
        """Each contact with its law."""
        return tuple(CompliantContact(r, self.laws[r.contact.name]) for r in self.rows)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the laws, each once."""
        every = [p for c in self.contacts for p in c.law.parameters]
        return tuple({p.name: p for p in every}.values())

    @cached_property
    def dissipations(self) -> tuple[sp.Symbol, ...]:
        """States that only account for energy."""
        moving = any(speed != 0 for speed in self.contact_set.surface_speeds)
        driven = self.mechanism.system.dissipated_power != 0 or moving
        return (FRICTION_WORK, CONTACT_WORK, *((FORCE_WORK,) if driven else ()))

    @cached_property
    def states(self) -> tuple[sp.Symbol, ...]:
        """Coordinates, velocities, contact states where needed, then dissipated energies."""
        system = self.mechanism.system
        own = (*system.q, *system.q_dot)
        extra = [s for row in self.rows for s in row.symbols if s not in own]
        return (*own, *extra, *self.dissipations)

    # ---- forces ----

    @cached_property
    def _symbols(self) -> dict[str, sp.Matrix]:
        n, nq = len(self.contacts), len(self.mechanism.system.q)

        def named(letter: str, rows: int, columns: int) -> sp.Matrix:
            return sp.Matrix(
                rows, columns, lambda i, j: sp.Symbol(f"{letter}_{i + 1}_{j + 1}", real=True)
            )

        W = named("W", 2 * n, 2 * n)
        W = sp.Matrix(2 * n, 2 * n, lambda i, j: W[min(i, j), max(i, j)])
        return {
            "W": W,
            "b": named("b", 2 * n, 1),
            "D": named("D", nq, 2 * n),
            "a": named("a", nq, 1),
            "F": named("F", 2 * n, 1),
        }

    @cached_property
    def terms(self) -> tuple[Definition | LinearSystem, ...]:
        """Mobility, free motion and forces, in the order in which they follow from each other."""
        own, given, n = self._symbols, self.contact_set, len(self.contacts)
        pairs = [
            *zip(own["a"], self.mechanism.system.free_acceleration, strict=True),
            *zip(own["D"], given.directions, strict=True),
            *((own["W"][i, j], given.W[i, j]) for i in range(2 * n) for j in range(i, 2 * n)),
            *zip(own["b"], given.b, strict=True),
            *((own["F"][2 * i], c.force) for i, c in enumerate(self.contacts)),
        ]
        return (*(Definition(*pair) for pair in pairs), self._friction)

    @property
    def _friction(self) -> LinearSystem:
        """The tangential forces: v̇_t = 0 where a contact sticks, F_t = −μ s F_n where it slips."""
        W, b, F = (self._symbols[k] for k in ("W", "b", "F"))
        n, sticks = len(self.contacts), [c.sticks for c in self.contacts]
        slipping = [
            -c.row.contact.friction * c.sign * F[2 * i] for i, c in enumerate(self.contacts)
        ]
        matrix, right = sp.zeros(n, n), sp.zeros(n, 1)
        for i in range(n):
            t = 2 * i + 1
            pulled = b[t] + sum(
                W[t, 2 * j] * F[2 * j] + W[t, 2 * j + 1] * slipping[j] for j in range(n)
            )
            right[i] = -sticks[i] * pulled + (1 - sticks[i]) * W[t, t] * slipping[i]
            for j in range(n):
                share = sticks[i] * sticks[j] * W[t, 2 * j + 1]
                matrix[i, j] = share if i != j else W[t, t]
        unknowns = tuple(F[2 * i + 1] for i in range(n))
        return LinearSystem(unknowns, matrix, right, semidefinite=True)

    def _field(self) -> dict[sp.Symbol, sp.Expr]:
        system, own = self.mechanism.system, self._symbols
        F = own["F"]
        rates = dict(zip(system.q, system.q_dot, strict=True))
        rates |= dict(zip(system.q_dot, own["a"] + own["D"] * F, strict=True))
        accelerations = own["W"] * F + own["b"]
        friction = drive = lost = sp.Integer(0)
        for i, (c, speed) in enumerate(
            zip(self.contacts, self.contact_set.surface_speeds, strict=True)
        ):
            n, t = 2 * i, 2 * i + 1
            rates[c.row.gap] = c.row.gap_rate
            rates[c.row.gap_rate] = accelerations[n]
            rates[c.row.slip] = (1 - c.sticks) * accelerations[t]
            friction -= (1 - c.sticks) * F[t] * c.row.slip
            drive -= F[t] * speed
            lost += c.dissipated_power
        rates |= {FRICTION_WORK: friction, CONTACT_WORK: lost}
        if FORCE_WORK in self.dissipations:
            rates[FORCE_WORK] = system.dissipated_power + drive
        return rates

    def outputs(self) -> dict[str, sp.Expr]:
        """Return forces, gaps and velocities of each contact by name, and energies."""
        system, F = self.mechanism.system, self._symbols["F"]
        values: dict[str, sp.Expr] = {}
        for i, c in enumerate(self.contacts):
            own = {
                "normal_force": F[2 * i],
                "tangential_force": F[2 * i + 1],
                "compression": -c.row.gap,
                "gap": c.row.gap,
                "gap_rate": c.row.gap_rate,
                "slip_velocity": c.row.slip,
            }
            values |= {f"{name}_{c.name}": value for name, value in own.items()}
        return values | {
            "kinetic_energy": system.kinetic_energy,
            "potential_energy": system.potential_energy,
            "stored_energy": sp.Add(*[c.stored_energy for c in self.contacts]),
        }

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton, validated."""
        mechanism, F = self.mechanism, self._symbols["F"]
        changes = [t for i, c in enumerate(self.contacts) for t in c.transitions(F[2 * i + 1])]
        begin = {s: v for c in self.contacts for s, v in c.start().items()}
        start = Transition(
            START, "contact", sp.Integer(-1), (Choice(MOTION),), begin, decides=True
        )
        parameters = (*mechanism.system.parameters, *self.parameters)
        definitions = {s: v for c in self.contacts for s, v in c.law.definitions.items()}
        laws = sorted({law.name for law in self.laws.values()})
        return HybridAutomaton(
            name=f"{mechanism.name} with {', '.join(laws)}",
            states=self.states,
            memory=tuple(s for c in self.contacts for s in c.memory),
            parameters=tuple(p.symbol for p in parameters),
            definitions={s: readable(v) for s, v in definitions.items()},
            modes=(
                Mode(
                    MOTION,
                    self._field(),
                    (*changes, *domain_transitions(mechanism)),
                    self.outputs(),
                ),
                Mode(START, {}, (start,), self.outputs()),
            ),
            starts=(Choice(START),),
            uncontrolled=self.dissipations,
            terms=self.terms,
            parts=tuple(c.part for c in self.contacts),
        )


def _where(flag: sp.Expr, expr: sp.Expr) -> sp.Expr:
    """Return the expression where the flag is 1, and 0, with all its derivatives, where it is 0.

    A guard that stays 0 never fires. Ramps inside keep their base at 0.
    """
    return flag * sp.sympify(expr).replace(
        lambda e: isinstance(e, ramp), lambda e: ramp(flag * e.args[0], evaluate=False)
    )
