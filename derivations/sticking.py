"""Which friction holds the end still, and how does it then move normal to the ground?"""

from __future__ import annotations

import sympy as sp

from derivations._page import Derivation, Quantity, Step
from derivations.equations_of_motion import accelerations, mechanism, quantities, symbol
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.simplify import readable

A_STICK, B_STICK = sp.symbols("A_stick B_stick", real=True)
MU_STICK = sp.Symbol("mu_stick", real=True)


def derive() -> Derivation:
    """Derive the sticking friction, A′ and B′ of (19) and the friction sticking needs."""
    motion, coefficients = accelerations(), mechanism().coefficients
    friction = sp.solve(motion[symbol("x_A_ddot")], F_T)[0]
    normal = sp.expand(motion[symbol("y_A_ddot")].subs(F_T, friction))
    ratio = readable(friction.subs(symbol("theta_dot"), 0) / F_N)
    steps = (
        Step(
            "Sticking keeps $\\ddot x_A = 0$. Solved for the tangential force:",
            sp.Eq(F_T, readable(friction)),
            "sticking-force",
            package=coefficients.sticking_force,
        ),
        Step(
            "With it, the normal acceleration is $\\ddot y_A = A' F_n + B'$, where",
            sp.Eq(A_STICK, readable(normal.diff(F_N))),
            "eq-19-A",
            package=coefficients.A_stick,
        ),
        Step(
            "and",
            sp.Eq(B_STICK, readable(normal.subs(F_N, 0))),
            "eq-19-B",
            package=coefficients.B_stick,
        ),
        Step(
            "Sticking holds while $|F_t| \\le \\mu F_n$. For the large forces of an impact the "
            "part of $\\dot\\theta$ drops out, and the friction must exceed the size of",
            sp.Eq(MU_STICK, ratio),
            package=-coefficients.W_nt / coefficients.W_tt,
        ),
    )
    return Derivation(
        "sticking",
        "The sticking rod",
        "Continues the equations of motion with an end that does not slip.",
        (
            *quantities(),
            Quantity(A_STICK, "A'", "1/kg", "normal acceleration per normal force in sticking"),
            Quantity(B_STICK, "B'", "m/s²", "normal acceleration in sticking without normal force"),
            Quantity(MU_STICK, r"\mu_s", "1", "tangential per normal impulse in sticking"),
        ),
        steps,
        {"constant μ": "no", "frozen configuration": "no"},
    )
