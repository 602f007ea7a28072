"""Static friction above kinetic, and Stribeck's curve: closed solutions, SciPy, and symmetries."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import painleve_sym as ps
from painleve_sym.c_export.export import export_scenario
from painleve_sym.c_export.files import expected
from painleve_sym.errors import InputError
from painleve_sym.laws.friction import FrictionLaw
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.study.scenario import Scenario
from painleve_sym.study.sweeps.runner import run_sweep
from painleve_sym.study.sweeps.sweep import Sweep
from tests.motion.comparisons import assert_same_motion, total_energy
from tests.scenes import FEET, parameter, point_mass
from tests.scenes import simulator as scene
from tests.support.exports import built_by_compiler

SPRING = """
[[springs]]
extension = "x"
stiffness = "k_s"
"""
BELT = point_mass(
    contact='surface_speed = "u"',
    parameters=parameter("k_s", 300.0, "N/m", "stiffness of the spring", "lower = 0")
    + parameter("u", 0.1, "m/s", "speed of the belt"),
    more=SPRING,
)
M, K_S, U, G, MU = 2.0, 300.0, 0.1, 9.8, 0.4
TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


@pytest.fixture(scope="module")
def belt():
    mechanism = mechanism_from_text(BELT)

    @functools.cache
    def simulator(friction):
        return ps.Simulator(mechanism, ps.law("linear", friction=friction))

    def run(friction, t_end, state=None, **parameters):
        start = {"x_dot": parameters.get("u", U), **(state or {})}
        return simulator(friction).run(
            start, t_end=t_end, initial_force=M * G, parameters=parameters, rtol=1e-11
        )

    return run


def rod_simulator(friction):
    return scene("rod", f"hertz/{friction}")


# ---- Coulomb is the limit ----


@pytest.mark.parametrize("friction", ["static", pytest.param("stribeck", marks=pytest.mark.slow)])
def test_equal_static_and_kinetic_friction_is_coulomb(friction):
    plain = rod_simulator("coulomb").run(TABLE_3, t_end=0.006)
    other = rod_simulator(friction).run(TABLE_3, t_end=0.006, parameters={"static_ratio": 1.0})
    assert_same_motion(other, plain, times=1e-13, values=1e-11)
    assert {"slip_stop", "separation"} <= {e.kind for e in plain.events}


def test_coulomb_friction_is_the_law_itself():
    law = ps.law("hertz")
    assert law.with_friction("coulomb") is law
    assert ps.law("hertz", friction="coulomb").definition == law.definition


# ---- a closed solution, and SciPy ----


def test_stick_slip_under_static_friction_has_its_closed_solution(belt):
    ratio = 1.5
    run = belt("static", 1.2, static_ratio=ratio)
    starts, stops = run.events_of("slip_start"), run.events_of("slip_stop")
    # It sticks to the belt until the spring carries mu_s m g.
    force = M * G * MU
    assert starts[0].time == pytest.approx(ratio * force / K_S / U, rel=1e-9)
    # Then it swings about the kinetic force until it is as fast as the belt again.
    w, a = math.sqrt(K_S / M), (ratio - 1) * force / K_S
    slipping = 2 * (math.pi - math.atan(a * w / U)) / w
    assert stops[0].time - starts[0].time == pytest.approx(slipping, rel=1e-8)
    assert starts[1].time - stops[0].time == pytest.approx(2 * a / U, rel=1e-8)


@settings(max_examples=12)
@given(
    ratio=st.floats(1.05, 2.5),
    v_s=st.floats(0.02, 0.5),
    start=st.floats(-0.4, 0.4),
)
def test_stribeck_slip_equals_scipy(belt, ratio, v_s, start):
    run = belt(
        "stribeck",
        0.15,
        {"x_dot": start + 3 * U, "x": 0.02},
        static_ratio=ratio,
        stribeck_velocity=v_s,
    )
    end = min([e.time for e in run.events], default=0.15)

    def rates(_, z):
        v = z[1] - U
        mu = MU * (1 + (ratio - 1) / (1 + (v / v_s) ** 2))
        return [z[1], -K_S / M * z[0] - math.copysign(mu, v) * G]

    z0 = [0.02, start + 3 * U]
    other = solve_ivp(rates, (0, end), z0, "DOP853", rtol=1e-12, atol=1e-14)
    if abs(z0[1] - U) > 1e-9:
        assert run.state(end)["x"] == pytest.approx(other.y[0, -1], rel=1e-8, abs=1e-11)
        assert run.state(end)["x_dot"] == pytest.approx(other.y[1, -1], rel=1e-8, abs=1e-10)


# ---- the rod: energy, mirror image, engines ----

CASES = st.fixed_dictionaries(
    {
        "static_ratio": st.floats(1.0, 3.0),
        "stribeck_velocity": st.floats(1e-3, 2.0),
        "mu": st.floats(0.1, 2.0),
    }
)


@settings(max_examples=15)
@given(parameters=CASES, friction=st.sampled_from(["static", "stribeck"]), slip=st.floats(-2, 2))
def test_energy_balance_closes_and_the_mirror_image_mirrors(parameters, friction, slip):
    if friction == "static":
        parameters = {k: v for k, v in parameters.items() if k != "stribeck_velocity"}
    simulator = rod_simulator(friction)
    state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": slip, "y_A_dot": -0.1}
    other = {**state, "theta": math.pi - 1.0, "theta_dot": -1.0, "x_A_dot": -slip}
    run = simulator.run(state, t_end=0.004, parameters=parameters, rtol=1e-11)
    mirror = simulator.run(other, t_end=0.004, parameters=parameters, rtol=1e-11)
    t = run.sample(40)
    values, energy = run.outputs(t), total_energy(run, t)
    assert np.ptp(energy) < 1e-9 * np.max(np.abs(energy))
    assert np.all(np.diff(run.values("friction_dissipation", t)) >= -1e-12)
    bound = parameters["mu"] * parameters["static_ratio"] * values["normal_force"]
    assert np.all(np.abs(values["tangential_force"]) <= bound * (1 + 1e-9) + 1e-9)
    assert [e.kind for e in run.events] == [e.kind for e in mirror.events]
    assert mirror.final["y_A"] == pytest.approx(run.final["y_A"], rel=1e-8, abs=1e-12)
    assert mirror.final["x_A_dot"] == pytest.approx(-run.final["x_A_dot"], rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("friction", ["static", pytest.param("stribeck", marks=pytest.mark.slow)])
def test_rows_of_a_batch_are_the_runs(friction):
    simulator, ratios = rod_simulator(friction), np.linspace(1.0, 2.0, 11)
    batch = run_batch(simulator, TABLE_3, {"static_ratio": ratios}, t_end=0.006)
    for i, ratio in enumerate(ratios):
        run = simulator.run(TABLE_3, t_end=0.006, parameters={"static_ratio": float(ratio)})
        for name in ("theta_dot", "y_A_dot", "x_A_dot"):
            assert batch[name][i] == run.final[name]


@pytest.mark.parametrize(
    ("mechanism", "friction"),
    [("rod", "static"), pytest.param(FEET, "stribeck", marks=pytest.mark.slow)],
)
def test_exported_c_gives_the_bits_of_the_run(mechanism, friction, tmp_path):
    """Also of several contacts; the friction law is part of the export's own scenario."""
    start = TABLE_3 if mechanism == "rod" else {"y_A": 1e-3, "theta": 0.02, "x_A_dot": -0.3}
    scenario = Scenario(
        mechanism, start, law="linear", law_choices={"friction": friction}, t_end=0.02,
        law_parameters={"k": 1e6, "c": 100.0, "static_ratio": 1.4},
    )  # fmt: skip
    done = export_scenario(scenario, tmp_path / "c")
    assert len(done.trajectory.events) >= 3
    assert built_by_compiler(done, "-O0", "-march=native", "-ffp-contract=off") == expected(
        done.trajectory
    )


def test_sweep_over_the_static_ratio_is_its_runs(tmp_path):
    text = """
    model = "rod"
    t_end = 0.006
    state = { theta = 1.0, theta_dot = 1.0, x_A_dot = -1.0 }
    law = { name = "hertz", friction = "static" }
    keep = ["theta_dot"]

    [axes]
    static_ratio = [1.0, 1.3, 1.6]
    """
    out = tmp_path / "swept.npz"
    run_sweep(Sweep.from_text(text, "static.toml"), out, threads=1)
    with np.load(out, allow_pickle=False) as data:
        swept = data["theta_dot"]
    simulator = rod_simulator("static")
    for value, ratio in zip(swept, (1.0, 1.3, 1.6), strict=True):
        run = simulator.run(TABLE_3, t_end=0.006, parameters={"static_ratio": ratio})
        assert value == run.final["theta_dot"]


def test_derivatives_by_the_parameters_of_friction_are_differences():
    simulator, step = rod_simulator("stribeck"), 1e-5
    options = {"t_end": 0.006, "rtol": 1e-12, "until": "separation"}
    names = ("static_ratio", "stribeck_velocity")
    values = {"static_ratio": 1.4, "stribeck_velocity": 0.05}
    own = simulator.sensitivities(TABLE_3, wrt=names, parameters=values, **options)
    for name in names:
        ends = [
            simulator.run(TABLE_3, parameters=values | {name: values[name] + h}, **options)
            for h in (-step, step)
        ]
        slope = (ends[1].final["y_A_dot"] - ends[0].final["y_A_dot"]) / (2 * step)
        assert own.final_gradient("y_A_dot")[name] == pytest.approx(slope, rel=1e-5)


@pytest.mark.parametrize(
    ("friction", "said"), [("coulomb", ""), ("static", "static"), ("stribeck", "Stribeck")]
)
def test_classification_says_what_friction_takes_from_its_theorems(friction, said, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(
        'model = "rod"\n[state]\ntheta = 1.0\nx_A_dot = -1.0\n'
        f'[law]\nname = "hertz"\nfriction = "{friction}"\n',
        encoding="utf-8",
    )
    notices = Scenario.read(path).contact_notices
    assert bool(notices) == bool(said) and all(said in notice for notice in notices)


def test_at_rest_stick_and_slip_are_both_possible_between_the_two_coefficients():
    # The statement of the notice: W diagonal, F_n = 1 N, and a pull of 0.6 N at mu 0.4, mu_s 0.8.
    pull, kinetic, static = 0.6, 0.4, 0.8
    assert pull <= static and pull - kinetic > 0
    W, b = np.eye(2), np.array([-1.0, pull])
    assert [s.mode.value for s in ContactProblem(W, b, [static], [0.0]).solutions()] == ["stick"]
    assert [s.mode.value for s in ContactProblem(W, b, [kinetic], [0.0]).solutions()] == [
        "slip_pos"
    ]


# ---- bad input ----


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ps.law("rigid", friction="spring"), "compliant law"),
        (lambda: ps.law("hertz", friction="lugre"), "coulomb, spring, static, stribeck"),
        (lambda: ps.law("hertz", friction="static").with_friction("stribeck"), "already"),
        (lambda: FrictionLaw.named("Coulomb"), "coulomb"),
        (
            lambda: rod_simulator("static").run(
                TABLE_3, t_end=1e-3, parameters={"static_ratio": 0.5}
            ),
            "1 <= static_ratio",
        ),
    ],
)
def test_what_does_not_go_together_is_one_sentence(make, words):
    with pytest.raises(InputError, match=words):
        make()
