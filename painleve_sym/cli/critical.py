"""The command critical: from which initial force an indeterminate contact impacts."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from painleve_sym.cli.case import read_case
from painleve_sym.cli.options import (
    MAPS,
    figure_file,
    given_options,
    read_look,
    read_range,
    unit_for,
)
from painleve_sym.cli.output import (
    assignments,
    deliver_map,
    notices_data,
    number,
    print_json,
    quantity,
    show,
    show_notices,
    show_table,
)
from painleve_sym.cli.run import show_start
from painleve_sym.errors import InputError
from painleve_sym.motion.simulator import Simulator
from painleve_sym.plain_data import plain_fields
from painleve_sym.study.critical.bisection import Border, CriticalForce, CriticalForceFinder
from painleve_sym.study.critical.gradient import ForceDerivative, critical_force_gradient
from painleve_sym.study.critical.outcome_map import OutcomeMap, outcome_map
from painleve_sym.study.scenario import Scenario

DEFAULT_LAW = "bilinear-hertz"
PRINTED_ROWS = 13
"""Rows of a map that are printed."""

_BORDERS = {
    Border.SLIP_STOP: "the slip stops at all: impact, not lift-off",
    Border.COMPRESSION: "it stops before the maximum compression",
}


def critical(arguments: argparse.Namespace) -> int:
    """Print the critical forces at a state, or map the outcomes over one quantity."""
    if arguments.law is None and not arguments.case.endswith(".toml"):
        arguments.law = DEFAULT_LAW
    scenario = read_case(arguments)
    look = read_look(arguments)
    files = [figure_file("--out", text, look, MAPS) for text in arguments.out or ()]
    finder = _finder(scenario)
    given = {**scenario.parameters, **scenario.law_parameters}
    if arguments.over is not None:
        return _map(arguments, scenario, finder, given, files, look)
    for option in given_options(arguments, "forces", "points", "out"):
        raise InputError(f"--{option}: needs --over NAME=FROM:TO, which maps the outcomes.")
    state = scenario.start()
    forces = {border: finder.find(state, given, border=border) for border in Border}
    names = arguments.gradient or ()
    gradient = critical_force_gradient(finder, state, names, parameters=given) if names else {}
    notices = finder.simulator.mechanism.outline.truncation_notices
    if arguments.json:
        print_json(_data(scenario, finder, forces, gradient) | notices_data(notices))
    else:
        _show(scenario, finder, forces, gradient)
        show_notices(notices)
    return 0


def _finder(scenario: Scenario) -> CriticalForceFinder:
    law = scenario.contact_law()
    if isinstance(law, Mapping):
        raise InputError(
            f"--law {law.name}: a critical force is that of one contact. Fix: choose one "
            "(--contact) of several, and name one law."
        )
    if not law.is_compliant:
        raise InputError(
            f"--law {law.name}: a rigid contact has no initial force. Fix: name a compliant law."
        )
    return CriticalForceFinder(Simulator(scenario.mechanism(), law, scenario.engine))


def _data(
    scenario: Scenario,
    finder: CriticalForceFinder,
    forces: dict[Border, CriticalForce],
    gradient: dict[str, ForceDerivative],
) -> dict[str, Any]:
    simulator = finder.simulator
    sliding = forces[Border.SLIP_STOP].sliding
    terms = dict(zip(("limit", "first", "second"), sliding.expansion, strict=True))
    data: dict[str, Any] = {
        "mechanism": simulator.mechanism.name,
        "law": simulator.contact_law.name,
        "state": dict(scenario.start()),
        "parameters": simulator.parameters({**scenario.parameters, **scenario.law_parameters}),
        "sliding": sliding.to_dict(),
        "expansion": terms,
        "critical": {border.value: force.to_dict() for border, force in forces.items()},
    }
    if gradient:
        data["gradient"] = {
            name: plain_fields(g, "value", "error", "method") for name, g in gradient.items()
        }
    return data


def _show(
    scenario: Scenario,
    finder: CriticalForceFinder,
    forces: dict[Border, CriticalForce],
    gradient: dict[str, ForceDerivative],
) -> None:
    _show_case(scenario, finder, {})
    sliding = forces[Border.SLIP_STOP].sliding
    show()
    show(f"A = {quantity(sliding.A, '1/kg')}, B = {quantity(sliding.B, 'm/s^2')}: indeterminate")
    show(
        f"sliding solution F_n* = -B/A = {quantity(sliding.force, 'N', 9)}, rising by "
        f"{quantity(sliding.force_rate, 'N/s')}"
    )
    show(
        f"compression {quantity(sliding.compression, 'm')}; a deviation grows with "
        f"{quantity(sliding.growth_rate, '1/s', 9)}, decays with "
        f"{quantity(sliding.decay_rate, '1/s', 9)}"
    )
    show()
    rows = [
        (number(force.value, 15), number(force.tolerance_effect, 1), _BORDERS[border])
        for border, force in forces.items()
    ]
    show_table(("critical force [N]", "+-", "least initial force from which"), rows, left=(2,))
    first = sliding.expansion
    if sliding.approach == 0:
        parts = " + ".join(number(term, 9) for term in first if term == term)
        total = sum(term for term in first if term == term)
        show(
            "expansion F_n* + F_n*'/lambda + c/lambda^2: "
            f"{parts.replace('+ -', '- ')} = {number(total, 9)} N"
        )
    else:
        predicted = quantity(sliding.predicted_force, "N")
        show(f"closed form with A and B held, approach included: {predicted}")
    if gradient:
        show()
        units = finder.simulator.units
        table = [
            (g.name, number(g.value, 9), number(g.error, 1), _per(units[g.name]))
            for g in gradient.values()
        ]
        show_table(("derivative by", "value", "+-", "unit"), table, left=(0, 3))


def _per(unit: str) -> str:
    return "N" if unit == "1" else f"N per {unit}"


def _show_case(scenario: Scenario, finder: CriticalForceFinder, drop: dict[str, float]) -> None:
    simulator = finder.simulator
    values = simulator.parameters({**scenario.parameters, **scenario.law_parameters})
    values = {n: v for n, v in values.items() if n not in drop}
    show(f"{simulator.mechanism.name} with {assignments(values, simulator.units)}")
    show_start(simulator.mechanism, scenario, drop)


# ---- the map ----


def _map(
    arguments: argparse.Namespace,
    scenario: Scenario,
    finder: CriticalForceFinder,
    given: dict[str, float],
    files: list[Path],
    look: dict[str, Any],
) -> int:
    if arguments.gradient is not None:
        raise InputError("--gradient: goes without --over, at one state.")
    over, equals, text = (part.strip() for part in arguments.over.partition("="))
    if not (over and equals) or "," in text:
        raise InputError(
            f"--over: got {arguments.over!r}, need one quantity with its ends, NAME=FROM:TO, such "
            "as E=1e10:1e14."
        )
    options = {"parameters": given, **given_options(arguments, "forces", "points")}
    unit = unit_for("--over", over, text, lambda: finder.simulator.units)
    ends = read_range(f"--over {over}", text, unit)
    outcomes = outcome_map(finder, scenario.start(), over, ends, **options)

    def show_text() -> None:
        _show_case(scenario, finder, {over: 0.0})
        _show_map(outcomes)

    shown = None if arguments.json else show_text
    notices = scenario.mechanism().outline.truncation_notices
    deliver_map(outcomes, files, "outcome_figure", look, shown, notices)
    return 0


def _show_map(outcomes: OutcomeMap) -> None:
    show()
    total = outcomes.outcome.size
    rows = [(n, f"{100 * c / total:.2f} %") for n, c in outcomes.counts.items() if c]
    show_table(("outcome", "points"), rows)
    show()
    every = max(1, -(-len(outcomes.values) // PRINTED_ROWS))
    table = [
        [number(v, 9) if v == v else "none" for v in row]
        for row in outcomes.columns[::every].tolist()
    ]
    unit = "" if outcomes.unit == "1" else f" [{outcomes.unit}]"
    head = (f"{outcomes.over}{unit}", "F_n* [N]", "closed form", *(b.value for b in Border))
    show_table(head, table, left=())
    if every > 1:
        show(f"every {every}th of {len(outcomes.values)}")
