"""The figure of one motion: forces, coordinates and velocities, with its events marked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from painleve_sym.codegen.run import Array
from painleve_sym.errors import InputError
from painleve_sym.mechanics.models import Mechanism
from painleve_sym.simulate.trajectory import Trajectory, write_beside

SUFFIXES = (".png", ".svg", ".pdf")
MAX_POINTS = 20_000
"""More points than this no screen can show."""
MAX_LINES = 60
"""More lines than this hide the curves; the events are then marked on the force only."""

# Colour-blind safe (Okabe & Ito), one per kind of event in the order in which they appear.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_FORCES = {"normal_force": ("$F_n$", "#000000"), "tangential_force": ("$F_t$", "#999999")}


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
        raise InputError("figure: the trajectory holds no steps. Fix: plot one that went on.")
    times = _times(trajectory)
    scale, unit = _time_unit(trajectory.final_time - float(trajectory.step_time[0]))
    coordinates = mechanism.system.coordinates
    figure = Figure(figsize=(9.0, 2.4 + 1.7 * len(coordinates)), layout="constrained")
    grid = figure.add_gridspec(len(coordinates) + 1, 2)
    top = figure.add_subplot(grid[0, :])
    outputs = trajectory.outputs(times)
    for name, (label, colour) in _FORCES.items():
        top.plot(times * scale, outputs[name], color=colour, label=label, linewidth=1.2)
    top.set_ylabel("force [N]")
    states = trajectory(times)
    axes = [top]
    for row, c in enumerate(coordinates, 1):
        for column, name, label, si in (
            (0, c.name, c.latex or c.name, c.unit),
            (1, f"{c.name}_dot", _rate(c.latex or c.name), f"{c.unit}/s"),
        ):
            ax = figure.add_subplot(grid[row, column], sharex=top)
            values = states[:, trajectory.state_names.index(name)]
            ax.plot(times * scale, values, color="#000000", linewidth=1.2)
            ax.set_ylabel(f"${label}$ [{si}]")
            ax.ticklabel_format(axis="y", useOffset=False)
            axes.append(ax)
    for ax in axes[-2:]:
        ax.set_xlabel(f"time [{unit}]")
    _mark_events(trajectory, axes, scale)
    law = trajectory.law + "".join(f" ({k} {v})" for k, v in trajectory.choices.items())
    figure.suptitle(f"{trajectory.mechanism} with {law}", fontsize=11)
    return figure


def write_trajectory_plot(trajectory: Trajectory, path: str | Path, mechanism: Mechanism) -> None:
    """Write the figure as PNG, SVG or PDF, as the suffix says: whole, or not at all.

    Raises
    ------
    InputError
        Another suffix, a folder that cannot be written, a trajectory without steps.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"figure {path}: got {suffix!r}, need one of {', '.join(SUFFIXES)}.")
    figure = trajectory_figure(trajectory, mechanism)
    # Neither the date nor random names: the same motion gives the same file.
    metadata: dict[str, Any] = {"Date": None} if suffix == ".svg" else {}
    if suffix == ".pdf":
        metadata = {"CreationDate": None}
    with rc_context({"svg.hashsalt": "painleve-sym"}):
        write_beside(
            path, lambda f: figure.savefig(f, format=suffix[1:], dpi=150, metadata=metadata)
        )


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


def _rate(latex: str) -> str:
    base, _, index = latex.partition("_")
    return rf"\dot{{{base}}}" + (f"_{index}" if index else "")


def _mark_events(trajectory: Trajectory, axes: list[Axes], scale: float) -> None:
    kinds = list(dict.fromkeys(e.kind for e in trajectory.events))
    colours: Mapping[str, str] = {k: _COLOURS[i % len(_COLOURS)] for i, k in enumerate(kinds)}
    events = trajectory.events
    for kind in kinds:
        of_kind = [e for e in events if e.kind == kind]
        label = kind.replace("_", " ") + (f" ({len(of_kind)})" if len(of_kind) > 1 else "")
        axes[0].plot(
            [e.time * scale for e in of_kind],
            [e.normal_force for e in of_kind],
            linestyle="none",
            marker="o",
            markersize=4,
            color=colours[kind],
            label=label,
        )
    if len(events) <= MAX_LINES:
        for ax in axes:
            for e in events:
                ax.axvline(e.time * scale, color=colours[e.kind], linewidth=0.8, alpha=0.5)
    axes[0].legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
