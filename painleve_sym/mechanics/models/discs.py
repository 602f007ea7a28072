"""A disc whose mass centre is not in its middle."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.bodies import Body
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter, positive
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import TITLES
from painleve_sym.mechanics.models.common import friction, gravity
from painleve_sym.mechanics.system import LagrangianSystem


def eccentric_disc() -> Mechanism:
    """Return a disc with its mass centre off the middle, slipping on level ground.

    The point that touches is not one of the disc: v_t = ẋ + r φ̇. The paradox is possible for
    μ > (J/m + d² cos²φ)/(d |cosφ| (r + d sinφ)), least at the root s = sinφ in (0, 1) of
    ρ s³ + (2κ + 1) s² + ρ (κ − 1) s − (κ + 1) = 0 with ρ = r/d and κ = J/(m d²).

    References
    ----------
    Tokieda (1997).
    """
    x = Coordinate("x", "position of the middle along the ground", "m")
    y = Coordinate("y", "height of the lowest point of the rim above the ground", "m")
    phi = Coordinate(
        "phi", "angle of the mass centre, from +x counter-clockwise", "rad", r"\varphi"
    )
    m = positive("m", 1.0, "kg", "mass")
    r = positive("r", 0.3, "m", "radius")
    d = Parameter("d", 0.2, "m", "distance of the mass centre from the middle", 0.0)
    J = positive("J", 0.02, "kg m^2", "moment of inertia about the mass centre")
    g, mu = gravity(), friction(0.9)
    middle = (x.symbol, y.symbol + r.symbol)
    cos, sin = sp.cos(phi.symbol), sp.sin(phi.symbol)
    centre = (middle[0] + d.symbol * cos, middle[1] + d.symbol * sin)
    system = LagrangianSystem.of_bodies(
        "eccentric-disc",
        (x, y, phi),
        (m, r, d, J, g, mu),
        [Body(m.symbol, centre, J.symbol, phi.symbol)],
        gravity=g.symbol,
    )
    contact = Contact.of_disc("rim", system, middle, r.symbol, phi.symbol, mu.symbol)
    return Mechanism(
        name="eccentric-disc",
        title=TITLES["eccentric-disc"],
        source="after Tokieda (1997)",
        system=system,
        contacts=(contact,),
        sketch=(
            "      .-'''-.          radius r, mass m, inertia J about o\n"
            "     /    o  \\         o: mass centre, d from the middle\n"
            "    |   +     |        phi: of the line + o, from +x\n"
            "     \\       /         slips with v_t = x_dot + r phi_dot\n"
            "  ____'-._.-'______ x   gap y under the rim\n"
        ),
        start={"phi": 0.5, "x_dot": -1.0},
    )
