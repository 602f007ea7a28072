"""A robot as a tree of rigid bodies: joints, inertias, frames, poses, and their checks."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from hashlib import sha256
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError, refuse_unknown

MAX_BODIES = 1000
"""Bodies of a robot: its mass matrix has the square of their number."""
ROUNDING = 1e-15
"""Entries of rotations and inertias below this are the rounding of 0."""
NO_INERTIA = 1e-15
"""Moments of inertia below this are rounding; kg m²."""
INERTIA_TOLERANCE = 1e-6
"""Part of the largest principal moment by which an inertia may miss its inequalities."""

Place = tuple[Array, Array]
"""Orientation and place of a frame in another one, m."""
Solid = tuple[float, Array, Array]
"""Mass, kg, centre, m, and inertia about it, kg m², in the axes of one frame."""
SAME_PLACE: Place = (np.eye(3), np.zeros(3))
MASSLESS: Solid = (0.0, np.zeros(3), np.zeros((3, 3)))


class JointKind(StrEnum):
    """Kind of motion that a joint allows."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another one: its value is ``factor`` times that one plus ``offset``."""

    joint: str
    factor: float
    offset: float


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint of one degree of freedom.

    Attributes
    ----------
    name : str
    kind : JointKind
    axis : ndarray, shape (3,)
        Unit vector in the frame of the joint.
    lower, upper : float
        Limits of its value in rad or m; infinite where there are none.
    armature : float
        Inertia of the rotor as the joint feels it, added to the diagonal of the mass matrix:
        kg m², for a prismatic joint kg.
    reference : float
        Value at which the joint does not move its body.
    mimic : Mimic or None
    stiffness : tuple of float
        Coefficients of x, x² and x³ in the force of the spring against the deflection x from
        `spring_reference`; N m/rad, for a prismatic joint N/m, and so on.
    spring_reference : float
        Value at which the spring has no force.
    damping : tuple of float
        Coefficients of v, v|v| and v³ in the force against the velocity v of the joint;
        N m s/rad, for a prismatic joint N s/m, and so on.
    friction : float
        Largest dry friction, which no formula holds; N m, for a prismatic joint N.
    """

    name: str
    kind: JointKind
    axis: Array
    lower: float = -math.inf
    upper: float = math.inf
    armature: float = 0.0
    reference: float = 0.0
    mimic: Mimic | None = None
    stiffness: tuple[float, ...] = ()
    spring_reference: float = 0.0
    damping: tuple[float, ...] = ()
    friction: float = 0.0

    @property
    def unit(self) -> str:
        """Unit of its value."""
        return "rad" if self.kind is JointKind.REVOLUTE else "m"

    @property
    def rest(self) -> float:
        """Value nearest to 0 within its limits."""
        return min(max(0.0, self.lower), self.upper)

    def fault(self, value: float) -> str:
        """Return a sentence where a value is outside the limits; empty where it is not."""
        if self.lower <= value <= self.upper:
            return ""
        return (
            f"joint {self.name}: got {value:g} {self.unit}, need a value within its limits "
            f"{self.lower:g} and {self.upper:g}."
        )


@dataclass(frozen=True, eq=False)
class TreeBody:
    """A rigid body with the joint that connects it to its parent.

    Attributes
    ----------
    name : str
    parent : int
        Index of the body that carries it, -1 for the base.
    rotation, position : ndarray, shapes (3, 3) and (3,)
        Frame of the joint in the frame of the parent, m. The joint then moves the body.
    joint : Joint or None
        None for a body fixed to its parent.
    mass : float
        kg.
    center : ndarray, shape (3,)
        Centre of mass in the frame of the body, m.
    inertia : ndarray, shape (3, 3)
        About the centre of mass, in the axes of the body; kg m².
    compensated : ndarray, shape (4,)
        Mass whose weight is held by gravity compensation, and this mass times its centre;
        kg and kg m.
    """

    name: str
    parent: int
    rotation: Array
    position: Array
    joint: Joint | None = None
    mass: float = 0.0
    center: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))
    compensated: Array = field(default_factory=lambda: np.zeros(4))


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame that a body carries: its place and orientation in that body's frame."""

    body: int
    rotation: Array
    position: Array


@dataclass(frozen=True)
class Pose:
    """Values of joints by name, and the orientation of the base as a quaternion (w, x, y, z)."""

    joints: Mapping[str, float]
    base: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False, repr=False)
class RobotTree:
    """Bodies of a robot, each after its parent, and its frames by name.

    Attributes
    ----------
    name : str
    bodies : tuple of Body
        The first one is the base.
    frames : mapping of str to Frame
    floating : bool
        Whether the base moves freely in space.
    poses : mapping of str to Pose
    gravity : ndarray, shape (3,)
        m/s².
    notices : tuple of str
        Sentences on what the file says and the tree does not hold.
    base : str
        A sentence that says whether the base floats, and how this was decided.
    orientation : tuple of float
        Of a floating base where no pose is named: a quaternion (w, x, y, z).
    base_armature : float
        Added to the diagonal of the mass matrix for each velocity of a floating base, kg and
        kg m².
    base_damping : float
        Force against each velocity of a floating base, N s/m and N m s/rad.
    ambiguous : mapping of str to tuple of str
        Names that several elements of the file share, with those that `frames` has instead.
    opened : bool
        Whether the file closes chains or couples joints, which the tree does not.
    """

    name: str
    bodies: tuple[TreeBody, ...]
    frames: Mapping[str, Frame]
    floating: bool
    poses: Mapping[str, Pose] = field(default_factory=dict)
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))
    notices: tuple[str, ...] = ()
    base: str = ""
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    base_armature: float = 0.0
    base_damping: float = 0.0
    ambiguous: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    opened: bool = False

    def __repr__(self) -> str:
        """Return the title."""
        return f"RobotTree {self.title}"

    @property
    def title(self) -> str:
        """Name, kind of base and number of joints in one line, and whether chains are open."""
        base = "floating" if self.floating else "fixed"
        opened = " of the open tree" if self.opened else ""
        return f"{self.name}, {base} base, {len(self.joints)} joints{opened}"

    @cached_property
    def joints(self) -> dict[str, Joint]:
        """The joints by name, without mimic joints."""
        joints = (body.joint for body in self.bodies)
        return {j.name: j for j in joints if j is not None and j.mimic is None}

    @cached_property
    def dry_joints(self) -> frozenset[str]:
        """Names of the joints that have dry friction, or that one follows which has it."""
        joints = (body.joint for body in self.bodies)
        dry = (j for j in joints if j is not None and j.friction > 0)
        return frozenset(j.mimic.joint if j.mimic else j.name for j in dry)

    @cached_property
    def definition(self) -> str:
        """All that dynamics is derived from, as one text."""
        bodies = [
            [
                *(b.parent, b.mass),
                *(a.tolist() for a in (b.rotation, b.position, b.center, b.inertia)),
                b.compensated.tolist(),
                b.joint
                and [
                    *(b.joint.name, b.joint.kind.value, b.joint.axis.tolist()),
                    *(b.joint.armature, b.joint.reference, b.joint.stiffness),
                    *(b.joint.spring_reference, b.joint.damping),
                    b.joint.mimic and [b.joint.mimic.joint, b.joint.mimic.factor],
                    b.joint.mimic and b.joint.mimic.offset,
                ],
            ]
            for b in self.bodies
        ]
        base = [self.floating, self.base_armature, self.base_damping]
        return json.dumps([base, self.gravity.tolist(), bodies])

    @cached_property
    def merged(self) -> RobotTree:
        """The same robot with each body that is fixed to its parent as a part of it."""
        # For each body: the one it is a part of, and its place there.
        places: list[tuple[int, Array, Array]] = []
        parts: list[list[tuple[TreeBody, Array, Array]]] = []
        kept: list[TreeBody] = []
        for body in self.bodies:
            into, (R, p) = -1, SAME_PLACE
            if body.parent >= 0:
                into, R, p = places[body.parent]
            R, p = cleaned(R @ body.rotation), R @ body.position + p
            if body.joint is not None or into < 0:
                kept.append(replace(body, parent=into, rotation=R, position=p))
                parts.append([])
                into, (R, p) = len(kept) - 1, SAME_PLACE
            places.append((into, R, p))
            parts[into].append((body, R, p))
        bodies = (replace(b, **_whole(own)) for b, own in zip(kept, parts, strict=True))
        frames = {}
        for name, frame in self.frames.items():
            into, R, p = places[frame.body]
            frames[name] = Frame(into, cleaned(R @ frame.rotation), R @ frame.position + p)
        return replace(self, bodies=tuple(bodies), frames=frames)

    @cached_property
    def joints_by_place(self) -> tuple[str, ...]:
        """Names of `joints`, each after those that carry it, siblings by their place and shape.

        The names of a file and the order of its elements change nothing in it. Siblings that equal
        each other with all that they carry stand in the order of the file.
        """
        bodies = self.merged.bodies
        carried: list[list[int]] = [[] for _ in bodies]
        shapes = [_shape(body) for body in bodies]
        digests = [b""] * len(bodies)
        for i in reversed(range(len(bodies))):
            own = sorted(digests[k] for k in carried[i])
            digests[i] = sha256(b"".join([repr(shapes[i]).encode(), *own])).digest()
            if i:
                carried[bodies[i].parent].append(i)
        names, waiting = list[str](), [0]
        while waiting:
            i = waiting.pop()
            joint = bodies[i].joint
            if joint is not None and joint.mimic is None:
                names.append(joint.name)
            waiting += sorted(carried[i], key=lambda k: (shapes[k], digests[k], k), reverse=True)
        return tuple(names)

    def massless(self, locked: Collection[str] = ()) -> str:
        """Return a joint that moves no mass and has no rotor, or ``base``; empty where none is."""
        carried = [body.mass for body in self.bodies]
        for i in reversed(range(1, len(carried))):
            carried[self.bodies[i].parent] += carried[i]
        if self.floating and not carried[0] > 0:
            return "base"
        for body, mass in zip(self.bodies, carried, strict=True):
            joint = body.joint
            if joint and not (mass > 0 or joint.armature > 0 or joint.name in locked):
                return joint.name
        return ""

    def frame(self, name: str, where: str) -> Frame:
        """Return a frame by its name; InputError names the nearest one."""
        if several := self.ambiguous.get(name):
            raise InputError(
                f"{where}: several elements of the file are called {name!r}, at different places. "
                f"Fix: name one of {', '.join(several)}."
            )
        refuse_unknown("frame", name, self.frames, where)
        return self.frames[name]

    def with_armature(self, armature: Mapping[str, float] | float, where: str) -> RobotTree:
        """Return the robot with other rotor inertias: of all its joints, or by their names."""
        given = dict.fromkeys(self.joints, armature) if isinstance(armature, float) else armature
        for name, value in given.items():
            refuse_unknown("joint", name, self.joints, where)
            if not 0 <= value < math.inf:
                raise InputError(
                    f"{where}: armature of joint {name!r}: got {value:g}, need a finite number "
                    ">= 0, in kg m^2."
                )
        bodies = (
            replace(b, joint=replace(b.joint, armature=given.get(b.joint.name, b.joint.armature)))
            if b.joint
            else b
            for b in self.bodies
        )
        return replace(self, bodies=tuple(bodies))


def _shape(body: TreeBody) -> tuple[float | str, ...]:
    """Return all of a body, its place and its joint that a name or an order cannot change.

    Lengths and masses that differ by rounding are equal in it.
    """
    arrays = [body.position, body.rotation, body.center, body.inertia, body.compensated]
    joint = body.joint
    if joint is not None:
        arrays += [joint.axis, np.array([*joint.stiffness, *joint.damping])]
    numbers = (
        [body.mass]
        if joint is None
        else [
            *(body.mass, joint.lower, joint.upper, joint.armature, joint.reference),
            *(joint.spring_reference, joint.friction),
        ]
    )
    flat = np.concatenate([*(array.ravel() for array in arrays), numbers])
    return (*(np.round(flat, 9) + 0.0).tolist(), "" if joint is None else joint.kind.value)


def _whole(parts: Sequence[tuple[TreeBody, Array, Array]]) -> dict[str, Any]:
    """Return mass, centre and inertia of bodies with their places in one frame."""
    solids = [(b.mass, R @ b.center + p, R @ b.inertia @ R.T) for b, R, p in parts]
    if not any(mass for mass, _, _ in solids):
        return {"inertia": sum((inertia for _, _, inertia in solids), np.zeros((3, 3)))}
    whole: dict[str, Any] = dict(zip(("mass", "center", "inertia"), joined(solids), strict=True))
    whole["compensated"] = np.zeros(4)
    for body, R, p in parts:
        mass, moment = body.compensated[0], body.compensated[1:]
        whole["compensated"] += (mass, *(R @ moment + mass * p))
    return whole


def joined(parts: Sequence[Solid]) -> Solid:
    """Return one solid of several in one frame, which together have mass."""
    mass = sum(m for m, _, _ in parts)
    center = sum((m * c for m, c, _ in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for m, c, own in parts:
        d = c - center
        inertia += own + m * (d @ d * np.eye(3) - np.outer(d, d))
    return mass, center, inertia


def rotation_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """Return the rotation about the fixed axes x, y, z in this order, as URDF has it."""
    angles = np.array([roll, pitch, yaw])
    return cleaned(np.array(rpy_rows(np.cos(angles), np.sin(angles))))


def rpy_rows(cosines: Sequence[Any] | Array, sines: Sequence[Any] | Array) -> list[list[Any]]:
    """Return the rows of `rotation_rpy` by cosine and sine of roll, pitch and yaw."""
    (cr, cp, cy), (sr, sp, sy) = cosines, sines
    return [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]


def rotation_axis(axis: Sequence[float] | Array, angle: float) -> Array:
    """Return the rotation by an angle about a unit vector."""
    c, s = math.cos(angle), math.sin(angle)
    return cleaned(c * np.eye(3) + s * cross_matrix(axis) + (1 - c) * np.outer(axis, axis))


def cross_matrix(axis: Sequence[float] | Array) -> Array:
    """Return the matrix whose product with a vector is the cross product of the axis with it."""
    x, y, z = axis
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def rotation_quaternion(quaternion: Sequence[float], where: str) -> Array:
    """Return the rotation of a quaternion (w, x, y, z), which is scaled to unit length.

    InputError where its length is 0.
    """
    q = np.array(quaternion, float)
    length = float(np.linalg.norm(q))
    if not length > 1e-10:
        raise InputError(f"{where}: got the quaternion {q.tolist()}, need one of unit length.")
    w, x, y, z = q / length
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return cleaned(np.array(rows))


def quaternion_of(rotation: Array) -> tuple[float, float, float, float]:
    """Return the quaternion (w, x, y, z) of a rotation."""
    # Each row is the quaternion times four times one of its entries: the largest is the safest.
    R, trace = rotation, float(np.trace(rotation))
    a, b, c = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    rows = np.zeros((4, 4))
    rows[0, 1:] = rows[1:, 0] = a, b, c
    rows[1:, 1:] = R + R.T
    rows[0, 0] = 1 + trace
    for i in range(3):
        rows[1 + i, 1 + i] = 1 + 2 * R[i, i] - trace
    best = rows[int(np.argmax(rows.diagonal()))]
    w, x, y, z = (best / np.linalg.norm(best)).tolist()
    return w, x, y, z


def cleaned(matrix: Array) -> Array:
    """Return a matrix whose entries that are rounding are 0, 1 and -1 exactly."""
    near = np.round(matrix)
    return np.where(np.abs(matrix - near) <= ROUNDING, near, matrix) + 0.0


def unit_vector(vector: Sequence[float] | Array, where: str) -> Array:
    """Return a vector scaled to unit length; InputError where its length is 0."""
    array = np.array(vector, float)
    length = float(np.linalg.norm(array))
    if not length > 1e-10:
        raise InputError(f"{where}: got the vector {array.tolist()}, need one of positive length.")
    return cleaned(array / length)


def inertia_fault(mass: float, inertia: Array) -> str:
    """Return a sentence on mass and inertia that no body has; empty for physical ones."""
    if not mass >= 0:
        return f"mass {mass:g} kg, need a number >= 0"
    moments = np.linalg.eigvalsh(inertia)
    tolerance = max(INERTIA_TOLERANCE * float(np.abs(moments).max()), NO_INERTIA)
    if moments[0] < -tolerance:
        listed = ", ".join(f"{m:.6g}" for m in moments)
        return f"an inertia with the principal moments {listed} kg m^2, need numbers >= 0"
    return ""


def inertia_doubt(mass: float, inertia: Array) -> str:
    """Return a warning on usable mass and inertia that no body has; empty for physical ones."""
    if fault := inertia_fault(mass, inertia):
        return fault
    a, b, c = np.linalg.eigvalsh(inertia).tolist()
    if mass == 0 and c > NO_INERTIA:
        return "an inertia without mass"
    if a + b >= c * (1 - INERTIA_TOLERANCE) - NO_INERTIA:
        return ""
    sums = f"{a:.6g} + {b:.6g} < {c:.6g} kg m^2"
    return f"principal moments that miss the triangle inequality, {sums}"
