"""Local modes of a planar contact with Coulomb friction, and their combinations for n contacts.

The friction law of one contact is piecewise linear. A `LocalMode` is one of its pieces: the
directions its force ``F = (F_n, F_t)`` may have, the entries of its acceleration ``a = (a_n, a_t)``
that vanish, and the inequalities in which F and a may still move. With as many directions as
vanishing accelerations, each choice of one local mode for every contact turns ``a = W F + b`` into
a square linear system; trying all choices finds every consistent set of forces.

Signs: F_n > 0 pushes the bodies apart and a_n > 0 separates them; F_t and a_t count along the slip
velocity v_t. A bilateral contact has both signs of F_n, its two sides, and keeps a_n = 0.
"""

from __future__ import annotations

import enum
import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from painleve_sym.complementarity.solution_sets import (
    RANK,
    BoolArray,
    FloatArray,
    affine_face,
    solve_refined,
)

IntArray = npt.NDArray[np.intp]

NORMAL, TANGENTIAL = 0, 1
# Rejects only candidates that are certainly wrong; the residual of the others is checked later.
_REJECTION_TOLERANCE = 1e-6
_BORDER = 1e-9  # as parts of forces and of the terms of accelerations, above the residual's 1e-10
_SMALLEST = 2.0**-1000  # of a friction coefficient in a quotient: its inverse is finite
_ROUNDING = 4 * float(np.finfo(float).eps)  # two products and their difference, each rounded once


class ContactMode(enum.Enum):
    """Name what the contact does next.

    LIFTOFF
        F_n = 0, F_t = 0, a_n >= 0 (grazing where a_n = 0); unilateral contacts only.
    SLIP_POS
        a_n = 0, F_t = -mu |F_n|: v_t > 0, or v_t = 0 and a_t > 0.
    SLIP_NEG
        a_n = 0, F_t = +mu |F_n|: v_t < 0, or v_t = 0 and a_t < 0.
    STICK
        a_n = 0, a_t = 0 with v_t = 0 and |F_t| <= mu |F_n|, the edge of the cone included.

    F_n > 0 except for LIFTOFF; a bilateral contact has either sign of F_n.
    """

    LIFTOFF = "liftoff"
    SLIP_POS = "slip_pos"
    SLIP_NEG = "slip_neg"
    STICK = "stick"


def slip_mode(direction: float) -> ContactMode:
    """Return the mode of slip along the sign of `direction`, which is not 0."""
    return ContactMode.SLIP_POS if direction > 0 else ContactMode.SLIP_NEG


@dataclass(frozen=True, eq=False)
class LocalMode:
    """State one piece of the law of one contact, linear in its force F and acceleration a.

    Attributes
    ----------
    mode : ContactMode
        What the contact does.
    directions : ndarray, shape (2, k)
        ``F = directions @ x`` with k = 0, 1 or 2 unknowns x.
    vanishing : tuple of int
        The k entries of a that are 0 (0 normal, 1 tangential).
    cone : ndarray, shape (m, 2)
        ``cone @ F >= 0``.
    signs : tuple of (int, int)
        ``(entry, sign)`` for ``sign * a_entry >= 0``.
    unit : ndarray, shape (k,)
        By which x extends, beside a normal force of 1: the friction of a sticking contact is at
        most mu.
    side : int
        Sign of F_n; 0 where it is 0.
    """

    mode: ContactMode
    directions: FloatArray
    vanishing: tuple[int, ...] = ()
    cone: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    signs: tuple[tuple[int, int], ...] = ()
    unit: FloatArray = field(default_factory=lambda: np.zeros(0))
    side: int = 1

    @cached_property
    def unit_cone(self) -> FloatArray:
        """The cone with rows scaled to a largest entry of one."""
        largest = np.max(np.abs(self.cone), axis=1, keepdims=True, initial=0.0)
        cone: FloatArray = self.cone / largest
        return cone

    def holds(self, force: FloatArray, share: FloatArray) -> bool:
        """Return whether the force of the contact lies in this mode or on its border.

        Parameters
        ----------
        force : ndarray, shape (2,)
            F_n, F_t.
        share : ndarray, shape (2,)
            a_n, a_t, each as a fraction of its terms.
        """
        along = not np.any(force)
        if self.directions.shape[1] == 1:
            first, second = self.directions[0, 0] * force[1], self.directions[1, 0] * force[0]
            along = bool(abs(first - second) <= _BORDER * (abs(first) + abs(second)))
        elif self.directions.shape[1] == 2:
            along = True
        terms = np.abs(self.cone) @ np.abs(force)
        return bool(
            along
            and np.all(self.cone @ force >= -_BORDER * terms)
            and all(abs(share[entry]) <= _BORDER for entry in self.vanishing)
            and all(sign * share[entry] >= -_BORDER for entry, sign in self.signs)
        )


def lift_off() -> LocalMode:
    """Return ``F = 0, a_n >= 0``."""
    return LocalMode(ContactMode.LIFTOFF, np.zeros((2, 0)), signs=((NORMAL, 1),), side=0)


def slip(mu: float, direction: int, at_rest: bool, side: int = 1) -> LocalMode:
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
    # Along F_n on both sides, so that the determinants of both orient alike.
    size = _power_of_two(max(1.0, mu))
    way = np.array([[1.0], [-mu * direction * side]]) / size
    signs = ((TANGENTIAL, direction),) if at_rest and mu > 0 else ()
    cone = np.array([[float(side), 0.0]])
    return LocalMode(slip_mode(direction), way, (NORMAL,), cone, signs, np.array([size]), side)


def stick(mu: float, side: int = 1) -> LocalMode:
    """Return ``a_n = a_t = 0, |F_t| <= mu |F_n|`` with the sign `side` of F_n, for mu > 0."""
    size = max(_power_of_two(mu), _SMALLEST)
    cone = np.array([[side * mu, 1.0], [side * mu, -1.0]]) / size
    unit = np.array([1.0, min(1.0, size)])
    return LocalMode(ContactMode.STICK, np.eye(2), (NORMAL, TANGENTIAL), cone, (), unit, side)


def local_modes(mu: float, direction: int, bilateral: bool = False) -> tuple[LocalMode, ...]:
    """Return everything one contact may do at zero normal velocity.

    Parameters
    ----------
    mu : float
        Friction coefficient, >= 0.
    direction : int
        Sign of the slip velocity, 0 at rest.
    bilateral : bool
        Whether the contact holds from both sides: then nothing lifts off and F_n has either sign.
    """
    modes = [] if bilateral else [lift_off()]
    # Without friction no mode depends on the direction.
    ways = (direction,) if direction else (1, -1) if mu > 0 else (1,)
    for side in (1, -1) if bilateral else (1,):
        modes += [slip(mu, s, at_rest=not direction, side=side) for s in ways]
        if not direction and mu > 0:
            modes.append(stick(mu, side))
    return tuple(modes)


def rounded_difference(a: npt.ArrayLike, b: npt.ArrayLike) -> FloatArray:
    """Return ``a - b`` with differences within rounding of their two terms as exactly 0."""
    first, second = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    value = first - second
    return np.where(np.abs(value) <= _ROUNDING * (np.abs(first) + np.abs(second)), 0.0, value)


def scale_contacts(
    W: FloatArray, b: FloatArray, mu: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Scale n contacts to order one by powers of two, which rounds nothing.

    Returns
    -------
    W, b, mu : ndarray
        The scaled problem, of the same signs and local modes.
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


def _power_of_two(size: float) -> float:
    """Return the largest power of two that is no larger than a positive number."""
    return float(np.ldexp(1.0, int(np.frexp(size)[1]) - 1))


# ---- all combinations ----


@dataclass(frozen=True, eq=False)
class ModePoint:
    """Hold the forces of one choice of local modes, before any check of their residual.

    Attributes
    ----------
    forces : ndarray, shape (2 n,)
        F_n, F_t contact by contact.
    choice : tuple of int
        The local mode of each contact, by its position in the list given.
    wide : bool
        True where the forces are one point of a segment, ray or wider face of the choice.
    """

    forces: FloatArray
    choice: tuple[int, ...]
    wide: bool


class ModeProduct:
    """The linear systems of all choices of one local mode for each contact, solved size by size.

    Parameters
    ----------
    W : ndarray, shape (2 n, 2 n)
        Mobility of the contacts, scaled to order one.
    b : ndarray, shape (2 n,)
        Accelerations without contact force, scaled to order one.
    modes : sequence of n sequences of LocalMode
        What each contact may do.
    """

    def __init__(self, W: FloatArray, b: FloatArray, modes: Sequence[Sequence[LocalMode]]) -> None:
        self.W, self.b, self.modes = W, b, modes
        ways, rates, units = [np.zeros((b.size, 0))], [np.zeros((b.size, 0))], [np.zeros(0)]
        for i, given in enumerate(modes):
            for mode in given:
                normal, tangential = (
                    W[:, [2 * i + k]] * mode.directions[k] for k in (NORMAL, TANGENTIAL)
                )
                way = np.zeros((b.size, mode.directions.shape[1]))
                way[2 * i : 2 * i + 2] = mode.directions
                ways.append(way)
                # A sign that rounding left of W_nn - mu s W_nt would be an accident.
                rates.append(rounded_difference(normal, -tangential))
                units.append(mode.unit)
        ends = np.cumsum([unit.size for unit in units])
        columns = iter(range(a, z) for a, z in itertools.pairwise(ends))
        self.ways = np.hstack(ways)  # every direction of every local mode, as columns
        self.rates = np.hstack(rates)
        self.units = np.concatenate(units)
        self.columns = [[next(columns) for _ in given] for given in modes]

    def points(self) -> list[ModePoint]:
        """Return the forces of every choice.

        There is one point for each choice with a solution, and some that miss their inequalities by
        little: every point still needs its check. Forces on the border of two local modes appear
        twice.
        """
        return [point for choices in self._groups() for point in self._solve_group(choices)]

    def pieces(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """Yield the square matrices of all choices, those of one size k as one array (m, k, k).

        With them the sizes of the terms of each entry, by which a sign left by rounding is known.
        """
        terms = np.abs(self.W) @ np.abs(self.ways)
        for choices in self._groups():
            blocks, rows, columns = self._blocks(choices)
            yield blocks, terms[rows[:, :, None], columns[:, None, :]]

    def power_forms(self) -> Iterator[FloatArray]:
        """Yield ``H'WG``: the power of forces on the accelerations that the law ties them to.

        The columns of G are the edges of the friction cones (at rest) or the directions of the
        sliding forces, those of H the same at rest but the normal while sliding. A bilateral
        contact has a set of columns for each side, so that there is one form for each choice of
        sides.
        """
        sides = [
            [side for side in (1, -1) if any(m.side == side for m in given)] for given in self.modes
        ]
        for chosen in itertools.product(*sides):
            forces, partners = [], []
            for i, (given, side) in enumerate(zip(self.modes, chosen, strict=True)):
                slips = [m for m in given if m.side == side and m.unit.size == 1]
                for mode in slips:
                    force = np.zeros(self.b.size)
                    force[2 * i : 2 * i + 2] = side * mode.directions[:, 0]
                    partner = force
                    if len(slips) == 1:  # sliding, or without friction: only F_n a_n = 0 is known
                        partner = np.zeros(self.b.size)
                        partner[2 * i] = side * mode.directions[0, 0]
                    forces.append(force)
                    partners.append(partner)
            yield np.array(partners) @ self.W @ np.array(forces).T

    def _groups(self) -> Iterable[list[tuple[int, ...]]]:
        """Return all choices, those with one number of unknowns together."""
        groups: dict[int, list[tuple[int, ...]]] = {}
        for choice in np.ndindex(*map(len, self.modes)):
            groups.setdefault(len(self._index(choice)[0]), []).append(choice)
        return groups.values()

    def _blocks(self, choices: list[tuple[int, ...]]) -> tuple[FloatArray, IntArray, IntArray]:
        """Return the matrices of choices of one size, with their rows and columns."""
        index = np.array([self._index(choice) for choice in choices], dtype=np.intp)
        rows, columns = index[:, 0], index[:, 1]
        return self.rates[rows[:, :, None], columns[:, None, :]], rows, columns

    def _index(self, choice: tuple[int, ...]) -> tuple[list[int], list[int]]:
        """Return the rows of a that vanish and the columns of `ways` in use."""
        rows: list[int] = []
        columns: list[int] = []
        for i, j in enumerate(choice):
            rows += [2 * i + entry for entry in self.modes[i][j].vanishing]
            columns += self.columns[i][j]
        return rows, columns

    def _solve_group(self, choices: list[tuple[int, ...]]) -> list[ModePoint]:
        """Solve all choices with one number of unknowns: regular ones together, others singly."""
        blocks, rows, columns = self._blocks(choices)
        regular = np.ones(len(choices), bool)
        if rows.shape[1] == 1:
            regular = blocks[:, 0, 0] != 0
        elif rows.shape[1]:
            stretch = np.linalg.svd(blocks, compute_uv=False)
            regular = stretch[:, -1] > RANK * self.b.size
        x = solve_refined(blocks[regular], -self.b[rows[regular]])
        forces = np.einsum("mk,mkf->mf", x, self.ways.T[columns[regular]])
        kept = self._plausible(forces, np.array(choices, dtype=np.intp)[regular])
        chosen = itertools.compress(choices, regular)
        points = [
            ModePoint(force, choice, False)
            for force, choice, good in zip(forces, chosen, kept, strict=True)
            if good
        ]
        faces = (self._face(choice) for choice in itertools.compress(choices, ~regular))
        return points + [face for face in faces if face is not None]

    def _plausible(self, forces: FloatArray, choices: IntArray) -> BoolArray:
        """Return whether each force may satisfy the inequalities of its choice."""
        good = np.ones(len(forces), bool)
        accelerations = forces @ self.W.T + self.b
        terms = np.abs(forces) @ np.abs(self.W.T) + np.abs(self.b)
        doubt = _REJECTION_TOLERANCE * (np.max(np.abs(forces), axis=1) + np.max(np.abs(self.b)))
        for i, given in enumerate(self.modes):
            force = forces[:, 2 * i : 2 * i + 2]
            for j, mode in enumerate(given):
                chosen = choices[:, i] == j
                if not np.any(chosen):
                    continue
                wrong = np.any(force @ mode.unit_cone.T < -doubt[:, None], axis=1)
                for entry, sign in mode.signs:
                    row = 2 * i + entry
                    wrong |= sign * accelerations[:, row] < -_REJECTION_TOLERANCE * terms[:, row]
                good &= ~(wrong & chosen)
        return good

    def _face(self, choice: tuple[int, ...]) -> ModePoint | None:
        """Return a point of a choice whose system is singular, or None if it has no solution."""
        rows, columns = self._index(choice)
        ways, rates = self.ways[:, columns], self.rates[:, columns]
        slopes, starts = [np.zeros((0, len(columns)))], [np.zeros(0)]
        for i, j in enumerate(choice):
            mode = self.modes[i][j]
            slopes.append(mode.cone @ ways[2 * i : 2 * i + 2])
            starts.append(np.zeros(len(mode.cone)))
            for entry, sign in mode.signs:
                slopes.append(sign * rates[[2 * i + entry]])
                starts.append(sign * self.b[[2 * i + entry]])
        slope, start = np.vstack(slopes), np.concatenate(starts)
        goal, unit = -self.b[rows], self.units[columns]
        face = affine_face(rates[rows], goal, slope, start, self.b.size, quick=True, unit=unit)
        if face is None:
            return None
        return ModePoint(ways @ face[0], choice, bool(np.any(face[1])))
