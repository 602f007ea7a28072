"""One point contact with Coulomb friction: which forces and accelerations are consistent.

Signs: the normal force F_n >= 0 pushes the bodies apart and a_n > 0 separates them; F_t and a_t
count along the slip velocity v_t. The contact's mobility W turns forces into accelerations::

    a_n = W_nn F_n + W_nt F_t + b_n
    a_t = W_nt F_n + W_tt F_t + b_t

            ^ F_n, a_n
            |
        ----o---->  F_t, a_t, v_t
      ////////////////

Friction opposes slip: F_t = +mu F_n where v_t < 0, F_t = -mu F_n where v_t > 0, and |F_t| <= mu F_n
where v_t = 0, with the bound reached against the direction of a_t once a_t is not zero.

References
----------
Painlevé (1895), Sur les lois du frottement de glissement. C. R. Acad. Sci. 121, 112-115.
Glocker & Pfeiffer (1993), Complementarity problems in multibody systems with planar friction.
    Arch. Appl. Mech. 63, 452-463.
Pfeiffer & Glocker (1996), Multibody Dynamics with Unilateral Contacts. Wiley.
Anitescu & Potra (1997), Formulating dynamic multi-rigid-body contact problems with friction as
    solvable linear complementarity problems. Nonlinear Dynamics 14, 231-247.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace

import numpy as np

from painleve_sym.complementarity.contact_data import ContactData, rounded_difference
from painleve_sym.complementarity.lcp import (
    LCP,
    RESIDUAL_TOLERANCE,
    LCPSolution,
    residual,
    solve_all,
)
from painleve_sym.errors import InputError

DISTINCT = 1e-8  # forces nearer than this part of themselves are one solution found twice


class ContactMode(enum.Enum):
    """Name what the contact does next.

    LIFTOFF
        F_n = 0, F_t = 0, a_n >= 0 (grazing where a_n = 0).
    SLIP_POS
        F_n > 0, a_n = 0, F_t = -mu F_n: v_t > 0, or v_t = 0 and a_t > 0.
    SLIP_NEG
        F_n > 0, a_n = 0, F_t = +mu F_n: v_t < 0, or v_t = 0 and a_t < 0.
    STICK
        F_n > 0, a_n = 0, a_t = 0 with v_t = 0 and |F_t| <= mu F_n, the edge of the cone included.
    """

    LIFTOFF = "liftoff"
    SLIP_POS = "slip_pos"
    SLIP_NEG = "slip_neg"
    STICK = "stick"


class ContactCase(enum.Enum):
    """Name how many solutions there are; for v_t != 0 by the signs of A and B in a_n = A F_n + B.

    SLIP
        One solution, F_n = -B/A > 0: A > 0 and B < 0.
    LIFTOFF
        One solution, F_n = 0: A >= 0 and B > 0; also B = 0 with A != 0, where a_n = 0.
    INCONSISTENT
        None: A <= 0 and B < 0.
    INDETERMINATE
        Several: F_n = 0 and F_n = -B/A where A < 0 and B > 0; any F_n >= 0 where A = B = 0.
    STICK
        For v_t = 0 only: one solution, and it sticks.

    For v_t = 0 the set of forces decides: empty, one (named after its mode) or more than one.
    """

    SLIP = "slip"
    LIFTOFF = "liftoff"
    INCONSISTENT = "inconsistent"
    INDETERMINATE = "indeterminate"
    STICK = "stick"


@dataclass(frozen=True)
class ContactSolution:
    """Hold one verified set of forces and accelerations; entries a mode fixes at 0 are exactly 0.

    Attributes
    ----------
    mode : ContactMode
        What the contact does.
    normal_force, tangential_force : float
        F_n and F_t, in N.
    normal_acceleration, tangential_acceleration : float
        a_n and a_t, in m/s².
    residual : float
        Largest violation of the complementarity problem, as a fraction of its terms.
    isolated : bool
        False where the forces belong to a segment or ray of solutions.
    """

    mode: ContactMode
    normal_force: float
    tangential_force: float
    normal_acceleration: float
    tangential_acceleration: float
    residual: float
    isolated: bool = True


@dataclass(frozen=True)
class ContactProblem(ContactData):
    """State the contact problem of one closed point contact with zero normal velocity.

    Parameters
    ----------
    W_nn, W_nt, W_tt : float
        Mobility (Delassus matrix), in 1/kg; positive semidefinite, singular allowed.
    b_n, b_t : float
        Accelerations without contact force, in m/s². b_n is B of the paradox literature.
    mu : float
        Friction coefficient, >= 0.
    slip_velocity : float
        v_t in m/s; only its sign matters, and exactly 0 means at rest tangentially.

    Raises
    ------
    InputError
        For entries that are not finite, mu < 0 or an indefinite mobility; all faults are named at
        once. Fix: evaluate J M^-1 J' of the contact at one state, with one sign for both rows of J.
    """

    def A_slip(self, direction: int) -> float:
        """Return ``A = W_nn - mu s W_nt`` of ``a_n = A F_n + B`` while slipping along s.

        A value within rounding of its two terms is returned as exactly 0, since its sign, and with
        it the case, would be an accident.

        Parameters
        ----------
        direction : int
            s = +1 for v_t > 0, -1 for v_t < 0.

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
        return float(rounded_difference(self.W_nn, direction * self.mu * self.W_nt))

    @property
    def A(self) -> float | None:
        """Return A for the present slip direction, in 1/kg; None when v_t = 0."""
        return self.A_slip(self.slip_direction) if self.slip_direction else None

    @property
    def B(self) -> float:
        """Return B = b_n, in m/s²."""
        return self.b_n

    @property
    def case(self) -> ContactCase:
        """Classify the problem; see `ContactCase` for the rule, borders included."""
        if self.A is None:
            return _case_at_rest(self.solutions())
        if self.B < 0:
            return ContactCase.SLIP if self.A > 0 else ContactCase.INCONSISTENT
        # From here F_n = 0 is a solution.
        several = self.A < 0 < self.B or self.A == self.B == 0
        return ContactCase.INDETERMINATE if several else ContactCase.LIFTOFF

    def lcp(self) -> LCP:
        """Return the complementarity problem of the contact.

        For v_t != 0 it is scalar, ``z = F_n``, ``w = a_n = A F_n + B``; for v_t = 0 it is
        `frictional_lcp`.
        """
        if self.A is None:
            return self.frictional_lcp()
        return LCP(np.array([[self.A]]), np.array([self.B]))

    def frictional_lcp(self) -> LCP:
        """Return the problem of a contact with v_t = 0 (Glocker & Pfeiffer 1993).

        With friction reserves ``lambda_R = mu F_n + F_t``, ``lambda_L = mu F_n - F_t`` and
        ``a_t = a_t^+ - a_t^-`` (both parts >= 0): ``z = (F_n, lambda_R, a_t^-)`` and
        ``w = (a_n, a_t^+, lambda_L)``. Speeding up along + uses up lambda_R, along - lambda_L.
        Where W is positive definite there is always a solution (Anitescu & Potra 1997): the
        inconsistent case needs slip, or a singular W. Where F_n = 0 or mu = 0, a_t^+ and a_t^- may
        grow together without changing a_t; `solution_from` removes that.
        """
        mu = self.mu
        matrix = [
            [self.A_slip(1), self.W_nt, 0.0],
            [self.W_nt - mu * self.W_tt, self.W_tt, 1.0],
            [2.0 * mu, -1.0, 0.0],
        ]
        return LCP(np.array(matrix), np.array([self.b_n, self.b_t, 0.0]))

    def solution_from(self, solution: LCPSolution) -> ContactSolution:
        """Translate a solution of `lcp` (one entry) or of `frictional_lcp` (three entries).

        Raises
        ------
        InputError
            For another number of entries, or one entry when v_t = 0. Fix: solve this problem's
            `lcp` or `frictional_lcp`.
        """
        if solution.z.size == 3:
            return self._from_rest(solution)
        if solution.z.size != 1 or not self.slip_direction:
            raise InputError(
                f"solution cannot be translated, z: got {solution.z.size} entries at "
                f"slip_velocity = {self.slip_velocity!r}, need 3, or 1 while slipping. "
                "Fix: solve this problem's lcp() or frictional_lcp()."
            )
        force = float(solution.z[0])
        mode = _slip_mode(self.slip_direction) if force > 0 else ContactMode.LIFTOFF
        friction = -self.slip_direction * self.mu * force
        return self._assembled(mode, force, friction, [force], solution.isolated is True)

    def solutions(self) -> tuple[ContactSolution, ...]:
        """Find every consistent set of forces, by increasing normal force.

        Every cone of `lcp` is tried, and each answer is checked. Of a segment or ray of forces,
        one representative for each cone appears, with `isolated` False. An empty tuple is the
        inconsistent case.
        """
        distinct: list[ContactSolution] = []
        for found in map(self.solution_from, solve_all(self.lcp())):
            twin = next((k for k, known in enumerate(distinct) if _same_forces(found, known)), None)
            if twin is None:
                distinct.append(found)
            elif not found.isolated:
                distinct[twin] = replace(distinct[twin], isolated=False)
        return tuple(sorted(distinct, key=lambda s: (s.normal_force, s.tangential_force)))

    def _from_rest(self, solution: LCPSolution) -> ContactSolution:
        """Translate a solution of `frictional_lcp`."""
        moving = solution.varying
        isolated = moving is not None and not (moving[0] or moving[1])
        if not solution.active[0]:
            split = [0.0, 0.0, max(-self.b_t, 0.0)]
            return self._assembled(ContactMode.LIFTOFF, 0.0, 0.0, split, isolated)
        force, limit = float(solution.z[0]), self.mu * float(solution.z[0])
        on_edge = self.mu == 0.0 or solution.active[2] or not solution.active[1]
        friction = float(solution.z[1]) - limit
        if on_edge:
            friction = limit if solution.active[2] else -limit
        terms = (self.W_nt * force, self.W_tt * friction, self.b_t)
        # Inside the cone a_t = 0 holds by complementarity; on its edge the value decides.
        sticks = not on_edge or abs(sum(terms)) <= RESIDUAL_TOLERANCE * sum(map(abs, terms))
        mode = ContactMode.STICK if sticks else _slip_mode(sum(terms))
        split = [force, friction + limit, 0.0 if sticks else max(-sum(terms), 0.0)]
        return self._assembled(mode, force, friction, split, isolated)

    def _assembled(
        self, mode: ContactMode, force: float, friction: float, z: list[float], isolated: bool
    ) -> ContactSolution:
        """Return the solution with its accelerations and the residual of its z."""
        problem = self.lcp() if len(z) == 1 else self.frictional_lcp()
        rate = self.W_nt * force + self.W_tt * friction + self.b_t
        return ContactSolution(
            mode=mode,
            normal_force=force,
            tangential_force=friction + 0.0,  # no -0.0
            normal_acceleration=self.b_n if mode is ContactMode.LIFTOFF else 0.0,
            tangential_acceleration=0.0 if mode is ContactMode.STICK else rate,
            residual=residual(problem, z),
            isolated=isolated,
        )


def _slip_mode(direction: float) -> ContactMode:
    """Return the slip mode along the sign of `direction`."""
    return ContactMode.SLIP_POS if direction > 0 else ContactMode.SLIP_NEG


def _same_forces(a: ContactSolution, b: ContactSolution) -> bool:
    """Tell whether two solutions are one found in two cones."""
    gap = math.hypot(a.normal_force - b.normal_force, a.tangential_force - b.tangential_force)
    size = max(math.hypot(s.normal_force, s.tangential_force) for s in (a, b))
    return gap <= DISTINCT * size


def _case_at_rest(solutions: tuple[ContactSolution, ...]) -> ContactCase:
    """Classify a contact with v_t = 0 by its solutions."""
    if not solutions:
        return ContactCase.INCONSISTENT
    if len(solutions) > 1 or not solutions[0].isolated:
        return ContactCase.INDETERMINATE
    named = {ContactMode.LIFTOFF: ContactCase.LIFTOFF, ContactMode.STICK: ContactCase.STICK}
    return named.get(solutions[0].mode, ContactCase.SLIP)
