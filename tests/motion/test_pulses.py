"""Pulses and square waves in formulas, against SciPy in pieces, phases and inputs."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import painleve_sym as ps
from painleve_sym.mechanics import TIME, pulse, square
from painleve_sym.mechanics.pulses import Edges
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.batch.run import run_batch

BETWEEN_STOPS = """
name = "mass-between-stops"
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
m = { default = 1.0, unit = "kg", positive = true }
k = { default = 0.4, unit = "N/m" }
c = { default = 0.1, unit = "N*s/m" }
d = { default = 1.5, unit = "m" }
F = { default = 3.0, unit = "N" }
T = { default = 4.0, unit = "s" }
duty = { default = 0.5, unit = "1" }
delay = { default = 0.0, unit = "s" }
mu = { default = 0.0, unit = "1" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[[springs]]
extension = "x"
stiffness = "k"
damping = "c"
[forces]
x = "FORCE"
[[contacts]]
name = "left"
gap = "x + d"
slip_velocity = "y_dot"
friction = "mu"
[[contacts]]
name = "right"
gap = "d - x"
slip_velocity = "-y_dot"
friction = "mu"
"""


@pytest.fixture(scope="module")
def waved():
    """Return a mass between two stops under a square wave."""
    text = BETWEEN_STOPS.replace("FORCE", "F*square(t, T, duty, delay)")
    return ps.Simulator(mechanism_from_text(text), "rigid")


@pytest.fixture(scope="module")
def forced():
    """Return the same under a force that a parameter gives."""
    return ps.Simulator(mechanism_from_text(BETWEEN_STOPS.replace("FORCE", "F")), "rigid")


def hits_by_scipy(t_end, force=3.0, period=4.0, k=0.4, c=0.1, d=1.5, e=0.75, duty=0.5):
    """Return times and velocities before the hits, by runs between the edges of the force."""
    state, t, hits = [0.0, 0.0], 0.0, []
    edges = sorted(
        float(Fraction(n) * Fraction(period) + part * Fraction(period) * Fraction(duty))
        for n in range(int(t_end / period) + 1)
        for part in (0, 1)
    )
    for edge in [*(e_ for e_ in edges if 0 < e_ < t_end), t_end]:
        sign = 1 if ((t + edge) / 2 / period) % 1 < duty else -1
        while t < edge:

            def rate(_, z, push=sign * force):
                return [z[1], push - k * z[0] - c * z[1]]

            def stop(_, z):
                return d - abs(z[0])

            stop.terminal, stop.direction = True, -1
            run = solve_ivp(rate, (t, edge), state, "DOP853", events=stop, rtol=1e-12, atol=1e-13)
            t, state = float(run.t[-1]), run.y[:, -1].copy()
            if run.status == 1:
                hits.append((t, float(state[1])))
                state = [math.copysign(d, state[0]), -e * state[1]]
    return np.array(hits), state


def test_a_mass_between_stops_under_a_square_wave_hits_when_scipy_says(waved):
    run = waved.run({}, t_end=9.5)
    known, end = hits_by_scipy(9.5)
    hits = [event for event in run.events if event.kind == "impact"]
    assert len(hits) == len(known) > 4
    assert [e.time for e in hits] == pytest.approx(known[:, 0], abs=1e-9)
    after = [-0.75 * v for v in known[:, 1]]
    assert [e.state["x_dot"] for e in hits] == pytest.approx(after, abs=1e-9)
    assert [run.final["x"], run.final["x_dot"]] == pytest.approx(end, abs=1e-9)
    assert {2.0, 4.0, 6.0, 8.0} <= set(run.t)
    assert run.energy_closes and run.parameters["T"] == 4.0 and "pulse_1" not in run.parameters


@settings(max_examples=25)
@given(
    period=st.floats(0.7, 5), duty=st.floats(0.1, 0.9), delay=st.floats(-3, 3), F=st.floats(-4, 4)
)
def test_three_doors_have_one_motion(waved, forced, period, duty, delay, F):
    t_end, far = 6.0, {"d": 100.0}
    given = {"T": period, "duty": duty, "delay": delay, "F": F, **far}
    by_formula = waved.run({}, t_end=t_end, parameters=given)
    ends = [delay + n * period + part for n in range(-9, 14) for part in (0, duty * period)]
    times = [0.0, *sorted(e for e in ends if 0 < e < t_end)]
    middles = [(a + b) / 2 for a, b in itertools.pairwise([*times, t_end])]
    values = [F if ((t - delay) / period) % 1 < duty else -F for t in middles]
    held = {"F": {"times": times, "values": values}}
    by_input = forced.run({}, t_end=t_end, parameters=far, inputs=held)
    phases = [{"time": t, "parameters": {"F": v}} for t, v in zip(times, values, strict=True)]
    by_phases = forced.run({}, t_end=t_end, parameters=far, phases=phases)
    assert (by_phases.final_state == by_input.final_state).all()
    scale = max(abs(by_input.final["x"]), abs(by_input.final["x_dot"]), 1e-3)
    for name in ("x", "x_dot"):
        assert by_formula.final[name] == pytest.approx(by_input.final[name], abs=1e-11 * scale)


def test_edges_follow_parameters_that_change(waved, forced):
    run = waved.run(
        {}, t_end=5.0, parameters={"d": 50.0}, phases=[{"time": 2.5, "parameters": {"T": 1.0}}]
    )
    # Until 2.5 s of period 4, then of period 1.
    times, signs = [0, 2, 2.5, 3, 3.5, 4, 4.5], [1, -1, -1, 1, -1, 1, -1]
    force = {"times": times, "values": [3 * s for s in signs]}
    known = forced.run({}, t_end=5.0, parameters={"d": 50.0}, inputs={"F": force})
    assert run.final["x"] == pytest.approx(known.final["x"], rel=1e-12)
    assert run.t[1:-1].tolist() != [] and set(times) <= set(run.t)


def test_the_time_of_formulas_may_be_ahead(waved):
    early, late = (waved.run({"t": t}, t_end=1.5) for t in (0.0, 1.0))
    assert 1.0 in late.t and 1.0 not in early.t
    again = waved.run({"t": 1.0}, t_end=0.7).continued(1.5)
    assert again.final_state == pytest.approx(late.final_state, rel=1e-12)


def test_a_contact_problem_has_the_pulse_of_its_time(waved):
    block = waved.mechanism.only("left")
    before, after = (ps.classify(block, {"x": -1.5, "t": t}).problem.b[0] for t in (1.9, 2.0))
    assert before - after == pytest.approx(6.0)


def test_pulses_print_and_have_values_as_sympy_has_them():
    wave = 2 + 3 * square(TIME, 2, sp.Rational(1, 4), 1) + pulse(TIME - 1, 2)
    times = np.array([-0.75, 0.0, 0.9, 1.0, 1.49, 1.5, 2.9, 3.0])
    known = [2 + (3 if (t - 1) % 2 < 0.5 else -3) + (t >= 3) for t in times]
    assert [float(wave.subs(TIME, t).doit()) for t in times] == known
    assert sp.lambdify(TIME, wave, "math")(1.49) == 5
    assert sp.lambdify(TIME, wave, "numpy")(times).tolist() == known
    assert wave.diff(TIME) == 0 and str(pulse(TIME, 1, 2)) == "pulse(t, 1, 2)"
    assert "floor" in sp.ccode(square(TIME, 2))


def test_edges_of_a_pulse_are_where_it_changes():
    own = Edges(0.3, 0.2, 0.7)
    times, t = [], -1.0
    while (t := own.after(t)) < 3:
        times.append(t)
    assert len(times) == 11 and own.after(0.5) == pytest.approx(1.0)
    for time in times:
        assert own.value(time - 1e-9) != own.value(time + 1e-9)
    assert Edges(0.0, 0.0, 1.0).after(0.2) == 1.0 and Edges(1.0).after(1.0) == math.inf


@pytest.mark.parametrize(
    ("formula", "message"),
    [
        ("F*square(2*t, T)", "Fix: write t, plus a constant"),
        ("F*square(x, T)", "got x as its time"),
        ("F*pulse(t, x)", "got x in its arguments"),
        ("F*pulse(t, 1, 2, t)", "got t in its arguments"),
        ("F*square(t)", "square: got 1, need 2 to 4 arguments"),
        ("F*abs(sin(t))", "square(t, period)"),
    ],
)
def test_pulses_at_unknown_times_are_faults_of_the_mechanism(formula, message):
    with pytest.raises(ps.ModelError) as error:
        mechanism_from_text(BETWEEN_STOPS.replace("FORCE", formula))
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [({"T": 0.0}, "period"), ({"T": -1.0}, "need"), ({"T": 1e-9}, "more than 50,000 edges")],
)
def test_periods_that_have_no_motion_are_one_sentence(waved, parameters, message):
    with pytest.raises(ps.InputError, match=message):
        waved.run({}, t_end=1.0, parameters=parameters)


def test_what_does_not_cut_a_motion_says_so(waved):
    with pytest.raises(ps.InputError, match="its formulas have pulses"):
        waved.sensitivities({}, ["F"], t_end=1.0)
    assert waved.casadi("motion").states  # equations are those of each time


def test_rows_of_a_batch_have_edges_of_their_own(waved):
    periods = [3.0, 4.0]
    batch = run_batch(waved, {"x": 0.0}, {"T": periods}, t_end=9.5)
    runs = [waved.run({}, t_end=9.5, parameters={"T": T}) for T in periods]
    assert batch["x_dot"].tolist() == [run.final["x_dot"] for run in runs]
    assert batch["count_of_impact"].tolist() == [len(run.events_of("impact")) for run in runs]
    assert batch.trajectory(0) == runs[0]


BLOCK = Path(__file__).parents[2] / "examples" / "mechanisms" / "block-under-a-pulse.toml"
B, H, OMEGA, GRAVITY = 0.1, 0.5, 12.0, 9.8


def rocking_by_scipy(a, t_end, most):
    """Return impacts and whether the block overturns, by Housner (1963) and SciPy in pieces."""
    alpha, period = math.atan2(B, H), 2 * math.pi / OMEGA
    p2, kept = 0.75 * GRAVITY / math.hypot(B, H), 1 - 1.5 * math.sin(alpha) ** 2
    t, side, state, hits = math.asin(GRAVITY * B / H / a) / OMEGA, 1, np.zeros(2), []
    while t < t_end and len(hits) < most:
        push = a / GRAVITY if t < period else 0.0

        def rate(t, z, side=side, push=push):
            lean = side * alpha - z[0]
            return [z[1], p2 * (push * math.sin(OMEGA * t) * math.cos(lean) - math.sin(lean))]

        def hit(_, z, side=side):
            return side * z[0]

        def lies(_, z):
            return math.pi / 2 - abs(z[0])

        hit.terminal, hit.direction, lies.terminal = True, -1, True
        end = period if t < period else t_end
        run = solve_ivp(rate, (t, end), state, "DOP853", events=[hit, lies], rtol=1e-11, atol=1e-13)
        t, state = float(run.t[-1]), run.y[:, -1].copy()
        if len(run.t_events[1]):
            return np.array(hits), True
        if run.status == 1:
            hits.append((t, kept * state[1]))
            state, side = np.array([0.0, kept * state[1]]), -side
    return np.array(hits), False


@pytest.mark.parametrize("a", [2.5, 4.5, 6.5, 7.5, 8.5])
def test_a_block_under_a_pulse_rocks_and_overturns_as_housner_says(a):
    run = ps.simulate(BLOCK, ps.laws.rigid(e=0.0), {}, t_end=3.0, parameters={"a": a})
    known, overturns = rocking_by_scipy(a, 3.0, 4)
    angle = np.abs(run.values("phi", run.sample(3000)))
    assert bool((angle > math.pi / 2).any()) == overturns
    upright = run.sample(3000)[np.argmax(angle > math.pi / 2)] if overturns else 3.0
    hits = [e for e in run.events_of("impact") if e.time < upright][:4]
    assert len(hits) == len(known)
    for event, (time, rate) in zip(hits, known, strict=True):
        assert event.time == pytest.approx(time, rel=1e-9)
        assert event.state["phi_dot"] == pytest.approx(rate, rel=1e-8)
    assert np.min(np.abs(run.t - 2 * math.pi / OMEGA)) < 1e-15
