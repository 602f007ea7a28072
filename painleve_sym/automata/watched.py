"""The automaton with the events that are watched: transitions of every motion back to itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import sympy as sp

from painleve_sym.automata.automaton import (
    Choice,
    Definition,
    HybridAutomaton,
    Mode,
    Reset,
    Transition,
)
from painleve_sym.automata.watch import Watch
from painleve_sym.errors import EventKind, InputError, refuse_unknown
from painleve_sym.mechanics.system import TIME
from painleve_sym.mechanics.toml.expressions import Formulas

_ZERO, _ONE = sp.Integer(0), sp.Integer(1)
_NEAR = sp.Float(1e-9)
"""Part of a period by which a strobe may be early: rounding of the time."""


def watched(
    automaton: HybridAutomaton, watches: tuple[Watch, ...], gaps: Mapping[str, sp.Symbol]
) -> HybridAutomaton:
    """Return an automaton whose motions have the events of `watches`, too.

    Each has a memory. That of an apex, peak or section tells whether its quantity has fallen
    through 0: then the transition is the silent one by which it rises again. That of a strobe
    counts. `gaps` are the gaps of the contacts by their names.

    Raises
    ------
    InputError
        Unknown names, a formula with faults, a quantity whose rate is not known.
    """
    clocked = _clocked(automaton) if any(_needs_time(w) for w in watches) else automaton
    memory = [_memory(w) for w in watches]
    own = len(clocked.impacts.impulses) if clocked.impacts is not None else 0
    first = len(clocked.memory) - own
    modes = tuple(
        replace(m, transitions=_with_watches(clocked, m, watches, gaps)) if m.field else m
        for m in clocked.modes
    )
    return replace(
        clocked,
        memory=(*clocked.memory[:first], *memory, *clocked.memory[first:]),
        modes=modes,
    )


def _memory(watch: Watch) -> sp.Symbol:
    return sp.Symbol(watch.memory, real=True)


def _needs_time(watch: Watch) -> bool:
    return watch.kind is EventKind.STROBE


def _clocked(automaton: HybridAutomaton) -> HybridAutomaton:
    """Return the automaton with the time among its states."""
    if TIME in automaton.states:
        return automaton
    modes = (replace(m, field={**m.field, TIME: _ONE}) if m.field else m for m in automaton.modes)
    return replace(automaton, states=(*automaton.states, TIME), modes=tuple(modes))


def _with_watches(
    automaton: HybridAutomaton,
    mode: Mode,
    watches: tuple[Watch, ...],
    gaps: Mapping[str, sp.Symbol],
) -> tuple[Transition, ...]:
    own = [t for w in watches for t in _transitions(automaton, mode, w, gaps)]
    timed = [t for t in mode.transitions if not t.immediate]
    return (*timed, *own, *(t for t in mode.transitions if t.immediate))


def _transitions(
    automaton: HybridAutomaton, mode: Mode, watch: Watch, gaps: Mapping[str, sp.Symbol]
) -> list[Transition]:
    """Return the transitions of a watch in a mode."""
    if watch.kind is EventKind.STROBE:
        return [_strobe(automaton, mode, watch)]
    value, fallen = _value(automaton, mode, watch, gaps), _memory(watch)
    falls, rises = watch.label, f"{watch.label} rises"

    def turn(label: str, guard: sp.Expr, reset: Reset, then: str, silent: bool) -> Transition:
        choices = (Choice(mode.name, departs=(then,)),)
        return Transition(
            label,
            watch.kind,
            guard,
            choices,
            reset,
            contact=watch.contact,
            watches=True,
            silent=silent,
        )

    return [
        turn(falls, (1 - fallen) * value + fallen, {fallen: _ONE}, rises, False),
        turn(rises, (1 - fallen) - fallen * value, {fallen: _ZERO}, falls, True),
    ]


def _strobe(automaton: HybridAutomaton, mode: Mode, watch: Watch) -> Transition:
    """Return the event at the times offset + k period."""
    names = {p.name: p for p in automaton.parameters}
    period, *more = (_formula(automaton, watch, text, names) for text in watch.arguments)
    if period.is_number and not period > 0:
        raise InputError(f"{automaton.name}: watch: {watch.text}: got no period > 0.")
    offset, count = (more[0] if more else _ZERO), _memory(watch)
    passed = sp.floor((TIME - offset) / period + _NEAR)
    reset = {count: sp.Max(count, passed) + 1}
    guard = offset + count * period - TIME
    choices = (Choice(mode.name),)
    return Transition(watch.label, watch.kind, guard, choices, reset, watches=True)


def _value(
    automaton: HybridAutomaton, mode: Mode, watch: Watch, gaps: Mapping[str, sp.Symbol]
) -> sp.Expr:
    """Return what falls through 0 at the event."""
    where, states = f"{automaton.name}: watch: {watch.text}", {s.name: s for s in automaton.states}
    if watch.contact:
        return _rate(automaton, mode, gaps[watch.contact], where)
    (text,) = watch.arguments
    if watch.kind is EventKind.SECTION:
        return _formula(automaton, watch, text, states | {p.name: p for p in automaton.parameters})
    known = states if watch.kind is EventKind.APEX else {**mode.outputs, **states}
    refuse_unknown("quantity", text, known, where)
    return _rate(automaton, mode, known[text], where)


def _formula(
    automaton: HybridAutomaton, watch: Watch, text: str, names: Mapping[str, sp.Expr]
) -> sp.Expr:
    """Return the expression of a formula in these names."""
    value, faults = Formulas(dict(names)).read(text)
    if value is None:
        raise InputError(f"{automaton.name}: watch: {watch.text}: {faults[0].message}")
    return sp.sympify(value)


def _rate(automaton: HybridAutomaton, mode: Mode, quantity: sp.Expr, where: str) -> sp.Expr:
    """Return the rate of a quantity along the field of a mode."""
    terms = {s: term for term in automaton.terms for s in term.symbols}
    rates: dict[sp.Symbol, sp.Expr] = dict(mode.field)

    def along(expr: sp.Expr) -> sp.Expr:
        symbols = [s for s in sorted(expr.free_symbols, key=str) if moves(s)]
        # A power is u**(n - 1), not u**n/u, at u = 0, too; a ramp is used where it rises.
        slopes = [sp.powsimp(sp.diff(expr, s), combine="exp") for s in symbols]
        slopes = [slope.replace(sp.Heaviside, lambda *_: _ONE) for slope in slopes]
        return sp.Add(*[a * of_symbol(s) for a, s in zip(slopes, symbols, strict=True)])

    def moves(symbol: sp.Symbol) -> bool:
        return symbol in rates or symbol in terms

    def of_symbol(symbol: sp.Symbol) -> sp.Expr:
        if symbol not in rates:
            term = terms[symbol]
            if not isinstance(term, Definition):
                raise InputError(
                    f"{where}: its rate is not known, since forces of several rigid contacts solve "
                    "a linear system. Fix: watch a state, or take maxima= of a batch."
                )
            rates[symbol] = along(term.expression)
        return rates[symbol]

    return along(sp.sympify(quantity))
