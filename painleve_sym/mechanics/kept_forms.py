"""Expressions as plain data: the result of a long search is taken from the cache the next time."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import sympy as sp

from painleve_sym.cache import FORM, entry_name, read_entry, write_entry

LONG = 150
"""Length of the text of an expression from which a search takes about 5 ms, and is kept."""
_OPERATIONS = (sp.Add, sp.Mul, sp.Pow)
_FUNCTIONS = (
    *(sp.sin, sp.cos, sp.tan, sp.sinh, sp.cosh, sp.tanh),
    *(sp.exp, sp.log, sp.Abs, sp.sign),
)
_HEADS = {head.__name__: head for head in (*_OPERATIONS, *_FUNCTIONS)}
_CONSTANTS: dict[str, sp.Expr] = {"pi": sp.pi, "E": sp.E, "I": sp.I}
_NAMES = {constant: name for name, constant in _CONSTANTS.items()}
# Their names differ from run to run.
_NAMELESS = (sp.Dummy, sp.Wild)


class _NotPlain(Exception):
    """An expression has a part without a plain form."""


def kept(title: str, expr: sp.Expr, search: Callable[[sp.Expr], sp.Expr]) -> sp.Expr:
    """Return `search(expr)`, from the cache where it was searched for before.

    Whether the result is kept depends on the expression, and not on the time of the search.

    What the cache gives is the same expression, argument by argument. The title says what the
    search is; it depends on the expression and on the code of the package alone. Expressions of
    other functions than those of mechanics are searched for each time.
    """
    symbols = sorted(expr.free_symbols, key=str)
    try:
        plain = expression_to_plain(expr, symbols)
    except _NotPlain:
        return search(expr)
    named = [[s.name, sorted(s.assumptions0.items())] for s in symbols]
    text = json.dumps(plain)
    if len(text) < LONG:
        return search(expr)
    key = entry_name(title, json.dumps([named, text]), by=("mechanics",))
    entry = read_entry(key, FORM)
    if entry is not None:
        return expression_of_plain(entry["form"], symbols)
    form = search(expr)
    try:
        written = expression_to_plain(form, symbols)
    except _NotPlain:
        return form
    if _same(expression_of_plain(written, symbols), form):
        write_entry(key, {"form": written}, FORM)
    return form


def expression_to_plain(expr: sp.Basic, symbols: list[sp.Symbol]) -> Any:
    """Return an expression as lists, texts and integers; its symbols are numbers of the list.

    Raises
    ------
    _NotPlain
        Another symbol, a symbol without a name of its own, or another function.
    """
    if isinstance(expr, sp.Symbol):
        if isinstance(expr, _NAMELESS) or expr not in symbols:
            raise _NotPlain
        return symbols.index(expr)
    if isinstance(expr, sp.Rational):
        return ["Rational", int(expr.p), int(expr.q)]
    if isinstance(expr, sp.Float):
        sign, mantissa, exponent, bits = expr._mpf_
        return ["Float", int(sign), hex(mantissa), int(exponent), int(bits), int(expr._prec)]
    name = type(expr).__name__
    if _HEADS.get(name) is type(expr):
        return [name, *(expression_to_plain(arg, symbols) for arg in expr.args)]
    if expr in _NAMES:
        return _NAMES[expr]
    raise _NotPlain


def expression_of_plain(plain: Any, symbols: list[sp.Symbol]) -> sp.Expr:
    """Return the expression of plain data, argument by argument; nothing in it is evaluated."""
    if isinstance(plain, int):
        return symbols[plain]
    if isinstance(plain, str):
        return _CONSTANTS[plain]
    name, *parts = plain
    if name == "Rational":
        return sp.Rational(*parts)
    if name == "Float":
        sign, mantissa, exponent, bits, precision = parts
        number = sign, int(mantissa, 16), exponent, bits
        return sp.Float(number, precision=precision)
    return _HEADS[name](*(expression_of_plain(part, symbols) for part in parts), evaluate=False)


def _same(first: sp.Basic, second: sp.Basic) -> bool:
    """Return whether two expressions are the same with their arguments in the same order."""
    return (
        first == second
        and len(first.args) == len(second.args)
        and all(map(_same, first.args, second.args))
    )
