"""Formulas at many points, as one function of arrays that CasADi evaluates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.evaluate import at_arrays, expression_function
from painleve_sym.errors import InputError


class Pointwise:
    """SymPy expressions as one function of arrays.

    The symbols are every one that occurs in the expressions. Each expression's derivatives by
    `derivatives` follow all the expressions, expression by expression.

    Raises
    ------
    TranslationError
        An expression holds another symbol, or what generated code has no counterpart of.
    """

    def __init__(
        self, expressions: Sequence[Any], symbols: Sequence[Any], *, derivatives: Sequence[Any] = ()
    ) -> None:
        if not expressions:
            raise InputError("pointwise: got no expressions, need at least one.")
        self.symbols = tuple(symbols)
        self._function = expression_function("pointwise", expressions, self.symbols, derivatives)

    def __call__(self, values: Mapping[Any, Any]) -> Array:
        """Return the expressions at the points, shape (outputs, *shape of the points).

        Arrays are broadcast against each other, as numpy does. InputError where a symbol has no
        value, or the shapes do not fit.
        """
        absent = [str(s) for s in self.symbols if s not in values]
        if absent:
            raise InputError(f"pointwise: no value of {', '.join(absent)}. Fix: give it.")
        try:
            arrays = np.broadcast_arrays(*(np.asarray(values[s], float) for s in self.symbols))
        except ValueError as error:
            raise InputError(
                f"pointwise: {error}. Fix: give arrays of one shape, or numbers."
            ) from error
        return at_arrays(self._function, arrays)
