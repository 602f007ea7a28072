"""Mechanisms from TOML files: formulas as text, every fault with its line, nothing executed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path as FilePath
from typing import Any

import sympy as sp

from painleve_sym.choices import Interpolation
from painleve_sym.errors import ModelError, unknown_name
from painleve_sym.escape import latex_fault
from painleve_sym.files import parse_toml, read_text
from painleve_sym.mechanics.bodies import Body, Load, Mode, Spring
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, DomainBound, Parameter
from painleve_sym.mechanics.friction import SLIP_VELOCITY
from painleve_sym.mechanics.inputs import Input, derivative_names
from painleve_sym.mechanics.materials import PROPERTIES
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.quaternions import Quaternion, QuaternionPart, velocities_of
from painleve_sym.mechanics.shapes import ContactGeometry, Shape, ShapeKind
from painleve_sym.mechanics.spatial_bodies import SpatialBody
from painleve_sym.mechanics.system import TIME, LagrangianSystem, name_fault
from painleve_sym.mechanics.toml.expressions import CONSTANTS, Formulas
from painleve_sym.mechanics.toml.lines import toml_lines
from painleve_sym.mechanics.toml.reader import Source, Table
from painleve_sym.mechanics.toml.spatial_parts import (
    BODY_IN_SPACE,
    CONTACT_IN_SPACE,
    body_in_space,
    contact_in_space,
    is_triple,
)
from painleve_sym.progress import progress
from painleve_sym.time_limit import within_time

MAX_BYTES = 200_000
"""Of a file: a mechanism takes a few thousand, a wrong file may be of any size."""
MAX_COORDINATES = 24
"""Closed forms of more cannot be derived: six take a minute, and each more several times that."""

_TOP = (
    *("name", "title", "source", "sketch", "gravity", "coordinates", "quaternions", "parameters"),
    "inputs",
    *("definitions", "bodies", "springs", "loads", "energy", "forces"),
    *("contacts", "domain", "shapes", "start"),
)
_COORDINATE = ("unit", "meaning", "latex")
_QUATERNION = ("meaning", "velocity")
_RANGE = ("lower", "upper", "lower_closed", "upper_closed", "positive")
_PARAMETER = ("default", "unit", "meaning", "material", *_RANGE)
_PLANAR = ("angle", "modes", "length", "lowest_period")
_INPUT = ("unit", "meaning", "default", "interpolation")
_BODY = (*BODY_IN_SPACE, *_PLANAR)
_MODE = (
    *("coordinate", "mass", "frequency", "damping", "momentum", "angular_momentum", "stretch"),
)
_SPRING = ("name", "extension", "stiffness", "damping")
_LOAD = ("name", "point", "force", "angle", "torque")
_SURFACE = ("slope", "through", "surface_speed")
_KINDS: Mapping[str, tuple[str, ...]] = {
    "point": (*_SURFACE, "curve"),
    "disc": _SURFACE,
    "gap": ("slip_velocity", "at", "slope"),
}
"""What a contact is given by, and which further keys belong to that."""
_ALWAYS = ("name", "friction", "static_friction", "bilateral")
_PLANE = (*_ALWAYS, *_KINDS, *_SURFACE, "curve", "slip_velocity", "at")
_CONTACT = (*_PLANE, *(key for key in CONTACT_IN_SPACE if key not in _PLANE))
_CIRCLE = ("centre", "radius", "angle")
_BOX = ("centre", "width", "height", "angle")
_SHAPE = ("stick", "polygon", "box", "disc", "dot", "pin")


def load_mechanism(path: str | FilePath) -> Mechanism:
    """Return the mechanism a TOML file describes; see `docs/mechanisms.md` for the keys.

    Parameters
    ----------
    path : str or pathlib.Path

    Raises
    ------
    InputError
        The file cannot be read, or is not TOML.
    ModelError
        What it describes is not a mechanism: every fault, with its line.
    DerivationTimeout
        Its formulas take longer than allowed.

    Examples
    --------
    >>> from painleve_sym import load_mechanism
    >>> load_mechanism("examples/mechanisms/rod-in-bowl.toml")
    Mechanism 'rod-in-bowl': coordinates x, y, theta; contact end
    """
    where = f"mechanism file {path}"
    text = read_text(path, where, MAX_BYTES)
    return mechanism_from_text(text, where, FilePath(path).stem)


def mechanism_from_text(text: str, where: str = "mechanism", name: str = "mechanism") -> Mechanism:
    """Return the mechanism that TOML text describes (see `load_mechanism`).

    Messages call the text `where`; `name` is the mechanism's where the text gives none.
    """
    data = parse_toml(text, where)
    reader = _Reader(Source(where, toml_lines(text)), data, name)
    with progress(f"reading {where}"):
        return within_time(where, reader.mechanism)


class _Reader:
    """Builds the parts of a mechanism from the data of one file."""

    def __init__(self, source: Source, data: dict[str, Any], name: str) -> None:
        self.source, self.formulas = source, source.formulas
        self.top = Table.of(source, (), data, _TOP)
        self.name = self.top.text("name", name) or name
        self.bodies: list[Body | SpatialBody] = []
        self.quaternions: dict[str, Quaternion] = {}
        self.inputs: list[Input] = []

    def mechanism(self) -> Mechanism:
        """Return the mechanism, or raise ModelError with every fault of the file."""
        coordinates, parameters = self.coordinates(), self.parameters()
        named = self.declare(coordinates, parameters)
        system = self.system(coordinates, parameters, named)
        if system is None and named:
            system = _stand_in(self.name, coordinates, parameters)
        contacts = self.contacts(system, parameters)
        domain, start = self.domain(), self.start(coordinates)
        title = self.top.text("title", self.name)
        source = self.top.text("source", self.source.where)
        sketch, shapes = self.top.text("sketch", ""), self.shapes()
        self.source.raise_if_faulty()
        assert system is not None
        with self.source.making("contacts"):
            parts = (system, contacts, domain, sketch, start, shapes)
            return Mechanism(self.name, title, source, *parts)
        raise ModelError(self.source.where, self.source.in_order)

    # ---- names ----

    def coordinates(self) -> tuple[Coordinate, ...]:
        if not self.top.entries.get("coordinates") and not self.top.entries.get("quaternions"):
            self.top.fault('no coordinates. Fix: add [coordinates] with x = { unit = "m" }.')
            return ()
        tables, coordinates = self.top.table("coordinates"), list[Coordinate]()
        turning = self.top.table("quaternions")
        count = len(tables.entries) + 4 * len(turning.entries)
        if count > MAX_COORDINATES:
            self.top.fault(
                f"got {count} coordinates, need at most {MAX_COORDINATES}. "
                "Fix: leave out what does not move.",
                "coordinates",
            )
            return ()
        for name in tables:
            table = tables.table(name, _COORDINATE)
            unit, meaning = _unit(table), table.text("meaning", name)
            latex = table.text("latex", "")
            if fault := latex_fault(latex):
                example = r"""latex = '\dot{x}_\mathrm{A}'"""
                table.fault(f"{fault}. Fix: write one symbol, such as {example}.", "latex")
            coordinates.append(Coordinate(name, meaning, unit, latex))
        for name in turning:
            table = turning.table(name, _QUATERNION)
            meaning = table.text("meaning", f"orientation {name}")
            quaternion = Quaternion(name, meaning, table.text("velocity", "omega"))
            self.quaternions[name] = quaternion
            coordinates += quaternion.coordinates
        return tuple(coordinates)

    def parameters(self) -> tuple[Parameter, ...]:
        contacts = self.top.entries.get("contacts", [])
        tables = [c for c in contacts if isinstance(c, dict)] if isinstance(contacts, list) else []
        frictions = [c.get(key) for c in tables for key in ("friction", "static_friction")]
        given, inputs = self.top.table("parameters"), self.top.table("inputs")
        self.inputs = [_input(name, inputs.table(name, _INPUT)) for name in inputs]
        own = (p for known in self.inputs for p in known.parameters)
        return (*(_parameter(name, given, name in frictions) for name in given), *own)

    def declare(
        self, coordinates: tuple[Coordinate, ...], parameters: tuple[Parameter, ...]
    ) -> bool:
        """Make names known to formulas, check them, read definitions; True if all is well."""
        names, before = self.formulas.names, len(self.source.faults)
        for c in coordinates:
            if not isinstance(c, QuaternionPart):
                self.check_name("coordinates", c.name)
                names |= {c.name: c.symbol, c.velocity.name: c.velocity.symbol}
        for quaternion in self.quaternions.values():
            parts = [(c.name, c.symbol) for c in quaternion.coordinates]
            for name, symbol in (*parts, *((v.name, v.symbol) for v in quaternion.velocities)):
                self.check_name("quaternions", name, quaternion.name)
                names[name] = symbol
        for p in parameters:
            self.check_name("inputs" if p.input_of else "parameters", p.name, p.input_of)
            names[p.name] = p.symbol
        for one in self.inputs:
            values = derivative_names(one.name, one.order)
            names |= dict(zip(values, one.derivatives, strict=True))
            self.formulas.sizes |= dict.fromkeys(values, 6 * one.order + 1)
        given = self.top.table("definitions")
        if TIME.name not in {*names, *given}:
            names[TIME.name] = TIME
        for name, text in given.entries.items():
            self.check_name("definitions", name)
            self.source.text_faults(("definitions", name), self.formulas.define(name, text))
        return bool(coordinates) and len(self.source.faults) == before

    def check_name(self, table: str, name: str, key: str = "") -> None:
        """Note a name that cannot be used as a fault of the table's entry with it, or with key."""
        fault = name_fault(name)
        if fault:
            self.top.fault(fault, table, key or name)
        elif name in self.formulas.names or name in CONSTANTS:
            fix = f'name {key} or its velocity = "..." another way' if key else "rename one"
            self.top.fault(f"name {name!r} is declared twice. Fix: {fix}.", table, key or name)

    # ---- the system ----

    def system(
        self, coordinates: tuple[Coordinate, ...], parameters: tuple[Parameter, ...], named: bool
    ) -> LagrangianSystem | None:
        before = len(self.source.faults)
        self.bodies = [
            body_in_space(table, self.quaternions)
            if is_triple(table, "centre")
            else _body(table, coordinates)
            for table in self.top.tables("bodies", _BODY)
        ]
        springs = [_spring(table) for table in self.top.tables("springs", _SPRING)]
        loads = [_load(table) for table in self.top.tables("loads", _LOAD)]
        gravity = self.gravity()
        energy = self.top.table("energy", ("kinetic", "potential"))
        kinetic, potential = energy.formula("kinetic", 0), energy.formula("potential", 0)
        forces = self.forces(coordinates)
        if not self.top.entries.get("bodies") and "kinetic" not in energy:
            self.top.fault("no mass. Fix: add [[bodies]], or [energy] with kinetic.")
        if not named or len(self.source.faults) > before:
            return None
        first = next((k for k in ("energy", "bodies") if k in self.top), "coordinates")
        system = None
        with self.source.making(first):
            system = LagrangianSystem.of_bodies(
                self.name,
                coordinates,
                parameters,
                self.bodies,
                gravity=gravity,
                springs=springs,
                loads=[load for load in loads if load is not None],
                kinetic_energy=kinetic,
                potential_energy=potential,
                generalized_forces=forces,
            )
        return system

    def gravity(self) -> sp.Expr | tuple[sp.Expr, ...]:
        if is_triple(self.top, "gravity"):
            return self.top.vector("gravity")
        if isinstance(self.top.entries.get("gravity"), list):
            return self.top.pair("gravity")
        return self.top.formula("gravity", 0)

    def forces(self, coordinates: tuple[Coordinate, ...]) -> dict[str, sp.Expr]:
        names, given = [v.row for v in velocities_of(coordinates)], self.top.table("forces")
        for name in given:
            if name not in names:
                given.fault(unknown_name("coordinate", name, names), name)
        return {name: given.formula(name) for name in given}

    # ---- contacts and the rest ----

    def contacts(
        self, system: LagrangianSystem | None, parameters: tuple[Parameter, ...]
    ) -> tuple[Contact, ...]:
        tables = self.top.tables("contacts", _CONTACT)
        if not tables:
            self.top.fault("no contact. Fix: add [[contacts]] with point, friction.", "contacts")
        read = [_contact(table, parameters, system, self.bodies) for table in tables]
        names = [c.name for c in read if c]
        for i, (table, contact) in enumerate(zip(tables, read, strict=True)):
            if contact and contact.name in names[:i]:
                fix = "Fix: give each its own name."
                table.fault(f"name {contact.name!r} is declared twice. {fix}")
        return tuple(c for c in read if c)

    def domain(self) -> tuple[DomainBound, ...]:
        tables = self.top.tables("domain", ("margin", "meaning"))
        given = (DomainBound(table.formula("margin"), table.text("meaning")) for table in tables)
        return (*given, *(DomainBound(*bound) for body in self.bodies for bound in body.bounds))

    def shapes(self) -> tuple[Shape, ...]:
        return tuple(s for t in self.top.tables("shapes", _SHAPE) if (s := _shape(t)) is not None)

    def start(self, coordinates: tuple[Coordinate, ...]) -> dict[str, float]:
        table = self.top.table("start")
        names = [c.name for c in coordinates] + [v.name for v in velocities_of(coordinates)]
        names += [TIME.name] if self.formulas.names.get(TIME.name) == TIME else []
        for name in table:
            if name not in names:
                table.fault(unknown_name("state", name, names), name)
        return {name: table.number(name) for name in table}


def _stand_in(
    name: str, coordinates: tuple[Coordinate, ...], parameters: tuple[Parameter, ...]
) -> LagrangianSystem | None:
    """Return a system of the same names, so that contacts are checked though the energies fail."""
    kinetic = sum((v.symbol**2 for v in velocities_of(coordinates)), sp.Integer(0))
    try:
        return LagrangianSystem(name, coordinates, parameters, kinetic, sp.Integer(0))
    except ModelError:
        return None


def _unit(table: Table) -> str:
    unit = table.text("unit", "")
    # A unit that is not a text is a fault of its own.
    if "unit" not in table or (isinstance(table.entries["unit"], str) and not unit.strip()):
        fix = 'Fix: add unit = "...", in SI, or "1" for a number without unit.'
        table.fault(f"unit is missing. {fix}")
    return unit or "1"


def _parameter(name: str, given: Table, is_friction: bool) -> Parameter:
    table = given.table(name, _PARAMETER)
    positive = table.flag("positive", False)
    if positive and "lower" in table:
        table.fault("'positive' and 'lower' are mutually exclusive. Fix: remove one.", "lower")
    parameter = Parameter(
        name=name,
        default=table.number("default"),
        unit=_unit(table),
        meaning=table.text("meaning", name),
        lower=table.number("lower", 0.0 if positive or is_friction else -math.inf),
        upper=table.number("upper", math.inf),
        lower_closed=table.flag("lower_closed", not positive),
        upper_closed=table.flag("upper_closed", True),
        material=_material_property(table),
    )
    fault = parameter.fault(parameter.default) if "default" in table else None
    if fault:
        table.fault(fault, "default")
    return parameter


def _input(name: str, table: Table) -> Input:
    kind = table.text("interpolation", Interpolation.HELD)
    if kind not in [*Interpolation]:
        table.fault(unknown_name("interpolation", kind, [*Interpolation]), "interpolation")
        kind = Interpolation.HELD
    meaning, default = table.text("meaning", name), table.number("default", 0.0)
    return Input(name, _unit(table), meaning, Interpolation(kind), default)


def _material_property(table: Table) -> str:
    """Return the property of a material that a parameter stands for, empty for none."""
    name, unit = table.text("material", ""), table.entries.get("unit")
    if name and name not in PROPERTIES:
        table.fault(unknown_name("property of a material", name, PROPERTIES), "material")
    elif name and unit != PROPERTIES[name]:
        table.fault(f"unit is {unit!r}, need {PROPERTIES[name]!r} of the {name}.", "unit")
    return name


def _body(table: Table, coordinates: Sequence[Coordinate]) -> Body:
    if "orientation" in table:
        table.fault("orientation belongs to a body in space. Fix: give its centre a z.")
    symbols = {c.name: c.symbol for c in coordinates}
    modes = [_mode(mode, symbols) for mode in table.tables("modes", _MODE)]
    name = table.text("name", "body")
    if ("inertia" in table) != ("angle" in table):
        table.fault("inertia and angle belong together. Fix: give both or none.")
    mass, inertia, angle = (
        table.formula("mass"),
        table.formula("inertia", 0),
        table.formula("angle", 0),
    )
    kept = tuple(mode for mode in modes if mode is not None)
    length, period = (
        table.formula(key) if key in table else None for key in ("length", "lowest_period")
    )
    return Body(
        mass=mass,
        centre=table.pair("centre"),
        inertia=inertia,
        angle=angle,
        modes=kept,
        name=name,
        length=length,
        lowest_period=period,
    )


def _mode(table: Table, coordinates: Mapping[str, sp.Symbol]) -> Mode | None:
    coordinate = table.named("coordinate", "coordinate", coordinates)
    momentum = table.pair("momentum", (0, 0))
    turning = table.formula("angular_momentum", 0)
    stretch = table.formula("stretch") if "stretch" in table else None
    mass, frequency = table.formula("mass"), table.formula("frequency")
    damping = table.formula("damping", 0)
    if coordinate is None:
        return None
    return Mode(coordinate, mass, frequency, damping, momentum, turning, stretch)


def _spring(table: Table) -> Spring:
    table.text("name", "")
    extension = table.formula("extension")
    return Spring(extension, table.formula("stiffness", 0), table.formula("damping", 0))


def _load(table: Table) -> Load | None:
    table.text("name", "")
    given = set(table) & set(_LOAD) - {"name"}
    if given == {"point", "force"} and is_triple(table, "point"):
        return Load.force(table.vector("point"), table.vector("force"))
    if given == {"point", "force"}:
        return Load.force(table.pair("point"), table.pair("force"))
    if given == {"angle", "torque"}:
        return Load.torque(table.formula("angle"), table.formula("torque"))
    table.fault("need point and force, or angle and torque.")
    return None


def _shape(table: Table) -> Shape | None:
    kinds = [kind for kind in _SHAPE if kind in table]
    if len(kinds) != 1:
        need = f"need one of {', '.join(_SHAPE)}"
        table.fault(f"got {' and '.join(kinds) or 'none'}, {need}.")
        return None
    (kind,) = kinds
    if kind in ("dot", "pin"):
        return Shape(ShapeKind(kind), (table.pair(kind),))
    if kind == "disc":
        return Shape.disc(**_disc(table))
    if kind == "box":
        box = table.table("box", _BOX)
        sides = box.formula("width"), box.formula("height")
        return Shape.box(box.pair("centre"), *sides, box.formula("angle", 0))
    points = table.points(kind)
    if len(points) < (least := 2 + (kind == "polygon")):
        table.fault(f"got {len(points)} points, need at least {least} points.", kind)
        return None
    return Shape(ShapeKind(kind), tuple(points))


# ---- contacts ----

Maker = Callable[..., Contact]
"""Makes the contact once its name, system, friction and bilateral are given."""


def _contact(
    table: Table,
    parameters: Sequence[Parameter],
    system: LagrangianSystem | None,
    bodies: Sequence[Body | SpatialBody],
) -> Contact | None:
    """Return the contact, or None where it has faults or there is no system."""
    before, kinds = table.source.stand_ins, [kind for kind in _KINDS if kind in table]
    symbols = {p.name: p.symbol for p in parameters}
    name, bilateral = table.text("name"), table.flag("bilateral", False)
    friction, static = _friction(table, symbols)
    if len(kinds) != 1:
        table.fault(f"got {' and '.join(kinds) or 'none'}, need one of point, disc, gap.")
        return None
    (kind,) = kinds
    clock = {s.name: s for s in system.clock} if system else {TIME.name: TIME}
    axes = {3 if is_triple(table, "point") else 2, *(len(body.centre) for body in bodies)}
    if kind == "point" and 3 in axes:
        make: Maker = contact_in_space(table, {**clock, **symbols}, bodies)
    else:
        make = partial(_in_plane(table, kind, {**clock, **symbols}, bodies), bilateral=bilateral)
    if table.source.stand_ins > before or friction is None or system is None:
        return None
    contact = None
    with table.source.making(*table.path):
        contact = make(name=name, system=system, friction=friction, static_friction=static)
    return contact


def _friction(
    table: Table, parameters: Mapping[str, sp.Symbol]
) -> tuple[sp.Expr | None, sp.Expr | None]:
    """Return the friction of slip, a parameter or a formula of v_t, and that of rest, or None."""
    text, own = table.entries.get("friction"), table.source.formulas
    # A name alone is meant to be a parameter.
    if not isinstance(text, str) or text.strip().isidentifier():
        friction: sp.Expr | None = table.named("friction", "parameter", parameters)
    else:
        name = SLIP_VELOCITY.name
        if name in own.names:
            table.fault(f"{name} means the slip velocity here. Fix: rename yours.", "friction")
        formulas = Formulas({**own.names, name: SLIP_VELOCITY}, own.sizes, own.broken)
        friction = table.formula("friction", formulas=formulas)
    static = table.formula("static_friction") if "static_friction" in table else None
    return friction, static


def _in_plane(
    table: Table, kind: str, names: Mapping[str, sp.Expr], bodies: Sequence[Body | SpatialBody]
) -> Maker:
    """Return the factory of the contact of a point or a disc in the plane, or of a gap."""
    for key in table:
        if key in _CONTACT and key not in (*_ALWAYS, kind, *_KINDS[kind]):
            table.fault(f"{key} does not belong to a contact with {kind}.", key)
    if kind == "gap" and isinstance(table.entries.get("slip_velocity"), list):
        slip, across = table.vector("slip_velocity", 2)
        return partial(Contact, gap=table.formula("gap"), slip_velocity=slip, slip_across=across)
    if kind == "gap":
        gap, slip = table.formula("gap"), table.formula("slip_velocity")
        if "at" in table:
            at, slope = table.pair("at"), table.formula("slope", 0)
            drawn = ContactGeometry.straight(at, slope, gap)
            return partial(Contact, gap=gap, slip_velocity=slip, geometry=drawn)
        if "slope" in table:
            table.fault("slope says how a contact with gap is drawn. Fix: add at.", "slope")
        return partial(Contact, gap=gap, slip_velocity=slip)
    if kind == "disc":
        return partial(Contact.of_disc, **_disc(table), **_surface(table))
    return _point(table, names, [body for body in bodies if isinstance(body, Body)])


def _surface(table: Table) -> dict[str, Any]:
    slope, speed = table.formula("slope", 0), table.formula("surface_speed", 0)
    return {"slope": slope, "surface_speed": speed, "through": table.pair("through", (0, 0))}


def _disc(table: Table) -> dict[str, Any]:
    disc = table.table("disc", _CIRCLE)
    centre, radius = disc.pair("centre"), disc.formula("radius")
    return {"centre": centre, "radius": radius, "angle": disc.formula("angle")}


def _point_of_body(contact: Table, bodies: Sequence[Body]) -> tuple[sp.Expr, sp.Expr]:
    """Return the place of a material point of a named body, moved by the body's modes."""
    table = contact.table("point", ("body", "at", "shape"))
    body = table.named("body", "body", {body.name: body for body in bodies})
    at, shapes = table.pair("at"), table.table("shape")
    values = {key: shapes.pair(key) for key in shapes}
    if body is not None:
        modes = {str(mode.coordinate): mode.coordinate for mode in body.modes}
        with table.source.making(*table.path):
            return body.point(at, {modes.get(k, sp.Symbol(k)): v for k, v in values.items()})
    table.source.stand_ins += 1
    return sp.Integer(1), sp.Integer(1)


def _point(table: Table, names: Mapping[str, sp.Expr], bodies: Sequence[Body]) -> Maker:
    """Return the contact of a point; a curve may use `names` beside its place x, y."""
    on_body = isinstance(table.entries["point"], Mapping)
    point = _point_of_body(table, bodies) if on_body else table.pair("point")
    surface = _surface(table)
    if "curve" not in table:
        return partial(Contact.of_point, point=point, **surface)
    if "slope" in table:
        table.fault("a curve says this. Fix: leave out slope or curve.", "slope")
    curve = table.formula_of_place("curve", ("x", "y"), names)
    del surface["slope"]
    return partial(Contact.of_point, point=point, curve=curve, **surface)
