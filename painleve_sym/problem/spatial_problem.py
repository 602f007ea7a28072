"""Contacts in space, or in space and in the plane together: which forces and accelerations agree.

A contact in space has three rows, n, t1, t2, and a `Disc` of friction; a planar one n, t and an
`Interval`. F_n pushes the bodies apart, a_n separates them, tangential forces and accelerations
count along the tangents, and ``a = W F + b``.

A contact that slides with velocity v along e = v/|v| has F_t = -μ F_n e. A disc at rest lifts off,
sticks, or begins to slip in a direction that is not given: one that does has its directions at the
roots of a polynomial of degree 4, whatever the other contacts do (`disc_slip`); where several do at
once, Newton's method searches from many starts (`turning`).

References
----------
Champneys & Várkonyi (2016).
"""

from __future__ import annotations

import itertools
import operator
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from painleve_sym.complementarity.solution_sets import FloatArray
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, received
from painleve_sym.problem.answers import REGULAR, Answer, Answers
from painleve_sym.problem.array_checks import finite_array, mobility_matrix_faults
from painleve_sym.problem.constraints import Ball, Constraint
from painleve_sym.problem.friction_set import FrictionSet
from painleve_sym.problem.law import ROUNDING, ScaledLaw
from painleve_sym.problem.modes import CONTACT_LIMIT, ContactMode
from painleve_sym.problem.risk import slip_angle
from painleve_sym.problem.solution import ContactCase, case_of, isolated, mode_of

MAX_RESTING = 4
"""Most contacts in space at rest: all directions of five at once take minutes to search."""


@dataclass(frozen=True, eq=False)
class SpatialSolution(Compared):
    """Hold one verified set of forces and accelerations of contacts in space.

    Attributes
    ----------
    modes : tuple of ContactMode
        LIFTOFF, SLIP or STICK of each contact.
    directions : tuple of (float or None)
        Angle of the slip, or of the acceleration with which it begins, from t1 towards t2, in rad
        from −π to π; 0 or π of a planar contact. None of a contact that sticks or lifts off.
    forces, accelerations : tuple of ndarray, shapes (3,) and (2,)
        n, t1, t2 of each contact, n, t of a planar one; N and m/s². What a mode fixes at 0 is
        exactly 0.
    residual : float
        How far the forces are from the laws, free of units; rounding leaves some 1e-15.
    open_forces : int
        In how many directions the forces are open while the motion stays. Where it is not 0 the
        forces are the shortest ones, lengths counted by mobilities.
    moves : bool
        Whether the motion is one of a continuum of motions.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> W = [[4.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 2.0]]
    >>> [solution] = ps.contact(W, [-9.8, 0.0, 6.0], 0.5).solutions
    >>> solution.mode.value, round(solution.direction, 3), solution.force.round(3).tolist()
    ('slip', 1.165, [2.577, -0.509, -1.184])
    """

    modes: tuple[ContactMode, ...]
    directions: tuple[float | None, ...]
    forces: tuple[FloatArray, ...]
    accelerations: tuple[FloatArray, ...]
    residual: float
    open_forces: int = 0
    moves: bool | None = False

    @property
    def isolated(self) -> bool | None:
        """Whether no neighbouring forces are a solution."""
        return isolated(self)

    def __repr__(self) -> str:
        """Return modes and forces in one line."""
        parts = (
            f"{mode.value} {np.array2string(force, precision=6, separator=', ')}"
            for mode, force in zip(self.modes, self.forces, strict=True)
        )
        return f"SpatialSolution {'; '.join(parts)} N"

    @property
    def mode(self) -> ContactMode:
        """Return what the only contact does."""
        (mode,) = self.modes
        return mode

    @property
    def direction(self) -> float | None:
        """Return the angle of slip of the only contact, in rad."""
        (direction,) = self.directions
        return direction

    @property
    def force(self) -> FloatArray:
        """Return the force of the only contact, in N."""
        (force,) = self.forces
        return force

    @property
    def acceleration(self) -> FloatArray:
        """Return the acceleration of the only contact, in m/s²."""
        (acceleration,) = self.accelerations
        return acceleration


@dataclass(frozen=True, eq=False)
class SpatialProblem(Compared):
    """State the contact problem of n closed contacts in space, all with zero normal velocity.

    Parameters
    ----------
    W : array_like, shape (r, r)
        Mobility ``J M^-1 J'``, contact by contact: rows n, t1, t2 of a disc, n, t of an interval;
        in 1/kg, symmetric and positive semidefinite.
    b : array_like, shape (r,)
        Accelerations without contact force, in the same order, in m/s².
    friction : sequence of n FrictionSet
        `Disc` of a contact in space, `Interval` of a planar one.
    slip : sequence of n sequences of float
        Slip velocities: two numbers for a disc, one for an interval; in m/s. Only the direction
        matters, and exactly 0 means at rest.

    Raises
    ------
    InputError
        For wrong shapes, entries that are not finite, or a mobility that is not symmetric and
        semidefinite.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> W = [[4.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 2.0]]
    >>> problem = ps.SpatialProblem(W, [-9.8, 0.0, 0.0], [ps.Disc(0.5)], [(-1.0, 0.0)])
    >>> [solution] = problem.solutions()
    >>> solution.mode.value, solution.force.round(6).tolist()
    ('slip', [2.177778, 1.088889, 0.0])
    """

    W: FloatArray
    b: FloatArray
    friction: tuple[FrictionSet, ...]
    slip: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        """Check every array and keep read-only copies."""
        fields = vars(self)
        sets, slips = tuple(self.friction), tuple(self.slip)
        if not sets or not all(isinstance(s, FrictionSet) for s in sets):
            raise InputError(
                f"{_STATED}friction: got {received(self.friction)}, need a Disc or an Interval for "
                "each contact. Fix: friction=[Disc(0.5)]."
            )
        if len(slips) != len(sets):
            raise InputError(
                f"{_STATED}slip: got {len(slips)} velocities for {len(sets)} contacts, need one "
                "for each."
            )
        fields["friction"] = sets
        fields["slip"] = tuple(
            tuple(_array(v, f"slip of contact {i}", (s.n_tangents,)).tolist())
            for i, (v, s) in enumerate(zip(slips, sets, strict=True))
        )
        size = self.rows[-1][-1] + 1
        W, b = _array(self.W, "W", (size, size)), _array(self.b, "b", (size,))
        faults = mobility_matrix_faults(W, "n, t1, t2 of each disc, n, t of each interval")
        if faults:
            raise InputError(_STATED + " Also, ".join(faults))
        fields["W"], fields["b"] = (W + W.T) / 2, b
        for array in (self.W, self.b):
            array.setflags(write=False)

    @cached_property
    def rows(self) -> tuple[tuple[int, ...], ...]:
        """The rows of each contact, the normal one first."""
        ends = list(itertools.accumulate((1 + s.n_tangents for s in self.friction), initial=0))
        return tuple(tuple(range(*pair)) for pair in itertools.pairwise(ends))

    @cached_property
    def directions(self) -> tuple[tuple[float, ...], ...]:
        """Unit vectors of the slip velocities, empty at rest."""
        return tuple(s.direction(v) for s, v in zip(self.friction, self.slip, strict=True))

    def alone(self, i: int) -> SpatialProblem:
        """Return the problem of one contact, the others open."""
        rows = list(self.rows[i])
        W, b = self.W[np.ix_(rows, rows)], self.b[rows]
        return SpatialProblem(W, b, (self.friction[i],), (self.slip[i],))

    @property
    def complete(self) -> bool:
        """Whether `solutions` returns every solution, up to those of a continuum."""
        return not self._answers.searched

    @property
    def guarantee(self) -> str:
        """Sentences on how certain it is that the solutions are all."""
        answers = self._answers
        if not answers.searched:
            return "These are all solutions; each was checked by its residual."
        text = (
            "Each solution was checked by its residual. Directions in which several contacts begin "
            "to slip at once have no finite list: that these are all solutions is not guaranteed."
        )
        if not any(self.directions) and answers.least_eigenvalue > REGULAR:
            text += " With all contacts at rest and W positive definite there is at least one."
        if answers.missed:
            text += " Their number is even, which proves that there are more."
        return text

    @property
    def borders(self) -> tuple[str, ...]:
        """Borders on which the problem lies; see `ContactProblem.borders`."""
        return tuple(sorted(self._answers.borders))

    # ---- solutions ----

    def solutions(self) -> tuple[SpatialSolution, ...]:
        """Return the consistent motions with their forces, each checked by its residual.

        Whether these are all is `complete`, and `guarantee` in words. An empty tuple is the
        inconsistent case where they are.

        Raises
        ------
        InputError
            For more contacts than all their cases can be tried. Fix: ask about fewer contacts.
        """
        return tuple(map(self._solution, self._answers.all))

    def case_of(self, solutions: Sequence[SpatialSolution]) -> ContactCase:
        """Classify the problem by its solutions; see `ContactCase`."""
        return case_of(solutions, len(self.friction) > 1, self.complete)

    @cached_property
    def _answers(self) -> Answers:
        if len(self.friction) > CONTACT_LIMIT:
            raise InputError(
                f"solutions() cannot try every piece of the law: got {len(self.friction)} "
                f"contacts, need at most {CONTACT_LIMIT}. Fix: ask about fewer contacts."
            )
        resting = sum(
            s.n_tangents > 1 and s.mu > 0 and not e
            for s, e in zip(self.friction, self.directions, strict=True)
        )
        if resting > MAX_RESTING:
            raise InputError(
                f"solutions() would search for minutes: got {len(self.friction)} contacts, "
                f"{resting} of them in space at rest, need at most {MAX_RESTING}. "
                "Fix: ask about fewer contacts."
            )
        constraints = [
            Constraint(n, (Ball(tuple(tangents), s.mu, e),))
            for (n, *tangents), s, e in zip(self.rows, self.friction, self.directions, strict=True)
        ]
        return Answers(ScaledLaw(self.W.tolist(), self.b.tolist(), constraints))

    def _solution(self, answer: Answer) -> SpatialSolution:
        """Return an answer in the units of the problem, with its accelerations."""
        law, checked = self._answers.law, answer.checked
        forces = np.array(list(map(operator.mul, law.unit, checked.forces)))
        motion = self.W @ forces + self.b
        terms = np.abs(self.W) @ np.abs(forces) + np.abs(self.b)
        motion = np.where(np.abs(motion) <= ROUNDING * terms, 0.0, motion)
        modes, angles = list[ContactMode](), list[float | None]()
        for i, own in enumerate(self.rows):
            mode, way = mode_of(law, answer, i), checked.slips[i][0]
            if mode is not ContactMode.LIFTOFF:
                motion[own[0]] = 0.0
                if mode is ContactMode.STICK:
                    motion[list(own[1:])] = 0.0
            slips = mode not in (ContactMode.LIFTOFF, ContactMode.STICK)
            modes.append(ContactMode.SLIP if slips else mode)
            angles.append(slip_angle(way) if slips else None)
        parts = [[v[list(own)] + 0.0 for own in self.rows] for v in (forces, motion)]  # no -0.0
        for part in (*parts[0], *parts[1]):
            part.setflags(write=False)
        return SpatialSolution(
            tuple(modes),
            tuple(angles),
            tuple(parts[0]),
            tuple(parts[1]),
            checked.residual,
            answer.open_forces,
            answer.moves,
        )


_STATED = "SpatialProblem cannot be stated, "


def _array(value: object, name: str, shape: tuple[int, ...]) -> FloatArray:
    """Return finite numbers of a shape; InputError for others."""
    array, fault = finite_array(value, name)
    if fault:
        raise InputError(f"{_STATED}{fault}")
    if array.ndim == 0 and shape == (1,):
        array = array.reshape(1)
    if array.shape != shape:
        raise InputError(
            f"{_STATED}{name}: got shape {array.shape}, need {shape}. Fix: give three rows n, t1, "
            "t2 for each disc and two rows n, t for each interval."
        )
    return array
