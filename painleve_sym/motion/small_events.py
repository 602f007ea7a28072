"""Events of a motion that is rounding: what happens within the tolerance of the run."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.errors import EventKind

if TYPE_CHECKING:
    from painleve_sym.motion.records import EventRecord
    from painleve_sym.motion.trajectory import Trajectory

RATES = {
    EventKind.MAX_COMPRESSION: "gap_rate",
    EventKind.RELOAD: "gap_rate",
    EventKind.YIELD: "gap_rate",
    EventKind.SEPARATION: "gap_rate",
    EventKind.LIFTOFF: "gap_rate",
    EventKind.TOUCHDOWN: "gap_rate",
    EventKind.SLIP_STOP: "slip_velocity",
    EventKind.SLIP_START: "slip_velocity",
}
"""The rate of a contact by which an event of a kind is rounding or not."""
PARTS = (0.25, 0.5, 0.75)
"""Of the time between two events, at which rates are looked at."""


def events_above_tolerance(run: Trajectory) -> tuple[EventRecord, ...]:
    """Return the events without those whose rate stays below the tolerance on both sides.

    The rate is that of the gap, or the slip velocity, of the event's contact, from the event of
    such a rate before it to the one after it. All events where no steps were kept.
    """
    if not len(run.step_time) or run.evaluator is None:
        return run.events
    small: set[int] = set()
    for contact in run.names.contacts:
        for rate in sorted(set(RATES.values())):
            of_rate = [i for i, e in enumerate(run.events) if RATES.get(e.kind) == rate]
            own = [i for i in of_rate if run.events[i].contact == contact]
            still = _still(run, [run.events[i].time for i in own], rate, contact)
            sides = itertools.pairwise(still)
            small.update(i for i, both in zip(own, sides, strict=True) if all(both))
    return tuple(e for i, e in enumerate(run.events) if i not in small)


def _still(run: Trajectory, times: list[float], rate: str, contact: str) -> list[bool]:
    """Return whether a rate stays below the tolerance between times, from start to end."""
    ends = np.array([float(run.t[0]), *times, run.final_time])
    looked_at: Array = ends[:-1, None] + np.diff(ends)[:, None] * np.array(PARTS)
    rates = run.values(run.names.of_contact(rate, contact), looked_at.ravel())
    still = np.abs(rates) <= run.tolerance(rate, contact)
    return [bool(row.all()) for row in still.reshape(looked_at.shape)]
