"""Files that are read up to a size, and written whole or not at all; tables of CSV files."""

from __future__ import annotations

import csv
import difflib
import itertools
import math
import os
import re
import stat
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, NamedTuple

from painleve_sym.errors import InputError, received, refuse_unknown
from painleve_sym.system import open_no_link


def write_beside(path: str | Path, write: Any) -> None:
    """Write through a temporary file in the same folder, then rename; `write` takes the open file.

    A file that is there keeps its permissions, a new one has those that the umask leaves.
    InputError where no file can be made there. OSError, with the name of the file, where it cannot
    be written (a full disk); nothing is left then.
    """
    path = file_path(path, "output file")
    name = beside(path)
    try:
        file = open(name, "xb", opener=open_no_link)  # noqa: SIM115, closed below
    except OSError as error:
        raise InputError(
            f"output file {path}: {error.strerror}. Fix: name a folder that exists and is writable."
        ) from error
    try:
        with file, suppress(FileNotFoundError):
            write(file)
            name.chmod(stat.S_IMODE(path.stat().st_mode))
        os.replace(name, path)
    except BaseException as error:
        name.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from error
        raise


def beside(path: Path) -> Path:
    """Return a hidden name beside a path, which is not in use and which no other user can guess."""
    return path.with_name(f".{path.name[:50]}.{os.urandom(6).hex()}")


def file_path(value: Any, where: str) -> Path:
    """Return the path of a file; InputError for what is none, such as a number or an empty text."""
    if isinstance(value, str | os.PathLike) and str(value).strip():
        return Path(os.fsdecode(value))
    raise InputError(f"{where}: got {received(value)}, need the path of a file.")


def read_text(path: str | Path, where: str, most: int, kind: str = "TOML file") -> str:
    """Return the UTF-8 text of a file; InputError as `read_bytes`, and where it is not UTF-8."""
    content = read_bytes(path, where, most, kind)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(f"{where}, line {line}: not UTF-8 text. Fix: save it as UTF-8.") from error


def read_bytes(path: str | Path, where: str, most: int, kind: str) -> bytes:
    """Return the content of a file that may be of any size or kind.

    Messages call the file `where`, and `kind` what it should be; at most `most` bytes are read,
    since a special file may never end. InputError where it is not readable, or too long.
    """
    path = file_path(path, where)
    try:
        with open(path, "rb") as file:
            content = file.read(most + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        near = _near_file(path) if isinstance(error, FileNotFoundError) else ""
        raise InputError(f"{where}: {reason}.{near} Fix: name a readable {kind}.") from error
    if len(content) > most:
        raise InputError(f"{where}: got more than {most} bytes. Fix: name a {kind}.")
    return content


MAX_CSV = 50_000_000
"""Size limit of a CSV file in bytes; guards against special files."""
SEPARATORS = {",": ",", ";": ";", "|": "|", "tab": "\t", "\t": "\t", "space": " ", " ": " "}
"""What may separate the columns of a CSV file, by the names that a setting may have."""


@dataclass(frozen=True)
class CsvFormat:
    """Notation of a table in a CSV file, and quantities that are computed from its columns.

    Attributes
    ----------
    skip : int
        Lines before the header; blank lines and those that begin with ``#`` are left out anyway.
    separator : str
        Of the columns: a comma, a semicolon, ``|``, ``tab`` or ``space`` (any number of blanks).
    decimal : str
        Sign before the decimals of a number: a point or a comma.
    columns : mapping of str to str
        Quantities by formulas of the columns of the file, such as ``sqrt(2*g*height)``. The name of
        a column stands for it in SI units, where the header has its unit: ``height (mm)``. Its
        place, ``c1``, ``c2``, …, stands for the numbers as they are written.

    Raises
    ------
    InputError
        Another separator or sign, or one sign for both.

    Examples
    --------
    >>> from painleve_sym.study import CsvFormat
    >>> CsvFormat(skip=2, separator=";", decimal=",").separator
    ';'
    """

    skip: int = 0
    separator: str = ","
    decimal: str = "."
    columns: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if type(self.skip) is not int or not 0 <= self.skip <= MAX_CSV:
            raise InputError(f"csv: skip: got {received(self.skip)}, need a whole number >= 0.")
        for name, known in (("separator", SEPARATORS), ("decimal", (".", ","))):
            if getattr(self, name) not in known:
                need = ", ".join(repr(sign) for sign in known if sign not in "\t ")
                raise InputError(f"csv: {name}: got {getattr(self, name)!r}, need one of {need}.")
        if self.separator == self.decimal:
            raise InputError(
                "csv: got a comma as the separator and as the decimal sign. Fix: give the "
                "separator of the file, such as ';'."
            )
        named = isinstance(self.columns, Mapping)
        if not (named and all(isinstance(t, str) for pair in self.columns.items() for t in pair)):
            raise InputError(
                f"csv: columns: got {received(self.columns)}, need formulas by names, such as "
                "{'end y_dot': 'sqrt(2*g*height)'}."
            )

    @classmethod
    def of(cls, given: CsvFormat | Mapping[str, Any] | None) -> CsvFormat:
        """Return the format of a mapping of its settings; InputError for anything else."""
        if isinstance(given, CsvFormat):
            return given
        if not isinstance(given, Mapping | None):
            raise InputError(f"csv: got {received(given)}, need settings such as {{'skip': 2}}.")
        for name in given or {}:
            refuse_unknown("key", name, [f.name for f in fields(cls)], "csv")
        return cls(**(given or {}))


class CsvTable(NamedTuple):
    """Cells of a CSV file: those of its header, and the rows below with their lines."""

    where: str
    header: list[str]
    lines: list[int]
    rows: list[list[str]]
    decimal: str

    def numbers(self, column: int, most: float = 1e100) -> list[float]:
        """Return the numbers of a column, nan where a cell is empty.

        InputError, with its line, for a cell that is not a finite number of at most that size.
        """
        values = []
        for line, row in zip(self.lines, self.rows, strict=True):
            cell = row[column]
            value = _number(cell, self.decimal) if cell else math.nan
            if cell and not abs(value) <= most:
                need = (
                    f"a finite number of at most {most:g} in size, or nothing where there is none"
                )
                comma = self.decimal != "," and "," in cell
                fix = " Fix: give a comma as the decimal sign." if comma else ""
                raise InputError(
                    f"{self.where}: line {line}, column {self.header[column]}: got {cell!r}, "
                    f"need {need}.{fix}"
                )
            values.append(value)
        return values


def read_csv(path: str | Path, where: str, form: CsvFormat) -> CsvTable:
    """Return the table of a CSV file; lines that are blank or begin with ``#`` are left out.

    A first row of numbers alone is data: the header then has the places ``c1``, ``c2``, …
    InputError where the file is not readable, has no rows, or rows of another length.
    """
    rows = []
    lines = read_text(path, where, MAX_CSV, "CSV file").splitlines()
    for i, line in enumerate(lines[form.skip :], form.skip + 1):
        if line.strip() and line.strip()[0] != "#":
            cells = _cells(f"{where}: line {i}", line, SEPARATORS[form.separator])
            rows += [(i, cells)] if any(cells) else []
    if not rows:
        raise InputError(
            f"{where}: got no rows. Fix: give a header with the names, and data below."
        )
    header = rows[0][1]
    if all(math.isfinite(_number(cell, form.decimal)) for cell in header):
        header = [f"c{k}" for k in range(1, len(header) + 1)]
    else:
        del rows[0]
    for i, cells in rows:
        if len(cells) != len(header):
            raise InputError(f"{where}: line {i}: got {len(cells)} cells, need {len(header)}.")
    return CsvTable(where, header, [i for i, _ in rows], [c for _, c in rows], form.decimal)


def _cells(where: str, line: str, separator: str) -> list[str]:
    """Return the cells of a line: no cell of numbers or names needs a line end in quotes."""
    line = " ".join(line.split()) if separator == " " else line
    try:
        (row,) = csv.reader([line], skipinitialspace=True, strict=True, delimiter=separator)
    except csv.Error as error:
        reason = "quotes are not closed" if "end of data" in str(error) else error
        raise InputError(
            f"{where}: not a row of a CSV file ({reason}). Fix: correct that line."
        ) from error
    return [cell.strip() for cell in row]


def _number(cell: str, decimal: str) -> float:
    """Return the number of a cell, nan where it is none."""
    plain = cell if decimal == "." else cell.replace(".", "x").replace(decimal, ".")
    try:
        return float(plain) if "_" not in cell else math.nan
    except ValueError:
        return math.nan


def _near_file(path: Path) -> str:
    """Return a question with the name of a file beside an absent one that is much like it."""
    with suppress(OSError):
        kept = (p.stem for p in path.parent.iterdir() if p.suffix == path.suffix)
        for stem in difflib.get_close_matches(path.stem, list(itertools.islice(kept, 1000)), n=1):
            return f" Did you mean {str(path.with_stem(stem))!r}?"
    return ""


MAX_NESTING = 32
"""Tables and arrays within each other, and parts of a dotted key."""
_LONG_KEY = re.compile(
    r"""(?:^|[\[{,])[ \t]*(?:(?:[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*)"""
    f"{{{MAX_NESTING}}}",
    re.MULTILINE,
)


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Return the entries of TOML text.

    InputError where it is not TOML, nested too deeply, or has a whole number beyond 64 bits.
    """
    deep = InputError(
        f"{where}: tables, arrays or the parts of a dotted key are nested too deeply, need at "
        f"most {MAX_NESTING} within each other."
    )
    # The reader takes the square of the length of a dotted key.
    if _LONG_KEY.search(text):
        raise deep
    try:
        data = tomllib.loads(text)
    except RecursionError as error:
        raise deep from error
    except ValueError as error:
        raise InputError(f"{where}: not valid TOML: {error}.") from error
    level: list[Any] = [data]
    for _ in range(MAX_NESTING + 1):
        if any(isinstance(v, int) and not -(2**63) <= v < 2**63 for v in level):
            raise InputError(
                f"{where}: a whole number has more than the 64 bits of TOML. "
                "Fix: write it as a decimal, such as 1e20."
            )
        inner = (v.values() if isinstance(v, dict) else v for v in level if isinstance(v, _NESTED))
        level = [v for values in inner for v in values]
    if level:
        raise deep
    return data


_NESTED = (dict, list)
