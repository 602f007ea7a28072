"""One contact by its numbers, in the plane and in space."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from painleve_sym.errors import InputError
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.friction_set import Disc, Interval


def contact(
    W: npt.ArrayLike,
    b: npt.ArrayLike,
    mu: float,
    velocity: float | Sequence[float] | npt.ArrayLike = 0.0,
) -> ContactProblem:
    """State one rigid contact by its mobility: its case, solutions and critical friction follow.

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
    >>> problem = ps.contact([[4.0, 1.0], [1.0, 2.0]], [-9.8, 0.0], 0.5, velocity=-1.0)
    >>> [solution] = problem.solutions()
    >>> problem.case.value, solution.mode.value, solution.force.round(6).tolist()
    ('slip', 'slip_neg', [2.177778, 1.088889])

    In space, beyond the friction from which a sliding contact may have no unique answer:

    >>> W = [[2.0, 1.5, 0.0], [1.5, 2.0, 0.0], [0.0, 0.0, 2.0]]
    >>> problem = ps.contact(W, [3.0, 0.0, 0.0], 1.5, velocity=[1.0, 0.0])
    >>> [own] = problem.coefficients
    >>> problem.case.value, len(problem.solutions()), round(own.mu_P, 6)
    ('indeterminate', 2, 1.333333)
    >>> round(own.sector.half_angle, 6), round(own.least_over_normals, 6)
    (0.475882, 0.881917)
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
    return ContactProblem(given, np.asarray(b), (friction,), [tuple(slip)])
