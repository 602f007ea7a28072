"""Existence and uniqueness by the matrix, against the enumeration and exact determinants."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from painleve_sym.problem.complementarity import Uniqueness, is_copositive, is_p_matrix
from painleve_sym.problem.contact_problem import ContactProblem
from tests.problem.friction_oracle import EIGHTHS, built, contact_sets
from tests.support.drawn import integers

sliding = -1, 1


def one(W_nt, mu, slip_velocity, W_tt=4.0):
    return ContactProblem([[1.0, W_nt], [W_nt, W_tt]], [0, 0], [mu], [slip_velocity])


@pytest.mark.parametrize(
    ("problem", "expected"),
    [
        (one(-1.5, 0.6, -1.0), Uniqueness.UNIQUE_FOR_ALL),  # A = 0.1
        (one(-1.5, 0.7, -1.0), Uniqueness.NOT_GUARANTEED),  # A = -0.05
        (one(-1.5, 0.7, 1.0), Uniqueness.UNIQUE_FOR_ALL),  # the other way A = 2.05
        (one(-1.0, 1.0, -1.0), Uniqueness.NOT_GUARANTEED),  # A = 0
        (one(-1.5, 0.6, 0.0), Uniqueness.UNIQUE_FOR_ALL),
        (one(-1.5, 0.7, 0.0), Uniqueness.SOLVABLE_FOR_ALL),  # at rest there is always a solution
        (one(1.0, 0.5, 0.0, 1.0), Uniqueness.SOLVABLE_FOR_ALL),  # W of rank one, A > 0 both ways
        (one(1.0, 1.5, 0.0, 1.0), Uniqueness.NOT_GUARANTEED),  # its null direction is in the cone
        (one(0.0, 0.0, 0.0, 0.0), Uniqueness.UNIQUE_FOR_ALL),  # frictionless: F_t = 0 anyway
        (ContactProblem(np.zeros((2, 2)), [0, 0], [0], [1]), Uniqueness.NOT_GUARANTEED),
    ],
)
def test_uniqueness_is_known_for_one_contact(problem, expected):
    assert problem.uniqueness() is expected


def test_uniqueness_of_sliding_contacts_may_be_existence_only():
    # Strictly copositive (all entries positive), yet the minor of both is negative.
    # A_ij = W_nn,ij - mu_j W_nt,ij, built from W_nn = I and W_nt = [[0, -2], [-2, 0]].
    W = 0.25 * np.eye(4)
    W[0, 3] = W[3, 0] = W[1, 2] = W[2, 1] = -0.25
    problem = ContactProblem(W, np.zeros(4), [2, 2], [1, 1])
    matrix = problem.lcp().matrix
    assert np.allclose(matrix, [[0.25, 0.5], [0.5, 0.25]])
    assert problem.uniqueness() is Uniqueness.SOLVABLE_FOR_ALL
    down = ContactProblem(W, [-1, 0, -1, 0], [2, 2], [1, 1])
    assert len(down.solutions()) == 3


def test_uniqueness_explains_itself():
    for member in Uniqueness:
        assert member.label == member.name.lower()
        assert len(member.meaning) > 40 and any(c.isdigit() for c in member.reference)
        assert member.name in Uniqueness.__doc__


# --- properties -------------------------------------------------------------------------------

# Strictly copositive, but only as long as rows and columns are scaled alike.
COPOSITIVE = (
    [
        [5, 0, 1, 0, -2, 3],
        [0, 0, 0, 0, 0, 0],
        [1, 0, 1, 0, 0, 1],
        [0, 0, 0, 0, 0, 0],
        [-2, 0, 0, 0, 1, -1],
        [3, 0, 1, 0, -1, 2],
    ],
    [0] * 6,
    [0, 0, 0.75],
    [-1, -1, -1],
)
# One solution, which two choices of branches meet, apart by a force of 1e-17.
TWICE = (
    [
        [9, 0, -9, 0, 9, 0],
        [0, 1, 1, 0, 1, 0],
        [-9, 1, 11, 0, -6, 0],
        [0, 0, 0, 1, 3, 0],
        [9, 1, -6, 3, 24, 0],
        [0, 0, 0, 0, 0, 1],
    ],
    [-1.5, 0, 1.375, -0.125, -2.125, 0],
    [0, 0.25, 0],
    [-1, 0, -1],
)


@given(contact_sets(sizes=st.integers(1, 3), slip=sliding))
@example(COPOSITIVE)
def test_uniqueness_is_the_p_property_while_sliding(data):
    problem = built(data)
    matrix = problem.lcp().matrix
    promised = problem.uniqueness()
    assert (promised is Uniqueness.UNIQUE_FOR_ALL) == is_p_matrix(matrix)
    if promised is not Uniqueness.UNIQUE_FOR_ALL:
        strict = is_copositive(matrix, strict=True)
        assert (promised is Uniqueness.SOLVABLE_FOR_ALL) == strict


@given(contact_sets(sizes=st.integers(1, 3), definite=True))
@example(TWICE)
def test_solutions_keep_the_promise(data):
    problem = built(data)
    promised, solutions = problem.uniqueness(), problem.solutions()
    if promised is Uniqueness.UNIQUE_FOR_ALL:
        assert len(solutions) == 1 and solutions[0].isolated
    if promised is Uniqueness.SOLVABLE_FOR_ALL:
        assert solutions


@given(contact_sets(sizes=st.integers(1, 2), slip=sliding, definite=True), st.data())
def test_p_matrices_have_exactly_one_solution_for_any_offset(data, draw):
    # Small friction keeps the matrix near the positive definite W_nn.
    W, b, mu, slip = data
    weak = ContactProblem(
        np.array(W, float), np.array(b, float), np.array(mu, float) / 64, np.array(slip)
    )
    if weak.uniqueness() is not Uniqueness.UNIQUE_FOR_ALL:
        return
    for _ in range(3):
        offset = [k / 8 for k in draw.draw(integers([EIGHTHS] * len(b)))]
        problem = ContactProblem(weak.W, offset, weak.mu, weak.slip_velocity)
        assert len(problem.solutions()) == 1


@pytest.mark.parametrize("directions", [(0, 0), (0, 1), (-1, 1)])
def test_no_promise_of_uniqueness_is_missed(directions):
    # Exactly where it is not promised, some b on a fine sphere has several solutions or none.
    rng = np.random.default_rng(7)
    kinds = set()
    for _ in range(12):
        L = rng.normal(size=(4, 4))
        mu = rng.uniform(0.0, 2.0, 2)
        W = L @ L.T + 0.3 * np.eye(4)
        promised = ContactProblem(W, np.zeros(4), mu, directions).uniqueness()
        counts = {
            len(ContactProblem(W, b, mu, directions).solutions()) for b in rng.normal(size=(40, 4))
        }
        kinds.add(promised)
        if promised is Uniqueness.UNIQUE_FOR_ALL:
            assert counts == {1}
        if promised is Uniqueness.SOLVABLE_FOR_ALL:
            assert 0 not in counts
    assert Uniqueness.UNIQUE_FOR_ALL in kinds and len(kinds) > 1


@settings(max_examples=60)
@given(contact_sets(sizes=st.just(1)))
def test_uniqueness_agrees_with_the_closed_conditions_of_one_contact(data):
    problem = built(data)
    (s,) = data[3]
    args = [float(v) for v in (data[0][0][0], data[0][0][1], data[0][1][1], *data[1], *data[2], s)]
    single = ContactProblem.single(*args)
    ways = [s] if s else [-1, 1]
    regular = s != 0 or args[5] == 0 or args[0] * args[2] - args[1] ** 2 > 0
    closed = all(single.A_slip(way) > 0 for way in ways) and regular
    assert (problem.uniqueness() is Uniqueness.UNIQUE_FOR_ALL) == closed
    # A bilateral contact loads either side: uniqueness there needs both signs of A.
    both = all(single.A_slip(1, side) > 0 for side in (1, -1)) and regular
    held = ContactProblem.single(*args, bilateral=True).uniqueness()
    assert (held is Uniqueness.UNIQUE_FOR_ALL) == both


def test_the_determinants_of_a_pair_at_rest_are_those_by_hand():
    W = np.array([[2.0, 0.5], [0.5, 1.0]])
    for mu, s in itertools.product([0.5, 3.9, 4.1], [1, -1]):
        mirrored = W * np.outer([1, s], [1, s])
        problem = ContactProblem(mirrored, [0, 0], [mu], [0])
        unique = mu * 0.5 < 2.0
        assert (problem.uniqueness() is Uniqueness.UNIQUE_FOR_ALL) == unique
