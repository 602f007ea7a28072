"""The critical force followed over a parameter or a velocity, and its derivatives."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.plain_data import plain_fields
from painleve_sym.progress import progress
from painleve_sym.study.critical.bisection import Border, CriticalForce, CriticalForceFinder

FIRST_WIDTH = 1e-4
"""Relative half width of the first bracket of a continued point; it grows where it must."""
MARGIN = 0.1
"""Of a predicted change, the part by which the prediction may be off before the bracket grows."""


@dataclass(frozen=True, eq=False)
class CriticalCurve(Compared):
    """Critical forces over one quantity.

    It is a parameter of mechanism or law, a coordinate or a velocity. Points are in the order of
    the values; where they end before the last value asked for, `stopped` says why.
    """

    mechanism: str
    law: str
    over: str
    border: Border
    values: Array
    points: tuple[CriticalForce, ...]
    stopped: str

    @property
    def forces(self) -> Array:
        """Critical forces, shape (k,); N."""
        return np.array([p.value for p in self.points])

    @property
    def limits(self) -> Array:
        """F_n* = −B/A, shape (k,); N."""
        return np.array([p.sliding.force for p in self.points])

    @property
    def predicted(self) -> Array:
        """The closed form of the saddle with A and B held, shape (k,); N."""
        return np.array([p.sliding.predicted_force for p in self.points])

    def remainders(self, terms: int) -> Array:
        """Return critical force − first `terms` terms of its expansion, shape (k,); N."""
        return np.array([p.value - sum(p.sliding.expansion[:terms]) for p in self.points])

    def orders(self, terms: int) -> Array:
        """Return exponents p of remainder ∝ valueᵖ between neighbours, shape (k − 1,)."""
        sizes = np.abs(self.remainders(terms))
        return np.diff(np.log(sizes)) / np.diff(np.log(self.values))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        rows = [
            {self.over: value, **point.to_dict()}
            for value, point in zip(self.values.tolist(), self.points, strict=True)
        ]
        return {
            **plain_fields(self, "mechanism", "law", "over", "border"),
            "points": rows,
            "stopped": self.stopped,
        }


def critical_curve(
    finder: CriticalForceFinder,
    state: Mapping[str, float],
    over: str,
    values: Sequence[float],
    *,
    parameters: Mapping[str, float] | None = None,
    border: Border = Border.SLIP_STOP,
) -> CriticalCurve:
    """Follow a critical force by continuation over values that increase or decrease.

    A secant through the last two points, in log |force − prediction of the closed form| or
    linearly, predicts the next; runs on both sides verify the bracket, which grows until it holds
    the border; bisection then ends at round-off. Values near to each other help the secant.

    `over` is a parameter of mechanism or law, a coordinate or a velocity.

    Raises
    ------
    InputError
        Unknown names, repeated values, or no critical force at the first value. Where it ends later
        the points so far are kept and `stopped` says why.
    """
    steps = np.diff(np.array(values, dtype=float))
    if not (np.all(steps > 0) or np.all(steps < 0)):
        raise InputError(
            f"{finder.where}: values of {over}: got {list(map(float, values))}, need numbers that "
            "increase or decrease. Fix: leave out what is repeated."
        )
    held = VariedCase(finder, state, parameters or {})
    points: list[CriticalForce] = []
    stopped = ""
    with progress(f"critical force over {over}", len(values), "points") as advance:
        for value in values:
            at = held.with_value(over, float(value))
            try:
                guess, width = _predicted(finder, at, values, points)
                points.append(finder.find(*at, border=border, guess=guess, width=width))
            except InputError as error:
                if not points:
                    raise
                stopped = f"at {over} = {value:g}: {error}"
                break
            advance(1)
    simulator = finder.simulator
    return CriticalCurve(
        mechanism=simulator.mechanism.name,
        law=simulator.contact_law.name,
        over=over,
        border=border,
        values=np.array(values[: len(points)], dtype=float),
        points=tuple(points),
        stopped=stopped,
    )


def _predicted(
    finder: CriticalForceFinder,
    at: tuple[Mapping[str, float], Mapping[str, float]],
    values: Sequence[float],
    points: Sequence[CriticalForce],
) -> tuple[float | None, float]:
    """Return the predicted force, and the relative half width of the first search."""
    if len(points) < 2:
        return None, 0.05
    k = len(points)
    # What the closed form leaves over changes slowly along the curve.
    near = [p.value - p.sliding.predicted_force for p in points[-2:]]
    part = (values[k] - values[k - 1]) / (values[k - 1] - values[k - 2])
    if min(values[k - 2 : k + 1]) > 0:
        part = math.log(values[k] / values[k - 1]) / math.log(values[k - 1] / values[k - 2])
    base = finder.analysis.at(*at).predicted_force
    if near[0] * near[1] > 0:
        correction = near[1] * (near[1] / near[0]) ** part
    else:
        correction = near[1] + part * (near[1] - near[0])
    guess = base + correction
    if not (math.isfinite(guess) and guess > 0):
        return None, 0.05
    return guess, max(FIRST_WIDTH, MARGIN * abs(correction - near[1]) / guess)


@dataclass(frozen=True)
class VariedCase:
    """State and parameters of which one quantity is varied."""

    finder: CriticalForceFinder
    state: Mapping[str, float]
    parameters: Mapping[str, float]

    @property
    def _names(self) -> dict[str, float]:
        """Return every parameter of mechanism and law with its value."""
        return self.finder.simulator.parameters(self.parameters)

    def with_value(
        self, name: str, value: float
    ) -> tuple[Mapping[str, float], Mapping[str, float]]:
        """Return state and parameters with one quantity replaced."""
        if name in self._names:
            return self.state, {**self.parameters, name: value}
        states = self.finder.simulator.mechanism.state_names
        if name not in states:
            known = (*self._names, *states)
            raise InputError(f"{self.finder.where}: {unknown_name('quantity', name, known)}")
        return {**self.state, name: value}, self.parameters

    def value(self, name: str) -> float:
        """Return the present value of a quantity."""
        self.with_value(name, 0.0)
        return float({**self._names, **self.state}.get(name, 0.0))
