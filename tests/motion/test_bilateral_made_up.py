"""Bilateral contacts beyond the named ones: forces that turn, a hoop, a moving guide."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from painleve_sym.at.tangential import tangential_impact
from painleve_sym.errors import InputError
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.simulator import Simulator

BEAD = (Path(__file__).parents[2] / "examples" / "mechanisms" / "bead-in-groove.toml").read_text(
    "utf-8"
)

CARRIAGE = """
name = "carriage"
[coordinates]
x = { unit = "m", meaning = "carriage along the rail" }
y = { unit = "m", meaning = "carriage across the rail" }
z = { unit = "m", meaning = "mass on a spring above it" }
[parameters]
m = { default = 1.0, unit = "kg", meaning = "mass of each", positive = true }
k = { default = 100.0, unit = "N/m", meaning = "stiffness", positive = true }
mu = { default = 0.4, unit = "1", meaning = "friction coefficient" }
[energy]
kinetic = "m*(x_dot**2 + y_dot**2)/2 + m*(x_dot**2 + z_dot**2)/2"
potential = "k*(z - y)**2/2"
[[contacts]]
name = "rail"
gap = "y"
slip_velocity = "x_dot"
friction = "mu"
bilateral = true
"""

HOOP = """
name = "hoop"
gravity = "g"
[coordinates]
x = { unit = "m", meaning = "place" }
y = { unit = "m", meaning = "height" }
[parameters]
m = { default = 1.0, unit = "kg", meaning = "mass", positive = true }
R = { default = 1.0, unit = "m", meaning = "radius", positive = true }
g = { default = 9.8, unit = "m/s^2", meaning = "gravity", lower = 0 }
mu = { default = 0.2, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[[contacts]]
name = "wire"
point = ["x", "y"]
curve = "x**2 + y**2 - R**2"
friction = "mu"
bilateral = true
"""


@pytest.fixture(scope="module")
def carriage():
    return Simulator(mechanism_from_text(CARRIAGE), RigidLaw())


def test_force_that_turns_in_sticking_changes_the_side(carriage):
    """F_n = −k z with z = sin(10 t)/10: it passes 0 every π/10 s and nothing pulls along."""
    run = carriage.run({"z_dot": 1.0}, t_end=1.0)
    turns = [e.time for e in run.events_of("force_reversal")]
    assert turns == pytest.approx([i * math.pi / 10 for i in range(4)], abs=1e-9)
    assert not run.events_of("slip_start") and run.final["x_dot"] == 0
    assert run.energy_residual < 1e-9


def test_force_that_turns_in_slip_rubs_on_both_sides(carriage):
    """2 m v' = −μ |F_n|: v = 1 is used up after two and a half half-waves of |sin 10 t|."""
    run = carriage.run({"z_dot": 1.0, "x_dot": 1.0}, t_end=1.0)
    (stop,) = run.events_of("slip_stop")
    assert stop.time == pytest.approx(math.pi / 4, abs=1e-9)
    assert stop.state["friction_dissipation"] == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_without_any_load_nothing_happens(carriage, speed):
    run = carriage.run({"x_dot": speed}, t_end=1.0)
    assert len(run.events) == 1 and run.final["x"] == pytest.approx(speed, rel=1e-12)


@pytest.mark.slow
def test_bead_on_a_hoop_agrees_with_its_angle_by_hand():
    """The gap is not a coordinate; from the top, N = m g cos a − m R a'^2 outwards."""
    run = Simulator(mechanism_from_text(HOOP), RigidLaw()).run({"y": 1.0, "x_dot": 0.7}, t_end=3.0)
    mu, g = 0.2, 9.8

    def field(_, z):
        normal = g * math.cos(z[0]) - z[1] ** 2
        return [z[1], g * math.sin(z[0]) - mu * math.copysign(abs(normal), z[1])]

    # Where N or the speed passes 0 the steps become short: no events are needed.
    tight = {"rtol": 1e-12, "atol": 1e-13}
    other = solve_ivp(field, (0, 3), [0, 0.7], method="DOP853", **tight)
    angle, rate = other.y[:, -1]
    expected = [math.sin(angle), math.cos(angle), rate * math.cos(angle), -rate * math.sin(angle)]
    final = [run.final[n] for n in ("x", "y", "x_dot", "y_dot")]
    assert final == pytest.approx(expected, abs=1e-8)
    assert abs(math.hypot(final[0], final[1]) - 1) < 1e-9
    kinds = [e.kind for e in run.events if e.kind != "contact"]
    assert kinds == ["force_reversal", "slip_stop"]
    assert run.energy_residual < 1e-9


def test_moving_guide_does_work_in_the_tangential_impact():
    text = BEAD.replace('slip_velocity = "x_dot"', 'slip_velocity = "x_dot - u"').replace(
        "[definitions]",
        'u = { default = 2.0, unit = "m/s", meaning = "speed of the groove" }\n[definitions]',
    )
    mechanism, state = mechanism_from_text(text), {"phi": 0.4, "x_dot": 3.0, "phi_dot": 9.0}
    jump = tangential_impact(mechanism, state, parameters={"mu": 1.5})
    assert jump.velocity["x_dot"] == pytest.approx(2.0, rel=1e-12)
    run = Simulator(mechanism, RigidLaw()).run(state, t_end=0.02, parameters={"mu": 1.5})
    (event,) = run.events_of("tangential_impact")
    M, m, L, phi = 0.2, 1.0, 0.5, 0.4
    energies = []
    for v in (jump.velocity_before, jump.velocity):
        v_x = v["x_dot"] + L * math.cos(phi) * v["phi_dot"]
        v_y = L * math.sin(phi) * v["phi_dot"]
        energies.append(M * v["x_dot"] ** 2 / 2 + m * (v_x**2 + v_y**2) / 2)
    booked = event.state["friction_dissipation"] + event.state["force_dissipation"]
    assert energies[0] - energies[1] == pytest.approx(booked, rel=1e-9)
    assert event.state["force_dissipation"] == pytest.approx(
        -2 * jump.tangential_impulse[0], rel=1e-9
    )
    assert np.isclose(jump.energy_change, -event.state["friction_dissipation"], rtol=1e-9)
    assert run.energy_residual < 1e-9


def test_guide_that_leaves_no_slip_is_refused():
    tied = CARRIAGE.replace('gap = "y"', 'gap = "x"')
    with pytest.raises(InputError, match="rank one"):
        _ = Simulator(mechanism_from_text(tied), RigidLaw()).contact
