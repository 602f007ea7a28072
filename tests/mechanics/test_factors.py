"""Factors of sums of monomials are those that SymPy writes."""

from __future__ import annotations

import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.mechanics.factors import factor_terms, factored

x, y = (sp.Symbol(n, real=True) for n in ("x", "y"))
m = sp.Symbol("m", positive=True)

BASES = st.sampled_from([x, m, sp.sin(x), sp.cos(x), sp.sin(x - y), sp.cos(2 * x + 2 * y)])
POWERS = st.builds(lambda base, power: base**power, BASES, st.integers(1, 3))
NUMBERS = st.one_of(st.integers(-6, 6), st.sampled_from([sp.Rational(1, 2), sp.Rational(-3, 4)]))
TERMS = st.builds(
    lambda number, parts: number * sp.Mul(*parts), NUMBERS, st.lists(POWERS, max_size=3)
)
SUMS = st.builds(lambda terms: sp.Add(*terms), st.lists(TERMS, max_size=4))
PRODUCTS = st.builds(lambda one, other: sp.expand(one * other), SUMS, SUMS)


@settings(max_examples=60)
@given(expr=st.one_of(SUMS, PRODUCTS))
def test_common_factors_are_those_of_sympy(expr):
    assert sp.srepr(factor_terms(expr)) == sp.srepr(sp.factor_terms(expr))


@settings(max_examples=60)
@given(expr=st.one_of(SUMS, PRODUCTS))
def test_factors_are_those_of_sympy(expr):
    assert sp.srepr(factored(expr)) == sp.srepr(sp.factor(expr))


def test_a_number_stays_outside_of_a_sum():
    assert str(factor_terms(4 * x + 4)) == "4*(x + 1)"
    assert str(factored(-x - 1)) == "-(x + 1)"
