"""From automata to compiled code: the only place that knows both SymPy and CasADi."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)
