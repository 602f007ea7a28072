"""Closed forms are short, and equal to what they came from."""

from __future__ import annotations

import math

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.mechanics.simplify import readable

a, b, mu, m = (sp.Symbol(n, real=True) for n in ("a", "b", "mu", "m"))
s, c = sp.sin(a), sp.cos(a)

LEAVES = st.sampled_from([s, c, sp.sin(b), sp.cos(b), mu, m, *map(sp.Integer, range(-3, 4))])
TREES = st.recursive(
    LEAVES,
    lambda part: st.one_of(
        st.builds(lambda x, y: x + y, part, part),
        st.builds(lambda x, y: x * y, part, part),
        st.builds(lambda x, y: x / (2 + y**2), part, part),
    ),
    max_leaves=7,
)
ANGLES = st.floats(-3.0, 3.0)


def _value(expr: sp.Expr, point: dict[sp.Symbol, float]) -> float:
    return float(expr.evalf(30, subs={k: sp.Float(v, 30) for k, v in point.items()}))


def _cost(expr: sp.Expr) -> int:
    parts = list(sp.preorder_traversal(expr))
    return int(sp.count_ops(expr)) + sum(p.could_extract_minus_sign() for p in parts if p.is_Mul)


@settings(max_examples=30)
@given(expr=TREES, values=st.tuples(ANGLES, ANGLES, ANGLES, ANGLES))
def test_readable_keeps_the_value_and_needs_no_more_operations(expr, values):
    simplified, point = readable(expr), dict(zip((a, b, mu, m), values, strict=True))
    expected = _value(expr, point)
    assert math.isclose(_value(simplified, point), expected, rel_tol=1e-12, abs_tol=1e-14)
    assert _cost(simplified) <= _cost(expr)


@pytest.mark.parametrize(
    ("long", "short"),
    [
        (s**2 + c**2, "1"),
        (4 * c**2 + s**2, "3*cos(a)**2 + 1"),
        ((4 * c**2 + s**2 - 3 * mu * s * c) / m, "(3*(-mu*sin(a) + cos(a))*cos(a) + 1)/m"),
        (1 / m + 3 * s**2 / m, "(3*sin(a)**2 + 1)/m"),
        (4 / (3 * m * s**2 + m), "4/(m*(3*sin(a)**2 + 1))"),
        (s * sp.sin(b) + c * sp.cos(b), "cos(a - b)"),
        (-3 * mu * s * c / m, "-3*mu*sin(a)*cos(a)/m"),
        (-(c**2), "sin(a)**2 - 1"),
    ],
)
def test_readable_writes_as_a_person_would(long, short):
    assert str(readable(long)) == short


@pytest.mark.parametrize("atom", [a, sp.Integer(3), sp.Rational(1, 3), sp.pi, 2, 0])
def test_readable_returns_atoms_as_they_are(atom):
    assert readable(atom) == atom


def test_readable_tells_integers_from_floats():
    assert readable(1) is sp.Integer(1)
    assert readable(2.0 * mu).has(sp.Float)
    assert not readable(2 * mu).has(sp.Float)


def test_readable_only_factors_a_long_expression():
    long = sum((mu * sp.sin(k * a) / (k + c) for k in range(1, 30)), sp.Integer(0))
    assert sp.count_ops(long) > 60
    simplified = readable(long)
    point = {a: 0.7, mu: 1.4, m: 1.0}
    assert sp.count_ops(simplified) < sp.count_ops(long)
    assert math.isclose(_value(simplified, point), _value(long, point), rel_tol=1e-12)


def test_readable_collapses_a_long_expression_whose_terms_cancel():
    power = (m * s + mu * c + b) ** 4
    long = sp.expand(power) - power + (m * s**2 + m * c**2) / (mu + 1)
    assert sp.count_ops(long) > 100
    assert str(readable(long)) == "m/(mu + 1)"
