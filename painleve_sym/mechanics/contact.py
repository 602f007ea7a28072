"""A frictional contact of a mechanism: gap, slip velocity, their Jacobians and rates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.errors import ModelError, unknown_name
from painleve_sym.mechanics.readable import readable
from painleve_sym.mechanics.system import LagrangianSystem


@dataclass(frozen=True)
class Contact:
    """A point of a mechanism against a surface, with Coulomb friction.

    Sign convention: the gap g_N is positive when the bodies are apart, the normal force
    F_n ≥ 0 pushes them apart, and F_t acts on the mechanism along positive slip velocity v_t.
    Sliding with v_t < 0 therefore means F_t = +μ F_n.

    Parameters
    ----------
    name : str
    system : LagrangianSystem
    gap : sympy.Expr
        g_N(q); m.
    slip_velocity : sympy.Expr
        v_t(q, q̇), affine in q̇ (a moving surface gives the constant part); m/s.
    friction : sympy.Symbol
        μ, one of the system's parameters.

    Raises
    ------
    ModelError
        Undeclared symbols, a gap that depends on velocities or on no coordinate, a slip
        velocity that is not affine in the velocities.
    """

    name: str
    system: LagrangianSystem
    gap: sp.Expr
    slip_velocity: sp.Expr
    friction: sp.Symbol

    def __post_init__(self) -> None:
        system, faults = self.system, []
        known = set(system.q) | set(system.q_dot) | {p.symbol for p in system.parameters}
        parts = {"gap": self.gap, "slip velocity": self.slip_velocity, "friction": self.friction}
        for what, expr in parts.items():
            for symbol in sorted(sp.sympify(expr).free_symbols - known, key=str):
                faults.append(f"{what}: " + unknown_name("symbol", str(symbol), map(str, known)))
        if self.gap.free_symbols & set(system.q_dot):
            faults.append("gap depends on a velocity; need a function of the coordinates alone.")
        if not self.gap.free_symbols & set(system.q):
            faults.append("gap depends on no coordinate: this contact has no normal motion.")
        if self.J_T.free_symbols & set(system.q_dot):
            faults.append("slip velocity is not affine in the velocities.")
        if faults:
            raise ModelError(f"contact {self.name!r} of mechanism {system.name!r}", faults)

    @classmethod
    def of_point(
        cls,
        name: str,
        system: LagrangianSystem,
        point: tuple[sp.Expr, sp.Expr],
        friction: sp.Symbol,
        *,
        slope: sp.Expr | float = 0,
        surface_speed: sp.Expr | float = 0,
    ) -> Contact:
        """Return the contact of a material point with a straight surface through the origin.

        Parameters
        ----------
        name, system, friction
            As for `Contact`.
        point : pair of sympy.Expr
            Cartesian (x, y) of the point as functions of q; m.
        slope : sympy.Expr
            Angle of the surface to the x axis, counter-clockwise; rad. The free side is above.
        surface_speed : sympy.Expr
            Speed of the surface along its own direction (a belt); m/s.
        """
        c, s = sp.cos(slope), sp.sin(slope)
        x, y = (sp.sympify(p) for p in point)
        along, gap = c * x + s * y, -s * x + c * y
        rates = zip(system.q, system.q_dot, strict=True)
        slip = sum((sp.diff(along, q) * v for q, v in rates), sp.Integer(0)) - surface_speed
        return cls(name, system, readable(gap), readable(slip), friction)

    @cached_property
    def J_N(self) -> sp.Matrix:
        """∂g_N/∂q, shape (1, n)."""
        return sp.Matrix([[readable(sp.diff(self.gap, q)) for q in self.system.q]])

    @cached_property
    def J_T(self) -> sp.Matrix:
        """∂v_t/∂q̇, shape (1, n)."""
        return sp.Matrix([[readable(sp.diff(self.slip_velocity, v)) for v in self.system.q_dot]])

    @cached_property
    def gap_rate(self) -> sp.Expr:
        """ġ_N = J_N q̇; m/s."""
        return readable((self.J_N * sp.Matrix(self.system.q_dot))[0])

    @cached_property
    def normal_bias(self) -> sp.Expr:
        """J̇_N q̇: the part of g̈_N that is not J_N q̈; m/s²."""
        return readable(self._transport(self.gap_rate))

    @cached_property
    def tangential_bias(self) -> sp.Expr:
        """The part of v̇_t that is not J_T q̈; m/s²."""
        return readable(self._transport(self.slip_velocity))

    def _transport(self, rate: sp.Expr) -> sp.Expr:
        pairs = zip(self.system.q, self.system.q_dot, strict=True)
        return sum((sp.diff(rate, q) * v for q, v in pairs), sp.Integer(0))
