"""Force–compression curves: branches, their exits, and what several laws share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from painleve_sym.equality import Compared
from painleve_sym.errors import EventKind
from painleve_sym.mechanics.declarations import Parameter

DELTA = sp.Symbol("delta", real=True)
"""Compression δ = −g_N; m."""
DELTA_DOT = sp.Symbol("delta_dot", real=True)
"""Rate of compression; m/s."""
DELTA_MAX = sp.Symbol("delta_max", real=True)
"""Memory: compression at which unloading began; m."""

SEPARATED = ""
"""Target of an exit that ends the contact."""


class ramp(sp.Function):  # noqa: N801 - a mathematical function, written as SymPy writes sin
    """max(x, 0): the base of a real power that must stay defined when round-off makes x < 0."""

    nargs = (1,)

    @classmethod
    def eval(cls, x: sp.Expr) -> sp.Expr | None:
        """Return x itself where it is known not to be negative."""
        if x.is_nonnegative:
            return x
        return None

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Return the derivative, 1 where the argument is positive (the side that is used)."""
        return sp.Heaviside(self.args[0], 0)

    def _eval_rewrite_as_Max(self, x: sp.Expr, **_hints: Any) -> sp.Expr:
        """Return the same by SymPy's own function."""
        return sp.Max(x, 0)

    def _printed(self, printer: Any, *_arguments: Any) -> Any:
        """Return how a printer of code writes the greatest of two numbers."""
        return printer._print(sp.Max(self.args[0], 0))

    _pythoncode = _lambdacode = _numpycode = _jaxcode = _mpmathcode = _printed
    _ccode = _fcode = _javascript = _julia = _octave = _rcode = _rust_code = _printed
    _cxxcode = _glsl = _mcode = _maple = _printed


def without_ramps(expr: sp.Expr) -> sp.Expr:
    """Return the expression inside the contact, where every ramp equals its argument."""
    return expr.replace(lambda e: isinstance(e, ramp), lambda e: e.args[0])


@dataclass(frozen=True, eq=False)
class Exit(Compared):
    """End of a branch, where `guard` crosses from + to −; the event is of the law's kinds.

    The guard is in δ, δ̇, memory and parameters; the target is the next branch, or SEPARATED. New
    values of the memory are in δ and the old one; what is absent is kept.

    Examples
    --------
    >>> from painleve_sym import EventKind, Exit
    >>> from painleve_sym.laws.compliance import DELTA, SEPARATED
    >>> Exit(EventKind.SEPARATION, DELTA, SEPARATED).guard
    delta
    """

    kind: EventKind
    guard: sp.Expr
    target: str
    memory: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)


@dataclass(frozen=True)
class Branch:
    """One curve F_n(δ, δ̇) with its energies; F_n δ̇ = d(stored)/dt + dissipated power.

    The force is ≥ 0, N. The stored energy is what this contact can still give back, J; the
    dissipated power is lost for good, W.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> [branch.name for branch in ps.laws.hertz().branches]
    ['compression', 'restitution']
    >>> ps.laws.linear().branches[0].stored_energy
    K_e*delta**2/2
    """

    name: str
    force: sp.Expr
    stored_energy: sp.Expr
    dissipated_power: sp.Expr
    exits: tuple[Exit, ...]


def stiffness(body: Sequence[Parameter], n: Parameter, l_0: Parameter) -> sp.Expr:
    """Return K_e = (4/3) E* √R* l_0^(3/2−n) of the parameters of one body, or of two; N/mⁿ.

    One body: both of the same material, the second one flat. 1/E* = Σ (1 − ν_i²)/E_i and
    1/R* = Σ 1/R_i (the paper sums four principal curvatures, which would halve R*). Without the
    reference length, as in the paper, the unit would be N/m^(3/2) whatever n.
    """
    return hertz_stiffness(body) * l_0.symbol ** (sp.Rational(3, 2) - n.symbol)


def hertz_stiffness(body: Sequence[Parameter]) -> sp.Expr:
    """Return (4/3) E* √R* of the parameters of one body, or of two; N/m^(3/2)."""
    symbols = [p.symbol for p in body]
    if len(symbols) == 3:
        E, nu, R = symbols
        e_star = E / (2 * (1 - nu**2))
        return sp.Rational(4, 3) * e_star * sp.sqrt(R)
    compliance, curvature = sp.Integer(0), sp.Integer(0)
    for E, nu, k in (symbols[:3], symbols[3:]):
        compliance += (1 - nu**2) / E
        curvature += k
    return sp.Rational(4, 3) / compliance / sp.sqrt(curvature)


K_E = sp.Symbol("K_e", positive=True)
"""Stiffness of the loading curve K_e δⁿ; N/mⁿ."""
