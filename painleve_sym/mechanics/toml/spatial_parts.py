"""Parts of a mechanism file in space: bodies with an orientation, and their contacts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import sympy as sp

from painleve_sym.errors import unknown_name
from painleve_sym.mechanics.bodies import Body
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.quaternions import Quaternion
from painleve_sym.mechanics.spatial_bodies import Orientation, SpatialBody
from painleve_sym.mechanics.toml.reader import Table

BODY_IN_SPACE = ("name", "mass", "centre", "inertia", "orientation")
CONTACT_IN_SPACE = (
    "name",
    "friction",
    "static_friction",
    "point",
    "normal",
    "through",
    "surface",
    "along",
)


def is_triple(table: Table, key: str) -> bool:
    """Return whether an entry is a list of three."""
    value = table.entries.get(key)
    return isinstance(value, list) and len(value) == 3


def body_in_space(table: Table, quaternions: Mapping[str, Quaternion]) -> SpatialBody:
    """Return the body that a table with three places of its centre describes.

    Its orientation is a list of turns, or the name of one of the quaternions.
    """
    _refuse_others(table, BODY_IN_SPACE, "a body in space")
    name = table.text("name", "body")
    turned: Orientation | Quaternion = Orientation()
    turns = table.entries.get("orientation", [])
    if isinstance(turns, str):
        if turns in quaternions:
            turned = quaternions[turns]
        else:
            fix = f"Fix: declare it as [quaternions.{turns}], or give turns."
            table.fault(f"{unknown_name('quaternion', turns, quaternions)} {fix}", "orientation")
    elif not isinstance(turns, list) or any(not isinstance(t, list) or len(t) != 2 for t in turns):
        example = '[["z", "psi"], ["y", "-theta"]]'
        table.fault(f"got {turns!r}, need turns such as {example}.", "orientation")
    else:
        angles = [(str(a), table.written(q, "orientation", i)) for i, (a, q) in enumerate(turns)]
        with table.source.making(*table.path, "orientation"):
            turned = Orientation(tuple(angles))
    centre, mass = table.vector("centre"), table.formula("mass")
    return SpatialBody(mass, (centre[0], centre[1], centre[2]), _inertia(table), turned, name)


def _inertia(table: Table) -> tuple[Any, ...]:
    value = table.entries.get("inertia", [0, 0, 0])
    if isinstance(value, list) and len(value) == 3:
        if all(isinstance(row, list) and len(row) == 3 for row in value):
            return tuple(
                tuple(table.written(v, "inertia", i, k) for k, v in enumerate(row))
                for i, row in enumerate(value)
            )
        if not any(isinstance(row, list) for row in value):
            return tuple(table.written(v, "inertia", i) for i, v in enumerate(value))
    table.fault(f"got {value!r}, need three principal moments or three rows of three.", "inertia")
    return (1, 1, 1)


def contact_in_space(
    table: Table, names: Mapping[str, sp.Expr], bodies: Sequence[Body | SpatialBody]
) -> Callable[..., Contact]:
    """Return the factory, of name, system and friction, of the contact of a point in space.

    A surface may use `names` beside its place x, y, z.
    """
    _refuse_others(table, CONTACT_IN_SPACE, "a contact in space")
    point = _point(table, bodies)
    given: dict[str, Any] = {
        key: table.vector(key) for key in ("through", "along", "normal") if key in table
    }
    if "surface" not in table:
        return partial(Contact.in_space, point=point, **given)
    if "normal" in table:
        table.fault("a surface says this. Fix: leave out normal or surface.", "normal")
        del given["normal"]
    surface = table.formula_of_place("surface", ("x", "y", "z"), names)
    return partial(Contact.in_space, point=point, surface=surface, **given)


def _point(table: Table, bodies: Sequence[Body | SpatialBody]) -> tuple[sp.Expr, ...]:
    """Return the place of the point: three formulas, or a material point of a named body."""
    if not isinstance(table.entries["point"], Mapping):
        return table.vector("point")
    own = table.table("point", ("body", "at"))
    named = {body.name: body for body in bodies if not isinstance(body, Body)}
    name = own.text("body")
    x, y, z = own.vector("at")
    if name in named:
        return named[name].point((x, y, z))
    own.fault(unknown_name("body", name, named), "body")
    own.source.stand_ins += 1
    return x, y, z


def _refuse_others(table: Table, known: Sequence[str], kind: str) -> None:
    for key in table:
        if key not in known:
            table.fault(f"{key} does not belong to {kind}.", key)
