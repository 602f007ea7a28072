"""Entries of a mechanism file: plain data with their lines, and all faults in one list."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from painleve_sym.checks import checked_number
from painleve_sym.errors import ModelError, unknown_name
from painleve_sym.mechanics.toml.expressions import Formulas
from painleve_sym.mechanics.toml.lines import Path, TomlLines


def shown(path: Path) -> str:
    """Return a path as a reader of the file would say it: ``contacts[1].point``."""
    text = ""
    for key in path:
        text += f"[{key + 1}]" if isinstance(key, int) else f".{key}" if text else key
    return text


@dataclass
class Faults:
    """Faults of a file, each with its line.

    Attributes
    ----------
    where : str
        What the message calls the file.
    lines : TomlLines
    """

    where: str
    lines: TomlLines
    found: list[tuple[int, str]] = field(default_factory=list)

    def add(self, path: Path, message: str, line: int | None = None) -> None:
        """Note a fault of an entry; one of the same line and text only once."""
        place = self.lines.of(path) if line is None else line
        name = shown(path)
        entry = (place, f"line {place}{f', {name}' if name else ''}: {message}")
        if entry not in self.found:
            self.found.append(entry)

    def add_all(self, path: Path, error: ModelError) -> None:
        """Note every fault of a part that could not be made."""
        for message in error.faults:
            self.add(path, message)

    def raise_if_any(self) -> None:
        """Raise ModelError with all faults in the order of the file."""
        if self.found:
            raise ModelError(self.where, [text for _, text in sorted(self.found)])


@dataclass
class Entries:
    """Typed access to the data of a file; what is missing or wrong is noted, not raised.

    Attributes
    ----------
    faults : Faults
    formulas : Formulas
        Names that formulas of the file may use.
    """

    faults: Faults
    formulas: Formulas

    def table(self, path: Path, value: Any, known: Iterable[str] | None = None) -> dict[str, Any]:
        """Return a table, empty where it is none; keys that are not `known` are faults."""
        if not isinstance(value, Mapping):
            self.faults.add(path, f"got {value!r}, need a table [{shown(path)}].")
            return {}
        names = None if known is None else list(known)
        for key in value:
            if names is not None and key not in names:
                self.faults.add((*path, key), unknown_name("key", key, names))
        return dict(value)

    def tables(self, path: Path, value: Any, known: Iterable[str]) -> list[dict[str, Any]]:
        """Return the tables of an array [[…]]; a single table [ ] counts as one."""
        if isinstance(value, Mapping) or not isinstance(value, list):
            self.faults.add(path, f"got {value!r}, need an array of tables [[{shown(path)}]].")
            return []
        names = list(known)
        return [self.table((*path, i), entry, names) for i, entry in enumerate(value)]

    def text(self, path: Path, table: Mapping[str, Any], key: str, default: str | None) -> str:
        """Return a text; a missing one is a fault where there is no default."""
        if key not in table:
            if default is None:
                self.faults.add(path, f'{key} is missing. Fix: add {key} = "...".')
            return default or ""
        if not isinstance(table[key], str):
            self.faults.add((*path, key), f"got {table[key]!r}, need text in quotes.")
            return default or ""
        return str(table[key])

    def number(
        self, path: Path, table: Mapping[str, Any], key: str, default: float | None
    ) -> float:
        """Return a finite number; a missing one is a fault where there is no default."""
        value = table.get(key, default)
        if value is None:
            self.faults.add(path, f"{key} is missing. Fix: add {key} = ..., a number.")
            return 1.0
        fallback = 1.0 if default is None else default
        if key not in table:
            return fallback
        number, fault = checked_number(value, key)
        if fault:
            self.faults.add((*path, key), fault.removeprefix(f"{key}: "))
            return fallback
        return number

    def flag(self, path: Path, table: Mapping[str, Any], key: str, default: bool) -> bool:
        """Return a truth value."""
        value = table.get(key, default)
        if not isinstance(value, bool):
            self.faults.add((*path, key), f"got {value!r}, need true or false.")
            return default
        return value

    def formula(
        self,
        path: Path,
        table: Mapping[str, Any],
        key: str,
        default: int | None,
        formulas: Formulas | None = None,
    ) -> sp.Expr | None:
        """Return a formula, or None where it is missing or has faults."""
        if key not in table:
            if default is None:
                self.faults.add(path, f'{key} is missing. Fix: add {key} = "...", a formula.')
                return None
            return sp.Integer(default)
        return self.written((*path, key), table[key], formulas)

    def written(self, path: Path, value: Any, formulas: Formulas | None = None) -> sp.Expr | None:
        """Return the formula of a value, or None where it has faults."""
        expr, faults = (formulas or self.formulas).read(value)
        for fault in faults:
            line = self.faults.lines.of_text(path, fault.line)
            self.faults.add(path, fault.message, line)
        return expr

    def pair(
        self,
        path: Path,
        table: Mapping[str, Any],
        key: str,
        default: tuple[int, int] | None,
    ) -> tuple[sp.Expr, sp.Expr] | None:
        """Return two formulas, such as the x and y of a point, or None where one has faults."""
        if key not in table:
            if default is None:
                fix = f'Fix: add {key} = ["...", "..."].'
                self.faults.add(path, f"{key} is missing. {fix}")
                return None
            return sp.Integer(default[0]), sp.Integer(default[1])
        value = table[key]
        if not isinstance(value, list) or len(value) != 2:
            self.faults.add((*path, key), f'got {value!r}, need two formulas ["...", "..."].')
            return None
        first, second = (self.written((*path, key, i), v) for i, v in enumerate(value))
        return None if first is None or second is None else (first, second)
