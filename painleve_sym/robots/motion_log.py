"""A logged motion of a robot: a CSV file of times, joint values, velocities and torques."""

from __future__ import annotations

import csv
import difflib
import io
import math
import operator
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.files import read_text
from painleve_sym.mechanics.declarations import TIME_NAME
from painleve_sym.robots.dynamics import BASE, MAX_LISTED, NORMAL, TANGENT, first_tangent
from painleve_sym.robots.robot_contact import RobotContact
from painleve_sym.units import in_unit, is_quantity

MAX_BYTES = 200_000_000
HEIGHT = "height"
"""In a rule: the height of the contact above the plane through the origin of the world, m."""
_UNIT = re.compile(r"\s*\[([^\]]*)\]\s*$")
_RULE = re.compile(r"(?P<name>.+?)\s*(?:(?P<relation><=|>=|<|>)\s*(?P<bound>[^<>=]+))?")
_RELATIONS: Mapping[str, Callable[[Any, float], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
SHORTEST_NORMAL = 1e-10
"""Length of a normal below which it has no direction."""
_ROUNDED = 1e-6
"""By how much a logged value may pass a limit of its joint, rad or m: logs are rounded."""


@dataclass(frozen=True)
class TouchingRule:
    """Rule for when the contact of a logged motion touches: a column, or the height, and a bound.

    Attributes
    ----------
    name : str
        Of a column, or ``height``.
    relation : str
        ``<``, ``<=``, ``>``, ``>=``; empty where any value but 0 means that it touches.
    bound : float
    """

    name: str
    relation: str = ""
    bound: float = 0.0

    @classmethod
    def of(cls, text: str, where: str = "touching") -> TouchingRule:
        """Return the rule of a text such as ``foot_force>5``, ``height<1mm`` or ``stance``.

        Raises
        ------
        InputError
            Not a name, or a name, a relation and a finite number.

        Examples
        --------
        >>> from painleve_sym.robots.motion_log import TouchingRule
        >>> TouchingRule.of("foot_force > 5")
        TouchingRule(name='foot_force', relation='>', bound=5.0)
        """
        parts = _RULE.fullmatch(text.strip())
        bound = math.nan
        if parts:
            try:
                text_of_bound = parts["bound"] or "0"
                length = parts["name"] == HEIGHT and is_quantity(text_of_bound)
                bound = in_unit(text_of_bound, "m", where) if length else float(text_of_bound)
            except ValueError:
                bound = math.nan
        if not parts or not math.isfinite(bound):
            raise InputError(
                f"{where}: got {text!r}, need a column, or a column with <, <=, > or >= and a "
                "number, such as foot_force>5 or height<0.001."
            )
        return cls(parts["name"], parts["relation"] or "", bound)

    def holds(self, values: Array) -> NDArray[np.bool_]:
        """Return whether the contact touches, for values of the column."""
        if not self.relation:
            return np.asarray(values != 0)
        return np.asarray(_RELATIONS[self.relation](values, self.bound))


@dataclass(frozen=True, eq=False)
class MotionLog:
    """A logged motion of n samples.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Times that grow; s.
    values : dict of str to ndarray, shape (n,)
        Coordinates, velocities and torques by their names in the mechanism; SI.
    closed : ndarray of bool, shape (n,), or None
        Whether the contact touches; None where nothing says so.
    notices : tuple of str
        Sentences on what the log leaves open and on columns that are not read.
    """

    t: Array
    values: dict[str, Array]
    closed: NDArray[np.bool_] | None = None
    notices: tuple[str, ...] = ()

    @property
    def moves(self) -> bool:
        """Whether there are velocities or torques."""
        return any(n.endswith("_dot") or n.startswith("torque_") for n in self.values)


def read_motion(
    path: str | Path, contact: RobotContact, touching: TouchingRule | None = None
) -> MotionLog:
    """Return the motion of a CSV file with the time ``t``, joint values, velocities and torques.

    A velocity is called as its joint with ``_dot``, a torque as its joint after ``torque_``; the
    base of a floating robot has ``base_roll`` and others, too. ``normal_x``, ``normal_y`` and
    ``normal_z`` together are the normal of the surface at each sample, in the axes of the world, of
    any length. A unit in brackets must be SI. Other columns are not read, and a notice names them.

    Parameters
    ----------
    path : str or Path
    contact : RobotContact
    touching : TouchingRule, optional
        When the contact touches.

    Raises
    ------
    InputError
        Not a table of finite numbers; no time, or one that does not grow; no column of the robot;
        joint values outside their limits; a rule on an unknown column.
    """
    where = f"trajectory {path}"
    header, rows = _table(path, where)
    names = _columns_of(contact)
    read = _read_columns(header, names, touching, where)
    columns = _numbers(rows, header, read, where)
    if TIME_NAME not in columns:
        other = next((mark for mark in ";\t" if len(header) == 1 and mark in header[0]), "")
        fix = f" Fix: separate columns by commas, not by {other!r}." if other else ""
        raise InputError(f"{where}: has no column {TIME_NAME}, the time in s.{fix}")
    t = columns[TIME_NAME]
    if not (np.diff(t) > 0).all():
        k = int(np.argmin(np.diff(t)))
        raise InputError(f"{where}: sample {k + 2}: the time does not grow.")
    own = {n: column for n, column in columns.items() if n in names and n != TIME_NAME}
    values = {names[n][0]: column for n, column in own.items()}
    if not values:
        raise InputError(
            f"{where}: has no column of the robot, need such as "
            f"{', '.join(list(names)[1:4]) or 'none'}."
        )
    _check_limits(contact, values, t, where)
    known = [name for name, _ in map(_named, header)]
    if touching is not None and touching.name not in (*known, HEIGHT):
        refuse_unknown("column", touching.name, [*known, HEIGHT], f"{where}: touching")
    values |= (normals := _normals(columns, names, where))
    closed = None if touching is None else _closed(touching, columns, contact, values, where)
    notices = _unread(header, read, names) + _missing(contact, values, closed is None)
    if normals:
        notices.insert(0, "The normal at each sample is that of the log, scaled to unit length.")
    return MotionLog(t, values, closed, tuple(notices))


def _table(path: str | Path, where: str) -> tuple[list[str], list[list[str]]]:
    """Return the header of a CSV file and its rows; comments and empty lines are left out."""
    text = read_text(path, where, MAX_BYTES, "CSV file")
    lines = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        rows = [row for row in lines if row and not row[0].lstrip().startswith("#")]
    except csv.Error as error:
        raise InputError(
            f"{where}, line {lines.line_num}: not CSV: {error}. Fix: close every quote, or leave "
            "quotes out."
        ) from error
    if len(rows) < 2:
        raise InputError(f"{where}: got {len(rows)} lines, need a header and at least one sample.")
    return rows[0], rows[1:]


def _columns_of(contact: RobotContact) -> dict[str, tuple[str, str]]:
    """Return name in the mechanism and unit of each column, by the name that it has in a log.

    A joint whose coordinate has another name has its own one, too, where no other column has it.
    """
    dynamics = contact.dynamics
    efforts = {p.name: p.unit for p in dynamics.outline.parameters if p.name.startswith("torque_")}
    units = {TIME_NAME: "s", **dynamics.outline.state_units, **efforts}
    columns = {name: (name, unit) for name, unit in units.items()}
    for joint, own in dynamics.coordinates.items():
        for form in ("{}", "{}_dot", "torque_{}"):
            columns.setdefault(form.format(joint), columns[form.format(own)])
    return columns


def _named(cell: str) -> tuple[str, str | None]:
    """Return name and unit of a cell of the header."""
    unit = _UNIT.search(cell)
    return _UNIT.sub("", cell).strip(), None if unit is None else unit[1].strip()


def _read_columns(
    header: list[str],
    names: Mapping[str, tuple[str, str]],
    touching: TouchingRule | None,
    where: str,
) -> dict[str, int]:
    """Return the places of the columns that are read, by name."""
    read: dict[str, int] = {}
    wanted = {*names} if touching is None else {*names, touching.name}
    if {*NORMAL} <= {name for name, _ in map(_named, header)}:
        wanted |= {*NORMAL}
    for k, cell in enumerate(header):
        name, unit = _named(cell)
        if name not in wanted:
            continue
        if name in read:
            raise InputError(f"{where}: got column {name} twice. Fix: give it once.")
        if name in names and unit is not None and unit != names[name][1]:
            raise InputError(
                f"{where}: column {name}: got the unit {unit!r}, need {names[name][1]}."
            )
        read[name] = k
    meanings = dict[str, str]()
    for name in read:
        if name in names and meanings.setdefault(names[name][0], name) != name:
            raise InputError(
                f"{where}: columns {meanings[names[name][0]]} and {name} are the same quantity. "
                "Fix: give it once."
            )
    return read


def _numbers(
    rows: list[list[str]], header: list[str], read: Mapping[str, int], where: str
) -> dict[str, Array]:
    """Return the columns that are read as arrays of finite numbers."""
    table, places = np.full((len(rows), len(read)), math.nan), list(read.values())
    for i, row in enumerate(rows):
        if len(row) == len(header):
            try:
                table[i] = [float(row[k]) for k in places]
            except ValueError:
                table[i] = math.nan
        if not np.isfinite(table[i]).all() or len(row) != len(header):
            raise InputError(
                f"{where}: sample {i + 1}: need {len(header)} finite numbers, got {len(row)} cells."
                if len(row) != len(header)
                else f"{where}: sample {i + 1}: need finite numbers, got "
                f"{_first_fault(row, table[i], read)}."
            )
    return dict(zip(read, table.T.copy(), strict=True))


def _first_fault(row: list[str], values: Array, read: Mapping[str, int]) -> str:
    """Return the first cell that is not a finite number, with its column."""
    for name, k in read.items():
        try:
            if math.isfinite(float(row[k])):
                continue
        except ValueError:
            pass
        return f"{row[k][:40]!r} in column {name}"
    raise AssertionError(values)


def _check_limits(contact: RobotContact, values: Mapping[str, Array], t: Array, where: str) -> None:
    """Raise InputError where a joint value is outside its limits, with the first such sample."""
    for name, joint in contact.dynamics.tree.joints.items():
        q = values.get(contact.dynamics.coordinates[name])
        if q is None:
            continue
        outside = (q < joint.lower - _ROUNDED) | (q > joint.upper + _ROUNDED)
        if outside.any():
            k = int(np.argmax(outside))
            raise InputError(f"{where}: sample {k + 1}, t = {t[k]:g} s: {joint.fault(float(q[k]))}")


def _normals(columns: Mapping[str, Array], names: Collection[str], where: str) -> dict[str, Array]:
    """Return normals of the surface and tangents, where the log has them; joints come first."""
    if not {*NORMAL} <= {*columns} - {*names}:
        return {}
    normal = np.array([columns[name] for name in NORMAL])
    length = np.linalg.norm(normal, axis=0)
    if not (length > SHORTEST_NORMAL).all():
        k = int(np.argmin(length))
        raise InputError(f"{where}: sample {k + 1}: the normal is 0, need a vector of some length.")
    normal = normal / length
    return dict(zip((*NORMAL, *TANGENT), (*normal, *first_tangent(normal)), strict=True))


def _closed(
    rule: TouchingRule,
    columns: Mapping[str, Array],
    contact: RobotContact,
    values: Mapping[str, Array],
    where: str,
) -> NDArray[np.bool_]:
    """Return at which samples the contact touches."""
    if rule.name in columns:
        return rule.holds(columns[rule.name])
    if not rule.relation:
        raise InputError(f"{where}: touching: height needs a bound. Fix: such as height<0.001.")
    if contact.dynamics.tree.floating:
        parts = zip(BASE[:3], contact.axes[0].tolist(), strict=True)
        for name, part in parts:
            if part and name not in values:
                raise InputError(
                    f"{where}: touching: the height of the contact needs the column {name}, the "
                    "place of the base. Fix: add it, or use another column, such as a force."
                )
    return rule.holds(contact.heights({**contact.values, **values}))


def _unread(header: list[str], read: Collection[str], names: Collection[str]) -> list[str]:
    """Return a notice on the columns that are not read."""
    others = [name for name, _ in map(_named, header) if name and name not in read]
    if not others:
        return []
    shown = []
    for name in others[:MAX_LISTED]:
        near = difflib.get_close_matches(name, names, n=1, cutoff=0.8)
        shown.append(f"{name!r}" + (f" (did you mean {near[0]!r}?)" if near else ""))
    more = "" if len(others) <= MAX_LISTED else f", and {len(others) - MAX_LISTED} more"
    ours = {"mu", *NORMAL, *TANGENT} & {*others}
    own = " The friction is that of --mu, the normal that of --normal." if ours else ""
    return [f"Columns of the log that are not read: {', '.join(shown)}{more}.{own}"]


def _missing(contact: RobotContact, values: Collection[str], no_rule: bool) -> list[str]:
    """Return notices on quantities that the log does not have."""
    own, floating = contact.dynamics.coordinates, contact.dynamics.tree.floating
    notices = []
    kept = [joint for joint, name in own.items() if name not in values]
    kept += [name for name in BASE[3:] * floating if name not in values]
    if kept:
        notices.append(f"The log has no column of {_some(kept)}: the value of the pose holds.")
    moving = [own[joint] for joint in contact.joints] + list(BASE * floating)
    rates = [f"{name}_dot" for name in moving if f"{name}_dot" not in values]
    efforts = [n for n in (f"torque_{own[j]}" for j in contact.joints) if n not in values]
    moves = any(n.endswith("_dot") or n.startswith("torque_") for n in values)
    for missing in (rates, efforts) if moves else ():
        if missing:
            notices.append(f"The log has no column of {_some(missing)}: taken as 0.")
    still = [joint for joint in contact.dynamics.locked if f"{own[joint]}_dot" in values]
    if still:
        notices.append(f"Locked joints have no velocity, whatever the log says: {_some(still)}.")
    if no_rule:
        notices.append(
            "Nothing says when the contact touches: it is taken to do so "
            + (
                "while its normal velocity is that of rest, and what approaches is called an "
                "impact, though it may be a swing."
                if moves
                else "always."
            )
            + " Fix: --touching with a column or the height, such as foot_force>5 or height<0.001."
        )
    return notices


def _some(names: Collection[str]) -> str:
    """Return the first names, and how many others there are."""
    shown = ", ".join(list(names)[:MAX_LISTED])
    return shown if len(names) <= MAX_LISTED else f"{shown} and {len(names) - MAX_LISTED} more"
