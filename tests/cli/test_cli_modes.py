"""Bodies with modes on a rigid contact: every command that asks about it says what it means."""

from __future__ import annotations

import pytest

from tests.cli.cli_helpers import run, run_json

STATE = ("--state", "theta=1,theta_dot=5,x_A_dot=-1")
SAID = "Body rod has finitely many modes. On a rigid contact its thresholds of friction do not"
COMMANDS = {
    "classify": STATE,
    "jump": ("--state", "theta=1,x_A_dot=-1,y_A_dot=-1"),
    "map": ("--over", "theta,theta_dot", "--points", "5"),
    "critical": STATE,
}


@pytest.mark.parametrize(
    "command",
    [pytest.param(c, marks=pytest.mark.slow if c in ("map", "critical") else ()) for c in COMMANDS],
)
def test_body_with_modes_gets_a_notice(capsys, command):
    # An axial mode is derived in less time; a bending one has several solutions.
    modes = "1,0" if command == "critical" else "0,1"
    arguments = (command, f"rod-bending:{modes}", *COMMANDS[command])
    code, out, _ = run(capsys, *arguments)
    assert code == 0 and SAID in " ".join(out.split())
    assert any(notice.startswith(SAID) for notice in run_json(capsys, *arguments)["notices"])


@pytest.mark.parametrize("command", ["classify", "jump", "map"])
def test_rigid_bodies_get_none(capsys, command):
    arguments = (command, "rod", *COMMANDS[command])
    code, out, _ = run(capsys, *arguments)
    assert code == 0 and "finitely many modes" not in " ".join(out.split())
    assert not run_json(capsys, *arguments).get("notices")
