"""What every engine takes and returns: options in, one raw run out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError, StopReason
from painleve_sym.hybrid.signature import Outline

SHRINKING, REMAINDER = 6, 1e-11
"""Accumulation: so many intervals shrink, and what is left is this part of the time so far."""

DENSE_ROWS = 8
"""Rows of a Runge–Kutta step's dense polynomial, the start value first (see `Trajectory`)."""


@dataclass(frozen=True)
class RunOptions:
    """How to integrate.

    Attributes
    ----------
    t_end : float
        End time; s.
    rtol : float
        Relative tolerance of every state.
    atol : ndarray, shape (nx,)
        Absolute tolerance of each state, in its unit; inf leaves it out of the step control.
    until : tuple of str
        Kinds of events that end the run.
    record : {"end", "events", "dense"}
        What is kept.
    first_step, max_step : float
        Bounds of the step; 0 lets the engine choose the first one. s.
    max_steps, max_events : int
    start_events : bool
        Whether what the start state makes happen at once is recorded as events (an impact), or
        only chooses the mode.
    start_mode : int
        Index of the mode to start in; -1: chosen from the state.
    start_departs : tuple of int
        Guards of that mode that are zero at the start and known to become positive.
    """

    t_end: float
    rtol: float
    atol: Array
    until: tuple[str, ...] = ()
    record: str = "dense"
    first_step: float = 0.0
    max_step: float = float("inf")
    max_steps: int = 1_000_000
    max_events: int = 100_000
    start_events: bool = False
    start_mode: int = -1
    start_departs: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if not self.rtol >= 1e-15 or not self.rtol < 1:
            raise InputError(f"integration: rtol: got {self.rtol!r}, need 1e-15 <= rtol < 1.")
        if self.record not in ("end", "events", "dense"):
            raise InputError(
                f"integration: record: got {self.record!r}, need end, events or dense."
            )
        if not self.max_step > 0 or not self.first_step >= 0:
            raise InputError("integration: max_step and first_step: need positive numbers.")
        if self.max_steps < 1 or self.max_events < 1:
            raise InputError("integration: max_steps and max_events: need at least 1.")


class RawRun(NamedTuple):
    """What an engine returns.

    Attributes
    ----------
    time : float
    state : ndarray, shape (nx,)
    memory : ndarray, shape (nz,)
    mode : int
        Index into the automaton's modes.
    stop_reason : StopReason
    stop_transition : int
        Index of the transition that ended the run, -1 where none did.
    steps : ndarray, shape (steps, 4 + nz + rows nx)
        t, h, mode, memory, the rows of the dense polynomial, the bend of time (see `Trajectory`).
    events : ndarray, shape (events, 4 + 2 (nx + nz))
        t, mode before, transition, mode after, state and memory before, and after.
    counters : dict
    """

    time: float
    state: Array
    memory: Array
    mode: int
    stop_reason: StopReason
    stop_transition: int
    steps: Array
    events: Array
    counters: dict[str, int]

    def shifted(self, start: float) -> RawRun:
        """Return the run as one that began at the time `start`; its arrays are reused."""
        if start == 0:
            return self
        for rows in (self.steps, self.events):
            rows[:, 0] += start
        return self._replace(time=self.time + start)


def joined_steps(runs: Sequence[RawRun]) -> Array:
    """Return the steps of runs that follow each other, shape (steps, …)."""
    # A run without steps does not know how many rows each would have.
    return np.vstack([r.steps for r in runs if len(r.steps)] or [runs[-1].steps])


@dataclass
class IntervalHistory:
    """When one transition happened before."""

    last: float = 0.0
    interval: float = 0.0
    ratio: float = 0.0
    shrinking: int = 0

    def accumulates(self, t: float) -> bool:
        """Whether the intervals shrink geometrically towards a limit that t has reached."""
        interval, before = t - self.last, self.interval
        self.last, self.interval = t, interval
        if not before > 0 or not interval < 0.9999 * before:
            self.shrinking = 0
            return False
        # The slower of the last two ratios: one short interval alone is no accumulation.
        ratio, self.ratio = max(interval / before, self.ratio), interval / before
        self.shrinking += 1
        return self.shrinking >= SHRINKING and interval * ratio / (1 - ratio) < REMAINDER * t


class Engine(Protocol):
    """An integrator of one automaton."""

    name: str

    @property
    def automaton(self) -> Outline:
        """What is integrated: names and structure at least."""
        ...

    def constants(self, parameters: Array) -> Array:
        """Return the parameters followed by the definitions, shape (nc,)."""
        ...

    def run(
        self,
        state: Array,
        parameters: Array,
        options: RunOptions,
        memory: Array | None = None,
    ) -> RawRun:
        """Integrate from t = 0; the memory is 0 or given."""
        ...

    def field(self, mode: int, state: Array, memory: Array, constants: Array) -> Array:
        """Return the rates of all states in a mode, shape (nx,)."""
        ...

    def outputs(self, modes: Any, states: Array, memory: Array, constants: Array) -> Array:
        """Return the automaton's outputs at n points, shape (n, no)."""
        ...
