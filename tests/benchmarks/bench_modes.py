"""What do ten bending modes cost, and does a stiff mode that is not excited set the step?

``python -m tests.benchmarks.bench_modes`` runs the impact of Table 3 with the rigid rod and with
elastic ones, in both integrators, and prints steps, CPU time per run and its ratio to the rigid
rod's. With 100 times the modulus of steel the modes are ten times as stiff, and the impact
hardly excites them.
"""

from __future__ import annotations

import time
from typing import Any

import painleve_sym as ps

STATE = {"theta": 1.0, "x_A_dot": -1.0, "theta_dot": 1.0}
RODS = ("rod", "rod-bending:10,0", "rod-bending:10,3")
MODULI = (2.09e11, 2.09e13)
ENGINES = {"taylor": "Taylor", "compiled": "Runge-Kutta"}
REPEATS = 15
LIMIT = 10.0
"""CPU time of a run with ten bending modes of steel, in runs of the rigid rod."""


def cost(model: str, engine: str, **parameters: float) -> dict[str, Any]:
    """Return steps and least CPU time of a run of 10 ms, in seconds."""
    simulator = ps.Simulator(ps.model(model), ps.law("bilinear-hertz"), engine=engine)
    run = simulator.run(STATE, t_end=0.01, parameters=parameters)
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        simulator.run(STATE, t_end=0.01, parameters=parameters)
        times.append(time.process_time() - start)
    return {"steps": len(run.step_time), "seconds": min(times)}


def measure() -> dict[str, dict[str, Any]]:
    """Print and return the cost of a run, by integrator, rod and modulus."""
    rows = {}
    print("integrator   rod               Y [Pa]    steps  time [ms]  ratio")
    for engine, integrator in ENGINES.items():
        rigid = cost("rod", engine)
        for model in RODS:
            for modulus in MODULI if model != "rod" else (None,):
                row = cost(model, engine, Y=modulus) if modulus else rigid
                row["ratio"] = row["seconds"] / rigid["seconds"]
                text = f"{modulus:.2e}" if modulus else ""
                rows[" ".join(filter(None, (integrator, model, text)))] = row
                print(
                    f"{integrator:12s} {model:17s} {text:8s} {row['steps']:6d}"
                    f" {1e3 * row['seconds']:10.3f} {row['ratio']:6.1f}",
                    flush=True,
                )
    return rows


if __name__ == "__main__":
    measure()
