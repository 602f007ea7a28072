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
    principal_block,
    residual,
    shares,
)

_DISTINCT = (
    1e-8  # of the terms of every acceleration; nearer solutions are one found in two branches
)
_NOISE = 1e-13  # of the largest force: what a solve may leave of a zero, if the check agrees
_NEAR = 1e-6  # part of the largest force; forces farther apart are not compared by row


@dataclass(frozen=True, eq=False)
class CheckedForces:
    """Hold forces that passed the residual check.

    Attributes
    ----------
    forces : ndarray, shape (2 n,)
        F_n, F_t contact by contact, in N.
    residual : float
        Of their point in the LCP as stated.
    modes : tuple of ContactMode
        What each contact does.
    possible : tuple of BoolArray
        For each contact, which of its branches hold these forces, borders included.
    """

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
        """Return the forces with negligible parts removed, or None if they are no solution.

        Forces that fail as they are get one correction on their active pairs, since a matrix near
        a singular one magnifies what the scaling of the problem changed in its last digit.
        """
        settled = self._settled(forces)
        quiet = np.where(self._small(np.abs(settled), np.abs(settled)), 0.0, settled)
        for candidate in (quiet, settled):
            found = self._described(self._pairs(candidate) / self.unit)
            if found is not None:
                return found
        return self._described(self._corrected(self._pairs(settled) / self.unit))

    def _described(self, candidate: FloatArray) -> CheckedForces | None:
        """Return a point of the equilibrated LCP as checked forces, or None if it fails."""
        z = cleaned(self.scaled, candidate, RESIDUAL_TOLERANCE)
        if z is None:
            return None
        z_zero, w_zero = z == 0, np.abs(shares(self.scaled, z)[1]) <= RESIDUAL_TOLERANCE
        point, forces = self.unit * z, np.zeros(2 * len(self.directions))
        modes, possible = list[ContactMode](), list[BoolArray]()
        k = 0
        for i, direction in enumerate(self.directions):
            pairs = slice(k, k + (1 if direction else 3))
            mu = float(self.mu[i])
            mode, branches = _standing(z_zero[pairs], w_zero[pairs], mu, direction)
            normal, limit = float(point[k]), mu * float(point[k])
            # On the edge of the cone exactly: what rounding leaves could fill a row of zeros.
            edge = mode is ContactMode.SLIP_POS or (not direction and z_zero[k + 1])
            friction = -limit if edge else limit
            if mode is ContactMode.STICK and not (edge or w_zero[k + 2]):
                friction = min(max(float(point[k + 1]) - limit, -limit), limit)
            forces[2 * i : 2 * i + 2] = normal, friction + 0.0  # no -0.0
            modes.append(mode)
            possible.append(branches)
            k = pairs.stop
        measured = residual(self.lcp, self._pairs(forces))
        if measured > RESIDUAL_TOLERANCE:
            return None
        return CheckedForces(forces, measured, tuple(modes), tuple(possible))

    def twin(self, point: CheckedForces, known: Sequence[CheckedForces]) -> int | None:
        """Return the position of the same forces among those known, or None."""
        if not known:
            return None
        table = np.array([other.forces for other in known])
        gap = np.max(np.abs(table - point.forces), axis=1)
        size = np.maximum(np.max(np.abs(table), axis=1), np.max(np.abs(point.forces)))
        near = np.flatnonzero(gap <= _NEAR * size)
        return next((int(k) for k in near if self._same(point.forces, table[k])), None)

    def _same(self, a: FloatArray, b: FloatArray) -> bool:
        """Tell whether the step from a to b is negligible for every acceleration."""
        size = np.maximum(np.abs(a), np.abs(b))
        step = np.where(self._small(np.abs(a - b), size), 0.0, np.abs(a - b))
        return bool(np.all(self._shares(step, size) <= _DISTINCT))

    def _settled(self, forces: FloatArray) -> FloatArray:
        """Return the forces without what matters to no acceleration: whole contacts, or noise."""
        size = np.abs(forces)
        negligible = self._shares(size, size).reshape(-1, 2) <= RESIDUAL_TOLERANCE
        return np.where(np.repeat(np.all(negligible, axis=1), 2), 0.0, forces)

    def _small(self, part: FloatArray, size: FloatArray) -> BoolArray:
        """Tell which parts of forces are noise beside the largest one, in comparable units.

        Where forces balance, every term of an acceleration may be rounding and `_shares` blind.
        """
        weight = np.sqrt(np.diag(self.mobility))
        small: BoolArray = (weight > 0) & (weight * part <= _NOISE * np.max(weight * size))
        return small

    def _shares(self, part: FloatArray, forces: FloatArray) -> FloatArray:
        """Return how much each part of the forces matters to any acceleration, by its terms."""
        terms = np.abs(self.offset) + np.abs(self.mobility) @ forces
        effects, terms = np.abs(self.mobility) * part, terms[:, None]
        ratio = np.divide(effects, terms, out=np.zeros_like(effects), where=terms > 0)
        share: FloatArray = np.max(ratio, axis=0)
        # Where nothing moves, forces count by themselves.
        idle = np.all(self.mobility == 0, axis=0) & (part > 0)
        share[idle] = part[idle] / forces[idle]
        return share

    def _corrected(self, z: FloatArray) -> FloatArray:
        """Return z after one step to ``w = 0`` in the pairs where z outweighs w."""
        matrix, w = self.scaled.matrix, self.scaled.matrix @ z + self.scaled.offset
        active = np.flatnonzero(z > np.abs(w))
        better = z.copy()
        block = principal_block(matrix, active)
        better[active] -= np.linalg.lstsq(block, w[active], rcond=None)[0]
        return better

    def _pairs(self, forces: FloatArray) -> FloatArray:
        """Return the z of forces: the smallest ``a_t^-`` that leaves ``a_t^+ >= 0``."""
        z = np.zeros(self.lcp.size)
        starts = np.cumsum([0] + [1 if s else 3 for s in self.directions])[:-1]
        rests = np.array([not s for s in self.directions])
        z[starts] = forces[0::2]
        z[starts[rests] + 1] = (self.mu * forces[0::2] + forces[1::2])[rests]
        rates = self.lcp.matrix @ z + self.lcp.offset
        z[starts[rests] + 2] = np.maximum(-rates[starts[rests] + 1], 0.0)
        return z


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
