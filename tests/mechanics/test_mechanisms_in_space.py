"""Mechanisms in space: against Newton and Euler, the planar rod, and closed forms of the rod."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp

import painleve_sym as ps
from painleve_sym.at.closing import closed_state
from painleve_sym.at.delassus import Delassus
from painleve_sym.cli import main
from painleve_sym.mechanics.models import SPATIAL_MODELS
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from tests.cli.cli_helpers import only_contact
from tests.support.vanishing import vanishes

ROD = {"theta": 0.7, "psi": 0.4, "phi": -1.1, "theta_dot": 1.5, "psi_dot": 0.8, "phi_dot": 30.0}


def numbers(mechanism, state, parameters=None):
    return Delassus.of(mechanism).at(mechanism.at(state, parameters).values)


# ---- one rigid body by Newton and Euler ----


def cross(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def turn(axis, angle):
    c, s = math.cos(angle), math.sin(angle)
    k = "xyz".index(axis)
    R = np.eye(3)
    i, j = (k + 1) % 3, (k + 2) % 3
    R[i, i] = R[j, j] = c
    R[i, j], R[j, i] = -s, s
    return R


def body_at(turns):
    """Return orientation and angular velocity in space of turns (axis, angle, rate)."""
    R, omega = np.eye(3), np.zeros(3)
    for axis, angle, rate in turns:
        omega = omega + R[:, "xyz".index(axis)] * rate
        R = R @ turn(axis, angle)
    return R, omega


def contact_of_body(m, J, R, omega, arm, g):
    """Return W and b of the point at `arm` from the mass centre, rows z, x, y."""
    tensor = R @ np.diag(J) @ R.T
    inverse = np.linalg.inv(tensor)
    W = np.eye(3) / m - cross(arm) @ inverse @ cross(arm)
    turning = -inverse @ np.cross(omega, tensor @ omega)
    b = np.array([0, 0, -g]) + np.cross(turning, arm) + np.cross(omega, np.cross(omega, arm))
    rows = [2, 0, 1]
    return W[np.ix_(rows, rows)], b[rows]


def rod_by_hand(s, p):
    turns = [("z", "psi", 1), ("y", "theta", -1), ("x", "phi", 1)]
    R, omega = body_at([(a, k * s[q], k * s[f"{q}_dot"]) for a, q, k in turns])
    J = p["m"] * p["l"] ** 2 / p["alpha"]
    return contact_of_body(p["m"], [p["J_3"], J, J], R, omega, -p["l"] * R[:, 0], p["g"])


def top_by_hand(s, p):
    turns = [("z", "psi"), ("x", "theta"), ("z", "phi")]
    R, omega = body_at([(a, s[q], s[f"{q}_dot"]) for a, q in turns])
    J = [p["J_1"], p["J_1"], p["J_3"]]
    return contact_of_body(p["m"], J, R, omega, -p["l"] * R[:, 2], p["g"])


def brick_by_hand(s, p):
    turns = [("z", "psi"), ("y", "theta"), ("x", "phi")]
    R, omega = body_at([(a, s[q], s[f"{q}_dot"]) for a, q in turns])
    a, b, c = (p[side] ** 2 for side in "abc")
    J = p["m"] / 3 * np.array([b + c, a + c, a + b])
    return contact_of_body(p["m"], J, R, omega, R @ np.array([p["a"], -p["b"], -p["c"]]), p["g"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "by_hand"), [("rod-3d", rod_by_hand), ("top", top_by_hand), ("brick", brick_by_hand)]
)
def test_one_body_agrees_with_newton_and_euler(name, by_hand):
    mechanism, rng = ps.model(name), np.random.default_rng(3)
    for _ in range(20):
        state = {n: rng.uniform(-1.2, 1.2) for n in mechanism.state_names}
        state["theta"] = rng.uniform(0.2, 1.3)
        parameters = {n: v * rng.uniform(0.5, 2) for n, v in mechanism.parameters.items()}
        place = mechanism.at(state, parameters)
        at = numbers(mechanism, state, parameters)
        W, b = by_hand(place.state, place.parameters)
        assert np.allclose(at.W, W, rtol=1e-10, atol=1e-12 * np.abs(W).max())
        assert np.allclose(at.b, b, rtol=1e-10, atol=1e-11 * np.abs(b).max())


@pytest.mark.parametrize("name", SPATIAL_MODELS)
def test_velocities_of_the_contact_are_the_rates_of_its_place(name):
    """Gap rate, slip velocities and the bias of the acceleration, by differences in time."""
    mechanism, rng = ps.model(name), np.random.default_rng(4)
    system, contact = mechanism.system, mechanism.contact
    speeds = (contact.gap_rate, *contact.slip_velocities)
    J = sp.Matrix.vstack(contact.J_N, contact.J_T)
    symbols = [*system.q, *system.q_dot, *(p.symbol for p in system.parameters)]
    evaluate = sp.lambdify(symbols, [contact.gap, *speeds, *contact.biases, *J])
    q, v, a = (rng.uniform(0.3, 1.0, size=len(system.q)) for _ in range(3))
    fixed = list(mechanism.parameters.values())

    def at(t):
        place = q + v * t + a * t**2 / 2
        return np.array(evaluate(*place, *(v + a * t), *fixed), dtype=float)

    step = 1e-5
    here, rate = at(0.0), (at(step) - at(-step)) / (2 * step)
    assert rate[0] == pytest.approx(here[1], rel=1e-7, abs=1e-8)
    jacobian = here[7:].reshape(3, -1)
    assert np.allclose(rate[1:4], here[4:7] + jacobian @ a, rtol=1e-6, atol=1e-7)


# That of the brick is too long to be derived; Newton and Euler judge it above.
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name == "slider-3d" else pytest.mark.slow)
        for name in SPATIAL_MODELS
        if name != "brick"
    ],
)
def test_numbers_are_those_of_the_closed_forms(name):
    from painleve_sym.codegen.evaluate import numbers as evaluated
    from painleve_sym.mechanics.coefficients import ContactCoefficients

    mechanism = ps.model(name)
    coefficients = ContactCoefficients(mechanism.contact)
    W, b = coefficients.W, coefficients.b
    rng = np.random.default_rng(5)
    state = {n: rng.uniform(0.2, 1.0) for n in mechanism.state_names}
    at, place = numbers(mechanism, state), mechanism.at(state)
    own = evaluated([*W, *b], place.values)
    assert np.allclose(own[:9].reshape(3, 3), at.W, rtol=1e-10, atol=1e-12)
    assert np.allclose(own[9:], at.b, rtol=1e-10, atol=1e-10)


def test_motion_functions_agree_with_each_other():
    mechanism = ps.model("rod-3d")
    place = mechanism.at({**ROD, "x_A_dot": -1.0})
    at, moves = Delassus.of(mechanism).whole_at(place.values)
    assert np.allclose(moves.J @ moves.D, at.W)
    assert np.allclose(moves.drive_speeds, 0)
    velocity = [place.state[n] for n in mechanism.outline.velocity_names]
    assert np.allclose(moves.J @ velocity, at.v)
    kinetic = [float(v) for v in moves.kinetic_energy]
    values = place.values
    expected = mechanism.system.kinetic_energy.subs(
        {s: values[s.name] for s in mechanism.system.kinetic_energy.free_symbols}
    )
    assert kinetic == [pytest.approx(float(expected))]


# ---- the rod ----


def test_rod_has_the_closed_forms_of_its_docstring():
    """A and B of the rod in any direction of slip, with azimuth and spin."""
    mechanism, rng = ps.model("rod-3d"), np.random.default_rng(6)
    for _ in range(20):
        state = {n: rng.uniform(-2, 2) for n in mechanism.state_names}
        state |= {"theta": rng.uniform(0.1, 1.4), "z_A": 0.0, "z_A_dot": 0.0}
        given = {"m": 2.0, "l": 0.7, "alpha": 2.2, "J_3": 0.05, "mu": 1.7}
        (answer,) = ps.classify(mechanism, state, parameters=given).coefficients
        m, l, alpha, J_3, mu = given.values()
        theta, psi, spin = state["theta"], state["psi_dot"], state["phi_dot"]
        s, c = math.sin(theta), math.cos(theta)
        slip = math.atan2(state["y_A_dot"], state["x_A_dot"])
        beta = slip - state["psi"] - math.pi
        A = (1 + alpha * c**2 - alpha * mu * s * c * math.cos(beta)) / m
        about = J_3 * alpha / (m * l**2) * (spin + psi * s)
        B = -9.8 + l * s * (state["theta_dot"] ** 2 + (psi * c) ** 2) - l * about * psi * c**2
        assert pytest.approx(A, rel=1e-11, abs=1e-12) == answer.A
        assert pytest.approx(B, rel=1e-11) == answer.B
        assert answer.mu_P == pytest.approx((1 + alpha * c**2) / (alpha * s * c), rel=1e-11)
        least = 2 * math.sqrt(1 + alpha) / alpha
        assert answer.least_over_normals == pytest.approx(least, rel=1e-9)


def test_rod_has_the_numbers_of_an_independent_computation():
    """m A at β = 0, half angle and μ_P at θ = 1, μ = 1.4, by SciPy outside of this package."""
    state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    (answer,) = ps.classify("rod-3d", state).coefficients
    assert pytest.approx(-0.0337448511546, abs=1e-9) == answer.A
    assert answer.sector.half_angle == pytest.approx(0.188277219521, abs=1e-9)
    assert answer.mu_P == pytest.approx(1.37525939613, abs=1e-9)


@pytest.mark.parametrize("slip", [-1.0, 0.0, 1.0])
@pytest.mark.parametrize("theta_dot", [0.0, 1.0, 5.0])
def test_in_the_plane_it_is_the_planar_rod(theta_dot, slip):
    for theta in (0.3, 1.0, 1.2):
        state = {"theta": theta, "theta_dot": theta_dot, "x_A_dot": slip}
        space, plane = ps.classify("rod-3d", state), ps.classify("rod", state)
        assert space.case is plane.case
        assert pytest.approx(plane.B, rel=1e-14) == space.B
        if slip:
            assert pytest.approx(plane.A, rel=1e-13, abs=1e-15) == space.A
        inside = [s for s in space.solutions if abs(s.force[2]) < 1e-12]
        assert len(inside) == len(plane.solutions) == len(space.solutions)
        for one, other in zip(inside, plane.solutions, strict=True):
            assert one.force[0] == pytest.approx(other.normal_force, rel=1e-12)
            assert one.force[1] == pytest.approx(other.tangential_force, rel=1e-12)


@pytest.mark.slow
def test_derived_rod_has_the_planar_rod_as_its_limit():
    def formulas(name):
        sections = ps.closed_forms(ps.model(name))
        return {f.name: f.value for section in sections for f in section.formulas}

    space, plane = formulas("rod-3d"), formulas("rod")
    flat = {sp.Symbol("phi_slip", real=True): sp.pi, sp.Symbol("psi", real=True): 0}
    flat |= {sp.Symbol("psi_dot", real=True): 0, sp.Symbol("alpha", positive=True): 3}
    flat |= {s: 0 for s in space["B"].free_symbols if s.name in ("psi", "psi_dot")}
    flat |= {s: 3 for s in space["A"].free_symbols if s.name == "alpha"}
    flat |= {s: 0 for s in space["A"].free_symbols if s.name == "psi"}
    flat |= {s: sp.pi for s in space["A"].free_symbols if s.name == "phi_slip"}
    assert vanishes(space["A"].subs(flat) - plane["A_neg"])
    assert vanishes(space["B"].subs(flat) - plane["B"])
    W = space["W"].subs(flat)
    assert vanishes(W[0, 0] - plane["W_nn"])
    assert vanishes(W[0, 1] - plane["W_nt"])
    assert vanishes(W[1, 1] - plane["W_tt"])
    assert vanishes(W[0, 2]) and vanishes(W[1, 2])


def test_turning_the_scene_about_the_normal_changes_nothing():
    angle = 0.9
    c, s = math.cos(angle), math.sin(angle)
    slip = np.array([-1.0, 0.3])
    turned = np.array([[c, -s], [s, c]]) @ slip
    rod = ps.models.rod_3d(mu=2.0)
    first = ps.classify(rod, ROD | dict(zip(("x_A_dot", "y_A_dot"), slip, strict=True)))
    state = ROD | {"psi": ROD["psi"] + angle}
    second = ps.classify(rod, state | dict(zip(("x_A_dot", "y_A_dot"), turned, strict=True)))
    assert second.case is first.case
    (one,), (other,) = first.coefficients, second.coefficients
    assert pytest.approx(one.A, rel=1e-12) == other.A
    assert other.mu_P == pytest.approx(one.mu_P, rel=1e-12)
    e_1, e_2 = one.sector.direction
    assert other.sector.direction == pytest.approx((c * e_1 - s * e_2, s * e_1 + c * e_2))


# ---- maps ----


def test_map_in_the_plane_is_that_of_the_planar_rod():
    options = {"points": 40, "ranges": {"theta": (0.05, 1.5), "theta_dot": (-6, 6)}}
    space = ps.region_map("rod-3d", ("theta", "theta_dot"), **options)
    plane = ps.region_map("rod", ("theta", "theta_dot"), **options)
    assert np.allclose(space.A, plane.A, rtol=1e-12, atol=1e-13)
    assert np.array_equal(space.case, plane.case)
    assert np.allclose(space.crossings, plane.crossings, atol=1e-12)
    assert np.array_equal(space.stick_feasible, plane.stick_feasible)
    for own in (space, plane):
        assert own.thresholds["least_over_normals"] == pytest.approx(4 / 3)


def test_border_of_the_sector_over_the_direction_of_slip():
    """A = 0 at cos β = μ_P(θ)/μ."""
    ranges = {"theta": (0.8, 1.4), "slip_direction": (2.5, 3.8)}
    regions = ps.region_map("rod-3d", ("theta", "slip_direction"), points=40, ranges=ranges)
    ends = regions.curves["A"].reshape(-1, 2)
    assert len(ends) > 40
    critical = (4 + np.tan(ends[:, 0]) ** 2) / (3 * np.tan(ends[:, 0]))
    assert np.allclose(np.cos(ends[:, 1] - np.pi), critical / 1.4, atol=1e-12)


def test_border_of_lift_off_over_the_azimuthal_velocity():
    """B = 0 at l sinθ (θ̇² + ψ̇² cos²θ) = g without spin about the axis."""
    regions = ps.region_map(
        "rod-3d",
        ("theta", "psi_dot"),
        points=40,
        ranges={"theta": (0.2, 1.3), "psi_dot": (0.0, 8.0)},
        state={"theta_dot": 1.0, "x_A_dot": -1.0},
        parameters={"J_3": 1e-9},
    )
    theta, rate = regions.curves["B"].reshape(-1, 2).T
    assert len(theta) > 40
    pull = np.sin(theta) * (1 + (rate * np.cos(theta)) ** 2)
    assert np.allclose(pull, 9.8, atol=1e-6)


def test_a_map_closes_the_contact_where_it_is_asked_to():
    options = {"points": 10, "ranges": {"h": (0.3, 0.9)}, "close": "theta"}
    regions = ps.region_map("slider-3d", ("h", "slip_direction"), **options)
    assert len(regions.curves["A"]) > 0
    heights, angles = regions.values
    slips = {"x_dot": math.cos(angles[3]), "y_dot": math.sin(angles[3])}
    for height, A in zip(heights, regions.A[:, 3], strict=True):
        state = {"theta": 0.9, **slips}
        answer = ps.classify("slider-3d", state, parameters={"h": height}, close="theta")
        assert abs(answer.A - A) < 1e-9
    # Along A = 0, by classify at the ends of its pieces.
    for height, angle in regions.curves["A"].reshape(-1, 2)[::5]:
        state = {"theta": 0.9, "x_dot": math.cos(angle), "y_dot": math.sin(angle)}
        answer = ps.classify("slider-3d", state, parameters={"h": height}, close="theta")
        assert abs(answer.A) < 1e-9


# ---- files ----

BODY = """
gravity = "g"
[coordinates]
x = {{ unit = "m" }}
y = {{ unit = "m" }}
z = {{ unit = "m" }}
theta = {{ unit = "rad" }}
psi = {{ unit = "rad" }}
phi = {{ unit = "rad" }}
[parameters]
m = {{ default = 1.0, unit = "kg", positive = true }}
l = {{ default = 1.0, unit = "m", positive = true }}
alpha = {{ default = 3.0, unit = "1", positive = true }}
J_3 = {{ default = 0.001, unit = "kg m^2", positive = true }}
mu = {{ default = 1.4, unit = "1" }}
g = {{ default = 9.8, unit = "m/s^2", lower = 0 }}
[[bodies]]
name = "rod"
mass = "m"
centre = ["x", "y", "z"]
inertia = {inertia}
orientation = {turns}
[[contacts]]
name = "A"
friction = "mu"
{contact}
"""
WHOLE = {
    "inertia": '["J_3", "m*l**2/alpha", "m*l**2/alpha"]',
    "turns": '[["z", "psi"], ["y", "-theta"], ["x", "phi"]]',
    "contact": 'point = { body = "rod", at = ["-l", 0, 0] }',
}


def from_text(**changes):
    return mechanism_from_text(BODY.format(**WHOLE | changes))


def test_a_file_has_the_numbers_of_the_named_rod():
    """Other coordinates, of the mass centre: the same contact."""
    mechanism, named = from_text(), ps.model("rod-3d")
    at = numbers(mechanism, ROD)
    other = numbers(named, ROD)
    assert np.allclose(at.W, other.W, rtol=1e-12, atol=1e-12)
    assert np.allclose(at.b, other.b, rtol=1e-11)


def test_a_full_tensor_is_that_of_its_principal_axes():
    tensor = '[["J_3", 0, 0], [0, "m*l**2/alpha", 0], [0, 0, "m*l**2/alpha"]]'
    at, other = (numbers(m, ROD) for m in (from_text(inertia=tensor), from_text()))
    assert np.array_equal(at.W, other.W)


@pytest.mark.slow
def test_a_ball_is_a_plane_to_first_order():
    """On top of a ball W is that of the plane, b that of the plane and v²/R."""
    state = ROD | {"x_dot": 0.0}
    plane = from_text()
    ball = from_text(
        contact='point = { body = "rod", at = ["-l", 0, 0] }\n'
        'surface = "sqrt(x**2 + y**2 + (z + 5)**2) - 5"'
    )
    c, s = math.cos(0.7), math.sin(0.7)
    place = {"x": c * math.cos(0.4), "y": c * math.sin(0.4), "z": s}
    flat, round_ = (numbers(m, state | place) for m in (plane, ball))
    assert np.allclose(round_.W, flat.W, atol=1e-12)
    speed = np.hypot(*flat.slip_velocity[0])
    assert round_.b[0] - flat.b[0] == pytest.approx(speed**2 / 5, rel=1e-9)
    assert np.allclose(round_.slip_velocity, flat.slip_velocity, atol=1e-12)


@pytest.mark.slow
def test_an_end_closes_on_a_ball_that_is_given_by_its_square():
    """Second derivatives of its gap are long: they are not multiplied out."""
    contact = 'point = { body = "rod", at = ["-l", 0, 0] }\nalong = [0, 0, 1]\n'
    mechanism = from_text(contact=contact + 'surface = "x**2 + y**2 + z**2 - 1"')
    place = closed_state(mechanism, mechanism.at({"x": 1.5}).state, mechanism.parameters, "x")
    assert place["x"] == pytest.approx(2.0, rel=1e-12)


def test_a_tilted_plane_is_the_tilted_gravity():
    slope = 0.3
    n = f"[{-math.sin(slope)}, 0, {math.cos(slope)}]"
    contact = f'point = {{ body = "rod", at = ["-l", 0, 0] }}\nnormal = {n}'
    mechanism = from_text(contact=contact)
    at, flat = numbers(mechanism, ROD), numbers(from_text(), ROD)
    R = np.array([[math.cos(slope), -math.sin(slope), 0], [math.sin(slope), math.cos(slope), 0],
                  [0, 0, 1]])  # fmt: skip
    assert np.allclose(at.W, R @ flat.W @ R.T, atol=1e-12)
    assert np.allclose(at.b, R @ flat.b, atol=1e-11)


# ---- bad input ----


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"inertia": "[1, 1, 3]"}, "largest is more than the other two together"),
        ({"inertia": "[1, 1, -1]"}, "need none below 0"),
        ({"inertia": "[[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]"}, "not a symmetric tensor"),
        ({"inertia": '"m"'}, "three principal moments or three rows"),
        ({"turns": '[["u", "psi"]]'}, "need 'x', 'y' or 'z'"),
        ({"turns": '[["z", "psi"], ["z", "theta"]]'}, "follow each other"),
        ({"turns": '["z"]'}, "need turns such as"),
        ({"contact": 'point = ["x", "y", "z"]\nnormal = [0, 0, 0]'}, "normal of the surface vanis"),
        ({"contact": 'point = ["x", "y", "z"]\nalong = [0, 0, 1]'}, "normal to the surface"),
        ({"contact": 'point = ["x", "y", "z"]\nsurface = "mu"'}, "normal of the surface vanishes"),
        ({"contact": 'point = ["x", "y", "z"]\nslope = 0.1'}, "does not belong to a contact in sp"),
        ({"contact": 'point = { body = "rad", at = [0, 0, 0] }'}, "Did you mean 'rod'"),
        ({"contact": 'point = ["x", "y"]'}, "got .* need 3 formulas"),
    ],
)
def test_a_file_in_space_says_what_is_wrong(changes, message):
    with pytest.raises(ps.ModelError, match=message):
        from_text(**changes)


def test_gimbal_lock_names_the_angles_and_another_order():
    with pytest.raises(ps.InputError, match="gimbal lock: the turns z, y, x by psi, -theta, phi"):
        ps.classify("rod-3d", {"theta": math.pi / 2, "x_A_dot": -1.0})
    with pytest.raises(
        ps.InputError, match=r"gimbal lock.* turn about other axes, such as z, y, x"
    ):
        ps.classify("top", {"theta": 0.0, "x_T_dot": -1.0})


def test_bodies_in_the_plane_and_in_space_do_not_mix():
    x = ps.Coordinate("x", "place", "m")
    m = ps.Parameter("m", 1.0, "kg", "mass", 0.0, lower_closed=False)
    bodies = [ps.Body(m.symbol, (x.symbol, 0)), ps.SpatialBody(m.symbol, (x.symbol, 0, 0))]
    with pytest.raises(ps.ModelError, match="in the plane and in space"):
        ps.LagrangianSystem.of_bodies("both", (x,), (m,), bodies)


@pytest.mark.parametrize(
    "words",
    [
        ["simulate", "rod-3d", "--law", "rigid", "--t-end", "0.1"],
        ["simulate", "rod-3d", "--law", "hertz", "--t-end", "0.1"],
        ["critical", "rod-3d"],
        ["automaton", "rod-3d", "--law", "rigid"],
        ["export", "rod-3d", "--law", "rigid", "--out", "folder"],
        ["explore", "rod-3d", "--out", "page.html"],
        # What is missing besides does not come first.
        ["simulate", "rod-3d"],
        ["export", "rod-3d", "--out", "folder"],
        ["animate", "rod-3d", "--law", "rigid", "--t-end", "0.1", "--out", "film.gif"],
    ],
)
def test_commands_that_do_not_take_space_say_so(words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    error = capsys.readouterr().err
    assert "got contacts in space, need contacts in the plane" in error
    assert "certify, classify, contrast, derive, jump, map" in " ".join(error.split())
    assert "Traceback" not in error and not list(tmp_path.iterdir())


def test_jump_with_a_law_in_space_names_what_has_compliant_contacts_there(capsys):
    assert main(["jump", "rod-3d", "--set", "mu=1.5", "--law", "hertz"]) == 2
    error = capsys.readouterr().err
    assert "the jump at finite stiffness is planar so far. Fix: leave the law out" in error


@pytest.mark.parametrize(
    "question",
    [
        lambda rod: ps.Simulator(rod, ps.law("rigid")),
        lambda rod: ps.simulate_batch(rod, "rigid", {"theta": [1.0, 1.1]}, t_end=0.1),
        lambda rod: ps.critical_force(rod, "hertz", {"theta": 1.0}),
        lambda rod: rod.coefficients,
    ],
)
def test_questions_that_do_not_take_space_say_so(question):
    with pytest.raises(ps.InputError, match="got contacts in space, need contacts in the plane"):
        question(ps.model("rod-3d"))


TWO = (
    BODY.format(**WHOLE)
    + """
[[contacts]]
name = "B"
friction = "mu"
point = { body = "rod", at = ["l", 0, 0] }
"""
)


def test_several_contacts_in_space_share_the_load(capsys):
    """A level rod on both ends: half of its weight on each, whether it slides or rests."""
    mechanism = mechanism_from_text(TWO, name="two-ends")
    sliding = ps.classify(mechanism, {"x_dot": 1.0, "psi_dot": 0.2}, parameters={"mu": 0.4})
    assert sliding.case is ps.ContactCase.UNIQUE and sliding.problem.complete
    [solution] = sliding.solutions
    for force, slip in zip(solution.contact_forces, sliding.problem.slips, strict=True):
        e = np.array(slip) / np.linalg.norm(slip)
        assert force[0] == pytest.approx(4.9, rel=1e-12)
        assert np.allclose(force[1:], -0.4 * force[0] * e, rtol=1e-12)
    resting = ps.classify(mechanism, {"z": 0.0})
    assert resting.case is ps.ContactCase.HYPERSTATIC and not resting.problem.complete
    [solution] = resting.solutions
    assert solution.isolated is False
    assert sum(f[0] for f in solution.contact_forces) == pytest.approx(9.8)
    data = resting.to_dict()
    assert "not guaranteed" in data["guarantee"]
    assert set(data["solutions"][0]["contacts"]) == {"A", "B"}
    with pytest.raises(ps.InputError, match="got 2 contacts, need one here"):
        ps.region_map(mechanism, ("mu", "psi"))
    alone = ps.classify(mechanism.only("A"), {"x_dot": 1.0})
    assert alone.problem.W.shape == (3, 3)


def test_classify_prints_and_writes_the_keys(capsys):
    state = "theta=1,theta_dot=5,x_A_dot=-1,y_A_dot=0.05"
    assert main(["classify", "rod-3d", "--state", state]) == 0
    text = capsys.readouterr().out
    assert "A < 0 for slip within 0.188277 rad of (-1, 0)" in text
    assert "indeterminate" in text and "least mu_P" in text
    assert main(["classify", "rod-3d", "--state", state, "--json"]) == 0
    import json

    data = json.loads(capsys.readouterr().out)
    assert {"case", "solutions"} <= set(data)
    own, solutions = only_contact(data)
    assert {"A", "B", "mu_P", "sector", "least_over_normals"} <= set(own)
    assert set(own["sector"]) == {"direction", "half_angle"}
    assert {"mode", "direction", "normal_force", "tangential_acceleration"} <= set(solutions[0])
    assert len(solutions) == 2 and len(solutions[1]["tangential_force"]) == 2


def test_derived_formulas_of_the_rod_have_independent_numbers():
    """The hodograph from β = 1.2 with v = 1, by SciPy outside of this package, to 1e-9."""
    from derivations.generated import rod_in_space as formulas

    own = formulas.C(theta=1.0, alpha=3.0, mu=1.4, beta=1.2, v=1.0)
    assert own == pytest.approx(4.593596233357, abs=1e-9)
    assert formulas.A(1.0, 1.0, 3.0, 1.4, 0.0) == pytest.approx(-0.0337448511546, abs=1e-12)
    assert formulas.psi_dot_m(1.0, 9.8) == pytest.approx(math.sqrt(1.5 * math.sqrt(3) * 9.8))
