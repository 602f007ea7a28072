"""Soft contacts: energy, mirror images, order of contacts, units; batches and derivatives."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.batch.run import run_batch
from painleve_sym.motion.simulator import Simulator
from tests.scenes import FEET, LADDER, TABLE, simulator

ENGINES = ("compiled", "auto")
SOFT = {"k": 1e5, "c": 30.0}
FRICTION = {"mu_left": 0.3, "mu_middle": 0.5, "mu_right": 0.6}
LENGTHS = {"x": 1, "y": 1, "theta": 0, "x_dot": 1, "y_dot": 1, "theta_dot": 0}
TIMES = {"x": 0, "y": 0, "theta": 0, "x_dot": -1, "y_dot": -1, "theta_dot": -1}


def either_way(least, most):
    """Return numbers of that size with either sign."""
    size = st.floats(least, most)
    return st.one_of(size, size.map(lambda value: -value))


# Level legs that land at once without sliding are a test of their own, below.
starts = st.fixed_dictionaries(
    {
        "y": st.floats(0.008, 0.02),
        "theta": either_way(1e-3, 0.02),
        "x_dot": either_way(0.05, 0.5),
        "theta_dot": either_way(0.05, 0.5),
    }
)


@cache
def _backwards():
    """The table with its contacts in another order."""
    table = model(str(TABLE))
    return Simulator(replace(table, contacts=table.contacts[::-1]), law("linear"))


def _table(engine="auto"):
    return simulator(TABLE, "linear", engine)


def _end(run):
    assert run.stop_reason is StopReason.T_END
    return {k: run.final_state[list(run.state_names).index(k)] for k in LENGTHS}


@pytest.mark.slow
@settings(max_examples=15)
@given(start=starts)
def test_energy_of_a_table_on_three_soft_legs_closes(start):
    run = _table().run(start, parameters=SOFT | FRICTION, t_end=0.2)
    assert run.stop_reason is StopReason.T_END
    assert run.energy_residual < 1e-9


@pytest.mark.slow
@settings(max_examples=10)
@given(drop=st.floats(1e-4, 5e-3), turn=either_way(0.05, 0.3), lean=st.floats(1e-3, 0.05))
def test_energy_of_a_ladder_between_soft_floor_and_wall_closes(drop, turn, lean):
    start = {"x": 1.0 + lean, "y": drop, "theta": np.pi / 3, "theta_dot": turn}
    soft = {"E_floor": 1e7, "k_wall": 1e5, "c_wall": 10.0}
    run = simulator(LADDER, "floor=hertz,wall=linear").run(start, parameters=soft, t_end=0.2)
    assert run.stop_reason is StopReason.T_END
    assert run.energy_residual < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@settings(max_examples=25)
@given(
    drop=st.floats(0.002, 0.05),
    turn=st.sampled_from([0.0, 1e-12]),
    mu=st.tuples(*[st.floats(0.1, 0.8)] * 3),
)
@example(drop=0.015625, turn=0.0, mu=tuple(FRICTION.values()))
@example(drop=0.028525352505021785, turn=1e-12, mu=(0.3, 0.5, 0.6))
def test_level_legs_that_drop_straight_bounce_to_the_end(engine, drop, turn, mu):
    """Rounding alone loads their friction: each of them slips and sticks in no time."""
    given = SOFT | dict(zip(FRICTION, mu, strict=True))
    run = _table(engine).run({"y": drop, "theta": turn}, parameters=given, t_end=0.3)
    assert run.stop_reason is StopReason.T_END
    assert run.energy_residual < 1e-9
    # Bounces let a tilt of 1e-12 grow.
    assert abs(run.final["x_dot"]) < 1e-6


@pytest.mark.slow
@settings(max_examples=10)
@given(start=starts)
def test_mirror_image_moves_as_the_mirrored_motion(start):
    table = _table()
    mirrored = {k: v if k == "y" else -v for k, v in start.items()}
    other = FRICTION | {"mu_left": FRICTION["mu_right"], "mu_right": FRICTION["mu_left"]}
    one = _end(table.run(start, parameters=SOFT | FRICTION, t_end=0.1))
    two = _end(table.run(mirrored, parameters=SOFT | other, t_end=0.1))
    expected = {k: v if k.startswith("y") else -v for k, v in one.items()}
    assert two == pytest.approx(expected, rel=1e-7, abs=1e-8)


@pytest.mark.slow
@settings(max_examples=10)
@given(start=starts)
def test_order_of_contacts_does_not_matter(start):
    runs = [
        own.run(start, parameters=SOFT | FRICTION, t_end=0.1) for own in (_table(), _backwards())
    ]
    assert _end(runs[0]) == pytest.approx(_end(runs[1]), rel=1e-7, abs=1e-8)


@pytest.mark.slow
@settings(max_examples=15)
@given(mass=st.floats(-6, 6), length=st.floats(-6, 6), speed=st.floats(-3, 3))
def test_units_do_not_matter_over_twelve_decades(mass, length, speed):
    # Gaps and gap rates of a start that are below 1e-12 m and m/s count as 0: no slower units.
    start, time = {"y": 0.012, "theta": 0.011, "x_dot": 0.3, "theta_dot": -0.4}, length - speed
    M, L, T = 10.0**mass, 10.0**length, 10.0**time
    table = _table()
    plain = table.parameters(SOFT | FRICTION)
    units = {"m": M, "J": M * L**2, "a": L, "h": L, "g": L / T**2, "k": M / T**2, "c": M / T}
    scaled = {k: v * units.get(k, 1.0) for k, v in plain.items()}
    there = {k: v * L ** LENGTHS[k] * T ** TIMES[k] for k, v in start.items()}
    one = _end(table.run(start, parameters=plain, t_end=0.1))
    two = _end(table.run(there, parameters=scaled, t_end=0.1 * T))
    back = {k: v / (L ** LENGTHS[k] * T ** TIMES[k]) for k, v in two.items()}
    assert back == pytest.approx(one, rel=1e-7, abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_a_batch_is_its_single_runs_with_any_number_of_threads(engine):
    table, count = _table(engine), 70
    rng = np.random.default_rng(3)
    start = {
        "y": rng.uniform(0.0, 0.02, count),  # some of them start compressed
        "theta": rng.uniform(-0.02, 0.02, count),
        "x_dot": rng.uniform(-0.5, 0.5, count),
        "theta_dot": rng.uniform(-1, 1, count),
    }
    batches = [run_batch(table, start, SOFT, t_end=0.1, threads=k).rows.state for k in (1, 3)]
    assert np.array_equal(*batches)
    for i in range(count):
        single = {k: float(v[i]) for k, v in start.items()}
        run = table.run(single, parameters=SOFT, t_end=0.1, record="end")
        assert np.array_equal(run.final_state, batches[0][i])


@pytest.mark.slow
def test_derivatives_of_a_motion_of_two_feet_are_those_of_runs_beside():
    feet = simulator(FEET, "linear")
    start, parameters = {"y_A": 1e-3, "theta": 0.02, "x_A_dot": -0.3}, {"k": 1e5, "c": 40.0}
    directions = ("theta", "x_A_dot", "mu_A")
    motion = feet.sensitivities(start, directions, parameters=parameters, t_end=0.05)
    assert len(motion.trajectory.events) >= 5
    for i, name in enumerate(directions):
        ends = []
        for step in (1e-6, -1e-6):
            moved, given_ = dict(start), parameters | {"mu_A": 0.4}
            (given_ if name == "mu_A" else moved)[name] += step
            run = feet.run(moved, parameters=given_, t_end=0.05, rtol=1e-13)
            ends.append(run.final_state)
        slope = (ends[0] - ends[1]) / 2e-6
        assert np.allclose(motion.final_jacobian[:, i], slope, rtol=0, atol=1e-7 * abs(slope).max())
