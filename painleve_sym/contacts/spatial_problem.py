"""Contacts in space, or in space and in the plane together: which forces and accelerations agree.

A contact in space has three rows, n, t1, t2, and a `Disc` of friction; a planar one n, t and an
`Interval`. F_n pushes the bodies apart, a_n separates them, tangential forces and accelerations
count along the tangents, and ``a = W F + b``.

A contact that slides with velocity v along e = v/|v| has F_t = -μ F_n e: in the plane of n and e it
is a planar contact that slides forwards, and what it does across that plane takes no force. So
while every disc slides, all contacts together are a planar `ContactProblem`, whose kernel finds
every solution. Discs at rest are not piecewise linear: one alone has its solutions at the roots of
a polynomial of degree 4 (`disc_at_rest`), also among contacts that are not such discs; several
are a nonlinear complementarity problem, for which `resting_contacts` searches from many starts.

References
----------
Champneys & Várkonyi (2016).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from painleve_sym.complementarity.lcp import RESIDUAL_TOLERANCE
from painleve_sym.complementarity.solution_sets import FloatArray
from painleve_sym.contact_rows import ContactRows
from painleve_sym.contacts.array_checks import finite_array, mobility_matrix_faults
from painleve_sym.contacts.ball_law import BallLaw
from painleve_sym.contacts.disc_at_rest import forces_at_rest
from painleve_sym.contacts.friction_set import Disc, FrictionSet
from painleve_sym.contacts.local_mode import ContactMode, Vector
from painleve_sym.contacts.problem import ContactProblem
from painleve_sym.contacts.resting_contacts import search, solve_one
from painleve_sym.contacts.risk import slip_angle
from painleve_sym.contacts.scaled_law import ROUNDING
from painleve_sym.contacts.solution import ContactCase, ContactSolution, case_of
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, received


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
    isolated : bool or None
        False where the forces belong to a continuum of solutions; None where that is not known.

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
    isolated: bool | None

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

    @cached_property
    def resting(self) -> tuple[int, ...]:
        """The discs at rest, where friction acts: what makes the problem nonlinear."""
        return tuple(
            i
            for i, (s, e) in enumerate(zip(self.friction, self.directions, strict=True))
            if isinstance(s, Disc) and s.mu > 0 and not e
        )

    def alone(self, i: int) -> SpatialProblem:
        """Return the problem of one contact, the others open."""
        rows = list(self.rows[i])
        W, b = self.W[np.ix_(rows, rows)], self.b[rows]
        return SpatialProblem(W, b, (self.friction[i],), (self.slip[i],))

    @property
    def complete(self) -> bool:
        """Whether `solutions` returns every solution, up to those of a continuum."""
        return not self.resting or len(self.friction) == 1 or self._of_one is not None

    @cached_property
    def _of_one(self) -> list[tuple[Vector, bool]] | None:
        """Forces where one disc rests among several contacts, all of them; None for others."""
        if len(self.resting) != 1:
            return None
        return solve_one(self._scaled[0], *self.resting)

    @property
    def guarantee(self) -> str:
        """Sentences on how certain it is that the solutions are all."""
        if self.complete:
            return "These are all solutions; each was checked by its residual."
        text = (
            "Each solution was checked by its residual. Contacts in space at rest have no finite "
            "list of cases: that these are all solutions is not guaranteed."
        )
        root = np.sqrt(np.where(np.diag(self.W) > 0, np.diag(self.W), 1.0))
        least = float(np.linalg.eigvalsh(self.W / np.outer(root, root))[0])
        if not any(self.directions) and least > 1e-12:
            text += " With all contacts at rest and W positive definite there is at least one."
        return text

    # ---- solutions ----

    def solutions(self) -> tuple[SpatialSolution, ...]:
        """Return the consistent sets of forces, each checked by its residual.

        Whether these are all is `complete`, and `guarantee` in words. An empty tuple is the
        inconsistent case where they are.

        Raises
        ------
        InputError
            For more contacts than all their cases can be tried. Fix: ask about fewer contacts.
        """
        if not self.resting:
            return tuple(map(self._from_plane, self.plane.solutions()))
        law, _ = self._scaled
        if len(self.friction) == 1:
            rests = forces_at_rest(law.W.tolist(), law.b.tolist(), *law.mu)
            return self._checked((r.force, (r.mode,), r.isolated) for r in rests)
        if self._of_one is not None:
            return self._checked(((f, None, alone) for f, alone in self._of_one))
        return self._checked((force, None, None) for force in search(law))

    def case_of(self, solutions: Sequence[SpatialSolution]) -> ContactCase:
        """Classify the problem by its solutions; see `ContactCase`."""
        return case_of(solutions, self.b, len(self.friction) > 1)

    # ---- sliding ----

    @cached_property
    def _into_plane(self) -> FloatArray:
        """Rows n and e of every contact by its own rows, shape (2 n, r)."""
        at = ContactRows(len(self.friction))
        turn = np.zeros((at.size, self.b.size))
        for i, (own, e) in enumerate(zip(self.rows, self.directions, strict=True)):
            turn[at.normal(i), own[0]] = 1.0
            turn[at.tangent(i), list(own[1:])] = e or (1.0, *[0.0] * (len(own) - 2))
        return turn

    @cached_property
    def plane(self) -> ContactProblem:
        """The same problem in the planes of slip: every disc an interval along its slip.

        A disc at rest counts along t1, which is its law only where it has no friction.
        """
        turn = self._into_plane
        mu = np.array([s.mu for s in self.friction])
        moving = np.array([float(bool(e)) for e in self.directions])
        W = turn @ self.W @ turn.T
        # What rounding leaves of a zero would be a coupling of a contact that does not move.
        W[np.abs(W) <= ROUNDING * (np.abs(turn) @ np.abs(self.W) @ np.abs(turn.T))] = 0.0
        still = np.diag(W) <= 0
        W[still], W[:, still] = 0.0, 0.0
        return ContactProblem(W, turn @ self.b, mu, moving)

    def _from_plane(self, solution: ContactSolution) -> SpatialSolution:
        forces = self._into_plane.T @ solution.forces
        return self._solution(forces, solution.modes, solution.residual, solution.isolated)

    def _solution(
        self,
        forces: FloatArray,
        modes: Sequence[ContactMode],
        residual: float,
        isolated: bool | None,
    ) -> SpatialSolution:
        """Return checked forces with their accelerations and the directions of slip."""
        a = self.W @ forces + self.b
        terms = np.abs(self.W) @ np.abs(forces) + np.abs(self.b)
        a = np.where(np.abs(a) <= ROUNDING * terms, 0.0, a)
        named, angles, parts = list[ContactMode](), list[float | None](), list[FloatArray]()
        for own, mode, e in zip(self.rows, modes, self.directions, strict=True):
            word, way = mode, e
            n, tangents = own[0], list(own[1:])
            if mode is not ContactMode.LIFTOFF:
                a[n] = 0.0
                if mode is ContactMode.STICK:
                    a[tangents] = 0.0
                # Without friction, or at the edge of the cone, the acceleration alone shows it.
                way = e or self.friction[len(named)].direction(a[tangents].tolist())
                word = ContactMode.SLIP if way else ContactMode.STICK
            named.append(word)
            angles.append(slip_angle(way) if word is ContactMode.SLIP else None)
            part = forces[list(own)] + 0.0  # no -0.0
            part.setflags(write=False)
            parts.append(part)
        motions = [a[list(own)] + 0.0 for own in self.rows]
        for motion in motions:
            motion.setflags(write=False)
        return SpatialSolution(
            tuple(named), tuple(angles), tuple(parts), tuple(motions), residual, isolated
        )

    # ---- at rest ----

    @cached_property
    def _scaled(self) -> tuple[BallLaw, FloatArray]:
        """The laws scaled to order one by powers of two, and the unit of the scaled forces.

        The tangents of one contact keep one scale, so that a disc stays a disc.
        """
        diagonal, d = np.diag(self.W), np.ones(self.b.size)
        for own in self.rows:
            for part in ([own[0]], list(own[1:])):
                largest = float(diagonal[part].max())
                if largest > 0:
                    d[part] = math.ldexp(1.0, math.frexp(largest)[1] // 2)
        offset = self.b / d
        largest = float(np.abs(offset).max())
        size = math.ldexp(1.0, math.frexp(largest)[1]) if largest > 0 else 1.0
        mu = [
            s.mu * float(d[t] / d[n])
            for s, (n, t, *_) in zip(self.friction, self.rows, strict=True)
        ]
        contacts = mu, self.friction, self.directions, self.rows
        return BallLaw(self.W / np.outer(d, d), offset / size, *contacts), size / d

    def _checked(
        self,
        given: Iterable[tuple[Vector, Sequence[ContactMode] | None, bool | None]],
    ) -> tuple[SpatialSolution, ...]:
        """Return those scaled forces that solve the problem, each once, by their normal forces."""
        law, unit = self._scaled
        kept: list[tuple[Vector, tuple[ContactMode, ...], float, bool | None]] = []
        for forces, modes, isolated in given:
            residual = law.residual(forces)
            if residual > RESIDUAL_TOLERANCE:
                continue
            entry = forces, tuple(modes or law.modes(forces)), residual, isolated
            twin = next((k for k, other in enumerate(kept) if law.same(forces, other[0])), None)
            if twin is None:
                kept.append(entry)
                continue
            other = kept[twin]
            # Other forces with the same motion: a continuum, such as of a body on many feet.
            alone = (
                False
                if False in (isolated, other[3]) or not law.near(forces, other[0])
                else isolated
            )
            kept[twin] = (*(entry if residual < other[2] else other)[:3], alone)
        wide = [entry for entry in kept if entry[3] is False]
        # One representative of each continuum: of directions of slip there may be many.
        kept = [entry for k, entry in enumerate(kept) if entry[3] is not False or entry in wide[:1]]
        kept.sort(key=lambda entry: [round(f, 12) for f in law.order(entry[0])])
        return tuple(
            self._solution(unit * np.array(forces), modes, residual, isolated)
            for forces, modes, residual, isolated in kept
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
