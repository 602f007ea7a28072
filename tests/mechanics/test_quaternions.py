"""Bodies oriented by unit quaternions: against Newton and Euler, and against the same in angles."""

from __future__ import annotations

import dataclasses
import json
import math
from functools import cache
from itertools import product

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import painleve_sym as ps
from painleve_sym.at.delassus import Delassus
from painleve_sym.at.positive import positive_function
from painleve_sym.cli import main
from painleve_sym.codegen.evaluate import numbers as evaluated
from painleve_sym.mechanics import DomainBound, Load
from painleve_sym.mechanics.toml.mechanism_file import load_mechanism, mechanism_from_text
from tests.support.vanishing import vanishes

BRICK = "examples/mechanisms/tumbling-brick.toml"
PARTS, OMEGA = ("q_w", "q_x", "q_y", "q_z"), ("omega_1", "omega_2", "omega_3")
ENTRIES = [f"J_{k}{n}" for k in (1, 2, 3) for n in (1, 2, 3) if n >= k]
DIAGONAL = [f"J_{k}{k}" for k in (1, 2, 3)]
START = {"J_11": 2.0, "J_22": 3.0, "J_33": 4.0, "J_12": 0.1, "J_13": -0.2, "J_23": 0.3}


def parameter(name, default, unit, lower=-math.inf):
    return ps.Parameter(name, default, unit, name, lower, lower_closed=lower != 0)


@cache
def free_body(of_the_point=False):
    """Return a body with a full tensor and a point; coordinates of its centre or of the point."""
    place = [ps.Coordinate(name, name, "m") for name in "xyz"]
    q = ps.Quaternion("q", "orientation of the body")
    m, g = parameter("m", 1.0, "kg", 0.0), parameter("g", 9.8, "m/s^2")
    mu = ps.Parameter("mu", 0.7, "1", "friction", 0.0)
    moment = parameter("M_1", 0.0, "N m")
    J = {name: parameter(name, START[name], "kg m^2") for name in ENTRIES}
    arm = [parameter(f"r_{k}", 0.1 * k, "m") for k in (1, 2, 3)]
    tensor = [[J[f"J_{min(k, n)}{max(k, n)}"].symbol for n in (1, 2, 3)] for k in (1, 2, 3)]
    r, at = sp.Matrix([p.symbol for p in arm]), sp.Matrix([c.symbol for c in place])
    centre = at - q.matrix * r if of_the_point else at
    body = ps.SpatialBody(m.symbol, tuple(centre), tensor, q, "body")
    system = ps.LagrangianSystem.of_bodies(
        "free body",
        (*place, *q.coordinates),
        (m, g, mu, moment, *J.values(), *arm),
        [body],
        gravity=g.symbol,
        generalized_forces={"omega_1": moment.symbol},
    )
    point = tuple(at) if of_the_point else body.point(tuple(r))
    contact = ps.Contact.in_space("A", system, point, mu.symbol)
    domain = tuple(DomainBound(*bound) for bound in body.bounds)
    return ps.Mechanism("free body", "free body", "test", system, (contact,), domain)


def numbers(mechanism, state, parameters=None):
    return Delassus.of(mechanism).at(mechanism.at(state, parameters).values)


def cross(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def by_newton_and_euler(m, tensor, R, omega, r, g, moment):
    """Return W and b, rows z, x, y, and the velocity of the point r from the centre at rest.

    The tensor, ω, r and the moment are given along the axes of the body.
    """
    inverse = np.linalg.inv(tensor)
    W = R @ (np.eye(3) / m - cross(r) @ inverse @ cross(r)) @ R.T
    turning = inverse @ (moment - np.cross(omega, tensor @ omega))
    b = R @ (np.cross(turning, r) + np.cross(omega, np.cross(omega, r))) - np.array([0, 0, g])
    rows = [2, 0, 1]
    return W[np.ix_(rows, rows)], b[rows], (R @ np.cross(omega, r))[rows]


def random_body(rng):
    """Return the parameters and the tensor of a random cloud of mass points."""
    points = rng.normal(size=(6, 3)) * rng.uniform(0.1, 2.0, 3)
    points -= points.mean(axis=0)
    m = rng.uniform(0.1, 5.0)
    tensor = m / 6 * sum(p @ p * np.eye(3) - np.outer(p, p) for p in points)
    r = rng.normal(size=3)
    given = {
        f"J_{k}{n}": float(tensor[k - 1, n - 1]) for k, n in product((1, 2, 3), repeat=2) if n >= k
    }
    given |= {"m": m, "g": rng.uniform(1, 20), "M_1": rng.normal()}
    return given | {f"r_{k}": float(v) for k, v in enumerate(r, 1)}, tensor, r


def turned(rotation):
    """Return the state of an orientation, by SciPy, which has the scalar part last."""
    x, y, z, w = rotation.as_quat()
    return dict(zip(PARTS, map(float, (w, x, y, z)), strict=True))


def random_motion(rng):
    """Return an orientation and an angular velocity as a state."""
    omega = dict(zip(OMEGA, rng.normal(size=3).tolist(), strict=True))
    return turned(Rotation.random(random_state=rng)) | omega


@pytest.mark.parametrize("of_the_point", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_free_body_agrees_with_newton_and_euler(of_the_point):
    mechanism, rng = free_body(of_the_point), np.random.default_rng(7)
    for _ in range(15):
        given, tensor, r = random_body(rng)
        rotation, omega = Rotation.random(random_state=rng), rng.normal(size=3)
        speed = rng.normal(size=3)
        state = turned(rotation) | dict(zip(OMEGA, omega, strict=True))
        state |= dict(zip(("x_dot", "y_dot", "z_dot"), speed, strict=True))
        at = numbers(mechanism, state, given)
        moment = np.array([given["M_1"], 0, 0])
        W, b, v = by_newton_and_euler(
            given["m"], tensor, rotation.as_matrix(), omega, r, given["g"], moment
        )
        v = speed[[2, 0, 1]] + (0 if of_the_point else v)
        assert np.allclose(at.W, W, rtol=1e-11, atol=1e-12 * np.abs(W).max())
        assert np.allclose(at.b, b, rtol=1e-10, atol=1e-11 * np.abs(b).max())
        assert np.allclose(at.v, v, rtol=1e-12, atol=1e-12)


def test_rates_of_the_quaternion_are_those_of_a_turning_body():
    """q̇ = N(q) ω against finite rotations R(t + h) = R(t) exp(h ω)."""
    q, rng, h = ps.Quaternion("q", "orientation"), np.random.default_rng(8), 1e-6
    for _ in range(5):
        rotation, omega = Rotation.random(random_state=rng), rng.normal(size=3)
        values = turned(rotation) | dict(zip(OMEGA, omega, strict=True))
        rates = evaluated([c.rate for c in q.coordinates], values)
        ahead, behind = (rotation * Rotation.from_rotvec(s * h * omega) for s in (1, -1))
        own = np.array(list(turned(rotation).values()))
        ends = [np.array(list(turned(end).values())) for end in (ahead, behind)]
        ends = [end * np.sign(end @ own) for end in ends]
        assert np.allclose(rates, (ends[0] - ends[1]) / (2 * h), atol=1e-8)
        matrix = evaluated(list(q.matrix), values).reshape(3, 3)
        assert np.allclose(matrix, rotation.as_matrix(), atol=1e-14)


# ---- the same in angles ----

TURNS = {"rod-3d": ("ZYX", (1, -1, 1)), "top": ("ZXZ", (1, 1, 1)), "brick": ("ZYX", (1, 1, 1))}
ANGLES = {name: ("psi", "theta", "phi") for name in TURNS}


def body_of(name, p):
    """Return tensor and arm of the touching point of a named mechanism, by its parameters."""
    if name == "rod-3d":
        J = p["m"] * p["l"] ** 2 / p["alpha"]
        return np.diag([p["J_3"], J, J]), np.array([-p["l"], 0, 0])
    if name == "top":
        return np.diag([p["J_1"], p["J_1"], p["J_3"]]), np.array([0, 0, -p["l"]])
    a, b, c = (p[side] for side in "abc")
    moments = p["m"] / 3 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    return np.diag(moments), np.array([a, -b, -c])


def in_quaternions(name, state, p):
    """Return state and parameters of the free body in the state of a named mechanism in angles."""
    axes, signs = TURNS[name]
    angles = [k * state[n] for n, k in zip(ANGLES[name], signs, strict=True)]
    rates = [k * state[f"{n}_dot"] for n, k in zip(ANGLES[name], signs, strict=True)]
    rotation = Rotation.from_euler(axes, angles)
    omega = np.zeros(3)
    for k in range(3):  # a turn's axis, along the axes that the later turns make
        after = (
            Rotation.from_euler(axes[k + 1 :], angles[k + 1 :]) if k < 2 else Rotation.identity()
        )
        omega += rates[k] * (after.inv().apply(np.eye(3)["XYZ".index(axes[k])])).reshape(3)
    tensor, r = body_of(name, p)
    end = next(n for n in state if n.startswith("x_"))[2:]
    at = np.array([state[f"{n}_{end}"] for n in "xyz"])
    speed = np.array([state[f"{n}_{end}_dot"] for n in "xyz"])
    centre = at - rotation.apply(r)
    moved = speed - rotation.apply(np.cross(omega, r))
    own = turned(rotation) | dict(zip(OMEGA, map(float, omega), strict=True))
    own |= dict(zip("xyz", map(float, centre), strict=True))
    own |= {f"{n}_dot": float(v) for n, v in zip("xyz", moved, strict=True)}
    given = {f"J_{k}{k}": float(tensor[k - 1, k - 1]) for k in (1, 2, 3)}
    given |= dict.fromkeys(set(ENTRIES) - set(DIAGONAL), 0.0)
    given |= {n: p[n] for n in ("m", "g", "mu")}
    return own, given | {f"r_{k}": float(v) for k, v in enumerate(r, 1)}


@pytest.mark.slow
@settings(max_examples=25)
@given(
    name=st.sampled_from(sorted(TURNS)),
    seed=st.integers(0, 2**32 - 1),
    mu=st.floats(0.0, 3.0),
)
def test_angles_and_a_quaternion_are_one_physical_state(name, seed, mu):
    """W, b, velocities, A, B, cases and jumps of a rod, a top and a brick, to round-off."""
    named, rng = ps.model(name), np.random.default_rng(seed)
    state = {n: rng.uniform(-2, 2) for n in named.state_names}
    state["theta"] = rng.uniform(0.2, 1.3)
    end = next(n for n in state if n.startswith("x_"))[2:]
    state |= {f"z_{end}": 0.0, f"z_{end}_dot": 0.0}
    p = named.parameters | {"mu": mu}
    own, given = in_quaternions(name, state, p)
    one, other = numbers(named, state, {"mu": mu}), numbers(free_body(), own, given)
    assert np.allclose(other.W, one.W, rtol=1e-9, atol=1e-11 * np.abs(one.W).max())
    assert np.allclose(other.b, one.b, rtol=1e-9, atol=1e-11 * np.abs(one.b).max())
    assert np.allclose(other.v, one.v, atol=1e-11)
    angles = ps.classify(named, state, parameters={"mu": mu})
    body = ps.classify(free_body(), own, parameters=given, close="z,z_dot")
    scale = np.abs(one.b).max()
    assert pytest.approx(angles.A, rel=1e-8, abs=1e-9 * one.W[0, 0]) == body.A
    assert pytest.approx(angles.B, rel=1e-9, abs=1e-9 * scale) == body.B
    if abs(angles.A) > 1e-6 * one.W[0, 0] and abs(angles.B) > 1e-6 * scale:
        assert body.case is angles.case
        for a, b in zip(angles.solutions, body.solutions, strict=True):
            size = np.abs(a.force).max() or 1.0
            assert np.allclose(a.force, b.force, atol=1e-6 * size)
    # The same blow from above.
    state[f"z_{end}_dot"] = -1.0
    own, given = in_quaternions(name, state, p)
    jumps = [
        ps.evaluate_jump(m, "energetic", s, parameters=v)
        for m, s, v in ((named, state, {"mu": mu}), (free_body(), own, given))
    ]
    size = jumps[0].kinetic_energy
    assert jumps[1].kinetic_energy == pytest.approx(size, rel=1e-10)
    assert jumps[1].energy_change == pytest.approx(jumps[0].energy_change, abs=1e-8 * size)
    for a, b in zip(jumps[0].phases, jumps[1].phases, strict=True):
        assert a.name == b.name
        assert a.normal_impulse == pytest.approx(b.normal_impulse, rel=1e-6, abs=1e-9)


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1))
def test_minus_q_is_the_same_orientation_to_the_last_bit(seed):
    mechanism, rng = free_body(), np.random.default_rng(seed)
    state = random_motion(rng)
    one = numbers(mechanism, state)
    other = numbers(mechanism, state | {name: -state[name] for name in PARTS})
    for a, b in zip(one, other, strict=True):
        assert np.array_equal(a, b)


@settings(max_examples=20)
@given(seed=st.integers(0, 2**32 - 1), angle=st.floats(-math.pi, math.pi))
def test_turning_the_scene_about_the_normal_changes_nothing(seed, angle):
    mechanism, rng = free_body(), np.random.default_rng(seed)
    rotation, omega = Rotation.random(random_state=rng), rng.normal(size=3)
    about = Rotation.from_euler("z", angle)
    speed = np.array([*rng.normal(size=2), 0.0])
    answers = []
    for R, v in ((rotation, speed), (about * rotation, about.apply(speed))):
        state = turned(R) | dict(zip(OMEGA, omega, strict=True))
        state |= dict(zip(("x_dot", "y_dot", "z_dot"), v, strict=True))
        answers.append(ps.classify(mechanism, state, close="z,z_dot"))
    one, other = answers
    scale = float(np.abs(one.problem.W).max())
    assert pytest.approx(one.A, rel=1e-9, abs=1e-11 * scale) == other.A
    assert pytest.approx(one.B, rel=1e-9, abs=1e-9) == other.B
    (own,), (again,) = one.coefficients, other.coefficients
    assert again.mu_P == pytest.approx(own.mu_P, rel=1e-7)
    assert again.least_over_normals == pytest.approx(own.least_over_normals, rel=1e-7)


def test_units_change_nothing():
    """Another metre, kilogram and second: W by 1/kg, b by m/s²; a quaternion has no unit."""
    mechanism, rng = free_body(), np.random.default_rng(9)
    given, _, _ = random_body(rng)
    state = random_motion(rng)
    metre, kilogram, second = 1000.0, 7.0, 60.0
    size = {
        "m": metre,
        "kg": kilogram,
        "s": second,
        "1": 1.0,
        "rad": 1.0,
        "N": kilogram * metre / second**2,
    }
    units = mechanism.units

    def in_other_units(values):
        changed = {}
        for name, value in values.items():
            factor, parts = 1.0, units[name].replace("/", " / ").split()
            sign = 1
            for part in parts:
                if part == "/":
                    sign = -1
                    continue
                base, _, power = part.partition("^")
                factor *= size[base] ** (sign * int(power or 1))
            changed[name] = value * factor
        return changed

    one = numbers(mechanism, state, given)
    other = numbers(mechanism, in_other_units(state), in_other_units(given))
    assert np.allclose(other.W * kilogram, one.W, rtol=1e-12)
    assert np.allclose(other.b * second**2 / metre, one.b, rtol=1e-12)


@pytest.mark.slow
def test_where_angles_lock_a_quaternion_answers():
    """The brick at a pitch of 90° has no rates of its angles; the quaternion is one of others."""
    with pytest.raises(
        ps.InputError, match=r"gimbal lock.*theta.*or orient the body by a quaternion"
    ):
        ps.classify("brick", {"theta": math.pi / 2, "x_C_dot": -1.0})
    answer = ps.classify(load_mechanism(BRICK))
    with pytest.warns(ps.PainleveWarning, match="about 5 digits of W and b"):
        near = ps.classify("brick", {"theta": math.pi / 2 - 1e-5, "x_C_dot": -1.0})
    assert pytest.approx(answer.A, abs=1e-3) == near.A
    assert pytest.approx(37 / 13) == answer.A  # 1/m + x²/J_2 + y²/J_1 of the corner, by hand


# ---- files and formulas ----


@pytest.mark.slow
def test_formulas_of_the_brick_are_those_of_a_textbook():
    """M of constants, Euler's equations, and W = 1/m + the arms' part."""
    mechanism = load_mechanism(BRICK)
    system = mechanism.system
    m, a, b, c = sp.symbols("m a b c", positive=True)
    J = [m * (b**2 + c**2) / 3, m * (a**2 + c**2) / 3, m * (a**2 + b**2) / 3]
    assert (system.mass_matrix - sp.diag(m, m, m, *J)).applyfunc(sp.simplify).is_zero_matrix
    w = sp.symbols("omega_1:4", real=True)
    euler = [(J[1] - J[2]) * w[1] * w[2], (J[2] - J[0]) * w[2] * w[0], (J[0] - J[1]) * w[0] * w[1]]
    assert all(vanishes(h - e) for h, e in zip(system.bias_force[3:], euler, strict=True))
    assert system.N.shape == (7, 6) and system.N[:3, :3] == sp.eye(3)
    q = sp.Matrix(system.q[3:])
    assert sp.expand((q.T * system.N[3:, 3:])[0]) == 0
    sections = {f.name: f.value for section in ps.closed_forms(mechanism) for f in section.formulas}
    at = numbers(mechanism, mechanism.start)
    W = evaluated(list(sections["W"]), mechanism.at().values).reshape(3, 3)
    assert np.allclose(W, at.W, rtol=1e-12, atol=1e-13)
    assert sections["N"] == system.N


def test_a_file_is_the_same_as_python():
    mechanism, rng = load_mechanism(BRICK), np.random.default_rng(10)
    p = mechanism.parameters
    tensor, r = body_of("brick", p)
    for _ in range(5):
        rotation, omega = Rotation.random(random_state=rng), rng.normal(size=3)
        at = numbers(mechanism, turned(rotation) | dict(zip(OMEGA, omega, strict=True)))
        W, b, _ = by_newton_and_euler(p["m"], tensor, rotation.as_matrix(), omega, r, p["g"], 0)
        assert np.allclose(at.W, W, rtol=1e-11, atol=1e-12)
        assert np.allclose(at.b, b, rtol=1e-10, atol=1e-11)


@pytest.mark.slow
def test_commands_take_it_with_the_keys_of_angles(capsys):
    assert main(["classify", BRICK, "--json"]) == 0
    own = json.loads(capsys.readouterr().out)
    assert main(["classify", "brick", "--json"]) == 0
    assert set(own) == set(json.loads(capsys.readouterr().out))
    assert main(["map", BRICK, "--over", "omega_1,slip_direction", "--points", "10", "--json"]) == 0
    assert sum(json.loads(capsys.readouterr().out)["counts"].values()) == 100
    assert (
        main(["jump", BRICK, "--state", "z=0.2,q_w=0.7071068,q_y=0.7071068,z_dot=-1", "--json"])
        == 0
    )
    assert set(OMEGA) < set(json.loads(capsys.readouterr().out)["final"]["velocity"])
    assert main(["models", BRICK, "--json"]) == 0
    [data] = json.loads(capsys.readouterr().out)["models"]
    assert [v["name"] for v in data["velocities"]] == ["x_dot", "y_dot", "z_dot", *OMEGA]
    assert data["coordinates"][3]["velocity"] is None
    assert main(["simulate", BRICK, "--law", "rigid", "--t-end", "0.1"]) == 2
    assert "got contacts in space, need contacts in the plane" in capsys.readouterr().err


def test_a_part_of_the_angular_velocity_closes_the_normal_velocity():
    state = {"z": 0.2, "q_w": math.sqrt(0.5), "q_y": math.sqrt(0.5), "z_dot": -1.0}
    answer = ps.classify(BRICK, state, close="omega_2")
    assert answer.state["omega_2"] == pytest.approx(1.0 / 0.3)


# ---- bad input ----


def test_a_quaternion_is_of_unit_norm():
    mechanism = load_mechanism(BRICK)
    state = mechanism.at({"q_w": 0.6000001, "q_x": 0.8}).state
    assert math.hypot(*(state[n] for n in PARTS)) == pytest.approx(1.0, abs=1e-15)
    assert state["q_x"] / state["q_w"] == pytest.approx(0.8 / 0.6000001, rel=1e-15)
    assert [mechanism.at({"z": 0.3}).state[n] for n in PARTS] == [1.0, 0.0, 0.0, 0.0]
    with pytest.raises(ps.InputError) as caught:
        mechanism.at({"q_w": 3.0, "q_z": 4.0})
    assert "= (3, 0, 0, 4) has the norm 5, need 1" in str(caught.value)
    assert "Fix: give q_w=0.6,q_x=0,q_y=0,q_z=0.8" in str(caught.value)
    for off in (3e-6, -3e-6, 5e-3, -5e-3):
        with pytest.raises(ps.InputError, match=r"has the norm .*, need 1 within 1e-06"):
            mechanism.at({"q_w": 0.6 * (1 + off), "q_x": 0.8 * (1 + off)})
        near = mechanism.at({"q_w": 0.6 * (1 + off / 1e4), "q_x": 0.8 * (1 + off / 1e4)}).state
        assert (near["q_w"], near["q_x"]) == pytest.approx((0.6, 0.8), rel=1e-15)
    with pytest.raises(ps.InputError, match=r"has the norm 0, need 1.* Fix: give q_w=1,q_x=0"):
        mechanism.at({"q_w": 0.0})
    with pytest.raises(ps.InputError, match=r"need finite|finite number"):
        mechanism.at({"q_w": math.nan})


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('orientation = "q"', 'orientation = "p"', r"unknown quaternion 'p'.* \[quaternions.p\]"),
        ('orientation = "q"', "orientation = 3", "need turns such as"),
        ("q_w = 0.7071067811865476", "q_w = 0.8", "start: the quaternion .* has the norm 1.067"),
        ("[quaternions]", "[quaternions]\nr = {}", "name 'omega_1' is declared twice.*velocity"),
        ("[quaternions]", '[quaternions]\nr = { rate = "w" }', "unknown key 'rate'"),
        ("[quaternions]", '[quaternions]\n"1r" = { velocity = "w" }', "name '1r_w' is not usable"),
        ('"m*(b**2 + c**2)/3"', '"m*(b**2 + c**2)"', "largest is more than the other two together"),
        ("[start]", "[forces]\nq_w = 1\n[start]", "unknown coordinate 'q_w'"),
    ],
)
def test_a_file_with_a_quaternion_says_what_is_wrong(old, new, message):
    with open(BRICK, encoding="utf-8") as file:
        text = file.read()
    assert text.count(old) == 1
    with pytest.raises(ps.ModelError, match=message):
        mechanism_from_text(text.replace(old, new))


def test_a_part_of_a_quaternion_is_no_axis_and_closes_nothing():
    mechanism = load_mechanism(BRICK)
    with pytest.raises(
        ps.InputError, match="q_x is a part of the quaternion q, whose norm stays 1"
    ):
        ps.region_map(mechanism, ("q_x", "mu"), points=10)
    with pytest.raises(ps.InputError, match=r"certify .* q_x is a part of the quaternion q, whose"):
        positive_function(mechanism, {"q_x": (0.0, 0.1)}, {})
    with pytest.raises(ps.InputError, match="need 1"):
        positive_function(mechanism, {"mu": (0.1, 0.2)}, {"q_w": 3.0})
    with pytest.raises(
        ps.InputError, match=r"q_x is a part of the quaternion q.* name x or y or z"
    ):
        ps.classify(mechanism, close="q_x")
    with pytest.raises(ps.InputError, match=r"does not depend on x. Fix: name one of z."):
        ps.classify(mechanism, close="x")


def test_a_quaternion_comes_whole():
    q, m = ps.Quaternion("q", "orientation"), ps.Parameter("m", 1.0, "kg", "mass", 0.0)
    body = ps.SpatialBody(m.symbol, (0, 0, 0), (1, 1, 1), q)
    with pytest.raises(ps.ModelError, match=r"quaternion 'q' lacks q_z. Fix: give"):
        ps.LagrangianSystem.of_bodies("part", q.coordinates[:3], (m,), [body])


def test_two_quaternions_have_velocities_of_their_own():
    q, r = (ps.Quaternion(name, "orientation") for name in "qr")
    m = ps.Parameter("m", 1.0, "kg", "mass", 0.0, lower_closed=False)
    bodies = [ps.SpatialBody(m.symbol, (0, 0, 0), (1, 1, 1), turned) for turned in (q, r)]
    coordinates = (*q.coordinates, *r.coordinates)
    with pytest.raises(ps.ModelError, match="name 'omega_1' is declared twice"):
        ps.LagrangianSystem.of_bodies("two", coordinates, (m,), bodies)


def test_two_bodies_turn_by_themselves():
    """Rates of one do not depend on the other; a load acts on a point of the second."""
    q, r = ps.Quaternion("q", "first"), ps.Quaternion("r", "second", velocity="spin")
    m = ps.Parameter("m", 1.0, "kg", "mass", 0.0, lower_closed=False)
    F = ps.Parameter("F", 1.0, "N", "force along x on a point of the second body")
    one, two = (ps.SpatialBody(m.symbol, (0, 0, 0), (1, 2, 2.5), turned) for turned in (q, r))
    force = Load.force(two.point((0, 1, 0)), (F.symbol, 0, 0))
    system = ps.LagrangianSystem.of_bodies(
        "two", (*q.coordinates, *r.coordinates), (m, F), [one, two], loads=[force]
    )
    omega, spin = np.array([0.3, -0.5, 0.7]), np.array([1.0, 0.2, -0.4])
    rotation = Rotation.from_rotvec([0.4, -0.2, 0.9])
    values = turned(rotation) | {n.replace("q_", "r_"): v for n, v in turned(rotation).items()}
    values |= dict(zip(OMEGA, omega, strict=True)) | {"F": 3.0, "m": 1.0}
    values |= {f"spin_{k}": v for k, v in enumerate(spin, 1)}
    h, J = evaluated(list(system.bias_force), values), np.diag([1, 2, 2.5])
    pull = np.cross([0, 1, 0], rotation.inv().apply([3.0, 0, 0]))
    assert np.allclose(h[:3], -np.cross(omega, J @ omega), atol=1e-14)
    assert np.allclose(h[3:], pull - np.cross(spin, J @ spin), atol=1e-14)
    assert np.allclose(
        evaluated(list(system.mass_matrix), values), np.diag([1, 2, 2.5] * 2).ravel()
    )


def test_a_planar_contact_takes_no_quaternion():
    q, m = ps.Quaternion("q", "orientation"), ps.Parameter("m", 1.0, "kg", "mass", 0.0)
    mu = ps.Parameter("mu", 0.5, "1", "friction", 0.0)
    body = ps.SpatialBody(m.symbol, (0, 0, 0), (1, 1, 1), q)
    system = ps.LagrangianSystem.of_bodies("mixed", q.coordinates, (m, mu), [body])
    slip = q.velocities[0].symbol
    contact = ps.Contact("A", system, q.coordinates[1].symbol, slip, mu.symbol)
    with pytest.raises(ps.ModelError, match="a quaternion and a contact in the plane"):
        ps.Mechanism("mixed", "mixed", "test", system, (contact,))


def test_a_tensor_is_judged_at_the_values_of_its_parameters():
    with pytest.raises(ps.InputError, match=r"top: .* more than the other two together"):
        ps.classify("top", parameters={"J_3": 1e-3})
    assert ps.classify("top", parameters={"J_1": 2e-5}).A > 0  # a flat body
    with pytest.raises(ps.InputError, match="body: no principal moment of inertia is negative"):
        ps.classify(free_body(), {}, parameters={"J_12": 2.6})
    assert ps.classify(free_body(), {}, parameters={"J_12": 0.5}, close="z").problem.complete


@pytest.mark.parametrize(
    ("name", "state", "parameters", "idle"),
    [
        ("slider-3d", {"theta": math.pi / 2}, {"h": 1.0}, "psi_dot"),
        (
            "two-link-arm-3d",
            {"theta_1": -math.pi / 2, "theta_2": -math.pi / 2},
            {"h": 1.0},
            "psi_dot",
        ),
        pytest.param(
            "examples/mechanisms/rod-on-ball.toml",
            {"theta": math.pi / 2, "z": 2.5},
            {},
            "psi_dot",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_angles_that_move_no_mass_are_named(name, state, parameters, idle):
    message = f"got .*theta.*where {idle} has no kinetic energy.*singular.* by a quaternion"
    with pytest.raises(ps.InputError, match=message):
        ps.classify(name, state, parameters=parameters)
    with pytest.raises(ps.InputError, match=message):
        ps.evaluate_jump(name, "energetic", state, parameters=parameters)


def test_angles_that_lock_together_are_named_without_a_bound():
    """A top of one's own, whose domain says nothing of its angles."""
    top = dataclasses.replace(ps.model("top"), domain=())
    message = r"got .*theta = 0.0, where psi_dot and phi_dot together have no kinetic energy"
    with pytest.raises(ps.InputError, match=message):
        ps.classify(top, {"theta": 0.0, "x_T_dot": 1.0})
    assert ps.classify(top, {"theta": 1e-5, "x_T_dot": 1.0}).A > 0


BALL = """
[coordinates]
x = { unit = "m" }
y = { unit = "m" }
z = { unit = "m" }
[parameters]
mu = { default = 0.5, unit = "1" }
k = { default = 1.0, unit = "1" }
[[bodies]]
mass = 1
centre = ["x", "y", "z"]
[[contacts]]
name = "A"
friction = "mu"
point = ["x", "y", "z"]
"""


@pytest.mark.parametrize(
    ("surface", "state", "parameters", "message"),
    [
        ('surface = "x**2 + y**2 + z**2 - 1"', {}, {}, "normal of its surface vanishes; got x = 0"),
        ('surface = "x**2 + y**2 + z**2 - 1"', {"x": 1.0}, {}, "'along' is normal.*; got x = 1"),
        ('normal = [0, 0, "k"]', {}, {"k": 0.0}, "normal of its surface vanishes; got .*k = 0"),
    ],
)
def test_a_surface_without_normal_or_tangent_is_named(surface, state, parameters, message):
    mechanism = mechanism_from_text(BALL + surface)
    with pytest.raises(ps.InputError, match=message):
        ps.classify(mechanism, state, parameters=parameters)
