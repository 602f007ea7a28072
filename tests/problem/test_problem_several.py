"""Several frictional contacts: known cases, the LCP, Lemke, rational arithmetic."""

import itertools
import math
import time
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from painleve_sym.errors import InputError
from painleve_sym.problem.complementarity import LemkeStatus, residual, solve_all
from painleve_sym.problem.complementarity.lcp import RESIDUAL_TOLERANCE
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.modes import CONTACT_LIMIT, ContactMode
from painleve_sym.problem.solution import ContactCase
from tests.problem.complementarity.rational import among
from tests.problem.friction_oracle import (
    SWAPPED,
    built,
    contact_sets,
    exact_solutions,
    same_sets,
    violates_coulomb,
)


def feet(xs, height=1.0, mass=2.0, inertia=1.0, mu=0.3, slip_velocity=0.0, b=None):
    """Return a rigid body on feet at (x, -height) of its centre of mass; its weight is on them."""
    J = np.array([row for x in xs for row in ([0.0, 1.0, x], [1.0, 0.0, height])])
    W = J @ np.diag([1 / mass, 1 / mass, 1 / inertia]) @ J.T
    free = J @ [0.0, -9.8, 0.0] if b is None else b
    return ContactProblem(W, free, np.full(len(xs), mu), np.full(len(xs), slip_velocity))


def definite(n, seed, mu, slip_velocity=0.0):
    """Return n contacts with a well-conditioned random mobility of full rank."""
    rng = np.random.default_rng(seed)
    L = rng.normal(size=(2 * n, 3 * n))
    return ContactProblem(
        L @ L.T, rng.normal(size=2 * n), np.full(n, mu), np.full(n, slip_velocity)
    )


# --- known cases ------------------------------------------------------------------------------


def test_solutions_share_the_weight_between_two_frictionless_feet():
    (solution,) = feet([-1.0, 2.0], mu=0.0).solutions()
    assert solution.normal_forces == pytest.approx(2 * 9.8 * np.array([2 / 3, 1 / 3]))
    assert solution.modes == (ContactMode.STICK, ContactMode.STICK)
    assert solution.isolated


def test_solutions_report_the_inner_stress_of_a_block_at_rest():
    # Opposite tangential forces at the two feet do nothing: rank 3 of 4.
    run = feet([-1.0, 1.0]).solutions()
    assert run and not any(s.isolated for s in run)
    for s in run:
        assert s.normal_forces == pytest.approx([9.8, 9.8])
        assert sum(s.tangential_forces) == pytest.approx(0.0, abs=1e-9)


def test_solutions_report_one_motion_of_a_block_on_three_feet_at_rest():
    problem = feet([-1.0, 0.0, 1.0])
    (solution,) = problem.solutions()
    assert problem.case is ContactCase.HYPERSTATIC
    # Six forces for three freedoms of the body.
    assert solution.open_forces == 3 and not solution.moves and not solution.isolated
    assert violates_coulomb(problem, solution) is None
    # The shortest forces, counted by mobilities, share the weight inversely to these.
    assert sum(solution.normal_forces) == pytest.approx(2 * 9.8)
    loads = solution.normal_forces * np.diag(problem.W)[::2]
    assert loads == pytest.approx(np.full(3, loads[0]))


def test_solutions_report_the_free_share_of_load_for_three_sliding_feet():
    run = feet([-1.0, 0.0, 1.0], slip_velocity=1.0).solutions()
    assert run and not any(s.isolated for s in run)
    for s in run:
        assert sum(s.normal_forces) == pytest.approx(2 * 9.8)
        # Moments about the centre of mass: sum x F_n = mu h m g.
        assert s.normal_forces[2] - s.normal_forces[0] == pytest.approx(0.3 * 2 * 9.8)


def test_solutions_multiply_for_contacts_that_do_not_feel_each_other():
    # Both contacts are the indeterminate one: lift-off or F_n = 2.
    one = [[1.0, -1.5], [-1.5, 4.0]]
    W = np.kron(np.eye(2), one)
    solutions = ContactProblem(W, [1, 0, 1, 0], [1, 1], [-1, -1]).solutions()
    assert [s.normal_forces.tolist() for s in solutions] == [[0, 0], [0, 2], [2, 0], [2, 2]]
    assert all(s.isolated for s in solutions)


def test_solutions_are_empty_when_one_contact_is_inconsistent():
    W = np.kron(np.eye(2), [[1.0, -1.5], [-1.5, 4.0]])
    assert ContactProblem(W, [1, 0, -1, 0], [1, 1], [-1, -1]).solutions() == ()


def test_solutions_hold_every_branch_for_a_problem_without_data():
    solutions = ContactProblem(np.zeros((4, 4)), np.zeros(4), [1, 1], [0, 1]).solutions()
    assert not any(s.isolated for s in solutions)
    (solution,) = solutions
    assert solution.open_forces == 3 and not solution.forces.any()


# --- many contacts ----------------------------------------------------------------------------


@pytest.mark.parametrize("slip_velocity", [0.0, 1.0])
def test_solutions_try_all_branches_of_six_contacts_in_time(slip_velocity):
    problem = definite(CONTACT_LIMIT, 4, 0.4, slip_velocity)
    begin = time.process_time()
    solutions = problem.solutions()
    assert time.process_time() - begin < 2.0  # 0.1 s; a solve of its own for each takes seconds
    assert solutions
    assert all(violates_coulomb(problem, s) is None for s in solutions)


def test_more_than_six_contacts_are_left_to_lemke():
    problem = definite(CONTACT_LIMIT + 1, 0, 0.4)
    for ask in (problem.solutions, problem.uniqueness):
        with pytest.raises(InputError, match=r"got 7 contacts, need at most 6.* solve_lemke"):
            ask()
    result = problem.solve_lemke()
    assert result.status is LemkeStatus.SOLVED
    assert result.solution.residual <= RESIDUAL_TOLERANCE
    assert violates_coulomb(problem, result.solution) is None


@pytest.mark.parametrize("mu", [0.1, 1.0, 20.0])
def test_solve_lemke_succeeds_at_rest_for_many_contacts_and_any_friction(mu):
    for seed in range(3):
        problem = definite(12, seed, mu)
        result = problem.solve_lemke()
        assert result.status is LemkeStatus.SOLVED and result.solution.isolated
        assert violates_coulomb(problem, result.solution) is None


def test_solve_lemke_says_so_when_the_inner_stress_is_free():
    for count in (2, 5):
        assert feet(np.linspace(-1, 1, count)).solve_lemke().solution.isolated is False


def test_solve_lemke_leaves_isolation_open_where_too_many_branches_meet():
    n = 9  # 4**9 choices at the origin
    problem = ContactProblem(np.eye(2 * n), np.zeros(2 * n), np.ones(n), np.zeros(n))
    assert problem.solve_lemke().solution.isolated is None


def test_solve_lemke_reports_the_step_limit_when_pivots_run_out():
    result = definite(3, 0, 0.4).solve_lemke(max_pivots=1)
    assert result.status is LemkeStatus.STEP_LIMIT and result.solution is None


# --- properties -------------------------------------------------------------------------------


@settings(max_examples=120)
@given(contact_sets())
def test_solutions_agree_with_rational_arithmetic_for_small_integers(data):
    problem = built(data)
    solutions = problem.solutions()
    for s in solutions:
        assert s.residual <= RESIDUAL_TOLERANCE
        assert violates_coulomb(problem, s) is None
    expected, complete = exact_solutions(*data)
    for exact in expected:
        assert among(np.array(exact, float), [s.forces for s in solutions])
    if complete:
        assert same_sets([s.forces for s in solutions], expected)
    for s in solutions:
        if s.isolated:
            assert among(s.forces, expected)


@settings(max_examples=60)
@given(contact_sets(sizes=st.just(2)))
def test_solutions_agree_with_the_enumeration_of_the_lcp(data):
    problem = built(data)
    lcp = problem.lcp()
    starts = np.cumsum([0] + [1 if s else 3 for s in data[3]])
    read, enumerated = [], solve_all(lcp)
    for listed in enumerated:
        F = np.zeros(4)
        for i, (k, s) in enumerate(zip(starts, data[3], strict=False)):
            F[2 * i] = listed.z[k]
            F[2 * i + 1] = -s * problem.mu[i] * listed.z[k]
            if not s:
                F[2 * i + 1] = listed.z[k + 1] - problem.mu[i] * listed.z[k]
        if listed.isolated:
            read.append(F)
    solutions = problem.solutions()
    assert bool(solutions) == bool(enumerated)
    everything = [s.forces for s in solutions]
    assert all(among(F, everything) for F in read)


@settings(max_examples=80)
@given(contact_sets(sizes=st.integers(1, 3)))
def test_solve_lemke_answers_from_the_enumerated_set(data):
    problem = built(data)
    result = problem.solve_lemke()
    solutions = problem.solutions()
    if result.solution is None:
        assert result.status in (LemkeStatus.RAY, LemkeStatus.NOT_VERIFIED)
        return
    assert result.status is LemkeStatus.SOLVED and solutions
    assert result.solution.residual <= RESIDUAL_TOLERANCE
    assert violates_coulomb(problem, result.solution) is None
    if result.solution.isolated:
        assert among(result.solution.forces, [s.forces for s in solutions if s.isolated])


# A ray of forces that ends on the edge of a cone: rounding there must not pass for friction.
ON_EDGE = (
    [[1, 2, 0, 1], [2, 5, 0, 2], [0, 0, 1, 1], [1, 2, 1, 6]],
    [0, 0.25, 0, 0.125],
    [0.5, 0.25],
    [0, 0],
)


@settings(max_examples=60)
@given(contact_sets(sizes=st.integers(1, 3), slip=(0,), definite=True))
@example(ON_EDGE)
def test_solve_lemke_succeeds_at_rest_for_definite_mobility(data):
    assert built(data).solve_lemke().status is LemkeStatus.SOLVED


@settings(max_examples=80)
@given(contact_sets())
def test_solutions_swap_slip_directions_under_reflection(data):
    problem = built(data)
    signs = np.tile([1.0, -1.0], problem.size)
    mirror = ContactProblem(
        problem.W * np.outer(signs, signs), problem.b * signs, problem.mu, -problem.slip_velocity
    )
    here, there = problem.solutions(), mirror.solutions()
    assert bool(here) == bool(there)
    modes = sorted(tuple(SWAPPED[m].value for m in s.modes) for s in there if s.isolated)
    assert modes == sorted(tuple(m.value for m in s.modes) for s in here if s.isolated)
    assert same_sets(
        [s.forces for s in here if s.isolated], [signs * s.forces for s in there if s.isolated]
    )


@settings(max_examples=50)
@given(contact_sets(sizes=st.integers(2, 3)), st.randoms(use_true_random=False))
def test_solutions_permute_with_the_contacts(data, random):
    problem = built(data)
    order = list(range(problem.size))
    random.shuffle(order)
    rows = [2 * i + k for i in order for k in (0, 1)]
    permuted = ContactProblem(
        problem.W[np.ix_(rows, rows)],
        problem.b[rows],
        problem.mu[order],
        problem.slip_velocity[order],
    )
    here, there = problem.solutions(), permuted.solutions()
    assert bool(here) == bool(there)
    assert same_sets(
        [s.forces[rows] for s in here if s.isolated], [s.forces for s in there if s.isolated]
    )


@settings(max_examples=50)
@given(contact_sets(), st.integers(-30, 30))
def test_solutions_scale_with_the_accelerations(data, power):
    problem, unit = built(data), 2.0**power
    scaled = ContactProblem(problem.W, problem.b * unit, problem.mu, problem.slip_velocity)
    for s, t in itertools.zip_longest(problem.solutions(), scaled.solutions()):
        assert s.modes == t.modes
        if s.isolated:
            assert np.array_equal(unit * s.forces, t.forces)


@settings(max_examples=60)
@given(contact_sets(), st.lists(st.integers(-20, 20), min_size=2, max_size=2))
def test_solutions_do_not_depend_on_the_size_of_each_contact(data, powers):
    problem = built(data)
    unit = np.repeat(2.0 ** np.array(powers[: problem.size]), 2)
    scaled = ContactProblem(
        problem.W * np.outer(unit, unit), problem.b * unit, problem.mu, problem.slip_velocity
    )
    here, there = problem.solutions(), scaled.solutions()
    assert sorted(str(s.modes) for s in here) == sorted(str(s.modes) for s in there)
    assert same_sets(
        [s.forces for s in here if s.isolated], [unit * s.forces for s in there if s.isolated]
    )


# --- the complementarity problem --------------------------------------------------------------


def test_lcp_has_one_pair_for_each_sliding_contact_and_three_at_rest():
    problem = ContactProblem(np.eye(6), np.ones(6), np.ones(3), [0.0, 1.0, -2.0])
    assert problem.lcp().size == 3 + 1 + 1


def test_solution_residual_is_that_of_its_forces_and_solves_the_lcp():
    problem = definite(3, 1, 0.3, 1.0)
    for s in problem.solutions():
        assert s.residual == problem.residual(s.forces)
        assert residual(problem.lcp(), s.normal_forces) <= 1e-14


def test_lcp_removes_signs_that_rounding_left():
    assert 0.3 - 3 * 0.1 != 0.0
    problem = ContactProblem([[0.3, -0.1], [-0.1, 1.0]], [1, 0], [3.0], [-1.0])
    assert problem.lcp().matrix[0, 0] == 0.0


# --- validation -------------------------------------------------------------------------------


@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 6),
    st.sampled_from([0.0, 1e-14, 1e-9, 1e-3, 1.0]),
)
def test_problem_takes_the_mobilities_without_a_negative_eigenvalue(seed, rank, lowered):
    """With NumPy's eigenvalues as the judge, of all ranks and sizes of rows."""
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(6, rank))
    scale = 10.0 ** rng.integers(-3, 4, size=6)
    root = np.sqrt(np.einsum("ij,ij->i", J, J))
    W = J @ J.T / np.outer(root, root)
    v = rng.normal(size=6)
    W -= lowered * np.outer(v, v) / (v @ v)
    root = np.sqrt(np.maximum(np.diag(W), 0))
    unit = np.diag(1 / np.where(root > 0, root, 1))
    least = np.min(np.linalg.eigvalsh(unit @ W @ unit))
    scaled = np.diag(scale) @ ((W + W.T) / 2) @ np.diag(scale)
    try:
        ContactProblem(scaled, np.ones(6), np.ones(3), np.ones(3))
        accepted = True
    except InputError:
        accepted = False
    assert accepted == (least >= -6e-12) or abs(least + 6e-12) < 1e-13


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"b": [math.nan, 0, 0, 0]}, "b: got"),
        ({"W": "x"}, "W: got 'x'"),
        ({"friction": [0.1, -0.1]}, "need mu >= 0"),
        ({"friction": [0.1]}, "mu: got shape (1,), need (2,)"),
        ({"W": np.eye(2), "b": [1, 1]}, "W: got shape (2, 2), need (4, 4)"),
        ({"W": np.eye(2), "b": [1, 1]}, "Also, b: got shape (2,), need (4,)"),
        ({"slip_velocity": []}, "slip_velocity: got shape (0,), need (1,)"),
        ({"W": np.triu(np.ones((4, 4)))}, "symmetric"),
        ({"W": np.ones((4, 4)) - np.eye(4)}, "where the diagonal is 0"),
        ({"W": np.eye(4) + 2 * np.fliplr(np.eye(4))}, "positive semidefinite"),
        ({"W": -np.eye(4)}, "where the diagonal is 0"),
    ],
)
def test_contact_problem_names_the_fault_for_bad_input(change, words):
    good = {"W": np.eye(4), "b": np.zeros(4), "friction": [0.1, 0.2], "slip_velocity": [0.0, 1.0]}
    with pytest.raises(InputError, match="Fix: ") as caught:
        ContactProblem(**{**good, **change})
    assert words in str(caught.value)


def test_contact_problem_keeps_its_own_arrays():
    W = np.eye(2)
    problem = ContactProblem(W, [1, 1], [0], [0])
    W[0, 0] = 5.0
    assert problem.W[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        problem.b[0] = 3.0


# Normal forces that only a tiny friction makes independent are of the size of its inverse, and what
# is small beside their terms is not rounding. The mobility is L L'; L, b, mu, directions of slip.
NEARLY_FRICTIONLESS = [
    (
        [[-3, -1], [2, 2], [-3, 0], [0, -3], [3, -3], [-2, -1]],
        [-0.875, -2.375, 0.875, -1.25, 0.75, -0.625],
        [2.0, 1.0, 1e-10],
        [1, 0, 0],
    ),
    (
        [[2, 1], [-3, -3], [-1, 1], [-3, -3], [-2, 0], [-2, 3]],
        [1.375, -1.625, 1.75, 1.75, -2.875, 1.5],
        [1e-11, 1.0, 1e-9],
        [-1, -1, 0],
    ),
    (
        [[3, 0], [-3, -1], [-1, 3], [-1, -2], [3, 1], [1, -1]],
        [-1.625, -1.875, -0.25, 0.75, -0.5, -1.5],
        [2.0, 2.0, 1e-11],
        [0, -1, 0],
    ),
    ([[2, -2], [2, -1], [-3, 2], [1, 1]], [-2.625, -0.625, -0.375, 2.625], [2.0, 1e-10], [0, 0]),
]


@pytest.mark.parametrize("given", NEARLY_FRICTIONLESS)
def test_forces_of_tiny_friction_leave_no_open_contact_approaching(given):
    L, *rest = given
    data = (np.array(L) @ np.transpose(L)).tolist(), *rest
    exact, _ = exact_solutions(*_fractions(*data))
    assert same_sets([s.forces for s in built(data).solutions()], exact)


def _fractions(W, b, mu, slip):
    return [[*map(Fraction, row)] for row in W], [*map(Fraction, b)], [*map(Fraction, mu)], slip
