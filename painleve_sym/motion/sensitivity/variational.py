"""Runs a simulator's motion together with its derivatives, and reads them off the events."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from sympy import Expr, Symbol, diff, sympify

from painleve_sym.arrays import Array
from painleve_sym.checks import StateLike
from painleve_sym.choices import EngineName, Record
from painleve_sym.codegen.derivation_cache import ENGINE, entry_key
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.codegen.variational import VariationalFunctions
from painleve_sym.engines.factory import make_engine
from painleve_sym.engines.protocol import Engine, RawRun, RunOptions, RunSettings
from painleve_sym.engines.records import EVENT_HEAD, STEP_HEAD
from painleve_sym.errors import InputError, PainleveWarning, StopReason, refuse_unknown
from painleve_sym.motion.arguments import INITIAL_FORCE, RunArguments, separated
from painleve_sym.motion.continuation import at_its_time, check_origin, options_of_rest
from painleve_sym.motion.joined import timetable_of
from painleve_sym.motion.mechanism_with_laws import Start
from painleve_sym.motion.refusals import end_detail
from painleve_sym.motion.sensitivity.impacts import SensitiveImpacts
from painleve_sym.motion.sensitivity.result import (
    NO_DERIVATIVE,
    EventMarks,
    EventSensitivity,
    RunDerivatives,
    SensitiveTrajectory,
    StoredDerivatives,
    first_without,
    split_outputs,
)
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory

LOOSENING_FACTOR = 100.0
"""Absolute tolerance of derivatives over that of states, each in parts of its size: then steps are
about a quarter more, and the derivatives of the reference impacts hold nine digits."""

_AT_EVENT = (StopReason.UNTIL, StopReason.EVENT_LIMIT, StopReason.ACCUMULATION)


def differentiated(
    simulator: Simulator,
    state: StateLike | None,
    wrt: tuple[str, ...],
    arguments: RunArguments,
) -> SensitiveTrajectory:
    """Return the motion with its derivatives; see `Simulator.sensitivities`."""
    settings, begins = separated(simulator.where, RunArguments, arguments)
    origin = begins.pop("start", None)
    changes = begins.pop("phases", None) or begins.pop("inputs", None)
    if changes or timetable_of(origin) is not None:
        raise InputError(
            f"{simulator.where}: sensitivities: got phases or inputs, need a motion with the same "
            "parameters from start to end. Fix: differentiate that, or take differences of runs."
        )
    # Without its events nothing would tell which of them are singular.
    if settings.record == "end":
        settings = replace(settings, record=Record.EVENTS)
    initial_force = begins.get(INITIAL_FORCE)
    if origin is None:
        simulator, start = simulator.moving(simulator.begin(state, **begins), wrt)
    else:
        given = {"state": state, **begins}
        check_origin(simulator.where, origin, given, float(settings.t_end))
        simulator, start = simulator.after(origin, begins, wrt)
    key = wrt, initial_force is not None
    known: dict[Any, Directions] = simulator.directions
    directions = known.get(key)
    if directions is None:
        directions = known[key] = Directions(simulator, wrt, initial_force is not None)
    result = directions.run(start, initial_force, settings)
    if result.valid_until == math.inf:
        return result
    _notify(result)
    if result.trajectory.stop_reason is not StopReason.NON_FINITE:
        return result
    # Only the sensitivities became singular: repeat the run without them.
    again = arguments.copy()
    again["record"] = settings.record
    whole = simulator.run(state, **again)
    stored = StoredDerivatives(_continued(result.events, whole), result.extended)
    return replace(result, trajectory=whole, record=stored)


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
    """Return the events of the whole motion, with nan beyond `events`."""
    rest = whole.events[len(events) :]
    if not events:
        return ()
    nowhere = [np.full_like(a, np.nan) for a in (events[0].time_gradient, events[0].state_jacobian)]
    later = (EventSensitivity(e, nowhere[0], nowhere[1], math.nan, -1) for e in rest)
    return (*events, *later)


@dataclass(frozen=True)
class Directions:
    """Directions in which motions are differentiated, with the functions common to all starts.

    Attributes
    ----------
    simulator : Simulator
    wrt : tuple of str
    forced : bool
        Whether the motions start with an initial force.

    Raises
    ------
    InputError
        No names, unknown names, a name given twice.
    """

    simulator: Simulator
    wrt: tuple[str, ...]
    forced: bool

    def __post_init__(self) -> None:
        sim = self.simulator
        names = [*sim.mechanism.state_names, *sim.parameters()]
        known = [*names, *([INITIAL_FORCE] if self.forced else [])]
        where = f"{sim.where}: derivatives"
        if not self.wrt:
            raise InputError(f"{where}: got no names, need at least one. Fix: name one of {known}.")
        for name in self.wrt:
            refuse_unknown("direction", name, known, where)
            if self.wrt.count(name) > 1:
                raise InputError(f"{where}: got {name!r} twice. Fix: name it once.")

    # ---- the start ----

    @cached_property
    def _state_names(self) -> list[str]:
        return [s.name for s in self.simulator.automaton.states]

    @cached_property
    def _start_slopes(self) -> dict[int, list[Expr]]:
        """Derivatives of the dependent start values by their index, one per direction."""
        sim, automaton = self.simulator, self.simulator.automaton
        symbols = {s.name: s for s in (*automaton.states, *automaton.parameters)}
        symbols[INITIAL_FORCE] = self._force
        slopes = {}
        for state, given in sim.start_expressions(self.forced).items():
            expr = sympify(given)
            for symbol, definition in reversed(list(automaton.definitions.items())):
                expr = expr.xreplace({symbol: definition})
            row = self._state_names.index(state.name)
            slopes[row] = [diff(expr, symbols[name]) for name in self.wrt]
        return slopes

    @cached_property
    def _force(self) -> Symbol:
        return Symbol(INITIAL_FORCE, positive=True)

    @cached_property
    def _moved_at_start(self) -> tuple[Array, Any]:
        """The start Jacobian with its dependent rows 0; which entries can be different from 0."""
        own = np.zeros((len(self._state_names), len(self.wrt)))
        for k, i in enumerate(self._places):
            if i is not None:
                own[i, k] = 1.0
        pattern = own != 0
        for row, slopes in self._start_slopes.items():
            own[row] = 0.0
            pattern[row] = [slope != 0 for slope in slopes]
        return own, pattern

    @cached_property
    def _dependent(self) -> Quantities:
        """The entries of the dependent rows, row by row."""
        automaton = self.simulator.automaton
        symbols = (
            *automaton.states,
            *automaton.parameters,
            *([self._force] if self.forced else []),
        )
        every = {
            f"{row}_{k}": slope
            for row, slopes in self._start_slopes.items()
            for k, slope in enumerate(slopes)
        }
        title = f"slopes of the start by {', '.join(self.wrt)}; force {self.forced}"
        definition, names = self.simulator.contact.definition, [s.name for s in symbols]
        return quantities(title, definition, names, lambda: (every, symbols))

    def start_jacobian(self, start: Start, force: float | None) -> Array:
        """Return d(start)/dw, shape (nx, k)."""
        jacobian = self._moved_at_start[0]
        if self._start_slopes:
            forces = [] if force is None else [force]
            point = [*start.state.tolist(), *start.parameters.tolist(), *forces]
            jacobian = jacobian.copy()
            entries = np.array(self._dependent.of_vector(point)) + 0.0  # no -0.0
            jacobian[list(self._start_slopes)] = entries.reshape(-1, len(self.wrt))
        return jacobian

    @cached_property
    def _places(self) -> list[int | None]:
        """The index of the state that each direction moves, None where it moves no state."""
        return [self._state_names.index(w) if w in self._state_names else None for w in self.wrt]

    def sizes(self, start: Start, force: float | None, scale: Array) -> Array:
        """Return the size of each direction: a parameter's value, a start value's scale."""
        sizes = []
        for name, i in zip(self.wrt, self._places, strict=True):
            if i is not None:
                sizes.append(max(abs(float(start.state[i])), float(scale[i])))
            else:
                value = force if name == INITIAL_FORCE else start.place.parameters[name]
                sizes.append(abs(value or 0.0) or 1.0)
        return np.array(sizes)

    # ---- the engine ----

    @cached_property
    def functions(self) -> VariationalFunctions:
        """Functions of state and derivatives."""
        return VariationalFunctions(self.simulator.automaton, self._moved, self._moved_at_start[1])

    @cached_property
    def _moved(self) -> list[int | None]:
        """The index of the parameter that each direction moves, None where it moves none."""
        names = [s.name for s in self.simulator.automaton.parameters]
        return [names.index(w) if w in names else None for w in self.wrt]

    @cached_property
    def engine(self) -> Engine:
        """The engine of state and derivatives, compiled on first use."""
        sim, start = self.simulator, self._moved_at_start[1].tolist()

        def key(engine: str) -> str | None:
            title = f"C of engine {engine} by parameters {self._moved} and states {start}"
            return entry_key(title, sim.contact, by=ENGINE)

        return make_engine(sim.automaton, EngineName(sim.integrator.name), self.functions, key)

    # ---- the run ----

    def run(self, start: Start, force: float | None, settings: RunSettings) -> SensitiveTrajectory:
        """Run from a start, with the initial force if there is one, and assemble."""
        sim, functions, engine = self.simulator, self.functions, self.engine
        plain = sim.options(start.scale, settings)
        scale = plain.atol / plain.rtol
        sizes = self.sizes(start, force, scale)
        with np.errstate(over="ignore"):  # of a parameter next to 0 no derivative needs digits
            loosened = plain.rtol * (LOOSENING_FACTOR * scale[:, None] / sizes)
        extended = replace(plain, atol=functions.packed(plain.atol, loosened))
        state = functions.packed(start.state, self.start_jacobian(start, force))
        impacts = self._impacts(start, scale, sizes, plain.rtol)
        if start.time or start.mode >= 0:
            rest, memory = options_of_rest(extended, start), None
            if start.memory is not None:
                # What a motion remembers at its start has no derivative.
                memory = np.zeros(functions.z.numel())
                memory[: len(start.memory)] = start.memory
            raw = engine.run(state, start.parameters, rest, memory, listener=impacts)
            raw = at_its_time(raw, extended, start.time)
        else:
            raw = engine.run(state, start.parameters, extended, listener=impacts)
        return self._assembled(raw, start, sizes, plain, impacts.notes if impacts else ())

    def _impacts(
        self, start: Start, scale: Array, sizes: Array, rtol: float
    ) -> SensitiveImpacts | None:
        """Return the listener that differentiates the impacts of several contacts."""
        if not self.functions.struck_states:
            return None
        names = [c.name for c in self.simulator.mechanism.outline.contacts]
        constants = self.engine.constants(start.parameters)
        tolerance = 10 * LOOSENING_FACTOR * rtol
        return SensitiveImpacts(self.functions, names, constants, sizes, scale, tolerance)

    def _assembled(
        self, raw: RawRun, start: Start, sizes: Array, options: RunOptions, notes: Sequence[str]
    ) -> SensitiveTrajectory:
        sim, functions, engine = self.simulator, self.functions, self.engine
        nx, k, no = len(start.state), len(self.wrt), len(sim.outline.output_names)
        rtol, scale = options.rtol, options.atol / options.rtol
        trajectory = sim.trajectory(self._plain(raw), start, options)
        marks = EventMarks.of(raw, functions, notes)
        verdicts = marks.verdicts(sizes, rtol)
        singular = first_without(verdicts)
        valid = math.inf
        if singular < len(verdicts):
            valid = float(marks.time[singular])
        elif not np.isfinite(raw.state).all():
            valid = raw.time
        constants = engine.constants(start.parameters)
        values = engine.outputs([raw.mode], raw.state[None], raw.memory[None], constants)
        fixed = split_outputs(values, nx, no, k)[0][0]
        ended = raw.stop_reason in _AT_EVENT or raw.stop_transition >= 0
        final, final_time = fixed, np.zeros(k)
        if ended:
            final = functions.unpacked(raw.state)[1]
            final_time = raw.memory[functions.event_entries["time"]]
            if end_detail(sim, raw, options.until):
                shift, moved = self._moved_before(raw, constants)
                final, final_time = final + moved, final_time + shift
        if valid < math.inf:
            final, fixed, final_time = (np.full_like(a, np.nan) for a in (final, fixed, final_time))
        return SensitiveTrajectory(
            trajectory=trajectory,
            wrt=self.wrt,
            record=RunDerivatives(
                functions, engine, self.wrt, raw, trajectory, marks, verdicts, sizes, scale
            ),
            final_jacobian=final,
            final_time_gradient=final_time,
            fixed_time_jacobian=fixed,
            valid_until=valid,
        )

    def _moved_before(self, raw: RawRun, constants: Array) -> tuple[Array, Array]:
        """Return what the time of the event that a run ended before adds to its derivatives.

        Shapes (k,) of those of the time since the event before it, and (nx, k) of the state.
        """
        functions, nx = self.functions, len(self._state_names)
        mode = self.simulator.automaton.modes[raw.mode]
        if not mode.field:  # no time has passed since the event before it
            return np.zeros(len(self.wrt)), np.zeros((nx, len(self.wrt)))
        event = functions.of_mode(mode.name).events[raw.stop_transition]
        memory = np.array(event(raw.state, raw.memory, constants, 1.0)[1]).reshape(-1)
        shift = memory[functions.event_entries["shift"]]
        rates = self.engine.field(raw.mode, raw.state, raw.memory, constants)[:nx]
        return shift, np.outer(rates, shift)

    def _plain(self, raw: RawRun) -> RawRun:
        """Return the run of the state alone."""
        nx, nz = len(self._state_names), len(self.simulator.automaton.memory)
        sizes = len(raw.state), len(raw.memory), nx, nz
        return raw._replace(
            state=raw.state[:nx],
            memory=raw.memory[:nz],
            steps=raw.steps[:, _step_columns(raw.steps.shape[1], *sizes)],
            events=raw.events[:, _event_columns(*sizes)],
        )


# ---- reading the extended run ----


@lru_cache(maxsize=64)
def _step_columns(width: int, whole_nx: int, whole_nz: int, nx: int, nz: int) -> Any:
    """Return the columns of the state alone in rows of `StepRecords` of a longer state."""
    columns, first = np.arange(width), STEP_HEAD + whole_nz
    polynomial = columns[first:-1].reshape(-1, whole_nx)[:, :nx].ravel()
    return np.concatenate([columns[: STEP_HEAD + nz], polynomial, columns[-1:]])


@lru_cache(maxsize=64)
def _event_columns(whole_nx: int, whole_nz: int, nx: int, nz: int) -> Any:
    """Return the columns of the state alone in rows of `EventRecords` of a longer state."""
    before, after = EVENT_HEAD, EVENT_HEAD + whole_nx + whole_nz
    starts = (0, EVENT_HEAD), (before, nx), (before + whole_nx, nz)
    pairs = (*starts, (after, nx), (after + whole_nx, nz))
    return np.concatenate([np.arange(start, start + count) for start, count in pairs])
