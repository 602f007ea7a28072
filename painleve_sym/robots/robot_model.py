"""Robots of a URDF or MJCF file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.checks import by_name, checked_values, names_of, number
from painleve_sym.errors import InputError, received, refuse_unknown, unknown_name
from painleve_sym.robots.dynamics import (
    BASE,
    NORMAL,
    TANGENT,
    ContactPoint,
    RobotDynamics,
    first_tangent,
)
from painleve_sym.robots.robot_contact import RobotContact
from painleve_sym.robots.robot_file import read_robot
from painleve_sym.robots.tree import (
    Joint,
    Pose,
    RobotTree,
    cleaned,
    rotation_quaternion,
    unit_vector,
)
from painleve_sym.robots.urdf import srdf_poses
from painleve_sym.units import Value

OTHERS = ("free", "stuck")
"""What the other contacts do: they carry no force that changes, or do not accelerate."""


@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """A robot of a URDF or MJCF file; `robot` reads it.

    Attributes
    ----------
    tree : RobotTree
        Bodies, joints, frames and named poses.
    file : str
        From which it was read.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> arm = ps.robot("tests/robots/files/two_link.urdf")
    >>> list(arm.joints)
    ['theta_1', 'theta_2']
    >>> tip = arm.contact("tip", joints={"theta_1": -0.5, "theta_2": -1.0})
    >>> round(tip.risk().mu_P, 3)
    20.3
    """

    tree: RobotTree
    where: str = field(default="robot")
    file: str = ""

    def __repr__(self) -> str:
        """Return the title of its tree."""
        return f"Robot {self.tree.title}"

    @property
    def joints(self) -> dict[str, Joint]:
        """Joints by name, without mimic joints."""
        return self.tree.joints

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of the frames."""
        return tuple(self.tree.frames)

    def contact(
        self,
        frames: str | Sequence[str],
        *,
        point: Sequence[float] = (0.0, 0.0, 0.0),
        normal: Sequence[float] = (0.0, 0.0, 1.0),
        radius: float = 0.0,
        joints: Mapping[str, Value] | None = None,
        pose: str | None = None,
        locked: str | Sequence[str] = (),
        others: str = "free",
    ) -> RobotContact:
        """Return a contact of the robot at a pose.

        Parameters
        ----------
        frames : str or sequence of str
            Frames with a contact; the first one is in question.
        point : sequence of float, shape (3,)
            Place of the contact in its frame, m; of a round foot its centre.
        normal : sequence of float, shape (3,)
            Of the surface, in the axes of the world: from the ground to the robot.
        radius : float
            Of round feet, m.
        joints : mapping of str to (float or str), optional
            Values of joints, rad or m, or texts with a unit; others are those of the pose, or
            nearest to 0.
        pose : str, optional
            A named pose: keyframe of MJCF, group state of SRDF.
        locked : str or sequence of str
            Joints that hold their value, whatever force acts; ``all`` of them.
        others : str
            What the other contacts do: ``free``, or ``stuck``, without acceleration.

        Raises
        ------
        InputError
            Unknown frames, joints or poses, with the nearest name; values outside limits; a
            vanishing normal.
        """
        where, tree = self.where, self.tree
        names = names_of(frames, f"{where}: contact", "LF_FOOT")
        if not names or len(set(names)) < len(names):
            raise InputError(f"{where}: contact: got {received(frames)}, need different frames.")
        for name in names:
            tree.frame(name, f"{where}: contact")
        refuse_unknown("choice", others, OTHERS, f"{where}: others")
        place = _vector(point, f"{where}: point")
        axis = unit_vector(_vector(normal, f"{where}: normal"), f"{where}: normal")
        size = number(radius, "radius", where=where, lower=0.0)
        held_joints = names_of(locked, f"{where}: locked", "knee,ankle")
        if held_joints == ("all",) and "all" not in tree.joints:
            held_joints = tuple(tree.joints)
        for name in held_joints:
            refuse_unknown("joint", name, tree.joints, f"{where}: locked")
        if mover := tree.massless(held_joints):
            raise InputError(
                f"{where}: {'the base' if mover == 'base' else f'joint {mover!r}'} moves links "
                "without mass. Fix: give the moving links an inertial, or lock the joint."
            )
        values, base = self._pose(joints, pose)
        points = tuple(ContactPoint(name, place, size) for name in names)
        dynamics = RobotDynamics(tree, points, frozenset(held_joints))
        if not tree.floating and not set(tree.joints) - set(held_joints):
            raise InputError(f"{where}: nothing moves. Fix: lock fewer joints.")
        at = dict.fromkeys(dynamics.outline.argument_names, 0.0)
        at |= {dynamics.coordinates[name]: value for name, value in values.items()}
        if tree.floating:
            at |= dict(zip(BASE[3:], base.tolist(), strict=True))
        along = cleaned(first_tangent(axis))
        at |= dict(zip(NORMAL, axis.tolist(), strict=True))
        at |= dict(zip(TANGENT, along.tolist(), strict=True))
        stuck = others == "stuck" and len(names) > 1
        return RobotContact(dynamics, at, stuck, self.file, pose)

    def _pose(
        self, joints: Mapping[str, Value] | None, pose: str | None
    ) -> tuple[dict[str, float], Array]:
        """Return values of all joints, and the angles of the base."""
        where, tree = self.where, self.tree
        if pose is not None and pose not in tree.poses:
            hint = "" if tree.poses else " Fix: name the SRDF file of the robot."
            raise InputError(f"{where}: {unknown_name('pose', pose, tree.poses)}{hint}")
        named = Pose({}, tree.orientation) if pose is None else tree.poses[pose]
        values = checked_values(
            where,
            "joint",
            by_name(joints, f"{where}: joints", "{'knee': 0.5}"),
            {name: named.joints.get(name, j.rest) for name, j in tree.joints.items()},
            lambda name: tree.joints[name].unit,
            lambda name, value: tree.joints[name].fault(value),
        )
        R = rotation_quaternion(named.base, f"{where}: pose {pose}")
        roll, yaw = math.atan2(R[2, 1], R[2, 2]), math.atan2(R[1, 0], R[0, 0])
        return values, np.array([roll, math.asin(max(-1.0, min(1.0, -R[2, 0]))), yaw])


def robot(
    path: str | Path,
    *,
    floating: bool | None = None,
    armature: float | Mapping[str, float] | None = None,
    srdf: str | Path | None = None,
) -> Robot:
    """Return the robot of a URDF or MJCF file.

    Parameters
    ----------
    path : str or Path
    floating : bool, optional
        Whether the base moves freely. By default as the file says: MJCF by a free joint; a URDF
        base floats unless its root link is called ``world`` or has no inertia.
    armature : float or mapping of str to float, optional
        Inertia of the rotors as the joints feel it, added to the diagonal of the mass matrix:
        kg m², for a prismatic joint kg; of all joints, or by their names. By default that of MJCF;
        URDF has none.
    srdf : str or Path, optional
        File with named poses of a URDF robot. By default that of the same name in the same folder
        or in a folder ``srdf`` beside it, where there is one.

    Returns
    -------
    Robot

    Raises
    ------
    InputError
        The file is not readable, not that of a robot, or has what is not an inertia.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> dog = ps.robot("examples/robots/quadruped.urdf")
    >>> foot = dog.contact("LF_foot", joints={"LF_HFE": 0.7, "LF_KFE": -1.0})
    >>> risk = foot.risk(mu=0.8)
    >>> risk.W.shape, len(risk.gradient)
    ((3, 3), 12)
    """
    tree = read_robot(path, floating=floating)
    where = f"robot {tree.name}"
    if armature is not None:
        if not isinstance(armature, Mapping):
            armature = number(armature, "armature", where=where, lower=0.0)
        tree = tree.with_armature(armature, where)
    return Robot(_with_poses(tree, Path(path), srdf), where, str(path))


def _with_poses(tree: RobotTree, path: Path, srdf: str | Path | None) -> RobotTree:
    candidates = [path.with_suffix(".srdf"), path.parent.parent / "srdf" / f"{path.stem}.srdf"]
    if srdf is not None:
        file = Path(srdf)
    elif path.suffix == ".urdf":
        file = next((f for f in candidates if f.is_file()), path)
    else:
        return tree
    if file == path:
        return tree
    return replace(tree, poses=srdf_poses(file, tree, f"SRDF file {file}"))


def _vector(values: Any, where: str) -> Array:
    try:
        vector = np.array(values, float)
    except (TypeError, ValueError):
        vector = np.array(math.nan)
    if vector.shape != (3,) or not (np.abs(vector) < 1e100).all():
        raise InputError(f"{where}: got {received(values)}, need three finite numbers.")
    return vector
