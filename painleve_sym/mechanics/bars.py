"""Natural modes of uniform bars: bending by Euler and Bernoulli, and along the axis."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mpmath as mp
import sympy as sp

from painleve_sym.errors import InputError

MAX_MODES = 20
"""Of one kind: the theory of slender bars ends long before."""

STATIONS = 21
"""Places along a bar at which its modes are drawn."""

_DIGITS = 60
"""cosh(β) loses as many digits as e^β has: 27 for twenty modes."""

_BENDING_ENDS: Mapping[str, tuple[int, int]] = {"free": (2, 3), "clamped": (0, 1), "pinned": (0, 2)}
"""Orders of the derivatives of the deflection that vanish at an end."""
_AXIAL_ENDS = ("free", "clamped")


@dataclass(frozen=True)
class BarMode:
    """One mode φ(s) of a uniform bar of length 1 and mass 1, with ∫φ² ds = 1.

    It varies as cos βs with β the wavenumber. `ends` are φ(0) and φ(1), of which the first that is
    not 0 is positive; `line` are φ at `STATIONS` equally spaced places from end to end. `momentum`
    is ∫φ ds, `moment` ∫(s − ½) φ ds: angular momentum of bending, stretch of an axial mode.
    """

    wavenumber: sp.Expr
    ends: tuple[sp.Expr, sp.Expr]
    momentum: sp.Expr
    moment: sp.Expr
    line: tuple[sp.Expr, ...]


@dataclass(frozen=True)
class RoundBar:
    """A uniform solid round bar, whose section follows from its mass; kg, m, kg/m³, Pa."""

    mass: sp.Expr
    length: sp.Expr
    density: sp.Expr
    modulus: sp.Expr

    @property
    def radius(self) -> sp.Expr:
        """Radius of the section; m. Its radius of gyration is half of it."""
        return sp.sqrt(self.mass / (sp.pi * self.density * self.length))

    @property
    def rate(self) -> sp.Expr:
        """1 over the time in which sound crosses the length; 1/s."""
        return sp.sqrt(self.modulus / self.density) / self.length

    def axial_frequency(self, wavenumber: sp.Expr) -> sp.Expr:
        """Return ω of a mode along the bar; rad/s."""
        return wavenumber * self.rate

    def bending_frequency(self, wavenumber: sp.Expr) -> sp.Expr:
        """Return ω of a bending mode by Euler and Bernoulli; rad/s."""
        return wavenumber**2 * self.rate * (self.radius / 2) / self.length


@functools.cache
def axial_modes(ends: tuple[str, str], count: int) -> tuple[BarMode, ...]:
    """Return the first modes along a uniform bar, u'' = −β² u, without its rigid motion.

    Their frequencies are β c/L with c² = Y/ρ. The ends, at s = 0 and at s = 1, are ``"free"`` or
    ``"clamped"``; the count is at most `MAX_MODES`.

    Examples
    --------
    >>> from painleve_sym.mechanics.bars import axial_modes
    >>> first = axial_modes(("free", "free"), 1)[0]
    >>> first.wavenumber, first.ends
    (pi, (sqrt(2), -sqrt(2)))
    """
    _check(ends, _AXIAL_ENDS, count)
    s = sp.Symbol("s", real=True)
    shape = sp.cos if ends[0] == "free" else sp.sin
    # A quarter of a wave more where one end is free and the other clamped.
    quarter = sp.Rational(1, 2) if ends[0] != ends[1] else sp.Integer(0)
    modes = []
    for j in range(1, count + 1):
        beta = (j - quarter) * sp.pi
        phi = sp.sqrt(2) * shape(beta * s)
        integrals = [
            sp.simplify(sp.integrate((s - sp.Rational(1, 2)) ** power * phi, (s, 0, 1)))
            for power in (0, 1)
        ]
        values = phi.subs(s, 0), phi.subs(s, 1)
        moving = [v for v in values if v != 0]
        sign = -1 if moving and moving[0] < 0 else 1
        start, end, momentum, moment = (sign * v for v in (*values, *integrals))
        places = (sp.Rational(k, STATIONS - 1) for k in range(STATIONS))
        line = tuple(sign * phi.subs(s, place).evalf(17) for place in places)
        modes.append(BarMode(beta, (start, end), momentum, moment, line))
    return tuple(modes)


@functools.cache
def bending_modes(ends: tuple[str, str], count: int) -> tuple[BarMode, ...]:
    """Return the first bending modes of a uniform bar, w'''' = β⁴ w, without rigid motions.

    Their frequencies are β² κ c/L² with κ the section's radius of gyration and c² = Y/ρ. The
    wavenumbers are the roots of the determinant of the conditions at both ends. The ends, at s = 0
    and at s = 1, are ``"free"``, ``"clamped"`` or ``"pinned"``; the count is at most `MAX_MODES`.

    Examples
    --------
    >>> from painleve_sym.mechanics.bars import bending_modes
    >>> first = bending_modes(("free", "free"), 1)[0]
    >>> first.wavenumber, first.ends
    (4.7300407448627040, (2, 2))

    References
    ----------
    Blevins (1979), table 8-1.
    """
    _check(ends, tuple(_BENDING_ENDS), count)
    with mp.workdps(_DIGITS):
        return tuple(_bending_mode(ends, beta) for beta in _wavenumbers(ends, count))


@functools.cache
def first_bending_wavenumber(ends: tuple[str, str]) -> sp.Expr:
    """Return β of the first bending mode without its shape, whose integrals take longer.

    Parameters
    ----------
    ends : pair of str
        As those of `bending_modes`.
    """
    _check(ends, tuple(_BENDING_ENDS), 1)
    with mp.workdps(_DIGITS):
        (beta,) = _wavenumbers(ends, 1)
        return _rounded(beta)


def _check(ends: tuple[str, str], known: tuple[str, ...], count: int) -> None:
    if not 0 <= count <= MAX_MODES:
        raise InputError(f"number of modes: got {count!r}, need a whole number 0 to {MAX_MODES}.")
    for end in ends:
        if end not in known:
            raise InputError(f"end of a bar: got {end!r}, need one of {', '.join(known)}.")


def _basis(order: int, x: Any) -> list[Any]:
    """Return the derivatives of cosh, sinh, cos, sin at x."""
    hyperbolic = (mp.cosh(x), mp.sinh(x))
    circular = (mp.cos(x), -mp.sin(x), -mp.cos(x), mp.sin(x))
    first, second = order % 2, (order + 1) % 2
    return [hyperbolic[first], hyperbolic[second], circular[order % 4], circular[(order + 3) % 4]]


def _conditions(ends: tuple[str, str], beta: Any) -> list[list[Any]]:
    """Return the rows of the end conditions for the coefficients of the basis."""
    return [
        [value / mp.exp(x) for value in _basis(order, x)]
        for end, x in zip(ends, (mp.mpf(0), beta), strict=True)
        for order in _BENDING_ENDS[end]
    ]


def _wavenumbers(ends: tuple[str, str], count: int) -> list[Any]:
    def determinant(beta: Any) -> Any:
        return mp.det(mp.matrix(_conditions(ends, beta)))

    roots: list[Any] = []
    step, before = mp.mpf("0.25"), mp.mpf(1)
    at_before = determinant(before)
    while len(roots) < count:
        after = before + step
        at_after = determinant(after)
        if at_before * at_after < 0:
            roots.append(mp.findroot(determinant, (before, after), solver="anderson"))
        before, at_before = after, at_after
    return roots


@functools.cache
def _bending_mode(ends: tuple[str, str], beta: Any) -> BarMode:
    rows = _conditions(ends, beta)[:3]
    # What three conditions leave: the cofactors of the fourth.
    weights = [
        (-1) ** k * mp.det(mp.matrix([[v for i, v in enumerate(row) if i != k] for row in rows]))
        for k in range(4)
    ]

    # Three integrals take it at the same places.
    @functools.cache
    def shape(s: Any) -> Any:
        return mp.fsum(w * f for w, f in zip(weights, _basis(0, beta * s), strict=True))

    # Pieces of half a wave each.
    pieces = mp.linspace(0, 1, int(beta / mp.pi) + 3)
    integral = functools.partial(mp.quad, method="gauss-legendre", maxdegree=4)
    values = shape(mp.mpf(0)), shape(mp.mpf(1))
    size = mp.sqrt(integral(lambda s: shape(s) ** 2, pieces))
    moving = [v for v in values if abs(v) > size * mp.mpf("1e-20")]
    size *= mp.sign(moving[0]) if moving else 1
    momentum = integral(shape, pieces) / size
    moment = integral(lambda s: (s - mp.mpf(1) / 2) * shape(s), pieces) / size
    start, end = (_number(v / size) for v in values)
    line = tuple(_rounded(shape(place) / size) for place in mp.linspace(0, 1, STATIONS))
    return BarMode(_rounded(beta), (start, end), _number(momentum), _number(moment), line)


def _number(value: Any) -> sp.Expr:
    """Return the whole number that the value is to 20 digits, or its first 17 digits."""
    whole = mp.nint(value)
    return sp.Integer(int(whole)) if abs(value - whole) < 1e-20 else _rounded(value)


def _rounded(value: Any) -> sp.Expr:
    return sp.Float(str(value), 17)
