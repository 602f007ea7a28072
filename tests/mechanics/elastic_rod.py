"""The elastic rod as many particles on a bar with given shapes: an oracle for `rod-bending`.

Newton's law for each particle, projected on the shapes; frequencies and shapes come from the
characteristic equation and strain energies, by other formulas than the package's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import brentq

from tests.mechanics.newton_euler import Array, cross, turn

POINTS = 80


@cache
def _shapes(bending: int, axial: int) -> tuple[Array, ...]:
    """Return places, weights, shapes (points, modes) and squares of their derivatives' sizes."""
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    s, weights = (nodes + 1) / 2, weights / 2
    ends = np.concatenate([s, [0.0]])
    across, along, stiff, taut = [], [], [], []
    for i in range(1, bending + 1):
        middle = (i + 0.5) * np.pi
        b = brentq(lambda x: np.cos(x) - 1 / np.cosh(x), middle - 0.5, middle + 0.5, xtol=1e-15)
        sigma = (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b))
        x = b * ends
        across.append(np.cosh(x) + np.cos(x) - sigma * (np.sinh(x) + np.sin(x)))
        bent = np.cosh(x) - np.cos(x) - sigma * (np.sinh(x) - np.sin(x))
        stiff.append(b**4 * (weights @ bent[:-1] ** 2))
    for j in range(1, axial + 1):
        along.append(np.sqrt(2) * np.cos(j * np.pi * ends))
        slope = -np.sqrt(2) * j * np.pi * np.sin(j * np.pi * s)
        taut.append(weights @ slope**2)
    shapes = (np.array(m).reshape(-1, POINTS + 1).T for m in (along, across))
    return s, weights, *shapes, np.array(stiff), np.array(taut)


@dataclass
class _Motion:
    """Velocities of the coordinates."""

    q_dot: Array


class ElasticRod:
    """`rod-bending` with numbers for everything; the same questions as `Machine` answers."""

    touches: Sequence[int] = (0,)

    def __init__(self, values: Mapping[str, float]) -> None:
        self.v = values
        names = [n for n in values if n[:2] in ("w_", "u_") and not n.endswith("_dot")]
        counts = [sum(n.startswith(kind) for n in names) for kind in ("w_", "u_")]
        self.s, self.weights, self.along, self.across, stiff, taut = _shapes(*counts)
        m, l, Y, rho = (values[n] for n in ("m", "l", "Y", "rho"))
        area = m / (rho * 2 * l)
        second_moment = area**2 / (4 * np.pi)
        self.stiffness = np.concatenate(
            [Y * second_moment * stiff / (2 * l) ** 3, Y * area * taut / (2 * l)]
        )
        self.w, self.u = (
            np.array([values[n] for n in names if n.startswith(kind)]) for kind in ("w_", "u_")
        )

    def motion(self, q_dot: Array) -> _Motion:
        return _Motion(np.asarray(q_dot, dtype=float))

    def _local(self, along: Array, across: Array) -> Array:
        return np.stack([self.along @ along, self.across @ across], axis=1)

    def _kinematics(self, motion: _Motion) -> tuple[Array, Array]:
        """Return the Jacobians (points + 1, 2, n) and J̇ q̇; the last point is the end A."""
        l, theta = self.v["l"], self.v["theta"]
        place = self._local(self.u, self.w)
        place[:, 0] += 2 * l * np.concatenate([self.s, [0.0]])
        n_w, R = len(self.w), turn(theta)
        n = 3 + n_w + len(self.u)
        J = np.zeros((POINTS + 1, 2, n))
        J[:, 0, 0] = J[:, 1, 1] = 1.0
        J[:, :, 2] = np.array([cross(1.0, R @ p) for p in place])
        J[:, :, 3 : 3 + n_w] = self.across[:, None, :] * R[:, 1][None, :, None]
        J[:, :, 3 + n_w :] = self.along[:, None, :] * R[:, 0][None, :, None]
        omega = motion.q_dot[2]
        speed = self._local(motion.q_dot[3 + n_w :], motion.q_dot[3 : 3 + n_w])
        rest = np.array(
            [
                2 * cross(omega, R @ v) - omega**2 * (R @ p)
                for p, v in zip(place, speed, strict=True)
            ]
        )
        return J, rest

    def accelerations(self, motion: _Motion, contact_forces: Sequence[Sequence[float]]) -> Array:
        J, rest = self._kinematics(motion)
        v = self.v
        masses = v["m"] * self.weights
        pull = np.array([0.0, -v["g"]]) - rest[:-1]
        force = np.einsum("k,kin,ki->n", masses, J[:-1], pull)
        ((f_n, f_t),) = contact_forces
        force += J[-1].T @ np.array([f_t, f_n])
        force[3:] -= self.stiffness * np.concatenate([self.w, self.u])
        force[3:] -= 2 * v["zeta"] * np.sqrt(self.stiffness * v["m"]) * motion.q_dot[3:]
        return np.linalg.solve(np.einsum("k,kin,kim->nm", masses, J[:-1], J[:-1]), force)

    def contact_velocity(self, motion: _Motion, _: int) -> tuple[float, float]:
        v = self._kinematics(motion)[0][-1] @ motion.q_dot
        return float(v[1]), float(v[0])

    def contact_acceleration(
        self, motion: _Motion, _: int, contact_forces: Sequence[Sequence[float]]
    ) -> tuple[float, float]:
        J, rest = self._kinematics(motion)
        a = J[-1] @ self.accelerations(motion, contact_forces) + rest[-1]
        return float(a[1]), float(a[0])
