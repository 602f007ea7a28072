"""Functions on a box as polynomials whose coefficients are balls of Arb (python-flint)."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import Any

from flint import arb

from painleve_sym.certify.checker import Side
from painleve_sym.certify.program import Step

Polynomial = dict[int, Any]
"""Coefficients by the place of their exponents; that of the constant, 0, is always there."""
_STEPS = 50
"""Steps of a program from one look at the clock to the next."""
_ZERO, _NAN = arb(0), arb("nan")


class BallPolynomials:
    """Taylor models of n quantities up to a degree.

    The quantities are distances from the middle of a piece, from −1 to 1. At each point of the
    piece, numbers within the balls make the polynomial equal to the function: what a product has
    above the degree, and the rest of a series, widen the ball of the constant.

    Source: Revol, Makino & Berz (2005).
    """

    def __init__(self, n: int, degree: int) -> None:
        self.n, self.degree = n, degree
        # The quantities of each term, those of a square twice, in the order of degrees.
        self._factors = [
            factors
            for size in range(degree + 1)
            for factors in combinations_with_replacement(range(n), size)
        ]
        self._places = {factors: k for k, factors in enumerate(self._factors)}
        self._rows: dict[int, list[int | None]] = {}

    def results(
        self, program: Sequence[Step], box: Sequence[Side], deadline: float = math.inf
    ) -> list[Polynomial]:
        """Return the polynomials of the results of a program on a box; nan where it has none.

        TimeoutError where `time.thread_time` passes the deadline.
        """
        places: dict[int, Polynomial] = {}
        results: dict[int, Polynomial] = {}
        for count, (name, place, taken) in enumerate(program):
            if count % _STEPS == 0 and time.thread_time() > deadline:
                raise TimeoutError
            if name == "const":
                places[place] = {0: arb(float.fromhex(taken[0]))}
            elif name == "input":
                places[place] = self._quantity(taken[0], box)
            elif name == "output":
                results[place] = places[taken[0]]
            elif all(places[k][0].is_finite() for k in taken):
                places[place] = self._apply(name, [places[k] for k in taken])
            else:
                places[place] = {0: _NAN}
        return [results[k] for k in range(len(results))]

    def lower_bound(self, x: Polynomial) -> float:
        """Return a number that the function does not fall below; −∞ where there is none."""
        low = x[0]
        for k, c in x.items():
            if k:
                low -= c.abs_upper() if self._is_odd(k) else (-c.lower()).max(_ZERO)
        return float(low.lower()) if low.is_finite() else -math.inf

    def influences(self, x: Polynomial) -> list[float]:
        """Return how much each quantity moves the function, for the choice of a side to halve."""
        sums = [0.0] * self.n
        for k, c in x.items():
            for i in self._factors[k]:
                sums[i] += abs(float(c.mid()))
        return sums

    def _is_odd(self, k: int) -> bool:
        factors = self._factors[k]
        return any(factors.count(i) % 2 for i in set(factors))

    def _quantity(self, i: int, box: Sequence[Side]) -> Polynomial:
        low, high = map(arb, box[i])
        middle = arb(box[i][0] + (box[i][1] - box[i][0]) / 2)
        if box[i][0] == box[i][1]:
            return {0: middle}
        radius = (high - middle).abs_upper().max((middle - low).abs_upper())
        return {0: middle, self._places[(i,)]: radius}

    def _plus(self, x: Polynomial, y: Polynomial) -> Polynomial:
        total = dict(x)
        for k, c in y.items():
            total[k] = total[k] + c if k in total else c
        return total

    def _scaled(self, x: Polynomial, factor: Any) -> Polynomial:
        return {k: c * factor for k, c in x.items()}

    def _row(self, i: int) -> list[int | None]:
        """Return the places of the products of a term with each one; None above the degree."""
        if i not in self._rows:
            mine = self._factors[i]
            self._rows[i] = [
                self._places.get(tuple(sorted(mine + other))) for other in self._factors
            ]
        return self._rows[i]

    def _times(self, x: Polynomial, y: Polynomial) -> Polynomial:
        if len(x) == 1:
            return self._scaled(y, x[0])
        if len(y) == 1:
            return self._scaled(x, y[0])
        product: Polynomial = {}
        for i, a in x.items():
            row = self._row(i)
            for j, b in y.items():
                if (k := row[j]) is not None:
                    c = a * b
                    product[k] = product[k] + c if k in product else c
        sizes_x, sizes_y = self._sizes(x), self._sizes(y)
        above = _ZERO
        for d, a in sizes_x.items():
            for e, b in sizes_y.items():
                if d + e > self.degree:
                    above += a * b
        return _widened(product, above)

    def _sizes(self, x: Polynomial) -> dict[int, Any]:
        """Return the sums of absolute coefficients of each degree."""
        sizes: dict[int, Any] = {}
        for k, c in x.items():
            d = len(self._factors[k])
            sizes[d] = sizes.get(d, _ZERO) + c.abs_upper()
        return sizes

    def _spread(self, x: Polynomial) -> Any:
        """Return a bound of the distance from the constant, whose own ball is not part of it."""
        return sum((c.abs_upper() for k, c in x.items() if k), _ZERO).abs_upper()

    def _series(self, coefficients: Sequence[Any], rest: Any, x: Polynomial) -> Polynomial:
        """Return Σ c_k (x − x_0)^k, widened by the rest; x_0 is the constant."""
        without: Polynomial = {**x, 0: _ZERO}
        result: Polynomial = {0: coefficients[-1]}
        for c in reversed(coefficients[:-1]):
            result = self._times(result, without)
            result[0] = result[0] + c
        return _widened(result, rest)

    def _ratio_series(self, x: Polynomial, first: Any, coefficients: Sequence[Any]) -> Polynomial:
        """Return first · Σ c_k r^k, r = (x − x_0)/x_0, of a series with |c_k| <= 1."""
        inverse = 1 / x[0]
        size = self._spread(x) * inverse.abs_upper()
        if not size < 1:
            return {0: _NAN}
        scaled = [first * c * inverse**k for k, c in enumerate(coefficients)]
        rest = first.abs_upper() * size ** (self.degree + 1) / (1 - size)
        return self._series(scaled, rest, x)

    def _inverse(self, x: Polynomial) -> Polynomial:
        if len(x) == 1:
            return {0: 1 / x[0]}
        return self._ratio_series(x, 1 / x[0], [(-1) ** k for k in range(self.degree + 1)])

    def _root(self, x: Polynomial) -> Polynomial:
        if len(x) == 1:
            return {0: x[0].sqrt()}
        binomial = [arb(1)]
        for k in range(self.degree):
            binomial.append(binomial[-1] * (1 - 2 * k) / (2 * k + 2))
        return self._ratio_series(x, x[0].sqrt(), binomial)

    def _wave(self, x: Polynomial, phase: int) -> Polynomial:
        sine, cosine = x[0].sin(), x[0].cos()
        slopes = (sine, cosine, -sine, -cosine)
        if len(x) == 1:
            return {0: slopes[phase]}
        size, degree = self._spread(x), self.degree
        coefficients = [slopes[(phase + k) % 4] / math.factorial(k) for k in range(degree + 1)]
        return self._series(coefficients, size ** (degree + 1) / math.factorial(degree + 1), x)

    def _power(self, x: Polynomial, exponent: Polynomial) -> Polynomial:
        twice = int(float(2 * exponent[0])) if (2 * exponent[0]).is_integer() else 0
        count = abs(twice)
        if len(exponent) > 1 or not 1 <= count <= 32:
            return {0: _NAN}
        factor, count = (self._root(x), count) if count % 2 else (x, count // 2)
        result = factor
        for _ in range(count - 1):
            result = self._times(result, factor)
        return result if twice > 0 else self._inverse(result)

    def _apply(self, name: str, take: Sequence[Polynomial]) -> Polynomial:
        x, y = take[0], take[-1]
        match name:
            case "add":
                return self._plus(x, y)
            case "sub":
                return self._plus(x, self._scaled(y, -1))
            case "mul":
                return self._times(x, y)
            case "div":
                return self._times(x, self._inverse(y))
            case "neg":
                return self._scaled(x, -1)
            case "twice":
                return self._scaled(x, 2)
            case "sq":
                return self._times(x, x)
            case "inv":
                return self._inverse(x)
            case "sqrt":
                return self._root(x)
            case "sin":
                return self._wave(x, 0)
            case "cos":
                return self._wave(x, 1)
            case "pow" | "constpow":
                return self._power(x, y)
        return x  # assign


def _widened(x: Polynomial, radius: Any) -> Polynomial:
    x[0] = x[0] + arb(0, radius.abs_upper())
    return x
