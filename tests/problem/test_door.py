"""`painleve_sym.problem` is a door of its own: contact problems by numbers, with few libraries."""

from __future__ import annotations

import subprocess
import sys

from painleve_sym.doors import listed

CODE = """
import sys
from painleve_sym.problem import ContactProblem
[solution] = ContactProblem([[4.0, 1.0], [1.0, 2.0]], [-9.8, 0.0], [0.5], [-1.0]).solutions()
heavy = {"sympy", "casadi", "matplotlib"}
print(round(solution.normal_force, 6), *sorted(heavy & set(sys.modules)))
"""


def test_a_contact_problem_needs_neither_sympy_nor_casadi():
    result = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True)
    assert result.stdout == "2.177778\n", result.stderr


def test_the_door_has_the_names_of_contact_problems():
    homes = {*listed("painleve_sym.problem").values()}
    elsewhere = {home for home in homes if not home.startswith("painleve_sym.problem.")}
    assert elsewhere == {"painleve_sym.mechanics.impact.impact_class"}
