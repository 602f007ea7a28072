"""One contact by its numbers: where friction makes a sliding rigid contact lose its one answer.

While a contact slides along the angle φ its normal acceleration is A(φ) F_n + B with

    A(φ) = W_nn - μ w·e(φ),    B = b_n,

where w couples the normal to the tangents. A is negative for some direction of slip where μ exceeds
``μ_P = W_nn/|w|``, and then in a sector around the direction of w. Over all normals that a surface
might have at this point, μ_P is least at ``2 √(λ₁ λ₃)/(λ₃ - λ₁)``, with the extreme eigenvalues of
W: one number for a foot, whatever it stands on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.files import finite, plain_fields
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.friction_set import Disc, FrictionSet, Interval
from painleve_sym.problem.risk import (
    friction_threshold,
    least_over_normals,
    sector_half_angle,
    slip_direction,
)
from painleve_sym.problem.rounding import rounded_difference
from painleve_sym.problem.solution import ContactCase, ContactSolution, forces_data


@dataclass(frozen=True)
class Sector:
    """The directions of slip for which A < 0.

    Attributes
    ----------
    direction : float
        Angle of its middle, from t1 towards t2, in rad from −π to π; 0 or π in the plane.
    half_angle : float
        Slip within this angle of it has A < 0; rad. 0 in the plane, which has this direction alone.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> W = [[2.0, 0.0, 1.5], [0.0, 2.0, 0.0], [1.5, 0.0, 2.0]]
    >>> sector = ps.contact(W, [-1.0, 0.0, 0.0], 1.5).sector
    >>> round(sector.direction, 4), round(sector.half_angle, 4)
    (1.5708, 0.4759)
    """

    direction: float
    half_angle: float


@dataclass(frozen=True, eq=False, repr=False)
class ContactAnswer(Compared):
    """The solutions of one rigid contact, and how near it is to its paradox.

    Attributes
    ----------
    problem : ContactProblem
        Of the one contact.
    solutions : tuple of ContactSolution
        Every solution, each with its verified residual; none and several are results.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> W = [[2.0, 1.5, 0.0], [1.5, 2.0, 0.0], [0.0, 0.0, 2.0]]
    >>> answer = ps.contact(W, [3.0, 0.0, 0.0], 1.5, velocity=[1.0, 0.0])
    >>> answer.case.value, len(answer.solutions), round(answer.mu_P, 6)
    ('indeterminate', 2, 1.333333)
    >>> round(answer.sector.half_angle, 6), round(answer.least_over_normals, 6)
    (0.475882, 0.881917)
    """

    problem: ContactProblem
    solutions: tuple[ContactSolution, ...]

    def __repr__(self) -> str:
        """Return case and modes in one line."""
        modes = "; ".join(s.mode.value for s in self.solutions)
        return f"ContactAnswer {self.case.value}{': ' * bool(modes)}{modes}"

    @cached_property
    def case(self) -> ContactCase:
        """The case, by number and kind of the solutions."""
        return self.problem.case_of(self.solutions)

    @property
    def mu(self) -> float:
        """The friction coefficient."""
        return float(self.problem.mu.item())

    @cached_property
    def slip(self) -> tuple[float, ...]:
        """Direction e of the slip; at rest that of the free acceleration b_t, empty where b_t = 0.

        A unit vector along the tangents.
        """
        ball: FrictionSet = self.problem.friction[0][0]
        (slip,) = self.problem.slips
        return ball.direction(slip) or ball.direction(self.problem.b[1:].tolist())

    @property
    def A(self) -> float | None:
        """A of a_n = A F_n + B in slip along `slip`, 1/kg; None where that is empty.

        A value within rounding of its terms is exactly 0.
        """
        if not self.slip:
            return None
        coupling = float(self.problem.W[0, 1:] @ np.array(self.slip))
        return float(rounded_difference(self.problem.W[0, 0], self.mu * coupling))

    @property
    def B(self) -> float:
        """B = b_n, in m/s²."""
        return float(self.problem.b[0])

    @property
    def mu_P(self) -> float | None:
        """Least friction with A < 0 for some direction of slip; None where no friction has it."""
        return finite(float(friction_threshold(self.problem.W)))

    @property
    def sector(self) -> Sector | None:
        """The directions of slip with A < 0; None where A >= 0 for all of them."""
        W, critical = self.problem.W, self.mu_P
        if critical is None or not self.mu > critical:
            return None
        half = sector_half_angle(critical, self.mu) if len(W) == 3 else 0.0
        return Sector(slip_direction(W), half)

    @property
    def least_over_normals(self) -> float | None:
        """Least μ_P over all directions of the surface's normal; None where none has a paradox."""
        return finite(float(least_over_normals(self.problem.W)))

    def coefficient_data(self) -> dict[str, Any]:
        """Return the numbers that do not depend on the solutions as plain data."""
        return plain_fields(self, "A", "B", "mu_P", "sector", "least_over_normals")

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        return {
            **self.coefficient_data(),
            "case": self.case.value,
            "borders": list(self.problem.borders),
            "solutions": [solution_data(s) | forces_data(s) for s in self.solutions],
        }


def solution_data(solution: ContactSolution, i: int = 0) -> dict[str, Any]:
    """Return one contact of a solution as plain data."""
    return {
        "mode": solution.modes[i].value,
        "direction": solution.directions[i],
        "force": solution.contact_forces[i].tolist(),
        "acceleration": solution.contact_accelerations[i].tolist(),
    }


def contact(
    W: npt.ArrayLike,
    b: npt.ArrayLike,
    mu: float,
    velocity: float | Sequence[float] | npt.ArrayLike = 0.0,
) -> ContactAnswer:
    """Return what one rigid contact may do, from its mobility: case, solutions, critical friction.

    Parameters
    ----------
    W : array_like, shape (3, 3) or (2, 2)
        Mobility ``J M^-1 J'`` (Delassus matrix) with rows n, t1, t2 in space and n, t in the plane;
        in 1/kg, symmetric and positive semidefinite.
    b : array_like, shape (3,) or (2,)
        Acceleration of the contact without contact force, same rows; m/s².
    mu : float
        Friction coefficient, >= 0.
    velocity : array_like of 2 float, or a float
        Slip velocity along t1, t2 in space, along t in the plane, in m/s: only its direction
        matters, and exactly 0, the default, is a contact at rest.

    Raises
    ------
    InputError
        For wrong shapes, numbers that are not finite, mu < 0 or a mobility that is not symmetric
        and semidefinite.

    References
    ----------
    Champneys & Várkonyi (2016). The bound over all normals: Gustafson & Rao (1997).

    Examples
    --------
    >>> import painleve_sym as ps
    >>> answer = ps.contact([[4.0, 1.0], [1.0, 2.0]], [-9.8, 0.0], 0.5, velocity=-1.0)
    >>> answer
    ContactAnswer slip: slip_neg
    >>> answer.solutions[0].force.round(6).tolist()
    [2.177778, 1.088889]
    """
    try:
        given = np.array(W, dtype=float)
    except (TypeError, ValueError):
        given = np.zeros(0)
    if given.shape not in ((2, 2), (3, 3)):
        raise InputError(
            f"contact: W: got shape {given.shape}, need (3, 3) in space or (2, 2) in the plane. "
            "Fix: give W with rows n, t1, t2, or n, t."
        )
    friction = Disc(mu) if len(given) == 3 else Interval(mu)
    slip = np.asarray(velocity)
    if slip.ndim == 0:
        slip = np.full(friction.n_tangents, slip)
        if friction.n_tangents > 1 and bool(np.any(slip)):
            raise InputError(
                f"contact: velocity: got {velocity!r}, need two numbers along t1 and t2. "
                "Fix: velocity=[v1, v2]."
            )
    problem = ContactProblem(given, np.asarray(b), (friction,), [tuple(slip)])
    return ContactAnswer(problem, problem.solutions())
