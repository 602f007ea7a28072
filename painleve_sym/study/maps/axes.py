"""Axes and constant values of a map: names and numbers checked, ranges chosen."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.at.closing import closed_states, unknowns
from painleve_sym.at.delassus import domain_margins
from painleve_sym.checks import StateLike, names_of, number, whole_number
from painleve_sym.errors import InputError, received, refuse_unknown
from painleve_sym.mechanics.declarations import TIME_NAME, Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.units import Value

MIN_POINTS, MAX_POINTS = 5, 2000
"""Along an axis: fewer show nothing, the square of more does not fit into a laptop's memory."""
BEYOND = 1.25
"""Part of the threshold μ_P that a friction axis reaches at least: past (2/√3) μ_P."""
SLIP_DIRECTION = "slip_direction"
"""An axis of a map in space: the angle of slip from t1 towards t2; rad."""
SPEED = 5.0
"""Velocities are drawn from −5 to 5, in rad/s or m/s, unless a range is given."""


@dataclass(frozen=True)
class MapPlace:
    """Domain of a map: two axes with their values, and the constant values.

    Messages name `where` as the place of a fault. State and parameters are without the axes.
    `close` is solved for at every point, the state having its first guess; see `closed_state`.
    `solved` holds its values on the grid once they are known, as guesses between the points.
    """

    where: str
    over: tuple[str, str]
    labels: tuple[str, str]
    units: tuple[str, str]
    values: tuple[Array, Array]
    state: dict[str, float]
    parameters: dict[str, float]
    mechanism: Mechanism
    close: str = ""
    solved: Mapping[str, Array] = field(default_factory=dict)

    def at(self, first: Array, second: Array) -> dict[str, Any]:
        """Return the values of all names at points of the map, nan where no contact closes."""
        values: dict[str, Any] = {**self.state, **self.parameters}
        values |= dict(zip(self.over, (first, second), strict=True))
        if self.close:
            guesses = self._guesses(values, first, second) if self.solved else {}
            values |= closed_states(self.mechanism, values | guesses, self.close)
        return values

    def _guesses(self, values: Mapping[str, Any], first: Array, second: Array) -> dict[str, Array]:
        """Return initial guesses: closing values at the nearest points of the grid."""
        parts = zip((first, second), self.values, strict=True)
        cells = [(at - v[0]) / (v[1] - v[0]) for at, v in parts]
        # Newton's method may leave the grid, or the numbers.
        nearest = tuple(
            np.clip(np.rint(np.nan_to_num(cell)), 0, len(v) - 1).astype(int)
            for cell, v in zip(cells, self.values, strict=True)
        )
        known = {name: grid[nearest] for name, grid in self.solved.items()}
        return {n: np.where(np.isfinite(v), v, values[n]) for n, v in known.items()}

    def grid(self) -> dict[str, Any]:
        """Return the values of all names on the grid."""
        return self.at(self.values[0][:, None], self.values[1][None, :])

    def with_solved(self, grid: Mapping[str, Any]) -> MapPlace:
        """Return the place with the closing values on its grid known."""
        named = unknowns(self.mechanism, self.close) if self.close else ()
        shape = len(self.values[0]), len(self.values[1])
        solved = {u.name: np.broadcast_to(grid[u.name], shape) for u in named}
        return dataclasses.replace(self, solved=solved)


def map_place(
    mechanism: Mechanism,
    over: str | Sequence[str],
    ranges: Mapping[str, tuple[Value, Value]],
    points: int,
    state: StateLike | None,
    parameters: Mapping[str, Value],
    close: str | None,
) -> MapPlace:
    """Return the checked axes and held numbers of a map (see `region_map`)."""
    where = f"map of {mechanism.name!r}"
    whole_number(points, "points along each axis", where=where, lower=MIN_POINTS, upper=MAX_POINTS)
    axes = _checked_names(mechanism, where, over)
    solved = [u.name for u in unknowns(mechanism, close)] if close is not None else []
    for name in solved:
        if name in axes:
            raise InputError(f"{where}: close: {name} is an axis. Fix: name another coordinate.")
    given = {} if state is None else mechanism.outline.named_state(f"{where}: state", state)
    for name in (*given, *parameters):
        if name in axes:
            raise InputError(f"{where}: {name} is an axis. Fix: give it a range, not one value.")
    for name in ranges:
        refuse_unknown("axis", name, axes, f"{where}: range")
    held = mechanism.start if state is None else given
    # The domain may depend on the axes: points outside are masked, not rejected.
    place = mechanism.at({n: v for n, v in held.items() if n not in axes}, parameters, where=where)
    start, values = place.state, place.parameters
    spans = [
        _checked_range(mechanism, where, name, ranges[name])
        if name in ranges
        else default_range(mechanism, name, start, values)
        for name in axes
    ]
    grid = [np.linspace(*span, points) for span in spans]
    for name, line in zip(axes, grid, strict=True):
        if not (np.diff(line) > 0).all():
            raise InputError(
                f"{where}: range {name}: its {points} points are not distinct numbers."
            )
    labels, units = zip(*(_described(mechanism, name) for name in axes), strict=True)
    return MapPlace(
        where=where,
        over=axes,
        labels=labels,
        units=units,
        values=(grid[0], grid[1]),
        state={n: v for n, v in start.items() if n not in axes},
        parameters={n: v for n, v in values.items() if n not in axes},
        mechanism=mechanism,
        close=close or "",
    )


def reaching(
    place: MapPlace, ranges: Mapping[str, tuple[Value, Value]], threshold: float | None
) -> MapPlace:
    """Return the place with a friction axis that goes beyond the threshold μ_P.

    An axis with a range of its own stays; so does one that goes there already.
    """
    name = place.mechanism.outline.contacts[0].friction
    if threshold is None or name not in place.over or name in ranges:
        return place
    axis = place.over.index(name)
    old, high = place.values[axis], BEYOND * threshold
    parameter = _parameter(place.mechanism, name)
    if high <= old[-1] or (parameter is not None and parameter.fault(high)):
        return place
    values = list(place.values)
    values[axis] = np.linspace(old[0], high, len(old))
    return dataclasses.replace(place, values=(values[0], values[1]))


def checked_slip(mechanism: Mechanism, slip: float | None) -> float:
    """Return the direction of slip, −1 or 1, in space an angle in rad; against t1 where none is."""
    where = f"map of {mechanism.name!r}"
    if mechanism.outline.in_space:
        return number(math.pi if slip is None else slip, "slip, an angle in space", where=where)
    if str(slip) not in ("-1", "1", "None"):
        raise InputError(f"{where}: slip: got {received(slip)}, need -1 or 1, the sign of v_t.")
    return -1 if slip is None else int(slip)


def axis_units(mechanism: Mechanism) -> dict[str, str]:
    """Return the SI unit of everything that may be an axis, in space also of the slip's angle."""
    angle = {SLIP_DIRECTION: "rad"} if mechanism.outline.in_space else {}
    return mechanism.units | angle


def _checked_names(mechanism: Mechanism, where: str, axes: str | Sequence[str]) -> tuple[str, str]:
    over = names_of(axes, f"{where}: axes")
    known = axis_units(mechanism)
    for name in over:
        refuse_unknown("axis", name, known, where)
        if fault := mechanism.outline.part_fault(name):
            fix = "Fix: map over velocities or parameters, or give the body angles."
            raise InputError(f"{where}: {fault} {fix}")
    if len(over) != 2 or over[0] == over[1]:
        received = ", ".join(over) or "none"
        raise InputError(f"{where}: axes: got {received}, need two different names.")
    return over[0], over[1]


def _parameter(mechanism: Mechanism, name: str) -> Parameter | None:
    return next((p for p in mechanism.outline.parameters if p.name == name), None)


def _checked_range(mechanism: Mechanism, where: str, name: str, span: Any) -> tuple[float, float]:
    unit = axis_units(mechanism)[name]
    try:
        low, high = (
            number(end, f"range {name}", where=where, unit=unit)
            for end in (() if isinstance(span, str) else span)
        )
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{where}: range {name}: got {received(span)}, need two numbers."
        ) from error
    if not low < high:
        fix = f"{high:g}:{low:g}" if low > high else "two different ends"
        raise InputError(
            f"{where}: range {name}: got {low:g}:{high:g}, need from < to. Fix: give {fix}."
        )
    parameter = _parameter(mechanism, name)
    faults = [parameter.fault(v) for v in (low, high)] if parameter is not None else []
    for fault in filter(None, faults):
        raise InputError(f"{where}: range {name}: {fault}")
    return low, high


def default_range(
    mechanism: Mechanism, name: str, state: Mapping[str, float], parameters: Mapping[str, float]
) -> tuple[float, float]:
    """Return the range of an axis that was not given one.

    Angles: what of −π to π is inside the domain; other coordinates −1 to 1 m; velocities −5 to 5;
    the time 0 to 1 s; parameters from nearly 0 to twice the default, which must be allowed.
    `reaching` extends that of a friction coefficient.
    """
    parameter = _parameter(mechanism, name)
    if parameter is not None:
        return parameter_range(parameter)
    if name == SLIP_DIRECTION:
        return -math.pi, math.pi
    if name in mechanism.outline.velocity_names:
        return -SPEED, SPEED
    if name == TIME_NAME:
        return 0.0, 1.0
    coordinate = next(c for c in mechanism.outline.coordinates if c.name == name)
    if coordinate.unit != "rad":
        return -1.0, 1.0
    angles = np.linspace(-math.pi, math.pi, 721)
    if mechanism.outline.domain:
        held = dict.fromkeys(mechanism.outline.argument_names, math.nan) | {**state, **parameters}
        values = {n: np.full(len(angles), v) for n, v in held.items()} | {name: angles}
        inside = angles[(domain_margins(mechanism).rows(values) > 0).all(axis=0)]
        angles = inside if len(inside) > 1 else angles
    return float(angles[0]), float(angles[-1])


def parameter_range(parameter: Parameter) -> tuple[float, float]:
    """Return from nearly 0 to twice the default, as far as that is allowed."""
    size = abs(parameter.default) or 1.0
    low, high = parameter.default - size, parameter.default + size
    if parameter.fault(low):
        low = parameter.lower if not parameter.fault(parameter.lower) else size / 20
    if parameter.fault(high):
        high = parameter.upper if not parameter.fault(parameter.upper) else parameter.default
    return low, high


def _described(mechanism: Mechanism, name: str) -> tuple[str, str]:
    """Return LaTeX and unit of an axis."""
    if name == SLIP_DIRECTION:
        return r"\varphi", "rad"
    return mechanism.latex_names[name], mechanism.units[name]
