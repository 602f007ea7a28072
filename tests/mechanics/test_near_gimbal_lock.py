"""Near gimbal lock an answer says how many digits of it are certain, against W without angles."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import painleve_sym as ps
from tests.cli.cli_helpers import run, run_json


def rod_mobility(theta):
    """Return W of the end of a thin rod, rows z, x, y: (1 + 3)/m across its axis, 1/m along it."""
    axis = np.array([math.sin(theta), math.cos(theta), 0.0])
    return np.eye(3) + 3 * (np.eye(3) - np.outer(axis, axis))


@pytest.mark.parametrize("away", [9e-4, 1e-4, 1e-5, 3e-6, 1.2e-6])
def test_digits_near_the_lock_are_told_and_true(away):
    theta = math.pi / 2 - away
    with pytest.warns(ps.PainleveWarning, match="gimbal lock") as caught:
        answer = ps.classify("rod-3d", {"theta": theta, "x_A_dot": -1.0})
    (digits,) = map(int, re.findall(r"than about (\d+) digits", str(caught[0].message)))
    assert 1 <= digits <= 9
    exact = rod_mobility(theta)
    assert np.abs(answer.problem.W - exact).max() <= 10.0**-digits * np.abs(exact).max()


@pytest.mark.parametrize("away", [1.1e-3, 0.1])
def test_nothing_is_said_further_away(away):
    theta = math.pi / 2 - away
    answer = ps.classify("rod-3d", {"theta": theta, "x_A_dot": -1.0})
    np.testing.assert_allclose(answer.problem.W, rod_mobility(theta), rtol=0, atol=2e-9)


@pytest.mark.parametrize(
    "command",
    [
        ("classify", "rod-3d", "--state", "theta=1.5707933,x_A_dot=-1"),
        ("classify", "top", "--state", "theta=1e-5,x_T_dot=1"),
        ("jump", "brick", "--state", "theta=1.5707933,z_C_dot=-1,x_C_dot=-1"),
    ],
)
def test_text_and_json_say_it(capsys, command):
    (notice,) = run_json(capsys, *command)["notices"]
    assert "no more than about" in notice and "gimbal lock" in notice
    text = " ".join(run(capsys, *command)[1].split())
    assert notice in text


def test_map_says_at_how_many_points():
    ranges = {"theta": (1.5, 1.6416), "mu": (0.0, 2.0)}
    with pytest.warns(ps.PainleveWarning, match="gimbal lock") as caught:
        ps.region_map("brick", ("theta", "mu"), ranges=ranges, points=101)
    (said,) = (str(c.message) for c in caught if "gimbal" in str(c.message))
    # One of 101 angles is within 1e-3 rad, 3.7e-6 rad away: 1.4e-11 less 1e-12.
    near = [a for a in np.linspace(*ranges["theta"], 101) if abs(math.cos(a)) < 1e-3]
    assert len(near) == 1
    assert said.startswith("at 101 of ") and "about 4 are certain" in said
