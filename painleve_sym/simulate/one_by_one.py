"""Rows for simulators that no compiled batch serves: single runs in Python, one after another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from painleve_sym.codegen.batch import COUNTERS, BatchRows, BatchWish
from painleve_sym.codegen.run import RunOptions
from painleve_sym.codegen.source import ENGINE_REASONS
from painleve_sym.errors import StopReason
from painleve_sym.simulate.simulator import ContactSimulator
from painleve_sym.simulate.trajectory import Trajectory


def run_one_by_one(
    simulator: ContactSimulator,
    run: Callable[[int], Trajectory],
    start: Callable[[int], Any],
    outside: Any,
    o: RunOptions,
    wish: BatchWish,
) -> BatchRows:
    """Return the ends of the runs.

    Parameters
    ----------
    run : callable
        Row number → its trajectory.
    start : callable
        Row number → its state vector, shape (nx,).
    outside : ndarray of bool, shape (n,)
        Rows outside the mechanism's domain, which are not run.
    """
    kinds = simulator.event_kinds
    rows = BatchRows.empty(len(outside), simulator.outline, wish, len(kinds))
    for i, beyond in enumerate(outside):
        part = rows.part(slice(i, i + 1))
        if beyond:
            reason = ENGINE_REASONS.index(StopReason.LEFT_DOMAIN)
            part.fill_unmoved(np.array([True]), np.array([start(i)]), reason)
        else:
            _fill(part, run(i), kinds, wish.events)
    return rows


def _fill(row: BatchRows, found: Trajectory, kinds: tuple[str, ...], events: int) -> None:
    row.time[:], row.state[0], row.memory[0] = (
        found.final_time,
        found.final_state,
        found.final_memory,
    )
    row.mode[:], row.transition[:] = found.final_mode, -1
    row.reason[:] = ENGINE_REASONS.index(found.stop_reason)
    counters: Mapping[str, int] = found.counters
    row.counters[0] = [counters.get(name, 0) for name in COUNTERS]
    row.event_times[:] = np.nan
    for k, kind in enumerate(kinds):
        times = [e.time for e in found.events_of(kind)]
        row.event_counts[0, k] = len(times)
        kept = times[:events]
        row.event_times[0, k, : len(kept)] = kept
