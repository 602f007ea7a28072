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
from painleve_sym.problem.constraints import Linear, Piece, Vector
from painleve_sym.problem.law import ScaledLaw

IntArray = npt.NDArray[np.intp]

# Rejects only candidates that are certainly wrong; the others are checked later.
_REJECTION_TOLERANCE = 1e-6
SUM_ROUNDING = 4 * float(
    np.finfo(float).eps
)  # two products and their difference, each rounded once


class Choice(NamedTuple):
    """A piece of each constraint, by position, and the system that it makes.

    The rows of a that vanish, and the directions of the forces by their columns.
    """

    pieces: tuple[int, ...]
    rows: list[int]
    columns: list[int]


class Solved(NamedTuple):
    """The forces of one choice of pieces, before any check."""

    forces: Vector
    choice: Choice


_Kinds = tuple[tuple[tuple[int, tuple[int, ...]], ...], ...]
"""The number of directions and the accelerations that vanish in every piece of every constraint."""


def _listed(kinds: _Kinds) -> list[list[Choice]]:
    """Return all choices of one piece for each constraint, by their number of unknowns."""
    starts = itertools.accumulate((count for given in kinds for count, _ in given), initial=0)
    columns = [[range(k := next(starts), k + count) for count, _ in given] for given in kinds]
    groups: dict[int, list[Choice]] = {}
    for local in itertools.product(*(range(len(given)) for given in kinds)):
        pairs = list(enumerate(local))
        rows = [row for i, j in pairs for row in kinds[i][j][1]]
        own = [column for i, j in pairs for column in columns[i][j]]
        groups.setdefault(len(own), []).append(Choice(local, rows, own))
    return list(groups.values())


# The same for all states in which the same constraints slide.
_choices = functools.lru_cache(maxsize=64)(_listed)
_KEPT = 4**3
"""Most choices that are kept: those of more contacts take memory, and their solution longer."""


class PieceProduct:
    """The linear systems of all choices of one piece for each constraint.

    Parameters
    ----------
    law : ScaledLaw
    offered : sequence of sequences of Piece
        What each constraint may do.
    """

    def __init__(self, law: ScaledLaw, offered: Sequence[Sequence[Piece]]) -> None:
        self.law, self.offered = law, offered
        self.W, self.b = law.W, law.b
        self._largest = max(map(abs, self.b))
        # Every direction of every piece, the accelerations that it causes, and its unit. A sign
        # that rounding left of W_nn - mu s W_nt would be an accident: as in `rounded_difference`.
        self.directions: list[Linear] = []
        self._rates: list[Vector] = []
        self.units: list[float] = []
        for given in offered:
            for piece in given:
                self.directions += piece.directions
                self._rates += [self._rate(way) for way in piece.directions]
                self.units += piece.units

    def _rate(self, way: Linear) -> Vector:
        """Return the accelerations of a force direction."""
        rows, values = way
        if len(rows) == 2:
            (n, t), (p, q) = rows, values
            return [
                0.0
                if abs(v := (x := row[n] * p) + (y := row[t] * q))
                <= SUM_ROUNDING * (abs(x) + abs(y))
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
            rates.append(0.0 if abs(total) <= 2 * SUM_ROUNDING * terms else total)
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

    def chosen(self, choice: Choice) -> list[Piece]:
        """Return the pieces of a choice."""
        return [given[j] for given, j in zip(self.offered, choice.pieces, strict=True)]

    def solve(self) -> tuple[list[Solved], list[Choice]]:
        """Return the forces of every regular choice, and the choices that are singular.

        Some miss their inequalities by little: every point still needs its check. Forces on the
        border of two pieces appear twice.
        """
        points, singular = list[Solved](), list[Choice]()
        for choices in self._groups():
            small = len(choices[0].columns) <= 2
            solved = map(self._solve_small, choices) if small else self._solve_together(choices)
            for choice, x in zip(choices, solved, strict=True):
                if x is None:
                    singular.append(choice)
                    continue
                forces = self._forces(choice, x)
                if self._plausible(forces, choice):
                    points.append(Solved(forces, choice))
        return points, singular

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

    def _groups(self) -> Iterable[Sequence[Choice]]:
        """Return all choices, those with one number of unknowns together."""
        kinds = tuple(
            tuple((len(piece.directions), piece.vanishing) for piece in given)
            for given in self.offered
        )
        return _choices(kinds) if math.prod(map(len, kinds)) <= _KEPT else _listed(kinds)

    def _blocks(self, choices: Sequence[Choice]) -> tuple[FloatArray, IntArray, IntArray]:
        """Return the matrices of choices of one size, with their rows and columns."""
        rows = np.array([choice.rows for choice in choices], dtype=np.intp)
        columns = np.array([choice.columns for choice in choices], dtype=np.intp)
        return self.rates[rows[:, :, None], columns[:, None, :]], rows, columns

    def _forces(self, choice: Choice, x: Sequence[float]) -> Vector:
        """Return the forces of the unknowns of a choice."""
        forces = [0.0] * len(self.b)
        for size, column in zip(x, choice.columns, strict=True):
            rows, values = self.directions[column]
            for row, value in zip(rows, values, strict=True):
                forces[row] += size * value
        return forces

    def _solve_small(self, choice: Choice) -> Vector | None:
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

    def _solve_together(self, choices: Sequence[Choice]) -> list[Vector | None]:
        """Return the unknowns of systems of one size, None for those that are singular."""
        blocks, rows, _ = self._blocks(choices)
        stretch = np.linalg.svd(blocks, compute_uv=False)
        regular = stretch[:, -1] > RANK * len(self.b)
        solved = iter(solve_refined(blocks[regular], -np.array(self.b)[rows[regular]]).tolist())
        return [next(solved) if good else None for good in regular]

    def _plausible(self, forces: Vector, choice: Choice) -> bool:
        """Return whether forces may satisfy the inequalities of their pieces."""
        doubt = _REJECTION_TOLERANCE * (max(map(abs, forces)) + self._largest)
        for given, j in zip(self.offered, choice.pieces, strict=True):
            piece = given[j]
            for rows, values in piece.cone:
                if sum(v * forces[r] for r, v in zip(rows, values, strict=True)) < -doubt:
                    return False
            for n, ball in piece.discs:
                size = math.hypot(*(forces[t] for t in ball.rows))
                if size > ball.mu * abs(forces[n]) + doubt * (1 + ball.mu):
                    return False
            for form in piece.signs:
                value = terms = 0.0
                for r, v in zip(form.rows, form.values, strict=True):
                    rate, size = self._acceleration(r, forces)
                    value += v * rate
                    terms += abs(v) * size
                if value < -_REJECTION_TOLERANCE * terms:
                    return False
        return True

    def _acceleration(self, row: int, forces: Vector) -> tuple[float, float]:
        """Return one acceleration and the size of its terms."""
        value = self.b[row]
        terms = abs(value)
        for w, force in zip(self.W[row], forces, strict=True):
            term = w * force
            value += term
            terms += abs(term)
        return value, terms
