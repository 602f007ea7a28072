"""Mechanisms from equations that `sympy.physics.mechanics`, or a person, has derived."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from typing import Any

import sympy as sp

from painleve_sym.errors import InputError, received
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.simplify import readable
from painleve_sym.mechanics.system import TIME, LagrangianSystem, vanish_everywhere

_NEED = "need a LagrangesMethod, a KanesMethod, or a pair (M, h) with coordinates="


@dataclass(frozen=True)
class _Equations:
    """M q̈ = h in the functions of time that the coordinates are; L = T − V where it is known."""

    q: tuple[sp.Expr, ...]
    M: sp.Matrix
    h: sp.Matrix
    lagrangian: sp.Expr | None = None


def mechanism_from_sympy(
    equations: Any,
    contacts: Mapping[str, Mapping[str, Any]],
    parameters: Mapping[Any, float | Parameter],
    *,
    name: str = "imported",
    coordinates: Sequence[Any] = (),
    units: Mapping[str, str] | None = None,
    frame: Any = None,
    origin: Any = None,
    in_space: bool = False,
    potential_energy: Any = None,
    title: str = "",
    source: str = "",
) -> Mechanism:
    """Return a mechanism; see `Mechanism.from_sympy`."""
    where = f"mechanism {name!r}"
    given = _equations(equations, coordinates, where)
    declared = _coordinates(given.q, units or {}, where)
    known = _parameters(parameters, units or {}, where)
    table = _Table(given.q, declared, known, where)
    M, h = table.matrix("M", given.M), table.matrix("h", given.h)
    if not vanish_everywhere(M - M.T):
        raise InputError(f"{where}: M is not symmetric, need ∂²T/∂q̇² of a kinetic energy.")
    velocities = sp.Matrix([c.velocity.symbol for c in declared])
    if given.lagrangian is not None and potential_energy is None:
        L = table.formula("the Lagrangian", given.lagrangian)
        V = -L.subs(dict.fromkeys(velocities, 0))
        T = L + V
    else:
        V = table.formula("potential_energy", potential_energy or 0)
        T = (velocities.T * M * velocities)[0] / 2
    own = (name, tuple(declared), tuple(known.values()), T, V)
    rest = h - LagrangianSystem(*own).bias_force
    forces = {
        c.name: readable(force)
        for c, force in zip(declared, rest, strict=True)
        if not vanish_everywhere([force])
    }
    system = LagrangianSystem(*own, generalized_forces=forces)
    space = _Space(frame, origin, in_space)
    own_contacts = tuple(_contact(n, c, system, table, space) for n, c in contacts.items())
    return Mechanism(name, title or name, source or "given as equations", system, own_contacts)


def _equations(given: Any, coordinates: Sequence[Any], where: str) -> _Equations:
    """Return the equations of a method of SymPy, or of a pair (M, h)."""
    from sympy.physics.mechanics import KanesMethod, LagrangesMethod

    if isinstance(given, LagrangesMethod):
        _refuse_constraints(given, ("coneqs", "_hol_coneqs", "_nonhol_coneqs"), where)
        if given.eom is None or not len(given.eom):
            given.form_lagranges_equations()
        q = tuple(given.q)
        return _Equations(q, given.mass_matrix, given.forcing, given._L[0])
    if isinstance(given, KanesMethod):
        _refuse_constraints(given, ("_qdep", "_udep", "_f_h", "_f_nh"), where)
        return _of_kane(given, where)
    if isinstance(given, tuple | list) and len(given) == 2 and coordinates:
        M, h = (sp.Matrix(part) for part in given)
        n = len(coordinates)
        if M.shape != (n, n) or h.shape != (n, 1):
            raise InputError(
                f"{where}: got M of shape {M.shape} and h of shape {h.shape}, need ({n}, {n}) and "
                f"({n}, 1) for {n} coordinates."
            )
        return _Equations(tuple(coordinates), M, h)
    raise InputError(f"{where}: equations: got {received(given)}, {_NEED}.")


def _refuse_constraints(method: Any, attributes: Iterable[str], where: str) -> None:
    """Raise InputError for equations of constraints, which tie the coordinates or velocities."""
    for attribute in attributes:
        tied = getattr(method, attribute, None)
        if tied is not None and len(tied):
            raise InputError(
                f"{where}: the equations have constraints, need independent coordinates. Fix: "
                "solve the constraints for coordinates that are free, or make a contact of each."
            )


def _of_kane(kane: Any, where: str) -> _Equations:
    """Return Kane's equations by coordinates and their rates.

    With q̇ = N u + c the speeds are u = N⁻¹(q̇ − c), and M_u u̇ = f is
    N⁻ᵀ M_u N⁻¹ q̈ = N⁻ᵀ (f − M_u ∂u/∂t), in which ∂u/∂t is what u̇ has besides N⁻¹ q̈.
    """
    t = sp.physics.mechanics.dynamicsymbols._t
    q, u = tuple(kane.q), tuple(kane.u)
    rates = [q_i.diff(t) for q_i in q]
    by_speed = kane.kindiffdict()
    N = sp.Matrix([by_speed[rate] for rate in rates]).jacobian(u)
    if N.rows != N.cols or sp.simplify(N.det()) == 0:
        raise InputError(
            f"{where}: Kane's equations have {len(q)} coordinates and {len(u)} speeds that do not "
            "follow from each other. Fix: give kinematic equations that determine the speeds."
        )
    still = dict.fromkeys(u, 0)
    c = sp.Matrix([by_speed[rate] for rate in rates]).subs(still)
    inverse = N.inv().applyfunc(sp.simplify)
    speeds = inverse * (sp.Matrix(rates) - c)
    slopes = speeds.diff(t)
    bends = [q_i.diff(t, 2) for q_i in q]
    bias = slopes.subs(dict.fromkeys(bends, 0))
    table = dict(zip(u, speeds, strict=True))
    M, f = kane.mass_matrix, kane.forcing
    # Rates of speeds do not occur there, rates of coordinates are replaced by speeds.
    M_q = (inverse.T * M * inverse).subs(table)
    h = (inverse.T * (f - M * bias)).subs(table)
    return _Equations(q, M_q.applyfunc(sp.simplify), h.applyfunc(sp.simplify))


def _coordinates(q: Sequence[Any], units: Mapping[str, str], where: str) -> list[Coordinate]:
    """Return the coordinates, named as the functions of time."""
    declared = []
    for q_i in q:
        function = getattr(q_i, "func", None)
        if not isinstance(q_i, sp.Function | sp.core.function.AppliedUndef) or len(q_i.args) != 1:
            raise InputError(
                f"{where}: coordinate {q_i}: got {received(q_i)}, need a function of the time. "
                "Fix: dynamicsymbols('x')."
            )
        own = str(function)
        declared.append(Coordinate(own, f"coordinate {own}", units.get(own, "1")))
    return declared


def _parameters(
    given: Mapping[Any, float | Parameter], units: Mapping[str, str], where: str
) -> dict[str, Parameter]:
    """Return the parameters by the names of their symbols."""
    known = {}
    for symbol, value in given.items():
        own = str(symbol)
        if not isinstance(value, Parameter):
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InputError(
                    f"{where}: parameter {own!r}: got {received(value)}, need a number, its "
                    "default, or a Parameter."
                )
            value = Parameter(own, float(value), units.get(own, "1"), f"constant {own}")
        known[own] = value
    return known


class _Table:
    """Replaces functions of time and plain symbols by the symbols of a mechanism."""

    def __init__(
        self,
        q: Sequence[sp.Expr],
        coordinates: Sequence[Coordinate],
        parameters: Mapping[str, Parameter],
        where: str,
    ) -> None:
        self._where, self._parameters = where, parameters
        self._time = q[0].args[0]
        self._rates = {
            sp.Derivative(q_i, self._time): c.velocity.symbol
            for q_i, c in zip(q, coordinates, strict=True)
        }
        self._values = {q_i: c.symbol for q_i, c in zip(q, coordinates, strict=True)}
        self._symbols = {*self._rates.values(), *self._values.values()}

    def formula(self, noun: str, value: Any) -> sp.Expr:
        """Return a formula in the symbols of the mechanism; InputError for unknown ones."""
        formula = sp.sympify(value) if not isinstance(value, str) else None
        if formula is None:
            raise InputError(f"{self._where}: {noun}: got a text, need a SymPy expression.")
        formula = formula.doit().subs(self._rates).subs(self._values)
        own = self._symbols | {p.symbol for p in self._parameters.values()} | {TIME}
        plain: dict[Any, Any] = {self._time: TIME}
        for symbol in formula.free_symbols - own - {self._time}:
            parameter = self._parameters.get(str(symbol))
            if parameter is not None:
                plain[symbol] = parameter.symbol
        formula = formula.subs(plain)
        if unknown := sorted(map(str, self._unknown(formula, own))):
            raise InputError(
                f"{self._where}: {noun}: {', '.join(unknown)}: no value. Fix: give each constant "
                "its default in parameters=, and have coordinates in the equations alone."
            )
        return formula

    def _unknown(self, formula: sp.Expr, own: set[sp.Symbol]) -> Iterator[Any]:
        yield from formula.free_symbols - own
        yield from formula.atoms(sp.core.function.AppliedUndef)

    def matrix(self, noun: str, matrix: sp.Matrix) -> sp.Matrix:
        """Return a matrix in the symbols of the mechanism."""
        return sp.Matrix(matrix).applyfunc(lambda entry: self.formula(noun, entry))


@dataclass(frozen=True)
class _Space:
    """Axes and origin of points and vectors of `sympy.physics.vector`."""

    frame: Any
    origin: Any
    in_space: bool

    def components(self, value: Any, where: str) -> Any:
        """Return the components of a point, body or vector, any other value as it is.

        A particle is its point, a rigid body its mass centre.
        """
        from sympy.physics.mechanics import Particle, RigidBody
        from sympy.physics.vector import Point, Vector

        if isinstance(value, RigidBody):
            value = value.masscenter
        elif isinstance(value, Particle):
            value = value.point
        if not isinstance(value, Point | Vector):
            return value
        if self.frame is None or (isinstance(value, Point) and self.origin is None):
            raise InputError(
                f"{where}: got {value}, need the axes and the origin of its components. "
                "Fix: frame=N, origin=O."
            )
        vector = value.pos_from(self.origin) if isinstance(value, Point) else value
        parts = tuple(vector.to_matrix(self.frame))
        return parts if self.in_space else parts[:2]


def _contact(
    name: str, given: Mapping[str, Any], system: LagrangianSystem, table: _Table, space: _Space
) -> Contact:
    """Return a contact by the arguments of `Contact` or of one of its functions."""
    where = f"mechanism {system.name!r}: contact {name!r}"
    values: dict[str, Any] = {}
    for key, value in given.items():
        own = space.components(value, where)
        if isinstance(own, tuple | list):
            own = tuple(table.formula(f"contact {name!r}: {key}", part) for part in own)
        elif not (isinstance(own, bool) or (callable(own) and not isinstance(own, sp.Basic))):
            own = table.formula(f"contact {name!r}: {key}", own)
        values[key] = own
    make: Any = Contact.in_space if space.in_space else Contact.of_point
    if "gap" in values:
        make = Contact
    elif "radius" in values:
        make = Contact.of_disc
    try:
        contact: Contact = make(name, system, **values)
    except TypeError as error:
        need = ", ".join(list(signature(make).parameters)[2:])
        raise InputError(f"{where}: got {', '.join(values)}, need some of {need}.") from error
    return contact
