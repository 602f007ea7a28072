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

import math
from collections.abc import Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from painleve_sym.blas_threads import UNTHREADED, one_blas_thread
from painleve_sym.errors import InputError
from painleve_sym.problem.answers import REGULAR, Answers, MotionWithForces, openness
from painleve_sym.problem.complementarity.lcp import (
    LCP,
    RESIDUAL_TOLERANCE,
    LCPSolution,
    equilibrate,
)
from painleve_sym.problem.complementarity.lemke import LemkeResult, LemkeStatus, pivot
from painleve_sym.problem.complementarity.solution_sets import FloatArray
from painleve_sym.problem.complementarity.uniqueness import Uniqueness, uniqueness_of
from painleve_sym.problem.contact_lcp import complementarity_of, copositive, forces_of
from painleve_sym.problem.modes import CONTACT_LIMIT
from painleve_sym.problem.only_contact import OnlyContact
from painleve_sym.problem.products import PieceProduct
from painleve_sym.problem.solution import ContactCase, ContactSolution, case_of, solution_of
from painleve_sym.problem.statement import is_brake

MAX_RESTING = 4
"""Most contacts in space at rest: all directions of five at once take minutes to search."""


class ContactProblem(OnlyContact):
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

    def __repr__(self) -> str:
        """Return the number of contacts, their friction and their slip in one line."""
        given = self.mu.tolist(), self.slip_velocity.tolist()
        mu, slip = (", ".join(f"{v:.6g}" for v in values) for values in given)
        return f"ContactProblem of {self._described}: mu = {mu}; slip {slip} m/s"

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
        answers = self._answers
        return tuple([solution_of(answers.law, answer) for answer in answers.all])

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

    @one_blas_thread()
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
        product = PieceProduct(self._law)
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
    def _answers(self) -> Answers:
        self._refuse_many("solutions")
        law = self._law
        resting = law.layout.turning
        if resting > MAX_RESTING:
            raise InputError(
                f"solutions() would search for minutes: got {self.size} contacts, {resting} "
                f"of them in space at rest, need at most {MAX_RESTING}. "
                "Fix: ask about fewer contacts."
            )
        if len(law.b) <= UNTHREADED:
            return Answers(law)
        with one_blas_thread():
            return Answers(law)

    def _scaled(self, forces: FloatArray) -> list[float]:
        """Return forces by rows of W as those of the scaled law, with what presses brakes."""
        pressing = [own[0].mu for own in self.friction if is_brake(own)]
        whole: list[float] = (np.append(forces, pressing) / self._law.unit).tolist()
        return whole

    def _solution_of(self, forces: FloatArray) -> ContactSolution | None:
        """Return forces as a solution, or None where they fail the check."""
        law = self._law
        checked = law.check(self._scaled(forces))
        if checked is None:
            return None
        return solution_of(law, MotionWithForces(checked, *openness(law, checked)))
