"""The cases of a map by the signs of its coefficients, as codes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.contacts.problem import ContactCase

Codes = NDArray[np.int_]

LEGEND: Mapping[str, int] = {
    "outside": -1,
    ContactCase.SLIP.value: 0,
    ContactCase.LIFTOFF.value: 1,
    ContactCase.INCONSISTENT.value: 2,
    ContactCase.INDETERMINATE.value: 3,
}
"""Codes of the cases; outside: beyond the mechanism's domain, or no finite coefficients."""


def opening_case(A: Array, B: Array) -> Codes:
    """Return the codes of a contact that can open."""
    several = ((A < 0) & (B > 0)) | ((A == 0) & (B == 0))
    return np.where(
        B < 0,
        np.where(A > 0, LEGEND["slip"], LEGEND["inconsistent"]),
        np.where(several, LEGEND["indeterminate"], LEGEND["liftoff"]),
    )


def bilateral_case(A_push: Array, A_pull: Array, B: Array) -> Codes:
    """Return the codes by the number of solutions; a ray of them counts as several."""
    with np.errstate(invalid="ignore"):
        count = (np.sign(A_push) * np.sign(B) < 0).astype(int)
        count += np.sign(A_pull) * np.sign(B) > 0
    count = np.where(B == 0, np.where((A_push == 0) | (A_pull == 0), 2, 1), count)
    codes = np.array([LEGEND["inconsistent"], LEGEND["slip"], LEGEND["indeterminate"]])
    cases: Codes = codes[count]
    return cases
