"""Cases and sticking of one contact at arrays of states are those of the contact problem."""

from __future__ import annotations

import numpy as np
import pytest

from painleve_sym.problem.case_codes import LEGEND, can_stick, case_codes
from painleve_sym.problem.risk import schur_complement, slip_slope
from tests.problem.problems import case_of, planar, spatial, turned

NAMES = {code: name for name, code in LEGEND.items()}
MADE = {
    "plane": planar,
    "space": spatial,
    "turned": lambda rng, n: turned(rng, spatial(rng, n))[0],
}


def problems(make, wanted, count=1500):
    rng = np.random.default_rng(7)
    drawn = (MADE[make](rng, 1) for _ in range(count))
    return [p for p in drawn if np.any(p.slip[0]) == wanted]


@pytest.mark.parametrize("make", MADE)
def test_case_of_a_slip_is_that_of_its_contact_problem(make):
    seen = set()
    for problem in problems(make, True):
        v = np.array(problem.slip[0], float)
        sides = (1, -1) if problem.closed[0] else (1,)
        W, mu = np.array(problem.W, float), float(problem.mu[0])
        A = [slip_slope(W, mu, v / np.linalg.norm(v), side) for side in sides]
        code = NAMES[int(case_codes(A, np.array(float(problem.b[0]))))]
        case = case_of(problem.answers())
        # A ray of forces is several answers here, whether the motion moves with it or not.
        expected = {"unique": {"slip", "liftoff"}, "hyperstatic": {"indeterminate"}}
        assert code in expected.get(case, {case})
        seen.add(code)
    assert seen == {"slip", "liftoff", "inconsistent", "indeterminate"}


@pytest.mark.parametrize("make", MADE)
def test_sticking_is_an_answer_of_the_contact_problem_at_rest(make):
    seen = set()
    for problem in problems(make, False):
        W, b = np.array(problem.W, float), np.array(problem.b, float)
        sides = (1, -1) if problem.closed[0] else (1,)
        slope, free = (part.ravel()[0] for part in schur_complement(W, b, 1))
        if slope <= 1e-12 * W[0, 0]:
            continue  # any normal force, or none, moves nothing in sticking
        with np.errstate(all="ignore"):
            sticks = bool(can_stick(W, b, np.array(float(problem.mu[0])), (slope, free), sides))
        assert sticks == any(
            problem.closed[0] or any(answer.checked.forces)
            for answer in problem.answers().all
            if not any(np.abs(answer.checked.motion.a) > 1e-9)
        )
        seen.add(sticks)
    assert seen == {True, False}
