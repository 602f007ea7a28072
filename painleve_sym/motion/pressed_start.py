"""Starts that a state does not determine: contacts with a past, and several solutions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeGuard

from painleve_sym.laws.catalogue import OwnLaw
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.motion.records import EventRecord
from painleve_sym.problem.impact.chatter import REVERSE_CHATTER

RESOLVED = 1e-6
"""Depth over the scale of the gap from which a contact counts as pressed."""


@dataclass(frozen=True)
class PressedStart:
    """A contact with a loading history: its depth at the start, m, and the memory of its law."""

    contact: str
    depth: float
    law: str
    remembers: tuple[str, ...]


def pressed_starts(
    contacts: Iterable[tuple[str, OwnLaw, float, float]],
) -> Iterator[PressedStart]:
    """Yield the contacts that start pressed with a law that remembers.

    Parameters
    ----------
    contacts : iterable of tuple
        Name, law, gap at the start and scale of the gap, m.
    """
    for name, law, gap, scale in contacts:
        if gap < -RESOLVED * scale and has_past(law):  # the latter may derive the law
            yield PressedStart(name, -gap, law.name, law.remembers)


def has_past(law: OwnLaw) -> TypeGuard[ContactLaw]:
    """Return whether the force of a law depends on more than the state."""
    return law.is_compliant and bool(law.remembers)


def batch_past_notices(count: int, motions: int) -> tuple[str, ...]:
    """Return a sentence on `count` motions of a batch with a loading history; none for 0."""
    if not count:
        return ()
    return (
        f"{count:,} of {motions:,} motions start with a contact pressed, not by an initial_force, "
        "and its law depends on the past, which a state does not hold: they begin on the loading "
        "curve, and continue no other motion. Fix: start with open contacts or an initial_force.",
    )


def past_notices(starts: Iterable[PressedStart]) -> tuple[str, ...]:
    """Return a sentence for each contact."""
    return tuple(
        f"Contact {s.contact} starts {s.depth:.3g} m deep, and its force by the law {s.law} "
        f"depends on its past ({', '.join(s.remembers)}), which a state does not hold: this motion "
        "begins on the loading curve, and is not the continuation of another one. Fix: run the "
        "whole motion at once, from a start with open contacts or a given initial_force."
        for s in starts
    )


def several_notices(events: Sequence[EventRecord]) -> tuple[str, ...]:
    """Return a sentence where rigid contacts have several solutions at the start."""
    if not events or events[0].time > 0:
        return ()
    first = events[0]
    names = [name for name in first.alternatives if name != REVERSE_CHATTER]
    if len(names) < 2:
        return ()
    return (
        f"The start has several solutions ({', '.join(names)}), of which the policy of the law "
        f"chooses: this motion goes to {first.mode_after}, and one that came from another state "
        "may not.",
    )
