"""The complete impact in numbers: known solutions, independent oracles, borders, errors."""

from __future__ import annotations

import json
import math
import time

import numpy as np
import pytest

from painleve_sym.errors import InputError
from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.mechanics.impact.impact_class import CLASSES, ImpactClass
from painleve_sym.problem.impact.one_contact import ImpactEnd, solve_impact
from painleve_sym.problem.modes import ContactMode

LAWS = sorted(RESTITUTIONS)
W = ((1.0, 0.6), (0.6, 1.0))

CASES = {
    # name: (W, mu, velocity, class)
    "slides": (W, 0.2, (-1.0, 3.0), ImpactClass.SLIDING),
    "slides faster": (W, 0.2, (-1.0, 1.0), ImpactClass.SLIDING),
    "sticks in compression": (W, 0.8, (-1.0, 0.1), ImpactClass.C_STICKING),
    "sticks without collision": (W, 2.0, (0.0, 1.0), ImpactClass.C_STICKING),
    "sticks in the paradox": (W, 2.0, (-0.4, 1.0), ImpactClass.C_STICKING),
    "reverses in compression": (W, 0.3, (-1.0, -0.4), ImpactClass.C_REVERSED),
    "sticks in restitution": (W, 0.8, (-1.0, -1.3), ImpactClass.R_STICKING),
    "reverses in restitution": (W, 0.3, (-1.0, -0.9), ImpactClass.R_REVERSED),
    "starts at rest, sticks": (W, 0.8, (-1.0, 0.0), ImpactClass.C_STICKING),
    "starts at rest, slips": (W, 0.3, (-1.0, 0.0), ImpactClass.SLIDING),
    "no friction": (W, 0.0, (-1.0, -0.5), ImpactClass.C_REVERSED),
    "central": (((1.0, 0.0), (0.0, 3.5)), 0.3, (-1.0, 1.0), ImpactClass.C_STICKING),
}


@pytest.fixture(params=LAWS)
def rule(request):
    return request.param


def _stepped(matrix, mu, velocity, rule, e, step):
    """Follow the impact by small implicit steps of the impulse; it knows no rays and no events.

    Each step takes the friction in the cone that stops the slip, or comes nearest to it.
    """
    (W_nn, W_nt), (_, W_tt) = matrix
    v_n, v_t = velocity
    impulse = work = compressed = stored = 0.0
    in_compression = True
    while True:
        ratio = min(mu, max(-mu, -(v_t / step + W_nt) / W_tt))
        v_t += step * (W_nt + ratio * W_tt)
        before, v_n = v_n, v_n + step * (W_nn + ratio * W_nt)
        impulse, work = impulse + step, work + step * (before + v_n) / 2
        if in_compression and v_n >= 0:
            in_compression, compressed, stored = False, impulse, -work
        if not in_compression:
            done = {
                "newton": v_n >= -e * velocity[0],
                "poisson": impulse - compressed >= e * compressed,
                "energetic": work + stored >= e**2 * stored,
            }
            if done[rule]:
                return v_t, v_n, impulse


@pytest.mark.parametrize("name", sorted(CASES))
def test_impact_agrees_with_small_steps_of_the_impulse(name, rule):
    matrix, mu, velocity, case = CASES[name]
    impact = solve_impact(matrix, mu, velocity, rule, 0.7)
    assert impact.case is case
    assert impact.end is not ImpactEnd.JAM
    step = impact.normal_impulse / 5000
    v_t, v_n, impulse = _stepped(matrix, mu, velocity, rule, 0.7, step)
    # A step decides too late by at most itself, at each of the three break points.
    assert impact.velocity == pytest.approx((v_n, v_t), abs=10 * step * (1 + mu))
    assert impact.normal_impulse == pytest.approx(impulse, rel=2e-3)


def test_impact_cases_cover_every_class():
    assert {case for *_, case in CASES.values()} == set(CLASSES)


@pytest.mark.parametrize("name", sorted(CASES))
def test_impact_balances_momentum_energy_and_the_law(name, rule):
    matrix, mu, velocity, _ = CASES[name]
    e = 0.6
    impact = solve_impact(np.array(matrix), mu, velocity, rule, e)
    change = np.array(matrix) @ impact.impulse
    assert np.array(impact.velocity) - velocity == pytest.approx(change, abs=1e-14)
    before, after = (
        np.array(v) @ np.linalg.solve(matrix, v) / 2 for v in (velocity, impact.velocity)
    )
    assert impact.energy_change == pytest.approx(after - before, abs=1e-14)
    ended = [i for i, p in enumerate(impact.phases) if p.name.endswith("compression")][-1]
    compression, restitution = impact.phases[: ended + 1], impact.phases[ended + 1 :]
    assert compression[-1].velocity[0] == 0.0
    if rule == "poisson":
        impulses = [
            math.fsum(p.normal_impulse for p in part) for part in (compression, restitution)
        ]
        assert impulses[1] == pytest.approx(e * impulses[0], rel=1e-14)
    elif rule == "energetic":
        works = [math.fsum(p.normal_work for p in part) for part in (compression, restitution)]
        assert works[1] == pytest.approx(-(e**2) * works[0], rel=1e-14)
    else:
        assert impact.velocity[0] == pytest.approx(-e * velocity[0], rel=1e-14, abs=0)


def test_impact_of_a_ball_stops_slipping_at_the_textbook_speed():
    # A solid sphere: W_tt = 7/(2m), W_nn = 1/m. It rolls after the impact iff
    # |v_t| ≤ (7/2) μ (1 + e) |v_n|, by any law.
    mass, mu, e = 0.4, 0.2, 0.8
    ball = ((1 / mass, 0.0), (0.0, 3.5 / mass))
    border = 3.5 * mu * (1 + e)
    for rule in LAWS:
        rolls = solve_impact(ball, mu, (-1.0, 0.99 * border), rule, e)
        slides = solve_impact(ball, mu, (-1.0, 1.01 * border), rule, e)
        assert rolls.case is ImpactClass.R_STICKING
        assert rolls.velocity == (pytest.approx(e, rel=1e-14), 0.0)
        assert slides.case is ImpactClass.SLIDING
        assert slides.velocity == pytest.approx((e, 0.01 * border), rel=1e-12)
        assert rolls.tangential_impulse[0] == pytest.approx(-0.99 * border * mass / 3.5, rel=1e-13)


@pytest.mark.parametrize("sign", [-1, 1])
def test_impact_slip_that_begins_has_the_sign_of_the_coupling(sign):
    matrix = ((1.0, 0.6 * sign), (0.6 * sign, 1.0))
    for v_t in (0.0, -0.4 * sign):
        impact = solve_impact(matrix, 0.3, (-1.0, v_t))
        assert math.copysign(1, impact.velocity[1]) == sign
        mode = ContactMode.SLIP_POS if sign > 0 else ContactMode.SLIP_NEG
        assert impact.phases[-1].mode is mode


def test_impact_on_the_edge_of_the_cone_sticks():
    impact = solve_impact(W, 0.6, (-1.0, -0.1))
    assert impact.case is ImpactClass.C_STICKING
    assert impact.velocity[1] == 0.0


def test_impact_newton_gives_nothing_back_without_collision():
    for e in (0.3, 1.0):
        impact = solve_impact(W, 2.0, (0.0, 1.0), "newton", e)
        assert impact.without_collision
        assert impact.end is ImpactEnd.PERSISTENT
        assert impact.velocity == (0.0, 0.0)
        assert impact.phases[-1].normal_impulse == 0.0
    for rule in ("poisson", "energetic"):
        impact = solve_impact(W, 2.0, (0.0, 1.0), rule, 0.3)
        assert impact.end is ImpactEnd.SEPARATION
        assert impact.velocity[0] > 0


@pytest.mark.parametrize(
    ("mu", "velocity"),
    [(1.0, (0.0, 1.0)), (2.0, (0.0, -1.0)), (2.0, (0.0, 0.0)), (0.3, (0.0, 0.0))],
    ids=["A > 0", "A > 0 the other way", "at rest", "at rest, would slip"],
)
def test_impact_that_is_none_says_so(mu, velocity, rule):
    impact = solve_impact(W, mu, velocity, rule, 0.5)
    assert impact.case is ImpactClass.NO_IMPACT
    assert impact.end is ImpactEnd.PERSISTENT
    assert (impact.phases, impact.velocity, impact.energy_change) == ((), velocity, 0.0)
    assert not impact.without_collision


def test_impact_on_the_border_of_the_paradox_stops_the_slip_at_once(rule):
    # A = 0: v_n stays 0 until the slip stops at P_n = −v_t/C_s, C_s = W_nt − μ W_tt = 0.1 − 3.
    # W_nn = μ W_nt in exact numbers; 0.1 · 3 rounds up, so that A = −5.6e-17.
    matrix = ((0.3, 0.1), (0.1, 1.0))
    assert 0.3 - 3.0 * 0.1 < 0
    e = 0.5
    impact = solve_impact(matrix, 3.0, (0.0, 1.0), rule, e)
    stops = 1.0 / 2.9
    assert (impact.case, impact.without_collision) == (ImpactClass.C_STICKING, True)
    first, second, _ = impact.phases
    assert first.normal_impulse == pytest.approx(stops, rel=1e-14)
    assert first.velocity == second.velocity == (0.0, 0.0)
    assert second.normal_impulse == 0.0
    # Nothing is stored; Poisson's law alone gives back e P_c, along A′ = 0.3 − 0.01.
    rebound = 0.29 * e * stops if rule == "poisson" else 0.0
    assert impact.velocity == (pytest.approx(rebound, rel=1e-13), 0.0)
    assert impact.end is (ImpactEnd.SEPARATION if rebound else ImpactEnd.PERSISTENT)


@pytest.mark.parametrize("beyond", [1e-15, 1e-12, 1e-9, 1e-6])
def test_impact_without_collision_is_continuous_as_A_comes_up_to_0(beyond, rule):
    matrix = ((0.3, 0.1), (0.1, 1.0))
    border = solve_impact(matrix, 3.0, (0.0, 1.0), rule, 0.5)
    near = solve_impact(matrix, 3.0 * (1 + beyond), (0.0, 1.0), rule, 0.5)
    assert near.normal_impulse == pytest.approx(border.normal_impulse, rel=10 * math.sqrt(beyond))
    # The energetic rebound grows like the root of −A.
    assert near.velocity == pytest.approx(border.velocity, abs=math.sqrt(beyond) + 1e-14)
    assert near.energy_change == pytest.approx(border.energy_change, abs=10 * beyond + 1e-14)


@pytest.mark.parametrize("v_n", [-1e-300, -1e-9])
def test_impact_that_grazes_tends_to_the_one_without_collision(v_n, rule):
    limit = solve_impact(W, 2.0, (0.0, 1.0), rule, 0.5)
    graze = solve_impact(W, 2.0, (v_n, 1.0), rule, 0.5)
    assert graze.case is ImpactClass.C_STICKING
    assert graze.velocity == pytest.approx(limit.velocity, abs=1e-8)


def test_impact_whose_slip_stops_with_the_compression_has_an_empty_phase(rule):
    # Slip along A = 1 + 0.3·0.6, C = 0.6 + 0.3: both velocities vanish at P = 1/1.18.
    mu, rate = 0.3, 1 + 0.3 * 0.6
    velocity = (-1.0, -(0.6 + 0.3) / rate)
    impact = solve_impact(W, mu, velocity, rule, 0.5)
    assert [p.name for p in impact.phases] == [
        "tangential",
        "reverse slip compression",
        "reverse slip restitution",
    ]
    assert impact.phases[0].velocity == (0.0, 0.0)
    assert impact.phases[1].normal_impulse == 0.0
    for shift in (-1e-9, 1e-9):
        near = solve_impact(W, mu, (-1.0, velocity[1] + shift), rule, 0.5)
        assert near.velocity == pytest.approx(impact.velocity, abs=1e-7)


# ---- rank one: struts ----

STRUT = ((1.0, 1.0), (1.0, 1.0))


def test_impact_strut_dragged_into_the_ground_jams(rule):
    # One degree of freedom on a moving belt: W_nt² = W_nn W_tt, and A = 1 − 1.5 < 0.
    impact = solve_impact(STRUT, 1.5, (0.0, 1.0), rule, 0.5)
    assert impact.end is ImpactEnd.JAM
    assert impact.case is ImpactClass.C_STICKING
    assert [p.name for p in impact.phases] == ["tangential"]
    assert impact.velocity == (-1.0, 0.0)
    assert json.loads(json.dumps(impact.to_dict()))["end"] == "jam"


def test_impact_strut_on_a_belt_at_its_own_speed_jams_at_once(rule):
    impact = solve_impact(STRUT, 1.5, (-1.0, 0.0), rule, 0.5)
    assert (impact.end, impact.phases, impact.velocity) == (ImpactEnd.JAM, (), (-1.0, 0.0))


def test_impact_strut_on_firm_ground_wedges():
    # v is along W's column, so that both velocities vanish together; sticking then moves nothing.
    matrix, velocity = ((1.0, -1.0), (-1.0, 1.0)), (-1.0, 1.0)
    for rule, e, end in (
        ("energetic", 0.5, ImpactEnd.JAM),
        ("newton", 0.5, ImpactEnd.JAM),
        ("poisson", 0.5, ImpactEnd.PERSISTENT),
        ("energetic", 0.0, ImpactEnd.PERSISTENT),
        ("newton", 0.0, ImpactEnd.PERSISTENT),
    ):
        impact = solve_impact(matrix, 1.5, velocity, rule, e)
        assert (impact.end, impact.velocity) == (end, (0.0, 0.0)), rule


def test_impact_strut_that_friction_cannot_hold_leaves(rule):
    matrix, velocity = ((1.0, -1.0), (-1.0, 1.0)), (-1.0, 1.0)
    impact = solve_impact(matrix, 0.5, velocity, rule, 0.5)
    assert impact.case is ImpactClass.C_REVERSED
    assert impact.end is ImpactEnd.SEPARATION
    assert impact.velocity[1] == -impact.velocity[0] < 0


def test_impact_strut_that_sticks_in_restitution_keeps_its_rebound():
    # dv_n/dP_n = 0 in sticking: v_n stays, and only Newton's law may ask for more.
    for rule in ("poisson", "energetic"):
        impact = solve_impact(STRUT, 1.5, (-1.0, -1.5), rule, 0.9)
        assert impact.case is ImpactClass.R_STICKING
        assert impact.velocity == (impact.phases[1].velocity[0], 0.0)
        assert impact.end is ImpactEnd.SEPARATION
    assert solve_impact(STRUT, 1.5, (-1.0, -1.5), "newton", 0.9).end is ImpactEnd.JAM


def test_impact_that_nothing_can_stop_jams():
    for v_t in (0.0, 1.0):
        impact = solve_impact(((0.0, 0.0), (0.0, 1.0)), 0.5, (-1.0, v_t))
        assert (impact.end, impact.velocity) == (ImpactEnd.JAM, (-1.0, 0.0))
    assert solve_impact(((0.0, 0.0), (0.0, 0.0)), 0.5, (-1.0, 1.0)).end is ImpactEnd.JAM


def test_impact_of_a_contact_that_cannot_slip_differently_bounces(rule):
    # W_tt = 0: no tangential force changes the slip.
    for v_t in (0.0, 1.0):
        impact = solve_impact(((2.0, 0.0), (0.0, 0.0)), 0.5, (-1.0, v_t), rule, 0.5)
        assert impact.velocity == (pytest.approx(0.5), v_t)


# ---- rejected input and extremes ----

REFUSED = {
    "opening": (W, 0.5, (0.1, 1.0), "energetic", 0.5, "need v_n <= 0"),
    "e above": (W, 0.5, (-1.0, 1.0), "energetic", 1.1, "need 0 <= e <= 1"),
    "e below": (W, 0.5, (-1.0, 1.0), "energetic", -0.1, "need 0 <= e <= 1"),
    "mu": (W, -0.5, (-1.0, 1.0), "energetic", 0.5, "need mu >= 0"),
    "indefinite": (((1, 2), (2, 1)), 0.5, (-1.0, 1.0), "energetic", 0.5, "semidefinite"),
    "negative": (((-1, 0), (0, 1)), 0.5, (-1.0, 1.0), "energetic", 0.5, "semidefinite"),
    "not symmetric": (((1, 0.1), (0.2, 1)), 0.5, (-1.0, 1.0), "energetic", 0.5, "symmetric"),
    "nan": (W, math.nan, (-1.0, 1.0), "energetic", 0.5, "mu: got nan, need a finite"),
    "inf": (W, 0.5, (-1.0, math.inf), "energetic", 0.5, "v_t: got inf, need a finite"),
    "nan e": (W, 0.5, (-1.0, 1.0), "energetic", math.nan, "e: got nan"),
    "law": (W, 0.5, (-1.0, 1.0), "poison", 0.5, "Did you mean 'poisson'"),
    "shape": ((1, 2, 3), 0.5, (-1.0, 1.0), "energetic", 0.5, "shape"),
    "text": (W, "much", (-1.0, 1.0), "energetic", 0.5, "need numbers"),
    "too fast": (W, 0.5, (-1e100, 1e101), "energetic", 0.5, "v_t: got 1e.101.*at most 1e.100"),
}


@pytest.mark.parametrize("case", sorted(REFUSED))
def test_impact_refuses_what_it_cannot_use(case):
    *arguments, text = REFUSED[case]
    with pytest.raises(InputError, match=text):
        solve_impact(*arguments)


def test_impact_names_every_fault_at_once():
    with pytest.raises(InputError) as caught:
        solve_impact(W, -1.0, (1.0, 0.0), "newtons", 2.0)
    for text in ("mu:", "v_n:", "e:", "Did you mean 'newton'"):
        assert text in str(caught.value)


def test_impact_knows_the_laws_of_the_package():
    for name in RESTITUTIONS:
        assert solve_impact(W, 0.5, (-1.0, 1.0), name, 0.5).restitution == name


def test_impact_takes_microseconds():
    start = time.process_time()
    for _ in range(1000):
        solve_impact(W, 0.3, (-1.0, -0.9), "energetic", 0.7)
    # It takes 35 μs each; the bound only catches a solution that iterates or derives.
    assert time.process_time() - start < 0.5
