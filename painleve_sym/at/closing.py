"""A state in contact: gap = 0 solved for a coordinate, gap_rate = 0 for a velocity."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from painleve_sym.arrays import Array
from painleve_sym.at.delassus import Delassus, argument_symbols, domain_margins
from painleve_sym.checks import text_of
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.closed_within import CONTACT_TOLERANCE
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.quaternions import QuaternionPart
from painleve_sym.progress import progress

IntArray = NDArray[np.intp]

_EVEN = 2000
_AWAY = np.concatenate([np.linspace(0.0, 1.0, _EVEN + 1), np.geomspace(1.0, 1e6, 1400)[1:]])
"""Distances of the search on each side, as parts of a turn of an angle or of 4 lengths: even steps
first, then steps of 1 %."""
_TOGETHER = 20_000
"""Values of the gap that are looked at together; the search ends at the roots."""
_HALVINGS = 56
_POLISH = 3

Gap = Callable[[IntArray, Array], tuple[Array, Array]]
"""Gap and its derivative by the coordinate, of states by their numbers, at values of it."""


@dataclass(frozen=True)
class Unknown:
    """Coordinate that closes a contact, and perhaps a velocity.

    Attributes
    ----------
    mechanism : Mechanism
    contact : int
        Which contact of the mechanism.
    coordinate : str
        Name of the coordinate; of a part of an angular velocity, its own.
    name : str
        The coordinate, which makes gap = 0, or its velocity, which makes gap_rate = 0.
    is_velocity : bool
        Whether gap_rate = 0 is solved.
    """

    mechanism: Mechanism
    contact: int
    coordinate: str
    name: str
    is_velocity: bool

    @property
    def slopes(self) -> Quantities:
        """Gap, its rate and its derivatives; see `gap_slopes`."""
        return gap_slopes(self.mechanism, self.contact)


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
    values = dict(state)
    for unknown in unknowns(mechanism, close):
        every = {n: np.array([v]) for n, v in {**values, **parameters}.items()}
        value = float(_solved(unknown, every)[0])
        if not math.isfinite(value):
            raise InputError(_unsolved(unknown, {**values, **parameters}))
        values[unknown.name] = value
    return values


def closed_states(
    mechanism: Mechanism, values: Mapping[str, ArrayLike], close: str
) -> dict[str, Array]:
    """Return the values that close the contact in many states, each as `closed_state` alone.

    Parameters
    ----------
    mechanism : Mechanism
    values : mapping of str to array_like
        Coordinates, velocities and parameters, complete; arrays broadcast against each other.
    close : str
        See `closed_state`.

    Returns
    -------
    dict of str to ndarray
        Of the names in `close`, in the shape of all values; nan where no value closes the contact.
    """
    names = mechanism.outline.argument_names
    every = dict(zip(names, np.broadcast_arrays(*(values[n] for n in names)), strict=True))
    shape = every[names[0]].shape
    flat = {n: np.ascontiguousarray(a, np.float64).reshape(-1) for n, a in every.items()}
    solved = {}
    for unknown in unknowns(mechanism, close):
        solved[unknown.name] = flat[unknown.name] = _solved(unknown, flat)
    return {name: array.reshape(shape) for name, array in solved.items()}


def unknowns(mechanism: Mechanism, close: str) -> tuple[Unknown, ...]:
    """Return the unknowns that `close` names, the coordinate first; see `closed_state`."""
    where = f"close {mechanism.name!r}"
    named = [_unknown(mechanism, where, part) for part in text_of(close, where).split(",")]
    # The normal velocity depends on the coordinate.
    named.sort(key=lambda unknown: unknown.is_velocity)
    kinds = [unknown.is_velocity for unknown in named]
    if len(kinds) != len(set(kinds)):
        raise InputError(
            f"{where}: got {close!r}, need at most one coordinate and one velocity, such as "
            f"{named[0].coordinate} or {named[0].coordinate},{named[0].coordinate}_dot."
        )
    return tuple(named)


def _unknown(mechanism: Mechanism, where: str, text: str) -> Unknown:
    contact, colon, name = (part.strip() for part in text.rpartition(":"))
    outline = mechanism.outline
    contacts = [c.name for c in outline.contacts]
    if colon and contact not in contacts:
        raise InputError(f"{where}: {unknown_name('contact', contact, contacts)}")
    coordinates = [c.name for c in outline.coordinates]
    of_velocity = {v.name: v.row for v in outline.velocities}
    movable = [row for row in of_velocity.values() if row in coordinates]
    if not colon and len(contacts) > 1:
        i = contacts.index(name) if name in contacts else 0
        example = name
        if name not in coordinates and name not in of_velocity:
            slopes = Unknown(mechanism, i, movable[0], movable[0], False).slopes.names
            example = next((row for row in movable if f"gap_by_{row}" in slopes), movable[0])
        raise InputError(
            f"{where}: got {text!r}, need CONTACT:COORDINATE, such as {contacts[i]}:{example}: "
            f"there are the contacts {', '.join(contacts)}."
        )
    if fault := outline.part_fault(name):
        raise InputError(f"{where}: {fault} Fix: name {' or '.join(movable or of_velocity)}.")
    if name not in coordinates and name not in of_velocity:
        raise InputError(f"{where}: {unknown_name('coordinate', name, coordinates)}")
    i = contacts.index(contact) if colon else 0
    unknown = Unknown(mechanism, i, of_velocity.get(name, name), name, name in of_velocity)
    rows = of_velocity if unknown.is_velocity else {name: name for name in movable}
    dependent = [name for name, row in rows.items() if f"gap_by_{row}" in unknown.slopes.names]
    if name not in dependent:
        subject = "normal velocity" if unknown.is_velocity else "gap"
        fix = f"Fix: name one of {', '.join(dependent)}." if dependent else ""
        raise InputError(
            f"{where}: the {subject} of contact {contacts[i]!r} does not depend on {name}. "
            f"{fix or 'No coordinate changes it.'}"
        )
    return unknown


def closing_hint(
    mechanism: Mechanism,
    i: int,
    without: Collection[str] = (),
    otherwise: str = "Fix: start with a gap of 0",
) -> str:
    """Return how to close the i-th contact by a coordinate, as the last sentence of a message.

    Such as ``Fix: close it with --close y_A, in Python close='y_A'``; coordinates that are to be
    left out are `without`. `otherwise` where no other one changes the gap.
    """
    contacts = mechanism.outline.contacts
    front = f"{contacts[i].name}:" if len(contacts) > 1 else ""
    known = gap_slopes(mechanism, i).names
    named = [c.name for c in mechanism.outline.coordinates if f"gap_by_{c.name}" in known]
    named = [f"{front}{name}" for name in named if name not in without]
    if not named:
        return otherwise
    listed = " or ".join(f"--close {name}" for name in named)
    return f"Fix: close it with {listed}, in Python close={named[-1]!r}"


def gap_slopes(mechanism: Mechanism, i: int) -> Quantities:
    """Return gap, gap_rate, and gap_by_NAME for every coordinate that the gap depends on.

    In place of the parts of a quaternion the names are those of its angular velocity.
    """

    def derive() -> tuple[dict[str, Any], tuple[Any, ...]]:
        contact, system = mechanism.contacts[i], mechanism.system
        rows, slopes_by = [v.row for v in system.velocities], system.slopes(contact.gap)
        slopes = {f"gap_by_{n}": slope for n, slope in zip(rows, slopes_by, strict=True)}
        formulas = {"gap": contact.gap, "gap_rate": contact.gap_rate}
        formulas |= {name: slope for name, slope in slopes.items() if slope != 0}
        return formulas, argument_symbols(mechanism)

    return quantities(f"gap {i}", mechanism.definition, mechanism.outline.argument_names, derive)


def gap_roots(mechanism: Mechanism, i: int) -> Quantities:
    """Return the closed-form roots of gap = 0, for every coordinate that has one.

    root_NAME is the root of a gap that is linear in the coordinate. A gap that is
    mean_NAME + cosine_NAME cos(NAME) + sine_NAME sin(NAME) has two in every turn.
    """

    def derive() -> tuple[dict[str, Any], tuple[Any, ...]]:
        import sympy as sp

        gap, formulas = mechanism.contacts[i].gap, {}
        for q, coordinate in zip(mechanism.system.q, mechanism.outline.coordinates, strict=True):
            slope = gap.diff(q)
            if isinstance(coordinate, QuaternionPart):
                continue
            bend = slope.diff(q)
            if slope == 0:
                continue
            if _is_zero(bend):
                formulas[f"root_{q.name}"] = -gap.subs(q, 0) / slope
            elif coordinate.unit == "rad" and _is_zero(bend.diff(q) + slope):
                ahead, behind, across = (gap.subs(q, at) for at in (0, sp.pi, sp.pi / 2))
                mean = (ahead + behind) / 2
                formulas[f"mean_{q.name}"] = mean
                formulas[f"cosine_{q.name}"] = (ahead - behind) / 2
                formulas[f"sine_{q.name}"] = across - mean
        return formulas, argument_symbols(mechanism)

    return quantities(f"roots {i}", mechanism.definition, mechanism.outline.argument_names, derive)


def _is_zero(formula: Any) -> bool:
    """Return whether a formula is zero; a long one that is not zero is not multiplied out."""
    import sympy as sp

    from painleve_sym.mechanics.system import sample_values, vanishes

    symbols = sorted(formula.free_symbols, key=str)
    at_points = (formula.xreplace(sample_values(symbols, seed)).evalf(30) for seed in (1, 2))
    return all(map(vanishes, at_points)) and sp.expand(formula) == 0


def _solved(unknown: Unknown, values: Mapping[str, Array]) -> Array:
    """Return the unknown in n states, nan where nothing closes the contact; shape (n,)."""
    if not len(values[unknown.name]):
        return np.zeros(0)
    solve = _closing_velocities if unknown.is_velocity else _closing_coordinates
    return solve(unknown, values)


def _unsolved(unknown: Unknown, values: Mapping[str, float]) -> str:
    """Return a sentence on a state in which nothing closes the contact."""
    mechanism, name, at = unknown.mechanism, unknown.name, unknown.slopes(values)
    where = f"close {mechanism.name!r}"
    if unknown.is_velocity:
        return (
            f"{where}: {name} does not change the normal velocity at this state, which is "
            f"{at['gap_rate']:g} m/s. Fix: name another velocity, or give another state."
        )
    return (
        f"{where}: no {name} makes the gap of contact "
        f"{mechanism.outline.contacts[unknown.contact].name!r} zero; it is {at['gap']:g} m at "
        f"{name} = {values[name]:g} {mechanism.units[name]}. "
        "Fix: give other coordinates, or name another one."
    )


def _closing_velocities(unknown: Unknown, values: Mapping[str, Array]) -> Array:
    """Return the velocity with gap_rate = 0, which is linear in it."""
    at = unknown.slopes.at(values)
    with np.errstate(all="ignore"):
        velocity = values[unknown.name] - at["gap_rate"] / at[f"gap_by_{unknown.coordinate}"]
    return np.where(np.isfinite(velocity), velocity, np.nan)


def _closing_coordinates(unknown: Unknown, values: Mapping[str, Array]) -> Array:
    """Return the nearest value of the coordinate with gap = 0; inside the domain where one is."""
    mechanism, i, name = unknown.mechanism, unknown.contact, unknown.name
    numbers = Delassus.of(mechanism).at_each(values)
    start, gap, near = values[name], numbers.gap[i], numbers.gap_tolerance[i]
    roots = _closed_form_roots(unknown, values)
    if roots is None:
        return _searched(unknown, values, gap, near)
    away = abs(roots - start)
    inside = np.stack([_in_domain(mechanism, {**values, name: row}) for row in roots])
    choice = np.where(
        inside.any(axis=0), np.where(inside, away, np.inf).argmin(axis=0), away.argmin(axis=0)
    )
    root = np.take_along_axis(roots, choice[None], 0)[0]
    slopes = unknown.slopes
    at_root = slopes.at({**values, name: root})
    with np.errstate(all="ignore"):
        better = root - at_root["gap"] / at_root[f"gap_by_{unknown.coordinate}"]
    left = [abs(at_root["gap"]), abs(slopes.at({**values, name: better})["gap"])]
    root = np.where(left[1] < left[0], better, root)
    root = np.where(np.fmin(*left) <= near, root, np.nan)
    return np.where(abs(gap) <= near, start, root)


def _closed_form_roots(unknown: Unknown, values: Mapping[str, Array]) -> Array | None:
    """Return candidate roots of gap = 0, of angles up to a turn away; shape (k, n).

    None where there is no closed form.
    """
    name, start = unknown.name, values[unknown.name]
    forms = gap_roots(unknown.mechanism, unknown.contact)
    linear = f"root_{name}" in forms.names
    if not linear and f"mean_{name}" not in forms.names:
        return None
    at = forms.at(values)
    if linear:
        return at[f"root_{name}"][None]
    cosine, sine = at[f"cosine_{name}"], at[f"sine_{name}"]
    with np.errstate(all="ignore"):
        # Where the gap turns before it is 0, the turn: it may touch.
        half = np.arccos(np.clip(-at[f"mean_{name}"] / np.hypot(cosine, sine), -1, 1))
        ahead = np.arctan2(sine, cosine) + np.stack([half, -half]) - start
        # Of equally near ones the first is taken, that below.
        turns = np.concatenate([-np.mod(-ahead, 2 * math.pi), np.mod(ahead, 2 * math.pi)])
    roots: Array = start + turns
    return roots


def _gap_of(unknown: Unknown, values: Mapping[str, Array]) -> Gap:
    """Return gap and slope as a function of the states' numbers and the coordinate."""
    slopes, name = unknown.slopes, unknown.name
    varied = {n for n, v in values.items() if (v != v[0]).any()}

    def gap(rows: IntArray, x: Array) -> tuple[Array, Array]:
        own = {n: v[rows] if n in varied else np.full(len(x), v[0]) for n, v in values.items()}
        numbers = slopes.at({**own, name: x})
        return numbers["gap"], numbers[f"gap_by_{name}"]

    return gap


def _searched(unknown: Unknown, values: Mapping[str, Array], gap: Array, near: Array) -> Array:
    """Return the roots of `_closing_coordinates` by search; `near` is the tolerance of the gap."""
    # Neither velocities nor friction play a part: each other combination is solved once.
    outline = unknown.mechanism.outline
    idle = {*outline.velocity_names, *(c.friction for c in outline.contacts)}
    columns = [v for n, v in values.items() if n not in idle and n in outline.argument_names]
    varied = [v for v in (*columns, near) if (v != v[0]).any()]
    if varied:
        _, first, back = np.unique(np.stack(varied), axis=1, return_index=True, return_inverse=True)
    else:
        first, back = np.zeros(1, np.intp), np.zeros(len(near), np.intp)
    own = {n: np.asarray(v)[first] for n, v in values.items()}
    return _nearest_roots(unknown, own, gap[first], near[first])[np.reshape(back, -1)]


def _nearest_roots(
    unknown: Unknown, values: Mapping[str, Array], at_start: Array, near: Array
) -> Array:
    """Return the roots of `_searched`, for states that differ in more than velocities."""
    mechanism, name, gap = unknown.mechanism, unknown.name, _gap_of(unknown, values)
    start, unit = values[name], mechanism.units[name]
    length = np.maximum(near / CONTACT_TOLERANCE, np.maximum(abs(start), abs(at_start)))
    reach = np.full(len(start), 2 * math.pi) if unit == "rad" else 4 * length

    # A gap that repeats after a turn has no other roots beyond it.
    last = _EVEN if unit == "rad" and _repeats(gap, start, at_start, length) else len(_AWAY) - 1
    result = np.where(abs(at_start) <= near, start, np.nan)
    outside = np.full(len(start), np.nan)
    left, k = np.flatnonzero(np.isnan(result)), 0
    with progress(f"roots of a gap in {name}", len(left), "states") as advance:
        while len(left) and k < last:
            stop = min(last, k + max(1, _TOGETHER // len(left)))
            rows, roots = _roots_between(gap, left, start, reach, _AWAY[k : stop + 1], near)
            inside = _in_domain(mechanism, {**{n: v[rows] for n, v in values.items()}, name: roots})
            # Roots are in the order of distance: of each state the first one stays.
            for into, kept in ((result, inside), (outside, ~inside)):
                of, place = np.unique(rows[kept], return_index=True)
                new = np.isnan(into[of])
                into[of[new]] = roots[kept][place[new]]
            open_before = len(left)
            left, k = left[np.isnan(result[left])], stop
            advance(open_before - len(left))
    return np.where(np.isnan(result), outside, result)


def _repeats(gap: Gap, start: Array, at_start: Array, length: Array) -> bool:
    """Return whether the gap is the same after a turn, at some angles of every state."""
    rows = np.arange(len(start))
    for part in (0.0, 0.2, 0.5, 0.9):
        angles = start + 2 * math.pi * part
        with np.errstate(all="ignore"):
            change = gap(rows, angles + 2 * math.pi)[0] - gap(rows, angles)[0]
        if not (abs(change) <= 1e-9 * (length + abs(at_start))).all():
            return False
    return True


def _in_domain(mechanism: Mechanism, values: Mapping[str, Array]) -> NDArray[np.bool_]:
    inside = np.full(len(next(iter(values.values()))), True)
    if mechanism.outline.domain and len(inside):
        for margin in domain_margins(mechanism).at(values).values():
            inside &= margin > 0
    return inside


def _roots_between(
    gap: Gap, states: IntArray, start: Array, reach: Array, away: Array, near: Array
) -> tuple[IntArray, Array]:
    """Return states and zeros of their gaps at these distances from the start, the nearest first.

    Also zeros where the gap touches 0 and turns.
    """
    sides = np.array([-1.0, 1.0])
    x = start[states, None, None] + reach[states, None, None] * away[:, None] * sides
    rows = np.broadcast_to(states[:, None, None], x.shape)
    with np.errstate(all="ignore"):
        value, slope = (a.reshape(x.shape) for a in gap(rows.reshape(-1), x.reshape(-1)))
        finite = np.isfinite(value[:, :-1]) & np.isfinite(value[:, 1:])
        crosses = finite & (np.sign(value[:, :-1]) != np.sign(value[:, 1:]))
        turns = finite & ~crosses & (slope[:, :-1] * slope[:, 1:] < 0)
        # Away from the start the size of the gap falls before it grows, and the tangents of the
        # ends do not cross above 0.
        turns &= (value * slope * sides)[:, :-1] < 0
        size, rate = abs(value), slope * np.sign(value) * sides
        width = np.diff(x, axis=1) * sides
        crossing = size[:, 1:] - size[:, :-1] - rate[:, 1:] * width
        least = size[:, :-1] + rate[:, :-1] * crossing / (rate[:, :-1] - rate[:, 1:])
        turns &= least <= near[states, None, None]
    state, step, side = np.nonzero(crosses | turns)
    order = np.lexsort((side, step, state))
    state, step, side = state[order], step[order], side[order]
    of, turn = states[state], turns[state, step, side]
    ends = [x[state, step + e, side] for e in (0, 1)]
    at_ends = [np.where(turn, *(a[state, step + e, side] for a in (slope, value))) for e in (0, 1)]
    roots = _halved(gap, of, turn, ends, at_ends)
    roots = np.where(turn, roots, _polished(gap, of, roots))
    with np.errstate(all="ignore"):
        # A pole changes the sign too; a turn need not reach 0.
        zero = abs(gap(of, roots)[0]) <= near[of]
    return of[zero], roots[zero]


def _halved(
    gap: Gap, states: IntArray, turn: NDArray[np.bool_], ends: list[Array], at_ends: list[Array]
) -> Array:
    """Return a zero of the gap, or of its slope where the gap turns, by bisection."""
    rising = at_ends[1] > at_ends[0]
    low, high = np.where(rising, ends[0], ends[1]), np.where(rising, ends[1], ends[0])
    with np.errstate(all="ignore"):
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            value, slope = gap(states, middle)
            above = np.where(turn, slope, value) > 0
            low, high = np.where(above, low, middle), np.where(above, middle, high)
    return high


def _polished(gap: Gap, states: IntArray, roots: Array) -> Array:
    """Return the roots after Newton steps, as long as each brings the gap nearer to 0."""
    with np.errstate(all="ignore"):
        for _ in range(_POLISH):
            value, slope = gap(states, roots)
            better = roots - value / slope
            nearer = abs(gap(states, better)[0]) < abs(value)
            roots = np.where(nearer, better, roots)
    return roots
