"""How the force that separates lift-off from impact depends on the start and the parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from painleve_sym.codegen.run import Array
from painleve_sym.errors import InputError
from painleve_sym.simulate.compliant import SoftenedSimulator
from painleve_sym.simulate.variational import INITIAL_FORCE
from painleve_sym.study.compare import separating_force

RTOL = 1e-12
"""Of the motion at the critical force: slow decisions let errors grow a thousandfold."""
WIDTH = 1e-12
"""Relative width to which the force is bisected."""
BELOW = 1e-10
"""Relative distance below the critical force at which it is differentiated."""


@dataclass(frozen=True)
class ForceGradient:
    """The critical force and its derivatives.

    Attributes
    ----------
    force : float
        N.
    wrt : tuple of str
    gradient : ndarray, shape (k,)
        ∂F*/∂w; N per unit of w.
    slip_velocity : float
        What is left of the slip where it should just vanish; m/s.
    """

    force: float
    wrt: tuple[str, ...]
    gradient: Array
    slip_velocity: float


def critical_force_gradient(
    simulator: SoftenedSimulator,
    state: Mapping[str, float],
    wrt: tuple[str, ...],
    *,
    bracket: tuple[float, float],
    parameters: Mapping[str, float] | None = None,
    compressing: bool = False,
) -> ForceGradient:
    """Return the least initial force from which the slip stops, and its derivatives.

    At the critical force F* the slip velocity v vanishes just when the contact separates (or, for
    `compressing`, when it turns): v(F*, w) = 0 there, so ∂F*/∂w = −(∂v/∂w)/(∂v/∂F), taken on the
    side where the slip goes on, with the time of that event moving along.

    Parameters
    ----------
    simulator : SoftenedSimulator
    state : mapping of str to float
    wrt : tuple of str
        Parameters and start values.
    bracket : tuple of float
        A force from which the slip does not stop, and one from which it does; N.
    parameters : mapping of str to float, optional
    compressing : bool
        As for `separating_force`.

    Raises
    ------
    InputError
        The bracket does not separate, or something else than the slip decides there.
    """
    given = dict(parameters or {})
    force = separating_force(simulator, state, given, bracket, compressing=compressing, rtol=WIDTH)
    end = "max_compression" if compressing else "separation"
    found = simulator.sensitivities(
        state,
        (INITIAL_FORCE, *wrt),
        parameters=given,
        initial_force=force * (1 - BELOW),
        t_end=1.0,
        until=(end, "slip_stop"),
        rtol=RTOL,
        record="events",
    )
    last = found.trajectory.events[-1] if found.trajectory.events else None
    if last is None or last.kind != end or found.singular is not None:
        got = last.kind if last else found.trajectory.stop_reason.label
        raise InputError(
            f"critical force of {simulator.where}: just below {force:g} N the motion ends in "
            f"{got}, need {end}. Fix: check that the slip decides there."
        )
    slip = found.trajectory.state_names.index(simulator.contact.slip.name)
    row = found.final_jacobian[slip]
    left = float(found.trajectory.final_state[slip])
    return ForceGradient(force, wrt, -row[1:] / row[0], left)
