"""Printed answers: each number is one of the JSON of the command, and stands under its heading."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import painleve_sym as ps
from tests.cli.cli_helpers import ROOT, TABLE_3, TABLE_4, run, run_json

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w]|\.\d)")
LAW = ("--law", "bilinear-hertz")
FALL = "theta=1,x_A_dot=-1,y_A_dot=-0.2"
ARM = str(ROOT / "examples" / "robots" / "desk_arm.xml")
COMMANDS = {
    "classify": ("classify", "rod", "--state", TABLE_3),
    "classify feet": ("classify", "block-two-feet"),
    "classify in space": ("classify", "rod-3d"),
    "jump": ("jump", "rod", "--state", FALL, "--rule", "poisson", "--restitution", "0.37"),
    "jump in space": ("jump", "rod-3d", "--state", "theta=1,x_A_dot=-1,z_A_dot=-0.2"),
    "simulate": ("simulate", "rod", "--state", TABLE_3, *LAW, "--t-end", "0.01"),
    "simulate feet": ("simulate", "block-two-feet", "--law", "rigid", "--t-end", "0.3"),
    "critical": ("critical", "rod", "--state", TABLE_4, *LAW, "--set", "mu=1.5"),
    "map": ("map", "rod", "--over", "theta,theta_dot", "--points", "21"),
    "contrast": ("contrast", "rod", "--state", TABLE_3),
    "robot": ("robot", ARM, "--contact", "finger", "--mu", "1.7", "--poses", "40"),
    "models": ("models", "rod"),
    "laws": ("laws", "hertz"),
}
NOT_OF_THE_ANSWER = {
    "jump in space": {0.75},  # the default of the coefficient
    "robot": {0.75, 5.0, 50.0, 95.0},  # a coefficient and quantiles that the sentence names
}


def numbers_of(data):
    """Yield every number of JSON data, those in its texts and the lengths of its lists too."""
    if isinstance(data, dict):
        yield len(data)
        for value in data.values():
            yield from numbers_of(value)
    elif isinstance(data, list):
        yield len(data)
        for value in data:
            yield from numbers_of(value)
    elif isinstance(data, str):
        yield from map(float, NUMBER.findall(data))
    elif isinstance(data, int | float) and not isinstance(data, bool):
        yield float(data)


def last_digit(text):
    """Return half a unit of the last digit of a printed number."""
    mantissa, _, power = text.lower().partition("e")
    return 0.5000001 * 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))


def thresholds_of_poses():
    """Return the thresholds of friction at the random poses of the command `robot`."""
    finger = ps.robot(ARM).contact("finger")
    return np.sort(finger.thresholds(finger.random_poses(40)))


def quantiles_of_poses():
    return [thresholds_of_poses()[math.ceil(part * 40) - 1] for part in (0.05, 0.5, 0.95)]


def derived(name, data):
    """Return numbers that a command prints and that follow from others of its answer."""
    if name == "map":
        total = sum(data["counts"].values())
        parts = [100 * count / total for count in data["counts"].values()]
        return [*parts, 100 * data["stick_feasible_count"] / total]
    if name == "critical":
        return [sum(data["expansion"].values())]
    if name == "robot":
        return [*quantiles_of_poses(), math.atan2(*reversed(data["direction"]))]
    if name.startswith("jump"):  # which leaves out the defaults of its mechanism
        angles = [math.atan2(*reversed((*p["direction"], 0.0)[:2])) for p in data["phases"]]
        return [*ps.model(COMMANDS[name][1]).parameters.values(), *angles]
    return []


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n == "contrast" else ()) for n in COMMANDS]
)
@pytest.mark.filterwarnings("ignore")
def test_every_printed_number_is_one_of_the_json(name, capsys):
    words = COMMANDS[name]
    code, out, err = run(capsys, *words)
    assert code in (0, 3), err
    data = run_json(capsys, *words, code=code)
    known = np.array([*numbers_of(data), *derived(name, data)])
    known = np.concatenate([known, 100 * known, np.degrees(known[np.abs(known) < 7])])
    given = [float(n) for word in words for n in NUMBER.findall(re.sub("[=,]", " ", word))]
    every = np.concatenate([known, given, sorted(NOT_OF_THE_ANSWER.get(name, ()))])
    printed = NUMBER.findall(out)
    assert len(printed) > 8
    for text in printed:
        away = np.abs(every - float(text)).min()
        assert away <= last_digit(text), f"{text} of {out}"


# ---- columns ----


def near(text, value):
    return abs(float(text) - value) <= last_digit(text)


def test_coefficients_of_a_contact_stand_at_their_names(capsys):
    for words in (COMMANDS["classify"], ("classify", "rod", "--state", TABLE_4)):
        _, out, _ = run(capsys, *words)
        data = run_json(capsys, *words)
        assert f"case: {data['case']} (" in out
        (own,) = data["contacts"].values()
        for name in ("A", "B"):
            printed = re.search(rf"(?<![\w']){name} = (\S+)", out)
            if printed:
                assert near(printed[1].rstrip(","), own[name]), name


def test_the_sector_of_a_robot_is_printed_in_degrees(capsys):
    words = ("robot", ARM, "--contact", "finger", "--mu", "5", "--joints", "pitch=0.1")
    _, out, _ = run(capsys, *words, "--poses", "3")
    data = run_json(capsys, *words, "--poses", "3")
    half = math.acos(data["mu_P"] / 5)
    assert data["sector"]["half_angle"] == pytest.approx(half)
    assert near(re.search(r"paradox within ([\d.]+) deg", out)[1], math.degrees(half))
    direction = math.degrees(math.atan2(*reversed(data["sector"]["direction"])))
    assert near(re.search(r"direction of slip: (\S+) deg", out)[1], direction)
