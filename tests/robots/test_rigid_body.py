"""Rigid-body dynamics of robots against Pinocchio, with a fixed and with a floating base."""

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from painleve_sym.robots.rigid_body import RigidBodies
from painleve_sym.robots.robot_file import read_robot

FILES = Path(__file__).parent / "files"
DOG = Path(__file__).parents[2] / "examples" / "robots" / "quadruped.urdf"
ROBOTS = ("pendulum", "two_link", "gantry", "arm", "quadruped", "biped")
FRAMES = {
    "pendulum": "tip",
    "two_link": "tip",
    "gantry": "hook",
    "arm": "tool",
    "quadruped": "LF_foot",
    "biped": "right_toe",
}


def path_of(name):
    return DOG if name == "quadruped" else FILES / f"{name}.urdf"


def robot(name, base):
    return read_robot(path_of(name), floating=base == "floating")


def drawn(tree, seed=0):
    """Return joint values within the limits, and velocities."""
    random = np.random.default_rng(seed)
    q = {j.name: random.uniform(max(j.lower, -3), min(j.upper, 3)) for j in tree.joints.values()}
    size = len(q) + 6 * tree.floating
    return q, random.normal(size=size)


def numbers(tree, q, frame, velocity):
    """Return M and J of the robot as it is, and as its parts that are fixed are joined."""
    both = []
    for one in (tree, tree.merged):
        x = ca.SX.sym("q", len(q))
        bodies = RigidBodies(one, dict(zip(q, ca.vertsplit(x), strict=True)))
        body, R, p = bodies.place(frame)
        linear, angular = bodies.jacobian(body, p)
        g = ca.SX(ca.DM(tree.gravity))
        entries = [bodies.mass_matrix(), linear, angular, p, R, bodies.bias(ca.SX(velocity), g)]
        entries += bodies.drift(body, p, ca.SX(velocity), g)
        values = ca.Function("f", [x], [ca.densify(e) for e in entries])(list(q.values()))
        both.append([np.array(v) for v in values])
    for a, b in zip(*both, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-12 * max(1, np.abs(b).max()))
    return both[1]


def close(a, b):
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-12 * max(1.0, np.abs(b).max()))


def mobility(M, J):
    return J @ np.linalg.solve(M, J.T)


@pytest.mark.parametrize("base", ["floating", "fixed"])
@pytest.mark.parametrize("name", ROBOTS)
def test_mass_jacobian_bias_and_drift_are_those_of_pinocchio(name, base):
    pin = pytest.importorskip("pinocchio", reason="needs the group robots (pin)")
    path = str(path_of(name))
    joint = [pin.JointModelFreeFlyer()] if base == "floating" else []
    model = pin.buildModelFromUrdf(path, *joint)
    data = model.createData()
    tree = robot(name, base)
    q, v = drawn(tree)
    M, J, angular, _, _, h, drift, turning = numbers(tree, q, FRAMES[name], v)
    # Pinocchio sorts branches by name, and a continuous joint has cosine and sine.
    position, velocity = pin.neutral(model), np.zeros(model.nv)
    order = list(range(6)) if base == "floating" else []
    velocity[: len(order)] = v[: len(order)]
    for k, (joint_name, value) in enumerate(q.items(), len(order)):
        own = model.joints[model.getJointId(joint_name)]
        position[own.idx_q : own.idx_q + own.nq] = (
            value if own.nq == 1 else (np.cos(value), np.sin(value))
        )
        order.append(own.idx_v)
        velocity[own.idx_v] = v[k]
    frame = model.getFrameId(FRAMES[name])
    world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    mass = pin.crba(model, data, position)
    mass = np.triu(mass) + np.triu(mass, 1).T
    pin.computeJointJacobians(model, data, position)
    pin.updateFramePlacements(model, data)
    jacobian = pin.getFrameJacobian(model, data, frame, world).reshape(6, model.nv)
    close(M, mass[np.ix_(order, order)])
    close(np.vstack([J, angular]), jacobian[:, order])
    close(mobility(M, J), mobility(mass, jacobian[:3]))
    close(h[:, 0], pin.nonLinearEffects(model, data, position, velocity)[order])
    pin.forwardKinematics(model, data, position, velocity, np.zeros(model.nv))
    own = pin.getFrameClassicalAcceleration(model, data, frame, world)
    close(np.vstack([drift, turning])[:, 0], np.concatenate([own.linear, own.angular]))
