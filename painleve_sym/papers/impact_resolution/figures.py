"""Figs. 4, 6 and 12: sliding that settles, and lift-off."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import brentq

from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.papers.impact_resolution.claims import (
    NUMBERS,
    SETTLING_TIMES,
    SOFT,
    STABLE_FORCES,
    STIFF,
)
from painleve_sym.papers.impact_resolution.runs import (
    AXES,
    JUMP_UP,
    JUMP_UPS,
    SLIDING,
    SLIDING_ELASTIC,
    RunCase,
    Workbench,
    first,
    history,
    modulus_label,
    modulus_text,
)
from painleve_sym.papers.item import ItemOutcome, checked, table
from painleve_sym.papers.panels import FORCE, TIME_S, Axis, Panel, line, window

SETTLED = 0.05
"""Part of −B/A within which the force counts as settled; from 1 to 5 % the times are the same."""


def settling_time(bench: Workbench, run: Trajectory) -> float:
    """Return when F_n last leaves the band of ±5 % about −B/A; s."""
    times = window(run, 0.0, run.final_time, per_step=100)
    ratio = run.values("normal_force", times) / bench.sliding_force_along(run, times)
    return float(times[np.flatnonzero(np.abs(ratio - 1) > SETTLED)[-1]])


def reading_time(bench: Workbench, run: Trajectory, force: float) -> float | None:
    """Return when the drifting −B/A passes a force; s. None where it does not."""

    def gap(t: float) -> float:
        return float(bench.sliding_force_along(run, np.array([t]))[0]) - force

    start, end = 0.0, run.final_time
    return float(brentq(gap, start, end)) if gap(start) * gap(end) < 0 else None


def reload_gain(run: Trajectory) -> float:
    """Return the energy that the jumps of the force at reloading add; J."""
    gain = 0.0
    for event in run.events_of("reload"):
        before = run.values("contact_dissipation", np.nextafter(event.time, -np.inf))[0]
        gain += before - event.state["contact_dissipation"]
    return float(gain)


def _force_panel(bench: Workbench, case: RunCase, title: str, kinds: tuple[str, ...] = ()) -> Panel:
    """Return F_n over time with the drifting −B/A beside it."""
    run = bench.run(case)
    panel = history(bench, [("$F_n$", case)], "normal_force", case.t_end, kinds, title)
    times = np.linspace(0.0, case.t_end, 200)
    drift = line("$-B/A$", times, bench.sliding_force_along(run, times), "reference")
    return Panel(panel.x, FORCE.within(-0.7, 18.5), (*panel.curves, drift), panel.marks, title)


def _sliding_panels(bench: Workbench) -> tuple[Panel, ...]:
    soft, stiff = SLIDING[SOFT], SLIDING[STIFF]
    kinds = ("max_compression", "reload")
    return (
        *(
            history(bench, [("", soft)], name, soft.t_end, (), modulus_label(SOFT))
            for name in ("y_A", "y_A_dot")
        ),
        _force_panel(bench, soft, modulus_label(SOFT), kinds),
        _force_panel(bench, stiff, modulus_label(STIFF), kinds),
        _force_panel(bench, SLIDING_ELASTIC[SOFT], "as (c), elastic reload"),
        _force_panel(bench, SLIDING_ELASTIC[STIFF], "as (d), elastic reload"),
    )


def compute_sliding(bench: Workbench) -> ItemOutcome:
    """Fig. 4: the force oscillates, settles and then follows −B/A."""
    checks, rows, texts = dict[str, bool](), list[list[Any]](), []
    for modulus, case in SLIDING.items():
        run, stable = bench.run(case), STABLE_FORCES[modulus]
        settled, passes = settling_time(bench, run), reading_time(bench, run, stable.value)
        at_end = float(run.values("normal_force", run.final_time)[0])
        other = bench.run(SLIDING_ELASTIC[modulus])
        never = settling_time(bench, other) > 0.95 * other.final_time
        name = modulus_text(modulus)
        checks |= {
            f"{name}: settles when the paper says": SETTLING_TIMES[modulus].matches(settled),
            f"{name}: the force passes the value read": passes is not None and passes > settled,
            f"{name}: with elastic reload it never settles": never,
        }
        rows.append([modulus, settled, stable.value, passes, at_end, reload_gain(run)])
        texts.append(f"{settled * 1e3:.3g} ms, {stable.text} N at {(passes or 0) * 1e3:.3g} ms")
    start = -bench.rigid(1).B / bench.rigid(1).A
    checks["−B/A = 6.039 N at the start"] = NUMBERS["sliding-force"].matches(start)
    columns = ["E", "settled after (s)", "read (N)", "passed at (s)", "F_n at the end (N)"]
    return checked(
        "; ".join(texts),
        checks,
        {"table": table([*columns, "energy added at reloading (J)"], rows)},
        _sliding_panels(bench),
        gain=rows[0][-1],
        modulus=modulus_text(SOFT),
    )


def compute_jump_up(bench: Workbench) -> ItemOutcome:
    """Fig. 6: the rod leaves at once."""
    run = bench.run(JUMP_UP)
    times = window(run, 0.0, run.final_time)
    heights, forces = run.values("y_A", times), run.values("normal_force", times)
    checks = {
        "no event": not run.events,
        "no force": bool(np.all(forces == 0)),
        "the height only grows": bool(np.all(np.diff(heights) > 0)),
    }
    height = Axis(r"$y_A$", "mm", 1e3)
    panel = Panel(TIME_S.within(0.0, JUMP_UP.t_end), height, (line("", times, heights),))
    return checked(
        f"y_A = {heights[-1] * 1e3:.2f} mm after {run.final_time:g} s, F_n = 0 throughout",
        checks,
        {"t": run.final_time, "y_A": float(heights[-1]), "largest_force": float(max(forces))},
        (panel,),
    )


def compute_jump_ups(bench: Workbench) -> ItemOutcome:
    """Fig. 12: below F_n* the force only decays and the rod leaves."""
    end, checks, rows = 5e-4, dict[str, bool](), list[list[Any]]()
    for force, case in JUMP_UPS.items():
        run = bench.run(case)
        times = window(run, 0.0, run.final_time)
        values, leave = run.values("normal_force", times), first(run, "separation")
        checks |= {
            f"{force:g} N: the force only decays": bool(np.all(np.diff(values) <= 0)),
            f"{force:g} N: the slip never stops": first(run, "slip_stop") is None,
            f"{force:g} N: the rod is up at the end": run.final["y_A"] > 0,
        }
        rows.append([force, leave.time if leave else 0.0, run.final["y_A_dot"]])
    named = [(rf"$F_{{n0}}={force:g}$ N", case) for force, case in JUMP_UPS.items()]
    axes = AXES | {"normal_force": FORCE}
    panels = tuple(
        history(bench, named, name, end, ("separation",), axes=axes)
        for name in ("y_A", "y_A_dot", "theta_dot", "normal_force")
    )
    leaving = ", ".join(f"{row[1] * 1e3:.3f}" for row in rows)
    return checked(
        f"force gone after {leaving} ms, slip never stops",
        checks,
        {"table": table(["initial force (N)", "separation (s)", "ẏ_A at 1 ms (m/s)"], rows)},
        panels,
    )


COMPUTE = {"fig-4": compute_sliding, "fig-6": compute_jump_up, "fig-12": compute_jump_ups}
