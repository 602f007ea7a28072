"""The automaton of a mechanism with several contacts, whose local modes are data.

A literal product of the local modes of n contacts has as many modes as their numbers multiplied
(121 for two contacts under the bilinear law). Here the motion is one mode: what each contact does
is memory, 0 or 1 or a sign, by which forces and guards are switched. An event changes the memory of
its contact; where contacts must find what follows, every combination of their alternatives is held
against the inequalities of its contact problem and their derivatives along its own motion.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import sympy as sp

from painleve_sym.arrays import Array
from painleve_sym.automata.automaton import (
    Choice,
    Definition,
    HybridAutomaton,
    Impacts,
    LinearSystem,
    Mode,
    Test,
    TestRole,
    Transition,
)
from painleve_sym.automata.compliant import CompliantInterface
from painleve_sym.automata.contact_forces import ContactMotion, Forces
from painleve_sym.automata.contact_states import (
    CONTACT_WORK,
    FORCE_WORK,
    FRICTION_WORK,
    SINGULAR_MARGIN,
    ContactStates,
)
from painleve_sym.automata.guide import GuideInterface
from painleve_sym.automata.interfaces import Interface, zero_factor
from painleve_sym.automata.model import CONTACT, MOTION, START
from painleve_sym.automata.rigid import RigidInterface
from painleve_sym.automata.tangential_spring import SpringInterface
from painleve_sym.contact_rows import ContactRows
from painleve_sym.errors import EventKind, StopReason
from painleve_sym.laws.contact_kind import ContactKind
from painleve_sym.mechanics.contact_set import ContactSet

_ZERO, _ONE = sp.Integer(0), sp.Integer(1)


INTERFACES: dict[ContactKind, type[Interface]] = {
    ContactKind.GUIDE: GuideInterface,
    ContactKind.RIGID: RigidInterface,
    ContactKind.COMPLIANT: CompliantInterface,
    ContactKind.SPRING: SpringInterface,
}
"""What a contact of each kind remembers and does."""


@dataclass(frozen=True)
class PluralContacts(ContactStates):
    """Builds the automaton of a mechanism with any number of contacts of any kinds.

    References
    ----------
    Glocker & Pfeiffer (1995).
    """

    @cached_property
    def contact_set(self) -> ContactSet:
        """The contacts together."""
        return ContactSet(self.mechanism)

    @cached_property
    def interfaces(self) -> tuple[Interface, ...]:
        """The interface of each contact: its memory, local modes and transitions."""
        target = CONTACT if self.model.rigid else MOTION
        given = zip(self.rows, self.model.own_laws, strict=True)
        return tuple(INTERFACES[law.kind](row, target, law) for row, law in given)

    # ---- forces ----

    @cached_property
    def _forces(self) -> tuple[Forces, ...]:
        return tuple(c.forces for c in self.interfaces)

    @property
    def _at(self) -> ContactRows:
        return ContactRows(len(self.interfaces))

    @cached_property
    def _symbols(self) -> dict[str, sp.Matrix]:
        size, nq = self._at.size, len(self.mechanism.system.q)

        def named(letter: str, rows: int, columns: int = 1) -> sp.Matrix:
            return sp.Matrix(
                rows, columns, lambda i, j: sp.Symbol(f"{letter}_{i + 1}_{j + 1}", real=True)
            )

        W = named("W", size, size)
        return {
            "W": sp.Matrix(size, size, lambda i, j: W[min(i, j), max(i, j)]),
            "b": named("b", size),
            "D": named("D", nq, size),
            "a": named("a", nq),
            "F": named("F", size),
            "acceleration": named("acceleration", size),
            "resolved": named("resolved", size),
            "resolved_acceleration": named("resolved_acceleration", size),
        }

    def _normals(self) -> list[sp.Symbol]:
        return list(self._symbols["F"])[self._at.normals]

    def _friction(
        self,
        columns: Sequence[Callable[[int], sp.Expr]],
        unknowns: sp.Matrix,
        ease: tuple[sp.Expr, ...] = (),
    ) -> LinearSystem:
        """Return the tangential forces: v̇_t = 0 where a contact sticks, −μ s F_n where it slips.

        A column is the normal force of each contact by its index, for one right side. The first
        also has the free accelerations and the forces of springs. What is not determined is shared
        by `ease`: where it is empty equally, of a single column by what its forces let bear.
        """
        W, b, n = self._symbols["W"], self._symbols["b"], len(self.interfaces)
        sticks = [c.holds for c in self._forces]
        matrix, right = sp.zeros(n, n), sp.zeros(n, len(columns))
        normal, tangent = self._at.normal, self._at.tangent
        for i in range(n):
            t = tangent(i)
            moves, ease_alone = self._slides(i)
            for j in range(n):
                share = sticks[i] * sticks[j] * W[t, tangent(j)]
                matrix[i, j] = share if i != j else ease_alone
            for k, force in enumerate(columns):
                slipping = [
                    c.known_friction(force(j)) + (c.spring_force if k == 0 else _ZERO)
                    for j, c in enumerate(self._forces)
                ]
                pulled = sum(
                    W[t, normal(j)] * force(j) + W[t, tangent(j)] * slipping[j] for j in range(n)
                )
                pulled += b[t] if k == 0 else _ZERO
                held, free = sticks[i] * moves, (1 - sticks[i]) * ease_alone
                right[i, k] = free * slipping[i] - held * pulled
        if len(columns) == 1:
            ease = self._capacities(columns[0])
        return LinearSystem(unknowns, matrix, right, ease=ease)

    def _slides(self, i: int) -> tuple[sp.Expr, sp.Expr]:
        """Return 1 where some motion slides a contact, else 0, and W_tt there, else 1.

        Where no motion does, W_tt = 0, and the friction that sticking needs is 0.
        """
        t = self._at.tangent(i)
        own, symbol = self.contact_set.W[t, t], self._symbols["W"][t, t]
        states = {*self.mechanism.system.q, *self.mechanism.system.q_dot}
        if own == 0:
            return _ZERO, _ONE
        if own.is_positive or own.free_symbols & states:
            return _ONE, symbol
        slides = sp.sign(symbol)
        return slides, symbol + 1 - slides

    @cached_property
    def _several_stick(self) -> sp.Expr:
        """1 where at least two contacts stick, else 0."""
        sticks = [c.holds for c in self._forces]
        none = sp.Mul(*[1 - s for s in sticks])
        one = sp.Add(
            *[s * sp.Mul(*[1 - r for r in sticks if r is not s]) for s in sticks if s != 0]
        )
        return 1 - none - one

    def _capacities(self, force: Callable[[int], sp.Expr]) -> tuple[sp.Expr, ...]:
        """Return what sticking contacts can bear, by which they share what is not determined.

        Those that slip have a force of their own, and the capacity of these as their ease. Nothing
        is shared where fewer than two contacts stick: there the ease is 1 for all, so that no force
        is divided by a normal force that may vanish.
        """
        sticks = [c.holds for c in self._forces]
        limits = [c.holds * c.capacity(force(i)) for i, c in enumerate(self._forces)]
        several = self._several_stick
        return tuple(
            several * (limit + (1 - s) * sp.Add(*limits)) + (1 - several)
            for s, limit in zip(sticks, limits, strict=True)
        )

    @cached_property
    def terms(self) -> tuple[Definition | LinearSystem, ...]:
        """Mobility, free motion, forces and accelerations, as they follow from each other."""
        own, given, size = self._symbols, self.contact_set, self._at.size
        W, F = own["W"], own["F"]
        laws = (
            Definition(F[self._at.normal(i)], c.given)
            for i, c in enumerate(self._forces)
            if c.given is not None
        )
        return (
            *_defined(own["a"], self.mechanism.system.free_acceleration),
            *_defined(own["D"], given.directions),
            *(Definition(W[i, j], given.W[i, j]) for i in range(size) for j in range(i, size)),
            *_defined(own["b"], given.b),
            *laws,
            *self._closing(),
            *_defined(own["acceleration"], W * F + own["b"]),
            *self._resolved_terms(),
        )

    def _resolved_terms(self) -> Iterator[Definition | LinearSystem]:
        """Yield forces and accelerations that tests take; see `Forces.resolved`."""
        own, forces, at = self._symbols, self._symbols["resolved"], self._at
        total = sp.Add(*[sp.Abs(force) for force in self._normals()])
        for i, (c, normal) in enumerate(zip(self._forces, self._normals(), strict=True)):
            yield Definition(forces[at.normal(i)], c.resolved(normal, total))
        tangential = sp.Matrix(list(forces)[at.tangentials])
        yield self._friction([lambda i: forces[at.normal(i)]], tangential)
        yield from _defined(own["resolved_acceleration"], own["W"] * forces + own["b"])

    def _closing(self) -> Iterator[Definition | LinearSystem]:
        """Yield the normal forces that keep g̈_N = 0, and friction.

        Where friction is not determined, or hardly, contacts share it by what they can bear. What
        that does to g̈_N beside compliant contacts is taken back.
        """
        W, b, F = (self._symbols[name] for name in "WbF")
        n, normals, unknown = len(self.interfaces), self._normals(), self.model.rigid
        normal, tangent = self._at.normal, self._at.tangent
        friction = sp.Matrix(list(F)[self._at.tangentials])
        if not unknown:
            yield self._friction([lambda i: normals[i]], friction)
            return
        # F_t = X_0 + Σ X_u F_nu: the friction of the given forces, and that of one unit of each.
        X, Y = (
            sp.Matrix(
                n, 1 + len(unknown), lambda i, j, x=x: sp.Symbol(f"{x}_{i + 1}_{j}", real=True)
            )
            for x in "XY"
        )
        columns: list[Callable[[int], sp.Expr]] = [
            lambda i: _ZERO if i in unknown else normals[i],
            *(partial(_unit, u) for u in unknown),
        ]
        yield self._friction(columns, X)
        alone = [_ZERO if i in unknown else normals[i] for i in range(n)]
        load = [
            b[normal(u)]
            + sum(
                W[normal(u), normal(j)] * alone[j] + W[normal(u), tangent(j)] * X[j, 0]
                for j in range(n)
            )
            for u in unknown
        ]
        if len(unknown) == n:
            # What friction of rigid contacts alone is not determined does nothing to g̈_N.
            yield self._closed(X, load, {u: normals[u] for u in unknown})
            yield self._friction([lambda i: normals[i]], friction)
            return
        first, rest = (
            {u: sp.Symbol(f"{name}_{u + 1}", real=True) for u in unknown}
            for name in ("first", "rest")
        )
        yield self._closed(X, load, first)

        def of_first(i: int) -> sp.Expr:
            return first.get(i, normals[i])

        shared = sp.Matrix(n, 1, lambda i, _: sp.Symbol(f"shared_{i + 1}", real=True))
        yield self._friction([of_first], shared)
        yield self._friction(columns, Y, self._capacities(of_first))
        other = shared - X * sp.Matrix([1, *first.values()])
        load = [
            self._several_stick * sum(W[normal(u), tangent(j)] * other[j] for j in range(n))
            for u in unknown
        ]
        yield self._closed(Y, load, rest)
        change = Y * sp.Matrix([0, *rest.values()])
        for u in unknown:
            yield Definition(normals[u], first[u] + rest[u])
        yield from _defined(friction, shared + change)

    def _closed(
        self, X: sp.Matrix, load: list[sp.Expr], unknowns: dict[int, sp.Symbol]
    ) -> LinearSystem:
        """Return the normal forces, with their friction X, that make up for a load of g̈_N."""
        W, n, size = self._symbols["W"], len(self.interfaces), len(unknowns)
        normal, tangent = self._at.normal, self._at.tangent
        matrix, right = sp.zeros(size, size), sp.zeros(size, 1)
        for row, u in enumerate(unknowns):
            c = self._forces[u].closed
            for column, v in enumerate(unknowns):
                share = W[normal(u), normal(v)] + sum(
                    W[normal(u), tangent(j)] * X[j, 1 + column] for j in range(n)
                )
                matrix[row, column] = c * share
            matrix[row, row] += (1 - c) * W[normal(u), normal(u)]
            right[row] = -c * load[row]
        scales = tuple(W[normal(u), normal(u)] for u in unknowns)
        values = sp.Matrix(list(unknowns.values()))
        return LinearSystem(values, matrix, right, scales=scales, determinant=_DETERMINANT)

    def _motion(self, i: int, *, resolved: bool = False) -> ContactMotion:
        own = self._symbols
        W, b, F, moved = own["W"], own["b"], own["F"], own["acceleration"]
        if resolved:
            F, moved = own["resolved"], own["resolved_acceleration"]
        n, t = self._at.normal(i), self._at.tangent(i)

        def size(row: int) -> sp.Expr:
            parts = [sp.Abs(W[row, j] * F[j], evaluate=False) for j in range(F.rows)]
            return sp.Add(*parts, sp.Abs(b[row]))

        forces = sp.Add(*[sp.Abs(f) for f in F], sp.Abs(b[n]) / W[n, n])
        values = F[n], F[t], moved[n], moved[t], forces, size(n), size(t), W[n, n]
        return ContactMotion(*values, sp.Add(*[f**2 for f in F]))

    # ---- the automaton ----

    def _field(self) -> dict[sp.Symbol, sp.Expr]:
        own = self._symbols
        F, moved = own["F"], own["acceleration"]
        rates = self.motion_rates(own["a"] + own["D"] * F, F)
        friction = lost = _ZERO
        for i, c in enumerate(self._forces):
            n, t, row = self._at.normal(i), self._at.tangent(i), c.contact.row
            moves = c.apart * (1 - self._kept(i))
            rates[row.gap] = moves * row.gap_rate
            rates[row.gap_rate] = moves * moved[n]
            rates[row.slip] = (1 - c.still) * moved[t]
            rates |= c.rates(self._motion(i))
            friction -= (1 - c.contact.sticks) * F[t] * c.rubbing_velocity(self._motion(i))
            lost += c.dissipated_power
        return rates | {FRICTION_WORK: friction, CONTACT_WORK: lost}

    def _outputs(self) -> dict[str, sp.Expr]:
        stored = sp.Add(*[c.stored_energy for c in self._forces])
        own = {name: value for c in self._forces for name, value in c.outputs.items()}
        return self.outputs_of(self._symbols["F"], stored) | own

    def _modes(self) -> tuple[Mode, ...]:
        rigid = self.model.rigid
        changes = [t for i, c in enumerate(self.interfaces) for t in c.transitions(self._motion(i))]
        tests = [
            t
            for i, c in enumerate(self.interfaces)
            for t in c.tests(self._motion(i, resolved=True))
        ]
        if len(rigid) == 2:
            # Where both stick and rigidity leaves their forces open, no forces are those.
            both = sp.Mul(*[self._forces[i].holds for i in rigid])
            tests.append(Test(both * (sp.Abs(_DETERMINANT) - SINGULAR_MARGIN), both))
        for contacts in self._holding_a_guide():
            # Rigidity leaves the force of the guide open: where it may rest, one of them does.
            stick = sp.Mul(*[self._forces[i].holds for i in contacts])
            tests.append(Test(-stick, stick))
        if rigid:
            # Of slips with several solutions: it has the sign of A where there is one contact.
            tests.append(Test(_DETERMINANT, sp.Integer(1), TestRole.RANKS))
            margin = _DETERMINANT**2 - SINGULAR_MARGIN**2
            changes.append(
                Transition("singular", EventKind.SINGULAR, margin, stop=StopReason.SINGULAR)
            )
        changes += self.domain_ends
        motion = Mode(MOTION, self._field(), tuple(changes), self._outputs(), tuple(tests))
        begin: dict[sp.Symbol, sp.Expr] = {}
        for i, c in enumerate(self.interfaces):
            begin |= c.begin(self._motion(i))
        follow = (Choice(CONTACT if rigid else MOTION),)
        start = Transition(START, EventKind.CONTACT, None, follow, begin, chooses=not rigid)
        modes = [motion]
        if self._starts_with_memory:
            modes.append(Mode(START, {}, (start,), self._outputs()))
        if rigid:
            modes.append(Mode(CONTACT, {}, self._decision(), self._outputs()))
        return tuple(modes)

    def _kept(self, i: int) -> sp.Expr:
        """Return 1 where other closed contacts keep a gap, else 0: it has not even rounding."""
        at = self._at
        others = {at.normal(j): self._forces[j].closed for j in self.model.rigid if j != i}
        sets = self._spanning(list(others), at.normal(i))
        return 1 - sp.Mul(*[1 - sp.Mul(*[others[row] for row in rows]) for rows in sets])

    def _holding_a_guide(self) -> list[tuple[int, ...]]:
        """Return sets of contacts that hold, where all stick, what a guide holds."""
        at, n = self._at, len(self.rows)
        tangents = [at.tangent(i) for i in range(n)]
        sets = (
            s
            for i in self.model.of_kind(ContactKind.GUIDE)
            for s in self._spanning(tangents, at.normal(i))
        )
        return [tuple(tangents.index(row) for row in rows) for rows in dict.fromkeys(sets)]

    def _spanning(self, rows: Sequence[int], target: int) -> list[tuple[int, ...]]:
        """Return the least sets of rows of contacts that another row depends on in any state."""
        J, sets = self._directions, list[tuple[int, ...]]()
        for size in range(1, len(rows) + 1):
            for chosen in itertools.combinations(rows, size):
                ranks = (
                    np.linalg.matrix_rank(J[[*r]], tol=1e-9) for r in (chosen, (*chosen, target))
                )
                if not any({*s} <= {*chosen} for s in sets) and [*ranks] == [size, size]:
                    sets.append(chosen)
        return sets

    @cached_property
    def _directions(self) -> Array:
        """The rows J of the contacts at numbers without a relation."""
        rows = [m for row in self.rows for m in (row.contact.J_N, row.contact.J_T)]
        symbols = sorted({s for m in rows for s in m.free_symbols}, key=str)
        chosen = np.random.default_rng(0).uniform(0.3, 1.2, len(symbols))
        point = {s: sp.Float(v) for s, v in zip(symbols, chosen.tolist(), strict=True)}
        return np.array([[float(e) for e in m.xreplace(point)] for m in rows])

    @property
    def _starts_with_memory(self) -> bool:
        """Whether some contact takes up its local mode before any is decided."""
        return len(self.model.rigid) < len(self.interfaces)

    def _decision(self) -> tuple[Transition, ...]:
        """Return the impact where a closed contact approaches, else the contact problem."""
        rigid = [self.interfaces[i].row for i in self.model.rigid]
        approaching = [zero_factor(row.gap) * sp.Min(row.gap_rate, 0) for row in rigid]
        again, follows = (Choice(CONTACT),), (Choice(MOTION),)
        impact = Transition("impact", EventKind.IMPACT, sp.Add(*approaching), again, strikes=True)
        decide = Transition("decide", EventKind.CONTACT, None, follows, chooses=True)
        return impact, decide

    @cached_property
    def impulses(self) -> tuple[sp.Symbol, ...]:
        """Memory of the impulses P_n, P_t of each contact in the last impact; N s."""
        if not self.model.rigid:
            return ()
        names = ("normal_impulse", "tangential_impulse")
        return tuple(sp.Symbol(f"{n}_{row.name}", real=True) for row in self.rows for n in names)

    @property
    def impacts(self) -> Impacts | None:
        """Impacts of the rigid contacts; None where there is none."""
        if not self.model.rigid:
            return None
        has_law = self.model.of_kind(ContactKind.RIGID)
        own, given, rigid = self._symbols, self.contact_set, self.model.rigid_law
        return Impacts(
            rigid=self.model.rigid,
            bilateral=self.model.of_kind(ContactKind.GUIDE),
            contacts=tuple((r.gap, r.gap_rate, r.slip) for r in self.rows),
            velocities=tuple(self.mechanism.system.q_dot),
            works=(
                CONTACT_WORK,
                FRICTION_WORK,
                FORCE_WORK if FORCE_WORK in self.dissipations else None,
            ),
            impulses=self.impulses,
            mobility=own["W"],
            load=own["b"],
            directions=own["D"],
            friction=tuple(given.mu),
            drive_speeds=self.mechanism.drive_speeds,
            contact_velocity=tuple(
                v for r in self.rows for v in (r.contact.gap_rate, r.contact.slip_velocity)
            ),
            restitution=rigid.restitution,
            # Guides alone, or among compliant contacts, have no law: nothing approaches them.
            coefficient=rigid.parameters[0].symbol if has_law else _ZERO,
            target=CONTACT,
        )

    @cached_property
    def automaton(self) -> HybridAutomaton:
        """The automaton, validated."""
        names = dict.fromkeys(law.name for law in self.model.own_laws)
        first = START if self._starts_with_memory else CONTACT
        policy = self.model.rigid_law.policy
        return self.automaton_of(
            f" with {', '.join(names)}",
            self._modes(),
            (Choice(first),),
            memory=(*(s for c in self.interfaces for s in c.memory), *self.impulses),
            terms=self.terms,
            parts=tuple(c.part for c in self.interfaces),
            preference={"liftoff": 1, "slip": -1, "impact": 0}[policy],
            impacts=self.impacts,
        )


_DETERMINANT = sp.Symbol("determinant", real=True)


def _defined(symbols: Iterable[sp.Symbol], values: Iterable[sp.Expr]) -> list[Definition]:
    return [Definition(*pair) for pair in zip(symbols, values, strict=True)]


def _unit(contact: int, i: int) -> sp.Expr:
    """Return 1 for the contact itself, else 0."""
    return sp.Integer(1) if i == contact else _ZERO
