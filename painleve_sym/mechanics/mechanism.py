"""A mechanism: a Lagrangian system with its frictional contacts and the domain it is valid in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property

import sympy as sp

from painleve_sym.errors import InputError, ModelError, unknown_name
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.definition import definition_text
from painleve_sym.mechanics.system import TIME, LagrangianSystem, with_defaults, with_fields
from painleve_sym.quantities import derivative_latex


@dataclass(frozen=True)
class DomainBound:
    """A condition the model needs: `margin` > 0 inside its domain."""

    margin: sp.Expr
    meaning: str


@dataclass(frozen=True, repr=False)
class Mechanism:
    """A Lagrangian system with its contacts and the domain it is valid in.

    Attributes
    ----------
    name, title, source : str
    system : LagrangianSystem
    contacts : tuple of Contact
    domain : tuple of DomainBound
    sketch : str
        A few lines of text showing the mechanism and its signs.
    start : mapping of str to float
        A state to begin with: in contact and sliding at the parameters' defaults; absent
        coordinates and velocities, and the time ``t`` where it occurs, are 0.

    Raises
    ------
    ModelError
        Lists every fault: no contact, contacts of one name or of another system, undeclared
        symbols in the domain, unknown names in the start.
    """

    name: str
    title: str
    source: str
    system: LagrangianSystem
    contacts: tuple[Contact, ...]
    domain: tuple[DomainBound, ...] = ()
    sketch: str = ""
    start: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        faults = list(self._faults())
        if faults:
            raise ModelError(f"mechanism {self.name!r}", faults)

    def __repr__(self) -> str:
        """Return name, coordinates and contacts."""
        coordinates = ", ".join(c.name for c in self.system.coordinates)
        names = ", ".join(c.name for c in self.contacts)
        several = "s" * (len(self.contacts) > 1)
        return f"Mechanism {self.name!r}: coordinates {coordinates}; contact{several} {names}"

    def __getstate__(self) -> dict[str, object]:
        """Pickle the definition too: in another process the cache is asked by the same text."""
        with suppress(TypeError):
            _ = self.definition
        return self.__dict__

    def _faults(self) -> Iterator[str]:
        if not self.contacts:
            yield "it has no contact; need at least one."
        different = {id(c): c.name for c in self.contacts}
        names = list(different.values())
        for name in sorted({n for n in names if names.count(n) > 1}):
            yield f"contact {name!r} is declared twice. Fix: give each its own name."
        for contact in self.contacts:
            if contact.system is not self.system:
                yield f"contact {contact.name!r} belongs to another system. Fix: give it this one."
        for i, bound in enumerate(self.domain, 1):
            yield from self.system.formula_faults(f"domain {i}", bound.margin)
        for name in self.start:
            if name not in self.state_names:
                yield "start: " + unknown_name("state", name, self.state_names)

    @property
    def contact(self) -> Contact:
        """The only contact; InputError when there are several."""
        if len(self.contacts) != 1:
            names = ", ".join(repr(c.name) for c in self.contacts)
            raise InputError(
                f"mechanism {self.name!r}: got {len(self.contacts)} contacts, need one here. "
                f"Fix: choose one of {names} (--contact, Mechanism.only); the others stay open."
            )
        return self.contacts[0]

    def only(self, name: str) -> Mechanism:
        """Return the mechanism with the named contact alone, as if the others were out of reach."""
        for contact in self.contacts:
            if contact.name == name:
                return replace(self, contacts=(contact,))
        known = [c.name for c in self.contacts]
        raise InputError(f"mechanism {self.name!r}: " + unknown_name("contact", name, known))

    def with_parameters(self, **values: float) -> Mechanism:
        """Return the mechanism with other defaults of its parameters; nothing is derived again.

        Parameters
        ----------
        **values : float
            By the parameter's name, in its unit.

        Raises
        ------
        InputError
            Unknown names, values out of range.

        Examples
        --------
        >>> from painleve_sym import models
        >>> rough = models.rod(mu=1.5)
        >>> rough.with_parameters(mu=1.2).parameters["mu"]
        1.2
        """
        where = f"mechanism {self.name!r}"
        parameters = with_defaults(where, self.system.parameters, values)
        system = with_fields(self.system, parameters=parameters)
        contacts = tuple(with_fields(c, system=system) for c in self.contacts)
        return with_fields(self, system=system, contacts=contacts)

    @property
    def parameters(self) -> dict[str, float]:
        """Default of every parameter by name, in its unit."""
        return {p.name: p.default for p in self.system.parameters}

    @cached_property
    def coefficients(self) -> ContactCoefficients:
        """Coefficients of the only contact."""
        return ContactCoefficients(self.contact)

    @cached_property
    def all_coefficients(self) -> tuple[ContactCoefficients, ...]:
        """Coefficients of every contact, each as if the others were open."""
        if len(self.contacts) == 1:
            return (self.coefficients,)
        return tuple(ContactCoefficients(c) for c in self.contacts)

    @cached_property
    def definition(self) -> str:
        """Everything its derivations start from, as one text (`definition_text`)."""
        return definition_text(self)

    @cached_property
    def depends_on_time(self) -> bool:
        """Whether the time itself occurs in any formula: something moves as prescribed."""
        system = self.system
        formulas = [system.kinetic_energy, system.potential_energy]
        formulas += [*system.generalized_forces.values(), *(b.margin for b in self.domain)]
        formulas += [f for c in self.contacts for f in (c.gap, c.slip_velocity)]
        return any(t in sp.sympify(f).free_symbols for t in system.clock for f in formulas)

    @property
    def motion(self) -> tuple[sp.Symbol, ...]:
        """Symbols of a state: coordinates, velocities, and `TIME` where anything depends on it."""
        clock = (TIME,) if self.depends_on_time else ()
        return (*self.system.q, *self.system.q_dot, *clock)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names a state may use: those of `motion`."""
        return tuple(s.name for s in self.motion)

    @cached_property
    def state_units(self) -> dict[str, str]:
        """SI unit of every state by name: those of `state_names`."""
        units = {c.name: c.unit for c in self.system.coordinates}
        units |= {f"{name}_dot": f"{unit}/s" for name, unit in units.items()}
        return units | ({TIME.name: "s"} if self.depends_on_time else {})

    @cached_property
    def units(self) -> dict[str, str]:
        """SI unit of every state and parameter by name."""
        return self.state_units | {p.name: p.unit for p in self.system.parameters}

    @cached_property
    def latex_names(self) -> dict[str, str]:
        """LaTeX of every state and parameter by name."""
        names = {c.name: c.latex or sp.latex(c.symbol) for c in self.system.coordinates}
        names |= {f"{name}_dot": derivative_latex(latex) for name, latex in names.items()}
        names |= {TIME.name: sp.latex(TIME)} if self.depends_on_time else {}
        return names | {p.name: sp.latex(p.symbol) for p in self.system.parameters}
