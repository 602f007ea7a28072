"""Figs. 8, 9, 10, 13 and 14: impact without collision."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from painleve_sym.papers.claim import Entry, Outcome, features, table
from painleve_sym.papers.impact_resolution.cases import (
    FIXED_FORCE,
    HARDER_IMPACTS,
    IMPACT,
    LOADED_HARDER,
    LOADED_IMPACTS,
    LOADED_SPEED,
    OTHER_SPEEDS,
    SPEED_FORCE,
    history,
    modulus_label,
    modulus_text,
    needed,
)
from painleve_sym.papers.panels import (
    ANGULAR_VELOCITY,
    COMPRESSION,
    FORCE_KN,
    HEIGHT,
    NORMAL_VELOCITY,
    SLIP_VELOCITY,
    TIME_MS,
    Mark,
    Panel,
    line,
    window,
)
from painleve_sym.papers.run_cache import Case, Workbench
from painleve_sym.simulate.trajectory import Trajectory

GROUP = "figure"
EVENTS = ("slip_stop", "max_compression", "separation")


def milestones(run: Trajectory) -> dict[str, dict[str, float]]:
    """Return time, velocities, force and compression at the three events of an impact."""
    found = {}
    for kind in EVENTS:
        event = needed(run, kind)
        found[kind] = {
            "time": event.time,
            "y_A_dot": event.state["y_A_dot"],
            "theta_dot": event.state["theta_dot"],
            "normal_force": event.normal_force,
            "compression": event.compression,
        }
    return found


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


def compute_impact(bench: Workbench) -> Outcome:
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
    case = [("", IMPACT)]
    panels = (
        history(bench, case, "x_A_dot", TIME_MS, SLIP_VELOCITY, end, EVENTS),
        history(bench, case, "y_A", TIME_MS, HEIGHT, end, EVENTS),
        history(bench, case, "y_A_dot", TIME_MS, NORMAL_VELOCITY, end, EVENTS),
        history(bench, case, "theta_dot", TIME_MS, ANGULAR_VELOCITY, end, EVENTS),
        history(bench, case, "normal_force", TIME_MS, FORCE_KN, end, EVENTS),
        loop(run),
    )
    return features(
        "slip stops, compression then restitution in sticking, rebound",
        f"{stop['time'] * 1e3:.4f}, {top['time'] * 1e3:.4f} ({top['normal_force']:.0f} N), "
        f"{leave['time'] * 1e3:.4f} ms, rebound {leave['y_A_dot']:.4f} m/s",
        checks,
        data={"events": at, "permanent_compression": leave["compression"]},
        panels=panels,
    )


def _peaks(bench: Workbench, cases: Mapping[float, Case]) -> list[list[Any]]:
    """Return parameter, duration, time of the slip stop and peak force of each impact."""
    rows = []
    for value, case in cases.items():
        run = bench.run(case)
        at = milestones(run)
        rows.append(
            [
                value,
                at["slip_stop"]["time"],
                at["separation"]["time"],
                at["max_compression"]["normal_force"],
                at["separation"]["y_A_dot"],
            ]
        )
    return rows


_COLUMNS = ["slip stops (s)", "separation (s)", "peak force (N)", "ẏ_A at separation (m/s)"]


def _stiffer(bench: Workbench, cases: Mapping[float, Case], paper: str, end: float) -> Outcome:
    """Return the force histories for growing stiffness: shorter and higher."""
    rows = _peaks(bench, cases)
    checks = {
        "the stiffer, the shorter": all(a[2] > b[2] for a, b in pairwise(rows)),
        "the stiffer, the higher the peak": all(a[3] < b[3] for a, b in pairwise(rows)),
    }
    named = [(modulus_label(E), case) for E, case in cases.items()]
    kinds = ("max_compression", "separation")
    panel = history(bench, named, "normal_force", TIME_MS, FORCE_KN, end, kinds)
    first, last = rows[0], rows[-1]
    computed = (
        f"E = {modulus_text(first[0])} … {modulus_text(last[0])}: {first[2] * 1e3:.2f} … "
        f"{last[2] * 1e3:.2f} ms, peak {first[3] / 1e3:.1f} … {last[3] / 1e3:.1f} kN"
    )
    data = {"table": table(["E (Pa)", *_COLUMNS], rows)}
    return features(paper, computed, checks, data=data, panels=(panel,))


def compute_stiffer(bench: Workbench) -> Outcome:
    """Fig. 9: F_n for several moduli."""
    return _stiffer(bench, HARDER_IMPACTS, "the stiffer, the closer to an impact", 0.8e-3)


def compute_loaded_stiffer(bench: Workbench) -> Outcome:
    """Fig. 14: the same from a fixed initial force."""
    return _stiffer(
        bench,
        LOADED_HARDER,
        "the stiffer, the shorter the impact and the higher the peak",
        0.4e-3,
    )


def compute_speeds(bench: Workbench) -> Outcome:
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
    panel = history(bench, named, "x_A_dot", TIME_MS, SLIP_VELOCITY, 0.5e-3, ("slip_stop",))
    data = {
        "table": table(["ẋ_A(0) (m/s)", *_COLUMNS], rows),
        "with_surface_energy": dict(zip(["initial_force", *_COLUMNS], loaded, strict=True)),
    }
    return features(
        "speeds hardly change the time; shortest with surface energy",
        f"slip stops after {min(stops) * 1e3:.3f} … {max(stops) * 1e3:.3f} ms for 0.5 … 2 m/s; "
        f"{loaded[1] * 1e3:.3f} ms with {SPEED_FORCE:g} N",
        checks,
        "The paper does not print its speeds; these are four and one run with surface energy.",
        data,
        (panel,),
    )


def compute_loaded(bench: Workbench) -> Outcome:
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
    panels = (
        history(bench, named, "x_A_dot", TIME_MS, SLIP_VELOCITY, end, EVENTS),
        history(bench, named, "y_A_dot", TIME_MS, NORMAL_VELOCITY, end, EVENTS),
        history(bench, named, "theta_dot", TIME_MS, ANGULAR_VELOCITY, end, EVENTS),
        history(bench, named, "normal_force", TIME_MS, FORCE_KN, end, EVENTS),
    )
    times = ", ".join(f"{row[1] * 1e3:.3f}" for row in rows)
    return features(
        "350, 500, 1000 N: as in the inconsistent field",
        f"slip stops after {times} ms, then rebound",
        checks,
        data={"table": table(["initial force (N)", *_COLUMNS], rows)},
        panels=panels,
    )


ENTRIES = (
    Entry("fig-8", GROUP, "Fig. 8: impact without collision, Table 3", compute_impact),
    Entry("fig-9", GROUP, "Fig. 9: F_n for several moduli", compute_stiffer),
    Entry("fig-10", GROUP, "Fig. 10: ẋ_A from several speeds", compute_speeds),
    Entry("fig-13", GROUP, "Fig. 13: impact from surface energy, Table 6", compute_loaded),
    Entry(
        "fig-14",
        GROUP,
        f"Fig. 14: F_n for several moduli from {FIXED_FORCE:g} N",
        compute_loaded_stiffer,
    ),
)
