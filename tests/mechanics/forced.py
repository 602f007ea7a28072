"""A mechanism under given contact forces as an automaton, to evaluate it in generated code."""

from __future__ import annotations

import sympy as sp

from painleve_sym.automata.automaton import Choice, HybridAutomaton, Mode, Transition
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.mechanism import Mechanism


def forces(mechanism: Mechanism) -> list[tuple[sp.Symbol, sp.Symbol]]:
    """Return one pair of symbols (F_n, F_t) per contact."""
    n = range(len(mechanism.contacts))
    return [(sp.Symbol(f"F_n{i}", real=True), sp.Symbol(f"F_t{i}", real=True)) for i in n]


def accelerations(mechanism: Mechanism) -> list[sp.Expr]:
    """Return q̈ under the forces of all contacts."""
    free = mechanism.system.free_acceleration
    total = free
    for c, (f_n, f_t) in zip(mechanism.all_coefficients, forces(mechanism), strict=True):
        total = total + (c.accelerations - free).xreplace({F_N: f_n, F_T: f_t})
    return list(total)


def directions(mechanism: Mechanism) -> list[sp.Symbol]:
    """Return the symbols of a direction in the space of states."""
    states = (*mechanism.system.q, *mechanism.system.q_dot)
    return [sp.Symbol(f"d_{s}", real=True) for s in states]


def forced_automaton(mechanism: Mechanism) -> HybridAutomaton:
    """Return two modes: "motion" has the field q̈; the guards of "line" are q̈ on a line.

    The field of "line" is a constant direction, so the Lie derivatives of its guards are the
    directional derivatives of q̈.
    """
    system = mechanism.system
    states = (*system.q, *system.q_dot)
    rates = accelerations(mechanism)
    to_line, to_motion = (Choice("line"),), (Choice("motion"),)
    guards = tuple(Transition(f"row_{i}", "row", rate, to_motion) for i, rate in enumerate(rates))
    field = dict(zip(system.q, system.q_dot, strict=True))
    field |= dict(zip(system.q_dot, rates, strict=True))
    line = dict(zip(states, directions(mechanism), strict=True))
    pushes = [f for pair in forces(mechanism) for f in pair]
    outputs = {"kinetic_energy": system.kinetic_energy}
    return HybridAutomaton(
        name=f"{mechanism.name} under given forces",
        states=states,
        memory=(),
        parameters=(*(p.symbol for p in system.parameters), *pushes, *directions(mechanism)),
        definitions={},
        modes=(
            Mode("motion", field, (Transition("go", "go", system.q[0], to_line),), outputs),
            Mode("line", line, guards, outputs),
        ),
        starts=(Choice("motion"),),
    )
