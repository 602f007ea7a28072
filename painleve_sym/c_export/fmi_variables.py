"""The variables of an FMU: parameters, inputs, states, outputs and modes, with names of FMI."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from painleve_sym.c_export.files import StartedCode
from painleve_sym.escape import c_name
from painleve_sym.mechanics.declarations import TIME_NAME
from painleve_sym.mechanics.inputs import instant_name
from painleve_sym.quantities import quantity, unit_of

CONTACT_OUTPUTS = ("gap", "slip_velocity", "normal_force", "tangential_force")
"""Quantities of a contact that are outputs of an FMU, besides coordinates and velocities."""
FORCE = "initial_force"


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU; its value reference is its place in the list of all.

    Attributes
    ----------
    name : str
        Unique, and an identifier of C and Modelica.
    kind : str
        Of what it is an element, as in ``fmu.c``.
    index : int
        Its place there.
    causality, variability : str
        As FMI has them.
    meaning, unit : str
    start : float, optional
        Where it is given.
    least, most : float, optional
        Range, where there is one.
    items : tuple of str
        Names of the values, from 1 on, of an enumeration; empty for a number.
    """

    name: str
    kind: str
    index: int
    causality: str
    variability: str
    meaning: str
    unit: str = "1"
    start: float | None = None
    least: float = -float("inf")
    most: float = float("inf")
    items: tuple[str, ...] = ()

    @property
    def whole(self) -> bool:
        """Whether its values are whole numbers."""
        return bool(self.items) or self.kind == "EVENTS"


def variables(case: StartedCode) -> tuple[Variable, ...]:
    """Return all variables in the order of their value references."""
    taken: set[str] = set()
    return tuple(_renamed(v, taken) for v in _variables(case))


def _variables(case: StartedCode) -> Iterator[Variable]:
    yield Variable("time", "TIME", 0, "independent", "continuous", "time", "s")
    yield from _parameters(case)
    if case.initial_force is not None:
        meaning = "normal force with which the contact is pressed at the start"
        start = case.initial_force
        yield Variable(FORCE, "FORCE", 0, "parameter", "fixed", meaning, "N", start, 0.0)
    yield from _states(case)
    yield from _outputs(case)
    yield from _memory(case)
    yield from _modes(case)
    yield Variable("events", "EVENTS", 0, "local", "discrete", "number of events so far")


def instants(case: StartedCode) -> list[int]:
    """Return the places of parameters that are the time at which inputs have their derivatives."""
    names = case.outline.parameter_names
    declared = [p for p in case.declared.values() if p.input_of]
    return [names.index(p.name) for p in declared if p.name == instant_name(p.input_of)]


def _parameters(case: StartedCode) -> Iterator[Variable]:
    hidden = instants(case)
    for i, name in enumerate(case.outline.parameter_names):
        own = case.declared[name]
        kind = ("input", "continuous") if name in case.inputs else ("parameter", "tunable")
        if i not in hidden:
            text, value = own.meaning, case.parameters[name]
            ends = own.lower, own.upper
            yield Variable(name, "PARAMETER", i, *kind, text, own.unit, value, *ends)


def _states(case: StartedCode) -> Iterator[Variable]:
    outline = case.simulator.mechanism.outline
    meanings = {c.name: c.meaning for c in outline.coordinates}
    meanings |= {v.name: v.meaning for v in outline.velocities}
    meanings[TIME_NAME] = "time of what moves as prescribed"
    for i, name in enumerate(case.outline.state_names):
        given = case.motion.tolist()[i] if i < case.motion_count else None
        causality = "output" if given is not None or _shown(name) else "local"
        meaning = meanings.get(name) or _meaning(name)
        unit = unit_of(name, outline.state_units)
        yield Variable(name, "STATE", i, causality, "continuous", meaning, unit, given)


def _outputs(case: StartedCode) -> Iterator[Variable]:
    units = case.simulator.units
    for i, name in enumerate(case.outline.output_names):
        if name not in case.outline.state_names:
            causality = "output" if _shown(name) else "local"
            meaning, unit = _meaning(name), unit_of(name, units)
            yield Variable(name, "OUTPUT", i, causality, "continuous", meaning, unit)


def _memory(case: StartedCode) -> Iterator[Variable]:
    of_parts = {name for part in case.outline.parts for name in part.memory}
    for i, name in enumerate(case.outline.memory_names):
        if name not in of_parts:
            unit = unit_of(name, case.simulator.units)
            yield Variable(name, "MEMORY", i, "local", "discrete", _meaning(name), unit)


def _modes(case: StartedCode) -> Iterator[Variable]:
    outline = case.outline
    kind = "MODE", "output", "discrete"
    if not outline.parts:
        items = _fit(mode.name for mode in outline.modes)
        yield Variable("mode", kind[0], 0, *kind[1:], "what the contact does", items=items)
    for part in outline.parts:
        at = outline.memory_names.index(part.memory[0])
        meaning = f"what contact {part.name} does"
        items = _fit(part.local_modes)
        yield Variable(f"mode_{part.name}", kind[0], at, *kind[1:], meaning, items=items)


def _shown(name: str) -> bool:
    return any(name == shown or name.startswith(f"{shown}_") for shown in CONTACT_OUTPUTS) and not (
        name.endswith("_dot")
    )


def _meaning(name: str) -> str:
    known = quantity(name)
    return known.meaning if known else ""


def _fit(names: Iterable[str]) -> tuple[str, ...]:
    """Return names as different identifiers."""
    taken: set[str] = set()
    return tuple(_unique(name, taken) for name in names)


def _renamed(variable: Variable, taken: set[str]) -> Variable:
    """Return a variable whose name is an identifier, and not taken."""
    values: dict[str, Any] = {**vars(variable), "name": _unique(variable.name, taken)}
    return Variable(**values)


def _unique(name: str, taken: set[str]) -> str:
    own = c_name(name)
    own = own if own[:1].isalpha() else f"v_{own}"
    while own in taken:
        own += "_"
    taken.add(own)
    return own
