"""Rectangular blocks on a slope, standing on one corner or on two feet."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.bodies import Body
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, DomainBound, Parameter, positive
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import TITLES
from painleve_sym.mechanics.models.common import friction, gravity
from painleve_sym.mechanics.shapes import Shape
from painleve_sym.mechanics.system import LagrangianSystem

_SLOPE = Parameter("beta", 0.2, "rad", "angle of the slope, rising towards +x", -1.5, 1.5)


def _coordinates() -> tuple[Coordinate, Coordinate, Coordinate]:
    return (
        Coordinate("x_A", "position of the corner A along the slope, upwards", "m", "x_A"),
        Coordinate("y_A", "distance of the corner A from the slope", "m", "y_A"),
        Coordinate("theta", "angle from the slope to the base of the block", "rad", r"\theta"),
    )


def _from_corner(
    along: sp.Expr, across: sp.Expr, coordinates: tuple[Coordinate, ...]
) -> tuple[sp.Expr, sp.Expr]:
    """Return the place of a point of the block, given from A along and across its base."""
    x, y, theta = (c.symbol for c in coordinates)
    cos, sin = sp.cos(theta), sp.sin(theta)
    return x + along * cos - across * sin, y + along * sin + across * cos


def block() -> Mechanism:
    """Return a rectangular block tilted onto its corner A, which slides on a slope.

    Coordinates are those of the corner in axes along and across the slope; J = m (a² + b²)/3, so
    that m r²/J = 3 with r the distance of the corner: the smallest critical friction is 4/3.

    References
    ----------
    Lötstedt (1981).
    """
    coordinates = _coordinates()
    m = positive("m", 1.0, "kg", "mass")
    a = positive("a", 0.1, "m", "half width of the base")
    b = positive("b", 0.2, "m", "half height")
    g, mu, beta = gravity(), friction(1.5), _SLOPE.symbol
    inertia = m.symbol * (a.symbol**2 + b.symbol**2) / 3
    theta = coordinates[2].symbol
    centre = _from_corner(a.symbol, b.symbol, coordinates)
    system = LagrangianSystem.of_bodies(
        "block",
        coordinates,
        (m, a, b, _SLOPE, g, mu),
        [Body(m.symbol, centre, inertia, theta)],
        gravity=(-g.symbol * sp.sin(beta), -g.symbol * sp.cos(beta)),
    )
    corner = _from_corner(sp.Integer(0), sp.Integer(0), coordinates)
    return Mechanism(
        name="block",
        title=TITLES["block"],
        source="after Lötstedt (1981)",
        system=system,
        contacts=(Contact.of_point("A", system, corner, mu.symbol),),
        domain=(
            DomainBound(theta, "the block stands on its base at theta = 0"),
            DomainBound(sp.pi / 2 - theta, "the block lies on its side at theta = pi/2"),
        ),
        sketch=(
            "       /\\              sides 2a and 2b, mass m\n"
            "      /  \\  b          theta: from the slope to the base A--\n"
            "      \\  / \n"
            "     a \\/   theta      drawn with the slope beta level\n"
            "  _____A____________ x  gap y_A, slip velocity x_A_dot\n"
        ),
        start={"theta": 0.5, "x_A_dot": -1.0},
        shapes=(Shape.box(centre, 2 * a.symbol, 2 * b.symbol, theta),),
    )


def block_two_feet() -> Mechanism:
    """Return a block that slides on two feet A and B, each with its own friction.

    The gap of B is y_A + 2 a sinθ; its rest state θ = 0, y_A = 0 has both contacts closed.

    References
    ----------
    Várkonyi & Or (2017).
    """
    coordinates = _coordinates()
    m = positive("m", 1.0, "kg", "mass")
    J = positive("J", 0.02, "kg m^2", "moment of inertia about the mass centre")
    a = positive("a", 0.1, "m", "half distance of the feet")
    h = Parameter("h", 0.2, "m", "height of the mass centre above the feet")
    g, beta = gravity(), _SLOPE.symbol
    mu_A, mu_B = friction(0.4, "mu_A", " of the foot A"), friction(0.6, "mu_B", " of the foot B")
    theta = coordinates[2].symbol
    centre = _from_corner(a.symbol, h.symbol, coordinates)
    system = LagrangianSystem.of_bodies(
        "block-two-feet",
        coordinates,
        (m, J, a, h, _SLOPE, g, mu_A, mu_B),
        [Body(m.symbol, centre, J.symbol, theta)],
        gravity=(-g.symbol * sp.sin(beta), -g.symbol * sp.cos(beta)),
    )
    feet = {"A": (sp.Integer(0), mu_A), "B": (2 * a.symbol, mu_B)}
    contacts = tuple(
        Contact.of_point(name, system, _from_corner(along, sp.Integer(0), coordinates), mu.symbol)
        for name, (along, mu) in feet.items()
    )
    return Mechanism(
        name="block-two-feet",
        title=TITLES["block-two-feet"],
        source="after Várkonyi & Or (2017)",
        system=system,
        contacts=contacts,
        domain=(
            DomainBound(sp.cos(theta), "the block stands upright on one foot at theta = pi/2"),
        ),
        sketch=(
            "      ____________     mass m, inertia J\n"
            "     |      o     |    mass centre o: a from both feet, h above them\n"
            "     |____________|    theta: from the slope to the line A B\n"
            "      |          |     drawn with the slope beta level\n"
            "  ____A__________B__ x  gaps y_A and y_A + 2 a sin(theta)\n"
        ),
        start={"x_A_dot": -1.0},
        shapes=(Shape.box(centre, 2 * a.symbol, 2 * h.symbol, theta),),
    )
