"""A body with a quaternion on a curved surface: its formulas end, and follow Newton and Euler."""

from __future__ import annotations

import math
import time
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import painleve_sym as ps
from painleve_sym.at import spatial_numbers
from painleve_sym.at.delassus import argument_symbols
from painleve_sym.mechanics import simplify
from painleve_sym.mechanics.formulas.in_space import LONGEST_JACOBIAN, spatial_sections

ROOT = Path(__file__).parents[2]
BRICK = (ROOT / "examples" / "mechanisms" / "tumbling-brick.toml").read_text()
SIDES = np.array([0.2, 0.1, 0.3])
CORNER = SIDES * [1, -1, -1]
MASS, GRAVITY = 1.0, 9.8
MOMENTS = MASS / 3 * (np.sum(SIDES**2) - SIDES**2)

BEAD = """
[coordinates]
x = { unit = "m", meaning = "first place of a bead" }
y = { unit = "m", meaning = "second place" }
z = { unit = "m", meaning = "height" }
[parameters]
mu = { default = 0.5, unit = "1", meaning = "friction coefficient" }
[[bodies]]
name = "bead"
mass = 1
centre = ["x", "y", "z"]
[[contacts]]
name = "bead"
friction = "mu"
point = ["x", "y", "z"]
surface = "z - x*y/4 - sin(3*t)/9"
"""


def on_surface(tmp_path, surface):
    file = tmp_path / "brick.toml"
    file.write_text(BRICK.replace('friction = "mu"', f'friction = "mu"\nsurface = "{surface}"'))
    return str(file)


def rotation(q):
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def axes_of(gradient, place):
    """Return n, t1 and t2 of a surface at a place, t1 with the direction of x."""
    n = gradient(place) / np.linalg.norm(gradient(place))
    first = np.array([1.0, 0, 0]) - n * n[0]
    first /= np.linalg.norm(first)
    return np.array([n, first, np.cross(n, first)])


def test_normal_with_a_root_is_not_multiplied_out(monkeypatch):
    q = sp.symbols("q_w q_x q_y q_z", real=True)
    x = sp.Symbol("x", real=True)
    place = x + 2 * q[0] * q[1] - 3 * q[2] * q[3] + q[0] ** 2
    form = place / sp.sqrt(place**2 + (q[0] * q[2] - q[3] ** 2) ** 2 + 1)

    def expand(*_):
        raise AssertionError("what is no polynomial is multiplied out")

    monkeypatch.setattr(simplify.sp, "expand", expand)
    assert list(simplify.on_unit_sphere(form, q)) == []
    monkeypatch.undo()
    assert 1 in simplify.on_unit_sphere(sum(s**2 for s in q), q)


def test_long_velocities_are_differentiated_to_the_same_accelerations(tmp_path, monkeypatch):
    file = tmp_path / "bead.toml"
    file.write_text(BEAD)
    mechanism = ps.load_mechanism(str(file))
    symbols = argument_symbols(mechanism)
    functions = []
    for longest in (500, 0):
        monkeypatch.setattr(spatial_numbers, "_LONG", longest)
        functions.append(spatial_numbers.contact_function(mechanism, symbols))
    assert functions[0].n_instructions() != functions[1].n_instructions()
    random = np.random.default_rng(7)
    for _ in range(20):
        point = random.uniform(0.2, 1.5, len(symbols))
        one, other = (np.array(f(point)).ravel() for f in functions)
        np.testing.assert_allclose(other, one, rtol=1e-11, atol=1e-11)


@pytest.mark.slow
def test_brick_on_a_cone_agrees_with_newton_and_euler(tmp_path):
    begun = time.process_time()
    mechanism = ps.load_mechanism(on_surface(tmp_path, "z - 0.6*sqrt(x**2 + y**2)"))

    def gradient(p):
        radius = math.hypot(p[0], p[1])
        return np.array([-0.6 * p[0] / radius, -0.6 * p[1] / radius, 1.0])

    q = np.array([0.3, -0.5, 0.7, 0.2])
    q /= np.linalg.norm(q)
    omega = np.array([0.7, -1.1, 0.4])
    R, place = rotation(q), np.array([0.4, -0.7, 0.6 * math.hypot(0.4, 0.7)])
    arm = R @ CORNER
    n, *tangents = axes_of(gradient, place)
    v = 0.8 * tangents[0] - 0.3 * tangents[1]  # of the corner: it slides
    centre_speed = v - np.cross(R @ omega, arm)
    state = dict(zip("xyz", place - arm, strict=True))
    state |= dict(zip(("q_w", "q_x", "q_y", "q_z"), q, strict=True))
    state |= dict(zip(("x_dot", "y_dot", "z_dot"), centre_speed, strict=True))
    state |= {f"omega_{k + 1}": omega[k] for k in range(3)}
    answer = ps.classify(mechanism, state)
    # It had no end: five minutes of processor time are what any derivation may take.
    assert time.process_time() - begun < 60

    spin = np.array([np.cross(arm, axis) for axis in (n, *tangents)]) @ R  # along body axes
    rows = np.array([n, *tangents])
    W = rows @ rows.T / MASS + spin @ np.diag(1 / MOMENTS) @ spin.T
    np.testing.assert_allclose(answer.problem.W, W, rtol=1e-10, atol=1e-12)

    def velocity(t):
        """Return the velocity of the corner along the axes at its place, in free flight."""
        rate = np.cross(MOMENTS * omega, omega) / MOMENTS
        # To second order in the time, of which the differences take the first.
        turn = R @ np.array(
            np.eye(3)
            + t * cross_matrix(omega)
            + t * t / 2 * (cross_matrix(omega) @ cross_matrix(omega) + cross_matrix(rate))
        )
        w = turn @ (omega + t * rate)
        fallen = place - arm + t * centre_speed - [0, 0, GRAVITY * t * t / 2]
        at = turn @ CORNER
        speed = centre_speed - [0, 0, GRAVITY * t] + np.cross(w, at)
        return axes_of(gradient, fallen + at) @ speed

    h = 1e-5
    b = (velocity(h) - velocity(-h)) / (2 * h)
    np.testing.assert_allclose(answer.problem.b, b, rtol=1e-7, atol=1e-6)


def cross_matrix(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


@pytest.mark.slow
def test_contact_with_a_long_jacobian_says_so_in_derive(tmp_path):
    mechanism = ps.load_mechanism(on_surface(tmp_path, "x**2 + y**2 + z**2 - 4"))
    *_, section = spatial_sections(mechanism)
    count = sp.count_ops(mechanism.contact.J)
    assert count > LONGEST_JACOBIAN and f"has {count} operations" in section.note
    assert [f.name for f in section.formulas] == ["gap"]
