"""C text of CasADi functions, without the unused code around them."""

from __future__ import annotations

import re
import tempfile
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import casadi as ca

_EXPORT = "#define CASADI_SYMBOL_EXPORT static __attribute__((unused))\n"
# Each function comes with a dozen that describe it (names, sparsity, work space): half of the text.
_ABOUT = (
    "alloc_mem|checkout|decref|default_in|free_mem|incref|init_mem|n_in|n_out|name_in|name_out|"
    "release|sparsity_in|sparsity_out|work|work_bytes|casadi_version|casadi_int_size|"
    "casadi_real_size"
)
_DESCRIPTION = re.compile(
    rf"^CASADI_SYMBOL_EXPORT [^\n]*_(?:{_ABOUT})\([^\n]*\{{"
    r"(?:[^\n]*\}\n|\n(?:[^\n]*\n)*?\}\n)\n?",
    re.M,
)
_SPARSITY = re.compile(
    r"^(?:static const casadi_int casadi_s\d+\[|#define casadi_s\d+ )[^\n]*\n", re.M
)
_BLOCK = re.compile(r"^(?=/\* \w+:\()", re.M)
_WHOLE = re.compile(
    r"/\* (?P<name>\w+):\([^\n]*\n"
    r"static int (?P<own>casadi_f\d+)(?P<body>\([^\n]*\{\n.*?\n\}\n)\s*"
    r"CASADI_SYMBOL_EXPORT int (?P=name)\([^\n]*\{\n  return (?P=own)\([^\n]*\n\}\s*",
    re.S,
)
_SIGNATURE = re.compile(r"^(PS_SHARED [^{;]*?) \{", re.M)
_PLAIN_HEAD = re.compile(r"^#if PS_HAS\((\d+)\)\n", re.M)
_FOR_LANES = re.compile(r"^#if PS_LANES > 1\nPS_SHARED .*?^\}\n#endif\n", re.M | re.S)
_EMPTY_PART = re.compile(r"^#if PS_HAS\(\d+\)(?: /\*[^\n]*\*/)?\n\s*#endif\n", re.M)
_LONG = re.compile(
    r"^static int (?P<name>casadi_f\d+)\([^\n]*\{\n(?:  casadi_real [^\n]*;\n)+"
    r"(?P<body>(?:  [^\n]*=[^\n]*;\n)+)  return 0;\n\}\n",
    re.M,
)
_VARIABLE = re.compile(r"\ba\d+\b")
_END = "#ifdef __cplusplus\n}"

_PARTS = """\
/* All of this file is one library. With -DPS_PART=i only part i of it is compiled: 0 is the event
 * loop, the others are generated functions. */
#ifdef PS_PART
#define PS_HAS(part) (PS_PART == part)
#define PS_SHARED __attribute__((visibility("hidden")))
#else
#define PS_HAS(part) 1
#define PS_SHARED static __attribute__((unused))
#endif
#define CASADI_SYMBOL_EXPORT PS_SHARED
"""
_SHARED = "/* ---- what every part sees ---- */"
_PART_LENGTH = 25_000
"""Characters of CasADi's functions in one part: a compiler takes half a second for them."""
_DENSE_LENGTH = 20_000
"""Characters of other functions that take it as long: their loops are what it works on."""


_PIECE = 250
"""Statements of CasADi's functions in one function of C: the time of compilers grows faster than
the length of a function, and that of twice as many is cut."""

_PIECE_ARGUMENTS = "const casadi_real **arg, casadi_real **res, casadi_real *v"

_STRAIGHT = "-Og"
"""How far CasADi's functions are optimized: -O3 takes the compiler twice as long, and makes no run
faster that was measured."""

_SINGLE = "-O1 -ftree-vectorize -fvect-cost-model -falign-functions=64"
"""How far the event loop and the series of single motions are optimized: that spares the compiler
a third of its time, and runs take 6 % less to 4 % more. Functions that begin anywhere make the
rod's run a tenth slower by chance."""


class Written(NamedTuple):
    """Functions of C, and how far they are to be optimized where that is not as in `FLAGS`."""

    texts: Sequence[str]
    level: str = ""


def c_functions(functions: Iterable[ca.Function]) -> str:
    """Return the C text of functions, to be used within the same file."""
    return _EXPORT + _generated(functions)


def c_file(
    functions: Sequence[ca.Function],
    callers: str,
    shared: str = "",
    more: Sequence[Written] = (),
) -> str:
    """Return a C file of functions and of the code that calls them.

    Its parts may be compiled side by side (`compile.compiled_library`). `callers` may name every
    function, every part sees `shared` first, and `more` are further functions, each `PS_SHARED`, in
    groups of which no part has two, with how far they are to be optimized.
    """
    text = _generated(functions)
    text, end, rest = text.rpartition(_END)
    head, *blocks = _BLOCK.split(text)
    blocks, declared = _without_copies(blocks)
    blocks = [_LONG.sub(_in_pieces, block) for block in blocks]
    arguments = "(const casadi_real **, casadi_real **, casadi_int *, casadi_real *, int);"
    declared += [f"PS_SHARED int {f.name()}{arguments}" for f in functions]
    declared += [
        f"{head};" for group in more for text in group.texts for head in _SIGNATURE.findall(text)
    ]
    groups = [(text, _STRAIGHT) for text in _shared_out(blocks, _PART_LENGTH)]
    groups += [(text, of.level) for of in more for text in _shared_out(of.texts, _DENSE_LENGTH)]
    parts = [_part(i, text, level) for i, (text, level) in enumerate(groups, 1)]
    # The callers come last, where the functions are known.
    pieces = (
        _PARTS + head,
        _SHARED,
        shared,
        _SHARED,
        *declared,
        "",
        *parts,
        end + rest,
        _part(0, callers, ""),
    )
    return "\n".join(pieces)


def shared_text(file: str) -> str:
    """Return what every part of a file of `c_file` sees."""
    return file.split(_SHARED)[1].strip("\n")


def for_single_motions(file: str) -> str:
    """Return a file of `c_file` to be compiled in less time, for motions one at a time."""
    file = _EMPTY_PART.sub("", _FOR_LANES.sub("", file))

    return _PLAIN_HEAD.sub(lambda plain: _head(int(plain[1]), _SINGLE), file)


def _part(number: int, text: str, level: str) -> str:
    return f"{_head(number, level)}{text}\n#endif\n"


def _head(number: int, level: str) -> str:
    return f"#if PS_HAS({number}){f' /* {level} */' * bool(level)}\n"


def _without_copies(blocks: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the blocks without duplicates, and their names.

    Modes have much in common: of the functions of a rod every third is another one's copy.
    """
    calls = Counter(n for block in blocks for n in set(re.findall(r"\bcasadi_f\d+\b", block)))
    first: dict[str, str] = {}
    kept, names = [], []
    for block in blocks:
        whole = _WHOLE.fullmatch(block)
        if whole and calls[whole["own"]] == 1:
            name = first.setdefault(whole["body"], whole["name"])
            if name != whole["name"]:
                names.append(f"#define {whole['name']} {name}")
                continue
        kept.append(block)
    return kept, names


def _shared_out(blocks: Sequence[str], length: int) -> list[str]:
    """Return the blocks joined to texts of about that length, in their order."""
    whole = sum(map(len, blocks))
    count = max(1, round(whole / length)) if blocks else 0
    texts, before = [""] * count, 0
    for block in blocks:
        texts[min(count - 1, before * count // whole)] += block
        before += len(block)
    return [text for text in texts if text]


def _in_pieces(function: re.Match[str]) -> str:
    """Return a long function as a chain of short ones.

    What one leaves for others lies in an array, which has a place for each variable.
    """
    lines = function["body"].splitlines()
    if len(lines) < 2 * _PIECE:
        return function[0]
    places = 1 + max(int(a[1:]) for a in _VARIABLE.findall(function["body"]))
    name, needed = function["name"], set[str]()
    texts: list[str] = []
    for first in reversed(range(0, len(lines), _PIECE)):
        own = lines[first : first + _PIECE]
        inputs, written = _read_and_written(own)
        starts = (f"{a} = {_place(a)}" if a in inputs else a for a in sorted(inputs | written))
        declared = ", ".join(starts)
        kept = [f"  {_place(a)} = {a};" for a in sorted(written & needed)]
        needed = needed - written | inputs
        head = f"static __attribute__((noinline)) void {name}_{first}({_PIECE_ARGUMENTS}) {{"
        unused = "  (void)arg; (void)res; (void)v;"
        texts.append("\n".join((head, f"  casadi_real {declared};", *own, *kept, unused, "}\n")))
    calls = [f"  {name}_{first}(arg, res, v);" for first in range(0, len(lines), _PIECE)]
    head = function[0].partition("\n")[0]
    kept_for_others = f"  casadi_real v[{places}];"
    return "\n".join((*reversed(texts), head, kept_for_others, *calls, "  return 0;\n}\n"))


def _place(variable: str) -> str:
    """Return the place of a variable in the array that pieces share."""
    return f"v[{int(variable[1:])}]"


def _read_and_written(lines: Sequence[str]) -> tuple[set[str], set[str]]:
    """Return the variables that statements read before they set them, and those that they set."""
    inputs, written = set[str](), set[str]()
    for line in lines:
        target, _, value = line.partition("=")
        inputs |= {*_VARIABLE.findall(value)} - written
        written |= {*_VARIABLE.findall(target)}
    return inputs, written


def _generated(functions: Iterable[ca.Function]) -> str:
    options: Any = {"with_header": False, "with_export": True, "casadi_int": "long long int"}
    generator = ca.CodeGenerator("generated.c", options)
    for f in functions:
        generator.add(f)
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(f"{folder}/")
        text = Path(folder, "generated.c").read_text("utf-8")
    text = _DESCRIPTION.sub("", text)
    without = _SPARSITY.sub("", text)
    text = text if re.search(r"\bcasadi_s\d", without) else without
    # More than one part may need them.
    text = re.sub(r"^casadi_real casadi_", "static inline casadi_real casadi_", text, flags=re.M)
    # No caller passes null pointers; the tests for them cost half of the compilation.
    text = re.sub(r"if \(res\[(\d+)\]!=0\) res", "res", text)
    return re.sub(r"arg\[(\d+)\]\? (arg\[\1\]\[\d+\]) : 0", r"\2", text)
