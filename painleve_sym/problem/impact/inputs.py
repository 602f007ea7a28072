"""Checks of what impacts are given: mobility, friction, velocities and restitution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from painleve_sym.checks import LARGEST, checked_number, mobility_faults, spatial_mobility_faults
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.laws.restitution import RESTITUTIONS, RestitutionLaw
from painleve_sym.problem.array_checks import mobility_matrix_faults
from painleve_sym.problem.impact.within_plane import in_plane, moving_tangent

_ONE = (
    "numbers, W of shape (2, 2) and velocity (v_n, v_t), or in space W of shape (3, 3) and "
    "velocity (v_n, v_1, v_2)"
)
_SEVERAL = (
    "numbers, for n contacts W of shape (2 n, 2 n), mu of shape (n,) and velocity of shape (2 n,)"
)


class ImpactInputs(NamedTuple):
    """Checked inputs of an impact: rows of a symmetric W, and numbers by contact and row."""

    W: tuple[tuple[float, ...], ...]
    mu: tuple[float, ...]
    velocity: tuple[float, ...]
    law: RestitutionLaw
    e: tuple[float, ...]


def impact_inputs(
    W: Any,
    mu: Any,
    velocity: Any,
    restitution: RestitutionLaw | str,
    e: Any,
    *,
    where: str = "solve impact",
    in_one_plane: bool = True,
    bilateral: Sequence[bool] | None = None,
) -> ImpactInputs:
    """Return the arguments of an impact as floats; raise InputError with every fault.

    Parameters
    ----------
    W, mu, velocity, restitution, e
        As for `solve_impact`, or, where `bilateral` says which hold from both sides, for the
        contacts of `solve_simultaneous_impact`.
    in_one_plane : bool
        Whether a contact in space may move in one plane only.
    """
    several = bilateral is not None
    try:
        rows = [list(map(float, row)) for row in _plain(W)]
        v = tuple(map(float, _plain(velocity)))
        friction = tuple(map(float, _plain(mu))) if several else (float(mu),)
        shares = _shares(e, len(friction)) if several else (float(e),)
        sizes = (2 * len(friction),) if several else (2, 3)
        fits = bilateral is None or len(bilateral) == len(friction) == len(shares)
        if not (fits and rows and len(rows) in sizes) or {len(v), *map(len, rows)} != {len(rows)}:
            raise ValueError
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{where}: got W = {W!r}, mu = {mu!r}, velocity = {velocity!r}, e = {e!r}, need "
            f"{_SEVERAL if several else _ONE}. Fix: check the shapes."
        ) from error
    faults = _number_faults(rows, friction, v, shares, several)
    if not faults:
        faults = _mobility_faults(rows, in_one_plane, several)
    normal_velocities = v[:: len(v) // len(friction)]
    if min(friction) < 0 or max(normal_velocities) > 0 or (bilateral and any(bilateral)):
        faults += _sign_faults(friction, normal_velocities, bilateral)
    if min(shares) < 0 or max(shares) > 1:
        faults.append(f"e: got {e!r}, need 0 <= e <= 1.")
    law = restitution
    if isinstance(law, str):
        law = RESTITUTIONS.get(law, law)
    if not isinstance(law, RestitutionLaw):
        faults.append(unknown_name("restitution law", law, RESTITUTIONS))
    if faults or not isinstance(law, RestitutionLaw):
        raise InputError(f"{where}: " + " ".join(faults))
    return ImpactInputs(_symmetric(rows), friction, v, law, shares)


def _shares(e: Any, contacts: int) -> tuple[float, ...]:
    """Return the coefficient of each contact; a number is that of all."""
    given = tuple(map(float, np.ravel(e).tolist()))
    return given * contacts if np.ndim(e) == 0 else given


def _sign_faults(
    friction: Sequence[float], velocities: Sequence[float], bilateral: Sequence[bool] | None
) -> list[str]:
    """Return a sentence for each friction coefficient and normal velocity of a wrong sign."""
    several, sides = bilateral is not None, bilateral or (False,)
    places = [str(k) for k in range(1, len(friction) + 1)] if several else [""]
    faults = [
        f"mu{'_' * several}{place}: got {m!r}, need mu >= 0."
        for place, m in zip(places, friction, strict=True)
        if m < 0
    ]
    for place, v_n, both in zip(places, velocities, sides, strict=True):
        if both and v_n:
            faults.append(f"v_n{place}: got {v_n!r} m/s, need 0: the contact holds both ways.")
        elif v_n > 0:
            faults.append(f"v_n{place}: got {v_n!r} m/s, need v_n <= 0: the contact is opening.")
    return faults


def _plain(value: Any) -> Any:
    # Floats of an array are cheaper all at once.
    return value.tolist() if isinstance(value, np.ndarray) else value


def _axes(size: int, several: bool) -> Sequence[str]:
    """Return the names of rows."""
    if several:
        return [f"{axis}{k}" for k in range(1, size // 2 + 1) for axis in "nt"]
    return "nt" if size == 2 else "n12"


def _number_faults(
    rows: Sequence[Sequence[float]],
    mu: Sequence[float],
    velocity: Sequence[float],
    e: Sequence[float],
    several: bool,
) -> list[str]:
    """Return a sentence for each number that is not finite or too large."""
    sizes = [*map(abs, chain(*rows, mu, e, velocity))]
    # A sum is nan where any number is.
    if max(sizes) <= LARGEST and math.isfinite(sum(sizes)):
        return []
    axes = _axes(len(rows), several)
    entries = {
        f"W_{a}{b}": w
        for a, row in zip(axes, rows, strict=True)
        for b, w in zip(axes, row, strict=True)
    }
    entries |= {"mu" if axes[0] == "n" else f"mu_{k}": m for k, m in enumerate(mu, 1)}
    shared = e.count(e[0]) == len(e)
    entries |= {"e": e[0]} if shared else {f"e_{k}": own for k, own in enumerate(e, 1)}
    entries |= {f"v_{a}": own for a, own in zip(axes, velocity, strict=True)}
    return [fault for name, number in entries.items() if (fault := checked_number(number, name)[1])]


def _mobility_faults(
    rows: Sequence[Sequence[float]], in_one_plane: bool, several: bool
) -> list[str]:
    """Return a sentence where W is none of a mechanism, or none whose impact has a path."""
    if several and len(rows) > 2:
        return mobility_matrix_faults(np.array(rows), "n1, t1, n2, t2, ...")
    if len(rows) == 2:
        return mobility_faults(*rows[0], *rows[1])
    tangent = moving_tangent(rows) if in_one_plane else None
    if tangent is None:
        return spatial_mobility_faults(rows)
    (nn, nt), (tn, tt) = in_plane(rows, tangent)
    return mobility_faults(nn, nt, tn, tt)


def _symmetric(rows: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], ...]:
    """Return the symmetric part of W, whose rounding may not be symmetric."""
    given, turned = tuple(map(tuple, rows)), tuple(zip(*rows, strict=True))
    if given == turned:
        return given
    return tuple(
        tuple((a + b) / 2 for a, b in zip(row, column, strict=True))
        for row, column in zip(given, turned, strict=True)
    )
