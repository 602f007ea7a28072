"""Batches of rigid motion: each row ends as the single run does, for the same reason."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.laws.rigid import RigidLaw
from painleve_sym.simulate.batch.result import ManyResult
from painleve_sym.simulate.batch.run import simulate_many
from painleve_sym.simulate.simulator import Simulator

KEPT = 3
AT_START = ("left_domain", "invalid_start", "non_finite")
COUNTERS = ("accepted_steps", "rejected_steps", "guard_evaluations", "events")


@pytest.fixture(scope="module", params=["taylor", "compiled"])
def rigid(request) -> Simulator:
    return Simulator(model("rod"), RigidLaw(), request.param)


def check_row(found: ManyResult, i: int) -> None:
    """Compare a row with the single run of its numbers."""
    try:
        single = found.trajectory(i)
    except InputError:
        assert found["stop_reason"][i] in AT_START
        assert found["time"][i] == 0 and np.isnan(found["event_times"][i]).all()
        return
    assert single.stop_reason.label == found["stop_reason"][i]
    assert single.final_time == found["time"][i]
    assert single.final_state.tobytes() == found.rows.state[i].tobytes()
    assert single.final_memory.tobytes() == found.rows.memory[i].tobytes()
    assert single.mode_names[single.final_mode] == found["mode"][i]
    for name in COUNTERS if single.engine != "erk" else ():
        assert single.counters[name] == found[name][i]
    for k, kind in enumerate(found.kinds):
        times = [e.time for e in single.events_of(kind)]
        kept = times[:KEPT] + [math.nan] * (KEPT - len(times))
        assert found["event_counts"][i, k] == found[f"count_of_{kind}"][i] == len(times)
        assert np.array_equal(found["event_times"][i, k], kept, equal_nan=True)
        assert np.array_equal(found[f"times_of_{kind}"][i], kept, equal_nan=True)


def drawn(seed: int, rows: int) -> tuple[dict, dict]:
    draw = np.random.default_rng(seed)
    states = {
        "y_A": draw.choice([0.0, 0.0, 0.0, 0.02, -0.01], rows),
        "theta": draw.uniform(-0.1, 1.5, rows),
        "theta_dot": draw.choice([0.0, 1.0, 3.0, 6.0], rows),
        "x_A_dot": draw.choice([-30.0, -1.0, 0.0, 20.0], rows),
    }
    return states, {"mu": draw.uniform(1.2, 2.5, rows), "e_energetic": draw.uniform(0, 0.9, rows)}


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 1000))
def test_random_rows_end_as_single_runs_do(rigid, seed):
    found = simulate_many(rigid, *drawn(seed, 12), t_end=1.0, max_events=60, events=KEPT)
    for i in range(12):
        check_row(found, i)


def test_every_kind_of_end_occurs_among_random_rows(rigid):
    found = simulate_many(rigid, *drawn(5, 300), t_end=1.0, max_events=60, events=KEPT)
    assert set(found.counts()) >= {"t_end", "left_domain", "event_limit", "dynamic_jam"}
    assert found.counts()["invalid_start"] > 20
    assert found["count_of_settle"].sum() > 0
    seen: Counter[str] = Counter()
    for i, reason in enumerate(found["stop_reason"].tolist()):
        seen[reason] += 1
        if seen[reason] <= 5 or found["count_of_settle"][i]:
            check_row(found, i)


def test_slips_that_meet_the_singular_point_are_told_apart(rigid):
    """Glocker's rod jams at θ = 45°; from forces well below F* the slip lifts off instead."""
    states = {"theta": np.radians([31.0, 31.0, 40.0]), "x_A_dot": [-30.0, -29.0, -0.5]}
    found = simulate_many(rigid, states, {"g": 10.0, "mu": 5 / 3}, t_end=3.0, events=KEPT)
    assert found["stop_reason"][:2].tolist() == ["dynamic_jam"] * 2
    for i in range(3):
        check_row(found, i)
    assert found.trajectory(0).limit.time == pytest.approx(found["time"][0], abs=1e-6)


def test_bounces_that_settle_are_among_the_events(rigid):
    states = {"theta": np.pi / 2, "y_A": [0.01, 0.02]}
    given = {"t_end": 0.5, "events": KEPT}
    found = simulate_many(rigid, states, {"e_energetic": [0.2, 0.5]}, **given)
    assert found["count_of_settle"].tolist() == [1, 1]
    until = simulate_many(rigid, states, {"e_energetic": [0.2, 0.5]}, until="settle", **given)
    assert until["stop_reason"].tolist() == ["until", "until"]
    assert until["time"].tolist() == found["time_of_settle"].tolist()
    assert until["y_A"].tolist() == until["y_A_dot"].tolist() == [0.0, 0.0]
    for i in range(2):
        check_row(found, i)
        check_row(until, i)


def test_the_second_engine_names_the_same_ends():
    states = {"theta": np.radians([31.0, 40.0]), "x_A_dot": -30.0, "y_A": [0.0, -0.1]}
    second = Simulator(model("rod"), RigidLaw(), "erk")
    found = simulate_many(second, states, {"g": 10.0, "mu": 5 / 3}, t_end=3.0, events=KEPT)
    assert found["stop_reason"].tolist() == ["dynamic_jam", "invalid_start"]
    check_row(found, 0)


def test_event_times_are_labelled_by_kind_and_occurrence(rigid):
    pytest.importorskip("xarray")
    states = {"theta": np.pi / 2, "y_A": [[0.01], [0.02]]}
    found = simulate_many(rigid, states, {"e_energetic": [0.2, 0.5]}, t_end=0.5, events=4)
    data = found.to_xarray(dims=("y_A", "e"))
    times = data["event_times"].sel(event="touchdown")
    assert times.dims == ("y_A", "e", "occurrence")
    assert times.attrs["units"] == "s"
    assert times.sel(occurrence=1).values.tolist() == found["time_of_touchdown"].tolist()
    assert data["event_counts"].sel(event="settle").values.tolist() == [[1, 1], [1, 1]]
    assert found["times_of_touchdown"].shape == (2, 2, 4)
