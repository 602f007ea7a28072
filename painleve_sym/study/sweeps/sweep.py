"""A sweep: one motion for every point of a grid or a sampled set, as data that a file can hold."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.at.closing import unknowns
from painleve_sym.at.delassus import Delassus
from painleve_sym.checks import number, whole_number
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.engines.batch import MAX_EVENTS_KEPT, AtEvents, BatchOutputs
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.files import parse_toml, read_text
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.toml.faults import Faults
from painleve_sym.mechanics.toml.lines import toml_lines
from painleve_sym.motion.batch.inputs import BatchInputs
from painleve_sym.motion.batch.machine import check_memory, row_bytes
from painleve_sym.motion.batch.reason_codes import ROW_REASONS
from painleve_sym.motion.batch.result import BatchResult, event_dims
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.pressed_start import has_past
from painleve_sym.motion.simulator import Simulator
from painleve_sym.problem.case_codes import LEGEND, case_codes
from painleve_sym.problem.risk import slip_slope
from painleve_sym.quantities import unit_of
from painleve_sym.study.scenario import MAX_FILE, Scenario
from painleve_sym.study.sweeps.space import Grid, Sample, read_space

OWN_KEYS = ("axes", "sample", "keep", "events", "chunk", "format")
_OF_JUMPS = ("restitution", "rule", "impact_friction", "contact_velocity")
UNUSED_KEYS = (*_OF_JUMPS, "samples", "robot", "csv")
DEFAULT_CHUNK = 20_000
MAX_CHUNK = 10_000_000
FORMATS = ("nc", "npz", "zarr")
"""Of the result, by the ending of its name."""
Columns = dict[str, NDArray[Any]]
"""Quantities by their names in the result; the first dimension is that of the points."""
CASES: dict[str, int] = {**LEGEND, "apart": -2, "no_slip": -3}
"""Codes of ``case``: the rigid contact problem at the start; apart: the contact is not closed."""


@dataclass(frozen=True)
class Sweep:
    """A scenario, the points at which it is run, and the outputs to record.

    Attributes
    ----------
    scenario : Scenario
        What all points share.
    space : Grid or Sample
    keep : tuple of str
        Names of `BatchResult`, and ``case``.
    events : int
        How many times of each kind of event are kept where all are asked for.
    chunk : int
        Points computed and written at a time.
    format : str
        Of the result where its name is not given (`FORMATS`).
    text : str
        The sweep's own file.
    mechanism_text : str or None
        Content of the mechanism's file, where the model is one.
    """

    scenario: Scenario
    space: Grid | Sample
    keep: tuple[str, ...]
    events: int
    chunk: int
    format: str
    text: str
    mechanism_text: str | None = None

    @classmethod
    def read(cls, path: str | Path) -> Sweep:
        """Return the sweep a TOML file describes; nothing in the file is executed.

        Raises
        ------
        InputError
            Not readable, not TOML, unknown keys or names, empty axes, numbers that are not finite.
        """
        text = read_text(path, f"sweep file {path}", MAX_FILE)
        return cls.from_text(text, str(path))

    @classmethod
    def from_text(cls, text: str, where: str, mechanism_text: str | None = None) -> Sweep:
        """Return the sweep of a text; see `read`."""
        data = parse_toml(text, f"sweep file {where}")
        if "coordinates" in data:
            raise InputError(
                f"{where}: this is a mechanism, need a sweep. Fix: write one with the line "
                f'model = "{where}" and a table [axes]; `painleve sweep -h` shows one.'
            )
        faults = Faults(where, toml_lines(text))
        own = {key: data.pop(key) for key in OWN_KEYS if key in data}
        for key in UNUSED_KEYS:
            if key in data:
                faults.fault((key,), "plays no part in a sweep. Fix: leave it out.")
                del data[key]

        def mechanism(name: str) -> Mechanism:
            nonlocal mechanism_text
            if mechanism_text is None and name.endswith(".toml"):
                mechanism_text = read_text(name, f"{where}: model {name}", MAX_FILE)
            if mechanism_text is None:
                return model(name)
            from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text

            return mechanism_from_text(mechanism_text, name, Path(name).stem)

        scenario = Scenario.described(faults, data, OWN_KEYS, mechanism)

        @functools.cache
        def units() -> dict[str, str]:
            law = scenario.contact_law()
            return _units(Simulator(scenario.mechanism(), law, scenario.engine, scenario.watch))

        def read(value: Any, place: str, name: str) -> float:
            unit = units().get(name, "1") if isinstance(value, str) else "1"
            return number(value, place, where=where, unit=unit)

        space = read_space(faults, own.get("axes"), own.get("sample"), read)
        kept = _read_keep(faults, own)
        chunk, events, form = DEFAULT_CHUNK, 1, FORMATS[0]
        with faults.at("chunk"):
            chunk = whole_number(
                own.get("chunk", chunk), "chunk", where=where, lower=1, upper=MAX_CHUNK
            )
        with faults.at("events"):
            events = whole_number(
                own.get("events", events), "events", where=where, lower=1, upper=MAX_EVENTS_KEPT
            )
        form = own.get("format", form)
        if form not in FORMATS:
            faults.fault(("format",), unknown_name("format", str(form), FORMATS))
        faults.raise_if_faulty()
        sweep = cls(scenario, space, kept, events, chunk, form, text, mechanism_text)
        with _placed(where):
            scenario = scenario.from_material(space.names)
            sweep = replace(sweep, scenario=scenario)
        sweep._check(faults)
        faults.raise_if_faulty()
        return sweep

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism, with the chosen contact alone where one is named."""
        return self.scenario.mechanism()

    @cached_property
    def simulator(self) -> Simulator:
        """The simulator of the mechanism with the law."""
        law, given = self.scenario.contact_law(), self.scenario
        return Simulator(self.mechanism, law, given.engine, given.watch)

    @property
    def starts(self) -> range:
        """First points of the chunks."""
        return range(0, self.space.points, self.chunk)

    def stop(self, start: int) -> int:
        """Return the first point after a chunk."""
        return min(start + self.chunk, self.space.points)

    @property
    def columns(self) -> dict[str, str]:
        """Name in the result → quantity, of everything written of a point.

        The coordinates of a sampled point come first. A final state that is also varied is called
        ``final_…``.
        """
        drawn = {name: name for name in self.space.names if name not in self.space.axes}
        final = {f"final_{name}" if name in self.space.names else name: name for name in self.kept}
        return drawn | final

    @property
    def kept(self) -> tuple[str, ...]:
        """Everything that is written of a point, besides the point itself."""
        named = ["stop_reason", "energy_residual"]
        for name in self.keep or ("time", *self.simulator.stepped.mechanism.state_names):
            named.append(name)
            if at := AtEvents.of(name):
                named.append(f"count_of_{at.kind}")
            elif _lists_events(name):  # the counts come with the times
                named.append(name.replace("times_of_", "count_of_").replace("_times", "_counts"))
        return tuple(dict.fromkeys(named))

    def labels(self, name: str) -> dict[str, NDArray[Any]]:
        """Return the dimensions of a quantity besides those of the points, with their labels."""
        return {
            dim: np.array(self.simulator.stepped.outline.kinds)
            if dim == "event"
            else np.arange(1, self.events + 1)
            for dim in event_dims(name)
        }

    @cached_property
    def batch_outputs(self) -> BatchOutputs:
        """Per-run outputs to record, besides the end of the run."""
        own = [name for name in self.keep if AtEvents.of(name) is None]
        names = [name.removesuffix("_time") for name in own]
        watched = {
            kind: tuple(dict.fromkeys(n.removeprefix(p) for n in names if n.startswith(p)))
            for kind, p in (("maxima", "max_"), ("minima", "min_"), ("integrals", "integral_"))
        }
        at_events = tuple(name for name in self.keep if AtEvents.of(name))
        return BatchOutputs(self.events, **watched, at_events=at_events)

    # ---- checks, before anything runs ----

    def _check(self, faults: Faults) -> None:
        """Add the faults of names and numbers of the points."""
        scenario, table = self.scenario, ("axes",) if self.space.axes else ("sample", "ranges")
        with faults.at("law"):
            own = [p.name for p in self.simulator.own_parameters]
            for name in scenario.law_parameters:
                if name not in own:
                    faults.fault(
                        ("law", "parameters", name), unknown_name("parameter of the law", name, own)
                    )
        faults.raise_if_faulty()
        with faults.at("close"):
            for unknown in unknowns(self.mechanism, scenario.close) if scenario.close else ():
                if unknown.name in self.space.names:
                    raise InputError(f"{unknown.name} is varied. Fix: name another coordinate.")
        declared = self.simulator.declared.by_name
        known = (*self.mechanism.state_names, *declared, "initial_force")
        given = {*(scenario.state or {}), *scenario.parameters, *scenario.law_parameters}
        given |= {"initial_force"} if scenario.initial_force is not None else set()
        for name in self.space.names:
            if name not in known:
                faults.fault((*table, name), unknown_name("axis", name, known))
                continue
            if name in given:
                faults.fault(
                    (*table, name), f"{name} is both given and varied. Fix: leave it out of one."
                )
            for value in self.space.ends(name):
                fault = declared[name].fault(value) if name in declared else None
                if name == "initial_force" and value < 0:
                    fault = f"initial_force: got {value!r}, need >= 0."
                if fault:
                    faults.fault((*table, name), fault)
        if scenario.t_end is None:
            faults.fault((), "no end time. Fix: add t_end, in s.")
        if scenario.engine == "erk" and self.batch_outputs.watched:
            faults.fault(("keep",), "extremes and integrals need the compiled engine.")

    def check_run(self) -> Columns:
        """Compile the simulator, run the first and the last point, and return the latter.

        Faults show here, before the sweep.

        Raises
        ------
        InputError
            Input that `run_batch` rejects, unknown names to keep, no memory for a chunk.
        """
        chunk = min(self.chunk, self.space.points)
        need = 2 * chunk * row_bytes(self.simulator.stepped, self.batch_outputs)
        size, fix = f"chunks of {chunk:,} points", "a smaller chunk, or fewer events"
        check_memory(self.scenario.where, size, need, fix)
        with _placed(self.scenario.where):
            self.compute(0, 1, threads=1)
            return self.compute(self.space.points - 1, self.space.points, threads=1)

    # ---- the work ----

    def _given(self, varied: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any], Any]:
        """Return states, parameters and initial force of points."""
        scenario = self.scenario
        states: dict[str, Any] = dict(scenario.state or {})
        if scenario.state is None:
            states = {n: v for n, v in self.mechanism.start.items() if n not in varied}
        parameters: dict[str, Any] = {**scenario.parameters, **scenario.law_parameters}
        for name, values in varied.items():
            if name != "initial_force":
                (states if name in self.mechanism.state_names else parameters)[name] = values
        return states, parameters, varied.get("initial_force", scenario.initial_force)

    def pressed_count(self, start: int, stop: int) -> int:
        """Return how many of a chunk's points begin with a contact that has a past."""
        if not any(map(has_past, self.simulator.contact.own_laws)):
            return 0
        states, parameters, force = self._given(self.space.values(start, stop))
        given, close = self.simulator.given(parameters, None), self.scenario.close
        return BatchInputs.of(self.simulator, states, given, force, close).pressed_count

    def compute(self, start: int, stop: int, threads: int | None = None) -> Columns:
        """Return the columns of the points start..stop − 1.

        Stop reasons and cases are codes (`codes`).
        """
        scenario, varied = self.scenario, self.space.values(start, stop)
        states, parameters, force = self._given(varied)
        kept: dict[str, Any] = {**scenario.settings.shared(), **vars(self.batch_outputs)}
        kept |= {"phases": scenario.phases or None, "inputs": scenario.inputs or None}
        ends = run_batch(
            self.simulator,
            states,
            parameters=parameters,
            initial_force=force,
            close=scenario.close,
            threads=threads,
            **kept,
        )
        return {
            name: np.ascontiguousarray(
                varied[name] if name in varied else self._quantity(ends, quantity)
            )
            for name, quantity in self.columns.items()
        }

    def _quantity(self, ends: BatchResult, name: str) -> NDArray[Any]:
        if name == "stop_reason":
            return ends.rows.reason.astype(np.int8)
        if name == "mode":
            return ends.rows.mode.astype(np.int16)
        if name == "case":
            return self._case(ends.inputs, len(ends.rows.time))
        if name not in ends.names:
            raise InputError(f"{self.scenario.where}: keep: {_unknown(name, ends)}")
        return ends[name]

    def _case(self, inputs: Mapping[str, Any], n: int) -> NDArray[np.int8]:
        mechanism = self.mechanism
        if len(mechanism.outline.contacts) > 1:
            raise InputError(
                f"{self.scenario.where}: keep: case needs one contact. "
                "Fix: leave it out, or name one contact."
            )
        names = mechanism.outline.argument_names
        with np.errstate(all="ignore"):
            at = Delassus.of(mechanism).at_each(
                {name: np.broadcast_to(inputs[name], (n,)) for name in names}
            )
            B, slip = at.b[0], at.slip_velocity[0]
            sides = mechanism.outline.contacts[0].sides
            A = [slip_slope(at.W, at.mu[0], [np.sign(slip)], side) for side in sides]
            codes = case_codes(A, B)
        codes = np.where(np.isfinite(A[0] + B), codes, CASES["outside"])
        closed = np.abs(at.gap) <= at.gap_tolerance
        closed = (closed & (np.abs(at.gap_rate) <= at.rate_tolerance))[0]
        codes = np.where(slip == 0, CASES["no_slip"], codes)
        return np.where(closed, codes, CASES["apart"]).astype(np.int8)

    def codes(self, name: str) -> dict[str, int] | None:
        """Return text → code of a quantity that is written as codes, None for others."""
        if name == "stop_reason":
            return {r.label: i for i, r in enumerate(ROW_REASONS)}
        if name == "mode":
            return {m.name: i for i, m in enumerate(self.simulator.stepped.outline.modes)}
        return dict(CASES) if name == "case" else None

    def unit(self, name: str) -> str:
        """Return the SI unit of a quantity; "1" where it has none."""
        return unit_of(name, _units(self.simulator))


def _units(simulator: Simulator) -> dict[str, str]:
    """Return the units of everything that can be varied."""
    return {**simulator.units, "initial_force": "N"}


def _read_keep(faults: Faults, own: Mapping[str, Any]) -> tuple[str, ...]:
    keep = own.get("keep", [])
    if not isinstance(keep, list) or not all(isinstance(k, str) for k in keep):
        faults.fault(("keep",), f"got {keep!r}, need a list of names in quotes.")
        return ()
    if any(map(_lists_events, keep)) != ("events" in own):
        faults.fault(
            ("events",) if "events" in own else ("keep",),
            "keep has event_times, times_of_EVENT or values at events, and events says how many of "
            "each kind: give both or neither. Fix: such as events = 10.",
        )
    return tuple(dict.fromkeys(keep))


@contextmanager
def _placed(where: str) -> Iterator[None]:
    """Put the name of the file before its faults."""
    try:
        yield
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith(where) else f"{where}: {text}") from error


def _unknown(name: str, ends: BatchResult) -> str:
    """Return a sentence on an unknown quantity; kinds of events are named once."""
    sentence = unknown_name("quantity", name, (*ends.names, "case")).partition(" Known:")[0]
    plain = sorted(n for n in (*ends.names, "case") if "_of_" not in n)
    return (
        f"{sentence} Known: {', '.join(plain)}; time_of_, times_of_, count_of_, QUANTITY_before_ "
        f"and QUANTITY_after_ with {', '.join(ends.kinds)}; max_, min_ and integral_ with an "
        "output."
    )


def _lists_events(name: str) -> bool:
    listed = name == "event_times" or name.startswith("times_of_")
    return listed or AtEvents.of(name) is not None
