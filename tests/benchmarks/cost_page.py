"""The page ``docs/cost.md``: how costs grow with contacts, rows, points and modes.

``python -m tests.benchmarks.cost_page --measure`` measures again, in about a quarter of a minute
of one processor, keeps the numbers in ``docs/cost.json`` and writes the tables. Times are the least
processor times of repeated calls.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import painleve_sym as ps
from painleve_sym.motion.batch.machine import processor_count
from painleve_sym.tables import markdown_table
from painleve_sym.version import __version__
from tests.benchmarks.against import least_of
from tools.tables import written

ROOT = Path(__file__).parents[2]
PAGE, NUMBERS = ROOT / "docs" / "cost.md", ROOT / "docs" / "cost.json"
STATE = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
IMPACT: dict[str, Any] = {"t_end": 0.01, "until": "separation", "rtol": 1e-9}


def feet(n: int) -> ps.ContactProblem:
    """Return a body of mass 1 that rests on n level feet."""
    rows = [row for x in np.linspace(-0.5, 0.5, n) for row in ((0.0, 1.0, x), (1.0, 0.0, 0.5))]
    J = np.array(rows)
    b = J @ np.array([0.0, -9.8, 0.0])
    return ps.ContactProblem(J @ np.diag([1.0, 1.0, 3.0]) @ J.T, b, np.full(n, 0.5), np.zeros(n))


def sliding(n: int) -> ps.ContactProblem:
    """Return a problem of n sliding contacts with a mobility of full rank."""
    draw = np.random.default_rng(0)
    G, b = draw.normal(size=(2 * n, 2 * n)), draw.normal(size=2 * n)
    b[::2] -= 5.0
    return ps.ContactProblem(G @ G.T + np.eye(2 * n), b, np.full(n, 0.5), np.full(n, -1.0))


def again(problem: Callable[[], ps.ContactProblem]) -> Callable[[], object]:
    """Return a call that states a problem and solves it."""
    return lambda: problem().solutions()


def contacts() -> list[dict[str, float]]:
    """Return the times of all solutions of feet at rest, and of one solution by Lemke, s."""
    return [
        {"contacts": n, "seconds": least_of(again(lambda n=n: feet(n)), 0.3)} for n in range(1, 7)
    ]


def pivots() -> list[dict[str, float]]:
    """Return the times of Lemke's pivots for sliding contacts, s."""
    problems = {n: sliding(n) for n in (5, 10, 20, 50)}
    return [
        {"contacts": n, "seconds": least_of(problem.solve_lemke, 0.3)}
        for n, problem in problems.items()
    ]


def rows() -> list[dict[str, float]]:
    """Return the times of batches of impacts of the rod on one thread, s."""
    lines = []
    for n in (1, 10, 100, 1000, 10000):
        states = STATE | {"theta": np.linspace(1.0, 1.1, n)}
        given = {"parameters": {"mu": 1.5}, "threads": 1, **IMPACT}
        call = lambda s=states, g=given: ps.simulate_batch("rod", "bilinear-hertz", s, **g)  # noqa: E731
        call()
        lines.append({"rows": n, "seconds": least_of(call, 0.5)})
    return lines


def points() -> list[dict[str, float]]:
    """Return the times of maps of the rod, s."""
    over = ("theta", "theta_dot")
    return [
        {"points": n, "seconds": least_of(lambda n=n: ps.region_map("rod", over, points=n), 0.5)}
        for n in (50, 200, 800)
    ]


def modes() -> list[dict[str, float]]:
    """Return the times of impacts of the elastic bar with natural modes, s."""
    lines = []
    for n in (0, 2, 5, 10):
        simulator = ps.Simulator(ps.model(f"rod-bending:{n},0"), ps.law("hertz"))
        run = lambda s=simulator: s.run(s.mechanism.start, record="end", t_end=1e-3)  # noqa: E731
        steps = run().counters["accepted_steps"]
        lines.append({"modes": n, "seconds": least_of(run, 0.3) / steps})
    return lines


PARTS: dict[str, Callable[[], list[dict[str, Any]]]] = {
    "contacts": contacts,
    "pivots": pivots,
    "rows": rows,
    "points": points,
    "modes": modes,
}


def measure() -> dict[str, Any]:
    """Return all numbers."""
    computed = {"version": __version__, "law": "named with the numbers"}
    return {"computed": computed, "processors": processor_count()} | {
        name: part() for name, part in PARTS.items()
    }


def tables(numbers: dict[str, Any]) -> dict[str, str]:
    """Return the tables of the page by their names."""

    def of(part: str, name: str, head: Sequence[str], each: bool = False) -> str:
        lines = []
        for line in numbers[part]:
            count = line[name] ** 2 if name == "points" else max(line[name], 1)
            cells = [f"{line[name]}", f"{1e3 * line['seconds']:.3g}"]
            lines.append((*cells, *([f"{1e6 * line['seconds'] / count:.3g}"] if each else [])))
        return markdown_table(tuple(head), lines)

    step = [(f"{m['modes']}", f"{1e6 * m['seconds']:.2f}") for m in numbers["modes"]]
    return {
        "contacts": of("contacts", "contacts", ("feet at rest", "all solutions, ms")),
        "pivots": of("pivots", "contacts", ("sliding contacts", "one solution, ms")),
        "rows": of("rows", "rows", ("rows", "batch, ms", "a row, µs"), each=True),
        "points": of("points", "points", ("points an axis", "map, ms", "a point, µs"), each=True),
        "modes": markdown_table(("bending modes", "a step, µs"), step),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure where asked, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--measure", action="store_true", help="measure again")
    o = parser.parse_args(arguments)
    if o.measure:
        NUMBERS.write_text(json.dumps(measure(), indent=1) + "\n", "utf-8")
    numbers = json.loads(NUMBERS.read_text("utf-8"))
    PAGE.write_text(written(PAGE.read_text("utf-8"), tables(numbers)), "utf-8")


if __name__ == "__main__":
    main()
