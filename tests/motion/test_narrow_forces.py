"""A user's force that is narrow on the scale of the motion: nothing passes over it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.laws.catalogue import law
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.simulator import Simulator

PUCK = """
name = "puck"
title = "puck over a patch that brakes it"
source = "an exercise"

[coordinates]
x = { unit = "m", meaning = "place along the table" }
y = { unit = "m", meaning = "height above the table" }

[parameters]
m = { default = 2.0, unit = "kg", meaning = "mass", positive = true }
c = { default = 0.4, unit = "kg/s", meaning = "damping in the middle of the patch", lower = 0 }
w = { default = 1e-4, unit = "m", meaning = "width of the patch", positive = true }
mu = { default = 0.0, unit = "1", meaning = "friction coefficient", lower = 0 }

[energy]
kinetic = "m*(x_dot**2 + y_dot**2)/2"
potential = "POTENTIAL"

[forces]
x = "FORCE"

[[contacts]]
name = "table"
gap = "y"
slip_velocity = "x_dot"
friction = "mu"

[start]
y = 0.1
"""


def puck(force: str = "0", potential: str = "0") -> Mechanism:
    text = PUCK.replace("FORCE", force).replace("POTENTIAL", potential)
    return mechanism_from_text(text, name="puck")


@pytest.fixture(scope="module")
def braked() -> Simulator:
    return Simulator(puck("-c*x_dot*exp(-(x/w)**2)"), law("linear"))


@settings(max_examples=20)
@given(exponent=st.floats(-6, -1), speed=st.floats(0.2, 5), start=st.floats(-3, -1))
def test_patch_takes_its_part_of_the_speed(braked, exponent, speed, start):
    """dv/dx = −(c/m) exp(−(x/w)²): beyond the patch v has fallen by √π c w/m."""
    width = 10**exponent
    t_end = (2 - start) / speed
    run = braked.run({"x": start, "x_dot": speed, "y": 0.1}, t_end=t_end, parameters={"w": width})
    lost = math.sqrt(math.pi) * 0.4 * width / 2.0
    assert run.final["x_dot"] == pytest.approx(speed - lost, abs=3e-11 * speed)
    assert isinstance(braked.integrator, TaylorEngine)


@pytest.mark.parametrize("width", [1e-6, 1e-3])
@pytest.mark.parametrize(("height", "turns"), [(0.6, True), (0.4, False)])
def test_narrow_hill_turns_back_what_has_not_the_energy(width, height, turns):
    """Of a puck with ẋ²/2 = 0.5 m²/s²: the hill of `height` in its way takes hardly any time."""
    hill = Simulator(puck(potential="m*c*exp(-(x/w)**2)"), law("linear"))
    start, p = {"x": -1.0, "x_dot": 1.0, "y": 0.1}, {"w": width, "c": height}
    run = hill.run(start, t_end=2.0, parameters=p)
    direction = -1 if turns else 1
    assert run.final["x_dot"] == pytest.approx(direction, abs=1e-9)
    assert run.final["x"] == pytest.approx(direction, abs=10 * width)
    assert run.energy_residual < 1e-9


def test_lanes_of_a_batch_are_the_runs(braked):
    """Each motion meets the patch at another time, and has the bits of its own run."""
    speeds, widths = np.linspace(0.5, 2, 19), np.logspace(-6, -2, 19)
    states = {"x": -1.0, "x_dot": speeds, "y": 0.1}
    batch = run_batch(braked, states, {"w": widths}, t_end=2.5)
    for i, (speed, width) in enumerate(zip(speeds, widths, strict=True)):
        start = {"x": -1.0, "x_dot": float(speed), "y": 0.1}
        run = braked.run(start, t_end=2.5, parameters={"w": float(width)})
        assert batch["x_dot"][i] == run.final["x_dot"]
        assert batch["x"][i] == run.final["x"]
