"""Maps of the outcome, lift-off or impact, over the initial force and one more quantity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array, load_npz, npz_faults, save_npz
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.plain_data import finite, plain_fields
from painleve_sym.progress import Advance, progress
from painleve_sym.study.critical.bisection import Border, CriticalForceFinder, Outcome
from painleve_sym.study.critical.continuation import VariedCase

FORMAT = "painleve-sym outcome map 1"
LEGEND: Mapping[str, int] = {
    Outcome.UNDECIDED.value: -1,
    Outcome.LIFTS_OFF.value: 0,
    Outcome.STOPS_IN_RESTITUTION.value: 1,
    Outcome.STOPS_IN_COMPRESSION.value: 2,
}
"""Codes of the outcomes; undecided also where the state is not indeterminate."""
MAX_POINTS = 400
"""Points along an axis: every point is a run."""
DECADES = 30.0
"""Ratio of the ends from which a positive axis is spaced, and drawn, logarithmically."""

_ARRAYS = ("forces", "values", "outcome", "limit", "predicted", "slip_stop", "compression")
_TEXTS = ("mechanism", "law", "over", "unit", "state", "parameters")


@dataclass(frozen=True, eq=False)
class OutcomeMap(Compared):
    """Outcomes of compliant runs over initial force and one quantity.

    Attributes
    ----------
    mechanism, law : str
    over, unit : str
        The second axis: a parameter, a coordinate or a velocity.
    forces : ndarray, shape (n,)
        Initial forces F_n0; N.
    values : ndarray, shape (k,)
        Of `over`.
    outcome : ndarray of int8, shape (n, k)
        Codes of `LEGEND`.
    limit : ndarray, shape (k,)
        F_n* = −B/A; nan where the state is not indeterminate. N.
    predicted : ndarray, shape (k,)
        The closed form of the saddle with A and B held; 0 where every force leads to impact. N.
    slip_stop, compression : ndarray, shape (k,)
        Both critical forces, to round-off; nan where there is none. N.
    state, parameters : dict of str to float
        Values that are constant over the map.
    """

    mechanism: str
    law: str
    over: str
    unit: str
    forces: Array
    values: Array
    outcome: NDArray[np.int8]
    limit: Array
    predicted: Array
    slip_stop: Array
    compression: Array
    state: dict[str, float]
    parameters: dict[str, float]

    @property
    def logarithmic(self) -> bool:
        """Whether the second axis is spaced logarithmically."""
        return _logarithmic(float(self.values[0]), float(self.values[-1]))

    @property
    def counts(self) -> dict[str, int]:
        """Number of points of each outcome, every entry of `LEGEND` in its order."""
        return {name: int(np.sum(self.outcome == code)) for name, code in LEGEND.items()}

    @property
    def columns(self) -> Array:
        """Values, F_n*, its closed form and both critical forces as columns, shape (k, 5)."""
        lines = (self.limit, self.predicted, self.slip_stop, self.compression)
        return np.column_stack((self.values, *lines))

    def summary(self) -> dict[str, Any]:
        """Return plain data without the grid."""
        names = (self.over, "limit", "predicted", *(b.value for b in Border))
        return {
            **plain_fields(self, "mechanism", "law", "over", "unit", "counts"),
            "critical_forces": [
                dict(zip(names, map(finite, row), strict=True)) for row in self.columns.tolist()
            ],
            **plain_fields(self, "state", "parameters"),
        }

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data for JSON: lists for arrays, None for nan."""
        return {
            **self.summary(),
            "legend": dict(LEGEND),
            "forces": self.forces.tolist(),
            "outcome": self.outcome.tolist(),
        }

    def save(self, path: str | Path) -> None:
        """Write to an NPZ file (arrays and JSON text, no pickle): whole, or not at all."""
        texts, arrays = ({n: getattr(self, n) for n in names} for names in (_TEXTS, _ARRAYS))
        save_npz(path, FORMAT, texts, arrays)

    @classmethod
    def load(cls, path: str | Path) -> OutcomeMap:
        """Read a file of `save`; InputError where it is not readable, or not a map of outcomes."""
        texts, arrays = load_npz(path, FORMAT, "outcome map", _TEXTS, _ARRAYS)
        with npz_faults(path, "outcome map"):
            return cls(**{name: texts[name] for name in _TEXTS}, **arrays)


def _logarithmic(low: float, high: float) -> bool:
    return low > 0 and high / low > DECADES


def _critical_lines(setting: VariedCase, over: str, values: Array, advance: Advance) -> Array:
    """Return F_n*, its prediction and both critical forces at each value, N; nan where none is.

    InputError where there is no indeterminate state at any value.
    """
    finder, reasons = setting.finder, list[str]()
    lines = np.full((4, len(values)), np.nan)
    for i, value in enumerate(values):
        at = setting.with_value(over, float(value))
        advance(1)
        try:
            sliding = finder.analysis.at(*at)
        except InputError as error:
            reasons.append(str(error))
            continue
        lines[:2, i] = sliding.force, sliding.predicted_force
        for row, border in enumerate(Border, start=2):
            # Where every force leads to impact there is no critical one.
            try:
                critical = finder.find(*at, border=border, check_tolerance=False)
                lines[row, i] = critical.value
            except InputError as error:
                reasons.append(str(error))
    if np.isnan(lines[0]).all():
        raise InputError(reasons[0])
    return lines


def outcome_map(
    finder: CriticalForceFinder,
    state: Mapping[str, float],
    over: str,
    ends: tuple[float, float],
    *,
    forces: tuple[float, float] | None = None,
    points: int = 61,
    parameters: Mapping[str, float] | None = None,
) -> OutcomeMap:
    """Run from a grid of initial forces and values of one quantity; add both critical forces.

    `over` is a parameter of mechanism or law, a coordinate or a velocity; it goes between its
    `ends`, spaced logarithmically over more than a decade and a half. `forces` are by default 0 to
    1.25 times the largest of F_n* and the critical forces, N. Along each axis are 2 to 400 points.

    Raises
    ------
    InputError
        Unknown names, ends that are none, no indeterminate state on the whole axis.
    """
    setting = VariedCase(finder, state, parameters or {})
    values = _axis(finder, over, ends, points)
    setting.value(over)  # an unknown name is reported here
    if forces is not None:
        _axis(finder, "initial force", forces, points)
        if forces[0] < 0:
            raise InputError(f"{finder.where}: initial force: got {forces[0]:g} N, need >= 0.")
    with progress(f"outcomes over {over}", 2 * points, "lines") as advance:
        lines = _critical_lines(setting, over, values, advance)
        top = 1.25 * float(np.nanmax(lines[[0, 2, 3]]))
        grid = np.linspace(*(forces or (0.0, top)), points)
        outcome = np.full((points, points), LEGEND[Outcome.UNDECIDED.value], dtype=np.int8)
        for i, value in enumerate(values):
            if not np.isnan(lines[0, i]):
                start, given = setting.with_value(over, float(value))
                outcome[:, i] = [LEGEND[o.value] for o in finder.outcomes(start, grid, given)]
            advance(1)
    simulator = finder.simulator
    return OutcomeMap(
        mechanism=simulator.mechanism.name,
        law=simulator.contact_law.name,
        over=over,
        unit=simulator.units[over],
        forces=grid,
        values=values,
        outcome=outcome,
        limit=lines[0],
        predicted=lines[1],
        slip_stop=lines[2],
        compression=lines[3],
        state={n: float(v) for n, v in state.items() if n != over},
        parameters={n: v for n, v in simulator.parameters(parameters).items() if n != over},
    )


def _axis(finder: CriticalForceFinder, name: str, ends: tuple[float, float], points: int) -> Array:
    if not 2 <= points <= MAX_POINTS:
        raise InputError(f"{finder.where}: points: got {points}, need 2 to {MAX_POINTS}.")
    low, high = ends
    if not (np.isfinite(low) and np.isfinite(high) and low < high):
        raise InputError(
            f"{finder.where}: range of {name}: got {low:g}:{high:g}, need from < to. "
            "Fix: swap them, or give two numbers."
        )
    if _logarithmic(low, high):
        return np.geomspace(low, high, points)
    return np.linspace(low, high, points)
