"""Measured data and the fitted model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from painleve_sym.present.style import COLUMN, PALETTE, REFERENCE, TALLEST, styled
from painleve_sym.quantities import symbol_latex, text_label
from painleve_sym.study.fitting.data import MEASURABLE
from painleve_sym.study.fitting.result import FitResult

_HEIGHT, _MARGIN = 2.45, 0.5


@styled
def fit_figure(
    fit_result: FitResult, units: Mapping[str, str], width: float | None = None
) -> Figure:
    """Return one panel per measured quantity; the width is in inches, by default that of a column.

    A history shows data and model over time; motions row by row show the model against the data,
    where a perfect fit lies on the diagonal.
    """
    names = list(fit_result.measured)
    wide = COLUMN if width is None else width
    # Of rows the panels are square.
    own = min(wide, COLUMN) if fit_result.times is None else _HEIGHT
    height = min(own * len(names) + _MARGIN, TALLEST)
    figure = Figure(figsize=(wide, height), layout="constrained")
    share = fit_result.times is not None
    rows = [r for _ in names for r in ((3, 1) if share else (1,))]
    panels: Any = figure.subplots(len(rows), 1, sharex=share, squeeze=False, height_ratios=rows)
    panels = panels[:, 0]
    for k, name in enumerate(names):
        label = text_label(_symbol(name), units[name])
        if fit_result.times is None:
            _draw_rows(panels[k], fit_result, name, label)
        else:
            _draw_history(panels[2 * k], fit_result, name, label)
            _draw_residual(panels[2 * k + 1], fit_result, name, units[name])
    if fit_result.times is not None:
        panels[-1].set_xlabel(text_label("time", "ms"))
    panels[0].legend(loc="best")
    return figure


def _symbol(name: str) -> str:
    """Return an output in words, a coordinate or velocity as a formula."""
    return name.replace("_", " ") if name in MEASURABLE else f"${symbol_latex(name)}$"


def _draw_history(axes: Axes, fit_result: FitResult, name: str, label: str) -> None:
    assert fit_result.times is not None
    times, data = fit_result.times * 1e3, fit_result.measured[name]
    axes.plot(times, data, ".", color=REFERENCE, markersize=3.0, label="measured")
    axes.plot(times, fit_result.model[name], color=PALETTE[2], label="fitted model")
    axes.set_ylabel(label)


def _draw_residual(axes: Axes, fit_result: FitResult, name: str, unit: str) -> None:
    """Draw measured less fitted values, with one standard deviation of the noise as a band."""
    assert fit_result.times is not None
    times = fit_result.times * 1e3
    axes.axhspan(-fit_result.noise[name], fit_result.noise[name], color="0.9", zorder=0)
    axes.axhline(0, color=REFERENCE, linewidth=0.6, zorder=0.5)
    residual = fit_result.measured[name] - fit_result.model[name]
    axes.plot(times, residual, ".", color=PALETTE[0], markersize=2.4)
    axes.set_ylabel(text_label("residual", unit))


def _draw_rows(axes: Axes, fit_result: FitResult, name: str, label: str) -> None:
    data, model = fit_result.measured[name], fit_result.model[name]
    kept = np.isfinite(data)
    ends = [float(f(np.concatenate([data[kept], model[kept]]))) for f in (np.min, np.max)]
    axes.plot(ends, ends, color=REFERENCE, linewidth=0.8, label="equal")
    axes.errorbar(
        data[kept],
        model[kept],
        xerr=fit_result.noise[name],
        fmt="o",
        color=PALETTE[1],
        markersize=3.0,
        elinewidth=0.7,
        label="motions, one standard deviation",
    )
    axes.set_xlabel(f"measured {label}")
    axes.set_ylabel(f"model {label}")
