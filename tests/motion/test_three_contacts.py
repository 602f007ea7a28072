"""Rigid motion with three contacts against Moreau's time stepping, as the step tends to 0.

The law is Newton's, which both have. They agree on impacts in which no slip turns round: one
contact alone follows Routh's path, along which friction opposes the slip of each moment, whereas a
step has the friction of the slip at its end. Contacts that touch down at one instant by geometry,
as the level feet of a stiff table do, are hit one after the other in the steps and together here:
no motion below depends on that.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator
from tests.oracles.moreau import SprungTable, Stepping, Table

LEVEL = "examples/mechanisms/three-legged-table.toml"
COORDINATES = ("x", "y", "theta", "s")
FEET = ("left", "middle", "right")

# With its middle foot on a spring, the table has normal forces that its motion determines.
SPRUNG = """
name = "sprung-table"
title = "table on two stiff legs and a sprung one, on three steps"
gravity = "g"

[coordinates]
x = { unit = "m", meaning = "place of the mass centre along the ground" }
y = { unit = "m", meaning = "height of the mass centre above its place on the three feet" }
theta = { unit = "rad", meaning = "tilt, counter-clockwise" }
s = { unit = "m", meaning = "extension of the middle leg" }

[parameters]
m = { default = 10.0, unit = "kg", meaning = "mass of the table", positive = true }
m_foot = { default = 2.0, unit = "kg", meaning = "mass of the middle foot", positive = true }
J = { default = 1.5, unit = "kg m^2", meaning = "moment of inertia of the table", positive = true }
a = { default = 0.6, unit = "m", meaning = "distance of the outer feet from the middle" }
h_left = { default = 0.7, unit = "m", meaning = "height of the mass centre above the left foot" }
h_middle = { default = 0.75, unit = "m", meaning = "the same of the middle foot" }
h_right = { default = 0.65, unit = "m", meaning = "the same of the right foot" }
k = { default = 4000.0, unit = "N/m", meaning = "stiffness of the middle leg", lower = 0 }
c = { default = 60.0, unit = "N s/m", meaning = "damping of the middle leg", lower = 0 }
g = { default = 9.8, unit = "m/s^2", meaning = "gravity", lower = 0 }
mu_left = { default = 0.3, unit = "1", meaning = "friction coefficient of the left foot" }
mu_middle = { default = 0.4, unit = "1", meaning = "friction coefficient of the middle foot" }
mu_right = { default = 0.5, unit = "1", meaning = "friction coefficient of the right foot" }

[[bodies]]
mass = "m"
inertia = "J"
angle = "theta"
centre = ["x", "y"]

[[bodies]]
mass = "m_foot"
centre = ["x + (h_middle + s)*sin(theta)", "y - (h_middle + s)*cos(theta)"]

[[springs]]
extension = "s"
stiffness = "k"
damping = "c"

[[contacts]]
name = "left"
point = [
    "x - a*cos(theta) + h_left*sin(theta)",
    "y + h_left - a*sin(theta) - h_left*cos(theta)",
]
friction = "mu_left"

[[contacts]]
name = "middle"
point = [
    "x + (h_middle + s)*sin(theta)",
    "y + h_middle - (h_middle + s)*cos(theta)",
]
friction = "mu_middle"

[[contacts]]
name = "right"
point = [
    "x + a*cos(theta) + h_right*sin(theta)",
    "y + h_right + a*sin(theta) - h_right*cos(theta)",
]
friction = "mu_right"
"""


@pytest.fixture(scope="module")
def simulator(tmp_path_factory):
    path = tmp_path_factory.mktemp("mechanisms") / "sprung-table.toml"
    path.write_text(SPRUNG)

    @cache
    def build(table):
        mechanism = model(str(path) if table is SprungTable else LEVEL)
        return Simulator(mechanism, law("rigid", restitution="newton"))

    return build


def _compared(simulator, table, starts, mu, e, t_end, steps):
    """Return events and modes of the runs, and the largest errors of steps halved each time."""
    events, modes, errors = set(), set(), np.zeros((len(starts), 5))
    names = COORDINATES[: table.size]
    given = dict(zip((f"mu_{foot}" for foot in FEET), mu, strict=True)) | {"e_newton": e}
    for start, row in zip(starts, errors, strict=True):
        run = simulator(table).run(start, parameters=given, t_end=t_end)
        assert run.stop_reason is StopReason.T_END
        events |= {event.kind.value for event in run.events}
        modes |= {event.mode_after for event in run.events}
        want = np.array([run.final[n] for n in (*names, *(f"{n}_dot" for n in names))])
        q, u = (np.array([start.get(n + dot, 0.0) for n in names]) for dot in ("", "_dot"))
        for k in range(len(row)):
            count = steps * 2**k
            ended = Stepping(table(mu=mu), e).run(q, u, t_end / count, count)
            row[k] = np.max(np.abs(np.concatenate(ended) - want))
    return events, modes, np.max(errors, axis=0)


def _order(errors):
    """Return the exponent of the step in the errors of halved steps, by least squares."""
    return -np.polyfit(np.arange(len(errors)), np.log2(errors), 1)[0]


def _drops(turn, slide):
    """Return starts that land in different parts of a step."""
    heights = (0.029, 0.03, 0.0305, 0.031)
    return [{"y": y, "theta": 0.02, "x_dot": slide, "theta_dot": turn} for y in heights]


THREE_SLIDE, THREE_STICK = " + ".join(["slip_pos"] * 3), " + ".join(["stick"] * 3)

# Table, starts, friction, e, end (s), how many of the longest steps, and what has to occur.
WITH_IMPACTS = {
    "lands on one foot after the other and slides on three": (
        SprungTable, _drops(0.3, 0.5), (0.3, 0.4, 0.5), 0.0, 0.14, 140,
        {"touchdown", "impact", "slip_stop", THREE_SLIDE, "flight + slip_pos + slip_pos"},
    ),
    "lands, slides and comes to rest": (
        SprungTable, _drops(0.3, 0.5), (0.3, 0.4, 0.5), 0.0, 0.2, 200,
        {"impact", THREE_SLIDE, THREE_STICK},
    ),
    "tips and lifts one foot after the other": (
        SprungTable, [{"x_dot": v} for v in (1.5, 1.6, 1.7, 1.8)], (0.9, 1.2, 1.5), 0.0, 0.2, 200,
        {"liftoff", "slip_stop", "flight + slip_pos + slip_pos", "flight + flight + stick"},
    ),
    "bounces off each foot while it slides": (
        SprungTable, _drops(-0.3, 2.0), (0.1, 0.1, 0.1), 0.5, 0.12, 120, {"touchdown", "impact"},
    ),
    "bounces off each foot with friction that stops slips": (
        SprungTable, _drops(-0.3, 0.2), (0.8, 0.9, 1.0), 0.5, 0.12, 120, {"touchdown", "impact"},
    ),
}  # fmt: skip
_SPEEDS = (0.61, 0.7, 0.75, 0.8)
WITHOUT_IMPACT = {
    "slides to rest on a sprung leg": (
        SprungTable, [{"x_dot": v} for v in _SPEEDS], (0.3, 0.4, 0.5), 0.0, 0.25, 250,
        {"slip_stop", THREE_SLIDE, THREE_STICK},
    ),
    "slides to rest on stiff legs": (
        Table, [{"x_dot": v} for v in _SPEEDS], (0.4, 0.4, 0.4), 0.0, 0.25, 250,
        {"slip_stop", "flight + slip_pos + slip_pos", "flight + stick + flight"},
    ),
    "tips on stiff legs": (
        Table, [{"x_dot": v} for v in (2.5, 2.6, 2.7, 2.8)], (1.2, 1.2, 1.2), 0.0, 0.4, 400,
        {"slip_stop", "flight + flight + slip_pos", "flight + flight + stick"},
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("motion", WITH_IMPACTS)
def test_moreau_stepping_tends_to_the_motion_with_order_one(simulator, motion):
    *given, occurs = WITH_IMPACTS[motion]
    events, modes, errors = _compared(simulator, *given)
    assert occurs <= events | modes
    assert _order(errors) == pytest.approx(1, abs=0.2)
    assert errors[-1] < 5e-3


@pytest.mark.slow
@pytest.mark.parametrize("motion", WITHOUT_IMPACT)
def test_moreau_stepping_has_a_higher_order_where_nothing_jumps_but_friction(simulator, motion):
    """The step in which slips stop has an error of second order in place and none in velocity.

    Three stiff legs share their load in many ways. With one μ the motion is unique all the same.
    """
    *given, occurs = WITHOUT_IMPACT[motion]
    events, modes, errors = _compared(simulator, *given)
    assert occurs <= events | modes
    assert _order(errors) > 1.75
    assert errors[-1] < 1e-5


# ---- the stepping alone ----


def test_stepping_slides_to_rest_as_far_as_coulomb_says():
    """v²/(2 μ g), although the forces of three stiff legs are not determined."""
    table = Table()
    q, u = Stepping(table).run(np.zeros(3), np.array([0.5, 0.0, 0.0]), 1e-4, 2000)
    np.testing.assert_allclose(u, 0, atol=1e-12)
    np.testing.assert_allclose(q, [0.5**2 / (2 * 0.4 * table.g), 0, 0], atol=1e-7)


def test_stepping_keeps_the_energy_of_a_sprung_table_in_flight():
    """T + V by the velocities of both bodies, k and the weights; without damping it is kept."""
    table = SprungTable(c=0.0)

    def energy(q, u):
        x, y = table.middle(q) @ u
        kinetic = table.m * (u[0] ** 2 + u[1] ** 2) + table.J * u[2] ** 2
        kinetic += table.m_foot * (x**2 + y**2)
        height = q[1] - (table.h[1] + q[3]) * np.cos(q[2])
        weight = table.g * (table.m * q[1] + table.m_foot * height)
        return kinetic / 2 + table.k * q[3] ** 2 / 2 + weight

    q, u = np.array([0, 5.0, 0.3, 0.01]), np.array([1.0, 0.5, 2.0, -0.3])
    errors = []
    for count in (1000, 2000):
        there = Stepping(table).run(q, u, 0.1 / count, count)
        errors.append(abs(energy(*there) - energy(q, u)))
    assert errors[1] < 0.55 * errors[0] and errors[1] < 1e-2 * energy(q, u)


@pytest.mark.parametrize(
    ("engine", "restitution"),
    [
        ("compiled", "newton"),
        pytest.param("taylor", "newton", marks=pytest.mark.slow),
        pytest.param("taylor", "energetic", marks=pytest.mark.slow),
        pytest.param("compiled", "energetic", marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_feet_that_stop_together_do_not_bounce_in_rounding(tmp_path, engine, restitution):
    """Feet at rest keep a normal velocity of exactly 0 where another one lands beside them."""
    path = tmp_path / "level.toml"
    path.write_text(SPRUNG)
    given = {f"h_{foot}": 0.7 for foot in FEET} | {f"mu_{foot}": 0.9 for foot in FEET}
    simulator = Simulator(model(str(path)), law("rigid", restitution=restitution), engine)
    run = simulator.run(
        {"x_dot": 1.5}, parameters=given | {f"e_{restitution}": 0.0}, t_end=0.6, max_events=200
    )
    assert run.stop_reason is StopReason.T_END
    assert run.energy_residual < 1e-9
    closed = [(e, foot) for e in run.events for foot in FEET if e.state[f"gap_{foot}"] == 0]
    rates = [e.state[f"gap_{foot}_dot"] for e, foot in closed]
    assert min(abs(rate) for rate in rates if rate != 0) > 1e-12
