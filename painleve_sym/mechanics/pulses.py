"""Pulses and square waves: functions of time that jump at times which are known before a run."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.mechanics.declarations import TIME_NAME, Parameter

if TYPE_CHECKING:
    from painleve_sym.mechanics.mechanism import Mechanism

_HALF = sp.Rational(1, 2)
_TIME = sp.Symbol(TIME_NAME, real=True)


class pulse(sp.Function):  # noqa: N801 - a mathematical function, written as SymPy writes sin
    """1 from a start on, for a width where one is given, else 0; with a period, again and again.

    ``pulse(t, start)``, ``pulse(t, start, width)``, ``pulse(t, start, width, period)``. The first
    argument is the time, plus a constant; the others are formulas of parameters. A periodic pulse
    is so for all times, also before its start. It is continuous from the right, and a run ends
    steps at its edges.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> from painleve_sym.mechanics import TIME, pulse
    >>> push = pulse(TIME, 1, 0.5)
    >>> [push.subs(TIME, t).doit() for t in (0.9, 1, 1.5)]
    [0, 1, 0]
    """

    nargs: Any = (2, 3, 4)
    is_real = True
    is_nonnegative: bool | None = True

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Return the derivative, 0 but at the edges."""
        return sp.Integer(0)

    def _eval_rewrite_as_Piecewise(self, *arguments: sp.Expr, **_hints: Any) -> sp.Expr:
        """Return the same by SymPy's own functions."""
        time, start, *rest = arguments
        since = time - start
        if len(rest) == 2:
            since -= rest[1] * sp.floor(since / rest[1])
        inside = sp.And(since >= 0, *(since < width for width in rest[:1]))
        return sp.Piecewise((1, inside), (0, True))

    def doit(self, **hints: bool) -> sp.Expr:
        """Return 0 or 1 where all arguments are numbers."""
        whole = self.func(*(a.doit(**hints) for a in self.args))
        return whole if whole.free_symbols else whole.rewrite(sp.Piecewise)

    def _printed(self, printer: Any, *_arguments: Any) -> Any:
        """Return how a printer of code writes the cases."""
        return printer._print(self.rewrite(sp.Piecewise))

    _pythoncode = _lambdacode = _numpycode = _jaxcode = _mpmathcode = _printed
    _ccode = _fcode = _javascript = _julia = _octave = _rcode = _rust_code = _printed
    _cxxcode = _glsl = _mcode = _maple = _printed


class cycles(pulse):  # noqa: N801 - a mathematical function, written as SymPy writes sin
    """Number of whole periods since a start: ``cycles(t, start, period)``, such as 2 or −1.

    Examples
    --------
    >>> from painleve_sym.mechanics.pulses import cycles
    >>> from painleve_sym.mechanics import TIME
    >>> [cycles(TIME, 1, 2).subs(TIME, t).doit() for t in (0, 1, 4)]
    [-1, 0, 1]
    """

    nargs = (3,)
    is_nonnegative = None

    def _eval_rewrite_as_Piecewise(self, *arguments: sp.Expr, **_hints: Any) -> sp.Expr:
        """Return the same by SymPy's own function."""
        time, start, period = arguments
        return sp.floor((time - start) / period)


def triangle(time: Any, period: Any, duty: Any = _HALF, delay: Any = 0) -> sp.Expr:
    """Return a triangle wave: from −1 to 1 in the part `duty` of each period, and back.

    Periods are counted from `delay`. Its rate jumps at the edges of its pulses. It is SciPy's
    ``signal.sawtooth``, with the time in s for the phase.

    Parameters
    ----------
    time : sympy.Expr
        `TIME`, plus a constant.
    period, delay : sympy.Expr
        s; formulas of parameters.
    duty : sympy.Expr
        In (0, 1).

    Examples
    --------
    >>> from painleve_sym.mechanics import TIME, triangle
    >>> wave = triangle(TIME, 4)
    >>> [wave.subs(TIME, t).doit() for t in (0, 1, 2, 3, 4)]
    [-1, 0, 1, 0, -1]
    """
    period, duty = sp.sympify(period), sp.sympify(duty)
    rises = pulse(time, delay, duty * period, period)
    part = (time - delay) / period - cycles(time, delay, period)
    return rises * (2 * part / duty - 1) + (1 - rises) * (1 - 2 * (part - duty) / (1 - duty))


def square(time: Any, period: Any, duty: Any = _HALF, delay: Any = 0) -> sp.Expr:
    """Return a square wave: 1 for the part `duty` of each period from `delay` on, then −1.

    Parameters
    ----------
    time : sympy.Expr
        `TIME`, plus a constant.
    period, delay : sympy.Expr
        s; formulas of parameters.
    duty : sympy.Expr
        In [0, 1].

    Examples
    --------
    >>> from painleve_sym.mechanics import TIME, square
    >>> wave = square(TIME, 2)
    >>> [wave.subs(TIME, t).doit() for t in (0, 1, 2, 3)]
    [1, -1, 1, -1]
    """
    return 2 * pulse(time, delay, sp.sympify(duty) * sp.sympify(period), period) - 1


def pulse_faults(formula: sp.Expr, constants: set[sp.Symbol]) -> Iterator[str]:
    """Yield a sentence for each pulse whose edges are not at known times."""
    for own in sorted(formula.atoms(pulse), key=str):
        time, *rest = own.args
        shift = time - _TIME
        other = set().union(shift.free_symbols, *(a.free_symbols for a in rest)) - constants
        if _TIME in shift.free_symbols:
            yield f"{own}: got {time} as its time. Fix: write t, plus a constant."
        elif other:
            names = ", ".join(sorted(map(str, other)))
            yield f"{own}: got {names} in its arguments, need t, then formulas of parameters alone."


@dataclass(frozen=True)
class Edges:
    """Start, width and period of a pulse as numbers, at times of `TIME`; None for what it lacks.

    One that `counts` has the number of periods as its value.
    """

    start: float
    width: float | None = None
    period: float | None = None
    counts: bool = False

    def value(self, time: float) -> float:
        """Return 0 or 1, or how many periods are over, at a time between edges."""
        since = time - self.start
        if self.counts and self.period is not None:
            return float(math.floor(since / self.period))
        if self.period is not None:
            since -= self.period * math.floor(since / self.period)
        return float(since >= 0 and (self.width is None or since < self.width))

    def after(self, time: float) -> float:
        """Return the next edge after a time, further away than rounding; inf where none is."""
        offsets = [0.0] if self.width is None else [0.0, self.width]
        if self.period is None:
            edges = [self.start + d for d in offsets]
        else:
            first = math.floor((time - self.start) / self.period) - 1
            widths = [d for d in offsets if 0 <= d < self.period]
            edges = [
                self.start + k * self.period + d for k in range(first, first + 4) for d in widths
            ]
        least = time + 8e-16 * max(abs(time), abs(self.start), self.period or 0.0)
        return min((e for e in edges if e > least), default=math.inf)


def without_pulses(mechanism: Mechanism) -> tuple[Mechanism, dict[str, pulse]]:
    """Return a mechanism with a parameter in place of each pulse, and the pulses by its name."""
    system, contacts = mechanism.system, mechanism.contacts
    formulas = [system.kinetic_energy, system.potential_energy, *system.generalized_forces.values()]
    formulas += [f for c in contacts for f in (c.gap, *c.slip_velocities)]
    formulas += [b.margin for b in mechanism.domain]
    atoms = set().union(*(sp.sympify(f).atoms(pulse) for f in formulas))
    known = {str(s) for s in system.symbols}
    free = (n for n in (f"pulse_{k}" for k in range(1, len(known) + len(atoms) + 1)))
    names = [n for n in free if n not in known]
    pulses = dict(zip(names, sorted(atoms, key=sp.default_sort_key), strict=False))
    hidden = [Parameter(n, 0.0, "1", f"value of {own}") for n, own in pulses.items()]
    table = {own: p.symbol for p, own in zip(hidden, pulses.values(), strict=True)}

    def held(formula: Any) -> Any:
        return None if formula is None else sp.sympify(formula).xreplace(table)

    stepped = replace(
        system,
        parameters=(*system.parameters, *hidden),
        kinetic_energy=held(system.kinetic_energy),
        potential_energy=held(system.potential_energy),
        generalized_forces={n: held(f) for n, f in system.generalized_forces.items()},
    )
    return replace(
        mechanism,
        system=stepped,
        contacts=tuple(
            replace(
                c,
                system=stepped,
                gap=held(c.gap),
                slip_velocity=held(c.slip_velocity),
                slip_across=held(c.slip_across),
            )
            for c in contacts
        ),
        domain=tuple(replace(b, margin=held(b.margin)) for b in mechanism.domain),
        start={n: v for n, v in mechanism.start.items() if n != TIME_NAME},
    ), pulses


def edges_of(where: str, own: pulse, values: Mapping[str, float]) -> Edges:
    """Return the edges of a pulse with numbers of the parameters.

    InputError, with `where` in front, where the width is negative or the period is not positive.
    """
    names = sorted({str(s) for a in own.args for s in a.free_symbols - {_TIME}})
    return _edges(where, own, tuple((name, values[name]) for name in names))


@lru_cache(maxsize=256)
def _edges(where: str, own: pulse, values: tuple[tuple[str, float], ...]) -> Edges:
    time, start, *rest = own.args
    numbers = dict(values)
    table = {s: sp.Float(numbers[str(s)], 17) for s in own.free_symbols - {_TIME}}
    every = [a.xreplace(table).evalf(17) for a in (start - (time - _TIME), *rest)]
    if not all(a.is_Float or a.is_Rational for a in every):
        raise InputError(f"{where}: {own}: got arguments {every}, need finite real numbers.")
    begin, *more = map(float, every)
    counts = isinstance(own, cycles)
    width, period = ([None, *more] if counts else [*more, None, None])[:2]
    edges = Edges(begin, width, period, counts)
    if edges.width is not None and edges.width < 0:
        raise InputError(f"{where}: {own}: got the width {edges.width:g} s, need >= 0.")
    if edges.period is not None and not edges.period > 0:
        raise InputError(f"{where}: {own}: got the period {edges.period:g} s, need > 0.")
    return edges
