"""What the paper says in words or with single numbers in its text."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from painleve_sym.contacts.problem import ContactCase
from painleve_sym.papers.claim import Entry, Outcome, Verdict, features, table
from painleve_sym.papers.impact_resolution.cases import (
    BORDER,
    IMPACT,
    JUMP_UPS,
    NEAR_BORDER,
    SLIDING,
    SLIDING_LOADED,
    first,
    modulus_text,
    needed,
)
from painleve_sym.papers.impact_resolution.claims import (
    PENDULUM_PERIOD,
    SOFT,
    STABLE_FORCES,
    STICKING_COMPRESSION,
    STICKING_TIME,
    STIFF,
)
from painleve_sym.papers.impact_resolution.diagrams import rigid
from painleve_sym.papers.impact_resolution.figures import reading_time, settling_time
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
from painleve_sym.papers.run_cache import Workbench
from painleve_sym.simulate.trajectory import Trajectory

GROUP = "statement"
EVENTS = ("slip_stop", "max_compression", "separation")


def compute_stable(bench: Workbench) -> Outcome:
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
    found = rigid(bench, 1)
    start = -found.B / found.A
    columns = ["E (Pa)", "printed (N)", "passed at (s)", "−B/A settled (N)", "−B/A at the end (N)"]
    return Outcome(
        "becomes stable at 6.40 N, at 6.071 N",
        "follows −B/A, still rising: " + ", ".join(texts),
        Verdict.DIFFERS if drifts else Verdict.REPRODUCED,
        f"−B/A grows from {start:.3f} N as θ and θ̇ change; both figures are readings of the "
        "drifting force near the end of the plot, not errors of the softened model",
        {"table": table(columns, rows)},
    )


def compute_small_energy(bench: Workbench) -> Outcome:
    """§3.1: a little surface energy changes nothing lasting."""
    plain, loaded = bench.run(SLIDING[SOFT]), bench.run(SLIDING_LOADED)
    ends = [float(r.values("normal_force", r.final_time)[0]) for r in (plain, loaded)]
    checks = {
        "both keep sliding": not plain.events_of("slip_stop") + loaded.events_of("slip_stop"),
        "both settle": all(settling_time(bench, r) < r.final_time for r in (plain, loaded)),
        "same force at the end": abs(ends[1] / ends[0] - 1) < 0.01,
    }
    return features(
        "small surface energy: motion unchanged",
        f"from {SLIDING_LOADED.initial_force:g} N: F_n at the end {ends[1]:.3f} N, without "
        f"{ends[0]:.3f} N",
        checks,
        data={"force_without": ends[0], "force_with": ends[1]},
    )


def compute_stick_time(bench: Workbench) -> Outcome:
    """§3.3: how long the tangential impact lasts."""
    stop = needed(bench.run(IMPACT), "slip_stop").time
    same = STICKING_TIME.matches(stop)
    return Outcome(
        "slip stops after about 4e-4 s",
        f"{stop:.4e} s",
        Verdict.REPRODUCED if same else Verdict.DIFFERS,
        data={"slip_stop": stop},
    )


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


def compute_sticking_compression(bench: Workbench) -> Outcome:
    """§3.3: how long the second period lasts."""
    run = bench.run(IMPACT)
    stop, top, leave = (needed(run, kind).time for kind in EVENTS)
    lasts = top - stop
    same = STICKING_COMPRESSION.matches(lasts)
    return Outcome(
        "sticking compression lasts about 1e-4 s",
        f"{lasts:.1e} s, restitution {leave - top:.1e} s",
        Verdict.REPRODUCED if same else Verdict.DIFFERS,
        f"{STICKING_COMPRESSION.value / lasts:.0f} times shorter; sticking as a whole, with "
        f"restitution, lasts {leave - stop:.1e} s",
        {"sticking_compression": lasts, "restitution": leave - top},
        _phases(run),
    )


def _energies(run: Trajectory, t: float) -> dict[str, float]:
    """Return the parts of the rod's energy at a time; J."""
    state, m, l = run.state(t), run.parameters["m"], run.parameters["l"]
    s, c = math.sin(state["theta"]), math.cos(state["theta"])
    # Velocity of the centre from that of the end A.
    along = state["x_A_dot"] - l * s * state["theta_dot"]
    up = state["y_A_dot"] + l * c * state["theta_dot"]
    return {
        "sliding": m * along**2 / 2,
        "vertical": m * up**2 / 2,
        "rotation": m * l**2 * state["theta_dot"] ** 2 / 6,
        "compression": float(run.values("stored_energy", t)[0]),
    }


def compute_portions(bench: Workbench) -> Outcome:
    """§3.3: where the energy of sliding goes in the tangential impact."""
    run = bench.run(IMPACT)
    stop = needed(run, "slip_stop")
    before, after = _energies(run, 0.0), _energies(run, stop.time)
    checks = {
        "kinetic energy along the ground falls": after["sliding"] < before["sliding"],
        "compression gains": after["compression"] > before["compression"],
        "rotation gains": after["rotation"] > before["rotation"],
        "the end moves down": stop.state["y_A_dot"] < 0,
    }
    rows = [[k, before[k], after[k], after[k] - before[k]] for k in before]
    return features(
        "sliding energy goes into compression, downward motion, rotation",
        f"rotation +{after['rotation'] - before['rotation']:.3f} J, compression "
        f"+{after['compression'] - before['compression']:.2g} J, ẏ_A = {stop.state['y_A_dot']:.4f}",
        checks,
        f"most of it is lost to friction ({stop.state['friction_dissipation']:.3f} J)",
        {"table": table(["energy", "at t0 (J)", "at t1 (J)", "change (J)"], rows)},
    )


def compute_rotation(bench: Workbench) -> Outcome:
    """§3.3: the rotational energy in the second period."""
    run = bench.run(IMPACT)
    stop, top = (needed(run, kind) for kind in EVENTS[:2])
    spins = [e.state["theta_dot"] for e in (stop, top)]
    energies = [_energies(run, e.time) for e in (stop, top)]
    grows = energies[1]["rotation"] > energies[0]["rotation"]
    return Outcome(
        "second period: rotational energy continues to increase",
        f"θ̇ falls, {spins[0]:.4f} → {spins[1]:.4f} rad/s",
        Verdict.REPRODUCED if grows else Verdict.DIFFERS,
        "by (18) θ̇ changes by 3 cosθ ẏ_A(t1)/(4l), negative whenever cosθ > 0; the energy of "
        "compression does increase",
        {"theta_dot": spins, "energies": energies},
    )


def compute_third_period(bench: Workbench) -> Outcome:
    """§3.3: whether the end sticks until it leaves."""
    run = bench.run(IMPACT)
    leave = needed(run, "separation")
    slip = first(run, "slip_start")
    sticks = slip is None
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
    return Outcome(
        "third period: sticks until it bounces up",
        computed,
        Verdict.REPRODUCED if sticks else Verdict.DIFFERS,
        "as F_n → 0, sticking still needs F_t ≈ −m l θ̇² cosθ/(1 + 3 sin²θ), more than friction "
        f"can give; the velocities then change by {largest:.0e} m/s or rad/s at most",
        data,
        panels,
    )


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


def compute_pendulum(bench: Workbench) -> Outcome:
    """§3.3: the period to compare the impact with."""
    p = {q.name: q.default for q in bench.rod.system.parameters}
    # About its end the rod has the moment of inertia 4 m l²/3; its centre is l away.
    period = 2 * math.pi * math.sqrt(4 * p["l"] / (3 * p["g"]))
    impact = needed(bench.run(IMPACT), "separation").time
    return features(
        "impact short against the pendulum's 2.3 s",
        f"pendulum {period:.3f} s, impact {impact:.1e} s",
        {"period": PENDULUM_PERIOD.matches(period), "short": impact < 1e-3 * period},
        data={"period": period, "impact": impact},
    )


def compute_border(bench: Workbench) -> Outcome:
    """§3.3: near the border θ̇ leaves the inconsistent field, unless E is large."""
    rows, impact = list[list[Any]](), {}
    for modulus, case in BORDER.items():
        run = bench.run(case)
        last = run.final
        g, l = run.parameters["g"], run.parameters["l"]
        b = l * last["theta_dot"] ** 2 * math.sin(last["theta"]) - g
        impact[modulus] = first(run, "slip_stop") is not None
        rows.append([modulus, impact[modulus], run.final_time, b])
    checks = {
        "soft: no impact, B becomes positive": not impact[SOFT] and rows[0][3] > 0,
        "stiff: impact without collision": impact[STIFF],
    }
    columns = ["E (Pa)", "slip stops", "separation (s)", "B at separation (m/s²)"]
    return features(
        "near the border θ̇ escapes; rarely so for large E",
        f"from θ̇ = {NEAR_BORDER:.2f}: lifts off at E = {modulus_text(SOFT)}, impact at "
        f"{modulus_text(STIFF)}",
        checks,
        data={"table": table(columns, rows)},
    )


def compute_conclusions(bench: Workbench) -> Outcome:
    """§4: the three conclusions, without surface energy."""
    impact = bench.run(IMPACT)
    checks = {
        "(1) one solution: the softened rod takes it": (
            rigid(bench, 1).case is ContactCase.SLIP
            and settling_time(bench, bench.run(SLIDING[STIFF])) < SLIDING[STIFF].t_end
        ),
        "(2) two solutions: it jumps up": (
            rigid(bench, 4).case is ContactCase.INDETERMINATE
            and not bench.run(JUMP_UPS[0.0]).events
        ),
        "(3) none: impact without collision": (
            rigid(bench, 3).case is ContactCase.INCONSISTENT
            and needed(impact, "separation").state["y_A_dot"] > 0
        ),
    }
    return features(
        "one solution: taken; two: jumps up; none: IW/OC",
        "the same from Tables 1, 4 and 3 without surface energy",
        checks,
    )


_DIFFERS = Verdict.DIFFERS
ENTRIES = (
    Entry("stable-force", GROUP, "§3.1: F_n becomes stable", compute_stable, _DIFFERS),
    Entry("small-energy", GROUP, "§3.1: small surface energy", compute_small_energy),
    Entry("stick-time", GROUP, "§3.3: first period", compute_stick_time),
    Entry("energy-portions", GROUP, "§3.3: energy of the first period", compute_portions),
    Entry(
        "sticking-compression",
        GROUP,
        "§3.3: length of the second period",
        compute_sticking_compression,
        _DIFFERS,
    ),
    Entry("rotation", GROUP, "§3.3: rotation in the second period", compute_rotation, _DIFFERS),
    Entry("third-period", GROUP, "§3.3: third period", compute_third_period, _DIFFERS),
    Entry("pendulum", GROUP, "§3.3: time scale", compute_pendulum),
    Entry("border", GROUP, "§3.3: near the border", compute_border),
    Entry("conclusions", GROUP, "§4: conclusions (1)–(3)", compute_conclusions),
)
