"""The commands that compute an impact or a motion from a state: jump, simulate."""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from painleve_sym.at.inputs import border_notices
from painleve_sym.at.jump import JumpResult
from painleve_sym.at.tangential import TangentialImpact
from painleve_sym.choices import ImpactFriction
from painleve_sym.cli.case import read_case
from painleve_sym.cli.corrected import corrected_data, show_corrected
from painleve_sym.cli.options import OTHER_FORMATS, figure_file, output_file, read_look
from painleve_sym.cli.output import (
    assignments,
    draw,
    number,
    print_json,
    quantity,
    show,
    show_notices,
    show_table,
    slip_cells,
    slip_head,
    velocity_table,
)
from painleve_sym.contact_rows import axis_names
from painleve_sym.errors import InputError, PainleveWarning, StopReason
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.singular_limit import LimitKind
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.plain_data import plain_fields
from painleve_sym.quantities import counted
from painleve_sym.study.changes import inputs_text, phases_text
from painleve_sym.study.scenario import Scenario

if TYPE_CHECKING:
    from painleve_sym.motion.finite_stiffness import CorrectedJump

EXIT_DOUBTFUL = 3
ORDINARY = (StopReason.T_END, StopReason.UNTIL, StopReason.LEFT_DOMAIN)
SHOWN_EVENTS = 40
MANY = 12
"""Parameters, of which those that are 0 are left out where there are more."""
WIDE = 8
"""Velocities, which are rows where there are more."""
_WRITTEN = {"save": "saved", "plot": "plotted", "report": "report"}


def show_case(
    mechanism: Mechanism,
    scenario: Scenario,
    parameters: Mapping[str, float] | None = None,
    leave_out: Collection[str] = (),
) -> None:
    """Print the subject of the command: the mechanism, its parameters and the state."""
    if scenario.title:
        show(scenario.title)
    if scenario.material:
        show(f"material {scenario.material}")
    values = dict(parameters or {**mechanism.parameters, **scenario.parameters})
    others = ""
    if len(values) > MANY:
        values, others = {n: v for n, v in values.items() if v}, " (others 0)"
    show(f"{mechanism.name} with {assignments(values, mechanism.units)}{others}")
    show_start(mechanism, scenario, leave_out)


def show_start(mechanism: Mechanism, scenario: Scenario, leave_out: Collection[str] = ()) -> None:
    """Print the state, and whether it is the mechanism's own start."""
    start = {k: v for k, v in scenario.start().items() if v != 0 and k not in leave_out}
    others = "all 0" if not start else "others 0"
    given = scenario.state is not None or scenario.contact_velocity is not None
    own = "" if given else ", the mechanism's own start"
    text = f"at {assignments(start, mechanism.state_units)} ({others}){own}"
    show(text.replace("at  (", "at ("))


# ---- jump ----


def jump(arguments: argparse.Namespace) -> int:
    """Print the phases of the velocity jump, and with a law those at its stiffness."""
    scenario = read_case(arguments)
    impact = scenario.jump()
    if isinstance(impact, TangentialImpact):
        if arguments.json:
            print_json(impact.to_dict())
            return 0
        show_case(scenario.mechanism(), scenario)
        _show_tangential_impact(impact, scenario.mechanism().state_units)
        return 0
    corrected = scenario.corrected_jump(arguments.configuration)
    if corrected is None and (arguments.initial_force or arguments.configuration != "frozen"):
        raise InputError(
            "jump: --initial-force and --configuration need a compliant contact. "
            "Fix: name its law, such as --law bilinear-hertz."
        )
    of_state = scenario.mechanism().notices + border_notices(scenario.place)
    if arguments.json:
        data = jump_data(impact)
        if corrected is not None:
            data["corrected"] = corrected_data(corrected)
            data["notices"] += _rigidity(scenario, corrected)
        data["notices"] += of_state
        print_json(data)
        return 0
    # Many velocities stand in the table alone.
    before = impact.velocity_before
    hidden = before if len(before) > WIDE else ()
    show_case(scenario.mechanism(), scenario, leave_out=hidden)
    _show_jump(impact, scenario)
    if corrected is not None:
        show_corrected(corrected, impact, scenario.mechanism().state_units)
        for notice in _rigidity(scenario, corrected):
            show(notice)
    show_notices(of_state)
    return 0


def _rigidity(scenario: Scenario, corrected: CorrectedJump) -> tuple[str, ...]:
    """Return sentences on bodies that are not rigid in an impact that ends."""
    ends = corrected.end == "separation"
    return scenario.rigidity_notices(corrected.duration) if ends else ()


def jump_data(impact: JumpResult) -> dict[str, Any]:
    """Return a jump as plain data with the documented keys."""
    return {
        "mechanism": impact.mechanism,
        "rule": impact.restitution,
        "impact_friction": impact.impact_friction,
        **plain_fields(impact, "slip_velocity", "case", "end", "phases"),
        "initial": {"velocity": dict(impact.velocity_before)},
        "final": {"velocity": dict(impact.velocity)},
        **plain_fields(impact, "energy_change", "kinetic_energy"),
        "notices": [impact.notice] if impact.notice else [],
    }


_OPPOSED = {
    ImpactFriction.PATH: "friction opposes the slip of each moment (impact_friction path)",
    ImpactFriction.FINAL_SLIP: "friction opposes the slip after it (impact_friction final_slip)",
}


def _show_jump(impact: JumpResult, scenario: Scenario) -> None:
    from painleve_sym.laws.restitution import restitution_law

    rule = restitution_law(impact.restitution)
    value = scenario.coefficient_of(rule)
    show(f"{rule.title}, {rule.parameter.name} = {number(value)}")
    show(_OPPOSED[impact.impact_friction])
    show()
    tangents = len(impact.slip_velocity)
    impulses = (f"P_{axis} [N s]" for axis in axis_names(tangents))
    head = ("phase", *impulses, "stored [J]", *slip_head(tangents))
    rows = [
        (p.name, *map(number, p.impulse), number(p.stored_energy), *slip_cells(p.direction))
        for p in impact.phases
    ]
    show_table(head, rows)
    show()
    show("velocities at the end of each phase")
    units = scenario.mechanism().state_units
    courses = [("before", impact.velocity_before), *((p.name, p.velocity) for p in impact.phases)]
    sizes = {n: max(abs(v[n]) for _, v in courses) for n in impact.velocity}
    table = velocity_table(courses, units, sizes=sizes)
    if len(sizes) > WIDE:
        table = list(zip(*table, strict=True))
    show_table(table[0], table[1:])
    show()
    show(f"course {impact.case.value}, ends in {impact.end.value}")
    if impact.end.value == "jam":
        show("The impulse of a rigid contact has no end here. A compliant contact has a solution.")
    show(f"energy change {quantity(impact.energy_change, 'J')}")
    if impact.notice:
        show(f"{impact.notice} That law is {rule.note}.")


def _show_tangential_impact(impact: TangentialImpact, units: dict[str, str]) -> None:
    """Print the impulse that stops the slip and the velocities around it."""
    show("tangential impact: the slip stops at once, the normal velocity stays 0")
    show()
    impulses = (number(impact.normal_impulse), *map(number, impact.tangential_impulse))
    show_table(("P_n [N s]", "P_t [N s]"), [impulses], left=())
    show()
    courses = [("before", impact.velocity_before), ("after", impact.velocity)]
    table = velocity_table(courses, units)
    show_table(table[0], table[1:])
    show()
    show(f"case before: {impact.case.value} ({impact.case.sentence})")
    show(f"energy change {quantity(impact.energy_change, 'J')}")


# ---- simulate ----


def simulate(arguments: argparse.Namespace) -> int:
    """Integrate the motion and print its events and its end."""
    look = read_look(arguments)
    files = _output_files(arguments, look)
    scenario = read_case(arguments)
    trajectory = scenario.simulate()
    written = _write_files(files, trajectory, scenario, look)
    if arguments.json:
        print_json(simulation_data(trajectory, scenario, written))
    else:
        _show_run(trajectory, scenario, written)
    return exit_code(trajectory)


def exit_code(trajectory: Trajectory) -> int:
    """Return 3 where a run stopped early, or its energy balance does not close."""
    sound = trajectory.stop_reason in ORDINARY and trajectory.energy_closes is not False
    return 0 if sound else EXIT_DOUBTFUL


def _output_files(arguments: argparse.Namespace, look: Mapping[str, Any]) -> dict[str, Path]:
    files = {}
    if arguments.save is not None:
        files["save"] = output_file("--save", arguments.save)
        if files["save"].suffix.lower() in OTHER_FORMATS:
            raise InputError(
                f"--save: got {arguments.save}, need a name ending in .npz, the format written."
            )
    if arguments.plot is not None:
        files["plot"] = figure_file("--plot", arguments.plot, look)
    if arguments.report is not None:
        files["report"] = output_file("--report", arguments.report, (".html",))
    return files


def _write_files(
    files: Mapping[str, Path], trajectory: Trajectory, scenario: Scenario, look: Mapping[str, Any]
) -> dict[str, str]:
    written = {}
    if "save" in files:
        trajectory.save(files["save"])
        written["save"] = str(files["save"])
    if "plot" in files and not len(trajectory.step_time):
        warnings.warn("nothing to plot: no step was taken.", PainleveWarning, stacklevel=2)
    elif "plot" in files:
        draw("trajectory_figure", files["plot"], look, trajectory)
        written["plot"] = str(files["plot"])
    if "report" in files:
        from painleve_sym.present.run_page import run_page

        run_page(scenario, trajectory).write(files["report"])
        written["report"] = str(files["report"])
    return written


def simulation_data(
    trajectory: Trajectory, scenario: Scenario, written: Mapping[str, str]
) -> dict[str, Any]:
    """Return a motion as plain data: `Trajectory.to_dict`, what made it, and its samples."""
    data = {
        **plain_fields(trajectory, "mechanism", "law", "choices", "parameters"),
        **trajectory.to_dict(),
        "rtol": trajectory.rtol,
        **{n: v for n, v in trajectory.inputs.items() if n in ("phases", "inputs")},
    }
    if scenario.samples is not None:
        data["samples"] = samples(trajectory, scenario.samples)
    if written:
        data["files"] = dict(written)
    return data


def samples(trajectory: Trajectory, count: int) -> dict[str, Any]:
    """Return states and outputs at `count` evenly spaced times, each of shape (count,).

    Without any step there is one time, the end.
    """
    if not len(trajectory.step_time):
        final = {name: [value] for name, value in trajectory.final.items()}
        outputs = {name: [value] for name, value in trajectory.final_outputs.items()}
        return {"time": [trajectory.final_time], "state": final, **outputs}
    times = trajectory.sample(count)
    states = dict(zip(trajectory.state_names, trajectory(times).T, strict=True))
    return {"time": times, "state": states, **trajectory.outputs(times)}


def _show_run(trajectory: Trajectory, scenario: Scenario, written: Mapping[str, str]) -> None:
    mechanism, law = scenario.mechanism(), scenario.contact_law()
    own = {p.name: p.input_of for p in mechanism.outline.parameters}
    values = {n: v for n, v in trajectory.parameters.items() if own.get(n) not in scenario.inputs}
    show_case(mechanism, scenario, {k: v for k, v in values.items() if k in own})
    if scenario.inputs:
        show(f"inputs {inputs_text(scenario.inputs)}")
    if scenario.phases:
        show(f"phases {phases_text(scenario.phases)}")
    units = trajectory.names.units
    choices = "".join(f" ({name} {value})" for name, value in trajectory.choices.items())
    of_law = assignments({k: v for k, v in values.items() if k not in own}, units)
    show(f"law {law.name}{choices}" + (f" with {of_law}" if of_law else ""))
    show()
    _show_events(trajectory)
    _show_end(trajectory, mechanism.state_units)
    if scenario.samples is not None:
        _show_samples(samples(trajectory, scenario.samples), trajectory)
    for name, path in written.items():
        show(f"{_WRITTEN[name]}: {path}")


def _show_events(trajectory: Trajectory) -> None:
    events = trajectory.events_above_tolerance
    folded = len(trajectory.events) - len(events)
    if not events:
        show(f"{counted(folded, 'event')} below the tolerance" if folded else "no events")
        return
    half = SHOWN_EVENTS // 2
    hidden = max(0, len(events) - SHOWN_EVENTS)
    shown = events if not hidden else [*events[:half], *events[-half:]]
    several = len({e.contact for e in shown}) > 1
    above = trajectory.above_tolerance
    rows = [
        (
            number(e.time, 9),
            f"{e.kind} {e.contact}" if several and e.contact else e.kind,
            e.mode_after,
            number(above("normal_force", e.normal_force)),
            number(above("gap", e.compression, e.contact)),
        )
        for e in shown
    ]
    if hidden:
        rows.insert(half, ("...", f"{hidden} more", "", "", ""))
    head = ("time [s]", "event", "mode after", "F_n [N]", "depth [m]")
    show_table(head, rows, left=(1, 2), indent=0)
    if folded:
        show(f"and {counted(folded, 'event')} below the tolerance")


def ending(trajectory: Trajectory) -> str:
    """Return a sentence on when and why a motion ended."""
    reason, time = trajectory.stop_reason, f"t = {number(trajectory.final_time, 9)} s"
    text = trajectory.stop_detail or reason.sentence
    if reason is StopReason.T_END:
        return f"reached the end time {time}"
    if reason is StopReason.UNTIL:
        if text.startswith("before "):
            return f"ended at {time} {text}"
        asked = trajectory.inputs["options"]["until"] if trajectory.inputs else ()
        kinds = [e.kind for e in trajectory.events if e.kind in asked or not asked]
        return f"ended at {time} by {kinds[-1] if kinds else reason.label}"
    if reason is StopReason.LEFT_DOMAIN:
        return f"ended at {time}: {text}"
    return f"stopped at {time}: {reason.label} ({text})"


def _show_end(trajectory: Trajectory, units: Mapping[str, str]) -> None:
    show()
    show(ending(trajectory))
    final = {n: v for n, v in trajectory.final.items() if n in units}
    above = trajectory.above_tolerance
    rows = [(n, number(above(n, v), 9), units[n]) for n, v in final.items()]
    forces = trajectory.final_forces
    rows += [(n, number(above(n, v), 9), "N") for n, v in forces.items()]
    show_table(("state", "value", "unit"), rows, left=(0, 2))
    _show_findings(trajectory, units)
    residual = trajectory.energy_residual
    closes = f", relative energy error {number(residual, 2)}" if trajectory.energy_closes else ""
    show(
        f"{counted(trajectory.counters['accepted_steps'], 'step')}, "
        f"{counted(len(trajectory.events), 'event')}, "
        f"rtol {number(trajectory.rtol)}{closes}, engine {trajectory.engine}"
    )


def _show_findings(trajectory: Trajectory, units: Mapping[str, str]) -> None:
    """Print where energy is gained, where a slip runs into A = 0, and which bounces grow."""
    for notice in trajectory.notices:
        show(notice)
    for c in trajectory.reverse_chatter:
        show(
            f"reverse chatter: {c.bounces} bounces grow from t = {number(c.start_time, 9)} s to "
            f"{number(c.end_time, 9)} s by {number(c.ratio)} each (expected "
            f"{number(c.expected_ratio)})"
        )
    limit = trajectory.limit
    if limit is None or limit.kind is LimitKind.STOP:
        return
    state = {n: v for n, v in limit.state.items() if n in units}
    measured = limit.measured_exponent
    seen = "" if measured is None else f" (measured {number(measured)})"
    grows = (
        f"grows like (t* - t)^-{number(limit.force_exponent)}{seen}"
        if limit.kind is LimitKind.DYNAMIC_JAM
        else "stays bounded"
    )
    show(f"A = B = 0 is reached at t* = {number(limit.time, 12)} s: F_n {grows}")
    show(f"  there {assignments(state, units)}")
    show(f"  bounded force F* = {quantity(limit.bounded_force, 'N')}")


def _show_samples(data: Mapping[str, Any], trajectory: Trajectory) -> None:
    show()
    ends = [name.removeprefix("gap_rate") for name in data if name.startswith("gap_rate")]
    for end in ends:
        if end:
            show(f"contact {end.removeprefix('_')}")
        titles = {
            f"gap{end}": "gap [m]",
            f"slip_velocity{end}": "slip [m/s]",
            f"gap_rate{end}": "normal [m/s]",
            f"normal_force{end}": "F_n [N]",
            f"tangential_force{end}": "F_t [N]",
        }
        columns = [[number(float(t)) for t in data["time"]]]
        above = trajectory.above_tolerance
        columns += [[number(above(n, float(v))) for v in data[n]] for n in titles]
        cells = list(zip(*columns, strict=True))
        show_table(["time [s]", *titles.values()], cells, left=(), indent=0)
