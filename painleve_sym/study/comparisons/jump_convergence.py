"""Convergence of compliant impacts to the three-phase rigid jump."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.at.jump import JumpResult, evaluate_jump
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.trajectory import Trajectory

PHASE_ENDS = ("slip_stop", "max_compression", "separation")
"""Events of a compliant impact at which the three phases of the jump end."""
RTOL = 1e-12
"""Of the compliant runs: their error then stays far below the difference that is studied."""


@dataclass(frozen=True, eq=False)
class JumpComparison(Compared):
    """A jump and the compliant impacts from the same state, for growing stiffness.

    `rule` has the velocities (columns) that the jump gives at the end of each of three phases,
    `softened` those at the events that end the phases, with a first axis of the values of
    stiffness, `times` when these are, s. The `expected_order` is −1/(2n): the rule drops the
    impulse of finite forces over the first phase, whose length is proportional to it, up to a
    factor that tends to 1 slowly.
    """

    velocities: tuple[str, ...]
    stiffness: Array
    jump: JumpResult
    rule: Array
    softened: Array
    times: Array
    expected_order: float

    @cached_property
    def errors(self) -> Array:
        """Compliant run minus rule, shape (k, 3, v)."""
        return self.softened - self.rule

    def column(self, phase: int, velocity: str) -> tuple[float, Array, Array]:
        """Return rule, compliant values (k,) and errors (k,) of one velocity after one phase."""
        index = self.velocities.index(velocity)
        values = self.softened[:, phase - 1, index]
        return float(self.rule[phase - 1, index]), values, self.errors[:, phase - 1, index]

    def orders(self, phase: int, velocity: str) -> Array:
        """Return the exponents p of error ∝ stiffnessᵖ between neighbours, shape (k − 1,)."""
        errors = np.abs(self.column(phase, velocity)[2])
        return np.diff(np.log(errors)) / np.diff(np.log(self.stiffness))


def energetic_jump(
    simulator: Simulator,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
) -> JumpResult:
    """Return the energetic jump at a state, with those parameters of a simulator that it has."""
    own = {*simulator.mechanism.parameters, "e_energetic"}
    given = {k: v for k, v in simulator.parameters(parameters).items() if k in own}
    return evaluate_jump(simulator.mechanism, "energetic", state, parameters=given)


def compare_jump(
    simulator: Simulator,
    state: Mapping[str, float],
    stiffness: Sequence[float],
    *,
    parameters: Mapping[str, float] | None = None,
    t_end: float = 1.0,
) -> JumpComparison:
    """Return the energetic jump at a state and compliant impacts from it for several moduli E; Pa.

    Every impact must have ended by `t_end`, and must have the three events that end the phases.
    """
    mechanism = simulator.mechanism
    complete = dict.fromkeys(mechanism.state_names, 0.0) | dict(state)
    jump = energetic_jump(simulator, complete, parameters)
    if jump.case is not ImpactClass.C_STICKING or not any(jump.slip_velocity):
        raise InputError(
            f"comparison of {mechanism.name!r}: the impact is {jump.case.value}, need one that "
            "slips, then sticks in compression. Fix: start it in the inconsistent state."
        )
    names = mechanism.outline.velocity_names
    runs = []
    for value in stiffness:
        given = {**(parameters or {}), "E": value}
        run = simulator.run(
            complete, t_end=t_end, parameters=given, until="separation", record="events", rtol=RTOL
        )
        runs.append(_at_ends(run, names, f"E = {value:g}"))
    symbols = simulator.constants(simulator.parameters(parameters))
    exponent = float(numbers([simulator.contact_law.exponent], symbols)[0])
    return JumpComparison(
        velocities=names,
        stiffness=np.array(stiffness, dtype=float),
        jump=jump,
        rule=np.array([[phase.velocity[n] for n in names] for phase in jump.phases]),
        softened=np.array([ends for ends, _ in runs]),
        times=np.array([times for _, times in runs]),
        expected_order=-1 / (2 * exponent),
    )


def _at_ends(
    run: Trajectory, names: tuple[str, ...], where: str
) -> tuple[list[list[float]], list[float]]:
    ends, times = [], []
    for kind in PHASE_ENDS:
        events = run.events_of(kind)
        if not events:
            kinds = ", ".join(e.kind for e in run.events) or "none"
            raise InputError(
                f"compare jump of {run.mechanism!r}, {where}: no event {kind!r} (events: {kinds}; "
                f"{run.stop_reason.sentence}). Fix: start from an impact, or give a later t_end."
            )
        ends.append([events[0].state[name] for name in names])
        times.append(events[0].time)
    return ends, times
