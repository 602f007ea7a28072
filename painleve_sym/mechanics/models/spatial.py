"""Mechanisms in space: a rod, a top, a brick on a corner, a slider, an arm of two links."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.bodies import Load
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, DomainBound, Parameter, positive
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import TITLES
from painleve_sym.mechanics.models.common import friction, gravity
from painleve_sym.mechanics.spatial_bodies import Orientation, SpatialBody
from painleve_sym.mechanics.system import LagrangianSystem


def _place(letter: str = "A") -> tuple[Coordinate, Coordinate, Coordinate]:
    """Return the coordinates of the end that touches the ground."""
    x, y, z = (
        Coordinate(f"{axis}_{letter}", f"{meaning} of the point {letter}", "m", f"{axis}_{letter}")
        for axis, meaning in (("x", "first place"), ("y", "second place"), ("z", "height"))
    )
    return x, y, z


def _bounds(*bodies: SpatialBody) -> tuple[DomainBound, ...]:
    return tuple(DomainBound(*bound) for body in bodies for bound in body.bounds)


def rod_3d() -> Mechanism:
    """Return the rod in space whose lower end A slides on level ground.

    The axis from A to the mass centre has the elevation θ and the azimuth ψ, and the rod turns
    about it by φ. J = m l²/α across the axis, J_3 about it. At ψ = 0 the centre lies towards +x,
    so that slip towards −x is the direction in which the planar rod meets its paradox::

        m A = 1 + α cos²θ − α μ sinθ cosθ cosβ    with the angle β of the slip from −(cosψ, sinψ)
        B = −g + l sinθ (θ̇² + ψ̇² cos²θ) − l (J_3/J) (φ̇ + ψ̇ sinθ) ψ̇ cos²θ

    References
    ----------
    Champneys & Várkonyi (2016); Cheesman, Hogan & Kristiansen (2021).
    """
    x, y, z = _place()
    theta = Coordinate("theta", "elevation of the rod above the ground", "rad", r"\theta")
    psi = Coordinate("psi", "azimuth of the rod, from +x towards +y", "rad", r"\psi")
    phi = Coordinate("phi", "turn of the rod about its axis", "rad", r"\varphi")
    m = positive("m", 1.0, "kg", "mass")
    l = positive("l", 1.0, "m", "distance from the end to the mass centre")
    alpha = positive("alpha", 3.0, "1", "m l^2/J: 3 for a slender rod, more with a heavy middle")
    J_3 = positive("J_3", 0.001, "kg m^2", "moment of inertia about the axis of the rod")
    g, mu = gravity(), friction(1.4)
    turned = Orientation((("z", psi.symbol), ("y", -theta.symbol), ("x", phi.symbol)))
    J = m.symbol * l.symbol**2 / alpha.symbol
    axis = turned.matrix[:, 0]
    end = x.symbol, y.symbol, z.symbol
    c_x, c_y, c_z = (p + l.symbol * a for p, a in zip(end, axis, strict=True))
    body = SpatialBody(m.symbol, (c_x, c_y, c_z), (J_3.symbol, J, J), turned, "rod")
    system = LagrangianSystem.of_bodies(
        "rod-3d", (x, y, z, theta, psi, phi), (m, l, alpha, J_3, g, mu), [body], gravity=g.symbol
    )
    return Mechanism(
        name="rod-3d",
        title=TITLES["rod-3d"],
        source="Champneys & Várkonyi (2016)",
        system=system,
        contacts=(Contact.in_space("A", system, end, mu.symbol),),
        domain=(
            DomainBound(sp.sin(theta.symbol), "the rod lies flat at theta = 0 and pi"),
            *_bounds(body),
        ),
        sketch=(
            "            o  centre    l from A, mass m; J = m l^2/alpha across the axis\n"
            "          /              theta: elevation, psi: azimuth from +x towards +y,\n"
            "        / theta          phi: turn about the axis\n"
            "  _____A__________ x     F_n up, F_t1 along +x, F_t2 along +y on the end A\n"
        ),
        start={"theta": 1.0, "x_A_dot": -1.0, "theta_dot": 1.0},
    )


def top() -> Mechanism:
    """Return a symmetric top whose tip slides on level ground.

    Euler's angles z, x, z: precession ψ, nutation θ from the vertical, spin φ.
    """
    x, y, z = _place("T")
    psi = Coordinate("psi", "precession about the vertical", "rad", r"\psi")
    theta = Coordinate("theta", "nutation: angle of the axis from the vertical", "rad", r"\theta")
    phi = Coordinate("phi", "spin about the axis of the top", "rad", r"\varphi")
    m = positive("m", 0.1, "kg", "mass")
    l = positive("l", 0.03, "m", "distance from the tip to the mass centre")
    J_1 = positive("J_1", 3e-5, "kg m^2", "moment of inertia across the axis, at the mass centre")
    J_3 = positive("J_3", 4e-5, "kg m^2", "moment of inertia about the axis")
    g, mu = gravity(), friction(0.3)
    turned = Orientation((("z", psi.symbol), ("x", theta.symbol), ("z", phi.symbol)))
    tip = x.symbol, y.symbol, z.symbol
    axis = turned.matrix[:, 2]
    c_x, c_y, c_z = (p + l.symbol * a for p, a in zip(tip, axis, strict=True))
    moments = J_1.symbol, J_1.symbol, J_3.symbol
    body = SpatialBody(m.symbol, (c_x, c_y, c_z), moments, turned, "top")
    system = LagrangianSystem.of_bodies(
        "top", (x, y, z, psi, theta, phi), (m, l, J_1, J_3, g, mu), [body], gravity=g.symbol
    )
    return Mechanism(
        name="top",
        title=TITLES["top"],
        source="Euler's top on a plane",
        system=system,
        contacts=(Contact.in_space("tip", system, tip, mu.symbol),),
        domain=_bounds(body),
        sketch=(
            "   \\ | z\n"
            "    \\|            theta: of the axis from the vertical, psi: precession,\n"
            "     o centre     phi: spin; l from tip to centre\n"
            "     |\n"
            "  ___T__________  F_n up, F_t1 along +x, F_t2 along +y on the tip\n"
        ),
        start={"theta": 0.5, "psi_dot": 5.0, "phi_dot": 100.0, "x_T_dot": 0.1},
    )


def brick() -> Mechanism:
    """Return a uniform brick of any sides that touches level ground with one corner.

    Turns z, y, x: yaw, pitch, roll. The corner C has the largest x, the least y and the least z
    along the axes of the brick.
    """
    x, y, z = _place("C")
    yaw = Coordinate("psi", "yaw about the vertical", "rad", r"\psi")
    pitch = Coordinate("theta", "pitch about the second axis of the brick", "rad", r"\theta")
    roll = Coordinate("phi", "roll about the first axis of the brick", "rad", r"\varphi")
    m = positive("m", 1.0, "kg", "mass")
    a = positive("a", 0.2, "m", "half side along the first axis of the brick")
    b = positive("b", 0.1, "m", "half side along its second axis")
    c = positive("c", 0.3, "m", "half side along its third axis")
    g, mu = gravity(), friction(0.6)
    turned = Orientation((("z", yaw.symbol), ("y", pitch.symbol), ("x", roll.symbol)))
    corner = x.symbol, y.symbol, z.symbol
    arm = turned.matrix * sp.Matrix([a.symbol, -b.symbol, -c.symbol])
    c_x, c_y, c_z = (p - r for p, r in zip(corner, arm, strict=True))
    A, B, C = (side.symbol**2 for side in (a, b, c))
    moments = tuple(m.symbol * pair / 3 for pair in (B + C, A + C, A + B))
    body = SpatialBody(m.symbol, (c_x, c_y, c_z), moments, turned, "brick")
    system = LagrangianSystem.of_bodies(
        "brick", (x, y, z, yaw, pitch, roll), (m, a, b, c, g, mu), [body], gravity=g.symbol
    )
    return Mechanism(
        name="brick",
        title=TITLES["brick"],
        source="uniform cuboid, rigid",
        system=system,
        contacts=(Contact.in_space("corner", system, corner, mu.symbol),),
        domain=_bounds(body),
        sketch=(
            "    .-----.\n"
            "   /     /|      psi, theta, phi: yaw, pitch, roll (turns z, y, x)\n"
            "  .-----. |      2a, 2b, 2c: sides along the axes of the brick\n"
            "  |     | .\n"
            "  |     |/       F_n up, F_t1 along +x, F_t2 along +y on the corner C\n"
            "  '-----C_____\n"
        ),
        start={"theta": 0.4, "phi": 0.3, "x_C_dot": -1.0, "y_C_dot": 0.5},
    )


def slider_3d() -> Mechanism:
    """Return a carriage on a level plane that drags a rod on a spherical joint over the ground.

    The carriage moves along x and y at the height h; the rod hangs on it at the angles ψ and θ and
    touches the ground with its other end. The gap is a function of θ alone.
    """
    x = Coordinate("x", "first place of the carriage", "m")
    y = Coordinate("y", "second place of the carriage", "m")
    psi = Coordinate("psi", "azimuth of the rod, from +x towards +y", "rad", r"\psi")
    theta = Coordinate("theta", "angle of the rod below the level", "rad", r"\theta")
    m_1 = positive("m_1", 1.0, "kg", "mass of the carriage")
    m_2 = positive("m_2", 1.0, "kg", "mass of the rod")
    l = positive("l", 0.5, "m", "half length of the rod")
    h = Parameter("h", 0.8, "m", "height of the carriage above the ground")
    F_x = Parameter("F_x", 0.0, "N", "drive of the carriage along +x")
    F_y = Parameter("F_y", 0.0, "N", "drive of the carriage along +y")
    g, mu = gravity(), friction(1.2)
    turned = Orientation((("z", psi.symbol), ("y", theta.symbol)))
    axis = turned.matrix[:, 0]
    joint = sp.Matrix([x.symbol, y.symbol, h.symbol])
    (c_x, c_y, c_z), (t_x, t_y, t_z) = (joint + k * l.symbol * axis for k in (1, 2))
    J = m_2.symbol * l.symbol**2 / 3
    carriage = joint[0], joint[1], joint[2]
    system = LagrangianSystem.of_bodies(
        "slider-3d",
        (x, y, psi, theta),
        (m_1, m_2, l, h, F_x, F_y, g, mu),
        [
            SpatialBody(m_1.symbol, carriage, name="carriage"),
            SpatialBody(m_2.symbol, (c_x, c_y, c_z), (0, J, J), turned, "rod"),
        ],
        gravity=g.symbol,
        loads=[Load.force(carriage, (F_x.symbol, F_y.symbol, sp.Integer(0)))],
    )
    upright = DomainBound(sp.cos(theta.symbol), "the rod is upright: the gap does not change")
    return Mechanism(
        name="slider-3d",
        title=TITLES["slider-3d"],
        source="prismatic-revolute robot of the plane, in space",
        system=system,
        contacts=(Contact.in_space("tip", system, (t_x, t_y, t_z), mu.symbol),),
        domain=(upright,),
        sketch=(
            "   [ m_1 ]===  level plane, h above the ground\n"
            "      \\        rod: length 2l, mass m_2; psi: azimuth, theta: below the level\n"
            "       \\\n"
            "  ______\\tip____ x\n"
        ),
        # sin(theta) = h/(2 l)
        start={"theta": 0.9272952180016122, "x_dot": 1.0},
    )


def two_link_arm_3d() -> Mechanism:
    """Return an arm of two uniform links that turns about the vertical, its tip on the ground.

    A base that turns by ψ carries the upper link at the angle θ_1, and this the lower one at θ_2,
    both above the level: three joints, as many as the contact has rows.
    """
    psi = Coordinate("psi", "turn of the base about the vertical", "rad", r"\psi")
    one = Coordinate("theta_1", "angle of the upper link above the level", "rad", r"\theta_1")
    two = Coordinate("theta_2", "angle of the lower link above the level", "rad", r"\theta_2")
    m_1 = positive("m_1", 1.0, "kg", "mass of the upper link")
    m_2 = positive("m_2", 1.0, "kg", "mass of the lower link")
    l_1 = positive("l_1", 0.5, "m", "length of the upper link")
    l_2 = positive("l_2", 0.5, "m", "length of the lower link")
    h = Parameter("h", 0.7, "m", "height of the shoulder above the ground")
    tau = [
        Parameter(name, 0.0, "N m", f"drive of {where}")
        for name, where in (
            ("tau_0", "the base about the vertical"),
            ("tau_1", "the shoulder, upwards"),
            ("tau_2", "the elbow, upwards"),
        )
    ]
    g, mu = gravity(), friction(0.6)
    a, b = one.symbol, two.symbol
    upper, lower = (Orientation((("z", psi.symbol), ("y", -angle))) for angle in (a, b))
    shoulder = sp.Matrix([0, 0, h.symbol])
    elbow = shoulder + l_1.symbol * upper.matrix[:, 0]
    tip = elbow + l_2.symbol * lower.matrix[:, 0]
    bodies = []
    for name, mass, length, start, turned in (
        ("upper link", m_1.symbol, l_1.symbol, shoulder, upper),
        ("lower link", m_2.symbol, l_2.symbol, elbow, lower),
    ):
        x, y, z = start + length * turned.matrix[:, 0] / 2
        J = mass * length**2 / 12
        bodies.append(SpatialBody(mass, (x, y, z), (0, J, J), turned, name))
    angles = psi.symbol, a, b - a
    system = LagrangianSystem.of_bodies(
        "two-link-arm-3d",
        (psi, one, two),
        (m_1, m_2, l_1, l_2, h, *tau, g, mu),
        bodies,
        gravity=g.symbol,
        loads=[Load.torque(q, t.symbol) for q, t in zip(angles, tau, strict=True)],
    )
    return Mechanism(
        name="two-link-arm-3d",
        title=TITLES["two-link-arm-3d"],
        source="arm of the plane, on a base that turns",
        system=system,
        contacts=(Contact.in_space("tip", system, (tip[0], tip[1], tip[2]), mu.symbol),),
        sketch=(
            "   O shoulder, h above the ground   psi: turn about the vertical\n"
            "    \\  l_1, m_1                     theta_1, theta_2: above the level\n"
            "     o elbow                         (both < 0 here)\n"
            "      \\  l_2, m_2\n"
            "  _____\\tip__________ x\n"
        ),
        # sin = -0.6 and -0.8: the tip is 0.3 + 0.4 below the shoulder.
        start={"theta_1": -0.6435011087932844, "theta_2": -0.9272952180016122, "psi_dot": 1.0},
    )
