"""Force–compression laws of a compliant contact, branch by branch."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from painleve_sym.errors import EventKind
from painleve_sym.laws.contact_law import ContactLaw
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


def without_ramps(expr: sp.Expr) -> sp.Expr:
    """Return the expression inside the contact, where every ramp equals its argument."""
    return expr.replace(lambda e: isinstance(e, ramp), lambda e: e.args[0])


@dataclass(frozen=True)
class Exit:
    """End of a branch, where `guard` crosses from + to −; the event is of the law's kinds.

    The guard is in δ, δ̇, memory and parameters; the target is the next branch, or SEPARATED. New
    values of the memory are in δ and the old one; what is absent is kept.
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
    """

    name: str
    force: sp.Expr
    stored_energy: sp.Expr
    dissipated_power: sp.Expr
    exits: tuple[Exit, ...]


def _stiffness(body: Sequence[Parameter], n: Parameter, l_0: Parameter) -> sp.Expr:
    """K_e = (4/3) E* √R* l_0^(3/2−n) of the parameters of one body, or of two; N/mⁿ.

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
_E2 = sp.Symbol("e_squared", positive=True)


def _bilinear_hertz(known: Mapping[str, Any]) -> ContactLaw:
    *body, n, l_0, e = known["parameters"]
    reload, N = known["choices"]["reload"], n.symbol
    delta_p = DELTA_MAX * (1 - e.symbol**2)
    virgin = K_E * ramp(DELTA) ** N
    # Its sign is not known, and SymPy would search for it long.
    recovered = ramp((DELTA - delta_p) / _E2, evaluate=False)
    unloading = K_E * recovered**N
    work = K_E * ramp(DELTA) ** (N + 1) / (N + 1)
    elastic_energy = _E2 * K_E * recovered ** (N + 1) / (N + 1)
    turn = {"elastic": "reload", "virgin": "compression"}[reload]
    compression = Branch(
        "compression",
        virgin,
        e.symbol**2 * work,
        (1 - e.symbol**2) * virgin * DELTA_DOT,
        (Exit(EventKind.MAX_COMPRESSION, DELTA_DOT, "restitution", {DELTA_MAX: DELTA}),),
    )
    restitution = Branch(
        "restitution",
        unloading,
        elastic_energy,
        sp.Integer(0),
        (
            Exit(EventKind.SEPARATION, DELTA - delta_p, SEPARATED),
            Exit(EventKind.RELOAD, -DELTA_DOT, turn),
        ),
    )
    branches: tuple[Branch, ...] = (compression, restitution)
    if reload == "elastic":
        branches += (
            Branch(
                "reload",
                unloading,
                elastic_energy,
                sp.Integer(0),
                (
                    Exit(EventKind.MAX_COMPRESSION, DELTA_DOT, "restitution"),
                    Exit(EventKind.YIELD, DELTA_MAX - DELTA, "compression"),
                ),
            ),
        )
        recontact = Exit(EventKind.TOUCHDOWN, delta_p - DELTA, "reload")
    else:
        recontact = Exit(EventKind.RELOAD, -DELTA_DOT, "compression")
    return ContactLaw(
        **known,
        branches=branches,
        unloading="restitution",
        memory=(DELTA_MAX,),
        # The floor keeps e = 0 from dividing by zero: unloading then ends where it begins.
        definitions={
            K_E: _stiffness(body, n, l_0),
            _E2: sp.Max(e.symbol**2, sp.Float("1e-200"), evaluate=False),
        },
        recontacts=(recontact,),
        stiffness=K_E,
        exponent=N,
    )


def _viscoelastic(
    known: Mapping[str, Any],
    definitions: Mapping[sp.Symbol, sp.Expr],
    exponent: sp.Expr,
    damping: sp.Expr,
    releases: tuple[sp.Expr, ...],
) -> ContactLaw:
    """Elastic K δⁿ plus a damping force; loading and unloading follow one expression."""
    # A linear force needs no ramp: it continues smoothly below δ = 0.
    base = DELTA if exponent == 1 else ramp(DELTA)
    elastic = K_E * base**exponent
    force, stored = elastic + damping, K_E * base ** (exponent + 1) / (exponent + 1)
    loss = damping * DELTA_DOT
    leave = tuple(Exit(EventKind.SEPARATION, guard, SEPARATED) for guard in (DELTA, *releases))
    turn, back = (
        Exit(EventKind.MAX_COMPRESSION, DELTA_DOT, "restitution"),
        Exit(EventKind.RELOAD, -DELTA_DOT, "compression"),
    )
    return ContactLaw(
        **known,
        branches=(
            Branch("compression", force, stored, loss, (turn, *leave[1:])),
            Branch("restitution", force, stored, loss, (*leave, back)),
        ),
        unloading="restitution",
        definitions=definitions,
        recontacts=tuple(Exit(EventKind.TOUCHDOWN, -guard, "restitution") for guard in releases),
        stiffness=K_E,
        exponent=exponent,
    )


def _hertz(known: Mapping[str, Any]) -> ContactLaw:
    *body, n, l_0 = known["parameters"]
    return _viscoelastic(known, {K_E: _stiffness(body, n, l_0)}, n.symbol, sp.Integer(0), ())


def _linear(known: Mapping[str, Any]) -> ContactLaw:
    k, c = known["parameters"]
    damping = c.symbol * DELTA_DOT
    # Without damping the force vanishes with δ, and that exit exists already.
    release = k.symbol * DELTA + damping
    return _viscoelastic(known, {K_E: k.symbol}, sp.Integer(1), damping, (release,))


def _hunt_crossley(known: Mapping[str, Any]) -> ContactLaw:
    *body, n, l_0, c = known["parameters"]
    damping = K_E * ramp(DELTA) ** n.symbol * c.symbol * DELTA_DOT
    release = 1 + c.symbol * DELTA_DOT
    return _viscoelastic(known, {K_E: _stiffness(body, n, l_0)}, n.symbol, damping, (release,))


FORMULAS: Mapping[str, Callable[[Mapping[str, Any]], ContactLaw]] = {
    "bilinear-hertz": _bilinear_hertz,
    "bilinear-hertz-two-bodies": _bilinear_hertz,
    "hertz": _hertz,
    "linear": _linear,
    "hunt-crossley": _hunt_crossley,
}
"""By name of the law: from its declared fields to the whole law."""
