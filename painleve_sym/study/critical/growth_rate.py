"""Growth rate of compliant runs that leave the sliding solution, compared with its closed form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.study.critical.bisection import CriticalForceFinder

OFFSET = 1e-10
"""Relative deviation of the force at the start: far above round-off, and linear for 20 e-folds."""
E_FOLDING_WINDOW = (4.0, 14.0)
"""Where the growth is read, in units of 1/λ: the decaying part is gone, the growing still small."""
SAMPLES = 41
"""Instants between, an odd number for Simpson's rule."""


@dataclass(frozen=True, eq=False)
class GrowthComparison(Compared):
    """Growth of a small deviation from the sliding solution.

    `deviation` is the difference of the compressions of both runs, m; `growth_rate` is λ₊ of the
    sliding solution along the run, 1/s. `measured` and `predicted` are ln of the deviation's growth
    from the first to the last instant, and ∫λ₊ dt. `base` runs from the critical force, `other`
    from one a little larger.
    """

    times: Array
    deviation: Array
    growth_rate: Array
    measured: float
    predicted: float
    base: Trajectory
    other: Trajectory

    @property
    def error(self) -> float:
        """measured/predicted − 1, which tends to 0 like 1/λ."""
        return self.measured / self.predicted - 1


def compare_growth(
    finder: CriticalForceFinder,
    state: Mapping[str, float],
    parameters: Mapping[str, float] | None = None,
) -> GrowthComparison:
    """Return how a deviation of the initial force grows in compliant runs.

    Two runs start at the critical force and a part `OFFSET` above it; both follow the stable
    manifold, and what separates them is the growing solution. The state is indeterminate, as for
    `CriticalForceFinder.find`; InputError where the contact does not slide long enough for
    `E_FOLDING_WINDOW`.
    """
    simulator = finder.simulator
    critical = finder.find(state, parameters, check_tolerance=False)
    rate = critical.sliding.growth_rate
    first, last = (fold / rate for fold in E_FOLDING_WINDOW)
    times = np.linspace(first, last, SAMPLES)
    base, other = (
        simulator.run(
            state,
            parameters=parameters,
            initial_force=force,
            t_end=float(times[-1]),
            until=("separation", "slip_stop"),
            rtol=finder.rtol,
        )
        for force in (critical.value, critical.value * (1 + OFFSET))
    )
    ends = min(base.final_time, other.final_time)
    if ends < times[-1]:
        raise InputError(
            f"growth of a deviation of {simulator.where}: the contact slides until {ends:g} s, "
            f"need {times[-1]:g} s. Fix: give fewer e-folds, or a stiffer contact."
        )
    deviation = np.abs(other.values("compression", times) - base.values("compression", times))
    names = simulator.mechanism.state_names
    rates = np.empty(SAMPLES)
    for i, time in enumerate(times):
        at = base.state(float(time))
        there = finder.analysis.along({n: at[n] for n in names}, parameters)
        rates[i] = there.growth_rate
    weights = np.array([1, *[4, 2] * (SAMPLES // 2 - 1), 4, 1]) * (times[1] - times[0]) / 3
    return GrowthComparison(
        times=times,
        deviation=deviation,
        growth_rate=rates,
        measured=float(np.log(deviation[-1] / deviation[0])),
        predicted=float(weights @ rates),
        base=base,
        other=other,
    )
