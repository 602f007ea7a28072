"""Whether an expression is 0 for all values of its symbols."""

from __future__ import annotations

import sympy as sp


def vanishes(expr: sp.Expr) -> bool:
    """Return whether it is 0: by its numerator modulo sin² + cos² = 1, else by SymPy's simplify."""
    numerator = sp.expand(sp.fraction(sp.together(expr))[0])
    for sine in numerator.atoms(sp.sin):
        square = 1 - sp.cos(*sine.args) ** 2
        powers = [p for p in numerator.atoms(sp.Pow) if p.base == sine and p.exp.is_Integer]
        swaps = {p: square ** (p.exp // 2) * sine ** (p.exp % 2) for p in powers}
        numerator = sp.expand(numerator.xreplace(swaps))
    return numerator == 0 or bool(sp.simplify(expr) == 0)
