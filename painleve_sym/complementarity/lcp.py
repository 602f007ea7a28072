"""Linear complementarity problems: every solution, Lemke's pivots, and a check of each answer.

An LCP asks for ``z`` with ``w = M z + q``, ``z >= 0``, ``w >= 0`` and ``z_i w_i = 0`` for every i.
It may have one solution, several, a continuum or none, and each of these is a result here, not an
exception: the paradox of a rod on rough ground is exactly an LCP that has none or two.

References
----------
Cottle, Pang & Stone (1992), The Linear Complementarity Problem. Academic Press ("CPS" below).
Lemke (1965), Bimatrix equilibrium points and mathematical programming. Manag. Sci. 11, 681-689.
Hadeler (1983), On copositive matrices. Linear Algebra Appl. 49, 79-89.
"""

from __future__ import annotations

import enum
import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from painleve_sym.errors import InputError

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

ENUMERATION_LIMIT = 14  # 2**14 cones take a few seconds, and each further pair doubles that
RESIDUAL_TOLERANCE = 1e-10  # a stable solve leaves some 1e-15; a wrong sign leaves order one
_RANK = 1e-14  # per row, on entries scaled to order one: some 50 roundings
_NOISE = 1e-13  # of the largest entry: what a solve may leave of a zero, on scaled entries
_FACE = 1e-10  # widths and defects of a face, on quantities scaled to order one; HiGHS' best
_EXTENT = 1e-8  # of a face, above what those defects can feign
_PIVOT = 1e-11  # smaller entries of a scaled tableau are what elimination left of a zero
_TIE = 1e-12  # ratios closer than this are equal; the lexicographic rule then decides
_MINOR = 1e-13  # a determinant below this part of Hadamard's bound has no certain sign


@dataclass(frozen=True, eq=False)
class LCP:
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
class LCPSolution:
    """Hold one verified solution.

    Attributes
    ----------
    z, w : ndarray, shape (n,)
        The solution and ``w = M z + q`` as computed, rounding included. Read-only.
    residual : float
        `residual` of z; dimensionless.
    active : tuple of bool
        Where ``z_i > 0``, so that ``w_i = 0``.
    varying : tuple of bool, or None
        Which z_i change along the ray, segment or wider set of solutions through this one. None
        where more than `ENUMERATION_LIMIT` pairs are zero on both sides, too many to try.
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


class LemkeStatus(enum.Enum):
    """Say how Lemke's method ended; `advice` tells what that means and what to change."""

    SOLVED = ("solved", "the solution has been checked; solve_all tells whether there are others")
    RAY = (
        "ray",
        "the pivots ended on an unbounded ray. For a copositive-plus matrix the problem has no "
        "feasible point, for a P-matrix this cannot happen; for any other matrix a solution may "
        "still exist: ask solve_all",
    )
    STEP_LIMIT = ("step_limit", "max_pivots was used up; raise max_pivots or ask solve_all")
    NOT_VERIFIED = (
        "not_verified",
        "the last basis is too ill-conditioned: its solution fails the residual check; rescale "
        "the data or ask solve_all",
    )

    def __init__(self, label: str, advice: str) -> None:
        self.label = label
        self.advice = advice


@dataclass(frozen=True, eq=False)
class LemkeResult:
    """Report one run of Lemke's method: its end, the solution if there is one, the pivots used."""

    status: LemkeStatus
    solution: LCPSolution | None
    pivots: int


def residual(lcp: LCP, z: npt.ArrayLike) -> float:
    """Measure how far z is from solving the problem, free of units.

    The largest of ``-z_i`` and ``-w_i`` where negative and of ``min(|z_i|, |w_i|)``, each as a
    fraction of its own scale. That of w_i is the sum of its terms, ``|q_i| + sum_j |M_ij z_j|``;
    z_j is measured by the largest share it has in any of these sums. Positive scaling of rows or
    columns therefore changes nothing, and rounding alone leaves some 1e-15.

    Parameters
    ----------
    lcp : LCP
        The problem.
    z : array_like, shape (n,)
        The candidate; entries that are not finite give ``inf``.

    Returns
    -------
    float
        0 for an exact solution, up to 1 otherwise, ``inf`` for an infinite or nan entry.

    Raises
    ------
    InputError
        For a candidate of another length. Fix: give one entry for each pair.
    """
    point = np.asarray(z, dtype=float)
    if point.shape != lcp.offset.shape:
        raise InputError(
            f"residual cannot be measured, z: got shape {point.shape}, need {lcp.offset.shape}. "
            "Fix: give one entry for each complementary pair."
        )
    if not np.all(np.isfinite(point)):
        return float("inf")
    share, w = _shares(lcp, point)
    wrong = np.maximum(np.where(point < 0, share, 0.0), np.where(w < 0, -w, 0.0))
    return float(np.max(np.maximum(wrong, np.minimum(share, np.abs(w)))))


def solve_all(lcp: LCP, tol: float = RESIDUAL_TOLERANCE) -> tuple[LCPSolution, ...]:
    """Find every solution by trying each choice of ``z_i = 0`` or ``w_i = 0``.

    For each set S of active pairs, ``M_SS z_S = -q_S`` is solved with all other ``z_i = 0`` (a
    complementary cone, CPS section 1.3). Where M_SS is singular, the solutions in that cone form a
    point, segment, ray or wider face; one representative of it is returned, inside the face where
    it has an inside, and marked as not isolated unless the face is a point.

    Parameters
    ----------
    lcp : LCP
        The problem, with at most `ENUMERATION_LIMIT` pairs.
    tol : float
        Largest `residual` of a solution, and the distance in the same measure below which two
        solutions are one.

    Returns
    -------
    tuple of LCPSolution
        Ordered by the number of active pairs; empty when the problem has no solution.

    Raises
    ------
    InputError
        For too many pairs. Fix: use `solve_lemke`, which returns one solution.
    """
    if lcp.size > ENUMERATION_LIMIT:
        raise InputError(
            f"solve_all cannot try 2**n cones: got n = {lcp.size}, need n <= {ENUMERATION_LIMIT}. "
            "Fix: call solve_lemke for one solution."
        )
    scaled, unit = equilibrate(lcp)
    found: list[FloatArray] = []
    for support in _between(np.zeros(lcp.size, bool), np.ones(lcp.size, bool)):
        face = _cone_face(scaled, support)
        point = None if face is None else _cleaned(scaled, face[0], tol)
        if point is not None and not any(_same(scaled, point, other, tol) for other in found):
            found.append(point)
    return tuple(_solution(lcp, scaled, unit, point) for point in found)


def solve_lemke(
    lcp: LCP, max_pivots: int | None = None, tol: float = RESIDUAL_TOLERANCE
) -> LemkeResult:
    """Find one solution by complementary pivots (Lemke 1965; CPS section 4.4).

    ``w = M z + d z_0 + q`` with d of ones starts from a z_0 that makes all w >= 0 and pivots until
    z_0 leaves. Ties are broken lexicographically, so that no basis returns (CPS section 4.9). The
    solution is computed afresh from the last basis and checked, never read off the tableau.

    Parameters
    ----------
    lcp : LCP
        The problem, of any size.
    max_pivots : int, optional
        Most pivots; 50 per pair when not given, far above the few per pair that are usual.
    tol : float
        Largest `residual` of a solution.

    Returns
    -------
    LemkeResult
        With `solution` None unless the status is SOLVED.
    """
    n = lcp.size
    scaled, unit = equilibrate(lcp)
    limit = 50 * n if max_pivots is None else max_pivots
    if np.all(scaled.offset >= 0):
        return LemkeResult(LemkeStatus.SOLVED, _solution(lcp, scaled, unit, np.zeros(n)), 0)
    # Columns 0..n-1 belong to w, n..2n-1 to z, 2n to z_0; the last holds the values.
    table = np.column_stack([np.eye(n), -scaled.matrix, -np.ones(n), scaled.offset])
    basis = np.arange(n)
    row = _lexicographic_row(table, np.ones(n), np.arange(n), basis)
    entering = 2 * n
    for pivots in range(1, limit + 1):
        leaving, basis[row] = int(basis[row]), entering
        table[row] /= table[row, entering]
        others = np.arange(n) != row
        table[others] -= np.outer(table[others, entering], table[row])
        if leaving == 2 * n:
            point = _cleaned(scaled, _basis_point(scaled, basis[basis >= n] - n), tol)
            if point is None:
                return LemkeResult(LemkeStatus.NOT_VERIFIED, None, pivots)
            return LemkeResult(LemkeStatus.SOLVED, _solution(lcp, scaled, unit, point), pivots)
        entering = leaving + n if leaving < n else leaving - n
        rows = np.flatnonzero(table[:, entering] > _PIVOT)
        if rows.size == 0:
            return LemkeResult(LemkeStatus.RAY, None, pivots)
        row = _lexicographic_row(table, table[:, entering], rows, basis)
    return LemkeResult(LemkeStatus.STEP_LIMIT, None, limit)


def is_p_matrix(matrix: npt.ArrayLike) -> bool:
    """Tell whether every principal minor is positive.

    Exactly then the LCP has one and only one solution for every offset (CPS theorem 3.3.7), and
    Lemke's method finds it. All ``2**n - 1`` minors are computed; one within rounding of zero
    counts as not positive.

    Raises
    ------
    InputError
        As for `LCP`, and for n above `ENUMERATION_LIMIT`. Fix: test a smaller block.
    """
    scaled, _ = equilibrate(_square("is_p_matrix", matrix))
    return all(_sign(_block(scaled.matrix, index)) > 0 for index in _subsets(scaled.size))


def is_copositive(matrix: npt.ArrayLike, strict: bool = False) -> bool:
    """Tell whether ``x'Mx >= 0`` for every ``x >= 0``; with `strict`, > 0 for every such x != 0.

    By Hadeler (1983): a symmetric matrix whose smaller principal blocks all pass fails if and only
    if ``det < 0`` and ``adj >= 0`` (strict: ``det <= 0`` and ``adj > 0``). The symmetric part is
    taken first. With a strictly copositive M, Lemke's method solves the LCP for every offset (CPS
    section 4.4); with a copositive one, for each q with ``q'v >= 0`` for all solutions v of the
    homogeneous problem. Neither promises that the solution is the only one.

    Raises
    ------
    InputError
        As for `LCP`, and for n above `ENUMERATION_LIMIT`. Fix: test a smaller block.
    """
    full = _square("is_copositive", matrix).matrix
    symmetric = (full + full.T) / 2
    for index in _subsets(full.shape[0]):
        block = _block(symmetric, index)
        if _sign(block) < (1 if strict else 0):
            signs = [_cofactor_sign(block, i, j) for i, j in np.ndindex(block.shape)]
            if min(signs) >= (1 if strict else 0):
                return False
    return True


def equilibrate(lcp: LCP) -> tuple[LCP, FloatArray]:
    """Scale rows, columns and offset to order one by powers of two, which rounds nothing.

    Returns
    -------
    scaled : LCP
        The problem with the same signs and the same sets of active pairs.
    unit : ndarray, shape (n,)
        A solution z' of `scaled` is the solution ``unit * z'`` of `lcp`.
    """
    row = _power_of_two(np.max(np.abs(lcp.matrix), axis=1))
    matrix = lcp.matrix / row[:, None]
    column = _power_of_two(np.max(np.abs(matrix), axis=0))
    offset = lcp.offset / row
    size = _power_of_two(np.max(np.abs(offset), keepdims=True))
    return LCP(matrix / column, offset / size), size / column


def _numbers(name: str, value: npt.ArrayLike, faults: list[str]) -> FloatArray:
    """Return a float copy; note in `faults` what is no real, finite number."""
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


def _shares(lcp: LCP, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the largest share of each z_j in any row, and each w_i by its row's scale."""
    terms = np.abs(lcp.matrix * z)
    scale = np.abs(lcp.offset) + terms.sum(axis=1)
    inverse = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0)
    share = np.max(terms * inverse[:, None], axis=0)
    # A column of zeros has no share anywhere; its entry still counts as a whole.
    share[np.all(lcp.matrix == 0, axis=0) & (z != 0)] = 1.0
    return share, (lcp.matrix @ z + lcp.offset) * inverse


def _same(lcp: LCP, a: FloatArray, b: FloatArray, tol: float) -> bool:
    """Tell whether the step from a to b is negligible in every row."""
    both = np.maximum(np.abs(a), np.abs(b))
    scale = np.abs(lcp.offset) + np.abs(lcp.matrix) @ both
    idle = np.all(lcp.matrix == 0, axis=0)
    return bool(
        np.all(np.abs(lcp.matrix * (a - b)) <= tol * scale[:, None])
        and np.all(np.abs(a - b)[idle] <= tol * both[idle])
    )


def _cleaned(lcp: LCP, z: FloatArray, tol: float) -> FloatArray | None:
    """Return z with negligible entries set to zero, or None if that is no solution."""
    negligible = _shares(lcp, z)[0] <= tol
    # What a solve leaves of an exact zero may be all there is in a row; so try without it, too.
    for noise in (0.0, _NOISE * float(np.max(np.abs(z)))):
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


def _basis_point(lcp: LCP, index: npt.NDArray[np.intp]) -> FloatArray:
    """Return z with ``w = 0`` in the rows of `index` (least squares where these are singular)."""
    z = np.zeros(lcp.size)
    if index.size:
        z[index] = np.linalg.lstsq(_block(lcp.matrix, index), -lcp.offset[index], rcond=None)[0]
    return z


def _cone_face(lcp: LCP, support: BoolArray) -> tuple[FloatArray, BoolArray] | None:
    """Return a point of one complementary cone's solutions and which entries vary along them."""
    index = np.flatnonzero(support)
    fixed = np.zeros(lcp.size, bool)
    z = np.zeros(lcp.size)
    if index.size == 0:
        return z, fixed
    block, goal = _block(lcp.matrix, index), -lcp.offset[index]
    left, stretch, right = np.linalg.svd(block)
    rank = int(np.sum(stretch > _RANK * lcp.size))
    if rank == index.size:
        z[index] = np.linalg.solve(block, goal)
        return z, fixed
    if np.any(np.abs(left[:, rank:].T @ goal) > _FACE * np.max(np.abs(goal))):
        return None
    z[index] = right[:rank].T @ (left[:, :rank].T @ goal / stretch[:rank])
    null = np.zeros((lcp.size, index.size - rank))
    null[index] = right[rank:].T
    # On this face z = start + null t, and each entry of z (or w, off the support) is >= 0.
    slope = np.where(support[:, None], null, lcp.matrix @ null)
    start = np.where(support, z, lcp.matrix @ z + lcp.offset)
    inside = _interval(slope[:, 0], start) if null.shape[1] == 1 else _polytope(slope, start)
    if inside is None:
        return None
    t, ways = inside
    return z + null @ t, np.any(np.abs(null @ ways) > _EXTENT, axis=1)


def _interval(slope: FloatArray, start: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Return a middle point of ``{t : start + slope t >= 0}`` and, as columns, its extent."""
    up, down = slope > _FACE, slope < -_FACE
    level = ~up & ~down
    low = float(np.max(-start[up] / slope[up], initial=-np.inf))
    high = float(np.min(-start[down] / slope[down], initial=np.inf))
    slack = _FACE * (1.0 + float(np.max(np.abs(start))))
    if np.any(start[level] < -slack) or low > high + slack:
        return None
    if np.isinf(low) or np.isinf(high):
        # A half line (z >= 0 forbids a whole one): one scaled unit away from its end.
        return np.array([low + 1.0 if np.isinf(high) else high - 1.0]), np.ones((1, 1))
    return np.array([(low + high) / 2]), np.array([[max(high - low, 0.0)]])


def _polytope(slope: FloatArray, start: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Do the same for several unknowns t, by linear programs."""
    from scipy.optimize import linprog  # needed for doubly singular blocks only

    count = slope.shape[1]
    slack = _FACE * (1.0 + float(np.max(np.abs(start))))
    # Rows without slope restrict no t; kept, they would only hide the inside of the face.
    level = np.all(np.abs(slope) <= _FACE, axis=1)
    if np.any(start[level] < -slack):
        return None
    slope, start = slope[~level], start[~level]
    tight = {"primal_feasibility_tolerance": _FACE, "dual_feasibility_tolerance": _FACE}
    # Deepest point: the largest common margin, at most one scaled unit.
    deepest = linprog(
        np.append(np.zeros(count), -1.0),
        A_ub=np.column_stack([-slope, np.ones(start.size)]),
        b_ub=start,
        bounds=[(None, None)] * count + [(None, 1.0)],
        options=tight,
    )
    if deepest.x is None or deepest.x[-1] < -slack:
        return None
    t = np.asarray(deepest.x[:-1], dtype=float)
    if deepest.x[-1] > slack:
        return t, np.eye(count)
    # A face without inside may still be a segment or ray: go one unit along each t both ways.
    ends = np.tile(t, (2 * count, 1))
    box = [(value - 1.0, value + 1.0) for value in t]
    for k, (axis, sign) in enumerate(itertools.product(range(count), (1.0, -1.0))):
        goal = np.where(np.arange(count) == axis, sign, 0.0)
        end = linprog(goal, A_ub=-slope, b_ub=start + slack, bounds=box, options=tight)
        ends[k] = t if end.x is None else end.x
    middle = ends.mean(axis=0)
    return middle, (ends - middle).T


def _solution(lcp: LCP, scaled: LCP, unit: FloatArray, point: FloatArray) -> LCPSolution:
    """Return the solution in the units of `lcp`, with what varies around it."""
    z = unit * point
    w = lcp.matrix @ z + lcp.offset
    z.setflags(write=False)
    w.setflags(write=False)
    active = point > 0
    open_pair = np.abs(_shares(scaled, point)[1]) <= RESIDUAL_TOLERANCE
    varying: tuple[bool, ...] | None = None
    if np.sum(open_pair & ~active) <= ENUMERATION_LIMIT:
        # Every solution near this one lies in a cone that also holds this one.
        faces = (_cone_face(scaled, support) for support in _between(active, active | open_pair))
        moving = np.any([face[1] for face in faces if face is not None], axis=0)
        varying = tuple(bool(flag) for flag in np.broadcast_to(moving, z.shape))
    return LCPSolution(z, w, residual(lcp, z), tuple(bool(flag) for flag in active), varying)


def _lexicographic_row(
    table: FloatArray, column: FloatArray, rows: npt.NDArray[np.intp], basis: npt.NDArray[np.intp]
) -> int:
    """Return the row whose values, then inverse-basis entries, by the pivot come first in order."""
    n = table.shape[0]
    for key in (-1, *range(n)):
        ratio = table[rows, key] / column[rows]
        rows = rows[ratio <= ratio.min() + _TIE * max(1.0, abs(ratio.min()))]
        if key == -1 and np.any(basis[rows] == 2 * n):
            return int(rows[basis[rows] == 2 * n][0])  # z_0 may leave: that is a solution
        if rows.size == 1:
            break
    return int(rows[0])


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


def _block(matrix: FloatArray, index: npt.NDArray[np.intp]) -> FloatArray:
    """Return the principal block of `index`."""
    return matrix[np.ix_(index, index)]


def _sign(matrix: FloatArray) -> int:
    """Return the sign of the determinant, 0 where rounding hides it."""
    if matrix.size == 0:
        return 1
    bound = float(np.prod(np.linalg.norm(matrix, axis=1)))
    det = float(np.linalg.det(matrix))
    return 0 if abs(det) <= _MINOR * bound else int(np.sign(det))


def _cofactor_sign(matrix: FloatArray, i: int, j: int) -> int:
    """Return the sign of one entry of the adjugate of a symmetric matrix."""
    minor = np.delete(np.delete(matrix, i, axis=0), j, axis=1)
    return _sign(minor) if (i + j) % 2 == 0 else -_sign(minor)
