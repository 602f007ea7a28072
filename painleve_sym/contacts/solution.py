"""Verified solutions of a contact problem, and the case that all of them make.

Forces and accelerations of a planar contact are listed and signed as in `ContactProblem`; the case
is that of contacts in space, too.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from painleve_sym.complementarity.solution_sets import FloatArray
from painleve_sym.contacts.local_mode import ContactMode
from painleve_sym.equality import Compared

_SAME_MOTION = 1e-9  # of the largest acceleration without forces


class ContactCase(enum.StrEnum):
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
        Several. One unilateral contact in slip: F_n = 0 and F_n = -B/A where A < 0 and B > 0; any
        F_n >= 0 where A = B = 0. One bilateral contact in slip: one for each sign of F_n where
        mu |W_nt| > W_nn and s W_nt B > 0. At v_t = 0 up to three, or a ray of them. Several
        contacts: several accelerations.
    HYPERSTATIC
        Several forces of several contacts, with the same accelerations.
    """

    SLIP = ("slip", "one solution, the contact slides on")
    LIFTOFF = ("liftoff", "one solution, the contact opens")
    STICK = ("stick", "one solution, the contact sticks")
    INCONSISTENT = ("inconsistent", "no forces of a rigid contact are possible here")
    INDETERMINATE = ("indeterminate", "several solutions, the rigid model does not choose")
    UNIQUE = ("unique", "one solution")
    HYPERSTATIC = ("hyperstatic", "one motion, but rigidity leaves its forces open")

    sentence: str

    def __new__(cls, label: str, sentence: str = "") -> ContactCase:
        """Return the member that is the text `label`."""
        member = str.__new__(cls, label)
        member._value_ = label
        member.sentence = sentence
        return member


@dataclass(frozen=True, eq=False)
class ContactSolution(Compared):
    """Hold one verified set of forces and accelerations; what a mode fixes at 0 is exactly 0.

    Attributes
    ----------
    modes : tuple of ContactMode
        What each contact does.
    normal_forces, tangential_forces : ndarray, shape (n,)
        F_n and F_t of each contact, in N. Read-only.
    normal_accelerations, tangential_accelerations : ndarray, shape (n,)
        a_n and a_t of each contact, in m/s². Read-only.
    residual : float
        `ContactProblem.residual` of the forces; dimensionless.
    isolated : bool, or None
        False where the forces belong to a segment, ray or wider set of solutions; None where more
        local modes meet than are tried.

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
    normal_forces: FloatArray
    tangential_forces: FloatArray
    normal_accelerations: FloatArray
    tangential_accelerations: FloatArray
    residual: float
    isolated: bool | None

    def __repr__(self) -> str:
        """Return modes and forces in one line."""
        modes = ", ".join(mode.value for mode in self.modes)
        F_n, F_t = (
            ", ".join(f"{v:.6g}" for v in forces.tolist())
            for forces in (self.normal_forces, self.tangential_forces)
        )
        return f"ContactSolution {modes}: F_n = {F_n} N, F_t = {F_t} N"

    @property
    def forces(self) -> FloatArray:
        """Return F_n1, F_t1, F_n2, F_t2, ... in N, shape (2 n,)."""
        return np.column_stack([self.normal_forces, self.tangential_forces]).ravel()

    @property
    def accelerations(self) -> FloatArray:
        """Return a_n1, a_t1, a_n2, a_t2, ... in m/s², shape (2 n,)."""
        return np.column_stack([self.normal_accelerations, self.tangential_accelerations]).ravel()

    # ---- one contact ----

    @property
    def mode(self) -> ContactMode:
        """Return what the only contact does."""
        (mode,) = self.modes
        return mode

    @property
    def normal_force(self) -> float:
        """Return F_n of the only contact, in N."""
        return float(self.normal_forces.item())

    @property
    def tangential_force(self) -> float:
        """Return F_t of the only contact, in N."""
        return float(self.tangential_forces.item())

    @property
    def normal_acceleration(self) -> float:
        """Return a_n of the only contact, in m/s²."""
        return float(self.normal_accelerations.item())

    @property
    def tangential_acceleration(self) -> float:
        """Return a_t of the only contact, in m/s²."""
        return float(self.tangential_accelerations.item())


class Verified(Protocol):
    """A solution of contacts in the plane or in space."""

    @property
    def modes(self) -> tuple[ContactMode, ...]:
        """The mode of each contact."""

    @property
    def isolated(self) -> bool | None:
        """Whether the forces are a solution by themselves; None where that is not known."""

    @property
    def accelerations(self) -> FloatArray | tuple[FloatArray, ...]:
        """Of all contacts."""


def case_of(solutions: Sequence[Verified], b: FloatArray, plural: bool) -> ContactCase:
    """Return the case by all solutions; b are the accelerations without forces.

    With `plural` in the words for several contacts.
    """
    if not solutions:
        return ContactCase.INCONSISTENT
    if len(solutions) == 1 and solutions[0].isolated is not False:
        return ContactCase.UNIQUE if plural else _CASES.get(solutions[0].modes[0], ContactCase.SLIP)
    motions = [np.hstack(list(s.accelerations)) for s in solutions]
    near = _SAME_MOTION * float(np.max(np.abs(b)))
    same = plural and np.allclose(motions, motions[0], rtol=0, atol=near)
    return ContactCase.HYPERSTATIC if same else ContactCase.INDETERMINATE


_CASES = {ContactMode.LIFTOFF: ContactCase.LIFTOFF, ContactMode.STICK: ContactCase.STICK}
