"""The sliding force and its drift, against the chain rule done by finite differences."""

import functools
import math

import numpy as np
import pytest

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.mechanics.coefficients import F_N
from painleve_sym.mechanics.paradox.sliding import (
    coefficient_rates,
    sliding_field,
    sliding_force_rate,
)

STATES = {
    "rod": {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0},
    "rod-inertia": {"theta": 1.1, "theta_dot": 5.0, "x_A_dot": -1.0},
    "eccentric-disc": {"phi": 1.0, "phi_dot": -8.0, "x_dot": -3.0},
    "cart-pendulum": {"phi": 2.7, "phi_dot": 5.0, "x_dot": -1.0},
    "strut": {"theta": 1.2, "theta_dot": 2.0},
}
NAMES = pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow) if n == "eccentric-disc" else n for n in STATES],
)
cached = functools.cache(model)


def values_at(mechanism, state):
    system = mechanism.system
    names = {s: state.get(s.name, 0.0) for s in (*system.q, *system.q_dot)}
    return names | {p.symbol: p.default for p in system.parameters}


@NAMES
def test_drift_is_the_change_of_the_force_along_the_sliding_motion(name):
    mechanism = cached(name)
    c, at = mechanism.coefficients, values_at(mechanism, STATES[name])
    field = sliding_field(c)
    rates = dict(zip(field, numbers(list(field.values()), at), strict=True))

    def force(h):
        moved = at | {s: at[s] + h * rates[s] for s in rates}
        return float(numbers([c.slip_force()], moved)[0])

    h = 1e-6
    expected = (8 * (force(h) - force(-h)) - (force(2 * h) - force(-2 * h))) / (12 * h)
    drift = float(numbers([sliding_force_rate(c)], at)[0])
    # Round-off of the differences, 1e-16/h.
    assert drift == pytest.approx(expected, rel=1e-7, abs=1e-8 * abs(force(0.0)))


@NAMES
def test_sliding_field_keeps_the_normal_acceleration_zero(name):
    mechanism = cached(name)
    contact, at = mechanism.contact, values_at(mechanism, STATES[name])
    field = sliding_field(mechanism.coefficients)
    accelerations = numbers([field[s] for s in mechanism.system.q_dot], at)
    J_N = numbers(list(contact.J_N), at)
    normal = float(J_N @ accelerations + numbers([contact.normal_bias], at)[0])
    assert normal == pytest.approx(0, abs=1e-12 * np.abs(accelerations).max())


def test_rates_of_the_coefficients_grow_linearly_with_the_force():
    mechanism = cached("rod")
    at = values_at(mechanism, STATES["rod"])
    A_dot, B_dot = coefficient_rates(mechanism.coefficients)
    assert not A_dot.has(F_N)
    slopes = [float(numbers([B_dot.diff(F_N)], at | {F_N: f})[0]) for f in (0.0, 300.0)]
    assert slopes[0] == slopes[1]
    # By hand: dA/dt = -3 θ̇ (sin 2θ + μ cos 2θ), dB/dt per force = 2 θ̇ sinθ · 3 (μ sinθ - cosθ).
    s, c = math.sin(1.0), math.cos(1.0)
    assert slopes[0] == pytest.approx(2 * 5 * s * 3 * (1.4 * s - c), rel=1e-12)
    expected = -3 * 5 * (math.sin(2.0) + 1.4 * math.cos(2.0))
    assert float(numbers([A_dot], at)[0]) == pytest.approx(expected, rel=1e-12)
