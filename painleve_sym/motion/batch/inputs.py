"""The arrays given to a batch, checked as a whole, and the starts of some of its rows."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from painleve_sym.arrays import Array
from painleve_sym.at.closing import closed_states
from painleve_sym.checks import LARGEST, StateLike, by_name, size_text
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.motion.batch.reason_codes import INVALID_START, LEFT_DOMAIN, NON_FINITE
from painleve_sym.motion.pressed_start import RESOLVED, has_past
from painleve_sym.motion.refusals import initial_force_fault
from painleve_sym.motion.simulator import NO_FORCE, Simulator
from painleve_sym.units import in_unit

BLOCK = 4096
"""Rows a thread takes at a time: at the ends of a block lanes are empty."""
RUNS = -1
"""Code of a row that can run, in place of a reason."""
_REFUSALS = (INVALID_START, NON_FINITE, LEFT_DOMAIN)
"""Reasons for which `Prepared.admits` rejects a row; the last one counts."""


@dataclass(frozen=True)
class Starts:
    """Starts of n rows of a batch; arrays of shape (n,), (n, nx) or (n, np).

    `scales` are those of the states, for their tolerances; `refusal` is the number of the reason
    (`ROW_REASONS`) for which a row cannot run, or `RUNS`.
    """

    states: Array
    parameters: Array
    scales: Array
    refusal: NDArray[np.int32]

    def chosen(self, rows: Any) -> Starts:
        """Return the rows of a slice or a mask."""
        arrays = (self.states, self.parameters, self.scales, self.refusal)
        return Starts(*(a[rows] for a in arrays))


@dataclass(frozen=True, eq=False)
class BatchInputs(Compared):
    """States, parameters and initial forces of all rows.

    All arrays broadcast to `shape`, and rows are numbered in its C order. `inputs` has states and
    parameters by name, with defaults; nan for a state that should close a contact and cannot.
    Forces are in N.
    """

    simulator: Simulator
    shape: tuple[int, ...]
    inputs: dict[str, Array]
    force: Array | None

    @classmethod
    def of(
        cls,
        simulator: Simulator,
        states: StateLike,
        parameters: Mapping[str, ArrayLike],
        force: ArrayLike | None,
        close: str | None = None,
    ) -> BatchInputs:
        """Return the inputs; InputError lists every fault of names, numbers and ranges."""
        mechanism, where = simulator.mechanism, f"batch of {simulator.where}"
        declared = simulator.declared.by_name
        values: dict[str, Array] = {n: np.array(0.0) for n in mechanism.state_names}
        values |= {n: np.array(p.default) for n, p in declared.items()}
        units, faults = simulator.units, list[str | None]()
        named = mechanism.outline.named_state(f"{where}: states", _as_array(states))
        for kind, given, known in (
            ("state", named, mechanism.state_names),
            ("parameter", parameters, tuple(declared)),
        ):
            for name, entries in by_name(given, f"{where}: {kind}s").items():
                if name not in known:
                    faults.append(unknown_name(kind, name, known))
                    continue
                values[name], fault = _numbers(f"{kind} {name}", entries, units[name])
                if kind == "parameter" and fault is None:
                    ends = (float(values[name].min()), float(values[name].max()))
                    fault = next(filter(None, map(declared[name].fault, ends)), None)
                faults.append(fault)
        if force is not None:
            force, fault = _numbers("initial_force", force, "N")
            if not fault and float(force.min()) < 0:
                fault = f"initial_force: got {float(force.min())!r}, need >= 0."
            faults += [fault, initial_force_fault(simulator)]
        if any(faults):
            raise InputError(f"{where}: " + " ".join(filter(None, faults)))
        every = (*values.values(), *(() if force is None else (force,)))
        try:
            shape = np.broadcast_shapes(*(a.shape for a in every))
        except ValueError:
            shapes = ", ".join(f"{n} {a.shape}" for n, a in values.items() if a.ndim)
            raise InputError(
                f"{where}: the arrays' shapes do not fit each other: {shapes}. Fix: give arrays "
                "that broadcast, as numpy does."
            ) from None
        if close is not None:
            whole = {n: np.broadcast_to(a, shape) for n, a in values.items()}
            values |= closed_states(mechanism, whole, close)
        return cls(simulator, shape, values, force)

    @property
    def count(self) -> int:
        """Number of rows."""
        return int(np.prod(self.shape, dtype=np.int64))

    def part(self, array: Array, start: int, stop: int) -> Array:
        """Return some rows of an input, without laying out the others."""
        if not array.ndim:
            return np.full(stop - start, array)
        if array.shape == self.shape and array.flags.c_contiguous:
            return array.reshape(-1)[start:stop]
        return np.broadcast_to(array, self.shape).flat[start:stop]

    def row(self, i: int) -> dict[str, float]:
        """Return states and parameters of one row."""
        return {
            n: float(self.part(a, i, i + 1)[0] if a.ndim else a) for n, a in self.inputs.items()
        }

    def named(self, start: int, stop: int) -> dict[str, Array]:
        """Return rows of coordinates, velocities and parameters by name."""
        names = (*self.simulator.mechanism.state_names, *self.simulator.outline.parameter_names)
        return {n: self.part(self.inputs[n], start, stop) for n in names}

    def starts(self, first: int, stop: int) -> Starts:
        """Return the starts of the rows first..stop − 1."""
        simulator, values, n = self.simulator, self.named(first, stop), stop - first
        parameters = np.array([values[name] for name in simulator.outline.parameter_names]).T.copy()
        given = np.array([values[name] for name in simulator.mechanism.state_names]).T.copy()
        force = np.full(n, NO_FORCE) if self.force is None else self.part(self.force, first, stop)
        states, admits, scales = simulator.integrator.prepare(parameters, given, force)
        refusal = np.full(n, RUNS, np.int32)
        for answers, reason in zip(admits.T, _REFUSALS, strict=True):
            refusal[answers == 0] = reason
        refusal[np.isnan(given).any(axis=1)] = INVALID_START  # nothing closes the contact
        return Starts(states, parameters, scales, refusal)

    @property
    def pressed_count(self) -> int:
        """Number of rows that start pressed, not by a force, under a law that remembers."""
        simulator = self.simulator
        rows = zip(simulator.contact.rows, simulator.contact.own_laws, strict=True)
        names = simulator.outline.state_names
        places = [names.index(row.gap) for row, law in rows if has_past(law)]
        if not places or self.force is not None:
            return 0
        count = 0
        for first in range(0, self.count, BLOCK):
            block = self.starts(first, min(first + BLOCK, self.count))
            deep = block.states[:, places] < -RESOLVED * block.scales[:, places]
            count += int((deep.any(axis=1) & (block.refusal == RUNS)).sum())
        return count


def _as_array(states: StateLike) -> StateLike:
    """Return a list of lists as an array, whose last axis is that of the states."""
    if isinstance(states, list | tuple):
        with suppress(TypeError, ValueError):
            return np.asarray(states, dtype=np.float64)
    return states


def _numbers(name: str, given: ArrayLike, unit: str) -> tuple[Array, str | None]:
    if isinstance(given, str):
        given = in_unit(given, unit, name)
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        return np.zeros(()), f"{name}: got {given!r}, need numbers."
    if not values.size:
        return np.zeros(()), f"{name}: got no numbers, need at least one."
    usable = np.abs(values) <= LARGEST
    if not usable.all():
        place = np.unravel_index(np.argmin(usable), values.shape)
        value, at = float(values[place]), f" at {list(map(int, place))}" if place else ""
        need = f"finite numbers{size_text(value)}"
        return np.zeros(()), f"{name}: got {value!r}{at}, need {need}."
    return values, None
