"""One bilateral contact with Coulomb friction, as in the Painlevé-Klein mechanism.

A slider in a slot, or a rod between two guides, stays closed whatever the sign of the normal force,
and either side of the slot rubs. Signs: F_n > 0 pushes along the normal, F_n < 0 against it; F_t
and a_t count along the slip velocity v_t. With the mobility W::

    a_n = W_nn F_n + W_nt F_t + b_n = 0        F_t = -mu s |F_n|,  s the sign of v_t
    a_t = W_nt F_n + W_tt F_t + b_t

While sliding, ``A F_n + b_n = 0`` with ``A = W_nn - mu s W_nt`` where F_n > 0 and
``A = W_nn + mu s W_nt`` where F_n < 0. So the number of solutions for v_t != 0 is

- 1 for every b_n where ``mu |W_nt| < W_nn``;
- 2 where ``mu |W_nt| > W_nn`` and ``s W_nt b_n > 0``: one of each sign of F_n;
- 0 where ``mu |W_nt| > W_nn`` and ``s W_nt b_n < 0``: the paradox without lift-off;
- 1, ``F_n = 0``, where ``mu |W_nt| > W_nn`` and b_n = 0;
- 1 or 0, by the same two signs, where ``mu |W_nt| = W_nn > 0`` and b_n != 0; a ray where b_n = 0;
- 0 where W_nn = 0 and b_n != 0; every F_n where b_n = 0.

At v_t = 0 the contact sticks, ``a_t = 0`` and ``|F_t| <= mu |F_n|``, or begins to slip along a_t.
For a definite W there is always a solution: exactly one where ``mu |W_nt| < W_nn``, one or three
where ``mu |W_nt| > W_nn`` (sticking, and two slips of opposite F_n, both along the sign of
``W_nt b_n``), and two where sticking meets a slip or b_n = 0 makes one of both slips.

References
----------
Painlevé (1895), Sur les lois du frottement de glissement. C. R. Acad. Sci. 121, 112-115.
Klein (1909), Zu Painlevés Kritik der Coulombschen Reibungsgesetze. Z. Math. Phys. 58, 186-191.
Le Xuan Anh (2003), Dynamics of Mechanical Systems with Coulomb Friction. Springer.
Blumentals, Brogliato & Bertails-Descoubes (2016), The contact problem in Lagrangian systems subject
    to bilateral and unilateral constraints, with or without sliding Coulomb's friction: a tutorial.
    Multibody Syst. Dyn. 38, 43-76.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from painleve_sym.complementarity import branches
from painleve_sym.complementarity.contact import DISTINCT, ContactMode
from painleve_sym.complementarity.contact_data import ContactData, rounded_difference
from painleve_sym.complementarity.faces import FloatArray
from painleve_sym.complementarity.lcp import RESIDUAL_TOLERANCE


@dataclass(frozen=True)
class BilateralSolution:
    """Hold one verified set of forces and accelerations; ``a_n = 0`` throughout.

    Attributes
    ----------
    mode : ContactMode
        SLIP_POS, SLIP_NEG or STICK; never LIFTOFF.
    normal_force, tangential_force : float
        F_n, of either sign, and F_t, in N.
    tangential_acceleration : float
        a_t, in m/s².
    residual : float
        Largest violation of an equation or inequality of the law, as a fraction of its terms.
    isolated : bool
        False where the forces belong to a segment or ray of solutions.
    """

    mode: ContactMode
    normal_force: float
    tangential_force: float
    tangential_acceleration: float
    residual: float
    isolated: bool = True


@dataclass(frozen=True)
class BilateralProblem(ContactData):
    """State the contact problem of one bilateral point contact.

    Parameters
    ----------
    W_nn, W_nt, W_tt : float
        Mobility (Delassus matrix), in 1/kg; positive semidefinite, singular allowed.
    b_n, b_t : float
        Accelerations without contact force, in m/s².
    mu : float
        Friction coefficient of both sides, >= 0.
    slip_velocity : float
        v_t in m/s; only its sign matters, and exactly 0 means at rest tangentially.

    Raises
    ------
    InputError
        For entries that are not finite, mu < 0 or an indefinite mobility; all faults are named at
        once. Fix: evaluate J M^-1 J' of the contact at one state, with one sign for both rows of J.
    """

    def A_slip(self, direction: int, side: int) -> float:
        """Return ``A = W_nn - mu s side W_nt`` of ``A F_n + b_n = 0`` while slipping along s.

        A value within rounding of its two terms is returned as exactly 0.

        Parameters
        ----------
        direction : int
            s = +1 for v_t > 0, -1 for v_t < 0.
        side : int
            The sign of F_n.
        """
        return float(rounded_difference(self.W_nn, direction * side * self.mu * self.W_nt))

    @property
    def unique_for_all(self) -> bool:
        """Tell whether ``mu |W_nt| < W_nn``: one solution for every b_n and slip direction.

        At v_t = 0, W must be definite, too: else forces that move nothing may add up.
        """
        regular = self.slip_direction or self.W_nn * self.W_tt - self.W_nt**2 > 0
        return bool(self.A_slip(1, 1) > 0 and self.A_slip(1, -1) > 0 and regular)

    def solutions(self) -> tuple[BilateralSolution, ...]:
        """Find every consistent set of forces, by increasing normal force.

        Both signs of F_n are tried with slip along v_t; at v_t = 0 with slip either way and with
        sticking. Of a segment or ray, one representative for each of these appears, and each
        solution on it has `isolated` False. An empty tuple is the inconsistent case.
        """
        W, b, unit, offered = self._scaled()
        points = branches.branch_forces(W, b, [offered])
        wide = [offered[point.choice[0]] for point in points if point.wide]
        distinct: list[BilateralSolution] = []
        for point in points:
            isolated = not any(branch.holds(point.forces, W, b) for branch in wide)
            found = self._solution(unit * point.forces, isolated)
            if found.residual > RESIDUAL_TOLERANCE:
                continue
            if not any(_same_forces(found, known) for known in distinct):
                distinct.append(found)
        return tuple(sorted(distinct, key=lambda s: (s.normal_force, s.tangential_force)))

    def residual(self, normal_force: float, tangential_force: float) -> float:
        """Measure how far forces are from the law, free of units.

        The largest of ``|a_n|`` by its terms, ``|F_t| - mu |F_n|`` where positive by its terms,
        and, where a_t or v_t is not zero, what friction misses of opposing it at its limit: the
        smaller of ``|F_t + mu s |F_n||`` and (at v_t = 0) ``|a_t|``, each by its terms.

        Parameters
        ----------
        normal_force, tangential_force : float
            F_n and F_t, in N; entries that are not finite give ``inf``.

        Returns
        -------
        float
            0 for an exact solution, up to 1 otherwise.
        """
        if not (math.isfinite(normal_force) and math.isfinite(tangential_force)):
            return math.inf
        normal = _share(self.W_nn * normal_force, self.W_nt * tangential_force, self.b_n)
        tangential = _share(self.W_nt * normal_force, self.W_tt * tangential_force, self.b_t)
        limit = self.mu * abs(normal_force)
        cone = max(_share(abs(tangential_force), -limit), 0.0)
        s = self.slip_direction or (tangential > 0) - (tangential < 0)
        opposing = abs(_share(tangential_force, s * limit))
        if not self.slip_direction:
            opposing = min(opposing, abs(tangential))
        return max(abs(normal), cone, opposing)

    def _scaled(self) -> tuple[FloatArray, FloatArray, FloatArray, list[branches.Branch]]:
        """Return W, b and the unit of force, scaled, and the branches of the law."""
        W, b, mu, unit = branches.scale_contacts(
            np.array([[self.W_nn, self.W_nt], [self.W_nt, self.W_tt]]),
            np.array([self.b_n, self.b_t]),
            np.array([self.mu]),
        )
        s, friction = self.slip_direction, float(mu[0])
        # Without friction no branch depends on the direction.
        ways = (s,) if s else (1, -1) if friction > 0 else (1,)
        offered: list[branches.Branch] = []
        for side in (1, -1):
            offered += [branches.slip(friction, way, at_rest=not s, side=side) for way in ways]
            if not s and friction > 0:
                offered.append(branches.stick(friction, side))
        return W, b, unit, offered

    def _solution(self, forces: FloatArray, isolated: bool) -> BilateralSolution:
        """Return the solution with its mode, acceleration and residual."""
        force, friction = float(forces[0]), float(forces[1])
        terms = self.W_nt * force, self.W_tt * friction, self.b_t
        s = self.slip_direction
        if not s and abs(_share(*terms)) > RESIDUAL_TOLERANCE:
            s = 1 if sum(terms) > 0 else -1
        if s:
            friction = -s * self.mu * abs(force)
        rate = self.W_nt * force + self.W_tt * friction + self.b_t
        modes = {0: ContactMode.STICK, 1: ContactMode.SLIP_POS, -1: ContactMode.SLIP_NEG}
        return BilateralSolution(
            mode=modes[s],
            normal_force=force + 0.0,  # no -0.0
            tangential_force=friction + 0.0,
            tangential_acceleration=rate if s else 0.0,
            residual=self.residual(force, friction),
            isolated=isolated,
        )


def _share(*terms: float) -> float:
    """Return a sum as a fraction of the sum of the sizes of its terms; 0 for nothing."""
    size = sum(map(abs, terms))
    return sum(terms) / size if size > 0 else 0.0


def _same_forces(a: BilateralSolution, b: BilateralSolution) -> bool:
    """Tell whether two solutions are one found in two branches."""
    gap = math.hypot(a.normal_force - b.normal_force, a.tangential_force - b.tangential_force)
    size = max(math.hypot(s.normal_force, s.tangential_force) for s in (a, b))
    return gap <= DISTINCT * size
