"""Parts of a planar mechanism: bodies, springs with dampers, and applied forces or torques."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import sympy as sp

Scalar: TypeAlias = sp.Expr | float
"""What a formula may be given as: an expression or a number, never text."""

Rates: TypeAlias = Mapping[sp.Symbol, sp.Expr]
"""Coordinates to their velocities, and the time to 1 (`LagrangianSystem.rates`)."""


def expr(value: Scalar) -> sp.Expr:
    """Return the value as an expression; text is rejected, since SymPy would execute it."""
    return sp.sympify(value, strict=True)


def rate(value: Scalar, rates: Rates) -> sp.Expr:
    """Return d/dt of a function of coordinates and time: Σ ∂/∂q_i q̇_i + ∂/∂t."""
    value = expr(value)
    pairs = [(s, v) for s, v in rates.items() if s in value.free_symbols]
    return sum((sp.diff(value, s) * v for s, v in pairs), sp.Integer(0))


@dataclass(frozen=True)
class Body:
    """A rigid body: T = m (ẋ² + ẏ²)/2 + J φ̇²/2 with x, y of its mass centre and its angle φ.

    Attributes
    ----------
    mass : sympy.Expr
        kg.
    centre : pair of sympy.Expr
        Cartesian (x, y) of the mass centre as functions of q and t; m.
    inertia : sympy.Expr
        J about the mass centre; kg m². 0 for a point mass.
    angle : sympy.Expr
        φ(q, t), counter-clockwise; rad. Only its rate matters.
    """

    mass: Scalar
    centre: tuple[Scalar, Scalar]
    inertia: Scalar = 0
    angle: Scalar = 0

    def kinetic_energy(self, rates: Rates) -> sp.Expr:
        """Return T; J."""
        speeds = [rate(c, rates) for c in self.centre]
        turn = rate(self.angle, rates)
        return expr(self.mass) * sum(v**2 for v in speeds) / 2 + expr(self.inertia) * turn**2 / 2


@dataclass(frozen=True)
class Spring:
    """A linear spring with a damper, along any extension e(q, t): F = −k e − c ė.

    Attributes
    ----------
    extension : sympy.Expr
        e(q, t), zero where the spring is relaxed; m, or rad for a torsion spring.
    stiffness, damping : sympy.Expr
        k and c; N/m and N s/m, or N m/rad and N m s/rad.
    """

    extension: Scalar
    stiffness: Scalar = 0
    damping: Scalar = 0

    @property
    def potential_energy(self) -> sp.Expr:
        """V = k e²/2; J."""
        return expr(self.stiffness) * expr(self.extension) ** 2 / 2

    def forces(self, q: Sequence[sp.Symbol], rates: Rates) -> list[sp.Expr]:
        """Return the damper's generalized forces −c ė ∂e/∂q_i."""
        pull = -expr(self.damping) * rate(self.extension, rates)
        return [pull * sp.diff(expr(self.extension), s) for s in q]


@dataclass(frozen=True)
class Load:
    """An applied force or torque: Q_i = Σ value_k ∂along_k/∂q_i.

    Attributes
    ----------
    along : tuple of sympy.Expr
        Places or angles the load does work along, as functions of q and t; m or rad.
    values : tuple of sympy.Expr
        Components of the load, in q, q̇, t and parameters; N or N m.
    """

    along: tuple[Scalar, ...]
    values: tuple[Scalar, ...]

    @classmethod
    def force(cls, point: tuple[Scalar, Scalar], components: tuple[Scalar, Scalar]) -> Load:
        """Return the force (F_x, F_y) on the point (x, y) of a body."""
        return cls(point, components)

    @classmethod
    def torque(cls, angle: Scalar, value: Scalar) -> Load:
        """Return the torque on the body, or between the bodies, whose angle is given."""
        return cls((angle,), (value,))

    def forces(self, q: Sequence[sp.Symbol]) -> list[sp.Expr]:
        """Return the generalized forces."""
        pairs = list(zip(self.along, self.values, strict=True))
        return [sum((expr(f) * sp.diff(expr(a), s) for a, f in pairs), sp.Integer(0)) for s in q]


def weight(bodies: Iterable[Body], gravity: Scalar | tuple[Scalar, Scalar]) -> sp.Expr:
    """Return the potential energy of the bodies' weight; J.

    Parameters
    ----------
    bodies : iterable of Body
    gravity : sympy.Expr or pair
        g, acting along −y, or the acceleration vector (g_x, g_y); m/s².
    """
    pull = gravity if isinstance(gravity, tuple) else (0, -expr(gravity))
    return sum(
        (
            -expr(b.mass) * expr(g) * expr(c)
            for b in bodies
            for g, c in zip(pull, b.centre, strict=True)
        ),
        sp.Integer(0),
    )
