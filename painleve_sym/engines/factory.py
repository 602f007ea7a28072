"""Which engine runs an automaton."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from painleve_sym.automata.signature import AutomatonBuilder
from painleve_sym.choices import EngineLike, EngineName, chosen
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.protocol import Engine
from painleve_sym.engines.taylor.runner import TaylorEngine
from painleve_sym.errors import CompilerMissing, InputError, NoRecurrence, PainleveWarning

if TYPE_CHECKING:
    from painleve_sym.automata.automaton import HybridAutomaton
    from painleve_sym.codegen.modes import AutomatonFunctions

SOURCES = {
    EngineName.TAYLOR: "Jorba & Zou (2005)",
    EngineName.COMPILED: "Prince & Dormand (1981); Hairer, Nørsett & Wanner (1993)",
    EngineName.ERK: "Prince & Dormand (1981); Hairer, Nørsett & Wanner (1993)",
}
"""Works on the integrator of each engine."""


def make_engine(
    automaton: HybridAutomaton | AutomatonBuilder,
    name: EngineLike = EngineName.AUTO,
    functions: AutomatonFunctions | None = None,
    key: Callable[[str], str | None] = lambda _: None,
) -> Engine:
    """Return an engine: ``taylor``, ``compiled`` (Runge–Kutta), ``erk`` (CasADi's) or ``auto``.

    ``auto`` is ``taylor`` where every mode has a Taylor series, else ``compiled``; without a C
    compiler it is ``erk``, with a notice, for one contact: several contacts need a compiler. Where
    a mode has no Taylor series, ``compiled`` takes the place of ``taylor``, with a notice where
    that was asked for. What a builder derives is taken from the cache where it was derived and
    compiled before. `functions` are those of the automaton where they are not the plain ones, and
    `key` gives the name of their entry in the cache for an engine.

    Raises
    ------
    InputError
        Unknown name; several contacts, and ``erk`` or no C compiler.
    CompilerMissing
        ``compiled`` or ``taylor`` was asked for and there is none.
    """
    name = chosen(EngineName, name, "engine")

    def given() -> Any:
        # A builder has the automaton as its attribute; what an automaton is may not be imported.
        return getattr(automaton, "automaton", automaton)

    try:
        if name in (EngineName.AUTO, EngineName.TAYLOR):
            try:
                return _compiled(TaylorEngine, automaton, functions, key)
            except NoRecurrence as error:
                if name is EngineName.TAYLOR:
                    _notice(f"engine 'taylor': {error}. Engine 'compiled' (Runge–Kutta) is used.")
        if name is not EngineName.ERK:
            return _compiled(CompiledEngine, automaton, functions, key)
    except CompilerMissing as error:
        if name is not EngineName.AUTO:
            raise
        if given().parts:
            need = "motions of several contacts need compiled code"
            raise InputError(f"{need}: {error}") from error
        _notice(f"{error} Until then the slower engine 'erk' is used.")
    from painleve_sym.engines.erk import ErkEngine

    return ErkEngine(given(), functions)


def _notice(message: str) -> None:
    warnings.warn(message, PainleveWarning, stacklevel=3)


def _compiled(
    kind: type[CompiledEngine],
    automaton: HybridAutomaton | AutomatonBuilder,
    functions: AutomatonFunctions | None,
    key: Callable[[str], str | None],
) -> CompiledEngine:
    builder: Any = automaton
    return (
        kind.of_builder(builder)
        if hasattr(type(builder), "automaton")
        else kind(builder, functions, key(kind.name))
    )
