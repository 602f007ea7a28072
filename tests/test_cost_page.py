"""The page on costs has the tables of the kept numbers."""

import json

from tests.benchmarks import cost_page
from tools.tables import written


def test_tables_are_those_of_the_kept_numbers():
    page, numbers = cost_page.PAGE.read_text("utf-8"), json.loads(cost_page.NUMBERS.read_text())
    assert written(page, cost_page.tables(numbers)) == page


def test_measured_problems_have_solutions():
    assert len(cost_page.feet(2).solutions()) == 1
    assert cost_page.sliding(5).solve_lemke().solution is not None
