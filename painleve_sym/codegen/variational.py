"""The variational automaton: a state and its first derivatives, through every event.

Derivatives are taken at a fixed time since the last event: with τ the time of that event,
S = d x(τ + σ)/dw at fixed σ, the variational equation S' = f_x S + f_z Z + f_c C holds in every
mode. Where a guard g(x, z, c) crosses zero from above, that time shifts by
dσ = −(g_x S + g_z Z + g_c C)/(g_x f), and

    S⁺ = R_x (S + f dσ) + R_z Z + R_c C,   T⁺ = T + dσ,

with the reset R, the derivatives Z of the memory and C of the constants, and T = dτ/dw. A guard
that fires at once takes no time: dσ = 0. At a fixed time t the derivative is S − f T; put together,
that is the saltation matrix R_x + (f⁺ − R_x f⁻) g_x/(g_x f⁻).

References
----------
Aizerman & Gantmakher (1958); Leine & Nijmeijer (2004); Galán, Feehery & Barton (1999).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.automata.automaton import HybridAutomaton, Mode, Reset, Transition
from painleve_sym.codegen.modes import AutomatonFunctions, Smooth

Pattern = Any
"""An array of bool: which derivatives can be different from zero."""
Rows = tuple[ca.SX, ca.SX, ca.SX]
"""Derivatives with respect to states, memory and constants."""


@dataclass(frozen=True)
class _EventSlopes:
    """Guard and reset (x⁺, then z⁺) of a transition with their derivatives."""

    guard: ca.SX
    guard_by: Rows
    after: ca.SX
    after_by: Rows


class VariationalFunctions(AutomatonFunctions):
    """Functions of an automaton extended by derivatives in some directions.

    The state is followed by the derivatives S, the memory by Z, then by `event_entries`, the
    constants by the derivatives of the definitions. States and definitions whose derivatives are
    zero in every mode have none; those of a state follow one another in the order of the
    directions. An output is followed by the derivatives of all states, then of all outputs, at a
    fixed time, each column by column.

    Per direction `parameters` has the index of the parameter that it moves, None for none, and
    `start` which states it moves at the start, shape (nx, directions).
    """

    def __init__(
        self, automaton: HybridAutomaton, parameters: Sequence[int | None], start: Pattern
    ) -> None:
        super().__init__(automaton, has_variants=False)
        self.directions = len(parameters)
        self._moved = tuple(parameters)
        self._rates = [self._field(mode) for mode in automaton.modes]
        self._rates_by = [self._by(f) for f in self._rates]
        self._events = [[self._slopes(t) for t in mode.transitions] for mode in automaton.modes]
        self._limits = {
            (i, j): self._reset_slopes(t.on_accumulation.reset)
            for i, mode in enumerate(automaton.modes)
            for j, t in enumerate(mode.transitions)
            if t.on_accumulation is not None
        }
        definitions = self._definitions_pattern()
        moved, memory = self._patterns(np.array(start, dtype=bool), definitions)
        # Whole rows: a vector of the processor holds a state's derivatives side by side.
        self.state_pattern = np.repeat(moved.any(axis=1)[:, None], self.directions, axis=1)
        self._S, states = _unknowns("S", self.state_pattern)
        self._Z, remembered = _unknowns("Z", memory)
        self._D, derived = _unknowns("D", definitions)
        self._C = self._D + _sparse(self._unit_pattern())
        self._T, self._timed = ca.SX.sym("T", 1, self.directions), ca.SX.sym("timed")
        last = ca.SX.sym("last", self.directions + 4)
        self.x = ca.vertcat(self._x, states)
        self.z = ca.vertcat(self._z, remembered, self._T.T, last)
        self.c = ca.vertcat(self._c, derived)

    @cached_property
    def impact_slopes(self) -> ca.Function:
        """Values of `AutomatonFunctions.impacts`, then the derivatives of each.

        Those of a result of shape (r,) have the shape (r, directions).
        """
        numbers = self._impact_numbers()
        return self.function("impact_slopes", [*numbers, *map(self.slopes, numbers)])

    @cached_property
    def struck_states(self) -> list[int]:
        """Indices of the states that an impact of several contacts changes."""
        given = self.automaton.impacts
        if given is None:
            return []
        contact = [s for _, rate, slip in given.contacts for s in (rate, slip)]
        works = [s for s in given.works if s is not None]
        every = dict.fromkeys([*given.velocities, *contact, *works])
        return [self.automaton.states.index(s) for s in every]

    @property
    def prepared(self) -> None:
        """None: whole start states are given, with their derivatives."""

    @property
    def scales(self) -> None:
        """None: the scales come with the start states."""

    @cached_property
    def event_entries(self) -> dict[str, slice]:
        """Slices of the memory that describe the last event.

        ``time``: T. ``shift``: dσ by the formula, also where the event took no time. ``guard``,
        ``rate``, ``bend``: g and its first two derivatives in time just before. ``timed``: 1 or 0.
        """
        n, at = self.directions, self.z.numel() - 2 * self.directions - 4
        sizes = {"time": n, "shift": n, "guard": 1, "rate": 1, "bend": 1, "timed": 1}
        places = {}
        for name, size in sizes.items():
            places[name] = slice(at, at + size)
            at += size
        return places

    @cached_property
    def entries(self) -> tuple[Any, Any]:
        """Rows and directions of the derivatives that follow the state, in their order."""
        rows, directions = np.nonzero(self.state_pattern)
        return rows, directions

    def packed(self, state: Array, jacobian: Array) -> Array:
        """Return the state followed by its derivatives, those of shape (nx, directions)."""
        return np.concatenate([state, jacobian[self.entries]])

    def unpacked(self, extended: Array) -> tuple[Array, Array]:
        """Return the state and its derivatives, shapes (nx,) and (nx, directions)."""
        nx = self._x.numel()
        jacobian = np.zeros((nx, self.directions))
        jacobian[self.entries] = extended[nx:]
        return extended[:nx], jacobian

    # ---- derivatives and which of them are zero ----

    @property
    def moved_states(self) -> list[int]:
        """Indices of the states that have derivatives, in the order in which these follow."""
        return [int(i) for i in np.flatnonzero(self.state_pattern.any(axis=1))]

    def slopes(self, values: ca.SX) -> ca.SX:
        """Return the derivatives of a column of expressions, shape (values, directions)."""
        return self._along(self._by(values), self._S)

    def _by(self, expr: ca.SX) -> Rows:
        return (ca.jacobian(expr, self._x), ca.jacobian(expr, self._z), ca.jacobian(expr, self._c))

    def _slopes(self, transition: Transition) -> _EventSlopes:
        # An immediate transition takes no time: any guard that does not move says so.
        guard = self._translate(-1 if transition.guard is None else transition.guard)
        return _EventSlopes(guard, self._by(guard), *self._reset_slopes(transition.reset))

    def _reset_slopes(self, reset: Reset) -> tuple[ca.SX, Rows]:
        after = ca.vertcat(*self._after(reset))
        return after, self._by(after)

    @cached_property
    def _definition_slopes(self) -> ca.Function:
        """Derivatives of the constants with respect to the parameters, shape (nc, np)."""
        p = ca.SX.sym("p", len(self.automaton.parameters))
        return ca.Function("slopes", [p], [ca.jacobian(self._constants_of(p), p)])

    def _unit_pattern(self) -> Pattern:
        """Return where a direction moves its own parameter."""
        pattern = np.zeros((self._c.numel(), self.directions), dtype=bool)
        for k, index in enumerate(self._moved):
            if index is not None:
                pattern[index, k] = True
        return pattern

    def _definitions_pattern(self) -> Pattern:
        full = _pattern(self._definition_slopes.sparsity_out(0))
        full[: len(self.automaton.parameters)] = False
        columns = [np.zeros(len(full), bool) if i is None else full[:, i] for i in self._moved]
        return np.column_stack(columns)

    def _patterns(self, states: Pattern, definitions: Pattern) -> tuple[Pattern, Pattern]:
        """Return which derivatives of states and memory can ever be different from zero."""
        nx, nz = self._x.numel(), self._z.numel()
        memory = np.zeros((nz, self.directions), dtype=bool)
        whole = np.vstack([states, memory, definitions | self._unit_pattern()])
        struck = self.struck_states
        impacts = np.vstack([_patterns_of(self._by(n)) for n in self._impact_numbers()] or [[]])
        before = np.zeros_like(whole)
        while (whole != before).any():
            before = whole.copy()
            for rates, by, events in zip(self._rates, self._rates_by, self._events, strict=True):
                whole[:nx] |= _patterns_of(by) @ whole
                moving = _pattern(ca.sparsify(rates).sparsity())
                for e in events:
                    moved = whole.copy()
                    moved[:nx] |= moving & (_patterns_of(e.guard_by) @ whole)
                    whole[: nx + nz] |= _patterns_of(e.after_by) @ moved
            for _, after_by in self._limits.values():
                whole[: nx + nz] |= _patterns_of(after_by) @ whole
            if struck:
                numbers = np.any(impacts @ whole, axis=0)
                whole[struck] |= numbers | np.any(whole[struck], axis=0)
        return whole[:nx], whole[nx : nx + nz]

    # ---- functions ----

    @cached_property
    def constants(self) -> ca.Function:
        """Parameters to constants and to the derivatives of the definitions."""
        p = ca.SX.sym("p", len(self.automaton.parameters))
        full, none = self._definition_slopes(p), ca.SX(self._c.numel(), 1)
        slopes = ca.horzcat(*[none if i is None else full[:, i] for i in self._moved])
        values = ca.vertcat(self._constants_of(p), _listed(slopes, self._D.sparsity()))
        return ca.Function("constants", [p], [ca.cse(ca.densify(values))])

    def _along(self, by: Rows, states: ca.SX) -> ca.SX:
        """Return the derivatives in all directions, those of the states given."""
        return by[0] @ states + by[1] @ self._Z + by[2] @ self._C

    def all_rates(self, of: Smooth) -> ca.SX:
        """Return the rates of a mode's states and of their derivatives."""
        slopes = self._along(self._rates_by[of.number], self._S)
        return ca.vertcat(of.rates, _listed(slopes, self._S.sparsity()))

    def _outputs(self, i: int, mode: Mode) -> ca.SX:
        expressions = list(mode.outputs.values())
        fixed_time = self._S - self._rates[i] @ self._T
        slopes = self._along(self._by(self._translate.vector(expressions)), fixed_time)
        values = self._translate_value.vector(expressions)
        return ca.vertcat(values, *(ca.vec(ca.densify(m)) for m in (fixed_time, slopes)))

    def _event(self, i: int, j: int, transition: Transition) -> ca.Function:
        e = self._events[i][j]
        rate = e.guard_by[0] @ self._rates[i]
        slope = ca.densify(self._along(e.guard_by, self._S))
        # A guard that is zero but not coming down has no time: the quotient is then not finite.
        shift = ca.if_else(self._timed > 0.5, -slope / ca.fmin(rate, 0), 0)
        bend = ca.jtimes(rate, self._x, self._rates[i])
        of_event = (self._T + shift, -slope / rate, e.guard, rate, bend, self._timed)
        states = self._S + self._rates[i] @ shift
        results = self._extended(e.after, e.after_by, states, of_event)
        results.append(self._conditions(transition.choices))
        return self.function(f"event_{i}_{j}", results, self._timed)

    def _limit(self, i: int, j: int, reset: Reset) -> ca.Function:
        # What comes before the limit moves it with the events that accumulate: dσ is theirs.
        of_event = (self._T, ca.SX.zeros(1, self.directions), *[ca.SX.zeros(1)] * 4)
        results = self._extended(*self._limits[i, j], self._S, of_event)
        return self.function(f"limit_{i}_{j}", results)

    def _extended(
        self, after: ca.SX, after_by: Rows, states: ca.SX, of_event: Sequence[ca.SX]
    ) -> list[ca.SX]:
        """Return states and memory after a reset, each followed by its derivatives."""
        nx, slopes = self._x.numel(), self._along(after_by, states)
        x = ca.vertcat(after[:nx], _listed(slopes[:nx, :], self._S.sparsity()))
        z = (after[nx:], _listed(slopes[nx:, :], self._Z.sparsity()), *(e.T for e in of_event))
        return [x, ca.vertcat(*z)]


def _pattern(sparsity: ca.Sparsity) -> Pattern:
    return np.array(ca.DM(sparsity, 1.0).full(), dtype=bool)


def _patterns_of(rows: Rows) -> Pattern:
    return np.hstack([_pattern(r.sparsity()) for r in rows])


def _sparse(pattern: Pattern) -> ca.DM:
    return ca.sparsify(ca.DM(pattern.astype(float)))


def _unknowns(name: str, pattern: Pattern) -> tuple[ca.SX, ca.SX]:
    """Return a matrix of symbols where `pattern` is true, and the column of these symbols."""
    matrix = ca.SX.sym(name, _sparse(pattern.T).sparsity()).T
    return matrix, _listed(matrix, matrix.sparsity())


def _listed(matrix: ca.SX, sparsity: ca.Sparsity) -> ca.SX:
    """Return the entries at `sparsity`, which holds all that are not zero, row by row."""
    entries: list[Any] = ca.project(matrix, sparsity).T.nonzeros()
    return ca.vertcat(*entries) if entries else ca.SX(0, 1)
