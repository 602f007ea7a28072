"""A state in contact: gap = 0 solved for a coordinate, gap_rate = 0 for a velocity."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contacts.contact_numbers import (
    CONTACT_TOLERANCE,
    argument_names,
    argument_symbols,
    contact_numbers,
    domain_margins,
)
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.mechanism import Mechanism

_FINE = 2000
"""Even steps of the search on each side: over a turn of an angle, or 4 lengths."""
_COARSE = np.geomspace(1.0, 1e6, 1400)[1:]
"""Steps of 1 % beyond them, as multiples of what the even ones cover."""
_POLISH = 3
_TRIED = 100
"""Roots that are looked at until one is inside the domain."""

Gap = Callable[[Array], tuple[Array, Array]]
"""Gap and its derivative at many values of one coordinate."""


@dataclass(frozen=True)
class Unknown:
    """Coordinate that closes a contact, and perhaps a velocity.

    Attributes
    ----------
    contact : int
        Which contact of the mechanism.
    coordinate : str
        Name of the coordinate.
    name : str
        The coordinate, which makes gap = 0, or its velocity, which makes gap_rate = 0.
    """

    contact: int
    coordinate: str
    name: str

    @property
    def is_velocity(self) -> bool:
        """Whether gap_rate = 0 is solved."""
        return self.name != self.coordinate


def closed_state(
    mechanism: Mechanism, state: Mapping[str, float], parameters: Mapping[str, float], close: str
) -> dict[str, float]:
    """Return the state with the contact closed: the named values are replaced by solutions.

    Parameters
    ----------
    mechanism : Mechanism
    state, parameters : mapping of str to float
        Complete; SI units, rad.
    close : str
        A coordinate: gap = 0 is solved for it. A velocity: gap_rate = 0 is solved for it. One of
        each may be named, separated by a comma. With several contacts ``CONTACT:NAME``.

    Returns
    -------
    dict of str to float
        Of the roots inside the mechanism's domain, the nearest to the given value; the given value
        where the contact is closed already (within `closed_within`).

    Raises
    ------
    InputError
        Unknown names; a gap that does not depend on the coordinate; no root.

    Examples
    --------
    >>> from painleve_sym import models
    >>> arm = models.two_link_arm()
    >>> state = dict.fromkeys(arm.state_names, 0.0) | {"theta_1": -0.6}
    >>> round(closed_state(arm, state, arm.parameters, "theta_2")["theta_2"], 6)
    -0.988783
    """
    where = f"close {mechanism.name!r}"
    values = dict(state)
    for unknown in unknowns(mechanism, close):
        solve = _closing_velocity if unknown.is_velocity else _closing_coordinate
        values[unknown.name] = solve(where, mechanism, unknown, {**values, **parameters})
    return values


def unknowns(mechanism: Mechanism, close: str) -> tuple[Unknown, ...]:
    """Return what `close` names, the coordinate first; see `closed_state`."""
    where = f"close {mechanism.name!r}"
    named = sorted((_unknown(where, mechanism, part) for part in close.split(",")), key=_second)
    kinds = [unknown.is_velocity for unknown in named]
    if len(kinds) != len(set(kinds)):
        raise InputError(
            f"{where}: got {close!r}, need at most one coordinate and one velocity, such as "
            f"{named[0].coordinate} or {named[0].coordinate},{named[0].coordinate}_dot."
        )
    return tuple(named)


def _second(unknown: Unknown) -> bool:
    # The normal velocity depends on the coordinate.
    return unknown.is_velocity


def _unknown(where: str, mechanism: Mechanism, text: str) -> Unknown:
    contact, colon, name = (part.strip() for part in text.rpartition(":"))
    contacts = [c.name for c in mechanism.outline.contacts]
    if colon and contact not in contacts:
        raise InputError(f"{where}: {unknown_name('contact', contact, contacts)}")
    if not colon and len(contacts) > 1:
        raise InputError(
            f"{where}: got {text!r}, need CONTACT:COORDINATE, such as {contacts[0]}:{name}: "
            f"there are the contacts {', '.join(contacts)}."
        )
    coordinates = [c.name for c in mechanism.outline.coordinates]
    of_velocity = dict(zip(mechanism.outline.velocity_names, coordinates, strict=True))
    if name not in coordinates and name not in of_velocity:
        raise InputError(f"{where}: {unknown_name('coordinate', name, coordinates)}")
    i = contacts.index(contact) if colon else 0
    unknown = Unknown(i, of_velocity.get(name, name) if name not in coordinates else name, name)
    known = gap_slopes(mechanism, i).names
    dependent = [c for c in coordinates if f"gap_by_{c}" in known]
    if unknown.coordinate not in dependent:
        subject = "gap" if not unknown.is_velocity else "normal velocity"
        need = ", ".join(f"{c}_dot" if unknown.is_velocity else c for c in dependent)
        raise InputError(
            f"{where}: the {subject} of contact {contacts[i]!r} does not depend on {name}. "
            + (f"Fix: name one of {need}." if dependent else "No coordinate changes it.")
        )
    return unknown


def gap_slopes(mechanism: Mechanism, i: int) -> Quantities:
    """Return gap, gap_rate, and gap_by_NAME for every coordinate that the gap depends on."""

    def derive() -> tuple[dict[str, Any], tuple[Any, ...]]:
        contact, system = mechanism.contacts[i], mechanism.system
        slopes = {f"gap_by_{q.name}": contact.gap.diff(q) for q in system.q}
        formulas = {"gap": contact.gap, "gap_rate": contact.gap_rate}
        formulas |= {name: slope for name, slope in slopes.items() if slope != 0}
        return formulas, argument_symbols(mechanism)

    return quantities(f"gap {i}", mechanism.definition, argument_names(mechanism), derive)


def _closing_velocity(
    where: str, mechanism: Mechanism, unknown: Unknown, values: Mapping[str, float]
) -> float:
    """Return the velocity with gap_rate = 0, which is linear in it."""
    at = gap_slopes(mechanism, unknown.contact)(values)
    slope = at[f"gap_by_{unknown.coordinate}"]
    velocity = values[unknown.name] - at["gap_rate"] / slope if slope else math.nan
    if not math.isfinite(velocity):
        raise InputError(
            f"{where}: {unknown.name} does not change the normal velocity at this state, which is "
            f"{at['gap_rate']:g} m/s. Fix: name another velocity, or give another state."
        )
    return velocity


def _closing_coordinate(
    where: str, mechanism: Mechanism, unknown: Unknown, values: Mapping[str, float]
) -> float:
    """Return the nearest value of the coordinate with gap = 0; inside the domain where one is."""
    i, name = unknown.contact, unknown.name
    slopes = gap_slopes(mechanism, i)
    at = contact_numbers(mechanism, i)(values)
    start, near = values[name], at["gap_tolerance"]
    if abs(at["gap"]) <= near:
        return start

    def gap(points: Array) -> tuple[Array, Array]:
        numbers = slopes.at(_spread(values, name, points))
        return numbers["gap"], numbers[f"gap_by_{name}"]

    unit = next(c.unit for c in mechanism.outline.coordinates if c.name == name)
    length = max(near / CONTACT_TOLERANCE, abs(start), abs(at["gap"]))
    reach = 2 * math.pi if unit == "rad" else 4 * length
    outside = math.nan
    for root in itertools.islice(_roots(gap, start, reach, near), _TRIED):
        if _in_domain(mechanism, {**values, name: root}):
            return root
        outside = root if math.isnan(outside) else outside
    if math.isnan(outside):
        raise InputError(
            f"{where}: no {name} makes the gap of contact "
            f"{mechanism.outline.contacts[i].name!r} zero; it is {at['gap']:g} m at "
            f"{name} = {start:g} {unit}. Fix: give other coordinates, or name another one."
        )
    return outside


def _in_domain(mechanism: Mechanism, values: Mapping[str, float]) -> bool:
    bounded = mechanism.outline.domain
    return not bounded or all(v > 0 for v in domain_margins(mechanism)(values).values())


def _spread(values: Mapping[str, float], name: str, points: Array) -> dict[str, Array]:
    return {n: points if n == name else np.full(len(points), v) for n, v in values.items()}


def _roots(gap: Gap, start: float, reach: float, near: float) -> Iterator[float]:
    """Yield the zeros that the search meets, the nearest first; also where the gap touches 0."""
    from scipy.optimize import brentq

    even = np.linspace(0.0, reach, _FINE + 1)
    away = np.concatenate([even, reach * _COARSE])
    points = np.concatenate([start - away[:0:-1], start + away])
    with np.errstate(all="ignore"):
        values, slopes = gap(points)

    def zero(of: int, low: float, high: float) -> float:
        def at(x: float) -> float:
            return float(gap(np.array([x]))[of][0])

        return float(brentq(at, low, high, xtol=1e-300, rtol=4 * np.finfo(float).eps))

    finite = np.isfinite(values[:-1]) & np.isfinite(values[1:])
    crosses = finite & (np.sign(values[:-1]) != np.sign(values[1:]))
    turns = finite & ~crosses & (slopes[:-1] * slopes[1:] < 0)
    turns &= values[:-1] * slopes[:-1] < 0
    places = np.flatnonzero(crosses | turns)
    nearest_first = places[np.argsort(np.abs(points[places] + points[places + 1] - 2 * start))]
    for k in nearest_first:
        root = zero(int(turns[k]), points[k], points[k + 1])
        root = _polished(gap, root) if crosses[k] else root
        # A pole changes the sign too; a turn need not reach 0.
        if abs(gap(np.array([root]))[0][0]) <= near:
            yield root


def _polished(gap: Gap, root: float) -> float:
    """Return the root after Newton steps, as long as each brings the gap nearer to 0."""
    for _ in range(_POLISH):
        (value,), (slope,) = gap(np.array([root]))
        better = root - value / slope if slope else root
        if not abs(gap(np.array([better]))[0][0]) < abs(value):
            break
        root = float(better)
    return root
