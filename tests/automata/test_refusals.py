"""Wrong automata cannot be built: every fault has its own sentence, with all others."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.automata.automaton import (
    MOST_TRANSITIONS,
    Accumulation,
    Alternative,
    Choice,
    Definition,
    HybridAutomaton,
    Mode,
    Part,
    Preparation,
    Transition,
)
from painleve_sym.automata.automaton import Test as Inequality
from painleve_sym.automata.derivation import ContactDerivation
from painleve_sym.errors import EventKind, ModelError
from painleve_sym.laws.catalogue import law
from painleve_sym.mechanics.models.rods import rod
from tests.scenes import FEET, simulator

X, Y, Z, P, C, S = sp.symbols("x y z p c s", real=True)
STRANGER = sp.Symbol("stranger", real=True)
KIND, LIMIT = EventKind.IMPACT, EventKind.SETTLE
COUNTS = st.integers(0, 3)
RESETS = st.sampled_from([{}, {X: -X}, {Z: X + P}])
GUARD, CONDITION, FIELD = X - C, Y > 0, {X: Y, Y: -C * X + Z}
TESTS = (Inequality(X + S, sp.Abs(X)),)


@st.composite
def automata(draw):
    """Draw a sound automaton: a ring of modes, so that all are reached, and more transitions."""
    count = 1 + draw(COUNTS)
    names = [f"mode_{k}" for k in range(count)]

    def target():
        return names[draw(COUNTS) % count]

    def transition(label, goal):
        first = (Choice(target(), CONDITION),) if draw(st.booleans()) else ()
        limit = Accumulation(LIMIT, target(), {Y: sp.Integer(0)}) if draw(st.booleans()) else None
        choices = (*first, Choice(goal))
        return Transition(label, KIND, GUARD, choices, draw(RESETS), on_accumulation=limit)

    modes = []
    for k, name in enumerate(names):
        more = [transition(f"more_{i}", target()) for i in range(draw(COUNTS))]
        exits = (transition("on", names[(k + 1) % count]), *more)
        modes.append(Mode(name, FIELD, exits, {"place": X, "sum": S}, TESTS))
    return HybridAutomaton(
        "drawn",
        (X, Y),
        (Z,),
        (P,),
        {C: P**2},
        tuple(modes),
        (Choice(names[0]),),
        terms=(Definition(S, X + Y),),
        parts=(Part("part", (Z,), ("on",), (Alternative(X > 0, {Z: sp.Integer(1)}),)),),
        preparation=Preparation((X,), sp.Symbol("F", real=True), {Y: P * X}, (X,), {X: P, Y: P}),
    )


def with_mode(automaton, k, **changes):
    modes = list(automaton.modes)
    modes[k] = replace(modes[k], **changes)
    return {"modes": tuple(modes)}


def with_transition(automaton, k, **changes):
    first, *rest = automaton.modes[k].transitions
    return with_mode(automaton, k, transitions=(replace(first, **changes), *rest))


def first(automaton, k):
    return automaton.modes[k].transitions[0]


def declared_twice(a, k):
    return {"modes": (*a.modes, a.modes[k])}, f"mode {a.modes[k].name!r} is declared twice."


def label_twice(a, k):
    exits = a.modes[k].transitions
    return with_mode(a, k, transitions=(*exits, exits[0])), "transition 'on' is declared twice."


def no_way_in(a, k):
    lonely = replace(a.modes[k], name="lonely")
    return {"modes": (*a.modes, lonely)}, "mode 'lonely' can never be reached."


def target_unknown(a, k):
    choices = (Choice("nowhere", X > 0), *first(a, k).choices)
    return with_transition(a, k, choices=choices), "unknown mode 'nowhere'"


def start_unknown(a, _):
    return {"starts": (Choice("nowhere", X > 0), *a.starts)}, "start: unknown mode 'nowhere'"


def limit_unknown(a, k):
    limit = Accumulation(LIMIT, "nowhere", {})
    return with_transition(a, k, on_accumulation=limit), "unknown mode 'nowhere'"


def no_last_choice(a, k):
    *rest, last = first(a, k).choices
    choices = (*rest, replace(last, condition=X > 0))
    return with_transition(a, k, choices=choices), "the last choice must admit every state."


def no_choice(a, k):
    # Its target may then be out of reach, too.
    return with_transition(a, k, choices=()), "the last choice must admit every state."


def number_for_a_condition(a, k):
    choices = (Choice(a.modes[k].name, X), *first(a, k).choices)
    return with_transition(a, k, choices=choices), "got the condition x, need a relation"


def departure_unknown(a, k):
    choices = (Choice(a.modes[k].name, X > 0, ("gone",)), *first(a, k).choices)
    return with_transition(a, k, choices=choices), "unknown transition 'gone'"


def follows_an_immediate_one(a, k):
    now = Transition("now", KIND, None, (Choice(a.modes[k].name),))
    exits = (now, *a.modes[k].transitions)
    return with_mode(a, k, transitions=exits), "after an immediate transition no other can happen."


def too_many_transitions(a, k):
    extra = [replace(first(a, k), label=f"extra_{i}") for i in range(MOST_TRANSITIONS)]
    exits = (*a.modes[k].transitions, *extra)
    return with_mode(a, k, transitions=exits), f"need at most {MOST_TRANSITIONS}."


def strikes_without_impacts(a, k):
    return with_transition(a, k, strikes=True), "a transition strikes, and no impacts are declared."


def other_outputs(a, k):
    # The first mode's are those that the others have to have.
    mode = replace(a.modes[k], name="other", outputs={"other": X})
    go = replace(first(a, k), label="there", choices=(Choice("other"),))
    modes = list(a.modes)
    modes[k] = replace(modes[k], transitions=(*modes[k].transitions, go))
    return {"modes": (*modes, mode)}, "its outputs differ from those of the first mode."


def rate_of_no_state(a, k):
    field = {**a.modes[k].field, Z: X}
    return with_mode(a, k, field=field), "z has a rate but is not a state."


def reset_of_no_state(a, k):
    return with_transition(a, k, reset={P: X}), "reset of p, which is not a state."


def definition_too_early(a, _):
    late = sp.Symbol("late", real=True)
    return {"definitions": {C: P**2 + 0 * late + late, late: P}}, "late is not declared before it."


STRUCTURE = (
    declared_twice,
    label_twice,
    no_way_in,
    target_unknown,
    start_unknown,
    limit_unknown,
    no_last_choice,
    no_choice,
    number_for_a_condition,
    departure_unknown,
    follows_an_immediate_one,
    too_many_transitions,
    strikes_without_impacts,
    other_outputs,
    rate_of_no_state,
    reset_of_no_state,
    definition_too_early,
)


def in_part(a, **changes):
    (part,) = a.parts
    (alternative,) = part.alternatives
    return {"parts": (replace(part, alternatives=(replace(alternative, **changes),)),)}


def prepared(a, **changes):
    return {"preparation": replace(a.preparation, **changes)}


PLACES = {
    "rate": lambda a, k: with_mode(a, k, field={X: STRANGER}),
    "output": lambda a, k: with_mode(a, k, outputs={"place": STRANGER, "sum": S}),
    "test": lambda a, k: with_mode(a, k, tests=(Inequality(STRANGER, X),)),
    "scale of a test": lambda a, k: with_mode(a, k, tests=(Inequality(X, STRANGER),)),
    "guard": lambda a, k: with_transition(a, k, guard=STRANGER),
    "reset": lambda a, k: with_transition(a, k, reset={X: STRANGER}),
    "condition": lambda a, k: with_transition(
        a, k, choices=(Choice(a.modes[k].name, STRANGER > 0), *first(a, k).choices)
    ),
    "limit": lambda a, k: with_transition(
        a, k, on_accumulation=Accumulation(LIMIT, a.modes[k].name, {X: STRANGER})
    ),
    "start": lambda a, k: {"starts": (Choice(a.modes[k].name, STRANGER > 0), *a.starts)},
    "condition of an alternative": lambda a, _: in_part(a, condition=STRANGER > 0),
    "memory of an alternative": lambda a, _: in_part(a, memory={Z: STRANGER}),
    "what an alternative sets": lambda a, _: in_part(a, memory={STRANGER: X}),
    "definition": lambda a, _: {"definitions": {C: STRANGER}},
    "term": lambda a, _: {"terms": (Definition(S, STRANGER),)},
    "prepared state": lambda a, _: prepared(a, states={Y: STRANGER}),
    "admitted start": lambda a, _: prepared(a, admits=(STRANGER,)),
    "scale of a state": lambda a, _: prepared(a, scales={X: STRANGER}),
    "term of the preparation": lambda a, _: prepared(a, terms=(Definition(S, STRANGER),)),
}
"""Where an undeclared symbol may stand."""


def faults(automaton, changes):
    with pytest.raises(ModelError) as caught:
        replace(automaton, **changes)
    return caught.value.faults


@settings(max_examples=50)
@given(automaton=automata())
def test_sound_automata_are_accepted_and_drawn_whole(automaton):
    names = {m.name for m in automaton.modes}
    assert automaton.reachable() == names
    assert all(name in automaton.mermaid() for name in names)


@pytest.mark.parametrize("fault", STRUCTURE, ids=lambda f: f.__name__)
@settings(max_examples=10)
@given(automaton=automata(), place=st.integers(0, 3))
def test_each_fault_is_refused_by_its_sentence(fault, automaton, place):
    changes, sentence = fault(automaton, place % len(automaton.modes))
    refused = faults(automaton, changes)
    assert sum(sentence in f for f in refused) == 1
    # Nothing else is wrong, but for modes that only the lost choice led to.
    others = [f for f in refused if sentence not in f]
    assert all("can never be reached" in f for f in others)
    assert not others or fault is no_choice


@pytest.mark.parametrize("place", PLACES)
@settings(max_examples=8)
@given(automaton=automata(), mode=st.integers(0, 3))
def test_a_symbol_that_nobody_declares_is_refused_wherever_it_stands(place, automaton, mode):
    refused = faults(automaton, PLACES[place](automaton, mode % len(automaton.modes)))
    assert len(refused) == 1 and "stranger" in refused[0]


PLACE_NAMED = {"definition": "definition of c", "prepared state": "preparation"}


@settings(max_examples=50)
@given(automaton=automata(), data=st.data())
def test_all_faults_are_collected(automaton, data):
    """One of a mode, and others of definitions, terms and start."""
    here = data.draw(st.sampled_from([f for f in STRUCTURE if f is not definition_too_early]))
    k = data.draw(st.integers(0, len(automaton.modes) - 1))
    changes, sentence = here(automaton, k)
    expected = [sentence]
    for name in ("definition", "prepared state"):
        if data.draw(st.booleans()):
            changes |= PLACES[name](automaton, k)
            expected.append(
                {"definition": "definition of c", "prepared state": "preparation"}[name]
            )
    refused = faults(automaton, changes)
    assert all(any(part in f for f in refused) for part in expected)


@pytest.mark.parametrize("builder", ["one contact", "several contacts"])
def test_automata_of_contacts_miss_every_symbol_that_is_taken_from_them(builder):
    if builder == "one contact":
        automaton = ContactDerivation(rod(), (law("bilinear-hertz"),)).automaton
    else:
        automaton = simulator(FEET, "A=rigid,B=linear").automaton
    for kind in ("states", "parameters", "memory"):
        symbols = getattr(automaton, kind)
        for symbol in symbols:
            less = tuple(s for s in symbols if s is not symbol)
            refused = faults(automaton, {kind: less})
            assert any(str(symbol) in f for f in refused), symbol


@pytest.mark.parametrize("name", ["hertz", "bilinear-hertz"])
def test_automata_of_contacts_miss_every_mode_that_is_taken_from_them(name):
    automaton = ContactDerivation(rod(), (law(name),)).automaton
    for gone in automaton.modes:
        modes = tuple(m for m in automaton.modes if m is not gone)
        assert any(repr(gone.name) in f for f in faults(automaton, {"modes": modes})), gone.name
