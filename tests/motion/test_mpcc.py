"""Relaxations through IPOPT: right where they succeed, honest where they do not."""

import math

import numpy as np
import pytest
from hypothesis import given, settings

from painleve_sym.errors import InputError
from painleve_sym.motion.time_stepping import mpcc
from painleve_sym.motion.time_stepping.mpcc import MPCCStatus, solve_mpcc, solve_mpcc_all
from painleve_sym.problem.complementarity import LCP, residual, solve_all
from painleve_sym.problem.complementarity.lcp import RESIDUAL_TOLERANCE
from painleve_sym.problem.contact_problem import ContactProblem
from tests.problem.complementarity.rational import problems

TOLERANCE = RESIDUAL_TOLERANCE
# w_2 = z_1 - z_2 - 2 >= 0 needs z_1 >= 2, yet w_1 = 2 z_1 + z_2 + 2 > 0 needs z_1 = 0: the
# inequalities can be met, complementarity cannot.
FEASIBLE_ONLY = LCP([[2, 1], [1, -1]], [2, -2])


def rod(angle, rate, slip_velocity=-1.0, mu=1.4):
    """Return the paper's rod (m = 1 kg, l = 1 m, g = 9.8 m/s²)."""
    sin, cos = math.sin(angle), math.cos(angle)
    mobility = 1 + 3 * cos**2, -3 * sin * cos, 1 + 3 * sin**2
    return ContactProblem.single(*mobility, rate**2 * sin - 9.8, rate**2 * cos, mu, slip_velocity)


@pytest.mark.parametrize(
    ("angle", "rate", "slip_velocity"),
    [(0.5, 1.0, -1.0), (0.5, 5.0, -1.0), (0.5, 1.0, 0.0), (1.0, 1.0, 0.0), (1.0, 1.0, 1.0)],
)
def test_solve_mpcc_finds_the_solution_when_there_is_one(angle, rate, slip_velocity):
    problem = rod(angle, rate, slip_velocity)
    (expected,) = problem.solutions()
    result = solve_mpcc(problem.lcp())
    assert result.status is MPCCStatus.SOLVED
    assert result.z[0] == pytest.approx(expected.normal_force, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("lcp", [rod(1.0, 1.0).lcp(), FEASIBLE_ONLY, LCP([[0]], [-1])])
def test_solve_mpcc_reports_failure_for_inconsistent_problems(lcp):
    assert solve_all(lcp) == ()
    result = solve_mpcc(lcp)
    assert result.status in (MPCCStatus.INFEASIBLE, MPCCStatus.NOT_CONVERGED)
    assert result.residual > 0.01
    survey = solve_mpcc_all(lcp)
    assert survey.solutions == () and survey.failed == survey.starts > 1


def test_solve_mpcc_all_finds_both_solutions_for_the_indeterminate_rod():
    survey = solve_mpcc_all(rod(1.0, 5.0).lcp())
    forces = sorted(result.z[0] for result in survey.solutions)
    assert forces == pytest.approx([0.0, 332.99227], abs=1e-4)
    assert survey.failed == 0


@pytest.mark.parametrize(("start", "force"), [(0.0, 0.0), (300.0, 332.99227)])
def test_solve_mpcc_finds_the_nearest_solution_for_a_given_start(start, force):
    result = solve_mpcc(rod(1.0, 5.0).lcp(), start=[start])
    assert result.z[0] == pytest.approx(force, abs=1e-4)


def test_solve_mpcc_all_finds_all_three_solutions_for_known_matrix():
    lcp = LCP([[1, 2], [2, 1]], [-1, -1])
    solutions = [result.z for result in solve_mpcc_all(lcp).solutions]
    for s in solve_all(lcp):
        assert any(np.allclose(s.z, z) for z in solutions)


def test_solve_mpcc_all_counts_one_solution_for_liftoff_at_rest():
    # How a_t divides into two parts is free here; the forces are not.
    survey = solve_mpcc_all(rod(0.5, 5.0, slip_velocity=0.0).lcp(), compared=2)
    assert len(survey.solutions) == 1


def test_solve_mpcc_polishes_into_exact_zeros_for_a_regular_solution():
    result = solve_mpcc(LCP([[2, 0], [0, 1]], [-4, 3]))
    assert result.polished
    assert result.z.tolist() == [2.0, 0.0] and result.w.tolist() == [0.0, 3.0]


def test_solve_mpcc_accepts_any_force_for_the_border_without_signs():
    result = solve_mpcc(LCP([[0]], [0]), start=[3.0])
    assert result.status is MPCCStatus.SOLVED and result.z[0] >= 0


def test_solve_mpcc_reports_not_converged_when_iterations_run_out(monkeypatch):
    monkeypatch.setattr(mpcc, "MAX_ITERATIONS", 1)
    result = solve_mpcc(FEASIBLE_ONLY)
    assert result.status is MPCCStatus.NOT_CONVERGED and result.iterations == 1


def test_solve_mpcc_reports_not_verified_when_relaxed_too_little(monkeypatch):
    monkeypatch.setattr(mpcc, "RELAXATIONS", (4.0,))
    result = solve_mpcc(FEASIBLE_ONLY)
    assert result.status is MPCCStatus.NOT_VERIFIED
    assert result.residual > TOLERANCE


def test_solve_mpcc_reports_not_verified_for_a_tolerance_below_rounding(monkeypatch):
    monkeypatch.setattr(mpcc, "RESIDUAL_TOLERANCE", 1e-30)
    rng = np.random.default_rng(3)
    factor = rng.normal(size=(3, 3))
    lcp = LCP(factor @ factor.T, -rng.uniform(size=3))
    result = solve_mpcc(lcp)
    assert 0 < result.residual < TOLERANCE
    assert result.status is MPCCStatus.NOT_VERIFIED


@pytest.mark.slow
def test_solve_mpcc_all_repeats_itself():
    lcp = LCP(np.diag([1.0, -1.0, 2.0, -3.0, 1.0]), [-1, 1, 1, 1, -1])
    first, second = (solve_mpcc_all(lcp) for _ in range(2))
    assert [a.z.tolist() for a in first.solutions] == [b.z.tolist() for b in second.solutions]
    assert len(first.solutions) > 1


@pytest.mark.parametrize("problem", [rod(0.5, 1.0), rod(1.0, 1.0)])
def test_solve_mpcc_prints_nothing_for_any_outcome(problem, capfd):
    solve_mpcc_all(problem.lcp(), starts=[[0.0], [1.0]])
    captured = capfd.readouterr()
    assert captured.out == "" and captured.err == ""


@settings(max_examples=15)
@given(problems())
def test_solve_mpcc_never_claims_more_than_it_verified(problem):
    lcp = LCP(*problem)
    everything = solve_all(lcp)
    survey = solve_mpcc_all(lcp, starts=np.eye(lcp.size))
    for result in survey.solutions + survey.failures:
        solved = result.status is MPCCStatus.SOLVED
        assert solved == (result.residual <= TOLERANCE)
        assert result.residual == residual(lcp, result.z)
        if solved:
            assert everything
            if all(s.isolated for s in everything):
                assert any(np.allclose(result.z, s.z, atol=1e-8) for s in everything)


@pytest.mark.parametrize("start", [[1.0, 2.0], [math.nan]])
def test_solve_mpcc_refuses_a_start_that_does_not_fit(start):
    with pytest.raises(InputError, match="Fix: give one number"):
        solve_mpcc(rod(0.5, 1.0).lcp(), start=start)


def test_solve_mpcc_all_refuses_an_empty_list_of_starts():
    with pytest.raises(InputError, match="need at least one"):
        solve_mpcc_all(rod(0.5, 1.0).lcp(), starts=[])
