"""Frozen impacts: against mpmath, against SciPy, and against what must hold."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from painleve_sym.errors import InputError
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.frozen_impact import (
    COEFFICIENTS,
    FrozenEnd,
    FrozenImpactSolver,
)
from tests.oracles.frozen_scipy import frozen_impact as integrated
from tests.support.frozen_impacts import LOADED, OBLIQUE, ROD, inputs
from tests.support.paper_law import paper_law

CENTRAL = {**ROD, "mu": 0.3, "compression_rate": 0.2, "slip_velocity": 0.1}
SLIDING = {**ROD, "W_nt": 0.4, "mu": 0.2, "compression_rate": 0.5, "slip_velocity": 2.0}
REVERSED = {**ROD, "W_nt": 1.5, "mu": 0.2, "compression_rate": 0.5, "slip_velocity": -0.05}
AT_REST = {**ROD, "slip_velocity": 0.0, "compression_rate": 0.3}
CASES = (ROD, OBLIQUE, LOADED, CENTRAL, SLIDING, REVERSED, AT_REST)


@pytest.fixture(scope="module")
def solver():
    return FrozenImpactSolver(paper_law())


def slip_forms(case, delta):
    """Return time and impulse of slip from rest by mpmath's hypergeometric function."""
    n, K, B = mp.mpf(case["n"]), mp.mpf(case["K"]), mp.mpf(case["b_n"])
    A = mp.mpf(case["W_nn"]) + mp.mpf(case["mu"]) * mp.mpf(case["W_nt"])
    x, b = mp.mpf(float(delta)), 1 / (2 * n)
    z = A * K * x**n / ((n + 1) * B)
    t = mp.sqrt(2 * x / -B) * mp.hyp2f1(mp.mpf(1) / 2, b, 1 + b, -z)
    P = K * x**n * mp.sqrt(2 * x / -B) / (2 * n + 1)
    return t, P * mp.hyp2f1(mp.mpf(1) / 2, 1 + b, 2 + b, -z)


@pytest.mark.parametrize("n", [0.7, 1.0, 1.2, 1.5, 1.764, 2.5, 4.0])
@pytest.mark.parametrize("speed", [1.0, 1e-3, 1e-6])
def test_slip_from_rest_is_the_hypergeometric_function(solver, n, speed):
    case = {**ROD, "n": n, "slip_velocity": -speed}
    impacts = solver(*inputs(case))
    t, P = impacts.phase["duration"][0], impacts.phase["normal_impulse"][0]
    with mp.workdps(40):
        exact_t, exact_P = slip_forms(case, impacts.phase["compression"][0])
        C = mp.mpf(case["W_nt"]) + mp.mpf(case["mu"]) * mp.mpf(case["W_tt"])
        left = -mp.mpf(speed) + C * exact_P + mp.mpf(case["b_t"]) * exact_t
        momentum = speed + abs(case["b_n"]) * t
        assert abs(t / exact_t - 1) < 1e-12
        # From the momentum balance: to round-off of the momentum, however small the force is.
        assert abs(P - exact_P) < 1e-12 * exact_P + 1e-13 * momentum
        assert abs(left) < 1e-12 * momentum


@pytest.mark.parametrize("n", [1.5, 1.764, 4.0])
def test_restitution_time_and_impulse_are_those_of_mpmath(solver, n):
    impacts = solver(*inputs({**ROD, "n": n}))
    with mp.workdps(30):
        W_nn, W_nt, W_tt = (mp.mpf(ROD[k]) for k in ("W_nn", "W_nt", "W_tt"))
        a, b = W_nn - W_nt**2 / W_tt, mp.mpf(ROD["b_n"]) - W_nt * mp.mpf(ROD["b_t"]) / W_tt
        e, largest = mp.mpf("0.75"), mp.mpf(float(impacts.head["largest_compression"]))
        kappa, top = mp.mpf(ROD["K"]) / e ** (2 * n), e**2 * largest
        low = mp.mpf(float(impacts.phase["compression"][2])) - (largest - top)
        p = mp.mpf(n) + 1

        def per_q(q):
            y = (top - low) * q * q
            x = top - y
            g = a * kappa / p * (top**p - x**p) + b * y
            return 2 * q * (top - low) / mp.sqrt(2 * g), x

        ends = [0, 0.5, 0.9, 0.99, 0.999, 1]
        t = mp.quad(lambda q: per_q(q)[0], ends, method="gauss-legendre")
        P = mp.quad(lambda q: per_q(q)[0] * kappa * per_q(q)[1] ** n, ends, method="gauss-legendre")
        assert abs(impacts.phase["duration"][2] / t - 1) < 1e-13
        assert abs(impacts.phase["normal_impulse"][2] / P - 1) < 1e-13


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("e", [1.0, 0.75, 0.2])
def test_impacts_agree_with_integration_by_scipy(solver, case, e):
    case = {"compression": 0.0, "compression_rate": 0.0, **case, "e": e}
    impacts = solver(*inputs(case))
    end, (v_t, v_n, P, P_t, time, modes) = integrated(case)
    assert impacts.ends[0].name.lower() == end
    slip, loading = impacts.phase["slip"], impacts.phase["loading"] == 1
    assert list(zip(slip, loading, strict=True)) == modes
    # SciPy's own error over thousands of steps.
    assert impacts.head["normal_velocity"] == pytest.approx(v_n, rel=1e-8)
    assert impacts.head["normal_impulse"] == pytest.approx(P, rel=1e-8)
    assert impacts.head["tangential_impulse"] == pytest.approx(P_t, rel=1e-8, abs=1e-8 * P)
    assert impacts.head["duration"] == pytest.approx(time, rel=1e-8)
    assert impacts.head["slip_velocity"] == pytest.approx(v_t, rel=1e-6, abs=1e-10)


@st.composite
def cases(draw):
    """Return any impact: a positive definite W, any friction, stiffness, exponent and start."""
    rows = [draw(st.integers(-150, 150)) / 100 for _ in range(3)]
    W_nn, W_nt, W_tt = rows[0] ** 2 + 0.1, rows[0] * rows[1], rows[1] ** 2 + rows[2] ** 2 + 0.1
    K = 10.0 ** draw(st.floats(6, 14))
    n = draw(st.sampled_from([0.8, 1.0, 1.02, 1.5, 1.764, 2.3]))
    depth = draw(st.sampled_from([0.0, 1.0])) * 10.0 ** draw(st.floats(-1, 1.5))
    speed = draw(st.sampled_from([0.0, 1.0])) * 10.0 ** draw(st.floats(-3, 0))
    return {
        "W_nn": W_nn,
        "W_nt": W_nt,
        "W_tt": W_tt,
        "b_n": draw(st.integers(-2000, 2000)) / 100,
        "b_t": draw(st.integers(-1000, 1000)) / 100,
        "mu": draw(st.integers(0, 200)) / 100,
        "K": K,
        "n": n,
        "e": draw(st.sampled_from([1.0, 0.75, 0.3])),
        "slip_velocity": draw(st.sampled_from([-1.0, 0.0, 1.0])) * 10.0 ** draw(st.floats(-4, 0.3)),
        "compression": depth * (10 / K) ** (1 / n),
        "compression_rate": speed,
    }


@settings(max_examples=80)
@given(case=cases())
def test_momentum_balance(solver, case):
    impacts = solver(*inputs(case))
    assume(impacts.ends[0] is FrozenEnd.SEPARATION)
    h = {name: float(value) for name, value in impacts.head.items()}
    P, P_t, t = h["normal_impulse"], h["tangential_impulse"], h["duration"]
    terms = (case["W_nn"] * P, case["W_nt"] * P_t, case["b_n"] * t, -case["compression_rate"])
    # Quadrature is right to round-off of the whole impact, not of every phase.
    size = sum(map(abs, terms)) + abs(h["normal_velocity"])
    assert h["normal_velocity"] == pytest.approx(math.fsum(terms), abs=1e-9 * size)
    terms = (case["W_nt"] * P, case["W_tt"] * P_t, case["b_t"] * t, case["slip_velocity"])
    size = sum(map(abs, terms))
    # A stop next to the largest compression is known to √ε: there δ hardly changes.
    assert h["slip_velocity"] == pytest.approx(math.fsum(terms), abs=1e-7 * size)
    assert abs(P_t) <= case["mu"] * P * (1 + 1e-12)
    assert h["normal_velocity"] >= 0


def in_other_units(case, length, time, mass):
    """Return the case with numbers in units of `length` m, `time` s and `mass` kg."""
    speed, force = length / time, mass * length / time**2
    units = dict.fromkeys(("W_nn", "W_nt", "W_tt"), 1 / mass)
    units |= dict.fromkeys(("b_n", "b_t"), speed / time)
    units |= dict.fromkeys(("slip_velocity", "compression_rate"), speed)
    units |= {"compression": length, "K": force / length ** case["n"]}
    return {name: value / units.get(name, 1.0) for name, value in case.items()}


@settings(max_examples=40)
@given(
    case=st.sampled_from(CASES),
    units=st.tuples(*[st.integers(-6, 6).map(lambda p: 10.0**p)] * 3),
)
def test_units_do_not_matter(solver, case, units):
    length, time, mass = units
    impacts = solver(*inputs(case))
    other = solver(*inputs(in_other_units(case, *units)))
    assert other.ends == impacts.ends
    assert np.array_equal(other.phase["slip"], impacts.phase["slip"])
    for name, unit in (
        ("normal_velocity", length / time),
        ("normal_impulse", mass * length / time),
        ("duration", time),
        ("largest_compression", length),
    ):
        assert other.head[name] * unit == pytest.approx(float(impacts.head[name]), rel=1e-11)


@settings(max_examples=40)
@given(case=cases())
def test_mirrored_impacts_have_mirrored_ends(solver, case):
    turned = {**case, **{name: -case[name] for name in ("W_nt", "b_t", "slip_velocity")}}
    one, other = solver(*inputs(case)), solver(*inputs(turned))
    assert one.ends == other.ends
    # Slips to either side are compiled apart: the last digit may differ.
    for name, sign in (("normal_velocity", 1), ("slip_velocity", -1)):
        assert sign * other.head[name] == pytest.approx(float(one.head[name]), rel=1e-13)


@settings(max_examples=40)
@given(case=cases())
def test_after_the_slip_the_same_coefficients_change_nothing(solver, case):
    one = solver(*inputs(case))
    other = solver(*inputs(case), after={name: case[name] for name in COEFFICIENTS})
    assert one.ends == other.ends
    assume(one.ends[0] is FrozenEnd.SEPARATION)
    speed = max(np.nanmax(np.abs(one.phase[n])) for n in ("compression_rate", "slip_velocity"))
    for name in ("normal_velocity", "slip_velocity"):
        assert other.head[name] == pytest.approx(float(one.head[name]), abs=1e-7 * speed)


def test_a_touching_contact_at_rest_slips_where_friction_cannot_hold_it(solver):
    """Without friction, and without a tangential acceleration of its own."""
    case = {**ROD, "W_nn": 1.0, "W_nt": 0.3, "W_tt": 1.0, "b_n": -1.0, "b_t": 0.0, "mu": 0.0}
    impacts = solver(*inputs({**case, "K": 1e6, "n": 1.5, "e": 1.0, "slip_velocity": 0.0}))
    assert float(impacts.head["tangential_impulse"]) == 0.0
    assert float(impacts.head["slip_velocity"]) == pytest.approx(
        0.3 * float(impacts.head["normal_impulse"]), rel=1e-9
    )


def test_arrays_are_broadcast_and_agree_with_single_cases(solver):
    K, v = np.logspace(8, 16, 5)[:, None], -np.linspace(0.1, 1, 3)
    impacts = solver(*inputs({**ROD, "K": K, "slip_velocity": v}))
    assert impacts.head["end"].shape == (5, 3)
    assert impacts.phase["slip"].shape == (5, 3, 4)
    one = solver(*inputs({**ROD, "K": float(K[2, 0]), "slip_velocity": float(v[1])}))
    assert impacts.head["normal_velocity"][2, 1] == one.head["normal_velocity"]


@pytest.mark.parametrize(
    ("change", "end"),
    [
        ({"b_n": 3.0}, FrozenEnd.NO_IMPACT),
        ({"compression_rate": -0.1}, FrozenEnd.NO_IMPACT),
        ({"mu": 0.1}, FrozenEnd.STAYS),
        ({"mu": 0.1, "e": 1.0}, FrozenEnd.STAYS),
        ({"b_n": 11.0, "compression": 1e-7}, FrozenEnd.SEPARATION),
    ],
)
def test_ends_are_named(solver, change, end):
    assert solver(*inputs({**ROD, **change})).ends == [end]


def test_plastic_contact_leaves_with_no_speed(solver):
    impacts = solver(*inputs({**ROD, "e": 0.0}))
    assert impacts.ends == [FrozenEnd.SEPARATION]
    assert impacts.head["normal_velocity"] == 0
    opens = solver(*inputs({**ROD, "e": 0.0, "compression": 1e-6, "compression_rate": -0.1}))
    assert opens.ends == [FrozenEnd.SEPARATION]
    assert (opens.head["phases"], opens.head["normal_velocity"]) == (0, 0.1)


@pytest.mark.slow
def test_a_motion_that_slip_presses_in_again_is_followed_on():
    """A < 0 turns the opening contact back: the reload rule of the law decides the force."""
    case = {"W_nn": 0.3116, "W_nt": -0.506, "W_tt": 1.8576, "b_n": -10.52, "b_t": -6.11, "mu": 1.16}
    case |= {"K": 1.8525e9, "n": 2.3, "e": 0.75, "slip_velocity": -0.0437086}
    case |= {"compression": 0.000165075, "compression_rate": 0.028847}
    slip = [
        FrozenImpactSolver(law("bilinear-hertz", reload=rule))(*inputs(case)).phase["slip"]
        for rule in ("elastic", "virgin")
    ]
    assert all(list(s[:5]) == [-1, 0, 0, -1, -1] for s in slip)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"K": 0.0}, "parameter E"),
        ({"e": 1.5}, "0 <= e_energetic <= 1"),
        ({"compression": -1e-9}, "compression: got -1e-09, need >= 0"),
        ({"b_n": math.nan}, "b_n: got nan"),
        ({"W_nt": 5.0}, "parameter A_stick"),
        ({"K": [1e9, 1e10], "slip_velocity": [-1, -2, -3]}, "shape"),
    ],
)
def test_bad_input_is_named(solver, change, text):
    with pytest.raises(InputError, match=text):
        solver(*inputs({**ROD, **change}))


def test_absent_and_unknown_input_is_named(solver):
    contact, start, parameters = inputs(ROD)
    with pytest.raises(InputError, match="no value of mu"):
        solver({k: v for k, v in contact.items() if k != "mu"}, start, parameters)
    with pytest.raises(InputError, match="unknown input 'speed'"):
        solver(contact, {**start, "speed": 1.0}, parameters)
    with pytest.raises(InputError, match="unknown parameter 'stiffness'"):
        solver(contact, start, {**parameters, "stiffness": 1.0})


@pytest.mark.parametrize("engine", ["compiled", "erk"])
def test_every_engine_gives_the_same_impact(solver, engine):
    one, other = solver(*inputs(ROD)), FrozenImpactSolver(solver.law, engine)(*inputs(ROD))
    assert one.ends == other.ends
    assert np.array_equal(one.phase["slip"], other.phase["slip"])
    for name in ("normal_velocity", "normal_impulse", "duration"):
        assert other.head[name] == pytest.approx(float(one.head[name]), rel=1e-9)
