"""The texts of an export: header, mode functions, start states, example, expected output, CMake."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sized
from dataclasses import dataclass, field
from functools import cached_property
from importlib import resources
from string import Template
from typing import Any

from painleve_sym.arrays import Array
from painleve_sym.automata.signature import Outline
from painleve_sym.c_export.contacts import CASES, contact_values
from painleve_sym.c_export.text import described, enum, identifiers, meaning_and_unit, prose
from painleve_sym.codegen.compile import FLAGS, Compiler
from painleve_sym.engines.c_texts import initializer
from painleve_sym.engines.compiled import CompiledEngine, EngineCode
from painleve_sym.engines.protocol import BEFORE, DEFAULT_RTOL, ENGINE_REASONS, Places, RunOptions
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.escape import c_comment, c_name, c_string, markdown_text, one_line
from painleve_sym.mechanics.declarations import TIME_NAME, Parameter
from painleve_sym.motion.continuation import SMALL
from painleve_sym.motion.refusals import initial_force_fault
from painleve_sym.motion.run_record import RunRecord
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.version import __version__

_LIBRARY_ONLY = ("-fPIC", "-shared", "-fvisibility=hidden")
NUMERIC_FLAGS = tuple(flag for flag in FLAGS if flag not in _LIBRARY_ONLY)
"""The package's flags that decide the numbers; the others only make a library of the code."""


def filled(template: str, values: Mapping[str, Any]) -> str:
    """Return the named template (a file in ``templates``) with `values` inserted."""
    folder = resources.files(__package__).joinpath("templates")
    text = Template(folder.joinpath(template).read_text("utf-8")).substitute(values)
    return "\n".join(line.rstrip() for line in text.split("\n")).rstrip() + "\n"


@dataclass(frozen=True)
class MotionCode:
    """One mechanism with its contact laws, to be written as C; `name` is the prefix of all C names.

    The engine is ``taylor`` or ``compiled``; comments name the compiler. The inputs are parameters
    that a caller gives for each piece of a motion.
    """

    name: str
    simulator: Simulator
    engine_name: str
    compiler: Compiler
    inputs: tuple[str, ...] = field(default=(), kw_only=True)

    @cached_property
    def code(self) -> EngineCode:
        """The C of the engine, from the cache where it is there, and the automaton's outline."""
        kind = TaylorEngine if self.engine_name == TaylorEngine.name else CompiledEngine
        return kind.code_of(self.simulator.contact, given=self.entered)

    @property
    def entered(self) -> Places:
        """Modes with memory for which there are variants, too."""
        return ()

    @property
    def outline(self) -> Outline:
        """Names and structure of the automaton."""
        return self.code.outline

    @property
    def motion_count(self) -> int:
        """Number of coordinates and velocities, and the time where it occurs."""
        return len(self.simulator.mechanism.state_names)

    @property
    def declared(self) -> dict[str, Parameter]:
        """Parameters of mechanism and law by name."""
        return self.simulator.declared.by_name

    @cached_property
    def states(self) -> dict[str, str]:
        """Meaning and unit of every state by name, in order."""
        known = {TIME_NAME: meaning_and_unit("s", "time of what moves as prescribed")}
        for c in self.simulator.mechanism.outline.coordinates:
            known[c.name] = meaning_and_unit(c.unit, c.meaning)
            known[f"{c.name}_dot"] = meaning_and_unit(f"{c.unit}/s", f"rate of {c.name}")
        return {n: known.get(n) or described(n) for n in self.outline.state_names}

    @property
    def engine(self) -> str:
        """The functions of the automaton and the event loop, in C; no name of the export."""
        return self.code.text

    @property
    def subject(self) -> str:
        """Mechanism and law."""
        law, choices = self.simulator.label, self.simulator.choices
        chosen = "".join(f", {k} {v}" for k, v in choices.items())
        return f"{self.simulator.mechanism.name} with contact law {law}{chosen}"

    @property
    def title(self) -> str:
        """Mechanism and law in a comment of C."""
        return c_comment(self.subject)

    @property
    def shared(self) -> dict[str, Any]:
        """Values that all files share."""
        name, flags = self.name, " ".join(NUMERIC_FLAGS)
        sources = f"main.c {name}_model.c {name}_contact.c"
        return {
            "name": name,
            "NAME": name.upper(),
            "title": self.title,
            "version": __version__,
            "compiler": c_comment(self.compiler.version),
            "flags": flags,
            "cc": f"cc {flags} -o {name}_example {sources} -lm",
        }


@dataclass(frozen=True)
class StartedCode(MotionCode):
    """One mechanism with its contact laws, and a start from which it moves.

    `parameters` are those of mechanism and law, `motion` coordinates and velocities at the start;
    `limits` are those of max_steps and max_events that were given.
    """

    parameters: Mapping[str, float]
    motion: Array
    t_end: float
    rtol: float
    until: tuple[str, ...]
    limits: Mapping[str, int]
    initial_force: float | None

    @property
    def option_lines(self) -> list[str]:
        """Statements of C that set limits of ``options``, and the events that end a run."""
        lines = [f"  options.{name} = {value};" for name, value in self.limits.items()]
        for kind in dict.fromkeys(k.removeprefix(BEFORE) for k in self.until):
            ends = (kind in self.until) + 2 * (BEFORE + kind in self.until)
            lines.append(f"  options.until[{self.name}_event_{c_name(kind)}] = {ends};")
        return lines


@dataclass(frozen=True)
class ExampleCode(StartedCode):
    """One mechanism with its contact laws, and the example to run.

    The trajectory is what the package computed for the example.
    """

    trajectory: Trajectory

    @property
    def entered(self) -> Places:
        """Modes and memories of the example: with them it is the package to the last bit."""
        record = self.trajectory.record
        if not self.simulator.outline.parts or not isinstance(record, RunRecord):
            return ()
        automaton = self.simulator.automaton
        moving = (at for at in record.entered if automaton.modes[at[0]].field)
        from painleve_sym.automata.variants import known_values

        return list(dict.fromkeys((i, known_values(automaton, memory)) for i, memory in moving))


def code_files(code: MotionCode) -> dict[str, str]:
    """Return the files that the motion needs, by name: interface, motion, contact problem."""
    return {
        f"{code.name}_model.h": _header(code),
        f"{code.name}_model.c": _model(code),
        f"{code.name}_contact.c": _contact(code),
    }


def files(case: ExampleCode) -> dict[str, str]:
    """Return the content of every file by name."""
    return {
        **code_files(case),
        "main.c": _main(case),
        "expected.txt": expected(case.trajectory),
        "CMakeLists.txt": filled("CMakeLists.txt", case.shared | {"title": one_line(case.subject)}),
        "README.md": filled(
            "README.md",
            case.shared
            | {"title": markdown_text(case.subject), "example": markdown_text(_example(case))},
        ),
    }


def clashing_name(case: MotionCode, texts: Mapping[str, str]) -> str | None:
    """Return a name of the interface that the engine's code has too, or None.

    Every name of the interface is in the header, and begins with the name of the export.
    """
    prefixes = (f"{case.name}_", f"{case.name.upper()}_")
    own = {n for n in identifiers(texts[f"{case.name}_model.h"]) if n.startswith(prefixes)}
    return min(own & identifiers(case.engine), default=None)


def _example(case: ExampleCode) -> str:
    mechanism = case.simulator.mechanism
    start = zip(mechanism.state_names, case.motion.tolist(), strict=True)
    given = ", ".join(f"{n} = {v!r}" for n, v in start if v != 0) or "all at 0"
    pressed = "" if case.initial_force is None else f", pressed with {case.initial_force!r} N"
    until = f" or the first {' or '.join(case.until)}" if case.until else ""
    return f"{mechanism.name} from {given}{pressed}, until t = {case.t_end!r} s{until}"


# ---- header ----


def _header(case: MotionCode) -> str:
    outline, mechanism = case.outline, case.simulator.mechanism
    memory, extra = outline.memory_names, list(case.states)[case.motion_count :]
    loads = not initial_force_fault(case.simulator)
    counts: dict[str, Sized] = {
        "states": outline.state_names,
        "parameters": outline.parameter_names,
        "inputs": case.inputs,
        "memory": memory,
        "modes": outline.modes,
        "outputs": outline.output_names,
        "events": outline.kinds,
        "stops": ENGINE_REASONS,
        "motion": mechanism.state_names,
        "contacts": mechanism.outline.contacts,
        "cases": CASES,
    }
    about = [mechanism.title, *([f"Source: {mechanism.source}"] if mechanism.source else [])]
    about += [f"Domain: {b.margin} > 0 ({b.meaning})." for b in mechanism.outline.domain]
    values = case.shared | {f"{k}_count": len(v) for k, v in counts.items()}
    return filled(
        "model.h",
        values
        | {
            "about": prose([line for line in about if line]),
            "constants_count": len(outline.constant_names),
            "enums": _enums(case),
            "memory_room": max(1, len(memory)),
            "completed": ", ".join(s + " = 0" * s.endswith("dissipation") for s in extra),
            "press": _PRESS.format(name=case.name) if loads else "",
            "contacts": _filled(_CONTACTS, case) if outline.parts else "",
            "event_contact": _EVENT_CONTACT.format(room=max(1, len(memory)), name=case.name)
            if outline.parts
            else "",
            "rtol": repr(DEFAULT_RTOL),
            "constants": ", ".join(outline.definition_names) or "here nothing more",
            "max_steps": RunOptions.max_steps,
            "max_events": RunOptions.max_events,
        },
    )


_PRESS = """\
/* Writes the gap of the state x so that the contact carries the normal force `force` >= 0 (N), on
 * the loading curve at rest. The gap must be 0 before; call it after {name}_complete_state. */
void {name}_press(const double *p, double *x, double force);

"""

_PRESSING = """\
void {name}_press(const double *p, double *x, double force) {{ complete(p, force, x); }}

"""

_CONTACTS = """\
/* What contact i does by the memory z of a run or of an event: the name of its local mode. */
const char *${name}_local_mode(int i, const double *z);

"""

_EVENT_CONTACT = """\
  int contact; /* index in {name}_contact_names; -1: no single one */
  /* Memory just before and just after: what each contact does, and the last impulses. */
  double memory_before[{room}], memory_after[{room}];
"""

_LOCAL_MODES = """\
const char *${name}_local_mode(int i, const double *z) {
  static const char *const names[] = {$local_names};
  static const int first[${NAME}_CONTACTS] = {$first}, at[${NAME}_CONTACTS] = {$at};
  return names[first[i] + (int)z[at[i]]];
}

"""

_COPY_CONTACT = """\
    e->contact = (int)row[5];
    memcpy(e->memory_before, x + PS_NX, sizeof(double) * PS_NZ);
    memcpy(e->memory_after, x + 2 * PS_NX + PS_NZ, sizeof(double) * PS_NZ);
"""

_PRINT_MODES = """\
static void print_modes(const double *memory) {
  for (int i = 0; i < ${NAME}_CONTACTS; i++)
    printf("%s%s", i ? " + " : "", ${name}_local_mode(i, memory));
}

"""

_PRINT_EVENT = """\
    printf("event %.17g %s %s: ", e->time, ${name}_event_names[e->kind],
           e->contact < 0 ? "all" : ${name}_contact_names[e->contact]);
    print_modes(e->memory_before);
    printf(" to ");
    print_modes(e->memory_after);
    printf("\\n");
$print_impulses"""

_PRINT_IMPULSES = """\
    if (e->kind == ${name}_event_impact)
      print_values(impulse_names, e->memory_after + $first_impulse, 2 * ${NAME}_CONTACTS);
"""

_IMPULSE_NAMES = """\
static const char *const impulse_names[] = {$impulse_names};

"""

_PRINT_END = """\
  printf("end %.17g %s: ", run->time, ${name}_stop_names[run->stop]);
  print_modes(run->memory);
  printf("\\n");
"""

_PRINT_EVENT_OF_ONE = """\
    printf("event %.17g %s: %s to %s\\n", e->time, ${name}_event_names[e->kind],
           ${name}_mode_names[e->mode_before], ${name}_mode_names[e->mode_after]);
    printf("  normal_force %.17g\\n", e->outputs[${name}_output_normal_force]);
    printf("  tangential_force %.17g\\n", e->outputs[${name}_output_tangential_force]);
"""

_PRINT_END_OF_ONE = """\
  printf("end %.17g %s: %s\\n", run->time, ${name}_stop_names[run->stop],
         ${name}_mode_names[run->mode]);
"""


def _filled(text: str, case: MotionCode) -> str:
    """Return a piece of C with what it says about the contacts of the case."""
    parts, memory = case.outline.parts, case.outline.memory_names
    sizes = [len(part.local_modes) for part in parts]
    impulses = memory[sum(len(part.memory) for part in parts) :]
    values = {
        "local_names": ", ".join(c_string(n) for part in parts for n in part.local_modes),
        "first": ", ".join(str(sum(sizes[:i])) for i in range(len(sizes))),
        "at": ", ".join(str(memory.index(part.memory[0])) for part in parts),
        "impulse_names": ", ".join(map(c_string, impulses)),
        "first_impulse": len(memory) - len(impulses),
        "print_impulses": "",
    }
    if impulses and "$print_impulses" in text:
        values["print_impulses"] = _filled(_PRINT_IMPULSES, case)
    return Template(text).substitute(case.shared | values)


def _enums(case: MotionCode) -> str:
    outline, name = case.outline, case.name
    parameters = [(n, case.declared[n]) for n in outline.parameter_names]
    memory = [(n, described(n)) for n in outline.memory_names]
    outputs = [(n, described(n)) for n in outline.output_names]
    given = [(n, case.declared[n]) for n in case.inputs]
    inputs = [(n, meaning_and_unit(p.unit, p.meaning)) for n, p in given]
    about_modes = "Modes; slip_neg and slip_pos are slips to the left and to the right"
    ranges = [
        (n, f"{meaning_and_unit(p.unit, p.meaning)}; {p.range_text}; by default {p.default!r}")
        for n, p in parameters
    ]
    tables: list[tuple[str, str, Iterable[tuple[str, str]], str]] = [
        ("state", "state", case.states.items(), "States, with their units"),
        ("parameter", "parameter", ranges, "Parameters, with their units"),
        ("input", "input", inputs, "Inputs: parameters that are held over each piece of a motion"),
        ("memory", "memory", memory, "Memory: constant within a mode, 0 at the start"),
        ("mode", "mode", [(m.name, "") for m in outline.modes], about_modes),
        ("output", "output", outputs, "Outputs"),
        ("event_kind", "event", [(k, k.sentence) for k in outline.kinds], "Kinds of events"),
        ("stop", "stop", [(r.label, r.sentence) for r in ENGINE_REASONS], "Why a run ended"),
        ("case", "case", [(c.value, c.sentence) for c in CASES], "Cases of one rigid contact"),
    ]
    return "\n\n".join(
        enum(f"{name}_{tag}", f"{name}_{prefix}", rows, about)
        for tag, prefix, rows, about in tables
    )


# ---- code ----


def _model(case: MotionCode) -> str:
    outline = case.outline
    values = {
        "engine": case.engine,
        "press": "" if initial_force_fault(case.simulator) else _PRESSING.format(name=case.name),
        "max_steps": RunOptions.max_steps,
        "max_events": RunOptions.max_events,
        "change": repr(SMALL),
        "contact_states": ", ".join(map(initializer, _contact_states(case))),
        "input_parameters": ", ".join(map(str, _input_places(case))),
        "start_events": int(case.simulator.start_events),
        "names": _names(case),
        "local_modes": _filled(_LOCAL_MODES, case) if outline.parts else "",
        "copy_contact": _COPY_CONTACT if outline.parts else "",
    }
    return filled("model.c", case.shared | values)


def _contact_states(case: MotionCode) -> list[list[int]]:
    """Return the places of gap, gap rate and slip of each contact among the states."""
    at, rows = case.outline.state_names.index, case.simulator.contact.rows
    return [[at(str(s)) for s in (row.gap, row.gap_rate, row.slip)] for row in rows]


def _input_places(case: MotionCode) -> list[int]:
    """Return the places of the inputs among the parameters, and -1 after them."""
    return [*map(case.outline.parameter_names.index, case.inputs), -1]


def _names(case: MotionCode) -> str:
    outline = case.outline
    tables = {
        "state_names[%s_STATES]": list(case.states),
        "parameter_names[%s_PARAMETERS]": list(outline.parameter_names),
        "mode_names[%s_MODES]": [m.name for m in outline.modes],
        "output_names[%s_OUTPUTS]": outline.output_names,
        "event_names[%s_EVENTS]": outline.kinds,
        "stop_names[%s_STOPS]": [r.label for r in ENGINE_REASONS],
        "contact_names[%s_CONTACTS]": [c.name for c in case.simulator.mechanism.outline.contacts],
        "case_names[%s_CASES]": [c.value for c in CASES],
    }
    lines = []
    for table, names in tables.items():
        entries = ",\n  ".join(map(c_string, names))
        head = f"const char *const {case.name}_{table % case.name.upper()}"
        lines.append(f"{head} = {{\n  {entries}\n}};")
    defaults = ", ".join(repr(case.declared[n].default) for n in outline.parameter_names)
    head = f"const double {case.name}_default_parameters[{case.name.upper()}_PARAMETERS]"
    return "\n".join([*lines, f"{head} = {{{defaults}}};"])


def _contact(case: MotionCode) -> str:
    states, contacts = case.outline.state_names, case.simulator.contact.rows
    slips = ", ".join(str(states.index(row.slip)) for row in contacts)
    values = contact_values(case.simulator.mechanism, case.name.upper()) | {"slip_states": slips}
    return filled("contact.c", case.shared | values)


def _main(case: ExampleCode) -> str:
    rows = [
        f"    {case.parameters[n]!r},  /* {n}: {c_comment(case.declared[n].unit)} */"
        for n in case.outline.parameter_names
    ]
    start = [
        f"    {value!r},  /* {n}: {c_comment(case.simulator.mechanism.state_units[n])} */"
        for n, value in zip(case.states, case.motion.tolist(), strict=False)
    ]
    force = case.initial_force
    return filled(
        "main.c",
        case.shared
        | {
            "case": prose([_example(case)]),
            "parameters": "\n".join(rows),
            "state": "\n".join(start),
            "press": "" if force is None else f"  {case.name}_press(p, x, {force!r});\n",
            "t_end": repr(case.t_end),
            "rtol": repr(case.rtol),
            "options": "".join(f"{line}\n" for line in case.option_lines),
        }
        | _printing(case),
    )


def _printing(case: ExampleCode) -> dict[str, str]:
    if not case.outline.parts:
        event, end, modes = _PRINT_EVENT_OF_ONE, _PRINT_END_OF_ONE, ""
    else:
        impulses = len(case.outline.memory_names) > sum(len(p.memory) for p in case.outline.parts)
        event, end, modes = _PRINT_EVENT, _PRINT_END, _IMPULSE_NAMES * impulses + _PRINT_MODES
    texts = {"print_event": event, "print_end": end, "print_modes": modes}
    return {name: _filled(text, case) for name, text in texts.items()}


def expected(trajectory: Trajectory) -> str:
    """Return what the example prints, from the package's own numbers."""
    lines: list[str] = []
    several = "normal_force" not in trajectory.output_names
    impulses = [n for n in trajectory.memory_names if "_impulse_" in n]

    def values(by_name: Mapping[str, float]) -> None:
        lines.extend(f"  {name} {value:.17g}" for name, value in by_name.items())

    for e in trajectory.events:
        contact = f" {e.contact or 'all'}" if several else ""
        lines.append(f"event {e.time:.17g} {e.kind}{contact}: {e.mode_before} to {e.mode_after}")
        if several:
            values(dict(zip(impulses, e.impulses, strict=False)))
        else:
            values({"normal_force": e.normal_force, "tangential_force": e.tangential_force})
        values(e.state)
    mode = trajectory.mode_names[trajectory.final_mode]
    lines.append(f"end {trajectory.final_time:.17g} {trajectory.stop_reason.label}: {mode}")
    values(trajectory.final)
    values(trajectory.final_outputs)
    done = trajectory.counters
    lines.append(f"steps {done['accepted_steps']} accepted, {done['rejected_steps']} rejected")
    return "\n".join(lines) + "\n"
