"""Hybrid automata: what can happen, with no numbers in it."""
