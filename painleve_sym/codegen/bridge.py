"""Translation of SymPy expressions to CasADi SX by one table of operators."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi as ca
import sympy as sp
from sympy.logic.boolalg import Boolean, BooleanAtom

from painleve_sym.errors import TranslationError
from painleve_sym.laws.compliance import ramp
from painleve_sym.mechanics.pulses import pulse

POWER_FLOOR = 1e-60
"""Base of a real power at and below zero, where the power is 0: its derivatives are not nan."""

_UNARY: dict[type[sp.Basic], Callable[[Any], Any]] = {
    sp.sin: ca.sin,
    sp.cos: ca.cos,
    sp.tan: ca.tan,
    sp.asin: ca.asin,
    sp.acos: ca.acos,
    sp.atan: ca.atan,
    sp.sinh: ca.sinh,
    sp.cosh: ca.cosh,
    sp.tanh: ca.tanh,
    sp.exp: ca.exp,
    sp.log: ca.log,
    sp.Abs: ca.fabs,
    sp.sign: ca.sign,
    sp.floor: ca.floor,
}

_CONDITIONS: dict[type[sp.Basic], Callable[[Any, Any], Any]] = {
    sp.And: ca.logic_and,
    sp.Or: ca.logic_or,
    sp.Gt: ca.gt,
    sp.Ge: ca.ge,
    sp.Lt: ca.lt,
    sp.Le: ca.le,
    sp.Eq: ca.eq,
    sp.Ne: ca.ne,
}


class Translator:
    """Translates expressions over one table of symbols, sharing common subexpressions.

    The table has every symbol that an expression may contain. `floor` is the least value of a ramp:
    POWER_FLOOR where derivatives are taken, 0 for plain values.
    """

    def __init__(self, table: Mapping[sp.Symbol, ca.SX], floor: float = POWER_FLOOR) -> None:
        self._known: dict[sp.Basic, ca.SX] = dict(table)
        self._floor = floor

    def __call__(self, expr: sp.Basic) -> ca.SX:
        """Return the SX scalar equal to `expr`; TranslationError names what has no counterpart."""
        expr = sp.sympify(expr)
        known = self._known.get(expr)
        if known is None:
            known = self._known[expr] = self._translate(expr)
        return known

    def vector(self, exprs: Sequence[sp.Expr]) -> ca.SX:
        """Return the SX column of `exprs`, shape (len(exprs), 1)."""
        return ca.vertcat(*[self(e) for e in exprs]) if exprs else ca.SX(0, 1)

    def _translate(self, expr: sp.Basic) -> ca.SX:
        if isinstance(expr, Boolean) and not expr.is_Symbol:
            return self._condition(expr)
        if expr.is_number:
            if expr.has(sp.nan, sp.zoo) or not expr.is_extended_real:
                raise TranslationError(f"code generation: got {expr}, need finite real values.")
            return ca.SX(float(expr))
        if expr.is_Symbol:
            raise TranslationError(
                f"code generation: symbol {expr} is not a state, memory or parameter. "
                "Fix: declare it."
            )
        if expr.is_Add:
            return self._fold(expr.args, lambda a, b: a + b)
        if expr.is_Mul:
            return self._product(expr)
        if expr.is_Pow:
            return self._power(expr.base, expr.exp)
        if isinstance(expr, sp.Max):
            return self._fold(expr.args, ca.fmax)
        if isinstance(expr, sp.Min):
            return self._fold(expr.args, ca.fmin)
        if isinstance(expr, sp.Piecewise):
            return self._cases(expr)
        if isinstance(expr, sp.atan2):
            return ca.atan2(self(expr.args[0]), self(expr.args[1]))
        if isinstance(expr, sp.Heaviside):
            return ca.if_else(self(expr.args[0]) > 0, 1, 0)
        if isinstance(expr, ramp):
            return ca.fmax(self(expr.args[0]), self._floor)
        if isinstance(expr, pulse):
            return self._pulse(*map(self, expr.args))
        operator = _UNARY.get(expr.func)
        if operator is None:
            raise TranslationError(
                f"code generation: {expr.func.__name__} in {expr} has no CasADi counterpart. "
                f"Fix: use one of {', '.join(sorted(f.__name__ for f in _UNARY))}."
            )
        result: ca.SX = operator(self(expr.args[0]))
        return result

    def _pulse(self, time: Any, start: Any, width: Any = math.inf, period: Any = None) -> ca.SX:
        """Return 1 inside a pulse, 0 outside."""
        since = time - start
        if period is not None:
            since = since - period * ca.floor(since / period)
        value: ca.SX = ca.if_else(ca.logic_and(since >= 0, since < width), 1, 0)
        return value

    def _cases(self, expr: sp.Piecewise) -> ca.SX:
        """Return the value of the first case that holds, nan where none does.

        What the other cases give, nan and inf included, does not matter.
        """
        value = ca.SX(float("nan"))
        for case in reversed(expr.args):
            own = self(case.expr)
            value = own if case.cond == sp.true else ca.if_else(self(case.cond), own, value)
        return value

    def _condition(self, condition: Boolean) -> ca.SX:
        """Return 1 where the condition holds, 0 where it does not, or a number is nan."""
        if isinstance(condition, BooleanAtom):
            return ca.SX(float(bool(condition)))
        operator = _CONDITIONS.get(condition.func)
        if operator is None:
            known = ", ".join(sorted(f.__name__ for f in _CONDITIONS))
            raise TranslationError(
                f"code generation: {condition.func.__name__} in {condition} has no CasADi "
                f"counterpart. Fix: use one of {known}."
            )
        return self._fold(condition.args, operator)

    def _fold(self, args: Sequence[sp.Basic], join: Callable[[Any, Any], Any]) -> ca.SX:
        total = self(args[0])
        for a in args[1:]:
            total = join(total, self(a))
        return total

    def _product(self, expr: sp.Expr) -> ca.SX:
        below = [a for a in expr.args if a.is_Pow and a.exp.is_number and a.exp.is_negative]
        above = [a for a in expr.args if a not in below]
        top = self._fold(above, lambda a, b: a * b) if above else ca.SX(1)
        for factor in below:
            top = top / self(factor.base**-factor.exp)
        return top

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> ca.SX:
        if exponent.is_Integer:
            if exponent < 0:
                return 1 / self._power(base, -exponent)
            half = self._power(base, exponent // 2) if exponent > 1 else None
            if half is None:
                return self(base) if exponent == 1 else ca.SX(1)
            return half * half * self(base) if exponent % 2 else half * half
        if exponent == sp.Rational(1, 2):
            power = ca.sqrt(self(base))
        elif exponent == sp.Rational(-1, 2):
            return 1 / ca.sqrt(self(base))
        else:
            power = self(base) ** self(exponent)
        if self._floor and isinstance(base, ramp):
            # Exactly 0 where the base is: the residue of a floor would decide the signs of guards.
            return ca.if_else(self(base.args[0]) > self._floor, power, 0)
        return power


def python_function(
    arguments: Sequence[Sequence[sp.Symbol]],
    values: Any,
    abbreviations: Sequence[tuple[sp.Symbol, sp.Expr]],
    library: str,
) -> Callable[..., Any]:
    """Return expressions, lists of them or of lists, as a function that SymPy writes.

    Each argument is a sequence; abbreviations are computed in their order before the values.
    """
    known = list(abbreviations)
    function: Callable[..., Any] = sp.lambdify(
        arguments, values, str(library), cse=lambda expressions: (known, expressions)
    )
    return function
