"""The singular point A = B = 0: eigenvalues, exponent and bounded force in closed form."""

from __future__ import annotations

import math

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.mechanics.impact.impulse_rays import raw
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.mechanics.paradox.singular_point import SingularPoint

theta, theta_dot = sp.Symbol("theta", real=True), sp.Symbol("theta_dot", real=True)


@pytest.fixture(scope="module")
def point():
    return SingularPoint(rod().coefficients)


def _numbers(expr, **values):
    return float(expr.subs({s: values[s.name] for s in expr.free_symbols}))


def test_bounded_force_of_the_rod_is_the_published_one(point):
    """F* = m g cot θ₁ / (|p_θ| − 2 tan θ₁) with A = p/m and p_θ < 0 at the smaller root θ₁."""
    m, l = sp.symbols("m l", positive=True)
    g, tan = sp.Symbol("g", nonnegative=True), sp.tan(theta)
    c = rod().coefficients
    p_theta = (m * sp.diff(c.A(-1), theta)).subs(c.mu, point.critical_friction)
    published = m * g / tan / (-p_theta - 2 * tan)
    spin = sp.sqrt(g / (l * sp.sin(theta)))
    at_B_zero = point.on_A_zero(point.bounded_force).subs(theta_dot, spin)
    for value in (0.3, 0.7, 0.8, 1.0):
        values = {"theta": value, "m": 1.7, "g": 9.1, "l": 0.6}
        expected = _numbers(published, **values)
        assert _numbers(at_B_zero, **values) == pytest.approx(expected, rel=1e-12)


def test_jamming_rod_has_exponent_one_third(point):
    at = {"theta": math.pi / 4, "theta_dot": 3.0}
    assert _numbers(point.on_A_zero(point.force_exponent), **at) == pytest.approx(1 / 3, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "slip"),
    [
        ("rod", -1),
        ("rod", 1),
        pytest.param("block", -1, marks=pytest.mark.slow),
        pytest.param("block", 1, marks=pytest.mark.slow),
    ],
)
def test_eigenvalues_are_equal_at_two_over_root_three_of_the_critical_friction(name, slip):
    """The mobility of a rigid body turns with it: min μ_P = 4/3 for J = m r²/3, of any shape."""
    thresholds = SingularPoint(model(name).coefficients, slip).thresholds("theta")
    assert {sp.simplify(t.friction) for t in thresholds} == {sp.Rational(4, 3) * 2 / sp.sqrt(3)}


def test_threshold_of_the_rod_of_any_inertia():
    (threshold,) = SingularPoint(model("rod-inertia").coefficients).thresholds("theta")
    alpha = sp.Symbol("alpha", positive=True)
    assert sp.simplify(threshold.friction - 4 * sp.sqrt(1 + alpha) / (sp.sqrt(3) * alpha)) == 0
    assert sp.simplify(threshold.at - sp.sqrt((1 + alpha) / 3)) == 0


@settings(max_examples=10)
@given(
    name=st.sampled_from(["rod", "rod-inertia", "block", "eccentric-disc"]),
    slip=st.sampled_from([-1, 1]),
    values=st.lists(st.floats(0.2, 1.5), min_size=16, max_size=16),
    force=st.floats(0, 50),
)
def test_rates_are_those_along_the_slip(name, slip, values, force):
    """Central differences of A and B along q̈ = f + w F against α and β₀ + β₁ F."""
    mechanism = _models.setdefault(name, model(name))
    system, c = mechanism.system, mechanism.coefficients
    point = SingularPoint(c, slip, raw)
    symbols = [*system.q, *system.q_dot, *(p.symbol for p in system.parameters)]
    at = dict(zip(symbols, values, strict=False))
    normal, tangential = c.force_directions
    acceleration = system.free_acceleration + (normal - slip * c.mu * tangential) * force
    rates = dict(zip(system.q, system.q_dot, strict=True))
    rates |= dict(zip(system.q_dot, acceleration, strict=True))
    rates = dict(zip(rates, numbers(list(rates.values()), at), strict=True))
    h = 1e-5

    def change(expr):
        ends = [{s: at[s] + k * h * r for s, r in rates.items()} for k in (1, -1)]
        first, last = (float(numbers([expr], at | end)[0]) for end in ends)
        return (first - last) / (2 * h)

    alpha, beta_0, beta_1 = numbers((point.A_rate, point.B_rate, point.B_rate_per_force), at)
    scale = 1 + max(abs(r) for r in rates.values()) ** 3
    assert change(c.A(slip)) == pytest.approx(alpha, abs=1e-7 * scale)
    assert change(c.B) == pytest.approx(beta_0 + beta_1 * force, abs=1e-7 * scale)


_models = {}


def test_faults_are_told(point):
    with pytest.raises(InputError, match=r"need -1 or \+1"):
        SingularPoint(rod().coefficients, 0)
    with pytest.raises(InputError, match="Did you mean 'theta'"):
        point.thresholds("thta")
    with pytest.raises(InputError, match="solve eigenvalue_ratio = 1 with numbers"):
        SingularPoint(model("eccentric-disc").coefficients).thresholds("phi")
