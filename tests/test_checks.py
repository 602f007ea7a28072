"""Checks of numbers: what is a finite number in range, and what messages say."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from painleve_sym.checks import LARGEST, checked_number, checked_values, number, whole_number
from painleve_sym.errors import MAX_FAULTS, InputError


@given(st.floats(), st.floats(-1e120, 1e120), st.floats(0, 1e120))
def test_number_is_accepted_exactly_in_its_range(value, lower, width):
    result, fault = checked_number(value, "x", lower=lower, upper=lower + width)
    inside = abs(value) <= LARGEST and lower <= value <= lower + width
    assert (fault == "") == inside
    if inside:
        assert result == value


@pytest.mark.parametrize("value", ["1", b"1", True, None, [1.0], 1j, object()])
def test_what_is_not_a_number_is_refused(value):
    with pytest.raises(InputError, match=r"case: x: got .*, need a number\."):
        number(value, "x", where="case")


@pytest.mark.parametrize(
    ("value", "bounds", "text"),
    [
        (math.nan, {}, "x: got nan, need a finite number."),
        (np.float64(-math.inf), {}, "x: got -inf, need a finite number."),
        (10**400, {}, "need a finite number."),
        (0.0, {"above": 0.0}, "x: got 0.0, need a finite number > 0."),
        (-1e101, {}, "x: got -1e+101, need a finite number, of at most 1e+100 in size."),
        (2, {"lower": 0, "below": 1}, "x: got 2, need a finite number >= 0 and < 1."),
    ],
)
def test_message_names_the_value_and_the_range(value, bounds, text):
    assert checked_number(value, "x", **bounds)[1].endswith(text)


@pytest.mark.parametrize("value", [0, 4, 1.0, True, "2", None])
def test_whole_number_outside_its_range_or_of_another_type_is_refused(value):
    with pytest.raises(InputError, match=r"case: n: got .*, need a whole number from 1 to 3"):
        whole_number(value, "n", where="case", lower=1, upper=3)


def test_whole_number_in_range_is_returned():
    assert whole_number(3, "n", where="case", lower=1, upper=3) == 3


def test_of_many_unknown_names_the_first_are_compared_and_the_rest_is_not(monkeypatch):
    compared = []

    def unknown(kind, name, known):
        compared.append(name)
        return f"unknown {kind} {name!r}."

    monkeypatch.setattr("painleve_sym.checks.unknown_name", unknown)
    given_values = {f"x{i}": 1.0 for i in range(10 * MAX_FAULTS)}
    with pytest.raises(InputError, match=r"x0.*What follows was not checked"):
        checked_values("place", "state", given_values, {"theta": 0.0}, lambda name: "rad")
    assert compared == list(given_values)[:MAX_FAULTS]
