"""Reader of MJCF, the files of MuJoCo: bodies, joints, inertias, sites and keyframes as a tree.

Defaults and classes, frames, orientations in every notation and inertias from primitive geoms are
read as MuJoCo does. What else changes a contact is a notice or an error, by the table of `formats`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError
from painleve_sym.robots.formats import MJCF, Rule, called, paths, review
from painleve_sym.robots.mjcf_inertia import body_inertia, is_mesh, parts_of, shape
from painleve_sym.robots.mjcf_settings import Settings, read_settings
from painleve_sym.robots.tree import (
    MAX_BODIES,
    SAME_PLACE,
    Frame,
    Joint,
    JointKind,
    Place,
    Pose,
    RobotTree,
    TreeBody,
    cleaned,
    inertia_doubt,
    quaternion_of,
    unit_vector,
)
from painleve_sym.robots.xml_text import label, number_list, one_number

_KINDS = {"hinge": JointKind.REVOLUTE, "slide": JointKind.PRISMATIC}
_DEFAULTS = {"tendon": "tendon", "equality": "equality"}
"""Tags of the defaults of a section, where they are not those of its elements."""


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
        own = MJCF["include"]
        assert isinstance(own, Rule)
        raise InputError(f"{where}: {own.sentence}")
    settings = read_settings(root, where)
    elements = list(_elements(root, settings))
    notices = review(elements, MJCF, where, settings.off)
    top = [part for world in root.findall("worldbody") for part in _bodies(world, settings, "")]
    moving = [part for part in top if _moves(part[0])]
    free = [part for part in moving if _free_joint(part[0], settings, part[1]) is not None]
    _one_robot(moving, free, settings)
    floating, base = _base(floating, [body for body, _, _ in free])
    reading = _Reading(settings, _drives(root, settings))
    if floating:
        if len(moving) != 1:
            raise InputError(
                f"{where}: a floating base is the one body of the world that moves, got "
                f"{len(moving)}."
            )
        reading.body(*moving[0], -1, floats=True)
    else:
        reading.worlds(root)
    of_base = _free_base(moving[0], reading) if floating else {}
    tree = RobotTree(
        name=root.get("model", "") or "robot",
        bodies=tuple(_scaled(reading, root)),
        frames=reading.frames,
        floating=floating,
        gravity=np.array(settings.gravity),
        notices=(*notices, *reading.notices),
        base=base,
        ambiguous=reading.ambiguous,
        opened="equality" not in settings.off
        and any(path.startswith("equality/") for path, _, _ in elements),
        **of_base,
    )
    names = [b.joint.name for b in tree.bodies if b.joint is not None]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"{where}: two joints are called {twice!r}. Fix: rename one.")
    return replace(tree, poses=_keyframes(root, tree, bool(free), where))


def _elements(root: Element, s: Settings) -> Iterator[tuple[str, Element, str]]:
    """Yield path, element with class defaults, and label in notices of every relevant element."""
    classes, aligns = _classes_of(root), _aligns(root, s)
    for path, element, _ in paths(root, MJCF):
        section = path.partition("/")[0]
        full, name = element, called(element)
        if path in ("body/joint", "body/geom", "body/site"):
            full = s.full(element, classes.get(element, ""))
        elif section in _DEFAULTS and path.count("/") == 1:
            full = s.full(element, "", _DEFAULTS[section])
        elif section == "actuator" and path.count("/") == 1:
            full = s.drive(element)
            if "joint" not in full.attrib:
                yield "tendon/fixed", _only(full, "armature", "damping"), name
        if full.get("active") == "false":
            continue
        if path == "body/joint" and full.get("type") == "free":
            path = "body/free"
        if path in ("compiler", "body/freejoint") and not aligns:
            full = Element(full.tag, {k: v for k, v in full.items() if k[:5] != "align"})
        yield path, full, name


def _only(element: Element, *keys: str) -> Element:
    return Element(element.tag, {k: v for k, v in element.items() if k in keys})


def _classes_of(root: Element) -> dict[Element, str]:
    """Return the default class of each element of the worlds, as bodies and frames spread it."""
    classes: dict[Element, str] = {}
    waiting = [(world, "") for world in root.findall("worldbody")]
    while waiting:
        element, name = waiting.pop()
        for child in element:
            classes[child] = name
            waiting.append((child, child.get("childclass") or name))
    return classes


def _aligns(root: Element, s: Settings) -> bool:
    """Return whether a free body has no body in it: only frames of such ones are aligned."""
    top = [part for world in root.findall("worldbody") for part in _bodies(world, s, "")]
    return any(
        _free_joint(body, s, name) is not None and not list(_bodies(body, s, name))
        for body, name, _ in top
    )


def _bodies(element: Element, s: Settings, childclass: str) -> Iterator[tuple[Element, str, Place]]:
    """Yield the bodies in an element, with class and the frame that they stand in."""
    return (part for part in parts_of(element, s, childclass) if part[0].tag == "body")


def _base(asked: bool | None, free: list[Element]) -> tuple[bool, str]:
    """Return whether the base floats, and a sentence that says why."""
    if asked is not None:
        return asked, f"The base {'floats' if asked else 'is fixed'} as asked."
    if free:
        return True, f"The base floats: {label(free[0])} of the file has a free joint."
    return False, "The base is fixed: no body of the file has a free joint."


def _one_robot(
    moving: list[tuple[Element, str, Place]], free: list[tuple[Element, str, Place]], s: Settings
) -> None:
    """InputError where a body moves freely beside others, or within another one."""
    if len(free) > 1 or (free and len(moving) > 1):
        raise InputError(
            f"{s.where}: {len(moving)} bodies of the world move, need one robot, got "
            f"{', '.join(label(body) for body, _, _ in moving[:3])}. "
            "Fix: remove the others, or their joints."
        )


def _moves(body: Element) -> bool:
    return any(next(body.iter(tag), None) is not None for tag in ("joint", "freejoint"))


def _free_joint(body: Element, s: Settings, childclass: str) -> Element | None:
    """Return the free joint of a body, with the attributes of its class."""
    for element, name, _ in parts_of(body, s, body.get("childclass") or childclass):
        if element.tag == "freejoint":
            return element
        if element.tag == "joint":
            full = s.full(element, name)
            if full.get("type") == "free":
                return full
    return None


def _free_base(part: tuple[Element, str, Place], reading: _Reading) -> dict[str, Any]:
    """Return orientation, armature and damping of a floating base."""
    s, (body, childclass, at) = reading.settings, part
    turned = {"orientation": quaternion_of(s.place(body, at)[0])}
    joint = _free_joint(body, s, childclass)
    if joint is None:
        return turned
    armature = one_number(joint, "armature", s.where, 0.0)
    if not armature >= 0:
        raise InputError(f"{s.where}: {label(joint)}: armature {armature:g}, need >= 0.")
    damping, *more = [0.0] if "damper" in s.off else _damping(joint, s)
    if any(more):
        reading.notices.append(
            "The damper of a free joint is taken as linear; its further coefficients are not read: "
            f"{called(joint)}."
        )
    return turned | {"base_armature": armature, "base_damping": damping}


def _damping(joint: Element, s: Settings) -> list[float]:
    return number_list(joint, "damping", s.where, ()) or [0.0]


def _drives(root: Element, s: Settings) -> dict[str, tuple[float, list[float]]]:
    """Return armature and damping that actuators give to joints, by the joints' names."""
    given: dict[str, tuple[float, list[float]]] = {}
    for element in root.iterfind("actuator/*"):
        full = s.drive(element)
        name = full.get("joint")
        if name is None:
            continue
        gear = number_list(full, "gear", s.where, (1.0,))[:1] or [1.0]
        armature, damping = given.get(name, (0.0, []))
        armature += gear[0] ** 2 * one_number(full, "armature", s.where, 0.0)
        own = [gear[0] ** 2 * d for d in number_list(full, "damping", s.where, ())]
        given[name] = armature, _added(damping, own)
    return given


def _added(a: Sequence[float], b: Sequence[float]) -> list[float]:
    size = max(len(a), len(b))
    return [sum(x[k] for x in (a, b) if k < len(x)) for k in range(size)]


@dataclass(eq=False)
class _Reading:
    """Bodies and places read so far."""

    settings: Settings
    drives: dict[str, tuple[float, list[float]]]
    bodies: list[TreeBody] = field(default_factory=list)
    places: dict[str, dict[str, Frame]] = field(
        default_factory=lambda: {"body": {}, "geom": {}, "site": {}}
    )
    notices: list[str] = field(default_factory=list)

    @property
    def frames(self) -> dict[str, Frame]:
        """Frames by name; a name of several has the kind of element before it."""
        frames: dict[str, Frame] = {}
        for name, several in self._by_name().items():
            one = next(iter(several.values()))
            same = all(_same_frame(one, other) for other in several.values())
            frames |= {name: one} if same else {f"{k}:{name}": f for k, f in several.items()}
        return frames

    @property
    def ambiguous(self) -> dict[str, tuple[str, ...]]:
        """Names of several places."""
        several = {n: tuple(f"{k}:{n}" for k in kinds) for n, kinds in self._by_name().items()}
        frames = self.frames
        return {name: names for name, names in several.items() if name not in frames}

    def _by_name(self) -> dict[str, dict[str, Frame]]:
        names: dict[str, dict[str, Frame]] = {}
        for kind in ("geom", "site", "body"):
            for name, frame in self.places[kind].items():
                names.setdefault(name, {})[kind] = frame
        return names

    def add(self, kind: str, name: str, frame: Frame) -> None:
        """Add a place; InputError where another one of its kind has its name."""
        if name in self.places[kind]:
            plural = "bodies" if kind == "body" else f"{kind}s"
            raise InputError(
                f"{self.settings.where}: two {plural} are called {name!r}. Fix: rename one."
            )
        self.places[kind][name] = frame

    def worlds(self, root: Element) -> None:
        """Read all that stands in the world, which is the base."""
        self.bodies.append(TreeBody("world", -1, *SAME_PLACE))
        self.add("body", "world", Frame(0, *SAME_PLACE))
        for world in root.findall("worldbody"):
            self.children(world, "", 0, moves=False)

    def children(self, parent: Element, childclass: str, index: int, moves: bool) -> None:
        """Read the bodies, sites and geoms of a body."""
        s = self.settings
        for element, name, at in parts_of(parent, s, childclass):
            if element.tag == "body":
                if parent.tag == "body" and _free_joint(element, s, name) is not None:
                    raise InputError(
                        f"{s.where}: {label(element)} has a free joint within another body, need "
                        "it on a body of the world."
                    )
                self.body(element, name, at, index, moves)
            elif element.tag in ("site", "geom") and (own := element.get("name")):
                full = s.full(element, name)
                if not is_mesh(full):
                    (turned, place), _ = shape(full, s)
                    frame = Frame(index, cleaned(at[0] @ turned), at[1] + at[0] @ place)
                    self.add(element.tag, own, frame)

    def body(
        self,
        element: Element,
        childclass: str,
        at: Place,
        parent: int,
        moves: bool = True,
        floats: bool = False,
    ) -> None:
        """Read a body with all that it carries, which stands in the frame `at`."""
        s, where = self.settings, f"{self.settings.where}: {label(element)}"
        own = element.get("childclass") or childclass
        name = element.get("name") or f"body_{len(self.bodies)}"
        if len(self.bodies) >= MAX_BODIES:
            raise InputError(f"{s.where}: got more than {MAX_BODIES} bodies.")
        joints = _joints(element, self, own)
        rotation, position = s.place(element, at)
        solid = body_inertia(element, s, own, position, moves or bool(joints) or s.total_mass > 0)
        if floats:
            rotation, position = SAME_PLACE
        if floats and joints:
            raise InputError(f"{where}: the base has joints besides a free one.")
        for joint, anchor in joints:
            # A joint turns about its anchor; the body's frame comes back after it.
            position = position + rotation @ anchor
            self.bodies.append(TreeBody(f"{name}/{joint.name}", parent, rotation, position, joint))
            parent, rotation, position = len(self.bodies) - 1, np.eye(3), -anchor
        moves = moves or bool(joints)
        mass, center, inertia = solid
        if moves and (doubt := inertia_doubt(mass, inertia)):
            self.notices.append(f"{called(element).capitalize()} has {doubt}.")
        held = 0.0 if {"spring", "damper"} <= s.off else mass
        held *= one_number(element, "gravcomp", s.where, 0.0)
        compensated = held * np.array([1.0, *center])
        self.bodies.append(TreeBody(name, parent, rotation, position, None, *solid, compensated))
        index = len(self.bodies) - 1
        self.add("body", name, Frame(index, *SAME_PLACE))
        self.children(element, own, index, moves)


def _same_frame(a: Frame, b: Frame) -> bool:
    same = np.array_equal(a.rotation, b.rotation) and np.array_equal(a.position, b.position)
    return a.body == b.body and same


def _scaled(reading: _Reading, root: Element) -> list[TreeBody]:
    """Return the bodies with the total mass that the file asks for, of all that it has."""
    wanted = reading.settings.total_mass
    if not wanted > 0:
        return reading.bodies
    whole = _Reading(reading.settings, reading.drives)
    whole.worlds(root)
    total = sum(body.mass for body in whole.bodies)
    if reading.settings.fuses and total - sum(_carried(reading.bodies)) > 1e-12 * total:
        raise InputError(
            f"{reading.settings.where}: compiler: settotalmass counts what stands still, and "
            "fusestatic takes it away. Fix: leave out one of the two."
        )
    if not total > 0:
        raise InputError(f"{reading.settings.where}: settotalmass needs a body with mass.")
    k = wanted / total
    return [
        replace(b, mass=k * b.mass, inertia=k * b.inertia, compensated=k * b.compensated)
        for b in reading.bodies
    ]


def _carried(bodies: Sequence[TreeBody]) -> Iterator[float]:
    """Yield the masses of the bodies that move; all of them where the base floats."""
    moves = [bodies[0].name != "world"]
    for body in bodies[1:]:
        moves.append(body.joint is not None or moves[body.parent])
    return (body.mass for body, moving in zip(bodies, moves, strict=True) if moving)


def _joints(body: Element, reading: _Reading, childclass: str) -> list[tuple[Joint, Array]]:
    """Return the joints of a body with their anchors, in its frame."""
    s = reading.settings
    joints: list[tuple[Joint, Array]] = []
    for element, name, (R, p) in parts_of(body, s, childclass):
        if element.tag != "joint":
            continue
        full = s.full(element, name)
        kind = full.get("type", "hinge")
        if kind == "free":
            continue
        where = f"{s.where}: {label(element)}"
        if kind not in _KINDS:
            raise InputError(
                f"{where} is of type {kind!r}, need hinge or slide. "
                "Fix: write it as several joints of one degree of freedom."
            )
        own = element.get("name") or f"joint_{len(reading.bodies) + len(joints)}"
        armature, damping = reading.drives.get(element.get("name", ""), (0.0, []))
        armature += one_number(full, "armature", s.where, 0.0)
        if not armature >= 0:
            raise InputError(f"{where}: armature {armature:g}, need >= 0.")
        angle: Callable[[float], float] = s.angle if kind == "hinge" else float
        lower, upper = _limits(full, s)
        axis = number_list(full, "axis", s.where, (0.0, 0.0, 1.0), 3)
        joint = Joint(
            name=own,
            kind=_KINDS[kind],
            axis=cleaned(R @ unit_vector(axis, f"{where}: axis")),
            lower=angle(lower),
            upper=angle(upper),
            armature=armature,
            reference=angle(one_number(full, "ref", s.where, 0.0)),
            stiffness=_passive(full, s, "stiffness", "spring"),
            spring_reference=angle(one_number(full, "springref", s.where, 0.0)),
            damping=_passive(full, s, "damping", "damper", damping),
            friction=0.0
            if "frictionloss" in s.off
            else one_number(full, "frictionloss", s.where, 0.0),
        )
        joints.append((joint, p + R @ s.position(full)))
    return joints


def _limits(joint: Element, s: Settings) -> tuple[float, float]:
    """Return the limits of a joint in the units of the file."""
    limited = joint.get("limited", "auto")
    if limited != "true" and not (limited == "auto" and s.autolimits and "range" in joint.attrib):
        return -math.inf, math.inf
    lower, upper = number_list(joint, "range", s.where, (0.0, 0.0), 2)
    if not lower <= upper:
        raise InputError(
            f"{s.where}: {label(joint)}: range {lower:g} to {upper:g}, need lower <= upper."
        )
    return lower, upper


def _passive(
    joint: Element, s: Settings, key: str, flag: str, more: Sequence[float] = ()
) -> tuple[float, ...]:
    """Return the coefficients of spring or damper of a joint; none where all are 0."""
    # A time constant and a ratio replace both; a notice says that these are not read.
    replaced = all(v > 0 for v in number_list(joint, "springdamper", s.where, (0.0, 0.0), 2))
    values = [] if replaced else number_list(joint, key, s.where, ())
    if len(values) > 3:
        raise InputError(f"{s.where}: {label(joint)}: {key} = {values}, need up to 3 numbers.")
    values = _added(values, more)
    return tuple(values) if any(values) and flag not in s.off else ()


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
