"""The closed forms of a mechanism as the command derive prints them: text, LaTeX, Python, JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import sympy as sp

from painleve_sym.cli.output import WIDTH, wrapped
from painleve_sym.errors import InputError
from painleve_sym.escape import one_line
from painleve_sym.laws.formulas import closed_forms, impulse_units
from painleve_sym.laws.python_module import python_module
from painleve_sym.laws.restitution_equation import V_N_MINUS
from painleve_sym.mechanics.formulas.formula import (
    ImpulsePhase,
    Section,
    Value,
    latex_names,
    named_parts,
    plain,
    wrap_expression,
    written_forms,
)
from painleve_sym.mechanics.impact.impulse_rays import V_N_PLUS
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.quantities import QUANTITIES


def written(mechanism: Mechanism, form: str) -> dict[str, Any]:
    """Return every closed form of a mechanism in a format: a text, or for JSON the data."""
    sections = [_with_search(mechanism, section) for section in closed_forms(mechanism)]
    if form == "json":
        return formula_data(mechanism, sections)
    page = {"python": python_module, "latex": latex_page}.get(form, text_page)
    return {"text": page(mechanism, sections)}


def _with_search(mechanism: Mechanism, section: Section) -> Section:
    """Add the least critical friction as a number where it has no closed form."""
    if not section.contact:
        return section
    from painleve_sym.study.maps.least_friction import least_critical_friction

    alone = mechanism.only(section.contact)
    try:
        least = least_critical_friction(alone)
    except InputError:
        text = "No configuration in contact was found at the default parameters."
        return replace(section, note=f"{section.note} {text}")
    c = alone.coefficients
    inner = c.W_nn.free_symbols | c.W_nt.free_symbols
    places = [f"{s} = {least.configuration[str(s)]:.6g}" for s in alone.system.q if s in inner]
    text = (
        "A search over the configurations in contact at the default parameters finds "
        f"{least.value:.6g}, at {', '.join(places)}."
    )
    return replace(section, note=f"{section.note} {text}")


# ---- text ----


def text_page(mechanism: Mechanism, sections: Sequence[Section]) -> str:
    """Return the formulas as text, at most 80 columns wide."""
    lines = [wrapped(f"{mechanism.name}: {mechanism.title}")]
    units = impulse_units(mechanism)
    for section in sections:
        lines += ["", wrapped(section.title.upper())]
        if section.note:
            lines.append(wrapped(f"  {section.note}"))
        for formula in section.formulas:
            unit = "" if formula.unit in ("1", "SI") else f" [{formula.unit}]"
            lines += ["", wrapped(f"  {formula.name}{unit}: {formula.meaning}")]
            lines += _value_lines(formula.value)
        for phase in section.phases:
            meaning = f": {phase.meaning}" if phase.meaning else ""
            lines += ["", wrapped(f"  {phase.name}{meaning}")]
            for name, margin, strict in phase.conditions:
                sign = ">" if strict else ">="
                lines += _expression_lines(f"    needs {name}: ", f"{plain(margin)} {sign} 0")
            for name, value in phase.values.items():
                lines += _expression_lines(f"    {name} [{units[name]}] = ", plain(value))
    return "\n".join(lines) + "\n"


def _value_lines(value: sp.Basic | sp.MatrixBase) -> Iterator[str]:
    if not isinstance(value, sp.MatrixBase):
        yield from _expression_lines("    = ", plain(value))
        return
    cells = [[plain(value[i, j]) for j in range(value.cols)] for i in range(value.rows)]
    widths = [max(len(row[j]) for row in cells) for j in range(value.cols)]
    if sum(widths) + 2 * len(widths) > WIDTH - 10:
        for i, row in enumerate(cells, 1):
            for j, cell in enumerate(row, 1):
                yield from _expression_lines(f"    [{i}, {j}] = ", cell)
        return
    for i, row in enumerate(cells):
        mark = "=" if i == 0 else " "
        line = "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True))
        yield from _expression_lines(f"    {mark} [ ", f"{line} ]")


def _expression_lines(start: str, text: str) -> list[str]:
    return wrap_expression(start, text, indent=" " * 8)


# ---- LaTeX ----


def latex_page(mechanism: Mechanism, sections: Sequence[Section]) -> str:
    """Return the formulas as LaTeX to be read into a document with amsmath.

    Parts that long formulas share have names of their own, which come first.
    """
    names = _latex_names(mechanism)
    parts, written = named_parts([value for section in sections for value in _values(section)])
    about = one_line(f"{mechanism.name}: {mechanism.title}")
    lines = [f"% {about}", "% for \\input; needs amsmath"]
    if parts:
        lines += ["", "% parts that long formulas share"]
    for symbol, part in parts.items():
        lines.append(f"\\[ {sp.latex(symbol)} = {sp.latex(part, symbol_names=names)} \\]")
    texts = iter([sp.latex(value, symbol_names=names) for value in written])
    for section in sections:
        lines += ["", f"% {one_line(section.title)}"]
        for formula in section.formulas:
            lines.append(f"% {one_line(f'{formula.name}: {formula.meaning}')}")
            lines.append(f"\\[ {formula.latex} = {next(texts)} \\]")
        for phase in section.phases:
            lines += _latex_phase(phase, names, texts)
    return "\n".join(lines) + "\n"


def _values(section: Section) -> Iterator[Value]:
    """Yield the values of a section in the order of the page."""
    yield from (formula.value for formula in section.formulas)
    for phase in section.phases:
        yield from (margin for _, margin, _ in phase.conditions)
        yield from phase.values.values()


def _latex_phase(
    phase: ImpulsePhase, names: dict[sp.Symbol, str], texts: Iterator[str]
) -> Iterator[str]:
    by_name = {str(symbol): latex for symbol, latex in names.items()}
    yield f"% {one_line(f'{phase.name}: {phase.meaning}' if phase.meaning else phase.name)}"
    for name, _, strict in phase.conditions:
        sign = ">" if strict else r"\ge"
        yield f"\\[ {next(texts)} {sign} 0 \\] % {name}"
    for name in phase.values:
        latex = QUANTITIES[name].latex if name in QUANTITIES else by_name[name]
        left = (
            latex
            if name in ("normal_impulse", "tangential_impulse", "stored_energy")
            else f"{latex}^{{+}}"
        )
        yield f"\\[ {left} = {next(texts)} \\]"


def _latex_names(mechanism: Mechanism) -> dict[sp.Symbol, str]:
    return {V_N_PLUS: "v_n^{+}", V_N_MINUS: "v_n^{-}", **latex_names(mechanism)}


# ---- JSON ----


def formula_data(mechanism: Mechanism, sections: Sequence[Section]) -> dict[str, Any]:
    """Return the formulas as plain data: each as text, LaTeX and Python."""
    names, units = _latex_names(mechanism), impulse_units(mechanism)

    formulas = {
        f.name: {"meaning": f.meaning, "unit": f.unit, **written_forms(f.value, names)}
        for s in sections
        for f in s.formulas
    }
    jump = {
        p.name: {
            "meaning": p.meaning,
            "conditions": [
                {"name": name, "strict": strict, **written_forms(margin, names)}
                for name, margin, strict in p.conditions
            ],
            "values": {
                k: {"unit": units[k], **written_forms(v, names)} for k, v in p.values.items()
            },
        }
        for s in sections
        for p in s.phases
    }
    return {
        "formulas": formulas,
        "jump": jump,
        "notes": {s.title: s.note for s in sections if s.note},
    }
