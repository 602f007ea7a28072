"""Formulas written as text become SymPy expressions; nothing in the text is executed.

Allowed are numbers, declared names, `pi`, + − * / **, brackets, and the functions sin, cos, tan,
sqrt, exp, log, atan2, abs, and pulse, square, triangle of the time. Python's parser reads the text,
and each node of its tree is translated by an explicit rule; what has no rule is a fault. Limits
keep 9**9**9 or a thousand brackets from taking time or memory.
"""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from painleve_sym.errors import unknown_name
from painleve_sym.mechanics.pulses import pulse, square, triangle
from painleve_sym.mechanics.system import not_finite, singular_part

MAX_LENGTH = 4000
"""Characters of one formula."""
MAX_DEPTH = 40
"""Brackets and functions within each other."""
MAX_NODES = 4000
"""Parts of a formula after its definitions are substituted: they could double at each use."""
MAX_EXPONENT = 40
"""Size of a whole exponent: higher powers are not mechanics, and multiply out to millions."""
MAX_DIGITS_BITS = 700
"""Size of the whole numbers in an exact fraction: two numbers at the limits of `MAX_MAGNITUDE`."""
MAX_MAGNITUDE = 1e100
"""Size of a number, and of its reciprocal: far beyond mechanics in any units, and short as a
fraction. Sums of products of such numbers stay in the range of floating point."""

_ONE = range(1, 2)
_FUNCTIONS: Mapping[str, tuple[range, Callable[..., sp.Expr], Callable[..., float]]] = {
    "sin": (_ONE, sp.sin, math.sin),
    "cos": (_ONE, sp.cos, math.cos),
    "tan": (_ONE, sp.tan, math.tan),
    "sqrt": (_ONE, sp.sqrt, math.sqrt),
    "exp": (_ONE, sp.exp, math.exp),
    "log": (_ONE, sp.log, math.log),
    "atan2": (range(2, 3), sp.atan2, math.atan2),
    "abs": (_ONE, sp.Abs, abs),
    "pulse": (range(2, 5), pulse, lambda *a: float(pulse(*a).doit())),
    "square": (range(2, 5), square, lambda *a: float(square(*a).doit())),
    "triangle": (range(2, 5), triangle, lambda *a: float(triangle(*a).doit())),
}
CONSTANTS: Mapping[str, sp.Expr] = {"pi": sp.pi}
_OPERATORS: Mapping[type[ast.operator], tuple[str, Callable[..., Any]]] = {
    ast.Add: ("+", operator.add),
    ast.Sub: ("-", operator.sub),
    ast.Mult: ("*", operator.mul),
    ast.Div: ("/", operator.truediv),
    ast.Pow: ("**", operator.pow),
}
_OTHER_OPERATORS: Mapping[type[ast.operator], str] = {
    ast.BitXor: "write ** for a power",
    ast.FloorDiv: "write /",
    ast.MatMult: "write *",
}


@dataclass(frozen=True)
class TextFault:
    """Fault in a formula, with its line within the text, from 0."""

    message: str
    line: int = 0


@dataclass(frozen=True)
class _Part:
    """A translated part: its expression, its number of nodes, its value where it is a number."""

    expr: sp.Expr
    size: int = 1
    value: float | None = None


class _Refused(Exception):
    """A part could not be translated; its faults are recorded already."""


@dataclass
class Formulas:
    """The names formulas may use; grows as definitions are added.

    `sizes` tell how many parts each definition stands for; `broken` are names defined by a formula
    with faults.
    """

    names: dict[str, sp.Expr]
    sizes: dict[str, int] = field(default_factory=dict)
    broken: set[str] = field(default_factory=set)

    def define(self, name: str, text: object) -> list[TextFault]:
        """Define `name` as a formula; return the fault of the formula."""
        part, faults = self._translate(text)
        if part is None:
            # Later uses are not faults of their own.
            self.broken.add(name)
            self.names[name] = sp.Symbol(name, real=True)
        else:
            self.names[name] = part.expr
            self.sizes[name] = part.size
        return faults

    def read(self, text: object) -> tuple[sp.Expr | None, list[TextFault]]:
        """Return the expression of a formula or number and no faults, or None and all faults."""
        part, faults = self._translate(text)
        return (part.expr if part else None), faults

    def _translate(self, text: object) -> tuple[_Part | None, list[TextFault]]:
        if isinstance(text, bool) or not isinstance(text, str | int | float):
            return None, [TextFault(f"got {text!r}, need a formula in quotes or a number.")]
        if isinstance(text, float) and not math.isfinite(text):
            return None, [TextFault(f"got {text!r}, need a finite number.")]
        source = text if isinstance(text, str) else repr(text)
        fault = _text_fault(source)
        if fault:
            return None, [fault]
        # Line ends become blanks, so that a formula may take several lines.
        flat = " ".join(source.split("\n"))
        start = len(flat) - len(flat.lstrip())
        tree = _parse(flat.strip())
        if isinstance(tree, str):
            return None, [TextFault(tree, source.count("\n", 0, start))]
        walk = _Walk(self, source, start)
        try:
            part = walk.part(tree, 0)
        except _Refused:
            return None, walk.faults
        if part.expr.has(sp.zoo, sp.nan, sp.oo, -sp.oo, sp.I):
            return None, [TextFault(f"got {part.expr}, need finite real values.")]
        if (zero := singular_part(part.expr)) is not None:
            return None, [TextFault(not_finite(zero))]
        return part, []


def _text_fault(source: str) -> TextFault | None:
    if not source.strip():
        return TextFault("the formula is empty. Fix: write one, or 0.")
    if len(source) > MAX_LENGTH:
        return TextFault(
            f"the formula has {len(source)} characters, need at most {MAX_LENGTH}. "
            "Fix: split it with [definitions]."
        )
    for i, char in enumerate(source):
        if char in "#\\\"'" or not (char.isascii() and (char.isprintable() or char in "\n\r\t")):
            return TextFault(
                f"character {char!r} is not allowed in a formula. Fix: use letters, digits, "
                "+ - * / ** and brackets.",
                source.count("\n", 0, i),
            )
    return None


def _parse(flat: str) -> ast.expr | str:
    """Return the syntax tree, or one sentence saying why there is none."""
    try:
        with warnings.catch_warnings():
            # Such as "1if x": the walk rejects it, without a warning.
            warnings.simplefilter("ignore")
            return ast.parse(flat, mode="eval").body
    except SyntaxError as error:
        near = flat[max((error.offset or 1) - 1, 0) :][:20]
        where = f" at {near!r}" if near else ""
        return f"cannot parse {flat[:60]!r} ({error.msg}{where})."
    except (ValueError, RecursionError, MemoryError):
        return "the formula is nested too deeply. Fix: split it with [definitions]."


class _Walk:
    """One translation of a syntax tree, with the faults met on the way."""

    def __init__(self, formulas: Formulas, source: str, start: int) -> None:
        self.formulas, self.source, self.start = formulas, source, start
        self.faults: list[TextFault] = []

    def refuse(self, node: ast.AST, message: str) -> _Refused:
        column = self.start + getattr(node, "col_offset", 0)
        fault = TextFault(message, self.source.count("\n", 0, column))
        if fault not in self.faults:
            self.faults.append(fault)
        return _Refused()

    def part(self, node: ast.expr, depth: int) -> _Part:
        """Return the translated node; raise _Refused after noting its faults."""
        if depth > MAX_DEPTH:
            fix = "Fix: split it with [definitions]."
            raise self.refuse(node, f"more than {MAX_DEPTH} brackets within each other. {fix}")
        if isinstance(node, ast.BinOp):
            return self._chain(node, depth)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
            inner = self.part(node.operand, depth + 1)
            if isinstance(node.op, ast.UAdd):
                return inner
            value = None if inner.value is None else -inner.value
            return _Part(-inner.expr, inner.size + 1, value)
        if isinstance(node, ast.Constant):
            return self._number(node)
        if isinstance(node, ast.Name):
            return self._name(node)
        if isinstance(node, ast.Call):
            return self._call(node, depth)
        kind = type(node).__name__
        raise self.refuse(
            node,
            f"{kind} is not allowed in a formula. Fix: use + - * / **, brackets and functions.",
        )

    def _chain(self, node: ast.BinOp, depth: int) -> _Part:
        """Translate a + b − c …, whose tree leans left, without going deeper for each term."""
        links: list[ast.BinOp] = []
        first: ast.expr = node
        while isinstance(first, ast.BinOp):
            links.append(first)
            first = first.left
        parts = self._all([first, *(link.right for link in reversed(links))], depth)
        total = parts[0]
        for link, right in zip(reversed(links), parts[1:], strict=True):
            total = self._join(link, total, right)
        return total

    def _all(self, nodes: list[ast.expr], depth: int) -> list[_Part]:
        """Translate every node, so that the faults of all are recorded."""
        parts, refused = [], False
        for node in nodes:
            try:
                parts.append(self.part(node, depth + 1))
            except _Refused:
                refused = True
        if refused:
            raise _Refused
        return parts

    def _number(self, node: ast.Constant) -> _Part:
        number = node.value
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise self.refuse(node, f"{number!r} is not a number. Fix: write 0.5 or 1e-3.")
        # Decimals are taken as they are written: 0.1 is 1/10, and 0.5 stays short.
        try:
            value = float(number)
        except OverflowError:
            value = math.inf
        self._check_size(node, value)
        exact = sp.Integer(number) if isinstance(number, int) else sp.Rational(repr(number))
        return _Part(exact, 1, value)

    def _name(self, node: ast.Name) -> _Part:
        known = self.formulas.names
        if node.id in known:
            if node.id in self.formulas.broken:
                raise _Refused
            return _Part(known[node.id], self.formulas.sizes.get(node.id, 1))
        if node.id in CONSTANTS:
            return _Part(CONSTANTS[node.id], 1, float(CONSTANTS[node.id]))
        if node.id in _FUNCTIONS:
            raise self.refuse(node, f"{node.id} is a function. Fix: write {node.id}(...).")
        raise self.refuse(node, unknown_name("name", node.id, [*known, *CONSTANTS]))

    def _call(self, node: ast.Call, depth: int) -> _Part:
        if not isinstance(node.func, ast.Name):
            raise self.refuse(node, "only a named function can be called, such as sin(x).")
        name = node.func.id
        if name not in _FUNCTIONS:
            if name in self.formulas.names or name in CONSTANTS:
                raise self.refuse(node, f"{name!r} is not a function. Fix: write * for a product.")
            raise self.refuse(node, unknown_name("function", name, _FUNCTIONS))
        count, symbolic, numeric = _FUNCTIONS[name]
        if node.keywords or len(node.args) not in count:
            most = count[-1]
            need = "one argument" if most == 1 else f"{most} arguments"
            need = need if len(count) == 1 else f"{count[0]} to {need}"
            raise self.refuse(node, f"{name}: got {len(node.args)}, need {need}.")
        return self._combined(node, name, symbolic, numeric, self._all(node.args, depth))

    def _join(self, node: ast.BinOp, left: _Part, right: _Part) -> _Part:
        if type(node.op) not in _OPERATORS:
            fix = _OTHER_OPERATORS.get(type(node.op), "use + - * / **")
            name = type(node.op).__name__
            raise self.refuse(node, f"operator {name} is not allowed in a formula. Fix: {fix}.")
        sign, apply = _OPERATORS[type(node.op)]
        if sign == "/" and right.expr == 0:
            raise self.refuse(node, "division by zero.")
        if sign == "**":
            self._check_power(node, left, right)
        return self._combined(node, sign, apply, apply, [left, right])

    def _check_power(self, node: ast.BinOp, base: _Part, exponent: _Part) -> None:
        """Reject powers that would take long to form, or to multiply out later."""
        if exponent.value is None:
            return
        if abs(exponent.value) > MAX_EXPONENT:
            received = f"{exponent.value:g}"
            raise self.refuse(node, f"exponent {received}: need at most {MAX_EXPONENT} in size.")
        if base.expr == 0 and exponent.value <= 0:
            raise self.refuse(node, "division by zero: a power of 0 needs an exponent > 0.")
        bits = _bits(base.expr) * abs(exponent.value)
        if bits > MAX_DIGITS_BITS:
            raise self.refuse(node, "the power has too many digits.")

    def _combined(
        self,
        node: ast.expr,
        name: str,
        symbolic: Callable[..., sp.Expr],
        numeric: Callable[..., float],
        parts: list[_Part],
    ) -> _Part:
        """Return an operator or a function of parts; reject expressions that are too large."""
        value = self._value(node, name, numeric, [p.value for p in parts])
        expr, size = symbolic(*(p.expr for p in parts)), 1 + sum(p.size for p in parts)
        if size > MAX_NODES:
            raise self.refuse(
                node,
                f"the formula, definitions included, has more than {MAX_NODES} parts. "
                "Fix: use fewer coordinates, or shorter definitions.",
            )
        if value is not None:
            self._check_size(node, value)
        elif name in ("*", "/", "**"):
            for term in sp.Add.make_args(expr):
                self._check_size(node, float(term.as_coeff_Mul(rational=True)[0]))
        # A product of equal factors is a power, too.
        powers = [a.exp for a in sp.Mul.make_args(expr) if a.is_Pow and a.exp.is_Integer]
        if any(abs(int(p)) > MAX_EXPONENT for p in powers):
            raise self.refuse(node, f"a power in all higher than {MAX_EXPONENT}.")
        if value is not None and _bits(expr) > MAX_DIGITS_BITS:
            raise self.refuse(node, "the number has too many digits.")
        return _Part(expr, size, value)

    def _check_size(self, node: ast.expr, number: float) -> None:
        """Reject a number that is too large or too small."""
        if number and not 1 / MAX_MAGNITUDE <= abs(number) <= MAX_MAGNITUDE:
            size = "large" if abs(number) > 1 else "small"
            raise self.refuse(
                node,
                f"the number {number:g} is too {size}, need {1 / MAX_MAGNITUDE:g} to "
                f"{MAX_MAGNITUDE:g} in size.",
            )

    def _value(
        self, node: ast.expr, name: str, numeric: Callable[..., float], values: list[float | None]
    ) -> float | None:
        """Return the number a constant part has; reject it where it is not finite or vanishes."""
        known = [v for v in values if v is not None]
        if len(known) != len(values):
            return None
        try:
            value = numeric(*known)
        except (OverflowError, ZeroDivisionError, ValueError):
            value = math.nan
        if isinstance(value, complex) or not math.isfinite(value):
            text = ", ".join(f"{v:g}" for v in known)
            raise self.refuse(node, f"{name} of {text} is not a finite real number.")
        if value == 0 and name in ("**", "exp", "*", "/") and known[0] != 0 and known[-1] != 0:
            raise self.refuse(node, f"the number is too small: {name} gives less than 1e-308.")
        return value


def _bits(expr: sp.Expr) -> int:
    """Return the size of the largest whole number in an expression of numbers."""
    numbers = expr.atoms(sp.Rational)
    return max((max(int(n.p).bit_length(), int(n.q).bit_length()) for n in numbers), default=0)
