"""The sliding solution on every contact law: a saddle, its rates and its barrier."""

import mpmath
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.laws.catalogue import COMPLIANT_LAWS, law
from painleve_sym.laws.compliance import DELTA, DELTA_DOT, without_ramps
from painleve_sym.laws.saddle import DEPTH, A, B, barrier, loading_saddle, unloading_saddle


def numeric(expr, chosen, a, b, depth):
    """Evaluate at the law's defaults."""
    values = {p.symbol: p.default for p in chosen.parameters}
    expr = sp.sympify(expr)
    for _ in range(2):
        expr = expr.subs({DEPTH: depth, A: a, B: b}).subs(dict(chosen.definitions)).subs(values)
    return float(expr)


@pytest.mark.parametrize("name", COMPLIANT_LAWS)
def test_compression_balances_force_and_free_acceleration(name):
    chosen = law(name)
    depth = numeric(loading_saddle(chosen).compression, chosen, -0.03, 11.0, 1.0)
    at = {DELTA: depth, DELTA_DOT: 0}
    force = numeric(without_ramps(chosen.loading.force).subs(at), chosen, -0.03, 11.0, depth)
    assert -0.03 * force + 11.0 == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("name", COMPLIANT_LAWS)
@pytest.mark.parametrize("saddle", [loading_saddle, unloading_saddle])
def test_rates_solve_the_characteristic_equation(name, saddle):
    chosen = law(name)
    saddle_point = saddle(chosen)
    depth = numeric(saddle_point.compression, chosen, -0.03, 11.0, 1.0)
    growth, decay, slope, damping = (
        numeric(e, chosen, -0.03, 11.0, depth)
        for e in (*saddle_point.rates, saddle_point.slope, saddle_point.damping)
    )
    assert growth > 0 > decay
    for rate in (growth, decay):
        terms = [rate**2, -0.03 * damping * rate, -0.03 * slope]
        assert sum(terms) == pytest.approx(0, abs=1e-12 * rate**2)


@settings(max_examples=15)
@given(a=st.floats(-5, -1e-3), b=st.floats(1e-2, 100), n=st.floats(1.0, 3.0))
def test_growth_rate_without_damping_is_the_root_of_n_B_over_depth(a, b, n):
    chosen = law("hertz")
    n_symbol = next(p.symbol for p in chosen.parameters if p.name == "n")
    saddle = loading_saddle(chosen)
    exprs = [e.subs(n_symbol, sp.Float(n)) for e in (saddle.compression, saddle.growth_rate)]
    depth, rate = (numeric(e, chosen, a, b, 1.0) for e in exprs)
    assert rate == pytest.approx((n * b / depth) ** 0.5, rel=1e-12)


def test_growth_rate_rises_with_the_dashpot():
    chosen = law("linear")
    c = next(p.symbol for p in chosen.parameters if p.name == "c")
    rates = [
        numeric(loading_saddle(chosen).growth_rate.subs(c, value), chosen, -0.03, 11.0, 1.0)
        for value in (0.0, 1e4, 1e6)
    ]
    assert rates == sorted(rates) and rates[2] > 2 * rates[0]


def test_unloading_rate_of_the_bilinear_law_is_the_loading_rate_over_e():
    chosen = law("bilinear-hertz")
    depth = numeric(loading_saddle(chosen).compression, chosen, -0.03, 11.0, 1.0)
    rates = [
        numeric(s(chosen).rates[0], chosen, -0.03, 11.0, depth)
        for s in (loading_saddle, unloading_saddle)
    ]
    assert rates[1] == pytest.approx(rates[0] / 0.75, rel=1e-12)


@pytest.mark.parametrize("name", COMPLIANT_LAWS)
def test_barrier_is_the_integral_of_the_acceleration(name):
    chosen = law(name)
    depth = numeric(loading_saddle(chosen).compression, chosen, -0.03, 11.0, 1.0)
    k, n = (numeric(e, chosen, -0.03, 11.0, depth) for e in (chosen.stiffness, chosen.exponent))
    expected = mpmath.quad(lambda d: 11.0 - 0.03 * k * d**n, [0, depth])
    value = numeric(barrier(chosen), chosen, -0.03, 11.0, depth)
    assert value == pytest.approx(float(expected), rel=1e-9)
    assert value == pytest.approx(11.0 * depth * n / (n + 1), rel=1e-12)
