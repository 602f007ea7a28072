"""From the text of options to numbers, names and checked output files."""

from __future__ import annotations

import argparse
import math
import os
import tempfile
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.units import in_unit, is_quantity

FIGURES = (".png", ".svg", ".pdf")
MAPS = (*FIGURES, ".npz", ".json")
"""Suffixes of what a map is written as."""
WIDTHS = {"column": 3.4, "page": 7.0}
"""Named widths of figures; inch."""
OTHER_FORMATS = (".csv", ".json", ".mat", ".h5", ".txt", ".toml", ".png", ".svg", ".pdf", ".py")


def read_look(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the values of --width, --title and --format, for `Look` of figures."""
    look: dict[str, Any] = {}
    if arguments.width is not None:
        width = WIDTHS.get(arguments.width)
        if width is None:
            width = read_number("--width", arguments.width, "cm") / 2.54
        if not 3 <= width * 2.54 <= 60:
            raise InputError(
                f"--width: got {arguments.width!r}, need column, page, or 3 to 60, in cm."
            )
        look["width"] = width
    if arguments.title is not None:
        if arguments.title != "none":
            raise InputError(f"--title: got {arguments.title!r}, need none, or leave it out.")
        look["titled"] = False
    if arguments.format is not None:
        names = [suffix[1:] for suffix in FIGURES]
        look["file_format"] = checked_format(arguments.format, names)
    return look


def checked_format(text: str, known: Sequence[str]) -> str:
    """Return the format; InputError suggests the nearest one."""
    refuse_unknown("format", text, known, "--format")
    return text


def figure_file(
    where: str, text: str, look: Mapping[str, Any], suffixes: tuple[str, ...] = FIGURES
) -> Path:
    """Return the path of a figure, as `output_file` does; with --format any suffix will do."""
    return output_file(where, text, () if "file_format" in look else suffixes)


def given_options(arguments: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Return the values of options by name: of those that a command has and that are given."""
    values = {name: getattr(arguments, name, None) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def read_number(where: str, text: str, unit: str = "") -> float:
    """Return a finite number; where a unit is needed, it may be given in another one of its kind.

    InputError names the option and the value received.
    """
    if unit and is_quantity(text):
        return in_unit(text, unit, where)
    try:
        value = float(text)
    except ValueError:
        example = f"0.5 or 209e9, or with a unit of the kind of {unit}" if unit else "0.5 or 1e-9"
        raise InputError(f"{where}: got {text!r}, need a number, such as {example}.") from None
    if not math.isfinite(value):
        raise InputError(f"{where}: got {text!r}, need a finite number.")
    return value


def read_count(where: str, text: str) -> int:
    """Return a whole number ≥ 1, also where it is written like 1e6."""
    value = read_number(where, text)
    if value != int(value) or not 1 <= value <= 1e9:
        raise InputError(f"{where}: got {text!r}, need a whole number from 1 to 1e9.")
    return int(value)


def read_assignments(where: str, texts: Collection[str] | None) -> dict[str, str]:
    """Return name → value of comma-separated ``name=value`` entries, no name twice.

    Without texts, as of an option that is not given, there are none.
    """
    pairs: dict[str, str] = {}
    for entry in ",".join(texts).split(",") if texts else ():
        name, equals, value = (part.strip() for part in entry.partition("="))
        if not (equals and name and value):
            raise InputError(
                f"{where}: got {entry.strip()!r}, need name=value, several separated by commas."
            )
        if name in pairs:
            raise InputError(f"{where}: got {name} twice. Fix: give it once.")
        pairs[name] = value
    return pairs


def read_quantities(
    where: str, texts: Collection[str] | None, units: Callable[[], Mapping[str, str]]
) -> dict[str, float]:
    """Return name → number in SI units of ``name=value`` entries; a value may have a unit.

    `units` returns the unit needed of each name; it is called where an entry has a unit.
    """
    pairs = read_assignments(where, texts)
    return {
        n: read_number(f"{where} {n}", v, unit_for(where, n, v, units)) for n, v in pairs.items()
    }


def unit_for(where: str, name: str, text: str, units: Callable[[], Mapping[str, str]]) -> str:
    """Return the unit needed of a name whose value has one, else none; InputError if unknown."""
    if not any(map(is_quantity, text.split(":"))):
        return ""
    known = units()
    refuse_unknown("quantity", name, known, where)
    return known[name]


def read_names(_where: str, text: str) -> tuple[str, ...]:
    """Return names that commas separate."""
    return tuple(name.strip() for name in text.split(","))


def read_positive(where: str, text: str, unit: str) -> list[float]:
    """Return numbers > 0 that commas separate."""
    values = [read_number(where, entry.strip(), unit) for entry in text.split(",")]
    for value in values:
        if not value > 0:
            raise InputError(f"{where}: got {value:g}, need numbers > 0.")
    return values


def read_slip(where: str, text: str) -> int | float:
    """Return -1 or 1, the sign of the slip velocity, or else an angle in rad."""
    if text.strip() in ("-1", "1", "+1"):
        return int(text)
    try:
        return read_number(where, text, "rad")
    except InputError:
        raise InputError(
            f"{where}: got {text!r}, need -1 or 1, the sign of v_t, or in space an angle, such as "
            "0.5 or 30deg."
        ) from None


def read_velocity(where: str, text: str) -> tuple[float, ...]:
    """Return the numbers along n and t, in space n, t1, t2, in m/s."""
    values = tuple(read_number(where, entry.strip(), "m/s") for entry in text.split(","))
    if len(values) not in (2, 3):
        raise InputError(
            f"{where}: got {text!r}, need numbers along n and t, in space along n, t1, t2, such as "
            "0,1,0."
        )
    return values


def read_range(
    where: str, text: str, unit: str = "", example: str = "1e14:1e18"
) -> tuple[float, float]:
    """Return the ends of ``FROM:TO``; the message of an InputError shows the example."""
    low, colon, high = (part.strip() for part in text.partition(":"))
    if not (colon and low and high):
        raise InputError(f"{where}: got {text!r}, need FROM:TO, such as {example}.")
    return read_number(where, low, unit), read_number(where, high, unit)


def read_ranges(
    where: str,
    texts: Collection[str] | None,
    units: Callable[[], Mapping[str, str]],
    example: str,
) -> dict[str, tuple[float, float]]:
    """Return name → ends of ``name=FROM:TO`` entries; for `units` see `read_quantities`."""
    return {
        name: read_range(
            f"{where} {name}", text, unit_for(where, name, text, units), f"{name}={example}"
        )
        for name, text in read_assignments(where, texts).items()
    }


def output_file(where: str, text: str, suffixes: tuple[str, ...] = ()) -> Path:
    """Return the path of a file that can be written; checked now, before anything is computed.

    InputError for a folder or another special file, a folder that is missing or not writable, a
    file that must not be written, a suffix that is not one of `suffixes`.
    """
    path = Path(_named(where, text))
    if os.path.isdir(path) or text.endswith("/"):
        raise InputError(f"{where}: {text} is a folder. Fix: name a file in it.")
    suffix = path.suffix.lower()
    if suffixes and suffix not in suffixes:
        received = f"the suffix {suffix!r}" if suffix else "no suffix"
        raise InputError(f"{where}: {text} has {received}, need one of {', '.join(suffixes)}.")
    # A link is followed, so that what it points to is replaced and not the link.
    target = Path(os.path.realpath(path))
    if os.path.exists(target) and not (target.is_file() and os.access(target, os.W_OK)):
        raise InputError(f"{where}: {text} exists and cannot be written. Fix: name another file.")
    _check_name(where, text, target)
    _check_folder(where, text, target.parent)
    return target


def output_folder(where: str, text: str) -> Path:
    """Return the path of a folder that exists and can be written, or that can be made."""
    path = Path(os.path.realpath(_named(where, text)))
    if os.path.exists(path) and not path.is_dir():
        raise InputError(f"{where}: {text} is a file. Fix: name a folder.")
    _check_name(where, text, path)
    existing = path
    while not os.path.exists(existing):
        existing = existing.parent
    _check_folder(where, text, existing)
    return path


def output_store(where: str, text: str) -> Path:
    """Return the path of a Zarr store (a folder) that can be written or replaced."""
    path = Path(os.path.realpath(_named(where, text)))
    if os.path.exists(path) and not any((path / n).is_file() for n in (".zgroup", "zarr.json")):
        raise InputError(
            f"{where}: {text} exists and is not a Zarr store. Fix: name another one, or remove it."
        )
    _check_name(where, text, path)
    _check_folder(where, text, path.parent)
    return path


def _named(where: str, text: str) -> str:
    """Return the text; InputError for an empty one, which would be the current folder."""
    if not text.strip():
        raise InputError(f"{where}: got an empty name. Fix: give a name, or leave {where} out.")
    return text


def _check_name(where: str, text: str, path: Path) -> None:
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise InputError(f"{where}: {text}: {error.strerror}. Fix: use another name.") from error


def _check_folder(where: str, text: str, folder: Path) -> None:
    problem = "there is no such folder" if not folder.exists() else None
    if folder.exists() and not folder.is_dir():
        problem = "is not a folder"
    if problem is None:
        try:
            # Trying it out also finds read-only disks, which a look at permissions does not.
            with tempfile.TemporaryFile(dir=folder):
                return
        except OSError as error:
            problem = error.strerror or str(error)
    raise InputError(
        f"{where}: {text} cannot be written, {folder}: {problem}. "
        "Fix: name a place in a folder that exists and is writable."
    )
