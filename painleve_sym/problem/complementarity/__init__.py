"""Complementarity problems, no mechanics: enumeration, pivots, relaxations, matrix classes."""

from painleve_sym.problem.complementarity.lcp import LCP, LCPSolution, residual, solve_all
from painleve_sym.problem.complementarity.lemke import LemkeResult, LemkeStatus, solve_lemke
from painleve_sym.problem.complementarity.matrix_class import is_copositive, is_p_matrix
from painleve_sym.problem.complementarity.mpcc import (
    MPCCResult,
    MPCCStatus,
    MPCCSurvey,
    solve_mpcc,
    solve_mpcc_all,
)
from painleve_sym.problem.complementarity.uniqueness import Uniqueness

__all__ = [
    "LCP",
    "LCPSolution",
    "LemkeResult",
    "LemkeStatus",
    "MPCCResult",
    "MPCCStatus",
    "MPCCSurvey",
    "Uniqueness",
    "is_copositive",
    "is_p_matrix",
    "residual",
    "solve_all",
    "solve_lemke",
    "solve_mpcc",
    "solve_mpcc_all",
]
