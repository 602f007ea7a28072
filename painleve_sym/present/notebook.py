"""HTML of results for notebooks: a table of the events and a small figure."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from painleve_sym.escape import figure_text
from painleve_sym.escape import html_text as escape
from painleve_sym.motion.trajectory import EventRecord, Trajectory
from painleve_sym.present.style import CONTACTS, DASHES, NORMAL, styled, svg_text
from painleve_sym.quantities import axis_label, scaled_unit

MAX_EVENTS = 12
"""Rows of the table; the others are counted."""
_HEAD = ("time (s)", "event", "contact", "mode after", "F_n (N)", "F_t (N)")


def trajectory_html(trajectory: Trajectory) -> str:
    """Return a trajectory as HTML: heading, table of the first events, figure of the forces.

    The figure is SVG, and there is none where no steps were kept. Names are escaped.
    """
    parts = [f"<p>{escape(repr(trajectory))}</p>", _table(trajectory.events)]
    if len(trajectory.step_time) and trajectory.evaluator is not None:
        parts.append(svg_text(_forces(trajectory), "forces"))
    return "\n".join(parts)


def _table(events: tuple[EventRecord, ...]) -> str:
    if not events:
        return "<p>No events.</p>"
    rows = [
        (
            f"{e.time:.6g}",
            str(e.kind),
            e.contact,
            e.mode_after,
            f"{e.normal_force:.4g}",
            f"{e.tangential_force:.4g}",
        )
        for e in events[:MAX_EVENTS]
    ]
    head = "".join(f"<th>{escape(title)}</th>" for title in _HEAD)
    lines = [f"<tr>{head}</tr>"]
    lines += ["<tr>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>" for row in rows]
    rest = len(events) - MAX_EVENTS
    note = f"<p>{rest} more events.</p>" if rest > 0 else ""
    return f"<table>{''.join(lines)}</table>{note}"


@styled
def _forces(trajectory: Trajectory) -> Figure:
    times = trajectory.fine_times(4)
    scale, unit = scaled_unit("s", trajectory.final_time)
    outputs, contacts = trajectory.outputs(times), trajectory.names.contacts
    several = len(contacts) > 1
    ends = [f"_{contact}" if several else "" for contact in contacts]
    largest = max(float(np.nanmax(np.abs(outputs[f"normal_force{end}"]))) for end in ends)
    factor, force_unit = scaled_unit("N", largest)
    figure = Figure(figsize=(4.5, 1.6), layout="constrained")
    axes = figure.add_subplot()
    for k, (contact, end) in enumerate(zip(contacts, ends, strict=True)):
        colour, dashes = (CONTACTS[k % 5], DASHES[k % 5]) if several else (NORMAL, DASHES[0])
        look: Any = {"color": colour, "linestyle": dashes, "label": figure_text(contact)}
        axes.plot(times * scale, outputs[f"normal_force{end}"] * factor, **look)
    axes.set_xlabel(axis_label("t", unit))
    axes.set_ylabel(axis_label("F_n", force_unit))
    if several:
        axes.legend()
    return figure
