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

from painleve_sym.problem.coefficients import NormalCoefficients, Sector
from painleve_sym.problem.contact_problem import ContactProblem
from painleve_sym.problem.friction_set import Brake, Disc, FrictionSet, Interval
from painleve_sym.problem.modes import ContactMode
from painleve_sym.problem.one_contact import contact
from painleve_sym.problem.solution import ContactCase, ContactSolution

__all__ = [
    "Brake",
    "ContactCase",
    "ContactMode",
    "ContactProblem",
    "ContactSolution",
    "Disc",
    "FrictionSet",
    "Interval",
    "NormalCoefficients",
    "Sector",
    "contact",
]
