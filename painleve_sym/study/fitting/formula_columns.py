"""Columns that formulas compute from those of a CSV file, row by row."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.checks import LARGEST
from painleve_sym.codegen.evaluate import at_points, expression_function
from painleve_sym.errors import InputError
from painleve_sym.files import CsvTable
from painleve_sym.units import si_factor

_NAMED = re.compile(r"([A-Za-z_]\w*)\s*(?:\[([^\]]*)\]|\(([^)]*)\))?", re.ASCII)


def computed_column(
    table: CsvTable, name: str, formula: str, constants: Mapping[str, float]
) -> Array:
    """Return the numbers of a formula in every row, shape (n,); nan where a cell of it is empty.

    A name stands for the column in SI units, where its header has a unit: ``height [mm]`` or
    ``height (mm)``. A place, ``c1``, stands for the numbers as they are written.

    Raises
    ------
    InputError
        Unknown or ambiguous names, a formula that cannot be read, or that has no finite value.
    """
    # Only a file with formulas needs SymPy.
    from sympy import Symbol

    from painleve_sym.mechanics.toml.expressions import Formulas

    where = f"{table.where}: column {name}"
    places = _places(table, constants)
    symbols = {n: Symbol(n, real=True) for n in (*constants, *places)}
    expression, faults = Formulas(dict(symbols)).read(formula)
    if expression is None:
        raise InputError(f"{where}: {' '.join(fault.message for fault in faults)}")
    used = sorted(str(symbol) for symbol in expression.free_symbols)
    values = np.empty((len(table.rows), len(used)))
    for i, one in enumerate(used):
        values[:, i] = _values(table, one, places.get(one, ()), constants, where)
    function = expression_function("column", [expression], [symbols[n] for n in used])
    result = at_points(function, values)[:, 0]
    missing = np.isnan(values).any(axis=1)
    result[missing] = np.nan
    wrong = ~missing & ~(np.abs(result) <= LARGEST)
    if wrong.any():
        k = int(np.argmax(wrong))
        given = ", ".join(f"{n} = {v:g}" for n, v in zip(used, values[k], strict=True))
        raise InputError(
            f"{where}: line {table.lines[k]}: {formula} is not a finite number at {given}. "
            "Fix: correct the row, or leave its cell empty."
        )
    return result


def _places(table: CsvTable, constants: Collection[str]) -> dict[str, tuple[int, ...]]:
    """Return the columns that a name may stand for: its own, or the place that ``c1`` names."""
    numbered = {f"c{k + 1}": (k,) for k in range(len(table.header))}
    places: dict[str, tuple[int, ...]]
    places = {name: at for name, at in numbered.items() if name not in constants}
    for k, cell in enumerate(table.header):
        if match := _NAMED.fullmatch(cell):
            others = (j for j in places.get(match[1], ()) if j != k)
            places[match[1]] = (*others, k)
    return places


def _values(
    table: CsvTable,
    name: str,
    places: tuple[int, ...],
    constants: Mapping[str, float],
    where: str,
) -> Array:
    """Return the values of a column in SI units, or those of a constant."""
    if not places:
        return np.full(len(table.rows), constants[name])
    if len(places) > 1 or name in constants:
        meanings = [f"column c{k + 1}" for k in places]
        meanings += ["a parameter"] if name in constants else []
        raise InputError(
            f"{where}: {name} may be {' or '.join(meanings)}. Fix: write "
            f"c{places[-1] + 1} for the column."
        )
    (k,) = places
    numbers, match = np.array(table.numbers(k, LARGEST)), _NAMED.fullmatch(table.header[k])
    if match is None or match[1] != name:
        return numbers
    unit = (match[2] or match[3] or "").strip()
    return numbers * si_factor(unit, f"{table.where}: column {table.header[k]}")
