"""The motion as C code that stands alone, and as a functional mock-up unit."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)
