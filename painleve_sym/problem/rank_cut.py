"""Choices of pieces that a contact problem need not try: smaller ones have their motions.

Forces within cones of friction are sums of multiples of the edges of these. By Carathéodory's
theorem edges whose accelerations are independent are enough for the same accelerations: at most as
many as W has rank, of each contact both, one, or none. Where the forces that the equations of a
choice leave open move nothing, its motion is therefore one of a smaller choice. It is such a choice
where it contains a regular one of as many forces as move independently in it.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from painleve_sym.problem.complementarity.solution_sets import RANK, FloatArray
from painleve_sym.problem.constraints import Constraint, Piece
from painleve_sym.problem.law import ScaledLaw

IntArray = npt.NDArray[np.int64]

_POINTED = 1e-6
"""Least acceleration by forces along the edges, in parts of theirs, where they hold no stress."""
_BITS = 3
"""Of a constraint in a mask: one for each direction of slip, and one for sticking."""


class RankCut:
    """The choices of one piece for each constraint by their numbers, in the order of their product.

    Parameters
    ----------
    law : ScaledLaw
    offered : sequence of sequences of Piece
        Of each constraint.
    ways : ndarray, shape (rows, directions)
        The directions of all pieces, as columns.

    Attributes
    ----------
    rank : int
        Of W: larger choices are singular.
    chosen : ndarray, shape (choices, constraints)
        The piece of each constraint.
    unknowns, mask : ndarray, shape (choices,)
        A choice contains those whose masks have no other bits.
    """

    def __init__(
        self, law: ScaledLaw, offered: Sequence[Sequence[Piece]], ways: FloatArray
    ) -> None:
        self.law, self.offered = law, offered
        values, vectors = np.linalg.eigh(law.arrays[0])
        kept = values > RANK * len(values)
        self.rank = int(kept.sum())
        # Accelerations by orthonormal coordinates of their space.
        self._moved = (vectors[:, kept] * np.sqrt(values[kept])).T @ ways
        ends = itertools.accumulate(len(piece.directions) for own in offered for piece in own)
        self._columns = [
            [list(range((end := next(ends)) - len(piece.directions), end)) for piece in own]
            for own in offered
        ]
        self.chosen = np.indices(tuple(map(len, offered))).reshape(len(offered), -1).T
        self.unknowns = self._sum([[len(columns) for columns in own] for own in self._columns])
        self.mask = self._sum(
            [[_bits(own, k) << _BITS * i for k in range(len(own))] for i, own in enumerate(offered)]
        )

    def _sum(self, numbers: Sequence[Sequence[int]]) -> IntArray:
        """Return the sum of numbers of the pieces of each choice."""
        columns = zip(self.chosen.T, numbers, strict=True)
        total = np.zeros(len(self.chosen), dtype=np.int64)
        for k, own in columns:
            total += np.array(own, dtype=np.int64)[k]
        return total

    @cached_property
    def applies(self) -> bool:
        """Whether there are larger choices, and the theorem holds for them.

        All constraints open, with at most one ball of friction, along one row or in a known
        direction, and no forces within the cones hold each other.
        """
        return (
            bool((self.unknowns > self.rank).any())
            and all(map(_is_simple, self.law.constraints))
            and self._pointed
        )

    @property
    def _pointed(self) -> bool:
        from scipy.optimize import nnls

        edges = [own[0] for of in self._columns for own in of if len(own) == 1]
        moved = self._moved[:, edges]
        sizes = np.linalg.norm(moved, axis=0)
        if not (sizes > _POINTED).all():
            return False
        # The sum of multiples that add up to one, as near to nothing as there is.
        system, goal = np.vstack([moved / sizes, np.ones(len(edges))]), np.zeros(len(moved) + 1)
        goal[-1] = 1.0
        weights, _ = nnls(system, goal)
        return bool(np.linalg.norm(system[:-1] @ weights) > _POINTED * weights.sum())

    def order(self, numbers: IntArray) -> list[list[int]]:
        """Return choices by their number of unknowns, as they first come in the product."""
        groups: dict[int, list[int]] = {}
        for number, size in zip(numbers.tolist(), self.unknowns[numbers].tolist(), strict=True):
            groups.setdefault(size, []).append(number)
        first = {k: int(np.argmax(self.unknowns == k)) for k in groups}
        return [groups[k] for k in sorted(groups, key=first.__getitem__)]

    def parts(self, number: int) -> tuple[tuple[Piece, ...], list[int], list[int]]:
        """Return pieces, vanishing rows and columns of a choice."""
        places = list(enumerate(self.chosen[number].tolist()))
        pieces = tuple([self.offered[i][k] for i, k in places])
        rows = [row for piece in pieces for row in piece.vanishing]
        return pieces, rows, [column for i, k in places for column in self._columns[i][k]]

    def needed(self, regular: Sequence[int]) -> tuple[list[int], list[int]]:
        """Return the singular choices that are to be tried, and those that are not.

        `regular` are the choices that are not singular.
        """
        by_size: dict[int, IntArray] = {
            size: self.mask[np.array(own)]
            for own in self.order(np.array(regular, dtype=np.int64))
            for size in [int(self.unknowns[own[0]])]
        }
        others = np.setdiff1d(np.arange(len(self.mask)), np.array(regular, dtype=np.int64))
        kept, left = list[int](), list[int]()
        for own in self.order(others):
            numbers = np.array(own)
            known = self._contain(numbers, by_size, np.full(len(numbers), self.rank))
            rest = numbers[~known]
            if rest.size:
                columns = np.array([self.parts(k)[2] for k in rest.tolist()], dtype=np.int64)
                stretch = np.linalg.svd(
                    self._moved[:, columns].transpose(1, 0, 2), compute_uv=False
                )
                ranks = (stretch > RANK * len(self.law.b)).sum(axis=1)
                known[~known] = self._contain(rest, by_size, ranks)
            kept += numbers[~known].tolist()
            left += numbers[known].tolist()
        return kept, left

    def _contain(
        self, numbers: IntArray, by_size: Mapping[int, IntArray], ranks: IntArray
    ) -> npt.NDArray[np.bool_]:
        """Return which choices contain a regular one of as many unknowns as their rank."""
        contain = np.zeros(len(numbers), dtype=np.bool_)
        for rank in set(ranks.tolist()):
            own, smaller = ranks == rank, by_size.get(rank)
            if smaller is not None:
                free = ~self.mask[numbers[own]]
                contain[own] = ((smaller[None] & free[:, None]) == 0).any(axis=1)
        return contain


def _is_simple(constraint: Constraint) -> bool:
    balls = [ball for ball in constraint.balls if ball.mu]
    return constraint.opens and len(balls) <= 1 and not any(ball.turns for ball in balls)


def _bits(own: Sequence[Piece], k: int) -> int:
    """Return the mask of a piece: that of sticking contains those of both slips."""
    size = len(own[k].directions)
    if not size:
        return 0
    return 1 << max(k - 1, 0) if size == 1 else 2**_BITS - 1
