"""Materials: moduli, densities, friction and restitution of what things are made of."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from painleve_sym.checks import text_of
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, received, refuse_unknown
from painleve_sym.mechanics.declarations import Parameter

DATA = "materials.toml"

PROPERTIES: Mapping[str, str] = {
    "young_modulus": "Pa",
    "poisson_ratio": "1",
    "density": "kg/m^3",
    "yield_strength": "Pa",
}
"""Properties that a parameter may stand for (`Parameter.material`), with their SI units."""
CONTACT_EXPONENT = "contact_exponent"
"""What a parameter stands for that is n in the force K δⁿ of a contact (`Parameter.material`)."""
HERTZ_EXPONENT = 1.5
"""n of two elastic bodies, whatever their material: a modulus says what K is with this n alone."""
PAIR_PROPERTIES = ("static_friction", "sliding_friction", "restitution")
"""What belongs to two bodies in contact; no command takes it from here, since its range is wide."""


@dataclass(frozen=True)
class MaterialValue:
    """A number from the literature, in `unit`, with its sources' keys in `painleve_sym.references`.

    `lower` and `upper` are what the sources span, both the value where they agree; `note` says
    under which condition it holds.
    """

    value: float
    lower: float
    upper: float
    unit: str
    sources: tuple[str, ...]
    note: str = ""

    @classmethod
    def of(cls, entry: Mapping[str, Any], unit: str) -> MaterialValue:
        """Return the value of an entry of the data file."""
        lower, upper = entry.get("range", (entry["value"],) * 2)
        return cls(
            entry["value"], lower, upper, unit, tuple(entry["source"]), entry.get("note", "")
        )


@dataclass(frozen=True)
class MaterialPair:
    """A material in dry contact with another, or with ``a hard floor``; None without a source."""

    other: str
    static_friction: MaterialValue | None = None
    sliding_friction: MaterialValue | None = None
    restitution: MaterialValue | None = None


@dataclass(frozen=True, eq=False)
class Material(Compared):
    """A material with its properties.

    Attributes
    ----------
    name, title : str
    properties : mapping of str to MaterialValue
        By the names of `PROPERTIES`; one that no source gives is absent.
    pairs : tuple of MaterialPair

    Examples
    --------
    >>> import painleve_sym as ps
    >>> ps.material("steel").density
    7860.0
    """

    name: str
    title: str
    properties: Mapping[str, MaterialValue]
    pairs: tuple[MaterialPair, ...] = ()

    def __repr__(self) -> str:
        """Return name, title and properties in one line."""
        known = ", ".join(f"{n}={v.value:g} {v.unit}" for n, v in self.properties.items())
        return f"Material {self.name!r} ({self.title}): {known}"

    def value_of(self, name: str, needed_for: str = "") -> float:
        """Return the value of a property in SI units.

        Raises
        ------
        InputError
            The material has none; `needed_for` tells which parameter needs it.
        """
        if name not in self.properties:
            raise InputError(
                f"material {self.name!r}: {name} is missing{needed_for}. "
                "Fix: give that parameter itself, or name another material."
            )
        return self.properties[name].value

    @property
    def young_modulus(self) -> float:
        """Young's modulus; Pa."""
        return self.value_of("young_modulus")

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio."""
        return self.value_of("poisson_ratio")

    @property
    def density(self) -> float:
        """Density; kg/m³."""
        return self.value_of("density")

    @property
    def yield_strength(self) -> float:
        """Stress from which a bar stays longer; Pa."""
        return self.value_of("yield_strength")


MaterialLike = Material | str
"""A material or its name."""
MaterialsLike = MaterialLike | Sequence[MaterialLike]
"""The material of both bodies in contact, or those of the moving body and of the other.

A text may name both: ``steel,rubber``.
"""


@cache
def materials() -> Mapping[str, Material]:
    """Return every material by its name, in the order of the data file."""
    data = tomllib.loads(Path(__file__).with_name(DATA).read_text("utf-8"))
    pairs = data.pop("pairs")
    return MappingProxyType({name: _material(name, data[name], pairs) for name in data})


def _material(name: str, entry: Mapping[str, Any], pairs: Sequence[Mapping[str, Any]]) -> Material:
    properties = {
        key: MaterialValue.of(entry[key], unit) for key, unit in PROPERTIES.items() if key in entry
    }
    own = []
    for pair in pairs:
        first, second = pair["bodies"]
        if name in (first, second):
            values = {k: MaterialValue.of(pair[k], "1") for k in PAIR_PROPERTIES if k in pair}
            own.append(MaterialPair(second if name == first else first, **values))
    return Material(name, entry["title"], properties, tuple(own))


def material(name: str) -> Material:
    """Return the named material.

    Raises
    ------
    InputError
        An unknown name; the message names the nearest.

    Examples
    --------
    >>> from painleve_sym import material
    >>> material("rubber").poisson_ratio
    0.48
    """
    refuse_unknown("material", text_of(name, "material"), materials())
    return materials()[name]


def two_materials(given: MaterialsLike) -> tuple[Material, Material]:
    """Return the materials of the moving body and of the other; a single one is for both.

    Raises
    ------
    InputError
        Unknown names, more than two.
    """
    named: Any = given.split(",") if isinstance(given, str) else given
    if isinstance(named, Material):
        return named, named
    if not isinstance(named, Sequence) or not all(isinstance(m, str | Material) for m in named):
        raise InputError(f"material: got {received(given)}, need a material, its name, or two.")
    chosen = [material(m.strip()) if isinstance(m, str) else m for m in named]
    if not 1 <= len(chosen) <= 2:
        raise InputError(
            f"material: got {len(chosen)} materials, need one of both bodies, or one of each, "
            "such as steel,rubber."
        )
    return chosen[0], chosen[-1]


def material_values(
    where: str,
    pair: tuple[Material, Material],
    declared: Sequence[Parameter],
    given: Mapping[str, Any] = MappingProxyType({}),
) -> dict[str, float]:
    """Return the values that materials give to the parameters that stand for their properties.

    The pair is that of `two_materials`; parameters in `given` have their value already and are left
    out; messages call what declares them `where`. InputError for a property that a material lacks,
    for two materials where one parameter stands for both, and for an exponent that is not Hertz's.
    """
    values = {}
    for p in declared:
        if p.material == CONTACT_EXPONENT:
            _check_exponent(where, pair, p, given.get(p.name, p.default))
            continue
        if not p.material or p.name in given:
            continue
        if p.body == 0 and pair[0] != pair[1]:
            raise InputError(
                f"{where}: got {pair[0].name} and {pair[1].name}, but parameter {p.name} is that "
                "of both bodies. Fix: name one material, or a law of two bodies "
                "(bilinear-hertz-two-bodies)."
            )
        values[p.name] = pair[p.body == 2].value_of(
            p.material, f", which parameter {p.name} of {where} needs"
        )
    return values


def _check_exponent(
    where: str, pair: tuple[Material, Material], exponent: Parameter, value: Any
) -> None:
    """Raise InputError where materials meet an exponent with which their modulus means nothing."""
    if isinstance(value, float) and value == HERTZ_EXPONENT:
        return
    names = " and ".join(dict.fromkeys(m.name for m in pair))
    raise InputError(
        f"{where}: got material {names} with {exponent.name} = {received(value)}, but the modulus "
        f"of a material gives the force of a contact by Hertz's theory, with n = {HERTZ_EXPONENT} "
        f"alone. Fix: leave {exponent.name} out, or give the parameters in place of a material."
    )
