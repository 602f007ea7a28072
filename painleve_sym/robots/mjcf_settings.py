"""Settings of a whole MJCF file: compiler, flags, default classes, notations of orientations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.robots.formats import DRIVES
from painleve_sym.robots.tree import (
    Place,
    cleaned,
    rotation_axis,
    rotation_quaternion,
    unit_vector,
)
from painleve_sym.robots.xml_text import label, number_list, one_number

_AXES = {"x": 0, "y": 1, "z": 2}
_TURNS = ("quat", "axisangle", "euler", "xyaxes", "zaxis")
_OPEN_LISTS = ("size", "stiffness", "damping", "gear")
"""Attributes that may have fewer numbers than they can have."""
MAX_WORDS = 6
"""Numbers that the longest of them has."""
_DRIVE = "general"


@dataclass(frozen=True, eq=False)
class Settings:
    """Settings of the file, and the default attributes of every class.

    Attributes
    ----------
    where : str
        Begins messages.
    radians : bool
    sequence : str
        Axes of Euler angles: small letters turn along, capitals are fixed.
    autolimits : bool
    from_geoms : str
        Whether bodies take their inertia from geoms: ``true``, ``false`` or ``auto``.
    groups : tuple of float
        First and last group of these geoms.
    balance : bool
        Whether moments of inertia that no body has become their mean.
    bounds : tuple of float
        Least mass and least moment of inertia of a body.
    total_mass : float
        Of all bodies; not positive where the file does not say.
    fuses : bool
        Whether bodies that stand still become part of the world, without their mass.
    off : frozenset of str
        Flags that are disabled.
    gravity : list of float
    classes : mapping
        Attributes by class and tag.
    parts : dict
        Parts of the bodies that have been looked through, by body and class.
    """

    where: str
    radians: bool
    sequence: str
    autolimits: bool
    from_geoms: str
    groups: tuple[float, float]
    balance: bool
    bounds: tuple[float, float]
    total_mass: float
    fuses: bool
    off: frozenset[str]
    gravity: list[float]
    classes: Mapping[str, Mapping[str, Mapping[str, str]]]
    parts: dict[tuple[Element, str], list[tuple[Element, str, Place]]] = field(default_factory=dict)

    def angle(self, value: float) -> float:
        """Return an angle of the file in rad."""
        return value if self.radians else math.radians(value)

    def full(self, element: Element, childclass: str, kind: str = "") -> Element:
        """Apply MJCF class defaults to an element."""
        name = element.get("class") or childclass
        if name not in self.classes:
            raise InputError(
                f"{self.where}: {label(element)}: "
                + unknown_name("default class", name, [c for c in self.classes if c])
            )
        defaults = self.classes[name].get(kind or element.tag, {})
        return Element(element.tag, _over(defaults, element.attrib))

    def drive(self, element: Element) -> Element:
        """Return an actuator with the attributes of its class; all its kinds share them."""
        return self.full(element, "", _DRIVE)

    def rotation(self, element: Element) -> Array:
        """Return the orientation of an element, in any of the notations."""
        where = f"{self.where}: {label(element)}"
        given = [turn for turn in _TURNS if turn in element.attrib]
        if len(given) > 1:
            raise InputError(f"{where} has {' and '.join(given)}, need one orientation.")
        if "quat" in given:
            return rotation_quaternion(number_list(element, "quat", self.where, None, 4), where)
        if "axisangle" in given:
            *axis, angle = number_list(element, "axisangle", self.where, None, 4)
            return rotation_axis(unit_vector(axis, f"{where}: axisangle"), self.angle(angle))
        if "euler" in given:
            return self._euler(number_list(element, "euler", self.where, None, 3))
        if "xyaxes" in given:
            values = number_list(element, "xyaxes", self.where, None, 6)
            x = unit_vector(values[:3], f"{where}: xyaxes")
            y = np.array(values[3:])
            y = unit_vector(y - (y @ x) * x, f"{where}: xyaxes")
            return cleaned(np.column_stack([x, y, np.cross(x, y)]))
        if "zaxis" in given:
            return to_z(unit_vector(number_list(element, "zaxis", self.where, None, 3), where))
        return np.eye(3)

    def _euler(self, angles: list[float]) -> Array:
        R = np.eye(3)
        for letter, angle in zip(self.sequence, angles, strict=True):
            turn = rotation_axis(np.eye(3)[_AXES[letter.lower()]], self.angle(angle))
            # Small letters are axes that turn along, capitals fixed ones.
            R = R @ turn if letter.islower() else turn @ R
        return cleaned(R)

    def position(self, element: Element) -> Array:
        """Return the place of an element, m."""
        return np.array(number_list(element, "pos", self.where, (0.0, 0.0, 0.0), 3))

    def place(self, element: Element, at: Place) -> Place:
        """Return orientation and place of an element that stands in the frame `at`."""
        R, p = at
        return cleaned(R @ self.rotation(element)), p + R @ self.position(element)


def to_z(z: Array) -> Array:
    """Return the smallest rotation that turns the axis z to a unit vector."""
    axis = np.cross([0.0, 0.0, 1.0], z)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-10:
        return np.eye(3) if z[2] > 0 else np.diag([1.0, -1.0, -1.0])
    return rotation_axis(axis / sine, math.atan2(sine, float(z[2])))


def read_settings(root: Element, where: str) -> Settings:
    """Return the settings of a file; InputError names their faults."""
    compiler, option, flag = (_merged(root, path) for path in ("compiler", "option", "option/flag"))
    sequence = compiler.get("eulerseq", "xyz")
    if len(sequence) != 3 or not set(sequence.lower()) <= set(_AXES):
        raise InputError(f"{where}: compiler: eulerseq = {sequence!r}, need three of x, y, z.")
    low, high = number_list(compiler, "inertiagrouprange", where, (0.0, 5.0), 2)
    off = {name for name, value in flag.attrib.items() if value == "disable"}
    if "passive" in off:
        off |= {"spring", "damper"}
    if "constraint" in off:
        off |= {"equality", "frictionloss"}
    gravity = number_list(option, "gravity", where, (0.0, 0.0, -9.81), 3)
    return Settings(
        where,
        radians=compiler.get("angle", "degree") == "radian",
        sequence=sequence,
        autolimits=compiler.get("autolimits", "true") != "false",
        from_geoms=compiler.get("inertiafromgeom", "auto"),
        groups=(low, high),
        balance=compiler.get("balanceinertia", "false") == "true",
        bounds=(
            one_number(compiler, "boundmass", where, 0.0),
            one_number(compiler, "boundinertia", where, 0.0),
        ),
        total_mass=one_number(compiler, "settotalmass", where, -1.0),
        fuses=compiler.get("fusestatic", "false") == "true",
        off=frozenset(off),
        gravity=[0.0, 0.0, 0.0] if "gravity" in off else gravity,
        classes=_classes(root, where),
    )


def _over(defaults: Mapping[str, str], own: Mapping[str, str]) -> dict[str, str]:
    """Return attributes of an element with class defaults applied.

    An orientation replaces that of the class, whatever its notation. A shorter list of numbers
    leaves the further ones of the class.
    """
    turned = any(turn in own for turn in _TURNS)
    kept = {k: v for k, v in defaults.items() if not (turned and k in _TURNS)}
    for key, value in own.items():
        more: list[str] = []
        if key in _OPEN_LISTS:
            words, above = (_words(text) for text in (value, kept.get(key, "")))
            more = above[len(words) :]
        kept[key] = " ".join([*words, *more]) if more else value
    return kept


def _words(text: str) -> list[str]:
    """Return the first words of a text that may have millions."""
    return text.split(maxsplit=MAX_WORDS)[:MAX_WORDS]


def _merged(root: Element, path: str) -> Element:
    """Return one element with the attributes of several, of which later ones count."""
    merged = Element(path.rpartition("/")[2])
    for element in root.iterfind(path):
        merged.attrib.update(element.attrib)
    return merged


def _classes(root: Element, where: str) -> dict[str, dict[str, dict[str, str]]]:
    classes: dict[str, dict[str, dict[str, str]]] = {"": {}}

    def add(element: Element, above: dict[str, dict[str, str]], name: str) -> None:
        own = {tag: dict(values) for tag, values in above.items()}
        for child in element:
            if child.tag == "default":
                continue
            tag = _DRIVE if child.tag in DRIVES else child.tag
            own[tag] = _over(own.get(tag, {}), child.attrib)
        classes[name] = own
        for child in element.findall("default"):
            inner = child.get("class", "")
            if not inner:
                raise InputError(f"{where}: a default within another one has no class.")
            add(child, own, inner)

    for top in root.findall("default"):
        add(top, classes[""], "")
        classes[top.get("class", "main")] = classes[""]
    return classes
