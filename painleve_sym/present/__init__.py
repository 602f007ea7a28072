"""Figures and reports; the only stage that imports matplotlib."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)
