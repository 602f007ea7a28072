"""The event loop on small automata whose motion is known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp

from painleve_sym.automata.automaton import Choice, HybridAutomaton, Mode, Transition
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.errors import InputError, StopReason

X, V, T = (sp.Symbol(n, real=True) for n in ("x", "v", "tau"))
E, G, C = (sp.Symbol(n, real=True) for n in ("e", "g", "c"))
OUT = {"position": X}


def automaton(name, modes, parameters=(), states=(X, V), starts=None):
    return HybridAutomaton(
        name=name,
        states=states,
        memory=(),
        parameters=parameters,
        definitions={},
        modes=modes,
        starts=starts or (Choice(modes[0].name),),
    )


def options(t_end, rtol=1e-12, nx=2, **more):
    return RunOptions(t_end, rtol, np.full(nx, more.pop("atol", rtol)), **more)


@pytest.fixture(scope="module", params=[CompiledEngine, TaylorEngine], ids=lambda e: e.name)
def engine(request):
    return request.param


def oscillating():
    return automaton("oscillator", (Mode("free", {X: V, V: -X}, (), OUT),))


@pytest.fixture(scope="module")
def oscillator(engine):
    return engine(oscillating())


@pytest.fixture(scope="module")
def runge_kutta():
    return CompiledEngine(oscillating())


@pytest.fixture(scope="module")
def ball(engine):
    """A ball falling on the floor x = 0 with Newton's restitution e."""
    land = Transition("land", "impact", X, (Choice("air"),), {V: -E * V, X: sp.Integer(0)})
    air = Mode("air", {X: V, V: -G}, (land,), OUT)
    return engine(automaton("ball", (air,), (E, G)))


@pytest.fixture(scope="module")
def ceiling(engine):
    """A tossed ball that stops at a ceiling x = c, which it may just touch."""
    hit = Transition("hit", "hit", C - X, (Choice("stuck"),), {V: sp.Integer(0)})
    air = Mode("air", {X: V, V: -G}, (hit,), OUT)
    stuck = Mode("stuck", {X: sp.Integer(0), V: sp.Integer(0)}, (), OUT)
    return engine(automaton("ceiling", (air, stuck), (G, C)))


def test_step_has_order_8(runge_kutta):
    errors, steps = [], [0.5, 0.25, 0.125]
    for h in steps:
        o = options(8.0, rtol=1e-15, atol=1e6, max_step=h, first_step=h, record="end")
        end = runge_kutta.run(np.array([1.0, 0.0]), np.empty(0), o).state
        errors.append(abs(end[0] - math.cos(8.0)) + abs(end[1] + math.sin(8.0)))
    orders = np.diff(np.log(errors)) / np.diff(np.log(steps))
    # The constant of the order-8 term is tiny, so the measured order nears 8 from above.
    assert np.all((orders > 7.7) & (orders < 8.7)), orders


def test_dense_output_has_order_7(runge_kutta):
    errors, steps = [], [1.0, 0.5, 0.25]
    for h in steps:
        o = options(h, rtol=1e-15, atol=1e6, max_step=h, first_step=h)
        row = runge_kutta.run(np.array([1.0, 0.3]), np.empty(0), o).steps[0, 3:-1].reshape(8, 2)
        worst = 0.0
        for u in np.linspace(0, 1, 21):
            value = np.zeros(2)
            for k in range(7, 0, -1):
                value = (value + row[k]) * (u if k % 2 else 1 - u)
            t = u * h
            worst = max(worst, abs(row[0, 0] + value[0] - (math.cos(t) + 0.3 * math.sin(t))))
        errors.append(worst)
    orders = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert np.all(orders > 7.5), orders  # error per step of a method of order 7 is h^8


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10, 1e-12])
def test_error_follows_tolerance(oscillator, rtol):
    end = oscillator.run(np.array([1.0, 0.0]), np.empty(0), options(20.0, rtol)).state
    assert abs(end[0] - math.cos(20.0)) < 30 * rtol


def test_event_times_of_a_bouncing_ball_are_exact(ball):
    e, g = 0.7, 9.81
    run = ball.run(np.array([1.0, 0.0]), np.array([e, g]), options(10.0, max_events=8))
    fall = math.sqrt(2 / g)
    times = [fall]
    for k in range(1, 8):
        times.append(times[-1] + 2 * fall * e**k)
    assert run.stop_reason is StopReason.EVENT_LIMIT
    # Round-off of each landing speed enters all later times.
    np.testing.assert_allclose(run.events[:, 0], times, rtol=4e-14)
    # Column 4 is x before the reset: the located zero, at round-off of the height fallen.
    assert np.max(np.abs(run.event_records.state_before[:, 0])) < 1e-15


def test_accumulation_is_named_at_its_limit(ball):
    e, g = 0.6, 9.81
    run = ball.run(np.array([1.0, 0.0]), np.array([e, g]), options(10.0))
    assert run.stop_reason is StopReason.ACCUMULATION
    limit = math.sqrt(2 / g) * (1 + e) / (1 - e)
    assert run.time == pytest.approx(limit, rel=1e-10)
    assert len(run.events) < 80


def test_no_accumulation_is_seen_where_bounces_keep_their_length(ball):
    run = ball.run(np.array([1.0, 0.0]), np.array([1.0, 9.81]), options(50.0))
    assert run.stop_reason is StopReason.T_END
    assert len(run.events) == 55  # (50/√(2/g) − 1)/2 + 1, by hand


@pytest.mark.parametrize("overshoot", [1e-3, 1e-6, 1e-9, 1e-12])
def test_two_crossings_inside_one_step_are_found(ceiling, overshoot):
    g, v = 10.0, 1.0
    top = v**2 / (2 * g)
    c = top * (1 - overshoot)
    run = ceiling.run(np.array([0.0, v]), np.array([g, c]), options(0.2, first_step=0.2))
    first = (v - math.sqrt(v**2 - 2 * g * c)) / g
    assert len(run.events) == 1
    # The crossing is nearly tangential: round-off of x over the speed there is what time can be.
    assert run.events[0, 0] == pytest.approx(first, abs=4e-16 / math.sqrt(overshoot))
    assert run.state[0] == pytest.approx(c, abs=1e-15)


def test_a_miss_is_no_event(ceiling):
    g, v = 10.0, 1.0
    run = ceiling.run(
        np.array([0.0, v]), np.array([g, v**2 / (2 * g) * (1 + 1e-9)]), options(0.2, first_step=0.2)
    )
    assert len(run.events) == 0


def test_simultaneous_guards_both_happen(engine):
    count = sp.Symbol("n", real=True)
    rest = Choice("both")
    a = Transition("a", "a", 1 - X, (rest,), {X: X - 2, count: count + 1})
    b = Transition("b", "b", 1 - V, (rest,), {V: V - 2, count: count + 10})
    mode = Mode("both", {X: sp.Integer(1), V: sp.Integer(1)}, (a, b), OUT)
    pair = engine(automaton("pair", (mode,), states=(X, V, count)))
    run = pair.run(np.zeros(3), np.empty(0), options(1.5, nx=3))
    assert [mode.transitions[int(j)].kind for j in run.events[:, 2]] == ["a", "b"]
    np.testing.assert_allclose(run.events[:, 0], 1.0, rtol=1e-15)
    assert run.state[2] == 11


@pytest.mark.parametrize(
    ("start", "events"),
    [
        ((0.0, 1.0), 1),  # on the floor, leaving: lands once
        ((0.0, -1.0), 1),  # on the floor, entering: the start itself is reset, then lands once
        ((0.0, 0.0), 0),  # at rest on a floor that gives way (g < 0 below): leaves by acceleration
    ],
)
def test_guards_are_armed_by_their_first_derivative_that_is_not_zero(ball, start, events):
    g = -9.81 if start == (0.0, 0.0) else 9.81
    run = ball.run(np.array(start), np.array([1.0, g]), options(0.25))
    assert run.stop_reason is StopReason.T_END
    assert len(run.events) == events


def test_a_flight_far_shorter_than_the_step_is_found(ball):
    v = 1e-7
    run = ball.run(
        np.array([0.0, v]), np.array([0.0, 10.0]), options(1.0, first_step=0.5, max_events=1)
    )
    assert run.events[0, 0] == pytest.approx(2 * v / 10.0, rel=1e-12)


def test_blow_up_is_reported(engine):
    mode = Mode("blow", {X: X**2, V: sp.Integer(0)}, (), OUT)
    blow_up = engine(automaton("blow-up", (mode,)))
    run = blow_up.run(np.array([1.0, 0.0]), np.empty(0), options(2.0))
    assert run.stop_reason in (StopReason.STEP_UNDERFLOW, StopReason.NON_FINITE)
    assert run.time == pytest.approx(1.0, abs=1e-6)
    assert np.all(np.isfinite(run.steps))


def test_not_a_number_is_reported(engine):
    mode = Mode("nan", {X: sp.log(X), V: sp.Integer(0)}, (), OUT)
    not_a_number = engine(automaton("nan", (mode,)))
    run = not_a_number.run(np.array([-1.0, 0.0]), np.empty(0), options(1.0))
    assert run.stop_reason is StopReason.NON_FINITE
    assert run.time == 0


def test_step_limit_keeps_what_was_computed(oscillator):
    run = oscillator.run(np.array([1.0, 0.0]), np.empty(0), options(1e4, max_steps=50))
    assert run.stop_reason is StopReason.STEP_LIMIT
    assert 0 < run.time < 1e4
    assert run.state[0] == pytest.approx(math.cos(run.time), abs=1e-9)


def test_until_stops_after_the_event(ball):
    run = ball.run(np.array([1.0, 0.0]), np.array([0.5, 9.81]), options(10, until=("impact",)))
    assert run.stop_reason is StopReason.UNTIL
    assert len(run.events) == 1
    assert run.state[1] == pytest.approx(0.5 * math.sqrt(2 * 9.81), rel=1e-14)


def test_records_are_as_asked(ball):
    start, p = np.array([1.0, 0.0]), np.array([0.5, 9.81])
    end, events, dense = (
        ball.run(start, p, options(0.8, record=r)) for r in ("end", "events", "dense")
    )
    assert len(end.steps) == len(end.events) == len(events.steps) == 0
    assert len(events.events) == len(dense.events) == 1
    assert len(dense.steps) > 0
    np.testing.assert_array_equal(end.state, dense.state)


@pytest.mark.parametrize(
    "bad",
    [
        {"rtol": 0.0},
        {"rtol": 2.0},
        {"rtol": float("nan")},
        {"record": "all"},
        {"max_step": 0.0},
        {"first_step": -1.0},
        {"max_steps": 0},
        {"max_events": 0},
    ],
)
def test_options_refuse_what_makes_no_sense(bad):
    with pytest.raises(InputError):
        RunOptions(**{"t_end": 1.0, "rtol": 1e-9, "atol": np.ones(2), **bad})
