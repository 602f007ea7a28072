"""A frictional contact of a mechanism: gap, slip velocity, their Jacobians and rates."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import sympy as sp

from painleve_sym.errors import ModelError, refuse_faulty, unknown_name
from painleve_sym.mechanics.bodies import Scalar, expr, rate
from painleve_sym.mechanics.declarations import NOT_DERIVED_FROM, DomainBound
from painleve_sym.mechanics.friction import FrictionCurve
from painleve_sym.mechanics.shapes import PLACE, ContactGeometry, Shape
from painleve_sym.mechanics.simplify import readable
from painleve_sym.mechanics.system import LagrangianSystem, vanish_everywhere

Vector3 = tuple[Scalar, Scalar, Scalar]
Surface = Callable[[sp.Symbol, sp.Symbol, sp.Symbol], sp.Expr]
"""g(x, y, z) of a smooth surface: zero on it, positive on its free side, any unit."""
Curve = Callable[[sp.Symbol, sp.Symbol], sp.Expr]
"""g(x, y) of a curved surface: zero on it, positive on its free side, any unit."""


@dataclass(frozen=True)
class Contact:
    """A point of a mechanism against a surface, with Coulomb friction.

    Sign convention: the gap g_N is positive when the bodies are apart, the normal force
    F_n ≥ 0 pushes them apart, and F_t acts on the mechanism along positive slip velocity v_t.
    Sliding with v_t < 0 therefore means F_t = +μ F_n.

    Parameters
    ----------
    name : str
        Letters, digits and underscores.
    system : LagrangianSystem
    gap : sympy.Expr
        g_N(q, t); m. A surface that moves as prescribed makes it depend on the time.
    slip_velocity : sympy.Expr
        v_t(q, q̇, t), affine in q̇ (a moving surface gives the part free of q̇); m/s.
    friction : sympy.Expr
        μ, one of the system's parameters; or the coefficient of slip as a formula of parameters and
        of ``v_t``, `friction.SLIP_VELOCITY`, which is the same for ±v_t.
    bilateral : bool
        A guide that holds the point from both sides: the gap stays 0, F_n has either sign, and
        friction is μ |F_n|. Its contact problem has 0, 1 or 2 solutions.
    geometry : ContactGeometry or None
        Where the contact is, for drawings; nothing is derived from it.
    slip_across : sympy.Expr or None
        Of a contact in space the second slip velocity, v_t2, `slip_velocity` being v_t1; m/s. The
        tangents t1, t2 and the normal are a right-handed triad.
    static_friction : sympy.Expr or None
        μ_s up to which the contact sticks, a formula of parameters; that of slip at v_t = 0 where
        it is None.

    Raises
    ------
    ModelError
        A name with other signs, undeclared symbols, a friction that is not a formula of parameters
        and v_t or that differs between v_t and −v_t, a static friction below it, a gap that
        depends on velocities or does not change with any coordinate, a slip velocity that is not
        affine in the velocities.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> contact = ps.models.rod().contacts[0]
    >>> contact.name, contact.gap, contact.slip_velocity, contact.friction
    ('A', y_A, x_A_dot, mu)
    """

    name: str
    system: LagrangianSystem
    gap: sp.Expr
    slip_velocity: sp.Expr
    friction: sp.Expr
    bilateral: bool = False
    geometry: ContactGeometry | None = field(default=None, compare=False, metadata=NOT_DERIVED_FROM)
    slip_across: sp.Expr | None = None
    static_friction: sp.Expr | None = None

    def __post_init__(self) -> None:
        refuse_faulty(f"contact {self.name!r} of mechanism {self.system.name!r}", self._faults())

    def __repr__(self) -> str:
        """Return name, kind and mechanism in one line."""
        kind = "bilateral" if self.bilateral else "unilateral"
        return f"Contact {self.name!r} of {self.system.name!r}: {kind}, friction {self.friction}"

    def _faults(self) -> Iterator[str]:
        system = self.system
        # It becomes part of the names of states, outputs and functions.
        if not self.name or not f"_{self.name}".isidentifier():
            yield f"name {self.name!r} is not usable. Fix: use letters, digits and underscores."
        parameters = {p.symbol for p in system.parameters}
        parts = {"gap": self.gap}
        parts |= {f"slip velocity{' 2' * k}": v for k, v in enumerate(self.slip_velocities)}
        if self.bilateral and self.n_tangents == 2:
            yield "bilateral is not offered in space; need a contact that can open."
        for name, part in parts.items():
            yield from system.formula_faults(name, part)
        if getattr(self.friction, "is_Symbol", False) and self.friction not in parameters:
            yield "friction: " + unknown_name("parameter", str(self.friction), map(str, parameters))
        else:
            yield from self.friction_curve.faults(system.parameters)
        if self.mu not in parameters and str(self.mu) in map(str, system.symbols):
            yield f"name {str(self.mu)!r} is that of its coefficient of friction. Fix: rename it."
        gap = sp.sympify(self.gap)
        if gap.free_symbols & set(system.q_dot):
            yield "gap depends on a velocity; need a function of the coordinates alone."
        if not gap.free_symbols & set(system.q):
            yield "gap depends on no coordinate: this contact has no normal motion."
        elif self._is_still():
            yield "gap changes with no coordinate: this contact has no normal motion."
        # As it comes, unless a velocity is left that may yet cancel: no search for short forms.
        velocities = set(system.q_dot)
        if self._raw_J_T.free_symbols & velocities and self.J_T.free_symbols & velocities:
            yield "slip velocity is not affine in the velocities."

    @cached_property
    def friction_curve(self) -> FrictionCurve:
        """Its coefficients of friction, at rest and in slip."""
        return FrictionCurve(self.friction, self.static_friction)

    @cached_property
    def mu(self) -> sp.Symbol:
        """μ in closed forms: the parameter, or a symbol for the coefficient at the slip velocity.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> ps.models.rod().contact.mu
        mu
        """
        if isinstance(self.friction, sp.Symbol):
            return self.friction
        return sp.Symbol(f"friction_{self.name}", nonnegative=True)

    @property
    def slip_speed(self) -> sp.Expr:
        """|v_t| as a function of the state; m/s."""
        if self.slip_across is None:
            return sp.Abs(self.slip_velocity)
        return sp.sqrt(self.slip_velocity**2 + self.slip_across**2)

    @cached_property
    def friction_bounds(self) -> tuple[DomainBound, ...]:
        """Conditions on its coefficients of friction that do not hold everywhere."""
        return self.friction_curve.bounds(self.name, self.slip_speed)

    def _is_still(self) -> bool:
        """Return whether no coordinate changes the gap."""
        row = self._raw_J_N
        return not any(entry.is_Number and entry != 0 for entry in row) and vanish_everywhere(row)

    @classmethod
    def of_point(
        cls,
        name: str,
        system: LagrangianSystem,
        point: tuple[Scalar, Scalar],
        friction: sp.Expr,
        *,
        static_friction: sp.Expr | None = None,
        slope: Scalar = 0,
        surface_speed: Scalar = 0,
        through: tuple[Scalar, Scalar] = (0, 0),
        curve: Curve | None = None,
        bilateral: bool = False,
    ) -> Contact:
        """Return the contact of a material point with a straight or curved surface.

        On a curve the gap is g/|∇g|, the distance to first order (exact where it is 0), and the
        tangent is ∇g turned clockwise by a right angle.

        Parameters
        ----------
        name, system, friction, static_friction, bilateral
            As for `Contact`.
        point : pair of sympy.Expr
            Cartesian (x, y) of the point as functions of q and t; m.
        slope : sympy.Expr
            Angle of the surface to the x axis, counter-clockwise; rad. The free side is above.
            Where it depends on t the surface turns about the place `through`.
        surface_speed : sympy.Expr
            Speed of the surface along its own direction (a belt), as a function of q and t; m/s.
            It is in addition to the motion that `through` and `slope` prescribe.
        through : pair of sympy.Expr
            A place on the straight surface, or the origin of the curve; m. Where it depends on t
            the surface moves with it, along its normal and along its tangent.
        curve : callable
            g(x, y) of a curved surface, in place of `slope`. Where g itself depends on t, the
            surface moves along its normal alone.
        """
        x, y = (expr(p) - expr(o) for p, o in zip(point, through, strict=True))
        if curve is None:
            c, s = sp.cos(slope), sp.sin(slope)
            gap, along = -s * x + c * y, c * x + s * y
            slip = rate(along, system.rates)
            geometry = ContactGeometry.straight(point, slope, gap)
        else:
            gap, (t_x, t_y) = _to_curve(curve, (x, y))
            place = [p - expr(o) for p, o in zip(PLACE, through, strict=True)]
            geometry = ContactGeometry(point, (-t_y, t_x), expr(curve(*place)))
            x_dot, y_dot = (rate(p, system.rates) for p in (x, y))
            slip = t_x * x_dot + t_y * y_dot
        slip -= expr(surface_speed)
        row = readable(gap), readable(slip), friction, bilateral, geometry
        return cls(name, system, *row, static_friction=static_friction)

    @classmethod
    def of_disc(
        cls,
        name: str,
        system: LagrangianSystem,
        centre: tuple[Scalar, Scalar],
        radius: Scalar,
        angle: Scalar,
        friction: sp.Expr,
        *,
        static_friction: sp.Expr | None = None,
        slope: Scalar = 0,
        surface_speed: Scalar = 0,
        through: tuple[Scalar, Scalar] = (0, 0),
        bilateral: bool = False,
    ) -> Contact:
        """Return the contact of a disc's rim with a straight surface.

        Parameters
        ----------
        name, system, friction, static_friction, slope, surface_speed, through, bilateral
            As for `of_point`.
        centre : pair of sympy.Expr
            Cartesian (x, y) of the disc's centre as functions of q and t; m.
        radius : sympy.Expr
            m.
        angle : sympy.Expr
            Angle of the disc as a function of q and t, counter-clockwise; rad. Rolling has
            centre speed = −radius · angular velocity.
        """
        x, y = expr(centre[0]) - expr(through[0]), expr(centre[1]) - expr(through[1])
        c, s = sp.cos(slope), sp.sin(slope)
        gap = -s * x + c * y - expr(radius)
        # The point of the rim that touches has the centre's velocity plus that of the turn.
        # The turn counts from the surface, which may turn itself.
        turned = c * x + s * y + expr(radius) * (expr(angle) - expr(slope))
        slip = rate(turned, system.rates) - expr(surface_speed)
        touching = (expr(centre[0]) + expr(radius) * s, expr(centre[1]) - expr(radius) * c)
        rim = Shape.disc(centre, radius, angle)
        geometry = ContactGeometry.straight(touching, slope, gap, rim)
        row = readable(gap), readable(slip), friction, bilateral, geometry
        return cls(name, system, *row, static_friction=static_friction)

    @classmethod
    def in_space(
        cls,
        name: str,
        system: LagrangianSystem,
        point: Vector3,
        friction: sp.Expr,
        *,
        static_friction: sp.Expr | None = None,
        normal: Vector3 = (0, 0, 1),
        through: Vector3 = (0, 0, 0),
        surface: Surface | None = None,
        along: Vector3 = (1, 0, 0),
    ) -> Contact:
        """Return the contact of a material point with a plane or a smooth surface in space.

        Parameters
        ----------
        name, system, friction, static_friction
            As for `Contact`.
        point : tuple of three sympy.Expr
            Cartesian (x, y, z) of the point as functions of q and t; m.
        normal : tuple of three sympy.Expr
            Of the plane, towards its free side, of any length; constant.
        through : tuple of three sympy.Expr
            A place on the plane, or the origin of the surface; m. Where it depends on t the surface
            moves with it.
        surface : callable
            g(x, y, z) of a smooth surface, in place of `normal`. The gap is g/|∇g|, the distance to
            first order (exact where it is 0).
        along : tuple of three sympy.Expr
            A direction whose part in the surface is the tangent t1; t2 = n × t1.

        Raises
        ------
        ModelError
            Where the normal vanishes, or `along` is normal to the plane, and for the faults of
            `Contact`.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> rod = ps.model("rod-3d")
        >>> rod.contact.gap, rod.contact.slip_velocities
        (z_A, (x_A_dot, y_A_dot))
        """
        place = [expr(p) - expr(o) for p, o in zip(point, through, strict=True)]
        given = f"contact {name!r} of mechanism {system.name!r}"
        if surface is None:
            n = sp.Matrix([expr(v) for v in normal])
            size = sp.sqrt((n.T * n)[0])
            gap = (n.T * sp.Matrix(place))[0]
        else:
            axes = sp.symbols("x y z", cls=sp.Dummy, real=True)
            g = expr(surface(*axes))
            at = dict(zip(axes, place, strict=True))
            n = sp.Matrix([sp.diff(g, axis) for axis in axes]).subs(at, simultaneous=True)
            size, gap = sp.sqrt((n.T * n)[0]), g.subs(at, simultaneous=True)
        if readable(size) == 0:
            raise ModelError(given, ["the normal of the surface vanishes; need a direction."])
        n = n.applyfunc(lambda part: readable(part / size))
        first = sp.Matrix([expr(v) for v in along])
        first -= n * (n.T * first)[0]
        width = sp.sqrt(readable((first.T * first)[0]))
        if width == 0:
            text = f"along is {along}, which is normal to the surface, need a direction across it."
            raise ModelError(given, [text])
        first = first.applyfunc(lambda part: readable(part / width))
        velocity = sp.Matrix([rate(p, system.rates) for p in place])
        slip, across = (system.readable((t.T * velocity)[0]) for t in (first, n.cross(first)))
        parts = (name, system, system.readable(gap / size), slip, friction)
        return cls(*parts, slip_across=across, static_friction=static_friction)

    @property
    def slip_velocities(self) -> tuple[sp.Expr, ...]:
        """v_t in the plane, v_t1 and v_t2 in space; m/s."""
        return (self.slip_velocity, *([] if self.slip_across is None else [self.slip_across]))

    @property
    def n_tangents(self) -> int:
        """Number of its tangents: 1 in the plane, 2 in space."""
        return len(self.slip_velocities)

    @cached_property
    def J_N(self) -> sp.Matrix:
        """∂ġ_N/∂u = ∂g_N/∂q N, shape (1, n)."""
        return self._raw_J_N.applyfunc(self.system.readable)

    @property
    def _raw_J_N(self) -> sp.Matrix:
        return sp.Matrix([self.system.slopes(self.gap)])

    @cached_property
    def J_T(self) -> sp.Matrix:
        """∂v_t/∂u, shape (1, n); (2, n) in space."""
        return self._raw_J_T.applyfunc(self.system.readable)

    @property
    def J(self) -> sp.Matrix:
        """J_N above J_T, shape (2, n); (3, n) in space."""
        return sp.Matrix.vstack(self.J_N, self.J_T)

    @property
    def _raw_J_T(self) -> sp.Matrix:
        velocities = self.system.q_dot
        return sp.Matrix([[sp.diff(slip, v) for v in velocities] for slip in self.slip_velocities])

    @cached_property
    def gap_rate(self) -> sp.Expr:
        """ġ_N = J_N u + ∂g_N/∂t, against the surface as it moves; m/s."""
        return self.system.readable((self.J_N * sp.Matrix(self.system.q_dot))[0] + self.gap_drift)

    @cached_property
    def gap_drift(self) -> sp.Expr:
        """∂g_N/∂t: how fast the surface moves away by itself along the normal; m/s."""
        drift = sum((sp.diff(self.gap, t) for t in self.system.clock), sp.Integer(0))
        return drift if drift == 0 else readable(drift)

    @cached_property
    def surface_speed(self) -> sp.Expr:
        """J_T q̇ − v_t: speed of the surface along positive slip; m/s. Its drive does work."""
        still = dict.fromkeys(self.system.q_dot, sp.Integer(0))
        return readable(-sp.sympify(self.slip_velocity).subs(still))

    @property
    def normal_bias(self) -> sp.Expr:
        """The part of g̈_N that is not J_N u̇; m/s²."""
        return self.biases[0]

    @cached_property
    def biases(self) -> sp.Matrix:
        """The parts of g̈_N and of each slip acceleration that are not J u̇, as a column; m/s²."""
        speeds = (self.gap_rate, *self.slip_velocities)
        return sp.Matrix([self.system.readable(rate(v, self.system.rates)) for v in speeds])

    @property
    def tangential_bias(self) -> sp.Expr:
        """The part of v̇_t that is not J_T u̇; m/s²."""
        return self.biases[1]


def _to_curve(
    curve: Curve, point: tuple[sp.Expr, sp.Expr]
) -> tuple[sp.Expr, tuple[sp.Expr, sp.Expr]]:
    """Return the gap g/|∇g| at a point and the unit tangent (∂g/∂y, −∂g/∂x)/|∇g|."""
    x, y = sp.Dummy("x", real=True), sp.Dummy("y", real=True)
    g = expr(curve(x, y))
    g_x, g_y = sp.diff(g, x), sp.diff(g, y)
    if g_x == 0 and g_y == 0:
        # No surface: let the contact report that nothing moves along its normal.
        return sp.Integer(0), (sp.Integer(0), sp.Integer(0))
    steepness = sp.sqrt(g_x**2 + g_y**2)
    place = dict(zip((x, y), point, strict=True))
    forms = (g / steepness, g_y / steepness, -g_x / steepness)
    gap, t_x, t_y = (form.subs(place, simultaneous=True) for form in forms)
    return gap, (t_x, t_y)
