"""Zeros of functions of two variables: curves from a grid, common zeros to round-off."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array

Function = Callable[[Array, Array], Array]
SharedCurve = tuple[float | None, float | None]

HALVINGS = 60
"""More than the bits of a number: each end lies on its curve to round-off."""
NEWTON_STEPS = 40
SETTLED = 1e-12
"""Last Newton step of a zero, as part of the range; the step after it is below round-off."""
DISTINCT = 1e-7
"""Zeros nearer than this part of the range are one zero, seen from two cells."""
PARALLEL = 1e-8
"""Sine of the angle between gradients, in parts of the ranges, below which curves do not cross."""
ON_CURVE = 1e-9
"""Distance, in parts of the ranges, from a zero that counts as none."""
TANGENT = 1e-3
"""Step along a curve, in parts of the ranges, after which curves that only touch are apart."""
ALONG = 101
"""Points at which a line is looked at: more than a formula has zeros there by chance."""
JUMP = 1e-6
"""Part of the values around it that a function is smaller than where it is 0, and does not jump."""


def zero_segments(function: Function, x: Array, y: Array, values: Array) -> Array:
    """Return the curve function = 0 as straight pieces, shape (n, 2 ends, 2).

    One piece for each cell of the grid that the curve crosses. Both its ends are zeros on the
    cell's sides, located by bisection; a curve that enters and leaves through one side is missed.
    The grid is increasing, shape (n_x,) and (n_y,); `values` are those of the function on it, shape
    (n_x, n_y), nan where it is not defined. The function takes points (x, y), each of shape (k,).
    """
    along_x, along_y = _zeros_on_sides(function, x, y, values)
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


def _zeros_on_sides(function: Function, x: Array, y: Array, values: Array) -> tuple[Array, Array]:
    """Return the zeros between neighbours along x and along y, nan where no sign changes."""
    changes, ends = [], []
    for step in ((1, 0), (0, 1)):
        here, there = values[: len(x) - step[0], : len(y) - step[1]], values[step[0] :, step[1] :]
        changes.append(np.isfinite(here) & np.isfinite(there) & ((here > 0) != (there > 0)))
        at = np.array(np.nonzero(changes[-1]))
        ends.append(np.stack([at, at + np.array(step)[:, None]]))
    # Shape (2 ends, 2 axes, number of sides), the end with a value that is not positive first.
    places = np.concatenate(ends, axis=2)
    places = np.where(values[tuple(places[0])] > 0, places[::-1], places)
    largest = abs(np.stack([values[tuple(end)] for end in places])).max(axis=0)
    low, high = (np.stack([x[end[0]], y[end[1]]]) for end in places)
    if low.size:
        for _ in range(HALVINGS):
            middle = (low + high) / 2
            up = function(middle[0], middle[1]) > 0
            low, high = np.where(up, low, middle), np.where(up, middle, high)
        # At a pole or a jump the sign changes too.
        low[:, ~(np.abs(function(low[0], low[1])) <= JUMP * largest)] = np.nan
    zeros = [np.full((*change.shape, 2), np.nan) for change in changes]
    parts = np.split(low.T, [len(ends[0][0, 0])])
    for side, change, part in zip(zeros, changes, parts, strict=True):
        side[change] = part
    return zeros[0], zeros[1]


def common_zeros(
    system: Function, x: Array, y: Array, first: Array, second: Array
) -> tuple[Array, list[SharedCurve]]:
    """Return the common zeros of two functions in the grid's rectangle: points, and shared curves.

    Newton's method from every cell that both curves come near. The points, shape (n, 2) and sorted
    by x, then y, are crossings: curves that touch without crossing are left out. Functions with a
    common factor vanish together along a curve, which is returned as the line (x, None) or
    (None, y), or by one of its points. The system returns f, g, f_x, f_y, g_x, g_y at points,
    shape (6, k); `first` and `second` are f and g on the grid, as for `zero_segments`.
    """
    low, span = np.array([[x[0]], [y[0]]]), np.array([[x[-1] - x[0]], [y[-1] - y[0]]])

    def scaled(part: Array) -> Array:
        place = low + span * part
        rows = system(place[0], place[1]).copy()
        rows[2::2] *= span[0]
        rows[3::2] *= span[1]
        return rows

    i, j = np.nonzero(_near_zero(first) & _near_zero(second))
    point = (np.stack([(x[i] + x[i + 1]) / 2, (y[j] + y[j + 1]) / 2]) - low) / span
    step, parallel = np.full_like(point, np.inf), np.zeros(len(i), bool)
    with np.errstate(all="ignore"):
        for _ in range(NEWTON_STEPS):
            f, g, f_x, f_y, g_x, g_y = scaled(point)
            determinant = f_x * g_y - f_y * g_x
            parallel = ~(abs(determinant) > PARALLEL * np.hypot(f_x, f_y) * np.hypot(g_x, g_y))
            step = np.stack([f * g_y - g * f_y, g * f_x - f * g_x]) / determinant
            # Far steps leave the curves they were started from.
            point = point - np.clip(step, -1 / 4, 1 / 4)
        zero = (np.abs(step) <= SETTLED).all(axis=0)
        zero &= ((point >= -SETTLED) & (point <= 1 + SETTLED)).all(axis=0)
        shared = _shared_curves(scaled, point[:, zero & parallel])

    def back(part: float | None, axis: int) -> float | None:
        return None if part is None else float(low[axis, 0] + span[axis, 0] * part)

    curves = [(back(a, 0), back(b, 1)) for a, b in shared]
    return (low + span * _distinct(point[:, zero & ~parallel])).T, curves


def _shared_curves(scaled: Callable[[Array], Array], zeros: Array) -> list[SharedCurve]:
    """Return the curves through common zeros, shape (2, n), on which both functions vanish."""
    curves: list[SharedCurve] = []
    along = np.linspace(0, 1, ALONG)
    for axis in (0, 1):
        values = np.sort(zeros[axis])
        for near in np.split(values, np.flatnonzero(np.diff(values) > DISTINCT) + 1):
            # A line has zeros in several cells.
            if len(near) < 2:
                continue
            line = np.stack([np.full(ALONG, np.median(near)), along])
            rows = scaled(line if axis == 0 else line[::-1])
            if (_vanish(rows) | np.isnan(rows).any(axis=0)).all():
                value = float(np.median(near))
                curves.append((value, None) if axis == 0 else (None, value))
                zeros = zeros[:, abs(zeros[axis] - value) > DISTINCT]
    # Along the tangent, and back to f = 0: there g is 0 too on a shared curve alone.
    _, _, f_x, f_y, *_ = scaled(zeros)
    point = zeros + TANGENT * np.stack([-f_y, f_x]) / np.hypot(f_x, f_y)
    for _ in range(4):
        f, _, f_x, f_y, *_ = scaled(point)
        point = point - f * np.stack([f_x, f_y]) / (f_x**2 + f_y**2)
    on = zeros[:, _vanish(scaled(point))].T.tolist()
    return [*curves, *((a, b) for a, b in sorted(on)[:1])]


def _vanish(rows: Array) -> Any:
    """Return whether zeros of both functions are near, by values and slopes."""
    f, g, f_x, f_y, g_x, g_y = rows
    return np.logical_and(
        abs(f) <= ON_CURVE * np.hypot(f_x, f_y), abs(g) <= ON_CURVE * np.hypot(g_x, g_y)
    )


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


def _distinct(points: Array) -> Array:
    """Return the points, shape (2, n), without repetitions and sorted."""
    kept: list[Array] = []
    for point in points.T:
        if all(np.max(np.abs(point - other)) > DISTINCT for other in kept):
            kept.append(point)
    kept.sort(key=tuple)
    return np.array(kept).reshape(-1, 2).T
