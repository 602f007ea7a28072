"""classify, jump and simulate: the documented JSON keys, and the numbers behind them."""

from __future__ import annotations

import json
import math

import pytest

from painleve_sym.at.cases import classify
from painleve_sym.at.jump import evaluate_jump
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.papers.impact_resolution.claims import TABLES
from tests.cli.cli_helpers import (
    LAW,
    ROOT,
    STIFF,
    TABLE_1,
    TABLE_3,
    TABLE_4,
    only_contact,
    rejected,
    run,
    run_json,
)
from tests.support.paper_law import paper_law

STATE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}


# ---- classify ----


@pytest.mark.parametrize(
    ("number", "case", "solutions"),
    [(1, "slip", 1), (2, "liftoff", 1), (3, "inconsistent", 0), (4, "indeterminate", 2)],
)
def test_classify_json_agrees_with_the_printed_tables(capsys, number, case, solutions):
    table = TABLES[number]
    state = ",".join(f"{name}={value}" for name, value in table.state.items())
    data = run_json(capsys, "classify", "rod", "--state", state)
    own, forces = only_contact(data)
    assert (table.corrected_A or table.A).matches(own["A"])
    assert table.B.matches(own["B"])
    assert data["case"] == case
    assert len(forces) == solutions
    assert {"A_stick", "B_stick"} <= set(own) and {"state", "parameters"} <= set(data)
    for solution in forces:
        keys = {"mode", "normal_force", "tangential_force", "normal_acceleration"}
        assert keys <= set(solution)


def test_classify_json_has_the_numbers_of_the_package_to_the_last_bit(capsys):
    data = run_json(capsys, "classify", "rod", "--state", TABLE_3, "--set", "mu=1.41")
    classification = classify(model("rod"), STATE_3, parameters={"mu": 1.41}).to_dict()
    assert data == json.loads(json.dumps(classification))


def test_classify_text_names_the_case_and_every_solution(capsys):
    code, out, err = run(capsys, "classify", "rod", "--state", TABLE_4)
    assert (code, err) == (0, "")
    assert "case: indeterminate" in out
    assert "332.992" in out
    assert all(len(line) <= 80 for line in out.splitlines())


def test_classify_accepts_state_in_several_options_and_spaces(capsys):
    parts = ("--state", "theta = 1, theta_dot=1", "--state", "x_A_dot=-1")
    together = run_json(capsys, "classify", "rod", *parts)
    assert together == run_json(capsys, "classify", "rod", "--state", TABLE_3)


# ---- jump ----


def test_jump_json_agrees_with_the_package(capsys):
    data = run_json(capsys, "jump", "rod", "--state", TABLE_3, "--restitution", "0.75")
    jump = evaluate_jump(model("rod"), "energetic", STATE_3, parameters={"e_energetic": 0.75})
    assert [p["name"] for p in data["phases"]] == [p.name for p in jump.phases]
    for phase, expected in zip(data["phases"], jump.phases, strict=True):
        assert phase["normal_impulse"] == expected.normal_impulse
        assert phase["stored_energy"] == expected.stored_energy
        assert phase["velocity"] == dict(expected.velocity)
    assert data["final"]["velocity"] == dict(jump.velocity)
    # The rule for a stiff contact, as the notes of the reproduction give it.
    assert data["final"]["velocity"]["y_A_dot"] == pytest.approx(0.05247, abs=0.5e-5)
    assert data["final"]["velocity"]["theta_dot"] == pytest.approx(1.60984, abs=0.5e-5)


def test_jump_text_lists_phases_and_velocities(capsys):
    code, out, err = run(capsys, "jump", "rod", "--state", TABLE_3)
    assert (code, err) == (0, "")
    assert "sticking restitution" in out
    assert "theta_dot [rad/s]" in out
    assert all(len(line) <= 80 for line in out.splitlines())


# ---- simulate ----


def test_simulate_json_is_the_trajectory_of_the_package(capsys):
    options = (*STIFF, "--t-end", "0.01", "--until", "separation")
    data = run_json(capsys, "simulate", "rod", "--state", TABLE_3, *options)
    simulator = Simulator(model("rod"), paper_law(reload="virgin"))
    parameters = {"E": 20.9e14, "e_energetic": 0.75}
    expected = simulator.run(
        STATE_3, t_end=0.01, parameters=parameters, until="separation"
    ).to_dict()
    # Through JSON once, since that makes lists of tuples.
    assert {key: data[key] for key in expected} == json.loads(json.dumps(expected))
    assert data["stop_reason"] == "until"
    assert data["events"][0]["kind"] == "slip_stop"
    assert data["events"][-1]["kind"] == "separation"
    keys = {"time", "kind", "mode_before", "mode_after", "state", "normal_force"}
    for event in data["events"]:
        assert keys | {"tangential_force", "compression"} <= set(event)
    assert {"time", "state", "normal_force"} <= set(data["final"])
    assert abs(data["energy_residual"]) < 1e-9
    assert data["counters"]["accepted_steps"] > 0


def test_simulate_samples_are_even_and_complete(capsys):
    options = (*STIFF, "--t-end", "0.001", "--samples", "11")
    data = run_json(capsys, "simulate", "rod", "--state", TABLE_3, *options)
    samples = data["samples"]
    assert samples["time"] == pytest.approx([i * 1e-4 for i in range(11)], abs=1e-18)
    for name in ("normal_force", "tangential_force", "compression", "gap", "slip_velocity"):
        assert len(samples[name]) == 11
    assert set(data["final"]["state"]) == set(samples["state"])
    last = {name: values[-1] for name, values in samples["state"].items()}
    assert last == pytest.approx(data["final"]["state"], rel=1e-12, abs=1e-15)


def test_simulate_text_fits_the_terminal(capsys):
    options = (*STIFF, "--t-end", "0.01", "--samples", "4")
    code, out, err = run(capsys, "simulate", "rod", "--state", TABLE_3, *options)
    assert (code, err) == (0, "")
    assert "slip_stop" in out and "\nreached the end time t = 0.01 s\n" in out
    assert all(len(line) <= 80 for line in out.splitlines())


def test_depths_of_rounding_are_printed_as_zero(capsys):
    command = ("simulate", "rod", "--state", TABLE_3, *LAW, "--t-end", "0.01")
    _, out, _ = run(capsys, *command)
    rows = [line.split() for line in out.splitlines() if " flight " in line]
    assert [row[-1] for row in rows] == ["0"]
    (liftoff,) = [e for e in run_json(capsys, *command)["events"] if e["kind"] == "liftoff"]
    assert 0 < abs(liftoff["compression"]) < 1e-18


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (
            (*LAW, "--t-end", "1", "--until", "separation"),
            "ended at t = 0.00191978753 s by separation",
        ),
        (("--law", "rigid", "--t-end", "10"), ": the rod lies flat at theta = pi"),
        (
            (
                *("--state", "y_A=0.1,theta=1", "--law", "rigid"),
                *("--t-end", "1", "--until", "touchdown,impact"),
            ),
            "ended at t = 0.142857143 s by impact",
        ),
        (
            ("--law", "rigid", "--t-end", "1", "--max-events", "7"),
            "s: event_limit (max_events was used up",
        ),
    ],
)
def test_the_end_of_a_motion_is_a_sentence(capsys, options, sentence):
    _, out, _ = run(capsys, "simulate", "rod", *options)
    assert sentence in " ".join(out.split())


def test_parameters_of_a_law_keep_their_units_under_another_name(capsys, tmp_path):
    text = (ROOT / "examples" / "mechanisms" / "rod.toml").read_text("utf-8")
    head, parameters, rest = text.partition("[parameters]\n")
    path = tmp_path / "rod.toml"
    path.write_text(f'{head}{parameters}R = {{ default = 0.3, unit = "m" }}\n{rest}', "utf-8")
    _, out, _ = run(capsys, "simulate", path, "--law", "hertz", "--t-end", "1e-4")
    assert "R_law = 0.00645 m, n = 1.5" in " ".join(out.split())


def test_simulate_text_shortens_a_long_list_of_events(capsys):
    options = (*LAW, "--t-end", "0.5")
    code, out, _ = run(capsys, "simulate", "rod", "--state", TABLE_1, *options)
    assert code == 0
    assert " more" in out
    assert len(out.splitlines()) < 70


@pytest.mark.parametrize(
    ("options", "reason", "code"),
    [
        (("--t-end", "0.001"), "t_end", 0),
        (("--t-end", "10", "--until", "slip_stop,separation"), "until", 0),
        (("--t-end", "10"), "left_domain", 0),
        (("--t-end", "1", "--max-steps", "5"), "step_limit", 3),
        (("--t-end", "1", "--max-events", "1"), "event_limit", 3),
    ],
)
def test_simulate_exit_code_tells_how_it_stopped(capsys, options, reason, code):
    data = run_json(capsys, "simulate", "rod", "--state", TABLE_3, *STIFF, *options, code=code)
    assert data["stop_reason"] == reason
    assert "final" in data


# A contact force beyond the largest double: the run ends before its first step.
FLYING_APART = ("--state", "theta=1,y_A=-1e100", "--law", "bilinear-hertz", "--law-set", "n=5")


def test_simulate_never_writes_nan_into_json(capsys):
    data = run_json(capsys, "simulate", "rod", *FLYING_APART, "--t-end", "1", code=3)
    assert data["stop_reason"] == "non_finite"
    assert data["energy_residual"] is None
    assert data["not_finite"]["energy_residual"] == "nan"


def test_simulate_save_can_be_loaded(capsys, tmp_path):
    path = tmp_path / "run.npz"
    options = (*STIFF, "--t-end", "0.001", "--save", path)
    data = run_json(capsys, "simulate", "rod", "--state", TABLE_3, *options)
    loaded = Trajectory.load(path)
    assert loaded.final == data["final"]["state"]
    assert data["files"] == {"save": str(path)}
    assert [p.name for p in tmp_path.iterdir()] == ["run.npz"]


def test_simulate_save_follows_a_link(capsys, tmp_path):
    (tmp_path / "real.npz").write_bytes(b"")
    (tmp_path / "link.npz").symlink_to(tmp_path / "real.npz")
    options = (*STIFF, "--t-end", "0.001", "--save", tmp_path / "link.npz")
    run_json(capsys, "simulate", "rod", "--state", TABLE_3, *options)
    assert (tmp_path / "link.npz").is_symlink()
    assert Trajectory.load(tmp_path / "real.npz").mechanism == "rod"


@pytest.mark.parametrize(
    ("suffix", "start"),
    [
        ("svg", b"<?xml"),
        pytest.param("png", b"\x89PNG", marks=pytest.mark.slow),
        pytest.param("pdf", b"%PDF", marks=pytest.mark.slow),
    ],
)
def test_simulate_plot_writes_the_format_of_the_suffix(capsys, tmp_path, suffix, start):
    path = tmp_path / f"run.{suffix}"
    options = (*STIFF, "--t-end", "0.001", "--plot", path)
    data = run_json(capsys, "simulate", "rod", "--state", TABLE_3, *options)
    assert path.read_bytes().startswith(start)
    assert data["files"] == {"plot": str(path)}
    first = path.read_bytes()
    run_json(capsys, "simulate", "rod", "--state", TABLE_3, *options)
    assert path.read_bytes() == first


def test_simulate_says_so_when_there_is_nothing_to_plot(capsys, tmp_path):
    options = ("--t-end", "1", "--plot", tmp_path / "run.png")
    code, _, err = run(capsys, "simulate", "rod", *FLYING_APART, *options)
    assert code == 3
    assert err == "painleve: note: nothing to plot: no step was taken.\n"
    assert not (tmp_path / "run.png").exists()


def test_simulate_without_steps_has_one_sample(capsys):
    options = ("--t-end", "1", "--samples", "5")
    data = run_json(capsys, "simulate", "rod", *FLYING_APART, *options, code=3)
    assert data["samples"]["time"] == [0.0]


def test_simulate_rtol_changes_the_work_and_not_the_answer(capsys):
    ends = []
    for rtol in ("1e-6", "1e-12"):
        options = (*STIFF, "--t-end", "0.0004", "--rtol", rtol)
        data = run_json(capsys, "simulate", "rod", "--state", TABLE_3, *options)
        assert data["rtol"] == float(rtol)
        ends.append((data["counters"]["accepted_steps"], data["final"]["state"]["theta_dot"]))
    assert ends[0][0] < ends[1][0]
    assert math.isclose(ends[0][1], ends[1][1], rel_tol=1e-4)


@pytest.mark.parametrize(
    ("words", "plain"),
    [
        (("--t-end", "1ms"), ("--t-end", "0.001")),
        (
            ("--t-end", "1e-3", "--initial-force", "0.5kN"),
            ("--t-end", "1e-3", "--initial-force", "500"),
        ),
    ],
)
def test_times_and_forces_may_have_units(capsys, words, plain):
    command = ("simulate", "rod", *STIFF)
    assert run_json(capsys, *command, *words) == run_json(capsys, *command, *plain)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("simulate", "rod", *STIFF, "--t-end", "1kg"), "--t-end: got the unit [kg], need [s]"),
        (
            ("simulate", "rod", *STIFF, "--t-end", "soon"),
            "--t-end: got 'soon', need a number, such as 0.5",
        ),
        (
            ("map", "rod", "--over", "theta,mu", "--range", "theta=10deg:1m"),
            "--range theta: got the unit [m]",
        ),
        (
            ("map", "rod", "--over", "theta,mu", "--range", "thta=10deg:80deg"),
            "Did you mean 'theta'?",
        ),
        (("critical", "rod", "--over", "E=1m:2m"), "--over E: got the unit [m], need [Pa]"),
        (("contrast", "rod", "--steps", "1m"), "--steps: got the unit [m], need [s]"),
    ],
)
def test_units_of_another_kind_are_refused(capsys, words, message):
    assert message in rejected(capsys, *words)


def test_simulate_says_where_its_energy_balance_does_not_close(capsys, monkeypatch):
    case = ("simulate", "rod", "--state", TABLE_3, *STIFF, "--t-end", "0.002")
    code, out, _ = run(capsys, *case)
    assert code == 0 and ", relative energy error " in out
    assert run_json(capsys, *case)["energy_closes"] is True
    monkeypatch.setattr("painleve_sym.motion.energy_balance.open_from", lambda rtol: 1e-20)
    code, out, _ = run(capsys, *case)
    assert code == 3 and "relative energy error" not in out
    assert "The energy balance is off by" in out
    data = run_json(capsys, *case, code=3)
    assert data["energy_closes"] is False
    assert data["notices"][0].startswith("The energy balance is off by")


def test_one_step_and_one_event_are_singular(capsys):
    case = ("simulate", "rod", "--state", "y_A=1e-9,y_A_dot=-1,theta=1", "--law", "linear")
    code, out, _ = run(capsys, *case, "--until", "touchdown", "--t-end", "1e-8")
    assert code == 0 and "1 step, 1 event, rtol" in out
