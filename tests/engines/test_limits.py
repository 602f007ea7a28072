"""Every engine passes the limit of accumulating events."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from painleve_sym.automata.automaton import (
    Accumulation,
    Choice,
    HybridAutomaton,
    Mode,
    Transition,
)
from painleve_sym.engines.batch import BatchOutputs, BatchRows
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.erk import ErkEngine
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.engines.records import EventRecords, StepRecords
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.errors import EventKind, ModelError, StopReason

X, V = (sp.Symbol(n, real=True) for n in ("x", "v"))
E, G = (sp.Symbol(n, real=True) for n in ("e", "g"))
ZERO = sp.Integer(0)
OUT = {"position": X, "energy": V**2 / 2}


def automaton(modes, **more):
    starts = (Choice(modes[0].name),)
    return HybridAutomaton("ball", (X, V), (), (E, G), {}, modes, starts, **more)


def ball(reset=None, target="rest", **more):
    """A ball that bounces and, at the limit of its bounces, comes to rest."""
    limit = Accumulation(EventKind.SETTLE, target, {X: ZERO, V: ZERO} if reset is None else reset)
    land = Transition(
        "land",
        EventKind.TOUCHDOWN,
        X,
        (Choice("air"),),
        {V: -E * V, X: ZERO},
        contact="floor",
        on_accumulation=limit,
        **more,
    )
    air = Mode("air", {X: V, V: -G}, (land,), OUT)
    return automaton((air, Mode("rest", {V: ZERO}, (), OUT)))


@pytest.fixture(scope="module", params=[CompiledEngine, TaylorEngine, ErkEngine])
def engine(request):
    return request.param


def options(t_end, **more):
    return RunOptions(t_end, 1e-11, np.array([1e-11, 1e-10]), **more)


START, CONSTANTS = np.array([1.0, 0.0]), np.array([0.5, 10.0])
FALL = np.sqrt(0.2)
LIMIT = FALL * (1 + 2 * 0.5 / (1 - 0.5))


def test_run_goes_on_past_the_limit_of_its_bounces(engine):
    raw = engine(ball()).run(START, CONSTANTS, options(5.0))
    assert raw.stop_reason is StopReason.T_END and raw.time == pytest.approx(5.0, rel=1e-15)
    assert raw.mode == 1 and raw.state.tolist() == [0.0, 0.0]
    events = raw.event_records
    settled = events.transition < 0
    assert settled.sum() == 1 and settled[-1]
    assert events.time[-1] == pytest.approx(LIMIT, rel=1e-10)
    assert events.mode_before[-1] == 0 and events.mode_after[-1] == 1
    kinds, contacts = ball().kinds, ball().contacts
    assert kinds == (EventKind.TOUCHDOWN, EventKind.SETTLE)
    assert kinds[events.kind[-1]] is EventKind.SETTLE and contacts[events.contact[-1]] == "floor"
    assert raw.counters["events"] == len(raw.events)
    steps = raw.step_records
    ends = steps.time + steps.length
    np.testing.assert_allclose(ends[:-1], steps.time[1:], rtol=1e-14)
    assert steps.polynomial[-1, 0].tolist() == [0.0, 0.0]


def test_run_may_end_at_the_limit(engine):
    raw = engine(ball()).run(START, CONSTANTS, options(5.0, until=(EventKind.SETTLE,)))
    assert raw.stop_reason is StopReason.UNTIL
    assert raw.time == pytest.approx(LIMIT, rel=1e-10) and raw.state.tolist() == [0.0, 0.0]


def test_limit_that_would_change_the_state_is_not_passed(engine):
    raw = engine(ball(reset={X: sp.Integer(1), V: ZERO})).run(START, CONSTANTS, options(5.0))
    assert raw.stop_reason is StopReason.ACCUMULATION
    assert EventKind.SETTLE not in {ball().kinds[k] for k in raw.event_records.kind}


def test_limits_of_a_whole_run_are_counted_together(engine):
    free = engine(ball()).run(START, CONSTANTS, options(5.0))
    bounces = len(free.events) - 1
    raw = engine(ball()).run(START, CONSTANTS, options(5.0, max_events=bounces + 1))
    assert raw.stop_reason is StopReason.EVENT_LIMIT and len(raw.events) == bounces + 1


def test_time_goes_on_through_two_limits(engine):
    """After half a second at rest the ball is tossed with 1 m/s and bounces for 2/(g (1 − e)) s."""
    air = ball().modes[0]
    toss = Transition("toss", "toss", sp.Rational(1, 2) - V, (Choice("air"),), {V: sp.Integer(1)})
    raw = engine(automaton((air, Mode("rest", {V: sp.Integer(1)}, (toss,), OUT)))).run(
        START, CONSTANTS, options(LIMIT + 0.5 + 0.4 + 0.25)
    )
    limits = raw.event_records.time[raw.event_records.transition < 0]
    assert limits.tolist() == pytest.approx([LIMIT, LIMIT + 0.5 + 0.4], rel=1e-9)
    assert raw.state[1] == pytest.approx(0.25, rel=1e-8)


def test_limit_of_an_unknown_mode_is_refused():
    with pytest.raises(ModelError, match="unknown mode 'nowhere'"):
        ball(target="nowhere")


@pytest.mark.parametrize("kind", [CompiledEngine, TaylorEngine])
def test_batch_passes_limits_bit_for_bit_like_single_runs(kind):
    engine = kind(ball())
    heights = np.linspace(0.1, 2.0, 23)
    states = np.column_stack([heights, np.zeros(23)])
    parameters = np.column_stack([np.linspace(0.1, 0.8, 23), np.full(23, 10.0)])
    o, kept = options(9.0), BatchOutputs(2, maxima=("energy",), integrals=("position",))
    rows = BatchRows.empty(23, engine.outline, kept)
    atol = np.tile(o.atol, (23, 1))
    engine.run_batch(states, parameters, np.full(23, 9.0), atol, o, kept, rows)
    for i in range(23):
        raw = engine.run(states[i], parameters[i], o)
        assert rows.time[i] == raw.time and rows.mode[i] == raw.mode == 1
        assert rows.state[i].tolist() == raw.state.tolist()
        settled = raw.event_records.time[raw.event_records.transition < 0]
        assert rows.event_counts[i, 1] == 1 and rows.event_times[i, 1, 0] == settled[0]
        assert rows.extremes[i, 0, 0] == pytest.approx(10.0 * heights[i], rel=1e-9)


def test_records_are_read_as_they_are_written():
    rng = np.random.default_rng(1)
    steps = rng.integers(0, 9, (4, StepRecords.width(3, 2, 5))).astype(float)
    events = rng.integers(0, 9, (4, EventRecords.width(3, 2))).astype(float)
    np.testing.assert_array_equal(StepRecords.of(steps, 3, 2).rows(), steps)
    np.testing.assert_array_equal(EventRecords.of(events, 3, 2).rows(), events)
    assert StepRecords.of(steps[:0], 3, 2).rows().shape == steps[:0].shape


@pytest.mark.parametrize("departs", [True, False])
def test_guard_beyond_the_thirty_second_may_leave_zero(engine, departs):
    """Just after the start x³ − 1e-25 x is negative to below round-off of the time."""
    exits = [
        Transition(f"exit_{i}", EventKind.SLIP_STOP, X + i + 1, stop=StopReason.JAM)
        for i in range(39)
    ]
    kind, guard = EventKind.SLIP_START, X**3 - sp.Float("1e-25") * X
    last = Transition("last", kind, guard, stop=StopReason.SINGULAR)
    go = Transition("go", EventKind.CONTACT, None, (Choice("air", departs=("last",) * departs),))
    built = automaton((Mode("start", {}, (go,), OUT), Mode("air", {X: V}, (*exits, last), OUT)))
    raw = engine(built).run(np.array([0.0, 1.0]), CONSTANTS, options(1.0))
    assert raw.stop_reason is (StopReason.T_END if departs else StopReason.SINGULAR)
    assert departs or raw.time == 0
