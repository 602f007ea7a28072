"""`painleve_sym.problem` is a door of its own: contact problems by numbers, with few libraries."""

from __future__ import annotations

import subprocess
import sys

from painleve_sym.doors import listed

CODE = """
import sys
from painleve_sym.problem import ContactProblem, solve_impact
[solution] = ContactProblem([[4.0, 1.0], [1.0, 2.0]], [-9.8, 0.0], [0.5], [-1.0]).solutions()
impact = solve_impact([[2.0, 0.0], [0.0, 1.0]], 0.3, (-1.0, 0.5), "newton", 0.5)
W = [[2.0, 0.3, 0.4], [0.3, 1.0, 0.2], [0.4, 0.2, 3.0]]
in_space = solve_impact(W, 0.5, (-1.0, 0.1, -0.2), "energetic", 0.5)
heavy = {"sympy", "casadi", "matplotlib"}
loaded = sorted(heavy & set(sys.modules))
print(round(solution.normal_force, 6), impact.case.value, len(in_space.phases), *loaded)
"""


def test_contact_problems_and_impacts_need_neither_sympy_nor_casadi():
    result = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True)
    assert result.stdout == "2.177778 sliding 3\n", result.stderr


def test_the_door_has_the_names_of_contact_problems():
    homes = {*listed("painleve_sym.problem").values()}
    elsewhere = {home for home in homes if not home.startswith("painleve_sym.problem.")}
    assert elsewhere == {"painleve_sym.mechanics.impact.impact_class"}
