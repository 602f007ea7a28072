"""Hybrid automata of contacts with their laws: modes, transitions, choices; all symbolic."""
