"""Many motions at once: arrays of states and parameters in, arrays of ends out."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.codegen.batch import BatchRows, BatchWish
from painleve_sym.codegen.compiled import CompiledEngine
from painleve_sym.codegen.run import Array, RunOptions
from painleve_sym.codegen.source import ENGINE_REASONS
from painleve_sym.errors import InputError, StopReason
from painleve_sym.simulate.bilateral import check_held
from painleve_sym.simulate.bounces import follow_bounces
from painleve_sym.simulate.compliant import SoftenedSimulator
from painleve_sym.simulate.many_inputs import ManyInputs
from painleve_sym.simulate.many_result import ManyResult, run_row
from painleve_sym.simulate.one_by_one import run_one_by_one
from painleve_sym.simulate.rigid import RigidSimulator
from painleve_sym.simulate.simulator import DEFAULT_RTOL, ContactSimulator
from painleve_sym.simulate.trajectory import Trajectory
from painleve_sym.simulate.two_contacts import TwoContactSimulator

BLOCK = 1024
"""Rows a thread takes at a time: some ten milliseconds, so that all threads end together."""
LEAST_BLOCK = 64
"""... where there are few rows."""

LEFT_DOMAIN = ENGINE_REASONS.index(StopReason.LEFT_DOMAIN)


def simulate_many(
    simulator: ContactSimulator,
    states: Mapping[str, ArrayLike],
    parameters: Mapping[str, ArrayLike] | None = None,
    *,
    t_end: float,
    until: str | tuple[str, ...] = (),
    initial_force: ArrayLike | None = None,
    rtol: float = DEFAULT_RTOL,
    threads: int | None = None,
    events: int = 1,
    maxima: tuple[str, ...] = (),
    minima: tuple[str, ...] = (),
    integrals: tuple[str, ...] = (),
    **limits: Any,
) -> ManyResult:
    """Integrate one motion for every entry of the arrays, in threads over compiled code.

    Each row is the same, bit for bit, as `simulator.run` on its own numbers: it depends neither on
    the other rows nor on the number of threads. A row that fails is a row with its stop reason;
    one that starts outside the mechanism's domain has ``left_domain`` at t = 0.

    Parameters
    ----------
    simulator : ContactSimulator
        Softened or rigid. Two rigid contacts, and the engine ``erk``, run row after row in Python.
    states : mapping of str to array_like
        Coordinates and velocities by name; absent ones are 0. SI units, rad.
    parameters : mapping of str to array_like
        Of mechanism and law; absent ones have their defaults.
    t_end, until, rtol
        As for `SoftenedSimulator.run`.
    initial_force : array_like
        Of a softened contact that starts with gap 0: the compression that carries it; N.
    threads : int
        By default the processors this process may use.
    events : int
        How many event times of each kind are kept, the first ones.
    maxima, minima : tuple of str
        Outputs (``normal_force``, ``compression``, …) of which the extreme over the run and its
        time are kept: located on the dense output of each step.
    integrals : tuple of str
        Outputs integrated over the run: of ``normal_force`` this is the normal impulse.
    **limits
        max_step, max_steps, max_events, first_step (`RunOptions`).

    Returns
    -------
    ManyResult
        Arrays of the shape that all the given ones broadcast to.

    Raises
    ------
    InputError
        Unknown names, shapes that do not fit, numbers that are not finite or out of range: before
        anything runs.
    """
    wish = BatchWish(events, tuple(maxima), tuple(minima), tuple(integrals))
    rows = ManyInputs.of(simulator, states, parameters or {}, initial_force)
    shared = _shared_options(simulator, t_end, until, rtol, limits)
    _check_outputs(simulator, wish)
    if _is_batched(simulator):
        found = _in_threads(simulator, rows, shared, wish, _thread_count(threads))
    else:
        found = _one_by_one(simulator, rows, shared, wish)
    return ManyResult(
        simulator=simulator,
        shape=rows.shape,
        inputs=rows.inputs,
        initial_force=rows.force,
        options=shared,
        wish=wish,
        rows=found,
    )


def _one_by_one(
    simulator: ContactSimulator, rows: ManyInputs, o: RunOptions, wish: BatchWish
) -> BatchRows:
    def run(i: int) -> Trajectory:
        more: dict[str, Any] = {}
        if rows.force is not None:
            more["initial_force"] = float(rows.part(rows.force, i, i + 1)[0])
        return run_row(simulator, simulator.mechanism, rows.row(i), o, "events", **more)

    def start(i: int) -> Any:
        return simulator.initial_states(rows.symbols(i, i + 1))[0]

    with np.errstate(all="ignore"):
        outside = rows.outside(rows.symbols(0, rows.count))
    return run_one_by_one(simulator, run, start, outside, o, wish)


def _thread_count(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0))
    if threads < 1:
        raise InputError(f"batch: threads: got {threads!r}, need at least 1.")
    return threads


def _is_batched(simulator: ContactSimulator) -> bool:
    compiled = isinstance(simulator.integrator, CompiledEngine)
    return compiled and not isinstance(simulator, TwoContactSimulator)


def _check_outputs(simulator: ContactSimulator, wish: BatchWish) -> None:
    wish.indices(simulator.outline.output_names)
    if wish.watched and not _is_batched(simulator):
        raise InputError(
            f"{simulator.where}: {wish.watched[0]}: extremes and integrals need the compiled "
            "engine and one contact. Fix: leave them out, or take them from single runs."
        )


def _shared_options(
    simulator: ContactSimulator,
    t_end: float,
    until: str | tuple[str, ...],
    rtol: float,
    limits: Mapping[str, Any],
) -> RunOptions:
    nothing = np.zeros(len(simulator.outline.states))
    options = {"t_end": t_end, "until": until, "rtol": rtol, "record": "events", **limits}
    return simulator.options(nothing, {}, atol=nothing, **options)


# ---- the work ----


@dataclass(frozen=True)
class _Block:
    """Rows ready for the engine."""

    states: Array
    parameters: Array
    atol: Array
    outside: Any

    def chosen(self, rows: Any) -> _Block:
        """Return the rows of a slice or a mask."""
        arrays = (self.states, self.parameters, self.atol, self.outside)
        return _Block(*(a[rows] for a in arrays))


def _in_threads(
    simulator: ContactSimulator, rows: ManyInputs, o: RunOptions, wish: BatchWish, threads: int
) -> BatchRows:
    engine = simulator.integrator
    assert isinstance(engine, CompiledEngine)
    found = engine.batch_rows(rows.count, wish)
    preparing = threading.Lock()

    def work(start: int) -> None:
        stop = min(start + size, rows.count)
        # Python's share: threads in turn, so that they do not fight over its one lock.
        with preparing:
            block = _prepared(simulator, engine, rows, start, stop, o)
        _integrate(simulator, engine, block, o, wish, found.part(slice(start, stop)))

    # A few blocks for each thread, but not so small that preparing them costs more than running.
    size = min(BLOCK, max(LEAST_BLOCK, -(-rows.count // (4 * threads))))
    starts = range(0, rows.count, size)
    if min(threads, len(starts)) == 1:
        for start in starts:
            work(start)
        return found
    with ThreadPoolExecutor(threads) as pool:
        # The first block that fails is the one that is heard of; no others begin after it.
        for _ in pool.map(work, starts):
            pass
    return found


def _prepared(
    simulator: ContactSimulator,
    engine: CompiledEngine,
    rows: ManyInputs,
    start: int,
    stop: int,
    o: RunOptions,
) -> _Block:
    # Outside the domain formulas may well divide by zero; those rows are not integrated.
    with np.errstate(all="ignore"):
        values = rows.symbols(start, stop)
        outside = rows.outside(values)
        parameters = np.array([values[s] for s in simulator.outline.parameters]).T.copy()
        constants = engine.many_constants(parameters)
        _check_constants(simulator, constants, start)
        states = simulator.initial_states(values)
        if rows.force is not None:
            assert isinstance(simulator, SoftenedSimulator)
            force = rows.part(rows.force, start, stop)
            states = simulator.with_forces(states, force, constants)
        if isinstance(simulator, RigidSimulator):
            _check_gaps(simulator, states[~outside])
        atol = o.rtol * simulator.all_tolerances(states, constants)
    return _Block(states, parameters, atol, outside)


def _check_constants(simulator: ContactSimulator, constants: Array, start: int) -> None:
    good = np.isfinite(constants)
    if good.all():
        return
    row, column = np.argwhere(~good)[0]
    names = (*simulator.outline.parameters, *simulator.outline.definitions)
    raise InputError(
        f"batch of {simulator.where}: row {start + int(row)}: {names[column]} comes out as "
        f"{float(constants[row, column])!r}, need a finite number. Fix: check the parameters it "
        "is made of (stiffness, curvatures)."
    )


def _check_gaps(simulator: RigidSimulator, states: Array) -> None:
    if not len(states):
        return
    contact, names = simulator.contact, simulator.outline.states
    gaps, rates = (states[:, names.index(s)] for s in (contact.gap, contact.gap_rate))
    if simulator.mechanism.contact.bilateral:
        for i in {int(np.argmax(np.abs(gaps))), int(np.argmax(np.abs(rates)))}:
            check_held(simulator.where, float(gaps[i]), float(rates[i]))
    elif gaps.min() < 0:
        raise InputError(
            f"batch of {simulator.where}: a row starts inside the ground, gap = "
            f"{float(gaps.min()):g} m, and a rigid contact has no compression. Fix: start with "
            "gap >= 0, or give a contact law."
        )


def _integrate(
    simulator: ContactSimulator,
    engine: CompiledEngine,
    block: _Block,
    o: RunOptions,
    wish: BatchWish,
    rows: BatchRows,
) -> None:
    """Fill the rows: those outside the domain at once, the others by the engine."""
    if block.outside.any():
        rows.fill_unmoved(block.outside, block.states, LEFT_DOMAIN)
        inside = ~block.outside
        if inside.any():
            part = engine.batch_rows(int(inside.sum()), wish)
            _integrate(simulator, engine, block.chosen(inside), o, wish, part)
            rows.put(inside, part)
        return
    t_end = np.full(len(block.states), o.t_end)
    if isinstance(simulator, RigidSimulator):
        o = replace(o, start_events=True)
    engine.run_batch(block.states, block.parameters, t_end, block.atol, o, wish, rows)
    if isinstance(simulator, RigidSimulator) and not simulator.mechanism.contact.bilateral:
        follow_bounces(simulator, engine, block.parameters, block.atol, o, wish, rows)
