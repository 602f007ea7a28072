"""Impacts in space of a contact with two freedoms: W of rank two ties slip and approach."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import painleve_sym as ps
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.problem.impact.one_contact import ImpactEnd, solve_impact
from painleve_sym.problem.impact.spatial import impacts_in_space
from painleve_sym.problem.modes import ContactMode
from tests.cli.cli_helpers import run

LAWS = tuple(RESTITUTIONS)
ARM = Path(__file__).parents[2] / "robots" / "files" / "turning_arm.urdf"


def random_impacts(count, seed):
    """Yield J of shape (3, 2), velocities u of two masses of 1 kg, and a friction coefficient."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        J, u = rng.normal(size=(3, 2)), rng.normal(size=2)
        yield J, u if J[0] @ u < 0 else -u, 10 ** rng.uniform(-1.5, 1)


def tie(W):
    """Return a = W_tt⁻¹ w: v_n − a·v_t stays, and (1, −a) is an impulse that moves nothing."""
    return np.linalg.solve(W[1:, 1:], W[1:, 0])


def compressed(J, u, mu):
    """Return u and (P_n, P_1, P_2) by SciPy where v_n = 0 or the slip stops.

    It follows the angle and the logarithm of the slip, and both freedoms.
    """
    W = J @ J.T

    def rates(_, y):
        v, e = math.exp(y[1]), np.array([math.cos(y[0]), math.sin(y[0])])
        f, r = W[1:, 0] - mu * W[1:, 1:] @ e, np.array([1.0, *(-mu * e)])
        return [e[0] * f[1] - e[1] * f[0], e @ f, *(v * J.T @ r), *(v * r)]

    def border(_, y):
        return J[0] @ y[2:4]

    def stop(_, y):
        return y[1] - slip + 25.0

    border.terminal = stop.terminal = True
    (_, v_1, v_2), tolerances = J @ u, {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
    slip = math.log(math.hypot(v_1, v_2))
    start = [math.atan2(v_2, v_1), slip, *u, 0, 0, 0]
    end = solve_ivp(rates, (0, 1e6), start, events=[border, stop], **tolerances).y[:, -1]
    return end[2:4], end[4:]


def test_compression_is_that_of_scipy_in_the_two_freedoms():
    stopped = 0
    for J, u, mu in random_impacts(40, 3):
        impact = solve_impact(J @ J.T, mu, J @ u, "poisson", 0.5)
        first = impact.phases[0]
        after, P = compressed(J, u, mu)
        assert first.impulse == pytest.approx(P, rel=1e-8, abs=1e-9)
        assert first.velocity == pytest.approx(J @ after, abs=1e-8 * (1 + abs(J @ u).max()))
        if first.name == "tangential":
            # Slip and approach stop together, exactly.
            stopped += 1
            assert first.velocity == (0.0, 0.0, 0.0)
    assert 5 < stopped < 35


@pytest.mark.parametrize("law", LAWS)
def test_impulse_moves_the_two_freedoms_and_the_works_are_their_energy(law):
    ends = set()
    for J, u, mu in random_impacts(150, 5):
        impact = solve_impact(J @ J.T, mu, J @ u, law, 0.7)
        after = u + J.T @ impact.impulse
        assert impact.velocity == pytest.approx(J @ after, abs=1e-9 * (1 + abs(J @ u).max()))
        change = (after @ after - u @ u) / 2
        assert impact.energy_change == pytest.approx(change, abs=1e-9 * (u @ u))
        # A jam is one, and no impulse of 1e14 by rounding.
        assert impact.normal_impulse < 1e4
        ends.add(impact.end)
    other = ImpactEnd.PERSISTENT if law == "poisson" else ImpactEnd.JAM
    assert ends == {ImpactEnd.SEPARATION, other}


def test_many_impacts_keep_their_two_freedoms():
    rng, count = np.random.default_rng(1), 3000
    J = rng.normal(size=(count, 3, 2)) * 10 ** rng.uniform(-1, 1, size=(count, 3, 1))
    J /= np.linalg.norm(J, axis=(1, 2))[:, None, None]
    u = rng.normal(size=(count, 2))
    u *= -np.sign(np.einsum("nj,nj->n", J[:, 0], u))[:, None]
    W, v = J @ J.transpose(0, 2, 1), np.einsum("nij,nj->ni", J, u)
    own = [W[:, i, j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]
    mu, e = 10 ** rng.uniform(-2, 1, count), rng.random(count)
    det = (own[3] * own[5] - own[4] ** 2) / (own[3] * own[5])
    given = np.column_stack([*own, mu, v, np.arange(count) % 3, e])[det > 1e-6]
    results, kept = impacts_in_space(given), J[det > 1e-6]
    phases = results[:, 2:].reshape(len(given), 16, 11)
    last = results[:, 1].astype(int) - 1
    assert last.min() >= 0
    P = phases[:, :, 1:4].cumsum(axis=1)[np.arange(len(given)), last]
    after = phases[np.arange(len(given)), last, 4:7]
    change = np.einsum("nij,nkj,nk->ni", kept, kept, P)
    sizes = abs(given[:, 7:10]).max(axis=1) + abs(P).max(axis=1)
    assert (abs(given[:, 7:10] + change - after).max(axis=1) / sizes).max() < 1e-8


@pytest.mark.parametrize(("law", "e"), [*product(LAWS, [0.6]), ("energetic", 0.0)])
def test_velocities_are_the_limit_of_regular_mobilities(law, e):
    numbers, jams, tied = np.random.default_rng(11), 0, 0
    for J, u, mu in random_impacts(60, 11):
        W, v, Q = J @ J.T, J @ u, numbers.normal(size=(3, 3))
        impact = solve_impact(W, mu, v, law, e)
        near = [solve_impact(W + size * Q @ Q.T, mu, v, law, e) for size in (1e-6, 1e-8)]
        if impact.end is ImpactEnd.JAM:
            # The impulse grows as 1/√ε, by Newton's law as 1/ε.
            jams += 1
            assert near[1].normal_impulse > 5 * near[0].normal_impulse
            continue
        assert near[1].velocity == pytest.approx(impact.velocity, abs=1e-4)
        if impact.phases[0].name == "tangential" and impact.case is ImpactClass.C_STICKING:
            # The rest of the impulse moves nothing.
            tied += 1
            more = np.array(near[1].impulse) - impact.impulse
            assert more[1:] == pytest.approx(-more[0] * tie(W), abs=2e-4 * (1 + abs(more[0])))
    assert (jams > 3) == (law != "poisson" and e > 0) and (tied > 3) == (jams == 0)


def test_impulse_of_the_limit_depends_on_the_way_there():
    # Slip straight into the wedge: w = -2 t1 and W_tt = 1, so that a = (-2, 0).
    W, mu, v = np.array([[4.0, -2, 0], [-2, 1, 0], [0, 0, 1]]), 3.0, (-2.0, 1.0, 0.0)
    # v_t stops at P = 1/(2 + 3), and so does v_n, since A = 4 + 2 * 3 = 10.
    impact = solve_impact(W, mu, v, "poisson", 0.0)
    assert impact.impulse == pytest.approx((0.2, -0.6, 0.0), rel=1e-15)
    assert impact.velocity == (0.0, 0.0, 0.0)
    kernel, totals = np.array([1.0, 2.0, 0.0]), []
    for way in (np.diag([1.0, 0, 0]), np.diag([0.0, 1, 0])):
        near = solve_impact(W + 1e-9 * way, mu, v, "poisson", 0.0)
        assert near.velocity == pytest.approx((0, 0, 0), abs=1e-8)
        more = np.array(near.impulse) - impact.impulse
        assert more == pytest.approx(more[0] * kernel, abs=1e-6)
        totals.append(near.normal_impulse)
    # ε (1, 0): v_n = 0 comes first. ε (0, 1): v_n = -0.2 * 2 * 3 ε is left, and A' = 4 ε.
    assert totals == pytest.approx([0.2, 0.5], abs=1e-6)


@pytest.mark.parametrize("law", LAWS)
def test_surface_that_is_driven_leaves_or_jams_what_sticks(law):
    W, mu = np.array([[1.0, -1, 0], [-1, 1, 0], [0, 0, 2]]), 2.0
    # c = v_n + v_1 = -0.5 is left where the slip stops.
    jam = solve_impact(W, mu, (-1.0, 0.5, 0.4), law, 0.5)
    assert (jam.end, jam.case) == (ImpactEnd.JAM, ImpactClass.C_STICKING)
    assert jam.velocity == (pytest.approx(-0.5, rel=1e-15), 0.0, 0.0)
    # c = 0.1 opens it: v_n ends there, and only Newton's law asks for more.
    impact = solve_impact(W, mu, (-1.0, 1.1, 0.1), law, 0.9)
    assert impact.case is ImpactClass.R_STICKING
    assert impact.velocity == (pytest.approx(0.1, rel=1e-15), 0.0, 0.0)
    assert (impact.end is ImpactEnd.JAM) == (law == "newton")


def test_contact_that_nothing_moves_along_its_normal_jams():
    for slip in ((0.0, 0.0), (1.0, 0.5)):
        impact = solve_impact(np.diag([0.0, 1, 2]), 0.5, (-1.0, *slip))
        assert (impact.end, impact.velocity) == (ImpactEnd.JAM, (-1.0, 0.0, 0.0))
    slides = solve_impact(np.diag([0.0, 1, 2]), 0.0, (-1.0, 1.0, 0.5))
    assert (slides.end, slides.velocity) == (ImpactEnd.JAM, (-1.0, 1.0, 0.5))
    assert solve_impact(np.diag([0.0, 1, 2]), 0.5, (0.0, 1.0, 0.5)).end is ImpactEnd.PERSISTENT


def test_slip_in_a_plane_of_symmetry_is_the_strut_of_the_plane():
    for law, mu in product(LAWS, (0.3, 1.5)):
        plane = solve_impact([[1.0, -1], [-1, 1]], mu, (-1.0, 1.0), law, 0.5)
        space = solve_impact([[1.0, -1, 0], [-1, 1, 0], [0, 0, 3]], mu, (-1.0, 1.0, 0), law, 0.5)
        assert (space.case, space.end) == (plane.case, plane.end)
        assert [p.name for p in space.phases] == [p.name for p in plane.phases]
        assert space.velocity == pytest.approx((*plane.velocity, 0.0), abs=1e-15)
        assert space.impulse == pytest.approx((*plane.impulse, 0.0), abs=1e-15)


# ---- mechanisms with two freedoms ----

MAST = """
gravity = "g"
[coordinates]
a = { unit = "rad", meaning = "turn about the vertical" }
b = { unit = "rad", meaning = "elevation" }
[parameters]
g = { default = 9.8, unit = "m/s^2", meaning = "gravity" }
mu = { default = 0.5, unit = "1", meaning = "friction coefficient" }
[[bodies]]
name = "rod"
mass = 1
centre = ["cos(b)*cos(a)/2", "cos(b)*sin(a)/2", "1 + sin(b)/2"]
inertia = [0, "1/12", "1/12"]
orientation = [["z", "a"], ["y", "-b"]]
[[contacts]]
name = "tip"
friction = "mu"
point = { body = "rod", at = ["1/2", 0, 0] }
through = [0, 0, "1 - sin(0.5)"]
[start]
b = -0.5
a_dot = 0.5
b_dot = -1.0
"""


def test_mechanism_of_two_coordinates_has_its_impact(capsys, tmp_path):
    file = tmp_path / "mast.toml"
    file.write_text(MAST)
    c, s = math.cos(0.5), math.sin(0.5)
    # A uniform rod that turns about its end: J = 1/3, and J cos² b about the vertical.
    J = np.array([[c, 0.0], [s, 0.0], [0.0, c]]) @ np.diag([3**0.5, 3**0.5 / c])
    before = np.diag([3**-0.5, c * 3**-0.5]) @ (-1.0, 0.5)
    mast = ps.load_mechanism(file)
    for rule, mu in product(LAWS, (0.2, 1.5, 3.0)):
        jump = ps.evaluate_jump(mast, rule, parameters={"mu": mu})
        impact = solve_impact(J @ J.T, mu, J @ before, rule, 0.75)
        assert (jump.end, jump.case) == (impact.end, impact.case)
        assert jump.energy_change == pytest.approx(impact.energy_change, rel=1e-9)
        end = {name: jump.velocity[name] for name in ("a_dot", "b_dot")}
        after = before + J.T @ impact.impulse
        expected = {"b_dot": 3**0.5 * after[0], "a_dot": 3**0.5 * after[1] / c}
        assert end == pytest.approx(expected, abs=1e-9)
    code, out, _ = run(capsys, "jump", str(file), "--set", "mu=3")
    assert code == 0 and "The impulse of a rigid contact has no end here" in " ".join(out.split())


def test_robot_with_two_free_joints_has_its_impact():
    robot = ps.robot(ARM)
    tip = robot.contact("tip", joints={"shoulder": -0.5}, locked="elbow")
    W = tip.mobility()
    assert abs(np.linalg.det(W)) < 1e-12 < np.linalg.det(W[1:, 1:])
    for law, mu in product(LAWS, (0.4, 3.0)):
        jump = tip.jump(law, mu, 0.5, {"psi": 0.5, "shoulder": -1.0})
        slip = jump.phases[0]
        impact = solve_impact(
            W, mu, (-math.cos(0.5), -math.sin(0.5), 0.5 * math.cos(0.5)), law, 0.5
        )
        assert jump.end is impact.end and [p.name for p in jump.phases] == [
            p.name for p in impact.phases
        ]
        assert slip.normal_impulse == pytest.approx(impact.phases[0].normal_impulse, rel=1e-9)
        assert jump.energy_change == pytest.approx(impact.energy_change, rel=1e-9)
    # Slip at 1 m/s along the worst direction is none that these joints can have.
    risk = tip.risk(3.0)
    assert risk.mu_P < 3.0 and risk.impact is None
    assert (
        robot.contact("tip", joints={"shoulder": -0.5}, locked="elbow,psi").risk(3.0).impact is None
    )
    assert any(p.mode is ContactMode.STICK for p in impact.phases)
