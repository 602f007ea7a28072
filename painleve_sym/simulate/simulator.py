"""What softened and rigid simulators share: inputs, tolerances, and the trajectory they return."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.quantities import Quantities
from painleve_sym.contacts.contact_numbers import (
    characteristic_length,
    contact_numbers,
    contact_tolerances,
)
from painleve_sym.contacts.contact_states import ContactRow
from painleve_sym.contacts.inputs import resolve_parameters, resolve_state, symbol_values
from painleve_sym.engines.factory import make_engine
from painleve_sym.engines.protocol import Engine, RawRun, RunOptions
from painleve_sym.engines.records import EventRecords
from painleve_sym.errors import InputError, StopReason, unknown_name
from painleve_sym.hybrid.automaton import HybridAutomaton
from painleve_sym.hybrid.signature import AutomatonBuilder, Outline, mode_name
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import TIME, Parameter
from painleve_sym.simulate.trajectory import EventRecord, Trajectory

if TYPE_CHECKING:
    from painleve_sym.simulate.sensitivity.result import SensitiveTrajectory

DEFAULT_RTOL = 1e-11
"""The reference impacts then hold eight digits through all events, energy closes to 1e-9."""


class Contacts(AutomatonBuilder, Protocol):
    """What a simulator asks of its contacts: what derives their automaton, rows, parameters."""

    @property
    def rows(self) -> tuple[ContactRow, ...]:
        """States of each contact."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the laws."""


class ContactSimulator(ABC):
    """A mechanism with its contacts, ready to run; build once, run often.

    Attributes
    ----------
    mechanism : Mechanism
    engine : {"auto", "compiled", "taylor", "erk"}
    """

    mechanism: Mechanism
    engine: str

    @property
    def start_events(self) -> bool:
        """Whether what a start makes happen at once are events, or only chooses the mode."""
        return False

    @property
    @abstractmethod
    def contact(self) -> Contacts:
        """The contact or contacts."""

    @property
    def automaton(self) -> HybridAutomaton:
        """The automaton that is run."""
        return self.contact.automaton

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """Parameters besides the mechanism's: those of the laws."""
        return self.contact.parameters

    @property
    @abstractmethod
    def label(self) -> str:
        """Name of the contact law, for messages and results."""

    @property
    @abstractmethod
    def choices(self) -> dict[str, str]:
        """Named choices of the contact law."""

    def is_compliant(self, i: int) -> bool:
        """Whether a contact may start compressed."""
        return False

    @abstractmethod
    def contact_scales(
        self, i: int, values: Mapping[Any, Array], numbers: Mapping[str, Array]
    ) -> tuple[Array, ...]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a contact.

        Parameters
        ----------
        i : int
            Which of the contacts.
        values : mapping of sympy.Symbol to ndarray, shape (n,)
            States, parameters and definitions.
        numbers : mapping of str to ndarray, shape (n,)
            What `contact_numbers` of the contact gives at them.
        """

    @abstractmethod
    def run(self, state: Mapping[str, float], **options: Any) -> Trajectory:
        """Integrate from t = 0."""

    @cached_property
    def integrator(self) -> Engine:
        """The engine, compiled or taken from the cache on first use."""
        return make_engine(self.builder, self.engine)

    @property
    def builder(self) -> AutomatonBuilder:
        """What derives the automaton that is run; only asked where the cache lacks the engine."""
        return self.contact

    @property
    def outline(self) -> Outline:
        """Names and structure of the automaton, known without deriving it."""
        return self.integrator.outline

    @property
    def where(self) -> str:
        """What messages name as the place of a fault."""
        return f"{self.mechanism.name!r} with law {self.label!r}"

    def parameters(self, given: Mapping[str, float] | None = None) -> dict[str, float]:
        """Return all parameters of mechanism and law with `given` put in, checked."""
        declared = (*self.mechanism.system.parameters, *self.own_parameters)
        return resolve_parameters(self.where, declared, given or {})

    def constants(self, parameters: Mapping[str, float]) -> dict[Any, float]:
        """Return the values of all parameter symbols and definitions."""
        c = self.integrator.constants(self._vector_of(parameters))
        symbols = (*self.outline.parameters, *self.outline.definitions)
        return dict(zip(symbols, map(float, c), strict=True))

    def _vector_of(self, parameters: Mapping[str, float]) -> Array:
        return np.array([parameters[s.name] for s in self.outline.parameters])

    def initial_state(self, state: Mapping[str, float], parameters: Mapping[str, float]) -> Array:
        """Return the automaton's state vector for coordinates and velocities by name."""
        values = symbol_values(self.mechanism, state, parameters)
        arrays = {s: np.array([v]) for s, v in values.items()}
        vector: Array = self.initial_states(arrays, self.contact_values(arrays))[0]
        return vector

    @cached_property
    def _contact_numbers(self) -> tuple[Quantities, ...]:
        return tuple(contact_numbers(self.mechanism, i) for i in range(len(self.contact.rows)))

    def contact_values(self, values: Mapping[Any, Array]) -> list[dict[str, Array]]:
        """Return `contact_numbers` of each contact at n points, arrays of shape (n,).

        Parameters
        ----------
        values : mapping of sympy.Symbol to ndarray, shape (n,)
            Of coordinates, velocities and parameters.
        """
        return [numbers.at(values) for numbers in self._contact_numbers]

    def initial_states(
        self, values: Mapping[Any, Array], numbers: Sequence[Mapping[str, Array]]
    ) -> Array:
        """Return state vectors, shape (n, nx), for coordinates, velocities and parameters.

        Parameters
        ----------
        values : mapping of sympy.Symbol to ndarray, shape (n,)
        numbers : sequence of dict
            `contact_values` there.
        """
        extra: dict[Any, Array] = {}
        for row, found in zip(self.contact.rows, numbers, strict=True):
            derived = [found[name] for name in ("gap", "gap_rate", "slip_velocity")]
            extra |= dict(zip(row.symbols, derived, strict=True))
            for s, tolerance in zip(
                (row.gap, row.gap_rate), contact_tolerances(found), strict=True
            ):
                # Computed from q these cancel: a touching start must not become a tiny fall.
                extra[s] = np.where(np.abs(extra[s]) <= tolerance, 0.0, extra[s])
        zero = np.zeros(len(next(iter(values.values()))))
        columns = [values.get(s, extra.get(s, zero)) for s in self.outline.states]
        vectors: Array = np.array(columns).T.copy()
        return vectors

    def checked_start(self, vector: Array, values: Mapping[str, float], force: Any) -> Array:
        """Return the start vector under an initial force, or as it is where `force` is None."""
        if force is not None:
            raise InputError(
                f"{self.where}: initial_force: a rigid contact has no compression. "
                "Fix: leave it out, or give a contact law."
            )
        return vector

    def start_expressions(self, forced: bool) -> dict[Any, Any]:
        """Return the start values that follow from other ones: states to SymPy expressions.

        Where `forced`, the compression is the one that carries the symbol ``initial_force``.
        """
        own = set(self.mechanism.motion)
        return {
            symbol: expr
            for row in self.contact.rows
            for symbol, expr in zip(row.symbols, row.expressions, strict=True)
            if symbol not in own
        }

    def sensitivities(
        self, state: Mapping[str, float], wrt: Sequence[str], **options: Any
    ) -> SensitiveTrajectory:
        """Integrate the motion together with its first derivatives, through every event.

        Parameters
        ----------
        state : mapping of str to float
        wrt : sequence of str
            Directions: names of coordinates and velocities (their start values), of parameters of
            mechanism and law, and ``initial_force`` where that is given.
        **options
            Those of `run`.

        Returns
        -------
        SensitiveTrajectory
            A start on the surface is differentiated within the mode that it starts in.

        Raises
        ------
        InputError
            As for `run`; unknown names of directions.
        """
        from painleve_sym.simulate.sensitivity.variational import differentiated

        return differentiated(self, state, tuple(wrt), **options)

    @cached_property
    def variational_engines(self) -> dict[Any, Any]:
        """Engines of state and derivatives, by direction; filled when used."""
        return {}

    def options(
        self,
        vector: Array,
        parameters: Mapping[str, float],
        *,
        t_end: float,
        until: str | tuple[str, ...] = (),
        rtol: float = DEFAULT_RTOL,
        atol: Array | None = None,
        record: str = "dense",
        **limits: Any,
    ) -> RunOptions:
        """Return checked options of a run from the state `vector`; see `run`."""
        if not (np.isfinite(t_end) and t_end > 0):
            raise InputError(f"{self.where}: t_end: got {t_end!r}, need a finite number > 0.")
        kinds = (until,) if isinstance(until, str) else tuple(until)
        for kind in kinds:
            if kind not in self.outline.kinds:
                message = unknown_name("event", kind, self.outline.kinds)
                raise InputError(f"{self.where}: until: {message}")
        scale = self.tolerances(vector, parameters) if atol is None else np.asarray(atol) / rtol
        limits = {"start_events": self.start_events, **limits}
        return RunOptions(t_end, rtol, rtol * scale, kinds, record, **limits)

    def start(
        self, state: Mapping[str, float], parameters: Mapping[str, float] | None
    ) -> tuple[Array, dict[str, float]]:
        """Return the checked state vector and all parameters."""
        values = self.parameters(parameters)
        for symbol, value in self.constants(values).items():
            if not np.isfinite(value):
                raise InputError(
                    f"{self.where}: {symbol} comes out as {value!r}, need a finite number. "
                    "Fix: check the parameters it is made of (stiffness, curvatures)."
                )
        return self.initial_state(resolve_state(self.mechanism, state, values), values), values

    def tolerances(self, vector: Array, parameters: Mapping[str, float]) -> Array:
        """Return the scale of each state below which only its absolute error counts, shape (nx,).

        Gap and its rate have the scales of the contact; other velocities that of the kinetic
        energy plus the energy of the contact; coordinates in m the `characteristic_length`, angles
        1, and the time that length over the speed of the energy. Dissipated energies are left out
        (inf).
        """
        constants = self.integrator.constants(self._vector_of(parameters))
        vectors, constants = np.asarray(vector)[None], constants[None]
        found = self.contact_values(self.at_states(vectors, constants))
        scale: Array = self.all_tolerances(vectors, constants, found)[0]
        return scale

    def closed_within(
        self, vector: Array, parameters: Mapping[str, float]
    ) -> list[tuple[float, float]]:
        """Return gap and gap rate up to which each contact is closed (`contact_tolerances`)."""
        constants = self.integrator.constants(self._vector_of(parameters))
        found = self.contact_values(self.at_states(np.asarray(vector)[None], constants[None]))
        pairs = [contact_tolerances(numbers) for numbers in found]
        return [(float(near.item()), float(slow.item())) for near, slow in pairs]

    def at_states(self, vectors: Array, constants: Array) -> dict[Any, Array]:
        """Return the values of all symbols, shape (n,), for n states and constants (n, nc)."""
        given = (*self.outline.parameters, *self.outline.definitions)
        states = dict(zip(self.outline.states, vectors.T, strict=True))
        return states | dict(zip(given, constants.T, strict=True))

    def all_tolerances(
        self, vectors: Array, constants: Array, found: Sequence[Mapping[str, Array]]
    ) -> Array:
        """Return what `tolerances` returns for n states, constants (n, nc) and `contact_values`."""
        system = self.mechanism.system
        symbols, rows = self.at_states(vectors, constants), self.contact.rows
        scales = self.all_scales(symbols, found)
        energy = np.maximum.reduce([own[2] for own in scales])
        length, ones = characteristic_length(found[0]), np.ones(len(vectors))
        masses = [found[0][f"mass_{k}"] for k in range(len(system.q))]
        scale: dict[Any, Array] = {
            c.symbol: length if c.unit == "m" else ones for c in system.coordinates
        }
        scale[TIME] = length / np.sqrt(2 * energy * found[0]["W_nn"])
        scale |= {s: np.sqrt(2 * energy / m) for s, m in zip(system.q_dot, masses, strict=True)}
        for row, numbers, (delta, rate, _) in zip(rows, found, scales, strict=True):
            slip = np.sqrt(2 * energy * numbers["W_tt"])
            scale[row.slip] = np.where(slip == 0, np.sqrt(2 * energy * numbers["W_nn"]), slip)
            scale |= {row.gap: delta, row.gap_rate: rate}
        scale |= dict.fromkeys(self.outline.uncontrolled, np.full(len(vectors), np.inf))
        tolerances: Array = np.array([scale[s] for s in self.outline.states]).T.copy()
        return tolerances

    def all_scales(
        self, values: Mapping[Any, Array], found: Sequence[Mapping[str, Array]]
    ) -> list[tuple[Array, ...]]:
        """Return `contact_scales` of every contact."""
        return [self.contact_scales(i, values, numbers) for i, numbers in enumerate(found)]

    def trajectory(self, raw: RawRun, values: dict[str, float], rtol: float) -> Trajectory:
        """Return the raw run as a trajectory."""
        automaton, steps = self.outline, raw.step_records
        c = self.integrator.constants(self._vector_of(values))
        memory = np.vstack([steps.memory, raw.memory])
        modes = np.append(steps.mode, raw.mode)
        names, modes = self._named(modes, memory)
        return Trajectory(
            mechanism=self.mechanism.name,
            law=self.label,
            choices=self.choices,
            parameters=values,
            state_names=tuple(s.name for s in automaton.states),
            memory_names=tuple(s.name for s in automaton.memory),
            mode_names=names,
            output_names=automaton.output_names,
            step_time=steps.time,
            step_length=steps.length,
            step_mode=modes[:-1],
            step_memory=steps.memory,
            step_rows=steps.polynomial,
            step_bend=steps.bend,
            events=self._events(raw.event_records, c),
            final_time=raw.time,
            final_state=raw.state,
            final_memory=raw.memory,
            final_mode=int(modes[-1]),
            stop_reason=raw.stop_reason,
            stop_detail=self._detail(raw),
            counters=raw.counters,
            engine=self.integrator.name,
            rtol=rtol,
            constants=c,
            evaluator=self.integrator,
        )

    def _named(self, modes: Array, memory: Array) -> tuple[tuple[str, ...], Array]:
        """Return names of modes, and the index of each of n modes among them."""
        automaton = self.outline
        if not automaton.parts:
            return tuple(m.name for m in automaton.modes), modes
        every = [mode_name(automaton, int(m), z) for m, z in zip(modes, memory, strict=True)]
        names = tuple(dict.fromkeys(every))
        return names, np.array([names.index(name) for name in every])

    def _events(self, rows: EventRecords, constants: Array) -> tuple[EventRecord, ...]:
        automaton = self.outline
        names = [s.name for s in automaton.states]
        outputs = self.integrator.outputs(
            rows.mode_before, rows.state_before, rows.memory_before, constants
        )
        at = {name: outputs[:, i] for i, name in enumerate(automaton.output_names)}
        own = [c.name for c in self.mechanism.contacts]
        records = []
        for i, after in enumerate(rows.state_after.tolist()):
            place = int(rows.contact[i])
            contact = automaton.contacts[place] if place >= 0 else ""
            end = f"_{contact or own[0]}" if len(own) > 1 else ""
            # A decision for several contacts at once has no force of its own.
            decided = place < 0 and rows.transition[i] < 0
            carried = ("normal_force", "tangential_force", "gap")
            force, friction, gap = (0.0 if decided else float(at[f"{n}{end}"][i]) for n in carried)
            records.append(
                EventRecord(
                    time=float(rows.time[i]),
                    kind=automaton.kinds[rows.kind[i]],
                    mode_before=mode_name(
                        automaton, int(rows.mode_before[i]), rows.memory_before[i]
                    ),
                    mode_after=mode_name(automaton, int(rows.mode_after[i]), rows.memory_after[i]),
                    state=dict(zip(names, after, strict=True)),
                    normal_force=force,
                    tangential_force=friction,
                    compression=-gap,
                    contact=contact if len(own) > 1 else own[0],
                )
            )
        return tuple(records)

    def _detail(self, raw: RawRun) -> str:
        if raw.stop_reason is StopReason.LEFT_DOMAIN:
            mode = self.outline.modes[raw.mode]
            bound = mode.transitions[raw.stop_transition].bound
            return self.mechanism.domain[bound].meaning if bound is not None else ""
        ordinary = (StopReason.T_END, StopReason.UNTIL)
        return "" if raw.stop_reason in ordinary else raw.stop_reason.advice
