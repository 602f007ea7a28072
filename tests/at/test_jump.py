"""The jump in numbers: reference values, balances, the other classes of impact, rejected input."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.at.jump import evaluate_jump
from painleve_sym.errors import InputError
from painleve_sym.laws.restitution import RESTITUTIONS, restitution_law
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate, Parameter
from painleve_sym.mechanics.impact.impact_class import ImpactClass
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.mechanics.system import LagrangianSystem
from painleve_sym.problem.impact.one_contact import ImpactEnd, solve_impact
from tests.mechanics.made_up import positive, skew_block

ROD = rod()
BLOCK, BELT = skew_block(), skew_block(belt=True)
TABLE_3 = {"x_A_dot": -1.0, "theta": 1.0, "theta_dot": 1.0}
RESTITUTION = st.floats(0.0, 1.0)


def test_jump_of_table_3_has_the_reference_values():
    # Computed by hand from (14)-(21) with 50 digits; the paper gives no numbers for its rule.
    result = evaluate_jump(ROD, "energetic", TABLE_3)
    s, c, mu, e = math.sin(1.0), math.cos(1.0), 1.4, 0.75
    p_1 = 1.0 / (mu - 3 * s * c + 3 * mu * s * s)
    y_1 = (1 - 3 * mu * s * c + 3 * c * c) * p_1
    first, second, third = result.phases
    assert math.isclose(first.normal_impulse, p_1, rel_tol=1e-14)
    # A is the difference of two numbers a hundred times larger.
    assert math.isclose(first.normal_velocity, y_1, rel_tol=2e-14)
    assert math.isclose(second.normal_impulse, -(1 + 3 * s * s) / 4 * y_1, rel_tol=2e-14)
    assert math.isclose(second.velocity["theta_dot"], 1.6311032386, rel_tol=1e-10)
    assert math.isclose(result.velocity["y_A_dot"], 0.0524701479, rel_tol=1e-9)
    assert math.isclose(result.velocity["theta_dot"], 1.6098409322, rel_tol=1e-10)
    ratio = 1 - 4 / (1 + 3 * s * s) / (1 + 3 * c * (c - mu * s))
    assert math.isclose(third.normal_velocity, -e * y_1 * math.sqrt(ratio), rel_tol=1e-13)
    assert result.velocity["x_A_dot"] == 0.0
    assert (result.mechanism, result.restitution) == ("rod", "energetic")
    assert result.slip_velocity == (-1.0,)


def test_jump_is_quick_once_the_closed_forms_exist():
    evaluate_jump(ROD, "energetic", TABLE_3)
    start = time.process_time()
    evaluate_jump(ROD, "energetic", TABLE_3 | {"theta_dot": 2.0})
    # It takes 20 ms; the bound only catches closed forms that are derived again.
    assert time.process_time() - start < 0.2


def test_jump_of_the_mirrored_rod_is_the_mirrored_jump():
    mirrored = {"x_A_dot": 1.0, "theta": math.pi - 1.0, "theta_dot": -1.0}
    left, right = (evaluate_jump(ROD, "energetic", s) for s in (TABLE_3, mirrored))
    assert (left.slip_velocity, right.slip_velocity) == ((-1.0,), (1.0,))
    for a, b in zip(left.phases, right.phases, strict=True):
        # π − θ is rounded, and A is small.
        assert math.isclose(a.normal_impulse, b.normal_impulse, rel_tol=1e-12)
        assert math.isclose(a.tangential_impulse[0], -b.tangential_impulse[0], rel_tol=1e-12)
        assert math.isclose(a.velocity["theta_dot"], -b.velocity["theta_dot"], rel_tol=1e-12)
        assert math.isclose(a.velocity["y_A_dot"], b.velocity["y_A_dot"], abs_tol=1e-13)


@st.composite
def rod_impacts(draw):
    """Draw rods in the paradox (A < 0), with or without an approach velocity."""
    theta = draw(st.floats(0.7, 1.35))
    tangent = math.tan(theta)
    mu = (4 + tangent**2) / (3 * tangent) * draw(st.floats(1.01, 2.0))
    state = {
        "theta": theta,
        "theta_dot": draw(st.floats(-5.0, 5.0)),
        "x_A_dot": -draw(st.floats(0.01, 10.0)),
        "y_A_dot": -draw(st.one_of(st.just(0.0), st.floats(0.01, 3.0))),
    }
    parameters = {"mu": mu, "m": draw(st.floats(0.1, 10.0)), "l": draw(st.floats(0.1, 5.0))}
    return ROD, state, parameters


@st.composite
def block_impacts(draw):
    """Draw blocks with any coupling for which the three phases hold."""
    s = draw(st.sampled_from([-1.0, 1.0]))
    mu, d = draw(st.floats(1.0, 2.5)), draw(st.floats(0.1, 2.0))
    # A_s = (1 + μ s c)/(m d) < 0, and |c| ≤ μ (c² + d), so that sticking holds.
    c = -s * (1 / mu) * draw(st.floats(1.05, 4.0))
    d = max(d, abs(c) / mu - c * c)
    state = {"x_dot": s * draw(st.floats(0.1, 5.0)), "y_dot": -draw(st.floats(0.0, 2.0))}
    return BLOCK, state, {"mu": mu, "c": c, "d": d * 1.01, "m": draw(st.floats(0.2, 5.0))}


IMPACTS = st.one_of(rod_impacts(), block_impacts())


def _numbers(mechanism, state, parameters):
    """Return M, J_N, J_T and q̇ before, by name of symbol."""
    system = mechanism.system
    values = {p.symbol: parameters.get(p.name, p.default) for p in system.parameters}
    values |= {s: state.get(s.name, 0.0) for s in (*system.q, *system.q_dot)}
    matrices = (system.mass_matrix, mechanism.contact.J_N, mechanism.contact.J_T)
    arrays = [np.array(m.subs(values), dtype=float) for m in matrices]
    return *arrays, np.array([values[v] for v in system.q_dot])


@settings(max_examples=25)
@given(impact=IMPACTS, e=RESTITUTION)
def test_jump_ends_sticking_with_the_velocity_of_the_law(impact, e):
    mechanism, state, parameters = impact
    result = evaluate_jump(
        mechanism, "energetic", state, parameters={**parameters, "e_energetic": e}
    )
    *_, J_N, J_T, _ = _numbers(mechanism, state, parameters)
    q_dot = np.array(list(result.velocity.values()))
    scale = max(abs(v) for v in state.values())
    assert abs((J_T @ q_dot).item()) <= 1e-12 * scale
    first, second, third = result.phases
    # The velocity jumps are differences of the terms that make up A.
    assert math.isclose((J_N @ q_dot).item(), third.normal_velocity, abs_tol=1e-11 * scale)
    stored = first.stored_energy + second.stored_energy
    assert math.isclose(third.stored_energy, -(e**2) * stored, rel_tol=1e-9, abs_tol=1e-300)
    assert third.normal_velocity >= 0


@settings(max_examples=25)
@given(impact=IMPACTS, e=RESTITUTION)
def test_jump_never_adds_energy(impact, e):
    mechanism, state, parameters = impact
    result = evaluate_jump(
        mechanism, "energetic", state, parameters={**parameters, "e_energetic": e}
    )
    assert result.energy_change <= 0
    mass, _, _, before = _numbers(mechanism, state, parameters)
    after = np.array(list(result.velocity.values()))
    kinetic = [v @ mass @ v / 2 for v in (before, after)]
    change = kinetic[1] - kinetic[0]
    assert math.isclose(result.energy_change, change, abs_tol=1e-10 * (1 + max(kinetic)))


@settings(max_examples=25)
@given(impact=IMPACTS, e=RESTITUTION, law=st.sampled_from(sorted(RESTITUTIONS)))
def test_jump_balances_momentum_in_every_phase(impact, e, law):
    mechanism, state, parameters = impact
    result = evaluate_jump(mechanism, law, state, parameters={**parameters, f"e_{law}": e})
    mass, J_N, J_T, before = _numbers(mechanism, state, parameters)
    for phase in result.phases:
        after = np.array(list(phase.velocity.values()))
        impulse = J_N[0] * phase.normal_impulse + J_T[0] * phase.tangential_impulse[0]
        size = 1 + np.abs(mass).max() * (np.abs(after).max() + np.abs(before).max())
        np.testing.assert_allclose(mass @ (after - before), impulse, atol=1e-11 * size)
        assert phase.normal_impulse >= 0
        # Friction stays in its cone, on its edge while it slips.
        limit = parameters.get("mu", 1.5) * phase.normal_impulse
        assert abs(phase.tangential_impulse[0]) <= limit * (1 + 1e-12)
        before = after


def test_jump_without_restitution_stops_the_contact():
    result = evaluate_jump(ROD, "energetic", TABLE_3, parameters={"e_energetic": 0.0})
    last = result.phases[-1]
    assert (last.normal_impulse, last.normal_velocity, last.stored_energy) == (0.0, 0.0, 0.0)
    assert result.velocity == result.phases[1].velocity


def test_jump_on_the_border_of_the_paradox_stops_the_slip_at_once():
    # A = (1 − μ/2)/(m d) = 0 at μ = 2, c = 0.5; v_n stays 0 all the way.
    result = evaluate_jump(BLOCK, "energetic", {"x_dot": -1.0}, parameters={"c": 0.5, "mu": 2.0})
    assert result.case is ImpactClass.C_STICKING and result.end is ImpactEnd.PERSISTENT
    assert result.velocity == {"x_dot": 0.0, "y_dot": 0.0}
    near = evaluate_jump(
        BLOCK, "energetic", {"x_dot": -1.0}, parameters={"c": 0.5, "mu": 2.0 + 1e-9}
    )
    impulse = near.phases[0].normal_impulse
    assert result.phases[0].normal_impulse == pytest.approx(impulse, rel=1e-8)


def test_jump_newton_gives_no_rebound_without_collision():
    result = evaluate_jump(ROD, "newton", TABLE_3)
    assert result.phases[-1].normal_velocity == 0.0
    hit = evaluate_jump(ROD, "newton", TABLE_3 | {"y_A_dot": -0.2}, parameters={"e_newton": 0.5})
    assert math.isclose(hit.velocity["y_A_dot"], 0.1, rel_tol=1e-13)


def test_jump_on_a_belt_stops_relative_to_the_belt():
    parameters = {"c": 0.8, "u": 0.3, "mu": 1.5}
    state = {"x_dot": -1.0, "y_dot": 0.0}
    result = evaluate_jump(BELT, "energetic", state, parameters=parameters)
    assert math.isclose(result.velocity["x_dot"], 0.3, rel_tol=1e-14)
    # Seen from the belt it is the jump of a block at rest ground, 1.3 m/s fast.
    still = evaluate_jump(BLOCK, "energetic", {"x_dot": -1.3}, parameters={"c": 0.8, "mu": 1.5})
    assert math.isclose(result.energy_change, still.energy_change, rel_tol=1e-13)
    assert math.isclose(result.velocity["y_dot"], still.velocity["y_dot"], rel_tol=1e-13)


REFUSED = {
    "opening": (ROD, TABLE_3 | {"y_A_dot": 0.1}, {}, r"v_n = 0.1 m/s, need v_n <= 0"),
    "at rest": (ROD, TABLE_3 | {"x_A_dot": 0.0}, {}, "v_t = 0 and v_n = 0, need a moving"),
    "slides on": (ROD, TABLE_3 | {"theta": 0.5}, {}, "case 1 of the paper"),
    "lifts off": (ROD, TABLE_3 | {"theta": 0.5, "theta_dot": 5.0}, {}, "case 2 of the paper"),
    "other slip direction": (ROD, TABLE_3 | {"x_A_dot": 1.0}, {}, "case 1 of the paper"),
    "grazes": (BLOCK, {"x_dot": 1.0}, {"g": 0.0}, "grazes"),
    "unknown state": (ROD, {"thet": 1.0}, {}, "Did you mean 'theta'"),
    "unknown parameter": (ROD, TABLE_3, {"e_newton": 0.5}, "unknown parameter 'e_newton'"),
    "bad parameter": (ROD, TABLE_3, {"e_energetic": 1.5}, "0 <= e_energetic <= 1"),
    "not a number": (ROD, TABLE_3 | {"theta": math.nan}, {}, "need a finite number"),
    "outside": (ROD, TABLE_3 | {"theta": 4.0}, {}, "lies flat at theta = pi"),
}


@pytest.mark.parametrize("case", sorted(REFUSED))
def test_jump_refuses_what_is_not_an_impact(case):
    mechanism, state, parameters, text = REFUSED[case]
    with pytest.raises(InputError, match=text) as caught:
        evaluate_jump(mechanism, "energetic", state, parameters=parameters)
    assert mechanism.name in str(caught.value)


OTHERS = {
    "slip continues": (
        ROD,
        {"theta": 0.2, "x_A_dot": -1.0, "y_A_dot": -1.0},
        {"mu": 0.2},
        ImpactClass.SLIDING,
    ),
    "compression ends first": (
        ROD,
        {"theta": 0.9, "x_A_dot": -1.1, "y_A_dot": -1.0},
        {"mu": 0.8},
        ImpactClass.R_STICKING,
    ),
    "slips back": (
        BLOCK,
        {"x_dot": 0.1, "y_dot": -1.0},
        {"c": 1.0, "d": 0.01, "mu": 0.5},
        ImpactClass.C_REVERSED,
    ),
    "slips back late": (
        ROD,
        {"theta": 0.5, "x_A_dot": 0.75, "y_A_dot": -1.0},
        {"mu": 0.3},
        ImpactClass.R_REVERSED,
    ),
    "starts at rest": (ROD, {"theta": 1.0, "y_A_dot": -1.0}, {}, ImpactClass.C_STICKING),
    "slips from rest": (ROD, {"theta": 0.5, "y_A_dot": -1.0}, {"mu": 0.3}, ImpactClass.SLIDING),
    "on a belt": (
        BELT,
        {"x_dot": 0.4, "y_dot": -1.0},
        {"c": 1.0, "d": 0.01, "mu": 0.5},
        ImpactClass.C_REVERSED,
    ),
}


@pytest.mark.parametrize("law", sorted(RESTITUTIONS))
@pytest.mark.parametrize("name", sorted(OTHERS))
def test_jump_of_every_other_class_balances_and_moves_the_contact_as_it_says(name, law):
    mechanism, state, parameters, case = OTHERS[name]
    result = evaluate_jump(mechanism, law, state, parameters={**parameters, f"e_{law}": 0.6})
    assert (result.case, result.end) == (case, ImpactEnd.SEPARATION)
    mass, J_N, J_T, start = _numbers(mechanism, state, parameters)
    assert list(result.velocity_before.values()) == list(start)
    before, belt = start, 0.3 if mechanism is BELT else 0.0
    for phase in result.phases:
        after = np.array(list(phase.velocity.values()))
        impulse = J_N[0] * phase.normal_impulse + J_T[0] * phase.tangential_impulse[0]
        np.testing.assert_allclose(mass @ (after - before), impulse, atol=1e-13)
        assert math.isclose((J_T @ after).item() - belt, *phase.slip_velocity, abs_tol=1e-13)
        assert math.isclose((J_N @ after).item(), phase.normal_velocity, abs_tol=1e-13)
        before = after
    if mechanism is not BELT:
        change = (before @ mass @ before - start @ mass @ start) / 2
        assert math.isclose(result.energy_change, change, abs_tol=1e-13)


@pytest.mark.parametrize("name", ["compression ends first", "starts at rest"])
def test_jump_that_ends_sticking_leaves_no_slip_behind(name):
    mechanism, state, parameters, _ = OTHERS[name]
    result = evaluate_jump(mechanism, "energetic", state, parameters=parameters)
    # Exactly 0, so that a motion may continue from there in sticking.
    assert result.velocity["x_A_dot"] == 0.0
    assert np.sign(result.slip_velocity) == (-1 if state.get("x_A_dot") else 0)


@settings(max_examples=25)
@given(impact=IMPACTS, e=RESTITUTION, law=st.sampled_from(sorted(RESTITUTIONS)))
def test_jump_of_three_phases_equals_the_complete_solution(impact, e, law):
    mechanism, state, parameters = impact
    result = evaluate_jump(mechanism, law, state, parameters={**parameters, f"e_{law}": e})
    assert result.case is ImpactClass.C_STICKING
    assert [p.name for p in result.phases] == [
        "tangential",
        "sticking compression",
        "sticking restitution",
    ]
    mass, J_N, J_T, before = _numbers(mechanism, state, parameters)
    J = np.vstack([J_N, J_T])
    W, v = J @ np.linalg.solve(mass, J.T), J @ before
    solution = solve_impact(W, parameters["mu"], tuple(v), law, e)
    assert result.end is solution.end
    for phase, other in zip(result.phases, solution.phases, strict=True):
        size = 1e-10 * (1 + np.abs(v).max()) * (1 + 1 / np.diag(W).min())
        assert math.isclose(phase.normal_impulse, other.normal_impulse, rel_tol=1e-9, abs_tol=size)
        assert math.isclose(phase.normal_velocity, other.velocity[0], rel_tol=1e-9, abs_tol=size)
        assert math.isclose(phase.stored_energy, -other.normal_work, rel_tol=1e-9, abs_tol=size)


def strut() -> Mechanism:
    """Return a rod pivoted over a moving belt that it touches: one degree of freedom."""
    a = Coordinate("a", "angle from the vertical", "rad")
    inertia, mu = (
        positive("J", 1.0, "kg m^2", "inertia"),
        Parameter("mu", 2.0, "1", "friction", 0.0),
    )
    u = Parameter("u", 1.0, "m/s", "speed of the belt")
    system = LagrangianSystem(
        "strut", (a,), (inertia, mu, u), inertia.symbol * a.rate**2 / 2, sp.Integer(0)
    )
    tip = (sp.sin(a.symbol), 1 - sp.cos(a.symbol))
    contact = Contact.of_point("tip", system, tip, mu.symbol, surface_speed=u.symbol)
    return Mechanism("strut", "pivoted rod on a belt", "a test", system, (contact,))


def test_jump_of_a_strut_dragged_by_a_belt_jams():
    # a = −45°: the belt at u > 0 drags the tip under the pivot.
    state, parameters = {"a": -math.pi / 4}, {"u": 1.0}
    result = evaluate_jump(strut(), "energetic", state, parameters=parameters)
    assert (result.case, result.end) == (ImpactClass.C_STICKING, ImpactEnd.JAM)
    assert [p.name for p in result.phases] == ["tangential"]
    assert result.phases[0].normal_velocity < 0
    # The tip moves with the belt.
    assert math.isclose(result.velocity["a_dot"] * math.cos(math.pi / 4), 1.0, rel_tol=1e-14)


def test_jump_that_jams_at_once_keeps_the_velocities():
    state, parameters = {"a": -math.pi / 4, "a_dot": 1.0}, {"u": math.cos(math.pi / 4)}
    result = evaluate_jump(strut(), "energetic", state, parameters=parameters)
    assert (result.end, result.phases, result.energy_change) == (ImpactEnd.JAM, (), 0.0)
    assert result.velocity == {"a_dot": 1.0}


def test_jump_takes_a_law_of_its_own():
    """E_r = −e E_c has the jump of the energetic law with √e."""
    law = replace(restitution_law("energetic"), name="my law", power=1)
    mechanism, state, parameters, _ = OTHERS["slips back"]
    for case, start, own in ((ROD, TABLE_3, {}), (mechanism, state, parameters)):
        jump = evaluate_jump(case, law, start, parameters=own | {"e_energetic": 0.64})
        same = evaluate_jump(case, "energetic", start, parameters=own | {"e_energetic": 0.8})
        assert jump.restitution == "my law"
        assert jump.velocity == pytest.approx(same.velocity, rel=1e-14, abs=1e-15)


def test_jump_unknown_restitution_suggests_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'poisson'"):
        evaluate_jump(ROD, "poison", TABLE_3)
