"""Painlevé's rod: slender, and of any moment of inertia."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.mechanism import DomainBound, Mechanism
from painleve_sym.mechanics.models.common import friction, gravity, positive
from painleve_sym.mechanics.shapes import Shape
from painleve_sym.mechanics.system import LagrangianSystem

_SKETCH = (
    "            o            length 2l, mass m\n"
    "          /              theta: from the ground to the rod\n"
    "        /  centre        F_n up, F_t along +x on the end A\n"
    "      / theta\n"
    "  ___A____________  x    gap y_A, slip velocity x_A_dot\n"
)


def rod() -> Mechanism:
    """Return Painlevé's example: a slender rod whose lower end A slides on level ground.

    Contact coordinates (x_A, y_A, θ) are used, so that the gap y_A is a state and keeps its
    relative precision. Centre: (x_A + l cosθ, y_A + l sinθ); J = m l²/3.

    References
    ----------
    Impact model resolution on Painlevé's paradox, Fig. 1 and equations (1)–(3).
    """
    return _rod(
        "rod",
        "slender rod with one end on rough ground (Painlevé's example)",
        "Impact model resolution on Painlevé's paradox, Fig. 1",
        sp.Integer(3),
        (),
    )


def rod_inertia() -> Mechanism:
    """Return the rod with any moment of inertia J = m l²/α.

    The paradox is possible for μ > (1 + α + tan²θ)/(α tanθ), smallest 2√(1 + α)/α at
    tanθ = √(1 + α); α = 3 is the slender rod.

    References
    ----------
    Génot & Brogliato (1999).
    """
    alpha = positive("alpha", 3.0, "1", "m l^2/J: 3 for a slender rod, more with a heavy middle")
    return _rod(
        "rod-inertia",
        "rod of any moment of inertia with one end on rough ground",
        "Génot & Brogliato (1999)",
        alpha.symbol,
        (alpha,),
    )


def _rod(
    name: str, title: str, source: str, alpha: sp.Expr, more: tuple[Parameter, ...]
) -> Mechanism:
    x = Coordinate("x_A", "position of the end A along the ground", "m", "x_A")
    y = Coordinate("y_A", "height of the end A above the ground", "m", "y_A")
    theta = Coordinate("theta", "angle from the ground to the rod", "rad", r"\theta")
    m = positive("m", 1.0, "kg", "mass")
    l = positive("l", 1.0, "m", "half length of the rod")
    g, mu = gravity(), friction(1.4)
    inertia = m.symbol * l.symbol**2 / alpha
    sin, cos = sp.sin(theta.symbol), sp.cos(theta.symbol)
    centre_x_dot = x.rate - l.symbol * sin * theta.rate
    centre_y_dot = y.rate + l.symbol * cos * theta.rate
    kinetic = m.symbol * (centre_x_dot**2 + centre_y_dot**2) / 2 + inertia * theta.rate**2 / 2
    system = LagrangianSystem(
        name=name,
        coordinates=(x, y, theta),
        parameters=(m, l, *more, g, mu),
        kinetic_energy=kinetic,
        potential_energy=m.symbol * g.symbol * (y.symbol + l.symbol * sin),
    )
    lower, length = (x.symbol, y.symbol), 2 * l.symbol
    upper = (x.symbol + length * cos, y.symbol + length * sin)
    contact = Contact.of_point("A", system, lower, mu.symbol)
    return Mechanism(
        name=name,
        title=title,
        source=source,
        system=system,
        contacts=(contact,),
        domain=(
            DomainBound(theta.symbol, "the rod lies flat at theta = 0"),
            DomainBound(sp.pi - theta.symbol, "the rod lies flat at theta = pi"),
        ),
        sketch=_SKETCH,
        start={"theta": 1.0, "x_A_dot": -1.0, "theta_dot": 1.0},
        shapes=(Shape.stick(lower, upper),),
    )
