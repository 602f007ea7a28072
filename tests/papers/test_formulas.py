"""The package's closed forms against the formulas of the claims, and the test of equality."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

from painleve_sym.laws.compliance import K_E, bilinear_hertz, without_ramps
from painleve_sym.laws.restitution import E_C, three_phase_jump
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_N_PLUS, V_T
from painleve_sym.mechanics.models import rod
from painleve_sym.mechanics.paradox.critical_friction import critical_friction
from painleve_sym.papers.formula import identical
from painleve_sym.papers.impact_resolution.claims import CLAIMS
from painleve_sym.papers.impact_resolution.formulas import compare, derived_forms
from painleve_sym.papers.impact_resolution.runs import Workbench
from painleve_sym.papers.item import Verdict

ROD = rod()
C = ROD.coefficients
JUMP = three_phase_jump(C)
OMEGA = ROD.system.q_dot[2]
NAMES = {s.name: s for s in (*ROD.system.q, *ROD.system.q_dot)}
NAMES |= {p.name: p.symbol for p in ROD.system.parameters}
NAMES |= {f.name: f for f in C.sticking_force.free_symbols}
# The velocities where a phase begins have one name in the package.
NAMES |= {"x_A_dot_0": V_T, "y_A_dot_0": V_N, "y_A_dot_1": V_N, "y_A_dot_3": V_N_PLUS}
NAMES |= {f"theta_dot_{phase}": OMEGA for phase in range(3)}
NAMES |= {"e_s": JUMP.law.parameter.symbol, "P_n1": JUMP.tangential.normal_impulse}

# The package's closed form of each formula.
PACKAGE = {
    "eq-2": C.A(-1),
    "eq-3": C.B,
    "eq-13": C.b_n,
    "sticking-force": C.sticking_force,
    "eq-14-normal": JUMP.tangential.normal_velocity,
    "eq-14-impulse": JUMP.tangential.normal_impulse,
    "eq-14-spin": JUMP.tangential.velocity[OMEGA],
    "eq-18-spin": JUMP.compression.velocity[OMEGA],
    "eq-18-impulse": JUMP.compression.normal_impulse,
    "eq-19-A": C.A_stick,
    "eq-19-B": C.B_stick,
    "eq-20": JUMP.compression.stored_energy,
    "eq-21-spin": JUMP.restitution.velocity[OMEGA],
    "critical-friction": critical_friction(C, slip=-1).minimum("theta").value,
}
# Exact points on the unit circle: equality of such closed forms is decided by numbers.
POINTS = [(sp.Rational(a, 65), sp.Rational(b, 65)) for a, b in ((16, 63), (33, 56), (52, 39))]


def differences(derived: sp.Expr, printed: sp.Expr) -> list[sp.Expr]:
    theta, left = NAMES["theta"], derived - printed
    rest = sorted(left.free_symbols - {theta}, key=str)
    values = {s: sp.Rational(k + 3, k + 7) for k, s in enumerate(rest)}
    at = [left.subs({sp.sin(theta): s, sp.cos(theta): c}).subs(values) for s, c in POINTS]
    return [difference for difference in at if difference != 0]


@pytest.mark.parametrize("name", PACKAGE)
def test_formula_of_the_paper_is_derived(name):
    assert differences(PACKAGE[name], CLAIMS.expression(name, NAMES, corrected=True)) == []


def test_formula_misprinted_in_the_paper_is_not_derived():
    printed = CLAIMS.expression("eq-18-impulse", NAMES)
    assert len(differences(PACKAGE["eq-18-impulse"], printed)) == len(POINTS)


def test_formula_17_is_the_energy_of_an_impact_without_approach():
    printed = CLAIMS.expression("eq-17", NAMES | {"y_A_dot_1": JUMP.tangential.normal_velocity})
    stored = JUMP.tangential.stored_energy
    assert differences(stored.subs(V_N, 0), printed.subs(V_N, 0)) == []


def test_formula_21_separation_velocity():
    released = -(NAMES["e_s"] ** 2) * E_C
    printed = CLAIMS.expression("eq-21-normal", NAMES | {"E_nr": released})
    assert sp.simplify(JUMP.separation_velocity**2 - printed**2) == 0
    point = {E_C: 2, NAMES["e_s"]: sp.Rational(3, 4), NAMES["m"]: 1, NAMES["theta"]: 1}
    assert JUMP.separation_velocity.subs(point) > 0


def test_formulas_4_to_6_of_the_compression_law():
    law = bilinear_hertz()
    E, nu, R, n, e = (p.symbol for p in law.parameters)
    letters = {"E": E, "nu": nu, "R_star": R, "n": n, "e_s": e, "K_e": K_E}
    letters |= {s.name: s for s in sp.symbols("delta delta_max", real=True)}
    letters["delta_p"] = CLAIMS.expression("eq-6", letters)
    letters["F_n_max"] = K_E * letters["delta_max"] ** n
    assert sp.simplify(law.definitions[K_E] - CLAIMS.expression("eq-4-stiffness", letters)) == 0
    loading, unloading = (without_ramps(b.force) for b in law.branches[:2])
    assert loading == CLAIMS.expression("eq-4", letters)
    values = {n: sp.Rational(3, 2), e: sp.Rational(3, 4), K_E: 7, letters["delta_max"]: 1}
    squared = next(s for s in law.definitions if s != K_E)
    for part in (sp.Rational(1, 2), sp.Rational(9, 10), 1):
        point = {**values, letters["delta"]: part, squared: values[e] ** 2}
        printed = CLAIMS.expression("eq-5", letters)
        assert sp.simplify(unloading.subs(point) - printed.subs(point)) == 0


# ---- verdicts ----

WRONG = {
    "eq-2": ("cos(theta) - mu", "cos(theta) + mu"),
    "eq-3": ("- g", "+ g"),
    "eq-5": ("**n", "**2"),
    "eq-6": ("1 - e_s**2", "1 - e_s"),
    "eq-14-impulse": ("-m", "m"),
    "eq-17": ("/(2*", "/(3*"),
    "eq-21-normal": ("-2*", "-3*"),
    "critical-friction": ("4/3", "5/3"),
}


@pytest.fixture(scope="module")
def derived():
    return derived_forms(Workbench())


def with_formula(name, **changes):
    formula = replace(CLAIMS.formulas[name], **changes)
    return replace(CLAIMS, formulas={**CLAIMS.formulas, name: formula})


@pytest.mark.parametrize("name", WRONG)
def test_formula_with_a_changed_sign_or_factor_is_not_reproduced(derived, name):
    text = CLAIMS.formulas[name].expression
    changed = with_formula(name, expression=text.replace(*WRONG[name]))
    assert changed != CLAIMS
    assert compare(CLAIMS, name, derived).verdict is Verdict.REPRODUCED
    assert compare(changed, name, derived).verdict is Verdict.DIFFERS


def test_misprint_needs_a_correction_that_holds(derived):
    assert compare(CLAIMS, "eq-18-impulse", derived).verdict is Verdict.MISPRINT
    text = CLAIMS.formulas["eq-18-impulse"].corrected
    other = with_formula("eq-18-impulse", corrected="2*" + text)
    assert compare(other, "eq-18-impulse", derived).verdict is Verdict.DIFFERS


# ---- equality ----

x, y = sp.symbols("x y", positive=True)
t = sp.Symbol("t", real=True)


@pytest.mark.parametrize(
    ("left", "right", "equal"),
    [
        (sp.sin(2 * t), 2 * sp.sin(t) * sp.cos(t), True),
        (sp.tan(t), sp.sin(t) / sp.cos(t), True),
        (sp.cos(t) ** 2, 1 - sp.sin(t) ** 2, True),
        (4 / (1 + 3 * sp.sin(t) ** 2), 4 / (4 - 3 * sp.cos(t) ** 2), True),
        (sp.sqrt(4 / (4 - 3 * sp.cos(t) ** 2)), 2 / sp.sqrt(1 + 3 * sp.sin(t) ** 2), True),
        (sp.sqrt(x**2 * y / (1 + y)), x * sp.sqrt(y / (1 + y)), True),
        (sp.sqrt(x), -sp.sqrt(x), False),
        (sp.sqrt(x), sp.sqrt(x + 1), False),
        (sp.sin(t) ** 2, sp.cos(t) ** 2, False),
        (sp.cos(t), sp.sin(t), False),
        (sp.Float(1.0), sp.Integer(1) + sp.Float("1e-12"), False),
    ],
)
def test_identical_decides_equality(left, right, equal):
    assert identical(left, right) is equal
