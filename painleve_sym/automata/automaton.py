"""Hybrid automata: modes with fields, guarded transitions with resets, all symbolic."""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp
from sympy.logic.boolalg import Boolean

from painleve_sym.equality import Compared
from painleve_sym.errors import EventKind, StopReason, refuse_faulty, repeated, unknown_name
from painleve_sym.escape import c_name, dot_string, mermaid_string
from painleve_sym.hooks import upper


def positive(expr: sp.Expr) -> Boolean:
    """Return expr > 0, unevaluated: whether a long formula is positive takes SymPy minutes."""
    return sp.Gt(expr, 0, evaluate=False)


def all_positive(*exprs: sp.Expr) -> Boolean:
    """Return whether every one of the expressions is > 0, unevaluated."""
    return sp.And(*map(positive, exprs))


def is_zero(expr: sp.Expr) -> Boolean:
    """Return expr = 0, unevaluated."""
    return sp.Eq(expr, 0, evaluate=False)


def least(*formulas: sp.Expr) -> sp.Expr:
    """Return the least of formulas, unevaluated: positive where every one is."""
    return sp.Min(*_opened(sp.Min, formulas), evaluate=False)


def greatest(*formulas: sp.Expr) -> sp.Expr:
    """Return the greatest of formulas, unevaluated: positive where any one is."""
    return sp.Max(*_opened(sp.Max, formulas), evaluate=False)


def _opened(kind: type[sp.Expr], formulas: tuple[sp.Expr, ...]) -> list[sp.Expr]:
    """Return the arguments with nested extremes of the same kind opened."""
    return [part for f in formulas for part in (f.args if isinstance(f, kind) else (f,))]


Reset = Mapping[sp.Symbol, sp.Expr]
"""Simultaneous assignment to states and memory; what is absent is kept."""


@dataclass(frozen=True)
class Choice:
    """A possible target of a transition; the first whose `condition` holds is taken.

    The condition is in the state before the reset; None admits always (must be the last choice).
    `departs` has labels of guards of the target that are zero on entry and known to become
    positive.
    """

    target: str
    condition: Boolean | None = None
    departs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Accumulation:
    """Continuation after transitions that repeat ever faster up to a limit time.

    It is entered when the transition has come so close to that time that the rest is below
    round-off, and what the reset changes is below round-off of the states. The event that the limit
    is has this kind; the target is the mode entered.
    """

    kind: EventKind
    target: str
    reset: Reset


@dataclass(frozen=True)
class Transition:
    """An event: `guard` crosses from + to −, `reset` applies, one of `choices` is entered.

    Attributes
    ----------
    label : str
        Unique in its mode.
    kind : EventKind
        What users see.
    guard : sympy.Expr or None
        In states, memory, parameters and definitions. None for an `immediate` transition: it
        happens as soon as its mode is entered, unless one of the guards before it fires first.
    choices : tuple of Choice
        Empty for a transition that ends the run with `stop`.
    reset : mapping of symbol to sympy.Expr
    stop : StopReason or None
    contact : str
        Name of the contact; empty where it concerns no single one.
    bound : int or None
        Index of the bound of the mechanism's domain whose margin the guard is.
    on_accumulation : Accumulation or None
        None: a run ends where its events accumulate.
    chooses : bool
        Whether the parts of the automaton choose their local modes after the reset: a combination
        of alternatives that satisfies the tests of the target. Where there is none, the contacts
        have an impact or, without `HybridAutomaton.impacts`, the run ends.
    strikes : bool
        Whether the contacts of `HybridAutomaton.impacts` have an impact there; its only choice
        names the mode that follows.
    watches : bool
        Whether it only looks at the motion: then it is not recorded at the start of a run, and does
        not accumulate.
    silent : bool
        Whether it is never an event.
    """

    label: str
    kind: EventKind
    guard: sp.Expr | None
    choices: tuple[Choice, ...] = ()
    reset: Reset = dataclasses.field(default_factory=dict)
    stop: StopReason | None = None
    contact: str = ""
    bound: int | None = None
    on_accumulation: Accumulation | None = None
    chooses: bool = False
    strikes: bool = False
    watches: bool = False
    silent: bool = False

    def __repr__(self) -> str:
        """Return the label and the modes that may be entered in one line."""
        targets = dict.fromkeys(target for _, target in self.edges)
        return f"Transition {self.label!r} to {', '.join(targets) or 'the end of the run'}"

    @property
    def immediate(self) -> bool:
        """Whether it happens on entry of its mode."""
        return self.guard is None

    @property
    def edges(self) -> tuple[tuple[EventKind, str], ...]:
        """Kind of event and mode entered, for each choice and for the limit of an accumulation."""
        limit = self.on_accumulation
        beyond = [] if limit is None else [(limit.kind, limit.target)]
        return (*((self.kind, c.target) for c in self.choices), *beyond)


MOST_TRANSITIONS = 64
"""Of a mode: the engines keep one bit for each."""


@dataclass(frozen=True)
class Definition:
    """An abbreviation: `symbol` stands for `expression` of states, memory and parameters."""

    symbol: sp.Symbol
    expression: sp.Expr

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """All symbols that it defines."""
        return (self.symbol,)

    @property
    def needs(self) -> set[sp.Symbol]:
        """All symbols that it is made of."""
        return _symbols([self.expression])


@dataclass(frozen=True)
class LinearSystem:
    """Symbols that stand for the solution of ``matrix · unknowns = right``.

    Either symmetric and semidefinite, where `weights` or several right sides are given, or general.

    `weights` is None for a general matrix. Else the matrix is symmetric and positive semidefinite,
    with a positive diagonal; where it is singular, the solution of least norm is taken, each
    unknown measured by the root of its entry there (empty: all alike). Of a general matrix `scales`
    are the size of each row and column, positive, and `determinant` stands for that of unit scales.
    """

    unknowns: sp.Matrix
    matrix: sp.Matrix
    right: sp.Matrix
    weights: tuple[sp.Expr, ...] | None = None
    scales: tuple[sp.Expr, ...] = ()
    determinant: sp.Symbol | None = None

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """All symbols that it defines."""
        return (*self.unknowns, *(() if self.determinant is None else (self.determinant,)))

    @property
    def needs(self) -> set[sp.Symbol]:
        """All symbols that it is made of."""
        return _symbols([*self.matrix, *self.right, *(self.weights or ()), *self.scales])


@dataclass(frozen=True)
class Alternative:
    """A local mode that a part of the system may enter when a transition chooses.

    The condition tells where it may be entered. New values of the memory are those of that part;
    what is absent is kept. `open` tells whether it is counted as open, where a policy prefers many
    or few open parts; `preferred` whether it is entered where others are possible, too: stick under
    a static friction above the kinetic one. After the policy, most preferred alternatives decide.
    `rest_of` makes it what the alternative of that index becomes where it is idle: it rests with
    its force at a bound, as others hold it.
    """

    condition: Boolean
    memory: Mapping[sp.Symbol, sp.Expr] = dataclasses.field(default_factory=dict)
    open: bool = False
    preferred: bool = False
    rest_of: int | None = None


class TestRole(enum.StrEnum):
    """Role of a test, by the letter that the compiled engine reads."""

    HOLDS = "h"
    """The value is not negative."""
    BEGINS = "b"
    """Not negative either; where it stays 0, what should begin does not: the mode is idle."""
    VANISHES = "v"
    """The value stays 0."""
    RANKS = "r"
    """No inequality: a policy that prefers many open parts prefers a positive value, too, one that
    prefers few a negative one."""


@dataclass(frozen=True)
class Test:
    """An inequality of a local mode: `value` ≥ 0 just after a decision.

    Where the value is 0 but for rounding, its first derivative along the motion that is not
    decides. `scale` is the size of the terms of which it is made, 0 where the test says nothing.
    """

    value: sp.Expr
    scale: sp.Expr
    role: TestRole = TestRole.HOLDS


@dataclass(frozen=True)
class Part:
    """A part of the system, such as one contact, whose local mode is data: its memory.

    The first entry of its own memory holds the index of its local mode. The alternatives are tried
    in their order after a transition that chooses; `rest` are states that then count as 0 where
    they are 0 within the tolerance. `leaving` has labels of guards that leave 0 upwards after a
    choice, whatever rounding says.

    `variants` are values of its memory for which functions of their own are generated, the most
    frequent first: constants, or what follows from memory that is absent, which may have any value.
    The first that agrees is taken. They change results by rounding only.
    """

    name: str
    memory: tuple[sp.Symbol, ...]
    local_modes: tuple[str, ...]
    alternatives: tuple[Alternative, ...]
    rest: tuple[sp.Symbol, ...] = ()
    leaving: tuple[str, ...] = ()
    variants: tuple[Mapping[sp.Symbol, sp.Expr], ...] = ()


@dataclass(frozen=True)
class Impacts:
    """Simultaneous impacts of rigid contacts at frozen coordinates; rows are n1, t1, n2, t2, ….

    Contacts with gap ≤ 0 and gap rate ≤ 0 have one where a transition `Transition.strikes`, or
    where none of the combinations that a transition chooses from is possible; the mode `target`
    follows.

    `rigid` are the indices of the contacts that take part (the other ones only change their
    velocities), `bilateral` those of them that hold from both sides, and `contacts` the states of
    every contact: gap, gap rate and slip velocity. The `velocities` are the generalised ones,
    length nq. From the `works` those of the normal impulses, of the tangential impulses, and of
    what drives the surfaces are subtracted; None for no such state. `impulses` are memory of the
    last impact, length 2 n; N s.

    Shapes are (2 n, 2 n) of the mobility, 1/kg, (2 n, 1) of the load, the accelerations without
    contact forces, m/s², (nq, 2 n) of the directions, the change of the generalised velocities by
    each impulse, (n,) of the friction, and (2 n,) of the speeds of the surfaces and of the
    `contact_velocity`, that of the contacts as the generalised velocities give it; m/s. The
    `coefficients` are those of restitution, one for each of the `rigid`. Friction opposes the slip
    after the impact where it is by the `final_slip`, else that of each moment.
    """

    rigid: tuple[int, ...]
    bilateral: tuple[int, ...]
    contacts: tuple[tuple[sp.Symbol, sp.Symbol, sp.Symbol], ...]
    velocities: tuple[sp.Symbol, ...]
    works: tuple[sp.Symbol, sp.Symbol, sp.Symbol | None]
    impulses: tuple[sp.Symbol, ...]
    mobility: sp.Matrix
    load: sp.Matrix
    directions: sp.Matrix
    friction: tuple[sp.Expr, ...]
    drive_speeds: tuple[sp.Expr, ...]
    contact_velocity: tuple[sp.Expr, ...]
    restitution: str
    coefficients: tuple[sp.Expr, ...]
    target: str
    final_slip: bool = False

    kinds = (EventKind.IMPACT, EventKind.SETTLE)
    """Kinds of its events: an impact, and the end of bounces that have died out."""


@dataclass(frozen=True)
class Preparation:
    """Start of a run: the whole start state, and the scale of every state.

    The others of the automaton's states follow from those `given`, its first. `force` is the
    initial one of the only contact, N; negative where none is given. `states` are in given states,
    parameters, definitions and the force; what is absent keeps its given value, or is 0.

    `admits` are 1 or 0: whether the contact laws admit the start, whether every definition is
    finite, and whether the start is inside the domain. `scales`, in states, parameters and
    definitions, are of every state: below them only the absolute error counts, and oo leaves a
    state out of the step control. All these formulas may use the `terms`, each in terms of those
    before it.
    """

    given: tuple[sp.Symbol, ...]
    force: sp.Symbol
    states: Mapping[sp.Symbol, sp.Expr]
    admits: tuple[sp.Expr, ...]
    scales: Mapping[sp.Symbol, sp.Expr]
    terms: tuple[Definition, ...] = ()


@dataclass(frozen=True)
class Mode:
    """A smooth regime.

    `field` has time derivatives; states that are absent are constant. At most one transition is
    immediate, and that is the last. Outputs are derived from the state (forces, energies), with the
    same names in every mode. A combination of alternatives must satisfy the tests to be entered.
    """

    name: str
    field: Mapping[sp.Symbol, sp.Expr]
    transitions: tuple[Transition, ...]
    outputs: Mapping[str, sp.Expr] = dataclasses.field(default_factory=dict)
    tests: tuple[Test, ...] = ()

    def __repr__(self) -> str:
        """Return the name and the labels of the transitions in one line."""
        return f"Mode {self.name!r}: transitions {', '.join(t.label for t in self.transitions)}"


@dataclass(frozen=True, eq=False)
class HybridAutomaton(Compared):
    """States, memory and modes of a system that switches.

    Parameters
    ----------
    name : str
    states : tuple of sympy.Symbol
        Integrated quantities.
    memory : tuple of sympy.Symbol
        Constants within a mode, changed by resets only.
    parameters : tuple of sympy.Symbol
    definitions : mapping of symbol to sympy.Expr
        Constants computed once from parameters, in order.
    modes : tuple of Mode
    starts : tuple of Choice
        Choices of the mode of a start state; the immediate transitions of that mode apply next.
    terms : tuple of Definition or LinearSystem
        Abbreviations that every expression may use, each in terms of those before it.
    parts : tuple of Part
        Parts whose local modes are data; they own the memory but for that of `impacts`, which
        comes after theirs.
    preference : int
        Which of several motions a decision takes: 1 the one with most open parts, -1 that with
        fewest, 0 none.
    impacts : Impacts or None
    preparation : Preparation or None
        None: whoever runs it gives whole start states and tolerances.

    Raises
    ------
    ModelError
        All faults: repeated names, unknown targets or labels, undeclared symbols, a
        missing unconditional choice, modes that cannot be reached, differing outputs.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> simulator = ps.Simulator(ps.models.rod(), ps.laws.rigid())
    >>> simulator.automaton.name
    'rod, rigid, energetic restitution'
    >>> [str(state) for state in simulator.automaton.states][:3]
    ['x_A', 'y_A', 'theta']
    """

    name: str
    states: tuple[sp.Symbol, ...]
    memory: tuple[sp.Symbol, ...]
    parameters: tuple[sp.Symbol, ...]
    definitions: Mapping[sp.Symbol, sp.Expr]
    modes: tuple[Mode, ...]
    starts: tuple[Choice, ...]
    terms: tuple[Definition | LinearSystem, ...] = ()
    parts: tuple[Part, ...] = ()
    preference: int = 1
    impacts: Impacts | None = None
    preparation: Preparation | None = None

    def __post_init__(self) -> None:
        refuse_faulty(f"automaton {self.name!r}", self._faults())

    def __repr__(self) -> str:
        """Return the name and the sizes in one line; the formulas may be long."""
        sizes = f"{len(self.states)} states, {len(self.memory)} of memory, {len(self.modes)} modes"
        return f"HybridAutomaton {self.name!r}: {sizes}"

    def casadi(self, mode: str) -> Any:
        """Return the equations of a mode as CasADi functions; see `Simulator.casadi`."""
        return upper("casadi_equations")(self, mode)

    def lambdify(self, mode: str, modules: str = "numpy") -> Any:
        """Return the equations of a mode as Python functions; see `Simulator.lambdify`."""
        return upper("lambdified_equations")(self, mode, modules)

    def _faults(self) -> Iterator[str]:
        names = [m.name for m in self.modes]
        for name in repeated(names):
            yield f"mode {name!r} is declared twice."
        for where, choices in self._choices():
            yield from self._choice_faults(where, choices, names)
        yield from self._symbol_faults()
        if self.impacts is not None and self.impacts.target not in names:
            yield "impacts: " + unknown_name("mode", self.impacts.target, names)
        for mode in self.modes:
            labels = [t.label for t in mode.transitions]
            for label in repeated(labels):
                yield f"mode {mode.name!r}: transition {label!r} is declared twice."
            for t in mode.transitions:
                limit = t.on_accumulation
                if limit is not None and limit.target not in names:
                    yield f"mode {mode.name!r}: " + unknown_name("mode", limit.target, names)
            if any(t.immediate for t in mode.transitions[:-1]):
                yield f"mode {mode.name!r}: after an immediate transition no other can happen."
            if len(mode.transitions) > MOST_TRANSITIONS:
                yield (
                    f"mode {mode.name!r}: got {len(mode.transitions)} transitions, need at most "
                    f"{MOST_TRANSITIONS}."
                )
            if self.impacts is None and any(t.strikes for t in mode.transitions):
                yield f"mode {mode.name!r}: a transition strikes, and no impacts are declared."
            if set(mode.outputs) != set(self.modes[0].outputs):
                yield f"mode {mode.name!r}: its outputs differ from those of the first mode."
        for name in sorted(set(names) - self.reachable()):
            yield f"mode {name!r} can never be reached."

    def _choices(self) -> Iterator[tuple[str, tuple[Choice, ...]]]:
        yield "start", self.starts
        for mode in self.modes:
            for t in mode.transitions:
                if t.stop is None:
                    yield f"mode {mode.name!r}, transition {t.label!r}", t.choices

    def _choice_faults(
        self, where: str, choices: tuple[Choice, ...], names: list[str]
    ) -> Iterator[str]:
        if not choices or choices[-1].condition is not None:
            yield f"{where}: the last choice must admit every state."
        for c in choices:
            if isinstance(c.condition, sp.Expr):
                yield f"{where}: got the condition {c.condition}, need a relation such as x > 0."
            if c.target not in names:
                yield f"{where}: " + unknown_name("mode", c.target, names)
                continue
            labels = [t.label for t in self.mode(c.target).transitions]
            for label in c.departs:
                if label not in labels:
                    yield f"{where}: " + unknown_name("transition", label, labels)

    def _symbol_faults(self) -> Iterator[str]:
        known = {*self.states, *self.memory, *self.parameters}
        for symbol, expr in self.definitions.items():
            yield from _undeclared(f"definition of {symbol}", [expr], known)
            known.add(symbol)
        yield from _term_faults("", self.terms, known)
        for where, exprs in self._expressions():
            for s in sorted(_symbols(exprs) - known, key=str):
                yield f"{where}: " + unknown_name("symbol", str(s), map(str, known))
        for where, symbols in self._assigned():
            for s in symbols:
                if s not in self.states and s not in self.memory:
                    yield f"{where}: reset of {s}, which is not a state."
        for mode in self.modes:
            for s in mode.field:
                if s not in self.states:
                    yield f"mode {mode.name!r}: {s} has a rate but is not a state."
        yield from self._preparation_faults()

    def _expressions(self) -> Iterator[tuple[str, list[sp.Basic]]]:
        """Yield the expressions of each place that may use every symbol."""
        yield "start", [c.condition for c in self.starts if c.condition is not None]
        for mode in self.modes:
            exprs: list[sp.Basic] = [*mode.field.values(), *mode.outputs.values()]
            exprs += [e for t in mode.tests for e in (t.value, t.scale)]
            for t in mode.transitions:
                exprs += [*([] if t.guard is None else [t.guard]), *t.reset.values()]
                exprs += [c.condition for c in t.choices if c.condition is not None]
                exprs += t.on_accumulation.reset.values() if t.on_accumulation is not None else ()
            yield f"mode {mode.name!r}", exprs
        for part in self.parts:
            parts = [e for a in part.alternatives for e in (a.condition, *a.memory.values())]
            yield f"part {part.name!r}", parts
        if (i := self.impacts) is not None:
            matrices = (i.mobility, i.load, i.directions, i.friction, i.drive_speeds)
            yield (
                "impacts",
                [*(e for m in matrices for e in m), *i.contact_velocity, *i.coefficients],
            )

    def _assigned(self) -> Iterator[tuple[str, list[sp.Symbol]]]:
        """Yield the symbols that each place gives new values."""
        for mode in self.modes:
            for t in mode.transitions:
                limit = t.on_accumulation.reset if t.on_accumulation is not None else {}
                yield f"mode {mode.name!r}, {t.label!r}", [*t.reset, *limit]
        for part in self.parts:
            own = [s for a in part.alternatives for s in a.memory]
            own += [s for values in part.variants for s in values]
            yield f"part {part.name!r}", [*part.memory, *part.rest, *own]
        if (i := self.impacts) is not None:
            own = [s for contact in i.contacts for s in contact]
            own += [*i.velocities, *i.impulses, *(work for work in i.works if work is not None)]
            yield "impacts", own

    def _preparation_faults(self) -> Iterator[str]:
        of = self.preparation
        if of is None:
            return
        known = {*self.states, of.force, *self.parameters, *self.definitions}
        yield from _term_faults("preparation, ", of.terms, known)
        exprs = [*of.states.values(), *of.admits, *of.scales.values()]
        yield from _undeclared("preparation", exprs, known)

    def mode(self, name: str) -> Mode:
        """Return the mode of that name."""
        return next(m for m in self.modes if m.name == name)

    @property
    def kinds(self) -> tuple[EventKind, ...]:
        """Kinds of events that can happen, in order of appearance.

        Those of impacts and of limits of accumulations come last.
        """
        transitions = [t for m in self.modes for t in m.transitions]
        impacts = self.impacts.kinds if self.impacts is not None else ()
        limits = [t.on_accumulation.kind for t in transitions if t.on_accumulation is not None]
        return tuple(dict.fromkeys([*(t.kind for t in transitions), *impacts, *limits]))

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the contacts that events concern, in order of appearance."""
        names = dict.fromkeys(t.contact for m in self.modes for t in m.transitions)
        return tuple(name for name in names if name)

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of the outputs, the same in every mode."""
        return tuple(self.modes[0].outputs)

    def reachable(self) -> set[str]:
        """Names of modes reachable from a start."""
        known = {m.name for m in self.modes}
        reached: set[str] = set()
        front = {c.target for c in self.starts} & known
        while front:
            reached |= front
            transitions = [t for name in front for t in self.mode(name).transitions]
            front = {target for t in transitions for _, target in t.edges} & known - reached
        return reached

    def mermaid(self) -> str:
        """Return the automaton as a Mermaid state diagram."""
        ids = {m.name: c_name(m.name) for m in self.modes}
        lines = ["stateDiagram-v2"]
        lines += [f"    state {mermaid_string(name)} as {i}" for name, i in ids.items()]
        lines += [f"    [*] --> {ids[c.target]}" for c in self.starts]
        for mode in self.modes:
            for t in mode.transitions:
                edges = [(kind, ids[target]) for kind, target in t.edges]
                edges += [(t.kind, "[*]")] if t.stop is not None else []
                lines += [f"    {ids[mode.name]} --> {target}: {kind}" for kind, target in edges]
        return "\n".join(lines) + "\n"

    def graphviz(self) -> str:
        """Return the automaton as Graphviz text."""
        lines = [f"digraph {dot_string(self.name)} {{", "    rankdir=LR;", "    node [shape=box];"]
        for mode in self.modes:
            for t in mode.transitions:
                edges = [*t.edges, *([(t.kind, "end")] if t.stop is not None else [])]
                lines += [
                    f"    {dot_string(mode.name)} -> {dot_string(x)} [label={dot_string(kind)}];"
                    for kind, x in edges
                ]
        return "\n".join([*lines, "}"]) + "\n"


def _symbols(exprs: Iterable[Any]) -> set[sp.Symbol]:
    return {s for e in exprs for s in sp.sympify(e).free_symbols}


def _undeclared(where: str, exprs: Iterable[Any], known: set[sp.Symbol]) -> Iterator[str]:
    for s in sorted(_symbols(exprs) - known, key=str):
        yield f"{where}: {s} is not declared before it."


def _term_faults(
    where: str, terms: Iterable[Definition | LinearSystem], known: set[sp.Symbol]
) -> Iterator[str]:
    """Yield undeclared symbols of terms in their order; `known` gains what they define."""
    for term in terms:
        yield from _undeclared(f"{where}term {term.symbols[0]}", term.needs, known)
        known.update(term.symbols)
