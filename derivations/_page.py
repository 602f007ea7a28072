"""A derivation as data: its steps, their comparison with the paper, and the pages they make."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import sympy as sp

from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.papers.formula import identical
from painleve_sym.papers.impact_resolution.claims import CLAIMS
from painleve_sym.quantities import derivative_latex
from painleve_sym.references import reference

ROOT = Path(__file__).resolve().parent.parent
ASSUMPTIONS = (
    "planar",
    "one contact",
    "point contact",
    "constant μ",
    "tangential rigidity",
    "frozen configuration",
    "rigid bodies",
)
"""The assumptions of docs/assumptions.md, in its order."""
EQUAL = "equal"
NOT_COMPARED = "not printed"


def cited(key: str) -> str:
    """Return the citation of a work as a link to its entry on the page of references."""
    return f"[{reference(key).label}](../references.md#{key.lower()})"


REFERENCE = (
    f"Numbers in brackets are equations of {cited(CLAIMS.source.key)}; "
    "SI units, radians. Every comparison below is asserted when this page is made."
)


@dataclass(frozen=True)
class Quantity:
    """A symbol with the way it is written, its unit and its meaning."""

    symbol: sp.Symbol
    latex: str
    unit: str
    meaning: str


@dataclass(frozen=True)
class Step:
    """One step: a text, its result, and the formula of the paper it is compared with.

    Attributes
    ----------
    text : str
        Why it follows; Markdown.
    derived : sympy.Eq
        The result, on the left side as a symbol. A symbol there becomes a generated function.
    formula : str
        Name of the formula in the claims of the paper; empty where the paper prints none.
    where : mapping of str to sympy.Expr
        Letters of that formula that are not symbols of the page.
    printed : sympy.Expr or None
        Its right side; by default as the claims have it.
    package : sympy.Expr or None
        Right side as the package gives it.
    function : str
        Name of the generated function, by default that of the left side.
    """

    text: str
    derived: sp.Eq
    formula: str = ""
    where: Mapping[str, sp.Expr] = field(default_factory=dict)
    printed: sp.Expr | None = None
    package: sp.Expr | None = None
    function: str = ""

    @property
    def number(self) -> str:
        """Place of the formula in the paper, such as ``(14), P_n1``."""
        return CLAIMS.formulas[self.formula].number if self.formula else ""

    @property
    def fault(self) -> str:
        """The fault of the printed formula; empty where it has none."""
        return CLAIMS.formulas[self.formula].fault if self.formula else ""

    @property
    def verdict(self) -> str:
        """``equal``, ``misprint: ...``, ``differs: ...`` or ``not printed``."""
        if not self.formula:
            return NOT_COMPARED
        claim = CLAIMS.formulas[self.formula]
        copy = " or fault of the copy" if claim.copy else ""
        return f"{claim.expected.value}{copy}: {self.fault}" if self.fault else EQUAL

    def check(self) -> None:
        """Assert that derivation, package and paper agree, or that the fault is one."""
        if self.package is not None:
            assert identical(self.derived.rhs, self.package), f"package differs: {self.derived}"
        if self.printed is not None:
            same = identical(self.derived.rhs, self.printed)
            expected = not self.fault
            assert same == expected, f"paper {self.number} {self.verdict}, but got: {self.derived}"


@dataclass(frozen=True)
class Derivation:
    """Steps with the quantities they use; `write` makes the page and the Python module.

    Attributes
    ----------
    name, title, opening : str
        Of the page; Markdown.
    quantities : tuple of Quantity
    steps : tuple of Step
    without : mapping of str to str
        ``no`` or ``in part`` for each of `ASSUMPTIONS` that not every step needs.
    """

    name: str
    title: str
    opening: str
    quantities: tuple[Quantity, ...]
    steps: tuple[Step, ...]
    without: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        names = {str(q.symbol): q.symbol for q in self.quantities}
        names["e_s"] = names.get("e_energetic")
        steps = [
            replace(step, printed=CLAIMS.expression(step.formula, {**names, **step.where}))
            if step.formula and step.printed is None and CLAIMS.formulas[step.formula].expression
            else step
            for step in self.steps
        ]
        object.__setattr__(self, "steps", tuple(steps))

    def check(self) -> None:
        """Assert every comparison, and that every symbol is explained."""
        known = {q.symbol for q in self.quantities}
        for step in self.steps:
            missing = _symbols(step) - known
            assert not missing, f"{self.name}: symbols without meaning: {missing}"
            step.check()
        names = [_name(step) for step in self.steps if step.derived.lhs.is_Symbol]
        assert len(set(names)) == len(names), f"{self.name}: repeated function in {names}"
        assert set(self.without) <= set(ASSUMPTIONS), f"{self.name}: {set(self.without)}"

    def exceptions(self, need: str) -> str:
        """Name the assumptions with that need: ``no`` or ``in part``."""
        return ", ".join(n for n in ASSUMPTIONS if self.without.get(n) == need) or "–"

    @property
    def verdicts(self) -> tuple[tuple[str, str], ...]:
        """Equation number and verdict of every step that the paper prints."""
        return tuple((s.number, s.verdict) for s in self.steps if s.verdict != NOT_COMPARED)

    def markdown(self) -> str:
        """Return the page."""
        used = set().union(*(_symbols(step) for step in self.steps))
        rows = [
            f"| ${q.latex}$ | {q.unit} | {q.meaning} |" for q in self.quantities if q.symbol in used
        ]
        parts = [
            f"<!-- generated by derivations/{self.name}.py, do not edit -->",
            f"# {self.title}",
            self.opening,
            REFERENCE,
            "## Symbols",
            "\n".join(["| symbol | unit | meaning |", "|---|---|---|", *rows]),
            "## Steps",
        ]
        names = {q.symbol: q.latex for q in self.quantities}
        for index, step in enumerate(self.steps, 1):
            parts += [f"**{index}.** {step.text}", _display(step.derived, names)]
            parts += _comparison(step, names)
        return "\n\n".join(parts) + "\n"

    def python(self) -> str:
        """Return the module with one function per derived symbol."""
        functions = [
            _function(step, self.quantities) for step in self.steps if step.derived.lhs.is_Symbol
        ]
        head = (
            f'"""{self.title}.\n\n'
            f"generated by derivations/{self.name}.py, do not edit. SI units, radians.\n"
            f'"""\n\n'
        )
        body = "\n\n\n".join(functions)
        return head + ("import math\n\n\n" if "math." in body else "\n") + body + "\n"

    def write(self, root: Path = ROOT) -> tuple[Path, Path]:
        """Check, then write the page and the module below `root`; return their paths."""
        self.check()
        page = root / "docs" / "derivations" / f"{self.name}.md"
        module = root / "derivations" / "generated" / f"{self.name}.py"
        for path, text in ((page, self.markdown()), (module, self.python())):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
        return page, module


def mechanism_quantities(mechanism: Mechanism) -> tuple[Quantity, ...]:
    """Return coordinates, velocities, accelerations and parameters of a mechanism."""
    rows = []
    for c in mechanism.system.coordinates:
        name = c.latex or sp.latex(c.symbol)
        rows += [
            Quantity(c.symbol, name, c.unit, c.meaning),
            Quantity(c.rate, derivative_latex(name), f"{c.unit}/s", f"velocity of ${name}$"),
            Quantity(
                c.acceleration,
                derivative_latex(name, 2),
                f"{c.unit}/s²",
                f"acceleration of ${name}$",
            ),
        ]
    for p in mechanism.system.parameters:
        rows.append(Quantity(p.symbol, sp.latex(p.symbol), p.unit.replace("^2", "²"), p.meaning))
    return tuple(rows)


def _symbols(step: Step) -> set[sp.Symbol]:
    symbols: set[sp.Symbol] = set(step.derived.free_symbols)
    return symbols | (step.printed.free_symbols if step.printed is not None else set())


def _latex(expr: sp.Basic, names: dict[sp.Symbol, str]) -> str:
    text = sp.latex(expr, symbol_names=names)
    # A single letter needs no brackets: sin θ.
    return re.sub(r"(\\(?:sin|cos|tan)(?:\^\{\d+\})?)\{\\left\((\\\w+) \\right\)\}", r"\1 \2", text)


def _display(equation: sp.Basic, names: dict[sp.Symbol, str]) -> str:
    return f"$$\n{_latex(equation, names)}\n$$"


def _comparison(step: Step, names: dict[sp.Symbol, str]) -> Iterable[str]:
    lines = []
    if step.printed is not None:
        lines.append(
            f"*Paper {step.number}:* ${_latex(step.printed, names)}$ — **{step.verdict}**."
        )
    elif step.fault:
        lines.append(f"*Paper {step.number}:* **{step.verdict}**.")
    if step.package is not None:
        lines.append("*Package:* equal.")
    if lines:
        yield " ".join(lines)


def _name(step: Step) -> str:
    return step.function or str(step.derived.lhs)


def _function(step: Step, quantities: tuple[Quantity, ...]) -> str:
    lhs, rhs = step.derived.args
    result = next(q for q in quantities if q.symbol == lhs)
    arguments = [q for q in quantities if q.symbol in rhs.free_symbols]
    name = _name(step)
    lines = [f"def {name}({', '.join(f'{q.symbol}: float' for q in arguments)}) -> float:"]
    if len(lines[0]) > 96:
        lines = [f"def {name}(", *(f"    {q.symbol}: float," for q in arguments), ") -> float:"]
    source = f" Paper {step.number}." if step.number else ""
    lines += _wrapped(f'"""Return {_plain(result.meaning, quantities)}; {result.unit}.{source}')
    if not arguments:
        lines[-1] += '"""'
        return "\n".join([*lines, *_return(repr(float(rhs)))])
    lines += ["", "    Parameters", "    ----------"]
    for q in arguments:
        lines += [f"    {q.symbol} : float", f"        {_plain(q.meaning, quantities)}; {q.unit}."]
    code = sp.pycode(rhs)
    # A power of floats may be complex for all the type checker knows.
    lines += ['    """', *_return(f"float({code})" if re.search(r"\*\*(?!\d)", code) else code)]
    return "\n".join(lines)


def _return(code: str) -> list[str]:
    if len(code) <= 88:
        return [f"    return {code}"]
    return ["    return (", *("    " + line for line in _wrapped(code)), "    )"]


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, 92, initial_indent="    ", subsequent_indent="    ")


def _plain(meaning: str, quantities: tuple[Quantity, ...]) -> str:
    """Write the formulas of a sentence as the names the Python form uses."""
    names = {q.latex: str(q.symbol) for q in quantities}
    return re.sub(r"\$([^$]+)\$", lambda match: names.get(match[1], match[1]), meaning)
