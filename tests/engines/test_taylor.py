"""The Taylor engine: recurrences, events on series, branch points, agreement with the others."""

from __future__ import annotations

import ctypes
import json
import math
from pathlib import Path

import casadi as ca
import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from painleve_sym.automata.automaton import Choice, HybridAutomaton, Mode, Transition
from painleve_sym.codegen.compile import load
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.factory import make_engine
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.engines.source import every_variant
from painleve_sym.engines.taylor.emit import SeriesCode
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.engines.taylor.simplify import simplify
from painleve_sym.engines.taylor.source import arithmetic
from painleve_sym.engines.taylor.source import tape as tape_of
from painleve_sym.engines.taylor.tape import build
from painleve_sym.errors import NoRecurrence, PainleveWarning, StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.laws.compliance import ramp
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.motion.simulator import Simulator
from tests.engines.test_erk import CASES
from tests.mechanics.catalogue import SOFTENED, derived
from tests.support.paper_law import paper_law

X, V, N = (sp.Symbol(n, real=True) for n in ("x", "v", "n"))
Y = sp.Symbol("y", real=True)


def automaton(states, modes, parameters=()):
    return HybridAutomaton("test", states, (), parameters, {}, modes, (Choice(modes[0].name),))


def options(t_end, nx, rtol=1e-15, **more):
    return RunOptions(t_end, rtol, np.full(nx, rtol), **more)


def coefficients(rows):
    """Return the monomial coefficients in u of a step's rows, shape (orders, nx)."""
    u, total = np.polynomial.Polynomial([0, 1]), []
    for column in rows.T:
        value = np.polynomial.Polynomial([0.0])
        for k in range(len(column) - 1, 0, -1):
            value = (value + column[k]) * (u if k % 2 else 1 - u)
        c = (value + column[0]).coef
        total.append(np.pad(c, (0, len(column) - len(c))))
    return np.array(total).T


# ---- recurrences ----

FUNCTIONS = {
    "product": (X * sp.sin(X), lambda x, n: x * mpmath.sin(x)),
    "square": (sp.cos(X) ** 2, lambda x, n: mpmath.cos(x) ** 2),
    "quotient": (sp.sin(X) / (2 + sp.cos(X)), lambda x, n: mpmath.sin(x) / (2 + mpmath.cos(x))),
    "reciprocal": (1 / (3 + sp.sin(X)), lambda x, n: 1 / (3 + mpmath.sin(x))),
    "real power": (X**N, lambda x, n: x**n),
    "negative power": (X ** sp.Rational(-3, 2), lambda x, n: x ** mpmath.mpf(-1.5)),
    "power of series": ((1 + X**2) ** sp.sin(X), lambda x, n: (1 + x**2) ** mpmath.sin(x)),
    "sqrt": (sp.sqrt(1 + X**2), lambda x, n: mpmath.sqrt(1 + x**2)),
    "exp": (sp.exp(-(X**2)), lambda x, n: mpmath.exp(-(x**2))),
    "log": (sp.log(2 + sp.sin(X)), lambda x, n: mpmath.log(2 + mpmath.sin(x))),
    "tan": (sp.tan(X / 4), lambda x, n: mpmath.tan(x / 4)),
    "sinh": (sp.sinh(X), lambda x, n: mpmath.sinh(x)),
    "cosh": (sp.cosh(X), lambda x, n: mpmath.cosh(x)),
    "tanh": (sp.tanh(X), lambda x, n: mpmath.tanh(x)),
    "atan": (sp.atan(X), lambda x, n: mpmath.atan(x)),
    "asin": (sp.asin(X / 8), lambda x, n: mpmath.asin(x / 8)),
    "acos": (sp.acos(X / 8), lambda x, n: mpmath.acos(x / 8)),
    "atan2": (
        sp.atan2(sp.sin(X), X + 2),
        lambda x, n: mpmath.atan2(mpmath.sin(x), x + 2),
    ),
}


@pytest.fixture(scope="module")
def integrals():
    """One state per function g, with the rate g(x) and x = x₀ + t."""
    states = tuple(sp.Symbol(f"y_{i}", real=True) for i in range(len(FUNCTIONS)))
    rates = dict(zip(states, (g for g, _ in FUNCTIONS.values()), strict=True))
    mode = Mode("all", {X: sp.Integer(1), **rates}, (), {"x": X})
    return TaylorEngine(automaton((X, *states), (mode,), (N,)))


@settings(max_examples=8)
@given(x0=st.floats(0.5, 3.0), n=st.floats(0.3, 4.0))
@example(x0=1.0, n=1.764)
@example(x0=3.0, n=0.3)
@example(x0=0.5, n=4.0)
def test_coefficients_are_those_of_mpmath(integrals, x0, n):
    nx = len(FUNCTIONS) + 1
    start = np.array([x0, *np.zeros(nx - 1)])
    run = integrals.run(start, np.array([n]), options(10.0, nx, max_steps=1))
    h, series = run.steps[0, 1], coefficients(run.steps[0, 3:-1].reshape(-1, nx))
    with mpmath.workdps(20):
        for i, (name, (_, g)) in enumerate(FUNCTIONS.items()):
            expected = mpmath.taylor(lambda x, g=g: g(x, mpmath.mpf(n)), mpmath.mpf(x0), 12)
            for k in range(1, 12):
                want = float(expected[k - 1] / k) * h**k
                # The rows are sums of coefficients: that is what round-off is relative to.
                size = np.max(np.abs(series[:, i + 1]))
                assert series[k, i + 1] == pytest.approx(want, rel=1e-10, abs=1e-14 * size), (
                    name,
                    k,
                )


_ANGLES = """
#include <math.h>
#include <string.h>
%s
__attribute__((visibility("default"))) void angles(long n, const double *x, double *one,
                                                   double *lanes) {
  for (long i = 0; i < n; i++) {
    const ps_pair both = ps_sin_cos(x[i]);
    memcpy(one + 2 * i, &both, sizeof both);
  }
#if PS_LANES > 1
  for (long i = 0; i < n; i += PS_LANES) {
    ps_lanes some;
    memcpy(&some, x + i, sizeof some);
    const ps_pair_lanes both = ps_sin_cos_lanes(some);
    PS_EACH_LANE((lanes[2 * (i + l)] = both.sin[l], lanes[2 * (i + l) + 1] = both.cos[l]))
  }
#else
  memcpy(lanes, one, (size_t)n * 2 * sizeof(double));
#endif
}
"""


def sines_and_cosines(angles):
    """Return those of single motions and of lanes, each of shape (n, 2)."""
    x, results = np.ascontiguousarray(angles), np.empty((2, len(angles), 2))
    load(_ANGLES % arithmetic()).angles(
        ctypes.c_long(len(x)), *(ctypes.c_void_p(a.ctypes.data) for a in (x, *results))
    )
    return results


def test_sine_and_cosine_are_exact_within_a_unit_of_the_last_place():
    draw = np.random.default_rng(0)
    sizes = 10 ** draw.uniform(-9, 6, 1600)
    right = np.pi / 2 * draw.integers(-60000, 60000, 400) + 1e-9 * draw.normal(size=400)
    x = np.concatenate([sizes * draw.choice([-1, 1], 1600), right])
    one, lanes = sines_and_cosines(x)
    with mpmath.workdps(40):
        exact = [(mpmath.sin(mpmath.mpf(a)), mpmath.cos(mpmath.mpf(a))) for a in x.tolist()]
        errors = [
            [abs(v - e) for v, e in zip(*row, strict=True)]
            for row in zip(one.tolist(), exact, strict=True)
        ]
    units = np.spacing(np.abs(np.array(exact, dtype=float)))
    assert (np.array(errors, dtype=float) < units).all()
    assert np.array_equal(one, lanes)


def test_sine_and_cosine_of_what_is_no_angle_are_those_of_the_c_library():
    x = np.array([0.0, -0.0, np.inf, -np.inf, np.nan, 1e5 + 1, 1e22, -1e300])
    one, lanes = sines_and_cosines(x)
    with np.errstate(invalid="ignore"):
        expected = np.array([np.sin(x), np.cos(x)]).T
    assert np.allclose(one, expected, rtol=1e-15, atol=0, equal_nan=True)
    assert np.array_equal(one, lanes, equal_nan=True)


BUMPS = {
    "gauss": (sp.exp(-((X / N) ** 2)), lambda x, w: math.exp(-((x / w) ** 2))),
    "tanh": (sp.tanh(X / N), lambda x, w: math.tanh(x / w)),
    "sech": (1 - sp.tanh(X / N) ** 2, lambda x, w: 1 - math.tanh(x / w) ** 2),
    "sine": (sp.exp(-((sp.sin(X) / N) ** 2)), lambda x, w: math.exp(-((math.sin(x) / w) ** 2))),
}
"""Forces that are flat beyond the width w, as formulas and as functions of x and w."""


@pytest.fixture(scope="module")
def bumps():
    """Return the engines of ẍ = −x/4 − bump(x) by kind of bump."""
    engines = {}
    for kind, (force, _) in BUMPS.items():
        mode = Mode("run", {X: V, V: -X / 4 - force}, (), {"x": X})
        engines[kind] = TaylorEngine(automaton((X, V), (mode,), (N,)))
    return engines


def through_bumps(kind, width, start, t_end):
    """Return the motion by SciPy, which is led through the bump at x = 0 by short steps."""
    force = BUMPS[kind][1]

    t, y = 0.0, np.array([start, 0.0])
    while t < t_end:
        far, side = abs(y[0]) > 20 * width, math.copysign(1, y[0])

        def edge(t, y, far=far, side=side):
            return (side * y[0] if far else abs(y[0])) - 20 * width

        edge.terminal = True
        solved = solve_ivp(
            lambda t, y: (y[1], -y[0] / 4 - force(y[0], width)),
            (t, t_end),
            y,
            "DOP853",
            rtol=1e-13,
            atol=1e-14,
            events=edge,
            max_step=0.1 if far else 0.5 * width / max(abs(y[1]), width),
        )
        t, y = solved.t[-1], solved.y[:, -1]
        if solved.status == 1:
            # A little beyond the edge, into the bump or out of it.
            step = 1e-9 * width / abs(y[1])
            t, y = t + step, y + step * np.array([y[1], -y[0] / 4 - force(y[0], width)])
    return y


@pytest.mark.parametrize("kind", BUMPS)
@settings(max_examples=5)
@given(
    exponent=st.floats(-5, 0),
    start=st.floats(0.5, 1.5) | st.floats(-1.5, -0.5),
    t_end=st.floats(2, 6),
)
@example(exponent=-4.0, start=1.0, t_end=6.0)
def test_narrow_function_is_not_passed_over(bumps, kind, exponent, start, t_end):
    """Far from a bump no term of its series announces it."""
    width = 10**exponent
    run = bumps[kind].run(np.array([start, 0.0]), np.array([width]), options(t_end, 2, rtol=1e-12))
    assert run.stop_reason is StopReason.T_END
    expected = through_bumps(kind, width, start, t_end)
    np.testing.assert_allclose(run.state, expected, atol=1e-9)


def test_flat_function_costs_few_steps(bumps):
    """Through a Gauss curve of 1/1000000 of the way, there and back."""
    run = bumps["gauss"].run(np.array([1.0, 0.0]), np.array([1e-6]), options(12.0, 2, rtol=1e-12))
    assert run.counters["accepted_steps"] < 150


def test_dense_output_is_as_exact_as_the_steps():
    engine = TaylorEngine(automaton((X, V), (Mode("free", {X: V, V: -X}, (), {"x": X}),)))
    run = engine.run(np.array([1.0, 0.0]), np.empty(0), options(20.0, 2, rtol=1e-13))
    worst = 0.0
    for row in run.steps:
        c = coefficients(row[3:-1].reshape(-1, 2))
        for u in (0.1, 0.35, 0.5, 0.8, 1.0):
            worst = max(worst, abs(np.polyval(c[::-1, 0], u) - math.cos(row[0] + u * row[1])))
    assert worst < 1e-12
    assert len(run.steps) < 40


# ---- branch points of real powers ----


@pytest.fixture(scope="module")
def spring():
    """A mass on a spring K xⁿ that is absent for x < 0; nothing happens at x = 0."""
    mode = Mode("fall", {X: V, V: 1 - 100 * ramp(X) ** N}, (), {"x": X})
    return TaylorEngine(automaton((X, V), (mode,), (N,)))


@pytest.mark.parametrize("n", [0.5, 1.0, 1.5, 1.764, 2.5, 3.0])
@pytest.mark.parametrize("start", [(0.0, 0.0), (0.0, 1.0), (-0.1, 0.0), (1e-17, 0.3), (0.02, -1.0)])
def test_motion_starts_at_and_crosses_a_branch_point(spring, n, start):
    run = spring.run(np.array(start), np.array([n]), options(1.0, 2, rtol=1e-12))
    assert run.stop_reason is StopReason.T_END
    x, v = run.steps[:, 3], run.steps[:, 4]
    energy = 0.5 * v**2 - x + 100 * np.maximum(x, 0) ** (n + 1) / (n + 1)
    assert np.max(np.abs(energy - energy[0])) < 2e-11
    assert np.max(x) > 1e-4
    assert len(run.steps) < 1200


@pytest.mark.parametrize("n", [0.5, 1.0, 1.764, 3.0])
@pytest.mark.parametrize("start", [(0.0, 0.05), (0.0, 1e-4), (-0.1, 0.451), (-1e-3, 0.05)])
def test_force_of_a_dip_shorter_than_a_step_is_not_left_out(n, start):
    # Without the force the motion is a parabola: one step, at whose end the spring is free again.
    mode = Mode("hop", {X: V, V: -1 - 1e4 * ramp(X) ** N}, (), {"x": X})
    engine = TaylorEngine(automaton((X, V), (mode,), (N,)))
    run = engine.run(np.array(start), np.array([n]), options(2.0, 2, rtol=1e-12))
    x, v = (np.append(run.steps[:, i], run.state[i - 3]) for i in (3, 4))
    energy = 0.5 * v**2 + x + 1e4 * np.maximum(x, 0) ** (n + 1) / (n + 1)
    assert np.max(np.abs(energy - energy[0])) < 1e-11
    assert np.max(x) > 0


# ---- events ----


@settings(max_examples=40)
@given(phase=st.floats(0, 6.28), width=st.floats(1e-4, 3.0))
def test_crossings_of_an_oscillation_are_all_found(crossings, phase, width):
    # cos is below the level for 2·width around π, far shorter than a step.
    level = -math.cos(width)
    if abs(math.cos(phase) - level) < 1e-9:
        return
    first = math.pi - width - phase
    times = [t for k in range(6) if 0 < (t := first + 2 * math.pi * (k - 1)) < 20]
    # Where the crossing is nearly tangential, round-off of x over the speed is what time can be.
    np.testing.assert_allclose(crossings(phase, level), times, atol=1e-12 / math.sin(width))


def test_crossing_located_to_round_off_is_not_met_again(crossings):
    # Slow crossings: one last place of x is a time in which the guard's sign is undecided.
    draw = np.random.default_rng(1)
    for phase, width in zip(
        draw.uniform(0, 6.28, 4000), 10 ** draw.uniform(-4, -3, 4000), strict=True
    ):
        level = -math.cos(width)
        if abs(math.cos(phase) - level) > 1e-9:
            times = crossings(phase, level)
            assert np.all(np.diff(times) > 1), (phase, width, times)


@pytest.fixture(scope="module")
def crossings():
    """Return a function from phase and level to the times at which cos falls through the level."""
    down = Transition("down", "down", X - N, (Choice("below"),))
    up = Transition("up", "up", N - X, (Choice("above"),))
    modes = tuple(
        Mode(name, {X: V, V: -X}, (transition,), {"x": X})
        for name, transition in (("above", down), ("below", up))
    )
    starts = (Choice("above", X > N), Choice("below"))
    engine = TaylorEngine(HybridAutomaton("swing", (X, V), (), (N,), {}, modes, starts))

    def falls(phase, level):
        start = np.array([math.cos(phase), -math.sin(phase)])
        run = engine.run(start, np.array([level]), options(20.0, 2, rtol=1e-14))
        return run.events[run.events[:, 1] == 0, 0]

    return falls


# ---- what has no recurrence ----


def test_operation_without_recurrence_is_named_and_runge_kutta_used():
    mode = Mode("bent", {X: sp.Abs(V), V: sp.Integer(-1)}, (), {"x": X})
    bent = automaton((X, V), (mode,))
    with pytest.raises(NoRecurrence, match=r"mode 'bent' uses fabs of a state"):
        TaylorEngine(bent)
    with pytest.warns(PainleveWarning, match="Engine 'compiled'"):
        engine = make_engine(bent, "taylor")
    assert isinstance(engine, CompiledEngine)
    assert engine.name == "compiled"


def test_auto_is_runge_kutta_where_there_is_no_series():
    mode = Mode("bent", {X: sp.Abs(V), V: sp.Integer(-1)}, (), {"x": X})
    assert make_engine(automaton((X, V), (mode,)), "auto").name == "compiled"


def test_any_operation_of_a_resting_state_is_a_parameter():
    mode = Mode("rest", {X: sp.Abs(V), V: sp.Integer(0)}, (), {"x": X})
    engine = TaylorEngine(automaton((X, V), (mode,)))
    run = engine.run(np.array([0.0, -3.0]), np.empty(0), options(2.0, 2))
    assert run.state[0] == pytest.approx(6.0, rel=1e-15)


@pytest.mark.parametrize(("base", "rate"), [(4.0, 8.0), (-4.0, 0.0)])
def test_power_of_a_gap_that_rests_is_a_parameter(base, rate):
    mode = Mode("rest", {X: X * ramp(V) ** sp.Rational(3, 2), V: sp.Integer(0)}, (), {"x": X})
    engine = TaylorEngine(automaton((X, V), (mode,)))
    run = engine.run(np.array([1.0, base]), np.empty(0), options(0.5, 2))
    assert run.state[0] == pytest.approx(math.exp(0.5 * rate), rel=1e-12)


# ---- the tape ----


def random_values(function, rng):
    return [ca.DM(rng.uniform(0.2, 1.5, function.size_in(i))) for i in range(3)]


def order_zero(tape, functions):
    """Return rates and guards of a tape as a casadi function: its meaning, not its recurrences."""
    values = []
    for node in tape.nodes:
        a = [values[i] for i in node.args]
        inner = _combined(tape, node.inner, values) if node.inner is not None else None
        values.append(
            {
                "state": lambda n=node: functions.x[n.state_index],
                "linear": lambda i=inner: i,
                "ramp": lambda i=inner: ca.fmax(i, 1e-60),
                "mul": lambda a=a: a[0] * a[1],
                "sq": lambda a=a: a[0] ** 2,
                "div": lambda a=a: a[0] / a[1],
                "inv": lambda a=a: 1 / a[0],
                "pow": lambda a=a, n=node: a[0] ** tape.scalars.expression(n.scalar),
                "sin": lambda a=a: ca.sin(a[0]),
                "cos": lambda a=a: ca.cos(a[0]),
                "sqrt": lambda a=a: ca.sqrt(a[0]),
            }[node.op]()
        )
    results = [_combined(tape, c, values) for c in (*tape.rates, *tape.guards)]
    return ca.Function("f", [functions.x, functions.z, functions.c], [ca.vertcat(*results)])


def _combined(tape, a, values):
    total = tape.scalars.expression(a.constant)
    for n, c in a.terms:
        total = total + tape.scalars.expression(c) * values[n]
    return total


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(n, marks=() if n in ("rod", "strut", "rod-inertia") else pytest.mark.slow)
        for n in SOFTENED
    ],
)
def test_simplified_tape_equals_field_and_guards(name):
    contact = Simulator(derived(name), law("bilinear-hertz")).contact
    functions, rng = AutomatonFunctions(contact.automaton), np.random.default_rng(5)
    x, z, c = functions.x, functions.z, functions.c
    for mode, short in zip(functions.modes, tapes(functions), strict=True):
        whole = ca.vertcat(mode.field(x, z, c), mode.guards(x, z, c)[0])
        plain = build(whole, x, z, c, x.numel())
        assert short.products == simplify(plain).products <= plain.products
        point = random_values(mode.field, rng)
        want = np.array(ca.Function("f", [x, z, c], [whole])(*point)).ravel()
        row = np.array(order_zero(short, functions)(*point)).ravel()
        np.testing.assert_allclose(row, want, rtol=1e-11, atol=1e-11 * np.max(np.abs(want)))


def tapes(functions):
    """Return the tape of each mode, of automata whose modes have no variants."""
    return [tape_of(functions, variant) for variant in every_variant(functions, ())]


@pytest.mark.parametrize(
    ("rates", "products"),
    [
        # b/d, then three products with it, and a·c.
        (lambda a, b, c, d: [a * b / d, b * c / d, a * c * b / d], 5),
        # (a + c)/d is a part of the second sum and, doubled, the last.
        (lambda a, b, c, d: [b * (a / d + c / d), d * (a / d + c / d + b), 2 * (a / d + c / d)], 3),
    ],
)
def test_sums_and_ratios_are_shared(rates, products):
    x, none = ca.SX.sym("x", 4), ca.SX(0, 1)
    field = ca.vertcat(*rates(*ca.vertsplit(x)), x[0])
    tape = build(field, x, none, none, 4)
    assert simplify(tape).products == products < tape.products


BASELINE = Path(__file__).with_name("taylor_operations.json")
ORDER = 15


def operations():
    """Return additions and multiplications of a series, by automaton and mode."""
    counts = {}
    for name in SOFTENED:
        for title, a in (
            ("hertz", Simulator(derived(name), law("hertz")).automaton),
            ("bilinear-hertz", Simulator(derived(name), law("bilinear-hertz")).automaton),
            ("rigid", Simulator(derived(name), RigidLaw()).automaton),
        ):
            codes = [SeriesCode(t, "series") for t in tapes(AutomatonFunctions(a))]
            counts[f"{name}, {title}"] = {
                mode.name: code.operations(ORDER) for mode, code in zip(a.modes, codes, strict=True)
            }
    return counts


@pytest.mark.slow
def test_operations_of_generated_series_have_not_grown():
    baseline, now = json.loads(BASELINE.read_text("utf-8")), operations()
    assert now.keys() == baseline.keys(), (
        "write the baseline anew: python -m tests.engines.test_taylor"
    )
    grown = {
        (name, mode): (baseline[name].get(mode, 0), count)
        for name, modes in now.items()
        for mode, count in modes.items()
        if count > baseline[name].get(mode, 0)
    }
    assert not grown, f"{grown}: (before, now). If it must be: python -m tests.engines.test_taylor"


# ---- agreement ----


def rod_run(engine, case):
    name, reload, state, more = CASES[case]
    chosen = paper_law(reload=reload) if reload else law(name)
    return Simulator(rod(), chosen, engine).run(state, **more)


def assert_same(a, b, rtol=3e-9):
    """Same events and states, relative to the largest of each state."""
    assert b.stop_reason is a.stop_reason
    assert [(e.kind, e.mode_before, e.mode_after) for e in a.events] == [
        (e.kind, e.mode_before, e.mode_after) for e in b.events
    ]
    seen = np.vstack([a.step_rows[:, 0], [[*e.state.values()] for e in a.events]])
    largest = dict(zip(a.state_names, np.max(np.abs(seen), axis=0), strict=True))
    # Where a force is 0 a state that only it moves is round-off, or the floor of its power.
    least = 1e-9 * max(largest.values())
    for e, f in zip(a.events, b.events, strict=True):
        assert f.time == pytest.approx(e.time, rel=rtol)
        for n, size in largest.items():
            assert f.state[n] == pytest.approx(e.state[n], abs=rtol * max(size, least)), n


@pytest.mark.parametrize("case", CASES)
def test_taylor_agrees_with_runge_kutta_on_the_rod(case):
    a, b = rod_run("compiled", case), rod_run("taylor", case)
    assert b.engine == "taylor"
    assert_same(a, b)
    assert b.energy_residual < 1e-11
    assert b.counters["accepted_steps"] < a.counters["accepted_steps"]
    times = a.sample(500)[:-1]
    # The dense output of the Runge–Kutta steps, of order 7, is the less exact one.
    # Below 1e-30 J nothing has been dissipated.
    largest = np.maximum(np.max(np.abs(a.step_rows[:, 0]), axis=0), 1e-30)
    assert np.max(np.abs(a(times) - b(times)) / largest) < 1e-7


def test_separation_of_table_3_is_that_of_the_80_bit_solution():
    state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    run = Simulator(rod(), paper_law(reload="virgin"), "taylor").run(
        state, t_end=1e-3, parameters={"E": 20.9e14}, until="separation", rtol=1e-13
    )
    assert run.final_time == pytest.approx(0.0004281634640972055, rel=2e-13)
    assert run.final["y_A_dot"] == pytest.approx(0.06561146794473227, rel=2e-12)
    assert run.final["theta_dot"] == pytest.approx(1.6029856063339739, rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(SOFTENED) - {"strut"}))
@pytest.mark.parametrize("law_name", ["hertz", "bilinear-hertz"])
def test_taylor_agrees_with_runge_kutta_on_every_mechanism(name, law_name):
    m = derived(name)
    a, b = (Simulator(m, law(law_name), e).run(m.start, t_end=0.02) for e in ("compiled", "taylor"))
    assert_same(a, b, rtol=1e-7)
    assert b.energy_residual < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("name", SOFTENED)
def test_taylor_agrees_with_runge_kutta_on_rigid_motion(name):
    m = derived(name)
    a, b = (Simulator(m, RigidLaw(), e).run(m.start, t_end=0.1) for e in ("compiled", "taylor"))
    assert_same(a, b, rtol=1e-7)


if __name__ == "__main__":
    BASELINE.write_text(json.dumps(operations(), indent=1) + "\n", "utf-8")
