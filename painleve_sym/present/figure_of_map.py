"""The figure of a map: regions, the curves A = 0 and B = 0, their crossings, the flow of slip."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator, MultipleLocator

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError, received
from painleve_sym.escape import figure_text
from painleve_sym.present.fonts import is_foreign
from painleve_sym.present.style import (
    DASHES,
    PALETTE,
    REFERENCE,
    STEPS,
    fitted,
    legend_below,
    styled,
    value_text,
)
from painleve_sym.problem.case_codes import LEGEND
from painleve_sym.quantities import axis_label, symbol_latex
from painleve_sym.study.maps.region_map import RegionMap

# Tints of Okabe & Ito's colours, each of another lightness: distinct in grey too.
FILLS = {
    "outside": "#FFFFFF",
    "slip": "#E6F0F7",
    "liftoff": "#A9D5F0",
    "inconsistent": "#E08A4A",
    "indeterminate": "#F4D58D",
}
NAMES = {
    "outside": "outside the domain",
    "slip": "slip",
    "liftoff": "lift-off",
    "inconsistent": "inconsistent: no solution",
    "indeterminate": "indeterminate: several",
}
FLOW = "#6E7780"
LOOKS: dict[str, dict[str, Any]] = {
    "A": {"colors": PALETTE[0], "linestyles": "solid", "linewidths": 1.2},
    "B": {"colors": PALETTE[1], "linestyles": [DASHES[1]], "linewidths": 1.2},
    "A_pull": {"colors": PALETTE[2], "linestyles": [DASHES[2]], "linewidths": 1.2},
}
CROSSING: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": 4.6,
    "markerfacecolor": "white",
    "markeredgecolor": "black",
}
WIDTH, HEIGHT = 4.2, 3.25
"""Between one column and the page; inch."""
FLOW_GRID = 120
"""Points along an axis of the flow: finer ones do not show."""


def map_figure(regions: RegionMap, width: float | None = None, ax: Any = None) -> Figure:
    """Return the figure of a map; its width is in inches, by default between column and page.

    Where axes are given it is drawn in these.
    """
    if ax is None:
        return _own_figure(regions, width)
    if not isinstance(ax, Axes) or width is not None:
        raise InputError(
            f"map figure: got ax = {received(ax)}, width = {width!r}, need axes of Matplotlib "
            "alone. Fix: figure, ax = matplotlib.pyplot.subplots()."
        )
    _draw(ax, regions)
    ax.set_title(", ".join([figure_text(regions.mechanism), *_held(regions)]))
    entries = _legend(regions)
    ax.legend(entries.values(), entries.keys())
    figure = ax.get_figure(root=True)
    assert isinstance(figure, Figure)
    return figure


def _draw(axes: Axes, regions: RegionMap) -> None:
    """Draw regions, flow, curves and thresholds."""
    _fill(axes, regions)
    if _flows(regions):
        _draw_flow(axes, regions)
    _draw_curves(axes, regions)
    if len(regions.crossings):
        axes.plot(*regions.crossings.T, markeredgewidth=0.9, zorder=5, **CROSSING)
    _draw_thresholds(axes, regions)
    _label(axes, regions)


@styled
def _own_figure(regions: RegionMap, width: float | None) -> Figure:
    figure = map_frame(width)
    axes = figure.add_subplot()
    _draw(axes, regions)
    name, held = figure_text(regions.mechanism), _held(regions)
    if is_foreign(name):
        # Text with formulas has one font alone.
        axes.set_title(name, loc="right")
    else:
        held = [name, *held]
    axes.set_title(fitted(held, float(figure.get_figwidth()) - 0.6))
    legend_below(figure, _legend(regions))
    return figure


def map_frame(width: float | None) -> Figure:
    """Return an empty figure for a map, whose legend comes below it."""
    wide = WIDTH if width is None else width
    return Figure(figsize=(wide, HEIGHT * wide / WIDTH), layout="constrained")


def code_colours(codes: Mapping[str, int], fills: Mapping[str, str]) -> dict[str, Any]:
    """Return colour map and norm that give each code the fill of its name."""
    names = sorted(codes, key=codes.__getitem__)
    borders = [codes[name] - 0.5 for name in names] + [codes[names[-1]] + 0.5]
    colours = ListedColormap([fills[name] for name in names])
    return {"cmap": colours, "norm": BoundaryNorm(borders, len(names))}


def fill_patch(fill: str) -> Patch:
    """Return the handle of a fill in a legend."""
    return Patch(facecolor=fill, edgecolor="black", linewidth=0.4)


def _fill(axes: Axes, regions: RegionMap) -> None:
    x, y = regions.values
    axes.imshow(
        regions.case.T,
        origin="lower",
        aspect="auto",
        interpolation="nearest",
        extent=(*_ends(x), *_ends(y)),
        zorder=0,
        **code_colours(LEGEND, FILLS),
    )
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(y[0], y[-1])


def _ends(values: Array) -> tuple[float, float]:
    """Return the borders of the pixels whose middles are the values."""
    half = (values[1] - values[0]) / 2
    return float(values[0] - half), float(values[-1] + half)


def _flows(regions: RegionMap) -> bool:
    """Return whether anything flows: with both velocities held at 0 nothing does."""
    return regions.flow is not None and bool((np.nan_to_num(regions.flow) != 0).any())


def _draw_flow(axes: Axes, regions: RegionMap) -> None:
    assert regions.flow is not None
    every = [max(1, len(v) // FLOW_GRID) for v in regions.values]
    u, v = regions.flow[:, :: every[0], :: every[1]]
    # streamplot wants evenly spaced numbers exactly; it follows a direction, speed plays no part.
    thinned = [w[::step] for w, step in zip(regions.values, every, strict=True)]
    x, y = (np.linspace(w[0], w[-1], len(w)) for w in thinned)
    span = [float(w[-1] - w[0]) for w in (x, y)]
    size = np.hypot(u / span[0], v / span[1])
    with np.errstate(all="ignore"):
        u, v = (np.ma.masked_invalid(w / size) for w in (u, v))
    axes.streamplot(
        x,
        y,
        u.T,
        v.T,
        color=FLOW,
        linewidth=0.45,
        arrowsize=0.55,
        density=(1.2, 1.05),
        minlength=0.08,
        zorder=1.5,
    )


def _draw_curves(axes: Axes, regions: RegionMap) -> None:
    for name, pieces in regions.curves.items():
        if len(pieces):
            axes.add_collection(
                LineCollection(_joined(pieces), zorder=3, capstyle="round", **LOOKS[name]),
                autolim=False,
            )


def _joined(pieces: Array) -> list[Array]:
    """Join the pieces that share an end into lines, so that dashes continue."""
    ends: dict[tuple[float, ...], list[int]] = {}
    for i, piece in enumerate(pieces):
        for end in piece:
            ends.setdefault(tuple(end), []).append(i)
    left = set(range(len(pieces)))
    lines = []
    # Open lines are followed from their ends; what then remains is closed.
    loose = [i for i, piece in enumerate(pieces) if any(len(ends[tuple(e)]) == 1 for e in piece)]
    for start in (*loose, *range(len(pieces))):
        if start not in left:
            continue
        left.remove(start)
        a, b = (tuple(e) for e in pieces[start])
        line = [b, a] if len(ends[b]) == 1 else [a, b]
        while True:
            following = [i for i in ends[line[-1]] if i in left]
            if not following:
                break
            left.remove(following[0])
            a, b = (tuple(e) for e in pieces[following[0]])
            line.append(b if a == line[-1] else a)
        lines.append(np.array(line))
    return lines


def _draw_thresholds(axes: Axes, regions: RegionMap) -> None:
    """Mark the thresholds of friction where it is an axis."""
    if "mu" not in regions.over:
        return
    place = regions.over.index("mu")
    values = regions.values[place]
    for name, value in regions.thresholds.items():
        if name not in ("mu_P", "mu_C") or not values[0] < value < values[-1]:
            continue
        draw = axes.axvline if place == 0 else axes.axhline
        draw(value, color=REFERENCE, linewidth=0.8, linestyle=(0, (3, 2)), zorder=2.5)
        at = (value, 0.98) if place == 0 else (0.99, value)
        axes.text(
            *at,
            rf"$\{name}$",
            transform=axes.get_xaxis_transform() if place == 0 else axes.get_yaxis_transform(),
            ha="right",
            va="top" if place == 0 else "bottom",
            zorder=6,
        )


def _label(axes: Axes, regions: RegionMap) -> None:
    for i, (ticks, label, unit) in enumerate(
        zip((axes.xaxis, axes.yaxis), regions.labels, regions.units, strict=True)
    ):
        span = float(regions.values[i][-1] - regions.values[i][0])
        if unit == "rad" and span > 0.9 * math.pi:
            ticks.set_major_locator(MultipleLocator(math.pi / (4 if span < 1.1 * math.pi else 2)))
            ticks.set_major_formatter(FuncFormatter(_in_pi))
        else:
            ticks.set_major_locator(MaxNLocator(6, steps=STEPS))
        ticks.set_label_text(axis_label(label, unit))
    for name, pieces in regions.curves.items():
        if len(pieces):
            _name_curve(axes, regions, name, pieces)


def _held(regions: RegionMap) -> list[str]:
    """Return the direction of slip, and the values that are held, with their units."""
    sign = "<" if regions.slip < 0 else ">"
    parts = [f"$v_t {sign} 0$"]
    if regions.in_space:
        parts = [value_text("slip_direction", regions.slip, "rad")]
        parts = parts if "slip_direction" not in regions.over else []
    if "mu" in regions.parameters:
        parts.append(value_text("mu", regions.parameters["mu"], "1"))
    solved = [part.rpartition(":")[2] for part in regions.close.split(",") if part]
    for name, value in regions.state.items():
        if value != 0 and name not in solved:
            parts.append(value_text(name, value, regions.state_units[name]))
    if solved:
        names = " and ".join(f"${symbol_latex(name)}$" for name in solved)
        parts.append(f"{names} close{'s' * (len(solved) == 1)} the contact")
    return parts


def _in_pi(value: float, _position: int | None = None) -> str:
    quarters = round(4 * value / math.pi)
    if quarters == 0:
        return "$0$"
    divisor = math.gcd(quarters, 4)
    above, below = abs(quarters) // divisor, 4 // divisor
    text = (f"{above}" if above > 1 else "") + r"\pi" + (f"/{below}" if below > 1 else "")
    return f"${'-' if quarters < 0 else ''}{text}$"


def _name_curve(axes: Axes, regions: RegionMap, name: str, pieces: Array) -> None:
    """Write A = 0 or B = 0 onto the curve, far from borders, crossings and the other curve."""
    low = np.array([v[0] for v in regions.values])
    span = np.array([v[-1] for v in regions.values]) - low
    places = (pieces.mean(axis=1) - low) / span
    others = [regions.curves[k].mean(axis=1) for k in regions.curves if k != name]
    marks = np.concatenate([regions.crossings, *others])
    inside = np.minimum(places, 1 - places).min(axis=1)
    room = 2 * inside
    if len(marks):
        gaps = np.array([np.hypot(*((marks - low) / span - p).T).min() for p in places])
        room = np.minimum(room, gaps)
    # The words are about twice as long as this.
    room[inside < 0.1] *= 0.1
    best = pieces[int(np.argmax(room))]
    x, y = best.mean(axis=0)
    right, up = best[1] - best[0]
    # Along the curve, and read from left to right or from below.
    angle = math.degrees(math.atan2(up, right)) if right else 90.0
    angle -= 180.0 * math.copysign(1.0, angle) if abs(angle) > 90 else 0.0
    text = axes.text(
        x,
        y,
        r"$A_\mathrm{pull} = 0$" if name == "A_pull" else f"${name} = 0$",
        rotation=angle,
        rotation_mode="anchor",
        transform_rotates_text=True,
        color=LOOKS[name]["colors"],
        fontsize=8.5,
        ha="center",
        va="center",
        zorder=6,
    )
    text.set_path_effects([patheffects.withStroke(linewidth=2.6, foreground="white")])


def _legend(regions: RegionMap) -> dict[str, Any]:
    shown = [n for n in (*(n for n in LEGEND if n != "outside"), "outside") if regions.counts[n]]
    handles: dict[str, Any] = {NAMES[n]: fill_patch(FILLS[n]) for n in shown}
    if _flows(regions):
        handles["flow of slip"] = Line2D([], [], color=FLOW, linewidth=0.6)
    if len(regions.crossings):
        handles["$A = B = 0$"] = Line2D([], [], **CROSSING)
    return handles
