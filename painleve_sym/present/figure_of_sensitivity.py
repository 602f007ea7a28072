"""A state and its derivatives over time, through every event."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from sympy import Symbol, latex

from painleve_sym.motion.sensitivity.result import SensitiveTrajectory
from painleve_sym.present.style import (
    COLUMN,
    DASHES,
    PALETTE,
    REFERENCE,
    legend_below,
    legend_entries,
    styled,
)
from painleve_sym.quantities import text_label

_MARGIN = 1.02
"""The end of the drawn motion, in units of the time of its last event."""


@styled
def sensitivity_figure(
    sensitivity: SensitiveTrajectory,
    quantity: str,
    label: str,
    symbols: Mapping[str, str] | None = None,
    start: float = 0.0,
) -> Figure:
    """Return a figure of a quantity, and of its derivatives per relative change of a parameter.

    The sensitivities have dense steps, and parameters as directions, whose LaTeX is by default that
    of their names. The label is that of the quantity's axis, with the unit. Drawn from `start` on;
    s.
    """
    run = sensitivity.trajectory
    # Just before an event, too: derivatives jump there.
    before = [np.nextafter(e.event.time, -np.inf) for e in sensitivity.events]
    times = np.union1d(run.fine_times(24), before)
    times = times[times >= start]
    if sensitivity.events:
        times = times[times <= _MARGIN * sensitivity.events[-1].event.time]
    values, slopes = run.values(quantity, times), sensitivity.gradient(quantity, times)
    sizes = np.array([run.parameters.get(name, 1.0) for name in sensitivity.wrt])
    figure = Figure(figsize=(COLUMN, 3.6), layout="constrained")
    panels: Any = figure.subplots(2, 1, sharex=True)
    panels[0].plot(times * 1e3, values, color=PALETTE[0])
    panels[0].set_ylabel(label)
    for k, name in enumerate(sensitivity.wrt):
        symbol = (symbols or {}).get(name) or latex(Symbol(name))
        text = rf"${symbol}\,\partial/\partial {symbol}$"
        look: Any = {"color": PALETTE[1 + k % 4], "linestyle": DASHES[k % len(DASHES)]}
        panels[1].plot(times * 1e3, slopes[:, k] * sizes[k], label=text, **look)
    for axes in panels:
        for i, e in enumerate(sensitivity.events):
            line: Any = {"color": REFERENCE, "linewidth": 0.6, "zorder": 0}
            axes.axvline(e.event.time * 1e3, label="_" if i else "event", **line)
    panels[1].set_ylabel(f"change of {label}")
    panels[1].set_xlabel(text_label("time", "ms"))
    legend_below(figure, legend_entries(panels[1:]))
    return figure
