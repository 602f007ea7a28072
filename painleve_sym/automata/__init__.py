"""Hybrid automata of contacts with their laws: modes, transitions, choices; all symbolic."""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)
