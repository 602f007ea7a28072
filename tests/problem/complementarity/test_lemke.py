"""Lemke's pivots, against the enumeration and exact rational arithmetic."""

import numpy as np
import pytest
from hypothesis import example, given

from painleve_sym.problem.complementarity import (
    LCP,
    LemkeStatus,
    is_copositive,
    solve_all,
    solve_lemke,
)
from painleve_sym.problem.complementarity.lcp import ENUMERATION_LIMIT, RESIDUAL_TOLERANCE
from tests.problem.complementarity.rational import (
    among,
    dominant_problems,
    exact_vertices,
    problems,
)


@given(problems())
@example(([[0, -1, 0], [1, 1, 0], [0, 0, 0]], [0, -1, 0]))  # the same, in the last basis
def test_solve_lemke_answers_from_the_enumerated_set(problem):
    lcp = LCP(*problem)
    everything = solve_all(lcp)
    result = solve_lemke(lcp)
    assert result.status in (LemkeStatus.SOLVED, LemkeStatus.RAY)
    if result.solution is None:
        assert result.status is LemkeStatus.RAY
        return
    assert result.solution.residual <= RESIDUAL_TOLERANCE
    assert everything
    if result.solution.isolated:
        assert among(result.solution.z, [s.z for s in everything])


@given(dominant_problems())
def test_solve_lemke_succeeds_for_p_matrices(problem):
    assert solve_lemke(LCP(*problem)).status is LemkeStatus.SOLVED


@given(problems())
def test_solve_lemke_decides_existence_for_semidefinite_matrices(problem):
    factor, offset = problem
    lcp = LCP(np.array(factor) @ np.array(factor).T, offset)
    solved = solve_lemke(lcp).status is LemkeStatus.SOLVED
    assert solved == bool(exact_vertices(lcp.matrix.astype(int).tolist(), offset))


@pytest.mark.parametrize(
    ("matrix", "offset", "status"),
    [
        ([[2]], [4], LemkeStatus.SOLVED),
        ([[2]], [-4], LemkeStatus.SOLVED),
        ([[-2]], [-4], LemkeStatus.RAY),
        # Kostreva's matrix, on which least-index rules cycle.
        ([[1, 2, 0], [0, 1, 2], [2, 0, 1]], [-1, -1, -1], LemkeStatus.SOLVED),
    ],
)
def test_solve_lemke_ends_as_known_for_textbook_problems(matrix, offset, status):
    result = solve_lemke(LCP(matrix, offset))
    assert result.status is status
    assert (result.solution is None) == (status is not LemkeStatus.SOLVED)


@pytest.mark.parametrize("n", [5, 30])
def test_solve_lemke_does_not_cycle_for_complete_ties(n):
    lcp = LCP(np.ones((n, n)) + np.eye(n), -np.ones(n))
    result = solve_lemke(lcp)
    assert result.status is LemkeStatus.SOLVED
    assert np.allclose(result.solution.z, 1 / (n + 1))


@pytest.mark.parametrize("part", [1e-4, 1e-6, 1e-9])
def test_ratios_that_differ_by_little_are_no_tie(part):
    matrix, offset = [[2, 0, 3], [0, 19, 0], [3, 0, 12]], [-2.7 * part, -3 - 3.3 * part, 2]
    result = solve_lemke(LCP(matrix, offset))
    assert result.status is LemkeStatus.SOLVED
    expected = [1.35 * part, (3 + 3.3 * part) / 19, 0]
    np.testing.assert_allclose(result.solution.z, expected, rtol=1e-12)


def test_solve_lemke_reports_the_step_limit_when_pivots_run_out():
    result = solve_lemke(LCP(np.eye(3), -np.ones(3)), max_pivots=1)
    assert result.status is LemkeStatus.STEP_LIMIT and result.pivots == 1
    assert "max_pivots" in result.status.sentence


def test_solve_lemke_reports_not_verified_for_a_tolerance_below_rounding():
    rng = np.random.default_rng(3)
    factor = rng.normal(size=(6, 6))
    result = solve_lemke(LCP(factor @ factor.T, -rng.uniform(size=6)), tol=1e-30)
    assert result.status is LemkeStatus.NOT_VERIFIED and result.solution is None


def test_solve_lemke_leaves_varying_open_for_many_double_zeros():
    n = ENUMERATION_LIMIT + 1
    solution = solve_lemke(LCP(np.zeros((n, n)), np.zeros(n))).solution
    assert solution.varying is None and solution.isolated is None


def test_solve_lemke_solves_beyond_the_enumeration_limit():
    rng = np.random.default_rng(0)
    factor = rng.normal(size=(60, 60))
    result = solve_lemke(LCP(factor @ factor.T, rng.normal(size=60)))
    assert result.status is LemkeStatus.SOLVED
    assert result.solution.residual < 1e-12


@given(problems())
def test_is_copositive_implies_that_lemke_solves_when_strict(problem):
    if is_copositive(problem[0], strict=True):
        assert solve_lemke(LCP(*problem)).status is LemkeStatus.SOLVED
