"""The paper on the package: its example, its citations and its length."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import yaml

from painleve_sym.references import references

ROOT = Path(__file__).parents[1]
PAPER = ROOT / "paper" / "paper.md"
HEADER, TEXT = PAPER.read_text("utf-8").removeprefix("---\n").split("\n---\n", 1)


def test_example_prints_the_shown_output():
    code, shown = re.search(r"```python\n(.*?)```\s+```\n(.*?)```", TEXT, re.S).groups()
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    options = {"capture_output": True, "text": True, "timeout": 300, "env": environment}
    answer = subprocess.run([sys.executable, "-c", code], **options)
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout == shown


def test_citations_are_entries_of_the_bibliography():
    bibliography = (PAPER.parent / yaml.safe_load(HEADER)["bibliography"]).resolve()
    assert bibliography == ROOT / "docs" / "references.bib"
    keys = set(re.findall(r"@(\w+)", TEXT))
    assert len(keys) > 20
    assert keys <= set(references())
    # Their authors are cited by name, so that these must be certain.
    assert not any(references()[key].cited_by_title for key in keys)


def test_length_is_that_of_a_software_paper():
    words = re.sub(r"```.*?```", "", TEXT, flags=re.S).split()
    assert 750 <= len(words) <= 1750
    for title in ("Summary", "Statement of need", "State of the field", "Example", "References"):
        assert f"\n# {title}\n" in TEXT
