"""An automaton without its formulas: names and structure, which is all that a run is read with."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import sympy as sp

from painleve_sym.errors import EventKind, StopReason
from painleve_sym.hybrid.automaton import HybridAutomaton


class AutomatonBuilder(Protocol):
    """Anything that derives an automaton: a frozen dataclass that says from what."""

    @property
    def automaton(self) -> HybridAutomaton:
        """The automaton, derived when first asked for."""


class TransitionOutline(NamedTuple):
    """A `Transition` without guard, choices and reset."""

    label: str
    kind: EventKind
    stop: StopReason | None
    contact: str
    bound: int | None
    decides: tuple[EventKind, ...]


class ModeOutline(NamedTuple):
    """A `Mode` without field and outputs."""

    name: str
    transitions: tuple[TransitionOutline, ...]


class PartOutline(NamedTuple):
    """A `Part` without its alternatives."""

    name: str
    memory: tuple[sp.Symbol, ...]
    local_modes: tuple[str, ...]


@dataclass(frozen=True)
class Outline:
    """Names and structure of an automaton; stored beside its library, it needs no derivation.

    Attributes as those of `HybridAutomaton`; `definitions` has the symbols alone.
    """

    name: str
    states: tuple[sp.Symbol, ...]
    memory: tuple[sp.Symbol, ...]
    parameters: tuple[sp.Symbol, ...]
    definitions: tuple[sp.Symbol, ...]
    modes: tuple[ModeOutline, ...]
    uncontrolled: tuple[sp.Symbol, ...]
    kinds: tuple[EventKind, ...]
    contacts: tuple[str, ...]
    output_names: tuple[str, ...]
    parts: tuple[PartOutline, ...]

    @classmethod
    def of(cls, automaton: HybridAutomaton) -> Outline:
        """Return the outline of an automaton."""
        modes = tuple(
            ModeOutline(
                m.name,
                tuple(
                    TransitionOutline(t.label, t.kind, t.stop, t.contact, t.bound, t.decides)
                    for t in m.transitions
                ),
            )
            for m in automaton.modes
        )
        return cls(
            name=automaton.name,
            states=automaton.states,
            memory=automaton.memory,
            parameters=automaton.parameters,
            definitions=tuple(automaton.definitions),
            modes=modes,
            uncontrolled=automaton.uncontrolled,
            kinds=automaton.kinds,
            contacts=automaton.contacts,
            output_names=automaton.output_names,
            parts=tuple(PartOutline(p.name, p.memory, p.local_modes) for p in automaton.parts),
        )

    def to_data(self) -> dict[str, Any]:
        """Return JSON-ready data; a symbol is its name and its assumptions."""
        symbols = {field: list(map(_named, getattr(self, field))) for field in _SYMBOLS}
        modes = [
            (name, [(*t[:2], t.stop.name if t.stop else None, *t[3:]) for t in transitions])
            for name, transitions in self.modes
        ]
        parts = [(name, list(map(_named, memory)), modes) for name, memory, modes in self.parts]
        return vars(self) | symbols | {"modes": modes, "parts": parts}

    @classmethod
    def of_data(cls, data: Mapping[str, Any]) -> Outline:
        """Return the outline that `to_data` wrote; its symbols equal those of the automaton."""
        modes = tuple(
            ModeOutline(name, tuple(map(_transition, transitions)))
            for name, transitions in data["modes"]
        )
        return cls(
            name=data["name"],
            modes=modes,
            kinds=tuple(map(EventKind, data["kinds"])),
            contacts=tuple(data["contacts"]),
            output_names=tuple(data["output_names"]),
            parts=tuple(PartOutline(n, _symbols(m), tuple(own)) for n, m, own in data["parts"]),
            **{field: _symbols(data[field]) for field in _SYMBOLS},
        )


_SYMBOLS = ("states", "memory", "parameters", "definitions", "uncontrolled")


def _named(symbol: sp.Symbol) -> tuple[str, dict[str, bool | None]]:
    """Return a symbol as data: with one assumption, where the others follow from it."""
    for word in ("real", "positive", "nonnegative"):
        if sp.Symbol(symbol.name, **{word: True}) == symbol:
            return symbol.name, {word: True}
    return symbol.name, symbol.assumptions0


def _symbols(data: Iterable[tuple[str, Mapping[str, bool]]]) -> tuple[sp.Symbol, ...]:
    return tuple(sp.Symbol(name, **assumptions) for name, assumptions in data)


def _transition(data: Sequence[Any]) -> TransitionOutline:
    label, kind, stop, contact, bound, decides = data
    reason = StopReason[stop] if stop else None
    return TransitionOutline(
        label, EventKind(kind), reason, contact, bound, tuple(map(EventKind, decides))
    )


def mode_name(outline: Outline, mode: int, memory: Sequence[float]) -> str:
    """Return the name of a mode; where local modes are data, those of all parts in their order.

    Parameters
    ----------
    outline : Outline
    mode : int
    memory : sequence of float, shape (nz,)
    """
    if not outline.parts:
        return outline.modes[mode].name
    names, first = [], 0
    for part in outline.parts:
        names.append(part.local_modes[round(memory[first])])
        first += len(part.memory)
    return " + ".join(names)
