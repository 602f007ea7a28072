"""HTML of results for notebooks: tables and small figures."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from painleve_sym.at.classification import Classification
from painleve_sym.at.jump import JumpResult
from painleve_sym.contact_rows import axis_names
from painleve_sym.escape import figure_text
from painleve_sym.escape import html_text as escape
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.records import EventRecord
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.notebooks import Shown
from painleve_sym.present.figure_of_map import map_figure
from painleve_sym.present.style import CONTACTS, DASHES, NORMAL, styled, svg_text
from painleve_sym.problem.solution import ContactSolution
from painleve_sym.quantities import axis_label, scaled_unit
from painleve_sym.study.maps.region_map import RegionMap
from painleve_sym.tables import html_table

MAX_EVENTS = 12
"""Rows of the table; the others are counted."""
_HEAD = ("time (s)", "event", "contact", "mode after", "F_n (N)", "F_t (N)")


def html(result: Shown) -> str:
    """Return a result as HTML: its line, and the parts that its type has. Names are escaped."""
    parts = next((p for kind, p in _PARTS.items() if isinstance(result, kind)), None)
    more = parts(result) if parts is not None else []
    return "\n".join([f"<p>{escape(repr(result))}</p>", *more])


def _trajectory(trajectory: Trajectory) -> list[str]:
    """Return a table of the first events and a figure of the forces, where steps were kept."""
    parts = [_events(trajectory.events)]
    if len(trajectory.step_time) and trajectory.evaluator is not None:
        parts.append(svg_text(_forces(trajectory), "forces"))
    return parts


def _events(events: tuple[EventRecord, ...]) -> str:
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
    rest = len(events) - MAX_EVENTS
    note = f"<p>{rest} more events.</p>" if rest > 0 else ""
    return f"{html_table(_HEAD, rows)}{note}"


def _event(event: EventRecord) -> list[str]:
    return [html_table(("state", "just after"), ((n, f"{v:.6g}") for n, v in event.state.items()))]


def _mechanism(mechanism: Mechanism) -> list[str]:
    """Return title, coordinates, parameters and contacts; nothing is derived."""
    outline = mechanism.outline
    held = ("contact", "held from both sides")
    return [
        f"<p>{escape(mechanism.title)}</p>",
        html_table(
            ("coordinate", "unit", "meaning"),
            ((c.name, c.unit, c.meaning) for c in outline.coordinates),
        ),
        html_table(
            ("parameter", "default", "unit", "meaning"),
            ((p.name, f"{p.default:g}", p.unit, p.meaning) for p in outline.parameters),
        ),
        html_table(
            ("contact", "friction", "gap", "kind"),
            ((c.name, c.friction, c.gap, held[c.bilateral]) for c in outline.contacts),
        ),
    ]


def _classification(classification: Classification) -> list[str]:
    """Return what the case means, and every solution with its forces and accelerations."""
    sentence = f"<p>{escape(classification.case.sentence)}</p>"
    solutions = classification.solutions
    if not solutions:
        return [sentence]
    axes = axis_names(max(classification.problem.tangents))
    head = ("solution", "contact", "mode", *(f"F_{k} (N)" for k in axes))
    rows = [
        (str(i), name, mode.value, *(f"{v:.6g}" for v in numbers))
        for i, s in enumerate(solutions, 1)
        for name, mode, numbers in zip(
            classification.contacts, s.modes, _forces_and_accelerations(s), strict=True
        )
    ]
    return [sentence, html_table((*head, *(f"a_{k} (m/s²)" for k in axes)), rows)]


def _forces_and_accelerations(solution: ContactSolution) -> list[list[float]]:
    """Return the forces, then the accelerations, of each contact."""
    both = zip(solution.contact_forces, solution.contact_accelerations, strict=True)
    return [[*force.tolist(), *acceleration.tolist()] for force, acceleration in both]


def _jump(jump: JumpResult) -> list[str]:
    """Return the phases, and the velocities before and after."""
    _, *tangents = axis_names(len(jump.slip_velocity))
    impulses, slips = [f"P_{t} (N s)" for t in tangents], [f"v_{t} (m/s)" for t in tangents]
    head = ("phase", "P_n (N s)", *impulses, "energy gained (J)", *slips, "v_n (m/s)")
    rows = []
    for p in jump.phases:
        values = (*p.impulse, p.stored_energy, *p.slip_velocity, p.normal_velocity)
        rows.append((p.name, *(f"{v:.6g}" for v in values)))
    velocities = [
        (name, f"{before:.6g}", f"{jump.velocity[name]:.6g}")
        for name, before in jump.velocity_before.items()
    ]
    return [html_table(head, rows), html_table(("velocity", "before", "after"), velocities)]


def _map(regions: RegionMap) -> list[str]:
    return [svg_text(map_figure(regions), "map", f"Map of {regions.mechanism}")]


_PARTS: dict[type, Callable[[Any], list[str]]] = {
    Trajectory: _trajectory,
    EventRecord: _event,
    Mechanism: _mechanism,
    Classification: _classification,
    JumpResult: _jump,
    RegionMap: _map,
}
"""What follows the line of a result, by its type."""


@styled
def _forces(trajectory: Trajectory) -> Figure:
    times = trajectory.fine_times(4)
    scale, unit = scaled_unit("s", trajectory.final_time)
    outputs, names = trajectory.outputs(times), trajectory.names
    forces = {c: outputs[names.of_contact("normal_force", c)] for c in names.contacts}
    several = len(forces) > 1
    largest = max(float(np.nanmax(np.abs(force))) for force in forces.values())
    factor, force_unit = scaled_unit("N", largest)
    figure = Figure(figsize=(4.5, 1.6), layout="constrained")
    axes = figure.add_subplot()
    for k, (contact, force) in enumerate(forces.items()):
        colour, dashes = (CONTACTS[k % 5], DASHES[k % 5]) if several else (NORMAL, DASHES[0])
        look: Any = {"color": colour, "linestyle": dashes, "label": figure_text(contact)}
        axes.plot(times * scale, force * factor, **look)
    axes.set_xlabel(axis_label("t", unit))
    axes.set_ylabel(axis_label("F_n", force_unit))
    if several:
        axes.legend()
    return figure
