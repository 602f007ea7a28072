"""Small bounces near a state of contact: whether they die out or grow."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from painleve_sym.equality import Compared
from painleve_sym.laws.restitution import Measure, restitution_law
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.plain_data import to_plain
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.impact.one_contact import ImpactEnd, solve_impact

REVERSE_CHATTER = "reverse_chatter"
"""Name of the way out of contact by growing bounces, beside the modes of the contact problem."""

_BOUNCES = 60
"""Bounces within which v_t/v_n has converged or diverged: both are geometric."""

_SETTLED, _RUN_OFF = 1e-14, 1e6
"""Relative change of v_t/v_n that is rounding; size at which no later impact can stop the slip."""

_STICKING = (ImpactClass.C_STICKING, ImpactClass.R_STICKING)


@dataclass(frozen=True, eq=False)
class Chatter(Compared):
    """Sequence of small bounces near a contact at rest (v_t = 0), with W, b_t, b_n frozen.

    Attributes
    ----------
    ratio : float
        ρ of successive bounces; 1. Below 1 they die out (chatter), above they grow.
    case : ImpactClass
        Of every impact.
    restitution : str
        Name of the law.
    e : float
        Coefficient of restitution.
    threshold : float or None
        The coefficient of restitution with ρ = 1; None where ρ < 1 for every e < 1.
    """

    ratio: float
    case: ImpactClass
    restitution: str
    e: float
    threshold: float | None

    @property
    def reverse(self) -> bool:
        """Whether bounces grow: the contact can leave in reverse chatter."""
        return self.ratio > 1

    def to_dict(self) -> dict[str, Any]:
        """Return plain data with the documented keys."""
        return {**to_plain(self), "reverse": self.reverse}


def chatter(
    problem: ContactProblem, restitution: str = "energetic", e: float = 0.75
) -> Chatter | None:
    """Return how small bounces near a contact follow each other when it does not slip.

    Parameters
    ----------
    problem : ContactProblem
        Of one contact: W, b_t, b_n and μ; its slip velocity counts as 0.
    restitution : {"energetic", "poisson", "newton"}
    e : float
        Coefficient of restitution of that law, in [0, 1].

    Returns
    -------
    Chatter or None
        None where b_n ≥ 0, so that a bounce does not come back, where impacts jam, and for a
        contact that cannot open.

    References
    ----------
    Nordmark, Dankowicz & Champneys (2011); docs/derivations/reverse_chatter.md has closed forms.
    """
    if problem.b_n >= 0 or problem.bilateral[0]:
        return None
    cycle = _cycle(problem, restitution, e)
    if cycle is None:
        return None
    ratio, case = cycle
    return Chatter(ratio, case, restitution, e, _threshold(problem, restitution))


def _cycle(problem: ContactProblem, restitution: str, e: float) -> tuple[float, ImpactClass] | None:
    """Return the ratio of bounces and their class, once v_t/v_n repeats itself."""
    W = problem.W.tolist()
    fall = -2 * problem.b_t / problem.b_n
    arriving = fall
    for _ in range(_BOUNCES):
        impact = solve_impact(W, problem.mu.item(), (-1.0, arriving), restitution, e)
        v_n, v_t = impact.velocity
        if impact.end is ImpactEnd.JAM:
            return None
        if v_n == 0 or impact.case in _STICKING:  # after sticking every flight is the same
            break
        last, arriving = arriving, v_t / v_n + fall
        if abs(arriving - last) <= _SETTLED * abs(last) or abs(arriving) > _RUN_OFF:
            break
    return v_n, impact.case


def _threshold(problem: ContactProblem, restitution: str) -> float | None:
    """Return the e with ρ = 1; of a law that measures work ρ² is affine in its share, else ρ is."""
    elastic = _cycle(problem, restitution, 1.0)
    if elastic is None or not elastic[0] > 1 or elastic[1] not in _STICKING:
        return None
    law = restitution_law(restitution)
    power = 2 if law.measure is Measure.WORK else 1
    excess = elastic[0] ** power - 1
    if elastic[1] is ImpactClass.C_STICKING:
        slope = elastic[0] ** power
    else:
        slope = problem.A_stick / problem.A_slip(1 if problem.b_t > 0 else -1)
    return math.pow(1 - excess / slope, 1 / law.power)
