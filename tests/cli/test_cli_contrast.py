"""painleve contrast: JSON keys, text, figure, bad input."""

from __future__ import annotations

import pytest

from tests.cli.cli_helpers import TABLE_3, TABLE_4, run, run_json

QUICK = ("--steps", "1e-3", "--stiffness", "20.9e14", "--solvers", "least-impulse,lemke")


def test_table_3_as_json(capsys):
    data = run_json(capsys, "contrast", "rod", "--state", TABLE_3, *QUICK)
    level = data["acceleration_level"]
    assert (level["case"], level["solutions"]) == ("inconsistent", [])
    assert level["lemke"] == {"status": "ray", "normal_force": None}
    assert level["mpcc"]["normal_forces"] == []
    assert data["plastic_jump_unnoticed"] is True
    assert data["solver_dependent"] is False
    assert [s["solver"] for s in data["stepping"]] == ["least-impulse", "lemke"]
    first = data["stepping"][0]
    assert first["solutions_per_first_step"] == 1
    assert first["velocity"]["x_A_dot"] == pytest.approx(0, abs=1e-12)
    assert data["softened"][0]["E"] == 20.9e14
    assert data["softened"][0]["events"][0]["kind"] == "slip_stop"
    assert data["rigid"]["jump"]["e"]["velocity"]["y_A_dot"] == pytest.approx(0.05247, abs=5e-6)
    assert data["orders"]["stiffness"] == []


@pytest.mark.slow
def test_table_4_as_text(capsys):
    code, out, err = run(capsys, "contrast", "rod", "--state", TABLE_4, *QUICK)
    assert (code, err) == (0, "")
    assert "accelerations: indeterminate" in out
    assert "depends on the solver" in out
    assert all(len(line) <= 100 for line in out.splitlines())


def test_figure_is_written_whole(capsys, tmp_path):
    file = tmp_path / "contrast.png"
    shown = ("contrast", "rod", "--state", TABLE_3, *QUICK, "--t-end", "2e-3", "--out", file)
    code, out, _ = run(capsys, *shown)
    assert code == 0
    assert f"drawn: {file}" in " ".join(out.split())  # a long path goes on the next line
    assert file.read_bytes().startswith(b"\x89PNG")
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--steps", "0"), "--steps: got 0"),
        (("--steps", "-1e-3"), "--steps: got -0.001"),
        (("--steps", "1e-3,"), "--steps: got ''"),
        (("--steps", "nan"), "--steps: got 'nan'"),
        (("--steps", "1"), "step: got 1.0"),
        (("--stiffness", "-1"), "--stiffness: got -1"),
        (("--stiffness", "stiff"), "--stiffness: got 'stiff'"),
        (("--solvers", "lemk"), "Did you mean 'lemke'?"),
        (("--solvers", ""), "unknown solver ''"),
        (("--restitution", "1.5"), "0 <= e_energetic <= 1"),
        (("--restitution", "nan"), "need a finite number"),
        (("--t-end", "0"), "t_end: got 0.0"),
        (("--set", "mu=-1"), "0 <= mu"),
        (("--out", "contrast.txt"), "need one of"),
        (("--stpes", "1e-3"), "Did you mean '--steps'?"),
    ],
)
def test_bad_input_is_one_sentence(capsys, options, words):
    code, out, err = run(capsys, "contrast", "rod", "--state", TABLE_3, *options)
    assert (code, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1


def test_state_is_needed_and_must_be_outside_the_ground(capsys):
    code, _, err = run(capsys, "contrast", "rod")
    assert code == 2 and "--state" in err
    code, _, err = run(capsys, "contrast", "rod", "--state", f"{TABLE_3},y_A=-1e-6")
    assert code == 2 and "inside the ground" in err
