"""Commands with a mechanism that depends on the time."""

from __future__ import annotations

import json
import math

import pytest

from tests.cli.cli_helpers import ROOT, only_contact, rejected, run, run_json

TABLE = str(ROOT / "examples/mechanisms/oscillating-table.toml")
LEVEL = ("--set", "a=0")


def test_classify_takes_the_time_as_part_of_the_state(capsys):
    data = run_json(capsys, "classify", TABLE, "--state", "t=0.3,x_dot=1", *LEVEL)
    assert data["state"]["t"] == 0.3
    _, (solution,) = only_contact(data)
    assert solution["tangential_force"] == pytest.approx([-0.4 * 9.8])
    acceleration = 0.02 * 40**2 * math.sin(40 * 0.3) - 0.4 * 9.8
    assert solution["tangential_acceleration"] == pytest.approx([acceleration])


def test_simulate_starts_at_the_time_of_the_state_and_at_zero_without_one(capsys):
    given = ("simulate", TABLE, "--law", "rigid", "--t-end", "0.05", "--samples", "3")
    late = run_json(capsys, *given, "--state", "y=0.05,t=0.3")
    assert late["final"]["time"] == 0.05
    assert late["final"]["state"]["t"] == pytest.approx(0.35, rel=1e-14)
    assert late["samples"]["time"] == [0.0, 0.025, 0.05]
    assert late["samples"]["state"]["t"][0] == 0.3
    assert run_json(capsys, *given, "--state", "y=0.05")["final"]["state"]["t"] == 0.05


def test_jump_takes_the_time(capsys):
    data = [
        run_json(capsys, "jump", TABLE, "--state", f"t={t},y_dot=-1", "--set", "b=0")
        for t in (0.0, math.pi / 40)
    ]
    after = [d["phases"][-1]["velocity"]["y_dot"] for d in data]
    for computed, table in zip(after, (0.4, -0.4), strict=True):
        assert computed == pytest.approx(table + 0.75 * (1 + table), rel=1e-12)


def test_map_has_the_time_as_an_axis(capsys):
    still = ("--state", "y=0")
    data = run_json(capsys, "map", TABLE, "--over", "t,x_dot", "--points", "40", *still, *LEVEL)
    assert data["axes"][0] == {"name": "t", "unit": "s", "from": 0.0, "to": 1.0, "points": 40}


def test_derive_shows_the_motion_of_the_surface(capsys):
    code, out, err = run(capsys, "derive", TABLE)
    assert (code, err) == (0, "")
    assert "gap_drift [m/s]" in out and "-a*omega*cos(omega*t + phase)" in out
    assert "gap_drift" not in run(capsys, "derive", "strut")[1]


def test_module_of_derive_has_the_time_among_its_arguments(capsys):
    code, out, err = run(capsys, "derive", TABLE, "--format", "python")
    assert (code, err) == (0, "")
    module: dict = {}
    exec(compile(out, "derived", "exec"), module)
    values = {"a": 0.01, "omega": 40.0, "phase": 0.0, "t": 0.02, "y": 0.1}
    assert module["gap"](**values) == pytest.approx(0.1 - 0.01 * math.sin(0.8))


def test_sweep_takes_the_time_as_an_axis(capsys, tmp_path):
    file = tmp_path / "phase.toml"
    file.write_text(
        f"model = {json.dumps(TABLE)}\nt_end = 0.05\nstate = {{ y = 0.05 }}\n"
        'law = { name = "rigid" }\nkeep = ["t", "y"]\n[axes]\nt = [0.0, 0.1]\n'
    )
    code, out, _ = run(capsys, "sweep", file, "--out", tmp_path / "phase.npz", "--json")
    assert code == 0 and json.loads(out)["stop_reasons"] == {"t_end": 2}


@pytest.mark.slow
def test_fit_estimates_an_amplitude_from_a_history(capsys, tmp_path):
    run_of = run_json(
        capsys, "simulate", TABLE, "--law", "hunt-crossley", "--state", "x_dot=0.9,y=0.05",
        "--set", "a=0.0101", "--t-end", "0.2", "--samples", "21",
    )  # fmt: skip
    history = zip(run_of["samples"]["time"], run_of["samples"]["state"]["y"], strict=True)
    data, case = tmp_path / "data.csv", tmp_path / "case.toml"
    data.write_text("t [s],y [m]\n" + "".join(f"{t!r},{y!r}\n" for t, y in history))
    case.write_text(
        f"model = {json.dumps(TABLE)}\nstate = {{ x_dot = 0.9, y = 0.05 }}\n"
        'law = { name = "hunt-crossley" }\n'
    )
    document = run_json(capsys, "fit", data, case, "--estimate", "a")
    assert document["estimates"][0]["estimate"] == pytest.approx(0.0101, rel=1e-6)


def test_state_with_the_time_of_a_mechanism_without_it_is_refused(capsys):
    assert "unknown state 't'" in rejected(capsys, "classify", "rod", "--state", "theta=1,t=0.3")
