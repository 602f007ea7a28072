"""Contacts and their coefficients: closed forms, symmetries, identities."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.errors import InputError, ModelError
from painleve_sym.mechanics.coefficients import F_N, F_T, ContactCoefficients
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.mechanics.models.spatial import rod_3d
from tests.mechanics.made_up import skew_block, two_link_arm
from tests.support.vanishing import vanishes

ROD = rod()
THETA = ROD.system.q[2]
TURN = {THETA: sp.pi - THETA, ROD.system.q_dot[2]: -ROD.system.q_dot[2]}


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("W_nn", "(3*cos(theta)**2 + 1)/m"),
        ("W_nt", "-3*sin(theta)*cos(theta)/m"),
        ("W_tt", "(3*sin(theta)**2 + 1)/m"),
        ("B", "-g + l*theta_dot**2*sin(theta)"),
        ("b_t", "l*theta_dot**2*cos(theta)"),
        ("A_stick", "4/(m*(3*sin(theta)**2 + 1))"),
        ("B_stick", "-g + 4*l*theta_dot**2*sin(theta)/(3*sin(theta)**2 + 1)"),
        (
            "sticking_force",
            "(3*F_n*sin(theta) - l*m*theta_dot**2)*cos(theta)/(3*sin(theta)**2 + 1)",
        ),
    ],
)
def test_coefficients_of_the_rod_print_as_the_paper_has_them(name, text):
    assert str(getattr(ROD.coefficients, name)) == text


def test_coefficients_slip_direction_prints_as_the_paper_has_it():
    assert str(ROD.coefficients.A(-1)) == "(3*(-mu*sin(theta) + cos(theta))*cos(theta) + 1)/m"


@pytest.mark.parametrize("name", ["W_nn", "W_tt", "B", "A_stick", "B_stick"])
def test_coefficients_mirrored_rod_keeps_even_ones(name):
    value = getattr(ROD.coefficients, name)
    assert vanishes(value.subs(TURN, simultaneous=True) - value)


@pytest.mark.parametrize("name", ["W_nt", "b_t"])
def test_coefficients_mirrored_rod_flips_odd_ones(name):
    value = getattr(ROD.coefficients, name)
    assert vanishes(value.subs(TURN, simultaneous=True) + value)


def test_coefficients_mirrored_rod_swaps_the_slip_directions():
    c = ROD.coefficients
    assert vanishes(c.A(-1).subs(TURN, simultaneous=True) - c.A(1))
    left, right = c.slip_rate_coefficient(-1), c.slip_rate_coefficient(1)
    assert vanishes(left.subs(TURN, simultaneous=True) + right)


@settings(max_examples=50)
@given(
    theta=st.floats(0.01, 3.1),
    mu=st.floats(0.0, 4.0),
    mass=st.floats(0.1, 10.0),
)
def test_coefficients_mirror_symmetry_at_random_points(theta, mu, mass):
    names = (THETA, ROD.coefficients.mu, ROD.system.parameters[0].symbol)
    left, right = (sp.lambdify(names, ROD.coefficients.A(s), "math") for s in (-1, 1))
    mirrored = right(math.pi - theta, mu, mass)
    assert math.isclose(left(theta, mu, mass), mirrored, rel_tol=1e-12, abs_tol=1e-12 * 9 / mass)


def _at_a_point(mechanism):
    """Return a mechanism with numbers for all its symbols."""
    system = mechanism.system
    rng = np.random.default_rng(3)
    values = {p.symbol: p.default for p in system.parameters}
    values |= {s: float(rng.uniform(0.3, 1.3)) for s in (*system.q, *system.q_dot)}
    return mechanism, values


POINTS = [_at_a_point(m) for m in (ROD, skew_block(), skew_block(belt=True))]
with_point = pytest.mark.parametrize("point", POINTS, ids=["rod", "block", "block on a belt"])


def _matrix(expr: sp.Matrix, values: dict[sp.Symbol, float]) -> np.ndarray:
    return np.array(sp.Matrix(expr).subs(values), dtype=float)


@pytest.mark.parametrize("point", [*POINTS, _at_a_point(two_link_arm())], ids=lambda p: p[0].name)
def test_coefficients_are_the_delassus_matrix(point):
    mechanism, values = point
    contact, c = mechanism.contact, mechanism.coefficients
    rows = np.vstack([_matrix(contact.J_N, values), _matrix(contact.J_T, values)])
    mass = _matrix(mechanism.system.mass_matrix, values)
    expected = rows @ np.linalg.solve(mass, rows.T)
    matrix = [[c.W_nn, c.W_nt], [c.W_nt, c.W_tt]]
    np.testing.assert_allclose(_matrix(matrix, values), expected, rtol=1e-11, atol=1e-12)
    assert np.all(np.linalg.eigvalsh(expected) > 0)


@with_point
def test_coefficients_give_the_contact_accelerations_of_the_motion(point):
    mechanism, values = point
    contact, c, system = mechanism.contact, mechanism.coefficients, mechanism.system
    forces = {F_N: 3.0, F_T: -1.7}
    q_ddot = c.accelerations.subs(forces)
    pairs = [
        (contact.gap_rate, c.W_nn * 3.0 - c.W_nt * 1.7 + c.b_n),
        (contact.slip_velocity, c.W_nt * 3.0 - c.W_tt * 1.7 + c.b_t),
    ]
    for rate, expected in pairs:
        moved = sum(sp.diff(rate, q) * v for q, v in zip(system.q, system.q_dot, strict=True))
        moved += sum(sp.diff(rate, v) * a for v, a in zip(system.q_dot, q_ddot, strict=True))
        computed, wanted = float(moved.subs(values)), float(expected.subs(values))
        assert math.isclose(computed, wanted, rel_tol=1e-11)


@with_point
def test_coefficients_sticking_force_holds_the_slip_velocity(point):
    mechanism, values = point
    c = mechanism.coefficients
    force = c.sticking_force.subs({**values, F_N: 5.0})
    rate = (c.W_nt * 5.0 + c.W_tt * force + c.b_t).subs(values)
    normal = (c.W_nn * 5.0 + c.W_nt * force + c.b_n).subs(values)
    assert math.isclose(float(rate), 0.0, abs_tol=1e-12)
    expected = (c.A_stick * 5.0 + c.B_stick).subs(values)
    assert math.isclose(float(normal), float(expected), rel_tol=1e-12)


def test_contact_of_a_belt_shifts_only_the_slip_velocity():
    still, belt = skew_block(), skew_block(belt=True)
    speed = belt.system.parameters[-1].symbol
    assert belt.contact.slip_velocity == still.contact.slip_velocity - speed
    assert belt.contact.J_T == still.contact.J_T
    assert belt.coefficients.W_tt == still.coefficients.W_tt


def test_contact_on_a_slope_turns_normal_and_tangent():
    angle = sp.pi / 6
    x, y = ROD.system.q[:2]
    contact = Contact.of_point("A", ROD.system, (x, y), ROD.coefficients.mu, slope=angle)
    assert contact.gap.subs({x: -1, y: 0}) == sp.Rational(1, 2)
    x_dot, y_dot = ROD.system.q_dot[:2]
    assert sp.expand(contact.slip_velocity - (sp.sqrt(3) * x_dot + y_dot) / 2) == 0
    c = ContactCoefficients(contact)
    # The rod at the same angle to its surface: an isotropic inertia does not notice the turn.
    level = ROD.coefficients.W_nn.subs(THETA, THETA - angle)
    assert vanishes(sp.expand_trig(c.W_nn - level))


def test_contact_faults_are_reported_together():
    x_dot = ROD.system.q_dot[0]
    with pytest.raises(ModelError) as caught:
        Contact("A", ROD.system, x_dot + sp.Symbol("thet"), x_dot**2, ROD.coefficients.mu)
    text = str(caught.value)
    assert "contact 'A' of mechanism 'rod'" in text
    assert "gap: unknown symbol 'thet'. Did you mean 'theta'?" in text
    assert "gap depends on a velocity" in text
    assert "gap depends on no coordinate" in text
    assert "slip velocity is not affine" in text


def test_contact_jacobians_of_the_rod_are_unit_rows():
    assert ROD.contact.J_N.tolist() == [[0, 1, 0]]
    assert ROD.contact.J_T.tolist() == [[1, 0, 0]]
    assert ROD.contact.normal_bias == 0 and ROD.contact.tangential_bias == 0


@pytest.mark.parametrize("name", ["W_nt", "W_tt", "b_t", "force_directions"])
def test_coefficients_of_one_tangent_are_refused_for_two(name):
    coefficients = ContactCoefficients(rod_3d().contact)
    with pytest.raises(InputError, match=r"has 2 tangents, .* Fix: use W and b"):
        getattr(coefficients, name)
