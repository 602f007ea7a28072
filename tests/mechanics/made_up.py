"""Mechanisms invented for tests, so that nothing holds for the rod alone."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import LagrangianSystem


def positive(name: str, default: float, unit: str, meaning: str) -> Parameter:
    """Return a parameter that must be > 0."""
    return Parameter(name, default, unit, meaning, 0.0, lower_closed=False)


def skew_block(belt: bool = False) -> Mechanism:
    """Return a point whose inertia couples both directions, as a linkage would.

    M = m [[1, c], [c, c² + d]], so W_nn = 1/(m d), W_nt = −c/(m d), W_tt = (c² + d)/(m d):
    A_s = (1 + μ s c)/(m d), which is negative for s c < −1/μ.
    """
    x = Coordinate("x", "place along the surface", "m")
    y = Coordinate("y", "height above the surface", "m")
    m = positive("m", 2.0, "kg", "mass along the surface")
    d = positive("d", 0.5, "1", "inertia that the coupling leaves across")
    c = Parameter("c", 0.8, "1", "inertial coupling of the two directions")
    g = Parameter("g", 9.8, "m/s^2", "gravity", 0.0)
    mu = Parameter("mu", 1.5, "1", "friction coefficient", 0.0)
    speed = Parameter("u", 0.3, "m/s", "speed of the belt")
    across = c.symbol**2 + d.symbol
    kinetic = m.symbol * (x.rate**2 + 2 * c.symbol * x.rate * y.rate + across * y.rate**2) / 2
    system = LagrangianSystem(
        "skew block",
        (x, y),
        (m, d, c, g, mu, speed),
        kinetic,
        m.symbol * g.symbol * y.symbol,
    )
    contact = Contact.of_point(
        "block",
        system,
        (x.symbol, y.symbol),
        mu.symbol,
        surface_speed=speed.symbol if belt else 0,
    )
    return Mechanism("skew block", "point with coupled inertia", "a test", system, (contact,))


def two_link_arm() -> Mechanism:
    """Return two massless links with point masses at their ends, hanging over a floor.

    Angles are absolute; the joint at the base has viscous friction.
    """
    a = Coordinate("alpha", "angle of the upper link", "rad", r"\alpha")
    b = Coordinate("beta", "angle of the lower link", "rad", r"\beta")
    m_1 = positive("m_1", 1.0, "kg", "mass at the elbow")
    m_2 = positive("m_2", 0.7, "kg", "mass at the tip")
    l_1 = positive("l_1", 0.5, "m", "length of the upper link")
    l_2 = positive("l_2", 0.4, "m", "length of the lower link")
    h = positive("h", 0.8, "m", "height of the base above the floor")
    k = Parameter("k", 0.1, "N m s", "viscous friction of the base joint", 0.0)
    g = Parameter("g", 9.8, "m/s^2", "gravity", 0.0)
    mu = Parameter("mu", 0.6, "1", "friction coefficient", 0.0)
    elbow = sp.Matrix([sp.cos(a.symbol), sp.sin(a.symbol)]) * l_1.symbol
    tip = elbow + sp.Matrix([sp.cos(b.symbol), sp.sin(b.symbol)]) * l_2.symbol
    q, v = (a.symbol, b.symbol), sp.Matrix([a.rate, b.rate])
    speeds = [(p.jacobian(q) * v).applyfunc(sp.expand) for p in (elbow, tip)]
    masses = (m_1.symbol, m_2.symbol)
    kinetic = sum(m * w.dot(w) / 2 for m, w in zip(masses, speeds, strict=True))
    heights = (elbow[1], tip[1])
    potential = sum(m * g.symbol * y for m, y in zip(masses, heights, strict=True))
    system = LagrangianSystem(
        "two-link arm",
        (a, b),
        (m_1, m_2, l_1, l_2, h, k, g, mu),
        kinetic,
        potential,
        {"alpha": -k.symbol * a.rate},
    )
    contact = Contact.of_point("tip", system, (tip[0], h.symbol + tip[1]), mu.symbol)
    return Mechanism("two-link arm", "two links over a floor", "a test", system, (contact,))


MADE_UP = {"skew block": skew_block, "two-link arm": two_link_arm}
