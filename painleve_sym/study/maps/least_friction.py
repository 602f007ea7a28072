"""The smallest critical friction of a closed contact as a number, where no closed form tells it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.optimize import minimize

from painleve_sym.arrays import Array
from painleve_sym.blas_threads import one_blas_thread
from painleve_sym.codegen.bridge import Translator
from painleve_sym.errors import InputError
from painleve_sym.mechanics.mechanism import Mechanism

_STARTS = 24
# How exactly the gap of an answer is 0, in m, and how far it may leave the domain.
_CLOSED = 1e-9
# Smaller values are those of a limit at which W_nn = 0.
_VANISHED = 1e-6


@dataclass(frozen=True)
class LeastFriction:
    """The smallest W_nn/|W_nt| over the configurations in contact; 0 where it has no bound."""

    value: float
    configuration: Mapping[str, float]


class _Smooth:
    """A vector of expressions and its Jacobian, in numbers."""

    def __init__(self, rows: ca.SX, x: ca.SX) -> None:
        self._both = ca.Function("f", [x], [rows, ca.jacobian(rows, x)])

    def value(self, at: Array) -> Array:
        return np.array(self._both(at)[0]).ravel()

    def slope(self, at: Array) -> Array:
        return np.array(self._both(at)[1])


@one_blas_thread()
def least_critical_friction(
    mechanism: Mechanism, parameters: Mapping[str, float] | None = None
) -> LeastFriction:
    """Return the smallest critical friction of one contact over all its closed configurations.

    A local search from many starts: a bound from above, which in one or two angles is the minimum.
    Where the time occurs, it is that of the mechanism's start. InputError for unknown or invalid
    parameters, and where no configuration in contact has W_nt ≠ 0.
    """
    where = f"least critical friction of {mechanism.name!r}"
    values = mechanism.at(None, parameters, where=where).parameters
    c, q = mechanism.coefficients, mechanism.system.q
    x = ca.SX.sym("q", len(q))
    table = {s: x[i] for i, s in enumerate(q)}
    table |= {p.symbol: ca.SX(values[p.name]) for p in mechanism.system.parameters}
    table |= {t: ca.SX(mechanism.start.get(t.name, 0.0)) for t in mechanism.system.clock}
    translate = Translator(table)
    W_nn, W_nt, gap = (translate.vector([e]) for e in (c.W_nn, c.W_nt, mechanism.contact.gap))
    margins = translate.vector([b.margin for b in mechanism.domain] or [1])
    # The logarithm of the square is smooth but where the friction is infinite or 0.
    goal = ca.log(W_nn**2) - ca.log(W_nt**2)
    aim, closed, inside = (_Smooth(e, x) for e in (goal, gap, margins))
    limits = [
        {"type": kind, "fun": f.value, "jac": f.slope}
        for kind, f in (("eq", closed), ("ineq", inside))
    ]
    start = np.array([mechanism.start.get(s.name, 0.0) for s in q])
    rng = np.random.default_rng(0)
    best, place = np.inf, start
    for _ in range(_STARTS):
        guess = start + rng.uniform(-np.pi, np.pi, len(q))
        with np.errstate(all="ignore"):
            end = minimize(
                lambda at: float(aim.value(at)[0]),
                guess,
                jac=lambda at: aim.slope(at)[0],
                method="SLSQP",
                constraints=limits,
                options={"ftol": 1e-14, "maxiter": 200},
            ).x
        if abs(closed.value(end)[0]) > _CLOSED or np.any(inside.value(end) < -_CLOSED):
            continue
        reached = float(np.exp(aim.value(end)[0] / 2))
        if reached < best:
            best, place = reached, end
    if not np.isfinite(best):
        raise InputError(
            f"{where}: no configuration is in contact. Fix: check the gap and the domain."
        )
    names = {s.name: float(v) for s, v in zip(q, place, strict=True)}
    return LeastFriction(0.0 if best < _VANISHED else best, names)
