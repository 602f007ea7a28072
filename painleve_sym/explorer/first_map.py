"""The map that a page shows first: axes over which something happens."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from painleve_sym.at.delassus import Delassus
from painleve_sym.contact_rows import ContactRows
from painleve_sym.errors import InputError, PainleveWarning
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.problem.case_codes import LEGEND
from painleve_sym.study.maps.region_map import region_map

POINTS = 41
"""Along each axis of a map that is tried."""
SHARE = 0.01
"""Least part of a map that counts as a region."""
ROUNDING = 1e-9
"""Part of its terms below which A or B is zero."""
ENOUGH = 3
"""Regions with which the search ends at once."""


@dataclass(frozen=True)
class FirstMap:
    """The contact of a map, the ranges of its axes, across then up, and its number of regions."""

    contact: int
    ranges: Mapping[str, tuple[float, float]]
    regions: int


def first_map(mechanism: Mechanism, slips: Sequence[int]) -> FirstMap:
    """Return the map over which most happens, contacts slipping along `slips`, -1 or 1.

    Over an angle with its rate or with the friction, of the first contact if that has two cases;
    else over other quantities, and of other contacts.
    """
    best = FirstMap(0, {}, 0)
    # A start on the border of two cases says nothing of either: such contacts come last.
    for contact, slip in sorted(enumerate(slips), key=lambda own: _on_border(mechanism, *own)):
        friction = _friction_axis(mechanism, contact)
        for pairs in _pairs(mechanism, friction):
            for over in pairs:
                tried = _tried(mechanism, contact, slip, over)
                best = max(best, tried, key=lambda own: own.regions)
                if best.regions >= ENOUGH:
                    return best
            if best.regions >= 2:
                return best
    if best.regions == 0:
        where = f"explorer of {mechanism.name!r}"
        raise InputError(f"{where}: none of its maps has a point inside the domain.")
    return best


def _on_border(mechanism: Mechanism, contact: int, slip: int) -> bool:
    """Return whether A or B of a contact alone is zero, to rounding, at the mechanism's start."""
    at = Delassus.of(mechanism).at(mechanism.at(mechanism.start).values)
    rows = ContactRows(len(mechanism.outline.contacts))
    normal, tangent = rows.normal(contact), rows.tangent(contact)
    terms = at.W[normal, normal], slip * at.mu[contact] * at.W[normal, tangent]
    A, B = terms[0] - terms[1], at.b[normal]
    return bool(
        abs(A) <= ROUNDING * max(map(abs, terms)) or abs(B) <= ROUNDING * float(np.abs(at.b).max())
    )


def _tried(mechanism: Mechanism, contact: int, slip: int, over: tuple[str, str]) -> FirstMap:
    contacts = mechanism.outline.contacts
    alone = mechanism if len(contacts) == 1 else mechanism.only(contacts[contact].name)
    held = {n: v for n, v in mechanism.start.items() if n not in over}
    try:
        with warnings.catch_warnings():
            # The map is not shown: its notes are of no use.
            warnings.simplefilter("ignore", PainleveWarning)
            tried = region_map(alone, over, points=POINTS, slip=slip, state=held)
    except InputError:
        # These axes have no map, as where nothing is inside the domain.
        return FirstMap(contact, {}, 0)
    _, counts = np.unique(tried.case[tried.case != LEGEND["outside"]], return_counts=True)
    ranges = [(float(v[0]), float(v[-1])) for v in tried.values]
    regions = int((counts >= SHARE * tried.case.size).sum())
    return FirstMap(contact, dict(zip(over, ranges, strict=True)), regions)


def _friction_axis(mechanism: Mechanism, contact: int) -> str:
    """Return the parameter that is the friction of a contact, or the first one in its formula."""
    outline = mechanism.outline.contacts[contact]
    if not outline.friction_curve:
        return outline.friction
    own = mechanism.contacts[contact].friction_curve.kinetic.free_symbols
    return next(p.name for p in mechanism.outline.parameters if p.symbol in own)


def _pairs(mechanism: Mechanism, friction: str) -> tuple[list[tuple[str, str]], ...]:
    """Return pairs of axes: those of angles, then others."""
    coordinates = mechanism.outline.coordinates
    angles = [c.name for c in coordinates if c.unit == "rad"]
    turned = [p.name for p in mechanism.outline.parameters if p.unit == "rad"]
    others = [*turned, *(f"{c.name}_dot" for c in coordinates), *(c.name for c in coordinates)]
    by_rate = [(name, f"{name}_dot") for name in angles]
    return [*by_rate, *((n, friction) for n in angles)], [(n, friction) for n in others]
