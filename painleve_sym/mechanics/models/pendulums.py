"""A pendulum hanging from a cart that slides."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.bodies import Body, Load, Spring
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter, positive
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import TITLES
from painleve_sym.mechanics.models.common import friction, gravity
from painleve_sym.mechanics.shapes import Shape
from painleve_sym.mechanics.system import LagrangianSystem


def cart_pendulum() -> Mechanism:
    """Return a cart that slides without turning, with a pendulum on its joint.

    The reaction of the pendulum presses the cart down or lifts it, and friction drives the
    pendulum. For a point bob (J = 0) the cart's mobility has the eigenvalues 1/M and 1/(M + m):
    the smallest critical friction is 2 √(M (M + m))/m.

    References
    ----------
    Champneys & Várkonyi (2016) for the contact equations of any mechanism; the example is a common
    one.
    """
    x = Coordinate("x", "position of the cart along the ground", "m")
    y = Coordinate("y", "height of the cart above the ground", "m")
    phi = Coordinate("phi", "angle of the pendulum, from hanging down to +x", "rad", r"\varphi")
    M = positive("M", 0.5, "kg", "mass of the cart")
    m = positive("m", 2.0, "kg", "mass of the bob")
    l = positive("l", 1.0, "m", "length of the pendulum")
    J = Parameter("J", 0.0, "kg m^2", "moment of inertia of the bob about its centre", 0.0)
    c_j = Parameter("c_j", 0.0, "N m s", "viscous friction of the joint", 0.0)
    F = Parameter("F", 0.0, "N", "drive of the cart along +x")
    g, mu = gravity(), friction(1.2)
    cart = (x.symbol, y.symbol)
    sin, cos = sp.sin(phi.symbol), sp.cos(phi.symbol)
    bob = (x.symbol + l.symbol * sin, y.symbol - l.symbol * cos)
    system = LagrangianSystem.of_bodies(
        "cart-pendulum",
        (x, y, phi),
        (M, m, l, J, c_j, F, g, mu),
        [Body(M.symbol, cart), Body(m.symbol, bob, J.symbol, phi.symbol)],
        gravity=g.symbol,
        springs=[Spring(phi.symbol, damping=c_j.symbol)],
        loads=[Load.force(cart, (F.symbol, sp.Integer(0)))],
    )
    return Mechanism(
        name="cart-pendulum",
        title=TITLES["cart-pendulum"],
        source="a common example; see Champneys & Várkonyi (2016)",
        system=system,
        contacts=(Contact.of_point("cart", system, cart, mu.symbol),),
        sketch=(
            "                o bob m, J     phi: from hanging down, to +x\n"
            "              /                length l\n"
            "  F -->  [ M ]                 the cart does not turn\n"
            "  _________________ x          gap y, slip velocity x_dot\n"
        ),
        start={"phi": 2.5, "x_dot": 1.0},
        shapes=(
            Shape.box((x.symbol, y.symbol + l.symbol / 8), l.symbol / 2, l.symbol / 4),
            Shape.stick(cart, bob),
            Shape.dot(bob),
        ),
    )
