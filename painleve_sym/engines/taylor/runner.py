"""The Taylor engine: the compiled event loop over series instead of Runge–Kutta steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.protocol import Place, Places
from painleve_sym.engines.taylor import ORDER

if TYPE_CHECKING:
    from painleve_sym.codegen.modes import AutomatonFunctions

MOST_LANES = 8
"""Motions of a batch side by side, or as many as a vector register of the processor holds."""


class TaylorEngine(CompiledEngine):
    """Taylor series of adaptive order and step, events at the zeros of the guards' own series.

    Raises
    ------
    NoRecurrence
        A mode uses an operation that has no recurrence, such as `max` of two states.
    CompilerMissing, CompileError
    """

    name = "taylor"
    dense_rows = ORDER + 1
    lanes = MOST_LANES

    @classmethod
    def _alone(cls, text: str) -> str:
        # Lanes are compiled when a batch first asks for them: they cost the compiler as much again.
        from painleve_sym.codegen.c_functions import for_single_motions

        return f"#define PS_LANES 1\n{for_single_motions(text)}"

    @staticmethod
    def _source(functions: AutomatonFunctions, given: Places = ()) -> str:
        from painleve_sym.engines.taylor.source import source

        return source(functions, given)

    @staticmethod
    def _variant_source(functions: AutomatonFunctions, at: Place, file: str) -> str:
        from painleve_sym.engines.taylor.source import variant_source

        return variant_source(functions, at, file)
