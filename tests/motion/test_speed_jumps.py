"""Surfaces whose speed jumps at known times: triangle waves, against closed forms and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import sawtooth

import painleve_sym as ps
from painleve_sym.mechanics import TIME, triangle
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text

BLOCK = """
name = "block-on-a-surface"
gravity = "g"
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
[parameters]
m = { default = 1.5, unit = "kg", positive = true }
g = { default = 9.8, unit = "m/s^2" }
mu = { default = 0.3, unit = "1" }
a = { default = 0.02, unit = "m" }
b = { default = 0.0, unit = "m" }
T = { default = 0.4, unit = "s" }
[[bodies]]
mass = "m"
centre = ["x", "y"]
[[contacts]]
name = "table"
point = ["x", "y"]
through = ["b*triangle(t, T, 0.5, T/4)", "a*triangle(t, T)"]
friction = "mu"
"""
G = 9.8


@pytest.fixture(scope="module")
def block():
    return mechanism_from_text(BLOCK, "block.toml", "block")


@given(
    time=st.floats(-10, 10),
    period=st.floats(0.1, 3),
    duty=st.floats(0.1, 0.9),
    delay=st.floats(-1, 1),
)
def test_a_triangle_wave_is_that_of_scipy(time, period, duty, delay):
    value = float(triangle(TIME, period, duty, delay).subs(TIME, time).doit())
    assert value == pytest.approx(sawtooth(2 * np.pi * (time - delay) / period, duty), abs=1e-9)


def test_its_rate_is_a_square_wave():
    rate = sp.diff(triangle(TIME, 2), TIME)
    assert [float(rate.subs(TIME, t).doit()) for t in (0.5, 1.5, 2.5)] == [2.0, -2.0, 2.0]


def test_a_resting_block_is_thrown_where_the_table_turns_down(block):
    """The table turns from 4 a/T up to as much down: the block leaves with the speed of the table.

    It is in free fall until the table meets it again, by hand.
    """
    a, T = 0.02, 0.4
    v = 4 * a / T
    run = ps.simulate(
        block, ps.laws.rigid(e=0.5), {"y": -a, "y_dot": v}, t_end=1.2 * T, parameters={"mu": 0.0}
    )
    (leaves, *_), (lands, *_) = run.events_of("liftoff"), run.events_of("touchdown")
    assert leaves.time == T / 2 and T / 2 in run.t
    # y = a + v s − g s²/2 and the table a − v s.
    fall = 4 * v / G
    assert lands.time == pytest.approx(T / 2 + fall, rel=1e-9)
    assert run.at_events("gap_rate_before_touchdown")[0] == pytest.approx(-2 * v, rel=1e-9)
    assert run.at_events("gap_rate_after_touchdown")[0] == pytest.approx(v, rel=1e-9)
    assert run.final["y"] - run.final_outputs["gap"] == pytest.approx(
        a * sawtooth(2 * np.pi * 1.2, 0.5), abs=1e-9
    )


def test_a_table_that_turns_up_strikes_a_resting_block(block):
    a, T, e = 0.02, 4.0, 0.6
    v = 4 * a / T
    start = {"y": a * 0.5, "y_dot": -v}
    shifted = {"mu": 0.0, "T": T}
    late = ps.simulate(
        block, ps.laws.rigid(e=0.0), start | {"t": 0.625 * T}, t_end=0.1, parameters=shifted
    )
    assert late.final["y_dot"] == pytest.approx(-v) and late.final_outputs["normal_force"] > 0
    run = ps.simulate(
        block, ps.laws.rigid(e=e), start | {"t": 0.625 * T}, t_end=0.4 * T, parameters=shifted
    )
    impact = run.events_of("impact")[0]
    assert impact.time == pytest.approx(0.375 * T, rel=1e-12)
    assert run.at_events("gap_rate_before_impact")[0] == pytest.approx(-2 * v, rel=1e-9)
    assert run.at_events("gap_rate_after_impact")[0] == pytest.approx(2 * v * e, rel=1e-9)


def test_a_block_on_a_belt_that_turns_slips_until_it_has_its_speed(block):
    """Between turns the block slips under μ g or sticks: velocities by hand, in pieces."""
    b, T, mu = 0.05, 1.0, 0.3
    u = 4 * b / T
    run = ps.simulate(
        block, "rigid", {"x_dot": -u}, t_end=1.1, parameters={"a": 0.0, "b": b, "T": T, "mu": mu}
    )
    slip = 2 * u / (mu * G)  # from each turn on
    assert [e.time for e in run.events_of("slip_stop")] == pytest.approx(
        [0.25 + slip, 0.75 + slip], rel=1e-9
    )
    times = np.linspace(0.01, 1.09, 37)

    def velocity(t):
        phase = (t - 0.25) % 1.0
        since, sign = phase % 0.5, 1 if phase < 0.5 else -1
        return sign * min(-u + mu * G * since, u) if t > 0.25 else -u

    assert run.values("x_dot", times) == pytest.approx([velocity(t) for t in times], abs=1e-9)
    assert run.energy_closes


def test_a_compliant_contact_follows_a_table_that_turns(block):
    """SciPy in pieces between the turns of the table; the contact stays pressed."""
    a, T, k, c, m, end = 2e-4, 0.2, 4000.0, 10.0, 1.5, 0.45
    law = ps.laws.linear(k=k, c=c)

    def rates(t, y, turns):
        table = a * sawtooth(2 * np.pi * t / T, 0.5)
        return [y[1], (k * (table - y[0]) + c * (turns * 4 * a / T - y[1])) / m - G]

    state, t = [-a - m * G / k, 0.0], 0.0
    for turns, stop in zip((1, -1, 1, -1, 1), (0.1, 0.2, 0.3, 0.4, end), strict=True):
        piece = solve_ivp(rates, (t, stop), state, "DOP853", rtol=1e-12, atol=1e-15, args=(turns,))
        state, t = piece.y[:, -1], stop
    run = ps.simulate(
        block,
        law,
        {"y": -a - m * G / k},
        t_end=end,
        parameters={"mu": 0.0, "a": a, "T": T, "m": m},
    )
    assert not run.events_of("separation") and run.energy_closes
    assert run.final["y"] == pytest.approx(state[0], rel=1e-8)
    assert run.final["y_dot"] == pytest.approx(state[1], rel=1e-6)


def test_it_is_named_before_the_run(block):
    (notice,) = block.notices
    assert notice.startswith("Contact table: the speed of its surface jumps")
    run = ps.simulate(block, "rigid", {"y": 0.1}, t_end=0.01)
    assert notice in run.notices


def test_a_batch_is_its_single_motions(block):
    speeds = np.array([0.0, 0.1, 0.2])
    given_ = {"t_end": 0.5, "parameters": {"mu": 0.2, "b": 0.01}}
    batch = ps.simulate_batch(block, "rigid", {"y": 0.01, "x_dot": speeds}, **given_)
    for i, speed in enumerate(speeds.tolist()):
        run = ps.simulate(block, "rigid", {"y": 0.01, "x_dot": speed}, **given_)
        assert batch["y"][i] == run.final["y"] and batch["x_dot"][i] == run.final["x_dot"]
