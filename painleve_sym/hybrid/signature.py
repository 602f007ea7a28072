"""An automaton without its formulas: names and structure, which is all that a run is read with."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import sympy as sp

from painleve_sym.errors import EventKind, StopReason
from painleve_sym.hybrid.automaton import HybridAutomaton


class TransitionOutline(Protocol):
    """An event by its names."""

    @property
    def label(self) -> str:
        """Unique in its mode."""

    @property
    def kind(self) -> EventKind:
        """What users see."""

    @property
    def stop(self) -> StopReason | None:
        """Why the run ends there, or None."""

    @property
    def contact(self) -> str:
        """Name of the contact, or nothing."""

    @property
    def bound(self) -> int | None:
        """Index of the bound of the domain that is watched, or None."""

    @property
    def decides(self) -> tuple[EventKind, ...]:
        """Kinds of events of the decision that is asked for; empty for no decision."""


class ModeOutline(Protocol):
    """A mode by its names."""

    @property
    def name(self) -> str:
        """Unique."""

    @property
    def transitions(self) -> Sequence[TransitionOutline]:
        """In the automaton's order."""


class PartOutline(Protocol):
    """A part by its names."""

    @property
    def name(self) -> str:
        """Unique."""

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """Its own memory; the first entry holds the index of its local mode."""

    @property
    def local_modes(self) -> tuple[str, ...]:
        """Names of its local modes."""


class Outline(Protocol):
    """Names and structure of an automaton; a `HybridAutomaton` is one, and so is a `Skeleton`."""

    @property
    def name(self) -> str:
        """Name of the automaton."""

    @property
    def states(self) -> tuple[sp.Symbol, ...]:
        """Integrated quantities."""

    @property
    def memory(self) -> tuple[sp.Symbol, ...]:
        """Constants within a mode."""

    @property
    def parameters(self) -> tuple[sp.Symbol, ...]:
        """Given constants."""

    @property
    def definitions(self) -> Collection[sp.Symbol]:
        """Constants computed from the parameters."""

    @property
    def modes(self) -> Sequence[ModeOutline]:
        """Smooth regimes."""

    @property
    def uncontrolled(self) -> tuple[sp.Symbol, ...]:
        """States that do not steer the step size."""

    @property
    def parts(self) -> Sequence[PartOutline]:
        """Parts whose local modes are data."""

    @property
    def kinds(self) -> tuple[EventKind, ...]:
        """Kinds of events, in order of appearance."""

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the contacts that events concern."""

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of the outputs."""


class AutomatonBuilder(Protocol):
    """Anything that derives an automaton: a frozen dataclass that says from what."""

    @property
    def automaton(self) -> HybridAutomaton:
        """The automaton, derived when first asked for."""


@dataclass(frozen=True)
class TransitionSkeleton:
    """A transition without guard, choices and reset."""

    label: str
    kind: EventKind
    stop: StopReason | None
    contact: str
    bound: int | None
    decides: tuple[EventKind, ...]


@dataclass(frozen=True)
class ModeSkeleton:
    """A mode without field and outputs."""

    name: str
    transitions: tuple[TransitionSkeleton, ...]


@dataclass(frozen=True)
class PartSkeleton:
    """A part without its alternatives."""

    name: str
    memory: tuple[sp.Symbol, ...]
    local_modes: tuple[str, ...]


@dataclass(frozen=True)
class Skeleton:
    """The outline of an automaton that need not have been derived; see `HybridAutomaton`."""

    name: str
    states: tuple[sp.Symbol, ...]
    memory: tuple[sp.Symbol, ...]
    parameters: tuple[sp.Symbol, ...]
    definitions: tuple[sp.Symbol, ...]
    modes: tuple[ModeSkeleton, ...]
    uncontrolled: tuple[sp.Symbol, ...]
    kinds: tuple[EventKind, ...]
    contacts: tuple[str, ...]
    output_names: tuple[str, ...]
    parts: tuple[PartSkeleton, ...] = ()


def mode_name(automaton: Outline, mode: int, memory: Sequence[float]) -> str:
    """Return the name of a mode; where local modes are data, those of all parts in their order.

    Parameters
    ----------
    automaton : Outline
    mode : int
    memory : sequence of float, shape (nz,)
    """
    if not automaton.parts:
        return automaton.modes[mode].name
    names, first = [], 0
    for part in automaton.parts:
        names.append(part.local_modes[round(memory[first])])
        first += len(part.memory)
    return " + ".join(names)


_SYMBOLS = ("states", "memory", "parameters", "definitions", "uncontrolled")


def outline_data(automaton: Outline) -> dict[str, Any]:
    """Return names and structure as JSON-ready data; a symbol is its name and its assumptions."""
    data: dict[str, Any] = {
        field: [_named(s) for s in getattr(automaton, field)] for field in _SYMBOLS
    }
    modes = [
        (
            m.name,
            [
                (t.label, t.kind, t.stop.name if t.stop else None, t.contact, t.bound, t.decides)
                for t in m.transitions
            ],
        )
        for m in automaton.modes
    ]
    names = {n: getattr(automaton, n) for n in ("kinds", "contacts", "output_names")}
    parts = [(p.name, [_named(s) for s in p.memory], p.local_modes) for p in automaton.parts]
    return data | {"name": automaton.name, "modes": modes, "parts": parts} | names


def _named(symbol: sp.Symbol) -> tuple[str, dict[str, bool | None]]:
    return symbol.name, _assumed(symbol)


def _assumed(symbol: sp.Symbol) -> dict[str, bool | None]:
    """Return what a symbol is declared with: one word, where the others follow from it."""
    for word in ("real", "positive", "nonnegative"):
        if sp.Symbol(symbol.name, **{word: True}) == symbol:
            return {word: True}
    everything: dict[str, bool | None] = symbol.assumptions0
    return everything


def outline_of(data: dict[str, Any]) -> Skeleton:
    """Return the outline that `outline_data` wrote; its symbols equal those of the automaton."""
    modes = tuple(
        ModeSkeleton(
            name,
            tuple(
                TransitionSkeleton(
                    label,
                    EventKind(kind),
                    StopReason[stop] if stop else None,
                    contact,
                    bound,
                    tuple(map(EventKind, decides)),
                )
                for label, kind, stop, contact, bound, decides in transitions
            ),
        )
        for name, transitions in data["modes"]
    )
    symbols = {
        field: tuple(sp.Symbol(name, **assumptions) for name, assumptions in data[field])
        for field in _SYMBOLS
    }
    return Skeleton(
        name=data["name"],
        modes=modes,
        kinds=tuple(map(EventKind, data["kinds"])),
        contacts=tuple(data["contacts"]),
        output_names=tuple(data["output_names"]),
        parts=tuple(
            PartSkeleton(name, tuple(sp.Symbol(n, **a) for n, a in memory), tuple(local_modes))
            for name, memory, local_modes in data["parts"]
        ),
        **symbols,
    )
