"""Rows for simulators that no compiled batch serves: single runs in Python, one after another."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from painleve_sym.engines.batch import COUNTERS, BatchRows, BatchWish
from painleve_sym.simulate.batch.reason_codes import ROW_REASONS
from painleve_sym.simulate.batch.starts import RUNS, Starts
from painleve_sym.simulate.simulator import Simulator
from painleve_sym.simulate.trajectory import Trajectory


def run_one_by_one(
    simulator: Simulator,
    run: Callable[[int], Trajectory],
    blocks: Iterable[Starts],
    count: int,
    wish: BatchWish,
) -> BatchRows:
    """Return the ends of the runs.

    Parameters
    ----------
    run : callable
        Row number → its trajectory.
    blocks : iterable of Starts
        Of them only the rows that cannot run are taken.
    count : int
        Of rows.
    """
    kinds = simulator.outline.kinds
    rows = BatchRows.empty(count, simulator.outline, wish)
    for block in blocks:
        for i, refusal in enumerate(block.refusal.tolist(), block.first):
            part = rows.part(slice(i, i + 1))
            if refusal == RUNS:
                _fill(part, run(i), kinds, wish.events)
            else:
                state = block.states[i - block.first][None]
                part.fill_unmoved(np.array([True]), state, refusal)
    return rows


def _fill(row: BatchRows, found: Trajectory, kinds: tuple[str, ...], events: int) -> None:
    row.time[:], row.state[0], row.memory[0] = (
        found.final_time,
        found.final_state,
        found.final_memory,
    )
    row.mode[:], row.transition[:] = found.final_mode, -1
    row.reason[:] = ROW_REASONS.index(found.stop_reason)
    counters: Mapping[str, int] = found.counters
    row.counters[0] = [counters.get(name, 0) for name in COUNTERS]
    row.event_times[:] = np.nan
    for k, kind in enumerate(kinds):
        times = [e.time for e in found.events_of(kind)]
        row.event_counts[0, k] = len(times)
        kept = times[:events]
        row.event_times[0, k, : len(kept)] = kept
