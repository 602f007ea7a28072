"""Headline results at real materials: the page has the computed numbers."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from painleve_sym.mechanics.materials import materials
from painleve_sym.papers.impact_resolution.physical import (
    compute_physical,
    compute_physical_force,
    compute_physical_friction,
)
from painleve_sym.papers.impact_resolution.runs import Workbench

PAGE = (Path(__file__).parents[2] / "docs" / "reproduction.md").read_text("utf-8")


def _seconds(text):
    value, unit = text.split()
    return float(value) * {"ms": 1e-3, "s": 1.0}[unit]


def test_page_has_the_computed_rebounds_durations_and_forces():
    outcome = compute_physical(Workbench())
    force = compute_physical_force(Workbench())
    assert all((outcome.data["checks"] | force.data["checks"]).values())
    forces = {row[0]: row[1:] for row in force.data["table"]["rows"]}
    table = {row[0]: row[1:] for row in outcome.data["table"]["rows"]}
    section = PAGE.partition("## Physical values")[2].partition("\n## ")[0]
    rows = {
        cells[0].split(",")[0]: cells[1:]
        for line in re.findall(r"^\| (.*) \|$", section, re.M)
        if len(cells := [c.strip() for c in line.split("|")]) == 9
    }
    for name in ("stiff", *materials()):
        _, compliant, classical, frozen, carried, stop, contact, period = table[name]
        row = rows["paper" if name == "stiff" else name]
        assert row[:4] == [f"{v:.4f}" for v in (compliant, classical, frozen, carried)]
        assert _seconds(row[4]) == pytest.approx(stop, rel=0.02)
        assert _seconds(row[5]) == pytest.approx(contact, rel=0.02)
        if period is not None:
            assert _seconds(row[6]) == pytest.approx(period, rel=0.02)
        assert row[7] == f"{forces[name][1]:.1f} N"
    low = [100 - 100 * table[name][2] / table[name][1] for name in ("steel", "rubber")]
    assert f"is {low[0]:.0f} % (steel) to {low[1]:.0f} % (rubber) too low" in section
    limit = force.data["F_n*"]
    assert f"F_n* = −B/A = {limit:.1f} N" in section
    ratios = [limit / forces[name][1] for name in ("steel", "rubber")]
    assert f"{ratios[0]:.1f} times that of\nsteel and {ratios[1]:.0f} times" in section


def test_thresholds_of_the_page_are_those_of_the_mobilities():
    outcome = compute_physical_friction(Workbench())
    assert all(outcome.data["checks"].values())
    section = PAGE.partition("## Physical values")[2].partition("\n## ")[0]
    sin, cos = math.sin(1.0), math.cos(1.0)
    assert f"μ > {(1 + 3 * cos**2) / (3 * sin * cos):.4f} at θ = 1 rad" in section
    rows = outcome.data["table"]["rows"]
    assert len(rows) == 7 and len({row[0] for row in rows}) == 7
    assert [row[0] for row in rows if row[3]] == ["aluminium, aluminium"]
