"""The contact problem of an export against the package: W, b, A, B and the case."""

from __future__ import annotations

import ctypes
import functools
import itertools
import math
from collections import Counter

import numpy as np
import pytest

from painleve_sym.at.cases import contact_problem
from painleve_sym.c_export.contacts import CASES
from painleve_sym.c_export.export import export_scenario
from painleve_sym.problem.case_codes import LEGEND, case_codes
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.solution import ContactCase
from painleve_sym.study.scenario import Scenario
from tests.problem import problems
from tests.support.exports import address, library

SCENARIOS = {
    "rod": Scenario("rod", {"theta": 1.0, "x_A_dot": -1.0}, law="rigid", t_end=1e-4),
    "guide": Scenario("painleve-klein", law="rigid", t_end=1e-4),
    "feet": Scenario("block-two-feet", {"y_A": 0.05, "theta": 0.1}, law="rigid", t_end=1e-4),
}
NUMBERS = ("B", "A_stick", "B_stick", "mu", "W_nn", "W_nt", "W_tt", "b_n", "b_t")


class Coefficients(ctypes.Structure):
    _fields_ = (("A", ctypes.c_double * 2), *((name, ctypes.c_double) for name in NUMBERS))


class Solutions(ctypes.Structure):
    _fields_ = (
        ("count", ctypes.c_int),
        ("normal_force", ctypes.c_double * 6),
        ("tangential_force", ctypes.c_double * 6),
        ("slip", ctypes.c_int * 6),
        ("mode", ctypes.c_int * 6),
    )


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    """Return a function that exports a scenario as `mine` and compiles it, each once."""

    @functools.cache
    def built(name):
        done = export_scenario(SCENARIOS[name], tmp_path_factory.mktemp(name) / "c", "mine")
        return done, library(done)

    return built


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(name, marks=pytest.mark.slow if name != "rod" else ()) for name in SCENARIOS
    ],
)
def exported(request, build):
    return SCENARIOS[request.param], *build(request.param)


def states(mechanism, count):
    """Yield states, half of them without slip, with parameters that make the paradox common."""
    rng = np.random.default_rng(11)
    names = [p.name for p in mechanism.system.parameters]
    friction = [c.friction.name for c in mechanism.contacts]
    for k in range(count):
        state = dict(zip(mechanism.state_names, rng.normal(size=99) * 3, strict=False))
        given = {name: float(rng.uniform(0.1, 4)) for name in friction if name in names}
        if k % 2:
            state |= {name: 0.0 for name in state if name.endswith("_dot")}
        yield state, mechanism.at(state, given).parameters


def test_contact_problem_coefficients_and_case_are_the_packages(exported):
    scenario, done, c = exported
    mechanism = scenario.mechanism()
    simulator, n = simulator_of(scenario), len(mechanism.contacts)
    slips = [simulator.outline.state_names.index(row.slip) for row in simulator.contact.rows]
    seen = set()
    for state, parameters in states(mechanism, 400):
        names = simulator.outline.parameter_names
        p = np.array([parameters.get(s, done.trajectory.parameters[s]) for s in names])
        x = np.zeros(len(simulator.outline.state_names))
        x[: len(state)] = list(state.values())
        whole = contact_problem(mechanism, state, parameters)
        for i, slip in enumerate(slips):
            x[slip] = whole.slip_velocity[i]
        W, b, mu = np.empty((2 * n, 2 * n)), np.empty(2 * n), np.empty(n)
        c.mine_contact_problem(*map(address, (p, x, W, b, mu)))
        np.testing.assert_allclose(W, whole.W, rtol=1e-12, atol=1e-14)
        np.testing.assert_allclose(b, whole.b, rtol=1e-11, atol=1e-12)
        np.testing.assert_array_equal(mu, whole.mu)
        for i in range(n):
            rows = slice(2 * i, 2 * i + 2)
            bilateral = np.array([mechanism.contacts[i].bilateral])
            one = ContactProblem(
                W[rows, rows], b[rows], mu[i : i + 1], x[slips[i : i + 1]], bilateral
            )
            numbers = Coefficients()
            c.mine_contact_coefficients(address(p), address(x), i, ctypes.byref(numbers))
            assert numbers.A[0] == one.A_slip(-1) and numbers.A[1] == one.A_slip(1)
            assert (numbers.B, numbers.mu) == (one.B, one.mu.item())
            if numbers.W_tt > 0:
                wanted = (
                    one.W_nn - one.W_nt**2 / one.W_tt,
                    one.b_n - one.W_nt * one.b_t / one.W_tt,
                )
                np.testing.assert_allclose(
                    (numbers.A_stick, numbers.B_stick), wanted, rtol=1e-9, atol=1e-9
                )
            case = CASES[c.mine_classify(address(p), address(x), i)]
            every = one.solutions()
            assert case is one.case_of(every), (state, parameters, i)
            seen.add(case)
            listed = Solutions()
            assert CASES[c.mine_solve(address(p), address(x), i, ctypes.byref(listed))] is case
            # Its coefficients tell the case in slip, whatever slip velocity the state has.
            for s in (-1, 1):
                slides = ContactProblem(one.W, one.b, one.mu, np.array([float(s)]), bilateral)
                given = CASES[c.mine_case_in_slip(ctypes.byref(numbers), i, s)]
                assert given is slides.case_of(slides.solutions()), (state, parameters, i, s)
            if all(s.isolated for s in every):
                forces = [(s.normal_force, s.tangential_force) for s in every]
                pairs = zip(listed.normal_force, listed.tangential_force, strict=True)
                own = list(pairs)[: listed.count]
                np.testing.assert_allclose(sorted(own), sorted(forces), rtol=1e-9, atol=1e-9)
    assert len(seen) >= 3


def simulator_of(scenario):
    from painleve_sym.motion.simulator import Simulator

    return Simulator(scenario.mechanism(), scenario.contact_law(), scenario.engine)


def test_cases_of_the_paper_are_those_of_its_tables(build):
    """Table 3 is inconsistent, Table 1 slips; the friction that separates them is the package's."""
    (done, c), simulator = build("rod"), simulator_of(SCENARIOS["rod"])
    names = simulator.outline.state_names
    p = np.array([done.trajectory.parameters[s] for s in simulator.outline.parameter_names])

    def case(**given):
        x = np.zeros(len(names))
        for name, value in given.items():
            x[names.index(name)] = value
        x[names.index("x_A_dot")] = -1.0
        c.mine_complete_state(address(p), address(x))
        return CASES[c.mine_classify(address(p), address(x), 0)]

    assert case(theta=0.5, theta_dot=1.0) is ContactCase.SLIP
    assert case(theta=0.5, theta_dot=5.0) is ContactCase.LIFTOFF
    assert case(theta=1.0, theta_dot=1.0) is ContactCase.INCONSISTENT
    assert case(theta=1.0, theta_dot=5.0) is ContactCase.INDETERMINATE
    # Vertical, A = (3 cos(theta) (cos(theta) - mu sin(theta)) + 1)/m is 1/m.
    numbers = Coefficients()
    x = np.zeros(len(names))
    x[names.index("theta")] = math.pi / 2
    c.mine_contact_coefficients(address(p), address(x), 0, ctypes.byref(numbers))
    mass = done.trajectory.parameters["m"]
    np.testing.assert_allclose(numbers.A[:], 1 / mass, rtol=1e-14)


def test_cases_in_slip_follow_the_signs_also_where_they_are_zero(exported):
    scenario, _, c = exported
    contacts = scenario.mechanism().outline.contacts
    words = {code: name for name, code in LEGEND.items()}
    signs = (-1.0, 0.0, 1.0)
    for A, pull, B, s in itertools.product(signs, signs, signs, (-1, 1)):
        numbers = Coefficients()
        numbers.A[s > 0], numbers.A[s < 0], numbers.B = A, pull, B
        numbers.W_nn, numbers.W_nt, numbers.b_n = (A + pull) / 2, s * (pull - A) / 2, B
        numbers.mu = numbers.W_tt = 1.0
        for i, contact in enumerate(contacts):
            slopes = (A, pull)[: len(contact.sides)]
            (wanted,) = case_codes([np.array([v]) for v in slopes], np.array([B]))
            given = CASES[c.mine_case_in_slip(ctypes.byref(numbers), i, s)]
            assert given.value == words[wanted], (A, pull, B, s)


@pytest.mark.parametrize("load", [0.0, pytest.param(1e-3, marks=pytest.mark.slow)])
def test_a_guide_that_needs_no_force_slips_on_or_stays(build, load):
    """Without a load B = 0, and no force is a solution beside those of the two signs."""
    scenario = SCENARIOS["guide"]
    _, c = build("guide")
    simulator = simulator_of(scenario)
    names, mechanism = simulator.outline.state_names, simulator.mechanism
    for speed, mu in itertools.product((-1.0, 0.0, 1.0), (0.5, 3.0)):
        given = {"P_1": load, "P_2": 0.0, "g": 0.0, "mu": mu}
        state, parameters = {"phi": 1.2, "x_dot": speed}, dict(mechanism.at({}, given).parameters)
        whole = dict.fromkeys(mechanism.state_names, 0.0) | state
        problem = contact_problem(mechanism, whole, parameters)
        p = np.array([parameters[n] for n in simulator.outline.parameter_names])
        x = np.zeros(len(names))
        for name, value in state.items():
            x[names.index(name)] = value
        c.mine_complete_state(address(p), address(x))
        listed = Solutions()
        case = CASES[c.mine_solve(address(p), address(x), 0, ctypes.byref(listed))]
        every = problem.solutions()
        assert (problem.b_n == 0) is (load == 0)
        assert case is problem.case_of(every), (speed, mu)
        if all(s.isolated for s in every):
            modes = sorted(CASES[mode].value for mode in listed.mode[: listed.count])
            assert modes == sorted(s.mode.value.partition("_")[0] for s in every)


def case_in_c(c, i, problem):
    """Return the case that the export states of the numbers of a planar problem of one contact."""
    (nn, nt), (_, tt) = W = np.array(problem.W, float)
    b = np.array(problem.b, float)
    stick = (nn - nt**2 / tt, b[0] - nt * b[1] / tt) if tt > 0 else (nn, b[0])
    one = ContactProblem(W, b, [float(problem.mu[0])], [0.0])
    A = (ctypes.c_double * 2)(one.A_slip(-1), one.A_slip(1))
    numbers = Coefficients(A, b[0], *stick, one.mu.item(), nn, nt, tt, *b)
    return CASES[c.mine_case_in_slip(ctypes.byref(numbers), i, problem.slip[0][0])]


def differences_from_kernel(build, seed, count, change):
    """Return how many cases differ from the kernel's, those on its borders apart."""
    rng, counts = np.random.default_rng(seed), Counter()
    libraries = {False: build("rod")[1], True: build("guide")[1]}
    for _ in range(count):
        problem = change(rng, problems.planar(rng, 1))
        given = case_in_c(libraries[problem.closed[0]], 0, problem)
        answers = problem.answers()
        wanted = problems.case_of(answers)
        same = given in (ContactCase.SLIP, ContactCase.STICK, ContactCase.LIFTOFF)
        if (same, "unique") != (True, wanted) and given != wanted:
            counts["border" if answers.borders else "different"] += 1
        counts[given] += 1
    assert len(counts.keys() - {"border", "different"}) == len(CASES)
    return counts["different"], counts["border"]


MANY = [pytest.param(700, id="few"), pytest.param(6000, id="many", marks=pytest.mark.slow)]


CHANGES = {"integers": lambda _, problem: problem, "units": problems.in_units}


@pytest.mark.parametrize("count", MANY)
@pytest.mark.parametrize("change", CHANGES.values(), ids=list(CHANGES))
def test_cases_of_small_integers_are_those_of_the_kernel(build, change, count):
    assert differences_from_kernel(build, 8, count, change) == (0, 0)


@pytest.mark.parametrize("count", MANY)
def test_cases_of_nearly_singular_problems_are_those_of_the_kernel(build, count):
    """Whether forces are open is a question of a tolerance there."""
    different, border = differences_from_kernel(build, 9, count, problems.nearly)
    assert different <= count / 50 and border <= count / 50


@pytest.mark.parametrize("slip", [0, -1])
def test_forces_that_are_rounding_are_no_solution_in_c(build, slip):
    problem = problems.Problem([[4, -2], [-2, 1]], [-1, -1], [2 * (1 - 4e-15)], [[slip]], [False])
    given = case_in_c(build("rod")[1], 0, problem)
    assert given is ContactCase.INCONSISTENT and problems.case_of(problem.answers()) == given
