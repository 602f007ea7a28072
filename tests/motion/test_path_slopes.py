"""Derivatives of an impact of several contacts against differences of impacts beside it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from painleve_sym.engines.impacts import solve_simultaneous_impact
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.motion.sensitivity.path_slopes import ImpactData, impact_slopes, least_norm_slopes
from painleve_sym.problem.impact.one_contact import ImpactEnd

FINAL_SLIP = "newton by the final slip"
LAW = st.sampled_from([*sorted(RESTITUTIONS), FINAL_SLIP])
SEED = st.integers(0, 2**32 - 1)


def data(u, n, walls, held):
    """Return W, μ, v, e of a body (and a second one where `held`) at the numbers u."""
    places, masses, speeds = u[: 2 * n].reshape(n, 2), u[2 * n : 2 * n + 6], u[2 * n + 6 :]
    rows = []
    for (x, y), wall in zip(places, walls, strict=True):
        along = np.array([1, 0, -y]), np.array([0, 1, x])
        rows += along if wall else along[::-1]
    J = np.array(rows)
    # A second body, which shakes the ground, leaves W definite.
    shaken = np.hstack([J, np.vander(0.3 + 0.1 * np.arange(2 * n), 3) * held])
    W = shaken @ np.diag(1 / masses) @ shaken.T
    velocity = shaken @ speeds[:6]
    if held:
        velocity = velocity - np.eye(2 * n)[0] * velocity[0]
    return W, speeds[6 : 6 + n], velocity, speeds[6 + n :]


def scene(seed, n, held):
    """Return numbers at which all contacts hit, and which of them touch a wall."""
    rng = np.random.default_rng(seed)
    while True:
        walls = rng.random(n) < 0.4
        mu, e = 10 ** rng.uniform(-1.5, 0.3, n), rng.uniform(0.1, 0.95, n)
        body = [rng.uniform(-1, 1, 2 * n), 10 ** rng.uniform(-0.5, 0.5, 6), rng.normal(size=6)]
        u = np.concatenate([*body, mu, e])
        if np.all(data(u, n, walls, held)[2][2 * held :: 2] < 0):
            return u, walls, rng.normal(size=len(u))


def solved(u, n, walls, held, law):
    W, mu, v, e = data(u, n, walls, held)
    bilateral = np.arange(n) < held
    name, by = ("newton", "final_slip") if law == FINAL_SLIP else (law, "path")
    return solve_simultaneous_impact(W, mu, v, name, e, impact_friction=by, bilateral=bilateral)


def numbers(impact):
    return np.concatenate([impact.velocities, impact.impulses, impact.works])


def slopes(impact, W, mu, v, e, tolerance=1e-8):
    """Return the derivatives of `numbers` in one direction."""
    floor = np.max(np.abs(impact.velocities_before), keepdims=True)
    columns = W[..., None], mu[:, None], v[:, None], np.broadcast_to(e, mu.shape)[:, None]
    slopes = impact_slopes(impact.path, ImpactData(*columns, floor, tolerance))
    return np.concatenate([slopes.velocities, slopes.impulses, slopes.works])[:, 0]


def difference(at, step):
    """Return the central difference of a function at 0, extrapolated from two steps."""
    halves = [(at(h) - at(-h)) / (2 * h) for h in (step, step / 2)]
    return (4 * halves[1] - halves[0]) / 3


def compared(seed, n, held, law):
    """Compare the derivatives in a random direction where the impact is smooth about the scene."""
    u, walls, direction = scene(seed, n, held)
    impact = solved(u, n, walls, held, law)
    assume(impact.end is not ImpactEnd.JAM)
    # Complex steps have no rounding: the data are smooth.
    given_ = [np.imag(a) / 1e-30 for a in data(u + 1e-30j * direction, n, walls, held)]
    exact = slopes(impact, *given_)
    assert np.isfinite(exact).all()
    differences = [
        difference(lambda h: numbers(solved(u + h * direction, n, walls, held, law)), step)
        for step in (1e-4, 1e-5)
    ]
    size = np.max(np.abs(exact))
    assume(np.max(np.abs(differences[0] - differences[1])) < 1e-6 * size)
    nearest = min(np.max(np.abs(d - exact)) for d in differences)
    assert nearest < 1e-7 * size


@settings(max_examples=60)
@given(SEED, LAW)
def test_derivatives_of_two_contacts_of_one_body_are_differences(seed, law):
    compared(seed, 2, 0, law)


@settings(max_examples=15)
@given(SEED, LAW)
def test_derivatives_of_three_contacts_are_differences(seed, law):
    compared(seed, 3, 0, law)


@settings(max_examples=25)
@given(SEED, LAW)
def test_derivatives_beside_a_guide_are_differences(seed, law):
    compared(seed, 2, 1, law)


def block(mu, v, law="energetic", e=0.5):
    """Return the impact of a block on both feet with velocities (x, y, θ)."""
    J = np.array([[0, 1, -1], [1, 0, 0.5], [0, 1, 1], [1, 0, 0.5]], dtype=float)
    return solve_simultaneous_impact(J @ J.T, np.full(2, mu), J @ v, law, e), J


@pytest.mark.parametrize("law", sorted(RESTITUTIONS))
def test_a_path_turns_round_sticks_and_ends_in_every_way(law):
    """The scenes of the property test hold every kind of end of a piece."""
    kinds = set()
    for seed in range(60):
        u, walls, _ = scene(seed, 2, 0)
        steps = solved(u, 2, walls, 0, law).path.steps
        kinds |= {step.event.kind for step in steps if hasattr(step, "event")}
        reverses = [s.push[1] * s.velocities[1] for s in steps if hasattr(s, "event")]
        assert all(r <= 0 for r in reverses)
    wanted = {"energetic": {"border", "slip", "spent"}, "poisson": {"border", "slip", "spent"}}
    assert kinds >= wanted.get(law, set())


def test_feet_that_end_compression_together_keep_to_it():
    """A block falls flat; the weights of its feet let them stop together in every direction."""
    impact, J = block(0.0, np.array([0.0, -1.0, 0.0]))
    still = np.zeros((4, 4)), np.zeros(2)
    faster = slopes(impact, *still, J @ [0, -1.0, 0], 0.0)
    assert np.allclose(faster[:4], [0.5, 0, 0.5, 0], atol=1e-12)
    # Restitution of both at once: half the impulse of compression, here 0.5 each.
    assert np.allclose(faster[[4, 6]], 0.75, atol=1e-12)
    turned = slopes(impact, *still, J @ [0, 0, 1.0], 0.0)
    assert np.allclose(turned[[0, 2]], [0.5, -0.5], atol=1e-12)


def test_events_at_once_leave_derivatives_in_directions_that_keep_them_together():
    """The slip stops just when compression ends; a faster slip alone would part the two."""
    W, mu, v = np.array([[1, 0.25], [0.25, 1]]), np.array([0.5]), np.array([-0.875, 0.25])
    impact = solve_simultaneous_impact(W, mu, v, "poisson", 0.5)
    first = impact.path.steps[0]
    assert np.all(first.velocities_after == 0)
    still = np.zeros((2, 2)), np.zeros(1)
    together = slopes(impact, *still, v, 0.0)
    # The impact is homogeneous in the velocity: of degree 1, works of degree 2.
    assert np.allclose(together, numbers(impact) * [1, 1, 1, 1, 2, 2], atol=1e-12)
    assert np.isnan(slopes(impact, *still, np.array([0.0, 1.0]), 0.0)).all()


def test_slip_that_begins_at_zero_has_a_derivative_where_it_sticks():
    """A foot without slip sticks under much friction; a small slip to either side stops first."""
    J = np.array([[0, 1, 0.6], [1, 0, 0.3]])
    W, v = J @ J.T, J @ np.array([0.1, -1.0, -1 / 3])
    v[1] = 0.0
    moved = np.array([0.0, 1.0])

    def at(h, mu):
        return numbers(
            solve_simultaneous_impact(W, np.array([mu]), v + h * moved, "energetic", 0.6)
        )

    for mu, sticks in ((2.0, True), (0.05, False)):
        impact = solve_simultaneous_impact(W, np.array([mu]), v, "energetic", 0.6)
        exact = slopes(impact, np.zeros((2, 2)), np.zeros(1), moved, 0.0)
        assert np.isfinite(exact).all() == sticks
        left, right = (at(0, mu) - at(-1e-6, mu)) / 1e-6, (at(1e-6, mu) - at(0, mu)) / 1e-6
        assert np.allclose(left, right, atol=1e-5) == sticks
        if sticks:
            assert np.allclose(exact, right, atol=1e-5)


def of_rank(rank, size, seed):
    """Return matrices of a smooth family of constant rank, and right sides in their range."""
    rng = np.random.default_rng(seed)
    left, right, point = (rng.normal(size=s) for s in ((2, size, rank), (2, rank, size), (2, size)))

    def at(h):
        matrix = (left[0] + h * left[1]) @ (right[0] + h * right[1])
        return matrix, matrix @ (point[0] + h * point[1])

    matrix, vector = at(0.0)
    moved = left[1] @ right[0] + left[0] @ right[1]
    return at, matrix, moved, vector, moved @ point[0] + matrix @ point[1]


@pytest.mark.parametrize("rank", [1, 2, 3, 4])
def test_least_norm_of_open_forces_changes_with_its_matrix(rank):
    """Of NumPy's pseudo-inverse by differences; for rank 4 nothing is open."""
    at, matrix, moved, vector, right = of_rank(rank, 4, rank)
    x, change = least_norm_slopes(matrix, moved[..., None], vector, right[:, None])

    def solution(h):
        return np.linalg.pinv(at(h)[0], rcond=1e-10) @ at(h)[1]

    np.testing.assert_allclose(x, solution(0.0), atol=1e-12)
    np.testing.assert_allclose(change[:, 0], difference(solution, 1e-3), rtol=1e-7, atol=1e-8)
    # Across the range of the matrix lies what least norm alone decides.
    across = (np.eye(4) - np.linalg.pinv(matrix, rcond=1e-10) @ matrix) @ change[:, 0]
    assert (np.max(np.abs(across)) > 1e-3) == (rank < 4)


TANGENTS = np.array([[1.0, 0.2], [0.4, 1.0], [-0.5, 0.7]])
COUPLINGS = np.array([[0.3, -0.1], [0.2, 0.25], [-0.15, 0.3]])
SHIFTS = np.array([[0.3, 0.2], [-0.1, 0.4], [0.2, -0.3]])


def held_impact(h):
    """Return the impact of three contacts whose tangents share two freedoms, each normal a third.

    Their slips are 0 before, and friction of 5 holds them: three tangential impulses for two
    velocities, with a direction between them that moves with h.
    """
    J = np.zeros((6, 5))
    J[1::2, :2] = TANGENTS + h * SHIFTS
    J[::2, :2], J[::2, 2:] = COUPLINGS - h * SHIFTS, np.diag([1.0, 1.2, 0.9])
    v = J @ np.array([0.0, 0.0, -1.0, -0.7, -1.1])
    return solve_simultaneous_impact(J @ J.T, np.full(3, 5.0), v, "poisson", 0.4), (J @ J.T, v)


def test_friction_that_rigidity_leaves_open_has_the_derivative_of_its_least_norm():
    impact, (W, _) = held_impact(0.0)
    tangential = W[1::2, 1::2]
    assert np.linalg.matrix_rank(tangential, tol=1e-10) == 2
    assert [row % 2 for row in impact.path.steps[1].rows] == [1, 1, 1]
    moved = [difference(lambda h, k=k: held_impact(h)[1][k], 1e-3) for k in (0, 1)]
    exact = slopes(impact, moved[0], np.zeros(3), moved[1], 0.0)
    by_differences = difference(lambda h: numbers(held_impact(h)[0]), 1e-3)
    size = np.max(np.abs(by_differences))
    np.testing.assert_allclose(exact, by_differences, atol=1e-7 * size)
    # Along the direction that moves no contact lies what only the least norm decides.
    still = np.linalg.svd(tangential)[2][-1]
    assert abs(still @ exact[6:12][1::2]) > 1e-3 * size


def test_no_derivative_by_an_energetic_restitution_of_zero():
    impact, _ = block(0.3, np.array([0.5, -1.0, 0.2]), e=0.0)
    nothing = np.zeros((4, 4)), np.zeros(2), np.zeros(4)
    assert np.isnan(slopes(impact, *nothing, 1.0)).all()
    assert np.allclose(slopes(impact, *nothing, 0.0), 0)


def test_friction_of_zero_has_no_derivative_by_friction():
    impact, _ = block(0.0, np.array([0.5, -1.0, 0.2]))
    rubs = slopes(impact, np.zeros((4, 4)), np.ones(2), np.zeros(4), 0.0)
    assert np.isnan(rubs).all()
