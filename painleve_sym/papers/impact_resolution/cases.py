"""The softened runs behind the figures and statements; the balance of energy is taken over all.

Where the paper does not print an input (the moduli of Figs. 9 and 14, the speeds of Fig. 10), the
values here are chosen to show what it describes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from painleve_sym.papers.impact_resolution.claims import INITIAL_FORCES, SOFT, STIFF, STIFFER
from painleve_sym.papers.panels import Axis, Mark, Panel, events_as_marks, line, window
from painleve_sym.papers.run_cache import Case, Workbench
from painleve_sym.simulate.trajectory import EventRecord, Trajectory

EXPONENT_RANGE = range(10, 19)
MODULI = tuple(float(f"20.9e{p}") for p in EXPONENT_RANGE)
"""Moduli of the convergence study, 20.9e10 … 20.9e18; Pa."""

LONG = 1.0
"""End time of runs that an event ends; s. No impact here lasts a twentieth of it."""

SLIDING = {
    SOFT: Case(1, SOFT, 0.018),
    STIFF: Case(1, STIFF, 1.6e-3),
}
"""Fig. 4; long enough for the forces that the paper reads off."""
SLIDING_ELASTIC = {
    SOFT: Case(1, SOFT, 0.018, reload="elastic"),
    STIFF: Case(1, STIFF, 1.6e-3, reload="elastic"),
}
SLIDING_LOADED = Case(1, SOFT, 0.018, initial_force=3.0)
"""§3.1: a small initial surface energy."""
JUMP_UP = Case(2, SOFT, 0.1)
"""Fig. 6."""
IMPACT = Case(3, STIFF, 5e-4)
"""Fig. 8."""

STIFFNESSES = tuple(float(f"20.9e{p}") for p in (13, 14, 15, 16))
HARDER_IMPACTS = {E: Case(3, E, LONG, until="separation") for E in STIFFNESSES}
"""Fig. 9."""
SPEEDS = (-0.5, -1.0, -1.5, -2.0)
SPEED_FORCE = 100.0
OTHER_SPEEDS = {
    v: Case(3, STIFF, LONG, until="separation", state=(("x_A_dot", v),)) for v in SPEEDS
}
"""Fig. 10."""
LOADED_SPEED = Case(3, STIFF, LONG, until="separation", initial_force=SPEED_FORCE)

NEAR_BORDER = 3.40
"""θ̇ just below the border of the inconsistent field at θ = 1, 3.4127 rad/s."""
BORDER = {
    E: Case(3, E, LONG, until="separation", state=(("theta_dot", NEAR_BORDER),))
    for E in (SOFT, STIFF)
}

JUMP_UPS = {
    F: Case(4, STIFF, 1e-3, initial_force=F)
    for F in (0.0, *(f.force.value for f in INITIAL_FORCES if f.table == 5))
}
"""Fig. 12."""
LOADED_IMPACTS = {
    f.force.value: Case(4, STIFFER, 3e-4, initial_force=f.force.value)
    for f in INITIAL_FORCES
    if f.table == 6
}
"""Fig. 13."""
FIXED_FORCE = 500.0
LOADED_STIFFNESSES = tuple(float(f"20.9e{p}") for p in (14, 15, 16))
LOADED_HARDER = {
    E: Case(4, E, LONG, until="separation", initial_force=FIXED_FORCE) for E in LOADED_STIFFNESSES
}
"""Fig. 14."""


def modulus_label(modulus: float) -> str:
    """Return E = 20.9 × 10ᵖ Pa as mathtext."""
    power = round(math.log10(modulus / 20.9))
    return rf"$E=20.9\times10^{{{power}}}$ Pa"


def modulus_text(modulus: float) -> str:
    """Return 20.9e14 and the like."""
    return f"20.9e{round(math.log10(modulus / 20.9))}"


def first(run: Trajectory, kind: str) -> EventRecord | None:
    """Return the first event of a kind, or None."""
    return next(iter(run.events_of(kind)), None)


def needed(run: Trajectory, kind: str) -> EventRecord:
    """Return the first event of a kind that the run must have.

    Raises
    ------
    LookupError
        There is none: the run is not the one the item is about.
    """
    found = first(run, kind)
    if found is None:
        kinds = [e.kind for e in run.events]
        raise LookupError(f"run of {run.mechanism!r}: no event {kind!r} among {kinds}")
    return found


def history(
    bench: Workbench,
    cases: Iterable[tuple[str, Case]],
    name: str,
    x: Axis,
    y: Axis,
    end: float,
    kinds: tuple[str, ...] = (),
    title: str = "",
) -> Panel:
    """Return one quantity over time for several runs.

    Parameters
    ----------
    bench : Workbench
    cases : iterable of (str, Case)
        Label and run.
    name : str
        State or output.
    x, y : Axis
    end : float
        s.
    kinds : tuple of str
        Events that are marked.
    title : str
    """
    curves, marks = [], list[Mark]()
    for label, case in cases:
        run = bench.run(case)
        times = window(run, 0.0, end)
        curves.append(line(label, times, run.values(name, times)))
        marks += events_as_marks(run, name, end, kinds)
    return Panel(x.within(0.0, x.factor * end), y, tuple(curves), tuple(marks), title)
