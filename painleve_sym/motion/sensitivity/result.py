"""First derivatives of a motion: states at any time, event times, velocities after events."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.motion.records import EventRecord
from painleve_sym.motion.trajectory import Trajectory

if TYPE_CHECKING:
    from painleve_sym.motion.sensitivity.variational import RunDerivatives

NO_DERIVATIVE = {
    "grazing": "is met tangentially",
    "singular": "has no finite derivative",
    "simultaneous": "joins contacts that touch at one instant, and a direction parts them",
    "tie": "changes its sequence of slip, stick and restitution with the sign of a direction",
}
"""Notes of events from which on nothing is differentiable, with what such an event does."""


@dataclass(frozen=True)
class EventSensitivity:
    """Derivatives of one event.

    `time_gradient` is ∂τ/∂w of its time, s per unit of w; `state_jacobian` the total derivative of
    `event.state`, including the shift of the event time, shape (nx, k).

    `condition` is the largest relative change of the speed at which the guard is met, per relative
    change of a direction: large near a tangential event; 0 for one that fires at once. `rank` is
    that of the state Jacobian: a slip that stops forgets a direction. It is -1 where that is nan.

    `note` is empty; or a key of `NO_DERIVATIVE`; or ``one-sided``: another event happens at the
    same time by chance, and the derivatives hold as long as their order stays.
    """

    event: EventRecord
    time_gradient: Array
    state_jacobian: Array
    condition: float
    rank: int
    note: str = ""


@dataclass(frozen=True)
class StoredDerivatives:
    """Derivatives of events that have been read, and the run of state and derivatives together."""

    events: tuple[EventSensitivity, ...]
    extended: Trajectory


@dataclass(frozen=True, repr=False)
class SensitiveTrajectory:
    """A motion with its first derivatives in the directions `wrt`.

    Attributes
    ----------
    trajectory : Trajectory
    wrt : tuple of str
        Names of the directions: start values of coordinates and velocities, parameters, or
        ``initial_force``.
    record : RunDerivatives or StoredDerivatives
        Events and extended run.
    final_jacobian : ndarray, shape (nx, k)
        Of `trajectory.final_state`. Where an event ended the run, its time moves along.
    final_time_gradient : ndarray, shape (k,)
        Of `trajectory.final_time`: 0 unless an event ended the run.
    fixed_time_jacobian : ndarray, shape (nx, k)
        Of the state at the final time held fixed.
    valid_until : float
        Time of the first event with a note of `NO_DERIVATIVE`, inf where there is none: derivatives
        from there on are nan; s.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> simulator = ps.Simulator(ps.models.rod(), ps.laws.bilinear_hertz())
    >>> state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> run = simulator.sensitivities(state, ("mu",), t_end=1e-2)
    >>> run.final_jacobian.shape
    (8, 1)
    """

    trajectory: Trajectory
    wrt: tuple[str, ...]
    record: RunDerivatives | StoredDerivatives
    final_jacobian: Array
    final_time_gradient: Array
    fixed_time_jacobian: Array
    valid_until: float

    def __repr__(self) -> str:
        """Return the motion and the directions in one line."""
        return f"Derivatives by {', '.join(self.wrt)} of the {self.trajectory!r}"

    @property
    def events(self) -> tuple[EventSensitivity, ...]:
        """Derivatives of the events, one per event of the trajectory."""
        return self.record.events

    @property
    def extended(self) -> Trajectory:
        """The run of state and derivatives together."""
        return self.record.extended

    @property
    def singular(self) -> EventSensitivity | None:
        """The event from which on nothing is differentiable, None for none."""
        return next((e for e in self.events if e.note in NO_DERIVATIVE), None)

    def at(self, t: ArrayLike) -> Array:
        """Return the derivatives of the states at fixed times `t`, shape (len(t), nx, k)."""
        return self._split(t)[0]

    def gradient(self, name: str, t: ArrayLike) -> Array:
        """Return the derivatives of one state or output at fixed times, shape (len(t), k).

        Raises
        ------
        InputError
            Unknown name, times outside the motion.
        """
        states, outputs = self._split(t)
        for names, values in (
            (self.trajectory.state_names, states),
            (self.trajectory.output_names, outputs),
        ):
            if name in names:
                gradient: Array = values[:, names.index(name)]
                return gradient
        known = (*self.trajectory.state_names, *self.trajectory.output_names)
        raise InputError(unknown_name("quantity", name, known))

    def final_gradient(self, name: str) -> dict[str, float]:
        """Return the derivatives of one state at the end by direction; see `final_jacobian`."""
        names = self.trajectory.state_names
        if name not in names:
            raise InputError(unknown_name("state", name, names))
        row = self.final_jacobian[names.index(name)]
        return dict(zip(self.wrt, map(float, row), strict=True))

    def _split(self, t: ArrayLike) -> tuple[Array, Array]:
        times = np.atleast_1d(np.asarray(t, dtype=float))
        self.trajectory(times)  # rejects times outside the motion
        known = times < self.valid_until
        nx, no, k = (
            len(n) for n in (self.trajectory.state_names, self.trajectory.output_names, self.wrt)
        )
        states, outputs = np.full((len(times), nx, k), np.nan), np.full((len(times), no, k), np.nan)
        if known.any():
            values = np.column_stack(list(self.extended.outputs(times[known]).values()))
            states[known], outputs[known] = split_outputs(values, nx, no, k)
        return states, outputs

    def to_dict(self) -> dict[str, Any]:
        """Return the derivatives as plain data."""
        names = self.trajectory.state_names

        def table(jacobian: Array) -> dict[str, list[float]]:
            return {n: row.tolist() for n, row in zip(names, jacobian, strict=True)}

        return {
            "wrt": list(self.wrt),
            "valid_until": self.valid_until,
            "events": [
                {
                    "kind": e.event.kind,
                    "time": e.event.time,
                    "time_gradient": e.time_gradient.tolist(),
                    "state_jacobian": table(e.state_jacobian),
                    "condition": e.condition,
                    "rank": e.rank,
                    "note": e.note,
                }
                for e in self.events
            ],
            "final_time": self.trajectory.final_time,
            "final_time_gradient": self.final_time_gradient.tolist(),
            "final_jacobian": table(self.final_jacobian),
            "fixed_time_jacobian": table(self.fixed_time_jacobian),
        }


def split_outputs(values: Array, nx: int, no: int, k: int) -> tuple[Array, Array]:
    """Return the derivatives of states (n, nx, k) and outputs (n, no, k) of extended outputs."""
    states = values[:, no : no + nx * k].reshape(-1, k, nx)
    outputs = values[:, no + nx * k :].reshape(-1, k, no)
    return states.transpose(0, 2, 1), outputs.transpose(0, 2, 1)
