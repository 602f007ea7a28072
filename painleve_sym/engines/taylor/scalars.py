"""Constants of a mode: numbers and monomials in parameters, memory, resting states."""

from __future__ import annotations

import math
from typing import NamedTuple

import casadi as ca

Factors = tuple[tuple[str, int], ...]


# A tuple: tapes are made of thousands of them, which are compared and hashed over and over.
class Scalar(NamedTuple):
    """A number times whole powers of expressions, by their keys in `Scalars`, sorted."""

    number: float
    factors: Factors = ()

    @property
    def is_zero(self) -> bool:
        """Whether it is the number 0."""
        return self.number == 0

    def __mul__(self, other: Scalar) -> Scalar:  # type: ignore[override]
        """Return the product."""
        number = self.number * other.number
        return Scalar(number, _together(self.factors, other.factors) if number else ())

    def inverse(self) -> Scalar:
        """Return 1 over it."""
        return ONE / self

    def __truediv__(self, other: Scalar) -> Scalar:
        """Return the quotient; its number is rounded once."""
        below = tuple((k, -p) for k, p in other.factors)
        factors = _together(self.factors, below) if self.number else ()
        return Scalar(_quotient(self.number, other.number), factors)

    def __neg__(self) -> Scalar:
        """Return the negative."""
        return Scalar(-self.number, self.factors)


ONE, ZERO = Scalar(1.0), Scalar(0.0)


def _quotient(a: float, b: float) -> float:
    """Return a / b, by 0 as the arithmetic of C has it."""
    if b:
        return a / b
    return math.copysign(math.inf, a) * math.copysign(1, b) if a else math.nan


def _together(first: Factors, second: Factors) -> Factors:
    if not first or not second:
        return first or second
    powers = dict(first)
    for key, power in second:
        powers[key] = powers.get(key, 0) + power
    return tuple(sorted((k, p) for k, p in powers.items() if p))


def common_factor(scalars: list[Scalar]) -> Scalar:
    """Return the number of the first scalar and the powers that all of them share."""
    powers = dict(scalars[0].factors)
    for other in scalars[1:]:
        theirs = dict(other.factors)
        for key, power in list(powers.items()):
            shared = theirs.get(key, 0)
            same_sign = shared * power > 0
            powers[key] = (min if power > 0 else max)(power, shared) if same_sign else 0
    factors = tuple(sorted((k, p) for k, p in powers.items() if p))
    return Scalar(scalars[0].number, factors)


class Scalars:
    """The expressions behind the keys of scalars."""

    def __init__(self) -> None:
        self._expressions: dict[str, ca.SX] = {}

    def of(self, expression: ca.SX) -> Scalar:
        """Return an expression as a scalar."""
        if expression.is_constant():
            return Scalar(float(expression))
        key = str(expression)
        self._expressions.setdefault(key, expression)
        return Scalar(1.0, ((key, 1),))

    def expression(self, scalar: Scalar) -> ca.SX:
        """Return a scalar as an expression."""
        result = ca.SX(scalar.number)
        for key, power in scalar.factors:
            base = self._expressions[key]
            for _ in range(abs(power)):
                result = result * base if power > 0 else result / base
        return result

    def add(self, a: Scalar, b: Scalar) -> Scalar:
        """Return the sum."""
        if a.is_zero:
            return b
        if b.is_zero:
            return a
        if a.factors == b.factors:
            total = a.number + b.number
            return Scalar(total, a.factors if total else ())
        return self.of(self.expression(a) + self.expression(b))
