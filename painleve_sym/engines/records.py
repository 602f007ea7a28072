"""Rows that engines keep of steps and events: the one place that knows their layout.

The numbers of the head are generated into the C of an engine (PS_STEP_HEAD, PS_EVENT_HEAD).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.equality import Compared

STEP_HEAD, EVENT_HEAD = 3, 6
"""Numbers before the memory of a step, and before the state of an event."""


def dense_values(rows: Array, u: Array) -> Array:
    """Return the dense polynomials of steps at points u in [0, 1], shape (n, nx).

    Rows have the shape (rows, nx), of one step, or (n, rows, nx), one for each point.
    """
    column, value = u[:, None], np.zeros((len(u), rows.shape[-1]))
    for k in range(rows.shape[-2] - 1, 0, -1):
        value = (value + rows[..., k, :]) * (column if k % 2 else 1 - column)
    total: Array = rows[..., 0, :] + value
    return total


@dataclass(frozen=True, eq=False)
class StepRecords(Compared):
    """Steps of a run, n of them: times and lengths in s, and the dense polynomials.

    These have the shape (n, rows, nx); `bend` is that of time (see `Trajectory`).
    """

    time: Array
    length: Array
    mode: NDArray[np.int64]
    memory: Array
    polynomial: Array
    bend: Array

    @staticmethod
    def width(nx: int, nz: int, rows: int) -> int:
        """Return how many numbers a row has."""
        return STEP_HEAD + nz + rows * nx + 1

    @classmethod
    def of(cls, rows: Array, nx: int, nz: int) -> StepRecords:
        """Return the records in the rows of an engine, shape (n, width)."""
        first = STEP_HEAD + nz
        return cls(
            time=rows[:, 0],
            length=rows[:, 1],
            mode=rows[:, 2].astype(np.int64),
            memory=rows[:, STEP_HEAD:first],
            polynomial=rows[:, first:-1].reshape(len(rows), (rows.shape[1] - first - 1) // nx, nx),
            bend=rows[:, -1],
        )

    def rows(self) -> Array:
        """Return the rows that `of` reads, shape (n, width)."""
        head = [self.time, self.length, self.mode]
        n, rows, nx = self.polynomial.shape
        flat = self.polynomial.reshape(n, rows * nx)
        return np.hstack([np.column_stack(head), self.memory, flat, self.bend[:, None]])


@dataclass(frozen=True, eq=False)
class EventRecords(Compared):
    """Events of a run, n of them, with states and memories, shapes (n, nx) and (n, nz); times in s.

    `transition` is the index in the mode before; −1 where no transition of that mode made the
    event. `kind` and `contact` are indices into the automaton's `kinds` and `contacts`; contact −1
    for no single one.
    """

    time: Array
    mode_before: NDArray[np.int64]
    transition: NDArray[np.int64]
    mode_after: NDArray[np.int64]
    kind: NDArray[np.int64]
    contact: NDArray[np.int64]
    state_before: Array
    memory_before: Array
    state_after: Array
    memory_after: Array

    @staticmethod
    def width(nx: int, nz: int) -> int:
        """Return how many numbers a row has."""
        return EVENT_HEAD + 2 * (nx + nz)

    @classmethod
    def of(cls, rows: Array, nx: int, nz: int) -> EventRecords:
        """Return the records in the rows of an engine, shape (n, width)."""
        mode, transition, target, kind, contact = rows[:, 1:EVENT_HEAD].astype(np.int64).T
        # Slices cost a tenth of `np.split`, which matters for loops of short runs.
        before, after = EVENT_HEAD + nx, EVENT_HEAD + nx + nz
        return cls(
            rows[:, 0],
            mode,
            transition,
            target,
            kind,
            contact,
            rows[:, EVENT_HEAD:before],
            rows[:, before:after],
            rows[:, after : after + nx],
            rows[:, after + nx :],
        )

    def rows(self) -> Array:
        """Return the rows that `of` reads, shape (n, width)."""
        head = (self.time, self.mode_before, self.transition, self.mode_after)
        columns = np.column_stack([*head, self.kind, self.contact])
        return np.hstack([columns, *self.before[1:], *self.after[1:]])

    @property
    def before(self) -> tuple[NDArray[np.int64], Array, Array]:
        """Modes, states and memories just before, as `Engine.outputs` takes them."""
        return self.mode_before, self.state_before, self.memory_before

    @property
    def after(self) -> tuple[NDArray[np.int64], Array, Array]:
        """The same just after."""
        return self.mode_after, self.state_after, self.memory_after
