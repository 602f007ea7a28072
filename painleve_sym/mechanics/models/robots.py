"""Robots that push a tip along a surface: two links over a belt, a slider with one link."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.bodies import Body, Load, Spring
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, DomainBound, Parameter, positive
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import TITLES
from painleve_sym.mechanics.models.common import friction, gravity
from painleve_sym.mechanics.shapes import Shape
from painleve_sym.mechanics.system import LagrangianSystem


def _at(angle: sp.Symbol, length: sp.Expr) -> sp.Matrix:
    return sp.Matrix([sp.cos(angle), sp.sin(angle)]) * length


def _place(point: sp.Matrix) -> tuple[sp.Expr, sp.Expr]:
    return point[0], point[1]


def two_link_arm() -> Mechanism:
    """Return an arm of two uniform links whose tip slides on a moving belt with friction.

    Both angles are measured from the x axis, which keeps the mass matrix short. The drives and
    the viscous friction act in the joints, so the second ones on the difference of the angles.

    References
    ----------
    Zhao et al. (2008), after Liu, Zhao & Chen (2007).
    """
    one = Coordinate("theta_1", "angle of the upper link, from +x", "rad", r"\theta_1")
    two = Coordinate("theta_2", "angle of the lower link, from +x", "rad", r"\theta_2")
    m_1 = positive("m_1", 1.0, "kg", "mass of the upper link")
    m_2 = positive("m_2", 1.0, "kg", "mass of the lower link")
    l_1 = positive("l_1", 0.5, "m", "length of the upper link")
    l_2 = positive("l_2", 0.5, "m", "length of the lower link")
    h = Parameter("h", 0.7, "m", "height of the base joint above the belt")
    u = Parameter("u", 1.0, "m/s", "speed of the belt along +x")
    tau_1 = Parameter("tau_1", 0.0, "N m", "drive of the base joint, counter-clockwise")
    tau_2 = Parameter("tau_2", 0.0, "N m", "drive of the elbow, counter-clockwise")
    c_1 = Parameter("c_1", 0.0, "N m s", "viscous friction of the base joint", 0.0)
    c_2 = Parameter("c_2", 0.0, "N m s", "viscous friction of the elbow", 0.0)
    g, mu = gravity(), friction(0.6)
    a, b = one.symbol, two.symbol
    base = sp.Matrix([0, h.symbol])
    elbow = base + _at(a, l_1.symbol)
    tip = elbow + _at(b, l_2.symbol)
    upper, lower = base + _at(a, l_1.symbol / 2), elbow + _at(b, l_2.symbol / 2)
    system = LagrangianSystem.of_bodies(
        "two-link-arm",
        (one, two),
        (m_1, m_2, l_1, l_2, h, tau_1, tau_2, c_1, c_2, g, u, mu),
        [
            Body(m_1.symbol, _place(upper), m_1.symbol * l_1.symbol**2 / 12, a),
            Body(m_2.symbol, _place(lower), m_2.symbol * l_2.symbol**2 / 12, b),
        ],
        gravity=g.symbol,
        springs=[Spring(a, damping=c_1.symbol), Spring(b - a, damping=c_2.symbol)],
        loads=[Load.torque(a, tau_1.symbol), Load.torque(b - a, tau_2.symbol)],
    )
    return Mechanism(
        name="two-link-arm",
        title=TITLES["two-link-arm"],
        source="Zhao et al. (2008)",
        system=system,
        contacts=(Contact.of_point("tip", system, _place(tip), mu.symbol, surface_speed=u.symbol),),
        sketch=(
            "   O base, h above the belt    theta_1, theta_2: from +x,\n"
            "    \\  l_1, m_1                counter-clockwise (both < 0 here)\n"
            "     o elbow\n"
            "      \\  l_2, m_2\n"
            "  _____\\tip__________ x        belt moves with u along +x\n"
        ),
        # sin = -0.6 and -0.8: the tip is 0.3 + 0.4 below the base.
        start={"theta_1": -0.6435011087932844, "theta_2": -0.9272952180016122},
    )


def pr_robot() -> Mechanism:
    """Return a carriage on a level guide with a link whose tip slides on the ground.

    With a prismatic and a revolute joint the gap is a function of θ alone:
    μ_P = 2 (m_1 + m_2)/((2 m_1 + m_2) tanθ).

    References
    ----------
    Elkaranshawy et al. (2017).
    """
    x = Coordinate("x", "position of the carriage along its guide", "m")
    theta = Coordinate("theta", "angle from the ground to the link", "rad", r"\theta")
    m_1 = positive("m_1", 1.0, "kg", "mass of the carriage")
    m_2 = positive("m_2", 1.0, "kg", "mass of the link")
    l = positive("l", 0.5, "m", "half length of the link")
    h = Parameter("h", 0.8, "m", "height of the guide above the ground")
    F = Parameter("F", 0.0, "N", "drive of the carriage along +x")
    tau = Parameter("tau", 0.0, "N m", "drive of the joint, counter-clockwise: presses the tip")
    c_j = Parameter("c_j", 0.0, "N m s", "viscous friction of the joint", 0.0)
    g, mu = gravity(), friction(1.2)
    joint = sp.Matrix([x.symbol, h.symbol])
    centre, tip = (joint - _at(theta.symbol, k * l.symbol) for k in (1, 2))
    system = LagrangianSystem.of_bodies(
        "pr-robot",
        (x, theta),
        (m_1, m_2, l, h, F, tau, c_j, g, mu),
        [
            Body(m_1.symbol, _place(joint)),
            Body(m_2.symbol, _place(centre), m_2.symbol * l.symbol**2 / 3, theta.symbol),
        ],
        gravity=g.symbol,
        springs=[Spring(theta.symbol, damping=c_j.symbol)],
        loads=[
            Load.force(_place(joint), (F.symbol, sp.Integer(0))),
            Load.torque(theta.symbol, tau.symbol),
        ],
    )
    return Mechanism(
        name="pr-robot",
        title=TITLES["pr-robot"],
        source="Elkaranshawy et al. (2017)",
        system=system,
        contacts=(Contact.of_point("tip", system, _place(tip), mu.symbol),),
        domain=(DomainBound(sp.cos(theta.symbol), "the link is upright: the gap does not change"),),
        sketch=(
            "  F -->  =[ m_1 ]=====  guide, h above the ground\n"
            "            /           link: length 2l, mass m_2\n"
            "          /             theta: from the ground to the link\n"
            "        / theta\n"
            "  ____tip___________ x\n"
        ),
        # sin(theta) = h/(2 l)
        start={"theta": 0.9272952180016122, "x_dot": -1.0},
        shapes=(
            Shape.box(_place(joint), l.symbol / 2, l.symbol / 4),
            Shape.stick(_place(joint), _place(tip)),
        ),
    )
