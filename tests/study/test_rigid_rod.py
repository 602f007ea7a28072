"""Is a rod rigid? Limits of the characteristic function, an oracle without modes, the page."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator
from tests.study.study_scripts import study_script

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples" / "studies" / "rigid_rod"
PAGE = (ROOT / "docs" / "rigid-rod.md").read_text("utf-8")
DATA = json.loads((FOLDER / "rigid-rod.json").read_text("utf-8"))

study = study_script("rigid_rod/rigid_rod.py")

STEEL = study.Bar()


def mobilities(counts, theta):
    """Return W_nn and W_nt of `rod-bending` without deflection."""
    mechanism = model(f"rod-bending:{counts[0]},{counts[1]}")
    values = dict.fromkeys((s.name for s in mechanism.system.symbols), 0.0)
    values |= {p.name: p.default for p in mechanism.system.parameters} | {"theta": theta}
    coefficients = mechanism.coefficients
    return numbers([coefficients.W_nn, coefficients.W_nt], values)


@pytest.mark.parametrize("counts", [(0, 0), (1, 0), (2, 1)])
@pytest.mark.parametrize("theta", [0.7, 1.0, 1.4])
def test_receptances_at_high_rates_are_the_mobilities_of_the_package(counts, theta):
    p = 1e12
    across, along = (float(g) * p**2 for g in study.modal(STEEL, *counts)(p))
    sin, cos = math.sin(theta), math.cos(theta)
    expected = cos**2 * across + sin**2 * along, sin * cos * (along - across)
    assert mobilities(counts, theta) == pytest.approx(expected, rel=1e-12)


def test_rigid_threshold_is_that_of_the_rod_and_least_at_four_thirds():
    assert study.threshold(study.rigid(STEEL), 1.0)[0] == pytest.approx(1.3752594, abs=1e-7)
    least, _ = study.threshold(study.rigid(STEEL), math.atan(2))
    assert least == pytest.approx(4 / 3, rel=1e-12)


def test_modal_sums_tend_to_the_closed_forms_as_modes_are_added():
    p = np.array([1000.0])
    exact = study.euler_bernoulli(STEEL)(p)
    errors = [
        [float(abs(g / e - 1)[0]) for g, e in zip(study.modal(STEEL, n, n)(p), exact, strict=True)]
        for n in (5, 10, 20)
    ]
    # Orders 3 in bending modes and 1 in axial ones.
    assert errors[1][0] / errors[2][0] == pytest.approx(8, rel=0.2)
    assert errors[1][1] / errors[2][1] == pytest.approx(2, rel=0.1)
    assert errors[2][0] < 0.01 and errors[2][1] < 0.002


def test_closed_forms_join_rigid_motion_and_half_infinite_bar():
    slow, fast = np.array([0.1]), np.array([1e5])
    for form, limit, p in (
        (study.euler_bernoulli, study.rigid, slow),
        (study.euler_bernoulli, study.half_infinite, fast),
        (study.timoshenko, study.euler_bernoulli, np.array([100.0])),
    ):
        for value, expected in zip(form(STEEL)(p), limit(STEEL)(p), strict=True):
            assert value == pytest.approx(expected, rel=2e-5)


def test_far_end_has_no_part_in_bending():
    _, k = study.contact(study.WEIGHT)
    finite, endless = study.euler_bernoulli(STEEL), study.half_infinite(STEEL)
    expected, _ = study.threshold(finite, 1.0, k)
    mixed, _ = study.threshold(lambda p: (endless(p)[0], finite(p)[1]), 1.0, k)
    mass, _ = study.threshold(lambda p: (endless(p)[0], 1 / (STEEL.mass * p**2)), 1.0, k)
    assert mixed == pytest.approx(expected, rel=1e-9)
    assert f"{mass:.4f} instead of {expected:.4f}" in PAGE


def test_timoshenko_ends_in_a_wave_of_shear():
    p = np.array([1e10])
    across, along = study.timoshenko(STEEL)(p)
    nu = STEEL.poisson
    shear = 6 * (1 + nu) / (7 + 6 * nu)
    assert across / along == pytest.approx(math.sqrt(2 * (1 + nu) / shear), rel=1e-4)


@settings(max_examples=25)
@given(st.floats(12, 300), st.floats(0.6, 1.4), st.floats(1.1, 50))
def test_threshold_is_the_rigid_one_up_to_the_stiffness_of_the_closed_form(slender, theta, factor):
    bar = study.round_bar(slender)
    edge, form = study.rigid_up_to(bar), study.euler_bernoulli(bar)
    rigid, _ = study.threshold(study.rigid(bar), theta)
    assert study.threshold(form, theta, 0.99 * edge)[0] == pytest.approx(rigid, rel=1e-5)
    assert study.threshold(form, theta, factor * edge)[0] < rigid * (1 - 1e-3)


@settings(max_examples=40)
@given(st.floats(0.5, 1.5), st.floats(0.05, 0.999), st.floats(3, 9), st.sampled_from([0.0, 0.05]))
def test_nothing_grows_while_the_force_stays_below_the_axis_of_the_rod(theta, part, k, damping):
    """Below μ = cot θ the matrix of stiffness is similar to a symmetric positive one."""
    p = study.growth(STEEL, (6, 3), theta, part / math.tan(theta), 10**k, damping)
    # Free turning and gliding are double roots at zero: their round-off is its square root.
    assert p.real < 0.05


def test_divergence_is_a_real_root_of_the_same_modes():
    _, k = study.contact(study.WEIGHT)
    mu, rate = study.threshold(study.modal(STEEL, 8, 2), 1.0, k)
    above = study.growth(STEEL, (8, 2), 1.0, mu * 1.001, k)
    below = study.growth(STEEL, (8, 2), 1.0, mu * 0.999, k)
    assert abs(above.imag) < 1e-6 and above.real > rate
    assert abs(below.imag) > 1 and below.real > 1  # coupled modes


@pytest.mark.slow
def test_runs_part_at_the_rate_of_the_root():
    """Nonlinear motion on a linear contact; θ drifts by a hundredth meanwhile."""
    k, mu = 2.5e6, 1.1
    p = study.growth(STEEL, (2, 1), 1.0, mu, k)
    assert p.imag == 0 and f"p = {p.real:.1f} 1/s" in PAGE
    simulator = Simulator(model("rod-bending:2,1"), law("linear"))
    runs = [
        simulator.run(
            {"theta": 1.0, "x_A_dot": -20.0}, t_end=0.01, initial_force=force,
            until=("slip_stop", "separation"), parameters={"mu": mu, "k": k},
        )
        for force in (60.0, 60.0 * (1 + 1e-7))
    ]  # fmt: skip
    t = np.linspace(0.5, 0.8, 7) * min(r.t[-1] for r in runs)
    gap = np.abs(np.subtract(*(r.values("normal_force", t) for r in runs)))
    rate = np.polyfit(t, np.log(gap), 1)[0]
    assert rate == pytest.approx(p.real, rel=0.01)


def test_mobilities_ratio_peaks_at_the_number_of_the_page():
    for slender in (50, 222, 1000):
        peak = study.peak_ratio(study.round_bar(slender))
        assert peak["ratio"] == pytest.approx(2.1596 * math.sqrt(slender), rel=1e-3)


@pytest.mark.slow
def test_chain_of_particles_stops_when_the_rod_of_modes_does():
    """Positions of particles, no modes and no frame; the rest is the chain's error of order 2."""
    coarse, fine = (study.chain(1.2, n, 0.002, bar=study.bench("steel")) for n in (8, 16))
    exact = fine["slip_stop"] + (fine["slip_stop"] - coarse["slip_stop"]) / 3
    run = study.simulator("2,0").run(
        study.SLIDING, t_end=0.003, until="slip_stop",
        parameters={"mu": 1.2, **study.parameters_of(study.bench("steel"))},
    )  # fmt: skip
    (stop,) = run.events_of("slip_stop")
    # Two bending modes of all: a third late, as the page's table says.
    assert exact == pytest.approx(0.4805e-3, rel=0.03)
    assert 1.25 < stop.time / exact < 1.4


def test_orders_and_agreement_of_the_oracle_are_those_of_the_page():
    landing = study_script("rigid_rod/landing.py")
    bar, words = study.bench("steel"), " ".join(PAGE.split())
    law = landing.Contact(landing.hertz(bar).K, 1.5, 0.75)
    chains, modes = DATA["oracle"]["chain"], DATA["oracle"]["modes"]
    for speed, off in ((1.0, 0.003), (0.05, 0.001)):
        t = [r["slip_stop"] for r in chains if r["speed"] == speed][-3:]
        order = math.log2((t[0] - t[1]) / (t[1] - t[2]))
        limit = t[2] + (t[2] - t[1]) / 3
        assert 1.8 < order < 2.1
        assert f"order {order:.2f} to {1e3 * limit:.4f} ms at {speed:g} m/s" in words
        (held,) = landing.slide(landing.Modes(bar, 24, 12), law, 1.0, 1.2, speed)["stop"]
        assert abs(held / limit - 1) < off and f"{1e3 * held:.4f} ms" in words
        late = {
            r["model"]: 100 * (r["slip_stop"] / limit - 1) for r in modes if r["speed"] == speed
        }
        assert f"{late['8,2']:.1f} %" in words and f"{-late['16,2']:.1f} %" in words
        assert late["2,0"] > late["4,1"] > late["8,2"] > 0 > late["16,2"] > -2


def test_slenderness_up_to_which_a_bar_is_rigid_is_that_of_the_page():
    def excess(slender):
        bar = study.round_bar(slender)
        return study.contact(study.WEIGHT, radius=bar.radius)[1] / study.rigid_up_to(bar) - 1

    edge = brentq(excess, 10, 100)
    assert f"in this sense up to {edge:.0f} diameters" in " ".join(PAGE.split())
    rows = {r["slenderness"]: r for r in DATA["thresholds"]["slenderness"]}
    coupled = [rows[n]["coupling"] for n in (10, 20)]
    assert f"the {coupled[0]:.3f} of the table is where growth by *damping*" in PAGE
    assert coupled[1] == pytest.approx(1 / math.tan(1.0), rel=5e-3)


def test_coupling_needs_no_wave_along_the_bar():
    _, k = study.contact(study.WEIGHT)
    both = [study.flutter_threshold(STEEL, (24, n), 1.0, k, 0.01) for n in (0, 12)]
    assert both[0] == pytest.approx(both[1], rel=3e-3)
    assert f"√(k/m) = {math.sqrt(k / STEEL.mass):.0f} 1/s" in PAGE


def test_page_prints_the_tables_of_the_study():
    tables = [*study.threshold_tables(DATA["thresholds"]), *study.run_tables(DATA["runs"])]
    for text in (*tables, study.oracle_table(DATA["oracle"])):
        assert text in PAGE, text


@pytest.mark.slow
def test_numbers_of_the_study_are_computed_again():
    _, k = study.contact(study.WEIGHT)
    (row,) = [r for r in DATA["thresholds"]["angle"] if r["theta"] == 1.0]
    for name, form in study.models(STEEL).items():
        assert study.threshold(form, 1.0, k)[0] == pytest.approx(row[name], rel=1e-7)
    for name in ("rod", "1,0"):
        (kept,) = [r for r in DATA["runs"]["friction"] if (r["model"], r["mu"]) == (name, 1.4)]
        new = study.motion(name, 1.4)
        for key in ("slip_stop", "peak_force", "rebound", "vibration"):
            assert new[key] == pytest.approx(kept[key], rel=1e-6, abs=1e-12)
        assert new["energy_residual"] < 1e-9


def test_energy_balance_of_every_run_closes():
    runs = DATA["runs"]
    for row in (*runs["friction"], *runs["approach"], *runs["damping"]):
        assert row["energy_residual"] < 1e-10
