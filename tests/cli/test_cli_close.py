"""``--close`` and the mechanism's own start, in every command that takes a state."""

from __future__ import annotations

import math

import pytest

import painleve_sym as ps
from tests.cli.cli_helpers import LAW, STIFF, TABLE_4, rejected, run, run_json

ROBOT = ("pr-robot", "--state", "theta=0.7,x_dot=-1", "--close", "theta")
RIGID = ("--law", "rigid", "--t-end", "0.001")
COMMANDS = {
    "classify": ("classify",),
    "jump": ("jump",),
    "simulate": ("simulate", *RIGID),
}


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_a_command_closes_the_contact(capsys, command):
    code, out, err = run(capsys, command[0], *ROBOT, *command[1:])
    assert (code in (0, 3), err) == (True, "")
    assert "theta = 0.927295 rad, x_dot = -1 m/s (others 0)" in " ".join(out.split())


def test_critical_and_a_scenario_file_close_too(capsys, tmp_path):
    plain = run_json(capsys, "critical", "rod", "--state", TABLE_4, *STIFF)
    lifted = ("critical", "rod", "--state", f"{TABLE_4},y_A=0.25", *STIFF, "--close", "y_A")
    assert run_json(capsys, *lifted)["critical"] == plain["critical"]
    path = tmp_path / "robot.toml"
    path.write_text('model = "pr-robot"\nclose = "theta"\nstate = { theta = 0.7, x_dot = -1 }\n')
    state = run_json(capsys, "classify", path)["state"]
    assert state["theta"] == pytest.approx(math.asin(0.8), abs=1e-12)


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_without_a_state_a_command_takes_the_start_and_says_so(capsys, command):
    _, out, err = run(capsys, command[0], "rod", *command[1:])
    assert "theta = 1 rad" in out and err == ""
    assert "(others 0), the mechanism's own start" in " ".join(out.split())
    _, out, _ = run(capsys, command[0], "rod", *command[1:], "--state", "theta=1,x_A_dot=-1")
    assert "own start" not in out


def test_the_start_is_that_of_the_model(capsys):
    assert run_json(capsys, "classify", "rod")["state"] == {
        **dict.fromkeys(ps.model("rod").state_names, 0.0),
        **ps.model("rod").start,
    }
    own = run_json(capsys, "simulate", "rod", *LAW, "--t-end", "1e-4")
    start = ps.model("rod").start
    given = ",".join(f"{n}={v!r}" for n, v in start.items())
    assert own == run_json(capsys, "simulate", "rod", *LAW, "--t-end", "1e-4", "--state", given)


def test_an_exported_example_starts_closed(capsys, tmp_path):
    words = ("export", "rod", "--law", "rigid", "--t-end", "0.1", "--state")
    closed = ("theta=1,x_A_dot=-1,y_A=0.25", "--close", "y_A", "--out", tmp_path / "closed")
    plain = ("theta=1,x_A_dot=-1", "--out", tmp_path / "plain")
    assert run(capsys, *words, *closed)[0] == run(capsys, *words, *plain)[0] == 0
    for path in (tmp_path / "plain").glob("*.c"):
        assert (tmp_path / "closed" / path.name).read_text() == path.read_text()


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (("classify", "rod", "--state", "theta=1,y_A=0.1"), "--close y_A, in Python close='y_A'"),
        (("jump", "rod", "--state", "theta=1,y_A=0.1"), "--close y_A, in Python"),
        (("classify", "block-two-feet", "--state", "y_A=-0.1"), "--close B:y_A or --close B:theta"),
        (("classify", "block-two-feet", "--state", "y_A=0.1"), "close one with --close A:y_A"),
    ],
)
def test_an_open_contact_names_what_closes_it(capsys, words, hint):
    assert hint in rejected(capsys, *words)


@pytest.mark.parametrize(("axes", "named"), [("theta_1,mu", True), ("theta_1,theta_2", False)])
def test_a_map_of_open_contacts_names_what_closes_them(capsys, axes, named):
    _, _, err = run(capsys, "map", "two-link-arm", "--over", axes, "--points", "8")
    assert "the map is drawn as if the contact were closed." in err
    assert ("--close theta_2, in Python close='theta_2'" in err) == named
