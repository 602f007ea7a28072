"""Integrators of automata: the event loop in C and its steppers."""
