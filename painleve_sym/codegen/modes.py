"""A hybrid automaton as CasADi functions: fields, guards with rates, resets, outputs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca

from painleve_sym.automata.automaton import (
    Choice,
    Definition,
    HybridAutomaton,
    LinearSystem,
    Mode,
    Preparation,
    Reset,
    Transition,
)
from painleve_sym.automata.variants import Terms, known_memory, known_values, variant
from painleve_sym.codegen.bridge import Translator
from painleve_sym.codegen.linear import least_solution, solution


class Smooth:
    """Smooth functions of a motion; arguments of the functions are always (x, z, c).

    `rates` are those of the automaton's own states, `margins` the guards. The names of the
    functions end in `number`.
    """

    def __init__(
        self, of: AutomatonFunctions, number: int, rates: ca.SX, guards: list[ca.SX]
    ) -> None:
        self._of, self.number, self.rates = of, number, rates
        self.margins = ca.vertcat(ca.SX(0, 1), *guards)

    @cached_property
    def field(self) -> ca.Function:
        """The rates ẋ."""
        return self._of.function(f"field_{self.number}", [self._of.all_rates(self)])

    @cached_property
    def _jet(self) -> list[ca.SX]:
        return self._of.jet(self.margins, self.rates)

    @cached_property
    def guards(self) -> ca.Function:
        """The guards and their first Lie derivatives along the field, two vectors."""
        return self._of.function(f"guards_{self.number}", self._jet[:2])

    @cached_property
    def jets(self) -> ca.Function:
        """The guards, their first and second Lie derivatives, and ẋ."""
        results = [*self._jet, self._of.all_rates(self)]
        return self._of.function(f"jets_{self.number}", results)


@dataclass(frozen=True)
class VariantFunctions:
    """Smooth functions of the mode with the index `mode`, while its memory has `known` values.

    Guards that say nothing there are left out: the others belong to the `transitions` of the mode.
    `known` has one value for each entry of the memory, infinity for any. Where not `runs`, a mode
    as it is of which variants take the place, only its field is of use. With `by_series` guards and
    jets are orders of a series; of a mode as it is the field is for callers.
    """

    smooth: Smooth
    mode: int
    known: tuple[float, ...]
    transitions: tuple[int, ...]
    runs: bool = True
    by_series: bool = False

    @property
    def generated(self) -> dict[str, ca.Function]:
        """Functions that are generated, by their role."""
        of = self.smooth
        if self.runs and not self.by_series:
            return {"field": of.field, "guards": of.guards, "jets": of.jets}
        return {"field": of.field} if self.is_mode else {}

    @property
    def is_mode(self) -> bool:
        """Whether it is a mode as it is."""
        return self.smooth.number == self.mode


@dataclass(frozen=True)
class ModeFunctions:
    """The CasADi functions of one mode; arguments are always (x, z, c).

    Per transition `events` are x⁺, z⁺ and the conditions of its choices, 1 or 0; the engine passes
    a fourth argument, 1 where a guard crossed zero from above in time and 0 where it fired at once;
    an immediate transition has no guard. `limits` are x⁺ and z⁺ beyond an accumulation that is
    passed. `tests` have first and second Lie derivatives, and their scales: four vectors.
    """

    smooth: Smooth
    events: tuple[ca.Function, ...]
    limits: dict[int, ca.Function]
    outputs: ca.Function
    tests: ca.Function | None = None

    @property
    def field(self) -> ca.Function:
        """The rates ẋ."""
        return self.smooth.field

    @property
    def guards(self) -> ca.Function:
        """The guards and their first Lie derivatives along the field, two vectors."""
        return self.smooth.guards

    @property
    def jets(self) -> ca.Function:
        """The guards, their first and second Lie derivatives, and ẋ."""
        return self.smooth.jets

    def all(self) -> tuple[ca.Function, ...]:
        """Every function that is not smooth, for code generation."""
        tests = () if self.tests is None else (self.tests,)
        return (*self.events, *self.limits.values(), self.outputs, *tests)


class AutomatonFunctions:
    """Translates an automaton once; x are states, z memory, c parameters, then definitions.

    `has_variants` tells whether modes whose local modes are data run as variants of them alone.
    """

    directions = 0
    """Number of directions in which states are differentiated."""

    def __init__(self, automaton: HybridAutomaton, has_variants: bool = True) -> None:
        self.automaton, self.has_variants = automaton, has_variants
        self.x = self._x = ca.SX.sym("x", len(automaton.states))
        self.z = self._z = ca.SX.sym("z", len(automaton.memory))
        constants = (*automaton.parameters, *automaton.definitions)
        self.c = self._c = ca.SX.sym("c", len(constants))
        table = {s: self.x[i] for i, s in enumerate(automaton.states)}
        table |= {s: self.z[i] for i, s in enumerate(automaton.memory)}
        table |= {s: self.c[i] for i, s in enumerate(constants)}
        self._table = self._with_terms(table, automaton.terms)
        self._translate = Translator(self._table)
        # Outputs are never differentiated: a contact that has just opened carries exactly 0 N.
        values = self._with_terms(table, automaton.terms, floor=0.0)
        self._translate_value = Translator(values, floor=0.0)
        self.mode_index = {m.name: i for i, m in enumerate(automaton.modes)}

    @property
    def own(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """States, memory and constants of the automaton itself, with which x, z and c begin."""
        return self._x, self._z, self._c

    @property
    def moved_states(self) -> list[int]:
        """Indices of the states that have derivatives, in the order in which these follow."""
        return []

    def slopes(self, values: ca.SX) -> ca.SX:
        """Return the derivatives of a column of expressions, shape (values, directions)."""
        return ca.SX(values.numel(), 0)

    @staticmethod
    def _with_terms(
        symbols: Mapping[Any, ca.SX], terms: Terms, **options: float
    ) -> dict[Any, ca.SX]:
        """Return the symbols with the symbols of the terms."""
        table = dict(symbols)
        for term in terms:
            translate = Translator(table, **options)
            if isinstance(term, Definition):
                table[term.symbol] = translate(term.expression)
                continue
            table |= _solved(term, translate)
        return table

    @cached_property
    def alternatives(self) -> ca.Function | None:
        """Conditions of all alternatives of all parts, and the memory that each leads to.

        Two results, of shapes (na,) and (nz, na); None where the automaton has no parts.
        """
        if not self.automaton.parts:
            return None
        alternatives = [a for part in self.automaton.parts for a in part.alternatives]
        memory, vector = self.automaton.memory, self._translate.vector
        conditions = vector([a.condition for a in alternatives])
        columns = [vector([a.memory.get(s, s) for s in memory]) for a in alternatives]
        return self.function("alternatives", [conditions, ca.horzcat(*columns)])

    @cached_property
    def impacts(self) -> ca.Function | None:
        """Mobility, load, directions, friction, both velocities and restitution of `Impacts`.

        Seven results, matrices column by column; None where the automaton has no impacts.
        """
        numbers = self._impact_numbers()
        return self.function("impacts", numbers) if numbers else None

    def _impact_numbers(self) -> list[ca.SX]:
        given = self.automaton.impacts
        if given is None:
            return []
        matrices = (given.mobility, given.load, given.directions)
        rows = [given.friction, given.drive_speeds, given.contact_velocity, given.coefficients]
        columns = [*(list(m.T) for m in matrices), *map(list, rows)]
        return [self._translate.vector(c) for c in columns]

    @cached_property
    def constants(self) -> ca.Function:
        """Parameters to constants: p, shape (np,), to c, shape (nc,)."""
        p = ca.SX.sym("p", len(self.automaton.parameters))
        return ca.Function("constants", [p], [self._constants_of(p)])

    def _constants_of(self, p: ca.SX) -> ca.SX:
        table = {s: p[i] for i, s in enumerate(self.automaton.parameters)}
        values = [p[i] for i in range(p.numel())]
        for symbol, expr in self.automaton.definitions.items():
            table[symbol] = Translator(table)(expr)
            values.append(table[symbol])
        return ca.vertcat(*values)

    @cached_property
    def starts(self) -> ca.Function:
        """Conditions of the start choices."""
        return self.function("starts", [self._conditions(self.automaton.starts)])

    @cached_property
    def prepared(self) -> ca.Function | None:
        """Given states, initial force and constants to the start state, and whether it is admitted.

        The second result has shape (3,), see `Preparation.admits`; None without a preparation.
        """
        of = self.automaton.preparation
        if of is None:
            return None
        given, force = ca.SX.sym("given", len(of.given)), ca.SX.sym("force")
        symbols = dict(zip(of.given, ca.vertsplit(given), strict=True)) | {of.force: force}
        translate = self._preparing(of, symbols)
        kept = dict.fromkeys(self.automaton.states, 0) | {s: s for s in of.given}
        states = [of.states.get(s, kept[s]) for s in self.automaton.states]
        results = [translate.vector(states), translate.vector(of.admits)]
        return ca.Function("prepared_state", [given, force, self.c], _dense(results))

    @cached_property
    def scales(self) -> ca.Function | None:
        """States and constants to the scale of each state; None without a preparation."""
        of = self.automaton.preparation
        if of is None:
            return None
        symbols = dict(zip(self.automaton.states, ca.vertsplit(self.x), strict=True))
        translate = self._preparing(of, symbols)
        scales = translate.vector([of.scales[s] for s in self.automaton.states])
        return ca.Function("state_scales", [self.x, self.c], _dense([scales]))

    def _preparing(self, of: Preparation, symbols: Mapping[Any, ca.SX]) -> Translator:
        """Return a translator that knows the symbols, the constants, and the terms made of them."""
        constants = (*self.automaton.parameters, *self.automaton.definitions)
        table = dict(symbols) | dict(zip(constants, ca.vertsplit(self.c), strict=True))
        for term in of.terms:
            if term.expression.free_symbols <= table.keys():
                table[term.symbol] = Translator(table, floor=0.0)(term.expression)
        return Translator(table, floor=0.0)

    @cached_property
    def modes(self) -> tuple[ModeFunctions, ...]:
        """Functions of every mode, in the automaton's order."""
        return tuple(self._mode(i, m) for i, m in enumerate(self.automaton.modes))

    @cached_property
    def as_they_are(self) -> tuple[VariantFunctions, ...]:
        """The modes as they are; without guards where variants take their place."""
        return tuple(map(self._as_it_is, range(len(self.modes))))

    def is_switched(self, i: int) -> bool:
        """Whether variants take the place of a mode: it moves, and its local modes are data."""
        given = self.automaton
        return bool(self.has_variants and given.parts and given.modes[i].field)

    def _as_it_is(self, i: int) -> VariantFunctions:
        mode, memory = self.automaton.modes[i], self.automaton.memory
        guarded = tuple(j for j, t in enumerate(mode.transitions) if t.guard is not None)
        known = (math.inf,) * len(memory)
        return VariantFunctions(self.modes[i].smooth, i, known, guarded, not self.is_switched(i))

    def variant(self, i: int, memory: Sequence[float], number: int) -> VariantFunctions:
        """Return the functions of the variant of a mode for a memory; see `known_memory`."""
        known = known_memory(self.automaton, memory)
        at, mode = variant(self.automaton, known), self.automaton.modes[i]
        translate = Translator(self._with_terms(self._table, at.terms))
        rates, guards = self._rates_of(at.field(mode), translate), at.guards(mode)
        smooth = Smooth(self, number, rates, [translate(g) for g in guards.values()])
        return VariantFunctions(smooth, i, known_values(self.automaton, memory), tuple(guards))

    @property
    def output_size(self) -> int:
        """Number of values that `outputs` returns."""
        return int(self.modes[0].outputs.numel_out(0))

    def all(self) -> tuple[ca.Function, ...]:
        """Every function that is not smooth, for code generation."""
        some = (self.alternatives, self.impacts, self.prepared, self.scales)
        more = [f for f in some if f is not None]
        modes = (f for m in self.modes for f in m.all())
        return (self.constants, self.starts, *more, *modes)

    def function(self, name: str, results: list[ca.SX], *more: ca.SX) -> ca.Function:
        """Return the function of states, memory and constants with these results, made dense."""
        return ca.Function(name, [self.x, self.z, self.c, *more], _dense(results))

    def _conditions(self, choices: tuple[Choice, ...]) -> ca.SX:
        conditions = (c.condition for c in choices)
        return self._translate.vector([1.0 if c is None else c for c in conditions])

    def _field(self, mode: Mode) -> ca.SX:
        return self._rates_of(mode.field, self._translate)

    def _rates_of(self, field: Mapping[Any, Any], translate: Translator) -> ca.SX:
        return translate.vector([field.get(s, 0) for s in self.automaton.states])

    def of_mode(self, name: str) -> ModeFunctions:
        """Return the functions of the mode of that name."""
        return self._mode(self.mode_index[name], self.automaton.mode(name))

    def _mode(self, i: int, mode: Mode) -> ModeFunctions:
        rates = self._field(mode)
        guards = [self._translate(t.guard) for t in mode.transitions if t.guard is not None]
        return ModeFunctions(
            smooth=Smooth(self, i, rates, guards),
            events=tuple(self._event(i, j, t) for j, t in enumerate(mode.transitions)),
            limits={
                j: self._limit(i, j, t.on_accumulation.reset)
                for j, t in enumerate(mode.transitions)
                if t.on_accumulation is not None
            },
            outputs=self.function(f"outputs_{i}", [self._outputs(i, mode)]),
            tests=self._tests(i, mode, rates),
        )

    def _outputs(self, i: int, mode: Mode) -> ca.SX:
        return self._translate_value.vector(list(mode.outputs.values()))

    def all_rates(self, of: Smooth) -> ca.SX:
        """Return the rates of all states of a motion."""
        return of.rates

    def jet(self, values: ca.SX, field: ca.SX) -> list[ca.SX]:
        """Return values with their first two Lie derivatives."""
        first = ca.jtimes(values, self._x, field)
        return [values, first, ca.jtimes(first, self._x, field)]

    def _tests(self, i: int, mode: Mode, field: ca.SX) -> ca.Function | None:
        if not mode.tests:
            return None
        values = self._translate.vector([t.value for t in mode.tests])
        scales = self._translate.vector([t.scale for t in mode.tests])
        return self.function(f"tests_{i}", [*self.jet(values, field), scales])

    def _event(self, i: int, j: int, transition: Transition) -> ca.Function:
        conditions = self._conditions(transition.choices)
        return self.function(f"event_{i}_{j}", [*self._after(transition.reset), conditions])

    def _limit(self, i: int, j: int, reset: Reset) -> ca.Function:
        return self.function(f"limit_{i}_{j}", self._after(reset))

    def _after(self, reset: Reset) -> list[ca.SX]:
        """Return x⁺ and z⁺."""
        groups = (self.automaton.states, self.automaton.memory)
        return [self._translate.vector([reset.get(s, s) for s in group]) for group in groups]

    def departures(self, choice: Choice) -> tuple[int, ...]:
        """Return the indices, in the target mode, of guards known to leave zero upwards."""
        labels = [t.label for t in self.automaton.mode(choice.target).transitions]
        return tuple(labels.index(name) for name in choice.departs)


def _solved(term: LinearSystem, translate: Translator) -> dict[Any, ca.SX]:
    matrix = [[translate(entry) for entry in term.matrix.row(i)] for i in range(term.matrix.rows)]
    right = [[translate(entry) for entry in term.right.row(i)] for i in range(term.right.rows)]
    if term.weights is not None:
        values = least_solution(matrix, right, [translate(e) for e in term.weights])
        return dict(zip(term.unknowns, (v for row in values for v in row), strict=True))
    scales = [translate(s) for s in term.scales]
    solved, whole = solution(matrix, [r for (r,) in right], scales)
    return dict(zip(term.unknowns, solved, strict=True)) | {term.determinant: whole}


def _dense(results: list[ca.SX]) -> list[ca.SX]:
    """Return results that share common parts, with explicit zeros where they are structural."""
    dense: list[ca.SX] = ca.cse([ca.densify(r) for r in results])
    return dense
