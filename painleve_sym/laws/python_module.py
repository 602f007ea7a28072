"""The closed forms of a mechanism as a Python module that needs nothing but `math`."""

from __future__ import annotations

import shlex
import textwrap
from collections.abc import Iterable, Sequence

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.escape import python_text
from painleve_sym.laws.formulas import closed_forms, impulse_units
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.laws.restitution_equation import E_C, P_C, V_N_MINUS
from painleve_sym.mechanics.coefficients import F_N
from painleve_sym.mechanics.formulas.formula import (
    Formula,
    ImpulsePhase,
    Section,
    python_code,
    wrap_expression,
)
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_N_PLUS, V_T
from painleve_sym.mechanics.mechanism import Mechanism

_CONTACT = {
    F_N: "normal force; N",
    V_T: "slip velocity at the start of the phase; m/s",
    V_N: "normal velocity at the start of the phase; m/s",
    V_N_MINUS: "normal velocity before the impact; m/s",
    V_N_PLUS: "normal velocity after the impact; m/s",
    P_C: "normal impulse of both compressions; N s",
    E_C: "energy stored by both compressions; J",
}


def python_module(mechanism: Mechanism, sections: Sequence[Section] | None = None) -> str:
    """Return the text of a Python module: one function per formula, and the whole jump.

    The sections are those of `closed_forms` when left out. InputError where a coordinate or
    parameter has the name of `math` or of what a function calls.
    """
    sections = closed_forms(mechanism) if sections is None else sections
    formulas = [f for s in sections for f in s.formulas]
    meanings = _meanings(mechanism) | {s: m for f in formulas for s, m in f.symbols.items()}
    command = shlex.join(["painleve", "derive", mechanism.name, "--format", "python"])
    parts = [
        f'"""Closed forms of {python_text(f"{mechanism.name}: {mechanism.title}")}.\n\n'
        f"Written by `{python_text(command)}`. SI units, radians.\n"
        '"""\n\nimport math'
    ]
    phases = [p for s in sections for p in s.phases]
    parts += [_formula(f, meanings) for f in formulas]
    parts += [_phase(p, meanings, mechanism) for p in phases]
    if any(p.name == "sticking_compression" for p in phases):
        parts.append(_whole_jump(mechanism, formulas, phases, meanings))
    return "\n\n\n".join(parts) + "\n"


def _meanings(mechanism: Mechanism) -> dict[sp.Symbol, str]:
    """Return the meaning of each possible argument, in the order arguments are given."""
    system = mechanism.system
    meanings = {c.symbol: f"{c.meaning}; {c.unit}" for c in system.coordinates}
    meanings |= {v.symbol: f"{v.meaning}; {v.unit}" for v in system.velocities}
    meanings |= dict.fromkeys(system.clock, "time; s")
    meanings |= _CONTACT
    meanings |= {p.symbol: f"{p.meaning}; {p.unit}" for p in system.parameters}
    for law in RESTITUTIONS.values():
        parameter = law.parameter
        meanings[parameter.symbol] = parameter.meaning
    return meanings


def _arguments(
    exprs: Iterable[sp.Basic | sp.MatrixBase], meanings: dict[sp.Symbol, str]
) -> list[sp.Symbol]:
    used: set[sp.Symbol] = set().union(*(e.free_symbols for e in exprs))
    return _checked([s for s in meanings if s in used], ("math",))


def _checked(arguments: list[sp.Symbol], taken: Iterable[str]) -> list[sp.Symbol]:
    """Return the arguments; InputError where one has a name that the function needs itself."""
    if clash := sorted({str(a) for a in arguments} & set(taken)):
        raise InputError(
            f"Python module of closed forms: {clash[0]!r} is a name of its own. "
            "Fix: rename the coordinate or parameter."
        )
    return arguments


def _head(name: str, arguments: Sequence[sp.Symbol], result: str) -> list[str]:
    line = f"def {name}({', '.join(f'{a}: float' for a in arguments)}) -> {result}:"
    if len(line) <= 99:
        return [line]
    return [f"def {name}(", *(f"    {a}: float," for a in arguments), f") -> {result}:"]


def _docstring(
    summary: str,
    arguments: Sequence[sp.Symbol],
    meanings: dict[sp.Symbol, str],
    keys: Sequence[str] = (),
) -> list[str]:
    lines = _wrapped(summary, "    ", '"""')
    if not arguments:
        return [*lines[:-1], lines[-1] + '"""']
    lines += ["", "    Parameters", "    ----------"]
    for a in arguments:
        lines += [f"    {a} : float", *_wrapped(f"{meanings[a]}.", "        ")]
    if keys:
        lines += ["", "    Returns", "    -------", "    dict of str to float"]
        lines += _wrapped(f"{', '.join(keys)}.", "        ")
    return [*lines, '    """']


def _wrapped(text: str, indent: str, opening: str = "") -> list[str]:
    return textwrap.wrap(
        python_text(text),
        99,
        initial_indent=indent + opening,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )


def _entry(start: str, code: str, end: str, indent: str) -> list[str]:
    if len(indent) + len(start) + len(code) + len(end) <= 99:
        return [f"{indent}{start}{code}{end}"]
    inner = indent + "    "
    return [f"{indent}{start}(", *wrap_expression(inner, code, 99, inner), f"{indent}){end}"]


def _formula(formula: Formula, meanings: dict[sp.Symbol, str]) -> str:
    arguments = _arguments([formula.value], meanings)
    matrix = isinstance(formula.value, sp.MatrixBase)
    unit = "" if formula.unit in ("1", "SI") else f"; {formula.unit}"
    lines = _head(formula.name, arguments, "list[list[float]]" if matrix else "float")
    lines += _docstring(f"Return {formula.meaning}{unit}.", arguments, meanings)
    if matrix:
        lines.append("    return [")
        for i in range(formula.value.rows):
            row = ", ".join(python_code(formula.value[i, j]) for j in range(formula.value.cols))
            lines += wrap_expression(" " * 8, f"[{row}],", 99, " " * 12)
        lines.append("    ]")
    else:
        lines += _entry("return ", python_code(formula.value), "", "    ")
    return "\n".join(lines)


def _phase(phase: ImpulsePhase, meanings: dict[sp.Symbol, str], mechanism: Mechanism) -> str:
    arguments = _arguments(phase.values.values(), meanings)
    units = impulse_units(mechanism)
    stage = phase.name.replace("_neg", "").replace("_pos", "").replace("_", " ")
    after = f" with {phase.meaning}" if phase.meaning else ""
    lines = _head(phase.name, arguments, "dict[str, float]")
    lines += _docstring(
        f"Return impulses, energy and velocities after the {stage} phase{after}.",
        arguments,
        meanings,
        [f"{name} [{unit}]" for name, unit in units.items()],
    )
    lines.append("    return {")
    for name, value in phase.values.items():
        lines += _entry(f'"{name}": ', python_code(value), ",", "        ")
    lines.append("    }")
    return "\n".join(lines)


def _whole_jump(
    mechanism: Mechanism,
    formulas: Sequence[Formula],
    phases: Sequence[ImpulsePhase],
    meanings: dict[sp.Symbol, str],
) -> str:
    """Return the function that chains the phases with the energetic restitution."""
    by_name = {f.name: f for f in formulas} | {p.name: p for p in phases}
    symbols: dict[str, list[sp.Symbol]] = {}
    for name, one in by_name.items():
        values = one.values.values() if isinstance(one, ImpulsePhase) else [one.value]
        symbols[name] = _arguments(values, meanings)
    velocities = set(mechanism.system.q_dot)
    chain = ("slip_velocity", "gap_rate", "rebound_energetic", *(p.name for p in phases))
    outer = _checked(
        [s for s in meanings if s not in _CONTACT and any(s in symbols[name] for name in chain)],
        (*chain, "first", "second", "third"),
    )

    def call(name: str, put: dict[sp.Symbol, str], before: str = "") -> str:
        def written(s: sp.Symbol) -> str:
            if s in put:
                return put[s]
            return f'{before}["{s}"]' if before and s in velocities else str(s)

        return f"{name}({', '.join(f'{s}={written(s)}' for s in symbols[name])})"

    start = {V_T: "v_t", V_N: "v_n"}
    second = {V_T: "0.0", V_N: 'first["normal_velocity"]'}
    closed = {
        P_C: 'first["normal_impulse"] + second["normal_impulse"]',
        E_C: 'first["stored_energy"] + second["stored_energy"]',
        V_N_MINUS: "v_n",
    }
    lines = _head("jump", outer, "list[dict[str, float]]")
    lines += _docstring(
        "Return the three phases of the jump, closed by the energetic restitution. "
        "Whether they take place in this form is for the caller to know: see `painleve jump`.",
        outer,
        meanings,
    )
    lines += [f"    v_t = {call('slip_velocity', {})}", f"    v_n = {call('gap_rate', {})}"]
    lines.append("    if v_t < 0:")
    lines += _entry("first = ", call("tangential_neg", start), "", " " * 8)
    lines.append("    else:")
    lines += _entry("first = ", call("tangential_pos", start), "", " " * 8)
    calls = (
        ("second = ", call("sticking_compression", second, "first")),
        ("v_n_plus = ", call("rebound_energetic", closed, "second")),
        ("third = ", call("sticking_restitution", {V_N_PLUS: "v_n_plus"}, "second")),
    )
    for target, code in calls:
        lines += _entry(target, code, "", "    ")
    return "\n".join([*lines, "    return [first, second, third]"])
