"""Readers of robot files against numbers of MuJoCo and Pinocchio, which are stored.

`store_oracles` writes them; its files have every notation of URDF and MJCF that is read.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.robots.rigid_body import RigidBodies
from painleve_sym.robots.tree import rotation_quaternion

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
STORED = json.loads((HERE / "oracles.json").read_text("utf-8"))


def computed(tree, stored):
    """Return M, W and b of a tree at the state of a stored entry, rows n, t1, t2."""
    tree = tree.merged
    bodies = RigidBodies(tree, {name: ca.SX(q) for name, q in stored["joints"].items()})
    R = rotation_quaternion(tree.orientation, "base")
    velocity, gravity = ca.SX(stored["velocities"]), ca.SX(R.T @ tree.gravity)
    body, _, point = bodies.place(stored["frame"])
    J, _ = bodies.jacobian(body, point)
    drift, _ = bodies.drift(body, point, velocity, gravity)
    entries = [bodies.mass_matrix(), J, bodies.bias(velocity, gravity), drift]
    function = ca.Function("f", [], [ca.densify(e) for e in entries])
    M, J, h, drift = (np.array(value) for value in function.call([]))
    J, drift = (R @ J)[[2, 0, 1]], (R @ drift)[[2, 0, 1], 0]
    b = J @ np.linalg.solve(M, np.array(stored["forces"]) - h[:, 0]) + drift
    return M, J @ np.linalg.solve(M, J.T), b


@pytest.mark.parametrize("name", STORED)
def test_robot_has_the_stored_mass_mobility_and_acceleration(name):
    stored = STORED[name]
    tree = ps.robot(ROOT / name, floating=stored["floating"]).tree
    assert list(tree.joints) == list(stored["joints"])
    for value, key in zip(computed(tree, stored), ("M", "W", "b"), strict=True):
        expected = np.array(stored[key])
        tolerance = 1e-9 * max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(value, expected, rtol=0, atol=tolerance, err_msg=key)
    for joint, (low, high) in stored.get("limits", {}).items():
        ends = (-math.inf if low is None else low, math.inf if high is None else high)
        assert (tree.joints[joint].lower, tree.joints[joint].upper) == pytest.approx(ends)


@pytest.mark.parametrize("name", STORED)
def test_contact_of_a_robot_has_the_stored_mobility(name):
    stored = STORED[name]
    robot = ps.robot(ROOT / name, floating=stored["floating"])
    contact = robot.contact(stored["frame"], joints=stored["joints"])
    expected = np.array(stored["W"])
    tolerance = 1e-9 * max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(contact.mobility(), expected, rtol=0, atol=tolerance)
