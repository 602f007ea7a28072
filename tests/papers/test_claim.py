"""Printed digits, verdicts on formulas, and what items share."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from painleve_sym.contacts.classify import classify
from painleve_sym.papers.claim import Printed, Verdict, features
from painleve_sym.papers.impact_resolution.cases import IMPACT, SLIDING, first, needed
from painleve_sym.papers.impact_resolution.claims import FORMULAS, SOFT, TABLES, PrintedFormula
from painleve_sym.papers.impact_resolution.formulas import (
    Derived,
    compare,
    derived_forms,
    identical,
)
from painleve_sym.papers.panels import events_as_marks, window
from painleve_sym.papers.run_cache import Workbench


@pytest.fixture(scope="module")
def bench():
    return Workbench({n: t.state for n, t in TABLES.items()})


@given(st.floats(-1e6, 1e6), st.integers(0, 6))
def test_printed_number_matches_what_rounds_to_it(value, digits):
    text = f"{value:.{digits}f}"
    assert Printed(text).matches(value)
    assert not Printed(text).matches(float(text) + 1.01 * 10.0**-digits)


@pytest.mark.parametrize(
    ("text", "tolerance"), [("1.5434", 5e-5), ("150", 0.5), ("-1.7628e-7", 5e-12), ("4e-4", 5e-5)]
)
def test_printed_tolerance_is_half_the_last_digit(text, tolerance):
    assert Printed(text).tolerance == pytest.approx(tolerance)


def test_printed_tolerance_can_be_given():
    assert Printed("0.75e-3", 1e-4).matches(0.00084)
    assert not Printed("0.75e-3", 1e-4).matches(0.00086)


def test_features_differ_when_one_check_fails():
    assert features("p", "c", {"a": True}).verdict is Verdict.REPRODUCED
    outcome = features("p", "c", {"a": True, "b": np.bool_(False)})
    assert outcome.verdict is Verdict.DIFFERS
    assert outcome.data["checks"] == {"a": True, "b": False}


def test_identical_tells_trigonometric_identities_and_roots():
    x, y = sp.symbols("x y", positive=True)
    assert identical(sp.sin(2 * x), 2 * sp.sin(x) * sp.cos(x))
    assert identical(4 / (1 + 3 * sp.sin(x) ** 2), 4 / (4 - 3 * sp.cos(x) ** 2))
    assert identical(sp.sqrt(x**2 * y / (1 + y)), x * sp.sqrt(y / (1 + y)))
    assert not identical(sp.sqrt(x), -sp.sqrt(x))
    assert not identical(sp.sin(x) ** 2, sp.cos(x) ** 2)


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


@pytest.mark.parametrize("name", WRONG)
def test_formula_with_a_changed_sign_or_factor_is_not_reproduced(bench, name):
    d, claim = derived_forms(bench), FORMULAS[name]
    changed = PrintedFormula(claim.text, claim.expression.replace(*WRONG[name]))
    derive = {
        "eq-2": Derived.a,
        "eq-3": Derived.b,
        "eq-5": Derived.unloading,
        "eq-6": Derived.permanent,
        "eq-14-impulse": lambda d: d.named(d.jump.tangential.normal_impulse, 0),
        "eq-17": lambda d: d.first_energy(sp.Integer(0)),
        "eq-21-normal": Derived.rebound,
        "critical-friction": Derived.least_critical_friction,
    }[name](d)
    assert changed.expression != claim.expression
    assert compare(claim, derive, d).verdict is Verdict.REPRODUCED
    assert compare(changed, derive, d).verdict is Verdict.DIFFERS


def test_misprint_needs_a_correction_that_holds(bench):
    d, claim = derived_forms(bench), FORMULAS["eq-18-impulse"]
    derived = d.named(d.jump.compression.normal_impulse, 1)
    assert compare(claim, derived, d).verdict is Verdict.MISPRINT
    other = PrintedFormula(claim.text, claim.expression, "2*" + claim.corrected)
    assert compare(other, derived, d).verdict is Verdict.DIFFERS


def test_runs_are_made_once(bench):
    assert bench.run(IMPACT) is bench.run(IMPACT)


def test_sliding_force_is_that_of_the_rigid_problem(bench):
    found = classify(bench.rod, bench.state(1))
    force = bench.sliding_force(np.array([0.5]), np.array([1.0]))[0]
    assert force == pytest.approx(-found.B / found.A, rel=1e-13)


def test_window_draws_a_jump_of_the_force_as_one(bench):
    run = bench.run(SLIDING[SOFT])
    times = window(run, 0.0, 0.01)
    assert times[0] == 0
    assert times[-1] == 0.01
    assert np.all(np.diff(times) > 0)
    reload = needed(run, "reload").time
    at = int(np.searchsorted(times, reload))
    assert times[at] == reload
    forces = run.values("normal_force", times[at - 1 : at + 1])
    # From the unloading curve, nearly zero, to the virgin one.
    assert forces[0] < 0.01
    assert forces[1] > 3.5


def test_marks_lie_on_the_curve_before_the_event(bench):
    run = bench.run(SLIDING[SOFT])
    marks = events_as_marks(run, "normal_force", 0.004, ("reload", "max_compression"))
    assert [m.kind for m in marks] == ["max_compression", "reload"]
    assert marks[0].y == pytest.approx(needed(run, "max_compression").normal_force, rel=1e-9)
    assert marks[1].y == pytest.approx(needed(run, "reload").normal_force, rel=1e-6)


def test_needed_event_that_is_missing_is_an_error(bench):
    run = bench.run(SLIDING[SOFT])
    assert first(run, "slip_stop") is None
    with pytest.raises(LookupError, match="slip_stop"):
        needed(run, "slip_stop")
