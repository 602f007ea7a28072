"""Named mechanisms in SymPy, CasADi and compiled code: the same values and first derivatives."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
import sympy as sp

from painleve_sym.automata.derivation import ContactDerivation
from painleve_sym.codegen.bridge import Translator
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.errors import InputError, StopReason
from painleve_sym.laws.catalogue import law
from painleve_sym.motion.simulator import Simulator
from tests.mechanics.catalogue import NAMES, SOFTENED, derived, random_numbers
from tests.mechanics.forced import accelerations, directions, forced_automaton, forces

LONG = ("two-link-arm", "pr-robot", "block", "rod-bending", "cart-pendulum")
"""Whose compliant automata take many seconds to derive and compile."""
QUICK = ("rod", "strut", "painleve-klein", "block-two-feet")
BELTS = ("strut", "two-link-arm")


def _point(mechanism):
    """Return random values of everything q̈ depends on, and of a direction."""
    rng = np.random.default_rng(5)
    values = random_numbers(mechanism, rng)
    at = {s: values[s.name] for s in mechanism.system.symbols}
    at |= {f: float(rng.uniform(-2, 2)) for pair in forces(mechanism) for f in pair}
    return at | {d: float(rng.uniform(-1, 1)) for d in directions(mechanism)}


def _by_sympy(mechanism, at):
    """Return q̈ and its directional derivative to 30 digits."""
    states = (*mechanism.system.q, *mechanism.system.q_dot)
    exact = {s: sp.Rational(v) for s, v in at.items()}
    rows = accelerations(mechanism)
    values = [row.evalf(30, subs=exact) for row in rows]
    pairs = list(zip(states, directions(mechanism), strict=True))
    slopes = [
        sum(sp.diff(row, s).evalf(30, subs=exact) * exact[d] for s, d in pairs) for row in rows
    ]
    return np.array(values, dtype=float), np.array(slopes, dtype=float)


def _by_casadi(mechanism, at):
    states = [*mechanism.system.q, *mechanism.system.q_dot]
    x = ca.SX.sym("x", len(states))
    table = {s: ca.SX(v) for s, v in at.items()} | {s: x[i] for i, s in enumerate(states)}
    rows = Translator(table).vector(accelerations(mechanism))
    direction = ca.DM([at[d] for d in directions(mechanism)])
    function = ca.Function("f", [x], [rows, ca.jtimes(rows, x, direction)])
    values, slopes = function(ca.DM([at[s] for s in states]))
    return np.array(values).reshape(-1), np.array(slopes).reshape(-1)


def _by_compiled_code(mechanism, at):
    engine = CompiledEngine(forced_automaton(mechanism))
    automaton, named = engine.outline, {s.name: v for s, v in at.items()}
    x = np.array([named[n] for n in automaton.state_names])
    c = engine.constants(np.array([named[n] for n in automaton.parameter_names]))
    n = len(x) // 2
    rate, rows, slopes = np.empty(2 * n), np.empty(n), np.empty(n)
    z = np.zeros(1)

    def evaluate(mode):
        arrays = (x, z, c, rate, rows, slopes)
        engine._library.ps_evaluate(mode, *(a.ctypes.data for a in arrays))

    evaluate(1)
    computed = rows.copy(), slopes.copy()
    rows, slopes = np.empty(1), np.empty(1)
    evaluate(0)
    # The compiler contracts products and sums of two functions differently.
    np.testing.assert_allclose(rate[n:], computed[0], rtol=1e-13, atol=1e-13)
    return computed


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in NAMES]
)
def test_mechanism_values_and_slopes_are_the_same_in_every_form(name):
    mechanism = derived(name)
    at = _point(mechanism)
    expected = _by_sympy(mechanism, at)
    for computed in (_by_casadi(mechanism, at), _by_compiled_code(mechanism, at)):
        for ours, exact in zip(computed, expected, strict=True):
            size = max(1.0, float(np.max(np.abs(exact))))
            # A few hundred rounded operations, and no cancellation to speak of.
            assert np.max(np.abs(ours - exact)) < 1e-12 * size


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n in LONG else ()) for n in SOFTENED]
)
def test_mechanism_moves_softened_from_its_start_and_keeps_its_energy(name):
    mechanism = derived(name)
    simulator = Simulator(mechanism, law("hertz"))
    run = simulator.run(mechanism.start, t_end=4e-3)
    assert run.stop_reason is StopReason.T_END
    assert run.energy_residual < 1e-8
    assert (mechanism.contact.surface_speed != 0) == (name in BELTS)
    assert max(e.compression for e in run.events) > 0
    # The extra states follow the coordinates they are computed from.
    at = {s: run.final[s.name] for s in (*mechanism.system.q, *mechanism.system.q_dot)}
    at |= {p.symbol: run.parameters[p.name] for p in mechanism.system.parameters}
    contact = simulator.contact.builder
    pairs = [
        (contact.gap, mechanism.contact.gap),
        (contact.gap_rate, mechanism.contact.gap_rate),
        (contact.slip, mechanism.contact.slip_velocity),
    ]
    for state, form in pairs:
        assert abs(run.final[state.name] - float(form.subs(at))) < 1e-9


@pytest.mark.parametrize("name", BELTS)
def test_mechanism_on_a_belt_counts_the_work_of_the_belt(name):
    assert (
        ContactDerivation(derived(name), (law("hertz"),)).builder.states[-1].name
        == "force_dissipation"
    )


def test_mechanism_in_a_guide_is_refused_by_a_law_that_only_pushes():
    with pytest.raises(InputError, match="holds from both sides"):
        ContactDerivation(derived("painleve-klein"), (law("hertz"),))


def test_mechanism_with_a_parameter_of_the_law_is_refused():
    mechanism = derived("cart-pendulum")
    taken = {p.name for p in mechanism.system.parameters}
    for name in ("bilinear-hertz", "hertz", "hunt-crossley", "linear"):
        assert not taken & {p.name for p in law(name).parameters}
