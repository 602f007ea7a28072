"""Derivatives of the critical initial force by the initial state and the parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from painleve_sym.arrays import Array
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.motion.arguments import INITIAL_FORCE
from painleve_sym.study.critical.bisection import Border, CriticalForce, CriticalForceFinder
from painleve_sym.study.critical.continuation import VariedCase

STEP = 2e-4
"""Relative step of the differences: near A = 0 the force varies on a scale of a hundredth, and the
sixth order then meets the round-off of the forces, 1e-13/STEP."""
BELOW = 1e-10, 4e-10
"""Relative distances below the critical force at which the motion is differentiated."""
RTOL = 1e-12
"""Of the motion at the critical force: slow decisions let errors grow a thousandfold."""
METHODS = ("differences", "sensitivities")
_ENDS = {Border.SLIP_STOP: "separation", Border.COMPRESSION: "max_compression"}


@dataclass(frozen=True, eq=False)
class ForceDerivative(Compared):
    """Derivative of a critical force by one quantity; N per unit of it.

    The error is estimated from the difference of the sixth and the fourth order, or of two
    distances.
    """

    name: str
    value: float
    error: float
    method: str


def critical_force_gradient(
    finder: CriticalForceFinder,
    state: Mapping[str, float],
    names: Sequence[str],
    *,
    parameters: Mapping[str, float] | None = None,
    border: Border = Border.SLIP_STOP,
    method: str = "differences",
) -> dict[str, ForceDerivative]:
    """Return the derivatives of a critical force by parameters or parts of the state.

    ``differences``: central, of sixth order, over the bisected forces, whose relative error is near
    1e-13; six bisections for each name. ``sensitivities``: at the critical force F* the slip
    velocity v vanishes just when the contact separates (or, for Border.COMPRESSION, turns), so that
    ∂F*/∂w = −(∂v/∂w)/(∂v/∂F), from one motion with its derivatives through the events on the side
    where the slip continues. Where the motion takes another branch of the law beside the state, as
    at ġ_N = 0, only the first derivative is continuous and the estimated error tells so.

    Parameters
    ----------
    finder : CriticalForceFinder
    state : mapping of str to float
    names : sequence of str
        Parameters of mechanism or law, coordinates, velocities.
    parameters : mapping of str to float, optional
    border : Border
    method : {"differences", "sensitivities"}

    Raises
    ------
    InputError
        As for `CriticalForceFinder.find`, also a little beside the state; an unknown method; for
        sensitivities, where something else than the slip decides.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> from painleve_sym.study import CriticalForceFinder, critical_force_gradient
    >>> simulator = ps.Simulator(ps.models.rod(), ps.laws.bilinear_hertz(E=209e9))
    >>> state = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}
    >>> gradient = critical_force_gradient(CriticalForceFinder(simulator), state, ["mu"])
    >>> gradient["mu"].value < 0
    True
    """
    refuse_unknown("method", method, METHODS, finder.where)
    setting = VariedCase(finder, state, parameters or {})
    for name in names:
        setting.value(name)  # rejects unknown names
    centre = finder.find(state, parameters, border=border, check_tolerance=False)
    if method == "differences":
        return {name: _difference(setting, centre, name) for name in names}
    near, far = (_implicit(setting, centre, tuple(names), below) for below in BELOW)
    return {
        name: ForceDerivative(name, float(a), float(abs(a - b)), method)
        for name, a, b in zip(names, near, far, strict=True)
    }


def _difference(setting: VariedCase, centre: CriticalForce, name: str) -> ForceDerivative:
    finder = setting.finder

    def force(value: float) -> float:
        at = setting.with_value(name, value)
        return finder.find(
            *at, border=centre.border, guess=centre.value, width=0.02, check_tolerance=False
        ).value

    value = setting.value(name)
    # A speed of 0 is varied on the scale on which it decides.
    speeds = finder.simulator.mechanism.outline.velocity_names
    h = STEP * (abs(value) or (centre.sliding.barrier_speed if name in speeds else 1.0))
    odd = [force(value + k * h) - force(value - k * h) for k in (1, 2, 3)]
    fourth = (8 * odd[0] - odd[1]) / (12 * h)
    sixth = (45 * odd[0] - 9 * odd[1] + odd[2]) / (60 * h)
    return ForceDerivative(name, sixth, abs(sixth - fourth), "differences")


def _implicit(
    setting: VariedCase, centre: CriticalForce, names: tuple[str, ...], below: float
) -> Array:
    finder, end = setting.finder, _ENDS[centre.border]
    sensitivities = finder.simulator.sensitivities(
        setting.state,
        (INITIAL_FORCE, *names),
        parameters=setting.parameters,
        initial_force=centre.value * (1 - below),
        t_end=finder.t_end,
        until=(end, "slip_stop"),
        rtol=RTOL,
        record="events",
    )
    run, singular = sensitivities.trajectory, sensitivities.singular
    # What follows in the same instant, such as the gap's opening, is recorded after it.
    kinds = [e.kind for e in run.events if e.time == run.final_time]
    if end not in kinds or "slip_stop" in kinds or singular is not None:
        ending = ", ".join(kinds) or run.stop_reason.label
        if singular is not None:
            ending = f"{singular.event.kind} without a derivative"
        raise InputError(
            f"{finder.where}: just below {centre.value:g} N the motion ends in {ending}, "
            f"need {end} with one. "
            "Fix: use method='differences'."
        )
    slip = finder.simulator.contact.rows[0].slip
    row = sensitivities.final_jacobian[run.state_names.index(slip)]
    gradient: Array = -row[1:] / row[0]
    return gradient
