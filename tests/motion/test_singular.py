"""Slip that runs into A = B = 0: the located limit, its exponent, and how it is named."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import StopReason
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.singular_limit import LimitKind
from painleve_sym.motion.trajectory import Trajectory

JAMMING_ROD = {"theta": math.radians(31), "x_A_dot": -30.0}
PARAMETERS = {"g": 10.0, "mu": 5 / 3}


@pytest.fixture(scope="module")
def rigid():
    return Simulator(rod(), RigidLaw(), "compiled")


@pytest.fixture(scope="module")
def jam(rigid):
    return rigid.run(JAMMING_ROD, t_end=3.0, parameters=PARAMETERS)


def _desingularised(start, mu, g):
    """The rod's slip in τ with dτ = dt/A, by hand: regular, and at A = B = 0 only for τ → ∞."""

    def field(tau, z):
        theta, theta_dot = z[1], z[2]
        s, c = math.sin(theta), math.cos(theta)
        A, B = 1 + 3 * c * (c - mu * s), theta_dot**2 * s - g
        spin = -3 * (mu * s - c) * B
        slip = -(mu + 3 * s * (mu * s - c)) * B + A * theta_dot**2 * c
        return [A, A * theta_dot, spin, slip]

    z = [0.0, start["theta"], start.get("theta_dot", 0.0), start["x_A_dot"]]
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-16}
    return solve_ivp(field, (0, 6), z, **options).y[:, -1]


def test_jamming_rod_ends_at_forty_five_degrees(jam):
    """A = B = 0 at θ = 45°, θ̇ = √(g/(l sinθ)); γ = 1/3 and F* = m g cot θ/(3 − 2) = 10 N."""
    limit = jam.limit
    assert jam.stop_reason is StopReason.DYNAMIC_JAM
    assert limit.kind is LimitKind.DYNAMIC_JAM
    assert limit.state["theta"] == pytest.approx(math.pi / 4, abs=1e-12)
    assert limit.state["theta_dot"] == pytest.approx(math.sqrt(10 * math.sqrt(2)), abs=1e-11)
    assert abs(limit.A) < 1e-12 and abs(limit.B) < 1e-12
    assert limit.force_exponent == pytest.approx(1 / 3, abs=1e-10)
    assert limit.measured_exponent == pytest.approx(1 / 3, abs=2e-5)
    assert limit.bounded_force == pytest.approx(10, rel=1e-9)
    assert limit.time > jam.final_time


def test_limit_is_that_of_the_desingularised_slip(rigid):
    t, theta, theta_dot, x_dot = _desingularised(JAMMING_ROD, PARAMETERS["mu"], PARAMETERS["g"])
    limit = rigid.run(JAMMING_ROD, t_end=3.0, parameters=PARAMETERS, rtol=1e-14).limit
    assert limit.time == pytest.approx(t, abs=1e-11)
    assert limit.state["theta"] == pytest.approx(theta, abs=1e-12)
    assert limit.state["theta_dot"] == pytest.approx(theta_dot, abs=1e-9)
    assert limit.state["x_A_dot"] == pytest.approx(x_dot, abs=1e-9)


@settings(max_examples=15)
@given(mu=st.floats(1.58, 2.5), gap=st.floats(0.02, 0.1), part=st.floats(0.3, 0.9))
def test_slips_near_the_point_jam_or_lift_off(rigid, mu, gap, part):
    """Above μ_C = 8/(3√3): F well above F* jams, below it lifts off."""
    tan = (3 * mu - math.sqrt(9 * mu**2 - 16)) / 2
    place, slope = math.atan(tan), (4 - tan**2) / tan
    theta = place - gap * 0.2
    bounded = 9.8 / tan / (slope - 2 * tan)
    s, c = math.sin(theta), math.cos(theta)
    A = 1 + 3 * c * (c - mu * s)
    assume(A * 5 * bounded / part < 9.8)  # such a slip exists: B < 0 there
    for force in (5 * bounded / part, bounded * part / 5):
        start = {"theta": theta, "theta_dot": math.sqrt((9.8 - A * force) / s), "x_A_dot": -30.0}
        run = rigid.run(start, t_end=0.2, parameters={"mu": mu}, until="liftoff")
        if force > bounded:
            assert run.stop_reason is StopReason.DYNAMIC_JAM
            expected = 1 - 2 * tan / slope
            assert run.limit.force_exponent == pytest.approx(expected, abs=1e-9)
            assert run.limit.bounded_force == pytest.approx(bounded, rel=1e-8)
        else:
            assert run.stop_reason is StopReason.UNTIL


@pytest.mark.parametrize(
    ("part", "reason", "kind"),
    [
        (1.02, StopReason.DYNAMIC_JAM, LimitKind.DYNAMIC_JAM),
        (0.98, StopReason.SINGULAR, LimitKind.LIFTOFF),
    ],
)
def test_the_bounded_force_parts_jam_and_lift_off(rigid, part, reason, kind):
    """A is all but 0 at the start, so that the force hardly moves away from F*."""
    mu = 2.0
    tan = (3 * mu - math.sqrt(9 * mu**2 - 16)) / 2
    bounded = 9.8 / tan / ((4 - tan**2) / tan - 2 * tan)

    def A(theta):
        return 1 + 3 * math.cos(theta) * (math.cos(theta) - mu * math.sin(theta))

    place = math.atan(tan)
    theta = brentq(lambda angle: A(angle) - 5e-8, place - 1e-3, place)
    speed = math.sqrt((9.8 - A(theta) * part * bounded) / math.sin(theta))
    start = {"theta": theta, "theta_dot": speed, "x_A_dot": -30.0}
    run = rigid.run(start, t_end=0.01, parameters={"mu": mu})
    assert run.stop_reason is reason
    assert run.limit.kind is kind
    assert run.limit.bounded_force == pytest.approx(bounded, rel=1e-6)


def test_below_the_threshold_everything_lifts_off(rigid):
    mu = 1.45
    tan = (3 * mu - math.sqrt(9 * mu**2 - 16)) / 2
    theta = math.atan(tan) - 0.01
    for force in (0.5, 5.0, 50.0, 500.0):
        s, c = math.sin(theta), math.cos(theta)
        A = 1 + 3 * c * (c - mu * s)
        start = {"theta": theta, "theta_dot": math.sqrt((9.8 - A * force) / s), "x_A_dot": -30.0}
        run = rigid.run(start, t_end=0.2, parameters={"mu": mu}, until="liftoff")
        assert run.stop_reason is StopReason.UNTIL


def test_mirrored_slip_jams_at_the_mirrored_place(rigid, jam):
    start = {"theta": math.pi - JAMMING_ROD["theta"], "x_A_dot": 30.0}
    run = rigid.run(start, t_end=3.0, parameters=PARAMETERS)
    assert run.stop_reason is StopReason.DYNAMIC_JAM
    assert run.limit.time == pytest.approx(jam.limit.time, abs=1e-9)
    assert run.limit.state["theta"] == pytest.approx(math.pi - jam.limit.state["theta"], abs=1e-9)


@pytest.mark.slow
def test_other_mechanisms_jam_too():
    """A block slipping to the right near θ = 1.39 rad, where r = 0.29 at μ = 2."""
    simulator = Simulator(model("block"), RigidLaw(), "compiled")
    start = {"theta": 1.41, "theta_dot": -5.6, "x_A_dot": 20.0}
    run = simulator.run(start, t_end=0.1, parameters={"mu": 2.0})
    assert run.stop_reason is StopReason.DYNAMIC_JAM
    limit = run.limit
    assert abs(limit.A) < 1e-9 and abs(limit.B) < 1e-8
    assert limit.measured_exponent == pytest.approx(limit.force_exponent, abs=1e-3)


def test_limit_is_saved_and_loaded(jam, tmp_path):
    jam.save(tmp_path / "jam.npz")
    again = Trajectory.load(tmp_path / "jam.npz")
    assert again.limit == jam.limit
    assert again.stop_reason is StopReason.DYNAMIC_JAM
    assert again.to_dict()["limit"]["kind"] == "dynamic_jam"


def test_runs_without_dense_output_have_no_measured_exponent(rigid, jam):
    run = rigid.run(JAMMING_ROD, t_end=3.0, parameters=PARAMETERS, record="end")
    assert run.limit.measured_exponent is None
    assert run.limit.time == pytest.approx(jam.limit.time, abs=1e-13)


def test_second_engine_finds_the_same_limit(jam):
    run = Simulator(rod(), RigidLaw(), "erk").run(
        JAMMING_ROD | {"theta": 0.7, "theta_dot": 3.6}, t_end=1.0, parameters=PARAMETERS
    )
    other = Simulator(rod(), RigidLaw(), "compiled").run(
        JAMMING_ROD | {"theta": 0.7, "theta_dot": 3.6}, t_end=1.0, parameters=PARAMETERS
    )
    assert run.stop_reason is other.stop_reason
    if other.limit is not None:
        assert run.limit.time == pytest.approx(other.limit.time, abs=1e-8)


def test_slip_that_opens_within_rounding_of_the_point_is_told_apart(rigid):
    """Below μ_C F* < 0: a large force falls to 0 only just before A does."""
    mu, force = 1.45, 3000.0
    tan = (3 * mu - math.sqrt(9 * mu**2 - 16)) / 2
    theta = math.atan(tan) - 1e-3 / (4 - tan**2) * tan
    s, c = math.sin(theta), math.cos(theta)
    A = 1 + 3 * c * (c - mu * s)
    start = {"theta": theta, "theta_dot": math.sqrt((9.8 - A * force) / s), "x_A_dot": -30.0}
    run = rigid.run(start, t_end=0.2, parameters={"mu": mu}, until="liftoff")
    assert run.stop_reason is StopReason.SINGULAR
    assert run.limit.kind is LimitKind.LIFTOFF
    assert "falls to 0" in run.stop_detail


PAGE = (Path(__file__).parents[2] / "docs" / "singular-point.md").read_text("utf-8")


def _ends(mu):
    """Return the angles between which A < 0 for the rod that slides to the left."""
    root = math.sqrt(9 * mu**2 - 16)
    return math.atan((3 * mu - root) / 2), math.atan((3 * mu + root) / 2)


@settings(max_examples=60)
@given(
    mu=st.floats(1.35, 2.5),
    gap=st.floats(1e-3, 0.05),
    spin=st.floats(-3.0, -1.0),
    slip=st.floats(-50.0, -0.5),
)
def test_no_slip_reaches_A_below_zero_at_the_upper_end(rigid, mu, gap, spin, slip):
    start = {"theta": min(_ends(mu)[1] + gap, 1.55), "theta_dot": spin, "x_A_dot": slip}
    assume(spin**2 * math.sin(start["theta"]) < 9.8)
    run = rigid.run(start, t_end=0.1, parameters={"mu": mu}, until=("slip_stop", "liftoff"))
    assert run.stop_reason in (StopReason.UNTIL, StopReason.T_END)
    assert run.final["theta"] > _ends(mu)[1]


@settings(max_examples=100)
@given(
    gap=st.floats(1e-3, 0.1),
    upper=st.booleans(),
    spin=st.floats(0.5, 3.2),
    slip=st.floats(-50.0, -0.5),
)
def test_below_the_threshold_no_slip_reaches_A_below_zero(rigid, gap, upper, spin, slip):
    low, high = _ends(1.4)
    theta = min(high + gap, 1.55) if upper else low - gap
    start = {"theta": theta, "theta_dot": -spin if upper else spin, "x_A_dot": slip}
    assume(spin**2 * math.sin(theta) < 9.8)
    run = rigid.run(start, t_end=0.3, until=("slip_stop", "liftoff"))
    assert run.stop_reason in (StopReason.UNTIL, StopReason.T_END)
    assert run.final["theta"] > high if upper else run.final["theta"] < low


@pytest.mark.parametrize(
    ("start", "time", "force"),
    [
        ({"theta": 1.25, "theta_dot": -1.0, "x_A_dot": -5.0}, "6.57863", "68.7"),
        ({"theta": 1.3, "theta_dot": -2.0, "x_A_dot": -2.0}, "6.78625", "83.5"),
    ],
)
def test_commands_of_the_page_stop_the_slip(rigid, start, time, force):
    text = ",".join(f"{name}={value:g}" for name, value in start.items())
    assert f"--state {text} --t-end 0.3" in PAGE
    run = rigid.run(start, t_end=0.3)
    stop = next(event for event in run.events if event.kind == "slip_stop")
    assert (f"{1e3 * stop.time:.5f}", f"{stop.normal_force:.1f}") == (time, force)
    assert f"{time} ms" in PAGE and force in PAGE


def test_impulse_in_front_of_A_0_always_slows_the_slip():
    """At A_s = 0 and det W > 0: s W_nt − μ W_tt = −det W/(s W_nt), since μ = W_nn/(s W_nt)."""
    W_nn, W_tt, coupling = sp.symbols("W_nn W_tt s_W_nt", positive=True)
    mu, det = W_nn / coupling, W_nn * W_tt - coupling**2
    assert sp.simplify(coupling - mu * W_tt + det / coupling) == 0


def test_a_slip_that_stands_at_a_0_has_no_time_left(rigid):
    """With θ̇ = 0 the rate of A is 0: no limit is ahead, and none is divided by zero."""
    start = {"theta": math.pi / 4 - 3.4e-9, "x_A_dot": -1.0}
    run = rigid.run(start, t_end=0.05, parameters={"mu": 5 / 3})
    assert run.stop_reason is StopReason.SINGULAR
    assert run.limit.kind is LimitKind.STOP
    assert run.limit.time == run.final_time
    assert run.limit.measured_exponent is None
    assert run.limit.state == run.final
