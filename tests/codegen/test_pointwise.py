"""Formulas over arrays: CasADi gives what they say."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from painleve_sym.codegen import evaluate
from painleve_sym.codegen.pointwise import Pointwise
from painleve_sym.errors import InputError, TranslationError

X, Y, P = sp.symbols("x y p", real=True)
FORMULAS = (X * sp.sin(Y) + P, sp.sqrt(X**2 + P) / (1 + Y**2), sp.Integer(3), P**2)


def expected(x, y, p):
    x, y = np.broadcast_arrays(x, y)
    return np.stack(
        [x * np.sin(y) + p, np.sqrt(x**2 + p) / (1 + y**2), np.full(x.shape, 3.0), p**2 + 0 * x]
    )


def test_pointwise_equals_numpy_over_a_grid_of_broadcast_arrays():
    f = Pointwise(FORMULAS, (X, Y, P))
    x, y = np.linspace(-2, 2, 71)[:, None], np.linspace(-3, 3, 83)[None, :]
    computed = f({X: x, Y: y, P: 1.5})
    assert computed.shape == (4, 71, 83)
    np.testing.assert_allclose(computed, expected(x, y, 1.5), rtol=4e-15, atol=4e-15)


def test_pointwise_takes_strided_integer_and_single_values():
    f = Pointwise(FORMULAS, (X, Y, P))
    x = np.arange(24).reshape(4, 6).T[::2]
    np.testing.assert_allclose(f({X: x, Y: 0.5, P: 2}), expected(x, 0.5, 2.0), rtol=4e-15)
    np.testing.assert_allclose(f({X: 1, Y: 0.5, P: 2}), expected(1.0, 0.5, 2.0), rtol=4e-15)


def test_pointwise_of_no_points_is_empty():
    f = Pointwise(FORMULAS, (X, Y, P))
    assert f({X: np.empty(0), Y: 1.0, P: 1.0}).shape == (4, 0)


def test_pointwise_blocks_join(monkeypatch):
    monkeypatch.setattr(evaluate, "BLOCK", 7)
    f = Pointwise(FORMULAS, (X, Y, P))
    x = np.linspace(0, 1, 50)
    np.testing.assert_allclose(f({X: x, Y: 2 * x, P: 1.0}), expected(x, 2 * x, 1.0), rtol=4e-15)


def test_pointwise_derivatives_follow_the_expressions():
    formulas = (X**2 * Y, sp.sin(X) + P * Y)
    f = Pointwise(formulas, (X, Y, P), derivatives=(X, Y))
    x, y = np.array([0.3, -1.2]), np.array([2.0, 0.7])
    want = [x**2 * y, np.sin(x) + 3 * y, 2 * x * y, x**2, np.cos(x), 3 + 0 * x]
    np.testing.assert_allclose(f({X: x, Y: y, P: 3.0}), want, rtol=4e-15)


def test_pointwise_outside_the_reals_is_nan_without_a_warning():
    f = Pointwise((sp.sqrt(X), sp.log(X)), (X,))
    computed = f({X: np.array([-1.0, 1.0])})
    assert np.isnan(computed[:, 0]).all()
    assert computed[:, 1].tolist() == [1.0, 0.0]


def test_pointwise_refuses_what_it_cannot_use():
    with pytest.raises(InputError, match="no expressions"):
        Pointwise((), (X,))
    with pytest.raises(TranslationError, match="symbol y"):
        Pointwise((X + Y,), (X,))
    f = Pointwise((X + Y,), (X, Y))
    with pytest.raises(InputError, match="no value of y"):
        f({X: 1.0})
    with pytest.raises(InputError, match="one shape"):
        f({X: np.zeros(3), Y: np.zeros(4)})
