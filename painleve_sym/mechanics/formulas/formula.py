"""A named closed form, its value as text, LaTeX and Python, and how a long formula is wrapped."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import sympy as sp

from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.quantities import QUANTITIES, derivative_latex

Value: TypeAlias = sp.Basic | sp.MatrixBase
"""An expression or a matrix of expressions."""


@dataclass(frozen=True, repr=False)
class Formula:
    """One closed form.

    Attributes
    ----------
    name : str
        Also the name of the Python function.
    value : sympy.Expr or sympy.Matrix
    unit, meaning, latex : str
        `latex` is the left side.
    symbols : mapping of sympy.Symbol to str
        Meaning of symbols that do not belong to the mechanism.
    """

    name: str
    value: Value
    unit: str
    meaning: str
    latex: str
    symbols: Mapping[sp.Symbol, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Return name, unit and meaning in one line; the value may be long."""
        return f"Formula {self.name!r} [{self.unit}]: {self.meaning}"

    def _repr_latex_(self) -> str:
        """Return the equation for notebooks; velocities have their dot."""
        return rf"$\displaystyle {self._equation()}$"

    def _equation(self, sign: str = "=") -> str:
        velocities = {
            s: derivative_latex(sp.latex(sp.Symbol(str(s).removesuffix("_dot"))))
            for s in sorted(self.value.free_symbols, key=str)
            if str(s).endswith("_dot")
        }
        return f"{self.latex} {sign} {sp.latex(self.value, symbol_names=velocities)}"

    @classmethod
    def of(cls, name: str, value: Value) -> Formula:
        """Return the formula of a registered quantity."""
        unit, latex, meaning = QUANTITIES[name]
        return cls(name, value, unit, meaning, latex)


@dataclass(frozen=True)
class ImpulsePhase:
    """A phase of the jump, with the names and meanings of what it gives.

    Attributes
    ----------
    name : str
    meaning : str
    values : mapping of str to sympy.Expr
        In the velocities at the start of the phase.
    conditions : tuple of (str, sympy.Expr, bool)
        What must hold at its start: in words, the margin, whether it must be > 0 and not only ≥ 0.
    """

    name: str
    meaning: str
    values: Mapping[str, sp.Expr]
    conditions: tuple[tuple[str, sp.Expr, bool], ...]


@dataclass(frozen=True, repr=False)
class Section:
    """A group of formulas, or of phases of the jump.

    Attributes
    ----------
    title, note : str
    formulas : tuple of Formula
    phases : tuple of ImpulsePhase
    contact : str
        The contact whose least critical friction has no closed form; else empty.
    """

    title: str
    formulas: tuple[Formula, ...] = ()
    phases: tuple[ImpulsePhase, ...] = ()
    note: str = ""
    contact: str = ""

    def __repr__(self) -> str:
        """Return the title with the names of formulas and phases in one line."""
        names = [*(f.name for f in self.formulas), *(phase.name for phase in self.phases)]
        return f"Section {self.title!r}: {', '.join(names)}"

    def _repr_latex_(self) -> str | None:
        """Return the equations for notebooks, one below the other; None where there are none."""
        if not self.formulas:
            return None
        lines = r" \\ ".join(formula._equation("&=") for formula in self.formulas)
        return rf"$\displaystyle \begin{{aligned}} {lines} \end{{aligned}}$"


def plain(expr: sp.Basic) -> str:
    """Return an expression as one line of text, with ^ for powers."""
    return str(expr).replace("**", "^")


def python_code(expr: sp.Basic) -> str:
    """Return an expression as Python that needs only `math`."""
    if expr.is_Integer:
        return str(float(expr))
    return str(sp.pycode(expr))


def latex_names(mechanism: Mechanism) -> dict[sp.Symbol, str]:
    r"""Return the LaTeX of coordinates and velocities by symbol, ``\dot{x}_A`` for x_A_dot."""
    system, names = mechanism.system, mechanism.latex_names
    return {symbol: names[symbol.name] for symbol in (*system.q, *system.q_dot)}


def written_forms(value: Value, names: Mapping[sp.Symbol, str]) -> dict[str, Any]:
    """Return a value as `text`, `latex` and `python`; matrices as nested lists of text and Python.

    Parameters
    ----------
    value : sympy.Expr or sympy.Matrix
    names : mapping of sympy.Symbol to str
        LaTeX of symbols.
    """
    return {
        "text": _by_entry(value, plain),
        "latex": sp.latex(value, symbol_names=dict(names)),
        "python": _by_entry(value, python_code),
    }


def _by_entry(value: Value, write: Callable[[sp.Basic], str]) -> Any:
    if isinstance(value, sp.MatrixBase):
        return [[write(value[i, j]) for j in range(value.cols)] for i in range(value.rows)]
    return write(value)


def wrap_expression(start: str, text: str, width: int = 80, indent: str = "") -> list[str]:
    """Return `start` and a formula as lines, broken before + or − in as few brackets as can be.

    Parameters
    ----------
    start : str
        Opens the first line; the others open with `indent`.
    text : str
    width : int
    indent : str
    """
    lines: list[str] = []
    line = start + text
    while len(line) > width:
        least = len(indent if lines else start) + 1
        half = (least + width) // 2
        places = list(_breaks(line, half, width)) or list(_breaks(line, least, width))
        if not places:
            break
        _, at = min(places, key=lambda place: (place[0], -place[1]))
        lines.append(line[:at].rstrip())
        line = indent + line[at:].lstrip()
    return [*lines, line]


def _breaks(line: str, least: int, most: int) -> Iterator[tuple[int, int]]:
    """Yield bracket depth and position of the spaces where a line may end."""
    depth = 0
    for i, character in enumerate(line[: most + 1]):
        depth += (character in "([{") - (character in ")]}")
        before_sign = line[i + 1 : i + 3] in ("+ ", "- ") or line[i + 1 : i + 3] in (">=", "> ")
        if character == " " and i >= least and (before_sign or line[i - 1] == ","):
            yield depth, i
