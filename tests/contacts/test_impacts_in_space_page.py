"""The examples of docs/impacts-in-space.md print what they say."""

import doctest
import re
from pathlib import Path

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
