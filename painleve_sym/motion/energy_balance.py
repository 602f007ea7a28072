"""The energy balance of a motion: by how much the sum of its energies changes."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from painleve_sym.arrays import Array

_POTENTIAL = "potential_energy"
ENERGY_ROUNDING = 100 * np.finfo(float).eps
"""Of the energies: what coordinates of a body at rest carry along from many operations."""
_MULTIPLE, _LOWEST_LIMIT, _HIGHEST_LIMIT = 1e3, 1e-9, 0.1
"""From this multiple of rtol on a residual is not explained by it, within limits: rounding adds up
to more than a tiny rtol, and a tenth is much by any."""


def balance_residual(terms: Mapping[str, Array], scale: float = 0.0) -> float:
    """Return the largest change of the sum of energies since the start.

    It is relative to the largest of the sizes of the terms, the potential energy counted from its
    start, or to the `scale`, J, where that is larger. 0 where no term is more than rounding, inf
    where one is not finite. Each term has its values in the order of time, shape (n,); J.
    """
    every = np.array(list(terms.values()))
    with np.errstate(invalid="ignore", over="ignore"):
        total = every.sum(axis=0)
    if not (np.isfinite(every).all() and np.isfinite(total).all()):
        return math.inf
    rounding = ENERGY_ROUNDING * float(np.abs(every).max(axis=1).sum())
    since = np.array([v - v[0] if name == _POTENTIAL else v for name, v in terms.items()])
    size = max(scale, float(np.abs(since).max()))
    return float(np.abs(total - total[0]).max() / size) if size > rounding else 0.0


def open_from(rtol: float) -> float:
    """Return the residual from which on the energy balance does not close."""
    return min(max(_MULTIPLE * rtol, _LOWEST_LIMIT), _HIGHEST_LIMIT)


def balance_closes(residual: float, rtol: float) -> bool | None:
    """Return whether the energy balance closes; None where the residual is not known (nan)."""
    return None if math.isnan(residual) else residual < open_from(rtol)


def balance_notice(residual: float, rtol: float) -> str:
    """Return a warning on an energy balance that does not close."""
    if math.isinf(residual):
        return "The energies are not finite."
    return (
        f"The energy balance is off by {100 * residual:.2g} % of its largest term, more than rtol "
        f"{rtol:g} explains: works and energies are not exact, and states may not be. Fix: compare "
        "with another engine, or a smaller rtol."
    )


def batch_notices(count: int, motions: int, largest: float) -> tuple[str, ...]:
    """Return the same of a batch, `count` of whose balances do not close; none where all do."""
    if not count:
        return ()
    return (
        f"The energy balance of {count:,} of {motions:,} motions does not close (energy_residual "
        f"up to {largest:.2g}): their works and energies are not exact, and their states may not "
        "be. Fix: compare with another engine, or a smaller rtol.",
    )
