"""Impacts of several contacts at once, against one contact, small steps, and balances."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.engines.impacts import solve_simultaneous_impact
from painleve_sym.errors import InputError
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.impact.one_contact import ImpactEnd, solve_impact
from tests.support.rigid_impacts import body_rows, energy, mobility, unit

LAW = st.sampled_from(sorted(RESTITUTIONS))
NEVER_GAINS = ("energetic", "poisson")
place = st.floats(-1, 1).map(lambda x: round(x, 3))
speed = st.floats(-2, 2).map(lambda x: round(x, 3))
friction = st.one_of(st.just(0.0), st.floats(0.005, 3.0))
inertias, either = st.floats(0.05, 2.0), st.booleans()


def block_rows(a: float, h: float) -> np.ndarray:
    """Rows n1, t1, n2, t2 of two feet at ∓a, h below the centre; coordinates x, y, θ."""
    return np.array([row for x in (-a, a) for row in ([0, 1, x], [1, 0, h])], dtype=float)


@st.composite
def impacts(draw, contacts=2):
    """Draw W, μ, v of one body that hits floor and walls with all of its contacts."""
    points = [(draw(place), draw(place)) for _ in range(contacts)]
    walls = [draw(either) for _ in range(contacts)]
    J = body_rows(points, walls)
    inertia = draw(inertias)
    mu = np.array([draw(friction) for _ in range(contacts)])
    v = J @ np.array([draw(speed), draw(speed), draw(speed)])
    # What approaches keeps its speed, what parts comes back: still a velocity of the contacts,
    # of a body on moving ground.
    v[::2] = -np.abs(v[::2])
    return mobility(J, np.array([1.0, 1.0, inertia])), mu, v


@st.composite
def impacts_at_rest(draw):
    """Draw W, μ, v as `random_impact` does, on ground at rest."""
    return random_impact(np.random.default_rng(draw(st.integers(0, 2**32 - 1))))


def random_impact(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return W, μ, v of a ladder or block that hits with both contacts at once."""
    points = [tuple(rng.uniform(-1, 1, 2)) for _ in range(2)]
    J = body_rows(points, [False, bool(rng.random() < 0.5)])
    mass, radius = 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-1, 0.3)
    W = mobility(J, np.array([mass, mass, mass * radius**2]))
    mu = 10 ** rng.uniform(-3, 0.5, 2)
    while True:
        v = J @ rng.normal(size=3)
        if np.all(v[::2] < 0):
            return W, mu, v


def check(W, mu, v, law, e, impact) -> None:
    """Assert momentum, unilaterality, the cone, friction against the slip, and the law."""
    scale = float(np.max(np.abs(v)))
    size = scale + float(np.max(np.abs(W) @ np.abs(impact.impulses)))
    assert np.max(np.abs(v + W @ impact.impulses - impact.velocities)) <= 1e-9 * size
    if impact.end is not ImpactEnd.JAM:
        assert np.all(impact.velocities[::2] >= 0)
    stored, released, at = np.zeros(len(mu)), np.zeros(len(mu)), v
    for piece in impact.pieces:
        normal, tangential = piece.impulses[::2], piece.impulses[1::2]
        assert np.all(normal >= 0)
        assert np.all(np.abs(tangential) <= mu * normal + 1e-8 * normal.max())
        works = piece.works[::2]
        stored -= np.minimum(works, 0)
        released += np.maximum(works, 0)
        if law != "newton":
            before, after = at[1::2], piece.velocities[1::2]
            assert np.all(piece.works[1::2] <= 1e-9 * size * normal.max())
            slips = before * after > 0
            opposed = -mu * np.sign(before) * normal
            assert np.allclose(tangential[slips], opposed[slips], rtol=1e-8, atol=0)
        at = piece.velocities
    total = impact.normal_work + impact.tangential_work
    work = float(sum(np.sum(np.abs(piece.works)) for piece in impact.pieces))
    if law in NEVER_GAINS:
        assert total <= 1e-9 * work
    if law == "energetic" and impact.end is not ImpactEnd.JAM:
        assert np.allclose(released, e**2 * stored, rtol=1e-7, atol=1e-9 * work)


@settings(max_examples=80)
@given(impacts(), unit, LAW)
def test_impact_obeys_momentum_cone_slip_and_law(impact, e, law):
    W, mu, v = impact
    check(W, mu, v, law, e, solve_simultaneous_impact(W, mu, v, law, e))


@settings(max_examples=80)
@given(impacts(contacts=3), unit, LAW)
def test_impact_of_three_contacts_obeys_the_same(impact, e, law):
    W, mu, v = impact
    check(W, mu, v, law, e, solve_simultaneous_impact(W, mu, v, law, e))


@settings(max_examples=80)
@given(impacts_at_rest(), unit, st.sampled_from(NEVER_GAINS))
def test_impact_on_firm_ground_never_gains_energy(impact, e, law):
    W, mu, v = impact
    solution = solve_simultaneous_impact(W, mu, v, law, e)
    check(W, mu, v, law, e, solution)
    assert energy(W, solution.velocities) <= energy(W, v) * (1 + 1e-9)


@pytest.mark.slow
def test_no_gain_in_a_sweep_of_ladders_and_blocks():
    """Within one phase with friction at its end, 36 of these gained by the energetic law."""
    rng = np.random.default_rng(1)
    jams = 0
    for _ in range(1500):
        W, mu, v = random_impact(rng)
        e = 1.0 if rng.random() < 0.5 else rng.uniform()
        before = energy(W, v)
        for law in NEVER_GAINS:
            impact = solve_simultaneous_impact(W, mu, v, law, e)
            assert energy(W, impact.velocities) <= before * (1 + 1e-9)
            change = impact.normal_work + impact.tangential_work
            assert energy(W, impact.velocities) - before == pytest.approx(change, abs=1e-8 * before)
            jams += impact.end is ImpactEnd.JAM
    assert jams <= 10


@settings(max_examples=80)
@given(impacts_at_rest(), unit)
def test_newtons_law_gains_what_friction_returns_beyond_what_restitution_loses(impact, e):
    """ΔT = Σ (P_t (v_t⁺ + v_t⁻) − (1 − e) P_n |v_n⁻|)/2, by hand from v⁺ − v⁻ = W P."""
    W, mu, v = impact
    solution = solve_simultaneous_impact(W, mu, v, "newton", e)
    if solution.end is ImpactEnd.JAM:
        return
    P, both = solution.impulses, v + solution.velocities
    expected = (P[1::2] @ both[1::2] + (1 - e) * P[::2] @ v[::2]) / 2
    change = energy(W, solution.velocities) - energy(W, v)
    assert change == pytest.approx(expected, abs=1e-8 * energy(W, v) + 1e-9 * abs(expected))
    assert bool(solution.notice) == (solution.energy_change > 1e-9 * energy(W, v))
    if e == 0:
        assert change <= 1e-9 * energy(W, v)


@settings(max_examples=60)
@given(impacts_at_rest(), unit)
def test_newtons_law_gains_nothing_without_friction(impact, e):
    W, _, v = impact
    solution = solve_simultaneous_impact(W, np.zeros(2), v, "newton", e)
    assert energy(W, solution.velocities) <= energy(W, v) * (1 + 1e-9)
    assert solution.notice == ""


def test_newtons_law_gains_energy_in_the_fall_of_a_block_on_two_feet():
    """By hand: foot B alone pushes, its approach comes back by e, and its slip is stopped."""
    W = mobility(block_rows(1.0, 1.4655005627793976), np.array([1.0, 1.0, 1.0492306332]))
    v, mu = np.array([-0.8336, -1.42637, -3.2932, -1.42637]), np.full(2, 0.9309)
    impact = solve_simultaneous_impact(W, mu, v, "newton", 0.9813)
    foot = np.linalg.solve(W[2:, 2:], [1.9813 * 3.2932, 1.42637])
    assert abs(foot[1]) < 0.9309 * foot[0]
    np.testing.assert_allclose(impact.impulses, [0, 0, *foot], rtol=1e-12)
    gain = foot @ [(0.9813 - 1) * 3.2932, -1.42637] / 2
    assert impact.energy_change == pytest.approx(gain, rel=1e-12)
    assert gain / energy(W, v) == pytest.approx(0.331, abs=5e-4)
    assert impact.notice == "The impact adds 0.99 J, 33.1 % of the kinetic energy before it, " + (
        "by the restitution law newton."
    )
    for law in NEVER_GAINS:
        assert solve_simultaneous_impact(W, mu, v, law, 0.9813).energy_change < 0


def test_of_several_ways_on_an_impact_says_that_there_were_others():
    """Two bodies that slide with A < 0 at rest against the ground: each may begin, or both."""
    one = np.array([[1.0, 0.6], [0.6, 1.0]])
    W = np.block([[one, np.zeros((2, 2))], [np.zeros((2, 2)), one]])
    v, load = np.array([0.0, 1.0, 0.0, 1.0]), np.array([-1.0, 0.0, -1.0, 0.0])
    impact = solve_simultaneous_impact(W, np.full(2, 2.0), v, "energetic", 0.5, load=load)
    assert not impact.is_unique
    alone = solve_simultaneous_impact(one, np.array([2.0]), v[:2], "energetic", 0.5, load=load[:2])
    assert alone.is_unique


LADDER_GAIN = {
    "x": 1.1643135350014513,
    "theta": 0.949417546469858,
    "velocity": [-1.1148894727309953, -0.5428140061004343, -1.2617945612963892],
    "mu": [0.004442450867425118, 1.0297975782705493],
}


def test_the_ladder_that_gained_energy_loses_it():
    """Floor and wall together, e = 1: with friction opposed to the slip at the end, +13.8 %."""
    s, c = math.sin(LADDER_GAIN["theta"]), math.cos(LADDER_GAIN["theta"])
    # x, y of the lower end, θ clockwise; centre (x − cos θ, y + sin θ), upper end twice as far.
    J = np.array([[0, 1, 0], [1, 0, 0], [1, 0, 2 * s], [0, -1, -2 * c]], dtype=float)
    mass = 5 * np.array([[1, 0, s], [0, 1, c], [s, c, 4 / 3]])
    W = J @ np.linalg.solve(mass, J.T)
    v = J @ np.array(LADDER_GAIN["velocity"])
    impact = solve_simultaneous_impact(W, np.array(LADDER_GAIN["mu"]), v, "energetic", 1.0)
    check(W, np.array(LADDER_GAIN["mu"]), v, "energetic", 1.0, impact)
    assert impact.tangential_work < 0
    assert energy(W, impact.velocities) < energy(W, v)


@settings(max_examples=80)
@given(
    st.floats(0.1, 10),
    st.floats(0.1, 10),
    st.floats(-0.99, 0.99),
    st.one_of(st.just(0.0), speed),
    st.one_of(st.just(0.0), st.floats(-2, -0.01)),
    st.one_of(st.just(0.0), st.floats(0.01, 4)),
    unit,
    LAW,
)
def test_one_contact_is_routh(W_nn, W_tt, skew, v_t, v_n, mu, e, law):
    W_nt = skew * math.sqrt(W_tt * W_nn)
    W = np.array([[W_nn, W_nt], [W_nt, W_tt]])
    routh = solve_impact(W.tolist(), mu, (v_n, v_t), law, e)
    impact = solve_simultaneous_impact(W, np.array([mu]), np.array([v_n, v_t]), law, e)
    if routh.case is ImpactClass.NO_IMPACT:
        assert impact.pieces == ()
        return
    size = 1 + abs(v_t) + abs(v_n) + routh.normal_impulse * (W_nn + W_tt)
    assert impact.end is routh.end
    np.testing.assert_allclose(impact.velocities, routh.velocity, atol=1e-12 * size)
    impulses = routh.impulse
    np.testing.assert_allclose(impact.impulses, impulses, rtol=1e-9, atol=1e-12 * size)


@pytest.mark.parametrize("mu", [0.0, 0.3, 2.0])
@pytest.mark.parametrize("v_n", [-1e-9, -1e-11, -1e-13, -1e-15, -1e-300])
def test_newtons_law_gives_back_e_of_a_slow_approach_that_is_no_rounding(mu, v_n):
    # With mu = 2 friction first presses the contact on: A < 0.
    W = np.array([[1.0, 0.6], [0.6, 1.0]])
    impact = solve_simultaneous_impact(W, np.array([mu]), np.array([v_n, 1.0]), "newton", 0.5)
    rebound = -0.5 * v_n if v_n < -1e-14 else 0.0
    assert impact.velocities[0] == rebound
    assert impact.end is (ImpactEnd.SEPARATION if rebound else ImpactEnd.PERSISTENT)
    routh = solve_impact(W.tolist(), mu, (v_n, 1.0), "newton", 0.5)
    np.testing.assert_allclose(impact.velocities, routh.velocity, atol=1e-14)


def _stepped(W, mu, v, e, weights, step):
    """Follow an energetic impact by small steps of the path; it knows no pieces and no events.

    Each contact pushes by its weight or not, by its velocity and budget before the step; friction
    is the impulse in the cones nearest to one that stops all slips, by projected sweeps.
    """
    n = len(mu)
    v, budget = v.copy(), np.zeros(n)
    for _ in range(200_000):
        push = (v[::2] < -1e-12) | (budget > 0)
        if not np.any(push):
            return v
        P = np.zeros(2 * n)
        P[::2] = step * push * weights
        for _ in range(40):
            for i in range(n):
                P[2 * i + 1] = 0.0
                rest = v[2 * i + 1] + W[2 * i + 1] @ P
                limit = mu[i] * P[2 * i]
                P[2 * i + 1] = np.clip(-rest / W[2 * i + 1, 2 * i + 1], -limit, limit)
        after = v + W @ P
        work = P[::2] * (v[::2] + after[::2]) / 2
        budget = np.maximum(0.0, budget - np.where(work < 0, e**2, 1.0) * work)
        v = after
    raise AssertionError("the steps do not end")


@pytest.mark.slow
def test_the_path_agrees_with_small_steps():
    rng = np.random.default_rng(5)
    for _ in range(12):
        W, mu, v = random_impact(rng)
        e = rng.uniform(0.2, 0.9)
        impact = solve_simultaneous_impact(W, mu, v, "energetic", e)
        weights = impact.pieces[0].impulses[::2] / impact.pieces[0].impulses[::2].max()
        step = float(impact.impulses[::2].max()) / 4000
        stepped = _stepped(W, mu, v, e, weights, step)
        bound = 60 * step * float(np.max(np.abs(W))) * (1 + mu.max())
        assert np.max(np.abs(stepped - impact.velocities)) <= bound


@settings(max_examples=60)
@given(impacts(), unit, LAW, st.floats(-6, 6), st.floats(-6, 6))
def test_units_of_mass_length_and_time_change_nothing(impact, e, law, mass, velocity):
    W, mu, v = impact
    here = solve_simultaneous_impact(W, mu, v, law, e)
    m, u = 10.0**mass, 10.0**velocity
    there = solve_simultaneous_impact(W / m, mu, v * u, law, e)
    assert there.end is here.end
    size = float(np.max(np.abs(v), initial=0) + np.max(np.abs(W) @ np.abs(here.impulses)))
    np.testing.assert_allclose(there.velocities / u, here.velocities, atol=1e-6 * size)


@settings(max_examples=60)
@given(impacts(), unit, LAW, st.integers(-300, 300), st.integers(-300, 300))
def test_powers_of_two_change_no_digit(impact, e, law, mass, velocity):
    W, mu, v = impact
    here = solve_simultaneous_impact(W, mu, v, law, e)
    there = solve_simultaneous_impact(np.ldexp(W, -mass), mu, np.ldexp(v, velocity), law, e)
    np.testing.assert_array_equal(np.ldexp(there.velocities, -velocity), here.velocities)
    np.testing.assert_array_equal(np.ldexp(there.impulses, -velocity - mass), here.impulses)


@settings(max_examples=60)
@given(impacts(), unit, LAW)
def test_the_mirror_image_is_the_mirrored_impact(impact, e, law):
    W, mu, v = impact
    S = np.tile([1.0, -1.0], 2)
    here = solve_simultaneous_impact(W, mu, v, law, e)
    there = solve_simultaneous_impact(W * np.outer(S, S), mu, v * S, law, e)
    assert there.end is here.end
    size = float(np.max(np.abs(v), initial=0) + np.max(np.abs(W) @ np.abs(here.impulses)))
    np.testing.assert_allclose(there.velocities * S, here.velocities, atol=1e-7 * size)


@settings(max_examples=60)
@given(impacts(), unit, LAW)
def test_the_order_of_contacts_changes_nothing(impact, e, law):
    W, mu, v = impact
    order = [2, 3, 0, 1]
    here = solve_simultaneous_impact(W, mu, v, law, e)
    there = solve_simultaneous_impact(W[np.ix_(order, order)], mu[::-1], v[order], law, e)
    assert there.end is here.end
    size = float(np.max(np.abs(v), initial=0) + np.max(np.abs(W) @ np.abs(here.impulses)))
    np.testing.assert_allclose(there.velocities[order], here.velocities, atol=1e-7 * size)


@settings(max_examples=60)
@given(impacts_at_rest(), st.sampled_from(NEVER_GAINS))
def test_without_friction_and_with_e_1_no_energy_is_lost_by_the_energetic_law(impact, law):
    W, _, v = impact
    solution = solve_simultaneous_impact(W, np.zeros(2), v, law, 1.0)
    after, before = energy(W, solution.velocities), energy(W, v)
    assert after <= before * (1 + 1e-9)
    if law == "energetic":
        assert after == pytest.approx(before, rel=1e-9)


# ---- contacts that share what one of them could bear ----


def test_a_contact_that_is_lifted_and_pressed_again_gives_back_what_it_stored():
    """Stopping all three at once takes nothing from the second; the others' rebound presses it."""
    J = np.array([[1, 0, 0.25], [0, 1, 0], [0, 1, 0.5], [1, 0, 0], [0, 1, -0.5], [1, 0, 1]])
    W, mu = J @ J.T, np.array([2.0, 0.0, 1.0])
    v = np.array([-0.25, -1.0, -0.5, 0.0, -1.5, 1.0])
    impact = solve_simultaneous_impact(W, mu, v, "energetic", 1.0)
    check(W, mu, v, "energetic", 1.0, impact)
    assert impact.pieces[0].impulses[2] == 0 < impact.impulses[2]
    np.testing.assert_allclose(impact.works[::2], 0, atol=1e-12)


def test_newtons_problem_without_a_solution_jams():
    """Two walls and moving ground: what closes one contact opens no other one."""
    J = np.array([[0, 1, 0], [1, 0, 0], [1, 0, -1], [0, 1, 0], [1, 0, 1], [0, 1, 1]])
    W, mu = (J @ J.T).astype(float), np.array([1.0, 0.0, 1.0])
    v = np.array([0.0, 0.0, -1.0, 0.0, -1.0, 1.0])
    assert not ContactProblem(W, v, mu, np.zeros(3)).solutions()
    impact = solve_simultaneous_impact(W, mu, v, "newton", 0.0)
    assert (impact.end, impact.pieces) == (ImpactEnd.JAM, ())


def test_newtons_problem_where_one_foot_alone_is_hit():
    """A coupling that is rounding alone, to the foot on a spring, matters to nothing."""
    J = np.array(
        [
            [0, 1, -0.6, 0],
            [1, 0, 0.7, 0],
            [1e-17, 1, 0, -1],
            [1, 0, 0.75, 1e-17],
            [0, 1, 0.6, 0],
            [1, 0, 0.65, 0],
        ]
    )
    foot = np.array([[1, 0, 0.75, 0], [0, 1, 0, -1]])
    mass = np.diag([10.0, 10.0, 1.5, 0.0]) + 2 * foot.T @ foot
    W = J @ np.linalg.solve(mass, J.T)
    mu = np.array([0.3, 0.4, 0.5])
    v = np.array([0.0, 0.0, 0.0, -0.044, -1.055, 0.044])
    impact = solve_simultaneous_impact(W, mu, v, "newton", 0.0)
    assert impact.end is ImpactEnd.SEPARATION
    check(W, mu, v, "newton", 0.0, impact)
    impulses = [0, 0, 0, 0, impact.impulses[4], -0.5 * impact.impulses[4]]
    np.testing.assert_allclose(impact.impulses, impulses, atol=1e-12)


@pytest.mark.parametrize("e", [0.0, 0.6])
def test_two_contacts_with_equal_normals_share_newtons_impulse(e):
    """Uncoupled friction: each slips against its own μ F_n, and half the weight is on each."""
    W = np.array([[1.0, 0, 1, 0], [0, 1, 0, 1], [1, 0, 1, 0], [0, 1, 0, 1.13]])
    mu, v = np.array([0.06, 0.03]), np.array([-0.5, -0.5, -0.5, -1.0])
    half = 0.25 * (1 + e)
    impact = solve_simultaneous_impact(W, mu, v, "newton", e)
    np.testing.assert_allclose(impact.impulses, [half, 0.06 * half, half, 0.03 * half], rtol=1e-9)
    check(W, mu, v, "newton", e, impact)


# ---- known results ----


def test_symmetric_drop_without_friction_returns_with_e():
    W = mobility(block_rows(0.1, 0.3), np.array([2.0, 2.0, 0.05]))
    for law in RESTITUTIONS:
        impact = solve_simultaneous_impact(W, np.zeros(2), np.array([-1.0, 0, -1.0, 0]), law, 0.6)
        np.testing.assert_allclose(impact.velocities[::2], [0.6, 0.6], atol=1e-12)
        np.testing.assert_allclose(impact.impulses, [1.6, 0, 1.6, 0], atol=1e-12)


def test_plastic_landing_on_both_feet_stops_the_block():
    """Four impulses, three freedoms: the motion is one although the forces are not."""
    W = mobility(block_rows(0.1, 0.3), np.array([2.0, 2.0, 0.05]))
    velocity = np.array([-1.0, 0.2, -1.0, 0.2])
    impact = solve_simultaneous_impact(W, np.array([0.8, 0.8]), velocity, "poisson", 0.0)
    np.testing.assert_allclose(impact.velocities, 0, atol=1e-12)
    assert impact.impulses[::2].sum() == pytest.approx(2.0)
    assert impact.end is ImpactEnd.PERSISTENT


def test_a_contact_that_the_other_one_lifts_takes_no_part():
    """A slender block on its left foot falls on the right one, which throws the left one up."""
    W = mobility(block_rows(0.1, 0.5), np.array([1.0, 1.0, 0.09]))
    velocity = np.array([0.0, 0.0, -1.0, 0.0])
    impact = solve_simultaneous_impact(W, np.array([2.0, 2.0]), velocity, "energetic", 0.4)
    alone = solve_impact(W[2:, 2:].tolist(), 2.0, (-1.0, 0.0), "energetic", 0.4)
    assert impact.impulses[0] == 0
    np.testing.assert_allclose(impact.velocities[2:], alone.velocity, atol=1e-14)


def test_impact_without_collision_brings_a_sliding_contact_to_rest():
    W = np.array([[2.6, 1.9], [1.9, 1.6]])
    assert W[0, 0] - 1.5 * W[0, 1] < 0
    impact = solve_simultaneous_impact(W, np.array([1.5]), np.array([0.0, 1.0]), "poisson", 0.0)
    np.testing.assert_allclose(impact.velocities, 0, atol=1e-12)


def test_of_two_impacts_without_collision_the_load_decides():
    """Two contacts of two bodies, each with A < 0: the one that is pressed impacts."""
    one = np.array([[1.0, 0.6], [0.6, 1.0]])
    W = np.block([[one, np.zeros((2, 2))], [np.zeros((2, 2)), one]])
    v = np.array([0.0, 1.0, 0.0, 1.0])
    for pressed in (0, 1):
        load = np.array([1.0, 0.0, 1.0, 0.0])
        load[2 * pressed] = -1.0
        impact = solve_simultaneous_impact(W, np.full(2, 2.0), v, "energetic", 0.5, load=load)
        assert np.flatnonzero(impact.impulses[::2]).tolist() == [pressed]


def test_without_slip_and_approach_nothing_begins():
    impact = solve_simultaneous_impact(np.eye(4), np.ones(2), np.zeros(4))
    assert (impact.end, impact.pieces) == (ImpactEnd.JAM, ())


def test_a_wedge_between_two_walls_jams():
    """A bar driven down between two steep walls: friction holds it whatever it has stored."""
    tilt = 0.2  # of the walls from the vertical: tan 0.2 < μ
    n = [np.array([math.cos(tilt), math.sin(tilt)]), np.array([-math.cos(tilt), math.sin(tilt)])]
    t = [np.array([-k[1], k[0]]) for k in n]
    J = np.array([n[0], t[0], n[1], t[1]])
    v = J @ np.array([0.0, -1.0])
    W = J @ J.T
    for e, end in ((0.5, ImpactEnd.JAM), (0.0, ImpactEnd.PERSISTENT)):
        impact = solve_simultaneous_impact(W, np.full(2, 0.5), v, "energetic", e)
        np.testing.assert_allclose(impact.velocities, 0, atol=1e-12)
        assert impact.end is end
    slippery = solve_simultaneous_impact(W, np.full(2, 0.1), v, "energetic", 0.5)
    assert slippery.end is ImpactEnd.SEPARATION


def test_an_unknown_law_is_named():
    with pytest.raises(InputError, match="unknown restitution law 'stronge'"):
        solve_simultaneous_impact(np.eye(2), np.ones(1), np.array([-1.0, 0]), "stronge")


# W row by row, mu and v of a body that hits with three contacts and comes to rest with all at once.
RESTING_MOBILITY = [
    6.093626602405338,
    -0.4410931649335734,
    -11.921570419568178,
    -1.3665521117332593,
    -7.752645720878447,
    5.9696747090841695,
    -0.4410931649335734,
    0.3295223295937131,
    1.2029708034052395,
    0.12648617586387356,
    0.885794014083547,
    -0.4316627562801599,
    -11.92157041956818,
    1.2029708034052395,
    24.80995072560965,
    3.418583584014816,
    16.237509051251497,
    -11.666691655205769,
    -1.3665521117332593,
    0.12648617586387356,
    3.418583584014816,
    0.7726999824463545,
    2.223118805772047,
    -1.3310081445542568,
    -7.752645720878448,
    0.885794014083547,
    16.237509051251497,
    2.223118805772047,
    10.662815372044083,
    -7.586897023992538,
    5.96967470908417,
    -0.43166275628015993,
    -11.666691655205769,
    -1.3310081445542568,
    -7.586897023992538,
    5.84837286137765,
]
RESTING_FRICTION = [
    2.3431629876730327,
    1.3119905871779973,
    0.6134800391501879,
]
RESTING_VELOCITY = [
    -1.0844350038323212,
    -1.089258873934939,
    -1.172190003521374,
    -1.1383248408101727,
    -1.1420750852340216,
    -1.0853303908706389,
]


def test_three_contacts_that_come_to_rest_at_once_rebound_alike_in_every_order():
    """One of them does not push then; its slip is rounding, which friction must not oppose."""
    W = np.array(RESTING_MOBILITY).reshape(6, 6)
    mu, v = np.array(RESTING_FRICTION), np.array(RESTING_VELOCITY)
    after = []
    for order in itertools.permutations(range(3)):
        rows = [2 * i + k for i in order for k in (0, 1)]
        impact = solve_simultaneous_impact(
            W[np.ix_(rows, rows)], mu[list(order)], v[rows], "poisson", 1.0
        )
        after.append(impact.velocities[np.argsort(rows)])
    assert np.ptp(after, axis=0).max() <= 1e-9 * np.abs(v).max()


EYE, FALL = np.eye(4), [-1.0, 0.0, -1.0, 0.0]
REFUSED = {
    "nan": (EYE * math.nan, [0.5, 0.5], FALL, "newton", 0.5, "W_n1n1: got nan"),
    "opening": (
        EYE,
        [0.5, 0.5],
        [-1.0, 0, 1.0, 0],
        "newton",
        0.5,
        "v_n2: got 1.0 m/s, need v_n <=",
    ),
    "friction": (EYE, [0.5, -0.5], FALL, "newton", 0.5, "mu_2: got -0.5, need mu >= 0"),
    "indefinite": (-EYE, [0.5, 0.5], FALL, "newton", 0.5, "semidefinite|symmetric"),
    "not symmetric": (np.triu(EYE + 0.1), [0.5, 0.5], FALL, "newton", 0.5, "symmetric"),
    "shape": (np.eye(3), [0.5, 0.5], FALL, "newton", 0.5, r"\(2 n, 2 n\).*check the shapes"),
    "one friction": (EYE, [0.5], FALL, "newton", 0.5, "check the shapes"),
    "text": ("a", [0.5, 0.5], FALL, "newton", 0.5, "check the shapes"),
    "e": (EYE, [0.5, 0.5], FALL, "newton", 7.0, "e: got 7.0, need 0 <= e <= 1"),
    "law": (EYE, [0.5, 0.5], FALL, "newtons", 0.5, "restitution law"),
}


@pytest.mark.parametrize("case", sorted(REFUSED))
def test_impact_of_several_contacts_refuses_what_it_cannot_use(case):
    *arguments, text = REFUSED[case]
    with pytest.raises(InputError, match=rf"(?s)^solve simultaneous impact: .*{text}"):
        solve_simultaneous_impact(*arguments)


def test_bilateral_contact_and_load_are_checked_too():
    with pytest.raises(
        InputError, match=r"v_n1: got -1.0 m/s, need 0: the contact holds both ways"
    ):
        solve_simultaneous_impact(EYE, [0.5, 0.5], FALL, bilateral=[True, False])
    for wrong in ([True], [True, False, False]):
        with pytest.raises(InputError, match="check the shapes"):
            solve_simultaneous_impact(EYE, [0.5, 0.5], FALL, bilateral=wrong)
    for load in (np.zeros(3), [math.nan] * 4):
        with pytest.raises(InputError, match="load: got"):
            solve_simultaneous_impact(EYE, [0.5, 0.5], FALL, load=load)
