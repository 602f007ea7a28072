"""The figure of a contrast: contact velocities over time, and errors over step and stiffness."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from painleve_sym.present.style import (
    DASHES,
    PALETTE,
    REFERENCE,
    legend_below,
    legend_entries,
    log_ticks,
    panel_grid,
    styled,
)
from painleve_sym.quantities import axis_label, number_latex, text_label
from painleve_sym.study.comparisons.case import Answer
from painleve_sym.study.comparisons.comparison import ROUND_OFF, Comparison

# Colour, symbol and size of a solver: open symbols that fit into each other where answers agree.
_SOLVERS: dict[str, tuple[str, str, float]] = {
    "first": (REFERENCE, "v", 9.5),
    "largest-impulse": (PALETTE[3], "s", 7.5),
    "least-impulse": (PALETTE[1], "o", 5.4),
    "lemke": (PALETTE[4], "D", 3.2),
    "mpcc": (PALETTE[0], "x", 3.6),
}
_SOFTENED = PALETTE[2]
_TITLES = ("normal velocity", "slip velocity", "time stepping", "compliant motion")
_ENDS = ("+", "x", "o", "s", "D")
"""Marks of the ends of rigid jumps in space: lift-off, three laws, plastic."""
ASIDE = 1.22
"""Ratio of the places of two points beside each other, where methods agree on one point."""
_EARLY = {"marker": "X", "markersize": 5.0, "markevery": [-1], "clip_on": False}
"""The cross where a motion ended before the end time."""


@styled
def contrast_figure(comparison: Comparison, width: float | None = None) -> Figure:
    """Return the figure: normal and slip velocity over time, error over step and over stiffness.

    In space the time is a part of the impact's duration, and the slip velocity is drawn in the
    plane of its tangents; of rigid jumps only the ends are drawn.

    The width is in inches, by default that of a page. Equal errors stand side by side.
    """
    figure, panels = panel_grid(4, width, 2.1)
    normal, slip, steps, stiffness = panels
    if comparison.frozen:
        _draw_impacts(normal, slip, comparison)
    else:
        _draw_motion(normal, comparison, 0)
        _draw_motion(slip, comparison, 1)
    _draw_errors(steps, comparison.stepping, text_label("step $h$", "s"), 1.0)
    expected = comparison.expected_stiffness_order
    _draw_errors(stiffness, comparison.softened, text_label("modulus $E$", "Pa"), expected)
    for letter, axes, title in zip("abcd", panels, _TITLES, strict=True):
        axes.set_title(f"({letter}) {title}")
    legend_below(figure, legend_entries([normal]))
    return figure


def _draw_motion(axes: Axes, comparison: Comparison, column: int) -> None:
    for answer, label, look in _lines(comparison):
        values = answer.contact_velocities[:, column]
        if not answer.complete:
            look = look | _EARLY
        axes.plot(answer.times * 1e3, values, label=label, **look)
    longest = max(a.setting for a in comparison.stepping)
    drawn = [a for a in comparison.stepping if a.setting == longest]
    for answer in sorted(drawn, key=lambda a: _SOLVERS[a.way][2], reverse=True):
        # Solvers that agree take turns, so that no mark hides another.
        alike = [a for a in drawn if _agree(a, answer)]
        values = answer.contact_velocities[:, column]
        label = f"{answer.way}, $h$ = {_power(longest)} s"
        every = max(1, len(values) // 20)
        turn = alike.index(answer)
        axes.plot(
            answer.times * 1e3,
            values,
            label=label,
            linestyle="none",
            markevery=(turn * every, len(alike) * every),
            zorder=3,
            clip_on=False,
            **_symbol(answer.way),
        )
    axes.axhline(0, color=REFERENCE, linewidth=0.5, zorder=0)
    axes.set_xlabel(axis_label("t", "ms"))
    axes.set_ylabel(axis_label((r"\dot{g}_N", "v_t")[column], "m/s"))


def _draw_impacts(normal: Axes, slip: Axes, comparison: Comparison) -> None:
    """Draw the velocities of impacts in space: rigid jumps by their ends alone."""
    marks = iter(_ENDS)
    for answer, label, look in _lines(comparison):
        v_n, along, across = answer.contact_velocities.T
        if answer.method == "rigid":
            symbol = {"marker": next(marks), "markersize": 6.5, "markerfacecolor": "none"}
            look = {"color": look["color"], "linestyle": "none", "clip_on": False, "zorder": 3}
            v_n, along, across, times = v_n[-1:], along[-1:], across[-1:], np.ones(1)
            look |= symbol
        else:
            times = answer.times / answer.final_time
        normal.plot(times, v_n, label=label, **look)
        slip.plot(along, across, **look)
    for solver in dict.fromkeys(a.way for a in comparison.stepping):
        normal.plot([], [], label=f"{solver}, one step", linestyle="none", **_symbol(solver))
    normal.axhline(0, color=REFERENCE, linewidth=0.5, zorder=0)
    normal.set_xlabel("part of the duration")
    normal.set_ylabel(axis_label(r"\dot{g}_N", "m/s"))
    slip.set_aspect("equal", adjustable="datalim")
    slip.set_xlabel(axis_label("v_{t1}", "m/s"))
    slip.set_ylabel(axis_label("v_{t2}", "m/s"))


def _agree(one: Answer, other: Answer) -> bool:
    """Return whether two answers are the same to the width of a line."""
    a, b = one.contact_velocities, other.contact_velocities
    if a.shape != b.shape:
        return False
    return bool(np.abs(a - b).max() <= 1e-3 * max(float(np.abs(a).max()), 1e-300))


def _lines(comparison: Comparison) -> list[tuple[Answer, str, dict[str, Any]]]:
    """Return rigid motions that differ, then compliant ones, with label and look."""
    lines: list[tuple[Answer, str, dict[str, Any]]] = []
    for answer in comparison.rigid:
        if not any(answer.same_end(other) for other, _, _ in lines):
            style = DASHES[len(lines) % len(DASHES)]
            look = {"color": PALETTE[0], "linestyle": style, "linewidth": 0.9, "zorder": 2}
            lines.append((answer, f"rigid, {answer.way}{_stopped(answer)}", look))
    for i, answer in enumerate(comparison.softened):
        look = {"color": _SOFTENED, "linestyle": DASHES[i % len(DASHES)], "zorder": 1}
        look["linewidth"] = 1.8
        label = f"compliant, $E$ = {_power(answer.setting)} Pa{_stopped(answer)}"
        lines.append((answer, label, look))
    return lines


def _stopped(answer: Answer) -> str:
    """Return why a motion ended early, for its label."""
    return "" if answer.complete else f" ({answer.stop_reason.label.replace('_', ' ')})"


def _symbol(solver: str) -> dict[str, Any]:
    color, symbol, size = _SOLVERS[solver]
    return {
        "color": color,
        "marker": symbol,
        "markersize": size,
        "markerfacecolor": "none",
        "markeredgewidth": 0.8,
    }


def _power(value: float) -> str:
    return f"${number_latex(value)}$"


def _draw_errors(axes: Axes, answers: tuple[Answer, ...], label: str, slope: float) -> None:
    drawn: list[Answer] = []
    # What is below the accuracy of the reference is not an error.
    known = [a for a in answers if a.error > ROUND_OFF]
    for way in dict.fromkeys(a.way for a in answers):
        chosen = [a for a in known if a.way == way]
        look = (
            {**_symbol(way), "linewidth": 0.8}
            if way in _SOLVERS
            else {"color": _SOFTENED, "marker": "o", "markersize": 3.5}
        )
        joined = len({a.first_mode for a in chosen}) == 1
        axes.plot(
            [a.setting * _aside(a, answers) for a in chosen],
            [a.error for a in chosen],
            linestyle="solid" if joined else "none",
            **look,
        )
        drawn = chosen if joined and len(chosen) > len(drawn) else drawn
    if not known:
        compared = any(a.reference for a in answers)
        axes.text(
            0.5,
            0.5,
            "equals the rigid motion\nto its accuracy"
            if compared
            else "no error: the rigid motion,\nor each of these, ended early",
            transform=axes.transAxes,
            ha="center",
            va="center",
        )
        axes.set_xticks([])
        axes.set_yticks([])
    else:
        axes.set(xscale="log", yscale="log")
        log_ticks(axes.xaxis)
        log_ticks(axes.yaxis)
        _draw_slope(axes, drawn, slope)
    axes.set_xlabel(label)
    axes.set_ylabel("relative error")


def _aside(answer: Answer, answers: tuple[Answer, ...]) -> float:
    """Return the factor that moves a point beside the others of equal setting and error."""
    alike = [
        a.way
        for a in answers
        if a.setting == answer.setting and abs(a.error - answer.error) <= 0.02 * answer.error
    ]
    return float(ASIDE ** (alike.index(answer.way) - (len(alike) - 1) / 2))


def _draw_slope(axes: Axes, answers: list[Answer], slope: float) -> None:
    """Draw a line of the expected order below the points of one way, with its order."""
    if not answers:
        return
    settings = np.array([min(a.setting for a in answers), max(a.setting for a in answers)])
    if not np.isfinite(slope) or settings[0] == settings[1]:
        return
    # From the point the line lies lowest under, a third below it.
    factor = min(a.error / a.setting**slope for a in answers) / 3
    axes.plot(settings, factor * settings**slope, color=REFERENCE, linewidth=0.9, linestyle="--")
    middle = float(np.exp(np.mean(np.log(settings))))
    axes.annotate(
        f"order ${slope:.3g}$",
        (middle, factor * middle**slope),
        xytext=(4, -4) if slope > 0 else (-4, -4),
        textcoords="offset points",
        ha="left" if slope > 0 else "right",
        va="top",
        color=REFERENCE,
    )
