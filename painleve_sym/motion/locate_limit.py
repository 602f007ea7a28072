"""Limit of a slip that meets A = 0: its time, state and force exponent."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.automata.model import CONTACTS, ContactModel
from painleve_sym.codegen.quantities import quantities
from painleve_sym.errors import StopReason
from painleve_sym.motion.singular_limit import LimitKind, SingularLimit
from painleve_sym.motion.trajectory import Trajectory

_FORCE = "F_n"
"""Name of the normal force among the arguments."""

_ITERATIONS = 5
"""Of the last stretch to the limit: each gains the part of α that changes there, below 1e-2."""

_SPACING = 10.0
"""Ratio of the distances t* − t of the three forces from which the exponent is measured."""


_MEETINGS = {
    LimitKind.BOUNDED: "the slip runs into A = B = 0 with a bounded force (see limit); beyond it "
    "the contact can slip on, open or have an impact",
    LimitKind.LIFTOFF: "the slip meets A = B = 0 to within rounding, but its force falls to 0 "
    "before; the contact opens there",
    LimitKind.STOP: "the slip comes to A = 0 with B < 0, where the contact force presses it to a "
    "stop; start again with slip velocity 0",
}
"""What a slip that meets A = 0 without dynamic jam does there."""


def with_limit(contact: ContactModel, run: Trajectory, values: Mapping[str, float]) -> Trajectory:
    """Return a motion that stopped where a slip meets A = 0 with the limit it would arrive at."""
    limit = locate_limit(contact, run, values)
    if limit is None:
        return run
    jam = limit.kind is LimitKind.DYNAMIC_JAM
    reason = StopReason.DYNAMIC_JAM if jam else run.stop_reason
    detail = reason.sentence if jam else _MEETINGS[limit.kind]
    return replace(run, limit=limit, stop_reason=reason, stop_detail=detail)


def locate_limit(
    contact: ContactModel, run: Trajectory, values: Mapping[str, float]
) -> SingularLimit | None:
    """Return the limit of a run that stopped where its slip meets A = 0; None for other stops.

    With the law F − F* ~ (t* − t)^(r − 1) of the singular point, the mean force from the stop to
    the limit is (F + β₀/α)/r, which stays finite where F* does not (r = 1). All rates are affine in
    the force, so that this mean force carries the state to t*; there it is corrected to B = 0.
    """
    if contact.friction_varies:
        return None
    mode = _slip(run.mode_names[run.final_mode])
    if run.stop_reason is not StopReason.SINGULAR or mode is None:
        return None
    constants = {p.name: np.array([values[p.name]]) for p in contact.mechanism.outline.parameters}
    limits = _Approach(contact, mode, run.state_names, constants).limits(
        np.asarray(run.final_state)[None]
    )
    time = run.final_time + float(limits.left[0])
    ratio = float(limits.ratio[0])
    return SingularLimit(
        kind=limits.kind(0),
        time=time,
        state={n: float(v) for n, v in zip(run.state_names, limits.states[0], strict=True)},
        A=float(limits.A[0]),
        B=float(limits.B[0]),
        eigenvalues=(float(limits.alpha[0]), -float(limits.beta_1[0])),
        eigenvalue_ratio=ratio,
        force_exponent=1 - ratio,
        measured_exponent=_measured_exponent(run, time),
        bounded_force=float(limits.bounded[0]),
    )


def jams(
    contact: ContactModel,
    mode: str,
    names: Sequence[str],
    states: Array,
    values: Mapping[str, Array],
) -> Any:
    """Return which runs that stopped where their slip meets A = 0 jam dynamically, shape (n,).

    All of them stopped in one mode; `names` are those of the states, shape (n, nx), and the values,
    shape (n,), those of all parameters.
    """
    slip = _slip(mode)
    if slip is None:
        return np.zeros(len(states), bool)
    limits = _Approach(contact, slip, names, values).limits(states)
    return np.array([limits.kind(i) is LimitKind.DYNAMIC_JAM for i in range(len(states))])


def _slip(mode: str) -> str | None:
    """Return the slip of a mode, None where it does not slip."""
    name = mode.removesuffix("_unstable")
    return name if CONTACTS.get(name) else None


@dataclass(frozen=True)
class _Limits:
    """Limits of n slips; arrays of shape (n,), states (n, nx)."""

    states: Array
    left: Array
    force: Array
    A: Array
    B: Array
    alpha: Array
    beta_1: Array
    ratio: Array
    bounded: Array
    reaches: Any

    def kind(self, i: int) -> LimitKind:
        """Return how one of them meets A = 0."""
        if not self.reaches[i]:
            return LimitKind.STOP
        force, bounded = self.force[i], self.bounded[i]
        if self.ratio[i] >= 1:
            return LimitKind.BOUNDED if bounded > 0 else LimitKind.LIFTOFF
        return LimitKind.DYNAMIC_JAM if force > bounded else LimitKind.LIFTOFF


class _Approach:
    """A, B, their rates and the rates of all states in one slip mode, at n points."""

    def __init__(
        self,
        contact: ContactModel,
        mode: str,
        states: Sequence[str],
        constants: Mapping[str, Array],
    ) -> None:
        def derive() -> tuple[dict[str, Any], list[Any]]:
            from painleve_sym.automata.rigid import RigidContact
            from painleve_sym.mechanics.coefficients import F_N

            builder, slip = RigidContact(contact), CONTACTS[mode]
            point, c = builder.singular_points[slip], builder.mechanism.coefficients
            local = (c.A(slip), c.B, point.A_rate, point.B_rate, point.B_rate_per_force)
            rates = builder.field(mode, F_N) | {builder.gap: 0, builder.gap_rate: 0}
            of_states = (rates.get(s, 0) for s in builder.states)
            parameters = [p.symbol for p in contact.mechanism.outline.parameters]
            symbols = [*builder.states, *parameters, F_N]
            return dict(zip(self._names, (*local, *of_states), strict=True)), symbols

        self._states, self._constants = states, constants
        of_states = (f"rate_{i}" for i in range(len(states)))
        self._names = ("A", "B", "alpha", "beta_0", "beta_1", *of_states)
        arguments = (*states, *(p.name for p in contact.mechanism.outline.parameters), _FORCE)
        title = f"approach of A = 0 in {mode}"
        self._numbers = quantities(title, contact.definition, arguments, derive)

    def _at(self, states: Array, force: Array) -> tuple[dict[str, Array], Array]:
        named = dict(zip(self._states, states.T, strict=True))
        numbers = list(self._numbers.at({**self._constants, **named, _FORCE: force}).values())
        return dict(zip(self._names[:5], numbers[:5], strict=True)), np.array(numbers[5:]).T

    def limits(self, states: Array) -> _Limits:
        """Return the limits of the runs that stopped at the states (n, nx)."""
        with np.errstate(all="ignore"):
            return self._limits(states)

    def _limits(self, states: Array) -> _Limits:
        at, _ = self._at(states, np.zeros(len(states)))
        A, alpha = at["A"], at["alpha"]
        force, end, left = -at["B"] / A, states, -A / alpha
        ratio = -at["beta_1"] / alpha
        reaches = (ratio > 0) & (left > 0)
        left = np.where(reaches, left, 0.0)
        mean_force = np.where(reaches, (force + at["beta_0"] / alpha) / ratio, 0.0)
        for _ in range(_ITERATIONS):
            _, rates = self._at(states, mean_force)
            end = np.where(reaches[:, None], states + left[:, None] * rates, states)
            there, _ = self._at(end, mean_force)
            # α goes to its limit like (t* − t)^r, as the velocities do; B ends at 0.
            mean_alpha = there["alpha"] + (alpha - there["alpha"]) / (1 + ratio)
            left = np.where(reaches, -A / mean_alpha, left)
            mean_force = mean_force - there["B"] / (there["beta_1"] * left)
        there, _ = self._at(end, mean_force)
        alpha, beta_1 = there["alpha"], there["beta_1"]
        return _Limits(
            states=end,
            left=left,
            force=force,
            A=there["A"],
            B=there["B"],
            alpha=alpha,
            beta_1=beta_1,
            ratio=-beta_1 / alpha,
            bounded=-there["beta_0"] / (alpha + beta_1),
            reaches=reaches,
        )


def _measured_exponent(run: Trajectory, limit: float) -> float | None:
    """Return γ of F = F* + C (t* − t)^(−γ) from three forces: differences do not hold F*."""
    left = limit - run.final_time
    if not left > 0:
        return None
    times = limit - left * _SPACING ** np.array([2.0, 1.0, 0.0])
    times[-1] = run.final_time
    if not len(run.step_time) or not times[0] >= run.segments[-1].t_start:
        return None
    # Times are rounded: the distances are those of the numbers taken.
    first, second, third = run.values("normal_force", times)
    if not (third - second) * (second - first) > 0:
        return None
    return math.log((third - second) / (second - first)) / math.log(_SPACING)
