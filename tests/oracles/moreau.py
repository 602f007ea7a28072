"""Moreau's time stepping for planar bodies with frictional contacts, and two tables by hand.

Independent of the package: mass matrices, forces and contact rows are derived by hand with vectors,
and the contact problem of a step is solved by enumeration. A step of length h goes half a step
ahead in place, takes M, J and the forces there, and changes the velocities from u to u⁺ (Moreau
1988; Jean 1999)::

    M (u⁺ − u) = h f + Jᵀ P
    0 <= P_n  ⟂  v_n⁺ + e v_n >= 0    |P_t| <= μ P_n, and P_t = −μ P_n sign(v_t⁺) where v_t⁺ ≠ 0

over the contacts that are closed there. Rows and impulses are n1, t1, n2, t2, ….

References
----------
Moreau (1988); Jean (1999).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

OPEN, STICK, RIGHT, LEFT = "open", "stick", "right", "left"
_NEGLIGIBLE = 1e-9
"""Of the largest velocity or impulse of a step: what an inequality may be missed by."""


@dataclass(frozen=True)
class Table:
    """A table with feet (−a, −h₁), (0, −h₂), (a, −h₃) about its mass centre; q = x, y, θ.

    The ground under each foot is level, h₁, h₂ or h₃ below y = 0.
    """

    m: float = 10.0
    J: float = 1.5
    a: float = 0.6
    h: tuple[float, float, float] = (0.7, 0.7, 0.7)
    g: float = 9.8
    mu: tuple[float, float, float] = (0.4, 0.4, 0.4)

    size = 3

    def foot(self, q: Array, x: float, h: float) -> tuple[float, Array]:
        """Return gap and rows (n, t) of the foot (x, −h) of the body: v = v_C + θ' (−r_y, r_x)."""
        s, c = np.sin(q[2]), np.cos(q[2])
        r_x, r_y = x * c + h * s, x * s - h * c
        rows = np.zeros((2, self.size))
        rows[0, 1:3] = 1.0, r_x
        rows[1, [0, 2]] = 1.0, -r_y
        return q[1] + h + r_y, rows

    def contacts(self, q: Array) -> tuple[Array, Array]:
        """Return the gaps, shape (3,), and the rows of all contacts, shape (6, size)."""
        feet = [self.foot(q, x, h) for x, h in zip((-self.a, 0.0, self.a), self.h, strict=True)]
        return np.array([gap for gap, _ in feet]), np.vstack([rows for _, rows in feet])

    def mass(self, q: Array) -> Array:
        """Return the mass matrix."""
        return np.diag([self.m, self.m, self.J])

    def force(self, q: Array, u: Array) -> Array:
        """Return what M u' is without contacts."""
        return np.array([0.0, -self.m * self.g, 0.0])


@dataclass(frozen=True)
class SprungTable(Table):
    """The same, its middle foot a point mass on a spring in the leg; q = x, y, θ, s.

    The leg has the length h₂ + s; k s + c s' pulls the foot back.
    """

    m_foot: float = 2.0
    h: tuple[float, float, float] = (0.7, 0.75, 0.65)
    k: float = 4000.0
    c: float = 60.0

    size = 4

    def middle(self, q: Array) -> Array:
        """Return the rows (x, y) of the velocity of the foot at C + (h₂ + s) (sin θ, −cos θ)."""
        length, s, c = self.h[1] + q[3], np.sin(q[2]), np.cos(q[2])
        return np.array([[1, 0, length * c, s], [0, 1, length * s, -c]])

    def contacts(self, q: Array) -> tuple[Array, Array]:
        gaps, rows = super().contacts(q)
        gaps[1] = q[1] + self.h[1] - (self.h[1] + q[3]) * np.cos(q[2])
        rows[2:4] = self.middle(q)[::-1]
        return gaps, rows

    def mass(self, q: Array) -> Array:
        foot = self.middle(q)
        return np.diag([self.m, self.m, self.J, 0]) + self.m_foot * foot.T @ foot

    def force(self, q: Array, u: Array) -> Array:
        length, s, c = self.h[1] + q[3], np.sin(q[2]), np.cos(q[2])
        turning = 2 * u[2] * u[3] * np.array([c, s]) + length * u[2] ** 2 * np.array([-s, c])
        carried = self.middle(q).T @ (turning + np.array([0.0, self.g]))
        own = np.array([0.0, self.m * self.g, 0.0, self.k * q[3] + self.c * u[3]])
        return -own - self.m_foot * carried


class Stepping:
    """Steps of a table; the states of the contacts in the last step are tried first in the next."""

    def __init__(self, table: Table, e: float = 0.0, closed: float = 1e-12) -> None:
        self.table, self.e, self.closed = table, e, closed
        self.last: dict[tuple[int, ...], tuple[str, ...]] = {}

    def run(self, q: Array, u: Array, h: float, steps: int) -> tuple[Array, Array]:
        """Return coordinates and velocities after that many steps of length h."""
        for _ in range(steps):
            middle = q + h / 2 * u
            u = self.step(middle, u, h)
            q = middle + h / 2 * u
        return q, u

    def step(self, q: Array, u: Array, h: float) -> Array:
        """Return the velocities after a step, of which q is the middle."""
        mass = self.table.mass(q)
        free = u + h * np.linalg.solve(mass, self.table.force(q, u))
        gaps, rows = self.table.contacts(q)
        active = tuple(int(i) for i in np.flatnonzero(gaps <= self.closed))
        if active:
            pairs = [r for i in active for r in (2 * i, 2 * i + 1)]
            J = rows[pairs]
            shift = np.zeros(len(pairs))
            shift[::2] = self.e * (J @ u)[::2]
            spread = np.linalg.solve(mass, J.T)
            mu = np.array(self.table.mu)[list(active)]
            free = free + spread @ self.impulses(active, J @ spread, J @ free + shift, mu)
        return free

    def impulses(self, active: tuple[int, ...], W: Array, aim: Array, mu: Array) -> Array:
        """Return P with v = aim + W P within the laws of the active contacts."""
        choices = list(itertools.product((OPEN, STICK, RIGHT, LEFT), repeat=len(mu)))
        if active in self.last:
            choices.insert(0, self.last[active])
        for states in choices:
            P = _of(states, W, aim, mu)
            if _holds(states, P, aim + W @ P, mu):
                self.last[active] = states
                return P
        raise ArithmeticError(f"no impulses for {aim}")


def _of(states: tuple[str, ...], W: Array, aim: Array, mu: Array) -> Array:
    """Return the impulses of the states, of least norm where the bodies leave them open."""
    columns, rows = [], []
    for i, state in enumerate(states):
        if state == OPEN:
            continue
        n, t = np.eye(len(aim))[[2 * i, 2 * i + 1]]
        slope = {RIGHT: -mu[i], LEFT: mu[i], STICK: 0.0}[state]
        columns.append(n + slope * t)
        rows.append(2 * i)
        if state == STICK:
            columns.append(t)
            rows.append(2 * i + 1)
    if not rows:
        return np.zeros(len(aim))
    U = np.array(columns).T
    return U @ np.linalg.lstsq(W[rows] @ U, -aim[rows], rcond=1e-11)[0]


def _holds(states: tuple[str, ...], P: Array, v: Array, mu: Array) -> bool:
    fast = _NEGLIGIBLE * (1e-3 + np.max(np.abs(v)))
    hard = _NEGLIGIBLE * (1e-3 + np.max(np.abs(P)))
    for i, state in enumerate(states):
        P_n, P_t, v_n, v_t = *P[2 * i : 2 * i + 2], *v[2 * i : 2 * i + 2]
        good = {
            OPEN: v_n >= -fast,
            STICK: abs(v_n) <= fast and abs(v_t) <= fast and abs(P_t) <= mu[i] * P_n + hard,
            RIGHT: abs(v_n) <= fast and v_t >= -fast,
            LEFT: abs(v_n) <= fast and v_t <= fast,
        }[state]
        if not (good and P_n >= -hard):
            return False
    return True
