"""Friction curves over the slip velocity, static above kinetic friction: closed periods, SciPy."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import painleve_sym as ps
from painleve_sym.errors import EventKind, InputError, ModelError, StopReason
from painleve_sym.mechanics.friction import SLIP_VELOCITY
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.time_stepping.stepping import TimeStepper
from tests.motion.comparisons import assert_same_motion, total_energy
from tests.scenes import parameter, point_mass

SPRING = """
[[springs]]
extension = "x"
stiffness = "k_s"
"""
LEINE = "mu/(1 + d*abs(v_t))"
EXPONENTIAL = "mu_k + (mu - mu_k)*exp(-abs(v_t)/v_s)"
BUMP = "mu*(1 + 0.5*(v_t/v_s)**2*exp(-abs(v_t)/v_s))"
OWN = (
    parameter("k_s", 1.0, "N/m", "stiffness of the spring", "positive = true")
    + parameter("u", 0.2, "m/s", "speed of the belt")
    + parameter("d", 3.0, "s/m", "fall of the friction", "lower = 0")
    + parameter("mu_k", 0.3, "1", "friction of slip", "lower = 0")
    + parameter("v_s", 0.1, "m/s", "velocity of the curve", "positive = true")
)
UNIT = {"m": 1.0, "g": 1.0, "mu": 1.0, "mu_k": 0.6}
"""Leine's block: m g = 1 N."""


@functools.cache
def belt(friction, static="", law="rigid", choice="coulomb"):
    contact = 'surface_speed = "u"' + (f'\nstatic_friction = "{static}"' if static else "")
    text = point_mass(name="block", contact=contact, parameters=OWN, more=SPRING)
    text = text.replace('\nfriction = "mu"', f'\nfriction = "{friction}"')
    return ps.Simulator(mechanism_from_text(text), ps.law(law, friction=choice))


def run_on(simulator, t_end=30.0, state=None, **parameters):
    values = UNIT | parameters
    start = {"x_dot": values.get("u", 0.2), **(state or {})}
    force = None if simulator.rigid else values["m"] * values["g"]
    given = {"initial_force": force} if force else {}
    if not simulator.rigid:
        values |= {"k": 1e5, "c": 200.0}
    return simulator.run(start, t_end=t_end, parameters=values, rtol=1e-12, **given)


def cycle(run):
    """Return the last whole period, between starts of slip, and the time of slip in it."""
    starts, stops = (run.events_of(kind) for kind in ("slip_start", "slip_stop"))
    first, second = starts[-2].time, starts[-1].time
    (stop,) = [e.time for e in stops if first < e.time < second]
    return second - first, stop - first


def slip_by_scipy(mu, rest, u, k=1.0, m=1.0, load=1.0):
    """Return period and time of slip; the block sticks up to `rest`, `mu` is a function of |v|."""

    def rates(_, z):
        return [z[1], (-k * z[0] + load * mu(u - z[1])) / m]

    def same_speed(_, z):
        return z[1] - u

    same_speed.terminal, same_speed.direction = True, 1
    begin = rest * load / k
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "max_step": 0.05}
    # From rest against the belt it slips back: v falls below u at once.
    way = solve_ivp(rates, (0, 60), [begin, u], events=same_speed, **options)
    slipping, end = way.t_events[0][-1], way.y_events[0][-1][0]
    return slipping + (begin - end) / u, slipping


# ---- closed solutions and SciPy ----


@pytest.mark.parametrize("law", ["rigid", "linear"])
def test_block_of_leine_has_the_period_of_an_independent_integration(law):
    period, slip = cycle(run_on(belt(LEINE, law=law)))
    expected = slip_by_scipy(lambda v: 1 / (1 + 3 * v), 1.0, 0.2)
    assert (period, slip) == pytest.approx(expected, rel=1e-11)
    # Leine et al. (1998).
    assert expected == pytest.approx((12.0010312948306, 4.2959995254802), rel=1e-12)


@pytest.mark.parametrize(
    "simulator",
    [
        lambda: belt("mu_k", "mu"),
        lambda: belt("mu_k", choice="static"),
        lambda: belt("mu_k", "mu", law="linear"),
    ],
    ids=["contact", "law", "compliant"],
)
@pytest.mark.parametrize(("mu_s", "k_s", "u"), [(1.0, 1.0, 0.2), (0.75, 40.0, 0.03)])
def test_static_friction_above_kinetic_has_its_closed_period(simulator, mu_s, k_s, u):
    own = simulator()
    values = {"mu": mu_s, "k_s": k_s, "u": u}
    if "static_ratio" in own.outline.parameter_names:
        values["static_ratio"] = mu_s / 0.6
    w, A = math.sqrt(k_s), (mu_s - 0.6) / k_s
    slip = 2 / w * (math.pi - math.atan(A * w / u))
    run = run_on(own, 3 * (2 * A / u + slip) + mu_s / k_s / u, **values)
    assert cycle(run) == pytest.approx((2 * A / u + slip, slip), rel=1e-10)


@pytest.mark.parametrize("law", ["rigid", "linear"])
@pytest.mark.parametrize(
    ("friction", "mu"),
    [
        (EXPONENTIAL, lambda v: 0.6 + 0.4 * math.exp(-v / 0.1)),
        (BUMP, lambda v: 1 + 0.5 * (v / 0.1) ** 2 * math.exp(-v / 0.1)),
    ],
    ids=["exponential", "bump"],
)
def test_other_curves_slip_as_scipy_says(friction, mu, law):
    # From rest on the belt pulled too far: it slips back and stops once.
    run = run_on(belt(friction, law=law), 20.0, {"x": 1.7})
    times = np.linspace(0, run.events_of("slip_stop")[0].time, 30)[1:-1]
    way = solve_ivp(
        lambda _, z: [z[1], -z[0] + math.copysign(mu(abs(z[1] - 0.2)), 0.2 - z[1])],
        (0, times[-1]),
        [1.7, 0.2 - 1e-14],
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
        t_eval=times,
        max_step=0.01,
    )
    assert run.values("x", times) == pytest.approx(way.y[0], abs=1e-9)
    assert run.values("x_dot", times) == pytest.approx(way.y[1], abs=1e-9)


def test_runs_close_their_energy():
    run = run_on(belt(EXPONENTIAL))
    energy = total_energy(run, np.linspace(0, run.final_time, 200))
    assert np.ptp(energy) < 1e-10 and run.energy_residual < 1e-10


# ---- symmetries ----


@pytest.mark.parametrize("law", ["rigid", "linear"])
def test_mirrored_belt_gives_the_mirrored_motion(law):
    simulator = belt(EXPONENTIAL, "1.2*mu", law=law)
    run = run_on(simulator)
    mirrored = run_on(simulator, u=-0.2)
    swapped = {"slip_start": "slip_start", "slip_stop": "slip_stop"}
    assert [e.kind for e in run.events] == [e.kind for e in mirrored.events]
    assert {e.kind.value for e in run.events} >= set(swapped)
    for one, other in zip(run.events, mirrored.events, strict=True):
        assert one.time == pytest.approx(other.time, rel=1e-13)
        assert one.state["x"] == pytest.approx(-other.state["x"], abs=1e-13)


def test_motion_does_not_depend_on_units():
    # Millimetres and milliseconds: 1 N = 1e-3 kg mm/ms^2; velocities stay.
    simulator = belt(EXPONENTIAL, "1.2*mu")
    run = run_on(simulator)
    scaled = run_on(simulator, 30e3, k_s=1e-6, g=1e-3, u=0.2)
    for one, other in zip(run.events, scaled.events, strict=True):
        assert (one.kind, 1e3 * one.time) == (other.kind, pytest.approx(other.time, rel=1e-11))


# ---- Coulomb is an instance ----


@settings(max_examples=8, deadline=None)
@given(
    mu=st.floats(0.1, 1.5),
    k_s=st.floats(0.3, 9.0),
    x=st.floats(1e-3, 2) | st.floats(-2, -1e-3),
    law=st.sampled_from(["rigid", "linear"]),
)
def test_constant_curve_gives_the_run_of_the_constant(mu, k_s, x, law):
    values = {"mu": mu, "k_s": k_s, "d": 0.0}
    plain = run_on(belt("mu", law=law), 12.0, {"x": x}, **values)
    # A whole turn after sticking the slip would graze zero again.
    ends = [e.time + 6 / math.sqrt(k_s) for e in plain.events_of("slip_start")]
    end = min([12.0, *ends])
    runs = [run_on(belt(f, law=law), end, {"x": x}, **values) for f in (LEINE, "mu")]
    # The compression of a pressed block that rests is rounding, and so are its maxima.
    kinds = {EventKind.SLIP_START, EventKind.SLIP_STOP}
    own, other = ([e for e in run.events if e.kind in kinds] for run in runs)
    assert [e.kind for e in own] == [e.kind for e in other]
    assert [e.time for e in own] == pytest.approx([e.time for e in other], rel=1e-11)
    for name in ("x", "x_dot"):
        assert runs[0].final[name] == pytest.approx(runs[1].final[name], abs=1e-10)


@pytest.mark.parametrize("law", ["rigid", "linear"])
def test_equal_static_friction_is_coulombs_bit_for_bit(law):
    plain, same = (run_on(belt("mu", static, law=law)) for static in ("", "mu"))
    assert [(e.kind, e.time, e.state) for e in plain.events] == [
        (e.kind, e.time, e.state) for e in same.events
    ]
    assert plain.final == same.final


def test_static_ratio_of_one_is_coulombs():
    plain = run_on(belt("mu"), 10.0)
    assert_same_motion(
        run_on(belt("mu", choice="static"), 10.0, static_ratio=1.0),
        plain,
        times=1e-13,
        values=1e-12,
    )


# ---- the contact problem ----


def test_classification_takes_friction_at_the_slip_velocity():
    rod = ps.models.rod()
    A = rod.contact
    curve = ps.Contact("A", rod.system, A.gap, A.slip_velocity, A.mu / (1 + abs(SLIP_VELOCITY)))
    falling = ps.Mechanism("falling", "", "", rod.system, (curve,), rod.domain)
    for speed in (0.1, 1.0, 5.0):
        state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -speed}
        own = ps.classify(falling, state, parameters={"mu": 1.8})
        plain = ps.classify("rod", state, parameters={"mu": 1.8 / (1 + speed)})
        assert own.case is plain.case
        assert own.problem.mu.item() == pytest.approx(1.8 / (1 + speed), rel=1e-15)
        assert pytest.approx(plain.problem.A, rel=1e-13) == own.problem.A


# ---- impacts ----


def test_impact_that_slides_under_a_curve_stops_with_its_reason():
    run = belt(LEINE).run({"y": 0.1, "x_dot": 0.5}, t_end=2.0, parameters=UNIT)
    assert run.stop_reason is StopReason.VARYING_FRICTION
    assert run.events[-1].kind is EventKind.IMPACT and "compliant contact" in run.stop_detail


# ---- where friction may not be ----


def test_run_ends_where_friction_would_no_longer_be_positive():
    run = run_on(belt("mu - d*abs(v_t)"), 60.0, {"x": -4.0}, d=1.0)
    assert run.stop_reason is StopReason.LEFT_DOMAIN
    assert abs(run.final["x_dot"] - 0.2) == pytest.approx(1.0, abs=1e-9)


def test_static_friction_below_that_of_slip_is_rejected():
    with pytest.raises(InputError, match="static friction of contact"):
        run_on(belt("mu_k", "mu"), mu=0.59)


@pytest.mark.parametrize(
    ("friction", "static", "words"),
    [
        ("mu*(1 + v_t)", "", "differs between v_t and -v_t"),
        ("mu*(1 + x**2)", "", "need a formula of parameters alone and of v_t"),
        ("mu - 2*mu/(1 + abs(v_t))", "", "need a number >= 0"),
        ("mu/(1 + abs(v_t))", "mu/2", "neither stick nor slip"),
        ("mu/(1 + abs(v_t))", "mu*abs(v_t)", "v_t"),
        ("mu/(sin(u)**2 + cos(u)**2 - 1)", "", "not finite"),
        ("mue", "", "Did you mean 'mu'"),
    ],
)
def test_wrong_curves_are_rejected_with_their_line(friction, static, words):
    with pytest.raises(ModelError, match=words) as raised:
        belt(friction, static)
    assert "contacts" in str(raised.value)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda m: ps.Simulator(m, ps.law("linear", friction="spring")), "series with one"),
        (lambda m: ps.evaluate_jump(m, "newton", {"y_dot": -1.0}), "need one coefficient"),
        (lambda m: TimeStepper(m), "need one coefficient"),
    ],
)
def test_what_has_no_curves_says_so(make, words):
    with pytest.raises(InputError, match=words):
        make(belt(LEINE).mechanism)
