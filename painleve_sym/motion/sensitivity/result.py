"""First derivatives of a motion: states at any time, event times, velocities after events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.codegen.tape import tapes_of_functions
from painleve_sym.engines.protocol import Engine, RawRun
from painleve_sym.equality import Compared, same
from painleve_sym.errors import InputError, refuse_unknown, unknown_name
from painleve_sym.motion.records import EngineOutputs, EventRecord
from painleve_sym.motion.run_record import StoredRecord
from painleve_sym.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from painleve_sym.codegen.variational import VariationalFunctions

GRAZING = 1e-3
"""Relative change of a guard's rate, under a change of a direction by the tolerance, from which on
the event counts as met tangentially: about that is the error of its derivatives then."""

COINCIDENT = 1e-9
"""Part of the time so far within which two events count as simultaneous."""

NO_DERIVATIVE = {
    "grazing": "is met tangentially",
    "singular": "has no finite derivative",
    "simultaneous": "joins contacts that touch at one instant, and a direction parts them",
    "tie": "changes its sequence of slip, stick and restitution with the sign of a direction",
}
"""Notes of events from which on nothing is differentiable, with what such an event does."""


@dataclass(frozen=True, eq=False)
class EventSensitivity(Compared):
    """Derivatives of one event.

    `time_gradient` is ∂τ/∂w of its time, s per unit of w; `state_jacobian` the total derivative of
    `event.state`, including the shift of the event time, shape (nx, k).

    `condition` is the largest relative change of the speed at which the guard is met, per relative
    change of a direction: large near a tangential event; 0 for one that fires at once. `rank` is
    that of the state Jacobian: a slip that stops forgets a direction. It is -1 where that is nan.

    `note` is empty; or a key of `NO_DERIVATIVE`; or ``one-sided``: another event happens at the
    same time by chance, and the derivatives hold as long as their order stays.
    """

    event: EventRecord
    time_gradient: Array
    state_jacobian: Array
    condition: float
    rank: int
    note: str = ""


@dataclass(frozen=True)
class StoredDerivatives:
    """Derivatives of events that have been read, and the run of state and derivatives together."""

    events: tuple[EventSensitivity, ...]
    extended: Trajectory


@dataclass(frozen=True, eq=False)
class EventMarks(Compared):
    """Numbers of an extended run at its n events, with k directions.

    Attributes
    ----------
    time : ndarray, shape (n,)
        s.
    slopes : ndarray, shape (n, entries)
        Derivatives of the states just after, as `VariationalFunctions.packed` lists them.
    time_gradient, shift : ndarray, shape (n, k)
        T; dσ by the guard alone.
    guard, rate, bend : ndarray, shape (n,)
        The guard and its first two derivatives in time just before.
    timed : ndarray of bool, shape (n,)
        Whether the event waited for its guard.
    notes : tuple of str
        Those of the events that no transition made, empty for the others.
    """

    time: Array
    slopes: Array
    time_gradient: Array
    shift: Array
    guard: Array
    rate: Array
    bend: Array
    timed: Any
    notes: tuple[str, ...]

    @classmethod
    def of(cls, raw: RawRun, functions: VariationalFunctions, notes: Sequence[str]) -> EventMarks:
        """Read the events; `notes` belong to the events without a transition, in order."""
        events, places = raw.event_records, functions.event_entries
        memory, answered = events.memory_after, events.transition < 0
        every = [""] * len(answered)
        if answered.any():
            # Such an event takes no time, and its entries are those of the event before it.
            memory = memory.copy()
            memory[answered, places["shift"].start :] = 0.0
            given = iter(notes)
            every = [next(given, "") if own else "" for own in answered.tolist()]
        return cls(
            time=events.time,
            slopes=events.state_after[:, len(functions.automaton.states) :],
            time_gradient=memory[:, places["time"]],
            shift=memory[:, places["shift"]],
            **{name: memory[:, places[name].start] for name in ("guard", "rate", "bend")},
            timed=memory[:, places["timed"].start] != 0,
            notes=tuple(every),
        )

    def verdicts(self, sizes: Array, rtol: float) -> list[tuple[float, str]]:
        """Return condition and note of each event; `sizes` are those of the directions."""
        if not self.notes:
            return []
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = np.abs(self.shift) * sizes
            changes = (np.abs(self.bend / self.rate)[:, None] * moved).max(axis=1)
        bounded = np.isfinite(moved)
        conditions = np.where(bounded.all(axis=1), changes, np.inf)
        smooth = np.isfinite(self.slopes).all(axis=1)
        near = COINCIDENT * np.where(self.time == 0, 1.0, self.time)
        by_chance = (bounded & (moved > near[:, None])).any(axis=1)
        by_chance &= np.abs(self.guard) <= near * np.abs(self.rate)
        columns = (self.notes, self.timed, conditions, smooth, by_chance)
        verdicts = []
        for note, timed, condition, regular, chance in zip(
            *(c if isinstance(c, tuple) else c.tolist() for c in columns), strict=True
        ):
            if note:
                verdicts.append((0.0, note))
            elif timed and not condition * rtol <= GRAZING:
                verdicts.append((condition, "grazing"))
            elif not regular:
                verdicts.append((condition if timed else 0.0, "singular"))
            else:
                verdicts.append((condition, "") if timed else (0.0, "one-sided" if chance else ""))
        return verdicts


@dataclass(frozen=True, eq=False)
class RunDerivatives:
    """Events and extended run of a motion with derivatives, made when they are first asked for.

    `verdicts` are condition and note of each event; `sizes`, shape (k,), are those of directions,
    `scale`, shape (nx,), is that of states.
    """

    functions: VariationalFunctions
    engine: Engine
    wrt: tuple[str, ...]
    raw: RawRun
    trajectory: Trajectory
    marks: EventMarks
    verdicts: Sequence[tuple[float, str]]
    sizes: Array
    scale: Array

    def __eq__(self, other: object) -> bool:
        """Whether the other, of a run or stored, has the same events and extended run."""
        if not isinstance(other, RunDerivatives | StoredDerivatives):
            return NotImplemented
        return same((self.events, self.extended), (other.events, other.extended))

    def __hash__(self) -> int:
        """Return the hash of the stored arrays."""
        return hash((self.events, self.extended))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle events and derivatives, without simulator and engine."""
        return StoredDerivatives, (self.events, self.extended)

    @cached_property
    def events(self) -> tuple[EventSensitivity, ...]:
        """Derivatives of the events, with their singularities named."""
        marks, functions = self.marks, self.functions
        n, known = len(self.verdicts), first_without(self.verdicts)
        jacobians = np.zeros((n, len(self.scale), len(self.sizes)))
        rows, columns = functions.entries
        jacobians[:, rows, columns] = marks.slopes
        gradients, ranks = marks.time_gradient.copy(), np.full(n, -1)
        if known:
            sized = jacobians[:known] * self.sizes / self.scale[:, None]
            ranks[:known] = np.linalg.matrix_rank(sized, rtol=1e-9)
        jacobians[known:] = gradients[known:] = np.nan
        return tuple(
            EventSensitivity(record, gradient, jacobian, condition, rank, note)
            for record, gradient, jacobian, rank, (condition, note) in zip(
                self.trajectory.events,
                gradients,
                jacobians,
                ranks.tolist(),
                self.verdicts,
                strict=True,
            )
        )

    @cached_property
    def extended(self) -> Trajectory:
        """The run of state and derivatives together."""
        trajectory, raw, wrt = self.trajectory, self.raw, self.wrt
        functions, engine = self.functions, self.engine
        rows, columns = functions.entries
        names = trajectory.state_names
        slopes = [f"d {names[i]}/d {wrt[k]}" for i, k in zip(rows, columns, strict=True)]
        outputs = [
            f"d {kind} {name}/d {w}"  # the gap may be a state and an output
            for kind, group in (("state", names), ("output", trajectory.output_names))
            for w in wrt
            for name in group
        ]
        record = StoredRecord.of(trajectory.record)
        steps = replace(raw.step_records, mode=record.steps.mode)
        parameters = trajectory.constants[: len(functions.automaton.parameters)]
        return replace(
            trajectory,
            names=replace(
                trajectory.names,
                states=(*names, *slopes),
                memory=tuple(f"memory {i}" for i in range(len(raw.memory))),
                outputs=(*trajectory.output_names, *outputs),
            ),
            record=replace(record, steps=steps, constants=engine.constants(parameters)),
            final_state=raw.state,
            final_memory=raw.memory,
            evaluator=EngineOutputs(engine, partial(tapes_of_functions, functions)),
        )


@dataclass(frozen=True, repr=False, eq=False)
class SensitiveTrajectory(Compared):
    """A motion with its first derivatives in the directions `wrt`.

    Attributes
    ----------
    trajectory : Trajectory
    wrt : tuple of str
        Names of the directions: start values of coordinates and velocities, parameters, or
        ``initial_force``.
    record : RunDerivatives or StoredDerivatives
        Events and extended run.
    final_jacobian : ndarray, shape (nx, k)
        Of `trajectory.final_state`. Where an event ended the run, its time moves along.
    final_time_gradient : ndarray, shape (k,)
        Of `trajectory.final_time`: 0 unless an event ended the run.
    fixed_time_jacobian : ndarray, shape (nx, k)
        Of the state at the final time held fixed.
    valid_until : float
        Time of the first event with a note of `NO_DERIVATIVE`, inf where there is none: derivatives
        from there on are nan; s.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> simulator = ps.Simulator(ps.models.rod(), ps.laws.bilinear_hertz())
    >>> state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> run = simulator.sensitivities(state, ("mu",), t_end=1e-2)
    >>> run.final_jacobian.shape
    (8, 1)
    """

    trajectory: Trajectory
    wrt: tuple[str, ...]
    record: RunDerivatives | StoredDerivatives
    final_jacobian: Array
    final_time_gradient: Array
    fixed_time_jacobian: Array
    valid_until: float

    def __repr__(self) -> str:
        """Return the motion and the directions in one line."""
        return f"Derivatives by {', '.join(self.wrt)} of the {self.trajectory!r}"

    @property
    def events(self) -> tuple[EventSensitivity, ...]:
        """Derivatives of the events, one per event of the trajectory."""
        return self.record.events

    @property
    def extended(self) -> Trajectory:
        """The run of state and derivatives together."""
        return self.record.extended

    @property
    def singular(self) -> EventSensitivity | None:
        """The event from which on nothing is differentiable, None for none."""
        return next((e for e in self.events if e.note in NO_DERIVATIVE), None)

    def at(self, t: ArrayLike) -> Array:
        """Return the derivatives of the states at fixed times `t`, shape (len(t), nx, k)."""
        return self._split(t)[0]

    def gradient(self, name: str, t: ArrayLike) -> Array:
        """Return the derivatives of one state or output at fixed times, shape (len(t), k).

        Raises
        ------
        InputError
            Unknown name, times outside the motion.
        """
        states, outputs = self._split(t)
        for names, values in (
            (self.trajectory.state_names, states),
            (self.trajectory.output_names, outputs),
        ):
            if name in names:
                gradient: Array = values[:, names.index(name)]
                return gradient
        known = (*self.trajectory.state_names, *self.trajectory.output_names)
        raise InputError(unknown_name("quantity", name, known))

    def final_gradient(self, name: str) -> dict[str, float]:
        """Return the derivatives of one state at the end by direction; see `final_jacobian`."""
        names = self.trajectory.state_names
        refuse_unknown("state", name, names)
        row = self.final_jacobian[names.index(name)]
        return dict(zip(self.wrt, map(float, row), strict=True))

    def _split(self, t: ArrayLike) -> tuple[Array, Array]:
        times = np.atleast_1d(np.asarray(t, dtype=float))
        self.trajectory(times)  # rejects times outside the motion
        known = times < self.valid_until
        nx, no, k = (
            len(n) for n in (self.trajectory.state_names, self.trajectory.output_names, self.wrt)
        )
        states, outputs = np.full((len(times), nx, k), np.nan), np.full((len(times), no, k), np.nan)
        if known.any():
            values = np.column_stack(list(self.extended.outputs(times[known]).values()))
            states[known], outputs[known] = split_outputs(values, nx, no, k)
        return states, outputs

    def to_dict(self) -> dict[str, Any]:
        """Return the derivatives as plain data."""
        names = self.trajectory.state_names

        def table(jacobian: Array) -> dict[str, list[float]]:
            return {n: row.tolist() for n, row in zip(names, jacobian, strict=True)}

        return {
            "wrt": list(self.wrt),
            "valid_until": self.valid_until,
            "events": [
                {
                    "kind": e.event.kind,
                    "time": e.event.time,
                    "time_gradient": e.time_gradient.tolist(),
                    "state_jacobian": table(e.state_jacobian),
                    "condition": e.condition,
                    "rank": e.rank,
                    "note": e.note,
                }
                for e in self.events
            ],
            "final_time": self.trajectory.final_time,
            "final_time_gradient": self.final_time_gradient.tolist(),
            "final_jacobian": table(self.final_jacobian),
            "fixed_time_jacobian": table(self.fixed_time_jacobian),
        }


def split_outputs(values: Array, nx: int, no: int, k: int) -> tuple[Array, Array]:
    """Return the derivatives of states (n, nx, k) and outputs (n, no, k) of extended outputs."""
    states = values[:, no : no + nx * k].reshape(-1, k, nx)
    outputs = values[:, no + nx * k :].reshape(-1, k, no)
    return states.transpose(0, 2, 1), outputs.transpose(0, 2, 1)


def first_without(verdicts: Sequence[tuple[float, str]]) -> int:
    """Return the index of the first event without a derivative, the number of all where none is."""
    notes = (i for i, (_, note) in enumerate(verdicts) if note in NO_DERIVATIVE)
    return next(notes, len(verdicts))
