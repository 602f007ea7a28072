"""Named choices a caller makes; each is an enumeration, and its text is accepted as well."""

from __future__ import annotations

import enum
from typing import Literal, TypeAlias, TypeVar

from painleve_sym.errors import InputError, unknown_name


class EngineName(enum.StrEnum):
    """Engine that integrates a motion."""

    AUTO = "auto"
    """The fastest that serves the mechanism: Taylor series, else Runge–Kutta, else ``erk``."""
    COMPILED = "compiled"
    """Runge–Kutta of order 8(5,3) in compiled C."""
    TAYLOR = "taylor"
    """Taylor series in compiled C."""
    ERK = "erk"
    """Runge–Kutta in Python over CasADi, which needs no C compiler."""


class Restitution(enum.StrEnum):
    """Which law of restitution ends a rigid impact."""

    ENERGETIC = "energetic"
    """Stronge: the part e² of the energy of compression comes back."""
    POISSON = "poisson"
    """The part e of the normal impulse of compression comes back."""
    NEWTON = "newton"
    """The part e of the normal velocity comes back; it can add energy."""


class ImpactFriction(enum.StrEnum):
    """Which slip friction opposes in a rigid impact, a choice that rigid bodies leave open."""

    PATH = "path"
    """The slip of each moment, along the path of the impulse: Routh's construction."""
    FINAL_SLIP = "final_slip"
    """The slip after the impact, as in time stepping: Moreau; with Newton's law alone."""


class Policy(enum.StrEnum):
    """Choice of a rigid contact where several motions are possible."""

    LIFTOFF = "liftoff"
    """It opens: what a contact without surface energy does."""
    SLIP = "slip"
    """It slides on."""
    IMPACT = "impact"
    """It has the impact without collision."""


class Reload(enum.StrEnum):
    """Rule of an elasto-plastic contact for compression that grows again before separation."""

    ELASTIC = "elastic"
    """Back up the unloading curve, as in Walton & Braun (1986)."""
    VIRGIN = "virgin"
    """The loading curve at once, with a jump of the force.

    Thermodynamically inadmissible, since the jump creates energy; for the reproduction only."""


class Friction(enum.StrEnum):
    """Friction law of a contact, with μ the friction coefficient of the contact."""

    COULOMB = "coulomb"
    """μ in slip and in stick."""
    STATIC = "static"
    """μ in slip, and a higher static friction that stick must exceed before slip starts."""
    STRIBECK = "stribeck"
    """Static friction where slip starts, which falls to μ as the slip velocity grows."""
    SPRING = "spring"
    """μ in series with a tangential spring: a compliant contact yields along its tangent, too."""


class Record(enum.StrEnum):
    """Extent of the recorded run."""

    DENSE = "dense"
    """Events and every step, so that the state is known at any time."""
    EVENTS = "events"
    """Events and the end."""
    END = "end"
    """The end."""


class Interpolation(enum.StrEnum):
    """Course of a function of time between its values at given times."""

    HELD = "held"
    """Each value until the next one, the last one from then on."""
    LINEAR = "linear"
    """Straight lines."""
    CUBIC = "cubic"
    """A cubic spline with two continuous derivatives, not-a-knot at its ends."""


EngineLike: TypeAlias = EngineName | Literal["auto", "compiled", "taylor", "erk"]
RestitutionLike: TypeAlias = Restitution | Literal["energetic", "poisson", "newton"]
ImpactFrictionLike: TypeAlias = ImpactFriction | Literal["path", "final_slip"]
PolicyLike: TypeAlias = Policy | Literal["liftoff", "slip", "impact"]
ReloadLike: TypeAlias = Reload | Literal["elastic", "virgin"]
FrictionLike: TypeAlias = Friction | Literal["coulomb", "static", "stribeck", "spring"]
RecordLike: TypeAlias = Record | Literal["dense", "events", "end"]
InterpolationLike: TypeAlias = Interpolation | Literal["held", "linear", "cubic"]

_Choice = TypeVar("_Choice", bound=enum.StrEnum)


def chosen(kind: type[_Choice], value: str, meaning: str, where: str = "") -> _Choice:
    """Return the member whose text `value` is; messages name the choice and its place.

    Raises
    ------
    InputError
        Another text; the nearest one is suggested.

    Examples
    --------
    >>> chosen(Policy, "slip", "policy")
    <Policy.SLIP: 'slip'>
    """
    try:
        return kind(value)
    except ValueError:
        place = f"{where}: " if where else ""
        known = [member.value for member in kind]
        raise InputError(place + unknown_name(meaning, str(value), known)) from None
