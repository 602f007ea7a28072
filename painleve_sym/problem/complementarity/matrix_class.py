"""Classes of matrices that promise solutions of a linear complementarity problem beforehand.

References
----------
Cottle, Pang & Stone (1992), "CPS" below; Hadeler (1983).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from painleve_sym.errors import InputError
from painleve_sym.problem.complementarity.lcp import (
    ENUMERATION_LIMIT,
    LCP,
    equilibrate,
    principal_block,
)
from painleve_sym.problem.complementarity.solution_sets import FloatArray

_MINOR = 1e-13  # a determinant below this part of Hadamard's bound has no certain sign


def is_p_matrix(matrix: npt.ArrayLike) -> bool:
    """Return whether every principal minor is positive.

    Exactly then the LCP has one and only one solution for every offset (CPS theorem 3.3.7), and
    Lemke's method finds it. All ``2**n - 1`` minors are computed, for n up to `ENUMERATION_LIMIT`;
    one within rounding of zero counts as not positive.
    """
    scaled, _ = equilibrate(_square("is_p_matrix", matrix))
    return all(_sign(principal_block(scaled.matrix, index)) > 0 for index in _subsets(scaled.size))


def is_copositive(matrix: npt.ArrayLike, strict: bool = False) -> bool:
    """Return whether ``x'Mx >= 0`` for every ``x >= 0``; with `strict`, > 0 for every such x != 0.

    By Hadeler (1983): a symmetric matrix whose smaller principal blocks all pass fails if and only
    if ``det < 0`` and ``adj >= 0`` (strict: ``det <= 0`` and ``adj > 0``). The symmetric part is
    taken first; n is at most `ENUMERATION_LIMIT`. With a strictly copositive M, Lemke's method
    solves the LCP for every offset (CPS section 4.4); with a copositive one, for each q with ``q'v
    >= 0`` for all solutions v of the homogeneous problem. Neither promises that the solution is the
    only one.
    """
    full = _square("is_copositive", matrix).matrix
    symmetric, least = (full + full.T) / 2, 1 if strict else 0
    for index in _subsets(full.shape[0]):
        block = principal_block(symmetric, index)
        if _sign(block) < least and all(
            _cofactor_sign(block, i, j) >= least for i, j in np.ndindex(block.shape)
        ):
            return False
    return True


def _square(where: str, matrix: npt.ArrayLike) -> LCP:
    """Return the matrix, checked, as a problem with offset zero."""
    lcp = LCP(np.asarray(matrix), np.zeros(np.shape(matrix)[:1]))
    if lcp.size > ENUMERATION_LIMIT:
        raise InputError(
            f"{where} cannot try 2**n minors: got n = {lcp.size}, need n <= {ENUMERATION_LIMIT}. "
            "Fix: test a smaller block."
        )
    return lcp


def _subsets(n: int) -> Iterator[npt.NDArray[np.intp]]:
    """Yield every nonempty set of indices below n, small ones first."""
    for size in range(1, n + 1):
        for chosen in itertools.combinations(range(n), size):
            yield np.array(chosen)


def determinant_signs(
    matrices: FloatArray, terms: FloatArray | None = None
) -> npt.NDArray[np.int_]:
    """Return the signs of the determinants of matrices (..., k, k), 0 where rounding hides them.

    `terms` holds the size of what each entry was summed from; without it entries count as exact.
    """
    bound = np.prod(np.linalg.norm(matrices if terms is None else terms, axis=-1), axis=-1)
    det = np.linalg.det(matrices)
    return np.where(np.abs(det) <= _MINOR * bound, 0, np.sign(det)).astype(int)


def _sign(matrix: FloatArray) -> int:
    return int(determinant_signs(matrix))


def _cofactor_sign(matrix: FloatArray, i: int, j: int) -> int:
    """Return the sign of one entry of the adjugate of a symmetric matrix."""
    minor = np.delete(np.delete(matrix, i, axis=0), j, axis=1)
    return _sign(minor) if (i + j) % 2 == 0 else -_sign(minor)
