"""Reader of MJCF, the files of MuJoCo: bodies, joints, inertias, sites and keyframes as a tree.

Defaults and classes, frames, orientations in every notation and inertias from primitive geoms are
read as MuJoCo does. Constraints that close chains are not part of a tree: a notice names them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.robots.tree import (
    MASSLESS,
    MAX_BODIES,
    SAME_PLACE,
    Body,
    Frame,
    Joint,
    JointKind,
    Place,
    Pose,
    RobotTree,
    Solid,
    cleaned,
    inertia_fault,
    joined,
    rotation_axis,
    rotation_quaternion,
    unit_vector,
)
from painleve_sym.robots.xml_text import label, number_list, one_number

_KINDS = {"hinge": JointKind.REVOLUTE, "slide": JointKind.PRISMATIC}
_AXES = {"x": 0, "y": 1, "z": 2}
_MASSLESS_SHAPES = {"plane", "hfield", "sdf"}


@dataclass(frozen=True, eq=False)
class _Settings:
    """Settings of the element ``compiler``, and the default attributes of every class."""

    where: str
    radians: bool
    sequence: str
    autolimits: bool
    from_geoms: str
    groups: tuple[float, float]
    classes: Mapping[str, Mapping[str, Mapping[str, str]]]

    def angle(self, value: float) -> float:
        """Return an angle of the file in rad."""
        return value if self.radians else math.radians(value)

    def full(self, element: Element, childclass: str) -> Element:
        """Return an element with the attributes of its class where it has none of its own."""
        name = element.get("class") or childclass
        if name not in self.classes:
            raise InputError(
                f"{self.where}: {label(element)}: "
                + unknown_name("default class", name, [c for c in self.classes if c])
            )
        defaults = self.classes[name].get(element.tag, {})
        return Element(element.tag, {**defaults, **element.attrib})


def mjcf_tree(root: Element, where: str, floating: bool | None) -> RobotTree:
    """Return the robot of an MJCF file.

    Parameters
    ----------
    root : Element
        The element ``mujoco``.
    where : str
        Begins messages.
    floating : bool, optional
        Whether the base moves freely, by default whether a body has a free joint.

    Raises
    ------
    InputError
        What is missing, not supported, or not an inertia.
    """
    if next(root.iter("include"), None) is not None:
        raise InputError(
            f"{where}: includes another file, which is not read. Fix: give the file of the robot "
            "itself, or what MuJoCo writes of the whole (mj_saveLastXML)."
        )
    settings = _settings(root, where)
    worlds = root.findall("worldbody")
    moving = [body for world in worlds for body in world.findall("body") if _moves(body)]
    framed = [f for world in worlds for f in world.findall("frame")]
    free = [body for body in moving if _has_free_joint(body)]
    if len(free) > 1 or (free and len(moving) > 1):
        raise InputError(
            f"{where}: {len(moving)} bodies of the world move, need one robot. "
            "Fix: remove the others."
        )
    floating, base = _base(floating, free)
    reading = _Reading(settings)
    if floating:
        if len(moving) != 1 or framed:
            raise InputError(
                f"{where}: a floating base is the one body of the world that moves, got "
                f"{len(moving)}."
            )
        reading.body(moving[0], "", -1)
    else:
        reading.bodies.append(Body("world", -1, *SAME_PLACE))
        reading.frames["world"] = Frame(0, *SAME_PLACE)
        for world in worlds:
            reading.children(world, "", 0)
    option = root.find("option")
    gravity = [0.0, 0.0, -9.81]
    if option is not None:
        gravity = number_list(option, "gravity", where, gravity, 3)
    notices = [
        f"The file has <{e.tag}> constraints, which close chains or couple joints; the tree, and "
        "so every mobility, is without them."
        for group in root.findall("equality")
        for e in list(group)[:1]
    ]
    tree = RobotTree(
        root.get("model", "") or "robot",
        tuple(reading.bodies),
        {**reading.others, **reading.frames},
        floating,
        gravity=np.array(gravity),
        notices=tuple(notices),
        base=base,
    )
    names = [b.joint.name for b in tree.bodies if b.joint is not None]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"{where}: two joints are called {twice!r}. Fix: rename one.")
    return replace(tree, poses=_keyframes(root, tree, bool(free), where))


def _base(asked: bool | None, free: list[Element]) -> tuple[bool, str]:
    """Return whether the base floats, and a sentence that says why."""
    if asked is not None:
        return asked, f"The base {'floats' if asked else 'is fixed'} as asked."
    if free:
        return True, f"The base floats: {label(free[0])} of the file has a free joint."
    return False, "The base is fixed: no body of the file has a free joint."


def _moves(body: Element) -> bool:
    return any(next(body.iter(tag), None) is not None for tag in ("joint", "freejoint"))


def _has_free_joint(body: Element) -> bool:
    return any(e.tag == "freejoint" or (e.tag == "joint" and e.get("type") == "free") for e in body)


def _settings(root: Element, where: str) -> _Settings:
    merged: dict[str, str] = {}
    for element in root.findall("compiler"):
        merged |= element.attrib
    compiler = Element("compiler", merged)
    if merged.get("coordinate", "local") != "local":
        raise InputError(f"{where}: compiler: coordinate is not local, which MuJoCo dropped.")
    sequence = merged.get("eulerseq", "xyz")
    if len(sequence) != 3 or not set(sequence.lower()) <= set(_AXES):
        raise InputError(f"{where}: compiler: eulerseq = {sequence!r}, need three of x, y, z.")
    classes: dict[str, dict[str, dict[str, str]]] = {"": {}}

    def add(element: Element, above: dict[str, dict[str, str]], name: str) -> None:
        own = {tag: dict(values) for tag, values in above.items()}
        for child in element:
            if child.tag != "default":
                own[child.tag] = {**own.get(child.tag, {}), **child.attrib}
        classes[name] = own
        for child in element.findall("default"):
            inner = child.get("class", "")
            if not inner:
                raise InputError(f"{where}: a default within another one has no class.")
            add(child, own, inner)

    for top in root.findall("default"):
        add(top, classes[""], "")
        classes[top.get("class", "main")] = classes[""]
    low, high = number_list(compiler, "inertiagrouprange", where, (0.0, 5.0), 2)
    return _Settings(
        where,
        merged.get("angle", "degree") == "radian",
        sequence,
        merged.get("autolimits", "true") != "false",
        merged.get("inertiafromgeom", "auto"),
        (low, high),
        classes,
    )


def _rotation(element: Element, s: _Settings) -> Array:
    """Return the orientation of an element, in any of the notations."""
    where = f"{s.where}: {label(element)}"
    if "quat" in element.attrib:
        return rotation_quaternion(number_list(element, "quat", s.where, None, 4), where)
    if "axisangle" in element.attrib:
        *axis, angle = number_list(element, "axisangle", s.where, None, 4)
        return rotation_axis(unit_vector(axis, f"{where}: axisangle"), s.angle(angle))
    if "euler" in element.attrib:
        R = np.eye(3)
        angles = number_list(element, "euler", s.where, None, 3)
        for letter, angle in zip(s.sequence, angles, strict=True):
            turn = rotation_axis(np.eye(3)[_AXES[letter.lower()]], s.angle(angle))
            # Small letters are axes that turn along, capitals fixed ones.
            R = R @ turn if letter.islower() else turn @ R
        return cleaned(R)
    if "xyaxes" in element.attrib:
        values = number_list(element, "xyaxes", s.where, None, 6)
        x = unit_vector(values[:3], f"{where}: xyaxes")
        y = np.array(values[3:])
        y = unit_vector(y - (y @ x) * x, f"{where}: xyaxes")
        return cleaned(np.column_stack([x, y, np.cross(x, y)]))
    if "zaxis" in element.attrib:
        return _to_z(unit_vector(number_list(element, "zaxis", s.where, None, 3), where))
    return np.eye(3)


def _to_z(z: Array) -> Array:
    """Return the smallest rotation that turns the axis z to a unit vector."""
    axis = np.cross([0.0, 0.0, 1.0], z)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-10:
        return np.eye(3) if z[2] > 0 else np.diag([1.0, -1.0, -1.0])
    return rotation_axis(axis / sine, math.atan2(sine, float(z[2])))


def _position(element: Element, s: _Settings) -> Array:
    return np.array(number_list(element, "pos", s.where, (0.0, 0.0, 0.0), 3))


@dataclass(eq=False)
class _Reading:
    """Bodies and frames read so far."""

    settings: _Settings
    bodies: list[Body] = field(default_factory=list)
    frames: dict[str, Frame] = field(default_factory=dict)
    others: dict[str, Frame] = field(default_factory=dict)

    def children(
        self, parent: Element, childclass: str, index: int, at: Place = SAME_PLACE
    ) -> None:
        """Read bodies, sites and geoms; `at` is the frame they stand in, in the body's frame."""
        s, (R, p) = self.settings, at
        for element in parent:
            if element.tag == "body":
                self.body(element, childclass, index, at)
            elif element.tag == "frame":
                inner = R @ _rotation(element, s), p + R @ _position(element, s)
                self.children(element, element.get("childclass") or childclass, index, inner)
            elif element.tag in ("site", "geom"):
                full = s.full(element, childclass)
                if (name := element.get("name")) and full.get("type", "") != "mesh":
                    turned, place, _ = _shape(full, s)
                    frame = Frame(index, cleaned(R @ turned), p + R @ place)
                    self.others.setdefault(name, frame)
            elif element.tag in ("composite", "flexcomp", "attach", "replicate"):
                raise InputError(
                    f"{s.where}: {label(element)} makes bodies that are not written in the file. "
                    "Fix: give what MuJoCo writes of the whole (mj_saveLastXML)."
                )

    def body(self, element: Element, childclass: str, parent: int, at: Place | None = None) -> None:
        """Read a body with all that it carries; without `at` it is a base that floats."""
        s = self.settings
        own = element.get("childclass") or childclass
        name = element.get("name") or f"body_{len(self.bodies)}"
        if len(self.bodies) >= MAX_BODIES:
            raise InputError(f"{s.where}: got more than {MAX_BODIES} bodies.")
        if name in self.frames:
            raise InputError(f"{s.where}: two bodies are called {name!r}. Fix: rename one.")
        rotation, position = _rotation(element, s), _position(element, s)
        if at is None:
            (rotation, position), joints = SAME_PLACE, []
            if any(e.tag == "joint" and e.get("type") != "free" for e in element):
                raise InputError(
                    f"{s.where}: {label(element)}: the base has joints besides a free one."
                )
        else:
            rotation, position = cleaned(at[0] @ rotation), at[1] + at[0] @ position
            joints = _joints(element, s, own, len(self.bodies))
        for joint, anchor in joints:
            # A joint turns about its anchor; the body's frame comes back after it.
            position = position + rotation @ anchor
            self.bodies.append(Body(f"{name}/{joint.name}", parent, rotation, position, joint))
            parent, rotation, position = len(self.bodies) - 1, np.eye(3), -anchor
        solid = _inertia(element, s, own)
        self.bodies.append(Body(name, parent, rotation, position, None, *solid))
        index = len(self.bodies) - 1
        self.frames[name] = Frame(index, *SAME_PLACE)
        self.children(element, own, index)


def _joints(body: Element, s: _Settings, childclass: str, index: int) -> list[tuple[Joint, Array]]:
    joints = []
    for number, element in enumerate(e for e in body if e.tag == "joint"):
        full = s.full(element, childclass)
        kind = full.get("type", "hinge")
        if kind == "free":
            continue
        if kind not in _KINDS:
            raise InputError(
                f"{s.where}: {label(element)} is of type {kind!r}, need hinge or slide. "
                "Fix: write it as several joints of one degree of freedom."
            )
        turns = kind == "hinge"
        lower, upper = -math.inf, math.inf
        limited = full.get("limited", "auto")
        if limited == "true" or (limited == "auto" and s.autolimits and "range" in full.attrib):
            lower, upper = number_list(full, "range", s.where, (0.0, 0.0), 2)
            if not lower <= upper:
                raise InputError(
                    f"{s.where}: {label(element)}: range {lower:g} to {upper:g}, need "
                    "lower <= upper."
                )
        reference = one_number(full, "ref", s.where, 0.0)
        armature = one_number(full, "armature", s.where, 0.0)
        if not armature >= 0:
            raise InputError(f"{s.where}: {label(element)}: armature {armature:g}, need >= 0.")
        values = (lower, upper, reference)
        lower, upper, reference = map(s.angle, values) if turns else values
        axis = number_list(full, "axis", s.where, (0.0, 0.0, 1.0), 3)
        joint = Joint(
            element.get("name") or f"joint_{index + number}",
            _KINDS[kind],
            unit_vector(axis, f"{s.where}: {label(element)}: axis"),
            lower,
            upper,
            armature,
            reference,
        )
        joints.append((joint, _position(full, s)))
    return joints


def _inertia(body: Element, s: _Settings, childclass: str) -> Solid:
    inertial = body.find("inertial")
    if inertial is not None and s.from_geoms != "true":
        mass, center = one_number(inertial, "mass", s.where), _position(inertial, s)
        if "fullinertia" in inertial.attrib:
            values = number_list(inertial, "fullinertia", s.where, None, 6)
            xx, yy, zz, xy, xz, yz = values
            inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        else:
            inertia = np.diag(number_list(inertial, "diaginertia", s.where, None, 3))
        R = _rotation(inertial, s)
        inertia = R @ inertia @ R.T
    elif s.from_geoms == "false":
        return MASSLESS
    else:
        mass, center, inertia = _geom_inertia(body, s, childclass)
    if fault := inertia_fault(mass, inertia):
        raise InputError(f"{s.where}: {label(body)} has {fault}.")
    return mass, center, inertia


def _geom_inertia(body: Element, s: _Settings, childclass: str) -> Solid:
    """Return mass, centre and inertia of the geoms of a body, all of primitive shapes."""
    parts = _parts(body, s, childclass, *SAME_PLACE)
    return joined(parts) if sum(mass for mass, _, _ in parts) > 0 else MASSLESS


def _parts(body: Element, s: _Settings, childclass: str, R: Array, p: Array) -> list[Solid]:
    parts = []
    for element in body:
        if element.tag == "frame":
            inner = R @ _rotation(element, s), p + R @ _position(element, s)
            parts += _parts(element, s, element.get("childclass") or childclass, *inner)
        if element.tag != "geom":
            continue
        full = s.full(element, childclass)
        shape = full.get("type", "sphere")
        group = one_number(full, "group", s.where, 0.0)
        given = "mass" in full.attrib
        mass = one_number(full, "mass", s.where, 0.0)
        density = one_number(full, "density", s.where, 1000.0)
        weightless = (mass == 0) if given else (density == 0)
        if weightless or not s.groups[0] <= group <= s.groups[1] or shape in _MASSLESS_SHAPES:
            continue
        if shape == "mesh" or full.get("mesh") is not None:
            raise InputError(
                f"{s.where}: {label(body)} takes its inertia from a mesh, which is not read. "
                "Fix: give it <inertial>, as mj_saveLastXML of MuJoCo writes it."
            )
        if full.get("shellinertia", "false") == "true":
            raise InputError(f"{s.where}: {label(element)}: shellinertia is not supported.")
        turned, place, size = _shape(full, s)
        volume, moments = _solid(shape, size, f"{s.where}: {label(element)}")
        mass = mass if given else density * volume
        turned = R @ turned
        parts.append((mass, p + R @ place, turned @ np.diag(mass * moments) @ turned.T))
    return parts


def _shape(element: Element, s: _Settings) -> tuple[Array, Array, list[float]]:
    """Return orientation, place and size of a geom or site."""
    size = number_list(element, "size", s.where, ())
    if "fromto" not in element.attrib:
        return _rotation(element, s), _position(element, s), size
    values = np.array(number_list(element, "fromto", s.where, None, 6))
    along = values[3:] - values[:3]
    length = float(np.linalg.norm(along))
    # MuJoCo's z axis of such a geom points back, from the second end to the first.
    axis = unit_vector(-along, f"{s.where}: {label(element)}: fromto")
    half = length / 2
    round_shape = element.get("type", "sphere") in ("capsule", "cylinder")
    sized = [*size[:1], half] if round_shape else [*size[:1], *size[:1], half]
    return _to_z(axis), (values[:3] + values[3:]) / 2, sized


def _solid(shape: str, size: list[float], where: str) -> tuple[float, Array]:
    """Return volume and principal moments per mass of a solid, which is that of MuJoCo's geom."""
    need = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
    if shape not in need:
        raise InputError(f"{where}: {unknown_name('type', shape, [*need, 'plane', 'mesh'])}")
    if len(size) < need[shape] or not all(value > 0 for value in size[: need[shape]]):
        raise InputError(f"{where}: size = {size}, need {need[shape]} numbers > 0.")
    if shape in ("box", "ellipsoid"):
        squares = np.array(size[:3]) ** 2
        factor, volume = (1 / 3, 8.0) if shape == "box" else (1 / 5, 4 * math.pi / 3)
        return volume * math.prod(size[:3]), factor * (squares.sum() - squares)
    r = size[0]
    if shape == "sphere":
        return 4 / 3 * math.pi * r**3, np.full(3, 2 / 5 * r * r)
    half = size[1]
    tube = 2 * math.pi * r * r * half
    across, along = r * r / 4 + half * half / 3, r * r / 2
    if shape == "cylinder":
        return tube, np.array([across, across, along])
    caps = 4 / 3 * math.pi * r**3
    # Two half balls: their centres are 3 r/8 beyond the ends of the tube.
    ball = 2 / 5 * r * r + half * half + 3 / 4 * half * r
    whole = tube + caps
    sideways = (tube * across + caps * ball) / whole
    return whole, np.array([sideways, sideways, (tube * along + caps * 2 / 5 * r * r) / whole])


def _keyframes(root: Element, tree: RobotTree, free: bool, where: str) -> dict[str, Pose]:
    names = tuple(tree.joints)
    begin = 7 if free else 0
    poses: dict[str, Pose] = {}
    for group in root.findall("keyframe"):
        for number, key in enumerate(group.findall("key")):
            if "qpos" not in key.attrib:
                continue
            values = number_list(key, "qpos", where, None)
            if len(values) != begin + len(names):
                raise InputError(
                    f"{where}: {label(key)}: qpos has {len(values)} numbers, need "
                    f"{begin + len(names)}."
                )
            base: Any = tuple(values[3:7]) if free else (1.0, 0.0, 0.0, 0.0)
            joints = dict(zip(names, values[begin:], strict=True))
            poses[key.get("name") or f"key_{number}"] = Pose(joints, base)
    return poses
