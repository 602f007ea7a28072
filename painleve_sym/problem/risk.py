"""The friction from which a mobility W has directions of slip without a unique answer.

With the contact basis (n, t1, t2), or (n, t) in the plane, slip along e(φ) and friction −μ F e(φ),
the normal acceleration is A(φ) F + b_n with A(φ) = W_nn − μ w·e(φ) and w = (W_t1n, W_t2n). So
A < 0 for some φ exactly where μ > μ_P = W_nn/|w|.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from painleve_sym.problem.rounding import FloatArray as Array
from painleve_sym.problem.rounding import rounded_difference

RANK_ONE = 1e-10
"""Of the largest mobility of a block: in a direction with less, by the rounding of W, none."""


def friction_threshold(W: Array) -> Array:
    """Return μ_P = W_nn/|w|, infinite where w = 0.

    Parameters
    ----------
    W : ndarray, shape (3, 3, ...) or (2, 2, ...)
        Mobility with the rows n, t1, t2, or n, t; 1/kg. Further axes are those of an array of
        states.

    Returns
    -------
    ndarray
        Of the shape of the further axes.
    """
    return _threshold(W[0, 0], np.linalg.norm(W[1:, 0], axis=0))


def _threshold(mobility: Array, coupling: Array) -> Array:
    """Return the quotient, infinite where nothing couples, also where nothing moves (0/0)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(coupling == 0, np.inf, mobility / coupling)


def slip_slope(W: Array, mu: float | Array, slip: Sequence[Any], side: int = 1) -> Array:
    """Return A of a_n = A F_n + B in slip along a direction, W_nn − side μ w·e; 1/kg.

    A value within rounding of its two terms is exactly 0: its sign, and with it the case, would be
    an accident.

    Parameters
    ----------
    W : ndarray, shape (m, m, ...)
        Mobility of one contact, its normal row first; 1/kg. Further axes are those of an array of
        states.
    mu : float or ndarray
        Of the shape of the further axes.
    slip : sequence of m - 1 float or ndarray
        The unit vector e along the tangents.
    side : int
        Sign of F_n.

    Returns
    -------
    ndarray
        Of the shape of the further axes.
    """
    coupling = sum(e * w for e, w in zip(slip, W[0, 1:], strict=True))
    return rounded_difference(W[0, 0], side * mu * coupling)


LEAST = 2e-6
"""Thresholds of friction below this are the rounding of 0, that of a singular W."""


def slip_angle(direction: Sequence[float]) -> float:
    """Return the angle of a slip from t1 towards t2, in rad; 0 or π in the plane."""
    first, second = (*direction, 0.0)[:2]
    return math.atan2(second + 0.0, first)  # no -0.0, whose angle would be -pi


def sector_half_angle(mu_P: float, mu: float) -> float:
    """Return half the angle of the sector of slip directions with A < 0; rad, 0 for μ ≤ μ_P."""
    return math.acos(mu_P / mu) if mu > mu_P else 0.0


def least_over_normals(W: Array) -> Array:
    """Return the least μ_P of all surface normals: 2 √(λ_1 λ_3)/(λ_3 − λ_1).

    λ_1 and λ_3 are the least and the largest eigenvalue of W. Infinite where they are equal.

    Parameters
    ----------
    W : ndarray, shape (3, 3, ...) or (2, 2, ...)
        Mobility; 1/kg.

    Returns
    -------
    ndarray
        Of the shape of the further axes.

    References
    ----------
    Wielandt's and Kantorovich's inequality; the angle is Gustafson's of an operator.
    """
    values = np.linalg.eigvalsh(np.moveaxis(W, (0, 1), (-2, -1)))
    low, high = np.maximum(values[..., 0], 0.0), values[..., -1]
    return _threshold(2 * np.sqrt(low) * np.sqrt(high), high - low)


def schur_complement(W: Array, b: Array, rows: int = 3) -> tuple[Array, Array]:
    """Return mobility and free accelerations of the first rows where the others do not accelerate.

    Of a singular block of the others the pseudoinverse is taken: what cannot move holds nothing.

    Parameters
    ----------
    W : ndarray, shape (m, m, ...)
        Such as that of several contacts, which have 3 rows each in space.
    b : ndarray, shape (m, ...)
    rows : int
        How many are in question: 3 for the first contact, 1 for its normal alone.

    Returns
    -------
    tuple of ndarray, shapes (rows, rows, ...) and (rows, ...)
    """
    gain, force = holding_forces(W, b, rows)
    cross = W[:rows, rows:]
    own = W[:rows, :rows] - np.einsum("ir...,rk...->ik...", cross, gain)
    return own, b[:rows] - np.einsum("ir...,r...->i...", cross, force)


def holding_forces(W: Array, b: Array, rows: int = 3) -> tuple[Array, Array]:
    """Return the forces that hold all but the first rows, with the opposite sign.

    Parameters
    ----------
    W, b, rows
        See `schur_complement`.

    Returns
    -------
    tuple of ndarray, shapes (m - rows, rows, ...) and (m - rows, ...)
        Per force of the first rows, and against the free accelerations; N.
    """
    inverse = _pseudoinverse(W[rows:, rows:])
    gain = np.einsum("ij...,jk...->ik...", inverse, W[rows:, :rows])
    return gain, np.einsum("ij...,j...->i...", inverse, b[rows:])


def _pseudoinverse(W: Array) -> Array:
    """Return the Moore–Penrose inverses of symmetric matrices, shape (m, m, ...).

    For one and two rows by formulas: arrays of states have many.
    """
    if len(W) == 1:
        return np.asarray(np.divide(1.0, W, out=np.zeros_like(W), where=W != 0))
    if len(W) == 2:
        trace = W[0, 0] + W[1, 1]
        # Of order one, so that no product of two of them leaves the range of numbers.
        (a, c), (_, d) = unit = np.divide(W, trace, out=np.zeros_like(W), where=trace > 0)
        determinant = a * d - c * c
        regular = determinant > RANK_ONE
        adjugate = np.array([[d, -c], [-c, a]])
        # That of a matrix of rank one and trace one is the matrix.
        inverse = np.where(regular, adjugate / np.where(regular, determinant, 1.0), unit)
        return np.asarray(np.divide(inverse, trace, out=np.zeros_like(W), where=trace > 0))
    last = np.moveaxis(W, (0, 1), (-2, -1))
    inverse = np.linalg.pinv(last, rcond=RANK_ONE, hermitian=True)
    return np.asarray(np.moveaxis(inverse, (-2, -1), (0, 1)))
