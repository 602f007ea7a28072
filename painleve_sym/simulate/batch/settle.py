"""Rows of rigid motion: bounces that die out are closed and followed on; jams are told apart."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.contacts.rigid import RigidContact
from painleve_sym.engines.batch import BatchRows, BatchWish
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.errors import EventKind
from painleve_sym.simulate.batch.reason_codes import ACCUMULATION, DYNAMIC_JAM, SINGULAR, UNTIL
from painleve_sym.simulate.locate_limit import jams
from painleve_sym.simulate.rigid import CLOSED, RigidSimulator


def run_rigid(
    simulator: RigidSimulator,
    engine: CompiledEngine,
    states: Array,
    parameters: Array,
    atol: Array,
    o: RunOptions,
    wish: BatchWish,
) -> BatchRows:
    """Return the ends of n rigid motions, each what `RigidSimulator.run` returns of it.

    Parameters
    ----------
    states, atol : ndarray, shape (n, nx)
    parameters : ndarray, shape (n, np)
    o : RunOptions
        With start events.
    """
    rows = engine.batch_rows(len(states), wish)
    engine.run_batch(states, parameters, np.full(len(states), o.t_end), atol, o, wish, rows)
    if isinstance(simulator.contact, RigidContact):
        rows = _with_settle(rows)
        _follow(simulator, engine, parameters, atol, o, wish, rows)
        _name_jams(simulator, simulator.contact, parameters, rows)
    return rows


def _with_settle(rows: BatchRows) -> BatchRows:
    """Return the rows with one more kind of event, which has not happened."""
    n, _, events = rows.event_times.shape
    times = np.concatenate([rows.event_times, np.full((n, 1, events), np.nan)], axis=1)
    counts = np.hstack([rows.event_counts, np.zeros((n, 1), np.int64)])
    return replace(rows, event_times=times, event_counts=counts)


def _follow(
    simulator: RigidSimulator,
    engine: CompiledEngine,
    parameters: Array,
    atol: Array,
    o: RunOptions,
    wish: BatchWish,
    rows: BatchRows,
) -> None:
    """Go on with the rows that ended where bounces accumulate; what follows is joined to them."""
    gap, rate = simulator.closing
    scale = atol / o.rtol
    index = np.flatnonzero(rows.reason == ACCUMULATION)
    started = np.full(len(rows.time), -1.0)
    while len(index):
        state, time = rows.state[index], rows.time[index]
        near = np.abs(state[:, gap]) < CLOSED * scale[index, gap]
        slow = np.abs(state[:, rate]) < 1e3 * CLOSED * scale[index, rate]
        index = index[near & slow & (time != started[index])]
        _note_settle(rows, index, wish)
        if EventKind.SETTLE in o.until:
            rows.reason[index], rows.memory[index] = UNTIL, 0.0
            rows.state[index[:, None], [gap, rate]] = 0.0
            return
        index = index[o.t_end - rows.time[index] > 0]
        if not len(index):
            return
        start = rows.time[index]
        states = rows.state[index].copy()
        states[:, [gap, rate]] = 0.0
        part = engine.batch_rows(len(index), wish)
        engine.run_batch(states, parameters[index], o.t_end - start, atol[index], o, wish, part)
        later = shifted(_with_settle(part), start)
        rows.put(index, joined(rows.taken(index), later, wish))
        started[index] = start
        index = index[part.reason == ACCUMULATION]


def _note_settle(rows: BatchRows, index: Any, wish: BatchWish) -> None:
    count = rows.event_counts[index, -1]
    room = count < wish.events
    rows.event_times[index[room], -1, count[room]] = rows.time[index[room]]
    rows.event_counts[index, -1] += 1


def _name_jams(
    simulator: RigidSimulator, contact: RigidContact, parameters: Array, rows: BatchRows
) -> None:
    """Tell the slips that jam dynamically from others that meet A = 0."""
    met = np.flatnonzero(rows.reason == SINGULAR)
    for mode in np.unique(rows.mode[met]):
        index = met[rows.mode[met] == mode]
        values = dict(zip(simulator.outline.parameters, parameters[index].T, strict=True))
        name = simulator.outline.modes[int(mode)].name
        rows.reason[index[jams(contact, name, rows.state[index], values)]] = DYNAMIC_JAM


def shifted(rows: BatchRows, start: Array) -> BatchRows:
    """Return rows that began at the times `start`, shape (n,)."""
    extremes = rows.extremes.copy()
    extremes[:, :, 1] += start[:, None]
    return replace(
        rows,
        time=rows.time + start,
        event_times=rows.event_times + start[:, None, None],
        extremes=extremes,
    )


def joined(first: BatchRows, then: BatchRows, wish: BatchWish) -> BatchRows:
    """Return rows of motions that went on: ends of `then`, and what both hold."""
    changes: dict[str, Any] = {
        "counters": first.counters + then.counters,
        "event_counts": first.event_counts + then.event_counts,
        "integrals": first.integrals + then.integrals,
    }
    if wish.events:
        count = np.minimum(first.event_counts, wish.events)
        # Times of the later part follow those of the earlier one, as far as there is room.
        place = np.arange(wish.events)[None, None, :]
        ahead = np.maximum(place - count[:, :, None], 0)
        later = np.take_along_axis(then.event_times, ahead, axis=2)
        changes["event_times"] = np.where(place < count[:, :, None], first.event_times, later)
    sign = np.where(np.arange(first.extremes.shape[1]) < len(wish.maxima), 1.0, -1.0)
    better = sign * then.extremes[:, :, 0] > sign * first.extremes[:, :, 0]
    changes["extremes"] = np.where(better[:, :, None], then.extremes, first.extremes)
    return replace(then, **changes)
