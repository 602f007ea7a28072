"""Linear complementarity problems: every solution, and a check of each answer.

An LCP asks for ``z`` with ``w = M z + q``, ``z >= 0``, ``w >= 0`` and ``z_i w_i = 0`` for every i.
It may have one solution, several, a continuum or none, and each of these is a result here, not an
exception: the paradox of a rod on rough ground is exactly an LCP that has none or two.

References
----------
Cottle, Pang & Stone (1992), "CPS" below.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.problem.complementarity.solution_sets import BoolArray, FloatArray, affine_face
from painleve_sym.problem.rounding import SOLVED

ENUMERATION_LIMIT = 14  # 2**14 cones take a few seconds, and each further pair doubles that
RESIDUAL_TOLERANCE = 1e-10  # a stable solve leaves some 1e-15; a wrong sign leaves order one
Face = tuple[FloatArray, BoolArray]  # a point of it, and which entries vary along it


@dataclass(frozen=True, eq=False)
class LCP(Compared):
    """State one problem ``w = matrix z + offset``, ``z >= 0``, ``w >= 0``, ``z'w = 0``.

    In a contact problem a positive entry of `z` is a force that pushes (or a speeding-up of slip),
    a positive entry of `w` an acceleration that separates (or friction in reserve).

    Parameters
    ----------
    matrix : array_like, shape (n, n)
        M, finite; the unit of entry (i, j) is that of ``w_i / z_j``.
    offset : array_like, shape (n,)
        q, finite; the units of w.

    Raises
    ------
    InputError
        For wrong shapes or entries that are not finite numbers; every fault is named at once. Fix:
        pass one row, one column and one offset for each complementary pair.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> W, b = [[4.0, 1.0], [1.0, 2.0]], [-9.8, 0.0]
    >>> problem = ps.ContactProblem(W, b, [0.5], slip_velocity=[-1.0])
    >>> lcp = problem.lcp()
    >>> lcp.size, lcp.matrix.tolist(), lcp.offset.tolist()
    (1, [[4.5]], [-9.8])
    """

    matrix: FloatArray
    offset: FloatArray

    def __post_init__(self) -> None:
        """Check both arrays and keep read-only copies of them."""
        faults: list[str] = []
        matrix = _numbers("matrix", self.matrix, faults)
        offset = _numbers("offset", self.offset, faults)
        if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[-1] or matrix.size == 0:
            faults.append(
                f"matrix: got shape {matrix.shape}, need (n, n) with n >= 1. "
                "Fix: give one row and one column for each complementary pair."
            )
        if offset.shape != matrix.shape[:1]:
            faults.append(
                f"offset: got shape {offset.shape}, need {matrix.shape[:1]}. "
                "Fix: give one entry for each row of the matrix."
            )
        if faults:
            raise InputError("LCP cannot be stated, " + " Also, ".join(faults))
        for name, array in (("matrix", matrix), ("offset", offset)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def size(self) -> int:
        """Return n, the number of complementary pairs."""
        return int(self.offset.size)


@dataclass(frozen=True, eq=False)
class LCPSolution(Compared):
    """Hold one verified solution.

    `z` and ``w = M z + q`` are as computed, rounding included, and read-only. A pair is active
    where ``z_i > 0``, so that ``w_i = 0``.

    `varying` tells which z_i change along the ray, segment or wider set of solutions through this
    one. None where more than `ENUMERATION_LIMIT` pairs are zero on both sides, too many to try.
    """

    z: FloatArray
    w: FloatArray
    residual: float
    active: tuple[bool, ...]
    varying: tuple[bool, ...] | None

    @property
    def isolated(self) -> bool | None:
        """Return whether no other solution is arbitrarily near; None where not determined."""
        return None if self.varying is None else not any(self.varying)


def residual(lcp: LCP, z: npt.ArrayLike) -> float:
    """Measure how far z is from solving the problem, free of units; 0 for an exact solution.

    The largest of ``-z_i`` and ``-w_i`` where negative and of ``min(|z_i|, |w_i|)``, each as a
    fraction of its own scale. That of w_i is the sum of its terms, ``|q_i| + sum_j |M_ij z_j|``;
    z_j is measured by the largest share it has in any of these sums. Positive scaling of rows or
    columns therefore changes nothing, and rounding alone leaves some 1e-15. It is at most 1, or
    ``inf`` for an infinite or nan entry.
    """
    point = np.asarray(z, dtype=float)
    if point.shape != lcp.offset.shape:
        raise InputError(
            f"residual cannot be measured, z: got shape {point.shape}, need {lcp.offset.shape}. "
            "Fix: give one entry for each complementary pair."
        )
    if not np.all(np.isfinite(point)):
        return float("inf")
    share, w = shares(lcp, point)
    wrong = np.maximum(np.where(point < 0, share, 0.0), np.where(w < 0, -w, 0.0))
    return float(np.max(np.maximum(wrong, np.minimum(share, np.abs(w)))))


def solve_all(lcp: LCP, tol: float = RESIDUAL_TOLERANCE) -> tuple[LCPSolution, ...]:
    """Find every solution by trying each choice of ``z_i = 0`` or ``w_i = 0``.

    For each set S of active pairs, ``M_SS z_S = -q_S`` is solved with all other ``z_i = 0`` (a
    complementary cone, CPS section 1.3). Where M_SS is singular, the solutions in that cone form a
    point, segment, ray or wider face; one representative of it is returned, inside the face where
    it has an inside, and marked as not isolated unless the face is a point.

    Solutions are ordered by the number of active pairs. Their `residual` is at most `tol`, and two
    that are nearer than that in the same measure are one.

    Raises
    ------
    InputError
        For more than `ENUMERATION_LIMIT` pairs. Fix: use `solve_lemke`, which returns one solution.
    """
    if lcp.size > ENUMERATION_LIMIT:
        raise InputError(
            f"solve_all cannot try 2**n cones: got n = {lcp.size}, need n <= {ENUMERATION_LIMIT}. "
            "Fix: call solve_lemke for one solution."
        )
    scaled, unit = equilibrate(lcp)
    supports = _between(np.zeros(lcp.size, bool), np.ones(lcp.size, bool))
    faces = {support.tobytes(): _cone_face(scaled, support) for support in supports}
    points: list[FloatArray] = []
    for face in faces.values():
        point = None if face is None else cleaned(scaled, face[0], tol)
        if point is not None and not any(_same(scaled, point, other, tol) for other in points):
            points.append(point)
    return tuple(solution_at(lcp, scaled, unit, point, faces) for point in points)


def equilibrate(lcp: LCP) -> tuple[LCP, FloatArray]:
    """Scale rows, columns and offset to order one by powers of two, which rounds nothing.

    Return the problem with the same signs and the same sets of active pairs, and its unit, shape
    (n,): a solution z' of it is the solution ``unit * z'`` of `lcp`.
    """
    row = _power_of_two(np.max(np.abs(lcp.matrix), axis=1))
    matrix = lcp.matrix / row[:, None]
    column = _power_of_two(np.max(np.abs(matrix), axis=0))
    offset = lcp.offset / row
    size = _power_of_two(np.max(np.abs(offset), keepdims=True))
    return LCP(matrix / column, offset / size), size / column


def _numbers(name: str, value: npt.ArrayLike, faults: list[str]) -> FloatArray:
    """Return a float copy; note in `faults` what is not a real, finite number."""
    try:
        array = np.array(value)
        if np.iscomplexobj(array):
            raise TypeError("complex entries")
        array = array.astype(float)
    except (TypeError, ValueError) as error:
        faults.append(f"{name}: got {error}, need real numbers. Fix: evaluate symbols first.")
        return np.empty(0)
    if not np.all(np.isfinite(array)):
        faults.append(
            f"{name}: got an infinite or nan entry, need finite numbers. "
            "Fix: check the state that the coefficients were evaluated at."
        )
    return array


def _power_of_two(size: FloatArray) -> FloatArray:
    """Return for each size the power of two next to it, and 1 for zero."""
    return np.where(size > 0, np.ldexp(1.0, np.frexp(size)[1]), 1.0)


def shares(lcp: LCP, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the largest share of each z_j in any row, and each w_i by its row's scale."""
    terms = np.abs(lcp.matrix * z)
    scale = np.abs(lcp.offset) + terms.sum(axis=1)
    normal = scale >= np.finfo(np.float64).tiny  # the inverse of a denormal overflows
    inverse = np.divide(1.0, scale, out=np.zeros_like(scale), where=normal)
    share = np.max(terms * inverse[:, None], axis=0)
    # A column of zeros has no share anywhere; its entry still counts as a whole.
    share[np.all(lcp.matrix == 0, axis=0) & (z != 0)] = 1.0
    return share, (lcp.matrix @ z + lcp.offset) * inverse


def _same(lcp: LCP, a: FloatArray, b: FloatArray, tol: float) -> bool:
    """Return whether the step from a to b is negligible in every row."""
    both = np.maximum(np.abs(a), np.abs(b))
    scale = np.abs(lcp.offset) + np.abs(lcp.matrix) @ both
    idle = np.all(lcp.matrix == 0, axis=0)
    return bool(
        np.all(np.abs(lcp.matrix * (a - b)) <= tol * scale[:, None])
        and np.all(np.abs(a - b)[idle] <= tol * both[idle])
    )


def cleaned(lcp: LCP, z: FloatArray, tol: float) -> FloatArray | None:
    """Return z with negligible entries set to zero, or None if that is not a solution."""
    negligible = shares(lcp, z)[0] <= tol
    # What a solve leaves of an exact zero may be all there is in a row; so try without it, too.
    for noise in (0.0, SOLVED * float(np.max(np.abs(z)))):
        clean = np.where(negligible | (np.abs(z) <= noise), 0.0, z)
        if residual(lcp, clean) <= tol:
            return clean
    return None


def _between(least: BoolArray, most: BoolArray) -> Iterator[BoolArray]:
    """Yield every set from `least` to `most`, small ones first."""
    optional = np.flatnonzero(most & ~least)
    for count in range(optional.size + 1):
        for chosen in itertools.combinations(optional, count):
            support = least.copy()
            support[list(chosen)] = True
            yield support


def _cone_face(lcp: LCP, support: BoolArray) -> Face | None:
    """Return a point of one complementary cone's solutions and which entries vary along them."""
    index = np.flatnonzero(support)
    # On the support z >= 0 is to hold, elsewhere w >= 0.
    rows = np.where(support[:, None], np.eye(lcp.size), lcp.matrix)[:, index]
    start = np.where(support, 0.0, lcp.offset)
    block = principal_block(lcp.matrix, index)
    face = affine_face(block, -lcp.offset[index], rows, start, lcp.size)
    if face is None:
        return None
    z, varies = np.zeros(lcp.size), np.zeros(lcp.size, bool)
    z[index], varies[index] = face
    return z, varies


def solution_at(
    lcp: LCP,
    scaled: LCP,
    unit: FloatArray,
    point: FloatArray,
    faces: Mapping[bytes, Face | None] | None = None,
) -> LCPSolution:
    """Return the solution in the units of `lcp`, with the set of solutions around it.

    `faces` are those of all sets, where they have been computed.
    """
    z = unit * point
    w = lcp.matrix @ z + lcp.offset
    z.setflags(write=False)
    w.setflags(write=False)
    active = point > 0
    open_pair = np.abs(shares(scaled, point)[1]) <= RESIDUAL_TOLERANCE
    varying: tuple[bool, ...] | None = None
    if np.sum(open_pair & ~active) <= ENUMERATION_LIMIT:
        # Every solution near this one lies in a cone that also holds this one.
        supports = _between(active, active | open_pair)
        beside = (faces[s.tobytes()] if faces else _cone_face(scaled, s) for s in supports)
        moving = np.any([face[1] for face in beside if face is not None], axis=0)
        varying = tuple(bool(flag) for flag in np.broadcast_to(moving, z.shape))
    return LCPSolution(z, w, residual(lcp, z), tuple(bool(flag) for flag in active), varying)


def principal_block(matrix: FloatArray, index: npt.NDArray[np.intp]) -> FloatArray:
    """Return the principal block of `index`."""
    return matrix[np.ix_(index, index)]
