"""What does one impact of many cost: the package's batch against heyoka's batch mode?

``python -m tests.benchmarks.bench_many`` runs impacts around Table 3 over a grid of angle, angular
velocity, friction and restitution, each peer at the loosest tolerance with which its error in the
final speeds is at most 1e-9 at every sampled point. heyoka runs twice: with different impacts in
its lanes, which then wait for each other at every event, and with the same impact in all of them,
the best case for lanes; how many lanes, 2, 4 or 8, is what suits it best on this machine. All on
one thread, in processor time; ratios are what to read. Then what the package's own lanes and
threads are worth, of rod and two-link arm: the blocks of rows also say how long threads waited for
each other, so that other work on the machine does not count.
"""

from __future__ import annotations

import argparse
import itertools
import json
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.motion.batch import run as batch_run
from painleve_sym.motion.batch.machine import processor_count
from painleve_sym.motion.batch.result import BatchResult
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.simulator import Simulator
from tests.benchmarks import cases, peers
from tests.benchmarks.cases import ROD, Rod
from tests.support.paper_law import paper_law

TARGET = 1e-9
RANGES = {
    "theta": (1.0, 1.1),
    "theta_dot": (0.8, 1.2),
    "mu": (1.45, 1.6),
    "e_energetic": (0.6, 0.9),
}
HEYOKA_LANES = (2, 4, 8)
COMPARED = ("y_A_dot", "theta_dot")


def impacts(per_axis: int) -> dict[str, np.ndarray]:
    """Return a grid of impacts as flat arrays."""
    axes = [np.linspace(low, high, per_axis) for low, high in RANGES.values()]
    grid = np.meshgrid(*axes, indexing="ij")
    return {n: a.ravel() for n, a in zip(RANGES, grid, strict=True)}


def package_batch(
    given: dict[str, np.ndarray], tol: float, threads: int, engine: str = "compiled"
) -> tuple[BatchResult, float, float]:
    """Return result, processor time and wall time."""
    simulator = Simulator(rod(), paper_law(reload="virgin"), engine)
    return timed(simulator, *rod_rows(given), tol, threads)


def rod_rows(given: dict[str, np.ndarray]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return states and parameters of the grid of impacts."""
    states = {"theta": given["theta"], "theta_dot": given["theta_dot"], "x_A_dot": -1.0}
    return states, {"mu": given["mu"], "e_energetic": given["e_energetic"], "E": 20.9e14}


def arm_rows(count: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return states and parameters of arms at rest around the one of `bench_table3`."""
    draw = np.random.default_rng(0)
    one, two = draw.uniform(-1.35, -1.25, count), draw.uniform(-1.85, -1.75, count)
    parameters = {"mu": draw.uniform(0.95, 1.1, count), "E": 20.9e14}
    parameters["h"] = -0.5 * (np.sin(one) + np.sin(two))
    return {"theta_1": one, "theta_2": two}, parameters


def timed(
    simulator: Simulator,
    states: dict[str, Any],
    parameters: dict[str, Any],
    tol: float,
    threads: int,
) -> tuple[BatchResult, float, float]:
    """Return result, processor time and wall time of impacts until separation."""
    options: dict[str, Any] = {"t_end": 0.01, "until": "separation", "threads": threads}
    first = [{n: np.ravel(v)[:1] for n, v in a.items()} for a in (states, parameters)]
    run_batch(simulator, *first, **options)
    cpu, wall = time.process_time(), time.perf_counter()
    batch = run_batch(simulator, states, parameters, rtol=tol, **options)
    return batch, time.process_time() - cpu, time.perf_counter() - wall


class HeyokaBatch:
    """heyoka's batch mode: lanes of impacts, one integrator per phase.

    A terminal event ends the call for all lanes; those that are not there yet are called again.
    """

    def __init__(self, tol: float, lanes: int) -> None:
        import heyoka as hy

        self.lanes = lanes
        self._built = []
        operators = peers._HeyokaOperators(float)
        z = hy.make_vars(*ROD.states)
        with (
            mock.patch.object(Rod, "mu", hy.par[1]),
            mock.patch.object(cases, "E_ENERGETIC", hy.par[2]),
        ):
            for phase in cases.phases(True):
                rates = ROD.equations(phase, operators, z, hy.par[0])
                event = hy.t_event_batch(
                    ROD.guard(phase, operators, z, hy.par[0]),
                    direction=hy.event_direction.negative,
                )
                integrator = hy.taylor_adaptive_batch(
                    list(zip(z, rates, strict=True)),
                    np.zeros((len(ROD.states), lanes)),
                    t_events=[event],
                    tol=tol,
                )
                self._built.append((phase, integrator))

    def start(self, theta: Any, omega: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return the scaled states (6, lanes) and times (lanes,) shortly after touching."""
        z, t = np.empty((len(ROD.states), self.lanes)), np.empty(self.lanes)
        for i in range(self.lanes):
            start = (0.0, -1.0, 0.0, 0.0, float(theta[i]), float(omega[i]))
            z[:, i], t[i] = replace(ROD, start=start).free_start(peers.HeyokaPeer.begin)
        return z, t

    def run(self, z: np.ndarray, t: np.ndarray, mu: Any, e: Any) -> np.ndarray:
        """Return y_A_dot and theta_dot at separation, shape (2, lanes)."""
        delta_max = np.ones(self.lanes)
        for phase, integrator in self._built:
            integrator.set_time(t)
            integrator.state[:] = z
            integrator.pars[:] = np.array((delta_max, mu, e))[: len(integrator.pars)]
            integrator.reset_cooldowns()
            ends = np.full(self.lanes, ROD.horizon)
            while True:
                integrator.propagate_until(ends)
                done = np.array([int(r[0]) == -1 for r in integrator.propagate_res])
                now = np.array(integrator.time)
                ends = np.where(done, now, ends)
                if (ends < ROD.horizon).all():
                    break
                if not done.any():
                    raise RuntimeError(f"heyoka batch, {phase}: {integrator.propagate_res}")
            t, z = now, np.array(integrator.state)
            if phase.guard == "slip":
                z[1] = 0.0
            if phase.guard == "turn":
                z[3] = 0.0
                delta_max = -z[2] * ROD.scale[2]
        return np.array([z[3] * ROD.scale[3], z[5] * ROD.scale[5]])


def heyoka_batch(
    given: dict[str, np.ndarray], tol: float, same: bool, lanes: int
) -> tuple[np.ndarray, float]:
    """Return final speeds (2, n) and processor time; `same`: each impact in all lanes at once."""
    batch = HeyokaBatch(tol, lanes)
    columns = np.array([given[n] for n in RANGES])
    n = columns.shape[1]
    if same:
        groups = [np.full(lanes, i) for i in range(0, n, lanes)]
    else:
        groups = [np.arange(i, i + lanes) for i in range(0, n - lanes + 1, lanes)]
    ends = np.full((2, n), np.nan)
    # The starts in Python floats are not what is measured.
    starts = [batch.start(*columns[:2, group]) for group in groups]
    batch.run(*starts[0], *columns[2:, groups[0]])
    begun = time.process_time()
    for group, start in zip(groups, starts, strict=True):
        ends[:, group] = batch.run(*start, *columns[2:, group])
    return ends, (time.process_time() - begun) / (len(groups) * lanes)


def _error(values: np.ndarray, exact: np.ndarray) -> dict[str, float]:
    error = np.abs(values / exact - 1).max(axis=0)
    error = error[np.isfinite(error)]
    return {"median": float(np.median(error)), "largest": float(error.max())}


def _tuned(errors: Callable[[float], dict[str, float]], loosest: float) -> float:
    """Return the loosest tolerance, four to a decade, that holds at this and the next one."""
    tolerances = [loosest * 10 ** (-k / 4) for k in range(24)]
    for loose, tight in itertools.pairwise(tolerances):
        if max(errors(loose)["largest"], errors(tight)["largest"]) <= TARGET:
            return loose
    raise RuntimeError(f"no tolerance reaches {TARGET:g}.")


def best_lanes(part: dict[str, np.ndarray], tol: float) -> int:
    """Return the number of lanes with which heyoka is fastest here."""
    seconds = {n: min(heyoka_batch(part, tol, False, n)[1] for _ in range(3)) for n in HEYOKA_LANES}
    return min(seconds, key=lambda n: seconds[n])


def measure(per_axis: int, some: int) -> dict[str, Any]:
    """Return tolerances, errors, and processor time per impact."""
    given = impacts(per_axis)
    n = len(given["theta"])
    chosen = np.random.default_rng(0).permutation(n)[: some - some % max(HEYOKA_LANES)]
    chosen.sort()
    part = {name: v[chosen] for name, v in given.items()}
    lanes = best_lanes(part, 1e-7)
    reference, _, _ = package_batch(part, 1e-13, 1)
    exact = np.array([reference[name] for name in COMPARED])

    def own(tol: float, engine: str = "taylor") -> dict[str, float]:
        ends, _, _ = package_batch(part, tol, 1, engine)
        return _error(np.array([ends[name] for name in COMPARED]), exact)

    def runge_kutta(tol: float) -> dict[str, float]:
        return own(tol, "compiled")

    def taylor(tol: float) -> dict[str, float]:
        return _error(heyoka_batch(part, tol, False, lanes)[0], exact)

    engines = {"taylor": _tuned(own, 1e-7), "compiled": _tuned(runge_kutta, 1e-8)}
    tol_taylor = _tuned(taylor, 1e-7)
    lines: dict[str, Any] = {"impacts": n, "heyoka_impacts": len(chosen), "heyoka_lanes": lanes}
    # Each is timed three times, in turn: another program on the machine shows as a difference.
    for _ in range(3):
        for engine, tol in engines.items():
            _, cpu, _ = package_batch(given, tol, 1, engine)
            error = own(tol, engine)
            line = lines.setdefault(engine, {"tolerance": tol, "error": error, "us": []})
            line["us"].append(1e6 * cpu / n)
        for name, same in (("heyoka", False), ("heyoka_same_in_all_lanes", True)):
            values, seconds = heyoka_batch(part, tol_taylor, same, lanes)
            line = lines.setdefault(name, {"tolerance": tol_taylor, "us": []})
            line |= {"error": _error(values, exact)}
            line["us"].append(1e6 * seconds)
    for line in lines.values():
        if isinstance(line, dict):
            line["ratio"] = min(line["us"]) / min(lines["taylor"]["us"])
    return lines


def threads(per_axis: int, counts: Sequence[int], repeats: int = 6) -> dict[int, dict[str, float]]:
    """Return wall and processor time per impact by the number of threads, the best of some.

    `idle` is the part of their time that threads spent waiting for each other, not for a processor.
    """
    given = impacts(per_axis)
    n = len(given["theta"])
    best: dict[int, dict[str, float]] = {}
    for _, count in itertools.product(range(repeats), counts):
        with Waits() as waits:
            _, cpu, wall = package_batch(given, 1e-9, count, "taylor")
        now = {"wall": 1e6 * wall / n, "processor": 1e6 * cpu / n, "idle": waits.idle}
        old = best.get(count, now)
        best[count] = {k: min(old[k], v) for k, v in now.items()}
    return best


class Waits:
    """Says how long the threads of batches begun inside were neither running nor ready to run."""

    def __enter__(self) -> Waits:
        """Watch the pools of threads that batches make."""
        self._seen: dict[int, tuple[Any, Any]] = {}
        record = self._seen

        class Watched(ThreadPoolExecutor):
            def map(self, work: Any, starts: Any, **more: Any) -> Any:
                def watched(start: Any) -> None:
                    first = record.get(threading.get_ident(), (_scheduled(), None))[0]
                    work(start)
                    record[threading.get_ident()] = (first, _scheduled())

                return super().map(watched, starts, **more)

        self._patch = mock.patch.object(batch_run, "ThreadPoolExecutor", Watched)
        self._patch.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the pools as they were."""
        self._patch.stop()

    @property
    def idle(self) -> float:
        """Part of the threads' time, from their first block to the end of the last of all."""
        if not self._seen:
            return 0.0
        end = max(last[0] for _, last in self._seen.values())
        spans = [(end - a[0], (b - a)[1]) for a, b in self._seen.values()]
        return 1 - sum(busy for _, busy in spans) / sum(whole for whole, _ in spans)


def _scheduled() -> np.ndarray:
    """Return the clock, and the time in which this thread ran or was ready to run; s."""
    running, ready = Path("/proc/thread-self/schedstat").read_text("ascii").split()[:2]
    return np.array([time.perf_counter(), 1e-9 * (int(running) + int(ready))])


def lanes(count: int, repeats: int = 3) -> dict[str, dict[str, float]]:
    """Return processor time per impact of rod and arm with one lane and with all, best of some."""
    ratios = {}
    given = impacts(round(count**0.25))
    for name, rows in (("rod", rod_rows(given)), ("two-link-arm", arm_rows(count))):
        simulator = Simulator(model(name), paper_law(reload="virgin"), "taylor")
        engine = simulator.integrator
        assert isinstance(engine, TaylorEngine)
        best = {"one": np.inf, "all": np.inf}
        for _, (which, number) in itertools.product(range(repeats), (("one", 1), ("all", 8))):
            with mock.patch.object(engine, "lanes", number):
                result, cpu, _ = timed(simulator, *rows, 1e-9, 1)
            best[which] = min(best[which], 1e6 * cpu / result["time"].size)
        ratios[name] = best | {"ratio": best["one"] / best["all"]}
    return ratios


def test_batches_agree_and_their_costs_are_shown():
    pytest.importorskip("heyoka")
    lines = measure(6, 64)
    print(json.dumps(lines, indent=2))
    for name in ("taylor", "compiled", "heyoka", "heyoka_same_in_all_lanes"):
        assert lines[name]["error"]["largest"] <= TARGET


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the costs as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--per-axis", type=int, default=18, help="the grid has this to the fourth")
    parser.add_argument("--heyoka-impacts", type=int, default=2000)
    parser.add_argument("--json", type=Path, metavar="FILE")
    o = parser.parse_args(arguments)
    lines = measure(o.per_axis, o.heyoka_impacts)
    lines["lanes"] = lanes(o.per_axis**4)
    lines["threads"] = threads(o.per_axis, range(1, processor_count() + 1))
    text = json.dumps(lines, indent=2)
    print(text)
    if o.json is not None:
        o.json.write_text(text + "\n")


if __name__ == "__main__":
    main()
