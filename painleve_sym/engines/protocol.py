"""Interface of all engines: options of a run, and its raw result."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple, Protocol

from painleve_sym.arrays import Array
from painleve_sym.automata.signature import Outline
from painleve_sym.checks import LARGEST, number, whole_number
from painleve_sym.choices import Record, RecordLike, chosen
from painleve_sym.engines.records import EventRecords, StepRecords
from painleve_sym.errors import EventKind, StopReason
from painleve_sym.units import in_si

ENGINE_REASONS = (
    StopReason.T_END,
    StopReason.UNTIL,
    StopReason.LEFT_DOMAIN,
    StopReason.STEP_LIMIT,
    StopReason.EVENT_LIMIT,
    StopReason.ACCUMULATION,
    StopReason.NON_FINITE,
    StopReason.STEP_UNDERFLOW,
    StopReason.NO_MODE,
    StopReason.SINGULAR,
    StopReason.JAM,
    StopReason.VARYING_FRICTION,
)
"""Stop reasons in the order of the engine's own numbers."""

SHRINKING, REMAINDER, CLOSED = 6, 1e-11, 1e-6
"""Accumulation: this many intervals shrink, the rest is this part of the time so far; its limit is
passed where that changes states by less than this part of their scale. As in the compiled loop."""

DEFAULT_RTOL = 1e-11
"""The reference impacts then hold eight digits through all events, energy closes to 1e-9."""
MAX_STEPS, MAX_EVENTS = 1_000_000, 100_000
"""Limits of a run where none are given."""
MAX_LIMIT = 2**31 - 1
"""The largest limit: the loop counts in C."""

_UNITS = dict.fromkeys(("t_end", "first_step", "max_step"), "s")
"""Of the settings that have one."""

BEFORE = "before_"
"""Prefix of a kind in `RunSettings.until`: the run ends before an event of that kind happens."""
ENDLESS = (EventKind.SETTLE,)
"""Kinds of limits, before which no single event is the next: a run cannot end before them."""

ADMITS = 3
"""Answers of `Prepared.admits` to a start."""

Place = tuple[int, Sequence[float]]
"""A mode, by its index, and values of its memory: infinity for any."""
Places = Sequence[Place]

DENSE_ROWS = 8
"""Rows of a Runge–Kutta step's dense polynomial, the start value first (see `Trajectory`)."""


@dataclass(frozen=True)
class RunSettings:
    """Settings of a run that its caller chooses; see `painleve_sym.simulate`.

    `t_end` and steps in s; `rtol` in [1e-15, 1); `atol` is the absolute tolerance of each state, in
    its unit, and None scales it to the contact; events of the kinds `until` end the run, before
    they happen where ``before_`` precedes the kind. A `first_step` of 0 lets the engine choose it.
    """

    t_end: float
    rtol: float = DEFAULT_RTOL
    atol: Any = None
    until: str | Sequence[str] = ()
    record: RecordLike = Record.DENSE
    first_step: float = 0.0
    max_step: float = float("inf")
    max_steps: int = MAX_STEPS
    max_events: int = MAX_EVENTS

    @classmethod
    def of(cls, where: str, given: Mapping[str, Any]) -> RunSettings:
        """Return checked settings; InputError begins with `where`."""
        settings = cls(**in_si(given, _UNITS, where))
        end = settings.t_end
        if type(end) is not float or not 0 < end <= LARGEST:
            number(end, "t_end", where=where, above=0.0)
        settings.check(where)
        return settings

    def arguments(self, **changed: Any) -> dict[str, Any]:
        """Return the settings by name, those that are `changed` replaced."""
        return {f.name: getattr(self, f.name) for f in fields(RunSettings)} | changed

    def shared(self) -> dict[str, Any]:
        """Return the settings that batches have, too, by name."""
        every = self.arguments()
        return {name: every[name] for name in every if name not in ("atol", "record")}

    def check(self, where: str = "integration") -> None:
        """Raise InputError where a number is out of range, or no record has such a name."""
        # The defaults are right.
        usual = RunSettings
        if type(self.rtol) is not float or not 1e-15 <= self.rtol < 1:
            number(self.rtol, "rtol", where=where, lower=1e-15, below=1.0)
        if self.record is not usual.record:
            chosen(Record, self.record, "record", where)
        if self.first_step is not usual.first_step:
            number(self.first_step, "first_step", where=where, lower=0.0)
        if self.max_step is not usual.max_step and str(self.max_step) != "inf":
            number(self.max_step, "max_step", where=where, above=0.0)
        if self.max_steps is not usual.max_steps:
            whole_number(self.max_steps, "max_steps", where=where, lower=1, upper=MAX_LIMIT)
        if self.max_events is not usual.max_events:
            whole_number(self.max_events, "max_events", where=where, lower=1, upper=MAX_LIMIT)


@dataclass(frozen=True)
class RunOptions(RunSettings):
    """Settings of one integration, with the absolute tolerance of each state, in its unit.

    A tolerance of inf leaves its state out of the step control.

    `start_events` tells whether what the start state makes happen at once is recorded as events (an
    impact), or only chooses the mode. `start_mode` is the index of the mode to start in; -1: chosen
    from the state.
    """

    until: tuple[str, ...] = ()
    start_events: bool = False
    start_mode: int = -1

    def __post_init__(self) -> None:
        self.check()

    def with_tolerances(self, atol: Array) -> RunOptions:
        """Return the same options with other absolute tolerances; nothing else is checked again."""
        other = object.__new__(RunOptions)
        other.__dict__.update(self.__dict__, atol=atol)
        return other


class Prepared(NamedTuple):
    """Start states and scales of n runs, shape (n, nx).

    Below the scales only absolute errors count. `admits`, shape (n, 3), is 1 or 0: whether the
    contact laws admit a start, every constant is finite, and the start is inside the domain.
    """

    states: Array
    admits: Array
    scales: Array

    @classmethod
    def of(cls, rows: Array) -> Prepared:
        """Return views of rows that hold states, admits and scales in turn."""
        nx = (rows.shape[1] - ADMITS) // 2
        return cls(rows[:, :nx], rows[:, nx : nx + ADMITS], rows[:, nx + ADMITS :])


class RawRun(NamedTuple):
    """Raw result of an engine.

    `mode` is an index into the automaton's modes, `stop_transition` that of the transition that
    ended the run, -1 where none did. `steps` and `events` have the rows that `step_records` and
    `event_records` read.
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

    def later(self, time: float) -> RawRun:
        """Return the same run with all times later by some seconds."""
        steps, events = self.steps.copy(), self.events.copy()
        steps[:, :1] += time
        events[:, :1] += time
        return self._replace(time=self.time + time, steps=steps, events=events)

    @property
    def step_records(self) -> StepRecords:
        """The steps by field."""
        return StepRecords.of(self.steps, len(self.state), len(self.memory))

    @property
    def event_records(self) -> EventRecords:
        """The events by field."""
        return EventRecords.of(self.events, len(self.state), len(self.memory))


Listener = Callable[[int, int, Array], None]
"""Hears what happens in an impact of several contacts: kind, address of numbers, state after it.

It may change the state after it; see `painleve_sym.engines.impacts`.
"""


class Engine(Protocol):
    """An integrator of one automaton."""

    name: str

    @property
    def outline(self) -> Outline:
        """Names and structure of the automaton."""
        ...

    def constants(self, parameters: Array) -> Array:
        """Return the parameters followed by the definitions, shape (nc,)."""
        ...

    def prepare(self, parameters: Array, given: Array, forces: Array) -> Prepared:
        """Return whole start states with their scales; see `Preparation`.

        Of n runs: parameters (n, np), the first states, which the others follow from, and the
        initial forces, N; negative for none.
        """
        ...

    def scales(self, parameters: Array, state: Array) -> Array:
        """Return the scale of each state at a state, shape (nx,)."""
        ...

    def run(
        self,
        state: Array,
        parameters: Array,
        options: RunOptions,
        memory: Array | None = None,
        listener: Listener | None = None,
    ) -> RawRun:
        """Integrate from t = 0; the memory is 0 or given.

        The listener hears of impacts of several contacts. Where parts cannot choose and there are
        no impacts, the run ends with the reason NO_MODE.
        """
        ...

    def field(self, mode: int, state: Array, memory: Array, constants: Array) -> Array:
        """Return the rates of all states in a mode, shape (nx,)."""
        ...

    def outputs(self, modes: Any, states: Array, memory: Array, constants: Array) -> Array:
        """Return the automaton's outputs at n points, shape (n, no)."""
        ...
