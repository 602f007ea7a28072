"""The subject of answers about a contact of a robot: file, base, contact, surface and pose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from painleve_sym.arrays import Array
from painleve_sym.robots.dynamics import BASE, RobotDynamics


@dataclass(frozen=True, eq=False)
class ContactSubject:
    """A contact of a robot at a pose, as answers name it.

    Attributes
    ----------
    dynamics : RobotDynamics
    values : mapping of str to float
        Every argument of its functions.
    axes : ndarray, shape (3, 3)
        Normal and both tangents in the axes of the world.
    stuck : bool
        Whether the other contacts do not accelerate.
    file : str
    pose : str or None
        Name of a pose of the file.
    """

    dynamics: RobotDynamics
    values: Mapping[str, float]
    axes: Array
    stuck: bool
    file: str
    pose: str | None

    def to_dict(self) -> dict[str, Any]:
        """Return plain data in SI units; joints have their names in the file."""
        dynamics, tree = self.dynamics, self.dynamics.tree
        first, *others = dynamics.contacts
        normal, tangent, across = (self.axes + 0.0).tolist()
        own = dynamics.coordinates
        return {
            "file": self.file,
            "robot": tree.name,
            "base": "floating" if tree.floating else "fixed",
            "base_reason": tree.base,
            "contact": first.frame,
            "point": [v + 0.0 for v in first.point.tolist()],
            "radius": first.radius,
            "normal": normal,
            "tangents": [tangent, across],
            "others": {c.frame: "stuck" if self.stuck else "free" for c in others},
            "pose": self.pose,
            "joints": {name: float(self.values[own[name]]) + 0.0 for name in tree.joints},
            "base_angles": [self.values[n] + 0.0 for n in BASE[3:]] if tree.floating else None,
            "locked": [name for name in tree.joints if name in dynamics.locked],
            "armature": {n: j.armature for n, j in tree.joints.items() if j.armature}
            | ({"floating base": tree.base_armature} if tree.base_armature else {}),
            "gravity": tree.gravity.tolist(),
        }

    @property
    def rows(self) -> list[tuple[str, str]]:
        """Names and texts of all this, for people."""
        data = self.to_dict()
        where = f"point {_listed(data['point'])} m of its frame"
        if data["radius"]:
            where = f"ball of radius {data['radius']:g} m about {where}"
        tangents = ", ".join(_listed(axis) for axis in data["tangents"])
        rows = [
            ("file", data["file"] or "none"),
            ("base", data["base_reason"] or f"The base is {data['base']}."),
            ("contact", f"{data['contact']}, {where}"),
            ("normal", f"{_listed(data['normal'])} in the world, t1 and t2 {tangents}"),
        ]
        if data["others"]:
            listed = ", ".join(f"{name} {kind}" for name, kind in data["others"].items())
            rows.append(("others", listed))
        named = data["pose"] or "none named"
        rows.append(("pose", f"{named}: {_assigned(data['joints']) or 'no joints'}"))
        if data["base_angles"] is not None:
            rows.append(
                ("tilt", f"roll, pitch, yaw of the base {_listed(data['base_angles'])} rad")
            )
        rows.append(("locked", ", ".join(data["locked"]) or "no joint"))
        rows.append(("armature", _assigned(data["armature"]) or "no rotor inertia"))
        return rows

    @property
    def sentence(self) -> str:
        """Return file, base, contacts, surface and locked joints in words."""
        data, rows = self.to_dict(), dict(self.rows)
        locked = f" Locked: {rows['locked']}." if data["locked"] else ""
        others = f" Other contacts: {rows['others']}." if data["others"] else ""
        armature = f" Rotor inertia: {rows['armature']}." if data["armature"] else ""
        return (
            f"Robot of {rows['file']}. {rows['base']} Contact {rows['contact']}; "
            f"normal {rows['normal']}.{others}{locked}{armature}"
        )


def _listed(values: list[float]) -> str:
    """Return numbers for people, in parentheses."""
    return f"({', '.join(f'{v + 0.0:.6g}' for v in values)})"


def _assigned(values: Mapping[str, float]) -> str:
    """Return ``name = number`` entries."""
    return ", ".join(f"{name} = {value + 0.0:.6g}" for name, value in values.items())
