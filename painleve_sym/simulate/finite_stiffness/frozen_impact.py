"""Impacts with frozen coefficients and a force K δⁿ: compiled, over arrays."""

from __future__ import annotations

import ctypes
import enum
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.codegen.compile import load
from painleve_sym.errors import CompilerMissing, InputError, PainleveWarning, unknown_name

ENGINES = ("auto", "compiled", "python")
COEFFICIENTS = ("W_nn", "W_nt", "W_tt", "b_n", "b_t")
"""What the contact feels: g̈ = W_nn F_n + W_nt F_t + b_n, v̇_t = W_nt F_n + W_tt F_t + b_t."""
AFTER = tuple(f"{name}_after" for name in COEFFICIENTS)
"""The same once the slip has stopped; by default those of the start."""
OTHERS = ("mu", "K", "n", "e", "slip_velocity", "compression", "compression_rate")
INPUTS = (*COEFFICIENTS, *AFTER, *OTHERS)
DEFAULTS = {"e": 1.0, "compression": 0.0, "compression_rate": 0.0}

PHASES = 8
"""Most phases of one impact: slip, stick, slip back, each loading and unloading."""
HEAD = (
    *("end", "methods", "phases", "slip_velocity", "normal_velocity"),
    *("normal_impulse", "tangential_impulse", "duration", "largest_compression"),
)
PHASE = (
    *("slip", "loading", "duration", "normal_impulse", "tangential_impulse"),
    *("compression", "compression_rate", "slip_velocity", "impulse_time"),
)
ORDERS = (10, 24)
"""Nodes of the two Gauss–Legendre rules, for short panels and for long ones."""


class FrozenEnd(enum.Enum):
    """How an impact with frozen coefficients ends.

    SEPARATION
        The force is zero and the contact opens.
    STAYS
        The motion turns before the force is zero: the contact stays closed, there is no jump.
    NO_IMPACT
        From the start the contact opens, or stays at rest.
    NO_END
        The slip never stops and the compression grows for ever.
    FAILED
        Numbers left the range of floating point.
    """

    SEPARATION = 0
    STAYS = 1
    NO_IMPACT = 2
    NO_END = 3
    FAILED = 4


class Method(enum.Flag):
    """How time and impulse of the phases were found.

    HYPERGEOMETRIC
        From rest at zero compression: Gauss hypergeometric functions.
    ELEMENTARY
        The same for n = 1, where they are an inverse hyperbolic sine.
    QUADRATURE
        The energy integral has three terms or more: Gauss–Legendre panels, to round-off.
    """

    NONE = 0
    HYPERGEOMETRIC = 1
    ELEMENTARY = 2
    QUADRATURE = 4

    @property
    def text(self) -> str:
        """Names of the methods used, joined by a comma."""
        return ", ".join(str(m.name).lower() for m in type(self) if m in self) or "none"


@dataclass(frozen=True)
class FrozenImpacts:
    """Impacts with frozen coefficients, arrays of the shape of the cases.

    Attributes
    ----------
    head : mapping of str to ndarray
        `HEAD`: ``end`` (number of a `FrozenEnd`), ``methods`` (of a `Method`), ``phases`` (how
        many), v_t and v_n at the end (m/s), impulses (N s), duration (s), largest compression (m).
    phase : mapping of str to ndarray, shape (*cases, PHASES)
        `PHASE`: ``slip`` (−1, 0, +1), ``loading`` (1 or 0), duration, impulses, and δ, δ̇, v_t at
        the end of the phase; ``impulse_time`` is ∫P_n dt over it. nan after the last phase.
    """

    head: Mapping[str, Array]
    phase: Mapping[str, Array]

    @property
    def ends(self) -> list[FrozenEnd]:
        """How each impact ends, flat."""
        return [FrozenEnd(int(code)) for code in np.ravel(self.head["end"])]


class FrozenImpactSolver:
    """The impact of one contact with frozen coefficients and a force K δⁿ.

    δ̈ = −(A F + B) in slip and in sticking, A and B frozen but not dropped. After the largest
    compression F = K ((δ − δ_p)/e²)ⁿ with δ_p = (1 − e²) δ_max; e = 1 is the elastic law.

    Parameters
    ----------
    engine : {"auto", "compiled", "python"}
        ``auto``: compiled C, or SciPy (slower) with a notice where there is no compiler.

    Raises
    ------
    CompilerMissing
        ``compiled`` was asked for and there is none.
    """

    def __init__(self, engine: str = "auto") -> None:
        if engine not in ENGINES:
            raise InputError(unknown_name("engine", engine, ENGINES))
        self._library = None if engine == "python" else _library(engine)
        self.engine = "python" if self._library is None else "compiled"

    def __call__(self, **values: ArrayLike) -> FrozenImpacts:
        """Return the impacts of the cases.

        Parameters
        ----------
        **values : float or ndarray
            `INPUTS`, broadcast against each other. W in 1/kg, b in m/s², K in N/mⁿ, n > 0,
            0 ≤ e ≤ 1, v_t in m/s, δ ≥ 0 in m, δ̇ = −v_n in m/s. Absent: e = 1, δ = δ̇ = 0, and
            the coefficients after the slip stops are those before it.

        Raises
        ------
        InputError
            Unknown or absent names, shapes that do not fit, numbers out of range.
        """
        arrays = _checked(values)
        shape = np.broadcast_shapes(*(a.shape for a in arrays))
        count = int(np.prod(shape, dtype=np.int64))
        flat = [
            a if a.ndim == 0 else np.ascontiguousarray(np.broadcast_to(a, shape)).reshape(-1)
            for a in arrays
        ]
        head = np.empty((count, len(HEAD)))
        rows = np.empty((count, PHASES, len(PHASE)))
        if self._library is not None:
            addresses = (ctypes.c_void_p * len(flat))(*(a.ctypes.data for a in flat))
            strides = (ctypes.c_long * len(flat))(*(int(a.ndim > 0) for a in flat))
            self._library.ps_frozen_impacts(
                count, addresses, strides, head.ctypes.data, rows.ctypes.data
            )
        else:
            from painleve_sym.simulate.finite_stiffness.frozen_python import solve

            for k in range(count):
                case = [float(a if a.ndim == 0 else a[k]) for a in flat]
                head[k], rows[k] = solve(case)
        return FrozenImpacts(
            {name: head[:, i].reshape(shape) for i, name in enumerate(HEAD)},
            {name: rows[:, :, i].reshape(*shape, PHASES) for i, name in enumerate(PHASE)},
        )


def _checked(values: Mapping[str, ArrayLike]) -> list[Array]:
    for name in values:
        if name not in INPUTS:
            raise InputError(f"frozen impact: {unknown_name('input', name, INPUTS)}")
    given = {**DEFAULTS, **values}
    for name, first in zip(AFTER, COEFFICIENTS, strict=True):
        if first in given:
            given.setdefault(name, given[first])
    absent = [name for name in INPUTS if name not in given]
    if absent:
        raise InputError(f"frozen impact: no value of {', '.join(absent)}. Fix: give it.")
    arrays = [np.asarray(given[name], dtype=np.float64) for name in INPUTS]
    faults = [f for n, a in zip(INPUTS, arrays, strict=True) for f in _faults(n, a)]
    try:
        np.broadcast_shapes(*(a.shape for a in arrays))
    except ValueError as error:
        faults.append(f"{error}.")
    if faults:
        raise InputError("frozen impact: " + " ".join(faults) + " Fix: give such numbers.")
    return arrays


def _faults(name: str, array: Array) -> list[str]:
    faults = [] if np.all(np.isfinite(array)) else [f"{name}: need finite numbers."]
    if name in _POSITIVE and not np.all(array > 0):
        faults.append(f"{name}: need numbers > 0.")
    if name in ("mu", "compression") and not np.all(array >= 0):
        faults.append(f"{name}: need numbers >= 0.")
    if name == "e" and not np.all((array >= 0) & (array <= 1)):
        faults.append(f"{name}: need numbers in [0, 1].")
    return faults


_POSITIVE = ("W_nn", "W_tt", "W_nn_after", "W_tt_after", "K", "n")


def _source() -> str:
    """Return the C source: nodes and weights, then the engine's files."""
    folder = resources.files(__package__)
    lines = [f"static const int PS_ORDER[] = {{{', '.join(map(str, ORDERS))}}};"]
    rules = [_rule(order) for order in ORDERS]
    for index, kind in enumerate(("NODES", "WEIGHTS", "LAST", "BEFORE")):
        rows = [", ".join(repr(float(x)) for x in rule[index]) for rule in rules]
        table = ", ".join(f"{{{row}}}" for row in rows)
        lines.append(f"static const double PS_{kind}[][{max(ORDERS)}] = {{{table}}};")
    files = ("frozen_integrals", "frozen_impact")
    return "\n".join((*lines, *(folder.joinpath(f"{f}.c").read_text("utf-8") for f in files)))


def _rule(order: int) -> tuple[Array, Array, Array, Array]:
    """Return nodes, weights, and weights that give the last two Legendre coefficients."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    top = [
        (2 * k + 1) * weights * np.polynomial.Legendre.basis(k)(nodes)
        for k in (order - 1, order - 2)
    ]
    return nodes, weights, top[0], top[1]


@lru_cache(maxsize=1)
def _compiled() -> ctypes.CDLL:
    library = load(_source())
    library.ps_frozen_impacts.argtypes = (ctypes.c_long, *[ctypes.c_void_p] * 4)
    library.ps_frozen_impacts.restype = None
    return library


def _library(engine: str) -> ctypes.CDLL | None:
    try:
        return _compiled()
    except CompilerMissing as error:
        if engine == "compiled":
            raise
        warnings.warn(
            f"{error} Until then impacts are solved by the slower engine 'python'.",
            PainleveWarning,
            stacklevel=4,
        )
        return None
