"""What softened and rigid simulators share: inputs, tolerances, and the trajectory they return."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.run import Array, Engine, RawRun, RunOptions
from painleve_sym.codegen.select import make_engine
from painleve_sym.errors import InputError, StopReason, unknown_name
from painleve_sym.hybrid.automaton import HybridAutomaton
from painleve_sym.hybrid.contact_states import GAP, GAP_RATE, SLIP, ContactStates
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import Parameter
from painleve_sym.simulate.inputs import (
    CONTACT_TOLERANCE,
    resolve_parameters,
    resolve_state,
    symbol_values,
)
from painleve_sym.simulate.trajectory import EventRecord, Trajectory

DEFAULT_RTOL = 1e-11
"""The reference impacts then hold eight digits through all events, energy closes to 1e-9."""


class ContactSimulator(ABC):
    """A mechanism with one contact, ready to run; build once, run often.

    Attributes
    ----------
    mechanism : Mechanism
    engine : {"auto", "compiled", "taylor", "erk"}
    """

    mechanism: Mechanism
    engine: str

    @property
    @abstractmethod
    def contact(self) -> ContactStates:
        """States of the contact."""

    @property
    @abstractmethod
    def automaton(self) -> HybridAutomaton:
        """The automaton that is run."""

    @property
    @abstractmethod
    def own_parameters(self) -> tuple[Parameter, ...]:
        """Parameters besides the mechanism's."""

    @property
    @abstractmethod
    def label(self) -> str:
        """Name of the contact law, for messages and results."""

    @property
    @abstractmethod
    def choices(self) -> dict[str, str]:
        """Named choices of the contact law."""

    @abstractmethod
    def contact_scale(self, values: Mapping[Any, float], kinetic: float) -> tuple[float, ...]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J) of the contact."""

    @cached_property
    def integrator(self) -> Engine:
        """The engine, compiled or taken from the cache on first use."""
        return make_engine(self.automaton, self.engine)

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
        symbols = (*self.automaton.parameters, *self.automaton.definitions)
        return dict(zip(symbols, map(float, c), strict=True))

    def _vector_of(self, parameters: Mapping[str, float]) -> Array:
        return np.array([parameters[s.name] for s in self.automaton.parameters])

    def initial_state(self, state: Mapping[str, float], parameters: Mapping[str, float]) -> Array:
        """Return the automaton's state vector for coordinates and velocities by name."""
        contact = self.mechanism.contact
        values = symbol_values(self.mechanism, state, parameters)
        derived = [contact.gap, contact.gap_rate, contact.slip_velocity]
        extra = dict(zip((GAP, GAP_RATE, SLIP), numbers(derived, values), strict=True))
        for s in (GAP, GAP_RATE):
            # Computed from q these cancel: a touching start must not become a tiny fall.
            extra[s] = 0.0 if abs(extra[s]) <= CONTACT_TOLERANCE else extra[s]
        return np.array([values.get(s, extra.get(s, 0.0)) for s in self.automaton.states])

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
            if kind not in self.automaton.kinds:
                message = unknown_name("event", kind, self.automaton.kinds)
                raise InputError(f"{self.where}: until: {message}")
        scale = self.tolerances(vector, parameters) if atol is None else np.asarray(atol) / rtol
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
        energy plus the energy of the contact; coordinates 1. Dissipated energies are left out
        (inf).
        """
        system = self.mechanism.system
        symbols: dict[Any, float] = dict(
            zip(self.automaton.states, map(float, vector), strict=True)
        )
        symbols |= self.constants(parameters)
        kinetic, W_tt = numbers([system.kinetic_energy, self.mechanism.coefficients.W_tt], symbols)
        masses = numbers([system.mass_matrix[i, i] for i in range(len(system.q))], symbols)
        delta, rate, energy = self.contact_scale(symbols, float(kinetic))
        scale: dict[Any, float] = dict.fromkeys(system.q, 1.0)
        scale |= {s: np.sqrt(2 * energy / m) for s, m in zip(system.q_dot, masses, strict=True)}
        scale[self.contact.slip] = np.sqrt(2 * energy * W_tt) or 1.0
        scale |= {self.contact.gap: delta, self.contact.gap_rate: rate}
        scale |= dict.fromkeys(self.automaton.uncontrolled, float("inf"))
        return np.array([scale[s] for s in self.automaton.states])

    def trajectory(self, raw: RawRun, values: dict[str, float], rtol: float) -> Trajectory:
        """Return the raw run as a trajectory."""
        automaton, nx = self.automaton, len(self.automaton.states)
        nz = len(automaton.memory)
        rows = (raw.steps.shape[1] - 4 - nz) // nx
        c = self.integrator.constants(self._vector_of(values))
        return Trajectory(
            mechanism=self.mechanism.name,
            law=self.label,
            choices=self.choices,
            parameters=values,
            state_names=tuple(s.name for s in automaton.states),
            memory_names=tuple(s.name for s in automaton.memory),
            mode_names=tuple(m.name for m in automaton.modes),
            output_names=automaton.output_names,
            step_time=raw.steps[:, 0],
            step_length=raw.steps[:, 1],
            step_mode=raw.steps[:, 2].astype(np.int64),
            step_memory=raw.steps[:, 3 : 3 + nz],
            step_rows=raw.steps[:, 3 + nz : -1].reshape(len(raw.steps), rows, nx),
            step_bend=raw.steps[:, -1],
            events=self._events(raw.events, c),
            final_time=raw.time,
            final_state=raw.state,
            final_memory=raw.memory,
            final_mode=raw.mode,
            stop_reason=raw.stop_reason,
            stop_detail=self._detail(raw),
            counters=raw.counters,
            engine=self.integrator.name,
            rtol=rtol,
            constants=c,
            evaluator=self.integrator,
        )

    def _events(self, rows: Array, constants: Array) -> tuple[EventRecord, ...]:
        automaton = self.automaton
        nx, nz = len(automaton.states), len(automaton.memory)
        before, memory = rows[:, 4 : 4 + nx], rows[:, 4 + nx : 4 + nx + nz]
        after = rows[:, 4 + nx + nz : 4 + 2 * nx + nz]
        modes = rows[:, 1].astype(np.int64)
        outputs = self.integrator.outputs(modes, before, memory, constants)
        at = {name: outputs[:, i] for i, name in enumerate(automaton.output_names)}
        return tuple(
            EventRecord(
                time=float(row[0]),
                kind=automaton.modes[modes[i]].transitions[int(row[2])].kind,
                mode_before=automaton.modes[modes[i]].name,
                mode_after=automaton.modes[int(row[3])].name,
                state={s.name: float(v) for s, v in zip(automaton.states, after[i], strict=True)},
                normal_force=float(at["normal_force"][i]),
                tangential_force=float(at["tangential_force"][i]),
                compression=float(at["compression"][i]),
            )
            for i, row in enumerate(rows)
        )

    def _detail(self, raw: RawRun) -> str:
        if raw.stop_reason is StopReason.LEFT_DOMAIN:
            mode = self.automaton.modes[raw.mode]
            label = mode.transitions[raw.stop_transition].label
            return self.mechanism.domain[int(label.rpartition("_")[2])].meaning
        ordinary = (StopReason.T_END, StopReason.UNTIL)
        return "" if raw.stop_reason in ordinary else raw.stop_reason.advice
