"""Softened motion: one frictional contact with a force–compression law, over generated modes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.run import DENSE_ROWS, Array, Engine, RawRun, RunOptions
from painleve_sym.codegen.select import make_engine
from painleve_sym.errors import InputError, StopReason, unknown_name
from painleve_sym.hybrid.contact_states import GAP, GAP_RATE, SLIP
from painleve_sym.hybrid.softened import SoftenedContact
from painleve_sym.laws.compliance import ContactLaw
from painleve_sym.mechanics.models import Mechanism
from painleve_sym.simulate.inputs import resolve_parameters, resolve_state, symbol_values
from painleve_sym.simulate.trajectory import EventRecord, Trajectory

DEFAULT_RTOL = 1e-11
"""The reference impacts then hold eight digits through all events, energy closes to 1e-9."""


@dataclass(frozen=True)
class SoftenedSimulator:
    """A mechanism with a contact law, ready to run; build once, run often.

    Parameters
    ----------
    mechanism : Mechanism
        With exactly one contact.
    law : ContactLaw
    engine : {"auto", "compiled", "erk"}
        ``auto``: compiled code, or CasADi's ``erk`` with a notice where there is no compiler.
    """

    mechanism: Mechanism
    law: ContactLaw
    engine: str = "auto"

    @cached_property
    def contact(self) -> SoftenedContact:
        """Mechanism and law joined."""
        return SoftenedContact(self.mechanism, self.law)

    @cached_property
    def integrator(self) -> Engine:
        """The engine, compiled or taken from the cache on first use."""
        return make_engine(self.contact.automaton, self.engine)

    def parameters(self, given: Mapping[str, float] | None = None) -> dict[str, float]:
        """Return all parameters of mechanism and law with `given` put in, checked."""
        declared = (*self.mechanism.system.parameters, *self.law.parameters)
        return resolve_parameters(self._where, declared, given or {})

    @property
    def _where(self) -> str:
        return f"{self.mechanism.name!r} with law {self.law.name!r}"

    def constants(self, parameters: Mapping[str, float]) -> dict[Any, float]:
        """Return the values of all parameter symbols and definitions."""
        automaton = self.contact.automaton
        p = np.array([parameters[s.name] for s in automaton.parameters])
        c = self.integrator.constants(p)
        return dict(
            zip((*automaton.parameters, *automaton.definitions), map(float, c), strict=True)
        )

    def compression_of_force(self, force: float, parameters: Mapping[str, float]) -> float:
        """Return δ₀ > 0 with F_n(δ₀) = `force` on the loading curve at rest; m.

        The initial surface energy of the paper, (10), is given this way.
        """
        if not (np.isfinite(force) and force >= 0):
            raise InputError(f"{self._where}: initial force: got {force!r}, need >= 0 and finite.")
        values = self.constants(parameters)
        k, n = numbers([self.law.stiffness, self.law.exponent], values)
        return float((force / k) ** (1 / n))

    def initial_state(self, state: Mapping[str, float], parameters: Mapping[str, float]) -> Array:
        """Return the automaton's state vector for coordinates and velocities by name."""
        automaton, contact = self.contact.automaton, self.mechanism.contact
        values = symbol_values(self.mechanism, state, parameters)
        derived = [contact.gap, contact.gap_rate, contact.slip_velocity]
        extra = dict(zip((GAP, GAP_RATE, SLIP), numbers(derived, values), strict=True))
        return np.array([values.get(s, extra.get(s, 0.0)) for s in automaton.states])

    def run(
        self,
        state: Mapping[str, float],
        *,
        t_end: float,
        parameters: Mapping[str, float] | None = None,
        until: str | tuple[str, ...] = (),
        rtol: float = DEFAULT_RTOL,
        atol: Array | None = None,
        record: str = "dense",
        initial_force: float | None = None,
        **limits: Any,
    ) -> Trajectory:
        """Integrate the softened motion from t = 0.

        Parameters
        ----------
        state : mapping of str to float
            Coordinates and velocities; absent ones are 0. A negative gap is a compression.
        t_end : float
            s, > 0.
        parameters : mapping of str to float
            Of mechanism and law; absent ones have their defaults.
        until : str or tuple of str
            Kinds of events that end the run.
        rtol : float
        atol : ndarray, shape (nx,)
            Per state; by default scaled to the contact (see `tolerances`).
        record : {"dense", "events", "end"}
        initial_force : float
            Sets the initial compression so that the contact carries this force; N.
        **limits
            first_step, max_step, max_steps, max_events of `RunOptions`.

        Returns
        -------
        Trajectory
            Also when it stopped early: `stop_reason` says why.

        Raises
        ------
        InputError
            Unknown names, numbers out of range, a start outside the domain.
        """
        if not (np.isfinite(t_end) and t_end > 0):
            raise InputError(f"{self._where}: t_end: got {t_end!r}, need a finite number > 0.")
        values = self.parameters(parameters)
        start = resolve_state(self.mechanism, state, values)
        vector = self.initial_state(start, values)
        if initial_force is not None:
            vector = self._with_force(vector, initial_force, values)
        p = np.array([values[s.name] for s in self.contact.automaton.parameters])
        kinds = (until,) if isinstance(until, str) else tuple(until)
        for kind in kinds:
            if kind not in self.contact.automaton.kinds:
                message = unknown_name("event", kind, self.contact.automaton.kinds)
                raise InputError(f"{self._where}: until: {message}")
        scale = self.tolerances(vector, values) if atol is None else np.asarray(atol) / rtol
        options = RunOptions(t_end, rtol, rtol * scale, kinds, record, **limits)
        return self._trajectory(self.integrator.run(vector, p, options), values, rtol)

    def _with_force(self, vector: Array, force: float, values: Mapping[str, float]) -> Array:
        if self.contact.gap is GAP or self.contact.gap not in self.mechanism.system.q:
            raise InputError(
                f"{self._where}: initial_force: the gap is no coordinate of this mechanism. "
                "Fix: give a state whose gap is the compression wanted."
            )
        index = self.contact.states.index(self.contact.gap)
        if vector[index] != 0:
            raise InputError(
                f"{self._where}: initial_force: got a start with gap {vector[index]!r}, need 0. "
                "Fix: give the force or the compression, not both."
            )
        vector[index] = -self.compression_of_force(force, values)
        return vector

    def tolerances(self, vector: Array, parameters: Mapping[str, float]) -> Array:
        """Return the scale of each state below which only its absolute error counts, shape (nx,).

        Compression is measured by its value δ_c under the free normal force |b_n|/W_nn, normal
        velocity by δ_c/T with T the time of a contact under that force; other velocities by the
        kinetic energy plus the energy of the contact; coordinates by 1. Dissipated energies are
        left out (inf).
        """
        automaton, system = self.contact.automaton, self.mechanism.system
        symbols = dict(zip(automaton.states, map(float, vector), strict=True))
        symbols |= self.constants(parameters)
        c = self.mechanism.coefficients
        W_nn, W_tt, b_n, kinetic, k, n = numbers(
            [c.W_nn, c.W_tt, c.b_n, system.kinetic_energy, self.law.stiffness, self.law.exponent],
            symbols,
        )
        masses = numbers([system.mass_matrix[i, i] for i in range(len(system.q))], symbols)
        force, depth = abs(b_n) / W_nn, max(0.0, -symbols[self.contact.gap])
        stored = k * depth ** (n + 1) / (n + 1)
        if force > 0:
            delta = (force / k) ** (1 / n)
        else:
            # Nothing presses: a hundredth of what the energy at hand can compress.
            delta = 0.01 * ((n + 1) * (kinetic + stored) / k) ** (1 / (n + 1))
        energy = kinetic + stored + force * delta
        if energy == 0:
            delta = energy = 1.0  # nothing moves and nothing pushes: any scale will do
        rate = np.sqrt(delta * abs(b_n)) if force > 0 else 0.01 * np.sqrt(2 * energy * W_nn)
        scale = {s: 1.0 for s in system.q}
        scale |= {s: np.sqrt(2 * energy / m) for s, m in zip(system.q_dot, masses, strict=True)}
        scale[self.contact.slip] = np.sqrt(2 * energy * W_tt) or 1.0
        scale |= {self.contact.gap: delta, self.contact.gap_rate: rate}
        scale |= dict.fromkeys(automaton.uncontrolled, float("inf"))
        return np.array([scale[s] for s in automaton.states])

    def _trajectory(self, raw: RawRun, values: dict[str, float], rtol: float) -> Trajectory:
        automaton, nx = self.contact.automaton, len(self.contact.automaton.states)
        nz = len(automaton.memory)
        c = self.integrator.constants(np.array([values[s.name] for s in automaton.parameters]))
        return Trajectory(
            mechanism=self.mechanism.name,
            law=self.law.name,
            choices=dict(self.law.choices),
            parameters=values,
            state_names=tuple(s.name for s in automaton.states),
            memory_names=tuple(s.name for s in automaton.memory),
            mode_names=tuple(m.name for m in automaton.modes),
            output_names=automaton.output_names,
            step_time=raw.steps[:, 0],
            step_length=raw.steps[:, 1],
            step_mode=raw.steps[:, 2].astype(np.int64),
            step_memory=raw.steps[:, 3 : 3 + nz],
            step_rows=raw.steps[:, 3 + nz :].reshape(len(raw.steps), DENSE_ROWS, nx),
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
        automaton = self.contact.automaton
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
            mode = self.contact.automaton.modes[raw.mode]
            label = mode.transitions[raw.stop_transition].label
            return self.mechanism.domain[int(label.rpartition("_")[2])].meaning
        ordinary = (StopReason.T_END, StopReason.UNTIL)
        return "" if raw.stop_reason in ordinary else raw.stop_reason.advice


def simulate_softened(
    mechanism: Mechanism,
    law: ContactLaw,
    state: Mapping[str, float],
    *,
    engine: str = "auto",
    **options: Any,
) -> Trajectory:
    """Integrate a softened motion; see `SoftenedSimulator.run` for the options."""
    return SoftenedSimulator(mechanism, law, engine).run(state, **options)
