"""Slip of discs of friction that begins at rest, in directions that the problem does not give.

One such disc, whatever the other constraints do, has its directions at the roots of a quartic
(`disc_slip`). Two or more at once are searched by Newton's method on the torus of their directions:
no finite number of starts proves that none was missed.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property

import numpy as np

from painleve_sym.problem.complementarity.solution_sets import RANK, FloatArray
from painleve_sym.problem.constraints import Piece, Vector, pressed
from painleve_sym.problem.disc_slip import BESIDE, quartic_angles, slips, wave_of
from painleve_sym.problem.families import Family
from painleve_sym.problem.law import ScaledLaw, Slips

_STARTS = {2: 32, 3: 10}  # for each angle but one; fewer for more
_ITERATIONS = 25
_CONVERGED = 1e-12  # of the size of the equations
_APART = 1e-7  # rad; nearer ends of the search are one

Turning = tuple[int, int]
"""A constraint, and one of its balls, whose slip begins in an unknown direction."""


class TurningChoice:
    """A choice of pieces, in some of which a disc slips in a direction that is not known.

    Its forces are ``G x`` with one column for each turning ball more: its friction, by direction.
    """

    def __init__(self, law: ScaledLaw, chosen: Sequence[Piece]) -> None:
        self.law, self.chosen = law, list(chosen)
        self.turning = [(i, k) for i, piece in enumerate(chosen) for k in piece.turning]

    @cached_property
    def family(self) -> Family:
        """The choice without the friction of the turning balls."""
        return Family(self.law, self.chosen)

    def slips(self, angles: Sequence[float]) -> Slips:
        """Return the directions of slip of all balls, those of the turning ones by their angles."""
        ways = [list(piece.slips) for piece in self.chosen]
        for (i, k), angle in zip(self.turning, angles, strict=True):
            ways[i][k] = (math.cos(angle), math.sin(angle))
        return tuple(map(tuple, ways))  # type: ignore[arg-type]

    def turned(self, angles: Sequence[float]) -> Family:
        """Return the choice as a linear one, in axes along the directions of slip."""
        law = TurnedLaw(self.law, self.turning, angles)
        complete, across = list(self.chosen), []
        for i, k in self.turning:
            ways = list(complete[i].slips)
            ways[k] = (1.0, 0.0)
            complete[i] = pressed(law.constraints[i], complete[i].side, tuple(ways))
            across.append(law.constraints[i].balls[k].rows[1])
        return Family(law, complete, across)


class TurnedLaw(ScaledLaw):
    """The law in axes that are turned about the normals of some discs."""

    def __init__(self, law: ScaledLaw, turning: Sequence[Turning], angles: Sequence[float]) -> None:
        own = "groups", "beta", "arrays"
        vars(self).update({k: v for k, v in vars(law).items() if k not in own})
        self.turn = np.eye(len(law.b))
        W, b = np.array(law.W), np.array(law.b)
        for (i, k), angle in zip(turning, angles, strict=True):
            s, t = law.constraints[i].balls[k].rows
            c, v = math.cos(angle), math.sin(angle)
            self.turn[np.ix_([s, t], [s, t])] = [[c, v], [-v, c]]
        W, b = self.turn @ W @ self.turn.T, self.turn @ b
        # Below the rounding of the ball's length, not of the entry's own terms.
        sizes = np.array(law.part_sizes)[np.ix_(law.row_part, law.row_part)]
        W[np.abs(W) <= RANK * sizes] = 0.0
        b[np.abs(b) <= RANK * np.array(law.offsets)[law.row_part]] = 0.0
        self.W, self.b = ((W + W.T) / 2).tolist(), b.tolist()

    def back(self, forces: Vector) -> Vector:
        """Return forces in the axes of the problem."""
        turned: Vector = (self.turn.T @ np.array(forces)).tolist()
        return turned


# ---- one ----


def directions(start: TurningChoice) -> Iterator[tuple[float, Vector | None, bool]]:
    """Yield the directions in which the one turning disc of a choice may begin to slip.

    With the forces, None where the direction alone is known; and whether it is one of a continuum.
    """
    ((i, k),) = start.turning
    constraint = start.law.constraints[i]
    mu = constraint.balls[k].mu
    eliminated = _eliminated(start)
    if eliminated is None:
        yield from _bordered(start)
        return
    reduced, offset, completed = eliminated
    for angle, normal, everywhere in slips(reduced, offset, mu):
        forces: Vector | None = None
        if normal is not None:
            if normal < 0 or (normal == 0 and constraint.opens):
                continue
            c, s = math.cos(angle), math.sin(angle)
            forces = completed(normal, -mu * normal * c, -mu * normal * s)
            angle, forces = _polished(start, angle, forces)
        yield angle, forces, everywhere


Completed = Callable[[float, float, float], Vector]
"""Forces of all constraints by F_n and the friction of one disc."""


def _eliminated(start: TurningChoice) -> tuple[list[Vector], Vector, Completed] | None:
    """Return W and b of the turning disc where the others follow it, and their forces.

    None where they have a motion of their own.
    """
    law = start.law
    ((i, k),) = start.turning
    piece, n, (s, t) = start.chosen[i], law.constraints[i].normal, law.constraints[i].balls[k].rows
    at = [n, s, t]
    if sum(len(p.directions) for p in start.chosen) == len(piece.directions[0].rows) == 1:

        def alone(normal: float, first: float, second: float) -> Vector:
            forces = [0.0] * len(law.b)
            forces[n], forces[s], forces[t] = piece.side * normal, first, second
            return forces

        W = [law.W[row] for row in at]
        own_block = [[piece.side * row[n], row[s], row[t]] for row in W]
        return own_block, [law.b[row] for row in at], alone
    family = start.family
    before = sum(len(p.directions) for p in start.chosen[:i])
    own = piece.side * family.G[:, before] / family.G[n, before]
    others = np.delete(family.G, before, axis=1)
    rows = [row for row in family.rows if row != n]
    b = family.b
    drives = np.column_stack([family.W @ own, family.W[:, [s, t]]])
    rates = np.delete(family.rates, before, axis=1)
    block = rates[rows]
    used, columns = _independent(block)
    if len(columns) < block.shape[1] and _null_moves(block, rates):
        return None
    goal = np.column_stack([drives[rows], b[rows]])[used]
    tied = np.linalg.solve(block[np.ix_(used, columns)], goal)
    follow = rates[:, columns]

    def completed(normal: float, first: float, second: float) -> Vector:
        drive = np.array([normal, first, second, 1.0])
        forces: FloatArray = normal * own - others[:, columns] @ (tied @ drive)
        forces[[s, t]] += drive[1:3]
        return [float(f) for f in forces]

    reduced = (drives[at] - follow[at] @ tied[:, :3]).tolist()
    return reduced, (b[at] - follow[at] @ tied[:, 3]).tolist(), completed


def _independent(block: FloatArray) -> tuple[list[int], list[int]]:
    """Return rows and columns of a regular block of full rank."""
    if not block.size:
        return [], []
    stretch = np.linalg.svd(block, compute_uv=False)
    least = RANK * max(len(block), 3)
    if stretch[-1] > least and block.shape[0] == block.shape[1]:
        return list(range(len(block))), list(range(len(block)))
    rest, rows, columns = block.copy(), list[int](), list[int]()
    for _ in range(min(block.shape)):
        i, j = np.unravel_index(int(np.argmax(np.abs(rest))), rest.shape)
        if abs(rest[i, j]) <= least:
            break
        rows.append(int(i))
        columns.append(int(j))
        rest = rest - np.outer(rest[:, j], rest[i]) / rest[i, j]
    return rows, columns


def _null_moves(block: FloatArray, rates: FloatArray) -> bool:
    _, stretch, right = np.linalg.svd(block)
    rank = int(np.sum(stretch > RANK * max(len(block), 3)))
    null = right[rank:].T
    return bool(null.shape[1]) and bool(np.max(np.abs(rates @ null)) > 1e-10)


def _bordered(start: TurningChoice) -> Iterator[tuple[float, Vector | None, bool]]:
    """Yield the directions where the equations of the choice have a solution at all.

    There is one equation more than unknowns, so the matrix with the right side is singular; its
    determinant is a trigonometric polynomial of degree two.
    """

    def determinant(angle: float) -> float:
        family = start.turned([angle])
        return float(np.linalg.det(np.column_stack([family.block, family.b[family.rows]])))

    wave = wave_of(determinant)
    scale = max(1.0, start.law.constraints[start.turning[0][0]].balls[start.turning[0][1]].mu)
    everywhere = wave.size <= 1e-13 * scale
    angles = [] if everywhere else wave.zeros()
    if everywhere:  # samples, each with neighbours: two motions make a continuum
        ring = [2 * math.pi * k / 16 for k in range(16)] + _special(start, *start.turning[0])
        angles = [angle + side * BESIDE for angle in ring for side in (0, -1, 1)]
    for angle in angles:
        yield angle, None, everywhere


# ---- the whole system ----


class _System:
    """Equations of a choice with turning discs: vanishing rows, and no acceleration across.

    The unknowns are x and the angles; shapes (s, k) and (s, m) for s trials at once.
    """

    def __init__(self, start: TurningChoice) -> None:
        law, family = start.law, start.family
        self.W, self.b, self.G = family.W, family.b, family.G
        self.rows = family.rows
        self.columns, self.mu = list[int](), list[float]()
        self.normals, self.tangents = list[int](), list[list[int]]()
        for i, k in start.turning:
            ball = law.constraints[i].balls[k]
            column, n = sum(len(p.directions) for p in start.chosen[:i]), law.constraints[i].normal
            self.columns.append(column)
            # Friction follows in the unit of F_n.
            self.mu.append(ball.mu * start.chosen[i].side * float(self.G[n, column]))
            self.normals.append(n)
            self.tangents.append(list(ball.rows))

    def forces(self, x: FloatArray, angles: FloatArray) -> FloatArray:
        """Return forces by rows, shape (s, r)."""
        forces: FloatArray = x @ self.G.T
        for j, (column, mu, (p, q)) in enumerate(
            zip(self.columns, self.mu, self.tangents, strict=True)
        ):
            forces[:, p] -= mu * x[:, column] * np.cos(angles[:, j])
            forces[:, q] -= mu * x[:, column] * np.sin(angles[:, j])
        return forces

    def defects(self, x: FloatArray, angles: FloatArray) -> FloatArray:
        """Return the residuals of the equations, shape (s, k + m)."""
        a = self.forces(x, angles) @ self.W + self.b
        parts = [a[:, self.rows]]
        for j, (p, q) in enumerate(self.tangents):
            across = a[:, q] * np.cos(angles[:, j]) - a[:, p] * np.sin(angles[:, j])
            parts.append(across[:, None])
        return np.hstack(parts)

    def sizes(self, x: FloatArray, angles: FloatArray) -> FloatArray:
        """Return the sizes of the terms of the equations, shape (s, k + m)."""
        terms = np.abs(self.forces(x, angles)) @ np.abs(self.W) + np.abs(self.b)
        across = [(terms[:, q] + terms[:, p])[:, None] for p, q in self.tangents]
        return np.hstack([terms[:, self.rows], *across])

    def slopes(self, x: FloatArray, angles: FloatArray) -> FloatArray:
        """Return the derivatives of the defects by x and the angles."""
        count, k, m = len(x), self.G.shape[1], len(self.columns)
        a = self.forces(x, angles) @ self.W + self.b
        ways = np.repeat(self.G[None], count, axis=0)
        turns = np.zeros((count, len(self.b), m))
        for j, (column, mu, (p, q)) in enumerate(
            zip(self.columns, self.mu, self.tangents, strict=True)
        ):
            c, s = np.cos(angles[:, j]), np.sin(angles[:, j])
            ways[:, p, column] -= mu * c
            ways[:, q, column] -= mu * s
            turns[:, p, j] = mu * x[:, column] * s
            turns[:, q, j] = -mu * x[:, column] * c
        moved = self.W @ np.concatenate([ways, turns], axis=2)
        slope = np.empty((count, len(self.rows) + m, k + m))
        slope[:, : len(self.rows)] = moved[:, self.rows]
        for j, (p, q) in enumerate(self.tangents):
            c, s = np.cos(angles[:, j]), np.sin(angles[:, j])
            row = moved[:, q] * c[:, None] - moved[:, p] * s[:, None]
            row[:, k + j] -= a[:, q] * s + a[:, p] * c
            slope[:, len(self.rows) + j] = row
        return slope

    def completed(self, around: FloatArray, last: int) -> FloatArray:
        """Return angles in which the one of disc `last` follows from the others, shape (4 s, m)."""
        count = len(around)
        angles = np.insert(around, last, 0.0, axis=1)
        ways = np.repeat(self.G[None], count, axis=0)
        for j, (column, mu, (p, q)) in enumerate(
            zip(self.columns, self.mu, self.tangents, strict=True)
        ):
            if j != last:
                ways[:, p, column] -= mu * np.cos(angles[:, j])
                ways[:, q, column] -= mu * np.sin(angles[:, j])
        column, mu, tangents = self.columns[last], self.mu[last], self.tangents[last]
        n = self.normals[last]
        others = [j for j in range(self.G.shape[1]) if j != column]
        rows = [row for row in self.rows if row != n]
        rates = self.W @ ways
        drives = np.empty((count, len(self.b), 3))
        drives[:, :, 0], drives[:, :, 1:] = rates[:, :, column], self.W[:, tangents]
        goal = np.concatenate(
            [drives[:, rows], np.broadcast_to(self.b[rows, None], (count, len(rows), 1))], axis=2
        )
        tied = np.linalg.pinv(rates[:, rows][:, :, others], rcond=1e-10) @ goal
        at = [n, *tangents]
        follow = rates[:, at][:, :, others]
        reduced = drives[:, at] - follow @ tied[:, :, :3]
        offset = self.b[at] - (follow @ tied[:, :, 3:])[..., 0]
        roots = quartic_angles(reduced, offset, mu)
        full = np.repeat(angles, roots.shape[1], axis=0)
        full[:, last] = roots.ravel()
        return full

    def newton(
        self, x: FloatArray, angles: FloatArray, steps: int
    ) -> tuple[FloatArray, FloatArray]:
        """Return x and angles after some of Newton's steps, each taken as it is."""
        k = x.shape[1]
        for _ in range(steps):
            step = _solved(self.slopes(x, angles), self.defects(x, angles))
            x = x - step[:, :k]
            angles = angles - np.clip(step[:, k:], -1.0, 1.0)
        return x, angles


def _solved(slopes: FloatArray, missed: FloatArray) -> FloatArray:
    try:
        return np.asarray(np.linalg.solve(slopes, missed[..., None])[..., 0], dtype=np.float64)
    except np.linalg.LinAlgError:  # one of them is singular
        return np.asarray((np.linalg.pinv(slopes) @ missed[..., None])[..., 0], dtype=np.float64)


def _polished(start: TurningChoice, angle: float, forces: Vector) -> tuple[float, Vector]:
    """Return direction and forces after a Newton step of the whole system, where that is better.

    Elimination of the other constraints leaves more of an equation than its rounding.
    """
    k = sum(len(piece.directions) for piece in start.chosen)
    if sum(len(piece.vanishing) for piece in start.chosen) != k or k < 2:
        return angle, forces
    system = _System(start)
    alone = np.array(forces)
    alone[system.tangents[0]] = 0.0
    x = np.asarray(np.linalg.lstsq(system.G, alone, rcond=None)[0][None], dtype=np.float64)
    at = np.array([[angle]])
    missed, sizes = system.defects(x, at), system.sizes(x, at)
    step = _solved(system.slopes(x, at), missed)
    new, turned = x - step[:, :k], at - step[:, k:]
    after = system.defects(new, turned)
    sizes = np.where(sizes > 0, sizes, 1.0)
    if not np.max(np.abs(after) / sizes) < np.max(np.abs(missed) / sizes):
        return angle, forces
    return float(turned[0, 0]), system.forces(new, turned)[0].tolist()


# ---- several ----


def search(start: TurningChoice, starts: int) -> Iterator[tuple[list[float], Vector]]:
    """Yield directions and forces of several turning discs to which Newton's method converged.

    All directions but one go around a grid of `starts` angles each; the last one then follows from
    its quartic. Each disc is the last one in turn.
    """
    system = _System(start)
    m, k = len(start.turning), system.G.shape[1]
    ring = 2 * math.pi * (np.arange(starts) + 0.25) / starts
    around = np.array(list(itertools.product(ring, repeat=m - 1)))
    grids = [system.completed(around, last) for last in range(m)]
    special = [_special(start, i, ball) for i, ball in start.turning]
    grids.append(np.array(list(itertools.product(*special))))
    grid = np.vstack(grids)
    slopes = system.slopes(np.ones((len(grid), k)), grid)[:, : len(system.rows), :k]
    goal = np.broadcast_to(system.b[system.rows], (len(grid), len(system.rows)))
    x = -(np.linalg.pinv(slopes, rcond=1e-10) @ goal[..., None])[..., 0]
    with np.errstate(all="ignore"):
        x, angles = system.newton(x, grid.copy(), _ITERATIONS)
        good = np.isfinite(x).all(axis=1) & np.isfinite(angles).all(axis=1)
        x, angles = x[good], angles[good]
        missed, sizes = system.defects(x, angles), system.sizes(x, angles)
    good = (np.abs(missed) <= _CONVERGED * sizes + 1e-300).all(axis=1)
    sides = np.sign([start.chosen[i].side for i, _ in start.turning])
    good &= np.all(x[:, system.columns] * sides > 0, axis=1)
    angles = angles[good]
    forces = system.forces(x[good], angles)
    largest = np.abs(forces).max(axis=1, keepdims=True, initial=0.0)
    points = np.hstack([np.cos(angles), np.sin(angles), forces / (1 + largest)])
    known: list[int] = []
    for i, point in enumerate(points):
        if (np.abs(points[known] - point).max(axis=1, initial=0.0) <= _APART).any():
            continue
        known.append(i)
        yield np.angle(np.exp(1j * angles[i])).tolist(), forces[i].tolist()


def count_of_starts(turning: int) -> int:
    """Return how many starts each angle has for a number of turning discs."""
    return _STARTS.get(turning, 5)


def _special(start: TurningChoice, i: int, k: int) -> list[float]:
    """Return directions that a singular mobility may single out: of b_t and of the couplings."""
    law = start.law
    p, q = law.constraints[i].balls[k].rows
    angles = set()
    for x, y in [(law.b[p], law.b[q])] + [
        (row[p], row[q]) for row in (law.W[c.normal] for c in law.constraints)
    ]:
        if x or y:
            angles |= {round(math.atan2(y, x), 12), round(math.atan2(-y, -x), 12)}
    return sorted(angles) or [0.0]
