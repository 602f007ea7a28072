"""What does an impact of one contact in space cost?

``python -m tests.benchmarks.bench_impact_in_space`` times random impacts by processor time: in the
compiled code alone, and with one call of `solve_impact` for each. Slips and mobilities of the first
kind are of one size, those of the second spread over decades.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable

from painleve_sym.arrays import Array
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.problem.impact.one_contact import solve_impact
from painleve_sym.problem.impact.spatial import MEASURES, impacts_in_space
from tests.problem.impact.test_impact_in_space import random_impacts

LAWS = {MEASURES.index(law.measure): law.name for law in RESTITUTIONS.values()}
LIMIT = 20e-6
"""Wanted of an impact in the compiled code, s."""


def _least(call: Callable[[], object], count: int, repeats: int = 5) -> float:
    best = float("inf")
    for _ in range(repeats):
        start = time.process_time()
        call()
        best = min(best, time.process_time() - start)
    return best / count


def _one_by_one(W: Array, given: Array) -> None:
    for own, row in zip(W, given, strict=True):
        solve_impact(own, row[6], row[7:10], LAWS[int(row[10])], row[11])


def measure() -> dict[str, dict[str, float]]:
    """Return the times of an impact, s, by the kind of impacts."""
    lines = {}
    for title, spread in {"one size": 0.0, "over decades": 1.0}.items():
        W, given = random_impacts(5000, 1, spread=spread)
        lines[title] = {
            "compiled": _least(lambda given=given: impacts_in_space(given), len(given)),
            "solve_impact": _least(lambda W=W, g=given: _one_by_one(W[:500], g[:500]), 500),
        }
    return lines


def test_impact_in_space_takes_microseconds():
    lines = measure()
    print(json.dumps(lines, indent=2))
    assert max(times["compiled"] for times in lines.values()) < LIMIT


if __name__ == "__main__":
    print(json.dumps(measure(), indent=2))
