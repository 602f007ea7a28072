"""The page of one motion: mechanism, input, figure, events, energy balance and sources."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import sympy as sp

from painleve_sym.errors import InputError, StopReason
from painleve_sym.escape import html_text as escape
from painleve_sym.laws.catalogue import each_law
from painleve_sym.laws.restitution import restitution_law
from painleve_sym.mechanics.formulas.formula import Formula
from painleve_sym.mechanics.formulas.whole_mechanism import energies
from painleve_sym.mechanics.mathml import mathml, symbol_mathml
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.present.animation import Animation
from painleve_sym.present.figure_of_trajectory import trajectory_figure
from painleve_sym.present.page import (
    HtmlPage,
    PageSection,
    figure,
    paragraph,
    preformatted,
    table,
    unit_html,
)
from painleve_sym.present.style import event_label, svg_text
from painleve_sym.quantities import counted, quantity
from painleve_sym.references import Reference, citation
from painleve_sym.study.changes import inputs_text, phases_text
from painleve_sym.study.scenario import Scenario
from painleve_sym.study.settings import SETTINGS
from painleve_sym.tables import Html

MAX_EVENTS = 200
"""Rows of the table of events; the others are counted."""
MAX_OPERATIONS = 400
"""Longer formulas than this are left to `painleve derive`."""


def run_page(scenario: Scenario, run: Trajectory) -> HtmlPage:
    """Return the page of a motion, computed from the scenario."""
    mechanism = scenario.mechanism()
    title = scenario.title or f"{mechanism.title}: motion with law {run.law}"
    end = "It reached the end time" if run.stop_reason is StopReason.T_END else "It ended at"
    why = "" if run.stop_reason is StopReason.T_END else f" ({run.stop_reason.label})"
    events = counted(len(run.events), "event")
    lead = paragraph(
        f"The motion has {events}. {end} t = {run.final_time:.10g} s{why}. {run.stop_detail}"
    )
    lead += "".join(paragraph(notice) for notice in run.notices)
    parts = [
        PageSection("Mechanism", _mechanism(mechanism, run)),
        PageSection("Formulas", _formulas(mechanism)),
        PageSection("Input", _input(scenario, run)),
    ]
    if len(run.step_time):
        drawing = svg_text(trajectory_figure(run), "motion", "Forces and motion over time")
        caption = "Forces, coordinates and velocities over time, with the events marked."
        parts.append(PageSection("Motion", figure(drawing, caption)))
    parts += [
        PageSection("Events", _events(run)),
        PageSection("End", _end(run)),
        PageSection("Energy balance", _energy(run)),
        PageSection("Sources", _sources(scenario, run)),
    ]
    return HtmlPage(title, lead, parts)


def scenario_command(scenario: Scenario) -> str:
    """Return the command that computes a scenario again."""
    words = ["painleve", "simulate", scenario.model]
    set_of_law: dict[str, Any] = {**scenario.law_choices, **scenario.law_parameters}
    usual, case = Scenario(""), replace(scenario, law_parameters=set_of_law)
    for name, setting in SETTINGS.items():
        value = getattr(case, name)
        if setting.group in ("", "jump") or value == getattr(usual, name):
            continue
        if name in ("phases", "inputs"):
            value = phases_text(value) if name == "phases" else inputs_text(value)
        if isinstance(value, Mapping):
            value = tuple(f"{k}={v}" for k, v in value.items())
        text = ",".join(value) if isinstance(value, tuple) else str(value)
        words += [setting.option, text] if text else []
    return shlex.join(words)


def _mechanism(mechanism: Mechanism, run: Trajectory) -> str:
    names: list[tuple[str, ...]] = [
        (_symbol(c.name), c.name, unit_html(c.unit), c.meaning)
        for c in mechanism.outline.coordinates
    ]
    names += [("", c.name, "", f"contact with the gap {c.gap}") for c in mechanism.outline.contacts]
    parts = [paragraph(f"{mechanism.name}: {mechanism.title}.")]
    if mechanism.sketch:
        parts.append(preformatted(mechanism.sketch, "Sketch of the mechanism"))
    parts.append(table(("symbol", "name", "unit", "meaning"), names, "Coordinates and contacts"))
    try:
        still = Animation(run, mechanism).still()
    except InputError as error:
        parts.append(paragraph(str(error)))
    else:
        drawing = svg_text(still, "mechanism", "The mechanism at the start")
        parts.append(figure(drawing, "The mechanism at the start, to scale.", whole=False))
    return "\n".join(parts)


def _symbol(name: str) -> Html:
    return Html(symbol_mathml(name))


def _formulas(mechanism: Mechanism) -> str:
    several = len(mechanism.contacts) > 1
    parts = [_formula(formula) for formula in energies(mechanism).formulas]
    for contact, c in zip(mechanism.contacts, mechanism.all_coefficients, strict=True):
        values = {
            "gap": contact.gap,
            "slip_velocity": contact.slip_velocity,
            **{name: getattr(c, name) for name in ("W_nn", "W_nt", "W_tt", "b_n", "b_t")},
            **{"A_neg": c.A(-1), "A_pos": c.A(1), "B": c.B},
        }
        of = f" of {contact.name}" if several else ""
        parts += [_formula(Formula.of(name, value), of) for name, value in values.items()]
    return "\n".join(parts)


def _formula(formula: Formula, of: str = "") -> str:
    """Return meaning, unit and name of a formula, and the formula with its symbol."""
    name, meaning = escape(formula.name + of), escape(formula.meaning)
    unit = "" if formula.unit in ("1", "SI", "") else f" ({unit_html(formula.unit)})"
    if sp.count_ops(formula.value) > MAX_OPERATIONS:
        body = "<p>It is too long for this page; <code>painleve derive</code> prints it.</p>"
    else:
        body = mathml(formula.value, _LETTERS.get(formula.name, formula.name))
    box = f'<div class="wide" tabindex="0" role="region" aria-label="{name}">{body}</div>'
    return f"<p>{meaning}{unit}: <code>{name}</code></p>{box}"


_LETTERS = {"gap": "g_N", "slip_velocity": "v_t", "A_neg": "A_\u2212", "A_pos": "A_+"}
"""Symbols of quantities whose name is a word."""


def _input(scenario: Scenario, run: Trajectory) -> str:
    mechanism = scenario.mechanism()
    start, units = scenario.start(), mechanism.units
    declared = {p.name: p for p in mechanism.outline.parameters}
    of_law = {p.name: p for p in scenario.contact_law().parameters}
    rows = [
        (_symbol(n), n, float(start.get(n, 0.0)), unit_html(units[n]), "start")
        for n in mechanism.state_names
    ]
    for name, value in run.parameters.items():
        p = declared.get(name) or of_law.get(name.removesuffix("_law"))
        meaning, unit = (p.meaning, p.unit) if p else ("parameter of the law", "")
        rows.append((_symbol(name), name, float(value), unit_html(unit), meaning))
    choices = "".join(f", {name} {value}" for name, value in run.choices.items())
    return (
        paragraph(f"Law {run.law}{choices}; relative tolerance {run.rtol:g}; engine {run.engine}.")
        + table(("symbol", "name", "value", "unit", "meaning"), rows, "Input")
        + paragraph("Compute it again:")
        + preformatted(scenario_command(scenario), "Command")
    )


def _events(run: Trajectory) -> str:
    if not run.events:
        return paragraph("There were no events.")
    forces = [Html(f"{_symbol(name)} (N)") for name in ("F_n", "F_t")]
    head = ("time (s)", "event", "contact", "mode after", *forces, "also possible")
    events = run.events_above_tolerance

    def force(name: str, value: float) -> float:
        return float(f"{run.above_tolerance(name, value):.6g}")

    rows = [
        (
            e.time,
            event_label(e.kind),
            e.contact,
            e.mode_after,
            force("normal_force", e.normal_force),
            force("tangential_force", e.tangential_force),
            ", ".join(e.alternatives),
        )
        for e in events[:MAX_EVENTS]
    ]
    rest, folded = len(events) - MAX_EVENTS, len(run.events) - len(events)
    notes = [f"{rest} more events are not shown."] if rest > 0 else []
    notes += [f"And {counted(folded, 'event')} below the tolerance of the run."] if folded else []
    return table(head, rows, "Events") + "".join(map(paragraph, notes))


def _end(run: Trajectory) -> str:
    values = {**run.final, **run.final_outputs}
    rows = []
    for name in values:
        symbol = "" if quantity(name) else _symbol(name)
        value = run.above_tolerance(name, values[name])
        rows.append((symbol, name, value, unit_html(run.units(name))))
    return table(("symbol", "name", "value", "unit"), rows, "State and forces at the end")


def _energy(run: Trajectory) -> str:
    if not len(run.step_time):
        return paragraph("No step was taken, so there is no balance.")
    terms = run.energies(np.array([run.step_time[0], run.final_time]))
    rows = [
        (name.replace("_", " "), *map(float, (first, last, last - first)))
        for name, (first, last) in terms.items()
    ]
    text = (
        "Kinetic, potential and stored energy with everything dissipated add up to a constant. "
        f"Over the ends of all steps the sum changes by {run.energy_residual:.2g} of its "
        "largest term."
    )
    head = ("term (J)", "start", "end", "change")
    return paragraph(text) + table(head, rows, "Energy balance")


def _sources(scenario: Scenario, run: Trajectory) -> str:
    mechanism, law = scenario.mechanism(), scenario.contact_law()
    cited = [f"Mechanism {mechanism.name}: {mechanism.source}"]
    cited += [f"Law {entry.name} ({entry.title}): {entry.source}" for entry in each_law(law)]
    rules = {value for name, value in run.choices.items() if name.startswith("restitution")}
    cited += [f"Restitution: {restitution_law(str(r)).source}" for r in sorted(rules)]
    entries = "".join(f"<li>{escape(text)}.</li>" for text in dict.fromkeys(cited))
    works = "".join(f"<li>{_work(work)}</li>" for work in citation(run))
    return f"<ul>{entries}</ul>" + (f"<p>Works to cite:</p><ol>{works}</ol>" if works else "")


def _work(work: Reference) -> str:
    text, link = escape(work.text), escape(work.link)
    label = f"<strong>{escape(work.label)}</strong>: " if not work.cited_by_title else ""
    return label + text + (f' <a href="{link}">{link}</a>' if link else "")
