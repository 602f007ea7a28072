"""A coordinate is solved for so that a contact is closed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import painleve_sym as ps
from painleve_sym.at import closing
from painleve_sym.at.closing import closed_state, closed_states
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text

PLACE = st.floats(-1.0, 1.0)
QUICK = settings(max_examples=25)


def closed(name, close, state=(), **parameters):
    mechanism = ps.model(name)
    whole = dict.fromkeys(mechanism.state_names, 0.0) | dict(state)
    return closed_state(mechanism, whole, mechanism.parameters | parameters, close)


@QUICK
@given(y=PLACE, theta=st.floats(0.1, 1.5))
def test_a_height_becomes_exactly_zero_and_nothing_else_changes(y, theta):
    state = {"theta": theta, "y_A": y, "x_A_dot": -1.0}
    whole = closed("rod", "y_A", state)
    assert whole.pop("y_A") == pytest.approx(0.0, abs=1e-12)
    assert {n: v for n, v in whole.items() if v} == {"theta": theta, "x_A_dot": -1.0}


@QUICK
@given(theta=st.floats(-6.0, 6.0))
def test_the_angle_is_the_nearest_one_of_the_domain_that_closes_the_gap(theta):
    # The gap h - 2 l sin(theta) vanishes at asin(0.8) and pi - asin(0.8); cos(theta) > 0 is needed.
    own = [math.asin(0.8) + 2 * math.pi * k for k in range(-3, 4)]
    nearest = min(own, key=lambda root: abs(root - theta))
    other = sorted(abs(root - theta) for root in own)
    reached = closed("pr-robot", "theta", {"theta": theta})["theta"]
    if other[1] - other[0] > 1e-6:
        assert reached == pytest.approx(nearest, abs=1e-12)
    assert math.cos(reached) > 0


@QUICK
@given(one=st.floats(-0.9, -0.45), rate=PLACE)
def test_angle_and_rate_of_an_arm_agree_with_scipy_and_the_hand(one, rate):
    state = {"theta_1": one, "theta_1_dot": rate, "theta_2": -0.9}

    def gap(two):
        return 0.7 + 0.5 * math.sin(one) + 0.5 * math.sin(two)

    whole = closed("two-link-arm", "theta_2,theta_2_dot", state)
    two = brentq(gap, -math.pi / 2, 0.0, xtol=1e-15)
    assert whole["theta_2"] == pytest.approx(two, abs=1e-11)
    by_hand = -rate * math.cos(one) / math.cos(whole["theta_2"])
    assert whole["theta_2_dot"] == pytest.approx(by_hand, rel=1e-9, abs=1e-12)


def test_a_closed_contact_keeps_its_state():
    start = ps.model("pr-robot").start
    assert closed("pr-robot", "theta", start)["theta"] == start["theta"]


def test_a_gap_that_only_touches_zero_is_closed():
    # The link just reaches the ground: h = 2 l, a double zero at a right angle.
    mechanism = ps.model("strut")
    whole = dict.fromkeys(mechanism.state_names, 0.0) | {"theta": 1.2}
    values = mechanism.parameters | {"h": 2 * mechanism.parameters["l"]}
    reached = closed_state(mechanism, whole, values, "theta")["theta"]
    assert reached == pytest.approx(math.pi / 2, abs=1e-6)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_the_root_does_not_depend_on_the_unit_of_length(scale):
    whole = closed(
        "two-link-arm",
        "theta_2",
        {"theta_1": -0.6},
        l_1=0.5 * scale,
        l_2=0.5 * scale,
        h=0.7 * scale,
    )
    assert whole["theta_2"] == pytest.approx(-0.9887829, abs=1e-7)


def test_of_several_contacts_the_named_one_is_closed():
    whole = closed("block-two-feet", "B:theta", {"y_A": -0.05})
    parameters = ps.model("block-two-feet").parameters
    assert 2 * parameters["a"] * math.sin(whole["theta"]) == pytest.approx(0.05, rel=1e-12)
    alone = closed("block-two-feet", "A:y_A", {"y_A": 0.3, "theta": 0.2})
    assert alone["y_A"] == 0.0


def test_every_entry_point_closes_alike():
    state = {"theta": 0.7, "x_dot": -1.0}
    case = ps.classify("pr-robot", state, close="theta")
    run = ps.simulate("pr-robot", "rigid", state, t_end=1e-3, close="theta")
    own = ps.Simulator(ps.model("pr-robot"), ps.law("rigid")).run(state, t_end=1e-3, close="theta")
    jump = ps.evaluate_jump("pr-robot", "energetic", state, close="theta")
    by_hand = ps.evaluate_jump("pr-robot", "energetic", case.state)
    assert case.state["theta"] == pytest.approx(math.asin(0.8), abs=1e-12)
    same = ps.simulate("pr-robot", "rigid", case.state, t_end=1e-3)
    assert run.final == own.final == same.final
    assert jump.velocity == by_hand.velocity
    with pytest.raises(ps.InputError, match="does not depend on x"):
        ps.classify("pr-robot", state, close="x")


def test_many_states_are_closed_as_each_alone():
    robot = ps.model("pr-robot")
    starts = np.array([-2.0, 0.3, 0.9, 4.0, 7.0])[:, None]
    heights = np.array([0.2, 0.8, 0.99, 1.3])
    rest = dict.fromkeys(robot.state_names, 0.0) | robot.parameters | {"x_dot": -1.0}
    values = rest | {"theta": starts, "h": heights, "theta_dot": 0.5}
    solved = closed_states(robot, values, "theta,theta_dot")
    for place in np.ndindex(5, 4):
        state = {"theta": float(starts[place[0], 0]), "theta_dot": 0.5, "x_dot": -1.0}
        height = float(heights[place[1]])
        if height > 1:  # out of reach
            assert np.isnan(solved["theta"][place])
            with pytest.raises(ps.InputError, match="no theta makes the gap"):
                closed("pr-robot", "theta", state, h=height)
            continue
        alone = closed("pr-robot", "theta,theta_dot", state, h=height)
        assert solved["theta"][place] == alone["theta"]
        assert solved["theta_dot"][place] == alone["theta_dot"]


@pytest.mark.parametrize(
    ("name", "close"),
    [("pr-robot", "theta"), ("two-link-arm", "theta_2"), ("block-two-feet", "B:theta")],
)
def test_closed_forms_are_the_roots_that_a_search_finds(name, close, monkeypatch):
    mechanism, coordinate = ps.model(name), close.split(":")[-1]
    random = np.random.default_rng(3)
    values = {n: random.normal(0.0, 1.0, 60) for n in mechanism.state_names}
    values |= {n: v * random.uniform(0.3, 1.7, 60) for n, v in mechanism.parameters.items()}
    exact = closed_states(mechanism, values, close)[coordinate]
    monkeypatch.setattr(closing, "_closed_form_roots", lambda *_: None)
    searched = closed_states(mechanism, values, close)[coordinate]
    assert 3 < np.isnan(searched).sum() < 57
    np.testing.assert_allclose(exact, searched, rtol=1e-13, atol=1e-13)


@pytest.mark.filterwarnings("ignore:at .* points the state has a gap")
def test_a_map_needs_no_search_where_there_is_a_closed_form(monkeypatch):
    monkeypatch.delattr(closing, "_searched")
    regions = ps.region_map("pr-robot", ("h", "tau"), points=20, close="theta")
    assert regions.counts["outside"] < 400


def test_a_root_far_beyond_a_turn_is_reached():
    # A winch: the rope of a drum of radius 0.1 m lowers a load from 5 m to the ground.
    text = """
[coordinates]
x = { unit = "m" }
phi = { unit = "rad" }
[parameters]
m = { default = 1.0, unit = "kg", positive = true }
mu = { default = 0.3, unit = "1" }
[[bodies]]
mass = "m"
centre = ["x", "5 - phi/10"]
[[bodies]]
mass = "m"
centre = ["0", "0"]
inertia = "m/100"
angle = "phi"
[[contacts]]
name = "load"
point = ["x", "5 - phi/10"]
friction = "mu"
"""
    winch = mechanism_from_text(text, "winch.toml", "winch")
    rest = dict.fromkeys(winch.state_names, 0.0)
    assert closed_state(winch, rest, winch.parameters, "phi")["phi"] == pytest.approx(50, rel=1e-14)


def test_rows_of_a_batch_start_closed():
    times = {"t_end": 1e-4, "close": "theta"}
    states, heights = {"theta": 0.9, "x_dot": -1.0}, [0.7, 0.8, 1.5]
    runs = ps.simulate_batch("pr-robot", "hertz", states, parameters={"h": heights}, **times)
    assert runs["stop_reason"].tolist() == ["t_end", "t_end", "invalid_start"]
    for i in (0, 1):
        alone = ps.simulate("pr-robot", "hertz", states, parameters={"h": heights[i]}, **times)
        assert alone.final_state.tobytes() == runs.rows.state[i].tobytes()
