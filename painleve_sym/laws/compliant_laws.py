"""The named laws of contacts that yield: each with its parameters, choices and formulas.

The formulas are made when they are first asked for: names and parameters need no SymPy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from painleve_sym.choices import Reload, ReloadLike, chosen
from painleve_sym.errors import EventKind, InputError
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.laws.friction import FrictionLaw
from painleve_sym.mechanics.declarations import Parameter, positive
from painleve_sym.mechanics.materials import CONTACT_EXPONENT, HERTZ_EXPONENT
from painleve_sym.units import Value

if TYPE_CHECKING:
    from sympy import Expr, Symbol

__all__ = ["bilinear_hertz", "hertz", "hunt_crossley", "linear"]  # what `laws` offers


_LOADING, _UNLOADING = "compression", "restitution"
"""Branches of every named law in which a contact begins, as it closes and as it opens."""

_Make = TypeVar("_Make", bound=Callable[..., ContactLaw])


class NamedLaw(NamedTuple):
    """A function that returns a law, and the choices that it takes besides friction."""

    make: Callable[..., ContactLaw]
    choices: tuple[str, ...]


COMPLIANT_LAWS: dict[str, NamedLaw] = {}
"""Laws of contacts that yield, by name."""


def _registered(
    choices: tuple[str, ...] = (), variants: Mapping[str, Mapping[str, Any]] | None = None
) -> Callable[[_Make], _Make]:
    """Return a decorator that enters a law, under the name of its function, and its variants.

    A variant is the law with arguments of its own, by its name.
    """

    def enter(make: _Make) -> _Make:
        COMPLIANT_LAWS[make.__name__.replace("_", "-")] = NamedLaw(make, choices)
        for name, arguments in (variants or {}).items():
            COMPLIANT_LAWS[name] = NamedLaw(partial(make, **arguments), choices)
        return make

    return enter


def _law(
    values: Mapping[str, Value],
    formulas: Callable[[Mapping[str, Any]], ContactLaw],
    definition: str,
    **known: Any,
) -> ContactLaw:
    """Return a named law with these values of its parameters.

    `formulas` makes the whole law from its declared fields. The cache knows it by `definition` and
    the package's own source.
    """
    known = {"choices": {}, "unloading": _UNLOADING, **known}
    make = partial(formulas, known)
    law = ContactLaw.deferred(
        make, definition=definition, friction=FrictionLaw(), loading_name=_LOADING, **known
    )
    return law.with_parameters(**values) if values else law


def _exponent() -> tuple[Parameter, Parameter]:
    """Exponent n of the compression law, and the length at which it equals Hertz's with n = 3/2."""
    meaning = "exponent of the compression law"
    n = positive("n", HERTZ_EXPONENT, "1", meaning, CONTACT_EXPONENT)
    meaning = "compression at which the force is Hertz's, K_e = (4/3) E* sqrt(R*) l_0^(3/2 - n)"
    return n, positive("l_0", 1.0, "m", meaning)


def _body_parameters(bodies: int) -> tuple[Parameter, ...]:
    """Modulus, Poisson's ratio and radius or curvature, of one body or of two."""
    if bodies == 1:
        E, nu = _elastic(0, ", both bodies")
        R = positive("R", 0.00645, "m", "radius of the contact end")
        return E, nu, R
    if bodies != 2:
        raise InputError(f"contact law: bodies: got {bodies!r}, need 1 or 2.")
    parameters: tuple[Parameter, ...] = ()
    for i, default_curvature in ((1, 1 / 0.00645), (2, 0.0)):
        k = Parameter(f"kappa_{i}", default_curvature, "1/m", f"curvature 1/R of body {i}")
        parameters += (*_elastic(i, f" of body {i}"), k)
    return parameters


def _elastic(body: int, whose: str) -> tuple[Parameter, Parameter]:
    """Return modulus and Poisson's ratio of body 1 or 2, or, for 0, of both."""
    end = f"_{body}" if body else ""
    meaning = f"elastic modulus{whose}"
    modulus = positive(f"E{end}", 20.9e10, "Pa", meaning, "young_modulus", body)
    ratio = Parameter(
        name=f"nu{end}",
        default=0.3,
        unit="1",
        meaning=f"Poisson's ratio{whose}",
        lower=-1.0,
        upper=0.5,
        material="poisson_ratio",
        body=body,
    )
    return modulus, ratio


@_registered(choices=("reload",), variants={"bilinear-hertz-two-bodies": {"bodies": 2}})
def bilinear_hertz(
    *, reload: ReloadLike = Reload.ELASTIC, bodies: int = 1, **parameters: Value
) -> ContactLaw:
    """Return the paper's elasto-plastic law, (4)–(10): F_n = K_e δⁿ, and (5) after δ_max.

    K_e = (4/3) E* √R* l_0^(3/2−n), in N/mⁿ. With n = 3/2 loading is Hertz's, for bodies of every
    material, and l_0 has no effect. The paper has n = 1.764 and no l_0, so that its K_e is in
    N/m^(3/2) and its force depends on the unit of length (in mm it would be 6.19 times as large).
    The length l_0, at which K_e δⁿ equals Hertz's force, makes the law one of every unit.
    ``n=1.764`` with l_0 = 1 m gives the numbers of the paper. It is the law of no material: at
    10 µm it is 21 times as soft as Hertz's.

    With δ_p = δ_max (1 − e²) the unloading curve (5) is F_n = K_e ((δ − δ_p)/e²)ⁿ. Of the work
    done on the loading curve the part e² is stored, the rest is dissipated by plasticity.

    A virgin reload creates the energy by which the loading curve at that compression exceeds what
    is stored. At e = 0 there is no unloading curve, and nothing for a contact that stays loaded to
    rest on: a run needs an event that ends it, and in a batch it stops at the first maximum
    compression of such a contact, as an accumulation of events.

    Parameters
    ----------
    reload : Reload or its text
        What follows when compression grows again before separation. ``virgin`` is
        thermodynamically inadmissible, since it creates energy; the paper's Fig. 4 needs it.
    bodies : {1, 2}
        1: both bodies of one material. 2: each has its own, and its curvature.
    **parameters : float
        ``E``, ``nu``, ``R``, ``n``, ``l_0``, ``e_energetic``; of two bodies ``E_1``, ``nu_1``,
        ``kappa_1``, …; SI units.

    Raises
    ------
    InputError
        Unknown names, values out of range.

    References
    ----------
    Impact model resolution on Painlevé's paradox, (4)–(10). Walton & Braun (1986), whose two
    branches are linear, for the elastic reload.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> laws.bilinear_hertz(E=20.9e14, reload="virgin").parameters[0].default
    2090000000000000.0
    """
    reload = chosen(Reload, reload, "reload rule", "law bilinear-hertz")
    e = Parameter("e_energetic", 0.75, "1", "energetic coefficient of restitution", 0.0, 1.0)
    return _law(
        parameters,
        _bilinear_hertz,
        f"bilinear-hertz {bodies} {reload}",
        name="bilinear-hertz" if bodies == 1 else "bilinear-hertz-two-bodies",
        title="elasto-plastic Hertz law K δⁿ, unloading by the energetic restitution"
        + ", two bodies" * (bodies == 2),
        source="Impact model resolution on Painlevé's paradox, (4)–(10)",
        parameters=(*_body_parameters(bodies), *_exponent(), e),
        choices={"reload": str(reload)},
    )


def _bilinear_hertz(known: Mapping[str, Any]) -> ContactLaw:
    import sympy as sp

    from painleve_sym.laws.compliance import (
        DELTA,
        DELTA_DOT,
        DELTA_MAX,
        K_E,
        SEPARATED,
        Branch,
        Exit,
        ramp,
        stiffness,
    )

    *body, n, l_0, e = known["parameters"]
    e_squared = sp.Symbol("e_squared", positive=True)
    reload, N = known["choices"]["reload"], n.symbol
    delta_p = DELTA_MAX * (1 - e.symbol**2)
    virgin = K_E * ramp(DELTA) ** N
    # Its sign is not known, and SymPy would search for it long.
    recovered = ramp((DELTA - delta_p) / e_squared, evaluate=False)
    work = K_E * ramp(DELTA) ** (N + 1) / (N + 1)
    turn = {"elastic": "reload", "virgin": _LOADING}[reload]
    compression = Branch(
        _LOADING,
        virgin,
        e.symbol**2 * work,
        (1 - e.symbol**2) * virgin * DELTA_DOT,
        (Exit(EventKind.MAX_COMPRESSION, DELTA_DOT, _UNLOADING, {DELTA_MAX: DELTA}),),
    )
    restitution = Branch(
        _UNLOADING,
        K_E * recovered**N,
        e_squared * K_E * recovered ** (N + 1) / (N + 1),
        sp.Integer(0),
        (
            Exit(EventKind.SEPARATION, DELTA - delta_p, SEPARATED),
            Exit(EventKind.RELOAD, -DELTA_DOT, turn),
        ),
    )
    branches: tuple[Branch, ...] = (compression, restitution)
    if reload == "elastic":
        back = (
            Exit(EventKind.MAX_COMPRESSION, DELTA_DOT, _UNLOADING),
            Exit(EventKind.YIELD, DELTA_MAX - DELTA, _LOADING),
        )
        branches += (replace(restitution, name="reload", exits=back),)
        recontact = Exit(EventKind.TOUCHDOWN, delta_p - DELTA, "reload")
    else:
        recontact = Exit(EventKind.RELOAD, -DELTA_DOT, _LOADING)
    return ContactLaw(
        **known,
        branches=branches,
        memory=(DELTA_MAX,),
        # The floor keeps e = 0 from dividing by zero: unloading then ends where it begins.
        definitions={
            K_E: stiffness(body, n, l_0),
            e_squared: sp.Max(e.symbol**2, sp.Float("1e-200"), evaluate=False),
        },
        recontacts=(recontact,),
        stiffness=K_E,
        exponent=N,
    )


def _viscoelastic(
    known: Mapping[str, Any],
    definitions: Mapping[Symbol, Expr],
    exponent: Expr,
    damping: Expr,
    releases: tuple[Expr, ...],
) -> ContactLaw:
    """Return elastic K δⁿ plus a damping force; loading and unloading follow one expression."""
    from painleve_sym.laws.compliance import DELTA, DELTA_DOT, K_E, SEPARATED, Branch, Exit, ramp

    # A linear force needs no ramp: it continues smoothly below δ = 0.
    base = DELTA if exponent == 1 else ramp(DELTA)
    elastic = K_E * base**exponent
    force, stored = elastic + damping, K_E * base ** (exponent + 1) / (exponent + 1)
    loss = damping * DELTA_DOT
    leave = tuple(Exit(EventKind.SEPARATION, guard, SEPARATED) for guard in (DELTA, *releases))
    turn, back = (
        Exit(EventKind.MAX_COMPRESSION, DELTA_DOT, _UNLOADING),
        Exit(EventKind.RELOAD, -DELTA_DOT, _LOADING),
    )
    return ContactLaw(
        **known,
        branches=(
            Branch(_LOADING, force, stored, loss, (turn, *leave[1:])),
            Branch(_UNLOADING, force, stored, loss, (*leave, back)),
        ),
        definitions=definitions,
        recontacts=tuple(Exit(EventKind.TOUCHDOWN, -guard, _UNLOADING) for guard in releases),
        stiffness=K_E,
        exponent=exponent,
    )


@_registered()
def hertz(*, bodies: int = 1, **parameters: Value) -> ContactLaw:
    """Return Hertz's elastic law F_n = K_e δⁿ (n = 3/2 by default), which dissipates nothing.

    K_e is that of `bilinear_hertz`; the reference length l_0 matters where n is not 3/2.

    Parameters
    ----------
    bodies, **parameters
        As for `bilinear_hertz`, without ``e_energetic``.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> laws.hertz(E=1e9)
    ContactLaw 'hertz': E=1e+09, nu=0.3, R=0.00645, n=1.5, l_0=1
    """
    return _law(
        parameters,
        _hertz,
        f"hertz {bodies}",
        name="hertz",
        title="elastic Hertz law K δⁿ",
        source="Johnson (1985), ch. 4",
        parameters=(*_body_parameters(bodies), *_exponent()),
    )


def _hertz(known: Mapping[str, Any]) -> ContactLaw:
    import sympy as sp

    from painleve_sym.laws.compliance import K_E, stiffness

    *body, n, l_0 = known["parameters"]
    return _viscoelastic(known, {K_E: stiffness(body, n, l_0)}, n.symbol, sp.Integer(0), ())


@_registered()
def linear(**parameters: Value) -> ContactLaw:
    """Return the spring and dashpot F_n = k δ + c δ̇, released where the force would pull.

    Parameters
    ----------
    **parameters : float
        ``k`` in N/m, ``c`` in N s/m.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> laws.linear(k=1e6)
    ContactLaw 'linear': k=1e+06, c=0
    """
    return _law(
        parameters,
        _linear,
        "linear",
        name="linear",
        title="linear spring and dashpot",
        source="Hogan & Kristiansen (2017)",
        parameters=(
            positive("k", 1e8, "N/m", "stiffness"),
            Parameter("c", 0.0, "N s/m", "damping", 0.0),
        ),
    )


def _linear(known: Mapping[str, Any]) -> ContactLaw:
    import sympy as sp

    from painleve_sym.laws.compliance import DELTA, DELTA_DOT, K_E

    k, c = known["parameters"]
    damping = c.symbol * DELTA_DOT
    # Without damping the force vanishes with δ, and that exit exists already.
    release = k.symbol * DELTA + damping
    return _viscoelastic(known, {K_E: k.symbol}, sp.Integer(1), damping, (release,))


@_registered()
def hunt_crossley(*, bodies: int = 1, **parameters: Value) -> ContactLaw:
    """Return F_n = K_e δⁿ (1 + c δ̇), whose dashpot vanishes with the compression.

    K_e is that of `bilinear_hertz`; the reference length l_0 matters where n is not 3/2.

    Parameters
    ----------
    bodies, **parameters
        As for `hertz`, and the damping factor ``c`` in s/m.

    Examples
    --------
    >>> from painleve_sym import laws
    >>> laws.hunt_crossley(c=0.2)
    ContactLaw 'hunt-crossley': E=2.09e+11, nu=0.3, R=0.00645, n=1.5, l_0=1, c=0.2
    """
    damping = Parameter("c", 0.1, "s/m", "damping factor", 0.0)
    return _law(
        parameters,
        _hunt_crossley,
        f"hunt-crossley {bodies}",
        name="hunt-crossley",
        title="Hertz law with a dashpot proportional to the elastic force",
        source="Hunt & Crossley (1975)",
        parameters=(*_body_parameters(bodies), *_exponent(), damping),
    )


def _hunt_crossley(known: Mapping[str, Any]) -> ContactLaw:
    from painleve_sym.laws.compliance import DELTA, DELTA_DOT, K_E, ramp, stiffness

    *body, n, l_0, c = known["parameters"]
    damping = K_E * ramp(DELTA) ** n.symbol * c.symbol * DELTA_DOT
    release = 1 + c.symbol * DELTA_DOT
    return _viscoelastic(known, {K_E: stiffness(body, n, l_0)}, n.symbol, damping, (release,))
