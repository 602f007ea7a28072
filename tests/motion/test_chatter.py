"""Bounces near a contact at rest: the ratio, reverse chatter in runs, and how it is named."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from derivations.generated import reverse_chatter as forms
from painleve_sym.at.cases import classify
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.impact.chatter import chatter
from painleve_sym.problem.impact.one_contact import solve_impact

PUSHED = {"F": -10.0}
START = {"phi": 2.9}


@pytest.fixture(scope="module")
def cart():
    return Simulator(model("cart-pendulum"), RigidLaw(), "compiled")


@pytest.fixture(scope="module")
def growing(cart):
    return cart.run(START | {"y_dot": 1e-7}, t_end=0.15, parameters=PUSHED)


@pytest.mark.slow
def test_pushed_cart_at_rest_can_leave_in_reverse_chatter(cart):
    run = cart.run(START, t_end=1e-3, parameters=PUSHED)
    assert run.events[0].alternatives == ("stick", "reverse_chatter")
    assert run.reverse_chatter == ()


def test_growing_bounces_are_named_and_have_the_ratio_of_the_closed_form(cart, growing):
    (growth,) = growing.reverse_chatter
    assert growth.bounces > 30
    assert growth.start_time == growing.events_of("touchdown")[0].time
    speeds = [-e.state["y_dot"] for e in growing.events_of("touchdown")]
    at = classify(cart.mechanism, START, parameters=PUSHED).problem
    ratio = math.sqrt(forms.rho_energetic_squared(**numbers(at), e_energetic=0.75))
    assert growth.expected_ratio == pytest.approx(ratio, rel=1e-6)
    # The first bounces are so small that nothing else has changed.
    assert np.array(speeds[1:6]) / speeds[:5] == pytest.approx(np.full(5, ratio), rel=1e-6)
    assert growth.ratio == pytest.approx(ratio, rel=1e-2)


def test_threshold_separates_growth_from_decay(cart):
    (chatter,) = (
        c
        for c in classify(cart.mechanism, START, parameters=PUSHED).chatter
        if c.restitution == "energetic"
    )
    start = START | {"y_dot": 1e-7}
    for e, grows in ((chatter.threshold * 1.02, True), (chatter.threshold * 0.98, False)):
        run = cart.run(start, t_end=3e-6, parameters=PUSHED | {"e_energetic": e})
        speeds = [-x.state["y_dot"] for x in run.events_of("touchdown")]
        assert (speeds[-1] > speeds[0]) is grows
        assert bool(run.reverse_chatter) is grows


def test_ordinary_bounces_are_no_reverse_chatter():
    run = Simulator(rod(), RigidLaw()).run({"theta": 1.5, "y_A": 0.3, "theta_dot": 3.0}, t_end=2.0)
    assert run.reverse_chatter == ()


def test_reverse_chatter_is_saved_and_loaded(growing, tmp_path):
    growing.save(tmp_path / "run.npz")
    again = Trajectory.load(tmp_path / "run.npz")
    assert again.reverse_chatter == growing.reverse_chatter
    assert again.to_dict()["reverse_chatter"][0]["bounces"] == growing.reverse_chatter[0].bounces


def test_classification_tells_of_bounces_at_rest_only(cart):
    bounces = {c.restitution: c for c in classify(cart.mechanism, START, parameters=PUSHED).chatter}
    assert bounces["newton"].ratio == 0.75 and not bounces["newton"].reverse
    assert bounces["poisson"].reverse and bounces["energetic"].reverse
    assert classify(cart.mechanism, START | {"x_dot": 1.0}, parameters=PUSHED).chatter == ()
    assert classify(rod(), {"theta": 1.0, "theta_dot": 5.0}).chatter == ()  # B > 0


@pytest.mark.slow
@settings(max_examples=150)
@given(
    law=st.sampled_from(["newton", "poisson", "energetic"]),
    w=st.floats(0.1, 3),
    a=st.floats(0.05, 3),
    k=st.floats(-2, 2),
    b_t=st.floats(-10, 10),
    friction=st.floats(0, 3),
    e=st.floats(0.01, 1),
)
def test_bounces_followed_one_by_one_grow_exactly_where_it_says(law, w, a, k, b_t, friction, e):
    """A flight, an impact, a flight …: the size after many, against ρ."""
    problem = ContactProblem.single(a + k * k * w, k * w, w, -9.8, b_t, friction, 0.0)
    cycle = chatter(problem, law, e)
    W = ((a + k * k * w, k * w), (k * w, w))
    v_t, v_n, logs = 0.0, 1.0, []
    for _ in range(300):
        v_t += b_t * 2 * v_n / 9.8
        rebound, v_t = solve_impact(W, friction, (-v_n, v_t), law, e).velocity
        logs.append(np.log(rebound / v_n))
        v_t, v_n = v_t / rebound, 1.0
        if abs(v_t) > 1e100:
            break
    assert cycle.ratio == pytest.approx(np.exp(logs[-1]), rel=1e-9)
    assert cycle.reverse == (cycle.ratio > 1)
    if cycle.threshold is not None:
        assert 0 < cycle.threshold < 1
        assert chatter(problem, law, cycle.threshold).ratio == pytest.approx(1, rel=1e-7)
    elif abs(cycle.ratio - 1) > 1e-9:
        assert cycle.ratio < 1


def test_contact_that_opens_has_no_chatter():
    assert chatter(ContactProblem.single(1.0, 0.5, 1.0, 2.0, 1.0, 0.5, 0.0)) is None


def test_threshold_in_the_closed_form_of_the_law():
    problem = ContactProblem.single(1.25, 0.5, 1.0, -9.8, 5.0, 3.0, 0.0)
    cycle = chatter(problem, "poisson", 0.6)
    assert cycle.ratio == pytest.approx(forms.rho_poisson(0.5, 10 / 9.8, 0.6), rel=1e-12)
    assert cycle.threshold == pytest.approx(forms.e_poisson_1(0.5, 10 / 9.8), rel=1e-12)
    cycle, at = chatter(problem, "energetic", 0.9), numbers(problem)
    squared = forms.rho_energetic_squared(**at, e_energetic=0.9)
    assert cycle.ratio == pytest.approx(math.sqrt(squared), rel=1e-12)
    assert cycle.threshold == pytest.approx(forms.e_energetic_1(**at), rel=1e-12)


def numbers(problem):
    """Return what the closed forms take, mirrored to b_t > 0."""
    (W_nn, W_nt), (_, W_tt) = problem.W.tolist()
    side = math.copysign(1.0, problem.b_t)
    kappa, tau = side * W_nt / W_tt, -2 * side * problem.b_t / problem.b_n
    own = {"W_tt": W_tt, "kappa": kappa, "A_stick": W_nn - W_nt**2 / W_tt}
    return own | {"mu": problem.mu.item(), "tau": tau}
