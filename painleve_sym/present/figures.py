"""From the panels of an item to a figure."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from matplotlib.ticker import MaxNLocator

from painleve_sym.errors import InputError
from painleve_sym.papers.panels import Axis, Curve, Panel
from painleve_sym.present.style import (
    ADMISSIBLE,
    COLUMN,
    DASHES,
    MARKERS,
    PAGE,
    PALETTE,
    REFERENCE,
    STYLE,
    log_ticks,
)
from painleve_sym.quantities import text_label

# Rows, columns, width and height of one row in inches, by the number of panels.
_LAYOUT = {
    1: (1, 1, COLUMN, 2.35),
    2: (1, 2, PAGE, 2.5),
    3: (1, 3, PAGE, 2.1),
    4: (2, 2, PAGE, 1.95),
    5: (2, 3, PAGE, 1.95),
    6: (2, 3, PAGE, 1.95),
}
_LEGEND_ROW = 0.17
HIDDEN = 0.03
"""Part of the abscissa: marks closer than this hide each other and are shown in an inset."""


def draw(panels: Sequence[Panel]) -> Figure:
    """Return a figure of one to six panels, lettered, with one legend below them."""
    if len(panels) not in _LAYOUT:
        raise InputError(f"figure: panels: got {len(panels)}, need 1 to {max(_LAYOUT)}.")
    rows, columns, width, height = _LAYOUT[len(panels)]
    with matplotlib.rc_context(STYLE):
        figure = Figure(layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        for letter, axes, panel in zip("abcdef", grid, panels, strict=False):
            _draw_panel(axes, panel, f"({letter})" if len(panels) > 1 else "")
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        entries = _legend_entries(grid)
        lines = _legend_rows(entries.keys(), width)
        figure.set_size_inches(width, rows * height + _LEGEND_ROW * len(lines))
        if entries:
            names = [name for line in _by_column(lines) for name in line]
            handles = [entries[name] for name in names]
            figure.legend(handles, names, loc="outside lower center", ncols=len(lines[0]))
    return figure


def _draw_panel(axes: Axes, panel: Panel, letter: str) -> None:
    index = 0
    for curve in panel.curves:
        x, y = curve.x * panel.x.factor, curve.y * panel.y.factor
        axes.plot(x, y, label=curve.label or "_", **_look(curve, index))
        index += curve.role in ("line", "points")
    _draw_marks(axes, panel)
    diagram = any(curve.role == "admissible" for curve in panel.curves)
    if diagram:
        axes.axhline(0, color=REFERENCE, linewidth=0.5, zorder=0)
        axes.axvline(0, color=REFERENCE, linewidth=0.5, zorder=0)
    _scale(axes.xaxis, panel.x, axes.set_xscale, axes.set_xlim)
    _scale(axes.yaxis, panel.y, axes.set_yscale, axes.set_ylim)
    axes.set_xlabel(text_label(panel.x.label, panel.x.unit))
    axes.set_ylabel(text_label(panel.y.label, panel.y.unit))
    axes.set_title(" ".join(part for part in (letter, panel.title) if part))
    _draw_inset(axes, panel)
    if panel.note:
        axes.text(0.95, 0.93, panel.note, transform=axes.transAxes, ha="right", va="top")


def _look(curve: Curve, index: int) -> dict[str, Any]:
    if curve.role == "reference":
        return {"color": REFERENCE, "linewidth": 0.9, "linestyle": (0, (3, 2)), "zorder": 1.5}
    if curve.role == "admissible":
        return {
            "color": ADMISSIBLE,
            "linewidth": 4.0,
            "alpha": 0.6,
            "zorder": 1,
            "solid_joinstyle": "miter",
        }
    style = index % len(PALETTE)
    look: dict[str, Any] = {"color": PALETTE[style], "linestyle": DASHES[style]}
    if curve.role == "points":
        look |= {"marker": "osD^v"[style], "markersize": 3.2}
    return look


def _draw_marks(axes: Axes, panel: Panel) -> None:
    for kind in dict.fromkeys(mark.kind for mark in panel.marks):
        chosen = [mark for mark in panel.marks if mark.kind == kind]
        look = MARKERS[kind]
        axes.plot(
            [mark.x * panel.x.factor for mark in chosen],
            [mark.y * panel.y.factor for mark in chosen],
            linestyle="none",
            marker=look.symbol,
            markersize=look.size,
            markerfacecolor=look.face,
            markeredgecolor="black",
            markeredgewidth=0.7,
            label=look.name,
            zorder=5 if look.face == "black" else 4,
            clip_on=False,
        )


def _draw_inset(axes: Axes, panel: Panel) -> None:
    """Magnify the abscissa where marks of different kinds on the only curve hide each other."""
    if len(panel.curves) != 1 or panel.x.log or panel.y.log:
        return
    (curve,) = panel.curves
    x, y = curve.x * panel.x.factor, curve.y * panel.y.factor
    low, high = axes.get_xlim()
    places = sorted((m.x * panel.x.factor, m.kind) for m in panel.marks)
    close = [
        (a, b)
        for (a, kind), (b, other) in itertools.pairwise(places)
        if kind != other and 0 < b - a < HIDDEN * (high - low)
    ]
    if len(close) != 1 or (np.diff(x) < 0).any():
        return
    ((first, second),) = close
    window = (first - 1.2 * (second - first), second + 1.2 * (second - first))
    within = (x >= window[0]) & (x <= window[1])
    if within.sum() < 4:
        return
    bottom, top = axes.get_ylim()
    left = y[x < (low + high) / 2]
    above = bool(left.size and np.mean(left) < (bottom + top) / 2)
    inset = axes.inset_axes((0.16, 0.5 if above else 0.12, 0.42, 0.38))
    inset.plot(x[within], y[within], color=PALETTE[0], linewidth=0.9)
    _draw_marks(inset, panel)
    spread = float(np.ptp(y[within])) or 1.0
    inset.set_xlim(window)
    inset.set_ylim(y[within].min() - 0.25 * spread, y[within].max() + 0.25 * spread)
    inset.set_xticks([first, second], [f"{first:.3g}", f"{second:.3g}"])
    inset.set_yticks([])
    inset.tick_params(labelsize=5.5, length=2, pad=1.5, top=False)
    for artist in inset.lines:
        artist.set_clip_on(True)


def _scale(ticks: Any, axis: Axis, set_scale: Any, set_limits: Any) -> None:
    if axis.log:
        set_scale("log")
        log_ticks(ticks)
    else:
        ticks.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))
    if axis.limits is not None:
        set_limits(*axis.limits)


def _legend_entries(grid: Iterable[Axes]) -> dict[str, Any]:
    entries: dict[str, Any] = {}
    for axes in grid:
        handles, names = axes.get_legend_handles_labels()
        for handle, name in zip(handles, names, strict=True):
            entries.setdefault(name, handle)
    return entries


def _legend_rows(names: Iterable[str], width: float) -> list[list[str]]:
    """Divide the names into equal rows that fit the width."""
    listed = list(names)
    if not listed:
        return []
    # The widest text with the handle, gap and column spacing of the legend.
    size = max(_text_width(name) for name in listed) + 0.58
    columns = max(1, min(len(listed), int(width / size)))
    rows = -(-len(listed) // columns)
    columns = -(-len(listed) // rows)
    return [listed[i : i + columns] for i in range(0, len(listed), columns)]


def _text_width(text: str) -> float:
    """Return the width of a legend's text in inches."""
    font = FontProperties(family=STYLE["font.family"], size=STYLE["legend.fontsize"])
    return float(TextPath((0, 0), text, prop=font).get_extents().width) / 72


def _by_column(rows: list[list[str]]) -> list[list[str]]:
    """Return the rows as columns, since legends are filled column by column."""
    if not rows:
        return []
    return [[row[i] for row in rows if i < len(row)] for i in range(len(rows[0]))]
