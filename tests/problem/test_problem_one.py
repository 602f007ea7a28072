"""The frictional contact problem: the paper's rod, borders, and an independent mode analysis."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.errors import InputError
from painleve_sym.problem.complementarity import residual, solve_all
from painleve_sym.problem.complementarity.lcp import RESIDUAL_TOLERANCE
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.solution import ContactCase
from tests.support.one_contact import built, contacts, mode_analysis

SWAPPED = {
    ContactMode.SLIP_POS: ContactMode.SLIP_NEG,
    ContactMode.SLIP_NEG: ContactMode.SLIP_POS,
    ContactMode.STICK: ContactMode.STICK,
    ContactMode.LIFTOFF: ContactMode.LIFTOFF,
}


def rod(angle, rate, slip_velocity=-1.0, mu=1.4):
    """Return the paper's rod (m = 1 kg, l = 1 m, g = 9.8 m/s²), from J M^-1 J' of its end."""
    sin, cos = math.sin(angle), math.cos(angle)
    inverse_mass = np.diag([1.0, 1.0, 3.0])  # J = m l²/3
    rows = np.array([[0.0, 1.0, -cos], [1.0, 0.0, sin]])
    W = rows @ inverse_mass @ rows.T
    return ContactProblem.single(
        W[0, 0], W[0, 1], W[1, 1], rate**2 * sin - 9.8, rate**2 * cos, mu, slip_velocity
    )


def violates_coulomb(problem, s):
    """Return the first law of the contact that a solution breaks, or None."""
    F_n, F_t, a_n, a_t = *s.forces, *s.accelerations
    scale = 1e-9 * (1 + abs(F_n) + abs(F_t) + abs(problem.b_n) + abs(problem.b_t))
    scale *= 1 + problem.W_nn + problem.W_tt + problem.mu
    if abs(problem.W_nn * F_n + problem.W_nt * F_t + problem.b_n - a_n) > scale:
        return "normal dynamics"
    if abs(problem.W_nt * F_n + problem.W_tt * F_t + problem.b_t - a_t) > scale:
        return "tangential dynamics"
    if F_n < 0 or a_n < 0 or F_n * a_n != 0:
        return "unilateral contact"
    if abs(F_t) > problem.mu.item() * F_n + scale:
        return "friction cone"
    sliding = problem.slip_direction or a_t
    if sliding and abs(F_t + math.copysign(problem.mu.item() * F_n, sliding)) > scale:
        return "friction direction"
    return None


# --- the paper's rod --------------------------------------------------------------------------


# Tables 1 to 4 (A of table 3 as tables 4 to 6 print it), half a unit of the last digit.
@pytest.mark.parametrize(
    ("angle", "rate", "A", "B", "case", "forces"),
    [
        (0.5, 1.0, 1.5434, -9.3206, ContactCase.SLIP, [6.039]),
        (0.5, 5.0, 1.5434, 2.1856, ContactCase.LIFTOFF, [0.0]),
        (1.0, 1.0, -0.0337, -8.9585, ContactCase.INCONSISTENT, []),
        (1.0, 5.0, -0.0337, 11.2368, ContactCase.INDETERMINATE, [0.0, 332.992]),
    ],
)
def test_contact_problem_gives_the_printed_case_for_paper_tables(angle, rate, A, B, case, forces):
    problem = rod(angle, rate)
    assert pytest.approx(A, abs=0.5e-4) == problem.A
    assert pytest.approx(B, abs=0.5e-4) == problem.B
    assert problem.case is case
    assert [s.normal_force for s in problem.solutions()] == pytest.approx(forces, abs=0.5e-3)


@given(st.floats(0.05, 3.0), st.floats(0.0, 3.0))
def test_a_slip_equals_formula_2_for_any_angle(angle, mu):
    printed = 1 + 3 * math.cos(angle) * (math.cos(angle) - mu * math.sin(angle))
    assert rod(angle, 0.0, mu=mu).A_slip(-1) == pytest.approx(printed, abs=1e-12)


def test_contact_problem_slides_left_with_positive_friction_for_table_1():
    (solution,) = rod(0.5, 1.0).solutions()
    assert solution.mode is ContactMode.SLIP_NEG
    assert solution.tangential_force == pytest.approx(1.4 * solution.normal_force)
    assert solution.normal_acceleration == 0.0


@pytest.mark.parametrize("rate", [0.5, 1.0, 2.0])
def test_contact_problem_sticks_with_the_printed_friction_for_rod_at_rest(rate):
    problem = rod(1.0, rate, slip_velocity=0.0)
    (solution,) = problem.solutions()
    sin, cos = math.sin(1.0), math.cos(1.0)
    assert problem.case is ContactCase.STICK
    printed = (3 * sin * cos * solution.normal_force - rate**2 * cos) / (3 * sin**2 + 1)
    assert solution.tangential_force == pytest.approx(printed)


@pytest.mark.parametrize(("mu", "possible"), [(1.33, False), (1.34, True)])
def test_a_slip_is_negative_somewhere_only_above_four_thirds(mu, possible):
    angle = math.atan(2.0)  # where the critical friction (4 + tan²)/(3 tan) is smallest
    assert (rod(angle, 0.0, mu=mu).A < 0) is possible


# --- borders ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("W_nt", "b_n", "case", "forces", "isolated"),
    [
        (-1.0, -3.0, ContactCase.INCONSISTENT, [], []),  # A = 0
        (-1.0, 3.0, ContactCase.LIFTOFF, [0.0], [True]),
        (-1.0, 0.0, ContactCase.INDETERMINATE, [0.0, 1.0], [False, False]),
        (-0.5, 0.0, ContactCase.LIFTOFF, [0.0], [True]),  # A > 0, B = 0
        (-1.5, 0.0, ContactCase.LIFTOFF, [0.0], [True]),  # A < 0, B = 0
        (-1.5, 1.0, ContactCase.INDETERMINATE, [0.0, 2.0], [True, True]),
        (-1.5, -1.0, ContactCase.INCONSISTENT, [], []),
    ],
)
def test_contact_problem_classifies_borders_while_slipping(W_nt, b_n, case, forces, isolated):
    problem = ContactProblem.single(1.0, W_nt, 4.0, b_n, 0.0, 1.0, -1.0)
    solutions = problem.solutions()
    assert problem.case is case
    assert [s.isolated for s in solutions] == isolated
    if all(isolated):
        assert [s.normal_force for s in solutions] == forces
    else:  # one force of a ray
        assert [s.normal_force > 0 for s in solutions] == [force > 0 for force in forces]


@pytest.mark.parametrize(
    ("data", "case", "modes"),
    [
        # Frictionless: the tangential acceleration alone decides.
        ((1, 0, 1, -1, 1, 0), ContactCase.SLIP, {ContactMode.SLIP_POS}),
        ((1, 0, 1, -1, -1, 0), ContactCase.SLIP, {ContactMode.SLIP_NEG}),
        ((1, 0, 1, -1, 0, 0), ContactCase.STICK, {ContactMode.STICK}),
        ((1, 0, 1, 1, 1, 0), ContactCase.LIFTOFF, {ContactMode.LIFTOFF}),
        ((1, 0, 1, 0, 0, 0.5), ContactCase.LIFTOFF, {ContactMode.LIFTOFF}),
        # On the edge of the cone with a_t = 0: sticking.
        ((1, 0, 1, -2, 1, 0.5), ContactCase.STICK, {ContactMode.STICK}),
        ((1, 0, 1, -2, -1, 0.5), ContactCase.STICK, {ContactMode.STICK}),
        # W of rank one: forces along its null direction add up without moving anything.
        ((4, 2, 1, -4, -2, 3), ContactCase.HYPERSTATIC, {ContactMode.STICK}),
        ((4, 2, 1, -4, -1, 1), ContactCase.SLIP, {ContactMode.SLIP_POS}),
        ((4, 2, 1, -4, -1, 2), ContactCase.INCONSISTENT, set()),
        ((1, 0, 0, -1, 0, 1), ContactCase.HYPERSTATIC, {ContactMode.STICK}),
        ((1, 0, 0, -1, -1, 1), ContactCase.SLIP, {ContactMode.SLIP_NEG}),
        # No normal mobility at all.
        ((0, 0, 1, -1, 0, 1), ContactCase.INCONSISTENT, set()),
        ((0, 0, 1, 0, 0, 1), ContactCase.HYPERSTATIC, {ContactMode.LIFTOFF}),
        ((0, 0, 0, 0, 0, 0), ContactCase.HYPERSTATIC, {ContactMode.LIFTOFF}),
    ],
)
def test_contact_problem_classifies_borders_at_rest(data, case, modes):
    problem = ContactProblem.single(*data, slip_velocity=0.0)
    assert problem.case is case
    assert {s.mode for s in problem.solutions()} == modes
    assert [
        violates_coulomb(problem, s) for s in problem.solutions() if violates_coulomb(problem, s)
    ] == []


def test_a_slip_is_exactly_zero_for_a_difference_of_rounded_terms():
    assert 0.3 - 3 * 0.1 != 0.0
    assert ContactProblem.single(0.3, -0.1, 1.0, 1.0, 0.0, 3.0, -1.0).A == 0.0


# --- properties -------------------------------------------------------------------------------


@settings(max_examples=200)
@given(contacts())
def test_solutions_agree_with_mode_analysis_for_rational_data(data):
    expected = mode_analysis(*data)
    problem = built(data)
    solutions = problem.solutions()
    for s in solutions:
        assert s.residual <= RESIDUAL_TOLERANCE
        assert violates_coulomb(problem, s) is None
    if expected is None:
        return
    assert sorted(s.mode.value for s in solutions) == sorted(mode.value for mode, _, _ in expected)
    for mode, force, friction in expected:
        (s,) = (s for s in solutions if s.mode is mode)
        assert (s.normal_force, s.tangential_force) == pytest.approx(
            (float(force), float(friction)), rel=1e-9
        )
        assert s.isolated


@given(contacts())
def test_solutions_swap_slip_directions_under_reflection(data):
    W_nn, W_nt, W_tt, b_n, b_t, mu, v = map(float, data)
    problem = built(data)
    mirror = ContactProblem.single(W_nn, -W_nt, W_tt, b_n, -b_t, mu, -v)
    assert mirror.case is problem.case
    here, there = problem.solutions(), mirror.solutions()
    assert {s.mode for s in here} == {SWAPPED[s.mode] for s in there}
    if all(s.isolated for s in here):
        forces = sorted((s.normal_force, s.tangential_force) for s in here)
        mirrored = sorted((s.normal_force, -s.tangential_force) for s in there)
        assert np.allclose(forces, mirrored, rtol=1e-9)


@given(contacts(slip=st.sampled_from([-1, 1])))
def test_case_counts_the_solutions_while_slipping(data):
    problem = built(data)
    solutions = problem.solutions()
    if problem.A < 0 and problem.B < 0:
        assert not solutions
    if problem.A < 0 < problem.B:
        assert [s.mode is ContactMode.LIFTOFF for s in solutions] == [True, False]
    if any(s.moves for s in solutions):
        return
    count = {ContactCase.INCONSISTENT: 0, ContactCase.INDETERMINATE: 2}.get(problem.case, 1)
    assert len(solutions) == count
    if count == 1 and problem.case is not ContactCase.HYPERSTATIC:
        assert (solutions[0].mode is ContactMode.LIFTOFF) == (problem.case is ContactCase.LIFTOFF)


@given(contacts(slip=st.just(0), definite=True))
def test_contact_problem_is_never_inconsistent_at_rest_for_definite_mobility(data):
    assert built(data).case is not ContactCase.INCONSISTENT


@given(contacts(), st.integers(-30, 30))
def test_solutions_scale_with_the_accelerations(data, power):
    W_nn, W_nt, W_tt, b_n, b_t, mu, v = map(float, data)
    scaled = ContactProblem.single(W_nn, W_nt, W_tt, b_n * 2.0**power, b_t * 2.0**power, mu, v)
    pairs = zip(built(data).solutions(), scaled.solutions(), strict=True)
    for s, t in pairs:
        assert s.mode is t.mode
        if s.isolated:
            assert t.normal_force == s.normal_force * 2.0**power


@given(contacts(slip=st.just(0), definite=True), st.floats(-1e-13, 1e-13))
def test_solutions_survive_rounding_of_the_data(data, noise):
    W_nn, W_nt, W_tt, b_n, b_t, mu, v = map(float, data)
    problem = ContactProblem.single(W_nn * (1 + noise), W_nt, W_tt * (1 - noise), b_n, b_t, mu, v)
    for s in problem.solutions():
        assert violates_coulomb(problem, s) is None


# --- the complementarity problems themselves --------------------------------------------------


def test_lcp_is_scalar_while_slipping_and_full_at_rest():
    assert rod(1.0, 1.0).lcp().size == 1
    still = rod(1.0, 1.0, slip_velocity=0.0)
    assert still.lcp().size == 3
    # At rest A is that of the slip which begins without force.
    assert still.A_slip(1 if still.b_t > 0 else -1) == still.A


def test_lcp_at_rest_has_friction_reserves_as_unknowns():
    problem = rod(0.7, 1.0, slip_velocity=0.0)
    lcp = problem.lcp()
    F_n, F_t, speeding_down = 3.0, 1.1, 0.4
    z = np.array([F_n, problem.mu.item() * F_n + F_t, speeding_down])
    a_n, speeding_up, reserve_left = lcp.matrix @ z + lcp.offset
    assert a_n == pytest.approx(problem.W_nn * F_n + problem.W_nt * F_t + problem.b_n)
    a_t = problem.W_nt * F_n + problem.W_tt * F_t + problem.b_t
    assert speeding_up - speeding_down == pytest.approx(a_t)
    assert reserve_left == pytest.approx(problem.mu.item() * F_n - F_t)


def test_solution_from_refuses_a_scalar_solution_at_rest():
    (slipping,) = solve_all(rod(0.5, 1.0).lcp())
    with pytest.raises(InputError, match=r"Fix: solve this problem's lcp"):
        rod(0.5, 1.0, slip_velocity=0.0).solution_from(slipping)


@given(contacts(), st.integers(-8, 0))
def test_solutions_are_those_of_the_lcp(data, power):
    *rest, mu, v = data
    # Friction reserves may be a tiny part of the normal force: unknowns of very different size.
    problem = built((*rest, float(mu) * 10.0**power, v))
    solutions, read = problem.solutions(), solve_all(problem.lcp())
    assert bool(solutions) == bool(read)
    for translated in map(problem.solution_from, read):
        assert translated.residual <= RESIDUAL_TOLERANCE
        if translated.isolated:
            (same,) = (s for s in solutions if np.allclose(s.forces, translated.forces, rtol=1e-9))
            assert same.modes == translated.modes and same.isolated


def test_solution_residual_is_that_of_its_forces_and_solves_the_lcp():
    problem = rod(0.5, 1.0)
    (solution,) = problem.solutions()
    assert solution.residual == problem.residual(solution.forces)
    assert residual(problem.lcp(), [solution.normal_force]) <= 1e-15


# --- validation -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"b_n": math.nan}, "b_n: got nan, need a finite number"),
        ({"W_nn": "x"}, "W_nn: got 'x'"),
        ({"mu": -0.1}, "mu: got -0.1, need mu >= 0"),
        ({"W_nt": 3.0}, "W_nt**2 <= W_nn W_tt"),
        ({"W_nn": -1.0}, "W_nn >= 0"),
        ({"mu": -0.1, "W_nt": 3.0}, "Also, mobility: "),
    ],
)
def test_contact_problem_names_the_fault_for_bad_input(change, words):
    good = {"W_nn": 1.0, "W_nt": 0.5, "W_tt": 1.0, "b_n": -1.0, "b_t": 0.0, "mu": 0.5}
    with pytest.raises(InputError, match="Fix: ") as caught:
        ContactProblem.single(**{**good, **change}, slip_velocity=-1.0)
    assert words in str(caught.value)


@pytest.mark.parametrize("direction", [0, 2, 0.5])
def test_a_slip_refuses_what_is_no_direction(direction):
    with pytest.raises(InputError, match=r"need \+1 or -1"):
        rod(1.0, 1.0).A_slip(direction)
