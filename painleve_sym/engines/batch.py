"""Requested outputs of a batch of runs, and the arrays that hold them: one row per run."""

from __future__ import annotations

import ctypes
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.automata.signature import Outline
from painleve_sym.engines.protocol import ENGINE_REASONS
from painleve_sym.equality import Compared
from painleve_sym.errors import EventKind, InputError, StopReason, refuse_unknown

COUNTERS = (
    "accepted_steps",
    "rejected_steps",
    "field_evaluations",
    "guard_evaluations",
    "dense_outputs",
    "events",
)
MAX_EVENTS_KEPT = 10_000
"""Event times of one kind and row: beyond it a single run with its record serves better."""


SIDES = ("before", "after")
"""Of an instant at which events happen."""


class AtEvents(NamedTuple):
    """A quantity on one side of the instants of events, as ``gap_rate_before_touchdown`` names it.

    Of all that happens at an instant, as in an impact, both sides are those of the whole.
    """

    quantity: str
    side: str
    kind: str

    @classmethod
    def of(cls, name: str, kinds: Sequence[str] = tuple(EventKind)) -> AtEvents | None:
        """Return what a name stands for; None where it has no such ending."""
        for kind, side in itertools.product(kinds, SIDES):
            quantity = name.removesuffix(f"_{side}_{kind}")
            if quantity and quantity != name:
                return cls(quantity, side, str(kind))
        return None


@dataclass(frozen=True)
class BatchOutputs:
    """Per-run outputs to record, besides the end of the run.

    The first event times of each kind, outputs of which the largest and smallest value over the run
    is kept, with its time, outputs that are integrated over time, and values at the first events
    (`AtEvents`).
    """

    events: int = 1
    maxima: tuple[str, ...] = ()
    minima: tuple[str, ...] = ()
    integrals: tuple[str, ...] = ()
    at_events: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not 0 <= self.events <= MAX_EVENTS_KEPT:
            raise InputError(
                f"batch: events: got {self.events!r}, need a whole number from 0 to "
                f"{MAX_EVENTS_KEPT}."
            )

    @property
    def watched(self) -> tuple[str, ...]:
        """Names of the outputs whose maxima, minima or integrals are requested, in this order."""
        return (*self.maxima, *self.minima, *self.integrals)

    def indices(self, outputs: Sequence[str]) -> list[int]:
        """Return the indices of the watched outputs; InputError for an unknown one."""
        for name in self.watched:
            refuse_unknown("output", name, outputs, "batch")
        return [outputs.index(name) for name in self.watched]

    def samples(self, outline: Outline) -> list[tuple[int, int, int]]:
        """Return kind, side and quantity of `at_events` as C reads them; InputError for others."""
        known, rows = quantities_at_events(outline), []
        for name in self.at_events:
            at = checked_at_events(name, outline, "batch: at_events")
            place = SIDES.index(at.side), known.index(at.quantity)
            rows.append(([str(k) for k in outline.kinds].index(at.kind), *place))
        return rows


def quantities_at_events(outline: Outline) -> tuple[str, ...]:
    """Return the names of what has values at events: outputs, then states."""
    return (*outline.output_names, *outline.state_names)


def checked_at_events(name: str, outline: Outline, where: str) -> AtEvents:
    """Return what a name stands for; InputError for an event or a quantity that there is not."""
    at = AtEvents.of(name, outline.kinds)
    if at is None:
        raise InputError(
            f"{where}: got {name!r}, need QUANTITY_before_EVENT or QUANTITY_after_EVENT. "
            f"Events: {', '.join(map(str, outline.kinds))}."
        )
    refuse_unknown("quantity", at.quantity, quantities_at_events(outline), f"{where}: {name}")
    return at


@dataclass(frozen=True, eq=False)
class BatchRows(Compared):
    """Ends of n runs; every array has n rows.

    `mode` and `transition` are indices, of the mode and of the transition that ended the run or -1;
    `reason` is the number of the stop reason (the engine's are `ENGINE_REASONS`). Columns of
    `event_counts` are kinds. `event_times` has kinds and events, nan where there was no such event;
    `extremes` has maxima, then minima, value and time of each. `energy_residual` is the change of
    all energies from start to end, relative to the largest of them there, or to that by which the
    tolerance of the works is measured; inf where one is not finite, nan where no time passed.
    `samples` has values at events, nan where there was none.
    """

    time: Array
    state: Array
    memory: Array
    mode: NDArray[np.int32]
    reason: NDArray[np.int32]
    transition: NDArray[np.int32]
    counters: NDArray[np.int64]
    event_counts: NDArray[np.int64]
    event_times: Array
    extremes: Array
    integrals: Array
    energy_residual: Array
    samples: Array

    def later(self, time: float, t_end: float) -> BatchRows:
        """Return the same ends later by some seconds; runs to the end are at its time."""
        whole = self.reason == ENGINE_REASONS.index(StopReason.T_END)
        extremes = self.extremes.copy()
        extremes[..., 1] += time
        return replace(
            self,
            time=np.where(whole, t_end, self.time + time),
            event_times=self.event_times + time,
            extremes=extremes,
        )

    @classmethod
    def empty(cls, n: int, outline: Outline, kept: BatchOutputs) -> BatchRows:
        """Return uninitialised rows."""
        kinds = max(1, len(outline.kinds))
        return cls(
            np.empty(n),
            np.empty((n, len(outline.state_names))),
            np.empty((n, len(outline.memory_names))),
            mode=np.empty(n, np.int32),
            reason=np.empty(n, np.int32),
            transition=np.empty(n, np.int32),
            counters=np.empty((n, len(COUNTERS)), np.int64),
            event_counts=np.empty((n, kinds), np.int64),
            event_times=np.empty((n, kinds, kept.events)),
            extremes=np.empty((n, len(kept.maxima + kept.minima), 2)),
            integrals=np.empty((n, len(kept.integrals))),
            energy_residual=np.empty(n),
            samples=np.empty((n, len(kept.at_events), kept.events)),
        )

    def part(self, rows: Any) -> BatchRows:
        """Return the rows chosen by a slice (a view), a mask or numbers (a copy)."""
        return BatchRows(*(getattr(self, f.name)[rows] for f in fields(self)))

    def put(self, rows: Any, other: BatchRows) -> None:
        """Overwrite some rows, chosen by a mask or by numbers."""
        for f in fields(self):
            getattr(self, f.name)[rows] = getattr(other, f.name)

    def fill_unmoved(self, rows: Any, states: Array, reason: Any) -> None:
        """Overwrite some rows, a mask of shape (n,), by motions that ended where they began.

        The states are those of these rows, the reason is that of all of them, or of each.
        """
        for f in fields(self):
            array = getattr(self, f.name)
            array[rows] = np.nan if array.dtype.kind == "f" else 0
        for zero in (self.time, self.memory, self.integrals):
            zero[rows] = 0.0
        self.state[rows] = states[rows]
        self.reason[rows], self.transition[rows] = reason, -1


class Ends(ctypes.Structure):
    """Addresses of the arrays of `BatchRows`, in its order."""

    _fields_ = tuple((f.name, ctypes.c_void_p) for f in fields(BatchRows))

    @classmethod
    def of(cls, rows: BatchRows) -> Ends:
        """Return the addresses; the caller keeps the arrays."""
        return cls(*(getattr(rows, f.name).ctypes.data for f in fields(rows)))


class Given(ctypes.Structure):
    """Number of rows and addresses of states, parameters, end times, tolerances and memory."""

    _fields_ = (
        ("rows", ctypes.c_long),
        *((name, ctypes.c_void_p) for name in ("states", "parameters", "t_end", "atol", "memory")),
    )


class Kept(ctypes.Structure):
    """`BatchOutputs` as C reads it."""

    _fields_ = (
        *((name, ctypes.c_int) for name in ("events", "maxima", "minima", "integrals", "samples")),
        ("of", ctypes.c_void_p),
        ("sample", ctypes.c_void_p),
    )
