"""The first engine: generated C and the event loop in C, driven through ctypes."""

from __future__ import annotations

import ctypes
import functools
import operator
import threading
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.automata.signature import AutomatonBuilder, Outline
from painleve_sym.cache import kept_entry, read_entry, write_entry
from painleve_sym.codegen.compile import compiled_library, compiler_mark, library_named
from painleve_sym.codegen.derivation_cache import ENGINE, entry_key
from painleve_sym.engines.batch import COUNTERS, BatchOutputs, BatchRows, Ends, Given, Kept
from painleve_sym.engines.entered import Entered, entering
from painleve_sym.engines.listening import listening
from painleve_sym.engines.protocol import (
    ADMITS,
    BEFORE,
    DENSE_ROWS,
    ENGINE_REASONS,
    Listener,
    Place,
    Places,
    Prepared,
    RawRun,
    RunOptions,
)
from painleve_sym.engines.records import EventRecords, StepRecords
from painleve_sym.errors import NoRecurrence, StopReason
from painleve_sym.plain_data import of_plain, to_plain
from painleve_sym.progress import progress
from painleve_sym.time_limit import within_time

if TYPE_CHECKING:
    from painleve_sym.automata.automaton import HybridAutomaton
    from painleve_sym.codegen.modes import AutomatonFunctions

_DECISION = -2
"""Reason of a run whose parts cannot choose (PS_DECISION)."""
_HEAD = 13
"""Numbers before the state in what a run returns."""
_RECORD = {"end": 0, "events": 1, "dense": 2}
_SHARED = tuple(f.name for f in fields(RunOptions) if f.name != "atol")
_shared = operator.attrgetter(*_SHARED)
_address = ctypes.c_void_p
_Filled = ctypes.c_char * 0
"""Where C fills a buffer: cheaper than the address of an array."""


def _options_structure(nx: int, kinds: int) -> type[Any]:
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
            ("listener", ctypes.c_void_p),
            ("make", ctypes.c_void_p),
        )

    return Options


class EngineCode(NamedTuple):
    """The C of an engine, and the outline of the automaton that it runs."""

    text: str
    outline: Outline


class CompiledEngine:
    """Runge–Kutta 8(5,3) with located events, wholly in compiled code.

    The functions are those of the automaton, where they are not the plain ones; the cache keeps
    their C under the key, where one is given.
    """

    name = "compiled"
    dense_rows = DENSE_ROWS
    lanes = 1  # motions of a batch side by side

    def __init__(
        self,
        automaton: HybridAutomaton,
        functions: AutomatonFunctions | None = None,
        key: str | None = None,
    ) -> None:
        from painleve_sym.codegen.modes import AutomatonFunctions

        functions = functions or AutomatonFunctions(automaton)

        def written() -> dict[str, Any]:
            sizes = [functions.x.numel(), functions.z.numel(), functions.c.numel()]
            return {"text": self._source(functions), "sizes": [*sizes, functions.output_size]}

        entry = kept_entry(key, written)
        text: str = entry["text"]

        def compiled(text: str, alone: bool) -> Path:
            # With derivatives a motion runs alone, and gains a tenth by all that a compiler can do.
            return compiled_library(
                self._alone(text) if alone and not functions.directions else text
            )

        def variant(alone: bool, mode: int, known: Sequence[float]) -> Path:
            return compiled(self._variant_source(functions, (mode, known), text), alone)

        lanes = partial(compiled, text, False)
        self._open(Outline.of(automaton), compiled(text, True), lanes, variant, entry["sizes"])

    @classmethod
    def of_builder(cls, builder: AutomatonBuilder) -> CompiledEngine:
        """Return the engine of the automaton of `builder`, from the cache where it is known.

        A builder is known again by its definition (`definition_text`); where the cache has what it
        led to, nothing is derived, and the engine knows the automaton's outline alone. NoRecurrence
        as for `code_of`.
        """

        @functools.cache
        def own_functions() -> AutomatonFunctions:
            from painleve_sym.codegen.modes import AutomatonFunctions

            return AutomatonFunctions(builder.automaton)

        @functools.cache
        def code() -> EngineCode:
            return cls.code_of(builder, own_functions)

        def lanes() -> Path:
            title = f"lanes of engine {cls.name}"
            return _library_of(title, builder, lambda: code().text, "for batches")

        def variant(alone: bool, mode: int, known: Sequence[float]) -> Path:
            def text() -> str:
                own = cls._variant_source(own_functions(), (mode, known), code().text)
                return cls._alone(own) if alone else own

            title = f"variant {mode} {known} of engine {cls.name}{'' if alone else ' in lanes'}"
            return _library_of(title, builder, text, "as its contacts move now")

        engine = cls.__new__(cls)
        key, entry, library = _library_entry(f"engine {cls.name}", builder)
        if library:
            outline = of_plain(Outline, entry["outline"])
        else:
            outline = code().outline
            with progress(f"compiling {builder.title}"):
                library = compiled_library(cls._alone(code().text))
            if key:
                write_entry(key, {"library": library.name, "outline": to_plain(outline)})
        engine._open(outline, library, lanes, variant)
        return engine

    @classmethod
    def code_of(
        cls,
        builder: AutomatonBuilder,
        functions: Callable[[], AutomatonFunctions] | None = None,
        given: Places | None = None,
    ) -> EngineCode:
        """Return the C code of the automaton of `builder`, from the cache where it is known.

        It depends on no compiler. That an automaton has no Taylor series is remembered as well. The
        functions are those of the automaton; they are asked for where the code is not known. With
        `given`, modes with memory, it runs alone: the modes as they are, and their variants for
        these memories. Without, variants are derived when a run enters them.

        Raises
        ------
        NoRecurrence
            There is no Taylor series.
        """
        title = f"C of engine {cls.name}" if given is None else f"C of engine {cls.name}, {given}"
        key = entry_key(title, builder, by=ENGINE)
        entry = read_entry(key) if key else None
        if entry and "no_recurrence" in entry:
            raise NoRecurrence(entry["no_recurrence"])
        if entry:
            return EngineCode(entry["text"], of_plain(Outline, entry["outline"]))

        def derived() -> EngineCode:
            from painleve_sym.codegen.modes import AutomatonFunctions

            own = functions() if functions else AutomatonFunctions(builder.automaton, given is None)
            return EngineCode(cls._source(own, given or ()), Outline.of(builder.automaton))

        try:
            with progress(f"deriving {builder.title}"):
                code = within_time("automaton", derived)
        except NoRecurrence as error:
            if key:
                write_entry(key, {"no_recurrence": str(error)})
            raise
        if key:
            write_entry(key, {"text": code.text, "outline": to_plain(code.outline)})
        return code

    def _open(
        self,
        outline: Outline,
        library: Path,
        lanes: Callable[[], Path],
        variant: Callable[[bool, int, Sequence[float]], Path],
        sizes: Sequence[int] | None = None,
    ) -> None:
        self.library = library
        self._lanes_library, self._variant_library = lanes, variant
        self._lanes_lock = threading.Lock()
        self._batch: Any = None
        self._lanes_entered: Entered | None = None
        self.outline = outline
        of_state = len(outline.state_names), len(outline.memory_names)
        plain = (*of_state, len(outline.constant_names), len(outline.output_names))
        self._nx, self._nz, self._nc, self._no = sizes or plain
        self._options = _options_structure(self._nx, max(1, len(outline.kinds)))
        self._library = ctypes.CDLL(str(library))
        self._entered = self._entered_in(self._library, alone=True)
        self._end = ctypes.c_double * (_HEAD + self._nx + self._nz)
        self._step_width = StepRecords.width(self._nx, self._nz, self.dense_rows)
        self._event_width = EventRecords.width(self._nx, self._nz)
        self._no_memory = bytes(8 * (self._nz + 1))
        self._library.ps_complete.restype = _address
        self._library.ps_complete.argtypes = (_address,) * 6
        self._library.ps_take.argtypes = (_address,) * 3
        self._library.ps_free.argtypes = (_address,)
        if hasattr(self._library, "ps_prepare"):
            self._library.ps_prepare.argtypes = (ctypes.c_long, *[_address] * 4)
            self._library.ps_scales.argtypes = (_address,) * 3
        self._library.ps_constants.argtypes = (_address, _address)
        self._library.ps_outputs.argtypes = (ctypes.c_long, *[_address] * 5)
        self._library.ps_evaluate.argtypes = (ctypes.c_int, *[_address] * 6)
        # Loops of runs use the same few options, or even the same object.
        self._in_c = functools.lru_cache(maxsize=64)(self._options_in_c)
        self._last_options: tuple[tuple[Any, ...], Any] = ((), None)
        self._no_steps = np.empty((0, self._step_width))
        self._no_events = np.empty((0, self._event_width))

    @classmethod
    def _alone(cls, text: str) -> str:
        """Return the C of one motion at a time."""
        return text

    def _batch_of(self, lanes: int) -> Any:
        """Return the C function of a batch; with lanes, from a library compiled for them."""
        batch = self._library.ps_batch
        if lanes > 1:
            with self._lanes_lock:
                if self._batch is None:
                    library = ctypes.CDLL(str(self._lanes_library()))
                    self._lanes_entered = self._entered_in(library, alone=False)
                    self._batch = library.ps_batch
            batch = self._batch
        batch.restype = ctypes.c_long
        batch.argtypes = (
            ctypes.POINTER(Given),
            ctypes.POINTER(self._options),
            ctypes.POINTER(Kept),
            ctypes.c_int,
            ctypes.POINTER(Ends),
        )
        return batch

    def _entered_in(self, library: Any, *, alone: bool) -> Entered | None:
        """Return what the library calls for variants; None where modes run as they are."""
        if not hasattr(library, "ps_add_variant"):
            return None
        return Entered(library, self._nz, partial(self._variant_library, alone))

    @staticmethod
    def _source(functions: AutomatonFunctions, given: Places = ()) -> str:
        from painleve_sym.engines.source import source

        return source(functions, given)

    @staticmethod
    def _variant_source(functions: AutomatonFunctions, at: Place, file: str) -> str:
        from painleve_sym.engines.source import variant_source

        return variant_source(functions, at, file)

    def constants(self, parameters: Array) -> Array:
        """Return the parameters followed by the definitions, shape (nc,)."""
        constants = bytearray(8 * self._nc)
        self._library.ps_constants(_bytes(parameters), _Filled.from_buffer(constants))
        return np.frombuffer(constants)

    def prepare(self, parameters: Array, given: Array, forces: Array) -> Prepared:
        """Return whole start states with their scales, of n rows; see `Engine.prepare`."""
        n, width = len(given), 2 * self._nx + ADMITS
        rows = bytearray(8 * n * width)
        inputs = _bytes(parameters), _bytes(given), _bytes(forces)
        self._library.ps_prepare(n, *inputs, _Filled.from_buffer(rows))
        return Prepared.of(np.frombuffer(rows).reshape(n, width))

    def scales(self, parameters: Array, state: Array) -> Array:
        """Return the scale of each state at a state, shape (nx,)."""
        scales = bytearray(8 * self._nx)
        self._library.ps_scales(_bytes(parameters), _bytes(state), _Filled.from_buffer(scales))
        return np.frombuffer(scales)

    def _options_in_c(self, shared: tuple[Any, ...]) -> Any:
        """Return the C structure of the options in `_shared`; each run has its own tolerances."""
        o = dict(zip(_SHARED, shared, strict=True))
        named = o["until"]
        until = [(k in named) + 2 * (BEFORE + k in named) for k in self.outline.kinds] or [0]
        same = ("rtol", "t_end", "max_steps", "max_events", "start_events", "start_mode")
        return self._options(
            **{name: o[name] for name in same},
            h0=o["first_step"],
            h_max=min(o["max_step"], 1e300),
            until=(ctypes.c_ubyte * len(until))(*until),
            record=_RECORD[o["record"]],
        )

    def run(
        self,
        state: Array,
        parameters: Array,
        options: RunOptions,
        memory: Array | None = None,
        listener: Listener | None = None,
    ) -> RawRun:
        """Integrate from t = 0; the memory is 0 or given."""
        out: Any = self._end()
        # Passing `bytes` avoids the overhead of `ndarray.ctypes`.
        x, p, atol = _bytes(state), _bytes(parameters), _bytes(options.atol)
        z = self._no_memory if memory is None else _bytes(memory)
        shared = _shared(options)
        last, options_in_c = self._last_options
        if last != shared:
            options_in_c = ctypes.byref(self._in_c(shared))
            self._last_options = (shared, options_in_c)
        if listener is None and self._entered is None:
            kept = self._library.ps_complete(x, z, p, options_in_c, atol, out)
        else:
            own = self._options.from_buffer_copy(self._in_c(shared))
            hears = listening(listener, self._nx) if listener else nullcontext()
            with hears as own.listener, entering(self._entered, own):
                kept = self._library.ps_complete(x, z, p, ctypes.byref(own), atol, out)
        time, mode, reason, stop, *counters, step_count, event_count, width = out[:_HEAD]
        decision = reason == _DECISION
        if reason < 0 and not decision:
            self._library.ps_free(kept)
            raise MemoryError(
                f"{self.name} engine: no memory for the record after t = {time:g} s. "
                "Fix: record='events' keeps less."
            )
        steps, events = self._no_steps, self._no_events
        if kept:
            step_width = int(width) or self._step_width
            rows = bytearray(8 * int(step_count) * step_width)
            event_rows = bytearray(8 * int(event_count) * self._event_width)
            filled = _Filled.from_buffer(rows), _Filled.from_buffer(event_rows)
            self._library.ps_take(kept, *filled)
            steps = np.frombuffer(rows).reshape(-1, step_width)
            events = np.frombuffer(event_rows).reshape(-1, self._event_width)
        values: Array = np.frombuffer(out)[_HEAD:]
        return RawRun(
            time=time,
            state=values[: self._nx],
            memory=values[self._nx :],
            mode=int(mode),
            stop_reason=StopReason.NO_MODE if decision else ENGINE_REASONS[int(reason)],
            stop_transition=int(stop),
            steps=steps,
            events=events,
            counters={name: int(count) for name, count in zip(COUNTERS, counters, strict=True)},
        )

    def run_batch(
        self,
        states: Array,
        parameters: Array,
        t_end: Array,
        atol: Array,
        options: RunOptions,
        kept: BatchOutputs,
        rows: BatchRows,
        memory: Array | None = None,
    ) -> None:
        """Integrate every row from t = 0 as `run` would, in one call that holds no Python lock.

        Shapes are (n, nx) of states and tolerances, (n, np) and (n,). The options are what all rows
        share, as the memory, shape (nz,): their t_end, atol and record are not used. The n rows are
        filled.
        """
        n = len(states)
        x, p, t = _plain(states), _plain(parameters), _plain(t_end)
        tolerances = _plain(atol)
        shared = self._in_c(_shared(replace(options, record="end")))
        chosen = np.array(kept.indices(self.outline.output_names), dtype=np.int32)
        sampled = np.array(kept.samples(self.outline), dtype=np.int32).reshape(-1, 3)
        counts = (len(kept.maxima), len(kept.minima), len(kept.integrals), len(sampled))
        kept_in_c = Kept(kept.events, *counts, chosen.ctypes.data, sampled.ctypes.data)
        ends = Ends.of(rows)
        z = _plain(np.zeros(self._nz + 1) if memory is None else memory)
        given = Given(n, *(a.ctypes.data for a in (x, p, t, tolerances, z)))
        lanes = self.lanes if n > 1 else 1
        batch = self._batch_of(lanes)
        own = self._options.from_buffer_copy(shared)
        with entering(self._lanes_entered if lanes > 1 else self._entered, own):
            done = batch(given, own, kept_in_c, self.lanes, ends)
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
        rows = bytearray(8 * n * self._no)
        # Where local modes are data every mode has the same outputs.
        index = np.asarray(modes, np.int64) * (not self.outline.parts)
        inputs = _bytes(states), _bytes(memory), _bytes(constants)
        self._library.ps_outputs(n, index.tobytes(), *inputs, _Filled.from_buffer(rows))
        return np.frombuffer(rows).reshape(n, self._no)


def _library_of(title: str, builder: AutomatonBuilder, text: Callable[[], str], use: str) -> Path:
    """Return a library from the cache, or compiled from the text that is then asked for."""
    key, _, library = _library_entry(title, builder)
    if library is None:
        source = text()
        with progress(f"compiling {builder.title} {use}"):
            library = compiled_library(source)
        if key:
            write_entry(key, {"library": library.name})
    return library


def _library_entry(title: str, builder: AutomatonBuilder) -> tuple[str | None, Any, Path | None]:
    """Return name and content of an entry that names a library, and that where it is there."""
    mark = compiler_mark()
    key = entry_key(f"{title}\n{mark}", builder, by=ENGINE) if mark else None
    entry = read_entry(key) if key else None
    return key, entry, library_named(entry["library"]) if entry else None


def _bytes(values: Array) -> bytes:
    """Return an array for C to read: cheaper than the address of its memory."""
    return np.asarray(values, np.float64).tobytes()


def _plain(values: Array) -> Array:
    """Return a contiguous array; the caller keeps it while C reads its address."""
    return np.ascontiguousarray(values, dtype=np.float64)
