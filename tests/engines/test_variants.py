"""Variants of a mode whose local modes are data: shorter, and equal but for rounding."""

from functools import cache

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.automata.variants import MOST_VARIANTS, variants
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.motion.simulator import Simulator
from tests.scenes import FEET, TABLE, simulator


class AsTheyAre(AutomatonFunctions):
    """Functions of the modes alone."""

    @property
    def variants(self):
        return ()


@cache
def with_and_without(laws, engine):
    """Return a simulator, and the same one whose engine has no variants."""
    own = simulator(FEET, laws, engine)
    plain = Simulator(own.mechanism, own.law, engine)
    functions = AsTheyAre(plain.automaton)
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
    memory = {at.place: at.constants for at in variants(automaton)}
    assert 5 < len(functions.variants) <= MOST_VARIANTS
    for v in functions.variants:
        mode, known = functions.modes[v.mode], memory[v.place]
        x, z = (rng.uniform(0.2, 1.0, of.numel()) for of in (functions.x, functions.z))
        # Which of two branches of the same force it is in: flags are 0 or 1.
        flags = {s: int(rng.integers(2)) for s in automaton.memory if s.name.startswith("in_")}
        for i, s in enumerate(automaton.memory):
            if s in flags or s in known:
                z[i] = float(known.get(s, flags.get(s)).xreplace(flags)) if s in known else flags[s]
        at = x, z, functions.constants(rng.uniform(0.5, 1.5, len(automaton.parameters)))
        field, own = mode.field(*at), v.field(*at)
        assert float(ca.norm_inf(field - own)) < 1e-9 * float(ca.norm_inf(field))
        g, slope = (np.array(values).ravel() for values in mode.guards(*at))
        own, own_slope = (np.array(values).ravel() for values in v.guards(*at))
        shown = list(v.transitions)
        assert np.allclose(g[shown], own, rtol=1e-8, atol=1e-9 * np.abs(g).max())
        assert np.allclose(slope[shown], own_slope, rtol=1e-7, atol=1e-8 * np.abs(slope).max())
        others = np.delete(np.arange(g.size), shown)
        assert (g[others] >= 0).all()
        assert np.abs(slope[others]).max(initial=0) <= 1e-9 * np.abs(slope).max()
