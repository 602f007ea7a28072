"""Comparison of the classical and finite-stiffness jumps with compliant impacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.codegen.evaluate import numbers
from painleve_sym.equality import Compared
from painleve_sym.mechanics.system import TIME
from painleve_sym.motion.finite_stiffness import CorrectedJumpRule
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.comparisons.jump_convergence import compare_jump, energetic_jump

_STEP = 1e-5
"""Of the central differences in time; s."""
RULES = ("classical", "frozen", "carried")
"""K → ∞; A and B of the start kept; A and B moved to where the impulse acts."""


@dataclass(frozen=True, eq=False)
class CorrectedComparison(Compared):
    """Velocities after the impact by the three rules and by compliant runs.

    `rules`, by the names of `RULES`, and `softened` have rows of the k values of the parameter that
    was varied and columns of velocities. `slip_times` are when the slip stops, by the frozen rule,
    s; `exponent` is n of the force K δⁿ.
    """

    velocities: tuple[str, ...]
    stiffness: Array
    rules: Mapping[str, Array]
    softened: Array
    slip_times: Array
    exponent: float

    def error(self, rule: str, velocity: str) -> Array:
        """Return rule minus compliant run of one velocity, shape (k,)."""
        return (self.rules[rule] - self.softened)[:, self.velocities.index(velocity)]

    def orders(self, rule: str, velocity: str) -> Array:
        """Return the exponents p of error ∝ stiffnessᵖ between neighbours, shape (k − 1,)."""
        errors = np.abs(self.error(rule, velocity))
        return np.diff(np.log(errors)) / np.diff(np.log(self.stiffness))

    @property
    def classical_order(self) -> float:
        """−1/(2n), where the order of the classical rule tends to."""
        return -1 / (2 * self.exponent)


def compare_corrected(
    simulator: Simulator, state: Mapping[str, float], stiffness: Sequence[float]
) -> CorrectedComparison:
    """Return the three rules and compliant impacts from a state; see `compare_jump`."""
    classical = compare_jump(simulator, state, stiffness)
    defaults = simulator.parameters()
    values: dict[str, ArrayLike] = {**defaults, "E": np.array(stiffness, dtype=float)}
    rule = CorrectedJumpRule(simulator.mechanism, simulator.contact_law)
    corrected = {name: rule(state, values, configuration=name) for name in ("frozen", "carried")}
    names = classical.velocities
    shape = (len(stiffness), len(names))
    rules = {"classical": np.broadcast_to(classical.rule[-1], shape)}
    for name, jumps in corrected.items():
        rules[name] = np.stack([jumps.velocity[v] for v in names], axis=-1)
    symbols = simulator.constants(defaults)
    return CorrectedComparison(
        names,
        classical.stiffness,
        rules,
        classical.softened[:, -1],
        corrected["frozen"].impacts.phase["duration"][:, 0],
        float(numbers([simulator.contact_law.exponent], symbols)[0]),
    )


def drift_of_the_rule(simulator: Simulator, state: Mapping[str, float], velocity: str) -> float:
    """Return d/dτ of a velocity after the classical jump, had it happened τ later; m/s² or 1/s².

    The configuration moves on freely until the impulse acts, at τ ≈ t1: times t1 this is the
    leading error of the rule with a frozen configuration. By central differences.
    """
    mechanism = simulator.mechanism
    full = dict.fromkeys(mechanism.state_names, 0.0) | dict(state)
    after = []
    for tau in (-_STEP, _STEP):
        # Only the configuration: what finite forces do to the velocities the rule keeps.
        moved = {
            c.name: full[c.name] + tau * full[f"{c.name}_dot"]
            for c in mechanism.outline.coordinates
        }
        if mechanism.depends_on_time:
            moved[TIME.name] = full[TIME.name] + tau
        after.append(energetic_jump(simulator, full | moved).velocity[velocity])
    return (after[1] - after[0]) / (2 * _STEP)
