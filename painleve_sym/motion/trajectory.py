"""The one result type of every simulator: segments, events, states, forces, energies."""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array, load_npz, npz_faults, save_npz, table_library
from painleve_sym.automata.model import ENERGIES, LOSSES
from painleve_sym.checks import names_of, number, text_of, whole_number
from painleve_sym.choices import chosen
from painleve_sym.codegen.tape import TapeOutputs
from painleve_sym.engines.records import StepRecords, dense_values
from painleve_sym.equality import Compared
from painleve_sym.errors import (
    EventKind,
    InputError,
    StopReason,
    received,
    refuse_unknown,
    unknown_name,
)
from painleve_sym.hooks import upper
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.energy_balance import balance_closes, balance_notice, balance_residual
from painleve_sym.motion.energy_gains import EnergyGain, notices
from painleve_sym.motion.joined import JoinedOutputs, JoinedRecord, outputs_of_data
from painleve_sym.motion.pressed_start import PressedStart, past_notices, several_notices
from painleve_sym.motion.pressing import ContactSurface, pressing_notices
from painleve_sym.motion.records import (
    PIECE,
    EngineOutputs,
    EventRecord,
    Film,
    MotionNames,
    Segment,
)
from painleve_sym.motion.rigid import final_slip_notices
from painleve_sym.motion.rigidity import BodyPeriod, contact_durations, rigidity_notices
from painleve_sym.motion.run_record import RunRecord, StoredRecord
from painleve_sym.motion.singular_limit import ReverseChatter, SingularLimit
from painleve_sym.motion.small_events import events_above_tolerance
from painleve_sym.notebooks import Shown
from painleve_sym.plain_data import of_plain, plain_fields, to_plain
from painleve_sym.quantities import ROUNDING, counted, unit_of
from painleve_sym.units import Value

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from painleve_sym.motion.arguments import ContinuationArguments

FORMAT = "painleve-sym trajectory 2"


CONTACT_RATES = ("gap_rate", "slip_velocity")
"""Rates of a contact, which are states of motions of several contacts under other names."""


@dataclass(frozen=True, repr=False, eq=False)
class Trajectory(Shown, Compared):
    """A motion, piecewise polynomial in time.

    In a step from t to t + h, with τ = t + h u (1 + β (u − 1)) and v = 1 − u, the state is
    r₀ + u(r₁ + v(r₂ + u(r₃ + v(r₄ + …)))): eight rows r as DOP853 gives them, or one per order of
    a Taylor series. The bend β is 0 but for series that run along √τ from or to a point where
    a contact force sets in or ends.

    Attributes
    ----------
    names : MotionNames
    parameters : dict of str to float
        Of mechanism and law, as used.
    rtol : float
    record : RunRecord, JoinedRecord or StoredRecord
        Steps and events.
    final_time : float
    final_state : ndarray, shape (nx,)
    final_memory : ndarray, shape (nz,)
    stop_reason : StopReason
    stop_detail : str
        What is particular to this stop; empty where the reason says all.
    counters : dict of str to int
        Work done.
    evaluator : Evaluator or None
        Computes forces.
    limit : SingularLimit or None
        Rigid motion that stopped where a slip meets A = 0: where it would arrive.
    subject : Mechanism or None
        The mechanism, for drawings; it is neither saved nor pickled.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> run = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 1.0}, t_end=0.2)
    >>> [str(event.kind) for event in run.events[:2]]
    ['touchdown', 'impact']
    >>> run["y_A"].shape == run.t.shape
    True
    >>> float(run.values("y_A", 0.1)[0]) < 0.1
    True
    """

    _INNER = ("evaluator", "record", "subject")

    names: MotionNames
    parameters: dict[str, float]
    rtol: float
    record: RunRecord | JoinedRecord | StoredRecord = field(repr=False)
    final_time: float
    final_state: Array
    final_memory: Array
    stop_reason: StopReason
    stop_detail: str
    counters: dict[str, int]
    evaluator: EngineOutputs | TapeOutputs | JoinedOutputs | None = field(
        default=None, compare=False
    )
    limit: SingularLimit | None = None
    subject: Mechanism | None = field(default=None, compare=False)

    def __repr__(self) -> str:
        """Return mechanism, law, number of events and end in one line."""
        choices = "".join(f", {name} {value}" for name, value in self.choices.items())
        return (
            f"Trajectory of {self.mechanism!r} with law {self.law!r}{choices}: "
            f"{counted(len(self.events), 'event')}, {counted(len(self.step_time), 'step')}, "
            f"end at t = {self.final_time:.6g} s ({self.stop_reason.label})"
        )

    def __getstate__(self) -> dict[str, Any]:
        """Pickle the outputs as plain operations in place of the engine."""
        state = self.__dict__ | {"subject": None}
        if self.evaluator is not None:
            state["evaluator"] = self.evaluator.portable()
        return state

    def continued(self, t_end: Value, **arguments: Unpack[ContinuationArguments]) -> Trajectory:
        """Return the motion from the end of this one on, in its mode and with its memory.

        The times of both are those of one motion: cut anywhere and continued, it is the motion
        that was not cut, but for rounding. `painleve_sym.simulate` with ``start=run`` does the same
        for a motion from a file, and with another law, which begins at the same coordinates and
        velocities in a mode of its own.

        Parameters
        ----------
        t_end : float or str
            s, after the end of this motion.
        **arguments
            As for `painleve_sym.simulate`; `parameters` and `law_parameters` change those of this
            motion from now on. Phases and inputs that are not given are those of this motion.

        Raises
        ------
        InputError
            This motion came from a file or another process, or ended for a reason that it cannot
            continue from.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> start = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
        >>> first = ps.simulate("rod", "bilinear-hertz", start, t_end=1e-3)
        >>> rest = first.continued(1e-2)
        >>> float(rest.t[0]), str(rest.events[0].kind)
        (0.001, 'slip_stop')
        """
        if isinstance(self.record, StoredRecord):
            raise InputError(
                "trajectory: a motion from a file or another process does not know its mechanism. "
                "Fix: simulate(mechanism, law, start=run, t_end=...)."
            )
        simulator: Any = self.record.simulator
        motion: Trajectory = simulator.run(start=self, t_end=t_end, **arguments)
        return motion

    # ---- names and records ----

    @property
    def mechanism(self) -> str:
        """Name of the mechanism."""
        return self.names.mechanism

    @property
    def law(self) -> str:
        """Name of the law."""
        return self.names.law

    @property
    def choices(self) -> dict[str, str]:
        """The law's named choices."""
        return self.names.choices

    @property
    def source(self) -> str:
        """Works on the mechanism, the laws and the integrator; see `painleve_sym.citation`."""
        return self.names.source

    @property
    def engine(self) -> str:
        """Name of the engine."""
        return self.names.engine

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states."""
        return self.names.states

    @property
    def memory_names(self) -> tuple[str, ...]:
        """Names of the memory, constant within a mode."""
        return self.names.memory

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of forces, gaps, energies …."""
        return self.names.outputs

    @property
    def mode_names(self) -> tuple[str, ...]:
        """Names of the modes."""
        return self.record.mode_names

    @property
    def final_mode(self) -> int:
        """Index into `mode_names` at the end."""
        return self.record.final_mode

    @property
    def events(self) -> tuple[EventRecord, ...]:
        """The events, in order."""
        return self.record.events

    @property
    def reverse_chatter(self) -> tuple[ReverseChatter, ...]:
        """Rigid motion: stretches of bounces that grow out of contact."""
        return self.record.reverse_chatter

    @property
    def energy_gains(self) -> tuple[EnergyGain, ...]:
        """Impacts and reloads that add energy, in order; none where no events were kept.

        Newton's law of restitution can add energy where friction acts, and the virgin reload rule
        does at every reload. What drives add by a moving surface does not count.
        """
        return self.record.energy_gains

    @property
    def notices(self) -> tuple[str, ...]:
        """Sentences that a reader of the result should know.

        They name an energy balance that does not close, energy that the motion gained, bodies
        that are not rigid in its impacts, contacts that are pressed deeper or harder than their
        law holds for, and a start that the state alone does not determine.
        """
        gained = notices(self.energy_gains)
        if self.energy_closes is False:
            gained = (balance_notice(self.energy_residual, self.rtol), *gained)
        periods = self.body_periods
        durations = contact_durations(self.events) if periods else {}
        pressed = self.record.surfaces if self.evaluator else ()
        hard = pressing_notices(pressed, self.events, self.final_outputs) if pressed else ()
        past = (*past_notices(self.record.pressed_starts), *several_notices(self.events))
        past += final_slip_notices(self.events)
        jumps = self.subject.outline.speed_jump_notices if self.subject else ()
        return (*jumps, *past, *gained, *rigidity_notices(durations, periods), *hard)

    @property
    def body_periods(self) -> tuple[BodyPeriod, ...]:
        """Natural periods of the bodies, with which durations of contacts are compared.

        Known of bodies with modes, with a `lowest_period`, and of bars whose material is given.
        """
        return self.record.body_periods

    @property
    def inputs(self) -> dict[str, Any]:
        """Arguments of `simulate` besides the parameters: plain data, to compute it again.

        ``law`` is the text that `painleve_sym.law` knows (with `choices`), ``state`` the start,
        ``options`` the end, the initial force and the bounds, ``version`` that of the package, and
        ``continues`` time, mode and memory of a motion that continues another one, and ``phases``
        and ``inputs`` what changes on its way.
        Empty for a file of an earlier release.
        """
        return self.record.inputs

    @property
    def constants(self) -> Array:
        """Parameters and definitions, as the engine takes them, shape (nc,)."""
        return self.record.constants

    @property
    def step_time(self) -> Array:
        """Times at which the steps begin, shape (steps,); s."""
        return self.record.steps.time

    @property
    def step_length(self) -> Array:
        """Lengths of the steps, shape (steps,); s."""
        return self.record.steps.length

    @property
    def step_mode(self) -> Any:
        """Indices into `mode_names`, shape (steps,)."""
        return self.record.steps.mode

    @property
    def step_memory(self) -> Array:
        """Memory during the steps, shape (steps, nz)."""
        return self.record.steps.memory

    @property
    def step_rows(self) -> Array:
        """Polynomials r of the steps, shape (steps, rows, nx)."""
        return self.record.steps.polynomial

    @property
    def step_bend(self) -> Array:
        """Bends β of the steps, shape (steps,)."""
        return self.record.steps.bend

    # ---- evaluation ----

    @cached_property
    def t(self) -> Array:
        """Beginnings of the steps and the end, shape (steps + 1,); s."""
        return np.append(self.step_time, self.final_time)

    def __getitem__(self, name: str) -> Array:
        """Return a state or output by name at the times `t`, shape (steps + 1,).

        At an event the value just after it; for other times see `values`.
        """
        name = text_of(name, "trajectory: quantity")
        return self.t if name == "time" else self.values(name, self.t)

    def size(self, name: str, contact: str = "") -> float:
        """Return the size of a state, gap, rate or force in this motion, in its SI unit.

        It is the largest value at events, beginnings of steps and the end, and no less than the
        scale of the absolute tolerance at the start; that of a force is the largest force. With
        several contacts, `contact` is that of a gap or its rate.
        """
        if "_force" in name:
            known = [abs(v) for v in self.final_forces.values()]
            known += [abs(f) for e in self.events for f in (e.normal_force, e.tangential_force)]
            return max(known, default=0.0)
        known = [self.record.scales.get(self.names.of_contact(name, contact), 0.0)]
        if name in self.state_names:
            i = self.state_names.index(name)
            known.append(float(np.nanmax(np.abs(self.step_rows[:, 0, i]), initial=0.0)))
            known.append(abs(self.final[name]))
        elif name.startswith("gap") and "rate" not in name:
            known += [abs(e.compression) for e in self.events]
        elif name in CONTACT_RATES and len(self.step_time) and self.evaluator is not None:
            rates = self.values(self.names.of_contact(name, contact), self.step_time)
            known.append(float(np.nanmax(np.abs(rates), initial=0.0)))
        return max(known)

    def tolerance(self, name: str, contact: str = "") -> float:
        """Return the tolerance of a state, gap, rate, force or energy, in its SI unit.

        It is the tolerance of the run, rtol, on the `size` of the quantity; of an energy, on the
        largest energy at the end. Figures, tables and reports have 0 for what is not larger, and
        leave out events whose rate is not (`events_above_tolerance`).

        Examples
        --------
        >>> import painleve_sym as ps
        >>> run = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 1.0}, t_end=0.1)
        >>> run.tolerance("x_A_dot") < 1e-10
        True
        """
        if self.units(name) == "J":
            values = {**self.final, **self.final_outputs}
            size = max(abs(v) for n, v in values.items() if self.units(n) == "J")
        else:
            size = self.size(name, contact)
        return max(self.rtol, ROUNDING) * size

    def above_tolerance(self, name: str, value: float, contact: str = "") -> float:
        """Return a value of a quantity, 0 where it is not above the `tolerance`."""
        return value + 0.0 if abs(value) > self.tolerance(name, contact) else 0.0

    @cached_property
    def events_above_tolerance(self) -> tuple[EventRecord, ...]:
        """Events of motions above the `tolerance`; a body at rest has none."""
        return events_above_tolerance(self)

    def units(self, name: str) -> str:
        """Return the SI unit of a state, output or parameter; "1" where it has none."""
        return unit_of(text_of(name, "trajectory: quantity"), self.names.units)

    def _locate(self, t: Array) -> Any:
        start = float(self.t[0])
        outside = (t < start) | (t > self.final_time) | ~np.isfinite(t)
        if outside.any():
            fault = f"trajectory: time: got {float(t[outside][0])!r}, need"
            if len(self.step_time):
                raise InputError(f"{fault} a number in [{start!r}, {self.final_time!r}].")
            if self.ended_at_start:
                raise InputError(
                    f"{fault} {self.final_time!r}: the run ended at its start "
                    f"({self.stop_reason.label})."
                )
            raise InputError(
                f"{fault} {self.final_time!r}: the trajectory holds no steps, so only its end can "
                "be evaluated.  Fix: simulate with record='dense'."
            )
        return np.searchsorted(self.step_time, t, side="right") - 1

    @property
    def ended_at_start(self) -> bool:
        """Whether the run took no step: it ended where it began."""
        return self.counters["accepted_steps"] == 0

    def _located(self, times: Array) -> tuple[Any, Array, Array]:
        """Return modes, states and memory at times, a row each; at the end, the final ones."""
        index, n = self._locate(times), len(times)
        modes = np.full(n, self.final_mode)
        states, memory = np.tile(self.final_state, (n, 1)), np.tile(self.final_memory, (n, 1))
        on = times < self.final_time
        modes[on], memory[on] = self.step_mode[index[on]], self.step_memory[index[on]]
        states[on] = self._states(times[on], index[on])
        return modes, states, memory

    def __call__(self, t: ArrayLike) -> Array:
        """Return the states at times `t`, shape (len(t), nx); at an event, those after it."""
        return self._located(_times(t))[1]

    def _states(self, times: Array, index: Any) -> Array:
        w = np.clip((times - self.step_time[index]) / self.step_length[index], 0.0, 1.0)
        bend = self.step_bend[index]
        u = 2 * w / (1 - bend + np.sqrt((1 - bend) ** 2 + 4 * bend * w))
        return dense_values(self.step_rows[index], u)

    def state(self, t: float) -> dict[str, float]:
        """Return the state at time `t` by name."""
        at = number(t, "time", where="trajectory")
        return dict(zip(self.state_names, map(float, self(at)[0]), strict=True))

    def outputs(self, t: ArrayLike) -> dict[str, Array]:
        """Return forces, gap, energies … at times `t`, each of shape (len(t),)."""
        return self._outputs(*self._located(_times(t)))

    def _outputs(self, modes: Any, states: Array, memory: Array) -> dict[str, Array]:
        if self.evaluator is None:
            raise InputError(
                "trajectory: the outputs were not kept, so forces and energies are not known. "
                "Fix: simulate and save again."
            )
        values = self.evaluator.outputs(modes, states, memory, self.constants)
        return dict(zip(self.output_names, values.T, strict=True))

    def values(self, name: str, t: ArrayLike) -> Array:
        """Return one state or output by name at times `t`, shape (len(t),)."""
        if text_of(name, "trajectory: quantity") in self.state_names:
            return self(t)[:, self.state_names.index(name)]
        if name in self.output_names:
            return self.outputs(t)[name]
        raise InputError("trajectory: " + unknown_name("quantity", name, self._every))

    @property
    def _every(self) -> tuple[str, ...]:
        return (*self.state_names, *self.output_names)

    def sample(self, n: int = 1001) -> Array:
        """Return n evenly spaced times from start to end, shape (n,)."""
        whole_number(n, "number of samples", where="trajectory", lower=2, upper=2**31 - 1)
        start = float(self.t[0])
        return np.linspace(start, self.final_time, n)

    def fine_times(self, per_step: int = 8) -> Array:
        """Return times that resolve every step, for drawing; shape (steps · per_step + 1,)."""
        u = np.arange(per_step) / per_step
        times = (self.step_time[:, None] + u * self.step_length[:, None]).ravel()
        return np.append(times, self.final_time)

    # ---- what happened ----

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        """Stretches of time in one mode, in order."""
        if not len(self.step_time):
            return ()
        breaks = {e.time for e in self.events}
        starts = [0]
        for i in range(1, len(self.step_time)):
            changed = self.step_mode[i] != self.step_mode[i - 1]
            if changed or float(self.step_time[i]) in breaks:
                starts.append(i)
        ends = [*(s - 1 for s in starts[1:]), len(self.step_time) - 1]
        return tuple(
            Segment(
                self.mode_names[int(self.step_mode[a])],
                float(self.step_time[a]),
                float(self.step_time[b] + self.step_length[b]),
                a,
                b,
            )
            for a, b in zip(starts, ends, strict=True)
        )

    def events_of(self, kind: str) -> tuple[EventRecord, ...]:
        """Return the events of one kind, in order; InputError for a kind that there is not."""
        of_kind = chosen(EventKind, kind, "kind of event", "trajectory")
        return tuple(e for e in self.events if e.kind is of_kind)

    def at_events(self, name: str) -> Array:
        """Return a state or output at every event of a kind, shape (events,), in its SI unit.

        Parameters
        ----------
        name : str
            ``QUANTITY_before_EVENT`` or ``QUANTITY_after_EVENT``, as in batches and sweeps: just
            before or after all that happens at the instant of the event. The normal speeds of
            impacts are ``gap_rate_before_touchdown`` and ``gap_rate_after_touchdown``, the
            tangential ones those of ``slip_velocity``; of several contacts with the contact's name,
            ``gap_rate_A_before_impact``.

        Raises
        ------
        InputError
            An event or a quantity that there is not; a motion from a file or another process.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> run = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 0.9}, t_end=0.2)
        >>> for side in ("before", "after"):
        ...     print(run.at_events(f"gap_rate_{side}_touchdown").round(3))
        [-1.4]
        [1.05]
        """
        if isinstance(self.record, StoredRecord):
            raise InputError(
                "trajectory: at_events: a motion from a file or another process keeps the states "
                "after events alone. Fix: simulate it again."
            )
        return self.record.at_events(text_of(name, "trajectory: at_events"))

    @cached_property
    def final_outputs(self) -> dict[str, float]:
        """Forces, gap, energies … at the end."""
        last = self._outputs(
            np.array([self.final_mode]), self.final_state[None], self.final_memory[None]
        )
        return {k: float(v[0]) for k, v in last.items()}

    @property
    def final_forces(self) -> dict[str, float]:
        """Normal and tangential forces at the end by name, of every contact; N."""
        return {k: v for k, v in self.final_outputs.items() if "_force" in k}

    @cached_property
    def final(self) -> dict[str, float]:
        """The final state by name."""
        return dict(zip(self.state_names, map(float, self.final_state), strict=True))

    # ---- energy ----

    def energies(self, t: ArrayLike) -> dict[str, Array]:
        """Return the terms of the balance at times `t`, each (len(t),), and their `total`; J."""
        terms = self._balance(self(t), self.outputs(t))
        with np.errstate(invalid="ignore"):
            return {**terms, "total": np.sum(list(terms.values()), axis=0)}

    def _balance(self, states: Array, outputs: Mapping[str, Array]) -> dict[str, Array]:
        terms = {name: outputs[name] for name in ENERGIES}
        for name in LOSSES:
            if name in self.state_names:
                terms[name] = states[:, self.state_names.index(name)]
        return terms

    @cached_property
    def energy_residual(self) -> float:
        """Largest change of kinetic + potential + stored + dissipated energy, relative.

        Relative to the largest of the sizes of the terms, the potential energy counted from its
        start; taken over the ends of all steps, or over events, start and end where no steps were
        kept. 0 where no term is more than rounding, as of a body at rest; inf where one is not
        finite; nan where no events were kept either.
        """
        if not len(self.step_time):
            return self.record.residual_at_events
        return max(map(self._residual, self._stretches))

    @property
    def _stretches(self) -> list[slice]:
        """Steps of each piece of the motion, whose energies jump where another one begins."""
        if PIECE not in self.memory_names:
            return [slice(0, len(self.step_time))]
        changes = np.flatnonzero(np.diff(self.step_memory[:, -1])) + 1
        ends = [0, *changes.tolist(), len(self.step_time)]
        return [slice(a, b) for a, b in itertools.pairwise(ends)]

    def _residual(self, steps: slice) -> float:
        """Return the energy residual over some steps."""
        states, modes = self.step_rows[steps, 0], self.step_mode[steps]
        memory, last = self.step_memory[steps], steps.stop - 1
        if steps.stop == len(self.step_time):
            end = self.final_state, self.final_mode, self.final_memory
        else:
            end = dense_values(self.step_rows[last], np.ones(1))[0], modes[-1], memory[-1]
        states, memory = np.vstack([states, end[0]]), np.vstack([memory, end[2]])
        outputs = self._outputs(np.append(modes, end[1]), states, memory)
        return balance_residual(self._balance(states, outputs))

    @property
    def energy_closes(self) -> bool | None:
        """Whether the residual is below 10³ rtol, at least 1e-9 and at most 0.1; None for nan.

        Where it is not, a notice says so.
        """
        return balance_closes(self.energy_residual, self.rtol)

    # ---- tables and figures ----

    def _table(
        self, names: str | Sequence[str] | None, times: ArrayLike | None
    ) -> dict[str, Array]:
        wanted = self._every if names is None else names_of(names, "trajectory: names")
        at = self.t if times is None else _times(times)
        states, outputs = self(at), {}
        if any(name not in self.state_names for name in wanted):
            outputs = self.outputs(at)
        known = dict(zip(self.state_names, states.T, strict=True)) | outputs
        for name in wanted:
            refuse_unknown("quantity", name, self._every, "trajectory")
        return {"time": at} | {name: known[name] for name in wanted}

    def to_dataframe(
        self, names: str | Sequence[str] | None = None, times: ArrayLike | None = None
    ) -> pandas.DataFrame:
        """Return a `pandas.DataFrame` over the time, with units in its ``attrs["units"]``.

        Parameters
        ----------
        names : sequence of str, optional
            States and outputs; all where none are given.
        times : array_like, optional
            s; the times `t` where none are given.

        Raises
        ------
        InputError
            pandas is not installed, or an unknown name.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> run = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 1.0}, t_end=0.1)
        >>> frame = run.to_dataframe(["theta", "normal_force"])
        >>> frame.attrs["units"]
        {'time': 's', 'theta': 'rad', 'normal_force': 'N'}
        """
        frames = table_library("pandas", "a data frame")
        columns = self._table(names, times)
        index = frames.Index(columns.pop("time"), name="time")
        frame: pandas.DataFrame = frames.DataFrame(columns, index=index)
        frame.attrs["units"] = {name: self.units(name) for name in ("time", *columns)}
        return frame

    def events_to_dataframe(self) -> pandas.DataFrame:
        """Return a `pandas.DataFrame` with a row for each event: time, kind, forces and states.

        The states are those just after the event, the forces those just before it.

        Raises
        ------
        InputError
            pandas is not installed.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> run = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 0.9}, t_end=0.2)
        >>> frame = run.events_to_dataframe()
        >>> frame["kind"][0], round(float(frame["time"][0]), 6)
        ('touchdown', 0.142857)
        """
        frames = table_library("pandas", "a data frame")
        own = ("time", "kind", "quantity", "contact", "mode_before", "mode_after")
        forces = ("normal_force", "tangential_force", "compression")
        columns: dict[str, list[Any]] = {
            name: [getattr(event, name) for event in self.events] for name in (*own, *forces)
        }
        columns["kind"] = list(map(str, columns["kind"]))
        columns |= {n: [event.state[n] for event in self.events] for n in self.state_names}
        frame: pandas.DataFrame = frames.DataFrame(columns)
        frame.attrs["units"] = {n: "s" if n == "time" else self.units(n) for n in columns}
        return frame

    def to_xarray(
        self, names: str | Sequence[str] | None = None, times: ArrayLike | None = None
    ) -> xarray.Dataset:
        """Return an `xarray.Dataset` over the time, every variable with its unit.

        Its attributes are what computes the motion again, also from a NetCDF file: ``mechanism``,
        ``law`` and ``version`` as texts; ``law_choices``, ``parameters``, ``state`` and ``options``
        (keywords of `simulate`) as JSON, ``continues`` of a motion that continues another one, and
        ``phases`` and ``inputs`` where there are any.

        Parameters
        ----------
        names, times
            As for `to_dataframe`.

        Raises
        ------
        InputError
            xarray is not installed, or an unknown name.

        Examples
        --------
        >>> import json, painleve_sym as ps
        >>> run = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 1.0}, t_end=0.2)
        >>> about = run.to_xarray(["theta"]).attrs
        >>> law = ps.law(about["law"], **json.loads(about["law_choices"]))
        >>> tables = {n: json.loads(about[n]) for n in ("state", "parameters", "options")}
        >>> options = tables.pop("options")
        >>> again = ps.simulate(about["mechanism"], law, **tables, **options)
        >>> again.final == run.final
        True
        """
        library = table_library("xarray", "a labelled array")
        columns = self._table(names, times)
        time = ("time", columns.pop("time"), {"units": "s"})
        variables = {n: ("time", v, {"units": self.units(n)}) for n, v in columns.items()}
        given = {"law": self.law, "state": {}, "options": {}, "version": ""} | self.inputs
        options = {"rtol": self.rtol, "engine": self.engine, **given["options"]}
        attributes = labels(self.mechanism, given, self.choices, self.parameters, options)
        attributes |= {"stop_reason": self.stop_reason.label, "sources": self.source}
        for name in ("continues", "phases", "inputs"):
            if name in given:
                attributes[name] = json.dumps(given[name])
        dataset: xarray.Dataset = library.Dataset(variables, {"time": time}, attributes)
        return dataset

    def plot(
        self,
        quantities: str | Sequence[str] | None = None,
        *,
        ax: Axes | Sequence[Axes] | None = None,
        width: float | None = None,
        label: str | None = None,
        color: str | None = None,
        linestyle: str | None = None,
    ) -> Figure:
        """Return a Matplotlib figure of forces, coordinates and velocities with the events.

        Parameters
        ----------
        quantities : sequence of str, optional
            States and outputs to draw, each in a panel of its own, instead of all.
        ax : Axes, or several, optional
            Axes to draw in, in SI units: those of all quantities, which then have one unit, or as
            many as quantities. Forces are drawn where no quantities are given.
        width : float, optional
            Width of the figure, in inches; by default 7, that of a journal's page. A column is 3.4.
        label, color, linestyle : str, optional
            Of the lines of quantities, as for `Axes.plot`.

        Returns
        -------
        Figure
            With axes of one's own, theirs.

        Raises
        ------
        InputError
            The trajectory holds no steps; unknown quantities; axes that do not fit them.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> from matplotlib.figure import Figure
        >>> run = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 1.0}, t_end=0.2)
        >>> [axes.get_ylabel() for axes in run.plot("y_A,normal_force").axes]
        ['$y_A$ (m)', '$F_n$ (N)']
        >>> axes = Figure().subplots()
        >>> for mu in (0.0, 0.5):
        ...     start = {"y_A": 0.1, "theta": 1.0}
        ...     run = ps.simulate("rod", "rigid", start, t_end=0.2, parameters={"mu": mu})
        ...     figure = run.plot("x_A_dot", ax=axes, label=f"mu = {mu}")
        >>> len(axes.lines)
        2
        """
        given = {"label": label, "color": color, "linestyle": linestyle}
        style = {name: value for name, value in given.items() if value is not None}
        figure: Figure = upper("plot")(self, quantities, ax, width, style)
        return figure

    def animate(
        self, mechanism: Mechanism | None = None, *, duration: float = 8.0, width: int = 480
    ) -> Film:
        """Return a film of the mechanism with its contact forces, to be saved or shown.

        Parameters
        ----------
        mechanism : Mechanism, optional
            That of the motion; needed where the trajectory comes from a file or another process.
        duration : float
            Of the film, in (0, 120]; s. Time is magnified where much happens.
        width : int
            Pixels, from 200 to 2000.

        Raises
        ------
        InputError
            The trajectory holds no steps, the mechanism has no shapes, or none is known.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> run = ps.simulate("rod", "rigid", {"y_A": 0.1, "theta": 1.0}, t_end=0.2)
        >>> film = run.animate(duration=1.0)
        >>> film.html().startswith("<figure")
        True
        """
        film: Film = upper("animate")(self, mechanism, duration, width)
        return film

    def explore(self) -> Any:
        """Return the explorer of this motion, an `ExplorerWidget` for notebooks.

        Raises
        ------
        InputError
            The trajectory comes from a file or another process, which do not keep the mechanism;
            the package anywidget is not installed.
        CompilerMissing
            The module is not part of the package and there is no compiler for WebAssembly.
        """
        return upper("explore")(self)

    # ---- files ----

    def to_dict(self) -> dict[str, Any]:
        """Return events, end, stop reason, energy residual and counters as plain data."""
        return {
            "events": to_plain(self.events),
            "final": {
                "time": self.final_time,
                "state": self.final,
                "mode": self.mode_names[self.final_mode],
                **self.final_forces,
            },
            "stop_reason": self.stop_reason.label,
            "stop_detail": self.stop_detail,
            **self._findings,
            "notices": list(self.notices),
            "energy_residual": self.energy_residual,
            "energy_closes": self.energy_closes,
            "counters": self.counters,
            "engine": self.engine,
        }

    @property
    def _findings(self) -> dict[str, Any]:
        return plain_fields(self, "limit", "reverse_chatter", "energy_gains", "body_periods")

    def save(self, path: str | Path) -> None:
        """Write to an NPZ file; see `save_npz`.

        Raises
        ------
        InputError
            The folder does not exist or cannot be written.
        """
        texts = {
            **{name: getattr(self.names, name) for name in (*_NAMES, "source")},
            **{name: getattr(self, name) for name in (*_OWN, "final_mode")},
            "names": [self.state_names, self.memory_names, self.mode_names, self.output_names],
            "events": to_plain(self.events),
            "stop_reason": self.stop_reason.label,
            **self._findings,
            "surfaces": to_plain(self.record.surfaces),
            "residual_at_events": to_plain(self.record.residual_at_events),
            "pressed_starts": to_plain(self.record.pressed_starts),
            "scales": dict(self.record.scales),
            "engine_mode": self.record.engine_mode,
            "inputs": self.inputs,
            "outputs": self.evaluator.portable().to_data() if self.evaluator else None,
        }
        arrays = {name: getattr(self, name) for name in (*_ARRAYS, "step_bend")}
        save_npz(path, FORMAT, texts, arrays)

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read a file written by `save`; forces and energies are computed from the file alone.

        Raises
        ------
        InputError
            Not readable, or not a trajectory.
        """
        needed = (*_OWN, *_NAMES, "names", "events", "stop_reason", "final_mode", "outputs")
        text, arrays = load_npz(path, FORMAT, "trajectory", needed, _ARRAYS, ("step_bend",))
        with npz_faults(path, "trajectory"):
            return cls._of_file(text, arrays)

    @classmethod
    def _of_file(cls, text: dict[str, Any], arrays: dict[str, Any]) -> Trajectory:
        states, memory, modes, outputs = (tuple(n) for n in text["names"])
        _check_shapes(arrays, len(states), len(memory), len(modes))
        bend = arrays.get("step_bend")
        bend = np.zeros(len(arrays["step_time"])) if bend is None else bend
        record = StoredRecord(
            steps=StepRecords(*[*(arrays[name] for name in _STEPS), bend]),
            mode_names=modes,
            final_mode=text["final_mode"],
            **{n: of_plain(kind, text.get(n, ())) for n, kind in _FOUND.items()},
            constants=arrays["constants"],
            scales=text.get("scales", {}),
            engine_mode=text.get("engine_mode", -1),
            residual_at_events=_number(text.get("residual_at_events")),
            inputs=dict(text.get("inputs", {})),
        )
        named = {name: text[name] for name in _NAMES} | {"contacts": tuple(text["contacts"])}
        evaluator = outputs_of_data(text["outputs"]) if text["outputs"] else None
        return cls(
            names=MotionNames(
                **named,
                states=states,
                memory=memory,
                outputs=outputs,
                # Files of earlier releases name no source.
                source=text.get("source", ""),
            ),
            record=record,
            **{k: text[k] for k in _OWN},
            **{k: arrays[k] for k in ("final_state", "final_memory")},
            stop_reason=StopReason.from_label(text["stop_reason"]),
            evaluator=evaluator,
            limit=of_plain(SingularLimit | None, text.get("limit")),
        )


def _number(value: float | None) -> float:
    """Return a number of a file, in which nan is null."""
    return float("nan") if value is None else float(value)


def _times(t: ArrayLike) -> Array:
    """Return times as an array of one dimension; InputError for anything but numbers."""
    try:
        times = np.atleast_1d(np.asarray(t, np.float64))
    except (TypeError, ValueError):
        times = np.zeros((0, 0))
    if times.ndim != 1:
        raise InputError(f"trajectory: time: got {received(t)}, need a number or a list of them.")
    return times


def _check_shapes(arrays: dict[str, Any], states: int, memory: int, modes: int) -> None:
    """Raise ValueError where shapes of a file's arrays do not agree."""
    n = len(arrays["step_time"])
    rows = arrays["step_rows"].shape[1:2]
    shapes = {
        **dict.fromkeys(("step_time", "step_length", "step_mode"), (n,)),
        **{"step_memory": (n, memory), "step_rows": (n, *rows, states)},
        **{"final_state": (states,), "final_memory": (memory,)},
    }
    for name, shape in shapes.items():
        if arrays[name].shape != shape or arrays[name].dtype.kind not in "fi":
            raise ValueError(f"{name}: got shape {arrays[name].shape}, need {shape} of numbers")
    if not ((arrays["step_mode"] >= 0) & (arrays["step_mode"] < modes)).all():
        raise ValueError("step_mode: a mode has no name")


def labels(
    mechanism: str,
    given: Mapping[str, Any],
    choices: Mapping[str, str],
    parameters: Mapping[str, Any],
    options: Mapping[str, Any],
) -> dict[str, str]:
    """Return the inputs of a motion as attributes of labelled arrays; see `to_xarray`."""
    tables = {"law_choices": choices, "parameters": parameters}
    tables |= {"state": given["state"], "options": options}
    return {
        **{"mechanism": mechanism, "law": given["law"], "version": given["version"]},
        **{name: json.dumps(table) for name, table in tables.items()},
    }


# What a file has of the record, of the names, of the trajectory itself, and as arrays.
_FOUND = {
    "events": tuple[EventRecord, ...],
    "reverse_chatter": tuple[ReverseChatter, ...],
    "energy_gains": tuple[EnergyGain, ...],
    "body_periods": tuple[BodyPeriod, ...],
    "surfaces": tuple[ContactSurface, ...],
    "pressed_starts": tuple[PressedStart, ...],
}
_NAMES = ("mechanism", "law", "choices", "engine", "contacts", "units", "latex")
_OWN = ("parameters", "rtol", "final_time", "stop_detail", "counters")
_STEPS = ("step_time", "step_length", "step_mode", "step_memory", "step_rows")
_ARRAYS = (*_STEPS, "final_state", "final_memory", "constants")
