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


def test_simulate_rigid_that_jams_at_its_start_shows_its_end(capsys):
    state = ("strut", "--state", "theta=0.9272952180016122", "--set", "mu=2", "--t-end", "0.01")
    assert main(["simulate", *state, "--law", "rigid", "--samples", "3"]) == 3
    text = capsys.readouterr().out
    assert "stopped at t = 0 s: jam" in text
    assert "0 steps, 3 events" in text and "nan" not in text


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
    assert "a rigid contact has no compression" in capsys.readouterr().err
    inside = ("--state", "theta=1,x_A_dot=-1,y_A=-1e-6", "--t-end", "1e-3", "--law", "rigid")
    assert main(["simulate", "rod", *inside]) == 2
    assert "inside the ground" in capsys.readouterr().err


def _events(capsys, state, parameters, restitution, t_end):
    name, *start = state
    arguments = ["--set", parameters, "--law-set", f"e_energetic={restitution}", "--law", "rigid"]
    command = ["simulate", name, "--state", *start, *arguments, "--t-end", repr(t_end), "--json"]
    assert main(command) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["stop_reason"] == "t_end"
    return data, [(e["kind"], e["mode_after"]) for e in data["events"]]


def test_simulate_small_block_on_two_feet_is_the_large_one(capsys):
    """A tenth of a micrometre, 1e-15 kg: nothing is compared with 1 m or 1 J."""
    state, friction = ("block-two-feet", "theta=0.3"), "beta=0.1,mu_A=0.5,mu_B=0.7"
    small = f"m=1e-15,J=2e-29,a=1e-7,h=2e-7,{friction}"
    large = f"m=1,J=2,a=1,h=2,{friction}"
    tiny, events = _events(capsys, state, small, 0.3, 6.4e-4)
    huge, same = _events(capsys, state, large, 0.3, 6.4e-4 * 1e7**0.5)
    assert events == same
    assert len(events) > 50
    assert tiny["energy_residual"] < 1e-9
    times = [e["time"] * 1e7**0.5 for e in tiny["events"]]
    assert times == pytest.approx([e["time"] for e in huge["events"]], rel=1e-9)


@pytest.mark.slow
def test_simulate_bounces_of_a_large_disc_die_out(capsys):
    """Of 100 m radius and 1e9 kg."""
    state, parameters = ("eccentric-disc", "y=200"), "d=0,r=100,m=1e9"
    data, events = _events(capsys, state, parameters, 0.4, 100.0)
    assert "settle" in [kind for kind, _ in events]
    assert data["final"]["state"]["y"] == 0
    lost = data["final"]["state"]["contact_dissipation"]
    assert lost == pytest.approx(1e9 * 9.8 * 200, rel=1e-12)
