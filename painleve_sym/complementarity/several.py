"""Several planar contacts with Coulomb friction at once: every consistent set of forces.

Signs are those of `contact`, contact by contact: F_n >= 0 pushes the bodies apart, a_n > 0
separates them, F_t and a_t count along v_t. Forces and accelerations are listed contact by contact,
``F = (F_n1, F_t1, F_n2, F_t2, ...)``, and ``a = W F + b``.

With several contacts a problem has up to one solution for each choice of what every contact does,
or a continuum: a body on more contacts than it has degrees of freedom can be loaded in itself.

References
----------
Glocker & Pfeiffer (1993), Complementarity problems in multibody systems with planar friction.
    Arch. Appl. Mech. 63, 452-463.
Pfeiffer & Glocker (1996), Multibody Dynamics with Unilateral Contacts. Wiley.
Pang & Trinkle (1996), Complementarity formulations and existence of solutions of dynamic
    multi-rigid-body contact problems with Coulomb friction. Math. Program. 73, 199-226.
Anitescu & Potra (1997), Formulating dynamic multi-rigid-body contact problems with friction as
    solvable linear complementarity problems. Nonlinear Dynamics 14, 231-247.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from painleve_sym.complementarity import branches
from painleve_sym.complementarity.contact import ContactMode
from painleve_sym.complementarity.contact_data import rounded_difference
from painleve_sym.complementarity.faces import BoolArray, FloatArray
from painleve_sym.complementarity.force_check import CheckedForces, ForceCheck
from painleve_sym.complementarity.lcp import LCP, RESIDUAL_TOLERANCE, equilibrate
from painleve_sym.complementarity.lemke import LemkeStatus, pivot
from painleve_sym.complementarity.uniqueness import Uniqueness, uniqueness_of
from painleve_sym.errors import InputError

CONTACT_LIMIT = 6
"""Most contacts whose branches are all tried: 4**6 regular systems take some tenth of a second."""

_SYMMETRY = 1e-9  # of the roots of the diagonal: roundings of a mass-matrix inverse
_ROUNDING = 1e-14  # of the terms of an acceleration: what a solve may leave of a zero
_INDEFINITE = 1e-12  # per row, on a mobility scaled to a diagonal of ones


@dataclass(frozen=True, eq=False)
class SeveralSolution:
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
        Of the complementarity problem, see `lcp.residual`; dimensionless.
    isolated : bool, or None
        False where the forces belong to a segment, ray or wider set of solutions; None where more
        branches meet than are tried.
    """

    modes: tuple[ContactMode, ...]
    normal_forces: FloatArray
    tangential_forces: FloatArray
    normal_accelerations: FloatArray
    tangential_accelerations: FloatArray
    residual: float
    isolated: bool | None


@dataclass(frozen=True, eq=False)
class SeveralLemke:
    """Report one run of Lemke's method: its end, the solution if there is one, the pivots used."""

    status: LemkeStatus
    solution: SeveralSolution | None
    pivots: int


@dataclass(frozen=True, eq=False)
class SeveralContacts:
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
        Friction coefficients, >= 0.
    slip_velocity : array_like, shape (n,)
        v_t of each contact in m/s; only the sign matters, and exactly 0 means at rest tangentially.

    Raises
    ------
    InputError
        For wrong shapes, entries that are not finite, mu < 0 or a mobility that is not symmetric
        and semidefinite; all faults are named at once. Fix: evaluate J M^-1 J' at one state.
    """

    W: FloatArray
    b: FloatArray
    mu: FloatArray
    slip_velocity: FloatArray

    def __post_init__(self) -> None:
        """Check every array and keep read-only copies."""
        faults: list[str] = []
        for field in fields(self):
            try:
                value = np.array(getattr(self, field.name), dtype=float)
            except (TypeError, ValueError):
                value = np.array(math.nan)
            if not np.all(np.isfinite(value)):
                faults.append(
                    f"{field.name}: got {getattr(self, field.name)!r}, need finite numbers. "
                    "Fix: check the state it was evaluated at."
                )
            object.__setattr__(self, field.name, value)
        faults = faults or self._shape_faults() or self._physical_faults()
        if faults:
            raise InputError("SeveralContacts cannot be stated, " + " Also, ".join(faults))
        object.__setattr__(self, "W", (self.W + self.W.T) / 2)
        for field in fields(self):
            getattr(self, field.name).setflags(write=False)

    def _shape_faults(self) -> list[str]:
        """Return a sentence for each array that does not fit n contacts, n from slip_velocity."""
        n = self.slip_velocity.size
        need = {"W": (2 * n, 2 * n), "b": (2 * n,), "mu": (n,), "slip_velocity": (max(n, 1),)}
        return [
            f"{name}: got shape {getattr(self, name).shape}, need {shape} for {n} entries of "
            "slip_velocity. Fix: give two rows (n, t) of W and b for each contact."
            for name, shape in need.items()
            if getattr(self, name).shape != shape
        ]

    def _physical_faults(self) -> list[str]:
        """Return a sentence for each entry that no mechanism can have."""
        faults: list[str] = []
        if np.any(self.mu < 0):
            faults.append(
                f"mu: got {self.mu!r}, need mu >= 0. Fix: give the direction by slip_velocity."
            )
        root = np.sqrt(np.maximum(np.diag(self.W), 0.0))
        bound = np.outer(root, root)
        inverse = np.divide(1.0, bound, out=np.zeros_like(bound), where=bound > 0)
        wrong = np.abs(self.W - self.W.T) > _SYMMETRY * bound
        if np.any(wrong) or np.any(np.abs(self.W[bound == 0]) > 0):
            faults.append(
                f"W: got {self.W!r}, need a symmetric matrix with rows of zeros where the diagonal "
                "is 0. Fix: compute it as J M^-1 J' with rows n1, t1, n2, t2, ... of J."
            )
        elif np.min(np.linalg.eigvalsh(self.W * inverse)) < -_INDEFINITE * len(self.W):
            faults.append(
                f"W: got {self.W!r}, need a positive semidefinite matrix. "
                "Fix: compute it as J M^-1 J' with a positive definite mass matrix M."
            )
        return faults

    @property
    def size(self) -> int:
        """Return n, the number of contacts."""
        return int(self.mu.size)

    @property
    def slip_directions(self) -> tuple[int, ...]:
        """Return the sign of each slip velocity: -1, 0 or +1."""
        return tuple(int(sign) for sign in np.sign(self.slip_velocity))

    def lcp(self) -> LCP:
        """Return the complementarity problem of all contacts, contact by contact.

        A sliding contact has the pair ``z = F_n``, ``w = a_n`` with ``F_t = -mu s F_n``. One at
        rest has the three pairs of `ContactProblem.frictional_lcp`: ``z = (F_n, mu F_n + F_t,
        a_t^-)`` and ``w = (a_n, a_t^+, mu F_n - F_t)`` with ``a_t = a_t^+ - a_t^-``.
        """
        directions = self.slip_directions
        ends = np.cumsum([0] + [1 if s else 3 for s in directions])
        matrix, offset = np.zeros((ends[-1], ends[-1])), np.zeros(ends[-1])
        for j, s in enumerate(directions):
            normal, tangential = self.W[:, 2 * j], self.W[:, 2 * j + 1]
            # An impossible sign left by rounding is removed, as in ContactProblem.A_slip.
            slipping = rounded_difference(normal, (s or 1) * self.mu[j] * tangential)
            for i, t in enumerate(directions):
                k, m = ends[i], ends[j]
                matrix[k, m] = slipping[2 * i]
                if not t:
                    matrix[k + 1, m] = slipping[2 * i + 1]
                if not s:
                    matrix[k, m + 1] = tangential[2 * i]
                if not (s or t):
                    matrix[k + 1, m + 1] = tangential[2 * i + 1]
        for i, s in enumerate(directions):
            k = ends[i]
            offset[k] = self.b[2 * i]
            if not s:
                offset[k + 1] = self.b[2 * i + 1]
                matrix[k + 1, k + 2] = 1.0
                matrix[k + 2, k : k + 2] = 2.0 * self.mu[i], -1.0
        return LCP(matrix, offset)

    def solutions(self) -> tuple[SeveralSolution, ...]:
        """Find every consistent set of forces, ordered by the normal forces.

        Each sliding contact lifts off or slips on; each one at rest lifts off, begins to slip
        either way, or sticks. All choices are tried, each answer is checked against `lcp`, and
        forces found in several choices are one solution. Where a choice leaves a segment, ray or
        wider set of forces, one representative appears, with `isolated` False. An empty tuple is
        the inconsistent case.

        Raises
        ------
        InputError
            For more than `CONTACT_LIMIT` contacts. Fix: call `solve_lemke` for one solution.
        """
        self._refuse_many("solutions")
        check, known = self._checker(), list[CheckedForces]()
        W, b, mu, unit = branches.scale_contacts(self.W, self.b, self.mu)
        wide: list[tuple[int, ...]] = []
        for point in branches.branch_forces(W, b, self._branches(mu)):
            found = check.check(unit * point.forces)
            if found is None:
                continue
            if point.wide:
                wide.append(point.choice)
            if check.twin(found, known) is None:
                known.append(found)
        choices = np.array(wide, dtype=np.intp).reshape(-1, self.size)
        known.sort(key=lambda point: (*point.forces[0::2], *point.forces[1::2]))
        return tuple(self._solution(point, not _any_holds(choices, point)) for point in known)

    def solve_lemke(self, max_pivots: int | None = None) -> SeveralLemke:
        """Find one consistent set of forces by Lemke's pivots, for any number of contacts.

        The pivots run on the formulation of Anitescu & Potra (1997), in which a contact at rest has
        the unknowns F_n, the two parts of F_t and its speeding-up. With all contacts at rest and W
        positive definite its matrix is copositive and the pivots end at a solution; the shorter
        `lcp` promises that only for little friction. With sliding contacts neither is promised.

        Parameters
        ----------
        max_pivots : int, optional
            Most pivots; 50 per complementary pair when not given.
        """
        lcp, ways = self._copositive_lcp()
        scaled, unit = equilibrate(lcp)
        limit = 50 * lcp.size if max_pivots is None else max_pivots
        status, z, pivots = pivot(scaled, limit, RESIDUAL_TOLERANCE)
        if z is None:
            return SeveralLemke(status, None, pivots)
        found = self._checker().check(ways @ (unit * z))
        if found is None:
            return SeveralLemke(LemkeStatus.NOT_VERIFIED, None, pivots)
        return SeveralLemke(status, self._solution(found, self._isolated(found)), pivots)

    def uniqueness(self) -> Uniqueness:
        """Say beforehand what W, mu and the slip directions promise for every b.

        Raises
        ------
        InputError
            For more than `CONTACT_LIMIT` contacts. Fix: ask about fewer contacts.
        """
        self._refuse_many("uniqueness")
        W, _, mu, _ = branches.scale_contacts(self.W, self.b, self.mu)
        return uniqueness_of(W, self._branches(mu))

    def _refuse_many(self, where: str) -> None:
        """Raise InputError for more contacts than can be enumerated."""
        if self.size > CONTACT_LIMIT:
            raise InputError(
                f"{where}() cannot try every branch: got {self.size} contacts, need at most "
                f"{CONTACT_LIMIT}. Fix: call solve_lemke() for one solution."
            )

    def _branches(self, mu: FloatArray) -> list[tuple[branches.Branch, ...]]:
        """Return what each contact may do, with the friction coefficients of a scaled problem."""
        return [
            _branches_of(float(coefficient), s)
            for coefficient, s in zip(mu, self.slip_directions, strict=True)
        ]

    def _checker(self) -> ForceCheck:
        """Return the check of this problem's answers."""
        return ForceCheck(self.lcp(), self.W, self.b, self.mu, self.slip_directions)

    def _isolated(self, point: CheckedForces) -> bool | None:
        """Tell whether no branch through these forces is wide; None where too many meet."""
        if math.prod(int(np.sum(flags)) for flags in point.possible) > 4**CONTACT_LIMIT:
            return None
        W, b, mu, _ = branches.scale_contacts(self.W, self.b, self.mu)
        meeting = [
            [branch for branch, flag in zip(given, flags, strict=True) if flag]
            for given, flags in zip(self._branches(mu), point.possible, strict=True)
        ]
        return not any(near.wide for near in branches.branch_forces(W, b, meeting))

    def _solution(self, point: CheckedForces, isolated: bool | None) -> SeveralSolution:
        """Return checked forces with their accelerations."""
        accelerations = self.W @ point.forces + self.b
        terms = np.abs(self.W) @ np.abs(point.forces) + np.abs(self.b)
        accelerations[np.abs(accelerations) <= _ROUNDING * terms] = 0.0
        normal, tangential = point.forces[0::2].copy(), point.forces[1::2].copy()
        closed = np.array([mode is not ContactMode.LIFTOFF for mode in point.modes])
        sticking = np.array([mode is ContactMode.STICK for mode in point.modes])
        parted = np.where(closed, 0.0, accelerations[0::2])
        sliding = np.where(sticking, 0.0, accelerations[1::2])
        for array in (normal, tangential, parted, sliding):
            array.setflags(write=False)
        return SeveralSolution(
            point.modes, normal, tangential, parted, sliding, point.residual, isolated
        )

    def _copositive_lcp(self) -> tuple[LCP, FloatArray]:
        """Return the problem of Anitescu & Potra and the map from its z to the forces."""
        ways: list[FloatArray] = []
        rests: list[tuple[int, float]] = []  # columns of F_n at rest, with their friction
        for i, (mu, s) in enumerate(zip(self.mu, self.slip_directions, strict=True)):
            axes = np.eye(2 * self.size)[:, 2 * i : 2 * i + 2]
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
                partners[2 * i + 1] = 0.0
        matrix = partners.T @ self.W @ forces
        for k, mu in rests:
            matrix[k + 1 : k + 3, k + 3] = 1.0
            matrix[k + 3, k : k + 3] = mu, -1.0, -1.0
        return LCP(matrix, partners.T @ self.b), forces


def _branches_of(mu: float, direction: int) -> tuple[branches.Branch, ...]:
    """Return the branches of one contact: lift-off first, then slip along +, -, and sticking."""
    if direction:
        return branches.lift_off(), branches.slip(mu, direction, at_rest=False)
    if mu == 0:
        return branches.lift_off(), branches.slip(mu, 1, at_rest=True)
    right, left = (branches.slip(mu, s, at_rest=True) for s in (1, -1))
    return branches.lift_off(), right, left, branches.stick(mu)


def _any_holds(choices: npt.NDArray[np.intp], point: CheckedForces) -> bool:
    """Tell whether one of the choices holds the forces, its borders included."""
    flags: BoolArray = np.ones(len(choices), np.bool_)
    for i, possible in enumerate(point.possible):
        flags &= possible[choices[:, i]]
    return bool(np.any(flags))
