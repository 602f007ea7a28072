"""Complementarity problems, no mechanics: enumeration, pivots, matrix classes."""

from painleve_sym.problem.complementarity.lcp import LCP, LCPSolution, residual, solve_all
from painleve_sym.problem.complementarity.lemke import LemkeResult, LemkeStatus, solve_lemke
from painleve_sym.problem.complementarity.matrix_class import is_copositive, is_p_matrix
from painleve_sym.problem.complementarity.uniqueness import Uniqueness

__all__ = [
    "LCP",
    "LCPSolution",
    "LemkeResult",
    "LemkeStatus",
    "Uniqueness",
    "is_copositive",
    "is_p_matrix",
    "residual",
    "solve_all",
    "solve_lemke",
]
