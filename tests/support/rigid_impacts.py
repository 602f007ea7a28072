"""Numbers of impacts of one body with several contacts: rows, mobility, energy."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

unit = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.01, 1))
"""Coefficients of restitution, their borders among them."""


def mobility(rows: np.ndarray, masses: np.ndarray) -> np.ndarray:
    return rows @ np.diag(1 / masses) @ rows.T


def body_rows(points: list[tuple[float, float]], walls: list[bool]) -> np.ndarray:
    """Rows of one body whose points touch the floor, or a wall to their left."""
    rows = []
    for (x, y), wall in zip(points, walls, strict=True):
        along = np.array([1.0, 0.0, -y]), np.array([0.0, 1.0, x])
        rows += along if wall else along[::-1]
    return np.array(rows)


def energy(W: np.ndarray, v: np.ndarray) -> float:
    return float(v @ np.linalg.pinv(W, rcond=1e-10) @ v) / 2
