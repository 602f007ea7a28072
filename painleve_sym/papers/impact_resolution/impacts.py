"""Figs. 8, 9, 10, 13 and 14: impact without collision."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.papers.impact_resolution.runs import (
    AXES,
    HARDER_IMPACTS,
    IMPACT,
    LOADED_HARDER,
    LOADED_IMPACTS,
    LOADED_SPEED,
    OTHER_SPEEDS,
    SPEED_FORCE,
    RunCase,
    Workbench,
    history,
    modulus_label,
    modulus_text,
    needed,
)
from painleve_sym.papers.item import ItemOutcome, checked, table
from painleve_sym.papers.panels import COMPRESSION, FORCE_KN, Mark, Panel, line, window

EVENTS = ("slip_stop", "max_compression", "separation")


def milestones(run: Trajectory) -> dict[str, dict[str, float]]:
    """Return time, velocities, force and compression at the three events of an impact."""
    events = {kind: needed(run, kind) for kind in EVENTS}
    return {
        kind: {
            "time": event.time,
            "y_A_dot": event.state["y_A_dot"],
            "theta_dot": event.state["theta_dot"],
            "normal_force": event.normal_force,
            "compression": event.compression,
        }
        for kind, event in events.items()
    }


def in_order(run: Trajectory) -> bool:
    """Return whether slip stops, compression ends and contact ends, in this order."""
    times = [needed(run, kind).time for kind in EVENTS]
    return times == sorted(times)


def loop(run: Trajectory) -> Panel:
    """Return F_n over δ until separation."""
    end = needed(run, "separation").time
    times = window(run, 0.0, np.nextafter(end, -np.inf))
    values = run.outputs(times)
    marks = []
    for kind in EVENTS:
        event = needed(run, kind)
        just_before = run.outputs(np.nextafter(event.time, -np.inf))
        marks.append(
            Mark(kind, float(just_before["compression"][0]), float(just_before["normal_force"][0]))
        )
    curve = line("", values["compression"], values["normal_force"])
    return Panel(COMPRESSION, FORCE_KN, (curve,), tuple(marks))


def compute_impact(bench: Workbench) -> ItemOutcome:
    """Fig. 8: sliding, sticking compression, sticking restitution, rebound."""
    run, end = bench.run(IMPACT), IMPACT.t_end
    at = milestones(run)
    stop, top, leave = (at[kind] for kind in EVENTS)
    e = run.parameters["e_energetic"]
    start = run.state(0.0)
    checks = {
        "slip stops, compression ends, the end leaves": in_order(run),
        "the tangential phase drives the end down": stop["y_A_dot"] < 0,
        "θ̇ jumps up in the tangential phase": stop["theta_dot"] > start["theta_dot"],
        "θ̇ falls a little in restitution": leave["theta_dot"] < top["theta_dot"],
        "the rod bounces up": leave["y_A_dot"] > 0,
        "permanent compression as (6)": bool(
            np.isclose(leave["compression"], (1 - e**2) * top["compression"], rtol=1e-9)
        ),
    }
    histories = [history(bench, [("", IMPACT)], name, end, EVENTS) for name in AXES]
    return checked(
        f"{stop['time'] * 1e3:.4f}, {top['time'] * 1e3:.4f} ({top['normal_force']:.0f} N), "
        f"{leave['time'] * 1e3:.4f} ms, rebound {leave['y_A_dot']:.4f} m/s",
        checks,
        {"events": at, "permanent_compression": leave["compression"]},
        (*histories, loop(run)),
    )


def _peaks(bench: Workbench, cases: Mapping[float, RunCase]) -> list[list[Any]]:
    """Return parameter, duration, time of the slip stop and peak force of each impact."""
    rows = []
    for value, case in cases.items():
        stop, top, leave = milestones(bench.run(case)).values()
        rows.append([value, stop["time"], leave["time"], top["normal_force"], leave["y_A_dot"]])
    return rows


_COLUMNS = ["slip stops (s)", "separation (s)", "peak force (N)", "ẏ_A at separation (m/s)"]


def compute_stiffer(cases: Mapping[float, RunCase], end: float, bench: Workbench) -> ItemOutcome:
    """Figs. 9 and 14: F_n for several moduli."""
    rows = _peaks(bench, cases)
    checks = {
        "the stiffer, the shorter": all(a[2] > b[2] for a, b in pairwise(rows)),
        "the stiffer, the higher the peak": all(a[3] < b[3] for a, b in pairwise(rows)),
    }
    named = [(modulus_label(E), case) for E, case in cases.items()]
    kinds = ("max_compression", "separation")
    panel = history(bench, named, "normal_force", end, kinds)
    first, last = rows[0], rows[-1]
    computed = (
        f"E = {modulus_text(first[0])} … {modulus_text(last[0])}: {first[2] * 1e3:.2f} … "
        f"{last[2] * 1e3:.2f} ms, peak {first[3] / 1e3:.1f} … {last[3] / 1e3:.1f} kN"
    )
    data = {"table": table(["E (Pa)", *_COLUMNS], rows)}
    return checked(computed, checks, data, (panel,))


def compute_speeds(bench: Workbench) -> ItemOutcome:
    """Fig. 10: the speed hardly matters, surface energy shortens the impact."""
    rows = _peaks(bench, OTHER_SPEEDS)
    loaded = _peaks(bench, {SPEED_FORCE: LOADED_SPEED})[0]
    stops = [row[1] for row in rows]
    longer = max(stops) / min(stops)
    checks = {
        # Four times the speed: "not greatly" is taken as less than half as long again.
        "the speed does not affect the time greatly": longer < 1.5,
        "the run with surface energy is the shortest": loaded[2] < min(row[2] for row in rows),
    }
    named = [(rf"$\dot{{x}}_A(0)={v:g}$ m/s", case) for v, case in OTHER_SPEEDS.items()]
    named.append((rf"$-1$ m/s, $F_{{n0}}={SPEED_FORCE:g}$ N", LOADED_SPEED))
    panel = history(bench, named, "x_A_dot", 0.5e-3, ("slip_stop",))
    data = {
        "table": table(["ẋ_A(0) (m/s)", *_COLUMNS], rows),
        "with_surface_energy": dict(zip(["initial_force", *_COLUMNS], loaded, strict=True)),
    }
    return checked(
        f"slip stops after {min(stops) * 1e3:.3f} … {max(stops) * 1e3:.3f} ms for 0.5 … 2 m/s; "
        f"{loaded[1] * 1e3:.3f} ms with {SPEED_FORCE:g} N",
        checks,
        data,
        (panel,),
    )


def compute_loaded(bench: Workbench) -> ItemOutcome:
    """Fig. 13: above F_n* the motion is like that in the inconsistent field."""
    end = 2.4e-4
    checks = {}
    for force, case in LOADED_IMPACTS.items():
        run = bench.run(case)
        checks[f"{force:g} N: slip stops, then compression ends, then separation"] = in_order(run)
        checks[f"{force:g} N: θ̇ jumps up"] = (
            needed(run, "slip_stop").state["theta_dot"] > run.state(0.0)["theta_dot"]
        )
    rows = _peaks(bench, LOADED_IMPACTS)
    checks["the more surface energy, the shorter"] = all(a[2] > b[2] for a, b in pairwise(rows))
    named = [(rf"$F_{{n0}}={force:g}$ N", case) for force, case in LOADED_IMPACTS.items()]
    shown = ("x_A_dot", "y_A_dot", "theta_dot", "normal_force")
    panels = tuple(history(bench, named, name, end, EVENTS) for name in shown)
    times = ", ".join(f"{row[1] * 1e3:.3f}" for row in rows)
    return checked(
        f"slip stops after {times} ms, then rebound",
        checks,
        {"table": table(["initial force (N)", *_COLUMNS], rows)},
        panels,
    )


COMPUTE = {
    "fig-8": compute_impact,
    "fig-9": partial(compute_stiffer, HARDER_IMPACTS, 0.8e-3),
    "fig-10": compute_speeds,
    "fig-13": compute_loaded,
    "fig-14": partial(compute_stiffer, LOADED_HARDER, 0.4e-3),
}
