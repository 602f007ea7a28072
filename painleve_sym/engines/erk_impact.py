"""Impacts of rigid contacts within a run, for the engine `erk`: decisions of ``loop/impact.c``."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.contacts.impact.one_contact import ImpactEnd
from painleve_sym.contacts.impact.simultaneous import solve_simultaneous_impact
from painleve_sym.engines.erk_mode import Call
from painleve_sym.engines.protocol import REMAINDER, SHRINKING
from painleve_sym.hybrid.automaton import Impacts

# The constants of the compiled engine: its decisions are repeated here.
_TOUCHING, _SETTLED, _WINDOWS = 1e-10, 1e-9, (1, 2, 3, 5, 8)


class _Numbers(NamedTuple):
    """Numbers of n contacts at one state, in the order n1, t1, n2, t2, …; see `Impacts`."""

    W: Array
    load: Array
    directions: Array
    mu: Array
    drive_speeds: Array
    e: float


class Striking:
    """What the rigid contacts of an automaton do to its states at an instant.

    Parameters
    ----------
    functions : AutomatonFunctions
    given : Impacts
        Of the automaton.
    """

    def __init__(self, functions: AutomatonFunctions, given: Impacts) -> None:
        self.given, self.target = given, functions.mode_index[given.target]
        self._function = Call(functions.impacts)
        states = functions.automaton.states
        self._rows = np.array([[states.index(s) for s in contact] for contact in given.contacts])
        self._speeds = [states.index(s) for s in given.velocities]
        self._works = [None if s is None else states.index(s) for s in given.works]

    def _numbers(self, x: Array, z: Array, c: Array) -> _Numbers:
        W, load, directions, mu, drive_speeds, e = self._function(x, z, c)
        n = len(load)
        shaped = directions.reshape(n, -1).T
        return _Numbers(W.reshape(n, n).T, load, shaped, mu, drive_speeds, float(e[0]))

    def touching(self, x: Array, scale: Array) -> Array:
        """Return the state with gaps that close at the same instant, but for rounding, as 0."""
        after = x.copy()
        for gap, rate, _ in self._rows[list(self.given.rigid)]:
            if x[rate] <= 0 and abs(x[gap]) <= _TOUCHING * scale[gap]:
                after[gap] = 0.0
        return after

    def settled(self, x: Array, scale: Array) -> list[int]:
        """Return the rigid contacts whose bounces have died out."""
        sizes = np.abs(x) < _SETTLED * scale
        return [i for i in self.given.rigid if sizes[self._rows[i, :2]].all()]

    def short_bounces(self, x: Array, z: Array, c: Array, time: float) -> list[int]:
        """Return the rigid contacts that leave and would be back within `time`; s."""
        falls = -self._numbers(x, z, c).load[::2]
        gaps, rates, _ = x[self._rows].T
        return [
            i
            for i in self.given.rigid
            if gaps[i] <= 0 and rates[i] > 0 and 2 * rates[i] < time * falls[i]
        ]

    def closed(self, x: Array, z: Array, c: Array, contacts: Sequence[int]) -> Array:
        """Return the state with contacts closed: gap and normal velocity 0, by normal impulses.

        Parameters
        ----------
        x, z, c : ndarray
            State, memory, constants.
        contacts : sequence of int
            Contacts whose gap and normal velocity are all but 0.
        """
        numbers, normals = self._numbers(x, z, c), [2 * i for i in contacts]
        arriving = x[self._rows[list(contacts), 1]]
        block = numbers.W[np.ix_(normals, normals)]
        impulses = np.zeros(len(numbers.load))
        impulses[normals] = np.linalg.lstsq(block, -arriving, rcond=1e-12)[0]
        after = self._pushed(x, numbers, impulses)
        after[self._works[0]] -= impulses[normals] @ arriving / 2
        after[self._rows[list(contacts), :2]] = 0.0
        return after

    def impact(self, x: Array, z: Array, c: Array) -> tuple[Array, Array] | None:
        """Return state and memory after the impact of the closed contacts; None where it jams."""
        gaps, rates, _ = x[self._rows].T
        closed = [i for i in self.given.rigid if gaps[i] <= 0 and rates[i] <= 0]
        rows = [r for i in closed for r in (2 * i, 2 * i + 1)]
        numbers, before = self._numbers(x, z, c), x[self._rows[closed, 1:]].ravel()
        W, law = numbers.W[np.ix_(rows, rows)], self.given.restitution
        mu, load = numbers.mu[closed], numbers.load[rows]
        impact = solve_simultaneous_impact(W, mu, before, law, numbers.e, load=load)
        if impact.end is ImpactEnd.JAM:
            return None
        impulses = np.zeros(len(numbers.load))
        impulses[rows] = impact.impulses
        after, memory = self._pushed(x, numbers, impulses), z.copy()
        # What the impact made vanish is exactly 0.
        after[self._rows[closed, 1:]] = np.reshape(impact.velocities, (-1, 2))
        after[self._works[0]] -= impact.normal_work
        after[self._works[1]] -= impact.tangential_work
        memory[-len(impulses) :] = impulses
        return after, memory

    def _pushed(self, x: Array, numbers: _Numbers, impulses: Array) -> Array:
        """Return the state with the velocities after impulses, and the work of the drives."""
        after, velocities = x.copy(), self._rows[:, 1:]
        after[self._speeds] += numbers.directions @ impulses
        # Last, since a generalised velocity may be that of a contact.
        after[velocities] = x[velocities] + (numbers.W @ impulses).reshape(-1, 2)
        if self._works[2] is not None:
            after[self._works[2]] -= numbers.drive_speeds @ impulses
        return after


def touchdowns_accumulate(times: Sequence[float]) -> bool:
    """Return whether touchdowns of several contacts shrink towards a limit that is reached.

    One contact's bounces are a geometric series; those of several take turns, and only windows of
    them, taken together, shrink steadily.

    Parameters
    ----------
    times : sequence of float
        Of all touchdowns so far; s.
    """
    for size in _WINDOWS:
        ends = times[-1 : -2 - size * SHRINKING : -size]
        lengths = [a - b for a, b in itertools.pairwise(ends)]
        if len(lengths) < SHRINKING or not all(a < b for a, b in itertools.pairwise(lengths)):
            continue
        ratio = max(lengths[0] / lengths[1], lengths[1] / lengths[2])
        if lengths[0] * ratio / (1 - ratio) < REMAINDER * times[-1]:
            return True
    return False
