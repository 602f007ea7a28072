"""Orientation of a body by a unit quaternion, with its angular velocity as velocities.

Its four coordinates have three velocities ω, the angular velocity along the axes of the body, and
q̇ = N(q) ω: two times q̇ is the product of q with (0, ω). It has no singular orientation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from painleve_sym.mechanics.declarations import Coordinate, Velocity

if TYPE_CHECKING:
    from sympy import Expr, Matrix, Symbol

UNIT_WITHIN = 1e-6
"""A quaternion whose norm differs from 1 by less is scaled to 1; another is rejected."""


@dataclass(frozen=True)
class Quaternion:
    """The orientation of a body by a unit quaternion q = (w, x, y, z), w its scalar part.

    q and −q are the same orientation. The body is turned by the angle 2 acos(w) about (x, y, z).

    Attributes
    ----------
    name : str
        Its coordinates are ``name + "_w"``, ``"_x"``, ``"_y"``, ``"_z"``; without unit.
    meaning : str
        One sentence.
    velocity : str
        Its velocities are ``velocity + "_1"``, ``"_2"``, ``"_3"``: the angular velocity along the
        first, second and third axis of the body; rad/s.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> q = ps.Quaternion("q", "orientation of the brick")
    >>> [c.name for c in q.coordinates], [v.name for v in q.velocities]
    (['q_w', 'q_x', 'q_y', 'q_z'], ['omega_1', 'omega_2', 'omega_3'])
    >>> q.coordinates[0].rate
    -omega_1*q_x/2 - omega_2*q_y/2 - omega_3*q_z/2
    """

    name: str
    meaning: str
    velocity: str = "omega"

    @cached_property
    def coordinates(self) -> tuple[QuaternionPart, ...]:
        """Its four parts w, x, y, z."""
        return tuple(
            QuaternionPart(f"{self.name}_{axis}", f"{self.meaning}, part {axis}", "1", of=self)
            for axis in "wxyz"
        )

    @cached_property
    def velocities(self) -> tuple[Velocity, ...]:
        """The angular velocity along the axes of the body, three components; rad/s."""
        return tuple(
            Velocity(
                name := f"{self.velocity}_{k}",
                f"angular velocity along axis {k} of the body ({self.meaning})",
                "rad/s",
                name,
            )
            for k in (1, 2, 3)
        )

    @property
    def symbols(self) -> tuple[Symbol, ...]:
        """Symbols of w, x, y, z."""
        return tuple(c.symbol for c in self.coordinates)

    @cached_property
    def matrix(self) -> Matrix:
        """R: components along x, y, z of a vector that is given along the axes of the body.

        Homogeneous of degree 2, so that d/dt (R a) = R (ω × a) holds for every q.
        """
        from sympy import Matrix

        w, x, y, z = self.symbols
        return Matrix(
            [
                [w**2 + x**2 - y**2 - z**2, 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), w**2 - x**2 + y**2 - z**2, 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), w**2 - x**2 - y**2 + z**2],
            ]
        )

    def turning(self, _: Mapping[Symbol, Expr]) -> Matrix:
        """Return the angular velocity along the axes of the body, shape (3, 1); rad/s."""
        from sympy import Matrix

        return Matrix([v.symbol for v in self.velocities])

    @property
    def lock(self) -> None:
        """None: no orientation is singular."""

    def scaled(
        self, values: Mapping[str, float], given: Mapping[str, object]
    ) -> tuple[dict[str, float], str]:
        """Return its parts with unit norm, or a sentence where they are too far from that.

        Parameters
        ----------
        values : mapping of str to float
            At least its four parts.
        given : mapping of str to object
            State as it came: where no part is in it, the axes of the body are those of space.
        """
        names = [c.name for c in self.coordinates]
        if not any(name in given for name in names):
            return dict(zip(names, (1.0, 0.0, 0.0, 0.0), strict=True)), ""
        parts = [values[name] for name in names]
        norm = math.hypot(*parts)
        if abs(norm - 1) > UNIT_WITHIN:
            unit = [p / norm for p in parts] if norm else [1.0, 0.0, 0.0, 0.0]
            fix = ",".join(f"{name}={p:.15g}" for name, p in zip(names, unit, strict=True))
            shown = ", ".join(f"{p:.6g}" for p in parts)
            return {}, (
                f"the quaternion ({', '.join(names)}) = ({shown}) has the norm {norm:.9g}, need 1 "
                f"within {UNIT_WITHIN:g}. Fix: give {fix}."
            )
        return {name: p / norm for name, p in zip(names, parts, strict=True)}, ""


@dataclass(frozen=True)
class QuaternionPart(Coordinate):
    """One of the four coordinates of a `Quaternion`, which has no velocity of its own."""

    of: Quaternion = field(kw_only=True)

    @cached_property
    def rate(self) -> Expr:
        """Its rate by the angular velocity: a row of N(q) ω; 1/s."""
        w, x, y, z = self.of.symbols
        first, second, third = (v.symbol for v in self.of.velocities)
        rows = {
            w: -x * first - y * second - z * third,
            x: w * first + y * third - z * second,
            y: w * second + z * first - x * third,
            z: w * third + x * second - y * first,
        }
        return (rows[self.symbol] / 2).expand()


def quaternions_of(coordinates: Sequence[Coordinate]) -> tuple[Quaternion, ...]:
    """Return the quaternions of which these coordinates are parts, each once."""
    return tuple(dict.fromkeys(c.of for c in coordinates if isinstance(c, QuaternionPart)))


def velocities_of(coordinates: Sequence[Coordinate]) -> tuple[Velocity, ...]:
    """Return the velocities u with q̇ = N(q) u: rates of coordinates, ω for each quaternion."""
    velocities, seen = list[Velocity](), set[Quaternion]()
    for c in coordinates:
        if not isinstance(c, QuaternionPart):
            velocities.append(c.velocity)
        elif c.of not in seen:
            seen.add(c.of)
            velocities += c.of.velocities
    return tuple(velocities)
