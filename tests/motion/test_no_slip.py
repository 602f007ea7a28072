"""Contacts that no motion slides, W_tt = 0, in any number and by either compiled engine."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.cli.run import ending
from painleve_sym.engines.c_texts import number_text
from painleve_sym.engines.taylor.scalars import ONE, ZERO, Scalar
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text

ROW = """
name = "balls-on-a-line"
[coordinates]
x1 = {{ unit = "m", meaning = "ball 1" }}
x2 = {{ unit = "m", meaning = "ball 2" }}
[parameters]
m = {{ default = 1.0, unit = "kg", meaning = "mass", positive = true }}
r = {{ default = 0.1, unit = "m", meaning = "radius", positive = true }}
c = {{ default = 0.0, unit = "1", meaning = "share of the slip" }}
mu = {{ default = 0.5, unit = "1", meaning = "friction coefficient" }}
[[bodies]]
mass = "m"
centre = ["x1", "0"]
[[bodies]]
mass = "m"
centre = ["x2", "0"]
[[contacts]]
name = "ab"
gap = "x2 - x1 - 2*r"
slip_velocity = "{first}"
friction = "mu"
[[contacts]]
name = "wall"
gap = "1.1 - x2 - r"
slip_velocity = "{second}"
friction = "mu"
"""
START = {"x1": 0.78, "x2": 0.99, "x1_dot": 2.0}


def cradle(first="0", second="0"):
    return mechanism_from_text(ROW.format(first=first, second=second))


@pytest.mark.parametrize("engine", ["taylor", "compiled"])
@pytest.mark.parametrize("slips", [("0", "0"), ("c*x1_dot", "0")])
def test_cradle_hands_its_speed_on_and_gets_it_back(engine, slips):
    """Equal masses exchange velocities: 10 mm at 2 m/s each way, and the wall turns ball 2."""
    law = ps.law("rigid", restitution="energetic").with_parameters(e_energetic=1.0)
    run = ps.simulate(cradle(*slips), law, START, t_end=0.2, engine=engine)
    touchdowns = [e.time for e in run.events if e.kind == ps.EventKind.TOUCHDOWN]
    np.testing.assert_allclose(touchdowns, [0.005, 0.010, 0.015], rtol=1e-12)
    assert run.final["x1_dot"] == pytest.approx(-2, abs=1e-12)
    assert run.final["x2_dot"] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("engine", ["taylor", "compiled"])
def test_compliant_cradle_keeps_momentum_until_the_wall_and_energy(engine):
    run = ps.simulate(cradle(), "hertz", START, t_end=0.008, engine=engine)
    assert run.final["x1_dot"] + run.final["x2_dot"] == pytest.approx(2, rel=1e-9)
    assert run.final["x1_dot"] ** 2 + run.final["x2_dot"] ** 2 == pytest.approx(4, rel=1e-9)
    assert run.final["x2_dot"] == pytest.approx(2, rel=1e-6)


def test_quotients_of_scalars_follow_the_arithmetic_of_c():
    half = Scalar(-0.5)
    assert (half / ZERO).number == -math.inf
    assert (ONE / Scalar(-0.0)).number == -math.inf
    assert math.isnan((ZERO / ZERO).number)
    assert ZERO.inverse().number == math.inf


@pytest.mark.parametrize(
    ("value", "text"),
    [(math.inf, "(INFINITY)"), (-math.inf, "(-INFINITY)"), (math.nan, "NAN"), (0.1, "0.1")],
)
def test_numbers_in_c_have_the_names_of_math_h(value, text):
    assert number_text(value) == text


# ---- without friction ----

PUCK = """
name = "puck"
[coordinates]
x = { unit = "m", meaning = "place" }
y = { unit = "m", meaning = "height" }
[parameters]
m = { default = 2.0, unit = "kg", meaning = "mass", positive = true }
p = { default = 0.0, unit = "N", meaning = "pull" }
g = { default = 9.81, unit = "m/s^2", meaning = "gravity", lower = 0 }
mu = { default = 0.0, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[forces]
x = "p"
y = "-m*g"
[[contacts]]
name = "floor"
gap = "y"
slip_velocity = "SLIP"
friction = "mu"
"""


@pytest.mark.parametrize("engine", ["taylor", "compiled", "erk"])
@pytest.mark.parametrize("slip", ["0", "x_dot"])
def test_rigid_contact_without_friction_rests_and_glides(slip, engine):
    """F_n = m g, x = x_dot t + p t²/(2 m)."""
    puck = mechanism_from_text(PUCK.replace("SLIP", slip))
    for speed, pull in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, -2.0)]:
        run = ps.simulate(
            puck, "rigid", {"x_dot": speed}, parameters={"p": pull}, t_end=1.5, engine=engine
        )
        assert run.stop_reason is ps.StopReason.T_END
        assert run.final["x"] == pytest.approx(speed * 1.5 + pull * 1.5**2 / 4, abs=1e-9)
        assert run.final_forces["normal_force"] == pytest.approx(2 * 9.81, rel=1e-9)
        assert run.final_forces["tangential_force"] == pytest.approx(0, abs=1e-12)
        assert len(run.events) <= 3


@pytest.mark.parametrize("friction", ["coulomb", "spring", "static"])
def test_no_slip_starts_without_friction(friction):
    """The puck turns; with friction a spring slips from stick then."""
    puck = mechanism_from_text(PUCK.replace("SLIP", "x_dot"))
    state, law = {"x_dot": 1.0, "y": -2 * 9.81 / 1e8}, ps.law("linear", friction=friction)
    given = {"p": -2.0}
    run = ps.simulate(puck, law, state, parameters=given, t_end=2)
    assert run.final["x_dot"] == pytest.approx(-1, abs=1e-9)
    assert not run.events_of("slip_start")
    rough = ps.simulate(puck, law, {"y": state["y"]}, parameters={"mu": 1e-3, **given}, t_end=2)
    assert rough.final["x_dot"] == pytest.approx(-2 * (1 - 1e-3 * 9.81), abs=1e-4)


def test_run_until_touchdown_has_the_state_before_the_impact_in_its_event():
    """A fall of 0.1 m ends at −√(2 g 0.1) and rebounds with e of it."""
    ball = mechanism_from_text(PUCK.replace("SLIP", "0"))
    law = ps.law("rigid").with_parameters(e_energetic=0.5)
    run = ps.simulate(ball, law, {"y": 0.1}, t_end=1, until="touchdown")
    speed = math.sqrt(2 * 9.81 * 0.1)
    assert run.stop_reason is ps.StopReason.UNTIL
    assert run.events_of("touchdown")[-1].state["y_dot"] == pytest.approx(-speed, rel=1e-9)
    assert run.final["y_dot"] == pytest.approx(speed / 2, rel=1e-9)
    assert ending(run) == f"ended at t = {run.final_time:.9g} s by touchdown"


FALLING = """
name = "falling"
[coordinates]
x = { unit = "m", meaning = "place" }
y = { unit = "m", meaning = "height" }
[parameters]
m = { default = 1.0, unit = "kg", meaning = "mass", positive = true }
c = { default = 0.0, unit = "1", meaning = "share of the slip" }
mu = { default = 0.5, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[[loads]]
point = ["x", "y"]
force = ["2*m", "-9.81*m"]
[[contacts]]
name = "foot"
gap = "y"
slip_velocity = "SLIP"
friction = "mu"
"""


QUICK = {("c*y_dot", "rigid", "taylor"), ("c*x_dot", "hertz", "compiled")}
VANISHING = [
    pytest.param(*case, marks=() if case in QUICK else pytest.mark.slow)
    for case in itertools.product(
        ["c*y_dot", "c*x_dot", "c*(x_dot + y_dot)"], ["rigid", "hertz"], ["taylor", "compiled"]
    )
]


@pytest.mark.parametrize(("slip", "law", "engine"), VANISHING)
def test_slip_that_a_parameter_makes_zero_is_that_of_a_contact_without_slip(slip, law, engine):
    """A fall of 1 cm, its bounces, and the rest: W_tt = 0 where c = 0, and all forces finite."""
    runs = [
        ps.simulate(
            mechanism_from_text(FALLING.replace("SLIP", own)), law, start, t_end=0.1, engine=engine
        )
        for own in (slip, "0")
        for start in ({"y": 0.01}, {"y": 0.0})
    ]
    for run, wanted in zip(runs[:2], runs[2:], strict=True):
        assert run.stop_reason == "t_end"
        assert [e.kind for e in run.events] == [e.kind for e in wanted.events]
        assert run.final == wanted.final and run.final_forces == wanted.final_forces
    assert runs[0].final["x"] == pytest.approx(0.01, rel=1e-12)


def test_rows_whose_slip_a_parameter_makes_zero_are_single_runs():
    mechanism = mechanism_from_text(FALLING.replace("SLIP", "c*y_dot"))
    rows = ps.simulate_batch(mechanism, "rigid", {"y": [0.01, 0.02]}, t_end=0.1)
    run = ps.simulate(mechanism, "rigid", {"y": 0.02}, t_end=0.1)
    assert rows["y"][1] == run.final["y"] == rows.trajectory(1).final["y"]
    assert list(rows["stop_reason"]) == ["t_end", "t_end"]


def test_slip_that_is_there_is_kept():
    mechanism = mechanism_from_text(FALLING.replace("SLIP", "c*x_dot"))
    run = ps.simulate(mechanism, "rigid", {"y": 0.0}, parameters={"c": 0.5}, t_end=0.1)
    assert run.final["x"] == pytest.approx(0.0, abs=1e-12)


def test_derivatives_of_a_fall_and_its_bounce_are_those_of_closed_form():
    """A fall of h and a bounce with e, at time t: y = e w s - g s**2/2, s = t - w/g, w**2 = 2gh."""
    h, g, e, t = 0.01, 9.81, 0.75, 0.08
    mechanism = mechanism_from_text(FALLING.replace("SLIP", "c*y_dot"))
    motion = ps.Simulator(mechanism, "rigid").sensitivities({"y": h}, ["y"], t_end=t)
    w = math.sqrt(2 * g * h)
    s = t - w / g
    by_w = e * s - e * w / g + s
    assert motion.trajectory.final["y"] == pytest.approx(e * w * s - g * s**2 / 2, rel=1e-9)
    assert motion.final_gradient("y")["y"] == pytest.approx(by_w * g / w, rel=1e-8)
