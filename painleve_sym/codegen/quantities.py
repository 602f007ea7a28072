"""Named numbers of a state from formulas, taken from the cache where they were derived before."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.derivation_cache import entry_key, read_entry, write_entry
from painleve_sym.codegen.evaluate import at_points, expression_function
from painleve_sym.time_limit import within_time


@dataclass(frozen=True)
class Quantities:
    """Formulas as one function.

    Attributes
    ----------
    names : tuple of str
    symbols : tuple of sympy.Symbol
        Arguments of the function, in this order.
    function : casadi.Function
        Of one vector, shape (len(symbols),), to one of shape (len(names),).
    """

    names: tuple[str, ...]
    symbols: tuple[Any, ...]
    function: ca.Function

    def __call__(self, values: Mapping[Any, float]) -> dict[str, float]:
        """Return the numbers by name; `values` holds every symbol and may hold others."""
        numbers = np.array(self.function([values[s] for s in self.symbols])).reshape(-1)
        return dict(zip(self.names, map(float, numbers), strict=True))

    def at(self, values: Mapping[Any, Array]) -> dict[str, Array]:
        """Return the numbers at n points, each of shape (n,), the same bits as one by one.

        Parameters
        ----------
        values : mapping of sympy.Symbol to ndarray, shape (n,)
            Every symbol, and maybe others.
        """
        points = np.array([values[s] for s in self.symbols], dtype=np.float64).T.copy()
        numbers = at_points(self.function, points)
        return dict(zip(self.names, numbers.T, strict=True))


def quantities(
    title: str, of: Any, symbols: Sequence[Any], derive: Callable[[], Mapping[str, Any]]
) -> Quantities:
    """Return formulas ready to be evaluated; `derive` is called only where the cache lacks them.

    Parameters
    ----------
    title : str
        Distinguishes these formulas from others of the same object.
    of : object
        What they are derived from (`definition_text`).
    symbols : sequence of sympy.Symbol
        Every symbol that occurs in the formulas.
    derive : callable
        Returns the formulas by name.
    """
    text = f"quantities\n{title}"
    key = _text_key(text, of) if isinstance(of, str) else entry_key(text, of)
    names, function = _stored(key) if key else ((), None)
    if function is None:

        def derived() -> tuple[tuple[str, ...], ca.Function]:
            formulas = derive()
            values = tuple(formulas.values())
            return tuple(formulas), expression_function("quantities", values, symbols)

        names, function = within_time(title, derived)
        if key:
            write_entry(key, {"names": names, "function": function.serialize()})
            _stored.cache_clear()
    return Quantities(names, tuple(symbols), function)


# Every run asks for the same few.
_text_key = functools.lru_cache(maxsize=256)(entry_key)


# One entry is asked for again and again, at every state that is looked at.
@functools.lru_cache(maxsize=64)
def _stored(key: str) -> tuple[tuple[str, ...], ca.Function | None]:
    entry = read_entry(key)
    if entry is None:
        return (), None
    return tuple(entry["names"]), ca.Function.deserialize(entry["function"])
