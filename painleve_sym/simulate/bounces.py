"""Rows of rigid motion whose bounces die out: closed, and followed on from there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from painleve_sym.codegen.batch import BatchRows, BatchWish
from painleve_sym.codegen.compiled import CompiledEngine
from painleve_sym.codegen.run import Array, RunOptions
from painleve_sym.codegen.source import ENGINE_REASONS
from painleve_sym.errors import StopReason
from painleve_sym.simulate.rigid import CLOSED, RigidSimulator

ACCUMULATION = ENGINE_REASONS.index(StopReason.ACCUMULATION)


def follow_bounces(
    simulator: RigidSimulator,
    engine: CompiledEngine,
    parameters: Array,
    atol: Array,
    o: RunOptions,
    wish: BatchWish,
    rows: BatchRows,
) -> None:
    """Go on with the rows that ended where bounces accumulate, as `RigidSimulator.run` does.

    Parameters
    ----------
    parameters : ndarray, shape (n, np)
    atol : ndarray, shape (n, nx)
    rows : BatchRows
        First runs of n rows; what follows is joined to them.
    """
    names, contact = simulator.outline.states, simulator.contact
    gap, rate = names.index(contact.gap), names.index(contact.gap_rate)
    scale = atol / o.rtol
    index = np.flatnonzero(rows.reason == ACCUMULATION)
    started = np.full(len(rows.time), -1.0)
    while len(index):
        state, time = rows.state[index], rows.time[index]
        near = np.abs(state[:, gap]) < CLOSED * scale[index, gap]
        slow = np.abs(state[:, rate]) < 1e3 * CLOSED * scale[index, rate]
        left = o.t_end - time
        index = index[near & slow & (time != started[index]) & (left > 0)]
        if not len(index):
            return
        start = rows.time[index]
        states = rows.state[index].copy()
        states[:, [gap, rate]] = 0.0
        part = engine.batch_rows(len(index), wish)
        given = (states, parameters[index], o.t_end - start, atol[index])
        engine.run_batch(*given, replace(o), wish, part)
        rows.put(index, joined(rows.taken(index), shifted(part, start), wish))
        started[index] = start
        index = index[part.reason == ACCUMULATION]


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
    count = np.minimum(first.event_counts, wish.events)
    # Times of the later part follow those of the earlier one, as far as there is room.
    place = np.arange(wish.events)[None, None, :]
    later = np.take_along_axis(then.event_times, np.maximum(place - count[:, :, None], 0), axis=2)
    times = np.where(place < count[:, :, None], first.event_times, later)
    sign = np.where(np.arange(first.extremes.shape[1]) < len(wish.maxima), 1.0, -1.0)
    better = sign * then.extremes[:, :, 0] > sign * first.extremes[:, :, 0]
    changes: dict[str, Any] = {
        "counters": first.counters + then.counters,
        "event_counts": first.event_counts + then.event_counts,
        "event_times": times,
        "extremes": np.where(better[:, :, None], then.extremes, first.extremes),
        "integrals": first.integrals + then.integrals,
    }
    return replace(then, **changes)
