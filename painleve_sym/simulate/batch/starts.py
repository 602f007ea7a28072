"""Starts of many motions, ready for the engine; those that cannot run, with the reason."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.contacts.contact_numbers import contact_tolerances
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.simulate.batch.inputs import ManyInputs
from painleve_sym.simulate.batch.reason_codes import INVALID_START, LEFT_DOMAIN, NON_FINITE
from painleve_sym.simulate.simulator import Simulator

RUNS = -1
"""Refusal of a row that can run."""


@dataclass(frozen=True)
class Starts:
    """Some rows of a batch.

    Attributes
    ----------
    first : int
        Number of the first of them.
    states : ndarray, shape (n, nx)
    parameters : ndarray, shape (n, np)
    scales : ndarray, shape (n, nx)
        Of the states, for their tolerances.
    refusal : ndarray of int, shape (n,)
        Number of the reason (`ROW_REASONS`) for which a row cannot run, or `RUNS`.
    """

    first: int
    states: Array
    parameters: Array
    scales: Array
    refusal: NDArray[np.int32]

    def chosen(self, rows: Any) -> Starts:
        """Return the rows of a slice or a mask."""
        arrays = (self.states, self.parameters, self.scales, self.refusal)
        return Starts(self.first, *(a[rows] for a in arrays))


def starts_of(simulator: Simulator, rows: ManyInputs, first: int, stop: int) -> Starts:
    """Return the rows first..stop − 1."""
    # Outside the domain formulas may well divide by zero; those rows are not integrated.
    with np.errstate(all="ignore"):
        return _starts_of(simulator, rows, first, stop)


def _starts_of(simulator: Simulator, rows: ManyInputs, first: int, stop: int) -> Starts:
    values = rows.named(first, stop)
    parameters = np.array([values[s] for s in simulator.outline.parameter_names]).T.copy()
    constants = _constants(simulator, parameters)
    numbers = simulator.contact_values(values)
    states = simulator.initial_states(values, numbers)
    force = None if rows.force is None else rows.part(rows.force, first, stop)
    refusal = np.full(len(states), RUNS, np.int32)
    refusal[_invalid(simulator, states, numbers, force)] = INVALID_START
    refusal[~np.isfinite(constants).all(axis=1)] = NON_FINITE
    refusal[rows.outside(values)] = LEFT_DOMAIN
    if force is not None:
        run = refusal == RUNS
        states[run] = simulator.with_forces(states[run], force[run], constants[run])
        numbers = simulator.contact_values(simulator.at_states(states, constants))
    scales = simulator.all_tolerances(states, constants, numbers)
    return Starts(first, states, parameters, scales, refusal)


def _constants(simulator: Simulator, parameters: Array) -> Array:
    engine = simulator.integrator
    if isinstance(engine, CompiledEngine):
        return engine.many_constants(parameters)
    return np.array([engine.constants(row) for row in parameters])


def _invalid(
    simulator: Simulator,
    states: Array,
    numbers: Sequence[Mapping[str, Array]],
    force: Array | None,
) -> Any:
    """Return which states the contact law does not admit, shape (n,)."""
    invalid = np.zeros(len(states), bool)
    names = simulator.outline.state_names
    for i, (row, own) in enumerate(zip(simulator.contact.rows, numbers, strict=True)):
        gap, rate = (states[:, names.index(s)] for s in (row.gap, row.gap_rate))
        if simulator.is_compliant(i):
            invalid |= False if force is None else gap != 0
        elif simulator.mechanism.outline.contacts[i].bilateral:
            near, slow = contact_tolerances(own)
            invalid |= ~((np.abs(gap) <= near) & (np.abs(rate) <= slow))
        else:
            invalid |= gap < 0
    return invalid
