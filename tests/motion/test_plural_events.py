"""Events of several contacts whose forces or guards are at rounding level."""

import functools

import numpy as np
import pytest

import painleve_sym as ps

ENGINES = ("taylor", "compiled")


@functools.cache
def _soft_block(engine):
    return ps.Simulator(ps.model("block-two-feet"), ps.law("linear"), engine=engine)


def test_a_foot_that_comes_back_with_no_force_slips_on_both_engines():
    """Foot B meets its indented surface again with F_n = 0 while A is in the air.

    Its friction must not be divided by its normal force: such a series reaches nowhere.
    """
    runs = [
        _soft_block(engine).run(
            {"y_A": 1e-3, "x_A_dot": -0.5},
            t_end=0.6,
            parameters={"k": 1e5, "c": 100.0, "beta": 0.0},
        )
        for engine in ENGINES
    ]
    assert {run.stop_reason for run in runs} == {ps.StopReason.T_END}
    assert max(run.energy_residual for run in runs) < 1e-10
    series, steps = ([(e.kind, e.contact, e.mode_after) for e in run.events] for run in runs)
    assert len(series) > 100
    assert series == steps
    times = [[e.time for e in run.events] for run in runs]
    assert np.allclose(*times, rtol=0, atol=1e-9)
    assert np.allclose(*(run.final_state[:3] for run in runs), rtol=0, atol=1e-11)


@pytest.mark.parametrize("state", [{"y_A": 1e-3, "x_A_dot": -0.5}, {"x_A_dot": 0.3}])
@pytest.mark.parametrize("damping", [100.0, 1000.0])
def test_state_and_time_of_an_event_agree_where_its_guard_is_at_rounding_level(state, damping):
    """Coordinates change by the integrals of their velocities over every recorded step."""
    run = _soft_block("compiled").run(
        state, t_end=3.0, parameters={"k": 1e5, "c": damping, "beta": 0.0}
    )
    assert run.final_time == 3.0
    place, weight = np.polynomial.legendre.leggauss(6)
    u = (place[:, None, None] + 1) / 2
    v, row = 1 - u, np.moveaxis(np.asarray(run.step_rows), 1, 0)[:, None]
    dense = row[7]
    for k, factor in zip(range(6, -1, -1), (u, v) * 4, strict=False):
        dense = row[k] + factor * dense
    names = list(run.state_names)
    for q in ("x_A", "y_A", "theta"):
        speed = dense[:, :, names.index(f"{q}_dot")]
        change = row[1][0][:, names.index(q)]
        missed = change - np.asarray(run.step_length) * (weight @ speed) / 2
        assert np.max(np.abs(missed)) < 5e-15


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("state", "damping", "t_end"),
    [
        ({"y_A": -4.9e-5}, 1000.0, 0.5),  # where the springs carry the weight exactly
        ({"y_A": -5e-5}, 1000.0, 3.0),
        ({"y_A": 1e-3, "x_A_dot": -0.5}, 100.0, 3.0),
    ],
)
def test_feet_that_have_come_to_rest_stay_there(engine, state, damping, t_end):
    """At rest δ̇ is noise: a turn is not followed by the turn back at the same instant."""
    run = _soft_block(engine).run(
        state, t_end=t_end, parameters={"k": 1e5, "c": damping, "beta": 0.0}
    )
    assert run.stop_reason is ps.StopReason.T_END
    end = dict(zip(run.state_names, run.final_state, strict=True))
    assert abs(end["y_A"] + 9.8 / (2 * 1e5)) < 1e-12 and abs(end["theta"]) < 1e-12
    assert max(abs(end[v]) for v in ("x_A_dot", "y_A_dot", "theta_dot")) < 1e-9
    assert len(run.events) < 2000
