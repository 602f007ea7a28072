"""All forces of one contact in space with zero slip velocity: lift-off, sticking, every slip.

Rows and forces are ordered n, t1, t2, and e is the direction (cos φ, sin φ) in which slip begins::

    W = [[W_nn, w'], [u, T]],    F = F_n (1, -μ e),    a_n = 0,    a_t = λ e with λ > 0

give two equations for F_n, with e⊥ the direction a right angle ahead of e:

    A F_n + b_n = 0,         A(φ) = W_nn - μ w·e
    h F_n + b_t·e⊥ = 0,      h(φ) = e⊥·(u - μ T e)

A mobility is symmetric, u = w; the W of one contact alone is not where the forces of others follow
from its own.

Both hold where G(φ) = A (b_t·e⊥) - b_n h vanishes. G is a trigonometric polynomial of degree 2, so
its zeros are those roots of a polynomial of degree 4 in exp(iφ) that lie on the unit circle.

For a positive definite W the number of solutions is 1 or 3, unless a border is met; the proof is
in ``docs/paradox-in-space.md``.
"""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from painleve_sym.complementarity.solution_sets import RANK, FloatArray, solve_refined
from painleve_sym.contacts.local_mode import ContactMode, Vector

_VANISHES = 1e-14  # of the terms of G: about 50 roundings
_SAMPLES = 16  # directions tried where G vanishes in all
_POLISH = 6  # Newton steps: the roots of the quartic are near


class RestForce(NamedTuple):
    """A force that solves one piece of the law at rest, before any check of its inequalities.

    Attributes
    ----------
    mode : ContactMode
    force : list of 3 float
    isolated : bool
        False where it is one of a continuum.
    """

    mode: ContactMode
    force: Vector
    isolated: bool = True


def forces_at_rest(W: list[Vector], b: Vector, mu: float) -> Iterator[RestForce]:
    """Yield a force for each piece of the law that its equations allow.

    Parameters
    ----------
    W : list of 3 rows
        Mobility, scaled to order one; not symmetric where other contacts are eliminated.
    b : list of 3 float
        Free acceleration, scaled to order one.
    mu : float
        Friction coefficient of the scaled problem, > 0.
    """
    yield RestForce(ContactMode.LIFTOFF, [0.0, 0.0, 0.0])
    yield from _sticking(np.array(W), np.array(b), mu)
    yield from _slipping(W, b, mu)


# ---- slip ----


def _slipping(W: list[Vector], b: Vector, mu: float) -> Iterator[RestForce]:
    (nn, w1, w2), (u1, t11, t12), (u2, t21, t22) = W
    b_n, b_1, b_2 = b
    constant = mu * (b_n * (t21 - t12) - (w1 * b_2 - w2 * b_1)) / 2
    first = complex(nn * b_2 - b_n * u2, b_n * u1 - nn * b_1)
    second = (
        mu
        / 2
        * complex(
            b_n * (t12 + t21) - (w1 * b_2 + w2 * b_1), b_n * (t22 - t11) - (w2 * b_2 - w1 * b_1)
        )
    )
    size_b, size_t = math.hypot(b_1, b_2), math.hypot(t11, t12, t21, t22)
    terms = abs(nn) * size_b + abs(b_n) * math.hypot(u1, u2)
    terms += mu * (math.hypot(w1, w2) * size_b + abs(b_n) * size_t)
    everywhere = max(abs(constant), abs(first), abs(second)) <= _VANISHES * terms
    if everywhere:
        angles = [2 * math.pi * k / _SAMPLES for k in range(_SAMPLES)]
    else:
        angles = _zeros(constant, first, second)
    for angle in angles:
        c, s = math.cos(angle), math.sin(angle)
        A = nn - mu * (w1 * c + w2 * s)
        along = u1 - mu * (t11 * c + t12 * s), u2 - mu * (t21 * c + t22 * s)
        h, across = along[1] * c - along[0] * s, b_2 * c - b_1 * s
        k, free = along[0] * c + along[1] * s, b_1 * c + b_2 * s
        small = _VANISHES * (abs(nn) + math.hypot(u1, u2) + mu * (math.hypot(w1, w2) + size_t))
        if max(abs(A), abs(h)) > small:
            normal, isolated = (-b_n / A if abs(A) >= abs(h) else -across / h), not everywhere
        else:  # any force, as far as slip does speed up along e
            isolated = False
            normal = free / -k / 2 if k < 0 else 1.0 + (max(0.0, -2 * free / k) if k else 0.0)
        if normal > 0:
            yield RestForce(
                ContactMode.SLIP, [normal, -mu * normal * c, -mu * normal * s], isolated
            )


def _zeros(constant: float, first: complex, second: complex) -> list[float]:
    """Return the angles of the zeros of ``constant + Re(conj(first) z + conj(second) z²)``.

    z is exp(iφ). Zeros off the unit circle are returned as well, by their angles: it takes no
    tolerance to leave them to the check of the forces.
    """
    largest = max(abs(constant), abs(first), abs(second))
    # A leading coefficient that rounding left of a zero would put two roots far away.
    lead = second if abs(second) > _VANISHES * largest else 0j
    low = first if abs(first) > _VANISHES * largest else 0j
    column = [*(lead.conjugate() / 2, low.conjugate() / 2, complex(constant)), *(low / 2, lead / 2)]
    angles = [cmath.phase(root) for root in np.roots(column) if root]

    def value(angle: float) -> tuple[float, float]:
        z = cmath.rect(1.0, angle)
        one, two = first.conjugate() * z, second.conjugate() * z * z
        return constant + one.real + two.real, -one.imag - 2 * two.imag

    zeros = []
    for angle in angles:
        size, slope = value(angle)
        for _ in range(_POLISH):
            if not slope:
                break
            better = angle - size / slope
            new, slope = value(better)
            if not abs(new) < abs(size):
                break
            angle, size = better, new
        zeros.append(angle)
    return zeros


# ---- sticking ----


def _sticking(W: FloatArray, b: FloatArray, mu: float) -> Iterator[RestForce]:
    """Yield a force with ``W F + b = 0``, within the friction cone where there is a choice."""
    left, stretch, right = np.linalg.svd(W)
    kept = stretch > 3 * RANK * max(float(stretch[0]), 1.0)
    if kept.all():
        yield RestForce(ContactMode.STICK, solve_refined(W, -b).tolist())
        return
    own = right.T[:, kept]
    force = -own @ ((left[:, kept].T @ b) / stretch[kept])
    free = right.T[:, ~kept]
    if free.shape[1] == 1:
        inside = _on_line(force, free[:, 0], mu)
    elif free.shape[1] == 2:
        inside = _on_plane(own[:, 0], float(own[:, 0] @ force), mu)
    else:
        inside = np.array([1.0, 0.0, 0.0])  # nothing moves: any force
    if inside is not None:
        yield RestForce(ContactMode.STICK, inside.tolist(), isolated=False)


def _on_line(start: FloatArray, way: FloatArray, mu: float) -> FloatArray | None:
    """Return a point of ``start + s way`` well inside the cone, or None where the line misses it.

    Between neighbouring ends of the pieces in which the line meets the cone, and beyond the last
    ones, being inside does not change.
    """
    square = np.array([mu * mu, -1.0, -1.0])
    a, half, c = (
        float(np.sum(square * way * way)),
        float(np.sum(square * way * start)),
        float(np.sum(square * start * start)),
    )
    ends = [-start[0] / way[0]] if way[0] else []
    root = half * half - a * c
    if abs(a) > RANK * (mu * mu + 1):
        if root >= 0:
            ends += [(-half + sign * math.sqrt(root)) / a for sign in (-1, 1)]
    elif half:
        ends.append(-c / (2 * half))
    ends.sort()
    reach = 1.0 + max(map(abs, ends), default=0.0) + float(np.max(np.abs(start)))
    points = [(p + q) / 2 for p, q in itertools.pairwise(ends)]
    points += [(ends[0] if ends else 0.0) - reach, (ends[-1] if ends else 0.0) + reach, *ends]
    for s in points:
        force: FloatArray = start + s * way
        if force[0] >= 0 and math.hypot(force[1], force[2]) <= mu * force[0] * (1 + 1e-12):
            return force
    return None


def _on_plane(way: FloatArray, amount: float, mu: float) -> FloatArray | None:
    """Return a force of the cone with ``way · F = amount``, or None."""
    if amount == 0:
        return np.zeros(3)
    if way[0] * amount > 0:
        return np.array([amount / way[0], 0.0, 0.0])
    side = math.copysign(1.0, amount)
    tangent = math.hypot(way[1], way[2])
    reach = side * way[0] + mu * tangent
    if not reach > 0:
        return None
    along = side * way[1:] / tangent
    force: FloatArray = np.concatenate([[1.0], mu * along]) * abs(amount) / reach
    return force
