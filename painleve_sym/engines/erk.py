"""The engine without a compiler: an automaton of one contact on CasADi's `erk` integrator."""

from __future__ import annotations

import threading
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.automata.automaton import Choice, HybridAutomaton
from painleve_sym.automata.signature import Outline
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.codegen.tape import TapeOutputs, tapes_of_functions
from painleve_sym.engines.batch import COUNTERS
from painleve_sym.engines.erk_mode import GRID, Call, ModeRunner, Window
from painleve_sym.engines.protocol import (
    BEFORE,
    CLOSED,
    DENSE_ROWS,
    REMAINDER,
    SHRINKING,
    Listener,
    Prepared,
    RawRun,
    RunOptions,
)
from painleve_sym.engines.records import EventRecords, StepRecords
from painleve_sym.errors import EventKind, InputError, StopReason

_ROUGH, _ROUGHEST = 10.0, 1e-12
"""Error between the points of a grid: this multiple of rtol, and not less than the second."""
_REPLACEMENTS = 8
"""Times that an earlier event may replace one; each is earlier still, so one or two are usual."""

# As in the compiled engine, whose decisions are repeated here.
_FROM_REST = 1e-4
_CHAIN = 64
ZERO_TIME, MOMENT = 1e-10, 16e-16

HUGE = 1e300
"""Stands for inf, so that 0·inf is not nan."""


def guard_side(g: float, d: float, d2: float, h: float, departs: bool, moment: float = 0.0) -> int:
    """1: on the positive side, armed; 0: at zero and leaving upwards; -1: fires now.

    A guard that rises above zero within a `moment`, which the time does not resolve, is at zero.
    """
    d = float(np.nan_to_num(d, nan=0.0, posinf=HUGE, neginf=-HUGE))
    d2 = d2 if np.isfinite(d2) else 0.0
    first, second = d * ZERO_TIME * h, 0.5 * d2 * (ZERO_TIME * h) ** 2
    band = abs(first) + abs(second)
    if g > band:
        return 1
    if g < -max(band, d * moment):
        return -1
    if departs:
        return 0
    return -1 if (first if abs(first) > abs(second) else second) < 0 else 0


@dataclass
class IntervalHistory:
    """Previous times of one transition."""

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
        # The slower of the last two ratios: one short interval alone is not an accumulation.
        ratio, self.ratio = max(interval / before, self.ratio), interval / before
        self.shrinking += 1
        return self.shrinking >= SHRINKING and interval * ratio / (1 - ratio) < REMAINDER * t


class _Run:
    """One run: its state, and the event loop of the compiled engine on windows instead of steps."""

    reason: StopReason | None = None
    stop_transition = -1
    hit = starting = False
    # The time since the start is t + t_base: t begins again at the limit of an accumulation.
    t_base, h_ref, limits = 0.0, 0.0, 0

    def __init__(
        self, engine: ErkEngine, x: Array, z: Array, c: Array, options: RunOptions
    ) -> None:
        self.engine, self.c, self.options = engine, c, options
        self.modes, self.x, self.z = engine.automaton.modes, x, z
        chosen = options.start_mode < 0
        self.mode = engine.start(x, z, c) if chosen else options.start_mode
        self.counters = Counter(dict.fromkeys(COUNTERS, 0))
        self.steps: list[Array] = []
        self.events: list[Array] = []
        self.armed = np.zeros(0, dtype=bool)
        self.history: dict[tuple[int, int], IntervalHistory] = {}
        self.atol = np.minimum(options.atol, HUGE)
        # Powers of two: scaling then rounds nothing. 2^500 leaves a state out of the error norm.
        exponent = np.round(np.log2(options.atol / options.rtol))
        self.scale = np.exp2(np.clip(exponent, -500, 500))

    def loop(self) -> None:
        """Integrate until there is a reason to stop."""
        # What the start state makes happen at once is its choice of mode, or events where asked.
        self.starting = self.options.start_mode < 0
        self.enter(visible=self.options.start_events)
        self.starting = False
        while self.running():
            self.advance()

    def enter(self, visible: bool) -> None:
        """Begin at t = 0 in the present state and mode; immediate transitions happen at once."""
        self.t, self.t_event, self.at_once = 0.0, -np.inf, 0
        self.t_end = self.options.t_end - self.t_base
        self.limit: tuple[int, int, float] | None = None
        self.history.clear()
        self.settle((), visible)
        if self.hit and self.reason is None:
            self.reason = StopReason.UNTIL
        self.length = self.options.first_step or self.h_ref

    def running(self) -> bool:
        """Whether the run continues."""
        while self.reason is StopReason.ACCUMULATION and self.pass_limit():
            pass
        return self.reason is None

    def pass_limit(self) -> bool:
        """Continue from the limit of events that accumulate; False: the run ends here."""
        again = self.limits and self.t_base + self.t == self.t_base
        if self.limit is None or self.limit[2] != self.t or again:
            return False
        mode, j, _ = self.limit
        transition, o = self.modes[mode].transitions[j], self.options
        at = transition.on_accumulation
        assert at is not None
        x, z = self.engine.runner(mode, o.rtol).limits[j](self.x, self.z, self.c)
        own = slice(0, len(self.engine.automaton.states))
        change, scale = np.abs(x - self.x)[own], (self.atol / o.rtol)[own]
        if not ((change == 0) | (change < CLOSED * scale)).all():
            return False
        before, self.mode = self.mode, self.engine.functions.mode_index[at.target]
        self.reason, self.limits = None, self.limits + 1
        self.note(at.kind, before, -1, transition.contact, x, z)
        self.x, self.z = x, z
        self.t_base, self.t = self.t_base + self.t, 0.0
        if self.hit:
            self.reason = StopReason.UNTIL
        elif not o.t_end - self.t_base > 0:
            self.reason = StopReason.T_END
        elif self.counters["events"] >= o.max_events:
            self.reason = StopReason.EVENT_LIMIT
        else:
            self.enter(visible=True)
        return True

    @property
    def runner(self) -> ModeRunner:
        """Integrator of the current mode."""
        return self.engine.runner(self.mode, self.options.rtol)

    # ---- entering a mode ----

    def first_step(self, f0: Array) -> float:
        """Return a first step (Hairer, Nørsett & Wanner 1993, II.4), as in C; f0 are the rates."""
        o, field = self.options, self.runner.field
        scale = self.atol + o.rtol * np.abs(self.x)
        d0, d1 = np.sum((self.x / scale) ** 2), np.sum((f0 / scale) ** 2)
        tau = _FROM_REST * self.t_end
        if d1 > 0:
            tau = np.sqrt(d0 / d1) if d0 > 1e-10 else _FROM_REST / (o.rtol * np.sqrt(d1))
        tau = min(tau, 100 * self.t_end)
        h = min(0.01 * tau, o.max_step)
        f1 = field(self.x + h * f0, self.z, self.c)[0]
        self.counters["field_evaluations"] += 1
        d2 = np.sum(((f1 - f0) / scale) ** 2)
        slope = np.fmax(np.sqrt(d1), np.sqrt(d2) / h)
        h1 = tau * (0.01 / (tau * slope)) ** 0.125 if slope > 0 else h
        h = float(np.fmin(100 * h, h1))
        return h if 0 < h < o.max_step else o.max_step

    def settle(self, departs: tuple[int, ...], visible: bool) -> None:
        """Make the transitions happen that must happen at once, then arm the guards."""
        for _ in range(_CHAIN):
            if self.reason is not None:
                return
            g, d, d2, rates = self.runner.jets(self.x, self.z, self.c)
            self.h_ref = self.first_step(rates)
            if not np.isfinite(self.h_ref):
                self.reason = StopReason.NON_FINITE
                return
            moment = MOMENT * abs(self.t)
            sides = [
                guard_side(g[j], d[j], d2[j], self.h_ref, j in departs, moment)
                for j in range(len(g))
            ]
            self.armed = np.array(sides) > 0
            transitions = self.modes[self.mode].transitions
            if transitions and transitions[-1].immediate:
                sides.append(-1)
            if -1 not in sides:
                return
            departs = self.apply(sides.index(-1), visible, timed=False)
        if self.reason is None:
            self.reason = StopReason.ACCUMULATION

    def apply(self, j: int, visible: bool, timed: bool) -> tuple[int, ...]:
        """Apply transition j, whose guard crossed zero (`timed`) or fired at once.

        Returns the guards of the new mode that are known to leave zero.
        """
        transition, before = self.modes[self.mode].transitions[j], self.mode
        if transition.watches:
            visible = not (transition.silent or self.starting)
        if visible and self.ends_before(transition.kind):
            self.reason, self.stop_transition = StopReason.UNTIL, j
            return ()
        at = (self.x, self.z, self.c, np.array([float(timed)]))
        x, z, conditions = self.runner.events[j](*at)
        departs: tuple[int, ...] = ()
        if transition.stop is None:
            choice = _chosen(conditions, transition.choices)
            self.mode = self.engine.functions.mode_index[choice.target]
            departs = self.engine.functions.departures(choice)
        else:
            self.reason, self.stop_transition = transition.stop, j
        if visible:
            self.note(transition.kind, before, j, transition.contact, x, z)
            self.check_events() if transition.watches else self.check_accumulation(before, j)
        if transition.on_accumulation is not None:
            self.limit = before, j, self.t
        self.x, self.z = x, z
        return departs

    def ends_before(self, kind: EventKind) -> bool:
        """Whether the run ends before an event of this kind, not that which it begins with."""
        begins = self.options.start_mode >= 0 and not self.t_base + self.t > 0
        return BEFORE + kind in self.options.until and not begins

    def note(self, kind: EventKind, before: int, j: int, contact: str, x: Array, z: Array) -> None:
        """Count and record an event; x and z are state and memory after it."""
        self.counters["events"] += 1
        self.hit |= kind in self.options.until
        if self.options.record != "end":
            automaton = self.engine.automaton
            place = automaton.contacts.index(contact) if contact else -1
            numbers = (before, j, self.mode, automaton.kinds.index(kind), place)
            head = [np.array([n]) for n in (self.t_base + self.t, *numbers)]
            values = [v[None] for v in (self.x, self.z, x, z)]
            self.events.append(EventRecords(*head, *values).rows())

    def check_accumulation(self, before: int, j: int) -> None:
        """Stop where the last event, of a transition of the mode before, is one too many."""
        self.at_once = self.at_once + 1 if self.t == self.t_event else 0
        self.t_event = self.t
        history = self.history.setdefault((before, j), IntervalHistory())
        if self.reason is None and (self.at_once >= _CHAIN or history.accumulates(self.t)):
            self.reason = StopReason.ACCUMULATION
        self.check_events()

    def check_events(self) -> None:
        """Stop where there are as many events as there may be."""
        if self.reason is None and self.counters["events"] >= self.options.max_events:
            self.reason = StopReason.EVENT_LIMIT

    # ---- smooth motion ----

    def window(self, length: float, watch: bool) -> tuple[Window | None, int]:
        """Integrate the current mode from here; return the window and the steps it took."""
        window, work = self.runner.window(self.x, self.z, self.c, self.scale, length, watch)
        done = work["n_steps"], work["n_reject"], work["n_rhs"], work.get("n_call_zeroF", 0) + GRID
        self.counters.update(dict(zip(COUNTERS, (*done, GRID), strict=False)))
        return window, done[0] + done[1]

    def advance(self) -> None:
        """One window, or the event it ran into."""
        o, length = self.options, min(self.length, self.options.max_step)
        last = self.t + length * 1.0000001 >= self.t_end
        if last:
            length = self.t_end - self.t
        if self.counters["accepted_steps"] + self.counters["rejected_steps"] >= o.max_steps:
            self.reason = StopReason.STEP_LIMIT
            return
        if not length > MOMENT * abs(self.t) + 1e-200:
            self.reason = StopReason.T_END if last else self.failure()
            return
        window, taken = self.window(length, watch=True)
        if window is None:
            self.length = length / GRID
            return
        if window.fired >= 0:
            self.run_into(window.fired, window.place * length, length)
            return
        if self.too_rough(window):
            return
        event = self.missed(window)
        if event is not None:
            self.run_into(*event, length)
            return
        self.accept(window)
        if last:
            self.t, self.reason = self.t_end, StopReason.T_END
        self.length = length * float(np.clip(GRID / max(taken, 1), 0.25, 4.0))

    def too_rough(self, window: Window) -> bool:
        """Whether the grid of a window is too coarse for its motion; then shorten the next one."""
        length, limit = float(window.times[-1]), max(_ROUGH * self.options.rtol, _ROUGHEST)
        excess = window.roughness(self.scale) / limit
        # Where a force sets in with a kink no grid is fine enough: there is an end to it.
        if not excess > 1 or length < ZERO_TIME * self.h_ref:
            return False
        self.length = length * max(0.8 * excess ** (-1 / 6), 1 / GRID)
        return True

    def failure(self) -> StopReason:
        """Return why no window can be integrated from here."""
        rate = self.runner.field(self.x, self.z, self.c)[0]
        finite = self.t > 0 and bool(np.isfinite(rate).all())
        return StopReason.STEP_UNDERFLOW if finite else StopReason.NON_FINITE

    def accept(self, window: Window) -> None:
        """Record a window and move to its end."""
        if self.options.record == "dense":
            records = StepRecords(
                time=self.t_base + (self.t + window.times[:-1]),
                length=np.diff(window.times),
                mode=np.full(GRID, self.mode),
                memory=np.tile(self.z, (GRID, 1)),
                polynomial=window.rows,
                bend=np.zeros(GRID),
            )
            self.steps.append(records.rows())
        self.t += float(window.times[-1])
        self.x = window.at.x[-1]
        self.armed |= window.at.g[-1] > 0

    # ---- events ----

    def run_into(self, j: int, tau: float, length: float) -> None:
        """Let guard j fire, which is zero at `tau` of a window, or an earlier one met on the way.

        Where the window is too long to resolve the event, a shorter one is tried first: a guard
        that does not leave zero as it should (`tau` is 0) may have left it and come back.
        """
        nearest = max(ZERO_TIME * self.h_ref, 1e-13 * self.t)
        replaced = 0
        while True:
            window = self.end_at_zero(j, tau) if tau >= 1e-14 * length else None
            if window is None and length <= nearest:
                # It fires after time has advanced: without an advance it might repeat without end.
                window = self.window(length, watch=False)[0]
            if window is None:
                self.length = length / GRID
                return
            if self.too_rough(window):
                return
            earlier = self.missed(window, ended=j)
            if earlier is None or length <= nearest or replaced == _REPLACEMENTS:
                break
            length, (j, tau), replaced = float(window.times[-1]), earlier, replaced + 1
        self.accept(window)
        self.settle(self.apply(j, visible=True, timed=True), visible=True)
        self.length = min(self.length, 10 * self.h_ref)
        if self.hit and self.reason is None:
            self.reason = StopReason.UNTIL

    def end_at_zero(self, j: int, tau: float) -> Window | None:
        """Integrate to where guard j is zero, to round-off; None if it is not zero near `tau`."""
        for _ in range(4):
            window = self.window(tau, watch=False)[0]
            if window is None:
                return None
            g, dg = float(window.at.g[-1, j]), float(window.at.dg[-1, j])
            # Newton on the length.
            more = -g / dg if dg < 0 else 0.0
            if abs(more) >= 1e-3 * tau or (g > 0 and dg >= 0):
                return window if g <= 0 else None
            if abs(more) <= 1e-12 * tau:
                # So close that the rest is linear, and the grid is as even as it was.
                return window.moved(more)
            tau += more
        return window

    def missed(self, window: Window, ended: int = -1) -> tuple[int, float] | None:
        """Return the first guard that reaches zero on the grid of a window, and when.

        It finds what `erk` leaves out: two crossings in one step, a guard that starts on its
        surface, the second of two guards. `ended` is the guard that is zero at the window's end.
        """
        if window.fired >= 0:
            return None
        end = float(window.times[-1])
        first, limit = None, end
        for j, armed in enumerate(self.armed):
            tau = self.runner.first_zero(window, j, bool(armed), GRID - (j == ended))
            if tau is None:
                continue
            # Of guards at one instant the first in the list fires, as in the compiled engine.
            if tau < limit * (1 - 1e-12) or (first is None and ended < 0):
                first, limit = (j, tau), tau
        return first


def _chosen(conditions: Array, choices: tuple[Choice, ...]) -> Choice:
    admitted = (c for c, v in zip(choices[:-1], conditions, strict=False) if v)
    return next(admitted, choices[-1])


class ErkEngine:
    """Runge–Kutta 5(4) of CasADi in its virtual machine: slower, and needs no compiler.

    The motion is integrated window by window. An event ends a window; the stretch up to it is then
    integrated again, so that the event lies at the end of a step and Newton places it to round-off.
    All else repeats the decisions of the compiled engine, which this one serves to check. Choices
    among the local modes of several contacts, and their impacts, are compiled code alone.
    """

    name = "erk"

    def __init__(
        self, automaton: HybridAutomaton, functions: AutomatonFunctions | None = None
    ) -> None:
        if automaton.parts:
            raise InputError(
                f"{automaton.name}: engine 'erk' runs one contact, got {len(automaton.parts)}: "
                "several contacts need compiled code. Fix: engine 'auto', and pip install "
                "'painleve-sym[compiler]' where there is no C compiler."
            )
        self.automaton, self.outline = automaton, Outline.of(automaton)
        self.functions = functions or AutomatonFunctions(automaton)
        self._runners: dict[tuple[int, float], ModeRunner] = {}
        self._calls: dict[str, Call] = {}
        # The functions work on arrays of their own: one run at a time.
        self._lock = threading.RLock()

    def _call(self, name: str, *arguments: Array) -> list[Array]:
        if name not in self._calls:
            self._calls[name] = Call(getattr(self.functions, name))
        return self._calls[name](*arguments)

    def runner(self, mode: int, rtol: float) -> ModeRunner:
        """Return a mode's integrator, built on first use: the tolerance is part of it."""
        runner = self._runners.get((mode, rtol))
        if runner is None:
            runner = self._runners[mode, rtol] = ModeRunner(self.functions, mode, rtol)
        return runner

    def start(self, x: Array, z: Array, c: Array) -> int:
        """Return the mode that a run from this state starts in."""
        choice = _chosen(self._call("starts", x, z, c)[0], self.automaton.starts)
        return self.functions.mode_index[choice.target]

    def constants(self, parameters: Array) -> Array:
        """Return the parameters followed by the definitions, shape (nc,)."""
        with self._lock:
            return self._call("constants", parameters)[0]

    def prepare(self, parameters: Array, given: Array, forces: Array) -> Prepared:
        """Return whole start states with their scales, of n rows; see `Engine.prepare`."""
        rows = []
        with self._lock:
            for p, own, force in zip(parameters, given, forces, strict=True):
                c = self.constants(p)
                state, admits = self._call("prepared", own, force, c)
                scales = self._call("scales", state, c)[0]
                rows.append(np.concatenate([state, admits, scales]))
        return Prepared.of(np.array(rows))

    def scales(self, parameters: Array, state: Array) -> Array:
        """Return the scale of each state at a state, shape (nx,)."""
        with self._lock:
            return self._call("scales", state, self.constants(parameters))[0]

    def run(
        self,
        state: Array,
        parameters: Array,
        options: RunOptions,
        memory: Array | None = None,
        listener: Listener | None = None,
    ) -> RawRun:
        """Integrate from t = 0; the mode is chosen from the state, the memory is 0 or given.

        A window, not a step, is what `first_step` and `max_step` bound, and `max_steps` is looked
        at before each window. There is nothing for the listener to hear.
        """
        x = np.array(state, dtype=np.float64)
        z = np.zeros(self.functions.z.numel()) if memory is None else np.array(memory)
        with self._lock, np.errstate(all="ignore"):
            r = _Run(self, x, z, self.constants(parameters), options)
            r.loop()
        nx, nz = len(x), len(r.z)
        return RawRun(
            time=r.t_base + r.t,
            state=r.x,
            memory=r.z,
            mode=r.mode,
            stop_reason=r.reason or StopReason.NO_MODE,
            stop_transition=r.stop_transition,
            steps=np.vstack([np.empty((0, StepRecords.width(nx, nz, DENSE_ROWS))), *r.steps]),
            events=np.vstack([np.empty((0, EventRecords.width(nx, nz))), *r.events]),
            counters=dict(r.counters),
        )

    def field(self, mode: int, state: Array, memory: Array, constants: Array) -> Array:
        """Return the rates of all states in a mode, shape (nx,)."""
        rates = self.functions.modes[mode].field(state, memory, constants)
        return np.array(rates).reshape(-1)

    def outputs(self, modes: Any, states: Array, memory: Array, constants: Array) -> Array:
        """Return the automaton's outputs at n points, shape (n, no)."""
        return self._tapes.outputs(modes, states, memory, constants)

    @cached_property
    def _tapes(self) -> TapeOutputs:
        return tapes_of_functions(self.functions)
