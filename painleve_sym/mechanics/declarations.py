"""Declarations of a mechanism or a law: coordinates and parameters, by name, unit and range.

Nothing here needs SymPy until a symbol is asked for, so that names and defaults are quick to have.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, TypeVar, cast

from painleve_sym.checks import LARGEST, SMALLEST, by_name, checked_values, size_text
from painleve_sym.units import Value

if TYPE_CHECKING:
    from sympy import Expr, Symbol

PLAYS_NO_PART = "plays no part in derivations"
NOT_DERIVED_FROM: Mapping[str, bool] = {PLAYS_NO_PART: True}
"""Metadata of a dataclass field that no derivation depends on, such as a default value."""

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

    Examples
    --------
    >>> import painleve_sym as ps
    >>> x = ps.Coordinate("x", "place of the block along the belt", "m")
    >>> x.symbol, x.name, x.unit
    (x, 'x', 'm')
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
    def velocity(self) -> Velocity:
        """Its velocity."""
        name, meaning = f"{self.name}_dot", f"velocity of {self.name}"
        return Velocity(name, meaning, f"{self.unit}/s", self.name)

    @cached_property
    def rate(self) -> Expr:
        """Its rate: the symbol of its velocity."""
        return self.velocity.symbol

    @cached_property
    def acceleration(self) -> Symbol:
        """Symbol of the acceleration."""
        return _symbol(f"{self.name}_ddot", real=True)


@dataclass(frozen=True)
class Velocity:
    """A velocity of a mechanism: the rate of a coordinate, or a part of an angular velocity.

    Attributes
    ----------
    name : str
        Name used in states.
    meaning : str
        One sentence.
    unit : str
        In SI.
    row : str
        Name of its row in the equations of motion and among generalized forces: that of the
        coordinate whose rate it is; its own for a part of an angular velocity.
    """

    name: str
    meaning: str
    unit: str
    row: str

    @cached_property
    def symbol(self) -> Symbol:
        """Symbol of the velocity."""
        return _symbol(self.name, real=True)


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
    material : str
        Property of a material that it stands for, one of `materials.PROPERTIES`; empty for none.
    body : int
        Whose property: 1, the moving body; 2, the other; 0, both are of one material.
    input_of : str
        Name of the `Input` whose value or derivative it is; empty for a constant.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> mu = ps.Parameter("mu", 0.6, "1", "friction coefficient", lower=0.0)
    >>> mu.symbol, mu.default, mu.lower
    (mu, 0.6, 0.0)
    """

    name: str
    default: float = field(metadata=NOT_DERIVED_FROM)
    unit: str
    meaning: str
    lower: float = -float("inf")
    upper: float = float("inf")
    lower_closed: bool = True
    upper_closed: bool = True
    material: str = field(default="", metadata=NOT_DERIVED_FROM)
    body: int = field(default=1, metadata=NOT_DERIVED_FROM)
    input_of: str = field(default="", metadata=NOT_DERIVED_FROM)

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
        tiny = self.lower == 0 and not self.lower_closed and 0 < value < SMALLEST
        if above and below and abs(value) <= LARGEST and not tiny:
            return None
        size = f", of at least {SMALLEST:g}" if tiny else size_text(value)
        need = self.range_text + size
        return f"parameter {self.name} ({self.meaning}): got {value!r}, need {need}."

    @property
    def range_text(self) -> str:
        """The valid range in words, e.g. ``0 <= e_energetic <= 1``."""
        text = self.name
        if self.lower != -float("inf"):
            text = f"{self.lower:g} {'<=' if self.lower_closed else '<'} {text}"
        if self.upper != float("inf"):
            text = f"{text} {'<=' if self.upper_closed else '<'} {self.upper:g}"
        return f"a finite number with {text}" if text != self.name else "a finite number"


def positive(
    name: str, default: float, unit: str, meaning: str, material: str = "", body: int = 1
) -> Parameter:
    """Return a parameter that must be > 0; `material` and `body` are those of `Parameter`."""
    return Parameter(
        name, default, unit, meaning, 0.0, lower_closed=False, material=material, body=body
    )


@dataclass(frozen=True)
class DomainBound:
    """A condition the model needs: `margin` > 0 inside its domain.

    Below `near`, numbers lose digits as the margin, which has no unit, goes to 0; a notice says so.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> ps.models.rod().domain[0].meaning
    'the rod lies flat at theta = 0'
    """

    margin: Expr
    meaning: str
    near: float = 0.0


class ParameterSet:
    """Parameters that are given together, such as those of a mechanism and of its law.

    Attributes
    ----------
    by_name : dict of str to Parameter
    defaults : dict of str to float
    """

    def __init__(self, *parameters: Parameter) -> None:
        self.by_name = {p.name: p for p in parameters}
        self.defaults = {p.name: p.default for p in parameters}

    def values(self, where: str, given: Mapping[str, Value] | None) -> dict[str, float]:
        """Return every parameter's value: the given one, else its default.

        A text is a number with a unit, such as ``200 g``. `where` begins messages.

        Raises
        ------
        InputError
            Unknown names, values that are not finite or out of range; all faults at once.
        """
        known = self.by_name
        if type(given) is dict:
            # A check of all at once; where it fails, each is looked at.
            whole = {**self.defaults, **given}
            if len(whole) == len(known) and all(
                type(v) is float and known[n].fault(v) is None for n, v in given.items()
            ):
                return cast(dict[str, float], whole)
        return checked_values(
            where,
            "parameter",
            by_name(given, f"{where}: parameters", "{'mu': 0.5}"),
            self.defaults,
            lambda name: known[name].unit,
            lambda name, value: known[name].fault(value),
        )


def with_defaults(
    where: str, declared: Sequence[Parameter], given: Mapping[str, Value]
) -> tuple[Parameter, ...]:
    """Return the parameters with the `given` values as their defaults."""
    values = ParameterSet(*declared).values(where, given)
    return tuple(replace(p, default=values[p.name]) for p in declared)


def settings_text(choices: Mapping[str, str], parameters: Sequence[Parameter]) -> str:
    """Return choices and defaults in one line, such as ``(reload=virgin): E=2.09e+11, nu=0.3``."""
    chosen = f"({', '.join(f'{k}={v}' for k, v in choices.items())})" if choices else ""
    return f"{chosen}: " + ", ".join(f"{p.name}={p.default:g}" for p in parameters)


_Record = TypeVar("_Record")


def with_fields(record: _Record, **fields: object) -> _Record:
    """Return a copy of a frozen dataclass that keeps everything it has derived.

    Only for fields that no derivation depends on (`NOT_DERIVED_FROM`), and for cached properties
    whose value is known; for other fields `replace`.
    """
    changed = copy.copy(record)
    changed.__dict__.update(fields)
    return changed


def _symbol(name: str, **assumptions: bool) -> Symbol:
    from sympy import Symbol

    return Symbol(name, **assumptions)
