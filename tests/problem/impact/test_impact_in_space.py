"""Impacts of one contact in space: independent numbers, closed forms, theorems, borders, errors."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from painleve_sym.errors import CompilerMissing, InputError
from painleve_sym.laws.restitution import RESTITUTIONS, Measure
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.problem.impact import spatial
from painleve_sym.problem.impact.one_contact import (
    ImpactEnd,
    invariant_directions,
    solve_impact,
)
from painleve_sym.problem.impact.spatial import MEASURES, impacts_in_space
from painleve_sym.problem.modes import ContactMode


def rod(theta, psi=0.0, alpha=3.0):
    """Return m W of a rod: its axis points from the contact to the centre, α = m l²/J."""
    c = math.cos(theta)
    a = np.array([math.sin(theta), c * math.cos(psi), c * math.sin(psi)])
    return (1 + alpha) * np.eye(3) - alpha * np.outer(a, a)


def sliding(v_n, v, beta, psi=0.0):
    """Return a velocity whose slip is at β from the direction away from the centre."""
    angle = psi + math.pi + beta
    return (v_n, v * math.cos(angle), v * math.sin(angle))


LAWS = tuple(RESTITUTIONS)

# Each ends another way than an impact in the plane can, with e = 1 by the energetic law.
SLIDES = ([[1, -1, 0], [-1, 6, 2], [0, 2, 1]], 2.4, (0.0, -0.5, 0.9))
RESUMES = ([[9, -2, 6], [-2, 1, -2], [6, -2, 5]], 2.1, (0.0, -0.5, 0.9))
COMPRESSED_TWICE = ([[8, -2, -6], [-2, 2, 1], [-6, 1, 5]], 1.3, (-1.0, -2.7, -1.5))
CASES = {
    "slides out of the paradox": SLIDES,
    "stops in the paradox, slips again": RESUMES,
    "is compressed twice": COMPRESSED_TWICE,
    "rod": (rod(1.0), 1.4, sliding(-1.0, 1.0, 1.2)),
    "rod in the paradox": (rod(1.0), 1.4, sliding(0.0, 1.0, 0.05)),
    "turns, within the astroid": ([[3, 0.3, 0.2], [0.3, 1, 0.5], [0.2, 0.5, 4]], 0.6, (-1.0, 1, 2)),
    "slow slip": ([[3, 0.3, 0.2], [0.3, 1, 0.5], [0.2, 0.5, 4]], 0.1, (-1.0, 1e-3, 2e-3)),
    "starts at rest, slips": ([[3, 1, 1.2], [1, 1, 0.5], [1.2, 0.5, 4]], 0.3, (-1.0, 0, 0)),
    "starts at rest, sticks": ([[3, 1, 1.2], [1, 1, 0.5], [1.2, 0.5, 4]], 2.0, (-1.0, 0, 0)),
}


# Across t1 only a surface that is driven slips.
DRIVEN = {
    "turns until its part along t1 stays": ([[3, 1, 0], [1, 1, 0], [0, 0, 0]], 2.0, (-1.0, 1, 0.8)),
    "grows along t1": ([[3, 1, 0], [1, 1, 0], [0, 0, 0]], 0.5, (-1.0, -0.2, 0.8)),
    "begins in the paradox": ([[2, 1.5, 0], [1.5, 2, 0], [0, 0, 0]], 2.0, (0.0, 1, 0.1)),
    "starts across": ([[3, 1, 0], [1, 1, 0], [0, 0, 0]], 1.0, (-1.0, 0.0, 0.5)),
}


# ---- numbers that the package did not compute ----


@pytest.mark.parametrize(
    ("beta", "v_n", "stop", "after", "total"),
    [
        (0.0, -0.011211054733, 0.332230083991, 0.052470147923, 0.381968609788),
        (0.05, -0.010913114410, 0.332036647411, 0.051423584668, 0.380725041881),
    ],
)
@pytest.mark.parametrize("psi", [0.0, 2.2])
def test_rod_has_the_impact_without_collision(beta, v_n, stop, after, total, psi):
    impact = solve_impact(rod(1.0, psi), 1.4, sliding(0.0, 1.0, beta, psi), "energetic", 0.75)
    assert impact.case is ImpactClass.C_STICKING and impact.without_collision
    first, *_, last = impact.phases
    assert first.velocity == pytest.approx((v_n, 0.0, 0.0), abs=1e-12)
    assert first.normal_impulse == pytest.approx(stop, abs=1e-12)
    assert last.velocity == pytest.approx((after, 0.0, 0.0), abs=1e-12)
    assert impact.normal_impulse == pytest.approx(total, abs=1e-12)
    # Slip ends along the direction away from the centre.
    assert first.direction == pytest.approx((-math.cos(psi), -math.sin(psi)), abs=1e-12)


def test_rod_has_the_ordinary_impact():
    impact = solve_impact(rod(1.0), 1.4, sliding(-1.0, 1.0, 1.2), "energetic", 0.75)
    first = impact.phases[0]
    assert first.normal_impulse == pytest.approx(0.241925238018, abs=2e-12)
    assert first.velocity[0] == pytest.approx(-0.848453549095, abs=1e-12)
    assert impact.velocity[0] == pytest.approx(0.847190569120, abs=1e-12)
    assert impact.normal_impulse == pytest.approx(1.566316662791, abs=1e-12)


def _followed(W, mu, velocity, law, e):
    """Return the velocity and the impulse at the end, by SciPy, with events along ln v and φ.

    Rays of sticking and of slip that begins are solved in closed form.
    """
    W = np.array(W, dtype=float)
    w, T = W[1:, 0], W[1:, 1:]
    given = {"target": -e * velocity[0], "left": 0.0, "restitution": False}
    # φ, ln v, then v_n, P, P_1, P_2, E of the part.
    y = np.array([math.atan2(*velocity[:0:-1]), 0, velocity[0], 0, 0, 0, 0.0])
    speed, y[1] = math.hypot(*velocity[1:]), math.log(math.hypot(*velocity[1:]))

    def rates(_, y):
        phi, v, n = y[0], math.exp(y[1]), y[2]
        e_, across = (
            np.array([math.cos(phi), math.sin(phi)]),
            np.array([-math.sin(phi), math.cos(phi)]),
        )
        f, A = w - mu * T @ e_, W[0, 0] - mu * w @ e_
        return [across @ f, e_ @ f, v * A, v, -mu * v * e_[0], -mu * v * e_[1], v * n]

    def border(_, y):
        return y[2]

    def law_ends(_, y):
        if not given["restitution"]:
            return -1.0
        done = {"newton": y[2] - given["target"], "poisson": y[3], "energetic": y[6]}[law]
        return done - (0.0 if law == "newton" else given["left"])

    def stops(_, y):
        return y[1] - math.log(speed) + 34.0

    border.terminal = law_ends.terminal = stops.terminal = True
    total = np.zeros(3)
    stopped = False
    for _ in range(10):
        border.direction = -1 if given["restitution"] else 1
        tolerances = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
        run = solve_ivp(rates, (0, 1e6), y, events=[border, law_ends, stops], **tolerances)
        y = run.y[:, -1]
        total, spent = total + y[3:6], {"newton": 0.0, "poisson": y[3], "energetic": y[6]}[law]
        hit = next(i for i in (2, 1, 0) if len(run.t_events[i]))
        if given["restitution"]:
            given["left"] -= spent
        else:
            given["left"] += e * spent if law == "poisson" else -e * e * spent
        y[3:] = 0.0
        if hit == 1:
            break
        if hit == 2:
            stopped = True
            break
        y[2], given["restitution"] = 0.0, not given["restitution"]
    v = math.exp(y[1]) * np.array([math.cos(y[0]), math.sin(y[0])])
    if not stopped:
        return np.array([y[2], *v]), total
    ratio = -np.linalg.solve(T, w)
    if np.linalg.norm(ratio) > mu:
        # Slip begins where W_tt's problem with a trust region of radius μ has its solution.
        low, high = 0.0, 1e3
        for _ in range(200):
            k = (low + high) / 2
            size = np.linalg.norm(np.linalg.solve(mu * T + k * np.eye(2), w))
            low, high = (k, high) if size > 1 else (low, k)
        ratio = -mu * np.linalg.solve(mu * T + k * np.eye(2), w)
    rate = W @ [1.0, *ratio]
    n = y[2]
    if not given["restitution"]:
        P = -n / rate[0]
        total, n = total + P * np.array([1.0, *ratio]), 0.0
        given["left"] += {"newton": 0, "poisson": e * P, "energetic": e * e * P * -y[2] / 2}[law]
    final = {
        "newton": given["target"],
        "poisson": n + rate[0] * given["left"],
        "energetic": math.sqrt(n * n + 2 * rate[0] * given["left"]),
    }[law]
    total = total + (final - n) / rate[0] * np.array([1.0, *ratio])
    return np.array(velocity) + W @ total, total


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", [n for n in sorted(CASES) if "at rest" not in n])
def test_impact_agrees_with_scipy(name, law):
    W, mu, velocity = CASES[name]
    e = 1.0 if "twice" in name else 0.7
    impact = solve_impact(W, mu, velocity, law, e)
    v, P = _followed(W, mu, velocity, law, e)
    assert impact.velocity == pytest.approx(v, abs=1e-9)
    assert impact.impulse == pytest.approx(P, abs=2e-9)


def test_without_a_compiler_an_impact_in_space_says_what_to_install(monkeypatch):
    def none():
        raise CompilerMissing("no working C compiler: looked for cc. Fix: install gcc.")

    monkeypatch.setattr(spatial, "_compiled", none)
    W, mu, velocity = CASES["rod"]
    text = r"^solve impact: impacts in space are computed by compiled code: no .*Fix: install gcc"
    with pytest.raises(CompilerMissing, match=text):
        solve_impact(W, mu, velocity)
    # What moves in a plane, and directions, need none.
    flat = solve_impact(np.diag([2.0, 1.0, 0.0]), mu, (-1.0, 1.0, 0.0))
    assert flat.end is ImpactEnd.SEPARATION and len(invariant_directions(W, mu)) == 2


def random_impacts(count, seed, tangential=False, spread=1.0):
    """Return W of shape (n, 3, 3) and what the compiled path is given, shape (n, 12)."""
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(count, 3, 3)) * 10 ** rng.uniform(-spread, spread, size=(count, 3, 1))
    W, v = J @ J.transpose(0, 2, 1), rng.normal(size=(count, 3))
    v[:, 0] = 0.0 if tangential else -abs(v[:, 0])
    v[:, 1:] *= 10 ** rng.uniform(-2 * spread, 2 * spread, size=(count, 1))
    e = np.where(rng.random(count) < 0.5, 1.0, rng.random(count))
    own = (W[:, 0, 0], W[:, 0, 1], W[:, 0, 2], W[:, 1, 1], W[:, 1, 2], W[:, 2, 2])
    mu = 10 ** rng.uniform(-2, 1, count)
    given = np.column_stack([*own, mu, v, np.arange(count) % 3, e])
    definite = np.linalg.cond(W) < 1e10
    return W[definite], given[definite]


def test_random_impacts_agree_with_scipy():
    names = {MEASURES.index(law.measure): law for law in RESTITUTIONS.values()}
    W, given = random_impacts(40, 4, spread=0.5)
    ends = set()
    for own, (mu, *velocity, measure, share) in zip(W, given[:, 6:].tolist(), strict=True):
        law = names[int(measure)]
        e = share ** (1 / law.power)
        impact = solve_impact(own, mu, velocity, law.name, e)
        v, P = _followed(own, mu, velocity, law.name, e)
        size = 1 + abs(v).max()
        assert impact.velocity == pytest.approx(v, abs=1e-8 * size)
        assert impact.impulse == pytest.approx(P, rel=1e-8, abs=1e-8 * abs(P).max())
        ends.add((impact.case, law.name))
    assert len(ends) > 8


# ---- the law and the events ----


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", sorted(CASES))
def test_impact_balances_momentum_energy_and_the_law(name, law):
    W, mu, velocity = CASES[name]
    e = 0.9 if "twice" not in name else 1.0
    impact = solve_impact(W, mu, velocity, law, e)
    change = np.array(W, dtype=float) @ impact.impulse
    assert np.array(impact.velocity) - velocity == pytest.approx(change, abs=1e-13)
    before, after = (np.array(v) @ np.linalg.solve(W, v) / 2 for v in (velocity, impact.velocity))
    assert impact.energy_change == pytest.approx(after - before, abs=1e-13)
    compressed = [p for p in impact.phases if p.name == "tangential" or "compression" in p.name]
    others = [p for p in impact.phases if p not in compressed]
    assert any(phase.velocity[0] == 0.0 for phase in compressed)
    if law == "poisson":
        P = [math.fsum(p.normal_impulse for p in part) for part in (compressed, others)]
        assert P[1] == pytest.approx(e * P[0], rel=1e-13)
    elif law == "energetic":
        E = [math.fsum(p.normal_work for p in part) for part in (compressed, others)]
        assert E[1] == pytest.approx(-e * e * E[0], rel=1e-13)
    else:
        assert impact.velocity[0] == -e * velocity[0]
    for phase in impact.phases:
        sizes = np.hypot(*phase.tangential_impulse), mu * phase.normal_impulse
        assert sizes[0] <= sizes[1] * (1 + 1e-14)
        assert phase.tangential_work <= 0
        sticks = phase.mode is ContactMode.STICK
        assert np.hypot(*phase.direction) == pytest.approx(0.0 if sticks else 1.0, abs=1e-14)


def test_stop_of_the_slip_is_its_limit():
    # With w = 0 and equal mobilities slip is straight, and stops at P = v/(μ λ).
    W, v = np.diag([2.0, 3.0, 3.0]), 0.5
    first = solve_impact(W, 0.2, (-1.0, v * 0.6, v * 0.8)).phases[0]
    assert first.velocity[1:] == pytest.approx((0.6 * (v - 0.3), 0.8 * (v - 0.3)), rel=1e-14)
    first = solve_impact(W, 0.4, (-1.0, v * 0.6, v * 0.8)).phases[0]
    assert first.name == "tangential" and first.velocity[1:] == (0.0, 0.0)
    assert first.normal_impulse == pytest.approx(v / 1.2, rel=1e-15)


# ---- closed forms ----


def test_invariant_of_a_central_contact_is_derived():
    one, two, phi, mu = sp.symbols("lambda_1 lambda_2 varphi mu", positive=True)
    e, across = sp.Matrix([sp.cos(phi), sp.sin(phi)]), sp.Matrix([-sp.sin(phi), sp.cos(phi)])
    f = -mu * sp.diag(one, two) * e
    k, h = e.dot(f), across.dot(f)
    # ln |v_1| / λ_1 − ln |v_2| / λ_2, with v_i = v e_i.
    rate = (k + h * across[0] / e[0]) / one - (k + h * across[1] / e[1]) / two
    assert sp.simplify(rate) == 0


@pytest.mark.parametrize("mu", [0.1, 0.35])
def test_central_contact_keeps_its_invariant(mu):
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    W = np.zeros((3, 3))
    W[0, 0], W[1:, 1:] = 2.0, turn @ np.diag([1.0, 3.5]) @ turn.T
    v = turn @ [0.7, 1.1]
    impact = solve_impact(W, mu, (-1.0, *v), "poisson", 0.8)

    def invariant(velocity):
        one, two = turn.T @ velocity[1:]
        return math.log(one) - math.log(two) / 3.5

    ends = [p.velocity for p in impact.phases]
    assert len(ends) == 2 and impact.case is ImpactClass.SLIDING
    assert [invariant(end) for end in ends] == pytest.approx([invariant((0, *v))] * 2, abs=1e-13)
    assert impact.velocity[0] == pytest.approx(0.8, rel=1e-14)


def test_invariant_of_the_rod_is_derived():
    theta, beta, mu, alpha = sp.symbols("theta beta mu alpha", positive=True)
    c, s, x = sp.cos(theta), sp.sin(theta), sp.cos(beta)
    # Along t1 lies the direction away from the centre, a_t = −c t1.
    a = sp.Matrix([s, -c, 0])
    W = (1 + alpha) * sp.eye(3) - alpha * a * a.T
    e, across = sp.Matrix([x, sp.sin(beta)]), sp.Matrix([-sp.sin(beta), x])
    f = W[1:, 0] - mu * W[1:, 1:] * e
    k, h = e.dot(f), across.dot(f)
    assert sp.simplify(h + alpha * c * sp.sin(beta) * (s + mu * c * x)) == 0
    A = W[0, 0] - mu * W[1:, 0].dot(e)
    assert sp.simplify(A - (1 + alpha * c**2 - alpha * mu * s * c * x)) == 0
    rate = k + h * sp.diff(_rod_invariant(theta, mu, alpha, beta, sp), beta)
    assert sp.simplify(rate) == 0


def _rod_invariant(theta, mu, alpha, beta, m):
    """Return the invariant without ln v, by functions of a module."""
    c, s, x = m.cos(theta), m.sin(theta), m.cos(beta)
    terms = -m.log(1 - x) / (2 * (s + mu * c)) + m.log(1 + x) / (2 * (s - mu * c))
    terms += mu * c / (mu**2 * c**2 - s**2) * m.log(s + mu * c * x)
    return m.log(m.sin(beta)) + mu * (1 + alpha) / (alpha * c) * terms


@pytest.mark.parametrize(
    ("theta", "mu", "beta"), [(1.0, 1.4, 1.2), (0.6, 0.3, 2.5), (1.2, 0.9, 0.4)]
)
def test_rod_keeps_its_invariant(theta, mu, beta):
    start = _rod_invariant(theta, mu, 3.0, beta, math)
    if (theta, mu) == (1.0, 1.4):
        assert start == pytest.approx(4.593596233357, abs=1e-11)
    # Slow approaches end while the contact slips.
    impact = solve_impact(rod(theta), mu, sliding(-0.05, 1.0, beta), "energetic", 0.5)
    for phase in impact.phases:
        assert phase.name.startswith("slip")
        v_1, v_2 = -phase.velocity[1], -phase.velocity[2]
        invariant = _rod_invariant(theta, mu, 3.0, math.atan2(v_2, v_1), math)
        assert invariant + math.log(math.hypot(v_1, v_2)) == pytest.approx(start, abs=1e-12)


# ---- invariant directions ----


def _rates(W, mu, angle):
    e, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    f = W[1:, 0] - mu * W[1:, 1:] @ e
    return W[0, 0] - mu * W[1:, 0] @ e, e @ f, across @ f


def _of_the_quartic(W, mu):
    """Return the angles of the invariant directions as roots of a polynomial on the unit circle."""
    w, d, m = W[1:, 0], (W[2, 2] - W[1, 1]) / 2, W[1, 2]
    # h = Re((w_2 + i w_1) z) − μ (d sin 2φ + m cos 2φ), z = exp(i φ).
    one, two = (w[1] + 1j * w[0]) / 2, -mu * (m - 1j * d) / 2
    roots = np.roots([two, one, 0, one.conjugate(), two.conjugate()])
    return np.sort(np.angle(roots[abs(abs(roots) - 1) < 1e-6]) % (2 * np.pi))


def test_invariant_directions_are_all_roots():
    every, _ = random_impacts(300, 11, spread=0.5)
    counts = set()
    for i, W in enumerate(every):
        mu = 10 ** (-1.5 + 2.5 * i / 300)
        directions = invariant_directions(W, mu)
        counts.add(len(directions))
        expected = _of_the_quartic(W, mu)
        assert np.sort([d.angle % (2 * np.pi) for d in directions]) == pytest.approx(
            expected, abs=1e-7
        )
        for d in directions:
            _, k, h = _rates(W, mu, d.angle)
            size = np.linalg.norm(W[1:, 0]) + mu * np.trace(W[1:, 1:])
            assert abs(h) <= 2e-15 * size  # the rounding of the angle
            assert d.growth == pytest.approx(k, abs=2e-15 * size)
            step = 1e-6
            slope = (_rates(W, mu, d.angle + step)[2] - _rates(W, mu, d.angle - step)[2]) / 2 / step
            assert d.turning == pytest.approx(slope, abs=1e-8 * size)
        # Slip can grow in one direction, the attracting first one, or in none: it then sticks.
        grows = [d.growth > 0 for d in directions]
        sticks = np.linalg.norm(np.linalg.solve(W[1:, 1:], W[1:, 0])) <= mu
        assert grows == [not sticks] + [False] * (len(directions) - 1)
        assert directions[0].turning < 0 and min(d.turning for d in directions[1:2]) >= -1e-12
    assert counts == {2, 4}


def test_invariant_directions_have_closed_forms_in_degenerate_cases():
    quarter = math.pi / 2

    def angles(W_tt, w, mu=0.5):
        W = np.diag([100.0, *W_tt])
        W[0, 1:] = W[1:, 0] = w
        return sorted((d.angle + 1e-12) % (4 * quarter) for d in invariant_directions(W, mu))

    assert angles((3.0, 3.0), (0.0, 0.0)) == []
    assert angles((1.0, 3.0), (0.0, 0.0)) == pytest.approx([0, quarter, 2 * quarter, 3 * quarter])
    assert angles((3.0, 3.0), (0.6, 0.8)) == pytest.approx(
        [math.atan2(4, 3), math.atan2(4, 3) + math.pi]
    )
    # h = −sin φ (w + μ Δ cos φ), and likewise along the other axis: μ Δ = 1.
    half = math.acos(-0.4)
    assert angles((1.0, 3.0), (0.4, 0.0)) == pytest.approx([0, half, math.pi, 2 * math.pi - half])
    assert angles((1.0, 3.0), (1.4, 0.0)) == pytest.approx([0, math.pi])
    rise = math.asin(0.4)
    expected = [rise, quarter, math.pi - rise, 3 * quarter]
    assert angles((1.0, 3.0), (0.0, 0.4)) == pytest.approx(expected)
    assert angles((1.0, 3.0), (0.0, -1.4)) == pytest.approx([quarter, 3 * quarter])


# ---- theorems ----


def test_in_the_paradox_slip_slows_down():
    A, k, W_nn, along, T, mu = sp.symbols("A k W_nn w_e T mu")
    # With the minor of W along n and e: W_nn T − (w·e)² > 0.
    A_of, k_of = W_nn - mu * along, along - mu * T
    minor = W_nn * T - along**2
    assert sp.expand(W_nn * k_of - along * A_of + mu * minor) == 0
    # So W_nn k = (w·e) A − μ minor, and A < 0 needs w·e > 0.
    W, given = random_impacts(20000, 3)
    mu_, v = given[:, 6], given[:, 8:10]
    e = v / np.hypot(*v.T)[:, None]
    A, k = np.empty((2, len(W)))
    for i in range(len(W)):
        A[i], k[i], _ = _rates(W[i], mu_[i], math.atan2(e[i, 1], e[i, 0]))
    assert (A < 0).sum() > 500
    assert (k[A < 0] < 0).all()


def test_rod_sticks_after_an_impact_without_collision():
    rng = np.random.default_rng(8)
    for _ in range(400):
        theta, alpha = rng.uniform(0.2, 1.4), rng.uniform(0.3, 6.0)
        s, c = math.sin(theta), math.cos(theta)
        border = (1 + alpha * c * c) / (alpha * s * c)
        mu = border * (1 + rng.exponential(0.5))
        beta = rng.uniform(-1, 1) * math.acos(border / mu)
        e = rng.uniform()
        impact = solve_impact(
            rod(theta, 0.7, alpha), mu, sliding(0.0, 1.0, beta, 0.7), "energetic", e
        )
        assert impact.case is ImpactClass.C_STICKING
        assert impact.phases[0].velocity[0] < 0


def test_general_impact_without_collision_need_not_stick():
    slides = solve_impact(*SLIDES, "energetic", 0.75)
    assert slides.without_collision and slides.case is ImpactClass.SLIDING
    assert np.hypot(*slides.velocity[1:]) > 0.8
    resumes = solve_impact(*RESUMES, "energetic", 0.75)
    assert resumes.without_collision and resumes.case is ImpactClass.C_REVERSED
    tangential, *_, last = resumes.phases
    assert tangential.velocity[0] < -0.5 and np.hypot(*last.velocity[1:]) > 0.1
    # Slip begins in the one direction in which it can grow, at an angle to that of its stop.
    first = invariant_directions(*RESUMES[:2])[0]
    assert last.direction == pytest.approx(
        (math.cos(first.angle), math.sin(first.angle)), abs=1e-14
    )
    assert np.dot(last.direction, tangential.direction) > -0.99


def test_contact_can_be_compressed_twice():
    impact = solve_impact(*COMPRESSED_TWICE, "energetic", 1.0)
    names = ["slip compression", "slip restitution", "tangential", "sticking compression"]
    assert [p.name for p in impact.phases] == [*names, "sticking restitution"]
    assert [p.velocity[0] for p in impact.phases[:2]] == [0.0, 0.0]
    assert impact.phases[1].normal_work > 0 > impact.phases[2].normal_work
    assert impact.energy_change < 0 and impact.end is ImpactEnd.SEPARATION


def test_slip_turns_down_the_rate_at_which_the_energy_bends():
    phi, mu = sp.symbols("varphi mu")
    n, w1, w2, a, b, d = sp.symbols("W_nn w_1 w_2 W_11 W_12 W_22")
    W = sp.Matrix([[n, w1, w2], [w1, a, b], [w2, b, d]])
    e, across = sp.Matrix([sp.cos(phi), sp.sin(phi)]), sp.Matrix([-sp.sin(phi), sp.cos(phi)])
    push = sp.Matrix([1, *(-mu * e)])
    kappa = (push.T * W * push)[0]
    h = across.dot(W[1:, 0] - mu * W[1:, 1:] * e)
    # d²E/dP² = κ along the path, dκ/dτ = κ′ h = −2 μ h²: never positive.
    assert sp.simplify(sp.diff(kappa, phi) + 2 * mu * h) == 0


def _energy_campaign(count, seed, tangential):
    W, given = random_impacts(count, seed, tangential)
    results = impacts_in_space(given)
    counts = results[:, 1].astype(int)
    rows = results[:, 2:].reshape(len(given), -1, 11)
    rows = np.where((np.arange(rows.shape[1]) < counts[:, None])[..., None], rows, 0.0)
    assert set(results[:, 0]) <= {0.0, 1.0}
    assert np.isfinite(results).all()
    work, impulses = rows[:, :, 7:9].sum(axis=(1, 2)), rows[:, :, 1:4].sum(axis=1)
    before = given[:, 7:10]
    change = np.einsum("nij,nj->ni", W, impulses)
    energy = np.einsum("ni,ni->n", before, np.linalg.solve(W, before[..., None])[..., 0]) / 2
    # The work is the change of energy, P·(v⁺ + v⁻)/2.
    balance = work - np.einsum("ni,ni->n", impulses, before + change / 2)
    summed = np.einsum("nij,nj->ni", abs(W), abs(impulses))
    terms = np.einsum("ni,ni->n", abs(impulses), abs(before) + summed)
    assert (abs(balance) <= 1e-11 * terms).all()
    kinematic = given[:, 10] == MEASURES.index(Measure.VELOCITY)
    gains = work > 1e-12 * energy
    assert not gains[~kinematic].any()
    if not tangential:
        assert gains[kinematic].any()
    return counts


def test_energy_never_grows():
    _energy_campaign(3000, 1, False)
    _energy_campaign(1000, 2, True)


@pytest.mark.slow
def test_energy_never_grows_in_many_impacts():
    counts = _energy_campaign(100_000, 5, False)
    assert (counts > 3).sum() > 10
    _energy_campaign(50_000, 6, True)


# ---- borders ----


def test_contact_at_rest_or_that_opens_has_no_impact():
    W = [[2.0, 0.3, 0.4], [0.3, 1.0, 0.2], [0.4, 0.2, 3.0]]
    for velocity in ((0.0, 0.0, 0.0), (0.0, 1.0, 0.5)):
        impact = solve_impact(W, 0.5, velocity)
        assert impact.case is ImpactClass.NO_IMPACT and impact.end is ImpactEnd.PERSISTENT
        assert impact.phases == () and impact.velocity == velocity
        assert impact.tangential_impulse == (0.0, 0.0)


def test_slip_on_the_border_begins_where_it_turns_into_the_paradox():
    begun = []
    for matrix, mu, _ in (SLIDES, RESUMES, COMPRESSED_TWICE):
        W = np.array(matrix, dtype=float)
        middle, half = math.atan2(W[2, 0], W[1, 0]), math.acos(W[0, 0] / mu / np.hypot(*W[1:, 0]))
        for angle in (middle - half, middle + half):
            A, _, h = _rates(W, mu, angle)
            assert abs(A) < 1e-14
            # dA/dφ has the sign of the side of the sector.
            turns_in = h * (angle - middle) < 0
            impact = solve_impact(W, mu, (0.0, math.cos(angle), math.sin(angle)))
            assert (impact.case is not ImpactClass.NO_IMPACT) == turns_in
            begun.append(turns_in)
    assert set(begun) == {True, False}


def test_slip_next_to_a_repelling_direction_has_the_limit_of_both_sides():
    # Slip along t1 slows down and turns away from it; both sides are mirror images.
    W = np.diag([2.0, 5.0, 1.0])
    on = solve_impact(W, 0.3, (-1.0, 1.0, 0.0), "energetic", 0.5)
    for side in (1e-15, -1e-15, 1e-9, -1e-9):
        near = solve_impact(W, 0.3, (-1.0, 1.0, side), "energetic", 0.5)
        assert near.velocity == pytest.approx(on.velocity, abs=1e-7)
        assert near.normal_impulse == pytest.approx(on.normal_impulse, rel=1e-7)


def test_very_slow_slip_is_near_a_start_at_rest():
    W, mu, _ = CASES["starts at rest, slips"]
    rest = solve_impact(W, mu, (-1.0, 0.0, 0.0), "poisson", 0.6)
    assert rest.case is ImpactClass.SLIDING
    for angle in np.linspace(0, 6, 13):
        v = 1e-13
        near = solve_impact(W, mu, (-1.0, v * math.cos(angle), v * math.sin(angle)), "poisson", 0.6)
        assert near.velocity == pytest.approx(rest.velocity, abs=1e-11)


@pytest.mark.parametrize("scale", [1e-90, 1e90])
def test_impact_has_its_range_of_numbers(scale):
    W, mu, velocity = CASES["turns, within the astroid"]
    one = solve_impact(W, mu, velocity)
    other = solve_impact(W, mu, tuple(v * scale for v in velocity))
    assert [p.name for p in one.phases] == [p.name for p in other.phases]
    assert np.array(other.velocity) / scale == pytest.approx(one.velocity, rel=1e-12, abs=1e-13)


# ---- motion in one plane ----


@given(
    st.floats(-1, 1),
    st.floats(0.1, 3),
    st.floats(0, 3),
    st.floats(-1, 0),
    st.floats(-1, 1),
    st.floats(-3.1, 3.1),
    st.sampled_from(["energetic", "poisson", "newton"]),
)
def test_contact_that_moves_in_one_plane_has_the_impact_of_the_plane(
    coupling, W_tt, mu, v_n, v_t, angle, law
):
    W_nt, e = 0.99 * coupling * math.sqrt(W_tt), (math.cos(angle), math.sin(angle))
    v_n, v_t = (v if abs(v) > 1e-6 else 0.0 for v in (v_n, v_t))
    plane = solve_impact([[1.0, W_nt], [W_nt, W_tt]], mu, (v_n, v_t), law, 0.6)
    turn = np.array([[1.0, 0.0], [0.0, e[0]], [0.0, e[1]]])
    W = turn @ np.array([[1.0, W_nt], [W_nt, W_tt]]) @ turn.T
    impact = solve_impact(W, mu, tuple(turn @ (v_n, v_t)), law, 0.6)
    assert impact.case is plane.case and impact.end is plane.end
    assert [p.name for p in impact.phases] == [p.name for p in plane.phases]
    for own, flat in zip(impact.phases, plane.phases, strict=True):
        np.testing.assert_allclose(own.velocity, turn @ flat.velocity, atol=1e-12)
        np.testing.assert_allclose(own.impulse, turn @ flat.impulse, atol=1e-12)
        np.testing.assert_allclose(own.direction, flat.direction[0] * np.array(e), atol=1e-12)
        assert own.mode.value == ("stick" if flat.mode.value == "stick" else "slip")
    assert impact.energy_change == pytest.approx(plane.energy_change, abs=1e-12)


def test_little_mobility_across_is_none_in_the_limit():
    W, velocity = np.array([[2.0, 1.5, 0], [1.5, 2.0, 0], [0, 0, 0.0]]), (0.0, 1.0, 0.0)
    none = solve_impact(W, 2.0, velocity)
    little = solve_impact(W + np.diag([0, 0, 1e-7]), 2.0, velocity)
    assert [p.name for p in little.phases] == [p.name for p in none.phases]
    np.testing.assert_allclose(little.velocity, none.velocity, atol=1e-12)
    # Nothing moves along the surface.
    free = solve_impact(np.diag([2.0, 0.0, 0.0]), 0.5, (-1.0, 0.0, 0.0), "newton", 0.5)
    assert free.velocity == (0.5, 0.0, 0.0) and free.tangential_impulse == (0.0, 0.0)


# ---- slip that only a surface that is driven can have ----


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", sorted(DRIVEN))
def test_slip_of_a_driven_surface_across_the_motion_stays(name, law):
    W, mu, velocity = DRIVEN[name]
    impact = solve_impact(W, mu, velocity, law, 0.7)
    v, P = _followed(W, mu, velocity, law, 0.7)
    assert impact.velocity == pytest.approx(v, abs=1e-9)
    assert impact.impulse == pytest.approx(P, abs=2e-9)
    assert impact.velocity[2] == pytest.approx(velocity[2], rel=1e-14)
    # The tangents may be turned.
    c, s = math.cos(0.7), math.sin(0.7)
    turn = np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])
    other = solve_impact(turn @ W @ turn.T, mu, turn @ velocity, law, 0.7)
    assert (other.case, other.end) == (impact.case, impact.end)
    assert other.velocity == pytest.approx(turn @ impact.velocity, abs=1e-9)
    assert other.impulse == pytest.approx(turn @ impact.impulse, abs=1e-9)


def test_slip_of_a_driven_surface_jams_only_what_is_tied():
    # W_nn = w1²/W_11 and v_n - v_1 = -2 all along; v_1 tends to v_2/√3, where mu cos φ = 1.
    W = np.array([[1.0, 1, 0], [1, 1, 0], [0, 0, 0]])
    jam = solve_impact(W, 2.0, (-1.0, 1.0, 0.5), "energetic", 0.5)
    assert (jam.end, jam.case, jam.phases) == (ImpactEnd.JAM, ImpactClass.SLIDING, ())
    plastic = solve_impact(W, 2.0, (-1.0, -0.9, 0.5), "energetic", 0.0)
    assert plastic.end is ImpactEnd.PERSISTENT
    assert plastic.velocity == pytest.approx((0.0, 0.1, 0.5), abs=1e-14)


@pytest.mark.parametrize("law", LAWS)
def test_slip_that_no_impulse_moves_is_answered_through_both_doors(law):
    plane = solve_impact([[2.0, 0.0], [0.0, 0.0]], 0.5, (-1.0, 0.5), law, 0.5)
    assert plane.case is ImpactClass.SLIDING and plane.velocity == (0.5, 0.5)
    for angle in (0.0, 0.9, math.pi / 2, -2.5):
        e = np.array([math.cos(angle), math.sin(angle)])
        space = solve_impact(np.diag([2.0, 0, 0]), 0.5, (-1.0, *(0.5 * e)), law, 0.5)
        assert (space.case, space.end) == (plane.case, plane.end)
        assert space.velocity == pytest.approx((0.5, *(0.5 * e)), abs=1e-15)
        assert space.impulse == pytest.approx(
            (plane.impulse[0], *(plane.impulse[1] * e)), abs=1e-15
        )


def test_an_uncoupled_tangent_changes_no_impact():
    """Small integers: ties, ranks 0 to 3 and borders are common there."""
    compared, cases = 0, set()
    numbers = product((0, 1, 2), (-2, -1, 0, 1), (0, 1, 2), (0, 3), (0, -1), (-1, 0, 2))
    for i, (nn, nt, tt, across, v_n, v_t) in enumerate(numbers):
        if nn * tt < nt * nt:
            continue
        W = np.array([[nn, nt, 0], [nt, tt, 0], [0, 0, across]])
        for mu, e in product((0.0, 0.5, 1.0, 2.0), (0.0, 0.5, 1.0)):
            law = LAWS[(i + compared) % 3]
            plane = solve_impact(W[:2, :2], mu, (v_n, v_t), law, e)
            space = solve_impact(W, mu, (v_n, v_t, 0.0), law, e)
            assert (space.case, space.end) == (plane.case, plane.end)
            assert [p.name for p in space.phases] == [p.name for p in plane.phases]
            for own, flat in zip(space.phases, plane.phases, strict=True):
                assert own.velocity == pytest.approx((*flat.velocity, 0.0), abs=1e-13)
                assert own.impulse == pytest.approx((*flat.impulse, 0.0), abs=1e-13)
            compared += 1
            cases.add((plane.case, plane.end))
    assert compared > 2000 and len(cases) > 10


TURNS = [(0.6, 0.8), (math.cos(0.7), math.sin(0.7)), (0.0, 1.0)]


def _compare_in_turned_tangents(W, mu, velocity, law, e):
    """Compare an impact with those in turned tangents; return its class and end."""
    one = solve_impact(W, mu, velocity, law, e)
    for c, s in TURNS:
        turn = np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])
        other = solve_impact(turn @ W @ turn.T, mu, turn @ velocity, law, e)
        assert (other.case, other.end) == (one.case, one.end)
        assert [p.name for p in other.phases] == [p.name for p in one.phases]
        assert other.velocity == pytest.approx(turn @ one.velocity, abs=1e-9)
        assert other.impulse == pytest.approx(turn @ one.impulse, abs=1e-8)
    return one.case, one.end


def test_turned_tangents_change_no_impact_of_small_integers():
    """Every rank, slip of driven surfaces, ties and borders are common there."""
    rng, cases = np.random.default_rng(8), set()
    for k in range(600):
        J = rng.integers(-2, 3, size=(3, rng.integers(1, 4)))
        moves = rng.integers(-2, 3, size=J.shape[1]) if k % 3 else None
        v = rng.integers(-2, 3, size=3) if moves is None else J @ moves
        v = -v if v[0] > 0 else v
        mu, e = float(rng.choice([0, 0.5, 1, 2])), float(rng.choice([0, 0.5, 1]))
        cases.add(_compare_in_turned_tangents(J @ J.T, mu, v.astype(float), LAWS[k % 3], e))
    assert len(cases) > 10


@pytest.mark.parametrize(
    ("W", "mu", "velocity", "case", "end"),
    [
        # The slip keeps its speed: k = 0 exactly.
        ([[2, -2, 0], [-2, 2, 0], [0, 0, 1]], 1.0, (-1, -1, 0), "sliding", "jam"),
        # The edge of the cone, |W_nt| = μ W_tt.
        ([[2, -1, 0], [-1, 2, 0], [0, 0, 1]], 0.5, (-1, 0, 0), "c_sticking", "separation"),
        ([[1, 1, 0], [1, 2, 0], [0, 0, 1]], 0.5, (-1, 0, 0), "c_sticking", "separation"),
        # Slip tends to a direction in which it keeps its speed, and v_n = v_2 with it.
        ([[6, -3, 6], [-3, 2, -3], [6, -3, 6]], 1.0, (-4, 1, -4), "sliding", "jam"),
        # v_n = v_1/2 vanishes faster than the slip, which stops along -t2.
        ([[2, 4, -1], [4, 8, -2], [-1, -2, 1]], 2.0, (-2, -4, 1), "c_sticking", "jam"),
        # A driven surface: v_n tends to 0 and never reaches it.
        ([[1, -1, -1], [-1, 1, 1], [-1, 1, 1]], 1.0, (-2, 1, 2), "sliding", "jam"),
        # The slip stops where the restitution ends.
        ([[5, 0, -3], [0, 5, 4], [-3, 4, 5]], 2.0, (-1, 1, 2), "sliding", "separation"),
    ],
)
def test_borders_are_the_same_in_turned_tangents(W, mu, velocity, case, end):
    e = 1.0 if W[0][0] == 5 else 0.5
    W, velocity = np.array(W, dtype=float), np.array(velocity, dtype=float)
    assert _compare_in_turned_tangents(W, mu, velocity, "newton", e) == (case, end)


GOOD = np.eye(3).tolist()
REFUSED = {
    "opening": (GOOD, 0.5, (0.1, 1.0, 0.0), "energetic", 0.5, "need v_n <= 0"),
    "indefinite": (
        [[1, 2, 0], [2, 1, 0], [0, 0, 1]],
        0.5,
        (-1, 1, 0),
        "energetic",
        0.5,
        "definite",
    ),
    "rank two, indefinite": (
        [[1, 2, 0], [2, 1, 0], [0, 0, 0]],
        *(0.5, (-1, 1, 0), "energetic", 0.5, "semidefinite"),
    ),
    "rank two, nearly of one tangent": (
        np.outer([1, 2, 3], [1, 2, 3]) + 1e-8 * np.outer([1, 0, 1], [1, 0, 1]),
        *(0.5, (-1, 1, 0), "energetic", 0.5, "positive definite or of rank one"),
    ),
    "not symmetric": (
        [[1, 0.1, 0], [0.2, 1, 0], [0, 0, 1]],
        0.5,
        (-1, 1, 0),
        "newton",
        0.5,
        "symm",
    ),
    "nan": (GOOD, 0.5, (-1.0, 1.0, math.nan), "energetic", 0.5, "v_2: got nan, need a finite"),
    "nan in W": ([[1, 0, 0], [0, math.nan, 0], [0, 0, 1]], 0.5, (-1, 1, 0), "newton", 0.5, "W_11"),
    "velocity of two": (GOOD, 0.5, (-1.0, 1.0), "energetic", 0.5, r"shape \(3, 3\)"),
    "ragged": (
        [[1, 0, 0], [0, 1], [0, 0, 1]],
        0.5,
        (-1, 1, 0),
        "energetic",
        0.5,
        "check the shapes",
    ),
    "four": (np.eye(4), 0.5, (-1, 1, 0, 0), "energetic", 0.5, "check the shapes"),
}


@pytest.mark.parametrize("case", sorted(REFUSED))
def test_impact_in_space_refuses_what_it_cannot_use(case):
    *arguments, text = REFUSED[case]
    with pytest.raises(InputError, match=text):
        solve_impact(*arguments)


def test_invariant_directions_refuse_what_they_cannot_use():
    with pytest.raises(InputError, match=r"^invariant directions: mu: got -1.0, need mu >= 0"):
        invariant_directions(GOOD, -1.0)
    with pytest.raises(InputError, match=r"^invariant directions: .*need a matrix of 3"):
        invariant_directions(np.eye(2), 1.0)
