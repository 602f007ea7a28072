"""Impulse phases: balance of momentum and energy, closed forms, critical friction."""

from __future__ import annotations

import math

import pytest
import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.impact.impulse_rays import (
    V_N,
    V_N_PLUS,
    V_T,
    Condition,
    ImpulseRay,
    raw,
    sticking_compression,
    sticking_restitution,
    tangential_phase,
)
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.mechanics.paradox.critical_friction import critical_friction
from painleve_sym.mechanics.system import LagrangianSystem
from tests.mechanics.made_up import skew_block
from tests.support.vanishing import vanishes

MECHANISMS = {"rod": rod(), "skew block": skew_block(), "belt": skew_block(belt=True)}
SLIPS = (-1, 1)


@pytest.fixture(params=sorted(MECHANISMS))
def mechanism(request):
    return MECHANISMS[request.param]


def _phases(mechanism: Mechanism, slip: int, write=raw):
    c = mechanism.coefficients
    return (
        tangential_phase(c, slip, write),
        sticking_compression(c, write),
        sticking_restitution(c, write),
    )


@pytest.mark.parametrize("slip", SLIPS)
def test_phase_changes_momentum_by_its_impulses(mechanism, slip):
    contact, system = mechanism.contact, mechanism.system
    for phase in _phases(mechanism, slip):
        change = sp.Matrix([phase.velocity[v] - v for v in system.q_dot])
        impulse = contact.J_N.T * phase.normal_impulse + contact.J_T.T * phase.tangential_impulse
        assert all(vanishes(entry) for entry in system.mass_matrix * change - impulse), phase.name


@pytest.mark.parametrize("slip", SLIPS)
def test_phase_velocities_agree_with_those_of_the_contact(mechanism, slip):
    contact, system = mechanism.contact, mechanism.system
    starts = ((V_T, V_N), (0, V_N), (0, 0))
    for phase, (v_t, v_n) in zip(_phases(mechanism, slip), starts, strict=True):
        after = dict(phase.velocity)
        slipped = contact.slip_velocity.subs(after, simultaneous=True) - contact.slip_velocity
        opened = contact.gap_rate.subs(after, simultaneous=True) - contact.gap_rate
        assert vanishes(slipped - (phase.slip_velocity - v_t)), phase.name
        assert vanishes(opened - (phase.normal_velocity - v_n)), phase.name
        assert set(phase.velocity) == set(system.q_dot)


@pytest.mark.parametrize("slip", SLIPS)
def test_phase_ends_where_it_says(mechanism, slip):
    first, second, third = _phases(mechanism, slip)
    assert first.slip_velocity == 0
    assert (second.slip_velocity, second.normal_velocity) == (0, 0)
    assert (third.slip_velocity, third.normal_velocity) == (0, V_N_PLUS)


@pytest.mark.parametrize("slip", SLIPS)
def test_phase_stored_energy_is_the_integral_of_force_times_speed(mechanism, slip):
    c = mechanism.coefficients
    p = sp.Symbol("p", real=True)
    rates = (c.A(slip), c.A_stick, c.A_stick)
    for phase, rate, start in zip(_phases(mechanism, slip), rates, (V_N, V_N, 0), strict=True):
        work = sp.integrate(start + rate * p, (p, 0, phase.normal_impulse))
        assert vanishes(phase.stored_energy + work), phase.name


@pytest.mark.parametrize("slip", SLIPS)
def test_tangential_phase_energy_is_the_quotient_of_the_paper(mechanism, slip):
    phase = tangential_phase(mechanism.coefficients, slip, raw)
    quotient = -(phase.normal_velocity**2 - V_N**2) / (2 * mechanism.coefficients.A(slip))
    assert vanishes(phase.stored_energy - quotient)


@pytest.mark.parametrize("slip", SLIPS)
def test_tangential_phase_loses_energy_only_to_friction(slip):
    mechanism = MECHANISMS["rod"]
    system, phase = mechanism.system, tangential_phase(mechanism.coefficients, slip, raw)
    start = {V_T: mechanism.contact.slip_velocity, V_N: mechanism.contact.gap_rate}
    moved = phase.started_from(start)
    kinetic = system.kinetic_energy
    change = kinetic.subs(moved.velocity, simultaneous=True) - kinetic
    friction = moved.tangential_impulse * mechanism.contact.slip_velocity / 2
    assert vanishes(change + moved.stored_energy - friction)


def test_phase_readable_and_raw_forms_are_equal():
    for slip in SLIPS:
        pairs = zip(_phases(MECHANISMS["rod"], slip), _phases(rod(), slip, raw), strict=True)
        for shown, plain in pairs:
            for name in ("normal_impulse", "tangential_impulse", "normal_velocity"):
                assert vanishes(getattr(shown, name) - getattr(plain, name))
            assert all(vanishes(shown.velocity[v] - e) for v, e in plain.velocity.items())


def test_ray_rates_are_the_coefficients():
    for mechanism in MECHANISMS.values():
        c = mechanism.coefficients
        for slip in SLIPS:
            ray = ImpulseRay.slipping(c, slip)
            assert vanishes(ray.normal_rate - c.A(slip))
            assert vanishes(ray.slip_rate - c.slip_rate_coefficient(slip))
            assert ray.force_ratio == -slip * c.mu
        stick = ImpulseRay.sticking(c)
        assert vanishes(stick.normal_rate - c.A_stick)
        assert stick.slip_rate == 0


def test_ray_can_end_on_a_normal_velocity_in_slip():
    # The piece a complete Routh solution needs: compression that ends before the slip does.
    c = MECHANISMS["rod"].coefficients
    phase = ImpulseRay.slipping(c, -1, raw).until_normal_velocity("slipping", sp.Integer(0))
    assert phase.normal_velocity == 0
    slope = c.slip_rate_coefficient(-1) / c.A(-1)
    assert vanishes(phase.slip_velocity - (V_T - slope * V_N))


@pytest.mark.parametrize("slip", [0, 2, -1.5])
def test_ray_rejects_a_slip_direction_that_is_no_sign(slip):
    with pytest.raises(InputError, match=r"need -1 or \+1"):
        ImpulseRay.slipping(MECHANISMS["rod"].coefficients, slip)


def test_phase_conditions_are_named_and_signed():
    c = MECHANISMS["rod"].coefficients
    conditions = {k.name: k for k in tangential_phase(c, -1, raw).conditions}
    assert list(conditions) == [
        "slip direction",
        "approach",
        "slip stops",
        "compression continues",
    ]
    assert vanishes(conditions["slip stops"].margin - c.slip_rate_coefficient(-1))
    stick = sticking_restitution(c, raw).conditions[0]
    assert stick.name == "sticking"
    assert vanishes(stick.margin - (c.mu * c.W_tt - sp.Abs(c.W_nt)))


def test_condition_is_strict_only_where_it_says():
    assert Condition("a", V_N, "").holds(0.0)
    assert not Condition("a", V_N, "", strict=True).holds(0.0)
    assert not Condition("a", V_N, "").holds(-1e-300)


def test_phase_started_from_replaces_every_velocity_at_once():
    c = MECHANISMS["rod"].coefficients
    x_dot = MECHANISMS["rod"].system.q_dot[0]
    phase = sticking_compression(c, raw).started_from({V_N: x_dot, x_dot: V_N})
    assert phase.velocity[x_dot] == V_N
    assert x_dot in phase.normal_impulse.free_symbols
    assert phase.conditions[1].margin == -x_dot


def test_critical_friction_of_the_rod_is_four_thirds_at_tangent_two():
    friction = critical_friction(MECHANISMS["rod"].coefficients, slip=-1)
    theta = MECHANISMS["rod"].system.q[2]
    t = sp.tan(theta)
    assert sp.simplify((friction.value - (4 + t**2) / (3 * t)).rewrite(sp.exp)) == 0
    minimum = friction.minimum("theta")
    assert (minimum.value, minimum.variable, minimum.at) == (sp.Rational(4, 3), t, (2,))


def test_critical_friction_of_either_slip_direction_has_both_minima():
    minimum = critical_friction(MECHANISMS["rod"].coefficients).minimum("theta")
    assert minimum.value == sp.Rational(4, 3)
    assert set(minimum.at) == {-2, 2}


def test_critical_friction_is_where_the_coefficient_changes_sign():
    c = MECHANISMS["rod"].coefficients
    theta = MECHANISMS["rod"].system.q[2]
    value = critical_friction(c).value.subs(theta, sp.Rational(6, 5))
    zero = c.A(-1).subs(theta, sp.Rational(6, 5)).subs(c.mu, value)
    assert math.isclose(float(zero.subs(sp.Symbol("m", positive=True), 1)), 0.0, abs_tol=1e-15)


def test_critical_friction_that_does_not_vary_has_no_minimum_to_find():
    friction = critical_friction(MECHANISMS["skew block"].coefficients)
    assert str(friction.value) == "1/Abs(c)"
    with pytest.raises(InputError, match=r"need it to vary with 'x'"):
        friction.minimum("x")


def test_critical_friction_unknown_coordinate_suggests_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'theta'"):
        critical_friction(MECHANISMS["rod"].coefficients).minimum("thta")


def test_critical_friction_without_coupling_is_refused():
    block = MECHANISMS["skew block"]
    c = block.system.parameters[2].symbol
    system = LagrangianSystem(
        "plain block",
        block.system.coordinates,
        block.system.parameters,
        block.system.kinetic_energy.subs(c, 0),
        block.system.potential_energy,
    )
    contact = Contact.of_point("block", system, system.q, block.contact.friction)
    mechanism = Mechanism("plain block", "no coupling", "a test", system, (contact,))
    with pytest.raises(InputError, match="W_nt = 0"):
        critical_friction(mechanism.coefficients)
    with pytest.raises(InputError, match="slip direction: got 3"):
        critical_friction(mechanism.coefficients, 3)


def test_critical_friction_minimum_keeps_a_parameter():
    # A rod of any inertia J = k m l²: min μ_P = 2 √(k(1 + k)), as in the literature.
    base = MECHANISMS["rod"]
    k = Parameter("k", 1 / 3, "1", "inertia over m l²", 0.0, lower_closed=False)
    m, l, *_ = base.system.parameters
    theta_dot = base.system.q_dot[2]
    extra = (k.symbol - sp.Rational(1, 3)) * m.symbol * l.symbol**2 * theta_dot**2 / 2
    system = LagrangianSystem(
        "any rod",
        base.system.coordinates,
        (*base.system.parameters, k),
        base.system.kinetic_energy + extra,
        base.system.potential_energy,
    )
    contact = Contact.of_point("A", system, system.q[:2], base.contact.friction)
    mechanism = Mechanism("any rod", "rod of any inertia", "a test", system, (contact,))
    minimum = critical_friction(mechanism.coefficients, slip=-1).minimum("theta")
    expected = 2 * sp.sqrt(k.symbol * (1 + k.symbol))
    assert sp.simplify(minimum.value**2 - expected**2) == 0


def test_critical_friction_minimum_over_a_plain_coordinate():
    # W_nt/W_nn = −c(x): with c = 2 x/(1 + x²) the threshold (1 + x²)/(2 x) is smallest at x = 1.
    x = Coordinate("x", "place", "m")
    y = Coordinate("y", "height", "m")
    m = Parameter("m", 1.0, "kg", "mass", 0.0, lower_closed=False)
    mu = Parameter("mu", 1.0, "1", "friction", 0.0)
    c = 2 * x.symbol / (1 + x.symbol**2)
    kinetic = m.symbol * (x.rate**2 + 2 * c * x.rate * y.rate + (c**2 + 1) * y.rate**2) / 2
    system = LagrangianSystem("track", (x, y), (m, mu), kinetic, sp.Integer(0))
    contact = Contact.of_point("end", system, (x.symbol, y.symbol), mu.symbol)
    mechanism = Mechanism("track", "inertia varies along it", "a test", system, (contact,))
    minimum = critical_friction(mechanism.coefficients, slip=-1).minimum("x")
    assert (minimum.value, minimum.variable, minimum.at) == (1, x.symbol, (1,))
