"""Expressions as plain data, and the cache of searched forms."""

from __future__ import annotations

import json
import time

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from painleve_sym.mechanics import kept_forms, simplify
from painleve_sym.mechanics.kept_forms import (
    _NotPlain,
    _same,
    expression_of_plain,
    expression_to_plain,
    kept,
)

X, Y = sp.Symbol("x", real=True), sp.Symbol("y", positive=True)
SYMBOLS = [X, Y]
ATOMS = [X, Y, sp.Integer(-3), sp.Rational(2, 7), sp.Float("0.1", 20), sp.pi, sp.E]


def combined(parts):
    pairs = st.tuples(parts, parts)
    return st.one_of(
        pairs.map(lambda p: p[0] + p[1]),
        pairs.map(lambda p: sp.Mul(*p, evaluate=False)),
        parts.map(lambda p: 2 * sp.Add(p, Y, evaluate=False)),
        parts.map(lambda p: sp.Pow(p, sp.Rational(3, 2))),
        parts.map(sp.sin),
        parts.map(sp.Abs),
    )


@given(st.recursive(st.sampled_from(ATOMS), combined, max_leaves=8))
def test_plain_form_gives_the_same_expression_back(expr):
    plain = json.loads(json.dumps(expression_to_plain(expr, SYMBOLS)))
    again = expression_of_plain(plain, SYMBOLS)
    assert _same(again, expr) and hash(again) == hash(expr)
    assert sp.srepr(again) == sp.srepr(expr)


@pytest.mark.parametrize("expr", [sp.Dummy("x"), sp.Symbol("z"), sp.gamma(X), sp.oo, X > 0])
def test_what_has_no_plain_form_is_refused(expr):
    with pytest.raises(_NotPlain):
        expression_to_plain(expr, SYMBOLS)


def test_product_of_a_number_and_a_sum_stays_one():
    held = sp.Mul(2, X + Y, evaluate=False)
    assert sp.srepr(expression_of_plain(expression_to_plain(held, SYMBOLS), SYMBOLS)) == sp.srepr(
        held
    )
    assert held != 2 * X + 2 * Y


def never(expr):
    raise AssertionError(f"searched for {expr} again")


def test_a_long_search_is_made_once(cache, monkeypatch):
    monkeypatch.setattr(kept_forms, "LONG", 0)
    form = kept("test", sp.cos(X) ** 2 + Y, lambda expr: expr - 1)
    assert kept("test", sp.cos(X) ** 2 + Y, never) == form
    assert len(list(cache.glob("*.form"))) == 1
    # A symbol of the same name that may be anything is another one, and so is another search.
    other = sp.Symbol("x")
    assert kept("test", sp.cos(other) ** 2 + Y, lambda expr: expr) == sp.cos(other) ** 2 + Y
    assert kept("another test", sp.cos(X) ** 2 + Y, lambda expr: expr) == sp.cos(X) ** 2 + Y


def test_what_is_kept_depends_on_the_expression_and_not_on_the_time_of_its_search(cache):
    def slowly(expr):
        time.sleep(0.05)
        return expr

    kept("test", sp.cos(X) ** 2 + Y, slowly)
    assert not list(cache.glob("*.form"))
    long = sum(sp.cos(k * X) * Y**k for k in range(1, 9))
    assert kept("test", long, lambda expr: expr) == kept("test", long, never)
    assert len(list(cache.glob("*.form"))) == 1


def test_a_form_without_a_name_is_searched_for_each_time(cache, monkeypatch):
    monkeypatch.setattr(kept_forms, "LONG", 0)
    kept("test", X, lambda expr: expr + sp.Dummy("c"))
    kept("test", sp.gamma(X), lambda expr: expr)
    assert not list(cache.glob("*.form"))


def test_readable_forms_are_taken_from_the_cache(cache, monkeypatch):
    expr = (X * sp.cos(X) ** 2 + X * sp.sin(X) ** 2 + Y) / (X + Y)
    monkeypatch.setattr(kept_forms, "LONG", 0)
    simplify._readable.cache_clear()
    first = simplify.readable(expr)
    assert list(cache.glob("*.form"))
    simplify._readable.cache_clear()
    monkeypatch.setattr(simplify, "_written", never)
    assert simplify.readable(expr) == first
    simplify._readable.cache_clear()
