"""Checker of certificates: intervals of floating-point numbers, with Python's own library alone.

It shares nothing with what made the certificate: other arithmetic, and derivatives of its own. A
certificate says that a function is positive on a box. It has the function as elementary operations,
and a tree of bisections, whose leaves bound the function from below.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from math import inf, nextafter
from typing import Any, NamedTuple

FORMAT = "painleve-certificate 1"
_LIBRARY = 4
"""Units in the last place by which sine and cosine of the C library may be wrong, generously."""


class Rejected(Exception):
    """A certificate that proves nothing; the message says why."""


class Interval(NamedTuple):
    """All numbers from `low` to `high`; every operation rounds outwards."""

    low: float
    high: float

    def __add__(self, other: Interval) -> Interval:  # type: ignore[override]
        return _outwards(self.low + other.low, self.high + other.high)

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __sub__(self, other: Interval) -> Interval:
        return _outwards(self.low - other.high, self.high - other.low)

    def __mul__(self, other: Interval) -> Interval:  # type: ignore[override]
        if self == _ZERO or other == _ZERO:
            return _ZERO
        (a, b), (c, d) = self, other
        products = (a * c, a * d, b * c, b * d)
        return _outwards(min(products), max(products))

    def inverse(self) -> Interval:
        """Return 1/x; Rejected where 0 is one of the numbers."""
        if self.low <= 0 <= self.high:
            raise Rejected("a quotient may divide by 0")
        return _outwards(1 / self.high, 1 / self.low)

    def square(self) -> Interval:
        """Return x²."""
        a, b = abs(self.low), abs(self.high)
        low = 0.0 if self.low <= 0 <= self.high else min(a, b) ** 2
        return Interval(max(0.0, nextafter(low, -inf)), nextafter(max(a, b) ** 2, inf))

    def root(self) -> Interval:
        """Return √x; Rejected where a number is negative."""
        if self.low < 0:
            raise Rejected("a root may be of a negative number")
        return _outwards(math.sqrt(self.low), math.sqrt(self.high))

    def sine(self) -> Interval:
        """Return sin x."""
        return self._wave(math.sin, 0.5)

    def cosine(self) -> Interval:
        """Return cos x."""
        return self._wave(math.cos, 0.0)

    def _wave(self, wave: Any, crest: float) -> Interval:
        """Return the range of a wave that is 1 at (crest + 2 k) π and -1 half a period later."""
        if not self.high - self.low < 6:
            return Interval(-1.0, 1.0)
        ends = wave(self.low), wave(self.high)
        low, high = min(ends), max(ends)
        # Slightly wider, so that a crest at an end is not missed by rounding.
        slack = 1e-12 * (1 + abs(self.low) + abs(self.high))
        first, last = (self.low - slack) / math.pi, (self.high + slack) / math.pi
        if math.floor((last - crest) / 2) >= math.ceil((first - crest) / 2):
            high = 1.0
        if math.floor((last - crest - 1) / 2) >= math.ceil((first - crest - 1) / 2):
            low = -1.0
        error = _LIBRARY * 2.3e-16
        return Interval(max(-1.0, low - error), min(1.0, high + error))


def _outwards(low: float, high: float) -> Interval:
    if math.isnan(low) or math.isnan(high):
        raise Rejected("an operation has no finite value")
    return Interval(nextafter(low, -inf), nextafter(high, inf))


_ZERO, _ONE = Interval(0.0, 0.0), Interval(1.0, 1.0)


class Dual(NamedTuple):
    """A value with its derivatives by the quantities of the box."""

    value: Interval
    slopes: tuple[Interval, ...]

    def linear(self, factor: Interval, value: Interval) -> Dual:
        """Return a function of this number: its value, and the derivative as factor."""
        return Dual(value, tuple(factor * s for s in self.slopes))

    def plus(self, other: Dual, value: Interval) -> Dual:
        """Return a sum of which the value is known."""
        return Dual(value, tuple(a + b for a, b in zip(self.slopes, other.slopes, strict=True)))


def _apply(name: str, take: Sequence[Dual]) -> Dual:
    x = take[0]
    if name in ("add", "sub", "mul", "div"):
        y = take[1]
        if name == "add":
            return x.plus(y, x.value + y.value)
        if name == "sub":
            return x.plus(y.linear(-_ONE, -y.value), x.value - y.value)
        if name == "div":
            inverse = y.value.inverse()
            return _apply("mul", (x, y.linear(-inverse.square(), inverse)))
        return x.linear(y.value, x.value).plus(y.linear(x.value, y.value), x.value * y.value)
    if name == "assign":
        return x
    if name == "neg":
        return x.linear(-_ONE, -x.value)
    if name == "twice":
        two = Interval(2.0, 2.0)
        return x.linear(two, two * x.value)
    if name == "sq":
        return x.linear(Interval(2.0, 2.0) * x.value, x.value.square())
    if name == "inv":
        inverse = x.value.inverse()
        return x.linear(-inverse.square(), inverse)
    if name == "sqrt":
        root = x.value.root()
        if not any(s != _ZERO for s in x.slopes):
            return Dual(root, x.slopes)
        return x.linear((Interval(2.0, 2.0) * root).inverse(), root)
    if name == "sin":
        return x.linear(x.value.cosine(), x.value.sine())
    if name == "cos":
        return x.linear(-x.value.sine(), x.value.cosine())
    if name in ("pow", "constpow"):
        power = take[1].value
        count = int(power.low)
        if power.low != power.high or count != power.low or not 1 <= count <= 16:
            raise Rejected("a power has another exponent than 1 to 16")
        result = x
        for _ in range(count - 1):
            result = _apply("mul", (result, x))
        return result
    raise Rejected(f"unknown operation {name!r}")


def evaluated(program: Sequence[Sequence[Any]], box: Sequence[Interval]) -> Dual:
    """Return value and derivatives of a program on a box."""
    n = len(box)
    still = (_ZERO,) * n
    places: dict[int, Dual] = {}
    result: Dual | None = None
    for name, place, taken in program:
        if name == "const":
            value = float.fromhex(taken[0])
            places[place] = Dual(Interval(value, value), still)
        elif name == "input":
            slopes = tuple(_ONE if i == taken[0] else _ZERO for i in range(n))
            places[place] = Dual(box[taken[0]], slopes)
        elif name == "output":
            result = places[taken[0]]
        else:
            places[place] = _apply(name, [places[k] for k in taken])
    if result is None:
        raise Rejected("the program has no result")
    return result


def lower_bound(program: Sequence[Sequence[Any]], box: Sequence[Interval]) -> float:
    """Return a number that the function does not fall below on a box: the better of two forms."""
    whole = evaluated(program, box)
    middles = [a + (b - a) / 2 for a, b in box]
    total = evaluated(program, [Interval(m, m) for m in middles]).value
    for slope, side, middle in zip(whole.slopes, box, middles, strict=True):
        total = total + slope * (side - Interval(middle, middle))
    return max(whole.value.low, total.low)


def halves(box: Sequence[Interval], k: int) -> tuple[list[Interval], list[Interval]]:
    """Return both halves of a box, cut across its side k."""
    low, high = box[k]
    middle = low + (high - low) / 2
    left, right = list(box), list(box)
    left[k], right[k] = Interval(low, middle), Interval(middle, high)
    return left, right


def digest(certificate: Mapping[str, Any]) -> str:
    """Return the hash of all but the hash itself."""
    content = {key: value for key, value in certificate.items() if key != "sha256"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def check(certificate: Mapping[str, Any]) -> int:
    """Verify a certificate and return the number of its pieces.

    Raises
    ------
    Rejected
        It is damaged, does not cover its box, or has a bound that is not confirmed.
    """
    try:
        if certificate["format"] != FORMAT:
            raise Rejected(f"the format is not {FORMAT!r}")
        if certificate["sha256"] != digest(certificate):
            raise Rejected("its content does not have the hash that it names")
        program, tree = certificate["program"], certificate["tree"]
        box = [Interval(float(a), float(b)) for a, b in certificate["over"].values()]
        return _verified(program, box, tree)
    except (KeyError, TypeError, ValueError, IndexError, OverflowError, AttributeError) as error:
        raise Rejected(f"it is damaged: {type(error).__name__}") from error


def _verified(program: Any, box: list[Interval], tree: Sequence[Any]) -> int:
    waiting, pieces = [box], 0
    for node in tree:
        if not waiting:
            raise Rejected("it has more pieces than its box")
        piece = waiting.pop()
        if isinstance(node, int):
            waiting += reversed(halves(piece, node))
            continue
        claimed = float.fromhex(node)
        if not claimed > 0:
            raise Rejected(f"a bound is not positive: {claimed:g}")
        own = lower_bound(program, piece)
        if not own >= claimed:
            raise Rejected(f"a bound is not confirmed: {claimed:g} is claimed, {own:g} proved")
        pieces += 1
    if waiting:
        raise Rejected("its pieces do not cover the box")
    return pieces
