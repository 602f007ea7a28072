"""An automaton without its formulas: names and structure, which is all that a run is read with."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from painleve_sym.errors import EventKind, StopReason

if TYPE_CHECKING:
    from sympy import Symbol

    from painleve_sym.hybrid.automaton import HybridAutomaton


class AutomatonBuilder(Protocol):
    """Anything that derives an automaton: a frozen dataclass that says from what."""

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

    def to_data(self) -> dict[str, Any]:
        """Return JSON-ready data."""
        modes = [
            (name, [(*t[:2], t.stop.name if t.stop else None, *t[3:]) for t in transitions])
            for name, transitions in self.modes
        ]
        return {f.name: getattr(self, f.name) for f in fields(self)} | {"modes": modes}

    @classmethod
    def of_data(cls, data: Mapping[str, Any]) -> Outline:
        """Return the outline that `to_data` wrote."""
        modes = tuple(
            ModeOutline(name, tuple(map(_transition, transitions)))
            for name, transitions in data["modes"]
        )
        texts = {name: tuple(data[name]) for name in data if name.endswith("_names")}
        return cls(
            name=data["name"],
            modes=modes,
            kinds=tuple(map(EventKind, data["kinds"])),
            contacts=tuple(data["contacts"]),
            parts=tuple(PartOutline(n, tuple(m), tuple(own)) for n, m, own in data["parts"]),
            **texts,
        )


def _names(symbols: Iterable[Symbol]) -> tuple[str, ...]:
    return tuple(s.name for s in symbols)


def _transition(data: Sequence[Any]) -> TransitionOutline:
    label, kind, stop, contact, bound = data
    reason = StopReason[stop] if stop else None
    return TransitionOutline(label, EventKind(kind), reason, contact, bound)


def mode_name(outline: Outline, mode: int, memory: Sequence[float]) -> str:
    """Return the name of a mode; where local modes are data, those of all parts in their order."""
    if not outline.parts:
        return outline.modes[mode].name
    names, first = [], 0
    for part in outline.parts:
        names.append(part.local_modes[round(memory[first])])
        first += len(part.memory)
    return " + ".join(names)
