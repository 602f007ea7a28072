"""The contacts of a robot as a `Dynamics`: mobility and free accelerations at its poses."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.at.sticking import sticking_formulas
from painleve_sym.cache import code_mark
from painleve_sym.contact_rows import ContactRows
from painleve_sym.laws.catalogue import parameter_names
from painleve_sym.mechanics.closed_within import CONTACT_TOLERANCE
from painleve_sym.mechanics.declarations import TIME_NAME, Coordinate, Parameter
from painleve_sym.mechanics.outline import ContactOutline, MechanismOutline
from painleve_sym.robots.rigid_body import RigidBodies, constant
from painleve_sym.robots.tree import RobotTree, rpy_rows

BASE = ("base_x", "base_y", "base_z", "base_roll", "base_pitch", "base_yaw")
"""Coordinates of a floating base: place, and angles about the fixed axes x, y, z in turn."""
NORMAL = ("normal_x", "normal_y", "normal_z")
TANGENT = ("tangent_x", "tangent_y", "tangent_z")
_OWN = frozenset({TIME_NAME, "mu", *NORMAL, *TANGENT, *BASE, *(f"{name}_dot" for name in BASE)})
"""Names that no coordinate of a joint takes, beside those of the parameters of laws."""
MAX_LISTED = 5
"""Names that a notice lists."""


def coordinate_names(joints: Iterable[str]) -> dict[str, str]:
    """Return the name of the coordinate of each joint, which no other quantity has.

    Its velocity is this name with ``_dot``, its torque this name after ``torque_``. The name is
    that of the joint, or has ``joint_`` before it where another quantity, or a parameter of a
    contact law, has one of these three.

    Examples
    --------
    >>> from painleve_sym.robots.dynamics import coordinate_names
    >>> coordinate_names(["knee", "knee_dot", "mu"])
    {'knee': 'knee', 'knee_dot': 'joint_knee_dot', 'mu': 'joint_mu'}
    """
    names = list(joints)
    derived = Counter(text for name in names for text in _derived(name))
    foreign = _OWN | parameter_names()
    taken = {*foreign, *names, *derived}
    given = {}
    for name in names:
        shared = derived[name] or any(derived[text] > 1 for text in _derived(name))
        own = name
        if shared or not foreign.isdisjoint((name, *_derived(name))):
            own = f"joint_{name}"
            while not taken.isdisjoint((own, *_derived(own))):
                own = f"joint_{own}"
            taken |= {own, *_derived(own)}
        given[name] = own
    return given


def _derived(name: str) -> tuple[str, str]:
    """Return the names of the velocity and the torque that belong to a coordinate."""
    return f"{name}_dot", f"torque_{name}"


def first_tangent(normal: Array) -> Array:
    """Return the unit vector t1 of surfaces: the axis x along them, y where the normal is nearly x.

    Parameters
    ----------
    normal : ndarray, shape (3, ...)
        Unit vectors.
    """
    steep = np.abs(normal[0]) > 0.9
    axis = np.stack([~steep, steep, np.zeros_like(steep)]).astype(float)
    along = axis - np.sum(axis * normal, axis=0) * normal
    return np.asarray(along / np.linalg.norm(along, axis=0))


@dataclass(frozen=True, eq=False)
class ContactPoint:
    """A contact of a robot with its surroundings.

    Attributes
    ----------
    frame : str
        Name of a frame of the robot.
    point : ndarray, shape (3,)
        In the axes of the frame, m: the point of contact, or the centre of a round foot.
    radius : float
        Of a round foot: the contact is this far from the point, against the normal; m.
    """

    frame: str
    point: Array = field(default_factory=lambda: np.zeros(3))
    radius: float = 0.0


class _Formulas(NamedTuple):
    """Expressions of the functions: arguments, Jacobians, accelerations, mass matrix, base."""

    x: ca.SX
    J: ca.SX
    D: ca.SX
    free: ca.SX
    b: ca.SX
    velocity: ca.SX
    bodies: RigidBodies
    M: ca.SX
    angles: ca.SX
    rates: ca.SX


@dataclass(frozen=True, eq=False)
class RobotDynamics:
    """Contacts of a robot in space, in the form in which `Delassus` asks for them.

    Coordinates are those of a floating base, then joint values; parameters are friction `mu`, the
    normal of the surface and a tangent, both unit vectors of the world, and the torque of each
    joint. All contacts have one normal, and are taken as closed.

    Parameters
    ----------
    tree : RobotTree
    contacts : tuple of ContactPoint
    locked : frozenset of str
        Joints without velocity.
    """

    tree: RobotTree
    contacts: tuple[ContactPoint, ...]
    locked: frozenset[str] = frozenset()

    @property
    def n_margins(self) -> int:
        """None: the domain of a robot is not bounded."""
        return 0

    @property
    def n_tangents(self) -> int:
        """Tangential directions of a contact."""
        return 2

    @property
    def rows(self) -> ContactRows:
        """Rows of the contacts in W and b."""
        return ContactRows(len(self.contacts), self.n_tangents)

    def __getstate__(self) -> dict[str, object]:
        """Pickle without the formulas of CasADi, which another process makes again."""
        return {name: value for name, value in vars(self).items() if name != "_formulas"}

    @cached_property
    def coordinates(self) -> dict[str, str]:
        """Names of the joint coordinates by the joints' names in the file."""
        return coordinate_names(self.tree.joints)

    @property
    def notices(self) -> tuple[str, ...]:
        """Sentences on omissions of the file, and on joints whose coordinates have other names."""
        others = {name: own for name, own in self.coordinates.items() if name != own}
        if not others:
            return self.tree.notices
        listed = ", ".join(f"{name!r} is {own}" for name, own in list(others.items())[:MAX_LISTED])
        more = "" if len(others) <= MAX_LISTED else f", and {len(others) - MAX_LISTED} more"
        return (
            *self.tree.notices,
            "Joints have names that other quantities have. In states, boxes and logs joint "
            f"{listed}{more}.",
        )

    @cached_property
    def outline(self) -> MechanismOutline:
        """Names of states, parameters and contacts."""
        joints = [(self.coordinates[j.name], j) for j in self.tree.joints.values()]
        coordinates = [
            Coordinate(n, f"{n} of the base", "m" if k < 3 else "rad") for k, n in enumerate(BASE)
        ] * self.tree.floating
        coordinates += [Coordinate(n, f"value of joint {j.name}", j.unit) for n, j in joints]
        parameters = [Parameter("mu", 0.0, "1", "friction coefficient", lower=0.0)]
        for names, noun, default in ((NORMAL, "normal", 2), (TANGENT, "tangent", 0)):
            parameters += [
                Parameter(name, float(k == default), "1", f"{noun} of the surface")
                for k, name in enumerate(names)
            ]
        parameters += [
            Parameter(f"torque_{n}", 0.0, "N m" if j.unit == "rad" else "N", "of the joint")
            for n, j in joints
        ]
        contacts = tuple(
            ContactOutline(c.frame, slip_velocity=f"slip of {c.frame}") for c in self.contacts
        )
        return MechanismOutline(tuple(coordinates), tuple(parameters), contacts, (), False)

    @cached_property
    def definition(self) -> str:
        """Everything that the functions are made of, as one text."""
        points: list[object] = []
        for contact in self.contacts:
            frame = self.tree.frames[contact.frame]
            arrays = (frame.rotation, frame.position, contact.point)
            points.append([frame.body, *(a.tolist() for a in arrays), contact.radius])
        own = (code_mark("robots"), self.tree.definition, points, sorted(self.locked))
        return "\n".join(map(str, own))

    @cached_property
    def _formulas(self) -> _Formulas:
        names = self.outline.argument_names
        x = ca.SX.sym("x", len(names))
        at: Mapping[str, ca.SX] = dict(zip(names, ca.vertsplit(x), strict=True))
        own = self.coordinates
        bodies = RigidBodies(self.tree.merged, {j: at[n] for j, n in own.items()}, self.locked)
        vector = [ca.vertcat(*(at[n] for n in three)) for three in (NORMAL, TANGENT)]
        gravity = ca.SX(ca.DM(self.tree.gravity))
        velocity = ca.vertcat(*(at[f"{own[name]}_dot"] for name in bodies.dofs))
        angles, rates = ca.SX(0, 1), ca.SX(0, 1)
        if self.tree.floating:
            angles = ca.vertcat(*(at[name] for name in BASE[3:]))
            rates = ca.vertcat(*(at[f"{name}_dot"] for name in BASE))
            R, _ = _base(angles)
            vector, gravity = [R.T @ v for v in vector], R.T @ gravity
            velocity = ca.vertcat(_to_twist(angles) @ rates, velocity)
        normal, tangent = vector
        axes = ca.horzcat(normal, tangent, ca.cross(normal, tangent)).T
        J, drift = [], []
        for contact in self.contacts:
            body, turned, origin = bodies.place(contact.frame)
            point = origin + turned @ constant(contact.point)
            linear, angular = bodies.jacobian(body, point)
            acceleration, turning = bodies.drift(body, point, velocity, gravity)
            if contact.radius:
                # The point of contact moves over the foot: its lever stays along the normal.
                lever = -contact.radius * normal
                linear = linear + ca.horzcat(
                    *(ca.cross(angular[:, k], lever) for k in range(bodies.size))
                )
                acceleration = acceleration + ca.cross(turning, lever)
            J.append(axes @ linear)
            drift.append(axes @ acceleration)
        M, whole = bodies.mass_matrix(), ca.vertcat(*J)
        torques = ca.vertcat(*(at[f"torque_{own[name]}"] for name in bodies.dofs))
        forces = ca.vertcat(ca.SX(bodies.base_size, 1), torques) - bodies.bias(velocity, gravity)
        # The tree's branches share no entry of M, and stay apart in its factors.
        solved = ca.ldl_solve(ca.densify(ca.horzcat(whole.T, forces)), *ca.ldl(M))
        D, free = solved[:, : self.rows.size], solved[:, self.rows.size]
        b = whole @ free + ca.vertcat(*drift)
        return _Formulas(x, whole, D, free, b, velocity, bodies, M, angles, rates)

    def height_function(self) -> ca.Function:
        """Return the function of the height of the first contact along the normal, m."""
        f, contact = self._formulas, self.contacts[0]
        at = dict(zip(self.outline.argument_names, ca.vertsplit(f.x), strict=True))
        _, turned, origin = f.bodies.place(contact.frame)
        point = origin + turned @ constant(contact.point)
        if self.tree.floating:
            R, _ = _base(f.angles)
            point = ca.vertcat(*(at[name] for name in BASE[:3])) + R @ point
        normal = ca.vertcat(*(at[name] for name in NORMAL))
        return ca.Function("height", [f.x], [ca.densify(ca.dot(normal, point) - contact.radius)])

    def mass_function(self) -> ca.Function:
        """Return the function of the mass matrix, row by row."""
        f = self._formulas
        return ca.Function("mass", [f.x], [ca.densify(ca.vec(f.M.T))])

    @property
    def velocities(self) -> tuple[str, ...]:
        """Name of the coordinate of each velocity of the robot: six of the base, then joints."""
        joints = (own for name, own in self.coordinates.items() if name not in self.locked)
        return (*(BASE * self.tree.floating), *joints)

    def contact_function(self) -> ca.Function:
        """Return the function of all `ContactNumbers` but mu."""
        f, rows, n = self._formulas, self.rows, len(self.contacts)
        W, v = f.J @ f.D, f.J @ f.velocity
        held = []
        for i in range(n):
            own = [rows.normal(i), *rows.tangents(i)]
            held.append(sticking_formulas(W[own, own], f.b[own]))
        slips = [v[row] for i in range(n) for row in rows.tangents(i)]
        entries = [ca.SX(n, 1), *(v[rows.normal(i)] for i in range(n)), *slips]
        entries += [h[k] for k in range(2) for h in held]
        entries += [CONTACT_TOLERANCE * ca.SX.ones(2 * n), ca.vec(W.T), f.b]
        return ca.Function("contacts", [f.x], ca.cse([ca.densify(ca.vertcat(*entries))]))

    def motion_function(self) -> ca.Function:
        """Return the function of all `MotionNumbers`."""
        f, names = self._formulas, [c.name for c in self.outline.coordinates]
        # Velocities of the robot from those of the coordinates, and back.
        to, back = ca.SX(f.bodies.size, len(names)), ca.SX(len(names), f.bodies.size)
        free = f.free
        for k, name in enumerate(f.bodies.dofs, f.bodies.base_size):
            place = names.index(self.coordinates[name])
            to[k, place] = back[place, k] = 1.0
        if self.tree.floating:
            E = _to_twist(f.angles)
            to[:6, :6], back[:6, :6] = E, ca.solve(E, ca.SX.eye(6))
            turning = ca.jtimes(E @ f.rates, f.angles, f.rates[3:])
            free = free - ca.vertcat(turning, ca.SX(f.bodies.size - 6, 1))
        energy = f.velocity.T @ f.M @ f.velocity / 2
        rows = [ca.vec((f.J @ to).T), ca.vec((back @ f.D).T), back @ free]
        entries = ca.vertcat(*rows, ca.SX(self.rows.size, 1), energy)
        return ca.Function("motion", [f.x], [ca.densify(entries)])


def _base(angles: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the rotation of the base by its angles, and its angular velocity per angle.

    The angular velocity is in the axes of the base.
    """
    cosines, sines = map(ca.vertsplit, (ca.cos(angles), ca.sin(angles)))
    R = ca.vertcat(*(ca.horzcat(*row) for row in rpy_rows(cosines, sines)))
    (cr, cp, _), (sr, sp, _) = cosines, sines
    rates = ca.vertcat(
        ca.horzcat(1, 0, -sp), ca.horzcat(0, cr, sr * cp), ca.horzcat(0, -sr, cr * cp)
    )
    return R, rates


def _to_twist(angles: ca.SX) -> ca.SX:
    """Return the Jacobian of the twist of the base, in its own axes, by its coordinate rates."""
    R, rates = _base(angles)
    return ca.diagcat(R.T, rates)
