"""The bilateral contact: closed counts, hand cases, mirrors and an oracle over the rationals."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from painleve_sym.errors import InputError
from painleve_sym.problem.complementarity.lcp import RESIDUAL_TOLERANCE
from painleve_sym.problem.complementarity.uniqueness import Uniqueness
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.modes import ContactMode
from tests.problem.friction_oracle import (
    LEFT,
    RIGHT,
    STICK,
    SWAPPED,
    contact_sets,
    same_sets,
)


def flat(data):
    """Return W_nn, W_nt, W_tt, b_n, b_t, mu, v of a drawn single contact."""
    W, b, mu, slip = data
    return (W[0][0], W[0][1], W[1][1], *b, *mu, Fraction(slip[0]))


def guided(*data, **named):
    return ContactProblem.single(*data, **named, bilateral=True)


def unique(problem):
    return problem.uniqueness() is Uniqueness.UNIQUE_FOR_ALL


def built(data):
    return guided(*map(float, data))


def pairs(solutions):
    return [(s.normal_force, s.tangential_force) for s in solutions]


def exact_solutions(W_nn, W_nt, W_tt, b_n, b_t, mu, v):
    """Return {(mode, F_n, F_t)} over the rationals, or None where a branch has many forces."""
    solutions = set()
    for s in (1, -1):
        for side in (1, -1):
            A = W_nn - mu * s * side * W_nt
            if v * s < 0:
                continue
            if A == 0:
                if b_n == 0:
                    return None
                continue
            F_n = -b_n / A
            F_t = -mu * s * abs(F_n)
            a_t = W_nt * F_n + W_tt * F_t + b_t
            if F_n * side >= 0 and (v != 0 or s * a_t > 0):
                solutions.add((RIGHT if s > 0 else LEFT, F_n, F_t))
    if v == 0:
        det = W_nn * W_tt - W_nt**2
        if det == 0:
            return None
        F_n = (W_nt * b_t - W_tt * b_n) / det
        F_t = (W_nt * b_n - W_nn * b_t) / det
        if abs(F_t) <= mu * abs(F_n):
            solutions.add((STICK, F_n, F_t))
    return solutions


def closed_count(W_nn, W_nt, b_n, mu, s):
    """Return the number of solutions while sliding, inf for a ray, as the module states it."""
    coupling = mu * abs(W_nt)
    if W_nn == 0:
        return math.inf if b_n == 0 else 0
    if coupling < W_nn:
        return 1
    towards = s * W_nt * b_n
    if coupling == W_nn:
        return math.inf if b_n == 0 else int(towards > 0)
    return 1 if b_n == 0 else 2 * int(towards > 0)


singles = contact_sets(sizes=st.just(1)).map(flat)
moving = contact_sets(sizes=st.just(1), slip=(-1, 1)).map(flat)
resting = contact_sets(sizes=st.just(1), slip=(0,), definite=True).map(flat)


# --- by hand ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("W_nt", "b_n", "v", "expected"),
    [
        (-0.5, -3.0, 1.0, [2.0]),  # A = 1.5 where F_n > 0
        (-0.5, 3.0, 1.0, [-6.0]),  # A = 0.5 where F_n < 0
        (0.0, 3.0, 1.0, [-3.0]),
        (-1.5, -1.0, 1.0, [-2.0, 0.4]),
        (-1.5, 1.0, -1.0, [-0.4, 2.0]),
        (-1.5, -1.0, -1.0, []),
        (-1.5, 0.0, -1.0, [0.0]),
        (-1.0, 1.0, -1.0, [-0.5]),  # A = 0 where F_n > 0
        (-1.0, -1.0, -1.0, []),
    ],
)
def test_solutions_are_those_by_hand_while_sliding(W_nt, b_n, v, expected):
    problem = guided(1.0, W_nt, 4.0, b_n, 0.0, 1.0, v)
    assert [s.normal_force for s in problem.solutions()] == pytest.approx(expected)
    assert all(s.isolated for s in problem.solutions())


def test_solutions_report_the_ray_on_the_border_without_load():
    solutions = guided(1.0, -1.0, 4.0, 0.0, 0.0, 1.0, -1.0).solutions()
    assert [s.normal_force > 0 for s in solutions] == [False, True]
    assert not any(s.isolated for s in solutions)


@pytest.mark.parametrize(
    ("b_t", "modes"),
    [
        (-10.0, [LEFT, LEFT, STICK]),
        (-3.0, [LEFT]),
        (-1.0, [STICK]),
        (3.0, [STICK]),
    ],
)
def test_solutions_at_rest_are_one_or_three_beyond_the_limit(b_t, modes):
    # mu |W_nt| = 1.5 > W_nn = 1; both slips go along the sign of W_nt b_n < 0.
    solutions = guided(1.0, -1.5, 4.0, 1.0, b_t, 1.0, 0.0).solutions()
    assert [s.mode for s in solutions] == modes
    assert all(s.isolated for s in solutions)


def test_solutions_at_rest_are_two_where_sticking_meets_a_slip():
    # The slip with F_n = 2, F_t = 2 has a_t = 5 + b_t, so b_t = -5 sticks there.
    solutions = guided(1.0, -1.5, 4.0, 1.0, -5.0, 1.0, 0.0).solutions()
    assert [s.mode for s in solutions] == [LEFT, STICK]
    assert pairs(solutions)[1] == pytest.approx((2.0, 2.0))


def test_solutions_at_rest_are_two_without_normal_load():
    solutions = guided(1.0, -1.5, 4.0, 0.0, 1.0, 1.0, 0.0).solutions()
    assert [s.mode for s in solutions] == [STICK, RIGHT]
    assert pairs(solutions)[1] == (0.0, 0.0)


@pytest.mark.parametrize(
    ("b_t", "mode"),
    [(1.0, RIGHT), (-1.0, LEFT), (0.0, STICK)],
)
def test_solutions_follow_the_free_acceleration_without_friction(b_t, mode):
    (solution,) = guided(1.0, 0.0, 1.0, 2.0, b_t, 0.0, 0.0).solutions()
    assert solution.mode is mode and solution.normal_force == -2.0
    assert solution.tangential_acceleration == b_t


def test_a_rod_held_at_its_end_turns_its_paradox_into_two_forces():
    # The paper's rod (m = l = 1, mu = 1.4, theta = 1, sliding left), its end in a slot.
    sin, cos = math.sin(1.0), math.cos(1.0)
    W = 1 + 3 * cos**2, -3 * sin * cos, 1 + 3 * sin**2
    for b_n, count in ((-9.0, 0), (11.0, 2)):
        problem = guided(*W, b_n, 0.0, 1.4, -1.0)
        assert len(problem.solutions()) == count and not unique(problem)


# --- properties -------------------------------------------------------------------------------


def one_force_each(expected, data):
    """Return whether the forces have different motions."""
    W_nn, W_nt, W_tt, b_n, b_t, *_ = data
    motions = {
        (W_nn * F_n + W_nt * F_t + b_n, W_nt * F_n + W_tt * F_t + b_t) for _, F_n, F_t in expected
    }
    return len(motions) == len({tuple(solution[1:]) for solution in expected})


@given(singles)
def test_solutions_agree_with_rational_arithmetic(data):
    problem, expected = built(data), exact_solutions(*data)
    solutions = problem.solutions()
    assert all(s.residual <= RESIDUAL_TOLERANCE for s in solutions)
    for s in solutions:
        assert s.residual == problem.residual(s.forces)
    if expected is None:
        return
    if not one_force_each(expected, data):
        (solution,) = solutions
        assert solution.open_forces == 1 and not solution.moves
        return
    assert all(s.isolated for s in solutions)
    assert same_sets(pairs(solutions), {(F_n, F_t) for _, F_n, F_t in expected})
    for s in solutions:
        if data[6] == 0:
            continue
        assert s.mode is (RIGHT if data[6] > 0 else LEFT)


@given(moving)
def test_solutions_are_as_many_as_the_closed_condition_says_while_sliding(data):
    W_nn, W_nt, _, b_n, _, mu, s = data
    problem = built(data)
    solutions = problem.solutions()
    count = closed_count(W_nn, W_nt, b_n, mu, s)
    if math.isinf(count):
        assert solutions and not any(t.isolated for t in solutions)
    elif count == 2 and len(solutions) == 1:  # both forces have one motion
        assert solutions[0].open_forces == 1
    else:
        assert len(solutions) == count
    assert unique(problem) == (mu * abs(W_nt) < W_nn)


@given(resting)
def test_solutions_at_rest_are_as_many_as_the_closed_condition_says(data):
    W_nn, W_nt, _, b_n, _, mu, _ = data
    problem = built(data)
    solutions = problem.solutions()
    coupling = mu * abs(W_nt)
    assert unique(problem) == (coupling < W_nn)
    if coupling < W_nn or (coupling == W_nn and b_n != 0):
        assert len(solutions) == 1
    elif coupling > W_nn:
        assert len(solutions) in (1, 2, 3)
        slips = [t for t in solutions if t.mode is not STICK]
        if len(slips) == 2 and b_n != 0:
            assert slips[0].mode is slips[1].mode
            assert slips[0].mode is (RIGHT if W_nt * b_n > 0 else LEFT)
            assert slips[0].normal_force < 0 < slips[1].normal_force


@given(singles)
def test_solutions_swap_slip_directions_under_reflection(data):
    W_nn, W_nt, W_tt, b_n, b_t, mu, v = data
    here = built(data).solutions()
    there = built((W_nn, -W_nt, W_tt, b_n, -b_t, mu, -v)).solutions()
    assume(all(s.isolated for s in here))
    assert sorted(s.mode.value for s in here) == sorted(SWAPPED[s.mode].value for s in there)
    assert same_sets(pairs(here), [(F_n, -F_t) for F_n, F_t in pairs(there)])


@given(singles)
def test_solutions_change_sign_when_the_normal_is_reversed(data):
    W_nn, W_nt, W_tt, b_n, b_t, mu, v = data
    here = built(data).solutions()
    there = built((W_nn, -W_nt, W_tt, -b_n, b_t, mu, v)).solutions()
    assume(all(s.isolated for s in here))
    assert sorted(s.mode.value for s in here) == sorted(s.mode.value for s in there)
    assert same_sets(pairs(here), [(-F_n, F_t) for F_n, F_t in pairs(there)])


@given(singles)
def test_pushing_solutions_are_those_of_the_closed_unilateral_contact(data):
    pushing = [s for s in built(data).solutions() if s.normal_force > 0]
    single = ContactProblem.single(*map(float, data)).solutions()
    closed = [s for s in single if s.mode is not ContactMode.LIFTOFF]
    assume(all(s.isolated for s in (*built(data).solutions(), *single)))
    assert same_sets(pairs(pushing), pairs(closed))


@given(singles, st.integers(-30, 30))
def test_solutions_scale_with_the_accelerations(data, power):
    W_nn, W_nt, W_tt, b_n, b_t, mu, v = map(float, data)
    unit = 2.0**power
    here = built(data).solutions()
    there = built((W_nn, W_nt, W_tt, b_n * unit, b_t * unit, mu, v)).solutions()
    assert [s.mode for s in here] == [s.mode for s in there]
    for s, t in zip(here, there, strict=True):
        if s.isolated:
            assert t.normal_force == s.normal_force * unit


# --- residual and validation ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("forces", "v", "expected"),
    [
        ((-0.4, 0.4), -1.0, 0.0),
        ((-0.4, -0.4), -1.0, 1.0),  # friction along the slip
        ((0.0, 0.0), -1.0, 1.0),  # a_n = b_n
        ((-1.0, 0.0), -1.0, 1.0),  # no friction
        ((-1.0, 0.0), 0.0, 0.5),  # no friction, while a_t = 1.5 - 0.5
        ((math.nan, 0.0), 0.0, math.inf),
    ],
)
def test_residual_measures_the_violation_for_known_forces(forces, v, expected):
    problem = guided(1.0, -1.5, 4.0, 1.0, -0.5, 1.0, v)
    assert problem.residual(forces) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"b_n": math.nan}, "ContactProblem cannot be stated, b_n: got nan"),
        ({"mu": -0.1, "W_nt": 3.0}, "Also, mobility: "),
    ],
)
def test_bilateral_problem_names_the_fault_for_bad_input(change, words):
    good = {"W_nn": 1.0, "W_nt": 0.5, "W_tt": 1.0, "b_n": -1.0, "b_t": 0.0, "mu": 0.5}
    with pytest.raises(InputError, match="Fix: ") as caught:
        guided(**{**good, **change}, slip_velocity=-1.0)
    assert words in str(caught.value)


def test_a_slip_is_exactly_zero_for_a_difference_of_rounded_terms():
    assert 0.3 - 3 * 0.1 != 0.0
    assert guided(0.3, 0.1, 1.0, 1.0, 0.0, 3.0, 1.0).A_slip(1, 1) == 0.0
    assert np.isclose(guided(0.3, 0.1, 1.0, 1.0, 0.0, 3.0, 1.0).A_slip(1, -1), 0.6)
