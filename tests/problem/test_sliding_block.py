"""A rigid block on two sliding feet: closed conditions against the enumeration.

Mass m, inertia J about the centre, feet at (-b, -h) and (b, -h) of it, both sliding with friction
mu. docs/complementarity.md derives every formula asserted here.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from painleve_sym.problem.complementarity import Uniqueness, is_p_matrix
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.modes import ContactMode

G = 9.8
JAM = (ContactMode.LIFTOFF, ContactMode.SLIP_POS)


def block(m, J, b, h, mu, slip_velocity=1.0, free=(-G, -G)):
    """Return the contact problem from J M^-1 J', with normal accelerations `free` of the feet."""
    rows = np.array([row for x in (-b, b) for row in ([0.0, 1.0, x], [1.0, 0.0, h])])
    W = rows @ np.diag([1 / m, 1 / m, 1 / J]) @ rows.T
    return ContactProblem(W, [free[0], 0.0, free[1], 0.0], [mu, mu], [slip_velocity] * 2)


def critical_friction(m, J, b, h):
    return (J / m + b**2) / (b * h)


lengths = st.floats(0.1, 10.0)
blocks = st.tuples(lengths, lengths, lengths, lengths)


@given(blocks, st.floats(0.0, 20.0))
def test_matrix_has_the_closed_form(data, mu):
    m, J, b, h = data
    A = block(m, J, b, h, mu).lcp().matrix
    x = np.array([-b, b])
    assert np.allclose(A, 1 / m + np.outer(x, x - mu * h) / J, rtol=1e-9, atol=1e-12)
    assert np.linalg.det(A) == pytest.approx(4 * b**2 / (m * J), rel=1e-6)


@given(blocks, st.floats(0.01, 0.99), st.booleans(), st.sampled_from([-1.0, 1.0]))
def test_matrix_is_p_exactly_below_the_critical_friction(data, ratio, above, slip_velocity):
    factor = 1 / ratio if above else ratio
    problem = block(*data, factor * critical_friction(*data), slip_velocity)
    assert is_p_matrix(problem.lcp().matrix) is not above
    assert (problem.uniqueness() is Uniqueness.UNIQUE_FOR_ALL) is not above


@given(blocks, st.floats(0.0, 0.99))
def test_both_feet_carry_the_weight_below_the_tipping_friction(data, ratio):
    m, J, b, h = data
    mu = ratio * b / h
    (solution,) = block(m, J, b, h, mu).solutions()
    load = m * G / 2
    assert solution.modes == (ContactMode.SLIP_POS, ContactMode.SLIP_POS)
    assert solution.normal_forces == pytest.approx(
        [load * (1 - mu * h / b), load * (1 + mu * h / b)], rel=1e-6
    )


@given(blocks, st.floats(0.02, 0.98))
def test_the_block_tips_over_its_leading_foot_between_the_two_frictions(data, part):
    m, J, b, h = data
    tipping, critical = b / h, critical_friction(m, J, b, h)
    mu = tipping + part * (critical - tipping)
    (solution,) = block(m, J, b, h, mu).solutions()
    assert solution.modes == JAM
    A_lead = 1 / m + b * (b - mu * h) / J
    assert solution.normal_forces[1] == pytest.approx(G / A_lead, rel=1e-5)
    assert solution.normal_accelerations[0] == pytest.approx(
        2 * G * b * (mu * h - b) / (J * A_lead), rel=1e-5
    )


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_existence_is_lost_at_the_critical_friction(gap):
    data = 2.0, 1.5, 0.4, 0.9
    limit = critical_friction(*data)
    (below,) = block(*data, limit * (1 - gap)).solutions()
    assert below.normal_forces[1] > 0.1 / gap  # the force grows without bound
    assert block(*data, limit * (1 + gap)).solutions() == ()


def test_nothing_is_consistent_at_the_critical_friction_itself():
    # m = J = b = h = 1: the limit is 2, and A of the leading foot exactly 0.
    problem = block(1.0, 1.0, 1.0, 1.0, 2.0)
    assert problem.lcp().matrix[1, 1] == 0.0
    assert problem.solutions() == ()
    assert problem.uniqueness() is Uniqueness.NOT_GUARANTEED


def test_uniqueness_is_lost_at_the_critical_friction_for_a_lifted_block():
    data, free = (2.0, 1.5, 0.4, 0.9), (0.5, 0.5)
    limit = critical_friction(*data)
    (floating,) = block(*data, limit * (1 - 1e-6), free=free).solutions()
    assert not floating.normal_forces.any()
    floating, jammed = block(*data, limit * (1 + 1e-6), free=free).solutions()
    assert not floating.normal_forces.any()
    assert jammed.modes == JAM


@given(blocks, st.floats(0.02, 0.9), st.floats(-10, 10), st.sampled_from([-1.0, 1.0]))
def test_above_the_limit_there_are_two_solutions_or_none(data, ratio, behind, ahead):
    # Two where the leading foot would lift (b_2 > 0) and b_1 > A_12 b_2 / A_22, else none.
    problem = block(*data, critical_friction(*data) / ratio, free=(behind, ahead))
    A = problem.lcp().matrix
    bound = A[0, 1] * ahead / A[1, 1]
    borders = (behind, behind - bound, ahead - A[1, 0] * behind / A[0, 0])
    if min(map(abs, borders)) < 1e-6:
        return  # two answers meet there
    solutions = problem.solutions()
    assert len(solutions) == (2 if ahead > 0 and behind > bound else 0)
    if solutions:
        (jam,) = (s for s in solutions if s.modes == JAM)
        assert jam.normal_forces[1] == pytest.approx(-ahead / A[1, 1])


@given(blocks, st.floats(0.0, 5.0), st.floats(-10, 10), st.floats(-10, 10))
def test_reversing_the_slip_exchanges_the_feet(data, mu, first, second):
    right = block(*data, mu, 1.0, (first, second)).solutions()
    left = block(*data, mu, -1.0, (second, first)).solutions()
    assert len(right) == len(left)
    mirrored = sorted(tuple(s.normal_forces[::-1]) for s in left)
    for s, forces in zip(right, mirrored, strict=True):
        assert tuple(s.normal_forces) == pytest.approx(forces, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("ratio", [0.3, 0.5, 1.0])
def test_a_homogeneous_block_has_the_critical_friction_of_a_rod(ratio):
    # Half width b, half height h, J/m = (b² + h²)/3: smallest limit 4/3, at b/h = 1/2.
    b, h = ratio, 1.0
    limit = critical_friction(1.0, (b**2 + h**2) / 3, b, h)
    tan = h / b
    assert limit == pytest.approx((4 + tan**2) / (3 * tan))
    assert limit >= 4 / 3 - 1e-12


@given(blocks, st.floats(0.1, 0.9), st.floats(0.1, 10.0))
def test_above_the_limit_the_two_solutions_merge_on_the_border(data, ratio, load):
    mu = critical_friction(*data) / ratio
    A = block(*data, mu).lcp().matrix
    for free in ((load, 0.0), (0.0, 0.0)):
        (floating,) = block(*data, mu, free=free).solutions()
        assert not floating.normal_forces.any()
    # A power of two keeps the border b_1 A_22 = A_12 b_2 to the last digit of A_12/A_22.
    on_border = (A[0, 1] / A[1, 1], 1.0)
    (jam,) = block(*data, mu, free=on_border).solutions()
    assert jam.normal_forces == pytest.approx([0.0, -1 / A[1, 1]], abs=1e-9)
    assert block(*data, mu, free=(load, -load)).solutions() == ()
    assert block(*data, mu, free=(-load, 0.0)).solutions() == ()


def test_at_the_critical_friction_a_load_without_its_leading_foot_leaves_a_ray():
    # m = J = b = h = 1: the limit is 2, and A of the leading foot exactly 0.
    solutions = block(1.0, 1.0, 1.0, 1.0, 2.0, free=(1.0, 0.0)).solutions()
    assert solutions and not any(solution.isolated for solution in solutions)
