"""The automaton of a mechanism with several contacts, whose local modes are data.

A literal product of the local modes of n contacts has as many modes as their numbers multiplied
(121 for two contacts under the bilinear law). Here the motion is one mode: what each contact does
is memory, 0 or 1 or a sign, by which forces and guards are switched. An event changes the memory of
its contact; where contacts must find what follows, every combination of their alternatives is held
against the inequalities of its contact problem and their derivatives along its own motion.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

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
from painleve_sym.automata.compliant import CompliantContact, CompliantInterface
from painleve_sym.automata.contact_forces import ContactMotion, Forces
from painleve_sym.automata.contact_states import (
    CONTACT_WORK,
    FORCE_WORK,
    FRICTION_WORK,
    SINGULAR_MARGIN,
    ContactStates,
)
from painleve_sym.automata.guide import BilateralContact, GuideInterface
from painleve_sym.automata.interfaces import Interface, zero_factor
from painleve_sym.automata.model import CONTACT, MOTION, START
from painleve_sym.automata.preparation import motion_steps
from painleve_sym.automata.rigid import RigidContact, RigidInterface
from painleve_sym.automata.tangential_spring import SpringInterface, TangentialSpringContact
from painleve_sym.choices import ImpactFriction
from painleve_sym.contact_rows import ContactRows
from painleve_sym.errors import EventKind, StopReason
from painleve_sym.laws.contact_kind import ContactKind
from painleve_sym.mechanics.contact_set import ContactSet
from painleve_sym.mechanics.solved import solved_motion

_ZERO, _ONE = sp.Integer(0), sp.Integer(1)


INTERFACES: dict[ContactKind, type[Interface]] = {
    ContactKind.GUIDE: GuideInterface,
    ContactKind.RIGID: RigidInterface,
    ContactKind.COMPLIANT: CompliantInterface,
    ContactKind.SPRING: SpringInterface,
}
"""The interface of each kind of contact: its memory, forces and transitions."""

ALONE: dict[ContactKind, type[ContactStates]] = {
    ContactKind.GUIDE: BilateralContact,
    ContactKind.RIGID: RigidContact,
    ContactKind.COMPLIANT: CompliantContact,
    ContactKind.SPRING: TangentialSpringContact,
}
"""Faster builders for an only contact, whose local modes are modes of the automaton."""


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
        at, nq = self._at, len(self.mechanism.system.q)
        W = _named("W", at.size, at.size)
        own = {
            "W": sp.Matrix(at.size, at.size, lambda i, j: W[min(i, j), max(i, j)]),
            "D": _named("D", nq, at.size),
            "a": _named("a", nq),
        }
        own |= {x: _named(x, at.size) for x in ("b", "F", "acceleration")}
        own |= {x: _named(x, at.size) for x in ("resolved", "resolved_acceleration")}
        rows = {"n": [*range(at.size)[at.normals]], "t": [*range(at.size)[at.tangentials]]}
        blocks = {f"W_{r}{c}": own["W"].extract(rows[r], rows[c]) for r, c in ("nn", "nt", "tt")}
        parts = {f"{x}_{r}": own[x][rows[r], :] for x in ("b", "F", "resolved") for r in "nt"}
        return own | blocks | parts

    def _friction(
        self, normals: sp.Matrix, unknowns: sp.Matrix, weights: tuple[sp.Expr, ...] = ()
    ) -> LinearSystem:
        """Return the tangential forces: v̇_t = 0 where a contact sticks, −μ s F_n where it slips.

        A column of `normals` has the normal forces of all contacts, for one right side. The first
        also has the free accelerations and the forces of springs. Friction that is not determined
        is shared by `weights`: without them equally, of a single column by capacity.
        """
        own, n, forces = self._symbols, normals.rows, self._forces
        sticks = [c.holds for c in forces]
        slides, mobilities = zip(*map(self._slides, range(n)), strict=True)
        slip = sp.Matrix(n, normals.cols, lambda i, k: forces[i].known_friction(normals[i, k]))
        slip[:, 0] += sp.Matrix([c.spring_force for c in forces])
        pull = own["W_nt"].T * normals + own["W_tt"] * slip
        pull[:, 0] += own["b_t"]
        matrix = sp.Matrix(n, n, lambda i, j: sticks[i] * sticks[j] * own["W_tt"][i, j])
        right = sp.zeros(n, normals.cols)
        for i, (stick, mobility) in enumerate(zip(sticks, mobilities, strict=True)):
            matrix[i, i] = mobility
            right[i, :] = (1 - stick) * mobility * slip[i, :] - stick * slides[i] * pull[i, :]
        if normals.cols == 1:
            weights = self._capacities(normals)
        return LinearSystem(unknowns, matrix, right, weights=weights)

    def _slides(self, i: int) -> tuple[sp.Expr, sp.Expr]:
        """Return 1 where some motion slides a contact, else 0, and W_tt there, else 1.

        Where no motion does, W_tt = 0, and the friction that sticking needs is 0.
        """
        t = self._at.tangent(i)
        symbol = self._symbols["W"][t, t]
        if solved_motion(self.mechanism):
            return _ONE, symbol
        own = self.contact_set.W[t, t]
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

    def _capacities(self, normals: sp.Matrix) -> tuple[sp.Expr, ...]:
        """Return the friction that sticking contacts can bear: weights of friction not determined.

        Those that slip have a force of their own, and the sum of the capacities as their weight.
        Nothing is shared where fewer than two contacts stick: there the weight is 1 for all, so
        that no force is divided by a normal force that may vanish.
        """
        sticks = [c.holds for c in self._forces]
        limits = [c.holds * c.capacity(normals[i]) for i, c in enumerate(self._forces)]
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
            Definition(force, c.given)
            for force, c in zip(own["F_n"], self._forces, strict=True)
            if c.given is not None
        )
        motion = motion_steps(self.mechanism) or (
            *_defined(own["a"], self.mechanism.system.free_acceleration),
            *_defined(own["D"], given.directions),
            *(Definition(W[i, j], given.W[i, j]) for i in range(size) for j in range(i, size)),
            *_defined(own["b"], given.b),
        )
        return (
            *motion,
            *laws,
            *self._closing(),
            *_defined(own["acceleration"], W * F + own["b"]),
            *self._resolved_terms(),
        )

    def _resolved_terms(self) -> Iterator[Definition | LinearSystem]:
        """Yield forces and accelerations that tests take; see `Forces.resolved`."""
        own, normals = self._symbols, self._symbols["F_n"]
        total = sp.Add(*[sp.Abs(force) for force in normals])
        each = zip(own["resolved_n"], self._forces, normals, strict=True)
        yield from (Definition(symbol, c.resolved(force, total)) for symbol, c, force in each)
        yield self._friction(own["resolved_n"], own["resolved_t"])
        yield from _defined(own["resolved_acceleration"], own["W"] * own["resolved"] + own["b"])

    def _closing(self) -> Iterator[Definition | LinearSystem]:
        """Yield the forces N of rigid contacts, which keep g̈_N = 0, and the friction T of all.

        Friction is affine in N: T = X_0 + X N, where X_0 is that under the forces P of compliant
        contacts. With it 0 = b_n + W_nP P + W_nn N + W_nt T gives N (`_closed`):

            (W_nn + W_nt X) N = −(b_n + W_nP P + W_nt X_0)

        Friction that v̇_t = 0 leaves open accelerates no gap, as W is semidefinite: contacts share
        it by their capacities under N. Beside compliant contacts, whose capacity may all but
        vanish, such shares T′ are not exact. Forces M with friction Y M of the same shares make up
        for what they accelerate, and the forces are N + M and T′ + Y M:

            (W_nn + W_nt Y) M = −W_nt (T′ − X_0 − X N)
        """
        own, rigid = self._symbols, [*self.model.rigid]
        normals, friction, n, m = own["F_n"], own["F_t"], len(self.interfaces), len(rigid)
        if not rigid:
            yield self._friction(normals, friction)
            return
        units = sp.eye(n)[:, rigid]
        given = sp.Matrix([_ZERO if i in rigid else force for i, force in enumerate(normals)])
        columns = given.row_join(units)
        X, Y = (sp.Matrix(n, 1 + m, lambda i, j, x=x: _real(f"{x}_{i + 1}_{j}")) for x in "XY")
        yield self._friction(columns, X)
        load = own["b_n"] + own["W_nn"] * given + own["W_nt"] * X[:, 0]
        if m == n:
            yield self._closed(X, load, normals)
            yield self._friction(normals, friction)
            return
        first, rest = (sp.Matrix([_real(f"{x}_{u + 1}") for u in rigid]) for x in ("first", "rest"))
        yield self._closed(X, load, first)
        at_first = given + units * first
        shared = sp.Matrix([_real(f"shared_{i + 1}") for i in range(n)])
        yield self._friction(at_first, shared)
        yield self._friction(columns, Y, self._capacities(at_first))
        moved = own["W_nt"] * (shared - X * sp.Matrix([1, *first]))
        yield self._closed(Y, self._several_stick * moved, rest)
        yield from _defined(normals[rigid, :], first + rest)
        yield from _defined(friction, shared + Y[:, 1:] * rest)

    def _closed(self, X: sp.Matrix, load: sp.Matrix, unknowns: sp.Matrix) -> LinearSystem:
        """Return the normal forces, with their friction X, that make up for a load of g̈_N."""
        own, rigid = self._symbols, [*self.model.rigid]
        closed = sp.diag(*[self._forces[u].closed for u in rigid])
        W_nn = own["W_nn"].extract(rigid, rigid)
        scales, whole = sp.diag(*W_nn.diagonal()), W_nn + own["W_nt"][rigid, :] * X[:, 1:]
        return LinearSystem(
            unknowns,
            closed * whole + (sp.eye(len(rigid)) - closed) * scales,
            -closed * load[rigid, :],
            scales=tuple(W_nn.diagonal()),
            determinant=_DETERMINANT,
        )

    def _motion(self, i: int, *, resolved: bool = False) -> ContactMotion:
        own = self._symbols
        W, b, F, moved = own["W"], own["b"], own["F"], own["acceleration"]
        if resolved:
            F, moved = own["resolved"], own["resolved_acceleration"]
        n, t = self._at.normal(i), self._at.tangent(i)

        def size(row: int) -> sp.Expr:
            parts = [sp.Abs(W[row, j] * F[j], evaluate=False) for j in range(F.rows)]
            return sp.Add(*parts, sp.Abs(b[row]))

        return ContactMotion(
            normal_force=F[n],
            tangential_force=F[t],
            normal_acceleration=moved[n],
            tangential_acceleration=moved[t],
            force_scale=sp.Add(*[sp.Abs(f) for f in F], sp.Abs(b[n]) / W[n, n]),
            normal_scale=size(n),
            tangential_scale=size(t),
            normal_mobility=W[n, n],
            force_square=sp.Add(*[f**2 for f in F]),
        )

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
        changes += self.domain_ends(*(c.sign for c in self.interfaces))
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
        """Return sets of contacts whose slip rows span the gap row of a guide."""
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
        guard, kind = sp.Add(*approaching), EventKind.IMPACT
        if all(self.interfaces[i].is_coulomb for i in self.model.rigid):
            impact = Transition("impact", kind, guard, again, strikes=True)
        else:
            impact = Transition("impact", kind, guard, stop=StopReason.VARYING_FRICTION)
        decide = Transition("decide", EventKind.CONTACT, None, follows, chooses=True)
        return impact, decide

    @cached_property
    def impulses(self) -> tuple[sp.Symbol, ...]:
        """Memory of the impulses P_n, P_t of each contact in the last impact; N s."""
        if not self.model.rigid:
            return ()
        names = ("normal_impulse", "tangential_impulse")
        return tuple(_real(f"{n}_{row.name}") for row in self.rows for n in names)

    @property
    def impacts(self) -> Impacts | None:
        """Impacts of the rigid contacts; None where there is none."""
        if not self.model.rigid:
            return None
        own, rigid = self._symbols, self.model.rigid_law
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
            friction=tuple(c.static_coefficient for c in self.interfaces),
            drive_speeds=self.mechanism.drive_speeds,
            contact_velocity=tuple(
                v for r in self.rows for v in (r.contact.gap_rate, r.contact.slip_velocity)
            ),
            restitution=rigid.restitution,
            # A guide has none: nothing approaches it.
            coefficients=tuple(
                law.parameters[0].symbol if law.kind is ContactKind.RIGID else _ZERO
                for law in (self.model.own_laws[i] for i in self.model.rigid)
            ),
            target=CONTACT,
            final_slip=rigid.impact_friction is ImpactFriction.FINAL_SLIP,
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
            parts=tuple(c.part for c in self.interfaces),
            preference={"liftoff": 1, "slip": -1, "impact": 0}[policy],
            impacts=self.impacts,
        )


_DETERMINANT = sp.Symbol("determinant", real=True)


def _defined(symbols: Iterable[sp.Symbol], values: Iterable[sp.Expr]) -> list[Definition]:
    return [Definition(*pair) for pair in zip(symbols, values, strict=True)]


def _real(name: str) -> sp.Symbol:
    return sp.Symbol(name, real=True)


def _named(letter: str, rows: int, columns: int = 1) -> sp.Matrix:
    return sp.Matrix(rows, columns, lambda i, j: _real(f"{letter}_{i + 1}_{j + 1}"))
