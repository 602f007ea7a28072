"""Numbers from symbolic expressions, through the same bridge as the generated code."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array

if TYPE_CHECKING:
    import casadi as ca

BLOCK = 4096
"""Points CasADi's map takes at once: its work space stays small."""


def numbers(expressions: Sequence[Any], values: Mapping[Any, float]) -> Array:
    """Return the values of SymPy expressions at a point, shape (len(expressions),).

    The values are those of every symbol that occurs, or of its name.
    """
    import casadi as ca

    from painleve_sym.codegen.bridge import Translator

    by_symbol = {s: ca.SX(v) for s, v in values.items() if not isinstance(s, str)}
    occurring = {s for e in expressions for s in getattr(e, "free_symbols", ())}
    by_symbol |= {s: ca.SX(values[s.name]) for s in occurring - set(by_symbol) if s.name in values}
    translate = Translator(by_symbol, floor=0.0)
    column = translate.vector(list(expressions))
    return np.array(ca.evalf(ca.densify(column))).reshape(-1)


def expression_function(
    name: str, expressions: Sequence[Any], symbols: Sequence[Any], derivatives: Sequence[Any] = ()
) -> ca.Function:
    """Return expressions as one CasADi function of one vector, shape (len(symbols),).

    Each expression's derivatives by `derivatives` follow all the expressions, expression by
    expression.
    """
    import casadi as ca

    from painleve_sym.codegen.bridge import POWER_FLOOR, Translator

    x = ca.SX.sym("x", len(symbols))
    table = {s: x[i] for i, s in enumerate(symbols)}
    # Values without derivatives need no floor under a power.
    translate = Translator(table, floor=POWER_FLOOR if derivatives else 0.0)
    column = translate.vector(list(expressions))
    parts = [column]
    if derivatives:
        by = ca.vertcat(*[table[s] for s in derivatives])
        parts.append(ca.vec(ca.densify(ca.jacobian(column, by)).T))
    return ca.Function(name, [x], ca.cse([ca.densify(ca.vertcat(*parts))]))


def at_points(function: ca.Function, points: Array) -> Array:
    """Return a function of one vector at n points, shape (n, outputs), the same bits as one by one.

    The points are contiguous, shape (n, arguments).
    """
    results = np.empty((len(points), function.numel_out(0)))
    for start in range(0, len(points), BLOCK):
        part, rows = points[start : start + BLOCK], results[start : start + BLOCK]
        mapped = _mapped(function, len(part))
        # CasADi reads and writes these arrays in place: a column of its matrix is a row here.
        buffer: Any
        buffer, evaluate = mapped.buffer()
        buffer.set_arg(0, part.data)
        buffer.set_res(0, rows.data)
        evaluate()
    return results


def at_arrays(function: ca.Function, arrays: Sequence[ArrayLike]) -> Array:
    """Return a function of one vector at arrays that broadcast, shape (outputs, *their shape)."""
    alike = len({np.shape(array) for array in arrays}) == 1
    whole = np.array(arrays if alike else np.broadcast_arrays(*arrays), dtype=np.float64)
    points = np.ascontiguousarray(whole.reshape(len(whole), whole[0].size).T)
    return at_points(function, points).T.reshape(function.numel_out(0), *whole.shape[1:])


# Batches ask for the same number of points again and again.
@functools.lru_cache(maxsize=64)
def _mapped(function: ca.Function, points: int) -> ca.Function:
    return function.map(points) if points > 1 else function


def power(base: Array, exponent: Array) -> Array:
    """Return base**exponent entry by entry, the same bits in an array of any length.

    numpy's own power takes another path through the processor where arrays are long.
    """
    if len(base) > 1 and (base == base[0]).all() and (exponent == exponent[0]).all():
        return np.full(len(base), _power(float(base[0]), float(exponent[0])))
    pairs = base.tolist(), exponent.tolist()
    try:
        return np.fromiter(map(math.pow, *pairs), np.float64, len(base))
    except (ValueError, OverflowError):
        return np.array([_power(x, y) for x, y in zip(*pairs, strict=True)])


def _power(x: float, y: float) -> float:
    try:
        return math.pow(x, y)
    except (ValueError, OverflowError):
        return math.nan if x < 0 else math.inf
