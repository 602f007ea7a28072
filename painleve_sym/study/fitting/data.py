"""Measured data for a fit: a CSV file whose header names every quantity with its unit."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.checks import LARGEST
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.files import file_path, read_text
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.quantities import QUANTITIES
from painleve_sym.units import factor

MAX_FILE = 50_000_000
"""Size limit of a data file in bytes; guards against special files."""
MEASURABLE = (
    "normal_force",
    "tangential_force",
    "compression",
    "gap",
    "gap_rate",
    "slip_velocity",
    "kinetic_energy",
    "potential_energy",
    "stored_energy",
    "friction_dissipation",
    "contact_dissipation",
)
"""What a column may hold besides coordinates and velocities."""
_HEADER = re.compile(r"^(?:(start|end)\s+)?(\w+)\s*\[([^\]]*)\]$")
_EXAMPLE = "such as 't [s], y_A_dot [m/s], normal_force [N]'"


@dataclass(frozen=True, eq=False)
class FitData(Compared):
    """Rows of measurements.

    Attributes
    ----------
    where : str
        What messages call the file.
    times : ndarray, shape (n,) or None
        A history of one motion, in the order of time; None: every row is a motion of its own,
        measured when it ended. s.
    starts : mapping of str to ndarray, shape (n,)
        Start values of each motion, by state; empty for a history.
    measured : mapping of str to ndarray, shape (n,)
        By state or output; nan where a cell is empty.
    """

    where: str
    times: Array | None
    starts: Mapping[str, Array]
    measured: Mapping[str, Array]

    @property
    def count(self) -> int:
        """Number of measured values."""
        return sum(int(np.isfinite(v).sum()) for v in self.measured.values())

    @property
    def units(self) -> dict[str, str]:
        """Unit of outputs among the measured quantities."""
        return {n: QUANTITIES[n].unit for n in self.measured if n in MEASURABLE}


def read_fit_data(path: str | Path, mechanism: Mechanism) -> FitData:
    """Read a CSV file; lines that open with # are comments.

    The header names each column and its unit. With a column ``t [s]`` the rows are the history of
    one motion. With columns ``start NAME [unit]`` and ``end NAME [unit]`` each row is a motion,
    given by its start and what was measured at its end.

    Raises
    ------
    InputError
        Not readable, a header without units, unknown quantities, another unit than SI, cells that
        are not numbers, missing columns, times out of order.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> from painleve_sym.study import read_fit_data
    >>> data = read_fit_data("examples/studies/fit/impacts.csv", ps.models.rod())
    >>> sorted(data.starts)
    ['theta', 'theta_dot', 'x_A_dot']
    """
    where = f"data file {path}"
    rows = _rows(where, file_path(path, where))
    if not rows:
        raise InputError(f"{where}: got no rows. Fix: give a header, {_EXAMPLE}, and data below.")
    (_, header), body = rows[0], rows[1:]
    outputs = {name: QUANTITIES[name].unit for name in MEASURABLE}
    known = {**mechanism.state_units, **outputs, "t": "s"}
    described = [_column(where, text, known) for text in header]
    columns = [(role, name) for role, name, _ in described]
    for name in columns:
        if columns.count(name) > 1:
            raise InputError(f"{where}: column {' '.join(name).strip()!r} is there twice.")
    values = _numbers(where, header, body)
    table = {name: values[:, i] * described[i][2] for i, name in enumerate(columns)}
    return _arranged(where, table)


def _rows(where: str, path: Path) -> list[tuple[int, list[str]]]:
    """Return the number and the cells of each line that is neither blank nor a comment."""
    rows = []
    for i, line in enumerate(read_text(path, where, MAX_FILE, "CSV file").splitlines(), 1):
        if not line.strip() or line.strip()[0] == "#":
            continue
        try:
            # Line by line: no cell of numbers or names needs a line end in quotes.
            (row,) = csv.reader([line], skipinitialspace=True, strict=True)
        except csv.Error as error:
            reason = "quotes are not closed" if "end of data" in str(error) else error
            raise InputError(
                f"{where}: line {i}: not a row of a CSV file ({reason}). Fix: correct that line."
            ) from error
        rows.append((i, [cell.strip() for cell in row]))
    return rows


def _column(where: str, text: str, known: Mapping[str, str]) -> tuple[str, str, float]:
    """Return role, name, and how many SI units one unit of the column is."""
    match = _HEADER.match(text)
    if match is None:
        raise InputError(f"{where}: header: got {text!r}, need NAME [unit], {_EXAMPLE}.")
    role, name, unit = match.group(1) or "", match.group(2), match.group(3).strip()
    refuse_unknown("quantity", name, known, f"{where}: header")
    return role, name, factor(unit, known[name], f"{where}: column {name}")


def _numbers(where: str, header: list[str], body: list[tuple[int, list[str]]]) -> Array:
    values = np.full((len(body), len(header)), np.nan)
    for i, (line, row) in enumerate(body):
        if len(row) != len(header):
            raise InputError(f"{where}: line {line}: got {len(row)} cells, need {len(header)}.")
        for j, cell in enumerate(row):
            if not cell:
                continue
            try:
                values[i, j] = float(cell)
            except ValueError:
                values[i, j] = math.inf
            if not abs(values[i, j]) <= LARGEST:
                raise InputError(
                    f"{where}: line {line}, column {header[j]}: got {cell!r}, need a finite "
                    f"number of at most {LARGEST:g} in size, or nothing where there is none."
                )
    return values


def _arranged(where: str, table: dict[tuple[str, str], Array]) -> FitData:
    history = {name: v for (role, name), v in table.items() if not role}
    starts = {name: v for (role, name), v in table.items() if role == "start"}
    ends = {name: v for (role, name), v in table.items() if role == "end"}
    if history and (starts or ends):
        raise InputError(
            f"{where}: got columns with and without start or end. Fix: give a history (t and what "
            "was measured), or motions row by row (start ... and end ...)."
        )
    times = history.pop("t", None)
    measured = history or ends
    if not (starts or ends) and times is None:
        raise InputError(
            f"{where}: column t [s] is missing. Fix: add it, or name the columns "
            "start NAME [unit] and end NAME [unit] for motions row by row."
        )
    for fixed, values in (("t", times), *starts.items()):
        if values is not None and np.isnan(values).any():
            raise InputError(f"{where}: column {fixed}: got an empty cell, need a number.")
    if times is not None and ((times < 0).any() or (np.diff(times) < 0).any()):
        raise InputError(f"{where}: column t: need times >= 0 that do not decrease.")
    if (starts or ends) and "t" in (*starts, *ends):
        raise InputError(f"{where}: column t has no start or end. Fix: leave it out.")
    if not measured:
        raise InputError(f"{where}: no measured column. Fix: add one, {_EXAMPLE}.")
    data = FitData(where, times, starts, measured)
    if not data.count:
        raise InputError(f"{where}: got no measured values. Fix: add rows below the header.")
    return data
