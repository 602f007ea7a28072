"""Risk of a robot's contact against other libraries, named mechanisms and differences."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import painleve_sym as ps
from painleve_sym.at.delassus import Delassus
from painleve_sym.problem.risk import (
    friction_threshold,
    least_over_normals,
    schur_complement,
    sector_half_angle,
    slip_angle,
)

FILES = Path(__file__).parent / "files"
DOG = Path(__file__).parents[2] / "examples" / "robots" / "quadruped.urdf"
STANDING = {"LF_HFE": 0.7, "LF_KFE": -1.2, "RF_HAA": 0.1}
ENTRY = st.floats(-1, 1, allow_subnormal=False)


def dog(**options):
    return ps.robot(DOG, **options)


# ---- thresholds of a mobility ----


@given(st.lists(ENTRY, min_size=9, max_size=9), st.floats(0.01, 3), st.floats(-3.1, 3.1))
def test_sector_is_where_the_normal_acceleration_falls_with_the_force(entries, mu, angle):
    A = np.array(entries).reshape(3, 3)
    W = A @ A.T + 1e-3 * np.eye(3)
    normal = W[0, 0] - mu * (W[1, 0] * math.cos(angle) + W[2, 0] * math.sin(angle))
    mu_P = float(friction_threshold(W))
    half = sector_half_angle(mu_P, mu)
    away = abs((angle - slip_angle(W[1:, 0].tolist()) + math.pi) % (2 * math.pi) - math.pi)
    if abs(normal) > 1e-9:
        assert (normal < 0) == (away < half)


@given(st.lists(ENTRY, min_size=9, max_size=9), st.lists(ENTRY, min_size=3, max_size=3))
def test_least_over_normals_bounds_every_normal_and_is_attained(entries, direction):
    A = np.array(entries).reshape(3, 3)
    W = A @ A.T + 1e-3 * np.eye(3)
    bound = float(least_over_normals(W))

    def threshold(n):
        along = n @ W @ n
        across = np.linalg.norm(W @ n - along * n)
        return along / across if across else math.inf

    n = np.array(direction)
    if np.linalg.norm(n) > 1e-3:
        assert threshold(n / np.linalg.norm(n)) >= bound * (1 - 1e-9)
    if bound < 1e3:
        # Its normal weighs the extreme axes each with the root of the other's eigenvalue.
        (low, _, high), axes = np.linalg.eigh(W)
        weights = math.sqrt(high / (low + high)), math.sqrt(low / (low + high))
        worst = weights[0] * axes[:, 0] + weights[1] * axes[:, 2]
        assert threshold(worst) == pytest.approx(bound, rel=1e-6)


def test_held_mobility_is_the_inverse_of_the_inverses_block():
    random = np.random.default_rng(2)
    A = random.normal(size=(6, 6))
    W = A @ A.T
    # Forces that hold the others at rest: the inverse of W without their rows.
    alone = np.linalg.inv(np.linalg.inv(W)[:3, :3])
    b = random.normal(size=6)
    own, rest = schur_complement(W, b)
    np.testing.assert_allclose(own, alone, rtol=1e-9)
    # Forces that leave the others without acceleration.
    forces = np.linalg.solve(W[3:, 3:], -b[3:])
    np.testing.assert_allclose(rest, b[:3] + W[:3, 3:] @ forces, rtol=1e-9)


# ---- robots ----


def test_planar_robot_has_the_numbers_of_the_named_mechanism():
    from dataclasses import replace

    arm = ps.robot(FILES / "two_link.urdf")
    upper, lower, spins, torques = -0.7, -1.9, (0.8, -1.3), (2.0, -0.5)
    tip = arm.contact("tip", joints={"theta_1": upper, "theta_2": lower - upper})
    moving = {"theta_1_dot": spins[0], "theta_2_dot": spins[1] - spins[0]}
    # A drive of the elbow acts on both links.
    moving |= {"torque_theta_1": torques[0], "torque_theta_2": torques[1]}
    numbers = replace(tip, values={**tip.values, **moving}).numbers()
    named = ps.model("two-link-arm")
    values = {p.name: p.default for p in named.outline.parameters}
    values |= {"l_1": 1.0, "l_2": 1.0, "g": 9.81, "u": 0.0}
    values |= {"tau_1": torques[0], "tau_2": torques[1]}
    values |= {"theta_1": upper, "theta_2": lower}
    values |= {"theta_1_dot": spins[0], "theta_2_dot": spins[1]}
    own = Delassus.of(named).at(values)
    np.testing.assert_allclose(numbers.W[:2, :2], own.W, rtol=1e-12)
    assert np.abs(tip.mobility()[2]).max() == 0
    np.testing.assert_allclose(numbers.b[:2], own.b, rtol=1e-11)
    np.testing.assert_allclose(numbers.v[:2], own.v, rtol=1e-12)


def test_derivatives_are_differences():
    robot, h = dog(), 1e-6
    risk = robot.contact("LF_foot", joints=STANDING).risk()
    for name, slope in risk.gradient.items():
        ends = [
            robot.contact("LF_foot", joints=STANDING | {name: STANDING.get(name, 0.0) + d})
            for d in (-h, h)
        ]
        low, high = (float(friction_threshold(c.mobility())) for c in ends)
        assert slope == pytest.approx((high - low) / (2 * h), abs=1e-7)


def test_turned_base_is_a_turned_normal():
    turned = ps.robot(FILES / "hopper.xml").contact("sole", pose="tilted")
    from painleve_sym.robots.tree import rotation_quaternion

    R = rotation_quaternion((0.9, 0.1, -0.2, 0.3), "")
    upright = ps.robot(FILES / "hopper.xml")
    joints = turned.dynamics.tree.poses["tilted"].joints
    same = upright.contact("sole", joints=joints, normal=R.T @ [0, 0, 1])
    assert turned.risk().mu_P == pytest.approx(same.risk().mu_P, rel=1e-12)
    least = [c.risk().least_over_normals for c in (turned, same)]
    assert least[0] == pytest.approx(least[1], rel=1e-12)


def test_scene_that_is_turned_about_the_normal_has_the_same_thresholds():
    robot = dog()
    risks = []
    for yaw in (0.0, 0.9):
        contact = robot.contact("LF_foot", joints=STANDING)
        contact.values["base_yaw"] = yaw
        risks.append(contact.risk(0.8))
    assert risks[0].mu_P == pytest.approx(risks[1].mu_P, rel=1e-12)
    turned, straight = (slip_angle(risk.direction) for risk in reversed(risks))
    assert turned - straight == pytest.approx(0.9)


def test_locked_joints_and_stuck_feet_make_a_contact_stiffer():
    robot = dog()
    free = robot.contact("LF_foot", joints=STANDING).mobility()
    locked = robot.contact("LF_foot", joints=STANDING, locked="LF_KFE").mobility()
    every = robot.contact("LF_foot", joints=STANDING, locked="all").mobility()
    feet = "LF_foot,RF_foot,LH_foot,RH_foot"
    stuck = robot.contact(feet, joints=STANDING, others="stuck").mobility()
    for stiffer in (free - locked, locked - every, free - stuck):
        assert np.linalg.eigvalsh(stiffer).min() > -1e-12
    # All joints locked: one rigid body, which has the mobility of the same mass at a point.
    composite = robot.contact("LF_foot", joints=STANDING, locked="all").numbers()
    assert np.isfinite(composite.W).all()


def test_rotor_inertia_is_on_the_diagonal():
    light, heavy = (dog(armature=a).contact("LF_foot", joints=STANDING) for a in (0.0, 1e9))
    locked = dog().contact("LF_foot", joints=STANDING, locked="all")
    np.testing.assert_allclose(heavy.mobility(), locked.mobility(), atol=1e-7)
    assert light.risk().mu_P == dog().contact("LF_foot", joints=STANDING).risk().mu_P


def test_round_foot_touches_below_its_centre():
    robot = dog()
    sole = robot.contact("LF_foot", joints=STANDING, radius=0.03)
    # The same point, given in the frame of the foot.
    place = robot.contact("LF_foot", joints=STANDING)
    from painleve_sym.robots.dynamics import RobotDynamics

    assert isinstance(place.dynamics, RobotDynamics)
    W = sole.mobility()
    assert W[0, 0] == pytest.approx(place.mobility()[0, 0], rel=1e-12)
    pitch = STANDING["LF_HFE"] + STANDING["LF_KFE"]
    below = (0.03 * math.sin(pitch), 0.0, -0.03 * math.cos(pitch))
    point = robot.contact("LF_foot", joints=STANDING, point=below)
    np.testing.assert_allclose(W, point.mobility(), atol=1e-12)


def test_least_of_all_poses_is_below_random_ones_and_within_limits():
    robot = dog()
    contact = robot.contact("LF_foot", joints=STANDING, locked="RF_HAA,RF_HFE,RF_KFE")
    poses = contact.random_poses(300, seed=4)
    assert "RF_KFE" not in poses
    thresholds = contact.thresholds(poses)
    k = int(np.argmin(thresholds))
    alone = robot.contact(
        "LF_foot",
        joints={**STANDING, **{name: values[k] for name, values in poses.items()}},
        locked="RF_HAA,RF_HFE,RF_KFE",
    )
    assert alone.risk().mu_P == pytest.approx(thresholds[k], rel=1e-12)
    least = contact.least(poses)
    assert least.mu_P <= thresholds[k]
    for name, value in least.joints.items():
        joint = robot.joints[name]
        assert joint.lower <= value <= joint.upper
    there = robot.contact("LF_foot", joints=STANDING | least.joints, locked="RF_HAA,RF_HFE,RF_KFE")
    assert there.risk().mu_P == pytest.approx(least.mu_P, rel=1e-9)


def test_motion_of_the_whole_robot_agrees_with_pinocchio():
    pin = pytest.importorskip("pinocchio", reason="needs the group robots (pin)")
    model = pin.buildModelFromUrdf(str(DOG), pin.JointModelFreeFlyer())
    data = model.createData()
    robot, random = dog(), np.random.default_rng(8)
    contact = robot.contact("LF_foot,RH_foot", joints=STANDING, normal=(0.1, -0.2, 1.0))
    outline = contact.dynamics.outline
    values = dict(contact.values)
    values |= {n: random.normal() for n in outline.velocity_names}
    values |= {f"torque_{n}": random.normal() for n in robot.joints}
    values |= {"base_roll": 0.3, "base_pitch": -0.4, "base_yaw": 1.2}
    numbers, moves = contact._delassus.whole_at(values)
    R = pin.rpy.rpyToMatrix(0.3, -0.4, 1.2)
    rates = np.array([values[f"{n}_dot"] for n in ("base_roll", "base_pitch", "base_yaw")])
    E = pin.rpy.computeRpyJacobian(np.array([0.3, -0.4, 1.2]), pin.ReferenceFrame.LOCAL)
    q, v, tau = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    q[3:7] = pin.Quaternion(R).coeffs()
    v[:3] = R.T @ [values[f"base_{k}_dot"] for k in "xyz"]
    v[3:6] = E @ rates
    for name in robot.joints:
        at = model.joints[model.getJointId(name)]
        q[at.idx_q], v[at.idx_v] = values[name], values[f"{name}_dot"]
        tau[at.idx_v] = values[f"torque_{name}"]
    a = pin.aba(model, data, q, v, tau)
    pin.forwardKinematics(model, data, q, v, a)
    pin.updateFramePlacements(model, data)
    world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    for i, name in enumerate(("LF_foot", "RH_foot")):
        frame = model.getFrameId(name)
        acceleration = pin.getFrameClassicalAcceleration(model, data, frame, world).linear
        velocity = pin.getFrameVelocity(model, data, frame, world).linear
        rows = slice(3 * i, 3 * i + 3)
        np.testing.assert_allclose(numbers.b[rows], contact.axes @ acceleration, rtol=1e-9)
        np.testing.assert_allclose(numbers.v[rows], contact.axes @ velocity, rtol=1e-10)
    energy = pin.computeKineticEnergy(model, data, q, v)
    assert moves.kinetic_energy[0] == pytest.approx(energy, rel=1e-12)
    rows = [numbers.v, moves.J @ [values[n] for n in outline.velocity_names]]
    np.testing.assert_allclose(*rows, rtol=1e-10)
    np.testing.assert_allclose(moves.J @ moves.D, numbers.W, atol=1e-10)
    # Accelerations of the coordinates by a difference of their velocities along the motion.
    names, h = [f"base_{k}_dot" for k in ("roll", "pitch", "yaw")], 1e-6
    twice = []
    for sign in (-1, 1):
        there = pin.integrate(model, q, sign * h * v)
        turned = pin.Quaternion(there[3:7]).matrix()
        local = pin.rpy.computeRpyJacobian(pin.rpy.matrixToRpy(turned), pin.ReferenceFrame.LOCAL)
        twice.append(np.linalg.solve(local, (v + sign * h * a)[3:6]))
    place = [outline.velocity_names.index(n) for n in names]
    np.testing.assert_allclose(moves.free[place], (twice[1] - twice[0]) / (2 * h), rtol=1e-5)


def test_keyframes_are_poses():
    robot = ps.robot(FILES / "hopper.xml")
    assert set(robot.tree.poses) == {"home", "tilted"}
    assert robot.tree.poses["home"].joints["knee"] == -1.2
    contact = robot.contact("sole", pose="home", joints={"knee": -1.0})
    assert contact.values["knee"] == -1.0 and contact.values["lift"] == 0.3


def test_poses_of_an_srdf_beside_the_file(tmp_path):
    (tmp_path / "dog.urdf").write_text(DOG.read_text())
    (tmp_path / "dog.srdf").write_text(
        '<robot name="quadruped"><group_state name="standing" group="all">'
        '<joint name="root_joint" value="0 0 0.5 0 0 0 1"/><joint name="LF_KFE" value="-1"/>'
        '<joint name="absent" value="3"/></group_state></robot>'
    )
    robot = ps.robot(tmp_path / "dog.urdf")
    assert robot.contact("LF_foot", pose="standing").values["LF_KFE"] == -1


def test_thousand_poses_of_a_quadruped_take_less_than_a_fifth_of_a_second():
    import time

    contact = dog().contact("LF_foot")
    poses = contact.random_poses(1000)
    contact.thresholds(poses)
    taken = []
    for _ in range(5):
        start = time.process_time()
        contact.thresholds(poses)
        taken.append(time.process_time() - start)
    assert min(taken) < 0.2


def test_singular_mass_matrix_is_an_error_of_every_number(tmp_path):
    """The shaft slides along its axis, about which it turns no inertia."""
    body = '<inertial><origin xyz="0 0 0.5"/><mass value="1"/>{}</inertial>'
    inertia = '<inertia ixx="0.1" iyy="0.1" izz="{}" ixy="0" ixz="0" iyz="0"/>'
    joint = (
        '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
    )
    for izz, singular in ((0.0, True), (0.1, False)):
        file = tmp_path / "shaft.urdf"
        file.write_text(
            '<robot name="shaft"><link name="world"/>'
            f'<link name="slide">{body.format(inertia.format(0.1))}</link>'
            f'<link name="shaft">{body.format(inertia.format(izz))}</link>'
            f"{joint.format('slides', 'prismatic', 'world', 'slide')}"
            f"{joint.format('turns', 'revolute', 'slide', 'shaft')}</robot>"
        )
        contact = ps.robot(file).contact("shaft", point=(0.1, 0.0, 0.0))
        numbers = (contact.mobility, contact.risk, lambda c=contact: c.classify(0.5))
        for number in numbers:
            if singular:
                with pytest.raises(ps.InputError, match="'turns' turns links without inertia"):
                    number()
            else:
                number()
