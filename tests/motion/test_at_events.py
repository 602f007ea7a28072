"""Values at events, in single motions and in batches: limits from both sides of an instant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import painleve_sym as ps

ROOT = Path(__file__).parents[2]
TABLE = ps.load_mechanism(ROOT / "examples/mechanisms/oscillating-table.toml")
NO_MOTION_OF_TABLE = {"a": 0.0, "b": 0.0}
BEFORE, AFTER = "gap_rate_before_touchdown", "gap_rate_after_touchdown"
G = 9.8


@settings(max_examples=8)
@given(height=st.floats(0.01, 2.0), e=st.floats(0.3, 0.95))
def test_each_impact_of_a_bouncing_ball_is_e_times_the_one_before(height, e):
    given_ = {"parameters": {**NO_MOTION_OF_TABLE, "e_energetic": e}, "events": 6}
    first = np.sqrt(2 * G * height)
    last = first / G * (1 + 2 * e * (1 - e**5) / (1 - e) + e**6)  # in the flight after the sixth
    batch = ps.simulate_batch(
        TABLE, "rigid", {"y": height}, t_end=last, at_events=(BEFORE, AFTER), **given_
    )
    powers = e ** np.arange(6)
    assert batch[BEFORE] == pytest.approx(-first * powers, rel=1e-9)
    assert batch[AFTER] == pytest.approx(first * e * powers, rel=1e-9)


@pytest.mark.parametrize("engine", ["taylor", "compiled", "erk"])
def test_a_ball_on_a_shaking_table_hits_it_as_scipy_says(engine):
    """The same table by SciPy, whose event and reset are written here."""
    a, omega, e, end = 0.008, 40.0, 0.8, 1.2
    t, y, times, speeds = 0.0, [0.05, 0.0], [], []
    begin = 0.0

    def gap(t, y):
        return y[0] - a * np.sin(omega * t) if t > begin + 1e-4 else 1.0

    gap.terminal, gap.direction = True, -1
    while True:
        flight = solve_ivp(
            lambda t, y: [y[1], -G], (t, end), y, "DOP853", events=gap, rtol=1e-12, atol=1e-14
        )
        if not len(flight.t_events[0]):
            break
        (t,) = (begin,) = flight.t_events[0]
        table = a * omega * np.cos(omega * t)
        rate = flight.y_events[0][0][1] - table
        times.append(t)
        speeds.append(rate)
        y = [a * np.sin(omega * t), table - e * rate]
    batch = ps.simulate_batch(
        TABLE,
        "rigid",
        {"y": 0.05},
        parameters={"a": a, "b": 0.0, "omega": omega, "e_energetic": e},
        t_end=end,
        events=len(times) + 1,
        at_events=(BEFORE,),
        engine=engine,
    )
    assert 8 <= len(times) < 40 and np.isnan(batch[BEFORE][-1])
    assert batch["times_of_touchdown"][:-1] == pytest.approx(times, rel=1e-7)
    assert batch[BEFORE][:-1] == pytest.approx(speeds, rel=1e-6)


MOTIONS = {
    "one rigid": ("rod", "rigid", {"y_A": 0.1, "theta": 0.9}, 0.5, ("touchdown", "impact_end")),
    "compliant": (
        "rod", "hunt-crossley", {"y_A": 0.1, "theta": 0.9}, 0.3, ("touchdown", "separation")
    ),
    "feet": (
        "block-two-feet", "rigid", {"y_A": 0.01, "theta": 0.02, "x_A_dot": 1.0}, 0.2,
        ("touchdown", "impact"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("motion", MOTIONS)
def test_they_are_the_limits_of_the_motion_from_both_sides(motion):
    mechanism, law, state, t_end, kinds = MOTIONS[motion]
    run = ps.simulate(mechanism, law, state, t_end=t_end)
    names = (
        "kinetic_energy",
        "theta_dot",
        run.output_names[run.output_names.index("gap") if "gap" in run.output_names else 2],
    )
    for kind in kinds:
        times = np.array([e.time for e in run.events_of(kind)])[:4]
        assert len(times)
        for name in names:
            before, after = (
                run.at_events(f"{name}_{side}_{kind}")[:4] for side in ("before", "after")
            )
            size = np.abs(run[name]).max()
            assert before == pytest.approx(run.values(name, times * (1 - 1e-13)), abs=1e-9 * size)
            assert after == pytest.approx(run.values(name, times), abs=1e-12 * size)


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_batch_keeps_those_of_single_motions(motion):
    mechanism, law, state, t_end, kinds = MOTIONS[motion]
    names = tuple(
        f"{n}_{s}_{k}"
        for n in ("kinetic_energy", "theta_dot")
        for s in ("before", "after")
        for k in kinds
    )
    thetas = state["theta"] + np.array([0.0, 0.01, 0.02])
    batch = ps.simulate_batch(
        mechanism, law, {**state, "theta": thetas}, t_end=t_end, events=4, at_events=names
    )
    for i, theta in enumerate(thetas):
        run = ps.simulate(mechanism, law, {**state, "theta": theta}, t_end=t_end)
        for name in names:
            known = run.at_events(name)[:4]
            assert np.array_equal(batch[name][i, : len(known)], known)
            assert np.isnan(batch[name][i, len(known) :]).all()
    assert batch.units(names[0]) == "J"
    assert batch.to_xarray([names[0]])[names[0]].dims[-1] == "occurrence"


def test_the_first_and_the_last_instant_have_both_sides():
    start = {"theta": 1.0, "y_A_dot": -1.0}
    names = ("y_A_dot_before_impact", "y_A_dot_after_impact")
    batch = ps.simulate_batch("rod", "rigid", start, t_end=0.1, until="impact_end", at_events=names)
    assert batch["time"] == 0.0 and batch[names[0]].tolist() == [-1.0]
    assert batch[names[1]] == batch["y_A_dot"] != -1.0


SWEEP = """model = "examples/mechanisms/oscillating-table.toml"
t_end = 30.0
rtol = 1e-9
state = { y = 0.036, y_dot = 0.0 }
parameters = { b = 0.0, mu = 0.0, omega = 40.0, phase = -2.42 }
keep = ["gap_rate_before_touchdown"]
events = 180
[law]
name = "rigid"
parameters = { e_energetic = 0.5 }
[axes]
a = [AMPLITUDES]
"""


def test_a_sweep_shows_where_the_period_doubles(tmp_path, monkeypatch):
    """A ball that bounces once a period T hits with g T/(1 + e); the period doubles where

    (a ω²/g)² = π² ((1 − e)/(1 + e))² + 4 ((1 + e²)/(1 + e)²)², by the linearised map of impacts.
    """
    monkeypatch.chdir(ROOT)
    e, omega = 0.5, 40.0
    ratio, bend = np.pi * (1 - e) / (1 + e), 2 * (1 + e**2) / (1 + e) ** 2
    doubles = np.hypot(ratio, bend) * G / omega**2
    file = tmp_path / "ball.toml"
    near = ", ".join(repr(float(doubles * part)) for part in (0.85, 0.97, 1.03))
    file.write_text(SWEEP.replace("AMPLITUDES", near))
    summary = ps.sweep(file, tmp_path / "ball.npz")
    with np.load(tmp_path / "ball.npz") as data:
        last = -data["gap_rate_before_touchdown"][:, -20:]
        assert data["count_of_touchdown"].min() > 180
    once = G * (2 * np.pi / omega) / (1 + e)
    assert last[:2] == pytest.approx(np.full((2, 20), once), rel=1e-3)
    assert np.ptp(last[2, ::2]) < 1e-3 * once and np.ptp(last[2, 1::2]) < 1e-3 * once
    assert abs(last[2, 0] - last[2, 1]) > 0.05 * once
    assert summary["points"] == 3


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("gap_rate_before_landing", "need QUANTITY_before_EVENT or QUANTITY_after_EVENT"),
        ("gap_rat_before_touchdown", "unknown quantity 'gap_rat'. Did you mean 'gap_rate'"),
        ("gap_rate_before_separation", "Events: touchdown"),
    ],
)
def test_other_names_are_one_sentence(name, message):
    run = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 0.9}, t_end=0.1)
    with pytest.raises(ps.InputError, match=message):
        run.at_events(name)
    with pytest.raises(ps.InputError, match=message):
        ps.simulate_batch("rod", "rigid", {"y_A": 0.1}, t_end=0.1, at_events=(name,))


def test_a_motion_from_a_file_has_none(tmp_path):
    run = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 0.9}, t_end=0.2)
    run.save(tmp_path / "run.npz")
    with pytest.raises(ps.InputError, match="Fix: simulate it again"):
        ps.Trajectory.load(tmp_path / "run.npz").at_events(BEFORE)


def test_a_motion_in_phases_has_those_of_its_pieces():
    phases = [{"time": 0.25, "law_parameters": {"e_energetic": 0.1}}]
    start = {"y_A": 0.1, "theta": 0.9}
    run = ps.simulate("rod", "rigid", start, t_end=0.45, phases=phases)
    first = ps.simulate("rod", "rigid", start, t_end=0.25)
    rest = first.continued(0.45, law_parameters={"e_energetic": 0.1})
    speeds = [piece.at_events("y_A_dot_after_touchdown") for piece in (first, rest)]
    assert all(len(s) for s in speeds)
    assert run.at_events("y_A_dot_after_touchdown").tolist() == np.concatenate(speeds).tolist()
