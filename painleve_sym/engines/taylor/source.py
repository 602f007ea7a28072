"""The C source of an automaton with the Taylor stepper."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import casadi as ca

from painleve_sym.codegen.c_functions import Written
from painleve_sym.codegen.modes import AutomatonFunctions, VariantFunctions
from painleve_sym.engines.c_texts import engine_texts, initializer
from painleve_sym.engines.protocol import Place, Places
from painleve_sym.engines.source import (
    AFTER_STEPPER,
    BEFORE_STEPPER,
    assemble,
    every_variant,
    variant_file,
    variant_row,
)
from painleve_sym.engines.taylor import ORDER
from painleve_sym.engines.taylor.emit import WIDTH, SeriesCode
from painleve_sym.engines.taylor.scalars import Scalar
from painleve_sym.engines.taylor.simplify import simplify
from painleve_sym.engines.taylor.tangents import TangentCode, Tangents
from painleve_sym.engines.taylor.tape import FLAT, SeriesTape, build
from painleve_sym.errors import NoRecurrence, PainleveError

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


def tape(functions: AutomatonFunctions, of: VariantFunctions) -> SeriesTape:
    """Return the tape of a variant, or of a mode as it is.

    Raises
    ------
    NoRecurrence
        Names the mode and the operation.
    """
    every, own = (functions.x, functions.z, functions.c), functions.own
    nx = own[0].numel()
    expressions = ca.vertcat(of.smooth.rates, of.smooth.margins)
    if of.runs and not of.by_series:
        expressions = ca.vertcat(of.smooth.field(*every)[:nx], of.smooth.guards(*every)[0])
    try:
        built = build(expressions, *own, nx)
    except NoRecurrence as error:
        name = functions.automaton.modes[of.mode].name
        raise NoRecurrence(
            f"mode {name!r} uses {error} of a state, which has no Taylor series"
        ) from error
    # Only that there are series is of use where variants take the place of a mode.
    return simplify(built) if of.runs else built


class _ModeCode(NamedTuple):
    """C code of one mode's Taylor series, and of their derivatives if any."""

    series: SeriesCode
    tangents: TangentCode | None

    @property
    def scalar_count(self) -> int:
        """Numbers that `_scalars` returns."""
        more = self.tangents.directions * len(self.tangents.scalars) if self.tangents else 0
        return max(1, len(self.series.scalars) + more)


def source(functions: AutomatonFunctions, given: Places = ()) -> str:
    """Return one self-contained C file: event loop, series and guards of every mode."""
    variants = [_of(functions, v) for v in every_variant(functions, given)]
    tapes = [tape(functions, v) for v in variants]
    pairs = list(zip(variants, tapes, strict=True))
    codes = {v.smooth.number: _code(functions, v, t) for v, t in pairs if v.runs}
    more = [_scalars(functions, code, i) for i, code in codes.items()]
    first = engine_texts(*BEFORE_STEPPER, "runge_kutta/extremes")
    last = engine_texts(*AFTER_STEPPER)
    roots, along = engine_texts("taylor/roots", "taylor/along")
    size, advance, lanes = engine_texts("taylor/size", "taylor/advance", "taylor/lanes")
    written, names = _written(codes.values())
    steps = [roots, _twice(along), size, advance, _in_lanes(lanes)]
    rows = [variant_row(v, _row(codes.get(v.smooth.number), names)) for v in variants]
    switched = [t for v, t in pairs if not v.runs]
    shared = _header(functions, list(codes.values()), switched) + arithmetic()
    if functions.directions:
        # A motion with derivatives runs alone: its lanes are directions.
        head = f"#define PS_LANES 1\n#define PS_DIRECTIONS {functions.directions}\n"
        shared = "".join([head, shared, *engine_texts("taylor/tangents")])
    shared += _series_type(bool(functions.directions))
    engine = [*first, *steps, *last]
    return assemble(functions, variants, more, rows, "", engine, shared, written)


def _of(functions: AutomatonFunctions, variant: VariantFunctions) -> VariantFunctions:
    """Return a variant whose guards and jets are orders of its series, where formulas are long.

    That is where the automaton has terms: accelerations or contact forces solved for. Derivatives
    in given directions, and closed forms, have functions of their own.
    """
    by_series = bool(functions.automaton.terms) and not functions.directions
    return replace(variant, by_series=by_series)


def variant_source(functions: AutomatonFunctions, at: Place, file: str) -> str:
    """Return the C file of a variant, to be loaded beside the automaton's own `file`.

    PainleveError where it does not fit there.
    """
    number = len(functions.modes)
    variant = _of(functions, functions.variant(*at, number))
    code = _code(functions, variant, tape(functions, variant))
    _check_room(code, file)
    written, names = _written([code])
    row = variant_row(variant, _row(code, names))
    return variant_file(variant, [_scalars(functions, code, number)], row, file, written)


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


def _code(functions: AutomatonFunctions, of: VariantFunctions, tape: SeriesTape) -> _ModeCode:
    name = f"series_{of.smooth.number}"
    if not functions.directions:
        return _ModeCode(SeriesCode(tape, name), None)

    @functools.cache
    def moves(scalar: Scalar) -> bool:
        return bool(functions.slopes(tape.scalars.expression(scalar)).nnz())

    tangents = Tangents(tape, functions.moved_states, moves)
    series = SeriesCode(tape, name, functions.x.numel())
    return _ModeCode(series, TangentCode(tangents, series, functions.directions))


def _written(codes: Iterable[_ModeCode]) -> tuple[list[Written], dict[str, str]]:
    """Return the functions of series, and the name of the first that equals each, by name."""
    texts = _series(list(codes))
    names = _first_of_equals(texts)
    alone, lanes = list[str](), list[str]()
    for name in dict.fromkeys(names.values()):
        (lanes if name.endswith("_lanes") else alone).append(texts[name])
    return [Written(alone), Written(lanes)], names


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


def _header(
    functions: AutomatonFunctions, codes: list[_ModeCode], switched: list[SeriesTape]
) -> str:
    """Return sizes and tables; variants of the `switched` modes have room, too."""
    series = [code.series for code in codes]
    sizes = _room(functions, switched)

    def most(name: str, values: Iterable[int]) -> int:
        return max(1, sizes[name], *values)

    sizes = {
        "ORDER": ORDER,
        "LENGTH": _LENGTH,
        "COLUMNS": _padded(most("COLUMNS", (code.columns for code in series))),
        "WATCHED": _padded(
            most("WATCHED", (len(code.tape.guards) + len(code.ramps) for code in series))
        ),
        "SCALARS": most("SCALARS", (code.scalar_count for code in codes)),
        "RAMPS": most("RAMPS", (len(code.ramps) for code in series)),
        "ARGUMENTS": most("ARGUMENTS", (len(code.arguments) for code in series)),
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


_SCALARS_OF_VARIANTS = 64
"""Scalars of a variant beyond twice those of its mode as it is."""


def _room(functions: AutomatonFunctions, switched: list[SeriesTape]) -> dict[str, int]:
    """Return the sizes that variants of modes may have, by those of the modes as they are.

    Each guard has two columns and more than twice the scalars: variants need less than half.
    """
    room = dict.fromkeys(("COLUMNS", "WATCHED", "SCALARS", "RAMPS", "ARGUMENTS"), 0)
    for tape in switched:
        nodes = [tape.nodes[i] for i in tape.reachable()]
        ramps = sum(node.op == "ramp" for node in nodes)
        flat = sum(node.op in FLAT for node in nodes)
        guards, states = len(tape.guards), len(tape.rates)
        sizes = {
            "COLUMNS": states + 2 * guards + 2 * ramps + flat,
            "WATCHED": guards + ramps,
            "SCALARS": 2 * len(tape.monomials()) + _SCALARS_OF_VARIANTS,
            "RAMPS": ramps,
            "ARGUMENTS": flat,
        }
        room = {name: max(size, sizes[name]) for name, size in room.items()}
    return room


def _check_room(code: _ModeCode, file: str) -> None:
    series = code.series
    needs = {"COLUMNS": series.columns, "SCALARS": code.scalar_count, "RAMPS": len(series.ramps)}
    for name, need in needs.items():
        (has,) = re.findall(rf"^#define PS_{name} (\d+)$", file, re.M)
        if need > int(has):
            raise PainleveError(
                f"series of contacts that move together: {name.lower()}: got {need}, need at most "
                f"{has}. Please report it."
            )


_GUARDS = (
    "typedef void (*ps_guards{0})(const {1} *, int, const {1} *, const {1} (*)[PS_COLUMNS], "
    "{1} (*restrict)[PS_WATCHED]);"
)
_TANGENTS = (
    "void (*tangents)(const double *, const double *, const double *, int, double, double, int, "
    "double (*restrict)[PS_COLUMNS]);"
)


def _series_type(directions: bool) -> str:
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
        *(f"  {line}" for line in [_TANGENTS] if directions),
        "  int (*scalars)(const double **, double **, casadi_int *, double *, int);",
        "  int scalar_count, columns;",
        "  unsigned long long of_states;  /* guards that are sums of states */",
        "  int ramps, ramp[PS_RAMPS], guarded[PS_RAMPS];  /* columns; a guard is zero with it */",
        "  double floor[PS_RAMPS];",
        "  int arguments, argument[PS_ARGUMENTS], sides[PS_ARGUMENTS];",
        "} ps_series;",
        "#define PS_OWN_SERIES ps_series series;",
    ]
    return "\n".join([*lines, ""])


def _row(of: _ModeCode | None, names: Mapping[str, str]) -> str:
    """Return the series of a variant as the initialiser of a `ps_series`."""
    if of is None:
        return "{0}"
    code = of.series
    own = [names[f"{code.name}{e}"] for e in ("", "_guards")]
    own += [f"PS_WIDE({names.get(f'{code.name}{e}', '0')})" for e in ("_lanes", "_guards_lanes")]
    own += [names[f"{code.name}_tangents"]] if of.tangents else []
    number = code.name.removeprefix("series_")
    row = f"{', '.join(own)}, scalars_{number}, {len(code.scalars)}, {code.columns}"
    row += f", {code.guards_of_states}ull"
    ramps = initializer(map(code.column, code.ramps))
    guarded = initializer(int(code.guarded(r)) for r in code.ramps)
    floors = initializer(map(code.floor, code.ramps))
    places = initializer(map(code.column, code.arguments))
    sides = initializer(code.arguments.values())
    row += f", {len(code.ramps)}, {ramps}, {guarded}, {floors}"
    return f"{{{row}, {len(code.arguments)}, {places}, {sides}}}"
