"""Below which part of its terms a sum counts as zero, each part with its reason.

Here and everywhere else, adding 0.0 turns -0.0 into 0.0.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

SUM = 4 * 2.0**-52
"""Two products and their difference, each rounded once: a smaller sign would be an accident."""
MOVED = 1e-14
"""A velocity after impulses: a sum of rounded products of numbers that are rounded themselves."""
SOLVED = 1e-13
"""Of the largest unknown: what a solve may leave of a zero, where the residual agrees."""


def rounded(value: FloatArray, size: FloatArray, part: float = SUM) -> FloatArray:
    """Return values, exactly 0 within this part of the size of their terms."""
    return np.where(np.abs(value) <= part * size, 0.0, value)


def rounded_sum(*terms: float, part: float = SUM) -> float:
    """Return the sum, exactly 0 within this part of the size of its terms."""
    value = size = 0.0
    for term in terms:
        value += term
        size += abs(term)
    return value if abs(value) > part * size else 0.0


def rounded_difference(a: npt.ArrayLike, b: npt.ArrayLike) -> FloatArray:
    """Return ``a - b``, exactly 0 within the rounding of its two terms."""
    first, second = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    return rounded(first - second, np.abs(first) + np.abs(second))
