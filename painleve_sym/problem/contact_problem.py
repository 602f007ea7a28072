"""Contacts with Coulomb friction: which forces and accelerations are consistent.

What follows is about the plane; page *The paradox in three dimensions* has the same in space.

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

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from painleve_sym.checks import checked_number, mobility_faults
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.problem.answers import REGULAR, Answer, Answers, openness
from painleve_sym.problem.array_checks import finite_array, mobility_matrix_faults
from painleve_sym.problem.complementarity.lcp import (
    LCP,
    RESIDUAL_TOLERANCE,
    LCPSolution,
    equilibrate,
)
from painleve_sym.problem.complementarity.lemke import LemkeResult, LemkeStatus, pivot
from painleve_sym.problem.complementarity.solution_sets import BoolArray, FloatArray
from painleve_sym.problem.complementarity.uniqueness import Uniqueness, uniqueness_of
from painleve_sym.problem.constraints import Ball, Constraint, pieces
from painleve_sym.problem.contact_lcp import complementarity_of, copositive, forces_of
from painleve_sym.problem.friction_set import Interval
from painleve_sym.problem.law import ScaledLaw
from painleve_sym.problem.modes import CONTACT_LIMIT, sign_of
from painleve_sym.problem.products import PieceProduct
from painleve_sym.problem.risk import held
from painleve_sym.problem.rounding import rounded_difference
from painleve_sym.problem.solution import ContactCase, ContactSolution, case_of, solution_of
from painleve_sym.problem.statement import (
    STATED,
    disc,
    friction_sets,
    interval,
    is_brake,
    joined,
    planar,
    pressed,
    shape_fault,
)

MAX_RESTING = 4
"""Most contacts in space at rest: all directions of five at once take minutes to search."""


@dataclass(frozen=True, eq=False)
class ContactProblem(Compared):
    """State the contact problem of n closed contacts, all with zero normal velocity.

    Parameters
    ----------
    W : array_like, shape (r, r)
        Mobility ``J M^-1 J'`` (Delassus matrix), contact by contact: rows n, t in the plane, n,
        t1, t2 in space; in 1/kg, symmetric and positive semidefinite. Singular is allowed and
        usual: one planar body has three degrees of freedom, so two contacts on it already leave
        rank 3 of 4.
    b : array_like, shape (r,)
        Accelerations without contact force, in the same order, in m/s².
    friction : array_like of n numbers, or sequence of n entries
        Friction coefficients, >= 0; a number for one contact. They mean intervals in the plane and
        discs in space, as the number of rows says. Or for each contact an `Interval`, a `Disc`, a
        tuple of these for several rows of friction of one contact, such as rolling resistance (the
        empty one for a contact without tangents), or a `Brake`, which has one row alone.
    slip_velocity : array_like
        Velocity along each tangential row, in m/s: shape (n,) in the plane, (n, 2) in space. Only
        the direction matters, and exactly 0 means at rest. A number for one planar contact.
    bilateral : array_like of bool, shape (n,)
        Which contacts hold from both sides, as a guide or a pin does that closes a chain; one value
        for all contacts, none by default.

    Attributes
    ----------
    W, b, bilateral : ndarray
    friction : tuple of tuples of FrictionSet
        The balls of friction of each contact.
    slip_velocity : ndarray, shape (number of tangential rows,)

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

    The same contact in space:

    >>> W = [[4.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 2.0]]
    >>> [solution] = ps.ContactProblem(W, [-9.8, 0.0, 0.0], 0.5, [(-1.0, 0.0)]).solutions()
    >>> solution.mode.value, solution.force.round(6).tolist()
    ('slip', [2.177778, 1.088889, 0.0])
    """

    W: FloatArray
    b: FloatArray
    friction: Any
    slip_velocity: Any
    bilateral: BoolArray = field(default_factory=lambda: np.zeros((), np.bool_))

    def __post_init__(self) -> None:
        """Check every array and keep read-only copies."""
        faults: list[str] = []
        fields = vars(self)
        for name in ("W", "b"):
            fields[name], fault = finite_array(fields[name], name)
            faults += [fault] * bool(fault)
        sets = friction_sets(self.friction)
        if sets is None:
            faults += self._state_numbers()
        else:
            fields["friction"] = sets
            fields["slip_velocity"], fault = joined(self.slip_velocity)
            faults += [fault] * bool(fault)
        count = len(self.friction)
        sides = np.array(self.bilateral, dtype=bool)
        fields["bilateral"] = np.full((count,), sides) if sides.ndim == 0 else sides
        faults = faults or self._shape_faults() or self._physical_faults()
        if faults:
            raise InputError(STATED + " Also, ".join(faults))
        rows = self.W.tolist()
        if rows != list(map(list, zip(*rows, strict=True))):
            fields["W"] = (self.W + self.W.T) / 2
        for array in (self.W, self.b, self.slip_velocity, self.bilateral):
            array.setflags(write=False)

    def _state_numbers(self) -> list[str]:
        """Take friction coefficients for intervals or discs; return the faults."""
        fields, faults = vars(self), list[str]()
        mu, fault = finite_array(self.friction, "mu")
        faults += [fault] * bool(fault)
        slip, fault = finite_array(self.slip_velocity, "slip_velocity")
        faults += [fault] * bool(fault)
        mu, slip = (v.reshape(1) if v.ndim == 0 else v for v in (mu, slip))
        fields["friction"], fields["slip_velocity"] = (), slip
        if faults:
            return faults
        values = mu.tolist() if mu.ndim == 1 else []
        if values and min(values) < 0:
            given = values[0] if len(values) == 1 else values
            fault = f"mu: got {given!r}, need mu >= 0. Fix: give the direction by slip_velocity."
            return [fault, *self._mobility_faults()]
        in_space = np.shape(self.W)[:1] == (3 * mu.size,) and mu.size > 0
        if in_space and slip.shape in ((mu.size, 2), (2 * mu.size,)):
            fields["friction"] = tuple(map(disc, values))
            fields["slip_velocity"] = slip.ravel()
        elif mu.shape != slip.shape or mu.ndim != 1:
            n = slip.size
            need: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
                "mu": (mu.shape, (n,)),
                "slip_velocity": (slip.shape, (max(n, 1),)),
                "W": (self.W.shape, (2 * n, 2 * n)),
                "b": (self.b.shape, (2 * n,)),
            }
            return [
                shape_fault(name, *pair, n) for name, pair in need.items() if pair[0] != pair[1]
            ]
        else:
            fields["friction"] = tuple(map(interval, values))
        return []

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
            raise InputError(STATED + " Also, ".join(faults))
        nn, nt, tt, n, t, friction, slip = values
        return cls(
            np.array([[nn, nt], [nt, tt]]),
            np.array([n, t]),
            np.array([friction]),
            np.array([slip]),
            np.array([bilateral]),
        )

    def _shape_faults(self) -> list[str]:
        """Return a sentence for each array that does not fit the contacts."""
        n = len(self.friction)
        plane = (2 * n, 2 * n), (2 * n,), (n,), (n,)
        given = self.W.shape, self.b.shape, self.slip_velocity.shape, self.bilateral.shape
        if n and given == plane and self.in_plane:
            return []
        rows, tangents = self.rows, sum(self.tangents)
        size = rows[-1][-1] + 1 if n and rows[-1] else 0
        need = {"W": (size, size), "b": (size,), "slip_velocity": (tangents,), "bilateral": (n,)}
        if not n:
            need["slip_velocity"] = (1,)
        return [
            shape_fault(name, getattr(self, name).shape, shape, n)
            for name, shape in need.items()
            if getattr(self, name).shape != shape
        ]

    def _physical_faults(self) -> list[str]:
        """Return a sentence for each entry that no mechanism can have."""
        if any(
            is_brake(own) and both for own, both in zip(self.friction, self.bilateral, strict=True)
        ):
            return ["bilateral: got a Brake that holds from both sides, which has no normal row."]
        return self._mobility_faults()

    def _mobility_faults(self) -> list[str]:
        if self.W.shape == (2, 2):
            (nn, nt), (tn, tt) = self.W.tolist()
            return mobility_faults(nn, nt, tn, tt)
        square = self.W.ndim == 2 and len(set(self.W.shape)) == 1
        return mobility_matrix_faults(self.W, self._row_names) if square else []

    @property
    def _row_names(self) -> str:
        if self.in_plane:
            return "n1, t1, n2, t2, ..."
        return "n, t1, t2 of each disc, n, t of each interval"

    @property
    def size(self) -> int:
        """Return n, the number of contacts."""
        return len(self.friction)

    @cached_property
    def mu(self) -> FloatArray:
        """The first friction coefficient of each contact, 0 without one; shape (n,)."""
        return np.array([own[0].mu if own else 0.0 for own in self.friction])

    @cached_property
    def tangents(self) -> tuple[int, ...]:
        """The number of tangential rows of each contact."""
        return tuple([sum([ball.n_tangents for ball in own]) for own in self.friction])

    @cached_property
    def in_plane(self) -> bool:
        """Whether every contact has the rows n, t."""
        return all(len(own) == 1 and type(own[0]) is Interval for own in self.friction)

    @cached_property
    def rows(self) -> tuple[tuple[int, ...], ...]:
        """The rows of each contact, the normal one first; a `Brake` has none."""
        starts, rows = 0, []
        for own, tangents in zip(self.friction, self.tangents, strict=True):
            end = starts + tangents + (not is_brake(own))
            rows.append(tuple(range(starts, end)))
            starts = end
        return tuple(rows)

    @cached_property
    def slips(self) -> tuple[tuple[float, ...], ...]:
        """The slip velocity of each contact along its tangential rows."""
        values = iter(self.slip_velocity.tolist())
        return tuple(tuple(itertools.islice(values, count)) for count in self.tangents)

    @cached_property
    def slip_directions(self) -> tuple[int, ...]:
        """Return the sign of each slip velocity: -1, 0 or +1."""
        return tuple(map(sign_of, self.slip_velocity.tolist()))

    # ---- solutions ----

    def solutions(self) -> tuple[ContactSolution, ...]:
        """Find every consistent motion with its forces, ordered by the normal forces.

        A sliding contact lifts off or slips on; one at rest lifts off, begins to slip, or sticks; a
        bilateral contact pushes or pulls instead of lifting off. All choices are tried, each answer
        is checked by its residual, and each motion appears once. Where its forces are open,
        `open_forces` is not 0 and the shortest ones appear. Of a continuum of motions some appear,
        with `moves` True. An empty tuple is the inconsistent case where the result is `complete`.

        Raises
        ------
        InputError
            For more than `CONTACT_LIMIT` contacts, or `MAX_RESTING` in space at rest. Fix: in the
            plane, call `solve_lemke` for one solution.
        """
        self._refuse_many("solutions")
        return tuple(map(self._solution, self._answers.all))

    @property
    def complete(self) -> bool:
        """Whether `solutions` returns every motion, up to those of a continuum.

        It does unless several discs may begin to slip at once.
        """
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
        rests = not any(map(any, self.slips)) and not any(self.bilateral.tolist())
        if rests and answers.least_eigenvalue > REGULAR:
            text += " With all contacts at rest and W positive definite there is at least one."
        if answers.missed:
            text += " Their number is even, which proves that there are more."
        return text

    @property
    def borders(self) -> tuple[str, ...]:
        """Borders on which the problem lies within some 1e-8, where a neighbour has another case.

        ``grazing``: a contact neither presses nor leaves. ``edge``: friction at its limit without
        slip. ``infinity``: a neighbouring problem has forces of any size.
        """
        self._refuse_many("borders")
        return tuple(sorted(self._answers.borders))

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
        lcp, ways = copositive(self)
        scaled, unit = equilibrate(lcp)
        limit = 50 * lcp.size if max_pivots is None else max_pivots
        status, z, pivots = pivot(scaled, limit, RESIDUAL_TOLERANCE)
        if z is None:
            return LemkeResult(status, None, pivots)
        answer = self._solution_of(ways @ (unit * z))
        return LemkeResult(status if answer else LemkeStatus.NOT_VERIFIED, answer, pivots)

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
        return self._law.residual(self._scaled(point))

    def uniqueness(self) -> Uniqueness:
        """Say beforehand what W, mu and the slip directions promise for every b.

        Raises
        ------
        InputError
            For more than `CONTACT_LIMIT` contacts. Fix: ask about fewer contacts.
        """
        self._refuse_many("uniqueness")
        if not self.in_plane:
            raise InputError(
                f"uniqueness() needs contacts in the plane: got {self._described}. "
                "Fix: see `guarantee` of the solutions."
            )
        law = self._law
        product = PieceProduct(law, list(map(pieces, law.constraints)))
        return uniqueness_of(product.pieces(), product.power_forms())

    @property
    def case(self) -> ContactCase:
        """Classify the problem; see `ContactCase` for the rule, borders included."""
        return self.case_of(self.solutions())

    def case_of(self, solutions: Sequence[ContactSolution]) -> ContactCase:
        """Classify the problem by all its solutions, as `solutions` returns them."""
        return case_of(solutions, self.size > 1, self.complete)

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
        return complementarity_of(self)

    def forces_from(self, solution: LCPSolution) -> FloatArray:
        """Translate a solution of `lcp` into F_n1, F_t1, F_n2, ... in N, shape (2 n,).

        Raises
        ------
        InputError
            For another number of entries. Fix: solve this problem's `lcp`.
        """
        self._refuse_bilateral("forces_from")
        return forces_of(self, solution)

    def solution_from(self, solution: LCPSolution) -> ContactSolution | None:
        """Translate a solution of `lcp`; None where the forces fail the check of this problem.

        Raises
        ------
        InputError
            As for `forces_from`.
        """
        return self._solution_of(self.forces_from(solution))

    # ---- one contact ----

    def alone(self, i: int) -> ContactProblem:
        """Return the problem of one contact, the others open."""
        own, one = list(self.rows[i]), slice(i, i + 1)
        W, b = self.W[np.ix_(own, own)], self.b[own]
        slip = [self.slips[i]]
        return ContactProblem(W, b, list(self.friction[one]), slip, self.bilateral[one])

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
        return float(rounded_difference(self.W_nn, direction * side * self.mu.item() * self.W_nt))

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
        """Return A' = W_nn - W_nt²/W_tt of ``a_n = A' F_n + B'`` while sticking, in 1/kg.

        W_nn where no motion slides the contact, W_tt = 0.
        """
        return float(held(self._only("A_stick").W, self.b, 1)[0].item())

    @property
    def B_stick(self) -> float:
        """Return B' = b_n - W_nt b_t/W_tt, in m/s²; b_n where W_tt = 0."""
        return float(held(self._only("B_stick").W, self.b, 1)[1].item())

    def _only(self, name: str) -> ContactProblem:
        """Return this problem, or raise InputError where it is not one contact in the plane."""
        if self.size != 1 or not self.in_plane:
            raise InputError(
                f"{name} belongs to one contact in the plane: got {self._described}. "
                "Fix: use the arrays W, b, mu and slip_velocity."
            )
        return self

    @property
    def _described(self) -> str:
        contacts = "one contact" if self.size == 1 else f"{self.size} contacts"
        return contacts if self.in_plane else f"{contacts}, not with the rows n, t"

    # ---- parts ----

    def _refuse_many(self, where: str) -> None:
        if len(self.friction) <= CONTACT_LIMIT:
            return
        count = sum(
            not both or any(ball.mu for ball in own)
            for own, both in zip(self.friction, self.bilateral.tolist(), strict=True)
        )
        if count > CONTACT_LIMIT:
            raise InputError(
                f"{where}() cannot try every local mode: got {count} contacts, need at most "
                f"{CONTACT_LIMIT}. Fix: call solve_lemke() for one solution."
            )

    def _refuse_bilateral(self, where: str) -> None:
        if not self.in_plane:
            raise InputError(
                f"{where}() needs contacts in the plane: got {self._described}. "
                "Fix: call solutions()."
            )
        if np.any(self.bilateral):
            raise InputError(
                f"{where}() needs contacts that can open: got bilateral = "
                f"{self.bilateral.tolist()}. Fix: call solutions()."
            )

    @cached_property
    def _law(self) -> ScaledLaw:
        W, b = self.W.tolist(), self.b.tolist()
        if self.in_plane:
            given = zip(self.friction, self.slip_directions, self.bilateral.tolist(), strict=True)
            constraints = [planar(i, own[0].mu, s, both) for i, (own, s, both) in enumerate(given)]
            return ScaledLaw(W, b, constraints)
        constraints = []
        for i, (own, rows, slip) in enumerate(
            zip(self.friction, self.rows, self.slips, strict=True)
        ):
            if is_brake(own):
                constraints.append(pressed(W, b, own[0], rows[0], slip))
                continue
            balls, start = [], 1
            for ball in own:
                end = start + ball.n_tangents
                way = ball.direction(slip[start - 1 : end - 1])
                balls.append(Ball(rows[start:end], ball.mu, way))
                start = end
            both = bool(self.bilateral[i])
            constraints.append(
                Constraint(rows[0], tuple(balls), not both, (1, -1) if both else (1,))
            )
        return ScaledLaw(W, b, constraints)

    @cached_property
    def _answers(self) -> Answers:
        self._refuse_many("solutions")
        law = self._law
        balls = [] if law.plain else [ball for c in law.constraints for ball in c.balls]
        resting = sum(ball.turns for ball in balls)
        if resting > MAX_RESTING:
            raise InputError(
                f"solutions() would search for minutes: got {self.size} contacts, {resting} "
                f"of them in space at rest, need at most {MAX_RESTING}. "
                "Fix: ask about fewer contacts."
            )
        return Answers(law)

    def _scaled(self, forces: FloatArray) -> list[float]:
        """Return forces by rows of W as those of the scaled law, with what presses brakes."""
        pressing = [own[0].mu for own in self.friction if is_brake(own)]
        whole: list[float] = (np.append(forces, pressing) / self._law.unit).tolist()
        return whole

    def _solution(self, answer: Answer) -> ContactSolution:
        return solution_of(self._law, answer, self.tangents)

    def _solution_of(self, forces: FloatArray) -> ContactSolution | None:
        """Return forces as a solution, or None where they fail the check."""
        law = self._law
        checked = law.check(self._scaled(forces))
        if checked is None:
            return None
        return self._solution(Answer(checked, *openness(law, checked)))
