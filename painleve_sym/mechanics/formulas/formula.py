"""A named closed form, its value as text, LaTeX and Python, and how a long formula is wrapped."""

from __future__ import annotations

import graphlib
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import sympy as sp

from painleve_sym.equality import Compared
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.quantities import QUANTITIES, derivative_latex

# A formula of more operations does not fit on a line of a page.
_LONG = 30
# A part of fewer operations, or one that spares fewer, is not worth a name.
_NAMED = 5
_SPARED = 25

Value: TypeAlias = sp.Basic | sp.MatrixBase
"""An expression or a matrix of expressions."""


@dataclass(frozen=True, repr=False, eq=False)
class Formula(Compared):
    """One closed form; `latex` is its left side, and the name also that of the Python function.

    `symbols` are the meanings of symbols that do not belong to the mechanism.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> energies = ps.closed_forms(ps.models.rod())[0]
    >>> formula = energies.formulas[1]
    >>> formula.name, formula.value, formula.unit
    ('V', g*m*(l*sin(theta) + y_A), 'J')
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


@dataclass(frozen=True, eq=False)
class ImpulsePhase(Compared):
    """A phase of the jump, with names and meanings of its values in the velocities at its start.

    Its conditions must hold at the start: in words, the margin, whether it must be > 0 and not only
    ≥ 0.
    """

    name: str
    meaning: str
    values: Mapping[str, sp.Expr]
    conditions: tuple[tuple[str, sp.Expr, bool], ...]


@dataclass(frozen=True, repr=False)
class Section:
    """A group of formulas, or of phases of the jump.

    `contact` is the one whose least critical friction has no closed form; else empty.
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


def alone(section: Section, contact: str) -> Section:
    """Return a section with the name of its contact, which stands as if the others were open."""
    formulas = tuple(
        replace(f, name=f"{f.name}_{contact}", latex=rf"\left({f.latex}\right)_{{{contact}}}")
        for f in section.formulas
    )
    return replace(section, title=f"{section.title}, {contact} alone", formulas=formulas)


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
    """Return a value as `text`, `latex` and `python`; matrices as nested lists of text."""
    return {
        "text": _by_entry(value, plain),
        "latex": sp.latex(value, symbol_names=dict(names)),
        "python": _by_entry(value, python_code),
    }


def named_parts(values: Sequence[Value]) -> tuple[dict[sp.Symbol, sp.Expr], list[Value]]:
    """Return names of the parts that long values share, and the values written with them.

    A part is named where that spares most operations. In the order returned, a part uses only
    earlier ones. With every symbol replaced by its part, last one first, each value is the one
    given, term by term; what SymPy would arrange in another way, as -(a + b), is left whole.
    """
    entries = {e for v in values if sp.count_ops(v) > _LONG for e in _entries(v)}
    written = {entry: entry for entry in sorted(entries, key=sp.default_sort_key)}
    parts: dict[sp.Symbol, sp.Expr] = {}
    while (part := _best_part([*written.values(), *parts.values()], written.values())) is not None:
        # A name of its own: by the number that SymPy gives, sums would differ from run to run.
        swap = {part: sp.Dummy(f"part_{len(parts):04}", real=True)}
        written = {entry: w.xreplace(swap) for entry, w in written.items()}
        parts = {symbol: p.xreplace(swap) for symbol, p in parts.items()}
        parts[swap[part]] = part
    ordered = _in_order(parts)
    kept = {e: w if _whole(w, ordered) == e else e for e, w in written.items()}
    used = _free(kept.values())
    for symbol in reversed(ordered):
        used |= ordered[symbol].free_symbols if symbol in used else set()
    names = dict(zip((s for s in ordered if s in used), _unused_symbols(values), strict=False))
    short = {entry: form.xreplace(names) for entry, form in kept.items()}
    return (
        {name: ordered[symbol].xreplace(names) for symbol, name in names.items()},
        [_by_value(value, short) for value in values],
    )


def _entries(value: Value) -> list[sp.Expr]:
    return list(value) if isinstance(value, sp.MatrixBase) else [value]


def _by_value(value: Value, short: Mapping[sp.Expr, sp.Expr]) -> Value:
    if isinstance(value, sp.MatrixBase):
        return value.applyfunc(lambda entry: short.get(entry, entry))
    return short.get(value, value)


def _free(values: Iterable[sp.Expr]) -> set[sp.Basic]:
    return set().union(*(v.free_symbols for v in values))


def _in_order(parts: Mapping[sp.Symbol, sp.Expr]) -> dict[sp.Symbol, sp.Expr]:
    """Return the parts so that each uses only earlier ones."""
    # In the order of the parts: that of a set would differ from run to run.
    needs = {symbol: [s for s in parts if s in p.free_symbols] for symbol, p in parts.items()}
    return {s: parts[s] for s in graphlib.TopologicalSorter(needs).static_order()}


def _whole(written: sp.Expr, parts: dict[sp.Symbol, sp.Expr]) -> sp.Expr:
    """Return a value with every part in its place again."""
    for symbol in reversed(parts):
        written = written.xreplace({symbol: parts[symbol]})
    return written


def _unused_symbols(values: Sequence[Value]) -> Iterator[sp.Symbol]:
    """Yield chi_1, chi_2, ... or the next letter's, so that no symbol of the values is one."""
    taken = {str(symbol).partition("_")[0] for v in values for symbol in v.free_symbols}
    letter = next(name for name in ("chi", "xi", "eta", "upsilon", "aux") if name not in taken)
    names: Iterator[sp.Symbol] = sp.numbered_symbols(f"{letter}_", start=1, real=True)
    return names


def _best_part(entries: Sequence[sp.Expr], whole: Collection[sp.Expr]) -> sp.Expr | None:
    """Return the part that spares most operations where it is written once; None for too few.

    None of those that are whole values, which have names already.
    """
    counts = Counter(part for entry in entries for part in sp.preorder_traversal(entry))
    shared = [p for p, n in counts.items() if n > 1 and p not in whole and not _is_inverse(p)]
    sizes = {part: int(sp.count_ops(part)) for part in shared}
    spared = {p: (counts[p] - 1) * size for p, size in sizes.items() if size >= _NAMED}
    most = max(spared.values(), default=0)
    return min((p for p, n in spared.items() if n == most), key=str) if most >= _SPARED else None


def _is_inverse(part: sp.Basic) -> bool:
    """Return whether 1 over something, which the page writes as a denominator."""
    return bool(part.is_Pow and part.args[1].could_extract_minus_sign())


def _by_entry(value: Value, write: Callable[[sp.Basic], str]) -> Any:
    if isinstance(value, sp.MatrixBase):
        return [[write(value[i, j]) for j in range(value.cols)] for i in range(value.rows)]
    return write(value)


def wrap_expression(start: str, text: str, width: int = 80, indent: str = "") -> list[str]:
    """Return `start` and a formula as lines, broken before + or − in as few brackets as can be.

    `start` opens the first line; the others open with `indent`.
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
