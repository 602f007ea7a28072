"""Newton and Euler in maximal coordinates: every body by itself, held together by joints.

An oracle for Lagrange's equations that shares nothing with them: three coordinates per body,
joints as constraints, and one linear system for accelerations and joint forces.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
WORLD = -1


def turn(angle: float) -> Array:
    """Return the rotation matrix."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def cross(omega: float, r: Array) -> Array:
    """Return ω × r in the plane."""
    return omega * np.array([-r[1], r[0]])


@dataclass
class Motion:
    """Places (x, y, angle) and velocities of all bodies, shape (n, 3)."""

    place: Array
    speed: Array

    def arm(self, body: int, local: Sequence[float]) -> Array:
        """Return a point of a body relative to its mass centre, in world axes."""
        return turn(self.place[body, 2]) @ np.asarray(local, dtype=float)

    def point(self, body: int, local: Sequence[float]) -> Array:
        """Return where a point of a body is; for WORLD the point itself."""
        if body == WORLD:
            return np.asarray(local, dtype=float)
        return self.place[body, :2] + self.arm(body, local)

    def velocity(self, body: int, local: Sequence[float]) -> Array:
        """Return the velocity of a point of a body."""
        return self.speed[body, :2] + cross(self.speed[body, 2], self.arm(body, local))

    def row(self, body: int, local: Sequence[float], direction: Array) -> Array:
        """Return the row that maps all velocities to that of a point along a direction."""
        r, row = self.arm(body, local), np.zeros(self.place.size)
        row[3 * body : 3 * body + 2] = direction
        row[3 * body + 2] = direction @ np.array([-r[1], r[0]])
        return row

    def centripetal(self, body: int, local: Sequence[float]) -> Array:
        """Return the part −ω² r of the acceleration of a point."""
        return -(self.speed[body, 2] ** 2) * self.arm(body, local)


@dataclass(frozen=True)
class Pin:
    """A revolute joint between points of two bodies, or of a body and the WORLD."""

    first: int
    at_first: Sequence[float]
    second: int
    at_second: Sequence[float]

    def rows(self, motion: Motion) -> list[tuple[Array, float, float]]:
        """Return per direction: the row, its part of the acceleration, the misfit."""
        entries = []
        misfit = motion.point(self.first, self.at_first) - motion.point(self.second, self.at_second)
        for k, direction in enumerate(np.eye(2)):
            row = motion.row(self.first, self.at_first, direction)
            rest = motion.centripetal(self.first, self.at_first)
            if self.second != WORLD:
                row = row - motion.row(self.second, self.at_second, direction)
                rest = rest - motion.centripetal(self.second, self.at_second)
            entries.append((row, float(rest[k]), float(misfit[k])))
        return entries


@dataclass(frozen=True)
class Rail:
    """A body that stays on a level line y = height and may turn."""

    body: int
    height: float

    def rows(self, motion: Motion) -> list[tuple[Array, float, float]]:
        """See `Pin.rows`."""
        row = motion.row(self.body, (0, 0), np.array([0.0, 1.0]))
        return [(row, 0.0, float(motion.place[self.body, 1] - self.height))]


@dataclass(frozen=True)
class NoTurn:
    """A body that does not turn."""

    body: int

    def rows(self, motion: Motion) -> list[tuple[Array, float, float]]:
        """See `Pin.rows`."""
        row = np.zeros(motion.place.size)
        row[3 * self.body + 2] = 1.0
        return [(row, 0.0, float(motion.place[self.body, 2]))]


@dataclass(frozen=True)
class Place:
    """A coordinate: a point of a body along a direction."""

    body: int
    local: Sequence[float]
    direction: Sequence[float]

    def read(self, motion: Motion) -> tuple[Array, float]:
        """Return the row and the rest of its acceleration."""
        d = np.asarray(self.direction, dtype=float)
        return motion.row(self.body, self.local, d), d @ motion.centripetal(self.body, self.local)


@dataclass(frozen=True)
class Angle:
    """A coordinate: the angle of a body."""

    body: int

    def read(self, motion: Motion) -> tuple[Array, float]:
        """Return the row and the rest of its acceleration."""
        row = np.zeros(motion.place.size)
        row[3 * self.body + 2] = 1.0
        return row, 0.0


@dataclass(frozen=True)
class Touch:
    """A contact: point of a body that touches (from its place, in world axes), and its surface.

    For a rolling rim `material` is False: the point of contact stays below the middle.
    """

    body: int
    arm: Callable[[Motion], Array]
    normal: Sequence[float] = (0.0, 1.0)
    tangent: Sequence[float] = (1.0, 0.0)
    surface_speed: float = 0.0
    material: bool = True
    middle: Sequence[float] = (0.0, 0.0)


@dataclass(frozen=True)
class Machine:
    """A mechanism in maximal coordinates, with numbers for everything.

    Attributes
    ----------
    masses : sequence of (mass, inertia)
    places : array, shape (n, 3)
        At the state that is looked at.
    joints, coordinates, touches : sequences
    forces : callable
        Motion to the array of applied forces and torques, shape (n, 3).
    """

    masses: Sequence[tuple[float, float]]
    places: Array
    joints: Sequence[Pin | Rail | NoTurn]
    coordinates: Sequence[Place | Angle]
    touches: Sequence[Touch]
    forces: Callable[[Motion], Array]

    def motion(self, q_dot: Array) -> Motion:
        """Return the motion with these velocities of the coordinates."""
        places = np.asarray(self.places, dtype=float)
        still = Motion(places, np.zeros_like(places))
        rows = [row for joint in self.joints for row, _, _ in joint.rows(still)]
        misfit = [m for joint in self.joints for _, _, m in joint.rows(still)]
        assert np.max(np.abs(misfit), initial=0.0) < 1e-13, "the bodies do not meet at the joints"
        rows += [c.read(still)[0] for c in self.coordinates]
        right = np.concatenate([np.zeros(len(misfit)), q_dot])
        return Motion(places, np.linalg.solve(np.array(rows), right).reshape(places.shape))

    def accelerations(self, motion: Motion, contact_forces: Sequence[tuple[float, float]]) -> Array:
        """Return q̈ under contact forces (F_n, F_t), one pair per touch."""
        a = self._solve(motion, contact_forces)
        return np.array(
            [row @ a + rest for row, rest in (c.read(motion) for c in self.coordinates)]
        )

    def _solve(self, motion: Motion, contact_forces: Sequence[tuple[float, float]]) -> Array:
        n = motion.place.size
        applied = self.forces(motion).astype(float).reshape(-1)
        for touch, (f_n, f_t) in zip(self.touches, contact_forces, strict=True):
            force = f_n * np.asarray(touch.normal) + f_t * np.asarray(touch.tangent)
            arm = touch.arm(motion)
            applied[3 * touch.body : 3 * touch.body + 2] += force
            applied[3 * touch.body + 2] += arm[0] * force[1] - arm[1] * force[0]
        joints = [entry for joint in self.joints for entry in joint.rows(motion)]
        J = np.array([row for row, _, _ in joints]).reshape(-1, n)
        rest = np.array([r for _, r, _ in joints])
        mass = np.diag([v for m, j in self.masses for v in (m, m, j)])
        left = np.block([[mass, J.T], [J, np.zeros((len(J), len(J)))]])
        return np.linalg.solve(left, np.concatenate([applied, -rest]))[:n]

    def contact_velocity(self, motion: Motion, touch: Touch) -> tuple[float, float]:
        """Return (v_n, v_t) of a touch."""
        v = motion.speed[touch.body, :2] + cross(motion.speed[touch.body, 2], touch.arm(motion))
        return float(v @ touch.normal), float(v @ touch.tangent) - touch.surface_speed

    def contact_acceleration(
        self, motion: Motion, touch: Touch, contact_forces: Sequence[tuple[float, float]]
    ) -> tuple[float, float]:
        """Return the rates of v_n and v_t."""
        a = self._solve(motion, contact_forces).reshape(-1, 3)[touch.body]
        omega, arm = motion.speed[touch.body, 2], touch.arm(motion)
        total = a[:2] + cross(a[2], arm)
        if touch.material:
            total = total - omega**2 * arm
        else:
            # Only the middle of the disc goes round the mass centre; the rim point stays below it.
            total = total - omega**2 * motion.arm(touch.body, touch.middle)
        return float(total @ touch.normal), float(total @ touch.tangent)
