"""The manuscripts: what they cite, what their form needs, and whose numbers they have."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
import yaml

from painleve_sym.references import references

ROOT = Path(__file__).parents[1]
MANUSCRIPTS = sorted((ROOT / "paper").glob("*.md"))


def parts(path):
    """Return the header as data, and the text."""
    header, text = path.read_text("utf-8").removeprefix("---\n").split("\n---\n", 1)
    return yaml.safe_load(header), text


@pytest.mark.parametrize("path", MANUSCRIPTS, ids=lambda path: path.stem)
def test_citations_are_entries_of_the_bibliography_with_certain_authors(path):
    header, text = parts(path)
    assert (path.parent / header["bibliography"]).resolve() == ROOT / "docs" / "references.bib"
    keys = set(re.findall(r"@(\w+)", text))
    assert len(keys) > 10 and keys <= set(references())
    assert not any(references()[key].cited_by_title for key in keys)


@pytest.mark.parametrize("path", MANUSCRIPTS, ids=lambda path: path.stem)
def test_a_manuscript_is_short_and_has_the_parts_of_one(path):
    header, text = parts(path)
    words = re.sub(r"(?m)^\|.*$|```.*?```", "", text, flags=re.S).split()
    assert 600 <= len(words) <= 3500
    headings = re.findall(r"(?m)^# (.+)$", text)
    assert headings[0] == "Abstract" and headings[-1] == "References"
    assert {"Introduction", "Discussion", "Reproduction"} <= set(headings) and header["title"]
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", text)
    assert pictures and all((path.parent / name).is_file() for name in pictures)
    assert re.search(r"(?m)^\| --- ", text), "no table: run make paper"


def test_make_paper_names_what_writes_each_manuscript():
    recipe = subprocess.run(
        ["make", "-n", "paper", "VENV=.venv"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    for path in MANUSCRIPTS:
        assert path.stem.replace("-", "_") in recipe.replace("-", "_"), path.stem
