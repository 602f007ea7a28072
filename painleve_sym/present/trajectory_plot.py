"""The figure of one motion: forces, coordinates and velocities, with its events marked."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError
from painleve_sym.escape import figure_text
from painleve_sym.motion.trajectory import EventRecord, Trajectory
from painleve_sym.present.style import MARKERS, PAGE, PALETTE, STYLE, Marker, event_label
from painleve_sym.quantities import axis_label, scaled_unit, text_label

MAX_POINTS = 20_000
"""Maximum number of plotted points."""
MAX_MARKERS = 12
"""More events of a kind than this hide the curve; they are then ticks above it only."""
MAGNIFIED = 0.2
"""Part of the motion: events that all happen within less have a panel with a magnified time."""

_FORCES = {"normal_force": ("F_n", "solid"), "tangential_force": ("F_t", (0, (5, 1.5)))}


def trajectory_figure(trajectory: Trajectory) -> Figure:
    """Return a figure of the forces, every coordinate and every velocity over time.

    InputError where the trajectory holds no steps.
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
        window = _magnified(trajectory)
        top = figure.add_subplot(grid[0, :] if window is None else grid[0, 0])
        near = None if window is None else figure.add_subplot(grid[0, 1])
        below = [
            figure.add_subplot(grid[1 + i // 2, i % 2], sharex=top) for i in range(2 * rows - 2)
        ]
        _draw(trajectory, names, [top] if near is None else [top, near], below)
        law = trajectory.law + "".join(f" ({k} {v})" for k, v in trajectory.choices.items())
        top.set_title(f"{figure_text(trajectory.mechanism)}, {law}")
        if near is not None and window is not None:
            scale, _ = _time_unit(trajectory)
            near.set_xlim(window[0] * scale, window[1] * scale)
            near.set_title("time magnified around the events")
        figure.legend(loc="outside lower center", ncols=4)
    return figure


def _motion(trajectory: Trajectory) -> list[str]:
    """Return names of coordinates and velocities in turn."""
    states = trajectory.state_names
    coordinates = [n for n in trajectory.names.units if n in states and f"{n}_dot" in states]
    return [name for c in coordinates for name in (c, f"{c}_dot")]


def _magnified(trajectory: Trajectory) -> tuple[float, float] | None:
    """Return a window of time around all events; None where they are spread over the motion."""
    times = [e.time for e in trajectory.events]
    start, end = float(trajectory.step_time[0]), trajectory.final_time
    length = max(times, default=0.0) - min(times, default=0.0)
    if not 0 < length < MAGNIFIED * (end - start):
        return None
    return max(start, min(times) - 0.4 * length), min(end, max(times) + 0.4 * length)


def _draw(trajectory: Trajectory, names: list[str], tops: list[Axes], below: list[Axes]) -> None:
    """Draw forces into `tops`, coordinates and velocities side by side into `below`."""
    times = _times(trajectory)
    scale, unit = _time_unit(trajectory)
    outputs, states = trajectory.outputs(times), trajectory(times)
    contacts = trajectory.names.contacts
    several = len(contacts) > 1
    curves = {
        (k, name): outputs[f"{name}_{contact}" if several else name]
        for k, contact in enumerate(contacts)
        for name in _FORCES
    }
    largest = max(float(np.nanmax(np.abs(v))) for v in curves.values())
    factor, force_unit = scaled_unit("N", largest)
    for axes in tops:
        for (k, name), values in curves.items():
            symbol, dashes = _FORCES[name]
            label = rf"${symbol}$ of {contacts[k]}" if several else f"${symbol}$"
            # The first are the widest: where forces coincide, each still shows.
            look: dict[str, Any] = {"linewidth": 1.1 + 1.3 * (len(contacts) - 1 - k)}
            look |= {"color": PALETTE[k], "linestyle": dashes}
            shown = label if axes is tops[0] else "_"
            axes.plot(times * scale, values * factor, label=shown, **look)
        axes.set_xlabel(text_label("time", unit))
    tops[0].set_ylabel(text_label("force", force_unit))
    for axes, name in zip(below, names, strict=True):
        values = states[:, trajectory.state_names.index(name)]
        own, own_unit = scaled_unit(trajectory.names.units[name], float(np.max(np.abs(values))))
        axes.plot(times * scale, values * own, color=PALETTE[0])
        axes.set_ylabel(axis_label(trajectory.names.latex[name], own_unit))
    for axes in below[-2:]:
        axes.set_xlabel(text_label("time", unit))
    _mark_events(trajectory.events, tops, below, scale, factor)


def _times(trajectory: Trajectory) -> Array:
    # Just before an event, too: forces may jump there.
    before = [np.nextafter(e.time, -np.inf) for e in trajectory.events]
    times = np.union1d(trajectory.fine_times(), before)
    times = times[times >= trajectory.step_time[0]]
    kept = np.linspace(0, len(times) - 1, min(len(times), MAX_POINTS)).round().astype(int)
    drawn: Array = times[kept]
    return drawn


def _time_unit(trajectory: Trajectory) -> tuple[float, str]:
    return scaled_unit("s", trajectory.final_time - float(trajectory.step_time[0]))


def _mark_events(
    events: tuple[EventRecord, ...], tops: list[Axes], below: list[Axes], scale: float, force: float
) -> None:
    """Mark events on the force, and by ticks along the upper border of every panel."""
    for i, kind in enumerate(dict.fromkeys(e.kind for e in events)):
        of_kind = [e for e in events if e.kind == kind]
        look = MARKERS.get(kind, Marker("", "s", 4.0, "white"))
        colour = PALETTE[1 + i % (len(PALETTE) - 1)]
        times = [e.time * scale for e in of_kind]
        label = event_label(kind) + (f" ({len(times)})" if len(times) > 1 else "")
        few = len(times) <= MAX_MARKERS
        marker: dict[str, Any] = {"marker": look.symbol, "markersize": look.size}
        marker |= {"color": colour, "markerfacecolor": colour if look.face != "white" else "none"}
        for axes in tops:
            shown = label if axes is tops[0] else "_"
            if few:
                values = [e.normal_force * force for e in of_kind]
                axes.plot(times, values, linestyle="none", label=shown, zorder=4, **marker)
            else:
                axes.plot([], [], linestyle="none", marker="|", color=colour, label=shown)
        for axes in (*tops, *below):
            axes.vlines(
                times, 0.93, 1.0, colors=colour, linewidth=0.8, transform=axes.get_xaxis_transform()
            )
