"""SymPy and CasADi must mean the same: values and derivatives of everything that is translated."""

from __future__ import annotations

import math
import random

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.codegen import bridge
from painleve_sym.codegen.bridge import Translator
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.errors import TranslationError
from painleve_sym.laws.compliance import ramp

X, Y, Z = SYMBOLS = sp.symbols("x y z", real=True)
SX = ca.SX.sym("x", 3)


def translated(expr):
    """Value and gradient of the translation as one CasADi function."""
    f = Translator(dict(zip(SYMBOLS, ca.vertsplit(SX), strict=True)))(expr)
    return ca.Function("f", [SX], [f, ca.jacobian(f, SX)])


def exact(expr, point):
    """Value and gradient by SymPy with 30 digits."""
    at = dict(zip(SYMBOLS, map(sp.Float, point), strict=True))
    # A ramp is evaluated off its kink.
    plain = [e.replace(ramp, lambda a: sp.Max(a, 0)) for e in (expr, *gradient(expr))]
    return [float(sp.N(e.subs(at).doit(), 30)) for e in plain]


def gradient(expr):
    return [sp.diff(expr, s) for s in SYMBOLS]


def assert_same(expr, point):
    value, slope = translated(expr)(list(point))
    ours = np.array([float(value), *np.array(ca.densify(slope)).ravel()])
    np.testing.assert_allclose(ours, exact(expr, point), rtol=1e-12, atol=1e-13)


# Where the argument of each operator of the table may lie, off its kinks.
RANGES = {
    sp.sin: (-4, 4),
    sp.cos: (-4, 4),
    sp.tan: (-1.4, 1.4),
    sp.asin: (-0.9, 0.9),
    sp.acos: (-0.9, 0.9),
    sp.atan: (-5, 5),
    sp.sinh: (-3, 3),
    sp.cosh: (-3, 3),
    sp.tanh: (-3, 3),
    sp.exp: (-5, 5),
    sp.log: (0.01, 9),
    sp.Abs: (-2, 2),
    sp.sign: (-2, 2),
    ramp: (-2, 2),
}


def test_every_operator_of_the_table_is_tested():
    # A floor counts strobes; it has no slope to compare.
    assert {*RANGES, sp.floor} == {*bridge._UNARY, ramp}
    floor = translated(sp.floor(X))
    assert [float(floor([x, 0.3, 0.7])[0]) for x in (-0.5, 0.0, 2.7)] == [-1.0, 0.0, 2.0]


@pytest.mark.parametrize("operator", RANGES, ids=lambda f: f.__name__)
def test_operator_has_the_same_value_and_slope(operator):
    rng = random.Random(operator.__name__)
    for _ in range(20):
        x = rng.uniform(*RANGES[operator])
        assert_same(operator(X), (x, 0.3, 0.7))


@pytest.mark.parametrize("operator", RANGES, ids=lambda f: f.__name__)
def test_operator_takes_an_expression(operator):
    # The argument stays within the range: 0.4 ± 0.2 suits every operator.
    assert_same(operator(sp.Rational(2, 5) + X * Y / 5), (0.7, -0.9, 0.0))


@pytest.mark.parametrize(
    "expr",
    [
        X + Y + Z + 1,
        X - Y,
        X * Y * Z,
        -X * Y,
        X / Y,
        X / (Y * Z**2),
        1 / (X * Y),
        X**2,
        X**3,
        X**7,
        X**-1,
        X**-2,
        X**-5,
        sp.sqrt(X),
        1 / sp.sqrt(X),
        X ** sp.Rational(3, 2),
        X ** sp.Rational(-3, 2),
        X ** sp.Float(1.764),
        X**Y,
        X ** (-Y),
        2**X,
        sp.pi * X + sp.E,
        sp.sqrt(2) * X + sp.Rational(1, 3),
        sp.Max(X, Y),
        sp.Max(X, Y, Z),
        sp.Min(X, Y, Z),
        sp.Min(X, 0.25),
        sp.atan2(X, Y),
        sp.Heaviside(X - Y, 0),
        sp.exp(-X) * sp.sin(Y) ** 2 / (1 + sp.cos(Z) ** 2),
        ramp((X - Y / 4) / Z) ** sp.Float(1.764),
    ],
    ids=str,
)
def test_expression_has_the_same_value_and_slope(expr):
    rng = random.Random(str(expr))
    for _ in range(10):
        assert_same(expr, [rng.uniform(0.2, 3.0) for _ in SYMBOLS])


@pytest.mark.parametrize("point", [(-1.3, 0.4, 1.0), (-0.2, -0.7, 1.0), (0.9, -0.1, 1.0)])
def test_signs_are_kept(point):
    for expr in (X**2, X**3, X**-3, X * Y, X / Y, sp.atan2(X, Y), sp.Max(X, Y), sp.Heaviside(X)):
        assert_same(expr, point)


LEAVES = st.sampled_from([X, Y, Z, sp.Integer(2), sp.Rational(1, 3), sp.Float(0.7)])


def _grow(inner):
    pair = st.tuples(inner, inner)
    return st.one_of(
        pair.map(lambda p: p[0] + p[1]),
        pair.map(lambda p: p[0] * p[1]),
        pair.map(lambda p: p[0] / (2 + sp.sin(p[1]))),
        inner.map(sp.sin),
        inner.map(sp.atan),
        inner.map(lambda e: sp.sqrt(1 + e**2)),
        inner.map(lambda e: (1 + e**2) ** sp.Float(0.8)),
    )


@settings(max_examples=50)
@given(
    expr=st.recursive(LEAVES, _grow, max_leaves=8),
    point=st.tuples(*[st.floats(-2, 2)] * 3),
)
def test_any_composition_has_the_same_value_and_slope(expr, point):
    value, slope = translated(expr)(list(point))
    ours = np.array([float(value), *np.array(ca.densify(slope)).ravel()])
    expected = exact(expr, point)
    np.testing.assert_allclose(ours, expected, rtol=1e-10, atol=1e-10 * max(map(abs, expected)))


@pytest.mark.parametrize("exponent", [1.0, 1.5, 1.764, 3.0, 2.764])
@pytest.mark.parametrize("x", [0.0, -1e-300, -1e-12, -1.0])
def test_real_power_of_a_ramp_vanishes_with_its_derivatives(exponent, x):
    power = translated(ramp(X) ** sp.Float(exponent))
    value, slope = power([x, 0, 0])
    assert float(value) == 0
    assert not np.array(ca.densify(slope)).any()
    second = ca.Function("h", [SX], [ca.hessian(power(SX)[0], SX)[0]])
    assert not np.array(ca.densify(second([x, 0, 0]))).any()


def test_real_power_of_a_ramp_is_the_plain_power_inside():
    power = translated(ramp(X) ** sp.Float(1.764))
    for x in (1e-9, 1e-6, 0.3):
        value, slope = power([x, 0, 0])
        assert float(value) == pytest.approx(x**1.764, rel=1e-15)
        assert float(slope[0]) == pytest.approx(1.764 * x**0.764, rel=1e-14)


def test_exact_zero_stays_zero():
    # a·d − b·c with equal products: nothing may be reordered into a remainder.
    f = translated(X * Y - Z * Y)
    assert float(f([0.1, 0.3, 0.1])[0]) == 0.0


def test_common_parts_are_translated_once():
    shared = sp.sin(X * Y)
    translate = Translator({X: SX[0], Y: SX[1]})
    a, b = translate(shared + 1), translate(shared * 2)
    f = ca.Function("f", [SX], [a, b])
    sines = [f.instruction_id(i) for i in range(f.n_instructions())].count(ca.OP_SIN)
    assert sines == 1


def test_vector_keeps_order_and_may_be_empty():
    translate = Translator({X: SX[0], Y: SX[1]})
    column = ca.Function("f", [SX], [translate.vector([Y, X, sp.Integer(5)])])
    assert np.array(column([1, 2, 0])).ravel().tolist() == [2, 1, 5]
    assert translate.vector([]).shape == (0, 1)


@pytest.mark.parametrize(
    ("expr", "name"),
    [
        (sp.gamma(X), "gamma"),
        (sp.erf(X) + 1, "erf"),
        (sp.Function("force")(X), "force"),
        (sp.sin(sp.ceiling(X)), "ceiling"),
        (sp.Derivative(sp.Function("q")(X), X), "Derivative"),
    ],
    ids=str,
)
def test_unsupported_function_is_named(expr, name):
    with pytest.raises(TranslationError, match=rf"{name}.*no CasADi counterpart.*Fix: use one of"):
        translated(expr)


def test_undeclared_symbol_is_named():
    with pytest.raises(TranslationError, match=r"symbol mass is not a state.*Fix: declare it"):
        translated(X * sp.Symbol("mass"))


def test_a_symbol_of_other_assumptions_is_another_symbol():
    with pytest.raises(TranslationError, match="symbol x "):
        translated(sp.Symbol("x", positive=True))


def test_numbers_evaluates_at_a_point():
    computed = numbers([X + Y, sp.sin(X), sp.Integer(3), sp.pi / 2], {X: 0.5, Y: 2.0})
    np.testing.assert_allclose(computed, [2.5, math.sin(0.5), 3.0, math.pi / 2], rtol=1e-15)


def test_conditions_are_one_or_zero_and_nan_holds_none():
    condition = sp.And(sp.Gt(X, 0), sp.Le(Y, 1), sp.Or(sp.Eq(X, 2), sp.Lt(Y, 0)))
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    holds = ca.Function("f", [x, y], [Translator({X: x, Y: y})(condition)])
    for at, expected in (((2, 1), 1), ((1, 1), 0), ((1, -1), 1), ((-1, -1), 0), ((2, 1.5), 0)):
        assert float(holds(*at)) == expected
    assert float(holds(math.nan, -1)) == float(holds(2, math.nan)) == 0
    assert float(Translator({})(sp.true)) == 1 and float(Translator({})(sp.false)) == 0


def test_a_condition_without_counterpart_is_named():
    with pytest.raises(TranslationError, match="Xor"):
        Translator({X: ca.SX.sym("x")})(sp.Xor(X > 0, X > 1))


@pytest.mark.parametrize(
    ("x", "expected"), [(2.0, 0.5), (0.0, 3.0), (-1.0, 7.0), (math.nan, 7.0), (math.inf, 0.0)]
)
def test_the_first_case_that_holds_counts_whatever_the_others_give(x, expected):
    """1/x is infinite at 0, and log(x) not a number below it."""
    cases = sp.Piecewise(
        (1 / X, sp.Gt(X, 0)),
        (3 + sp.Piecewise((sp.log(X), sp.Gt(X, 0)), (0, True), evaluate=False), sp.Eq(X, 0)),
        (7, True),
        evaluate=False,
    )
    assert numbers([cases], {X: x})[0] == expected


def test_no_case_that_holds_gives_nan():
    assert math.isnan(numbers([sp.Piecewise((1, sp.Gt(X, 0)), evaluate=False)], {X: -1.0})[0])


@pytest.mark.parametrize("number", [sp.nan, sp.zoo, sp.I])
def test_number_that_is_not_real_has_no_counterpart(number):
    with pytest.raises(TranslationError, match="need finite real values"):
        translated(number)
