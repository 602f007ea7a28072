"""The engine on CasADi's `erk` against the compiled one: the same automaton, other code."""

from __future__ import annotations

import functools
import math
import threading

import numpy as np
import pytest
import sympy as sp

from painleve_sym.automata.automaton import Choice, HybridAutomaton, Mode, Transition
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.erk import ErkEngine
from painleve_sym.engines.factory import make_engine
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.errors import CompilerMissing, InputError, PainleveWarning, StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.motion.simulator import Simulator
from tests.support.paper_law import paper_law

TABLE_1 = {"theta": 0.5, "theta_dot": 1.0, "x_A_dot": -1.0}
TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
TABLE_4 = {"theta": 1.0, "theta_dot": 5.0, "x_A_dot": -1.0}


@functools.cache
def simulator(name, engine, reload=None):
    choices = {"reload": reload} if reload else {}
    own = paper_law if name == "bilinear-hertz" else functools.partial(law, name)
    return Simulator(rod(), own(**choices), engine)


def both(name, reload, state, **options):
    return (simulator(name, e, reload).run(state, **options) for e in ("compiled", "erk"))


# ---- the rod ----

SOFT, HARD, HARDER = {"E": 20.9e10}, {"E": 20.9e14}, {"E": 20.9e16}
PAPER = ("bilinear-hertz", "virgin")
CASES = {
    "table 1": (*PAPER, TABLE_1, {"t_end": 0.0175, "parameters": SOFT}),
    "table 1, elastic reload": (
        "bilinear-hertz",
        "elastic",
        TABLE_1,
        {"t_end": 0.0175, "parameters": SOFT},
    ),
    "table 1, hard": (*PAPER, TABLE_1, {"t_end": 0.8e-3, "parameters": HARD}),
    "table 3": (
        *PAPER,
        TABLE_3,
        {"t_end": 0.01, "parameters": HARD, "until": "separation"},
    ),
    "table 3, bouncing": (*PAPER, TABLE_3, {"t_end": 0.03, "parameters": HARD}),
    "table 5, 150 N": (
        *PAPER,
        TABLE_4,
        {"t_end": 0.01, "parameters": HARD, "initial_force": 150.0},
    ),
    "table 5, 333 N": (
        *PAPER,
        TABLE_4,
        {"t_end": 0.001, "parameters": HARD, "initial_force": 333.0},
    ),
    "table 6, 350 N": (
        *PAPER,
        TABLE_4,
        {"t_end": 0.001, "parameters": HARDER, "initial_force": 350.0},
    ),
    "table 6, 1000 N": (
        *PAPER,
        TABLE_4,
        {"t_end": 0.001, "parameters": HARDER, "initial_force": 1000.0},
    ),
    "hertz": ("hertz", None, TABLE_3, {"t_end": 0.01, "parameters": {"E": 20.9e12}}),
    "linear": ("linear", None, TABLE_1, {"t_end": 0.02, "parameters": {"c": 1000.0}}),
    "hunt-crossley": ("hunt-crossley", None, TABLE_3, {"t_end": 0.01, "parameters": HARD}),
}


@pytest.mark.parametrize("case", CASES)
def test_engines_agree_on_the_rod(case):
    name, reload, state, options = CASES[case]
    a, b = both(name, reload, state, **options)
    assert (b.engine, b.stop_reason) == ("erk", a.stop_reason)
    assert [(e.kind, e.mode_before, e.mode_after) for e in a.events] == [
        (e.kind, e.mode_before, e.mode_after) for e in b.events
    ]
    assert len(a.events) > 1
    largest = {n: float(np.max(np.abs(a.step_rows[:, 0, i]))) for i, n in enumerate(a.state_names)}
    # At 333 N the first event is 0.4 N from the equilibrium that it leaves: ten times the rest.
    for e, f in zip(a.events, b.events, strict=True):
        assert f.time == pytest.approx(e.time, rel=1e-8)
        assert f.normal_force == pytest.approx(e.normal_force, rel=1e-8, abs=1e-5)
        for n, size in largest.items():
            # Below 1e-60 J nothing has been dissipated.
            assert f.state[n] == pytest.approx(e.state[n], abs=3e-9 * max(size, 1e-60)), n
    assert b.energy_residual < 1e-10


@pytest.mark.parametrize("case", ["table 1", "table 3", "table 3, bouncing", "table 6, 350 N"])
def test_engines_agree_between_events(case):
    name, reload, state, options = CASES[case]
    a, b = both(name, reload, state, **options)
    times = a.sample(500)[:-1]
    largest = np.max(np.abs(a.step_rows[:, 0]), axis=0)
    # The compiled engine's dense output, of order 7 on long steps, is the less exact one.
    assert np.max(np.abs(a(times) - b(times)) / largest) < 1e-7
    force = a.values("normal_force", times)
    np.testing.assert_allclose(
        b.values("normal_force", times), force, rtol=0, atol=1e-7 * np.max(force)
    )


def test_separation_of_table_3_is_that_of_the_80_bit_taylor_solution():
    run = simulator(*PAPER[:1], "erk", PAPER[1]).run(
        TABLE_3, t_end=1e-3, parameters=HARD, until="separation", rtol=1e-12
    )
    assert run.final_time == pytest.approx(0.0004281634640972055, rel=1e-12)
    assert run.final["y_A_dot"] == pytest.approx(0.06561146794473227, rel=1e-11)
    assert run.final["theta_dot"] == pytest.approx(1.6029856063339739, rel=1e-13)


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10, 1e-12])
def test_tolerance_governs_the_error(rtol):
    run = simulator("bilinear-hertz", "erk", "virgin").run(
        TABLE_3, t_end=1e-3, parameters=HARD, until="slip_stop", rtol=rtol
    )
    assert abs(run.final_time / 4.0886242206149e-4 - 1) < max(rtol, 1e-13)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"until": "separation"}, StopReason.UNTIL),
        ({"t_end": 2.0, "state": TABLE_4}, StopReason.LEFT_DOMAIN),
        ({"max_events": 3}, StopReason.EVENT_LIMIT),
        ({"max_steps": 5}, StopReason.STEP_LIMIT),
        ({"t_end": 1e-4}, StopReason.T_END),
    ],
)
def test_stop_reasons_are_equal(options, reason):
    a, b = both(*PAPER, **{"state": TABLE_3, "t_end": 0.005, "parameters": HARD, **options})
    assert a.stop_reason is b.stop_reason is reason
    assert a.stop_detail == b.stop_detail
    assert len(a.events) == len(b.events)
    if reason is not StopReason.STEP_LIMIT:  # which ends the two in different places
        assert b.final_time == pytest.approx(a.final_time, rel=1e-8)


def test_outputs_are_equal():
    a, b = both(*PAPER, TABLE_3, t_end=1e-3, parameters=HARD)
    times = a.sample(700)
    states, modes = a(times), a.step_mode[a._locate(times)]
    memory = a.step_memory[a._locate(times)]
    one, other = (r.evaluator.outputs(modes, states, memory, r.constants) for r in (a, b))
    np.testing.assert_array_equal(a.constants, b.constants)
    # Machine code and virtual machine may round a power differently.
    np.testing.assert_allclose(other, one, rtol=1e-12, atol=1e-12)


def test_a_start_at_zero_speed_is_no_trap():
    # Sticking has nothing to hold it and slip nothing to drive it but 1e-16 rad/s.
    state = {"theta": 0.5, "theta_dot": 2.2e-16, "y_A_dot": -5e-324}
    a, b = both("linear", None, state, t_end=0.002, parameters={"mu": 1.2}, max_events=200)
    assert a.stop_reason is b.stop_reason is StopReason.T_END
    np.testing.assert_allclose(b.final_state, a.final_state, atol=1e-9)


def test_grazing_separation_is_not_missed():
    # Undamped, the rod all but comes back to rest on the surface: 0.17 nm of gap for 0.4 μs.
    run = simulator("linear", "erk").run(
        {"theta": 0.3, "theta_dot": 1e-5}, t_end=1.4e-3, parameters={"mu": 0.0}, rtol=1e-11
    )
    assert "reload" not in {e.kind for e in run.events}
    # Agreed on by both engines at rtol 1e-13 with steps of 1 μs.
    assert run.events_of("separation")[-1].time == pytest.approx(1.299743644145e-3, rel=1e-9)


# ---- small automata ----

X, V = sp.symbols("x v", real=True)
E, G, C = sp.symbols("e g c", real=True)
OUT = {"position": X}


def automaton(name, modes, parameters=(), states=(X, V), memory=()):
    start = (Choice(modes[0].name),)
    return HybridAutomaton(name, states, memory, parameters, {}, modes, start)


def ball():
    land = Transition("land", "impact", X, (Choice("air"),), {V: -E * V, X: sp.Integer(0)})
    return automaton("ball", (Mode("air", {X: V, V: -G}, (land,), OUT),), (E, G))


def ceiling():
    hit = Transition("hit", "hit", C - X, (Choice("stuck"),), {V: sp.Integer(0)})
    air = Mode("air", {X: V, V: -G}, (hit,), OUT)
    return automaton("ceiling", (air, Mode("stuck", {}, (), OUT)), (G, C))


def pair():
    count = sp.Symbol("n", real=True)
    again = (Choice("both"),)
    a = Transition("a", "a", 1 - X, again, {X: X - 2, count: count + 1})
    b = Transition("b", "b", 1 - V, again, {V: V - 2, count: count + 10})
    mode = Mode("both", {X: sp.Integer(1), V: sp.Integer(1)}, (a, b), OUT)
    return automaton("pair", (mode,), states=(X, V, count))


def loop():
    there = Transition("go", "go", -X, (Choice("b"),))
    back = Transition("go", "go", -X, (Choice("a"),))
    modes = (Mode("a", {X: sp.Integer(1)}, (there,), OUT), Mode("b", {}, (back,), OUT))
    return automaton("loop", modes)


def single(name, rate, *transitions):
    return automaton(name, (Mode("one", {X: rate}, transitions, OUT),))


SMALL = {
    "fall and bounce": (ball(), (1.0, 0.0), (0.7, 9.81), {"t_end": 2.0}),
    "bounces accumulate": (ball(), (1.0, 0.0), (0.6, 9.81), {"t_end": 10.0}),
    "event limit": (ball(), (1.0, 0.0), (0.9, 9.81), {"t_end": 10.0, "max_events": 4}),
    "on the floor, leaving": (ball(), (0.0, 1.0), (1.0, 9.81), {"t_end": 0.25}),
    "on the floor, entering": (ball(), (0.0, -1.0), (1.0, 9.81), {"t_end": 0.25}),
    "on the floor, floating off": (ball(), (0.0, 0.0), (1.0, -9.81), {"t_end": 0.25}),
    "flight far shorter than a step": (
        ball(),
        (0.0, 1e-7),
        (0.0, 10.0),
        {"t_end": 1.0, "first_step": 0.5, "max_events": 1},
    ),
    "two crossings in a step": (
        ceiling(),
        (0.0, 1.0),
        (10.0, 0.05 * (1 - 1e-9)),
        {"t_end": 0.2, "first_step": 0.2},
    ),
    "a near miss": (
        ceiling(),
        (0.0, 1.0),
        (10.0, 0.05 * (1 + 1e-9)),
        {"t_end": 0.2, "first_step": 0.2},
    ),
    "two guards at once": (pair(), (0.0, 0.0, 0.0), (), {"t_end": 1.5}),
    "a chain without end": (loop(), (-1.0, 0.0), (), {"t_end": 3.0}),
    "stop asked for": (ball(), (1.0, 0.0), (0.5, 9.81), {"t_end": 9.0, "until": ("impact",)}),
    "step limit": (single("sine", sp.cos(X)), (0.0, 0.0), (), {"t_end": 1e4, "max_steps": 60}),
    "not a number": (single("nan", sp.log(X)), (-1.0, 0.0), (), {"t_end": 1.0}),
    "blow-up": (single("blow-up", X**2), (1.0, 0.0), (), {"t_end": 2.0}),
    "left out of the domain": (
        single("domain", 1 + X, Transition("out", "out", 1 - X, stop=StopReason.LEFT_DOMAIN)),
        (0.0, 0.0),
        (),
        {"t_end": 3.0},
    ),
}


@pytest.mark.parametrize("case", SMALL)
def test_engines_agree_on_small_automata(case):
    system, start, parameters, more = SMALL[case]
    o = RunOptions(rtol=1e-12, atol=np.full(len(start), 1e-12), **more)
    a, b = (
        engine(system).run(np.array(start), np.array(parameters), o)
        for engine in (CompiledEngine, ErkEngine)
    )
    assert b.stop_reason is a.stop_reason
    assert (b.mode, b.stop_transition) == (a.mode, a.stop_transition)
    assert b.steps.shape[1] == a.steps.shape[1]
    # Number of events, and which: time, modes, states before and after. A crossing that is nearly
    # tangential magnifies round-off.
    near = 1e-9 if case == "two crossings in a step" else 1e-11
    np.testing.assert_allclose(b.events, a.events, rtol=near, atol=near)
    if a.stop_reason is not StopReason.STEP_LIMIT:
        # At a blow-up the last step is where the states no longer fit.
        assert b.time == pytest.approx(a.time, rel=1e-6 if case == "blow-up" else 1e-11)
    if case != "blow-up" and a.stop_reason is not StopReason.STEP_LIMIT:
        np.testing.assert_allclose(b.state, a.state, rtol=1e-10, atol=1e-10)


def test_dense_steps_follow_the_motion():
    system = automaton("oscillator", (Mode("free", {X: V, V: -X}, (), OUT),))
    o = RunOptions(10.0, 1e-11, np.full(2, 1e-11))
    run = ErkEngine(system).run(np.array([1.0, 0.0]), np.empty(0), o)
    u, worst = np.linspace(0, 1, 11)[:, None], 0.0
    np.testing.assert_allclose(run.steps[:-1, 0] + run.steps[:-1, 1], run.steps[1:, 0], rtol=1e-14)
    for row in run.steps:
        r = row[3:-1].reshape(8, 2)
        value = np.zeros((11, 2))
        for k in range(7, 0, -1):
            value = (value + r[k]) * (u if k % 2 else 1 - u)
        t = row[0] + u[:, 0] * row[1]
        exact = np.column_stack([np.cos(t), -np.sin(t)])
        worst = max(worst, float(np.max(np.abs(r[0] + value - exact))))
    assert worst < 1e-10


def test_records_are_as_asked():
    engine, start, p = ErkEngine(ball()), np.array([1.0, 0.0]), np.array([0.5, 9.81])
    runs = [
        engine.run(start, p, RunOptions(0.8, 1e-10, np.full(2, 1e-10), record=record))
        for record in ("end", "events", "dense")
    ]
    assert [len(r.events) for r in runs] == [0, 1, 1]
    assert [len(r.steps) > 0 for r in runs] == [False, False, True]
    for r in runs:
        np.testing.assert_array_equal(r.state, runs[0].state)
        assert set(r.counters) == {
            "accepted_steps",
            "rejected_steps",
            "field_evaluations",
            "guard_evaluations",
            "dense_outputs",
            "events",
        }


def test_states_left_out_of_the_control_are_integrated():
    system = automaton("drift", (Mode("one", {X: V, V: sp.cos(X)}, (), OUT),))
    for atol in ([1e-10, math.inf], [0.0, 1e-10], [1e-10, 0.0]):
        o = RunOptions(0.5, 1e-10, np.array(atol))
        a, b = (e(system).run(np.ones(2), np.empty(0), o) for e in (CompiledEngine, ErkEngine))
        np.testing.assert_allclose(b.state, a.state, rtol=1e-8)


def test_threads_may_share_an_engine():
    engine, runs = ErkEngine(ball()), {}
    o = RunOptions(1.0, 1e-10, np.full(2, 1e-10))

    def run(height):
        runs[height] = engine.run(np.array([height, 0.0]), np.array([0.5, 9.81]), o).events[0, 0]

    threads = [threading.Thread(target=run, args=(h,)) for h in (1.0, 2.0, 3.0, 4.0)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    for height, time in runs.items():
        assert time == pytest.approx(math.sqrt(2 * height / 9.81), rel=1e-12)
    assert len(runs) == 4


def test_nothing_is_written_to_stderr(capfd):
    ErkEngine(ball()).run(
        np.array([1.0, 0.0]), np.array([0.5, 9.81]), RunOptions(1.0, 1e-9, np.full(2, 1e-9))
    )
    assert capfd.readouterr() == ("", "")


# ---- which engine ----


@pytest.fixture
def no_compiler(monkeypatch):
    monkeypatch.setenv("CC", "/nonexistent")


def test_auto_without_a_compiler_warns_and_works(no_compiler):
    s = Simulator(rod(), paper_law(reload="virgin"), engine="auto")
    with pytest.warns(PainleveWarning, match=r"no working C compiler.*'erk'"):
        run = s.run(TABLE_3, t_end=1e-3, parameters=HARD, until="separation")
    assert run.engine == "erk"
    assert run.final_time == pytest.approx(4.281634640972e-4, rel=1e-10)


def test_compiled_without_a_compiler_is_refused(no_compiler):
    with pytest.raises(CompilerMissing, match=r"/nonexistent.*Fix: install"):
        make_engine(ball(), "compiled")


def test_erk_needs_no_compiler(no_compiler):
    assert make_engine(ball(), "erk").name == "erk"


def test_several_contacts_without_a_compiler_end_in_one_sentence(no_compiler):
    feet = Simulator(model("block-two-feet"), law("rigid"))
    for engine in ("auto", "erk"):
        with pytest.raises(
            InputError, match=r"several contacts.*painleve-sym\[compiler\]"
        ) as error:
            replaced = Simulator(feet.mechanism, feet.law, engine)
            replaced.run({"y_A": 0.01}, t_end=0.1)
        assert str(error.value).count("Fix:") == 1


def test_auto_with_a_compiler_is_taylor():
    assert make_engine(ball()).name == "taylor"


def test_unknown_engine_is_refused():
    with pytest.raises(InputError, match=r"unknown engine 'erq'\. Did you mean 'erk'"):
        make_engine(ball(), "erq")
