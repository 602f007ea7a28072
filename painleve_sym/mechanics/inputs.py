"""Inputs: functions of time in the formulas of a mechanism, of which each run gives the values."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from painleve_sym.choices import Interpolation, InterpolationLike
from painleve_sym.mechanics.declarations import Parameter

if TYPE_CHECKING:
    import sympy as sp

ORDER = {Interpolation.HELD: 0, Interpolation.LINEAR: 1, Interpolation.CUBIC: 3}
"""Degree of the polynomials in time by which an input is given."""
_MEANINGS = ("", "rate of {}", "second derivative of {}", "third derivative of {}")


def derivative_names(name: str, order: int) -> tuple[str, ...]:
    """Return the names of the value of an input and of its derivatives up to an order."""
    return (name, *(f"{name}_{'d' * k}ot" for k in range(1, order + 1)))


def instant_name(name: str) -> str:
    """Return the name of the time at which an input has its value and derivatives."""
    return f"{name}_t0"


@dataclass(frozen=True)
class Input:
    """A function of time u(t) in the formulas of a mechanism, given by pieces.

    In each piece u(t) is a polynomial in t − t₀. Its value and derivatives at t₀, and t₀ where
    there are derivatives, are parameters of the mechanism: `u`, `u_dot`, …, `u_t0`. A run sets them
    at the beginning of each piece (see `painleve_sym.simulate`); elsewhere they are constants.

    Parameters
    ----------
    name : str
    unit : str
        In SI.
    meaning : str
    interpolation : Interpolation or its text
        The highest that values of it may have: ``held`` has no derivative.
    default : float
        Value where none is given.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> from painleve_sym.mechanics import Input
    >>> table = Input("u", "m", "place of the table", "linear")
    >>> [p.name for p in table.parameters]
    ['u', 'u_dot', 'u_t0']
    >>> table.expression
    u + u_dot*(t - u_t0)
    """

    name: str
    unit: str
    meaning: str = ""
    interpolation: InterpolationLike = Interpolation.HELD
    default: float = 0.0

    @property
    def order(self) -> int:
        """Degree of its polynomials."""
        return ORDER[Interpolation(self.interpolation)]

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Value, derivatives and their time, to be declared with those of the mechanism."""
        meaning, own = self.meaning or self.name, self.name
        unit = "" if self.unit == "1" else self.unit
        declared = []
        for k, name in enumerate(derivative_names(self.name, self.order)):
            power = f"/s^{k}" if k > 1 else "/s"
            of = self.unit if k == 0 else f"{unit or '1'}{power}"
            text = meaning if k == 0 else _MEANINGS[k].format(self.name)
            declared.append(
                Parameter(name, self.default if k == 0 else 0.0, of, text, input_of=own)
            )
        if self.order:
            text = f"time at which {self.name} has these derivatives"
            declared.append(Parameter(instant_name(self.name), 0.0, "s", text, input_of=own))
        return tuple(declared)

    @cached_property
    def derivatives(self) -> tuple[sp.Expr, ...]:
        """The input and its derivatives, functions of the time."""
        if not self.order:
            return (self.parameters[0].symbol,)
        from painleve_sym.mechanics.system import TIME

        *values, instant = (p.symbol for p in self.parameters)
        return tuple(_polynomial(values[k:], TIME - instant) for k in range(len(values)))

    @property
    def expression(self) -> sp.Expr:
        """The input as a formula, to be used in those of a mechanism."""
        return self.derivatives[0]


def _polynomial(derivatives: Sequence[sp.Expr], since: sp.Expr) -> sp.Expr:
    """Return the polynomial in the time since some instant that has these derivatives there."""
    import sympy as sp

    total: sp.Expr = sp.Integer(0)
    for k, value in reversed(list(enumerate(derivatives, 1))):
        total = value + since * total / k
    return total


def inputs_of(parameters: Iterable[Parameter]) -> dict[str, int]:
    """Return the degree of each declared input by its name."""
    names = [p.name for p in parameters if p.input_of == p.name]
    known = {p.name for p in parameters}
    return {
        name: max(k for k in (0, 1, 3) if set(derivative_names(name, k)) <= known) for name in names
    }
