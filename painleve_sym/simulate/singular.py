"""Where a slip that meets A = 0 arrives: time, state and force exponent of the limit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from painleve_sym.codegen.evaluate import numbers
from painleve_sym.codegen.run import Array
from painleve_sym.errors import StopReason
from painleve_sym.hybrid.contact_states import CONTACTS
from painleve_sym.hybrid.rigid import RigidContact
from painleve_sym.mechanics.coefficients import F_N
from painleve_sym.simulate.findings import LimitKind, SingularLimit
from painleve_sym.simulate.trajectory import Trajectory

_ITERATIONS = 5
"""Of the last stretch to the limit: each gains the part of α that changes there, below 1e-2."""

_SPACING = 10.0
"""Ratio of the distances t* − t of the three forces from which the exponent is measured."""


def locate_limit(
    contact: RigidContact, run: Trajectory, values: Mapping[str, float]
) -> SingularLimit | None:
    """Return the limit of a run that stopped where its slip meets A = 0; None for other stops.

    With the law F − F* ~ (t* − t)^(r − 1) of the singular point, the mean force from the stop to
    the limit is (F + β₀/α)/r, which stays finite where F* does not (r = 1). All rates are affine
    in the force, so that this mean force carries the state to t*; there it is corrected to B = 0.

    Parameters
    ----------
    contact : RigidContact
    run : Trajectory
    values : mapping of str to float
        All parameters by name.
    """
    mode = run.mode_names[run.final_mode]
    name = mode.removesuffix("_unstable")
    if run.stop_reason is not StopReason.SINGULAR or not CONTACTS.get(name):
        return None
    return _Approach(contact, name, values).limit(run)


class _Approach:
    """A, B, their rates and the rates of all states in one slip mode."""

    def __init__(self, contact: RigidContact, mode: str, values: Mapping[str, float]) -> None:
        slip, c = CONTACTS[mode], contact.mechanism.coefficients
        point = contact.singular_points[slip]
        self.states = contact.states
        self._local = (c.A(slip), c.B, point.A_rate, point.B_rate, point.B_rate_per_force)
        rates = contact.field(mode, F_N) | {contact.gap: 0, contact.gap_rate: 0}
        self._rates = [rates.get(s, 0) for s in self.states]
        parameters = contact.mechanism.system.parameters
        self._constants: dict[Any, float] = {p.symbol: values[p.name] for p in parameters}

    def _at(self, expressions: Any, state: Array, force: float = 0.0) -> Array:
        symbols = dict(zip(self.states, map(float, state), strict=True))
        return numbers(expressions, self._constants | symbols | {F_N: force})

    def limit(self, run: Trajectory) -> SingularLimit:
        """Return where the run arrives."""
        state = np.asarray(run.final_state)
        A, B, alpha, beta_0, beta_1 = map(float, self._at(self._local, state))
        force, end, left = -B / A, state, -A / alpha
        ratio = -beta_1 / alpha
        reaches = ratio > 0 and left > 0
        mean_force = (force + beta_0 / alpha) / ratio if reaches else math.nan
        for _ in range(_ITERATIONS if reaches else 0):
            end = state + left * self._at(self._rates, state, mean_force)
            _, B_end, alpha_end, _, beta_end = map(float, self._at(self._local, end))
            # α goes to its limit like (t* − t)^r, as the velocities do; B ends at 0.
            left = -A / (alpha_end + (alpha - alpha_end) / (1 + ratio))
            mean_force -= B_end / (beta_end * left)
        A, B, alpha, beta_0, beta_1 = map(float, self._at(self._local, end))
        ratio, bounded = -beta_1 / alpha, -beta_0 / (alpha + beta_1)
        kind = _kind(ratio, force, bounded) if reaches else LimitKind.STOP
        time = run.final_time + left
        return SingularLimit(
            kind=kind,
            time=time,
            state={s.name: float(v) for s, v in zip(self.states, end, strict=True)},
            A=A,
            B=B,
            eigenvalues=(alpha, -beta_1),
            eigenvalue_ratio=ratio,
            force_exponent=1 - ratio,
            measured_exponent=_measured_exponent(run, time),
            bounded_force=bounded,
        )


def _kind(ratio: float, force: float, bounded: float) -> LimitKind:
    if ratio >= 1:
        return LimitKind.BOUNDED if bounded > 0 else LimitKind.LIFTOFF
    return LimitKind.DYNAMIC_JAM if force > bounded else LimitKind.LIFTOFF


def _measured_exponent(run: Trajectory, limit: float) -> float | None:
    """Return γ of F = F* + C (t* − t)^(−γ) from three forces: differences do not hold F*."""
    left = limit - run.final_time
    times = limit - left * _SPACING ** np.array([2.0, 1.0, 0.0])
    times[-1] = run.final_time
    if not len(run.step_time) or not times[0] >= run.segments[-1].t_start:
        return None
    # Times are rounded: the distances are those of the numbers taken.
    first, second, third = run.values("normal_force", times)
    if not (third - second) * (second - first) > 0:
        return None
    return math.log((third - second) / (second - first)) / math.log(_SPACING)
