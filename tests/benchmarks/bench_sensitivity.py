"""What do all first derivatives of a Table 3 impact cost, in plain runs of the default engine?

``python -m tests.benchmarks.bench_sensitivity`` times the plain motion and the motion with its
derivatives by eight parameters (mu, e, E, n, m, l, m l²/J, g) in the event loop, by processor time
in one process, alternating; and the same through the Python interface. The first is a run of the
Taylor engine, the second one of each engine.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from painleve_sym.choices import EngineLike
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.motion.simulator import Simulator
from tests.support.paper_law import paper_law

LIMIT = 3.0
"""Plain runs of the engine."""
PYTHON_LIMIT = 5.0
"""Calls of `Simulator.run`."""
STATE = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
WRT = ("mu", "e_energetic", "E", "n", "m", "l", "alpha", "g")
OPTIONS: dict[str, Any] = {
    "parameters": {"E": 20.9e14}, "t_end": 0.01, "until": "separation", "record": "events",
}  # fmt: skip


def ratio(plain: Callable[[], Any], whole: Callable[[], Any], runs: int, rounds: int = 9) -> float:
    """Return the median over rounds of the processor time of `whole` in that of `plain`."""
    ratios = []
    for _ in range(rounds):
        times = []
        for call in (plain, whole):
            start = time.process_time()
            for _ in range(runs):
                call()
            times.append(time.process_time() - start)
        ratios.append(times[1] / times[0])
    return float(np.median(ratios))


def simulator(engine: EngineLike) -> Simulator:
    """Return the rod of any moment of inertia on a compliant contact."""
    return Simulator(model("rod-inertia"), paper_law(reload="virgin"), engine)


def loops(sim: Simulator, rtol: float) -> tuple[Callable[[], Any], Callable[[], Any]]:
    """Return calls of the event loop alone: the plain one, and that with derivatives."""
    sim.sensitivities(STATE, WRT, rtol=rtol, **OPTIONS)
    (directions,) = sim.directions.values()
    engine = directions.engine
    captured: list[Any] = []

    class Spy:
        outline, constants, outputs = engine.outline, engine.constants, engine.outputs

        def run(self, *arguments: Any, **more: Any) -> Any:
            captured.append(arguments)
            return engine.run(*arguments, **more)

    vars(directions)["engine"] = Spy()
    sim.sensitivities(STATE, WRT, rtol=rtol, **OPTIONS)
    vars(directions)["engine"] = engine
    start, parameters, options = captured[0]
    nx = len(sim.automaton.states)
    plain = replace(options, atol=options.atol[:nx])
    return (
        lambda: sim.integrator.run(start[:nx], parameters, plain),
        lambda: engine.run(start, parameters, options),
    )


def measure(rtol: float) -> dict[str, float]:
    """Return the ratios in the loop, of each engine, and through Python."""
    taylor, runge_kutta = simulator("taylor"), simulator("compiled")
    plain, whole = loops(taylor, rtol)
    _, other = loops(runge_kutta, rtol)
    return {
        "loop": ratio(plain, whole, 300),
        "loop of Runge-Kutta": ratio(plain, other, 300),
        "python": ratio(
            lambda: taylor.run(STATE, rtol=rtol, **OPTIONS),
            lambda: taylor.sensitivities(STATE, WRT, rtol=rtol, **OPTIONS),
            20,
        ),
    }


@pytest.mark.slow
def test_jacobian_of_eight_states_by_eight_parameters_costs_at_most_three_runs():
    ratios = measure(1e-11)
    assert ratios["loop"] <= LIMIT
    assert ratios["python"] <= PYTHON_LIMIT


if __name__ == "__main__":
    for tolerance in (1e-9, 1e-10, 1e-11, 1e-12):
        print(f"rtol {tolerance:g}: {measure(tolerance)}", flush=True)
