"""Proof that a function is positive on a box, by ball arithmetic on pieces of it.

The box is halved until polynomials with balls as coefficients show that the function is positive
on each piece, or balls that it is negative at the middle of one. The piece with the worst bound
comes first.
"""

from __future__ import annotations

import enum
import heapq
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import casadi as ca

from painleve_sym.certify.checker import FORMAT, Polynomials, Rejected, Side, digest, halves
from painleve_sym.certify.program import Step, program_of
from painleve_sym.errors import InputError
from painleve_sym.progress import progress

if TYPE_CHECKING:
    from painleve_sym.certify.ball_polynomials import BallPolynomials

MAX_PIECES = 20_000
"""Pieces after which the question stays undecided."""
MAX_SECONDS = 300.0
"""Processor time after which it does."""
MAX_QUANTITIES = 16
"""Sides of a box."""
_TERMS = 40
"""Terms of a polynomial: its degree is the largest one with as many, but 3 to 10."""
_SHARE = 0.5
"""Part of a proven bound that is claimed: another C library has other sines."""


class Verdict(enum.StrEnum):
    """End of an attempt to prove that a function is positive on a box."""

    PROVED = "proved"
    REFUTED = "refuted"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Proof:
    """Result of an attempt to prove that a function is positive on a box.

    Attributes
    ----------
    verdict : Verdict
    pieces : int
        Pieces of the box on which the function is proved to be positive.
    piece : dict of str to tuple of float or None
        The piece that refutes it, or that stays undecided; None for a proof.
    certificate : dict or None
        What `checker.check` verifies; None without a proof.
    """

    verdict: Verdict
    pieces: int
    piece: dict[str, tuple[float, float]] | None
    certificate: dict[str, Any] | None

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, without the certificate."""
        piece = None if self.piece is None else {n: list(ends) for n, ends in self.piece.items()}
        return {"verdict": self.verdict.value, "pieces": self.pieces, "piece": piece}


def prove_positive(
    function: ca.Function,
    over: Mapping[str, tuple[float, float]],
    claim: str,
    max_pieces: int = MAX_PIECES,
    max_seconds: float = MAX_SECONDS,
) -> Proof:
    """Return whether a function of one vector is positive on a box.

    Parameters
    ----------
    function : casadi.Function
        Of SX operations, of the quantities of the box in their order to one number.
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
    bounds: dict[int, float] = {}

    def ended(verdict: Verdict, piece: list[Side]) -> Proof:
        return Proof(verdict, len(bounds), dict(zip(over, piece, strict=True)), None)

    # Pieces to halve, the one with the worst bound first; the halves of piece k are 2k and 2k + 1.
    waiting: list[tuple[float, int, list[Side], int]] = []
    fresh = [(1, box)]
    with progress("certify", unit=" pieces") as advance:
        while fresh:
            for place, piece in fresh:
                try:
                    bound, at_middle, across = judge(piece)
                except TimeoutError:
                    return ended(Verdict.UNDECIDED, piece)
                if bound * _SHARE > 0:
                    bounds[place] = bound * _SHARE
                    advance(1)
                elif at_middle < 0:
                    return ended(Verdict.REFUTED, piece)
                else:
                    heapq.heappush(waiting, (bound, place, piece, across))
            fresh = []
            if waiting:
                _, place, piece, across = heapq.heappop(waiting)
                left, right = halves(piece, across)
                stuck = any(a == b for a, b in (left[across], right[across]))
                if stuck or len(bounds) + len(waiting) + 2 > max_pieces:
                    return ended(Verdict.UNDECIDED, piece)
                cuts[place] = across
                fresh = [(2 * place, left), (2 * place + 1, right)]
    certificate = certificate_of(function, over, claim, degree, _tree(cuts, bounds))
    return Proof(Verdict.PROVED, len(bounds), None, certificate)


@dataclass(frozen=True)
class _Judge:
    """Judgement of a piece of a box by balls."""

    polynomials: BallPolynomials
    checker: Polynomials
    program: list[Step]
    box: list[Side]
    deadline: float

    def __call__(self, piece: list[Side]) -> tuple[float, float, int]:
        """Return a lower bound, an upper bound in the middle, and the side to halve.

        Where the lower bound is positive, the others are not asked for. TimeoutError after the
        deadline.
        """
        value = self.polynomials.results(self.program, piece, self.deadline)
        bound = self.polynomials.lower_bound(value)
        if bound * _SHARE > 0:
            # What balls prove is a piece of the certificate only where its checker confirms it.
            bound = min(bound, self._confirmed(piece))
        if bound * _SHARE > 0:
            return bound, math.inf, 0
        middle = [(m, m) for m in (a + (b - a) / 2 for a, b in piece)]
        at_middle = self.polynomials.results(self.program, middle, self.deadline)[0]
        top = float(at_middle.upper()) if at_middle.is_finite() else math.inf
        return bound, top, self._side(self.polynomials.influences(value), piece)

    def _confirmed(self, piece: list[Side]) -> float:
        """Return the bound of the checker; −∞ where it has none."""
        try:
            return self.checker.lowest(self.checker.evaluated(self.program, piece))
        except (Rejected, ArithmeticError):
            return -math.inf

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


def _tree(cuts: Mapping[int, int], bounds: Mapping[int, float]) -> list[int | str]:
    tree: list[int | str] = []
    waiting = [1]
    while waiting:
        place = waiting.pop()
        if place in cuts:
            tree.append(cuts[place])
            waiting += [2 * place + 1, 2 * place]
        else:
            tree.append(bounds[place].hex())
    return tree


def certificate_of(
    function: ca.Function,
    over: Mapping[str, tuple[float, float]],
    claim: str,
    degree: int,
    tree: list[Any],
) -> dict[str, Any]:
    """Return the certificate of a function on a box, with a tree of bisections and bounds.

    In the order of a walk that goes left first, the tree has the side that is halved, or as a text
    the bound of a piece.
    """
    certificate: dict[str, Any] = {
        "format": FORMAT,
        "claim": claim,
        "over": {n: [float(a), float(b)] for n, (a, b) in over.items()},
        "degree": degree,
        "program": [[name, place, list(taken)] for name, place, taken in program_of(function)],
        "tree": tree,
    }
    return certificate | {"sha256": digest(certificate)}
