"""MathML of formulas, and the marks on parts that differ."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from painleve_sym import model
from painleve_sym.mechanics.mathml import mathml, symbol_mathml, with_marks

a, b, c = sp.symbols("a b c", positive=True)


def _parsed(text: str) -> ET.Element:
    return ET.fromstring(text.replace("&InvisibleTimes;", "\u2062"))


def _words(text: str) -> str:
    return "".join(_parsed(text).itertext()).replace("\u2062", " ")


def test_velocity_has_a_dot_over_its_letter():
    node = _parsed(mathml(sp.Symbol("x_A_dot")))
    (below,) = node.iter("msub")
    assert [child.tag for child in below] == ["mover", "mi"]
    assert _words(mathml(sp.Symbol("x_A_dot"))) == "x˙A"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("theta", "θ"),
        ("theta_ddot", "θ¨"),
        ("y_A_dot_1", "y˙A(t1)"),
        ("R_star", "R*"),
        ("delta_max", "δmax"),
        ("mu_A", "μA"),
        ("l", "l"),
        ("theta_1_dot", "θ˙1"),
    ],
)
def test_names_of_symbols(name, words):
    assert _words(mathml(sp.Symbol(name))) == words


def test_equation_has_its_left_side():
    assert _words(mathml(a + 1, "theta_dot")) == "θ˙=a+1"


def test_functions_stand_apart_and_have_brackets_only_where_needed():
    theta, x = sp.symbols("theta x")
    assert _words(mathml(a * sp.sin(theta))) == "a sin\u2061θ"
    assert len(list(_parsed(mathml(a * sp.sin(theta))).iter("mspace"))) == 2
    assert _words(mathml(sp.sin(theta + x))) == "sin\u2061(θ+x)"
    square = _parsed(mathml(sp.cos(theta) ** 2))
    (power,) = square.iter("msup")
    assert "".join(power.itertext()) == "cos2"
    assert _words(mathml(-a)) == "\u2212a"


def test_exponent_of_a_dotted_letter_stands_as_low_as_others():
    (power,) = _parsed(mathml(sp.Symbol("theta_dot") ** 2)).iter("msup")
    assert power[0].tag == "mpadded" and power[0].get("height").endswith("em")


def test_symbol_within_a_line():
    assert _words(symbol_mathml("x_A_dot")) == "x˙A"
    assert "display" not in symbol_mathml("x_A_dot")


def test_matrix_is_a_table():
    text = mathml(model("rod").system.mass_matrix)
    assert len(list(_parsed(text).iter("mtr"))) == 3


@pytest.mark.parametrize(
    ("printed", "correct", "parts"),
    [
        (a * b / (4 * c), a * b / 4, [c]),
        (2 / a + 2 / b, 1 / a + 1 / b, [2, 2]),
        (a + b, a - b, [b]),
        (sp.sin(a) * b, sp.cos(a) * b, [sp.sin(a)]),
        (a**2 + b, a**3 + b, [2]),
        (a + b + c, a + b, [c]),
        (a * sp.sin(b + c), a * sp.sin(b + 2 * c), [c]),
    ],
)
def test_marks_are_at_the_symbol(printed, correct, parts):
    marked, marks = with_marks(printed, correct)
    assert sorted(map(str, (part for _, part in marks))) == sorted(map(str, parts))
    assert marked.subs(dict(marks)) == printed
    text = mathml(marked, marked=marks)
    assert text.count('class="misprint"') == len(parts)
    assert "mark" not in _words(text)


def test_equal_formulas_have_no_mark():
    assert with_marks(a + b * c, a + b * c) == (a + b * c, ())


_LEAF = st.sampled_from([a, b, c, sp.Integer(2), sp.Rational(1, 3)])
_FORMULA = st.recursive(
    _LEAF,
    lambda inner: (
        st.builds(lambda f, x, y: f(x, y), st.sampled_from([sp.Add, sp.Mul]), inner, inner)
        | st.builds(sp.sin, inner)
    ),
    max_leaves=6,
)


@given(_FORMULA, _FORMULA)
def test_marked_parts_put_back_give_the_printed_formula(printed, correct):
    marked, marks = with_marks(printed, correct)
    assert sp.expand(marked.subs(dict(marks)) - printed) == 0
    assert bool(marks) == (printed != correct)
    assert re.fullmatch(r"<math .*</math>", mathml(marked, marked=marks), re.DOTALL)
