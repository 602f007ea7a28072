"""Mechanisms whose formulas depend on the time: surfaces and drives that move as prescribed."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.automata.model import ContactModel
from painleve_sym.automata.rigid import RigidContact
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import ModelError
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.bodies import Body, Load, Spring
from painleve_sym.mechanics.coefficients import F_N, F_T, ContactCoefficients
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, DomainBound, Parameter
from painleve_sym.mechanics.definition import definition_text
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.paradox.singular_point import SingularPoint
from painleve_sym.mechanics.system import TIME, LagrangianSystem
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from tests.support.vanishing import vanishes

t = TIME
X, Y = Coordinate("x", "place", "m"), Coordinate("y", "height", "m")
PHI = Coordinate("phi", "angle", "rad")
M, L, G, A, W = (
    Parameter(name, 1.0, "1", name, 0.0, lower_closed=False) for name in ("m", "l", "g", "a", "w")
)
MU, U = Parameter("mu", 0.5, "1", "friction", 0.0), Parameter("u", 0.5, "m/s", "speed")
PARAMETERS = (M, L, G, A, W, MU, U)
m, l, g, a, w, mu, u = (p.symbol for p in PARAMETERS)
x, y, phi = (c.symbol for c in (X, Y, PHI))

ROD = LagrangianSystem.of_bodies(
    "rod", (X, Y, PHI), PARAMETERS, [Body(m, (x, y), m * l**2 / 3, phi)], gravity=g
)
TIP = (x - l * sp.cos(phi), y - l * sp.sin(phi))
MOVES = (a * sp.sin(w * t), a * sp.cos(2 * w * t) + t**2 / 7)


def numeric(formulas, **values):
    symbols = {s for f in formulas for s in sp.sympify(f).free_symbols}
    return numbers(list(formulas), {s: values[s.name] for s in symbols})


# ---- Lagrange's equations ----


def driven_pendulum():
    """A point mass on a rod whose pivot moves by (a sin ωt, a cos 2ωt + t²/7)."""
    place = (MOVES[0] + l * sp.sin(phi), MOVES[1] - l * sp.cos(phi))
    return LagrangianSystem.of_bodies("driven", (PHI,), PARAMETERS, [Body(m, place)], gravity=g)


def test_driven_pivot_is_gravity_and_the_acceleration_of_the_pivot():
    """The textbook form: l φ̈ = −(g + ÿ_P) sin φ − ẍ_P cos φ."""
    p_x, p_y = (sp.diff(move, t, 2) for move in MOVES)
    expected = -((g + p_y) * sp.sin(phi) + p_x * sp.cos(phi)) / l
    difference = driven_pendulum().free_acceleration[0] - expected
    assert vanishes(sp.expand_trig(difference))


def test_relative_coordinates_are_the_absolute_ones_in_a_moving_frame():
    """A point at the height r + f(t), with a spring to the frame, by either coordinate."""
    frame = a * sp.sin(w * t)
    moving = LagrangianSystem.of_bodies(
        "moving", (Y,), PARAMETERS, [Body(m, (0, y + frame))], gravity=g, springs=[Spring(y, u, mu)]
    )
    fixed = LagrangianSystem.of_bodies(
        "fixed", (Y,), PARAMETERS, [Body(m, (0, y))], gravity=g, springs=[Spring(y - frame, u, mu)]
    )
    shift = {y: y + frame, Y.rate: Y.rate + sp.diff(frame, t)}
    acceleration = fixed.free_acceleration[0].subs(shift, simultaneous=True)
    assert vanishes(moving.free_acceleration[0] - acceleration + sp.diff(frame, t, 2))
    # The energy is the same, so its change is, too.
    power = fixed.dissipated_power.subs(shift, simultaneous=True)
    assert vanishes(moving.dissipated_power - power)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pivot", "turning frame", "spring and load", "mass"])
def test_dissipated_power_and_drive_speeds_are_the_change_of_the_energy(name):
    """−d(T + V)/dt along q̈ = M⁻¹(h + Jᵀ F), less v_n and v_t, differentiated as it stands."""
    spin = sp.cos(w * t) * (1 + phi)
    place = (phi * sp.cos(spin), phi * sp.sin(spin))
    body, spring = Body(m, (phi, t * phi)), Spring(phi - sp.sin(t), u, mu * t)
    load = Load.force((phi + t, phi * t), (sp.cos(t), PHI.rate * t))
    system = {
        "pivot": driven_pendulum(),
        "turning frame": LagrangianSystem.of_bodies(
            "turning", (PHI,), PARAMETERS, [Body(m, place)], gravity=g
        ),
        "spring and load": LagrangianSystem.of_bodies(
            "spring", (PHI,), PARAMETERS, [body], gravity=g, springs=[spring], loads=[load]
        ),
        "mass": LagrangianSystem(
            "mass", (PHI,), PARAMETERS, (2 + sp.sin(t)) * PHI.rate**2 / 2, phi**2 * sp.exp(-t)
        ),
    }[name]
    contact = Contact("c", system, phi * sp.cos(t) - sp.sin(3 * t), PHI.rate - t**2, mu)
    c = ContactCoefficients(contact)
    energy = system.kinetic_energy + system.potential_energy
    change = sp.diff(energy, t) + sp.diff(energy, phi) * PHI.rate
    change += sp.diff(energy, PHI.rate) * c.accelerations[0]
    normal, tangential = c.drive_speeds
    given = F_N * (contact.gap_rate + normal) + F_T * (contact.slip_velocity + tangential)
    values = {"phi": 0.7, "phi_dot": -1.3, "t": 0.9, "F_n": 2.3, "F_t": -0.8}
    values |= {"m": 1.4, "l": 0.6, "g": 9.8, "a": 0.3, "w": 2.1, "mu": 0.4, "u": 0.7}
    left, right = numeric([change, given - system.dissipated_power], **values)
    assert math.isclose(left, right, rel_tol=1e-12)


# ---- surfaces ----


SLOPE, SPEED = sp.sin(w * t) / 5, u * sp.cos(t)
SURFACES = {
    "flat": {"through": MOVES, "surface_speed": SPEED},
    "sloped": {"slope": 0.3, "through": MOVES},
    "turning": {"slope": SLOPE, "through": MOVES},
    "curved": {"through": MOVES, "curve": lambda x, y: y - x**2 / 3, "surface_speed": SPEED},
    "deforming": {"curve": lambda x, y: y - sp.sin(x - t) / 3},
    "disc": {"slope": SLOPE, "through": MOVES},
}
LONG = {"turning", "curved", "deforming"}
"""Whose second derivatives take seconds."""


def on_surface(name):
    if name == "disc":
        return Contact.of_disc("c", ROD, (x, y), l, phi, mu, **SURFACES[name])
    return Contact.of_point("c", ROD, TIP, mu, **SURFACES[name])


finite = st.floats(-2, 2)
ACCELERATION = (0.3, -0.7, 0.4)


@functools.cache
def along_a_motion(name):
    """Return rates and biases of a surface, and the derivatives along q + q̇ τ + q̈ τ²/2 at τ = 0."""
    contact, tau = on_surface(name), sp.Symbol("tau", real=True)
    path = {t: t + tau}
    for c, b in zip(ROD.coordinates, ACCELERATION, strict=True):
        path |= {c.symbol: c.symbol + c.rate * tau + b * tau**2 / 2, c.rate: c.rate + b * tau}
    gap, slip = (f.subs(path, simultaneous=True) for f in (contact.gap, contact.slip_velocity))
    expected = [sp.diff(gap, tau), sp.diff(gap, tau, 2), sp.diff(slip, tau)]
    q_ddot = sp.Matrix(ACCELERATION)
    rates = [
        contact.gap_rate,
        (contact.J_N * q_ddot)[0] + contact.normal_bias,
        (contact.J_T * q_ddot)[0] + contact.tangential_bias,
    ]
    return rates, [e.subs(tau, 0) for e in expected]


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow if n in LONG else ()) for n in SURFACES],
)
@settings(max_examples=15)
@given(place=st.tuples(finite, finite, finite), speed=st.tuples(finite, finite, finite), now=finite)
def test_rates_and_biases_are_the_derivatives_along_any_motion(name, place, speed, now):
    rates, expected = along_a_motion(name)
    values = dict(zip(("x", "y", "phi"), place, strict=True)) | {"t": now}
    values |= dict(zip(("x_dot", "y_dot", "phi_dot"), speed, strict=True))
    values |= {"m": 1.0, "l": 0.7, "g": 9.8, "a": 0.4, "w": 1.3, "mu": 0.5, "u": 0.6}
    assert numeric(rates, **values) == pytest.approx(numeric(expected, **values), abs=1e-9)


def test_disc_at_rest_on_a_turning_surface_does_not_slip():
    """A disc that moves with the surface like one body with it has no slip velocity."""
    slope, place = sp.Symbol("s", real=True), (0.3, 1.1)
    contact = Contact.of_disc("c", ROD, (x, y), 1, phi, mu, slope=0.4 * sp.sin(t), through=place)
    c, s = sp.cos(slope), sp.sin(slope)
    centre = (place[0] + 2 * c - s, place[1] + 2 * s + c)  # at the height of the radius, 1
    spin = sp.diff(0.4 * sp.sin(t), t)
    now = {q: e.subs(slope, 0.4 * sp.sin(t)) for q, e in zip((x, y), centre, strict=True)}
    now |= {
        v.rate: (sp.diff(e, slope) * spin).subs(slope, 0.4 * sp.sin(t))
        for v, e in zip((X, Y), centre, strict=True)
    }
    now |= {PHI.rate: spin, phi: 0.4 * sp.sin(t)}
    for form in (contact.gap, contact.gap_rate, contact.slip_velocity):
        assert abs(float(form.subs(now, simultaneous=True).subs(t, 0.7))) < 1e-14


def test_table_that_moves_level_at_constant_speed_is_a_belt():
    moved = Contact.of_point("c", ROD, TIP, mu, through=(u * t, 0))
    belt = Contact.of_point("c", ROD, TIP, mu, surface_speed=u)
    assert (moved.gap, moved.slip_velocity) == (belt.gap, belt.slip_velocity)
    mechanism = Mechanism("moved", "moved", "test", ROD, (moved,))
    assert not mechanism.depends_on_time
    assert definition_text(mechanism).replace("moved", "belt") == (
        definition_text(Mechanism("belt", "belt", "test", ROD, (belt,)))
    )


state_values = st.fixed_dictionaries(
    {"phi": st.floats(0.2, 1.4), "phi_dot": finite, "x_dot": finite, "mu": st.floats(0.1, 4)}
)


@functools.cache
def on_the_table_and_on_the_ground():
    table = Contact.of_point("c", ROD, TIP, mu, through=(0, u * t**2 / 2))
    pair = [ContactCoefficients(c) for c in (table, Contact.of_point("c", ROD, TIP, mu))]
    return [
        [c.W_nn, c.W_nt, c.W_tt, c.b_n, c.b_t, c.B_stick, c.contact.gap_rate, c.contact.gap]
        for c in pair
    ]


@settings(max_examples=60)
@given(values=state_values, lift=st.floats(-9, 30), now=finite)
def test_accelerating_table_is_gravity_plus_the_acceleration(values, lift, now):
    """y_table = ½ a t²: the coefficients of the contact are those with g + a in place of g."""
    table, ground = on_the_table_and_on_the_ground()
    same = {"m": 1.0, "l": 1.0, "u": lift, "t": now, "x": 0.0} | values
    height = lift * now**2 / 2
    on_table = numeric(table, g=9.8, y=1.0 + height, y_dot=0.3 + lift * now, **same)
    on_ground = numeric(ground, g=9.8 + lift, y=1.0, y_dot=0.3, **same)
    assert on_table == pytest.approx(on_ground, rel=1e-11, abs=1e-11)


def test_rate_of_the_singular_point_contains_the_time():
    contact = Contact.of_point("c", ROD, TIP, mu, through=MOVES)
    c = ContactCoefficients(contact)
    still = ContactCoefficients(Contact.of_point("c", ROD, TIP, mu))
    difference = SingularPoint(c).B_rate - SingularPoint(still).B_rate
    assert vanishes(difference + sp.diff(MOVES[1], t, 3))


# ---- names and rejected input ----

FILE = """
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
m = { default = 1.0, unit = "kg", positive = true }
mu = { default = 0.4, unit = "1" }
%s
[[bodies]]
mass = "m"
centre = ["x", "y"]
[[contacts]]
name = "table"
point = ["x", "y"]
friction = "mu"
%s
"""


def from_file(more="", contact=""):
    return mechanism_from_text(FILE % (more, contact))


def test_time_is_a_state_only_where_it_occurs():
    still, moving = from_file(), from_file("", 'through = ["0", "sin(t)"]')
    assert still.state_names == ("x", "y", "x_dot", "y_dot")
    assert moving.state_names == (*still.state_names, "t")
    assert moving.state_units == {"x": "m", "y": "m", "x_dot": "m/s", "y_dot": "m/s", "t": "s"}
    contacts = [RigidContact(ContactModel(m, (RigidLaw(),))) for m in (still, moving)]
    assert TIME not in contacts[0].states
    assert contacts[1].field(None, sp.Integer(0))[TIME] == 1


def test_domain_alone_may_depend_on_the_time():
    still = from_file()
    bound = DomainBound(1 - t, "the film ends")
    assert replace(still, domain=(bound,)).state_names[-1] == "t"


@pytest.mark.parametrize(
    ("more", "contact"),
    [
        ('t = { default = 0.3, unit = "m" }', 'through = ["0", "t"]'),
        ('t = { default = 0.3, unit = "m", positive = true }', 'through = ["0", "t"]'),
        ('[definitions]\nt = "0.3*m"', 'through = ["0", "t"]'),
        ('t = { default = 0.3, unit = "m" }', 'curve = "y - t"'),
    ],
)
def test_name_t_of_a_file_keeps_its_own_meaning(more, contact):
    mechanism = from_file(more, contact)
    assert not mechanism.depends_on_time
    assert mechanism.contact.gap_drift == 0 and mechanism.contact.gap_rate == Y.rate


def test_coordinate_called_t_is_no_time():
    mechanism = mechanism_from_text((FILE % ("", "")).replace("x", "t"))
    assert mechanism.state_names == ("t", "y", "t_dot", "y_dot")
    assert mechanism.contact.slip_velocity == Coordinate("t", "place", "m").rate


def test_curve_of_a_file_moves_with_its_origin_and_the_time():
    mechanism = from_file("", 'curve = "y - x**2 - 0.1*sin(t)"\nthrough = ["cos(t)", "0"]')
    place = x - sp.cos(t)
    gap = y - place**2 - sp.sin(t) / 10
    expected = gap / sp.sqrt(1 + 4 * place**2)
    assert vanishes(mechanism.contact.gap - expected)
    slope = sp.simplify(mechanism.contact.J_T[1] / mechanism.contact.J_T[0])
    assert vanishes(slope - 2 * place)
    level = mechanism.contact.slip_velocity.subs({Y.rate: 0, X.rate: -sp.sin(t)})
    assert vanishes(level)


@pytest.mark.parametrize(
    "height", [sp.Abs(sp.sin(t)), sp.Heaviside(t - 1), sp.floor(t), sp.sign(t - x), sp.Mod(t, 1)]
)
def test_jumps_and_kinks_at_given_times_are_refused(height):
    with pytest.raises(ModelError, match="need a smooth function of t"):
        Contact.of_point("c", ROD, TIP, mu, through=(0, height))
    with pytest.raises(ModelError, match="need a smooth function of t"):
        LagrangianSystem("s", (X,), PARAMETERS, X.rate**2, height)


def test_kink_in_a_velocity_against_the_time_is_kept():
    """|ẋ − wind(t)| has its kink where the motion puts it, as |ẋ| has."""
    drag = -u * sp.Abs(X.rate - sp.sin(t)) * (X.rate - sp.sin(t))
    system = LagrangianSystem("s", (X,), PARAMETERS, X.rate**2, sp.Integer(0), {"x": drag})
    assert system.bias_force[0].has(sp.Abs)


def test_file_with_a_kink_in_the_time_names_the_line():
    with pytest.raises(ModelError, match=r"line 12, contacts\[1\]: gap: .*need a smooth function"):
        from_file("", 'through = ["0", "abs(sin(t))"]')


def test_time_beside_a_parameter_called_t_is_refused():
    taken = Parameter("t", 1.0, "m", "a length", 0.0, lower_closed=False)
    system = LagrangianSystem("s", (X, Y), (M, MU, taken), X.rate**2 + Y.rate**2, x * 0)
    with pytest.raises(ModelError, match="t is the time, but a parameter is called t"):
        Contact("c", system, y - sp.sin(TIME), X.rate, mu)


def test_named_mechanisms_do_not_depend_on_time():
    for name in ("rod", "two-link-arm", "painleve-klein", "block-two-feet"):
        assert not model(name).depends_on_time
