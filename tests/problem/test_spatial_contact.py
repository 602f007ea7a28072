"""One contact in space: every solution, the critical friction, and its bound over all normals."""

from __future__ import annotations

import itertools
import math
from collections import Counter

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize

import painleve_sym as ps
from painleve_sym.problem.risk import least_over_normals, slip_angle


def random_problem(rng):
    """Return W, b and μ of any shape and size."""
    root = rng.normal(size=(3, 3)) * 10 ** rng.uniform(-1, 1, size=(3, 1))
    W = root @ root.T * 10 ** rng.uniform(-3, 3)
    b = rng.normal(size=3) * 10 ** rng.uniform(-1.5, 1.5, size=3)
    return W, b, 10 ** rng.uniform(-2, 1.5)


def turned(angle):
    """Return the rotation by an angle about the normal, for vectors n, t1, t2."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def forces_of(answer):
    return np.array([s.force for s in answer.solutions()]).reshape(-1, 3)


# ---- oracles ----


def solutions_by_search(W, b, mu):
    """Return the forces by the scalar equation of the proof, scanned and bracketed by SciPy.

    In sticking F = F_s = -W⁻¹ b. A slip of acceleration x has (V_tt + s) x = -F_st with V = W⁻¹ and
    s = μ F_n/|x| > 0: one equation for s.
    """
    V = np.linalg.inv(W)
    stick = -V @ b
    forces = [np.zeros(3)] if b[0] >= 0 else []
    if math.hypot(*stick[1:]) <= mu * stick[0]:
        forces.append(stick)
    stretch, axes = np.linalg.eigh(V[1:, 1:])
    c, u = axes.T @ stick[1:], axes.T @ V[1:, 0]

    def acceleration(s):
        return -c / (stretch + np.asarray(s)[..., None])

    def excess(s):
        x = acceleration(s)
        return s * np.hypot(*x.T) - mu * (stick[0] + x @ u)

    grid = np.concatenate([[0.0], np.geomspace(1e-9, 1e9, 4000) * stretch[1]])
    values = excess(grid)
    for (low, high), (f, g) in zip(
        itertools.pairwise(grid), itertools.pairwise(values), strict=True
    ):
        if f * g < 0:
            s = brentq(excess, low, high, xtol=1e-300, rtol=1e-15)
            x = axes @ acceleration(s)
            forces.append(stick + V @ np.array([0.0, *x]))
    return np.array(sorted(forces, key=lambda f: f.tolist())).reshape(-1, 3)


def test_all_solutions_are_those_of_a_search():
    rng = np.random.default_rng(5)
    counts = Counter()
    for _ in range(100):
        W, b, mu = random_problem(rng)
        answer = ps.contact(W, b, mu)
        expected = solutions_by_search(W, b, mu)
        own = np.array(sorted(forces_of(answer).tolist()))
        assert own.shape == expected.shape
        assert np.allclose(own, expected, rtol=1e-6, atol=1e-7 * np.abs(own).max())
        counts[len(own)] += 1
    assert set(counts) == {1, 3}


def test_slip_solves_its_equations_in_fifty_digits():
    """A solution of three slips, polished by mpmath from the forces of the package."""
    rng = np.random.default_rng(29)
    seen = 0
    while seen < 10:
        W, b, mu = random_problem(rng)
        answer = ps.contact(W, b, mu)
        solutions = answer.solutions()
        for solution in solutions:
            if solution.mode is not ps.ContactMode.SLIP or len(solutions) != 3:
                continue
            seen += 1
            with mpmath.workdps(50):
                exact, free = mpmath.matrix(W.tolist()), mpmath.matrix(b.tolist())

                def equations(force, angle, exact=exact, free=free, mu=mu):
                    e = mpmath.cos(angle), mpmath.sin(angle)
                    F = mpmath.matrix([force, -mu * force * e[0], -mu * force * e[1]])
                    a = exact * F + free
                    return a[0], a[2] * e[0] - a[1] * e[1]

                start = solution.force[0], slip_angle(solution.direction)
                force, angle = mpmath.findroot(equations, start, tol=1e-60, maxsteps=50)
                way = [float(mpmath.cos(angle)), float(mpmath.sin(angle))]
            assert float(force) == pytest.approx(solution.force[0], rel=1e-7)
            assert way == pytest.approx(solution.direction, abs=1e-7)


# ---- the number of solutions ----


def count_solutions(seed, count):
    rng = np.random.default_rng(seed)
    return Counter(len(ps.contact(*random_problem(rng)).solutions()) for _ in range(count))


def test_at_rest_there_is_one_solution_or_three():
    counts = count_solutions(1, 500)
    assert set(counts) == {1, 3}
    assert counts[3] > 10


@pytest.mark.slow
def test_at_rest_there_is_one_solution_or_three_in_many_cases():
    counts = count_solutions(2, 100_000)
    assert set(counts) == {1, 3}


def test_on_a_border_there_may_be_two():
    """At b_n = 0 lift-off touches a slip of no force: not generic."""
    W = [[2.0, 1.5, 0.0], [1.5, 2.0, 0.0], [0.0, 0.0, 2.0]]
    sizes = [len(ps.contact(W, [b_n, 0.1, 0.0], 2.0).solutions()) for b_n in (-1e-3, 0.0, 1e-3)]
    assert sizes[0] in (1, 3) and sizes[2] in (1, 3) and sizes[1] == 2


def test_a_singular_mobility_may_have_none_or_a_continuum():
    rank_one = np.outer([1.0, 2.0, 0.0], [1.0, 2.0, 0.0])
    none = ps.contact(rank_one, [-1.0, -2.1, 0.5], 0.1)
    assert all(s.mode is not ps.ContactMode.STICK for s in none.solutions())
    held = ps.contact(rank_one, [-1.0, -2.0, 0.0], 1.0)
    stick = [s for s in held.solutions() if s.mode is ps.ContactMode.STICK]
    assert [s.isolated for s in stick] == [False]
    assert np.allclose(rank_one @ stick[0].force, [1.0, 2.0, 0.0])
    assert held.case is ps.ContactCase.HYPERSTATIC and stick[0].open_forces == 2


# ---- invariance ----


@given(st.integers(0, 2**32 - 1), st.floats(-7, 7), st.booleans())
def test_turning_the_tangents_changes_nothing(seed, angle, slides):
    rng = np.random.default_rng(seed)
    W, b, mu = random_problem(rng)
    v = rng.normal(size=2) * slides
    R = turned(angle)
    answer = ps.contact(W, b, mu, v)
    other = ps.contact(R @ W @ R.T, R @ b, mu, R[1:, 1:] @ v)
    assert other.case is answer.case
    assert [s.mode for s in other.solutions()] == [s.mode for s in answer.solutions()]
    size = np.abs(forces_of(answer)).max(initial=0)
    assert np.allclose(forces_of(other), forces_of(answer) @ R.T, rtol=1e-5, atol=1e-6 * size)
    (own,), (again,) = answer.coefficients, other.coefficients
    assert again.mu_P == pytest.approx(own.mu_P)
    assert again.least_over_normals == pytest.approx(own.least_over_normals, rel=1e-6)


@given(st.integers(0, 2**32 - 1), st.integers(-40, 40), st.integers(-60, 60))
def test_other_units_change_nothing(seed, mass, time):
    """Powers of four and two as units: the same bits."""
    W, b, mu = random_problem(np.random.default_rng(seed))
    W_unit, b_unit = 4.0**mass, 2.0**time
    answer, other = ps.contact(W, b, mu), ps.contact(W * W_unit, b * b_unit, mu)
    assert other.case is answer.case
    assert np.array_equal(forces_of(other), forces_of(answer) * (b_unit / W_unit))


@given(st.integers(0, 2**32 - 1), st.sampled_from([-1.0, 0.0, 1.0]))
def test_a_plane_of_symmetry_is_the_planar_contact(seed, slip):
    W, b, mu = random_problem(np.random.default_rng(seed))
    W[2, :2] = W[:2, 2] = b[2] = 0.0
    space = ps.contact(W, b, mu, [slip, 0.0])
    plane = ps.contact(W[:2, :2], b[:2], mu, slip)
    size = np.abs(forces_of(space)).max(initial=0)
    inside = [s for s in space.solutions() if abs(s.force[2]) <= 1e-9 * size]
    assert [s.mode for s in inside] == [s.mode.value.split("_")[0] for s in plane.solutions()]
    for one, other in zip(inside, plane.solutions(), strict=True):
        assert np.allclose(one.force[:2], other.force, rtol=1e-7, atol=1e-9 * size)
        assert one.direction == pytest.approx((*other.direction, 0.0), abs=1e-7)
    # Slips out of the plane come in pairs, mirror images of each other.
    outside = sorted(s.force[2] for s in space.solutions() if s not in inside)
    assert np.allclose(outside, [-f for f in reversed(outside)], rtol=1e-6)
    if slip:
        assert space.case is plane.case
        assert (space.A, space.B) == (plane.A, plane.B)


def test_a_sliding_contact_is_that_of_the_planar_kernel():
    rng = np.random.default_rng(8)
    for _ in range(50):
        W, b, mu = random_problem(rng)
        v = rng.normal(size=2)
        e = v / np.linalg.norm(v)
        turn = np.array([[1, 0, 0], [0, *e]])
        answer = ps.contact(W, b, mu, v)
        planar = ps.ContactProblem(turn @ W @ turn.T, turn @ b, mu, 1.0)
        assert len(answer.solutions()) == len(planar.solutions())
        for one, other in zip(answer.solutions(), planar.solutions(), strict=True):
            assert np.allclose(one.force, turn.T @ other.forces)
            assert np.allclose(one.acceleration, W @ one.force + b, atol=1e-9 * np.abs(b).max())
        A = W[0, 0] - mu * W[0, 1:] @ e
        assert pytest.approx(A, rel=1e-12, abs=1e-13 * W[0, 0]) == answer.A
        (own,) = answer.coefficients
        inside = own.sector is not None and e @ own.sector.direction > math.cos(
            own.sector.half_angle
        )
        assert own.direction == pytest.approx(e, rel=1e-12)
        assert inside == (answer.A < 0)


# ---- one number for all normals ----


def normal_first(normal):
    """Return a rotation whose first row is a unit vector."""
    full = np.linalg.qr(np.column_stack([normal, np.eye(3)]))[0]
    return (full * np.sign(full[:, 0] @ normal)).T


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1))
def test_no_normal_has_a_smaller_critical_friction(seed):
    rng = np.random.default_rng(seed)
    W, _, _ = random_problem(rng)
    bound = least_over_normals(W)
    for _ in range(20):
        R = normal_first(rng.normal(size=3))
        (answer,) = ps.contact(R @ W @ R.T, [1.0, 0.0, 0.0], 1.0).coefficients
        assert answer.mu_P >= bound * (1 - 1e-9)
        assert answer.least_over_normals == pytest.approx(bound, rel=1e-6)
    # The normal that has it lies between the axes of least and largest mobility.
    (low, _, high), axes = np.linalg.eigh(W)
    best = axes[:, 0] * math.sqrt(high / (low + high)) + axes[:, 2] * math.sqrt(low / (low + high))
    R = normal_first(best)
    (answer,) = ps.contact(R @ W @ R.T, [1.0, 0.0, 0.0], 1.0).coefficients
    assert answer.mu_P == pytest.approx(bound, rel=1e-6)


def test_the_bound_is_what_a_search_finds():
    rng = np.random.default_rng(12)
    W, _, _ = random_problem(rng)

    def critical(angles):
        a, b = angles
        n = np.array([math.cos(a) * math.cos(b), math.sin(a) * math.cos(b), math.sin(b)])
        pushed = W @ n
        return n @ pushed / np.linalg.norm(pushed - n * (n @ pushed))

    starts = rng.uniform(-math.pi, math.pi, size=(20, 2))
    options = {"xatol": 1e-10, "fatol": 1e-14}
    least = min(minimize(critical, s, method="Nelder-Mead", options=options).fun for s in starts)
    assert least == pytest.approx(least_over_normals(W), rel=1e-8)


def test_equal_mobilities_have_no_paradox():
    (own,) = ps.contact(np.eye(3), [-1.0, 0.0, 0.0], 100.0, [1.0, 0.0]).coefficients
    assert (own.mu_P, own.sector, own.least_over_normals) == (math.inf, None, math.inf)
    data = own.to_dict()
    assert (data["mu_P"], data["sector"], data["least_over_normals"]) == (None, None, None)


# ---- theorems of slip ----


@given(st.integers(0, 2**32 - 1))
def test_slip_slows_down_in_the_paradox(seed):
    """A(φ) < 0 implies k(φ) = e·(w - μ T e) < 0: a minor of W."""
    rng = np.random.default_rng(seed)
    W, _, mu = random_problem(rng)
    mu *= 10
    for angle in np.linspace(-math.pi, math.pi, 60):
        e = np.array([math.cos(angle), math.sin(angle)])
        if W[0, 0] - mu * W[0, 1:] @ e < 0:
            assert e @ (W[1:, 0] - mu * W[1:, 1:] @ e) < 0


# ---- bad input ----


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ({"mu": -0.1}, "mu: got -0.1, need a finite number >= 0"),
        ({"W": np.eye(4)}, r"need \(3, 3\) in space or \(2, 2\) in the plane"),
        ({"W": [[1, 2, 0], [2, 1, 0], [0, 0, 1]]}, "positive semidefinite"),
        ({"W": [[1, 2, 0], [0, 1, 0], [0, 0, 1]]}, "symmetric"),
        ({"b": [1.0, 2.0]}, r"b: got shape \(2,\), need \(3,\)"),
        ({"b": [1.0, math.nan, 0.0]}, "finite numbers"),
        ({"velocity": 1.0}, "two numbers along t1 and t2"),
        ({"velocity": [1.0, 2.0, 3.0]}, r"got shape \(3,\), need \(2,\)"),
    ],
)
def test_bad_input_has_one_sentence(given_, message):
    whole = {"W": np.eye(3), "b": [-1.0, 0.0, 0.0], "mu": 0.5, "velocity": [1.0, 0.0]}
    with pytest.raises(ps.InputError, match=message):
        ps.contact(**whole | given_)


def test_a_contact_at_rest_may_slip_three_ways_below_its_critical_friction():
    W = np.array([[10.0, -4.4, -13.7], [-4.4, 7.8, 3.5], [-13.7, 3.5, 20.1]])
    b, mu = np.array([-1.0, 2.07, -0.08]), 0.66
    angles = np.linspace(0, 2 * np.pi, 3601)
    A = W[0, 0] - mu * (W[0, 1] * np.cos(angles) + W[0, 2] * np.sin(angles))
    assert A.min() > 0.1 and np.linalg.eigvalsh(W)[0] > 0
    solutions = ps.contact(W, b, mu).solutions()
    assert len(solutions) == 3
    for s in solutions:
        F = s.force
        a = W @ F + b
        e = a[1:] / np.linalg.norm(a[1:])
        assert F[0] > 0 and abs(a[0]) < 1e-13 and np.linalg.norm(a[1:]) > 1e-3
        assert F[1:] == pytest.approx(-mu * F[0] * e, rel=1e-12)
