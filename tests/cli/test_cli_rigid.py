"""`--law rigid`: rigid motion on the command line."""

from __future__ import annotations

import json

import pytest

from painleve_sym.cli import main

STATE = ("simulate", "rod", "--state", "theta=1,theta_dot=1,x_A_dot=-1", "--t-end", "0.001")


def test_simulate_rigid_makes_the_impact_without_collision(capsys):
    assert main([*STATE, "--law", "rigid", "--law-set", "e_energetic=0.75", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    kinds = [e["kind"] for e in data["events"]]
    assert kinds[1:4] == ["impact_slip_stop", "impact_max_compression", "impact_end"]
    assert data["events"][3]["state"]["y_A_dot"] == pytest.approx(0.0524701, abs=5e-8)
    assert data["energy_residual"] < 1e-9


def test_simulate_rigid_records_the_alternatives_of_a_choice(capsys):
    state = ("simulate", "rod", "--state", "theta=1,theta_dot=5,x_A_dot=-1", "--t-end", "1e-4")
    assert main([*state, "--law", "rigid", "--law-set", "policy=impact", "--json"]) == 0
    first = json.loads(capsys.readouterr().out)["events"][0]
    assert first["alternatives"] == ["liftoff", "slip_neg"]
    assert first["mode_after"] == "impact/slip_neg/compression"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ("policy=lift", "Did you mean 'liftoff'"),
        ("restitution=newtom", "Did you mean 'newton'"),
        ("e_newton=0.5", "unknown parameter 'e_newton'"),
        ("e_energetic=1.5", "e_energetic"),
    ],
)
def test_simulate_rigid_bad_settings_are_one_sentence(capsys, settings, message):
    assert main([*STATE, "--law", "rigid", "--law-set", settings]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert err.count("\n") == 1


def test_simulate_rigid_refuses_a_stored_force_and_a_start_in_the_ground(capsys):
    assert main([*STATE, "--law", "rigid", "--initial-force", "3"]) == 2
    assert "stores no force" in capsys.readouterr().err
    inside = ("--state", "theta=1,x_A_dot=-1,y_A=-1e-6", "--t-end", "1e-3", "--law", "rigid")
    assert main(["simulate", "rod", *inside]) == 2
    assert "inside the ground" in capsys.readouterr().err
