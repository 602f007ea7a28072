"""From which initial force does an indeterminate contact impact, and how fast is sliding left?"""

from __future__ import annotations

import sympy as sp

from derivations._page import Derivation, Quantity, Step, cited
from derivations.compliance_energies import E_s as e_s
from derivations.compliance_energies import n, packaged
from derivations.equations_of_motion import accelerations, mechanism, quantities, symbol
from painleve_sym.laws.compliance import K_E
from painleve_sym.laws.compliant_laws import bilinear_hertz
from painleve_sym.laws.saddle import DEPTH, A, B, barrier, loading_saddle, unloading_saddle
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.paradox.sliding import sliding_force_rate
from painleve_sym.study.critical.sliding_solution import SlidingSolution

RATE, RATE_UNLOADING, SPEED = sp.symbols("growth_rate unloading_growth_rate v_c", positive=True)
BARRIER, x, w_squared = sp.symbols("barrier x w_squared", positive=True)
F_STAR, F_DOT = sp.symbols("F_sliding F_sliding_dot", positive=True)
F_DDOT, R, A_DOT = sp.symbols("F_sliding_ddot r A_dot", real=True)
FIRST, SECOND, DRIFT = sp.symbols("first_term second_term sliding_force_dot", real=True)
TAU = sp.Symbol("tau", positive=True)
LAYER_1, LAYER_2 = sp.Function("varphi_1")(TAU), sp.Function("varphi_2")(TAU)
"""The force in the layer at the start, F* + φ₁/λ + φ₂/λ²: φ₁ in N/s, φ₂ in N/s²."""


QUANTITIES = (
    Quantity(A, "A", "1/kg", "normal acceleration per normal force in slip, negative"),
    Quantity(B, "B", "m/s²", "normal acceleration in slip without normal force, positive"),
    Quantity(K_E, "K_e", "N/m^n", "stiffness"),
    Quantity(n, "n", "1", "exponent of the compression law"),
    Quantity(e_s, "e_s", "1", "energetic coefficient of restitution"),
    Quantity(DEPTH, r"\delta^*", "m", "compression of the sliding solution"),
    Quantity(RATE, r"\lambda", "1/s", "growth rate of a deviation from sliding, loading"),
    Quantity(
        RATE_UNLOADING,
        r"\lambda_u",
        "1/s",
        "growth rate of a deviation from sliding, unloading",
    ),
    Quantity(BARRIER, "U^*", "m²/s²", "work, per mobility, to reach the sliding solution"),
    Quantity(SPEED, "v_c", "m/s", "approach that just reaches the sliding solution"),
    Quantity(x, "x", "1", "initial compression relative to that of the sliding solution"),
    Quantity(w_squared, "w^2", "m²/s²", "square of the approach speed on the separatrix"),
    Quantity(DRIFT, r"\dot{F}^*_\mathrm{rod}", "N/s", "rate of the sliding force of the rod"),
    Quantity(F_STAR, "F_n^*", "N", "normal force of the sliding solution"),
    Quantity(F_DOT, r"\dot{F}_n^*", "N/s", "its rate along the sliding solution"),
    Quantity(F_DDOT, r"\ddot{F}_n^*", "N/s²", "its second rate along the sliding solution"),
    Quantity(R, "r", "1/s", "derivative of the rate of F_n* by the normal force"),
    Quantity(A_DOT, r"\dot{A}", "1/(kg s)", "rate of A"),
    Quantity(TAU, r"\tau", "1", "time since the start times λ"),
    Quantity(FIRST, "F_1", "N", "first term of the expansion of the critical force"),
    Quantity(SECOND, "F_2", "N", "second term of the expansion of the critical force"),
)


def layer_terms() -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
    """Return φ₁(τ), g₂(τ) and both terms of the expansion, from the boundary layer at the start.

    With τ = λt, F = F* + φ₁(τ)/λ + φ₂(τ)/λ² the motion δ̈ = −(A F + B) gives φ'' − φ = g at each
    order, and the solution that stays near sliding has φ(0) + φ'(0) = −∫ g exp(−τ) dτ.
    """
    decay = sp.exp(-TAU)

    def start(g: sp.Expr) -> sp.Expr:
        return -sp.integrate(sp.expand(g * decay), (TAU, 0, sp.oo))

    # Order 1/λ: the sliding force moves like Ḟ* τ; the contact starts at rest.
    first_force = F_DOT * (TAU + decay)
    assert sp.simplify(first_force.diff(TAU, 2) - (first_force - F_DOT * TAU)) == 0
    assert first_force.diff(TAU).subs(TAU, 0) == 0
    assert sp.simplify(first_force.subs(TAU, 0) - start(-F_DOT * TAU)) == 0
    # Order 1/λ²: F* curves, and is moved by the deviation; the slope of δ(F) and A change.
    deviation = first_force - F_DOT * TAU
    moved = F_DDOT * TAU**2 / 2 + sp.integrate(R * deviation.subs(TAU, x), (x, 0, TAU))
    bend = (1 - n) / (n * F_STAR)
    curvature = bend * (first_force * first_force.diff(TAU, 2) + first_force.diff(TAU) ** 2)
    right = -moved + A_DOT / A * TAU * deviation - curvature
    check_layer(first_force, right)
    second = sp.expand(start(right))
    return first_force, right, start(-F_DOT * TAU) / RATE, second / RATE**2


def check_layer(first: sp.Expr, right: sp.Expr) -> None:
    """Assert φ'' − φ = g of both orders by substitution into the motion itself.

    F = K δⁿ obeys δ̈ = −(A F + B) with A = A₀ + Ȧ t and with −B/A = F* + Ḟ* t + F̈* t²/2 moved by
    r ∫(F − F* − Ḟ* t) dt, all for t = τ/λ and small ε = 1/λ.
    """
    small, second = sp.Symbol("epsilon", positive=True), sp.Function("phi")(TAU)
    force = F_STAR + small * first + small**2 * second
    deviation = (first - F_DOT * TAU).subs(TAU, x)
    sliding = F_STAR + small * F_DOT * TAU + small**2 * F_DDOT * TAU**2 / 2
    sliding += small**2 * sp.integrate(R * deviation, (x, 0, TAU))
    mobility = A + A_DOT * small * TAU
    # δ = δ* (F/F*)^(1/n) and λ² = −A n F*/δ*: δ̈ = λ² d²δ/dτ² in parts of −A n F*.
    depth = (force / F_STAR) ** (1 / n)
    left = -A * n * F_STAR * depth.diff(TAU, 2)
    rest = sp.series(left + mobility * (force - sliding), small, 0, 3).removeO()
    orders = [sp.simplify(sp.expand(rest).coeff(small, k)) for k in (0, 1, 2)]
    expected = -A * (second.diff(TAU, 2) - second - right)
    assert orders[:2] == [0, 0]
    assert sp.simplify(orders[2] - expected) == 0


def packaged_second() -> sp.Expr:
    """Return the package's second term, its numbers replaced by symbols."""
    solution = SlidingSolution(
        slip=-1,
        A=A,
        B=B,
        force=F_STAR,
        force_rate=F_DOT,
        force_second_rate=F_DDOT,
        A_rate=A_DOT,
        rate_per_force=R,
        compression=DEPTH,
        compression_rate=sp.Integer(0),
        approach=sp.Integer(0),
        exponent=n,
        growth_rate=RATE,
        decay_rate=-RATE,
        unloading_growth_rate=RATE / e_s,
        unloading_decay_rate=-RATE / e_s,
        conservative=True,
    )
    return sp.nsimplify(solution.expansion[2])


def derive() -> Derivation:
    """Derive growth rate, separatrix and the expansion of the critical force."""
    law, delta = bilinear_hertz(), sp.Symbol("delta", positive=True)
    force = K_E * delta**n
    depth = (-B / (A * K_E)) ** (1 / n)
    stiffness = -B / (A * DEPTH**n)
    slope = force.diff(delta).subs(delta, DEPTH).subs(K_E, stiffness)
    rate = sp.sqrt(sp.simplify(-A * slope))
    energy = sp.integrate(B + A * force, (delta, 0, x * DEPTH)).subs(K_E, stiffness)
    level = sp.simplify(sp.expand(energy.subs(x, 1) - energy))
    work = sp.simplify(energy.subs(x, 1))
    layer, right, first, second = layer_terms()
    rod = mechanism().coefficients

    def at_depth(expr: sp.Expr) -> sp.Expr:
        return packaged(expr, law).subs(K_E, stiffness)

    unloading = sp.simplify(at_depth(unloading_saddle(law).rates[0]))
    steps = (
        Step(
            "Where $A < 0 < B$ the normal motion of the sliding contact, "
            "$\\ddot\\delta = -(A F_n + B)$, rests at the compression of $F_n^* = -B/A$:",
            sp.Eq(DEPTH, depth),
            package=packaged(loading_saddle(law).compression, law),
        ),
        Step(
            "With $A$ and $B$ held, a small deviation $\\eta$ obeys "
            "$\\ddot\\eta = -A F_n'(\\delta^*)\\,\\eta$. For a force that grows with the "
            "compression, $F_n'(\\delta^*) > 0$, the sliding solution is a saddle, and the "
            "deviation grows with",
            sp.Eq(RATE, rate),
            package=sp.simplify(at_depth(loading_saddle(law).rates[0])),
        ),
        Step(
            "On the unloading curve of the bilinear law $\\delta - \\delta_p$ is $e_s^2$ times the "
            "compression that the loading curve has at the same force. So the same equation in "
            "the force holds with $\\lambda^2/e_s^2$, here and in the expansion below:",
            sp.Eq(RATE_UNLOADING, rate / e_s),
            package=unloading,
        ),
        Step(
            "With $A$ and $B$ held, $\\dot\\delta^2/2 + \\int (B + A F_n)\\,d\\delta$ is "
            "conserved. Its value at rest on the saddle, counted from $\\delta = 0$, is",
            sp.Eq(BARRIER, work),
            package=sp.simplify(at_depth(barrier(law))),
        ),
        Step(
            "A contact that touches without compression impacts if it approaches faster than",
            sp.Eq(SPEED, sp.sqrt(2 * work)),
        ),
        Step(
            "and one that starts with $\\delta_0 = x\\,\\delta^*$ if it approaches with more than",
            sp.Eq(w_squared, sp.factor(2 * level)),
        ),
        Step(
            "But $-B/A$ moves while the contact slides. For the rod",
            sp.Eq(DRIFT, drift_of_rod()),
            package=sliding_force_rate(rod),
        ),
        *layer_steps(layer, right),
        Step(
            "So the critical force is $F_n^* + F_1 + F_2 + O(\\lambda^{-3})$ with",
            sp.Eq(FIRST, first),
            package=F_DOT / RATE,
        ),
        Step(
            "and, since $\\varphi_2'(0) = 0$ for a start at rest,",
            sp.Eq(SECOND, second),
            package=packaged_second(),
        ),
    )
    return Derivation(
        "critical_force",
        "The critical initial force of the indeterminate state",
        "The paper states that the sliding solution $F_n^* = -B/A$ separates lift-off from impact "
        "and is not stable. At finite stiffness both can be said in numbers. For linear contacts "
        f"{cited('HoganKristiansen2017')} and {cited('KristiansenHogan2018')} have done so.",
        (*quantities(), *QUANTITIES),
        steps,
        {"frozen configuration": "in part"},
    )


def layer_steps(first: sp.Expr, right: sp.Expr) -> list[Step]:
    """Return the equations of the layer at the start."""
    bend, rates = (n - 1) * F_DOT**2 / (n * F_STAR), (F_DDOT, R, A_DOT)
    parts = [rate * sp.expand(right).coeff(rate) for rate in rates]
    rest = sp.simplify((right.subs(dict.fromkeys(rates, 0))) / bend)
    g = sp.Add(*parts, bend * sp.expand(rest))
    assert sp.simplify(g - right) == 0
    return [
        Step(
            "A start at rest has to lie ahead of it. In the layer at the start, of the duration "
            "$1/\\lambda$, let $\\tau = \\lambda t$ and $F_n = F_n^* + \\varphi_1(\\tau)/\\lambda "
            "+ \\varphi_2(\\tau)/\\lambda^2$. The motion $\\ddot\\delta = -(A F_n + B)$ has at the "
            "order $1/\\lambda$, where $F_n^*$ moves,",
            sp.Eq(LAYER_1.diff(TAU, 2) - LAYER_1, -F_DOT * TAU),
        ),
        Step(
            "The start is at rest, $\\varphi_1'(0) = 0$, and the solution must not grow like "
            "$e^\\tau$ beside the sliding solution. That leaves",
            sp.Eq(LAYER_1, first),
        ),
        Step(
            "At the next order $F_n^*$ curves and is moved by the deviation at the rate $r$, $A$ "
            "changes, and so does the slope of $\\delta(F_n)$:",
            sp.Eq(LAYER_2.diff(TAU, 2) - LAYER_2, g),
        ),
        Step(
            "Multiplied by $e^{-\\tau}$ and integrated, $\\varphi_2'' - \\varphi_2 = g_2$ gives "
            "for a solution that does not grow like $e^\\tau$ $\\varphi_2(0) + \\varphi_2'(0) = "
            "-\\int_0^\\infty g_2 e^{-\\tau} d\\tau$. This is formal asymptotics: the order of "
            "the remainder is that of the next term, and no bound of it is proved. For "
            "$\\varphi_1$ the same formula returns",
            sp.Eq(LAYER_1.subs(TAU, 0), first.subs(TAU, 0)),
        ),
    ]


def drift_of_rod() -> sp.Expr:
    """Return dF*/dt of the rod by the chain rule, from Lagrange's equations."""
    motion, angle, spin = accelerations(), symbol("theta"), symbol("theta_dot")
    friction = {F_T: symbol("mu") * F_N}
    normal = sp.expand(motion[symbol("y_A_ddot")].subs(friction))
    force = sp.solve(normal, F_N)[0]
    spin_rate = motion[symbol("theta_ddot")].subs(friction).subs(F_N, force)
    return sp.factor(sp.simplify(force.diff(angle) * spin + force.diff(spin) * spin_rate))
