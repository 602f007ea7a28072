"""The jump at finite stiffness: against compliant runs, its limit, and a contact with a dashpot."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from derivations.generated import corrected_jump as forms
from painleve_sym.at.jump import evaluate_jump
from painleve_sym.automata.compliant import CompliantContact
from painleve_sym.codegen import named_mechanisms
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError
from painleve_sym.laws.catalogue import law
from painleve_sym.mechanics import general_contact
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.finite_stiffness import CorrectedJumpRule, evaluate_corrected_jump
from painleve_sym.motion.frozen_impact import FrozenEnd, FrozenImpactSolver
from painleve_sym.motion.simulator import Simulator
from tests.support.paper_law import paper_law

TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
SIN, COS = math.sin(1.0), math.cos(1.0)
CONTACT = {"W_nn": 1 + 3 * COS**2, "W_nt": -3 * SIN * COS, "W_tt": 1 + 3 * SIN**2}
CONTACT |= {"b_n": SIN - 9.8, "b_t": COS, "mu": 1.4}
A = CONTACT["W_nn"] + 1.4 * CONTACT["W_nt"]
A_STICK = CONTACT["W_nn"] - CONTACT["W_nt"] ** 2 / CONTACT["W_tt"]
C = CONTACT["W_nt"] + 1.4 * CONTACT["W_tt"]


@pytest.fixture(scope="module")
def rod():
    return model("rod")


@pytest.fixture(scope="module")
def rule(rod):
    return CorrectedJumpRule(rod, paper_law(reload="virgin"))


@pytest.fixture(scope="module")
def simulator(rod):
    return Simulator(rod, paper_law(reload="virgin"))


def values(rule, **changes):
    declared = (*rule.mechanism.system.parameters, *rule.law.parameters)
    return {p.name: p.default for p in declared} | changes


def test_rebound_of_table_3_is_the_softened_one(rule):
    stiff = values(rule, E=20.9e14)
    frozen = rule(TABLE_3, stiff).velocity
    carried = rule(TABLE_3, stiff, configuration="carried").velocity
    # 0.0656115 and 1.6029856: compliant runs computed outside the project.
    assert frozen["y_A_dot"] == pytest.approx(0.0656115, rel=1e-3)
    assert carried["y_A_dot"] == pytest.approx(0.0656115, rel=1e-4)
    assert carried["theta_dot"] == pytest.approx(1.6029856, rel=2e-5)


def test_limit_is_the_classical_rule_and_the_leading_correction_its_approach(rod, rule):
    K = np.logspace(20, 32, 4)
    E = K / evaluate_corrected_jump(rod, rule.law, TABLE_3, parameters={"E": 1.0}).stiffness
    jump = rule(TABLE_3, values(rule, E=E)).impacts.head["normal_velocity"]
    classical = evaluate_jump(rod, "energetic", TABLE_3).velocity["y_A_dot"]
    numbers = {"A": A, "A_stick": A_STICK, "B": CONTACT["b_n"], "C": C, "b_t": CONTACT["b_t"]}
    leading = np.array([forms.dv_n_3(**numbers, K=k, n=1.764, e_energetic=0.75) for k in K])
    left = (jump - classical) / leading - 1
    assert np.all(np.diff(np.abs(jump - classical)) < 0)
    # The error falls like K^(−(n−1)/(2n(n+1))), 0.72 over four decades.
    orders = np.diff(np.log(np.abs(left))) / np.diff(np.log(K))
    assert orders[-1] == pytest.approx(-0.764 / (2 * 1.764 * 2.764), rel=0.1)


def test_separation_velocity_needs_neither_time_nor_largest_compression(rule):
    jump = rule(TABLE_3, values(rule, E=20.9e12))
    v_1, delta_1 = (
        -jump.impacts.phase["compression_rate"][0],
        jump.impacts.phase["compression"][0],
    )
    B_STICK = CONTACT["b_n"] - CONTACT["W_nt"] * CONTACT["b_t"] / CONTACT["W_tt"]
    ends = {"v_n_1": float(v_1), "delta_1": float(delta_1), "e_energetic": 0.75}
    formula = forms.v_n_3(A=A, A_stick=A_STICK, B=CONTACT["b_n"], B_stick=B_STICK, **ends)
    # Reverse slip at the very end takes about 1e-6 of it.
    assert jump.impacts.head["normal_velocity"] == pytest.approx(formula, rel=1e-5)
    t_1 = float(jump.impacts.phase["duration"][0])
    stop = forms.v_n_1(A=A, B=CONTACT["b_n"], C=C, b_t=CONTACT["b_t"], v_t=-1.0, t_1=t_1)
    assert v_1 == pytest.approx(stop, rel=1e-12)


def test_surface_energy_is_that_of_the_softened_run(rod, rule, simulator):
    state = {**TABLE_3, "theta_dot": 5.0}
    run = simulator.run(
        state, t_end=0.1, parameters={"E": 20.9e16}, until="separation", initial_force=500.0
    )
    jump = evaluate_corrected_jump(
        rod,
        rule.law,
        state,
        parameters={"E": 20.9e16},
        initial_force=500.0,
        configuration="carried",
    )
    assert jump.end is FrozenEnd.SEPARATION
    classical = evaluate_jump(rod, "energetic", state).velocity["y_A_dot"]
    error = abs(jump.velocity["y_A_dot"] - run.final["y_A_dot"])
    # Next to the saddle F = −B/A the drift of the configuration counts more: 0.6 % here.
    assert error < 0.1 * abs(classical - run.final["y_A_dot"])
    lifts = evaluate_corrected_jump(
        rod, rule.law, state, parameters={"E": 20.9e16}, initial_force=300.0
    )
    assert [p.name for p in lifts.phases] == ["slip restitution"]


@pytest.mark.parametrize(
    ("name", "state", "changes"),
    [
        ("rod", {**TABLE_3, "y_A_dot": -0.05}, {}),
        ("rod", {"theta": 0.6, "theta_dot": -1.0, "x_A_dot": 1.0, "y_A_dot": -0.3}, {"mu": 0.4}),
        ("rod", {"theta": 1.2, "x_A_dot": -0.05, "y_A_dot": -0.5}, {"mu": 0.3}),
    ],
)
def test_oblique_impacts_are_those_of_softened_runs(simulator, rule, name, state, changes):
    run = simulator.run(state, t_end=0.1, parameters={"E": 20.9e14, **changes}, until="separation")
    given = values(rule, E=20.9e14, **changes)
    frozen, carried = (rule(state, given, configuration=c).velocity for c in ("frozen", "carried"))
    for velocity in ("x_A_dot", "y_A_dot", "theta_dot"):
        off = [abs(r[velocity] - run.final[velocity]) for r in (frozen, carried)]
        assert off[0] < 2e-3
        assert off[1] < 5e-5


@pytest.mark.slow
def test_another_mechanism_is_corrected_too():
    mechanism = model("pr-robot")
    state = dict(mechanism.start)
    contact_law = paper_law(reload="virgin")
    rule = CorrectedJumpRule(mechanism, contact_law)
    given = values(rule, E=20.9e14)
    run = Simulator(mechanism, contact_law).run(
        state, t_end=0.1, parameters={"E": 20.9e14}, until="separation"
    )
    classical = evaluate_jump(mechanism, "energetic", state)
    carried = rule(state, given, configuration="carried")
    for v in classical.velocity:
        error = abs(classical.velocity[v] - run.final[v])
        assert abs(float(carried.velocity[v]) - run.final[v]) < 0.1 * error + 1e-9


def test_second_time_a_jump_is_evaluated_without_derivation(monkeypatch):
    def solved():
        state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
        jump = evaluate_corrected_jump("rod", law("hertz"), state, configuration="carried")
        return dict(jump.velocity)

    def refuse(*_):
        raise AssertionError("this should have come from the cache")

    first = solved()
    monkeypatch.setattr(Mechanism, "coefficients", property(refuse))
    monkeypatch.setattr(CompliantContact, "automaton", property(refuse))
    monkeypatch.setattr(general_contact, "general_contact", refuse)
    named_mechanisms._named.cache_clear()
    assert solved() == first
    named_mechanisms._named.cache_clear()


def test_arrays_of_states_are_evaluated_at_once(rule):
    theta = np.linspace(0.95, 1.05, 7)
    jump = rule({**TABLE_3, "theta": theta}, values(rule, E=20.9e14), configuration="carried")
    one = rule(
        {**TABLE_3, "theta": float(theta[2])}, values(rule, E=20.9e14), configuration="carried"
    )
    assert jump.velocity["theta_dot"].shape == (7,)
    assert jump.velocity["theta_dot"][2] == one.velocity["theta_dot"]


@pytest.fixture(scope="module")
def damped():
    return FrozenImpactSolver(law("linear"))


def test_elastic_limit_is_that_of_hogan_and_kristiansen(damped):
    w_1 = abs(A / C)
    impact = damped(CONTACT, {"slip_velocity": -1.0}, {"k": [1e12, 1e16, 1e20]})
    left = impact.head["normal_velocity"] / (w_1 * math.sqrt(1 + A_STICK / -A)) - 1
    # The blow-up time of a linear contact is log K/√K: three digits per four decades.
    assert np.all(left > 0)
    assert left[2] < 1e-5
    assert np.all(left[1:] < 0.03 * left[:-1])


def test_strong_damping_leaves_the_rebound_of_hogan_and_kristiansen(damped):
    k, damping = 1e20, np.array([30.0, 100.0, 300.0])
    impact = damped(CONTACT, {"slip_velocity": -1.0}, {"k": k, "c": damping * math.sqrt(k)})
    assert impact.ends == [FrozenEnd.SEPARATION] * 3
    rebound = (1 / -A + 1 / A_STICK) * abs(A / C) / damping**2
    left = np.abs(impact.head["normal_velocity"] / rebound - 1)
    # The next term of the expansion is log(damping)/damping².
    assert left[2] < 1e-3
    assert left[0] > 5 * left[1] > 25 * left[2]


@pytest.mark.parametrize("c", [0.0, 1e4, 1e6])
def test_separating_surface_separates(damped, c):
    up, k, F = {**CONTACT, "b_n": 11.2368}, 1e12, 200.0
    stable = forms.lambda_stable(A=A, K=k, c=c)
    rate = forms.delta_dot_s(A=A, K=k, delta_0=F / k, B_up=up["b_n"], lambda_stable=stable)
    start = {"slip_velocity": -1.0, "compression": F / k}
    start["compression_rate"] = rate * np.array([0.999, 1.001])
    slip = damped(up, start, {"k": k, "c": c}).phase["slip"]
    assert np.all(slip[0][~np.isnan(slip[0])] == -1)
    assert np.any(slip[1] == 0)


@pytest.mark.parametrize("c", [1e4, 1e6, 1e7])
def test_linear_dashpot_agrees_with_the_matrix_exponential(damped, c):
    """Each phase from the end of the one before: (δ, δ̇, ∫F dt) by SciPy's exponential."""
    k = 1e12
    impact = damped(CONTACT, {"slip_velocity": -1.0, "compression_rate": 0.1}, {"k": k, "c": c})
    assert impact.ends == [FrozenEnd.SEPARATION]
    y, v_t = np.array([0.0, 0.1, 0.0, 1.0]), -1.0
    for i in range(int(impact.head["phases"])):
        phase = {name: float(values[i]) for name, values in impact.phase.items()}
        W_nt, W_tt = CONTACT["W_nt"], CONTACT["W_tt"]
        slip = phase["slip"]
        ratio, offset = -1.4 * slip, 0.0
        if slip == 0:
            ratio, offset = -W_nt / W_tt, -CONTACT["b_t"] / W_tt
        a, b = CONTACT["W_nn"] + ratio * W_nt, CONTACT["b_n"] + offset * W_nt
        matrix = np.zeros((4, 4))
        matrix[0, 1], matrix[1], matrix[2] = 1.0, [-a * k, -a * c, 0, -b], [k, c, 0, 0]
        t = phase["duration"]
        y = expm(matrix * t) @ [*y[:2], 0.0, 1.0]
        if slip:
            v_t += (W_nt + ratio * W_tt) * y[2] + CONTACT["b_t"] * t
        assert phase["compression"] == pytest.approx(y[0], rel=1e-9, abs=1e-16)
        assert phase["compression_rate"] == pytest.approx(y[1], rel=1e-9, abs=1e-11)
        assert phase["normal_impulse"] == pytest.approx(y[2], rel=1e-9, abs=1e-12)
        assert phase["slip_velocity"] == pytest.approx(v_t, abs=1e-10)
    assert k * y[0] + c * y[1] == pytest.approx(0.0, abs=1e-9 * (k * 1e-6))


def test_dashpots_lower_the_rebound(rod):
    def rebound(c):
        jump = evaluate_corrected_jump(
            rod,
            law("hunt-crossley"),
            TABLE_3,
            parameters={"E": 20.9e14, "c": c},
            configuration="carried",
        )
        return jump.velocity["y_A_dot"]

    assert rebound(2.0) < rebound(1.0) < rebound(0.0)


@pytest.mark.slow
def test_hunt_crossley_agrees_with_the_softened_run(rod):
    parameters = {"E": 20.9e15, "c": 1.0}
    run = Simulator(rod, law("hunt-crossley")).run(
        TABLE_3, t_end=0.1, parameters=parameters, until="separation"
    )
    jump = evaluate_corrected_jump(rod, law("hunt-crossley"), TABLE_3, parameters=parameters)
    # The rest is the drift of the configuration.
    assert jump.velocity["y_A_dot"] == pytest.approx(run.final["y_A_dot"], rel=2e-3)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"configuration": "moved"}, "need one of frozen, carried"),
        ({"initial_force": -1.0}, "initial force: got -1.0"),
        ({"parameters": {"E": -1.0}}, "parameter E"),
        ({"parameters": {"e": 0.5}}, "unknown parameter 'e'"),
    ],
)
def test_bad_input_is_named(rod, rule, options, text):
    parameters = options.pop("parameters", None)
    with pytest.raises(InputError, match=text):
        evaluate_corrected_jump(rod, rule.law, TABLE_3, parameters=parameters, **options)
