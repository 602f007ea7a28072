"""Formulas at many points: one C loop over arrays, through the same bridge and compile cache."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.array_function import ArrayFunction
from painleve_sym.codegen.evaluate import at_points, expression_function
from painleve_sym.errors import CompilerMissing, InputError, PainleveWarning, unknown_name

ENGINES = ("auto", "compiled", "casadi")


class Pointwise:
    """SymPy expressions as one function of arrays.

    Numbers that are the same at every point are arguments too, so that one compiled library serves
    all of them. The symbols are every one that occurs in the expressions. Each expression's
    derivatives by `derivatives` follow all the expressions, expression by expression.

    The engine ``auto`` is ``compiled`` (C), or ``casadi`` (its virtual machine, slower) with a
    notice where there is no C compiler.

    Raises
    ------
    TranslationError
        An expression holds another symbol, or what generated code has no counterpart of.
    CompilerMissing
        ``compiled`` was asked for and there is none.
    """

    def __init__(
        self,
        expressions: Sequence[Any],
        symbols: Sequence[Any],
        *,
        derivatives: Sequence[Any] = (),
        engine: str = "auto",
    ) -> None:
        if engine not in ENGINES:
            raise InputError(unknown_name("engine", engine, ENGINES))
        if not expressions:
            raise InputError("pointwise: got no expressions, need at least one.")
        self.symbols = tuple(symbols)
        self._function = expression_function("pointwise", expressions, self.symbols, derivatives)
        self.outputs = int(self._function.numel_out(0))
        self._loop = self._compiled(engine) if engine != "casadi" else None
        self.engine = "casadi" if self._loop is None else "compiled"

    def _compiled(self, engine: str) -> ArrayFunction | None:
        try:
            return ArrayFunction.of(self._function)
        except CompilerMissing as error:
            if engine == "compiled":
                raise
            warnings.warn(
                f"{error} Until then formulas are evaluated by the slower engine 'casadi'.",
                PainleveWarning,
                stacklevel=4,
            )
            return None

    def __call__(self, values: Mapping[Any, Any]) -> Array:
        """Return the expressions at the points, shape (outputs, *shape of the points).

        Arrays are broadcast against each other, as numpy does. InputError where a symbol has no
        value, or the shapes do not fit.
        """
        absent = [str(s) for s in self.symbols if s not in values]
        if absent:
            raise InputError(f"pointwise: no value of {', '.join(absent)}. Fix: give it.")
        arrays = [np.asarray(values[s], dtype=np.float64) for s in self.symbols]
        try:
            shape = np.broadcast_shapes(*(a.shape for a in arrays))
        except ValueError as error:
            raise InputError(
                f"pointwise: {error}. Fix: give arrays of one shape, or numbers."
            ) from error
        flat = [_plain(a, shape) for a in arrays]
        n = int(np.prod(shape, dtype=np.int64))
        rows = self._loop.at_points(flat, n) if self._loop is not None else self._by_map(flat, n)
        return rows.reshape(self.outputs, *shape)

    def _by_map(self, arrays: list[Array], n: int) -> Array:
        points = np.empty((n, len(arrays)))
        for i, values in enumerate(arrays):
            points[:, i] = values
        return at_points(self._function, points).T


def _plain(array: Array, shape: tuple[int, ...]) -> Array:
    """Return a number as it is, an array flat and contiguous at all points."""
    if array.ndim == 0:
        return array
    return np.ascontiguousarray(np.broadcast_to(array, shape)).reshape(-1)
