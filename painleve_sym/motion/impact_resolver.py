"""Impacts of rigid contacts for the engine that runs without a compiler."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.contact_rows import ContactRows
from painleve_sym.contacts.terms import ContactImpacts, ImpactResult
from painleve_sym.engines.protocol import REMAINDER, SHRINKING, Answer, Question
from painleve_sym.errors import EventKind, StopReason
from painleve_sym.laws.rigid_contact import RigidLaw

WINDOWS = (1, 2, 3, 5, 8)
"""Numbers of touchdowns whose time, taken together, may shrink from each to the next."""
SETTLED = 1e-9
"""Gap and normal speed at which bounces have died out, in parts of the state's scale.

The speed also in parts of that which the free acceleration gives in the time so far, since a run
that starts all but at rest has a small scale.
"""


@dataclass
class ImpactResolver:
    """Answers the questions of one run without compiled code: the impacts of rigid contacts.

    It repeats the decisions of ``engines/loop/impact.c``, which it serves to check. The law is that
    of all rigid contacts, `target` the mode in which the motion continues, `values` the parameters,
    `scale` that of each state. It collects the times of the touchdowns, s, and per event of the
    answers its impulses.
    """

    impacts: ContactImpacts
    law: RigidLaw
    target: int
    values: dict[str, float]
    scale: Array
    touchdowns: list[float] = field(default_factory=list)
    impulses: list[tuple[float, ...]] = field(default_factory=list)

    def __call__(self, question: Question) -> Answer:
        """Return what follows: the limit of bounces, an impact, or a jam."""
        impacts, contact = self.impacts, self.target
        state = impacts.touching(question.state, self.scale, self.values)
        if impacts.collides(question.state) and not impacts.collides(state):
            # It was rounding of contacts that rest.
            return self._rests(state)
        if self._accumulates(question):
            closed = self._settled(state, question.time)
            if closed is not None:
                return self._rests(closed)
            return Answer(contact, state, stop=StopReason.ACCUMULATION)
        result = self.impact(state)
        if result is None:
            return Answer(contact, state, stop=StopReason.JAM)
        self.impulses.append(tuple(map(float, result.impulses)))
        short = impacts.short_bounces(result.state, self.values, REMAINDER * question.time)
        if short:
            still = self.closed(result.state, short)
            self.impulses.append(())
            ended = (EventKind.IMPACT, result.state, contact)
            return Answer(contact, still, (), (ended, (EventKind.SETTLE, still, contact)))
        return Answer(contact, result.state, (), ((EventKind.IMPACT, result.state, contact),))

    def _rests(self, state: Array) -> Answer:
        self.impulses.append(())
        return Answer(self.target, state, (), ((EventKind.SETTLE, state, self.target),))

    def impact(self, state: Array) -> ImpactResult | None:
        """Return the impact of the closed contacts; None where it jams."""
        # Guides among compliant contacts have no law, and nothing approaches them.
        e = self.values.get(self.law.parameters[0].name, 0.0)
        return self.impacts.impact(state, self.values, self.law.restitution, e)

    def closed(self, state: Array, contacts: Sequence[int]) -> Array:
        """Return the state with contacts closed; see `ContactImpacts.closed`."""
        return self.impacts.closed(state, self.values, contacts)

    def _accumulates(self, question: Question) -> bool:
        if question.kind is not EventKind.TOUCHDOWN:
            return False
        self.touchdowns.append(question.time)
        return accumulates(self.touchdowns)

    def _settled(self, state: Array, time: float) -> Array | None:
        """Return the state with the contacts closed whose bounces have died out; None for none."""
        rigid, at = np.array(self.impacts.rigid), ContactRows(len(self.impacts.rows))
        free = self.impacts.terms(state, self.values).b[at.normals]
        gaps, rates, _ = self.impacts.places[rigid].T
        near = np.abs(state[gaps]) < SETTLED * self.scale[gaps]
        speeds = np.maximum(self.scale[rates], time * np.abs(free[rigid]))
        died = near & (np.abs(state[rates]) < SETTLED * speeds)
        moves = np.any(state[rates[died]] != 0)
        return self.closed(state, rigid[died].tolist()) if moves else None


def accumulates(times: list[float]) -> bool:
    """Return whether touchdowns of several contacts shrink towards a limit that is reached.

    The times, s, are those of all touchdowns so far. One contact's bounces are a geometric series;
    those of several take turns, and only windows of them, taken together, shrink steadily.
    """
    for size in WINDOWS:
        ends = times[-1 : -2 - size * SHRINKING : -size]
        lengths = [a - b for a, b in itertools.pairwise(ends)]
        if len(lengths) < SHRINKING or not all(a < b for a, b in itertools.pairwise(lengths)):
            continue
        ratio = max(lengths[0] / lengths[1], lengths[1] / lengths[2])
        if lengths[0] * ratio / (1 - ratio) < REMAINDER * times[-1]:
            return True
    return False
