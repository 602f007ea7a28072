"""The door of every computation at a state: from what a user gives to a checked `Place`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from painleve_sym.codegen.named_mechanisms import MechanismLike, as_mechanism
from painleve_sym.contacts.closing import closed_state
from painleve_sym.contacts.delassus import domain_margins
from painleve_sym.errors import InputError
from painleve_sym.mechanics.mechanism import Place
from painleve_sym.units import Value


def place_of(
    mechanism: MechanismLike,
    state: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    close: str | None = None,
    **checks: Any,
) -> Place:
    """Return a checked place; where `close` names a coordinate, it is solved for.

    Parameters are those of `Mechanism.at` and `closed_state`. The domain is not looked at (see
    `inside`).

    Raises
    ------
    InputError
        Unknown names, numbers out of range, nothing that closes the contact.
    """
    place = as_mechanism(mechanism).at(state, parameters, **checks)
    return place if close is None else closed_place(place, close)


def closed_place(place: Place, close: str) -> Place:
    """Return the place with a contact closed; see `closed_state`."""
    state = closed_state(place.mechanism, place.state, place.parameters, close)
    solved = tuple(n for n, v in state.items() if v != place.state[n])
    return replace(place, state=state, given=(*place.given, *solved))


def inside(place: Place) -> Place:
    """Return the place; InputError where it is outside the domain of its mechanism."""
    mechanism = place.mechanism
    if mechanism.outline.domain:
        values = place.values
        point = [values[name] for name in mechanism.outline.argument_names]
        refuse_outside(place, domain_margins(mechanism).of_vector(point))
    return place


def refuse_outside(place: Place, margins: Sequence[float]) -> None:
    """Raise InputError where a margin of the domain is not positive."""
    bounds = place.mechanism.outline.domain
    broken = [b for b, margin in zip(bounds, margins, strict=True) if not margin > 0]
    if not broken:
        return
    faults = []
    for bound in broken:
        received = ", ".join(f"{n} = {place.values[n]!r}" for n in bound.names)
        faults.append(
            f"got {received}, need {bound.margin} > 0 ({bound.meaning})."
            f"{_in_degrees(place, bound.names)}"
        )
    names = {name for bound in broken for name in bound.names}
    if absent := sorted((names & set(place.state)) - set(place.given)):
        faults.append(f"Fix: give {', '.join(absent)} too; what is not given is 0.")
    raise InputError(f"state of {place.mechanism.name!r}: {' '.join(faults)}")


def _in_degrees(place: Place, names: Sequence[str]) -> str:
    """Return a sentence where an angle is of the size of degrees."""
    units, state = place.mechanism.state_units, place.state
    for name in names:
        if units.get(name) == "rad" and 2 * math.pi < abs(value := state[name]) <= 360:
            shown = f"{name}={value:g}deg is {name}={math.radians(value):.6g}"
            return f" Fix: angles are in rad; {shown}."
    return ""
