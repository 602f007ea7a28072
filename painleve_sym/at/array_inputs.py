"""Arrays of states and parameters, checked as a whole."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.checks import LARGEST, StateLike, by_name, size_text
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.declarations import Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.units import in_unit


def given_arrays(
    where: str,
    mechanism: Mechanism,
    states: StateLike,
    parameters: Mapping[str, Any] | None,
    declared: Mapping[str, Parameter],
) -> tuple[dict[str, Array], list[str]]:
    """Return states and parameters by name, with defaults, and a sentence for each fault.

    States that are not given are 0. `declared` are the parameters that may be given.
    """
    values: dict[str, Array] = {n: np.array(0.0) for n in mechanism.state_names}
    values |= {n: np.array(p.default) for n, p in declared.items()}
    units = mechanism.state_units | {n: p.unit for n, p in declared.items()}
    named = mechanism.outline.named_state(f"{where}: states", _as_array(states))
    faults = list[str | None]()
    for kind, given, known in (
        ("state", named, mechanism.state_names),
        ("parameter", parameters, tuple(declared)),
    ):
        for name, entries in by_name(given, f"{where}: {kind}s").items():
            if name not in known:
                faults.append(unknown_name(kind, name, known))
                continue
            values[name], fault = numbers_of(f"{kind} {name}", entries, units[name])
            if kind == "parameter" and fault is None:
                fault = next(filter(None, map(declared[name].fault, _ends(values[name]))), None)
            faults.append(fault)
    return values, list(filter(None, faults))


def common_shape(where: str, values: Mapping[str, Array]) -> tuple[int, ...]:
    """Return the shape to which arrays broadcast; InputError where they do not."""
    try:
        return np.broadcast_shapes(*(a.shape for a in values.values()))
    except ValueError:
        shapes = ", ".join(f"{n} {a.shape}" for n, a in values.items() if a.ndim)
        raise InputError(
            f"{where}: the arrays' shapes do not fit each other: {shapes}. Fix: give arrays "
            "that broadcast, as numpy does."
        ) from None


def _as_array(states: StateLike) -> StateLike:
    """Return a list of lists as an array, whose last axis is that of the states."""
    if isinstance(states, list | tuple):
        with suppress(TypeError, ValueError):
            return np.asarray(states, dtype=np.float64)
    return states


def _ends(values: Array) -> tuple[float, ...]:
    """Return the least and the largest number, or the only one."""
    return (float(values.min()), float(values.max())) if values.ndim else (float(values),)


def numbers_of(name: str, given: Any, unit: str) -> tuple[Array, str | None]:
    """Return the numbers of a quantity, or a sentence where it has others than finite ones."""
    if type(given) is float and abs(given) <= LARGEST:  # as most are
        return np.array(given), None
    if isinstance(given, str):
        given = in_unit(given, unit, name)
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        return np.zeros(()), f"{name}: got {given!r}, need numbers."
    if not values.size:
        return np.zeros(()), f"{name}: got no numbers, need at least one."
    usable = np.abs(values) <= LARGEST
    if not usable.all():
        place = np.unravel_index(np.argmin(usable), values.shape)
        value, at = float(values[place]), f" at {list(map(int, place))}" if place else ""
        need = f"finite numbers{size_text(value)}"
        return np.zeros(()), f"{name}: got {value!r}{at}, need {need}."
    return values, None
