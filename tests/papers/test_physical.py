"""The impact of Table 3 at real materials: the page has the computed numbers."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from painleve_sym.mechanics.materials import materials
from painleve_sym.papers.impact_resolution.physical import compute_physical
from painleve_sym.papers.impact_resolution.runs import Workbench

PAGE = (Path(__file__).parents[2] / "docs" / "reproduction.md").read_text("utf-8")


def _seconds(text):
    value, unit = text.split()
    return float(value) * {"ms": 1e-3, "s": 1.0}[unit]


def test_page_has_the_computed_rebounds_and_durations():
    outcome = compute_physical(Workbench())
    assert all(outcome.data["checks"].values())
    table = {row[0]: row[1:] for row in outcome.data["table"]["rows"]}
    section = PAGE.partition("## Physical values")[2].partition("\n## ")[0]
    rows = {
        cells[0].split(",")[0]: cells[1:]
        for line in re.findall(r"^\| (.*) \|$", section, re.M)
        if len(cells := [c.strip() for c in line.split("|")]) == 7
    }
    for name in ("stiff", *materials()):
        _, compliant, classical, frozen, carried, _, contact, period = table[name]
        row = rows["paper" if name == "stiff" else name]
        assert row[:4] == [f"{v:.4f}" for v in (compliant, classical, frozen, carried)]
        assert _seconds(row[4]) == pytest.approx(contact, rel=0.02)
        if period is not None:
            assert _seconds(row[5]) == pytest.approx(period, rel=0.02)
