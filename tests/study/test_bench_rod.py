"""Predictions of the bench experiments: hand limits, momentum, the page."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.mechanics.bars import bending_modes
from tests.study.study_scripts import study_script

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples" / "studies" / "bench_rod"
PAGE = (ROOT / "docs" / "experiments.md").read_text("utf-8")
DATA = json.loads((FOLDER / "bench-rod.json").read_text("utf-8"))

study = study_script("bench_rod/bench_rod.py")

MIDDLE = study.FRICTION["0.6 ± 10 %"]


def row(rows, **values):
    """Return the only row with these values."""
    (one,) = [r for r in rows if all(r[k] == v for k, v in values.items())]
    return one


# ---- hand limits and balances ----


@pytest.mark.parametrize("theta", [0.4, 0.9, 1.5])
def test_rigid_bar_has_the_restitution_of_its_contact_at_every_angle(theta):
    low, middle, high = study.drop("rigid", 0.2, theta, 40)["restitution"]
    assert study.BAR["restitution"][0] - 0.01 < low < high < study.BAR["restitution"][1] + 0.01
    assert middle == pytest.approx(0.6, abs=0.03)


@pytest.mark.slow
def test_bar_of_a_stiff_material_tends_to_the_rigid_one():
    """The modulus of the bar alone grows; its modes follow statically, with an error of 1/Y."""
    steel = ps.material("steel")
    mass = steel.density * math.pi / 4 * 0.01**2 * 0.2
    common = {"m": mass, "l": 0.1, "E": steel.young_modulus, "R": 0.005, "mu": 0.3}
    ends = []
    cases = [("rigid", {}), *(("1,1", {"rho": steel.density, "Y": 2e11 * x}) for x in (1e3, 1e4))]
    for name, own in cases:
        run = ps.simulate(
            study.mechanism(name), study.law(), {"theta": 0.8, "y_A_dot": -1.0}, t_end=2e-4,
            parameters=common | own, until="separation",
        )  # fmt: skip
        ends.append(run.final["y_A_dot"])
    errors = [abs(end / ends[0] - 1) for end in ends[1:]]
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.1) and errors[1] < 1e-3


@pytest.mark.slow
def test_stiff_tangential_spring_is_the_rigid_rod():
    draws = study.Draws("aluminium", 1)
    ends = []
    for name, own in (("rigid", {}), ("tangential", {"k_t": 1e11, "m_tip": 1e-8})):
        parameters = draws.parameters(name, 1.0, 0.006, 0.0) | own | {"mu": 0.6}
        run = ps.simulate(
            study.mechanism(name), study.law(), {"theta": 1.2, "x_A_dot": -1.0, "y_A_dot": -0.1},
            parameters={k: float(np.squeeze(v)) for k, v in parameters.items()},
            t_end=1e-3, until="separation",
        )  # fmt: skip
        ends.append((run.final_time, run.final["y_A_dot"], run.final["theta_dot"]))
    assert ends[1] == pytest.approx(ends[0], rel=1e-5)


@pytest.mark.slow
def test_momentum_of_the_mass_centre_is_the_impulse_of_the_contact():
    """Modes of free ends carry no momentum, so that the frame's centre has all of it."""
    mass, half, theta, t_end = 0.1, 0.1, 0.6, 1e-3
    run = ps.simulate_batch(
        study.mechanism("2,1"), study.law(), {"theta": np.array([theta]), "y_A_dot": -1.0},
        parameters={"m": mass, "l": half, "mu": 0.3}, t_end=t_end, integrals=("normal_force",),
    )  # fmt: skip
    centre = run["y_A_dot"] + half * np.cos(run["theta"]) * run["theta_dot"]
    impulse = run["integral_normal_force"] - mass * study.G * t_end
    assert mass * (centre + 1.0) == pytest.approx(impulse, rel=1e-8)


def test_stiff_arm_rebounds_as_the_jump_of_rigid_contact():
    state = {"theta_1": -0.643501, "theta_2": -0.927295}
    arm = ps.model("two-link-arm")
    jump = ps.evaluate_jump(arm, "energetic", state, parameters={"mu": 0.8, "u": -1.0})
    rates = jump.velocity["theta_1_dot"], jump.velocity["theta_2_dot"]
    expected = sum(
        0.5 * math.cos(state[q]) * v for q, v in zip(("theta_1", "theta_2"), rates, strict=True)
    )
    run = ps.simulate(
        arm, study.law(), state, parameters={"mu": 0.8, "u": -1.0, "E": 2e17}, t_end=0.01,
        until="separation", close="theta_1",
    )  # fmt: skip
    assert run.final["gap_dot"] == pytest.approx(expected, rel=2e-3)


def test_draws_are_the_same_for_every_model():
    first, second = (study.Draws("aluminium", 5) for _ in range(2))
    assert np.array_equal(first.modulus, second.modulus)
    assert np.array_equal(first(0.0, 1.0), second(0.0, 1.0))


def limit(values):
    """Return the limit of a chain whose number of links is doubled, and its order."""
    order = math.log2((values[0] - values[1]) / (values[1] - values[2]))
    return values[2] + (values[2] - values[1]) / 3, order


def test_first_contact_is_that_of_a_chain_of_particles():
    rows = DATA["oracle"]
    chains = [r for r in rows if r["model"].startswith("chain")]
    modes = [r for r in rows if r["model"].startswith("bending")]
    for key, worst in (("slip_stop", 0.20), ("contact", 0.025), ("v_y", 0.02), ("spin", 0.04)):
        exact, order = limit([r[key] for r in chains])
        assert 1.7 < order < 2.3, (key, order)
        assert modes[-1][key] == pytest.approx(exact, rel=worst), key
        errors = [abs(r[key] / exact - 1) for r in modes]
        assert key == "spin" or errors[0] > errors[1] > errors[2], key
    assert modes[-1]["peak_force"] == pytest.approx(chains[-1]["peak_force"], rel=0.01)
    speeds = [r["v_y"] for r in modes]
    exact, _ = limit([r["v_y"] for r in chains])
    assert f"{100 * (1 - speeds[2] / exact):.1f} % too slow, with 8,4 modes" in PAGE
    stop, _ = limit([r["slip_stop"] for r in chains])
    assert f"to {1e3 * stop:.3f} ms" in PAGE and f"takes {1e3 * stop:.2f} ms" in PAGE
    assert round(10 / stop, -3) == 88000 and "88 000 frames/s" in PAGE


def test_chain_of_the_study_is_computed_again():
    kept = row(DATA["oracle"], model="chain of 32 links")
    (new,) = study.oracle((32,), ())
    for key in ("slip_stop", "contact", "v_y", "spin"):
        assert new[key] == pytest.approx(kept[key], rel=1e-5)


# ---- the page ----


def test_page_prints_the_tables_of_the_study():
    for text in study.tables(DATA):
        assert text in PAGE, text


@pytest.mark.slow
def test_numbers_of_the_study_are_computed_again():
    kept = row(DATA["modes"], model="2,1")
    new = study.drag("2,1", MIDDLE)
    for key in ("stops", "slip_stop", "contact", "peak_force", "rise"):
        assert new[key] == pytest.approx(kept[key], rel=1e-3), key
    kept = row(DATA["bars"], model="rigid", length=0.1, theta=0.6)
    assert study.drop("rigid", 0.1, 0.6)["restitution"] == pytest.approx(
        kept["restitution"], rel=1e-6
    )
    kept = row(DATA["arm"], mu=0.8, belt=0.5)
    assert study.arm(0.8, 0.5) == pytest.approx(kept, rel=1e-6)


def test_every_run_of_the_study_reached_its_end():
    sections = ("rod", "controls", "contacts", "modes", "curve", "bars", "bar modes")
    assert {r["completed"] for s in sections for r in DATA[s]} == {study.SAMPLE}
    assert min(r["far end"] for r in DATA["bars"]) > 0


def test_opening_and_statements_have_the_numbers_of_the_study():
    rise = {(r["friction"], r["model"]): r["rise"] for r in DATA["rod"]}
    decisive = "0.6 ± 10 %"
    rigid, bending = (1e3 * rise[decisive, m][1] for m in ("rigid", study.MODES))
    assert f"rises by {rigid:.2f} mm if the rod is rigid and by {bending:.0f} mm" in PAGE
    ratios = [rise[f, study.MODES][1] / rise[f, "rigid"][1] for f in (decisive, "0.9 ± 10 %")]
    assert "by a factor of {:.0f} at μ = 0.6 and {:.0f} at 0.9".format(*ratios) in PAGE
    assert 1e3 * rise[decisive, "rigid"][2] < 1 < 10 < 1e3 * rise[decisive, study.MODES][0]
    for friction in ("0.3 ± 10 %", decisive):
        rigid, sprung = (rise[friction, m][1] for m in ("rigid", "tangential"))
        assert sprung == pytest.approx(rigid, rel=0.01)
    stops = {(r["mu"], r["model"]): r["stops"] for r in DATA["curve"]}
    assert stops[0.4, study.MODES] == 0 and stops[0.5, study.MODES] == 1
    assert stops[0.9, "rigid"] == 0 and stops[1.0, "rigid"] > 0.5


def test_intervals_contain_what_the_modes_leave():
    """They reach to the limit of the chain of particles, at the middle values."""
    left = study.truncation(DATA["oracle"])
    assert 0.7 < left["slip_stop"] < 1 < left["rise"] < 1.1
    words = "multiplied by {slip_stop:.2f}, of contacts by {contact:.2f} "
    words += "and of peaks by {peak_force:.2f}"
    assert words.format(**left) in " ".join(PAGE.split())
    assert f"by {left['rise']:.2f}, by which" in PAGE
    kept = row(DATA["rod"], friction="0.6 ± 10 %", model=study.MODES)
    (line,) = study.rod_rows([kept], "friction", left)
    assert f"{1e3 * kept['rise'][2] * left['rise']:.2f})" in line[-1]


def test_dropped_bars_have_the_error_of_truncation_beside_them():
    """It is what halving the modes changes; 20,10 modes change far less."""
    rows = {(r["model"], r["length"], r["theta"]): r for r in (*DATA["bars"], *DATA["bar modes"])}
    for length in study.LENGTHS:
        for theta in study.TABLE_ANGLES:
            all_modes = rows[study.MODES, length, theta]["restitution"]
            half = rows[study.HALF, length, theta]["restitution"][1]
            error = study.truncation_of_bar(rows, length, theta)
            assert error == abs(all_modes[1] - half)
            assert f"{study.interval(all_modes)} ± {error:.3f}; " in PAGE
    medians = {key: r["restitution"][1] for key, r in rows.items()}
    changes = {
        (length, theta): abs(
            medians[study.MODES, length, theta] - medians[study.HALF, length, theta]
        )
        for length in study.LENGTHS
        for theta in study.ANGLES
    }
    words = " ".join(PAGE.split())
    most = max(v for (length, theta), v in changes.items() if length == 0.4 and theta < 1.15)
    assert f"move by up to {most:.2f} from 8,4 to 16,8 modes up to 1.1 rad" in words
    assert max(v for (n, theta), v in changes.items() if n == 0.4 and theta > 1.15) < 0.005
    assert max(v for (n, _), v in changes.items() if n < 0.4) < 0.01
    least, short = (
        min(medians[study.MODES, n, theta] for theta in study.ANGLES) for n in (0.4, 0.06)
    )
    assert f"from {least:.2f} at θ = 1.1 to {medians[study.MODES, 0.4, 1.5]:.2f} near" in words
    assert f"varies between {short:.2f} and {medians[study.MODES, 0.06, 0.2]:.2f}" in words
    contacts = max(r["contacts"][1] for key, r in rows.items() if key[0] == study.MODES)
    assert f"up to {contacts:.0f} times at 400 mm" in words
    for theta in study.TABLE_ANGLES:
        long = study.LENGTHS[-1]
        more, all_modes = (rows[m, long, theta]["restitution"][1] for m in ("20,10", study.MODES))
        assert abs(more - all_modes) < 0.0055


def test_contact_that_yields_keeps_the_verdict():
    rows = {r["model"]: r for r in DATA["contacts"]}
    assert {r["contact law"] for r in rows.values()} == {"plastic"}
    assert rows[study.MODES]["stops"] == 1 and rows["rigid"]["stops"] == 0
    assert 10 * rows["rigid"]["rise"][2] < rows[study.MODES]["rise"][0]
    forces = [study.first_yield(0.003, 70e9, 0.33, s) for s in (95e6, 276e6)]
    words = " ".join(PAGE.split())
    assert "which is {:.1f} N for the table's 95 MPa and {:.1f} N".format(*forces) in words


def test_tip_that_weighs_changes_the_landing_as_the_page_says():
    landing = study_script("rigid_rod/landing.py")
    kept = json.loads((ROOT / "examples/studies/rigid_rod/landing.json").read_text("utf-8"))
    assert landing.belt_table(kept) in PAGE
    at = row(kept["belt"], theta=1.2)
    words = " ".join(PAGE.split())
    light, heavy, round_end = (at[f"{n} 48,24"] for n in ("hard tip", "heavy tip", "round end"))
    assert f"raises the landing from {light:.3f} to {heavy:.3f}" in words
    assert f"lowers the landing to {round_end:.3f}" in words
    radius, density = landing.BALL
    mass = 4e3 / 3 * math.pi * radius**3 * density
    assert f"{1e3 * radius:.0f} mm radius and {mass:.2f} g" in words
    (again,) = landing.belt((1.2,))
    assert again == pytest.approx(at, rel=1e-9)
    assert "at most 0.3 g" in words and "tip of at most 0.3 g: a rise" in words


def test_round_end_stops_sooner_and_keeps_the_verdict():
    point, ball = DATA["round end"]
    assert (point["end"], ball["end"]) == ("radius 0", "round")
    sooner = 1 - ball["slip_stop"] / point["slip_stop"]
    change = abs(ball["rise"] / point["rise"] - 1)
    words = " ".join(PAGE.split())
    assert f"stops the slip {100 * sooner:.1f} % sooner" in words
    assert f"changes the rise by {100 * change:.1f} %" in words
    # The end of radius 0 is that of the kept runs with half the modes.
    kept = row(DATA["modes"], model=study.HALF)
    for key in ("slip_stop", "contact", "rise", "peak_force"):
        assert kept[key][0] < point[key] < kept[key][2], key
    all_modes = row(DATA["rod"], friction="0.6 ± 10 %", model=study.MODES)
    low, middle, high = all_modes["slip_stop"]
    assert low < middle * (1 - sooner) < high
    low, middle, high = all_modes["rise"]
    assert low < middle * ball["rise"] / point["rise"] < high


@pytest.mark.slow
def test_end_of_a_tiny_radius_is_that_of_radius_zero():
    def stop(rod):
        run = ps.simulate(
            rod, "hertz", {"theta": 1.0, "x_A_dot": -1.0}, t_end=0.01,
            parameters={"mu": 1.1}, until="slip_stop",
        )  # fmt: skip
        return run.final_time

    tiny, plain = study.with_round_end("1,0", 1e-12), study.mechanism("1,0")
    assert stop(tiny) == pytest.approx(stop(plain), rel=1e-9)


def test_plastic_contact_has_the_force_of_its_hardness():
    draws = study.Draws("aluminium", 3)
    given = draws.parameters("rigid", 1.0, 0.006, 0.0) | {"e_energetic": 0.5}
    values = study.with_plastic_contact(given, draws)
    law = ps.laws.bilinear_hertz(
        **{n: float(np.ravel(values[n])[0]) for n in ("E", "nu", "R", "n", "l_0", "e_energetic")}
    )
    K = float(law.stiffness.subs(dict(law.definitions)).subs(
        {p.symbol: p.default for p in law.parameters}))  # fmt: skip
    low, high = (2 * math.pi * 0.003 * 2.8 * s for s in study.PLASTIC["strength"])
    assert low <= K <= high


def test_arm_has_its_paradox_and_rod_its_first_mode_where_the_page_says():
    arm = ps.model("two-link-arm")
    values = {p.name: p.default for p in arm.system.parameters}
    values |= dict.fromkeys(arm.state_names, 0.0) | {"theta_1": -0.643501, "theta_2": -0.927295}
    normal, coupled = numbers([arm.coefficients.W_nn, arm.coefficients.W_nt], values)
    assert f"begins at μ = {normal / abs(coupled):.2f}" in PAGE
    (mode,) = bending_modes(("free", "free"), 1)
    aluminium = ps.material("aluminium")
    speed = math.sqrt(aluminium.young_modulus / aluminium.density)
    frequency = float(mode.wavenumber) ** 2 * speed * 0.006 / 4 / (2 * math.pi)
    assert f"the {frequency:.0f} Hz of the rod's first mode" in PAGE
    ratios = [r["rebound"] / r["belt"] for r in DATA["arm"] if r["mu"] == 0.8]
    assert max(ratios) / min(ratios) < 1.07
