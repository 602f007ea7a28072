"""Which engine runs an automaton."""

from __future__ import annotations

import warnings

from painleve_sym.codegen.compiled import CompiledEngine
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.codegen.run import Engine
from painleve_sym.codegen.taylor.runner import TaylorEngine
from painleve_sym.errors import (
    CompilerMissing,
    InputError,
    NoRecurrence,
    PainleveWarning,
    unknown_name,
)
from painleve_sym.hybrid.automaton import HybridAutomaton
from painleve_sym.hybrid.outline import AutomatonBuilder

ENGINES = ("auto", "compiled", "taylor", "erk")


def make_engine(
    automaton: HybridAutomaton | AutomatonBuilder,
    name: str = "auto",
    functions: AutomatonFunctions | None = None,
) -> Engine:
    """Return an engine: ``compiled`` (Runge–Kutta), ``taylor``, ``erk`` (CasADi's) or ``auto``.

    ``auto`` is ``compiled``, or ``erk`` with a notice where there is no C compiler. Where a mode
    has no Taylor series, ``compiled`` takes the place of ``taylor``, with a notice. What a builder
    derives is taken from the cache where it was derived and compiled before. `functions` are those
    of the automaton where they are not the plain ones; they have no series.

    Raises
    ------
    InputError
        Unknown name.
    CompilerMissing
        ``compiled`` or ``taylor`` was asked for and there is none.
    """
    if name not in ENGINES:
        raise InputError(unknown_name("engine", name, ENGINES))
    if name == "taylor":
        try:
            return _compiled(TaylorEngine, automaton, functions)
        except NoRecurrence as error:
            warnings.warn(
                f"engine 'taylor': {error}. Engine 'compiled' (Runge–Kutta) is used instead.",
                PainleveWarning,
                stacklevel=2,
            )
            name = "compiled"
    if name != "erk":
        try:
            return _compiled(CompiledEngine, automaton, functions)
        except CompilerMissing as error:
            if name == "compiled":
                raise
            warnings.warn(
                f"{error} Until then the slower engine 'erk' is used.",
                PainleveWarning,
                stacklevel=2,
            )
    from painleve_sym.codegen.erk import ErkEngine

    whole = automaton if isinstance(automaton, HybridAutomaton) else automaton.automaton
    return ErkEngine(whole, functions)


def _compiled(
    kind: type[CompiledEngine],
    automaton: HybridAutomaton | AutomatonBuilder,
    functions: AutomatonFunctions | None,
) -> CompiledEngine:
    if isinstance(automaton, HybridAutomaton):
        return kind(automaton, functions)
    return kind.of_builder(automaton)
