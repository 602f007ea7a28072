"""Extremes of formulas are left as they are, and opened where they are nested."""

from __future__ import annotations

import sympy as sp

from painleve_sym.automata.automaton import greatest, least

X, Y, Z = sp.symbols("x y z", real=True)


def test_nested_extremes_of_one_kind_are_one():
    assert set(least(X, least(Y, Z)).args) == {X, Y, Z}
    assert set(greatest(greatest(X, Y), Z).args) == {X, Y, Z}
    assert set(least(X, greatest(Y, Z)).args) == {X, sp.Max(Y, Z)}


def test_one_formula_alone_or_twice_is_itself():
    assert least(X) == least(X, X) == greatest(X, X) == X


def test_values_are_those_of_numbers():
    for at in ((1, 2, 3), (3, 1, 2), (-1, -1, 0)):
        point = dict(zip((X, Y, Z), map(sp.Integer, at), strict=True))
        assert least(X, Y + 1, Z).xreplace(point) == min(at[0], at[1] + 1, at[2])
        assert greatest(X, Y + 1, Z).xreplace(point) == max(at[0], at[1] + 1, at[2])


def test_provable_order_is_not_searched_for():
    assert set(least(X, X + 1).args) == {X, X + 1}
