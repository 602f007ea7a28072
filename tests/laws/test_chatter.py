"""The ratio of bounces in closed form against the impact solver and by hand."""

from __future__ import annotations

import functools
import itertools
import math

import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from painleve_sym.errors import InputError
from painleve_sym.laws.chatter import CYCLES, chatter_ratio, symbols_of
from painleve_sym.laws.restitution import restitution_law
from painleve_sym.mechanics.general_contact import general_contact
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.problem.impact.one_contact import solve_impact

W_tt, A_stick = sp.symbols("W_tt A_stick", positive=True)
kappa, tau = sp.symbols("kappa tau", real=True)
mu = sp.Symbol("mu", nonnegative=True)


@functools.cache
def ratio_of(law, slip, case=ImpactClass.C_STICKING):
    return chatter_ratio(case, restitution_law(law), slip)


@pytest.fixture(scope="module")
def contact():
    return general_contact().coefficients


def test_poisson_sticking_bounces_grow_by_e_times_one_plus_kappa_tau():
    ratio = ratio_of("poisson", 1)
    e = ratio.law.parameter.symbol
    assert sp.simplify(ratio.ratio - e * (1 + kappa * tau)) == 0
    assert sp.simplify(ratio.restitution_threshold - 1 / (1 + kappa * tau)) == 0
    assert ratio.friction_threshold is None


@pytest.mark.parametrize("slip", [-1, 1])
def test_energetic_sticking_bounces_have_the_ratio_derived_by_hand(slip):
    """ρ² = e² [(1 + κτ)² + κ τ² A′/(W_tt (κ − μ s))]."""
    ratio = chatter_ratio(slip=slip)
    e = ratio.law.parameter.symbol
    lost = kappa * tau**2 * A_stick / (W_tt * (kappa - slip * mu))
    assert sp.simplify(ratio.ratio**2 - e**2 * ((1 + kappa * tau) ** 2 + lost)) == 0
    assert sp.simplify(ratio.restitution_threshold**2 * ((1 + kappa * tau) ** 2 + lost) - 1) == 0
    at = ratio.friction_threshold
    assert sp.simplify(sp.cancel(sp.together((ratio.ratio**2).subs(mu, at)))) == 1


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_slip_throughout_dies_out_like_the_restitution(law):
    ratio = chatter_ratio(ImpactClass.SLIDING, restitution_law(law))
    assert ratio.ratio == ratio.law.parameter.symbol
    assert ratio.restitution_threshold == 1


@pytest.mark.parametrize("law", ["poisson", "energetic"])
@pytest.mark.parametrize("case", CYCLES[1:])
def test_bounces_repeat_themselves_at_the_threshold(case, law):
    ratio = ratio_of(law, 1, case)
    values = {W_tt: 0.7, A_stick: 0.4, kappa: 1.5, tau: 0.8, mu: 1.8}
    at = ratio.restitution_threshold.subs(values)
    assert at.is_real
    e = ratio.law.parameter.symbol
    assert float(ratio.ratio.subs(values).subs(e, at)) == pytest.approx(1, rel=1e-12)


@settings(max_examples=60)
@given(
    law=st.sampled_from(["newton", "poisson", "energetic"]),
    w=st.floats(0.1, 3),
    a=st.floats(0.05, 3),
    k=st.floats(-2, 2),
    t=st.floats(1e-3, 4),
    friction=st.floats(0, 3),
    e=st.floats(0.05, 1),
)
@pytest.mark.slow
def test_closed_forms_are_the_impact_solver(law, w, a, k, t, friction, e):
    W = ((a + k * k * w, k * w), (k * w, w))
    impact = solve_impact(W, friction, (-1.0, t), law, e)
    assume(impact.case in CYCLES[1:])
    forms = _forms(law, impact.case)
    values = {"W_tt": w, "A_stick": a, "kappa": k, "tau": t, "mu": friction}
    values["e_" + law] = e
    ratio, threshold, conditions = forms
    assert ratio(**values) == pytest.approx(impact.velocity[0], rel=1e-8, abs=1e-9)
    if impact.case is ImpactClass.C_STICKING:
        assert all(c(**values) >= -1e-9 for c in conditions)
    if law != "newton" and impact.velocity[0] > 1:
        limit = threshold(**values)
        at = solve_impact(W, friction, (-1.0, t), law, limit)
        assert limit < e
        assert at.velocity[0] == pytest.approx(1, rel=1e-7)


_cached = {}


def _forms(law, case):
    key = (law, case)
    if key not in _cached:
        ratio = ratio_of(law, 1, case)
        exprs = (ratio.ratio, ratio.restitution_threshold)
        margins = [c.margin for c in ratio.conditions]
        _cached[key] = (*map(_function, exprs), [_function(m) for m in margins])
    return _cached[key]


def _function(expr):
    symbols = sorted(sp.sympify(expr).free_symbols, key=str)
    f = sp.lambdify(symbols, expr, "math")
    return lambda **values: f(*(values[s.name] for s in symbols))


@given(
    law=st.sampled_from(["poisson", "energetic"]),
    w=st.floats(0.1, 3),
    a=st.floats(0.05, 3),
    k=st.floats(0.1, 2),
    u=st.floats(0.01, 4),
    part=st.floats(0, 0.99),
    e=st.floats(0, 1),
)
def test_impacts_with_reversed_slip_never_rebound_faster_than_e(law, w, a, k, u, part, e):
    """Friction below |W_nt|/W_tt and slip against W_nt: the slip turns, if it stops."""
    W = ((a + k * k * w, k * w), (k * w, w))
    impact = solve_impact(W, part * k, (-1.0, -u), law, e)
    assert impact.case.value in ("sliding", "c_reversed", "r_reversed")
    assert impact.velocity[0] <= e * (1 + 1e-9) + 1e-12


@given(
    law=st.sampled_from(["newton", "poisson", "energetic"]),
    w=st.floats(0.1, 3),
    a=st.floats(0.05, 3),
    k=st.floats(0, 2),
    u=st.floats(0, 4),
    friction=st.floats(0, 4),
    e=st.floats(0, 1),
)
def test_slip_against_the_coupling_never_rebounds_faster_than_e(law, w, a, k, u, friction, e):
    """The normal velocity is concave in the impulse for s W_nt ≤ 0: docs/reverse-chatter.md."""
    W = ((a + k * k * w, -k * w), (-k * w, w))
    impact = solve_impact(W, friction, (-1.0, u), law, e)
    rates = [
        (p.velocity[0] - before[0]) / p.normal_impulse
        for before, p in zip(
            [(-1.0, u), *(p.velocity for p in impact.phases)], impact.phases, strict=False
        )
        if p.normal_impulse > 1e-6
    ]
    assert all(y <= x * (1 + 1e-6) for x, y in itertools.pairwise(rates))
    assert impact.velocity[0] <= e * (1 + 1e-9) + 1e-12


@given(
    law=st.sampled_from(["poisson", "energetic"]),
    w=st.floats(0.1, 3),
    a=st.floats(0.05, 3),
    k=st.floats(0, 2),
    t=st.floats(0, 4),
    friction=st.floats(0, 4),
    e=st.floats(0.1, 1),
)
def test_bounces_do_not_grow_without_kappa_tau_above_zero(law, w, a, k, t, friction, e):
    """Forty bounces from rest, each flight adding τ v_n to the slip, of any course."""
    W = ((a + k * k * w, -k * w), (-k * w, w))
    v_n, v_t = 1.0, 0.0
    for _ in range(40):
        impact = solve_impact(W, friction, (-v_n, v_t + t * v_n), law, e)
        assert impact.velocity[0] <= e * v_n * (1 + 1e-9)
        # Impacts are homogeneous: the size of a bounce is taken out.
        v_t = impact.velocity[1] / impact.velocity[0]
        v_n = 1.0


def test_general_contact_has_the_coefficients_it_is_named_by(contact):
    assert sp.simplify(contact.W_nt / contact.W_tt) == kappa
    assert sp.simplify(contact.A_stick) == A_stick
    assert (contact.b_t, contact.b_n) == sp.symbols("b_t b_n", real=True)


def test_rod_without_drive_never_chatters_in_reverse():
    """κτ = −6 l θ̇² sin θ cos² θ/((1 + 3 sin² θ)|b_n|) ≤ 0."""
    c = rod().coefficients
    chatter = ratio_of("poisson", 1)
    at = {"theta": 0.8, "theta_dot": 1.5, "l": 1.0, "g": 9.8, "m": 1.0, "e_poisson": 1.0}
    expected = 1 - 6 * 1.5**2 * math.sin(0.8) * math.cos(0.8) ** 2 / (
        (1 + 3 * math.sin(0.8) ** 2) * (9.8 - 1.5**2 * math.sin(0.8))
    )
    ratio = chatter.ratio.subs(symbols_of(c))
    ratio = float(ratio.subs({s: at[s.name] for s in ratio.free_symbols}))
    assert ratio == pytest.approx(expected, rel=1e-12)


def test_other_classes_are_refused():
    with pytest.raises(InputError, match="c_reversed"):
        chatter_ratio(ImpactClass.C_REVERSED)
