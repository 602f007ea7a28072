"""Contact problems of small integers, low rank and borders, asked through several doors."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import painleve_sym as ps
from tests.problem import problems, rational
from tests.problem.problems import OPEN, agree, verdict

DATA = Path(__file__).parent


def exact_differences(seed, count, n):
    """Return how many planar problems have another case or number of motions than the rationals."""
    rng, counts = np.random.default_rng(seed), Counter()
    for _ in range(count):
        problem = problems.planar(rng, n)
        exact = rational.solutions_of(
            problem.W.tolist(), problem.b.tolist(), problem.mu, [v[0] for v in problem.slip],
            problem.closed,
        )  # fmt: skip
        own = verdict(problem.answers())
        same = own.case == exact.case
        if not exact.moves:
            same = same and len(own.motions) == len(exact.motions)
            same = same and sorted(own.is_open) == sorted(exact.motions.values())
        counts[exact.case] += 1
        counts["different"] += not same
    assert len(counts) > 4
    return counts["different"]


@pytest.mark.parametrize("n", [1, 2])
def test_planar_problems_agree_with_rational_arithmetic(n):
    assert exact_differences(5, 250 if n == 1 else 120, n) == 0


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 2])
def test_many_planar_problems_agree_with_rational_arithmetic(n):
    assert exact_differences(17, 5000, n) == 0


def door_differences(seed, count, n, most_resting=1):
    """Return how many problems differ by a change that means nothing.

    A disc with an uncoupled second tangent beside the planar contact; other tangents; another
    order, other units, a mirror. Counted apart: where one of both states a border, where one states
    nothing definite, and all problems.
    """
    rng, counts = np.random.default_rng(seed), Counter()
    while counts["all"] < count:
        if rng.random() < 1 / 3:
            plane = problems.planar(rng, n)
            space, rows = problems.with_discs(rng, plane)
            if space.resting_discs > most_resting:
                continue
            one, other = plane.answers(), space.answers()
            verdicts = verdict(one), verdict(other, rows=rows)
        else:
            problem = problems.spatial(rng, n)
            if problem.resting_discs > most_resting:
                continue
            change = (problems.turned, problems.renumbered)[int(rng.integers(2))]
            changed, to = change(rng, problem)
            one, other = problem.answers(), changed.answers()
            verdicts = verdict(one, to), verdict(other)
        scale = float(np.max(np.abs(other.law.b * np.array(other.law.rate_unit)))) or 1.0
        counts["all"] += 1
        if agree(*verdicts, scale):
            continue
        if OPEN & {v.case for v in verdicts}:
            counts["open"] += 1
        elif one.borders or other.borders:
            counts["border"] += 1
        else:
            counts["different"] += 1
    return counts


@pytest.mark.parametrize(("n", "count"), [(1, 400), (2, 60)])
def test_what_means_nothing_changes_nothing(n, count):
    counts = door_differences(3, count, n)
    assert counts["different"] == counts["open"] == 0 and counts["border"] <= count / 20


@pytest.mark.slow
@pytest.mark.parametrize(("n", "count"), [(1, 6000), (2, 2000), (3, 150)])
def test_what_means_nothing_changes_nothing_in_many_problems(n, count):
    counts = door_differences(29, count, n)
    assert counts["different"] == counts["open"] == 0 and counts["border"] <= count / 20


@pytest.mark.slow
def test_two_discs_at_rest_do_not_contradict_each_other():
    counts = door_differences(31, 500, 2, most_resting=2)
    assert counts["different"] == 0 and counts["border"] <= 25


def slips_missed(seed, count):
    rng, missed = np.random.default_rng(seed), 0
    for _ in range(count):
        root = rng.normal(size=(3, 3))
        b = rng.normal(size=3)
        b[0] *= 10.0 ** -rng.uniform(3, 12) * (1 if rng.random() < 0.3 else -np.sign(b[0]))
        answer = ps.contact(root @ root.T, b, 10 ** rng.uniform(-1, 1))
        missed += len(answer.solutions()) % 2 == 0
    return missed


def test_no_slip_is_missed_where_the_normal_acceleration_is_small():
    """A definite W has one solution or three."""
    assert slips_missed(1, 400) == 0


@pytest.mark.slow
def test_no_slip_is_missed_in_many_problems():
    assert slips_missed(2, 20_000) == 0


# ---- single problems ----


def test_one_motion_with_open_forces_is_hyperstatic_for_one_contact_too():
    problem = ps.ContactProblem([[1, 1], [1, 1]], [-1, -1], 2, 0)
    (solution,) = problem.solutions()
    assert problem.case == "hyperstatic" and solution.open_forces == 1 and not solution.moves
    # Of F_n + F_t = 1 the shortest.
    assert solution.forces == pytest.approx([0.5, 0.5])
    arm = ps.contact([[2, 1, 0], [1, 2, 0], [0, 0, 0]], [-3, 0, 0], 2.0)
    assert arm.case == "hyperstatic" and arm.solutions()[0].force == pytest.approx([2, -1, 0])


@pytest.mark.parametrize("excess", [0.0, 1e-15, 1e-12, 1e-10, 1e-6])
def test_forces_at_infinity_are_no_solution(excess):
    """From μ = 2 on no force satisfies both equations of the slip."""
    mu = 2 * (1 + excess)
    space = ps.contact([[4, -2, 0], [-2, 1, 0], [0, 0, 1]], [-1, -1, 0], mu)
    plane = ps.ContactProblem([[4, -2], [-2, 1]], [-1, -1], mu, 0)
    assert space.case == plane.case == "inconsistent"
    near = excess < 1e-14
    assert ("infinity" in space.borders) == ("infinity" in plane.borders) == near


def test_forces_that_are_rounding_are_no_solution():
    """A = 4 - 2 μ is some roundings of its terms: so would b be of the terms of such forces."""
    problem = ps.ContactProblem([[4, -2], [-2, 1]], [-1, -1], 2 * (1 - 4e-15), 0)
    assert problem.A_slip(-1) > 0 and problem.case == "inconsistent"


def test_forces_near_infinity_are_a_solution():
    for mu in (2 * (1 - 1e-10), 2 * (1 - 1e-6)):
        space = ps.contact([[4, -2, 0], [-2, 1, 0], [0, 0, 1]], [-1, -1, 0], mu)
        (plane,) = ps.ContactProblem([[4, -2], [-2, 1]], [-1, -1], mu, 0).solutions()
        assert space.case == "slip"
        assert space.solutions()[0].force[:2] == pytest.approx(plane.forces, rel=1e-9)
        assert plane.normal_force == pytest.approx(1 / (4 - 2 * mu), rel=1e-5)


def test_a_slip_under_a_small_load_has_its_force():
    answer = ps.contact([[2, 0, 1], [0, 2, -2], [1, -2, 7]], [-1e-6, -1, -3], 1.0)
    (solution,) = answer.solutions()
    expected = [3.39134433e-07, 1.07243842e-07, 3.21731113e-07]
    assert answer.case == "slip" and solution.force == pytest.approx(expected, rel=1e-8)


def test_a_slip_at_the_border_of_a_sector_takes_its_force_from_the_tangents():
    """Without b_n it begins where A = 0; its direction is that of the border."""
    W, b, mu = np.array([[2, 1.5, 0.2], [1.5, 2, 0.1], [0.2, 0.1, 2]]), np.array([0, 0.4, -1.2]), 3
    modes = {s.mode.value: s for s in ps.contact(W, b, mu).solutions()}
    assert set(modes) == {"liftoff", "slip", "stick"}
    force, e = modes["slip"].force, modes["slip"].direction
    assert 2 - mu * (1.5 * e[0] + 0.2 * e[1]) == pytest.approx(0, abs=1e-12)
    motion = W @ force + b
    assert motion == pytest.approx([0, *(np.hypot(*motion[1:]) * np.array(e))])
    assert np.hypot(*force[1:]) == pytest.approx(mu * force[0])


def test_a_continuum_of_slips_is_not_isolated():
    answer = ps.contact([[2, 1.5, 0], [1.5, 2, 0], [0, 0, 2]], [0, 1, 0], 4 / 3)
    assert answer.case == "indeterminate"
    solutions = answer.solutions()
    assert [s.moves for s in solutions] == [True] * len(solutions)
    (slip,) = (s for s in solutions if s.mode == "slip")
    F, a = slip.force, slip.acceleration
    assert F[1] == pytest.approx(-4 / 3 * F[0]) and a[0] == 0 and a[1] > 0


def test_two_discs_whose_slip_a_search_missed():
    W, b, mu = json.loads((DATA / "two-discs.json").read_text())
    discs = [ps.Disc(m) for m in mu]
    problem = ps.ContactProblem(W, b, discs, [(0.0, 0.0)] * 2)
    (solution,) = problem.solutions()
    force = [0.29334013, -0.43211192, -0.55266543, 2.20063481, -1.16945776, 1.05828066]
    assert solution.forces == pytest.approx(force, rel=1e-6)
    # One is known: directions of two slips at once have no finite list.
    assert problem.case == "one_known" and "not guaranteed" in problem.guarantee
    assert problem.case_of([]) == "unknown"


def test_an_even_number_of_solutions_proves_a_miss(monkeypatch):
    from painleve_sym.problem import answers

    W, b, mu = json.loads((DATA / "two-discs.json").read_text())
    monkeypatch.setattr(answers, "search", lambda *_: [])
    problem = ps.ContactProblem(W, b, [ps.Disc(m) for m in mu], [(0.0, 0.0)] * 2)
    kept = problem.solutions()
    missing = [s for s in kept if s.modes.count(ps.ContactMode.SLIP) == 2]
    assert not missing
    if len(kept) % 2 == 0:
        assert "proves that there are more" in problem.guarantee


@pytest.mark.parametrize(
    ("b", "mu", "border"),
    [
        ([0.0, 0.3], 0.5, "grazing"),
        ([-2.0, 1.0], 0.5, "edge"),
        ([-2.0, 0.3], 0.5, None),
    ],
)
def test_a_border_is_stated(b, mu, border):
    problem = ps.ContactProblem(np.eye(2), b, mu, 0)
    assert problem.borders == ((border,) if border else ())
    lifted = ps.ContactProblem(np.eye(3), [*b, 0.0], [ps.Disc(mu)], [(0.0, 0.0)])
    assert lifted.borders == problem.borders
