"""SymPy only: a mechanism and its contacts become closed forms."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)
