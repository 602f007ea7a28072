"""What a mechanism or a law declares: coordinates and parameters, by name, unit and range.

Nothing here needs SymPy until a symbol is asked for, so that names and defaults are quick to have.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sympy import Symbol

TIME_NAME = "t"
"""Name of the time in states and formulas."""


@dataclass(frozen=True)
class Coordinate:
    """A generalized coordinate and its velocity.

    Attributes
    ----------
    name : str
        Name used in states; the velocity is ``name + "_dot"``.
    meaning : str
        One sentence.
    unit : str
        SI unit of the coordinate ("m" or "rad").
    latex : str
        LaTeX of the symbol, empty for SymPy's own.
    """

    name: str
    meaning: str
    unit: str
    latex: str = ""

    @cached_property
    def symbol(self) -> Symbol:
        """Symbol of the coordinate."""
        return _symbol(self.name, real=True)

    @cached_property
    def rate(self) -> Symbol:
        """Symbol of the velocity."""
        return _symbol(f"{self.name}_dot", real=True)

    @cached_property
    def acceleration(self) -> Symbol:
        """Symbol of the acceleration."""
        return _symbol(f"{self.name}_ddot", real=True)


@dataclass(frozen=True)
class Parameter:
    """A constant of a mechanism or of a contact law.

    Attributes
    ----------
    name : str
    default : float
        Value used when none is given, in `unit`.
    unit : str
    meaning : str
    lower, upper : float
        Valid range; the end points belong to it only where `lower_closed`, `upper_closed` say so.
    """

    name: str
    default: float
    unit: str
    meaning: str
    lower: float = -float("inf")
    upper: float = float("inf")
    lower_closed: bool = True
    upper_closed: bool = True

    @cached_property
    def symbol(self) -> Symbol:
        """Symbol: positive, nonnegative or real as the range tells."""
        if self.lower > 0 or (self.lower == 0 and not self.lower_closed):
            return _symbol(self.name, positive=True)
        if self.lower == 0:
            return _symbol(self.name, nonnegative=True)
        return _symbol(self.name, real=True)

    def fault(self, value: float) -> str | None:
        """Return one sentence when `value` is not valid, else None."""
        above = value >= self.lower if self.lower_closed else value > self.lower
        below = value <= self.upper if self.upper_closed else value < self.upper
        if above and below and abs(value) != float("inf"):
            return None
        return f"parameter {self.name} ({self.meaning}): got {value!r}, need {self.range_text}."

    @property
    def range_text(self) -> str:
        """The valid range in words, e.g. ``0 <= e_energetic <= 1``."""
        text = self.name
        if self.lower != -float("inf"):
            text = f"{self.lower:g} {'<=' if self.lower_closed else '<'} {text}"
        if self.upper != float("inf"):
            text = f"{text} {'<=' if self.upper_closed else '<'} {self.upper:g}"
        return f"a finite number with {text}" if text != self.name else "a finite number"


def _symbol(name: str, **assumptions: bool) -> Symbol:
    from sympy import Symbol

    return Symbol(name, **assumptions)
