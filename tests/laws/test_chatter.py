"""The ratio of bounces in closed form against the impact solver and by hand."""

from __future__ import annotations

import itertools
import math

import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from derivations.generated import reverse_chatter as forms
from painleve_sym.mechanics.general_contact import general_contact
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.problem.impact.one_contact import solve_impact


@settings(max_examples=60)
@given(
    law=st.sampled_from(["poisson", "energetic"]),
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
    assume(impact.case is ImpactClass.C_STICKING)
    own = {"W_tt": w, "A_stick": a, "kappa": k, "tau": t, "mu": friction}
    if law == "poisson":
        ratio, threshold = forms.rho_poisson(k, t, e), forms.e_poisson_1(k, t)
    else:
        ratio = math.sqrt(forms.rho_energetic_squared(**own, e_energetic=e))
        threshold = forms.e_energetic_1(**own)
    assert ratio == pytest.approx(impact.velocity[0], rel=1e-8, abs=1e-9)
    if impact.velocity[0] > 1:
        at = solve_impact(W, friction, (-1.0, t), law, threshold)
        assert threshold < e
        assert at.velocity[0] == pytest.approx(1, rel=1e-7)


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


def test_general_contact_has_the_coefficients_it_is_named_by():
    contact = general_contact().coefficients
    assert sp.simplify(contact.W_nt / contact.W_tt) == sp.Symbol("kappa", real=True)
    assert sp.simplify(contact.A_stick) == sp.Symbol("A_stick", positive=True)
    assert (contact.b_t, contact.b_n) == sp.symbols("b_t b_n", real=True)


def test_rod_without_drive_never_chatters_in_reverse():
    """κτ = −6 l θ̇² sin θ cos² θ/((1 + 3 sin² θ)|b_n|) ≤ 0."""
    c = rod().coefficients
    at = {"theta": 0.8, "theta_dot": 1.5, "l": 1.0, "g": 9.8, "m": 1.0}
    coupled = -2 * c.W_nt * c.b_t / (c.W_tt * c.b_n)
    expected = (
        -6
        * 1.5**2
        * math.sin(0.8)
        * math.cos(0.8) ** 2
        / ((1 + 3 * math.sin(0.8) ** 2) * (9.8 - 1.5**2 * math.sin(0.8)))
    )
    value = float(coupled.subs({s: at[s.name] for s in coupled.free_symbols}))
    assert value == pytest.approx(expected, rel=1e-12) and value < 0
