"""From what a user gives (names and numbers) to checked parameters and states."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import cast

from painleve_sym.checks import LARGEST, by_name, checked_number
from painleve_sym.contacts.closing import closed_state
from painleve_sym.contacts.contact_numbers import domain_margins
from painleve_sym.errors import InputError, received, unknown_name
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.units import Value, in_unit


def _raise(where: str, faults: Sequence[str]) -> None:
    if faults:
        raise InputError(f"{where}: " + " ".join(faults))


def resolve_state(
    mechanism: Mechanism,
    given: Mapping[str, Value],
    parameters: Mapping[str, float],
    close: str | None = None,
) -> dict[str, float]:
    """Return coordinates, velocities, and ``t`` where it occurs; what is not given is 0.

    Where `close` names a coordinate, it is solved for (see `closed_state`).

    Raises
    ------
    InputError
        Unknown names, values that are not finite, a state outside the mechanism's domain, nothing
        that closes the contact.
    """
    values = state_values(mechanism, given)
    if close is not None:
        values = closed_state(mechanism, values, parameters, close)
    if mechanism.outline.domain:
        every = {**values, **parameters}
        point = [every[name] for name in mechanism.outline.argument_names]
        margins = domain_margins(mechanism).of_vector(point)
        refuse_outside(mechanism, values, parameters, margins)
    return values


def refuse_outside(
    mechanism: Mechanism,
    state: Mapping[str, float],
    parameters: Mapping[str, float],
    margins: Sequence[float],
) -> None:
    """Raise InputError where a margin of the domain is not positive."""
    faults = list[str]()
    for bound, margin in zip(mechanism.outline.domain, margins, strict=True):
        if not margin > 0:
            received = ", ".join(f"{n} = {state.get(n, parameters.get(n))!r}" for n in bound.names)
            faults.append(
                f"got {received}, need {bound.margin} > 0 ({bound.meaning})."
                f"{_in_degrees(mechanism, bound.names, state)}"
            )
    _raise(f"state of {mechanism.name!r}", faults)


def _in_degrees(mechanism: Mechanism, names: Sequence[str], state: Mapping[str, float]) -> str:
    """Return a sentence where an angle is of the size of degrees."""
    units = mechanism.state_units
    for name in names:
        if units.get(name) == "rad" and 2 * math.pi < abs(state[name]) <= 360:
            value = state[name]
            return (
                f" Fix: angles are in rad; {name}={value:g}deg is {name}={math.radians(value):.6g}."
            )
    return ""


def state_values(mechanism: Mechanism, given: Mapping[str, Value]) -> dict[str, float]:
    """Return what `resolve_state` returns, without a look at the domain."""
    values = dict.fromkeys(mechanism.state_names, 0.0)
    if type(given) is not dict:
        given = _by_name(mechanism, given)
    numbers, known = given.values(), len(values)
    # A check of all at once; where it fails, each is looked at.
    if all(type(v) is float and abs(v) <= LARGEST for v in numbers):
        whole = {**values, **given}
        if len(whole) == known:
            return cast(dict[str, float], whole)
    where, faults = f"state of {mechanism.name!r}", list[str]()
    for name, value in given.items():
        if name not in values:
            faults.append(unknown_name("state", name, values))
            continue
        if isinstance(value, str):
            value = in_unit(value, mechanism.state_units[name], f"{where}: state {name}")
        values[name], fault = checked_number(value, f"state {name}")
        if fault:
            faults.append(fault)
    _raise(where, faults)
    return values


def _by_name(mechanism: Mechanism, given: object) -> Mapping[str, Value]:
    """Return a state by names; InputError where it is none, with the way from a list."""
    where, names = f"state of {mechanism.name!r}", mechanism.state_names
    if isinstance(given, list | tuple) and len(given) == len(names):
        raise InputError(
            f"{where}: got {received(given)}, need numbers by name. "
            f"Fix: dict(zip(mechanism.state_names, {list(given)}))."
        )
    return by_name(given, where)


def symbol_values(
    mechanism: Mechanism, state: Mapping[str, float], parameters: Mapping[str, float]
) -> dict[object, float]:
    """Return the values keyed by the mechanism's symbols."""
    system = mechanism.system
    values: dict[object, float] = {s: state[s.name] for s in mechanism.motion if s.name in state}
    values |= {p.symbol: parameters[p.name] for p in system.parameters if p.name in parameters}
    return values
