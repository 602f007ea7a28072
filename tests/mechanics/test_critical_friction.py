"""Critical friction: closed forms of its minimum against a search, and against the literature."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from painleve_sym.errors import InputError
from painleve_sym.mechanics.paradox.critical_friction import (
    critical_friction,
    least_over_directions,
)
from painleve_sym.study.maps.least_friction import least_critical_friction
from tests.mechanics.catalogue import by_symbol, derived, random_numbers

TURNING = {"rod": "theta", "rod-inertia": "theta", "block": "theta", "cart-pendulum": "phi"}


def _defaults(mechanism):
    return {p.symbol: p.default for p in mechanism.system.parameters}


def _by_search(mechanism, angle, values):
    """Return the least W_nn/|W_nt| over one angle, by a grid and a line search."""
    c = mechanism.coefficients
    q = next(s for s in mechanism.system.q if s.name == angle)
    ratio = sp.lambdify(q, (c.W_nn / sp.Abs(c.W_nt)).subs(values), "math")
    grid = np.linspace(0.01, 2 * math.pi, 1001)
    best = grid[np.argmin([ratio(float(x)) for x in grid])]
    bounds = (best - 0.01, best + 0.01)
    return minimize_scalar(ratio, bounds=bounds, options={"xatol": 1e-12}).fun


@pytest.mark.parametrize("name", TURNING)
def test_minimum_over_an_angle_that_turns_the_mobility_is_that_over_directions(name):
    mechanism = derived(name)
    c = mechanism.coefficients
    lowest = critical_friction(c).minimum(TURNING[name])
    assert lowest.attained and lowest.equation is None
    assert lowest.value == least_over_directions(c)
    rng = np.random.default_rng(3)
    for _ in range(3):
        numbers = random_numbers(mechanism, rng)
        values = {p.symbol: numbers[p.name] for p in mechanism.system.parameters}
        value, places = lowest.number(values)
        assert math.isclose(value, _by_search(mechanism, TURNING[name], values), rel_tol=1e-9)
        q = next(s for s in mechanism.system.q if s.name == TURNING[name])
        for place in places:
            at = {**values, q: math.atan(place)}
            assert math.isclose(abs((c.W_nn / c.W_nt).subs(at)), value, rel_tol=1e-12)


@pytest.mark.parametrize("slip", [-1, 1])
@pytest.mark.parametrize("name", ["rod", "block", "cart-pendulum"])
def test_minimum_for_one_slip_direction_is_at_one_place_of_the_right_sign(name, slip):
    mechanism = derived(name)
    critical = critical_friction(mechanism.coefficients, slip)
    value, (place,) = critical.minimum(TURNING[name]).number(_defaults(mechanism))
    q = next(s for s in mechanism.system.q if s.name == TURNING[name])
    at = {**_defaults(mechanism), q: math.atan(place)}
    assert math.isclose(critical.value.subs(at), value, rel_tol=1e-12)


def test_block_minimum_is_where_the_literature_has_it():
    """m r²/J = 3 for any sides: a rod of tangent ±2 from the corner to the centre."""
    a, b = (sp.Symbol(n, positive=True) for n in "ab")
    lowest = critical_friction(derived("block").coefficients).minimum("theta")
    assert lowest.value == sp.Rational(4, 3)
    diagonal = b / a
    for place in lowest.at:
        # tan(theta + atan(b/a)) = ±2
        tangent = sp.simplify((place + diagonal) / (1 - place * diagonal))
        assert tangent in (2, -2)


def test_cart_pendulum_minimum_for_a_point_bob_is_that_of_two_masses():
    M, m = (sp.Symbol(n, positive=True) for n in "Mm")
    J = sp.Symbol("J", nonnegative=True)
    lowest = critical_friction(derived("cart-pendulum").coefficients).minimum("phi")
    expected = 2 * sp.sqrt(M * (M + m)) / m
    assert sp.simplify(lowest.value.subs(J, 0) - expected) == 0


def test_eccentric_disc_minimum_is_the_root_of_the_cubic():
    lowest = critical_friction(derived("eccentric-disc").coefficients).minimum("phi")
    m, r, J = (sp.Symbol(n, positive=True) for n in ("m", "r", "J"))
    d, s = sp.Symbol("d", nonnegative=True), lowest.root
    ratio, k = r / d, J / (m * d**2)
    cubic = ratio * s**3 + (2 * k + 1) * s**2 + ratio * (k - 1) * s - (k + 1)
    assert sp.simplify(lowest.equation / (m * d**3) - cubic) == 0
    assert lowest.variable == sp.sin(sp.Symbol("phi", real=True))


def test_eccentric_disc_minimum_is_the_least_found_by_a_search():
    mechanism = derived("eccentric-disc")
    lowest = critical_friction(mechanism.coefficients).minimum("phi")

    @settings(max_examples=5)
    @given(st.floats(0.1, 2), st.floats(0.05, 1), st.floats(0.05, 1), st.floats(1e-3, 0.5))
    @example(0.5, 1.0, 0.25, 0.5)  # a root of the cubic below -1 has a smaller value
    def check(m, r, d, J):
        names = {"m": m, "r": r, "d": d, "J": J}
        values = {s: names.get(s.name, v) for s, v in _defaults(mechanism).items()}
        value, places = lowest.number(values)
        assert math.isclose(value, _by_search(mechanism, "phi", values), rel_tol=1e-8)
        assert all(0 < place < 1 for place in places)

    check()


@pytest.mark.parametrize(
    ("name", "angle", "closed"),
    [
        ("strut", "theta", lambda v: math.sqrt(4 * v["l"] ** 2 - v["h"] ** 2) / v["h"]),
        (
            "pr-robot",
            "theta",
            lambda v: (
                2
                * (v["m_1"] + v["m_2"])
                / (2 * v["m_1"] + v["m_2"])
                / math.tan(math.asin(v["h"] / (2 * v["l"])))
            ),
        ),
        (
            "painleve-klein",
            "phi",
            lambda v: (v["m_1"] + v["m_2"]) / (v["m_2"] * math.tan(v["phi_0"])),
        ),
    ],
)
def test_mechanism_held_by_its_gap_has_one_value_in_contact_and_no_minimum(name, angle, closed):
    mechanism = derived(name)
    critical = critical_friction(mechanism.coefficients)
    lowest = critical.minimum(angle)
    assert not lowest.attained and lowest.value == 0
    values = {p.name: p.default for p in mechanism.system.parameters}
    friction = critical.in_contact().subs(_defaults(mechanism))
    assert math.isclose(friction, closed(values), rel_tol=1e-12)
    start = {**_defaults(mechanism), **by_symbol(mechanism, {**values, **_full(mechanism)})}
    assert math.isclose(friction, critical.value.subs(start), rel_tol=1e-12)


def _full(mechanism):
    return dict.fromkeys(mechanism.state_names, 0.0) | dict(mechanism.start)


def test_gap_that_leaves_the_configuration_free_has_no_value_in_contact():
    with pytest.raises(InputError, match="need one that fixes the only coordinate"):
        critical_friction(derived("rod").coefficients).in_contact()


def test_strut_has_no_friction_without_paradox_for_some_direction():
    """Rank one: a surface across the only motion of the tip is left by no force on it."""
    assert least_over_directions(derived("strut").coefficients) == 0


def test_least_over_directions_is_that_of_the_eigenvalues():
    for name in ("rod", "eccentric-disc", "cart-pendulum"):
        mechanism = derived(name)
        c, rng = mechanism.coefficients, np.random.default_rng(1)
        at = by_symbol(mechanism, random_numbers(mechanism, rng))
        W = np.array([[c.W_nn.subs(at), c.W_nt.subs(at)], [c.W_nt.subs(at), c.W_tt.subs(at)]])
        low, high = np.linalg.eigvalsh(W.astype(float))
        expected = 2 * math.sqrt(low * high) / (high - low)
        assert math.isclose(least_over_directions(c).subs(at), expected, rel_tol=1e-9), name


@pytest.mark.slow
def test_two_link_arm_turned_as_a_whole_keeps_the_eigenvalues():
    mechanism = derived("two-link-arm")
    c, rng = mechanism.coefficients, np.random.default_rng(1)
    form = least_over_directions(c)
    at = by_symbol(mechanism, random_numbers(mechanism, rng))
    W = np.array([[c.W_nn.subs(at), c.W_nt.subs(at)], [c.W_nt.subs(at), c.W_tt.subs(at)]])
    low, high = np.linalg.eigvalsh(W.astype(float))
    expected = 2 * math.sqrt(low * high) / (high - low)
    assert math.isclose(form.subs(at), expected, rel_tol=1e-9)
    one, two = mechanism.system.q
    turned = {**at, one: at[one] + 0.3, two: at[two] + 0.3}
    assert math.isclose(form.subs(turned), expected, rel_tol=1e-9)


@pytest.mark.parametrize(
    "name",
    [
        "rod",
        pytest.param("eccentric-disc", marks=pytest.mark.slow),
        pytest.param("cart-pendulum", marks=pytest.mark.slow),
    ],
)
def test_search_in_contact_finds_the_closed_minimum(name):
    mechanism = derived(name)
    angle = TURNING.get(name, "phi")
    value, _ = critical_friction(mechanism.coefficients).minimum(angle).number(_defaults(mechanism))
    assert math.isclose(least_critical_friction(mechanism).value, value, rel_tol=1e-9)


def test_minimum_without_numbers_for_its_symbols_says_which():
    lowest = critical_friction(derived("rod-inertia").coefficients).minimum("theta")
    with pytest.raises(InputError, match="got no value of alpha"):
        lowest.number({})
