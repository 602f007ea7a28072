"""When does a bar jam? The kernel beside SciPy and the package, the invariant, k* and the page."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import painleve_sym as ps
from tests.study.study_scripts import study_script

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples" / "studies" / "rigid_rod"
PAGE = (ROOT / "docs" / "rigid-rod.md").read_text("utf-8")
DATA = json.loads((FOLDER / "landing.json").read_text("utf-8"))
RUNS = json.loads((FOLDER / "rigid-rod.json").read_text("utf-8"))["runs"]

study = study_script("rigid_rod/landing.py")
theory = study.theory()

STEEL = theory.Bar()
HERTZ = study.hertz(STEEL)


def motion(modes, theta, mu, t_end, approach=0.0, law=HERTZ):
    """Return SciPy's motion of the modes on an elastic contact, without slip stops."""
    (normal,), (along,), (push,) = modes.rows(theta, mu)
    n = len(normal)

    def depth(t, q):
        return approach * t + study.G * t * t / 2 - normal @ q

    def field(t, y):
        force = law.K * max(depth(t, y[:n]), 0.0) ** law.n
        return np.concatenate([y[n:], push * force / modes.mass - modes.rates**2 * y[:n]])

    run = solve_ivp(
        field, (0, t_end), np.zeros(2 * n), method="DOP853", rtol=1e-11, atol=1e-16,
        dense_output=True, max_step=0.5 / max(modes.rates.max(), 1.0),
    )  # fmt: skip
    return run, depth, along, normal, push


# ---- the kernel ----


@pytest.mark.parametrize("counts", [(0, 0), (1, 0), (4, 2)])
def test_stop_and_peak_are_those_of_another_integrator(counts):
    modes = study.Modes(STEEL, *counts)
    ends = study.slide(modes, HERTZ, 1.0, 1.4, 1.0, fineness=0.2)
    (stop,), (peak,) = ends["stop"], ends["peak"]
    run, depth, along, *_ = motion(modes, 1.0, 1.4, 1.01 * stop)
    n = len(along)
    exact = brentq(lambda t: along @ run.sol(t)[n:] - 1.0, 0.9 * stop, 1.01 * stop)
    assert stop == pytest.approx(exact, rel=2e-5)
    t = np.linspace(0, exact, 2001)
    force = [HERTZ.K * max(depth(x, run.sol(x)[:n]), 0.0) ** 1.5 for x in t]
    assert peak == pytest.approx(max(force), rel=2e-3)  # the kernel's is that of a whole step


def test_modes_tend_to_the_closed_receptances_of_all_modes():
    """At a growth rate: with order 3 in bending modes, with order 1 along the axis."""
    p = 1000.0
    exact = [g[0] for g in theory.euler_bernoulli(STEEL)(np.array([p]))]
    left = []
    for counts in ((40, 20), (80, 40)):
        modes = study.Modes(STEEL, *counts)
        weights = 1 / (modes.mass * (p**2 + modes.rates**2))
        sums = modes.across**2 @ weights, modes.along**2 @ weights
        left.append([1 - s / e for s, e in zip(sums, exact, strict=True)])
    assert 0 < left[1][0] < 2e-4 and 0 < left[1][1] < 1e-3
    assert left[0][0] / left[1][0] == pytest.approx(8, rel=0.05)
    assert left[0][1] / left[1][1] == pytest.approx(2, rel=0.05)


@pytest.mark.slow
def test_forces_drive_the_modes_as_the_mobility_of_the_package_has_it():
    bending = ps.model("rod-bending:2,1")
    modes = study.Modes(STEEL, 2, 1)
    for theta, mu in ((0.7, 0.9), (1.3, 0.4)):
        (normal,), _, (push,) = modes.rows(theta, mu)
        at = ps.classify(bending, {"theta": theta, "x_A_dot": -1.0}, parameters={"mu": mu})
        W = at.problem.W
        assert normal @ push / modes.mass == pytest.approx(W[0, 0] + mu * W[0, 1], rel=1e-12)
        assert normal @ normal / modes.mass == pytest.approx(W[0, 0], rel=1e-12)


@pytest.mark.parametrize("off", [2e-3, -2e-3])
def test_a_landing_by_scipy_is_that_of_the_study(off):
    """The slip stops above the threshold of 8,2 modes, and the end separates below."""
    (row,) = (r for r in DATA["convergence"] if r["modes"] == "8,2")
    modes, mu = study.Modes(STEEL, 8, 2), row["landing 1.0"] + off
    (normal,), (along,), (push,) = modes.rows(1.0, mu)
    n = len(normal)

    def gap(t, y):
        return normal @ y[:n] - study.G * t * t / 2 if t > 1e-5 else -1.0

    def slip(_, y):
        return along @ y[n:] - 1.0

    def field(t, y):
        force = HERTZ.K * max(study.G * t * t / 2 - normal @ y[:n], 0.0) ** 1.5
        return np.concatenate([y[n:], push * force / modes.mass - modes.rates**2 * y[:n]])

    for event in (slip, gap):
        event.terminal, event.direction = True, 1
    run = solve_ivp(
        field, (0, study.PERIODS * study.contact_time(modes, HERTZ)), np.zeros(2 * n),
        method="DOP853", rtol=1e-11, atol=1e-15, events=(slip, gap), max_step=2e-5,
    )  # fmt: skip
    assert bool(len(run.t_events[0])) == (off > 0)
    assert math.isfinite(study.slide(modes, HERTZ, 1.0, mu, 1.0)["stop"][0]) == (off > 0)


def test_stops_at_a_held_angle_are_those_of_the_package():
    """The package lets the angle turn and follows every event."""
    rows = {r["modes"]: r for r in DATA["convergence"]}
    for name in ("8,2", "4,1"):
        for run in RUNS["friction"]:
            if run["model"] == name and run["mu"] in (0.9, 1.1, 1.4):
                assert rows[name][f"stop {run['mu']}"] == pytest.approx(run["slip_stop"], rel=4e-3)


def test_stops_of_an_approaching_bar_are_those_of_the_package():
    """20,10 modes in both: a held angle here, an engine with events there."""
    rows = {(r["approach"], r["mu"]): r for r in DATA["approach"]}
    compared = 0
    for run in RUNS["approach"]:
        if run["model"] in ("8,2", "20,10"):
            stop = rows[-run["y_A_dot"], run["mu"]][f"stop {run['model']}"]
            assert (stop is None) == (run["slip_stop"] is None)
            if stop is not None:
                assert stop == pytest.approx(run["slip_stop"], rel=0.06)
                compared += 1
    assert compared == 10


def test_numbers_of_the_study_are_computed_again():
    for row in DATA["convergence"][:4]:
        modes = study.Modes(STEEL, *map(int, row["modes"].split(",")))
        law = study.Contact(HERTZ.K, 1.5, 0.75)
        stop = study.slide(modes, law, 1.0, 1.1, 1.0, window=0.03, bounces=True)["stop"]
        assert stop[0] == pytest.approx(row["stop 1.1"], rel=1e-7)
        assert float(study.landing(modes, HERTZ, 1.4, 1.0)) == row["landing 1.4"]


# ---- (a): the invariant ----


@pytest.mark.parametrize(
    ("theta", "mu", "approach"),
    [
        *((1.0, 0.62, 0.1), (1.3, 0.25, 0.2)),
        *(pytest.param(1.0, mu, 0.1, marks=pytest.mark.slow) for mu in (0.3, 0.5)),
    ],
)
def test_invariant_keeps_its_value_through_lift_offs(theta, mu, approach):
    modes = study.Modes(STEEL, 8, 2)
    run, depth, _, normal, push = motion(modes, theta, mu, 0.02, approach)
    D, m, rigid = push / normal, modes.mass, modes.rates == 0
    assert (D > 0).all()
    force = study.G * m / (normal * push)[rigid].sum()
    resting = (force / HERTZ.K) ** (1 / HERTZ.n)
    offset = np.where(rigid, 0.0, push * force / m / np.where(rigid, 1.0, modes.rates) ** 2)
    t = np.linspace(0, 0.02, 4001)
    y = run.sol(t)
    n = len(normal)
    lifted = 0
    values = []
    for time, q, p in zip(t, y[:n].T, y[n:].T, strict=True):
        d = depth(time, q)
        lifted += d < 0
        # Rigid motions of uniform sliding accelerate under the resting force.
        at = offset + np.where(rigid, push * force / m * time**2 / 2, 0.0)
        pace = np.where(rigid, push * force / m * time, 0.0)
        # They take the approach, too: here all of it across the bar.
        pace[0] += approach / normal[0]
        eta, rate = q - at, p - pace
        stored = HERTZ.K * (max(d, 0.0) ** 2.5 - resting**2.5) / 2.5
        energies = m / (2 * D) * (rate**2 + (modes.rates * eta) ** 2)
        values.append(float(energies.sum()) + stored - force * (d - resting))
    assert lifted > 100
    assert min(values) >= 0
    assert max(values) == pytest.approx(min(values), rel=1e-8)


@settings(max_examples=20)
@given(st.floats(0.6, 1.4), st.floats(0.1, 0.98), st.floats(100, 1e6))
def test_fast_slip_does_not_stop_in_the_window_below_cot_theta(theta, part, speed):
    modes = study.Modes(STEEL, 4, 2)
    ends = study.slide(modes, HERTZ, theta, part / math.tan(theta), speed, bounces=True)
    assert np.isnan(ends["stop"]).all()


def test_slips_below_cot_theta_stop_by_the_friction_of_uniform_sliding():
    """The rigid rod's mean force m g/A slows them; deviations from it add a hundredth."""
    mu, (c, s) = 0.6, (math.cos(1), math.sin(1))
    slowing = (mu * (4 * s * s + c * c) - 3 * s * c) / (4 * c * c + s * s - 3 * mu * s * c)
    times = []
    for row in DATA["below cot"]:
        assert row["mu"] == mu < 1 / math.tan(row["theta"])
        assert row["stop"] == pytest.approx(row["speed"] / (slowing * study.G), rel=0.02)
        times.append(f"{row['stop']:.4f}")
    assert f"after {' and '.join(times)} s" in " ".join(PAGE.split())


# ---- ends with a radius ----


@pytest.mark.parametrize("counts", [(0, 0), (4, 2)])
def test_end_of_a_tiny_radius_is_that_of_radius_zero(counts):
    """Drift and turning are then one rigid motion; all modes agree as well."""
    point, ball = (study.Modes(STEEL, *counts, radius) for radius in (0.0, 1e-9))
    for a in point.rows(0.8, 0.9), ball.rows(0.8, 0.9):
        assert len(a) == 3
    ends = [study.slide(m, HERTZ, 1.0, 1.4, 1.0) for m in (point, ball)]
    for key in ("stop", "peak"):
        assert ends[0][key] == pytest.approx(ends[1][key], rel=1e-6)


def test_mobility_of_a_round_end_is_that_of_a_rigid_body_with_the_point_below_its_axis():
    """The point R below A: W = (J M⁻¹ Jᵀ) of a rod of moment of inertia m L²/12."""
    theta, mu, radius = 0.9, 0.7, 0.05
    modes = study.Modes(STEEL, 0, 0, radius)
    (normal,), (along,), _ = modes.rows(theta, mu)
    arm = -np.array([math.cos(theta), math.sin(theta)]) * STEEL.length / 2 - [0, radius]
    J = np.array([[0, 1, arm[0]], [1, 0, -arm[1]]])
    m = STEEL.mass
    W = J @ np.diag([1 / m, 1 / m, 12 / (m * STEEL.length**2)]) @ J.T
    own = np.array([normal, along])
    assert own @ own.T / m == pytest.approx(W, rel=1e-12)


def test_slopes_of_the_bending_modes_are_those_of_their_shapes():
    """A difference quotient of cosh + cos - σ (sinh + sin) with free ends."""
    modes, radius = study.Modes(STEEL, 4, 0, 1.0), 1.0
    for b, swing in zip(theory.wavenumbers(4), modes.swing[2:6], strict=True):
        sigma = (math.cosh(b) - math.cos(b)) / (math.sinh(b) - math.sin(b))

        def shape(x, b=b, sigma=sigma):
            return math.cosh(b * x) + math.cos(b * x) - sigma * (math.sinh(b * x) + math.sin(b * x))

        slope = (shape(1e-6) - shape(-1e-6)) / 2e-6 / STEEL.length
        assert swing == pytest.approx(radius * slope, rel=1e-6)


def test_point_mass_at_the_end_has_the_mobility_of_a_loaded_bar():
    """1/W of the end grows by the mass in both directions (rigid and with modes)."""
    mass = 0.3
    for counts in ((0, 0), (5, 3)):
        modes = study.Modes(STEEL, *counts)
        heavy = modes.loaded(mass)
        for own, name in ((modes.across, "across"), (modes.along, "along")):
            inertia = STEEL.mass / (own @ own)
            loaded = getattr(heavy, name)
            assert STEEL.mass / (loaded @ loaded) == pytest.approx(inertia + mass, rel=1e-9)
        assert np.sum(heavy.rates == 0) == 2
        # Rayleigh: a mass lowers every frequency.
        assert (np.sort(heavy.rates) <= np.sort(modes.rates) * (1 + 1e-9)).all()


@pytest.mark.slow
def test_stop_of_a_round_end_is_that_of_the_package():
    """The slip velocity of the ball's lowest point, in a motion whose angle turns."""
    radius = 0.00645
    round_end = study_script("bench_rod/bench_rod.py").with_round_end("1,0", radius)
    run = ps.simulate(
        round_end, "hertz", {"theta": 1.0, "x_A_dot": -1.0}, t_end=0.01,
        parameters={"mu": 1.1}, until="slip_stop",
    )  # fmt: skip
    ends = [study.slide(study.Modes(STEEL, 1, 0, r), HERTZ, 1.0, 1.1, 1.0)["stop"][0]
            for r in (radius, 0.0)]  # fmt: skip
    assert run.final_time == pytest.approx(ends[0], rel=1e-4)
    assert run.final_time < 0.985 * ends[1]


def test_round_end_lowers_the_landing_as_the_pages_say():
    rows = {r["theta"]: r for r in DATA["round ends"]}
    parts = [1 - r["ball 48,24"] / r["point 48,24"] for r in rows.values()]
    assert f"by {100 * min(parts):.0f} to {100 * max(parts):.0f} %" in PAGE
    opening = " ".join(PAGE.split("## Assumptions")[0].split())
    low, high = (f"{rows[1.0][f'{name} 48,24']:.3f}" for name in ("ball", "point"))
    assert f"from {low} instead of {high}" in opening
    # The stop of the study, by SciPy, a little above the landing of 8,2 modes and a ball.
    modes = study.Modes(STEEL, 8, 2, 0.00645)
    mu = float(study.landing(modes, HERTZ, 1.0, 1.0)) + 2e-3
    (stop,) = study.slide(modes, HERTZ, 1.0, mu, 1.0, fineness=0.2)["stop"]
    run, _, along, *_ = motion(modes, 1.0, mu, 1.01 * stop)
    assert along @ run.sol(stop)[len(along) :] == pytest.approx(1.0, rel=1e-4)


# ---- k* ----


def test_angle_cancels_where_the_bar_and_the_rigid_rod_part():
    """The two conditions of the page are one, for all numbers."""
    k, b, a, theta = sp.symbols("k G_b G_a theta", positive=True)
    c, s = sp.cos(theta), sp.sin(theta)
    condition = (4 * c**2 + s**2) * (b - a) - 3 * (1 / k + c**2 * b + s**2 * a)
    assert sp.simplify(condition - (b - 4 * a - 3 / k)) == 0


@settings(max_examples=30)
@given(st.floats(3.2, 1000))
def test_give_of_the_end_falls_with_the_rate_where_it_is_positive(slender):
    """Rigid parts cancel, so that sums over modes have no rounding of theirs."""
    bar = theory.round_bar(slender)
    across, along = (w[:, None] ** 2 for w in bar.frequencies(200, 200))
    square = np.geomspace(1.0, 1e7, 1000) ** 2
    give = (4 / (square + across)).sum(axis=0) - (8 / (square + along)).sum(axis=0)
    slope = (8 / (square + along) ** 2).sum(axis=0) - (4 / (square + across) ** 2).sum(axis=0)
    assert (slope[give > 0] < 0).all()
    assert give[0] / bar.mass == pytest.approx(3 / theory.rigid_up_to(bar), rel=0.03) or slender < 6


@settings(max_examples=25)
@given(st.floats(12, 300), st.floats(0.3, 1.5), st.floats(0.2, 1.5), st.floats(0.1, 10))
def test_stiffness_that_parts_bar_and_rigid_rod_is_one_for_all_angles(slender, one, two, factor):
    bar = theory.round_bar(slender)
    k, form, rigid = (
        factor * theory.rigid_up_to(bar),
        theory.euler_bernoulli(bar),
        theory.rigid(bar),
    )
    if abs(factor - 1) < 0.02:
        return
    lower = [theory.threshold(form, x, k)[0] < theory.threshold(rigid, x)[0] * (1 - 1e-6)
             for x in (one, two)]  # fmt: skip
    assert lower == [factor > 1] * 2


# ---- thresholds ----


def test_four_thresholds_are_in_order_at_every_angle():
    for row in DATA["angles"]:
        assert row["cot"] < row["coupling"] < row["landing 48,24"] < row["divergence"]
        assert row["divergence"] < row["divergence at 9.8 N"] < row["rigid rod"]
        assert row["landing 48,24"] < row["landing of the rigid rod"]


def test_order_of_landing_and_divergence_is_that_of_slender_bars():
    rows = {r["slenderness"]: r for r in DATA["slenderness"]}
    for ratio, row in rows.items():
        assert (row["landing"] > row["divergence"]) == (ratio < 100)
    short = rows[10]["landing"] / rows[10]["landing of the rigid rod"]
    parts = [r["landing 48,24"] / r["landing of the rigid rod"] for r in DATA["angles"]
             if r["theta"] < 1.45]  # fmt: skip
    words = f"{min(parts):.2f} to {max(parts):.2f} of the rigid rod's friction; a bar of 10"
    assert f"{words} diameters needs {short:.2f} of it" in " ".join(PAGE.split())


def test_window_has_no_part_in_the_landing_of_a_bar():
    """Unlike that of a rigid rod, which does not separate from an elastic contact."""
    polymer = ps.material("polymer")
    soft = theory.round_bar(200, density=polymer.density, modulus=polymer.young_modulus,
                            poisson=polymer.poisson_ratio)  # fmt: skip
    for bar, contact in ((STEEL, HERTZ), (soft, study.hertz(soft, soft.radius))):
        modes, angles = study.Modes(bar, 8, 4), np.array([1.0, 1.2, 1.4])
        time = study.contact_time(modes, contact)
        short, long = (study.landing(modes, contact, angles, 1.0, steps=12, window=n * time)
                       for n in (6, 30))  # fmt: skip
        assert short == pytest.approx(long, abs=1e-9)
    # The rigid rod's depends on it, and the page has both.
    rows = {r["theta"]: r for r in DATA["angles"]}
    words = " ".join(PAGE.split())
    within, first = ([rows[x][name] for x in (1.0, 1.4)]
                     for name in ("rigid rod, 6 ms", "landing of the rigid rod"))  # fmt: skip
    assert "it needs {:.4f} at θ = 1 and {:.4f} at 1.4 ".format(*within) in words
    assert "instead of {:.4f} and {:.4f}".format(*first) in words
    leaning = [r for r in DATA["angles"] if r["theta"] < 1.45]
    low, high = ([f(r["landing 48,24"] / r[name] for r in leaning) for name in (
        "rigid rod, 6 ms", "landing of the rigid rod")] for f in (min, max))  # fmt: skip
    ends = "is {:.2f} to {:.2f} instead of {:.2f} to {:.2f}"
    assert ends.format(low[0], high[0], low[1], high[1]) in words


@pytest.mark.parametrize("mu", [0.9, 1.3])
def test_slip_of_a_rigid_bounce_is_that_of_scipy(mu):
    modes = study.Modes(STEEL, 0, 0)
    run, depth, along, *_ = motion(modes, 1.0, mu, 5e-3)
    t = np.linspace(1e-4, 5e-3, 4901)
    depths = np.array([depth(x, run.sol(x)[:2]) for x in t])
    first = np.flatnonzero((depths[1:-1] < depths[:-2]) & (depths[1:-1] <= depths[2:]))[0] + 1
    assert abs(depths[first]) < 1e-3 * depths.max()
    slowed = along @ run.sol(t[first])[2:]
    assert study.slip_of_a_bounce(modes, HERTZ, 1.0, mu) == pytest.approx(slowed, rel=1e-3)
    (least,) = study.rigid_landing(modes, HERTZ, 1.0, slowed)
    assert least == pytest.approx(mu, rel=1e-3)


def test_words_on_modes_and_materials_have_the_numbers_of_the_tables():
    words = " ".join(PAGE.split())
    kept = json.loads((FOLDER / "rigid-rod.json").read_text("utf-8"))["thresholds"]["angle"]
    rows = {r["theta"]: r for r in kept}
    parts = {round(100 * (r["rigid"] - r["1,0"]) / (r["rigid"] - r["all"]))
             for r in rows.values()}  # fmt: skip
    assert len(parts) == 1 and f"One bending mode makes {parts.pop()} % of" in words
    most = max(r["20,20"] / r["all"] - 1 for r in rows.values())
    assert f"20,20 modes are within {math.ceil(1000 * most) / 10:.1f} % of all" in words
    grids = {n: np.min(grid, axis=1) for n, grid in DATA["maps"]["landing"].items()}
    falls = 100 * (1 - grids["wood"] / grids["steel"])
    assert f"the landing falls by {min(falls):.0f} to {max(falls):.0f} %" in words
    rubber = ps.material("rubber")
    bar = theory.round_bar(50, density=rubber.density, modulus=rubber.young_modulus,
                           poisson=rubber.poisson_ratio)  # fmt: skip
    time = study.contact_time(study.Modes(bar, 0, 0), study.hertz(bar, bar.radius))
    assert f"its contact time is {1e3 * time:.0f} ms at 50 diameters" in words


def test_short_bars_grow_by_their_damping_alone():
    """At 10 diameters the growth is proportional to ζ, at 20 it is not."""
    rates = {}
    for ratio in (10, 20):
        bar = theory.round_bar(ratio)
        k = theory.contact(study.G * bar.mass, radius=bar.radius)[1]
        rates[ratio] = [theory.growth(bar, (24, 12), 1.0, 1.0, k, z).real
                        for z in (0.0, 0.005, 0.01, 0.02)]  # fmt: skip
    assert rates[10][0] < 1e-2 and rates[20][0] > 1000
    assert rates[10][2] / rates[10][1] == pytest.approx(2, rel=1e-2)
    words = "{:.2f}, {:.2f} and {:.2f} 1/s".format(*rates[10][1:])
    assert words in " ".join(PAGE.split())


def test_landing_never_falls_as_the_speed_rises():
    theta = np.array([1.0, 1.3])
    modes = study.Modes(STEEL, 4, 2)
    rows = [study.landing(modes, HERTZ, theta, v) for v in (0.01, 0.3, 1.0, 30.0, 1e3)]
    assert (np.diff(rows, axis=0) >= 0).all()
    for angle in {r["theta"] for r in DATA["speeds"]}:
        own = [r["landing"] for r in DATA["speeds"] if r["theta"] == angle]
        assert own == sorted(own)


def test_fast_slip_on_a_stiff_contact_tends_to_the_divergence_on_a_rigid_one():
    off = {
        (r["theta"], r["modes"], r["factor"]): r["landing"][-1] / r["divergence"] - 1
        for r in DATA["fast"]
    }
    assert off[1.0, "24,12", 0.01] > 0.03 > off[1.0, "24,12", 1.0] > 5e-4
    assert -2e-3 < off[1.0, "24,12", 100.0] < 0
    # The excess does not go away as modes are added.
    assert (
        off[1.0, "8,4", 1.0] < 0 < 9e-4 < off[1.0, "24,12", 1.0] < off[1.0, "80,40", 1.0] < 1.1e-3
    )
    assert 4e-3 < off[1.4, "24,12", 1.0] < off[1.4, "48,24", 1.0] < 6e-3


def test_landing_is_converged_as_the_page_says():
    last = DATA["convergence"][-1]
    assert last["modes"] == "80,40"
    by_modes = {r["modes"]: r for r in DATA["convergence"]}
    for theta in (1.0, 1.4):
        assert abs(by_modes["24,12"][f"landing {theta}"] - last[f"landing {theta}"]) < 3e-4
    late = [by_modes["8,2"][f"stop {mu}"] / last[f"stop {mu}"] for mu in (0.9, 1.1, 1.4)]
    assert f"{100 * min(late) - 100:.0f} to {100 * max(late) - 100:.0f} % later" in PAGE
    ten = [by_modes["24,12"][f"stop {mu}"] / last[f"stop {mu}"] - 1 for mu in (0.9, 1.1, 1.4)]
    assert all(0.08 < x < 0.17 for x in ten)
    fine = [by_modes["48,24"][f"stop {mu}"] / last[f"stop {mu}"] - 1 for mu in (0.9, 1.1, 1.4)]
    assert all(0 < x < 0.03 for x in fine)


# ---- a rigid contact ----


def test_thresholds_of_truncated_bars_on_the_page_are_those_of_their_mobilities():
    printed = {"1,0": 0, "4,0": 0, "8,0": 0, "20,0": 0, "8,2": 0, "20,20": 0}
    for name in printed:
        N, M = map(int, name.split(","))
        across, along = 4 + 4 * N, 1 + 2 * M
        printed[name] = 2 * math.sqrt(across * along) / (across - along)
        # The least of (W_b cos² + W_a sin²)/((W_b - W_a) sin cos) over a grid of angles.
        angle = np.linspace(0.01, 1.56, 20001)
        s, c = np.sin(angle), np.cos(angle)
        direct = ((across * c**2 + along * s**2) / ((across - along) * s * c)).min()
        assert direct == pytest.approx(printed[name], rel=1e-6)
    assert f"| least μ | {' | '.join(f'{v:.4f}' for v in printed.values())} | none |" in PAGE


def test_page_prints_the_tables_and_numbers_of_the_study():
    for text in study.tables(DATA):
        assert text in PAGE, text.splitlines()[0]
    row = next(r for r in DATA["angles"] if r["theta"] == 1.0)
    opening = " ".join(PAGE.split("## Assumptions")[0].split())
    assert f"jams from μ = {row['landing 48,24']:.3f}" in opening
    assert f"needs {row['landing of the rigid rod']:.3f} by the same test" in opening
    assert "end of radius 0" in opening
    least = min(theory.threshold(theory.euler_bernoulli(STEEL), x)[0]
                for x in np.linspace(1.38, 1.41, 31))  # fmt: skip
    assert f"least at {least:.3f}, instead of 4/3" in opening
    papers = ", ".join(f"{r['landing']:.4f}" for r in DATA["paper"])
    assert papers in PAGE


def test_first_yield_is_that_of_the_page():
    aluminium = theory.Bar(modulus=70e9, poisson=0.33)
    force = study.first_yield(aluminium, 0.003, 276e6)
    assert f"{force:.1f} N for a hemisphere of aluminium" in PAGE
    # Hertz's largest pressure then is 1.6 yield strengths: p_0 = (6 F E*²/(π³ R²))^(1/3).
    effective = 70e9 / (2 * (1 - 0.33**2))
    assert (6 * force * effective**2 / (math.pi**3 * 0.003**2)) ** (1 / 3) == pytest.approx(
        1.6 * 276e6, rel=1e-12
    )
