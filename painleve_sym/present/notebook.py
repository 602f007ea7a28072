"""HTML of results for notebooks: a table of the events and a small figure."""

from __future__ import annotations

from matplotlib import rc_context
from matplotlib.figure import Figure

from painleve_sym.escape import html_text as escape
from painleve_sym.motion.trajectory import EventRecord, Trajectory
from painleve_sym.present.style import PALETTE, STYLE, svg_text
from painleve_sym.quantities import axis_label

MAX_EVENTS = 12
"""Rows of the table; the others are counted."""
_HEAD = ("time [s]", "event", "contact", "mode after", "F_n [N]", "F_t [N]")


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


def _forces(trajectory: Trajectory) -> Figure:
    times = trajectory.fine_times(4)
    outputs = trajectory.outputs(times)
    contacts = trajectory.names.contacts
    with rc_context(STYLE):
        figure = Figure(figsize=(4.5, 1.6), layout="constrained")
        axes = figure.add_subplot()
        for k, contact in enumerate(contacts):
            end = f"_{contact}" if len(contacts) > 1 else ""
            axes.plot(times, outputs[f"normal_force{end}"], color=PALETTE[k], label=contact)
        axes.set_xlabel(axis_label("t", "s"))
        axes.set_ylabel(axis_label("F_n", "N"))
        if len(contacts) > 1:
            axes.legend()
    return figure
