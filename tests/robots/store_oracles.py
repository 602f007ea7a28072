"""Numbers of robots by MuJoCo and Pinocchio, with which `test_stored_oracles` compares.

The list of all elements and attributes of MJCF, as MuJoCo prints it, is stored as well.

It needs both, in an environment of their own: ``pip install mujoco pin``, then
``python tests/robots/store_oracles.py``. Nothing of the package is imported.
"""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FILES = {
    "tests/robots/files/afloat.xml": "top",
    "tests/robots/files/hopper.xml": "sole",
    "tests/robots/files/notations.xml": "sole",
    "tests/robots/files/turned_base.xml": "palm",
    "examples/robots/desk_arm.xml": "finger",
    "examples/robots/quadruped.urdf": "LF_foot",
    "tests/robots/files/arm.urdf": "tool",
    "tests/robots/files/biped.urdf": "right_toe",
    "tests/robots/files/gantry.urdf": "hook",
    "tests/robots/files/gripper.urdf": "nail_a",
    "tests/robots/files/mimics.urdf": "nail",
    "tests/robots/files/pendulum.urdf": "tip",
    "tests/robots/files/rover.urdf": "claw",
    "tests/robots/files/two_link.urdf": "tip",
}
ROWS = [2, 0, 1]
"""Rows n, t1, t2 of x, y, z."""


def drawn(size: int, floating: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return velocities, of the base in its own axes, and forces, none on the base."""
    random = np.random.default_rng(size)
    velocities, forces = random.normal(size=size), random.normal(size=size)
    if floating:
        forces[:6] = 0
    return velocities, forces


def entry(by: str, floating: bool, joints: dict[str, float], numbers: dict[str, object]):
    velocities, forces = drawn(len(joints) + 6 * floating, floating)
    return {
        "by": by,
        "floating": floating,
        "joints": joints,
        "velocities": velocities.tolist(),
        "forces": forces.tolist(),
        **{k: np.asarray(v, float).tolist() for k, v in numbers.items()},
    }


def of_mujoco(path: Path, frame: str):
    """Return the entry of an MJCF file, without constraints."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    kinds = [int(k) for k in model.jnt_type]
    floating = 0 in kinds
    names = [model.joint(i).name for i, kind in enumerate(kinds) if kind]
    joints, limits, order = {}, {}, list(range(6 * floating))
    for k, name in enumerate(names):
        joint = model.joint(name)
        low, high = joint.range if joint.limited[0] else (-np.inf, np.inf)
        limits[name] = [None if np.isinf(v) else float(v) for v in (low, high)]
        joints[name] = float(np.clip(0.3 * (-1) ** k + 0.1 * k, low, high))
        data.qpos[joint.qposadr[0]] = joints[name]
        order.append(int(joint.dofadr[0]))
    velocities, forces = drawn(len(order), floating)
    T = np.eye(model.nv)
    if floating:
        turned = np.zeros(9)
        mujoco.mju_quat2Mat(turned, data.qpos[3:7])
        T[:3, :3] = turned.reshape(3, 3)
    T = T[:, order]
    data.qvel[:], data.qfrc_applied[:] = T @ velocities, T @ forces
    mujoco.mj_forward(model, data)
    M, J, dJ = np.zeros((model.nv, model.nv)), np.zeros((3, model.nv)), np.zeros((3, model.nv))
    mujoco.mj_fullM(model, data, M)
    site = data.site(frame)
    body = int(model.site(frame).bodyid[0])
    mujoco.mj_jac(model, data, J, None, site.xpos, body)
    mujoco.mj_jacDot(model, data, dJ, None, site.xpos, body)
    free = data.qfrc_passive + data.qfrc_applied + data.qfrc_actuator - data.qfrc_bias
    b = J @ np.linalg.solve(M, free) + dJ @ data.qvel
    W = J @ np.linalg.solve(M, J.T)
    numbers = {"M": T.T @ M @ T, "W": W[np.ix_(ROWS, ROWS)], "b": b[ROWS]}
    return entry(f"MuJoCo {mujoco.__version__}", floating, joints, numbers) | {"limits": limits}


def of_pinocchio(path: Path, frame: str):
    """Return the entry of a URDF file; joints that mimic follow, and dampers act."""
    model = pin.buildModelFromUrdf(str(path))
    data, position = model.createData(), pin.neutral(model)
    elements = {e.get("name"): e for e in ElementTree.parse(path).iter("joint")}
    free = [n for n in model.names[1:] if elements[n].get("type") == "floating"]
    moving = [n for n in elements if n in model.names and n not in free]
    leaders = [n for n in moving if elements[n].find("mimic") is None]
    joints = {}
    for k, name in enumerate(leaders):
        limit = elements[name].find("limit")
        ends = [-9.0, 9.0]
        if limit is not None and elements[name].get("type") != "continuous":
            ends = [float(limit.get(key, 0)) for key in ("lower", "upper")]
        joints[name] = float(np.clip(0.3 * (-1) ** k + 0.02 * k, *ends))
    size = len(joints) + 6 * len(free)

    def motion(name: str) -> tuple[float, np.ndarray]:
        follows, rate = elements[name].find("mimic"), np.zeros(size)
        if follows is None:
            rate[6 * len(free) + leaders.index(name)] = 1
            return joints[name], rate
        value, rate = motion(follows.get("joint"))
        factor = float(follows.get("multiplier", 1))
        return factor * value + float(follows.get("offset", 0)), factor * rate

    rates, dampers = np.zeros((model.nv, size)), np.zeros(model.nv)
    for name in free:
        start = model.joints[model.getJointId(name)].idx_v
        rates[start : start + 6, :6] = np.eye(6)
    for name in moving:
        joint = model.joints[model.getJointId(name)]
        value, rates[joint.idx_v] = motion(name)
        values = value if joint.nq == 1 else (np.cos(value), np.sin(value))
        position[joint.idx_q : joint.idx_q + joint.nq] = values
        dynamics = elements[name].find("dynamics")
        dampers[joint.idx_v] = 0 if dynamics is None else float(dynamics.get("damping", 0))
    velocities, forces = drawn(size, bool(free))
    velocity = rates @ velocities
    M = pin.crba(model, data, position)
    M = rates.T @ (np.triu(M) + np.triu(M, 1).T) @ rates
    h = rates.T @ (pin.nonLinearEffects(model, data, position, velocity) + dampers * velocity)
    pin.forwardKinematics(model, data, position, velocity, np.zeros(model.nv))
    pin.computeJointJacobians(model, data, position)
    pin.updateFramePlacements(model, data)
    at, world = model.getFrameId(frame), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    J = pin.getFrameJacobian(model, data, at, world).reshape(6, model.nv)[:3] @ rates
    drift = pin.getFrameClassicalAcceleration(model, data, at, world).linear
    W = J @ np.linalg.solve(M, J.T)
    b = J @ np.linalg.solve(M, forces - h) + drift
    numbers = {"M": M, "W": W[np.ix_(ROWS, ROWS)], "b": b[ROWS]}
    return entry(f"Pinocchio {pin.__version__}", bool(free), joints, numbers)


def schema() -> dict[str, list[str]]:
    """Return the attributes of every element of MJCF, by its path as MuJoCo prints it."""
    lists: dict[str, list[str]] = {}
    above: list[str] = []
    path = ""
    for line in mujoco.mj_printSchema(False, False).splitlines():
        depth = (len(line) - len(line.lstrip())) // 3
        head = re.match(r" *(\S+) \([!?*R]\) *(.*)", line)
        if head:
            above = [*above[:depth], head[1]]
            path = "/".join(above[1:]) or above[0]
            lists[path] = head[2].split()
        else:
            lists[path] += line.split()
    return lists


if __name__ == "__main__":
    stored = {}
    for name, frame in FILES.items():
        of = of_mujoco if name.endswith(".xml") else of_pinocchio
        stored[name] = {"frame": frame, **of(ROOT / name, frame)}
    text = json.dumps(stored, indent=1)
    (HERE / "oracles.json").write_text(text + "\n", "utf-8")
    lines = [f"{path}: {' '.join(attributes)}\n" for path, attributes in schema().items()]
    (HERE / "mjcf_schema.txt").write_text("".join(lines), "utf-8")
