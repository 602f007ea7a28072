"""Measured data for a fit: a CSV file whose header names every quantity with its unit."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.checks import LARGEST
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, received, refuse_unknown
from painleve_sym.files import CsvFormat, file_path, read_csv
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.quantities import QUANTITIES
from painleve_sym.study.fitting.formula_columns import computed_column
from painleve_sym.units import factor

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

    Examples
    --------
    >>> import painleve_sym as ps
    >>> from painleve_sym.study import read_fit_data
    >>> data = read_fit_data("examples/studies/fit/force.csv", ps.models.rod())
    >>> data.count, data.units
    (101, {'normal_force': 'N'})
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


def read_fit_data(
    source: str | Path | Mapping[str, ArrayLike],
    mechanism: Mechanism,
    csv: CsvFormat | Mapping[str, Any] | None = None,
    parameters: Mapping[str, float] | None = None,
) -> FitData:
    """Read measurements from a CSV file, or from columns such as those of a pandas data frame.

    The header names each column and its unit. With a column ``t [s]`` the rows are the history of
    one motion. With columns ``start NAME [unit]`` and ``end NAME [unit]`` each row is a motion,
    given by its start and what was measured at its end. Columns of a file with another header are
    turned into these by the formulas of `csv`, in SI units; only those are read then.

    Parameters
    ----------
    source : path, or mapping of str to array_like
        A file, or columns by name; without a unit they are in SI units.
    mechanism : Mechanism
    csv : CsvFormat, or mapping of its settings, optional
        How the file is written.
    parameters : mapping of str to float, optional
        Constants that formulas may use besides columns; those of the mechanism where none are
        given.

    Raises
    ------
    InputError
        Not readable, a header without units, unknown quantities, another unit than SI, cells that
        are not numbers, missing columns, times out of order, formulas that cannot be read.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> from painleve_sym.study import read_fit_data
    >>> data = read_fit_data("examples/studies/fit/impacts.csv", ps.models.rod())
    >>> sorted(data.starts)
    ['theta', 'theta_dot', 'x_A_dot']
    >>> read_fit_data({"t": [0.0, 1e-3], "normal_force": [5.9, 5.1]}, ps.models.rod()).count
    2
    """
    form = CsvFormat.of(csv)
    if _is_table(source):
        if csv is not None:
            raise InputError("data: got columns and csv. Fix: leave csv out, or name a file.")
        return _of_columns(source, mechanism)
    where = f"data file {source}"
    table = read_csv(file_path(source, where), where, form)
    if not form.columns:
        cells = {text: table.numbers(k, LARGEST) for k, text in enumerate(table.header)}
        return _arranged(where, _quantities(where, table.header, cells, mechanism), table.lines)
    constants = mechanism.parameters if parameters is None else parameters
    known, computed = _known_units(mechanism), dict[tuple[str, str], Array]()
    for text, formula in form.columns.items():
        role, name, _ = _column(where, text, known, bare=True)
        computed[role, name] = computed_column(table, text, formula, constants)
    return _arranged(where, computed, table.lines)


def _is_table(source: object) -> TypeGuard[Mapping[str, ArrayLike]]:
    """Whether a source has columns: a mapping, or a data frame."""
    return isinstance(source, Mapping) or hasattr(source, "columns")


def _of_columns(source: Mapping[str, ArrayLike], mechanism: Mechanism) -> FitData:
    """Return the measurements of columns by name."""
    where, columns = "data", dict[str, Array]()
    for text in source.keys():  # noqa: SIM118 - a data frame
        try:
            column = np.array(source[text], dtype=np.float64)
        except (TypeError, ValueError):
            column = np.zeros((0, 0))
        if column.ndim != 1 or not (np.isnan(column) | (np.abs(column) <= LARGEST)).all():
            raise InputError(
                f"{where}: column {text}: got {received(source[text])}, need a list of finite "
                f"numbers of at most {LARGEST:g} in size, nan where there is none."
            )
        columns[str(text)] = column
    if len({len(column) for column in columns.values()}) > 1:
        lengths = ", ".join(f"{name} {len(column)}" for name, column in columns.items())
        raise InputError(f"{where}: got columns of different lengths: {lengths}.")
    table = _quantities(where, list(columns), columns, mechanism, bare=True)
    return _arranged(where, table)


def _quantities(
    where: str,
    header: Sequence[str],
    cells: Mapping[str, Sequence[float] | Array],
    mechanism: Mechanism,
    bare: bool = False,
) -> dict[tuple[str, str], Array]:
    """Return columns in SI units by role and quantity."""
    known = _known_units(mechanism)
    described = {text: _column(where, text, known, bare) for text in header}
    columns = [described[text][:2] for text in header]
    for name in columns:
        if columns.count(name) > 1:
            raise InputError(f"{where}: column {' '.join(name).strip()!r} is there twice.")
    return {described[t][:2]: np.array(cells[t]) * described[t][2] for t in header}


def _known_units(mechanism: Mechanism) -> dict[str, str]:
    """Return the units of what may be measured."""
    outputs = {name: QUANTITIES[name].unit for name in MEASURABLE}
    return {**mechanism.state_units, **outputs, "t": "s"}


def _column(
    where: str, text: str, known: Mapping[str, str], bare: bool = False
) -> tuple[str, str, float]:
    """Return role, name, and how many SI units one unit of the column is.

    A `bare` name, without a unit, is in SI units.
    """
    match = _HEADER.match(text if not bare or "[" in text else f"{text} []")
    if match is None:
        raise InputError(f"{where}: header: got {text!r}, need NAME [unit], {_EXAMPLE}.")
    role, name, unit = match.group(1) or "", match.group(2), match.group(3).strip()
    refuse_unknown("quantity", name, known, f"{where}: header")
    if bare and not unit:
        return role, name, 1.0
    return role, name, factor(unit, known[name], f"{where}: column {name}")


def _arranged(
    where: str, table: dict[tuple[str, str], Array], lines: Sequence[int] = ()
) -> FitData:
    """Return the measurements of columns; `lines` are those of a file."""
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
    given = {f"start {name}": v for name, v in starts.items()}
    for fixed, values in (given if times is None else {"t": times, **given}).items():
        if np.isnan(values).any():
            k = int(np.argmax(np.isnan(values)))
            row = f"line {lines[k]}" if lines else f"row {k + 1}"
            raise InputError(
                f"{where}: {row}, column {fixed}: got an empty cell, need a number. "
                "Fix: fill it, or leave the row out."
            )
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
