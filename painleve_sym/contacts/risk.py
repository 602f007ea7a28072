"""The friction from which a mobility W has directions of slip without a unique answer.

With the contact basis (n, t1, t2), or (n, t) in the plane, slip along e(φ) and friction −μ F e(φ),
the normal acceleration is A(φ) F + b_n with A(φ) = W_nn − μ w·e(φ) and w = (W_t1n, W_t2n). So
A < 0 for some φ exactly where μ > μ_P = W_nn/|w|.
"""

from __future__ import annotations

import math

import numpy as np

from painleve_sym.arrays import Array


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
    with np.errstate(divide="ignore"):
        return np.asarray(W[0, 0] / np.linalg.norm(W[1:, 0], axis=0))


def slip_direction(W: Array) -> float:
    """Return the angle φ from t1 towards t2 of the slip for which A is smallest; rad.

    Parameters
    ----------
    W : ndarray, shape (3, 3) or (2, 2)
        Mobility with the rows n, t1, t2, or n, t; 1/kg.
    """
    first, second = (*W[1:, 0].tolist(), 0.0)[:2]
    return math.atan2(second, first)


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
    with np.errstate(divide="ignore"):
        return np.asarray(2 * np.sqrt(low) * np.sqrt(high) / (high - low))


def worst_normal(W: Array) -> Array:
    """Return a normal for which μ_P is that of `least_over_normals`.

    Parameters
    ----------
    W : ndarray, shape (3, 3)
        Mobility; 1/kg.

    Returns
    -------
    ndarray, shape (3,)
        Unit vector in the basis of W.
    """
    values, vectors = np.linalg.eigh(W)
    low, high = max(float(values[0]), 0.0), float(values[2])
    # At the least the angle between n and W n is the largest: n weighs both with the other's root.
    first, last = math.sqrt(high / (low + high)), math.sqrt(low / (low + high))
    return np.asarray(first * vectors[:, 0] + last * vectors[:, 2])


def held(W: Array, rows: list[int], others: list[int]) -> Array:
    """Return the mobility of some rows where the accelerations of the others are held at 0.

    It is the Schur complement; directions in which the others cannot move hold nothing.

    Parameters
    ----------
    W : ndarray, shape (m, m, ...)
    rows, others : list of int
    """
    whole = np.moveaxis(W, (0, 1), (-2, -1))
    own, cross = whole[..., rows, :][..., rows], whole[..., rows, :][..., others]
    inner = whole[..., others, :][..., others]
    left = own - cross @ np.linalg.pinv(inner, rcond=1e-10, hermitian=True) @ np.swapaxes(
        cross, -1, -2
    )
    return np.moveaxis(left, (-2, -1), (0, 1))
