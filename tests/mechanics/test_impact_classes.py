"""The five courses of an impact: balances, ends, conditions, and what makes slip stop."""

from __future__ import annotations

import pytest
import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.laws.impact_cases import impact_cases, three_phase_jump
from painleve_sym.laws.restitution import RESTITUTIONS, restitution_law
from painleve_sym.mechanics.impact.classes import impact_course
from painleve_sym.mechanics.impact.impact_class import CLASSES, ImpactClass
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_N_PLUS, V_T, ImpulseRay, raw
from painleve_sym.mechanics.models.rods import rod
from tests.mechanics.made_up import skew_block
from tests.support.vanishing import vanishes

BLOCK, BELT = skew_block(), skew_block(belt=True)
SLIPS = (-1, 1)
C_CLASSES = (ImpactClass.C_STICKING, ImpactClass.C_REVERSED)
R_CLASSES = (ImpactClass.R_STICKING, ImpactClass.R_REVERSED)


def _course(case: ImpactClass, slip: int = -1, mechanism=BLOCK):
    return impact_course(mechanism.coefficients, case, slip, raw)


@pytest.mark.parametrize("slip", SLIPS)
@pytest.mark.parametrize("case", CLASSES)
@pytest.mark.parametrize("mechanism", [BLOCK, BELT], ids=["block", "belt"])
def test_course_balances_momentum_of_every_phase(mechanism, case, slip):
    contact, system = mechanism.contact, mechanism.system
    for phase in _course(case, slip, mechanism).phases:
        change = sp.Matrix([phase.velocity[v] - v for v in system.q_dot])
        impulse = contact.J_N.T * phase.normal_impulse + contact.J_T.T * phase.tangential_impulse
        assert all(vanishes(entry) for entry in system.mass_matrix * change - impulse), phase.name


@pytest.mark.parametrize("case", CLASSES)
def test_course_from_start_agrees_with_the_velocities_of_the_contact(case):
    contact = BELT.contact
    start = {V_T: contact.slip_velocity, V_N: contact.gap_rate}
    for phase in _course(case, 1, BELT).from_start:
        moved = phase.started_from(start)
        after = dict(moved.velocity)
        slip = contact.slip_velocity.subs(after, simultaneous=True)
        opening = contact.gap_rate.subs(after, simultaneous=True)
        assert vanishes(slip - moved.slip_velocity), phase.name
        assert vanishes(opening - moved.normal_velocity), phase.name


@pytest.mark.parametrize("case", CLASSES)
def test_course_ends_where_its_class_says(case):
    course = _course(case)
    assert course.compression[-1].normal_velocity == 0
    assert course.restitution[-1].normal_velocity == V_N_PLUS
    if case in C_CLASSES:
        assert course.compression[0].slip_velocity == 0
    if case in R_CLASSES:
        assert course.restitution[0].slip_velocity == 0
    if "stick" in case.rays:
        assert course.phases[-1].slip_velocity == 0
    assert len(course.phases) == 1 + len(case.rays)


@pytest.mark.parametrize("slip", SLIPS)
@pytest.mark.parametrize("case", CLASSES)
def test_course_force_ratios_are_those_of_its_rays(case, slip):
    c = BLOCK.coefficients
    ratio = {"slip": -slip * c.mu, "stick": -c.W_nt / c.W_tt, "reverse": slip * c.mu}
    ratios = list(dict.fromkeys(sp.simplify(p.force_ratio) for p in _course(case, slip).phases))
    assert [sp.simplify(f - ratio[r]) for f, r in zip(ratios, case.rays, strict=True)] == [0] * len(
        case.rays
    )


def test_course_names_say_what_the_contact_does():
    names = {case: [p.name for p in _course(case).phases] for case in CLASSES}
    assert names == {
        ImpactClass.SLIDING: ["slip compression", "slip restitution"],
        ImpactClass.C_STICKING: ["tangential", "sticking compression", "sticking restitution"],
        ImpactClass.C_REVERSED: [
            "tangential",
            "reverse slip compression",
            "reverse slip restitution",
        ],
        ImpactClass.R_STICKING: ["slip compression", "slip restitution", "sticking restitution"],
        ImpactClass.R_REVERSED: [
            "slip compression",
            "slip restitution",
            "reverse slip restitution",
        ],
    }


@pytest.mark.parametrize("case", CLASSES)
def test_course_friction_work_is_the_integral_of_friction_force_times_slip(case):
    course, c, p = _course(case), BLOCK.coefficients, sp.Symbol("p", real=True)
    work, before = sp.Integer(0), V_T
    symbols = sorted(BLOCK.system.mass_matrix.free_symbols, key=str)
    numbers = {s: sp.Rational(7 + 2 * i, 11) for i, s in enumerate(symbols)}
    numbers |= {c.mu: sp.Rational(3, 10), V_T: -2, V_N: -3, V_N_PLUS: sp.Rational(5, 3)}
    for phase in course.from_start:
        rate = c.W_nt + phase.force_ratio * c.W_tt
        slip = sp.integrate(before + rate * p, (p, 0, phase.normal_impulse))
        work += phase.force_ratio * slip
        before = phase.slip_velocity
    assert (work - course.friction_work).subs(numbers) == 0


def test_class_is_found_by_its_rays():
    assert ImpactClass.of_rays(("slip",)) is ImpactClass.SLIDING
    assert ImpactClass.of_rays(("slip", "stick")) is ImpactClass.C_STICKING
    assert ImpactClass.of_rays(["slip", "reverse"]) is ImpactClass.C_REVERSED
    late = {r: ImpactClass.of_rays(("slip", r), in_compression=False) for r in ("stick", "reverse")}
    assert late == {"stick": ImpactClass.R_STICKING, "reverse": ImpactClass.R_REVERSED}


@pytest.mark.parametrize("rays", [(), ("stick", "slip"), ("slip", "stick", "reverse")])
def test_class_of_impossible_rays_is_refused(rays):
    with pytest.raises(InputError, match="at most one follows"):
        ImpactClass.of_rays(rays)


def test_course_of_no_impact_is_refused():
    with pytest.raises(InputError, match="no phases"):
        impact_course(BLOCK.coefficients, ImpactClass.NO_IMPACT)


@pytest.mark.parametrize("slip", [0, 2])
def test_course_rejects_a_slip_that_is_no_sign(slip):
    with pytest.raises(InputError, match=r"need -1 or \+1"):
        impact_course(BLOCK.coefficients, ImpactClass.SLIDING, slip)


def test_course_c_sticking_is_the_three_phase_jump():
    course = _course(ImpactClass.C_STICKING)
    assert course.phases == three_phase_jump(BLOCK.coefficients, write=raw).course.phases


def test_course_conditions_are_named():
    names = [[c.name for c in p.conditions] for p in _course(ImpactClass.R_REVERSED).phases]
    assert names == [
        ["slip direction", "approach", "compression ends", "slip continues"],
        ["slip stops"],
        ["slip reverses", "restitution continues"],
    ]
    reverse = _course(ImpactClass.R_REVERSED).phases[-1].conditions[0]
    c = BLOCK.coefficients
    # With s = −1: slip begins in direction +1 iff W_nt > μ W_tt.
    assert vanishes(reverse.margin - (c.W_nt - c.mu * c.W_tt))
    assert reverse.strict


@pytest.mark.parametrize("slip", SLIPS)
def test_rate_identity_behind_slip_that_stops_and_sticks(slip):
    # s W_nt (μ W_tt − s W_nt) = det W − A_s W_tt. With A_s < 0 and det W ≥ 0 the right side is
    # positive and s W_nt > 0: so |W_nt| < μ W_tt, the slip stops and sticks. With |W_nt| > μ W_tt
    # and s = sign(W_nt) the left side is negative: so A_s > det W/W_tt = A′ in a slip that begins.
    c = BLOCK.coefficients
    det = c.W_nn * c.W_tt - c.W_nt**2
    left = slip * c.W_nt * (c.mu * c.W_tt - slip * c.W_nt)
    assert vanishes(left - (det - c.A(slip) * c.W_tt))
    rate = ImpulseRay.slipping(c, slip).slip_rate
    assert vanishes(-slip * rate - (c.mu * c.W_tt - slip * c.W_nt))
    assert vanishes(det - c.A_stick * c.W_tt)


@pytest.mark.parametrize("law", sorted(RESTITUTIONS))
def test_cases_close_every_class_in_the_velocities_before(law):
    rule = restitution_law(law)
    known = {V_T, V_N, rule.parameter.symbol, *BLOCK.system.q_dot}
    known |= {p.symbol for p in BLOCK.system.parameters}
    cases = impact_cases(BLOCK.coefficients, rule, write=raw)
    assert tuple(cases) == CLASSES
    for classes in cases.values():
        expressions = [*classes.velocity.values(), classes.slip_velocity, classes.energy_change]
        expressions += [condition.margin for condition in classes.conditions]
        assert set().union(*(sp.sympify(e).free_symbols for e in expressions)) <= known
        assert classes.course.case in cases


def test_cases_take_the_energetic_law_when_none_is_given():
    cases = impact_cases(BLOCK.coefficients, write=raw)
    assert {case.law.name for case in cases.values()} == {"energetic"}


@pytest.mark.parametrize("law", sorted(RESTITUTIONS))
def test_cases_sliding_rebound_is_the_same_by_every_law(law):
    rule = restitution_law(law)
    sliding = impact_cases(BLOCK.coefficients, rule, write=raw)[ImpactClass.SLIDING]
    rebound = sliding.separation_velocity.subs(V_N, -sp.Symbol("v", positive=True))
    expected = rule.parameter.symbol * sp.Symbol("v", positive=True)
    assert vanishes(rebound - expected)


@pytest.mark.parametrize("law", sorted(RESTITUTIONS))
def test_final_velocity_of_a_law_starts_like_its_separation_velocity(law):
    from painleve_sym.laws.restitution_equation import A_R, E_R, E_R1, P_R, P_R1, V_N_1

    rule = restitution_law(law)
    first = rule.final_velocity.subs({V_N_1: 0, P_R1: 0, E_R1: 0})
    assert sp.simplify(first**2 - rule.separation_velocity**2) == 0
    v = rule.final_velocity
    ray = {P_R: P_R1 + (v - V_N_1) / A_R, E_R: E_R1 - (v**2 - V_N_1**2) / (2 * A_R), V_N_PLUS: v}
    assert vanishes((rule.equation.lhs - rule.equation.rhs).subs(ray, simultaneous=True))


def test_cases_of_the_rod_read_well():
    cases = impact_cases(rod().coefficients, restitution_law("newton"))
    e = restitution_law("newton").parameter.symbol
    for classes in cases.values():
        assert vanishes(classes.separation_velocity + e * V_N)
    reverse = cases[ImpactClass.C_REVERSED].course.compression[1]
    assert str(reverse.force_ratio) == "-mu"
