"""Variants of a mode whose local modes are data: shorter, and equal but for rounding."""

import itertools
import math
from functools import cache

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.automata.variants import known_values
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.engines.entered import Entered
from painleve_sym.engines.taylor import source as series
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.errors import CompileError
from painleve_sym.motion.runs import simulate_batch
from painleve_sym.motion.simulator import Simulator
from tests.scenes import FEET, TABLE, simulator


@cache
def with_and_without(laws, engine):
    """Return a simulator, and the same one whose engine has no variants."""
    own = simulator(FEET, laws, engine)
    plain = Simulator(own.mechanism, own.law, engine)
    functions = AutomatonFunctions(plain.automaton, has_variants=False)
    vars(plain)["integrator"] = type(own.integrator)(plain.automaton, functions)
    return own, plain


CASES = [
    ("rigid", "taylor"),
    pytest.param("A=hertz,B=rigid", "compiled", marks=pytest.mark.slow),
    pytest.param("A=bilinear-hertz,B=linear/spring", "taylor", marks=pytest.mark.slow),
    pytest.param("linear/static", "compiled", marks=pytest.mark.slow),
]
# Feet that slide fast, and one that sticks while the other is high: a foot that lands beside one
# that sticks does so without slip, and rounding decides its direction.
SLIDING = st.tuples(
    st.fixed_dictionaries(
        {
            "y_A": st.sampled_from([0.0, 1e-3]),
            "theta": st.sampled_from([0.0, 0.02]),
            "x_A_dot": st.floats(0.5, 1.0) | st.floats(-1.0, -0.5),
            "y_A_dot": st.sampled_from([0.0, -0.2]),
        }
    ),
    st.floats(0.05, 0.3),
)
STICKING = st.tuples(
    st.fixed_dictionaries({"theta": st.floats(0.08, 0.2), "theta_dot": st.floats(0.0, 0.5)}),
    st.floats(0.9, 1.2),
)


@pytest.mark.parametrize(("laws", "engine"), CASES)
@settings(max_examples=20)
@given(start=SLIDING | STICKING)
def test_variants_change_runs_by_rounding_only(laws, engine, start):
    state, mu = start
    options = {"parameters": {"mu_A": mu, "mu_B": 0.8 * mu}, "t_end": 0.02, "rtol": 1e-11}
    a, b = (s.run(state, **options) for s in with_and_without(laws, engine))
    # Bounces of stiff feet multiply a difference: of many, the first are compared.
    first = list(zip(a.events, b.events, strict=False))[:30]
    assert [(e.kind, e.contact, e.mode_after) for e, _ in first] == [
        (o.kind, o.contact, o.mode_after) for _, o in first
    ]
    assert max((abs(e.time - o.time) for e, o in first), default=0) < 1e-9 * 0.02
    if len(a.events) <= 30:
        assert a.stop_reason is b.stop_reason
        assert len(a.events) == len(b.events)
        scale = np.abs(b.final_state).max()
        assert np.abs(a.final_state - b.final_state).max() < 1e-8 * scale


@pytest.mark.parametrize(
    ("mechanism", "laws"),
    [
        *((FEET, "rigid"), (FEET, "A=hertz,B=rigid"), (FEET, "linear/static")),
        pytest.param(TABLE, "rigid", marks=pytest.mark.slow),
    ],
)
def test_variants_have_the_fields_and_guards_of_their_mode(mechanism, laws):
    automaton = simulator(mechanism, laws).automaton
    functions, rng = AutomatonFunctions(automaton), np.random.default_rng(7)
    (i,) = (i for i, mode in enumerate(automaton.modes) if mode.field)
    mode, parts = functions.modes[i], automaton.parts
    for number, values in enumerate(itertools.product(*(part.variants for part in parts))):
        x, z = (rng.uniform(0.2, 1.0, of.numel()) for of in (functions.x, functions.z))
        known = {s: value for one in values for s, value in one.items()}
        # Which of two branches of the same force it is in: flags are 0 or 1.
        flags = {s: int(rng.integers(2)) for s in automaton.memory if s.name.startswith("in_")}
        for k, s in enumerate(automaton.memory):
            if s in flags or s in known:
                z[k] = float(known.get(s, flags.get(s)).xreplace(flags)) if s in known else flags[s]
        v = functions.variant(i, z, 100 + number)
        assert v.known == known_values(automaton, v.known) == known_values(automaton, z)
        at = x, z, functions.constants(rng.uniform(0.5, 1.5, len(automaton.parameters)))
        field, own = mode.field(*at), v.smooth.field(*at)
        # Six rows of three feet that stick are singular, at a state that fits none of them.
        sticking = sum(s.name.startswith("sticks") and value == 1 for s, value in known.items())
        near = 1e-6 if len(parts) == 3 and sticking > 1 else 1e-9
        assert float(ca.norm_inf(field - own)) < near * float(ca.norm_inf(field))
        g, slope = (np.array(values).ravel() for values in mode.guards(*at))
        own, own_slope = (np.array(values).ravel() for values in v.smooth.guards(*at))
        shown = list(v.transitions)
        assert np.allclose(g[shown], own, rtol=10 * near, atol=near * np.abs(g).max())
        near *= 10
        assert np.allclose(slope[shown], own_slope, rtol=10 * near, atol=near * np.abs(slope).max())
        others = np.delete(np.arange(g.size), shown)
        assert (g[others] >= 0).all()
        assert np.abs(slope[others]).max(initial=0) <= 1e-9 * np.abs(slope).max()


def test_memory_that_no_variant_agrees_with_is_known_where_it_is_whole():
    automaton = simulator(FEET, "rigid").automaton
    size = len(automaton.memory)
    # Each foot touches without force, as the other one holds it; the rest are impulses.
    touching = [0.0, 0.0, 1.0, 0.0] * 2 + [0.25] * (size - 8)
    assert known_values(automaton, touching) == (0.0, 0.0, 1.0, 0.0) * 2 + (math.inf,) * (size - 8)
    touching[1] = 0.5
    assert known_values(automaton, touching)[:4] == (0.0, math.inf, 1.0, 0.0)


def test_variants_are_made_once_and_when_they_are_entered(cache, monkeypatch):
    calls, enter = [], Entered._enter
    monkeypatch.setattr(Entered, "_enter", lambda *at: calls.append(at[1]) or enter(*at))
    own = Simulator(simulator(FEET, "rigid").mechanism, "rigid")
    start = {"y_A": 1e-3, "x_A_dot": 0.5}
    assert not calls
    first = own.run(start, t_end=0.01)
    count = len(calls)
    assert count == len(first.events) == 1
    again = own.run(start, t_end=0.01)
    assert len(calls) == count and again.final_state.tobytes() == first.final_state.tobytes()
    own.run(start, t_end=0.1)
    assert len(calls) > count


def test_a_variant_that_cannot_be_compiled_is_an_error_of_the_run(cache, monkeypatch):
    own = Simulator(simulator(FEET, "rigid").mechanism, "rigid")

    def fail(*_):
        raise CompileError("compiler: it is gone.")

    monkeypatch.setattr(type(own.integrator), "_variant_source", fail)
    with pytest.raises(CompileError, match="it is gone"):
        own.run({"y_A": 1e-3}, t_end=0.01)
    with pytest.raises(CompileError, match="it is gone"):
        simulate_batch(own.mechanism, "rigid", {"y_A": [1e-3, 2e-3]}, t_end=0.01)


@pytest.mark.parametrize("laws", ["rigid", "A=hertz,B=rigid"])
def test_guards_and_jets_as_orders_of_a_series_are_those_of_formulas(laws, monkeypatch):
    """Derivatives along the motion, by the series of the engine and expanded by CasADi."""
    own = simulator(FEET, laws, "taylor")
    start = {"y_A": 1e-3, "theta": 0.02, "x_A_dot": 0.5}
    # Variants are made by the run: that by series comes first.
    a = own.run(start, t_end=0.05, rtol=1e-11)
    monkeypatch.setattr(series, "_of", lambda functions, variant: variant)
    expanded = Simulator(own.mechanism, own.law, "taylor")
    vars(expanded)["integrator"] = TaylorEngine(expanded.automaton)
    b = expanded.run(start, t_end=0.05, rtol=1e-11)
    assert [(e.kind, e.mode_after) for e in a.events] == [(e.kind, e.mode_after) for e in b.events]
    assert len(a.events) > 2
    np.testing.assert_allclose(a.final_state, b.final_state, rtol=1e-9, atol=1e-11)
