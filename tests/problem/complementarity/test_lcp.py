"""Statement, residual and enumeration, against exact rational arithmetic."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from painleve_sym.errors import InputError
from painleve_sym.problem.complementarity import LCP, is_p_matrix, residual, solve_all
from painleve_sym.problem.complementarity.lcp import (
    ENUMERATION_LIMIT,
    RESIDUAL_TOLERANCE,
    equilibrate,
)
from tests.problem.complementarity.rational import (
    among,
    dominant_problems,
    entries,
    exact_vertices,
    magnitudes,
    problems,
)
from tests.support.drawn import integers

# --- statement and residual -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("matrix", "offset", "words"),
    [
        ([[1, 2]], [1], "matrix: got shape (1, 2)"),
        ([1, 2], [1, 2], "matrix: got shape (2,)"),
        (np.empty((0, 0)), [], "n >= 1"),
        ([[1]], [1, 2], "offset: got shape (2,)"),
        ([[np.nan]], [1], "matrix: got an infinite or nan entry"),
        ([[1]], [np.inf], "offset: got an infinite or nan entry"),
        ([["a"]], [1], "need real numbers"),
        ([[1j]], [1], "complex entries"),
    ],
)
def test_lcp_names_the_fault_for_bad_input(matrix, offset, words):
    with pytest.raises(InputError, match="Fix: ") as caught:
        LCP(matrix, offset)
    assert words in str(caught.value)


def test_lcp_names_every_fault_for_several():
    with pytest.raises(InputError, match=r"matrix: .* Also, offset: "):
        LCP([[np.nan]], [np.inf])


def test_lcp_keeps_its_own_arrays_after_construction():
    matrix = np.array([[2.0]])
    lcp = LCP(matrix, np.array([1.0]))
    matrix[0, 0] = 5.0
    assert lcp.matrix[0, 0] == 2.0
    with pytest.raises(ValueError, match="read-only"):
        lcp.matrix[0, 0] = 3.0


@pytest.mark.parametrize(
    ("matrix", "offset", "z", "expected"),
    [
        ([[2]], [-4], [2], 0.0),
        ([[2]], [4], [0], 0.0),
        ([[2]], [-4], [0], 1.0),  # w < 0
        ([[-2]], [-4], [-2], 0.5),  # z < 0: half of the terms of w
        ([[1]], [0], [1e-30], 1.0),  # the only solution is 0, however small z is
        ([[0]], [0], [7], 0.0),
        ([[0]], [0], [-7], 1.0),
        ([[1]], [1], [np.nan], np.inf),
    ],
)
def test_residual_measures_the_violation_for_known_points(matrix, offset, z, expected):
    assert residual(LCP(matrix, offset), z) == pytest.approx(expected)


def test_residual_refuses_a_point_of_other_length():
    with pytest.raises(InputError, match="Fix: give one entry"):
        residual(LCP([[1]], [1]), [1, 2])


@given(problems(), st.data())
def test_residual_is_unchanged_under_change_of_units(problem, data):
    matrix, offset = (np.array(part, dtype=float) for part in problem)
    n = offset.size
    row, column = 2.0 ** np.reshape(data.draw(integers([range(-20, 21)] * (2 * n))), (2, n))
    z = np.array(data.draw(entries(n)), dtype=float)
    scaled = LCP(row[:, None] * matrix / column, row * offset)
    assert residual(scaled, column * z) == residual(LCP(matrix, offset), z)


@given(problems(numbers=magnitudes))
def test_equilibrate_keeps_solutions_for_any_scale(problem):
    lcp = LCP(*problem)
    scaled, unit = equilibrate(lcp)
    assert np.max(np.abs(scaled.matrix), initial=0) <= 1 and np.max(np.abs(scaled.offset)) <= 1
    z = np.arange(1.0, lcp.size + 1)
    assert residual(scaled, z) == pytest.approx(residual(lcp, unit * z), rel=1e-12)


# --- every solution ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        (2, -4, [2]),
        (2, 4, [0]),
        (-2, -4, []),
        (-2, 4, [0, 2]),
        (2, 0, [0]),
        (-2, 0, [0]),
        (0, 1, [0]),
        (0, -1, []),
    ],
)
def test_solve_all_finds_every_solution_for_one_pair(a, b, expected):
    solutions = solve_all(LCP([[a]], [b]))
    assert [s.z[0] for s in solutions] == expected
    assert all(s.isolated for s in solutions)


def test_solve_all_reports_the_ray_for_zero_data():
    solutions = solve_all(LCP([[0]], [0]))
    assert [s.z[0] > 0 for s in solutions] == [False, True]
    assert not any(s.isolated for s in solutions)


def test_solve_all_finds_three_solutions_for_known_matrix():
    solutions = solve_all(LCP([[1, 2], [2, 1]], [-1, -1]))
    assert [s.active for s in solutions] == [(True, False), (False, True), (True, True)]
    assert np.allclose([s.z for s in solutions], [[1, 0], [0, 1], [1 / 3, 1 / 3]])
    assert all(s.isolated for s in solutions)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_solve_all_reports_a_simplex_of_solutions_for_equal_rows(n):
    solutions = solve_all(LCP(np.ones((n, n)), -np.ones(n)))
    assert {s.active for s in solutions} == set(itertools.product([False, True], repeat=n)) - {
        (False,) * n
    }
    assert all(np.isclose(s.z.sum(), 1) and not s.isolated for s in solutions)


@pytest.mark.parametrize("n", [2, 3])
def test_solve_all_reports_one_point_for_faces_without_extent(n):
    matrix = np.zeros((n, n))
    matrix[-1] = -1  # w_n = -sum(z) >= 0 leaves only z = 0, though most blocks are singular
    (solution,) = solve_all(LCP(matrix, np.zeros(n)))
    assert not solution.z.any() and solution.isolated


def test_solve_all_names_the_varying_entries_for_a_ray():
    solutions = solve_all(LCP([[1, 0], [0, 0]], [-1, 0]))
    assert {s.active for s in solutions} == {(True, False), (True, True)}
    assert all(s.varying == (False, True) for s in solutions)


def test_solve_all_finds_the_ray_for_a_face_without_inside():
    # w_3 and w_4 leave z_1 = z_2 only, inside a block that is singular twice.
    matrix = [[0, 0, 0, 0], [0, 0, 0, 0], [1, -1, -1, 0], [-1, 1, 0, -1]]
    solutions = solve_all(LCP(matrix, np.zeros(4)))
    assert {s.active for s in solutions} == {(False,) * 4, (True, True, False, False)}
    assert all(s.varying == (True, True, False, False) for s in solutions)


def test_solve_all_refuses_too_many_pairs():
    n = ENUMERATION_LIMIT + 1
    with pytest.raises(InputError, match="solve_lemke"):
        solve_all(LCP(np.eye(n), np.ones(n)))


@settings(max_examples=200)
@given(problems())
@example(([[0, 1, 0], [-1, 1, 0], [3, 0, -1]], [0, 1, 0]))  # rounding leaves z_2 = 1e-17
def test_solve_all_agrees_with_rational_arithmetic_for_small_integers(problem):
    vertices = exact_vertices(*problem)
    lcp = LCP(*problem)
    solutions = solve_all(lcp)
    assert bool(solutions) == bool(vertices)
    for vertex in (v for v, full in vertices.items() if full):
        assert among(vertex, [s.z for s in solutions])
    for s in solutions:
        assert s.residual <= RESIDUAL_TOLERANCE
        assert np.all(s.z >= 0) and np.all(s.z[~np.array(s.active)] == 0)
        if s.isolated:
            assert among(s.z, vertices)


@given(problems(st.integers(2, 3)), st.randoms(use_true_random=False))
def test_solve_all_is_unchanged_under_renumbering(problem, random):
    matrix, offset = (np.array(part, dtype=float) for part in problem)
    order = list(range(offset.size))
    random.shuffle(order)
    direct = [s for s in solve_all(LCP(matrix, offset)) if s.isolated]
    renumbered = solve_all(LCP(matrix[np.ix_(order, order)], offset[order]))
    assert len(direct) == sum(bool(s.isolated) for s in renumbered)
    assert all(among(s.z[order], [r.z for r in renumbered]) for s in direct)


@given(dominant_problems())
def test_solve_all_finds_exactly_one_for_p_matrices(problem):
    assert is_p_matrix(problem[0])
    (solution,) = solve_all(LCP(*problem))
    assert solution.isolated
