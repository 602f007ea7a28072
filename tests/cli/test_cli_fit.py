"""The command fit."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.cli_helpers import rejected, run, run_json

FOLDER = Path(__file__).parents[2] / "examples" / "studies" / "fit"
FALL = "theta=1,theta_dot=1,x_A_dot=-1,y_A_dot=-0.02"
COMMAND = ("rod", "--law", "bilinear-hertz", "--estimate", "e_energetic,mu,E")
START = ("--law-set", "E=5e10,e_energetic=0.5", "--set", "mu=1.35")


@pytest.mark.slow
def test_fit_prints_estimates_and_draws(capsys, tmp_path):
    out_file = tmp_path / "force.png"
    code, out, err = run(
        capsys, "fit", FOLDER / "force.csv", *COMMAND, *START, "--state", FALL, "--out", out_file
    )
    assert (code, err) == (0, "")
    assert "history, 101 measured values, 3 unknowns" in out
    assert "95 % interval" in out and "converged" in out
    assert out_file.read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_fit_of_motions_row_by_row_as_json(capsys):
    data = run_json(
        capsys, "fit", FOLDER / "impacts.csv", *COMMAND, *START,
        "--sigma", "y_A_dot=2e-3,theta_dot=4e-3", "--level", "0.9",
    )  # fmt: skip
    assert (data["mechanism"], data["law"], data["level"]) == ("rod", "bilinear-hertz", 0.9)
    assert [e["name"] for e in data["estimates"]] == ["e_energetic", "mu", "E"]
    friction = data["estimates"][1]
    assert friction["interval"][0] < 1.4 < friction["interval"][1]
    assert data["noise"] == {"y_A_dot": 2e-3, "theta_dot": 4e-3}
    assert data["noise_given"] is True


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("none.csv", *COMMAND), "No such file"),
        ((FOLDER / "force.csv", "rod", "--law", "bilinear-hertz"), "--estimate: missing"),
        ((FOLDER / "force.csv", "rod", "--estimate", "mu"), "no contact law"),
        ((FOLDER / "force.csv", *COMMAND, "--level", "2"), "level"),
        ((FOLDER / "force.csv", *COMMAND, "--out", "x.txt"), "--out"),
    ],
)
def test_fit_refuses_bad_input_in_one_line(capsys, arguments, said):
    assert said in rejected(capsys, "fit", *arguments)
