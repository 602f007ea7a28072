"""Directions in which one disc of friction begins to slip.

Rows and forces are ordered n, t1, t2, and e is the direction (cos φ, sin φ) in which slip begins::

    W = [[W_nn, w'], [u, T]],    F = F_n (1, -μ e),    a_n = 0,    a_t = λ e with λ >= 0

give two equations for F_n, with e⊥ the direction a right angle ahead of e:

    A F_n + b_n = 0,         A(φ) = W_nn - μ w·e
    h F_n + b_t·e⊥ = 0,      h(φ) = e⊥·(u - μ T e)

A mobility is symmetric, u = w; the W of one disc alone is not where the forces of others follow
from its own.

Both hold where G(φ) = A (b_t·e⊥) - b_n h vanishes. G is a trigonometric polynomial of degree 2, so
its zeros are those roots of a polynomial of degree 4 in exp(iφ) that lie on the unit circle. For a
positive definite W the number of solutions, with lift-off and stick, is 1 or 3 unless a border is
met; the proof is in ``docs/paradox-in-space.md``.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from painleve_sym.problem.complementarity.solution_sets import FloatArray
from painleve_sym.problem.constraints import Vector

_VANISHES = 1e-14  # of the terms of a function of φ: about 50 roundings
_SAMPLES = 16  # directions tried where G vanishes in all
BESIDE = 1e-3
"""Angle between a direction and its neighbour in a continuum; rad."""
_POLISH = 6  # Newton steps: the roots of the quartic are near
_MULTIPLE = 256 * 2.0**-52  # of the coefficients: a derivative that vanishes in a multiple root
_NEAR = 0.05  # a multiple root of the quartic is within this of what rounding makes of it, rad


class Slip(NamedTuple):
    """A direction in which slip may begin.

    Attributes
    ----------
    angle : float
        φ, in rad.
    normal : float or None
        F_n, None where both equations leave it open.
    everywhere : bool
        Whether G vanishes for all directions, of which this is a sample.
    """

    angle: float
    normal: float | None
    everywhere: bool = False


class Wave(NamedTuple):
    """``constant + Re(first z + second z²)`` with z = exp(iφ)."""

    constant: float
    first: complex
    second: complex

    @property
    def size(self) -> float:
        """The largest coefficient."""
        return max(abs(self.constant), abs(self.first), abs(self.second))

    def slope(self) -> Wave:
        """Return the derivative by φ."""
        return Wave(0.0, 1j * self.first, 2j * self.second)

    def value(self, angle: float) -> float:
        """Return the function at an angle."""
        z = cmath.rect(1.0, angle)
        constant, first, second = self
        return constant + (first * z).real + (second * z * z).real

    def zeros(self) -> Vector:
        """Return the angles of the zeros."""
        # A leading coefficient that rounding left of a zero would put two roots far away.
        least = _VANISHES * self.size
        lead = self.second if abs(self.second) > least else 0j
        low = self.first if abs(self.first) > least else 0j
        column = [lead / 2, low / 2, complex(self.constant)]
        column += [low.conjugate() / 2, lead.conjugate() / 2]
        waves = [self]
        for _ in range(3):
            waves.append(waves[-1].slope())
        on_circle = [root for root in _roots(column) if abs(abs(root) - 1.0) < _NEAR]
        return [_polished(waves, cmath.phase(root)) for root in on_circle]


def _roots(column: list[complex]) -> list[complex]:
    """Return the roots of a polynomial, highest power first, but for those at 0."""
    while column and not column[0]:
        column = column[1:]
    while column and not column[-1]:
        column = column[:-1]
    if len(column) < 2:
        return []
    companion = np.zeros((len(column) - 1, len(column) - 1), dtype=complex)
    companion.ravel()[len(column) - 1 :: len(column)] = 1.0
    companion[0] = -np.array(column[1:]) / column[0]
    roots: list[complex] = np.linalg.eigvals(companion).tolist()
    return roots


def _polished(waves: Sequence[Wave], angle: float) -> float:
    """Return the zero of a function near an angle: that of a derivative where it is a multiple one.

    With the function, its derivatives.
    """
    size = waves[0].size
    best = _newton(waves[0], waves[1], angle)
    for order in (1, 2):
        near = _newton(waves[order], waves[order + 1], angle)
        if abs(near - angle) > _NEAR:
            break
        if all(abs(lower.value(near)) <= _MULTIPLE * size for lower in waves[:order]):
            best = near
    return best


def _newton(wave: Wave, slopes: Wave, angle: float) -> float:
    """Return the zero that Newton's steps reach from an angle while they come nearer."""
    size, slope = wave.value(angle), slopes.value(angle)
    for _ in range(_POLISH):
        if not slope:
            break
        better = angle - size / slope
        new = wave.value(better)
        if not abs(new) < abs(size):
            break
        angle, size, slope = better, new, slopes.value(better)
    return angle


def wave_of(function: Callable[[float], float]) -> Wave:
    """Return a trigonometric polynomial of degree 2 by five of its values."""
    angles = [2 * math.pi * k / 5 for k in range(5)]
    values = [function(angle) for angle in angles]

    def part(order: int) -> complex:
        turns = (cmath.rect(v, -order * angle) for v, angle in zip(values, angles, strict=True))
        return 2 * sum(turns, 0j) / 5

    return Wave(sum(values) / 5, part(1), part(2))


def _defect(W: Any, b: Any, mu: float) -> tuple[Any, Any, Any]:
    """Return the coefficients of G as those of a `Wave`; of one problem, or arrays of many."""
    (nn, w1, w2), (u1, t11, t12), (u2, t21, t22) = W
    b_n, b_1, b_2 = b
    real = b_n * (t12 + t21) - (w1 * b_2 + w2 * b_1)
    imaginary = b_n * (t22 - t11) - (w2 * b_2 - w1 * b_1)
    return (
        mu * (b_n * (t21 - t12) - (w1 * b_2 - w2 * b_1)) / 2,
        (nn * b_2 - b_n * u2) - 1j * (b_n * u1 - nn * b_1),
        (real - 1j * imaginary) * (mu / 2),
    )


def slips(W: Sequence[Vector], b: Vector, mu: float) -> list[Slip]:
    """Return the directions in which slip may begin, with the normal force of each.

    Parameters
    ----------
    W : list of 3 rows
        Mobility, scaled to order one.
    b : list of 3 float
        Free acceleration, scaled to order one.
    mu : float
        Friction coefficient of the scaled problem, > 0.
    """
    (nn, w1, w2), (u1, t11, t12), (u2, t21, t22) = W
    b_n, b_1, b_2 = b
    G = Wave(*_defect(W, b, mu))
    h = Wave(mu * (t12 - t21) / 2, complex(u2, u1), complex(-(t12 + t21), t22 - t11) * (mu / 2))
    A_wave = Wave(nn, complex(-mu * w1, mu * w2), 0j)
    size_b, size_t, size_w = (
        math.hypot(b_1, b_2),
        math.hypot(t11, t12, t21, t22),
        math.hypot(w1, w2),
    )
    of_h, of_A = math.hypot(u1, u2) + mu * size_t, abs(nn) + mu * size_w
    terms = of_A * size_b + abs(b_n) * of_h
    everywhere = G.size <= _VANISHES * terms
    if everywhere:
        angles = [2 * math.pi * k / _SAMPLES for k in range(_SAMPLES)]
        angles += [math.atan2(b_2, b_1), math.atan2(-b_2, -b_1)] if size_b else []
        angles += h.zeros() if h.size > _VANISHES * of_h else []
        angles += A_wave.zeros() if A_wave.size > _VANISHES * of_A else []
        # A neighbour of each: two of them make a continuum.
        angles += [angle + side * BESIDE for angle in angles for side in (-1, 1)]
    else:
        angles = G.zeros()
    begun = list[Slip]()
    for angle in angles:
        c, s = math.cos(angle), math.sin(angle)
        A = nn - mu * (w1 * c + w2 * s)
        across = b_2 * c - b_1 * s
        turned = h.value(angle)
        normal: float | None
        if abs(A) <= _VANISHES * of_A and abs(turned) <= _VANISHES * of_h:
            normal = None
        elif abs(A) * size_b >= abs(across) * of_A and abs(A) > _VANISHES * of_A:
            normal = -b_n / A
        elif abs(turned) > _VANISHES * of_h:
            normal = -across / turned
        else:
            normal = -b_n / A
        if normal is not None and not everywhere:
            angle, normal = _refined(A_wave, h, b, angle, normal)
        begun.append(Slip(angle, normal, everywhere))
    return begun


def _refined(A: Wave, h: Wave, b: Vector, angle: float, normal: float) -> tuple[float, float]:
    """Return the direction and F_n after a Newton step of both equations, where that is better.

    A quotient of small numbers leaves more of an equation than its rounding.
    """
    b_n, b_1, b_2 = b
    slope_A, slope_h = A.slope(), h.slope()

    def missed(phi: float, F: float) -> tuple[float, float]:
        c, s = math.cos(phi), math.sin(phi)
        return A.value(phi) * F + b_n, h.value(phi) * F + b_2 * c - b_1 * s

    for _ in range(2):
        first, second = missed(angle, normal)
        c, s = math.cos(angle), math.sin(angle)
        a, p = A.value(angle), normal * slope_A.value(angle)
        k, q = h.value(angle), normal * slope_h.value(angle) - b_2 * s - b_1 * c
        determinant = a * q - p * k
        if not determinant:
            break
        phi = angle - (a * second - k * first) / determinant
        F = normal - (q * first - p * second) / determinant
        new = missed(phi, F)
        if not max(map(abs, new)) < max(abs(first), abs(second)):
            break
        angle, normal = phi, F
    return angle, normal


def quartic_angles(W: FloatArray, b: FloatArray, mu: float) -> FloatArray:
    """Return the angles of all zeros of G for many problems, shapes (s, 3, 3) and (s, 3) to (s, 4).

    Those off the unit circle are returned by their angles as well.
    """
    constant, first, second = _defect(np.moveaxis(W, 0, -1), b.T, mu)
    lead = second / 2
    size = np.maximum(np.abs(constant), np.abs(first)) + np.abs(lead)
    lead = np.where(
        np.abs(lead) <= _VANISHES * size, _VANISHES * np.where(size > 0, size, 1.0), lead
    )
    companion = np.zeros((len(W), 4, 4), dtype=complex)
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    column = np.stack([lead.conj(), first.conj() / 2, constant + 0j, first / 2], axis=1)
    companion[:, :, 3] = -column / lead[:, None]
    angles: FloatArray = np.angle(np.linalg.eigvals(companion))
    return angles
