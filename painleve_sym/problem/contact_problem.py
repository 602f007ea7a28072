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

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt

from painleve_sym.checks import checked_number, mobility_faults
from painleve_sym.complementarity.lcp import LCP, RESIDUAL_TOLERANCE, LCPSolution, equilibrate
from painleve_sym.complementarity.lemke import LemkeResult, LemkeStatus, pivot
from painleve_sym.complementarity.solution_sets import BoolArray, FloatArray
from painleve_sym.complementarity.uniqueness import Uniqueness, uniqueness_of
from painleve_sym.contact_rows import ContactRows
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.problem.answers import Answer, Answers, openness
from painleve_sym.problem.array_checks import finite_array, mobility_matrix_faults
from painleve_sym.problem.constraints import Ball, Constraint, pieces
from painleve_sym.problem.law import ScaledLaw
from painleve_sym.problem.modes import CONTACT_LIMIT, rounded_difference, sign_of
from painleve_sym.problem.products import PieceProduct
from painleve_sym.problem.risk import held
from painleve_sym.problem.solution import ContactCase, ContactSolution, case_of, planar_solution

_STATED = "ContactProblem cannot be stated, "


@dataclass(frozen=True, eq=False)
class ContactProblem(Compared):
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
        return tuple(map(sign_of, self.slip_velocity.tolist()))

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
        answers = self._answers
        return tuple(planar_solution(answers.law, answer) for answer in answers.all)

    @property
    def complete(self) -> bool:
        """Whether `solutions` returns every motion, up to those of a continuum: always."""
        return True

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
        lcp, ways = self._copositive_lcp()
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
        return self._law.residual((point / self._law.unit).tolist())

    def uniqueness(self) -> Uniqueness:
        """Say beforehand what W, mu and the slip directions promise for every b.

        Raises
        ------
        InputError
            For more than `CONTACT_LIMIT` contacts. Fix: ask about fewer contacts.
        """
        self._refuse_many("uniqueness")
        law = self._law
        product = PieceProduct(law, list(map(pieces, law.constraints)))
        return uniqueness_of(product.pieces(), product.power_forms())

    @property
    def case(self) -> ContactCase:
        """Classify the problem; see `ContactCase` for the rule, borders included."""
        return self.case_of(self.solutions())

    def case_of(self, solutions: Sequence[ContactSolution]) -> ContactCase:
        """Classify the problem by all its solutions, as `solutions` returns them."""
        return case_of(solutions, self.size > 1)

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
        return self._solution_of(self.forces_from(solution))

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
        """Return A' = W_nn - W_nt²/W_tt of ``a_n = A' F_n + B'`` while sticking, in 1/kg.

        W_nn where no motion slides the contact, W_tt = 0.
        """
        return float(held(self._only("A_stick").W, self.b, 1)[0].item())

    @property
    def B_stick(self) -> float:
        """Return B' = b_n - W_nt b_t/W_tt, in m/s²; b_n where W_tt = 0."""
        return float(held(self._only("B_stick").W, self.b, 1)[1].item())

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
        if self.size > CONTACT_LIMIT:
            raise InputError(
                f"{where}() cannot try every local mode: got {self.size} contacts, need at most "
                f"{CONTACT_LIMIT}. Fix: call solve_lemke() for one solution."
            )

    def _refuse_bilateral(self, where: str) -> None:
        if np.any(self.bilateral):
            raise InputError(
                f"{where}() needs contacts that can open: got bilateral = "
                f"{self.bilateral.tolist()}. Fix: call solutions()."
            )

    @cached_property
    def _law(self) -> ScaledLaw:
        constraints = []
        for i, (mu, s, both) in enumerate(
            zip(self.mu.tolist(), self.slip_directions, self.bilateral.tolist(), strict=True)
        ):
            ball = Ball((2 * i + 1,), mu, (float(s),) if s else ())
            sides = (1, -1) if both else (1,)
            constraints.append(Constraint(2 * i, (ball,), not both, sides))
        return ScaledLaw(self.W.tolist(), self.b.tolist(), constraints)

    @cached_property
    def _answers(self) -> Answers:
        return Answers(self._law)

    def _solution_of(self, forces: FloatArray) -> ContactSolution | None:
        """Return forces as a solution, or None where they fail the check."""
        law = self._law
        checked = law.check((forces / law.unit).tolist())
        if checked is None:
            return None
        return planar_solution(law, Answer(checked, *openness(law, checked)))
