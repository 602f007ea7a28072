"""Rigid motion of the rod: every case of the contact problem, impacts, limits and balances."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from painleve_sym.at.cases import contact_problem
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, StopReason
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.simulator import Simulator
from painleve_sym.problem.impact.one_contact import solve_impact
from tests.scenes import point_mass
from tests.support.paper_law import paper_law

SLIDING = {"theta": 0.5, "theta_dot": 1.0, "x_A_dot": -1.0}
LIFTING = {"theta": 0.5, "theta_dot": 5.0, "x_A_dot": -1.0}
INCONSISTENT = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
INDETERMINATE = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}


@pytest.fixture(scope="module")
def rigid():
    return Simulator(rod(), RigidLaw(), "compiled")


def test_unique_slip_stays_closed_and_carries_the_lcp_force(rigid):
    run = rigid.run(SLIDING, t_end=0.05)
    assert [e.kind for e in run.events] == ["contact"]
    assert run.values("normal_force", 0.0)[0] == pytest.approx(6.0391275823, rel=1e-10)
    assert np.all(run.values("y_A", run.sample(50)) == 0)


def test_slip_follows_the_reduced_equations(rigid):
    """θ̈ and ẍ_A with F_n = −B/A, written out by hand for the rod and solved by SciPy."""
    mu, g = 1.4, 9.8

    def reduced(t, z):
        theta, theta_dot = z[1], z[3]
        s, c = math.sin(theta), math.cos(theta)
        force = (g - theta_dot**2 * s) / (1 + 3 * c * (c - mu * s))
        slip = (mu + 3 * s * (mu * s - c)) * force + theta_dot**2 * c
        return [z[2], theta_dot, slip, 3 * (mu * s - c) * force]

    run = rigid.run(SLIDING, t_end=0.1)
    other = solve_ivp(reduced, (0, 0.1), [0, 0.5, -1, 1], method="DOP853", rtol=1e-12, atol=1e-13)
    names = ("x_A", "theta", "x_A_dot", "theta_dot")
    assert [run.final[n] for n in names] == pytest.approx(list(other.y[:, -1]), rel=1e-9)


def test_unique_lift_off(rigid):
    run = rigid.run(LIFTING, t_end=0.05)
    assert [e.mode_after for e in run.events] == ["flight"]
    assert run.events[0].alternatives == ()


def test_inconsistent_state_makes_the_impact_without_collision(rigid):
    run = rigid.run(INCONSISTENT, t_end=1e-3)
    kinds = [e.kind for e in run.events]
    assert kinds == [
        "contact",
        "impact_slip_stop",
        "impact_max_compression",
        "impact_end",
        "liftoff",
    ]
    assert {e.time for e in run.events} == {0.0}
    after = run.events[-1].state
    # The paper's rule at this state: (14), (18), (21).
    assert after["y_A_dot"] == pytest.approx(0.05247, abs=5e-6)
    assert after["theta_dot"] == pytest.approx(1.60984, abs=5e-6)
    assert after["x_A_dot"] == 0


@pytest.mark.parametrize(
    ("policy", "mode"),
    [
        ("liftoff", "flight"),
        ("slip", "slip_neg_unstable"),
        ("impact", "impact/slip_neg/compression"),
    ],
)
def test_indeterminate_state_follows_the_policy_and_records_all(policy, mode):
    run = Simulator(rod(), RigidLaw(policy=policy)).run(INDETERMINATE, t_end=1e-4)
    assert run.events[0].mode_after == mode
    assert run.events[0].alternatives == ("liftoff", "slip_neg")


def test_unstable_slip_carries_the_second_solution():
    run = Simulator(rod(), RigidLaw(policy="slip")).run(INDETERMINATE, t_end=1e-4)
    assert run.values("normal_force", 0.0)[0] == pytest.approx(332.99227098, rel=1e-10)


def test_jamming_rod_meets_the_singular_point(rigid):
    """m = l = 1, J = 1/3, g = 10, μ = 5/3: A = B = 0 at θ = 45°, θ̇ = √(g/(l sinθ))."""
    start = {"theta": math.radians(31), "x_A_dot": -30.0}
    run = rigid.run(start, t_end=3.0, parameters={"g": 10.0, "mu": 5 / 3})
    assert run.stop_reason is StopReason.DYNAMIC_JAM
    assert run.final["theta"] == pytest.approx(math.pi / 4, abs=2e-8)
    assert run.final["theta_dot"] == pytest.approx(math.sqrt(10 * math.sqrt(2)), rel=1e-4)
    assert run.final_time == pytest.approx(0.8145496574, abs=2e-9)
    force = run.values("normal_force", run.step_time)
    assert force[-1] > 1e2 * force[0]


def test_bounces_that_accumulate_end_in_contact(rigid):
    """Upright rod on a frictionless floor: a ball with restitution e."""
    start = {"theta": math.pi / 2, "y_A": 0.5}
    e = 0.5
    run = rigid.run(start, t_end=2.0, parameters={"mu": 0.0, "e_energetic": e})
    settled = run.events_of("settle")
    assert len(settled) == 1
    limit = math.sqrt(2 * 0.5 / 9.8) * (1 + e) / (1 - e)
    assert settled[0].time == pytest.approx(limit, rel=1e-9)
    assert run.stop_reason is StopReason.T_END
    assert run.final_time == 2.0
    assert run.values("normal_force", 1.9)[0] == pytest.approx(9.8, rel=1e-9)
    assert np.all(np.abs(run.values("y_A", np.linspace(limit + 0.01, 2.0, 20))) < 1e-12)


@settings(max_examples=30)
@given(
    theta=st.floats(0.3, 2.8),
    theta_dot=st.floats(-3, 3),
    speed=st.floats(-3, 3),
    fall=st.floats(0, 2),
    mu=st.floats(0, 2),
    e=st.floats(0, 1),
)
def test_energy_balance_closes_and_nothing_is_gained(rigid, theta, theta_dot, speed, fall, mu, e):
    state = {"theta": theta, "theta_dot": theta_dot, "x_A_dot": speed, "y_A_dot": -fall}
    run = rigid.run(state, t_end=0.3, parameters={"mu": mu, "e_energetic": e}, max_events=2000)
    ends = (StopReason.T_END, StopReason.LEFT_DOMAIN, StopReason.SINGULAR, StopReason.EVENT_LIMIT)
    ends += (StopReason.DYNAMIC_JAM,)
    assert run.stop_reason in ends
    if len(run.step_time):
        assert run.energy_residual < 1e-9
    for name in ("friction_dissipation", "contact_dissipation"):
        assert run.final[name] > -1e-12


@settings(max_examples=20)
@given(theta=st.floats(0.4, 1.4), theta_dot=st.floats(-3, 3), speed=st.floats(-3, 3))
def test_mirrored_start_gives_the_mirrored_motion(rigid, theta, theta_dot, speed):
    a = rigid.run({"theta": theta, "theta_dot": theta_dot, "x_A_dot": speed}, t_end=0.05)
    mirrored = {"theta": math.pi - theta, "theta_dot": -theta_dot, "x_A_dot": -speed}
    b = rigid.run(mirrored, t_end=0.05)
    assert [e.kind for e in a.events[:3]] == [e.kind for e in b.events[:3]]
    assert a.final["theta_dot"] == pytest.approx(-b.final["theta_dot"], abs=1e-7)


@pytest.mark.parametrize("E", [20.9e12, 20.9e14, 20.9e16])
def test_softened_impact_tends_to_the_rigid_one(rigid, E):
    soft = Simulator(rod(), paper_law(), "compiled")
    run = soft.run(INCONSISTENT, t_end=0.01, parameters={"E": E}, until="separation")
    hard = rigid.run(INCONSISTENT, t_end=1e-3).events[-1].state
    error = abs(run.final["y_A_dot"] - hard["y_A_dot"])
    # What the rigid rule drops falls like E^(−1/(2n)).
    assert 0.4 < error / 0.01314 * (E / 20.9e14) ** (1 / (2 * 1.764)) < 1.6


def test_newton_gives_no_rebound_without_collision():
    run = Simulator(rod(), RigidLaw("newton")).run(INCONSISTENT, t_end=1e-6)
    impact = run.events_of("impact_end")[0]
    assert impact.state["y_A_dot"] == pytest.approx(0.0, abs=1e-15)


def test_start_inside_the_ground_is_refused(rigid):
    with pytest.raises(InputError, match="inside the ground"):
        rigid.run({"theta": 1.0, "y_A": -1e-6}, t_end=1.0)


@pytest.mark.parametrize("bad", [{"policy": "lift"}, {"restitution": "newtom"}])
def test_unknown_choices_suggest_the_nearest(bad):
    with pytest.raises(InputError, match="Did you mean"):
        _ = Simulator(rod(), RigidLaw(**bad)).contact


@pytest.mark.parametrize("restitution", ["energetic", "poisson", "newton"])
@settings(max_examples=40)
@given(
    theta=st.floats(0.2, 2.9),
    speed=st.floats(-3, 3),
    fall=st.floats(0.01, 2),
    mu=st.floats(0, 2),
    e=st.floats(0, 1),
)
def test_impact_of_the_automaton_is_the_complete_planar_impact(
    restitution, theta, speed, fall, mu, e
):
    """The chain of instantaneous modes in C against the numeric solver in impulse space."""
    simulator = _simulator(restitution)
    coefficient = simulator.own_parameters[0].name
    state = {"theta": theta, "x_A_dot": speed, "y_A_dot": -fall}
    given_parameters = {"mu": mu, coefficient: e}
    run = simulator.run(state, t_end=1e-9, parameters=given_parameters)
    problem = contact_problem(
        simulator.mechanism,
        dict.fromkeys(simulator.mechanism.state_names, 0.0) | state,
        simulator.parameters(given_parameters),
    )
    W = [[problem.W_nn, problem.W_nt], [problem.W_nt, problem.W_tt]]
    other = solve_impact(W, mu, (-fall, speed), restitution, e)
    end = run.events_of("impact_end")[0]
    size = abs(speed) + fall
    assert end.state["x_A_dot"] == pytest.approx(other.velocity[1], abs=1e-11 * size)
    assert end.state["y_A_dot"] == pytest.approx(other.velocity[0], abs=1e-11 * size)


_cache = {}


def _simulator(restitution):
    if restitution not in _cache:
        _cache[restitution] = Simulator(rod(), RigidLaw(restitution), "compiled")
    return _cache[restitution]


def test_wedged_strut_jams_and_says_so():
    """Rank one: once friction exceeds cot θ no finite force or impulse is a rigid answer."""
    strut = model("strut")
    run = Simulator(strut, RigidLaw()).run(strut.start, t_end=0.1, parameters={"mu": 1.0})
    assert run.stop_reason is StopReason.JAM
    assert "no exit" in run.stop_detail
    assert len(run.events) < 50


@pytest.mark.parametrize("restitution", ["energetic", "poisson", "newton"])
def test_contact_that_no_motion_slides_bounces(restitution):
    """A mass on a vertical rail: v_n⁺ = −e v_n⁻ by every law, and friction has no part in it."""
    text = point_mass(name="mass-on-rail").replace('["x", "y"]', '["0", "y"]')
    text = "".join(line for line in text.splitlines(True) if not line.startswith("x = "))
    mass, e, g, height = mechanism_from_text(text), 0.6, 9.8, 1.0
    given = {f"e_{restitution}": e}
    run = Simulator(mass, RigidLaw(restitution)).run({"y": height}, t_end=0.8, parameters=given)
    fall = math.sqrt(2 * height / g)
    rise = 0.8 - fall
    assert run.final["y"] == pytest.approx(e * g * fall * rise - g * rise**2 / 2, rel=1e-9)
    assert run.final["friction_dissipation"] == 0


@pytest.mark.parametrize(
    "name",
    [
        "eccentric-disc",
        pytest.param("cart-pendulum", marks=pytest.mark.slow),
        pytest.param("two-link-arm", marks=pytest.mark.slow),
        pytest.param("pr-robot", marks=pytest.mark.slow),
    ],
)
def test_named_mechanisms_move_and_keep_their_energy_balance(name):
    mechanism = model(name)
    run = Simulator(mechanism, RigidLaw()).run(mechanism.start, t_end=0.05)
    assert run.stop_reason in (StopReason.T_END, StopReason.LEFT_DOMAIN)
    assert run.energy_residual < 1e-9


@pytest.mark.parametrize("name", ["pr-robot", "strut"])
def test_touching_start_where_the_gap_is_no_coordinate_is_no_fall(name):
    mechanism = model(name)
    run = Simulator(mechanism, RigidLaw()).run(mechanism.start, t_end=1e-6)
    assert not run.events_of("touchdown")


@pytest.mark.parametrize("restitution", ["energetic", "poisson", "newton"])
def test_on_the_border_A_0_the_slip_stops_at_once(restitution):
    """A = 0 with B < 0 at v_n = 0: P_n = −v_t/C_s, then what the law gives back along A′."""
    state, mu = {"theta": math.pi / 4, "x_A_dot": -1.0}, {"mu": 5 / 3}
    run = _simulator(restitution).run(state, t_end=0.01, parameters=mu)
    first = [e.kind for e in run.events[:4]]
    assert first == ["contact", "impact_slip_stop", "impact_max_compression", "impact_end"]
    assert run.energy_residual < 1e-12
    after = run.events[3].state
    assert after["x_A_dot"] == 0.0
    near = _simulator(restitution).run(state, t_end=0.01, parameters={"mu": 5 / 3 + 1e-11})
    limit = near.events_of("impact_end")[0].state
    assert after["y_A_dot"] == pytest.approx(limit["y_A_dot"], abs=1e-4)
    assert after["theta_dot"] == pytest.approx(limit["theta_dot"], abs=1e-4)
