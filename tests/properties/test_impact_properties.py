"""Properties of every planar impact of one contact, and of its closed forms."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from painleve_sym.laws.impact_cases import impact_cases
from painleve_sym.laws.restitution import RESTITUTIONS, restitution_law
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_T, raw
from painleve_sym.problem.impact.one_contact import Impact, ImpactEnd, solve_impact
from tests.mechanics.made_up import skew_block

LAWS = sorted(RESTITUTIONS)
LAW = st.sampled_from(LAWS)
RESTITUTION = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.001, 1.0))
FRICTION = st.one_of(st.just(0.0), st.floats(0.01, 4.0))
NORMAL = st.one_of(st.just(0.0), st.floats(-5.0, -0.01))
SLIP = st.one_of(st.just(0.0), st.floats(0.01, 5.0), st.floats(-5.0, -0.01))
BLOCK = skew_block()


@st.composite
def mobilities(draw, correlation=0.999):
    """Draw a positive definite W, rows and columns (n, t)."""
    W_tt, W_nn = draw(st.floats(0.1, 10.0)), draw(st.floats(0.1, 10.0))
    coupling = draw(st.floats(-correlation, correlation))
    # Weaker couplings lose digits below the smallest normal number.
    W_nt = coupling * math.sqrt(W_tt * W_nn) if abs(coupling) > 1e-100 else 0.0
    return ((W_nn, W_nt), (W_nt, W_tt))


@st.composite
def paradoxes(draw):
    """Draw W, mu and a slip with A_s < 0 and W positive definite."""
    (W_nn, W_nt), (_, W_tt) = draw(mobilities())
    assume(abs(W_nt) > 1e-3 * W_nn)
    mu = W_nn / abs(W_nt) * draw(st.floats(1 + 1e-9, 5.0))
    slip = math.copysign(draw(st.floats(0.01, 5.0)), W_nt)
    assume(W_nn - mu * abs(W_nt) < -1e-14 * W_nn)
    return ((W_nn, W_nt), (W_nt, W_tt)), mu, slip


MOBILITY = mobilities()


def _size(W, velocity) -> float:
    """Return the kinetic energy that belongs to the contact's velocity."""
    return float(np.dot(velocity, np.linalg.solve(W, velocity))) / 2


@given(W=MOBILITY, mu=FRICTION, v_t=SLIP, v_n=NORMAL, rule=LAW, e=RESTITUTION)
def test_impact_changes_velocities_by_its_impulses_in_the_cone(W, mu, v_t, v_n, rule, e):
    impact = solve_impact(W, mu, (v_n, v_t), rule, e)
    at, scale = np.array([v_n, v_t]), 10 + abs(v_t) + abs(v_n)
    for phase in impact.phases:
        impulse = np.array(phase.impulse)
        moved = at + np.array(W) @ impulse
        # Near a singular W impulses are large and cancel in the velocity.
        rounding = 1e-13 * (scale + np.abs(W).max() * np.abs(impulse).max())
        assert np.abs(moved - phase.velocity).max() <= rounding
        assert phase.normal_impulse >= 0
        limit = mu * phase.normal_impulse
        assert abs(phase.tangential_impulse[0]) <= limit * (1 + 1e-15)
        if phase.mode.value != "stick":
            assert abs(phase.tangential_impulse[0]) >= limit * (1 - 1e-15)
        assert phase.tangential_work <= 0
        at = np.array(phase.velocity)
    assert tuple(at) == impact.velocity
    assert abs(impact.tangential_impulse[0]) <= mu * impact.normal_impulse * (1 + 1e-14)


@given(W=MOBILITY, mu=FRICTION, v_t=SLIP, v_n=NORMAL, rule=LAW, e=RESTITUTION)
def test_impact_of_positive_definite_mobility_ends(W, mu, v_t, v_n, rule, e):
    impact = solve_impact(W, mu, (v_n, v_t), rule, e)
    assert impact.end is not ImpactEnd.JAM
    assert len(impact.phases) <= 3
    assert impact.velocity[0] >= 0
    assert (impact.velocity[0] > 0) == (impact.end is ImpactEnd.SEPARATION)
    if e == 0:
        assert impact.velocity[0] == 0
    elif impact.case is not ImpactClass.NO_IMPACT and (v_n < 0 or rule != "newton"):
        assert impact.end is ImpactEnd.SEPARATION


@given(
    W=MOBILITY,
    mu=FRICTION,
    v_t=SLIP,
    v_n=NORMAL,
    rule=st.sampled_from(["energetic", "poisson"]),
    e=RESTITUTION,
)
def test_impact_never_gains_energy_by_the_energetic_or_poissons_law(W, mu, v_t, v_n, rule, e):
    impact = solve_impact(W, mu, (v_n, v_t), rule, e)
    work = math.fsum(abs(w) for p in impact.phases for w in (p.normal_work, p.tangential_work))
    assert impact.energy_change <= 1e-14 * work
    if rule == "energetic":
        normal = math.fsum(p.normal_work for p in impact.phases)
        assert normal <= 1e-14 * work


@given(W=MOBILITY, mu=FRICTION, v_t=SLIP, v_n=NORMAL, rule=LAW, e=RESTITUTION)
def test_impact_of_the_mirror_image_is_the_mirrored_impact(W, mu, v_t, v_n, rule, e):
    (W_nn, W_nt), (_, W_tt) = W
    impact = solve_impact(W, mu, (v_n, v_t), rule, e)
    mirrored = solve_impact(((W_nn, -W_nt), (-W_nt, W_tt)), mu, (v_n, -v_t), rule, e)
    assert (mirrored.case, mirrored.end) == (impact.case, impact.end)
    assert mirrored.velocity == (impact.velocity[0], -impact.velocity[1])
    assert mirrored.normal_impulse == impact.normal_impulse
    assert mirrored.tangential_impulse[0] == -impact.tangential_impulse[0]
    assert mirrored.energy_change == impact.energy_change


@given(
    W=MOBILITY,
    mu=FRICTION,
    v_t=SLIP,
    v_n=NORMAL,
    rule=LAW,
    e=RESTITUTION,
    powers=st.tuples(st.integers(-60, 60), st.integers(-60, 60)),
)
def test_impact_scales_with_speed_and_mass(W, mu, v_t, v_n, rule, e, powers):
    # Powers of two leave every digit, so that the scaled impact is the same to the last bit.
    speed, mass = (2.0**p for p in powers)
    impact = solve_impact(W, mu, (v_n, v_t), rule, e)
    lighter = tuple(tuple(w / mass for w in row) for row in W)
    scaled = solve_impact(lighter, mu, (v_n * speed, v_t * speed), rule, e)
    assert scaled.case is impact.case
    assert scaled.velocity == (impact.velocity[0] * speed, impact.velocity[1] * speed)
    assert scaled.normal_impulse == impact.normal_impulse * speed * mass
    assert scaled.energy_change == impact.energy_change * speed**2 * mass


@given(W=MOBILITY, mu=FRICTION, v_t=SLIP, v_n=NORMAL, e=RESTITUTION)
def test_impact_laws_agree_on_one_ray_and_in_central_impacts(W, mu, v_t, v_n, e):
    (W_nn, _), (_, W_tt) = W
    impact = {rule: solve_impact(W, mu, (v_n, v_t), rule, e) for rule in LAWS}
    on_one_ray = len({phase.mode for f in impact.values() for phase in f.phases}) <= 1
    central = {
        rule: solve_impact(((W_nn, 0.0), (0.0, W_tt)), mu, (v_n, v_t), rule, e) for rule in LAWS
    }
    for same in [impact] * (on_one_ray or e == 0) + [central]:
        final = {rule: np.array(f.velocity) for rule, f in same.items()}
        scale = 1 + abs(v_t) + np.abs(final["newton"]).max()
        assert np.abs(final["poisson"] - final["newton"]).max() <= 1e-10 * scale
        assert np.abs(final["energetic"] - final["newton"]).max() <= 1e-10 * scale


# ---- the theorem: in the paradox an impact ends in sticking ----


@given(case=paradoxes(), v_n=NORMAL, rule=LAW, e=RESTITUTION)
def test_impact_in_the_paradox_stops_the_slip_and_ends_sticking(case, v_n, rule, e):
    # W positive definite and A_s < 0: for every v_n ≤ 0, every law and every restitution.
    W, mu, v_t = case
    _, (W_nt, W_tt) = W
    assert abs(W_nt) < mu * W_tt
    impact = solve_impact(W, mu, (v_n, v_t), rule, e)
    assert impact.case is ImpactClass.C_STICKING
    assert [p.name for p in impact.phases] == [
        "tangential",
        "sticking compression",
        "sticking restitution",
    ]
    assert impact.velocity[1] == 0.0
    assert impact.phases[0].velocity[0] <= v_n
    assert impact.without_collision == (v_n == 0)


@given(W=MOBILITY, mu=FRICTION)
def test_impact_without_collision_needs_slip(W, mu):
    assert solve_impact(W, mu, (0.0, 0.0)).case is ImpactClass.NO_IMPACT


@given(
    w=st.tuples(st.integers(-4, 4), st.integers(-4, 4)),
    mu=FRICTION,
    v_t=SLIP,
    v_n=NORMAL,
    rule=LAW,
    e=RESTITUTION,
)
def test_impact_of_rank_one_jams_where_it_sticks_in_compression(w, mu, v_t, v_n, rule, e):
    w_t, w_n = w
    W = ((w_n * w_n, w_t * w_n), (w_t * w_n, w_t * w_t))
    impact = solve_impact(W, mu, (v_n, v_t), rule, e)
    assert all(math.isfinite(p.normal_impulse) for p in impact.phases)
    if w_t == 0 or w_n == 0:
        return
    holds = abs(w_n) <= mu * abs(w_t)
    at_border = math.isclose(abs(w_n), mu * abs(w_t))
    slip = (v_t > 0) - (v_t < 0)
    if slip * w_t * w_n > 0 and w_n**2 - mu * abs(w_t * w_n) < -1e-12:
        assert holds
        assert impact.end is ImpactEnd.JAM
        assert impact.velocity[0] < 0
    # On the border of the cone no ray changes any velocity: both answers are right.
    if at_border:
        return
    if impact.end is ImpactEnd.JAM:
        assert holds
        assert impact.velocity[1] == 0
    if impact.end is not ImpactEnd.JAM and impact.case is ImpactClass.C_STICKING:
        assert impact.velocity[0] == 0  # wedged, with nothing asked back


# ---- continuity ----


@given(
    W=mobilities(correlation=0.9),
    mu=FRICTION,
    v_t=SLIP,
    v_n=st.floats(-5.0, -0.1),
    rule=LAW,
    e=RESTITUTION,
    shifts=st.tuples(*[st.sampled_from([-1.0, 0.0, 1.0])] * 6),
)
def test_impact_with_collision_is_continuous_in_everything(W, mu, v_t, v_n, rule, e, shifts):
    # The borders left out: A_s = 0 without collision, and det W = 0.
    step = 1e-9
    a, b, c, d, f, g = (step * s for s in shifts)
    (W_nn, W_nt), (_, W_tt) = W
    near = ((W_nn + a, W_nt + b), (W_nt + b, W_tt + c))
    here = solve_impact(W, mu, (v_n, v_t), rule, e)
    there = solve_impact(near, max(0.0, mu + d), (v_n, v_t + f), rule, min(1.0, max(0.0, e + g)))
    gap = np.abs(np.array(here.velocity) - there.velocity).max()
    # The energetic law takes a root: where it ends with the slip, changes go like √step.
    assert gap <= 3e-3


# ---- closed forms ----


@functools.cache
def _closed_forms(rule: str, slip: int):
    """Return, per class, a function from (m, c, d, mu, v_t, v_n, e) to its result and margins."""
    law = restitution_law(rule)
    x_dot, y_dot = BLOCK.system.q_dot
    names = {p.name: p.symbol for p in BLOCK.system.parameters}
    arguments = [*(names[n] for n in ("m", "c", "d", "mu")), V_T, V_N, law.parameter.symbol]
    functions = {}
    for case, impact in impact_cases(BLOCK.coefficients, law, slip, raw).items():
        after = [v.subs({x_dot: V_T, y_dot: V_N}) for v in impact.velocity.values()]
        impulses = [sp.Add(*(getattr(p, n) for p in impact.phases)) for n in IMPULSES]
        margins = [condition.margin for condition in impact.conditions]
        outputs = [impact.slip_velocity, impact.separation_velocity, impact.energy_change]
        functions[case] = (
            sp.lambdify(arguments, [*outputs, *after, *impulses, margins], "numpy", cse=True),
            impact.conditions,
        )
    return functions


IMPULSES = ("normal_impulse", "tangential_impulse")


def _holding(rule, slip, numbers) -> tuple[dict[ImpactClass, list[float]], float]:
    """Return the classes whose conditions hold with their results, and the smallest margin."""
    holding, smallest = {}, math.inf
    for case, (function, conditions) in _closed_forms(rule, slip).items():
        with np.errstate(all="ignore"):
            *results, margins = function(*(np.float64(n) for n in numbers))
        smallest = min([smallest, *(abs(float(m)) for m in margins if not np.isnan(m))])
        if all(k.holds(float(m)) for k, m in zip(conditions, margins, strict=True)):
            holding[case] = [float(r) for r in results]
    return holding, smallest


def _compare(actual: Impact, results: list[float], size: float) -> None:
    v_t, v_n, energy, x_dot, y_dot, normal, tangential = results
    impulse = 1e-7 * (1 + abs(normal))
    assert math.isclose(actual.velocity[1], v_t, abs_tol=1e-7)
    assert math.isclose(actual.velocity[0], v_n, abs_tol=1e-7)
    assert math.isclose(x_dot, v_t, abs_tol=1e-7)
    assert math.isclose(y_dot, v_n, abs_tol=1e-7)
    assert math.isclose(actual.energy_change, energy, abs_tol=1e-7 * (1 + size))
    assert math.isclose(actual.normal_impulse, normal, abs_tol=impulse)
    assert math.isclose(actual.tangential_impulse[0], tangential, abs_tol=impulse)


SLIDING_HITS = given(
    W=mobilities(correlation=0.95),
    mu=st.floats(0.05, 3.0),
    v_t=st.one_of(st.floats(0.01, 3.0), st.floats(-3.0, -0.01)),
    v_n=st.floats(-3.0, -0.1),
    rule=LAW,
    e=st.floats(0.05, 1.0),
)


@SLIDING_HITS
def test_impact_is_of_the_one_class_whose_closed_form_holds(W, mu, v_t, v_n, rule, e):
    _assert_one_class(W, mu, v_t, v_n, rule, e)


@pytest.mark.slow
@SLIDING_HITS
@settings(max_examples=400)
def test_each_of_many_impacts_is_of_one_class(W, mu, v_t, v_n, rule, e):
    _assert_one_class(W, mu, v_t, v_n, rule, e)


def _assert_one_class(W, mu, v_t, v_n, rule, e):
    (W_nn, W_nt), (_, W_tt) = W
    # The skew block has W_nn = 1/(m d), W_nt = −c/(m d), W_tt = (c² + d)/(m d).
    c = -W_nt / W_nn
    d = W_tt / W_nn - c * c
    holding, margin = _holding(rule, 1 if v_t > 0 else -1, (1 / (W_nn * d), c, d, mu, v_t, v_n, e))
    assume(margin > 1e-9)  # at a tie two classes hold, and are the same impact
    impact = solve_impact(W, mu, (v_n, v_t), rule, e)
    assert list(holding) == [impact.case]
    _compare(impact, holding[impact.case], _size(W, (v_n, v_t)))


@given(case=paradoxes(), rule=LAW, e=st.floats(0.05, 1.0))
def test_impact_without_collision_is_its_closed_form(case, rule, e):
    ((W_nn, W_nt), (_, W_tt)), mu, v_t = case
    c = -W_nt / W_nn
    d = W_tt / W_nn - c * c
    assume(d > 0.01 and mu < 100)
    numbers = (1 / (W_nn * d), c, d, mu, v_t, 0.0, e)
    holding, _ = _holding(rule, 1 if v_t > 0 else -1, numbers)
    impact = solve_impact(((W_nn, W_nt), (W_nt, W_tt)), mu, (0.0, v_t), rule, e)
    assert list(holding) == [ImpactClass.C_STICKING]
    _compare(impact, holding[ImpactClass.C_STICKING], _size(((W_nn, W_nt), (W_nt, W_tt)), (0, v_t)))


@given(
    W=mobilities(correlation=0.95),
    v_t=st.floats(0.01, 5.0),
    rule=LAW,
    e=RESTITUTION,
    beyond=st.sampled_from([0.0, 1e-16, 1e-14, 1e-12, 1e-10]),
)
def test_impact_without_collision_is_continuous_down_to_A_0(W, v_t, rule, e, beyond):
    (W_nn, W_nt), (_, W_tt) = W
    assume(abs(W_nt) > 1e-2 * W_nn)
    slip = math.copysign(v_t, W_nt)
    mu = W_nn / abs(W_nt)
    impact = solve_impact(W, mu * (1 + beyond), (0.0, slip), rule, e)
    if impact.case is ImpactClass.NO_IMPACT:  # the quotient is rounded down, and A > 0
        assert W_nn - mu * (1 + beyond) * abs(W_nt) > 0
        return
    assert impact.case is ImpactClass.C_STICKING
    # By hand: P_n until the slip stops, and what Poisson's law adds along A′.
    stops = v_t / (mu * W_tt - abs(W_nt))
    rebound = e * stops * (W_nn - W_nt**2 / W_tt) if rule == "poisson" else 0.0
    size = 1 + stops * (W_nn + W_tt)
    assert math.isclose(impact.velocity[0], rebound, abs_tol=1e-4 * size)
    assert impact.velocity[1] == 0.0
    assert math.isclose(impact.phases[0].normal_impulse, stops, rel_tol=1e-6)
