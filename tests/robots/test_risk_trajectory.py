"""The risk of a contact along a logged motion, and every solution at a state."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.errors import InputError
from painleve_sym.present.risk_trajectory_figure import risk_trajectory_figure
from painleve_sym.robots.trajectory import read_motion, risk_along, time_weights

ROBOTS = Path(__file__).parents[2] / "examples" / "robots"
ARM = ROBOTS / "desk_arm.xml"
MOTION = ROBOTS / "motion.csv"


@pytest.fixture(scope="module")
def finger():
    return ps.robot(ARM).contact("finger")


def test_every_sample_is_the_pose_by_itself(finger):
    motion = read_motion(MOTION, finger)
    risk = risk_along(finger, motion, 1.0)
    assert len(risk.t) == 100 and len(risk.case) == 100
    for k in (3, 27, 61):
        joints = {n: float(motion[n][k]) for n in ("yaw", "pitch", "roll")}
        alone = ps.robot(ARM).contact("finger", joints=joints)
        assert risk.mu_P[k] == pytest.approx(alone.risk().mu_P, rel=1e-9)
        assert risk.margin[k] == risk.mu_P[k]
    at_risk = (risk.mu_P < 1).astype(float)
    assert risk.share_at_risk == pytest.approx(np.trapezoid(at_risk, risk.t) / risk.t[-1], abs=1e-9)
    assert sum(risk.case_shares.values()) == pytest.approx(1)
    assert risk.to_dict()["least_mu_P"] == risk.mu_P.min()
    # Without torques and velocities there is a threshold, but no case.
    bare = {n: motion[n] for n in ("t", "yaw", "pitch", "roll")}
    assert risk_along(finger, bare, 1.0).case == ()
    assert risk_along(finger, bare).share_at_risk is None


def test_figure_shades_the_time_at_risk(finger):
    figure = risk_trajectory_figure(risk_along(finger, read_motion(MOTION, finger), 1.0))
    (axes,) = figure.axes
    assert [t.get_text() for t in figure.legends[0].get_texts()][-1] == "at risk"
    assert len(axes.collections) == 1


def test_weights_are_those_of_the_trapezoidal_rule():
    t = np.array([0.0, 1.0, 1.5, 4.0])
    values = np.array([2.0, -1.0, 3.0, 0.5])
    assert time_weights(t) @ values == pytest.approx(np.trapezoid(values, t) / 4)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "got 0 lines"),
        ("yaw\n1\n", "has no column t"),
        ("t,yaww\n0,1\n", "unknown column 'yaww'. Did you mean 'yaw'?"),
        ("t,yaw [deg]\n0,1\n", "got the unit 'deg', need rad"),
        ("t,yaw,yaw\n0,1,1\n", "got column yaw twice"),
        ("t,yaw\n0,1\n1,nan\n", "sample 2: need 2 finite numbers"),
        ("t,yaw\n0,1,2\n", "sample 1: need 2 finite numbers, got 3 cells"),
        ("t,yaw\n0,1\n0,1\n", "sample 2: the time does not grow"),
    ],
)
def test_fault_of_a_table_is_one_sentence(tmp_path, finger, text, expected):
    (tmp_path / "motion.csv").write_text(text)
    with pytest.raises(InputError, match=expected.replace("?", r"\?")):
        read_motion(tmp_path / "motion.csv", finger)


def test_units_and_comments_are_read(tmp_path, finger):
    (tmp_path / "motion.csv").write_text("# log\nt [s],yaw [rad],torque_yaw [N m]\n0,1,2\n1,2,3\n")
    assert read_motion(tmp_path / "motion.csv", finger)["torque_yaw"].tolist() == [2.0, 3.0]


def test_solutions_at_a_state_are_those_of_W_and_b():
    dog = ps.robot(ROBOTS / "quadruped.urdf")
    foot = dog.contact("LF_foot", pose="standing")
    sliding = foot.classify(2.5, {"base_x": 0.3}, {"LF_KFE": 4.0}).answer
    numbers = foot.numbers_at({**foot.values, "base_x_dot": np.array([0.3]), "torque_LF_KFE": 4.0})
    again = ps.contact(foot.mobility(), numbers.b[:3, 0], 2.5, [0.3, 0.0])
    assert sliding.case is again.case and sliding.A < 0
    with pytest.raises(InputError, match=r"normal velocity -0\.2 m/s, need 0"):
        foot.classify(0.5, {"base_z": -0.2})
    with pytest.raises(InputError, match="unknown torque 'LF_KF'"):
        foot.classify(0.5, torques={"LF_KF": 1.0})


def test_example_logs_a_motion_of_mujoco(tmp_path):
    pytest.importorskip("mujoco", reason="needs the extra robots (mujoco)")
    script, out = ROBOTS.parent / "studies" / "peers" / "log_motion.py", tmp_path / "motion.csv"
    subprocess.run([sys.executable, str(script), str(ARM), str(out)], check=True, timeout=120)
    log = np.genfromtxt(out, delimiter=",", skip_header=1)
    np.testing.assert_allclose(log, np.genfromtxt(MOTION, delimiter=",", skip_header=1), rtol=1e-6)


def test_case_along_the_motion_is_that_of_mujocos_numbers():
    mujoco = pytest.importorskip("mujoco", reason="needs the extra robots (mujoco)")
    model = mujoco.MjModel.from_xml_path(str(ARM))
    data = mujoco.MjData(model)
    finger = ps.robot(ARM).contact("finger")
    motion = read_motion(MOTION, finger)
    names = ("yaw", "pitch", "roll")
    numbers = finger.numbers_at({**finger.values, **{n: v for n, v in motion.items() if n != "t"}})
    for k in (10, 60):
        for n in names:
            data.joint(n).qpos, data.joint(n).qvel = motion[n][k], motion[f"{n}_dot"][k]
        data.qfrc_applied[:] = [motion[f"torque_{n}"][k] for n in names]
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
