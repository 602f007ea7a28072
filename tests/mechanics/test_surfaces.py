"""Contacts with slopes, belts, curves and discs; parts of mechanisms; faults of all of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.errors import ModelError
from painleve_sym.mechanics.bodies import Body, Load, Spring, expr
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, DomainBound, Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import LagrangianSystem
from tests.support.vanishing import vanishes

X, Y = Coordinate("x", "place", "m"), Coordinate("y", "height", "m")
PHI = Coordinate("phi", "angle", "rad")
M = Parameter("m", 1.0, "kg", "mass", 0.0, lower_closed=False)
RADIUS = Parameter("r", 2.0, "m", "radius", 0.0, lower_closed=False)
MU = Parameter("mu", 0.5, "1", "friction", 0.0)
U = Parameter("u", 0.5, "m/s", "speed of the surface")
BEAD = LagrangianSystem.of_bodies(
    "bead", (X, Y), (M, RADIUS, MU, U), [Body(M.symbol, (X.symbol, Y.symbol))]
)
PLACE = (X.symbol, Y.symbol)


def bead(**surface):
    return Contact.of_point("bead", BEAD, PLACE, MU.symbol, **surface)


def at(form, **values):
    return float(form.subs({s: values[s.name] for s in form.free_symbols}))


# ---- straight surfaces ----


def test_contact_through_a_point_shifts_only_the_gap():
    shifted, plain = bead(slope=0.3, through=(1, 2)), bead(slope=0.3)
    offset = sp.simplify(shifted.gap - plain.gap)
    assert math.isclose(float(offset), math.sin(0.3) - 2 * math.cos(0.3))
    assert shifted.J_N == plain.J_N and shifted.slip_velocity == plain.slip_velocity


def test_contact_with_a_wall_has_its_free_side_where_the_slope_says():
    wall = bead(slope=-sp.pi / 2)
    assert wall.gap == X.symbol
    assert wall.slip_velocity == -Y.rate


def test_contact_of_a_belt_knows_the_speed_of_its_surface():
    assert bead(surface_speed=U.symbol).surface_speed == U.symbol
    assert bead().surface_speed == 0


# ---- curves ----


def circle(x, y):
    return RADIUS.symbol**2 - x**2 - y**2


@pytest.mark.slow
@settings(max_examples=40)
@given(angle=st.floats(0, 6.28), x_dot=st.floats(-2, 2), y_dot=st.floats(-2, 2))
def test_contact_inside_a_circle_is_that_of_polar_coordinates(angle, x_dot, y_dot):
    contact, r = bead(curve=circle), 2.0
    values = {"x": r * math.cos(angle), "y": r * math.sin(angle), "r": r}
    values |= {"x_dot": x_dot, "y_dot": y_dot}
    radial = x_dot * math.cos(angle) + y_dot * math.sin(angle)
    around = -x_dot * math.sin(angle) + y_dot * math.cos(angle)
    assert abs(at(contact.gap, **values)) < 1e-14
    assert math.isclose(at(contact.gap_rate, **values), -radial, abs_tol=1e-13)
    # ∇g points inwards; turned clockwise it runs counter-clockwise along the circle.
    assert math.isclose(at(contact.slip_velocity, **values), around, abs_tol=1e-13)


def test_contact_inside_a_circle_feels_the_centrifugal_acceleration():
    contact = bead(curve=circle)
    c = ContactCoefficients(contact)
    values = {"x": 2.0, "y": 0.0, "r": 2.0, "m": 1.0, "x_dot": 0.0, "y_dot": 3.0}
    # Moving along the wall without a force, the bead runs into it with v²/r.
    assert math.isclose(at(c.b_n, **values), -(3.0**2) / 2.0, rel_tol=1e-12)
    assert math.isclose(at(c.W_nn, **values), 1.0) and abs(at(c.W_nt, **values)) < 1e-14


@settings(max_examples=40)
@given(x=st.floats(-1.5, 1.5), height=st.floats(-1e-4, 1e-4))
def test_contact_gap_of_a_curve_is_the_distance_to_first_order(x, height):
    contact = bead(curve=lambda a, b: b - a**2)
    steep = math.hypot(1, 2 * x)
    place = {"x": x - 2 * x / steep * height, "y": x**2 + height / steep}
    assert math.isclose(at(contact.gap, **place), height, rel_tol=1e-3, abs_tol=1e-15)


def test_contact_of_a_straight_curve_is_that_of_the_slope():
    slope = sp.Rational(3, 10)
    line = bead(curve=lambda x, y: y * sp.cos(slope) - x * sp.sin(slope), surface_speed=U.symbol)
    straight = bead(slope=slope, surface_speed=U.symbol)
    assert vanishes(line.gap - straight.gap)
    assert vanishes(line.slip_velocity - straight.slip_velocity)


def test_contact_of_a_curve_does_not_depend_on_how_g_is_scaled():
    one = bead(curve=lambda x, y: y - x**2)
    other = bead(curve=lambda x, y: 7 * (y - x**2))
    assert vanishes(one.gap - other.gap)


# ---- discs ----

WHEEL = LagrangianSystem.of_bodies(
    "wheel",
    (X, Y, PHI),
    (M, RADIUS, MU, U),
    [Body(M.symbol, PLACE, M.symbol * RADIUS.symbol**2 / 2, PHI.symbol)],
)


def test_contact_of_a_disc_rolls_where_its_slip_velocity_is_zero():
    contact = Contact.of_disc(
        "rim", WHEEL, PLACE, RADIUS.symbol, PHI.symbol, MU.symbol, surface_speed=U.symbol
    )
    assert sp.expand(contact.slip_velocity - (X.rate + RADIUS.symbol * PHI.rate - U.symbol)) == 0
    assert contact.gap == Y.symbol - RADIUS.symbol
    # The effective mass of a uniform disc pushed at its rim is m/3.
    assert vanishes(ContactCoefficients(contact).W_tt - 3 / M.symbol)


def test_contact_of_a_disc_on_a_slope_turns_with_it():
    contact = Contact.of_disc(
        "rim", WHEEL, PLACE, RADIUS.symbol, PHI.symbol, MU.symbol, slope=sp.pi / 2, through=(3, 0)
    )
    assert sp.expand(contact.gap - (3 - X.symbol - RADIUS.symbol)) == 0
    assert sp.expand(contact.slip_velocity - (Y.rate + RADIUS.symbol * PHI.rate)) == 0


# ---- parts ----


def test_spring_pulls_back_and_its_damper_takes_power():
    k, c = Parameter("k_s", 3.0, "N/m", "k", 0.0), Parameter("c_s", 2.0, "N s/m", "c", 0.0)
    length = sp.sqrt(X.symbol**2 + Y.symbol**2)
    system = LagrangianSystem.of_bodies(
        "sprung",
        (X, Y),
        (M, k, c, MU),
        [Body(M.symbol, PLACE)],
        springs=[Spring(length - 1, k.symbol, c.symbol)],
        loads=[Load.force(PLACE, (5, 0))],
    )
    values = {"x": 3.0, "y": 4.0, "x_dot": 1.0, "y_dot": 2.0, "m": 2.0, "k_s": 3.0, "c_s": 2.0}
    pull = 3.0 * (5.0 - 1.0) + 2.0 * (3.0 * 1.0 + 4.0 * 2.0) / 5.0
    accelerations = [at(entry, **values) for entry in system.free_acceleration]
    np.testing.assert_allclose(accelerations, [(5 - pull * 0.6) / 2, -pull * 0.8 / 2], rtol=1e-13)
    damped = 2.0 * (11.0 / 5.0) ** 2 - 5.0 * 1.0
    assert math.isclose(at(system.dissipated_power, **values), damped, rel_tol=1e-13)


def test_torque_between_two_bodies_acts_on_both():
    one, two = Coordinate("a", "angle", "rad"), Coordinate("b", "angle", "rad")
    assert Load.torque(two.symbol - one.symbol, 2).forces([one.symbol, two.symbol]) == [-2, 2]


def test_gravity_along_a_direction_is_a_constant_acceleration():
    system = LagrangianSystem.of_bodies(
        "falling", (X, Y), (M, MU), [Body(M.symbol, PLACE)], gravity=(sp.Integer(1), -2)
    )
    assert list(system.free_acceleration) == [1, -2]


def test_parts_refuse_text_which_sympy_would_execute():
    with pytest.raises(sp.SympifyError):
        expr("__import__('os')")


# ---- faults ----


@pytest.mark.parametrize(
    ("entry", "fault"),
    [
        (Parameter("k", 1.0, "", "k"), "parameter 'k' has no unit. Fix: give one in SI"),
        (Coordinate("z", "z", " "), "coordinate 'z' has no unit."),
        (Parameter("gap", 1.0, "m", "k"), "parameter: name 'gap' is reserved."),
        (Parameter("x_dot", 1.0, "m", "k"), "name 'x_dot' is declared twice."),
        (Coordinate("lambda", "z", "m"), "coordinate: name 'lambda' is not usable."),
        (Parameter("μ", 1.0, "1", "k"), "parameter: name 'μ' is not usable."),
    ],
)
def test_system_faults_of_names_and_units(entry, fault):
    coordinates = (X, entry) if isinstance(entry, Coordinate) else (X,)
    parameters = (M, entry) if isinstance(entry, Parameter) else (M,)
    with pytest.raises(ModelError) as caught:
        LagrangianSystem("bad", coordinates, parameters, M.symbol * X.rate**2, sp.Integer(0))
    assert fault in str(caught.value)


def test_system_with_negative_kinetic_energy_is_refused():
    with pytest.raises(ModelError, match="negative for some velocities"):
        LagrangianSystem("bad", (X, Y), (M,), M.symbol * (X.rate**2 - Y.rate**2), sp.Integer(0))


def test_system_without_coordinates_is_refused():
    with pytest.raises(ModelError, match="no coordinate; need at least one"):
        LagrangianSystem("bad", (), (M,), sp.Integer(0), sp.Integer(0))


def test_contact_whose_gap_never_changes_is_refused():
    still = sp.sin(X.symbol) ** 2 + sp.cos(X.symbol) ** 2
    with pytest.raises(ModelError, match="gap changes with no coordinate"):
        Contact("A", BEAD, still, X.rate, MU.symbol)
    with pytest.raises(ModelError, match="no normal motion"):
        bead(curve=lambda x, y: RADIUS.symbol)


def test_contact_whose_friction_is_no_parameter_is_refused():
    with pytest.raises(ModelError, match="friction: unknown parameter 'x'"):
        Contact("A", BEAD, Y.symbol, X.rate, X.symbol)


def test_mechanism_faults_are_told_together():
    other = Contact.of_point("bead", WHEEL, PLACE, MU.symbol)
    with pytest.raises(ModelError) as caught:
        Mechanism(
            "bad",
            "",
            "",
            BEAD,
            (bead(), other),
            (DomainBound(sp.Symbol("radus"), "nowhere"),),
            start={"x_dott": 1.0},
        )
    text = str(caught.value)
    assert "contact 'bead' is declared twice" in text
    assert "contact 'bead' belongs to another system" in text
    assert "domain 1: unknown symbol 'radus'" in text
    assert "start: unknown state 'x_dott'. Did you mean 'x_dot'?" in text
