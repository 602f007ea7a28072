"""Contact problems do not depend on units, the size of contacts, their order or a mirror."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.problem.contact_problem import ContactProblem
from tests.problem.friction_oracle import SWAPPED, contact_sets
from tests.support.one_contact import built, contacts, mode_analysis

decades = st.floats(-6.0, 6.0).map(lambda k: 10.0**k)
up_to_three = st.integers(1, 3)


@st.composite
def problems(draw, sizes=up_to_three):
    """Draw contacts of both kinds, with friction over 18 decades."""
    W, b, mu, slip, powers, held = draw(contact_sets(sizes, more=(range(-12, 7), range(2))))
    friction = np.array(mu, float) * 10.0 ** np.array(powers)
    held = np.array(held, bool)
    return ContactProblem(np.array(W, float), np.array(b, float), friction, slip, held)


def changed(problem, rows, b_unit=1.0, W_unit=1.0, order=None, mirror=1.0):
    """Return the problem with rows scaled, units changed, contacts permuted or mirrored."""
    order = list(range(problem.size)) if order is None else order
    place = [2 * i + k for i in order for k in (0, 1)]
    rows = (np.repeat(rows, 2) * np.tile([1.0, mirror], problem.size))[place]
    return ContactProblem(
        W_unit * problem.W[np.ix_(place, place)] * np.outer(rows, rows),
        b_unit * problem.b[place] * rows,
        problem.mu[order],
        mirror * problem.slip_velocity[order],
        problem.bilateral[order],
    )


def solved(problem):
    """Return case, modes and uniqueness, which have no units, and the isolated forces."""
    solutions = problem.solutions()
    isolated = [s for s in solutions if s.isolated]
    modes = sorted(str([m.value for m in s.modes]) for s in isolated)
    verdict = problem.case_of(solutions), modes, len(isolated) < len(solutions)
    return (*verdict, problem.uniqueness()), [s.forces for s in isolated]


def same_forces(problem, first, second):
    """Return whether two lists of forces agree, each entry by the accelerations it makes."""
    size = np.sqrt(np.diag(problem.W))
    for F in first:
        largest = np.max(size * np.abs(F), initial=0.0)
        near = [np.all(size * np.abs(F - G) <= 1e-9 * largest) for G in second]
        if not any(near):
            return False
    return len(first) == len(second)


@settings(max_examples=200)
@given(contacts(), st.integers(-12, 6))
def test_solutions_agree_with_mode_analysis_for_friction_over_many_decades(data, power):
    *rest, mu, v = data
    mu = Fraction(float(mu) * 10.0**power)
    expected, solutions = mode_analysis(*rest, mu, v), built((*rest, mu, v)).solutions()
    if expected is None:
        return
    assert sorted(s.mode.value for s in solutions) == sorted(m.value for m, _, _ in expected)
    for mode, force, friction in expected:
        (s,) = (s for s in solutions if s.mode is mode)
        assert s.normal_force == pytest.approx(float(force), rel=1e-9)
        # Beside the rounding of the terms of a_t, from which F_t is a difference.
        assert s.tangential_force == pytest.approx(float(friction), rel=1e-9, abs=1e-14 * force)
        assert s.isolated


@settings(max_examples=80)
@given(problems(), decades, decades, decades)
def test_solutions_scale_with_the_units_of_mass_length_and_time(problem, mass, length, time):
    acceleration = length / time**2
    other = changed(problem, np.ones(problem.size), acceleration, 1 / mass)
    (here, forces), (there, others) = solved(problem), solved(other)
    assert here == there
    assert same_forces(problem, [mass * acceleration * F for F in forces], others)


@settings(max_examples=80)
@given(problems(), st.lists(decades, min_size=3, max_size=3))
def test_solutions_do_not_depend_on_the_size_of_each_contact(problem, sizes):
    rows = np.array(sizes[: problem.size])
    other = changed(problem, rows)
    (here, forces), (there, others) = solved(problem), solved(other)
    assert here == there
    assert same_forces(problem, forces, [np.repeat(rows, 2) * F for F in others])


@settings(max_examples=60)
@given(problems())
def test_solutions_of_the_mirror_image_slip_the_other_way(problem):
    other = changed(problem, np.ones(problem.size), mirror=-1.0)
    (case, modes, wide, promise), forces = solved(problem)
    solutions = other.solutions()
    swapped = [str([SWAPPED[m].value for m in s.modes]) for s in solutions if s.isolated]
    assert sorted(swapped) == modes and other.uniqueness() is promise
    assert any(not s.isolated for s in solutions) == wide and other.case_of(solutions) is case
    signs = np.tile([1.0, -1.0], problem.size)
    mirrored = [s.forces for s in solutions if s.isolated]
    assert same_forces(problem, [signs * F for F in forces], mirrored)


@settings(max_examples=60)
@given(problems(sizes=st.integers(2, 3)), st.randoms(use_true_random=False))
def test_solutions_permute_with_contacts_of_both_kinds(problem, random):
    order = list(range(problem.size))
    random.shuffle(order)
    other = changed(problem, np.ones(problem.size), order=order)
    ((case, _, wide, promise), forces), (there, others) = solved(problem), solved(other)
    assert (case, wide, promise) == (there[0], *there[2:])
    rows = [2 * i + k for i in order for k in (0, 1)]
    assert same_forces(other, [F[rows] for F in forces], others)


@settings(max_examples=60)
@given(problems(sizes=st.just(1)), problems(sizes=st.just(1)))
def test_solutions_of_contacts_that_do_not_feel_each_other_are_all_pairs(first, second):
    W = np.zeros((4, 4))
    W[:2, :2], W[2:, 2:] = first.W, second.W
    data = ([*a, *b] for a, b in zip(_data(first), _data(second), strict=True))
    both = ContactProblem(W, *data)
    singles = [p.solutions() for p in (first, second)]
    pairs = [(s, t) for s in singles[0] for t in singles[1]]
    solutions = both.solutions()
    assert bool(solutions) == bool(pairs)
    expected = [np.append(s.forces, t.forces) for s, t in pairs if s.isolated and t.isolated]
    assert same_forces(both, expected, [s.forces for s in solutions if s.isolated])


def _data(problem):
    return problem.b, problem.mu, problem.slip_velocity, problem.bilateral
