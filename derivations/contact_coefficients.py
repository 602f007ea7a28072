"""How does the normal acceleration of a sliding end depend on the normal force?"""

from __future__ import annotations

import sympy as sp

from derivations._page import Derivation, Quantity, Step
from derivations.equations_of_motion import accelerations, mechanism, quantities, symbol
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.simplify import readable

W_NN, W_NT, W_TT = sp.symbols("W_nn W_nt W_tt", real=True)
A, A_RIGHT, B, C, C_RIGHT, B_T = sp.symbols("A A_right B C C_right b_t", real=True)


COEFFICIENTS = (
    Quantity(W_NN, "W_{nn}", "1/kg", "normal acceleration per normal force"),
    Quantity(W_NT, "W_{nt}", "1/kg", "normal acceleration per tangential force, and back"),
    Quantity(W_TT, "W_{tt}", "1/kg", "tangential acceleration per tangential force"),
    Quantity(A, "A", "1/kg", "normal acceleration per normal force while sliding left"),
    Quantity(A_RIGHT, "A_+", "1/kg", "normal acceleration per normal force, sliding right"),
    Quantity(B, "B", "m/s²", "normal acceleration without contact forces"),
    Quantity(B_T, "b_t", "m/s²", "tangential acceleration without contact forces"),
    Quantity(C, "C", "1/kg", "tangential acceleration per normal force while sliding left"),
    Quantity(C_RIGHT, "C_+", "1/kg", "tangential acceleration per normal force, sliding right"),
)


def steps() -> tuple[Step, ...]:
    """Return the steps to (1)–(3) and to the coefficients of both slip directions."""
    mu = symbol("mu")
    normal, slip = (sp.expand(accelerations()[symbol(f"{n}_A_ddot")]) for n in "yx")
    coefficients = mechanism().coefficients
    none = {F_N: 0, F_T: 0}
    left, right = ({F_T: sign * mu * F_N} for sign in (1, -1))
    sliding = readable(normal.subs(left).diff(F_N))
    return (
        Step(
            "The accelerations of A are linear in the contact forces. Per normal force:",
            sp.Eq(W_NN, readable(normal.diff(F_N))),
            package=coefficients.W_nn,
        ),
        Step("the coupling,", sp.Eq(W_NT, readable(normal.diff(F_T))), package=coefficients.W_nt),
        Step(
            "and per tangential:", sp.Eq(W_TT, readable(slip.diff(F_T))), package=coefficients.W_tt
        ),
        Step(
            "Without forces the end still accelerates:",
            sp.Eq(B, readable(normal.subs(none))),
            "eq-3",
            package=coefficients.B,
        ),
        Step(
            "and along the ground:", sp.Eq(B_T, readable(slip.subs(none))), package=coefficients.b_t
        ),
        Step(
            "Sliding left ($\\dot x_A < 0$) means $F_t = +\\mu F_n$. What multiplies $F_n$ is then",
            sp.Eq(A, sliding),
            "eq-2",
            package=coefficients.A(-1),
        ),
        Step(
            "so that the normal acceleration is",
            sp.Eq(symbol("y_A_ddot"), sliding * F_N + readable(normal.subs(none))),
            "eq-1",
        ),
        Step(
            "Sliding right means $F_t = -\\mu F_n$:",
            sp.Eq(A_RIGHT, readable(normal.subs(right).diff(F_N))),
            package=coefficients.A(1),
        ),
        Step(
            "The slip itself changes with $\\ddot x_A = C F_n + b_t$; to the left",
            sp.Eq(C, readable(slip.subs(left).diff(F_N))),
            package=coefficients.slip_rate_coefficient(-1),
        ),
        Step(
            "and to the right:",
            sp.Eq(C_RIGHT, readable(slip.subs(right).diff(F_N))),
            package=coefficients.slip_rate_coefficient(1),
        ),
    )


def derive() -> Derivation:
    """Derive (1)–(3) and the coefficients of both slip directions."""
    return Derivation(
        "contact_coefficients",
        "Contact coefficients of the sliding rod",
        "Continues the equations of motion. Where $A < 0$ a larger normal force accelerates the "
        "end *into* the ground: Painlevé's paradox.",
        (*quantities(), *COEFFICIENTS),
        steps(),
        {"frozen configuration": "no"},
    )
