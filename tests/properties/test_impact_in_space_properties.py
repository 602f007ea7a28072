"""Properties of every impact of one contact in space: rotation, mirror, units, the plane in it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from painleve_sym.laws.restitution import RESTITUTIONS
from painleve_sym.problem.impact.one_contact import ImpactEnd, solve_impact
from painleve_sym.problem.modes import ContactMode

LAW = st.sampled_from(sorted(RESTITUTIONS))
RESTITUTION = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.01, 1.0))
FRICTION = st.one_of(st.just(0.0), st.floats(0.01, 4.0))
NORMAL = st.one_of(st.just(0.0), st.floats(-5.0, -0.01))
ANGLE = st.floats(0.0, 2 * math.pi)
SPEED = st.one_of(st.just(0.0), st.floats(0.01, 5.0))


@st.composite
def mobilities(draw):
    """Draw a positive definite W of condition below 1e4."""
    entry = st.floats(-1.0, 1.0)
    J = np.array([[draw(entry) for _ in range(3)] for _ in range(3)])
    W = J @ J.T + draw(st.floats(0.01, 1.0)) * np.eye(3)
    assume(np.linalg.cond(W) < 1e4)
    return W


def _same(one, other, turn=None, tolerance=1e-9):
    """Compare two impacts, the tangential directions of the first turned."""
    turn = np.eye(2) if turn is None else turn
    size = 1 + math.hypot(*one.velocity_before) + math.hypot(*one.impulse)

    def turned(values):
        return np.array([values[0], *(turn @ values[1:])])

    assert other.velocity == pytest.approx(turned(one.velocity), abs=tolerance * size)
    assert other.impulse == pytest.approx(turned(one.impulse), abs=tolerance * size)
    assert other.energy_change == pytest.approx(one.energy_change, abs=tolerance * size**2)


@given(W=mobilities(), mu=FRICTION, v_n=NORMAL, v=SPEED, angle=ANGLE, law=LAW, e=RESTITUTION)
@settings(max_examples=80)
def test_impact_obeys_its_laws(W, mu, v_n, v, angle, law, e):
    velocity = (v_n, v * math.cos(angle), v * math.sin(angle))
    impact = solve_impact(W, mu, velocity, law, e)
    assert impact.end is not ImpactEnd.JAM
    at, size = np.array(velocity), 10 + math.hypot(*velocity) + math.hypot(*impact.impulse)
    for phase in impact.phases:
        P_n, *P_t = phase.impulse
        at = at + W @ phase.impulse
        assert at == pytest.approx(phase.velocity, abs=1e-12 * size)
        assert P_n >= 0 and phase.tangential_work <= 0
        assert math.hypot(*P_t) <= mu * P_n * (1 + 1e-12) + 1e-15 * size
        if phase.mode is ContactMode.STICK:
            assert phase.velocity[1:] == (0.0, 0.0)
        at = np.array(phase.velocity)
    before, after = (np.array(v) @ np.linalg.solve(W, v) / 2 for v in (velocity, impact.velocity))
    assert impact.energy_change == pytest.approx(after - before, abs=1e-10 * size**2)
    if law != "newton":
        assert impact.energy_change <= 1e-12 * size**2
    assert impact.velocity[0] >= 0


@given(
    W=mobilities(),
    mu=FRICTION,
    v_n=NORMAL,
    v=SPEED,
    angle=ANGLE,
    turn=ANGLE,
    mirrored=st.booleans(),
)
@settings(max_examples=80)
def test_impact_does_not_depend_on_the_tangential_axes(W, mu, v_n, v, angle, turn, mirrored):
    c, s = math.cos(turn), math.sin(turn)
    Q = np.array([[c, -s], [s, c]]) @ np.diag([1.0, -1.0 if mirrored else 1.0])
    whole = np.eye(3)
    whole[1:, 1:] = Q
    velocity = np.array([v_n, v * math.cos(angle), v * math.sin(angle)])
    one = solve_impact(W, mu, velocity, "energetic", 0.7)
    other = solve_impact(whole @ W @ whole.T, mu, whole @ velocity, "energetic", 0.7)
    # Whether an impact without collision begins may hang on the rounding of A = 0.
    assume((one.phases == ()) == (other.phases == ()))
    _same(one, other, Q)


@given(
    W=mobilities(),
    mu=FRICTION,
    v_n=NORMAL,
    v=SPEED,
    angle=ANGLE,
    law=LAW,
    e=RESTITUTION,
    mass=st.floats(1e-6, 1e6),
    speed=st.floats(1e-6, 1e6),
)
@settings(max_examples=80)
def test_impact_does_not_depend_on_units(W, mu, v_n, v, angle, law, e, mass, speed):
    velocity = np.array([v_n, v * math.cos(angle), v * math.sin(angle)])
    one = solve_impact(W, mu, velocity, law, e)
    other = solve_impact(W / mass, mu, velocity * speed, law, e)
    assume([p.name for p in one.phases] == [p.name for p in other.phases])
    size = 1 + math.hypot(*velocity) + math.hypot(*one.impulse)
    assert np.array(other.velocity) / speed == pytest.approx(one.velocity, abs=1e-10 * size)
    scaled = np.array(other.impulse) / speed / mass
    assert scaled == pytest.approx(one.impulse, abs=1e-10 * size)


@given(
    W=mobilities(),
    beside=st.floats(0.05, 5.0),
    mu=FRICTION,
    v_n=NORMAL,
    v=st.one_of(SPEED, st.floats(-5.0, -0.01)),
    law=LAW,
    e=RESTITUTION,
    across=st.booleans(),
)
@settings(max_examples=80)
def test_impact_in_a_plane_of_symmetry_is_that_of_the_plane(W, beside, mu, v_n, v, law, e, across):
    plane = W[:2, :2]
    space, own, other = np.diag([0.0, beside, beside]), (2 if across else 1), (1 if across else 2)
    rows = [0, own]
    space[np.ix_(rows, rows)] = plane
    velocity = np.zeros(3)
    velocity[0], velocity[own] = v_n, v
    one, two = solve_impact(plane, mu, (v_n, v), law, e), solve_impact(space, mu, velocity, law, e)
    assert (one.case, one.end) == (two.case, two.end)
    assert [p.name for p in one.phases] == [p.name for p in two.phases]
    size = 10 + math.hypot(v_n, v) + math.hypot(*one.impulse)
    for in_plane, phase in zip(one.phases, two.phases, strict=True):
        assert np.array(phase.velocity)[rows] == pytest.approx(in_plane.velocity, abs=1e-13 * size)
        assert np.array(phase.impulse)[rows] == pytest.approx(in_plane.impulse, abs=1e-13 * size)
        assert abs(phase.velocity[other]) <= 1e-14 * size
        assert phase.normal_work == pytest.approx(in_plane.normal_work, abs=1e-13 * size**2)
        assert phase.direction[own - 1] == pytest.approx(in_plane.direction[0], abs=1e-15)
