"""From the panels of an item to a figure."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from painleve_sym.errors import InputError
from painleve_sym.papers.panels import Axis, Curve, Panel
from painleve_sym.present.style import (
    ADMISSIBLE,
    COLUMN,
    DASHES,
    LEGEND_ROW,
    MARKERS,
    PAGE,
    PALETTE,
    REFERENCE,
    STEPS,
    TALLEST,
    legend_below,
    legend_entries,
    log_ticks,
    panel_grid,
    styled,
)
from painleve_sym.quantities import text_label

MAX_PANELS = 6
_HEIGHTS = {1: 2.35, 2: 2.5, 3: 2.1}
"""Height of a panel by their number; inch."""
HIDDEN = 0.03
"""Part of the abscissa: marks closer than this hide each other and are shown in an inset."""


@styled
def draw(panels: Sequence[Panel], width: float | None = None) -> Figure:
    """Return a figure of one to six panels, lettered, with one legend below them.

    The width is in inches: by default that of a column for one panel, of a page for several.
    """
    count = len(panels)
    if not 1 <= count <= MAX_PANELS:
        raise InputError(f"figure: panels: got {count}, need 1 to {MAX_PANELS}.")
    own = COLUMN if count == 1 else PAGE
    figure, grid = panel_grid(count, width, _HEIGHTS.get(count, 1.95), own)
    for letter, axes, panel in zip("abcdef", grid, panels, strict=False):
        _draw_panel(axes, panel, f"({letter})" if count > 1 else "")
    if _looks_have_one_meaning(panels):
        legend_below(figure, legend_entries(grid))
        return figure
    rows = max(len(legend_entries([axes])) for axes in grid)
    below = len({axes.get_position().y0 for axes in grid})
    wide, high = figure.get_size_inches()
    figure.set_size_inches(wide, min(high + below * rows * LEGEND_ROW, TALLEST))
    for axes in grid:
        axes.legend(loc="upper left", bbox_to_anchor=(0, -0.24), borderaxespad=0)
    return figure


def _looks_have_one_meaning(panels: Sequence[Panel]) -> bool:
    """Return whether lines that look the same have one name in all panels."""
    names: dict[tuple[str, int], str] = {}
    for panel in panels:
        lines = [curve for curve in panel.curves if curve.role in ("line", "points")]
        others = [curve for curve in panel.curves if curve.role not in ("line", "points")]
        for curves in (lines, others):
            for i, curve in enumerate(curves):
                look = ("line", i) if curves is lines else (curve.role, 0)
                if curve.label and names.setdefault(look, curve.label) != curve.label:
                    return False
    return True


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
        ticks.set_major_locator(MaxNLocator(5, steps=STEPS))
    if axis.limits is not None:
        set_limits(*axis.limits)
