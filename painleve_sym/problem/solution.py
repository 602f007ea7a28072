"""Verified solutions of a contact problem, and the case that all of them make.

Forces and accelerations of a planar contact are listed and signed as in `ContactProblem`; the case
is that of contacts in space, too.
"""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from painleve_sym.equality import Compared
from painleve_sym.errors import Explained
from painleve_sym.plain_data import plain_fields
from painleve_sym.problem.answers import MotionWithForces
from painleve_sym.problem.complementarity.solution_sets import FloatArray
from painleve_sym.problem.law import ROUNDING, ScaledLaw
from painleve_sym.problem.modes import ContactMode, slip_mode


class ContactCase(Explained):
    """Name a contact problem by its solutions; `sentence` says what follows.

    INCONSISTENT
        None. One unilateral contact: A <= 0 and B < 0. One bilateral contact in slip:
        mu |W_nt| > W_nn and s W_nt B < 0; only the tangential impact answers.
    SLIP, LIFTOFF, STICK
        One solution of one contact, by its mode. Of a unilateral contact in slip F_n = -B/A > 0
        where A > 0 and B < 0, and F_n = 0 where A >= 0 and B > 0; also B = 0 with A != 0, where
        a_n = 0.
    UNIQUE
        One solution of several contacts.
    INDETERMINATE
        Several motions. One unilateral contact in slip: F_n = 0 and F_n = -B/A where A < 0 and
        B > 0; any F_n >= 0 where A = B = 0. One bilateral contact in slip: one for each sign of
        F_n where mu |W_nt| > W_nn and s W_nt B > 0. At v_t = 0 up to three, or a continuum.
    HYPERSTATIC
        One motion with several forces: a body on more contacts than it has freedoms, or one contact
        of a mechanism whose normal and tangent share a freedom. After a search that proves nothing,
        one motion is known.
    UNKNOWN
        No solution, after a search that proves nothing: several contacts in space begin to slip.
    ONE_KNOWN
        One solution, with one set of forces, after such a search.
    """

    SLIP = ("slip", "one solution, the contact slides on")
    LIFTOFF = ("liftoff", "one solution, the contact opens")
    STICK = ("stick", "one solution, the contact sticks")
    INCONSISTENT = ("inconsistent", "no forces of a rigid contact are possible here")
    INDETERMINATE = ("indeterminate", "several solutions, the rigid model does not choose")
    UNIQUE = ("unique", "one solution")
    HYPERSTATIC = ("hyperstatic", "one motion, statically indeterminate: its forces are not unique")
    UNKNOWN = ("unknown", "no solution is known, and none is proved not to exist")
    ONE_KNOWN = ("one_known", "one solution is known, and none is proved to be the only one")


@dataclass(frozen=True, eq=False)
class ContactSolution(Compared):
    """Hold one verified motion with its forces; what a mode fixes at 0 is exactly 0.

    Attributes
    ----------
    modes : tuple of ContactMode
        What each contact does, by its first ball of friction.
    slips : tuple of tuples of tuples of float
        For each contact, and each of its balls of friction, the unit vector along which it slips or
        begins to; zeros where it does not.
    normal_forces : ndarray, shape (n,)
        F_n of each contact, in N; of a `Brake` its limit. Read-only.
    tangential_forces : ndarray, shape (number of tangential rows,)
        F_t of each contact in the plane; contact by contact. In N. Read-only.
    normal_accelerations, tangential_accelerations : ndarray
        The same of a_n and a_t, in m/s². Read-only.
    tangents : tuple of int
        The number of tangential rows of each contact.
    residual : float
        `ContactProblem.residual` of the forces; dimensionless.
    open_forces : int
        In how many directions the forces are open while the motion stays. Where it is not 0 the
        forces are the shortest ones, lengths counted by mobilities.
    moves : bool or None
        Whether the motion is one of a continuum of motions; None where more pieces of the law meet
        than are tried.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> state = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
    >>> for solution in ps.classify("rod", state).solutions:
    ...     print(solution.modes[0].value, solution.normal_forces.round(3).tolist())
    liftoff [0.0]
    slip_neg [332.992]
    """

    modes: tuple[ContactMode, ...]
    slips: tuple[tuple[tuple[float, ...], ...], ...]
    normal_forces: FloatArray
    tangential_forces: FloatArray
    normal_accelerations: FloatArray
    tangential_accelerations: FloatArray
    tangents: tuple[int, ...]
    residual: float
    open_forces: int = 0
    moves: bool | None = False
    brakes: tuple[int, ...] = ()

    @property
    def directions(self) -> tuple[tuple[float, ...], ...]:
        """The slip of each contact, by its first ball: a unit vector along the tangents, or zeros.

        Empty of a contact without tangents.
        """
        return tuple(ways[0] if ways else () for ways in self.slips)

    @property
    def isolated(self) -> bool | None:
        """Whether no neighbouring forces are a solution; None where that is not known."""
        if self.open_forces or self.moves:
            return False
        return None if self.moves is None else True

    def __repr__(self) -> str:
        """Return modes and forces in one line."""
        if set(self.tangents) != {1}:
            parts = zip(self.modes, self.contact_forces, strict=True)
            texts = (
                f"{m.value} {np.array2string(F, precision=6, separator=', ')}" for m, F in parts
            )
            return f"ContactSolution {'; '.join(texts)} N"
        modes = ", ".join(mode.value for mode in self.modes)
        F_n, F_t = (
            ", ".join(f"{v:.6g}" for v in forces.tolist())
            for forces in (self.normal_forces, self.tangential_forces)
        )
        return f"ContactSolution {modes}: F_n = {F_n} N, F_t = {F_t} N"

    @property
    def forces(self) -> FloatArray:
        """The forces by the rows of W: F_n1, F_t1, F_n2, F_t2, ... in the plane; N."""
        return np.concatenate(self.contact_forces)

    @property
    def accelerations(self) -> FloatArray:
        """The accelerations by the rows of W: a_n1, a_t1, a_n2, a_t2, ... in the plane; m/s²."""
        return np.concatenate(self.contact_accelerations)

    @property
    def contact_forces(self) -> tuple[FloatArray, ...]:
        """The force of each contact along its rows, such as n, t or n, t1, t2; N."""
        return self._by_contact(self.normal_forces, self.tangential_forces)

    @property
    def contact_accelerations(self) -> tuple[FloatArray, ...]:
        """The acceleration of each contact along its rows; m/s²."""
        return self._by_contact(self.normal_accelerations, self.tangential_accelerations)

    def _by_contact(self, normal: FloatArray, tangential: FloatArray) -> tuple[FloatArray, ...]:
        parts, start = [], 0
        for i, count in enumerate(self.tangents):
            own = tangential[start : start + count]
            parts.append(own if i in self.brakes else np.append(normal[i], own))
            start += count
        return tuple(parts)

    # ---- one contact ----

    @property
    def mode(self) -> ContactMode:
        """The mode of the only contact."""
        (mode,) = self.modes
        return mode

    @property
    def direction(self) -> tuple[float, ...]:
        """The slip of the only contact: a unit vector along its tangents, or zeros."""
        (direction,) = self.directions
        return direction

    @property
    def force(self) -> FloatArray:
        """The force of the only contact along its rows, in N."""
        (force,) = self.contact_forces
        return force

    @property
    def acceleration(self) -> FloatArray:
        """The acceleration of the only contact along its rows, in m/s²."""
        (acceleration,) = self.contact_accelerations
        return acceleration

    @property
    def normal_force(self) -> float:
        """F_n of the only contact, in N."""
        return float(self.normal_forces.item())

    @property
    def tangential_force(self) -> float:
        """F_t of the only contact, which has one tangent, in N."""
        return float(self.tangential_forces.item())

    @property
    def normal_acceleration(self) -> float:
        """a_n of the only contact, in m/s²."""
        return float(self.normal_accelerations.item())

    @property
    def tangential_acceleration(self) -> float:
        """a_t of the only contact, which has one tangent, in m/s²."""
        return float(self.tangential_accelerations.item())


def solution_data(solution: ContactSolution, contacts: Sequence[str]) -> dict[str, Any]:
    """Return a solution with contacts of these names, one ball of friction each, as plain data."""
    data, start = dict[str, Any](), 0
    for i, (name, count) in enumerate(zip(contacts, solution.tangents, strict=True)):
        own = slice(start, start + count)
        start += count
        data[name] = {
            "mode": solution.modes[i].value,
            "direction": [v + 0.0 for v in solution.directions[i]],  # no -0.0
            "normal_force": float(solution.normal_forces[i]),
            "tangential_force": solution.tangential_forces[own].tolist(),
            "normal_acceleration": float(solution.normal_accelerations[i]),
            "tangential_acceleration": solution.tangential_accelerations[own].tolist(),
        }
    return {"contacts": data} | plain_fields(
        solution, "isolated", "open_forces", "moves", "residual"
    )


def case_of(
    solutions: Sequence[ContactSolution], plural: bool, complete: bool = True
) -> ContactCase:
    """Return the case by all solutions, each of which is one motion.

    With `plural` in the words for several contacts. `complete` says whether they are all: two
    motions are a proof, but one or none need it.
    """
    if not solutions:
        return ContactCase.INCONSISTENT if complete else ContactCase.UNKNOWN
    if len(solutions) > 1 or solutions[0].moves:
        return ContactCase.INDETERMINATE
    if solutions[0].open_forces:
        return ContactCase.HYPERSTATIC
    if not complete:
        return ContactCase.ONE_KNOWN
    return ContactCase.UNIQUE if plural else _CASES.get(solutions[0].modes[0], ContactCase.SLIP)


_CASES = {
    ContactMode.LIFTOFF: ContactCase.LIFTOFF,
    ContactMode.STICK: ContactCase.STICK,
    ContactMode.PRESSED: ContactCase.UNIQUE,
}


_NO_SLIP = (), (0.0,), (0.0, 0.0)
"""The direction of a ball of 0, 1 or 2 rows that does not slip."""


def _mode(lifted: bool, ways: tuple[tuple[float, ...], ...]) -> ContactMode:
    """Return the mode of a constraint by its first ball."""
    if lifted:
        return ContactMode.LIFTOFF
    if not ways:
        return ContactMode.PRESSED
    way = ways[0]
    if not way:
        return ContactMode.STICK
    return slip_mode(way[0]) if len(way) == 1 else ContactMode.SLIP


def solution_of(law: ScaledLaw, answer: MotionWithForces) -> ContactSolution:
    """Return an answer in the units of the problem, with its accelerations."""
    checked = answer.checked
    forces = list(map(operator.mul, law.unit, checked.forces))
    a, _, terms = checked.motion
    modes, slips = list[ContactMode](), list[tuple[tuple[float, ...], ...]]()
    normal, tangential = list[float](), list[float]()
    parted, sliding = list[float](), list[float]()

    def moving(row: int, part: int) -> float:
        still = abs(a[row]) <= ROUNDING * terms[part]
        return 0.0 if still else a[row] * law.rate_unit[row]

    for (constraint, n, balls), ways in zip(law.each, checked.slips, strict=True):
        row = constraint.normal
        lifted = constraint.opens and not checked.forces[row]
        modes.append(_mode(lifted, ways))
        normal.append(forces[row])
        # What the mode fixes at 0 is exactly 0.
        parted.append(moving(row, n) if lifted else 0.0)
        named = []
        for (ball, k), way in zip(balls, ways, strict=True):
            named.append(way or _NO_SLIP[len(ball.rows)])
            for t in ball.rows:
                tangential.append(forces[t])
                sliding.append(moving(t, k) if lifted or way else 0.0)
        slips.append(tuple(named))
    numbers = np.array([*normal, *parted, *tangential, *sliding])
    numbers.setflags(write=False)
    n, both, end = len(normal), 2 * len(normal), 2 * len(normal) + len(tangential)
    F_n, a_n, F_t, a_t = numbers[:n], numbers[n:both], numbers[both:end], numbers[end:]
    return ContactSolution(
        tuple(modes),
        tuple(slips),
        F_n,
        F_t,
        a_n,
        a_t,
        law.layout.tangents,
        checked.residual,
        answer.open_forces,
        answer.moves,
        law.layout.brakes,
    )
