"""Impacts of several contacts at once: one complementarity problem per phase.

Compression takes the contact velocities v to v⁺ = v + W P with, at each contact,
0 ≤ P_n ⟂ v_n⁺ ≥ 0 and the cone of friction, opposed to v_t⁺. Restitution adds impulses: at each
contact P_n is at least a part of its compression impulse (Glocker & Pfeiffer 1995). That part is

- Poisson: e;
- energetic: κ, the same at all contacts, such that the normal impulses of restitution give back
  e² of the energy that those of compression took (Stronge's law for the impact as a whole);

and Newton's law asks for v_n⁺ ≥ −e v_n⁻ in a single phase (Moreau 1988). With one contact, slip
that ends or turns within a phase makes these differ from Routh's construction, which follows the
impulse; an impact that involves one contact alone uses that (`solve_impact`).

References
----------
Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics. CISM 302, 1–82.
Glocker & Pfeiffer (1995), Multiple impacts with friction in rigid multibody systems. Nonlinear
    Dynamics 7, 471–497.
Stronge (1990), Rigid body collisions with friction. Proc. R. Soc. A 431, 169–181.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import brentq

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.laws.restitution import RESTITUTIONS

_ROUNDING = 1e-10
"""Of the scale of the velocities: what an inequality may be missed by."""
_LARGEST_PART = 1e3
"""Largest κ that is tried."""


@dataclass(frozen=True)
class SeveralImpact:
    """An impact of several contacts.

    Attributes
    ----------
    impulses : ndarray, shape (2 n,)
        P_n, P_t of each contact; N s.
    velocities : ndarray, shape (2 n,)
        v_n, v_t of each contact after the impact; m/s.
    normal_work, tangential_work : float
        Energy that the impulses give to the mechanism, by direction; J.
    solutions : int
        How many compressions solve the problem; the one of least normal impulse is taken.
    """

    impulses: Array
    velocities: Array
    normal_work: float
    tangential_work: float
    solutions: int


def solve_simultaneous_impact(
    W: Array, mu: Array, velocity: Array, restitution: str = "energetic", e: float = 0.75
) -> SeveralImpact | None:
    """Return the impact of n contacts, or None where no impulses solve it.

    Parameters
    ----------
    W : ndarray, shape (2 n, 2 n)
        J M⁻¹ Jᵀ with rows n1, t1, n2, t2, …; positive semidefinite; 1/kg.
    mu : ndarray, shape (n,)
        Friction coefficients.
    velocity : ndarray, shape (2 n,)
        v_n, v_t of each contact, v_n ≤ 0. With all v_n = 0 the impact without collision is asked
        for: no impulse is then no answer; m/s.
    restitution : {"energetic", "poisson", "newton"}
    e : float
        Coefficient of restitution of all contacts, in [0, 1].
    """
    if restitution not in RESTITUTIONS:
        raise InputError(unknown_name("restitution law", restitution, RESTITUTIONS))
    W, mu, v = (np.asarray(a, dtype=float) for a in (W, mu, velocity))
    if restitution == "newton":
        aim = v.copy()
        aim[::2] *= 1 + e
        found = _nontrivial(W, mu, aim, collision=bool(np.any(v[::2] < 0)))
        return _impact(v, [(found[0], v + W @ found[0])], len(found)) if found else None
    found = _nontrivial(W, mu, v, collision=bool(np.any(v[::2] < 0)))
    if not found:
        return None
    first, between = found[0], v + W @ found[0]
    if restitution == "poisson":
        second = _expansion(W, mu, between, e * first[::2])
    else:
        second = _energetic(W, mu, v, first, e)
    if second is None:
        return None
    return _impact(v, [(first, between), (second, between + W @ second)], len(found))


def _impact(v: Array, phases: list[tuple[Array, Array]], solutions: int) -> SeveralImpact:
    total, works, before = np.zeros_like(v), np.zeros(2), v
    for impulses, after in phases:
        # Velocities are linear in the impulse: the works take their means.
        means = impulses * (before + after) / 2
        works += means[::2].sum(), means[1::2].sum()
        total, before = total + impulses, after
    return SeveralImpact(total, before, float(works[0]), float(works[1]), solutions)


def _nontrivial(W: Array, mu: Array, v: Array, collision: bool) -> list[Array]:
    """Return the solutions of compression, the least normal impulse first, none of them zero."""
    found = frictional_impulses(W, mu, v, np.zeros(len(mu)))
    if not collision:
        size = float(np.max(np.abs(v))) / (float(np.max(np.diag(W))) or 1.0)
        found = [p for p in found if np.max(np.abs(p)) > _ROUNDING * size]
    return sorted(found, key=lambda p: (float(p[::2].sum()), *p))


def _expansion(W: Array, mu: Array, v: Array, least: Array) -> Array | None:
    found = frictional_impulses(W, mu, v, least)
    return min(found, key=lambda p: (float(p[::2].sum()), *p)) if found else None


def _energetic(W: Array, mu: Array, v: Array, first: Array, e: float) -> Array | None:
    between = v + W @ first
    taken = -float(np.sum(first[::2] * (v[::2] + between[::2])) / 2)

    def missing(part: float) -> float:
        second = _expansion(W, mu, between, part * first[::2])
        if second is None:
            return np.inf
        after = between + W @ second
        return float(np.sum(second[::2] * (between[::2] + after[::2])) / 2) - e**2 * taken

    if e == 0 or taken <= 0:
        return _expansion(W, mu, between, np.zeros(len(mu)))
    upper = 1.0
    while missing(upper) < 0:
        upper *= 2
        if upper > _LARGEST_PART:
            return None
    part = float(brentq(missing, 0.0, upper, xtol=1e-15, rtol=1e-14))
    return _expansion(W, mu, between, part * first[::2])


def frictional_impulses(W: Array, mu: Array, v: Array, least: Array) -> list[Array]:
    """Return all impulses P with, at each contact, 0 ≤ P_n − least ⟂ v_n⁺ ≥ 0 and friction.

    Of impulses with the same effect, which differ by what the bodies' rigidity leaves open, those
    of least norm are returned.

    Friction is |P_t| ≤ μ P_n, and P_t = −μ P_n sign(v_t⁺) where v_t⁺ ≠ 0; v⁺ = v + W P.

    Parameters
    ----------
    W, mu, v : ndarray
        As for `solve_simultaneous_impact`.
    least : ndarray, shape (n,)
        ≥ 0; N s.
    """
    speed = float(np.max(np.abs(v), initial=0.0)) + float(np.max(W @ _pairs(least), initial=0.0))
    if speed == 0:
        return [np.zeros_like(v)]
    impulse = speed / (float(np.max(np.diag(W))) or 1.0)
    found: list[Array] = []
    for choice in product(_KINDS, repeat=len(mu)):
        P = _candidate(W, mu, v, least, choice)
        if P is None or not _holds(W, mu, v, least, P, speed, impulse):
            continue
        twins = [k for k, Q in enumerate(found) if np.max(np.abs(W @ (P - Q))) <= 1e-8 * speed]
        if not twins:
            found.append(P)
        elif found[twins[0]] @ found[twins[0]] > P @ P:
            found[twins[0]] = P
    return found


_KINDS = tuple(product((False, True), (-1, 0, 1)))
"""Of one contact: whether it stays closed, and where it slips after (0: it sticks)."""


def _pairs(normal: Array) -> Array:
    both = np.zeros(2 * len(normal))
    both[::2] = normal
    return both


def _candidate(
    W: Array, mu: Array, v: Array, least: Array, choice: tuple[tuple[bool, int], ...]
) -> Array | None:
    """Return the impulses of one choice, of least norm where they are not determined."""
    start, rows, columns = _pairs(least), list[int](), list[Array]()
    for i, (closed, slip) in enumerate(choice):
        n, t = 2 * i, 2 * i + 1
        along = np.zeros(len(v))
        if slip:
            start[t] = -slip * mu[i] * least[i]
        if closed:
            along[n], along[t] = 1.0, -slip * mu[i]
            rows.append(n)
            columns.append(along)
        if not slip:
            across = np.zeros(len(v))
            across[t] = 1.0
            rows.append(t)
            columns.append(across)
    if not rows:
        return start
    U = np.array(columns).T
    matrix, right = W[rows] @ U, -(v + W @ start)[rows]
    solved = np.linalg.lstsq(matrix, right, rcond=1e-12)[0]
    P: Array = start + U @ solved
    return P


def _conditions(
    mu: Array, least: Array, P: Array, after: Array, speed: float, impulse: float
) -> Iterator[bool]:
    for i, friction in enumerate(mu):
        normal, tangential = P[2 * i], P[2 * i + 1]
        v_n, v_t = after[2 * i], after[2 * i + 1]
        extra = normal - least[i]
        yield extra >= -_ROUNDING * impulse
        yield v_n >= -_ROUNDING * speed
        yield min(extra / impulse, v_n / speed) <= _ROUNDING
        yield abs(tangential) <= friction * normal + _ROUNDING * impulse
        if abs(v_t) > _ROUNDING * speed:
            yield abs(tangential + friction * normal * np.sign(v_t)) <= _ROUNDING * impulse


def _holds(
    W: Array, mu: Array, v: Array, least: Array, P: Array, speed: float, impulse: float
) -> bool:
    return all(_conditions(mu, least, P, v + W @ P, speed, impulse))
