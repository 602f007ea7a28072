"""A mechanism with its contact laws: names, parameters, and the engine that runs them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.automata.derivation import ContactDerivation
from painleve_sym.automata.signature import Outline
from painleve_sym.automata.watch import read_watch, watch_texts
from painleve_sym.checks import number
from painleve_sym.choices import EngineLike, EngineName, chosen
from painleve_sym.codegen.named_mechanisms import MechanismLike, as_mechanism
from painleve_sym.codegen.quantities import quantities
from painleve_sym.codegen.tape import TapeOutputs, output_tapes
from painleve_sym.engines.factory import SOURCES, make_engine
from painleve_sym.engines.protocol import Engine
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.laws.catalogue import Law, LawsLike, as_law, choices_by_contact
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.mechanics.declarations import TIME_NAME, Parameter, ParameterSet
from painleve_sym.mechanics.materials import (
    Material,
    MaterialsLike,
    material_values,
    two_materials,
)
from painleve_sym.mechanics.mechanism import Mechanism, Place
from painleve_sym.motion.records import MotionNames
from painleve_sym.units import Value

if TYPE_CHECKING:
    from painleve_sym.automata.automaton import HybridAutomaton


_FIELDS = ("mechanism", "law", "engine", "watch")


class Start(NamedTuple):
    """Start of a run: its place, its state and parameters in the engine's order, and its scale.

    Below the scale of a state, shape (nx,), only its absolute error counts. The place is not yet
    pressed by the initial force, N, which is negative where there is none. `materials` are those of
    both bodies, where they are given. A motion that continues another one begins at its time, s,
    and with the same laws in its mode with its memory; -1 and None where these follow from the
    state.
    """

    place: Place
    state: Array
    parameters: Array
    scale: Array
    force: float
    materials: tuple[Material, Material] | None = None
    time: float = 0.0
    mode: int = -1
    memory: Array | None = None


@dataclass(frozen=True, init=False)
class MechanismWithLaws:
    """Names, parameters and numbers of a mechanism with its laws; a `Simulator` runs it."""

    mechanism: Mechanism
    law: Law | Mapping[str, Law] = field(hash=False)
    engine: EngineLike = EngineName.AUTO
    watch: tuple[str, ...] = ()

    def __init__(
        self,
        mechanism: MechanismLike,
        law: LawsLike,
        engine: EngineLike = EngineName.AUTO,
        watch: str | Sequence[str] = (),
    ) -> None:
        name = chosen(EngineName, engine, "engine")
        values = {
            "mechanism": as_mechanism(mechanism),
            "law": as_law(law),
            "engine": name,
            "watch": watch_texts(watch),
        }
        for attribute, value in values.items():
            object.__setattr__(self, attribute, value)
        self.mechanism.require_planar()
        _ = self.contact  # rejects laws that do not fit the contacts, or each other

    def __getstate__(self) -> dict[str, Any]:
        """Pickle mechanism, law and engine name; the engine comes from the cache again."""
        return {name: self.__dict__[name] for name in _FIELDS}

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """One law for all contacts, or one for each in the mechanism's order."""
        if not isinstance(self.law, Mapping):
            return (self.law,)
        names = [c.name for c in self.mechanism.outline.contacts]
        for name in self.law:
            refuse_unknown("contact", name, names, f"mechanism {self.mechanism.name!r}: law")
        for name in names:
            if name not in self.law:
                raise InputError(
                    f"mechanism {self.mechanism.name!r}: law: contact {name!r} has none. "
                    "Fix: give each contact its law."
                )
        return tuple(self.law[name] for name in names)

    @cached_property
    def contact(self) -> ContactDerivation:
        """The contact or contacts, joined with their laws."""
        contacts = [c.name for c in self.mechanism.outline.contacts]
        watches = read_watch(self.watch, contacts, self.where)
        return ContactDerivation(self.mechanism, self.laws, watches)

    @property
    def automaton(self) -> HybridAutomaton:
        """The automaton that is run."""
        return self.contact.automaton

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the laws, besides the mechanism's."""
        return self.contact.parameters

    @property
    def label(self) -> str:
        """Names of the laws, for messages and results."""
        return ", ".join(law.name for law in self.laws)

    @cached_property
    def where(self) -> str:
        """Place of a fault, as messages name it."""
        return f"{self.mechanism.name!r} with law {self.label!r}"

    @property
    def source(self) -> str:
        """Works on the mechanism, the laws and the integrator."""
        texts = [self.mechanism.source, *(law.source for law in self.laws)]
        return "; ".join([*texts, SOURCES[EngineName(self.integrator.name)]])

    @property
    def choices(self) -> dict[str, str]:
        """Named choices of the laws that contacts follow; guides have a policy alone."""
        names = (c.name for c in self.mechanism.outline.contacts)
        return choices_by_contact(dict(zip(names, self.contact.own_laws, strict=True)))

    @property
    def contact_law(self) -> ContactLaw:
        """The compliant law of the only contact.

        Raises
        ------
        InputError
            A rigid contact, or several contacts.
        """
        law, *more = self.contact.own_laws
        if more or not law.is_compliant:
            raise InputError(
                f"{self.where}: need one contact with a compliant law. Fix: take such a law, and "
                "one contact of several (Mechanism.only)."
            )
        return law

    @cached_property
    def restitutions(self) -> tuple[str, ...]:
        """Names of the coefficients of restitution of compliant contacts."""
        laws = self.contact.compliant.values()
        names = dict.fromkeys(p.name for law in laws for p in law.parameters)
        return tuple(n for n in names if n.startswith("e_energetic"))

    @cached_property
    def rigid(self) -> tuple[int, ...]:
        """Indices of the contacts that do not yield: rigid ones and guides."""
        return self.contact.rigid

    @property
    def start_events(self) -> bool:
        """Whether transitions at the start are recorded as events: where a contact is rigid."""
        return bool(self.rigid)

    @cached_property
    def strikes(self) -> bool:
        """Whether several contacts can have an impact: at least one of them is rigid."""
        return self.contact.several and bool(self.rigid)

    @cached_property
    def declared(self) -> ParameterSet:
        """The parameters of mechanism and laws."""
        return ParameterSet(*self.mechanism.outline.parameters, *self.own_parameters)

    def parameters(self, given: Mapping[str, Value] | None = None) -> dict[str, float]:
        """Return all parameters of mechanism and law, those in `given` replaced, checked."""
        return self.declared.values(self.where, given)

    @property
    def units(self) -> dict[str, str]:
        """SI unit of every state and parameter, also of the laws, by name."""
        own = {p.name: p.unit for p in self.own_parameters}
        # A strobe has the time among the states.
        return (
            {TIME_NAME: "s", **self.mechanism.units, **own}
            if self.watch
            else {**self.mechanism.units, **own}
        )

    @cached_property
    def integrator(self) -> Engine:
        """The engine, compiled or taken from the cache on first use."""
        if self.mechanism.outline.pulsed:
            raise InputError(
                f"{self.where}: its formulas have pulses, at whose edges a motion is cut, which "
                "simulate, batches, sweeps and fits do and nothing else. Fix: use one of these, or "
                "make the pulse a parameter."
            )
        return make_engine(self.contact, self.engine)

    @property
    def outline(self) -> Outline:
        """Names and structure of the automaton, known without deriving it."""
        return self.integrator.outline

    def constants(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the values of all parameters and definitions by name."""
        c = self.integrator.constants(self._vector_of(parameters))
        return dict(zip(self.outline.constant_names, map(float, c), strict=True))

    def _vector_of(self, parameters: Mapping[str, float]) -> Array:
        return np.array([parameters[name] for name in self._order])

    @cached_property
    def _order(self) -> tuple[str, ...]:
        """Names of the parameters in the engine's order."""
        return self.outline.parameter_names

    def loading_curve(self, values: Mapping[str, Array], i: int = 0) -> tuple[Array, Array]:
        """Return K and n of a compliant contact's loading curve K δⁿ, each of shape (n,)."""

        def derive() -> tuple[dict[str, Any], tuple[Any, ...]]:
            curves = {
                f"{name}_{k}": getattr(law, name)
                for k, law in self.contact.compliant.items()
                for name in ("stiffness", "exponent")
            }
            return curves, (*self.automaton.parameters, *self.automaton.definitions)

        names, definition = self.outline.constant_names, self.contact.definition
        curve = quantities("loading curves", definition, names, derive).at(values)
        return curve[f"stiffness_{i}"], curve[f"exponent_{i}"]

    def loading_constants(self, parameters: Mapping[str, float]) -> tuple[float, float]:
        """Return K and n of the loading curve K δⁿ of the only contact; see `contact_law`."""
        _ = self.contact_law  # rejects laws without a loading curve
        values = {s: np.array([v]) for s, v in self.constants(parameters).items()}
        k, n = (float(v[0]) for v in self.loading_curve(values))
        return k, n

    def compression_of_force(self, force: Value, parameters: Mapping[str, float]) -> float:
        """Return δ₀ > 0 with F_n(δ₀) = `force` on the loading curve at rest; m.

        The initial surface energy of the paper, (10), is given this way.
        """
        force = number(force, "initial force", where=self.where, unit="N", lower=0.0)
        k, n = self.loading_constants(parameters)
        return float((force / k) ** (1 / n))

    def values_of_materials(
        self, materials: MaterialsLike, given: Mapping[str, Any] | None = None
    ) -> dict[str, float]:
        """Return the values that materials give to parameters of mechanism and laws.

        Parameters
        ----------
        materials : Material or its name, or two
            That of both bodies in contact, or those of the moving body and of the other:
            ``steel,rubber``.
        given : mapping of str to object
            Parameters that have their values, and are left out.

        Raises
        ------
        InputError
            Unknown names, a property that a material lacks.
        """
        pair, known = two_materials(materials), given or {}
        declared, law = self.mechanism.outline.parameters, f"law {self.label!r}"
        return {
            **material_values(self.where, pair, declared, known),
            **material_values(law, pair, self.own_parameters, known),
        }

    @cached_property
    def output_tapes(self) -> TapeOutputs:
        """Outputs of the automaton as plain operations, from the cache where it has them."""
        return output_tapes(self.contact)

    @cached_property
    def names(self) -> MotionNames:
        """Names that all motions of the simulator share."""
        outline = self.outline
        return MotionNames(
            mechanism=self.mechanism.name,
            law=self.label,
            choices=self.choices,
            states=outline.state_names,
            memory=outline.memory_names,
            outputs=outline.output_names,
            engine=self.integrator.name,
            contacts=tuple(c.name for c in self.mechanism.outline.contacts),
            units=self.units,
            latex=self.mechanism.latex_names,
            source=self.source,
        )
