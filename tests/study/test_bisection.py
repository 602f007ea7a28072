"""The sliding solution and the critical initial force, against SciPy, quadrature and limits."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from painleve_sym.automata.compliant import CompliantContact
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.laws.catalogue import law
from painleve_sym.laws.saddle import LawSaddle
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.critical.bisection import (
    Border,
    CriticalForceFinder,
    Outcome,
    critical_force,
)
from painleve_sym.study.critical.sliding_solution import SlidingAnalysis, SlidingSolution, _energy
from tests.oracles import rod_scipy
from tests.support.paper_law import paper_law

STIFF = 20.9e14
TABLE_4 = {"x_A_dot": -1.0, "theta": 1.0, "theta_dot": 5.0}
BOTH = pytest.mark.parametrize("border", Border)
# Indeterminate states: F_n* rises in some and falls in others; one gap is not a coordinate.
CASES = {
    "rod": ({"x_A_dot": -1.0, "theta": 1.05, "theta_dot": -4.0}, {}),
    "rod-inertia": ({"x_A_dot": -1.0, "theta": 1.1, "theta_dot": 5.0}, {"alpha": 3.5}),
    "cart-pendulum": ({"x_dot": -1.0, "phi": 2.7, "phi_dot": 5.0}, {}),
    "eccentric-disc": ({"x_dot": -3.0, "phi": 1.0, "phi_dot": -8.0}, {"mu": 1.2}),
    "pr-robot": ({"x_dot": -1.0, "theta": math.asin(0.8)}, {"tau": -20.0}),
}


@pytest.fixture(scope="module")
def finder():
    return CriticalForceFinder(Simulator(model("rod"), paper_law(reload="virgin")))


def test_second_time_a_sliding_solution_is_found_without_derivation(monkeypatch):
    def solved():
        analysis = SlidingAnalysis(Simulator(model("rod"), law("linear")))
        return analysis.at(TABLE_4, {"k": 1e9, "c": 5.0})

    def refuse(*_):
        raise AssertionError("this should have come from the cache")

    first = solved()
    monkeypatch.setattr(Mechanism, "coefficients", property(refuse))
    monkeypatch.setattr(CompliantContact, "automaton", property(refuse))
    monkeypatch.setattr(LawSaddle, "slope", property(refuse))
    assert solved() == first
    assert not first.conservative


# ---- the numbers of the paper's Table 4 ----


def test_both_critical_forces_of_table_4(finder):
    forces = {b: finder.find(TABLE_4, {"E": STIFF}, border=b) for b in Border}
    assert forces[Border.SLIP_STOP].value == pytest.approx(346.8785, abs=5e-5)
    assert forces[Border.COMPRESSION].value == pytest.approx(346.9994, abs=5e-5)
    for one in forces.values():
        low, high = one.bracket
        assert high == np.nextafter(low, np.inf) == one.value
        assert one.tolerance_effect < 1e-9
        assert one.sliding.force == pytest.approx(332.992, abs=5e-4)
    outcomes = [(f.outcome_below, f.outcome_above) for f in forces.values()]
    assert outcomes == [
        (Outcome.LIFTS_OFF, Outcome.STOPS_IN_RESTITUTION),
        (Outcome.STOPS_IN_RESTITUTION, Outcome.STOPS_IN_COMPRESSION),
    ]


@pytest.mark.parametrize(
    ("border", "first"), [(Border.SLIP_STOP, False), (Border.COMPRESSION, True)]
)
def test_scipy_sees_the_border_where_the_compiled_runs_do(finder, border, first):
    critical = finder.find(TABLE_4, {"E": STIFF}, border=border).value
    K = finder.simulator.constants(finder.simulator.parameters({"E": STIFF}))
    stiffness = K["K_e"]

    def impacts(force):
        depth = (force / stiffness) ** (1 / 1.764)
        run = rod_scipy.simulate(
            1.0, 5.0, -1.0, -depth, E=STIFF, t_end=0.01, until="separation", rtol=1e-12
        )
        kinds = [e.kind for e in run.events]
        return kinds[0] == "slip_stop" if first else "slip_stop" in kinds

    # Two integrators with an own error of 1e-12 each, enlarged by the saddle.
    assert not impacts(critical * (1 - 1e-9))
    assert impacts(critical * (1 + 1e-9))


@pytest.mark.slow
def test_the_other_engine_finds_the_same_force(finder):
    other = Simulator(model("rod"), paper_law(reload="virgin"), "erk")
    critical = CriticalForceFinder(other, rtol=1e-10).find(
        TABLE_4, {"E": STIFF}, check_tolerance=False
    )
    assert critical.value == pytest.approx(finder.find(TABLE_4, {"E": STIFF}).value, rel=1e-10)


@pytest.mark.parametrize("spin", [5.0, -5.0])
def test_a_plastic_contact_has_a_critical_force_too(finder, spin):
    # e = 0 opens at once where it does not close: a falling F_n* is met at F_n* itself.
    state = {**TABLE_4, "theta_dot": spin}
    critical = finder.find(state, {"E": 20.9e18, "e_energetic": 0.0})
    assert critical.outcome_below is Outcome.LIFTS_OFF
    assert critical.value == pytest.approx(critical.sliding.predicted_force, rel=2e-5)


def test_the_borders_draw_together_as_the_sliding_solution_lasts_longer(finder):
    gaps = []
    for E in (20.9e13, 20.9e14, 20.9e15):
        one, two = (finder.find(TABLE_4, {"E": E}, border=b).value for b in Border)
        gaps.append((two - one) / one)
    # λ grows 1.92-fold per decade and the gap is exp(−λ T): its logarithm does too, roughly.
    logs = np.log(gaps)
    assert np.all(np.diff(logs) < -3)
    assert logs[2] / logs[1] == pytest.approx(10 ** (1 / (2 * 1.764)), rel=0.25)


# ---- other mechanisms and laws ----


@pytest.mark.parametrize(
    ("name", "law_name"),
    [
        ("rod", "bilinear-hertz"),
        pytest.param("rod-inertia", "bilinear-hertz", marks=pytest.mark.slow),
        ("rod-inertia", "hertz"),
        pytest.param("cart-pendulum", "bilinear-hertz", marks=pytest.mark.slow),
        pytest.param("cart-pendulum", "hertz", marks=pytest.mark.slow),
        pytest.param("eccentric-disc", "bilinear-hertz", marks=pytest.mark.slow),
        pytest.param("pr-robot", "bilinear-hertz", marks=pytest.mark.slow),
    ],
)
def test_expansion_holds_for_any_mechanism(name, law_name):
    state, parameters = CASES[name]
    finder = CriticalForceFinder(Simulator(model(name), law(law_name)))
    left = []
    for E in (20.9e14, 20.9e18):
        critical = finder.find(state, {**parameters, "E": E}, check_tolerance=False)
        left.append(abs(critical.value - sum(critical.sliding.expansion)))
    n = critical.sliding.exponent
    if critical.sliding.force_rate == 0:  # a true equilibrium: F_n* itself, to round-off
        assert max(left) < 1e-12 * critical.value
    else:
        # The first term left out, 1/λ³, falls like E^(−3/(2n)); the next one disturbs by 1/λ.
        order = math.log(left[1] / left[0]) / math.log(1e4)
        assert order == pytest.approx(-3 / (2 * n), abs=0.06)


@pytest.mark.parametrize("name", ["linear", "hunt-crossley"])
def test_first_term_holds_for_laws_with_damping(name):
    finder = CriticalForceFinder(Simulator(model("rod"), law(name)))
    left = []
    for scale in (1.0, 1e4):
        hard = {"k": 1e12 * scale, "c": 3e4 * scale**0.5}
        soft = {"E": 20.9e16 * scale, "c": 0.1 * scale**0.5}
        critical = finder.find(TABLE_4, hard if name == "linear" else soft, check_tolerance=False)
        terms = critical.sliding.expansion
        assert math.isnan(terms[2])
        left.append(abs(critical.value - terms[0] - terms[1]))
        rates = critical.sliding.growth_rate
    # 1/λ² is left: λ grows like the root of k, or like E^(1/(2n)).
    n = critical.sliding.exponent
    assert rates > 0
    assert math.log(left[1] / left[0]) / math.log(1e4) == pytest.approx(-1 / n, abs=0.02)


@settings(max_examples=12)
@given(
    theta=st.floats(1.0, 1.18),
    spin=st.floats(4.0, 6.0),
    E=st.sampled_from([20.9e16, 20.9e18, 20.9e20]),
)
def test_outcome_changes_exactly_at_the_critical_force(finder, theta, spin, E):
    state = {"theta": theta, "theta_dot": spin, "x_A_dot": -1.0}
    critical = finder.find(state, {"E": E}, check_tolerance=False)
    factors = np.array([0.5, 0.9, 1 - 1e-6, 1 + 1e-6, 1.1, 2.0])
    below = finder.outcomes(state, critical.value * factors, {"E": E})
    assert below[:3] == [Outcome.LIFTS_OFF] * 3
    assert Outcome.LIFTS_OFF not in below[3:] and Outcome.UNDECIDED not in below[3:]
    terms = critical.sliding.expansion
    assert abs(critical.value - terms[0]) < 3 * abs(terms[1])


# ---- the separatrix of constant A and B ----


@settings(max_examples=50)
@given(x=st.floats(0, 5), n=st.floats(1, 3))
def test_energy_is_never_negative_and_its_series_meets_the_formula(x, n):
    direct = n - (n + 1) * x + x ** (n + 1)
    assert _energy(x, n) >= 0
    assert _energy(x, n) == pytest.approx(direct, abs=1e-13 * (1 + n) * (1 + x ** (n + 1)))


@settings(max_examples=30)
@given(approach=st.floats(-3e-3, 1.8e-3))
def test_closed_form_is_the_level_of_the_saddle(approach):
    # A frozen contact: nothing drifts, and e = 1 unloads along the loading curve.
    A, B, n, K = -0.0337, 11.2, 1.764, 1.23e14
    depth = (-B / (A * K)) ** (1 / n)
    rate = math.sqrt(n * B / depth)
    solution = SlidingSolution(
        slip=-1, A=A, B=B, force=-B / A, force_rate=0.0, force_second_rate=0.0, A_rate=0.0,
        rate_per_force=0.0, compression=depth, compression_rate=0.0, approach=approach,
        exponent=n, growth_rate=rate, decay_rate=-rate, unloading_growth_rate=rate,
        unloading_decay_rate=-rate, conservative=True,
    )  # fmt: skip

    def level(d):
        return B * d + A * K * d ** (n + 1) / (n + 1)

    def miss(d):
        return approach**2 / 2 + level(d) - level(depth)

    ends = (0.0, depth) if approach > 0 else (depth, 50 * depth)
    if abs(approach) < 1e-6:
        return
    expected = K * brentq(miss, *ends, xtol=1e-22, rtol=1e-14) ** n
    assert solution.predicted_force == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_an_approach_above_the_barrier_speed_always_impacts(finder):
    sliding = finder.analysis.at(TABLE_4, {"E": 20.9e20})
    fast = {**TABLE_4, "y_A_dot": -1.001 * sliding.barrier_speed}
    slow = {**TABLE_4, "y_A_dot": -0.995 * sliding.barrier_speed}
    none = np.array([0.0])
    assert finder.outcomes(slow, none, {"E": 20.9e20}) == [Outcome.LIFTS_OFF]
    assert finder.outcomes(fast, none, {"E": 20.9e20}) == [Outcome.STOPS_IN_COMPRESSION]
    with pytest.raises(InputError, match=r"approaches too fast.*slower approach"):
        finder.find(fast, {"E": 20.9e20})


@pytest.mark.parametrize("share", [-0.5, 0.5])
def test_closed_form_with_an_approach_holds_to_first_order(finder, share):
    errors = []
    for E in (20.9e16, 20.9e20):
        speed = -share * finder.analysis.at(TABLE_4, {"E": E}).barrier_speed
        critical = finder.find({**TABLE_4, "y_A_dot": speed}, {"E": E}, check_tolerance=False)
        errors.append(abs(critical.sliding.predicted_force / critical.value - 1))
    # Speed and barrier shrink together, so 1/λ is left: E^(−1/(2n)).
    order = math.log(errors[1] / errors[0]) / math.log(1e4)
    assert order == pytest.approx(-1 / (2 * 1.764), abs=0.03)


# ---- rejected input ----


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ({**TABLE_4, "theta_dot": 1.0}, r"got A = -0.03\d+ 1/kg and B = -8.\d+ .*A < 0 and B > 0"),
        ({**TABLE_4, "theta": 0.5}, r"got A = 1.54.*indeterminate"),
        ({"theta": 1.0, "theta_dot": 5.0}, "slip velocity 0, need slip"),
        ({**TABLE_4, "y_A": 1e-3}, "got gap = 0.001 m, need 0"),
    ],
)
def test_states_that_are_not_indeterminate_are_refused(finder, state, message):
    with pytest.raises(InputError, match=message):
        critical_force(finder.simulator.mechanism, finder.simulator.contact_law, state)


def test_forces_must_be_numbers(finder):
    with pytest.raises(InputError, match="initial force: got"):
        finder.outcomes(TABLE_4, np.array([1.0, math.nan]))


def test_a_run_that_is_not_decided_says_why(finder):
    hasty = CriticalForceFinder(finder.simulator, t_end=1e-7)
    with pytest.raises(InputError, match=r"neither opens nor stops.*t = 1e-07 s.*later t_end"):
        hasty.find(TABLE_4, {"E": STIFF})


def test_initial_force_of_a_gap_that_is_no_coordinate():
    state, parameters = {"theta": math.asin(0.8)}, {"mu": 1.5, "k_s": 40.0, "theta_0": 0.5}
    simulator = Simulator(model("strut"), paper_law())
    run = simulator.run(state, parameters=parameters, t_end=1e-8, initial_force=100.0)
    assert run.values("normal_force", np.array([0.0]))[0] == pytest.approx(100.0, rel=1e-12)
