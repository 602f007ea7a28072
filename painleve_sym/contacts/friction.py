"""Friction of contacts whose normal forces are given: a convex problem with one motion.

Compliant contacts have their normal forces from their compressions. The rest of Coulomb's law
at the acceleration level, ``a_t = W_tt F_t + b_t + W_tn F_n``, is for each contact at rest
(v_t = 0)

- ``|F_t| <= mu |F_n|``, and
- ``F_t = -mu |F_n|`` where a_t > 0, ``F_t = +mu |F_n|`` where a_t < 0.

These are the conditions of the minimum of ``F_t' W_tt F_t / 2 + F_t' (b_t + W_tn F_n)`` over the
box ``|F_t| <= mu |F_n|`` of the contacts at rest; those that slide have ``F_t = -mu s |F_n|``. W_tt
is positive semidefinite, so there is a minimum, and all accelerations, the normal ones included,
are the same at all its points. docs/complementarity.md has the proof.

References
----------
Moreau (1966) and Lötstedt (1982) for such minima where the normal forces are unknown.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from painleve_sym.complementarity.lcp import RESIDUAL_TOLERANCE
from painleve_sym.complementarity.solution_sets import (
    RANK,
    BoolArray,
    FloatArray,
    affine_face,
    solve_refined,
)
from painleve_sym.contact_rows import ContactRows
from painleve_sym.contacts.local_mode import ContactMode, slip_mode
from painleve_sym.contacts.problem import CONTACT_LIMIT, ContactProblem, ContactSolution
from painleve_sym.errors import InputError

_ROUNDING = 1e-13  # residuals below this are equal: then the least forces are taken
_ROUND_OFF = 1e-14  # of the terms of an acceleration: what a solve may leave of a zero

FREE, RIGHT, LEFT = 0, -1, 1  # of a contact at rest: sign of F_t at the edge it is held to


def friction_forces(
    W: npt.ArrayLike,
    b: npt.ArrayLike,
    normal_forces: npt.ArrayLike,
    mu: npt.ArrayLike,
    slip_velocity: npt.ArrayLike,
) -> ContactSolution:
    """Return friction and accelerations of contacts whose normal forces are given.

    Every choice of sticking contacts and edges is one linear system; all are solved, and each is
    checked. Where the tangential forces are not determined (two feet of one body that stick pull
    against each other), those of least norm are returned; the accelerations are unique.

    Parameters
    ----------
    W : array_like, shape (2 n, 2 n)
        Mobility ``J M^-1 J'`` with rows and columns n1, t1, n2, t2, ...; 1/kg.
    b : array_like, shape (2 n,)
        Accelerations without contact forces; m/s².
    normal_forces : array_like, shape (n,)
        F_n in N; 0 of an open contact, negative of a bilateral one that pulls.
    mu : array_like, shape (n,)
        Friction coefficients, >= 0.
    slip_velocity : array_like, shape (n,)
        v_t in m/s; only the sign matters, and exactly 0 means at rest tangentially.

    Returns
    -------
    ContactSolution
        With mode LIFTOFF where F_n = 0; `residual` is the largest violation of the conditions above
        as a fraction of their terms; `isolated` tells whether the tangential forces are determined.

    Raises
    ------
    InputError
        As for `ContactProblem`, for normal forces of another shape or not finite, and for more than
        `CONTACT_LIMIT` contacts at rest with friction.
    """
    problem = ContactProblem(*map(np.asarray, (W, b, mu, slip_velocity)))
    normal = np.atleast_1d(np.array(normal_forces, dtype=float))
    if normal.shape != problem.mu.shape or not np.all(np.isfinite(normal)):
        raise InputError(
            f"friction_forces, normal_forces: got {normal.tolist()}, need {problem.size} finite "
            "numbers. Fix: give the normal force of each contact, 0 of an open one."
        )
    directions = np.array(problem.slip_directions)
    limit = problem.mu * np.abs(normal)
    given = -directions * limit
    resting = np.flatnonzero((directions == 0) & (limit > 0))
    if resting.size > CONTACT_LIMIT:
        raise InputError(
            f"friction_forces cannot try every choice: got {resting.size} contacts at rest, need "
            f"at most {CONTACT_LIMIT}."
        )
    at = ContactRows(problem.size)
    load = problem.b.copy()
    load += np.sum(problem.W[:, at.normals] * normal, axis=1)
    load += np.sum(problem.W[:, at.tangentials] * given, axis=1)
    sizes = np.abs(problem.b) + np.abs(problem.W[:, at.normals]) @ np.abs(normal)
    sizes += np.abs(problem.W[:, at.tangentials]) @ np.abs(given)
    rows = np.array([at.tangent(i) for i in resting.tolist()], dtype=np.intp)
    box = _Box(problem.W[np.ix_(rows, rows)], load[rows], sizes[rows], limit[resting])
    forces, residual = box.minimum()
    tangential = given + 0.0  # no -0.0
    tangential[resting] = forces
    accelerations = load + np.sum(problem.W[:, rows] * forces, axis=1)
    terms = sizes + np.abs(problem.W[:, rows]) @ np.abs(forces)
    accelerations[np.abs(accelerations) <= _ROUND_OFF * terms] = 0.0
    accelerations[rows[np.abs(forces) < limit[resting]]] = 0.0
    rates = accelerations[at.tangentials]
    modes = tuple(
        ContactMode.LIFTOFF if F_n == 0 else slip_mode(s or a) if s or a else ContactMode.STICK
        for F_n, s, a in zip(normal, directions, rates, strict=True)
    )
    arrays = (normal, tangential, accelerations[at.normals].copy(), rates.copy())
    for array in arrays:
        array.setflags(write=False)
    return ContactSolution(modes, *arrays, residual, box.determined(forces))


@dataclass(frozen=True, eq=False)
class _Box:
    """The least ``F'WF/2 + F'c`` over the box ``|F| <= limit`` of contacts at rest.

    Parameters
    ----------
    W : ndarray, shape (r, r)
        Tangential mobility, positive semidefinite.
    load : ndarray, shape (r,)
        c, the accelerations without these forces.
    sizes : ndarray, shape (r,)
        Sums of the sizes of the terms of c.
    limit : ndarray, shape (r,)
        Bounds, positive.
    """

    W: FloatArray
    load: FloatArray
    sizes: FloatArray
    limit: FloatArray

    def minimum(self) -> tuple[FloatArray, float]:
        """Return the point of least norm among all minima, and its residual.

        At that point the contacts inside the box solve ``W_SS F_S = -c_S - W_SE F_E`` with the
        least norm, as the edges E hold the others: so it is among the candidates, and every
        candidate that passes the check is a minimum.
        """
        best, key, least = np.zeros(self.limit.size), (np.inf, np.inf), np.inf
        for choice in itertools.product((FREE, RIGHT, LEFT), repeat=self.limit.size):
            forces = self._candidate(np.array(choice, dtype=float))
            residual = self._residual(forces, choice)
            own = (residual if residual > _ROUNDING else 0.0, float(forces @ forces))
            if own < key:
                best, key, least = forces, own, residual
        if least > RESIDUAL_TOLERANCE:
            raise ArithmeticError(
                f"friction_forces: no choice solves the convex problem (residual {least:g}), "
                "which has a solution. Fix: check that W is J M^-1 J' to rounding."
            )
        return best, least

    def determined(self, forces: FloatArray) -> bool:
        """Return whether no other forces in the box make the same accelerations."""
        rates = self.load + np.sum(self.W * forces, axis=1)
        terms = self.sizes + np.abs(self.W) @ np.abs(forces)
        still: BoolArray = np.abs(rates) <= RESIDUAL_TOLERANCE * terms
        still |= np.abs(forces) < self.limit
        index = np.flatnonzero(still)
        unit, scaled = self._scaled(index)
        bound = self.limit[index] / unit
        eye = np.eye(index.size)
        rows = np.vstack([eye, -eye]) / np.tile(bound, 2)[:, None]
        face = affine_face(
            scaled,
            scaled @ (forces[index] / unit),
            rows,
            np.ones(len(rows)),
            max(index.size, 1),
            unit=bound,
        )
        return face is None or not np.any(face[1])

    def _scaled(self, index: npt.NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
        """Return units of force, and the block of `index` in them, with a diagonal of ones."""
        diagonal = np.diag(self.W)[index]
        unit = np.divide(1.0, np.sqrt(diagonal), out=np.ones(index.size), where=diagonal > 0)
        return unit, self.W[np.ix_(index, index)] * np.outer(unit, unit)

    def _candidate(self, choice: FloatArray) -> FloatArray:
        """Return the forces at their edges, the free ones of least norm with ``a = 0``."""
        forces = choice * self.limit
        index = np.flatnonzero(choice == FREE)
        if not index.size:
            return forces
        unit, scaled = self._scaled(index)
        goal = -unit * (self.load + np.sum(self.W * forces, axis=1))[index]
        values, vectors = np.linalg.eigh(scaled)
        kept = values > RANK * index.size
        if np.all(kept):
            forces[index] = unit * solve_refined(scaled, goal)
        else:
            basis = vectors[:, kept]
            particular = unit * (basis @ (basis.T @ goal / values[kept]))
            null = np.linalg.qr(unit[:, None] * vectors[:, ~kept])[0]
            forces[index] = particular - null @ (null.T @ particular)
        return np.clip(forces, -self.limit, self.limit)

    def _residual(self, forces: FloatArray, choice: tuple[int, ...]) -> float:
        """Return the largest violation of the law as a fraction of the terms of accelerations."""
        rates = self.load + np.sum(self.W * forces, axis=1)
        terms = self.sizes + np.abs(self.W) @ np.abs(forces)
        share = np.divide(rates, terms, out=np.zeros(rates.size), where=terms > 0)
        edge = np.array(choice)
        inside = np.abs(share)
        outward = np.maximum(edge * share, 0.0)
        return float(np.max(np.where(edge == FREE, inside, outward), initial=0.0))
