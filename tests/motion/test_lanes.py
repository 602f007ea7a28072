"""Motions in the lanes of a vector: results are bitwise independent of the other lanes."""

from __future__ import annotations

import dataclasses
import shutil

import numpy as np
import pytest

from painleve_sym.codegen.compile import find_compiler
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.simulator import Simulator
from tests.support.paper_law import paper_law

ROWS = 250


@pytest.fixture(scope="module")
def softened() -> Simulator:
    return Simulator(model("rod"), paper_law(reload="virgin"), "taylor")


@pytest.fixture(scope="module")
def rigid() -> Simulator:
    return Simulator(model("rod"), RigidLaw(), "taylor")


def touching(rows: int = ROWS) -> tuple[dict, dict]:
    """Impacts, falls, a motion that flies apart, one outside the domain: in any order."""
    draw = np.random.default_rng(11)
    states = {
        "theta": draw.uniform(0.3, 1.4, rows),
        "theta_dot": draw.uniform(-2.0, 2.0, rows),
        "x_A_dot": draw.choice([-1.0, -0.2, 0.0, 0.5], rows),
        "y_A_dot": draw.choice([0.0, -0.3], rows),
    }
    states["theta"][23] = 4.0
    # A contact force beyond the largest double.
    states["y_A"] = np.where(np.arange(rows) == 17, -1e100, 0.0)
    parameters = {
        "mu": draw.uniform(0.2, 1.6, rows),
        "e_energetic": draw.uniform(0.3, 0.9, rows),
        "E": draw.choice([20.9e10, 20.9e14], rows),
        "n": np.where(np.arange(rows) == 17, 5.0, 1.5),
    }
    return states, parameters


def falling(rows: int = ROWS) -> tuple[dict, dict]:
    """Rigid motions: slip, stick, and bounces that come closer and closer."""
    draw = np.random.default_rng(12)
    states = {
        "theta": draw.uniform(0.7, 1.3, rows),
        "y_A": draw.choice([0.0, 0.01], rows),
        "x_A_dot": draw.choice([-0.5, 0.0, 0.5], rows),
    }
    return states, {"mu": draw.uniform(0.1, 0.6, rows)}


OPTIONS = {
    "until": {"t_end": 0.01, "until": ("separation",), "rtol": 1e-9},
    "t_end": {"t_end": 3e-4, "rtol": 1e-6},
    "steps": {"t_end": 0.01, "rtol": 1e-9, "max_steps": 25},
    "events": {"t_end": 0.05, "rtol": 1e-7, "max_events": 4, "events": 3},
    "first step": {"t_end": 0.002, "rtol": 1e-11, "max_step": 1e-4, "first_step": 1e-6},
}


def chosen(given, order):
    return {n: v[order] if np.ndim(v) else v for n, v in given.items()}


def with_lanes(simulator, lanes, states, parameters, monkeypatch, **options):
    monkeypatch.setattr(simulator.integrator, "lanes", lanes)
    return run_batch(simulator, states, parameters, **options).rows


def assert_same_bits(a, b):
    for f in dataclasses.fields(a):
        assert getattr(a, f.name).tobytes() == getattr(b, f.name).tobytes(), f.name


@pytest.mark.parametrize("case", OPTIONS)
def test_bits_do_not_depend_on_lanes_threads_and_order(softened, case, monkeypatch):
    states, parameters = touching()
    one = with_lanes(softened, 1, states, parameters, monkeypatch, threads=1, **OPTIONS[case])
    for lanes, threads in ((2, 1), (3, 2), (8, 1), (8, 3)):
        batch = with_lanes(
            softened, lanes, states, parameters, monkeypatch, threads=threads, **OPTIONS[case]
        )
        assert_same_bits(batch, one)
    order = np.random.default_rng(1).permutation(ROWS)
    mixed = [chosen(given, order) for given in (states, parameters)]
    assert_same_bits(with_lanes(softened, 8, *mixed, monkeypatch, **OPTIONS[case]), one.part(order))


def test_the_rows_end_in_many_ways(softened):
    states, parameters = touching()
    reasons = {}
    for options in OPTIONS.values():
        reasons |= run_batch(softened, states, parameters, **options).counts()
    assert {"until", "t_end", "step_limit", "event_limit", "left_domain"} <= set(reasons)
    assert {"non_finite", "step_underflow"} & set(reasons)


def test_rows_in_lanes_are_the_single_runs(softened):
    states, parameters = touching()
    batch = run_batch(softened, states, parameters, **OPTIONS["until"])
    for i in range(0, ROWS, 8):
        given, law_given = (
            {n: float(v) for n, v in chosen(a, i).items()} for a in (states, parameters)
        )
        single = softened.run(given, parameters=law_given, record="events", **OPTIONS["until"])
        assert single.final_state.tobytes() == batch.rows.state[i].tobytes()
        assert single.final_memory.tobytes() == batch.rows.memory[i].tobytes()
        assert single.final_time == batch["time"][i]
        assert list(single.counters.values()) == batch.rows.counters[i].tolist()


def test_rigid_motions_and_accumulations_in_lanes(rigid, monkeypatch):
    states, parameters = falling(60)
    options = {"t_end": 0.3, "rtol": 1e-8, "events": 5}
    one = with_lanes(rigid, 1, states, parameters, monkeypatch, threads=1, **options)
    assert_same_bits(
        with_lanes(rigid, 8, states, parameters, monkeypatch, threads=2, **options), one
    )
    assert one.event_counts.sum() > 60


def test_rows_in_lanes_are_the_single_runs_of_another_compiler(monkeypatch, tmp_path):
    other = "gcc" if "clang" in find_compiler().version else "clang"
    if shutil.which(other) is None:
        pytest.skip(f"{other} is not installed")
    monkeypatch.setenv("CC", other)
    monkeypatch.setenv("PAINLEVE_CACHE", str(tmp_path))
    simulator = Simulator(model("rod"), paper_law(reload="virgin"), "taylor")
    states, parameters = touching()
    one = with_lanes(simulator, 1, states, parameters, monkeypatch, **OPTIONS["until"])
    assert_same_bits(
        with_lanes(simulator, 8, states, parameters, monkeypatch, **OPTIONS["until"]), one
    )


@pytest.mark.slow
@pytest.mark.usefixtures("optimized")
@pytest.mark.parametrize("width", [2, 4, 8])
def test_vectors_of_any_width_give_the_same_bits(softened, width, monkeypatch):
    class Wide(TaylorEngine):
        @staticmethod
        def _source(functions):
            return f"#define PS_LANES {width}\n" + TaylorEngine._source(functions)

        @classmethod
        def _alone(cls, text):
            return text

    states, parameters = touching()
    one = with_lanes(softened, 1, states, parameters, monkeypatch, **OPTIONS["until"])
    monkeypatch.setitem(softened.__dict__, "integrator", Wide(softened.contact.automaton))
    wide = with_lanes(softened, 8, states, parameters, monkeypatch, **OPTIONS["until"])
    assert_same_bits(wide, one)


@pytest.mark.slow
@pytest.mark.usefixtures("optimized")
def test_bits_of_the_arm_do_not_depend_on_lanes(monkeypatch):
    arm = Simulator(model("two-link-arm"), paper_law(reload="virgin"), "taylor")
    draw = np.random.default_rng(13)
    angles = draw.uniform(-1.35, -1.25, ROWS), draw.uniform(-1.85, -1.75, ROWS)
    states = {"theta_1": angles[0], "theta_2": angles[1]}
    parameters = {"mu": draw.uniform(0.3, 1.1, ROWS), "E": 20.9e14}
    parameters["h"] = -0.5 * (np.sin(angles[0]) + np.sin(angles[1]))
    one = with_lanes(arm, 1, states, parameters, monkeypatch, **OPTIONS["until"])
    assert_same_bits(with_lanes(arm, 8, states, parameters, monkeypatch, **OPTIONS["until"]), one)
