"""Law of a contact that yields: its branches, memory, parameters and friction."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from painleve_sym.choices import Friction, FrictionLike, Reload
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, refuse_faulty, repeated, unknown_name
from painleve_sym.laws.contact_kind import ContactKind
from painleve_sym.laws.friction import FrictionLaw
from painleve_sym.mechanics.declarations import Parameter, settings_text, with_defaults, with_fields
from painleve_sym.mechanics.deferred import Deferred
from painleve_sym.units import Value

if TYPE_CHECKING:
    from sympy import Expr, Symbol

    from painleve_sym.laws.compliance import Branch, Exit


_DECLARED = (
    *("name", "title", "source", "parameters", "choices"),
    *("unloading", "loading_name", "friction"),
)
"""Fields that a law has before its formulas are made."""


@dataclass(frozen=True, repr=False, eq=False)
class ContactLaw(Compared, Deferred):
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

    Examples
    --------
    >>> import painleve_sym as ps
    >>> law = ps.laws.hertz(E=70e9)
    >>> law.name, [p.name for p in law.parameters]
    ('hertz', ['E', 'nu', 'R', 'n', 'l_0'])
    >>> law.stiffness
    K_e
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
        faults = [f"branch {n!r} is declared twice." for n in repeated(names)]
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
        refuse_faulty(f"contact law {self.name!r}", faults)

    @property
    def kind(self) -> ContactKind:
        """Whether its friction yields, too."""
        yields = self.friction.tangential_stiffness is not None
        return ContactKind.SPRING if yields else ContactKind.COMPLIANT

    @cached_property
    def remembers(self) -> tuple[str, ...]:
        """Names of quantities besides δ, δ̇ and the slip on which the force depends.

        Examples
        --------
        >>> from painleve_sym import laws
        >>> laws.bilinear_hertz().remembers, laws.hertz().remembers
        (('branch', 'delta_max'), ())
        """
        branch = ("branch",) if len({b.force for b in self.branches}) > 1 else ()
        spring = ("deflection of the tangential spring",) if self.kind is ContactKind.SPRING else ()
        return (*branch, *map(str, self.memory), *spring)

    @cached_property
    def definition(self) -> str:
        """Everything its derivations start from, as one text (`definition_text`)."""
        from painleve_sym.mechanics.definition import definition_text

        return definition_text(self)

    def __repr__(self) -> str:
        """Return name, choices and parameters."""
        space = " " if self.choices else ""
        return f"ContactLaw {self.name!r}{space}{settings_text(self.choices, self.parameters)}"

    def with_parameters(self, **values: Value) -> ContactLaw:
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
            with a normal force that jumps: that of a virgin reload, or of e = 0, which falls to 0
            where it is largest.

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
        own = self.parameters
        if rubbing.kind is Friction.SPRING:
            own = tuple(
                replace(p, lower_closed=False) if p.name == "e_energetic" else p for p in own
            )
        for p in own:
            if fault := p.fault(p.default):
                raise InputError(f"law {self.name!r} with friction {rubbing.kind.value!r}: {fault}")
        parameters = (*own, *rubbing.parameters)
        choices = {**self.choices, "friction": str(rubbing.kind)}
        source = f"{self.source}; {rubbing.source}"

        def make() -> ContactLaw:
            law = self._with_names(str, own)
            return replace(
                law, parameters=parameters, choices=choices, source=source, friction=rubbing
            )

        changed = {"parameters": parameters, "choices": choices, "source": source}
        end = f" with {rubbing.kind} friction"
        return self._deferred(make, end, friction=rubbing, **changed)

    def _deferred(
        self, make: Callable[[], ContactLaw], definition: str, **changed: Any
    ) -> ContactLaw:
        """Return the law that is made later; its definition is this one's with an end."""
        known = {name: getattr(self, name) for name in _DECLARED} | changed
        return ContactLaw.deferred(make, definition=f"{self.definition}{definition}", **known)

    def of_contact(self, contact: str) -> ContactLaw:
        """Return the law with the contact's name behind those of its parameters and constants."""
        return self._renamed(f" of contact {contact}", lambda name: f"{name}_{contact}")

    def apart_from(self, names: Collection[str]) -> ContactLaw:
        """Return the law with ``_law`` behind the names of its parameters that are taken.

        So a drum of radius ``R``, or a coordinate ``n``, goes with a law of such a parameter.
        """
        if not any(p.name in names for p in self.parameters):
            return self
        taken = [p.name for p in self.parameters if p.name in names]
        return self._renamed(
            f" apart from {taken}", lambda name: f"{name}_law" if name in names else name
        )

    def _renamed(self, definition: str, new_name: Callable[[str], str]) -> ContactLaw:
        parameters = tuple(replace(p, name=new_name(p.name)) for p in self.parameters)
        make = partial(self._with_names, new_name, parameters)
        friction = self.friction.renamed(new_name)
        return self._deferred(make, definition, parameters=parameters, friction=friction)

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

    @cached_property
    def loading_name(self) -> str:
        """Name of the branch `loading`."""
        return self.loading.name

    @property
    def depends_on_rate(self) -> bool:
        """Whether the force depends on the rate of the compression in any branch."""
        from painleve_sym.laws.compliance import DELTA_DOT

        return any(branch.force.has(DELTA_DOT) for branch in self.branches)

    def branch(self, name: str) -> Branch:
        """Return the branch of that name."""
        return next(b for b in self.branches if b.name == name)
