"""The equations of one mode as functions for other programs: CasADi's, or Python's of SymPy."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from painleve_sym.choices import chosen
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.escape import c_name

if TYPE_CHECKING:
    from painleve_sym.automata.automaton import HybridAutomaton, Mode


class Modules(StrEnum):
    """Library whose functions a Python function of SymPy calls."""

    NUMPY = "numpy"
    MATH = "math"
    JAX = "jax"
    MPMATH = "mpmath"


@dataclass(frozen=True, eq=False, repr=False)
class ModeEquations:
    """The equations of one mode of a hybrid automaton, as functions of (x, z, p).

    x are the states, z the memory, which is constant within a mode and 0 at the start of a run, and
    p the parameters; SI units and radians. CasADi's functions have these names for their inputs.
    Those of `lambdify` take and return sequences.

    Attributes
    ----------
    mode : str
    states, memory, parameters : tuple of str
        Names in the order of x, z and p.
    field : function
        ẋ, shape (nx,).
    guards : function
        The guards of `guard_labels`, one value each. A transition happens where its guard crosses
        from + to −.
    guard_labels : tuple of str
        Labels of the transitions that have a guard; the others happen on entry.
    resets : dict of str to function
        By label: x⁺ and z⁺.
    choices : dict of str to function
        By label: one condition for each target, true (1) where it holds.
    targets : dict of str to tuple of str
        By label: the modes to choose from. The first whose condition holds is entered; a transition
        without a target ends a run.
    outputs : function
        Forces, energies and what else is derived from a state: the values of `output_names`.
    output_names : tuple of str

    Examples
    --------
    >>> import painleve_sym as ps
    >>> simulator = ps.Simulator("rod", "bilinear-hertz")
    >>> slip = simulator.casadi("slip_neg/compression")
    >>> slip.field.name_in(), slip.field.name_out()
    (['x', 'z', 'p'], ['x_dot'])
    >>> start = simulator.begin({"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0})
    >>> slip.states[1], slip.field(start.state, 0, start.parameters)[1]
    ('y_A', DM(0))
    """

    mode: str
    states: tuple[str, ...]
    memory: tuple[str, ...]
    parameters: tuple[str, ...]
    field: Any
    guards: Any
    guard_labels: tuple[str, ...]
    resets: Mapping[str, Any]
    choices: Mapping[str, Any]
    targets: Mapping[str, tuple[str, ...]]
    outputs: Any
    output_names: tuple[str, ...]

    def __repr__(self) -> str:
        """Return the mode, its states and the labels of its guards in one line."""
        states, guards = ", ".join(self.states), ", ".join(self.guard_labels)
        return f"ModeEquations of {self.mode!r}: states {states}; guards {guards}"


def casadi_equations(automaton: HybridAutomaton, mode: str) -> ModeEquations:
    """Return the equations of a mode as CasADi functions; InputError for an unknown mode."""
    import casadi as ca

    from painleve_sym.codegen.modes import AutomatonFunctions

    own, functions = _mode(automaton, mode), AutomatonFunctions(automaton)
    of = functions.of_mode(mode)
    sizes = len(automaton.states), len(automaton.memory), len(automaton.parameters)
    x, z, p = (ca.SX.sym(name, size) for name, size in zip("xzp", sizes, strict=True))
    c = functions.constants(p)

    def named(name: str, results: list[Any], outputs: Sequence[str]) -> ca.Function:
        dense = [ca.densify(r) for r in results]
        return ca.Function(name, [x, z, p], ca.cse(dense), ["x", "z", "p"], list(outputs))

    resets, choices = {}, {}
    for transition, event in zip(own.transitions, of.events, strict=True):
        *after, conditions = event(x, z, c)
        label = c_name(transition.label)
        resets[transition.label] = named(f"reset_{label}", after, ("x_plus", "z_plus"))
        choices[transition.label] = named(f"choices_{label}", [conditions], ("holds",))
    guards, _ = of.guards(x, z, c)
    return _equations(
        automaton,
        own,
        field=named("field", [of.field(x, z, c)], ("x_dot",)),
        guards=named("guards", [guards], ("guards",)),
        resets=resets,
        choices=choices,
        outputs=named("outputs", [of.outputs(x, z, c)], ("outputs",)),
    )


def lambdified_equations(
    automaton: HybridAutomaton, mode: str, modules: Modules | str = Modules.NUMPY
) -> ModeEquations:
    """Return the equations of a mode as Python functions that SymPy writes.

    Raises
    ------
    InputError
        An unknown mode or library; linear systems that are solved where the functions are called.
    """
    own = _mode(automaton, mode)
    library = chosen(Modules, modules, "library", "lambdify")
    kept = {s: s for s in (*automaton.states, *automaton.memory)}

    def function(values: Sequence[Any]) -> Callable[..., Any]:
        return _lambdified(automaton, values, library)

    resets, choices = {}, {}
    for transition in own.transitions:
        after = kept | dict(transition.reset)
        parts = [[after[s] for s in group] for group in (automaton.states, automaton.memory)]
        resets[transition.label] = function(parts)
        conditions = [True if c.condition is None else c.condition for c in transition.choices]
        choices[transition.label] = function(conditions)
    return _equations(
        automaton,
        own,
        field=function([own.field.get(s, 0) for s in automaton.states]),
        guards=function([t.guard for t in own.transitions if t.guard is not None]),
        resets=resets,
        choices=choices,
        outputs=function(list(own.outputs.values())),
    )


def _equations(automaton: HybridAutomaton, mode: Mode, **functions: Any) -> ModeEquations:
    """Return functions with the names of their arguments and results."""
    return ModeEquations(
        mode=mode.name,
        states=tuple(map(str, automaton.states)),
        memory=tuple(map(str, automaton.memory)),
        parameters=tuple(map(str, automaton.parameters)),
        guard_labels=tuple(t.label for t in mode.transitions if t.guard is not None),
        targets={t.label: tuple(c.target for c in t.choices) for t in mode.transitions},
        output_names=automaton.output_names,
        **functions,
    )


def _mode(automaton: HybridAutomaton, name: str) -> Mode:
    names = [m.name for m in automaton.modes]
    refuse_unknown("mode", name, names, f"automaton {automaton.name!r}")
    return automaton.mode(name)


def _lambdified(automaton: HybridAutomaton, values: Any, library: Modules) -> Callable[..., Any]:
    """Return a function of x, z and p; definitions and terms that occur are its first lines."""
    from painleve_sym.automata.automaton import Definition
    from painleve_sym.codegen.bridge import python_function

    known = [Definition(s, e) for s, e in automaton.definitions.items()] + list(automaton.terms)
    wanted = {s for v in _flat(values) for s in getattr(v, "free_symbols", ())}
    used: list[tuple[Any, Any]] = []
    for term in reversed(known):
        if wanted.isdisjoint(term.symbols):
            continue
        if not isinstance(term, Definition):
            raise InputError(
                f"lambdify: automaton {automaton.name!r} solves linear systems of several contacts "
                "at each state, which no formula is. Fix: use casadi."
            )
        used.insert(0, (term.symbol, term.expression))
        wanted |= term.needs

    arguments = (automaton.states, automaton.memory, automaton.parameters)
    return python_function(arguments, values, used, library)


def _flat(values: Any) -> list[Any]:
    """Return the entries of lists within a list."""
    return [e for v in values for e in (_flat(v) if isinstance(v, list) else [v])]
