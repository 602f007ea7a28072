"""Named mechanisms, each with its parameters, units and source."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.errors import InputError, ModelError, unknown_name
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.system import Coordinate, LagrangianSystem, Parameter


@dataclass(frozen=True)
class DomainBound:
    """A condition the model needs: `margin` > 0 inside its domain."""

    margin: sp.Expr
    meaning: str


@dataclass(frozen=True)
class Mechanism:
    """A Lagrangian system with its contacts and the domain it is valid in.

    Attributes
    ----------
    name, title, source : str
    system : LagrangianSystem
    contacts : tuple of Contact
    domain : tuple of DomainBound
    sketch : str
        A few lines of text showing the mechanism and its signs.
    """

    name: str
    title: str
    source: str
    system: LagrangianSystem
    contacts: tuple[Contact, ...]
    domain: tuple[DomainBound, ...] = ()
    sketch: str = ""

    def __post_init__(self) -> None:
        if not self.contacts:
            raise ModelError(f"mechanism {self.name!r}", ["it has no contact; need at least one."])

    @property
    def contact(self) -> Contact:
        """The only contact; InputError when there are several."""
        if len(self.contacts) != 1:
            raise InputError(
                f"mechanism {self.name!r}: got {len(self.contacts)} contacts, need one here."
            )
        return self.contacts[0]

    @cached_property
    def coefficients(self) -> ContactCoefficients:
        """Coefficients of the only contact."""
        return ContactCoefficients(self.contact)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Coordinates, then velocities: the names a state may use."""
        names = [c.name for c in self.system.coordinates]
        return (*names, *(f"{n}_dot" for n in names))


def rod() -> Mechanism:
    """Return Painlevé's example: a slender rod whose lower end A slides on level ground.

    Contact coordinates (x_A, y_A, θ) are used, so that the gap y_A is a state and keeps its
    relative precision. Centre: (x_A + l cosθ, y_A + l sinθ); J = m l²/3.

    References
    ----------
    Zhao, Liu & Chen, Fig. 1 and equations (1)–(3).
    """
    x = Coordinate("x_A", "position of the end A along the ground", "m", "x_A")
    y = Coordinate("y_A", "height of the end A above the ground", "m", "y_A")
    theta = Coordinate("theta", "angle from the ground to the rod", "rad", r"\theta")
    m = Parameter("m", 1.0, "kg", "mass", 0.0, lower_closed=False)
    l = Parameter("l", 1.0, "m", "half length of the rod", 0.0, lower_closed=False)
    g = Parameter("g", 9.8, "m/s^2", "gravity", 0.0)
    mu = Parameter("mu", 1.4, "1", "friction coefficient", 0.0)
    inertia = m.symbol * l.symbol**2 / 3
    sin, cos = sp.sin(theta.symbol), sp.cos(theta.symbol)
    centre_x_dot = x.rate - l.symbol * sin * theta.rate
    centre_y_dot = y.rate + l.symbol * cos * theta.rate
    kinetic = m.symbol * (centre_x_dot**2 + centre_y_dot**2) / 2 + inertia * theta.rate**2 / 2
    system = LagrangianSystem(
        name="rod",
        coordinates=(x, y, theta),
        parameters=(m, l, g, mu),
        kinetic_energy=kinetic,
        potential_energy=m.symbol * g.symbol * (y.symbol + l.symbol * sin),
    )
    contact = Contact.of_point("A", system, (x.symbol, y.symbol), mu.symbol)
    return Mechanism(
        name="rod",
        title="slender rod with one end on rough ground (Painlevé's example)",
        source="Zhao, Liu & Chen, Impact model resolution on Painlevé's paradox, Fig. 1",
        system=system,
        contacts=(contact,),
        domain=(
            DomainBound(theta.symbol, "the rod lies flat at theta = 0"),
            DomainBound(sp.pi - theta.symbol, "the rod lies flat at theta = pi"),
        ),
        sketch=(
            "            o            length 2l, mass m\n"
            "          /              theta: from the ground to the rod\n"
            "        /  centre        F_n up, F_t along +x on the end A\n"
            "      / theta\n"
            "  ___A____________  x    gap y_A, slip velocity x_A_dot\n"
        ),
    )


MODELS: dict[str, Callable[[], Mechanism]] = {"rod": rod}


def model(name: str) -> Mechanism:
    """Return the named mechanism; InputError suggests the nearest name."""
    if name not in MODELS:
        raise InputError(unknown_name("model", name, MODELS))
    return MODELS[name]()
