"""Contact problems as people have them: small integers, low rank, borders; and their comparison."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from painleve_sym.problem.answers import Answers
from painleve_sym.problem.constraints import Ball, Constraint
from painleve_sym.problem.law import ScaledLaw

FRICTIONS = [Fraction(0), Fraction(1, 2), Fraction(1), Fraction(2)]
OPEN = {"unknown", "one_known"}
"""Cases that state nothing definite."""


class Problem(NamedTuple):
    """W, b, and of each contact: friction, slip velocity, whether it is closed."""

    W: np.ndarray
    b: np.ndarray
    mu: Sequence[Fraction | float]
    slip: Sequence[Sequence[float]]
    closed: Sequence[bool]

    def answers(self) -> Answers:
        """Return all answers of the kernel."""
        constraints, row = [], 0
        for mu, slip, closed in zip(self.mu, self.slip, self.closed, strict=True):
            tangents = tuple(range(row + 1, row + 1 + len(slip)))
            v = np.array(slip, float)
            length = float(np.linalg.norm(v))
            e = tuple((v / length).tolist()) if length else ()
            ball = Ball(tangents, float(mu), e)
            constraints.append(Constraint(row, (ball,), not closed, (1, -1) if closed else (1,)))
            row = tangents[-1] + 1
        W, b = np.array(self.W, float).tolist(), np.array(self.b, float).tolist()
        return Answers(ScaledLaw(W, b, constraints))

    @property
    def resting_discs(self) -> int:
        """The number of contacts in space at rest with friction."""
        pairs = zip(self.mu, self.slip, strict=True)
        return sum(len(v) > 1 and mu > 0 and not np.any(v) for mu, v in pairs)


class Verdict(NamedTuple):
    """Case, accelerations of the isolated motions, whether their forces are open."""

    case: str
    motions: list[np.ndarray]
    is_open: list[bool]
    borders: frozenset[str]


def verdict(answers: Answers, turn: np.ndarray | None = None, rows=slice(None)) -> Verdict:
    """Return what the answers state, accelerations turned and of some rows."""
    alone = [answer for answer in answers.all if not answer.moves]
    motions = [answer.checked.motion.a * np.array(answers.law.rate_unit) for answer in alone]
    if turn is not None:
        motions = [turn @ a for a in motions]
    return Verdict(
        case_of(answers),
        [a[rows] for a in motions],
        [answer.open_forces > 0 for answer in alone],
        answers.borders,
    )


def case_of(answers: Answers) -> str:
    """Return the case in words for several contacts."""
    if not answers.all:
        return "unknown" if answers.searched else "inconsistent"
    if len(answers.all) > 1 or answers.all[0].moves:
        return "indeterminate"
    if answers.all[0].open_forces:
        return "hyperstatic"
    return "one_known" if answers.searched else "unique"


def agree(one: Verdict, other: Verdict, scale: float) -> bool:
    """Return whether two verdicts are the same; of continua their cases alone."""
    if one.case != other.case:
        return False
    if "indeterminate" in (one.case, other.case) and len(one.motions) != len(other.motions):
        return True  # the number of representatives of a continuum is not promised
    left = list(zip(other.motions, other.is_open, strict=True))
    for a, is_open in zip(one.motions, one.is_open, strict=True):
        same = [
            k
            for k, (c, other_open) in enumerate(left)
            if is_open == other_open and np.allclose(a, c, rtol=1e-7, atol=1e-8 * scale)
        ]
        if not same:
            return False
        del left[same[0]]
    return not left


# ---- made-up problems ----


def planar(rng: np.random.Generator, n: int) -> Problem:
    """Return a planar problem of small integers, often of low rank and on a border."""
    size = 2 * n
    full = n > 1 and rng.random() < 0.2
    rank = size if full else int(rng.integers(1, size + 1))
    return with_root(rng, rng.integers(-2, 3, size=(size, rank)))


def with_root(rng: np.random.Generator, L: np.ndarray) -> Problem:
    """Return a planar problem with the mobility L Lᵀ."""
    W, size = L @ L.T, len(L)
    n = size // 2
    inside = rng.random() < 0.5
    b = W @ rng.integers(-2, 3, size=size) if inside else rng.integers(-3, 4, size=size)
    mu = [FRICTIONS[rng.integers(4)] for _ in range(n)]
    slip = [[int(rng.choice([0, 0, 1, -1]))] for _ in range(n)]
    closed = [bool(rng.random() < 0.2) for _ in range(n)]
    at = int(rng.integers(n))
    if rng.random() < 0.25 and W[2 * at, 2 * at + 1]:
        mu[at] = Fraction(int(W[2 * at, 2 * at]), abs(int(W[2 * at, 2 * at + 1])))  # A = 0
    return Problem(W, b, mu, slip, closed)


def in_units(rng: np.random.Generator, problem: Problem) -> Problem:
    """Return a planar problem in other units, and each row in one of its own."""
    d = 10.0 ** rng.uniform(-1, 1, size=len(problem.b))
    mass, time = 10.0 ** rng.uniform(-4, 4, size=2)
    mu = [float(m) * d[2 * i] / d[2 * i + 1] for i, m in enumerate(problem.mu)]
    W, b = problem.W * np.outer(d, d) * mass, problem.b * d * time
    return Problem(W, b, mu, problem.slip, problem.closed)


def nearly(rng: np.random.Generator, problem: Problem) -> Problem:
    """Return a planar problem beside the given one, by 1e-4 to 1e-16."""
    size, step = len(problem.b), 10.0 ** -rng.integers(4, 17)
    root = rng.normal(size=(size, size))
    b = problem.b + step * rng.normal(size=size) * (rng.random() < 0.5)
    mu = [float(m) * (1 + step * rng.normal()) for m in problem.mu]
    return Problem(problem.W + step * root @ root.T, b, mu, problem.slip, problem.closed)


def spatial(rng: np.random.Generator, n: int) -> Problem:
    """Return a problem of discs, of small integers."""
    size = 3 * n
    L = rng.integers(-2, 3, size=(size, int(rng.integers(1, size + 1))))
    W = (L @ L.T).astype(float)
    inside = rng.random() < 0.5
    b = W @ rng.integers(-2, 3, size=size) if inside else rng.integers(-3, 4, size=size)
    mu = [float(FRICTIONS[rng.integers(4)]) for _ in range(n)]
    w = float(np.hypot(*W[0, 1:3]))
    if rng.random() < 0.2 and w:
        mu[0] = W[0, 0] / w
    moving = rng.random(n) < 0.4
    slip = [rng.integers(-1, 2, size=2) * moves for moves in moving]
    return Problem(W, b.astype(float), mu, slip, [bool(rng.random() < 0.2) for _ in range(n)])


def with_discs(rng: np.random.Generator, problem: Problem) -> tuple[Problem, list[int]]:
    """Return a planar problem with discs, whose second tangents are not coupled, and its rows."""
    n = len(problem.mu)
    tangents = [int(rng.integers(1, 3)) for _ in range(n)]
    tangents[0] = 2
    starts = np.cumsum([0, *(1 + t for t in tangents)]).tolist()
    rows = [row for start in starts[:-1] for row in (start, start + 1)]
    W, b = np.zeros((starts[-1], starts[-1])), np.zeros(starts[-1])
    W[np.ix_(rows, rows)], b[rows] = problem.W, problem.b
    for row in set(range(starts[-1])) - set(rows):
        W[row, row] = rng.integers(1, 4)
    slip = [[*v, 0] if t == 2 else v for v, t in zip(problem.slip, tangents, strict=True)]
    return Problem(W, b, problem.mu, slip, problem.closed), rows


def turned(rng: np.random.Generator, problem: Problem) -> tuple[Problem, np.ndarray]:
    """Return a problem of discs in other tangents, and the map of its vectors to them."""
    n = len(problem.mu)
    turn, slip = np.eye(3 * n), []
    for i in range(n):
        angle = rng.uniform(0, 7)
        c, s = np.cos(angle), np.sin(angle)
        turn[3 * i + 1 : 3 * i + 3, 3 * i + 1 : 3 * i + 3] = [[c, s], [-s, c]]
        slip.append(np.array([[c, s], [-s, c]]) @ problem.slip[i])
    W = turn @ problem.W @ turn.T
    return Problem((W + W.T) / 2, turn @ problem.b, problem.mu, slip, problem.closed), turn


def renumbered(rng: np.random.Generator, problem: Problem) -> tuple[Problem, np.ndarray]:
    """Return a problem of discs in other order and units, mirrored; the map of its motions."""
    n = len(problem.mu)
    order = rng.permutation(n)
    rows = [3 * i + k for i in order for k in range(3)]
    mirror = rng.random(n) < 0.5
    signs = np.ones(3 * n)
    signs[2::3] = np.where(mirror, -1, 1)
    mass, time = 10 ** rng.uniform(-4, 4, size=2)
    W = (problem.W * np.outer(signs, signs))[np.ix_(rows, rows)] * mass
    slip = [np.array(problem.slip[i]) * ([1, -1] if mirror[i] else [1, 1]) for i in order]
    mu, closed = [problem.mu[i] for i in order], [problem.closed[i] for i in order]
    to = np.eye(3 * n)[rows] * signs[None]
    return Problem(W, (signs * problem.b)[rows] * time, mu, slip, closed), time * to
