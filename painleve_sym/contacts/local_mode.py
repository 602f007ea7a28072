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
import functools
import itertools
import math
import operator
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from painleve_sym.complementarity.solution_sets import (
    RANK,
    FloatArray,
    affine_face,
    solve_refined,
    solve_two,
)
from painleve_sym.contact_rows import ContactRows

IntArray = npt.NDArray[np.intp]

CONTACT_LIMIT = 6
"""Most contacts whose local modes are all tried: 4**6 regular systems take a tenth of a second."""

NORMAL, TANGENTIAL = 0, 1
_AXES = ((1.0, 0.0), (0.0, 1.0))
# Rejects only candidates that are certainly wrong; the residual of the others is checked later.
_REJECTION_TOLERANCE = 1e-6
_BORDER = 1e-9  # as parts of forces and of the terms of accelerations, above the residual's 1e-10
_SMALLEST = 2.0**-1000  # of a friction coefficient in a quotient: its inverse is finite
_ROUNDING = 4 * float(np.finfo(float).eps)  # two products and their difference, each rounded once


class ContactMode(enum.StrEnum):
    """Name what the contact does next.

    LIFTOFF
        F_n = 0, F_t = 0, a_n >= 0 (grazing where a_n = 0); unilateral contacts only.
    SLIP_POS
        a_n = 0, F_t = -mu |F_n|: v_t > 0, or v_t = 0 and a_t > 0.
    SLIP_NEG
        a_n = 0, F_t = +mu |F_n|: v_t < 0, or v_t = 0 and a_t < 0.
    SLIP
        In space: a_n = 0, F_t = -mu |F_n| e with e along v_t, or along a_t where v_t = 0.
    STICK
        a_n = 0, a_t = 0 with v_t = 0 and |F_t| <= mu |F_n|, the edge of the cone included.

    F_n > 0 except for LIFTOFF; a bilateral contact has either sign of F_n.
    """

    LIFTOFF = "liftoff"
    SLIP_POS = "slip_pos"
    SLIP_NEG = "slip_neg"
    SLIP = "slip"
    STICK = "stick"


def sign_of(value: float) -> int:
    """Return -1, 0 or +1."""
    return int(value > 0) - int(value < 0)


def slip_mode(direction: float) -> ContactMode:
    """Return the mode of slip along the sign of `direction`, which is not 0."""
    return ContactMode.SLIP_POS if direction > 0 else ContactMode.SLIP_NEG


Vector = list[float]
"""Numbers of a few contacts: Python computes with these faster than NumPy with its arrays."""


@dataclass(frozen=True, eq=False)
class LocalMode:
    """State one piece of the law of one contact, linear in its force F and acceleration a.

    Attributes
    ----------
    mode : ContactMode
        What the contact does.
    directions : tuple of (float, float)
        ``F = sum of x_k directions_k`` with 0, 1 or 2 unknowns x.
    vanishing : tuple of int
        As many entries of a that are 0 (0 normal, 1 tangential).
    cone : tuple of (float, float)
        ``row . F >= 0`` for each row.
    signs : tuple of (int, int)
        ``(entry, sign)`` for ``sign * a_entry >= 0``.
    unit : tuple of float
        By which each x extends, beside a normal force of 1: the friction of a sticking contact is
        at most mu.
    side : int
        Sign of F_n; 0 where it is 0.
    """

    mode: ContactMode
    directions: tuple[tuple[float, float], ...] = ()
    vanishing: tuple[int, ...] = ()
    cone: tuple[tuple[float, float], ...] = ()
    signs: tuple[tuple[int, int], ...] = ()
    unit: tuple[float, ...] = ()
    side: int = 1

    def holds(self, force: Sequence[float], share: Sequence[float]) -> bool:
        """Return whether the force (F_n, F_t) lies in this mode or on its border.

        `share` is a_n, a_t, each as a fraction of its terms.
        """
        normal, tangential = force
        along = len(self.directions) == 2 or not (normal or tangential)
        if len(self.directions) == 1:
            ((way_n, way_t),) = self.directions
            first, second = way_n * tangential, way_t * normal
            along = abs(first - second) <= _BORDER * (abs(first) + abs(second))
        return (
            along
            and all(
                p * normal + q * tangential >= -_BORDER * (abs(p * normal) + abs(q * tangential))
                for p, q in self.cone
            )
            and all(abs(share[entry]) <= _BORDER for entry in self.vanishing)
            and all(sign * share[entry] >= -_BORDER for entry, sign in self.signs)
        )

    @cached_property
    def edges(self) -> tuple[tuple[float, float], ...]:
        """The rows of the cone with a largest entry of one."""
        sizes = [max(abs(p), abs(q)) for p, q in self.cone]
        return tuple((p / s, q / s) for (p, q), s in zip(self.cone, sizes, strict=True))


def lift_off() -> LocalMode:
    """Return ``F = 0, a_n >= 0``."""
    return LocalMode(ContactMode.LIFTOFF, signs=((NORMAL, 1),), side=0)


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
    size = power_of_two(max(1.0, mu))
    way = (1.0 / size, -mu * direction * side / size)
    signs = ((TANGENTIAL, direction),) if at_rest and mu > 0 else ()
    cone = ((float(side), 0.0),)
    return LocalMode(slip_mode(direction), (way,), (NORMAL,), cone, signs, (size,), side)


def stick(mu: float, side: int = 1) -> LocalMode:
    """Return ``a_n = a_t = 0, |F_t| <= mu |F_n|`` with the sign `side` of F_n, for mu > 0."""
    size = max(power_of_two(mu), _SMALLEST)
    edge = side * mu / size
    cone = ((edge, 1.0 / size), (edge, -1.0 / size))
    unit = (1.0, min(1.0, size))
    return LocalMode(ContactMode.STICK, _AXES, (NORMAL, TANGENTIAL), cone, (), unit, side)


# The same few for all states of a mechanism.
@functools.lru_cache(maxsize=256)
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


def power_of_two(size: float) -> float:
    """Return the largest power of two that is no larger than a positive number."""
    return math.ldexp(1.0, math.frexp(size)[1] - 1)


# ---- all combinations ----


class ModePoint(NamedTuple):
    """The forces of one choice of local modes, before any check of their residual.

    Attributes
    ----------
    forces : list of 2 n float
        F_n, F_t contact by contact.
    choice : tuple of int
        The local mode of each contact, by its position in the list given.
    wide : bool
        True where the forces are one point of a segment, ray or wider face of the choice.
    """

    forces: Vector
    choice: tuple[int, ...]
    wide: bool


class _Choice(NamedTuple):
    """A local mode of each contact, by position, and the system that it makes.

    The rows of a that vanish, and the directions of the forces by their columns.
    """

    local: tuple[int, ...]
    rows: list[int]
    columns: list[int]


_Kinds = tuple[tuple[tuple[int, ...], ...], ...]
"""The accelerations that vanish in every local mode of every contact."""


def _listed(kinds: _Kinds) -> list[list[_Choice]]:
    """Return all choices of one local mode for each contact, by their number of unknowns."""
    starts = itertools.accumulate((len(v) for given in kinds for v in given), initial=0)
    columns = [[range(k := next(starts), k + len(v)) for v in given] for given in kinds]
    groups: dict[int, list[_Choice]] = {}
    at = ContactRows(len(kinds))
    for local in itertools.product(*(range(len(given)) for given in kinds)):
        pairs = list(enumerate(local))
        rows = [at.row(i, entry) for i, j in pairs for entry in kinds[i][j]]
        own = [column for i, j in pairs for column in columns[i][j]]
        groups.setdefault(len(rows), []).append(_Choice(local, rows, own))
    return list(groups.values())


# The same for all states in which the same contacts slide.
_choices = functools.lru_cache(maxsize=64)(_listed)
_KEPT = 4**3
"""Most choices that are kept: those of more contacts take memory, and their solution longer."""


class ModeProduct:
    """The linear systems of all choices of one local mode for each contact, solved size by size.

    Systems of one or two unknowns, all that one contact has, are solved number by number; larger
    ones, of which there may be thousands, together.

    Parameters
    ----------
    W : list of 2 n rows
        Mobility of the contacts, scaled to order one.
    b : list of 2 n float
        Accelerations without contact force, scaled to order one.
    modes : sequence of n sequences of LocalMode
        What each contact may do.
    """

    def __init__(self, W: list[Vector], b: Vector, modes: Sequence[Sequence[LocalMode]]) -> None:
        self.W, self.b, self.modes = W, b, modes
        self.rows = ContactRows(len(modes))
        self.pairs = self.rows.each()
        self._largest = max(map(abs, b))
        # Every direction of every local mode: its contact, its force, the accelerations that it
        # causes, and its unit. A sign that rounding left of W_nn - mu s W_nt would be an accident:
        # as in `rounded_difference`.
        self._ways: list[tuple[int, tuple[float, float]]] = []
        self._rates: list[Vector] = []
        self._units: list[float] = []
        for i, (given, pair) in enumerate(zip(modes, self.pairs, strict=True)):
            columns = list(map(operator.itemgetter(*pair), W))
            for mode in given:
                for n, t in mode.directions:
                    self._ways.append((i, (n, t)))
                    self._rates.append(
                        [
                            0.0
                            if abs(v := (p := w * n) + (q := z * t))
                            <= _ROUNDING * (abs(p) + abs(q))
                            else v
                            for w, z in columns
                        ]
                    )
                self._units += mode.unit

    @cached_property
    def ways(self) -> FloatArray:
        """Every direction of every local mode, as columns; shape (2 n, directions)."""
        ways = np.zeros((len(self.b), len(self._ways)))
        for k, (i, way) in enumerate(self._ways):
            ways[self.rows.of(i), k] = way
        return ways

    @cached_property
    def rates(self) -> FloatArray:
        """Accelerations of these directions, as columns; shape (2 n, directions)."""
        return np.array(self._rates).reshape(-1, len(self.b)).T

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
        terms = np.abs(np.array(self.W)) @ np.abs(self.ways)
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
                slips = [m for m in given if m.side == side and len(m.unit) == 1]
                for mode in slips:
                    force = np.zeros(len(self.b))
                    force[self.rows.of(i)] = side * np.array(mode.directions[0])
                    partner = force
                    if len(slips) == 1:  # sliding, or without friction: only F_n a_n = 0 is known
                        partner = np.zeros(len(self.b))
                        n = self.rows.normal(i)
                        partner[n] = force[n]
                    forces.append(force)
                    partners.append(partner)
            yield np.array(partners) @ np.array(self.W) @ np.array(forces).T

    def _groups(self) -> Iterable[Sequence[_Choice]]:
        """Return all choices, those with one number of unknowns together."""
        kinds = tuple(tuple(mode.vanishing for mode in given) for given in self.modes)
        return _choices(kinds) if math.prod(map(len, kinds)) <= _KEPT else _listed(kinds)

    def _blocks(self, choices: Sequence[_Choice]) -> tuple[FloatArray, IntArray, IntArray]:
        """Return the matrices of choices of one size, with their rows and columns."""
        rows = np.array([choice.rows for choice in choices], dtype=np.intp)
        columns = np.array([choice.columns for choice in choices], dtype=np.intp)
        return self.rates[rows[:, :, None], columns[:, None, :]], rows, columns

    def _solve_group(self, choices: Sequence[_Choice]) -> list[ModePoint]:
        """Solve all choices with one number of unknowns: regular ones first, then the others."""
        small = len(choices[0].rows) <= 2
        solved = map(self._solve_small, choices) if small else self._solve_together(choices)
        points: list[ModePoint] = []
        singular: list[_Choice] = []
        ways, none, pairs = self._ways, [0.0] * len(self.b), self.pairs
        for choice, x in zip(choices, solved, strict=True):
            if x is None:
                singular.append(choice)
                continue
            local, _, columns = choice
            forces = none.copy()
            for size, column in zip(x, columns, strict=True):
                i, (normal, tangential) = ways[column]
                n, t = pairs[i]
                forces[n] += size * normal
                forces[t] += size * tangential
            if self._plausible(forces, local):
                points.append(ModePoint(forces, local, False))
        for choice in singular:
            face = self._face(choice)
            if face is not None:
                points.append(face)
        return points

    def _solve_small(self, choice: _Choice) -> Vector | None:
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

    def _solve_together(self, choices: Sequence[_Choice]) -> list[Vector | None]:
        """Return the unknowns of systems of one size, None for those that are singular."""
        blocks, rows, _ = self._blocks(choices)
        stretch = np.linalg.svd(blocks, compute_uv=False)
        regular = stretch[:, -1] > RANK * len(self.b)
        solved = iter(solve_refined(blocks[regular], -np.array(self.b)[rows[regular]]).tolist())
        return [next(solved) if good else None for good in regular]

    def _plausible(self, forces: Vector, local: tuple[int, ...]) -> bool:
        """Return whether forces may satisfy the inequalities of their local modes."""
        doubt = _REJECTION_TOLERANCE * (max(map(abs, forces)) + self._largest)
        for i, j in enumerate(local):
            mode, pair = self.modes[i][j], self.pairs[i]
            normal, tangential = forces[pair[0]], forces[pair[1]]
            for p, q in mode.edges:
                if p * normal + q * tangential < -doubt:
                    return False
            for entry, sign in mode.signs:
                value = self.b[pair[entry]]
                terms = abs(value)
                for w, force in zip(self.W[pair[entry]], forces, strict=True):
                    term = w * force
                    value += term
                    terms += abs(term)
                if sign * value < -_REJECTION_TOLERANCE * terms:
                    return False
        return True

    def _face(self, choice: _Choice) -> ModePoint | None:
        """Return a point of a choice whose system is singular, or None if it has no solution."""
        local, rows, columns = choice
        ways, rates, b = self.ways[:, columns], self.rates[:, columns], np.array(self.b)
        slopes, starts = [np.zeros((0, len(columns)))], [np.zeros(0)]
        for i, j in enumerate(local):
            mode = self.modes[i][j]
            slopes.append(np.array(mode.cone).reshape(-1, 2) @ ways[self.rows.of(i)])
            starts.append(np.zeros(len(mode.cone)))
            for entry, sign in mode.signs:
                row = self.pairs[i][entry]
                slopes.append(sign * rates[[row]])
                starts.append(sign * b[[row]])
        slope, start = np.vstack(slopes), np.concatenate(starts)
        goal, unit = -b[rows], np.array([self._units[column] for column in columns])
        face = affine_face(rates[rows], goal, slope, start, b.size, quick=True, unit=unit)
        if face is None:
            return None
        return ModePoint((ways @ face[0]).tolist(), local, bool(np.any(face[1])))
