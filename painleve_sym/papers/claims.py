"""Claims of a paper, read from the one data file of its folder, ``claims.toml``."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any

import sympy as sp

from painleve_sym.papers.formula import expression
from painleve_sym.papers.item import Verdict
from painleve_sym.references import Reference, reference


@dataclass(frozen=True)
class Printed:
    """A number as it is printed, with all its digits, such as ``-0.0337``.

    `within` is the tolerance where the paper calls the number approximate; `where` tells section,
    meaning and unit.
    """

    text: str
    within: float | None = None
    where: str = ""

    @property
    def value(self) -> float:
        """The number."""
        return float(self.text)

    @property
    def tolerance(self) -> float:
        """`within`, or half a unit of the last digit printed."""
        if self.within is not None:
            return self.within
        exponent = Decimal(self.text).as_tuple().exponent
        return 0.5 * 10.0 ** int(exponent)

    def matches(self, computed: float) -> bool:
        """Return whether the number computed is printed correctly."""
        # A computed number that lies on the edge rounds either way: 1e-6 of the digit decides.
        return bool(abs(computed - self.value) <= self.tolerance * (1 + 1e-6))


@dataclass(frozen=True)
class PrintedFormula:
    """A formula of the paper: where it is printed, the formula for people, and its right side.

    The title is empty where only the derivations compare it, the expression where the paper leaves
    the line out. Of a misprint there are the right side without it (`corrected`), the same for
    people (`holds`), and the fault; of a formula that is right in itself and used where it does not
    hold, the same with `differs` in place of `misprint`. With `copy` the fault may be that of the
    copy that was read.
    """

    number: str
    text: str
    title: str = ""
    expression: str = ""
    corrected: str = ""
    holds: str = ""
    misprint: str = ""
    differs: str = ""
    copy: bool = False

    @property
    def fault(self) -> str:
        """Reason for which the formula is not reproduced; empty where it is."""
        return self.misprint or self.differs

    @property
    def expected(self) -> Verdict:
        """The verdict that the derivation establishes."""
        if self.differs:
            return Verdict.DIFFERS
        return Verdict.MISPRINT if self.misprint else Verdict.REPRODUCED


@dataclass(frozen=True)
class ItemClaim:
    """One thing the paper says in short, or with printed numbers, and how it fares.

    The verdict expected is that of the derivations and of independent computations; in the reason
    ``{name}`` stands for a computed number. With `copy` a misprint may be a fault of the copy.
    """

    group: str
    title: str
    paper: str = ""
    expected: Verdict = Verdict.REPRODUCED
    reason: str = ""
    copy: bool = False


@dataclass(frozen=True)
class Claims:
    """Everything a paper prints that is compared with.

    `letters` are those in which the paper writes another formula, with the name of that formula.
    `numbers` are single ones in the text. `items` are in the order in which they are reported; each
    titled formula is one. `data` are other tables of the file, which only the paper's own modules
    read.
    """

    source: Reference
    formulas: Mapping[str, PrintedFormula] = field(default_factory=dict)
    letters: Mapping[str, str] = field(default_factory=dict)
    numbers: Mapping[str, Printed] = field(default_factory=dict)
    items: Mapping[str, ItemClaim] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)

    def expression(
        self, formula: str, names: Mapping[str, sp.Expr], corrected: bool = False
    ) -> sp.Expr:
        """Return the right side of a formula, as printed or with its misprint removed.

        To the meanings of the names the letters of other formulas are added.
        """
        claim = self.formulas[formula]
        letters = {
            letter: expression(self.formulas[name].expression, names)
            for letter, name in self.letters.items()
            if letter in claim.expression
        }
        text = claim.corrected if corrected and claim.corrected else claim.expression
        return expression(text, {**names, **letters})


@cache
def read_claims(path: Path) -> Claims:
    """Return the claims of a ``claims.toml``; TypeError where an entry has or lacks a key."""
    with path.open("rb") as file:
        data = tomllib.load(file)
    source = reference(data.pop("source"))
    formulas = {k: PrintedFormula(**v) for k, v in data.pop("formulas", {}).items()}
    items = {
        name: ItemClaim(
            group="formula",
            title=formula.title,
            paper=formula.text,
            expected=formula.expected,
            reason=formula.fault.replace("{", "{{").replace("}", "}}"),
            copy=formula.copy,
        )
        for name, formula in formulas.items()
        if formula.title
    }
    for name, entry in data.pop("items", {}).items():
        expected = Verdict(entry.pop("expected", Verdict.REPRODUCED.value))
        items[name] = ItemClaim(**entry, expected=expected)
    return Claims(
        source=source,
        formulas=formulas,
        letters=data.pop("letters", {}),
        numbers={k: Printed(**v) for k, v in data.pop("numbers", {}).items()},
        items=items,
        data=data,
    )
