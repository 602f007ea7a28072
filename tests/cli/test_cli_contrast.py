"""painleve contrast: JSON keys, text, figure, bad input."""

from __future__ import annotations

import pytest

from tests.cli.cli_helpers import ROOT, TABLE_3, TABLE_4, rejected, run, run_json

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
    assert all(step["contact_velocity"] == [0, 0] for step in data["stepping"])
    assert first["tangential_impulse"] == [pytest.approx(0.48878, rel=2e-3)]
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
    assert f"drawn: {file}" in " ".join(out.split())  # a long path is on a line of its own
    assert file.read_bytes().startswith(b"\x89PNG")
    assert list(tmp_path.iterdir()) == [file]


JAMMED = ("contrast", "strut", "--state", "theta=0.9272952180016122", "--set", "mu=2", *QUICK)


@pytest.mark.slow
def test_rigid_motion_that_jams_is_a_row(capsys):
    code, out, err = run(capsys, *JAMMED)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    (row,) = [line for line in lines if line.startswith("energetic ")]
    assert row.split() == ["energetic", "jam", "*", "1.25", "0.41667"]
    assert any(line.split()[:3] == ["compliant", "E", "2.09e+15"] for line in lines)
    assert sum("h 0.001 *" in line for line in lines) == 2
    said = " ".join(out.split())
    assert "*) ended early (jam): the contact impulse grows without end" in said
    assert "energetic at t = 0 s, theta = 0.927295 rad, theta_dot = 1.25 rad/s" in said
    assert "lemke at t = 0 s (h 0.001)" in said
    assert "rigid jump with e = 0.75: jams at theta_dot = 1.25 rad/s" in said
    assert "tends to the rigid jump" not in said
    assert "only compliant motion does" in said


@pytest.mark.slow
def test_rigid_motion_that_jams_as_json(capsys):
    data = run_json(capsys, *JAMMED)
    first, second = data["rigid"]["motions"]
    assert (first["way"], second["way"]) == ("energetic", "newton")
    assert (first["stop_reason"], first["time"]) == ("jam", 0)
    assert "no exit" in first["stop_detail"]
    assert first["state"] == {"theta": 0.9272952180016122, "theta_dot": pytest.approx(1.25)}
    assert first["events"][-1] == {"time": 0, "kind": "jam"}
    assert first["limit"] is None
    assert data["rigid"]["jump"]["e"]["end"] == "jam"
    assert [a["stop_reason"] for a in data["stepping"]] == ["no_mode"] * 2
    assert data["softened"][0]["stop_reason"] == "t_end"
    assert data["softened"][0]["error"] is None
    assert data["orders"]["stiffness_expected"] is None


@pytest.mark.slow
def test_figure_of_rigid_motion_that_jams(capsys, tmp_path):
    file = tmp_path / "jam.svg"
    code, _, err = run(capsys, *JAMMED, "--out", file)
    assert (code, err) == (0, "")
    drawn = file.read_text()
    assert "no error: the rigid motion," in drawn and "rigid, energetic (jam)" in drawn


@pytest.mark.parametrize("case", ["block-two-feet", "ladder"])
def test_several_contacts_are_refused_in_one_sentence(capsys, case):
    err = rejected(capsys, "contrast", case, "--state", "theta=1")
    assert "got 2 contacts, need one, since time stepping" in err and "--contact" in err


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
    assert words in rejected(capsys, "contrast", "rod", "--state", TABLE_3, *options)


def test_state_must_be_outside_the_ground(capsys):
    err = rejected(capsys, "contrast", "rod", "--state", f"{TABLE_3},y_A=-1e-6")
    assert "inside the ground" in err


@pytest.mark.slow
def test_no_restitution_compares_with_the_plastic_jump(capsys):
    """Compliant contacts give nothing back: their motions end with the compression."""
    data = run_json(capsys, "contrast", "rod", "--restitution", "0")
    assert data["restitution"] == 0
    assert {row["stop_reason"] for row in data["softened"]} == {"accumulation"}
    assert all(abs(row["velocity"]["y_A_dot"]) < 1e-6 for row in data["softened"])


# ---- in space ----

FOOT = (
    *("contrast", ROOT / "examples/robots/quadruped.urdf", "--contact", "LF_foot"),
    *("--pose", "standing", "--set", "mu=2", "--contact-velocity", "0,1,0"),
)


def test_contact_in_space_as_json(capsys):
    data = run_json(capsys, "contrast", "rod-3d", "--state", TABLE_3)
    assert data["frozen"] is True and data["steps_miss_turn"] is False
    level = data["acceleration_level"]
    assert (level["case"], level["solutions"]) == ("inconsistent", [])
    assert level["lemke"] is level["mpcc"] is None
    (solution,) = data["velocity_level"][0]["solutions"]
    assert solution["mode"] == "stick" and solution["slip_velocity"] == [0, 0]
    assert len(solution["tangential_impulse"]) == 2
    ways = [a["way"] for a in data["rigid"]["motions"]]
    assert ways == ["energetic", "poisson", "newton", "plastic"]
    assert data["rigid"]["motions"][0]["contact_velocity"] == pytest.approx(
        [0.05247, 0, 0], abs=5e-6
    )
    assert [s["step"] for s in data["stepping"]] == [1e-3, 1e-4, 1e-5] * 2
    softened = data["softened"][-1]
    assert (softened["complete"], softened["reference"]) == (True, "energetic")
    assert softened["velocity"]["theta_dot"] == pytest.approx(1.609, abs=1e-3)


def test_contact_of_a_robot_as_text_and_figure(capsys, tmp_path):
    file = tmp_path / "foot.svg"
    code, out, err = run(capsys, *FOOT, "--out", file)
    assert (code, err) == (0, "")
    rows = [line.split() for line in out.splitlines()]
    (energetic,) = (row for row in rows if row[:1] == ["energetic"])
    assert energetic == ["energetic", "0.19438", "0", "0", "0.33644", "0"]
    (knee,) = (row for row in rows if row[:1] == ["LF_KFE_dot"])
    assert knee[2:4] == ["0.221989", "-1.3311"]
    said = " ".join(out.split())
    assert "the configuration, and so W and b, is frozen" in said
    assert "Time stepping meets no paradox" in said and "tends to the rigid jump" in said
    assert "ideal torque control" in said
    assert all(len(line) <= 100 for line in out.splitlines())
    drawn = file.read_text()
    assert "part of the duration" in drawn and "least-impulse, one step" in drawn


def test_slip_that_turns_is_told(capsys):
    state = f"{TABLE_3},y_A_dot=0.6,z_A_dot=-1"
    code, out, _ = run(capsys, "contrast", "rod-3d", "--state", state, "--set", "mu=0.3")
    assert code == 0
    assert "no step, however short, comes nearer to the jump than about 0.027" in " ".join(
        out.split()
    )


def test_scenario_of_a_robot(capsys, tmp_path):
    robot = ROOT / "examples/robots/quadruped.urdf"
    file = tmp_path / "foot.toml"
    file.write_text(
        f'model = "{robot}"\ncontact = "LF_foot"\ncontact_velocity = [0, 1, 0]\n'
        'restitution = 0.5\nparameters = { mu = 2.0 }\n[robot]\npose = "standing"\n'
    )
    data = run_json(capsys, "contrast", file, "--stiffness", "20.9e14", "--steps", "1e-4")
    assert data["restitution"] == 0.5
    assert data["rigid"]["jump"]["e"]["velocity"]["LF_KFE_dot"] == pytest.approx(-0.8874, abs=1e-4)
    assert "ideal torque control" in " ".join(data["notices"])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (("rod-3d", "--state", "theta=1,z_A=0.1"), "starts above the ground"),
        (("rod-3d", "--state", TABLE_3, "--solvers", "mpcc"), "unknown solver 'mpcc'"),
        (("rod-3d", "--state", TABLE_3, "--contact-velocity", "0,1"), "need 3 finite numbers"),
        (FOOT[1:4], "mu: missing"),
        (FOOT[1:2], "no contact"),
        (("rod", "--state", TABLE_3, "--pose", "standing"), "need the file of a robot"),
    ],
)
def test_faults_in_space_are_one_sentence(capsys, call, words):
    assert words in rejected(capsys, "contrast", *call)
