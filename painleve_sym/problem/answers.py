"""Every solution of a contact problem: motions, each with the set of its forces.

All choices of one piece for each constraint are tried. A choice whose system is regular leaves one
set of forces; a singular one leaves none, the open forces of one motion, or a continuum of motions.
Each answer is checked by the law, and answers with one motion are one answer.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from painleve_sym.problem.constraints import Constraint, Piece, Vector, pieces
from painleve_sym.problem.families import Family, forces_of_motion
from painleve_sym.problem.law import EDGE, EQUAL, Checked, ScaledLaw, Slips
from painleve_sym.problem.products import CUT, PieceProduct
from painleve_sym.problem.scaling import Placed
from painleve_sym.problem.turning import (
    TurnedLaw,
    TurningChoice,
    count_of_starts,
    directions,
    search,
)

REGULAR = 1e-10
"""Least eigenvalue of W, with a diagonal of ones, at which no forces are open."""
MOST_MEETING = 4**6
"""Most choices of pieces that are tried around given forces."""


class MotionWithForces(NamedTuple):
    """One motion with its forces.

    Attributes
    ----------
    checked : Checked
        Its forces; the shortest where they are open.
    open_forces : int
        In how many directions the forces are open for the same motion.
    moves : bool or None
        Whether the motion is one of a continuum of motions; None where that is not known.
    """

    checked: Checked
    open_forces: int = 0
    moves: bool | None = False


class Answers:
    """The solutions of a scaled law.

    Attributes
    ----------
    all : list of Answer
        By the normal forces.
    searched : bool
        Whether some of them come from a search that proves nothing: two discs that begin to slip.
    """

    def __init__(self, law: ScaledLaw) -> None:
        self.law = law
        self.all: list[MotionWithForces] = []
        self.searched = False
        self._merged = False
        self._families: list[Family] = []
        self._moving: list[tuple[ScaledLaw, Family]] = []
        self._solve()

    # ---- solve ----

    def _solve(self) -> None:
        product = PieceProduct(self.law)
        solved, singular = product.solve()
        for forces, choice in solved:
            self._add(forces, tuple([piece.slips for piece in choice.pieces]))  # type: ignore[misc]
        for choice in singular:
            self._add_family(self.law, Family(self.law, choice.pieces))
        if self._moving:  # choices left out may have another motion of a continuum
            for choice in product.left:
                self._add_family(self.law, Family(self.law, choice.pieces))
        turning = self.law.layout.turning
        if turning:
            self._turn()
        if self.searched and self._missed():
            self._turn(finer=2)
        if self._moving or (
            (singular or product.left or turning or self._merged) and self._may_be_open
        ):
            self._open()
        if len(self.all) > 1:
            self.all = ordered(self.law, self.all)

    def _add(self, forces: Vector, slips: Slips) -> None:
        """Check forces of complete pieces, and add them where their motion is another one."""
        checked = self.law.check(forces, slips)
        if checked is not None:
            self._merge(MotionWithForces(checked))

    def _merge(self, answer: MotionWithForces) -> None:
        motion = answer.checked.motion
        for k, other in enumerate(self.all):
            if self.law.same_motion(motion, other.checked.motion):
                better = answer if answer.checked.residual < other.checked.residual else other
                self._merged = True
                self.all[k] = better._replace(moves=answer.moves or other.moves)
                return
        self.all.append(answer)

    def _add_family(self, law: ScaledLaw, family: Family) -> None:
        """Add the solutions of a singular choice."""
        answer = self._of_family(law, family)
        if answer is not None:
            self._merge(answer)

    def _of_family(self, law: ScaledLaw, family: Family) -> MotionWithForces | None:
        """Return motion and forces of a singular choice; None without, and for a known motion."""
        if not family.reached:
            self._families.append(family)
            return None
        if law is self.law and (len(law.constraints) >= CUT or not family.moves):
            motion = family.only_motion()
            if motion and any(law.same_motion(motion, a.checked.motion) for a in self.all):
                return None
        inside = family.inside()
        if inside is None:
            return None
        forces, moves = inside
        if isinstance(law, TurnedLaw):
            forces = law.back(forces)
        checked = self.law.check(forces)
        if checked is None:
            return None
        if moves:
            self._moving.append((law, family))
        return MotionWithForces(checked, 0, moves)

    @cached_property
    def _may_be_open(self) -> bool:
        """Whether W is singular, so that forces may be open."""
        return self.least_eigenvalue <= REGULAR

    @cached_property
    def least_eigenvalue(self) -> float:
        """The least eigenvalue of W, with a diagonal of ones."""
        W = np.array(self.law.W)
        root = np.sqrt(np.where(np.diag(W) > 0, np.diag(W), 1.0))
        return float(np.linalg.eigvalsh(W / np.outer(root, root))[0])

    def _open(self) -> None:
        """Find out how far the forces of each motion are open."""
        for k, answer in enumerate(self.all):
            moves = answer.moves or any(
                self._contains(law, family, answer.checked) for law, family in self._moving
            )
            dimension, checked = 0, answer.checked
            open_ = forces_of_motion(self.law, answer.checked.motion)
            if open_ is not None and open_[1]:
                forces, dimension = open_
                checked = self.law.check(forces) or checked
            self.all[k] = MotionWithForces(checked, dimension, moves)

    @staticmethod
    def _contains(law: ScaledLaw, family: Family, checked: Checked) -> bool:
        if isinstance(law, TurnedLaw):
            forces: Vector = (law.turn @ np.array(checked.forces)).tolist()
            return family.contains(forces, law.motion(forces))
        return family.contains(checked.forces, checked.motion)

    # ---- discs that begin to slip ----

    def _turn(self, finer: int = 1) -> None:
        """Add the slips of discs at rest; a finer search repeats those of several at once."""
        for chosen in itertools.product(*map(pieces, self.law.constraints)):
            count = sum(len(piece.turning) for piece in chosen)
            if not count:
                continue
            start = TurningChoice(self.law, chosen)
            if count == 1:
                if finer == 1:
                    self._turn_one(start)
            else:
                self.searched = True
                for angles, forces in search(start, finer * count_of_starts(count)):
                    self._add(forces, start.slips(angles))

    def _turn_one(self, start: TurningChoice) -> None:
        samples: list[Checked] = []
        for angle, forces, everywhere in directions(start):
            if forces is None:
                family = start.turned([angle])
                answer = self._of_family(family.law, family)
                if answer is not None and everywhere and not answer.moves:
                    samples.append(answer.checked)
                elif answer is not None:
                    self._merge(answer)
                continue
            checked = self.law.check(forces, start.slips([angle]))
            if checked is None:
                continue
            if everywhere:
                samples.append(checked)
            else:
                self._merge(MotionWithForces(checked))
        # Of all directions some were tried: two motions are a continuum, of which one is kept.
        moves = any(not self.law.same_motion(s.motion, samples[0].motion) for s in samples)
        if samples:
            self._merge(MotionWithForces(samples[len(samples) // 2 if moves else 0], 0, moves))

    # ---- about all answers ----

    @cached_property
    def missed(self) -> bool:
        """Whether the number of solutions proves that a search missed some."""
        return self._missed()

    def _missed(self) -> bool:
        """Return whether the number of solutions so far is impossible.

        Where all rest, all may open, and W is positive definite, the number of isolated solutions
        that lie on no border is odd.
        """
        law = self.law
        if not self.searched or any(not c.opens for c in law.constraints):
            return False
        if any(ball.slip and ball.mu for c in law.constraints for ball in c.balls):
            return False
        if len(self.all) % 2 or any(a.moves or a.open_forces for a in self.all):
            return False
        return self.least_eigenvalue > REGULAR and not self._borders()

    @cached_property
    def borders(self) -> frozenset[str]:
        """The borders that the problem lies on, within some 1e-8: 'grazing', 'edge', 'infinity'.

        At a border the case of a neighbouring problem is another one.
        """
        return frozenset(self._borders())

    def _borders(self) -> set[str]:
        met = set[str]()
        for answer in self.all:
            if not (answer.open_forces or answer.moves):
                met |= self.law.borders(answer.checked)
        if any(family.at_infinity() for family in self._families):
            met.add("infinity")
        return met


def ordered(law: ScaledLaw, answers: list[MotionWithForces]) -> list[MotionWithForces]:
    """Return the answers by their normal forces, then by the others.

    Forces that differ by rounding alone are equal here: it must not decide the order.
    """
    first = [c.normal for c in law.constraints]
    rows = first + [row for row in range(len(law.b)) if row not in first]
    columns = list(zip(*(answer.checked.forces for answer in answers), strict=True))
    ranks = [_levels(columns[row]) for row in rows]
    return [answers[k] for k in sorted(range(len(answers)), key=lambda k: [r[k] for r in ranks])]


def _levels(values: Sequence[float]) -> list[int]:
    """Return the rank of each value, the same for values that differ by rounding alone."""
    near = EQUAL * max(map(abs, values))
    ranks, level, last = [0] * len(values), 0, -math.inf
    for k in sorted(range(len(values)), key=values.__getitem__):
        level += values[k] - last > near
        ranks[k], last = level, values[k]
    return ranks


def openness(law: ScaledLaw, checked: Checked) -> tuple[int, bool | None]:
    """Return in how many directions checked forces are open, and whether their motion is.

    The latter is None where too many pieces meet.
    """
    dimension, moves = 0, False
    open_ = forces_of_motion(law, checked.motion)
    if open_ is not None:
        dimension = open_[1]
    meeting = [_meeting(law, checked, *each) for each in law.each]
    if math.prod(map(len, meeting)) > MOST_MEETING:
        return dimension, None
    for chosen in itertools.product(*meeting):
        family = Family(law, chosen)
        if family.reached and family.moves and family.contains(checked.forces, checked.motion):
            inside = family.inside()
            moves = moves or bool(inside and inside[1])
    return dimension, moves


def _meeting(
    law: ScaledLaw, checked: Checked, constraint: Constraint, n: int, balls: Placed
) -> list[Piece]:
    """Return the linear pieces of a constraint that may hold the forces, borders included."""
    forces, (_, lengths, terms) = checked.forces, checked.motion
    pressing = forces[constraint.normal]
    still = law.is_zero(n, lengths[n], terms)
    meeting = []
    for piece in pieces(constraint):
        if not piece.side:
            fits = pressing == 0
        else:
            fits = still and pressing * piece.side >= 0 and not piece.turning
            for (ball, k), way in zip(balls, piece.slips, strict=True):
                size = math.hypot(*(forces[t] for t in ball.rows))
                at_rest = ball.mu and not ball.slip
                if at_rest and not way:
                    fits = fits and law.is_zero(k, lengths[k], terms)
                elif at_rest:
                    fits = fits and size >= ball.mu * abs(pressing) * (1 - EDGE)
        if fits:
            meeting.append(piece)
    return meeting
