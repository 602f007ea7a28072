"""Notice of an impact that adds energy to the bodies, which friction and restitution alone cannot.

Newton's law can do so; the energetic and Poisson's law never do.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

LEAST_GAIN = 1e-9
"""Of the kinetic energy: a smaller growth counts as rounding."""


def gains(gain: float, energy: float) -> bool:
    """Return whether `gain` is more than the rounding of a kinetic energy; both in J."""
    return gain > LEAST_GAIN * energy


def gain_notice(
    gain: float, energy: float, law: str, contacts: Sequence[str] = (), time: float | None = None
) -> str:
    """Return one sentence about the energy that an impact adds; empty where it adds none.

    The gain is the work of the contact impulses as seen from the surfaces, the energy the kinetic
    one before the impact; J. The law is that of restitution; the time is in s.
    """
    if not gains(gain, energy):
        return ""
    at = "" if time is None else f"at t = {time:.9g} s "
    of = f" of contact{'s' * (len(contacts) > 1)} {' and '.join(contacts)}" if contacts else ""
    share = f", {100 * gain / energy:.3g} % of the kinetic energy before it" if energy > 0 else ""
    text = f"{at}the impact{of} adds {gain:.3g} J{share}, by the restitution law {law}."
    return text[0].upper() + text[1:]


def least_energy_notice(gain: float, W: ArrayLike, velocity: ArrayLike, law: str) -> str:
    """Return `gain_notice` by ½ vᵀ W⁺ v, the least kinetic energy with these contact velocities; J.

    Shapes are (2 n, 2 n), 1/kg, and (2 n,), m/s.
    """
    if gain <= 0:
        return ""
    W, v = np.asarray(W, dtype=float), np.asarray(velocity, dtype=float)
    energy = float(v @ np.linalg.pinv(W, rcond=1e-12, hermitian=True) @ v) / 2
    return gain_notice(gain, energy, law)
