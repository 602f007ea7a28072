"""Runs that end before an event: at its instant, with state, mode and memory as they were."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import painleve_sym as ps
from tests.cli.cli_helpers import rejected, run_json
from tests.cli.cli_helpers import run as run_command
from tests.motion.test_continuation import MOTIONS, assert_joined
from tests.motion.test_sensitivity import richardson

FALLING = {"y_A": 0.1, "theta": 0.9}
KINDS = ("before_touchdown", "before_impact", "before_slip_stop", "before_separation")


EVERY = {**MOTIONS, "rigid erk": ("rod", "rigid", {"y_A": 0.1, "theta": 0.9}, 0.5, "erk")}


@pytest.fixture(scope="module", params=EVERY)
def motion(request):
    """Return a function of t_end and other settings, and the motion that is not cut."""
    mechanism, law, state, t_end, engine = EVERY[request.param]

    def run(t_end, **arguments):
        return ps.simulate(mechanism, law, state, t_end=t_end, engine=engine, **arguments)

    return run, run(t_end)


@pytest.mark.parametrize("kind", KINDS)
def test_a_motion_cut_before_its_events_and_continued_is_the_whole_one(motion, kind):
    run, whole = motion
    known = [e for e in whole.events if f"before_{e.kind}" == kind][:3]
    if not known:
        return
    piece, pieces = run(whole.final_time, until=kind), []
    for event in known:
        assert piece.stop_reason is ps.StopReason.UNTIL
        assert piece.stop_detail == kind.replace("_", " ", 1)
        assert piece.final_time == pytest.approx(event.time, rel=1e-9)
        assert event.kind not in [e.kind for e in piece.events if e.time == piece.final_time]
        pieces.append(piece)
        piece = piece.continued(whole.final_time, until=kind)
    rest = pieces[-1].continued(whole.final_time)
    assert_joined(_joined(pieces), rest, whole)


def _joined(pieces):
    """Return several pieces as what `assert_joined` reads of one."""
    events = tuple(itertools.chain.from_iterable(p.events for p in pieces))
    return type("Pieces", (), {"events": events, "final_time": pieces[-1].final_time})


@settings(max_examples=6)
@given(height=st.floats(0.02, 0.3), turn=st.floats(-1.0, 1.0))
def test_the_state_before_an_impact_is_that_of_free_fall(height, turn):
    start = {"y_A": height, "theta": 0.9, "theta_dot": turn, "x_A_dot": 0.3}
    before = ps.simulate("rod", "rigid", start, t_end=1.0, until="before_impact")
    # The height of the tip over that of the centre of mass, which falls freely.
    t, g, final = before.final_time, before.parameters["g"], before.final
    half = before.parameters["l"]
    theta = 0.9 + turn * t
    fallen = height + half * np.sin(0.9) + half * turn * np.cos(0.9) * t - g * t**2 / 2
    assert final["theta"] == pytest.approx(theta, rel=1e-9)
    assert final["y_A"] == pytest.approx(0, abs=1e-9)
    assert fallen - half * np.sin(theta) == pytest.approx(0, abs=1e-8)
    speed = half * turn * np.cos(0.9) - g * t - half * turn * np.cos(theta)
    assert final["y_A_dot"] == pytest.approx(speed, rel=1e-8)


def test_it_ends_where_it_begins_if_it_begins_with_the_event():
    start = {"theta": 1.0, "y_A_dot": -1.0}
    before = ps.simulate("rod", "rigid", start, t_end=0.1, until="before_impact")
    assert before.final_time == 0 and before.ended_at_start and before.final["y_A_dot"] == -1
    whole = ps.simulate("rod", "rigid", start, t_end=0.1)
    assert_joined(before, before.continued(0.1), whole)


def test_the_mode_and_the_memory_are_those_before():
    run = ps.simulate("rod", "rigid", FALLING, t_end=1.0, until="before_touchdown")
    assert run.mode_names[run.final_mode] == "flight" and run.final["y_A_dot"] < 0
    assert run.events == () and run.final_outputs["normal_force"] == 0
    plastic = ps.simulate(
        "rod", "bilinear-hertz", FALLING, t_end=1.0, until="before_max_compression"
    )
    whole = ps.simulate("rod", "bilinear-hertz", FALLING, t_end=1.0, until="max_compression")
    assert plastic.final_memory[0] == 0 and whole.final_memory[0] > 0


def test_a_saved_motion_is_continued_through_the_impact(tmp_path):
    before = ps.simulate("rod", "rigid", FALLING, t_end=1.0, until="before_impact")
    before.save(tmp_path / "before.npz")
    loaded = ps.Trajectory.load(tmp_path / "before.npz")
    assert loaded.inputs["options"]["until"] == ["before_impact"]
    assert loaded.stop_detail == "before impact"
    again = ps.simulate("rod", "rigid", start=loaded, t_end=0.2)
    assert again == before.continued(0.2) and again.events[0].kind == "impact"


def test_batches_end_there_too():
    heights = np.array([0.05, 0.1, 0.2])
    given_ = {"t_end": 1.0, "until": "before_touchdown"}
    batch = ps.simulate_batch("rod", "rigid", {"y_A": heights, "theta": 0.9}, **given_)
    assert batch["y_A_dot"] == pytest.approx(-np.sqrt(2 * 9.8 * heights), rel=1e-10)
    for i, height in enumerate(heights):
        alone = ps.simulate("rod", "rigid", {"y_A": height, "theta": 0.9}, **given_)
        assert batch["y_A_dot"][i] == alone.final["y_A_dot"]


@pytest.mark.parametrize(
    ("law", "kind"), [("rigid", "before_touchdown"), ("bilinear-hertz", "before_separation")]
)
def test_derivatives_there_are_those_at_the_event(law, kind):
    simulator = ps.Simulator("rod", law)
    start = {"y_A": 0.1, "theta": 0.9, "theta_dot": 0.5}
    result = simulator.sensitivities(start, ["theta_dot", "g"], t_end=1.0, until=kind)

    def end(run):
        return np.append(run.final_state, run.final_time)

    for k, name in enumerate(("theta_dot", "g")):
        expected = richardson(simulator, start, name, {}, end, t_end=1.0, until=kind)
        derivatives = np.append(result.final_jacobian[:, k], result.final_time_gradient[k])
        assert derivatives == pytest.approx(expected, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize(
    "kind", ["before_settle", "before_touchdwn", "before_", "before_singular_"]
)
def test_what_no_run_ends_before_is_one_sentence(kind):
    with pytest.raises(ps.InputError, match=f"unknown event '{kind}'"):
        ps.simulate("rod", "rigid", FALLING, t_end=1.0, until=kind)


SCENARIO = """model = "rod"
law = "rigid"
t_end = 1.0
until = ["before_touchdown"]
[state]
theta = 0.9
y_A = 0.1
"""


def test_a_file_and_the_command_line_say_it(capsys, tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(SCENARIO)
    _, out, _ = run_command(capsys, "simulate", file)
    assert "ended at t = 0.142857143 s before touchdown" in out
    case = ("rod", "--state", "theta=0.9,y_A=0.1", "--law", "rigid", "--t-end", "1")
    data = run_json(capsys, "simulate", *case, "--until", "before_impact")
    assert data["stop_detail"] == "before impact" and data["final"]["mode"] == "contact"
    assert data["final"]["state"]["y_A_dot"] == pytest.approx(-1.4, rel=1e-9)
    wrong = rejected(capsys, "simulate", *case, "--until", "before_landing")
    assert "unknown event 'before_landing'" in wrong


def test_a_sweep_ends_there(tmp_path):
    file = tmp_path / "sweep.toml"
    heights = SCENARIO.replace("y_A = 0.1\n", "[axes]\ny_A = [0.05, 0.2]\n")
    file.write_text('keep = ["y_A_dot", "time"]\n' + heights)
    ps.sweep(str(file), str(tmp_path / "out.npz"))
    with np.load(tmp_path / "out.npz") as data:
        speeds = -np.sqrt(2 * 9.8 * np.array([0.05, 0.2]))
        assert data["y_A_dot"] == pytest.approx(speeds, rel=1e-10)
