"""What a mechanism, a law or a builder is, as one text: equal texts give equal derivations."""

from __future__ import annotations

import dataclasses
import enum
import functools
from collections.abc import Mapping
from typing import Any

import sympy as sp

SYMPY_VERSION = str(sp.__version__)
"""Another version may write the same derivation another way."""

_PLAYS_NO_PART = "plays no part in derivations"
NOT_DERIVED_FROM: Mapping[str, bool] = {_PLAYS_NO_PART: True}
"""Metadata of a dataclass field that no derivation depends on, such as a default value."""


def definition_text(thing: Any) -> str:
    """Return a text that tells everything the derivations of a thing start from.

    Nothing is derived. Arguments keep the order they have, since the order of a sum decides its
    last digit. The text is for comparing and hashing; it is never read back.

    Parameters
    ----------
    thing : object
        Dataclasses, SymPy expressions, mappings, sequences, enums, texts and numbers, nested in
        any way. Fields marked as `NOT_DERIVED_FROM`, or left out of comparisons, play no part.

    Raises
    ------
    TypeError
        Something else is in it (a function, say), whose content cannot be told.
    """
    return _Writer(thing).text(thing)


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

    def text(self, thing: Any) -> str:
        if isinstance(thing, sp.Basic):
            return self._formula(thing)
        if isinstance(thing, enum.StrEnum):
            return repr(thing.value)
        if thing is None or isinstance(thing, bool | int | float | str):
            return repr(thing)
        if isinstance(thing, enum.Enum):
            return str(thing)
        if isinstance(thing, tuple | list):
            return f"[{','.join(map(self.text, thing))}]"
        if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
            known = getattr(thing, "definition", None) if thing is not self._whole else None
            return f"<{known}>" if isinstance(known, str) else self._dataclass(thing)
        if isinstance(thing, Mapping):
            pairs = (f"{self.text(k)}:{self.text(v)}" for k, v in thing.items())
            return f"{{{','.join(pairs)}}}"
        raise TypeError(f"definition: got {type(thing).__name__}, which has no content to write.")

    def _dataclass(self, thing: Any) -> str:
        number = self._seen.get(id(thing))
        if number is not None:
            return f"#{number}"
        self._seen[id(thing)] = len(self._seen)
        self._kept.append(thing)  # an object that is gone could lend its id to another
        entries = (
            f"{f.name}={self.text(getattr(thing, f.name))}"
            for f in dataclasses.fields(thing)
            if f.compare and not f.metadata.get(_PLAYS_NO_PART)
        )
        kind = type(thing)
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
