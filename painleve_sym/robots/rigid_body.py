"""Rigid-body dynamics of a tree as CasADi formulas: mass matrix, bias and motion of a point.

All vectors are in the axes of the base, and motions are those at its origin, so that inertias of
bodies add up as they are. The mass matrix is that of composite rigid bodies, the bias that of the
recursive Newton-Euler equations (Featherstone 2008, *Rigid Body Dynamics Algorithms*, chapters 5
and 6). The velocities of a floating base are those of its origin and its angular velocity, in its
own axes; they come before those of the joints.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.robots.tree import Joint, JointKind, RobotTree, TreeBody, cross_matrix


class _Inertia(NamedTuple):
    """Mass, mass times centre, and inertia about the origin of the base."""

    mass: ca.SX
    moment: ca.SX
    about: ca.SX

    def __add__(self, other: _Inertia) -> _Inertia:  # type: ignore[override]
        return _Inertia(*(a + b for a, b in zip(self, other, strict=True)))

    def momentum(self, motion: _Motion) -> _Motion:
        """Return linear and angular momentum of a motion."""
        return _Motion(
            self.mass * motion.linear - ca.cross(self.moment, motion.angular),
            self.about @ motion.angular + ca.cross(self.moment, motion.linear),
        )


class _Motion(NamedTuple):
    """Velocity of the origin of the base and angular velocity; or force and moment there."""

    linear: ca.SX
    angular: ca.SX

    def __add__(self, other: _Motion) -> _Motion:  # type: ignore[override]
        return _Motion(self.linear + other.linear, self.angular + other.angular)

    def times(self, factor: ca.SX) -> _Motion:
        """Return the motion times a number."""
        return _Motion(self.linear * factor, self.angular * factor)

    def dot(self, other: _Motion) -> ca.SX:
        """Return the power of a force in a motion."""
        return ca.dot(self.linear, other.linear) + ca.dot(self.angular, other.angular)

    def moves(self, motion: _Motion) -> _Motion:
        """Return how this motion changes another one that is carried along."""
        return _Motion(
            ca.cross(self.angular, motion.linear) + ca.cross(self.linear, motion.angular),
            ca.cross(self.angular, motion.angular),
        )

    def moves_force(self, force: _Motion) -> _Motion:
        """Return how this motion changes a momentum that is carried along."""
        return _Motion(
            ca.cross(self.angular, force.linear),
            ca.cross(self.angular, force.angular) + ca.cross(self.linear, force.linear),
        )

    def at(self, point: ca.SX) -> ca.SX:
        """Return the velocity of a point that moves along."""
        return self.linear + ca.cross(self.angular, point)


_AT_REST = _Motion(ca.SX(3, 1), ca.SX(3, 1))


@dataclass(frozen=True, eq=False)
class RigidBodies:
    """Formulas of a robot at joint values `q`, by name; each a scalar CasADi expression.

    `locked` joints have a value and no velocity. The velocities, `dofs`, are six of a floating
    base and one of each joint that is not locked and follows no other.
    """

    tree: RobotTree
    q: Mapping[str, ca.SX]
    locked: frozenset[str] = frozenset()

    @cached_property
    def dofs(self) -> tuple[str, ...]:
        """The joints that have a velocity, in the order of the file."""
        return tuple(name for name in self.tree.joints if name not in self.locked)

    @property
    def base_size(self) -> int:
        """Velocities of the base: 6, or 0 where it is fixed."""
        return 6 if self.tree.floating else 0

    @property
    def size(self) -> int:
        """Number of all velocities."""
        return self.base_size + len(self.dofs)

    def _leader(self, joint: Joint) -> tuple[str, float]:
        """Return the joint whose velocity moves a joint, and by which factor."""
        follows = joint.mimic
        return (joint.name, 1.0) if follows is None else (follows.joint, follows.factor)

    def _value(self, joint: Joint) -> ca.SX:
        """Return the value of a joint, also of one that follows another one."""
        name, factor = self._leader(joint)
        return self.q[name] * factor + (joint.mimic.offset if joint.mimic else 0.0)

    @cached_property
    def placements(self) -> list[tuple[ca.SX, ca.SX]]:
        """Rotation and position of every body in the frame of the base."""
        placed: list[tuple[ca.SX, ca.SX]] = []
        for body in self.tree.bodies:
            R, p = constant(body.rotation), constant(body.position)
            if body.parent >= 0:
                above, origin = placed[body.parent]
                R, p = above @ R, origin + above @ p
            if (joint := body.joint) is not None:
                value = self._value(joint) - joint.reference
                if joint.kind is JointKind.REVOLUTE:
                    R = R @ _turn(joint.axis, value)
                else:
                    p = p + R @ (constant(joint.axis) * value)
            placed.append((R, p))
        return placed

    @cached_property
    def _column(self) -> dict[str, int]:
        return {name: self.base_size + k for k, name in enumerate(self.dofs)}

    @cached_property
    def _moved(self) -> list[tuple[int, _Motion] | None]:
        """Velocity that moves each body against its parent, and the motion for a unit of it."""
        moved: list[tuple[int, _Motion] | None] = []
        for body, (R, p) in zip(self.tree.bodies, self.placements, strict=True):
            if body.joint is None or self._leader(body.joint)[0] in self.locked:
                moved.append(None)
                continue
            name, factor = self._leader(body.joint)
            axis = R @ (constant(body.joint.axis) * factor)
            if body.joint.kind is JointKind.REVOLUTE:
                motion = _Motion(ca.cross(p, axis), axis)
            else:
                motion = _Motion(axis, ca.SX(3, 1))
            moved.append((self._column[name], motion))
        return moved

    def _moving(self, body: int) -> Iterator[tuple[int, _Motion]]:
        """Yield the motions of the joints above a body, from its own joint to the base."""
        while body >= 0:
            if (moved := self._moved[body]) is not None:
                yield moved
            body = self.tree.bodies[body].parent

    @cached_property
    def _composites(self) -> list[_Inertia]:
        """Inertia of each body with all that it carries."""
        own: list[_Inertia] = []
        for body, (R, p) in zip(self.tree.bodies, self.placements, strict=True):
            own.append(_inertia(body, R, p))
        for i in reversed(range(1, len(own))):
            parent = self.tree.bodies[i].parent
            own[parent] = own[parent] + own[i]
        return own

    def mass_matrix(self) -> ca.SX:
        """Return the mass matrix, shape (size, size); rotor inertias are on its diagonal."""
        M = ca.SX(self.size, self.size)
        whole = self._composites[0]
        for k in range(self.base_size):
            momentum = whole.momentum(_unit(k))
            M[:6, k] = ca.vertcat(*momentum)
            M[k, k] += self.tree.base_armature
        for i, moved in enumerate(self._moved):
            if moved is None:
                continue
            column, motion = moved
            joint = self.tree.bodies[i].joint
            assert joint is not None
            momentum = self._composites[i].momentum(motion)
            # The rotor of a joint that follows turns by its factor as well.
            M[column, column] += motion.dot(momentum) + joint.armature * self._leader(joint)[1] ** 2
            for row, carried in self._moving(self.tree.bodies[i].parent):
                # One velocity may move both: that of a joint that the other one follows.
                entry = carried.dot(momentum) * (2 if row == column else 1)
                M[min(row, column), max(row, column)] += entry
            if self.tree.floating:
                M[:6, column] += ca.vertcat(*momentum)
        return ca.triu2symm(ca.triu(M))

    def _motions(self, velocity: ca.SX, gravity: ca.SX) -> list[tuple[_Motion, _Motion]]:
        """Return velocity and acceleration of every body where no velocity changes.

        The accelerations hold −gravity, as if the base were accelerated against it.
        """
        motions: list[tuple[_Motion, _Motion]] = []
        for body, moved in zip(self.tree.bodies, self._moved, strict=True):
            if body.parent < 0:
                floats = self.tree.floating
                V = _Motion(velocity[:3], velocity[3:6]) if floats else _AT_REST
                A = _Motion(-gravity, ca.SX(3, 1))
            else:
                V, A = motions[body.parent]
            if moved is not None:
                column, motion = moved
                step = motion.times(velocity[column])
                V, A = V + step, A + V.moves(step)
            motions.append((V, A))
        return motions

    def bias(self, velocity: ca.SX, gravity: ca.SX) -> ca.SX:
        """Return the forces h of M a + h = forces: of gravity, velocities, springs and dampers.

        Shape (size,); `gravity` is in the axes of the base.
        """
        forces = []
        parts = zip(self.tree.bodies, self.placements, strict=True)
        for (V, A), (body, (R, p)) in zip(self._motions(velocity, gravity), parts, strict=True):
            inertia = _inertia(body, R, p)
            force = inertia.momentum(A) + V.moves_force(inertia.momentum(V))
            if body.compensated.any():
                held = body.compensated[0] * p + R @ constant(body.compensated[1:])
                force += _Motion(body.compensated[0] * gravity, ca.cross(held, gravity))
            forces.append(force)
        h = ca.SX(self.size, 1)
        for i in reversed(range(len(forces))):
            if (moved := self._moved[i]) is not None:
                h[moved[0]] += moved[1].dot(forces[i])
            if i:
                parent = self.tree.bodies[i].parent
                forces[parent] = forces[parent] + forces[i]
            h += self._passive(i, velocity)
        if self.tree.floating:
            h[:6] = ca.vertcat(*forces[0]) + self.tree.base_damping * velocity[:6]
            # The armature takes part in the acceleration in the world, the axes turn.
            h[:3] += self.tree.base_armature * ca.cross(velocity[3:6], velocity[:3])
        return h

    def _passive(self, body: int, velocity: ca.SX) -> ca.SX:
        """Return the resisting generalised force of spring and damper of a body's joint."""
        taken, joint = ca.SX(self.size, 1), self.tree.bodies[body].joint
        if (moved := self._moved[body]) is None or joint is None:
            return taken
        column, factor = moved[0], self._leader(joint)[1]
        x, v = self._value(joint) - joint.spring_reference, factor * velocity[column]
        force = ca.SX(0)
        for k, stiffness in enumerate(joint.stiffness, 1):
            force += stiffness * x**k
        for power, damping in zip((v, v * ca.fabs(v), v**3), joint.damping, strict=False):
            force += damping * power
        taken[column] = factor * force
        return taken

    def place(self, name: str) -> tuple[int, ca.SX, ca.SX]:
        """Return the body of a frame, and rotation and position in the frame of the base."""
        frame = self.tree.frames[name]
        R, p = self.placements[frame.body]
        return frame.body, R @ constant(frame.rotation), p + R @ constant(frame.position)

    def jacobian(self, body: int, point: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return the Jacobians of a point of a body: velocity and angular velocity.

        Shapes (3, size).
        """
        linear, angular = ca.SX(3, self.size), ca.SX(3, self.size)
        for k in range(self.base_size):
            motion = _unit(k)
            linear[:, k], angular[:, k] = motion.at(point), motion.angular
        for column, motion in self._moving(body):
            linear[:, column] += motion.at(point)
            angular[:, column] += motion.angular
        return linear, angular

    def drift(
        self, body: int, point: ca.SX, velocity: ca.SX, gravity: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        """Return the acceleration of a point and the angular one where no velocity changes."""
        V, A = self._motions(velocity, gravity)[body]
        return A.at(point) + gravity + ca.cross(V.angular, V.at(point)), A.angular


def constant(values: Array) -> ca.SX:
    """Return numbers as a sparse matrix: its zeros take no part in formulas."""
    return ca.SX(ca.sparsify(ca.DM(values)))


def _unit(k: int) -> _Motion:
    linear, angular = np.zeros(3), np.zeros(3)
    (linear if k < 3 else angular)[k % 3] = 1.0
    return _Motion(constant(linear), constant(angular))


def _turn(axis: Array, angle: ca.SX) -> ca.SX:
    """Return the rotation about a unit vector by an angle (Rodrigues)."""
    c, s = ca.cos(angle), ca.sin(angle)
    if (np.abs(axis) == 1).any():
        # About an axis of coordinates few entries differ from 0 and 1.
        k = int(np.argmax(np.abs(axis)))
        i, j = (k + 1) % 3, (k + 2) % 3
        R = ca.SX(3, 3)
        R[k, k] = 1.0
        R[i, i] = R[j, j] = c
        R[i, j], R[j, i] = -float(axis[k]) * s, float(axis[k]) * s
        return R
    across = constant(cross_matrix(axis))
    return c * ca.SX.eye(3) + s * across + (1 - c) * constant(np.outer(axis, axis))


def _inertia(body: TreeBody, R: ca.SX, p: ca.SX) -> _Inertia:
    if body.mass == 0.0 and not body.inertia.any():
        return _Inertia(ca.SX(1, 1), ca.SX(3, 1), ca.SX(3, 3))
    center = p + R @ constant(body.center)
    moment = body.mass * center
    about = R @ constant(body.inertia) @ R.T
    about = about + ca.dot(moment, center) * ca.SX.eye(3) - moment @ center.T
    return _Inertia(ca.SX(body.mass), moment, about)
