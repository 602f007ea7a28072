"""Painlevé's rod: slender, and of any moment of inertia."""

from __future__ import annotations

import sympy as sp

from painleve_sym.mechanics.bars import STATIONS, RoundBar, axial_modes, bending_modes
from painleve_sym.mechanics.bodies import Body, Mode
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, DomainBound, Parameter, positive
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models import TITLES
from painleve_sym.mechanics.models.common import friction, gravity
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
        "Génot & Brogliato (1999)",
        alpha.symbol,
        (alpha,),
    )


def _rod(name: str, source: str, alpha: sp.Expr, more: tuple[Parameter, ...]) -> Mechanism:
    x = Coordinate("x_A", "position of the end A along the ground", "m", "x_A")
    y = Coordinate("y_A", "height of the end A above the ground", "m", "y_A")
    theta = Coordinate("theta", "angle from the ground to the rod", "rad", r"\theta")
    m = positive("m", 1.0, "kg", "mass")
    l = positive("l", 1.0, "m", "half length of the rod")
    g, mu = gravity(), friction(1.4)
    inertia = m.symbol * l.symbol**2 / alpha
    sin, cos = sp.sin(theta.symbol), sp.cos(theta.symbol)
    length = None if more else 2 * l.symbol
    centre = x.symbol + l.symbol * cos, y.symbol + l.symbol * sin
    body = Body(m.symbol, centre, inertia, theta.symbol, name="rod", length=length)
    system = LagrangianSystem.of_bodies(
        name, (x, y, theta), (m, l, *more, g, mu), [body], gravity=g.symbol
    )
    lower = x.symbol, y.symbol
    upper = (x.symbol + 2 * l.symbol * cos, y.symbol + 2 * l.symbol * sin)
    return Mechanism(
        name=name,
        title=TITLES[name],
        source=source,
        system=system,
        contacts=(Contact.of_point("A", system, lower, mu.symbol),),
        domain=(
            DomainBound(theta.symbol, "the rod lies flat at theta = 0"),
            DomainBound(sp.pi - theta.symbol, "the rod lies flat at theta = pi"),
        ),
        sketch=_SKETCH,
        start={"theta": 1.0, "x_A_dot": -1.0, "theta_dot": 1.0},
        shapes=(Shape.stick(lower, upper),),
    )


def rod_bending(bending: int = 3, axial: int = 1) -> Mechanism:
    """Return the rod as a solid round elastic bar with free natural modes, up to 20 of each kind.

    x_A, y_A and θ belong to the bar's frame, of which A is the undeformed end; the gap is that of
    the deformed end. Deflections are small, sections stay plane and the bar is slender (Euler and
    Bernoulli), and it turns slowly against its modes. Every bending mode adds 4/m to the transverse
    mobility of the end, every axial one 2/m to the mobility along the rod.

    References
    ----------
    Mode shapes: Blevins (1979).
    """
    free = ("free", "free")
    x = Coordinate("x_A", "position of the frame's end A along the ground", "m", "x_A")
    y = Coordinate("y_A", "height of the frame's end A above the ground", "m", "y_A")
    theta = Coordinate("theta", "angle from the ground to the rod", "rad", r"\theta")
    m = positive("m", 1.0, "kg", "mass")
    l = positive("l", 1.0, "m", "half length of the rod")
    rho = positive("rho", 7850.0, "kg/m^3", "density", "density")
    Y = positive("Y", 2.09e11, "Pa", "Young's modulus of the rod", "young_modulus")
    zeta = Parameter("zeta", 0.0, "1", "ratio of modal to critical damping", 0.0)
    g, mu = gravity(), friction(1.4)
    bar = RoundBar(m.symbol, 2 * l.symbol, rho.symbol, Y.symbol)
    modal, modes, shapes = [], [], {}
    drawn: list[dict[sp.Symbol, tuple[sp.Expr, sp.Expr]]] = [{} for _ in range(STATIONS)]
    for i, shape in enumerate(bending_modes(free, bending), 1):
        across = Coordinate(f"w_{i}", f"bending mode {i}", "m", f"w_{{{i}}}")
        frequency = bar.bending_frequency(shape.wavenumber)
        modal.append(across)
        modes.append(Mode(across.symbol, m.symbol, frequency, zeta.symbol))
        shapes[across.symbol] = (sp.S.Zero, shape.ends[0])
        for values, value in zip(drawn, shape.line, strict=True):
            values[across.symbol] = (sp.S.Zero, value)
    for i, shape in enumerate(axial_modes(free, axial), 1):
        along = Coordinate(f"u_{i}", f"mode {i} along the rod", "m", f"u_{{{i}}}")
        stretch = 2 * m.symbol * l.symbol * shape.moment
        frequency = bar.axial_frequency(shape.wavenumber)
        modal.append(along)
        modes.append(Mode(along.symbol, m.symbol, frequency, zeta.symbol, stretch=stretch))
        shapes[along.symbol] = (shape.ends[0], sp.S.Zero)
        for values, value in zip(drawn, shape.line, strict=True):
            values[along.symbol] = (value, sp.S.Zero)
    centre = x.symbol + l.symbol * sp.cos(theta.symbol), y.symbol + l.symbol * sp.sin(theta.symbol)
    inertia = m.symbol * l.symbol**2 / 3
    body = Body(m.symbol, centre, inertia, theta.symbol, tuple(modes), "rod")
    name = "rod-bending" if (bending, axial) == (3, 1) else f"rod-bending:{bending},{axial}"
    system = LagrangianSystem.of_bodies(
        name, (x, y, theta, *modal), (m, l, rho, Y, zeta, g, mu), [body], gravity=g.symbol
    )
    end = body.point((-l.symbol, 0), shapes)
    places = (l.symbol * sp.Rational(2 * k - STATIONS + 1, STATIONS - 1) for k in range(STATIONS))
    line = (body.point((at, 0), values) for at, values in zip(places, drawn, strict=True))
    return Mechanism(
        name=name,
        title=TITLES["rod-bending"],
        source="rod of Painlevé's example with the free modes of a uniform bar",
        system=system,
        contacts=(Contact.of_point("A", system, end, mu.symbol),),
        domain=(
            DomainBound(theta.symbol, "the rod lies flat at theta = 0"),
            DomainBound(sp.pi - theta.symbol, "the rod lies flat at theta = pi"),
            DomainBound(
                l.symbol / 5 - bar.radius, "a bar thicker than a fifth of its length is not slender"
            ),
        ),
        sketch=_SKETCH,
        start={"theta": 1.0, "x_A_dot": -1.0, "theta_dot": 1.0},
        shapes=(Shape.stick(*line),),
    )
