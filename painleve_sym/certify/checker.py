"""Checker of certificates: polynomials of floating-point numbers, with Python's own library alone.

It shares nothing with what made the certificate: other numbers, and another account of errors. A
certificate says that conditions hold on a box: functions that are positive. It has the functions as
elementary operations, and a tree of bisections, whose leaves bound each of them from below.

What is verified is that those functions are positive on that box. Whether they are the functions of
a model, and those of the claim in words, is not known here: `painleve certify --check` derives them
again, and compares everything that the certificate says.
"""

from __future__ import annotations

import hashlib
import json
import math
import sys
import time
from collections.abc import Mapping, Sequence
from math import inf, nextafter
from typing import Any, NamedTuple

FORMAT = "painleve-certificate 3"
Side = tuple[float, float]
"""Ends of a quantity."""
MAX_DEGREE = 16
"""Of the polynomials of a certificate."""
MAX_TERMS = 1000
"""Terms of a polynomial of that degree."""
MAX_PIECES = 20_000
"""Pieces of a box."""
MAX_STEPS = 1_000_000
"""Elementary operations of a program."""
MAX_SECONDS = 900.0
"""Processor time of a verification, three times as much as a proof may take."""
_STEPS = 50
"""Operations from one look at the clock to the next."""
_ROUNDING = 2.0**-52
"""Twice the relative error of an operation, so that it also covers what sums of it round."""
_SLACK = 1e-12
"""Relative widening of a computed bound, far more than its own few operations round."""
_LEAST = 1e-300
"""Absolute widening of a computed bound: what underflows."""
_WAVE = 1e-15
"""Error of sine and cosine of the C library: four units in the last place, and more."""


_DAMAGE = (
    *(KeyError, TypeError, ValueError, IndexError, ArithmeticError, AttributeError),
    RecursionError,
)
"""What Python raises where a certificate has other entries than it should."""


class Rejected(Exception):
    """A certificate that proves nothing; the message says why."""


class TaylorModel(NamedTuple):
    """A polynomial, and a bound of its distance from the function that it stands for.

    The polynomial is one of distances from the middle of a piece, which are from −1 to 1. Its
    coefficients are by number of their term, see `Polynomials`.
    """

    terms: dict[int, float]
    error: float

    @property
    def middle(self) -> float:
        """The constant term."""
        return self.terms.get(0, 0.0)

    @property
    def spread(self) -> float:
        """Bound of the distance of the function from the constant term."""
        return _up(self.error + sum(abs(c) for k, c in self.terms.items() if k))


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise Rejected("an operation has no finite value")
    return value


def _up(bound: float) -> float:
    return _finite(bound) * (1 + _SLACK) + _LEAST


def _number(value: float, error: float = 0.0) -> TaylorModel:
    return TaylorModel({0: value}, error)


class Polynomials:
    """Taylor models of n quantities up to a degree: what is above widens their error.

    The account of rounding is that of Revol, Makino & Berz (2005), more generous.

    The number of the term x^a y^b … has its degree and a, b, … as digits in the base degree + 1:
    numbers of factors add up to that of the product, unless its degree is above.
    """

    def __init__(self, n: int, degree: int, deadline: float = inf) -> None:
        self.n, self.degree, self.base = n, degree, degree + 1
        self.deadline = deadline
        self.one = self.base**n
        self.end = self.base * self.one

    def evaluated(self, program: Sequence[Sequence[Any]], box: Sequence[Side]) -> list[TaylorModel]:
        """Return the models of the results of a program on a box.

        Rejected where `time.thread_time` passes the deadline.
        """
        places: dict[int, TaylorModel] = {}
        results: dict[int, TaylorModel] = {}
        for count, (name, place, taken) in enumerate(program):
            if count % _STEPS == 0 and time.thread_time() > self.deadline:
                raise Rejected("its verification takes more processor time than is given to it")
            if name == "const":
                places[place] = _number(_finite(float.fromhex(taken[0])))
            elif name == "input":
                places[place] = self.quantity(taken[0], box)
            elif name == "output":
                results[place] = places[taken[0]]
            else:
                places[place] = self._apply(name, [places[k] for k in taken])
        return [results[k] for k in range(len(results))]

    def quantity(self, i: int, box: Sequence[Side]) -> TaylorModel:
        """Return the model of a quantity itself."""
        if i < 0:
            raise Rejected("an input is none of the quantities of its box")
        low, high = box[i]
        middle = low + (high - low) / 2
        radius = nextafter(max(high - middle, middle - low), inf)
        if not low <= high:
            raise Rejected("the ends of a quantity are in the wrong order")
        term = self.one + self.base**i
        return TaylorModel({0: _finite(middle), term: _finite(radius)}, 0.0)

    def lowest(self, x: TaylorModel) -> float:
        """Return a number that the function does not fall below."""
        below = x.error
        for k, c in x.terms.items():
            if k:
                below += max(0.0, -c) if self._is_even(k) else abs(c)
        return nextafter(x.middle - _up(below), -inf)

    def plus(self, x: TaylorModel, y: TaylorModel, factor: float = 1.0) -> TaylorModel:
        """Return x + y, or x − y with the factor −1."""
        terms, rounded = dict(x.terms), 0.0
        for k, c in y.terms.items():
            if k in terms:
                terms[k] += factor * c
                rounded += abs(terms[k])
            else:
                terms[k] = factor * c
        return TaylorModel(terms, _up(x.error + y.error + _ROUNDING * rounded))

    def times(self, x: TaylorModel, y: TaylorModel) -> TaylorModel:
        """Return x y."""
        terms: dict[int, float] = {}
        for i, a in x.terms.items():
            for j, b in y.terms.items():
                if (k := i + j) < self.end:
                    terms[k] = terms.get(k, 0.0) + a * b
        sizes_x, sizes_y = self._sizes(x), self._sizes(y)
        above = sum(
            sizes_x[i] * sizes_y[j]
            for i in range(self.base)
            for j in range(self.base - i, self.base)
        )
        size_x, size_y = sum(sizes_x), sum(sizes_y)
        # Each term is a product, and a sum of as many as one factor has at most.
        rounded = (min(len(x.terms), len(y.terms)) + 1) * size_x * size_y
        carried = size_x * y.error + size_y * x.error + x.error * y.error
        return TaylorModel(terms, _up(carried + above + _ROUNDING * rounded))

    def inverse(self, x: TaylorModel) -> TaylorModel:
        """Return 1/x by the geometric series; Rejected where 0 may be a value."""
        first, ratio, size = self._ratio(x, "a quotient may divide by 0")
        series = self._series([(-1.0) ** k for k in range(self.base)], 0.0, ratio)
        rest = size**self.base / (1 - size)
        return self.times(first, TaylorModel(series.terms, _up(series.error + rest)))

    def root(self, x: TaylorModel) -> TaylorModel:
        """Return √x by the binomial series; Rejected where a value may be negative."""
        fault = "a root may be of a negative number"
        if not x.middle > 0:
            raise Rejected(fault)
        _, ratio, size = self._ratio(x, fault)
        binomial = [1.0]
        for k in range(self.degree):
            binomial.append(binomial[-1] * (0.5 - k) / (k + 1))
        series = self._series(binomial, 0.0, ratio)
        # No coefficient of the series is above 1.
        rest = size**self.base / (1 - size)
        root = math.sqrt(x.middle)
        first = _number(root, _up(_ROUNDING * root))
        return self.times(first, TaylorModel(series.terms, _up(series.error + rest)))

    def wave(self, x: TaylorModel, phase: int) -> TaylorModel:
        """Return the sine of x, or with the phase 1 the cosine, by Taylor's series."""
        sine, cosine = math.sin(x.middle), math.cos(x.middle)
        slopes = (sine, cosine, -sine, -cosine)
        coefficients = [slopes[(phase + k) % 4] / math.factorial(k) for k in range(self.base)]
        rest = x.spread**self.base / math.factorial(self.base)
        series = self._series(coefficients, _WAVE, self._without_middle(x))
        return TaylorModel(series.terms, _up(series.error + rest))

    def _power(self, x: TaylorModel, exponent: TaylorModel) -> TaylorModel:
        """Return x to a power that is a multiple of 1/2, up to 16 in size."""
        twice = 2 * exponent.middle
        count = int(abs(twice))
        if set(exponent.terms) != {0} or exponent.error or not 1 <= count == abs(twice) <= 32:
            raise Rejected("a power has another exponent than a multiple of 1/2 up to 16")
        factor, count = (self.root(x), count) if count % 2 else (x, count // 2)
        result = factor
        for _ in range(count - 1):
            result = self.times(result, factor)
        return result if twice > 0 else self.inverse(result)

    def _ratio(self, x: TaylorModel, fault: str) -> tuple[TaylorModel, TaylorModel, float]:
        """Return 1/m and (x − m)/m with a bound of its size, for the constant term m of x."""
        if not (x.middle and x.spread < abs(x.middle)):
            raise Rejected(fault)
        inverse = 1 / x.middle
        first = _number(inverse, _up(_ROUNDING * abs(inverse)))
        ratio = self.times(self._without_middle(x), first)
        size = _up(sum(map(abs, ratio.terms.values())) + ratio.error)
        if not size < 1:
            raise Rejected(fault)
        return first, ratio, size

    def _without_middle(self, x: TaylorModel) -> TaylorModel:
        return TaylorModel({k: c for k, c in x.terms.items() if k}, x.error)

    def _series(self, coefficients: Sequence[float], error: float, x: TaylorModel) -> TaylorModel:
        """Return Σ c_k x^k; each coefficient has an error, and what its own operations round."""
        rounded = 4 * len(coefficients) * _ROUNDING
        *before, last = (_number(c, _up(error + rounded * abs(c))) for c in coefficients)
        result = last
        for own in reversed(before):
            result = self.plus(self.times(result, x), own)
        return result

    def _sizes(self, x: TaylorModel) -> list[float]:
        """Return the sums of absolute coefficients of each degree."""
        sizes = [0.0] * self.base
        for k, c in x.terms.items():
            sizes[k // self.one] += abs(c)
        return sizes

    def _is_even(self, k: int) -> bool:
        """Return whether every exponent of a term is even, so that it is never negative."""
        return all(k // self.base**i % self.base % 2 == 0 for i in range(self.n))

    def _apply(self, name: str, take: Sequence[TaylorModel]) -> TaylorModel:
        x = take[0]
        if name in ("add", "sub"):
            return self.plus(x, take[1], 1.0 if name == "add" else -1.0)
        if name == "mul":
            return self.times(x, take[1])
        if name == "div":
            return self.times(x, self.inverse(take[1]))
        if name == "assign":
            return x
        if name == "neg":
            return TaylorModel({k: -c for k, c in x.terms.items()}, x.error)
        if name == "twice":
            return self.plus(x, x)
        if name == "sq":
            return self.times(x, x)
        if name == "inv":
            return self.inverse(x)
        if name == "sqrt":
            return self.root(x)
        if name in ("sin", "cos"):
            return self.wave(x, int(name == "cos"))
        if name in ("pow", "constpow"):
            return self._power(x, take[1])
        raise Rejected(f"unknown operation {name!r}")


def halves(box: Sequence[Side], k: int) -> tuple[list[Side], list[Side]]:
    """Return both halves of a box, cut across its side k."""
    low, high = box[k]
    middle = low + (high - low) / 2
    left, right = list(box), list(box)
    left[k], right[k] = (low, middle), (middle, high)
    return left, right


def over_list(over: Mapping[str, Side]) -> list[list[Any]]:
    """Return a box as certificates have it: name and ends of each quantity, in their order."""
    return [[name, float(low), float(high)] for name, (low, high) in over.items()]


def box_of(over: Any) -> list[Side]:
    """Return the ends of the quantities of a certificate's box; Rejected where they are none."""
    shape = "need a list of [name, from, to], each name once and its ends finite"
    if not isinstance(over, list) or not all(map(_is_side, over)):
        raise Rejected(f"it is damaged: {shape} as its over")
    if len({name for name, _, _ in over}) < len(over):
        raise Rejected(f"it is damaged: {shape} as its over")
    return [(float(low), float(high)) for _, low, high in over]


def _is_side(entry: Any) -> bool:
    if not isinstance(entry, list) or len(entry) != 3:
        return False
    name, *ends = entry
    return isinstance(name, str) and all(
        type(end) in (int, float) and abs(end) <= sys.float_info.max for end in ends
    )


def digest(certificate: Mapping[str, Any]) -> str:
    """Return the hash of all but the hash itself.

    The order of keys does not matter, nor whether an end of the box is written as 1 or 1.0.
    """
    content = {key: value for key, value in certificate.items() if key != "sha256"}
    if isinstance(over := content.get("over"), list):
        content["over"] = [_with_floats(side) for side in over]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _with_floats(side: Any) -> Any:
    """Return a side of a box with its whole numbers as floating-point ones."""
    if not isinstance(side, list):
        return side
    return [float(entry) if type(entry) is int else entry for entry in side]


def check(certificate: Mapping[str, Any], max_seconds: float = MAX_SECONDS) -> int:
    """Verify that the functions of a certificate are positive on its box.

    This does not tell whether they are those of a model or of the claim in words: all of them are
    only what the file says. `painleve certify MODEL --check` derives the functions again.

    Parameters
    ----------
    certificate : mapping
        As in its file.
    max_seconds : float
        Processor time after which it is rejected.

    Returns
    -------
    int
        Pieces of the box.

    Raises
    ------
    Rejected
        It is damaged or too long, does not cover its box, or has a bound that is not confirmed.
    """
    refuse_other_form(certificate)
    try:
        if certificate["sha256"] != digest(certificate):
            raise Rejected("its content does not have the hash that it names")
        box, degree = box_of(certificate["over"]), certificate["degree"]
        if not (
            type(degree) is int
            and 1 <= degree <= MAX_DEGREE
            and math.comb(len(box) + degree, degree) <= MAX_TERMS
        ):
            raise Rejected(f"its polynomials have the degree {degree!r}, or too many terms")
        conditions, program = certificate["conditions"], certificate["program"]
        if not conditions or sum(step[0] == "output" for step in program) != len(conditions):
            raise Rejected("its program has not one result for each condition")
        polynomials = Polynomials(len(box), degree, time.thread_time() + max_seconds)
        return _verified(polynomials, program, box, certificate["tree"], conditions)
    except _DAMAGE as error:
        raise Rejected(f"it is damaged: {type(error).__name__}") from error


def refuse_other_form(certificate: Any) -> None:
    """Reject another format, and what is longer than any that a proof writes."""
    if not isinstance(certificate, Mapping) or certificate.get("format") != FORMAT:
        raise Rejected(f"its format is not {FORMAT!r}. Fix: prove it again")
    box_of(certificate.get("over"))
    for key, limit in {"tree": 2 * MAX_PIECES - 1, "program": MAX_STEPS}.items():
        entries = certificate.get(key)
        if not isinstance(entries, list):
            raise Rejected(f"it is damaged: its {key} is not a list")
        if len(entries) > limit:
            raise Rejected(f"its {key} has {len(entries)} entries, need at most {limit}")


def _verified(
    polynomials: Polynomials,
    program: Any,
    box: list[Side],
    tree: Sequence[Any],
    conditions: Sequence[str],
) -> int:
    waiting, pieces = [box], 0
    for node in tree:
        if not waiting:
            raise Rejected("it has more pieces than its box")
        piece = waiting.pop()
        if type(node) is int:
            if not 0 <= node < polynomials.n:
                raise Rejected(f"it halves side {node} of a box of {polynomials.n}")
            waiting += reversed(halves(piece, node))
            continue
        models = polynomials.evaluated(program, piece)
        for condition, text, model in zip(conditions, node, models, strict=True):
            claimed, own = float.fromhex(text), polynomials.lowest(model)
            if not claimed > 0:
                raise Rejected(f"a bound is not positive: {claimed:g}, of {condition}")
            if not own >= claimed:
                raise Rejected(
                    f"a bound is not confirmed: {claimed:g} is claimed, {own:g} proved, of "
                    f"{condition}"
                )
        pieces += 1
    if waiting:
        raise Rejected("its pieces do not cover the box")
    return pieces
