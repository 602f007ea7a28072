"""Singular limits and reverse chatter detected in a rigid run."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from painleve_sym.equality import Compared


class LimitKind(enum.StrEnum):
    """Kind of approach of a slip to A = 0.

    With r and F* of `SingularPoint` at the limit, and F the force where the run stopped.
    """

    DYNAMIC_JAM = "dynamic_jam"
    """0 < r < 1 and F > F*: A and B reach 0 together, the force diverges, its impulse does not."""
    BOUNDED = "bounded"
    """r ≥ 1 and F* > 0: A and B reach 0 together with the finite force F*."""
    LIFTOFF = "liftoff"
    """F falls to 0 before A does, since F < F* with r < 1, or F* < 0 with r ≥ 1: the contact opens,
    so close to A = B = 0 that the run stopped before."""
    STOP = "stop"
    """r ≤ 0: the impulse up to A = 0 would be infinite, so that the slip stops before."""


@dataclass(frozen=True, eq=False)
class SingularLimit(Compared):
    """Limit of a slip that meets A = 0, extrapolated from the state where the run stopped.

    Attributes
    ----------
    kind : LimitKind
    time : float
        t*; s.
    state : dict of str to float
        At t*: coordinates, velocities and further states. The velocities have a limit since the
        impulse is finite; for ``STOP`` this is the state where the run stopped.
    A, B : float
        At that state; 0 up to the error of the extrapolation, except for ``STOP``; 1/kg, m/s².
    eigenvalues : tuple of float
        α and −β₁ at that state; 1/(kg s).
    eigenvalue_ratio : float
        r = −β₁/α; 1.
    force_exponent : float
        γ = 1 − r; the force grows like (t* − t)^(−γ); 1.
    measured_exponent : float or None
        The same from forces of the run at three times before t*; None where it has too few.
    bounded_force : float
        F* = −β₀/(α + β₁); N.
    """

    kind: LimitKind
    time: float
    state: dict[str, float]
    A: float
    B: float
    eigenvalues: tuple[float, float]
    eigenvalue_ratio: float
    force_exponent: float
    measured_exponent: float | None
    bounded_force: float


@dataclass(frozen=True, eq=False)
class ReverseChatter(Compared):
    """Successive bounces of a rigid motion that grow where growth is expected.

    The times are those of the first and the last of these touchdowns, s; `bounces` is their number.
    `ratio` is the geometric mean of the ratios of successive approach speeds, `expected_ratio` that
    of bounces of frozen coefficients at the first touchdown (see `Chatter`).
    """

    start_time: float
    end_time: float
    bounces: int
    ratio: float
    expected_ratio: float
