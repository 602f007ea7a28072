"""Blocks in parallel guides joined by a rod: the apparatus of Painlevé and Klein."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.bodies import Body, Load
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, DomainBound, Parameter, positive
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import TITLES
from painleve_sym.mechanics.models.common import friction, gravity
from painleve_sym.mechanics.shapes import Shape
from painleve_sym.mechanics.system import LagrangianSystem


def painleve_klein() -> Mechanism:
    """Return two blocks in level guides, joined by a massless rod; the lower guide is rough.

    The rough guide holds its block from both sides, so F_n has either sign. In the guide φ = φ_0,
    and the motion has no solution or two where μ tanφ_0 > (m_1 + m_2)/m_2.

    References
    ----------
    Klein (1909); Le Xuan Anh (2003).
    """
    x = Coordinate("x", "position of the lower block along its guide", "m")
    phi = Coordinate("phi", "angle from the guides to the rod", "rad", r"\varphi")
    m_1 = positive("m_1", 1.0, "kg", "mass of the lower block, in the rough guide")
    m_2 = positive("m_2", 1.0, "kg", "mass of the upper block, in the smooth guide")
    L = positive("L", 1.0, "m", "length of the rod")
    phi_0 = Parameter("phi_0", 1.2, "rad", "angle of the rod with both blocks in their guides")
    P_1 = Parameter("P_1", 0.0, "N", "force on the lower block along +x")
    P_2 = Parameter("P_2", 1.0, "N", "force on the upper block along +x")
    g, mu = gravity(), friction(0.9)
    cos, sin = sp.cos(phi.symbol), sp.sin(phi.symbol)
    height = L.symbol * sp.sin(phi_0.symbol)
    upper = (x.symbol + L.symbol * cos, height)
    lower = (x.symbol, height - L.symbol * sin)
    system = LagrangianSystem.of_bodies(
        "painleve-klein",
        (x, phi),
        (m_1, m_2, L, phi_0, P_1, P_2, g, mu),
        [Body(m_1.symbol, lower), Body(m_2.symbol, upper)],
        gravity=g.symbol,
        loads=[
            Load.force(lower, (P_1.symbol, sp.Integer(0))),
            Load.force(upper, (P_2.symbol, sp.Integer(0))),
        ],
    )
    return Mechanism(
        name="painleve-klein",
        title=TITLES["painleve-klein"],
        source="Klein (1909)",
        system=system,
        contacts=(Contact.of_point("guide", system, lower, mu.symbol, bilateral=True),),
        domain=(DomainBound(cos, "the rod is upright: the lower block cannot move in y"),),
        sketch=(
            "  =======[ m_2 ]=====   smooth guide\n"
            "          /             massless rod of length L\n"
            "        / phi\n"
            "  ==[ m_1 ]========== x  rough guide: holds the block from both sides\n"
        ),
        start={"phi": 1.2, "x_dot": 1.0},
        shapes=(
            *(Shape.box(place, L.symbol / 4, L.symbol / 8) for place in (lower, upper)),
            Shape.stick(lower, upper),
        ),
    )
