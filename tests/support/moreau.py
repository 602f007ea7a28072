"""Moreau's midpoint rule for planar contacts, in NumPy alone: an oracle of final slips."""

from __future__ import annotations

from itertools import product

import numpy as np


def impulses(W, v, mu):
    """Return P (2 n) of least normal impulse with 0 ≤ P_n ⟂ v_n⁺ ≥ 0, friction against v_t⁺.

    v⁺ = v + W P, rows n1, t1, n2, t2, …; every choice of apart, slip to either side and stick is
    solved and checked.
    """
    n, best = len(mu), None
    size = np.max(np.abs(v)) + 1e-300
    for modes in product(("apart", "stick", -1, 1), repeat=n):
        columns, rows = [], []
        for i, mode in enumerate(modes):
            if mode == "apart":
                continue
            unit = np.eye(2 * n)[2 * i : 2 * i + 2]
            rows.append(2 * i)
            if mode == "stick":
                columns += list(unit)
                rows.append(2 * i + 1)
            else:
                columns.append(unit[0] - mode * mu[i] * unit[1])
        P = np.zeros(2 * n)
        if rows:
            U = np.array(columns).T
            P = U @ np.linalg.lstsq((W @ U)[rows], -v[rows], rcond=1e-12)[0]
        after = v + W @ P
        force = np.max(np.abs(P), initial=1e-300)
        fits = np.max(np.abs(after[rows]), initial=0.0) < 1e-9 * size
        for i, mode in enumerate(modes):
            fits &= P[2 * i] >= -1e-9 * force and after[2 * i] >= -1e-9 * size
            fits &= abs(P[2 * i + 1]) <= mu[i] * P[2 * i] + 1e-9 * force
            if mode in (-1, 1):
                fits &= mode * after[2 * i + 1] >= -1e-9 * size
        if fits and (best is None or P[::2].sum() < best[::2].sum()):
            best = P
    return best


def stepped(M, force, gaps, J, mu, e, q, u, step, count):
    """Return coordinates and velocities after each of `count` steps of Moreau's midpoint rule.

    The mass matrix M, (n, n), and rows J, (2 c, n), are constant; `force` of q and `gaps` of q are
    (n,) and (c,); `e` is Newton's coefficient of each contact.
    """
    inverse = np.linalg.inv(M)
    states = np.empty((count + 1, 2, len(q)))
    states[0] = q, u
    for k in range(count):
        q, u = states[k]
        middle = q + step / 2 * u
        free = u + step * inverse @ force(middle)
        closed = np.flatnonzero(gaps(middle) <= 0)
        if len(closed):
            rows = np.ravel([2 * closed, 2 * closed + 1], order="F")
            own = J[rows]
            W, aim = own @ inverse @ own.T, own @ free
            aim[::2] += e[closed] * (own @ u)[::2]
            P = impulses(W, aim, mu[closed])
            assert P is not None
            free = free + inverse @ own.T @ P
        states[k + 1] = middle + step / 2 * free, free
    return states
