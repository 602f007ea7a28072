"""Proof that conditions hold on a box, functions that are positive, by ball arithmetic on pieces.

The box is halved until polynomials with balls as coefficients show that each function is positive
on each piece, or balls that one is negative at the middle of one, where those before it are
positive. The earliest condition comes first, and of it the piece with the worst bound: a later one
that fails is the answer only where those before it are settled, or `_SETTLING` pieces later.
"""

from __future__ import annotations

import enum
import heapq
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import casadi as ca

from painleve_sym.certify.checker import (
    FORMAT,
    MAX_PIECES,
    Polynomials,
    Rejected,
    Side,
    digest,
    halves,
    over_list,
)
from painleve_sym.certify.program import Step, program_of
from painleve_sym.errors import InputError
from painleve_sym.plain_data import plain_fields
from painleve_sym.progress import progress

if TYPE_CHECKING:
    from painleve_sym.certify.ball_polynomials import BallPolynomials

MAX_SECONDS = 300.0
"""Processor time after which the question stays undecided, as it does after `MAX_PIECES`."""
MAX_QUANTITIES = 16
"""Sides of a box."""
_SETTLING = 40
"""Pieces that are halved for the conditions before one that is known to fail."""
_TERMS = 40
"""Terms of a polynomial: its degree is the largest one with as many, but 3 to 10."""
_NARROW = 2.0**-50
"""Part of a quantity, and of its side of the box, below which a side is not halved."""
_SHARE = 0.5
"""Part of a proven bound that is claimed: another C library has other sines."""


class Decision(enum.StrEnum):
    """End of an attempt to prove that conditions hold on a box."""

    PROVED = "proved"
    REFUTED = "refuted"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Proof:
    """Result of an attempt to prove that conditions hold on a box.

    Attributes
    ----------
    verdict : Verdict
    pieces : int
        Pieces of the box on which they are proved.
    piece : dict of str to tuple of float or None
        The piece that refutes one, or on which it stays undecided; None for a proof.
    condition : str or None
        That condition.
    certificate : dict or None
        What `checker.check` verifies; None without a proof.
    """

    verdict: Decision
    pieces: int
    piece: dict[str, tuple[float, float]] | None
    condition: str | None
    certificate: dict[str, Any] | None

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, without the certificate."""
        return plain_fields(self, "verdict", "pieces", "piece", "condition")


def prove_positive(
    function: ca.Function,
    conditions: Sequence[str],
    over: Mapping[str, tuple[float, float]],
    claim: str,
    max_pieces: int = MAX_PIECES,
    max_seconds: float = MAX_SECONDS,
) -> Proof:
    """Return whether all results of a function of one vector are positive on a box.

    Parameters
    ----------
    function : casadi.Function
        Of SX operations, of the quantities of the box in their order to one vector.
    conditions : sequence of str
        What each of its results says where it is positive. One is refuted only where those before
        it hold.
    over : mapping of str to (float, float)
        Ends of each quantity.
    claim : str
        The statement in words, for the certificate.
    max_pieces : int
    max_seconds : float
        Pieces and processor time after which the question stays undecided.

    Raises
    ------
    InputError
        Without python-flint; an operation whose range is not known; too many quantities.
    """
    try:
        from painleve_sym.certify.ball_polynomials import BallPolynomials
    except ImportError:
        raise InputError(
            "certify: needs python-flint. Fix: pip install 'painleve-sym[certify]'."
        ) from None
    degree = degree_for(len(over))
    box = [(float(a), float(b)) for a, b in over.values()]
    judge = _Judge(
        BallPolynomials(len(over), degree),
        Polynomials(len(over), degree),
        program_of(function),
        box,
        time.thread_time() + max_seconds,
    )
    cuts: dict[int, int] = {}
    bounds: dict[int, list[float]] = {}
    failed: tuple[int, list[Side]] | None = None

    def ended(piece: list[Side], which: int, verdict: Decision = Decision.UNDECIDED) -> Proof:
        if failed is not None:
            verdict, (which, piece) = Decision.REFUTED, failed
        where = dict(zip(over, piece, strict=True))
        return Proof(verdict, len(bounds), where, conditions[which], None)

    # Pieces to halve, those of the first condition first, and the one with the worst bound first;
    # the halves of piece k are 2k and 2k + 1.
    waiting: list[tuple[int, float, int, list[Side], int]] = []
    fresh, which, patience = [(1, box)], 0, _SETTLING
    with progress("certify", unit=" pieces") as advance:
        while fresh:
            for place, piece in fresh:
                try:
                    own = judge(piece)
                except TimeoutError:
                    return ended(piece, which)
                if isinstance(own, list):
                    bounds[place] = [bound * _SHARE for bound in own]
                    advance(1)
                    continue
                if own.failing is not None and (failed is None or own.failing < failed[0]):
                    failed = own.failing, piece
                heapq.heappush(waiting, (own.condition, own.bound, place, piece, own.across))
            fresh = []
            if waiting:
                which, _, place, piece, across = heapq.heappop(waiting)
                if failed is not None:
                    patience -= 1
                    if failed[0] <= which or not patience:
                        return ended(piece, which)
                left, right = halves(piece, across)
                low, high = piece[across]
                stuck = high - low <= _NARROW * max(
                    abs(low), abs(high), box[across][1] - box[across][0]
                )
                if stuck or len(bounds) + len(waiting) + 2 > max_pieces:
                    return ended(piece, which)
                cuts[place] = across
                fresh = [(2 * place, left), (2 * place + 1, right)]
    tree = _tree(cuts, bounds)
    certificate = certificate_of(function, conditions, over, claim, degree, tree)
    return Proof(Decision.PROVED, len(bounds), None, None, certificate)


class _Open(NamedTuple):
    """A piece on which not all conditions are proved.

    The first of those, its lower bound, the one that fails in the middle of the piece where those
    before it hold, or None, and the side to halve.
    """

    condition: int
    bound: float
    failing: int | None
    across: int


@dataclass(frozen=True)
class _Judge:
    """Judgement of a piece of a box by balls."""

    polynomials: BallPolynomials
    checker: Polynomials
    program: list[Step]
    box: list[Side]
    deadline: float

    def __call__(self, piece: list[Side]) -> list[float] | _Open:
        """Return a positive lower bound of each condition, or what is still open.

        TimeoutError after the deadline.
        """
        values = self.polynomials.results(self.program, piece, self.deadline)
        bounds = [self.polynomials.lower_bound(value) for value in values]
        if self._first_open(bounds) is None:
            # What balls prove is a piece of the certificate only where its checker confirms it.
            bounds = [min(pair) for pair in zip(bounds, self._confirmed(piece), strict=True)]
        which = self._first_open(bounds)
        if which is None:
            return bounds
        middle = [(m, m) for m in (a + (b - a) / 2 for a, b in piece)]
        there = self.polynomials.results(self.program, middle, self.deadline)
        # The first condition that is not proved there fails, or is undecided.
        first = next((k for k, value in enumerate(there) if not value[0] > 0), which)
        failing = first if there[first][0] < 0 else None
        across = self._side(self.polynomials.influences(values[which]), piece)
        return _Open(which, bounds[which], failing, across)

    def _first_open(self, bounds: list[float]) -> int | None:
        return next((k for k, bound in enumerate(bounds) if not bound * _SHARE > 0), None)

    def _confirmed(self, piece: list[Side]) -> list[float]:
        """Return the bounds of the checker; where it has none, −∞ for the last condition."""
        try:
            models = self.checker.evaluated(self.program, piece)
            return [self.checker.lowest(model) for model in models]
        except (Rejected, ArithmeticError):
            count = sum(name == "output" for name, *_ in self.program)
            return [*[math.inf] * (count - 1), -math.inf]

    def _side(self, influences: list[float], piece: list[Side]) -> int:
        """Return the side to halve: that of the quantity which moves the function most."""
        if not all(map(math.isfinite, influences)) or not any(influences):
            pairs = zip(piece, self.box, strict=True)
            influences = [(b - a) / (d - c) if d > c else 0.0 for (a, b), (c, d) in pairs]
        return influences.index(max(influences))


def degree_for(n: int) -> int:
    """Return the degree of polynomials of n quantities.

    Raises
    ------
    InputError
        More than `MAX_QUANTITIES`.
    """
    if n > MAX_QUANTITIES:
        raise InputError(
            f"certify: got {n} quantities that vary, need at most {MAX_QUANTITIES}. "
            "Fix: give fewer of them a range."
        )
    return next((d for d in range(10, 3, -1) if math.comb(n + d, d) <= _TERMS), 3)


def _tree(cuts: Mapping[int, int], bounds: Mapping[int, list[float]]) -> list[int | list[str]]:
    tree: list[int | list[str]] = []
    waiting = [1]
    while waiting:
        place = waiting.pop()
        if place in cuts:
            tree.append(cuts[place])
            waiting += [2 * place + 1, 2 * place]
        else:
            tree.append([bound.hex() for bound in bounds[place]])
    return tree


def certificate_of(
    function: ca.Function,
    conditions: Sequence[str],
    over: Mapping[str, tuple[float, float]],
    claim: str,
    degree: int,
    tree: list[Any],
) -> dict[str, Any]:
    """Return the certificate of conditions on a box, with a tree of bisections and bounds.

    In the order of a walk that goes left first, the tree has the side that is halved, or as texts
    the bounds of a piece, one of each condition.
    """
    certificate: dict[str, Any] = {
        "format": FORMAT,
        "claim": claim,
        "conditions": list(conditions),
        "over": over_list(over),
        "degree": degree,
        "program": [[name, place, list(taken)] for name, place, taken in program_of(function)],
        "tree": tree,
    }
    return certificate | {"sha256": digest(certificate)}
