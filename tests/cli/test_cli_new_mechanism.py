"""A mechanism that is nowhere in the package goes through every command from its file alone.

A compound pendulum with a torsion spring and a drive hangs from a block on a level spring; its tip
slides with friction on a belt that runs up a slope. Independent numbers come from Newton and Euler
by hand.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from tests.cli.cli_helpers import only_contact, run, run_json

TEXT = """
name = "swing"
title = "driven pendulum on a sprung block, its tip on a sloping belt"
source = "a test"
gravity = "g"

[coordinates]
x = { unit = "m", meaning = "place of the block along its guide" }
phi = { unit = "rad", meaning = "angle of the pendulum from hanging down, counter-clockwise" }

[parameters]
M = { default = 0.8, unit = "kg", meaning = "mass of the block", positive = true }
m = { default = 1.5, unit = "kg", meaning = "mass of the pendulum", positive = true }
J = { default = 0.04, unit = "kg m^2", meaning = "inertia about the mass centre", positive = true }
c = { default = 0.25, unit = "m", meaning = "joint to mass centre", positive = true }
L = { default = 0.6, unit = "m", meaning = "joint to tip", positive = true }
k_x = { default = 200.0, unit = "N/m", meaning = "stiffness of the level spring", lower = 0 }
k_phi = { default = 30.0, unit = "N m/rad", meaning = "stiffness of the joint", lower = 0 }
phi_0 = { default = -0.4, unit = "rad", meaning = "angle of the relaxed joint" }
d_x = { default = 3.0, unit = "N s/m", meaning = "damping of the guide", lower = 0 }
tau = { default = 4.0, unit = "N m", meaning = "drive of the joint" }
h = { default = 0.5, unit = "m", meaning = "height of the guide over the belt's foot" }
beta = { default = 0.15, unit = "rad", meaning = "angle of the belt" }
u = { default = 0.7, unit = "m/s", meaning = "speed of the belt, uphill" }
g = { default = 9.81, unit = "m/s^2", meaning = "gravity", lower = 0 }
mu = { default = 0.5, unit = "1", meaning = "friction coefficient" }

[definitions]
x_T = "x + L*sin(phi)"
y_T = "h - L*cos(phi)"

[[bodies]]
mass = "M"
centre = ["x", "h"]

[[bodies]]
mass = "m"
inertia = "J"
angle = "phi"
centre = ["x + c*sin(phi)", "h - c*cos(phi)"]

[[springs]]
extension = "x"
stiffness = "k_x"
damping = "d_x"

[[springs]]
extension = "phi - phi_0"
stiffness = "k_phi"

[[loads]]
angle = "phi"
torque = "tau"

[[contacts]]
name = "tip"
point = ["x_T", "y_T"]
slope = "beta"
surface_speed = "u"
friction = "mu"
"""
P = {
    "M": 0.8, "m": 1.5, "J": 0.04, "c": 0.25, "L": 0.6, "k_x": 200.0, "k_phi": 30.0,
    "phi_0": -0.4, "d_x": 3.0, "tau": 4.0, "h": 0.5, "beta": 0.15, "u": 0.7, "g": 9.81, "mu": 0.5,
}  # fmt: skip
PHI = 0.5
# The gap along the normal of the belt is 0.
X = (P["h"] - P["L"] * math.cos(PHI)) / math.tan(P["beta"]) - P["L"] * math.sin(PHI)
STATE = f"x={X!r},phi={PHI!r}"


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("new") / "swing.toml"
    path.write_text(TEXT, "utf-8")
    return path


def _by_hand():
    """Return W and b of the tip at rest: two equations of motion for x and φ, written out."""
    s, co = math.sin(PHI), math.cos(PHI)
    mass = np.array(
        [
            [P["M"] + P["m"], P["m"] * P["c"] * co],
            [P["m"] * P["c"] * co, P["J"] + P["m"] * P["c"] ** 2],
        ]
    )
    force = np.array(
        [-P["k_x"] * X, -P["k_phi"] * (PHI - P["phi_0"]) + P["tau"] - P["m"] * P["g"] * P["c"] * s]
    )
    tip = np.array([[1.0, P["L"] * co], [0.0, P["L"] * s]])
    sin, cos = math.sin(P["beta"]), math.cos(P["beta"])
    rows = np.array([[-sin, cos], [cos, sin]]) @ tip
    inverse = np.linalg.inv(mass)
    return rows @ inverse @ rows.T, rows @ inverse @ force, rows, mass


@pytest.mark.slow
def test_classify_agrees_with_newton_and_euler(capsys, file):
    data = run_json(capsys, "classify", file, "--state", STATE)
    W, b, _, _ = _by_hand()
    # v_t = −u < 0: the belt drags the tip uphill with +μ F_n.
    A = W[0, 0] + P["mu"] * W[0, 1]
    own, solutions = only_contact(data)
    assert own["A"] == pytest.approx(A, rel=1e-12)
    assert own["B"] == pytest.approx(b[0], rel=1e-9)
    (slip,) = [s for s in solutions if s["mode"] == "slip_neg"]
    assert slip["normal_force"] == pytest.approx(-b[0] / A, rel=1e-9)


@pytest.mark.slow
def test_derive_gives_the_same_coefficients_as_formulas(capsys, file):
    code, out, err = run(capsys, "derive", file, "--format", "json")
    assert (code, err) == (0, "")
    for word in ("zoo", '"nan', "Piecewise"):
        assert word not in out
    formulas = json.loads(out)["formulas"]
    W, _, _, _ = _by_hand()
    at = {**P, "x": X, "phi": PHI, "math": math, "abs": abs}
    for name, value in (("W_nn", W[0, 0]), ("W_nt", W[0, 1]), ("W_tt", W[1, 1])):
        assert eval(formulas[name]["python"], at) == pytest.approx(value, rel=1e-10)
    least = 2 * math.sqrt(np.linalg.det(W)) / math.sqrt(np.trace(W) ** 2 - 4 * np.linalg.det(W))
    form = formulas["mu_critical_any_direction"]["python"]
    assert eval(form, at) == pytest.approx(least, rel=1e-9)


@pytest.mark.slow
def test_jump_agrees_with_the_impulses_by_hand(capsys, file):
    """A plastic impact that ends in slip or stick: v⁺ = v + W Λ in the contact's axes."""
    state = f"{STATE},phi_dot=-3"
    data = run_json(
        capsys, "jump", file, "--state", state, "--restitution", "0", "--rule", "newton"
    )
    W, _, rows, mass = _by_hand()
    before = rows @ np.array([0.0, -3.0]) - np.array([0.0, P["u"]])
    assert before[0] < 0
    parts = [[p["normal_impulse"], *p["tangential_impulse"]] for p in data["phases"]]
    impulse = np.sum(parts, axis=0)
    after = before + W @ impulse
    assert after[0] == pytest.approx(0, abs=1e-12)
    assert abs(impulse[1]) <= P["mu"] * impulse[0] * (1 + 1e-12)
    velocity = np.array([0.0, -3.0]) + np.linalg.solve(mass, rows.T @ impulse)
    computed = [data["final"]["velocity"][n] for n in ("x_dot", "phi_dot")]
    assert computed == pytest.approx(velocity, rel=1e-10)


@pytest.mark.slow
def test_map_counts_the_inconsistent_points_of_the_coefficients_by_hand(capsys, file):
    where = ("--over", "tau,mu", "--range", "tau=-6:6,mu=0.1:4", "--points", "5")
    data = run_json(capsys, "map", file, *where, "--state", STATE)
    W, b, rows, mass = _by_hand()
    drive = (rows @ np.linalg.solve(mass, np.array([0.0, 1.0])))[0]
    expected = 0
    for tau in np.linspace(-6, 6, 5):
        for mu in np.linspace(0.1, 4, 5):
            expected += W[0, 0] + mu * W[0, 1] < 0 and b[0] + drive * (tau - P["tau"]) < 0
    assert sum(data["counts"].values()) == 25
    assert data["counts"].get("inconsistent", 0) == expected
    assert data["mechanism"] == "swing"
