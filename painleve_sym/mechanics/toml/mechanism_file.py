"""Mechanisms from TOML files: formulas as text, every fault with its line, nothing executed."""

from __future__ import annotations

import math
from pathlib import Path as FilePath
from typing import Any

import sympy as sp

from painleve_sym.errors import ModelError, unknown_name
from painleve_sym.files import parse_toml, read_text
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.mechanism import DomainBound, Mechanism
from painleve_sym.mechanics.system import (
    TIME,
    Coordinate,
    LagrangianSystem,
    Parameter,
    name_fault,
)
from painleve_sym.mechanics.toml.expressions import CONSTANTS, Formulas
from painleve_sym.mechanics.toml.lines import Path, TomlLines, toml_lines
from painleve_sym.mechanics.toml.parts import (
    BODY_KEYS,
    CONTACT_KEYS,
    LOAD_KEYS,
    SPRING_KEYS,
    ContactReader,
    read_bodies,
    read_loads,
    read_springs,
)
from painleve_sym.mechanics.toml.reader import Entries, Faults

MAX_BYTES = 200_000
"""Of a file: a mechanism takes a few thousand, a wrong file may be of any size."""

_TOP = (
    *("name", "title", "source", "sketch", "gravity", "coordinates", "parameters"),
    *("definitions", "bodies", "springs", "loads", "energy", "forces"),
    *("contacts", "domain", "start"),
)
_COORDINATE = ("unit", "meaning", "latex")
_RANGE = ("lower", "upper", "lower_closed", "upper_closed", "positive")
_PARAMETER = ("default", "unit", "meaning", *_RANGE)
_ENERGY = ("kinetic", "potential")


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
        What it describes is no mechanism: every fault, with its line.
    """
    where = f"mechanism file {path}"
    text = read_text(path, where, MAX_BYTES)
    return mechanism_from_text(text, where, FilePath(path).stem)


def mechanism_from_text(text: str, where: str = "mechanism", name: str = "mechanism") -> Mechanism:
    """Return the mechanism that TOML text describes (see `load_mechanism`).

    Parameters
    ----------
    text : str
    where : str
        What error messages call the text.
    name : str
        Name of the mechanism where the text gives none.
    """
    return _Reader(parse_toml(text, where), toml_lines(text), where, name).mechanism()


class _Reader:
    """Builds the parts of a mechanism from the data of one file."""

    def __init__(self, data: dict[str, Any], lines: TomlLines, where: str, name: str) -> None:
        self.faults = Faults(where, lines)
        self.formulas = Formulas({})
        self.entries = Entries(self.faults, self.formulas)
        self.data = self.entries.table((), data, _TOP)
        self.name = self.entries.text((), self.data, "name", name) or name
        self.where = where

    def mechanism(self) -> Mechanism:
        """Return the mechanism, or raise ModelError with every fault of the file."""
        coordinates, parameters = self.coordinates(), self.parameters()
        named = self.declare(coordinates, parameters)
        system = self.system(coordinates, parameters, named)
        if system is None and named:
            system = _stand_in(self.name, coordinates, parameters)
        contacts = self.contacts(system, parameters)
        domain, start = self.domain(), self.start(coordinates)
        title = self.entries.text((), self.data, "title", self.name)
        source = self.entries.text((), self.data, "source", self.where)
        sketch = self.entries.text((), self.data, "sketch", "")
        self.faults.raise_if_any()
        assert system is not None
        try:
            return Mechanism(self.name, title, source, system, contacts, domain, sketch, start)
        except ModelError as error:
            self.faults.add_all(("contacts",), error)
            self.faults.raise_if_any()
            raise

    # ---- names ----

    def coordinates(self) -> tuple[Coordinate, ...]:
        if not self.data.get("coordinates"):
            self.faults.add((), 'no coordinates. Fix: add [coordinates] with x = { unit = "m" }.')
            return ()
        found = []
        for name, value in self.entries.table(("coordinates",), self.data["coordinates"]).items():
            path: Path = ("coordinates", name)
            table = self.entries.table(path, value, _COORDINATE)
            unit = self.unit(path, table)
            meaning = self.entries.text(path, table, "meaning", name)
            latex = self.entries.text(path, table, "latex", "")
            found.append(Coordinate(name, meaning, unit, latex))
        return tuple(found)

    def parameters(self) -> tuple[Parameter, ...]:
        given = self.entries.table(("parameters",), self.data.get("parameters", {}))
        contacts = self.data.get("contacts", [])
        tables = [c for c in contacts if isinstance(c, dict)] if isinstance(contacts, list) else []
        frictions = [c.get("friction") for c in tables]
        return tuple(self.parameter(n, v, n in frictions) for n, v in given.items())

    def parameter(self, name: str, value: Any, is_friction: bool) -> Parameter:
        path: Path = ("parameters", name)
        table = self.entries.table(path, value, _PARAMETER)
        positive = self.entries.flag(path, table, "positive", False)
        if positive and "lower" in table:
            self.faults.add((*path, "lower"), "positive = true says lower already. Fix: keep one.")
        lowest = 0.0 if positive or is_friction else -math.inf
        parameter = Parameter(
            name,
            self.entries.number(path, table, "default", None),
            self.unit(path, table),
            self.entries.text(path, table, "meaning", name),
            self.bound(path, table, "lower", lowest),
            self.bound(path, table, "upper", math.inf),
            self.entries.flag(path, table, "lower_closed", not positive),
            self.entries.flag(path, table, "upper_closed", True),
        )
        fault = parameter.fault(parameter.default) if "default" in table else None
        if fault:
            self.faults.add((*path, "default"), fault)
        return parameter

    def bound(self, path: Path, table: dict[str, Any], key: str, default: float) -> float:
        return self.entries.number(path, table, key, default)

    def unit(self, path: Path, table: dict[str, Any]) -> str:
        unit = self.entries.text(path, table, "unit", "")
        if "unit" not in table or (isinstance(table["unit"], str) and not unit.strip()):
            fix = 'Fix: add unit = "...", in SI, or "1" for a number without unit.'
            self.faults.add(path, f"unit is missing. {fix}")
        return unit or "1"

    def declare(
        self, coordinates: tuple[Coordinate, ...], parameters: tuple[Parameter, ...]
    ) -> bool:
        """Make names known to formulas, check them, read definitions; True if all is well."""
        names, before = self.formulas.names, len(self.faults.found)
        for c in coordinates:
            self.check_name(("coordinates", c.name), c.name)
            names |= {c.name: c.symbol, c.rate.name: c.rate}
        for p in parameters:
            self.check_name(("parameters", p.name), p.name)
            names[p.name] = p.symbol
        given = self.entries.table(("definitions",), self.data.get("definitions", {}))
        if TIME.name not in {*names, *given}:
            names[TIME.name] = TIME
        for name, text in given.items():
            path: Path = ("definitions", name)
            self.check_name(path, name)
            for fault in self.formulas.define(name, text):
                line = self.faults.lines.of_text(path, fault.line)
                self.faults.add(path, fault.message, line)
        return bool(coordinates) and len(self.faults.found) == before

    def check_name(self, path: Path, name: str) -> None:
        fault = name_fault(name)
        if fault:
            self.faults.add(path, fault)
        elif name in self.formulas.names or name in CONSTANTS:
            self.faults.add(path, f"name {name!r} is declared twice. Fix: rename one.")

    # ---- the system ----

    def system(
        self, coordinates: tuple[Coordinate, ...], parameters: tuple[Parameter, ...], named: bool
    ) -> LagrangianSystem | None:
        before = len(self.faults.found)
        bodies = read_bodies(self.entries, self.tables("bodies", BODY_KEYS))
        springs = read_springs(self.entries, self.tables("springs", SPRING_KEYS))
        loads = read_loads(self.entries, self.tables("loads", LOAD_KEYS))
        gravity = self.gravity()
        energy = self.entries.table(("energy",), self.data.get("energy", {}), _ENERGY)
        kinetic = self.entries.formula(("energy",), energy, "kinetic", 0)
        potential = self.entries.formula(("energy",), energy, "potential", 0)
        forces = self.forces(coordinates)
        if not self.data.get("bodies") and "kinetic" not in energy:
            self.faults.add((), "no mass. Fix: add [[bodies]], or [energy] with kinetic.")
        if not named or len(self.faults.found) > before or kinetic is None or potential is None:
            return None
        first = next((k for k in ("energy", "bodies") if k in self.data), "coordinates")
        try:
            return LagrangianSystem.of_bodies(
                self.name,
                coordinates,
                parameters,
                bodies,
                gravity=gravity,
                springs=springs,
                loads=loads,
                kinetic_energy=kinetic,
                potential_energy=potential,
                generalized_forces=forces,
            )
        except ModelError as error:
            self.faults.add_all((first,), error)
            return None

    def gravity(self) -> sp.Expr | tuple[sp.Expr, sp.Expr]:
        given = self.data.get("gravity", 0)
        if isinstance(given, list):
            return self.entries.pair((), self.data, "gravity", (0, 0)) or sp.Integer(0)
        return self.entries.written(("gravity",), given) or sp.Integer(0)

    def tables(self, key: str, known: tuple[str, ...]) -> list[dict[str, Any]]:
        return self.entries.tables((key,), self.data.get(key, []), known)

    def forces(self, coordinates: tuple[Coordinate, ...]) -> dict[str, sp.Expr]:
        names = [c.name for c in coordinates]
        found = {}
        for name, text in self.entries.table(("forces",), self.data.get("forces", {})).items():
            if name not in names:
                self.faults.add(("forces", name), unknown_name("coordinate", name, names))
            formula = self.entries.written(("forces", name), text)
            if formula is not None:
                found[name] = formula
        return found

    # ---- contacts and the rest ----

    def contacts(
        self, system: LagrangianSystem | None, parameters: tuple[Parameter, ...]
    ) -> tuple[Contact, ...]:
        reader = ContactReader(self.entries, parameters)
        tables = self.tables("contacts", CONTACT_KEYS)
        if not tables:
            self.faults.add(
                ("contacts",), "no contact. Fix: add [[contacts]] with point, friction."
            )
        found = [reader.read(("contacts", i), table, system) for i, table in enumerate(tables)]
        names = [c.name for c in found if c]
        for i, contact in enumerate(found):
            if contact and contact.name in names[:i]:
                fix = "Fix: give each its own name."
                self.faults.add(("contacts", i), f"name {contact.name!r} is declared twice. {fix}")
        return tuple(c for c in found if c)

    def domain(self) -> tuple[DomainBound, ...]:
        found = []
        for i, table in enumerate(self.tables("domain", ("margin", "meaning"))):
            path: Path = ("domain", i)
            margin = self.entries.formula(path, table, "margin", None)
            meaning = self.entries.text(path, table, "meaning", None)
            if margin is not None:
                found.append(DomainBound(margin, meaning))
        return tuple(found)

    def start(self, coordinates: tuple[Coordinate, ...]) -> dict[str, float]:
        table = self.entries.table(("start",), self.data.get("start", {}))
        names = [c.name for c in coordinates] + [c.rate.name for c in coordinates]
        names += [TIME.name] if self.formulas.names.get(TIME.name) == TIME else []
        for name in table:
            if name not in names:
                self.faults.add(("start", name), unknown_name("state", name, names))
        return {name: self.entries.number(("start",), table, name, None) for name in table}


def _stand_in(
    name: str, coordinates: tuple[Coordinate, ...], parameters: tuple[Parameter, ...]
) -> LagrangianSystem | None:
    """Return a system of the same names, so that contacts are checked though the energies fail."""
    kinetic = sum((c.rate**2 for c in coordinates), sp.Integer(0))
    try:
        return LagrangianSystem(name, coordinates, parameters, kinetic, sp.Integer(0))
    except ModelError:
        return None
