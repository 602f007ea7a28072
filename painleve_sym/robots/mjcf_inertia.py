"""Mass and inertia of the bodies of an MJCF file, as given or of primitive geoms."""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree.ElementTree import Element

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.robots.formats import WRITTEN_BY_MUJOCO
from painleve_sym.robots.mjcf_settings import Settings, to_z
from painleve_sym.robots.tree import (
    MASSLESS,
    SAME_PLACE,
    Place,
    Solid,
    cleaned,
    inertia_fault,
    joined,
    unit_vector,
)
from painleve_sym.robots.xml_text import label, number_list, one_number

_MASSLESS_SHAPES = {"plane", "hfield"}
_MESHES = {"mesh", "sdf"}


Part = tuple[Element, str, Place]
"""An element of a body, its class, and the frame that it stands in, in the frame of the body."""


def parts_of(element: Element, s: Settings, childclass: str) -> list[Part]:
    """Return the parts of a body and of its frames."""
    if (element, childclass) not in s.parts:
        s.parts[element, childclass] = list(_parts(element, s, childclass))
    return s.parts[element, childclass]


def _parts(element: Element, s: Settings, childclass: str) -> Iterator[Part]:
    waiting: list[Part] = [(e, childclass, SAME_PLACE) for e in reversed(element)]
    while waiting:
        child, name, at = waiting.pop()
        if child.tag == "frame":
            inner, place = child.get("childclass") or name, s.place(child, at)
            waiting += ((e, inner, place) for e in reversed(child))
        else:
            yield child, name, at


def body_inertia(
    body: Element, s: Settings, childclass: str, position: Array, matters: bool
) -> Solid:
    """Return mass, centre and inertia of a body that stands at `position` in the one before.

    `matters` is false for a body that never moves, whose mesh needs no inertia.
    """
    inertials = [(e, at) for e, _, at in parts_of(body, s, childclass) if e.tag == "inertial"]
    if len(inertials) > 1:
        raise InputError(f"{s.where}: {label(body)} has several <inertial>, need one.")
    geoms = [s.full(e, name) for e, name, _ in parts_of(body, s, childclass) if e.tag == "geom"]
    # Without a geom that counts, the given inertia stays.
    if inertials and (s.from_geoms != "true" or not any(_weighs(geom, s) for geom in geoms)):
        solid = _given(*inertials[0], s)
    elif s.from_geoms == "false":
        solid = MASSLESS
    else:
        solid = _of_geoms(body, s, childclass, matters)
    if solid is MASSLESS and s.bounds[0] > 0:
        # MuJoCo puts the centre of a body of nothing at the coordinates of its place.
        solid = (0.0, position, np.zeros((3, 3)))
    solid = _bounded(solid, s)
    if fault := inertia_fault(solid[0], solid[2]):
        raise InputError(f"{s.where}: {label(body)} has {fault}.")
    return solid


def _given(inertial: Element, at: Place, s: Settings) -> Solid:
    """Return the inertia of an element ``inertial`` in the frame `at`."""
    if "fullinertia" in inertial.attrib:
        xx, yy, zz, xy, xz, yz = number_list(inertial, "fullinertia", s.where, None, 6)
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    else:
        inertia = np.diag(number_list(inertial, "diaginertia", s.where, None, 3))
    R, center = s.place(inertial, at)
    return one_number(inertial, "mass", s.where), center, R @ inertia @ R.T


def _bounded(solid: Solid, s: Settings) -> Solid:
    """Return mass and inertia after the corrections that the file asks of the compiler."""
    mass, center, inertia = solid
    mass = max(mass, s.bounds[0])
    if s.bounds[1] > 0 or s.balance:
        moments, axes = np.linalg.eigh(inertia)
        moments = np.maximum(moments, s.bounds[1])
        if s.balance and moments[0] + moments[1] < moments[2]:
            moments = np.full(3, moments.mean())
        inertia = axes @ np.diag(moments) @ axes.T
    return mass, center, inertia


def _of_geoms(body: Element, s: Settings, childclass: str, matters: bool) -> Solid:
    """Return mass, centre and inertia of the geoms of a body, all of primitive shapes."""
    solids = []
    for element, name, at in parts_of(body, s, childclass):
        if element.tag != "geom":
            continue
        full = s.full(element, name)
        if is_mesh(full) and _weighs(full, s) and not matters:
            return MASSLESS
        solids += _geom(full, s, label(body), at)
    return joined(solids) if sum(mass for mass, _, _ in solids) > 0 else MASSLESS


def is_mesh(geom: Element) -> bool:
    """Return whether the place and inertia of a geom come from a mesh."""
    return geom.get("type") in _MESHES or "mesh" in geom.attrib


def _weighs(geom: Element, s: Settings) -> bool:
    """Return whether a geom counts for the inertia of its body."""
    group = one_number(geom, "group", s.where, 0.0)
    key, default = ("mass", 0.0) if "mass" in geom.attrib else ("density", 1000.0)
    weight = one_number(geom, key, s.where, default)
    counts = s.groups[0] <= group <= s.groups[1]
    return weight != 0 and counts and geom.get("type", "sphere") not in _MASSLESS_SHAPES


def _geom(geom: Element, s: Settings, body: str, at: Place) -> list[Solid]:
    """Return the solid of a geom, if it counts."""
    if not _weighs(geom, s):
        return []
    if is_mesh(geom):
        raise InputError(
            f"{s.where}: {body} takes its inertia from a mesh, which is not read. "
            + WRITTEN_BY_MUJOCO
        )
    if geom.get("shellinertia", "false") == "true":
        raise InputError(
            f"{s.where}: {label(geom)}: the inertia of a shell (shellinertia) is not read. "
            + WRITTEN_BY_MUJOCO
        )
    (turned, place), size = shape(geom, s)
    kind = geom.get("type", "sphere")
    volume, moments = _solid(kind, size, f"{s.where}: {label(geom)}")
    density = one_number(geom, "density", s.where, 1000.0)
    mass = one_number(geom, "mass", s.where, density * volume)
    turned = at[0] @ turned
    inertia = turned @ np.diag(mass * moments) @ turned.T
    return [(mass, at[1] + at[0] @ place, inertia)]


def shape(element: Element, s: Settings) -> tuple[Place, list[float]]:
    """Return orientation, place and size of a geom or site."""
    size = number_list(element, "size", s.where, ())
    if "fromto" not in element.attrib:
        return (s.rotation(element), s.position(element)), size
    values = np.array(number_list(element, "fromto", s.where, None, 6))
    along = values[3:] - values[:3]
    length = float(np.linalg.norm(along))
    # MuJoCo's z axis of such a geom points back, from the second end to the first.
    axis = unit_vector(-along, f"{s.where}: {label(element)}: fromto")
    half = length / 2
    round_shape = element.get("type", "sphere") in ("capsule", "cylinder")
    sized = [*size[:1], half] if round_shape else [*size[:1], *size[:1], half]
    return (cleaned(to_z(axis)), (values[:3] + values[3:]) / 2), sized


def _solid(shape: str, size: list[float], where: str) -> tuple[float, Array]:
    """Return volume and principal moments per mass of a solid, as MuJoCo has them for a geom."""
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
