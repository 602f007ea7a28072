"""Numbers from symbolic expressions, through the same bridge as the generated code."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca
import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.bridge import Translator


def numbers(expressions: Sequence[Any], values: Mapping[Any, float]) -> Array:
    """Return the values of SymPy expressions at a point, shape (len(expressions),).

    Parameters
    ----------
    expressions : sequence of sympy.Expr
    values : mapping of sympy.Symbol to float
        Every symbol that occurs.
    """
    translate = Translator({s: ca.SX(v) for s, v in values.items()}, floor=0.0)
    column = translate.vector(list(expressions))
    return np.array(ca.evalf(ca.densify(column))).reshape(-1)


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
