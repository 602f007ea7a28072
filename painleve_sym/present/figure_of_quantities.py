"""Chosen quantities of a motion over time: a figure of panels, or in axes of one's own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from painleve_sym.checks import checked_number, names_of
from painleve_sym.errors import InputError, received, refuse_unknown
from painleve_sym.escape import figure_text
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.present.figure_of_trajectory import (
    drawn_times,
    refuse_unmoved,
    trajectory_figure,
)
from painleve_sym.present.style import PAGE, STEPS, TALLEST, styled
from painleve_sym.quantities import QUANTITIES, axis_label, text_label

PANEL = 1.25
"""Height of a panel; inch."""
AxesLike = Axes | Sequence[Axes]


def motion_figure(
    run: Trajectory,
    quantities: str | Sequence[str] | None = None,
    ax: AxesLike | None = None,
    width: float | None = None,
    style: dict[str, Any] | None = None,
) -> Figure:
    """Return a figure of a motion; see `Trajectory.plot`."""
    if quantities is None and ax is None and not style:
        return trajectory_figure(run, width)
    if width is not None and (ax is not None or checked_number(width, "width", above=0.0)[1]):
        need = "none with axes of your own" if ax is not None else "a number > 0 of inches"
        raise InputError(f"trajectory figure: width: got {received(width)}, need {need}.")
    refuse_unmoved(run)
    names = _names(run, quantities)
    if ax is not None:
        return _on_axes(run, names, _axes(ax, names), style or {})
    return _panels(run, names, PAGE if width is None else width, style or {})


def _names(run: Trajectory, quantities: str | Sequence[str] | None) -> list[str]:
    """Return the names of quantities; those of the forces where none are given."""
    where = "trajectory figure: quantities"
    if quantities is None:
        contacts = run.names.contacts
        forces = ("normal_force", "tangential_force")[: 2 if len(contacts) == 1 else 1]
        return [run.names.of_contact(force, c) for force in forces for c in contacts]
    names = names_of(quantities, where, "theta,normal_force")
    known = (*run.state_names, *run.output_names)
    if not names:
        raise InputError(f"{where}: got none. Fix: name one, such as {known[0]!r}.")
    for name in names:
        if name.endswith((".png", ".svg", ".pdf")):
            raise InputError(f"{where}: got {name!r}. Fix: to write a file, plot().savefig(...).")
        refuse_unknown("quantity", name, known, where)
    return list(names)


def _axes(ax: Any, names: Sequence[str]) -> list[Axes]:
    """Return the axes of each quantity: one for all, or as many as there are."""
    several = list(np.ravel(np.asarray(ax, dtype=object)))
    if not several or not all(isinstance(axes, Axes) for axes in several):
        raise InputError(
            f"trajectory figure: ax: got {received(ax)}, need axes of Matplotlib, or several. "
            "Fix: figure, ax = matplotlib.pyplot.subplots()."
        )
    if len(several) == 1:
        return several * len(names)
    if len(several) != len(names):
        raise InputError(
            f"trajectory figure: got {len(several)} axes and the quantities {', '.join(names)}, "
            "need one of axes for each, or axes for all."
        )
    return several


def _on_axes(
    run: Trajectory, names: Sequence[str], axes: Sequence[Axes], style: dict[str, Any]
) -> Figure:
    """Draw quantities in SI units, so that several motions share axes; return their figure."""
    shared = len(names) > 1 and axes[0] is axes[1]
    units = {run.units(name) for name in names}
    if shared and len(units) > 1:
        raise InputError(
            f"trajectory figure: got {', '.join(names)} for one of axes, need quantities of one "
            f"unit, not of {', '.join(sorted(units))}. Fix: give several axes."
        )
    times = drawn_times(run)
    values = _values(run, names, times)
    for own, name in zip(axes, names, strict=True):
        label = {"label": name.replace("_", " ")} if shared else {}
        own.plot(times, values[name], **{**label, **style})
        if shared:
            own.set_ylabel(run.units(name))
            own.legend()
        else:
            own.set_ylabel(_label(run, name, run.units(name)))
        own.set_xlabel(text_label("time", "s"))
    figure = axes[0].get_figure(root=True)
    assert isinstance(figure, Figure)
    return figure


@styled
def _panels(run: Trajectory, names: Sequence[str], width: float, style: dict[str, Any]) -> Figure:
    """Return a figure with a panel for each quantity below each other."""
    height = min(PANEL * len(names) + 0.6, TALLEST)
    figure = Figure(figsize=(width, height), layout="constrained")
    every: Any = figure.subplots(len(names), sharex=True, squeeze=False)
    panels: list[Axes] = list(every[:, 0])
    _on_axes(run, names, panels if len(names) > 1 else panels * len(names), style)
    for axes in panels:
        axes.yaxis.set_major_locator(MaxNLocator(4, steps=STEPS))
        axes.label_outer()
    panels[0].set_title(f"{figure_text(run.mechanism)}, {figure_text(run.law)}")
    return figure


def _values(run: Trajectory, names: Sequence[str], times: Any) -> dict[str, Any]:
    """Return the values of quantities at times, by name."""
    states = run(times)
    outputs = run.outputs(times) if any(n not in run.state_names for n in names) else {}
    known = dict(zip(run.state_names, states.T, strict=True))
    return {name: known[name] if name in known else outputs[name] for name in names}


def _label(run: Trajectory, name: str, unit: str) -> str:
    """Return the label of an axis: a formula where the quantity has one."""
    if name in run.names.latex:
        return axis_label(run.names.latex[name], unit)
    if name in QUANTITIES:
        return axis_label(QUANTITIES[name].latex, unit)
    return text_label(figure_text(name.replace("_", " ")), unit)
