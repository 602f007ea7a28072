"""Parts of a planar mechanism: bodies and their modes, springs with dampers, applied loads."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

import sympy as sp

from painleve_sym.errors import refuse_faulty, unknown_name
from painleve_sym.mechanics.bars import RoundBar, first_bending_wavenumber

if TYPE_CHECKING:
    from painleve_sym.mechanics.declarations import Parameter
    from painleve_sym.mechanics.spatial_bodies import SpatialBody

Scalar: TypeAlias = sp.Expr | float
"""What a formula may be given as: an expression or a number, never text."""

Point: TypeAlias = tuple[Scalar, Scalar]
"""Cartesian (x, y) as functions of q, t and parameters; m."""

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


def moved(origin: Point, by: Point, angle: Scalar) -> tuple[sp.Expr, sp.Expr]:
    """Return origin + R(angle) by."""
    c, s = sp.cos(angle), sp.sin(angle)
    x, y = (expr(part) for part in by)
    return expr(origin[0]) + c * x - s * y, expr(origin[1]) + s * x + c * y


@dataclass(frozen=True)
class Mode:
    """A natural mode of a body that deforms: the body's points move by φ(P) q in its frame.

    Deflections are small and the body turns slowly against the mode, so that terms of the order
    (φ̇/ω)² q are left out. A free mode moves neither the mass centre nor the mean angle: its
    `momentum` and `angular_momentum` are 0. A mode of a body that is clamped in its frame has them.

    Attributes
    ----------
    coordinate : sympy.Symbol
        q, one of the system's coordinates; m.
    mass : sympy.Expr
        Modal mass ∫φ² dm; kg.
    frequency : sympy.Expr
        Natural circular frequency ω; rad/s.
    damping : sympy.Expr
        Ratio ζ of the modal damping to the critical one; 1.
    momentum : pair of sympy.Expr
        ∫φ dm in the body's frame; kg.
    angular_momentum : sympy.Expr
        ∫(ξ φ_η − η φ_ξ) dm with (ξ, η) from the body's mass centre; kg m.
    stretch : sympy.Expr, optional
        ∫(ξ φ_ξ + η φ_η) dm; kg m. Where it is given the inertia grows by 2 `stretch` q + `mass` q²;
        it belongs to modes along a bar. Bending changes the inertia in second order alone.

    Examples
    --------
    >>> import sympy as sp
    >>> import painleve_sym as ps
    >>> from painleve_sym.mechanics import Mode
    >>> q, m, omega, phi, x, y = sp.symbols("q m omega phi x y")
    >>> bending = Mode(q, m, omega, damping=0.01)
    >>> bar = ps.Body(m, (x, y), m, phi, modes=(bending,))
    >>> bar.point((0, 0), {q: (0, 2)})
    (-2*q*sin(phi) + x, 2*q*cos(phi) + y)
    """

    coordinate: sp.Symbol
    mass: Scalar
    frequency: Scalar
    damping: Scalar = 0
    momentum: tuple[Scalar, Scalar] = (0, 0)
    angular_momentum: Scalar = 0
    stretch: Scalar | None = None

    @property
    def spring(self) -> Spring:
        """The mode's restoring and damping force: k = m ω², c = 2 ζ m ω."""
        stiffness = expr(self.mass) * expr(self.frequency) ** 2
        damping = 2 * expr(self.damping) * expr(self.mass) * expr(self.frequency)
        return Spring(self.coordinate, stiffness, damping)


DENSITY = sp.Symbol("density_of_material", positive=True)
MODULUS = sp.Symbol("modulus_of_material", positive=True)
"""Of a bar whose material is chosen with a run."""


@dataclass(frozen=True)
class NaturalPeriod:
    """A natural period of a body, s; where it is not `modelled` the body is rigid in the mechanism.

    It is written in parameters, and in `DENSITY` and `MODULUS` where the material is chosen with a
    run.
    """

    body: str
    mode: str
    period: sp.Expr
    modelled: bool = False


Shape: TypeAlias = Mapping[sp.Symbol, tuple[Scalar, Scalar]]
"""Values (φ_ξ, φ_η) of modes at one point of a body, by the mode's coordinate."""


@dataclass(frozen=True)
class Body:
    """A body: T = m (ẋ² + ẏ²)/2 + J φ̇²/2 with x, y of its mass centre and its angle φ.

    A body with modes deforms. `centre` and `angle` are then those of its frame, in which it is
    undeformed where every modal coordinate is 0.

    Attributes
    ----------
    mass : sympy.Expr
        kg.
    centre : pair of sympy.Expr
        Cartesian (x, y) of the mass centre as functions of q and t; m.
    inertia : sympy.Expr
        J about the mass centre; kg m². 0 for a point mass.
    angle : sympy.Expr
        φ(q, t), counter-clockwise; rad. Without modes only its rate matters.
    modes : tuple of Mode
        Orthogonal to each other with respect to the mass.
    name : str
        For messages.
    length : sympy.Expr, optional
        Of a uniform solid round bar without modes here; m. With it the first bending period is
        known for every material.
    lowest_period : sympy.Expr, optional
        Longest natural period of a body that is rigid here, where it is known; s.

    References
    ----------
    Modes in a floating frame: Shabana (1989).

    Examples
    --------
    >>> import sympy as sp
    >>> import painleve_sym as ps
    >>> m, l, x, y, phi = sp.symbols("m l x y phi")
    >>> centre = (x + l * sp.cos(phi), y + l * sp.sin(phi))
    >>> rod = ps.Body(m, centre, inertia=m * l**2 / 3, angle=phi)
    >>> rod.point((-l, 0))
    (x, y)
    """

    mass: Scalar
    centre: tuple[Scalar, Scalar]
    inertia: Scalar = 0
    angle: Scalar = 0
    modes: tuple[Mode, ...] = field(default_factory=tuple)
    name: str = "body"
    length: Scalar | None = None
    lowest_period: Scalar | None = None

    @property
    def successive_modes(self) -> Iterator[tuple[Mode, Mode]]:
        """Neighbouring modes of one kind, of bending or along a bar, in the order given."""
        for along in (False, True):
            yield from itertools.pairwise(
                mode for mode in self.modes if (mode.stretch is not None) == along
            )

    @property
    def natural_periods(self) -> tuple[NaturalPeriod, ...]:
        """Periods of its modes, or else the lowest of a body that is rigid here."""
        if self.modes:
            return tuple(
                NaturalPeriod(
                    self.name,
                    "bending modes" if mode.stretch is None else "modes along the bar",
                    2 * sp.pi / expr(mode.frequency),
                    modelled=True,
                )
                for mode in self.modes
            )
        if self.lowest_period is not None:
            return (NaturalPeriod(self.name, "lowest mode", expr(self.lowest_period)),)
        if self.length is not None:
            bar = RoundBar(expr(self.mass), expr(self.length), DENSITY, MODULUS)
            frequency = bar.bending_frequency(first_bending_wavenumber(("free", "free")))
            return (NaturalPeriod(self.name, "first bending mode", 2 * sp.pi / frequency),)
        return ()

    def faults(
        self, coordinates: Sequence[sp.Symbol], parameters: Sequence[Parameter]
    ) -> Iterator[str]:
        """Yield a sentence for each mode, length or period that cannot be: out of range, mostly."""
        known = {p.symbol for p in parameters}
        for title, value in (("length", self.length), ("lowest_period", self.lowest_period)):
            if value is None:
                continue
            if expr(value).is_nonpositive:
                yield f"{self.name}: {title} is {value}, need > 0."
            if expr(value).free_symbols - known:
                yield f"{self.name}: {title} is {value}, need a formula of parameters alone."
            if self.modes:
                yield f"{self.name}: got modes and {title}. Fix: leave {title} out."
        where = f"{self.name}: mode"
        for mode in self.modes:
            named = f"{where} {mode.coordinate}"
            if mode.coordinate not in coordinates:
                yield f"{where}: " + unknown_name(
                    "coordinate", str(mode.coordinate), map(str, coordinates)
                )
            for title, value in (("mass", mode.mass), ("frequency", mode.frequency)):
                if _at_defaults(value, parameters).is_positive is False:
                    yield f"{named}: {title} is {_shown(value, parameters)}, need > 0."
            damping = expr(mode.damping)
            if _at_defaults(damping, parameters).is_negative:
                yield f"{named}: damping ratio is {_shown(damping, parameters)}, need >= 0."
            elif damping.is_nonnegative is None:
                yield (
                    f"{named}: damping ratio is {damping}, which other parameters make negative, "
                    "need >= 0. Fix: give its parameters lower = 0."
                )
        for before, after in self.successive_modes:
            difference = expr(after.frequency) - expr(before.frequency)
            if difference.is_negative or _at_defaults(difference, parameters).is_negative:
                yield (
                    f"{where} {after.coordinate}: frequency {after.frequency} is below the one "
                    f"before, {before.frequency}. Fix: order the modes of one kind by frequency."
                )

    @property
    def bounds(self) -> Iterator[tuple[sp.Expr, str, float]]:
        """Margins that are positive where frequencies are and ascend, if parameters decide them.

        Each with what is so there, and `DomainBound.near`.
        """
        where = f"{self.name}: mode"
        for mode in self.modes:
            frequency = expr(mode.frequency)
            if frequency.is_positive is None:
                yield frequency, f"{where} {mode.coordinate}: a natural frequency is positive", 0.0
        for before, after in self.successive_modes:
            difference = expr(after.frequency) - expr(before.frequency)
            if difference.is_nonnegative is None:
                meaning = f"{where} {after.coordinate}: modes of one kind ascend in frequency"
                yield difference, meaning, 0.0

    @property
    def springs(self) -> tuple[Spring, ...]:
        """Those of its modes."""
        return tuple(mode.spring for mode in self.modes)

    def kinetic_energy(self, rates: Rates) -> sp.Expr:
        """Return T; J."""
        speeds = [rate(c, rates) for c in self.centre]
        turn = rate(self.angle, rates)
        inertia = expr(self.inertia)
        for mode in self.modes:
            if mode.stretch is not None:
                q = mode.coordinate
                inertia += 2 * expr(mode.stretch) * q + expr(mode.mass) * q**2
        kinetic = expr(self.mass) * sum(v**2 for v in speeds) / 2 + inertia * turn**2 / 2
        shift = [rate(p, rates) for p in self._mass_shift]
        kinetic += sum(v * p for v, p in zip(speeds, shift, strict=True))
        for mode in self.modes:
            speed = rates[mode.coordinate]
            kinetic += expr(mode.angular_momentum) * turn * speed + expr(mode.mass) * speed**2 / 2
        return kinetic

    @property
    def _mass_shift(self) -> tuple[sp.Expr, sp.Expr]:
        """∫φ dm q summed over the modes: m times the mass centre's shift, along x and y."""
        x, y = (
            sum((expr(m.momentum[i]) * m.coordinate for m in self.modes), sp.S.Zero) for i in (0, 1)
        )
        return moved((0, 0), (x, y), self.angle)

    def point(
        self, at: tuple[Scalar, Scalar], shape: Shape | None = None
    ) -> tuple[sp.Expr, sp.Expr]:
        """Return the place (x, y) of a material point as a function of q and t.

        Parameters
        ----------
        at : pair of sympy.Expr
            (ξ, η) of the undeformed point in the body's frame, from the mass centre; m.
        shape : mapping of modal coordinate to pair of sympy.Expr
            (φ_ξ, φ_η) of every mode at the point.

        Raises
        ------
        ModelError
            Modes without value at the point, values of unknown modes.
        """
        shape = shape or {}
        modes = [m.coordinate for m in self.modes]
        faults = [
            f"mode {q} has no value at this point. Fix: give its shape there; (0, 0) at a node."
            for q in modes
            if q not in shape
        ]
        faults += [
            f"{q} is not a mode of this body; its modes: {', '.join(map(str, modes)) or 'none'}."
            for q in shape
            if q not in modes
        ]
        refuse_faulty(f"point of {self.name}", faults)
        x, y = (
            expr(at[i]) + sum((expr(values[i]) * q for q, values in shape.items()), sp.S.Zero)
            for i in (0, 1)
        )
        return moved(self.centre, (x, y), self.angle)

    @property
    def mass_moment(self) -> tuple[sp.Expr, sp.Expr]:
        """m (x, y) of the mass centre of the deformed body; kg m."""
        x, y = self._mass_shift
        mass = expr(self.mass)
        return mass * expr(self.centre[0]) + x, mass * expr(self.centre[1]) + y


@dataclass(frozen=True)
class Spring:
    """A linear spring with a damper, along any extension e(q, t): F = −k e − c ė.

    Attributes
    ----------
    extension : sympy.Expr
        e(q, t), zero where the spring is relaxed; m, or rad for a torsion spring.
    stiffness, damping : sympy.Expr
        k and c; N/m and N s/m, or N m/rad and N m s/rad.

    Examples
    --------
    >>> import sympy as sp
    >>> import painleve_sym as ps
    >>> x, k, c = sp.symbols("x k c")
    >>> ps.Spring(x - sp.Rational(1, 2), stiffness=k, damping=c).extension
    x - 1/2
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

    Examples
    --------
    >>> import sympy as sp
    >>> from painleve_sym.mechanics import Load
    >>> phi, tau = sp.symbols("phi tau")
    >>> Load.torque(phi, tau)
    Load(along=(phi,), values=(tau,))
    """

    along: tuple[Scalar, ...]
    values: tuple[Scalar, ...]

    @classmethod
    def force(cls, point: tuple[Scalar, ...], components: tuple[Scalar, ...]) -> Load:
        """Return the force (F_x, F_y) on the point (x, y) of a body; three of each in space."""
        return cls(point, components)

    @classmethod
    def torque(cls, angle: Scalar, value: Scalar) -> Load:
        """Return the torque on the body, or between the bodies, whose angle is given."""
        return cls((angle,), (value,))

    def forces(self, q: Sequence[sp.Symbol]) -> list[sp.Expr]:
        """Return the generalized forces."""
        pairs = list(zip(self.along, self.values, strict=True))
        return [sum((expr(f) * sp.diff(expr(a), s) for a, f in pairs), sp.Integer(0)) for s in q]


def _at_defaults(value: Scalar, parameters: Sequence[Parameter]) -> sp.Expr:
    """Return a formula with the defaults of the parameters, where only these occur in it."""
    formula = expr(value).xreplace({p.symbol: sp.Float(p.default) for p in parameters})
    return formula if formula.is_number else expr(value)


def _shown(value: Scalar, parameters: Sequence[Parameter]) -> str:
    """Return a formula as text, with its number where parameters occur in it."""
    number = _at_defaults(value, parameters)
    same = not expr(value).free_symbols or not number.is_number
    return str(value) if same else f"{value} = {sp.N(number, 6)} at the defaults"


def weight(bodies: Iterable[Body | SpatialBody], gravity: Scalar | tuple[Scalar, ...]) -> sp.Expr:
    """Return the potential energy of the bodies' weight; J.

    `gravity` is g, acting along −y in the plane and −z in space, or the acceleration vector; m/s².
    """
    total = sp.Integer(0)
    for moments in (b.mass_moment for b in bodies):
        level = (0,) * (len(moments) - 1)
        pull = gravity if isinstance(gravity, tuple) else (*level, -expr(gravity))
        for g, moment in zip(pull, moments, strict=True):
            total += -expr(g) * moment
    return total
