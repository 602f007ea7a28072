"""The numbers that state the problem of one contact, checked once for every kind of contact."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from painleve_sym.checks import checked_number
from painleve_sym.complementarity.faces import FloatArray
from painleve_sym.errors import InputError

_ROUNDING = 4 * float(np.finfo(float).eps)  # two products and their difference, each rounded once
_SINGULAR = 1e-12  # det W of a deficient mobility, after the roundings of a mass-matrix inverse


@dataclass(frozen=True)
class ContactData:
    """Hold one contact's mobility, free accelerations, friction and slip velocity.

    The units are those of the parameters of `ContactProblem`: ``a_n = W_nn F_n + W_nt F_t + b_n``
    and ``a_t = W_nt F_n + W_tt F_t + b_t``, tangential quantities counted along v_t.
    """

    W_nn: float
    W_nt: float
    W_tt: float
    b_n: float
    b_t: float
    mu: float
    slip_velocity: float

    def __post_init__(self) -> None:
        """Check every entry and keep them as plain floats."""
        faults: list[str] = []
        for field in fields(self):
            value, fault = checked_number(getattr(self, field.name), field.name)
            object.__setattr__(self, field.name, value)
            if fault:
                faults.append(f"{fault} Fix: check the state it was evaluated at.")
        faults = faults or self._physical_faults()
        if faults:
            where = type(self).__name__
            raise InputError(f"{where} cannot be stated, " + " Also, ".join(faults))

    def _physical_faults(self) -> list[str]:
        """Return a sentence for each entry that no mechanism can have."""
        faults: list[str] = []
        if self.mu < 0:
            faults.append(
                f"mu: got {self.mu!r}, need mu >= 0. Fix: give the direction by slip_velocity."
            )
        product = self.W_nn * self.W_tt
        if min(self.W_nn, self.W_tt) < 0 or self.W_nt**2 > product * (1 + _SINGULAR):
            faults.append(
                f"mobility: got W_nn, W_nt, W_tt = {self.W_nn!r}, {self.W_nt!r}, {self.W_tt!r}, "
                "need W_nn >= 0, W_tt >= 0 and W_nt**2 <= W_nn W_tt. "
                "Fix: compute it as J M^-1 J' with a positive definite mass matrix M."
            )
        return faults

    @property
    def slip_direction(self) -> int:
        """Return the sign of v_t: -1, 0 or +1."""
        return (self.slip_velocity > 0) - (self.slip_velocity < 0)


def rounded_difference(a: npt.ArrayLike, b: npt.ArrayLike) -> FloatArray:
    """Return ``a - b`` with differences within rounding of their two terms as exactly 0."""
    first, second = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    value = first - second
    return np.where(np.abs(value) <= _ROUNDING * (np.abs(first) + np.abs(second)), 0.0, value)
