"""Printed formulas as expressions, and equality of expressions."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.mechanics.toml.expressions import Formulas


def expression(text: str, names: Mapping[str, sp.Expr]) -> sp.Expr:
    """Return the expression of a formula written as text; the text is parsed, never executed.

    InputError where it is not a formula, or uses a name that is not given.
    """
    expr, faults = Formulas(dict(names)).read(text)
    if expr is None:
        raise InputError(f"formula {text!r}: {' '.join(fault.message for fault in faults)}")
    return expr


def identical(left: sp.Expr, right: sp.Expr) -> bool:
    """Return whether two expressions are equal for all values of their symbols.

    Sines, cosines and tangents become rational functions of the half angle's tangent, where
    equality is decided exactly; SymPy simplifies the rest. Square roots are compared by their
    squares and their sign at one point.
    """
    if _vanishes(left - right):
        return True
    if not any(p.exp == sp.Rational(1, 2) for p in (left - right).atoms(sp.Pow)):
        return False
    symbols = sorted((left - right).free_symbols, key=str)
    point = {s: sp.Rational(2 + i, 3) for i, s in enumerate(symbols)}
    same_sign = abs(sp.N((left - right).subs(point), 30)) < sp.Float("1e-20")
    return bool(same_sign) and _vanishes(sp.expand(left**2) - sp.expand(right**2))


def _vanishes(difference: sp.Expr) -> bool:
    difference = sp.expand_trig(sp.expand_power_base(difference, force=True))
    half_angle: dict[sp.Expr, sp.Expr] = {}
    for angle in {a.args[0] for a in difference.atoms(sp.sin, sp.cos, sp.tan)}:
        u = sp.Dummy("u", real=True)
        half_angle[sp.sin(angle)] = 2 * u / (1 + u**2)
        half_angle[sp.cos(angle)] = (1 - u**2) / (1 + u**2)
        half_angle[sp.tan(angle)] = 2 * u / (1 - u**2)
    whole = sp.together(difference.subs(half_angle))
    numerator = sp.expand(sp.fraction(whole)[0])
    if numerator == 0 or (numerator.is_polynomial() and not numerator.has(sp.Float)):
        return bool(numerator == 0)
    return bool(sp.simplify(whole) == 0)
