"""Impacts of several contacts at once, against one contact, known results and the energy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.contacts.impact.one_contact import solve_impact
from painleve_sym.contacts.impact.simultaneous import frictional_impulses, solve_simultaneous_impact
from painleve_sym.errors import InputError
from painleve_sym.laws.restitution import RESTITUTIONS

entries = st.floats(-2, 2, allow_subnormal=False)
unit = st.floats(0, 1)


def mobility(rows: np.ndarray, masses: np.ndarray) -> np.ndarray:
    return rows @ np.diag(1 / masses) @ rows.T


def block_rows(a: float, h: float) -> np.ndarray:
    """Rows n1, t1, n2, t2 of two feet at ∓a, h below the centre; coordinates x, y, θ."""
    return np.array([row for x in (-a, a) for row in ([0, 1, x], [1, 0, h])], dtype=float)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(entries, min_size=8, max_size=8),
    st.lists(entries, min_size=2, max_size=2),
    st.lists(unit, min_size=2, max_size=2),
    unit,
    st.sampled_from(sorted(RESTITUTIONS)),
)
def test_answers_obey_the_law_and_the_energy(jacobian, slips, approach, e, law):
    J = np.array(jacobian).reshape(4, 2)
    W = J @ J.T + 0.3 * np.eye(4)
    velocity = np.array([-approach[0] - 0.1, slips[0], -approach[1], slips[1]])
    mu = np.array([0.4, 0.9])
    found = solve_simultaneous_impact(W, mu, velocity, law, e)
    assert found is not None  # W is positive definite
    np.testing.assert_allclose(found.velocities, velocity + W @ found.impulses, atol=1e-9)
    normal, tangential = found.impulses[::2], found.impulses[1::2]
    assert np.all(normal >= -1e-8) and np.all(found.velocities[::2] >= -1e-8)
    assert np.all(np.abs(tangential) <= mu * normal + 1e-8)
    # The change of kinetic energy by both ways: works along the phases, and the velocities.
    kinetic = found.velocities @ np.linalg.solve(W, found.velocities)
    before = velocity @ np.linalg.solve(W, velocity)
    change = (kinetic - before) / 2
    assert found.normal_work + found.tangential_work == pytest.approx(change, abs=1e-8)
    if law == "energetic":
        assert found.normal_work <= 1e-9


@settings(max_examples=60, deadline=None)
@given(st.floats(0.2, 2), st.floats(0.2, 2), st.floats(-0.9, 0.9), entries, unit, unit)
def test_one_contact_that_sticks_at_once_follows_routh(W_tt, W_nn, skew, v_t, mu, e):
    """From v_t = 0 the phases are single rays, and the two constructions are one."""
    W_nt = skew * math.sqrt(W_tt * W_nn)
    W = np.array([[W_nn, W_nt], [W_nt, W_tt]])
    for law in RESTITUTIONS:
        routh = solve_impact([[W_tt, W_nt], [W_nt, W_nn]], mu, (0.0, -1.0), law, e)
        found = solve_simultaneous_impact(W, np.array([mu]), np.array([-1.0, 0.0]), law, e)
        assert found is not None
        v_t_after, v_n_after = routh.velocity
        np.testing.assert_allclose(found.velocities, [v_n_after, v_t_after], atol=1e-8)


def test_symmetric_drop_without_friction_returns_with_e():
    W = mobility(block_rows(0.1, 0.3), np.array([2.0, 2.0, 0.05]))
    for law in RESTITUTIONS:
        found = solve_simultaneous_impact(W, np.zeros(2), np.array([-1.0, 0, -1.0, 0]), law, 0.6)
        assert found is not None
        np.testing.assert_allclose(found.velocities[::2], [0.6, 0.6], atol=1e-12)
        np.testing.assert_allclose(found.impulses, [1.6, 0, 1.6, 0], atol=1e-12)


def test_plastic_landing_on_both_feet_stops_the_block():
    """Four impulses, three freedoms: the motion is one although the forces are not."""
    W = mobility(block_rows(0.1, 0.3), np.array([2.0, 2.0, 0.05]))
    velocity = np.array([-1.0, 0.2, -1.0, 0.2])
    found = solve_simultaneous_impact(W, np.array([0.8, 0.8]), velocity, "poisson", 0.0)
    assert found is not None
    np.testing.assert_allclose(found.velocities, 0, atol=1e-12)
    assert found.impulses[::2].sum() == pytest.approx(2.0)


def test_newtons_cradle_of_two_feet_keeps_energy_at_most():
    """Energetic: e² of the normal work of compression comes back, over both contacts."""
    W = mobility(block_rows(0.15, 0.1), np.array([1.0, 1.0, 0.02]))
    velocity = np.array([-1.0, 0.5, -0.2, 0.5])
    mu = np.array([0.3, 0.3])
    first = frictional_impulses(W, mu, velocity, np.zeros(2))[0]
    between = velocity + W @ first
    taken = np.sum(first[::2] * (velocity[::2] + between[::2])) / 2
    found = solve_simultaneous_impact(W, mu, velocity, "energetic", 0.7)
    assert found is not None
    assert found.normal_work == pytest.approx((1 - 0.49) * taken, rel=1e-10)


def test_impact_without_collision_brings_a_sliding_contact_to_rest():
    """The rod of the paper at theta = 1, mu = 1.5 in (n, t) order: A < 0, so slip must stop."""
    W = np.array([[2.6, 1.9], [1.9, 1.6]])
    assert W[0, 0] - 1.5 * W[0, 1] < 0
    found = solve_simultaneous_impact(W, np.array([1.5]), np.array([0.0, 1.0]), "poisson", 0.0)
    routh = solve_impact([[1.6, 1.9], [1.9, 2.6]], 1.5, (1.0, 0.0), "poisson", 0.0)
    assert found is not None
    np.testing.assert_allclose(found.velocities, 0, atol=1e-12)
    np.testing.assert_allclose(found.velocities[::-1], routh.velocity, atol=1e-12)


def test_an_unknown_law_is_named():
    with pytest.raises(InputError, match="unknown restitution law 'stronge'"):
        solve_simultaneous_impact(np.eye(2), np.ones(1), np.array([-1.0, 0]), "stronge")
