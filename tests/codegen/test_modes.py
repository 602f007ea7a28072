"""Functions of a mode: guards with their derivatives along the motion, by hand."""

from __future__ import annotations

import numpy as np
import sympy as sp

from painleve_sym.automata.automaton import Choice, HybridAutomaton, Mode, Transition
from painleve_sym.codegen.modes import AutomatonFunctions

X, V = sp.symbols("x v", real=True)


def test_jets_are_the_lie_derivatives_of_the_guards():
    turn = Transition("turn", "turn", X**2 * V, (Choice("swing"),))
    swing = Mode("swing", {X: V, V: -4 * X}, (turn,), {"x": X})
    automaton = HybridAutomaton("swing", (X, V), (), (), {}, (swing,), (Choice("swing"),))
    functions = AutomatonFunctions(automaton).modes[0]
    x, v = 0.7, -1.3
    # With x' = v and v' = -4 x: g = x² v, g' = 2 x v² - 4 x³, g'' = 2 v³ - 28 x² v.
    g, first = x**2 * v, 2 * x * v**2 - 4 * x**3
    second = 2 * v**3 - 28 * x**2 * v
    *jets, rates = functions.jets([x, v], [], [])
    assert np.allclose([float(value) for value in jets], [g, first, second], rtol=1e-14)
    assert np.allclose(rates.full().ravel(), [v, -4 * x], rtol=1e-14)
    assert np.allclose([float(v) for v in functions.guards([x, v], [], [])], [g, first], rtol=1e-14)
