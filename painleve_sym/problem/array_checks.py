"""Checks of the arrays that state a contact problem: finite numbers, and a mobility among them.

Those of one contact, without arrays, are in `painleve_sym.checks`.
"""

from __future__ import annotations

import math
import operator

import numpy as np

from painleve_sym.checks import INDEFINITE, SYMMETRY
from painleve_sym.errors import received
from painleve_sym.problem.complementarity.solution_sets import FloatArray
from painleve_sym.problem.constraints import Vector


def finite_array(value: object, name: str) -> tuple[FloatArray, str]:
    """Return numbers as an array, and a sentence where they are not finite numbers."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        array = np.array(math.nan)
    entries = array.ravel().tolist()
    # A finite sum has finite terms; a sum of finite terms may overflow.
    if math.isfinite(sum(entries)) or all(map(math.isfinite, entries)):
        return array, ""
    return array, (
        f"{name}: got {received(value)}, need finite numbers. "
        "Fix: check the state it was evaluated at."
    )


def mobility_matrix_faults(W: FloatArray, order: str) -> list[str]:
    """Return a sentence where a mobility is not symmetric or indefinite; `order` names its rows."""
    rows = W.tolist()
    root = [math.sqrt(max(row[k], 0.0)) for k, row in enumerate(rows)]
    scaled: list[Vector] = []  # the triangle up to the diagonal
    for i, (row, r) in enumerate(zip(rows, root, strict=True)):
        own: Vector = []
        for j in range(i + 1):
            w, v, bound = row[j], rows[j][i], r * root[j]
            if abs(w - v) > SYMMETRY * bound or (bound == 0 and (w != 0 or v != 0)):
                return [
                    f"W: got {W!r}, need a symmetric matrix with rows of zeros where the "
                    "diagonal is 0. Fix: compute it as J M^-1 J' with rows "
                    f"{order} of J."
                ]
            own.append(w / bound if bound else 0.0)
        scaled.append(own)
    least = INDEFINITE * len(rows)
    if _factorizes(scaled, least / 2):
        return []
    lower = np.zeros((len(rows), len(rows)))
    for i, own in enumerate(scaled):
        lower[i, : i + 1] = own
    if np.min(np.linalg.eigvalsh(lower, UPLO="L")) >= -least:
        return []
    return [
        f"W: got {W!r}, need a positive semidefinite matrix. "
        "Fix: compute it as J M^-1 J' with a positive definite mass matrix M."
    ]


def _factorizes(matrix: list[Vector], shift: float) -> bool:
    """Return whether a matrix plus `shift` times the identity has a Cholesky factor.

    Then no eigenvalue of the matrix lies below -shift by more than rounding. Few numbers: the
    eigenvalues themselves would take NumPy longer. The matrix is symmetric, with a diagonal of ones
    and zeros; its rows end there.
    """
    factor: list[Vector] = []
    mul = operator.mul
    for i, row in enumerate(matrix):
        own: Vector = []
        for j, other in enumerate(factor):
            own.append((row[j] - sum(map(mul, own, other))) / other[j])
        rest = row[i] + shift - sum(map(mul, own, own))
        if not rest > 0:
            return False
        own.append(math.sqrt(rest))
        factor.append(own)
    return True
