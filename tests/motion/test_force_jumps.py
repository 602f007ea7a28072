"""Forces that jump where a velocity is 0: a run that they hold ends early and says why."""

from __future__ import annotations

import pytest

import painleve_sym as ps
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text

SLIDER = """
name = "rubbed-mass"
[coordinates]
x = { unit = "m", meaning = "place" }
y = { unit = "m", meaning = "height" }
[parameters]
m = { default = 2.0, unit = "kg", meaning = "mass", positive = true }
f = { default = 1.0, unit = "N", meaning = "rubbing force" }
p = { default = 0.0, unit = "N", meaning = "pull" }
g = { default = 9.81, unit = "m/s^2", meaning = "gravity", lower = 0 }
mu = { default = 0.0, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[forces]
x = "p - f*x_dot/abs(x_dot)"
y = "-m*g"
[[contacts]]
name = "floor"
gap = "y"
slip_velocity = "SLIP"
friction = "mu"
"""
START = {"x_dot": 1.0}


def slider(slip="0"):
    return mechanism_from_text(SLIDER.replace("SLIP", slip))


@pytest.mark.parametrize("law", ["rigid", "linear"])
@pytest.mark.parametrize("record", ["dense", "end"])
def test_run_that_a_force_holds_at_rest_ends_early_with_the_way_out(law, record):
    """The mass stops after m v/(f + p) = 2 s and m v²/(2 f) = 1 m."""
    state = START if law == "rigid" else {**START, "y": -2 * 9.81 / 1e8}
    run = ps.simulate(slider(), law, state, t_end=5, record=record)
    assert run.stop_reason is ps.StopReason.FORCE_JUMP
    assert run.final_time == pytest.approx(2, abs=1e-3)
    assert run.final["x"] == pytest.approx(1, abs=1e-6)
    assert run.counters["accepted_steps"] <= 50_000
    assert "x_dot" in run.stop_detail and "sqrt(x_dot**2 + w**2)" in run.stop_detail
    assert "max_steps" not in run.stop_detail


def test_run_with_a_force_that_jumps_passes_where_the_force_does_not_hold_it():
    """A pull of 3 N turns the mass: ẍ = (−3 + 1)/2 after, −4/2 before it stands at t = 1/2."""
    run = ps.simulate(slider(), "rigid", START, parameters={"p": -3}, t_end=2)
    assert run.stop_reason is ps.StopReason.T_END
    assert run.final["x_dot"] == pytest.approx(-1.5, abs=1e-8)


@pytest.mark.parametrize("law", ["rigid", "linear"])
def test_run_whose_slip_stops_where_a_force_jumps_rests_or_ends(law):
    """The event sets the velocity to 0, where the force is 0, too."""
    state = START if law == "rigid" else {**START, "y": -2 * 9.81 / 1e8}
    run = ps.simulate(slider("x_dot"), law, state, t_end=5)
    assert run.stop_reason in (ps.StopReason.T_END, ps.StopReason.FORCE_JUMP)
    assert run.final["x"] == pytest.approx(1, abs=1e-6)
    assert run.final["x_dot"] == pytest.approx(0, abs=1e-6)
    assert len(run.events) < 200


def test_force_that_jumps_is_zero_at_rest():
    run = ps.simulate(slider(), "rigid", {}, parameters={"f": 0}, t_end=1)
    assert (run.stop_reason, run.final["x"]) == (ps.StopReason.T_END, 0)
    run = ps.simulate(slider(), "rigid", {}, t_end=1)
    assert (run.stop_reason, run.final["x"]) == (ps.StopReason.T_END, 0)


def test_long_run_without_such_a_force_is_not_cut_short():
    start, short = {"y_A": 0.1, "theta": 1.0}, {"max_step": 1e-6, "t_end": 0.1}
    run = ps.simulate("rod", "rigid", start, engine="compiled", **short)
    assert run.stop_reason is ps.StopReason.T_END
    assert run.counters["accepted_steps"] > 99_000
