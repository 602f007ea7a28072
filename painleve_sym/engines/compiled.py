"""The first engine: generated C and the event loop in C, driven through ctypes."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.compile import compiled_library, compiler_mark, library_named
from painleve_sym.codegen.derivation_cache import entry_key, read_entry, write_entry
from painleve_sym.engines.batch import (
    COUNTERS,
    BatchOutputs,
    BatchRows,
    Ends,
    Given,
    Kept,
    pointers,
)
from painleve_sym.engines.protocol import (
    DENSE_ROWS,
    ENGINE_REASONS,
    RawRun,
    Resolver,
    RunOptions,
    run_resolved,
)
from painleve_sym.engines.records import EventRecords, StepRecords
from painleve_sym.errors import NoRecurrence, StopReason
from painleve_sym.hybrid.signature import AutomatonBuilder, Outline

if TYPE_CHECKING:
    from painleve_sym.codegen.modes import AutomatonFunctions
    from painleve_sym.hybrid.automaton import HybridAutomaton

_DECISION = -2
"""Reason of a run that asks for a decision (PS_DECISION)."""
_HEAD = 12
"""Numbers before the state in what a run returns."""
_RECORD = {"end": 0, "events": 1, "dense": 2}
_pointer = ctypes.POINTER(ctypes.c_double)
_address = ctypes.c_void_p


class _Rows(ctypes.Structure):
    _fields_ = (
        ("data", _pointer),
        ("used", ctypes.c_long),
        ("room", ctypes.c_long),
        ("width", ctypes.c_long),
    )

    def array(self) -> Array:
        if not self.used:
            return np.empty((0, self.width))
        return np.ctypeslib.as_array(self.data, (self.used, self.width)).copy()


def _structures(nx: int, nz: int, kinds: int) -> tuple[Any, Any]:
    class Options(ctypes.Structure):
        _fields_ = (
            ("rtol", ctypes.c_double),
            ("h0", ctypes.c_double),
            ("h_max", ctypes.c_double),
            ("t_end", ctypes.c_double),
            ("atol", ctypes.c_double * nx),
            ("max_steps", ctypes.c_long),
            ("max_events", ctypes.c_long),
            ("until", ctypes.c_ubyte * kinds),
            ("record", ctypes.c_int),
            ("start_events", ctypes.c_int),
            ("start_mode", ctypes.c_int),
            ("start_departs", ctypes.c_uint64),
        )

    class Run(ctypes.Structure):
        _fields_ = (
            ("t", ctypes.c_double),
            ("x", ctypes.c_double * nx),
            ("z", ctypes.c_double * (nz + 1)),
            ("mode", ctypes.c_long),
            ("reason", ctypes.c_long),
            ("stop_transition", ctypes.c_long),
            ("counters", ctypes.c_long * 6),
            ("steps", _Rows),
            ("events", _Rows),
        )

    return Options, Run


class CompiledEngine:
    """Runge–Kutta 8(5,3) with located events, wholly in compiled code.

    Parameters
    ----------
    automaton : HybridAutomaton
    functions : AutomatonFunctions, optional
        Its functions, where they are not the plain ones.

    Raises
    ------
    CompilerMissing, CompileError
    """

    name = "compiled"
    dense_rows = DENSE_ROWS
    lanes = 1  # motions of a batch side by side

    def __init__(
        self, automaton: HybridAutomaton, functions: AutomatonFunctions | None = None
    ) -> None:
        from painleve_sym.codegen.modes import AutomatonFunctions

        functions = functions or AutomatonFunctions(automaton)
        sizes = functions.x.numel(), functions.z.numel(), functions.c.numel()
        text = self._source(functions)
        self._open(
            Outline.of(automaton),
            compiled_library(self._alone(text)),
            lambda: compiled_library(text),
            (*sizes, functions.output_size),
        )

    @classmethod
    def of_builder(cls, builder: AutomatonBuilder) -> CompiledEngine:
        """Return the engine of what `builder` derives, from the cache where it was derived before.

        A builder is known again by its definition (`definition_text`); where the cache has what it
        led to, nothing is derived, and the engine knows the automaton's outline alone. That an
        automaton has no Taylor series is remembered as well.
        """
        mark = compiler_mark()
        key = entry_key(f"engine {cls.name}\n{mark}", builder) if mark else None
        engine = cls.__new__(cls)
        entry = read_entry(key) if key else None
        if entry and "no_recurrence" in entry:
            raise NoRecurrence(entry["no_recurrence"])
        library = library_named(entry["library"]) if entry else None
        if entry and library:
            engine._open(
                Outline.of_data(entry["outline"]), library, partial(cls._lanes_of, builder)
            )
            return engine
        from painleve_sym.codegen.modes import AutomatonFunctions

        automaton = builder.automaton
        try:
            text = cls._source(AutomatonFunctions(automaton))
        except NoRecurrence as error:
            if key:
                write_entry(key, {"no_recurrence": str(error)})
            raise
        library = compiled_library(cls._alone(text))
        engine._open(Outline.of(automaton), library, partial(cls._lanes_of, builder, text))
        if key:
            write_entry(key, {"library": library.name, "outline": engine.outline.to_data()})
        return engine

    @classmethod
    def _lanes_of(cls, builder: AutomatonBuilder, text: str | None = None) -> Path:
        """Return the library with lanes of what `builder` derives, from the cache where it is."""
        mark = compiler_mark()
        key = entry_key(f"lanes of engine {cls.name}\n{mark}", builder) if mark else None
        entry = read_entry(key) if key else None
        library = library_named(entry["library"]) if entry else None
        if library is None:
            from painleve_sym.codegen.modes import AutomatonFunctions

            text = text or cls._source(AutomatonFunctions(builder.automaton))
            library = compiled_library(text)
            if key:
                write_entry(key, {"library": library.name})
        return library

    def _open(
        self,
        outline: Outline,
        library: Path,
        lanes: Callable[[], Path],
        sizes: tuple[int, int, int, int] | None = None,
    ) -> None:
        self.library = library
        self._lanes_library = lanes
        self._lanes_lock = threading.Lock()
        self._batch: Any = None
        self.outline = outline
        self._nx, self._nz, self._nc, self._no = sizes or _plain_sizes(outline)
        self._options, self._run = _structures(self._nx, self._nz, max(1, len(outline.kinds)))
        self._library = ctypes.CDLL(str(library))
        self._end = ctypes.c_double * (_HEAD + self._nx + self._nz)
        self._tolerances = ctypes.c_double * self._nx
        self._no_steps = np.empty((0, StepRecords.width(self._nx, self._nz, self.dense_rows)))
        self._no_events = np.empty((0, EventRecords.width(self._nx, self._nz)))
        self._no_memory = bytes(8 * (self._nz + 1))
        self._library.ps_complete.restype = ctypes.POINTER(self._run)
        self._library.ps_complete.argtypes = (_address,) * 5
        self._library.ps_free.argtypes = (ctypes.POINTER(self._run),)
        self._library.ps_free.restype = None
        self._library.ps_many_constants.argtypes = (ctypes.c_long, _address, _address)
        self._library.ps_many_constants.restype = None
        self._library.ps_constants.argtypes = (_address, _address)
        self._library.ps_outputs.argtypes = (ctypes.c_long, *[_address] * 5)
        self._library.ps_evaluate.argtypes = (ctypes.c_int, *[_address] * 6)
        self._last_options: tuple[RunOptions, Any] | None = None

    @classmethod
    def _alone(cls, text: str) -> str:
        """Return the C of one motion at a time."""
        return text

    def _batch_of(self, lanes: int) -> Any:
        """Return the C function of a batch; with lanes, that of a library compiled for them."""
        if lanes == 1:
            return self._prepared(self._library.ps_batch)
        with self._lanes_lock:
            if self._batch is None:
                self._batch = ctypes.CDLL(str(self._lanes_library())).ps_batch
        return self._prepared(self._batch)

    def _prepared(self, batch: Any) -> Any:
        batch.restype = ctypes.c_long
        batch.argtypes = (
            ctypes.POINTER(Given),
            ctypes.POINTER(self._options),
            ctypes.POINTER(Kept),
            ctypes.c_int,
            ctypes.POINTER(Ends),
        )
        return batch

    @staticmethod
    def _source(functions: AutomatonFunctions) -> str:
        from painleve_sym.engines.source import source

        return source(functions)

    def constants(self, parameters: Array) -> Array:
        """Return the parameters followed by the definitions, shape (nc,)."""
        p, c = _plain(parameters), np.empty(self._nc)
        self._library.ps_constants(p.ctypes.data, c.ctypes.data)
        return c

    def _options_of(self, o: RunOptions) -> Any:
        # 1e100 stands for inf: a state left out must not turn 0·inf into nan in the norm, nor into
        # a number too small to be normal, which processors are slow with.
        atol = _plain(np.minimum(o.atol, 1e100))
        until = [kind in o.until for kind in self.outline.kinds] or [False]
        return self._options(
            o.rtol,
            o.first_step,
            min(o.max_step, 1e300),
            o.t_end,
            self._tolerances.from_buffer_copy(atol.tobytes()),
            o.max_steps,
            o.max_events,
            (ctypes.c_ubyte * len(until))(*until),
            _RECORD[o.record],
            o.start_events,
            o.start_mode,
            sum(1 << j for j in o.start_departs),
        )

    def run(
        self,
        state: Array,
        parameters: Array,
        options: RunOptions,
        memory: Array | None = None,
        resolve: Resolver | None = None,
    ) -> RawRun:
        """Integrate from t = 0; the memory is 0 or given."""
        if resolve is not None:
            return run_resolved(self, state, parameters, options, memory, resolve)
        # The same options object is used in loops of runs: its C form is kept.
        if self._last_options is None or self._last_options[0] is not options:
            self._last_options = (options, self._options_of(options))
        out: Any = self._end()
        # Bytes are passed by address at a fraction of the price of `ndarray.ctypes`.
        x, p = _plain(state).tobytes(), _plain(parameters).tobytes()
        z = self._no_memory if memory is None else _plain(memory).tobytes()
        kept = self._library.ps_complete(x, z, p, ctypes.byref(self._last_options[1]), out)
        try:
            time, mode, reason, stop, *counters = out[:10]
            decision = reason == _DECISION
            if reason < 0 and not decision:
                raise MemoryError(
                    f"{self.name} engine: no memory for the record after t = {time:g} s. "
                    "Fix: record='events' keeps less."
                )
            steps, events = (kept.contents.steps, kept.contents.events) if kept else (None, None)
            values: Array = np.frombuffer(out)[_HEAD:]
            return RawRun(
                time=time,
                state=values[: self._nx],
                memory=values[self._nx : self._nx + self._nz],
                mode=int(mode),
                stop_reason=StopReason.NO_MODE if decision else ENGINE_REASONS[int(reason)],
                stop_transition=int(stop),
                steps=steps.array() if steps and steps.used else self._no_steps,
                events=events.array() if events and events.used else self._no_events,
                counters=dict(zip(COUNTERS, map(int, counters), strict=True)),
                decision=decision,
            )
        finally:
            if kept:
                self._library.ps_free(kept)

    def many_constants(self, parameters: Array) -> Array:
        """Return `constants` of n rows of parameters, shape (n, nc)."""
        p, c = _plain(parameters), np.empty((len(parameters), self._nc))
        self._library.ps_many_constants(len(p), p.ctypes.data, c.ctypes.data)
        return c

    def run_batch(
        self,
        states: Array,
        parameters: Array,
        t_end: Array,
        atol: Array,
        options: RunOptions,
        kept: BatchOutputs,
        rows: BatchRows,
    ) -> None:
        """Integrate every row from t = 0 as `run` would, in one call that holds no Python lock.

        Parameters
        ----------
        states : ndarray, shape (n, nx)
        parameters : ndarray, shape (n, np)
        t_end : ndarray, shape (n,)
        atol : ndarray, shape (n, nx)
        options : RunOptions
            What all rows share; its t_end, atol and record are not used.
        kept : BatchOutputs
        rows : BatchRows
            Filled; of n rows.
        """
        n = len(states)
        x, p, t = _plain(states), _plain(parameters), _plain(t_end)
        scales = np.minimum(_plain(atol), 1e100)
        shared = self._options_of(replace(options, atol=scales[0], record="end"))
        chosen = np.array(kept.indices(self.outline.output_names), dtype=np.int32)
        counts = (len(kept.maxima), len(kept.minima), len(kept.integrals))
        kept_in_c = Kept(kept.events, *counts, chosen.ctypes.data)
        ends = Ends(*pointers(rows))
        given = Given(n, *(a.ctypes.data for a in (x, p, t, scales)))
        done = self._batch_of(self.lanes if n > 1 else 1)(
            given, shared, kept_in_c, self.lanes, ends
        )
        if done < n:
            raise MemoryError("compiled engine: no memory for a run.")

    def field(self, mode: int, state: Array, memory: Array, constants: Array) -> Array:
        """Return the rates of all states in a mode, shape (nx,)."""
        count = max(1, *(len(m.transitions) for m in self.outline.modes))
        rates, guards = np.empty(self._nx), np.empty((2, count))
        inputs = [_plain(a) for a in (state, memory, constants)]
        addresses = [a.ctypes.data for a in (*inputs, rates, guards[0], guards[1])]
        self._library.ps_evaluate(mode, *addresses)
        return rates

    def outputs(self, modes: Any, states: Array, memory: Array, constants: Array) -> Array:
        """Return the automaton's outputs at n points, shape (n, no)."""
        n = len(states)
        out = np.empty((n, self._no))
        # Where local modes are data every mode has the same outputs.
        index = np.ascontiguousarray(modes, dtype=np.int64) * (not self.outline.parts)
        x, z, c = _plain(states), _plain(memory), _plain(constants)
        addresses = (a.ctypes.data for a in (index, x, z, c, out))
        self._library.ps_outputs(n, *addresses)
        return out


def _plain_sizes(outline: Outline) -> tuple[int, int, int, int]:
    names = (outline.state_names, outline.memory_names, outline.constant_names)
    return len(names[0]), len(names[1]), len(names[2]), len(outline.output_names)


def _plain(values: Array) -> Array:
    """Return a contiguous array; the caller keeps it while C reads its address."""
    return np.ascontiguousarray(values, dtype=np.float64)
