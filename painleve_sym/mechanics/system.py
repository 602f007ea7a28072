"""Lagrangian systems: from T, V and generalized forces to mass matrix and bias force."""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import sympy as sp

from painleve_sym.equality import Compared
from painleve_sym.errors import refuse_faulty, refuse_unknown, repeated, unknown_name
from painleve_sym.mechanics.bodies import Body, Load, Scalar, Spring, expr, rate, weight
from painleve_sym.mechanics.declarations import (
    NOT_DERIVED_FROM,
    TIME_NAME,
    Coordinate,
    Parameter,
    Velocity,
)
from painleve_sym.mechanics.pulses import pulse_faults
from painleve_sym.mechanics.quaternions import Quaternion, quaternions_of, velocities_of
from painleve_sym.mechanics.simplify import on_unit_sphere, readable, reduced
from painleve_sym.mechanics.spatial_bodies import SpatialBody
from painleve_sym.mechanics.velocity_terms import clearly_positive, velocity_terms

TIME = sp.Symbol(TIME_NAME, real=True)
"""The time, in every formula that prescribes a motion; s."""

_CONTACT_NAMES = (
    ("gap", "gap_dot", "slip_velocity", "delta", "delta_dot", "delta_max", "K_e", "e_squared"),
    ("friction_dissipation", "contact_dissipation", "force_dissipation", "F_n", "F_t"),
    ("v_t", "v_n", "v_n_plus", "v_n_minus", "E_c", "P_c", "deflection_from_slip", "slip_side"),
)
_FUNCTION_NAMES = ("sin", "cos", "tan", "sqrt", "exp", "log", "atan2", "abs", "pi")
RESERVED = frozenset((*(n for group in _CONTACT_NAMES for n in group), *_FUNCTION_NAMES))
"""Names a coordinate or parameter cannot have: it would be taken for what they mean."""

_STEPS = (sp.Heaviside, sp.sign, sp.floor, sp.ceiling, sp.Piecewise, sp.Mod)
_KINKS = (sp.Abs, sp.Max, sp.Min)

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)


def name_fault(name: str) -> str | None:
    """Return one sentence when a coordinate or parameter cannot have this name, else None."""
    if not _NAME.fullmatch(name) or keyword.iskeyword(name):
        return (
            f"name {name!r} is not usable. Fix: use a letter, then letters, digits and "
            "underscores; no word of the Python language."
        )
    if name in RESERVED:
        return f"name {name!r} is reserved. Fix: use another, such as {name + '_1'!r}."
    return None


def sample_values(symbols: Iterable[sp.Symbol], seed: int) -> dict[sp.Symbol, sp.Expr]:
    """Return exact values of symbols, to distinguish zero from what is not zero.

    A formula that vanishes at the points of two seeds vanishes identically.
    """
    return {
        s: sp.Rational(7 * i + 11 * seed, 13 + i) for i, s in enumerate(sorted(symbols, key=str))
    }


def determinant(matrix: sp.Matrix) -> sp.Expr:
    """Return the determinant without multiplying anything out, which SymPy's own does."""
    if matrix.rows == 1:
        return matrix[0, 0]
    total = sp.Integer(0)
    for column in range(matrix.cols):
        if matrix[0, column] != 0:
            minor = determinant(matrix.minor_submatrix(0, column))
            total += (-1) ** column * matrix[0, column] * minor
    return total


def vanishes(number: sp.Expr) -> bool:
    """Return whether a value at a sample point, taken to 30 digits, is zero."""
    return number is not sp.nan and bool(abs(number) <= sp.Float("1e-20"))


def vanish_everywhere(formulas: Iterable[sp.Expr]) -> bool:
    """Return whether formulas are zero for all values of their symbols, by those of two seeds."""
    every = list(formulas)
    symbols = set[sp.Symbol]().union(*(f.free_symbols for f in every))
    points = [sample_values(symbols, seed) for seed in (1, 2)]
    return all(vanishes(f.xreplace(point).evalf(30)) for point in points for f in every)


def singular_part(formula: sp.Expr) -> sp.Expr | None:
    """Return a part that is zero everywhere, by which a formula divides, or whose root it takes.

    Such a formula, or its derivative, is nowhere finite, which SymPy may find much later.
    Logarithms and angles of such parts count, too.
    """
    powers = formula.atoms(sp.Pow)
    parts = {p.base for p in powers if not (p.exp.is_Integer and p.exp.is_positive)}
    parts |= {f.args[0] for f in formula.atoms(sp.log)}
    parts |= {sum(a**2 for a in f.args) for f in formula.atoms(sp.atan2)}
    compound = sorted((p for p in parts if p.args), key=sp.default_sort_key)
    for part in compound:
        if all(_is_zero(part, point) for point in _points(part)):
            return part
    return None


def not_finite(part: sp.Expr) -> str:
    """Return the sentence about a formula with such a part."""
    return (
        f"not finite: {part} is 0 everywhere, and the formula divides by it or takes its root, "
        "logarithm or angle. Fix: leave it out."
    )


def _points(formula: sp.Expr) -> Iterator[dict[sp.Symbol, sp.Expr]]:
    """Yield values of the symbols: of both signs, where they may be negative."""
    for seed, signs in ((1, (1, 1)), (2, (1, -1)), (1, (-1, 1)), (2, (-1, -1))):
        values = sample_values(formula.free_symbols, seed)
        yield {
            s: v if s.is_nonnegative else signs[i % 2] * v
            for i, (s, v) in enumerate(values.items())
        }


def _is_zero(part: sp.Expr, point: Mapping[sp.Symbol, sp.Expr]) -> bool:
    """Return whether a part is zero at a point; a sum, beside its terms."""
    if not part.args or isinstance(part, sp.exp):
        return False
    if part.is_Mul or isinstance(part, sp.Abs):
        return any(_is_zero(factor, point) for factor in part.args)
    if part.is_Pow:
        return bool(part.exp.is_positive) and _is_zero(part.base, point)
    if part.is_Add and all(_is_zero(term, point) for term in part.args):
        return True
    terms = part.args if part.is_Add else ()
    total, *sizes = (abs(sp.N(e.xreplace(point), 30)) for e in (part, *terms))
    limit = max(sizes) * sp.Float("1e-20") if sizes else sp.Float("1e-50")
    return bool((total <= limit) == True)  # noqa: E712, a comparison that SymPy leaves open


@dataclass(frozen=True, eq=False)
class LagrangianSystem(Compared):
    """A holonomic mechanical system given by its energies.

    Lagrange's equations d/dt(∂T/∂q̇) − ∂T/∂q + ∂V/∂q = Q + Jᵀ F are kept as
    M(q, t) q̈ = h(q, q̇, t) + Jᵀ F, with contact forces F added by `Contact`.

    Where coordinates are parts of a `Quaternion`, the velocities are u with q̇ = N(q) u: the rates
    of the other coordinates and the angular velocity ω along the axes of that body. Then
    d/dt(∂T/∂u) + (ω × ∂T/∂ω in the rows of ω) − Nᵀ ∂(T − V)/∂q = Q + Jᵀ F, and q̇, q̈ above stand
    for u, u̇: Lagrange's equations in quasi-velocities.

    Every formula may depend on the time, `TIME`: a pivot or a frame that moves as prescribed gives
    T terms linear in q̇ and free of it. Where a coordinate or parameter is called ``t``, that is
    what `TIME` means, and nothing depends on the time.

    Parameters
    ----------
    name : str
    coordinates : tuple of Coordinate
        With all four parts of every quaternion among them.
    parameters : tuple of Parameter
    kinetic_energy : sympy.Expr
        T(q, u, t), quadratic in the n velocities u; J.
    potential_energy : sympy.Expr
        V(q, t); J.
    generalized_forces : mapping of coordinate name to sympy.Expr
        Q_i(q, u, t); absent ones are 0. Sign: positive does work in the positive q_i direction.
        A part of an angular velocity, such as ``omega_1``, names the moment about that axis.
    bodies : tuple of Body
        The rigid bodies of which the energies are those, for drawings; nothing is derived from it.

    Raises
    ------
    ModelError
        Lists every fault: unusable, reserved or repeated names, missing units, undeclared
        symbols, jumps and kinks at given times, T not quadratic or not positive in the velocities.

    Examples
    --------
    >>> import sympy as sp
    >>> import painleve_sym as ps
    >>> x = ps.Coordinate("x", "place", "m")
    >>> y = ps.Coordinate("y", "height", "m")
    >>> m = ps.Parameter("m", 2.0, "kg", "mass", 0.0, lower_closed=False)
    >>> g = ps.Parameter("g", 9.8, "m/s^2", "gravity", 0.0)
    >>> block = ps.Body(m.symbol, (x.symbol, y.symbol))
    >>> system = ps.LagrangianSystem.of_bodies("block", (x, y), (m, g), [block], gravity=g.symbol)
    >>> system.kinetic_energy, system.potential_energy
    (m*(x_dot**2 + y_dot**2)/2, g*m*y)
    >>> system.mass_matrix
    Matrix([
    [m, 0],
    [0, m]])
    """

    name: str
    coordinates: tuple[Coordinate, ...]
    parameters: tuple[Parameter, ...]
    kinetic_energy: sp.Expr
    potential_energy: sp.Expr
    generalized_forces: Mapping[str, sp.Expr] = field(default_factory=dict)
    bodies: tuple[Body, ...] = field(default=(), compare=False, metadata=NOT_DERIVED_FROM)

    def __post_init__(self) -> None:
        refuse_faulty(f"mechanism {self.name!r}", self._faults())

    def __repr__(self) -> str:
        """Return the names of coordinates and parameters in one line."""
        q, p = (", ".join(d.name for d in group) for group in (self.coordinates, self.parameters))
        return f"LagrangianSystem {self.name!r}: coordinates {q}; parameters {p}"

    @classmethod
    def of_bodies(
        cls,
        name: str,
        coordinates: Sequence[Coordinate],
        parameters: Sequence[Parameter],
        bodies: Sequence[Body | SpatialBody],
        *,
        gravity: Scalar | tuple[Scalar, ...] = 0,
        springs: Sequence[Spring] = (),
        loads: Sequence[Load] = (),
        kinetic_energy: Scalar = 0,
        potential_energy: Scalar = 0,
        generalized_forces: Mapping[str, Scalar] | None = None,
    ) -> LagrangianSystem:
        """Return the system of bodies with springs, dampers and applied loads.

        Parameters
        ----------
        name, coordinates, parameters
            As for `LagrangianSystem`.
        bodies : sequence of Body or SpatialBody
            All in the plane, or all in space.
        gravity : sympy.Expr or tuple
            g along −y in the plane and −z in space, or the acceleration vector; m/s².
        springs : sequence of Spring
        loads : sequence of Load
        kinetic_energy, potential_energy : sympy.Expr
            What is to be added to the bodies', and to weight and springs; J.
        generalized_forces : mapping of coordinate name to sympy.Expr
            What is to be added to dampers and loads.
        """
        q, rates = [c.symbol for c in coordinates], _rates(coordinates, parameters)
        velocities, columns = velocities_of(coordinates), _columns_of_N(coordinates)
        faults = [fault for b in bodies for fault in b.faults(q, parameters)]
        if len({len(b.centre) for b in bodies}) > 1:
            faults.append("got bodies in the plane and in space. Fix: give every centre a z.")
        if not faults and isinstance(gravity, tuple) and bodies:
            need = len(bodies[0].centre)
            if len(gravity) != need:
                faults.append(f"gravity: got {len(gravity)} components, need {need}.")
        refuse_faulty(f"mechanism {name!r}", faults)
        springs = [*springs, *(spring for b in bodies for spring in b.springs)]
        kinetic = sum((b.kinetic_energy(rates) for b in bodies), expr(kinetic_energy))
        potential = expr(potential_energy) + weight(bodies, gravity)
        potential += sum(s.potential_energy for s in springs)
        given = {k: _with_signs(expr(v)) for k, v in (generalized_forces or {}).items()}
        parts = [s.forces(q, rates) for s in springs] + [load.forces(q) for load in loads]
        for velocity, column in zip(velocities, columns, strict=True):
            own = (p[q.index(s)] * n for p in parts for s, n in column)
            total = sum(own, given.get(velocity.row, sp.Integer(0)))
            if total != 0:
                given[velocity.row] = total
        declared = (name, tuple(coordinates), tuple(parameters))
        planar = tuple(body for body in bodies if isinstance(body, Body))
        return cls(*declared, kinetic, potential, given, planar)

    def _faults(self) -> list[str]:
        faults = list(self._name_faults())
        entries = {"kinetic energy": self.kinetic_energy, "potential energy": self.potential_energy}
        for key, value in self.generalized_forces.items():
            entries[f"generalized force {key!r}"] = value
            rows = [v.row for v in self.velocities]
            if key not in rows:
                kind = "coordinate of a generalized force"
                faults.append(unknown_name(kind, key, rows))
        for name, entry in entries.items():
            faults += self.formula_faults(name, entry)
        if set(sp.sympify(self.potential_energy).free_symbols) & set(self.q_dot):
            faults.append("potential energy depends on a velocity. Fix: use a generalized force.")
        if not faults:
            faults += self._mass_faults()
        return faults

    def formula_faults(self, name: str, formula: Scalar) -> Iterator[str]:
        """Yield a sentence for each symbol not declared, and for what is not finite or smooth.

        Jumps and kinks at given times are not smooth.

        Parameters
        ----------
        name : str
            What the sentences call the formula.
        formula : sympy.Expr
        """
        formula = sp.sympify(formula)
        for symbol in sorted(formula.free_symbols - {*self.symbols, *self.clock}, key=str):
            if symbol == TIME:
                yield f"{name}: t is the time, but a parameter is called t. Fix: rename it."
            else:
                yield f"{name}: " + unknown_name("symbol", str(symbol), map(str, self.symbols))
        if (part := singular_part(formula)) is not None:
            yield f"{name}: {not_finite(part)}"
        constants = {p.symbol for p in self.parameters}
        yield from (f"{name}: {fault}" for fault in pulse_faults(formula, constants))
        if TIME in self.clock and TIME in formula.free_symbols:
            moving = {*self.q, *self.q_dot}
            for part in sorted(formula.atoms(*_STEPS, *_KINKS), key=str):
                inner = part.free_symbols
                if TIME in inner and (isinstance(part, _STEPS) or not inner & moving):
                    yield (
                        f"{name}: {part} jumps or has a kink at given times, where no event "
                        "would stop the integration; need a smooth function of t, or pulses. "
                        "Fix: use functions such as sin, or pulse(t, start, width) and "
                        "square(t, period), at whose edges steps end."
                    )

    def _name_faults(self) -> Iterator[str]:
        if not self.coordinates:
            yield "it has no coordinate; need at least one."
        entries: list[tuple[str, Coordinate | Parameter]] = []
        entries += [("coordinate", c) for c in self.coordinates]
        entries += [("parameter", p) for p in self.parameters]
        names = [e.name for _, e in entries] + [v.name for v in self.velocities]
        for name in repeated(names):
            yield f"name {name!r} is declared twice."
        for kind, entry in entries:
            fault = name_fault(entry.name)
            if fault:
                yield f"{kind}: {fault}"
            if not entry.unit.strip():
                yield (
                    f"{kind} {entry.name!r} has no unit. "
                    'Fix: give one in SI, "1" for a number without unit.'
                )
        for quaternion in self.quaternions:
            missing = [c.name for c in quaternion.coordinates if c not in self.coordinates]
            if missing:
                yield (
                    f"quaternion {quaternion.name!r} lacks {', '.join(missing)}. Fix: give "
                    "(*others, *quaternion.coordinates)."
                )
            if fault := name_fault(quaternion.velocities[0].name):
                yield f"velocity of quaternion {quaternion.name!r}: {fault}"

    def _mass_faults(self) -> list[str]:
        if all(self._is_positive(seed) for seed in (1, 2)):
            return []
        # As it comes, unless a velocity is left that may yet cancel: no search for short forms.
        mass = sp.Matrix(self._second_derivatives)
        if mass.free_symbols & set(self.q_dot):
            mass = self.mass_matrix
        if mass.free_symbols & set(self.q_dot):
            return ["kinetic energy is not quadratic in the velocities."]
        verdicts = [self._mass_verdict(mass, seed) for seed in (1, 2)]
        if all(v == "singular" for v in verdicts):
            return ["the mass matrix is singular. Fix: give every coordinate kinetic energy."]
        if all(v == "indefinite" for v in verdicts):
            # Off-diagonal moments of inertia as parameters need not go with sampled ones.
            at_defaults = mass.xreplace({p.symbol: sp.Float(p.default) for p in self.parameters})
            if self._mass_verdict(at_defaults, 1) == "positive":
                return []
            return ["kinetic energy is negative for some velocities. Fix: check its signs."]
        return []

    def _is_positive(self, seed: int) -> bool:
        """Return whether T shows at a point that it is quadratic in q̇ with M positive definite."""
        kinetic = sp.sympify(self.kinetic_energy)
        rest = kinetic.free_symbols - set(self.q_dot)
        terms = velocity_terms(kinetic, self.q_dot, sample_values(rest, seed))
        return terms is not None and clearly_positive(terms, len(self.velocities))

    @staticmethod
    def _mass_verdict(matrix: sp.Matrix, seed: int) -> str:
        mass = matrix.xreplace(sample_values(matrix.free_symbols, seed)).evalf(30)
        n = mass.rows
        minors = [determinant(mass[:k, :k]) for k in range(1, n + 1)]
        if vanishes(minors[-1]):
            return "singular"
        negative = any(m.is_real and m < 0 for m in minors)
        return "indefinite" if negative else "positive"

    @cached_property
    def symbols(self) -> frozenset[sp.Symbol]:
        """Every declared symbol; a formula of the mechanism may contain these and the time."""
        return frozenset((*self.q, *self.q_dot, *(p.symbol for p in self.parameters)))

    @cached_property
    def clock(self) -> tuple[sp.Symbol, ...]:
        """`TIME` alone; empty where a coordinate or parameter is called ``t``."""
        return tuple(s for s in self.rates if s not in self.q)

    @cached_property
    def rates(self) -> dict[sp.Symbol, sp.Expr]:
        """Time derivatives of coordinates and time: q_i to q̇_i, a row of N(q) u; t to 1."""
        return _rates(self.coordinates, self.parameters)

    @property
    def defaults(self) -> dict[sp.Symbol, float]:
        """Defaults of the parameters by symbol."""
        return {p.symbol: p.default for p in self.parameters}

    def coordinate(self, name: str, where: str) -> sp.Symbol:
        """Return the symbol of a coordinate; InputError, by `where`, for another name."""
        names = [c.name for c in self.coordinates]
        refuse_unknown("coordinate", name, names, where)
        return self.q[names.index(name)]

    @property
    def q(self) -> tuple[sp.Symbol, ...]:
        """Coordinate symbols, as many as coordinates."""
        return tuple(c.symbol for c in self.coordinates)

    @property
    def q_dot(self) -> tuple[sp.Symbol, ...]:
        """Symbols of the velocities u, length n: q̇ but for quaternions."""
        return tuple(v.symbol for v in self.velocities)

    @cached_property
    def quaternions(self) -> tuple[Quaternion, ...]:
        """The quaternions among the coordinates."""
        return quaternions_of(self.coordinates)

    @cached_property
    def velocities(self) -> tuple[Velocity, ...]:
        """The velocities u, length n, fewer than coordinates where there are quaternions."""
        return velocities_of(self.coordinates)

    @property
    def N(self) -> sp.Matrix:
        """Of q̇ = N(q) u: the identity without quaternions."""
        return sp.Matrix([[sp.diff(self.rates[q], u) for u in self.q_dot] for q in self.q])

    def slopes(self, formula: Scalar) -> list[sp.Expr]:
        """Return Nᵀ ∂f/∂q of a function of q and t, length n: how each velocity changes it."""
        return [
            sum((sp.diff(formula, q) * n for q, n in column), sp.Integer(0))
            for column in self._columns
        ]

    @cached_property
    def _columns(self) -> list[list[tuple[sp.Symbol, sp.Expr]]]:
        return _columns_of_N(self.coordinates)

    def readable(self, formula: sp.Expr) -> sp.Expr:
        """Return the formula as `simplify.readable` does, shortened by |q| = 1 of quaternions."""
        forms = [formula]
        for quaternion in self.quaternions:
            forms += [new for f in forms for new in on_unit_sphere(f, quaternion.symbols)]
        return readable(min(forms, key=sp.count_ops) if len(forms) > 1 else formula)

    @cached_property
    def mass_matrix(self) -> sp.Matrix:
        """M = ∂²T/∂u², shape (n, n), symmetric."""
        return sp.Matrix(self._second_derivatives).applyfunc(self.readable)

    @property
    def _second_derivatives(self) -> list[list[sp.Expr]]:
        """∂²T/∂u², as it comes."""
        momenta = [sp.diff(self.kinetic_energy, v) for v in self.q_dot]
        return [[sp.diff(p, v) for v in self.q_dot] for p in momenta]

    @cached_property
    def bias_force(self) -> sp.Matrix:
        """h = Nᵀ ∂(T − V)/∂q − (∂²T/∂u∂q) q̇ − ∂²T/∂u∂t − ω × ∂T/∂ω + Q, shape (n, 1)."""
        momenta = sp.Matrix([sp.diff(self.kinetic_energy, v) for v in self.q_dot])
        transport = momenta.jacobian(self.q) * sp.Matrix([self.rates[q] for q in self.q])
        for symbol in self.clock:
            transport += sp.diff(momenta, symbol)
        for quaternion in self.quaternions:
            own = [self.velocities.index(v) for v in quaternion.velocities]
            turn = sp.Matrix([v.symbol for v in quaternion.velocities])
            for i, gyroscopic in zip(own, turn.cross(momenta.extract(own, [0])), strict=True):
                transport[i] += gyroscopic
        rows = []
        slopes = self.slopes(self.kinetic_energy - self.potential_energy)
        for i, v in enumerate(self.velocities):
            row = slopes[i] - transport[i]
            rows.append(self.readable(row + self.generalized_forces.get(v.row, sp.Integer(0))))
        return sp.Matrix(rows)

    @cached_property
    def _adjugate(self) -> tuple[sp.Matrix, sp.Expr]:
        """Adjugate and determinant of M, shortened before any division."""
        mass = self.mass_matrix
        n = mass.rows
        adjugate = sp.zeros(n, n)
        for i in range(n):
            for j in range(i + 1):
                minor = determinant(mass.minor_submatrix(i, j)) if n > 1 else sp.Integer(1)
                adjugate[i, j] = adjugate[j, i] = reduced((-1) ** (i + j) * minor)
        return adjugate, reduced(determinant(mass))

    @cached_property
    def inverse_mass_matrix(self) -> sp.Matrix:
        """M⁻¹, shape (n, n)."""
        adjugate, determinant = self._adjugate
        return adjugate.applyfunc(lambda cofactor: readable(cofactor / determinant))

    @cached_property
    def free_acceleration(self) -> sp.Matrix:
        """q̈ = M⁻¹ h without contact forces, shape (n, 1)."""
        adjugate, determinant = self._adjugate
        whole = (self.inverse_mass_matrix * self.bias_force).applyfunc(readable)
        # A second way to the same: multiplied out before the division, much may cancel.
        parts = (adjugate * self.bias_force).applyfunc(
            lambda entry: readable(reduced(entry) / determinant)
        )
        pairs = zip(whole, parts, strict=True)
        return sp.Matrix([min(pair, key=sp.count_ops) for pair in pairs])

    @cached_property
    def dissipated_power(self) -> sp.Expr:
        """−d(T + V)/dt without contact forces: what forces take out and drives bring in; W.

        −Qᵀ q̇ + ∂(T − V)/∂t − d(T₁ + 2 T₀)/dt, with T₁ and T₀ the parts of T that are linear in q̇
        and free of it; only the first term is left where nothing moves as prescribed.
        """
        power = sum(
            (self.generalized_forces.get(v.row, sp.Integer(0)) * v.symbol for v in self.velocities),
            sp.Integer(0),
        )
        for symbol in self.clock:
            power -= sp.diff(self.kinetic_energy - self.potential_energy, symbol)
        if self._still_energy != 0 or any(self.still_momenta):
            linear = (self.still_momenta.T * sp.Matrix(self.q_dot))[0]
            power += rate(linear + 2 * self._still_energy, self.rates)
            power += (self.still_momenta.T * self.free_acceleration)[0]
        return readable(-power)

    @cached_property
    def still_momenta(self) -> sp.Matrix:
        """∂T/∂q̇ where q̇ = 0, shape (n, 1): not 0 where a frame or pivot moves as prescribed."""
        momenta = [self._at_rest(sp.diff(self.kinetic_energy, v)) for v in self.q_dot]
        return sp.Matrix(momenta)

    @cached_property
    def _still_energy(self) -> sp.Expr:
        """T₀: T where q̇ = 0; J."""
        return self._at_rest(self.kinetic_energy)

    def _at_rest(self, formula: sp.Expr) -> sp.Expr:
        still = dict.fromkeys(self.q_dot, sp.Integer(0))
        value = sp.sympify(formula).xreplace(still)
        return value if value == 0 else readable(value)


def _columns_of_N(coordinates: Sequence[Coordinate]) -> list[list[tuple[sp.Symbol, sp.Expr]]]:
    """Return for each velocity the coordinates that it changes, with their entries of N."""
    columns = []
    for velocity in velocities_of(coordinates):
        entries = ((c.symbol, sp.diff(c.rate, velocity.symbol)) for c in coordinates)
        columns.append([(symbol, entry) for symbol, entry in entries if entry != 0])
    return columns


def _rates(
    coordinates: Sequence[Coordinate], parameters: Sequence[Parameter]
) -> dict[sp.Symbol, sp.Expr]:
    """Return the rates of the coordinates, and 1 of the time unless its name is taken."""
    rates: dict[sp.Symbol, sp.Expr] = {c.symbol: c.rate for c in coordinates}
    names = {*(c.name for c in coordinates), *(p.name for p in parameters)}
    if TIME.name not in names:
        rates[TIME] = sp.Integer(1)
    return rates


def _with_signs(force: sp.Expr) -> sp.Expr:
    """Return a force with sign(v) in place of v/|v|, which has a value at v = 0, too."""

    def signed(product: sp.Expr) -> sp.Expr:
        for size in product.atoms(sp.Abs):
            if sp.Pow(size, -1) in product.args and size.args[0] in product.args:
                product = product * size / size.args[0] * sp.sign(size.args[0])
        return product

    return force.replace(lambda e: e.is_Mul and e.has(sp.Abs), signed)
