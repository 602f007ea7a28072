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
    with np.errstate(divide="ignore"):
        return np.asarray(2 * np.sqrt(low) * np.sqrt(high) / (high - low))


def held(W: Array, b: Array) -> tuple[Array, Array]:
    """Return mobility and free accelerations of the first contact where the others stick.

    The accelerations of the others are held at 0: Schur complements. Directions in which they
    cannot move hold nothing.

    Parameters
    ----------
    W : ndarray, shape (3 n, 3 n, ...)
    b : ndarray, shape (3 n, ...)

    Returns
    -------
    tuple of ndarray, shapes (3, 3, ...) and (3, ...)
    """
    whole, free = np.moveaxis(W, (0, 1), (-2, -1)), np.moveaxis(b, 0, -1)[..., None]
    cross, inner = whole[..., :3, 3:], whole[..., 3:, 3:]
    gain = cross @ np.linalg.pinv(inner, rcond=1e-10, hermitian=True)
    own = whole[..., :3, :3] - gain @ np.swapaxes(cross, -1, -2)
    rest = (free[..., :3, :] - gain @ free[..., 3:, :])[..., 0]
    return np.moveaxis(own, (-2, -1), (0, 1)), np.moveaxis(rest, -1, 0)
