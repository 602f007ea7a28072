"""Derivatives through events on small automata: closed forms, 40 digits, CasADi's own events."""

from __future__ import annotations

import contextlib
import io
import math

import casadi as ca
import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from painleve_sym.automata.automaton import Choice, HybridAutomaton, Mode, Transition
from painleve_sym.codegen.variational import VariationalFunctions
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.erk import ErkEngine
from painleve_sym.engines.protocol import RunOptions
from painleve_sym.engines.taylor.runner import TaylorEngine

X, V, TOP = (sp.Symbol(n, real=True) for n in ("x", "v", "top"))
E, G, L, K = (sp.Symbol(n, real=True) for n in ("e", "g", "l", "k"))
COMPILED = [CompiledEngine, TaylorEngine]
ENGINES = [*COMPILED, ErkEngine]


def automaton(name, modes, parameters, memory=(), definitions=None, states=(X, V)):
    start = (Choice(modes[0].name),)
    return HybridAutomaton(name, states, memory, parameters, definitions or {}, modes, start)


def ball():
    land = Transition("land", "impact", X, (Choice("air"),), {V: -E * V, X: sp.Integer(0)})
    return automaton("ball", (Mode("air", {X: V, V: -G}, (land,), {"x": X}),), (E, G))


def pendulum():
    """A pendulum against a wall at x = 0, of frequency k² = g/l, with restitution e."""
    hit = Transition("hit", "impact", X, (Choice("free"),), {V: -E * V})
    mode = Mode("free", {X: V, V: -K * sp.sin(X + sp.Rational(1, 2))}, (hit,), {"x": X, "w": V * K})
    return automaton("pendulum", (mode,), (E, G, L), definitions={K: G / L})


def remembering():
    """A toss that remembers its height at the top, and stops where it has fallen by e of it."""
    top = Transition("top", "top", V, (Choice("down"),), {TOP: X})
    stop = Transition("stop", "stop", X - (1 - E) * TOP, (Choice("up"),), {V: TOP, X: X + TOP})
    up = Mode("up", {X: V, V: -G}, (top,), {"x": X})
    down = Mode("down", {X: V, V: -G}, (stop,), {"x": X})
    return automaton("toss", (up, down), (E, G), memory=(TOP,))


def differentiated(make, engine, states=(0, 1), parameters=(0, 1)):
    """Return engine and functions for directions: start values, then parameters, by index."""
    a = make()
    n = len(states)
    start = np.zeros((len(a.states), n + len(parameters)), dtype=bool)
    for k, i in enumerate(states):
        start[i, k] = True
    functions = VariationalFunctions(a, [*[None] * n, *parameters], start)
    return engine(a, functions), functions, start.astype(float)


def go(engine, functions, start, x, p, t_end, rtol=1e-12, **more):
    atol = np.full(functions.x.numel(), rtol)
    return engine.run(
        functions.packed(np.array(x), start), np.array(p), RunOptions(t_end, rtol, atol, **more)
    )


def fixed_time(engine, functions, run, p, no):
    """Derivatives of the states at the end, its time held fixed."""
    c = engine.constants(np.array(p))
    values = engine.outputs([run.mode], run.state[None], run.memory[None], c)[0]
    nx, k = functions.state_pattern.shape
    return values[no : no + nx * k].reshape(k, nx).T


@pytest.mark.parametrize("engine", ENGINES)
def test_ball_after_two_bounces_is_the_closed_form(engine):
    h, v, e, g, t_end = 1.0, 0.3, 0.8, 9.81, 1.7
    built = differentiated(ball, engine)
    run = go(*built, [h, v], [e, g], t_end)
    assert len(run.events) == 2

    H, V0, T = sp.symbols("H V0 T")
    speed = sp.sqrt(V0**2 + 2 * G * H)
    first = (V0 + speed) / G
    second = first + 2 * E * speed / G
    since = T - second
    height, rate = E**2 * speed * since - G * since**2 / 2, E**2 * speed - G * since
    at = {H: h, V0: v, E: e, G: g, T: t_end}
    wrt = (H, V0, E, G)
    exact = np.array([[float(sp.diff(f, w).subs(at)) for w in wrt] for f in (height, rate)])
    tolerance = 1e-9 if engine is ErkEngine else 1e-11
    np.testing.assert_allclose(
        fixed_time(built[0], built[1], run, [e, g], 1), exact, rtol=tolerance, atol=tolerance
    )
    times = np.array([[float(sp.diff(f, w).subs(at)) for w in wrt] for f in (first, second)])
    place = built[1].event_entries["time"]
    memory = run.events[:, -built[1].z.numel() :]
    np.testing.assert_allclose(memory[:, place], times, rtol=tolerance, atol=tolerance)


@pytest.mark.parametrize("engine", COMPILED)
def test_update_is_the_saltation_matrix(engine):
    """S⁺ = (R_x + (f⁺ − R_x f⁻) g_x/(g_x f⁻)) S⁻ at a fixed time, by hand for the ball."""
    e, g = 0.6, 9.81
    engine, functions, start = differentiated(ball, engine, parameters=())
    run = go(engine, functions, start, [1.0, 0.0], [e, g], 10.0, until=("impact",))
    w = math.sqrt(2 * g)
    before = np.array([[1.0, run.time], [0.0, 1.0]])
    R, g_x = np.diag([0.0, -e]), np.array([[1.0, 0.0]])
    f_minus, f_plus = np.array([[-w], [-g]]), np.array([[e * w], [-g]])
    saltation = R + (f_plus - R @ f_minus) @ g_x / (g_x @ f_minus)[0, 0]
    derivatives = fixed_time(engine, functions, run, [e, g], 1)
    np.testing.assert_allclose(derivatives, saltation @ before, rtol=1e-12, atol=1e-13)


def forty_digits(x0, v0, e, g, l, t_end):
    """The pendulum at t_end after one hit, in 40-digit arithmetic (Taylor series)."""
    rate = lambda t, y: [y[1], -g / l * mp.sin(y[0] + mp.mpf(1) / 2)]  # noqa: E731
    down = mp.odefun(rate, 0, [x0, v0])
    hit = mp.findroot(lambda t: down(t)[0], mp.mpf("0.25"))
    up = mp.odefun(rate, hit, [mp.mpf(0), -e * down(hit)[1]])
    return [*up(t_end), hit]


@pytest.mark.slow
@pytest.mark.parametrize("engine", COMPILED)
def test_pendulum_is_the_forty_digit_reference(engine):
    values = [mp.mpf(s) for s in ("0.2", "-0.1", "0.7", "9.81", "1.3")]
    with mp.workdps(40):
        h, end, columns = mp.mpf("1e-19"), mp.mpf("0.45"), []
        base = forty_digits(*values, end)
        for k in range(5):
            moved = forty_digits(*values[:k], values[k] + h, *values[k + 1 :], end)
            columns.append([float((p - q) / h) for p, q in zip(moved, base, strict=True)])
    exact = np.array(columns).T
    built = differentiated(pendulum, engine, parameters=(0, 1, 2))
    x, p = [0.2, -0.1], [0.7, 9.81, 1.3]
    run = go(*built, x, p, 0.45)
    assert len(run.events) == 1
    derivatives = fixed_time(built[0], built[1], run, p, 2)
    np.testing.assert_allclose(derivatives, exact[:2], rtol=1e-11, atol=1e-12)
    time = run.memory[built[1].event_entries["time"]]
    np.testing.assert_allclose(time, exact[2], rtol=1e-11, atol=1e-12)


def test_pendulum_is_casadis_own_event_integrator():
    """Forward derivatives of CasADi's `erk` through its own event, which it does not control."""
    y, p = ca.SX.sym("y", 2), ca.SX.sym("p", 3)
    ode = ca.vertcat(y[1], -p[1] / p[2] * ca.sin(y[0] + 0.5))
    i, t, none = ca.SX.sym("i"), ca.SX.sym("t"), ca.SX(0, 1)
    after = ca.vertcat(y[0], -p[0] * y[1])
    jump = ca.Function(
        "jump", [i, t, y, none, p, none], [after, none], ca.event_in(), ca.event_out()
    )
    dae = {"x": y, "p": p, "ode": ode, "zero": ca.vertcat(y[0])}
    options = {"transition": jump, "reltol": 1e-13, "abstol": 1e-13, "event_tol": 1e-14}
    with contextlib.redirect_stderr(io.StringIO()):
        own = ca.integrator("own", "erk", dae, 0.0, 0.45, options)
        both = own.factory("both", ["x0", "p"], ["xf", "jac:xf:x0", "jac:xf:p"])
        final, by_x, by_p = (np.array(r) for r in both([0.2, -0.1], [0.7, 9.81, 1.3]))
    built = differentiated(pendulum, CompiledEngine, parameters=(0, 1, 2))
    run = go(*built, [0.2, -0.1], [0.7, 9.81, 1.3], 0.45)
    np.testing.assert_allclose(run.state[:2], final.ravel(), rtol=1e-9)
    derivatives = fixed_time(built[0], built[1], run, [0.7, 9.81, 1.3], 2)
    # Its derivatives follow the steps of the state: less exact than ours.
    np.testing.assert_allclose(derivatives, np.hstack([by_x, by_p]), rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("engine", ENGINES)
def test_memory_carries_derivatives(engine):
    built = differentiated(remembering, engine)
    v, e, g = 1.2, 0.5, 9.81

    run = go(*built, [0.1, v], [e, g], 0.265)
    assert [int(r[2]) for r in run.events] == [0, 0]

    def after(h, v, e, g, t=0.265):
        top = h + v**2 / (2 * g)
        since = t - v / g - math.sqrt(2 * e * top / g)
        return np.array([(2 - e) * top + top * since - g * since**2 / 2, top - g * since])

    at = [0.1, v, e, g]
    np.testing.assert_allclose(run.state[:2], after(*at), rtol=1e-10)
    exact = []
    for k in range(4):
        h = 1e-4
        moved = [after(*[a + s * h * (i == k) for i, a in enumerate(at)]) for s in (1, -1, 2, -2)]
        exact.append((8 * (moved[0] - moved[1]) - (moved[2] - moved[3])) / (12 * h))
    derivatives = fixed_time(built[0], built[1], run, [e, g], 1)
    np.testing.assert_allclose(derivatives, np.array(exact).T, rtol=1e-8, atol=1e-9)


def test_states_that_no_direction_moves_are_left_out():
    W, U = (sp.Symbol(n, real=True) for n in "wu")
    mode = Mode("free", {X: V, V: -X, W: V * X, U: -E * U}, (), {"x": X})
    a = automaton("work", (mode,), (E, G), states=(X, U, V, W))
    start = np.array([[True, False], [False, False], [False, False], [False, False]])
    functions = VariationalFunctions(a, [None, 1], start)
    # The second parameter moves nothing, and the start of x all states but u.
    expected = [[True, True], [False, False], [True, True], [True, True]]
    np.testing.assert_array_equal(functions.state_pattern, expected)
    assert functions.moved_states == [0, 2, 3]
    assert functions.x.numel() == 4 + 6


X2, Y2 = (sp.Symbol(n, real=True) for n in ("x2", "y2"))
P1, P2 = (sp.Symbol(n, positive=True) for n in ("p1", "p2"))


def every_operation():
    """Rates with every operation that has a series, and powers of a state and of a parameter."""
    rates = {
        X: sp.sin(P1 * Y2) / (2 + sp.cos(X)) + sp.sqrt(3 + X * V),
        V: sp.exp(-P2 * X) * sp.log(2 + Y2**2) - V**3,
        X2: sp.atan2(Y2, 1 + X**2) + sp.tanh(P1 * V) + sp.asin(X2 / 5),
        Y2: (2 + X) ** (P2 + sp.Rational(1, 3)) / 10 - 1 / (P1 + V**2) + sp.cosh(X2) / 4,
    }
    mode = Mode("only", rates, (), {"x": X})
    return automaton("operations", (mode,), (P1, P2), states=(X, V, X2, Y2))


@pytest.mark.parametrize(
    "count", [1, 11, *(pytest.param(n, marks=pytest.mark.slow) for n in (5, 6))]
)
def test_series_of_derivatives_are_variational_equations_of_scipy(count):
    """Vectors of directions that are full, not full, and several."""
    a = every_operation()
    names = (*a.states, *a.parameters)
    values = dict(zip(names, (0.3, -0.4, 0.2, 0.6, 0.7, 1.1), strict=True))
    rates = sp.Matrix([a.modes[0].field[s] for s in a.states])
    by = sp.lambdify(names, [rates, rates.jacobian(a.states), rates.jacobian(a.parameters)])
    at = [values[n] for n in names]
    rng = np.random.default_rng(1)
    chosen = [int(i) for i in rng.integers(0, 6, count)]
    start, of_parameters = np.zeros((4, count)), np.zeros((2, count))
    for k, i in enumerate(chosen):
        (start if i < 4 else of_parameters)[i % 4, k] = 1.0

    def extended(_, y):
        f, f_x, f_p = by(*y[:4], *at[4:])
        slopes = f_x @ y[4:].reshape(4, count) + f_p @ of_parameters
        return np.concatenate([f.ravel(), slopes.ravel()])

    exact = solve_ivp(
        extended, (0, 1.5), [*at[:4], *start.ravel()], method="DOP853", rtol=1e-13, atol=1e-13
    ).y[:, -1]
    functions = VariationalFunctions(a, [i - 4 if i >= 4 else None for i in chosen], start != 0)
    run = go(TaylorEngine(a, functions), functions, start, at[:4], at[4:], 1.5)
    state, jacobian = functions.unpacked(run.state)
    np.testing.assert_allclose(state, exact[:4], rtol=1e-11)
    expected = exact[4:].reshape(4, count)
    np.testing.assert_allclose(jacobian, expected, rtol=1e-9, atol=1e-10)
