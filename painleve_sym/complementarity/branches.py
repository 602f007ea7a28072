"""Planar contacts with Coulomb friction, branch by branch: every combination is one linear system.

The friction law of one contact is piecewise linear. A `Branch` is one of its pieces: the directions
its force ``F = (F_n, F_t)`` may have, the entries of its acceleration ``a = (a_n, a_t)`` that
vanish, and the inequalities in which F and a may still move. With as many directions as vanishing
accelerations, each choice of one branch for every contact turns ``a = W F + b`` into a square
linear system; trying all choices finds every consistent set of forces.

Signs are those of `contact`: F_n > 0 pushes the bodies apart, F_t and a_t count along v_t.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from painleve_sym.complementarity.faces import RANK, BoolArray, FloatArray, affine_face

IntArray = npt.NDArray[np.intp]

NORMAL, TANGENTIAL = 0, 1
# Refuses only what is beyond doubt wrong; what passes is measured by its residual afterwards.
_DOUBT = 1e-6
_BORDER = 1e-9  # as parts of forces and of the terms of accelerations, above the residual's 1e-10


@dataclass(frozen=True, eq=False)
class Branch:
    """State one piece of the law of one contact, linear in its force F and acceleration a.

    Attributes
    ----------
    directions : ndarray, shape (2, k)
        ``F = directions @ x`` with k = 0, 1 or 2 unknowns x.
    vanishing : tuple of int
        The k entries of a that are 0 (0 normal, 1 tangential).
    cone : ndarray, shape (m, 2)
        ``cone @ F >= 0``.
    signs : tuple of (int, int)
        ``(entry, sign)`` for ``sign * a_entry >= 0``.
    """

    directions: FloatArray
    vanishing: tuple[int, ...] = ()
    cone: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    signs: tuple[tuple[int, int], ...] = ()

    def holds(self, force: FloatArray, W: FloatArray, b: FloatArray) -> bool:
        """Tell whether the force of a single contact, scaled, lies in the branch or on its border.

        Parameters
        ----------
        force : ndarray, shape (2,)
            F_n, F_t.
        W, b : ndarray, shapes (2, 2) and (2,)
            The scaled contact.
        """
        terms = np.abs(W) @ np.abs(force) + np.abs(b)
        share = np.divide(W @ force + b, terms, out=np.zeros(2), where=terms > 0)
        size = np.max(np.abs(force))
        basis = np.linalg.qr(self.directions)[0]
        return bool(
            np.all(np.abs(force - basis @ (basis.T @ force)) <= _BORDER * size)
            and np.all(self.cone @ force >= -_BORDER * size)
            and all(abs(share[entry]) <= _BORDER for entry in self.vanishing)
            and all(sign * share[entry] >= -_BORDER for entry, sign in self.signs)
        )


@dataclass(frozen=True, eq=False)
class BranchPoint:
    """Hold the forces found in one choice of branches, before any check of their residual.

    Attributes
    ----------
    forces : ndarray, shape (2 n,)
        F_n, F_t contact by contact.
    choice : tuple of int
        The branch of each contact, by its position in the list given.
    wide : bool
        True where the forces are one point of a segment, ray or wider face of the choice.
    """

    forces: FloatArray
    choice: tuple[int, ...]
    wide: bool


def lift_off() -> Branch:
    """Return ``F = 0, a_n >= 0``."""
    return Branch(np.zeros((2, 0)), signs=((NORMAL, 1),))


def slip(mu: float, direction: int, at_rest: bool, side: int = 1) -> Branch:
    """Return ``F_t = -mu s |F_n|, a_n = 0``, and ``s a_t >= 0`` where slip only begins.

    Parameters
    ----------
    mu : float
        Friction coefficient; 0 leaves a_t free, since no friction depends on its sign.
    direction : int
        s, the sign of slip.
    at_rest : bool
        Whether v_t = 0.
    side : int
        The sign of F_n; -1 is possible for a bilateral contact only.
    """
    way = np.array([[side], [-mu * direction]], dtype=float) / max(1.0, mu)
    signs = ((TANGENTIAL, direction),) if at_rest and mu > 0 else ()
    return Branch(way, (NORMAL,), np.array([[float(side), 0.0]]), signs)


def stick(mu: float, side: int = 1) -> Branch:
    """Return ``a_n = a_t = 0, |F_t| <= mu |F_n|`` with the sign `side` of F_n."""
    cone = np.array([[side * mu, 1.0], [side * mu, -1.0]]) / max(1.0, mu)
    return Branch(np.eye(2), (NORMAL, TANGENTIAL), cone)


def scale_contacts(
    W: FloatArray, b: FloatArray, mu: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Scale n contacts to order one by powers of two, which rounds nothing.

    Returns
    -------
    W, b, mu : ndarray
        The scaled problem, of the same signs and branches.
    unit : ndarray, shape (2 n,)
        Forces F' of the scaled problem are ``unit * F'`` of the given one.
    """
    # ldexp(1, k // 2) is within a factor two of the root of a number near 2**k.
    half = np.frexp(np.diag(W))[1] // 2
    d = np.where(np.diag(W) > 0, np.ldexp(1.0, half), 1.0)
    offset = b / d
    largest = float(np.max(np.abs(offset)))
    size = float(np.ldexp(1.0, np.frexp(largest)[1])) if largest > 0 else 1.0
    return W / np.outer(d, d), offset / size, mu * d[1::2] / d[0::2], size / d


def branch_forces(
    W: FloatArray, b: FloatArray, branches: Sequence[Sequence[Branch]]
) -> list[BranchPoint]:
    """Find the forces of every choice of branches.

    Parameters
    ----------
    W : ndarray, shape (2 n, 2 n)
        Mobility of the contacts, scaled to order one.
    b : ndarray, shape (2 n,)
        Accelerations without contact force, scaled to order one.
    branches : sequence of n sequences of Branch
        What each contact may do.

    Returns
    -------
    list of BranchPoint
        One for each choice with a solution, and some that miss their inequalities by little: every
        point still needs its check. Forces on the border of two branches appear twice.
    """
    return _Table(W, b, branches).points()


def branch_blocks(
    W: FloatArray, branches: Sequence[Sequence[Branch]]
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield the square matrices of all choices, those of one size k as one array (m, k, k).

    With them the sizes of the terms of each entry, by which a sign left by rounding is known.
    """
    table = _Table(W, np.zeros(len(W)), branches)
    terms = np.abs(W) @ np.abs(table.ways)
    for choices in table.groups():
        blocks, rows, columns = table.blocks(choices)
        yield blocks, terms[rows[:, :, None], columns[:, None, :]]


class _Table:
    """The linear systems of all choices, solved size by size."""

    def __init__(self, W: FloatArray, b: FloatArray, branches: Sequence[Sequence[Branch]]) -> None:
        self.W, self.b, self.branches = W, b, branches
        offered = [(i, branch) for i, given in enumerate(branches) for branch in given]
        ways = [np.zeros((b.size, 0))]
        for i, branch in offered:
            way = np.zeros((b.size, branch.directions.shape[1]))
            way[2 * i : 2 * i + 2] = branch.directions
            ways.append(way)
        self.ways = np.hstack(ways)  # every direction of every branch, as columns
        self.rates = W @ self.ways
        ends = np.cumsum([way.shape[1] for way in ways])
        columns = iter(range(a, z) for a, z in itertools.pairwise(ends))
        self.columns = [[next(columns) for _ in given] for given in branches]

    def groups(self) -> Iterable[list[tuple[int, ...]]]:
        """Return all choices, those with one number of unknowns together."""
        groups: dict[int, list[tuple[int, ...]]] = {}
        for choice in np.ndindex(*map(len, self.branches)):
            groups.setdefault(len(self._index(choice)[0]), []).append(choice)
        return groups.values()

    def points(self) -> list[BranchPoint]:
        """Solve every choice."""
        return [point for choices in self.groups() for point in self._solve_group(choices)]

    def blocks(self, choices: list[tuple[int, ...]]) -> tuple[FloatArray, IntArray, IntArray]:
        """Return the matrices of choices of one size, with their rows and columns."""
        index = np.array([self._index(choice) for choice in choices], dtype=np.intp)
        rows, columns = index[:, 0], index[:, 1]
        return self.rates[rows[:, :, None], columns[:, None, :]], rows, columns

    def _index(self, choice: tuple[int, ...]) -> tuple[list[int], list[int]]:
        """Return the rows of a that vanish and the columns of `ways` in use."""
        rows: list[int] = []
        columns: list[int] = []
        for i, j in enumerate(choice):
            rows += [2 * i + entry for entry in self.branches[i][j].vanishing]
            columns += self.columns[i][j]
        return rows, columns

    def _solve_group(self, choices: list[tuple[int, ...]]) -> list[BranchPoint]:
        """Solve all choices with one number of unknowns: regular ones together, others singly."""
        blocks, rows, columns = self.blocks(choices)
        regular = np.ones(len(choices), bool)
        if rows.shape[1]:
            stretch = np.linalg.svd(blocks, compute_uv=False)
            regular = stretch[:, -1] > RANK * self.b.size
        x = np.linalg.solve(blocks[regular], -self.b[rows[regular]][..., None])[..., 0]
        forces = np.einsum("mk,mkf->mf", x, self.ways.T[columns[regular]])
        kept = self._plausible(forces, np.array(choices, dtype=np.intp)[regular])
        chosen = itertools.compress(choices, regular)
        found = [
            BranchPoint(force, choice, False)
            for force, choice, good in zip(forces, chosen, kept, strict=True)
            if good
        ]
        faces = (self._face(choice) for choice in itertools.compress(choices, ~regular))
        return found + [face for face in faces if face is not None]

    def _plausible(self, forces: FloatArray, choices: IntArray) -> BoolArray:
        """Tell which forces are not certain to break an inequality of their choice."""
        good = np.ones(len(forces), bool)
        accelerations = forces @ self.W.T + self.b
        terms = np.abs(forces) @ np.abs(self.W.T) + np.abs(self.b)
        doubt = _DOUBT * (np.max(np.abs(forces), axis=1) + np.max(np.abs(self.b)))
        for i, given in enumerate(self.branches):
            force = forces[:, 2 * i : 2 * i + 2]
            for j, branch in enumerate(given):
                wrong = np.any(force @ branch.cone.T < -doubt[:, None], axis=1)
                for entry, sign in branch.signs:
                    row = 2 * i + entry
                    wrong |= sign * accelerations[:, row] < -_DOUBT * terms[:, row]
                good &= ~wrong | (choices[:, i] != j)
        return good

    def _face(self, choice: tuple[int, ...]) -> BranchPoint | None:
        """Return a point of a choice whose system is singular, or None if it has no solution."""
        rows, columns = self._index(choice)
        ways, rates = self.ways[:, columns], self.rates[:, columns]
        slopes, starts = [np.zeros((0, len(columns)))], [np.zeros(0)]
        for i, j in enumerate(choice):
            branch = self.branches[i][j]
            slopes.append(branch.cone @ ways[2 * i : 2 * i + 2])
            starts.append(np.zeros(len(branch.cone)))
            for entry, sign in branch.signs:
                slopes.append(sign * rates[[2 * i + entry]])
                starts.append(sign * self.b[[2 * i + entry]])
        slope, start = np.vstack(slopes), np.concatenate(starts)
        size = self.b.size
        face = affine_face(rates[rows], -self.b[rows], slope, start, size, quick=True)
        if face is None:
            return None
        return BranchPoint(ways @ face[0], choice, bool(np.any(face[1])))
