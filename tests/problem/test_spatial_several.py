"""Several contacts, in space or in space and in the plane together."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.linalg import block_diag

import painleve_sym as ps
from tests.problem.test_spatial_contact import random_problem


def definite(rng, size):
    root = rng.normal(size=(size, size))
    return root @ root.T + 0.05 * np.eye(size)


def all_forces(solutions):
    return np.array([s.forces for s in solutions])


def assert_same(first, second):
    """Assert that two lists of forces are the same but for their order."""
    assert len(first) == len(second)
    left = list(second)
    for force in first:
        near = [np.allclose(force, other, rtol=1e-6, atol=1e-7) for other in left]
        assert any(near), (force, left)
        del left[near.index(True)]


def law_defect(problem, solution):
    """Return the largest violation of Coulomb's law and of a = W F + b, in their own units."""
    forces, accelerations = solution.forces, solution.accelerations
    rigid = problem.W @ forces + problem.b
    worst = np.abs(rigid - accelerations).max()
    for F, a, (friction,), slip in zip(
        solution.contact_forces,
        solution.contact_accelerations,
        problem.friction,
        problem.slips,
        strict=True,
    ):
        worst = max(worst, -F[0], -a[0], abs(F[0] * a[0]))
        worst = max(worst, np.linalg.norm(F[1:]) - friction.mu * F[0])
        way = np.array(slip) if np.any(slip) else a[1:]
        lost = friction.mu * F[0] * np.linalg.norm(way)
        worst = max(worst, abs(F[1:] @ way + lost))
    return worst


def test_contacts_that_do_not_feel_each_other_have_the_solutions_of_each():
    rng = np.random.default_rng(3)
    several = 0
    for _ in range(12):
        alone = [random_problem(rng) for _ in range(2)]
        # Of comparable sizes: which contacts are one body's is what the scales say.
        alone = [(W / W[0, 0], b / np.abs(b).max(), min(mu, 5.0)) for W, b, mu in alone]
        single = [ps.contact(W, b, mu).solutions() for W, b, mu in alone]
        whole = ps.ContactProblem(
            block_diag(*(W for W, _, _ in alone)),
            np.concatenate([b for _, b, _ in alone]),
            [ps.Disc(mu) for _, _, mu in alone],
            [(0.0, 0.0)] * 2,
        )
        pairs = itertools.product(*single)
        expected = [np.concatenate([s.force for s in pair]) for pair in pairs]
        own = all_forces(whole.solutions())
        assert_same(own, expected)
        several += len(own) > 1
        assert not whole.complete and "not guaranteed" in whole.guarantee
    assert several


def test_every_solution_obeys_the_law():
    rng = np.random.default_rng(4)
    kinds = ps.Disc, ps.Interval
    for _ in range(20):
        sets = [kinds[i](rng.uniform(0, 2)) for i in rng.integers(0, 2, size=2)]
        size = sum(1 + s.n_tangents for s in sets)
        slip = [rng.normal(size=s.n_tangents) * rng.integers(0, 2) for s in sets]
        problem = ps.ContactProblem(definite(rng, size), rng.normal(size=size), sets, slip)
        for solution in problem.solutions():
            scale = max(1.0, np.abs(solution.forces).max())
            assert law_defect(problem, solution) < 1e-8 * scale**2


def test_sliding_discs_are_the_planar_contacts_of_their_slip():
    rng = np.random.default_rng(6)
    counts = set()
    for _ in range(40):
        W, b, mu = definite(rng, 6), rng.normal(size=6), rng.uniform(0, 4, size=2)
        e = [v / np.linalg.norm(v) for v in rng.normal(size=(2, 2))]
        turn = block_diag(*(np.array([[1, 0, 0], [0, *way]]) for way in e))
        space = ps.ContactProblem(W, b, [ps.Disc(m) for m in mu], e)
        plane = ps.ContactProblem(turn @ W @ turn.T, turn @ b, mu, [1.0, 1.0])
        assert space.complete
        own = all_forces(space.solutions())
        assert_same(own, [turn.T @ s.forces for s in plane.solutions()])
        counts.add(len(own))
    assert len(counts) > 1


@pytest.mark.slow
def test_one_disc_at_rest_among_others_has_all_its_solutions():
    """Each obeys the law; contacts that do not feel each other have the solutions of each."""
    rng, counts = np.random.default_rng(9), set()
    for k in range(40):
        other = (ps.Disc, ps.Interval)[k % 2](rng.uniform(0.1, 3))
        sets = [ps.Disc(rng.uniform(0.1, 3)), other]
        size = 4 + other.n_tangents
        slip = [(0.0, 0.0), rng.normal(size=other.n_tangents)]
        if k % 4 == 1:
            slip[1] = [0.0]
        W, b = definite(rng, size), rng.normal(size=size)
        problem = ps.ContactProblem(W, b, sets, slip)
        assert problem.complete and "all solutions" in problem.guarantee
        solutions = problem.solutions()
        own = all_forces(solutions)
        assert all(law_defect(problem, s) < 1e-7 for s in solutions)
        counts.add(len(own))
        cases = ps.ContactCase.INCONSISTENT, ps.ContactCase.UNIQUE, ps.ContactCase.INDETERMINATE
        assert problem.case_of(solutions) is cases[min(len(own), 2)]
    assert {0, 1, 2} <= counts
    for _ in range(20):
        (W, b, mu), (V, a, nu) = (random_problem(rng) for _ in range(2))
        W, b, V, a = W / W[0, 0], b / np.abs(b).max(), V / V[0, 0], a / np.abs(a).max()
        v = rng.normal(size=2)
        singles = ps.contact(W, b, mu).solutions(), ps.contact(V, a, nu, v).solutions()
        whole = ps.ContactProblem(
            block_diag(W, V), [*b, *a], [ps.Disc(mu), ps.Disc(nu)], [(0.0, 0.0), v]
        )
        pairs = itertools.product(*singles)
        expected = [np.concatenate([s.force for s in pair]) for pair in pairs]
        assert_same(all_forces(whole.solutions()), expected)


def test_discs_in_a_plane_of_symmetry_have_the_planar_solutions():
    rng = np.random.default_rng(7)
    inside = [0, 1, 3, 4]
    for _ in range(6):
        W, b = definite(rng, 6), rng.normal(size=6)
        across = [2, 5]
        W[np.ix_(inside, across)] = W[np.ix_(across, inside)] = 0.0
        b[across] = 0.0
        mu = rng.uniform(0.1, 2, size=2)
        space = ps.ContactProblem(W, b, [ps.Disc(m) for m in mu], [(0.0, 0.0)] * 2)
        plane = ps.ContactProblem(W[np.ix_(inside, inside)], b[inside], mu, [0.0, 0.0])
        forces = all_forces(space.solutions())
        forces = forces[np.abs(forces[:, across]).max(axis=1) < 1e-9][:, inside]
        assert_same(forces, [s.forces for s in plane.solutions()])


def test_four_feet_of_one_body_have_one_motion():
    """A block of mass 1 on four corners: its weight may rest on any of them."""
    feet = [(x, y, -0.2) for x in (-1.0, 1.0) for y in (-0.5, 0.5)]
    M = np.diag([1.0, 1.0, 1.0, 0.2, 0.4, 0.5])
    rows = []
    for x, y, z in feet:
        velocity = np.array([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]])
        rows += [velocity[2], velocity[0], velocity[1]]
    J = np.array(rows)
    pull = np.array([3.0, 0.0, -9.8, 0.0, 0.0, 0.0])
    problem = ps.ContactProblem(
        J @ np.linalg.solve(M, J.T),
        J @ np.linalg.solve(M, pull),
        [ps.Disc(0.5)] * 4,
        [(0.0, 0.0)] * 4,
    )
    solutions = problem.solutions()
    assert problem.case_of(solutions) is ps.ContactCase.HYPERSTATIC
    [solution] = solutions
    assert solution.isolated is False
    assert np.sum(solution.contact_forces, axis=0) == pytest.approx([9.8, -3.0, 0.0])
    assert set(solution.modes) <= {ps.ContactMode.STICK, ps.ContactMode.LIFTOFF}


def test_too_many_contacts_are_refused():
    sets = [ps.Disc(0.5)] * 5
    problem = ps.ContactProblem(np.eye(15), -np.ones(15), sets, [(0.0, 0.0)] * 5)
    message = "5 contacts, 5 of them in space at rest, need at most 4"
    with pytest.raises(ps.InputError, match=message):
        problem.solutions()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"friction": [ps.Disc(0.5), 0.5]}, "need an Interval, a Disc, a Brake or a tuple"),
        ({"friction": [(ps.Disc(0.5), ps.Brake(1.0))]}, "a Brake beside another ball"),
        ({"friction": [-0.5]}, "mu >= 0"),
        ({"slip_velocity": []}, r"slip_velocity: got shape \(0,\), need \(2,\) for 1 contacts"),
        ({"W": np.eye(2)}, r"W: got shape \(2, 2\), need \(3, 3\)"),
        ({"slip_velocity": [("a", 0.0)]}, "slip_velocity"),
    ],
)
def test_bad_input_has_one_sentence(given, message):
    whole = {"W": np.eye(3), "b": np.zeros(3), "friction": [ps.Disc(0.5)]}
    whole["slip_velocity"] = [(0.0, 0.0)]
    with pytest.raises(ps.InputError, match=message):
        ps.ContactProblem(**whole | given)


@pytest.mark.parametrize(
    ("rank", "slip", "exists"), [(9, 0.0, True), (8, 0.0, False), (6, 0.0, False), (9, 1.0, False)]
)
def test_that_there_is_a_solution_is_said_of_a_regular_w_at_rest_alone(rank, slip, exists):
    J = np.random.default_rng(rank).normal(size=(9, rank))
    slips = [(0.0, 0.0), (0.0, 0.0), (slip, 0.0)]
    problem = ps.ContactProblem(J @ J.T, [-1.0, 0.1, 0.2] * 3, [ps.Disc(0.5)] * 3, slips)
    assert not problem.complete
    assert ("there is at least one" in problem.guarantee) == exists
