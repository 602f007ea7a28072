"""Bodies, springs, loads and contacts of a mechanism file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import sympy as sp

from painleve_sym.errors import ModelError, unknown_name
from painleve_sym.mechanics.bodies import Body, Load, Spring
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.system import TIME, LagrangianSystem, Parameter
from painleve_sym.mechanics.toml.expressions import Formulas
from painleve_sym.mechanics.toml.lines import Path
from painleve_sym.mechanics.toml.reader import Entries

BODY_KEYS = ("name", "mass", "inertia", "centre", "angle")
SPRING_KEYS = ("name", "extension", "stiffness", "damping")
LOAD_KEYS = ("name", "point", "force", "angle", "torque")
_SURFACE = ("slope", "through", "surface_speed")
_KINDS: Mapping[str, tuple[str, ...]] = {
    "point": (*_SURFACE, "curve"),
    "disc": _SURFACE,
    "gap": ("slip_velocity",),
}
"""What a contact is given by, and which further keys belong to that."""
_ALWAYS = ("name", "friction", "bilateral")
CONTACT_KEYS = (*_ALWAYS, *_KINDS, *_SURFACE, "curve", "slip_velocity")
_DISC = ("centre", "radius", "angle")

Tables = Sequence[Mapping[str, Any]]
Maker = Callable[..., Contact]
"""Makes the contact once its name, system, friction and bilateral are given."""


def read_bodies(entries: Entries, tables: Tables) -> list[Body]:
    """Return the bodies that have no fault."""
    found = []
    for i, table in enumerate(tables):
        path: Path = ("bodies", i)
        entries.text(path, table, "name", "")
        if ("inertia" in table) != ("angle" in table):
            entries.faults.add(path, "inertia and angle belong together. Fix: give both or none.")
        mass = entries.formula(path, table, "mass", None)
        inertia = entries.formula(path, table, "inertia", 0)
        angle = entries.formula(path, table, "angle", 0)
        centre = entries.pair(path, table, "centre", None)
        if mass is not None and inertia is not None and angle is not None and centre:
            found.append(Body(mass, centre, inertia, angle))
    return found


def read_springs(entries: Entries, tables: Tables) -> list[Spring]:
    """Return the springs and dampers that have no fault."""
    found = []
    for i, table in enumerate(tables):
        path: Path = ("springs", i)
        entries.text(path, table, "name", "")
        extension = entries.formula(path, table, "extension", None)
        stiffness = entries.formula(path, table, "stiffness", 0)
        damping = entries.formula(path, table, "damping", 0)
        if extension is not None and stiffness is not None and damping is not None:
            found.append(Spring(extension, stiffness, damping))
    return found


def read_loads(entries: Entries, tables: Tables) -> list[Load]:
    """Return the applied forces and torques that have no fault."""
    found = []
    for i, table in enumerate(tables):
        path: Path = ("loads", i)
        entries.text(path, table, "name", "")
        given = set(table) & set(LOAD_KEYS) - {"name"}
        if given == {"point", "force"}:
            point = entries.pair(path, table, "point", None)
            force = entries.pair(path, table, "force", None)
            if point and force:
                found.append(Load.force(point, force))
        elif given == {"angle", "torque"}:
            angle = entries.formula(path, table, "angle", None)
            torque = entries.formula(path, table, "torque", None)
            if angle is not None and torque is not None:
                found.append(Load.torque(angle, torque))
        else:
            entries.faults.add(path, "need point and force, or angle and torque.")
    return found


class ContactReader:
    """Reads contacts: a point or a disc against a surface, or gap and slip velocity as formulas.

    Parameters
    ----------
    entries : Entries
    parameters : sequence of Parameter
        One of them is the friction; a curve may use them beside its place x, y, and the time.
    """

    def __init__(self, entries: Entries, parameters: Sequence[Parameter]) -> None:
        self.entries, self.faults = entries, entries.faults
        self.symbols = {p.name: p.symbol for p in parameters}
        self.clock: dict[str, sp.Expr] = {}

    def read(
        self, path: Path, table: Mapping[str, Any], system: LagrangianSystem | None
    ) -> Contact | None:
        """Return the contact, or None where it has faults or there is no system."""
        kinds = [kind for kind in _KINDS if kind in table]
        self.clock = {s.name: s for s in system.clock} if system else {TIME.name: TIME}
        name = self.entries.text(path, table, "name", None)
        bilateral = self.entries.flag(path, table, "bilateral", False)
        friction = self._friction(path, table)
        if len(kinds) != 1:
            self.faults.add(
                path, f"got {' and '.join(kinds) or 'none'}, need one of point, disc, gap."
            )
            return None
        for key in table:
            if key in CONTACT_KEYS and key not in (*_ALWAYS, *kinds, *_KINDS[kinds[0]]):
                self.faults.add(
                    (*path, key), f"{key} does not belong to a contact with {kinds[0]}."
                )
        read = {"point": self._point, "disc": self._disc, "gap": self._gap}[kinds[0]]
        make = read(path, table)
        if make is None or friction is None or system is None:
            return None
        try:
            return make(name=name, system=system, friction=friction, bilateral=bilateral)
        except ModelError as error:
            self.faults.add_all(path, error)
            return None

    def _friction(self, path: Path, table: Mapping[str, Any]) -> sp.Symbol | None:
        name = self.entries.text(path, table, "friction", None)
        if isinstance(table.get("friction"), str) and name not in self.symbols:
            self.faults.add((*path, "friction"), unknown_name("parameter", name, self.symbols))
        return self.symbols.get(name)

    def _surface(self, path: Path, table: Mapping[str, Any]) -> dict[str, Any] | None:
        slope = self.entries.formula(path, table, "slope", 0)
        speed = self.entries.formula(path, table, "surface_speed", 0)
        through = self.entries.pair(path, table, "through", (0, 0))
        if slope is None or speed is None or through is None:
            return None
        return {"slope": slope, "surface_speed": speed, "through": through}

    def _point(self, path: Path, table: Mapping[str, Any]) -> Maker | None:
        point = self.entries.pair(path, table, "point", None)
        surface = self._surface(path, table)
        if "curve" not in table:
            if point is None or surface is None:
                return None
            return partial(Contact.of_point, point=point, **surface)
        if "slope" in table:
            self.faults.add((*path, "slope"), "a curve says this. Fix: leave out slope or curve.")
        for name in set(self.symbols) & {"x", "y"}:
            fix = "Fix: rename the parameter."
            self.faults.add((*path, "curve"), f"{name} means the place, not the parameter. {fix}")
        place = {name: sp.Dummy(name, real=True) for name in ("x", "y")}
        formulas = Formulas({**self.clock, **self.symbols, **place})
        formula = self.entries.formula(path, table, "curve", None, formulas)
        if point is None or surface is None or formula is None:
            return None

        def curve(x: sp.Expr, y: sp.Expr) -> sp.Expr:
            return formula.subs({place["x"]: x, place["y"]: y}, simultaneous=True)

        given = {key: surface[key] for key in ("surface_speed", "through")}
        return partial(Contact.of_point, point=point, curve=curve, **given)

    def _disc(self, path: Path, table: Mapping[str, Any]) -> Maker | None:
        inner: Path = (*path, "disc")
        disc = self.entries.table(inner, table["disc"], _DISC)
        surface = self._surface(path, table)
        centre = self.entries.pair(inner, disc, "centre", None)
        radius = self.entries.formula(inner, disc, "radius", None)
        angle = self.entries.formula(inner, disc, "angle", None)
        if centre is None or radius is None or angle is None or surface is None:
            return None
        return partial(Contact.of_disc, centre=centre, radius=radius, angle=angle, **surface)

    def _gap(self, path: Path, table: Mapping[str, Any]) -> Maker | None:
        gap = self.entries.formula(path, table, "gap", None)
        slip = self.entries.formula(path, table, "slip_velocity", None)
        if gap is None or slip is None:
            return None
        return partial(Contact, gap=gap, slip_velocity=slip)
