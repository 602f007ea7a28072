"""One contact at an array of states: the case of its slip as a code, and whether it can stick.

`ContactProblem` decides the same state by state, with every solution.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.problem.law import ZERO
from painleve_sym.problem.risk import holding_forces
from painleve_sym.problem.solution import ContactCase

Codes = NDArray[np.int_]

SINGULAR = 1e-13
"""Part of W_nn below which A′, the difference of two terms of that size, is their rounding."""

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


def can_stick(
    W: Array, b: Array, mu: Array, line: tuple[Array, Array], sides: Sequence[int]
) -> NDArray[np.bool_]:
    """Return whether a normal force that the contact may have holds its slip.

    Parameters
    ----------
    W, b : ndarray, shape (m, m, ...) and (m, ...)
        The normal row first; 1/kg, m/s².
    mu : ndarray
    line : tuple of two ndarray
        A′ and B′ of a_n = A′ F_n + B′ in sticking; 1/kg, m/s².
    sides : sequence of int
        Signs of F_n.
    """
    force = -line[1] / line[0]
    size = np.max([side * force for side in sides], axis=0)
    gain, free = holding_forces(W, b, 1)
    needed = -(gain[:, 0] * force + free)
    # What friction within its bounds leaves of the slip's acceleration is no more than rounding
    # where it holds the slip; it may miss also a direction in which no motion slides it.
    friction = needed * np.fmin(1.0, mu * size / _length(needed))
    parts = W[1:, 0] * force, np.einsum("ij...,j...->i...", W[1:, 1:], friction), b[1:]
    holds = _length(np.sum(parts, axis=0)) <= ZERO * sum(map(_length, parts))
    allowed = (size > 0) | (len(sides) > 1)
    return np.asarray(holds & allowed & (line[0] > SINGULAR * W[0, 0]))


def _length(vectors: Array) -> Array:
    """Return the lengths of vectors along the tangents, shape (1, n) or (2, n)."""
    return np.asarray(np.abs(vectors[0]) if len(vectors) == 1 else np.hypot(*vectors))
