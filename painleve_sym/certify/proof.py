"""Proof that a function is positive on a box, by ball arithmetic on pieces of it.

The box is halved until the balls of Arb (python-flint) show that the function is positive on each
piece, or negative at the middle of one. Each piece is bounded by the function itself, and by the
mean-value form: the value in the middle, and derivatives times distances.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from painleve_sym.certify.checker import FORMAT, Interval, digest, halves
from painleve_sym.certify.program import Step, program_of
from painleve_sym.errors import InputError

MAX_PIECES = 20_000
"""Pieces after which the question stays undecided."""
_SHARE = 0.5
"""Part of a proven bound that is claimed, so that another arithmetic confirms it."""


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

    Raises
    ------
    InputError
        Without python-flint; an operation whose range is not known.
    """
    try:
        import flint  # noqa: F401
    except ImportError:
        raise InputError(
            "certify: needs python-flint. Fix: pip install 'painleve-sym[certify]'."
        ) from None
    x = ca.SX.sym("x", len(over))
    value = function(x)
    whole = ca.vertcat(value, ca.gradient(value, x))
    with_slopes = program_of(ca.Function("slopes", [x], [ca.densify(whole)]))
    program = program_of(function)
    names = tuple(over)
    tree: list[int | str] = []
    waiting = [[Interval(*map(float, ends)) for ends in over.values()]]
    pieces = 0
    while waiting:
        piece = waiting.pop()
        bound, across, middle = _bounds(program, with_slopes, piece)
        if bound is not None and bound * _SHARE > 0:
            tree.append((bound * _SHARE).hex())
            pieces += 1
            continue
        named = {n: (side.low, side.high) for n, side in zip(names, piece, strict=True)}
        if middle < 0:
            return Proof(Verdict.REFUTED, pieces, named, None)
        left, right = halves(piece, across)
        stuck = any(a.low == a.high for a in (left[across], right[across]))
        if stuck or pieces + len(waiting) >= max_pieces:
            return Proof(Verdict.UNDECIDED, pieces, named, None)
        tree.append(across)
        waiting += [right, left]
    return Proof(Verdict.PROVED, pieces, None, certificate_of(function, over, claim, tree))


def certificate_of(
    function: ca.Function, over: Mapping[str, tuple[float, float]], claim: str, tree: list[Any]
) -> dict[str, Any]:
    """Return the certificate of a function on a box, with a tree of bisections and bounds.

    In the order of a walk that goes left first, the tree has the side that is halved, or as a text
    the bound of a piece.
    """
    certificate: dict[str, Any] = {
        "format": FORMAT,
        "claim": claim,
        "over": {n: [float(a), float(b)] for n, (a, b) in over.items()},
        "program": [[name, place, list(taken)] for name, place, taken in program_of(function)],
        "tree": tree,
    }
    return certificate | {"sha256": digest(certificate)}


def _bounds(
    program: list[Step], with_slopes: list[Step], piece: list[Interval]
) -> tuple[float | None, int, float]:
    """Return a lower bound, the side to halve, and an upper bound of the value in the middle."""
    from flint import arb

    balls = [arb(a).union(arb(b)) for a, b in piece]
    middles = [arb(a + (b - a) / 2) for a, b in piece]
    (at_middle,) = _run(program, middles)
    value, *slopes = _run(with_slopes, balls)
    effects = [s * (ball - m) for s, ball, m in zip(slopes, balls, middles, strict=True)]
    form = at_middle
    for effect in effects:
        form = form + effect
    lows = [float(b.lower()) for b in (value, form) if b.is_finite()]
    sizes = [float(e.abs_upper()) if e.is_finite() else float("inf") for e in effects]
    if not all(size < float("inf") for size in sizes):
        sizes = [b - a for a, b in piece]
    top = float(at_middle.upper()) if at_middle.is_finite() else float("inf")
    return (max(lows) if lows else None), sizes.index(max(sizes)), top


def _run(program: list[Step], box: list[Any]) -> list[Any]:
    """Return the results of a program in ball arithmetic."""
    from flint import arb

    places: dict[int, Any] = {}
    results: dict[int, Any] = {}
    for name, place, taken in program:
        if name == "const":
            places[place] = arb(float.fromhex(taken[0]))
        elif name == "input":
            places[place] = box[taken[0]]
        elif name == "output":
            results[place] = places[taken[0]]
        else:
            places[place] = _OPERATIONS[name](*(places[k] for k in taken))
    return [results[k] for k in sorted(results)]


def _power(x: Any, exponent: Any) -> Any:
    return x ** int(float(exponent)) if exponent.is_integer() else x**exponent


_OPERATIONS: dict[str, Any] = {
    "assign": lambda x: x,
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
    "neg": lambda x: -x,
    "sq": lambda x: x**2,
    "twice": lambda x: 2 * x,
    "inv": lambda x: 1 / x,
    "sqrt": lambda x: x.sqrt(),
    "sin": lambda x: x.sin(),
    "cos": lambda x: x.cos(),
    "pow": _power,
    "constpow": _power,
}
