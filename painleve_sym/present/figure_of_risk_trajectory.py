"""The friction from which a robot's contact is at risk, along a motion."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from painleve_sym.errors import InputError
from painleve_sym.present.style import COLUMN, PALETTE, REFERENCE, legend_below, styled
from painleve_sym.quantities import text_label
from painleve_sym.robots.trajectory import RiskTrajectory

_HEIGHT = 2.3


@styled
def risk_trajectory_figure(motion: RiskTrajectory, width: float | None = None) -> Figure:
    """Return μ_P over time, with the friction coefficient; the width is in inches.

    The line is thin where the contact is open. The time at risk, in which the contact touches with
    μ_P below the friction coefficient, is shaded. InputError where μ_P is finite nowhere.
    """
    bounded = motion.mu_P[np.isfinite(motion.mu_P)]
    if not len(bounded):
        raise InputError("robot: the figure shows mu_P along the motion: got none that is finite.")
    wide = COLUMN if width is None else width
    figure = Figure(figsize=(wide, _HEIGHT * wide / COLUMN), layout="constrained")
    axes = figure.add_subplot()
    touching = np.where(motion.closed, motion.mu_P, np.nan)
    axes.plot(motion.t, touching, color=PALETTE[0], label=r"$\mu_P$")
    if not motion.closed.all():
        (thin,) = axes.plot(motion.t, motion.mu_P, label="no contact", zorder=1)
        thin.set(color=PALETTE[0], linewidth=0.5, alpha=0.6)
    top = float(np.quantile(bounded, 0.95)) * 1.1
    if motion.mu is not None:
        axes.axhline(motion.mu, color=REFERENCE, label=r"$\mu$")
        low = np.minimum(motion.mu_P, motion.mu)
        shade = axes.fill_between(motion.t, low, motion.mu, where=motion.at_risk, label="at risk")
        shade.set(color=PALETTE[2], alpha=0.25, linewidth=0)
        top = max(top, 1.1 * motion.mu)
    axes.set_ylim(0, top)
    axes.set_xlabel(text_label("time", "s"))
    axes.set_ylabel("friction coefficient")
    handles, names = axes.get_legend_handles_labels()
    legend_below(figure, dict(zip(names, handles, strict=True)))
    return figure
