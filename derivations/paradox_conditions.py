"""When has the sliding rod no solution, or two?"""

from __future__ import annotations

import sympy as sp

from derivations._page import Derivation, Quantity, Step
from derivations.contact_coefficients import COEFFICIENTS, A
from derivations.equations_of_motion import accelerations, mechanism, quantities, symbol
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.paradox.critical_friction import critical_friction
from painleve_sym.mechanics.simplify import readable
from painleve_sym.papers.impact_resolution.claims import CLAIMS

TAU = sp.Symbol("tau", positive=True)
MU_P, MU_MIN, TAU_MIN = sp.symbols("mu_P mu_P_min tau_min", positive=True)
TAU_LOW, TAU_HIGH = sp.symbols("tau_low tau_high", positive=True)
OMEGA_B = sp.Symbol("theta_dot_squared_B", positive=True)
F_STAR, DELTA_STAR, N = sp.symbols("F_n_star delta_star n", positive=True)
GROWTH = sp.Symbol("growth_squared", real=True)


QUANTITIES = (
    Quantity(TAU, r"\tau", "1", "tan θ"),
    Quantity(MU_P, r"\mu_P", "1", "critical friction: $A < 0$ above it"),
    Quantity(TAU_MIN, r"\tau_m", "1", "tan θ where the critical friction is smallest"),
    Quantity(MU_MIN, r"\mu_m", "1", "smallest critical friction"),
    Quantity(TAU_LOW, r"\tau_-", "1", "lower end of the range of tan θ with $A < 0$"),
    Quantity(TAU_HIGH, r"\tau_+", "1", "upper end of the range of tan θ with $A < 0$"),
    Quantity(OMEGA_B, r"\dot\theta_B^2", "1/s²", "square of the angular speed where $B = 0$"),
    Quantity(F_STAR, "F_n^*", "N", "normal force of sliding on"),
    Quantity(DELTA_STAR, r"\delta^*", "m", "compression that carries $F_n^*$"),
    Quantity(N, "n", "1", "exponent of the compression law"),
    Quantity(GROWTH, r"\lambda^2", "1/s²", "square of the growth rate of a disturbance"),
)


def in_tangent(expr: sp.Expr) -> sp.Expr:
    """Return the expression in τ = tanθ, for 0 < θ < π/2."""
    root = sp.sqrt(1 + TAU**2)
    theta = symbol("theta")
    swap = {sp.sin(theta): TAU / root, sp.cos(theta): 1 / root}
    return readable(sp.simplify(expr.subs(swap)))


def friction_steps() -> list[Step]:
    """Return the steps on the sign of A."""
    mu, coefficients = symbol("mu"), mechanism().coefficients
    letters = {name: symbol(name) for name in ("theta", "mu", "m")}
    critical = critical_friction(coefficients, slip=-1)
    minimum = critical.minimum("theta")
    normal = accelerations()[symbol("y_A_ddot")]
    a = in_tangent(sp.expand(normal.subs(F_T, mu * F_N)).diff(F_N))
    threshold = sp.solve(a, mu)[0]
    place = sp.solve(threshold.diff(TAU), TAU)[0]
    ends = sorted(sp.solve(a, TAU), key=lambda r: r.subs(mu, 2))
    range_text = "For a given friction above it, $A < 0$ lasts from"
    return [
        Step(
            "Sliding left, $\\ddot y_A = A F_n + B$. With $\\tau = \\tan\\theta$ and "
            "$0 < \\theta < \\pi/2$",
            sp.Eq(A, a),
            "eq-2",
            printed=in_tangent(CLAIMS.expression("eq-2", letters)),
            package=in_tangent(coefficients.A(-1)),
        ),
        Step(
            "which changes sign at the friction",
            sp.Eq(MU_P, threshold),
            package=in_tangent(critical.value),
        ),
        Step(
            "Its derivative vanishes where",
            sp.Eq(TAU_MIN, place),
            package=minimum.at[0],
        ),
        Step(
            "so that no configuration has $A < 0$ unless the friction exceeds",
            sp.Eq(MU_MIN, threshold.subs(TAU, place)),
            "critical-friction",
            package=minimum.value,
        ),
        Step(range_text, sp.Eq(TAU_LOW, ends[0])),
        Step("to", sp.Eq(TAU_HIGH, ends[1])),
    ]


def force_steps() -> list[Step]:
    """Return the steps on the sign of B and on the normal force."""
    omega = symbol("theta_dot")
    normal = sp.expand(accelerations()[symbol("y_A_ddot")].subs(F_T, symbol("mu") * F_N))
    free = normal.subs(F_N, 0)
    squared = sp.solve(free, omega**2)[0]
    sliding = -free / readable(normal.diff(F_N))
    delta, K = sp.symbols("delta K", positive=True)
    # δ̈ = −(A F_n + B), linearised about δ*.
    slope = -A * sp.diff(K * delta**N, delta)
    growth = sp.simplify(slope.subs(K, F_STAR / DELTA_STAR**N).subs(delta, DELTA_STAR))
    return [
        Step("$B > 0$ needs $\\dot\\theta^2$ above", sp.Eq(OMEGA_B, squared)),
        Step(
            "Sliding on ($\\ddot y_A = 0$) needs the normal force $-B/A$, which is positive only "
            "if $A$ and $B$ differ in sign. With $A > 0$, $B < 0$ it is the only solution (case "
            "1); with $A > 0$, $B > 0$ only lift-off is one (case 2); with $A < 0$, $B < 0$ there "
            "is none (case 3); with $A < 0$, $B > 0$ both are (case 4).",
            sp.Eq(F_STAR, sliding),
            "sliding-force",
            package=-mechanism().coefficients.B / mechanism().coefficients.A(-1),
        ),
        Step(
            "On a compliant contact the compression obeys $\\ddot\\delta = -(A F_n + B)$ with "
            "$F_n = K_e\\delta^n$. A small disturbance of $F_n^*$ grows like $e^{\\lambda t}$: "
            "for $A < 0$ sliding on is unstable, and with $A$ and $B$ held the side of the "
            "disturbance decides between lift-off and impact "
            "([the critical force](critical_force.md) is that of coefficients that move).",
            sp.Eq(GROWTH, growth),
        ),
    ]


def derive() -> Derivation:
    """Derive the four cases and the friction the paradox needs."""
    return Derivation(
        "paradox_conditions",
        "Conditions of Painlevé's paradox",
        "Continues the contact coefficients: where $A$ and $B$ change sign, and what then follows.",
        (*quantities(), *COEFFICIENTS, *QUANTITIES),
        (*friction_steps(), *force_steps()),
        {"frozen configuration": "in part"},
    )
