"""Result of a fit: estimates, confidence intervals, noise and the fitted model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from painleve_sym.arrays import Array
from painleve_sym.equality import Compared
from painleve_sym.plain_data import plain_fields


@dataclass(frozen=True, repr=False, eq=False)
class FitResult(Compared):
    """Estimates with their confidence intervals.

    Attributes
    ----------
    names, units : tuple of str
        Of the estimated quantities.
    start, estimate, standard_error : ndarray, shape (k,)
    interval : ndarray, shape (k, 2)
        estimate ± t·standard_error, with Student's t for `level` and `freedom`; where the noise is
        given, with the quantile of the normal distribution.
    level : float
    freedom : int
        Measured values minus estimated quantities.
    correlation : ndarray, shape (k, k)
    noise : mapping of str to float
        Standard deviation of each measured quantity: as given, or estimated from its residuals.
    noise_given : bool
    measured, model : mapping of str to ndarray, shape (n,)
        Data (nan where none) and the fitted model at the same rows.
    times : ndarray, shape (n,) or None
    evaluations : int
        Runs of the whole data set with derivatives.
    condition : float
        Of the scaled Jacobian.
    message : str
        Why the least squares ended.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> columns = {"start y": "drop", "end y_dot": "sqrt(2*g*rebound)"}
    >>> form = {"skip": 2, "separator": ";", "decimal": ",", "columns": columns}
    >>> heights = "examples/studies/fit/rebounds.csv"
    >>> ball = ps.load_mechanism("examples/mechanisms/dropped-ball.toml")
    >>> result = ps.fit(ball, "rigid", heights, "e_energetic", csv=form)
    >>> result
    FitResult: e_energetic = 0.8832583 ± 0.0026
    >>> result.interval.round(4).tolist()
    [[0.8779, 0.8886]]
    """

    def __repr__(self) -> str:
        """Return estimates with their standard errors in one line."""
        rows = zip(self.names, self.estimate.tolist(), self.standard_error.tolist(), strict=True)
        return "FitResult: " + ", ".join(f"{n} = {v:.7g} ± {s:.2g}" for n, v, s in rows)

    names: tuple[str, ...]
    units: tuple[str, ...]
    start: Array
    estimate: Array
    standard_error: Array
    interval: Array
    level: float
    freedom: int
    correlation: Array
    noise: Mapping[str, float]
    noise_given: bool
    measured: Mapping[str, Array]
    model: Mapping[str, Array]
    times: Array | None
    evaluations: int
    condition: float
    message: str

    def to_dict(self) -> dict[str, Any]:
        """Return the result as plain data."""
        return {
            "estimates": [
                {
                    "name": name,
                    "unit": unit,
                    "start": float(self.start[i]),
                    "estimate": float(self.estimate[i]),
                    "standard_error": float(self.standard_error[i]),
                    "interval": self.interval[i].tolist(),
                }
                for i, (name, unit) in enumerate(zip(self.names, self.units, strict=True))
            ],
            **plain_fields(self, "level", "freedom", "correlation", "noise", "noise_given"),
            **plain_fields(self, "evaluations", "condition", "message"),
        }
