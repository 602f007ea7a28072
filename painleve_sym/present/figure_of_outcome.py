"""The figure of an outcome map: lift-off, impact, and the critical forces between them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, MaxNLocator

from painleve_sym.arrays import Array
from painleve_sym.escape import figure_text
from painleve_sym.present.figure_of_map import code_colours, fill_patch, map_frame
from painleve_sym.present.style import (
    DASHES,
    PALETTE,
    REFERENCE,
    STEPS,
    fitted,
    legend_below,
    styled,
)
from painleve_sym.quantities import axis_label, scaled_unit, symbol_latex
from painleve_sym.study.critical.outcome_map import LEGEND, OutcomeMap

# Tints of Okabe & Ito's colours, each of another lightness: distinct in grey too.
FILLS = {
    "undecided": "#FFFFFF",
    "lifts_off": "#A9D5F0",
    "stops_in_restitution": "#F4D58D",
    "stops_in_compression": "#E08A4A",
}
NAMES = {
    "undecided": "not indeterminate, or undecided",
    "lifts_off": "lift-off",
    "stops_in_restitution": "slip stops in restitution",
    "stops_in_compression": "slip stops in compression",
}
LINES: dict[str, tuple[str, dict[str, Any]]] = {
    "slip_stop": ("critical force", {"color": PALETTE[0], "linewidth": 1.3}),
    "predicted": ("closed form", {"color": PALETTE[1], "linewidth": 1.3, "linestyle": DASHES[1]}),
    "limit": ("$F_n^* = -B/A$", {"color": REFERENCE, "linewidth": 1.0, "linestyle": DASHES[3]}),
}
"""The other critical force is the border of the fills."""


@styled
def outcome_figure(outcomes: OutcomeMap, width: float | None = None) -> Figure:
    """Return the figure of an outcome map; its width is in inches, by default that of a map."""
    figure = map_frame(width)
    axes = figure.add_subplot()
    _fill(axes, outcomes)
    handles: dict[str, Any] = {NAMES[n]: fill_patch(FILLS[n]) for n in FILLS if outcomes.counts[n]}
    for name, (label, look) in LINES.items():
        forces = getattr(outcomes, name)
        # 0 stands for no critical force.
        axes.plot(outcomes.values, np.where(forces > 0, forces, np.nan), zorder=3, **look)
        if ((forces > outcomes.forces[0]) & (forces < outcomes.forces[-1])).any():
            handles[label] = Line2D([], [], **look)
    if outcomes.logarithmic:
        axes.set_xscale("log")
    axes.set_xlim(outcomes.values[0], outcomes.values[-1])
    axes.set_ylim(outcomes.forces[0], outcomes.forces[-1])
    factor, unit = 1.0, outcomes.unit
    if not outcomes.logarithmic:
        factor, unit = scaled_unit(unit, float(np.abs(outcomes.values).max()))
        axes.xaxis.set_major_locator(MaxNLocator(6, steps=STEPS))
        axes.xaxis.set_major_formatter(
            FuncFormatter(lambda x, _: f"{x * factor:.6g}".replace("-", "\u2212"))
        )
    axes.set_xlabel(axis_label(symbol_latex(outcomes.over), unit))
    axes.set_ylabel(axis_label("F_{n0}", "N"))
    title = [figure_text(outcomes.mechanism), figure_text(outcomes.law)]
    axes.set_title(fitted(title, float(figure.get_figwidth()) - 0.6))
    legend_below(figure, handles)
    return figure


def _fill(axes: Axes, outcomes: OutcomeMap) -> None:
    """Fill between the critical forces, which were bisected; where runs say otherwise, by runs."""
    borders = _borders(outcomes)
    if borders is None:
        _fill_cells(axes, outcomes)
        return
    stop, compression = borders
    top = np.full_like(stop, outcomes.forces[-1])
    bottom = np.full_like(stop, outcomes.forces[0])
    for name, low, high in (
        ("lifts_off", bottom, stop),
        ("stops_in_restitution", stop, compression),
        ("stops_in_compression", compression, top),
    ):
        look: dict[str, Any] = {"color": FILLS[name], "linewidth": 0, "zorder": 0}
        axes.fill_between(outcomes.values, low, high, where=np.isfinite(outcomes.limit), **look)


def _borders(outcomes: OutcomeMap) -> tuple[Array, Array] | None:
    """Return the forces from which the slip stops, and stops in compression, shape (k,) each.

    Where there is no critical force it is the end of the axis that agrees with the runs. None where
    a run of the grid disagrees with these borders.
    """
    low, high = outcomes.forces[0], outcomes.forces[-1]
    known = np.isfinite(outcomes.limit)
    borders = []
    for values, code in (
        (outcomes.slip_stop, LEGEND["stops_in_restitution"]),
        (outcomes.compression, LEGEND["stops_in_compression"]),
    ):
        # Without a critical force every run of a column ends on one side.
        end = np.where((outcomes.outcome >= code).all(axis=0), low, high)
        borders.append(np.clip(np.where(np.isfinite(values), values, end), low, high))
    stop, compression = borders[0], np.maximum(*borders)
    forces = outcomes.forces[:, None]
    expected = (forces > stop).astype(int) + (forces > compression)
    apart = np.minimum(np.abs(forces - stop), np.abs(forces - compression))
    near = apart < 1e-6 * (high - low)
    agrees = (expected == outcomes.outcome) | near | ~known
    return (stop, compression) if agrees.all() else None


def _fill_cells(axes: Axes, outcomes: OutcomeMap) -> None:
    axes.pcolormesh(
        _edges(outcomes.values, outcomes.logarithmic),
        _edges(outcomes.forces, logarithmic=False),
        outcomes.outcome,
        rasterized=True,
        zorder=0,
        **code_colours(LEGEND, FILLS),
    )


def _edges(values: Array, logarithmic: bool) -> Array:
    """Return the borders of the cells whose middles are the values."""
    v = np.log(values) if logarithmic else values
    inner = (v[1:] + v[:-1]) / 2
    edges = np.concatenate([[2 * v[0] - inner[0]], inner, [2 * v[-1] - inner[-1]]])
    return np.exp(edges) if logarithmic else edges
