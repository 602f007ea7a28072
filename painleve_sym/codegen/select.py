"""Which engine runs an automaton."""

from __future__ import annotations

import warnings

from painleve_sym.codegen.compiled import CompiledEngine
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

ENGINES = ("auto", "compiled", "taylor", "erk")


def make_engine(automaton: HybridAutomaton, name: str = "auto") -> Engine:
    """Return an engine: ``compiled`` (Runge–Kutta), ``taylor``, ``erk`` (CasADi's) or ``auto``.

    ``auto`` is ``compiled``, or ``erk`` with a notice where there is no C compiler. Where a mode
    has no Taylor series, ``compiled`` takes the place of ``taylor``, with a notice.

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
            return TaylorEngine(automaton)
        except NoRecurrence as error:
            warnings.warn(
                f"engine 'taylor': {error}. Engine 'compiled' (Runge–Kutta) is used instead.",
                PainleveWarning,
                stacklevel=2,
            )
            name = "compiled"
    if name != "erk":
        try:
            return CompiledEngine(automaton)
        except CompilerMissing as error:
            if name == "compiled":
                raise
            warnings.warn(
                f"{error} Until then the slower engine 'erk' is used.",
                PainleveWarning,
                stacklevel=2,
            )
    from painleve_sym.codegen.erk import ErkEngine

    return ErkEngine(automaton)
