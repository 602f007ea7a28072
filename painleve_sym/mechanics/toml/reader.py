"""Tables of a mechanism file: typed entries, and their faults."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

import sympy as sp

from painleve_sym.checks import checked_number
from painleve_sym.errors import ModelError, unknown_name
from painleve_sym.mechanics.toml.expressions import Formulas, TextFault
from painleve_sym.mechanics.toml.faults import Faults, shown
from painleve_sym.mechanics.toml.lines import Path, TomlLines

T = TypeVar("T")


class Source(Faults):
    """The text of a mechanism while it is read, with the line and message of every fault so far.

    `stand_ins` counts the values that stand in for entries that could not be read.
    """

    lines: TomlLines

    def __init__(self, where: str, lines: TomlLines) -> None:
        super().__init__(where, lines)
        self.formulas = Formulas({})
        self.stand_ins = 0

    def text_faults(self, path: Path, faults: Iterable[TextFault]) -> None:
        """Note the faults of a formula, each in its own line."""
        for fault in faults:
            self.fault(path, fault.message, self.lines.of_text(path, fault.line))

    @contextmanager
    def making(self, *path: str | int) -> Iterator[None]:
        """Note every fault of the part that is made inside, and continue after it."""
        try:
            yield
        except ModelError as error:
            for message in error.faults:
                self.fault(path, message)


@dataclass(frozen=True)
class Table:
    """One table of a file.

    Missing and wrong entries are recorded as faults, and substitutes are returned for them.
    """

    source: Source
    path: Path
    entries: Mapping[str, Any]

    @classmethod
    def of(cls, source: Source, path: Path, value: Any, known: Iterable[str] | None) -> Table:
        """Return a table, empty where `value` is none; keys that are not `known` are faults."""
        if not isinstance(value, Mapping):
            source.fault(path, f"got {value!r}, need a table [{shown(path)}].")
            return cls(source, path, {})
        names = None if known is None else list(known)
        for key in value:
            if names is not None and key not in names:
                source.fault((*path, key), unknown_name("key", key, names))
        return cls(source, path, value)

    def __iter__(self) -> Iterator[str]:
        return iter(self.entries)

    def fault(self, message: str, *keys: str) -> None:
        """Note a fault of the table, or of an entry in it."""
        self.source.fault((*self.path, *keys), message)

    def table(self, key: str, known: Iterable[str] | None = None) -> Table:
        """Return the table of that key, empty where there is none."""
        return Table.of(self.source, (*self.path, key), self.entries.get(key, {}), known)

    def tables(self, key: str, known: Iterable[str]) -> list[Table]:
        """Return the tables of an array [[…]]."""
        value, names = self.entries.get(key, []), list(known)
        if not isinstance(value, list):
            self.fault(f"got {value!r}, need an array of tables [[{key}]].", key)
            return []
        path = (*self.path, key)
        return [Table.of(self.source, (*path, i), entry, names) for i, entry in enumerate(value)]

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text; a missing one is a fault where there is no default."""
        value = self.entries.get(key, default)
        if value is None:
            self.fault(f'{key} is missing. Fix: add {key} = "...".')
        elif not isinstance(value, str):
            self.fault(f"got {value!r}, need text in quotes.", key)
        else:
            return value
        return default or ""

    def named(self, key: str, kind: str, known: Mapping[str, T]) -> T | None:
        """Return the object of a kind that a text names; None, with a fault, if unknown."""
        name = self.text(key)
        if name not in known and isinstance(self.entries.get(key), str):
            self.fault(unknown_name(kind, name, known), key)
        return known.get(name)

    def number(self, key: str, default: float | None = None) -> float:
        """Return a finite number; a missing one is a fault where there is no default."""
        if key in self.entries:
            number, fault = checked_number(self.entries[key], key)
            if not fault:
                return number
            self.fault(fault.removeprefix(f"{key}: "), key)
        elif default is None:
            self.fault(f"{key} is missing. Fix: add {key} = ..., a number.")
        return 1.0 if default is None else default

    def flag(self, key: str, default: bool) -> bool:
        """Return a truth value."""
        value = self.entries.get(key, default)
        if not isinstance(value, bool):
            self.fault(f"got {value!r}, need true or false.", key)
            return default
        return value

    def formula(
        self, key: str, default: int | None = None, formulas: Formulas | None = None
    ) -> sp.Expr:
        """Return a formula; a missing one is a fault where there is no default."""
        if key in self.entries:
            return self.written(self.entries[key], key, formulas=formulas)
        if default is None:
            self.fault(f'{key} is missing. Fix: add {key} = "...", a formula.')
            self.source.stand_ins += 1
        return sp.Integer(1 if default is None else default)

    def pair(self, key: str, default: tuple[int, int] | None = None) -> tuple[sp.Expr, sp.Expr]:
        """Return two formulas, such as the x and y of a point."""
        value = self.entries.get(key, default)
        if value is None:
            self.fault(f'{key} is missing. Fix: add {key} = ["...", "..."].')
        elif key in self.entries and (not isinstance(value, list) or len(value) != 2):
            self.fault(f'got {value!r}, need two formulas ["...", "..."].', key)
        else:
            first, second = (self.written(v, key, i) for i, v in enumerate(value))
            return first, second
        self.source.stand_ins += 1
        return sp.Integer(1), sp.Integer(1)

    def vector(self, key: str, size: int = 3) -> tuple[sp.Expr, ...]:
        """Return formulas, such as the x, y and z of a point in space."""
        value = self.entries.get(key)
        if isinstance(value, list) and len(value) == size:
            return tuple(self.written(v, key, i) for i, v in enumerate(value))
        self.fault(f"got {value!r}, need {size} formulas in a list.", key)
        self.source.stand_ins += 1
        return tuple(sp.Integer(1) for _ in range(size))

    def points(self, key: str) -> list[tuple[sp.Expr, sp.Expr]]:
        """Return a list of points, each of two formulas."""
        value = self.entries.get(key, [])
        if not isinstance(value, list) or any(
            not isinstance(entry, list) or len(entry) != 2 for entry in value
        ):
            self.fault(f'got {value!r}, need a list of points ["...", "..."].', key)
            self.source.stand_ins += 1
            return []
        return [
            (self.written(x, key, i, 0), self.written(y, key, i, 1))
            for i, (x, y) in enumerate(value)
        ]

    def formula_of_place(
        self, key: str, axes: Sequence[str], names: Mapping[str, sp.Expr]
    ) -> Callable[..., sp.Expr]:
        """Return a formula as a function of its place; it may use `names` beside the axes."""
        for name in set(names) & set(axes):
            fix = "Fix: rename the parameter."
            self.fault(f"{name} means the place, not the parameter. {fix}", key)
        place = {name: sp.Dummy(name, real=True) for name in axes}
        formula = self.formula(key, formulas=Formulas({**names, **place}))

        def at(*values: sp.Expr) -> sp.Expr:
            return formula.subs(dict(zip(place.values(), values, strict=True)), simultaneous=True)

        return at

    def written(self, value: Any, *keys: str | int, formulas: Formulas | None = None) -> sp.Expr:
        """Return the formula that a value is, under these keys; its faults are recorded."""
        expr, faults = (formulas or self.source.formulas).read(value)
        self.source.text_faults((*self.path, *keys), faults)
        if expr is None:
            self.source.stand_ins += 1
            return sp.Integer(1)
        return expr
