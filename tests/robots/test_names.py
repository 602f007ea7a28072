"""Names of joints and links, and their order in the file, change no number."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.errors import InputError
from painleve_sym.robots.dynamics import coordinate_names
from tests.cli.cli_helpers import rejected, run_json
from tests.robots.random_robots import HOSTILE, random_parts, urdf

CLASH = """<robot name="c"><link name="a"><inertial><mass value="5"/>
<inertia ixx="0.01" iyy="0.02" izz="0.015"/></inertial></link><link name="b"><inertial>
<origin xyz="0.03 0.02 -0.1"/><mass value="1"/><inertia ixx="0.01" iyy="0.02" izz="0.015"/>
</inertial></link><joint name="NAME" type="revolute"><parent link="a"/><child link="b"/>
<origin xyz="0.05 0.02 -0.2"/><axis xyz="0 1 0"/><limit lower="-1" upper="1"/></joint></robot>"""


def numbers(path: Path, names: dict[str, str], frame: str, floating: bool) -> list:
    """Return all numbers of a contact by the names of joints and links that stand in its file."""
    robot, mu = ps.robot(path, floating=floating), 1.2
    values = {name: 0.1 * k - 0.2 for k, name in enumerate(names)}
    tip = robot.contact(
        frame, point=(0.1, 0.2, -0.15), joints={names[n]: v for n, v in values.items()}
    )
    own = tip.dynamics.coordinates
    velocities = {own[names[n]]: 0.3 + v for n, v in values.items()}
    torques = {names[n]: 1 - v for n, v in values.items()}
    risk = tip.risk(mu)
    poses = {names[n]: np.array([0.5, -0.3]) + v for n, v in values.items()}
    moving = {f"{n}_dot": v for n, v in velocities.items()}
    moving |= {f"torque_{own[n]}": v for n, v in torques.items()}
    b = tip.numbers_at({**tip.values, **moving}).b
    kept = [risk.W, b, risk.mu_P, risk.least_over_normals, risk.direction, tip.thresholds(poses)]
    kept += [risk.gradient[names[n]] for n in values]
    drawn = tip.random_poses(20, seed=3)
    kept += [drawn[names[n]] for n in values if names[n] in drawn]
    kept += [np.sort(tip.thresholds(drawn))]
    if np.linalg.eigvalsh(risk.W)[0] > 1e-3 * risk.W[0, 0]:
        slip = {"contact_velocity": (0.0, 0.3, 0.1)}
        answer = tip.classify(mu, velocities, torques, **slip)
        kept += [list(answer.case.value.encode()), *(s.force for s in answer.solutions)]
        jump = tip.jump("poisson", mu, 0.5, velocities, contact_velocity=(-0.2, 0.3, 0.1))
        kept += [jump.velocity[f"{own[names[n]]}_dot"] for n in values]
        kept += [jump.energy_change]
    box = {own[names[n]]: (v - 0.01, v + 0.01) for n, v in values.items()}
    positive = tip.positive_function(box, mu)
    kept += [np.array(positive.function([low for low, _ in box.values()]))[-1]]
    return kept


def agree(path: Path, seed: int) -> None:
    """Compare a random robot with plain names with the same one with hostile names, shuffled."""
    parts, random = random_parts(seed), np.random.default_rng([seed, 1])
    count = len(parts)
    plain = [f"q{k}" for k in range(count)], [f"l{k}" for k in range(count)]
    hostile = [list(random.choice(HOSTILE, count, replace=False)) for _ in range(2)]
    both = []
    for (joints, links), order in (
        (plain, list(range(count))),
        (hostile, [0, *random.permutation(np.arange(1, count))]),
    ):
        path.write_text(urdf(parts, links, joints, order), "utf-8")
        names = {f"q{k}": str(joints[k]) for k in range(1, count)}
        both.append(numbers(path, names, str(links[-1]), seed % 2 == 0))
    for one, other in zip(*both, strict=True):
        one, other = np.asarray(one, float), np.asarray(other, float)
        np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-11 * max(1, np.abs(one).max()))


@pytest.mark.parametrize("seed", (1, 2))
def test_names_and_order_change_no_number(tmp_path, seed):
    agree(tmp_path / "random.urdf", seed)


@pytest.mark.slow
def test_names_and_order_change_no_number_of_100_robots(tmp_path):
    for seed in range(100):
        agree(tmp_path / "random.urdf", seed)


def test_the_order_of_equal_legs_changes_no_random_pose(tmp_path):
    # Legs at one place differ by what they carry alone; each is as good as its equal.
    base = "<robot name='r'><link name='base'><inertial><mass value='2'/><inertia ixx='1' iyy='1'"
    base += " izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>"
    link = "<link name='{0}'><inertial><origin xyz='0 0 -.1'/><mass value='{1}'/><inertia ixx='.01'"
    link += " iyy='.01' izz='.01' ixy='0' ixz='0' iyz='0'/></inertial></link>"
    joint = "<joint name='j{1}' type='revolute'><parent link='{0}'/><child link='{1}'/>"
    joint += "<origin xyz='0 0 -.2'/><axis xyz='0 1 0'/><limit lower='-1' upper='1'/></joint>"
    legs = []
    for name, foot_mass in (("a", 0.5), ("b", 0.3), ("c", 0.4)):
        upper = link.format(name, 1.0) + joint.format("base", name)
        legs.append(upper + link.format(f"{name}2", foot_mass) + joint.format(name, f"{name}2"))
    drawn = []
    for order in itertools.permutations(legs):
        path = tmp_path / "legs.urdf"
        path.write_text(base + "".join(order) + "</robot>")
        tip = ps.robot(path, floating=True).contact("a2", point=(0.1, 0.0, -0.2))
        drawn.append({name: tuple(v) for name, v in tip.random_poses(5).items()})
    assert all(one == drawn[0] for one in drawn)
    assert len(set(drawn[0].values())) == 6


@pytest.mark.parametrize(
    "name",
    [
        *("normal_x", "mu", "t", "base_x", "base_pitch", "torque_j1", "W_0_0", "x", "ratio", "I"),
        *("lambda", "a joint", "left-knee", "2nd", "knie é", "all", "E"),
    ],
)
def test_a_joint_may_have_any_name(capsys, tmp_path, name):
    path = tmp_path / "clash.urdf"
    path.write_text(CLASH.replace("NAME", name), "utf-8")
    call = ("robot", str(path), "--contact", "b", "--joints", f"{name}=0.5", "--poses", "3")
    data = run_json(capsys, *call)
    # By MuJoCo's mass matrix and Jacobian.
    assert data["mu_P"] == pytest.approx(1.3591742840818013, rel=1e-12)
    assert list(data["gradient"]) == [name]


def test_a_joint_with_a_foreign_name_is_named_in_a_notice(capsys, tmp_path):
    path = tmp_path / "clash.urdf"
    path.write_text(CLASH.replace("NAME", "normal_x"))
    call = ("robot", str(path), "--contact", "b", "--joints", "normal_x=0.5", "--poses", "3")
    assert "joint 'normal_x' is joint_normal_x." in run_json(capsys, *call)["notices"][0]
    where = (str(path), "--contact", "b", "--set", "mu=2", "--contact-velocity", "0,1,0")
    data = run_json(capsys, "classify", *where, "--state", "joint_normal_x=0.5")
    assert data["state"]["joint_normal_x"] == 0.5
    err = rejected(capsys, "classify", *where, "--state", "normal_x=0.5")
    assert "unknown state 'normal_x'. Did you mean 'joint_normal_x'?" in err
    with pytest.raises(InputError, match="unknown torque 'joint_normal'"):
        ps.robot(path).contact("b").classify(1.0, torques={"joint_normal": 1.0})


@pytest.mark.parametrize("name", ["E", "e_energetic"])
def test_a_joint_called_like_a_parameter_of_a_law_changes_no_jump(capsys, tmp_path, name):
    dog = (Path(__file__).parents[2] / "examples" / "robots" / "quadruped.urdf").read_text("utf-8")
    answers = []
    for joint in ("knee", name):
        path = tmp_path / "dog.urdf"
        path.write_text(dog.replace("LF_KFE", joint), "utf-8")
        own = coordinate_names([joint])[joint]
        call = (str(path), "--contact", "LF_foot", "--set", "mu=2", "--contact-velocity", "0,1,0")
        call += ("--state", f"LF_HFE=0.7,{own}=-1.4")
        velocity = run_json(capsys, "jump", *call)["final"]["velocity"]
        if name == "E":
            contrast = run_json(capsys, "contrast", *call, "--stiffness", "1e9")
            velocity |= {"softened": contrast["softened"][0]["velocity"][f"{own}_dot"]}
        answers.append({k.replace(own, "knee"): v for k, v in velocity.items()})
    assert answers[0] == answers[1]


def test_names_of_coordinates_are_all_different():
    names = [n for n in HOSTILE if n != "t"]
    own = coordinate_names(names)
    every = [t for n in own.values() for t in (n, f"{n}_dot", f"torque_{n}")]
    assert len(set(every)) == 3 * len(names)
    assert own["j1"] == "j1" and own["I"] == "I"
    assert own["E"] == "joint_E" and own["e_energetic"] == "joint_e_energetic"
    assert own["base_x"] == "joint_base_x" and json.dumps(own)
