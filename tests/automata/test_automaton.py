"""Validation and drawing of automata; the compliant contact builds a sound one."""

from __future__ import annotations

import pytest
import sympy as sp

from painleve_sym.automata.automaton import (
    Choice,
    HybridAutomaton,
    Mode,
    Transition,
    all_positive,
    is_zero,
    positive,
)
from painleve_sym.automata.derivation import ContactDerivation
from painleve_sym.errors import ModelError
from painleve_sym.laws.catalogue import COMPLIANT_LAWS, law
from painleve_sym.mechanics.models.rods import rod

X, Y = sp.Symbol("x", real=True), sp.Symbol("y", real=True)


def make(modes, **more):
    defaults = {"states": (X,), "memory": (), "parameters": (), "definitions": {}}
    return HybridAutomaton(name="test", modes=modes, starts=(Choice("a"),), **(defaults | more))


def mode(name, *transitions, field=None, outputs=None):
    return Mode(name, field or {X: sp.Integer(1)}, transitions, outputs or {"x": X})


def test_automaton_collects_all_faults():
    jump = Transition("go", "go", X + Y, (Choice("b"), Choice("nowhere")), {Y: X})
    with pytest.raises(ModelError) as caught:
        make((mode("a", jump, jump), mode("b", outputs={"other": X}), mode("far")))
    text = str(caught.value)
    for part in ("unknown mode 'nowhere'", "'go' is declared twice", "reset of y", "symbol 'y'"):
        assert part in text
    assert "'far' can never be reached" in text
    assert "outputs differ" in text
    assert len(caught.value.faults) >= 6


def test_automaton_needs_an_unconditional_last_choice():
    t = Transition("go", "go", X, (Choice("a", X > 0),))
    with pytest.raises(ModelError, match="last choice must admit every state"):
        make((mode("a", t),))


def test_automaton_refuses_unknown_departures():
    t = Transition("go", "go", X, (Choice("a", departs=("gone",)),))
    with pytest.raises(ModelError, match="unknown transition 'gone'"):
        make((mode("a", t),))


def test_automaton_refuses_a_condition_that_is_a_number():
    t = Transition("go", "go", X, (Choice("a", X), Choice("a")))
    with pytest.raises(ModelError, match="got the condition x, need a relation"):
        make((mode("a", t),))


def test_automaton_refuses_what_follows_an_immediate_transition():
    now, later = Transition("now", "go", None, (Choice("a"),)), Transition("go", "go", X, ())
    with pytest.raises(ModelError, match="after an immediate transition no other can happen"):
        make((mode("a", now, later),))


def test_automaton_has_as_many_transitions_as_a_mode_has_bits():
    exits = [Transition(f"exit_{i}", "go", X - i, (Choice("a"),)) for i in range(65)]
    make((mode("a", *exits[:64]),))
    with pytest.raises(ModelError, match="got 65 transitions, need at most 64"):
        make((mode("a", *exits),))


def test_conditions_stay_as_they_are():
    apart = all_positive(X, X - 1, Y)
    assert set(apart.args) == {positive(X), positive(X - 1), positive(Y)}
    assert is_zero(X).xreplace({X: sp.Integer(0)}) == sp.true
    assert all_positive(X) == positive(X)


def test_automaton_definitions_are_ordered():
    c, d = sp.symbols("c d", real=True)
    with pytest.raises(ModelError, match="d is not declared before it"):
        make((mode("a"),), definitions={c: d, d: sp.Integer(1)})


@pytest.mark.parametrize("name", sorted(COMPLIANT_LAWS))
def test_softened_automaton_is_sound_for_every_law(name):
    automaton = ContactDerivation(rod(), (law(name),)).automaton
    assert automaton.reachable() == {m.name for m in automaton.modes}
    for m in automaton.modes:
        assert set(m.field) <= set(automaton.states)
        if m.name.startswith("stick"):
            assert m.field[sp.Symbol("x_A_dot", real=True)] == 0
        if m.name.startswith("flight"):
            assert m.outputs["normal_force"] == 0


def test_diagrams_name_every_mode_and_kind():
    automaton = ContactDerivation(rod(), (law("bilinear-hertz"),)).automaton
    for text in (automaton.mermaid(), automaton.graphviz()):
        for m in automaton.modes:
            assert m.name in text
        for kind in automaton.kinds:
            assert kind in text
    assert automaton.mermaid().startswith("stateDiagram-v2")
    assert automaton.graphviz().startswith("digraph")
