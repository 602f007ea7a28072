"""Force–compression laws of a compliant contact, branch by branch."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar

import sympy as sp

from painleve_sym.choices import Reload, ReloadLike, chosen
from painleve_sym.errors import EventKind, InputError, ModelError, unknown_name
from painleve_sym.mechanics.definition import definition_text
from painleve_sym.mechanics.system import Parameter, settings_text, with_defaults, with_fields

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
    """End of a branch, where `guard` crosses from + to −.

    Attributes
    ----------
    kind : EventKind
        max_compression, reload, yield, separation or touchdown.
    guard : sympy.Expr
        In δ, δ̇, memory and parameters.
    target : str
        Name of the next branch, or SEPARATED.
    memory : mapping of memory symbol to sympy.Expr
        New values, in δ and the old memory; what is absent is kept.
    """

    kind: EventKind
    guard: sp.Expr
    target: str
    memory: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)


@dataclass(frozen=True)
class Branch:
    """One curve F_n(δ, δ̇) with its energies; F_n δ̇ = d(stored)/dt + dissipated power.

    Attributes
    ----------
    name : str
    force : sympy.Expr
        F_n ≥ 0; N.
    stored_energy : sympy.Expr
        What this contact can still give back; J.
    dissipated_power : sympy.Expr
        Power lost for good; W.
    exits : tuple of Exit
    """

    name: str
    force: sp.Expr
    stored_energy: sp.Expr
    dissipated_power: sp.Expr
    exits: tuple[Exit, ...]


@dataclass(frozen=True, repr=False)
class ContactLaw:
    """A normal contact law made of branches.

    Parameters
    ----------
    name, title, source : str
    parameters : tuple of Parameter
    branches : tuple of Branch
        The first is where loading of a fresh surface starts.
    unloading : str
        Branch in which a contact starts that is compressed and opening.
    memory : tuple of sympy.Symbol
    definitions : mapping of symbol to sympy.Expr
        Constants computed once from the parameters, in order (such as K_e).
    recontacts : tuple of Exit
        How a contact that separated with δ > 0 closes again before the gap opens.
    choices : mapping of str to str
        Named choices the law was made with (such as the reload rule).
    stiffness, exponent : sympy.Expr
        K and n of the loading curve K δⁿ, used for scales and closed forms.

    Raises
    ------
    ModelError
        Branch names repeated, exits to unknown branches, undeclared symbols.
    """

    is_compliant: ClassVar[bool] = True
    """Whether the contact yields."""

    name: str
    title: str
    source: str
    parameters: tuple[Parameter, ...]
    branches: tuple[Branch, ...]
    unloading: str
    stiffness: sp.Expr
    exponent: sp.Expr
    memory: tuple[sp.Symbol, ...] = field(default_factory=tuple)
    definitions: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    recontacts: tuple[Exit, ...] = field(default_factory=tuple)
    choices: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        names = [b.name for b in self.branches]
        faults = [f"branch {n!r} is declared twice." for n in set(names) if names.count(n) > 1]
        known = {DELTA, DELTA_DOT, *self.memory, *self.definitions}
        known |= {p.symbol for p in self.parameters}
        exits = [e for b in self.branches for e in b.exits] + list(self.recontacts)
        for target in [e.target for e in exits if e.target != SEPARATED] + [self.unloading]:
            if target not in names:
                faults.append(unknown_name("branch", target, names))
        exprs = [e for b in self.branches for e in (b.force, b.stored_energy, b.dissipated_power)]
        exprs += [e.guard for e in exits] + [v for e in exits for v in e.memory.values()]
        for symbol in {s for e in exprs for s in sp.sympify(e).free_symbols} - known:
            faults.append(unknown_name("symbol", str(symbol), map(str, known)))
        if faults:
            raise ModelError(f"contact law {self.name!r}", faults)

    @classmethod
    def deferred(cls, make: Callable[[], ContactLaw], **known: Any) -> ContactLaw:
        """Return the law that `make` returns; its formulas are made when first asked for.

        Parameters
        ----------
        make : callable
        **known
            Fields of the law that are known before, and its `definition`: sufficient for
            a run from the cache.
        """
        law = object.__new__(cls)
        law.__dict__.update(known, _make=make)
        return law

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            # Asked for what is not there: a field of a deferred law.
            if name not in self.__dataclass_fields__ or "_make" not in self.__dict__:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            values = vars(self._make())
            for other in values:
                self.__dict__.setdefault(other, values[other])
            return values[name]

    @cached_property
    def definition(self) -> str:
        """Everything its derivations start from, as one text (`definition_text`)."""
        return definition_text(self)

    def __repr__(self) -> str:
        """Return name, choices and parameters."""
        space = " " if self.choices else ""
        return f"ContactLaw {self.name!r}{space}{settings_text(self.choices, self.parameters)}"

    def with_parameters(self, **values: float) -> ContactLaw:
        """Return the law with other defaults of its parameters; see `Mechanism.with_parameters`.

        Examples
        --------
        >>> from painleve_sym import laws
        >>> soft = laws.hertz().with_parameters(E=1e9)
        >>> {p.name: p.default for p in soft.parameters}["E"]
        1000000000.0
        """
        return with_fields(
            self, parameters=with_defaults(f"law {self.name!r}", self.parameters, values)
        )

    def of_contact(self, contact: str) -> ContactLaw:
        """Return the law with the contact's name behind those of its parameters and constants."""
        return self._renamed(lambda name: f"{name}_{contact}")

    def apart_from(self, names: Collection[str]) -> ContactLaw:
        """Return the law with ``_law`` behind the names of its parameters that are taken.

        So a drum of radius ``R`` goes with a law whose parameter is ``R``.
        """
        if not any(p.name in names for p in self.parameters):
            return self
        return self._renamed(lambda name: f"{name}_law" if name in names else name)

    def _renamed(self, new_name: Callable[[str], str]) -> ContactLaw:
        parameters = [replace(p, name=new_name(p.name)) for p in self.parameters]
        symbols = {p.symbol: q.symbol for p, q in zip(self.parameters, parameters, strict=True)}
        symbols |= {s: sp.Symbol(new_name(s.name), **s.assumptions0) for s in self.definitions}

        def own(expr: sp.Expr) -> sp.Expr:
            return sp.sympify(expr).xreplace(symbols)

        def exits(given: tuple[Exit, ...]) -> tuple[Exit, ...]:
            return tuple(
                replace(e, guard=own(e.guard), memory={s: own(v) for s, v in e.memory.items()})
                for e in given
            )

        branches = tuple(
            replace(
                b,
                force=own(b.force),
                stored_energy=own(b.stored_energy),
                dissipated_power=own(b.dissipated_power),
                exits=exits(b.exits),
            )
            for b in self.branches
        )
        return ContactLaw(
            name=self.name,
            title=self.title,
            source=self.source,
            parameters=tuple(parameters),
            branches=branches,
            unloading=self.unloading,
            stiffness=own(self.stiffness),
            exponent=own(self.exponent),
            memory=self.memory,
            definitions={own(s): own(v) for s, v in self.definitions.items()},
            recontacts=exits(self.recontacts),
            choices=self.choices,
        )

    @property
    def loading(self) -> Branch:
        """Branch in which a fresh surface is compressed."""
        return self.branches[0]

    def branch(self, name: str) -> Branch:
        """Return the branch of that name."""
        return next(b for b in self.branches if b.name == name)


def _exponent(default: float) -> Parameter:
    return Parameter("n", default, "1", "exponent of the compression law", 0.0, lower_closed=False)


def _body_parameters(bodies: int) -> tuple[Parameter, ...]:
    """Modulus, Poisson's ratio and radius or curvature, of one body or of two."""
    if bodies == 1:
        E = Parameter("E", 20.9e10, "Pa", "elastic modulus, both bodies", 0.0, lower_closed=False)
        nu = Parameter("nu", 0.3, "1", "Poisson's ratio, both bodies", -1.0, 0.5)
        R = Parameter("R", 0.00645, "m", "radius of the contact end", 0.0, lower_closed=False)
        return E, nu, R
    if bodies != 2:
        raise InputError(f"contact law: bodies: got {bodies!r}, need 1 or 2.")
    parameters: tuple[Parameter, ...] = ()
    for i, default_curvature in ((1, 1 / 0.00645), (2, 0.0)):
        body = f"of body {i}"
        E = Parameter(f"E_{i}", 20.9e10, "Pa", f"elastic modulus {body}", 0.0, lower_closed=False)
        nu = Parameter(f"nu_{i}", 0.3, "1", f"Poisson's ratio {body}", -1.0, 0.5)
        k = Parameter(f"kappa_{i}", default_curvature, "1/m", f"curvature 1/R {body}")
        parameters += (E, nu, k)
    return parameters


def _stiffness(parameters: Sequence[Parameter]) -> sp.Expr:
    """K_e = (4/3) E* √R* of the parameters of one body, or of two.

    One body: both of the same material, the second one flat. 1/E* = Σ (1 − ν_i²)/E_i and
    1/R* = Σ 1/R_i (the paper sums four principal curvatures, which would halve R*).
    """
    symbols = [p.symbol for p in parameters]
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
_E2 = sp.Symbol("e_squared", positive=True)


def bilinear_hertz(reload: ReloadLike = Reload.ELASTIC, bodies: int = 1) -> ContactLaw:
    """Return the paper's elasto-plastic law: F_n = K_e δⁿ, and (5) after δ_max.

    With δ_p = δ_max (1 − e²) the unloading curve (5) is F_n = K_e ((δ − δ_p)/e²)ⁿ. Of the work
    done on the loading curve the part e² is stored, the rest is dissipated by plasticity.

    Parameters
    ----------
    reload : {"elastic", "virgin"}
        What follows when compression grows again before separation. ``elastic``: back up the
        unloading curve to δ_max, then the loading curve (Walton & Braun). ``virgin``: the loading
        curve at once, with a jump of the force; what the paper's Fig. 4 needs.
        At e = 0 there is no unloading curve, and a contact that stays loaded ends a run at its
        first maximum compression, as an accumulation of events.
    bodies : {1, 2}
        1: parameters E, nu, R, the same material on a plane. 2: E_i, nu_i and curvature kappa_i.

    References
    ----------
    Zhao, Liu & Chen, (4)–(10). Walton & Braun, J. Rheology 30 (1986) 949–980.
    """
    reload = chosen(Reload, reload, "reload rule", "law bilinear-hertz")
    e = Parameter("e_energetic", 0.75, "1", "energetic coefficient of restitution", 0.0, 1.0)
    known: dict[str, Any] = {
        "name": "bilinear-hertz" if bodies == 1 else "bilinear-hertz-two-bodies",
        "title": "elasto-plastic Hertz law, loading K δⁿ, unloading from the energetic restitution",
        "source": "Zhao, Liu & Chen, (4)–(10)",
        "parameters": (*_body_parameters(bodies), _exponent(1.764), e),
        "choices": {"reload": str(reload)},
    }
    # What the formulas are is written below, and the cache knows this text from any other.
    definition = f"bilinear-hertz {bodies} {reload}"
    return ContactLaw.deferred(partial(_bilinear_hertz, known), definition=definition, **known)


def _bilinear_hertz(known: Mapping[str, Any]) -> ContactLaw:
    *body, n, e = known["parameters"]
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
            K_E: _stiffness(body),
            _E2: sp.Max(e.symbol**2, sp.Float("1e-200"), evaluate=False),
        },
        recontacts=(recontact,),
        stiffness=K_E,
        exponent=N,
    )


def _viscoelastic(
    name: str,
    title: str,
    source: str,
    parameters: tuple[Parameter, ...],
    definitions: Mapping[sp.Symbol, sp.Expr],
    exponent: sp.Expr,
    damping: sp.Expr,
    releases: tuple[sp.Expr, ...],
) -> ContactLaw:
    """Elastic K δⁿ plus a damping force; loading and unloading follow one expression."""
    elastic = K_E * ramp(DELTA) ** exponent
    force, stored = elastic + damping, K_E * ramp(DELTA) ** (exponent + 1) / (exponent + 1)
    loss = damping * DELTA_DOT
    leave = tuple(Exit(EventKind.SEPARATION, guard, SEPARATED) for guard in (DELTA, *releases))
    turn, back = (
        Exit(EventKind.MAX_COMPRESSION, DELTA_DOT, "restitution"),
        Exit(EventKind.RELOAD, -DELTA_DOT, "compression"),
    )
    return ContactLaw(
        name=name,
        title=title,
        source=source,
        parameters=parameters,
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


def hertz(bodies: int = 1) -> ContactLaw:
    """Return the elastic law F_n = K_e δⁿ (n = 3/2 by default), nothing dissipated."""
    body, n = _body_parameters(bodies), _exponent(1.5)
    return _viscoelastic(
        "hertz",
        "elastic Hertz law K δⁿ",
        "Johnson, Contact Mechanics (1985), ch. 4",
        (*body, n),
        {K_E: _stiffness(body)},
        n.symbol,
        sp.Integer(0),
        (),
    )


def linear() -> ContactLaw:
    """Return the spring and dashpot F_n = k δ + c δ̇, released where the force would pull."""
    k = Parameter("k", 1e8, "N/m", "stiffness", 0.0, lower_closed=False)
    c = Parameter("c", 0.0, "N s/m", "damping", 0.0)
    damping = c.symbol * DELTA_DOT
    # Without damping the force vanishes with δ, and that exit exists already.
    release = k.symbol * DELTA + damping
    return _viscoelastic(
        "linear",
        "linear spring and dashpot",
        "Hogan & Kristiansen, SIAM J. Appl. Dyn. Syst. 16 (2017)",
        (k, c),
        {K_E: k.symbol},
        sp.Integer(1),
        damping,
        (release,),
    )


def hunt_crossley(bodies: int = 1) -> ContactLaw:
    """Return F_n = K_e δⁿ (1 + c δ̇), whose dashpot vanishes with the compression."""
    body, n = _body_parameters(bodies), _exponent(1.5)
    c = Parameter("c", 0.1, "s/m", "damping factor", 0.0)
    damping = K_E * ramp(DELTA) ** n.symbol * c.symbol * DELTA_DOT
    return _viscoelastic(
        "hunt-crossley",
        "Hertz law with a dashpot proportional to the elastic force",
        "Hunt & Crossley, J. Appl. Mech. 42 (1975) 440–445",
        (*body, n, c),
        {K_E: _stiffness(body)},
        n.symbol,
        damping,
        (1 + c.symbol * DELTA_DOT,),
    )
