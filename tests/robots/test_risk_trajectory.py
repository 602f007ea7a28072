"""The risk of a contact along a logged motion, and every solution at a state."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.errors import InputError
from painleve_sym.present.figure_of_risk_trajectory import risk_trajectory_figure
from painleve_sym.robots.motion_log import MotionLog, TouchingRule, read_motion
from painleve_sym.robots.trajectory import risk_along, time_weights

ROBOTS = Path(__file__).parents[2] / "examples" / "robots"
ARM = ROBOTS / "desk_arm.xml"
MOTION = ROBOTS / "motion.csv"


@pytest.fixture(scope="module")
def finger():
    return ps.robot(ARM).contact("finger")


def log(tmp_path, text):
    path = tmp_path / "log.csv"
    path.write_text(text)
    return path


def test_every_sample_is_the_pose_by_itself(finger):
    motion = read_motion(MOTION, finger)
    risk = risk_along(finger, motion, 1.0)
    assert len(risk.t) == 100 and len(risk.case) == 100
    for k in (3, 27, 61):
        joints = {n: float(motion.values[n][k]) for n in ("yaw", "pitch", "roll")}
        alone = ps.robot(ARM).contact("finger", joints=joints)
        assert risk.mu_P[k] == pytest.approx(alone.risk().mu_P, rel=1e-9)
        assert risk.margin[k] == risk.mu_P[k]
    # The desk moves nothing: the finger touches where it neither rises nor falls.
    rates = finger.numbers_at({**finger.values, **motion.values}).gap_rate[0]
    assert risk.closed.tolist() == (np.abs(rates) <= 0.02).tolist()
    assert 0 < risk.closed.sum() < 10
    at_risk = (risk.closed & (risk.mu_P < 1)).astype(float)
    assert risk.share_at_risk == pytest.approx(np.trapezoid(at_risk, risk.t) / risk.t[-1], abs=1e-9)
    assert sum(risk.case_shares.values()) == pytest.approx(1)
    assert risk.to_dict()["least_mu_P"] == risk.mu_P[risk.closed].min()
    assert {risk.case[k] for k in np.flatnonzero(rates > 0.02)} == {"flight"}
    assert {risk.case[k] for k in np.flatnonzero(rates < -0.02)} == {"impact"}
    # Without torques and velocities there is a threshold, but no case.
    bare = MotionLog(motion.t, {n: motion.values[n] for n in ("yaw", "pitch", "roll")})
    assert risk_along(finger, bare, 1.0).case == ()
    assert risk_along(finger, bare).share_at_risk is None
    assert risk_along(finger, bare, 1.0).share_closed == pytest.approx(1)


def test_figure_shades_the_time_at_risk(finger):
    bare = read_motion(MOTION, finger)
    bare = MotionLog(bare.t, {n: bare.values[n] for n in ("yaw", "pitch", "roll")}, bare.t > 0.5)
    risk = risk_along(finger, bare, 1.0)
    assert 0 < risk.at_risk.sum() < (risk.mu_P < 1).sum()
    (axes,) = risk_trajectory_figure(risk).axes
    names = [t.get_text() for t in axes.figure.legends[0].get_texts()]
    assert set(names) == {r"$\mu_P$", "no contact", r"$\mu$", "at risk"}
    (shade,) = axes.collections
    inside = np.zeros(len(risk.t), bool)
    for path in shade.get_paths():
        low, high = path.vertices[:, 0].min(), path.vertices[:, 0].max()
        inside |= (risk.t >= low) & (risk.t <= high)
        assert path.vertices[:, 1].max() <= 1.0
    # A sample at risk without neighbours at risk has no width.
    both = risk.at_risk & (np.roll(risk.at_risk, 1) | np.roll(risk.at_risk, -1))
    assert inside.tolist() == both.tolist()
    line = axes.lines[0].get_ydata()
    assert (
        np.isnan(line[~risk.closed]).all() and (line[risk.closed] == risk.mu_P[risk.closed]).all()
    )


def test_columns_that_are_not_of_the_robot_are_named_and_not_read(tmp_path):
    foot = ps.robot(ROBOTS / "quadruped.urdf").contact("LF_foot", pose="standing")
    path = log(
        tmp_path,
        "t,LF_KFE,normal_x,normal_z,tangent_x,mu,note\n0,-1.4,0.6,0.8,2,9,a\n1,-1.4,1,0,0,,\n",
    )
    motion = read_motion(path, foot)
    assert list(motion.values) == ["LF_KFE"]
    expected = ps.robot(ROBOTS / "quadruped.urdf").contact(
        "LF_foot", pose="standing", joints={"LF_KFE": -1.4}
    )
    assert risk_along(foot, motion).mu_P == pytest.approx([expected.risk().mu_P] * 2, rel=1e-12)
    unread, kept, *_ = motion.notices
    assert "'normal_x', 'normal_z', 'tangent_x', 'mu', 'note'" in unread and "--mu" in unread
    assert "LF_HAA" in kept and "the value of the pose holds" in kept


def test_swing_is_flight_and_no_risk(tmp_path, finger):
    rows = "0,0.5,0.4,0,0,0\n1,0.5,0.4,-2,0,0\n2,0.5,0.4,2,0,0\n3,0.5,0.4,0,0,9\n"
    path = log(tmp_path, "t,pitch,roll,pitch_dot,roll_dot,force\n" + rows)
    alone = risk_along(finger, read_motion(path, finger), 2.0)
    assert alone.mu_P == pytest.approx([alone.mu_P[0]] * 4) and alone.mu_P[0] < 2
    rates = finger.numbers_at({**finger.values, **read_motion(path, finger).values}).gap_rate[0]
    assert abs(rates[1]) > 0.5 and rates[1] == pytest.approx(-rates[2])
    named = ["flight" if rates[1] > 0 else "impact", "flight" if rates[2] > 0 else "impact"]
    assert list(alone.case[1:3]) == named and alone.case[0] not in ("flight", "impact")
    assert alone.share_at_risk == pytest.approx(1 / 3)
    assert "Nothing says when the contact touches" in alone.notices[-1]
    ruled = risk_along(finger, read_motion(path, finger, TouchingRule.of("force > 5")), 2.0)
    assert list(ruled.case[:3]) == ["flight"] * 3 and ruled.case[3] == alone.case[0]
    assert ruled.share_at_risk == pytest.approx(1 / 6) == ruled.share_closed
    assert not any("Nothing says" in notice for notice in ruled.notices)
    down = risk_along(finger, read_motion(path, finger, TouchingRule.of("t>=0")), 2.0)
    assert [{"flight": "liftoff"}.get(case, case) for case in named] == list(down.case[1:3])
    assert down.share_closed == pytest.approx(1)


@pytest.mark.parametrize(
    ("rule", "closed"),
    [
        ("stance", [0, 1, 1, 0]),
        ("stance>0.5", [0, 1, 0, 0]),
        ("stance >= 0.5", [0, 1, 1, 0]),
        ("stance<0.5", [1, 0, 0, 1]),
        ("stance<=5e-1", [1, 0, 1, 1]),
        # Two rods of length 1 from a shoulder at the height 1.
        ("height<1.5", [1, 0, 0, 1]),
        ("height < 500 mm", [1, 0, 0, 0]),
        ("height > 2", [0, 0, 1, 0]),
    ],
)
def test_rule_says_when_the_contact_touches(tmp_path, rule, closed):
    tip = ps.robot(Path(__file__).parent / "files" / "two_link.urdf").contact("tip")
    rows = "0,-0.3,0,0\n1,0.3,0,1\n2,1.2,0.3,0.5\n3,-0.2,0.4,0\n"
    path = log(tmp_path, "t,theta_1,theta_2,stance\n" + rows)
    motion = read_motion(path, tip, TouchingRule.of(rule))
    assert motion.closed.tolist() == [bool(v) for v in closed]
    q = motion.values
    height = 1 + np.sin(q["theta_1"]) + np.sin(q["theta_1"] + q["theta_2"])
    np.testing.assert_allclose(tip.heights({**tip.values, **q}), height, atol=1e-12)


def test_height_of_a_floating_robot_is_that_of_its_base_and_of_a_round_foot(tmp_path):
    dog = ps.robot(ROBOTS / "quadruped.urdf")
    foot = dog.contact("LF_foot", pose="standing", radius=0.02)
    at = {**foot.values, "base_z": np.array([0.0, 0.5]), "base_yaw": np.array([0.0, 1.0])}
    low, high = foot.heights(at)
    assert high - low == pytest.approx(0.5, abs=1e-12)
    bare = dog.contact("LF_foot", pose="standing").heights(at)
    np.testing.assert_allclose(bare - [low, high], 0.02, atol=1e-12)
    path = log(tmp_path, "t,LF_KFE\n0,-1.4\n1,-1.4\n")
    with pytest.raises(InputError, match="needs the column base_z"):
        read_motion(path, foot, TouchingRule.of("height<0.001"))


def test_a_foot_that_creeps_sticks(tmp_path):
    foot = ps.robot(ROBOTS / "quadruped.urdf").contact("LF_foot", pose="standing")
    path = log(tmp_path, "t,base_x_dot,base_z_dot\n0,0,0\n1,0.004,0.001\n2,0.5,0\n")
    motion = read_motion(path, foot)
    assert risk_along(foot, motion, 1.0).case == ("stick", "stick", "slip")
    assert risk_along(foot, motion, 1.0, rest=0.0).case == ("stick", "flight", "slip")
    assert risk_along(foot, motion, 1.0, rest=1.0).case == ("stick", "stick", "stick")
    assert "torque_LF_HAA" in " ".join(motion.notices)


def test_a_locked_joint_that_moves_in_the_log_is_named(tmp_path):
    foot = ps.robot(ROBOTS / "quadruped.urdf").contact("LF_foot", pose="standing", locked="LF_KFE")
    motion = read_motion(log(tmp_path, "t,LF_KFE,LF_KFE_dot\n0,-1,0\n1,-1.1,-0.1\n"), foot)
    assert any("Locked joints have no velocity" in n and "LF_KFE" in n for n in motion.notices)


def test_weights_are_those_of_the_trapezoidal_rule():
    t = np.array([0.0, 1.0, 1.5, 4.0])
    values = np.array([2.0, -1.0, 3.0, 0.5])
    assert time_weights(t) @ values == pytest.approx(np.trapezoid(values, t) / 4)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "got 0 lines"),
        ("yaw\n1\n", "has no column t"),
        ("t;yaw\n0;1\n", "has no column t, the time in s. Fix: separate columns by commas"),
        ("t,yaww\n0,1\n", "has no column of the robot, need such as yaw, pitch, roll"),
        ("t,yaw\n0,1\n1,99\n", "sample 2, t = 1 s: joint yaw: got 99 rad, need a value within"),
        ('t,yaw\n0,"1' + 131073 * "x", "line 2: not CSV: "),
        ('t,yaw\n0,"1\n', "line 2: not CSV: unexpected end of data"),
        ("t,yaw [deg]\n0,1\n", "got the unit 'deg', need rad"),
        ("t,yaw,yaw\n0,1,1\n", "got column yaw twice"),
        ("t,yaw\n0,1\n1,nan\n", "sample 2: need finite numbers, got 'nan' in column yaw"),
        ("t,yaw\n0,1,2\n", "sample 1: need 2 finite numbers, got 3 cells"),
        ("t,yaw\n0,1\n0,1\n", "sample 2: the time does not grow"),
    ],
)
def test_fault_of_a_table_is_one_sentence(tmp_path, finger, text, expected):
    (tmp_path / "motion.csv").write_text(text)
    with pytest.raises(InputError, match=re.escape(expected)):
        read_motion(tmp_path / "motion.csv", finger)


def test_units_and_comments_are_read(tmp_path, finger):
    (tmp_path / "motion.csv").write_text("# log\nt [s],yaw [rad],torque_yaw [N m]\n0,1,2\n1,2,3\n")
    assert read_motion(tmp_path / "motion.csv", finger).values["torque_yaw"].tolist() == [2.0, 3.0]


def test_solutions_at_a_state_are_those_of_W_and_b():
    dog = ps.robot(ROBOTS / "quadruped.urdf")
    foot = dog.contact("LF_foot", pose="standing")
    sliding = foot.classify(2.5, {"base_x": 0.3}, {"LF_KFE": 4.0})
    numbers = foot.numbers_at({**foot.values, "base_x_dot": np.array([0.3]), "torque_LF_KFE": 4.0})
    again = ps.contact(foot.mobility(), numbers.b[:3, 0], 2.5, [0.3, 0.0])
    assert sliding.case is again.case and sliding.A < 0
    with pytest.raises(InputError, match=r"normal velocity -0\.2 m/s, need 0"):
        foot.classify(0.5, {"base_z": -0.2})
    with pytest.raises(InputError, match="unknown torque 'LF_KF'"):
        foot.classify(0.5, torques={"LF_KF": 1.0})


def test_example_logs_a_motion_of_mujoco(tmp_path):
    pytest.importorskip("mujoco", reason="needs the group robots (mujoco)")
    script, out = ROBOTS.parent / "studies" / "peers" / "log_motion.py", tmp_path / "motion.csv"
    subprocess.run([sys.executable, str(script), str(ARM), str(out)], check=True, timeout=120)
    log = np.genfromtxt(out, delimiter=",", skip_header=1)
    np.testing.assert_allclose(log, np.genfromtxt(MOTION, delimiter=",", skip_header=1), rtol=1e-6)


def test_case_along_the_motion_is_that_of_mujocos_numbers():
    mujoco = pytest.importorskip("mujoco", reason="needs the group robots (mujoco)")
    model = mujoco.MjModel.from_xml_path(str(ARM))
    data = mujoco.MjData(model)
    finger = ps.robot(ARM).contact("finger")
    motion = read_motion(MOTION, finger)
    names = ("yaw", "pitch", "roll")
    numbers = finger.numbers_at({**finger.values, **motion.values})
    for k in (10, 60):
        for n in names:
            data.joint(n).qpos, data.joint(n).qvel = (
                motion.values[n][k],
                motion.values[f"{n}_dot"][k],
            )
        data.qfrc_applied[:] = [motion.values[f"torque_{n}"][k] for n in names]
        mujoco.mj_forward(model, data)
        site = model.site("finger").id
        # Acceleration of the site from the free accelerations, by a difference of its velocity.
        h, v, twice = 1e-6, data.qvel.copy(), []
        start, slope = data.qpos.copy(), data.qacc.copy()
        for sign in (-1, 1):
            data.qpos[:] = start + sign * h * v
            mujoco.mj_forward(model, data)
            J = np.zeros((3, 3))
            mujoco.mj_jacSite(model, data, J, None, site)
            twice.append(J @ (v + sign * h * slope))
        acceleration = (twice[1] - twice[0]) / (2 * h)
        expected = acceleration[[2, 0, 1]]
        np.testing.assert_allclose(numbers.b[:, k], expected, rtol=1e-5, atol=1e-5)
        data.qpos[:], data.qvel[:] = start, v


def test_normals_of_a_log_are_those_of_its_surfaces(tmp_path):
    dog = ps.robot(ROBOTS / "quadruped.urdf")
    foot = dog.contact("LF_foot", pose="standing")
    normals = [(0.6, 0, 0.8), (3, 0, 4), (0.95, 0.1, -0.2)]
    rows = "\n".join(f"{k},-1.4,{x},{y},{z}" for k, (x, y, z) in enumerate(normals))
    path = log(tmp_path, f"t,LF_KFE,normal_x,normal_y,normal_z\n{rows}\n")
    motion = read_motion(path, foot)
    along = risk_along(foot, motion)
    alone = [dog.contact("LF_foot", pose="standing", normal=n).risk() for n in normals]
    assert along.mu_P == pytest.approx([risk.mu_P for risk in alone], rel=1e-12)
    assert along.mu_P[0] == pytest.approx(5.614, abs=5e-4)
    assert motion.notices[0].startswith("The normal at each sample is that of the log")
    path = log(tmp_path, "t,LF_KFE,normal_x,normal_y,normal_z\n0,-1.4,0,0,0\n")
    with pytest.raises(InputError, match="sample 1: the normal is 0"):
        read_motion(path, foot)


def test_joints_called_like_a_normal_are_joints_in_a_log(tmp_path):
    text = (ROBOTS / "quadruped.urdf").read_text()
    for leg, part in zip(("HAA", "HFE", "KFE"), "xyz", strict=True):
        text = text.replace(f"LF_{leg}", f"normal_{part}")
    path = tmp_path / "dog.urdf"
    path.write_text(text)
    motion = log(tmp_path, "t,normal_x,normal_y,normal_z\n0,0.1,0.7,-1.4\n")
    foot = ps.robot(path).contact("LF_foot")
    joints = {"LF_HAA": 0.1, "LF_HFE": 0.7, "LF_KFE": -1.4}
    plain = ps.robot(ROBOTS / "quadruped.urdf").contact("LF_foot", joints=joints)
    mu_P = risk_along(foot, read_motion(motion, foot)).mu_P
    assert mu_P == pytest.approx([plain.risk().mu_P], rel=1e-12)
