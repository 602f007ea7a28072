"""What do all first derivatives of a Table 3 impact cost, in plain runs?

``python -m tests.benchmarks.bench_sensitivity`` times the plain motion and the motion with its
derivatives by eight parameters (mu, e, E, n, m, l, m l²/J, g) in the event loop, by processor time
in one process, alternating; and the same through the Python interface. Both take Runge–Kutta steps:
a plain run of the Taylor engine, the default, takes half the time.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator

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


def loops(rtol: float) -> tuple[Callable[[], Any], Callable[[], Any], Simulator]:
    """Return calls of the event loop alone: the plain one, and that with derivatives."""
    sim = Simulator(model("rod-inertia"), law("bilinear-hertz", reload="virgin"), "compiled")
    sim.sensitivities(STATE, WRT, rtol=rtol, **OPTIONS)
    engine, _ = next(iter(sim.variational_engines.values()))
    captured: list[Any] = []

    class Spy:
        outline, constants, outputs = engine.outline, engine.constants, engine.outputs

        def run(self, *arguments: Any) -> Any:
            captured.append(arguments)
            return engine.run(*arguments)

    for key, (_, functions) in list(sim.variational_engines.items()):
        sim.variational_engines[key] = (Spy(), functions)
    sim.sensitivities(STATE, WRT, rtol=rtol, **OPTIONS)
    start, parameters, options = captured[0]
    nx = len(sim.automaton.states)
    plain = replace(options, atol=options.atol[:nx])
    return (
        lambda: sim.integrator.run(start[:nx], parameters, plain),
        lambda: engine.run(start, parameters, options),
        sim,
    )


def measure(rtol: float) -> dict[str, float]:
    """Return the ratios in the loop and through Python."""
    plain, whole, sim = loops(rtol)
    sim.sensitivities(STATE, WRT, rtol=rtol, **OPTIONS)
    return {
        "loop": ratio(plain, whole, 300),
        "python": ratio(
            lambda: sim.run(STATE, rtol=rtol, **OPTIONS),
            lambda: sim.sensitivities(STATE, WRT, rtol=rtol, **OPTIONS),
            20,
        ),
    }


@pytest.mark.slow
def test_jacobian_of_eight_states_by_eight_parameters_costs_less_than_four_runs():
    assert measure(1e-11)["loop"] < 4


if __name__ == "__main__":
    for tolerance in (1e-9, 1e-10, 1e-11, 1e-12):
        times = measure(tolerance)
        print(f"rtol {tolerance:g}: loop {times['loop']:.2f}, Python {times['python']:.2f}")
