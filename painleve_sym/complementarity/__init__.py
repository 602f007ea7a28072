"""Complementarity problems: exact enumeration, pivots, relaxations, and the frictional contact."""

from painleve_sym.complementarity.contact import (
    ContactCase,
    ContactMode,
    ContactProblem,
    ContactSolution,
)
from painleve_sym.complementarity.lcp import (
    LCP,
    LCPSolution,
    residual,
    solve_all,
)
from painleve_sym.complementarity.lemke import LemkeResult, LemkeStatus, solve_lemke
from painleve_sym.complementarity.matrix_class import is_copositive, is_p_matrix
from painleve_sym.complementarity.mpcc import (
    MPCCOptions,
    MPCCResult,
    MPCCStatus,
    MPCCSurvey,
    RelaxationStep,
    solve_mpcc,
    solve_mpcc_all,
)

__all__ = [
    "LCP",
    "ContactCase",
    "ContactMode",
    "ContactProblem",
    "ContactSolution",
    "LCPSolution",
    "LemkeResult",
    "LemkeStatus",
    "MPCCOptions",
    "MPCCResult",
    "MPCCStatus",
    "MPCCSurvey",
    "RelaxationStep",
    "is_copositive",
    "is_p_matrix",
    "residual",
    "solve_all",
    "solve_lemke",
    "solve_mpcc",
    "solve_mpcc_all",
]
