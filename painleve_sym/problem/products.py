"""The linear systems of all choices of one piece for each constraint, solved size by size.

Systems of one or two unknowns, all that one contact in the plane has, are solved number by number;
larger ones, of which there may be thousands, together. Choices whose system is singular are
returned as they are: `families` has them.
"""

from __future__ import annotations

import functools
import itertools
import math
import operator
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from painleve_sym.problem.complementarity.solution_sets import (
    RANK,
    FloatArray,
    solve_refined,
    solve_two,
)
from painleve_sym.problem.constraints import Constraint, Linear, Piece, Vector, linear_pieces
from painleve_sym.problem.law import ScaledLaw, acceleration
from painleve_sym.problem.rank_cut import RankCut
from painleve_sym.problem.rounding import SUM

IntArray = npt.NDArray[np.intp]

# Rejects only candidates that are certainly wrong; the others are checked later.
REJECTION = 1e-6
CUT = 3
"""Constraints from which choices that need not be tried are looked for."""
_KEPT = 4**3
"""Most choices that are kept: those of more contacts take memory, and their solution longer."""


class PieceChoice(NamedTuple):
    """A piece of each constraint, and the system that it makes.

    The rows of a that vanish, and the directions of the forces by their columns.
    """

    pieces: tuple[Piece, ...]
    rows: list[int]
    columns: list[int]


def _listed(offered: Sequence[Sequence[Piece]]) -> list[list[PieceChoice]]:
    """Return all choices of one piece for each constraint, by their number of unknowns."""
    ends = itertools.accumulate(len(piece.directions) for own in offered for piece in own)
    placed = [
        [(piece, range((end := next(ends)) - len(piece.directions), end)) for piece in own]
        for own in offered
    ]
    groups: dict[int, list[PieceChoice]] = {}
    for chosen in itertools.product(*placed):
        rows = [row for piece, _ in chosen for row in piece.vanishing]
        columns = [column for _, own in chosen for column in own]
        choice = PieceChoice(tuple([piece for piece, _ in chosen]), rows, columns)
        groups.setdefault(len(columns), []).append(choice)
    return list(groups.values())


class _Offered(NamedTuple):
    """The pieces of each constraint, the direction of every column, choices if there are few."""

    pieces: tuple[tuple[Piece, ...], ...]
    directions: list[Linear]
    choices: list[list[PieceChoice]] | None


# The same for all states in which the same constraints slide.
@functools.lru_cache(maxsize=128)
def _offered(constraints: tuple[Constraint, ...]) -> _Offered:
    given = tuple(map(linear_pieces, constraints))
    few = math.prod(map(len, given)) <= _KEPT
    directions = [way for own in given for piece in own for way in piece.directions]
    return _Offered(given, directions, _listed(given) if few else None)


class PieceProduct:
    """The linear systems of all choices of one piece for each constraint.

    Parameters
    ----------
    law : ScaledLaw

    Attributes
    ----------
    left : list of PieceChoice
        Singular choices that `solve` leaves out: their forces move nothing, and their motions are
        those of other choices.
    """

    def __init__(self, law: ScaledLaw) -> None:
        self.law, self.W, self.b = law, law.W, law.b
        self.offered, self.directions, self._choices = _offered(law.constraints)
        self.left = list[PieceChoice]()
        # The accelerations that every direction of every piece causes. A sign that rounding left of
        # W_nn - mu s W_nt would be an accident: as in `rounded_difference`.
        self._rates = list(map(self._rate, self.directions))

    def _rate(self, way: Linear) -> Vector:
        """Return the accelerations of a force direction."""
        rows, values = way
        if len(rows) == 2:
            (n, t), (p, q) = rows, values
            return [
                0.0
                if abs(v := (x := row[n] * p) + (y := row[t] * q)) <= SUM * (abs(x) + abs(y))
                else v
                for row in self.W
            ]
        if len(rows) == 1:
            (n,), (p,) = rows, values
            return [row[n] * p for row in self.W]
        # A disc counts by its length, so that its axes do not matter.
        row = self.law.row_part
        lengths = [0.0] * len(self.law.parts)
        for r, v in zip(rows, values, strict=True):
            lengths[row[r]] = math.hypot(lengths[row[r]], v)
        rates = []
        for i, entries in enumerate(self.W):
            total = sum(entries[r] * v for r, v in zip(rows, values, strict=True))
            terms = sum(map(operator.mul, self.law.part_sizes[row[i]], lengths))
            rates.append(0.0 if abs(total) <= 2 * SUM * terms else total)
        return rates

    @cached_property
    def ways(self) -> FloatArray:
        """Every direction of every piece, as columns; shape (r, directions)."""
        ways = np.zeros((len(self.b), len(self.directions)))
        for k, (rows, values) in enumerate(self.directions):
            ways[list(rows), k] = values
        return ways

    @cached_property
    def rates(self) -> FloatArray:
        """Accelerations of these directions, as columns; shape (r, directions)."""
        return np.array(self._rates).reshape(-1, len(self.b)).T

    def solve(self) -> tuple[list[tuple[Vector, PieceChoice]], list[PieceChoice]]:
        """Return the forces of every regular choice, and the choices that are singular.

        Some miss their inequalities by little: every point still needs its check. Forces on the
        border of two pieces appear twice.
        """
        if self._cut is not None:
            return self._solve_small_ones(self._cut)
        points, singular = list[tuple[Vector, PieceChoice]](), list[PieceChoice]()
        for choices in self._groups():
            self._solve_group(choices, points, singular)
        return points, singular

    @cached_property
    def _cut(self) -> RankCut | None:
        """The choices that need not be tried; None where there are few, or all have to be."""
        if self._choices is not None and len(self.offered) < CUT:
            return None
        cut = RankCut(self.law, self.offered, self.ways)
        return cut if cut.applies else None

    def _solve_small_ones(
        self, cut: RankCut
    ) -> tuple[list[tuple[Vector, PieceChoice]], list[PieceChoice]]:
        """Return the same without choices whose motions are those of smaller ones."""
        points, regular = list[tuple[Vector, PieceChoice]](), list[int]()
        for numbers in cut.order(np.flatnonzero(cut.unknowns <= cut.rank)):
            choices = [PieceChoice(*cut.parts(k)) for k in numbers]
            singular = list[PieceChoice]()
            self._solve_group(choices, points, singular)
            without = {id(choice) for choice in singular}
            regular += [k for k, c in zip(numbers, choices, strict=True) if id(c) not in without]
        kept, left = cut.needed(regular)
        self.left = [PieceChoice(*cut.parts(k)) for k in left]
        return points, [PieceChoice(*cut.parts(k)) for k in kept]

    def _solve_group(
        self,
        choices: Sequence[PieceChoice],
        points: list[tuple[Vector, PieceChoice]],
        singular: list[PieceChoice],
    ) -> None:
        """Append the forces of regular choices of one size, and the singular ones."""
        largest = max(map(abs, self.b))
        if choices:
            together = self._solve_together(choices) if len(choices[0].columns) > 2 else None
            for k, choice in enumerate(choices):
                x = together[k] if together else self._solve_small(choice)
                if x is None:
                    singular.append(choice)
                    continue
                forces = self._forces(choice, x)
                if self._plausible(forces, choice, largest):
                    points.append((forces, choice))

    def pieces(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Yield the square matrices of all choices, those of one size k as one array (m, k, k).

        With them the sizes of the terms of each entry, by which a sign left by rounding is known.
        """
        terms = np.abs(np.array(self.W)) @ np.abs(self.ways)
        for choices in self._groups():
            blocks, rows, columns = self._blocks(choices)
            yield blocks, terms[rows[:, :, None], columns[:, None, :]]

    def power_forms(self) -> Iterator[FloatArray]:
        """Yield ``H'WG``: the power of forces on the accelerations that the law ties them to.

        The columns of G are the edges of the friction cones (at rest) or the directions of the
        sliding forces, those of H the same at rest but the normal while sliding. A closed
        constraint has a set of columns for each side, so that there is one form for each choice of
        sides.
        """
        sides = [
            [side for side in (1, -1) if any(m.side == side for m in given)]
            for given in self.offered
        ]
        for chosen in itertools.product(*sides):
            forces, partners = [], []
            for given, side in zip(self.offered, chosen, strict=True):
                slips = [m for m in given if m.side == side and len(m.directions) == 1]
                for mode in slips:
                    force = np.zeros(len(self.b))
                    rows, values = mode.directions[0]
                    force[list(rows)] = side * np.array(values)
                    partner = force
                    if len(slips) == 1:  # sliding, or without friction: only F_n a_n = 0 is known
                        partner = np.zeros(len(self.b))
                        partner[rows[0]] = force[rows[0]]
                    forces.append(force)
                    partners.append(partner)
            yield np.array(partners) @ np.array(self.W) @ np.array(forces).T

    def _groups(self) -> Iterable[Sequence[PieceChoice]]:
        """Return all choices, those with one number of unknowns together."""
        return self._choices or _listed(self.offered)

    def _blocks(self, choices: Sequence[PieceChoice]) -> tuple[FloatArray, IntArray, IntArray]:
        """Return the matrices of choices of one size, with their rows and columns."""
        rows = np.array([choice.rows for choice in choices], dtype=np.intp)
        columns = np.array([choice.columns for choice in choices], dtype=np.intp)
        return self.rates[rows[:, :, None], columns[:, None, :]], rows, columns

    def _forces(self, choice: PieceChoice, x: Sequence[float]) -> Vector:
        """Return the forces of the unknowns of a choice."""
        forces = [0.0] * len(self.b)
        for k, column in enumerate(choice.columns):
            rows, values = self.directions[column]
            for j, row in enumerate(rows):
                forces[row] += x[k] * values[j]
        return forces

    def _solve_small(self, choice: PieceChoice) -> Vector | None:
        """Return the unknowns of a system of at most two, or None where it is singular."""
        _, rows, columns = choice
        if not rows:
            return []
        if len(rows) == 1:
            (row,), (column,) = rows, columns
            rate = self._rates[column][row]
            return [-self.b[row] / rate] if rate else None
        (first, second), (p, q) = rows, columns
        left, right = self._rates[p], self._rates[q]
        block = (left[first], right[first]), (left[second], right[second])
        return solve_two(block, (-self.b[first], -self.b[second]), RANK * len(self.b))

    def _solve_together(self, choices: Sequence[PieceChoice]) -> list[Vector | None]:
        """Return the unknowns of systems of one size, None for those that are singular."""
        blocks, rows, _ = self._blocks(choices)
        stretch = np.linalg.svd(blocks, compute_uv=False)
        regular = stretch[:, -1] > RANK * len(self.b)
        solved = iter(solve_refined(blocks[regular], -np.array(self.b)[rows[regular]]).tolist())
        return [next(solved) if good else None for good in regular]

    def _plausible(self, forces: Vector, choice: PieceChoice, largest: float) -> bool:
        """Return whether forces may satisfy the inequalities of their pieces."""
        doubt = REJECTION * (max(map(abs, forces)) + largest)
        for piece in choice.pieces:
            for rows, values in piece.cone:
                level = 0.0
                for k, row in enumerate(rows):
                    level += values[k] * forces[row]
                if level < -doubt:
                    return False
            for n, ball in piece.discs:
                size = math.hypot(*[forces[t] for t in ball.rows])
                if size > ball.mu * abs(forces[n]) + doubt * (1 + ball.mu):
                    return False
            for rows, values in piece.signs:
                value = terms = 0.0
                for k, row in enumerate(rows):
                    rate, size = acceleration(self.W[row], self.b[row], forces)
                    value += values[k] * rate
                    terms += abs(values[k]) * size
                if value < -REJECTION * terms:
                    return False
        return True
