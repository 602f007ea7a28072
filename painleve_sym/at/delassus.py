"""The numbers of contacts at states: gaps, velocities, mobility W, free accelerations b, scales.

Everything that needs them asks `Delassus`, which asks a `Dynamics` for one function of them all.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.at.sticking import sticking_expressions
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contact_rows import ContactRows
from painleve_sym.mechanics.closed_within import closed_within, length_formula
from painleve_sym.mechanics.declarations import with_fields
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.outline import MechanismOutline

if TYPE_CHECKING:
    import casadi as ca


Shapes = tuple[tuple[int, ...], ...]

_MOTION = ("gap", "gap_rate", "slip_velocity")
_OF_CONTACT = (*_MOTION, "A_stick", "B_stick", "gap_tolerance", "rate_tolerance")


class ContactNumbers(NamedTuple):
    """Numbers of all n contacts of a mechanism at one state, or at an array of states.

    For an array of states each array ends with the axes of that array.

    Attributes
    ----------
    gap, gap_rate : ndarray, shape (n,)
        m, m/s.
    slip_velocity : ndarray, shape (n,), in space (n, 2)
        m/s.
    A_stick, B_stick : ndarray, shape (n,)
        A′ and B′ of each contact with the others open; 1/kg and m/s².
    gap_tolerance, rate_tolerance : ndarray, shape (n,)
        See `closed_within`; m, m/s.
    W : ndarray, shape (2 n, 2 n), in space (3 n, 3 n)
        Mobility with the rows of `ContactRows`: n1, t1, n2, t2, ...; 1/kg.
    b : ndarray, shape (2 n,), in space (3 n,)
        Accelerations without contact forces; m/s².
    margins : sequence of float, or ndarray
        Of the bounds of the domain, all positive inside; of a mechanism in space one more, positive
        where its mass matrix is regular.
    mu : ndarray, shape (n,)
        Friction coefficients.
    """

    gap: Array
    gap_rate: Array
    slip_velocity: Array
    A_stick: Array
    B_stick: Array
    gap_tolerance: Array
    rate_tolerance: Array
    W: Array
    b: Array
    margins: Any
    mu: Array

    def of_contacts(self, contacts: Sequence[int]) -> ContactNumbers:
        """Return the numbers of some contacts, the others open."""
        n = len(self.gap)
        if len(contacts) == n:
            return self
        rows = ContactRows(n, len(self.b) // n - 1).of_contacts(contacts)
        own = {name: getattr(self, name)[contacts] for name in (*_OF_CONTACT, "mu")}
        return self._replace(**own, W=self.W[np.ix_(rows, rows)], b=self.b[rows])

    @property
    def v(self) -> Array:
        """Velocities of the contacts, as many as rows; m/s."""
        n, rows = len(self.gap_rate), len(self.b)
        slip = self.slip_velocity.reshape(n, rows // n - 1, *self.gap_rate.shape[1:])
        velocities = np.concatenate([self.gap_rate[:, None], slip], axis=1)
        return velocities.reshape(rows, *velocities.shape[2:])


class MotionNumbers(NamedTuple):
    """Effect of contact impulses on a mechanism of nu velocities, at one state or several.

    Attributes
    ----------
    J : ndarray, shape (2 n, nu)
        Velocities of the contacts by those of the mechanism.
    D : ndarray, shape (nu, 2 n)
        M⁻¹ Jᵀ: velocities of the mechanism by the impulses.
    free : ndarray, shape (nu,)
        Accelerations of the mechanism without contact forces.
    drive_speeds : ndarray, shape (2 n,)
        Of the surfaces; m/s.
    kinetic_energy : ndarray, shape (1,)
        J.
    """

    J: Array
    D: Array
    free: Array
    drive_speeds: Array
    kinetic_energy: Array


class Dynamics(Protocol):
    """Names and numerical functions of a mechanism, as `Delassus` needs them.

    `LagrangianDynamics` has closed forms of SymPy. CasADi functions of a mass matrix, a bias, and
    gaps, Jacobians and bias accelerations of contacts serve as well.
    """

    @property
    def outline(self) -> MechanismOutline:
        """Names of states, parameters and contacts."""
        ...

    @property
    def definition(self) -> str:
        """Everything that the functions are made of, as one text."""
        ...

    @property
    def n_tangents(self) -> int:
        """Tangential directions of a contact: 1 in the plane, 2 in space."""
        ...

    @property
    def n_margins(self) -> int:
        """Number of `ContactNumbers.margins`."""
        ...

    def contact_function(self) -> ca.Function:
        """Return the function of `argument_names` to all `ContactNumbers` but mu, row by row."""
        ...

    def motion_function(self) -> ca.Function:
        """Return the function of `argument_names` to all `MotionNumbers`, row by row."""
        ...


@dataclass(frozen=True)
class LagrangianDynamics:
    """A `Dynamics` from the closed forms of a mechanism's Lagrangian system."""

    mechanism: Mechanism

    @property
    def outline(self) -> MechanismOutline:
        """Names of states, parameters and contacts."""
        return self.mechanism.outline

    @property
    def definition(self) -> str:
        """Everything that the mechanism is derived from."""
        return self.mechanism.definition

    @property
    def n_tangents(self) -> int:
        """Tangential directions of a contact."""
        return self.outline.n_tangents

    @property
    def n_margins(self) -> int:
        """One for each bound of the domain."""
        return len(self.outline.domain)

    def contact_function(self) -> ca.Function:
        """Return the function of all `ContactNumbers` but mu."""
        from painleve_sym.codegen.evaluate import expression_function
        from painleve_sym.mechanics.contact_set import ContactSet

        mechanism = self.mechanism
        n = len(mechanism.contacts)
        own = [_formulas(mechanism, i) for i in range(n)]
        between = ContactSet(mechanism)
        entries = [own[i][name] for name in _OF_CONTACT for i in range(n)]
        at, axis = ContactRows(n), ("t", "n")
        kinds = [axis[at.is_normal(row)] for row in range(at.size)]
        for r, c in itertools.product(range(at.size), repeat=2):
            low, high = min(r, c), max(r, c)
            alone = own[at.contact(low)]
            coupled = at.contact(r) != at.contact(c)
            entries.append(
                between.W[low, high] if coupled else alone[f"W_{kinds[low]}{kinds[high]}"]
            )
        entries += [own[at.contact(r)][f"b_{kind}"] for r, kind in enumerate(kinds)]
        entries += [bound.margin for bound in mechanism.domain]
        return expression_function("contacts", entries, argument_symbols(mechanism))

    def motion_function(self) -> ca.Function:
        """Return the function of all `MotionNumbers`."""
        from painleve_sym.codegen.evaluate import expression_function
        from painleve_sym.mechanics.contact_set import ContactSet

        mechanism, system = self.mechanism, self.mechanism.system
        contacts = ContactSet(mechanism)
        directions = [d for c in mechanism.all_coefficients for d in c.force_directions]
        entries = [*contacts.J]
        entries += [column[k] for k in range(len(system.q)) for column in directions]
        entries += [*system.free_acceleration, *mechanism.drive_speeds, system.kinetic_energy]
        return expression_function("motion", entries, argument_symbols(mechanism))


class FactorizedDynamics(LagrangianDynamics):
    """The same of a mechanism in space, whose mass matrix is factorized in the function itself."""

    @property
    def n_margins(self) -> int:
        """One for each bound of the domain, and one for the mass matrix."""
        return len(self.outline.domain) + 1

    def contact_function(self) -> ca.Function:
        """Return the function of all `ContactNumbers` but mu."""
        from painleve_sym.at.spatial_numbers import contact_function

        return contact_function(self.mechanism, argument_symbols(self.mechanism))

    def motion_function(self) -> ca.Function:
        """Return the function of all `MotionNumbers`."""
        from painleve_sym.at.spatial_numbers import motion_function

        return motion_function(self.mechanism, argument_symbols(self.mechanism))


@dataclass(frozen=True)
class Delassus:
    """The numbers of the contacts of a mechanism, compiled once and evaluated at states.

    Where it does not compile, CasADi evaluates them: sooner the first time, slower each time.

    The values are coordinates, velocities and parameters by name, and may hold others: numbers for
    one state, or arrays that broadcast against each other for an array of states, each with the
    same bits as alone.

    Examples
    --------
    >>> from painleve_sym import model
    >>> from painleve_sym.at.delassus import Delassus
    >>> rod = model("rod")
    >>> numbers = Delassus.of(rod).at({**rod.at(rod.start).values, "theta": 1.0})
    >>> numbers.W.shape, numbers.b.shape
    ((2, 2), (2,))
    """

    dynamics: Dynamics
    compiles: bool = True

    @staticmethod
    def of(mechanism: Mechanism) -> Delassus:
        """Return that of a mechanism: its own where it has no formulas, else by closed forms."""
        if isinstance(mechanism, NumericalMechanism):
            return mechanism.numbers
        dynamics = FactorizedDynamics if mechanism.outline.in_space else LagrangianDynamics
        return Delassus(dynamics(mechanism))

    def at(self, values: Mapping[str, float]) -> ContactNumbers:
        """Return the numbers of the contacts at one state."""
        function = self.contact_quantities
        numbers = function.of_vector([values[name] for name in function.arguments])
        return self._contacts(numbers, values)[0]

    def whole_at(self, values: Mapping[str, Any]) -> tuple[ContactNumbers, MotionNumbers]:
        """Return the numbers of the contacts at one state, and how impulses move the mechanism."""
        function = self.whole_quantities
        numbers = function.of_vector([values[name] for name in function.arguments])
        contacts, moves = self._contacts(numbers, values, self._motion_shapes)
        return contacts, MotionNumbers(*moves)

    def at_each(self, values: Mapping[str, Any]) -> ContactNumbers:
        """Return the numbers of the contacts at an array of states."""
        return self._at_each(self.contact_quantities, values, ())[0]

    def whole_at_each(self, values: Mapping[str, Any]) -> tuple[ContactNumbers, MotionNumbers]:
        """Return the same as `whole_at` at an array of states."""
        contacts, moves = self._at_each(self.whole_quantities, values, self._motion_shapes)
        return contacts, MotionNumbers(*moves)

    def _contacts(
        self, numbers: list[float], values: Mapping[str, Any], more: Shapes = ()
    ) -> tuple[ContactNumbers, list[Array]]:
        """Return the numbers at one state, and parts of the shapes `more` after them."""
        shapes = self._contact_shapes
        parts = _in_shapes(np.array(numbers), shapes + more)
        begin, end = _ends(shapes)[-2:]
        count, mu = len(shapes), self._friction(values)
        own: Any = (*parts[: count - 1], numbers[begin:end], mu)
        return ContactNumbers(*own), parts[count:]

    def _friction(self, values: Mapping[str, float]) -> Array:
        """Return the friction coefficient of each contact at one state."""
        outline = self.dynamics.outline
        if not outline.has_curves:
            return np.array([float(values[c.friction]) for c in outline.contacts])
        function = self.friction_quantities
        return np.array(function.of_vector([values[name] for name in function.arguments]))

    def friction_at_rest(self, values: Mapping[str, Any]) -> Array | None:
        """Return the coefficients up to which contacts stick at an array of states, shape (n, ...).

        None where each contact has one coefficient, that of slip.
        """
        dynamics = self.dynamics
        if all(c.has_one_coefficient for c in dynamics.outline.contacts):
            return None
        assert isinstance(dynamics, LagrangianDynamics)
        mechanism, names = dynamics.mechanism, dynamics.outline.argument_names

        def derive() -> tuple[dict[str, Any], Sequence[Any]]:
            own = {c.name: c.friction_curve.at_rest for c in mechanism.contacts}
            return own, argument_symbols(mechanism)

        definition = dynamics.definition
        function = quantities("friction at rest", definition, names, derive, compiles=self.compiles)
        arrays = np.broadcast_arrays(*(np.asarray(values[n], float) for n in names))
        flat = {n: a.reshape(-1) for n, a in zip(names, arrays, strict=True)}
        return function.rows(flat).reshape(-1, *arrays[0].shape)

    def _at_each(
        self, function: Quantities, values: Mapping[str, Any], more: Shapes
    ) -> tuple[ContactNumbers, list[Array]]:
        """Return the numbers at an array of states, and parts of the shapes `more` after them."""
        outline = self.dynamics.outline
        arrays = np.broadcast_arrays(*(np.asarray(values[n], float) for n in function.arguments))
        axes, count = arrays[0].shape, len(self._contact_shapes)
        flat = {n: a.reshape(-1) for n, a in zip(function.arguments, arrays, strict=True)}
        parts = _in_shapes(function.rows(flat), (*self._contact_shapes, *more), axes)
        if outline.has_curves:
            mu = self.friction_quantities.rows(flat).reshape(-1, *axes)
        else:
            given = (np.asarray(values[c.friction], float) for c in outline.contacts)
            mu = np.stack([np.broadcast_to(number, axes) for number in given])
        own: Any = (*parts[:count], mu)
        return ContactNumbers(*own), parts[count:]

    @property
    def array_names(self) -> tuple[str, ...]:
        """Names of `arrays`."""
        return (*_OF_CONTACT, "W", "b")

    def arrays(self, values: Mapping[str, ca.SX]) -> dict[str, ca.SX]:
        """Return the arrays of `ContactNumbers` but mu and margins, as CasADi formulas.

        The values are those of all arguments. An array of one axis is a column.
        """
        import casadi as ca

        function, arrays, end = self.contact_quantities, dict[str, ca.SX](), 0
        entries = function.function(ca.vertcat(*(values[name] for name in function.arguments)))
        for name, shape in zip(self.array_names, self._contact_shapes, strict=False):
            rows, columns = (*shape, 1)[:2]
            first, end = end, end + rows * columns
            arrays[name] = ca.reshape(entries[first:end], columns, rows).T
        return arrays

    def friction_of(self, values: Mapping[str, ca.SX]) -> list[ca.SX]:
        """Return the friction coefficients as CasADi formulas of all arguments."""
        import casadi as ca

        outline = self.dynamics.outline
        if not outline.has_curves:
            return [values[contact.friction] for contact in outline.contacts]
        function = self.friction_quantities
        own = function.function(ca.vertcat(*(values[name] for name in function.arguments)))
        return list(ca.vertsplit(own))

    @property
    def _contact_shapes(self) -> Shapes:
        dynamics = self.dynamics
        n, tangents = len(dynamics.outline.contacts), dynamics.n_tangents
        return _contact_shapes(n, tangents, dynamics.n_margins)

    @property
    def _motion_shapes(self) -> Shapes:
        outline = self.dynamics.outline
        return _motion_shapes(
            len(outline.contacts), self.dynamics.n_tangents, len(outline.velocities)
        )

    @property
    def contact_quantities(self) -> Quantities:
        """All `ContactNumbers` but mu, row by row."""
        outline, definition = self.dynamics.outline, self.dynamics.definition
        return quantities(
            "contacts",
            definition,
            outline.argument_names,
            lambda: (self._contact_names, self.dynamics.contact_function()),
            compiles=self.compiles,
        )

    @property
    def friction_quantities(self) -> Quantities:
        """The coefficient of friction of each contact at its slip velocity, where one varies."""
        dynamics = self.dynamics
        assert isinstance(dynamics, LagrangianDynamics)
        mechanism, outline = dynamics.mechanism, dynamics.outline

        def derive() -> tuple[dict[str, Any], Sequence[Any]]:
            own = {c.name: c.friction_curve.in_slip(c.slip_speed) for c in mechanism.contacts}
            return own, argument_symbols(mechanism)

        names, definition = outline.argument_names, dynamics.definition
        return quantities("friction", definition, names, derive, compiles=self.compiles)

    @property
    def whole_quantities(self) -> Quantities:
        """All `ContactNumbers` but mu, followed by all `MotionNumbers`."""
        outline, definition = self.dynamics.outline, self.dynamics.definition

        def derive() -> tuple[list[str], ca.Function]:
            import casadi as ca

            x = ca.SX.sym("x", len(outline.argument_names))
            parts = self.dynamics.contact_function()(x), self.dynamics.motion_function()(x)
            whole = ca.Function("whole", [x], ca.cse([ca.vertcat(*parts)]))
            moves = _entry_names(MotionNumbers._fields, self._motion_shapes)
            return self._contact_names + moves, whole

        names = outline.argument_names
        return quantities("whole", definition, names, derive, compiles=self.compiles)

    @property
    def _contact_names(self) -> list[str]:
        names = (*_OF_CONTACT, "W", "b", "margin")
        return _entry_names(names, self._contact_shapes)


@dataclass(frozen=True, repr=False, eq=False)
class NumericalMechanism(Mechanism):
    """A mechanism without formulas: names, and the numbers of its contacts.

    Made by `deferred`, whose `make` raises an error.

    Attributes
    ----------
    numbers : Delassus
    """

    numbers: Delassus = field(kw_only=True)

    def __eq__(self, other: object) -> bool:
        """Whether it is the same object, since it has no formulas to compare."""
        return self is other

    __hash__ = object.__hash__

    def _deferred(
        self, make: Callable[[], Mechanism], outline: MechanismOutline, definition: str
    ) -> Mechanism:
        return with_fields(self, outline=outline, definition=definition)


# The same few for all states of a mechanism.
@functools.lru_cache(maxsize=256)
def _contact_shapes(n: int, tangents: int, margins: int) -> Shapes:
    """Return the shapes of all `ContactNumbers` but mu."""
    size = ContactRows(n, tangents).size
    slip = (n,) if tangents == 1 else (n, tangents)
    own = [slip if name == "slip_velocity" else (n,) for name in _OF_CONTACT]
    return *own, (size, size), (size,), (margins,)


@functools.lru_cache(maxsize=256)
def _motion_shapes(n: int, tangents: int, nu: int) -> Shapes:
    """Return the shapes of all `MotionNumbers`."""
    size = ContactRows(n, tangents).size
    return (size, nu), (nu, size), (nu,), (size,), (1,)


@functools.lru_cache(maxsize=256)
def _ends(shapes: Shapes) -> list[int]:
    """Return where the entries of arrays of these shapes end, one after the other."""
    return list(itertools.accumulate(map(math.prod, shapes)))


def _in_shapes(numbers: Array, shapes: Shapes, axes: tuple[int, ...] = ()) -> list[Array]:
    """Return arrays of these shapes from their entries, one after the other; `axes` end each."""
    parts, first = list[Array](), 0
    flat = numbers.ndim
    for shape, end in zip(shapes, _ends(shapes), strict=True):
        part = numbers[first:end]
        parts.append(part if flat == len(shape) == 1 else part.reshape(*shape, *axes))
        first = end
    return parts


def _entry_names(names: Sequence[str], shapes: Shapes) -> list[str]:
    """Return a name for each entry of arrays of these shapes, row by row."""
    return [
        "_".join((name, *map(str, place)))
        for name, shape in zip(names, shapes, strict=True)
        for place in itertools.product(*map(range, shape))
    ]


def domain_margins(mechanism: Mechanism) -> Quantities:
    """Return margin_0, margin_1, … of the bounds of the domain, all positive inside.

    Functions of coordinates, velocities and parameters.
    """
    return quantities(
        "domain",
        mechanism.definition,
        mechanism.outline.argument_names,
        lambda: (
            {f"margin_{i}": bound.margin for i, bound in enumerate(mechanism.domain)},
            argument_symbols(mechanism),
        ),
    )


def argument_symbols(mechanism: Mechanism) -> tuple[Any, ...]:
    """Return the arguments of a mechanism's functions as symbols: states, then parameters."""
    return (*mechanism.motion, *(p.symbol for p in mechanism.system.parameters))


def _formulas(mechanism: Mechanism, i: int) -> dict[str, Any]:
    system, contact, c = mechanism.system, mechanism.contacts[i], mechanism.all_coefficients[i]
    forces = ("W_nn", "W_nt", "W_tt", "b_n", "b_t")
    formulas = {name: getattr(contact, name) for name in _MOTION}
    formulas |= {name: getattr(c, name) for name in forces}
    formulas["A_stick"], formulas["B_stick"] = sticking_expressions(c)
    given = length_formula(mechanism, i), system.kinetic_energy, c.W_nn, c.b_n
    _, near, slow = closed_within(*given)
    return formulas | {"gap_tolerance": near, "rate_tolerance": slow}
