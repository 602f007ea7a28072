"""Lagrangian systems: from T, V and generalized forces to mass matrix and bias force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import sympy as sp

from painleve_sym.errors import ModelError, unknown_name
from painleve_sym.mechanics.readable import readable


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
    """

    name: str
    meaning: str
    unit: str
    latex: str = ""

    @cached_property
    def symbol(self) -> sp.Symbol:
        """Symbol of the coordinate."""
        return sp.Symbol(self.name, real=True)

    @cached_property
    def rate(self) -> sp.Symbol:
        """Symbol of the velocity."""
        return sp.Symbol(f"{self.name}_dot", real=True)

    @cached_property
    def acceleration(self) -> sp.Symbol:
        """Symbol of the acceleration."""
        return sp.Symbol(f"{self.name}_ddot", real=True)


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
    """

    name: str
    default: float
    unit: str
    meaning: str
    lower: float = -float("inf")
    upper: float = float("inf")
    lower_closed: bool = True
    upper_closed: bool = True

    @cached_property
    def symbol(self) -> sp.Symbol:
        """Symbol: positive, nonnegative or real as the range tells."""
        if self.lower > 0 or (self.lower == 0 and not self.lower_closed):
            return sp.Symbol(self.name, positive=True)
        if self.lower == 0:
            return sp.Symbol(self.name, nonnegative=True)
        return sp.Symbol(self.name, real=True)

    def fault(self, value: float) -> str | None:
        """Return one sentence when `value` is not valid, else None."""
        above = value >= self.lower if self.lower_closed else value > self.lower
        below = value <= self.upper if self.upper_closed else value < self.upper
        if above and below and abs(value) != float("inf"):
            return None
        return f"parameter {self.name} ({self.meaning}): got {value!r}, need {self.range_text}."

    @property
    def range_text(self) -> str:
        """The valid range in words, e.g. ``0 <= e_energetic <= 1``."""
        text = self.name
        if self.lower != -float("inf"):
            text = f"{self.lower:g} {'<=' if self.lower_closed else '<'} {text}"
        if self.upper != float("inf"):
            text = f"{text} {'<=' if self.upper_closed else '<'} {self.upper:g}"
        return f"a finite number with {text}" if text != self.name else "a finite number"


@dataclass(frozen=True)
class LagrangianSystem:
    """A holonomic mechanical system given by its energies.

    Lagrange's equations d/dt(∂T/∂q̇) − ∂T/∂q + ∂V/∂q = Q + Jᵀ F are kept as
    M(q) q̈ = h(q, q̇) + Jᵀ F, with contact forces F added by `Contact`.

    Parameters
    ----------
    name : str
    coordinates : tuple of Coordinate, length n
    parameters : tuple of Parameter
    kinetic_energy : sympy.Expr
        T(q, q̇), quadratic in q̇; J.
    potential_energy : sympy.Expr
        V(q); J.
    generalized_forces : mapping of coordinate name to sympy.Expr
        Q_i(q, q̇); absent ones are 0. Sign: positive does work in the positive q_i direction.

    Raises
    ------
    ModelError
        Lists every fault: undeclared symbols, repeated names, T not depending on some q̇.
    """

    name: str
    coordinates: tuple[Coordinate, ...]
    parameters: tuple[Parameter, ...]
    kinetic_energy: sp.Expr
    potential_energy: sp.Expr
    generalized_forces: Mapping[str, sp.Expr] = field(default_factory=dict)

    def __post_init__(self) -> None:
        faults = list(self._faults())
        if faults:
            raise ModelError(f"mechanism {self.name!r}", faults)

    def _faults(self) -> list[str]:
        names = [c.name for c in self.coordinates] + [p.name for p in self.parameters]
        twice = sorted({n for n in names if names.count(n) > 1})
        faults = [f"name {n!r} is declared twice." for n in twice]
        known = set(self.q) | set(self.q_dot) | {p.symbol for p in self.parameters}
        entries = {"kinetic energy": self.kinetic_energy, "potential energy": self.potential_energy}
        for key, value in self.generalized_forces.items():
            entries[f"generalized force {key!r}"] = value
            if key not in [c.name for c in self.coordinates]:
                kind = "coordinate of a generalized force"
                faults.append(unknown_name(kind, key, [c.name for c in self.coordinates]))
        for what, expr in entries.items():
            for symbol in sorted(sp.sympify(expr).free_symbols - known, key=str):
                faults.append(f"{what}: " + unknown_name("symbol", str(symbol), map(str, known)))
        if set(self.potential_energy.free_symbols) & set(self.q_dot):
            faults.append("potential energy depends on a velocity. Fix: use a generalized force.")
        if not faults:
            faults += self._mass_faults()
        return faults

    def _mass_faults(self) -> list[str]:
        if self.mass_matrix.free_symbols & set(self.q_dot):
            return ["kinetic energy is not quadratic in the velocities."]
        # Random rational points: a determinant that is zero at both is zero identically.
        for seed in (1, 2):
            values = {
                s: sp.Rational(7 * i + 11 * seed, 13 + i)
                for i, s in enumerate(sorted(self.mass_matrix.free_symbols, key=str))
            }
            if abs(sp.N(self.mass_matrix.subs(values).det(), 30)) > sp.Float("1e-20"):
                return []
        return ["the mass matrix is singular. Fix: give every coordinate kinetic energy."]

    @property
    def q(self) -> tuple[sp.Symbol, ...]:
        """Coordinate symbols, length n."""
        return tuple(c.symbol for c in self.coordinates)

    @property
    def q_dot(self) -> tuple[sp.Symbol, ...]:
        """Velocity symbols, length n."""
        return tuple(c.rate for c in self.coordinates)

    @cached_property
    def mass_matrix(self) -> sp.Matrix:
        """M = ∂²T/∂q̇², shape (n, n), symmetric."""
        return sp.hessian(self.kinetic_energy, self.q_dot).applyfunc(readable)

    @cached_property
    def bias_force(self) -> sp.Matrix:
        """h = ∂T/∂q − (∂²T/∂q̇∂q) q̇ − ∂V/∂q + Q, shape (n, 1)."""
        momenta = sp.Matrix([sp.diff(self.kinetic_energy, v) for v in self.q_dot])
        transport = momenta.jacobian(self.q) * sp.Matrix(self.q_dot)
        rows = []
        for i, c in enumerate(self.coordinates):
            row = sp.diff(self.kinetic_energy - self.potential_energy, c.symbol) - transport[i]
            rows.append(readable(row + self.generalized_forces.get(c.name, sp.Integer(0))))
        return sp.Matrix(rows)

    @cached_property
    def inverse_mass_matrix(self) -> sp.Matrix:
        """M⁻¹, shape (n, n)."""
        return self.mass_matrix.inv(method="ADJ").applyfunc(readable)

    @cached_property
    def free_acceleration(self) -> sp.Matrix:
        """q̈ = M⁻¹ h without contact forces, shape (n, 1)."""
        return (self.inverse_mass_matrix * self.bias_force).applyfunc(readable)

    @cached_property
    def dissipated_power(self) -> sp.Expr:
        """−Qᵀ q̇: the rate at which generalized forces take energy out of T + V; W."""
        power = sum(
            (self.generalized_forces.get(c.name, sp.Integer(0)) * c.rate for c in self.coordinates),
            sp.Integer(0),
        )
        return readable(-power)
