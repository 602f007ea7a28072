"""Convex sets of forces: a point inside, the shortest point, and directions of their extent.

A set is ``{x : x = x_0 + N y, rows x + start >= 0, |x_t| <= mu x_n for discs}``. Discs are cut by
tangent half spaces where they are met. All quantities are scaled to order one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from painleve_sym.problem.complementarity.solution_sets import FloatArray

_SLOPE = 1e-10  # of a row of order one: it does not depend on y
_SLACK = 1e-10  # of the size of the levels: what an inequality may miss
_MARGINS = (0.1, 1e-3, 1e-6)  # of the size of the levels: a point is inside by so much
_DUAL = 1e-9  # of the largest multiplier: the inequality is one of a contradiction
_LEVEL_ROUNDING = 1e-12  # of the base: levels that are zero but for rounding
_FAR = 1e-12  # 1/(1 + |y|²) of the shortest y: none, but for rounding
_CUTS = 60  # of a disc; each more than halves the angle that is left


class Cone(NamedTuple):
    """A disc of friction within x: ``|x[tangents]| <= mu * (normal . x)``.

    Attributes
    ----------
    normal : ndarray, shape (k,)
        F_n by x, with the sign of its side.
    tangents : ndarray, shape (2, k)
        The two friction forces by x.
    mu : float
    """

    normal: FloatArray
    tangents: FloatArray
    mu: float

    def _way(self, x: FloatArray) -> FloatArray:
        friction: FloatArray = self.tangents @ x
        size = float(np.linalg.norm(friction))
        return friction / size if size > 0 else np.array([1.0, 0.0])

    def cut(self, x: FloatArray) -> FloatArray:
        """Return the half space that touches the disc along the friction of x."""
        row: FloatArray = self.mu * self.normal - self._way(x) @ self.tangents
        return row / max(1.0, self.mu)

    def edge(self, x: FloatArray) -> FloatArray:
        """Return the equations of friction at its limit along that of x, shape (2, k)."""
        rows: FloatArray = self.tangents - self.mu * np.outer(self._way(x), self.normal)
        return rows / max(1.0, self.mu)

    def excess(self, x: FloatArray) -> float:
        """Return by how much the friction of x exceeds the disc."""
        size = float(np.linalg.norm(self.tangents @ x))
        return (size - self.mu * float(self.normal @ x)) / max(1.0, self.mu)


class Face(NamedTuple):
    """A set of forces that is not empty.

    Attributes
    ----------
    point : ndarray, shape (k,)
        Its shortest vector, or one well inside.
    span : ndarray, shape (k, d)
        The directions in which it extends, orthonormal.
    """

    point: FloatArray
    span: FloatArray


class _End(NamedTuple):
    """End of a search for a point inside by a margin; nothing where the set is empty.

    Attributes
    ----------
    point : ndarray or None
    equations : (ndarray, ndarray) or None
        ``rows x + start = 0`` holds on all of the set.
    touched : Cone or None
        The disc that all of the set touches, where the equations are those of its edge.
    """

    point: FloatArray | None = None
    equations: tuple[FloatArray, FloatArray] | None = None
    touched: Cone | None = None


class ForceSet:
    """``x = base + null y`` with linear inequalities and discs.

    Parameters
    ----------
    base : ndarray, shape (k,)
    null : ndarray, shape (k, d)
        Orthonormal columns.
    rows : ndarray, shape (m, k)
    start : ndarray, shape (m,)
    cones : sequence of Cone
        With them F_n >= 0 of each.
    """

    def __init__(
        self,
        base: FloatArray,
        null: FloatArray,
        rows: FloatArray,
        start: FloatArray,
        cones: Sequence[Cone] = (),
    ) -> None:
        self.base, self.null, self.cones = base, null, tuple(cones)
        self.rows = np.vstack([rows, *(cone.normal[None] for cone in cones)])
        self.start = np.append(start, np.zeros(len(cones)))

    def shortest(self) -> Face | None:
        """Return the set with its shortest vector, None where it is empty."""
        face = self.inside()
        if face is None or not face.span.shape[1]:
            return face
        self.base = face.point - face.span @ (face.span.T @ face.point)
        self.null = face.span
        point = self._nearest(0.0).point
        return face if point is None else Face(point, face.span)

    def inside(self) -> Face | None:
        """Return the set with a vector well inside of it, None where it is empty.

        Inequalities that hold as equations on all of the set take away directions until the rest
        has an inside.
        """
        while self.null.shape[1]:
            self.base = self.base - self.null @ (self.null.T @ self.base)
            for margin in _MARGINS:
                end = self._nearest(margin * self._size())
                if end.point is not None:
                    return Face(end.point, self.null)
                if end.equations is None:
                    return None
                rows, start = end.equations
                if end.touched is not None:
                    self.cones = tuple(c for c in self.cones if c is not end.touched)
                    break
            slope, level = rows @ self.null, rows @ self.base + start
            self.base = self.base - self.null @ np.linalg.lstsq(slope, level, rcond=_SLOPE)[0]
            self.null = self.null @ _null_space(slope)
        slack = _SLACK * self._size()
        levels = [
            *(self.rows @ self.base + self.start),
            *(-c.excess(self.base) for c in self.cones),
        ]
        return Face(self.base, self.null) if min(levels, default=0.0) >= -slack else None

    def _size(self) -> float:
        """Return the largest level of an inequality; for 0 the size of the base, or 1."""
        level = float(np.abs(self.rows @ self.base + self.start).max(initial=0.0))
        base = float(np.abs(self.base).max(initial=0.0))
        return level if level > _LEVEL_ROUNDING * base else base or 1.0

    def _nearest(self, margin: float) -> _End:
        """Return the point nearest to the base, inside by a margin, or the reason for having none.

        Discs add the rows that touch them.
        """
        least = _SLACK * self._size()
        for _ in range(_CUTS):
            slope, level = self.rows @ self.null, self.rows @ self.base + self.start
            # A row that does not depend on y restricts nothing; kept, it would hide the inside.
            still = np.abs(slope).max(axis=1, initial=0.0) <= _SLOPE
            if (level[still] < -least).any():
                return _End()
            y, dual = nearest(slope[~still], level[~still] - margin)
            if y is None:
                assert dual is not None
                if float(dual @ level[~still]) < -least * float(np.sum(dual)):
                    return _End()
                tight = np.zeros(len(level), dtype=np.bool_)
                tight[~still] = dual > _DUAL * float(np.max(dual))
                return _End(equations=(self.rows[tight], self.start[tight]))
            x = self.base + self.null @ y
            outside = [c for c in self.cones if c.excess(x) + margin > max(least, margin / 2)]
            if not outside:
                return _End(x)
            cuts = 0
            for cone in outside:
                row, excess = cone.cut(x), cone.excess(x)
                if np.max(np.abs(row @ self.null)) > _SLOPE:
                    self.rows = np.vstack([self.rows, row[None]])
                    self.start = np.append(self.start, 0.0)
                    cuts += 1
                elif excess > least:
                    return _End()
                elif excess >= -least:  # the set touches the disc along this friction alone
                    return _End(equations=(cone.edge(x), np.zeros(2)), touched=cone)
            if not cuts:  # as deep inside as the set is anywhere
                return _End(x)
        return _End()


def _size(level: FloatArray) -> float:
    return float(np.abs(level).max(initial=0.0)) or 1.0


def nearest(slope: FloatArray, level: FloatArray) -> tuple[FloatArray | None, FloatArray | None]:
    """Return the shortest y with ``slope y + level >= 0``, or multipliers that prove there is none.

    Lawson & Hanson (1974), chapter 23, algorithm LDP.
    """
    if level.min(initial=0.0) >= 0:
        return np.zeros(slope.shape[1]), None
    from scipy.optimize import nnls  # needed for singular systems only

    goal = np.zeros(slope.shape[1] + 1)
    goal[-1] = 1.0
    size = _size(level)
    dual, _ = nnls(np.vstack([slope.T, -level / size]), goal)
    rest = slope.T @ dual
    scale = 1.0 + float(level @ dual) / size
    rounding = 16 * np.finfo(float).eps * float(np.abs(level) @ dual) / size
    if scale <= _FAR + rounding:
        return None, dual
    y: FloatArray = rest * size / scale
    return y, None


def _null_space(rows: FloatArray) -> FloatArray:
    """Return an orthonormal basis of the vectors that rows of order one map to zero."""
    _, stretch, right = np.linalg.svd(rows)
    rank = int(np.sum(stretch > _SLOPE * max(float(stretch[0]), 1.0)))
    basis: FloatArray = right[rank:].T
    return basis
