"""Impacts beside guides: guides without friction, pairs of opposite contacts, stops at once."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.engines.impacts import solve_simultaneous_impact
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.problem.impact.one_contact import ImpactEnd
from tests.support.rigid_impacts import body_rows, energy, mobility, unit

LAW = st.sampled_from(sorted(RESTITUTIONS))


def guided_impact(rng, mu_guide):
    """Return W, μ, v of two bodies: the first contact guides one, the others hit with another."""
    points = [tuple(rng.uniform(-1, 1, 2)) for _ in range(3)]
    J = body_rows(points, [bool(rng.random() < 0.5) for _ in points])
    # A second body takes part in the velocity of every contact: W is definite.
    more = rng.normal(size=(6, 3)) * 0.7
    rows = np.hstack([J, more])
    W = mobility(rows, 10 ** rng.uniform(-0.5, 0.5, 6))
    mu = np.array([mu_guide, *10 ** rng.uniform(-2, 0.3, 2)])
    while True:
        v = rows @ rng.normal(size=6)
        if np.all(v[[2, 4]] < 0):
            break
    v[0] = 0.0
    return W, mu, v


def guided(W, mu, v, law, e):
    return solve_simultaneous_impact(W, mu, v, law, e, bilateral=np.arange(len(mu)) == 0)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), unit, LAW)
def test_guide_without_friction_is_a_constraint(seed, e, law):
    """The impact is that of the other contacts with the mobility the guide leaves them."""
    W, mu, v = guided_impact(np.random.default_rng(seed), 0.0)
    impact = guided(W, mu, v, law, e)
    rest = slice(2, None)
    left = W[rest, rest] - np.outer(W[rest, 0], W[0, rest]) / W[0, 0]
    wanted = solve_simultaneous_impact((left + left.T) / 2, mu[1:], v[rest], law, e)
    assert impact.end is wanted.end
    assert impact.velocities[0] == 0
    size = 1 + np.max(np.abs(v)) + np.max(np.abs(W) @ np.abs(impact.impulses))
    np.testing.assert_allclose(impact.velocities[rest], wanted.velocities, atol=1e-10 * size)
    np.testing.assert_allclose(impact.impulses[rest], wanted.impulses, rtol=1e-7, atol=1e-10 * size)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.floats(0.01, 2), unit, LAW)
def test_guide_keeps_its_velocity_and_its_friction_opposes_the_slip(seed, mu_guide, e, law):
    W, mu, v = guided_impact(np.random.default_rng(seed), mu_guide)
    impact = guided(W, mu, v, law, e)
    size = np.max(np.abs(v)) + np.max(np.abs(W) @ np.abs(impact.impulses))
    assert np.max(np.abs(v + W @ impact.impulses - impact.velocities)) <= 1e-9 * size
    assert impact.velocities[0] == 0
    if impact.end is not ImpactEnd.JAM:
        assert np.all(impact.velocities[::2] >= 0)
    for piece in impact.pieces:
        normal, tangential = np.abs(piece.impulses[::2]), piece.impulses[1::2]
        assert np.all(piece.impulses[2::2] >= 0)
        assert np.all(np.abs(tangential) <= mu * normal + 1e-8 * normal.max())
        assert abs(piece.works[0]) <= 1e-9 * size * normal.max()
        # What stops at once has friction against the slip after it: all loses energy, one may gain.
        losses = piece.works[1::2], piece.works.sum()
        if law != "newton":
            assert any(np.all(part <= 1e-9 * size * normal.max()) for part in losses)
    if law != "newton":
        change = impact.normal_work + impact.tangential_work
        before = energy(W, v)
        assert change <= 1e-9 * before
        assert energy(W, impact.velocities) - before == pytest.approx(change, abs=1e-8 * before)


def test_guide_with_friction_is_a_pair_of_opposite_contacts():
    """A slot is a floor and a ceiling without play: of both only one has a force."""
    rng, compared = np.random.default_rng(3), 0
    for _ in range(150):
        W, mu, v = guided_impact(rng, float(10 ** rng.uniform(-2, -0.3)))
        law, e = str(rng.choice(["energetic", "poisson"])), float(rng.uniform())
        impact = guided(W, mu, v, law, e)
        turn = np.diag([-1.0, 1.0])
        twice = np.vstack([np.eye(6), np.hstack([turn, np.zeros((2, 4))])])
        pair = solve_simultaneous_impact(
            twice @ W @ twice.T, np.append(mu, mu[0]), twice @ v, law, e
        )
        # A contact that opens pushes at most as hard as the hardest: a harder guide has no pair.
        hardest = [max(p.impulses[[0, 6]]) < 0.99 * max(p.impulses[[2, 4]]) for p in pair.pieces]
        if not all(hardest) or pair.end is ImpactEnd.JAM:
            continue
        compared += 1
        size = np.max(np.abs(v)) + np.max(np.abs(W) @ np.abs(impact.impulses))
        np.testing.assert_allclose(pair.velocities[:6], impact.velocities, atol=1e-8 * size)
    assert compared > 50


def test_guide_that_finds_no_force_stops_at_once():
    """One guide: P of the two equations v_n = v_t = 0, where it lies within the friction cone."""
    W = np.array([[1.0, 2.0], [2.0, 5.0]])
    still = np.linalg.solve(W, [0.0, -3.0])
    steep = abs(still[1] / still[0])
    none = {"load": np.zeros(2), "bilateral": np.array([True])}
    impact = solve_simultaneous_impact(W, np.array([1.1 * steep]), np.array([0.0, 3.0]), **none)
    np.testing.assert_allclose(impact.impulses, still, rtol=1e-12)
    assert impact.end is ImpactEnd.PERSISTENT
    assert np.all(impact.velocities == 0)
    assert impact.tangential_work == pytest.approx(1.5 * still[1], rel=1e-12)
    slips = solve_simultaneous_impact(W, np.array([0.9 * steep]), np.array([0.0, 3.0]), **none)
    assert slips.end is ImpactEnd.JAM
    assert np.all(slips.velocities == [0.0, 3.0])
