"""Enumeration, Lemke's method and matrix classes, against exact rational arithmetic."""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from painleve_sym.complementarity import (
    LCP,
    LemkeStatus,
    is_copositive,
    is_p_matrix,
    residual,
    solve_all,
    solve_lemke,
)
from painleve_sym.complementarity.lcp import ENUMERATION_LIMIT, RESIDUAL_TOLERANCE, equilibrate
from painleve_sym.errors import InputError

HORN = np.array(
    [[1, -1, 1, 1, -1], [-1, 1, -1, 1, 1], [1, -1, 1, -1, 1], [1, 1, -1, 1, -1], [-1, 1, 1, -1, 1]]
)


# --- the oracle -------------------------------------------------------------------------------


def unique_solution(rows, values):
    """Solve rows x = values over the rationals; None unless there is exactly one solution."""
    table = [
        [*map(Fraction, row), Fraction(value)] for row, value in zip(rows, values, strict=True)
    ]
    unknowns = len(table[0]) - 1
    for k in range(unknowns):
        pivot = next((i for i in range(k, len(table)) if table[i][k] != 0), None)
        if pivot is None:
            return None
        table[k], table[pivot] = table[pivot], table[k]
        table[k] = [entry / table[k][k] for entry in table[k]]
        for i in range(len(table)):
            if i != k:
                table[i] = [a - table[i][k] * b for a, b in zip(table[i], table[k], strict=True)]
    return (
        None if any(row[-1] != 0 for row in table[unknowns:]) else [r[-1] for r in table[:unknowns]]
    )


def exact_vertices(matrix, offset):
    """Return the basic complementary solutions z, and which of them have a full basis.

    The problem is solvable if and only if it has one of these (no line fits into z, w >= 0).
    """
    n = len(offset)
    vertices = {}
    for kinds in itertools.product("wz-", repeat=n):
        basis = [(kind, j) for j, kind in enumerate(kinds) if kind != "-"]
        if basis:
            rows = [
                [int(i == j) if kind == "w" else -matrix[i][j] for kind, j in basis]
                for i in range(n)
            ]
            values = unique_solution(rows, offset)
        else:
            values = [] if not any(offset) else None
        if values is None or any(value < 0 for value in values):
            continue
        z = [Fraction(0)] * n
        for (kind, j), value in zip(basis, values, strict=True):
            z[j] = value if kind == "z" else z[j]
        vertices[tuple(z)] = vertices.get(tuple(z), False) or "-" not in kinds
    return vertices


def among(z, candidates):
    return any(np.allclose(z, np.array(c, dtype=float), rtol=1e-9, atol=1e-12) for c in candidates)


entries = st.integers(-3, 3)
orders = st.integers(1, 3)
# Many magnitudes, but none that overflow when multiplied.
magnitudes = st.builds(lambda a, k: a * 10.0**k, entries, st.integers(-9, 9))


@st.composite
def problems(draw, sizes=orders, entry=entries):
    n = draw(sizes)
    matrix = draw(st.lists(st.lists(entry, min_size=n, max_size=n), min_size=n, max_size=n))
    return matrix, draw(st.lists(entry, min_size=n, max_size=n))


@st.composite
def dominant_problems(draw):
    """Strictly row-dominant matrices with a positive diagonal: P-matrices, rarely symmetric."""
    matrix, offset = draw(problems(st.integers(1, 4)))
    for i, row in enumerate(matrix):
        row[i] = 1 + sum(abs(entry) for j, entry in enumerate(row) if j != i)
    return matrix, offset


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
    powers = st.lists(st.integers(-20, 20).map(lambda k: 2.0**k), min_size=n, max_size=n)
    row, column = np.array(data.draw(powers)), np.array(data.draw(powers))
    z = np.array(data.draw(st.lists(entries, min_size=n, max_size=n)), dtype=float)
    scaled = LCP(row[:, None] * matrix / column, row * offset)
    assert residual(scaled, column * z) == residual(LCP(matrix, offset), z)


@given(problems(entry=magnitudes))
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


@settings(max_examples=300, deadline=None)
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


@settings(deadline=None)
@given(problems(st.integers(2, 3)), st.randoms(use_true_random=False))
def test_solve_all_is_unchanged_under_renumbering(problem, random):
    matrix, offset = (np.array(part, dtype=float) for part in problem)
    order = list(range(offset.size))
    random.shuffle(order)
    direct = [s for s in solve_all(LCP(matrix, offset)) if s.isolated]
    renumbered = solve_all(LCP(matrix[np.ix_(order, order)], offset[order]))
    assert len(direct) == sum(bool(s.isolated) for s in renumbered)
    assert all(among(s.z[order], [r.z for r in renumbered]) for s in direct)


@settings(deadline=None)
@given(dominant_problems())
def test_solve_all_finds_exactly_one_for_p_matrices(problem):
    assert is_p_matrix(problem[0])
    (solution,) = solve_all(LCP(*problem))
    assert solution.isolated


# --- Lemke ------------------------------------------------------------------------------------


@settings(max_examples=200, deadline=None)
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


@settings(deadline=None)
@given(dominant_problems())
def test_solve_lemke_succeeds_for_p_matrices(problem):
    assert solve_lemke(LCP(*problem)).status is LemkeStatus.SOLVED


@settings(deadline=None)
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


def test_solve_lemke_reports_the_step_limit_when_pivots_run_out():
    result = solve_lemke(LCP(np.eye(3), -np.ones(3)), max_pivots=1)
    assert result.status is LemkeStatus.STEP_LIMIT and result.pivots == 1
    assert "max_pivots" in result.status.advice


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


# --- matrix classes ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("matrix", "expected"),
    [
        (np.eye(3), True),
        ([[1, 5], [0, 1]], True),
        ([[1, 2], [2, 1]], False),
        ([[0]], False),
        ([[1, 1], [1, 1]], False),
        ([[1e-8, 0], [0, 1e8]], True),
    ],
)
def test_is_p_matrix_decides_for_known_matrices(matrix, expected):
    assert is_p_matrix(matrix) is expected


@pytest.mark.parametrize(
    ("matrix", "plain", "strict"),
    [
        ([[0]], True, False),
        ([[-1]], False, False),
        (np.eye(2), True, True),
        ([[1, -1], [-1, 1]], True, False),
        ([[1, -1.01], [-1.01, 1]], False, False),
        ([[0, 1], [1, 0]], True, False),
        ([[0, 3], [-1, 0]], True, False),  # only the symmetric part counts
        (HORN, True, False),
        (HORN + 1e-6 * np.eye(5), True, True),
        (HORN - 1e-6 * np.eye(5), False, False),
    ],
)
def test_is_copositive_decides_for_known_matrices(matrix, plain, strict):
    assert is_copositive(matrix) is plain
    assert is_copositive(matrix, strict=True) is strict


@given(st.lists(entries, min_size=6, max_size=6))
def test_is_copositive_agrees_with_the_closed_form_for_three_rows(values):
    a, b, c, d, e, f = values
    matrix = [[a, d, e], [d, b, f], [e, f, c]]
    # Hadeler (1983), theorem 4: order 3 in closed form.
    closed = min(a, b, c) >= 0
    if closed:
        p, q, r = d + np.sqrt(a * b), e + np.sqrt(a * c), f + np.sqrt(b * c)
        left = np.sqrt(a * b * c) + d * np.sqrt(c) + e * np.sqrt(b) + f * np.sqrt(a)
        closed = min(p, q, r) >= -1e-12 and left + np.sqrt(max(2 * p * q * r, 0)) >= -1e-9
    assert is_copositive(matrix) is bool(closed)


@settings(deadline=None)
@given(problems())
def test_is_copositive_implies_that_lemke_solves_when_strict(problem):
    if is_copositive(problem[0], strict=True):
        assert solve_lemke(LCP(*problem)).status is LemkeStatus.SOLVED


@pytest.mark.parametrize("check", [is_p_matrix, is_copositive])
def test_matrix_classes_refuse_large_or_oblong_matrices(check):
    with pytest.raises(InputError, match="Fix: test a smaller block"):
        check(np.eye(ENUMERATION_LIMIT + 1))
    with pytest.raises(InputError, match="need \\(n, n\\)"):
        check(np.ones((2, 3)))
