"""The figure of one motion: forces, coordinates and velocities, with its events marked."""

from __future__ import annotations

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError
from painleve_sym.motion.trajectory import EventRecord, Trajectory
from painleve_sym.present.style import MARKERS, PAGE, PALETTE, REFERENCE, STYLE, Marker
from painleve_sym.quantities import axis_label, text_label

MAX_POINTS = 20_000
"""Maximum number of plotted points."""
MAX_LINES = 60
"""More lines than this hide the curves; the events are then marked on the force only."""

_FORCES = {"normal_force": ("F_n", "solid"), "tangential_force": ("F_t", (0, (5, 1.5)))}


def trajectory_figure(trajectory: Trajectory) -> Figure:
    """Return a figure of the forces, every coordinate and every velocity over time.

    Parameters
    ----------
    trajectory : Trajectory
        With steps.

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
    names = _motion(trajectory)
    rows = 1 + len(names) // 2
    with rc_context(STYLE):
        figure = Figure(figsize=(PAGE, 0.6 + 1.45 * rows), layout="constrained")
        grid = figure.add_gridspec(rows, 2)
        top = figure.add_subplot(grid[0, :])
        below = [
            figure.add_subplot(grid[1 + i // 2, i % 2], sharex=top) for i in range(2 * rows - 2)
        ]
        _draw(trajectory, names, top, below)
        law = trajectory.law + "".join(f" ({k} {v})" for k, v in trajectory.choices.items())
        top.set_title(f"{trajectory.mechanism}, {law}")
        figure.legend(loc="outside lower center", ncols=4)
    return figure


def _motion(trajectory: Trajectory) -> list[str]:
    """Return names of coordinates and velocities in turn."""
    states = trajectory.state_names
    coordinates = [n for n in trajectory.names.units if n in states and f"{n}_dot" in states]
    return [name for c in coordinates for name in (c, f"{c}_dot")]


def _draw(trajectory: Trajectory, names: list[str], top: Axes, below: list[Axes]) -> None:
    """Draw forces into `top`, coordinates and velocities side by side into `below`."""
    times = _times(trajectory)
    scale, unit = _time_unit(trajectory.final_time - float(trajectory.step_time[0]))
    outputs, states = trajectory.outputs(times), trajectory(times)
    contacts = trajectory.names.contacts
    for k, contact in enumerate(contacts):
        several = len(contacts) > 1
        for name, (symbol, dashes) in _FORCES.items():
            values = outputs[f"{name}_{contact}" if several else name]
            label = rf"${symbol}$ of {contact}" if several else f"${symbol}$"
            top.plot(times * scale, values, color=PALETTE[k], linestyle=dashes, label=label)
    top.set_ylabel(text_label("force", "N"))
    top.set_xlabel(text_label("time", unit))
    for axes, name in zip(below, names, strict=True):
        values = states[:, trajectory.state_names.index(name)]
        axes.plot(times * scale, values, color=PALETTE[0])
        axes.set_ylabel(axis_label(trajectory.names.latex[name], trajectory.names.units[name]))
    for axes in below[-2:]:
        axes.set_xlabel(text_label("time", unit))
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
