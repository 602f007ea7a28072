"""Integrators of automata: the event loop in C and its steppers."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)
