"""Motion of a mechanism with several contacts, each with a law of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contacts.automaton import PluralContacts
from painleve_sym.contacts.problem import ContactProblem
from painleve_sym.contacts.terms import ContactImpacts, rows_of
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.errors import EventKind, InputError, StopReason
from painleve_sym.laws.compliance import ContactLaw
from painleve_sym.laws.rigid import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.simulate.impact_resolver import ImpactResolver
from painleve_sym.simulate.scales import compliant_scales, rigid_scales
from painleve_sym.simulate.simulator import ContactSimulator
from painleve_sym.simulate.trajectory import EventRecord, Trajectory

_JAM = (
    "the impact of the rigid contacts has no end: their friction carries any impulse, or leaves "
    "none possible; use one contact at a time, or a softened law"
)


@dataclass(frozen=True)
class PluralSimulator(ContactSimulator):
    """A mechanism with several contacts, ready to run; build once, run often.

    Between impacts everything happens in compiled code: at an event every combination of what the
    closed contacts may do is held against their contact problem, and where several motions are
    possible the policy of the rigid law chooses; the event ``contact`` lists all. Rigid contacts
    that touch down, or for which no forces are possible, have an impact, which follows the path of
    `solve_simultaneous_impact`, in compiled code too; the event ``impact`` has the impulses.

    Parameters
    ----------
    mechanism : Mechanism
    laws : tuple of (ContactLaw or RigidLaw)
        One for all contacts, or one for each in the mechanism's order; see `PluralContacts`.
    engine : {"auto", "compiled", "taylor"}

    Raises
    ------
    InputError
        Laws that do not go together; see `PluralContacts`.
    """

    mechanism: Mechanism
    laws: tuple[ContactLaw | RigidLaw, ...]
    engine: str = "auto"

    def __post_init__(self) -> None:
        _ = self.contact  # refuses laws that do not go together

    @property
    def start_events(self) -> bool:
        """Whether what a start makes happen at once are events: where a contact is rigid."""
        return bool(self.impacts.rigid)

    @cached_property
    def contact(self) -> PluralContacts:
        """The contacts with their laws."""
        return PluralContacts(self.mechanism, self.laws)

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

    @property
    def loading_curves(self) -> list[Any]:
        """Stiffness and exponent of each contact's loading curve, 0 of a rigid one, in turn."""
        curves = [
            (law.stiffness, law.exponent) if isinstance(law, ContactLaw) else (0, 0)
            for law in self.contact.own_laws
        ]
        return [entry for curve in curves for entry in curve]

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

    @cached_property
    def impacts(self) -> ContactImpacts:
        """Impacts of the rigid contacts."""
        rigid = tuple(
            i
            for i, law in enumerate(self.contact.own_laws)
            if isinstance(law, RigidLaw) or self.mechanism.contacts[i].bilateral
        )
        return ContactImpacts(self.mechanism, self.outline.states, self.contact.rows, rigid)

    def checked_start(self, vector: Array, values: Mapping[str, float], force: Any) -> Array:
        """Return the start vector where no rigid contact is inside its surface."""
        gaps, _, _ = self.impacts.contact_values(vector)
        within = self.closed_within(vector, values)
        for i in self.impacts.rigid:
            contact = self.mechanism.contacts[i]
            if contact.bilateral and abs(gaps[i]) > within[i][0]:
                raise InputError(
                    f"{self.where}: contact {contact.name!r} holds from both sides and starts off "
                    f"its guide, gap = {gaps[i]:g} m. Fix: start with gap 0."
                )
            if gaps[i] < 0:
                raise InputError(
                    f"{self.where}: contact {contact.name!r} starts inside the ground, gap = "
                    f"{gaps[i]:g} m, and a rigid contact has no compression. "
                    "Fix: start with gap >= 0."
                )
        if force is not None:
            raise InputError(
                f"{self.where}: initial_force: several contacts share no force. Fix: give the "
                "compression of each by the state."
            )
        return vector

    def run(
        self,
        state: Mapping[str, float],
        *,
        parameters: Mapping[str, float] | None = None,
        initial_force: float | None = None,
        **options: Any,
    ) -> Trajectory:
        """Integrate the motion from t = 0; see `SoftenedSimulator.run` for the options.

        Returns
        -------
        Trajectory
            Also when it stopped early: `stop_reason` says why. Forces and gaps of each contact are
            the outputs ``normal_force_<contact>``, …; where the bodies' rigidity leaves forces
            open, contacts share them in proportion to what their friction carries.
        """
        vector, values = self.start(state, parameters)
        vector = self.checked_start(vector, values, initial_force)
        checked = self.options(vector, values, **options)
        p = self._vector_of(values)
        compiled = isinstance(self.integrator, CompiledEngine) or not self.impacts.rigid
        resolver = ImpactResolver(self, values, checked.atol / checked.rtol)
        raw = self.integrator.run(vector, p, checked, resolve=None if compiled else resolver)
        trajectory = self.trajectory(raw, values, checked.rtol)
        if not self.impacts.rigid:
            return trajectory
        # The last entries of the memory are the impulses of the last impact.
        impulses = raw.event_records.memory_after[:, -2 * len(self.contact.rows) :].tolist()
        for i, told in zip(
            np.flatnonzero(raw.event_records.transition < 0), resolver.impulses, strict=False
        ):
            impulses[i] = told
        events = tuple(
            replace(e, impulses=tuple(given))
            if e.kind is EventKind.IMPACT
            else self._with_alternatives(e, values)
            for e, given in zip(trajectory.events, impulses, strict=True)
        )
        detail = _JAM if raw.stop_reason is StopReason.JAM else trajectory.stop_detail
        return replace(trajectory, events=events, stop_detail=detail)

    def _with_alternatives(self, event: EventRecord, values: Mapping[str, float]) -> EventRecord:
        """Return the event of a contact problem with all solutions, where there are several."""
        if event.kind is not EventKind.CONTACT:
            return event
        state = np.array([event.state[s.name] for s in self.outline.states])
        gaps, rates, slips = self.impacts.contact_values(state)
        closed = [i for i in self.impacts.rigid if gaps[i] <= 0 and rates[i] == 0]
        if len(self.impacts.rigid) < len(gaps) or not closed:
            return event
        terms, rows = self.impacts.terms(state, values), rows_of(closed)
        held = np.array([self.mechanism.contacts[i].bilateral for i in closed])
        problem = ContactProblem(
            terms.W[np.ix_(rows, rows)], terms.b[rows], terms.mu[closed], slips[closed], held
        )
        solutions = problem.solutions()
        if len(solutions) < 2:
            return event
        names = []
        for solution in solutions:
            modes = ["flight"] * len(gaps)
            for i, mode in zip(closed, solution.modes, strict=True):
                modes[i] = "flight" if mode.value == "liftoff" else mode.value
            names.append(" + ".join(modes))
        several = (*dict.fromkeys(names), "impact")
        return replace(event, alternatives=several) if len(several) > 2 else event
