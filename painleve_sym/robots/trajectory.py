"""The risk of a robot's contact along a logged motion: joint positions, velocities and torques."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array
from painleve_sym.checks import number
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError
from painleve_sym.plain_data import finite
from painleve_sym.problem.one_contact import contact as contact_answer
from painleve_sym.problem.solution import ContactCase
from painleve_sym.robots.motion_log import MotionLog
from painleve_sym.robots.robot_contact import RobotContact

FLIGHT, IMPACT, UNANSWERED = "flight", "impact", "unanswered"
"""Cases of a contact that is open, that approaches, and that cannot move so."""
REST_SPEED = 0.02
"""Speed of a contact that counts as rest in a log by default, m/s."""


@dataclass(frozen=True, eq=False)
class RiskTrajectory(Compared):
    """The risk of a contact along a motion of n samples.

    Attributes
    ----------
    t : ndarray, shape (n,)
        s.
    mu : float or None
    mu_P : ndarray, shape (n,)
        Infinite, or nan, as `RobotContact.thresholds` has it.
    margin : ndarray, shape (n,) or None
        μ_P/μ: below 1 some direction of slip is at risk. None without a friction coefficient.
    closed : ndarray of bool, shape (n,)
        Whether the contact touches.
    case : tuple of str
        At each sample ``flight`` where the contact is open, ``impact`` where it approaches,
        ``liftoff`` also where it touches by a rule and leaves, ``unanswered`` where the joints
        cannot move it so, else the case of the rigid contact problem; empty without velocities,
        torques or friction.
    rest : float
        Speed along the normal, and of slip, that counts as 0; m/s.
    notices : tuple of str
    """

    t: Array
    mu: float | None
    mu_P: Array
    margin: Array | None
    closed: NDArray[np.bool_]
    case: tuple[str, ...]
    rest: float
    notices: tuple[str, ...] = ()

    @property
    def at_risk(self) -> NDArray[np.bool_]:
        """Whether the contact touches with a margin below 1, at each sample."""
        if self.margin is None:
            return np.zeros(len(self.t), bool)
        with np.errstate(invalid="ignore"):
            return np.asarray(self.closed & (self.margin < 1))

    @property
    def share_closed(self) -> float:
        """Part of the time in which the contact touches."""
        return float(time_weights(self.t)[self.closed].sum())

    @property
    def share_at_risk(self) -> float | None:
        """Part of the time in which the contact touches with a margin below 1; None without μ."""
        if self.margin is None:
            return None
        return float(time_weights(self.t)[self.at_risk].sum())

    @property
    def least(self) -> int | None:
        """Touching sample with the least μ_P; None without any."""
        kept = np.where(self.closed, self.mu_P, np.nan)
        return None if np.isnan(kept).all() else int(np.nanargmin(kept))

    @property
    def case_shares(self) -> dict[str, float]:
        """Part of the time in each case."""
        shares: Counter[str] = Counter()
        for case, weight in zip(self.case, time_weights(self.t).tolist(), strict=False):
            shares[case] += weight
        return dict(shares)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data, the samples included; infinite numbers are None."""
        least = self.least
        return {
            "samples": len(self.t),
            "rest": self.rest,
            "share_closed": self.share_closed,
            "least_mu_P": None if least is None else finite(float(self.mu_P[least])),
            "time_of_least": None if least is None else float(self.t[least]),
            "share_at_risk": self.share_at_risk,
            "cases": self.case_shares,
            "t": self.t.tolist(),
            "closed": self.closed.tolist(),
            "mu_P": [finite(v) for v in self.mu_P.tolist()],
            "margin": None if self.margin is None else [finite(v) for v in self.margin.tolist()],
            "case": list(self.case),
            "notices": list(self.notices),
        }


def time_weights(t: Array) -> Array:
    """Return the part of the whole time that each sample stands for: half of both intervals."""
    if len(t) < 2:
        return np.ones(len(t))
    steps = np.diff(t)
    weights = np.concatenate([[0.0], steps]) + np.concatenate([steps, [0.0]])
    return np.asarray(weights / weights.sum())


def risk_along(
    contact: RobotContact, motion: MotionLog, mu: float | None = None, rest: float = REST_SPEED
) -> RiskTrajectory:
    """Return the risk of a contact along a motion.

    Where nothing in the motion says when the contact touches, it does so while its velocity along
    the normal is at most `rest`, and always where there are no velocities.

    Parameters
    ----------
    contact : RobotContact
        Whose values hold for what the motion does not give.
    motion : Motion
        As `read_motion` returns it.
    mu : float, optional
        Friction coefficient, >= 0.
    rest : float
        Speed of the contact along the normal, and of slip, that counts as 0; m/s, >= 0.
    """
    if mu is not None:
        mu = number(mu, "mu", where="trajectory", lower=0.0)
    rest = number(rest, "rest", where="trajectory", lower=0.0)
    values = {**contact.values, **motion.values}
    values["mu"] = np.full(len(motion.t), 0.0 if mu is None else mu)
    numbers = contact.numbers_at(values)
    mu_P = contact.thresholds_of(numbers)
    v = np.concatenate([numbers.gap_rate[:1], numbers.slip_velocity[0]])
    slow = np.abs(v[0]) <= rest
    closed = slow if motion.closed is None else motion.closed
    margin = None if not mu else mu_P / mu
    case: tuple[str, ...] = ()
    if mu and motion.moves:
        W, b = contact.in_question(numbers)
        # Where a rule says that it touches, a contact that rises leaves; else it is open already.
        leaving = FLIGHT if motion.closed is None else ContactCase.LIFTOFF.value
        opened = np.zeros(len(motion.t), bool) if motion.closed is None else ~motion.closed
        case = tuple(
            _moving_case(bool(opened[k]), float(v[0, k]), rest, leaving)
            or _closed_case(W[..., k], b[:, k], mu, v[1:, k], rest)
            for k in range(len(motion.t))
        )
    notices = motion.notices + _unanswered(motion.t, case)
    return RiskTrajectory(motion.t, mu, mu_P, margin, closed, case, rest, notices)


def _moving_case(opened: bool, rate: float, rest: float, leaving: str) -> str:
    """Return the case of a contact that is open, leaves or approaches; empty for others."""
    if opened:
        return FLIGHT
    if rate > rest:
        return leaving
    return IMPACT if rate < -rest else ""


def _closed_case(W: Array, b: Array, mu: float, slip: Array, rest: float) -> str:
    """Return the case of a closed contact, whose slip below a speed is rest."""
    moving = slip.tolist() if math.hypot(*slip) > rest else [0.0, 0.0]
    try:
        return str(contact_answer(W, b, mu, moving).case.value)
    except InputError:
        return UNANSWERED


def _unanswered(t: Array, case: tuple[str, ...]) -> tuple[str, ...]:
    """Return a notice where the contact cannot move as the log says, or not along its normal."""
    if UNANSWERED not in case:
        return ()
    return (
        f"{case.count(UNANSWERED)} samples have no contact problem, the first one at t = "
        f"{t[case.index(UNANSWERED)]:g} s: the joints cannot move the contact along its normal, or "
        "along its slip.",
    )
