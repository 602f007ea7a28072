"""The figure of one motion: forces, coordinates and velocities, with its events marked."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from painleve_sym.arrays import Array
from painleve_sym.checks import checked_number
from painleve_sym.errors import InputError, received
from painleve_sym.escape import figure_text
from painleve_sym.motion.records import EventRecord
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.present.style import (
    CONTACTS,
    DASHES,
    MARKERS,
    NARROW,
    NORMAL,
    PAGE,
    PALETTE,
    STEPS,
    TALLEST,
    TANGENTIAL,
    TICKS,
    Marker,
    event_label,
    fitted,
    legend_below,
    legend_entries,
    show_above_rounding,
    styled,
)
from painleve_sym.quantities import axis_label, counted, scaled_unit, text_label

MAX_POINTS = 20_000
"""Maximum number of plotted points."""
SMOOTH = 600
"""Points over the motion, besides those of its steps: a step of a parabola may be the motion."""
MAX_MARKERS = 12
"""More events of a kind than this hide the curve; they are then ticks above the forces only."""
MAGNIFIED = 0.1
"""Part of the motion: what happens all within less has panels with a magnified time."""

_FORCES = {
    "normal_force": ("F_n", NORMAL, DASHES[0]),
    "tangential_force": ("F_t", TANGENTIAL, DASHES[1]),
}
_SYMBOLS = "sPX*hdp<"
"""Of events that have no mark of their own."""


@dataclass(frozen=True)
class _Panel:
    """Forces that share a panel: (contact, output) pairs, and the latex of their axis or ""."""

    curves: tuple[tuple[int, str], ...]
    latex: str = ""


@dataclass(frozen=True)
class _Curves:
    """Curves of a motion that are drawn: times in s, forces in N."""

    run: Trajectory

    @cached_property
    def times(self) -> Array:
        """Times of the curves, also just before each event, since forces may jump there."""
        return drawn_times(self.run)

    @cached_property
    def states(self) -> dict[str, Array]:
        """Coordinates and velocities in turn, by name."""
        names = self.run.state_names
        values = self.run(self.times)
        coordinates = [n for n in self.run.names.units if n in names and f"{n}_dot" in names]
        listed = [name for c in coordinates for name in (c, f"{c}_dot")]
        return {name: values[:, names.index(name)] for name in listed}

    @cached_property
    def forces(self) -> dict[tuple[int, str], Array]:
        """Forces by number of the contact and name."""
        outputs, names = self.run.outputs(self.times), self.run.names
        pairs = ((k, c, f) for k, c in enumerate(names.contacts) for f in _FORCES)
        forces = {(k, f): outputs[names.of_contact(f, c)] for k, c, f in pairs}
        return {key: self._without_many_jumps(values) for key, values in forces.items()}

    def _without_many_jumps(self, values: Array) -> Array:
        """Return a force with nan just before its jumps where their lines would fill the panel."""
        at = np.unique(np.searchsorted(self.times, [e.time for e in self.run.events]))
        at = at[(at > 0) & (at < len(values))]
        size = np.abs(values[at] - values[at - 1])
        jumps = at[size > 0.05 * float(np.nanmax(np.abs(values)) or 1.0)]
        if len(jumps) <= MAX_MARKERS:
            return values
        broken = values.copy()
        broken[jumps - 1] = np.nan
        return broken

    @cached_property
    def events(self) -> dict[str, list[EventRecord]]:
        """Events by kind above the tolerance, without those that only choose among solutions."""
        shown = [e for e in self.run.events_above_tolerance if e.kind != "contact"]
        kinds = dict.fromkeys(str(e.kind) for e in shown)
        return {kind: [e for e in shown if e.kind == kind] for kind in kinds}

    @property
    def panels(self) -> list[_Panel]:
        """One panel with both forces of one contact, or one for each force of several."""
        if len(self.run.names.contacts) == 1:
            return [_Panel(tuple(self.forces))]
        return [
            _Panel(tuple(key for key in self.forces if key[1] == name), latex)
            for name, (latex, *_) in _FORCES.items()
        ]

    @cached_property
    def unit_of_time(self) -> tuple[float, str]:
        """Factor and unit of the axes of time."""
        return scaled_unit("s", self.run.final_time - float(self.run.step_time[0]))

    @cached_property
    def unit_of_force(self) -> tuple[float, str]:
        """Factor and unit of the axes of force."""
        largest = max(float(np.nanmax(np.abs(f))) for f in self.forces.values())
        return scaled_unit("N", largest)

    @cached_property
    def window(self) -> tuple[float, float] | None:
        """Time about all events and the largest force; None where that is not a short time; s."""
        start, end = float(self.times[0]), float(self.times[-1])
        if not self.events:
            return None
        normal = np.max([f for (_, name), f in self.forces.items() if name == "normal_force"], 0)
        largest = float(self.times[int(np.nanargmax(normal))])
        moments = [largest, *(e.time for kind in self.events.values() for e in kind)]
        length = max(moments) - min(moments)
        if not 0 < length < MAGNIFIED * (end - start):
            return None
        return max(start, min(moments) - 0.4 * length), min(end, max(moments) + 0.4 * length)


def drawn_times(run: Trajectory) -> Array:
    """Return times of curves of a motion, also just before each event, since forces may jump."""
    before = [np.nextafter(e.time, -np.inf) for e in run.events]
    even = np.linspace(run.step_time[0], run.final_time, SMOOTH)
    times = np.unique(np.concatenate([run.fine_times(), before, even]))
    times = times[times >= run.step_time[0]]
    kept = np.linspace(0, len(times) - 1, min(len(times), MAX_POINTS)).round().astype(int)
    drawn: Array = times[kept]
    return drawn


def refuse_unmoved(trajectory: Trajectory) -> None:
    """Raise InputError where a trajectory holds no steps."""
    if not len(trajectory.step_time):
        why = f"the run ended at its start ({trajectory.stop_reason.label})"
        raise InputError(
            f"figure: {why}: there is no motion to draw. Fix: start elsewhere."
            if trajectory.ended_at_start
            else "figure: the trajectory holds no steps. Fix: simulate with record='dense'."
        )


def trajectory_figure(trajectory: Trajectory, width: float | None = None) -> Figure:
    """Return a figure of the forces, every coordinate and every velocity over time.

    The width is in inches, by default that of a page. What the tolerance of the run does not
    resolve is drawn as 0, and its events are counted in the legend alone.
    InputError where the trajectory holds no steps.
    """
    if width is not None and checked_number(width, "width", above=0.0)[1]:
        raise InputError(
            f"trajectory figure: width: got {received(width)}, need a number > 0 of inches. "
            "Fix: to write a file, plot().savefig(...)."
        )
    refuse_unmoved(trajectory)
    return _figure(_Curves(trajectory), PAGE if width is None else width)


@styled
def _figure(motion: _Curves, width: float) -> Figure:
    narrow = width < NARROW
    window = motion.window
    pairs = len(motion.states) // 2
    figure = Figure(layout="constrained")
    rows = _force_rows(motion.panels, window is not None, narrow)
    high, low = (1.3, 0.95) if narrow else (1.6, 1.25)
    fits = min(1.0, TALLEST / (len(rows) * high + pairs * low))
    figure.set_size_inches(width, (len(rows) * high + pairs * low) * fits + 0.5)
    grid = figure.add_gridspec(
        len(rows) + pairs, 2, height_ratios=[high] * len(rows) + [low] * pairs
    )
    tops: list[Axes] = []
    for i, row in enumerate(rows):
        for k, (panel, near) in enumerate(row):
            axes = figure.add_subplot(grid[i, k] if len(row) > 1 else grid[i, :])
            _draw_forces(axes, motion, panel, window if near else None)
            tops.append(axes)
    below: list[Axes] = []
    for i in range(2 * pairs):
        place = grid[len(rows) + i // 2, i % 2]
        below.append(figure.add_subplot(place, sharex=below[0] if below else None))
    below[0].xaxis.set_major_locator(MaxNLocator(3 if narrow else 6, steps=STEPS))
    _draw_states(below, motion)
    run = motion.run
    choices = [f"{key.replace('_', ' ')} {value}" for key, value in run.choices.items()]
    title = [figure_text(run.mechanism), figure_text(run.law), *choices]
    tops[0].set_title(fitted(title, width / len(rows[0]) - 0.7))
    legend_below(figure, legend_entries(tops))
    return figure


def _force_rows(
    panels: list[_Panel], magnified: bool, narrow: bool
) -> list[list[tuple[_Panel, bool]]]:
    """Return the rows of panels of forces, each with whether its time is magnified."""
    times = (False, True) if magnified else (False,)
    if narrow:
        return [[(p, near)] for p in panels for near in times]
    if len(panels) == 1:
        return [[(panels[0], near) for near in times]]
    return [[(p, near) for p in panels] for near in times]


def _draw_forces(
    axes: Axes, motion: _Curves, panel: _Panel, window: tuple[float, float] | None
) -> None:
    """Draw the forces of a panel over the motion, or over a window of magnified time; s."""
    scale, unit = motion.unit_of_time
    start, end = float(motion.times[0]), float(motion.times[-1])
    if window is not None:
        scale, unit = scaled_unit("s", max(map(abs, window)))
        times = (end - start) / (window[1] - window[0])
        axes.set_xlim(window[0] * scale, window[1] * scale)
        axes.set_title(f"time magnified {times:,.0f} times")
    factor, force_unit = motion.unit_of_force
    contacts = motion.run.names.contacts
    for k, name in panel.curves:
        latex, colour, dashes = _FORCES[name]
        label = f"${latex}$"
        if panel.latex:
            label = figure_text(contacts[k])
            colour, dashes = CONTACTS[k % len(CONTACTS)], DASHES[k % len(DASHES)]
        values = motion.forces[k, name] * factor
        axes.plot(motion.times * scale, values, label=label, color=colour, linestyle=dashes)
    label = f"${panel.latex}$" if panel.latex else "force"
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=STEPS))
    axes.set_ylabel(text_label(label, force_unit))
    axes.set_xlabel(text_label("time", unit))
    _mark_events(axes, motion, scale, panel.latex != _FORCES["tangential_force"][0])


def _draw_states(below: list[Axes], motion: _Curves) -> None:
    scale, unit = motion.unit_of_time
    names = motion.run.names
    for axes, (name, values) in zip(below, motion.states.items(), strict=True):
        size = motion.run.size(name)
        largest, least = float(np.max(np.abs(values))), motion.run.tolerance(name)
        factor, own = scaled_unit(names.units[name], largest if largest > least else size)
        axes.plot(motion.times * scale, values * factor, color=PALETTE[0])
        axes.set_ylabel(axis_label(names.latex[name], own))
        axes.yaxis.set_major_locator(MaxNLocator(4, steps=STEPS))
        few = [events for events in motion.events.values() if len(events) <= MAX_MARKERS]
        _tick(axes, [e.time * scale for events in few for e in events])
        axes.tick_params(labelbottom=axes in below[-2:])
        show_above_rounding(axes, size * factor, least * factor)
    for axes in below[-2:]:
        axes.set_xlabel(text_label("time", unit))


def _mark_events(axes: Axes, motion: _Curves, scale: float, normal: bool) -> None:
    """Mark events by ticks along the upper border, and on the normal force of the panel."""
    factor, _ = motion.unit_of_force
    colours, symbols = itertools.cycle(TICKS), itertools.cycle(_SYMBOLS)
    for kind, events in motion.events.items():
        label = event_label(kind) + (f" ({len(events)})" if len(events) > 1 else "")
        few = len(events) <= MAX_MARKERS
        look = MARKERS.get(kind) or Marker("", next(symbols), 4.6, "white")
        if few and normal:
            style: dict[str, Any] = {"marker": look.symbol, "markersize": look.size}
            style |= {"markerfacecolor": look.face, "markeredgewidth": 0.7, "color": "black"}
            places = [(e.time * scale, e.normal_force * factor) for e in events]
            axes.plot(*zip(*places, strict=True), linestyle="none", zorder=4, label=label, **style)
        colour = "black" if few else next(colours)
        if not few:
            axes.plot([], [], linestyle="none", marker="|", color=colour, label=label)
        _tick(axes, [e.time * scale for e in events], colour)
    if folded := len(motion.run.events) - len(motion.run.events_above_tolerance):
        label = f"{counted(folded, 'event')} below the tolerance"
        axes.plot([], [], linestyle="none", label=label)


def _tick(axes: Axes, times: Sequence[float], colour: str = "black") -> None:
    """Draw ticks along the upper border, which has no others, and leave them room."""
    axes.vlines(times, 0.93, 1, colors=colour, linewidth=0.7, transform=axes.get_xaxis_transform())
    axes.tick_params(top=False)
    axes.margins(y=0.1)
