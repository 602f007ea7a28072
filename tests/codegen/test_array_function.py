"""Compiled formulas over arrays give what CasADi gives, and one point the bits of many."""

from __future__ import annotations

import numpy as np
import sympy as sp

from painleve_sym.codegen.array_function import ArrayFunction
from painleve_sym.codegen.evaluate import at_points, expression_function

X, Y, P = sp.symbols("x y p", real=True)
FORMULAS = (X * sp.sin(Y) + P, sp.sqrt(X**2 + P) / (1 + Y**2), sp.Integer(3), sp.log(X))


def test_compiled_formulas_equal_those_of_casadi_also_outside_the_reals():
    function = expression_function("test", FORMULAS, (X, Y, P))
    compiled = ArrayFunction.of(function)
    rng = np.random.default_rng(1)
    points = np.ascontiguousarray(rng.uniform(-2, 2, (5001, 3)))
    rows = compiled.at_points([np.ascontiguousarray(column) for column in points.T], 5001)
    np.testing.assert_allclose(rows, at_points(function, points).T, rtol=4e-15, atol=4e-15)
    assert np.isnan(rows[3]).any() and np.isnan(rows[1]).any()
    for k in (0, 1, 5000):
        np.testing.assert_array_equal(compiled.at_point(points[k].tolist()), rows[:, k])


def test_one_library_serves_all_values(cache):
    for value in (1.0, 2.0):
        compiled = ArrayFunction.of(expression_function("test", FORMULAS, (X, Y, P)))
        assert compiled.at_point([1.0, 0.0, value])[0] == value
    assert len(list(cache.glob("*.so"))) == 1
