"""What do calls of a user cost besides the engine?

``python -m tests.benchmarks.bench_call`` times, in turn in one process and by processor time, the
engine on a start that is ready, and `Simulator.run` with names and numbers, both with every step
kept. The first is the impact of Table 3. Then, beside the same engine's run, the calls that take a
mechanism and a law by name: `simulate`, `classify` and `evaluate_jump`.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any

from painleve_sym.at.cases import classify
from painleve_sym.at.jump import evaluate_jump
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.engines.protocol import RunSettings
from painleve_sym.laws.catalogue import Law, law
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.runs import simulate
from painleve_sym.motion.simulator import Simulator
from tests.support.paper_law import paper_law

LIMIT = 60e-6
"""Wanted of a call for the impact of Table 3, s."""
OVERHEAD = 2.5
"""Most that a call for it may take, in parts of the engine's time."""

NAMED_LIMITS = {"simulate": 150e-6, "classify": 100e-6, "evaluate_jump": 300e-6}
NAMED_LIMITS |= {"classify, at rest": 100e-6, "classify, two feet": 100e-6}
"""Wanted of the calls with names, s."""
NAMED_RATIOS = {"simulate": 4.0, "classify": 3.5, "evaluate_jump": 10.0}
NAMED_RATIOS |= {"classify, at rest": 4.5, "classify, two feet": 6.5}
"""Most that they may take, in parts of the engine's time for the impact of Table 3."""

TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
FALL = {"x": 1.7, "y": 1.3, "theta": 0.9}


def cases() -> dict[str, tuple[Mechanism, Law, dict[str, Any]]]:
    """Return mechanism, law and arguments of `run`, by title."""
    hertz, rod = paper_law(reload="virgin"), model("rod")
    impact = {"parameters": {"E": 20.9e14}, "t_end": 0.01, "until": "separation"}
    bounce = {"state": TABLE_3 | {"y_A": 0.001}, "t_end": 0.05}
    fall = {"state": FALL, "t_end": 0.2}
    block = {"state": {"y_A": 0.005, "theta": 0.02}, "t_end": 0.05}
    return {
        "rod, compliant": (rod, hertz, {"state": TABLE_3, **impact}),
        "rod, rigid": (rod, law("rigid"), bounce),
        "block with two feet, rigid": (model("block-two-feet"), law("rigid"), block),
        "ladder, compliant, in flight": (model("ladder"), hertz, fall),
    }


def least(calls: dict[str, Callable[[], Any]], seconds: float) -> dict[str, float]:
    """Return the least processor time of each call, s; they take turns."""
    best = dict.fromkeys(calls, float("inf"))
    end = time.process_time() + seconds
    while time.process_time() < end:
        for name, call in calls.items():
            start = time.process_time()
            for _ in range(20):
                call()
            best[name] = min(best[name], (time.process_time() - start) / 20)
    return best


def measure(seconds: float = 1.0) -> dict[str, dict[str, float]]:
    """Return the times of engine and call in s, and the ratio of the second to the first."""
    lines = {}
    for title, (mechanism, chosen, given) in cases().items():
        simulator, options = Simulator(mechanism, chosen), dict(given)
        place = simulator.at(options.pop("state"), options.pop("parameters", None))
        start = simulator.start(place)
        ready = simulator.options(start.scale, RunSettings(**options))
        engine = simulator.integrator
        arguments = start.state, start.parameters, ready
        whole, alone = simulator.run(**given), engine.run(*arguments)
        assert whole.final_state.tobytes() == alone.state.tobytes()
        calls = {
            "engine": lambda engine=engine, a=arguments: engine.run(*a),
            "call": lambda simulator=simulator, g=given: simulator.run(**g),
        }
        best = least(calls, seconds)
        lines[title] = best | {"ratio": best["call"] / best["engine"]}
    return lines


def named(seconds: float = 1.0) -> dict[str, dict[str, float]]:
    """Return the time of each call with names in s, and its ratio to the engine's for Table 3."""
    mechanism, chosen, given = cases()["rod, compliant"]
    options = {name: value for name, value in given.items() if name != "state"}
    state, stiffness = given["state"], options.pop("parameters")
    simulator = Simulator(mechanism, chosen)
    start = simulator.start(simulator.at(state, stiffness))
    arguments = (
        start.state,
        start.parameters,
        simulator.options(start.scale, RunSettings(**options)),
    )
    engine = simulator.integrator
    calls: dict[str, Callable[[], Any]] = {
        "engine": lambda: engine.run(*arguments),
        "simulate": lambda: simulate("rod", chosen, state, parameters=stiffness, **options),
        "classify": lambda: classify("rod", state),
        "classify, at rest": lambda: classify("rod", {"theta": 1.0}),
        "classify, two feet": lambda: classify("block-two-feet", {"x_A_dot": -1.0}),
        "evaluate_jump": lambda: evaluate_jump("rod", "energetic", state),
    }
    assert calls["simulate"]().final_state.tobytes() == calls["engine"]().state.tobytes()
    assert classify("rod", state).case.value == "inconsistent"
    best = least(calls, seconds)
    return {n: {"call": best[n], "ratio": best[n] / best["engine"]} for n in NAMED_LIMITS}


def test_calls_with_names_cost_few_runs_of_the_engine():
    lines = named(0.5)
    print(json.dumps(lines, indent=2))
    assert all(lines[name]["ratio"] < most for name, most in NAMED_RATIOS.items())


def test_call_costs_little_besides_its_engine():
    lines = measure(0.5)
    print(json.dumps(lines, indent=2))
    assert lines["rod, compliant"]["ratio"] < OVERHEAD


if __name__ == "__main__":
    print(json.dumps({**measure(), "by name": named()}, indent=2))
