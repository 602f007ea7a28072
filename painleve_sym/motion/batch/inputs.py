"""The arrays given to a batch, checked as a whole, and the starts of some of its rows."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from painleve_sym.arrays import Array
from painleve_sym.at.array_inputs import common_shape, given_arrays, numbers_of
from painleve_sym.at.closing import closed_states
from painleve_sym.checks import StateLike
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.mechanics.declarations import TIME_NAME
from painleve_sym.motion.batch.reason_codes import INVALID_START, LEFT_DOMAIN, NON_FINITE
from painleve_sym.motion.continuation import has_states_of, known_scale, states_of_end
from painleve_sym.motion.pressed_start import RESOLVED, has_past
from painleve_sym.motion.refusals import initial_force_fault
from painleve_sym.motion.simulator import NO_FORCE, Simulator
from painleve_sym.motion.trajectory import Trajectory

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
    Forces are in N. `origin` is the motion that all rows continue.
    """

    simulator: Simulator
    shape: tuple[int, ...]
    inputs: dict[str, Array]
    force: Array | None
    origin: Trajectory | None = None

    @classmethod
    def of(
        cls,
        simulator: Simulator,
        states: StateLike,
        parameters: Mapping[str, ArrayLike],
        force: ArrayLike | None,
        close: str | None = None,
        origin: Trajectory | None = None,
    ) -> BatchInputs:
        """Return the inputs; InputError lists every fault of names, numbers and ranges."""
        mechanism, where = simulator.mechanism, f"batch of {simulator.where}"
        given = states, parameters, simulator.declared.by_name
        values, faults = given_arrays(where, mechanism, *given)
        if force is not None:
            force, fault = numbers_of("initial_force", force, "N")
            if not fault and float(force.min()) < 0:
                fault = f"initial_force: got {float(force.min())!r}, need >= 0."
            faults += filter(None, [fault, initial_force_fault(simulator)])
        if faults:
            raise InputError(f"{where}: " + " ".join(faults))
        more = {} if force is None else {"initial_force": force}
        shape = common_shape(where, values | more)
        if close is not None:
            whole = {n: np.broadcast_to(a, shape) for n, a in values.items()}
            values |= closed_states(mechanism, whole, close)
        return cls(simulator, shape, values, force, origin)

    @property
    def count(self) -> int:
        """Number of rows."""
        return math.prod(self.shape)

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

    def _columns(self, names: Sequence[str], start: int, stop: int) -> Array:
        """Return rows of some inputs, one column for each name."""
        columns = np.empty((stop - start, len(names)))
        for column, name in zip(columns.T, names, strict=True):
            array = self.inputs[name]
            column[:] = self.part(array, start, stop) if array.ndim else array
        return columns

    def starts(self, first: int, stop: int) -> Starts:
        """Return the starts of the rows first..stop − 1."""
        simulator, n = self.simulator, stop - first
        parameters = self._columns(simulator.outline.parameter_names, first, stop)
        given = self._columns(simulator.mechanism.state_names, first, stop)
        force = np.full(n, NO_FORCE) if self.force is None else self.part(self.force, first, stop)
        states, admits, scales = simulator.integrator.prepare(parameters, given, force)
        refusal = np.full(n, RUNS, np.int32)
        if self.origin is not None:
            if has_states_of(simulator, self.origin):
                return self._continuing(states, parameters, scales, refusal)
            names = simulator.outline.state_names
            states[:, [k for k, n in enumerate(names) if n == TIME_NAME]] = self.origin.final_time
        for answers, reason in zip(admits.T, _REFUSALS, strict=True):
            refusal[answers == 0] = reason
        refusal[np.isnan(given).any(axis=1)] = INVALID_START  # nothing closes the contact
        return Starts(states, parameters, scales, refusal)

    def _continuing(
        self, states: Array, parameters: Array, scales: Array, refusal: NDArray[np.int32]
    ) -> Starts:
        """Return the starts of rows that continue a motion under its laws."""
        simulator, origin = self.simulator, self.origin
        assert origin is not None
        if origin.record.scales:
            own = [origin.parameters[name] for name in simulator.outline.parameter_names]
            scales[(parameters == own).all(axis=1)] = known_scale(simulator, origin)
        states, decides, fault = states_of_end(simulator, states, scales, origin)
        if fault is None and decides.any():
            fault = (
                "the surface of a closed contact has another speed, and rows of a batch keep the "
                "mode of the motion before. Fix: continue it row by row with simulate."
            )
        if fault is not None:
            raise InputError(f"batch of {simulator.where}: start: {fault}")
        return Starts(states, parameters, scales, refusal)

    @property
    def pressed_count(self) -> int:
        """Number of rows that start pressed, not by a force, under a law that remembers."""
        simulator = self.simulator
        rows = zip(simulator.contact.rows, simulator.contact.own_laws, strict=True)
        names = simulator.outline.state_names
        places = [names.index(row.gap) for row, law in rows if has_past(law)]
        if self.origin is not None:
            return 0  # its past is known
        if not places or self.force is not None:
            return 0
        count = 0
        for first in range(0, self.count, BLOCK):
            block = self.starts(first, min(first + BLOCK, self.count))
            deep = block.states[:, places] < -RESOLVED * block.scales[:, places]
            count += int((deep.any(axis=1) & (block.refusal == RUNS)).sum())
        return count
