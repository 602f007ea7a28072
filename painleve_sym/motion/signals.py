"""Functions of time given by pieces: values that are held, or joined by lines or a spline."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.checks import LARGEST, text_of
from painleve_sym.choices import Interpolation, chosen
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, received, refuse_unknown
from painleve_sym.files import CsvFormat, CsvTable, file_path, read_csv
from painleve_sym.units import factor, in_unit

MAX_TIMES = 50_000
"""Of a signal: each is the beginning of a piece of a motion."""
_ARRAYS, _OF_FILE = ("times", "values"), ("file", "time", "column", "csv")
_KEYS = (*_ARRAYS, "interpolation", *_OF_FILE)
_HEADER = re.compile(r"(.*?)\s*(?:\[([^\]]*)\]|\(([^)]*)\))?")
_EXAMPLE = "{'times': [0, 1], 'values': [0, 2], 'interpolation': 'linear'}"


@dataclass(frozen=True, eq=False)
class Signal(Compared):
    """A function of time by polynomials in the time since the beginning of each piece.

    Attributes
    ----------
    given : dict of str to object
        Times, values and interpolation as plain data, in SI units.
    times : ndarray, shape (n,)
        Beginnings of the pieces, increasing; s.
    derivatives : ndarray, shape (n, order + 1)
        Value and derivatives at the beginning of each piece, in SI units.
    end : float
        Last time at which it has a value, s; inf where the last value is held.
    """

    given: Mapping[str, Any] = field(repr=False)
    times: Array
    derivatives: Array
    end: float

    @property
    def order(self) -> int:
        """Degree of the polynomials."""
        columns: int = self.derivatives.shape[1]
        return columns - 1

    def of_order(self, order: int) -> Signal:
        """Return the same signal by polynomials of at least a degree."""
        missing = order - self.order
        return replace(self, derivatives=np.pad(self.derivatives, ((0, 0), (0, missing))))

    def piece(self, time: float) -> int:
        """Return the index of the piece that holds from a time on; -1 before the first."""
        later: int = np.searchsorted(self.times, time, "right").item()
        return later - 1

    def after(self, time: float) -> float:
        """Return the next beginning of a piece after a time, s; inf where there is none."""
        i = self.piece(time) + 1
        return float(self.times[i]) if i < len(self.times) else math.inf

    @classmethod
    def of(cls, where: str, given: Any, name: str, unit: str) -> Signal:
        """Return the signal of plain data, its values in an SI unit.

        The name is that of the column of a file where none is given. InputError, with `where` in
        front, for anything but increasing times with a value each.
        """
        if isinstance(given, str | os.PathLike):
            given = {"file": given}
        if not isinstance(given, Mapping):
            raise InputError(f"{where}: got {received(given)}, need a mapping such as {_EXAMPLE}.")
        for key in given:
            refuse_unknown("key", key, _KEYS, where)
        kind = chosen(Interpolation, given.get("interpolation", "held"), "interpolation", where)
        arrays = [key for key in _ARRAYS if key in given]
        of_file = [key for key in _OF_FILE if key in given]
        if "file" in given and not arrays:
            times, values = _of_file(where, given, name, unit)
        elif of_file:
            raise InputError(
                f"{where}: got {' and '.join((*arrays, *of_file))}, need times and values, or the "
                "file of a table. Fix: leave out the others."
            )
        else:
            times = _column(f"{where}: times", given.get("times"), "s")
            values = _column(f"{where}: values", given.get("values"), unit)
        if len(times) != len(values):
            raise InputError(
                f"{where}: got {len(times)} times and {len(values)} values, need one for each."
            )
        least = 1 if kind is Interpolation.HELD else 2
        if not least <= len(times) <= MAX_TIMES:
            raise InputError(f"{where}: got {len(times)} times, need {least} to {MAX_TIMES}.")
        if (np.diff(times) <= 0).any():
            raise InputError(f"{where}: times: need each later than the one before.")
        plain = {"times": times.tolist(), "values": values.tolist(), "interpolation": str(kind)}
        return cls(plain, *_pieces(times, values, kind))


def _of_file(where: str, given: Mapping[str, Any], name: str, unit: str) -> tuple[Array, Array]:
    """Return times and values of two columns of a CSV file in SI units."""
    table = read_csv(file_path(given["file"], where), where, CsvFormat.of(given.get("csv")))
    wanted = (given.get("time", "t"), "s"), (given.get("column", name), unit)
    times, values = (_cells(where, table, column, own) for column, own in wanted)
    return times, values


def _cells(where: str, table: CsvTable, column: Any, unit: str) -> Array:
    """Return a column by its name, without a unit, or its place c1, c2, …, in an SI unit."""
    heads = [_HEADER.fullmatch(cell) for cell in table.header]
    names = [match[1] if match else "" for match in heads]
    places = [f"c{k}" for k in range(1, len(names) + 1)]
    refuse_unknown("column", text_of(column, f"{where}: column"), [*names, *places], where)
    if names.count(column) > 1:
        raise InputError(f"{where}: column {column!r} is there twice. Fix: write its place, c1.")
    k = names.index(column) if column in names else places.index(column)
    values, match = np.array(table.numbers(k, LARGEST)), heads[k]
    if np.isnan(values).any():
        line = table.lines[int(np.isnan(values).argmax())]
        raise InputError(
            f"{where}: line {line}, column {column}: got an empty cell, need a number."
        )
    own = (match[2] or match[3] or "").strip() if match else ""
    return values * factor(own, unit, f"{where}: column {column}") if own else values


def _column(where: str, given: Any, unit: str) -> Array:
    """Return finite numbers in an SI unit; texts have their unit."""
    if isinstance(given, list | tuple):
        given = [in_unit(v, unit, where) if isinstance(v, str) else v for v in given]
    try:
        column = np.asarray(given, np.float64)
    except (TypeError, ValueError):
        column = np.zeros((0, 0))
    if column.ndim != 1 or not (np.abs(column) <= LARGEST).all():
        raise InputError(
            f"{where}: got {received(given)}, need a list of finite numbers of at most "
            f"{LARGEST:g} in size."
        )
    return column


def _pieces(times: Array, values: Array, kind: Interpolation) -> tuple[Array, Array, float]:
    """Return beginnings, derivatives there, and the last time of a signal."""
    if kind is Interpolation.HELD:
        return times, values[:, None], math.inf
    from scipy.interpolate import CubicSpline, PPoly

    if kind is Interpolation.LINEAR:
        curve = PPoly(np.array([np.diff(values) / np.diff(times), values[:-1]]), times)
    else:
        curve = CubicSpline(times, values)
    factorials = [math.factorial(k) for k in range(len(curve.c))]
    return times[:-1], curve.c[::-1].T * factorials, float(times[-1])
