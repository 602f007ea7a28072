"""Derivatives of whole motions through impacts of several rigid contacts, against differences."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import PainleveWarning
from painleve_sym.laws.catalogue import law
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.motion.simulator import Simulator
from tests.scenes import FEET, LADDER, TABLE, simulator

LAWS = sorted(RESTITUTIONS)
FLAT = {"beta": 0.0, "mu_A": 0.3, "mu_B": 0.3}


def compared(sim, start, wrt, parameters, t_end, rtol=1e-8):
    """Compare the state at the end with runs beside it; return the motion with derivatives."""
    motion = sim.sensitivities(start, wrt, parameters=parameters, t_end=t_end, rtol=1e-11)
    defaults = {p.name: p.default for p in (*sim.mechanism.system.parameters, *sim.own_parameters)}

    def end(name, h):
        moved, values = dict(start), defaults | parameters
        changed = values if name in values else moved
        changed[name] = changed.get(name, 0.0) + h
        return sim.run(moved, parameters=values, t_end=t_end, rtol=1e-13).final_state

    for k, name in enumerate(wrt):
        steps = [(end(name, h) - end(name, -h)) / (2 * h) for h in (1e-5, 5e-6)]
        slope = (4 * steps[1] - steps[0]) / 3
        # States are of order 1, a derivative may be 0.
        size = max(np.max(np.abs(slope)), 1.0)
        assert np.max(np.abs(motion.fixed_time_jacobian[:, k] - slope)) <= rtol * size, name
    return motion


def impacts(motion):
    return [e for e in motion.events if e.event.kind == "impact"]


@pytest.mark.slow
def test_ladder_that_slides_against_a_wall():
    """Both ends take part, and the bounces at the wall die out."""
    e = "e_energetic"
    start = {"theta": 0.9, "x": 1.32, "theta_dot": -0.1, "x_dot": -0.9}
    motion = compared(simulator(LADDER), start, ("theta", "mu_floor", e), {e: 0.5}, 0.45)
    assert len(impacts(motion)) >= 5
    assert all(i.event.impulses[2] > 0 for i in impacts(motion))
    assert any(i.event.impulses[0] > 0 for i in impacts(motion))
    assert motion.trajectory.energy_residual < 1e-8


@pytest.mark.parametrize("restitution", LAWS)
@pytest.mark.slow
def test_block_that_rocks_from_foot_to_foot_slipping(restitution):
    e = f"e_{restitution}"
    start = {"theta": 0.1, "theta_dot": 0.5, "x_A_dot": 0.3}
    values = {"beta": 0.0, "h": 0.3, "mu_A": 0.3, "mu_B": 0.2, e: 0.3}
    motion = compared(
        simulator(FEET, restitution=restitution), start, ("theta_dot", "mu_B", e), values, 0.35
    )
    assert impacts(motion)


@pytest.mark.slow
@pytest.mark.parametrize("restitution", LAWS)
def test_block_that_rocks_and_sticks(restitution):
    """A foot at rest takes part in the impact of the other one; what slip it had is forgotten."""
    e = f"e_{restitution}"
    values = {"beta": 0.0, "h": 0.3, "mu_A": 1.5, "mu_B": 1.5, e: 0.3}
    start = {"theta": 0.1, "theta_dot": -0.5}
    compared(simulator(FEET, restitution=restitution), start, ("theta_dot", "mu_B", e), values, 0.2)


@pytest.mark.slow
def test_three_legged_table():
    sim = simulator(TABLE)
    start = {"y": 0.01, "theta": 0.01, "x_dot": 0.3, "theta_dot": 0.2}
    motion = compared(sim, start, ("theta_dot",), {"e_energetic": 0.4}, 0.06)
    assert len(impacts(motion)) >= 4
    assert {e.event.contact for e in motion.events if e.event.kind == "touchdown"} >= {
        "left",
        "right",
    }


@pytest.mark.slow
def test_feet_that_land_together_in_directions_that_keep_them_together():
    sim = simulator(FEET)
    start = {"y_A": 0.02, "x_A_dot": 0.4}
    motion = compared(sim, start, ("y_A", "x_A_dot", "mu_A"), FLAT, 0.08)
    (hit,) = impacts(motion)
    assert min(hit.event.impulses[::2]) > 0 and hit.note == ""


@pytest.mark.slow
def test_feet_that_land_together_are_parted_by_a_turn():
    sim = simulator(FEET)
    start = {"y_A": 0.02, "x_A_dot": 0.4}
    with pytest.warns(PainleveWarning, match="touch at one instant"):
        motion = sim.sensitivities(start, ("y_A", "theta"), parameters=FLAT, t_end=0.08)
    (hit,) = impacts(motion)
    assert hit.note == "simultaneous" and motion.valid_until == hit.event.time
    assert np.isnan(motion.final_jacobian).all()
    assert np.isfinite(motion.at(0.9 * hit.event.time)).all()
    # The motion itself is followed to its end.
    assert motion.trajectory.final_time == 0.08
    # Indeed: the turns to both sides lead to different motions, however small they are.
    left, right = (
        sim.run(start | {"theta": turn}, parameters=FLAT, t_end=0.08).final["theta_dot"]
        for turn in (-1e-9, 1e-9)
    )
    assert abs(left - right) > 0.1


@pytest.mark.slow
def test_slip_that_begins_at_zero_and_does_not_stick_has_no_derivative():
    sim = simulator(FEET)
    start, values = {"y_A": 0.02, "theta": 0.3}, FLAT | {"mu_A": 0.01}
    with pytest.warns(PainleveWarning, match="sequence of slip"):
        motion = sim.sensitivities(start, ("x_A_dot",), parameters=values, t_end=0.08)
    assert impacts(motion)[0].note == "tie"
    at = [
        sim.run(start | {"x_A_dot": v}, parameters=values, t_end=0.08, rtol=1e-13)
        for v in (-1e-5, 0.0, 1e-5)
    ]
    below, above = (
        (b.final["theta_dot"] - a.final["theta_dot"]) / 1e-5 for a, b in itertools.pairwise(at)
    )
    assert abs(above - below) > 1e-3


@pytest.mark.slow
def test_impacts_beside_a_guide():
    block = model("block-two-feet")
    held, free = block.contacts
    guided = replace(block, contacts=(replace(held, bilateral=True), free))
    sim = Simulator(guided, law("rigid"))
    start, values = {"theta": 0.05, "theta_dot": 0.3}, {"beta": 0.0, "mu_A": 0.4, "mu_B": 0.6}
    motion = compared(sim, start, ("theta_dot", "mu_A", "e_energetic"), values, 0.3)
    assert len(impacts(motion)) >= 2


@pytest.mark.slow
def test_both_engines_agree():
    start, wrt = {"y_A": 0.02, "theta": 0.1, "x_A_dot": 0.3}, ("theta", "mu_A")
    ends = [
        simulator(FEET, "rigid", engine, restitution="poisson")
        .sensitivities(start, wrt, parameters=FLAT, t_end=0.08)
        .fixed_time_jacobian
        for engine in ("compiled", "taylor")
    ]
    assert np.allclose(*ends, rtol=1e-7, atol=1e-8)
