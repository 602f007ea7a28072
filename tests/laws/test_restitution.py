"""Restitution laws: what each solves for, when they agree, what they do to the energy."""

from __future__ import annotations

import pytest
import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.laws.impact_cases import three_phase_jump
from painleve_sym.laws.restitution import RESTITUTIONS, energetic, restitution_law
from painleve_sym.laws.restitution_equation import A_R, E_C, E_R, P_C, P_R, V_N_MINUS
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_N_PLUS, V_T, raw
from painleve_sym.mechanics.models.rods import rod
from tests.mechanics.made_up import skew_block

P_1, A_S, A_STICK = sp.symbols("P_1 A_s A_stick", real=True)
V_1 = sp.Symbol("v_1", nonpositive=True)


@pytest.fixture(params=sorted(RESTITUTIONS))
def law(request):
    return restitution_law(request.param)


def test_restitution_law_separation_velocity_solves_its_equation(law):
    v = law.separation_velocity
    ray = {V_N_PLUS: v, P_R: v / A_R, E_R: -(v**2) / (2 * A_R)}
    assert sp.simplify((law.equation.lhs - law.equation.rhs).subs(ray, simultaneous=True)) == 0


def test_restitution_law_separates_and_stops_at_zero_restitution(law):
    e = law.parameter.symbol
    point = {V_N_MINUS: -0.3, P_C: 0.7, E_C: 0.2, A_R: 1.6}
    assert law.separation_velocity.subs({**point, e: 0.5}) > 0
    assert law.separation_velocity.subs({**point, e: 0}) == 0


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("newton", "-e_newton*v_n_minus"),
        ("poisson", "A_r*P_c*e_poisson"),
        ("energetic", "sqrt(2)*sqrt(A_r)*sqrt(E_c)*e_energetic"),
    ],
)
def test_restitution_law_separation_velocity_reads_as_defined(name, text):
    assert str(restitution_law(name).separation_velocity) == text


def _compressed() -> dict[sp.Symbol, sp.Expr]:
    """Return the compression quantities of P_1 along A_s, then sticking from v_1 to 0."""
    v_0 = V_1 - A_S * P_1
    p_2 = -V_1 / A_STICK
    return {
        V_N_MINUS: v_0,
        P_C: P_1 + p_2,
        E_C: -P_1 * (v_0 + V_1) / 2 - p_2 * V_1 / 2,
        A_R: A_STICK,
    }


@pytest.mark.parametrize("same", [{P_1: 0}, {A_S: A_STICK}], ids=["no slip phase", "A_s = A'"])
def test_restitution_laws_agree_when_the_force_keeps_its_direction(same):
    e = sp.Symbol("e", positive=True)
    squares = []
    for name in RESTITUTIONS:
        law = restitution_law(name)
        v = law.separation_velocity.subs(law.parameter.symbol, e).subs(_compressed())
        squares.append(sp.simplify((v**2).subs(same)))
    assert sp.simplify(squares[0] - squares[1]) == 0
    assert sp.simplify(squares[0] - squares[2]) == 0


def test_restitution_laws_differ_only_by_the_slip_phase_when_they_differ():
    # E_c − A′ P_c²/2 = (A_s − A′) P_1²/2: energetic and Poisson agree nowhere else.
    results = _compressed()
    gap = results[E_C] - A_STICK * results[P_C] ** 2 / 2
    assert sp.simplify(gap - (A_S - A_STICK) * P_1**2 / 2) == 0


def test_restitution_poisson_can_release_more_than_was_stored():
    law = restitution_law("poisson")
    point = {A_S: -0.03, A_STICK: 1.3, P_1: 0.33, V_1: -0.01}
    v = law.separation_velocity.subs(_compressed()).subs({**point, law.parameter.symbol: 1})
    assert v**2 / (2 * point[A_STICK]) > _compressed()[E_C].subs(point)


def test_restitution_law_unknown_name_suggests_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'energetic'"):
        restitution_law("energetics")


def test_three_phase_jump_takes_the_energetic_law_when_none_is_given():
    jump = three_phase_jump(skew_block().coefficients, write=raw)
    assert jump.law == energetic()
    assert [phase.name for phase in jump.course.phases] == [
        "tangential",
        "sticking compression",
        "sticking restitution",
    ]


@pytest.mark.parametrize("slip", [-1, 1])
def test_three_phase_jump_releases_the_part_of_energy_the_law_says(slip):
    jump = three_phase_jump(skew_block().coefficients, slip=slip, write=raw)
    first, second, third = jump.phases
    e = jump.law.parameter.symbol
    stored = first.stored_energy + second.stored_energy
    assert sp.simplify(third.stored_energy + e**2 * stored) == 0


def test_three_phase_jump_from_start_has_the_initial_velocities_only(law):
    mechanism = skew_block()
    jump = three_phase_jump(mechanism.coefficients, law, slip=-1, write=raw)
    known = {V_T, V_N, law.parameter.symbol, *mechanism.system.q_dot, *mechanism.system.q}
    known |= {p.symbol for p in mechanism.system.parameters}
    for phase in jump.phases:
        expressions = [phase.normal_impulse, phase.stored_energy, *phase.velocity.values()]
        assert set().union(*(e.free_symbols for e in expressions)) <= known


def test_three_phase_jump_without_collision_rebounds_by_the_ratio_of_coefficients():
    # ẏ(t3) = −e ẏ(t1) √(1 − A′/A).
    c = rod().coefficients
    jump = three_phase_jump(c, write=raw)
    first, _, third = (p.started_from({V_N: sp.Integer(0)}) for p in jump.phases)
    e = jump.law.parameter.symbol
    squared = (e * first.normal_velocity) ** 2 * (1 - c.A_stick / c.A(-1))
    assert sp.simplify(third.normal_velocity**2 - squared) == 0
