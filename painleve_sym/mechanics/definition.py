"""Canonical text of a mechanism, law or builder: equal texts give equal derivations."""

from __future__ import annotations

import dataclasses
import enum
import functools
import hashlib
from collections.abc import Mapping
from typing import Any

import sympy as sp

from painleve_sym.mechanics.declarations import PLAYS_NO_PART


def definition_text(value: Any) -> str:
    """Return a text with everything that the derivations of an object depend on.

    Nothing is derived. Arguments keep the order they have, since the order of a sum decides its
    last digit. The text is for comparing and hashing; it is never read back.

    The object may hold dataclasses, SymPy expressions, mappings, sequences, enums, texts and
    numbers, nested in any way; anything else (a function, say) has no text and raises TypeError.
    Fields marked as `NOT_DERIVED_FROM`, or left out of comparisons, play no part.
    """
    return _Writer(value).text(value)


def definition_hash(value: Any) -> str:
    """Return the hash of `definition_text`."""
    return hashlib.sha256(definition_text(value).encode()).hexdigest()


# A symbol occurs in every definition of a process; SymPy's own text of it takes 0.1 ms.
@functools.lru_cache(maxsize=4096)
def _leaf(_: str, expr: sp.Basic) -> str:
    if type(expr) is sp.Symbol:
        return f"Symbol({expr.name!r},{sorted(expr.assumptions0.items())})"
    if expr.is_Rational:
        return f"Rational({expr.p},{expr.q})"
    return str(sp.srepr(expr))


class _Writer:
    """Writes each object once; a system occurs in its mechanism and in every contact.

    Parts that keep a `definition` of their own are written as that.
    """

    def __init__(self, whole: Any) -> None:
        self._whole = whole
        self._seen: dict[int, int] = {}
        self._kept: list[Any] = []
        self._formulas: dict[sp.Basic, str] = {}

    def text(self, value: Any) -> str:
        if isinstance(value, sp.Basic):
            return self._formula(value)
        if isinstance(value, enum.Enum):
            return repr(value.value)
        if value is None or isinstance(value, bool | int | float | str):
            return repr(value)
        if isinstance(value, tuple | list):
            return f"[{','.join(map(self.text, value))}]"
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            known = getattr(value, "definition", None) if value is not self._whole else None
            return f"<{known}>" if isinstance(known, str) else self._dataclass(value)
        if isinstance(value, Mapping):
            pairs = (f"{self.text(k)}:{self.text(v)}" for k, v in value.items())
            return f"{{{','.join(pairs)}}}"
        raise TypeError(f"definition: got {type(value).__name__}, which has no content to write.")

    def _dataclass(self, value: Any) -> str:
        number = self._seen.get(id(value))
        if number is not None:
            return f"#{number}"
        self._seen[id(value)] = len(self._seen)
        self._kept.append(value)  # keep a reference: ids are reused after collection
        entries = (
            f"{f.name}={self.text(getattr(value, f.name))}"
            for f in dataclasses.fields(value)
            if f.compare and not f.metadata.get(PLAYS_NO_PART)
        )
        kind = type(value)
        return f"{kind.__module__}.{kind.__qualname__}({','.join(entries)})"

    def _formula(self, expr: sp.Basic) -> str:
        known = self._formulas.get(expr)
        if known is None:
            if expr.args:
                inner = ",".join(map(self._formula, expr.args))
                known = f"{expr.func.__name__}({inner})"
            else:
                known = _leaf(expr.func.__name__, expr)
            self._formulas[expr] = known
        return known
