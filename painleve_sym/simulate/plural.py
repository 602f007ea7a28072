"""Motion of a mechanism with several contacts, each with a law of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contacts.automaton import PluralContacts
from painleve_sym.hybrid.automaton import HybridAutomaton
from painleve_sym.laws.compliance import ContactLaw
from painleve_sym.laws.rigid import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import Parameter
from painleve_sym.simulate.scales import compliant_scales, rigid_scales
from painleve_sym.simulate.simulator import ContactSimulator
from painleve_sym.simulate.trajectory import Trajectory


@dataclass(frozen=True)
class PluralSimulator(ContactSimulator):
    """A mechanism with several contacts, ready to run; build once, run often.

    Parameters
    ----------
    mechanism : Mechanism
    laws : tuple of (ContactLaw or RigidLaw)
        One for all contacts, or one for each in the mechanism's order; see `PluralContacts`.
    engine : {"auto", "compiled", "taylor", "erk"}
    """

    mechanism: Mechanism
    laws: tuple[ContactLaw | RigidLaw, ...]
    engine: str = "auto"

    @cached_property
    def contact(self) -> PluralContacts:
        """The contacts with their laws."""
        return PluralContacts(self.mechanism, self.laws)

    @property
    def automaton(self) -> HybridAutomaton:
        """The automaton that is run."""
        return self.contact.automaton

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the laws."""
        return self.contact.parameters

    @property
    def label(self) -> str:
        """Names of the laws."""
        return ", ".join(law.name for law in self.laws)

    @property
    def choices(self) -> dict[str, str]:
        """Named choices of the laws."""
        return {k: v for law in self.laws for k, v in law.choices.items()}

    def contact_scales(
        self, i: int, values: Mapping[Any, Array], numbers: Mapping[str, Array]
    ) -> tuple[Array, ...]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a contact."""
        law = self.contact.own_laws[i]
        if not isinstance(law, ContactLaw):
            return rigid_scales(numbers)
        curve = self._loading.at(values)
        stiffness, exponent = curve[f"stiffness_{i}"], curve[f"exponent_{i}"]
        gap = values[self.contact.rows[i].gap]
        return compliant_scales(numbers, gap, stiffness, exponent)

    def all_scales(
        self, values: Mapping[Any, Array], found: Sequence[Mapping[str, Array]]
    ) -> list[tuple[Array, ...]]:
        """Return `contact_scales` of every contact, all with the largest energy of any.

        A contact that hardly anything presses yet, such as a wall, is hit by what moves or presses
        the others: its free acceleration counts as a hundredth of theirs at least.
        """
        least = 0.01 * np.max([np.abs(numbers["b_n"]) for numbers in found], axis=0)
        pressed = [{**n, "b_n": np.maximum(np.abs(n["b_n"]), least)} for n in found]
        energy = np.zeros(1)
        for row, numbers, (*_, own) in zip(
            self.contact.rows, pressed, super().all_scales(values, pressed), strict=True
        ):
            idle = (numbers["kinetic_energy"] <= 0) & (numbers["b_n"] == 0)
            energy = np.maximum(energy, np.where(idle & (values[row.gap] >= 0), 0.0, own))
        energy = np.where(energy > 0, energy, 1.0)
        shared = [{**numbers, "kinetic_energy": energy} for numbers in pressed]
        return [(*scales[:2], energy) for scales in super().all_scales(values, shared)]

    def is_compliant(self, i: int) -> bool:
        """Whether a contact may start compressed."""
        return isinstance(self.contact.own_laws[i], ContactLaw)

    @cached_property
    def _loading(self) -> Quantities:
        laws = self.contact.own_laws
        symbols = (*self.outline.parameters, *self.outline.definitions)
        return quantities(
            "loading curves",
            self.contact,
            symbols,
            lambda: {
                f"{name}_{i}": getattr(law, name)
                for i, law in enumerate(laws)
                for name in ("stiffness", "exponent")
                if isinstance(law, ContactLaw)
            },
        )

    def run(
        self,
        state: Mapping[str, float],
        *,
        parameters: Mapping[str, float] | None = None,
        **options: Any,
    ) -> Trajectory:
        """Integrate the motion from t = 0; see `SoftenedSimulator.run` for the options."""
        vector, values = self.start(state, parameters)
        checked = self.options(vector, values, **options)
        raw = self.integrator.run(vector, self._vector_of(values), checked)
        return self.trajectory(raw, values, checked.rtol)

    def event_outputs(self, contact: str) -> tuple[str, str]:
        """Return the name of the contact of an event and what its outputs' names end in."""
        return contact, f"_{contact or self.mechanism.contacts[0].name}"
