"""The examples of docs/complementarity.md print what they say."""

import doctest
from pathlib import Path


def test_examples_of_the_page_print_what_they_say():
    page = Path(__file__).parents[3] / "docs" / "complementarity.md"
    result = doctest.testfile(str(page), module_relative=False)
    assert result.attempted >= 12 and result.failed == 0
