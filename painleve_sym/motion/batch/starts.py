"""Initial values of a batch, ready for the engine, with the reasons of rows that cannot run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.motion.batch.inputs import BatchInputs
from painleve_sym.motion.batch.reason_codes import INVALID_START, LEFT_DOMAIN, NON_FINITE
from painleve_sym.motion.simulator import NO_FORCE, Simulator

RUNS = -1
"""Code of a row that can run, in place of a reason."""
_REFUSALS = (INVALID_START, NON_FINITE, LEFT_DOMAIN)
"""Reasons for which `Prepared.admits` rejects a row; the last one counts."""


@dataclass(frozen=True)
class Starts:
    """Some rows of a batch, from the number `first` on; arrays of shape (n,), (n, nx) or (n, np).

    `scales` are those of the states, for their tolerances; `refusal` is the number of the reason
    (`ROW_REASONS`) for which a row cannot run, or `RUNS`.
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


def starts_of(simulator: Simulator, rows: BatchInputs, first: int, stop: int) -> Starts:
    """Return the rows first..stop − 1."""
    values, n = rows.named(first, stop), stop - first
    parameters = np.array([values[name] for name in simulator.outline.parameter_names]).T.copy()
    given = np.array([values[name] for name in simulator.mechanism.state_names]).T.copy()
    force = np.full(n, NO_FORCE) if rows.force is None else rows.part(rows.force, first, stop)
    states, admits, scales = simulator.integrator.prepare(parameters, given, force)
    refusal = np.full(n, RUNS, np.int32)
    for answers, reason in zip(admits.T, _REFUSALS, strict=True):
        refusal[answers == 0] = reason
    refusal[np.isnan(given).any(axis=1)] = INVALID_START  # nothing closes the contact
    return Starts(first, states, parameters, scales, refusal)
