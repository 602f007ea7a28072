"""Formulas as MathML, which browsers show without any script, printed by SymPy."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias

import sympy as sp
from sympy.functions.elementary.trigonometric import TrigonometricFunction
from sympy.printing.mathml import MathMLPresentationPrinter
from sympy.printing.pretty.pretty_symbology import greek_unicode

_NAME = re.compile(
    r"(?P<base>[^_]+)(?:_(?P<index>.+?))??(?:_(?P<dots>d{1,2}ot)(?:_(?P<time>\d+))?)?"
)
_DOTS = {"dot": "\u02d9", "ddot": "\u00a8"}
_THIN = "0.17em"
"""Space between a function and its neighbours, as TeX has it."""

Marks: TypeAlias = list[tuple[sp.Symbol, sp.Expr]]
"""Symbols, each with the part of a formula that it stands for."""


class _Printer(MathMLPresentationPrinter):
    """SymPy's printer with dots over velocities, and with marked parts."""

    def __init__(self, marked: dict[sp.Symbol, sp.Expr]) -> None:
        super().__init__()
        self.marked = marked

    def _node(self, tag: str, *children: Any, **attributes: str) -> Any:
        node = self.dom.createElement(tag)
        for name, value in attributes.items():
            node.setAttribute(name, value)
        for child in children:
            text = self.dom.createTextNode(child) if isinstance(child, str) else child
            node.appendChild(text)
        return node

    def _print_Symbol(self, sym: sp.Symbol, style: str = "plain") -> Any:
        if sym in self.marked:
            return self._node("mrow", self._print(self.marked[sym]), **{"class": "misprint"})
        parts = _NAME.fullmatch(sym.name)
        assert parts is not None
        node = self._node("mi", greek_unicode.get(parts["base"], parts["base"]))
        if parts["dots"]:
            # Not as an accent, which browsers without a font for formulas draw into the letter.
            node = self._node("mover", node, self._node("mo", _DOTS[parts["dots"]]))
        index = (parts["index"] or "").removesuffix("star").removesuffix("_")
        if index:
            below = [greek_unicode.get(word, word) for word in index.split("_")]
            node = self._node("msub", node, self._node("mi", ",".join(below)))
        if (parts["index"] or "").endswith("star"):
            node = self._node("msup", node, self._node("mo", "*"))
        if parts["time"]:
            time = self._node("msub", self._node("mi", "t"), self._node("mn", parts["time"]))
            between = (self._node("mo", "("), time, self._node("mo", ")"))
            node = self._node("mrow", node, *between)
        return node

    def _print_Function(self, e: sp.Function) -> Any:
        return self._applied(e, self._node("mi", self.mathml_tag(e)))

    def _print_Pow(self, e: sp.Pow) -> Any:
        """Print sin² θ for sin(θ)², and exponents of dotted letters at the height of others."""
        if isinstance(e.exp, sp.Integer) and e.exp > 0:
            if isinstance(e.base, TrigonometricFunction):
                name = self._node("mi", self.mathml_tag(e.base))
                return self._applied(e.base, self._node("msup", name, self._print(e.exp)))
            if isinstance(e.base, sp.Symbol) and e.base not in self.marked:
                base = self._node("mpadded", self._print(e.base), height="0.75em")
                return self._node("msup", base, self._print(e.exp))
        return super()._print_Pow(e)

    def _applied(self, e: sp.Function, name: Any) -> Any:
        """Return a function before its argument, which has brackets where it is not one symbol."""
        alone = len(e.args) == 1 and isinstance(e.args[0], sp.Symbol)
        inner = [self._paren_comma_separated(*e.args)]
        if alone and e.args[0] not in self.marked:
            inner = [self._node("mspace", width=_THIN), self._print(e.args[0])]
        space = self._node("mspace", width=_THIN)
        return self._node("mrow", space, name, self._node("mo", "\u2061"), *inner)


def symbol_mathml(name: str) -> str:
    """Return the symbol of a name, such as ``theta_dot``, as MathML within a line of text."""
    return f"<math>{_Printer({}).doprint(sp.Symbol(name))}</math>"


def mathml(value: Any, name: str = "", marked: Sequence[Any] = ()) -> str:
    """Return a formula, or an equation where a name stands before it, as a MathML element.

    The name is that of a symbol, such as ``theta_dot``; `marked` are the pairs of `with_marks`,
    whose parts have the class ``misprint``.
    """
    printer = _Printer(dict(marked))
    inner = printer.doprint(value)
    if name:
        inner = f"{printer.doprint(sp.Symbol(name))}<mo>=</mo>{inner}"
    inner = inner.replace("<mo>-</mo>", "<mo>\u2212</mo>")
    return f'<math display="block"><mrow>{inner}</mrow></math>'


def with_marks(
    printed: sp.Expr, correct: sp.Expr
) -> tuple[sp.Expr, tuple[tuple[sp.Symbol, sp.Expr], ...]]:
    """Return a formula with symbols in place of the parts that differ from the correct one.

    The symbols follow, each with the part it stands for; see `mathml`.
    """
    marks: Marks = []
    return _marked(printed, correct, marks), tuple(marks)


def _marked(printed: sp.Expr, correct: sp.Expr, marks: Marks) -> sp.Expr:
    if printed == correct:
        return printed
    if isinstance(printed, sp.Add | sp.Mul):
        own, other = list(printed.args), list(printed.func.make_args(correct))
        common = [a for a in own if a in other]
        rest = [a for a in own if a not in common]
        left = [a for a in other if a not in common]
        if rest:
            return printed.func(*common, *_paired(rest, left, marks))
    elif printed.func == correct.func and 0 < len(printed.args) == len(correct.args):
        pairs = zip(printed.args, correct.args, strict=True)
        return printed.func(*(_marked(a, b, marks) for a, b in pairs))
    return _mark(printed, marks)  # also where a part is missing, at no place that could be marked


def _paired(rest: Sequence[sp.Expr], left: list[sp.Expr], marks: Marks) -> Iterator[sp.Expr]:
    """Yield the parts, each compared with the one most like it, and marked where there is none."""

    def shared(part: sp.Expr, other: sp.Expr) -> int:
        kinds = (sp.Mul, sp.Add)
        common = max(len(set(k.make_args(part)) & set(k.make_args(other))) for k in kinds)
        if part.func != other.func:
            return common
        same_function = int(isinstance(part, sp.Function))
        return max(common, len(set(part.args) & set(other.args))) + same_function

    for part in rest:
        nearest = max(left, key=lambda other: shared(part, other), default=None)
        if nearest is None or not shared(part, nearest):
            yield _mark(part, marks)
            continue
        left.remove(nearest)
        yield _marked(part, nearest, marks)


def _mark(part: sp.Expr, marks: Marks) -> sp.Expr:
    if isinstance(part, sp.Pow) and part.exp.could_extract_minus_sign():
        return _mark(part.base, marks) ** part.exp  # it stays in the denominator
    symbol = sp.Dummy(f"mark{len(marks)}", positive=True)
    marks.append((symbol, part))
    return symbol
