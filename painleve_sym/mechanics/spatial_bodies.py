"""Bodies in space: orientation by successive angles, tensor of inertia, points.

Axes of space are x, y, z, with z upwards where gravity is one number. An orientation turns the axes
of a body out of those of space by rotations one after the other, each about an axis of the body as
it is then: Euler's angles in any order.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

import mpmath
import sympy as sp

from painleve_sym.errors import ModelError, refuse_faulty
from painleve_sym.mechanics.bodies import Rates, Scalar, Spring, expr, rate
from painleve_sym.mechanics.declarations import Parameter
from painleve_sym.mechanics.quaternions import Quaternion

Vector3: TypeAlias = tuple[Scalar, Scalar, Scalar]
"""Three components along x, y, z, or along the axes of a body."""

NEAR_LOCK = sp.Rational(1, 10**12)
"""Square of the sine (or cosine) of an angle below which the other two are one turn."""
LOSES_DIGITS = 1e-6
"""Such a square below which W and b lose digits, about 1e-16 over it: 1e-3 rad from the lock."""
FLAT = 1e-12
"""Of the trace of a tensor: how far twice the second moments of a flat body may be below 0."""


def _turn(axis: str, angle: Scalar) -> sp.Matrix:
    c, s = sp.cos(expr(angle)), sp.sin(expr(angle))
    k = "xyz".index(axis)
    matrix = sp.eye(3)
    i, j = (k + 1) % 3, (k + 2) % 3
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


@dataclass(frozen=True)
class Orientation:
    """Rotations about axes of the body, one after the other.

    Attributes
    ----------
    turns : tuple of (str, sympy.Expr)
        Axis ``"x"``, ``"y"`` or ``"z"`` and angle of each, as functions of q and t; rad.

    Raises
    ------
    ModelError
        For another axis, or successive turns about one axis.

    Examples
    --------
    >>> import sympy as sp
    >>> from painleve_sym.mechanics import Orientation
    >>> psi, theta = sp.symbols("psi theta")
    >>> Orientation((("z", psi), ("y", -theta))).matrix[:, 0].T
    Matrix([[cos(psi)*cos(theta), sin(psi)*cos(theta), sin(theta)]])
    """

    turns: tuple[tuple[str, Scalar], ...] = ()

    def __post_init__(self) -> None:
        faults = [
            f"axis of a turn: got {axis!r}, need 'x', 'y' or 'z'."
            for axis, _ in self.turns
            if axis not in ("x", "y", "z")
        ]
        axes = [axis for axis, _ in self.turns]
        faults += [
            f"two turns about {one} follow each other. Fix: make them one turn."
            for one, next_ in itertools.pairwise(axes)
            if one == next_
        ]
        refuse_faulty("orientation", faults)

    @cached_property
    def matrix(self) -> sp.Matrix:
        """R: components along x, y, z of a vector that is given along the axes of the body."""
        whole = sp.eye(3)
        for axis, angle in self.turns:
            whole = whole * _turn(axis, angle)
        return whole

    def turning(self, rates: Rates) -> sp.Matrix:
        """Return the angular velocity along the axes of the body, shape (3, 1); rad/s."""
        total, after = sp.zeros(3, 1), sp.eye(3)
        for axis, angle in reversed(self.turns):
            total += after.T[:, "xyz".index(axis)] * rate(angle, rates)
            after = _turn(axis, angle) * after
        return total

    @property
    def lock(self) -> tuple[sp.Expr, str] | None:
        """A margin that is 0 where three turns are two, and what is so there; None for fewer turns.

        The first and the last axis are then one line: the gimbal lock of these angles.
        """
        if len(self.turns) != 3:
            return None
        (first, one), (_, middle), (last, three) = self.turns
        angle = expr(middle)
        size = sp.sin(angle) ** 2 if first == last else sp.cos(angle) ** 2
        order = ", ".join(axis for axis, _ in self.turns)
        other = "z, x, z" if first != last else "z, y, x"
        return size - NEAR_LOCK, (
            f"gimbal lock: the turns {order} by {one}, {middle}, {three} have their first and last "
            f"axis on one line. Fix: turn about other axes, such as {other}, or orient the body "
            "by a quaternion"
        )


@dataclass(frozen=True)
class SpatialBody:
    """A rigid body in space: T = m v²/2 + ωᵀ J ω/2 with ω along its axes.

    Attributes
    ----------
    mass : sympy.Expr
        kg.
    centre : tuple of three sympy.Expr
        Cartesian (x, y, z) of the mass centre as functions of q and t; m.
    inertia : sequence
        About the mass centre, along the axes of the body: three principal moments, or three rows
        of a symmetric tensor; kg m². All 0 for a point mass.
    orientation : Orientation or Quaternion
        Of the axes of the body, by angles or by a unit quaternion.
    name : str
        For messages.

    Examples
    --------
    >>> import sympy as sp
    >>> import painleve_sym as ps
    >>> from painleve_sym.mechanics import Orientation
    >>> m, J, l, x, psi = sp.symbols("m J l x psi")
    >>> turned = Orientation((("z", psi),))
    >>> rod = ps.SpatialBody(m, (x, 0, 0), (0, J, J), turned)
    >>> rod.point((l, 0, 0))
    (l*cos(psi) + x, l*sin(psi), 0)
    """

    mass: Scalar
    centre: Vector3
    inertia: Sequence[Scalar] | Sequence[Sequence[Scalar]] = (0, 0, 0)
    orientation: Orientation | Quaternion = field(default_factory=Orientation)
    name: str = "body"

    @cached_property
    def tensor(self) -> sp.Matrix:
        """J about the mass centre, shape (3, 3); kg m²."""
        rows: list[Any] = list(self.inertia)
        if len(rows) == 3 and all(isinstance(row, Sequence) and len(row) == 3 for row in rows):
            return sp.Matrix([[expr(v) for v in row] for row in rows])
        if len(rows) == 3 and not any(isinstance(row, Sequence) for row in rows):
            return sp.diag(*(expr(v) for v in rows))
        raise ModelError(
            self.name,
            ["inertia: need three principal moments, or three rows of a symmetric tensor."],
        )

    def faults(
        self, _coordinates: Sequence[sp.Symbol], parameters: Sequence[Parameter]
    ) -> Iterator[str]:
        """Yield a sentence for each way in which mass and tensor are none of a body.

        Principal moments are not negative, and none is larger than the other two together, which a
        flat body reaches. Entries are judged at the defaults of the parameters where these decide.
        """
        defaults = {p.symbol: sp.Float(p.default) for p in parameters}
        mass = expr(self.mass).xreplace(defaults)
        if mass.is_number and not mass.is_positive:
            yield f"{self.name}: mass is {self.mass}, need > 0."
        tensor = self.tensor
        if sp.simplify(tensor - tensor.T) != sp.zeros(3, 3):
            yield f"{self.name}: inertia is not a symmetric tensor. Fix: give J_xy = J_yx."
            return
        numbers = tensor.xreplace(defaults)
        if numbers.free_symbols:
            return
        principal = mpmath.eigsy(mpmath.matrix(numbers.evalf(30).tolist()), eigvals_only=True)
        moments = sorted(map(float, principal))
        small = 1e-12 * max(abs(moments[0]), abs(moments[2]))
        shown = ", ".join(f"{v:.6g}" for v in moments)
        if moments[0] < -small:
            yield f"{self.name}: inertia has principal moments {shown}, need none below 0."
        elif moments[2] > moments[0] + moments[1] + small:
            yield (
                f"{self.name}: inertia has principal moments {shown}, of which the largest is more "
                "than the other two together: no body has that. Fix: check the tensor, and that "
                "it is about the mass centre."
            )

    @property
    def bounds(self) -> Iterator[tuple[sp.Expr, str, float]]:
        """Margins that are positive where angles do not lock and the tensor is that of a body.

        Each with what is so there, and `DomainBound.near`. A tensor J is that of a body where
        tr(J) − 2 J, twice the second moments of its mass, is positive semidefinite; a tensor of
        numbers is judged by `faults`, and what the signs of parameters decide is left out.
        """
        lock = self.orientation.lock
        if lock is not None and lock[0].free_symbols:
            yield lock[0], f"{self.name}: {lock[1]}", LOSES_DIGITS
        tensor = self.tensor
        if not tensor.free_symbols:
            return
        trace = tensor.trace()
        moments = sp.eye(3) * trace - 2 * tensor
        sizes = (1, 1, 1) if tensor.is_diagonal() else (1, 2, 3)
        for k, size in enumerate(sizes):
            part = moments[k, k] if tensor.is_diagonal() else moments[:size, :size].det()
            margin = sp.simplify(part)
            if margin.free_symbols and not margin.is_nonnegative:
                slack = sp.Mul(sp.Float(FLAT), trace**size, evaluate=False)
                yield (
                    sp.Add(margin, slack, evaluate=False),
                    f"{self.name}: no principal moment of inertia is negative, or more than the "
                    "other two together",
                    0.0,
                )

    @property
    def springs(self) -> tuple[Spring, ...]:
        """None: it is rigid."""
        return ()

    def kinetic_energy(self, rates: Rates) -> sp.Expr:
        """Return T; J."""
        speeds = [rate(c, rates) for c in self.centre]
        kinetic = expr(self.mass) * sum(v**2 for v in speeds) / 2
        if self.tensor.is_zero_matrix:
            return kinetic
        turning = self.orientation.turning(rates)
        return kinetic + (turning.T * self.tensor * turning)[0] / 2

    def point(self, at: Vector3) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """Return the place (x, y, z) of a material point as a function of q and t.

        Parameters
        ----------
        at : tuple of three sympy.Expr
            From the mass centre, along the axes of the body; m.
        """
        arm = self.orientation.matrix * sp.Matrix([expr(v) for v in at])
        x, y, z = (expr(c) + a for c, a in zip(self.centre, arm, strict=True))
        return x, y, z

    @property
    def mass_moment(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """m (x, y, z) of the mass centre; kg m."""
        x, y, z = (expr(self.mass) * expr(c) for c in self.centre)
        return x, y, z
