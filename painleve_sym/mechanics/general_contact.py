"""One contact with constant coefficients, in its own coordinates."""

from __future__ import annotations

from functools import lru_cache

import sympy as sp

from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter, positive
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import LagrangianSystem

_W_TT = positive("W_tt", 1.0, "1/kg", "tangential mobility")
_A_STICK = positive("A_stick", 1.0, "1/kg", "mobility A' in sticking")
_KAPPA = Parameter("kappa", 0.0, "1", "W_nt/W_tt")
_B_T = Parameter("b_t", 0.0, "m/s^2", "free tangential acceleration")
_B_N = Parameter("b_n", -1.0, "m/s^2", "free normal acceleration")
_MU = Parameter("mu", 1.0, "1", "friction coefficient", 0.0)
W_TT, A_STICK, MU = _W_TT.symbol, _A_STICK.symbol, _MU.symbol
KAPPA = _KAPPA.symbol
"""κ = W_nt/W_tt, the normal velocity per tangential one of a tangential impulse; 1."""


@lru_cache(maxsize=1)
def general_contact() -> Mechanism:
    """Return one contact in its own coordinates: what holds for it holds for every mechanism.

    Its parameters are W_tt > 0, κ = W_nt/W_tt and A′ = W_nn − W_nt²/W_tt > 0, by which any positive
    definite W can be written, the free accelerations b_t and b_n, and μ. All of them are constant:
    every motion of it has frozen coefficients.
    """
    t = Coordinate("x_t", "tangential displacement of the contact point", "m")
    n = Coordinate("x_n", "gap", "m")
    kinetic = t.rate**2 / (2 * W_TT)
    kinetic += (n.rate - KAPPA * t.rate) ** 2 / (2 * A_STICK)
    forces = sp.hessian(kinetic, (t.rate, n.rate)) * sp.Matrix([_B_T.symbol, _B_N.symbol])
    system = LagrangianSystem(
        name="general contact",
        coordinates=(t, n),
        parameters=(_W_TT, _A_STICK, _KAPPA, _B_T, _B_N, _MU),
        kinetic_energy=kinetic,
        potential_energy=sp.Integer(0),
        generalized_forces={"x_t": forces[0], "x_n": forces[1]},
    )
    return Mechanism(
        name=system.name,
        title="one contact with constant coefficients, in its own coordinates",
        source="Nordmark, Dankowicz & Champneys (2011)",
        system=system,
        contacts=(Contact("contact", system, n.symbol, t.rate, MU),),
    )
