"""The path of an impact of one contact in space: slip that turns, stops, sticks or begins again.

The configuration is frozen. With the slip v e, e = (cos φ, sin φ), friction −μ e and the mobility
W = [[W_nn, wᵀ], [w, W_tt]], the velocities change with the normal impulse P as

    dv_t/dP = w − μ W_tt e,    dv_n/dP = A(φ) = W_nn − μ w·e.

The direction e has no limit speed of turning where v → 0; in the blown-up time τ with dτ = dP/v,

    d ln v/dτ = k(φ) = e·(w − μ W_tt e),    dφ/dτ = h(φ) = e⊥·(w − μ W_tt e),    dP/dτ = v,

nothing is singular, and slip that stops does so as τ → ∞, along an *invariant direction*: h = 0
and k < 0. There (μ W_tt + k) e = w, so that |(μ W_tt + k)⁻¹ w| = 1. For k ≥ 0 this size falls with
k from |W_tt⁻¹ w|/μ to 0: where it begins at most at 1 the contact sticks, with dP_t/dP = −W_tt⁻¹ w,
and no slip can grow; else slip grows along one direction, and begins again there. In the principal
axes of W_tt with the mobilities λ₁ ≤ λ₂ and with w₁, w₂ ≥ 0 (turn the axes),

    h = w₂ cos φ − w₁ sin φ − μ (λ₂ − λ₁) sin φ cos φ

has one zero from 0 to π/2, one from π to 3π/2, and two from π/2 to π where w lies in the astroid
w₁^⅔ + w₂^⅔ < (μ (λ₂ − λ₁))^⅔: all are bracketed, and the first is that with the largest k. Since
h′ = −k − μ e⊥·W_tt e⊥ where h = 0, that first one attracts, and the one beyond π repels.

The path is followed by power series in τ. Near the invariant direction ahead, with h′ < 0, by a
series in y = exp(h′ τ): then P, v_n and the works are sums of exp((k + j h′) τ), whose limits as
τ → ∞ are exact where k < 0. Between the zeros of A the velocity v_n is monotonic, and a compression
or a restitution ends at a zero of v_n, of the impulse or of the work along the series. Where slip
turns so that A < 0 in restitution, v_n can fall to 0 while there is restitution left: the contact
is then compressed again, and what that takes adds to what restitution has to give.

Where W is of rank two with a regular W_tt, W_nn = w·a with a = W_tt⁻¹ w, and c = v_n − a·v_t never
changes. Then v_n is taken from v_t, which keeps its digits where both vanish together (c = 0), and
sticking has the rate 0. Where no impulse moves the contact along t2, the slip of a driven surface
along it stays, and W_nn = w₁²/W₁₁ ties v_n and v_1.

``spatial.c`` follows the path, and needs a C compiler once: there is no second, slower path, whose
digits would differ.

References
----------
Keller (1986); Bhatt & Koechling (1995); Batlle (1996); Jia & Wang (2017); Stronge (1990).
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from functools import cache
from importlib import resources
from typing import NamedTuple

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.compile import load
from painleve_sym.errors import CompilerMissing, InputError
from painleve_sym.laws.restitution import Measure
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.problem.impact.path import (
    AFTER_STOP,
    ImpactPhase,
    binary_exponent,
)
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.rounding import SUM

# The names and numbers of ``spatial.c``.
PHASES, PIECES, HEAD, ROW = 16, 20000, 2, 11
MEASURES = tuple(Measure)
NO_IMPACT, ENDED, JAM, UNFINISHED = range(4)
SLIP, STOPS, STICK, RESUMED = range(4)
_PARTS, _RAY_NAMES = ("compression", "restitution"), ("slip", "", "sticking", "reverse slip")
_PART_NAMES = ("tangential", "slip restitution")


def course_in_space(
    W: Sequence[Sequence[float]],
    mu: float,
    velocity: Sequence[float],
    measure: Measure,
    share: float,
) -> tuple[ImpactClass, bool, tuple[ImpactPhase, ...]]:
    """Return the class of an impact, whether it has an end, and its phases.

    The first arguments are those of `solve_impact`, checked, with a W of shape (3, 3); a share of
    the measure of compression comes back.
    """
    (nn, n1, n2), (_, one, m), (_, _, two) = W
    # Powers of two leave every digit, and keep squares of the velocities in range.
    mass, speed = binary_exponent(nn, one, two), binary_exponent(*velocity)
    mobility = (math.ldexp(w, -mass) for w in (nn, n1, n2, one, m, two))
    v = (math.ldexp(own, -speed) for own in velocity)
    given = np.array([(*mobility, mu, *v, MEASURES.index(measure), share)])
    try:
        result = impacts_in_space(given)[0]
    except CompilerMissing as error:
        need = "impacts in space are computed by compiled code"
        raise CompilerMissing(f"solve impact: {need}: {error}") from error
    end, count = int(result[0]), int(result[1])
    if end == NO_IMPACT:
        return ImpactClass.NO_IMPACT, True, ()
    if end == UNFINISHED:
        raise InputError(
            f"solve impact: got a path of more than {PHASES} phases or {PIECES} pieces, need "
            f"fewer, from W = {W!r}, mu = {mu!r} and velocity = {tuple(velocity)!r}. "
            "Fix: change their last digits."
        )
    units = [speed - mass] * 3 + [speed] * 3 + [2 * speed - mass] * 2
    rows = result[HEAD : HEAD + ROW * count].reshape(count, ROW).tolist()
    phases, rays = [], [int(row[0]) // 2 for row in rows]
    # Without slip only a contact that sticks jams before its first phase ends.
    sticks = rays[:1] == [STICK] or not (rays or any(velocity[1:]))
    case = ImpactClass.C_STICKING if sticks else ImpactClass.SLIDING
    for i, (ray, (kind, *row)) in enumerate(zip(rays, rows, strict=True)):
        part = int(kind) % 2
        P_n, P_1, P_2, *v_after, work_n, work_t = (
            math.ldexp(number, unit) + 0.0 for number, unit in zip(row, units, strict=False)
        )
        name = _PART_NAMES[part] if ray == STOPS else f"{_RAY_NAMES[ray]} {_PARTS[part]}"
        mode = ContactMode.STICK if ray == STICK else ContactMode.SLIP
        # Exactly 0 where it is rounding, so that the angle of a slip along −t1 is π and not −π.
        c, s = (part if abs(part) > SUM else 0.0 for part in row[-2:])
        phases.append(
            ImpactPhase(name, mode, P_n, (P_1, P_2), tuple(v_after), work_n, work_t, (c, s))
        )
        if ray == STOPS:
            case = AFTER_STOP[_PARTS[part], rays[i + 1 :][:1] != [RESUMED]]
    return case, end == ENDED, tuple(phases)


def impacts_in_space(given: Array) -> Array:
    """Return the results of ``spatial.c`` for impacts, an array of shape (n, 2 + 11 · 16).

    Parameters
    ----------
    given : ndarray, shape (n, 12)
        W_nn, W_n1, W_n2, W_11, W_12, W_22, mu, v_n, v_1, v_2, place of the measure in `MEASURES`,
        share. All of order 1, as `course_in_space` scales them.

    Raises
    ------
    CompilerMissing
        Where nothing compiles C.
    """
    given = np.ascontiguousarray(given, dtype=float)
    results = np.zeros((len(given), HEAD + ROW * PHASES))
    _compiled()(len(given), given.ctypes.data, results.ctypes.data)
    return results


@cache
def _compiled() -> Callable[[int, int, int], None]:
    source = resources.files("painleve_sym.problem.impact").joinpath("spatial.c")
    function = load(source.read_text("utf-8")).ps_impacts_in_space
    function.argtypes, function.restype = [ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p], None
    return function


class InvariantDirection(NamedTuple):
    """A direction in which slip does not turn in an impact.

    Attributes
    ----------
    angle : float
        φ of the direction (cos φ, sin φ) in (t1, t2); rad.
    growth : float
        k, the rate d|v_t|/dP_n along it: where it is negative slip stops, where it is positive slip
        begins; 1/kg.
    turning : float
        dh/dφ: where it is negative slip turns towards it; 1/kg.

    Examples
    --------
    >>> from painleve_sym.problem import invariant_directions
    >>> W = [[2.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    >>> begins, stops = invariant_directions(W, 0.5)
    >>> begins.growth, stops.growth
    (0.5, -1.5)
    """

    angle: float
    growth: float
    turning: float


def invariant_ones(
    w: tuple[float, float], W_tt: tuple[float, float, float], mu: float
) -> tuple[InvariantDirection, ...]:
    """Return all invariant directions with their rates; arguments as of `invariant_angles`."""
    (w1, w2), (W11, W12, W22), every = w, W_tt, []
    for angle in invariant_angles(w, W_tt, mu):
        c, s = math.cos(angle), math.sin(angle)
        f1, f2 = w1 - mu * (W11 * c + W12 * s), w2 - mu * (W12 * c + W22 * s)
        growth = c * f1 + s * f2
        across = W11 * s * s - 2 * W12 * s * c + W22 * c * c
        every.append(InvariantDirection(angle, growth, -growth - mu * across))
    return tuple(every)


def invariant_angles(
    w: tuple[float, float], W_tt: tuple[float, float, float], mu: float
) -> tuple[float, ...]:
    """Return all invariant directions of slip as angles, that with the largest k first; rad.

    Two or four, none where every direction is invariant (w = 0 and W_11 = W_22, W_12 = 0). `w` is
    (W_n1, W_n2), and `W_tt` are W_11, W_12, W_22.
    """
    (w1, w2), (W11, W12, W22) = w, W_tt
    half, d = math.pi / 2, (W11 - W22) / 2
    r = math.hypot(d, W12)
    axis, D = (math.atan2(W12, d) / 2 + half if r > 0.0 else 0.0), 2 * mu * r
    a = w1 * math.cos(axis) + w2 * math.sin(axis)
    b = w2 * math.cos(axis) - w1 * math.sin(axis)
    one, two = abs(a), abs(b)
    if one == two == D == 0.0:
        return ()

    def h(x: float) -> tuple[float, float]:
        c, s = math.cos(x), math.sin(x)
        return two * c - one * s - D * s * c, -two * s - one * c - D * (c * c - s * s)

    def minus(x: float) -> tuple[float, float]:
        return -h(x)[0], -h(x)[1]

    zeros = [zero_between(h, 0.0, half, 1e-16), zero_between(minus, math.pi, 3 * half, 1e-16)]
    roots = math.cbrt(one), math.cbrt(two)
    if math.hypot(*roots) ** 3 < D:
        top = math.pi - math.atan2(roots[1], roots[0])
        zeros += [zero_between(minus, half, top, 1e-16), zero_between(h, top, math.pi, 1e-16)]
    signs = math.copysign(1.0, a), math.copysign(1.0, b)
    return tuple(axis + math.atan2(signs[1] * math.sin(x), signs[0] * math.cos(x)) for x in zeros)


def zero_between(
    f: Callable[[float], tuple[float, float]], a: float, b: float, tolerance: float
) -> float:
    """Return where f changes sign between a, where it is positive, and b; f has its derivative."""
    x = (a + b) / 2
    for _ in range(200):
        value, slope = f(x)
        if value == 0.0:
            return x
        a, b = (x, b) if value > 0.0 else (a, x)
        after = x - value / slope if slope else math.nan
        if not min(a, b) < after < max(a, b):
            after = (a + b) / 2
        if abs(after - x) <= tolerance * abs(x) or after in (a, b):
            return after
        x = after
    return x
