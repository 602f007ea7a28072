"""Planar contacts with Coulomb friction: which forces and accelerations are consistent.

Signs, contact by contact: the normal force F_n pushes the bodies apart and a_n > 0 separates them;
F_t and a_t count along the slip velocity v_t. Forces and accelerations are listed contact by
contact, ``F = (F_n1, F_t1, F_n2, F_t2, ...)``, and the mobility W turns forces into accelerations,
``a = W F + b``. For one contact::

    a_n = W_nn F_n + W_nt F_t + b_n                    ^ F_n, a_n
    a_t = W_nt F_n + W_tt F_t + b_t                    |
                                                   ----o---->  F_t, a_t, v_t
                                                 ///////////////

A unilateral contact has F_n >= 0, a_n >= 0 and F_n a_n = 0. A bilateral one, a slider in a slot or
a rod between two guides, keeps a_n = 0 with either sign of F_n; friction acts where it touches.
Friction opposes slip: F_t = -mu s |F_n| with s the sign of v_t, and |F_t| <= mu |F_n| where
v_t = 0, with the bound reached against the direction of a_t once a_t is not zero.

There may be one solution, several, a continuum or none. One sliding unilateral contact,
``a_n = A F_n + B`` with ``A = W_nn - mu s W_nt`` and ``B = b_n``, has the four cases of
`ContactCase`. One sliding bilateral contact, with ``A = W_nn - mu s W_nt`` where F_n > 0 and
``A = W_nn + mu s W_nt`` where F_n < 0, has

- 1 solution for every b_n where ``mu |W_nt| < W_nn``;
- 2 where ``mu |W_nt| > W_nn`` and ``s W_nt b_n > 0``: one of each sign of F_n;
- 0 where ``mu |W_nt| > W_nn`` and ``s W_nt b_n < 0``: the paradox without lift-off;
- 1, ``F_n = 0``, where ``mu |W_nt| > W_nn`` and b_n = 0;
- 1 or 0, by the same two signs, where ``mu |W_nt| = W_nn > 0`` and b_n != 0; a ray where b_n = 0;
- 0 where W_nn = 0 and b_n != 0; every F_n where b_n = 0.

At v_t = 0 and for a definite W one bilateral contact always has a solution: exactly one where
``mu |W_nt| < W_nn``, one or three where ``mu |W_nt| > W_nn`` (sticking, and two slips of opposite
F_n, both along the sign of ``W_nt b_n``), and two where sticking meets a slip or b_n = 0 makes one
of both slips. Several contacts have up to one solution for each choice of what every contact does,
or a continuum: a body on more contacts than it has degrees of freedom can be loaded in itself.

References
----------
Painlevé (1895) and Klein (1909) for the paradox; Glocker & Pfeiffer (1993), Pfeiffer & Glocker
(1996), Pang & Trinkle (1996) and Anitescu & Potra (1997) for contacts that open; Le Xuan Anh (2003)
for bilateral ones; Blumentals, Brogliato & Bertails-Descoubes (2016) for both.
"""

from __future__ import annotations

import enum
import math
import operator
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from painleve_sym.checks import INDEFINITE, SYMMETRY, checked_number, mobility_faults
from painleve_sym.complementarity.lcp import LCP, RESIDUAL_TOLERANCE, LCPSolution, equilibrate
from painleve_sym.complementarity.lemke import LemkeResult, LemkeStatus, pivot
from painleve_sym.complementarity.solution_sets import BoolArray, FloatArray
from painleve_sym.complementarity.uniqueness import Uniqueness, uniqueness_of
from painleve_sym.contact_rows import ContactRows
from painleve_sym.contacts.local_mode import (
    ContactMode,
    ModeProduct,
    Vector,
    local_modes,
    rounded_difference,
    scale_contacts,
    slip_mode,
)
from painleve_sym.errors import InputError, received

CONTACT_LIMIT = 6
"""Most contacts whose local modes are all tried: 4**6 regular systems take a tenth of a second."""

ROUNDING = 1e-14  # of the terms of an acceleration: what a solve may leave of a zero
SIGN = 1e-12  # of the terms of an acceleration: what may be missing to its right sign
_ROUND_OFF = 1e-13  # of the largest force: what a solve may leave of a zero, if the residual agrees
_NEAR = 1e-6  # part of the largest force; forces farther apart are not compared by row
DISTINCT = 1e-8  # of the terms of every acceleration; nearer solutions are one, met in two modes
_SAME_MOTION = 1e-9  # of the largest acceleration without forces
_MANY_MODES = 4**CONTACT_LIMIT


class ContactCase(enum.Enum):
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

    def __new__(cls, label: str, sentence: str) -> ContactCase:
        """Take the label as the value."""
        member = object.__new__(cls)
        member._value_ = label
        member.sentence = sentence
        return member


@dataclass(frozen=True, eq=False)
class ContactSolution:
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


@dataclass(frozen=True, eq=False)
class ContactProblem:
    """State the contact problem of n closed contacts, all with zero normal velocity.

    Parameters
    ----------
    W : array_like, shape (2 n, 2 n)
        Mobility ``J M^-1 J'`` (Delassus matrix) with rows and columns in the order n1, t1, n2, t2,
        ...; in 1/kg, symmetric and positive semidefinite. Singular is allowed and usual: one planar
        body has three degrees of freedom, so two contacts on it already leave rank 3 of 4.
    b : array_like, shape (2 n,)
        Accelerations without contact force, in the same order, in m/s².
    mu : array_like, shape (n,)
        Friction coefficients, >= 0; a number for one contact.
    slip_velocity : array_like, shape (n,)
        v_t of each contact in m/s; only the sign matters, and exactly 0 means at rest tangentially.
        A number for one contact.
    bilateral : array_like of bool, shape (n,)
        Which contacts hold from both sides; one value for all contacts, none by default.

    Raises
    ------
    InputError
        For wrong shapes, entries that are not finite, mu < 0 or a mobility that is not symmetric
        and semidefinite; all faults are named at once. Fix: evaluate J M^-1 J' at one state.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> W, b = [[4.0, 1.0], [1.0, 2.0]], [-9.8, 0.0]
    >>> problem = ps.ContactProblem(W, b, [0.5], slip_velocity=[-1.0])
    >>> [solution] = problem.solutions()
    >>> solution.modes[0], solution.normal_forces.round(6).tolist()
    (<ContactMode.SLIP_NEG: 'slip_neg'>, [2.177778])
    """

    W: FloatArray
    b: FloatArray
    mu: FloatArray
    slip_velocity: FloatArray
    bilateral: BoolArray = field(default_factory=lambda: np.zeros((), np.bool_))

    def __post_init__(self) -> None:
        """Check every array and keep read-only copies."""
        faults: list[str] = []
        fields = vars(self)
        for name in ("W", "b", "mu", "slip_velocity"):
            value, fault = finite_array(fields[name], name)
            faults += [fault] * bool(fault)
            if value.ndim == 0 and name in ("mu", "slip_velocity"):
                value = value.reshape(1)
            fields[name] = value
        sides = np.array(self.bilateral, dtype=bool)
        fields["bilateral"] = np.full(self.mu.shape, sides) if sides.ndim == 0 else sides
        faults = faults or self._shape_faults() or self._physical_faults()
        if faults:
            raise InputError(_STATED + " Also, ".join(faults))
        rows = self.W.tolist()
        if rows != list(map(list, zip(*rows, strict=True))):
            fields["W"] = (self.W + self.W.T) / 2
        for array in (self.W, self.b, self.mu, self.slip_velocity, self.bilateral):
            array.setflags(write=False)

    @classmethod
    def single(
        cls,
        W_nn: float,
        W_nt: float,
        W_tt: float,
        b_n: float,
        b_t: float,
        mu: float,
        slip_velocity: float,
        bilateral: bool = False,
    ) -> ContactProblem:
        """State the problem of one contact by its scalars.

        Parameters
        ----------
        W_nn, W_nt, W_tt : float
            Mobility, in 1/kg.
        b_n, b_t : float
            Accelerations without contact force, in m/s². b_n is B of the paradox literature.
        mu : float
            Friction coefficient, >= 0.
        slip_velocity : float
            v_t in m/s; exactly 0 means at rest tangentially.
        bilateral : bool
            Whether the contact holds from both sides.
        """
        given = {"W_nn": W_nn, "W_nt": W_nt, "W_tt": W_tt, "b_n": b_n, "b_t": b_t}
        faults, values = [], []
        for name, value in (given | {"mu": mu, "slip_velocity": slip_velocity}).items():
            number, fault = checked_number(value, name)
            values.append(number)
            if fault:
                faults.append(f"{fault} Fix: check the state it was evaluated at.")
        if faults:
            raise InputError(_STATED + " Also, ".join(faults))
        nn, nt, tt, n, t, friction, slip = values
        return cls(
            np.array([[nn, nt], [nt, tt]]),
            np.array([n, t]),
            np.array([friction]),
            np.array([slip]),
            np.array([bilateral]),
        )

    def _shape_faults(self) -> list[str]:
        """Return a sentence for each array that does not fit n contacts, n from slip_velocity."""
        n = self.slip_velocity.size
        of = (max(n, 1),)
        one_each = self.mu.shape == self.slip_velocity.shape == self.bilateral.shape == of == (n,)
        size = ContactRows(n).size
        if one_each and self.W.shape == (size, size) and self.b.shape == (size,):
            return []
        need = {"W": (size, size), "b": (size,), "mu": (n,), "slip_velocity": of}
        need["bilateral"] = (n,)
        return [
            f"{name}: got shape {getattr(self, name).shape}, need {shape} for {n} entries of "
            "slip_velocity. Fix: give two rows (n, t) of W and b for each contact."
            for name, shape in need.items()
            if getattr(self, name).shape != shape
        ]

    def _physical_faults(self) -> list[str]:
        """Return a sentence for each entry that no mechanism can have."""
        faults: list[str] = []
        if min(self.mu.tolist()) < 0:
            given = self.mu.item() if self.size == 1 else self.mu.tolist()
            faults.append(
                f"mu: got {given!r}, need mu >= 0. Fix: give the direction by slip_velocity."
            )
        if self.size == 1:
            (nn, nt), (tn, tt) = self.W.tolist()
            return faults + mobility_faults(nn, nt, tn, tt)
        return faults + mobility_matrix_faults(self.W, "n1, t1, n2, t2, ...")

    @property
    def size(self) -> int:
        """Return n, the number of contacts."""
        return int(self.mu.size)

    @cached_property
    def slip_directions(self) -> tuple[int, ...]:
        """Return the sign of each slip velocity: -1, 0 or +1."""
        return tuple(map(_sign, self.slip_velocity.tolist()))

    # ---- solutions ----

    def solutions(self) -> tuple[ContactSolution, ...]:
        """Find every consistent set of forces, ordered by the normal forces.

        A sliding contact lifts off or slips on; one at rest lifts off, begins to slip either way,
        or sticks; a bilateral contact pushes or pulls instead of lifting off. All choices are
        tried, each answer is checked by its residual, and forces met in several choices are one
        solution. Where a choice leaves a segment, ray or wider set of forces, one representative
        appears, with `isolated` False. An empty tuple is the inconsistent case.

        Raises
        ------
        InputError
            For more than `CONTACT_LIMIT` contacts. Fix: call `solve_lemke` for one solution.
        """
        self._refuse_many("solutions")
        law, checked, wide = self._law, list[_Checked](), list[tuple[int, ...]]()
        for point in law.product.points():
            answer = law.check(point.forces, point.choice)
            if answer is None:
                continue
            if point.wide:
                wide.append(point.choice)
            twin = law.twin(answer, checked)
            if twin is None:
                checked.append(answer)
            elif answer.residual < checked[twin].residual:
                checked[twin] = answer
        return tuple(
            law.solution(answer, not (wide and _any_holds(wide, law.possible(answer.forces))))
            for answer in _ordered(checked)
        )

    def solve_lemke(self, max_pivots: int | None = None) -> LemkeResult[ContactSolution]:
        """Find one consistent set of forces by Lemke's pivots, for any number of contacts.

        The pivots run on the formulation of Anitescu & Potra (1997), in which a contact at rest has
        the unknowns F_n, the two parts of F_t and its speeding-up. With all contacts at rest and W
        positive definite its matrix is copositive and the pivots end at a solution; the shorter
        `lcp` promises that only for little friction. With sliding contacts neither is promised.

        Parameters
        ----------
        max_pivots : int, optional
            Most pivots; 50 per complementary pair when not given.

        Raises
        ------
        InputError
            For bilateral contacts. Fix: call `solutions`.
        """
        self._refuse_bilateral("solve_lemke")
        lcp, ways = self._copositive_lcp()
        scaled, unit = equilibrate(lcp)
        limit = 50 * lcp.size if max_pivots is None else max_pivots
        status, z, pivots = pivot(scaled, limit, RESIDUAL_TOLERANCE)
        if z is None:
            return LemkeResult(status, None, pivots)
        answer = self._law.check(((ways @ (unit * z)) / self._law.unit).tolist())
        if answer is None:
            return LemkeResult(LemkeStatus.NOT_VERIFIED, None, pivots)
        return LemkeResult(status, self._law.solution(answer, self._isolated(answer)), pivots)

    def residual(self, forces: npt.ArrayLike) -> float:
        """Measure how far forces are from the laws of the contacts, free of units.

        The largest over all contacts of

        - ``min(F_n, |a_n|)`` and what is negative of F_n and a_n; ``|a_n|`` of a bilateral contact;
        - ``|F_t| - mu |F_n|`` where positive;
        - where a_t or v_t is not zero, what friction misses of opposing it at its limit: the
          smaller of ``|F_t + mu s |F_n||`` and (at v_t = 0) ``|a_t|``.

        Accelerations and friction count as a fraction of the sum of their terms, F_n by its largest
        share in any acceleration. Positive scaling of a contact or of units changes nothing, and
        rounding alone leaves some 1e-15.

        Parameters
        ----------
        forces : array_like, shape (2 n,)
            F_n1, F_t1, F_n2, F_t2, ... in N; entries that are not finite give ``inf``.

        Returns
        -------
        float
            0 for an exact solution, up to 1 otherwise.

        Raises
        ------
        InputError
            For another number of entries. Fix: give two entries for each contact.
        """
        point = np.asarray(forces, dtype=float)
        if point.shape != self.b.shape:
            raise InputError(
                f"residual cannot be measured, forces: got shape {point.shape}, need "
                f"{self.b.shape}. Fix: give F_n and F_t of each contact."
            )
        if not np.all(np.isfinite(point)):
            return math.inf
        return self._law.residual((point / self._law.unit).tolist())

    def uniqueness(self) -> Uniqueness:
        """Say beforehand what W, mu and the slip directions promise for every b.

        Raises
        ------
        InputError
            For more than `CONTACT_LIMIT` contacts. Fix: ask about fewer contacts.
        """
        self._refuse_many("uniqueness")
        product = self._law.product
        return uniqueness_of(product.pieces(), product.power_forms())

    @property
    def case(self) -> ContactCase:
        """Classify the problem; see `ContactCase` for the rule, borders included."""
        return self.case_of(self.solutions())

    def case_of(self, solutions: Sequence[ContactSolution]) -> ContactCase:
        """Classify the problem by all its solutions, as `solutions` returns them."""
        return case_of(solutions, self.b, self.size > 1)

    # ---- complementarity problems ----

    def lcp(self) -> LCP:
        """Return the complementarity problem of all contacts, contact by contact.

        A sliding contact has the pair ``z = F_n``, ``w = a_n`` with ``F_t = -mu s F_n``. One at
        rest has three (Glocker & Pfeiffer 1993). With friction reserves
        ``lambda_R = mu F_n + F_t``, ``lambda_L = mu F_n - F_t`` and ``a_t = a_t^+ - a_t^-`` (both
        parts >= 0) they are ``z = (F_n, lambda_R, a_t^-)`` and ``w = (a_n, a_t^+, lambda_L)``:
        speeding up along + uses up lambda_R, along - lambda_L. Where F_n = 0 or mu = 0, a_t^+ and
        a_t^- may grow together without changing a_t; `solution_from` removes that.

        Where all contacts are at rest and W is positive definite there is always a solution
        (Anitescu & Potra 1997): the inconsistent case needs slip, or a singular W.

        Raises
        ------
        InputError
            For bilateral contacts, whose law ``a_n = 0`` with ``|F_n|`` in the friction is not a
            complementarity. Fix: call `solutions`.
        """
        self._refuse_bilateral("lcp")
        directions, starts = self.slip_directions, self._pair_starts
        matrix, offset = np.zeros((starts[-1], starts[-1])), np.zeros(starts[-1])
        pairs = self._rows.each()
        for j, s in enumerate(directions):
            normal, tangential = self.W.T[list(pairs[j])]
            # An impossible sign left by rounding is removed, as in A_slip.
            slipping = rounded_difference(normal, (s or 1) * self.mu[j] * tangential)
            for i, t in enumerate(directions):
                (k, m), (leaving, speeding) = (starts[i], starts[j]), pairs[i]
                matrix[k, m] = slipping[leaving]
                if not t:
                    matrix[k + 1, m] = slipping[speeding]
                if not s:
                    matrix[k, m + 1] = tangential[leaving]
                if not (s or t):
                    matrix[k + 1, m + 1] = tangential[speeding]
        for i, s in enumerate(directions):
            k, (leaving, speeding) = starts[i], pairs[i]
            offset[k] = self.b[leaving]
            if not s:
                offset[k + 1] = self.b[speeding]
                matrix[k + 1, k + 2] = 1.0
                matrix[k + 2, k : k + 2] = 2.0 * self.mu[i], -1.0
        return LCP(matrix, offset)

    def forces_from(self, solution: LCPSolution) -> FloatArray:
        """Translate a solution of `lcp` into F_n1, F_t1, F_n2, ... in N, shape (2 n,).

        Raises
        ------
        InputError
            For another number of entries. Fix: solve this problem's `lcp`.
        """
        self._refuse_bilateral("forces_from")
        starts = self._pair_starts
        if solution.z.size != starts[-1]:
            raise InputError(
                f"solution cannot be translated, z: got {solution.z.size} entries at "
                f"slip_velocity = {self.slip_velocity.tolist()!r}, need {starts[-1]}. "
                "Fix: solve this problem's lcp()."
            )
        forces = np.zeros(self._rows.size)
        for i, (k, s) in enumerate(zip(starts, self.slip_directions, strict=False)):
            if not solution.active[k]:
                continue
            normal, limit = solution.z[k], self.mu[i] * solution.z[k]
            friction = -s * limit
            if not s:
                right, left = not solution.active[k + 1], solution.active[k + 2]
                edge = limit if left else -limit
                friction = edge if right or left or limit == 0 else solution.z[k + 1] - limit
            forces[self._rows.of(i)] = normal, friction + 0.0  # no -0.0
        return forces

    def solution_from(self, solution: LCPSolution) -> ContactSolution | None:
        """Translate a solution of `lcp`; None where the forces fail the check of this problem.

        Raises
        ------
        InputError
            As for `forces_from`.
        """
        answer = self._law.check((self.forces_from(solution) / self._law.unit).tolist())
        return None if answer is None else self._law.solution(answer, self._isolated(answer))

    @property
    def _rows(self) -> ContactRows:
        return ContactRows(self.size)

    @cached_property
    def _pair_starts(self) -> list[int]:
        """Return the first pair of each contact in `lcp`, and the number of pairs."""
        return [0, *np.cumsum([1 if s else 3 for s in self.slip_directions]).tolist()]

    def _copositive_lcp(self) -> tuple[LCP, FloatArray]:
        """Return the problem of Anitescu & Potra and the map from its z to the forces."""
        ways: list[FloatArray] = []
        rests: list[tuple[int, float]] = []  # columns of F_n at rest, with their friction
        for i, (mu, s) in enumerate(zip(self.mu, self.slip_directions, strict=True)):
            axes = np.eye(self._rows.size)[:, self._rows.of(i)]
            if s or mu == 0:
                ways.append(axes[:, 0] - mu * s * axes[:, 1])
            else:
                rests.append((len(ways), float(mu)))
                ways += [axes[:, 0], axes[:, 1], -axes[:, 1], 0.0 * axes[:, 0]]
        forces = np.array(ways).T
        # A force works on the acceleration along itself; a sliding one on a_n alone.
        partners = forces.copy()
        for i, s in enumerate(self.slip_directions):
            if s:
                partners[self._rows.tangent(i)] = 0.0
        matrix = partners.T @ self.W @ forces
        for k, mu in rests:
            matrix[k + 1 : k + 3, k + 3] = 1.0
            matrix[k + 3, k : k + 3] = mu, -1.0, -1.0
        return LCP(matrix, partners.T @ self.b), forces

    # ---- one contact ----

    def alone(self, i: int) -> ContactProblem:
        """Return the problem of one contact, the others open."""
        own = self._rows.of(i)
        one = slice(i, i + 1)
        mu, slip, held = self.mu[one], self.slip_velocity[one], self.bilateral[one]
        return ContactProblem(self.W[own, own], self.b[own], mu, slip, held)

    @property
    def W_nn(self) -> float:
        """Return the normal mobility of the only contact, in 1/kg."""
        return float(self._only("W_nn").W[0, 0])

    @property
    def W_nt(self) -> float:
        """Return the coupling of the only contact, in 1/kg."""
        return float(self._only("W_nt").W[0, 1])

    @property
    def W_tt(self) -> float:
        """Return the tangential mobility of the only contact, in 1/kg."""
        return float(self._only("W_tt").W[1, 1])

    @property
    def b_n(self) -> float:
        """Return the free normal acceleration of the only contact, in m/s²."""
        return float(self._only("b_n").b[0])

    @property
    def b_t(self) -> float:
        """Return the free tangential acceleration of the only contact, in m/s²."""
        return float(self._only("b_t").b[1])

    @property
    def friction(self) -> float:
        """Return mu of the only contact."""
        return float(self._only("friction").mu[0])

    @property
    def slip_direction(self) -> int:
        """Return the sign of v_t of the only contact: -1, 0 or +1."""
        return self._only("slip_direction").slip_directions[0]

    def A_slip(self, direction: int, side: int = 1) -> float:
        """Return ``A = W_nn - mu s W_nt`` of ``a_n = A F_n + B`` while slipping along s.

        A value within rounding of its two terms is returned as exactly 0, since its sign, and with
        it the case, would be an accident.

        Parameters
        ----------
        direction : int
            s = +1 for v_t > 0, -1 for v_t < 0.
        side : int
            The sign of F_n; -1 (``A = W_nn + mu s W_nt``) is possible for a bilateral contact only.

        Raises
        ------
        InputError
            For another direction. Fix: pass +1 or -1.
        """
        if direction not in (-1, 1):
            raise InputError(
                f"A_slip is not defined, direction: got {direction!r}, need +1 or -1. "
                "Fix: pass the sign of the slip velocity."
            )
        return float(rounded_difference(self.W_nn, direction * side * self.friction * self.W_nt))

    @property
    def A(self) -> float | None:
        """Return A for the present slip direction and F_n > 0, in 1/kg; None when v_t = 0."""
        return self.A_slip(self.slip_direction) if self.slip_direction else None

    @property
    def B(self) -> float:
        """Return B = b_n, in m/s²."""
        return self.b_n

    @property
    def A_stick(self) -> float:
        """Return A' = W_nn - W_nt²/W_tt of ``a_n = A' F_n + B'`` while sticking, in 1/kg."""
        return self.W_nn - self.W_nt**2 / self.W_tt

    @property
    def B_stick(self) -> float:
        """Return B' = b_n - W_nt b_t/W_tt, in m/s²."""
        return self.b_n - self.W_nt * self.b_t / self.W_tt

    def _only(self, name: str) -> ContactProblem:
        """Return this problem, or raise InputError where it has several contacts."""
        if self.size != 1:
            raise InputError(
                f"{name} belongs to one contact: got {self.size} contacts, need one. "
                "Fix: use the arrays W, b, mu and slip_velocity."
            )
        return self

    # ---- parts ----

    def _refuse_many(self, where: str) -> None:
        """Raise InputError for more contacts than can be enumerated."""
        if self.size > CONTACT_LIMIT:
            raise InputError(
                f"{where}() cannot try every local mode: got {self.size} contacts, need at most "
                f"{CONTACT_LIMIT}. Fix: call solve_lemke() for one solution."
            )

    def _refuse_bilateral(self, where: str) -> None:
        """Raise InputError for contacts that hold from both sides."""
        if np.any(self.bilateral):
            raise InputError(
                f"{where}() needs contacts that can open: got bilateral = "
                f"{self.bilateral.tolist()}. Fix: call solutions()."
            )

    @cached_property
    def _law(self) -> _ScaledLaw:
        """Return the scaled problem with the local modes of its contacts."""
        return _ScaledLaw(self)

    def _isolated(self, point: _Checked) -> bool | None:
        """Return whether no choice of local modes through these forces is wide.

        None where too many choices meet.
        """
        law = self._law
        possible = law.possible(point.forces)
        if math.prod(map(sum, possible)) > _MANY_MODES:
            return None
        meeting = [
            [mode for mode, flag in zip(given, flags, strict=True) if flag]
            for given, flags in zip(law.modes, possible, strict=True)
        ]
        return not any(near.wide for near in ModeProduct(law.W, law.b, meeting).points())


_STATED = "ContactProblem cannot be stated, "


class _Checked(NamedTuple):
    """2 n scaled forces that passed the check, with their modes and residual."""

    forces: Vector
    modes: tuple[ContactMode, ...]
    residual: float

    @property
    def largest(self) -> float:
        """Return the size of the largest force."""
        return max(map(abs, self.forces))


class _ScaledLaw:
    """The problem scaled to order one by powers of two, and the check of its answers.

    Forces here are those of the problem over `unit`, which rounds nothing. All is computed number
    by number: for the few contacts that a problem has, calls of NumPy take ten times as long.

    `given` are W and b of the problem, `directions` the signs of its slip velocities, `modes` the
    local modes of its contacts and `product` all choices of them. `weights` make forces comparable:
    the root of each mobility. `least` is the least normal force of each contact, at which it opens:
    0, or -inf where it holds from both sides.
    """

    def __init__(self, problem: ContactProblem) -> None:
        self.given: tuple[list[Vector], Vector] = problem.W.tolist(), problem.b.tolist()
        self.directions = problem.slip_directions
        self.W, self.b, self.mu, self.unit = scale_contacts(*self.given, problem.mu.tolist())
        held = problem.bilateral.tolist()
        self.least = [-math.inf if both else 0.0 for both in held]
        self.modes = list(map(local_modes, self.mu, self.directions, held))
        self.product = ModeProduct(self.W, self.b, self.modes)
        self._pairs = self.product.pairs
        self._normals = [n for n, _ in self._pairs]
        self.weights = [math.sqrt(row[k]) for k, row in enumerate(self.W)]

    def residual(self, forces: Vector) -> float:
        """Measure forces; see `ContactProblem.residual`."""
        return self._residual(forces, _accelerations(self.W, self.b, forces))

    def _residual(self, forces: Vector, motion: tuple[Vector, Vector]) -> float:
        """Measure forces whose accelerations are known, with the sizes of their terms."""
        a, terms = motion
        if not math.isfinite(sum(terms)):
            return math.inf
        share = list(map(ratio, a, terms))
        weights = self._share(list(map(abs, forces)), terms, rows=self._normals)
        residual = 0.0
        for i, (weight, s) in enumerate(zip(weights, self.directions, strict=True)):
            n, t = self._pairs[i]
            normal, tangential, leaving, speeding = forces[n], forces[t], share[n], share[t]
            held = abs(leaving)
            if self.least[i] == 0:
                held = max(weight if normal < 0 else min(weight, held), -leaving, 0.0)
            limit = self.mu[i] * abs(normal)
            span = abs(tangential) + limit
            cone = ratio(abs(tangential) - limit, span)
            way = s or _sign(speeding)
            opposing = ratio(abs(tangential + way * limit), span)
            if not s:
                opposing = min(opposing, abs(speeding))
            residual = max(residual, held, cone, opposing)
        return residual

    def check(self, forces: Vector, choice: tuple[int, ...] | None = None) -> _Checked | None:
        """Return the forces with negligible parts removed, or None if they are not a solution.

        Parameters
        ----------
        forces : list of 2 n float
            Scaled.
        choice : tuple of int, optional
            The local modes they were computed for; without it they follow from the forces.
        """
        best: _Checked | None = None
        moved: tuple[Vector, Vector] = [], []
        for candidate in self._candidates(forces):
            modes = self._modes(candidate, choice)
            settled = self._settled(candidate, modes)
            motion = _accelerations(self.W, self.b, settled)
            measured = self._residual(settled, motion)
            if best is None or measured < best.residual:
                named = self._named(settled, modes, motion)
                best = _Checked([force + 0.0 for force in settled], named, measured)  # no -0.0
                moved = motion
            if measured <= ROUNDING:
                break
        if best is None or best.residual > RESIDUAL_TOLERANCE or self._opposes(best, *moved):
            return None
        return best

    def _opposes(self, point: _Checked, a: Vector, terms: Vector) -> bool:
        """Return whether an open contact approaches, or friction drives a slip, beyond rounding.

        Where large forces cancel, what is small beside its terms is not yet rounding.
        """
        for (n, t), mode, s, least in zip(
            self._pairs, point.modes, self.directions, self.least, strict=True
        ):
            if point.forces[n] == least:
                wrong, size = -a[n], terms[n]
            elif s or mode is ContactMode.STICK:
                continue
            else:
                wrong, size = a[t] * _sign(point.forces[t]), terms[t]
            if wrong > SIGN * size:
                return True
        return False

    def _candidates(self, forces: Vector) -> Iterator[Vector]:
        """Yield the forces without what a solve may have left of zeros, and as they are.

        Noise is what is small beside the largest force in comparable units, or whole contacts that
        matter to no acceleration.
        """
        weighted = list(map(operator.mul, self.weights, map(abs, forces)))
        noise = _ROUND_OFF * max(weighted)
        if 0 < min(filter(None, weighted), default=0.0) <= noise:
            pairs = zip(forces, weighted, strict=True)
            yield [0.0 if 0 < value <= noise else force for force, value in pairs]
        yield forces
        terms = _accelerations(self.W, self.b, forces)[1]
        share = self._share([abs(force) for force in forces], terms)
        kept = list(forces)
        for n, t in self._pairs:
            if share[n] <= RESIDUAL_TOLERANCE and share[t] <= RESIDUAL_TOLERANCE:
                kept[n] = kept[t] = 0.0
        if kept != forces:
            yield kept

    def _modes(self, forces: Vector, choice: tuple[int, ...] | None) -> list[ContactMode]:
        """Return the modes of a choice, or those that the forces show."""
        if choice is not None:
            return [given[j].mode for given, j in zip(self.modes, choice, strict=True)]
        modes, a = [], _accelerations(self.W, self.b, forces)[0]
        for i, s in enumerate(self.directions):
            n, t = self._pairs[i]
            normal, tangential = forces[n], forces[t]
            inside = abs(tangential) < self.mu[i] * abs(normal) * (1 - 1e-9)
            if normal == self.least[i]:
                modes.append(ContactMode.LIFTOFF)
            elif s or not inside:
                modes.append(slip_mode(s or (-tangential if tangential else a[t])))
            else:
                modes.append(ContactMode.STICK)
        return modes

    def _settled(self, forces: Vector, modes: Sequence[ContactMode]) -> Vector:
        """Return the forces with F_n >= 0 where a contact can open, and F_t within its cone.

        Friction is on the edge of the cone exactly where the contact slips.
        """
        settled = list(forces)
        for i, mode in enumerate(modes):
            n, t = self._pairs[i]
            normal, tangential = forces[n], forces[t]
            if normal <= self.least[i]:
                settled[n] = settled[t] = 0.0
                continue
            limit = self.mu[i] * abs(normal)
            if mode is ContactMode.SLIP_POS:
                tangential = -limit
            elif mode is ContactMode.SLIP_NEG:
                tangential = limit
            settled[t] = min(max(tangential, -limit), limit)
        return settled

    def _named(
        self, forces: Vector, modes: Sequence[ContactMode], motion: tuple[Vector, Vector]
    ) -> tuple[ContactMode, ...]:
        """Return the modes, borders by the convention of `ContactMode`."""
        a, terms = motion
        named = []
        for i, (mode, s) in enumerate(zip(modes, self.directions, strict=True)):
            n, t = self._pairs[i]
            rate, size = a[t], terms[t]
            word = mode
            if forces[n] == self.least[i]:
                word = ContactMode.LIFTOFF
            elif not s and (mode is not ContactMode.STICK or abs(rate) > RESIDUAL_TOLERANCE * size):
                # Without friction, or where F_n = 0, the acceleration alone tells the direction.
                word = ContactMode.STICK if abs(rate) <= ROUNDING * size else slip_mode(rate)
            named.append(word)
        return tuple(named)

    def twin(self, point: _Checked, known: Sequence[_Checked]) -> int | None:
        """Return the position of the same forces among those known, or None."""
        for k, other in enumerate(known):
            near = _NEAR * max(point.largest, other.largest)
            if all(
                abs(p - q) <= near for p, q in zip(point.forces, other.forces, strict=True)
            ) and self._same(point.forces, other.forces):
                return k
        return None

    def _same(self, first: Vector, second: Vector) -> bool:
        """Return whether the step between two forces is negligible for every acceleration."""
        pairs = list(zip(first, second, strict=True))
        size = [max(abs(p), abs(q)) for p, q in pairs]
        # Where forces balance, every term of an acceleration may be rounding: noise is none.
        noise = _ROUND_OFF * max(w * s for w, s in zip(self.weights, size, strict=True))
        step = [
            0.0 if w > 0 and w * abs(p - q) <= noise else abs(p - q)
            for w, (p, q) in zip(self.weights, pairs, strict=True)
        ]
        terms = _accelerations(self.W, self.b, size)[1]
        return all(share <= DISTINCT for share in self._share(step, terms, size))

    def _share(
        self,
        part: Vector,
        terms: Vector,
        whole: Vector | None = None,
        rows: Sequence[int] | None = None,
    ) -> Vector:
        """Return how much each part of the forces matters to any acceleration, by its terms.

        With `rows` only of the forces there.
        """
        shares = []
        pairs = list(zip(self.W, terms, strict=True))
        for k in rows or range(len(part)):
            value, share, moves = part[k], 0.0, False
            for row, size in pairs:
                w = row[k]
                if w:
                    moves = True
                    if size > 0:
                        own = abs(w) * value / size
                        if own > share:
                            share = own
            if not moves and value > 0:  # where nothing moves, forces count by themselves
                share = 1.0 if whole is None else value / whole[k]
            shares.append(share)
        return shares

    def possible(self, forces: Vector) -> list[list[bool]]:
        """Return for each contact which of its local modes hold these forces, borders included."""
        a, terms = _accelerations(self.W, self.b, forces)
        share = [ratio(value, size) for value, size in zip(a, terms, strict=True)]
        rows = map(self.product.rows.of, range(len(self.mu)))
        return [
            [mode.holds(forces[pair], share[pair]) for mode in given]
            for given, pair in zip(self.modes, rows, strict=True)
        ]

    def solution(self, point: _Checked, isolated: bool | None) -> ContactSolution:
        """Return checked forces with their accelerations, in the units of the problem."""
        forces = list(map(operator.mul, self.unit, point.forces))
        a, terms = _accelerations(*self.given, forces)
        a = [0.0 if abs(v) <= ROUNDING * t else v for v, t in zip(a, terms, strict=True)]
        lift, stick, pairs = ContactMode.LIFTOFF, ContactMode.STICK, self._pairs
        # What the mode fixes at 0 is exactly 0.
        parted = [a[n] if m is lift else 0.0 for (n, _), m in zip(pairs, point.modes, strict=True)]
        sliding = [
            0.0 if m is stick else a[t] for (_, t), m in zip(pairs, point.modes, strict=True)
        ]
        given = [forces[n] for n, _ in pairs], [forces[t] for _, t in pairs]
        numbers = np.array((*given, parted, sliding))
        numbers.setflags(write=False)
        normal, tangential, a_n, a_t = numbers
        return ContactSolution(point.modes, normal, tangential, a_n, a_t, point.residual, isolated)


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


def finite_array(value: object, name: str) -> tuple[FloatArray, str]:
    """Return numbers as an array, and a sentence where they are not finite numbers."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError):
        array = np.array(math.nan)
    entries = array.ravel().tolist()
    # A finite sum has finite terms; a sum of finite terms may overflow.
    if math.isfinite(sum(entries)) or all(map(math.isfinite, entries)):
        return array, ""
    return array, (
        f"{name}: got {received(value)}, need finite numbers. "
        "Fix: check the state it was evaluated at."
    )


def mobility_matrix_faults(W: FloatArray, order: str) -> list[str]:
    """Return a sentence where a mobility is not symmetric or indefinite; `order` names its rows."""
    rows = W.tolist()
    root = [math.sqrt(max(row[k], 0.0)) for k, row in enumerate(rows)]
    scaled: list[Vector] = []  # the triangle up to the diagonal
    for i, (row, r) in enumerate(zip(rows, root, strict=True)):
        own: Vector = []
        for j in range(i + 1):
            w, v, bound = row[j], rows[j][i], r * root[j]
            if abs(w - v) > SYMMETRY * bound or (bound == 0 and (w != 0 or v != 0)):
                return [
                    f"W: got {W!r}, need a symmetric matrix with rows of zeros where the "
                    "diagonal is 0. Fix: compute it as J M^-1 J' with rows "
                    f"{order} of J."
                ]
            own.append(w / bound if bound else 0.0)
        scaled.append(own)
    least = INDEFINITE * len(rows)
    if _factorizes(scaled, least / 2):
        return []
    lower = np.zeros((len(rows), len(rows)))
    for i, own in enumerate(scaled):
        lower[i, : i + 1] = own
    if np.min(np.linalg.eigvalsh(lower, UPLO="L")) >= -least:
        return []
    return [
        f"W: got {W!r}, need a positive semidefinite matrix. "
        "Fix: compute it as J M^-1 J' with a positive definite mass matrix M."
    ]


def _factorizes(matrix: list[Vector], shift: float) -> bool:
    """Return whether a matrix plus `shift` times the identity has a Cholesky factor.

    Then no eigenvalue of the matrix lies below -shift by more than rounding. Few numbers: the
    eigenvalues themselves would take NumPy longer.

    Parameters
    ----------
    matrix : list of rows
        Symmetric, with a diagonal of ones and zeros; rows up to the diagonal.
    shift : float
    """
    factor: list[Vector] = []
    mul = operator.mul
    for i, row in enumerate(matrix):
        own: Vector = []
        for j, other in enumerate(factor):
            own.append((row[j] - sum(map(mul, own, other))) / other[j])
        rest = row[i] + shift - sum(map(mul, own, own))
        if not rest > 0:
            return False
        own.append(math.sqrt(rest))
        factor.append(own)
    return True


def _ordered(points: list[_Checked]) -> list[_Checked]:
    """Return the points by their normal forces, then by the tangential ones.

    Forces that differ by rounding alone are equal here: it must not decide the order.
    """
    if len(points) < 2:
        return points
    at = ContactRows(len(points[0].modes))
    forces = [(*p.forces[at.normals], *p.forces[at.tangentials]) for p in points]
    ranks = [_levels(column) for column in zip(*forces, strict=True)]
    return [points[k] for k in sorted(range(len(points)), key=lambda k: [r[k] for r in ranks])]


def _levels(values: Sequence[float]) -> list[int]:
    """Return the rank of each value, the same for values that differ by rounding alone."""
    near = DISTINCT * max(map(abs, values))
    ranks, level, last = [0] * len(values), 0, -math.inf
    for k in sorted(range(len(values)), key=values.__getitem__):
        level += values[k] - last > near
        ranks[k], last = level, values[k]
    return ranks


def _accelerations(W: list[Vector], b: Vector, forces: Vector) -> tuple[Vector, Vector]:
    """Return ``W F + b``, and the sum of the sizes of the terms of each entry."""
    # Term by term, so that one contact has W_nn F_n + W_nt F_t + b_n literally.
    rates, sizes = [], []
    for row, free in zip(W, b, strict=True):
        rate = size = 0.0
        for term in map(operator.mul, row, forces):
            rate += term
            size += abs(term)
        rates.append(rate + free)
        sizes.append(size + abs(free))
    return rates, sizes


def ratio(part: float, whole: float) -> float:
    """Return part / whole, 0 where there is nothing."""
    return part / whole if whole > 0 else 0.0


def _sign(value: float) -> int:
    return (value > 0) - (value < 0)


def _any_holds(choices: list[tuple[int, ...]], possible: Sequence[Sequence[bool]]) -> bool:
    """Return whether one of the choices holds the forces that are possible in each contact."""
    return any(all(held[j] for held, j in zip(possible, choice, strict=True)) for choice in choices)
