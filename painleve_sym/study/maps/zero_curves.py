"""Zeros of functions of two variables: curves from a grid, common zeros to round-off."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array

Function = Callable[[Array, Array], Array]

HALVINGS = 60
"""More than the bits of a number: each end lies on its curve to round-off."""
NEWTON_STEPS = 40
SETTLED = 1e-12
"""Last Newton step of a zero, as part of the range; the step after it is below round-off."""
DISTINCT = 1e-7
"""Zeros nearer than this part of the range are one zero, seen from two cells."""


def zero_segments(function: Function, x: Array, y: Array, values: Array) -> Array:
    """Return the curve function = 0 as straight pieces, shape (n, 2 ends, 2).

    One piece for each cell of the grid that the curve crosses. Both its ends are zeros on the
    cell's sides, located by bisection; a curve that enters and leaves through one side is missed.
    The grid is increasing, shape (n_x,) and (n_y,); `values` are those of the function on it, shape
    (n_x, n_y), nan where it is not defined. The function takes points (x, y), each of shape (k,).
    """
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    along_x = _zeros_between(function, grid[:-1], grid[1:], values[:-1], values[1:])
    along_y = _zeros_between(function, grid[:, :-1], grid[:, 1:], values[:, :-1], values[:, 1:])
    # The sides of a cell in turn: of four crossed ones, neighbours are joined.
    turn = (along_x[:, :-1], along_y[1:], along_x[:, 1:], along_y[:-1])
    cells = np.nonzero(np.any([~np.isnan(side[..., 0]) for side in turn], axis=0))
    sides = np.stack([side[cells] for side in turn])
    crossed = ~np.isnan(sides[..., 0])
    order = np.argsort(~crossed, axis=0, kind="stable")
    pieces = []
    for first, count in ((0, 2), (2, 4)):
        chosen = np.flatnonzero(crossed.sum(axis=0) >= count)
        ends = [sides[order[first + k, chosen], chosen] for k in (0, 1)]
        pieces.append(np.stack(ends, axis=1))
    return np.concatenate(pieces)


def _zeros_between(function: Function, a: Array, b: Array, at_a: Array, at_b: Array) -> Array:
    """Return the zero between neighbouring points, nan where the sign does not change."""
    zeros = np.full(a.shape, np.nan)
    change = np.isfinite(at_a) & np.isfinite(at_b) & ((at_a > 0) != (at_b > 0))
    if not change.any():
        return zeros
    above = (at_a > 0)[change][:, None]
    low = np.where(above, b[change], a[change])
    high = np.where(above, a[change], b[change])
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        up = (function(middle[:, 0], middle[:, 1]) > 0)[:, None]
        low, high = np.where(up, low, middle), np.where(up, middle, high)
    # At a pole the sign changes too, but values grow.
    size = np.abs(function(low[:, 0], low[:, 1]))
    largest = np.maximum(np.abs(at_a[change]), np.abs(at_b[change]))
    low[~(size <= largest)] = np.nan
    zeros[change] = low
    return zeros


def common_zeros(system: Function, x: Array, y: Array, first: Array, second: Array) -> Array:
    """Return the points of the grid's rectangle where two functions vanish, shape (n, 2).

    Newton's method from every cell that both curves come near, sorted by x, then y. Curves that
    touch without crossing are left out. The system returns f, g, f_x, f_y, g_x, g_y at points,
    shape (6, k); `first` and `second` are f and g on the grid, as for `zero_segments`.
    """
    i, j = np.nonzero(_near_zero(first) & _near_zero(second))
    point = np.stack([(x[i] + x[i + 1]) / 2, (y[j] + y[j + 1]) / 2])
    low, span = np.array([[x[0]], [y[0]]]), np.array([[x[-1] - x[0]], [y[-1] - y[0]]])
    step = np.full_like(point, np.inf)
    with np.errstate(all="ignore"):
        for _ in range(NEWTON_STEPS):
            f, g, f_x, f_y, g_x, g_y = system(point[0], point[1])
            determinant = f_x * g_y - f_y * g_x
            step = np.stack([f * g_y - g * f_y, g * f_x - f * g_x]) / determinant
            # Far steps leave the curves they were started from.
            point = point - np.clip(step, -span / 4, span / 4)
        settled = (np.abs(step) <= SETTLED * span).all(axis=0)
        part = (point - low) / span
        inside = ((part >= -SETTLED) & (part <= 1 + SETTLED)).all(axis=0)
    return _distinct(point.T[settled & inside], span[:, 0])


def _near_zero(values: Array) -> NDArray[np.bool_]:
    """Return for each cell whether it, or a neighbour, has corners of both signs."""
    corners = np.stack([values[:-1, :-1], values[1:, :-1], values[:-1, 1:], values[1:, 1:]])
    above, below = np.any(corners > 0, axis=0), np.any(corners <= 0, axis=0)
    mixed: NDArray[np.bool_] = np.logical_and(above, below)
    wide = mixed.copy()
    wide[1:] |= mixed[:-1]
    wide[:-1] |= mixed[1:]
    rows = wide.copy()
    wide[:, 1:] |= rows[:, :-1]
    wide[:, :-1] |= rows[:, 1:]
    return wide


def _distinct(points: Array, span: Array) -> Array:
    kept: list[Array] = []
    for point in points:
        if all(np.max(np.abs(point - other) / span) > DISTINCT for other in kept):
            kept.append(point)
    kept.sort(key=tuple)
    return np.array(kept).reshape(-1, 2)
