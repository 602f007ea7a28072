"""An automaton without its formulas: names and structure, which is all that a run is read with."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

from painleve_sym.errors import EventKind, StopReason

if TYPE_CHECKING:
    from sympy import Symbol

    from painleve_sym.automata.automaton import HybridAutomaton


class AutomatonBuilder(Protocol):
    """Protocol of a builder of an automaton: a frozen dataclass of all that it is derived from."""

    @property
    def title(self) -> str:
        """The mechanism and its laws in a few words."""

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


class ModeOutline(NamedTuple):
    """A `Mode` without field and outputs."""

    name: str
    transitions: tuple[TransitionOutline, ...]


class PartOutline(NamedTuple):
    """A `Part` without its alternatives."""

    name: str
    memory: tuple[str, ...]
    local_modes: tuple[str, ...]


@dataclass(frozen=True)
class Outline:
    """Names and structure of an automaton; stored beside its library, it needs no derivation.

    Attributes as those of `HybridAutomaton`, with names in place of symbols.
    """

    name: str
    state_names: tuple[str, ...]
    memory_names: tuple[str, ...]
    parameter_names: tuple[str, ...]
    definition_names: tuple[str, ...]
    modes: tuple[ModeOutline, ...]
    kinds: tuple[EventKind, ...]
    contacts: tuple[str, ...]
    output_names: tuple[str, ...]
    parts: tuple[PartOutline, ...]

    def __repr__(self) -> str:
        """Return the name and the modes in one line."""
        return f"Outline of {self.name!r}: modes {', '.join(mode.name for mode in self.modes)}"

    @classmethod
    def of(cls, automaton: HybridAutomaton) -> Outline:
        """Return the outline of an automaton."""
        modes = tuple(
            ModeOutline(
                m.name,
                tuple(
                    TransitionOutline(t.label, t.kind, t.stop, t.contact, t.bound)
                    for t in m.transitions
                ),
            )
            for m in automaton.modes
        )
        return cls(
            name=automaton.name,
            state_names=_names(automaton.states),
            memory_names=_names(automaton.memory),
            parameter_names=_names(automaton.parameters),
            definition_names=_names(automaton.definitions),
            modes=modes,
            kinds=automaton.kinds,
            contacts=automaton.contacts,
            output_names=automaton.output_names,
            parts=tuple(
                PartOutline(p.name, _names(p.memory), p.local_modes) for p in automaton.parts
            ),
        )

    @property
    def constant_names(self) -> tuple[str, ...]:
        """Names of parameters and definitions, as an engine's constants."""
        return (*self.parameter_names, *self.definition_names)


def _names(symbols: Iterable[Symbol]) -> tuple[str, ...]:
    return tuple(s.name for s in symbols)


def mode_name(outline: Outline, mode: int, memory: Sequence[float]) -> str:
    """Return the name of a mode; of local modes in memory, the names of all parts."""
    if not outline.parts:
        return outline.modes[mode].name
    names, first = [], 0
    for part in outline.parts:
        names.append(part.local_modes[round(memory[first])])
        first += len(part.memory)
    return " + ".join(names)
