"""A mechanism: a Lagrangian system with its frictional contacts and the domain it is valid in."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from painleve_sym.checks import StateLike
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, NotPlanar, refuse_faulty, repeated, unknown_name
from painleve_sym.hooks import upper
from painleve_sym.mechanics.declarations import (
    NOT_DERIVED_FROM,
    TIME_NAME,
    DomainBound,
    Parameter,
    ParameterSet,
    with_defaults,
    with_fields,
)
from painleve_sym.mechanics.deferred import Deferred
from painleve_sym.mechanics.outline import MechanismOutline
from painleve_sym.notebooks import Shown
from painleve_sym.quantities import derivative_latex, symbol_latex
from painleve_sym.units import Value

if TYPE_CHECKING:
    from sympy import Expr, Symbol

    from painleve_sym.mechanics.bodies import NaturalPeriod
    from painleve_sym.mechanics.coefficients import ContactCoefficients
    from painleve_sym.mechanics.contact import Contact
    from painleve_sym.mechanics.shapes import Shape
    from painleve_sym.mechanics.solved import SolvedMotion
    from painleve_sym.mechanics.system import LagrangianSystem


@dataclass(frozen=True, eq=False)
class Place(Compared):
    """A state of a mechanism with the values of all parameters: names and numbers are checked.

    Attributes
    ----------
    mechanism : Mechanism
    state : dict of str to float
        Every coordinate and velocity, and ``t`` where it occurs; SI units, rad.
    parameters : dict of str to float
        Every parameter of the mechanism, and of laws where they were asked for.
    given : tuple of str
        Names of the states that were given; the others are 0.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> place = ps.models.rod().at({"theta": 1.0}, {"mu": 1.5})
    >>> place.state["theta"], place.state["y_A"], place.parameters["mu"]
    (1.0, 0.0, 1.5)
    """

    mechanism: Mechanism
    state: dict[str, float]
    parameters: dict[str, float]
    given: tuple[str, ...]

    @property
    def values(self) -> dict[str, float]:
        """State and parameters in one mapping."""
        return {**self.state, **self.parameters}


@dataclass(frozen=True, repr=False)
class Mechanism(Shown, Deferred):
    """A Lagrangian system with its contacts and the domain it is valid in.

    Attributes
    ----------
    name, title, source : str
    system : LagrangianSystem
    contacts : tuple of Contact
    domain : tuple of DomainBound
    sketch : str
        A few lines of text showing the mechanism and its signs.
    start : mapping of str to float
        A state to begin with: in contact and sliding at the parameters' defaults; absent
        coordinates and velocities, and the time ``t`` where it occurs, are 0.
    shapes : tuple of Shape
        With which it is drawn; where there are none, `shapes_of` suggests some.

    Raises
    ------
    ModelError
        Lists every fault: no contact, contacts of one name or of another system, undeclared
        symbols in the domain or the shapes, unknown names in the start.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> rod = ps.models.rod()
    >>> rod
    Mechanism 'rod': coordinates x_A, y_A, theta; contact A
    >>> [c.name for c in rod.system.coordinates], [c.name for c in rod.contacts]
    (['x_A', 'y_A', 'theta'], ['A'])
    >>> rod.coefficients.A()
    (3*(-mu*sin(theta) + cos(theta))*cos(theta) + 1)/m
    """

    _INNER = ("deferred", "require_one_contact", "require_planar")

    name: str
    title: str
    source: str
    system: LagrangianSystem
    contacts: tuple[Contact, ...]
    domain: tuple[DomainBound, ...] = field(default_factory=tuple)
    sketch: str = field(default_factory=str)
    start: Mapping[str, float] = field(default_factory=dict)
    shapes: tuple[Shape, ...] = field(
        default_factory=tuple, compare=False, metadata=NOT_DERIVED_FROM
    )

    def __post_init__(self) -> None:
        refuse_faulty(f"mechanism {self.name!r}", self._faults())
        own = (bound for c in self.contacts for bound in c.friction_bounds)
        bounds = tuple(bound for bound in own if bound not in self.domain)
        object.__setattr__(self, "domain", (*self.domain, *bounds))
        # Where the start was checked, the outline was made without these bounds.
        self.__dict__.pop("outline", None)

    @classmethod
    def from_sympy(
        cls,
        equations: Any,
        contacts: Mapping[str, Mapping[str, Any]],
        parameters: Mapping[Any, float | Parameter],
        **options: Any,
    ) -> Mechanism:
        """Return the mechanism of equations of motion that SymPy or a person has derived.

        Parameters
        ----------
        equations : LagrangesMethod, KanesMethod, or (M, h)
            Of `sympy.physics.mechanics` without constraints; or M and h of M q̈ = h + Jᵀ F, in
            functions of the time and their derivatives. Speeds of Kane are replaced by
            rates of coordinates.
        contacts : mapping of str to mapping
            By the contact's name the arguments of `Contact.of_point`, `Contact.of_disc` (with
            ``radius``), `Contact.in_space` (where `in_space`) or `Contact` (with ``gap``). Points
            and vectors of `sympy.physics.vector` have their components along `frame`; a particle
            stands for its point, a rigid body for its mass centre.
        parameters : mapping of sympy.Symbol to float or Parameter
            Default of every constant, by its symbol or name. A `Parameter` has its unit and range,
            too.
        coordinates : sequence of dynamicsymbols
            Of a pair (M, h), in its order.
        units : mapping of str to str
            SI units of coordinates and parameters by name, "1" where none is given.
        frame, origin : ReferenceFrame, Point
            Of points and vectors: the axes x, y (and z) of the ground.
        in_space : bool
            Whether the contacts are in space.
        potential_energy : sympy.Expr
            Of Kane's equations and of a pair: where it is given, the energy balance has it in place
            of the work of its forces.
        name, title, source : str

        Raises
        ------
        InputError
            Constraint equations, constants without a value, coordinates that do not depend on the
            time, contacts without their arguments.
        ModelError
            See `LagrangianSystem` and `Contact`.

        Examples
        --------
        >>> import sympy as sp
        >>> import painleve_sym as ps
        >>> from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols
        >>> x, y = dynamicsymbols("x y")
        >>> m, g, mu = sp.symbols("m g mu")
        >>> t = dynamicsymbols._t
        >>> L = m * (x.diff(t) ** 2 + y.diff(t) ** 2) / 2 - m * g * y
        >>> block = ps.Mechanism.from_sympy(
        ...     LagrangesMethod(L, [x, y]),
        ...     {"A": {"point": (x, y), "friction": mu}},
        ...     {m: 2.0, g: 9.8, mu: 0.5},
        ... )
        >>> block.coefficients.W_nn, block.coefficients.B
        (1/m, -g)
        """
        mechanism: Mechanism = upper("mechanism_from_sympy")(
            equations, contacts, parameters, **options
        )
        return mechanism

    def __repr__(self) -> str:
        """Return name, coordinates and contacts."""
        coordinates = ", ".join(c.name for c in self.outline.coordinates)
        names = ", ".join(c.name for c in self.outline.contacts)
        several = "s" * (len(self.outline.contacts) > 1)
        return f"Mechanism {self.name!r}: coordinates {coordinates}; contact{several} {names}"

    def __hash__(self) -> int:
        """Return a hash of the names, which are known without deriving anything."""
        outline = self.outline
        names = (c.name for group in (outline.coordinates, outline.contacts) for c in group)
        return hash((self.name, self.title, self.source, *names))

    def __getstate__(self) -> dict[str, object]:
        """Pickle the definition too: in another process the cache is asked by the same text."""
        with suppress(TypeError):
            _ = self.definition
        return self.__dict__

    def _faults(self) -> Iterator[str]:
        if not self.contacts:
            yield "it has no contact; need at least one."
        different = {id(c): c.name for c in self.contacts}
        for name in repeated(different.values()):
            yield f"contact {name!r} is declared twice. Fix: give each its own name."
        if len({c.n_tangents for c in self.contacts}) > 1:
            yield "it has contacts in the plane and in space. Fix: make all of them by in_space."
        if self.system.quaternions and any(c.n_tangents == 1 for c in self.contacts):
            yield "it has a quaternion and a contact in the plane. Fix: make contacts by in_space."
        for contact in self.contacts:
            if contact.system is not self.system:
                yield f"contact {contact.name!r} belongs to another system. Fix: give it this one."
        for i, bound in enumerate(self.domain, 1):
            yield from self.system.formula_faults(f"domain {i}", bound.margin)
        for i, shape in enumerate(self.shapes, 1):
            for value in (v for point in shape.points for v in point):
                yield from self.system.formula_faults(f"shape {i}", value)
                if getattr(value, "free_symbols", set()) & set(self.system.q_dot):
                    yield f"shape {i} depends on a velocity; need coordinates and time alone."
        for name in self.start:
            if name not in self.state_names:
                yield "start: " + unknown_name("state", name, self.state_names)
        for quaternion in self.system.quaternions:
            parts = {c.name: self.start.get(c.name, 0.0) for c in quaternion.coordinates}
            if fault := quaternion.scaled(parts, self.start)[1]:
                yield f"start: {fault}"

    @cached_property
    def outline(self) -> MechanismOutline:
        """Names, units and defaults, known without deriving anything."""
        return MechanismOutline.of(self.system, self.contacts, self.domain, self.natural_periods)

    @property
    def contact(self) -> Contact:
        """The only contact; InputError when there are several."""
        self.require_one_contact()
        return self.contacts[0]

    def require_one_contact(self) -> None:
        """Raise InputError when there are several contacts."""
        names = [c.name for c in self.outline.contacts]
        if len(names) != 1:
            raise InputError(
                f"mechanism {self.name!r}: got {len(names)} contacts, need one here. "
                f"Fix: choose one of {', '.join(map(repr, names))} (--contact, Mechanism.only); "
                "the others stay open."
            )

    def require_planar(self) -> None:
        """Raise NotPlanar where contacts have two tangents."""
        if self.outline.in_space:
            raise NotPlanar(
                f"mechanism {self.name!r}: got contacts in space, need contacts in the plane. "
                "Fix: give a planar mechanism."
            )

    def require_opening(self, where: str, fix: str) -> None:
        """Raise InputError where the only contact is bilateral; `where` begins the message."""
        contact = self.outline.contacts[0]
        if contact.bilateral:
            raise InputError(
                f"{where}: contact {contact.name!r} is bilateral, need one that can open. "
                f"Fix: {fix}."
            )

    def require_one_coefficient(self, where: str, fix: str) -> None:
        """Raise InputError where friction differs between rest and slip; `where` begins it."""
        for contact in self.outline.contacts:
            if not contact.has_one_coefficient:
                own = contact.friction_curve or contact.friction
                rest = contact.static_friction or own
                raise InputError(
                    f"{where}: contact {contact.name!r} has the friction {own} in slip and {rest} "
                    f"at rest, need one coefficient, a parameter. Fix: {fix}."
                )

    def only(self, *names: str) -> Mechanism:
        """Return the mechanism with the named contacts, as if the others were out of reach."""
        outline = self.outline.only(f"mechanism {self.name!r}", *names)

        def make() -> Mechanism:
            from painleve_sym.mechanics.shapes import suggested_shapes

            own = tuple(c for c in self.contacts if c.name in names)
            shapes = self.shapes
            if not (shapes or self.outline.in_space):
                geometries = [c.geometry for c in self.contacts if c.geometry is not None]
                shapes = suggested_shapes(self.system, geometries)
            return replace(self, contacts=own, shapes=shapes)

        return self._deferred(make, outline, f"{self.definition} contact {' '.join(names)} alone")

    def _deferred(
        self, make: Callable[[], Mechanism], outline: MechanismOutline, definition: str
    ) -> Mechanism:
        texts = {name: getattr(self, name) for name in ("name", "title", "source", "sketch")}
        if "drawing_definition" in vars(self):
            texts["drawing_definition"] = self.drawing_definition
        return Mechanism.deferred(
            make, start=self.start, outline=outline, definition=definition, **texts
        )

    def with_parameters(self, **values: Value) -> Mechanism:
        """Return the mechanism with other defaults of its parameters; nothing is derived again.

        Parameters
        ----------
        **values : float
            By the parameter's name, in its unit.

        Raises
        ------
        InputError
            Unknown names, values out of range.

        Examples
        --------
        >>> from painleve_sym import models
        >>> rough = models.rod(mu=1.5)
        >>> rough.with_parameters(mu=1.2).parameters["mu"]
        1.2
        """
        where = f"mechanism {self.name!r}"
        parameters = with_defaults(where, self.outline.parameters, values)
        outline = replace(self.outline, parameters=parameters)
        if "system" in self.__dict__:
            return with_fields(self._with_defaults(parameters), outline=outline)
        make = partial(self._with_defaults, parameters)
        return self._deferred(make, outline, self.definition)

    def _with_defaults(self, parameters: tuple[Parameter, ...]) -> Mechanism:
        system = with_fields(self.system, parameters=parameters)
        contacts = tuple(with_fields(c, system=system) for c in self.contacts)
        return with_fields(self, system=system, contacts=contacts)

    def at(
        self,
        state: StateLike | None = None,
        parameters: Mapping[str, Value] | None = None,
        *,
        declared: ParameterSet | None = None,
        where: str = "",
    ) -> Place:
        """Return a state with parameters, all names and numbers checked; the domain is not.

        Parameters
        ----------
        state : mapping of str to (float or str), Series, or array_like, optional
            Coordinates and velocities by name or symbol, those absent are 0; SI units, rad. Or a
            number for each of `state_names`, in their order. The mechanism's `start` where no state
            is given.
        parameters : mapping of str to (float or str), optional
            Those absent have their defaults.
        declared : ParameterSet, optional
            What may be given, where it is more than the parameters of the mechanism.
        where : str
            Begins messages on parameters.

        Raises
        ------
        InputError
            Unknown names, values that are not finite or out of range.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> place = ps.models.rod().at({"theta": 1.0}, {"mu": 0.5})
        >>> place.state["y_A"], place.parameters["mu"]
        (0.0, 0.5)
        """
        outline, of_state = self.outline, f"state of {self.name!r}"
        given = self.start if state is None else outline.named_state(of_state, state)
        known = outline.declared if declared is None else declared
        values = known.values(where or repr(self.name), parameters)
        return Place(self, outline.state(of_state, given), values, tuple(given))

    def casadi(self, quantity: str) -> Any:
        """Return a quantity of the mechanism as a CasADi function of its state and parameters.

        Parameters
        ----------
        quantity : str
            Of n contacts with the rows n1, t1, n2, t2, … (in space n1, t1, t1', n2, …): ``W``,
            shape (rows, rows), 1/kg, and ``b``, shape (rows,), m/s²; of each contact ``gap``,
            ``gap_rate``, ``slip_velocity``, ``A_stick`` and ``B_stick``, and while it slides ``A``,
            1/kg, ``B``, m/s², and ``mu_P``, the friction coefficient from which A < 0 for some
            direction of slip. Of the mechanism ``M``, ``h``, ``T`` and ``V`` in
            M q̈ = h + Jᵀ F; a robot, which has no formulas, lacks these.

        Returns
        -------
        casadi.Function
            Its inputs are ``state``, in the order of `state_names`, and ``parameters``, in the
            order of `parameters`.

        Raises
        ------
        InputError
            An unknown quantity.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> rod = ps.models.rod()
        >>> W = rod.casadi("W")
        >>> W.name_in(), W.size_out("W")
        (['state', 'parameters'], (2, 2))
        >>> place = rod.at({"theta": 1.0, "x_A_dot": -1.0})
        >>> A = rod.casadi("A")([*place.state.values()], [*place.parameters.values()])
        >>> round(float(A), 6)
        -0.033745
        """
        return upper("quantity_function")(self, quantity)

    @property
    def notices(self) -> tuple[str, ...]:
        """Sentences on effects outside its rigid contact problem, such as modes of its bodies."""
        return self.outline.truncation_notices + self.outline.speed_jump_notices

    @property
    def parameters(self) -> dict[str, float]:
        """Default of every parameter by name, in its unit."""
        return {p.name: p.default for p in self.outline.parameters}

    @property
    def natural_periods(self) -> tuple[NaturalPeriod, ...]:
        """Natural periods of the bodies as formulas, those that depend on parameters alone."""
        from painleve_sym.mechanics.bodies import DENSITY, MODULUS

        known = {p.symbol for p in self.system.parameters} | {DENSITY, MODULUS}
        periods = [p for body in self.system.bodies for p in body.natural_periods]
        return tuple(p for p in periods if p.period.free_symbols <= known)

    @cached_property
    def coefficients(self) -> ContactCoefficients:
        """Coefficients of the only contact, in the plane."""
        self.require_one_contact()
        return self.all_coefficients[0]

    @cached_property
    def all_coefficients(self) -> tuple[ContactCoefficients, ...]:
        """Coefficients of every contact, each as if the others were open; in the plane."""
        self.require_planar()
        from painleve_sym.mechanics.coefficients import ContactCoefficients

        return tuple(ContactCoefficients(c) for c in self.contacts)

    @cached_property
    def _solved_motion(self) -> SolvedMotion | None:
        """Accelerations solved for step by step, where closed forms of them would be long."""
        self.require_planar()
        from painleve_sym.mechanics.solved import SolvedMotion, is_solved

        return SolvedMotion(self) if is_solved(self) else None

    @cached_property
    def drive_speeds(self) -> tuple[Expr, ...]:
        """Speeds of the surfaces, n1, t1, n2, t2, …; see `ContactCoefficients.drive_speeds`."""
        return tuple(v for c in self.all_coefficients for v in c.drive_speeds)

    @cached_property
    def locked(self) -> bool:
        """Whether its only contact is bilateral and, with W of rank one, holds the slip as well."""
        held = self.outline.bilateral == (True,) and not self._solved_motion
        return held and self.coefficients.A_stick == 0

    @cached_property
    def definition(self) -> str:
        """The hash of everything its derivations start from (`definition_text`)."""
        from painleve_sym.mechanics.definition import definition_hash

        return definition_hash(self)

    @cached_property
    def drawing_definition(self) -> str:
        """The hash of what it is drawn with besides `definition`: bodies, shapes and contacts."""
        from painleve_sym.mechanics.definition import definition_hash

        geometries = [c.geometry for c in self.contacts]
        return definition_hash((self.shapes, self.system.bodies, geometries))

    @property
    def depends_on_time(self) -> bool:
        """Whether the time itself occurs in any formula: something moves as prescribed."""
        return self.outline.depends_on_time

    @property
    def motion(self) -> tuple[Symbol, ...]:
        """Symbols of a state: coordinates, velocities, and `TIME` where anything depends on it."""
        from painleve_sym.mechanics.system import TIME

        clock = (TIME,) if self.depends_on_time else ()
        return (*self.system.q, *self.system.q_dot, *clock)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names a state may use, in the order of an array: coordinates, velocities, then ``t``.

        ``t`` is there where the time itself occurs in a formula.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> rod = ps.models.rod()
        >>> rod.state_names
        ('x_A', 'y_A', 'theta', 'x_A_dot', 'y_A_dot', 'theta_dot')
        >>> rod.at([0, 0, 1, -1, 0, 1]).state["theta"]
        1.0
        """
        return self.outline.state_names

    @cached_property
    def symbols(self) -> dict[str, Symbol]:
        """Symbol of every state and parameter by name, as formulas of the mechanism have it.

        They are real, so that ``expr.subs({"theta": 1})``, whose text SymPy reads as another
        symbol, replaces nothing.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> rod = ps.models.rod()
        >>> gap = rod.contact.gap
        >>> gap, gap.subs({"y_A": 2}), gap.subs({rod.symbols["y_A"]: 2})
        (y_A, y_A, 2)
        """
        own = (*self.motion, *(p.symbol for p in self.system.parameters))
        return {symbol.name: symbol for symbol in own}

    @property
    def state_units(self) -> dict[str, str]:
        """SI unit of every state by name: those of `state_names`."""
        return self.outline.state_units

    @cached_property
    def units(self) -> dict[str, str]:
        """SI unit of every state and parameter by name."""
        return self.state_units | {p.name: p.unit for p in self.outline.parameters}

    @cached_property
    def latex_names(self) -> dict[str, str]:
        """LaTeX of every state and parameter by name."""
        names = {c.name: c.latex or symbol_latex(c.name) for c in self.outline.coordinates}
        names |= {
            v.name: derivative_latex(names[v.row]) if v.row in names else symbol_latex(v.name)
            for v in self.outline.velocities
        }
        names |= {TIME_NAME: TIME_NAME} if self.depends_on_time else {}
        return names | {p.name: symbol_latex(p.name) for p in self.outline.parameters}
