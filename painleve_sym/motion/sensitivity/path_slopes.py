"""Derivatives of an impact of several contacts: of its path, piece by piece.

Along a straight piece dP/dτ follows from a linear system, v and P change linearly with τ, and the
piece ends where a polynomial of its length L vanishes: v_n reaches its border, v_t reaches 0, a
restitution or the energy of all is given back. With the sequence of pieces frozen, all of these are
smooth functions of mobility, friction, velocities and restitution, and their derivatives follow one
from the other: those of dP/dτ from the linear system, that of L from the polynomial (implicit
function), and those of what is reached from both.

The impact is differentiable where the sequence stays the same nearby. Where two events end a piece
together, or an impact begins with a slip that is exactly 0 and does not stick, all derivatives have
to agree with that, as those of a symmetric impact in a symmetric direction do; else they do not
exist.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.contact_rows import ContactRows
from painleve_sym.engines.simultaneous import AtOnce, PathRecord, Straight
from painleve_sym.laws.restitution import Measure

# Of the largest singular value: less is zero, as in the path.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class ImpactData:
    """Derivatives of the data of an impact of n contacts in k directions.

    Shapes are (2 n, 2 n, k) of W, (n, k) of mu and e, (2 n, k) of the velocity, and (k,).
    Derivatives of velocities that are small against the floor count as 0, m/s per unit; `tolerance`
    is the part of the terms of a derivative within which it is 0.
    """

    W: Array
    mu: Array
    velocity: Array
    e: Array
    floor: Array
    tolerance: float


@dataclass(frozen=True)
class ImpactSlopes:
    """Derivatives of a `SimultaneousImpact`, of shape (2 n, k); nan where they do not exist."""

    velocities: Array
    impulses: Array
    works: Array


def impact_slopes(path: PathRecord, data: ImpactData) -> ImpactSlopes:
    """Return the derivatives of the impact that followed a path, by those of its data."""
    slopes = _Slopes(path, data)
    for step in path.steps:
        if isinstance(step, AtOnce):
            slopes.take(step)
        else:
            slopes.follow(step)
    lost = np.nan if slopes.is_lost else 0.0
    mass, speed = path.mass, path.speed
    return ImpactSlopes(
        np.ldexp(slopes.velocity, speed) + lost,
        np.ldexp(slopes.impulses, speed - mass) + lost,
        np.ldexp(slopes.works, 2 * speed - mass) + lost,
    )


class _Slopes:
    """Derivatives of the numbers of a path as it is followed, with k directions as last axis."""

    def __init__(self, path: PathRecord, data: ImpactData) -> None:
        self.path, self.tolerance = path, data.tolerance
        self.W, self.mu = np.ldexp(data.W, -path.mass), data.mu
        shares = path.e.tolist()
        self.share = np.array([[path.law.share(e)] for e in shares])
        self.share_slopes = np.array([[path.law.share_slope(e)] for e in shares]) * data.e
        self.velocity = np.ldexp(data.velocity, -path.speed)
        self.rows = ContactRows(len(self.mu))
        self.normals, self.tangentials = self.rows.normals, self.rows.tangentials
        self.measure = path.law.measure
        kinematic, v_n = self.measure is Measure.VELOCITY, path.velocity[self.normals]
        factor = self.share if kinematic else 0.0
        self.border = -factor * self.velocity[self.normals]
        self.border -= kinematic * v_n[:, None] * self.share_slopes
        n, k = self.mu.shape
        self.budget, self.weights, self.work = np.zeros((n, k)), np.zeros((n, k)), np.zeros(k)
        self.impulses, self.works = np.zeros(self.velocity.shape), np.zeros(self.velocity.shape)
        # The largest terms of velocities and energies so far.
        self.floor = np.ldexp(data.floor, -path.speed)
        self.size = np.maximum(self.floor, np.max(np.abs(self.velocity), axis=0))
        self.energy_size = np.zeros(k)
        # The last speed of an energetic restitution is a square root at e = 0.
        collides = bool(np.any(v_n < 0))
        energetic = self.measure is Measure.WORK
        self.is_lost = energetic and collides and bool(np.any(data.e[path.e == 0]))

    # ---- a straight piece ----

    def follow(self, step: Straight) -> None:
        """Follow a straight piece."""
        self._stick(step)
        self._pin_velocities(step.velocities, step)
        push = self._push(step)
        rates = _applied(self.W, step.push) + self.path.W @ push
        length = step.event.length
        change = self._length(step, push, rates)
        impulses = push * length + np.outer(step.push, change)
        before = self.velocity
        self.velocity = before + rates * length + np.outer(step.rates, change)
        terms = _applied(np.abs(self.W), np.abs(step.push)) + np.abs(self.path.W) @ np.abs(push)
        terms = terms * length + np.abs(np.outer(step.rates, change))
        self.size = np.maximum(self.size, np.max(terms, axis=0))
        self._pin_velocities(step.velocities_after, step)

        done, mean = step.push * length, (step.velocities + step.velocities_after) / 2
        works = impulses * mean[:, None] + done[:, None] * (before + self.velocity) / 2
        self.impulses += impulses
        self.works += works
        largest = np.max(np.abs(works) + np.outer(np.abs(done), self.floor), axis=0)
        self.energy_size += largest + np.max(np.abs(impulses), axis=0)
        self._spend(step, done * mean, works, impulses)

    def _stick(self, step: Straight) -> None:
        """Stop the slips that a direction gives to contacts which stick from their beginning.

        A slip ε, to either side, stops after an impulse of first order in ε. Friction to that side
        adds to the impulses of sticking what stops ε, whatever μ is.
        """
        rows, W, U = list(step.rows), self.path.W, step.columns
        slips = np.array(
            [np.zeros_like(self.work) if self.rows.is_normal(r) else self.velocity[r] for r in rows]
        )
        if not np.any(slips):
            return
        impulses = -U @ np.linalg.pinv(W[rows] @ U, rcond=_ROUNDING) @ slips
        works = impulses * step.velocities[:, None]
        self.velocity = self.velocity + W @ impulses
        self.impulses += impulses
        self.works += works
        self.work = self.work + works.sum(axis=0)

    def _push(self, step: Straight) -> Array:
        """Return the derivatives of dP/dτ."""
        v_n, mu = step.velocities[self.normals], self.path.mu
        normal, side = step.fixed[self.normals], np.sign(step.fixed[self.tangentials])
        weighted = (normal != 0) & ((v_n < self.path.border) | (step.budget > 0))
        fixed = np.zeros_like(self.velocity)
        fixed[self.normals] = np.where(weighted[:, None], self.weights, 0.0)
        fixed[self.tangentials] = side[:, None] * (
            normal[:, None] * self.mu + mu[:, None] * fixed[self.normals]
        )
        # As the path does: what leaves the border has the full push from then on.
        self.weights[(v_n == self.path.border) & (step.budget == 0)] = 0.0
        if not step.rows:
            return fixed
        W, rows, U = self.path.W, list(step.rows), step.columns
        moved, slopes = self._columns(rows, U)
        matrix = W[rows] @ U
        right = -_applied(self.W[rows], step.fixed) - W[rows] @ fixed
        x, change = least_norm_slopes(matrix, slopes, -W[rows] @ step.fixed, right)
        return fixed + _applied(moved, x) + U @ change

    def _columns(self, rows: list[int], columns: Array) -> tuple[Array, Array]:
        """Return the derivatives of directions of impulses, and of the rates of rows by them.

        Friction changes the directions of slips.
        """
        moved = np.zeros((*columns.shape, len(self.work)))
        share = np.abs(columns[self.normals]) * np.sign(columns[self.tangentials])
        moved[self.tangentials] = share[:, :, None] * self.mu[:, None, :]
        slopes = np.einsum("rjk,jc->rck", self.W[rows], columns)
        return moved, slopes + np.einsum("rj,jck->rck", self.path.W[rows], moved)

    def _length(self, step: Straight, push: Array, rates: Array) -> Array:
        """Return the derivatives of the length, shape (k,), at which its event has its zero."""
        (length, kind, i), v, force = step.event, step.velocities, step.push
        n, t = self.rows.normal(i), self.rows.tangent(i)
        if kind in ("border", "slip"):
            row, border = (n, self.border[i]) if kind == "border" else (t, 0.0)
            moved = self.velocity[row] - border + rates[row] * length
            change: Array = -moved / step.rates[row]
        elif kind == "spent" and self.measure is Measure.IMPULSE:
            change = (self.budget[i] - push[n] * length) / force[n]
        elif kind == "spent":
            mean, end = v[n] + step.rates[n] * length / 2, v[n] + step.rates[n] * length
            given = push[n] * mean + force[n] * (self.velocity[n] + rates[n] * length / 2)
            change = (self.budget[i] - given * length) / (force[n] * end)
        else:
            power = v @ push + force @ self.velocity
            slope = step.rates @ push + force @ rates
            taken = self.work + power * length + slope * length**2 / 2
            change = -taken / (force @ v + force @ step.rates * length)
        return change

    def _spend(self, step: Straight, works: Array, moved: Array, impulses: Array) -> None:
        """Update the remaining restitution of each contact, and the energy of all."""
        kinetic = self.measure is Measure.IMPULSE
        self.work = self.work + moved.sum(axis=0)
        if self.measure is Measure.VELOCITY:
            return
        given = step.push[self.normals] * step.event.length if kinetic else works[self.normals]
        change = impulses[self.normals] if kinetic else moved[self.normals]
        stored = self.share * change + given[:, None] * self.share_slopes
        stored = stored if kinetic else -stored
        spends = ~step.compresses & (step.budget > 0)
        self.budget = self.budget + np.where(step.compresses[:, None], stored, 0.0)
        self.budget = self.budget - np.where(spends[:, None], change, 0.0)
        self.energy_size += np.max(np.abs(stored), axis=0)
        if kinetic and step.work_after == 0:
            self._vanishes(self.work, self.energy_size)
            self.work, self.budget = np.zeros_like(self.work), np.zeros_like(self.budget)
        spent = step.budget_after == 0
        self._vanishes(self.budget[spent], self.energy_size)
        self.budget[spent] = 0.0

    # ---- one mode for each contact ----

    def take(self, step: AtOnce) -> None:
        """Follow impulses of one mode for each contact."""
        W, rows, U = self.path.W, list(step.rows), step.columns
        rebound = np.zeros_like(self.velocity)
        if not step.weighs and step.e is not None:
            rebound[self.normals] = -step.e[:, None] * self.velocity[self.normals]
            rebound[self.normals] -= step.velocities[self.normals, None] * self.share_slopes
        aim, impulses = self.velocity - rebound, np.zeros_like(self.velocity)
        if rows:
            moved, slopes = self._columns(rows, U)
            x = np.linalg.pinv(U) @ step.impulses
            right = -aim[rows] - _applied(slopes, x)
            impulses = _applied(moved, x) + U @ _change_in_range(W[rows] @ U, slopes, x, right)
        if step.weighs:
            stops = np.where(self.path.bilateral, 0.0, step.impulses[self.normals])
            top = int(np.argmax(stops))
            self.weights = np.zeros_like(self.weights)
            if stops[top] > 0:
                relative = impulses[self.normals] - np.outer(
                    stops, impulses[self.rows.normal(top)] / stops[top]
                )
                self.weights = np.where(self.path.bilateral[:, None], 0.0, relative / stops[top])
            return
        rates = aim + _applied(self.W, step.impulses) + W @ impulses
        rates[rows] = 0.0
        size = np.maximum(self.size, np.max(np.abs(W) @ np.abs(impulses), axis=0))
        self._vanishes(rates[step.rates == 0], size)
        before, self.velocity = self.velocity, rates + rebound
        after = step.velocities + W @ step.impulses
        self.impulses += impulses
        self.works += impulses * (step.velocities + after)[:, None] / 2
        self.works += step.impulses[:, None] * (before + self.velocity) / 2

    # ---- what vanishes ----

    def _pin_velocities(self, velocities: Array, step: Straight) -> None:
        """Hold velocities that are exactly on their border, or 0 in friction, to that."""
        slides = step.rubs & ((self.path.mu > 0) | np.any(self.mu != 0, axis=1))
        stops = slides & (velocities[self.tangentials] == 0)
        rests = velocities[self.normals] == self.path.border
        self._vanishes(self.velocity[self.normals][rests] - self.border[rests], self.size)
        self._vanishes(self.velocity[self.tangentials][stops], self.size)
        self.velocity[self.normals][rests] = self.border[rests]
        self.velocity[self.tangentials][stops] = 0.0
        # Without friction, its derivative has the sign of a slip that may be 0.
        if np.any(slides & (self.path.mu == 0)):
            self.is_lost = True

    def _vanishes(self, values: Array, size: Array) -> None:
        """Note where derivatives, shape (…, k), of a quantity that vanishes exceed rounding."""
        self.is_lost |= bool(np.any(~(np.abs(values) <= self.tolerance * size)))


def _applied(matrix: Array, vector: Array) -> Array:
    """Return the derivatives of matrix · vector by the matrix, shape (rows, k)."""
    product: Array = np.einsum("rck,c->rk", matrix, vector)
    return product


def least_norm_slopes(
    matrix: Array, slopes: Array, right: Array, right_slopes: Array
) -> tuple[Array, Array]:
    """Return the solution of least norm and its derivatives, where the rank stays as it is.

    Shapes are (m, n) and (m, n, k) of the matrix, (m,) and (m, k) of the right side, which is in
    the range of the matrix.

    References
    ----------
    Golub & Pereyra (1973).
    """
    inverse = np.linalg.pinv(matrix, rcond=_ROUNDING)
    x = inverse @ right
    beyond = np.eye(len(x)) - inverse @ matrix
    change = inverse @ (right_slopes - _applied(slopes, x))
    return x, change + beyond @ np.einsum("rck,r->ck", slopes, inverse.T @ x)


def _change_in_range(matrix: Array, slopes: Array, x: Array, right: Array) -> Array:
    """Return the derivatives of the solution x that lies in the range of a matrix.

    Shapes are (m, m), (m, m, k), (m,) and (m, k); those of the right side are without the
    derivatives of the matrix times x.
    """
    left, stretch, ways = np.linalg.svd(matrix)
    rank = int(np.sum(stretch > _ROUNDING * stretch[0]))
    F, G = left[:, :rank] * stretch[:rank], ways[:rank]
    # The group inverse.
    core = np.linalg.pinv(G @ F, rcond=_ROUNDING)
    inverse = F @ core @ core @ G
    beyond = np.eye(len(x)) - matrix @ inverse
    change: Array = inverse @ right + beyond @ _applied(slopes, inverse @ x)
    return change
