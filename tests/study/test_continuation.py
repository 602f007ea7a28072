"""Continuation, derivatives and growth: orders in the stiffness, and two other ways to the same."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.critical.bisection import Border, CriticalForceFinder
from painleve_sym.study.critical.continuation import VariedCase, critical_curve
from painleve_sym.study.critical.gradient import critical_force_gradient
from tests.study.study_scripts import study_script
from tests.support.paper_law import paper_law

TABLE_4 = {"x_A_dot": -1.0, "theta": 1.0, "theta_dot": 5.0}
N = 1.764
ROOT = Path(__file__).resolve().parents[2]
compare_growth = study_script("critical_force/study.py").compare_growth
PAGE = (ROOT / "docs" / "critical-force.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def finder():
    return CriticalForceFinder(Simulator(model("rod"), paper_law(reload="virgin")))


@pytest.fixture(scope="module")
def curve(finder):
    return critical_curve(finder, TABLE_4, "E", np.geomspace(20.9e16, 20.9e22, 7))


@pytest.mark.parametrize("terms", [1, 2])
def test_remainders_fall_with_their_orders(curve, terms):
    # The next term of the series is smaller by 1/λ, which is 1.4e-2 at first and 3e-4 at last.
    off = np.abs(curve.orders(terms) + terms / (2 * N))
    assert np.all(np.diff(off) < 0)
    assert off[0] < 5e-3 and off[-1] < 2e-4


def test_remainder_of_all_terms_falls_with_the_third_order(curve):
    # The last remainders are 1e-8 N, a hundred times what rtol = 1e-13 leaves of 333 N.
    assert curve.orders(3) == pytest.approx(-3 / (2 * N), abs=5e-3)


def test_continuation_meets_the_forces_found_alone(finder, curve):
    for index in (2, 6):
        alone = finder.find(TABLE_4, {"E": curve.values[index]}, check_tolerance=False)
        assert curve.forces[index] == pytest.approx(alone.value, rel=1e-13)
    # Two bisections alone need some 80; a predicted bracket saves its widening.
    assert max(p.runs for p in curve.points[2:]) <= min(p.runs for p in curve.points[:1]) + 5


def test_continuation_in_the_approach_ends_where_every_force_impacts(finder):
    values = -np.linspace(0.0, 3e-3, 13)
    curve = critical_curve(
        finder,
        TABLE_4,
        "y_A_dot",
        values,
        parameters={"E": 20.9e14},
    )
    assert 0 < len(curve.points) < len(values)
    assert curve.stopped.startswith("at y_A_dot = -0.00225") and "too fast" in curve.stopped
    assert np.all(np.diff(curve.forces) < 0)
    barrier = curve.points[0].sliding.barrier_speed
    # The last speed with a critical force and the first without enclose the barrier's, to 1/λ.
    assert -values[len(curve.points)] > barrier
    assert curve.predicted == pytest.approx(curve.forces, rel=0.3, abs=1.0)


def test_continuation_refuses_what_it_cannot_start(finder):
    with pytest.raises(InputError, match="unknown quantity 'theta_ddot'"):
        critical_curve(finder, TABLE_4, "theta_ddot", [1.0])
    for repeated in ([2e19, 2e19, 2e19], [1e19, 2e19, 1e19]):
        with pytest.raises(InputError, match=r"values of E: got .*, need numbers that increase"):
            critical_curve(finder, TABLE_4, "E", repeated, parameters={"e_energetic": 1e-3})
    with pytest.raises(InputError, match="indeterminate"):
        critical_curve(finder, TABLE_4, "theta", [0.5, 1.0])


def test_setting_finds_values_of_parameters_and_states(finder):
    setting = VariedCase(finder, TABLE_4, {"mu": 1.5})
    assert [setting.value(n) for n in ("mu", "E", "theta", "y_A_dot")] == [1.5, 20.9e10, 1.0, 0.0]


# ---- derivatives ----


def test_gradient_is_the_slope_of_the_border_function(finder):
    # The border is where the slip velocity at separation becomes 0. With v(F, p) on the side that
    # lifts off, the implicit function theorem gives dF/dp = −(∂v/∂p)/(∂v/∂F).
    E = 20.9e13
    at = {"E": E}
    critical = finder.find(TABLE_4, at).value
    gradient = critical_force_gradient(finder, TABLE_4, ["theta_dot", "m", "E"], parameters=at)

    def slip(force, **changed):
        state = {k: changed.get(k, v) for k, v in TABLE_4.items()}
        given = {k: changed.get(k, v) for k, v in {"E": E, "m": 1.0}.items()}
        run = finder.simulator.run(
            state,
            parameters=given,
            initial_force=force,
            t_end=1.0,
            until="separation",
            rtol=1e-13,
            record="events",
        )
        return run.events[-1].state["x_A_dot"]

    def slope(function, at, h):
        near = function(at + h) - function(at - h)
        far = function(at + 2 * h) - function(at - 2 * h)
        return (8 * near - far) / (12 * h)

    # Just below the border, so that every run beside it lifts off too.
    for name, value in (("theta_dot", 5.0), ("m", 1.0), ("E", E)):
        estimates = []
        for part in (4e-4, 2e-4):
            base = critical * (1 - 10 * part)
            by_force = slope(lambda f: slip(f), base, part * critical)
            by_name = slope(lambda p, n=name, b=base: slip(b, **{n: p}), value, part * value)
            estimates.append(-by_name / by_force)
        # Both bases lie off the border by a part of it; the limit is extrapolated.
        limit = 2 * estimates[1] - estimates[0]
        assert gradient[name].value == pytest.approx(limit, rel=2e-3)
        assert gradient[name].error < 1e-6 * abs(gradient[name].value)


def test_gradient_obeys_the_scaling_by_mass(finder):
    # m → c m with K → c K multiplies every force by c: F = m ∂F/∂m + E ∂F/∂E, as K ∝ E.
    at = {"E": 20.9e14}
    gradient = critical_force_gradient(finder, TABLE_4, ["m", "E"], parameters=at)
    value = finder.find(TABLE_4, at).value
    assert gradient["m"].value + at["E"] * gradient["E"].value == pytest.approx(value, rel=1e-9)
    assert gradient["m"].method == "differences"


# ---- growth ----


def test_growth_of_a_deviation_tends_to_the_closed_form(finder):
    errors = []
    for E in (20.9e16, 20.9e18, 20.9e20):
        growth = compare_growth(finder, TABLE_4, {"E": E})
        assert np.all(np.diff(growth.deviation) > 0)
        errors.append(growth.error)
    orders = np.diff(np.log(np.abs(errors))) / math.log(100)
    # The remainder, 1/λ, falls like E^(−1/(2n)); 1/λ² disturbs the order by some hundredths.
    assert orders == pytest.approx(-1 / (2 * N), abs=0.02)
    assert abs(errors[-1]) < 1e-3


@pytest.mark.parametrize("damping", [0.0, 3e4])
def test_growth_with_a_dashpot_is_the_larger_root(damping):
    finder = CriticalForceFinder(Simulator(model("rod"), law("linear")))
    growth = compare_growth(finder, TABLE_4, {"k": 1e12, "c": damping})
    assert growth.measured == pytest.approx(growth.predicted, rel=5e-3)


def test_growth_needs_a_contact_that_slides_long_enough(finder):
    with pytest.raises(ValueError, match="give a stiffer one"):
        compare_growth(finder, TABLE_4, {"E": 20.9e12})


def test_both_borders_have_the_same_limit(finder):
    one, two = (
        critical_curve(finder, TABLE_4, "E", [20.9e16, 20.9e18], border=b).forces for b in Border
    )
    assert one == pytest.approx(two, rel=1e-12)


# ---- the page and the study ----


def test_page_example_prints_what_it_says(capsys):
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
    exec(compile(code, "docs/critical-force.md", "exec"), {})
    assert capsys.readouterr().out.startswith("346.878472 lifts_off")


def test_page_prints_the_forces_that_are_computed(finder):
    values = [finder.find(TABLE_4, {"E": 20.9e14}, border=b).value for b in Border]
    values += [finder.find(TABLE_4, {"E": 20.9 * 10.0**k}).value for k in (16, 18, 20, 22)]
    for value in values:
        assert f"{value:.9f}" in PAGE
    assert f"{finder.analysis.at(TABLE_4).force:.9f}" in PAGE
