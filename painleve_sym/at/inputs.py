"""The door of every computation at a state: from what a user gives to a checked `Place`."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from painleve_sym.at.closing import closed_state
from painleve_sym.at.delassus import ContactNumbers, Delassus, domain_margins
from painleve_sym.checks import LARGEST, StateLike
from painleve_sym.codegen.named_mechanisms import MechanismLike, as_mechanism
from painleve_sym.contact_rows import axis_names
from painleve_sym.errors import InputError
from painleve_sym.mechanics.mechanism import Mechanism, Place
from painleve_sym.problem.rounding import MOVED, rounded
from painleve_sym.units import Value

_EXTREME = 1e-50
"""Size of a number, or of its inverse, whose products may be no numbers."""
_SINGULAR = 1e-12
"""Part of the largest singular value of W below which another one is 0."""
_REACHED = 1e-9
"""Part of a velocity within which it is reached."""


def place_of(
    mechanism: MechanismLike,
    state: StateLike | None = None,
    parameters: Mapping[str, Value] | None = None,
    close: str | None = None,
    contact_velocity: Sequence[float] | None = None,
    **checks: Any,
) -> Place:
    """Return a checked place; `close` and `contact_velocity` are solved for where they are given.

    Parameters are those of `Mechanism.at`, `closed_state` and `moving_place`. The domain is not
    looked at (see `inside`).

    Raises
    ------
    InputError
        Unknown names, numbers out of range, nothing that closes the contact.
    """
    place = as_mechanism(mechanism).at(state, parameters, **checks)
    place = place if close is None else closed_place(place, close)
    return place if contact_velocity is None else moving_place(place, contact_velocity)


def closed_place(place: Place, close: str) -> Place:
    """Return the place with a contact closed; see `closed_state`."""
    state = closed_state(place.mechanism, place.state, place.parameters, close)
    solved = tuple(n for n, v in state.items() if v != place.state[n])
    return replace(place, state=state, given=(*place.given, *solved))


def moving_place(place: Place, velocity: Sequence[float]) -> Place:
    """Return the place with velocities that give its only contact a velocity.

    The change Δu of the velocities is that of an impulse at the contact, which has the least
    kinetic energy ½ Δu·M Δu of all.

    Parameters
    ----------
    place : Place
    velocity : sequence of float, shape (2,) or in space (3,)
        Along n and t, in space along n, t1, t2; m/s.

    Raises
    ------
    InputError
        Not as many finite numbers; a velocity that the contact cannot have here.
    """
    mechanism = place.mechanism
    mechanism.require_one_contact()
    where, rows = (
        f"contact velocity of {mechanism.name!r}",
        axis_names(mechanism.outline.n_tangents),
    )
    try:
        wanted = np.array([float(v) for v in velocity])
    except (TypeError, ValueError):
        wanted = np.empty(0)
    if wanted.shape != (len(rows),) or not (np.abs(wanted) <= LARGEST).all():
        raise InputError(
            f"{where}: got {velocity!r}, need {len(rows)} finite numbers along {', '.join(rows)}, "
            "in m/s."
        )
    names, state = mechanism.outline.velocity_names, dict(place.state)
    of = Delassus.of(mechanism)
    for _ in range(3):  # the first change finds it, others take its rounding away
        numbers, moves = of.whole_at({**state, **place.parameters})
        W = (numbers.W + numbers.W.T) / 2
        impulse = np.linalg.lstsq(W, wanted - numbers.v, rcond=_SINGULAR)[0]
        old = np.array([state[n] for n in names])
        new, sizes = old + moves.D @ impulse, np.abs(old) + np.abs(moves.D) @ np.abs(impulse)
        new = rounded(new, sizes, MOVED)
        state |= dict(zip(names, new.tolist(), strict=True))
    reached = of.at({**state, **place.parameters}).v
    scale = max(float(np.abs(wanted).max()), float(np.abs(reached).max()))
    nearest = [float(f"{v:.6g}") if abs(v) > _REACHED * scale else 0.0 for v in reached]
    if not (np.abs(reached - wanted) <= _REACHED * scale).all():
        raise InputError(
            f"{where}: got {wanted.tolist()} m/s, which the contact cannot have here: the nearest "
            f"is {nearest} m/s. Fix: give one in which it can move."
        )
    return replace(place, state=state, given=tuple(dict.fromkeys((*place.given, *names))))


def inside(place: Place) -> Place:
    """Return the place; InputError where it is outside the domain of its mechanism."""
    mechanism = place.mechanism
    if mechanism.outline.domain:
        values = place.values
        point = [values[name] for name in mechanism.outline.argument_names]
        refuse_outside(place, domain_margins(mechanism).of_vector(point))
    return place


def border_notices(place: Place) -> tuple[str, ...]:
    """Return a sentence for each border of the domain near which W and b lose digits: gimbal lock.

    The mass matrix of three angles is singular there, and W, which is not, is computed with it.
    """
    bounds = place.mechanism.outline.domain
    if not any(bound.near for bound in bounds):
        return ()
    point = [place.values[name] for name in place.mechanism.outline.argument_names]
    margins = domain_margins(place.mechanism).of_vector(point)
    notices = []
    for bound, margin in zip(bounds, margins, strict=True):
        if 0 < margin < bound.near:
            received = ", ".join(f"{n} = {place.values[n]!r}" for n in bound.names)
            notices.append(
                f"At {received}, no more than about {digits_left(float(margin))} digits of W and b "
                f"are certain, since {bound.margin} is near 0 ({bound.meaning})."
            )
    return tuple(notices)


def digits_left(margin: float) -> int:
    """Return how many digits a number has that is computed with a margin, which has no unit."""
    return max(0, math.floor(math.log10(margin / sys.float_info.epsilon)))


def refuse_outside(place: Place, margins: Sequence[float]) -> None:
    """Raise InputError where a margin is not positive: of the domain, in space of the mass too."""
    bounds = place.mechanism.outline.domain
    broken = [b for b, margin in zip(bounds, margins, strict=False) if not margin > 0]
    if not broken:
        if len(margins) > len(bounds) and not margins[-1] > 0:
            raise InputError(_singular_mass(place))
        return
    faults = []
    for bound in broken:
        received = ", ".join(f"{n} = {place.values[n]!r}" for n in bound.names)
        faults.append(
            f"got {received}, need {bound.margin} > 0 ({bound.meaning})."
            f"{_in_degrees(place, bound.names)}"
        )
    names = {name for bound in broken for name in bound.names}
    if absent := sorted((names & set(place.state)) - set(place.given)):
        faults.append(f"Fix: give {', '.join(absent)} too; what is not given is 0.")
    raise InputError(f"state of {place.mechanism.name!r}: {' '.join(faults)}")


def _singular_mass(place: Place) -> str:
    """Return a sentence on a place in space where some velocities have no kinetic energy."""
    from painleve_sym.codegen.evaluate import numbers

    system, values = place.mechanism.system, place.values
    mass = numbers([*system.mass_matrix], values).reshape(len(system.q_dot), -1)
    units = [v.unit for v in system.velocities]
    scale = [max(mass[k, k] for k, u in enumerate(units) if u == unit) for unit in units]
    root = np.sqrt(np.where(np.array(scale) > 0, scale, 1.0))
    least, ways = np.linalg.eigh(mass / np.outer(root, root))
    part = abs(ways[:, 0])
    idle = [v.name for v, p in zip(system.velocities, part, strict=True) if p > part.max() / 1e3]
    occurring = {str(s) for s in system.mass_matrix.free_symbols}
    angles = {c.name for c in system.coordinates if c.unit == "rad"} & occurring
    received = ", ".join(f"{n} = {v!r}" for n, v in values.items() if n in (angles or occurring))
    front = f"state of {place.mechanism.name!r}: got {received}, where "
    who = f"{idle[0]} has" if len(idle) == 1 else f"{' and '.join(idle)} together have"
    if least[0] < -1e-9:
        return f"{front}{who} negative kinetic energy. Fix: check masses and moments of inertia."
    return (
        f"{front}{who} no kinetic energy, so that the mass matrix is singular, as in gimbal lock. "
        "Fix: give another state, turn the body about other axes, or orient it by a quaternion."
    )


def refuse_place(place: Place, at: ContactNumbers) -> None:
    """Raise InputError as `refuse_outside`, and where a contact in space has no tangents."""
    refuse_outside(place, at.margins)
    if not place.mechanism.outline.in_space:
        return
    for i, contact in enumerate(place.mechanism.outline.contacts):
        if np.isfinite([at.gap[i], at.gap_rate[i], *at.slip_velocity[i]]).all():
            continue
        if math.isfinite(at.gap[i]):
            fault, fix = "'along' is normal to its surface", "another 'along', "
        else:
            fault, fix = "the normal of its surface vanishes", ""
        parts = place.mechanism.contacts[i]
        occurring = {str(s) for f in (parts.gap, *parts.slip_velocities) for s in f.free_symbols}
        known = occurring - set(place.mechanism.outline.velocity_names)
        received = ", ".join(f"{n} = {v:g}" for n, v in place.values.items() if n in known)
        raise InputError(
            f"state of {place.mechanism.name!r}: contact {contact.name!r} has no tangents here: "
            f"{fault}; got {received}. Fix: give {fix}another state or other parameters."
        )


def refuse_infinite(mechanism: Mechanism, values: Mapping[str, float], at: ContactNumbers) -> None:
    """Raise InputError where W or b of contacts are not numbers, as of a mass of 1e-310 kg."""
    if math.isfinite(sum(at.W.ravel().tolist()) + sum(at.b.tolist())):
        return
    if np.isfinite(at.W).all() and np.isfinite(at.b).all():
        return
    extreme = [n for n, v in values.items() if v and not _EXTREME < abs(v) < 1 / _EXTREME]
    received = ", ".join(f"{n} = {values[n]!r}" for n in extreme or values)
    raise InputError(
        f"state of {mechanism.name!r}: got {received}, where the mobility of the contact or its "
        "acceleration without contact forces is not a finite number. Fix: give another state, or "
        "parameters nearer to 1 where they are that small or large."
    )


def _in_degrees(place: Place, names: Sequence[str]) -> str:
    """Return a sentence where an angle is of the size of degrees."""
    units, state = place.mechanism.state_units, place.state
    for name in names:
        if units.get(name) == "rad" and 2 * math.pi < abs(value := state[name]) <= 360:
            shown = f"{name}={value:g}deg is {name}={math.radians(value):.6g}"
            return f" Fix: angles are in rad; {shown}."
    return ""
