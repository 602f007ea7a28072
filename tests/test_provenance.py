"""Pages of computed numbers: a line says with which version, law, exponent and modes."""

from __future__ import annotations

import json
import re

import pytest

from painleve_sym.version import RELEASE
from tools import provenance
from tools.tables import written

CITATION = (provenance.ROOT / "CITATION.cff").read_text("utf-8")
LAST_RELEASE = re.search(r"^version: (.*)$", CITATION, re.M)[1]
STUDY = re.compile(r"examples/studies/([\w/]+)\.(?:py|png)|tests\.benchmarks\.\w+_page")
COMPARED = {
    "docs/fit.md",
    "docs/how-to/friction-curve.md",
    "docs/how-to/equations-elsewhere.md",
    "docs/how-to/fit.md",
    "docs/how-to/robot.md",
    "docs/impacts-in-space.md",
}
"""Pages whose numbers a test computes again and compares with the page."""


@pytest.mark.parametrize("page", provenance.PAGES)
def test_line_of_a_page_is_that_of_its_kept_numbers(page):
    text = (provenance.ROOT / page).read_text("utf-8")
    assert written(text, {"computed": provenance.line(page)}) == text, (
        "Fix: run python -m tools.provenance."
    )


@pytest.mark.parametrize("page", provenance.PAGES)
def test_numbers_were_computed_with_the_last_release_or_after_it(page):
    for kept in provenance.PAGES[page]:
        programs = provenance.computed(kept)["programs"]
        if kept.name != "cone-dual.json":  # of other programs alone
            assert programs.keys() == {provenance.PACKAGE}
            version = programs[provenance.PACKAGE]
            assert version == LAST_RELEASE or version.startswith(RELEASE), (
                f"{kept}. Fix: run its study again."
            )


def test_every_page_that_names_a_study_has_the_line():
    named = {
        path.relative_to(provenance.ROOT).as_posix()
        for folder in ("docs", "paper")
        for path in (provenance.ROOT / folder).rglob("*.md")
        if not {"_generated", "changes"} & {*path.parts} and STUDY.search(path.read_text("utf-8"))
    }
    assert named - COMPARED <= set(provenance.PAGES) and len(named) > 10


def test_line_says_version_law_exponent_and_modes(monkeypatch, tmp_path):
    monkeypatch.setattr(provenance, "ROOT", tmp_path)
    kept = '{"computed": {"version": "9.9", "law": "hertz", "n": 1.5, "modes": "4,2"}}'
    for path in provenance.PAGES["docs/experiments.md"]:
        (tmp_path / path).parent.mkdir(parents=True)
        (tmp_path / path).write_text(kept, "utf-8")
    assert provenance.line("docs/experiments.md") == (
        "*Computed with:* `bench-rod.json`: painleve-sym 9.9; contact law: hertz (n = 1.5); "
        "modes: 4,2."
    )


def test_table_of_random_impacts_is_the_kept_one():
    page = (provenance.ROOT / "docs" / "impacts.md").read_text("utf-8")
    shown = [
        [cell.strip().lower() for cell in row.strip("|").split("|")]
        for row in re.findall(r"(?m)^\|.*\|$", page)
    ]
    data = json.loads((provenance.ROOT / "docs/figures/impact-energy.json").read_text("utf-8"))
    assert f"impact_energy.py {data['count']} {data['seed']}" in page
    for _, law, gaining, worst, _, unanswered, jams, several, _ in data["rows"]:
        row = next(r for r in shown if len(r) == 7 and r[1:3] == [law, gaining])
        shown.remove(row)
        rounded = f"{float(worst):.2g}".replace("e+0", "e") if float(worst) > 1000 else worst
        assert row[3] == ("–" if gaining == "0" else f"{rounded} %")
        assert row[4:] == [unanswered, "–" if law == "newton" else jams, several]
    sums = {law: 0 for law in ("energetic", "poisson", "newton")}
    for _, law, *_, several, _ in data["rows"]:
        sums[law] += int(several)
    words = (
        "{energetic} of the 12 000 impacts above had several continuations by the energetic law, "
    )
    words += "{poisson} by Poisson's, and {newton} by Newton's"
    assert words.format(**sums) in " ".join(page.split())
    table = (provenance.ROOT / "docs" / "several-contacts.md").read_text("utf-8")
    for law, several in sums.items():
        (row,) = re.findall(rf"(?m)^\| `{law}` \|.*$", table)
        assert row.rpartition("no: ")[2].startswith(f"{several} of 12 000")
