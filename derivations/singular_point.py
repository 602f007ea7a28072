"""How does slip run into A = B = 0, and when does the force diverge there?"""

from __future__ import annotations

import sympy as sp

from derivations._page import Derivation, Quantity, Step, cited
from derivations.contact_coefficients import COEFFICIENTS
from derivations.equations_of_motion import accelerations, mechanism, quantities, symbol
from derivations.paradox_conditions import TAU, in_tangent
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.models.rods import rod_inertia
from painleve_sym.mechanics.paradox.singular_point import SingularPoint
from painleve_sym.mechanics.simplify import readable

ALPHA, BETA_0, BETA_1 = sp.symbols("A_dot beta_0 beta_1", real=True)
RATIO, GAMMA = sp.symbols("r gamma", real=True)
FORCE, F_DOT, F_STAR, LEFT = sp.symbols("F F_dot F_star u", real=True)
LAMBDA_A, LAMBDA_B = sp.symbols("lambda_A lambda_B", real=True)
TAU_C, MU_C, INERTIA, TIMES = sp.symbols("tau_C mu_C alpha mu_ratio", positive=True)


QUANTITIES = (
    Quantity(TAU, r"\tau", "1", "tan θ at the singular point"),
    Quantity(ALPHA, r"\dot A", "1/(kg s)", "rate of $A$ in slip"),
    Quantity(BETA_0, r"\beta_0", "m/s³", "rate of $B$ without contact force"),
    Quantity(BETA_1, r"\beta_1", "1/(kg s)", "rate of $B$ per normal force"),
    Quantity(LAMBDA_A, r"\lambda_A", "1/(kg s)", "eigenvalue with direction $(1, -F^*)$"),
    Quantity(LAMBDA_B, r"\lambda_B", "1/(kg s)", "eigenvalue with direction $(0, 1)$"),
    Quantity(RATIO, "r", "1", "ratio of the eigenvalues"),
    Quantity(GAMMA, r"\gamma", "1", "exponent of the diverging force"),
    Quantity(FORCE, "F", "N", "normal force of slip"),
    Quantity(F_DOT, r"\dot F", "N/s", "its rate"),
    Quantity(F_STAR, "F^*", "N", "normal force of the slip that stays bounded"),
    Quantity(LEFT, "u", "s", "time left until $A = 0$"),
    Quantity(TAU_C, r"\tau_C", "1", "tan θ at the singular point with equal eigenvalues"),
    Quantity(MU_C, r"\mu_C", "1", "friction with equal eigenvalues at the singular point"),
    Quantity(INERTIA, r"\alpha", "1", "$m l^2/J$ of a rod of any inertia"),
    Quantity(TIMES, r"\mu_C/\mu_P", "1", "ratio of that friction to the smallest critical one"),
)


def rates() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return Ȧ, β₀ and β₁ of the rod that slides left, from its accelerations."""
    theta, omega, mu = symbol("theta"), symbol("theta_dot"), symbol("mu")
    motion = {k: sp.expand(v.subs(F_T, mu * F_N)) for k, v in accelerations().items()}
    normal, spin = motion[symbol("y_A_ddot")], motion[symbol("theta_ddot")]
    a, b = normal.diff(F_N), normal.subs(F_N, 0)
    b_rate = sp.expand(b.diff(theta) * omega + b.diff(omega) * spin)
    return a.diff(theta) * omega, b_rate.subs(F_N, 0), b_rate.diff(F_N)


def flow_steps() -> list[Step]:
    """Return the steps on the rates of A and B and the law of the force."""
    point, (a_rate, free, forced) = SingularPoint(mechanism().coefficients), rates()
    flow = sp.Matrix([[ALPHA, 0], [BETA_0, -BETA_1]])
    assert set(flow.eigenvals()) == {ALPHA, -BETA_1}
    (direction,) = next(v for value, _, v in flow.eigenvects() if value == ALPHA)
    bounded = readable(-direction[1] / direction[0])
    # F = −B/A: its rate with Ȧ, Ḃ = β₀ + β₁F and A = −Ȧ u.
    rate = -(BETA_0 + BETA_1 * FORCE + FORCE * ALPHA) / (-ALPHA * LEFT)
    exponent = sp.simplify(rate.diff(FORCE) * LEFT)
    assert sp.simplify(rate - exponent * (FORCE - bounded) / LEFT) == 0
    # r = 1, β₁ = −Ȧ: a logarithm in place of the power.
    equal = sp.Symbol("F_0") - BETA_0 / ALPHA * sp.log(LEFT)
    assert sp.simplify(-equal.diff(LEFT) - rate.subs(BETA_1, -ALPHA).subs(FORCE, equal)) == 0
    return [
        Step(
            "In slip $F = -B/A$. With a constant friction coefficient $A$ depends on the angle "
            "alone, so that no force enters",
            sp.Eq(ALPHA, readable(a_rate)),
            package=point.A_rate,
        ),
        Step(
            "$B$ depends on $\\dot\\theta$ too: $\\dot B = \\beta_0 + \\beta_1 F$ with",
            sp.Eq(BETA_0, readable(free)),
            package=point.B_rate,
        ),
        Step("and", sp.Eq(BETA_1, readable(forced)), package=point.B_rate_per_force),
        Step(
            "In the time with $d\\tau = dt/A$ this is $A' = \\dot A\\,A$, "
            "$B' = \\beta_0 A - \\beta_1 B$, linear near the point. Its eigenvalues are",
            sp.Eq(LAMBDA_A, ALPHA),
        ),
        Step("and", sp.Eq(LAMBDA_B, -BETA_1)),
        Step(
            "Along the first direction the force $-B/A$ keeps the value",
            sp.Eq(F_STAR, bounded),
        ),
        Step(
            "With $u = t^* - t$ and $A = -\\dot A\\,u$, every force obeys "
            "$\\dot F = -(\\dot B + F\\dot A)/A = \\gamma (F - F^*)/u$, so that "
            "$F - F^* \\sim (t^* - t)^{-\\gamma}$ with",
            sp.Eq(GAMMA, readable(exponent)),
        ),
    ]


def rod_steps() -> list[Step]:
    """Return eigenvalue ratio, bounded force and threshold of the rod."""
    l, g, mu = (symbol(name) for name in ("l", "g", "mu"))
    theta, omega = symbol("theta"), symbol("theta_dot")
    point, (a_rate, free, forced) = SingularPoint(mechanism().coefficients), rates()
    at_A = {mu: (4 + TAU**2) / (3 * TAU)}
    ratio = sp.cancel(in_tangent(-forced / a_rate).subs(at_A))
    spin = sp.sqrt(g / (l * sp.sin(theta)))
    bounded = in_tangent((-free / (a_rate + forced)).subs(omega, spin)).subs(at_A)
    own = point.on_A_zero(point.bounded_force).subs(omega, spin)
    place = next(t for t in sp.solve(ratio - 1, TAU) if t.is_positive)
    (threshold,) = point.thresholds("theta")
    (general,) = SingularPoint(rod_inertia().coefficients).thresholds("theta")
    smallest = 2 * sp.sqrt(1 + INERTIA) / INERTIA
    return [
        Step(
            "At $A = 0$ the friction is $\\mu = (4 + \\tau^2)/(3\\tau)$ with "
            "$\\tau = \\tan\\theta$, and the ratio $\\lambda_B/\\lambda_A$ of the rod is",
            sp.Eq(RATIO, readable(ratio)),
            package=in_tangent(point.on_A_zero(point.eigenvalue_ratio)),
        ),
        Step(
            "At $B = 0$, $\\dot\\theta^2 = g/(l\\sin\\theta)$. There the bounded force is",
            sp.Eq(F_STAR, readable(sp.simplify(bounded))),
            package=readable(sp.simplify(in_tangent(own))),
            # The general form has the same symbol.
            function="F_star_rod",
        ),
        Step(
            "At the lower end of the range with $A < 0$, $\\tau < 2$ and $r > 0$: for $r < 1$ the "
            "force of other slips diverges, and those with $F > F^*$ jam; for $r > 1$ $F^*$ is "
            "negative and all slips lift off. For $r = 1$ the force is $F_0 - (\\beta_0/\\dot "
            "A)\\ln u$, which tends to $-\\infty$ since $\\beta_0 > 0 > \\dot A$: all lift off. "
            "At the upper end, where $\\dot\\theta < 0$, $\\tau > 2$ and $r < 0$: with $\\gamma > "
            "1$ the impulse of the force is unbounded, so that every slip stops before. Between "
            "the first two, $r = 1$ at",
            sp.Eq(TAU_C, place),
            package=threshold.at,
        ),
        Step(
            f"reached with the critical friction of {cited('GenotBrogliato1999')}",
            sp.Eq(MU_C, sp.radsimp(at_A[mu].subs(TAU, place))),
            package=threshold.friction,
        ),
        Step(
            "A rod of any inertia has $\\mu_P = 2\\sqrt{1 + \\alpha}/\\alpha$ and the same ratio",
            sp.Eq(TIMES, sp.simplify(general.friction / smallest)),
        ),
    ]


def derive() -> Derivation:
    """Derive eigenvalues, force exponent, bounded force and threshold."""
    steps = (*flow_steps(), *rod_steps())
    return Derivation(
        "singular_point",
        "Slip near A = B = 0",
        "Continues the conditions of the paradox: how the sliding rod reaches the point where both "
        "coefficients vanish. The first steps hold for any mechanism with one planar contact. "
        f"{cited('GenotBrogliato1999')} did this for the rod; the two eigenvalues are also in "
        f"{cited('NordmarkEtAl2018')}.",
        (*quantities(), *COEFFICIENTS, *QUANTITIES),
        steps,
        {"frozen configuration": "no"},
    )
