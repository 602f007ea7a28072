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
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.motion.batch.result import BatchResult
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.simulator import Simulator

KEPT = 3
AT_START = ("left_domain", "invalid_start", "non_finite")
COUNTERS = ("accepted_steps", "rejected_steps", "guard_evaluations", "events")


@pytest.fixture(scope="module", params=["taylor", "compiled"])
def rigid(request) -> Simulator:
    return Simulator(model("rod"), RigidLaw(), request.param)


def check_row(batch: BatchResult, i: int) -> None:
    """Compare a row with the single run of its numbers."""
    try:
        single = batch.trajectory(i)
    except InputError:
        assert batch["stop_reason"][i] in AT_START
        assert batch["time"][i] == 0 and np.isnan(batch["event_times"][i]).all()
        return
    assert single.stop_reason.label == batch["stop_reason"][i]
    assert single.final_time == batch["time"][i]
    assert single.final_state.tobytes() == batch.rows.state[i].tobytes()
    assert single.final_memory.tobytes() == batch.rows.memory[i].tobytes()
    assert single.mode_names[single.final_mode] == batch["mode"][i]
    for name in COUNTERS if single.engine != "erk" else ():
        assert single.counters[name] == batch[name][i]
    for k, kind in enumerate(batch.kinds):
        times = [e.time for e in single.events_of(kind)]
        kept = times[:KEPT] + [math.nan] * (KEPT - len(times))
        assert batch["event_counts"][i, k] == batch[f"count_of_{kind}"][i] == len(times)
        assert np.array_equal(batch["event_times"][i, k], kept, equal_nan=True)
        assert np.array_equal(batch[f"times_of_{kind}"][i], kept, equal_nan=True)


def drawn(seed: int, rows: int) -> tuple[dict, dict]:
    draw = np.random.default_rng(seed)
    states = {
        "y_A": draw.choice([0.0, 0.0, 0.0, 0.02, -0.01], rows),
        "theta": draw.uniform(-0.1, 1.5, rows),
        "theta_dot": draw.choice([0.0, 1.0, 3.0, 6.0], rows),
        "x_A_dot": draw.choice([-30.0, -1.0, 0.0, 20.0], rows),
    }
    return states, {"mu": draw.uniform(1.2, 2.5, rows), "e_energetic": draw.uniform(0, 0.9, rows)}


@settings(max_examples=6)
@given(st.integers(0, 1000))
def test_random_rows_end_as_single_runs_do(rigid, seed):
    batch = run_batch(rigid, *drawn(seed, 12), t_end=1.0, max_events=60, events=KEPT)
    for i in range(12):
        check_row(batch, i)


def test_every_kind_of_end_occurs_among_random_rows(rigid):
    batch = run_batch(rigid, *drawn(5, 300), t_end=1.0, max_events=60, events=KEPT)
    assert set(batch.counts()) >= {"t_end", "left_domain", "event_limit", "dynamic_jam"}
    assert batch.counts()["invalid_start"] > 20
    assert batch["count_of_settle"].sum() > 0
    seen: Counter[str] = Counter()
    for i, reason in enumerate(batch["stop_reason"].tolist()):
        seen[reason] += 1
        if seen[reason] <= 5 or batch["count_of_settle"][i]:
            check_row(batch, i)


def test_slips_that_meet_the_singular_point_are_told_apart(rigid):
    """The slip jams at θ = 45°; from forces well below F* the slip lifts off instead."""
    states = {"theta": np.radians([31.0, 31.0, 40.0]), "x_A_dot": [-30.0, -29.0, -0.5]}
    batch = run_batch(rigid, states, {"g": 10.0, "mu": 5 / 3}, t_end=3.0, events=KEPT)
    assert batch["stop_reason"][:2].tolist() == ["dynamic_jam"] * 2
    for i in range(3):
        check_row(batch, i)
    assert batch.trajectory(0).limit.time == pytest.approx(batch["time"][0], abs=1e-6)


def test_bounces_that_settle_are_among_the_events(rigid):
    states = {"theta": np.pi / 2, "y_A": [0.01, 0.02]}
    given = {"t_end": 0.5, "events": KEPT}
    batch = run_batch(rigid, states, {"e_energetic": [0.2, 0.5]}, **given)
    assert batch["count_of_settle"].tolist() == [1, 1]
    until = run_batch(rigid, states, {"e_energetic": [0.2, 0.5]}, until="settle", **given)
    assert until["stop_reason"].tolist() == ["until", "until"]
    assert until["time"].tolist() == batch["time_of_settle"].tolist()
    assert until["y_A"].tolist() == until["y_A_dot"].tolist() == [0.0, 0.0]
    for i in range(2):
        check_row(batch, i)
        check_row(until, i)


def test_the_second_engine_names_the_same_ends():
    states = {"theta": np.radians([31.0, 40.0]), "x_A_dot": -30.0, "y_A": [0.0, -0.1]}
    second = Simulator(model("rod"), RigidLaw(), "erk")
    batch = run_batch(second, states, {"g": 10.0, "mu": 5 / 3}, t_end=3.0, events=KEPT)
    assert batch["stop_reason"].tolist() == ["dynamic_jam", "invalid_start"]
    check_row(batch, 0)


def test_event_times_are_labelled_by_kind_and_occurrence(rigid):
    pytest.importorskip("xarray")
    states = {"theta": np.pi / 2, "y_A": [[0.01], [0.02]]}
    batch = run_batch(rigid, states, {"e_energetic": [0.2, 0.5]}, t_end=0.5, events=4)
    data = batch.to_xarray(dims=("y_A", "e"))
    times = data["event_times"].sel(event="touchdown")
    assert times.dims == ("y_A", "e", "occurrence")
    assert times.attrs["units"] == "s"
    assert times.sel(occurrence=1).values.tolist() == batch["time_of_touchdown"].tolist()
    assert data["event_counts"].sel(event="settle").values.tolist() == [[1, 1], [1, 1]]
    assert batch["times_of_touchdown"].shape == (2, 2, 4)
