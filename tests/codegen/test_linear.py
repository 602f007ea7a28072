"""Small linear systems as expressions, against NumPy, and their derivatives against differences."""

import casadi as ca
import numpy as np
import pytest

from painleve_sym.codegen.linear import determinant, least_solution, solution


def _rows(m):
    return [[m[i, j] for j in range(m.shape[1])] for i in range(m.shape[0])]


def _least(matrix, right, weight=None):
    k, m = right.shape
    A, r = ca.SX.sym("A", k, k), ca.SX.sym("r", k, m)
    e = ca.SX.sym("e", 0 if weight is None else k)
    weights = [] if weight is None else [e[i] for i in range(k)]
    x = least_solution(_rows(A), _rows(r), weights)
    f = ca.Function("f", [A, r, e], [ca.vertcat(*[ca.horzcat(*row) for row in x])])
    return np.array(f(matrix, right, [] if weight is None else weight))


def _spd(rng, size, spread=1.0):
    Q = np.linalg.qr(rng.normal(size=(size, size)))[0]
    scale = np.diag(10.0 ** rng.uniform(-spread, spread, size))
    return scale @ Q @ np.diag(rng.uniform(0.2, 2, size)) @ Q.T @ scale


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_least_solution_of_a_regular_system_is_the_solution(size):
    rng = np.random.default_rng(size)
    for _ in range(20):
        A, right = _spd(rng, size, 3.0), rng.normal(size=(size, 2))
        expected = np.linalg.solve(A, right)
        computed = _least(A, right)
        assert np.allclose(A @ computed, right, rtol=0, atol=1e-11 * np.abs(A).max())
        assert np.allclose(computed, expected, rtol=1e-9)


@pytest.mark.parametrize("weight", [(1.0, 1.0), (3.0, 1.0), (0.02, 5.0)])
def test_least_solution_of_a_singular_pair_is_shared_by_weight(weight):
    # Two contacts with one line of action: w (T1 + T2) = r.
    w, r = 1.7, 0.9
    computed = _least(np.full((2, 2), w), np.full((2, 1), r), np.array(weight))[:, 0]
    assert computed.sum() == pytest.approx(r / w, rel=1e-12)
    assert computed == pytest.approx(r / w * np.array(weight) / sum(weight), rel=1e-6)


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.1])
def test_shares_that_are_not_determined_carry_no_amplified_rounding(turn):
    # One line of action, loads that agree but for rounding.
    rng = np.random.default_rng(3)
    line = np.array([np.cos(turn), np.sin(turn), 0.7])
    A = np.full((2, 2), line @ line)
    for _ in range(50):
        load = np.full((2, 1), line @ rng.normal(size=3))
        load[0] = np.nextafter(load[0], 9.0)
        weight = np.abs(load[0, 0]) / A[0, 0] * rng.uniform(0.3, 3, 2)
        shares = _least(A, load, weight)[:, 0] / weight
        assert abs(shares[0] - shares[1]) < 1e-12 * abs(shares).max()


def test_what_a_nearly_singular_system_demands_is_kept():
    A = np.array([[1.0, 1 - 1e-10], [1 - 1e-10, 1.0]])
    right = np.array([[1.0], [1.0 - 1e-6]])
    computed = _least(A, right, np.ones(2))[:, 0]
    assert computed.sum() == pytest.approx(1.0, rel=1e-5)
    assert abs(computed[0] - computed[1]) > 100


def test_least_solution_without_ease_is_that_of_least_norm():
    rng = np.random.default_rng(5)
    for _ in range(20):
        J = rng.normal(size=(4, 2))
        J /= np.linalg.norm(J, axis=1)[:, None]  # a unit diagonal: the scaled norm is the norm
        A, force = J @ J.T, rng.normal(size=(4, 1))
        computed = _least(A, A @ force)
        assert np.allclose(computed, np.linalg.pinv(A) @ A @ force, atol=1e-6)
        assert np.allclose(A @ computed, A @ force, atol=1e-12)


@pytest.mark.parametrize("tilt", [1e-1, 1e-2, 3e-3])
def test_least_solution_is_exact_down_to_small_eigenvalues(tilt):
    A = np.array([[1.0, 1 - tilt**2], [1 - tilt**2, 1.0]])
    force = np.array([[0.3], [-0.7]])
    assert np.allclose(_least(A, A @ force, np.ones(2)), force, rtol=1e-6, atol=0)


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_solution_and_determinant_agree_with_numpy(size):
    rng = np.random.default_rng(10 + size)
    A, r, s = ca.SX.sym("A", size, size), ca.SX.sym("r", size), ca.SX.sym("s", size)
    x, whole = solution(_rows(A), [r[i] for i in range(size)], [s[i] for i in range(size)])
    f = ca.Function("f", [A, r, s], [ca.vertcat(*x), whole, determinant(_rows(A))])
    for _ in range(30):
        # Not symmetric, as friction makes it.
        matrix, right = rng.normal(size=(size, size)) + np.eye(size), rng.normal(size=size)
        scales = 10.0 ** rng.uniform(-4, 4, size)
        scaled = matrix * np.sqrt(np.outer(scales, scales))
        computed, unit, plain = (np.array(v).ravel() for v in f(scaled, right, scales))
        assert plain[0] == pytest.approx(np.linalg.det(scaled), rel=1e-9)
        if np.linalg.cond(matrix) < 1e3:
            root = np.sqrt(scales)
            expected = np.linalg.solve(matrix, right / root) / root
            tolerance = 1e-10 if size <= 2 else 1e-6
            assert np.allclose(computed, expected, rtol=0, atol=tolerance * np.abs(expected).max())
        if size <= 2:
            assert unit[0] == pytest.approx(np.linalg.det(matrix), rel=1e-9)


def test_solution_of_three_dependent_rows_satisfies_them():
    # Three feet of one body: three normal forces, two rows that are independent.
    x = np.array([-1.0, 0.2, 1.0])
    A = 1 / 3 + np.outer(x, x)
    A = A + 1e-3 * np.outer(x**0, [1.0, -1, 0.5])  # friction: not symmetric, still of rank 2
    force = A.T @ np.array([1.0, 2.0, -1.0])
    computed, _ = solution(_rows(ca.SX(A)), list(map(ca.SX, A @ force)), [ca.SX(1)] * 3)
    value = np.array([float(v) for v in computed])
    assert np.allclose(A @ value, A @ force, atol=1e-12)
    assert np.allclose(value, np.linalg.pinv(A) @ A @ force, atol=1e-6)


@pytest.mark.parametrize("singular", [False, True])
def test_derivatives_of_the_least_solution_agree_with_differences(singular):
    t = ca.SX.sym("t")
    off = ca.SX(1) if singular else 0.4 + 0.1 * t
    matrix = [[2 + t, (2 + t) * off], [(2 + t) * off, 2 + t]]
    load = ca.sin(t)
    x = least_solution(matrix, [[load], [load]], [1 + t**2, ca.exp(t)])
    value = ca.vertcat(*[row[0] for row in x])
    f = ca.Function("f", [t], [value, ca.jtimes(value, t, ca.SX(1))])
    for at in (0.2, 0.9):
        # Shares of a singular pair carry the round-off over the ridge, 1e-7: no shorter step.
        h = 1e-3 if singular else 1e-5
        slope = (np.array(f(at + h)[0]) - np.array(f(at - h)[0])) / (2 * h)
        assert np.allclose(np.array(f(at)[1]), slope, rtol=0, atol=1e-4 * np.abs(slope).max())
