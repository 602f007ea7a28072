"""Runs a simulator's motion together with its derivatives, and reads them off the events."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from sympy import diff, sympify

from painleve_sym.arrays import Array
from painleve_sym.choices import EngineName, Record, RecordLike
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.tape import tapes_of_functions
from painleve_sym.codegen.variational import VariationalFunctions
from painleve_sym.engines.factory import make_engine
from painleve_sym.engines.protocol import Engine, RawRun
from painleve_sym.errors import InputError, PainleveWarning, StopReason, unknown_name
from painleve_sym.motion.sensitivity.impacts import SensitiveImpacts
from painleve_sym.motion.sensitivity.result import (
    NO_DERIVATIVE,
    EventSensitivity,
    SensitiveTrajectory,
    split_outputs,
)
from painleve_sym.motion.simulator import Simulator, Start
from painleve_sym.motion.trajectory import EngineOutputs, EventRecord, StoredRecord, Trajectory

INITIAL_FORCE = "initial_force"

LOOSENING_FACTOR = 100.0
"""Absolute tolerance of derivatives over that of states, each in parts of its size: then steps are
about a quarter more, and the derivatives of the reference impacts hold nine digits."""

GRAZING = 1e-3
"""Relative change of a guard's rate, under a change of a direction by the tolerance, from which on
the event counts as met tangentially: about that is the error of its derivatives then."""

COINCIDENT = 1e-9
"""Part of the time so far within which two events count as simultaneous."""

_AT_EVENT = (StopReason.UNTIL, StopReason.EVENT_LIMIT, StopReason.ACCUMULATION)


def differentiated(
    simulator: Simulator,
    state: Mapping[str, float],
    wrt: tuple[str, ...],
    *,
    parameters: Mapping[str, float] | None = None,
    initial_force: float | None = None,
    record: RecordLike = Record.DENSE,
    **options: Any,
) -> SensitiveTrajectory:
    """Return the motion with its derivatives; see `Simulator.sensitivities`."""
    start = simulator.start(state, parameters, initial_force)
    _check_directions(simulator, wrt, start.values, initial_force is not None)
    run = _Differentiated(simulator, wrt, start, initial_force)
    # Without its events nothing would tell which of them are singular.
    record = Record.EVENTS if record == "end" else record
    result = run.result(record, options)
    if result.valid_until == math.inf:
        return result
    _notify(result)
    if result.trajectory.stop_reason is not StopReason.NON_FINITE:
        return result
    # Only the sensitivities became singular: repeat the run without them.
    given: dict[str, Any] = {"parameters": parameters, "record": record, **options}
    if initial_force is not None:
        given[INITIAL_FORCE] = initial_force
    whole = simulator.run(state, **given)
    return replace(result, trajectory=whole, events=_continued(result.events, whole))


def _check_directions(
    simulator: Simulator, wrt: tuple[str, ...], values: Mapping[str, float], forced: bool
) -> None:
    known = [*simulator.mechanism.state_names, *values, *([INITIAL_FORCE] if forced else [])]
    where = f"{simulator.where}: derivatives"
    if not wrt:
        raise InputError(f"{where}: got no names, need at least one. Fix: name one of {known}.")
    for name in wrt:
        if name not in known:
            raise InputError(f"{where}: {unknown_name('direction', name, known)}")
        if wrt.count(name) > 1:
            raise InputError(f"{where}: got {name!r} twice. Fix: name it once.")


def _notify(result: SensitiveTrajectory) -> None:
    where, singular = f"derivatives of {result.trajectory.mechanism!r}", result.singular
    if singular is None:
        text = f"not finite from t = {result.valid_until:g} s on; nan from there on"
    else:
        text = (
            f"event {str(singular.event.kind)!r} at t = {singular.event.time:g} s "
            f"{NO_DERIVATIVE[singular.note]} "
            f"(condition {singular.condition:.1e}); nan from there on"
        )
    fix = "Fix: end before it, or move the start or the parameters."
    warnings.warn(f"{where}: {text}. {fix}", PainleveWarning, stacklevel=4)


def _continued(
    events: tuple[EventSensitivity, ...], whole: Trajectory
) -> tuple[EventSensitivity, ...]:
    """Return the events of the whole motion, those not yet among `events` with nan."""
    rest = whole.events[len(events) :]
    if not events:
        return ()
    nowhere = [np.full_like(a, np.nan) for a in (events[0].time_gradient, events[0].state_jacobian)]
    later = (EventSensitivity(e, nowhere[0], nowhere[1], math.nan, -1) for e in rest)
    return (*events, *later)


@dataclass(frozen=True)
class _Marked:
    """An event with what the extended run says of it; `shift` is dσ by the guard alone."""

    record: EventRecord
    jacobian: Array
    time_gradient: Array
    shift: Array
    guard: float
    rate: float
    bend: float
    timed: bool
    note: str = ""


@dataclass(frozen=True)
class _Differentiated:
    """One start, with the directions in which it is differentiated."""

    simulator: Simulator
    wrt: tuple[str, ...]
    start: Start
    initial_force: float | None

    # ---- the start and the engine ----

    def _start_expressions(self) -> dict[Any, Any]:
        """Dependent start values, written in states and parameters only."""
        automaton = self.simulator.automaton
        expressions = {}
        for s, e in self.simulator.start_expressions(self.initial_force is not None).items():
            expr = sympify(e)
            for symbol, definition in reversed(list(automaton.definitions.items())):
                expr = expr.xreplace({symbol: definition})
            expressions[s] = expr
        return expressions

    def start_jacobian(self) -> tuple[Array, Any]:
        """Return d(start)/dw, shape (nx, k), and which entries can be different from zero."""
        sim = self.simulator
        symbols = {s.name: s for s in (*sim.automaton.states, *sim.automaton.parameters)}
        # Symbols compare their assumptions too, which takes half as long as the run.
        states = [s.name for s in sim.automaton.states]
        jacobian = np.zeros((len(self.start.state), len(self.wrt)))
        values: dict[Any, float] = dict(
            zip(sim.automaton.states, map(float, self.start.state), strict=True)
        )
        values |= {s: self.start.values[s.name] for s in sim.automaton.parameters}
        if self.initial_force is not None:
            force = next(
                s
                for e in self._start_expressions().values()
                for s in e.free_symbols
                if s.name == INITIAL_FORCE
            )
            symbols[INITIAL_FORCE] = force
            values[force] = self.initial_force
        for k, name in enumerate(self.wrt):
            if name in states:
                jacobian[states.index(name), k] = 1.0
        pattern = jacobian != 0
        for state, expr in self._start_expressions().items():
            row = states.index(state.name)
            slopes = [diff(expr, symbols[name]) for name in self.wrt]
            pattern[row] = [slope != 0 for slope in slopes]
            jacobian[row] = numbers(slopes, values)
        return jacobian, pattern

    def engine(self, pattern: Any) -> tuple[Engine, VariationalFunctions]:
        """Return the engine of state and derivatives, compiled on first use."""
        sim = self.simulator
        key = (self.wrt, pattern.tobytes())
        known: dict[Any, tuple[Engine, VariationalFunctions]] = sim.variational_engines
        if key not in known:
            names = [s.name for s in sim.automaton.parameters]
            moved = [names.index(w) if w in names else None for w in self.wrt]
            functions = VariationalFunctions(sim.automaton, moved, pattern)
            engine = make_engine(sim.automaton, EngineName(sim.integrator.name), functions)
            known[key] = (engine, functions)
        return known[key]

    def sizes(self, scale: Array) -> Array:
        """Return the size of each direction: a parameter's value, a start value's scale."""
        names = [s.name for s in self.simulator.automaton.states]
        sizes = []
        for name in self.wrt:
            if name in names:
                i = names.index(name)
                sizes.append(max(abs(float(self.start.state[i])), float(scale[i])))
            else:
                value = self.initial_force if name == INITIAL_FORCE else self.start.values[name]
                sizes.append(abs(value or 0.0) or 1.0)
        return np.array(sizes)

    # ---- the run ----

    def result(self, record: RecordLike, options: dict[str, Any]) -> SensitiveTrajectory:
        """Run and assemble."""
        sim = self.simulator
        plain = sim.options(self.start.scale, record=record, **options)
        jacobian, pattern = self.start_jacobian()
        engine, functions = self.engine(pattern)
        scale = plain.atol / plain.rtol
        directions = self.sizes(scale)
        finite = np.where(np.isfinite(scale), scale, 1.0)
        sizes = LOOSENING_FACTOR * scale[:, None] / directions
        extended = replace(plain, atol=functions.packed(plain.atol, plain.rtol * sizes))

        start = functions.packed(self.start.state, jacobian)
        resolver = None
        if functions.struck_states:
            resolver = SensitiveImpacts(
                **sim.resolver_inputs(self.start.values, plain),
                functions=functions,
                constants=engine.constants(self.start.parameters),
                sizes=directions,
                tolerance=10 * LOOSENING_FACTOR * plain.rtol,
            )
        raw = engine.run(start, self.start.parameters, extended, resolve=resolver)
        return self._assembled(raw, engine, functions, directions, finite, plain.rtol, resolver)

    def _assembled(
        self,
        raw: RawRun,
        engine: Engine,
        functions: VariationalFunctions,
        directions: Array,
        scale: Array,
        rtol: float,
        resolver: SensitiveImpacts | None,
    ) -> SensitiveTrajectory:
        sim = self.simulator
        nx, nz, k = len(self.start.state), len(sim.automaton.memory), len(self.wrt)
        resolved = resolver.impulses if resolver else ()
        trajectory = sim.trajectory(_plain(raw, nx, nz), self.start, rtol, resolved)
        marked = _marked(raw, trajectory, functions, resolver.notes if resolver else ())
        events = _judged(marked, directions, scale, rtol)
        c = engine.constants(self.start.parameters)
        singular = next((e for e in events if e.note in NO_DERIVATIVE), None)
        valid = math.inf if singular is None else singular.event.time
        if not np.isfinite(raw.state).all() and singular is None:
            valid = raw.time
        no = len(sim.automaton.output_names)
        values = engine.outputs([raw.mode], raw.state[None], raw.memory[None], c)
        fixed = split_outputs(values, nx, no, k)[0][0]
        moving = functions.unpacked(raw.state)[1]
        time = raw.memory[functions.event_entries["time"]]
        ended = raw.stop_reason in _AT_EVENT or raw.stop_transition >= 0
        final, final_time = (moving, time) if ended else (fixed, np.zeros(k))
        if valid < math.inf:
            final, fixed, final_time = (np.full_like(a, np.nan) for a in (final, fixed, final_time))
        return SensitiveTrajectory(
            trajectory=trajectory,
            wrt=self.wrt,
            events=events,
            final_jacobian=final,
            final_time_gradient=final_time,
            fixed_time_jacobian=fixed,
            valid_until=valid,
            extended=self._extended(raw, trajectory, engine, functions, c),
        )

    def _extended(
        self,
        raw: RawRun,
        trajectory: Trajectory,
        engine: Engine,
        functions: VariationalFunctions,
        constants: Array,
    ) -> Trajectory:
        rows, columns = functions.entries
        names = trajectory.state_names
        slopes = [f"d {names[i]}/d {self.wrt[k]}" for i, k in zip(rows, columns, strict=True)]
        outputs = [
            f"d {kind} {name}/d {w}"  # the gap may be a state and an output
            for kind, group in (("state", names), ("output", trajectory.output_names))
            for w in self.wrt
            for name in group
        ]
        record, states = trajectory.record, (*names, *slopes)
        memory = tuple(f"memory {i}" for i in range(len(raw.memory)))
        return replace(
            trajectory,
            names=replace(
                trajectory.names,
                states=states,
                memory=memory,
                outputs=(*trajectory.output_names, *outputs),
            ),
            record=replace(
                StoredRecord.of(record),
                steps=replace(raw.step_records, mode=record.steps.mode),
                constants=constants,
            ),
            final_state=raw.state,
            final_memory=raw.memory,
            evaluator=EngineOutputs(engine, partial(tapes_of_functions, functions)),
        )


# ---- reading the extended run ----


def _plain(raw: RawRun, nx: int, nz: int) -> RawRun:
    """Return the run of the state alone."""
    steps, events = raw.step_records, raw.event_records
    own = replace(steps, memory=steps.memory[:, :nz], polynomial=steps.polynomial[:, :, :nx])
    marks = replace(
        events,
        state_before=events.state_before[:, :nx],
        memory_before=events.memory_before[:, :nz],
        state_after=events.state_after[:, :nx],
        memory_after=events.memory_after[:, :nz],
    )
    return raw._replace(
        state=raw.state[:nx], memory=raw.memory[:nz], steps=own.rows(), events=marks.rows()
    )


def _marked(
    raw: RawRun, trajectory: Trajectory, functions: VariationalFunctions, notes: Sequence[str]
) -> list[_Marked]:
    """Return the events; `notes` are those of the ones that no transition made, in order."""
    events, places = raw.event_records, functions.event_entries
    marked, resolved = [], iter(notes)
    for record, transition, x, z in zip(
        trajectory.events, events.transition, events.state_after, events.memory_after, strict=True
    ):
        answered = transition < 0
        m = {name: z[place] for name, place in places.items()}
        if answered:
            # It takes no time, and its entries are those of the event before it.
            m |= {name: np.zeros_like(m[name]) for name in m if name != "time"}
        marked.append(
            _Marked(
                record,
                functions.unpacked(x)[1],
                m["time"],
                m["shift"],
                float(m["guard"][0]),
                float(m["rate"][0]),
                float(m["bend"][0]),
                bool(m["timed"][0]),
                next(resolved, "") if answered else "",
            )
        )
    return marked


def _judged(
    marked: list[_Marked], directions: Array, scale: Array, rtol: float
) -> tuple[EventSensitivity, ...]:
    """Return the events with what is singular about them named."""
    verdicts = [_verdict(m, directions, rtol) for m in marked]
    known = next((i for i, (_, note) in enumerate(verdicts) if note in NO_DERIVATIVE), len(marked))
    ranks = np.full(len(marked), -1)
    if known:
        sized = np.array([m.jacobian for m in marked[:known]]) * directions / scale[:, None]
        ranks[:known] = np.linalg.matrix_rank(sized, rtol=1e-9)
    return tuple(
        EventSensitivity(
            event=m.record,
            time_gradient=m.time_gradient if i < known else np.full_like(m.time_gradient, np.nan),
            state_jacobian=m.jacobian if i < known else np.full_like(m.jacobian, np.nan),
            condition=condition,
            rank=int(ranks[i]),
            note=note,
        )
        for i, (m, (condition, note)) in enumerate(zip(marked, verdicts, strict=True))
    )


def _verdict(m: _Marked, directions: Array, rtol: float) -> tuple[float, str]:
    """Return condition and note of an event."""
    if m.note:
        return 0.0, m.note
    moved = np.abs(m.shift) * directions
    if m.timed:
        with np.errstate(divide="ignore", invalid="ignore"):
            changes = np.abs(np.float64(m.bend) / m.rate) * moved
        condition = float(np.max(changes)) if np.isfinite(moved).all() else math.inf
        if not condition * rtol <= GRAZING:
            return condition, "grazing"
        return condition, "" if np.isfinite(m.jacobian).all() else "singular"
    if not np.isfinite(m.jacobian).all():
        return 0.0, "singular"
    span = m.record.time or 1.0
    beside = abs(m.guard) <= COINCIDENT * span * abs(m.rate)
    by_chance = beside and bool((moved[np.isfinite(moved)] > COINCIDENT * span).any())
    return 0.0, "one-sided" if by_chance else ""
