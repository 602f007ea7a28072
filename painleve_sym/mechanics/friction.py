"""The friction of a contact: its coefficient at rest, and in slip as a function of the speed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import sympy as sp

from painleve_sym.mechanics.declarations import DomainBound
from painleve_sym.mechanics.system import not_finite, singular_part, vanish_everywhere

if TYPE_CHECKING:
    from painleve_sym.mechanics.declarations import Parameter

SLIP_VELOCITY = sp.Symbol("v_t", real=True)
"""v_t in the formula of a friction curve; m/s."""
SPEED = sp.Symbol("slip_speed", nonnegative=True)
"""|v_t|; m/s."""

_ROUNDING = sp.Rational(1, 10**12)
"""Of a coefficient: by how much the one at rest may be less than that of slip."""


@dataclass(frozen=True)
class FrictionCurve:
    """Coefficients of friction: one up to which a contact sticks, and one in slip.

    Parameters
    ----------
    kinetic : sympy.Expr
        μ of slip, a formula of parameters and of `SLIP_VELOCITY`, which is the same for ±v_t.
    static : sympy.Expr
        μ_s of parameters alone; where it is None, μ at v_t = 0.
    """

    kinetic: sp.Expr
    static: sp.Expr | None = None

    @cached_property
    def _by_speed(self) -> sp.Expr:
        return sp.sympify(self.kinetic).xreplace({SLIP_VELOCITY: SPEED})

    def in_slip(self, speed: sp.Expr) -> sp.Expr:
        """Return μ at a speed |v_t|, written without the absolute value; m/s.

        The speed may be s v_t with s the sign of slip: the formula is smooth through v_t = 0.
        """
        return self._by_speed.xreplace({SPEED: speed})

    @cached_property
    def at_rest(self) -> sp.Expr:
        """μ_s."""
        return self.onset if self.static is None else sp.sympify(self.static)

    @cached_property
    def onset(self) -> sp.Expr:
        """μ of a slip that begins."""
        return self.in_slip(sp.Integer(0))

    @property
    def is_constant(self) -> bool:
        """Whether μ of slip does not depend on the speed."""
        return SPEED not in self._by_speed.free_symbols

    @property
    def is_coulomb(self) -> bool:
        """Whether one coefficient is that of rest and of all slips."""
        return self.is_constant and self.at_rest == self.kinetic

    @cached_property
    def slope(self) -> sp.Expr:
        """dμ/d|v_t| as a formula of `SPEED`; s/m."""
        return sp.diff(self._by_speed, SPEED)

    def faults(self, parameters: tuple[Parameter, ...]) -> Iterator[str]:
        """Yield a sentence for each fault of the formulas with parameters of these defaults."""
        known = {p.symbol for p in parameters}
        defaults = {p.symbol: sp.Float(p.default) for p in parameters}
        formulas = {"friction": self._by_speed}
        if self.static is not None:
            formulas["static_friction"] = self.at_rest
        for name, formula in formulas.items():
            allowed = known | ({SPEED} if name == "friction" else set())
            if unknown := sorted(formula.free_symbols - allowed, key=str):
                also = " and of v_t" if name == "friction" else ""
                yield (
                    f"{name}: got {', '.join(map(str, unknown))} in {formula}, need a formula of "
                    f"parameters alone{also}."
                )
                return
            if (part := singular_part(formula)) is not None:
                yield f"{name}: {not_finite(part)}"
                return
        mirrored = sp.sympify(self.kinetic).xreplace({SLIP_VELOCITY: -SPEED})
        if mirrored != self._by_speed and not vanish_everywhere([mirrored - self._by_speed]):
            yield (
                f"friction: got {self.kinetic}, which differs between v_t and -v_t, need a "
                "coefficient that is the same for both. Fix: write it with abs(v_t)."
            )
            return
        onset, rest = (sp.N(e.xreplace(defaults)) for e in (self.onset, self.at_rest))
        for name, value in (("friction at v_t = 0", onset), ("static_friction", rest)):
            if not (value.is_real and value.is_finite and value >= 0):
                yield f"{name}: got {value} at the defaults, need a number >= 0."
                return
        if rest < onset:
            yield (
                f"static_friction: got {rest} at the defaults, need at least the friction of slip "
                f"at v_t = 0, {onset}: a contact could neither stick nor slip between both."
            )

    def bounds(self, contact: str, speed: sp.Expr) -> tuple[DomainBound, ...]:
        """Return the conditions on the coefficients that SymPy does not know to hold everywhere.

        `speed` is |v_t| of the contact, called so in messages, as a function of its state.
        """
        bounds = []
        if not self.is_constant and not self._by_speed.is_nonnegative:
            meaning = f"the friction coefficient of contact {contact} is positive"
            bounds.append(DomainBound(self.in_slip(speed), meaning))
        excess = self.at_rest - self.onset
        if not excess.is_nonnegative:
            meaning = (
                f"the static friction of contact {contact} is at least that of slip at v_t = 0"
            )
            bounds.append(DomainBound(excess + _ROUNDING * self.onset, meaning))
        return tuple(bounds)
