"""A rimless wheel with eight rigid contacts: against quadrature and Newton's impact."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator

SPOKES = 8
SLOPE, INERTIA, GRAVITY = 0.08, 0.5, 9.81
HALF = np.pi / SPOKES
WHEEL = """
name = "rimless-wheel"
gravity = ["g*sin(gamma)", "-g*cos(gamma)"]
[coordinates]
x = { unit = "m", meaning = "hub along the slope, downhill" }
y = { unit = "m", meaning = "hub above the slope" }
theta = { unit = "rad", meaning = "rotation, downhill positive" }
[parameters]
m = { default = 1.0, unit = "kg", meaning = "mass", positive = true }
l = { default = 1.0, unit = "m", meaning = "length of a spoke", positive = true }
j = { default = 0.5, unit = "1", meaning = "moment of inertia over m l^2", positive = true }
g = { default = 9.81, unit = "m/s^2", meaning = "gravity", lower = 0 }
gamma = { default = 0.08, unit = "rad", meaning = "slope" }
mu = { default = 2.0, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = "m"
inertia = "j*m*l**2"
angle = "-theta"
centre = ["x", "y"]
"""
SPOKE = """
[[contacts]]
name = "s{i}"
point = ["x - l*sin(theta - 2*{i}*pi/{n})", "y - l*cos(theta - 2*{i}*pi/{n})"]
friction = "mu"
"""


def _walk() -> tuple[float, float]:
    """Return period and rate just after an impact of the steady walk about the foot that stands."""
    kept = (INERTIA + np.cos(2 * HALF)) / (INERTIA + 1)
    gained = 4 * GRAVITY / (1 + INERTIA) * np.sin(HALF) * np.sin(SLOPE)
    after = np.sqrt(kept**2 * gained / (1 - kept**2))

    def pace(angle: float) -> float:
        fallen = np.cos(SLOPE - HALF) - np.cos(angle)
        return 1 / np.sqrt(after**2 + 2 * GRAVITY / (1 + INERTIA) * fallen)

    period, _ = quad(pace, SLOPE - HALF, SLOPE + HALF, epsabs=1e-14, epsrel=1e-14)
    return period, after


@pytest.mark.slow
def test_ten_steps_of_a_wheel_take_ten_times_the_period(tmp_path):
    path = tmp_path / "wheel.toml"
    path.write_text(WHEEL + "".join(SPOKE.format(i=i, n=SPOKES) for i in range(SPOKES)))
    period, rate = _walk()
    start = {"y": np.cos(HALF), "theta": -HALF, "theta_dot": rate}
    start |= {"x_dot": rate * np.cos(HALF), "y_dot": rate * np.sin(HALF)}
    wheel = Simulator(model(str(path)), law("rigid", restitution="newton"))
    run = wheel.run(start, t_end=10.5 * period, rtol=1e-12, parameters={"e_newton": 0.0})
    times = [e.time for e in run.events if e.kind.value == "touchdown"]
    np.testing.assert_allclose(times, period * np.arange(1, 11), rtol=0, atol=1e-10)
    rates = [e.state["theta_dot"] for e in run.events if e.kind.value == "impact"]
    np.testing.assert_allclose(rates, rate, rtol=1e-11)
