"""Printed answers: each number is one of the JSON of the command, and stands under its heading."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.cli import robot as robot_command
from painleve_sym.robots.contact_risk import LeastRisk
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


def table_of(out, *heads):
    """Return the rows of the printed table whose head begins so, as numbers and words by head."""
    lines = out.splitlines()
    at = next(i for i, line in enumerate(lines) if line.split()[: len(heads)] == [*heads])
    names = re.split(r"\s{2,}", lines[at].strip())
    rows = []
    for line in lines[at + 1 :]:
        if not line.startswith(" ") and not line[:1].isdigit():
            break
        cells = re.split(r"\s{2,}", line.strip())
        if len(cells) != len(names):
            break
        rows.append(dict(zip(names, cells, strict=False)))
    return rows


def near(text, value):
    return abs(float(text) - value) <= last_digit(text)


def test_columns_of_events_are_those_of_the_json(capsys):
    words = COMMANDS["simulate"]
    _, out, _ = run(capsys, *words)
    events = run_json(capsys, *words)["events"]
    rows = table_of(out, "time", "[s]")
    assert len(rows) == len(events) > 3
    for row, event in zip(rows, events, strict=True):
        assert near(row["time [s]"], event["time"]) and row["event"] == event["kind"]
        assert row["mode after"] == event["mode_after"]
        assert near(row["F_n [N]"], event["normal_force"])
        assert near(row["depth [m]"], event["compression"])
    assert len({e["normal_force"] for e in events}) > 2


def test_the_end_of_a_motion_is_that_of_the_json(capsys):
    words = COMMANDS["simulate"]
    _, out, _ = run(capsys, *words)
    data = run_json(capsys, *words)
    rows = {row["state"]: row["value"] for row in table_of(out, "state", "value")}
    final = data["final"]["state"] | data["final"]
    assert {"theta", "x_A_dot", "normal_force"} < rows.keys()
    for name, printed in rows.items():
        assert near(printed, final[name]), name
    assert f"{len(data['events'])} events" in out
    residual = re.search(r"energy closes to (\S+),", out)[1]
    assert near(residual, data["energy_residual"])


def test_columns_of_a_jump_are_those_of_the_json(capsys):
    words = COMMANDS["jump"]
    _, out, _ = run(capsys, *words)
    data = run_json(capsys, *words)
    rows = table_of(out, "phase", "P_n")
    assert len(rows) == len(data["phases"]) == 3
    for row, phase in zip(rows, data["phases"], strict=True):
        assert row["phase"] == phase["name"]
        assert near(row["P_n [N s]"], phase["normal_impulse"])
        assert near(row["P_t [N s]"], *phase["tangential_impulse"])
        assert near(row["stored [J]"], phase["stored_energy"])


def test_shares_of_a_map_are_those_of_their_cases(capsys):
    words = COMMANDS["map"]
    _, out, _ = run(capsys, *words)
    data = run_json(capsys, *words)
    total = sum(data["counts"].values())
    for case, count in data["counts"].items():
        share = re.search(rf"^\s*{case}\s+([\d.]+) %", out, re.M)
        if count:
            assert near(share[1], 100 * count / total), case


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


class Report:
    """Random poses of a robot whose thresholds are 1 to 100, and 1 in 4 at risk."""

    distribution = np.arange(100.0, 0.0, -1.0)
    share_at_risk = 0.25


def test_quantiles_and_shares_of_poses_are_those_of_their_data(capsys):
    robot_command._show_poses(Report(), LeastRisk(0.5, {"knee": 0.25}))
    out = capsys.readouterr().out
    assert "mu_P of 100 random poses, 5, 50 and 95 %: 5, 50, 95\n" in out
    assert "share of poses at risk: 25 %\n" in out
    assert "least mu_P that a search over joint limits reached: 0.5\n" in out
    assert "at knee = 0.25\n" in out


def test_the_sector_of_a_robot_is_printed_in_degrees(capsys):
    words = ("robot", ARM, "--contact", "finger", "--mu", "5", "--joints", "pitch=0.1")
    _, out, _ = run(capsys, *words, "--poses", "3")
    data = run_json(capsys, *words, "--poses", "3")
    half = math.acos(data["mu_P"] / 5)
    assert data["sector"]["half_angle"] == pytest.approx(half)
    assert near(re.search(r"paradox within ([\d.]+) deg", out)[1], math.degrees(half))
    direction = math.degrees(math.atan2(*reversed(data["sector"]["direction"])))
    assert near(re.search(r"direction of slip: (\S+) deg", out)[1], direction)


def test_share_of_poses_is_that_of_the_thresholds(capsys):
    data = run_json(capsys, *COMMANDS["robot"])
    assert data["share_at_risk"] == pytest.approx(np.mean(thresholds_of_poses() < 1.7))
    assert 0 < data["share_at_risk"] < 1
    _, out, _ = run(capsys, *COMMANDS["robot"])
    printed = re.search(r"5, 50 and 95 %: (.*)", out)[1].split(", ")
    assert all(map(near, printed, quantiles_of_poses()))
