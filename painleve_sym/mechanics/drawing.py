"""Parts of a drawing of a mechanism: its shapes, the places of its contacts, the ground."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.mechanics.bodies import expr
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.shapes import ContactGeometry, Shape, is_still, suggested_shapes


def shapes_of(mechanism: Mechanism) -> tuple[Shape, ...]:
    """Return the shapes of a mechanism: those declared, else those that its bodies suggest.

    The rim of a contact is a disc. A body with one point of contact is a stick from there through
    its mass centre and as far beyond; with several points it is the polygon of these and of their
    mirror images in the mass centre. A body without a point of contact is the uniform stick of its
    inertia along its angle, of length √(12 J/m), and a point mass is a dot. An end of such a stick
    that does not move is a pin.

    Raises
    ------
    InputError
        No shapes are declared, and there are neither bodies nor rims.
    """
    shapes = drawn_shapes(mechanism)
    if not shapes:
        raise InputError(
            f"mechanism {mechanism.name!r}: there is nothing to draw, since it is given by its "
            "energies and not by bodies. Fix: declare shapes, in a file such as "
            '[[shapes]] with stick = [["x", "y"], ["x + l", "y"]].'
        )
    return shapes


def drawn_shapes(mechanism: Mechanism) -> tuple[Shape, ...]:
    """Return the shapes of a mechanism (`shapes_of`), none where there is nothing to draw."""
    geometries = [*contact_geometries(mechanism).values()]
    return mechanism.shapes or suggested_shapes(mechanism.system, geometries)


def contact_geometries(mechanism: Mechanism) -> dict[str, ContactGeometry]:
    """Return the geometry of every contact that has one, by name."""
    return {c.name: c.geometry for c in mechanism.contacts if c.geometry is not None}


def ground_surfaces(mechanism: Mechanism) -> dict[str, sp.Expr]:
    """Return the surfaces that are drawn as ground, by contact; functions of `PLACE`.

    They stand still or move as prescribed. A surface that moves with a coordinate belongs to a body
    of the mechanism, whose shape shows it.
    """
    return {
        name: geometry.surface
        for name, geometry in contact_geometries(mechanism).items()
        if is_still(mechanism.system, (geometry.surface,), driven=True)
    }


def scene_formulas(mechanism: Mechanism, shapes: Sequence[Shape]) -> dict[str, sp.Expr]:
    """Return every number that a drawing of the mechanism needs, by name.

    ``shape_i_point_k_x`` and ``…_y`` in the order of the shapes; then, for each contact c of those
    with a geometry, ``c_x``, ``c_y``, ``c_normal_x``, ``c_normal_y``, in m, and
    ``c_surface_speed``, the speed of a belt along positive slip, in m/s. Functions of coordinates,
    time and parameters.
    """
    formulas: dict[str, sp.Expr] = {}
    for i, shape in enumerate(shapes):
        for k, point in enumerate(shape.points):
            for axis, value in zip("xy", point, strict=True):
                formulas[f"shape_{i}_point_{k}_{axis}"] = expr(value)
    contacts = {c.name: c for c in mechanism.contacts}
    for name, geometry in contact_geometries(mechanism).items():
        for part, point in (("", geometry.point), ("normal_", geometry.normal)):
            for axis, value in zip("xy", point, strict=True):
                formulas[f"{name}_{part}{axis}"] = expr(value)
        formulas[f"{name}_surface_speed"] = contacts[name].surface_speed
    return formulas
