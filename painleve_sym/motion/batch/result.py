"""Result of a batch: arrays of final values, by name."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array, table_library
from painleve_sym.automata.signature import mode_name
from painleve_sym.checks import names_of, text_of
from painleve_sym.choices import Record, RecordLike
from painleve_sym.engines.batch import COUNTERS, AtEvents, BatchOutputs, BatchRows
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.laws.catalogue import law_text
from painleve_sym.motion.batch.inputs import BatchInputs
from painleve_sym.motion.batch.reason_codes import ROW_REASONS
from painleve_sym.motion.continuation import cut_of
from painleve_sym.motion.energy_balance import batch_notices, open_from
from painleve_sym.motion.pressed_start import batch_past_notices
from painleve_sym.motion.run_record import beginning_of, plain_options
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory, labels
from painleve_sym.quantities import unit_of
from painleve_sym.version import __version__

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True, repr=False, eq=False)
class BatchResult(Compared):
    """Result of `run_batch`; every array has the shape of the inputs, row by row.

    ``result["theta_dot"]`` is a final state by name. Other names (`names` lists all):

    - ``time``, ``stop_reason`` (text), ``mode`` (text);
    - ``time_of_KIND``, ``count_of_KIND``: first time of an event and how often it happened;
    - ``times_of_KIND``, shape ``(*shape, events)``: its first times, nan where there were fewer;
    - ``event_times``, shape ``(*shape, kinds, events)``, and ``event_counts``, ``(*shape, kinds)``:
      the same of all kinds;
    - ``max_OUTPUT``, ``max_OUTPUT_time``, ``min_…``, ``integral_OUTPUT``: where asked for;
    - ``QUANTITY_before_EVENT``, ``QUANTITY_after_EVENT``, shape ``(*shape, events)``: values at
      the first events, where asked for;
    - ``energy_residual``: the change of all energies from start to end, relative to the largest of
      them there, or to that by which the tolerance of the works is measured; inf where one is not
      finite, nan where no time passed;
    - the counters of the work, such as ``accepted_steps``.

    Energy that an impact or a reload adds is not among them: `trajectory` of a row names it.

    Attributes
    ----------
    simulator : Simulator
    shape : tuple of int
    inputs : dict of str to ndarray
        States and parameters as given, with defaults; they broadcast to `shape`.
    initial_force : ndarray or None
        N.
    origin : Trajectory or None
        The motion that all rows continue.
    options : RunOptions
        What all rows shared.
    kept : BatchOutputs
    rows : BatchRows
        All that was kept, one row per motion, in C order of `shape`.
    changes : dict of str to object or None
        Phases and inputs, which all rows shared, as plain data; None where nothing changes.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> start = {"theta": [0.95, 1.0], "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> runs = ps.simulate_batch("rod", "bilinear-hertz", start, t_end=1e-2)
    >>> runs.shape, runs["theta"].shape
    ((2,), (2,))
    """

    simulator: Simulator
    shape: tuple[int, ...]
    inputs: dict[str, Array]
    initial_force: Array | None
    options: RunOptions
    kept: BatchOutputs
    rows: BatchRows
    changes: Mapping[str, Any] | None = None
    origin: Trajectory | None = None

    @property
    def source(self) -> str:
        """Works on the mechanism, the laws and the integrator; see `painleve_sym.citation`."""
        return self.simulator.source

    def __repr__(self) -> str:
        """Return mechanism, law, shape and stop reasons in one line."""
        ends = ", ".join(f"{count} {reason}" for reason, count in self.counts().items())
        where = f"{self.simulator.mechanism.name!r} with law {self.simulator.label!r}"
        return f"BatchResult of {where}, shape {self.shape}: {ends}"

    @property
    def notices(self) -> tuple[str, ...]:
        """Sentences that a reader of the result should know.

        They count energy balances that do not close, and starts that a state does not determine.
        """
        residuals = self.rows.energy_residual
        off = residuals[residuals >= open_from(self.options.rtol)]
        count, largest = len(residuals), float(off.max(initial=0.0))
        past = batch_past_notices(self.pressed_count, count)
        return (*past, *batch_notices(len(off), count, largest))

    @cached_property
    def pressed_count(self) -> int:
        """Number of motions that start pressed, not by a force, under a law that remembers."""
        given = BatchInputs(
            self.simulator, self.shape, self.inputs, self.initial_force, self.origin
        )
        return given.pressed_count

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of events, in the order of `event_times`."""
        return self.simulator.outline.kinds

    @cached_property
    def _names(self) -> dict[str, Any]:
        """Name → array of n rows, not yet in the shape of the inputs; texts are made on demand."""
        rows, kept = self.rows, self.kept
        arrays: dict[str, Any] = {"time": rows.time}
        arrays |= {n: rows.state[:, i] for i, n in enumerate(self.simulator.outline.state_names)}
        arrays |= {n: rows.memory[:, i] for i, n in enumerate(self.simulator.outline.memory_names)}
        for k, kind in enumerate(self.kinds):
            if kept.events:
                arrays[f"time_of_{kind}"] = rows.event_times[:, k, 0]
                arrays[f"times_of_{kind}"] = rows.event_times[:, k]
            arrays[f"count_of_{kind}"] = rows.event_counts[:, k]
        if kept.events:
            arrays["event_times"] = rows.event_times
        arrays["event_counts"] = rows.event_counts
        extremes = [*(f"max_{n}" for n in kept.maxima), *(f"min_{n}" for n in kept.minima)]
        for k, name in enumerate(extremes):
            arrays |= {name: rows.extremes[:, k, 0], f"{name}_time": rows.extremes[:, k, 1]}
        arrays |= {f"integral_{n}": rows.integrals[:, k] for k, n in enumerate(kept.integrals)}
        arrays |= {name: rows.samples[:, k] for k, name in enumerate(kept.at_events)}
        arrays["energy_residual"] = rows.energy_residual
        return arrays | {name: rows.counters[:, k] for k, name in enumerate(COUNTERS)}

    @property
    def names(self) -> tuple[str, ...]:
        """Everything that can be asked for by name."""
        return ("stop_reason", "mode", *self._names)

    def __contains__(self, name: object) -> bool:
        """Whether there is a quantity of that name."""
        return name in self.names

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return one quantity of every motion, ``(*shape, *its own dimensions)``."""
        if text_of(name, "batch result: quantity") == "stop_reason":
            labels = np.array([r.label for r in ROW_REASONS])
            return np.asarray(labels[self.rows.reason].reshape(self.shape))
        if name == "mode":
            rows = zip(self.rows.mode.tolist(), self.rows.memory, strict=True)
            modes = np.array([mode_name(self.simulator.outline, m, z) for m, z in rows])
            return np.asarray(modes.reshape(self.shape))
        refuse_unknown("quantity", name, self.names, "batch result")
        array = self._names[name]
        return np.asarray(array.reshape(self.shape + array.shape[1:]))

    def counts(self) -> dict[str, int]:
        """Return the number of rows for each stop reason that occurred."""
        numbers = np.bincount(self.rows.reason, minlength=len(ROW_REASONS))
        return {r.label: int(n) for r, n in zip(ROW_REASONS, numbers, strict=True) if n}

    def trajectory(self, *index: int) -> Trajectory:
        """Return the whole motion of one row, run again: the same bits, with every step.

        Parameters
        ----------
        *index : int
            Place in the arrays: one number per dimension.
        """
        row = {n: float(np.broadcast_to(a, self.shape)[index]) for n, a in self.inputs.items()}
        given = self.initial_force
        force = None if given is None else float(np.broadcast_to(given, self.shape)[index])
        more = self.changes, self.origin
        return run_row(self.simulator, row, self.options, Record.DENSE, force, *more)

    def units(self, name: str) -> str:
        """Return the SI unit of a quantity; "1" where it has none."""
        return unit_of(name, self.simulator.units)

    @property
    def varied(self) -> dict[str, tuple[tuple[int, ...], Array]]:
        """Inputs that differ between the rows, by name.

        Each with the dimensions of `shape` along which it differs, and its values along them.
        """
        varied = {}
        force = {} if self.initial_force is None else {"initial_force": self.initial_force}
        for name, given in {**self.inputs, **force}.items():
            own = np.asarray(given)
            own = own.reshape((1,) * (len(self.shape) - own.ndim) + own.shape)
            axes = tuple(i for i in range(own.ndim) if own.shape[i] > 1)
            if axes:
                varied[name] = (axes, own.reshape([own.shape[i] for i in axes]))
        return varied

    def to_dataframe(self, names: str | Sequence[str] | None = None) -> pandas.DataFrame:
        """Return a `pandas.DataFrame` with one row per motion: varied inputs, then quantities.

        Parameters
        ----------
        names : sequence of str, optional
            Quantities of one number per motion; all of these where none are given.

        Raises
        ------
        InputError
            pandas is not installed, an unknown name, or a quantity of several numbers.
        """
        frames = table_library("pandas", "a data frame")
        plain = [n for n in self.names if not event_dims(n)]
        chosen = plain if names is None else names_of(names, "batch result: names")
        columns: dict[str, Any] = {}
        for name in self.varied:
            given = self.inputs.get(name, self.initial_force)
            columns[self._label(name)] = np.broadcast_to(np.asarray(given), self.shape).ravel()
        for name in chosen:
            if event_dims(name):
                raise InputError(
                    f"batch result: {name} has several numbers per motion, and a data frame has "
                    "one. Fix: take to_xarray, or time_of_KIND."
                )
            columns[name] = self[name].ravel()
        frame: pandas.DataFrame = frames.DataFrame(columns)
        frame.attrs["units"] = {c: self.units(c.removeprefix("start_")) for c in columns}
        return frame

    def to_xarray(
        self, names: str | Sequence[str] | None = None, dims: str | Sequence[str] | None = None
    ) -> xarray.Dataset:
        """Return an `xarray.Dataset` of the quantities `names`, by default all but ``times_of_…``.

        ``event_times`` has the further dimensions ``event``, the kinds by name, and ``occurrence``
        from 1.

        Parameters
        ----------
        names : sequence of str, optional
        dims : sequence of str, optional
            Names of the dimensions. Where none are given, a dimension along which a single input
            varies is called as that input, others are ``row`` or ``axis_0``, ``axis_1``, …

        Returns
        -------
        xarray.Dataset
            Inputs that differ between the rows are coordinates; a state's is ``start_NAME``, since
            its plain name is that of the final value. All others are attributes, as of
            `Trajectory.to_xarray`.

        Raises
        ------
        InputError
            xarray is not installed, or an unknown name.
        """
        library = table_library("xarray", "a labelled array")
        dims = self._dims() if dims is None else names_of(dims, "batch result: dims")
        if len(dims) != len(self.shape):
            raise InputError(
                f"batch result: dims: got {len(dims)} names, need {len(self.shape)}, one for each "
                f"dimension of the shape {self.shape}."
            )
        coordinates = {
            self._label(name): (tuple(dims[i] for i in axes), values, {"units": self.units(name)})
            for name, (axes, values) in self.varied.items()
        }
        usual = tuple(n for n in self.names if not n.startswith("times_of_"))
        names = usual if names is None else names_of(names, "batch result: names")
        variables = {
            name: ((*dims, *event_dims(name)), self[name], {"units": self.units(name)})
            for name in names
        }
        used = {d for name in names for d in event_dims(name)}
        indices = {
            "event": ("event", np.array(self.kinds)),
            "occurrence": ("occurrence", np.arange(1, self.kept.events + 1)),
        }
        simulator, options = self.simulator, self.options
        plain = {n: float(a) for n, a in self.inputs.items() if np.ndim(a) == 0}
        start = {n: v for n, v in plain.items() if n in simulator.mechanism.state_names}
        kept = {"rtol": options.rtol, **plain_options(options)}
        kept["engine"] = simulator.integrator.name
        if self.initial_force is not None and np.ndim(self.initial_force) == 0:
            kept["initial_force"] = float(self.initial_force)
        given = {"law": law_text(simulator.law), "state": start, "version": __version__}
        parameters = {n: v for n, v in plain.items() if n not in start}
        attributes = labels(simulator.mechanism.name, given, simulator.choices, parameters, kept)
        if self.origin is not None:
            cut = cut_of(simulator, self.origin)
            attributes["continues"] = json.dumps(beginning_of(simulator.outline, cut))
        dataset: xarray.Dataset = library.Dataset(
            variables,
            coords=coordinates | {d: index for d, index in indices.items() if d in used},
            attrs=attributes,
        )
        return dataset

    def _label(self, name: str) -> str:
        return f"start_{name}" if name in self else name

    def _dims(self) -> tuple[str, ...]:
        count = len(self.shape)
        along: dict[int, list[str]] = {i: [] for i in range(count)}
        for name, (axes, _) in self.varied.items():
            for i in axes:
                along[i].append(self._label(name) if len(axes) == 1 else "")
        plain = ("row",) if count == 1 else tuple(f"axis_{i}" for i in range(count))
        return tuple(
            names[0] if len(names) == 1 and names[0] else plain[i] for i, names in along.items()
        )


def event_dims(name: str) -> tuple[str, ...]:
    """Return the dimensions of a quantity besides those of the points."""
    if name.startswith("times_of_") or AtEvents.of(name):
        return ("occurrence",)
    return {"event_times": ("event", "occurrence"), "event_counts": ("event",)}.get(name, ())


def run_row(
    simulator: Simulator,
    row: dict[str, float],
    o: RunOptions,
    record: RecordLike,
    force: float | None,
    changes: Mapping[str, Any] | None = None,
    origin: Trajectory | None = None,
) -> Trajectory:
    """Return the single run of a row's states and parameters, with phases and inputs."""
    simulator = simulator.whole
    states = {n: row[n] for n in simulator.mechanism.state_names}
    others = {n: v for n, v in row.items() if n not in states}
    settings = {**o.arguments(atol=None, record=record), **(changes or {})}
    if origin is not None:
        return simulator.run(start=origin, parameters=others, **settings)
    return simulator.run(states, parameters=others, initial_force=force, **settings)
