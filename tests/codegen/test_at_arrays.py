"""Formulas over arrays: CasADi gives what they say."""

from __future__ import annotations

import numpy as np
import sympy as sp

from painleve_sym.codegen import evaluate
from painleve_sym.codegen.evaluate import at_arrays, expression_function

X, Y, P = sp.symbols("x y p", real=True)
FORMULAS = (X * sp.sin(Y) + P, sp.sqrt(X**2 + P) / (1 + Y**2), sp.Integer(3), P**2)


def expected(x, y, p):
    x, y = np.broadcast_arrays(x, y)
    return np.stack(
        [x * np.sin(y) + p, np.sqrt(x**2 + p) / (1 + y**2), np.full(x.shape, 3.0), p**2 + 0 * x]
    )


def test_arrays_equals_numpy_over_a_grid_of_broadcast_arrays():
    f = expression_function("f", FORMULAS, (X, Y, P))
    x, y = np.linspace(-2, 2, 71)[:, None], np.linspace(-3, 3, 83)[None, :]
    computed = at_arrays(f, (x, y, 1.5))
    assert computed.shape == (4, 71, 83)
    np.testing.assert_allclose(computed, expected(x, y, 1.5), rtol=4e-15, atol=4e-15)


def test_arrays_takes_strided_integer_and_single_values():
    f = expression_function("f", FORMULAS, (X, Y, P))
    x = np.arange(24).reshape(4, 6).T[::2]
    np.testing.assert_allclose(at_arrays(f, (x, 0.5, 2)), expected(x, 0.5, 2.0), rtol=4e-15)
    np.testing.assert_allclose(at_arrays(f, (1, 0.5, 2)), expected(1.0, 0.5, 2.0), rtol=4e-15)


def test_arrays_of_no_points_is_empty():
    f = expression_function("f", FORMULAS, (X, Y, P))
    assert at_arrays(f, (np.empty(0), 1.0, 1.0)).shape == (4, 0)


def test_arrays_blocks_join(monkeypatch):
    monkeypatch.setattr(evaluate, "BLOCK", 7)
    f = expression_function("f", FORMULAS, (X, Y, P))
    x = np.linspace(0, 1, 50)
    np.testing.assert_allclose(at_arrays(f, (x, 2 * x, 1.0)), expected(x, 2 * x, 1.0), rtol=4e-15)


def test_arrays_derivatives_follow_the_expressions():
    formulas = (X**2 * Y, sp.sin(X) + P * Y)
    f = expression_function("f", formulas, (X, Y, P), (X, Y))
    x, y = np.array([0.3, -1.2]), np.array([2.0, 0.7])
    want = [x**2 * y, np.sin(x) + 3 * y, 2 * x * y, x**2, np.cos(x), 3 + 0 * x]
    np.testing.assert_allclose(at_arrays(f, (x, y, 3.0)), want, rtol=4e-15)


def test_arrays_outside_the_reals_is_nan_without_a_warning():
    f = expression_function("f", (sp.sqrt(X), sp.log(X)), (X,))
    computed = at_arrays(f, [np.array([-1.0, 1.0])])
    assert np.isnan(computed[:, 0]).all()
    assert computed[:, 1].tolist() == [1.0, 0.0]
