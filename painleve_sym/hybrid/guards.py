"""The least and the greatest of several formulas, without comparing them."""

from __future__ import annotations

import sympy as sp


def least(*margins: sp.Expr) -> sp.Expr:
    """Return the least of `margins`: positive where every one is.

    Unevaluated: to find out which of two long formulas is smaller takes SymPy seconds to minutes,
    and it rarely finds out.
    """
    return sp.Min(*_parts(sp.Min, margins), evaluate=False)


def greatest(*margins: sp.Expr) -> sp.Expr:
    """Return the greatest of `margins`, unevaluated: positive where any one is."""
    return sp.Max(*_parts(sp.Max, margins), evaluate=False)


def _parts(kind: type[sp.Expr], margins: tuple[sp.Expr, ...]) -> list[sp.Expr]:
    """Return the arguments with nested extremes of the same kind opened."""
    return [part for m in margins for part in (m.args if isinstance(m, kind) else (m,))]
