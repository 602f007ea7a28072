"""Properties of impacts by the final slip: law, answers, energy; and the path beside it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from painleve_sym.engines.impacts import solve_simultaneous_impact
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.problem.impact.one_contact import ImpactEnd, solve_impact
from tests.properties.test_impact_properties import (
    FRICTION,
    MOBILITY,
    NORMAL,
    RESTITUTION,
    SLIP,
    paradoxes,
)
from tests.support import moreau

REVERSED = (ImpactClass.C_REVERSED, ImpactClass.R_REVERSED)


def final(W, mu, velocity, e):
    return solve_impact(W, mu, velocity, "newton", e, impact_friction="final_slip")


def size(W, velocity, impact):
    """Return what rounding of velocities is relative to."""
    given = np.max(np.abs(velocity))
    return 1e-12 * (given + np.max(np.abs(W)) * np.max(np.abs(impact.impulse), initial=0.0))


@given(W=MOBILITY, mu=FRICTION, v_t=SLIP, v_n=st.floats(-5.0, -0.01), e=RESTITUTION)
def test_the_final_slip_obeys_newton_and_coulomb_and_is_the_only_one(W, mu, v_t, v_n, e):
    impact, v = final(W, mu, (v_n, v_t), e), np.array([v_n, v_t])
    (P_n, P_t), after = impact.impulse, np.array(impact.velocity)
    near = size(W, v, impact)
    assert np.abs(v + np.array(W) @ impact.impulse - after).max() <= near
    assert after[0] == -e * v_n + 0.0 and impact.is_unique and len(impact.phases) == 1
    if impact.case is ImpactClass.STICKING:
        assert after[1] == 0 and abs(P_t) <= mu * P_n * (1 + 1e-9)
    else:
        assert P_t == pytest.approx(-mu * P_n * math.copysign(1, after[1]), abs=1e-12 * P_n)
        assert (impact.case is ImpactClass.REVERSED) == (after[1] * v_t < 0)
    # Every choice of a mode, solved by least squares.
    assert np.allclose(
        moreau.impulses(np.array(W), v * [1 + e, 1], [mu]), impact.impulse, rtol=1e-7, atol=1e-9
    )


@given(W=MOBILITY, mu=FRICTION, v_t=SLIP, v_n=NORMAL, e=RESTITUTION)
def test_both_readings_agree_unless_the_slip_turns_round(W, mu, v_t, v_n, e):
    path = solve_impact(W, mu, (v_n, v_t), "newton", e)
    other = final(W, mu, (v_n, v_t), e)
    assert (path.case is ImpactClass.NO_IMPACT) == (other.case is ImpactClass.NO_IMPACT)
    assume(path.end is not ImpactEnd.JAM)
    near = 1e3 * size(W, (v_n, v_t), path)
    difference = np.abs(np.subtract(path.velocity, other.velocity)).max()
    if path.case not in REVERSED:
        assert difference <= near
    else:
        # Friction pushed first one way, then the other; at the end it is the way it ends.
        turned = [abs(p.tangential_impulse[0]) for p in path.phases]
        assert difference > near or min(turned[0], sum(turned[1:])) <= near or mu == 0


@given(W=MOBILITY, mu=FRICTION, v_t=SLIP, v_n=st.floats(-5.0, -0.01), e=RESTITUTION)
def test_energy_grows_only_where_friction_pushed_along_the_slip_before(W, mu, v_t, v_n, e):
    impact = final(W, mu, (v_n, v_t), e)
    (P_n, P_t), after = impact.impulse, impact.velocity
    by_formula = (P_t * (v_t + after[1]) - (1 - e) * P_n * -v_n) / 2
    scale = P_n * -v_n + abs(P_t) * (abs(v_t) + abs(after[1]))
    assert abs(impact.energy_change - by_formula) <= 1e-12 * scale
    if e == 0 or mu == 0 or impact.case is ImpactClass.SLIDING:
        assert impact.energy_change <= 1e-12 * scale
    if impact.energy_change > 1e-9 * scale:
        assert P_t * v_t > 0 and impact.notice


@given(W=MOBILITY, mu=FRICTION, v_t=SLIP, v_n=NORMAL, e=RESTITUTION)
def test_mirror_image_and_units_change_nothing(W, mu, v_t, v_n, e):
    (W_nn, W_nt), (_, W_tt) = W
    impact = final(W, mu, (v_n, v_t), e)
    mirror = final(((W_nn, -W_nt), (-W_nt, W_tt)), mu, (v_n, -v_t), e)
    assert mirror.velocity == pytest.approx((impact.velocity[0], -impact.velocity[1]))
    assert mirror.case is impact.case
    grams = final(np.array(W) / 1024, mu, (v_n * 512, v_t * 512), e)
    assert grams.velocity == tuple(512 * v for v in impact.velocity)
    assert grams.impulse == tuple(2.0**19 * P for P in impact.impulse)


@given(problem=paradoxes(), e=RESTITUTION)
def test_in_the_paradox_the_slip_stops_without_collision(problem, e):
    W, mu, slip = problem
    impact = final(W, mu, (0.0, slip), e)
    assert impact.case is ImpactClass.STICKING and impact.end is ImpactEnd.PERSISTENT
    assert impact.velocity == (0.0, 0.0)
    by_hand = -np.linalg.solve(W, [0.0, slip])
    assert impact.impulse == pytest.approx(tuple(by_hand), rel=1e-6)


@settings(max_examples=40)
@given(W=MOBILITY, mu=FRICTION, v_t=SLIP, v_n=NORMAL, e=RESTITUTION)
def test_one_contact_is_the_same_asked_as_several_and_in_space(W, mu, v_t, v_n, e):
    impact = final(W, mu, (v_n, v_t), e)
    if impact.case is not ImpactClass.NO_IMPACT:
        other = solve_simultaneous_impact(
            W, [mu], (v_n, v_t), "newton", e, impact_friction="final_slip"
        )
        near = 1e2 * size(W, (v_n, v_t), impact)
        assert np.abs(np.subtract(other.velocities, impact.velocity)).max() <= near
    (W_nn, W_nt), (_, W_tt) = W
    # A second tangent along which nothing couples: no force acts along it.
    space = [[W_nn, W_nt, 0.0], [W_nt, W_tt, 0.0], [0.0, 0.0, W_tt]]
    deep = final(space, mu, (v_n, v_t, 0.0), e)
    if v_n < 0 and deep.is_unique:
        assert deep.velocity == pytest.approx((*impact.velocity, 0.0), abs=1e-9)


@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), mu=FRICTION, e=RESTITUTION, turn=st.floats(0.0, 6.28))
def test_tangents_turned_in_space_turn_the_impact(seed, mu, e, turn):
    rng = np.random.default_rng(seed)
    A, v = rng.normal(size=(3, 3)), rng.normal(size=3)
    v[0] = -abs(v[0])
    W, R = A @ A.T + 0.05 * np.eye(3), np.eye(3)
    R[1:, 1:] = [[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]
    impact, turned = final(W, mu, v, e), final(R @ W @ R.T, mu, R @ v, e)
    assert turned.is_unique == impact.is_unique
    if impact.is_unique:
        assert R @ impact.velocity == pytest.approx(turned.velocity, abs=1e-7)
    P_n, *P_t = impact.impulse
    after = np.array(impact.velocity)
    assert math.hypot(*P_t) <= mu * P_n * (1 + 1e-9)
    slip = math.hypot(*after[1:])
    if slip > 1e-9:
        assert np.array(P_t) == pytest.approx(-mu * P_n * after[1:] / slip, abs=1e-7 * (1 + P_n))


def scene(seed):
    """Return W, μ, v of a body that hits floor and wall, of rank three."""
    rng = np.random.default_rng(seed)
    points, rows = rng.uniform(-1, 1, (2, 2)), []
    for (x, y), wall in zip(points, rng.random(2) < 0.5, strict=True):
        along = np.array([1.0, 0.0, -y]), np.array([0.0, 1.0, x])
        rows += along if wall else along[::-1]
    J = np.array(rows)
    W = J @ np.diag(10 ** rng.uniform(-0.5, 0.5, 3)) @ J.T
    v = J @ rng.normal(size=3)
    v[::2] = -np.abs(v[::2])
    return W, 10 ** rng.uniform(-2, 0, 2), v, rng.uniform(size=2)


@settings(max_examples=80)
@given(seed=st.integers(0, 2**32 - 1))
def test_each_contact_has_its_own_coefficient_in_any_order(seed):
    W, mu, v, e = scene(seed)
    order, rows = [1, 0], [2, 3, 0, 1]
    for by in ("path", "final_slip"):
        impact = solve_simultaneous_impact(W, mu, v, "newton", e, impact_friction=by)
        swapped = solve_simultaneous_impact(
            W[np.ix_(rows, rows)], mu[order], v[rows], "newton", e[order], impact_friction=by
        )
        assert impact.end is swapped.end
        assume(impact.end is not ImpactEnd.JAM and impact.is_unique)
        near = 1e-9 * (np.max(np.abs(v)) + np.max(np.abs(W) @ np.abs(impact.impulses)))
        assert np.abs(impact.velocities[rows] - swapped.velocities).max() <= near
        # 0 ≤ P_n ⟂ v_n⁺ + e v_n⁻ ≥ 0 with the coefficient of each.
        rebound = impact.velocities[::2] + e * v[::2]
        assert np.all(rebound >= -near) and np.all(impact.impulses[::2] >= 0)
        pushed = impact.impulses[::2] > 1e-9 * np.max(impact.impulses)
        assert np.abs(rebound[pushed]).max(initial=0.0) <= near


@settings(max_examples=60)
@given(seed=st.integers(0, 2**32 - 1))
def test_without_restitution_no_impact_of_several_contacts_gains_energy(seed):
    W, mu, v, _ = scene(seed)
    impact = solve_simultaneous_impact(W, mu, v, "newton", 0.0, impact_friction="final_slip")
    assume(impact.end is not ImpactEnd.JAM)
    assert impact.energy_change <= 1e-12 * np.abs(impact.impulses) @ np.abs(v)
    want = moreau.impulses(W, v, mu)
    if impact.is_unique:
        near = 1e-7 * np.max(np.abs(W) @ np.abs(impact.impulses))
        assert np.abs(W @ (want - impact.impulses)).max() <= near
