"""The derivations assert what they claim, and what is committed is what they write."""

from __future__ import annotations

import importlib
import inspect
import math

import pytest
import sympy as sp

from derivations.__main__ import DERIVATIONS, write_index
from derivations._page import ROOT, Derivation, Quantity, Step
from painleve_sym.at.jump import evaluate_jump
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.papers.impact_resolution.claims import CLAIMS

x, t = sp.symbols("x t", real=True)


@pytest.fixture(scope="module")
def derived():
    return [derive() for derive in DERIVATIONS]


@pytest.mark.slow
def test_derivations_write_what_is_committed(derived, tmp_path):
    paths = [write_index(derived, tmp_path)]
    for derivation in derived:
        paths += derivation.write(tmp_path)
    for path in paths:
        committed = ROOT / path.relative_to(tmp_path)
        assert path.read_bytes() == committed.read_bytes(), (
            f"{committed.name} is not what its derivation writes. Fix: run make derivations."
        )


@pytest.mark.slow
def test_derivations_leave_no_stale_file(derived):
    names = {d.name for d in derived}
    assert {p.stem for p in (ROOT / "derivations" / "generated").glob("*.py")} == names
    assert {p.stem for p in (ROOT / "docs" / "derivations").glob("*.md")} == names | {"README"}
    scripts = {p.stem for p in (ROOT / "derivations").glob("[!_]*.py")}
    assert scripts == names


@pytest.mark.slow
def test_derivations_compare_every_formula_of_the_claims(derived):
    compared = {step.formula for d in derived for step in d.steps if step.formula}
    # (15) is (1) again.
    assert compared == set(CLAIMS.formulas) - {"eq-15"}


@pytest.mark.slow
def test_derivations_prove_exactly_the_known_misprints(derived):
    verdicts = [entry for d in derived for entry in d.verdicts]
    misprints = {number for number, verdict in verdicts if verdict != "equal"}
    assert misprints == {"(4), 1/R*", "(4), K_e", "(14), θ̇(t1)", "(18), P_n2"}
    (stiffness,) = (verdict for number, verdict in verdicts if number == "(4), K_e")
    assert stiffness.startswith("differs: right for the n = 3/2")


def test_generated_functions_are_documented_and_typed():
    names = sorted(p.stem for p in (ROOT / "derivations" / "generated").glob("[!_]*.py"))
    assert len(names) == len(DERIVATIONS)
    for name in names:
        module = importlib.import_module(f"derivations.generated.{name}")
        functions = [f for _, f in inspect.getmembers(module, inspect.isfunction)]
        assert functions
        for function in functions:
            assert function.__doc__.startswith("Return ")
            for argument in inspect.signature(function).parameters:
                assert f"{argument} : float" in function.__doc__


def test_generated_functions_give_the_jump_of_the_package():
    f = importlib.import_module("derivations.generated.three_phase_jump")
    theta, mu, m, l, e = 1.0, 1.4, 1.3, 0.9, 0.75
    state = {"theta": theta, "theta_dot": 1.0, "x_A_dot": -1.0, "y_A_dot": -0.05}
    parameters = {"mu": mu, "m": m, "l": l, "e_energetic": e}
    result = evaluate_jump(rod(), "energetic", state, parameters=parameters)
    p_1 = f.P_n1(theta=theta, m=m, mu=mu, x_A_dot_0=-1.0)
    y_1 = f.y_A_dot_1(theta=theta, mu=mu, x_A_dot_0=-1.0, y_A_dot_0=-0.05)
    spin_1 = f.theta_dot_1(theta=theta, m=m, l=l, mu=mu, theta_dot_0=1.0, P_n1=p_1)
    e_1 = f.E_n1(theta=theta, m=m, mu=mu, y_A_dot_0=-0.05, y_A_dot_1=y_1)
    spin_2 = f.theta_dot_2(theta=theta, l=l, y_A_dot_1=y_1, theta_dot_1=spin_1)
    e_2 = f.E_n2(theta=theta, m=m, y_A_dot_1=y_1)
    released = f.E_nr(E_n1=e_1, E_n2=e_2, e_energetic=e)
    y_3 = f.y_A_dot_3(theta=theta, m=m, E_nr=released)
    spin_3 = f.theta_dot_3(theta=theta, l=l, y_A_dot_3=y_3, theta_dot_2=spin_2)
    generated = [p_1, e_1, e_2, y_3, spin_3]
    first, second, _ = result.phases
    expected = [first.normal_impulse, first.stored_energy, second.stored_energy]
    expected += [result.velocity["y_A_dot"], result.velocity["theta_dot"]]
    for left, right in zip(generated, expected, strict=True):
        # A is the difference of numbers a hundred times larger; it divides E_n1.
        assert math.isclose(left, right, rel_tol=1e-12)


@pytest.mark.parametrize(
    ("step", "text"),
    [
        (Step("", sp.Eq(x, t), "eq-1", printed=2 * t), "paper"),
        (Step("", sp.Eq(x, t), "eq-18-impulse", printed=t), "paper"),
        (Step("", sp.Eq(x, t), package=3 * t), "package"),
    ],
)
def test_step_check_fails_where_the_claim_is_wrong(step, text):
    with pytest.raises(AssertionError, match=text):
        step.check()


def test_derivation_check_wants_every_symbol_explained_and_functions_named_once():
    explained = (Quantity(x, "x", "m", "place"), Quantity(t, "t", "s", "time"))
    with pytest.raises(AssertionError, match="without meaning"):
        Derivation("d", "D", "", explained[:1], (Step("", sp.Eq(x, t)),)).check()
    twice = (Step("", sp.Eq(x, t)), Step("", sp.Eq(x, 2 * t)))
    with pytest.raises(AssertionError, match="repeated function"):
        Derivation("d", "D", "", explained, twice).check()
