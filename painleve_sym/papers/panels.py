"""The content of a figure as arrays and labels; its look is decided in `present`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.equality import Compared
from painleve_sym.motion.trajectory import Trajectory


@dataclass(frozen=True)
class Axis:
    """A quantity along an axis: its symbol in mathtext and its unit, empty for a plain number.

    `factor` is the shown value per SI value, such as 1e3 for milliseconds; limits are in the shown
    unit.
    """

    label: str
    unit: str = ""
    factor: float = 1.0
    log: bool = False
    limits: tuple[float, float] | None = None

    def within(self, low: float, high: float) -> Axis:
        """Return the axis with a range, in the shown unit."""
        return Axis(self.label, self.unit, self.factor, self.log, (low, high))


@dataclass(frozen=True, eq=False)
class Curve(Compared):
    """Points joined by a line, in SI units, shape (n,) each; the label is mathtext, or empty.

    Roles are ``line`` (a result), ``reference`` (to compare with), ``admissible`` (the set that
    complementarity admits) and ``points`` (computed points joined by a line).
    """

    label: str
    x: Array
    y: Array
    role: str = "line"


@dataclass(frozen=True)
class Mark:
    """A point worth naming, in SI units: an event of a run by its kind, or a ``solution``."""

    kind: str
    x: float
    y: float


@dataclass(frozen=True)
class Panel:
    """One diagram of a figure; its note is shown inside, where there is nothing to mark."""

    x: Axis
    y: Axis
    curves: tuple[Curve, ...]
    marks: tuple[Mark, ...] = field(default=())
    title: str = ""
    note: str = ""


TIME_MS = Axis(r"$t$", "ms", 1e3)
TIME_US = Axis(r"$t$", "μs", 1e6)
TIME_S = Axis(r"$t$", "s")
SLIP_VELOCITY = Axis(r"$\dot{x}_A$", "m/s")
HEIGHT = Axis(r"$y_A$", "μm", 1e6)
NORMAL_VELOCITY = Axis(r"$\dot{y}_A$", "mm/s", 1e3)
ANGULAR_VELOCITY = Axis(r"$\dot{\theta}$", "rad/s")
FORCE = Axis(r"$F_n$", "N")
FORCE_KN = Axis(r"$F_n$", "kN", 1e-3)
COMPRESSION = Axis(r"$\delta$", "μm", 1e6)
NORMAL_ACCELERATION = Axis(r"$\ddot{y}_A$", "m/s²")
MODULUS = Axis(r"$E$", "Pa", log=True)


def window(trajectory: Trajectory, start: float, end: float, per_step: int = 40) -> Array:
    """Return times that draw a run smoothly, shape (n,).

    Every step is divided into `per_step`, and each event has a point just before it, so that a jump
    of the force is drawn as one. Start and end, s, are cut to the run.
    """
    end = min(end, trajectory.final_time)
    times = trajectory.fine_times(per_step)
    events = np.array([e.time for e in trajectory.events])
    before = np.nextafter(events, -np.inf)
    times = np.concatenate([times, events, before, [start, end]])
    return np.unique(times[(times >= start) & (times <= end)])


def events_as_marks(
    trajectory: Trajectory, name: str, end: float, kinds: tuple[str, ...]
) -> tuple[Mark, ...]:
    """Return a mark on the curve of one quantity for every event of these kinds until `end`."""
    chosen = [e for e in trajectory.events if e.kind in kinds and e.time <= end]
    if not chosen:
        return ()
    # Just before the event: there the force is the one that the event ended.
    times = np.nextafter([e.time for e in chosen], -np.inf)
    values = trajectory.values(name, times)
    return tuple(Mark(e.kind, e.time, float(v)) for e, v in zip(chosen, values, strict=True))


def line(label: str, x: ArrayLike, y: ArrayLike, role: str = "line") -> Curve:
    """Return a curve from anything array-like."""
    return Curve(label, np.asarray(x, dtype=float), np.asarray(y, dtype=float), role)
