"""Friction of a contact: an interval of forces in the plane, a disc of them in space.

Coulomb's law is the same in both: the friction force has at most the size μ F_n, and while the
contact slides it has that size and opposes the slip. In its plane of slip a sliding disc is an
interval, and so both have the same linear pieces.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from painleve_sym.checks import number


def unit_vector(vector: Sequence[float]) -> tuple[float, ...]:
    """Return the unit vector along one, such as a slip velocity; empty where that is 0.

    >>> unit_vector((0.0, -2.0))
    (0.0, -1.0)
    """
    largest = max(map(abs, vector), default=0.0)
    if largest == 0:
        return ()
    parts = [v / largest for v in vector]  # neither overflow nor underflow in their squares
    length = math.hypot(*parts)
    return tuple([v / length for v in parts])


@dataclass(frozen=True)
class FrictionSet:
    """All friction forces of a contact of normal force 1: those of size μ at most.

    Attributes
    ----------
    mu : float
        Friction coefficient μ, >= 0.
    """

    mu: float
    n_tangents: ClassVar[int]

    def __post_init__(self) -> None:
        """Check the coefficient.

        Raises
        ------
        InputError
            For a coefficient that is negative or not finite.
        """
        name = type(self).__name__
        object.__setattr__(self, "mu", number(self.mu, "mu", where=name, lower=0.0))


class Interval(FrictionSet):
    """The friction of a planar contact: from −μ F_n to μ F_n along its one tangent.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> ps.Interval(0.3).mu
    0.3
    """

    n_tangents: ClassVar[int] = 1


class Brake(FrictionSet):
    """Dry friction of a constant size along one row of its own, such as that of a joint.

    Its force is at most `limit`, whatever presses elsewhere, and opposes the slip. It takes one row
    of W, without a normal one, and stands alone among the contacts of a problem.

    Attributes
    ----------
    mu : float
        The largest force; N, or N m where the row is an angle. `limit` is the same.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> joint = ps.ContactProblem([[2.0]], [3.0], [ps.Brake(1.0)], [0.0])
    >>> [solution] = joint.solutions()
    >>> solution.mode.value, solution.tangential_force, solution.tangential_acceleration
    ('slip_pos', -1.0, 1.0)
    """

    n_tangents: ClassVar[int] = 1

    @property
    def limit(self) -> float:
        """The largest force."""
        return self.mu


class Disc(FrictionSet):
    """The isotropic friction of a contact in space: a disc of radius μ F_n in its tangent plane.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> ps.Disc(0.3).n_tangents
    2
    """

    n_tangents: ClassVar[int] = 2
