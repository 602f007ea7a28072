"""The start of a page, with closed contacts that a file's few digits left compressed."""

from __future__ import annotations

from painleve_sym.at.closing import closed_state, gap_slopes
from painleve_sym.at.delassus import Delassus
from painleve_sym.mechanics.mechanism import Mechanism

FEW_DIGITS = 1e-3
"""Part of the largest length of a start below which a compression is rounding of a file."""


def exact_start(mechanism: Mechanism) -> tuple[dict[str, float], list[str]]:
    """Return the mechanism's start with contacts closed that are compressed by rounding.

    A file has few digits, and a rigid contact has no compression. A coordinate closes a contact
    that changes no other gap; the sentences say which values were replaced.
    """
    place = mechanism.at(mechanism.start)
    state, notes = dict(place.state), list[str]()
    at = Delassus.of(mechanism).at(place.values)
    contacts, coordinates = mechanism.outline.contacts, mechanism.outline.coordinates
    slopes = [gap_slopes(mechanism, i).names for i in range(len(contacts))]
    size = max((abs(state[c.name]) for c in coordinates if c.unit == "m"), default=0.0)
    for i, contact in enumerate(contacts):
        if contact.bilateral or not -FEW_DIGITS * size <= at.gap[i] < -at.gap_tolerance[i]:
            continue
        others = {name for k, own in enumerate(slopes) if k != i for name in own}
        # A value of 0 is exact.
        for c in sorted(coordinates, key=lambda own: state[own.name] == 0):
            if f"gap_by_{c.name}" in slopes[i] and f"gap_by_{c.name}" not in others:
                named = f"{contact.name}:{c.name}" if len(contacts) > 1 else c.name
                state = closed_state(mechanism, state, place.parameters, named)
                notes.append(
                    f"{c.name} is {state[c.name]:.9g} {c.unit}, which closes the contact "
                    f"{contact.name}; the mechanism's start has {place.state[c.name]:.9g}."
                )
                break
    return state, notes
