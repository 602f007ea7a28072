"""Parts whose local modes are data, for the engine `erk`: the decisions of ``loop/choose.c``."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.engines.erk_mode import Call
from painleve_sym.hybrid.automaton import HybridAutomaton, TestRole

# The constants of the compiled engine: its decisions are repeated here.
ZERO_TIME, MOMENT = 1e-10, 16e-16
_ZERO_TERMS, _ZERO_SLOPE, _SAME_MOTION = 1e-12, 1e-10, 1e-8
REST_ERRORS = 10.0
"""Errors of a state, by its tolerance, below which it is at rest."""

HUGE = 1e300
"""Stands for inf, so that 0·inf is not nan."""


def guard_side(g: float, d: float, d2: float, h: float, departs: bool, moment: float = 0.0) -> int:
    """1: on the positive side, armed; 0: at zero and leaving upwards; -1: fires now.

    A guard that rises above zero within a `moment`, which the time does not resolve, is at zero.
    """
    d = float(np.nan_to_num(d, nan=0.0, posinf=HUGE, neginf=-HUGE))
    d2 = d2 if np.isfinite(d2) else 0.0
    first, second = d * ZERO_TIME * h, 0.5 * d2 * (ZERO_TIME * h) ** 2
    band = abs(first) + abs(second)
    if g > band:
        return 1
    if g < -max(band, d * moment):
        return -1
    if departs:
        return 0
    return -1 if (first if abs(first) > abs(second) else second) < 0 else 0


FAILS, HOLDS, LASTS, IDLE, ENDS = 0, 1, 2, 4, 8
"""How the tests of a combination hold; IDLE is added where what should begin stays zero.

They end where they fail by rates alone: guards would be armed, though values are no more than
rounding.
"""


def tests_hold(
    values: list[Array], h: float, roles: Sequence[TestRole], exists: bool
) -> tuple[int, float]:
    """Return how tests hold, and by how much they are missed, in parts of their scales.

    They last where they hold also by the measure by which guards are armed. The values are tests
    with first and second derivatives along the motion, and their scales, shape (nt,) each; h is the
    first step of the motion, s. Where a motion always `exists`, none is idle.
    """
    lasts, idle, ends, missed = True, False, True, 0.0
    for v, d, d2, scale, role in zip(*values, roles, strict=True):
        first, second, slope = h * d, 0.5 * h * h * d2, _ZERO_SLOPE * scale
        if not np.isfinite(v):
            missed = math.inf
        if abs(v) > _ZERO_TERMS * scale + ZERO_TIME * abs(first):
            decides = v
        elif abs(first) > slope:
            decides = first
        else:
            decides = second if abs(second) > slope else 0.0
        stays = role is TestRole.BEGINS and not exists and decides == 0 and scale > 0
        idle |= stays
        if role is TestRole.VANISHES:
            decides = -abs(decides)
        if decides < 0:
            missed = max(missed, -decides / scale if scale > 0 else math.inf)
            ends &= role is TestRole.HOLDS and guard_side(v, d, d2, h, False) > 0
        lasts &= stays or role is TestRole.VANISHES or guard_side(v, d, d2, h, False) >= 0
    if missed > 0:
        return (ENDS if ends else FAILS), missed
    return (LASTS if lasts else HOLDS) | (IDLE if idle else 0), missed


def same_motion(a: Array, b: Array, rounding: float = 0.0) -> bool:
    """Whether rates are those of one motion; less than `rounding` they are not known to."""
    return bool(np.abs(a - b).max() <= max(_SAME_MOTION * np.abs(a).max(), rounding))


class Combination(NamedTuple):
    """Memory, how many parts are open and in what they prefer, and what it may become at rest."""

    memory: Array
    open: int
    preferred: int
    rests: tuple[Array, ...] = ()


class Parts:
    """The parts of an automaton: what they may do, and what follows a choice."""

    def __init__(self, functions: AutomatonFunctions, alternatives: ca.Function) -> None:
        self.automaton: HybridAutomaton = functions.automaton
        self._alternatives = Call(alternatives)

    def exists(self, combinations: Sequence[Combination]) -> bool:
        """Whether there is always one motion: all forces are given, no rigid contact can close."""
        impacts = self.automaton.impacts
        return impacts is None or all(c.open == len(impacts.rigid) for c in combinations)

    @cached_property
    def rest(self) -> list[int]:
        """Indices of the states that count as 0 where they are 0 within the tolerance."""
        own = self.automaton
        return [own.states.index(s) for part in own.parts for s in part.rest]

    def roles(self, mode: int) -> tuple[TestRole, ...]:
        """Return what each test of a mode says."""
        return tuple(test.role for test in self.automaton.modes[mode].tests)

    def leaving(self, mode: int) -> tuple[int, ...]:
        """Return the guards of a mode that leave 0 upwards after a choice."""
        labels = {label for part in self.automaton.parts for label in part.leaving}
        transitions = self.automaton.modes[mode].transitions
        return tuple(j for j, t in enumerate(transitions) if t.label in labels)

    def combinations(self, x: Array, z: Array, c: Array) -> list[Combination]:
        """Return every combination of alternatives."""
        conditions, flat = self._alternatives(x, z, c)
        memory, place, first = flat.reshape(len(conditions), -1), 0, 0
        offered: list[list[Combination]] = []
        for part in self.automaton.parts:
            own = slice(place, place + len(part.memory))
            every = [
                Combination(memory[first + k, own], int(a.open), int(a.preferred))
                for k, a in enumerate(part.alternatives)
            ]
            possible = [
                (k, a) for k, a in enumerate(part.alternatives) if conditions[first + k] > 0
            ]
            rests = [
                tuple(every[j].memory for j, b in possible if b.rest_of == k)
                for k in range(len(every))
            ]
            offered.append(
                [every[k]._replace(rests=rests[k]) for k, a in possible if a.rest_of is None]
            )
            place, first = own.stop, first + len(part.alternatives)
        # What no part owns, the impulses of the last impact, is kept.
        kept = z[place:]
        return [
            Combination(
                np.concatenate([*(one.memory for one in each), kept]),
                sum(one.open for one in each),
                sum(one.preferred for one in each),
                tuple(
                    np.concatenate([*memories, kept])
                    for memories in itertools.product(*((m.memory, *m.rests) for m in each))
                ),
            )
            for each in itertools.product(*offered)
        ]

    def choose(
        self,
        combinations: list[Combination],
        held: Callable[[Array, bool], tuple[int, float, Array]],
        before: Array,
        entered: list[Array],
    ) -> Array | None:
        """Return the memory that is entered; None where no combination satisfies the tests.

        Forces that are all given leave one motion: where rounding hides it, that is the nearest; of
        others it is one that ends in no time. A motion that ends where it begins is not the one
        that lasts; of one motion a combination is taken that does. `held` maps the memory, and
        whether all forces are given, to the results of `tests_hold` and the rates of the states;
        `before` is the memory before the event, shape (nz,), and `entered` are those chosen before
        at this instant.
        """
        policy, parts = self.automaton.preference, len(self.automaton.parts)
        best, motions, chosen, rate, repeats, most = -1, 0, None, before, True, 0
        nearest, exists, some = (math.inf, before), self.exists(combinations), False
        lasts, lasting, span = True, list[tuple[Array, Array, int]](), 0.0
        idle: tuple[Array, ...] = ()
        for memory, is_open, preferred, rests in combinations:
            hold, missed, rates = held(memory, exists)
            span = max(span, float(np.abs(rates).max()))
            if hold == LASTS:
                lasting.append((memory, rates, preferred))
            # What alone is possible needs no test.
            hold = hold if len(combinations) > 1 else HOLDS
            left = np.array_equal(memory, before)
            again = exists and (left or any(np.array_equal(memory, m) for m in entered))
            if hold in (FAILS, ENDS):
                if not again and (exists or hold) and missed < nearest[0]:
                    nearest = missed, memory
                continue
            repeats &= again
            # Of those that differ by rounding alone, one that lasts; last the one just left.
            rank = 2 * (parts - is_open if policy < 0 else is_open) + (not (left or again))
            rank = 3 * ((parts + 1) * rank + preferred) + (0 if left or again else hold & ~IDLE)
            if preferred > most:
                most, motions = preferred, 0
            # Rates of an idle one are those of others but for rounding.
            some |= bool(hold & IDLE)
            if preferred == most and not hold & IDLE:
                motions += not motions or not same_motion(rates, rate)
            if rank > best:
                best, chosen, rate = rank, memory, rates
                idle = rests if hold & IDLE else ()
                lasts = len(combinations) == 1 or bool(hold & LASTS)
        if not exists and not lasts:
            for memory, rates, preferred in lasting:
                if preferred == most and same_motion(rates, rate, _ZERO_TERMS * span):
                    chosen, idle = memory, ()
                    break
        held_at_rest = (memory for memory in idle if held(memory, exists)[0] in (HOLDS, LASTS))
        chosen = next(held_at_rest, chosen)
        motions = motions or int(some)
        if (not motions or (exists and repeats)) and nearest[0] < math.inf:
            return nearest[1]
        return None if policy == 0 and motions > 1 else chosen
