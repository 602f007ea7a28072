"""The check behind every answer for several contacts: an LCP, its residual, borders and twins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from painleve_sym.complementarity.contact import ContactMode
from painleve_sym.complementarity.faces import BoolArray, FloatArray
from painleve_sym.complementarity.lcp import (
    LCP,
    RESIDUAL_TOLERANCE,
    cleaned,
    equilibrate,
    residual,
    same_point,
    shares,
)

_DISTINCT = 1e-8  # solutions that differ by less in every row are one found in two branches
_NEAR = 1e-6  # part of the largest force; farther apart, `same_point` need not be asked


@dataclass(frozen=True, eq=False)
class CheckedForces:
    """Hold forces that passed the residual check.

    Attributes
    ----------
    z : ndarray, shape (N,)
        The point of the LCP, equilibrated, negligible entries exactly 0.
    forces : ndarray, shape (2 n,)
        F_n, F_t contact by contact, in N.
    residual : float
        Of z in the LCP as stated.
    modes : tuple of ContactMode
        What each contact does.
    possible : tuple of BoolArray
        For each contact, which of its branches hold these forces, borders included.
    """

    z: FloatArray
    forces: FloatArray
    residual: float
    modes: tuple[ContactMode, ...]
    possible: tuple[BoolArray, ...]


class ForceCheck:
    """Measure forces by the LCP of their problem.

    Parameters
    ----------
    lcp : LCP
        One pair ``(F_n, a_n)`` for a sliding contact; three for one at rest: ``(F_n, a_n)``,
        ``(mu F_n + F_t, a_t^+)`` and ``(a_t^-, mu F_n - F_t)``.
    mobility, offset : ndarray, shapes (2 n, 2 n) and (2 n,)
        W and b.
    mu : ndarray, shape (n,)
        Friction coefficients.
    directions : sequence of n int
        Signs of the slip velocities, 0 at rest.
    """

    def __init__(
        self,
        lcp: LCP,
        mobility: FloatArray,
        offset: FloatArray,
        mu: FloatArray,
        directions: Sequence[int],
    ) -> None:
        self.lcp, self.mobility, self.offset = lcp, mobility, offset
        self.mu, self.directions = mu, directions
        self.scaled, self.unit = equilibrate(lcp)

    def check(self, forces: FloatArray) -> CheckedForces | None:
        """Return the forces with negligible parts removed, or None if they are no solution."""
        z = cleaned(self.scaled, self._pairs(forces) / self.unit, RESIDUAL_TOLERANCE)
        if z is None:
            return None
        w = shares(self.scaled, z)[1]
        z_zero, w_zero = z == 0, np.abs(w) <= RESIDUAL_TOLERANCE
        exact, modes, possible = np.zeros_like(forces), list[ContactMode](), list[BoolArray]()
        k = 0
        for i, direction in enumerate(self.directions):
            pairs = slice(k, k + (1 if direction else 3))
            k = pairs.stop
            mode, branches = _standing(z_zero[pairs], w_zero[pairs], float(self.mu[i]), direction)
            normal = float(z[pairs.start] * self.unit[pairs.start])
            limit = float(self.mu[i]) * normal
            # On the edge of the cone exactly: what rounding leaves could fill a row of zeros.
            edge = mode is ContactMode.SLIP_POS or (not direction and z_zero[pairs][1])
            friction = -limit if edge else limit
            if mode is ContactMode.STICK and not (edge or w_zero[pairs][2]):
                friction = min(max(float(forces[2 * i + 1]), -limit), limit)
            exact[2 * i : 2 * i + 2] = normal, friction + 0.0  # no -0.0
            modes.append(mode)
            possible.append(branches)
        measured = residual(self.lcp, self._pairs(exact))
        if measured > RESIDUAL_TOLERANCE:
            return None
        return CheckedForces(z, exact, measured, tuple(modes), tuple(possible))

    def twin(self, point: CheckedForces, known: Sequence[CheckedForces]) -> int | None:
        """Return the position of the same forces among those known, or None."""
        if not known:
            return None
        table = np.array([other.forces for other in known])
        gap = np.max(np.abs(table - point.forces), axis=1)
        size = np.maximum(np.max(np.abs(table), axis=1), np.max(np.abs(point.forces)))
        near = np.flatnonzero(gap <= _NEAR * size)
        same = (
            int(k) for k in near if same_point(self.scaled, point.z, known[int(k)].z, _DISTINCT)
        )
        return next(same, None)

    def _pairs(self, forces: FloatArray) -> FloatArray:
        """Return the z of forces: the smallest ``a_t^-`` that leaves ``a_t^+ >= 0``."""
        accelerations = self.mobility @ forces + self.offset
        z: list[float] = []
        for i, direction in enumerate(self.directions):
            normal, friction = forces[2 * i : 2 * i + 2]
            z.append(normal)
            if not direction:
                z += [self.mu[i] * normal + friction, max(-accelerations[2 * i + 1], 0.0)]
        return np.array(z)


def _standing(
    z_zero: BoolArray, w_zero: BoolArray, mu: float, direction: int
) -> tuple[ContactMode, BoolArray]:
    """Return the mode of one contact and which of its branches it may leave by.

    The branches come in the order of `SeveralContacts`: lift-off, then slip along v_t; at rest slip
    along +, slip along -, stick; at rest without friction, contact.
    """
    unloaded, closed = bool(z_zero[0]), bool(w_zero[0])
    if direction:
        slipping = ContactMode.SLIP_POS if direction > 0 else ContactMode.SLIP_NEG
        return ContactMode.LIFTOFF if unloaded else slipping, np.array([unloaded, closed])
    not_right, not_left = bool(w_zero[1]), bool(z_zero[2])
    branches = np.array(
        [
            unloaded,
            closed and bool(z_zero[1]) and not_left,
            closed and bool(w_zero[2]) and not_right,
            closed and not_left and not_right,
        ]
    )
    if mu == 0:
        branches = np.array([unloaded, closed])
    if unloaded:
        return ContactMode.LIFTOFF, branches
    if not_right and not_left:
        return ContactMode.STICK, branches
    return ContactMode.SLIP_NEG if not_right else ContactMode.SLIP_POS, branches
