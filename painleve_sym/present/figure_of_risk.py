"""The distribution of the friction from which a robot's contact is at risk, over its poses."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from painleve_sym.errors import InputError
from painleve_sym.present.style import COLUMN, DASHES, PALETTE, REFERENCE, legend_below, styled
from painleve_sym.quantities import axis_label, text_label
from painleve_sym.robots.report import RiskReport

_HEIGHT = 2.6


@styled
def risk_figure(report: RiskReport, width: float | None = None) -> Figure:
    """Return the share of poses with μ_P below each value; the width is in inches.

    Lines mark μ_P at the pose, its least value, and the friction coefficient.
    """
    values = np.sort(report.distribution[np.isfinite(report.distribution)])
    if not len(values):
        raise InputError(
            "robot: the figure shows poses over the ranges of joints: got "
            + ("none with a finite mu_P." if report.least else "no joint with a range.")
        )
    wide = COLUMN if width is None else width
    figure = Figure(figsize=(wide, _HEIGHT * wide / COLUMN), layout="constrained")
    axes = figure.add_subplot()
    share = 100 * np.arange(1, len(values) + 1) / len(report.distribution)
    axes.plot(values, share, color=PALETTE[0], label="poses within joint limits")
    marks = [(report.risk.mu_P, "this pose", 1)]
    if report.least is not None:
        marks.append((report.least.mu_P, "least of all poses", 2))
    for value, name, style in marks:
        if not math.isfinite(value):
            continue
        axes.axvline(value, color=PALETTE[style], linestyle=DASHES[style], label=name)
    if report.risk.mu is not None:
        axes.axvline(report.risk.mu, color=REFERENCE, label=r"$\mu$")
        below = values[values < report.risk.mu]
        axes.fill_between(below, share[: len(below)], color=PALETTE[2], alpha=0.2, linewidth=0)
    shown = [float(np.quantile(values, 0.95)), report.risk.mu_P * 1.1, (report.risk.mu or 0) * 1.1]
    axes.set_xlim(0, max(v for v in shown if np.isfinite(v)))
    axes.set_ylim(0, 100)
    axes.set_xlabel(axis_label(r"\mu_P"))
    axes.set_ylabel(text_label(r"poses with a smaller $\mu_P$", "%"))
    handles, names = axes.get_legend_handles_labels()
    legend_below(figure, dict(zip(names, handles, strict=True)))
    return figure
