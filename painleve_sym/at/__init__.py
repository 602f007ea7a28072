"""Contact problems and impacts at states of a mechanism: W and b, closed states, cases, jumps."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)
