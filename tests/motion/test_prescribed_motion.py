"""Motions on surfaces and with drives that move as prescribed, against SciPy and closed forms."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from painleve_sym.at.cases import classify
from painleve_sym.at.jump import evaluate_jump
from painleve_sym.errors import InputError, StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.toml.mechanism_file import load_mechanism, mechanism_from_text
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.simulator import Simulator
from painleve_sym.motion.time_stepping.stepping import TimeStepper

G = 9.8
TABLE = load_mechanism("examples/mechanisms/oscillating-table.toml")
HEAD = """
gravity = "g"
[parameters]
m = { default = 1.0, unit = "kg", positive = true }
g = { default = 9.8, unit = "m/s^2" }
l = { default = 0.5, unit = "m", positive = true }
a = { default = 0.02, unit = "m" }
omega = { default = 20.0, unit = "rad/s" }
mu = { default = 0.4, unit = "1" }
"""
BODY = """
[[bodies]]
mass = "m"
centre = ["x", "y"]
inertia = "m*l**2/3"
angle = "theta"
"""
PLANE = """
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
theta = { unit = "rad" }
"""


@cache
def on_table(restitution="energetic", engine="auto"):
    return Simulator(TABLE, RigidLaw(restitution), engine)


@cache
def softened(engine="auto"):
    return Simulator(TABLE, law("hunt-crossley"), engine)


# ---- closed forms ----


def test_ball_that_rests_leaves_where_the_table_falls_faster_than_gravity():
    """It rests until a ω² sin(ωt) = g; then it flies to the next zero of the distance."""
    a, omega = 0.02, 40.0
    start = {"y_dot": a * omega}
    run = on_table().run(start, parameters={"a": a, "omega": omega, "b": 0.0}, t_end=0.2)
    leaves = math.asin(G / (a * omega**2)) / omega
    first = next(e for e in run.events if e.kind == "liftoff" and e.time > 0)
    assert first.time == pytest.approx(leaves, rel=1e-10)

    def gap(t):
        s = t - leaves
        rises = a * omega * math.cos(omega * leaves)
        return a * math.sin(omega * leaves) + rises * s - G * s**2 / 2 - a * math.sin(omega * t)

    lands = brentq(gap, leaves + 0.03, leaves + 0.2, xtol=1e-15)
    touch = next(e for e in run.events if e.kind == "touchdown")
    assert touch.time == pytest.approx(lands, rel=1e-10)


def test_bounces_on_the_table_are_those_of_the_closed_form():
    """Flights are parabolas, impacts v⁺ = u − e (v − u) with the speed u of the table."""
    a, omega, e, height = 0.01, 40.0, 0.8, 0.05
    given_values = {"a": a, "omega": omega, "b": 0.0, "e_newton": e}
    run = on_table("newton").run({"y": height}, parameters=given_values, t_end=1.0)
    touches = [event.time for event in run.events if event.kind == "touchdown"]
    y, v, now, expected = height, 0.0, 0.0, []
    while len(expected) < 5:
        times = now + np.linspace(1e-4, 0.5, 5000)
        gaps = y + v * (times - now) - G * (times - now) ** 2 / 2 - a * np.sin(omega * times)
        i = int(np.argmax(gaps < 0))
        land = brentq(
            lambda t, y=y, v=v, now=now: (
                y + v * (t - now) - G * (t - now) ** 2 / 2 - a * math.sin(omega * t)
            ),
            times[i - 1],
            times[i],
            xtol=1e-15,
        )
        u = a * omega * math.cos(omega * land)
        v, y, now = u - e * (v - G * (land - now) - u), a * math.sin(omega * land), land
        expected.append(land)
    assert touches[:5] == pytest.approx(expected, rel=1e-9)
    assert run.energy_residual < 1e-9


def test_block_shaken_level_sticks_and_slips_as_scipy_finds():
    """m ẍ = −μ m g sign(v_t); it sticks while b ω² |sin ωt| ≤ μ g."""
    b, omega, mu, end = 0.02, 20.0, 0.6, 1.5
    assert b * omega**2 > mu * G

    def flow(t, z, s):
        return [z[1], -s * mu * G]

    def speed(t):
        return b * omega * math.cos(omega * t)

    def stops(t, z, s):
        return (z[1] - speed(t)) * s

    stops.terminal, stops.direction = True, -1
    now, z, slips, changes = 0.0, [0.0, 0.8], 1, []
    while now < end:
        # A step away from the event that has just happened.
        solution = solve_ivp(
            flow, (now, end), z, "DOP853", events=stops, args=(slips,),
            rtol=1e-12, atol=1e-13, max_step=1e-3,
        )  # fmt: skip
        now, z = solution.t[-1], list(solution.y[:, -1])
        if now >= end:
            break
        changes.append(now)
        needed = -b * omega**2 * math.sin(omega * now)
        if abs(needed) <= mu * G:
            # The times at which b ω² |sin ωt| reaches μ g from below.
            first = math.asin(mu * G / (b * omega**2)) / omega
            period = math.pi / omega
            later = first + period * math.ceil((now - first) / period)
            if later >= end:
                z[0] += b * (math.sin(omega * end) - math.sin(omega * now))
                break
            z = [z[0] + b * (math.sin(omega * later) - math.sin(omega * now)), speed(later)]
            now, needed = later, -b * omega**2 * math.sin(omega * later)
            changes.append(now)
        slips = 1 if needed < 0 else -1  # the table runs away from the block
        stuck = -slips * mu * G - needed  # how v_t begins to change
        assert slips * stuck >= -1e-9
    values = {"a": 0.0, "b": b, "omega": omega, "mu": mu}
    run = on_table().run({"x_dot": 0.8}, parameters=values, t_end=end)
    kinds = ("slip_stop", "slip_start")
    times = [e.time for e in run.events if e.kind in kinds]
    assert {e.kind for e in run.events} >= set(kinds) and len(changes) > 8
    assert times == pytest.approx(changes, abs=1e-9)
    assert run.final["x"] == pytest.approx(z[0], abs=1e-9)
    assert run.energy_residual < 1e-9


# ---- change of frame ----

TIP = 'point = ["x - l*cos(theta)", "y - l*sin(theta)"]\nfriction = "mu"'


@cache
def rod(surface):
    text = HEAD + PLANE + BODY + f'[[contacts]]\nname = "tip"\n{TIP}\n{surface}\n'
    return mechanism_from_text(text, name="rod")


@cache
def rod_simulator(surface, name):
    mechanism = rod(surface)
    return Simulator(mechanism, RigidLaw()) if name == "rigid" else Simulator(mechanism, law(name))


LIFTED = 'through = ["0", "a*t**2/2"]'
frames = st.fixed_dictionaries(
    {"theta": st.floats(0.4, 1.3), "theta_dot": st.floats(-4, 4), "x_dot": st.floats(-2, 2)}
)


@settings(max_examples=50)
@given(motion=frames, mu=st.floats(0.2, 3), lift=st.floats(-5, 20), now=st.floats(0, 2))
def test_classification_on_a_lifted_table_is_that_with_more_gravity(motion, mu, lift, now):
    """y_table = ½ a t² against g + a: the same coefficients and solutions."""
    up = 0.5 * math.sin(motion["theta"])
    rises = 0.5 * math.cos(motion["theta"]) * motion["theta_dot"]
    start = motion | {"y": up, "y_dot": rises}
    other = start | {"y": up + lift * now**2 / 2, "y_dot": rises + lift * now, "t": now}
    moving = classify(rod(LIFTED), other, parameters={"mu": mu, "a": lift})
    ground = classify(rod(""), start, parameters={"mu": mu, "g": G + lift})
    assert pytest.approx((ground.A, ground.B), rel=1e-10, abs=1e-10) == (moving.A, moving.B)
    if min(abs(ground.A), abs(ground.B)) > 1e-6 and motion["x_dot"] != 0:
        assert moving.case == ground.case
        assert [s.mode for s in moving.solutions] == [s.mode for s in ground.solutions]


@pytest.mark.parametrize("name", ["rigid", pytest.param("hunt-crossley", marks=pytest.mark.slow)])
def test_motion_on_a_lifted_table_is_that_with_more_gravity(name):
    lift, start = 3.0, {"theta": 0.8, "y": 0.6, "x_dot": -0.7, "theta_dot": 1.1}
    on_ground = rod_simulator("", name).run(start, parameters={"g": G + lift}, t_end=0.4)
    # The table has the speed a t from its start at rest on: at t = 0 both frames agree.
    lifted = rod_simulator(LIFTED, name).run(start, parameters={"a": lift}, t_end=0.4)
    assert [e.kind for e in lifted.events] == [e.kind for e in on_ground.events]
    assert len(lifted.events) >= 4
    times = [[e.time for e in run.events] for run in (lifted, on_ground)]
    assert times[0] == pytest.approx(times[1], rel=1e-8)
    moved = {"y": lift * 0.4**2 / 2, "y_dot": lift * 0.4}
    for key in ("x", "y", "theta", "x_dot", "y_dot", "theta_dot"):
        expected = on_ground.final[key] + moved.get(key, 0.0)
        assert lifted.final[key] == pytest.approx(expected, rel=1e-7, abs=1e-8)
    assert lifted.energy_residual < 1e-9


def test_table_at_constant_speed_is_a_belt_to_the_last_bit():
    start = {"theta": 0.8, "y": 0.6, "x_dot": -0.7, "theta_dot": 1.1}
    runs = [
        rod_simulator(surface, "rigid").run(start, parameters={"a": 0.3}, t_end=0.4)
        for surface in ('surface_speed = "a"', 'through = ["a*t", "0"]')
    ]
    assert runs[0].final == runs[1].final
    assert runs[0].state_names == runs[1].state_names


@pytest.mark.parametrize("name", ["rigid", pytest.param("hunt-crossley", marks=pytest.mark.slow)])
def test_coordinates_against_the_table_give_the_motion_of_those_in_space(name):
    """x, y against the table: the motion is in the momenta, not in the gap."""
    move = ("b*sin(omega*t)", "a*sin(omega*t)")
    text = (
        HEAD
        + f"""
b = {{ default = 0.02, unit = "m" }}
[coordinates]
x = {{ unit = "m" }}
y = {{ unit = "m" }}
[[bodies]]
mass = "m"
centre = ["x + {move[0]}", "y + {move[1]}"]
[[contacts]]
name = "table"
point = ["x", "y"]
friction = "mu"
"""
    )
    moving = mechanism_from_text(text, name="on the table")
    rigid = name == "rigid"
    sim = Simulator(moving, RigidLaw()) if rigid else Simulator(moving, law(name))
    values = {"a": 0.01, "b": 0.02, "omega": 40.0}
    start = {"x": 0.0, "y": 0.05, "x_dot": 0.3 - 0.02 * 40, "y_dot": -0.01 * 40}
    run = sim.run(start, parameters=values, t_end=0.2)
    other = (on_table() if rigid else softened()).run(
        {"y": 0.05, "x_dot": 0.3}, parameters=values, t_end=0.2
    )
    assert [e.kind for e in run.events] == [e.kind for e in other.events]
    assert len(run.events) >= 4
    assert run.final["y"] == pytest.approx(other.final["gap"], rel=1e-7, abs=1e-9)
    assert run.final["x_dot"] == pytest.approx(other.final["slip_velocity"], rel=1e-6)
    for work in ("force_dissipation", "friction_dissipation", "contact_dissipation"):
        assert run.final[work] == pytest.approx(other.final[work], rel=1e-6)
    assert run.energy_residual < 1e-9


# ---- energy ----

PENDULUM = """
[coordinates]
phi = { unit = "rad" }
[[bodies]]
mass = "m"
centre = ["a*sin(omega*t) + l*sin(phi)", "0.45 + a*cos(omega*t) - l*cos(phi)"]
[[contacts]]
name = "floor"
point = ["a*sin(omega*t) + l*sin(phi)", "0.45 + a*cos(omega*t) - l*cos(phi)"]
surface_speed = "0.3*cos(3*t)"
slope = "0.2*sin(5*t)"
through = ["0.1*t", "0.03*cos(t)"]
friction = "mu"
"""
GUIDE = (
    PLANE
    + """
[[bodies]]
mass = "m"
centre = ["x + l*sin(theta)", "y - l*cos(theta)"]
inertia = "m*l**2/12"
angle = "theta"
[[contacts]]
name = "rail"
bilateral = true
point = ["x", "y"]
through = ["0.1*sin(3*t)", "a*sin(omega*t)"]
slope = "0.1*sin(2*t)"
friction = "mu"
"""
)
FEET = PLANE + BODY
for foot, side in (("A", "-"), ("B", "+")):
    FEET += f"""
[[contacts]]
name = "{foot}"
point = ["x {side} l*cos(theta) + 0.2*sin(theta)", "y {side} l*sin(theta) - 0.2*cos(theta)"]
through = ["2*a*sin(omega*t)", "a*cos(omega*t)"]
friction = "mu"
"""


@pytest.mark.slow
def test_energy_of_a_driven_pivot_above_a_rocking_floor_closes():
    mechanism = mechanism_from_text(HEAD + PENDULUM, name="driven")
    sim = Simulator(mechanism, RigidLaw())
    run = sim.run({"phi": 1.4}, t_end=1.0)
    assert any(e.kind == "touchdown" for e in run.events)
    assert abs(run.final["force_dissipation"]) > 0.1
    assert run.energy_residual < 1e-9


@pytest.mark.slow
def test_energy_of_a_pendulum_under_a_shaken_rail_closes_through_tangential_impacts():
    sim = Simulator(mechanism_from_text(HEAD + GUIDE, name="rail"), RigidLaw())
    start = {"theta": 1.0, "x_dot": 0.5, "y_dot": 0.4}
    for mu, impacts in ((0.4, False), (3.0, True)):
        run = sim.run(start, parameters={"mu": mu}, t_end=1.5)
        assert impacts == any(e.kind == "tangential_impact" for e in run.events)
        assert run.stop_reason is StopReason.T_END
        assert abs(run.final["force_dissipation"]) > 0.01
        assert run.energy_residual < 1e-9


@cache
def two_feet():
    return Simulator(mechanism_from_text(HEAD + FEET, name="feet"), RigidLaw())


@pytest.mark.slow
def test_energy_of_two_feet_on_a_shaken_table_closes_through_impacts_and_slip():
    thrown = two_feet().run({"y": 0.3, "theta": 0.05, "x_dot": 0.5}, t_end=0.6)
    slow = {"omega": 15.0}
    slides = two_feet().run({"y": 0.22, "x_dot": 0.5}, parameters=slow, t_end=0.6)
    assert sum(e.kind == "impact" for e in thrown.events) >= 3
    assert "slip_neg + slip_neg" in {e.mode_after for e in slides.events}
    for run in (thrown, slides):
        assert abs(run.final["force_dissipation"]) > 0.1
        assert run.energy_residual < 1e-9


@pytest.mark.slow
def test_feet_that_slide_on_a_table_are_a_block_of_one_contact():
    """An upright body that only slides moves as a point does, with half the force on each foot."""
    values = {"omega": 15.0, "g": G}
    feet = two_feet().run({"y": 0.22, "x_dot": 0.5}, parameters=values, t_end=0.6)
    same = {"omega": 15.0, "a": 0.02, "b": 0.04, "phase": math.pi / 2}
    block = on_table().run({"y": 0.02, "x_dot": 0.5}, parameters=same, t_end=0.6)
    assert feet.final["x"] == pytest.approx(block.final["x"], abs=1e-9)
    assert feet.final["force_dissipation"] == pytest.approx(
        block.final["force_dissipation"], abs=1e-9
    )


# ---- engines, batches, derivatives, time stepping ----

BOUNCE = {"y": 0.05, "x_dot": 0.3, "t": 0.02}


def test_engines_agree_on_a_table_that_moves():
    makes = [on_table(engine=engine) for engine in ("auto", "compiled", "erk")]
    runs = [sim.run(BOUNCE, t_end=0.2) for sim in makes]
    for run in runs[1:]:
        assert [e.kind for e in run.events] == [e.kind for e in runs[0].events]
        for name, value in runs[0].final.items():
            assert run.final[name] == pytest.approx(value, rel=1e-6, abs=1e-8)


def test_time_of_the_state_goes_on_from_its_start_and_that_of_the_run_from_zero():
    run = on_table().run(BOUNCE, t_end=0.2)
    assert (run.final_time, run.step_time[0]) == (0.2, 0.0)
    assert run.final["t"] == pytest.approx(0.22, rel=1e-14)
    assert run.values("t", np.array([0.0, 0.1])) == pytest.approx([0.02, 0.12], rel=1e-14)


def test_period_of_the_table_later_the_motion_is_the_same():
    period = 2 * math.pi / 40.0
    runs = [on_table().run(BOUNCE | {"t": t}, t_end=0.2) for t in (0.02, 0.02 + period)]
    assert len(runs[0].events) > 4
    for name in ("x", "y", "x_dot", "y_dot", "gap"):
        assert runs[1].final[name] == pytest.approx(runs[0].final[name], rel=1e-8, abs=1e-10)


def test_rows_of_a_batch_are_the_single_runs_to_the_last_bit():
    times, amplitudes = np.linspace(0, 0.1, 4), np.array([0.002, 0.01])[:, None]
    batch = run_batch(on_table(), {"y": 0.05, "t": times}, {"a": amplitudes}, t_end=0.2)
    assert batch.units("t") == "s"
    for i, a in enumerate(amplitudes.ravel()):
        for k, t in enumerate(times):
            state = {"y": 0.05, "t": float(t)}
            run = on_table().run(state, parameters={"a": float(a)}, t_end=0.2)
            assert all(batch[name][i, k] == value for name, value in run.final.items())


@pytest.mark.slow
def test_derivatives_by_amplitude_frequency_and_start_time_are_differences():
    sim, names = on_table(), ("a", "omega", "t")
    state, parameters = {"y": 0.05, "x_dot": 0.3, "t": 0.01}, {"a": 0.01, "omega": 40.0}
    sensitivities = sim.sensitivities(state, names, parameters=parameters, t_end=0.2)
    assert len(sensitivities.trajectory.events) >= 4
    for k, name in enumerate(names):
        step = 1e-6 * {"omega": 40.0}.get(name, 1.0)
        ends = []
        for sign in (-1, 1):
            moved = state | {n: v + sign * step for n, v in state.items() if n == name}
            values = parameters | {n: v + sign * step for n, v in parameters.items() if n == name}
            ends.append(sim.run(moved, parameters=values, t_end=0.2).final_state)
        slopes = (ends[1] - ends[0]) / (2 * step)
        assert sensitivities.final_jacobian[:, k] == pytest.approx(slopes, rel=1e-5, abs=1e-5)


def test_gradients_of_states_and_outputs_of_one_name_are_told_apart():
    """The gap is a state and an output here: its gradient at any time is that of the difference."""
    state, times = {"y": 0.05, "x_dot": 0.3}, np.array([0.05, 0.15, 0.2])
    run = softened().sensitivities(state, ("a",), parameters={"a": 0.01}, t_end=0.2)
    ends = [softened().run(state, parameters={"a": 0.01 + d}, t_end=0.2) for d in (-1e-6, 1e-6)]
    for name in ("gap", "slip_velocity", "kinetic_energy"):
        slopes = (ends[1].values(name, times) - ends[0].values(name, times)) / 2e-6
        assert run.gradient(name, times)[:, 0] == pytest.approx(slopes, rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("scheme", ["moreau-jean", "stewart-trinkle"])
def test_time_stepping_tends_to_the_rigid_motion_on_the_table(scheme):
    start, values = {"y_dot": 0.08, "x_dot": 0.9}, {"a": 0.002}
    exact = on_table().run(start, parameters=values | {"e_energetic": 0.0}, t_end=0.1).final
    errors = []
    for step in (1e-3, 1e-4):
        run = TimeStepper(TABLE, scheme).run(start, parameters=values, step=step, t_end=0.1)
        assert run.final["t"] == pytest.approx(0.1, rel=1e-12)
        errors.append(math.hypot(run.final["x"] - exact["x"], run.final["y"] - exact["y"]))
    assert errors[1] < errors[0] / 4 < 1e-3


def test_jump_takes_the_velocity_against_the_table():
    """A block at rest under a table that rises: v⁺ = (1 + e) u."""
    jump = evaluate_jump(TABLE, "newton", {}, parameters={"e_newton": 0.5, "b": 0.0, "a": 0.01})
    assert jump.velocity["y_dot"] == pytest.approx(1.5 * 0.01 * 40.0, rel=1e-14)


def test_mechanism_without_the_time_refuses_a_state_with_it():
    with pytest.raises(InputError, match="unknown state 't'"):
        rod_simulator("", "rigid").run({"t": 0.3}, t_end=0.1)
