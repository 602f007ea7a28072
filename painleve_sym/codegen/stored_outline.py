"""The outline of an automaton as plain data, and back."""

from __future__ import annotations

from typing import Any

import sympy as sp

from painleve_sym.errors import StopReason
from painleve_sym.hybrid.outline import ModeSkeleton, Outline, Skeleton, TransitionSkeleton

_SYMBOLS = ("states", "memory", "parameters", "definitions", "uncontrolled")


def outline_data(automaton: Outline) -> dict[str, Any]:
    """Return names and structure as JSON-ready data; a symbol is its name and its assumptions."""
    data: dict[str, Any] = {
        field: [(s.name, s.assumptions0) for s in getattr(automaton, field)] for field in _SYMBOLS
    }
    modes = [
        (m.name, [(t.label, t.kind, t.stop.name if t.stop else None) for t in m.transitions])
        for m in automaton.modes
    ]
    names = {"kinds": automaton.kinds, "output_names": automaton.output_names}
    return data | {"name": automaton.name, "modes": modes} | names


def outline_of(data: dict[str, Any]) -> Skeleton:
    """Return the outline that `outline_data` wrote; its symbols equal those of the automaton."""
    modes = tuple(
        ModeSkeleton(
            name,
            tuple(
                TransitionSkeleton(label, kind, StopReason[stop] if stop else None)
                for label, kind, stop in transitions
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
        kinds=tuple(data["kinds"]),
        output_names=tuple(data["output_names"]),
        **symbols,
    )
