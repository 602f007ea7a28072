"""The C source of an automaton with the Taylor stepper."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import casadi as ca

from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.engines.c_texts import engine_texts, initializer
from painleve_sym.engines.source import AFTER_STEPPER, BEFORE_STEPPER, assemble
from painleve_sym.engines.taylor import ORDER
from painleve_sym.engines.taylor.emit import WIDTH, SeriesCode
from painleve_sym.engines.taylor.scalars import Scalar
from painleve_sym.engines.taylor.simplify import simplify
from painleve_sym.engines.taylor.tangents import TangentCode, Tangents
from painleve_sym.engines.taylor.tape import SeriesTape, build
from painleve_sym.errors import NoRecurrence

_FUNCTION = re.compile(r"^static void (\w+)\(.*?^\}\n", re.M | re.S)
# Compilers make vectors of loops over the states. Those of one motion stay in functions of their
# own, which clear the registers' upper halves at their end: gcc 12 forgets that before some calls,
# and then the first old instruction in libm pays for it. Those of lanes are part of `fill_lanes` or
# `look_along`; to functions of their own clang 14 hands vectors in registers they do not expect.
_MACROS = {
    "FUNCTION": ("__attribute__((noinline)) static", "static inline"),
    "REAL": ("double", "ps_lanes"),
    "OF(name)": ("name", "name##_lanes"),
    "REAL_OF": ("", "PS_SPREAD"),
    "REAL_FMA": ("PS_FMA", "PS_LANES_FMA"),
    "REAL_ABS": ("fabs", "PS_LANES_ABS"),
    "CHOOSE(test, a, b)": ("((test) ? (a) : (b))", "PS_LANES_CHOOSE(test, a, b)"),
    "BITS": ("unsigned long long", "ps_lane_bits"),
}
"""What a macro stands for in C that is read for one motion, and for lanes of motions."""
_LENGTH = 24
"""Orders, the constant among them, and room to a whole cache line."""


def tapes(functions: AutomatonFunctions) -> list[SeriesTape]:
    """Return the tape of every mode and variant.

    Raises
    ------
    NoRecurrence
        Names the mode and the operation.
    """
    every, own = (functions.x, functions.z, functions.c), functions.own
    nx = own[0].numel()
    tapes_of_modes = []
    for f in functions.every_variant:
        expressions = ca.vertcat(f.field(*every)[:nx], f.guards(*every)[0])
        try:
            tapes_of_modes.append(simplify(build(expressions, *own, nx)))
        except NoRecurrence as error:
            name = functions.automaton.modes[f.mode].name
            raise NoRecurrence(
                f"mode {name!r} uses {error} of a state, which has no Taylor series"
            ) from error
    return tapes_of_modes


class _ModeCode(NamedTuple):
    """C code of one mode's Taylor series, and of their derivatives if any."""

    series: SeriesCode
    tangents: TangentCode | None

    @property
    def scalar_count(self) -> int:
        """Numbers that `_scalars` returns."""
        more = self.tangents.directions * len(self.tangents.scalars) if self.tangents else 0
        return max(1, len(self.series.scalars) + more)


def source(functions: AutomatonFunctions) -> str:
    """Return one self-contained C file: event loop, series and guards of every mode."""
    codes = [_code(functions, t, f"series_{i}") for i, t in enumerate(tapes(functions))]
    more = [_scalars(functions, code, i) for i, code in enumerate(codes)]
    first = engine_texts(*BEFORE_STEPPER, "runge_kutta/extremes")
    last = engine_texts(*AFTER_STEPPER)
    roots, along = engine_texts("taylor/roots", "taylor/along")
    size, advance, lanes = engine_texts("taylor/size", "taylor/advance", "taylor/lanes")
    texts = _series(codes)
    names = _first_of_equals(texts)
    steps = [roots, _table(codes, names), _twice(along), size, advance, _in_lanes(lanes)]
    engine = [*first, *steps, *last]
    written: tuple[list[str], list[str]] = [], []
    for name in dict.fromkeys(names.values()):
        written[name.endswith("_lanes")].append(texts[name])
    shared = _header(codes) + arithmetic()
    if functions.directions:
        # A motion with derivatives runs alone: its lanes are directions.
        head = f"#define PS_LANES 1\n#define PS_DIRECTIONS {functions.directions}\n"
        shared = "".join([head, shared, *engine_texts("taylor/tangents")])
    return assemble(functions, more, "", engine, shared, written)


def arithmetic() -> str:
    """Return the C that series are made of, which needs math.h alone."""
    series, angles = engine_texts("taylor/series", "taylor/angles")
    factorials = initializer(1 / math.factorial(k) for k in range(ORDER + 1))
    table = f"static const double PS_INVERSE_FACTORIAL[] = {factorials};\n"
    return table + series + _twice(angles)


def _twice(text: str) -> str:
    """Return C for one motion, and the same for lanes of motions."""
    one, lanes = (
        "\n".join(
            [
                *(f"#define PS_{name} {values[i]}" for name, values in _MACROS.items()),
                text.rstrip(),
                *(f"#undef PS_{name.partition('(')[0]}" for name in _MACROS),
                "",
            ]
        )
        for i in (0, 1)
    )
    return one + _in_lanes(lanes)


def _code(functions: AutomatonFunctions, tape: SeriesTape, name: str) -> _ModeCode:
    if not functions.directions:
        return _ModeCode(SeriesCode(tape, name), None)

    @functools.cache
    def moves(scalar: Scalar) -> bool:
        return bool(functions.slopes(tape.scalars.expression(scalar)).nnz())

    tangents = Tangents(tape, functions.moved_states, moves)
    series = SeriesCode(tape, name, functions.x.numel())
    return _ModeCode(series, TangentCode(tangents, series, functions.directions))


def _series(codes: list[_ModeCode]) -> dict[str, str]:
    """Return the functions of every mode by name; modes of the same motion share theirs."""
    alone = [text for c in codes for text in (c.series.text, c.series.guards_text)]
    alone += [c.tangents.text for c in codes if c.tangents]
    lanes = _functions([c.series.lanes_text for c in codes if not c.tangents])
    return _functions(alone) | {name: _in_lanes(text) for name, text in lanes.items()}


def _functions(texts: Sequence[str]) -> dict[str, str]:
    matches = (m for text in texts for m in _FUNCTION.finditer(text))
    return {m[1]: m[0].replace("static", "PS_SHARED", 1) for m in matches}


def _in_lanes(text: str) -> str:
    """Return C that is compiled for lanes of motions only, where PS_LANES is more than 1."""
    return f"#if PS_LANES > 1\n{text.rstrip()}\n#endif\n"


def _first_of_equals(texts: Mapping[str, str]) -> dict[str, str]:
    """Return for every function the name of the first one that computes the same."""
    first: dict[str, str] = {}
    return {name: first.setdefault(text.replace(name, "", 1), name) for name, text in texts.items()}


def _scalars(functions: AutomatonFunctions, code: _ModeCode, i: int) -> ca.Function:
    expression = code.series.tape.scalars.expression
    values = [expression(s) for s in code.series.scalars] or [ca.SX(0.0)]
    if code.tangents:
        moving = ca.vertcat(*map(expression, code.tangents.scalars))
        values.append(ca.vec(functions.slopes(moving).T))
    arguments = [functions.x, functions.z, functions.c]
    return ca.Function(f"scalars_{i}", arguments, [ca.cse(ca.densify(ca.vertcat(*values)))])


def _padded(n: int) -> int:
    """Round up to whole vectors."""
    return max(1, -(-n // WIDTH)) * WIDTH


def _header(codes: list[_ModeCode]) -> str:
    series = [code.series for code in codes]
    sizes = {
        "ORDER": ORDER,
        "LENGTH": _LENGTH,
        "COLUMNS": _padded(max(code.columns for code in series)),
        "WATCHED": _padded(max(len(code.tape.guards) + len(code.ramps) for code in series)),
        "SCALARS": max(code.scalar_count for code in codes),
        "RAMPS": max(1, *(len(code.ramps) for code in series)),
        "ARGUMENTS": max(1, *(len(code.arguments) for code in series)),
        "STAGES": 2,
    }
    lines = [f"#define PS_{name} {value}" for name, value in sizes.items()]
    fields = (
        "int order, ready, left_out, missed; double unit, bend, zero, "
        "scalars[PS_SCALARS], live[PS_RAMPS], "
        "v[PS_LENGTH][PS_COLUMNS];"
    )
    inverse = initializer([0.0, *(1 / k for k in range(1, ORDER + 1))])
    binomials = ([1 / math.comb(n, k) for k in range(n + 1)] for n in range(ORDER + 1))
    rows = ",\n".join(f"  {initializer(row)}" for row in binomials)
    lines += [
        f"#define PS_STEPPER {fields}",
        f"static const double PS_INVERSE[PS_ORDER + 1] = {inverse};",
        "static const double PS_INVERSE_BINOMIAL[PS_ORDER + 1][PS_ORDER + 1] = {",
        rows,
        "};",
        "",
    ]
    return "\n".join(lines)


_GUARDS = (
    "typedef void (*ps_guards{0})(const {1} *, int, const {1} *, const {1} (*)[PS_COLUMNS], "
    "{1} (*restrict)[PS_WATCHED]);"
)
_TANGENTS = (
    "void (*tangents)(const double *, const double *, const double *, int, double, double, int, "
    "double (*restrict)[PS_COLUMNS]);"
)


def _table(codes: list[_ModeCode], names: Mapping[str, str]) -> str:
    lines = [
        "#if PS_LANES > 1",
        "#define PS_WIDE(function) function",
        "#else",
        "#define PS_WIDE(function) 0",
        "#endif",
        _GUARDS.format("", "double"),
        _GUARDS.format("_lanes", "ps_lanes"),
        "typedef struct {",
        "  void (*series)(const double *, const double *, const double *, int, double, double,",
        "                 double (*restrict)[PS_COLUMNS]);",
        "  ps_guards guards;",
        "  void (*series_lanes)(const ps_lanes *, const ps_lanes *, const ps_lanes *, int,",
        "                       const ps_lanes *, ps_lanes (*restrict)[PS_COLUMNS]);",
        "  ps_guards_lanes guards_lanes;",
        *(f"  {line}" for line in [_TANGENTS] if codes[0].tangents),
        "  ps_function scalars;",
        "  int scalar_count, columns;",
        "  ps_bits of_states;  /* guards that are sums of states */",
        "  int ramps, ramp[PS_RAMPS], guarded[PS_RAMPS];  /* columns; a guard is zero with it */",
        "  double floor[PS_RAMPS];",
        "  int arguments, argument[PS_ARGUMENTS], sides[PS_ARGUMENTS];",
        "} ps_series;",
        "static const ps_series PS_SERIES[PS_NV] = {",
    ]
    for i, code in enumerate(code.series for code in codes):
        own = [names[f"series_{i}{e}"] for e in ("", "_guards")]
        own += [f"PS_WIDE({names.get(f'series_{i}{e}', '0')})" for e in ("_lanes", "_guards_lanes")]
        own += [names[f"series_{i}_tangents"]] if codes[i].tangents else []
        row = f"{', '.join(own)}, scalars_{i}, {len(code.scalars)}, {code.columns}"
        row += f", {code.guards_of_states}ull"
        ramps = initializer(map(code.column, code.ramps))
        guarded = initializer(int(code.guarded(r)) for r in code.ramps)
        floors = initializer(map(code.floor, code.ramps))
        lines.append(f"  {{{row}, {len(code.ramps)}, {ramps}, {guarded}, {floors},")
        places = initializer(map(code.column, code.arguments))
        sides = initializer(code.arguments.values())
        lines.append(f"   {len(code.arguments)}, {places}, {sides}}},")
    return "\n".join([*lines, "};", ""])
