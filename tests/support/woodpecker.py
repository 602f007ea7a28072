"""The woodpecker toy by hand, from numbers alone: mass matrix, rows and forces."""

from __future__ import annotations

import numpy as np

m_M, m_S, J_M, J_S, c, g = 0.0003, 0.0045, 5e-9, 7e-7, 0.0056, 9.81
r_0, r_M, h_M, l_M, l_G, h_S, l_S = 0.0025, 0.0031, 0.0058, 0.010, 0.015, 0.020, 0.0201
MU = np.full(3, 0.3)
M = np.array(
    [
        [m_S + m_M, m_S * l_M, m_S * l_G],
        [m_S * l_M, J_M + m_S * l_M**2, m_S * l_M * l_G],
        [m_S * l_G, m_S * l_M * l_G, J_S + m_S * l_G**2],
    ]
)
# Normals and tangents of beak, lower and upper edge of the sleeve; coordinates y, a, b.
J = np.array(
    [
        [0, 0, -h_S],
        [1, l_M, l_G - l_S],
        [0, h_M, 0],
        [1, r_M, 0],
        [0, -h_M, 0],
        [1, r_M, 0],
    ]
)
START = np.array([0.0, (r_0 - r_M) / h_M, -0.2788]), np.array([-0.3411, 0.0, -7.4583])


def gaps(q):
    _, a, b = q
    return np.array([l_M + l_G - l_S - r_0 - h_S * b, r_M - r_0 + h_M * a, r_M - r_0 - h_M * a])


def force(q):
    _, a, b = q
    twist = c * (a - b)
    return np.array([-(m_S + m_M) * g, -m_S * l_M * g - twist, -m_S * l_G * g + twist])
