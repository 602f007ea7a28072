"""The examples of docs/paradox-in-space.md print what they say; its formulas hold."""

import doctest
from pathlib import Path

import sympy as sp

ROOT = Path(__file__).parents[2]


def test_examples_of_the_page_print_what_they_say():
    page = ROOT / "docs" / "paradox-in-space.md"
    result = doctest.testfile(str(page), module_relative=False)
    assert result.attempted >= 9 and result.failed == 0


def test_third_derivative_of_the_proof():
    s, p1, p2, c1, c2 = sp.symbols("s p_1 p_2 c_1 c_2", positive=True)
    q = sp.expand(c1**2 * (p2 + s) ** 2 + c2**2 * (p1 + s) ** 2)
    alpha, beta, gamma = q.coeff(s, 2), q.coeff(s, 1) / 2, q.coeff(s, 0)
    assert sp.expand(alpha * gamma - beta**2 - c1**2 * c2**2 * (p1 - p2) ** 2) == 0
    third = sp.diff(s * sp.sqrt(q), s, 3) * q ** sp.Rational(5, 2)
    assert sp.simplify(third - 3 * (alpha * gamma - beta**2) * (beta * s + gamma)) == 0
