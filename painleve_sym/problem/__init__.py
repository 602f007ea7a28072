"""Rigid contact problems by their numbers: W, b and friction; every solution, and their case.

No SymPy and no CasADi: `painleve_sym.at` states these problems at states of a mechanism.

Examples
--------
>>> from painleve_sym.problem import ContactProblem, Disc
>>> W = [[4.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 2.0]]
>>> problem = ContactProblem(W, [-9.8, 0.0, 6.0], [Disc(0.5)], [(0.0, 0.0)])
>>> problem.case.value, [solution.mode.value for solution in problem.solutions()]
('slip', ['slip'])
"""

from painleve_sym.doors import door

__all__, __getattr__, __dir__ = door(__name__)
