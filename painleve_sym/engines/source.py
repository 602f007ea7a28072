"""The C source of an automaton: generated functions, tables, coefficients and the event loop."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import accumulate
from typing import Any

import casadi as ca

from painleve_sym.automata.automaton import HybridAutomaton, Transition
from painleve_sym.automata.model import ENERGIES, LOSSES
from painleve_sym.codegen.c_functions import Written, c_file, shared_text
from painleve_sym.codegen.modes import AutomatonFunctions, VariantFunctions
from painleve_sym.engines.c_texts import engine_texts, initializer, number_text
from painleve_sym.engines.protocol import ENGINE_REASONS, Place, Places
from painleve_sym.engines.records import EVENT_HEAD, STEP_HEAD
from painleve_sym.engines.runge_kutta.coefficients import DENSE_STAGES, dop853
from painleve_sym.errors import EventKind
from painleve_sym.laws.restitution import restitution_law

BEFORE_STEPPER = (
    *("loop/rows", "loop/state", "loop/watch", "loop/choose", "loop/linear"),
    *("loop/problem", "loop/impulse", "loop/events", "loop/impact"),
)
AFTER_STEPPER = ("loop/loop", "loop/batch")
"""Files of the event loop above and below those of a stepper, in the order of reading."""
_RUNGE_KUTTA = tuple(f"runge_kutta/{part}" for part in ("step", "extremes", "search", "advance"))


def source(functions: AutomatonFunctions, given: Places = ()) -> str:
    """Return one self-contained C file: everything the event loop needs for this automaton."""
    variants = every_variant(functions, given)
    parts = engine_texts(*BEFORE_STEPPER, *_RUNGE_KUTTA, *AFTER_STEPPER)
    rows = [variant_row(v, "") for v in variants]
    stepper = _coefficients()
    return assemble(functions, variants, (), rows, stepper, parts, "#define PS_OWN_SERIES\n")


def variant_source(functions: AutomatonFunctions, at: Place, file: str) -> str:
    """Return the C file of a variant, to be loaded beside the automaton's own `file`."""
    variant = functions.variant(*at, len(functions.modes))
    return variant_file(variant, (), variant_row(variant, ""), file)


def every_variant(functions: AutomatonFunctions, given: Places) -> list[VariantFunctions]:
    """Return the modes as they are, then variants of them."""
    first = len(functions.modes)
    own = (functions.variant(*at, number) for number, at in enumerate(given, first))
    return [*functions.as_they_are, *own]


def assemble(
    functions: AutomatonFunctions,
    variants: Sequence[VariantFunctions],
    more: Sequence[ca.Function],
    rows: Sequence[str],
    stepper: str,
    engine: Sequence[str],
    shared: str,
    written: Sequence[Written] = (),
) -> str:
    """Return the C file of an automaton.

    `more` are functions that the stepper needs besides, `rows` those of the variants in its table,
    `stepper` is C that its files expect above them, `engine` hand-written C in the order in which
    it must be read. For `shared` and `written` see `c_file`.
    """
    smooth = (f for v in variants for f in v.generated.values())
    every = (*functions.all(), *smooth, *more)
    table = "static const ps_variant PS_VARIANTS[PS_NV] = {\n" + ",\n".join(rows) + "};\n"
    parts = (_tables(functions, len(rows) > len(functions.modes)), table, stepper, *engine)
    sizes = _sizes(functions, every) | {"NV": len(variants)}
    lines = [f"#define PS_{name} {value}" for name, value in sizes.items()]
    return c_file(every, "\n".join(parts), "\n".join([*lines, shared, _TYPES]), written)


def variant_file(
    variant: VariantFunctions,
    more: Sequence[ca.Function],
    row: str,
    file: str,
    written: Sequence[Written] = (),
) -> str:
    """Return the C file of a variant that shares what every part of its automaton's file sees."""
    callers = f"PS_EXPORT const ps_variant ps_own_variant = {row};\n"
    return c_file((*variant.generated.values(), *more), callers, shared_text(file), written)


def variant_row(v: VariantFunctions, series: str) -> str:
    """Return a variant as the initialiser of a `ps_variant`."""
    every = (v.generated.get(role) for role in ("field", "guards", "jets"))
    names = ", ".join("0" if f is None else f.name() for f in every)
    known = initializer(map(number_text, v.known))
    row = f"{names}, {len(v.transitions)}, {initializer(v.transitions)}, {v.mode}, {known}"
    return f"{{{row}{f', {series}' if series else ''}}}"


_TYPES = """\
/* What a run does; other reasons to stop are >= 0, in the order of the Python side. */
enum { PS_RUNNING = -1, PS_DECISION = -2, PS_NO_MEMORY = -3, PS_NO_VARIANT = -4 };
/* One bit for each guard of a mode. */
typedef unsigned long long ps_bits;
typedef int (*ps_function)(const double **, double **, casadi_int *, double *, int);
/* What is smooth of a mode: as it is, or while the memory has `known` values, INFINITY for any;
 * n guards, those of the transitions. A mode of which variants take the place has none as it is. */
typedef struct {
  ps_function field, guards, jets;
  int n;
  unsigned char transition[PS_NG];
  int mode;
  double known[PS_NZ + 1];
  PS_OWN_SERIES
} ps_variant;
#ifndef PS_EXPORT
/* An enclosing file may have set the visibility of its functions already. */
#define PS_EXPORT __attribute__((visibility("default")))
#endif
"""


def _sizes(functions: AutomatonFunctions, every: Sequence[ca.Function]) -> dict[str, int]:
    automaton = functions.automaton
    transitions = [t for m in automaton.modes for t in m.transitions]
    return {
        "NX": functions.x.numel(),
        "NOWN": len(automaton.states),
        "NZ": functions.z.numel(),
        "NP": len(automaton.parameters),
        "NC": functions.c.numel(),
        "NM": len(automaton.modes),
        "NO": functions.output_size,
        "NG": max(1, *(f.smooth.margins.numel() for f in functions.modes)),
        "NT": max(1, *(len(m.transitions) for m in automaton.modes)),
        "NCHOICE": max((len(t.choices) for t in transitions), default=0) or 1,
        "NSTART": len(automaton.starts),
        "NKIND": max(1, len(automaton.kinds)),
        "NTEST": max(len(m.tests) for m in automaton.modes),
        "NPART": len(automaton.parts),
        "NALT": sum(len(part.alternatives) for part in automaton.parts),
        "WORK": max(f.sz_w() for f in every),
        "STEP_HEAD": STEP_HEAD,
        "EVENT_HEAD": EVENT_HEAD,
    }


def _coefficients() -> str:
    method = dop853()
    rows = {f"ROW_{s}": row for s, row in enumerate(method.stage_weights) if row}
    rows |= {"E5": method.error_5, "E3": method.error_3}
    rows |= {f"D_{i}": row for i, row in enumerate(method.dense_weights)}
    sums = {n: " + ".join(f"{w!r} * k[{j}][i]" for j, w in r.items()) for n, r in rows.items()}
    weights = [f"#define PS_{name} ({text})" for name, text in sums.items()]
    ends = [f"#define PS_STAGES {DENSE_STAGES}", "#define PS_STEPPER double h_last, err_last;", ""]
    return "\n".join([*weights, *ends])


def _array(kind: str, name: str, values: Iterable[object]) -> str:
    """Return a constant array of C, whose name begins with PS_."""
    return f"static const {kind} PS_{name} = {initializer(values)};"


def _transition(functions: AutomatonFunctions, i: int, j: int, t: Transition) -> str:
    kind = functions.automaton.kinds.index(t.kind)
    stop: int | str = ENGINE_REASONS.index(t.stop) if t.stop is not None else "PS_RUNNING"
    if t.strikes:
        stop = "PS_DECISION"
    targets = initializer(functions.mode_index[c.target] for c in t.choices)
    masks = [sum(1 << k for k in functions.departures(c)) for c in t.choices] or [0]
    departs = initializer(f"{m}ull" for m in masks)
    contact = functions.automaton.contacts.index(t.contact) if t.contact else -1
    limit, at = "0, 0, 0", t.on_accumulation
    if at is not None:
        places = functions.automaton.kinds.index(at.kind), functions.mode_index[at.target]
        limit = f"limit_{i}_{j}, {places[0]}, {places[1]}"
    head = f"event_{i}_{j}, {kind}, {contact}, {stop}, {int(t.chooses)}, {len(t.choices)}"
    return f"{{{head}, {targets}, {departs}, {limit}, {int(t.watches) + int(t.silent)}}}"


def _tables(functions: AutomatonFunctions, has_given: bool) -> str:
    automaton = functions.automaton
    lines = [
        "#include <math.h>",
        "/* Its n choices; where `limit`, what follows where it accumulates. `watching`: 1 for an",
        " * event that only looks at the motion, 2 for one that is not recorded either. */",
        "typedef struct { ps_function event; int kind, contact, stop, chooses, n; "
        "int target[PS_NCHOICE]; ps_bits departs[PS_NCHOICE]; "
        "ps_function limit; int limit_kind, limit_target, watching; } ps_transition;",
        "/* n transitions with a guard; where `immediate`, one more that has none. */",
        "typedef struct { ps_function outputs, tests; const char *roles; "
        "int n, immediate, tested; ps_transition transitions[PS_NT]; } ps_mode;",
        "static const ps_mode PS_MODES[PS_NM] = {",
    ]
    for i, mode in enumerate(automaton.modes):
        rows = [_transition(functions, i, j, t) for j, t in enumerate(mode.transitions)]
        tests = f"tests_{i}" if mode.tests else "0"
        roles = "".join(t.role.value for t in mode.tests)
        names = f'outputs_{i}, {tests}, "{roles}"'
        now = sum(t.immediate for t in mode.transitions)
        sizes = f"{len(rows) - now}, {now}, {len(mode.tests)}"
        table = f"{{{', '.join(rows)}}}"
        lines.append(f"  {{{names}, {sizes}, {table}}},  /* {mode.name} */")
    starts = (functions.mode_index[c.target] for c in automaton.starts)
    lines += [
        "};",
        _array("int", "STARTS[PS_NSTART]", starts),
        "#define PS_START_CONDITIONS starts",
        "#define PS_CONSTANTS constants",
        *_energies(automaton),
        *_preparation(functions),
        *_parts(automaton),
        *_variants(functions, has_given),
        *_impacts(functions),
        "",
    ]
    return "\n".join(lines)


def _energies(automaton: HybridAutomaton) -> list[str]:
    """Return the places of the energies among the outputs, and of the losses among the states."""
    outputs, states = automaton.output_names, [s.name for s in automaton.states]
    if not set(ENERGIES) <= set(outputs):
        return []
    losses = [states.index(name) for name in LOSSES if name in states]
    return [
        f"#define PS_ENERGIES {len(ENERGIES)}",
        _array("int", "ENERGY[PS_ENERGIES]", (outputs.index(name) for name in ENERGIES)),
        f"#define PS_LOSSES {len(losses)}",
        _array("int", "LOSS[PS_LOSSES]", losses),
    ]


def _preparation(functions: AutomatonFunctions) -> list[str]:
    """Return name, arguments and results of the functions that prepare a run."""
    of = functions.automaton.preparation
    if of is None or functions.prepared is None:
        return []
    return [
        "#define PS_PREPARED prepared_state",
        "#define PS_SCALES state_scales",
        f"#define PS_GIVEN {len(of.given)}",
        f"#define PS_ADMITS {len(of.admits)}",
    ]


def _parts(automaton: HybridAutomaton) -> list[str]:
    """Return the tables of the parts: how many alternatives each has, where its memory begins."""
    if not automaton.parts:
        return []
    every = [a for part in automaton.parts for a in part.alternatives]
    leaving = {label for part in automaton.parts for label in part.leaving}
    masks = [
        sum(1 << j for j, t in enumerate(mode.transitions) if t.label in leaving)
        for mode in automaton.modes
    ]
    rest = [automaton.states.index(s) for part in automaton.parts for s in part.rest]
    rest_of = (-1 if a.rest_of is None else a.rest_of for a in every)
    places = accumulate((len(part.memory) for part in automaton.parts), initial=0)
    return [
        "#define PS_ALTERNATIVES alternatives",
        f"#define PS_POLICY {automaton.preference}",
        f"#define PS_OWNED_SIZE {len(automaton.memory)}",
        _array("ps_bits", "LEAVING[PS_NM]", (f"{m}ull" for m in masks)),
        f"#define PS_NREST {len(rest)}",
        _array("int", "REST[]", rest),
        _array("int", "OFFERED[PS_NPART]", (len(part.alternatives) for part in automaton.parts)),
        _array("int", "IS_OPEN[PS_NALT]", (int(a.open) for a in every)),
        _array("int", "IS_PREFERRED[PS_NALT]", (int(a.preferred) for a in every)),
        _array("int", "REST_OF[PS_NALT]", rest_of),
        _array("int", "OWNED[PS_NPART + 1]", places),
    ]


def _variants(functions: AutomatonFunctions, has_given: bool) -> list[str]:
    """Return the tables of the values of the memory of each part that have a variant in common."""
    parts = functions.automaton.parts
    if not (parts and (functions.has_variants or has_given)):
        return []
    moving = (f"(mode) == {i}" for i, mode in enumerate(functions.automaton.modes) if mode.field)
    rows = [
        ", ".join(_known(values, s) for s in part.memory)
        for part in parts
        for values in part.variants
    ]
    return [
        _array("int", "KNOWN[PS_NPART]", (len(part.variants) for part in parts)),
        _array("double", "KNOWN_MEMORY[]", rows),
        f"#define PS_HAS_VARIANTS(mode) ({' || '.join(moving) or '0'})",
    ]


def _known(values: Mapping[Any, Any], symbol: Any) -> str:
    """Return what a variant knows of an entry of the memory, as a number of C."""
    value = values.get(symbol, symbol)
    return number_text(float(value) if value.is_number else math.inf)


def _impacts(functions: AutomatonFunctions) -> list[str]:
    """Return the tables of the impacts: which contacts and states they concern, and their law."""
    automaton, given = functions.automaton, functions.automaton.impacts
    if given is None or functions.impacts is None:
        return []
    at, law = automaton.states.index, restitution_law(given.restitution)
    touchdown = EventKind.TOUCHDOWN
    sizes = {
        "IMPACTS": "impacts",
        "CONTACTS": len(given.contacts),
        "RIGID": len(given.rigid),
        "SPEEDS": len(given.velocities),
        "IMPACT_MEASURE": f"PS_BY_{law.measure.upper()}",
        "IMPACT_POWER": law.power,
        "IMPACT_FINAL_SLIP": int(given.final_slip),
        "IMPACT_TARGET": functions.mode_index[given.target],
        "IMPACT_KIND": automaton.kinds.index(given.kinds[0]),
        "SETTLE_KIND": automaton.kinds.index(given.kinds[1]),
        "TOUCHDOWN_KIND": automaton.kinds.index(touchdown) if touchdown in automaton.kinds else -1,
        "IMPULSES": automaton.memory.index(given.impulses[0]),
    }
    lines = [f"#define PS_{name} {value}" for name, value in sizes.items()]
    states = (initializer(map(at, row)) for row in given.contacts)
    return [
        *lines,
        _array("int", "RIGID_CONTACT[PS_RIGID]", given.rigid),
        _array("int", "BILATERAL[PS_RIGID]", (int(i in given.bilateral) for i in given.rigid)),
        _array("int", "CONTACT_STATES[PS_CONTACTS][3]", states),
        _array("int", "SPEED[PS_SPEEDS]", map(at, given.velocities)),
        _array("int", "WORKS[3]", (-1 if s is None else at(s) for s in given.works)),
    ]
