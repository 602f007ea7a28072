"""Tolerances that the loop in C and the formulas of a run have, against those of the law."""

from __future__ import annotations

import re

import pytest

from painleve_sym.automata.impact_rays import RATE_ROUNDING
from painleve_sym.engines.c_texts import engine_texts
from painleve_sym.problem import law, rounding
from painleve_sym.problem.complementarity.lcp import RESIDUAL_TOLERANCE

IN_C = {
    "PS_RESIDUAL": RESIDUAL_TOLERANCE,
    "PS_NOISE": rounding.SOLVED,
    "PS_DIFFERENCE_ROUNDING": rounding.SUM,
    "PS_SUM_ROUNDING": law.ROUNDING,
    "PS_RATE_ROUNDING": law.SIGN,
    "PS_REST_SPEED": rounding.MOVED,
    "PS_DISTINCT": law.EQUAL,
    "PS_SAME_MOTION": law.EQUAL,
    "PS_ZERO_TERMS": law.SIGN,
    "PS_ZERO_SLOPE": law.ZERO,
}
"""Constants of the loop by what each is in the law."""


@pytest.fixture(scope="module")
def constants():
    """Return the constants of the loop by name."""
    text = "\n".join(engine_texts("loop/linear", "loop/problem", "loop/impulse", "loop/choose"))
    lists = re.findall(r"static const double ([^;]*);", text)
    return dict(re.findall(r"(PS_\w+) = ([-\d.e]+)", ", ".join(lists)))


@pytest.mark.parametrize("name", IN_C)
def test_tolerance_in_c_is_that_of_the_law(constants, name):
    assert float(constants[name]) == IN_C[name]


def test_tolerance_of_a_formula_is_that_of_the_law():
    assert float(RATE_ROUNDING) == law.SIGN
