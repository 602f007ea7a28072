"""Every method at a contact in space, with the configuration frozen."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.errors import InputError, StopReason
from painleve_sym.study.comparisons.comparison import compare

TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
"""Of the planar rod; the rod in space has the same in its plane, with z for y."""
QUADRUPED = Path(__file__).parents[2] / "examples" / "robots" / "quadruped.urdf"


@pytest.fixture(scope="module")
def table_3():
    return compare("rod-3d", TABLE_3)


def test_slip_in_a_plane_has_the_rigid_answers_of_the_planar_rod(table_3):
    for way in ("energetic", "poisson", "newton"):
        planar = ps.evaluate_jump("rod", way, TABLE_3, parameters={f"e_{way}": 0.75})
        (answer,) = (a for a in table_3.rigid if a.way == way)
        expected = [planar.velocity[n] for n in ("x_A_dot", "y_A_dot", "theta_dot")]
        velocity = [answer.velocity[n] for n in ("x_A_dot", "z_A_dot", "theta_dot")]
        assert velocity == pytest.approx(expected, abs=1e-13)
        assert answer.normal_impulse == pytest.approx(planar.normal_impulse, rel=1e-13)


def test_slip_in_a_plane_has_the_errors_of_the_planar_rod(table_3):
    """The planar motions last up to one time, and their configuration moves, as little as E is."""
    planar = compare("rod", TABLE_3, solvers=("lemke",), steps=(1e-3,))
    for ours, theirs in zip(table_3.softened, planar.softened, strict=True):
        assert ours.error == pytest.approx(theirs.error, rel=0.07)
    assert table_3.stiffness_orders == pytest.approx(planar.stiffness_orders, abs=2e-3)
    assert planar.expected_stiffness_order == table_3.expected_stiffness_order


def test_impact_without_collision(table_3):
    assert table_3.frozen and table_3.impact_without_collision
    assert table_3.plastic_jump_unnoticed and not table_3.solver_dependent and not table_3.jams
    assert list(table_3.jumps) == ["e", "plastic"]
    for answer in table_3.softened:
        kinds = [kind for _, kind in answer.events]
        assert kinds[:2] == ["slip_stop", "max_compression"] and kinds[-1] == "separation"
        assert answer.complete and answer.reference == "energetic"
    forces = np.array([a.peak_force for a in table_3.softened])
    first, second = np.log10(forces[1:] / forces[:-1]) / 2
    assert 0.34 < first < second < 0.4  # of F = K δ^1.5 with K δ^2.5 the energy


def test_velocities_are_those_of_the_impulse_and_of_the_free_motion(table_3):
    """Linear and angular momentum of a rod of length 2 l about its centre, by hand."""
    before = table_3.state
    m, g, inertia = 1.0, 9.8, 1 / 3
    for answer in (*table_3.rigid, *table_3.stepping, *table_3.softened):
        P_n, P_t, _ = answer.impulse
        s, c = math.sin(before["theta"]), math.cos(before["theta"])

        def centre(v, s=s, c=c):
            return v["x_A_dot"] - s * v["theta_dot"], v["z_A_dot"] + c * v["theta_dot"]

        # θ̇² turns the centre about the end: with the configuration frozen, as in the free motion.
        turn = before["theta_dot"] ** 2 * answer.final_time
        x, z = np.subtract(centre(answer.velocity), centre(before))
        assert m * (x - c * turn) == pytest.approx(P_t, abs=1e-12)
        assert m * (z - s * turn) == pytest.approx(P_n - m * g * answer.final_time, abs=1e-12)
        spin = answer.velocity["theta_dot"] - before["theta_dot"]
        assert inertia * spin == pytest.approx(s * P_t - c * P_n, abs=1e-12)


def test_several_solutions_are_all_there():
    comparison = compare("rod-3d", TABLE_3 | {"theta_dot": 5.0}, stiffness=(20.9e14,))
    level = comparison.acceleration_level.classification
    assert [s.mode.value for s in level.solutions] == ["liftoff", "slip"]
    modes = [[s.mode.value for s in first.solutions] for first in comparison.first_steps]
    assert modes == [["liftoff"], ["liftoff", "slip", "stick"], ["liftoff", "slip", "stick"]]
    assert comparison.solver_dependent
    assert comparison.rigid[0].way == "liftoff"
    (softened,) = comparison.softened
    assert (softened.reference, softened.error, softened.normal_impulse) == ("liftoff", 0, 0)
    assert softened.complete and softened.stop_reason is StopReason.T_END


def test_no_restitution_ends_with_the_compression():
    comparison = compare("rod-3d", TABLE_3, e=0.0)
    for answer in comparison.softened:
        assert answer.complete and answer.stop_reason is StopReason.UNTIL
        assert answer.contact_velocities[-1] == pytest.approx([0, 0, 0], abs=1e-12)
    assert [r.normal_impulse for r in comparison.rigid] == pytest.approx([0.340986535] * 4)
    assert comparison.stiffness_orders == pytest.approx([-1 / 3] * 2, abs=0.08)


COLLISION = TABLE_3 | {"y_A_dot": 0.6, "psi_dot": 2.0, "z_A_dot": -0.1}


def test_collision_tends_with_the_duration_of_the_impact():
    """The impulse of b that the jump drops lasts a duration ∝ E^(−1/(n+1))."""
    comparison = compare("rod-3d", COLLISION)
    assert comparison.acceleration_level is None
    assert comparison.stiffness_orders == pytest.approx([-0.4, -0.4], abs=1e-3)
    assert comparison.expected_stiffness_order == -0.4
    newton = next(a for a in comparison.rigid if a.way == "newton")
    for answer in comparison.stepping:
        assert answer.contact_velocities[-1] == pytest.approx([0.075, 0, 0], abs=1e-12)
        assert answer.reference == "newton"
        assert answer.normal_impulse == pytest.approx(newton.normal_impulse, rel=0.02)
    (orders,) = {tuple(p) for p in comparison.step_orders.values()}
    assert orders == pytest.approx((1, 1), abs=1e-6)
    assert not comparison.steps_miss_turn


def test_step_has_the_friction_of_its_last_slip_and_misses_a_turn():
    """In slip that turns and does not stop a step of any length differs from the jump."""
    state = TABLE_3 | {"y_A_dot": 0.6, "z_A_dot": -1.0}
    given = {"parameters": {"mu": 0.3}, "steps": (1e-4, 1e-6), "stiffness": (20.9e16,)}
    comparison = compare("rod-3d", state, **given)
    newton = next(a for a in comparison.rigid if a.way == "newton")
    angles = [math.atan2(v[2], v[1]) for v in newton.contact_velocities[[0, -1]]]
    assert 0.3 < abs(angles[1] - angles[0]) < 0.5
    for answer in comparison.stepping:
        slip, friction = answer.contact_velocities[-1, 1:], np.array(answer.impulse[1:])
        along = slip / np.linalg.norm(slip)
        assert friction == pytest.approx(-0.3 * answer.normal_impulse * along, abs=1e-9)
        assert answer.error == pytest.approx(0.02676, rel=2e-3)
    assert comparison.steps_miss_turn
    assert comparison.softened[0].error < 1e-5


def test_contact_of_a_robot():
    foot = ps.robot(QUADRUPED).contact("LF_foot", pose="standing").mechanism
    given = {"contact_velocity": (0.0, 1.0, 0.0), "parameters": {"mu": 2.0}}
    comparison = compare(foot, **given)
    jump = ps.evaluate_jump(foot, "energetic", **given)
    assert comparison.jumps["e"].velocity == jump.velocity
    assert comparison.impact_without_collision and comparison.plastic_jump_unnoticed
    finest = comparison.softened[-1]
    for name, after in jump.velocity.items():
        assert finest.velocity[name] == pytest.approx(after, abs=3e-3)
    assert comparison.stiffness_orders[-1] == pytest.approx(-1 / 3, abs=0.02)


def test_held_contact_has_no_jump_and_no_error():
    comparison = compare("rod-3d", TABLE_3 | {"theta": 0.3}, stiffness=(20.9e14,))
    assert comparison.rigid == () and comparison.jumps == {}
    (softened,) = comparison.softened
    assert softened.stop_reason is StopReason.EVENT_LIMIT and not softened.complete
    assert "the contact is held" in softened.stop_detail
    assert all(math.isnan(a.error) for a in (*comparison.stepping, softened))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"state": {"theta": 1.0, "z_A": 0.01}}, "the contact starts above the ground"),
        ({"state": {"theta": 1.0, "z_A": -0.01}}, "the contact starts inside the ground"),
        ({"solvers": ("lemke",)}, "unknown solver 'lemke'"),
        ({"steps": (0.1,)}, "step: got 0.1, need a number in"),
        ({"e": 1.5}, "0 <= e_energetic <= 1"),
        ({"stiffness": ()}, "stiffness: got none"),
        ({"contact_velocity": (0.0, 1.0)}, "need 3 finite numbers along n, t1, t2"),
    ],
)
def test_faults_are_named(options, words):
    with pytest.raises(InputError) as fault:
        compare("rod-3d", **({"state": TABLE_3} | options))
    assert words in str(fault.value)
