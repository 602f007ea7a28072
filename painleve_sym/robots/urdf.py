"""Reader of URDF: links, joints and mimic joints as a tree; named poses of an SRDF file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from painleve_sym.errors import InputError, refuse_unknown, shortened
from painleve_sym.robots.formats import URDF, called, paths, review
from painleve_sym.robots.tree import (
    MASSLESS,
    MAX_BODIES,
    SAME_PLACE,
    Frame,
    Joint,
    JointKind,
    Mimic,
    Place,
    Pose,
    RobotTree,
    Solid,
    TreeBody,
    inertia_doubt,
    inertia_fault,
    quaternion_of,
    rotation_quaternion,
    rotation_rpy,
    unit_vector,
)
from painleve_sym.robots.xml_text import label, name_of, number_list, one_number, read_elements

_KINDS = {
    "revolute": JointKind.REVOLUTE,
    "continuous": JointKind.REVOLUTE,
    "prismatic": JointKind.PRISMATIC,
}
_PARTS = ("robot/link", "robot/link/inertial", "robot/joint")
_ONCE = frozenset(
    ("inertial", "origin", "mass", "inertia", "parent", "child", "axis", "limit", "dynamics")
) | {"mimic"}
_WORLD = "world"
"""Name of a root link that does not move, by convention."""


def urdf_tree(root: Element, where: str, floating: bool | None) -> RobotTree:
    """Return the robot of a URDF file.

    Parameters
    ----------
    root : Element
        The element ``robot``.
    where : str
        Begins messages.
    floating : bool, optional
        Whether the base moves freely. URDF does not say: by default it does, unless the root link
        is called ``world`` or has no inertia.

    Raises
    ------
    InputError
        What is missing, not a tree, or not an inertia.
    """
    links = _by_name(root, "link", where)
    joints = _by_name(root, "joint", where)
    if not links:
        raise InputError(f"{where}: the robot has no link.")
    if len(links) > MAX_BODIES:
        raise InputError(f"{where}: got {len(links)} links, need at most {MAX_BODIES}.")
    children: dict[str, list[Element]] = {name: [] for name in links}
    parent_of: dict[str, str] = {}
    for joint in joints.values():
        parent, child = (_linked(joint, end, links, where) for end in ("parent", "child"))
        if child in parent_of:
            raise InputError(
                f"{where}: link {child!r} is the child of two joints, need a tree. "
                "Fix: remove one of the joints; closed chains have no URDF."
            )
        parent_of[child] = parent
        children[parent].append(joint)
    roots = [name for name in links if name not in parent_of]
    if len(roots) > 1:
        raise InputError(
            f"{where}: links {roots[0]!r} and {roots[1]!r} have no parent, need one tree."
        )
    order = list(_walk(roots[0], children)) if roots else []
    if len(order) != len(links):
        reached = {link for link, _ in order}
        left = next(name for name in links if name not in reached)
        raise InputError(f"{where}: the joints form a cycle through link {left!r}, need a tree.")
    free = _free_joint(order, links)
    order = order[free is not None :]
    index = {link: i for i, (link, _) in enumerate(order)}
    notices = list(_notices(root, where))
    bodies = []
    for link, above in order:
        placed = SAME_PLACE if above is None else _origin(above, where)
        parent_index, own = -1, None
        if above is not None and above is not free:
            parent_index, own = index[parent_of[link]], _joint(above, joints, where)
        mass, center, inertia = _inertia(links[link], where, notices)
        bodies.append(TreeBody(link, parent_index, *placed, own, mass, center, inertia))
    frames = {link: Frame(i, *SAME_PLACE) for link, i in index.items()}
    floating, base = _base(floating, free, bodies)
    orientation = quaternion_of(bodies[0].rotation)
    if floating:
        bodies[0] = replace(bodies[0], rotation=SAME_PLACE[0], position=SAME_PLACE[1])
    name = root.get("name", "") or "robot"
    tree = RobotTree(
        name=name,
        bodies=tuple(bodies),
        frames=frames,
        floating=floating,
        notices=tuple(notices),
        base=base,
        orientation=orientation,
    )
    for body in tree.merged.bodies:
        # A link may have an inertia of no body where that of all that is fixed to it is one.
        if fault := inertia_fault(body.mass, body.inertia):
            raise InputError(
                f"{where}: link {body.name!r}, with all that is fixed to it, has {fault}."
            )
    return tree


def _notices(root: Element, where: str) -> tuple[str, ...]:
    """Return notices on elements of the file that the tree ignores."""
    elements = [(path, e, _called(e, parent)) for path, e, parent in paths(root, URDF)]
    for path, element, name in elements:
        tags = [child.tag for child in element]
        for tag in set(tags) & _ONCE if path in _PARTS else ():
            if tags.count(tag) > 1:
                raise InputError(f"{where}: {name} has several <{tag}>, need one.")
    return review(elements, URDF, where)


def _called(element: Element, parent: Element) -> str:
    if parent.tag == "gazebo":
        return f"<{element.tag}> of {shortened(parent.get('reference', 'the robot'), 80)}"
    named = element if element.get("name") or not parent.get("name") else parent
    return called(named)


def _free_joint(
    order: list[tuple[str, Element | None]], links: dict[str, Element]
) -> Element | None:
    """Return the floating joint between a root link without inertia and the base, if it is so."""
    if len(order) < 2 or links[order[0][0]].find("inertial") is not None:
        return None
    joint = order[1][1]
    assert joint is not None
    parents = [e.find("parent") for _, e in order[1:] if e is not None]
    alone = sum(p is not None and p.get("link", "").strip() == order[0][0] for p in parents) == 1
    return joint if alone and joint.get("type") == "floating" else None


def _by_name(root: Element, tag: str, where: str) -> dict[str, Element]:
    elements: dict[str, Element] = {}
    for element in root.iterfind(tag):
        name = name_of(element, where)
        if name in elements:
            raise InputError(f"{where}: got two elements {label(element)}. Fix: rename one.")
        elements[name] = element
    return elements


def _linked(joint: Element, end: str, links: dict[str, Element], where: str) -> str:
    element = joint.find(end)
    if element is None:
        raise InputError(f"{where}: {label(joint)} has no {end}.")
    name = name_of(element, where, "link")
    refuse_unknown("link", name, links, f"{where}: {label(joint)}")
    return name


def _walk(root: str, children: dict[str, list[Element]]) -> Iterator[tuple[str, Element | None]]:
    """Yield links with their joints, each after its parent."""
    waiting: list[tuple[str, Element | None]] = [(root, None)]
    while waiting:
        link, joint = waiting.pop()
        yield link, joint
        for element in reversed(children[link]):
            child = element.find("child")
            assert child is not None
            waiting.append((child.get("link", "").strip(), element))


def _base(asked: bool | None, free: Element | None, bodies: list[TreeBody]) -> tuple[bool, str]:
    """Return whether the base floats, and a sentence that says why."""
    root = bodies[0].name
    if asked is not None:
        return asked, f"The base, link {root!r}, {'floats' if asked else 'is fixed'} as asked."
    if free is not None:
        return True, f"The base, link {root!r}, floats: {label(free)} of the file is floating."
    if root == _WORLD:
        return False, f"The base is fixed: the root link is called {_WORLD!r}."
    if any(body.mass > 0 for body in _fixed_to_base(bodies)):
        return True, (
            f"The base is taken to float, since the root link {root!r} has an inertia and URDF "
            "does not say. For a robot that is bolted down: --base fixed, in Python floating=False."
        )
    return False, (
        f"The base is taken as fixed, since the root link {root!r} has no inertia and URDF does "
        "not say. For a robot that moves freely: --base floating, in Python floating=True."
    )


def _fixed_to_base(bodies: list[TreeBody]) -> Iterator[TreeBody]:
    fixed: set[int] = set()
    for i, body in enumerate(bodies):
        if body.parent < 0 or (body.joint is None and body.parent in fixed):
            fixed.add(i)
            yield body


def _origin(element: Element, where: str) -> Place:
    origin = element.find("origin")
    if origin is None:
        return SAME_PLACE
    place = np.array(number_list(origin, "xyz", where, (0.0, 0.0, 0.0), 3))
    if "quat_xyzw" not in origin.attrib:
        return rotation_rpy(*number_list(origin, "rpy", where, (0.0, 0.0, 0.0), 3)), place
    if "rpy" in origin.attrib:
        raise InputError(f"{where}: {label(element)}: origin has rpy and quat_xyzw, need one.")
    x, y, z, w = number_list(origin, "quat_xyzw", where, None, 4)
    return rotation_quaternion((w, x, y, z), f"{where}: {label(element)}: origin"), place


def _inertia(link: Element, where: str, notices: list[str]) -> Solid:
    inertial = link.find("inertial")
    if inertial is None:
        return MASSLESS
    rotation, center = _origin(inertial, where)
    parts = [inertial.find(tag) for tag in ("mass", "inertia")]
    if parts[0] is None or parts[1] is None:
        raise InputError(f"{where}: {label(link)}: inertial needs mass and inertia.")
    mass = one_number(parts[0], "value", where)
    xx, xy, xz, yy, yz, zz = (
        one_number(parts[1], key, where, 0.0 if key[1] != key[2] else None)
        for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if not mass >= 0:
        raise InputError(f"{where}: {label(link)} has {inertia_fault(mass, inertia)}.")
    if doubt := inertia_doubt(mass, inertia):
        notices.append(f"Link {link.get('name')!r} has {doubt}.")
    return mass, center, rotation @ inertia @ rotation.T


def _joint(element: Element, joints: dict[str, Element], where: str) -> Joint | None:
    text = element.get("type", "")
    if text == "fixed":
        return None
    if text not in _KINDS:
        raise InputError(
            f"{where}: {label(element)} is of type {text!r}, need revolute, continuous, prismatic "
            "or fixed; a floating one only from a root link without inertia to the base. "
            "Fix: write it as several joints of one degree of freedom."
        )
    axis = element.find("axis")
    vector = [1.0, 0.0, 0.0] if axis is None else number_list(axis, "xyz", where, (1, 0, 0), 3)
    limit = element.find("limit")
    lower, upper = -math.inf, math.inf
    if limit is not None and text != "continuous":
        lower, upper = (one_number(limit, key, where, 0.0) for key in ("lower", "upper"))
        if not lower <= upper:
            raise InputError(
                f"{where}: {label(element)}: lower limit {lower:g}, upper limit {upper:g}, need "
                "lower <= upper."
            )
        if lower == upper == 0.0 and not {"lower", "upper"} & set(limit.keys()):
            lower, upper = -math.inf, math.inf
    dynamics = element.find("dynamics")
    damping = friction = 0.0
    if dynamics is not None:
        damping, friction = (one_number(dynamics, k, where, 0.0) for k in ("damping", "friction"))
    return Joint(
        name_of(element, where),
        _KINDS[text],
        unit_vector(vector, f"{where}: {label(element)}: axis"),
        lower,
        upper,
        mimic=_mimic(element, joints, where),
        damping=(damping,) if damping else (),
        friction=friction,
    )


def _mimic(element: Element, joints: dict[str, Element], where: str) -> Mimic | None:
    mimic = element.find("mimic")
    if mimic is None:
        return None
    factor, offset, name = 1.0, 0.0, ""
    passed: list[str] = []
    while mimic is not None:
        # A joint may follow one that follows another one.
        name = name_of(mimic, where, "joint")
        refuse_unknown("joint", name, joints, f"{where}: {label(element)}")
        offset += factor * one_number(mimic, "offset", where, 0.0)
        factor *= one_number(mimic, "multiplier", where, 1.0)
        if name in passed or name == name_of(element, where):
            raise InputError(f"{where}: {label(element)} mimics itself. Fix: remove one <mimic>.")
        passed.append(name)
        mimic = joints[name].find("mimic")
    if joints[name].get("type") not in _KINDS:
        raise InputError(f"{where}: {label(element)} mimics {name!r}, need a joint that moves.")
    return Mimic(name, factor, offset)


def srdf_poses(path: Path, tree: RobotTree, where: str) -> dict[str, Pose]:
    """Return the poses (``group_state``) of an SRDF file by name.

    Joints that the robot lacks are left out. Seven values of a floating root joint are the place
    and the orientation of the base, its quaternion with the scalar last.
    """
    poses = {}
    for state in read_elements(path, where).iterfind("group_state"):
        joints: dict[str, float] = {}
        base = (1.0, 0.0, 0.0, 0.0)
        for joint in state.iterfind("joint"):
            name = name_of(joint, where)
            values = number_list(joint, "value", where, None)
            if name in tree.joints and len(values) == 1:
                joints[name] = values[0]
            elif tree.floating and len(values) == 7:
                x, y, z, w = values[3:]
                base = (w, x, y, z)
        poses[name_of(state, where)] = Pose(joints, base)
    return poses
