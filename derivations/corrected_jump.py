"""What does a jump at finite stiffness add to the classical rule?"""

from __future__ import annotations

import sympy as sp

from derivations._page import Derivation, Quantity, Step, cited
from derivations.equations_of_motion import mechanism
from painleve_sym.laws.impact_cases import three_phase_jump
from painleve_sym.mechanics.impact.impulse_rays import V_N
from painleve_sym.mechanics.impact.impulse_rays import V_T as SLIP
from painleve_sym.papers.formula import identical

A, B = sp.symbols("A B", negative=True)
A_STICK, DELTA, DELTA_1, K, N, TIME = sp.symbols("A_stick delta delta_1 K n t_1", positive=True)
B_STICK, B_T, C, V_T = sp.symbols("B_stick b_t C v_t", real=True)
E_S, V_1 = sp.Symbol("e_energetic", nonnegative=True), sp.Symbol("v_n_1", negative=True)
T_INF, V_3, DV_3 = sp.symbols("t_infinity v_n_3 dv_n_3", real=True)
Z = sp.Symbol("z", positive=True)
RATE = sp.Function("E")(DELTA)
SLIP_TIME, SLIP_IMPULSE = sp.Function("t")(DELTA), sp.Function("P")(DELTA)
STORED = sp.Symbol("h", real=True)
DELTA_0 = sp.Symbol("delta_0", nonnegative=True)
RATE_0, DASHPOT = sp.Symbol("delta_dot_0", real=True), sp.Symbol("c", positive=True)
LAMBDA, RATE_S, V_C = sp.symbols("lambda_stable delta_dot_s v_n_c", real=True)
B_UP = sp.Symbol("B_up", positive=True)

QUANTITIES = (
    Quantity(A, "A", "1/kg", "normal acceleration per normal force in slip, negative"),
    Quantity(B, "B", "m/s²", "free normal acceleration, negative"),
    Quantity(A_STICK, "A'", "1/kg", "normal acceleration per normal force in sticking"),
    Quantity(B_STICK, "B'", "m/s²", "free normal acceleration in sticking"),
    Quantity(C, "C", "1/kg", "tangential acceleration per normal force in slip"),
    Quantity(B_T, "b_t", "m/s²", "free tangential acceleration"),
    Quantity(V_T, "v_t", "m/s", "slip velocity before the impact"),
    Quantity(K, "K", "N/mⁿ", "stiffness of the force K δⁿ"),
    Quantity(N, "n", "1", "exponent of the force"),
    Quantity(E_S, "e_s", "1", "energetic coefficient of restitution"),
    Quantity(DELTA, r"\delta", "m", "compression"),
    Quantity(TIME, "t_1", "s", "time at which the slip stops"),
    Quantity(DELTA_1, r"\delta_1", "m", "compression at which the slip stops"),
    Quantity(V_1, "v_{n1}", "m/s", "normal velocity when the slip stops"),
    Quantity(V_3, "v_{n3}", "m/s", "normal velocity after the impact"),
    Quantity(DV_3, r"\Delta v_{n3}", "m/s", "leading correction of the rebound"),
    Quantity(T_INF, r"t_\infty", "s", "time in which an endless slip would blow up"),
    Quantity(Z, "z", "1", "ratio of the two terms of the energy integral"),
    Quantity(DELTA_0, r"\delta_0", "m", "compression at the start"),
    Quantity(RATE_0, r"\dot\delta_0", "m/s", "rate of compression at the start"),
    Quantity(DASHPOT, "c", "N s/m", "damping of a linear contact K δ + c dδ/dt"),
    Quantity(B_UP, "B_+", "m/s²", "free normal acceleration in the indeterminate state, positive"),
    Quantity(LAMBDA, r"\lambda_-", "1/s", "stable eigenvalue of slip with a linear contact"),
    Quantity(RATE_S, r"\dot\delta_s", "m/s", "rate of compression on the separating surface"),
    Quantity(V_C, "v_{n3}^c", "m/s", "normal velocity after an impact with strong damping"),
    Quantity(STORED, "h", "m²/s²", "energy integral of sticking compression at its end"),
)


_B = 1 / (2 * N)
RATIO = A * K * DELTA**N / ((N + 1) * B)
BLOW_UP = sp.sqrt(2 / -B) * (A * K / ((N + 1) * B)) ** -_B
BLOW_UP *= sp.gamma(1 + _B) * sp.gamma(sp.Rational(1, 2) - _B) / sp.sqrt(sp.pi)


def hypergeometric(power: int) -> sp.Expr:
    """Return the time of slip (power 0), or its impulse (power 1), up to a compression."""
    b = _B + power
    series = sp.hyper((sp.Rational(1, 2), b), (1 + b,), -RATIO)
    return (K * DELTA**N / (2 * N + 1)) ** power * sp.sqrt(2 * DELTA / -B) * series


def separation_velocity(v_1: sp.Expr, delta_1: sp.Expr) -> sp.Expr:
    """Return v_n(t3) from the normal velocity and the compression at the stop of the slip."""
    kinetic = (1 - A_STICK / A) * v_1**2
    return E_S * sp.sqrt(kinetic + 2 * (B_STICK - A_STICK * B / A) * delta_1)


def slip_steps() -> list[Step]:
    """Return the slip phase: energy integral, time, impulse, stop."""
    energy = sp.integrate(-A * K * DELTA**N - B, (DELTA, 0, DELTA), conds="none")
    check_series()
    return [
        Step(
            "**Slip.** With $A$ and $B$ frozen $\\ddot\\delta = -(A K \\delta^n + B)$. Multiplied "
            "by $\\dot\\delta$ and integrated from rest at $\\delta = 0$, with "
            "$E = \\dot\\delta^2/2$:",
            sp.Eq(RATE, energy),
        ),
        Step(
            "From another start (surface energy, an oblique approach) it is",
            sp.Eq(RATE, RATE_0**2 / 2 + energy - energy.subs(DELTA, DELTA_0)),
        ),
        Step(
            "From there on $\\int d\\delta/\\dot\\delta$ with its third term is not a "
            "hypergeometric function of one variable: the package integrates it by quadrature and "
            "says so. From rest at $\\delta = 0$, the first term over the second is",
            sp.Eq(Z, sp.simplify(-A * K * DELTA ** (N + 1) / (N + 1) / (-B * DELTA))),
        ),
        Step(
            "$t = \\int d\\delta/\\dot\\delta$ is, term by term of the binomial series in $z$, a "
            "Gauss hypergeometric function. The series shows it for $|z| < 1$. Integral and "
            "function are both analytic in $z$ outside $z \\le -1$, so they are equal for every "
            "$z > 0$,",
            sp.Eq(SLIP_TIME, hypergeometric(0)),
        ),
        Step(
            "and so is the impulse $P = \\int K\\delta^n d\\delta/\\dot\\delta$:",
            sp.Eq(SLIP_IMPULSE, hypergeometric(1)),
        ),
        Step(
            "The slip stops where one scalar equation holds:",
            sp.Eq(V_T + C * SLIP_IMPULSE + B_T * SLIP_TIME, 0),
        ),
        Step(
            "Eliminating the impulse from $v_n = A P + B t$ and that equation leaves the normal "
            "velocity at the stop, whatever the force law. The classical rule drops the second "
            "term, the impulse of $B$ and $b_t$:",
            sp.Eq(V_1, stop_velocity()),
        ),
    ]


def check_series() -> None:
    """Assert both hypergeometric forms term by term: each term of the integrand, integrated."""
    k = sp.Symbol("k", integer=True, nonnegative=True)
    half, b = sp.Rational(1, 2), 1 / (2 * N)
    binomial = (-1) ** k * sp.rf(half, k) / sp.factorial(k)
    for power, (top, bottom) in {0: (b, 1 + b), 1: (1 + b, 2 + b)}.items():
        # ∫ δ^(power n − 1/2 + n k) dδ over its value at k = 0.
        integrated = (power * N + half) / (power * N + half + N * k)
        term = (-1) ** k * sp.rf(half, k) * sp.rf(top, k) / sp.rf(bottom, k) / sp.factorial(k)
        ratio = term / (binomial * integrated)
        assert sp.gammasimp(ratio.rewrite(sp.gamma)) == 1, f"hypergeometric series {power}"
    # The factor in front is the first term integrated.
    x = sp.Symbol("x", positive=True)
    first = sp.integrate(K**0 / sp.sqrt(-2 * B * x), (x, 0, DELTA))
    assert sp.simplify(first - sp.sqrt(2 * DELTA / -B)) == 0
    lead = K * DELTA ** (N + half) / (N + half) / sp.sqrt(-2 * B)
    assert sp.simplify(lead - K * DELTA**N * sp.sqrt(2 * DELTA / -B) / (2 * N + 1)) == 0


def stop_velocity() -> sp.Expr:
    """Solve v_t + C P + b_t t1 = 0 for P and put it into A P + B t1."""
    P = sp.Symbol("P")
    impulse = sp.solve(V_T + C * P + B_T * TIME, P)[0]
    return sp.expand(A * impulse + B * TIME)


def sticking_steps() -> list[Step]:
    """Return sticking compression and restitution: v_n(t3) without the largest compression."""
    end, x = sp.symbols("delta_2 x", positive=True)
    work = K * end ** (N + 1) / (N + 1)
    # Restitution from x = e² δ_2 with the stiffness K e^(−2n), and compression from δ1.
    released = A_STICK * K * E_S ** (-2 * N) * x ** (N + 1) / (N + 1) + B_STICK * x
    released = sp.powsimp(sp.expand_power_base(released.subs(x, E_S**2 * end), force=True))
    assert sp.simplify(released - E_S**2 * (A_STICK * work + B_STICK * end)) == 0
    start = V_1**2 / 2 + A_STICK * K * DELTA_1 ** (N + 1) / (N + 1) + B_STICK * DELTA_1
    # The energy integral of slip gives K δ1^(n+1)/(n+1).
    stored = sp.Symbol("W")
    slip = sp.solve(V_1**2 / 2 + A * stored + B * DELTA_1, stored)[0]
    at_end = sp.expand(V_1**2 / 2 + A_STICK * slip + B_STICK * DELTA_1)
    assert sp.simplify(start.subs(K * DELTA_1 ** (N + 1), (N + 1) * slip) - at_end) == 0
    rebound = E_S * sp.sqrt(2 * at_end)
    assert identical(rebound**2, separation_velocity(V_1, DELTA_1) ** 2)
    return [
        Step(
            "**Sticking.** From the stop to the largest compression $\\dot\\delta^2/2 + "
            "A' K \\delta^{n+1}/(n+1) + B'\\delta$ keeps its value $h$. The energy integral of "
            "slip gives $K\\delta_1^{n+1}/(n+1)$, so that",
            sp.Eq(STORED, at_end),
        ),
        Step(
            "On the unloading curve $K((\\delta-\\delta_p)/e_s^2)^n$ both terms, with $A'$ and "
            "with $B'$, are $e_s^2$ times those of the loading curve. So the contact leaves with "
            "$v_{n3}^2/2 = e_s^2 h$: the largest compression is not needed,",
            sp.Eq(V_3, separation_velocity(V_1, DELTA_1)),
            function="v_n_3",
        ),
    ]


def limit_steps() -> list[Step]:
    """Return the limit K → ∞ and the leading correction."""
    check_limit()
    b = 1 / (2 * N)
    beta = sp.gamma(b) * sp.gamma(sp.Rational(1, 2) - b) / sp.gamma(sp.Rational(1, 2))
    # t = √(2/|B|) ζ^(−b) b ∫ z^(b−1) (1 + z)^(−1/2) dz, a Beta integral from 0 to ∞.
    whole = sp.sqrt(2 / -B) * (A * K / ((N + 1) * B)) ** (-b) * b * beta
    assert sp.gammasimp(whole / BLOW_UP) == 1
    return [
        Step(
            "**Limit.** For $n > 1$ the time of slip stays below its limit for "
            "$\\delta \\to \\infty$, a Beta integral over $z$ that falls like $K^{-1/(2n)}$:",
            sp.Eq(T_INF, BLOW_UP),
            function="t_infinity",
        ),
        Step(
            "So $t_1 \\to 0$, and $\\delta_1 \\to 0$ since the energy at the stop is finite: "
            "$v_{n1} \\to -(A/C)\\,v_t$ and $v_{n3} \\to e_s |v_{n1}|\\sqrt{1 - A'/A}$, the "
            "classical rule. The slip phase ends before its blow-up time by a part "
            "$K^{-(n-1)/(2n(n+1))}$ of it, and $\\delta_1$ is of the order $K^{-1/(n+1)}$, so "
            "that the first term that a finite stiffness adds to this problem, with its "
            "coefficients frozen, is of the order $K^{-1/(2n)}$ (drift of the configuration adds "
            "another of that order):",
            sp.Eq(DV_3, -E_S * sp.sqrt(1 - A_STICK / A) * stop_velocity().coeff(TIME) * BLOW_UP),
            function="dv_n_3",
        ),
    ]


def check_limit() -> None:
    """Assert that the limit is the classical rule, also as the package derives it for the rod."""
    assert sp.limit(BLOW_UP.subs(N, sp.Rational(3, 2)), K, sp.oo) == 0
    first = stop_velocity().subs(TIME, 0)
    classical = separation_velocity(first, sp.Integer(0))
    c = mechanism().coefficients
    jump = three_phase_jump(c)
    values = {A: c.A(-1), A_STICK: c.A_stick, C: c.slip_rate_coefficient(-1), V_T: SLIP}
    third = jump.phases[2].normal_velocity.subs(V_N, 0)
    assert identical(sp.expand(third**2), sp.expand((classical**2).subs(values)))


def linear_steps() -> list[Step]:
    """Return the results of Hogan & Kristiansen for a linear contact with a dashpot."""
    x, rate = sp.symbols("x lambda")
    # δ − δ* = x e^(λ t) in δ̈ = −A (K δ + c δ̇) − B_+.
    characteristic = rate**2 + A * DASHPOT * rate + A * K
    roots = sp.solve(characteristic, rate)
    stable = min(roots, key=lambda root: root.subs({A: -1, K: 1, DASHPOT: 1}))
    still = sp.solve(-A * K * x - B_UP, x)[0]
    first, second = sp.symbols("delta_1 delta_2", positive=True)
    # Without K: δ̇ + A c δ keeps its value in slip, δ̇ + A' c δ in sticking, until K δ + c δ̇ = 0.
    at_stop = sp.solve(-V_1 + A * DASHPOT * first, first)[0]
    kept = sp.Eq(-V_1 + A_STICK * DASHPOT * at_stop, A_STICK * DASHPOT * second)
    at_end = sp.solve(kept, second)
    return [
        Step(
            "**A linear contact with a dashpot**, $F = K\\delta + c\\dot\\delta$, after "
            f"{cited('HoganKristiansen2017')}, whose $p$ and $S$ are $A$ and "
            "$A'$. For $c = 0$ the limit above with $e_s = 1$ is theirs, "
            "$|v_{n1}|\\sqrt{1 + A'/|A|}$. In the indeterminate state, $A < 0 < B_+$, slip has the "
            "equilibrium $F = -B_+/A$, a saddle with the stable eigenvalue",
            sp.Eq(LAMBDA, stable),
        ),
        Step(
            "Starts on its stable direction separate lift-off from impact without collision:",
            sp.Eq(RATE_S, LAMBDA * (DELTA_0 - still)),
        ),
        Step(
            "With strong damping, $c^2|A| \\gg K$ and $K \\to \\infty$, slip follows "
            "$\\dot\\delta + A c\\,\\delta = 0$, sticking keeps $\\dot\\delta + A' c\\,\\delta$ "
            "until $\\dot\\delta$ is small, and the force ends at "
            "$\\dot\\delta = -(K/c)\\,\\delta$: the rebound is",
            sp.Eq(V_C, sp.factor(K / DASHPOT * at_end[0])),
        ),
    ]


def derive() -> Derivation:
    """Derive the jump at finite stiffness of any mechanism with one planar contact."""
    return Derivation(
        "corrected_jump",
        "The jump at finite stiffness",
        "An impact without collision of any mechanism with one planar contact and a force "
        "$K\\delta^n$, with $A$ and $B$ frozen at the start but not dropped. None of this is in "
        "the paper, whose rule is the limit $K \\to \\infty$.",
        QUANTITIES,
        (*slip_steps(), *sticking_steps(), *limit_steps(), *linear_steps()),
    )
