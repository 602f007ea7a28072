"""Events of a motion that add energy to it: impacts, and reloads under the virgin rule."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.contact_rows import ContactRows
from painleve_sym.engines.records import EventRecords
from painleve_sym.equality import Compared
from painleve_sym.errors import EventKind
from painleve_sym.motion.records import EventRecord, MotionNames
from painleve_sym.problem.impact.energy_gain import gain_notice, gains

GAINING = (EventKind.IMPACT, EventKind.RELOAD)
"""Kinds of events that may add energy."""
_CONTINUES = (EventKind.IMPACT_SLIP_STOP, EventKind.IMPACT_MAX_COMPRESSION, EventKind.IMPACT_END)
"""Events of one contact's impact after its beginning."""
_ROUNDING = 1e-15
"""Of the largest kinetic energy at an event: bodies all but at rest gain less than that."""
_IMPACT_SENTENCES = 3
"""Impacts with a sentence of their own."""


@dataclass(frozen=True, eq=False)
class EnergyGain(Compared):
    """An impact or a reload that adds energy, by the law of restitution or the reload rule `law`.

    The gain of an impact is the growth of the kinetic energy but for the work of drives; that of a
    reload the stored energy that appears without work; J. `kinetic_energy` is that before the
    event, J, `time` in s.
    """

    time: float
    kind: EventKind
    contacts: tuple[str, ...]
    gain: float
    kinetic_energy: float
    law: str


def energy_gains(
    rows: EventRecords,
    events: Sequence[EventRecord],
    kinetic: tuple[Array, Array],
    names: MotionNames,
) -> tuple[EnergyGain, ...]:
    """Return the events that add energy, in order.

    `events` are the n `rows` with names; `kinetic` is the energy before and after each of them,
    shape (n,) each; J.
    """
    before, after = kinetic
    lost, driven = (_around(rows, names, f"{n}_dissipation") for n in ("contact", "force"))
    rounding = _ROUNDING * max(before, default=0.0)
    every: list[EnergyGain] = []
    for k, event in enumerate(events):
        last = _end_of_impact(events, k)
        if event.kind is EventKind.IMPACT:
            gain = after[last] - before[k] + driven[1][last] - driven[0][k]
            law = names.choices.get("restitution", "")
        elif event.kind is EventKind.RELOAD:
            gain = lost[0][k] - lost[1][k]
            law = names.choices.get("reload", names.choices.get(f"reload_{event.contact}", ""))
        else:
            continue
        if gain > rounding and gains(gain, max(before[k], after[last])):
            contacts = _contacts(event, names.contacts)
            own = float(gain), float(before[k])
            every.append(EnergyGain(event.time, event.kind, contacts, *own, law))
    return tuple(every)


def _around(rows: EventRecords, names: MotionNames, state: str) -> tuple[Array, Array]:
    """Return a state before and after each event, each of shape (n,); 0 where there is none."""
    if state not in names.states:
        return np.zeros(len(rows.time)), np.zeros(len(rows.time))
    i = names.states.index(state)
    return rows.state_before[:, i], rows.state_after[:, i]


def _end_of_impact(events: Sequence[EventRecord], k: int) -> int:
    """Return the index of the last event of the impact that begins with event k."""
    while k + 1 < len(events) and events[k + 1].kind in _CONTINUES:
        k += 1
    return k


def _contacts(event: EventRecord, names: Sequence[str]) -> tuple[str, ...]:
    """Return the contact of an event, or all contacts that an impact pushes."""
    if event.contact:
        return (event.contact,)
    at = ContactRows(len(names))
    pairs = zip(names, event.impulses[at.normals], event.impulses[at.tangentials], strict=False)
    return tuple(name for name, normal, tangential in pairs if normal or tangential)


def notices(every: Sequence[EnergyGain]) -> tuple[str, ...]:
    """Return warnings on energy that a motion gained, in whole sentences."""
    impacts = [g for g in every if g.kind is EventKind.IMPACT]
    reloads = [g for g in every if g.kind is EventKind.RELOAD]
    first, rest = impacts[:_IMPACT_SENTENCES], impacts[_IMPACT_SENTENCES:]
    sentences = [gain_notice(g.gain, g.kinetic_energy, g.law, g.contacts, g.time) for g in first]
    if rest:
        sentences.append(f"{len(rest)} more impacts add {sum(g.gain for g in rest):.3g} J in all.")
    if reloads:
        total, rule = sum(g.gain for g in reloads), reloads[0].law
        count = "1 reload creates" if len(reloads) == 1 else f"{len(reloads)} reloads create"
        sentences.append(
            f"{count} {total:.3g} J by the reload rule {rule}, which is thermodynamically "
            "inadmissible; the energy balance has it as negative contact dissipation."
        )
    return tuple(sentences)
