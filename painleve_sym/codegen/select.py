"""Which engine runs an automaton."""

from __future__ import annotations

import warnings

from painleve_sym.codegen.compiled import CompiledEngine
from painleve_sym.codegen.modes import AutomatonFunctions
from painleve_sym.codegen.run import Engine
from painleve_sym.errors import CompilerMissing, InputError, PainleveWarning, unknown_name
from painleve_sym.hybrid.automaton import HybridAutomaton
from painleve_sym.hybrid.outline import AutomatonBuilder

ENGINES = ("auto", "compiled", "erk")


def make_engine(
    automaton: HybridAutomaton | AutomatonBuilder,
    name: str = "auto",
    functions: AutomatonFunctions | None = None,
) -> Engine:
    """Return an engine: ``compiled`` (C), ``erk`` (CasADi's), or ``auto``.

    ``auto`` is ``compiled``, or ``erk`` with a notice where there is no C compiler. What a builder
    derives is taken from the cache where it was derived and compiled before. `functions` are those
    of the automaton where they are not the plain ones.

    Raises
    ------
    InputError
        Unknown name.
    CompilerMissing
        ``compiled`` was asked for and there is none.
    """
    if name not in ENGINES:
        raise InputError(unknown_name("engine", name, ENGINES))
    if name != "erk":
        try:
            if isinstance(automaton, HybridAutomaton):
                return CompiledEngine(automaton, functions)
            return CompiledEngine.of_builder(automaton)
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
