"""Robots of the package example-robot-data: published digits, Pinocchio, and the page's table."""

from __future__ import annotations

import importlib.util
import math
import re
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.errors import InputError

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "examples" / "studies" / "robots" / "robots.py"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def study():
    import sys

    specification = importlib.util.spec_from_file_location("robots_study", SCRIPT)
    module = importlib.util.module_from_spec(specification)
    sys.modules["robots_study"] = module
    specification.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def folder(study):
    place = study.data_folder()
    if place is None:
        pytest.skip("needs the robots of a group: pip install --group robots")
    return place


def case_of(study, title):
    return next(case for case in study.CASES if case.title == title)


def test_anymal_has_the_mobility_of_an_independent_computation(study, folder):
    contact = study.contact_of(case_of(study, "ANYmal C"), folder)
    t1, t2, n = (
        (5.71585191, 0.1044024, 3.2001139),
        (0.1044024, 1.3136258, 0.19408619),
        (3.2001139, 0.19408619, 2.17529076),
    )
    expected = np.array([t1, t2, n])[np.ix_([2, 0, 1], [2, 0, 1])]
    np.testing.assert_allclose(contact.mobility(), expected, atol=6e-9)
    risk = contact.risk(0.8)
    assert risk.mu_P == pytest.approx(0.6785, abs=5e-5)
    assert np.degrees(risk.sector.half_angle) == pytest.approx(32, abs=0.5)


def test_foot_of_anymal_has_an_impact_without_collision(study, folder):
    contact = study.contact_of(case_of(study, "ANYmal C"), folder)
    velocity = (0.0, *contact.risk(0.8).direction)
    jump = contact.jump("energetic", 0.8, 0.75, contact_velocity=velocity)
    assert [p.name for p in jump.phases] == [
        *("tangential", "sticking compression", "sticking restitution")
    ]
    # The published digits of W alone.
    W = [[2.17529076, 3.2001139, 0.19408619], [3.2001139, 5.71585191, 0.1044024]]
    W.append([0.19408619, 0.1044024, 1.3136258])
    known = ps.solve_impact(W, 0.8, velocity, "energetic", 0.75)
    assert known.without_collision
    assert jump.normal_impulse == pytest.approx(known.normal_impulse, rel=1e-7)
    assert jump.phases[-1].normal_velocity == pytest.approx(known.velocity[0], rel=1e-7)
    assert jump.energy_change == pytest.approx(known.energy_change, rel=1e-7)
    # What the page says.
    assert sum(p.normal_impulse for p in jump.phases[:2]) == pytest.approx(1.52, abs=5e-3)
    assert jump.phases[-1].normal_velocity == pytest.approx(0.30, abs=5e-3)
    assert jump.energy_change / jump.kinetic_energy == pytest.approx(-0.76, abs=5e-3)


def test_anymal_with_rotors_stuck_feet_and_locked_joints(study, folder):
    case = case_of(study, "ANYmal C")
    path = folder / case.file
    for armature, mu_P in ((0.01, 0.684), (0.2, 0.720)):
        robot = ps.robot(path, armature=armature)
        risk = robot.contact(case.frame, joints=case.joints).risk()
        assert risk.mu_P == pytest.approx(mu_P, abs=5e-4)
    robot = ps.robot(path)
    feet = "LF_FOOT,RF_FOOT,LH_FOOT,RH_FOOT"
    stuck = robot.contact(feet, joints=case.joints, others="stuck").risk().mu_P
    assert stuck == pytest.approx(0.678, abs=6e-4)
    locked = robot.contact(case.frame, joints=case.joints, locked="all").risk().mu_P
    assert locked == pytest.approx(1.076, abs=5e-4)


@pytest.mark.parametrize(
    ("title", "mu_P"),
    [("HyQ", 1.241), ("Bolt", 1.313), ("Solo 12", 1.660), ("Go2", 1.677), ("A1", 3.664)],
)
def test_other_standing_robots(study, folder, title, mu_P):
    risk = study.contact_of(case_of(study, title), folder).risk()
    assert risk.mu_P == pytest.approx(mu_P, abs=5e-4)


def test_go2_with_rotors_and_locked(study, folder):
    case = case_of(study, "Go2")
    heavy = ps.robot(folder / case.file, armature=0.01).contact(case.frame, pose=case.pose)
    assert heavy.risk().mu_P == pytest.approx(1.322, abs=5e-4)
    locked = ps.robot(folder / case.file).contact(case.frame, pose=case.pose, locked="all")
    assert locked.risk().mu_P == pytest.approx(0.946, abs=5e-4)


@pytest.mark.parametrize(
    # Not the Panda: Pinocchio moves the finger that mimics the other one by itself.
    "title",
    ["ANYmal C", "Go2", "HyQ", "Talos", "UR5", "Solo 12"],
)
def test_mobility_is_that_of_pinocchio(study, folder, title):
    pin = pytest.importorskip("pinocchio", reason="needs the group robots (pin)")
    case = case_of(study, title)
    contact = study.contact_of(case, folder)
    joint = [pin.JointModelFreeFlyer()] if case.floating else []
    model = pin.buildModelFromUrdf(str(folder / case.file), *joint)
    data = model.createData()
    q = pin.neutral(model)
    if case.floating and case.pose is not None:
        w, *axis = contact.dynamics.tree.poses[case.pose].base
        q[3:7] = (*axis, w)
        q = pin.normalize(model, q)
    for name in contact.joints:
        at = model.joints[model.getJointId(name)]
        value = contact.values[name]
        q[at.idx_q : at.idx_q + at.nq] = value if at.nq == 1 else (np.cos(value), np.sin(value))
    M = pin.crba(model, data, q)
    M = np.triu(M) + np.triu(M, 1).T
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    J = pin.getFrameJacobian(model, data, model.getFrameId(case.frame), world)[:3]
    W = (J @ np.linalg.solve(M, J.T))[np.ix_([2, 0, 1], [2, 0, 1])]
    np.testing.assert_allclose(contact.mobility(), W, rtol=0, atol=1e-11 * np.abs(W).max())


def test_robot_with_links_of_no_inertia_is_an_error_or_has_rotors(folder):
    path = folder / "icub_description" / "robots" / "icub.urdf"
    with pytest.raises(InputError, match="'neck_yaw' turns links without inertia"):
        ps.robot(path).contact("l_sole", pose="half_sitting").risk()
    assert ps.robot(path, armature=0.01).contact("l_sole").risk().mu_P > 0


def test_share_of_poses_of_anymal_at_risk(study, folder):
    contact = study.contact_of(case_of(study, "ANYmal C"), folder)
    share = np.mean(contact.thresholds(contact.random_poses(20_000)) < 1)
    assert 0.44 < share < 0.51


def test_table_of_the_page_is_that_of_the_script(study, folder):
    page = (ROOT / "docs" / "how-to" / "robot.md").read_text("utf-8")
    shown = {m[1]: m[0] for m in re.finditer(r"^\| ([A-Za-z][\w ]+) \| `.*\|$", page, re.M)}
    shown.pop("robot", None)
    assert set(shown) == {case.title for case in study.CASES}
    for case in study.CASES:
        cells = [c.strip() for c in shown[case.title].strip("|").split("|")]
        row = study.row(case, folder, 5000)
        assert tuple(cells[3:]) == study.cells(row)


def test_thresholds_at_the_lowest_point_of_a_ball_are_those_of_pinocchio(study, folder):
    pin = pytest.importorskip("pinocchio", reason="needs the group robots (pin)")
    case = case_of(study, "A1")
    (center, radius), contact = study.ball_of(case, folder), study.contact_of(case, folder, True)
    model = pin.buildModelFromUrdf(str(folder / case.file), pin.JointModelFreeFlyer())
    data, q = model.createData(), pin.neutral(model)
    for name in contact.joints:
        q[model.joints[model.getJointId(name)].idx_q] = contact.values[name]
    M = pin.crba(model, data, q)
    M = np.triu(M) + np.triu(M, 1).T
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    frame = model.getFrameId(case.frame)
    world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    whole = pin.getFrameJacobian(model, data, frame, world)
    lever = data.oMf[frame].rotation @ center - [0, 0, radius]
    J = (whole[:3] + np.cross(whole[3:].T, lever).T)[[2, 0, 1]]
    W = J @ np.linalg.solve(M, J.T)
    mu_P = W[0, 0] / np.linalg.norm(W[1:, 0])
    assert contact.risk().mu_P == pytest.approx(mu_P, rel=1e-10) == pytest.approx(2.747, abs=5e-4)


@pytest.mark.parametrize(
    ("lowest", "impulses", "lost"),
    [(True, (0.657, 1.501, 2.363), 0.73), (False, (0.782, 1.524, 2.338), 0.76)],
)
def test_dragged_foot_of_the_page_stops_is_pressed_in_and_leaves(
    study, folder, lowest, impulses, lost
):
    foot = study.contact_of(study.CASES[0], folder, lowest)
    slip = (0.0, *foot.risk().direction)
    jump = foot.jump("energetic", 0.8, 0.75, contact_velocity=slip)
    assert [p.name for p in jump.phases][1:] == ["sticking compression", "sticking restitution"]
    sums = np.cumsum([phase.normal_impulse for phase in jump.phases])
    np.testing.assert_allclose(sums, impulses, atol=5e-4)
    assert -jump.energy_change / jump.kinetic_energy == pytest.approx(lost, abs=5e-3)


def test_numbers_of_the_page_on_an_anymal_at_the_lowest_point(study, folder):
    case = study.CASES[0]
    center, radius = study.ball_of(case, folder)
    place = {"joints": case.joints, "point": center, "radius": radius}

    def threshold(frames="LF_FOOT", armature=None, **options):
        robot = ps.robot(folder / case.file, armature=armature)
        return robot.contact(frames, **place, **options).risk(0.8).mu_P

    feet = "LF_FOOT,RF_FOOT,LH_FOOT,RH_FOOT"
    numbers = [threshold(), threshold(armature=0.01), threshold(armature=0.2)]
    numbers += [threshold(feet, others="stuck"), threshold(locked="all")]
    np.testing.assert_allclose(numbers, [0.640, 0.648, 0.700, 0.640, 1.049], atol=5e-4)
    assert math.degrees(math.acos(numbers[0] / 0.8)) == pytest.approx(37, abs=0.5)
    go2 = case_of(study, "Go2")
    ball = ps.robot(folder / go2.file).contact(go2.frame, pose=go2.pose, radius=0.022)
    assert ball.risk().mu_P == pytest.approx(1.403, abs=5e-4)


@pytest.mark.parametrize(("title", "mu"), [("ANYmal C", 0.5), ("Go2", 1.5), ("HyQ", 1.0)])
def test_leg_is_proved_over_a_box(study, folder, title, mu):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    from painleve_sym.certify.checker import check
    from painleve_sym.certify.proof import prove_positive

    contact = study.contact_of(case_of(study, title), folder)
    leg = contact.dynamics.contacts[0].frame[:2]
    over = {n: (v - 0.05, v + 0.05) for n, v in contact.values.items() if n in contact.joints}
    over = {n: ends for n, ends in over.items() if n.startswith(leg)}
    assert len(over) == 3
    positive = contact.positive_function(over, mu)
    proof = prove_positive(positive.function, positive.conditions, over, title)
    assert proof.verdict == "proved" and check(proof.certificate) == proof.pieces <= 3


def independent_mobility(pin, path, contact):
    """Return the mobility by Pinocchio, whose joints that mimic are independent before."""
    tree = contact.dynamics.tree
    base = [pin.JointModelFreeFlyer()] if tree.floating else []
    model = pin.buildModelFromUrdf(str(path), *base)
    data, position = model.createData(), pin.neutral(model)

    def joint(name):
        return model.joints[model.getJointId(name)]

    for name in tree.joints:
        own, value = joint(name), contact.values[name]
        values = value if own.nq == 1 else (np.cos(value), np.sin(value))
        position[own.idx_q : own.idx_q + own.nq] = values
    rates, follows = np.eye(model.nv), []
    for body in tree.bodies:
        if body.joint is not None and (leader := body.joint.mimic) is not None:
            own, other = joint(body.joint.name), joint(leader.joint)
            position[own.idx_q] = leader.factor * contact.values[leader.joint] + leader.offset
            rates[own.idx_v] = leader.factor * rates[other.idx_v]
            follows.append(own.idx_v)
    rates = np.delete(rates, follows, axis=1)
    mass = pin.crba(model, data, position)
    mass = rates.T @ (np.triu(mass) + np.triu(mass, 1).T) @ rates
    pin.computeJointJacobians(model, data, position)
    pin.updateFramePlacements(model, data)
    frame = model.getFrameId(contact.dynamics.contacts[0].frame)
    world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    jacobian = (pin.getFrameJacobian(model, data, frame, world)[:3] @ rates)[[2, 0, 1]]
    return jacobian @ np.linalg.solve(mass, jacobian.T)


def test_every_robot_of_the_data_has_the_mobility_of_pinocchio_or_a_sentence(folder):
    pin = pytest.importorskip("pinocchio", reason="needs the group robots (pin)")
    compared = refused = 0
    for path in sorted(folder.rglob("*.urdf")):
        try:
            robot = ps.robot(path)
            parents = {body.parent for body in robot.tree.bodies}
            ends = [b.name for i, b in enumerate(robot.tree.bodies) if i not in parents]
            contact = robot.contact(ends[-1])
            mobility = contact.mobility()
        except InputError as error:
            refused += 1
            assert "\n" not in str(error)
            continue
        expected = independent_mobility(pin, path, contact)
        size = np.abs(expected).max()
        np.testing.assert_allclose(mobility, expected, rtol=0, atol=1e-9 * size, err_msg=path.name)
        compared += 1
    assert compared >= 60
    assert refused <= 8
