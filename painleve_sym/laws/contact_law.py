"""Named laws of a contact that yields: what they are called and their parameters.

Their formulas, branch by branch, are in `compliance`, and are made when first asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from painleve_sym.choices import Friction, FrictionLike, Reload, ReloadLike, chosen
from painleve_sym.errors import InputError, ModelError, unknown_name
from painleve_sym.laws.friction import FrictionLaw
from painleve_sym.mechanics.declarations import (
    Parameter,
    settings_text,
    with_defaults,
    with_fields,
)
from painleve_sym.mechanics.deferred import Deferred

if TYPE_CHECKING:
    from sympy import Expr, Symbol

    from painleve_sym.laws.compliance import Branch, Exit


@dataclass(frozen=True, repr=False)
class ContactLaw(Deferred):
    """A normal contact law made of branches, and the friction law of the contact.

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
    friction : FrictionLaw
        Its parameters are among those of the law; by default Coulomb's.

    Raises
    ------
    ModelError
        Branch names repeated, exits to unknown branches, undeclared symbols.
    """

    is_compliant: ClassVar[Literal[True]] = True
    """Whether the contact yields."""

    name: str
    title: str
    source: str
    parameters: tuple[Parameter, ...]
    branches: tuple[Branch, ...]
    unloading: str
    stiffness: Expr
    exponent: Expr
    memory: tuple[Symbol, ...] = field(default_factory=tuple)
    definitions: Mapping[Symbol, Expr] = field(default_factory=dict)
    recontacts: tuple[Exit, ...] = field(default_factory=tuple)
    choices: Mapping[str, str] = field(default_factory=dict)
    friction: FrictionLaw = field(default_factory=FrictionLaw)

    def __post_init__(self) -> None:
        from sympy import sympify

        from painleve_sym.laws.compliance import DELTA, DELTA_DOT, SEPARATED

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
        for symbol in {s for e in exprs for s in sympify(e).free_symbols} - known:
            faults.append(unknown_name("symbol", str(symbol), map(str, known)))
        if faults:
            raise ModelError(f"contact law {self.name!r}", faults)

    @cached_property
    def definition(self) -> str:
        """Everything its derivations start from, as one text (`definition_text`)."""
        from painleve_sym.mechanics.definition import definition_text

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

    def with_friction(self, friction: FrictionLike) -> ContactLaw:
        """Return the law with a friction law; its parameters follow those of the law.

        Parameters
        ----------
        friction : {"coulomb", "static", "stribeck", "spring"}

        Raises
        ------
        InputError
            An unknown friction law, a law that has one other than Coulomb's already, or a spring
            with a normal force that jumps.

        Examples
        --------
        >>> from painleve_sym import laws
        >>> [p.name for p in laws.linear().with_friction("stribeck").parameters]
        ['k', 'c', 'static_ratio', 'stribeck_velocity']
        """
        rubbing = FrictionLaw.named(friction)
        if not self.friction.is_coulomb:
            raise InputError(
                f"law {self.name!r}: friction: got {rubbing.kind.value!r} for a law that has "
                f"{self.friction.kind.value!r} already. Fix: start from the law without it."
            )
        if rubbing.is_coulomb:
            return self
        if rubbing.kind is Friction.SPRING and self.choices.get("reload") == Reload.VIRGIN:
            raise InputError(
                f"law {self.name!r}: friction: got {rubbing.kind.value!r} with reload='virgin', "
                "where the normal force jumps, and the force of a tangential spring cannot jump "
                "with it. Fix: take reload='elastic'."
            )
        parameters = (*self.parameters, *rubbing.parameters)
        choices = {**self.choices, "friction": str(rubbing.kind)}
        source = f"{self.source}; {rubbing.source}"

        def make() -> ContactLaw:
            return replace(
                self, parameters=parameters, choices=choices, source=source, friction=rubbing
            )

        return ContactLaw.deferred(
            make,
            name=self.name,
            title=self.title,
            source=source,
            parameters=parameters,
            choices=choices,
            friction=rubbing,
            definition=f"{self.definition} with {rubbing.kind} friction",
        )

    def of_contact(self, contact: str) -> ContactLaw:
        """Return the law with the contact's name behind those of its parameters and constants."""
        return self._renamed(f" of contact {contact}", lambda name: f"{name}_{contact}")

    def apart_from(self, names: Collection[str]) -> ContactLaw:
        """Return the law with ``_law`` behind the names of its parameters that are taken.

        So a drum of radius ``R`` goes with a law whose parameter is ``R``.
        """
        if not any(p.name in names for p in self.parameters):
            return self
        taken = [p.name for p in self.parameters if p.name in names]
        return self._renamed(
            f" apart from {taken}", lambda name: f"{name}_law" if name in names else name
        )

    def _renamed(self, definition: str, new_name: Callable[[str], str]) -> ContactLaw:
        parameters = tuple(replace(p, name=new_name(p.name)) for p in self.parameters)
        friction = self.friction.renamed(new_name)
        return ContactLaw.deferred(
            partial(self._with_names, new_name, parameters),
            friction=friction,
            name=self.name,
            title=self.title,
            source=self.source,
            parameters=parameters,
            choices=self.choices,
            definition=f"{self.definition}{definition}",
        )

    def _with_names(
        self, new_name: Callable[[str], str], parameters: tuple[Parameter, ...]
    ) -> ContactLaw:
        from sympy import Symbol, sympify

        symbols = {p.symbol: q.symbol for p, q in zip(self.parameters, parameters, strict=True)}
        symbols |= {s: Symbol(new_name(s.name), **s.assumptions0) for s in self.definitions}

        def own(expr: Expr) -> Expr:
            return sympify(expr).xreplace(symbols)

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
        return replace(
            self,
            parameters=parameters,
            branches=branches,
            stiffness=own(self.stiffness),
            exponent=own(self.exponent),
            definitions={own(s): own(v) for s, v in self.definitions.items()},
            recontacts=exits(self.recontacts),
            friction=self.friction.renamed(new_name),
        )

    @property
    def loading(self) -> Branch:
        """Branch in which a fresh surface is compressed."""
        return self.branches[0]

    @property
    def depends_on_rate(self) -> bool:
        """Whether the force depends on the rate of the compression in any branch."""
        from painleve_sym.laws.compliance import DELTA_DOT

        return any(branch.force.has(DELTA_DOT) for branch in self.branches)

    def branch(self, name: str) -> Branch:
        """Return the branch of that name."""
        return next(b for b in self.branches if b.name == name)


def _exponent(default: float) -> tuple[Parameter, Parameter]:
    """Exponent n of the compression law, and the length at which it equals Hertz's with n = 3/2."""
    n = Parameter("n", default, "1", "exponent of the compression law", 0.0, lower_closed=False)
    meaning = "compression at which the force is Hertz's, K_e = (4/3) E* sqrt(R*) l_0^(3/2 - n)"
    return n, Parameter("l_0", 1.0, "m", meaning, 0.0, lower_closed=False)


def _body_parameters(bodies: int) -> tuple[Parameter, ...]:
    """Modulus, Poisson's ratio and radius or curvature, of one body or of two."""
    if bodies == 1:
        E, nu = _elastic(0, ", both bodies")
        R = Parameter("R", 0.00645, "m", "radius of the contact end", 0.0, lower_closed=False)
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
    modulus = Parameter(
        *(f"E{end}", 20.9e10, "Pa", f"elastic modulus{whose}", 0.0),
        lower_closed=False,
        material="young_modulus",
        body=body,
    )
    ratio = Parameter(
        *(f"nu{end}", 0.3, "1", f"Poisson's ratio{whose}", -1.0, 0.5),
        material="poisson_ratio",
        body=body,
    )
    return modulus, ratio


def bilinear_hertz(
    *, reload: ReloadLike = Reload.ELASTIC, bodies: int = 1, **parameters: float
) -> ContactLaw:
    """Return the paper's elasto-plastic law, (4)–(10): F_n = K_e δⁿ, and (5) after δ_max.

    K_e = (4/3) E* √R* l_0^(3/2−n), in N/mⁿ. The paper has no l_0, and its K_e is in N/m^(3/2): with
    n = 1.764 its force depends on the unit of length (in mm it would be 6.19 times as large). The
    length l_0, at which K_e δⁿ equals Hertz's force, makes the law one of every unit; l_0 = 1 m
    gives the numbers of the paper, and at n = 3/2 it has no effect.

    With δ_p = δ_max (1 − e²) the unloading curve (5) is F_n = K_e ((δ − δ_p)/e²)ⁿ. Of the work
    done on the loading curve the part e² is stored, the rest is dissipated by plasticity.

    A virgin reload creates the energy by which the loading curve at that compression exceeds what
    is stored. At e = 0 there is no unloading curve, and a contact that stays loaded ends a run at
    its first maximum compression, as an accumulation of events.

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
    return _named(
        parameters,
        f"bilinear-hertz {bodies} {reload}",
        name="bilinear-hertz" if bodies == 1 else "bilinear-hertz-two-bodies",
        title="elasto-plastic Hertz law, loading K δⁿ, unloading from the energetic restitution",
        source="Impact model resolution on Painlevé's paradox, (4)–(10)",
        parameters=(*_body_parameters(bodies), *_exponent(1.764), e),
        choices={"reload": str(reload)},
    )


def hertz(*, bodies: int = 1, **parameters: float) -> ContactLaw:
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
    return _named(
        parameters,
        f"hertz {bodies}",
        name="hertz",
        title="elastic Hertz law K δⁿ",
        source="Johnson (1985), ch. 4",
        parameters=(*_body_parameters(bodies), *_exponent(1.5)),
    )


def linear(**parameters: float) -> ContactLaw:
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
    return _named(
        parameters,
        "linear",
        name="linear",
        title="linear spring and dashpot",
        source="Hogan & Kristiansen (2017)",
        parameters=(
            Parameter("k", 1e8, "N/m", "stiffness", 0.0, lower_closed=False),
            Parameter("c", 0.0, "N s/m", "damping", 0.0),
        ),
    )


def hunt_crossley(*, bodies: int = 1, **parameters: float) -> ContactLaw:
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
    return _named(
        parameters,
        f"hunt-crossley {bodies}",
        name="hunt-crossley",
        title="Hertz law with a dashpot proportional to the elastic force",
        source="Hunt & Crossley (1975)",
        parameters=(*_body_parameters(bodies), *_exponent(1.5), damping),
    )


def _named(values: Mapping[str, float], definition: str, **known: Any) -> ContactLaw:
    """Return a named law with these values of its parameters.

    The cache knows it by `definition` and the package's own source.
    """
    known = {"choices": {}, **known}
    make = partial(_with_formulas, known)
    law = ContactLaw.deferred(make, definition=definition, friction=FrictionLaw(), **known)
    return law.with_parameters(**values) if values else law


def _with_formulas(known: Mapping[str, Any]) -> ContactLaw:
    from painleve_sym.laws.compliance import FORMULAS

    return FORMULAS[known["name"]](known)
