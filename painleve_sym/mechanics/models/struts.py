"""A strut on a fixed pivot, pressed against a moving surface: chalk, brake pads, door stops."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.bodies import Body, Spring
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, DomainBound, Parameter, positive
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import TITLES
from painleve_sym.mechanics.models.common import friction, gravity
from painleve_sym.mechanics.system import LagrangianSystem


def strut() -> Mechanism:
    """Return a pivoted strut (sprag) whose tip is pressed onto a moving surface by a spring.

    One coordinate gives gap and slip alike, so the Delassus matrix has rank one: A′ = 0, and
    sticking forces are not determined by the rigid model. μ_P = 1/tanθ.

    References
    ----------
    Spurr (1961); Champneys & Várkonyi (2016).
    """
    theta = Coordinate("theta", "angle from the surface to the strut", "rad", r"\theta")
    m = positive("m", 1.0, "kg", "mass")
    l = positive("l", 0.5, "m", "half length of the strut")
    h = Parameter("h", 0.8, "m", "height of the pivot above the surface")
    k_s = Parameter("k_s", 10.0, "N m/rad", "stiffness of the torsion spring at the pivot", 0.0)
    theta_0 = Parameter("theta_0", 1.5, "rad", "angle at which the spring is relaxed")
    c_s = Parameter("c_s", 0.0, "N m s/rad", "viscous friction of the pivot", 0.0)
    u = Parameter("u", 1.0, "m/s", "speed of the surface along +x")
    g, mu = gravity(), friction(0.5)
    cos, sin = sp.cos(theta.symbol), sp.sin(theta.symbol)
    centre, tip = ((-k * l.symbol * cos, h.symbol - k * l.symbol * sin) for k in (1, 2))
    system = LagrangianSystem.of_bodies(
        "strut",
        (theta,),
        (m, l, h, k_s, theta_0, c_s, u, g, mu),
        [Body(m.symbol, centre, m.symbol * l.symbol**2 / 3, theta.symbol)],
        gravity=g.symbol,
        springs=[Spring(theta.symbol - theta_0.symbol, k_s.symbol, c_s.symbol)],
    )
    return Mechanism(
        name="strut",
        title=TITLES["strut"],
        source="Spurr (1961)",
        system=system,
        contacts=(Contact.of_point("tip", system, tip, mu.symbol, surface_speed=u.symbol),),
        domain=(
            DomainBound(sp.cos(theta.symbol), "the strut is upright: the gap does not change"),
        ),
        sketch=(
            "            O pivot with a torsion spring k_s, h above the surface\n"
            "          /   length 2l, mass m\n"
            "        / theta\n"
            "  ____tip___________ x   the surface moves with u along +x\n"
        ),
        # sin(theta) = h/(2 l)
        start={"theta": 0.9272952180016122},
    )
