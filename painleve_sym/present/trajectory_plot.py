"""The figure of one motion: forces, coordinates and velocities, with its events marked."""

from __future__ import annotations

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.trajectory import EventRecord, Trajectory
from painleve_sym.present.style import MARKERS, PAGE, PALETTE, REFERENCE, STYLE, Marker
from painleve_sym.quantities import axis_label

MAX_POINTS = 20_000
"""Maximum number of plotted points."""
MAX_LINES = 60
"""More lines than this hide the curves; the events are then marked on the force only."""

_FORCES = {"normal_force": ("F_n", "solid"), "tangential_force": ("F_t", (0, (5, 1.5)))}


def trajectory_figure(trajectory: Trajectory, mechanism: Mechanism) -> Figure:
    """Return a figure of the forces, every coordinate and every velocity over time.

    Parameters
    ----------
    trajectory : Trajectory
        With steps, and the engine that gives its forces.
    mechanism : Mechanism
        The one it was simulated with, for symbols and units.

    Raises
    ------
    InputError
        The trajectory holds no steps.
    """
    if not len(trajectory.step_time):
        why = f"the run ended at its start ({trajectory.stop_reason.label})"
        raise InputError(
            f"figure: {why}: there is no motion to draw. Fix: start elsewhere."
            if trajectory.ended_at_start
            else "figure: the trajectory holds no steps. Fix: simulate with record='dense'."
        )
    rows = 1 + len(mechanism.system.coordinates)
    with rc_context(STYLE):
        figure = Figure(figsize=(PAGE, 0.6 + 1.45 * rows), layout="constrained")
        grid = figure.add_gridspec(rows, 2)
        top = figure.add_subplot(grid[0, :])
        below = [
            figure.add_subplot(grid[1 + i // 2, i % 2], sharex=top) for i in range(2 * rows - 2)
        ]
        _draw(trajectory, mechanism, top, below)
        law = trajectory.law + "".join(f" ({k} {v})" for k, v in trajectory.choices.items())
        top.set_title(f"{trajectory.mechanism}, {law}")
        figure.legend(loc="outside lower center", ncols=4)
    return figure


def _draw(trajectory: Trajectory, mechanism: Mechanism, top: Axes, below: list[Axes]) -> None:
    """Draw forces into `top`, coordinates and velocities side by side into `below`."""
    times = _times(trajectory)
    scale, unit = _time_unit(trajectory.final_time - float(trajectory.step_time[0]))
    outputs, states = trajectory.outputs(times), trajectory(times)
    for k, contact in enumerate(mechanism.contacts):
        several = len(mechanism.contacts) > 1
        for name, (symbol, dashes) in _FORCES.items():
            values = outputs[f"{name}_{contact.name}" if several else name]
            label = rf"${symbol}$ of {contact.name}" if several else f"${symbol}$"
            top.plot(times * scale, values, color=PALETTE[k], linestyle=dashes, label=label)
    top.set_ylabel("force [N]")
    top.set_xlabel(f"time [{unit}]")
    names = [n for c in mechanism.system.coordinates for n in (c.name, f"{c.name}_dot")]
    for axes, name in zip(below, names, strict=True):
        values = states[:, trajectory.state_names.index(name)]
        axes.plot(times * scale, values, color=PALETTE[0])
        axes.set_ylabel(axis_label(mechanism.latex_names[name], mechanism.units[name]))
    for axes in below[-2:]:
        axes.set_xlabel(f"time [{unit}]")
    _mark_events(trajectory.events, top, below, scale)


def _times(trajectory: Trajectory) -> Array:
    times = trajectory.fine_times()
    if len(times) > MAX_POINTS:
        times = times[np.linspace(0, len(times) - 1, MAX_POINTS).round().astype(int)]
    return times


def _time_unit(length: float) -> tuple[float, str]:
    for scale, unit in ((1.0, "s"), (1e3, "ms")):
        if length * scale >= 1:
            return scale, unit
    return 1e6, "µs"


def _mark_events(
    events: tuple[EventRecord, ...], top: Axes, below: list[Axes], scale: float
) -> None:
    for i, kind in enumerate(dict.fromkeys(e.kind for e in events)):
        of_kind = [e for e in events if e.kind == kind]
        look = MARKERS.get(kind, Marker(kind.replace("_", " "), "s", 4.0, "white"))
        colour = PALETTE[1 + i % (len(PALETTE) - 1)]
        times = [e.time * scale for e in of_kind]
        top.plot(
            times,
            [e.normal_force for e in of_kind],
            linestyle="none",
            marker=look.symbol,
            markersize=look.size,
            color=colour,
            markerfacecolor=colour if look.face != "white" else "white",
            label=look.name + (f" ({len(times)})" if len(times) > 1 else ""),
        )
        if len(events) <= MAX_LINES:
            for axes in (top, *below):
                for t in times:
                    axes.axvline(t, color=REFERENCE, linewidth=0.5, alpha=0.7, zorder=0)
