"""Starts that a state does not determine say so: contacts with a past, and several solutions."""

from __future__ import annotations

import numpy as np
import pytest

import painleve_sym as ps

FALL = {"theta": 1.0, "y_A_dot": -1.0, "x_A_dot": -0.3}
STATE = ("x_A", "y_A", "theta", "x_A_dot", "y_A_dot", "theta_dot")


def in_restitution(law, engine):
    """Return a run that stops half way from the greatest compression to the next event."""
    whole = ps.simulate("rod", law, FALL, t_end=1e-3, engine=engine)
    kinds = [event.kind for event in whole.events]
    i = kinds.index(ps.EventKind.MAX_COMPRESSION)
    middle = (whole.events[i].time + whole.events[i + 1].time) / 2
    return ps.simulate("rod", law, FALL, t_end=middle, engine=engine)


@pytest.mark.parametrize("engine", ["taylor", "compiled", "erk"])
@pytest.mark.parametrize(
    ("law", "past"),
    [
        (ps.law("bilinear-hertz"), "branch, delta_max"),
        (ps.law("hertz", friction="spring"), "deflection of the tangential spring"),
        (ps.law("hertz"), ""),
        (ps.law("hunt-crossley"), ""),
    ],
)
def test_continued_motion_is_the_same_one_or_says_that_it_is_not(law, past, engine):
    """One run of the whole time is what a continued one is compared with."""
    stopped, more = in_restitution(law, engine), 1e-4
    state = {name: stopped.final[name] for name in STATE}
    again = ps.simulate("rod", law, state, t_end=more, engine=engine)
    whole = ps.simulate("rod", law, FALL, t_end=stopped.final_time + more, engine=engine)
    off = max(abs(again.final[name] - whole.final[name]) for name in STATE)
    assert (off > 1e-3) == bool(past)
    assert off > 1e-3 or off < 1e-9
    sentences = [text for text in again.notices if "depends on its past" in text]
    assert len(sentences) == bool(past)
    assert all(f"({past})" in text and f"{-state['y_A']:.3g} m deep" in text for text in sentences)
    assert not any("its past" in text for text in (*stopped.notices, *whole.notices))


def test_notice_of_a_pressed_start_names_its_contact_and_is_kept_in_files(tmp_path):
    run = ps.simulate("block-two-feet", "A=bilinear-hertz,B=hertz", {"y_A": -1e-5}, t_end=1e-5)
    (text,) = run.notices
    assert text.startswith("Contact A ")
    run.save(tmp_path / "run.npz")
    assert ps.Trajectory.load(tmp_path / "run.npz").notices == run.notices


def test_initial_force_and_an_open_contact_begin_without_a_past():
    pressed = ps.simulate("rod", "bilinear-hertz", {"theta": 1.0}, initial_force=10, t_end=1e-5)
    rounding = ps.simulate("rod", "bilinear-hertz", {"theta": 1.0, "y_A": -1e-18}, t_end=1e-5)
    assert not any("its past" in text for text in (*pressed.notices, *rounding.notices))


@pytest.mark.parametrize("engine", ["compiled", "erk"])
def test_batch_counts_the_rows_that_start_with_a_past(engine):
    """Of an open contact, a closed one, rounding and two depths the last two count."""
    depths = {"theta": 1.0, "y_A": [0.1, 0.0, -1e-18, -1e-6, -2e-6]}
    runs = ps.simulate_batch("rod", "bilinear-hertz", depths, t_end=1e-6, engine=engine)
    assert [t[:72] for t in runs.notices] == [
        "2 of 5 motions start with a contact pressed, not by an initial_force, and"[:72]
    ]
    others = ps.simulate_batch("rod", "hertz", depths, t_end=1e-6, engine=engine)
    closed = {"theta": [1.0, 1.1]}
    forced = ps.simulate_batch("rod", "bilinear-hertz", closed, initial_force=5.0, t_end=1e-6)
    assert others.notices == forced.notices == ()


def test_rigid_start_with_several_solutions_says_which_is_chosen():
    """Rod of the paradox with B > 0 > A: lift-off, slip and impact are solutions."""
    state, mu = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}, {"mu": 2.0}
    assert ps.classify("rod", state, parameters=mu).case is ps.ContactCase.INDETERMINATE
    run = ps.simulate("rod", "rigid", state, parameters=mu, t_end=1e-4)
    (text,) = run.notices
    assert "several solutions" in text and run.events[0].mode_after in text
    np.testing.assert_equal(run.events[0].time, 0.0)
