"""DOP853: the Runge–Kutta method of order 8(5,3) with dense output of order 7, as data.

References
----------
Prince & Dormand (1981); Hairer, Nørsett & Wanner (1993), II.5, II.6 for the dense output, and the
accompanying code DOP853, as SciPy has it.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from typing import NamedTuple

DENSE_STAGES = 16
"""12 stages of the step, the field at its end, and three more for the dense output."""


class Tableau(NamedTuple):
    """Coefficients of the method; weights without those that are 0, by stage.

    Attributes
    ----------
    nodes : tuple of float
        c_i, one per stage of the dense method.
    stage_weights : tuple of dict
        a_ij by stage; row 12 holds the weights b of the step itself.
    error_5, error_3 : dict of int to float
        Weights of the error estimates of order five and three.
    dense_weights : tuple of dict
        d_ij of the last four rows of the dense polynomial.
    """

    nodes: tuple[float, ...]
    stage_weights: tuple[dict[int, float], ...]
    error_5: dict[int, float]
    error_3: dict[int, float]
    dense_weights: tuple[dict[int, float], ...]


@functools.cache
def dop853() -> Tableau:
    """Return the coefficients of DOP853."""
    # Imported here: SciPy takes a third of a second, and most commands generate no code.
    from scipy.integrate import DOP853

    return Tableau(
        nodes=tuple(map(float, (*DOP853.C, 1.0, *DOP853.C_EXTRA))),
        stage_weights=tuple(map(_weights, (*DOP853.A, DOP853.B, *DOP853.A_EXTRA))),
        error_5=_weights(DOP853.E5),
        error_3=_weights(DOP853.E3),
        dense_weights=tuple(map(_weights, DOP853.D)),
    )


def _weights(row: Iterable[float]) -> dict[int, float]:
    return {i: float(weight) for i, weight in enumerate(row) if weight != 0}
