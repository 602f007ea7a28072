"""Claims that the paper makes in words or with single numbers in its text."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from painleve_sym.motion.trajectory import Trajectory
from painleve_sym.papers.impact_resolution.claims import NUMBERS, SOFT, STABLE_FORCES, STIFF
from painleve_sym.papers.impact_resolution.figures import reading_time, settling_time
from painleve_sym.papers.impact_resolution.impacts import EVENTS
from painleve_sym.papers.impact_resolution.runs import (
    BORDER,
    IMPACT,
    JUMP_UPS,
    NEAR_BORDER,
    SLIDING,
    SLIDING_LOADED,
    Workbench,
    first,
    modulus_text,
    needed,
)
from painleve_sym.papers.item import ItemOutcome, Verdict, checked, table
from painleve_sym.papers.panels import (
    ANGULAR_VELOCITY,
    FORCE_KN,
    TIME_US,
    Axis,
    Panel,
    events_as_marks,
    line,
    window,
)
from painleve_sym.problem.solution import ContactCase


def compute_stable(bench: Workbench) -> ItemOutcome:
    """§3.1: the force does not become constant."""
    rows, texts, drifts = list[list[Any]](), [], True
    for modulus, case in SLIDING.items():
        run, stable = bench.run(case), STABLE_FORCES[modulus]
        settled = settling_time(bench, run)
        times = np.linspace(settled, run.final_time, 50)
        forces = bench.sliding_force_along(run, times)
        drifts &= bool(np.all(np.diff(forces) > 0))
        passes = reading_time(bench, run, stable.value)
        rows.append([modulus, stable.value, passes, forces[0], forces[-1]])
        texts.append(f"{forces[0]:.3f} … {forces[-1]:.3f} N")
    start = -bench.rigid(1).B / bench.rigid(1).A
    columns = ["E (Pa)", "printed (N)", "passed at (s)", "−B/A settled (N)", "−B/A at the end (N)"]
    return ItemOutcome(
        "follows −B/A, still rising: " + ", ".join(texts),
        Verdict.of(not drifts),
        {"start": start},
        {"table": table(columns, rows)},
    )


def compute_small_energy(bench: Workbench) -> ItemOutcome:
    """§3.1: a little surface energy changes nothing lasting."""
    plain, loaded = bench.run(SLIDING[SOFT]), bench.run(SLIDING_LOADED)
    ends = [float(r.values("normal_force", r.final_time)[0]) for r in (plain, loaded)]
    checks = {
        "both keep sliding": not plain.events_of("slip_stop") + loaded.events_of("slip_stop"),
        "both settle": all(settling_time(bench, r) < r.final_time for r in (plain, loaded)),
        "same force at the end": abs(ends[1] / ends[0] - 1) < 0.01,
    }
    return checked(
        f"from {SLIDING_LOADED.initial_force:g} N: F_n at the end {ends[1]:.3f} N, without "
        f"{ends[0]:.3f} N",
        checks,
        {"force_without": ends[0], "force_with": ends[1]},
    )


def compute_stick_time(bench: Workbench) -> ItemOutcome:
    """§3.3: how long the tangential impact lasts."""
    stop = needed(bench.run(IMPACT), "slip_stop").time
    same = NUMBERS["sticking-time"].matches(stop)
    return ItemOutcome(f"{stop:.4e} s", Verdict.of(same), data={"slip_stop": stop})


def _phases(run: Trajectory) -> tuple[Panel, Panel]:
    """Return θ̇ and F_n from just before the slip stops until after separation."""
    start, end = 400e-6, 432e-6
    times = window(run, start, end)
    panels = []
    for name, axis in (("theta_dot", ANGULAR_VELOCITY), ("normal_force", FORCE_KN)):
        marks = events_as_marks(run, name, end, EVENTS)
        curve = line("", times, run.values(name, times))
        panels.append(Panel(TIME_US.within(1e6 * start, 1e6 * end), axis, (curve,), marks))
    return panels[0], panels[1]


def compute_sticking_compression(bench: Workbench) -> ItemOutcome:
    """§3.3: how long the second period lasts."""
    run = bench.run(IMPACT)
    stop, top, leave = (needed(run, kind).time for kind in EVENTS)
    lasts = top - stop
    printed = NUMBERS["sticking-compression"]
    return ItemOutcome(
        f"{lasts:.1e} s, restitution {leave - top:.1e} s",
        Verdict.of(printed.matches(lasts)),
        {"factor": printed.value / lasts, "sticking": leave - stop},
        {"sticking_compression": lasts, "restitution": leave - top},
        _phases(run),
    )


def _energies(bench: Workbench, run: Trajectory, t: float) -> dict[str, float]:
    """Return the parts of the rod's energy at a time, and the work of compression; J."""
    system = bench.rod.system
    kinetic, (along, up) = system.kinetic_energy, system.q_dot[:2]
    # Momenta of the centre: its energies are p²/(2m), and rotation has the rest.
    mass = kinetic.diff(along, 2)
    sliding, vertical = (kinetic.diff(v) ** 2 / (2 * mass) for v in (along, up))
    parts = {"sliding": sliding, "vertical": vertical, "rotation": kinetic - sliding - vertical}
    state = run.state(t)
    energies = {name: bench.evaluated(part, run, state) for name, part in parts.items()}
    stored = float(run.values("stored_energy", t)[0])
    return energies | {"compression": stored + state["contact_dissipation"], "recoverable": stored}


def compute_portions(bench: Workbench) -> ItemOutcome:
    """§3.3: where the energy of sliding goes in the tangential impact."""
    run = bench.run(IMPACT)
    stop = needed(run, "slip_stop")
    before, after = (_energies(bench, run, t) for t in (0.0, stop.time))
    checks = {
        "kinetic energy along the ground falls": after["sliding"] < before["sliding"],
        "compression gains": after["compression"] > before["compression"],
        "rotation gains": after["rotation"] > before["rotation"],
        "the end moves down": stop.state["y_A_dot"] < 0,
    }
    rows = [[k, before[k], after[k], after[k] - before[k]] for k in before]
    return checked(
        f"rotation +{after['rotation'] - before['rotation']:.3f} J, compression "
        f"+{after['compression'] - before['compression']:.4f} J, ẏ_A = {stop.state['y_A_dot']:.4f}",
        checks,
        {"table": table(["energy", "at t0 (J)", "at t1 (J)", "change (J)"], rows)},
        friction=stop.state["friction_dissipation"],
        recoverable=after["recoverable"],
    )


def compute_rotation(bench: Workbench) -> ItemOutcome:
    """§3.3: the rotational energy in the second period."""
    run = bench.run(IMPACT)
    stop, top = (needed(run, kind) for kind in EVENTS[:2])
    spins = [e.state["theta_dot"] for e in (stop, top)]
    energies = [_energies(bench, run, e.time) for e in (stop, top)]
    grows = energies[1]["rotation"] > energies[0]["rotation"]
    return ItemOutcome(
        f"θ̇ falls, {spins[0]:.4f} → {spins[1]:.4f} rad/s",
        Verdict.of(grows),
        data={"theta_dot": spins, "energies": energies},
    )


def compute_third_period(bench: Workbench) -> ItemOutcome:
    """§3.3: whether the end sticks until it leaves."""
    run = bench.run(IMPACT)
    leave = needed(run, "separation")
    slip = first(run, "slip_start")
    data: dict[str, Any] = {"separation": leave.time}
    panels: tuple[Panel, ...] = ()
    computed, largest = "sticks until separation", 0.0
    if slip is not None:
        lasts = leave.time - slip.time
        changes = {k: leave.state[k] - slip.state[k] for k in ("x_A_dot", "y_A_dot", "theta_dot")}
        data |= {"slip_start": slip.time, "lasts": lasts, "changes": changes}
        largest = max(abs(v) for v in changes.values())
        computed = f"slips back for the last {lasts:.1e} s"
        panels = (_friction_ratio(run, slip.time, leave.time),)
    return ItemOutcome(computed, Verdict.of(slip is None), {"largest": largest}, data, panels)


def _friction_ratio(run: Trajectory, slip: float, leave: float) -> Panel:
    """Return F_t/F_n over the last moments before separation, time counted from it."""
    span = 5 * (leave - slip)
    times = window(run, leave - span, leave, per_step=400)[:-1]
    values = run.outputs(times)
    mu = run.parameters["mu"]
    since = times - leave
    ratio = line("$F_t/F_n$", since, values["tangential_force"] / values["normal_force"])
    bounds = [
        line(r"$\pm\mu$", since[[0, -1]], [sign * mu, sign * mu], "reference") for sign in (1, -1)
    ]
    axis = Axis(r"$t-t_3$", "ns", 1e9, limits=(-1e9 * span, 0.0))
    return Panel(axis, Axis("$F_t/F_n$", limits=(-1.7, 1.7)), (ratio, *bounds))


def compute_pendulum(bench: Workbench) -> ItemOutcome:
    """§3.3: the period to compare the impact with."""
    run, system = bench.run(IMPACT), bench.rod.system
    theta, spin = system.q[2], system.q_dot[2]
    hanging = run.state(0.0) | {"theta": -math.pi / 2}
    inertia = bench.evaluated(system.kinetic_energy.diff(spin, 2), run, hanging)
    stiffness = bench.evaluated(system.potential_energy.diff(theta, 2), run, hanging)
    period = 2 * math.pi * math.sqrt(inertia / stiffness)
    impact = needed(run, "separation").time
    same = NUMBERS["pendulum-period"].matches(period)
    return checked(
        f"pendulum {period:.3f} s, impact {impact:.1e} s",
        {"period": same, "short": impact < 1e-3 * period},
        {"period": period, "impact": impact},
    )


def compute_border(bench: Workbench) -> ItemOutcome:
    """§3.3: near the border θ̇ leaves the inconsistent field, unless E is large."""
    rows, impact = list[list[Any]](), {}
    for modulus, case in BORDER.items():
        run = bench.run(case)
        b = bench.evaluated(bench.rod.coefficients.B, run, run.final)
        impact[modulus] = first(run, "slip_stop") is not None
        rows.append([modulus, impact[modulus], run.final_time, b])
    checks = {
        "soft: no impact, B becomes positive": not impact[SOFT] and rows[0][3] > 0,
        "stiff: impact without collision": impact[STIFF],
    }
    columns = ["E (Pa)", "slip stops", "separation (s)", "B at separation (m/s²)"]
    return checked(
        f"from θ̇ = {NEAR_BORDER:.2f}: lifts off at E = {modulus_text(SOFT)}, impact at "
        f"{modulus_text(STIFF)}",
        checks,
        {"table": table(columns, rows)},
    )


def compute_conclusions(bench: Workbench) -> ItemOutcome:
    """§4: the three conclusions, without surface energy."""
    impact = bench.run(IMPACT)
    checks = {
        "(1) one solution: the compliant rod takes it": (
            bench.rigid(1).case is ContactCase.SLIP
            and settling_time(bench, bench.run(SLIDING[STIFF])) < SLIDING[STIFF].t_end
        ),
        "(2) two solutions: it jumps up": (
            bench.rigid(4).case is ContactCase.INDETERMINATE and not bench.run(JUMP_UPS[0.0]).events
        ),
        "(3) none: impact without collision": (
            bench.rigid(3).case is ContactCase.INCONSISTENT
            and needed(impact, "separation").state["y_A_dot"] > 0
        ),
    }
    return checked("the same from Tables 1, 4 and 3 without surface energy", checks)


COMPUTE = {
    "stable-force": compute_stable,
    "small-energy": compute_small_energy,
    "stick-time": compute_stick_time,
    "energy-portions": compute_portions,
    "sticking-compression": compute_sticking_compression,
    "rotation": compute_rotation,
    "third-period": compute_third_period,
    "pendulum": compute_pendulum,
    "border": compute_border,
    "conclusions": compute_conclusions,
}
