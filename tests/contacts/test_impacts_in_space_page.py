"""The examples of docs/impacts-in-space.md print what they say."""

import doctest
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "impacts-in-space.md"


def test_examples_of_the_page_print_what_they_say():
    result = doctest.testfile(str(PAGE), module_relative=False)
    assert result.attempted >= 8 and result.failed == 0


def test_planar_page_says_which_theorem_is_planar():
    planar = (ROOT / "docs" / "impacts.md").read_text("utf-8")
    section = re.search(r"(?s)## In the paradox an impact ends sticking.*?\n## ", planar).group()
    assert "theorem of the plane" in section and "impacts-in-space.md" in section
    row = next(line for line in PAGE.read_text("utf-8").splitlines() if "planar only" in line)
    assert "in the paradox an impact ends sticking" in row


@pytest.mark.slow
def test_page_has_the_shares_that_the_study_prints(tmp_path):
    script = ROOT / "examples" / "studies" / "impact_in_space.py"
    command = (sys.executable, str(script), "1000", str(tmp_path / "hodographs"))
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    sticks, again, slides = (
        re.search(rf"{name} +([\d.]+) %", printed).group(1)
        for name in ("sticks", "slips again", "slides")
    )
    page = " ".join(PAGE.read_text("utf-8").split())
    assert f"{sticks} % end sticking, in {slides} % the slip turns out" in page
    assert f"in {again} % it stops in the sector and begins again" in page
