"""Friction with given normal forces: the law, one motion, SciPy, scaling, and two feet by hand."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog, lsq_linear

from painleve_sym.contacts.friction import friction_forces
from painleve_sym.contacts.local_mode import ContactMode
from painleve_sym.errors import InputError
from tests.contacts.friction_oracle import SWAPPED

LIFT, RIGHT, LEFT, STICK = (
    ContactMode.LIFTOFF,
    ContactMode.SLIP_POS,
    ContactMode.SLIP_NEG,
    ContactMode.STICK,
)
integers = st.integers(-3, 3)
quarters = st.integers(0, 8).map(lambda k: k / 4)


@st.composite
def bodies(draw, slip=(-1, 0, 0, 0, 1)):
    """Draw rows J of n contacts on unit masses, free accelerations, forces, friction and slip.

    W = J J' with fewer degrees of freedom than forces: hyperstatic contacts are frequent.
    """
    n = draw(st.integers(1, 3))
    dof = draw(st.integers(1, 2 * n))
    J = np.array(draw(st.lists(_list(integers, dof), min_size=2 * n, max_size=2 * n)), float)
    free = np.array(draw(_list(st.integers(-8, 8), dof)), float) / 4
    normal, mu = (np.array(draw(_list(quarters, n))) for _ in range(2))
    return J, free, normal, mu, np.array(draw(_list(st.sampled_from(slip), n)), float)


def _list(entries, size):
    return st.lists(entries, min_size=size, max_size=size)


def solved(body, normal_unit=1.0):
    J, free, normal, mu, slip = body
    return friction_forces(J @ J.T, J @ free, normal_unit * normal, mu, slip)


def motion(body, solution):
    """Return the accelerations of the masses."""
    J, free, *_ = body
    return free + J.T @ solution.forces


# --- by hand ----------------------------------------------------------------------------------


def foot(push, mu=0.5, slip=0.0):
    return friction_forces(np.eye(2), [0.0, push], [2.0], mu, slip)


@pytest.mark.parametrize(
    ("push", "slip", "mode", "force", "rate"),
    [
        (0.4, 0.0, STICK, -0.4, 0.0),
        (1.0, 0.0, STICK, -1.0, 0.0),  # the edge of the cone
        (3.0, 0.0, RIGHT, -1.0, 2.0),
        (-3.0, 0.0, LEFT, 1.0, -2.0),
        (0.4, 1.0, RIGHT, -1.0, -0.6),
        (0.4, -1.0, LEFT, 1.0, 1.4),
    ],
)
def test_one_contact_obeys_the_law_by_hand(push, slip, mode, force, rate):
    friction = foot(push, slip=slip)
    assert friction.mode is mode and friction.isolated
    assert friction.tangential_force == pytest.approx(force)
    assert friction.tangential_acceleration == pytest.approx(rate)
    assert friction.normal_acceleration == 2.0


def test_two_feet_of_one_body_share_friction_with_the_least_norm():
    # Only the sum of both forces moves the body (mass 1): -0.8 - 0.8 balances the push of 1.6.
    W = np.array([[1.0, 0, 1, 0], [0, 1, 0, 1], [1, 0, 1, 0], [0, 1, 0, 1]])
    friction = friction_forces(W, [0, 1.6, 0, 1.6], [2.0, 4.0], [1.0, 1.0], [0.0, 0.0])
    assert friction.modes == (STICK, STICK) and not friction.isolated
    assert friction.tangential_forces == pytest.approx([-0.8, -0.8])
    # The first foot reaches its limit, the second takes the rest, and nothing is left open beyond.
    friction = friction_forces(W, [0, 4.0, 0, 4.0], [1.0, 4.0], [1.0, 1.0], [0.0, 0.0])
    assert friction.modes == (STICK, STICK) and not friction.isolated
    assert friction.tangential_forces == pytest.approx([-1.0, -3.0])
    friction = friction_forces(W, [0, 6.0, 0, 6.0], [1.0, 4.0], [1.0, 1.0], [0.0, 0.0])
    assert friction.modes == (RIGHT, RIGHT) and friction.isolated
    assert friction.tangential_forces.tolist() == [-1.0, -4.0]


def test_open_contact_has_no_friction():
    friction = friction_forces(np.eye(4), [1, 1, 1, 1], [0.0, 1.0], [1.0, 0.0], [0.0, 0.0])
    assert friction.modes == (LIFT, RIGHT)
    assert friction.tangential_forces.tolist() == [0.0, 0.0]
    assert friction.accelerations.tolist() == [1.0, 1.0, 2.0, 1.0]


def test_guide_that_pulls_has_friction_of_the_size_of_its_force():
    friction = friction_forces(np.eye(2), [0.0, 3.0], [-2.0], 0.5, 0.0)
    assert friction.mode is RIGHT and friction.tangential_force == -1.0


# --- properties -------------------------------------------------------------------------------


@settings(max_examples=200, deadline=None)
@given(bodies())
def test_friction_obeys_coulombs_law(body):
    J, free, normal, mu, slip = body
    friction = solved(body)
    assert friction.residual <= 1e-12
    acceleration = J @ J.T @ friction.forces + J @ free
    assert np.allclose(acceleration, friction.accelerations, atol=1e-11)
    for i, mode in enumerate(friction.modes):
        force, rate = friction.tangential_forces[i], friction.tangential_accelerations[i]
        limit = mu[i] * normal[i]
        assert abs(force) <= limit
        assert (mode is LIFT) == (normal[i] == 0)
        if slip[i] or rate:
            way = slip[i] or rate
            assert force == -math.copysign(limit, way) if limit else force == 0
            assert mode in (LIFT, RIGHT if way > 0 else LEFT)
        else:
            assert mode in (LIFT, STICK)


@settings(max_examples=150, deadline=None)
@given(bodies())
def test_motion_is_that_of_scipys_bounded_least_squares(body):
    J, free, normal, mu, slip = body
    friction = solved(body)
    limit = mu * normal
    resting = np.flatnonzero((slip == 0) & (limit > 0))
    forces = np.column_stack([normal, -slip * limit]).ravel()
    pushed = free + J.T @ forces
    if resting.size:
        columns = J[2 * resting + 1].T
        bound = limit[resting]
        # |free + J' F|² is twice the convex function, up to a constant.
        best = lsq_linear(columns, -pushed, (-bound, bound), method="bvls", tol=1e-15)
        pushed = pushed + columns @ best.x
    assert np.allclose(motion(body, friction), pushed, atol=1e-9)


@settings(max_examples=150, deadline=None)
@given(bodies(slip=(0,)), st.data())
def test_no_other_forces_in_the_box_do_better_or_move_otherwise(body, data):
    J, free, normal, mu, _ = body
    friction, limit = solved(body), mu * normal
    weights = np.array(data.draw(_list(st.floats(-1, 1), len(mu))))
    value = [
        np.sum((free + J.T @ np.column_stack([normal, F]).ravel()) ** 2)
        for F in (friction.tangential_forces, weights * limit)
    ]
    assert value[0] <= value[1] + 1e-11 * (1 + value[1])
    assert friction.isolated == (_reach(J[1::2].T, friction, limit) <= 1e-9)


def _reach(rest, friction, limit):
    """Return how far forces without effect lead away from the answer, by linear programs."""
    room = []
    for F, bound, rate in zip(
        friction.tangential_forces, limit, friction.accelerations[1::2], strict=True
    ):
        room.append((-bound - F, bound - F) if rate == 0 else (0.0, 0.0))
    goals = np.vstack([np.eye(len(limit)), -np.eye(len(limit))])
    ends = [linprog(g, A_eq=rest, b_eq=np.zeros(len(rest)), bounds=room) for g in goals]
    return max(-end.fun for end in ends)


@settings(max_examples=100, deadline=None)
@given(bodies(), st.lists(st.floats(-6, 6), min_size=3, max_size=3), st.integers(-12, 6))
def test_friction_scales_with_the_units_of_mass_length_and_time(body, powers, decades):
    J, free, normal, mu, slip = body
    mu = mu * 10.0**decades
    mass, length, time = (10.0**p for p in powers)
    unit = mass * length / time**2
    W, b = J @ J.T, J @ free
    first = friction_forces(W, b, normal, mu, slip)
    other = friction_forces(W / mass, b * length / time**2, unit * normal, mu, slip)
    assert first.modes == other.modes and first.isolated == other.isolated
    size = 1e-9 * np.max(mu * normal)
    assert np.allclose(unit * first.tangential_forces, other.tangential_forces, atol=unit * size)


@settings(max_examples=100, deadline=None)
@given(bodies())
def test_friction_of_the_mirror_image_points_the_other_way(body):
    J, free, normal, mu, slip = body
    signs = np.tile([1.0, -1.0], len(mu))[:, None]
    first, other = solved(body), solved((signs * J, free, normal, mu, -slip))
    assert [SWAPPED[m] for m in first.modes] == list(other.modes)
    assert np.allclose(first.tangential_forces, -other.tangential_forces, atol=1e-12)


@settings(max_examples=100, deadline=None)
@given(bodies(), st.floats(-1e-6, 1e-6))
def test_motion_depends_continuously_on_the_loads(body, change):
    J, free, normal, mu, slip = body
    near = solved((J, free + change, normal, mu, slip))
    first = motion(body, solved(body))
    second = motion((J, free + change, normal, mu, slip), near)
    # A projection: the distance does not grow.
    assert np.linalg.norm(first - second) <= abs(change) * math.sqrt(len(free)) + 1e-11


# --- validation -------------------------------------------------------------------------------


@pytest.mark.parametrize("normal", [[1.0], [math.nan, 1.0], [1.0, 2.0, 3.0]])
def test_friction_forces_refuse_normal_forces_that_do_not_fit(normal):
    with pytest.raises(InputError, match=r"normal_forces: got .*need 2 finite numbers. Fix: "):
        friction_forces(np.eye(4), np.zeros(4), normal, [1, 1], [0, 0])


def test_friction_forces_refuse_more_contacts_than_can_be_tried():
    with pytest.raises(InputError, match="got 7 contacts at rest"):
        friction_forces(np.eye(14), np.zeros(14), np.ones(7), np.ones(7), np.zeros(7))
