"""The command contrast: one state, every method, side by side."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from painleve_sym.cli.case import read_case
from painleve_sym.cli.options import figure_file, read_look
from painleve_sym.cli.output import (
    assignments,
    draw,
    notices_data,
    number,
    print_json,
    show,
    show_notices,
    show_table,
)
from painleve_sym.cli.run import show_case
from painleve_sym.contact_rows import axis_names
from painleve_sym.plain_data import finite, plain_fields, to_plain
from painleve_sym.problem.impact.one_contact import ImpactEnd
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.solution import ContactCase, ContactSolution
from painleve_sym.study.comparisons import comparison as study
from painleve_sym.study.comparisons.case import Answer
from painleve_sym.study.comparisons.comparison import Comparison

_OPEN = "open or closing, so there is no contact problem of accelerations"
_Columns = tuple[list[str], Callable[[Answer], list[str]]]
"""Heads of columns of a table, and their cells for an answer."""


def contrast(arguments: argparse.Namespace) -> int:
    """Print what every method makes of a state; draw it where a file is named."""
    look = read_look(arguments)
    out = None if arguments.out is None else figure_file("--out", arguments.out, look)
    scenario = read_case(arguments)
    options = {name: getattr(arguments, name) for name in ("steps", "stiffness", "solvers")}
    options |= {"t_end": scenario.t_end, "e": scenario.restitution}
    given = {name: value for name, value in options.items() if value is not None}
    mechanism = scenario.mechanism()
    comparison = study.compare(
        mechanism, scenario.start(), parameters=scenario.parameters, engine="auto", **given
    )
    if out is not None:
        draw("contrast_figure", out, look, comparison)
    notices = scenario.contact_notices
    if arguments.json:
        files = {} if out is None else {"files": {"out": out}}
        print_json(contrast_data(comparison) | notices_data(notices) | files)
        return 0
    show_case(mechanism, scenario, comparison.parameters)
    _show(comparison, mechanism.state_units)
    show()
    _show_orders(comparison)
    _show_findings(comparison)
    show_notices(notices)
    if out is not None:
        show(f"drawn: {out}")
    return 0


# ---- JSON ----


def contrast_data(comparison: Comparison) -> dict[str, Any]:
    """Return plain data with the documented keys."""
    return {
        **plain_fields(comparison, "mechanism", "frozen", "state", "parameters"),
        "restitution": comparison.e,
        "t_end": comparison.t_end,
        "acceleration_level": _acceleration_data(comparison),
        "velocity_level": [
            {"step": first.step, "solutions": [_step_data(s) for s in first.solutions]}
            for first in comparison.first_steps
        ],
        "rigid": {
            "motions": [
                {"way": a.way, **_motion_data(a), "limit": to_plain(a.limit)}
                for a in comparison.rigid
            ],
            "jump": {
                name: plain_fields(jump, "velocity", "normal_impulse", "end")
                for name, jump in comparison.jumps.items()
            },
        },
        "stepping": [_stepping_data(a) for a in comparison.stepping],
        "softened": [
            {"E": a.setting, "peak_force": a.peak_force, **_motion_data(a)}
            for a in comparison.softened
        ],
        "orders": {
            "step": {way: list(map(finite, p)) for way, p in comparison.step_orders.items()},
            "stiffness": list(map(finite, comparison.stiffness_orders)),
            "stiffness_expected": finite(comparison.expected_stiffness_order),
        },
        **plain_fields(comparison, "plastic_jump_unnoticed", "solver_dependent", "steps_miss_turn"),
    }


def _step_data(solution: ContactSolution) -> dict[str, Any]:
    return {
        "mode": solution.mode.value,
        "normal_impulse": solution.normal_force,
        "tangential_impulse": solution.tangential_forces.tolist(),
        "slip_velocity": solution.tangential_accelerations.tolist(),
    }


def _acceleration_data(comparison: Comparison) -> dict[str, Any] | None:
    level = comparison.acceleration_level
    if level is None:
        return None
    whole = level.classification.to_dict()
    solution = None if level.lemke is None else level.lemke.solution
    return {
        **{key: whole[key] for key in ("contacts", "case", "solutions")},
        "lemke": level.lemke
        and {
            "status": level.lemke.status.label,
            "normal_force": None if solution is None else float(solution.z[0]),
        },
        "mpcc": level.mpcc
        and {
            "normal_forces": sorted(float(r.z[0]) for r in level.mpcc.solutions),
            **plain_fields(level.mpcc, "starts", "failed"),
        },
    }


def _motion_data(answer: Answer) -> dict[str, Any]:
    data = {
        "events": [{"time": time, "kind": kind} for time, kind in answer.events],
        "stop_reason": answer.stop_reason.label,
        **plain_fields(answer, "stop_detail", "complete"),
        "time": answer.final_time,
        **plain_fields(answer, "state", "velocity", "normal_impulse"),
        "tangential_impulse": list(answer.impulse[1:]),
        "contact_velocity": answer.contact_velocity.tolist(),
    }
    if answer.method != "rigid":
        data["reference"] = answer.reference or None
        data["error"] = finite(answer.error)
    return data


def _stepping_data(answer: Answer) -> dict[str, Any]:
    data = _motion_data(answer)
    del data["events"]
    return {
        "step": answer.setting,
        "solver": answer.way,
        **data,
        "solutions_per_first_step": answer.solutions_first_step,
        "first_mode": answer.first_mode,
        "first_impulse": finite(answer.first_impulse),
    }


# ---- text ----


def _show(comparison: Comparison, units: dict[str, str]) -> None:
    frozen = comparison.frozen
    note = "; the configuration, and so W and b, is frozen" if frozen else ""
    show(f"e = {number(comparison.e)}{note}")
    show()
    _show_accelerations(comparison)
    _show_first_steps(comparison)
    if not frozen:  # else the rigid motions are these jumps
        _show_jumps(comparison, units)
    show()
    rigid = _distinct(comparison.rigid)
    answers = [*rigid, *comparison.stepping, *comparison.softened]
    head, cells = _contact_columns(answers) if frozen else _velocity_columns(comparison, units)
    rows = [[_name(a), _marked(a), *cells(a), _finite(a.error, 2)] for a in answers]
    show_table(("method", "setting", *head, "error"), rows, left=(0, 1), indent=0)
    _show_early(answers, units)
    show("error: relative distance to the rigid motion it tends to, by kinetic energy")
    if frozen and rigid:
        _show_all_velocities(comparison, [*rigid, *comparison.softened[-1:]], units)


def _velocity_columns(comparison: Comparison, units: dict[str, str]) -> _Columns:
    """Say which velocities follow, those at the end time; return their columns."""
    names = list(comparison.rigid[0].velocity)
    listed = ", ".join(f"{n} in {units[n]}" for n in names)
    show(f"velocities at t = {number(comparison.t_end)} s: {listed}; impulse P_n in N s")
    show("rigid motion first, by its restitution and policy")

    def cells(answer: Answer) -> list[str]:
        return [*(_short(answer.velocity[n]) for n in names), number(answer.normal_impulse, 5)]

    return [*names, "P_n"], cells


def _contact_columns(answers: list[Answer]) -> _Columns:
    """Say which velocities follow, those of the contact after the impact; return their columns."""
    show("contact after the impact: velocities in m/s, P_n in N s, time in s, largest force in N")
    axes = axis_names(answers[0].contact_velocities.shape[1] - 1)
    return [*(f"v_{axis}" for axis in axes), "P_n", "time", "force"], _contact_cells


def _contact_cells(answer: Answer) -> list[str]:
    speeds = answer.contact_velocities[-1].tolist()
    size = float(np.abs(answer.contact_velocities).max())
    return [
        number(speeds[0], 5, size),
        *(number(v, 4, size) for v in speeds[1:]),
        number(answer.normal_impulse, 5),
        number(answer.final_time, 4),
        _finite(answer.peak_force, 4),
    ]


def _finite(value: float, digits: int) -> str:
    return number(value, digits) if math.isfinite(value) else ""


def _show_all_velocities(
    comparison: Comparison, answers: list[Answer], units: dict[str, str]
) -> None:
    """Print the velocities of all coordinates, a column for each answer."""
    show()
    show("all velocities")
    rows = [
        (
            f"{n} [{units[n]}]",
            number(comparison.state[n]),
            *(_short(a.velocity[n]) for a in answers),
        )
        for n in answers[0].velocity
    ]
    named = [_name(a) if a.method == "rigid" else _setting(a) for a in answers]
    show_table(("", "before", *named), rows)


def _marked(answer: Answer) -> str:
    """Return the setting, or why a rigid motion ended; with a star where it ended early."""
    setting = _setting(answer)
    return setting if answer.complete else f"{setting or answer.stop_reason.label} *"


def _short(value: float) -> str:
    # The round-off of an exact zero carries no information and fills the column.
    return number(0.0 if abs(value) < 1e-14 else value, 5)


def _distinct(rigid: tuple[Answer, ...]) -> list[Answer]:
    shown: list[Answer] = []
    for answer in rigid:
        if not any(answer.same_end(other) for other in shown):
            shown.append(answer)
    return shown


def _setting(answer: Answer) -> str:
    letter = {"rigid": "", "stepping": "h", "softened": "E"}[answer.method]
    return f"{letter} {number(answer.setting, 4)}" if letter else ""


def _name(answer: Answer) -> str:
    return "compliant" if answer.method == "softened" else answer.way.replace(",", "")


def _show_early(answers: list[Answer], units: dict[str, str]) -> None:
    """Say when, where and why motions ended before the end time: a paragraph for each reason."""
    early = [a for a in answers if not a.complete]
    for label, detail in dict.fromkeys((a.stop_reason.label, a.stop_detail) for a in early):
        show(f"*) ended early ({label}): {detail}")
        same = [a for a in early if (a.stop_reason.label, a.stop_detail) == (label, detail)]
        for name in dict.fromkeys(map(_name, same)):
            ends = dict.fromkeys(_end(a, units) for a in same if _name(a) == name)
            show(f"   {name} at t = {', '.join(ends)}")


def _end(answer: Answer, units: dict[str, str]) -> str:
    time = f"{number(answer.final_time, 3)} s"
    if answer.method != "rigid":
        return f"{time} ({_setting(answer)})"
    limit = answer.limit
    arrival = "" if limit is None else f"; A = 0 is met at t = {number(limit.time)} s"
    return f"{time}, {assignments(answer.state, units)}{arrival}"


def _show_accelerations(comparison: Comparison) -> None:
    level = comparison.acceleration_level
    if level is None:
        show(f"accelerations: the contact is {_OPEN}")
        return
    listed = ", ".join(map(_force, level.classification.solutions))
    show(f"accelerations: {level.classification.case.value}; solutions: {listed or 'none'}")
    if level.lemke is None or level.mpcc is None:
        return
    solution = level.lemke.solution
    lemke = "" if solution is None else f", F_n = {number(float(solution.z[0]))} N"
    forces = sorted(float(r.z[0]) for r in level.mpcc.solutions)
    several = ", ".join(number(f) for f in forces)
    show(
        f"  Lemke: {level.lemke.status.label}{lemke}; MPCC from {level.mpcc.starts} starts: "
        + (f"F_n = {several} N" if forces else "no solution")
        + (f" ({level.mpcc.failed} failed)" if level.mpcc.failed else "")
    )


def _show_first_steps(comparison: Comparison) -> None:
    for first in comparison.first_steps:
        listed = ", ".join(map(_impulse, first.solutions))
        show(f"velocities after one step of {number(first.step)} s: {listed or 'none'}")


def _force(solution: ContactSolution) -> str:
    return f"{solution.mode.value} with F_n = {number(solution.normal_force)} N"


def _impulse(solution: ContactSolution) -> str:
    text = f"{solution.mode.value} with P_n = {number(solution.normal_force)} N s"
    slip = solution.tangential_accelerations
    if len(slip) > 1 and solution.mode is not ContactMode.STICK:
        size = float(np.abs(solution.acceleration).max())
        slips = ", ".join(number(v, size=size) for v in slip.tolist())
        text += f" and slip ({slips}) m/s"
    return text


def _show_jumps(comparison: Comparison, units: dict[str, str]) -> None:
    for name, jump in comparison.jumps.items():
        if name == "plastic" and comparison.e == 0:
            continue  # it is the one before
        e = 0.0 if name == "plastic" else comparison.e
        after = assignments(jump.velocity, units)
        impulse = f"P_n = {number(jump.normal_impulse)} N s"
        known = comparison.acceleration_level
        several = known and known.classification.case is ContactCase.INDETERMINATE
        subject = "rigid jump, if one is set off," if several else "rigid jump"
        if jump.end is ImpactEnd.JAM:
            after = f"jams at {after}"
            impulse += ", from where its impulse has no end"
        show(f"{subject} with e = {number(e)}: {after}, {impulse}")


def _show_orders(comparison: Comparison) -> None:
    for way, orders in comparison.step_orders.items():
        if any(map(math.isfinite, orders)):
            show(f"order in the step, {way}: {_listed(orders)}")
    if any(map(math.isfinite, comparison.stiffness_orders)):
        expected = comparison.expected_stiffness_order
        limit = f" (an impact tends to {number(expected, 3)})" if math.isfinite(expected) else ""
        show(f"order in E: {_listed(comparison.stiffness_orders)}{limit}")


def _listed(orders: tuple[float, ...]) -> str:
    return ", ".join(number(p, 4) if math.isfinite(p) else "-" for p in orders)


def _show_findings(comparison: Comparison) -> None:
    if comparison.plastic_jump_unnoticed:
        show(
            "Time stepping meets no paradox: each first step has one solution, the jump to rest in "
            "contact (e = 0). The approach speed is 0, so Newton's restitution changes nothing."
        )
    if comparison.solver_dependent:
        taken: dict[str, list[str]] = {}
        for answer in comparison.stepping:
            taken.setdefault(answer.way, []).append(answer.first_mode or "none")
        listed = "; ".join(
            f"{way}: {modes[0] if len(set(modes)) == 1 else ', '.join(modes)}"
            for way, modes in taken.items()
        )
        steps = ", ".join(number(h) for h in dict.fromkeys(a.setting for a in comparison.stepping))
        show(f"The answer of time stepping depends on the solver (h = {steps} s): {listed}.")
    if comparison.steps_miss_turn:
        least = min(a.error for a in comparison.stepping if math.isfinite(a.error))
        show(
            "A time step has the friction of its last slip. In the impact the slip turns, so that "
            f"no step, however short, comes nearer to the jump than about {number(least, 2)}."
        )
    if comparison.impact_without_collision:
        show("Compliant motion tends to the rigid jump with e: the compression stores the energy.")
    if comparison.jams:
        show("The rigid jump jams, so that no rigid motion follows: only compliant motion does.")
