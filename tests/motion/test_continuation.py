"""A motion that is cut and continued is the motion that was not cut."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import painleve_sym as ps

EXAMPLES = Path(__file__).parents[2] / "examples" / "mechanisms"
SLIDING = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
FALLING = {"y_A": 0.1, "theta": 0.9}
TWO_FEET = {"y_A": 0.01, "theta": 0.02, "x_A_dot": 1.0}
MOTIONS = {
    "compliant": ("rod", "bilinear-hertz", SLIDING, 0.02, "auto"),
    "damped": ("rod", "hunt-crossley", FALLING, 0.3, "auto"),
    "rigid": ("rod", "rigid", FALLING, 0.5, "auto"),
    "erk": ("rod", "bilinear-hertz", SLIDING, 0.01, "erk"),
    "rigid feet": ("block-two-feet", "rigid", TWO_FEET, 0.4, "auto"),
    "both kinds": ("block-two-feet", {"A": "rigid", "B": "hertz"}, TWO_FEET, 0.1, "auto"),
}


@pytest.fixture(scope="module", params=MOTIONS)
def motion(request):
    """Return a function of t_end and other settings, and the motion that is not cut."""
    mechanism, law, state, t_end, engine = MOTIONS[request.param]

    def run(t_end, **arguments):
        return ps.simulate(mechanism, law, state, t_end=t_end, engine=engine, **arguments)

    return run, run(t_end)


def assert_joined(first, rest, whole):
    """Check that two pieces are the whole motion."""
    assert rest.t[0] == first.final_time and rest.final_time == whole.final_time
    # Bounces that die out are counted from the cut on: of the last ones, which are rounding, there
    # may be others.
    ends = [e.time for e in whole.events if e.kind == "settle"]
    last = ends[0] * (1 - 1e-6) if ends else np.inf
    cut, known = (
        [e for e in events if e.time < last]
        for events in ((*first.events, *rest.events), whole.events)
    )
    assert [(e.kind, e.contact) for e in cut] == [(e.kind, e.contact) for e in known]
    assert [e.time for e in cut] == pytest.approx([e.time for e in known], rel=1e-8)
    scale = np.maximum(np.abs(whole.final_state), 1e-3)
    assert np.max(np.abs(rest.final_state - whole.final_state) / scale) < 1e-7
    assert rest.final_memory == pytest.approx(whole.final_memory, rel=1e-6, abs=1e-9)
    assert rest.energy_closes


@settings(max_examples=4)
@given(part=st.floats(0.02, 0.98))
def test_a_motion_cut_anywhere_and_continued_is_the_whole_one(motion, part):
    run, whole = motion
    first = run(part * whole.final_time)
    assert_joined(first, first.continued(whole.final_time), whole)


def test_a_motion_cut_after_each_event_is_the_whole_one(motion):
    run, whole = motion
    for count in range(1, min(len(whole.events), 8)):
        if whole.events[count].time == whole.events[count - 1].time:
            continue  # what happens at one instant is not cut
        first = run(whole.final_time, max_events=count)
        assert first.stop_reason is ps.StopReason.EVENT_LIMIT
        assert_joined(first, first.continued(whole.final_time), whole)


def test_three_pieces_are_one_motion():
    pieces = [ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=2e-3)]
    pieces += [pieces[0].continued("3 ms")]
    pieces += [pieces[1].continued(5e-3)]
    known = pieces[1].inputs["continues"]
    assert known["time"] == 2e-3 and known["mode"] == "flight_indented"
    assert known["memory"] == {"delta_max": pieces[0].final_memory[0]}
    assert pieces[0].final_memory[0] > 0
    whole = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=5e-3)
    assert pieces[2].final_state == pytest.approx(whole.final_state, rel=1e-8, abs=1e-12)
    assert pieces[1].values("normal_force", 2.5e-3) == pytest.approx(
        whole.values("normal_force", 2.5e-3), rel=1e-8
    )


def test_a_motion_from_a_file_is_continued_by_simulate(tmp_path):
    first = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=3e-3)
    first.save(tmp_path / "first.npz")
    loaded = ps.Trajectory.load(tmp_path / "first.npz")
    with pytest.raises(ps.InputError, match=r"Fix: simulate\(mechanism, law, start=run"):
        loaded.continued(4e-3)
    again = ps.simulate("rod", "bilinear-hertz", start=loaded, t_end=4e-3)
    assert again == first.continued(4e-3)


def test_parameters_may_change_between_pieces():
    """A block that slides up a slope is braked by the slope alone where μ = 0, then by both."""
    low = {"h": 0.05, "mu_A": 0.4, "mu_B": 0.4}  # does not tip
    start = {"x_A_dot": 3.0}
    slow = ps.simulate("block-two-feet", "rigid", start, parameters=low, t_end=0.1)
    g, beta = (slow.parameters[name] for name in ("g", "beta"))
    free = slow.continued(0.2, parameters={"mu_A": 0.0, "mu_B": 0.0})
    lost = slow.final["x_A_dot"] - free.final["x_A_dot"]
    assert lost == pytest.approx(0.1 * g * np.sin(beta), rel=1e-9)
    assert free.parameters["mu_A"] == 0.0 and free.parameters["g"] == g
    braked = free.continued(0.3, parameters={"mu_A": 0.5, "mu_B": 0.5})
    lost = free.final["x_A_dot"] - braked.final["x_A_dot"]
    assert lost == pytest.approx(0.1 * g * (0.5 * np.cos(beta) + np.sin(beta)), rel=1e-9)


def test_what_happens_at_a_cut_is_an_event():
    """A rod that sticks, on a contact that yields, slips at once where its friction is gone."""
    start = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    rod = ps.Simulator("rod", "bilinear-hertz")
    stuck = rod.run(start, t_end=0.01, until="slip_stop")
    slips = stuck.continued(0.01, parameters={"mu": 0.01})
    assert str(slips.events[0].kind) == "slip_start"
    assert slips.events[0].time == stuck.final_time


def test_a_belt_that_runs_faster_from_a_cut_on_moves_the_slip():
    """The slip is a state of its own; a new motion from the same place is the oracle."""
    belt = ps.model(str(EXAMPLES / "belt-oscillator.toml"))
    first = ps.simulate(belt, "rigid", t_end=0.5)
    rest = first.continued(0.6, parameters={"u": 0.4})
    start = {name: first.final[name] for name in belt.state_names}
    again = ps.simulate(belt, "rigid", start, parameters={"u": 0.4}, t_end=0.1)
    for name in (*belt.state_names, "slip_velocity"):
        assert rest.final[name] == pytest.approx(again.final[name], rel=1e-9, abs=1e-12)
    lost = rest.final["friction_dissipation"] - first.final["friction_dissipation"]
    assert lost == pytest.approx(again.final["friction_dissipation"], rel=1e-9)
    assert rest.final["slip_velocity"] == pytest.approx(rest.final["x_dot"] - 0.4)


def test_a_parameter_moves_the_gap_of_an_open_contact():
    high = {"y_A": 0.05, "theta": 0.1, "theta_dot": 1.0}
    first = ps.simulate("block-two-feet", "rigid", high, t_end=0.02)
    final = first.continued(0.03, parameters={"a": 0.12}).final
    gap = final["y_A"] + 2 * 0.12 * np.sin(final["theta"])
    assert final["gap_B"] == pytest.approx(gap, rel=1e-12)


@pytest.mark.parametrize("speed", [0.4, -0.3])
def test_a_block_that_sticks_to_a_belt_slips_where_the_belt_changes_its_speed(speed):
    """A new motion from the same place is the oracle."""
    belt = ps.model(str(EXAMPLES / "belt-oscillator.toml"))
    first = ps.simulate(belt, "rigid", {"x_dot": 0.2}, t_end=0.01)
    assert first.final["slip_velocity"] == 0
    rest = first.continued(0.1, parameters={"u": speed})
    start = {name: first.final[name] for name in belt.state_names}
    again = ps.simulate(belt, "rigid", start, parameters={"u": speed}, t_end=0.09)
    for name in (*belt.state_names, "slip_velocity"):
        assert rest.final[name] == pytest.approx(again.final[name], rel=1e-8, abs=1e-11)
    modes = [(e.kind, e.mode_after) for e in rest.events]
    assert modes == [(e.kind, e.mode_after) for e in again.events]
    # What moves no contact changes nothing in its states.
    assert first.continued(0.02, parameters={"k_s": 20.0}).final["slip_velocity"] == 0


def test_what_moves_the_gap_of_a_closed_contact_at_a_cut_is_one_sentence():
    table = ps.model(str(EXAMPLES / "oscillating-table.toml"))
    calm = {"a": 0.001, "b": 0.0, "omega": 5.0}
    rests = {"y": 0.0, "y_dot": 0.005}
    first = ps.simulate(table, "rigid", rests, t_end=0.1, parameters=calm)
    assert first.final_outputs["normal_force"] > 0
    with pytest.raises(ps.InputError, match=r"moves contact 'table' while it is closed: gap by"):
        first.continued(0.2, parameters={"a": 0.002})


def test_an_explorer_of_a_continued_motion_is_one_sentence():
    rest = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=1e-3).continued(2e-3)
    with pytest.raises(ps.InputError, match=r"continues another one .* Fix: explore the first"):
        rest.explore()
    assert "continues" in rest.to_xarray().attrs


def test_another_law_begins_with_a_mode_of_its_own():
    rigid = ps.simulate("rod", "rigid", FALLING, t_end=0.1)
    soft = ps.simulate("rod", "hertz", start=rigid, t_end=0.2)
    assert soft.t[0] == 0.1 and soft.events[0].kind == "touchdown"
    whole = ps.simulate("rod", "hertz", FALLING, t_end=0.2)
    assert soft.final["theta"] == pytest.approx(whole.final["theta"], rel=1e-7)
    assert "memory" not in soft.inputs["continues"]


def test_a_mechanism_that_depends_on_time_keeps_it():
    table = ps.model(str(EXAMPLES / "oscillating-table.toml"))
    whole = ps.simulate(table, "rigid", t_end=0.4)
    first = ps.simulate(table, "rigid", t_end=0.17)
    rest = first.continued(0.4)
    assert rest.final_state == pytest.approx(whole.final_state, rel=1e-8, abs=1e-10)
    assert rest.final["t"] == pytest.approx(0.4, rel=1e-14)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"t_end": 1e-3}, "t_end: got 0.001 s, need a time after 0.002 s"),
        ({"t_end": 1, "initial_force": 1.0}, "start: got initial_force, too"),
        ({"t_end": 1, "close": "y_A"}, "start: got close, too"),
        ({"t_end": 1, "state": {"theta": 1}}, "start: got state, too"),
        ({"t_end": 1, "parameters": {"nu_2": 1}}, "unknown parameter 'nu_2'"),
    ],
)
def test_what_a_continued_motion_does_not_take_is_one_sentence(arguments, message):
    first = ps.simulate("rod", "bilinear-hertz", SLIDING, t_end=2e-3)
    with pytest.raises(ps.InputError, match=message):
        ps.simulate("rod", "bilinear-hertz", start=first, **arguments)


def test_only_a_motion_that_can_go_on_is_continued():
    out = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 1.0}, t_end=2.0)
    assert out.stop_reason is ps.StopReason.LEFT_DOMAIN
    with pytest.raises(ps.InputError, match="from where it does not continue"):
        out.continued(3.0)
    with pytest.raises(ps.InputError, match=r"start: got dict \{\}, need a Trajectory"):
        ps.simulate("rod", "rigid", start={}, t_end=1.0)
    other = ps.simulate("block-two-feet", "rigid", {"x_A_dot": 1.0}, t_end=0.01)
    with pytest.raises(ps.InputError, match="without"):
        ps.simulate("two-link-arm", "rigid", start=other, t_end=0.02)
