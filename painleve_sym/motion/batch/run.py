"""Simulation of batches: arrays of states and parameters in, arrays of final values out."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.automata.model import LOSSES
from painleve_sym.checks import StateLike
from painleve_sym.choices import Record
from painleve_sym.engines.batch import COUNTERS, BatchOutputs, BatchRows
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.protocol import RunOptions, RunSettings
from painleve_sym.errors import InputError
from painleve_sym.motion.arguments import BatchArguments, BatchOptions, separated
from painleve_sym.motion.batch.inputs import BLOCK, RUNS, BatchInputs, Starts
from painleve_sym.motion.batch.machine import check_memory, processor_count, row_bytes
from painleve_sym.motion.batch.reason_codes import DYNAMIC_JAM, ROW_REASONS, SINGULAR
from painleve_sym.motion.batch.result import BatchResult, run_row
from painleve_sym.motion.continuation import (
    Cut,
    check_origin,
    check_watches,
    cut_of,
    first_state,
    options_of_rest,
    same_parameters,
)
from painleve_sym.motion.energy_balance import balance_residual
from painleve_sym.motion.joined import timetable_of
from painleve_sym.motion.locate_limit import jams
from painleve_sym.motion.run_record import RunRecord
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.timetable import Timetable
from painleve_sym.motion.trajectory import Trajectory

LEAST_BLOCK = 64
"""... at first and last, so that all threads begin and end together."""


def run_batch(
    simulator: Simulator,
    states: StateLike | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    **options: Unpack[BatchOptions],
) -> BatchResult:
    """Integrate one motion for every entry of the arrays; see `simulate_batch` for the arguments.

    Each row is the same, bit for bit, as `simulator.run` on its own numbers: it depends neither on
    the other rows nor on the number of threads. A row that fails is a row with its stop reason. One
    that cannot start has its reason at t = 0: ``left_domain`` outside the mechanism's domain,
    ``invalid_start`` where the contact law does not admit it (inside the ground of a rigid contact,
    off a guide, compressed as well as under an initial force) or nothing closes the contact,
    ``non_finite`` where a constant of the law is not finite. Rows that continue a motion have its
    times. The engine ``erk`` runs row after row in Python.
    """
    settings, others = separated(simulator.where, BatchArguments, options)
    kept = BatchOutputs(
        others.get("events", 1),
        *(tuple(others.get(name, ())) for name in ("maxima", "minima", "integrals", "at_events")),
    )
    given = simulator.given(parameters, others.get("law_parameters"))
    force, close = others.get("initial_force"), others.get("close")
    origin = others.get("start")
    changes = others.get("phases"), others.get("inputs")
    if origin is not None:
        said = {"state": states, "close": close, "initial_force": force}
        origin = _checked_origin(simulator, origin, said, changes, float(settings.t_end))
        states = first_state(simulator, origin)
        given = {**same_parameters(simulator, origin), **given}
    states = simulator.mechanism.start if states is None else states
    rows = BatchInputs.of(simulator, states, given, force, close, origin)
    timetable = Timetable.of(simulator, *changes)
    if timetable:
        return _in_pieces(rows, timetable, settings, kept)
    # Most inputs are single numbers, of which Python asks ten times as fast as NumPy.
    zeros = (n for n, v in rows.inputs.items() if not (v.any() if v.ndim else float(v)))
    moving = simulator.without_slip(rows.row(0), zeros)
    if moving is not simulator:
        simulator, rows = moving, replace(rows, simulator=moving)
    scale = np.zeros(len(simulator.outline.state_names))
    shared = simulator.options(scale, replace(settings, record=Record.EVENTS))
    engine, batch = simulator.integrator, _Batch(rows, shared, kept)
    _check_outputs(simulator, kept)
    need = rows.count * row_bytes(simulator, kept)
    fix = "fewer rows at a time, or fewer event times"
    check_memory(f"batch of {simulator.where}", f"{rows.count:,} rows", need, fix)
    if isinstance(engine, CompiledEngine):
        ends = batch.in_threads(engine, _thread_count(others.get("threads")))
    else:
        ends = batch.one_by_one()
    return BatchResult(
        simulator=simulator,
        shape=rows.shape,
        inputs=rows.inputs,
        initial_force=rows.force,
        origin=origin,
        options=shared,
        kept=kept,
        rows=ends,
    )


def _in_pieces(
    rows: BatchInputs, timetable: Timetable, settings: RunSettings, kept: BatchOutputs
) -> BatchResult:
    """Return the ends of runs with phases, inputs or pulses, row after row in Python."""
    simulator = rows.simulator.stepped
    where = f"batch of {simulator.where}"
    if any(name in phase for phase in timetable.phases for name in ("law", "contacts")):
        raise InputError(
            f"{where}: phases: got another law or contacts, need parameters alone, so that all "
            "rows keep the same states. Fix: run such motions one by one with simulate."
        )
    if kept.watched:
        raise InputError(
            f"{where}: {kept.watched[0]}: extremes and integrals need motions without phases, "
            "inputs and pulses. Fix: leave them out, or take them from single runs."
        )
    own = {n: rows.inputs.get(n, np.array(0.0)) for n in simulator.units}
    if timetable.pulses:
        own |= _first_pulses(rows, timetable, where, float(settings.t_end))
    shared = simulator.options(
        np.zeros(len(simulator.outline.state_names)), replace(settings, record=Record.EVENTS)
    )
    changes = timetable.to_data()
    batch = _Batch(replace(rows, simulator=simulator, inputs=own), shared, kept)
    return BatchResult(
        simulator=simulator,
        shape=rows.shape,
        inputs=rows.inputs,
        initial_force=rows.force,
        options=shared,
        kept=kept,
        rows=batch.one_by_one(rows.row, changes),
        changes=changes,
    )


def _checked_origin(
    simulator: Simulator,
    origin: object,
    given: Mapping[str, object],
    changes: tuple[object, object],
    t_end: float,
) -> Trajectory:
    """Return the motion that all rows continue; InputError where they cannot."""
    motion = check_origin(simulator.where, origin, given, t_end)
    check_watches(simulator, motion)
    pulsed = simulator.mechanism.outline.pulsed
    if timetable_of(motion) is not None or pulsed or changes != (None, None):
        raise InputError(
            f"batch of {simulator.where}: start: got a motion with phases, inputs or pulses, which "
            "rows of a batch do not continue. Fix: continue it row by row with simulate."
        )
    return motion


def _first_pulses(
    rows: BatchInputs, timetable: Timetable, where: str, end: float
) -> dict[str, Array]:
    """Return the pulses with which each row begins, where its start is looked at."""
    every = [rows.row(i) for i in range(rows.count)]
    first = [timetable.beginning(row, 0.0).pulsed(where, 0.0, end, row)[1] for row in every]
    return {n: np.array([f[n] for f in first]).reshape(rows.shape) for n in timetable.pulses}


def _thread_count(threads: int | None) -> int:
    if threads is None:
        return processor_count()
    if threads < 1:
        raise InputError(f"batch: threads: got {threads!r}, need at least 1.")
    return threads


def _check_outputs(simulator: Simulator, kept: BatchOutputs) -> None:
    kept.indices(simulator.outline.output_names)
    kept.samples(simulator.outline)
    if kept.watched and not isinstance(simulator.integrator, CompiledEngine):
        raise InputError(
            f"{simulator.where}: {kept.watched[0]}: extremes and integrals need the compiled "
            "engine. Fix: leave them out, or take them from single runs."
        )


# ---- the work ----


@dataclass(frozen=True)
class _Batch:
    """Rows with the options that they share and the requested outputs."""

    rows: BatchInputs
    options: RunOptions
    kept: BatchOutputs

    @cached_property
    def cut(self) -> Cut:
        """Time, mode and memory with which all rows begin."""
        origin = self.rows.origin
        return Cut(0.0) if origin is None else cut_of(self.rows.simulator, origin)

    def empty(self, count: int) -> BatchRows:
        """Return uninitialised ends of as many rows."""
        return BatchRows.empty(count, self.rows.simulator.outline, self.kept)

    def one_by_one(
        self,
        given: Callable[[int], dict[str, float]] | None = None,
        changes: Mapping[str, Any] | None = None,
    ) -> BatchRows:
        """Return the ends of single runs in Python, where no compiled batch serves them.

        `given` returns the states and parameters of a row where they are not those of `rows`,
        `changes` are phases and inputs.
        """
        rows, simulator = self.rows, self.rows.simulator
        ends = self.empty(rows.count)
        for first, stop in _spans(rows.count, 1):
            block = rows.starts(first, stop)
            for i, refusal in enumerate(block.refusal.tolist(), first):
                end = ends.part(slice(i, i + 1))
                if refusal != RUNS:
                    end.fill_unmoved(np.array([True]), block.states[i - first][None], refusal)
                    continue
                force = None if rows.force is None else float(rows.part(rows.force, i, i + 1)[0])
                row, origin = (given or rows.row)(i), rows.origin
                record = Record.DENSE if changes is None else Record.EVENTS
                run = run_row(simulator, row, self.options, record, force, changes, origin)
                _fill(end, run, simulator.outline.kinds, self.kept)
                end.energy_residual[:] = _residual_of_ends(run)
        return ends

    def in_threads(self, engine: CompiledEngine, threads: int) -> BatchRows:
        """Return the ends of compiled runs."""
        if self.cut.time:
            rest = replace(self, options=options_of_rest(self.options, self.cut))
            return rest.at_once(engine, threads).later(self.cut.time, self.options.t_end)
        return self.at_once(engine, threads)

    def at_once(self, engine: CompiledEngine, threads: int) -> BatchRows:
        """Return the ends of compiled runs whose times count from their starts."""
        count = self.rows.count
        ends, preparing = self.empty(count), threading.Lock()

        def work(span: tuple[int, int]) -> None:
            start, stop = span
            # Serialise the Python part; it holds the GIL anyway.
            with preparing:
                block = self.rows.starts(start, stop)
            self._integrate(engine, block, ends.part(slice(start, stop)))

        spans = list(_spans(count, threads))
        if min(threads, len(spans)) == 1:
            for span in spans:
                work(span)
            return ends
        with ThreadPoolExecutor(threads) as pool:
            # Propagate the first exception; pending blocks are cancelled.
            for _ in pool.map(work, spans):
                pass
        return ends

    def _integrate(self, engine: CompiledEngine, block: Starts, rows: BatchRows) -> None:
        """Fill the rows: of rejected starts at once, of the others by the engine."""
        runs, o = block.refusal == RUNS, self.options
        if not runs.all():
            rows.fill_unmoved(~runs, block.states, block.refusal[~runs])
            if runs.any():
                part = self.empty(int(runs.sum()))
                self._integrate(engine, block.chosen(runs), part)
                rows.put(runs, part)
            return
        atol, t_end = o.rtol * block.scales, np.full(len(block.states), o.t_end)
        given = block.states, block.parameters, t_end, atol
        engine.run_batch(*given, o, self.kept, rows, self.cut.memory)
        if self.rows.simulator.contact.can_open:
            _name_jams(self.rows.simulator, block.parameters, rows)


def _residual_of_ends(run: Trajectory) -> float:
    """Return `BatchRows.energy_residual` of a run."""
    record = run.record
    if not isinstance(record, RunRecord):
        return run.energy_residual
    if not len(run.step_time):
        return float("nan")
    terms = run.energies([run.step_time[0], run.final_time])
    del terms["total"]
    scale = record.start.scale[run.state_names.index(LOSSES[0])]
    return balance_residual(terms, float(scale))


def _fill(row: BatchRows, run: Trajectory, kinds: tuple[str, ...], kept: BatchOutputs) -> None:
    row.time[:], row.state[0], row.transition[:] = run.final_time, run.final_state, -1
    # A motion in pieces remembers one thing more.
    row.memory[0] = run.final_memory[: row.memory.shape[1]]
    row.mode[:] = run.record.engine_mode
    row.reason[:] = ROW_REASONS.index(run.stop_reason)
    row.counters[0] = [run.counters.get(name, 0) for name in COUNTERS]
    row.event_times[:] = np.nan
    for k, kind in enumerate(kinds):
        times = [e.time for e in run.events_of(kind)]
        row.event_counts[0, k] = len(times)
        row.event_times[0, k, : len(times[: kept.events])] = times[: kept.events]
    row.samples[:] = np.nan
    for k, name in enumerate(kept.at_events):
        values = run.at_events(name)[: kept.events]
        row.samples[0, k, : len(values)] = values


def _spans(count: int, threads: int) -> Iterator[tuple[int, int]]:
    """Yield first and end of the blocks: smaller ones first and last, where threads would wait.

    They double and halve, so that there are few sizes.
    """
    start, size = 0, BLOCK if threads == 1 else LEAST_BLOCK
    while start < count:
        yield start, min(start + size, count)
        start += size
        if threads > 1:
            room = max(LEAST_BLOCK, (count - start) // (2 * threads))
            size = min(2 * size, BLOCK)
            while size > room:
                size //= 2


def _name_jams(simulator: Simulator, parameters: Array, rows: BatchRows) -> None:
    """Name the slips that jam dynamically among those that meet A = 0."""
    met = np.flatnonzero(rows.reason == SINGULAR)
    for mode in set(rows.mode[met].tolist()):
        index = met[rows.mode[met] == mode]
        values = dict(zip(simulator.outline.parameter_names, parameters[index].T, strict=True))
        name = simulator.outline.modes[mode].name
        names = simulator.outline.state_names
        jam = jams(simulator.contact, name, names, rows.state[index], values)
        rows.reason[index[jam]] = DYNAMIC_JAM
