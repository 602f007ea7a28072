"""The package's closed forms against the formulas as the paper prints them.

They are typed here a second time, apart from `derivations`, so that a slip in one is seen.
"""

from __future__ import annotations

import pytest
import sympy as sp

from painleve_sym.laws.compliance import K_E, bilinear_hertz, without_ramps
from painleve_sym.laws.restitution import three_phase_jump
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_N_PLUS, V_T
from painleve_sym.mechanics.models import rod
from painleve_sym.mechanics.paradox.critical_friction import critical_friction

ROD = rod()
C = ROD.coefficients
JUMP = three_phase_jump(C)
TANGENTIAL, COMPRESSION, RESTITUTION = JUMP.course.phases
NAMES = {s.name: s for s in (*ROD.system.q, *ROD.system.q_dot)}
NAMES |= {p.name: p.symbol for p in ROD.system.parameters}
NAMES |= {str(s): s for s in (V_T, V_N, V_N_PLUS)} | {"s": sp.Symbol("s"), "c": sp.Symbol("c")}
NAMES |= {f.name: f for f in C.sticking_force.free_symbols}
OMEGA = NAMES["theta_dot"]

# Left: what the package derives. Right: what is printed, with s = sin θ, c = cos θ, and v_t, v_n
# for ẋ_A, ẏ_A where the phase begins.
PRINTED = {
    "(2)": (C.A(-1), "(1 + 3*c*(c - mu*s))/m"),
    "(3)": (C.B, "l*theta_dot**2*s - g"),
    "(13)": (C.b_n, "-g + l*theta_dot**2*s"),
    "F_t": (C.sticking_force, "(3*s*c*F_n - m*l*theta_dot**2*c)/(3*s**2 + 1)"),
    "(14) ydot(t1)": (
        TANGENTIAL.normal_velocity,
        "v_n - (1 - 3*mu*s*c + 3*c**2)/(mu - 3*s*c + 3*mu*s**2)*v_t",
    ),
    "(14) P_n1": (TANGENTIAL.normal_impulse, "-m/(mu - 3*s*c + 3*mu*s**2)*v_t"),
    "(14) thetadot(t1), restored": (
        TANGENTIAL.velocity[OMEGA],
        "theta_dot + 3*(mu*s - c)/(m*l)*(-m/(mu - 3*s*c + 3*mu*s**2)*v_t)",
    ),
    "(17)": (
        TANGENTIAL.stored_energy.subs(V_N, 0),
        "-((1 - 3*mu*s*c + 3*c**2)/(mu - 3*s*c + 3*mu*s**2)*v_t)**2/(2*(1 + 3*c*(c - mu*s))/m)",
    ),
    "(18) thetadot(t2)": (COMPRESSION.velocity[OMEGA], "theta_dot + 3*c/(4*l)*v_n"),
    "(18) P_n2, corrected": (COMPRESSION.normal_impulse, "-m*(1 + 3*s**2)/4*v_n"),
    "(19) A'": (C.A_stick, "4/(m*(1 + 3*s**2))"),
    "(19) B'": (C.B_stick, "4*l*s/(3*s**2 + 1)*theta_dot**2 - g"),
    "(20)": (COMPRESSION.stored_energy, "v_n**2/(2*4/(m*(1 + 3*s**2)))"),
    "(21) thetadot(t3)": (RESTITUTION.velocity[OMEGA], "theta_dot - 3*c/(4*l)*v_n_plus"),
}
MISPRINTED = {
    "(18) P_n2": (COMPRESSION.normal_impulse, "-m*(1 + 3*s**2)/(4*l)*v_n"),
}

# Exact points on the unit circle: equality of such closed forms is decided by numbers.
POINTS = [(sp.Rational(a, 65), sp.Rational(b, 65)) for a, b in ((16, 63), (33, 56), (52, 39))]
VALUES = [sp.Rational(k + 3, k + 7) for k in range(11)]


def _differs(derived: sp.Expr, printed: str) -> list[sp.Expr]:
    theta = NAMES["theta"]
    expected = sp.sympify(printed, locals=NAMES)
    found = []
    for sine, cosine in POINTS:
        numbers = {sp.sin(theta): sine, sp.cos(theta): cosine}
        numbers |= {NAMES["s"]: sine, NAMES["c"]: cosine}
        rest = sorted((derived.free_symbols | expected.free_symbols) - {theta}, key=str)
        plain = [s for s in rest if s not in numbers]
        numbers |= dict(zip(plain, VALUES, strict=False))
        found.append((derived - expected).subs(numbers))
    return [difference for difference in found if difference != 0]


@pytest.mark.parametrize("number", PRINTED)
def test_formula_of_the_paper_is_derived(number):
    derived, printed = PRINTED[number]
    assert _differs(derived, printed) == []


@pytest.mark.parametrize("number", MISPRINTED)
def test_formula_misprinted_in_the_paper_is_not_derived(number):
    derived, printed = MISPRINTED[number]
    assert len(_differs(derived, printed)) == len(POINTS)


def test_formula_21_separation_velocity():
    stored = sp.Symbol("E_c", nonnegative=True)
    e = JUMP.law.parameter.symbol
    printed = sp.sqrt(-2 * C.A_stick * (-(e**2) * stored))
    assert sp.simplify(JUMP.rebound**2 - printed**2) == 0
    point = {stored: 2, e: sp.Rational(3, 4), NAMES["m"]: 1, NAMES["theta"]: 1}
    assert JUMP.rebound.subs(point) > 0


def test_formula_critical_friction_is_four_thirds():
    assert critical_friction(C, slip=-1).minimum("theta").value == sp.Rational(4, 3)


def test_formulas_4_to_6_of_the_compression_law():
    law = bilinear_hertz()
    E, nu, R, n, e = (p.symbol for p in law.parameters)
    e_star = E / (2 * (1 - nu**2))
    assert sp.simplify(law.definitions[K_E] - sp.Rational(4, 3) * e_star * sp.sqrt(R)) == 0
    delta, delta_max = (sp.Symbol(name, real=True) for name in ("delta", "delta_max"))
    loading, unloading = (without_ramps(b.force) for b in law.branches[:2])
    assert loading == K_E * delta**n
    values = {n: sp.Rational(3, 2), e: sp.Rational(3, 4), K_E: 7, delta_max: 1}
    floored = next(s for s in law.definitions if s != K_E)
    for part in (sp.Rational(1, 2), sp.Rational(9, 10), 1):
        point = {**values, delta: part, floored: values[e] ** 2}
        delta_p = 1 - values[e] ** 2
        printed = 7 * ((part - delta_p) / (1 - delta_p)) ** values[n]
        assert sp.simplify(unloading.subs(point) - printed) == 0
