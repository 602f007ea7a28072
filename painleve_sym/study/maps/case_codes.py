"""The cases of a map by the signs of its coefficients, as codes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.problem.solution import ContactCase

Codes = NDArray[np.int_]

LEGEND: Mapping[str, int] = {
    "outside": -1,
    ContactCase.SLIP.value: 0,
    ContactCase.LIFTOFF.value: 1,
    ContactCase.INCONSISTENT.value: 2,
    ContactCase.INDETERMINATE.value: 3,
}
"""Codes of the cases; outside: beyond the mechanism's domain, or no finite coefficients."""


def case_codes(A: Sequence[Array], B: Array) -> Codes:
    """Return the codes of a sliding contact by the number of its solutions.

    A of each sign of F_n that the contact has: F_n > 0, and F_n < 0 of one that holds from both
    sides. Each has a solution where -B/A has its sign, and a ray where A = B = 0; F_n = 0 is one
    where B = 0, and where B > 0 opens the contact.
    """
    opens = len(A) == 1
    free = (B >= 0) if opens else (B == 0)
    count = free.astype(int)
    for side, slope in zip((1, -1), A, strict=False):
        with np.errstate(invalid="ignore"):
            count += (side * np.sign(slope) * np.sign(B) < 0) | ((slope == 0) & (B == 0))
    one = np.where(free & opens, LEGEND["liftoff"], LEGEND["slip"])
    codes: Codes = np.select(
        [count == 0, count == 1], [LEGEND["inconsistent"], one], LEGEND["indeterminate"]
    )
    return codes
