"""The formulas of the claims against the package, and the test of equality."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

from painleve_sym.papers.formula import identical
from painleve_sym.papers.impact_resolution.claims import CLAIMS
from painleve_sym.papers.impact_resolution.formulas import (
    DERIVE,
    abbreviations,
    compare,
    derived_forms,
)
from painleve_sym.papers.impact_resolution.runs import Workbench
from painleve_sym.papers.item import Verdict

# Exact points on the unit circle, and rational numbers for all other symbols.
POINTS = [(sp.Rational(a, 65), sp.Rational(b, 65)) for a, b in ((16, 63), (33, 56), (52, 39))]


@pytest.fixture(scope="module")
def derived():
    return derived_forms(Workbench())


def differences(derived, name, corrected):
    """Return derived − printed at the points, to thirty digits."""
    printed = derived.printed(name, corrected).subs(abbreviations(derived))
    theta, left = derived["theta"], DERIVE[name](derived) - printed
    rest = sorted(left.free_symbols - {theta}, key=str)
    values = {s: sp.Rational(k + 3, k + 7) for k, s in enumerate(rest)}
    at = [left.subs({sp.sin(theta): s, sp.cos(theta): c}).subs(values) for s, c in POINTS]
    return [abs(sp.N(difference, 30, chop=False)) for difference in at]


# Numbers decide here what `identical` decides by algebra.
@pytest.mark.parametrize("name", DERIVE)
def test_formula_agrees_with_the_package_at_exact_points(derived, name):
    assert max(differences(derived, name, corrected=True)) < 1e-25


@pytest.mark.parametrize("name", ["eq-4-radius", "eq-4-stiffness", "eq-18-impulse"])
def test_formula_misprinted_in_the_paper_differs_at_every_point(derived, name):
    assert min(differences(derived, name, corrected=False)) > 1e-3


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


def test_stiffness_is_right_for_the_exponent_it_is_printed_for(derived):
    """K_e of Hertz's n = 3/2 is used with n = 1.764: the print is not at fault."""
    assert compare(CLAIMS, "eq-4-stiffness", derived).verdict is Verdict.DIFFERS
    hertz = DERIVE["eq-4-stiffness"](derived).subs(derived["n"], sp.Rational(3, 2))
    assert sp.simplify(hertz - derived.printed("eq-4-stiffness")) == 0


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
