"""Each explanation page says first which of its results need which assumption."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

import painleve_sym as ps
from painleve_sym.mechanics.bars import bending_modes

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGE = (DOCS / "assumptions.md").read_text("utf-8")
EXPLANATIONS = (
    "bilateral.md",
    "complementarity.md",
    "contact-solvers.md",
    "contrast.md",
    "corrected-jump.md",
    "critical-force.md",
    "derivations/README.md",
    "experiments.md",
    "friction-laws.md",
    "impacts-in-space.md",
    "impacts.md",
    "maps.md",
    "paradox-in-space.md",
    "reverse-chatter.md",
    "rigid-rod.md",
    "sensitivities.md",
    "several-contacts.md",
    "singular-point.md",
    "tangential-compliance.md",
)


def rows(text):
    """Return the cells of the first table of a text, without the line of dashes."""
    lines = re.search(r"(?m)(?:^\|.*\n)+", text).group().splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return [cells[0], *cells[2:]]


ASSUMPTIONS = [row[0] for row in rows(PAGE)[1:]]


@pytest.mark.parametrize("name", EXPLANATIONS)
def test_page_opens_with_a_table_of_assumptions(name):
    text = (DOCS / name).read_text("utf-8")
    heading, section = re.search(r"(?ms)^## ([^\n]*)\n(.*?)(?=^## |\Z)", text).groups()
    assert heading == "Assumptions"
    assert "Every result needs the seven [assumptions]" in section and "assumptions.md" in section
    head, *results = rows(section)
    assert head in (["result", "does not need"], ["result", "does not need", "needs in part"])
    assert results and len({row[0] for row in results}) == len(results)
    for row in results:
        named = [name for cell in row[1:] if cell != "–" for name in cell.split(", ")]
        assert len(row) == len(head) and len(set(named)) == len(named), row[0]
        assert set(named) <= set(ASSUMPTIONS), row[0]


def test_every_page_of_theory_is_an_explanation():
    sections = [DOCS / "theory.md", *(DOCS / "theory").glob("*.md")]
    listed = "\n".join(path.read_text("utf-8") for path in sections)
    pages = {f"{name}.md" for name in re.findall(r"^(?:\.\./)?([\w-]+)$", listed, re.M)}
    others = {"assumptions.md", "reproduction.md", "derivations.md", "peers.md", "engine.md"}
    assert pages - others - {"numerics.md", "cost.md"} <= set(EXPLANATIONS)
    assert "assumptions.md" in pages


def test_a_steel_rod_of_that_mass_bends_in_the_impact():
    mass, length, density, modulus = 1.0, 2.0, 7850.0, 209e9
    area = mass / (density * length)
    diameter = math.sqrt(4 * area / math.pi)
    bending = modulus * math.pi * diameter**4 / 64
    # First root of cos(x) cosh(x) = 1: a free–free beam.
    root = 4.730040744862704
    assert math.cos(root) * math.cosh(root) == pytest.approx(1, abs=1e-9)
    (mode,) = bending_modes(("free", "free"), 1)
    assert float(mode.wavenumber) == pytest.approx(root, rel=1e-14)
    rate = root**2 / length**2 * math.sqrt(bending / (density * area))
    period = 2 * math.pi / rate
    state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    law = ps.law("bilinear-hertz")
    run = ps.simulate(ps.model("rod"), law, state, t_end=0.1, parameters={"E": modulus, "n": 1.5})
    contact = next(e.time for e in run.events if e.kind == "separation")
    printed = (f"{1e3 * diameter:.1f} mm", f"{period:.3f} s", f"{1e3 * contact:.2f} ms")
    assert all(text in PAGE.replace("\n", " ") for text in printed), printed
    assert f"The period is {period / contact:.0f} times as long" in PAGE
