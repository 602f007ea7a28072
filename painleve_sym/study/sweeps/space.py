"""The points of a sweep: a grid over axes, or a sampled set; any part of them without the rest."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.checks import whole_number
from painleve_sym.codegen.evaluate import power
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.toml.faults import Faults

SCALES = ("linear", "log")
METHODS = ("sobol", "uniform")
SOBOL_BITS = 30
"""Of SciPy's sequence: it has 2**30 points."""
MAX_AXIS = 10_000_000
"""Points of one axis: its values are laid out."""


@dataclass(frozen=True)
class Grid:
    """Every combination of the values of the axes, given by name; the last axis varies fastest."""

    axes: dict[str, Array]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the varied quantities."""
        return tuple(self.axes)

    def ends(self, name: str) -> tuple[float, float]:
        """Return the smallest and the largest value of an axis."""
        return float(self.axes[name].min()), float(self.axes[name].max())

    @property
    def shape(self) -> tuple[int, ...]:
        """Points of each axis."""
        return tuple(len(a) for a in self.axes.values())

    @property
    def points(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    def values(self, start: int, stop: int) -> dict[str, Array]:
        """Return points start..stop − 1 by name."""
        places = np.unravel_index(np.arange(start, stop), self.shape)
        return {n: a[i] for (n, a), i in zip(self.axes.items(), places, strict=True)}


@dataclass(frozen=True)
class Range:
    """An interval to draw from, evenly in the number or in its logarithm."""

    low: float
    high: float
    scale: str = "linear"

    def at(self, u: Array) -> Array:
        """Return the numbers at parts `u` of the interval."""
        if self.scale == "linear":
            return self.low + (self.high - self.low) * u
        return self.low * power(np.full(len(u), self.high / self.low), u)


@dataclass(frozen=True)
class Sample:
    """Points drawn from ranges: a scrambled Sobol sequence, or independent uniform numbers."""

    ranges: dict[str, Range]
    points: int
    method: str = "sobol"
    seed: int = 0
    axes: ClassVar[dict[str, Array]] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the varied quantities."""
        return tuple(self.ranges)

    def ends(self, name: str) -> tuple[float, float]:
        """Return the ends of a range, the smaller one first."""
        drawn = self.ranges[name]
        return min(drawn.low, drawn.high), max(drawn.low, drawn.high)

    def values(self, start: int, stop: int) -> dict[str, Array]:
        """Return points start..stop − 1 by name; a point does not depend on where parts begin."""
        n, d = stop - start, len(self.ranges)
        if self.method == "sobol":
            from scipy.stats import qmc  # it takes seconds to import

            engine = qmc.Sobol(d, rng=np.random.default_rng(self.seed))
            # SciPy notes that the first points are not a power of two; the whole set may be one.
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)
                if start:
                    engine.fast_forward(start)
                unit = engine.random(n)
        else:
            generator = np.random.PCG64(self.seed)
            generator.advance(start * d)
            unit = np.random.Generator(generator).random((n, d))
        return {
            name: r.at(np.ascontiguousarray(u))
            for (name, r), u in zip(self.ranges.items(), unit.T, strict=True)
        }


# ---- from the tables of a file ----

Read = Callable[[Any, str, str], float]
"""From a value, its place and the name of its quantity to a number in SI units."""


def read_space(faults: Faults, axes: Any, sample: Any, read: Read) -> Grid | Sample:
    """Return the points that the tables [axes] or [sample] describe; None stands for no table.

    On a fault they are placeholders, and the fault is recorded.
    """
    if (axes is None) == (sample is None):
        received = "both" if axes is not None else "neither"
        faults.fault(
            (),
            f"got {received} of [axes] and [sample], need one: a grid or a sampled set. "
            "Fix: such as [axes] theta = { from = 0.9, to = 1.1, points = 21 }.",
        )
        return Grid({})
    return _grid(faults, axes, read) if sample is None else _sample(faults, sample, read)


def _table(place: str, given: Any, *known: str) -> dict[str, Any]:
    if not isinstance(given, Mapping) or not given:
        raise InputError(f"{place}: got {given!r}, need a table with entries.")
    for key in given:
        if known and key not in known:
            raise InputError(f"{place}: " + unknown_name("key", key, known))
    return dict(given)


def _choice(place: str, value: Any, known: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in known:
        raise InputError(f"{place}: " + unknown_name("choice", str(value), known))
    return value


def _range(place: str, name: str, table: dict[str, Any], read: Read) -> Range:
    for key in ("from", "to"):
        if key not in table:
            raise InputError(f"{place}: no {key!r}. Fix: give both ends.")
    low, high = (read(table[key], f"{place}.{key}", name) for key in ("from", "to"))
    scale = _choice(f"{place}.scale", table.get("scale", "linear"), SCALES)
    if low == high or (scale == "log" and not (low > 0 and high > 0)):
        need = "two different numbers" if low == high else "numbers > 0 on a log scale"
        raise InputError(f"{place}: got {low:g} to {high:g}, need {need}.")
    return Range(low, high, scale)


def _axis(where: str, name: str, given: Any, read: Read) -> Array:
    place = f"axes.{name}"
    if isinstance(given, list):
        listed = [read(v, f"{place}[{i + 1}]", name) for i, v in enumerate(given)]
        if not listed:
            raise InputError(f"{place}: got no values, need at least one.")
        if len(set(listed)) < len(listed):
            raise InputError(f"{place}: got a value twice. Fix: give each once.")
        return np.array(listed)
    table = _table(place, given, "from", "to", "points", "scale")
    ends = _range(place, name, table, read)
    points = whole_number(
        table.get("points"), f"{place}.points", where=where, lower=2, upper=MAX_AXIS
    )
    values = ends.at(np.arange(points) / (points - 1))
    values[-1] = ends.high
    return values


def _grid(faults: Faults, axes: Any, read: Read) -> Grid:
    values = {}
    with faults.at("axes"):
        for name, given in _table("[axes]", axes).items():
            with faults.at("axes", name):
                values[name] = _axis(faults.where, name, given, read)
    return Grid(values)


def _sample(faults: Faults, sample: Any, read: Read) -> Sample:
    where, ranges, drawn = faults.where, {}, dict[str, Range]()
    method, points, seed = METHODS[0], 1, 0
    with faults.at("sample"):
        table = _table("[sample]", sample, "method", "points", "seed", "ranges")
        method = _choice("sample.method", table.get("method", "sobol"), METHODS)
        most = 2**SOBOL_BITS if method == "sobol" else 10**12
        points = whole_number(
            table.get("points"), "sample.points", where=where, lower=1, upper=most
        )
        seed = whole_number(table.get("seed", 0), "sample.seed", where=where, lower=0, upper=2**63)
        ranges = _table("[sample.ranges]", table.get("ranges"))
    for name, given in ranges.items():
        place = f"sample.ranges.{name}"
        with faults.at("sample", "ranges", name):
            if isinstance(given, list) and len(given) == 2:
                given = {"from": given[0], "to": given[1]}
            drawn[name] = _range(place, name, _table(place, given, "from", "to", "scale"), read)
    return Sample(drawn, points, method, seed)
