"""By what ratio do small bounces near a sticking contact grow or die out?"""

from __future__ import annotations

import sympy as sp

from derivations._page import Derivation, Quantity, Step, cited
from painleve_sym.laws.restitution import energetic, poisson
from painleve_sym.mechanics.general_contact import KAPPA, general_contact
from painleve_sym.mechanics.simplify import readable

CONTACT = general_contact().coefficients
W_TT, A_STICK, MU = CONTACT.W_tt, CONTACT.A_stick, CONTACT.mu
E_P, E_S = poisson().parameter.symbol, energetic().parameter.symbol
FALL, B_T, V = sp.symbols("a b_t v", positive=True)
TIME, P_1, V_1, P_C, E_C = sp.symbols("T P_1 v_1 P_c E_c", real=True)
RHO_P, RHO_SQUARED = sp.symbols("rho_poisson rho_energetic_squared", positive=True)
TAU = sp.Symbol("tau", real=True)
STICK_DROP, REVERSE_DROP = sp.symbols("stick_drop reverse_drop", real=True)
E_P_AT, E_S_AT, MU_AT = sp.symbols("e_poisson_1 e_energetic_1 mu_1", positive=True)


QUANTITIES = (
    Quantity(W_TT, "W_{tt}", "1/kg", "tangential mobility"),
    Quantity(KAPPA, r"\kappa", "1", "$W_{nt}/W_{tt}$"),
    Quantity(A_STICK, "A'", "1/kg", "normal mobility in sticking, $W_{nn} - W_{nt}^2/W_{tt}$"),
    Quantity(MU, r"\mu", "1", "friction coefficient"),
    Quantity(FALL, "a", "m/s²", "fall of the free contact, $-b_n = -B$"),
    Quantity(B_T, "b_t", "m/s²", "free tangential acceleration"),
    Quantity(TAU, r"\tau", "1", "$2 b_t/a$"),
    Quantity(V, "v", "m/s", "speed with which a flight starts and ends"),
    Quantity(TIME, "T", "s", "duration of a flight"),
    Quantity(P_1, "P_1", "N s", "normal impulse until the slip stops"),
    Quantity(V_1, "v_1", "m/s", "approach speed when the slip stops"),
    Quantity(P_C, "P_c", "N s", "normal impulse of compression"),
    Quantity(E_C, "E_c", "J", "energy stored by compression"),
    Quantity(E_P, "e_P", "1", "Poisson's coefficient of restitution"),
    Quantity(E_S, "e", "1", "energetic coefficient of restitution"),
    Quantity(RHO_P, r"\rho_P", "1", "ratio of successive bounces, Poisson's restitution"),
    Quantity(RHO_SQUARED, r"\rho^2", "1", "its square, energetic restitution"),
    Quantity(E_P_AT, "e_{P,1}", "1", "Poisson's coefficient with ratio 1"),
    Quantity(E_S_AT, "e_1", "1", "energetic coefficient with ratio 1"),
    Quantity(MU_AT, r"\mu_1", "1", "friction with ratio 1, energetic restitution"),
    Quantity(STICK_DROP, "A_+ - A'", "1/kg", "fall of $dv_n/dP_n$ where the slip stops to stick"),
    Quantity(REVERSE_DROP, "A_+ - A_-", "1/kg", "fall of $dv_n/dP_n$ where the slip reverses"),
)


def bounce() -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
    """Return P₁, v₁, P_c and E_c of an impact at (τv, −v) whose slip stops in compression."""
    W_nt, W_nn = KAPPA * W_TT, A_STICK + KAPPA**2 * W_TT
    slip_rate, normal_rate = W_nt - MU * W_TT, W_nn - MU * W_nt
    p_1 = -TAU * V / slip_rate
    v_1 = V - normal_rate * p_1
    p_2 = v_1 / A_STICK
    # The normal velocity is linear in the impulse: means over both parts.
    stored = p_1 * (V + v_1) / 2 + p_2 * v_1 / 2
    return p_1, v_1, p_1 + p_2, stored


def necessity_steps() -> list[Step]:
    """Return the steps that show that bounces grow only for κτ > 0."""
    W_nt, W_nn = KAPPA * W_TT, A_STICK + KAPPA**2 * W_TT
    slip, reverse = W_nn - MU * W_nt, W_nn + MU * W_nt
    # Two pieces of compression with the slopes a and g < a: v²/2 − g E_c is what the first adds.
    g, lost, first, second = sp.symbols("g x v_0 v_1", positive=True)
    stored = (first**2 - second**2) / (2 * (g + lost)) + second**2 / (2 * g)
    excess = sp.factor(sp.simplify(first**2 / 2 - g * stored))
    assert sp.simplify(excess - lost * (first**2 - second**2) / (2 * (g + lost))) == 0
    return [
        Step(
            "**Growth needs $\\kappa\\tau > 0$**, whatever the course of the impact. Let $b_t > "
            "0$ and $\\kappa \\le 0$. In slip, sticking and reverse slip $v_n$ grows with the "
            "impulse at the rates $A_+ = W_{nn} - \\mu W_{nt}$, $A'$ and $A_- = W_{nn} + \\mu "
            "W_{nt}$. Where the slip stops the rate falls, by",
            sp.Eq(STICK_DROP, sp.factor(slip - A_STICK)),
        ),
        Step(
            "which is not negative for $\\kappa \\le 0$, or, where the slip reverses, by",
            sp.Eq(REVERSE_DROP, sp.factor(slip - reverse)),
        ),
        Step(
            "not negative either. So $v_n(P)$ is concave. Poisson: after $P_c$ it rises at most "
            "at its mean rate before, $v/P_c$, and after $e P_c$ more it is at most $e v$. "
            "Energetic: with the rate $g$ just before $P_c$, compression has rates of at least "
            "$g$, so that $v^2/2 = \\int (dv_n/dP)\\,|v_n|\\,dP \\ge g E_c$; restitution has "
            "rates of at most $g$, so that its rebound has at most $v_+^2/2 = g e^2 E_c$. In both "
            "cases the ratio is at most $e$. For Poisson's law in the course above this is its "
            "formula,",
            sp.Eq(RHO_P / E_P, 1 + KAPPA * TAU),
        ),
    ]


def derive() -> Derivation:
    """Derive the ratio of bounces with Poisson's and the energetic law, and the thresholds."""
    p_1, v_1, p_c, stored = bounce()
    rho_p = sp.simplify(A_STICK * E_P * p_c / V)
    squared = sp.cancel(sp.together(sp.expand(E_S**2 * 2 * A_STICK * stored / V**2)))
    shown = E_S**2 * ((1 + KAPPA * TAU) ** 2 - KAPPA * TAU**2 * A_STICK / (W_TT * (MU - KAPPA)))
    assert sp.simplify(squared - shown) == 0
    friction = sp.solve(sp.numer(sp.together(shown - 1)), MU)
    steps = (
        Step(
            "Near contact a bounce is so small that $W$, $b_t$ and $b_n = -a$ do not change. A "
            "flight that starts with normal speed $v$ lasts",
            sp.Eq(TIME, 2 * V / FALL),
        ),
        Step(
            "and ends with $-v$. After a sticking impact $v_t = 0$, so that the next impact is at "
            "$v_t = b_t T = \\tau v$, with",
            sp.Eq(TAU, 2 * B_T / FALL),
        ),
        Step(
            "Let $b_t > 0$. Slip stops after the impulse $-v_t/(W_{nt} - \\mu W_{tt})$,",
            sp.Eq(P_1, readable(p_1)),
        ),
        Step("when the approach speed is", sp.Eq(V_1, readable(v_1))),
        Step("Sticking, the compression ends after", sp.Eq(P_C, readable(sp.simplify(p_c)))),
        Step(
            "Poisson's restitution gives the rebound $A' e_P P_c = \\rho_P v$. Friction has "
            "dropped out:",
            sp.Eq(RHO_P, sp.factor(rho_p)),
        ),
        Step(
            "Bounces grow, reverse chatter, above",
            sp.Eq(E_P_AT, 1 / (1 + KAPPA * TAU)),
        ),
        Step(
            "The compression stores $\\int v_n\\,dP$ over both parts,",
            sp.Eq(E_C, readable(sp.simplify(stored))),
        ),
        Step(
            "of which the energetic restitution gives back $e^2$: the rebound is "
            "$\\sqrt{2 A' e^2 E_c} = \\rho v$,",
            sp.Eq(RHO_SQUARED, shown),
        ),
        Step(
            "less than Poisson's for $\\kappa\\tau > 0$. Bounces grow above",
            sp.Eq(E_S_AT, 1 / sp.sqrt(shown / E_S**2)),
        ),
        Step(
            "or, at a given restitution with $e(1 + \\kappa\\tau) > 1$, above the friction",
            sp.Eq(MU_AT, readable(friction[0])),
        ),
        *necessity_steps(),
    )
    return Derivation(
        "reverse_chatter",
        "Bounces near a sticking contact",
        "For any mechanism with one planar contact whose free normal acceleration is downward, "
        "under a constant load. The first part is for impacts whose slip stops in compression, "
        "the last for every course of an impact. Such bounces can "
        f"grow: reverse chatter, described by {cited('NordmarkEtAl2011')}.",
        QUANTITIES,
        steps,
    )
