"""The table of distances between both borders in docs/critical-force.md, computed again."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.critical.bisection import Border, CriticalForceFinder
from tests.support.paper_law import paper_law

PAGE = (Path(__file__).parents[2] / "docs" / "critical-force.md").read_text("utf-8")
TABLE_4 = {"x_A_dot": -1.0, "theta": 1.0, "theta_dot": 5.0}
ROWS = [
    [float(cell) for cell in match]
    for match in re.findall(
        r"(?m)^\| (20\.9e\d+) \| ([\d.e-]+) \| ([\d.e-]+) \| (0\.\d+) \|$", PAGE
    )
]


def test_the_table_has_three_moduli():
    assert [row[0] for row in ROWS] == [20.9e14, 20.9e15, 20.9e16]


@pytest.mark.parametrize("row", ROWS, ids=str)
def test_borders_are_apart_as_the_page_says(row):
    E, distance, estimate, ratio = row
    simulator = Simulator(model("rod"), paper_law(reload="virgin"))
    finder = CriticalForceFinder(simulator)
    below, above = (
        finder.find(TABLE_4, {"E": E}, border=border, check_tolerance=False)
        for border in (Border.SLIP_STOP, Border.COMPRESSION)
    )
    run = simulator.run(
        TABLE_4,
        parameters={"E": E},
        initial_force=above.value,
        t_end=1.0,
        until=("separation", "slip_stop"),
        rtol=1e-13,
    )
    # Right before the stop: behind it nothing slides.
    times = np.linspace(0.0, run.final_time * (1 - 1e-9), 201)
    rates = []
    for time in times:
        at = run.state(float(time))
        there = {name: at[name] for name in simulator.mechanism.state_names}
        rates.append(finder.analysis.along(there, {"E": E}).growth_rate)
    growth = float(np.trapezoid(rates, times))
    expected = below.sliding.force * math.exp(-growth)
    assert above.value - below.value == pytest.approx(distance, rel=5e-3)
    assert expected == pytest.approx(estimate, rel=5e-3)
    assert distance / estimate == pytest.approx(ratio, abs=6e-3)
