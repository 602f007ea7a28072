"""Rigid contact problems by their numbers: W, b and friction; every solution, and their case.

No SymPy and no CasADi: `painleve_sym.contacts` states these problems at states of a mechanism.
"""
