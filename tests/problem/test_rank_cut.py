"""Choices of pieces that are left out have no motion of their own."""

from unittest import mock

import numpy as np
import pytest

import painleve_sym as ps
from painleve_sym.problem import families
from painleve_sym.problem.products import PieceProduct
from painleve_sym.problem.rank_cut import RankCut


def body(points, normals, force):
    """Return W and b of contacts of one body of mass 1 and inertia 0.3, by its force and moment."""
    rows = []
    for (x, y), (n, m) in zip(points, normals, strict=True):
        rows += [(u, v, x * v - y * u) for u, v in ((n, m), (m, -n))]
    J = np.array(rows, dtype=float)
    inverse = np.diag([1.0, 1.0, 1 / 0.3])
    return J @ inverse @ J.T, J @ inverse @ np.array(force, dtype=float)


def level(n, force=(0.0, -9.8, 0.0), mu=0.5, slip=0.0):
    """Return the problem of a body on n feet in a row, 0.5 below its centre."""
    points = [(x, -0.5) for x in np.linspace(-0.5, 0.5, n)]
    W, b = body(points, [(0.0, 1.0)] * n, force)
    return ps.ContactProblem(W, b, np.full(n, mu), np.full(n, slip))


def random_problem(seed):
    """Return a problem of three or four contacts with small integers, such as wedges."""
    draw = np.random.default_rng(seed)
    n = int(draw.integers(3, 5))
    points = draw.integers(-2, 3, (n, 2)) / 2
    ways = [(0.0, 1.0), (0.0, 1.0), (1.0, 0.0), (0.6, 0.8)]
    normals = [ways[k] for k in draw.integers(0, len(ways), n)]
    force = (*draw.integers(-2, 3, 1), draw.choice([-9.8, -1.0, 0.0]), *draw.integers(-2, 3, 1))
    W, b = body(points, normals, force)
    mu = draw.choice([0.0, 0.3, 0.5, 1.0, 2.0], n)
    slip = draw.integers(-1, 2, n) if seed % 3 == 0 else np.zeros(n)
    return ps.ContactProblem(W, b, mu, slip.astype(float))


def answer(problem):
    """Return what a problem says of its motions, with accelerations and forces as numbers."""
    motions = [(s.modes, s.open_forces, s.moves) for s in problem.solutions()]
    numbers = [np.concatenate([s.accelerations, s.forces], axis=None) for s in problem.solutions()]
    return (motions, problem.borders, problem.case), numbers


def trying_all(problem):
    """Return the same where every choice is tried."""
    with mock.patch.object(PieceProduct, "_cut", None):
        again = ps.ContactProblem(
            problem.W, problem.b, problem.mu, problem.slip_velocity, problem.bilateral
        )
        return answer(again)


@pytest.mark.parametrize("seed", range(24))
def test_solutions_are_those_of_all_choices(seed):
    problem = random_problem(seed)
    (said, numbers), (other, exhaustive) = answer(problem), trying_all(problem)
    assert said == other
    for own, one in zip(numbers, exhaustive, strict=True):
        np.testing.assert_allclose(own, one, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("n", "open_forces"), [(3, 3), (4, 5), (5, 7)])
def test_feet_at_rest_have_one_motion_and_two_forces_more_for_each(n, open_forces):
    """2 n forces, and three equations of equilibrium."""
    (solution,) = level(n).solutions()
    assert (solution.open_forces, solution.moves) == (open_forces, False)
    np.testing.assert_allclose(solution.accelerations, 0, atol=1e-12)
    assert solution.normal_forces.sum() == pytest.approx(9.8)


def test_feet_that_are_pushed_slide_together():
    """Of mass 1 with μ = 0.1: 0.98 N of friction; four normal forces, two equations."""
    (solution,) = level(4, force=(2.0, -9.8, 0.0), mu=0.1).solutions()
    assert set(solution.modes) == {ps.ContactMode.SLIP_POS}
    np.testing.assert_allclose(solution.accelerations[..., 1], 2.0 - 0.98, rtol=1e-12)
    assert solution.open_forces == 2


def test_few_choices_of_four_feet_are_tried():
    with mock.patch.object(families.Family, "inside", autospec=True) as inside:
        level(4).solutions()
    assert inside.call_count == 0
    product = PieceProduct(level(4)._law)
    _, singular = product.solve()
    assert len(singular) < 60 < 150 < len(product.left)


def test_a_wedge_in_which_forces_hold_each_other_is_tried_whole():
    W, b = body([(-1, 0), (1, 0), (0, -1)], [(1, 0), (-1, 0), (0, 1)], (0, -1, 0))
    law = ps.ContactProblem(W, b, np.full(3, 0.5), np.zeros(3))._law
    product = PieceProduct(law)
    assert not RankCut(law, product.offered, product.ways).applies
    flat = PieceProduct(level(3)._law)
    assert RankCut(flat.law, flat.offered, flat.ways).applies
