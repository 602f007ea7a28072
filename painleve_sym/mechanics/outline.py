"""A mechanism without its formulas: names, units and defaults, with which a run is read."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

from painleve_sym.checks import LARGEST, checked_values, named_state, text_of
from painleve_sym.contact_rows import ContactRows
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.mechanics.declarations import (
    TIME_NAME,
    Coordinate,
    DomainBound,
    Parameter,
    ParameterSet,
    Velocity,
)
from painleve_sym.mechanics.quaternions import Quaternion, quaternions_of, velocities_of

if TYPE_CHECKING:
    from painleve_sym.mechanics.bodies import NaturalPeriod
    from painleve_sym.mechanics.contact import Contact
    from painleve_sym.mechanics.system import LagrangianSystem


SIDES = {"push": 1, "pull": -1}
"""Sides of a guide: the sign of its normal force."""
KINDS = ("unilateral", "bilateral")
"""Of contacts that can open, and of those that hold from both sides."""


@dataclass(frozen=True)
class ContactOutline:
    """A `Contact` without its formulas, whose texts `gap` and `slip_velocity` are to be shown.

    `friction` is the name of the parameter μ, or that of the coefficient of which `friction_curve`
    is the formula, empty where it is a parameter; `static_friction` is the formula of μ_s, empty
    where it is that of slip at v_t = 0. `gap_coordinate` and `slip_rate` are the coordinate
    that is the gap and the velocity that is the slip velocity, empty where none is.
    `depends_on_time` tells whether the time itself occurs in one of both formulas. `slip_across` is
    the text of the second slip velocity of a contact in space, empty in the plane.
    """

    name: str
    bilateral: bool = False
    friction: str = "mu"
    gap: str = "0"
    slip_velocity: str = ""
    gap_coordinate: str = ""
    slip_rate: str = ""
    depends_on_time: bool = False
    slip_across: str = ""
    friction_curve: str = ""
    static_friction: str = ""

    @property
    def has_one_coefficient(self) -> bool:
        """Whether its friction is a parameter, the same at rest and in slip."""
        return not (self.friction_curve or self.static_friction)

    @property
    def sides(self) -> tuple[int, ...]:
        """Signs that its normal force may have."""
        return (1, -1) if self.bilateral else (1,)


@dataclass(frozen=True)
class BoundOutline:
    """A `DomainBound` as text, with the names that occur in it."""

    margin: str
    meaning: str
    names: tuple[str, ...]
    near: float = 0.0


@dataclass(frozen=True)
class PeriodOutline:
    """A `NaturalPeriod` as text; `of_material` where it needs the material of the run."""

    body: str
    mode: str
    formula: str
    modelled: bool
    of_material: bool


@dataclass(frozen=True)
class MechanismOutline:
    """Names, units and defaults of a mechanism, without its formulas.

    `timed` says whether the time itself occurs in the energies, the forces or the domain; `periods`
    are the natural periods of its bodies, where they are known. `pulsed` says whether a formula of
    the motion has a pulse.
    """

    coordinates: tuple[Coordinate, ...]
    parameters: tuple[Parameter, ...]
    contacts: tuple[ContactOutline, ...]
    domain: tuple[BoundOutline, ...]
    timed: bool
    periods: tuple[PeriodOutline, ...] = ()
    pulsed: bool = False

    def __repr__(self) -> str:
        """Return the names in one line."""
        groups = (self.coordinates, self.parameters, self.contacts)
        c, p, contacts = (", ".join(own.name for own in group) for group in groups)
        return f"MechanismOutline: coordinates {c}; parameters {p}; contacts {contacts}"

    @cached_property
    def bilateral(self) -> tuple[bool, ...]:
        """Whether each contact holds from both sides."""
        return tuple(c.bilateral for c in self.contacts)

    @property
    def has_curves(self) -> bool:
        """Whether the friction of any contact is a formula, not a parameter."""
        return any(c.friction_curve for c in self.contacts)

    @property
    def truncation_notices(self) -> tuple[str, ...]:
        """Sentences on bodies with modes, whose rigid contact problem does not converge in them."""
        return tuple(
            f"Body {name} has finitely many modes. On a rigid contact its thresholds of friction "
            "do not converge as modes are added, since the contact moves more easily with each; a "
            "body with all its modes has no paradox of accelerations. Fix: judge it on a compliant "
            "contact, as the page 'When does a real bar jam?' does."
            for name in dict.fromkeys(p.body for p in self.periods if p.modelled)
        )

    @property
    def speed_jump_notices(self) -> tuple[str, ...]:
        """Sentences on contacts whose surface has a speed that jumps at known times."""
        return tuple(
            f"Contact {c.name}: the speed of its surface jumps at the edges of pulses, where steps "
            "end. A rigid contact that is closed there has an impact, opens, or begins to slip."
            for c in self.contacts
            if any(self._pulses.search(f) for f in (c.gap, c.slip_velocity, c.slip_across))
        )

    @property
    def _pulses(self) -> re.Pattern[str]:
        """Pulses in the text of a formula, or the parameters that hold their values in a run."""
        held = [p.name for p in self.parameters if p.meaning.startswith("value of ")]
        names = "|".join(map(re.escape, held)) or "(?!)"
        return re.compile(rf"\b(pulse|cycles)\(|\b({names})\b")

    @classmethod
    def of(
        cls,
        system: LagrangianSystem,
        contacts: Sequence[Contact],
        domain: Sequence[DomainBound],
        periods: Sequence[NaturalPeriod],
    ) -> MechanismOutline:
        """Return the outline of a mechanism."""
        from sympy import sympify

        from painleve_sym.mechanics.bodies import MODULUS
        from painleve_sym.mechanics.pulses import pulse

        def timed(*formulas: Any) -> bool:
            return any(t in sympify(f).free_symbols for t in system.clock for f in formulas)

        outlines = tuple(
            ContactOutline(
                name=c.name,
                bilateral=c.bilateral,
                friction=str(c.mu),
                gap=str(c.gap),
                slip_velocity=str(c.slip_velocity),
                gap_coordinate=str(c.gap) if c.gap in system.q else "",
                slip_rate=str(c.slip_velocity) if c.slip_velocity in system.q_dot else "",
                depends_on_time=timed(c.gap, *c.slip_velocities),
                slip_across="" if c.slip_across is None else str(c.slip_across),
                friction_curve="" if c.mu == c.friction else str(c.friction),
                static_friction="" if c.static_friction is None else str(c.static_friction),
            )
            for c in contacts
        )
        bounds = tuple(
            BoundOutline(
                str(b.margin), b.meaning, tuple(sorted(map(str, b.margin.free_symbols))), b.near
            )
            for b in domain
        )
        formulas = [system.kinetic_energy, system.potential_energy]
        formulas += [*system.generalized_forces.values(), *(b.margin for b in domain)]
        known = tuple(
            PeriodOutline(n.body, n.mode, str(n.period), n.modelled, n.period.has(MODULUS))
            for n in periods
        )
        declared = system.coordinates, system.parameters
        every = [*formulas, *(f for c in contacts for f in (c.gap, *c.slip_velocities))]
        pulsed = any(sympify(f).has(pulse) for f in every)
        return cls(*declared, outlines, bounds, timed(*formulas), known, pulsed)

    def only(self, where: str, *names: str) -> MechanismOutline:
        """Return the outline with some contacts; InputError suggests the nearest name."""
        known = [c.name for c in self.contacts]
        for name in names:
            refuse_unknown("contact", text_of(name, where), known, where)
        return replace(self, contacts=tuple(c for c in self.contacts if c.name in names))

    def state(self, where: str, given: object) -> dict[str, float]:
        """Return every coordinate and velocity, and ``t`` where it occurs; 0 if it is not given.

        A quaternion of which nothing is given turns nothing, and one within `UNIT_WITHIN` of unit
        norm is scaled to it.

        A text is a number with a unit, such as ``30 deg``. `where` begins messages.

        Raises
        ------
        InputError
            Unknown names, values that are not finite, all at once; a quaternion that is not of
            unit norm.
        """
        zeros = self._at_rest
        if type(given) is dict:
            # A check of all at once; where it fails, each is looked at.
            whole = {**zeros, **given}
            if len(whole) == len(zeros) and all(
                type(v) is float and abs(v) <= LARGEST for v in given.values()
            ):
                return self.with_unit_quaternions(where, cast(dict[str, float], whole), given)
        named = self.named_state(where, given)
        values = checked_values(where, "state", named, zeros, self.state_units.__getitem__)
        return self.with_unit_quaternions(where, values, named)

    def named_state(self, where: str, given: object) -> dict[str, Any]:
        """Return the values that are given, by name; see `checks.named_state`."""
        return named_state(given, self.state_names, where)

    def part_fault(self, name: str) -> str:
        """Return why a part of a quaternion cannot vary by itself; empty for other names."""
        for quaternion in self.quaternions:
            if name in (c.name for c in quaternion.coordinates):
                return f"{name} is a part of the quaternion {quaternion.name}, whose norm stays 1."
        return ""

    def with_unit_quaternions(
        self, where: str, values: dict[str, float], given: Mapping[str, Any]
    ) -> dict[str, float]:
        """Return the values of states with every quaternion scaled to unit norm.

        `given` tells which were given: see `Quaternion.scaled`. `where` begins messages.

        Raises
        ------
        InputError
            A quaternion whose norm differs from 1 by more than `UNIT_WITHIN`.
        """
        for quaternion in self.quaternions:
            parts, fault = quaternion.scaled(values, given)
            if fault:
                raise InputError(f"{where}: {fault}")
            values = values | parts
        return values

    @cached_property
    def _at_rest(self) -> dict[str, float]:
        return dict.fromkeys(self.state_names, 0.0)

    @cached_property
    def declared(self) -> ParameterSet:
        """The parameters, to be given values."""
        return ParameterSet(*self.parameters)

    @cached_property
    def state_units(self) -> dict[str, str]:
        """SI unit of every state by name: those of `state_names`."""
        units = {c.name: c.unit for c in self.coordinates}
        units |= {v.name: v.unit for v in self.velocities}
        return units | ({TIME_NAME: "s"} if self.depends_on_time else {})

    @property
    def n_tangents(self) -> int:
        """Number of tangents of each contact: 1 in the plane, 2 in space."""
        return 2 if self.contacts[0].slip_across else 1

    @property
    def in_space(self) -> bool:
        """Whether its contacts have two tangents."""
        return self.n_tangents > 1

    @cached_property
    def rows(self) -> ContactRows:
        """Places of the rows of its contacts."""
        return ContactRows(len(self.contacts), self.n_tangents)

    @property
    def depends_on_time(self) -> bool:
        """Whether the time itself occurs in any formula: something moves as prescribed."""
        return self.timed or any(c.depends_on_time for c in self.contacts)

    @cached_property
    def velocity_names(self) -> tuple[str, ...]:
        """Names of the velocities."""
        return tuple(v.name for v in self.velocities)

    @cached_property
    def velocities(self) -> tuple[Velocity, ...]:
        """The velocities, in the order of the coordinates; three of a quaternion."""
        return velocities_of(self.coordinates)

    @cached_property
    def quaternions(self) -> tuple[Quaternion, ...]:
        """The quaternions among the coordinates."""
        return quaternions_of(self.coordinates)

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Names of coordinates and velocities, and of the time where anything depends on it."""
        clock = (TIME_NAME,) if self.depends_on_time else ()
        return (*(c.name for c in self.coordinates), *self.velocity_names, *clock)

    @cached_property
    def argument_names(self) -> tuple[str, ...]:
        """Names of all that numbers of the mechanism depend on: states, then parameters."""
        return (*self.state_names, *(p.name for p in self.parameters))
